"""Sets of states (t, v) that grow no more than the motion makes them (Lohner's coordinates).

The set is m + Q r: a point, an orthogonal matrix, and two intervals. Each map turns the set
into F(m) + F'(set) Q r; a new Q along the image keeps the intervals from growing by wrapping.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

from flint import arb

from percuss.certified.numbers import between

BallPair = tuple[arb, arb]
BallMatrix = tuple[BallPair, BallPair]


def times(a: BallMatrix, b: BallMatrix) -> BallMatrix:
    """Return the product of two matrices."""
    (a11, a12), (a21, a22) = a
    (b11, b12), (b21, b22) = b
    return (
        (a11 * b11 + a12 * b21, a11 * b12 + a12 * b22),
        (a21 * b11 + a22 * b21, a21 * b12 + a22 * b22),
    )


def applied(a: BallMatrix, r: BallPair) -> BallPair:
    """Return a matrix times a vector."""
    return a[0][0] * r[0] + a[0][1] * r[1], a[1][0] * r[0] + a[1][1] * r[1]


def hull(states: Iterable[BallPair]) -> BallPair:
    """Return balls that hold all states."""
    return reduce(lambda a, b: (between(a[0], b[0]), between(a[1], b[1])), states)


@dataclass(frozen=True, slots=True)
class Cloud:
    """The set middle + axes * spread.

    Attributes
    ----------
    middle
        An exact point.
    axes
        Two directions as columns, exact.
    spread
        Intervals along them.
    """

    middle: BallPair
    axes: BallMatrix
    spread: BallPair

    @classmethod
    def of(cls, t: arb, v: arb) -> Cloud:
        """Return the box of two balls."""
        middle = t.mid(), v.mid()
        one, zero = arb(1), arb(0)
        return cls(middle, ((one, zero), (zero, one)), (t - middle[0], v - middle[1]))

    def box(self) -> BallPair:
        """Return balls that hold t and v."""
        dt, dv = applied(self.axes, self.spread)
        return self.middle[0] + dt, self.middle[1] + dv

    def image(self, point: BallPair, derivative: BallMatrix) -> Cloud:
        """Return the image under a map with this value at the middle and derivative on the set."""
        moved = times(derivative, self.axes)
        middle = point[0].mid(), point[1].mid()
        rest = point[0] - middle[0], point[1] - middle[1]
        c, s = _direction(moved, self.spread)
        # The inverse of ((c, -s), (s, c)), whose entries are exact, is its transpose over this.
        size = c * c + s * s
        back: BallMatrix = ((c / size, s / size), (-s / size, c / size))
        along, more = applied(times(back, moved), self.spread), applied(back, rest)
        return Cloud(middle, ((c, -s), (s, c)), (along[0] + more[0], along[1] + more[1]))


def _direction(columns: BallMatrix, spread: BallPair) -> BallPair:
    """Return the direction of the longer side of the image, nearly a unit vector."""
    first, second = ((float(columns[0][k]), float(columns[1][k])) for k in (0, 1))
    by = spread[0].abs_upper() * math.hypot(*first), spread[1].abs_upper() * math.hypot(*second)
    x, y = first if by[0] >= by[1] else second
    size = math.hypot(x, y)
    if not 0.0 < size < math.inf:
        return arb(1), arb(0)
    return arb(x / size), arb(y / size)
