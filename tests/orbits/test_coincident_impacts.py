"""Coincident impacts of a family: one graze, and no other special point near it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.orbits import Branch, analysed_graze
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.grazing_contact import grazing_contacts

WALL, OMEGA = "oscillator.stops.0.at", "forcing.omega"
# The steady motion swings this far: there it grazes the wall, and both impacts coincide.
FREQUENCY, AMPLITUDE, DAMPING = 3.409, 1.694, 0.05
EDGES = {"period_doubling": -1.0, "fold": 1.0, "branch_point": 1.0}
SWING = AMPLITUDE / math.hypot(1.0 - FREQUENCY**2, 2.0 * DAMPING * FREQUENCY)


@pytest.fixture(scope="module")
def orbit() -> pc.PeriodicOrbit:
    osc = pc.impact_oscillator(0.7, wall=0.113, damping=DAMPING)
    return pc.find_orbit(osc, pc.cosine(FREQUENCY, AMPLITUDE, phase=0.7), 2, 2)


@pytest.fixture(scope="module")
def branch(orbit: pc.PeriodicOrbit) -> Branch:
    return pc.continue_orbit(orbit, over={WALL: (-1.0, 1.0)})


def test_it_is_one_graze_at_its_closed_form(branch: Branch) -> None:
    near = [point for point in branch.special_points if abs(point.value + SWING) < 1e-3]

    assert [point.kind for point in near] == ["grazing"]
    assert near[0].status == "located"
    assert near[0].value == pytest.approx(-SWING, abs=1e-12)
    assert near[0].detail == "impacts on stop 0 have no velocity"


def test_special_points_of_the_branch_have_their_multipliers(branch: Branch) -> None:
    for point in branch.special_points:
        assert point.status == "located"
        if point.kind in EDGES and "cover" not in point.detail:
            assert np.abs(point.orbit.multipliers - EDGES[point.kind]).min() < 1e-6


def test_the_graze_is_that_of_the_motion_without_impacts(branch: Branch) -> None:
    graze = min(branch.special_points, key=lambda point: abs(point.value + SWING))

    first, again = grazing_contacts(graze.orbit)
    assert (first.events, again.events) == ((0, 1), ())

    steady = pc.switch_branch(graze)
    assert (steady.n_impacts, steady.n_periods, steady.admissible) == (0, 1, True)

    osc = pc.impact_oscillator(0.7, wall=-SWING, damping=DAMPING)
    alone = analysed_graze(pc.find_orbit(osc, graze.orbit.forcing, 0), WALL)
    reported = graze.graze
    assert reported is not None
    assert reported.scenario == alone.scenario
    assert reported.acceleration == pytest.approx(alone.acceleration, rel=1e-9)
    assert reported.impact_rate == pytest.approx(alone.impact_rate, rel=1e-6)


def test_beyond_it_there_is_no_motion(orbit: pc.PeriodicOrbit) -> None:
    """On one side the flight between the two would have a negative duration: the family ends."""
    down = pc.continue_orbit(
        pc.continue_orbit(orbit, over={WALL: (-0.2, 0.2)})[0], over={WALL: (-1.0, 1.0)}
    )
    for found in (down, pc.continue_orbit(orbit, over={WALL: (-1.0, 1.0)})):
        for each in found:
            assert each.itinerary.durations.min() > -1e-6


def test_formal_orbits_do_not_go_back_in_time() -> None:
    """The equations have such solutions, and the formulas of the flights hold forwards only."""
    osc, force, counts, _ = FAMILIES["flights back"]
    for found in pc.find_orbits(osc, force, *counts, formal=True):
        assert found.n_impacts == 0 or found.impacts.intervals.min() > 0.0


def test_a_flight_of_no_time_is_no_solution_by_itself(orbit: pc.PeriodicOrbit) -> None:
    """The next impact without a flight between would be met by any velocity."""
    family = BranchEquations(orbit, WALL, -1.0, 1.0)
    z = family.start(orbit, 0.113)
    z[1] = 0.0

    residual, _ = family.residual(z, 0.113)

    assert residual[0] == z[1 + family.n]


@pytest.mark.parametrize("short", [1e-3, 0.3])
def test_equations_divided_by_durations_have_their_derivative(
    orbit: pc.PeriodicOrbit, short: float
) -> None:
    family = BranchEquations(orbit, WALL, -1.0, 1.0)
    z = family.start(orbit, 0.113)
    z[1] = short
    _, matrix = family.residual(z, 0.113)
    for column in range(2 * family.n + 1):
        sides = []
        for step in (1e-5, -1e-5):
            beside = z.copy()
            beside[column] += step
            sides.append(family.residual(beside, 0.113)[0])
        measured = (sides[0] - sides[1]) / 2e-5
        assert measured == pytest.approx(matrix[:, column], abs=1e-8 * np.abs(matrix).max())


def test_they_are_smooth_at_a_flight_of_no_time(orbit: pc.PeriodicOrbit) -> None:
    """At its start the velocity of the flight is its mean, where the flight closes."""
    family = BranchEquations(orbit, WALL, -1.0, 1.0)
    z = family.start(orbit, 0.113)
    z[1], z[1 + family.n] = 0.0, 0.0
    at_graze, exact = family.residual(z, 0.113)
    short = 1e-6
    z[1] = short
    beside, _ = family.residual(z, 0.113)

    assert (beside - at_graze) / short == pytest.approx(exact[:, 1], rel=1e-4, abs=1e-4)


def wall(at: float, r: float, damping: float) -> pc.Oscillator:
    return pc.impact_oscillator(r, wall=at, damping=damping)


# Families that had false points: near such a graze, or where flights of negative duration follow
# it, whose multipliers were those of no flight; the last by a step of Newton's method far aside.
FAMILIES = {
    "two impacts": (wall(0.362, 0.9, 0.05), pc.cosine(1.464, 1.342, phase=0.7), (2, 1), WALL),
    "three impacts": (wall(0.413, 0.7, 0.2), pc.cosine(0.803, 1.505, phase=0.7), (3, 1), WALL),
    "flights back": (wall(0.024, 0.7, 0.2), pc.cosine(3.051, 0.525, phase=0.7), (2, 1), WALL),
    "frequency": (wall(-0.589, 0.7, 0.05), pc.cosine(0.804, 0.897, phase=0.7), (2, 1), OMEGA),
    "far aside": (wall(0.368, 0.3, 0.05), pc.cosine(2.676, 1.111, phase=0.7), (1, 2), OMEGA),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_no_family_has_false_points(name: str) -> None:
    osc, force, counts, path = FAMILIES[name]
    found = [
        orbit for orbit in pc.find_orbits(osc, force, *counts, formal=True)
        if (orbit.n_impacts, orbit.n_periods) == counts
    ]  # fmt: skip
    over = (-1.5, 1.5) if path == WALL else (0.5, 4.5)

    points = pc.continue_orbit(found[-1], over={path: over}, max_points=400).special_points

    assert points
    for point in points:
        assert point.status == "located", point
        if point.kind in EDGES and "cover" not in point.detail:
            assert np.abs(point.orbit.multipliers - EDGES[point.kind]).min() < 1e-5, point
