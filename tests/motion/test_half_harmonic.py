"""The half-harmonic: formulas against exact runs, against algebra, and against many digits."""

from __future__ import annotations

import importlib
import math
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mp

import percuss as pc
from percuss.motion.half_harmonic import (
    cosine_eigenset_motion,
    half_harmonic_expansion,
    half_harmonic_flight,
    half_harmonic_growth,
    half_harmonic_impact,
    half_harmonic_invariant,
    half_harmonic_two_impacts,
)

PHASES = (0.0, 0.3, 1.0, math.pi / 2, 2.0, 3.0, 4.0, -0.5)


def precise_impact(t: Any, v: Any) -> tuple[Any, Any]:
    """Return the next impact for a large velocity, at the working precision of mpmath."""
    s, c = mpmath.sin(t), mpmath.cos(t)

    def flight(tau: Any) -> Any:
        sin, cos = mpmath.sin(tau), mpmath.cos(tau)
        return (v + tau * s / 2) * sin + c * (sin - tau * cos) / 2

    xi = mpmath.findroot(flight, mp.pi + mp.pi * c / (2 * v))
    sin, cos = mpmath.sin(xi), mpmath.cos(xi)
    return t + xi, -(v * cos + s * (sin + xi * cos) / 2 + c * xi * sin / 2)


@pytest.mark.parametrize("t_k", PHASES)
@pytest.mark.parametrize("v_k", [0.2, 1.0, 5.0, 1e3])
def test_flight_is_that_of_the_simulation(t_k: float, v_k: float) -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(1), t0=t_k, v0=v_k, max_impacts=1)
    elapsed = np.linspace(0.01, 0.99, 7) * run.impacts.intervals[0]

    x, v = half_harmonic_flight(elapsed, t_k, v_k)

    np.testing.assert_allclose(
        np.array([x, v]), np.array(run(t_k + elapsed)), atol=1e-14 * (10 + v_k)
    )


@pytest.mark.parametrize("t_k", PHASES)
@pytest.mark.parametrize("v_k", [0.2, 1.0, 5.0, 1e3])
def test_time_of_flight_solves_the_corrected_equation_and_not_the_printed_one(
    t_k: float, v_k: float
) -> None:
    xi = half_harmonic_impact(t_k, v_k)[0] - t_k
    s, c = math.sin(t_k), math.cos(t_k)

    assert abs(math.sin(xi) * (2 * v_k + c + xi * s) - xi * c * math.cos(xi)) < 1e-12 * (1 + v_k)
    if min(abs(s), abs(c)) > 1e-9:
        assert abs(math.sin(xi) * (2 * v_k + c) - xi * c * math.cos(xi)) > 1e-4


@pytest.mark.parametrize("t_k", PHASES)
def test_expansion_has_the_stated_errors(t_k: float) -> None:
    with mpmath.workdps(40):
        for v in (1e3, 1e4, 1e5):
            exact_t, exact_v = precise_impact(mpmath.mpf(t_k), mpmath.mpf(v))
            t, w = half_harmonic_expansion(t_k, v)
            assert abs(exact_t - float(t)) < 25.0 / v**3 + 1e-14
            assert abs(exact_v - float(w)) < 10.0 / v**2 + 1e-16 * v


@pytest.mark.parametrize("t_k", PHASES)
def test_two_impacts_change_the_velocity_by_the_corrected_term(t_k: float) -> None:
    with mpmath.workdps(40):
        v = mpmath.mpf(10) ** 8
        t, w = precise_impact(*precise_impact(mpmath.mpf(t_k), v))
        gain = v * (w - v)
        assert abs(gain - mpmath.pi / 2 * mpmath.sin(2 * mpmath.mpf(t_k))) < 1e-7
        assert abs(t - 2 * mpmath.pi - t_k) < 10 / v**3
    step = float(half_harmonic_two_impacts(t_k, 100.0)) - 100.0
    assert abs(100.0 * step - math.pi / 2 * math.sin(2 * t_k)) < 1e-10


@pytest.mark.parametrize("t_k", PHASES)
@pytest.mark.parametrize("v_k", [5.0, 10.0, 30.0])
def test_invariant_changes_by_three_over_the_seventh_power(t_k: float, v_k: float) -> None:
    before = half_harmonic_invariant(t_k, v_k)
    after = half_harmonic_invariant(*half_harmonic_impact(t_k, v_k))
    assert abs(after - before) < 3.0 / v_k**7 + 1e-15


