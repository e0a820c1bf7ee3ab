"""The first root of a curve, by exclusion: no root can be stepped over.

On a segment the curve is its Taylor polynomial and a bounded remainder. Where the smallest
Bernstein coefficient exceeds the remainder there is no root; where the derivative's coefficients
have one sign beyond theirs there is at most one, which the ends decide; else the segment is
halved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import mpmath
from mpmath import mp
from tests.oracle.curves import Curve, Real

ORDER = 12


@dataclass
class Search:
    """The first root in (0, end] of g(s) = sign (curve(s) - level), which starts positive.

    With ``multiplicity`` m the curve starts on its level, and g(s)/s^m is searched instead.
    Segments on which g stays within 10^(-digits) of zero are ``touches``.
    """

    curve: Curve
    level: Real
    sign: int
    multiplicity: int
    digits: int
    touches: list[Real] = field(default_factory=list)

    def first_root(self, end: Real) -> Real | None:
        """Return the first root, or None."""
        s, h = mp.zero, mp.one / 4
        # Half of the digits in time are all of them in height.
        narrow = mpmath.mpf(10) ** (-self.digits // 2)
        while s < end:
            h = min(h, end - s)
            h, settled = self._segment(s, h, narrow)
            if not settled:
                if self.g(s + h) <= 0:
                    raise ArithmeticError(f"a root of multiplicity above 2 near s = {s}")
                self.touches.append(s + h / 2)
            elif self.g(s + h) <= 0:
                return self._refined(s, s + h)
            s += h
            h *= 2
        return None

    def g(self, s: Real) -> Real:
        """Return the distance to the level, positive where the motion is."""
        return self.sign * (self.curve.value(s) - self.level)

    def _segment(self, s: Real, h: Real, narrow: Real) -> tuple[Real, bool]:
        """Return the longest halving of h on which there is at most one root, and if it is so."""
        m = self.multiplicity if s == 0 else 0
        raw = self.curve.taylor(s, ORDER + 2)
        coefficients = [self.sign * c for c in raw[: ORDER + 1]]
        coefficients[0] -= self.sign * self.level
        deflated = coefficients[m:]
        slopes = [n * c for n, c in enumerate(deflated)][1:]
        while True:
            bound = self.curve.bound(raw, ORDER + 1, h)
            remainder = bound * h ** (ORDER + 1 - m) / mpmath.factorial(ORDER + 1)
            if min(_bernstein(deflated, h)) > remainder:
                return h, True
            remainder = bound * h ** (ORDER - m) / mpmath.factorial(ORDER - m)
            rates = _bernstein(slopes, h)
            if min(rates) > remainder or max(rates) < -remainder:
                return h, True
            if h < narrow:
                return h, False
            h /= 2

    def _refined(self, low: Real, high: Real) -> Real:
        """Return the only root in (low, high], by Newton's steps on the deflated curve."""
        m = self.multiplicity if low == 0 else 0
        goal = mpmath.mpf(10) ** (-2 * self.digits)
        c = self.curve.taylor(low, m + 1)
        height = self.sign * (c[m] - (self.level if m == 0 else 0))
        slope = self.sign * c[m + 1]
        s = low
        while height != 0:
            step = -height / slope if slope else high - low
            s = s + step if low < s + step < high else (low + high) / 2
            if min(abs(step), high - low) < goal:
                return s
            value, rate = self.curve.taylor(s, 1)
            height = self.sign * (value - self.level)
            low, high = (s, high) if height > 0 else (low, s)
            slope = self.sign * rate - m * height / s
        return s


def _bernstein(coefficients: list[Real], h: Real) -> list[Real]:
    """Return the Bernstein coefficients of a polynomial on [0, h], between which its values are."""
    degree, row, power = len(coefficients) - 1, [], mp.one
    for j, c in enumerate(coefficients):
        row.append(c * power / math.comb(degree, j))
        power *= h
    # The i-th is the sum of comb(i, j) row[j], found as Pascal's triangle is.
    found = [row[0]]
    while len(row) > 1:
        row = [a + b for a, b in pairwise(row)]
        found.append(row[0])
    return found
