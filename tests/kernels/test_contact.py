from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.kernels.uncompiled import python_of
from tests.oracle.event_driven import Wall, restitution_of
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.contact import chatter_time, fine_force, fine_tolerance, release_time
from percuss.kernels.flight import set_phases
from percuss.kernels.law_columns import FIRST_HARMONIC, LOWER_FORCE, TURNS, TURNS_LOW, Law
from percuss.model.system import law as law_of

# mpmath has no types.
Real = Any

# So fast an earlier impact that any speed counts as the tail of a chatter.
FAST = 1e30


def wall_and_phases(
    osc: pc.Oscillator, force: pc.Forcing, t: float
) -> tuple[Law, int, float, Floats]:
    """Return the law, its one region, the constant force at the wall below, and the phases."""
    law = law_of(osc, force)
    n = len(force.harmonics)
    phases = np.empty((n, 2))
    set_phases(law, t, 0.0, phases)
    region = FIRST_HARMONIC + n
    return law, region, float(law[region, LOWER_FORCE]), phases


CHATTERS = given(
    restitution=st.floats(0.01, 0.99),
    damping=st.sampled_from([0.0, 0.05, 1.0, 3.0]),
    stiffness=st.sampled_from([-1.0, 0.0, 1.0, 20.0]),
    wall=st.sampled_from([0.0, -0.7]),
    amplitude=st.floats(0.0, 0.8),
    omega=st.floats(0.1, 9.0),
    phase=st.floats(0.0, 6.3),
    smallness=st.floats(-10.0, -5.0),
)


@CHATTERS
@settings(max_examples=20)
def test_sum_of_a_chatter_lies_within_its_error_bound(**drawn: float) -> None:
    assert_within_its_bound(**drawn)


@pytest.mark.nightly
@CHATTERS
@settings(max_examples=60)
def test_sums_of_more_chatters_lie_within_their_error_bounds(**drawn: float) -> None:
    assert_within_its_bound(**drawn)


def assert_within_its_bound(
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
    # The slowest of these hops are a chatter's tail in every case.
    check_sum(
        osc, force, restitution, 10.0**smallness * (1.0 - restitution), may_fail=smallness > -7.0
    )


@given(
    at_rest=st.floats(0.05, 0.95),
    change=st.floats(-0.9, 0.9),
    scale=st.floats(-3.0, 3.0),
    first=st.booleans(),
    damping=st.sampled_from([-0.2, 0.0, 1.0]),
    amplitude=st.floats(0.0, 0.8),
    omega=st.floats(0.1, 9.0),
    phase=st.floats(0.0, 6.3),
    smallness=st.floats(-10.0, -5.0),
)
@settings(max_examples=60)
def test_sum_of_a_chatter_holds_for_restitutions_that_change_with_the_speed(
    at_rest: float,
    change: float,
    scale: float,
    *,
    first: bool,
    damping: float,
    amplitude: float,
    omega: float,
    phase: float,
    smallness: float,
) -> None:
    """From rest on, or constant up to a speed that the hops may or may not reach."""
    second = at_rest + (change if 0.02 < at_rest + change <= 1.0 else -0.3 * at_rest)
    second = max(second, 0.6 * at_rest)
    scale = 10.0**scale
    speeds = (0.0, scale) if first else (1e-7 * scale, scale)
    table = pc.restitution_table(speeds, (at_rest, second))
    osc = pc.impact_oscillator(table, damping=damping)
    force = pc.cosine(omega, amplitude=amplitude, phase=phase, constant=-2.0)
    speed = 10.0**smallness * (1.0 - at_rest)
    may_fail = smallness > -7.0 or scale < 100.0 * speed or not first or scale < 0.1
    check_sum(osc, force, at_rest, speed, may_fail=may_fail)


def check_sum(
    osc: pc.Oscillator, force: pc.Forcing, restitution: float, speed: float, *, may_fail: bool
) -> None:
    """Compare the sum of a chatter, if the kernel finds one, with its hops one by one."""
    law, region, constant, phases = wall_and_phases(osc, force, 0.0)

    time, error = chatter_time(law, region, -1.0, speed, FAST, constant, phases)

    if time < 0.0:
        assert may_fail
        return
    assert 0.0 < error <= 1e-9 * time
    with mpmath.workdps(40):
        exact = time_of_hops(osc, force, restitution, speed)
        assert abs(time - exact) <= error


def time_of_hops(osc: pc.Oscillator, force: pc.Forcing, restitution: float, speed: float) -> Real:
    """Return the time that all hops take, one by one until the next are of no account.

    ``restitution`` is that of the slowest.
    """
    (wall,) = problem_of(osc).stops
    assert isinstance(wall, Wall)
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
        landing = sum(n * c * h ** (n - 1) for n, c in enumerate(series) if n > 0)
        v = -restitution_of(wall, -landing) * landing
    # What is left is a geometric series to the twelfth digit of the last part of 1e-12.
    return t + 2 * v / (2 - part.cos * mpmath.cos(w * t) - part.sin * mpmath.sin(w * t)) / (1 - r)


def test_hops_are_no_chatter_where_nothing_presses_or_nothing_is_lost() -> None:
    force = pc.sine(1.0)
    for t, restitution in ((0.0, 0.5), (1.0, 0.5), (4.0, 1.0)):
        osc = pc.impact_oscillator(restitution)
        law, region, constant, phases = wall_and_phases(osc, force, t)

        time, _ = chatter_time(law, region, -1.0, 1e-9, FAST, constant, phases)

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
    law, _, at_wall, phases = wall_and_phases(osc, force, start)

    s = 0.0
    released = False
    while not released and s < math.inf:
        released, s, _ = release_time(law, 1.0, at_wall, (start, 0.0), s, math.inf, phases)

    assert released
    # The phase is known to an ulp of the double `start`; the force's rounding by its slope.
    slope = omega * math.sqrt(1.0 - constant**2)
    assert s == pytest.approx(expected, abs=math.ulp(start) + 1e-14 / slope, rel=1e-14)


@pytest.mark.parametrize("start", [0.0, 1.0, 2.0 * math.pi])
def test_force_that_only_touches_zero_does_not_release(start: float) -> None:
    """f = cos(t) - 1 is zero at each period and positive never."""
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-1.0)
    law, _, at_wall, phases = wall_and_phases(osc, force, start)

    released, s, _ = release_time(law, 1.0, at_wall, (start, 0.0), 0.0, math.inf, phases)

    assert (released, s) == (False, math.inf)


