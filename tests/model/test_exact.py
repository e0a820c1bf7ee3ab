from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.errors import ParameterError
from percuss.model.exact import (
    Exact,
    Phase,
    as_float,
    as_fraction,
    cos_sin,
    kept,
    phase_problem,
    pi_times,
    square_root,
)


def repr_of(value: object) -> str:
    """The short name of a case: 1.0, "1" and True must not share one."""
    return f"{type(value).__name__} {value!r}"[:40]


FRACTIONS = st.fractions(min_value=-(10**6), max_value=10**6, max_denominator=10**6)


@pytest.mark.parametrize(
    ("given_value", "meant"),
    [
        (3, Fraction(3)),
        (0.1, Fraction(3602879701896397, 2**55)),
        (Fraction(1, 3), Fraction(1, 3)),
        (Decimal("2.80"), Fraction(14, 5)),
        ("2.8", Fraction(14, 5)),
        (" -1e-3 ", Fraction(-1, 1000)),
        (".5", Fraction(1, 2)),
        ("1/3", Fraction(1, 3)),
        ("-2 / 6", Fraction(-1, 3)),
    ],
)
def test_a_number_means_exactly_what_was_written(given_value: Exact, meant: Fraction) -> None:
    assert as_fraction(given_value) == meant
    assert as_float(given_value) == meant.numerator / meant.denominator


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (math.nan, "not finite"),
        (-math.inf, "not finite"),
        (Decimal("NaN"), "not finite"),
        ("nan", "not finite"),
        ("-Infinity", "not finite"),
        (True, "not a number"),
        (np.bool_(False), "not a number"),
        (None, "not a number"),
        (1j, "not a number"),
        ("", "not a number"),
        ("two", "not a number"),
        ("1_000", "not a number"),
        ("1 000", "not a number"),
        ("0x10", "not a number"),
        ("__import__('os')", "not a number"),
        ("9" * 2000, "not a number"),
        ([1.0], "not a number"),
        (np.array([1.0, 2.0]), "not a number"),
        ("1/0", "a division by zero"),
        (10**400, "beyond the range of floats"),
        ("1e400", "beyond the range of floats"),
        ("1e-400", "beyond the range of floats"),
        (Fraction(1, 10**400), "beyond the range of floats"),
        # Their fractions would fill the memory.
        ("1e999999", "beyond the range of floats"),
        (Decimal("1e-999999"), "beyond the range of floats"),
    ],
    ids=repr_of,
)
def test_what_is_no_finite_number_is_refused_in_a_sentence(value: object, reason: str) -> None:
    with pytest.raises(ParameterError, match=reason):
        as_fraction(value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "value",
    [np.float64(0.25), np.float32(0.25), np.int32(4), np.array(0.25), np.str_("0.25")],
    ids=repr_of,
)
def test_a_numpy_scalar_is_taken_as_its_python_value(value: Exact) -> None:
    assert as_fraction(value) in {Fraction(1, 4), Fraction(4)}


@pytest.mark.parametrize("quarters", range(-9, 10))
def test_cosine_and_sine_are_exact_at_every_multiple_of_a_quarter_turn(quarters: int) -> None:
    exact = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarters % 4]

    cosine, sine = cos_sin(pi_times(quarters, 2))

    assert (cosine, sine) == exact
    assert math.copysign(1.0, cosine) >= exact[0]  # a zero is never -0.0
    assert math.copysign(1.0, sine) >= exact[1]


@pytest.mark.parametrize("sixths", range(-13, 14))
def test_cosine_and_sine_are_exact_where_they_are_a_half(sixths: int) -> None:
    for number, part in zip(cos_sin(pi_times(sixths, 6)), (math.cos, math.sin), strict=True):
        true_value = part(sixths * math.pi / 6)
        if abs(abs(true_value) - 0.5) < 0.01:
            assert number == math.copysign(0.5, true_value)


@given(times=FRACTIONS, plus=FRACTIONS)
def test_cosine_and_sine_of_any_phase_agree_with_50_digits(times: Fraction, plus: Fraction) -> None:
    with mpmath.workdps(50):
        phase = mpmath.mpf(times.numerator) / times.denominator * mpmath.pi
        phase += mpmath.mpf(plus.numerator) / plus.denominator

        for number, reference in zip(
            cos_sin(pi_times(times) + plus), (mpmath.cos(phase), mpmath.sin(phase)), strict=True
        ):
            # One rounding of the reduced phase and one of the function.
            assert abs(number - reference) <= 3e-16 * abs(reference) + 1e-30


@given(times=FRACTIONS, plus=FRACTIONS)
def test_a_multiple_of_pi_is_read_back_from_its_text_and_from_its_repr(
    times: Fraction, plus: Fraction
) -> None:
    phase = pi_times(times) + plus

    assert pi_times(0) + str(phase) == phase
    assert eval(repr(phase), {"pi_times": pi_times, "Fraction": Fraction}) == phase


@pytest.mark.parametrize(
    ("text", "times", "plus"),
    [
        ("pi", 1, 0),
        ("-pi/2", Fraction(-1, 2), 0),
        ("3*pi/4", Fraction(3, 4), 0),
        ("3 pi / 4", Fraction(3, 4), 0),
        ("1/3 pi", Fraction(1, 3), 0),
        ("0.3 - pi/2", Fraction(-1, 2), Fraction(3, 10)),
        ("-1e-3 + 2pi", 2, Fraction(-1, 1000)),
    ],
)
def test_a_phase_may_be_a_text_with_pi(text: str, times: Fraction, plus: Fraction) -> None:
    assert pi_times(0) + text == pi_times(times) + plus
    assert as_float(text) == pytest.approx(float(times) * math.pi + float(plus), rel=1e-15)


@pytest.mark.parametrize("text", ["pie", "pi pi", "2pi3", "pi*2", "0.3pi/0", "pi/", "+", "1 2 pi"])
def test_other_texts_with_pi_are_no_phase(text: str) -> None:
    assert phase_problem(text) is not None


def test_so_many_pi_that_they_are_no_float_are_no_phase() -> None:
    with pytest.raises(ParameterError, match=r"beyond the range of floats, 5e-324 to 1\.8e308"):
        as_float(pi_times(10**308))


def test_sums_and_differences_of_phases_are_exact() -> None:
    quarter: Phase = pi_times(1, 2)

    assert pi_times(3, 4) - pi_times(1, 4) == quarter
    assert 0.1 + pi_times(1) - 0.1 == pi_times(1)
    assert 1 - pi_times(1, 2) == -(pi_times(1, 2) - 1)


def test_a_multiple_of_pi_over_zero_is_refused() -> None:
    with pytest.raises(ParameterError, match="q = 0: zero"):
        pi_times(1, 0)


@given(value=st.fractions(min_value=0, max_denominator=10**9))
def test_a_square_root_is_correctly_rounded_and_exact_where_it_is_rational(value: Fraction) -> None:
    with mpmath.workdps(60):
        reference = mpmath.sqrt(mpmath.mpf(value.numerator) / value.denominator)
        assert float(square_root(value)) == float(reference)

    assert as_fraction(square_root(value**2)) == value


def test_a_computed_number_stays_exact() -> None:
    assert kept(Fraction(1, 3)) == Fraction(1, 3)
    assert isinstance(kept(Fraction(1, 4)), float)
