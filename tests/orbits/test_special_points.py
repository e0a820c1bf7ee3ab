"""What a special point tells of itself, and steps of a branch that go astray."""

from __future__ import annotations

import dataclasses
from collections import Counter

import numpy as np
import pytest

import percuss as pc
from percuss.orbits import Branch
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.multiple_covers import orbit_of_itinerary
from percuss.orbits.bifurcations.soft_grazing import start_beyond
from percuss.orbits.orbit.itinerary import Itinerary

AMPLITUDE, OMEGA = "forcing.amplitude", "forcing.omega"


@pytest.fixture(scope="module")
def grazing() -> Branch:
    osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    return pc.continue_orbit(pc.find_orbit(osc, pc.cosine(1.0)), over={AMPLITUDE: (1.0, 0.05)})


def test_a_special_point_says_whether_its_orbit_is_formal(grazing: Branch) -> None:
    reported = {point.kind: (point.admissible, "formal" in repr(point))
            for point in grazing.special_points}  # fmt: skip

    assert reported == {
        "fold": (True, False),
        "grazing": (True, False),
        # Beyond the graze.
        "period_doubling": (False, True),
    }


def test_a_graze_of_a_formal_orbit_stays_formal(grazing: Branch) -> None:
    """An orbit that passes through the wall elsewhere, as one of a graze."""
    (graze,) = (point for point in grazing.special_points if point.kind == "grazing")
    formal = dataclasses.replace(graze, orbit=grazing[len(grazing) - 1])

    assert not formal.admissible


def test_the_origin_of_a_doubled_branch_says_where_switching_leads() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    single = pc.continue_orbit(orbit, over={OMEGA: (2.6, 2.7)})
    (doubling,) = single.special_points
    doubled = pc.continue_orbit(pc.switch_branch(doubling), over={OMEGA: (2.65, 2.7)})

    origin = doubled.special_points[0]

    assert doubling.detail == "a multiplier is -1"
    assert "switch_branch returns it" in origin.detail
    assert "switch_branch returns it" in repr(origin)
    assert (doubled[5].n_impacts, pc.switch_branch(origin).n_impacts) == (2, 1)


@pytest.mark.parametrize("size", [1e160, -1e200, 1.7e308])
def test_a_step_far_astray_ends_in_an_error_without_warnings(size: float) -> None:
    gear = pc.backlash_oscillator(gap=0.5, stiffness=10.0, damping=0.04, stop_damping=0.02)
    orbit = pc.find_orbit(gear, pc.cosine(1.9, amplitude=0.9, constant=0.4), 1)
    family = BranchEquations(orbit, OMEGA, 1.0, 3.0)
    start = family.start(orbit, 1.9)

    for k in range(len(start) - 1):
        astray = start.copy()
        astray[k] = size
        family.slope(astray)
        with pytest.raises((pc.ConvergenceError, pc.ParameterError)):
            family.corrected(astray, np.append(np.zeros(len(start) - 1), 1.0))


@pytest.mark.parametrize("unit", [2.0**-30, 1.0, 2.0**20])
def test_whether_a_point_is_located_does_not_hang_on_the_unit(unit: float) -> None:
    """A bracket below 1e-10, whatever that was, was a location."""
    stops = pc.SoftStop(0.2 * unit, "above", 8), pc.Wall(0.5 * unit, "above", 0.7)
    force = pc.cosine(1.5, amplitude=1.2 * unit)
    orbit = pc.find_orbit(pc.Oscillator(1, 0.05, stops), force, 2, 1)

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (-0.1 * unit, 0.8 * unit)})

    (corner,) = (point for point in branch.special_points if point.kind == "corner")
    assert (corner.value, corner.status) == (0.5 * unit, "bracketed")