def test_contact_begun_at_a_zero_of_the_force_lasts_to_the_next_one() -> None:
    """f = -sin(t) presses from t = 0 on."""
    osc, force = pc.impact_oscillator(0.5), pc.sine(1.0, amplitude=-1.0)
    law, _, at_wall, phases = wall_and_phases(osc, force, 0.0)

    released, s, _ = release_time(law, 1.0, at_wall, (0.0, 0.0), 0.0, math.inf, phases)

    assert released
    assert s == pytest.approx(math.pi, rel=1e-15)


def flat_zero(order: int, depth: float, sign: float = 1.0) -> tuple[pc.Forcing, Real]:
    """Return sign ((2 sin(t / 2))^order - depth) as doubles have it, and its zero after t = 0."""
    half = order // 2
    cosines = tuple(sign * 2.0 * (-1) ** k * math.comb(order, half - k) for k in range(1, half + 1))
    middle = math.comb(order, half)
    force = pc.fourier(1.0, cos=cosines, constant=sign * (middle - depth))
    with mpmath.workdps(60):
        left = middle - mpmath.mpf(middle - depth)
        return force, 2 * mpmath.asin(mpmath.root(left, order) / 2)


DEPTHS = [1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10]


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_release_at_a_flat_zero_of_the_force_is_where_it_pulls(order: int, depth: float) -> None:
    """From rest in the dip the wall holds for a moment, whatever doubles make of the force."""
    force, zero = flat_zero(order, depth)
    run = pc.simulate(pc.impact_oscillator(0.5), force, t_end=3.0)

    assert len(run.impacts) == 0
    # A depth that is lost in the constant leaves a force that never presses.
    assert len(run.contacts) == (1 if zero > 0 else 0)
    for release in run.contacts.release:
        assert release == pytest.approx(float(zero), rel=1e-6)
    with mpmath.workdps(30):
        assert float(run(3.0)[0]) == pytest.approx(float(risen(force, zero, 3)), rel=1e-9)


