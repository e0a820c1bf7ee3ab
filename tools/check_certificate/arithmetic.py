"""Intervals with whole numbers, and functions of them.

Proven here: the result of an operation or a function on intervals holds its values at all numbers
in them. An interval is a pair of integers, numbers of units of 2^-bits, and each operation rounds
outward. Why the series hold their functions is section 11.2 of docs/theory/certified.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import isqrt
from typing import Any, NamedTuple, TypeVar

# Bits of all intervals, which `bits` changes.
BITS = 128
# Arguments y of cos y, cosh y and e^y are no larger than the root of this.
LARGEST_ARGUMENT = 1 << 24

T = TypeVar("T")
C = TypeVar("C")


class NotProvenError(Exception):
    """What is claimed is not proven."""


class HopelessError(NotProvenError):
    """What more bits or smaller parts would not change: that something is wrong, or cannot be told."""


def with_first(choices: Sequence[C], proven: Callable[[C], T]) -> T:
    """Return what is proven with the first of some choices that suffices."""
    for choice in choices[:-1]:
        try:
            return proven(choice)
        except HopelessError:
            raise
        except NotProvenError:
            continue
    return proven(choices[-1])


@contextmanager
def bits(n: int) -> Iterator[None]:
    """Work with intervals of so many bits; those of other bits have no meaning meanwhile."""
    global BITS  # noqa: PLW0603
    before, BITS = BITS, n
    try:
        yield
    finally:
        BITS = before


def unit() -> int:
    """Return how many units 1 has."""
    return 1 << BITS


class Interval(NamedTuple):
    """All real numbers from low to high, in units of 2^-BITS."""

    low: int
    high: int

    def __add__(self, other: Any) -> Any:
        if type(other) is not Interval:
            if type(other) is Dual:
                return NotImplemented
            other = of(other)
        return _new(Interval, (self[0] + other[0], self[1] + other[1]))

    def __neg__(self) -> Interval:
        return _new(Interval, (-self[1], -self[0]))

    def __sub__(self, other: Any) -> Any:
        if type(other) is not Interval:
            return self + -other
        return _new(Interval, (self[0] - other[1], self[1] - other[0]))

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        p, q = self
        if type(other) is not Interval:
            if type(other) is Dual:
                return NotImplemented
            if type(other) is int:
                low, high = (p, q) if other >= 0 else (q, p)
                return _new(Interval, (low * other, high * other))
            other = of(other)
        r, s = other
        if p >= 0:
            low, high = (p if r >= 0 else q) * r, (q if s >= 0 else p) * s
        elif q <= 0:
            low, high = (p if s >= 0 else q) * s, (q if r >= 0 else p) * r
        else:
            low, high = min(p * s, q * r), max(p * r, q * s)
        return _new(Interval, (low >> BITS, -(-high >> BITS)))

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __truediv__(self, other: Any) -> Any:
        if type(other) is Dual:
            return NotImplemented
        p, q = self
        r, s = of(other)
        if r <= 0 <= s:
            raise NotProvenError("a divisor may be zero")
        if s < 0:
            p, q, r, s = -q, -p, -s, -r
        return Interval(
            (p << BITS) // (s if p >= 0 else r), -((-q << BITS) // (r if q >= 0 else s))
        )

    def __rtruediv__(self, other: Any) -> Any:
        return of(other) / self

    @property
    def size(self) -> int:
        """The largest absolute value."""
        return max(-self.low, self.high)

    @property
    def least(self) -> int:
        """The smallest absolute value."""
        return max(self.low, -self.high, 0)

    @property
    def sign(self) -> int:
        """The sign of all numbers, 0 if they have not the same or one is zero."""
        return (self.low > 0) - (self.high < 0)

    @property
    def width(self) -> int:
        return self.high - self.low

    def middle(self) -> Interval:
        middle = (self.low + self.high) // 2
        return Interval(middle, middle)

    def square(self) -> Interval:
        return Interval(self.least**2 >> BITS, -(-(self.size**2) >> BITS))

    def root(self) -> Interval:
        """Return bounds of the square root: 0 and one from above."""
        return Interval(0, isqrt(max(self.high, 0) << BITS) + 1)

    def fractions(self) -> tuple[Fraction, Fraction]:
        return Fraction(self.low, 1 << BITS), Fraction(self.high, 1 << BITS)

    def wider(self) -> Interval:
        by = (self.high - self.low) // 8 + 1
        return Interval(self.low - by, self.high + by)

    def holds(self, other: Interval) -> bool:
        return self.low <= other.low and other.high <= self.high

    def both(self, other: Interval) -> Interval:
        """Return what is in both, which have a point in common."""
        return Interval(max(self.low, other.low), min(self.high, other.high))


_new = tuple.__new__


def of(low: Any, high: Fraction | int | None = None) -> Any:
    """Return the interval of a rational number, or of all between two; an interval as it is."""
    if type(low) is Interval or type(low) is Dual:
        return low
    n, d = low.as_integer_ratio()
    p, q = (n, d) if high is None else high.as_integer_ratio()
    return Interval((n << BITS) // d, -((-p << BITS) // q))


def hull(values: Sequence[Interval]) -> Interval:
    """Return the interval from the lowest to the highest of some."""
    return Interval(min(value.low for value in values), max(value.high for value in values))


class Dual(NamedTuple):
    """Values of a function of the parameter of a branch, and of its derivative by it."""

    value: Interval
    slope: Interval

    def __add__(self, other: Any) -> Any:
        value, slope = dual(other)
        return Dual(self.value + value, self.slope + slope)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slope)

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        value, slope = dual(other)
        return Dual(self.value * value, self.slope * value + self.value * slope)

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __truediv__(self, other: Any) -> Any:
        value, slope = dual(other)
        quotient = self.value / value
        return Dual(quotient, (self.slope - quotient * slope) / value)

    def __rtruediv__(self, other: Any) -> Any:
        return dual(other) / self


def dual(number: Any) -> Dual:
    return number if isinstance(number, Dual) else Dual(of(number), of(0))


def cosine_series(z: Any) -> Any:
    """Return the two series of `_cosine_series`, with derivatives if z has one."""
    if not isinstance(z, Dual):
        return _cosine_series(z)
    c, s = _cosine_series(z.value)
    # C' = S/2, S' = (C - S)/2z = 1/6 + z/60 + ..., whose rest is below z^2/1600 for |z| <= 2.
    if z.value.least >= 1 << BITS:
        slope = (c - s) / (2 * z.value)
    elif z.value.size <= 2 << BITS:
        rest = z.value.size**2 // (1600 << BITS) + 1
        slope = Fraction(1, 6) + Fraction(1, 60) * z.value + Interval(-rest, rest)
    else:
        raise NotProvenError("an interval is too wide for a series")
    return Dual(c, Fraction(1, 2) * s * z.slope), Dual(s, slope * z.slope)


def _cosine_series(z: Interval) -> tuple[Interval, Interval]:
    """Return C(z) = sum of z^k/(2k)! and S(z) = sum of z^k/(2k+1)!.

    C(-y^2) = cos y, S(-y^2) = sin(y)/y, and cosh and sinh for positive z. At the middle m of z the
    sums end with a term of one unit at most, behind which each is less than a quarter of the one
    before. C' = S/2 and |S'| <= max(1, S)/6 carry them to all of z.
    """
    m, radius = (z.low + z.high) // 2, (z.width + 2) // 2
    if z.size > LARGEST_ARGUMENT << BITS:
        raise NotProvenError("an argument is too large for a series")
    cos = sin = term = 1 << BITS
    k = 0
    while True:
        k += 1
        term = (term * m >> BITS) // (2 * k * (2 * k - 1))
        cos += term
        sin += term // (2 * k + 1)
        if -1 <= term <= 1 and abs(m) < k * k << BITS:
            break
    # Each of k terms is rounded by less than a unit, and passes that on to those behind it by
    # factors that sum to less than cosh(sqrt|m|); the rest is less than a third of the last term.
    error = (4 * k + 4) * 3 ** (isqrt(abs(m) >> BITS) + 1)
    slope = max(1 << BITS, abs(sin) + error)
    if z.high > 0:
        if radius >= 1 << BITS:
            raise NotProvenError("an interval is too wide for a series")
        # S grows by e^(r/6) at most on the way.
        slope += (slope * radius >> BITS) + 1
    c, s = error + (slope * radius >> (BITS + 1)) + 1, error + (slope * radius >> BITS) // 6 + 2
    return Interval(cos - c, cos + c), Interval(sin - s, sin + s)


def exponential(y: Any) -> Any:
    """Return e^y = C(y^2) + y S(y^2) at both ends, which it grows between."""
    if isinstance(y, Dual):
        power = exponential(y.value)
        return Dual(power, power * y.slope)
    first = _exponential_at(y.low)
    return first if y.low == y.high else Interval(first.low, _exponential_at(y.high).high)


def _exponential_at(y: int) -> Any:
    point = Interval(abs(y), abs(y))
    c, s = _cosine_series(point * point)
    power = c + point * s
    return power if y >= 0 else 1 / power


def pi() -> Any:
    """Return pi = 16 arctan(1/5) - 4 arctan(1/239), whose series alternate."""
    if BITS not in PI:
        PI[BITS] = 16 * _arctan(5) - 4 * _arctan(239)
    return PI[BITS]


PI: dict[int, Interval] = {}


def _arctan(q: int) -> Interval:
    total, n, sign = 0, 0, 1
    while True:
        term = (1 << (BITS + 8)) // (q ** (2 * n + 1) * (2 * n + 1))
        total += sign * term
        n, sign = n + 1, -sign
        if term == 0:
            return Interval((total - n - 1) >> 8, -(-(total + n + 1) >> 8))


def angle(phase: tuple[Fraction, Fraction]) -> Any:
    """Return p pi + q of a pair (p, q)."""
    return of(phase[0]) * pi() + of(phase[1])


def nearest(t: Interval, period: Interval) -> int:
    """Return about how many periods an instant is from 0."""
    return (2 * t.low + period.low) // (2 * period.low)


def cosine_and_sine(argument: Any) -> tuple[Any, Any]:
    """Return cos and sin, by quarters of a turn near zero."""
    if isinstance(argument, Dual):
        cos, sin = cosine_and_sine(argument.value)
        return Dual(cos, -sin * argument.slope), Dual(sin, cos * argument.slope)
    quarter = pi() / 2
    turns = nearest(argument.middle(), quarter)
    y = argument - turns * quarter
    c, s = _cosine_series(-y.square())
    whole = Interval(-1 << BITS, 1 << BITS)
    cos, sin = c.both(whole), (y * s).both(whole)
    for _ in range(turns % 4):
        cos, sin = -sin, cos
    return cos, sin


Pair = tuple[Interval, Interval]
Matrix = tuple[Pair, Pair]


def product(a: Matrix, b: Matrix) -> Matrix:
    (p, q), (r, s) = a
    (e, f), (g, h) = b
    return (p * e + q * g, p * f + q * h), (r * e + s * g, r * f + s * h)


def applied(a: Matrix, b: Pair) -> Pair:
    (p, q), (r, s) = a
    return p * b[0] + q * b[1], r * b[0] + s * b[1]


def inverse_of(a: Fraction, b: Fraction, c: Fraction, d: Fraction) -> Matrix:
    """Return the inverse of ((a, b), (c, d))."""
    size = a * d - b * c
    if size == 0:
        raise NotProvenError("two sides are parallel")
    return (of(d / size), of(-b / size)), (of(-c / size), of(a / size))