def precise_invariant(t: Any, v: Any) -> Any:
    s, c = mpmath.sin(t), mpmath.cos(t)
    line = 4 * v * c / mp.pi * mpmath.atan2(mp.pi * c, 2 * v + mp.pi * s) - 1
    fifth = mp.pi**3 * s**3 * c**4 / 16 / v**5
    return line + fifth + 13 * mp.pi**4 / 288 * s**2 * c**4 * (1 - 4 * s**2) / v**6


@pytest.mark.parametrize("t_k", [0.3, 1.0, 2.0, 4.0])
def test_change_of_the_invariant_falls_with_the_seventh_power(t_k: float) -> None:
    with mpmath.workdps(60):
        changes = []
        for v in (1000, 2000):
            state = (mpmath.mpf(t_k), mpmath.mpf(v))
            changes.append(precise_invariant(*precise_impact(*state)) - precise_invariant(*state))
        assert abs(mpmath.log(abs(changes[0] / changes[1]), 2) - 7) < 0.02


def test_impact_map_preserves_the_area_v_dv_dt() -> None:
    h = 1e-5
    for t, v in ((0.3, 2.0), (2.0, 5.0), (4.0, 1.5)):
        east, west = half_harmonic_impact(t + h, v), half_harmonic_impact(t - h, v)
        north, south = half_harmonic_impact(t, v + h), half_harmonic_impact(t, v - h)
        jacobian = np.array([np.subtract(east, west), np.subtract(north, south)]).T / (2 * h)
        after = half_harmonic_impact(t, v)[1]
        assert abs(np.linalg.det(jacobian) * after / v - 1.0) < 1e-7


def sine_run(v0: float, count: int) -> tuple[Any, Any, Any]:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(1), v0=v0, max_impacts=count)
    return run.impacts.t, run.impacts.v_after, 2 * math.pi * run.impacts.cycle


def test_envelope_from_rest_up_to_a_million_impacts() -> None:
    t, v, phase = sine_run(0.0, 1_000_000)
    laws = [half_harmonic_growth(phase[k], v[k]) for k in (9_999, 99_999, 999_999)]

    assert all(abs(law.constant - 0.590579848926) < 1e-12 for law in laws)
    assert abs(laws[-1].phase - 1.184796711171) < 1e-12
    smooth = np.abs(v * np.exp(1j * phase) + 0.25j * math.pi) ** 2
    rest = smooth - laws[-1].rate * t - laws[-1].logarithm * np.log(t)
    # What is left tends to a constant, while the logarithm alone grows by 0.4 a decade.
    assert abs(rest[99_999] - rest[9_999]) < 2e-3
    assert abs(rest[999_999] - rest[99_999]) < 2e-3
    assert abs(v[-2:].mean() / math.sqrt(t[-1]) - 0.61) > 0.019


@pytest.mark.parametrize("v0", [10.0, 30.0, 100.0])
def test_constant_of_a_fast_start_is_the_closed_form(v0: float) -> None:
    _, v, phase = sine_run(v0, 20_000)
    closed = half_harmonic_growth(0.0, v0).constant

    assert abs(half_harmonic_growth(phase[-1], v[-1]).constant / closed - 1.0) < 1.0 / v0**5 + 1e-11
    leading = math.sqrt(math.pi / (2 * math.sqrt(3) * v0))
    assert abs(closed / leading - 1.0) < 1.0 / v0**2


def test_velocities_fall_in_the_other_half_of_the_phases() -> None:
    law = half_harmonic_growth(2.3, 30.0)
    run = pc.simulate(pc.impact_oscillator(), pc.sine(1), t0=2.3, v0=30.0, max_impacts=400)

    assert law.rate < 0.0
    assert math.isnan(law.constant)
    middle = np.abs(
        run.impacts.v_after * np.exp(2j * math.pi * run.impacts.cycle) + 0.25j * math.pi
    )
    slope = np.polyfit(run.impacts.t, middle**2, 1)[0]
    assert abs(slope / law.rate - 1.0) < 0.01


def test_on_the_eigenset_nothing_grows() -> None:
    law = half_harmonic_growth(math.pi / 2, 3.0)
    assert abs(law.rate) < 1e-7
    assert math.isclose(abs(law.phase), math.pi / 2, abs_tol=1e-7)


@pytest.mark.parametrize("v0", [0.0, 1e-3, 1.0, 50.0])
def test_motion_under_cosine_is_the_closed_form(v0: float) -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.cosine(1), v0=v0, t_end=60.0)
    t = np.linspace(0.05, 59.95, 600)

    x, v = cosine_eigenset_motion(t, v0)

    np.testing.assert_allclose(run(t)[0], x, atol=1e-10)
    np.testing.assert_allclose(run(t)[1], v, atol=1e-10)


