"""A search for all orbits of a structure, against branches, closed forms and its own repetition."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.orbits.finding.found import FoundOrbits

# Example 03 of NLvib.
NLVIB = pc.Structure(
    mass=[1, 1],
    stiffness=[[1, -1], [-1, 2]],
    damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
    stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
)
WALLED = pc.chain([1, 1], [1, 1, 0], "0.1", [pc.Wall("0.5", "above", "0.7", on=1)])


def loads(omega: str, amplitude: str | int, on: int) -> pc.Loads:
    return pc.Loads({on: pc.cosine(omega, amplitude=amplitude)})


def multipliers(orbits: FoundOrbits[pc.StructureOrbit]) -> list[float]:
    return sorted(float(np.abs(orbit.multipliers).max()) for orbit in orbits)


@pytest.mark.parametrize(
    ("structure", "given"),
    [(NLVIB, loads("0.75", "0.1", 1)), (WALLED, loads("0.9", "0.3", 0))],
    ids=["soft stop", "wall"],
)
def test_orbits_close_are_different_and_are_sorted(
    structure: pc.Structure, given: pc.Loads
) -> None:
    orbits = pc.find_orbits(structure, given, 4, 4)

    assert len(orbits) >= 3
    assert all(orbit.residual < 1e-12 for orbit in orbits)
    assert not all(orbit.is_stable for orbit in orbits)
    kinds = [(orbit.n_periods, orbit.n_impacts) for orbit in orbits]
    assert kinds == sorted(kinds)
    for i, orbit in enumerate(orbits):
        # The motion over ten of its periods comes back, in that order: it is an orbit of the motion
        # that `simulate` follows, and none is given twice.
        again = pc.simulate(structure, given, orbit.x0, orbit.v0, periods=orbit.n_periods)
        np.testing.assert_allclose(again(again.t_end)[0], orbit.x0, atol=1e-11)
        states = [other.run(k * other.period / other.n_periods)
                  for other in orbits[:i] for k in range(other.n_periods)]  # fmt: skip
        assert all(np.abs(x - orbit.x0).max() > 1e-6 for x, _ in states)


@pytest.fixture(scope="module")
def response() -> pc.Response:
    return pc.response_curve(
        NLVIB, loads("0.75", "0.1", 1), {"loads.0.omega": ("0.7", "0.8")},
        on=0, max_impacts=2, max_periods=1, n_seeds=2,
    )  # fmt: skip


@pytest.mark.parametrize("value", ["0.72", "0.75"])
def test_all_orbits_of_the_branches_through_this_value_are_found(
    value: str, response: pc.Response
) -> None:
    """A continuation, which begins elsewhere and goes round folds, knows of no other orbits."""
    crossings = 0
    for branch in response.branches:
        sides = np.sign(branch.values - float(value))
        between = (sides[:-1] * sides[1:] < 0.0) & branch.admissible[:-1] & branch.admissible[1:]
        crossings += int(between.sum())

    orbits = pc.find_orbits(NLVIB, loads(value, "0.1", 1), 2, 1)

    assert len(orbits) == crossings == 3


def test_other_starts_find_the_same_orbits() -> None:
    one, other = (pc.find_orbits(WALLED, loads("0.9", "0.3", 0), 2, 2, seed=s) for s in (1, 2))

    np.testing.assert_allclose(multipliers(one), multipliers(other), rtol=1e-8)
    assert one.n_searches >= 40
    assert one.unseen_estimate < 0.25


def test_without_stops_the_linear_response_is_all() -> None:
    two = pc.chain([1, 1], [1, 1, 0], "0.1")

    (orbit,) = orbits = pc.find_orbits(two, loads("0.9", "0.3", 0))

    assert (orbits.n_searches, orbits.unseen_estimate) == (0, 0.0)
    dynamic = two.stiffness_matrix - 0.81 * two.mass_matrix + 0.9j * two.damping_matrix
    np.testing.assert_allclose(orbit.x0, np.linalg.solve(dynamic, [0.3, 0.0]).real, rtol=1e-12)


def test_orbits_that_stick_are_given_whatever_the_number_of_their_impacts() -> None:
    sticking = pc.chain([1, 1], [1, 1, 0], "0.4", [pc.Wall("0.05", "above", "0.2", on=1)])

    orbits = pc.find_orbits(sticking, loads("0.4", 1, 0), 1, 1)

    (orbit,) = [orbit for orbit in orbits if len(orbit.run.contacts)]
    assert orbit.n_impacts > 1
    # What a wall holds forgets how it came there.
    assert np.abs(orbit.multipliers).min() < 1e-12


def test_a_search_is_stopped_by_progress() -> None:
    calls: list[float] = []

    def stop(done: float, total: float) -> bool:
        calls.append(done / total)
        return len(calls) < 3

    orbits = pc.find_orbits(NLVIB, loads("0.75", "0.1", 1), 2, 2, progress=stop)

    assert len(calls) == orbits.n_searches == 3
    assert math.isnan(orbits.unseen_estimate)
    assert repr(orbits).endswith(" from 3 starts")


def test_what_cannot_be_searched_for_is_told() -> None:
    given = loads("0.75", "0.1", 1)
    with pytest.raises(pc.ParameterError, match=r"formal = True: of a structure only orbits that"):
        pc.find_orbits(NLVIB, given, formal=True)
    with pytest.raises(pc.ParameterError, match=r"effort = 0.01: outside 0.1 to 100"):
        pc.find_orbits(NLVIB, given, effort=0.01)
    with pytest.raises(pc.ParameterError, match="max_periods = 0: "):
        pc.find_orbits(NLVIB, given, max_periods=0)
    with pytest.raises(pc.ParameterError, match="a periodic orbit needs loads of one period"):
        pc.find_orbits(NLVIB, {0: pc.cosine(1), 1: pc.cosine("1.3")})


@pytest.mark.parametrize("unit", [2.0**-30, pytest.param(2.0**20, marks=pytest.mark.nightly)])
def test_orbits_and_multipliers_are_the_same_in_every_unit_of_time(unit: float) -> None:
    """Small motions in two wells differ in their places alone."""
    found = []
    for scale in (1.0, unit):
        stiff = 4.0 / scale**2
        structure = pc.Structure(
            mass=[1, 1],
            stiffness=np.array([[-1.0, -0.3], [-0.3, 5.0]]) / scale**2,
            damping=np.array([[0.2, -0.05], [-0.05, 0.3]]) / scale,
            stops=[
                pc.SoftStop(0.5, "above", stiff, on=0),
                pc.SoftStop(-0.5, "below", stiff, on=0),
            ],
        )
        loads = pc.Loads({0: pc.cosine(1.3 / scale, amplitude=0.05 / scale**2)})
        found.append(pc.find_orbits(structure, loads, max_periods=1))

    here, there = found
    assert len(here) == len(there) >= 2
    for one, other in zip(here, there, strict=True):
        np.testing.assert_allclose(other.x0, one.x0, rtol=1e-12)
        np.testing.assert_allclose(other.v0 * unit, one.v0, rtol=1e-11)
        np.testing.assert_allclose(other.multipliers, one.multipliers, rtol=1e-12)
