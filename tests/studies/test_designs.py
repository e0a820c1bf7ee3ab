"""Studies of designs: their faults, what they write, and that they are those of Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.studies.texts import faults_of

import percuss as pc
from percuss.errors import ParameterError, StudyError
from percuss.io import load_netcdf, save_csv
from percuss.optimization import ParetoFront
from percuss.studies import Design, Study, load_study, parse_study, run_study

MODEL = """\
[study]
kind = "design"
[oscillator]
mass = 2
stiffness = 2
damping_coefficient = "0.4"
units = {length = "m", time = "s", mass = "kg"}
[[oscillator.stops]]
type = "soft"
at = "0.2"
side = "above"
stiffness = 60
[[forcing.harmonics]]
amplitude = 2
omega = 2
"""
OWN = """\
[design]
outcome = "peak_stop_force"
[design.free]
"oscillator.stops.0.stiffness" = [10, 200]
"oscillator.stops.0.damping" = [0, 2]
[design.subject_to]
max_displacement = [-inf, "0.3"]
"""
RUN = """\
[start]
x0 = 0
v0 = "0.1"
[run]
t_end = 20
"""


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"peak_stop_force"', '"peak_force"', ('s.toml:17: design.outcome = "peak_force": did you '
         'mean "peak_stop_force"? There are ')),
        ('"peak_stop_force"', "[]", "s.toml:17: design.outcome: 0 outcomes; give one, or two for"),
        ('"peak_stop_force"', '["period", "period"]', "twice the same outcome"),
        ('"peak_stop_force"', '"period"\non = "run"',
         's.toml:17: design.outcome = "period": not max_displacement, min_displacement'),
        ('outcome = "peak_stop_force"\n', "", "s.toml:16: design.outcome: missing"),
        ("[design.free]", 'goal = "leest"\n[design.free]',
         's.toml:18: design.goal = "leest": neither "least" nor "largest", nor a number'),
        ("[design.free]", 'goal = ["least", "largest"]\n[design.free]', "2 goals for 1 outcome"),
        ('"peak_stop_force"', '["period", "multiplier"]\ngoal = 2', "a front is between outcomes"),
        ("[design.free]", "n = 4\n[design.free]", "s.toml:18: design.n = 4: of a front, which is"),
        ("[design.free]", 'on = "orbits"\n[design.free]',
         's.toml:18: design.on = "orbits": not "orbit" or "run"'),
        ("[design.free]", "[design.fre]", "design.free: missing; such as {"),
        ("stops.0.stiffness", "stops.0.stifness",
         "s.toml:19: design.free.oscillator.stops.0.stifness: no such parameter; did you mean"),
        ("[10, 200]", "[200, 10]", ("s.toml:19: design.free.oscillator.stops.0.stiffness = "
         "[200, 10]: the least is above the largest")),
        ("[10, 200]", "200", "not a range; write [first, last]"),
        ('"oscillator.stops.0.damping" = [0, 2]', '"oscillator.mass" = [-1, 2]', "design.free.oscillator.mass.0 = -1: "),
        ('"oscillator.stops.0.damping"', '"start.x0"', "design.free.start.x0: no such parameter"),
        ("max_displacement", "max_displacment",
         "s.toml:22: design.subject_to.max_displacment: did you mean"),
        ('[-inf, "0.3"]', '["0.3"]', 'not [least, largest], where inf is no limit'),
        ('[-inf, "0.3"]', "[-inf, inf]",
         "design.subject_to.max_displacement: give the least value, the largest or both"),
        ('[-inf, "0.3"]', '[-inf, "a"]', 'design.subject_to.max_displacement.1 = "a": not a number'),
        ('[-inf, "0.3"]', "[1, 0]", "the least is above the largest"),
        ("[design]", f"{RUN}[design]", 's.toml:16: start: given though design.on is "orbit"'),
        ("[design]", "[orbit]\nimpacts = 1\nsequence = [3]\n[design]",
         "orbit.sequence = [3]: the oscillator has 1 stop"),
        ("[design.free]", 'on = "run"\n[design.free]', "s.toml: run: missing a limit; give t_end"),
        ("omega = 2", 'omega = 2\n[[forcing.harmonics]]\namplitude = 1\nomega = "2.1"',
         "forcing.period: missing; a periodic orbit needs a periodic forcing"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_line_and_path(old: str, new: str, told: str) -> None:
    text = MODEL + OWN
    assert old in text

    faults = faults_of(text.replace(old, new))

    assert any(told in fault for fault in faults), faults
    assert len(faults) <= 2


def test_all_faults_are_told_at_once() -> None:
    text = MODEL + OWN.replace("peak_stop_force", "force").replace("[10, 200]", "[10]")
    text = text.replace("-inf, ", "").replace("[design]\n", "[design]\nrestarts = -1\n")

    paths = [fault.split(":")[2].split(" =")[0].strip() for fault in faults_of(text)]

    assert paths == [
        "design.restarts",
        "design.outcome",
        "design.free.oscillator.stops.0.stiffness",
        "design.subject_to.max_displacement",
    ]


@pytest.mark.parametrize(
    "own",
    [
        OWN,
        OWN.replace("[design.free]", "[design.free]\nforcing.omega = [1, 2]"),
        OWN.replace('"peak_stop_force"', '["peak_stop_force", "period"]\nn = 3\ngoal = "least"'),
        OWN.replace('"peak_stop_force"', '"period"\ngoal = "3.1"') + "[orbit]\nimpacts = 1\n",
        OWN.replace("[design.free]", f'on = "run"\n{RUN}[design.free]\n"start.v0" = [0, 1]'),
    ],
)
def test_a_design_is_read_back_equal_from_its_text(own: str) -> None:
    study = parse_study(MODEL + own)

    again = parse_study(study.text())

    assert again == study
    assert again.text() == study.text()


def test_wrong_values_in_python_are_refused() -> None:
    free: dict[str, tuple[float, float]] = {"forcing.omega": (1.0, 2.0)}
    with pytest.raises(ParameterError, match=r"design\.goal = 'leest': neither"):
        Design(("period",), free, goal="leest")
    with pytest.raises(ParameterError, match=r"design\.restarts"):
        Design(("period",), free, restarts=-1)


def test_a_run_is_that_of_python_and_its_files_hold_setting_searches_and_motion(
    tmp_path: Path,
) -> None:
    own = OWN.replace("[design.free]", 'on = "run"\nrestarts = 1\n[design.free]')
    study = parse_study(MODEL + own + RUN)

    result = run_study(study, tmp_path)

    best = pc.design(
        "peak_stop_force", study.oscillator, study.forcing, on="run", start=(0, "0.1"), t_end=20,
        free={"oscillator.stops.0.stiffness": (10, 200), "oscillator.stops.0.damping": (0, 2)},
        subject_to={"max_displacement": (None, "0.3")}, restarts=1,
    )  # fmt: skip
    assert result.answer.values == best.values
    assert result.report["design"].endswith(" N, least")
    assert result.report["max_displacement"].endswith("at most 0.3")
    tree = load_netcdf(tmp_path / "design.nc")
    assert tree["best"]["largest"].values.tolist()[-1] == 0.3
    assert tree["motion"]["x"].sizes == {"sample": 2001}
    table = (tmp_path / "best.csv").read_text().splitlines()
    assert [row.split(",")[2] for row in table] == ["unit", "N", "N/m", "N s/m", "m"]
    head = (tmp_path / "design.csv").read_text().splitlines()[0]
    assert head.startswith("oscillator.stops.0.stiffness [N/m],oscillator.stops.0.damping [N s/m],")
    assert all(load_study(file) == study for file in result.files)


def test_a_front_is_that_of_python_a_row_a_design(tmp_path: Path) -> None:
    own = OWN.replace('"peak_stop_force"', '["peak_stop_force", "max_displacement"]\nn = 3')
    own = own.split("[design.subject_to]")[0].replace(
        "[design.free]", "restarts = 0\n[design.free]"
    )
    study = parse_study(MODEL + own)

    result = run_study(study, tmp_path)

    front = result.answer
    assert isinstance(front, ParetoFront)
    assert len(front) == 3
    assert [name for name in result.report if name.startswith("design")] == [
        f"design {i}" for i in range(3)
    ]
    assert {file.name for file in result.files} >= {"design.nc", "design.csv", "design.png"}
    tree = load_netcdf(tmp_path / "design.nc")
    np.testing.assert_array_equal(tree["peak_stop_force"], front.values[:, 0])
    save_csv(front, tmp_path / "front.csv")
    assert (tmp_path / "front.csv").read_text() == (tmp_path / "design.csv").read_text()


def test_a_front_that_is_stopped_holds_the_designs_that_were_begun() -> None:
    study = parse_study(MODEL + OWN)
    counts: list[float] = []

    def stop(done: float, _: float) -> bool:
        counts.append(done)
        return len(counts) < 12

    front = pc.pareto_front(
        ("peak_stop_force", "max_displacement"), study.oscillator, study.forcing, n=9, restarts=0,
        free={"oscillator.stops.0.stiffness": (10, 200)}, progress=stop,
    )  # fmt: skip

    assert counts == sorted(counts)
    assert 1 <= len(front) < 9


def test_an_orbit_that_is_named_is_followed_though_it_is_unstable() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    text = Study(
        osc, pc.cosine("1.1"), Design(("multiplier",), {"oscillator.stops.0.at": (0.1, 0.3)})
    )
    study = parse_study(text.text() + "[orbit]\nimpacts = 1\n")

    question = study.question
    assert isinstance(question, Design)
    assert question.sought is not None
    assert not question.sought.find(study).is_stable


OF_STRUCTURE = """\
[study]
kind = "design"
[structure]
mass = [1, 1]
stiffness = [[1, -1], [-1, 2]]
damping = [["0.2", "-0.03"], ["-0.03", "0.2"]]
points = {tip = [0, 1]}
units = {length = "m", time = "s", mass = "kg"}
[[structure.stops]]
type = "soft"
on = "tip"
at = "-0.2"
side = "below"
stiffness = 100
damping = "0.3"
[[loads]]
on = 1
[[loads.harmonics]]
amplitude = "0.4"
omega = "1.7"
[design]
outcome = "peak_stop_force"
on = "run"
restarts = 0
[design.free]
"structure.stops.0.stiffness" = [20, 200]
[design.subject_to]
min_displacement_tip = ["-0.26", inf]
[run]
periods = 6
"""


def test_a_study_of_a_structure(tmp_path: Path) -> None:
    study = parse_study(OF_STRUCTURE)
    assert parse_study(study.text()) == study

    result = run_study(study, tmp_path / "out")

    assert result.answer.converged
    assert result.report["min_displacement_tip"].startswith("-0.26 m, at its limit")
    assert " N/m; free from 20" in result.report["structure.stops.0.stiffness"]
    assert (tmp_path / "out" / "design.png").stat().st_size > 10_000
    assert all(load_study(file) == study for file in result.files)
    with pytest.raises(StudyError, match='did you mean "min_displacement_'):
        parse_study(OF_STRUCTURE.replace("min_displacement_tip", "min_displacement_top"))
