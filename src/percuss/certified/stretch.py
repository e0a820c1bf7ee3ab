"""Whether a polynomial with a remainder is positive on a stretch, or falls through zero.

Two of a kind: in floats with a bound of their rounding, which is fast, and in balls, which tells
clearances below the floats' rounding.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

from flint import arb

from percuss.certified.law import Number, constant_of

# A float, or a ball.
Real: TypeAlias = Any

__all__ = ["BallStretch", "FloatStretch", "Stretch"]

# Above the rounding of the float operations of a test, relative to its terms.
ROUNDING = 2.0**-44
UP = 1.0001
# With an error below this no sum of the tests is beyond the floats.
LARGEST = 1e280
ROWS = [[math.comb(n, j) for j in range(n + 1)] for n in range(16)]


class FloatStretch(NamedTuple):
    """A polynomial whose coefficients are known to within radii; rest h^power is its remainder."""

    mids: list[float]
    radii: list[float]

    @classmethod
    def of(cls, coefficients: list[Number]) -> FloatStretch:
        """Take over balls; the radii hold the rounding to floats too."""
        mids, radii = [], []
        for value in coefficients:
            number = constant_of(value)
            mid = float(number)
            mids.append(mid)
            radii.append(UP * float(number.rad()) + abs(mid) * 2.0**-52 + 1e-300)
        return cls(mids, radii)

    def is_clear(self, rest: float, h: float, power: int) -> bool:
        """Tell whether it is positive on [0, h] for certain."""
        error = self._error(self.mids, self.radii, h) + UP * rest * h**power
        return bool(min(_bernstein(self.mids, h)) > error)

    def falls_through(self, rest: float, slope_rest: float, h: float, power: int) -> bool:
        """Tell whether it falls all along, from above zero to below, for certain."""
        if not self.mids[0] > self.radii[0]:
            return False
        error = self._error(self.mids, self.radii, h) + UP * rest * h**power
        if not _value(self.mids, h) < -error:
            return False
        slopes = [-(k * value) for k, value in enumerate(self.mids)][1:]
        radii = [k * radius for k, radius in enumerate(self.radii)][1:]
        error = self._error(slopes, radii, h) + UP * slope_rest * h ** (power - 1)
        return bool(min(_bernstein(slopes, h)) > error)

    @staticmethod
    def _error(mids: list[float], radii: list[float], h: float) -> float:
        """Return a bound of what rounding and radii do to a value on [0, h]."""
        total, power = 0.0, 1.0
        for value, radius in zip(mids, radii, strict=True):
            total += (radius + ROUNDING * abs(value)) * power
            power *= h
        return UP * total if total < LARGEST else math.inf

    def root(self, h: float) -> float:
        """Return about where a falling polynomial is zero on [0, h]."""
        low, high = 0.0, h
        s = 0.5 * h
        for _ in range(60):
            value, slope = 0.0, 0.0
            for c in reversed(self.mids):
                slope = slope * s + value
                value = value * s + c
            if value > 0.0:
                low = s
            else:
                high = s
            step = s - value / slope if slope < 0.0 else math.inf
            following = step if low < step < high else 0.5 * (low + high)
            if abs(following - s) <= 1e-15 * following:
                return following
            s = following
        return s


class BallStretch(NamedTuple):
    """The same with balls as coefficients."""

    balls: list[arb]

    @classmethod
    def of(cls, coefficients: list[Number]) -> BallStretch:
        """Take over balls."""
        return cls([constant_of(value) for value in coefficients])

    def is_clear(self, rest: float, h: float, power: int) -> bool:
        """Tell whether it is positive on [0, h] for certain."""
        most = UP * arb(rest) * arb(h) ** power
        return all(value > most for value in _bernstein(self.balls, arb(h)))

    def falls_through(self, rest: float, slope_rest: float, h: float, power: int) -> bool:
        """Tell whether it falls all along, from above zero to below, for certain."""
        at = arb(h)
        most = UP * arb(rest) * at**power
        if not (self.balls[0] > 0 and _value(self.balls, at) < -most):
            return False
        slopes = [-(k * value) for k, value in enumerate(self.balls)][1:]
        most = UP * arb(slope_rest) * at ** (power - 1)
        return all(value > most for value in _bernstein(slopes, at))

    def root(self, h: float) -> float:
        """Return about where a falling polynomial is zero on [0, h]."""
        return FloatStretch.of(list(self.balls)).root(h)


Stretch: TypeAlias = FloatStretch | BallStretch


def _bernstein(coefficients: list[Real], h: Real) -> list[Real]:
    """Return the Bernstein coefficients of a polynomial on [0, h], between which it stays."""
    degree = len(coefficients) - 1
    found: list[Real] = []
    power: Real = 1
    for value, binomial in zip(coefficients, ROWS[degree], strict=True):
        found.append(value * power / binomial)
        power = power * h
    # Sums of neighbours, again and again.
    for i in range(1, degree + 1):
        for j in range(degree, i - 1, -1):
            found[j] = found[j] + found[j - 1]
    return found


def _value(coefficients: list[Real], h: Real) -> Real:
    total = coefficients[-1]
    for value in coefficients[-2::-1]:
        total = total * h + value
    return total