def test_where_a_soft_stop_is_left_without_velocity_no_multiplier_is_one() -> None:
    """The formal branch turns there, as motions of either sign meet; it was a fold."""
    stops = pc.SoftStop("0.46", "above", "6.69"), pc.Wall("0.632", "above", "0.68")
    osc, force = pc.Oscillator(1, "0.6", stops), pc.cosine("1.7757", amplitude="1.82", phase="1.43")
    omega = "forcing.omega"

    branch = pc.continue_orbit(pc.find_orbit(osc, force, 1, 1), over={omega: (0.5, 3.5)})

    left = [point for point in branch.special_points if "left without velocity" in point.detail]
    assert [round(point.value, 6) for point in left] == [0.711025, 0.641404]
    assert {point.kind for point in left} == {"grazing"}
    assert not any(point.admissible for point in left)
    assert not any(point.kind == "fold" for point in branch.special_points)
    with pytest.raises(pc.ParameterError, match="the graze coincides with another event"):
        pc.continue_curve(left[0], {omega: (0.5, 3.5), "forcing.constant": (-1, 1)})


def test_a_formal_entry_without_velocity_ends_a_branch_with_a_sentence() -> None:
    """The impact on the wall behind the soft stop was taken for the exit: a StopIteration."""
    stops = pc.SoftStop("0.27", "above", "4.427"), pc.Wall("0.5075", "above", "0.403")
    osc = pc.Oscillator(1, "0.05", stops)
    force = pc.cosine("2.6405", amplitude="1.4218", phase="3.474")
    orbits = [each for each in pc.find_orbits(osc, force, 2, 2) if each.n_impacts == 2]
    assert orbits

    for orbit in orbits:
        branch = pc.continue_orbit(orbit, over={"forcing.omega": (1.9, 3.2)})
        assert "the orbit does not meet soft stop 0" in branch.end_reason


def test_no_family_begins_among_flights_of_negative_duration() -> None:
    """Visits that begin at a graze came before the first event: a KeyError."""
    stops = pc.SoftStop("0.3246", "above", "59.5"), pc.SoftStop("-0.3246", "below", "9.49")
    osc, amplitude = pc.Oscillator(1, "0.05", stops), 2.37331
    calm = pc.find_orbit(osc, pc.cosine("2.8821", amplitude=amplitude), 0)
    early, instants = 2.7e-6, calm.turning_points.t[:2]
    events = np.array([[2, 4, 6], [2, 6, 4], [1, 4, 2], [1, 2, 4]])
    half = 0.5 * calm.period
    durations = np.array([-early, half + early, -early, half + early])
    speeds = 3.6e-6 * np.array([-1.0, 1.0, 1.0, -1.0])
    formal = orbit_of_itinerary(
        calm, Itinerary(events, float(instants.min()), durations, speeds, 1)
    )
    family = BranchEquations(formal, "forcing.amplitude", 2.3, 2.5)

    assert start_beyond(family, formal, amplitude) is None


@pytest.mark.nightly
def test_zeros_that_come_in_pairs_within_a_step_are_found_where_a_point_shows_them() -> None:
    """Without losses another branch crosses next to each fold: both in a step of usual length."""
    osc = pc.Oscillator(1, 0, (pc.SoftStop("0.273", "above", "2790.404"),))
    force = pc.cosine("2.228", amplitude="0.326", phase="pi")
    orbit = min(pc.find_orbits(osc, force, 1, 2)[1:], key=lambda each: abs(each.multipliers[0]))
    kinds = []
    for largest_step in (0.02, 0.005):
        ranges = {"forcing.omega": (2.01, 2.3)}
        branch = pc.continue_orbit(orbit, over=ranges, largest_step=largest_step)
        kinds.append(Counter(point.kind for point in branch.special_points))
        for point in branch.special_points:
            if point.kind == "branch_point" and point.status == "located":
                assert np.abs(point.orbit.multipliers - 1.0).min() < 1e-3
    assert kinds[0] == kinds[1]
    assert min(kinds[0].values()) > 0
