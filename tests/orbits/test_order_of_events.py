"""Branches where the order of their events changes, stops meet, or impacts accumulate."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.orbits.kinds import points

import percuss as pc


@pytest.mark.parametrize("amplitude", [3, "0.7"])
def test_with_a_soft_stop_the_branch_goes_on_where_the_stop_is_not_met(
    amplitude: float | str,
) -> None:
    """From either side."""
    osc = pc.Oscillator(1.0, "0.05", (pc.SoftStop(1.0, "above", 9.0),))
    force = pc.cosine("1.5", amplitude=amplitude)
    orbit = pc.find_orbit(osc, force, int(amplitude == 3))

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (4.0, 0.5)})

    (graze,) = points(branch, "grazing")
    # The motion without the stop has amplitude 1 there.
    assert graze.value == pytest.approx(math.hypot(1.25, 0.15), abs=1e-9)
    assert branch.values[[0, -1]].tolist() == [4.0, 0.5]
    met = np.array([each.n_impacts for each in branch])
    assert (met[: graze.row] == 1).all()
    assert (met[graze.row + 1 :] == 0).all()
    assert np.isnan(branch.impact_velocity[graze.row + 1 :]).all()
    assert np.delete(branch.admissible, graze.row).all()
    assert len(branch) < 400


def is_physical(orbit: pc.PeriodicOrbit) -> bool:
    """Whether the motion from the orbit's start returns to it after its period."""
    run = pc.simulate(
        orbit.oscillator, orbit.forcing, x0=orbit.x0, v0=orbit.v0, t0=orbit.t0,
        t_end=orbit.t0 + orbit.period,
    )  # fmt: skip
    x, v = run(orbit.t0 + orbit.period)
    return bool(abs(float(x) - orbit.x0) < 1e-8 and abs(float(v) - orbit.v0) < 1e-8)


def test_backlash_both_stops_are_met_at_once() -> None:
    osc = pc.backlash_oscillator(gap=1.0, stiffness=9.0, damping=0.1, stiffness_inside=1.0)
    orbit = pc.find_orbit(osc, pc.cosine(1.5, amplitude=0.5), 0)

    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.2, 6.0)})

    (graze,) = points(branch, "grazing")
    assert graze.value == pytest.approx(math.hypot(1.25, 0.3), abs=1e-9)
    met = [each.n_impacts for each in branch]
    assert met[graze.row - 1] == 0
    assert met[graze.row + 1] == 2
    assert branch.values[-1] == 6.0
    # The stiffening spring bends the resonance over.
    assert len(points(branch, "fold")) == 2
    assert all(each.symmetric for each in branch.orbits[graze.row + 1 :: 20])
    assert all(is_physical(each) for each in branch.orbits[:: len(branch) // 10])


def test_bilinear_along_the_frequency_through_both_ends_of_the_resonance() -> None:
    osc = pc.bilinear_oscillator(1.0, stiffness_below=4.0, damping=0.05)
    orbit = pc.find_orbit(osc, pc.cosine(1.2, constant=3.0), 0)

    branch = pc.continue_orbit(orbit, over={"forcing.omega": (0.3, 3.0)})

    grazes = points(branch, "grazing")
    assert len(grazes) == 2
    for graze in grazes:
        # The motion without the stop, about 3, has amplitude 3 there.
        response = math.hypot(1.0 - graze.value**2, 0.1 * graze.value)
        assert response == pytest.approx(1.0 / 3.0, abs=1e-9)
        assert graze.status == "located"
        beside = [branch[graze.row + k].n_impacts for k in (-1, 1)]
        assert sorted(beside) == [0, 1]
    assert branch.values[[0, -1]].tolist() == [0.3, 3.0]
    stable = [each for each in branch.orbits[::15] if each.is_stable]
    assert all(is_physical(each) for each in stable)


def test_a_branch_ends_in_chatter_where_its_impacts_accumulate() -> None:
    """Each hop after the first is slower by about the restitution, which falls."""
    osc, force = pc.impact_oscillator(0.72, wall=-0.42, damping=0.02), pc.cosine(0.31)
    run = pc.simulate(osc, force, x0=0.08, t_end=6000.0)
    orbit = pc.find_orbit(osc, force, guess=run)
    assert orbit.n_impacts == 8

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.restitution": (0.0, 1.0)})

    chatter = branch.special_points[-1]
    assert chatter.kind == "chatter"
    assert "accumulate" in branch.end_reason
    speeds = np.abs(chatter.orbit.impacts.v_before[1:])
    falling = speeds[1:] / speeds[:-1]
    assert (falling < 2.0 * chatter.value + 0.1).all()
    assert speeds[-1] < 1e-6 * speeds[0]
    with pytest.raises(pc.ParameterError, match="accumulate"):
        pc.switch_branch(chatter)


def test_stops_that_change_places_meet_in_a_corner() -> None:
    stops = pc.SoftStop(1.0, "above", 4.0), pc.SoftStop(1.2, "above", 9.0)
    orbit = pc.find_orbit(pc.Oscillator(1.0, 0.05, stops), pc.cosine(1.5, amplitude=4), 2, 1)

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.1.at": (1.5, 0.8)})

    (corner,) = points(branch, "corner")
    assert (corner.value, corner.status) == (1.0, "located")
    assert "stops 1 and 0" in corner.detail
    assert branch.values[-1] == 0.8
    assert all(is_physical(each) for each in branch.orbits[::8])
    assert branch[0].sequence == (0, 1)
    assert branch[len(branch) - 1].sequence == (1, 0)


def test_a_branch_ends_in_the_corner_where_opposite_soft_stops_change_places() -> None:
    """Beyond it the events that enter one stop leave the other."""
    stops = pc.SoftStop(0.2, "above", 29.0), pc.SoftStop(-0.2, "below", 29.0)
    orbit = pc.find_orbit(pc.Oscillator(1, 0.05, stops), pc.cosine(1.2, amplitude=0.55), 2, 1)

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (-0.4, 0.3)})

    (corner,) = points(branch, "corner")
    assert (corner.value, corner.status, corner.row) == (-0.2, "located", 0)
    assert branch.end_reason.startswith(
        "at oscillator.stops.0.at = -0.2 stops 0 and 1 come to lie at one place"
    )


def test_a_branch_ends_in_the_corner_where_its_walls_leave_no_room() -> None:
    walls = pc.Wall(0.3, "above", 0.7), pc.Wall(-0.3, "below", 0.7)
    orbit = pc.find_orbit(pc.Oscillator(1.0, 0.02, walls), pc.cosine(1.5), 2, 1)

    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (0.3, -0.5)})

    corner = branch.special_points[-1]
    assert (corner.kind, corner.value) == ("corner", -0.3)
    assert corner.row == len(branch) - 1
    assert branch.end_reason == (
        "at oscillator.stops.0.at = -0.3 stops 0 and 1 come to lie at one place"
    )
