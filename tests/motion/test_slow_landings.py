"""Landings at zero speed: decided by the derivatives of the flight, not by its rounding."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from tests.kernels.test_batch import follow

import percuss as pc
from percuss.kernels import observables

# x'' + x of x = sin(t)^n for odd n: a landing at zero speed at pi, of order n.
ODD_POWERS = {
    3: (0.0, 0.0, 2.0),
    5: (0.0, 0.0, 40 / 16, 0.0, -24 / 16),
    7: (0.0, 0.0, 168 / 64, 0.0, -168 / 64, 0.0, 48 / 64),
}


def power(order: int, size: float = 1.0, stiffness: float = 1.0, wall: float = 0.0) -> pc.Forcing:
    sines = tuple(size * part for part in ODD_POWERS[order])
    return pc.fourier(1.0, sin=sines, constant=stiffness * wall)


@pytest.mark.parametrize("restitution", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("size", [1.0, 2.0**-40, 2.0**-230, 2.0**70])
@pytest.mark.parametrize("order", ODD_POWERS)
def test_a_landing_at_zero_speed_is_a_contact_and_no_impact(
    order: int, size: float, restitution: float
) -> None:
    run = pc.simulate(pc.impact_oscillator(restitution), power(order, size), t_end=30.0)

    assert len(run.impacts) == 0
    # Held from pi until the force lets go, and a flight of half a period again.
    assert len(run.contacts) == 7
    first = run.contacts.start[0]
    assert abs(first - math.pi) <= run.contacts.error_bound[0]
    assert abs(first - math.pi) <= 1e-15 ** (1 / order)
    assert first < run.contacts.release[0]
    sines = np.sin(np.linspace(0.1, 3.0, 30)) ** order
    np.testing.assert_allclose(run(np.linspace(0.1, 3.0, 30))[0], size * sines, atol=2e-15 * size)
    assert float(run(3.5)[0]) == 0.0


@pytest.mark.parametrize("wall", [0.0, 1.0, -2.5])
def test_a_landing_at_zero_speed_is_the_same_at_any_wall_of_either_side(wall: float) -> None:
    walls = (pc.Wall(wall, "below", 1.0), pc.Wall(wall, "above", 1.0))
    for stop, size in zip(walls, (1.0, -1.0), strict=True):
        osc = pc.Oscillator(1.0, 0.0, (stop,))
        run = pc.simulate(osc, power(3, size, wall=wall), x0=wall, t_end=5.0)

        assert len(run.impacts) == 0
        np.testing.assert_allclose(run.contacts.start, [math.pi], rtol=1e-9)
        np.testing.assert_allclose(run.contacts.release, [4.0 * math.pi / 3.0], rtol=1e-13)


def test_a_landing_at_zero_speed_is_the_same_from_anywhere_on_the_way() -> None:
    """From within the flight, with rounding carried in its start."""
    for t0 in (0.5, 1.0, 2.0, 3.0):
        x0, v0 = math.sin(t0) ** 3, 3.0 * math.sin(t0) ** 2 * math.cos(t0)
        run = pc.simulate(pc.impact_oscillator(), power(3), x0, v0, t0, t_end=9.0)

        assert len(run.impacts) == 0
        assert len(run.contacts) == 2


@pytest.mark.parametrize("size", [1e-3, 1e-12, 1e-70])
def test_slow_hops_that_are_known_stay_impacts(size: float) -> None:
    """Hops on an elastic wall start on it, and are known to their own digits at any size."""
    run = pc.simulate(pc.impact_oscillator(), pc.Forcing(constant=-1.0), v0=size, max_impacts=500)
    pressed = pc.cosine(0.5, amplitude=-1.0)
    forced = pc.simulate(pc.impact_oscillator(), pressed, v0=size, max_impacts=50)

    np.testing.assert_allclose(np.abs(run.impacts.v_before), size, rtol=1e-12)
    np.testing.assert_allclose(forced.impacts.intervals[:9], 2.0 * size, rtol=0.1 * size + 1e-12)
    assert len(run.contacts) == len(forced.contacts) == len(run.grazes) == 0


@pytest.mark.parametrize("miss", [1e-8, 1e-6, 1e-4])
def test_a_landing_faster_than_its_rounding_stays_an_impact(miss: float) -> None:
    """sin(t)^3 - miss sin(t) comes to the wall a little before pi, at a speed of 2 miss.

    Without the wall it would pass by 0.38 miss^1.5 and come back.
    """
    lands = math.pi - math.asin(math.sqrt(miss))

    run = pc.simulate(pc.impact_oscillator(0.0), power(3), 1.0 - miss, 0.0, math.pi / 2, t_end=3.5)

    assert len(run.impacts) >= 1
    assert run.impacts.v_before[0] == pytest.approx(-2.0 * miss, rel=1e-3 + 4.0 * miss)
    assert run.impacts.t[0] == pytest.approx(lands, abs=2e-15 / miss + 1e-14)


@pytest.mark.parametrize("miss", [0.0, 1e-12, 1e-10])
def test_a_dip_within_rounding_is_a_contact(miss: float) -> None:
    run = pc.simulate(pc.impact_oscillator(), power(3), 1.0 - miss, 0.0, math.pi / 2, t_end=4.0)

    assert len(run.impacts) == 0
    assert len(run.contacts) == 1
    assert abs(run.contacts.start[0] - math.pi) <= run.contacts.error_bound[0] < 1e-4


def test_motions_come_to_rest_where_the_run_does() -> None:
    osc, force = pc.impact_oscillator(0.5), power(3)
    starts = np.array([[math.sin(t) ** 3, 3 * math.sin(t) ** 2 * math.cos(t), t] for t in (0, 1)])
    starts = np.repeat(starts, 10, axis=0)
    for section in (observables.STROBES, observables.IMPACT_POINTS, observables.TANGENTS):
        motions = follow(osc, force, starts, 30.0, section=section, n_points=4, with_extremes=True)

        for start, values in zip(starts, motions.values, strict=True):
            run = pc.simulate(osc, force, *start, t_end=30.0)
            assert values[observables.IMPACTS] == len(run.impacts) == 0
            assert values[observables.CONTACTS] == len(run.contacts) == 7
            ends = values[[observables.END_X, observables.END_V]]
            np.testing.assert_allclose(ends, np.array(run(30.0)), rtol=0, atol=1e-14)


def test_slow_landings_between_near_walls_keep_their_digits() -> None:
    """Where a force turns within the flight, its jerk bends the landing as much as its speed."""
    random = np.random.default_rng(1755)
    amplitude, omega = 1.4875363250385083, 0.655239981219691
    worst, landings = 0.0, 0
    with mp.workdps(50):
        for _ in range(400):
            # How long a flight lasts, and how much of it is the jerk's.
            duration, part = (10.0 ** random.uniform(*powers) for powers in ((-7, -1), (-8, -1)))
            v0 = float(amplitude * omega * duration**2 / (6.0 * part))
            gap = float(v0 * duration)
            phase = float(random.choice([-math.pi / 2, math.pi / 2, random.uniform(-3.0, 3.0)]))
            osc = pc.Oscillator(
                stiffness=0, stops=(pc.Wall(0, "below", 1.0), pc.Wall(gap, "above", 1.0))
            )
            force = pc.cosine(omega, amplitude=amplitude, phase=phase)
            impacts = pc.simulate(osc, force, 0.0, v0, max_impacts=1, t_end=2.0).impacts
            if not len(impacts) or impacts.stop[0] != 1:
                continue
            s, v = float(impacts.t[0]), float(impacts.v_before[0])
            missed = gap_left(mp.mpf(s), v0, amplitude, omega, phase, gap)
            # What rounding may move the landing by: sixteen units of the terms of the flight.
            allowed = 16 * 2.0**-52 * (v0 * s + amplitude * s * s) + 2.0**-52 * s * v
            worst, landings = max(worst, abs(float(missed)) / allowed), landings + 1

    assert landings > 200
    assert worst < 1.0


def gap_left(s: Any, v0: float, amplitude: float, omega: float, phase: float, gap: float) -> Any:
    """Return how far the wall is off after a flight without a spring, to 50 digits."""
    a, w, p = mp.mpf(amplitude), mp.mpf(omega), mp.mpf(phase)
    bend = (mp.cos(p) - mp.cos(p + w * s)) / w**2 - mp.sin(p) * s / w
    return mp.mpf(gap) - v0 * s - a * bend
