"""Studies of every kind that a structure has: their texts, their faults, and what they write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
import pytest
import xarray
from tests.studies.texts import faults_of

import percuss as pc
from percuss.errors import ParameterError
from percuss.io import load_netcdf
from percuss.io.study_text import response_text
from percuss.studies import Certify, parse_study, run_study
from percuss.studies.kinds.response import Response
from percuss.studies.link import link_of
from percuss.studies.reading import known_keys
from percuss.studies.study import kind_named, kind_names

MODEL = """\
[structure]
chain = {masses = [1, 1], springs = [1, 1, 0], dashpots = "0.05"}
[[structure.stops]]
type = "soft"
at = "0.5"
side = "above"
stiffness = 8
damping = "0.1"
on = 1
[[loads]]
on = 0
[[loads.harmonics]]
amplitude = "0.3"
omega = "0.9"
"""
KINDS = {
    "motion": "[start]\nv0 = [0, 1]\n[run]\nperiods = 10\n[draw]\non = [1, [1, -1]]\n",
    "orbit": "[orbit]\nx0 = [0, 0]\nv0 = [0, 0]\n",
    "orbits": "[orbits]\nmax_impacts = 1\nmax_periods = 1\n[draw]\non = [1]\n",
    "branch": '[over]\n"loads.0.omega" = ["0.7", "1.2"]\n[branch]\nmax_points = 3\n',
    "curve": '[over]\n"loads.0.omega" = ["0.4", "1.2"]\n"loads.0.amplitude" = ["0.1", 1]\n',
    "response": (
        '[over]\n"loads.0.omega" = ["0.7", "1.2"]\n'
        "[response]\non = [1, -1]\nmax_impacts = 1\nmax_periods = 1\nn_seeds = 1\n"
    ),
    "sweep": (
        '[over]\n"start.x0.1" = [0, "0.1"]\n'
        '[sweep]\nmeasure = ["peak_displacement", "period"]\non = [1, -1]\n'
        "transient = 20\nperiods = 8\n"
    ),
    "diagram": (
        '[over]\n"structure.stops.0.at" = ["0.4", "0.5"]\n'
        '[diagram]\non = 1\ntransient = 10\npoints = 8\nstarts = [[[0, 0], ["0.1", 0]]]\n'
    ),
    "basins": (
        '[over]\n"start.x0.0" = [0, "0.1"]\n"start.v0.1" = [0, "0.1"]\n[basins]\nperiods = 40\n'
    ),
    "lyapunov": "[lyapunov]\ntransient = 4\nperiods = 64\n",
}


def text_of(kind: str, more: str = "") -> str:
    return f'[study]\nkind = "{kind}"\n{MODEL}{KINDS[kind]}{more}'


def test_the_kinds_here_are_all_kinds() -> None:
    # Designs and fits are tried with their own searches and records, in test_designs and test_fits.
    assert [*KINDS, "design", "fit"] == kind_names()


@pytest.mark.parametrize("kind", KINDS)
def test_a_study_of_a_structure_is_read_back_equal_from_its_text(kind: str) -> None:
    study = parse_study(text_of(kind))

    again = parse_study(study.text())
    assert again.question == study.question
    assert again.text() == study.text()


@pytest.mark.parametrize(
    ("kind", "old", "new", "told"),
    [
        ("motion", "[1, -1]]", "[0, 0]]", "draw.on.1 = [0, 0]: a direction of zeros; what acts"),
        ("motion", "[0, 1]", "[0]", "start.v0 = [0]: 1 number for 2 coordinates"),
        ("motion", "periods = 10", "periods = 0", "run.periods = 0: not positive"),
        ("orbit", "v0 = [0, 0]\n", "", "orbit.v0: missing; a guess is a state, x0 and v0"),
        ("orbit", "v0 = [0, 0]", "v0 = [0]", "orbit.v0 = [0]: 1 number for 2 coordinates"),
        ("orbit", "[orbit]", "[orbit]\nimpacts = 1", "orbit.impacts: unknown key; known here: "),
        ("orbits", "max_impacts", "formal = true\nmax_impacts", "orbits.formal: unknown key; known "),
        ("orbits", "on = [1]", "on = [2]", "draw.on.0 = 2: no such coordinate; the coordinates are"),
        ("branch", "loads.0.omega", "loads.0.omgea", "over.loads.0.omgea: no such parameter"),
        ("branch", "[branch]", '[draw]\nquantity = "impact_velocity"\n[branch]',
         'draw.quantity = "impact_velocity": not amplitude or multiplier'),
        ("branch", "[branch]", "[draw]\ncoordinate = 2\n[branch]",
         "draw.coordinate = 2: no such coordinate; the coordinates are 0 to 1"),
        ("curve", '"0.1", 1]\n', '"0.1", 1]\n[curve]\npoints = ["grazin"]\n',
         'curve.points.0 = "grazin": '),
        ("response", "on = [1, -1]\n", "", "response.on: not said on what it acts; the coordinates"),
        ("response", "on = [1, -1]", "on = [1]", "response.on = [1]: "),
        ("sweep", "on = [1, -1]\n", "", "sweep.on: not said on what it acts; the coordinates"),
        ("sweep", '"period"]', '"rms_displacement", "period"]\nsection = {at = 0}',
         "no section of a structure"),
        ("sweep", "start.x0.1", "start.x0.2", "over.start.x0.2: no such parameter"),
        ("diagram", "on = 1\ntransient", "on = 2\ntransient", "diagram.on = 2: no such coordinate"),
        ("diagram", "[[[0, 0]", "[[[0, 0, 0]", "diagram.starts.0.0 = [0, 0, 0]: 3 numbers for 2"),
        ("basins", "start.v0.1", "loads.0.omega", "over.loads.0.omega: no number of the start"),
        ("basins", "start.v0.1", "[0, 0, 1]", "over.[0, 0, 1]: 3 numbers; a direction has 4, of"),
        ("basins", "start.v0.1", "[0, 0, 0, 0]", "over.[0, 0, 0, 0]: a direction of zeros"),
        ("basins", "start.v0.1", "[0, 0, 1, a]", "over.[0, 0, 1, a]: 1 number; a direction has 4"),
        ("basins", "periods = 40", "x0 = [0, 1]", "basins.x0: unknown key; known here: "),
        ("lyapunov", "[[loads.harmonics]]\namplitude", "[[loads.harmonics]]\nampl",
         "loads.0.harmonics.0.amplitude: missing"),
    ],
)  # fmt: skip
def test_what_a_structure_does_not_have_is_told(kind: str, old: str, new: str, told: str) -> None:
    text = text_of(kind)
    assert old in text

    faults = faults_of(text.replace(old, new))

    assert any(told in fault for fault in faults), faults
    assert len(faults) <= 2


def test_loads_without_a_period_are_told_where_one_is_needed() -> None:
    text = text_of("lyapunov").replace("[lyapunov]", "[[loads]]\non = 1\nconstant = 1\n[lyapunov]")
    other = '[[loads]]\non = 1\nharmonics = [{amplitude = 1, omega = "1.3"}]\n[lyapunov]'

    assert parse_study(text).force is not None
    assert faults_of(text.replace("[lyapunov]", other)) == [
        (
            "s.toml:3: structure.loads_period: missing, as the loads have no common period; exponents "
            "are taken over forcing periods"
        )
    ]


def test_a_structure_is_neither_certified_nor_shown_on_the_page(tmp_path: Path) -> None:
    study = parse_study(text_of("orbit"))
    wanted = type(study)(study.model, study.force, study.question, certify=Certify(12))

    with pytest.raises(ParameterError, match="of structures there are no proofs"):
        run_study(wanted, tmp_path)
    with pytest.raises(ParameterError, match="not on the page"):
        link_of(study)


def test_keys_of_the_other_model_are_unknown() -> None:
    assert known_keys(kind_named("basins"), of_structure=True)["basins"] == [
        "periods", "escape", "measures", "on",
    ]  # fmt: skip
    assert "on" not in known_keys(kind_named("sweep"))["sweep"]
    assert known_keys(kind_named("orbit"), of_structure=True)["orbit"] == ["periods", "x0", "v0"]


def test_an_orbit_and_a_branch_are_those_of_python_and_are_written(tmp_path: Path) -> None:
    study = parse_study(text_of("branch"))
    structure, loads = study.model, study.force
    assert isinstance(structure, pc.Structure)
    assert isinstance(loads, pc.Loads)

    result = run_study(study, tmp_path / "branch")

    own = pc.continue_orbit(
        pc.find_orbit(structure, loads), {"loads.0.omega": ("0.7", "1.2")}, max_points=3
    )
    np.testing.assert_array_equal(result.answer.values, own.values)
    assert {file.name for file in result.files} >= {"branch.nc", "branch.csv", "branch.png"}
    loaded = load_netcdf(tmp_path / "branch" / "branch.nc")
    np.testing.assert_array_equal(loaded.amplitude, own.amplitude)
    table = xarray.load_dataset(tmp_path / "branch" / "branch.nc")
    np.testing.assert_array_equal(table.amplitude, own.amplitude)
    # The record of a table repeats the study.
    again = parse_study((tmp_path / "branch" / "branch.csv.toml").read_text())
    assert again == study or again.text() == study.text()


def test_the_orbits_of_a_search_are_those_of_python_and_are_written(tmp_path: Path) -> None:
    study = parse_study(text_of("orbits"))
    structure, loads = study.model, study.force
    assert isinstance(structure, pc.Structure)
    assert isinstance(loads, pc.Loads)

    result = run_study(study, tmp_path)

    own = pc.find_orbits(structure, loads, 1, 1)
    assert result.report["orbits"].startswith(f"{len(own)}: ")
    assert result.report["search"] == own.completeness()
    loaded = load_netcdf(tmp_path / "orbits.nc")
    assert [orbit.x0.tolist() for orbit in loaded] == [orbit.x0.tolist() for orbit in own]
    rows = pandas.read_csv(tmp_path / "orbits.csv")
    # pandas before 3.1 rounds decimals in its own way.
    np.testing.assert_array_max_ulp(rows.x0_1.to_numpy(), np.array([orbit.x0[1] for orbit in own]))
    assert rows.is_stable.tolist() == [orbit.is_stable for orbit in own]
    assert (tmp_path / "orbits.png").stat().st_size > 10_000


def test_a_response_is_that_of_python_and_is_written(tmp_path: Path) -> None:
    study = parse_study(text_of("response").replace('"0.7", "1.2"', '"0.85", "1.2"'))
    structure, loads = study.model, study.force
    assert isinstance(structure, pc.Structure)
    assert isinstance(loads, pc.Loads)

    result = run_study(study, tmp_path / "response")

    own = pc.response_curve(
        structure, loads, {"loads.0.omega": ("0.85", "1.2")}, on=(1, -1),
        max_impacts=1, max_periods=1, n_seeds=1,
    )  # fmt: skip
    loaded = load_netcdf(tmp_path / "response" / "response.nc")
    assert loaded.to_xarray().equals(own.to_xarray())
    table = xarray.load_dataset(tmp_path / "response" / "response.nc")
    assert table.drop_attrs().equals(own.to_xarray().drop_attrs())
    rows = pandas.read_csv(tmp_path / "response" / "response.csv")
    np.testing.assert_array_max_ulp(rows.amplitude.to_numpy(), np.concatenate(own.amplitude))
    np.testing.assert_array_equal(rows.n_periods, 1)
    special = pandas.read_csv(tmp_path / "response" / "special_points.csv")
    points = [point for branch in own.branches for point in branch.special_points]
    assert points
    assert [*special.kind] == [point.kind for point in points]
    for kind in {point.kind for point in own.special_points}:
        assert kind.replace("_", " ") in result.report["special points"]
    # The record of a table repeats the chart: its own range, and what is measured.
    again = parse_study((tmp_path / "response" / "response.csv.toml").read_text())
    assert again.text() == study.text()
    found = parse_study(response_text(own)).question
    assert isinstance(found, Response)
    assert (found.on, found.max_impacts) == ((1, -1), 1)
    assert (tmp_path / "response" / "response.png").stat().st_size > 10_000


def test_basins_over_a_direction_are_those_of_python(tmp_path: Path) -> None:
    text = text_of("basins").replace('"start.v0.1"', "'[0, 1, 0, \"0.5\"]'")
    study = parse_study(f'{text}[start]\nx0 = [0, "0.2"]\n[save]\ncsv = false\n')
    structure, loads = study.model, study.force
    assert isinstance(structure, pc.Structure)
    assert isinstance(loads, pc.Loads)
    assert parse_study(study.text()).text() == study.text()

    result = run_study(study, tmp_path)

    own = pc.basins(
        structure, loads, over={"start.x0.0": [0, "0.1"], (0, 1, 0, "0.5"): [0, "0.1"]},
        start=([0, "0.2"], [0, 0]), periods=40,
    )  # fmt: skip
    assert result.answer.equals(own)
    assert (tmp_path / "basins.png").stat().st_size > 10_000


def test_a_direction_of_starts_is_one_of_structures_with_a_start() -> None:
    text = text_of("branch").replace("loads.0.omega", "[1, 0, 0, 0]")

    assert any("a direction of starts, which this study has not" in it for it in faults_of(text))


@pytest.mark.nightly
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_runs_and_draws(kind: str, tmp_path: Path) -> None:
    study = parse_study(text_of(kind).replace('"0.7", "1.2"', '"0.4", "1.2"'))

    result = run_study(study, tmp_path / kind)

    assert result.report
    assert all(file.exists() for file in result.files)


BETWEEN_WALLS = """\
[study]
kind = "curve"
[structure]
chain = {masses = ["0.566", "0.705"], springs = ["1.717", "1.26", 0], dashpots = "0.05"}
[[structure.stops]]
type = "wall"
at = "0.213"
side = "above"
restitution = "0.58"
on = 0
[[structure.stops]]
type = "wall"
at = "-0.213"
side = "below"
restitution = "0.58"
on = 0
[[loads]]
on = 0
[[loads.harmonics]]
amplitude = "0.22"
omega = "1.021"
[orbit]
[over]
"loads.0.omega" = ["0.95", "1.15"]
"loads.0.amplitude" = ["0.2", "0.24"]
[curve]
points = ["fold", "symmetry_breaking"]
"""


def test_a_point_without_a_curve_leaves_the_curves_of_the_others(tmp_path: Path) -> None:
    """The whole study ended with the sentence of that point."""
    study = parse_study(BETWEEN_WALLS)

    what = r"no curve from symmetry_breaking at loads.0.omega = 1.02\d*: formal"
    with pytest.warns(UserWarning, match=what):
        result = run_study(study, tmp_path)

    assert [curve.kind for curve in result.answer] == ["fold"]
