"""Attempts to break the inequalities of docs/theory: by exact rationals, and by many digits."""

from __future__ import annotations

import math
import random
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from tests.kernels.exact_flight import Rest

import percuss as pc
from percuss.kernels.arithmetic import cubic_minimum
from percuss.kernels.flight import (
    Flight,
    acceleration_and_jerk,
    derivative_bound,
    four_derivatives,
    move,
    uncertainty,
)
from percuss.kernels.law_columns import FIRST_HARMONIC, FORCE_BOUND, QUICKEST, STEP
from percuss.model.system import law as law_of

ROUNDED = 1e-12


def bernstein(k: int, tau: Fraction) -> Fraction:
    return math.comb(3, k) * tau**k * (1 - tau) ** (3 - k)


def test_the_quartic_remainder_lies_below_the_bernstein_polynomials_that_pay_for_it() -> None:
    for i in range(1025):
        tau = Fraction(i, 1024)
        remainder = tau**2 * (1 - tau) ** 2
        assert remainder <= Fraction(1, 16)
        assert remainder <= bernstein(1, tau) / 3
        assert remainder <= (bernstein(1, tau) + bernstein(2, tau)) / 12
        # What pays for the rounding of the bound on the first step.
        assert tau * bernstein(1, tau) <= bernstein(2, tau)
    half = Fraction(1, 2)
    assert half**4 == Fraction(1, 16) == (bernstein(1, half) + bernstein(2, half)) / 12


@pytest.mark.parametrize("first", [True, False])
def test_a_quartic_at_the_limit_of_the_test_has_no_root_before_its_last(first: bool) -> None:
    """The worst fourth derivative there is, with both inner coefficients at the limit."""
    fourth = Fraction(24)
    limit = fourth / (72 if first else 288)
    for sign in (-1, 1):
        for i in range(1, 256):
            tau = Fraction(i, 256)
            inner = limit * (bernstein(1, tau) + (0 if first else bernstein(2, tau)))
            assert inner + sign * fourth / 24 * tau**2 * (1 - tau) ** 2 >= 0


def test_no_cubic_goes_below_its_minimum() -> None:
    """Also one that first rises, turns to a minimum, and rises to its end."""
    draw = random.Random(1)
    taus = np.linspace(0.0, 1.0, 201)
    # A derivative with two zeros in (0, 1), among them the cubic of a dip behind a crest.
    cubics = [(0.1, 0.8, 1.0)]
    cubics += [(draw.uniform(-1, 2), draw.uniform(-1, 2), draw.gauss(0, 1)) for _ in range(2000)]
    for first, second, size in cubics:
        values = size * taus * (first * second + taus * (-(first + second) / 2 + taus / 3))
        slopes = size * first * second, size * (1 - first) * (1 - second)

        lowest = cubic_minimum(0.0, slopes[0], float(values[-1]), slopes[1])

        assert lowest <= values.min() + 1e-14
        assert lowest >= values.min() - 2e-4 * abs(size)


@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize("stiffness", [0.0, 0.01, 0.2])
def test_a_dip_that_a_crest_hides_within_one_step_is_an_impact(
    stiffness: float, restitution: float
) -> None:
    """The mass rises at first, dips below the wall, and would be above at the step's end."""
    oscillator = pc.impact_oscillator(restitution, stiffness=stiffness)
    v0 = math.cos(0.35) - math.cos(0.49)

    run = pc.simulate(oscillator, pc.sine(1.0), x0=0.0236, v0=v0, t0=-0.49, t_end=0.9)

    assert len(run.impacts) == 1
    assert run(np.linspace(-0.49, 0.9, 500))[0].min() >= -ROUNDED


@pytest.mark.parametrize("damping", [0.0, 0.05, 1.0, 5.0])
@pytest.mark.parametrize("stiffness", [-2.0, -0.01, 0.0, 1e-6, 1.0, 50.0])
def test_several_harmonics_stay_within_the_bounds_of_their_derivatives(
    stiffness: float, damping: float
) -> None:
    draw = random.Random(2)
    for _ in range(8):
        harmonics = [
            pc.Harmonic(draw.gauss(0, 1), 10 ** draw.uniform(-1, 1), draw.uniform(0, 6))
            for _ in range(3)
        ]
        law = law_of(pc.Oscillator(stiffness, damping), pc.Forcing(tuple(harmonics)))
        region = FIRST_HARMONIC + 3
        step = float(law[region, STEP])
        phases, arrival = np.array([[1.0, 0.0]] * 3), np.empty((3, 2))
        v, force = draw.gauss(0, 10 ** draw.uniform(-3, 1)), draw.gauss(0, 3)
        second, third = acceleration_and_jerk(law, region, force, phases, 0.0, v)
        bound = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, step)
        for s in np.linspace(0.0, step, 9):
            y, speed = move(Flight(law, region, (0.0, 0.0, v, force), phases, arrival), float(s))
            *_, fourth, _ = four_derivatives(law, region, force, arrival, y, speed)
            assert abs(fourth) <= bound * (1.0 + ROUNDED)


