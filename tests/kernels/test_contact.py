from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.kernels.uncompiled import python_of

import percuss as pc
from percuss.kernels.contact import chatter_time, release_time
from percuss.kernels.flight import set_phases
from percuss.kernels.law import FIRST_HARMONIC, LOWER_FORCE, Law, Table
from percuss.model.law import law

# mpmath has no types.
Real = Any

# So fast an earlier impact that any speed counts as the tail of a chatter.
FAST = 1e30


def wall_and_phases(
    osc: pc.Oscillator, force: pc.Forcing, t: float
) -> tuple[Law, int, float, Table]:
    """Return the law, its one region, the constant force at the wall below, and the phases."""
    table = law(osc, force)
    n = len(force.harmonics)
    phases = np.empty((n, 2))
    set_phases(table, t, 0.0, phases)
    region = FIRST_HARMONIC + n
    return table, region, float(table[region, LOWER_FORCE]), phases


@given(
    restitution=st.floats(0.01, 0.99),
    damping=st.sampled_from([0.0, 0.05, 1.0, 3.0]),
    stiffness=st.sampled_from([-1.0, 0.0, 1.0, 20.0]),
    wall=st.sampled_from([0.0, -0.7]),
    amplitude=st.floats(0.0, 0.8),
    omega=st.floats(0.1, 9.0),
    phase=st.floats(0.0, 6.3),
    smallness=st.floats(-10.0, -5.0),
)
@settings(max_examples=60)
def test_sum_of_a_chatter_lies_within_its_error_bound(
    restitution: float,
    damping: float,
    stiffness: float,
    wall: float,
    amplitude: float,
    omega: float,
    phase: float,
    smallness: float,
) -> None:
    osc = pc.impact_oscillator(restitution, wall=wall, stiffness=stiffness, damping=damping)
    force = pc.cosine(omega, amplitude=amplitude, phase=phase, constant=-2.0 + stiffness * wall)
    table, region, constant, phases = wall_and_phases(osc, force, 0.0)
    speed = 10.0**smallness * (1.0 - restitution)

    time, error = chatter_time(table, region, -1.0, restitution, speed, FAST, constant, phases)

    if time < 0.0:
        assert smallness > -7.0, "the slowest of these hops are a chatter's tail in every case"
        return
    assert 0.0 < error <= 1e-9 * time
    with mpmath.workdps(40):
        exact = time_of_hops(osc, force, restitution, speed)
        assert abs(time - exact) <= error


def time_of_hops(osc: pc.Oscillator, force: pc.Forcing, restitution: float, speed: float) -> Real:
    """Return the time that all hops take, one by one until the next are of no account."""
    (part,) = force.components()
    a, K = mpmath.mpf(float(osc.damping)), mpmath.mpf(float(osc.stiffness))
    w = mpmath.mpf(float(part.omega))
    constant = mpmath.mpf(-2.0)
    t, v, r = mpmath.mpf(0), mpmath.mpf(speed), mpmath.mpf(restitution)
    while v > 1e-12 * speed:
        turn = part.cos * mpmath.cos(w * t) + part.sin * mpmath.sin(w * t)
        slope = w * (part.sin * mpmath.cos(w * t) - part.cos * mpmath.sin(w * t))
        forces = [constant + turn, slope, -w * w * turn, -w * w * slope, w**4 * turn]
        derivatives = [mpmath.mpf(0), v]
        for order, value in enumerate(forces):
            derivatives.append(value - 2 * a * derivatives[order + 1] - K * derivatives[order])
        series = [d / mpmath.factorial(n) for n, d in enumerate(derivatives)]
        # The displacement is h times this; what is neglected is (h pace)^6 of it, below 1e-25.
        h = 2 * v / -forces[0]
        for _ in range(6):
            value = sum(c * h**n for n, c in enumerate(series[1:]))
            h -= value / sum(n * c * h ** (n - 1) for n, c in enumerate(series[1:]) if n > 0)
        t += h
        v = -r * sum(n * c * h ** (n - 1) for n, c in enumerate(series) if n > 0)
    # What is left is a geometric series to the twelfth digit of the last part of 1e-12.
    return t + 2 * v / (2 - part.cos * mpmath.cos(w * t) - part.sin * mpmath.sin(w * t)) / (1 - r)


def test_hops_are_no_chatter_where_nothing_presses_or_nothing_is_lost() -> None:
    osc, force = pc.impact_oscillator(0.5), pc.sine(1.0)
    for t, restitution in ((0.0, 0.5), (1.0, 0.5), (4.0, 1.0)):
        table, region, constant, phases = wall_and_phases(osc, force, t)

        time, _ = chatter_time(table, region, -1.0, restitution, 1e-9, FAST, constant, phases)

        assert time == -1.0


@given(omega=st.floats(0.05, 20.0), constant=st.floats(-0.99, -0.01), t=st.floats(0.0, 1e4))
@settings(max_examples=60)
def test_release_is_where_the_force_next_changes_sign(
    omega: float, constant: float, t: float
) -> None:
    """f = constant + cos(omega t) is contact until cos(omega t) = -constant on its way up."""
    osc, force = pc.impact_oscillator(0.5), pc.cosine(omega, constant=constant)
    with mpmath.workdps(40):
        quarter = mpmath.acos(-mpmath.mpf(constant)) / omega
        period = 2 * mpmath.pi / omega
        begin = t - mpmath.mpf(t) % period + quarter
        expected = period - 2 * quarter
    start = float(begin + 1e-3 * expected)
    with mpmath.workdps(40):
        expected = float(begin + expected - mpmath.mpf(start))
    table, _, at_wall, phases = wall_and_phases(osc, force, start)

    s = 0.0
    released = False
    while not released and s < math.inf:
        released, s, _ = release_time(table, 1.0, at_wall, (start, 0.0), s, math.inf, phases)

    assert released
    # The phase is known to an ulp of the double `start`; the force's rounding by its slope.
    slope = omega * math.sqrt(1.0 - constant**2)
    assert s == pytest.approx(expected, abs=math.ulp(start) + 1e-14 / slope, rel=1e-14)


@pytest.mark.parametrize("start", [0.0, 1.0, 2.0 * math.pi])
def test_force_that_only_touches_zero_does_not_release(start: float) -> None:
    """f = cos(t) - 1 is zero at each period and positive never."""
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-1.0)
    table, _, at_wall, phases = wall_and_phases(osc, force, start)

    released, s, _ = release_time(table, 1.0, at_wall, (start, 0.0), 0.0, math.inf, phases)

    assert (released, s) == (False, math.inf)


def test_contact_begun_at_a_zero_of_the_force_lasts_to_the_next_one() -> None:
    """f = -sin(t) presses from t = 0 on."""
    osc, force = pc.impact_oscillator(0.5), pc.sine(1.0, amplitude=-1.0)
    table, _, at_wall, phases = wall_and_phases(osc, force, 0.0)

    released, s, _ = release_time(table, 1.0, at_wall, (0.0, 0.0), 0.0, math.inf, phases)

    assert released
    assert s == pytest.approx(math.pi, rel=1e-15)


def test_plain_python_gives_the_bits_of_the_machine_code() -> None:
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.7, constant=-1.2)
    table, region, at_wall, phases = wall_and_phases(osc, force, 1.0)
    chatter = (table, region, -1.0, 0.8, 1e-8, FAST, at_wall, phases)
    contact = (table, 1.0, at_wall, (1.0, 0.0), 0.0, 1e9, phases)

    assert python_of(chatter_time)(*chatter) == chatter_time(*chatter)
    assert python_of(release_time)(*contact) == release_time(*contact)
