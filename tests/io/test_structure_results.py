"""Orbits, branches, curves and responses of structures in files, and back to the bit."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import h5py  # type: ignore[import-untyped]  # it has no types
import numpy as np
import pytest

import percuss as pc
from percuss.kernels.record import NEXT_REGION
from percuss.model.acting_sets import StructureSystem
from percuss.orbits.bifurcations.structure_branch import StructureBranch
from percuss.orbits.orbit.structure_orbit import StructureOrbit

STOPS = (
    pc.Wall(at="0.5", side="above", restitution="0.7", on="tip"),
    pc.SoftStop(at="-0.3", side="below", stiffness=20, damping="0.1", on=0),
)
TWO = pc.Structure(
    [1, 1], [[2, -1], [-1, 2]], [["0.4", "-0.2"], ["-0.2", "0.4"]], stops=STOPS,
    units=pc.Units("m", "s", "kg"), points={"tip": (0, 1)},
)  # fmt: skip
LOADS = pc.Loads({0: pc.cosine("1.4", amplitude="0.8")})


@pytest.fixture(scope="module")
def branch() -> StructureBranch:
    orbit = pc.find_orbit(TWO, LOADS)
    return pc.continue_orbit(orbit, over={"loads.0.amplitude": (0.9, 0.35)}, largest_step=0.1)


def and_back(result: Any, path: Path) -> Any:
    pc.save_netcdf(result, path)
    return pc.load_netcdf(path)


def assert_same(one: Any, other: Any) -> None:
    """Compare two values to the bit, field by field."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other)
        assert one.dtype == other.dtype
    elif isinstance(one, list | tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_same(a, b)
    elif isinstance(one, StructureOrbit):
        for name in ("structure", "loads", "n_periods", "residual", "admissible"):
            assert getattr(one, name) == getattr(other, name)
        for name in ("x0", "v0", "multipliers", "monodromy"):
            assert_same(getattr(one, name), getattr(other, name))
        assert (one.run.start, one.run.t0, one.run.t_end, one.run.outcome) == (
            other.run.start, other.run.t0, other.run.t_end, other.run.outcome,
        )  # fmt: skip
        for name in ("impacts", "crossings", "contacts", "grazes"):
            tables = (getattr(each.run, name).to_xarray() for each in (one, other))
            a, b = tables
            assert a.identical(b)
        t = np.linspace(0.0, one.run.t_end, 33)
        assert_same(one.run(t), other.run(t))
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name))
    else:
        # So that NaN is equal to NaN.
        assert repr(one) == repr(other)


def test_a_branch_with_formal_orbits_comes_back_to_the_bit(
    branch: StructureBranch, tmp_path: Path
) -> None:
    assert {"grazing"} <= {point.kind for point in branch.special_points}
    assert not branch.admissible.all()

    loaded = and_back(branch, tmp_path / "branch.nc")

    assert_same(branch, loaded)
    for point in loaded.special_points:
        assert point.orbit is loaded.orbits[point.row]
    again = and_back(loaded, tmp_path / "again.nc")
    assert_same(branch, again)


def test_a_loaded_orbit_goes_on_as_the_one_that_was_saved(
    branch: StructureBranch, tmp_path: Path
) -> None:
    orbit = branch.orbits[0]
    loaded = and_back(orbit, tmp_path / "orbit.nc")

    assert_same(orbit, loaded)
    ends = {"loads.0.amplitude": (0.89, 0.9)}
    assert_same(pc.continue_orbit(orbit, over=ends), pc.continue_orbit(loaded, over=ends))
    paths = ["structure.stops.0.at", "loads.0.omega"]
    assert_same(orbit.sensitivity(paths).x0, loaded.sensitivity(paths).x0)
    assert loaded.run.extremes("stop_force", stop=1) == orbit.run.extremes("stop_force", stop=1)


def test_sets_of_acting_stops_are_known_by_their_bits(
    branch: StructureBranch, tmp_path: Path
) -> None:
    orbit = branch.orbits[0]
    pc.save_netcdf(orbit, tmp_path / "orbit.nc")
    kept = StructureSystem.of.__globals__["_system"]
    kept.cache_clear()
    # The wall holds, then both: not in the order of the orbit.
    system = StructureSystem.of(orbit.structure, orbit.loads)
    system.add(1, 3, 2)

    loaded = pc.load_netcdf(tmp_path / "orbit.nc")

    own, others = orbit.run.record, loaded.run.record
    assert own.marks[:, NEXT_REGION].tolist() != others.marks[:, NEXT_REGION].tolist()
    assert_same(orbit, loaded)


def test_curves_come_back_one_alone_and_as_a_list(branch: StructureBranch, tmp_path: Path) -> None:
    (graze, *_) = (point for point in branch.special_points if point.kind == "grazing")
    ranges = {"loads.0.amplitude": (0.35, 0.9), "loads.0.omega": (1.39, 1.41)}
    curve = pc.continue_curve(graze, over=ranges, largest_step=0.3)

    assert_same(curve, and_back(curve, tmp_path / "curve.nc"))
    assert_same([curve, curve], and_back([curve, curve], tmp_path / "curves.nc"))


def test_a_response_comes_back(tmp_path: Path) -> None:
    loads = pc.Loads({0: pc.cosine("1.4", amplitude="0.3")})
    chart = pc.response_curve(
        TWO, loads, {"loads.0.omega": ("1.4", "1.42")}, on="tip", max_periods=1, max_impacts=1,
        n_seeds=1,
    )  # fmt: skip
    loaded = and_back(chart, tmp_path / "response.nc")

    assert_same(chart, loaded)
    assert loaded.families == chart.families
    assert loaded.on == "tip"


def test_a_damaged_file_is_told(branch: StructureBranch, tmp_path: Path) -> None:
    path = tmp_path / "orbit.nc"
    pc.save_netcdf(branch.orbits[0], path)
    with h5py.File(path, "a") as file:
        del file["orbits_of_structures"]["run_marks"]
    with pytest.raises(OSError, match=r"orbit\.nc: damaged, or of another version"):
        pc.load_netcdf(path)