def test_a_series_whose_terms_vanish_two_in_a_row_is_summed_to_its_end() -> None:
    """K = -w^2: the force's terms and the spring's cancel in the fourth and fifth order."""
    rest = Rest(-1.0, 0.0)
    arrival = np.empty((1, 2))
    for s in (0.01, 0.1, 0.24, 0.49):
        with mpmath.workdps(40):
            exact = rest.harmonic(s)
        for phase, part in (((1.0, 0.0), exact.real), ((0.0, -1.0), exact.imag)):
            start = (0.0, 0.0, 0.0, 0.0)
            y, _ = move(Flight(rest.law, rest.region, start, np.array([phase]), arrival), s)
            assert abs(y - float(part)) <= 1e-15 * abs(exact)


def test_no_displacement_is_off_by_more_than_its_uncertainty() -> None:
    """Where the closed forms cancel most: just above the series, and next to whole periods."""
    draw = random.Random(3)
    for _ in range(1500):
        stiffness = draw.choice([1.0, 0.0, -1.0, draw.uniform(0, 2), 10 ** draw.uniform(-6, 0)])
        damping = draw.choice([0.0, 0.1, 1.0, draw.uniform(0, 2), 10 ** draw.uniform(-18, 0)])
        omega = draw.choice([1.0, draw.uniform(0.5, 1.5), 10 ** draw.uniform(-3, 1)])
        rest = Rest(stiffness, damping, omega)
        law, region = rest.law, rest.region
        period = 2 * math.pi * draw.randint(1, 4) * (1 + 10 ** draw.uniform(-17, -3))
        phase = draw.choice([draw.uniform(0.5, 1.0), 10 ** draw.uniform(-1, 1.2), period])
        s = phase / max(float(law[region, QUICKEST]), omega)
        force, v0 = draw.choice([(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.0, 0.0)])
        turn = draw.choice([0.0, 1.0])
        phases = np.array([[1.0 - turn, -turn]])
        start = (0.0, 0.0, v0, force)
        flight = Flight(law, region, start, phases, np.empty((1, 2)))
        y, _ = move(flight, s)
        with mpmath.workdps(80):
            impulse, _, rise = rest.free(s)
            harmonic = rest.harmonic(s)
            part = harmonic.imag if turn else harmonic.real
            error = abs(y - (v0 * impulse + force * rise + part))
        assert error <= uncertainty(flight, s), (rest, s, start, phases)


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.8, 0.95])
@pytest.mark.parametrize("pull", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.4), (-1.0, 1.0, 0.5)])
def test_the_sum_of_a_chatter_is_off_by_less_than_the_cube_of_its_length(
    restitution: float, pull: tuple[float, float, float]
) -> None:
    """Hops under y'' = -(1 + slope t + bend t^2 / 2) - 2 a y', to forty digits."""
    slope, bend, a = (mpmath.mpf(part) for part in pull)
    with mpmath.workdps(40):
        tau = mpmath.mpf("1e-4")
        q = tau * (1 - mpmath.mpf(restitution)) / 2
        total, speed = mpmath.mpf(0), q
        while speed > 1e-18 * q:
            total, speed = hop(total, speed, slope, bend, a)
            speed *= mpmath.mpf(restitution)
        formula = tau * (1 - (slope + a) * tau / 3)
        pace = max(abs(slope), mpmath.sqrt(abs(bend)), 2 * a)
        assert abs(formula - total) <= 0.6 * tau**3 * pace**2 + 1e-17 * tau


def hop(
    t: mpmath.mpf, v: mpmath.mpf, slope: mpmath.mpf, bend: mpmath.mpf, a: mpmath.mpf
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Return the instant and speed of landing, from the Taylor series of the hop."""
    terms = [mpmath.mpf(0), v]
    force = (-(1 + slope * t + bend * t * t / 2), -(slope + bend * t), -bend / 2)
    for n in range(2, 14):
        part = force[n - 2] if n < 5 else 0
        terms.append((part - 2 * a * (n - 1) * terms[n - 1]) / (n * (n - 1)))
    slopes = [k * term for k, term in enumerate(terms)][1:]
    # The root that is not zero: of the series divided by the time.
    over = terms[1:]
    over_slopes = [k * term for k, term in enumerate(over)][1:]
    s = 2 * v
    for _ in range(5):
        rate = mpmath.polyval(over_slopes[::-1], s)
        s -= mpmath.polyval(over[::-1], s) / rate
    return t + s, -mpmath.polyval(slopes[::-1], s)


@pytest.mark.parametrize(("v0", "end"), [(-1.0, 2.5), (1.0, 5.0)])
def test_a_start_on_a_wall_is_seen_where_no_force_acts_at_all(v0: float, end: float) -> None:
    run = pc.simulate(pc.impact_oscillator(0.5, stiffness=0), x0=0.0, v0=v0, t_end=5.0)

    assert len(run.impacts) == (v0 < 0.0)
    assert float(run(5.0)[0]) == end
