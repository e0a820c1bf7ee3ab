"""Exact numbers as balls of the working precision, and bounds of balls as floats."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, TypeAlias, cast

from flint import arb, ctx, fmpq

from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, angle, as_fraction, two_of
from percuss.model.expression import Expression

# A number, or, cast to this type, an arb_series of two terms: it holds a number and its
# derivative by a parameter, and has the same operations.
Number: TypeAlias = arb

# More than the rounding of a conversion to a float.
UP = 1.0 + 2.0**-50
TINY = 5e-324
# Arb has one precision for the whole process, so that one thread at a time works with it.
_LOCK = threading.RLock()
# Bits by which two irrational times are told apart.
MOST_BITS = 4096


class precision:  # noqa: N801
    """The working precision inside a ``with`` block, which one thread enters at a time.

    Parameters
    ----------
    bits
        The bits of midpoints.
    """

    __slots__ = ("before", "bits")

    def __init__(self, bits: int) -> None:
        self.bits = bits
        self.before = bits

    def __enter__(self) -> None:
        _LOCK.acquire()
        self.before, ctx.prec = ctx.prec, self.bits

    def __exit__(self, *problem: object) -> None:
        ctx.prec = self.before
        _LOCK.release()


def rational(value: Fraction) -> fmpq:
    """Return a fraction as Arb's exact rational."""
    return fmpq(value.numerator, value.denominator)


def ball(value: Fraction) -> arb:
    """Return a ball that holds a fraction, of radius zero where the precision holds it."""
    return arb(rational(value))


def exact_value(value: arb) -> Fraction:
    """Return the midpoint of a ball as a fraction."""
    mantissa, exponent = value.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def time_ball(value: Phase) -> arb:
    """Return a ball that holds a time or a phase.

    Examples
    --------
    >>> time_ball("pi/2").contains(arb.pi() / 2)
    True
    """
    if not is_exact(value):
        return in_balls(value, {})  # type: ignore[arg-type]
    times, plus = angle(value)
    return arb.pi() * ball(times) + ball(plus) if times else ball(plus)


def is_exact(value: Phase) -> bool:
    """Return whether a number is a rational, or a rational multiple of pi and a rational.

    Examples
    --------
    >>> import percuss as pc
    >>> is_exact("pi/3"), is_exact(pc.expression("sqrt(2)"))
    (True, False)
    """
    return not isinstance(value, Expression) or value.is_exact


class _BallArithmetic:
    """Balls, or series of them, as what expressions are evaluated in."""

    def number(self, value: Fraction) -> Number:
        return ball(value)

    def pi(self) -> Number:
        return arb.pi()

    def sqrt(self, value: Number) -> Number:
        return value.sqrt()

    def sin(self, value: Number) -> Number:
        return value.sin()

    def cos(self, value: Number) -> Number:
        return value.cos()


def in_balls(number: Expression, values: Mapping[str, Number]) -> Number:
    """Return the value of an expression as a ball, with other values of some parameters."""
    own = {name: time_ball(value) for name, value in number.parameters}
    return number.evaluated(_BallArithmetic(), own | dict(values))


def constant_of(value: Any) -> arb:
    """Return a number, or that of a series, without the derivative."""
    return value if isinstance(value, arb) else cast("arb", value[0])


def cos_sin(times: Fraction, plus: Fraction) -> tuple[arb, arb]:
    """Return the cosine and the sine of ``times * pi + plus``, exact at multiples of pi/2.

    Examples
    --------
    >>> [str(value) for value in cos_sin(Fraction(-1, 2), Fraction(0))]
    ['0', '-1.00000000000000']
    """
    if plus == 0:
        sine, cosine = arb.sin_cos_pi_fmpq(rational(times))
    else:
        sine, cosine = (arb.pi() * ball(times) + ball(plus)).sin_cos()
    return cosine, sine


def exact_range(name: str, given: tuple[Exact, Exact]) -> tuple[Fraction, Fraction]:
    """Return two exact numbers, the first below the second, or raise a `ParameterError`."""
    low, high = two_of(as_fraction, name, given, "not two numbers")
    if not low < high:
        raise ParameterError(name, given, "the first is not below the second")
    return low, high


def ratio_of(one: tuple[Fraction, Fraction], other: tuple[Fraction, Fraction]) -> Fraction | None:
    """Return the rational by which an angle is another, None if it is no such multiple."""
    (times, plus), (by, more) = one, other
    if times * more != plus * by:
        # No multiple: pi is irrational.
        return None
    return times / by if by else plus / more


def order_of(time: Phase, other: Phase) -> int:
    """Return -1, 0 or 1 for a time before another, the same, or after it; exactly.

    Raises
    ------
    ParameterError
        If irrational expressions are not told apart by 4096 bits.

    Examples
    --------
    >>> order_of("pi", 3.141592653589793), order_of("20*pi", "40*pi/2")
    (1, 0)
    """
    if not (is_exact(time) and is_exact(other)):
        return _irrational_order(time, other)
    (times, plus), (other_times, other_plus) = angle(time), angle(other)
    times, plus = times - other_times, plus - other_plus
    bits = 128
    # A multiple of pi is no fraction: enough bits separate them, however close they are.
    while times:
        with precision(bits):
            gap = arb.pi() * ball(times) + ball(plus)
            if gap > 0 or gap < 0:
                return 1 if gap > 0 else -1
        bits *= 2
    return (plus > 0) - (plus < 0)


def _irrational_order(time: Phase, other: Phase) -> int:
    if time == other:
        return 0
    bits = 128
    while bits <= MOST_BITS:
        with precision(bits):
            gap = time_ball(time) - time_ball(other)
            if gap > 0 or gap < 0:
                return 1 if gap > 0 else -1
        bits *= 2
    raise ParameterError("t", time, f"not told from {other} by {MOST_BITS} bits")


def largest_abs(value: arb) -> float:
    """Return a float that no magnitude in a ball exceeds."""
    return float(value.abs_upper()) * UP + TINY


def power(base: float, n: int) -> float:
    """Return a power of a float, infinity where it is beyond all floats."""
    try:
        return base**n
    except OverflowError:
        return float("inf")


def between(low: arb, high: arb) -> arb:
    """Return a ball that holds two balls and all numbers between them."""
    return low.union(high)


def span(radius: arb) -> arb:
    """Return the ball around zero of all numbers up to a magnitude."""
    return arb(0, radius.abs_upper())