def risen(force: pc.Forcing, t0: Real, t: Real) -> Real:
    """Return where x'' + x = force leads by t, from rest at 0 at t0."""
    x = force.constant * (1 - mpmath.cos(t - t0))
    for part in force.components():
        w = round(float(part.omega))
        if w == 1:
            s = t - t0
            x += part.cos * (s * mpmath.sin(t) - mpmath.sin(t0) * mpmath.sin(s)) / 2
        else:
            steady = [mpmath.cos(w * t), mpmath.cos(w * t0), -w * mpmath.sin(w * t0)]
            free = steady[1] * mpmath.cos(t - t0) + steady[2] * mpmath.sin(t - t0)
            x += part.cos * (steady[0] - free) / (1 - w * w)
    return x


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_wall_lets_go_at_a_flat_crest_of_the_force_only_where_it_pulls(
    order: int, depth: float
) -> None:
    """The same from the other side: pressed but for a crest of this height, or not even there."""
    below, zero = flat_zero(order, depth, -1.0)
    above, _ = flat_zero(order, -depth, -1.0)

    crest, miss = (
        pc.simulate(pc.impact_oscillator(0.5), f, t0=-2.0, t_end=3.0) for f in (below, above)
    )

    assert np.isnan(miss.contacts.release).tolist() == [True]
    assert len(crest.contacts) == (2 if zero > 0 else 1)
    assert math.isnan(crest.contacts.release[-1])
    for release in crest.contacts.release[:-1]:
        assert release == pytest.approx(-float(zero), rel=1e-5)
    # Hops there are: as fast as depth and time make them, or lost in rounding and not counted.
    fastest = np.abs(crest.impacts.v_before[:1]) / (depth * float(zero) + 1e-300)
    assert ((fastest > order) & (fastest < 4.0 * order)).all()
    assert len(crest.impacts) == 0 or depth > 1e-14


@pytest.mark.parametrize("t_end", [6.0, 1e7])
def test_wall_does_not_hold_a_mass_that_it_would_have_to_pull(t_end: float) -> None:
    force = pc.fourier(1.0, cos=(-4.0, 1.0), constant=3.0 - 1e-15)
    run = pc.simulate(pc.impact_oscillator(0.5), force, t_end=t_end, max_impacts=10)

    assert run.contacts.release[0] == pytest.approx(2.05297e-4, rel=1e-5)
    assert float(run(3.0)[0]) == pytest.approx(4.4732, rel=1e-5)


@given(
    omega=st.floats(1e-3, 1e3),
    t=st.floats(-1e6, 1e6),
    low=st.floats(-1.0, 1.0),
    order=st.integers(0, 9),
)
@settings(max_examples=40)
def test_force_in_pairs_of_doubles_is_within_its_tolerance(
    omega: float, t: float, low: float, order: int
) -> None:
    force = pc.cosine(omega, constant=-0.75) + pc.sine(3.0 * omega, amplitude=0.3)
    law = law_of(pc.impact_oscillator(), force)
    instant = (t, low * math.ulp(t) / 2)

    computed = python_of(fine_force)(law, -0.75, instant, order)

    with mpmath.workdps(80):
        at = mpmath.mpf(instant[0]) + instant[1]
        exact = mpmath.mpf(-0.75 if order == 0 else 0)
        for row, part in enumerate(force.components()):
            rate = mpmath.mpf(law[FIRST_HARMONIC + row, TURNS])
            w = 2 * mpmath.pi * (rate + law[FIRST_HARMONIC + row, TURNS_LOW])
            turn = w * at + order * mpmath.pi / 2
            exact += w**order * (part.cos * mpmath.cos(turn) + part.sin * mpmath.sin(turn))
        error = abs(computed - exact)
    # Besides, the result is a double.
    assert error <= fine_tolerance(law, -0.75, instant, order) + abs(computed) * 2.0**-52


def test_plain_python_gives_the_bits_of_the_machine_code() -> None:
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.7, constant=-1.2)
    law, region, at_wall, phases = wall_and_phases(osc, force, 1.0)
    chatter = (law, region, -1.0, 1e-8, FAST, at_wall, phases)
    contact = (law, 1.0, at_wall, (1.0, 0.0), 0.0, 1e9, phases)

    assert python_of(chatter_time)(*chatter) == chatter_time(*chatter)
    assert python_of(release_time)(*contact) == release_time(*contact)