def test_rest_under_cosine_touches_at_whole_periods_and_hits_between() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.cosine(1), v0=0, t_end=60.0)

    np.testing.assert_allclose(run.impacts.t, math.pi * (2 * np.arange(10) + 1), atol=1e-12)
    np.testing.assert_allclose(run.impacts.v_after, math.pi / 2, atol=1e-13)
    np.testing.assert_allclose(run.grazes.t, 2 * math.pi * np.arange(1, 10), atol=1e-6)
    assert abs(run(math.pi / 2)[0] - math.pi / 4) < 1e-15


def test_bad_input_is_refused() -> None:
    with pytest.raises(pc.ParameterError, match="not positive"):
        half_harmonic_impact(0.0, 0.0)
    with pytest.raises(pc.ParameterError, match="negative"):
        cosine_eigenset_motion(1.0, -0.1)
    with pytest.raises(pc.ParameterError, match="too small"):
        half_harmonic_growth(1.0, 1e-3)


# Algebra. Where sympy is not installed these are skipped, and reported as such.


def test_symbolic_flight_equation() -> None:
    sp: Any = importlib.import_module("sympy")
    tau, t, v = sp.symbols("tau t v", real=True)
    x = (v + tau / 2 * sp.sin(t)) * sp.sin(tau) + sp.cos(t) / 2 * (sp.sin(tau) - tau * sp.cos(tau))

    assert sp.simplify(sp.expand_trig(sp.diff(x, tau, 2) + x - sp.sin(t + tau))) == 0
    assert (x.subs(tau, 0), sp.simplify(sp.diff(x, tau).subs(tau, 0))) == (0, v)
    right = tau * sp.cos(t) / (2 * v + sp.cos(t) + tau * sp.sin(t))
    numerator = sp.sin(tau) * sp.denom(right) - sp.numer(right) * sp.cos(tau)
    assert sp.expand(2 * x - numerator) == 0


def test_symbolic_two_impacts() -> None:
    sp: Any = importlib.import_module("sympy")
    t, u = sp.symbols("t u")  # u = 1/V

    def impact(phase: Any, small: Any) -> tuple[Any, Any]:
        """Return how late the next impact is after half a turn, and the gain of the velocity."""
        s, c = sp.sin(phase), sp.cos(phase)
        delta = sp.pi / 2 * c * small - sp.pi**2 / 4 * s * c * small**2
        return delta, sp.pi / 2 * (s + (s + sp.pi / 4 * c) * c * small)

    # The expansion solves the equation of flight to its order ...
    delta, gain = impact(t, u)
    s, c = sp.sin(t), sp.cos(t)
    flown = (sp.pi + delta) * u
    equation = sp.tan(delta) * (2 + u * c + flown * s) - flown * c
    # (its coefficients of Taylor, for `series` takes thirty times as long)
    for order in range(3):
        assert sp.simplify(sp.diff(equation, u, order).subs(u, 0)) == 0
    # ... and twice in a row gives the corrected (33).
    twice = gain + impact(t + sp.pi + delta, u / (1 + u * gain))[1]
    assert sp.simplify(twice.subs(u, 0)) == 0
    assert sp.simplify(sp.diff(twice, u).subs(u, 0) - sp.pi / 2 * sp.sin(2 * t)) == 0


def test_symbolic_logarithm_of_the_envelope() -> None:
    sp: Any = importlib.import_module("sympy")
    psi, x, y, q = sp.symbols("psi x y q", real=True)
    # E = |W|^2 / 2, H = K + kappa / E, from the mean of cos 2 theta along a line of length pi/2.
    bend = sp.diff((x**2 - y**2) / (x**2 + y**2), y, 2) * sp.pi**2 / 96
    radius = sp.symbols("radius", positive=True)
    bent = bend.subs({x: radius * sp.cos(psi), y: radius * sp.sin(psi)})
    kappa = sp.simplify(-bent * radius**2 / 2 / 8)
    k = -sp.cos(2 * psi) / 8
    slope = sp.diff(k, psi)
    per_time = (sp.diff(kappa, psi) - sp.diff(slope, psi) * kappa / slope) / slope
    stated = -(sp.pi**2) / 48 * (1 + 3 * q - 2 * q**3) / (1 - q**2)
    assert sp.simplify(2 * per_time - stated.subs(q, sp.cos(2 * psi))) == 0
