"""Orbits, branches, curves and responses come back from their files to the bit."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py  # type: ignore[import-untyped]  # it has no types
import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss.errors import OutputError, ParameterError
from percuss.execution import Execution
from percuss.io import load_netcdf, load_record, save_csv, save_netcdf
from percuss.io.exact_json import decoded, encoded
from percuss.orbits import Branch, PeriodicOrbit
from percuss.studies.reading import parse_study

# Exact numbers of every type, which a file has to keep apart.
OSC = pc.impact_oscillator(
    Decimal("0.80"), wall="1", side="above", stiffness=1, damping=Fraction(1, 20)
)

# Formal orbits are meant here: they are looked at one by one.
pytestmark = pytest.mark.filterwarnings("ignore::percuss.FormalOrbitWarning")
FORCE = pc.cosine("1", phase=pc.pi_times(1, 3))


def assert_same(a: Any, b: Any, path: str = "") -> None:
    """Compare to the bit, types included."""
    assert type(a) is type(b), path
    if isinstance(a, np.ndarray):
        assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes()), path
    elif dataclasses.is_dataclass(a) and not isinstance(a, type):
        for field in dataclasses.fields(a):
            name = field.name
            assert_same(getattr(a, name), getattr(b, name), f"{path}.{name}")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), path
        for i, (one, other) in enumerate(zip(a, b, strict=True)):
            assert_same(one, other, f"{path}[{i}]")
    elif isinstance(a, float):
        assert a == b or (math.isnan(a) and math.isnan(b)), path
    else:
        assert a == b, path


@pytest.fixture(scope="module")
def orbit() -> PeriodicOrbit:
    found: PeriodicOrbit = pc.find_orbit(OSC, FORCE)
    return found


@pytest.fixture(scope="module")
def branch(orbit: PeriodicOrbit) -> Branch:
    found: Branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (1, "0.05")})
    return found


BALL, TABLE = pc.ball_on_table(amplitude="1.2", omega=1, gravity=1, restitution="0.5")
SOFT = pc.bilinear_oscillator(stiffness_above=1, stiffness_below=25, damping=0.1)
SETTLED = pc.simulate(SOFT, pc.cosine(2), v0=1.0, t_end=400.0)
# An orbit of every make.
MAKES: dict[str, Callable[[], PeriodicOrbit]] = {
    "soft": lambda: pc.find_orbit(SOFT, pc.cosine(2), guess=SETTLED),
    "steady": lambda: pc.find_orbit(OSC, FORCE, 0),
    "sticking": lambda: pc.find_orbit(BALL, TABLE, math.inf),
    "family": lambda: pc.find_orbit(pc.impact_oscillator(1), pc.sine(3), guess=(0.0, 0.6)),
    "free": lambda: pc.find_orbit(pc.impact_oscillator(1, wall=-1), None, guess=(0.0, 1.0)),
}


@pytest.mark.parametrize("name", MAKES)
def test_an_orbit_of_any_make_is_read_back_equal(name: str, tmp_path: Path) -> None:
    orbit = MAKES[name]()

    save_netcdf(orbit, tmp_path / "orbit.nc")

    again = load_netcdf(tmp_path / "orbit.nc")
    assert_same(again, orbit)
    assert_same(again.trajectory(2).impacts, orbit.trajectory(2).impacts)


def test_a_formal_orbit_keeps_its_passages(branch: Branch, tmp_path: Path) -> None:
    formal = next(it for it in branch if len(it.passages))

    save_netcdf(formal, tmp_path / "orbit.nc")

    assert_same(load_netcdf(tmp_path / "orbit.nc"), formal)


def test_a_branch_is_read_back_equal_and_its_special_points_are_its_rows(
    branch: Branch, tmp_path: Path
) -> None:
    save_netcdf(branch, tmp_path / "branch.nc")

    again = load_netcdf(tmp_path / "branch.nc")

    assert len(branch.special_points) == 3
    assert_same(again, branch)
    for point in again.special_points:
        assert point.orbit is again.orbits[point.row]
    frame = again.to_xarray().to_dataframe()
    assert len(frame) > 0


def test_a_loaded_branch_can_be_followed_further(branch: Branch, tmp_path: Path) -> None:
    save_netcdf(branch, tmp_path / "branch.nc")

    again = load_netcdf(tmp_path / "branch.nc")

    fresh = pc.continue_orbit(branch[-1], over={"forcing.amplitude": (0.9, 1.2)})
    assert_same(pc.continue_orbit(again[-1], over={"forcing.amplitude": (0.9, 1.2)}), fresh)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_list_of_orbits_is_read_back_equal(
    count: int, orbit: PeriodicOrbit, tmp_path: Path
) -> None:
    orbits = [orbit, pc.find_orbit(OSC, FORCE, 0)][:count]

    save_netcdf(orbits, tmp_path / "orbits.nc")
    save_csv(orbits, tmp_path / "orbits.csv")

    assert_same(load_netcdf(tmp_path / "orbits.nc"), orbits)
    lines = (tmp_path / "orbits.csv").read_text().splitlines()
    assert sum(not line.startswith("#") for line in lines) == count + 1


def test_csv_of_a_branch_holds_its_floats_to_the_bit(branch: Branch, tmp_path: Path) -> None:
    save_csv(branch, tmp_path / "branch.csv")
    save_csv(branch, tmp_path / "special.csv", table="special_points")

    with (tmp_path / "branch.csv").open() as file:
        rows = list(csv.DictReader(file))
    columns = {
        branch.path: branch.values,
        "impact_velocity_0": branch.impact_velocity[:, 0],
        "multiplier_imag_1": branch.multipliers[:, 1].imag,
        "grazing_margin": branch.grazing_margin,
    }
    for name, values in columns.items():
        np.testing.assert_array_equal([float(row[name]) for row in rows], values)
    marked = {i: row["special_point"] for i, row in enumerate(rows) if row["special_point"]}
    assert marked == {point.row: point.kind for point in branch.special_points}
    with (tmp_path / "special.csv").open() as file:
        special = list(csv.DictReader(file))
    assert [float(row[branch.path]) for row in special] == [p.value for p in branch.special_points]


def test_the_record_of_an_orbit_finds_it_again(orbit: PeriodicOrbit, tmp_path: Path) -> None:
    save_netcdf(orbit, tmp_path / "orbit.nc", command="by hand")

    record = load_record(tmp_path / "orbit.nc")
    study = parse_study(record.study)
    again = study.question.answer(study, Execution())

    assert record.command == "by hand"
    assert study.kind == "orbit"
    assert again.impacts.v_after[0] == pytest.approx(orbit.impacts.v_after[0], rel=1e-13)


def test_the_record_of_a_branch_follows_it_again(branch: Branch, tmp_path: Path) -> None:
    save_csv(branch, tmp_path / "branch.csv")

    study = parse_study(load_record(tmp_path / "branch.csv").study)
    again = study.question.answer(study, Execution())

    found = {point.kind: point.value for point in again.special_points}
    for point in branch.special_points:
        assert found[point.kind] == pytest.approx(point.value, abs=1e-9)


def test_the_dataset_of_an_ensemble_is_read_back(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="1 of 3 points have no answer"):
        data = pc.sweep("period", OSC, FORCE, over={"forcing.omega": [1.0, 1.1, -1.0]}, transient=9)

    save_netcdf(data, tmp_path / "sweep.nc")
    save_csv(data, tmp_path / "sweep.csv")

    again = load_netcdf(tmp_path / "sweep.nc")
    xr.testing.assert_equal(again, data)
    assert "forcing.omega,period" in (tmp_path / "sweep.csv").read_text()
    assert len(again.reason) == 1


def test_nothing_is_overwritten_without_force(orbit: PeriodicOrbit, tmp_path: Path) -> None:
    path = tmp_path / "orbit.nc"
    path.write_text("precious")

    with pytest.raises(OutputError, match="exists already"):
        save_netcdf(orbit, path)

    assert path.read_text() == "precious"


def test_what_is_no_result_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="not a run, an orbit, a list of them"):
        save_netcdf({"x": 1}, tmp_path / "x.nc")
    with pytest.raises(ParameterError, match=r"or a dataset; its table is in to_pandas\(\)"):
        save_csv(pc.simulate(pc.impact_oscillator(), v0=1, t_end=5).impacts, tmp_path / "x.csv")
    with pytest.raises(ParameterError, match="not a list of one of"):
        save_netcdf([1, 2], tmp_path / "x.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_table_that_there_is_not_is_refused(orbit: PeriodicOrbit, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="none of impacts, orbit"):
        save_csv(orbit, tmp_path / "x.csv", table="branch")


def test_a_file_cut_short_is_one_sentence(orbit: PeriodicOrbit, tmp_path: Path) -> None:
    path = tmp_path / "orbit.nc"
    save_netcdf(orbit, path)
    whole = path.read_bytes()
    for part in (0, 100, len(whole) // 2):
        path.write_bytes(whole[:part])
        with pytest.raises(OSError, match=r"orbit\.nc: (not a NetCDF file|damaged)"):
            load_netcdf(path)


def test_a_file_with_a_table_missing_is_one_sentence(orbit: PeriodicOrbit, tmp_path: Path) -> None:
    path = tmp_path / "orbit.nc"
    save_netcdf(orbit, path)
    with h5py.File(path, "r+") as file:
        del file["orbits/period"]

    with pytest.raises(OSError, match=r"orbit\.nc: damaged, or of another version of percuss"):
        load_netcdf(path)


def test_a_foreign_netcdf_file_is_one_sentence(tmp_path: Path) -> None:
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")

    with pytest.raises(OSError, match=r"a\.nc: holds no result of percuss"):
        load_netcdf(tmp_path / "a.nc")


def test_no_class_but_values_of_percuss_is_ever_made_from_a_file() -> None:
    for name in ("subprocess.Popen", "percuss.model.paths.get_parameter", "percuss.io.files.os"):
        with pytest.raises(ValueError, match="no value of percuss"):
            decoded({"value": name, "fields": {}})
    with pytest.raises(TypeError, match="no place in a file"):
        encoded(object())
