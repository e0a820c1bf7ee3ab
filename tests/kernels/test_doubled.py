from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.kernels.uncompiled import python_of

from percuss.kernels.arithmetic import cos_sin, later, nearest, turns, two_product, two_sum
from percuss.model.ratios import PI

ULP = 2.0**-52

# Within these neither products nor their errors overflow or underflow.
FLOATS = st.floats(-1e140, 1e140).filter(lambda x: x == 0.0 or abs(x) > 1e-130)
TIMES = st.floats(1e-100, 1e9)
OMEGAS = st.floats(1e-3, 1e3)


@given(a=FLOATS, b=FLOATS)
def test_two_sum_and_two_product_keep_all_digits(a: float, b: float) -> None:
    total, lost_of_sum = two_sum(a, b)
    product, lost_of_product = two_product(a, b)

    assert total == a + b
    assert Fraction(total) + Fraction(lost_of_sum) == Fraction(a) + Fraction(b)
    assert product == a * b
    assert Fraction(product) + Fraction(lost_of_product) == Fraction(a) * Fraction(b)


@given(x=st.floats(-(2.0**51), 2.0**51))
def test_nearest_rounds_half_to_even(x: float) -> None:
    assert nearest(x) == round(x)


@given(t=TIMES, t_low=st.floats(-1e-8, 1e-8), s=st.floats(0.0, 100.0))
def test_an_instant_keeps_32_digits(t: float, t_low: float, s: float) -> None:
    high, low = later(t, t_low, s)

    exact = Fraction(t) + Fraction(t_low) + Fraction(s)
    assert abs(low) <= 0.5 * math.ulp(high)
    assert abs(Fraction(high) + Fraction(low) - exact) <= abs(exact) * Fraction(2) ** -104 + (
        Fraction(math.ulp(t_low)) + Fraction(math.ulp(s)) * Fraction(2) ** -52
    )


@given(omega=OMEGAS, t=TIMES, t_low=st.floats(-1e-8, 1e-8))
def test_cosine_and_sine_keep_their_digits_after_any_number_of_turns(
    omega: float, t: float, t_low: float
) -> None:
    """The largest phase is 1e12; two pairs know it to some 1e-32 of that."""
    rate, rate_low = pair_of(Fraction(omega) / (2 * PI))

    cosine, sine = cos_sin(rate, rate_low, t, t_low)

    with mpmath.workdps(60):
        phase = mpmath.mpf(omega) * (mpmath.mpf(t) + mpmath.mpf(t_low))
        # What the pairs do not hold of the phase: (omega / 2 pi) to 107 bits, and the second
        # product, which is rounded once.
        known = abs(phase) * 2.0**-104 + abs(omega * t_low) * 2 * ULP
        for value, exact in ((cosine, mpmath.cos(phase)), (sine, mpmath.sin(phase))):
            assert abs(value - exact) <= 3 * ULP * abs(exact) + known


@pytest.mark.parametrize("t", [1e6, 1e7, 1e8, 1e9])
def test_a_sine_next_to_its_zero_keeps_its_relative_precision(t: float) -> None:
    """At the double next to a multiple of pi, as impact times are."""
    multiple = float(round(t / math.pi) * PI)
    rate, rate_low = pair_of(1 / (2 * PI))

    _, sine = cos_sin(rate, rate_low, multiple, 0.0)

    with mpmath.workdps(60):
        exact = mpmath.sin(mpmath.mpf(multiple))
    assert sine == pytest.approx(float(exact), rel=1e-14)


def test_quarter_turns_are_exact() -> None:
    quarters = [cos_sin(0.25, 0.0, float(n), 0.0) for n in (0, 1, 2, 3, 4, 10**9 + 1)]

    assert quarters == [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 0), (0, 1)]


@given(omega=OMEGAS, t=TIMES)
def test_turns_are_the_fraction_of_the_exact_product(omega: float, t: float) -> None:
    rate, rate_low = pair_of(Fraction(omega) / (2 * PI))

    part = turns(rate, rate_low, t, 0.0)

    exact = Fraction(t) * Fraction(omega) / (2 * PI)
    off = (exact - Fraction(part)) % 1
    assert abs(part) <= 0.5
    assert min(off, 1 - off) <= Fraction(4 * ULP * abs(part)) + exact * Fraction(2) ** -104


@given(a=FLOATS, b=FLOATS, t=TIMES)
def test_plain_python_gives_the_bits_of_the_machine_code(a: float, b: float, t: float) -> None:
    assert python_of(two_sum)(a, b) == two_sum(a, b)
    assert python_of(two_product)(a, b) == two_product(a, b)
    assert python_of(cos_sin)(0.3, 1e-18, t, 1e-9) == cos_sin(0.3, 1e-18, t, 1e-9)
    assert python_of(turns)(0.3, 1e-18, t, 1e-9) == turns(0.3, 1e-18, t, 1e-9)


def pair_of(value: Fraction) -> tuple[float, float]:
    return float(value), float(value - Fraction(float(value)))
