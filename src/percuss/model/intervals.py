"""Values of expressions: exact where they are rational, else enclosed in rational intervals."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from percuss.model.exact import DIVISION_BY_ZERO, OUT_OF_RANGE, rational_cosine, rational_root

# Bits of a value relative to its size, and those after the point that are tried for them.
RELATIVE, PRECISIONS = 320, (448, 1600, 4800)
# A number of more bits is far outside the range of floats, or no hand wrote it.
MOST_BITS = 40_000
GUARD = 32
NEGATIVE = "the square root of a negative number"


class NoNumber(ArithmeticError):  # noqa: N818 - no error of the program, but of a text
    """The value of an expression is no number; the text says why."""


class Irrational(ArithmeticError):  # noqa: N818 - no error at all
    """The value is no rational number and no multiple of pi."""


class TooLarge(ArithmeticError):  # noqa: N818 - no error at all
    """An exact value has too many digits."""


@dataclass(frozen=True, slots=True)
class ExactNumber:
    """The number times * pi + plus."""

    times: Fraction
    plus: Fraction

    def __post_init__(self) -> None:
        for part in (self.times, self.plus):
            if max(part.numerator.bit_length(), part.denominator.bit_length()) > MOST_BITS:
                raise TooLarge

    def __add__(self, other: ExactNumber) -> ExactNumber:
        return ExactNumber(self.times + other.times, self.plus + other.plus)

    def __neg__(self) -> ExactNumber:
        return ExactNumber(-self.times, -self.plus)

    def __sub__(self, other: ExactNumber) -> ExactNumber:
        return self + -other

    def __mul__(self, other: ExactNumber) -> ExactNumber:
        if self.times and other.times:
            raise Irrational
        return ExactNumber(
            self.times * other.plus + self.plus * other.times, self.plus * other.plus
        )

    def __truediv__(self, other: ExactNumber) -> ExactNumber:
        if not other.times:
            if not other.plus:
                raise NoNumber(DIVISION_BY_ZERO)
            return ExactNumber(self.times / other.plus, self.plus / other.plus)
        ratio = self.times / other.times
        if self.plus != ratio * other.plus:
            raise Irrational
        return ExactNumber(Fraction(0), ratio)

    def sqrt(self) -> ExactNumber:
        """Return the square root of a square of a rational number."""
        if self.times:
            raise Irrational
        if self.plus < 0:
            raise NoNumber(NEGATIVE)
        root = rational_root(self.plus)
        if root is None:
            raise Irrational
        return ExactNumber(Fraction(0), root)

    def cos(self) -> ExactNumber:
        """Return a cosine that is rational."""
        cosine = rational_cosine(self.times, self.plus)
        if cosine is None:
            raise Irrational
        return ExactNumber(Fraction(0), cosine)

    def sin(self) -> ExactNumber:
        """Return a sine that is rational."""
        return ExactNumber(self.times - Fraction(1, 2), self.plus).cos()


@dataclass(frozen=True, slots=True)
class FixedPointInterval:
    """All numbers from low to high, in units of 2^-bits."""

    bits: int
    low: int
    high: int

    def __post_init__(self) -> None:
        if max(self.low.bit_length(), self.high.bit_length()) > MOST_BITS:
            raise NoNumber(OUT_OF_RANGE)

    def __add__(self, other: FixedPointInterval) -> FixedPointInterval:
        return FixedPointInterval(self.bits, self.low + other.low, self.high + other.high)

    def __neg__(self) -> FixedPointInterval:
        return FixedPointInterval(self.bits, -self.high, -self.low)

    def __sub__(self, other: FixedPointInterval) -> FixedPointInterval:
        return self + -other

    def __mul__(self, other: FixedPointInterval) -> FixedPointInterval:
        corners = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return FixedPointInterval(
            self.bits, min(corners) >> self.bits, -(-max(corners) >> self.bits)
        )

    def __truediv__(self, other: FixedPointInterval) -> FixedPointInterval:
        if other.low <= 0 <= other.high:
            raise NoNumber(DIVISION_BY_ZERO)
        lifted = [a << self.bits for a in (self.low, self.high)]
        ends = (other.low, other.high)
        return FixedPointInterval(
            self.bits,
            min(a // b for a in lifted for b in ends),
            max(-(-a // b) for a in lifted for b in ends),
        )


@dataclass(frozen=True, slots=True)
class IntervalArithmetic:
    """Arithmetic of intervals with so many bits after the point."""

    bits: int

    def number(self, value: Fraction) -> FixedPointInterval:
        """Return an interval that holds a rational number."""
        p, q = value.numerator << self.bits, value.denominator
        return FixedPointInterval(self.bits, p // q, -(-p // q))

    def pi(self) -> FixedPointInterval:
        """Return an interval that holds pi."""
        low = _pi(self.bits)
        return FixedPointInterval(self.bits, low, low + 1)

    def sqrt(self, value: FixedPointInterval) -> FixedPointInterval:
        """Return an interval that holds the square roots."""
        if value.high < 0:
            raise NoNumber(NEGATIVE)
        low, high = max(value.low, 0) << self.bits, value.high << self.bits
        return FixedPointInterval(self.bits, math.isqrt(low), math.isqrt(high) + 1)

    def cos(self, value: FixedPointInterval) -> FixedPointInterval:
        """Return an interval that holds the cosines."""
        middle = (value.low + value.high) // 2
        # No cosine changes faster than its argument.
        around = value.high - middle + 2
        cosine = _cosine(middle, self.bits)
        return FixedPointInterval(self.bits, cosine - around, cosine + around)

    def sin(self, value: FixedPointInterval) -> FixedPointInterval:
        """Return an interval that holds the sines."""
        half = self.pi() * self.number(Fraction(1, 2))
        return self.cos(value - half)


def enclosed(at: Callable[[IntervalArithmetic], FixedPointInterval]) -> Fraction:
    """Return the value that an expression has in intervals, within 2^-320 of its size.

    What is not told from zero by 4800 bits after the point is zero.
    """
    for bits in PRECISIONS:
        is_last = bits == PRECISIONS[-1]
        try:
            interval = at(IntervalArithmetic(bits))
        except NoNumber:
            if is_last:
                raise
            continue
        size = min(abs(interval.low), abs(interval.high)) if interval.low * interval.high > 0 else 0
        if (interval.high - interval.low) << RELATIVE <= size:
            break
    return Fraction(interval.low + interval.high, 2 << bits) if size else Fraction(0)


@lru_cache(maxsize=32)
def _pi(bits: int) -> int:
    """Return the largest whole number of 2^-bits below pi (Machin)."""
    work = bits + GUARD
    return (16 * _arctangent(5, work) - 4 * _arctangent(239, work)) >> GUARD


def _arctangent(n: int, bits: int) -> int:
    term = total = (1 << bits) // n
    k = 1
    while term:
        term //= -n * n
        k += 2
        total += term // k
    return total


def _cosine(x: int, bits: int) -> int:
    """Return a cosine in units of 2^-bits, within one of them."""
    work = bits + GUARD
    turn = 2 * _pi(work + max(0, x.bit_length() - bits))
    lifted = x << (GUARD + max(0, x.bit_length() - bits))
    rest = abs((lifted + turn // 2) % turn - turn // 2) >> max(0, x.bit_length() - bits)
    # Taylor's series of the cosine of a 2^-8th, doubled eight times.
    small = rest >> 8
    square = (small * small) >> work
    term = total = 1 << work
    k = 0
    while term:
        term = -((term * square) >> work) // ((k + 1) * (k + 2))
        k += 2
        total += term
    for _ in range(8):
        total = ((total * total) >> (work - 1)) - (1 << work)
    return total >> GUARD
