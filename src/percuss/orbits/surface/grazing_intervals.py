"""Intervals of a period in which the force leads a mass off a stop, so that it can graze it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from percuss.arrays import Floats
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.kernels.pieces import knot_time, record_at
from percuss.numerics import atan2, modulus, polynomial_roots
from percuss.numerics import cos as cos_of
from percuss.numerics import sin as sin_of

# Distance from the unit circle of roots of the polynomial that are taken for zeros of the force.
NEAR = 1e-5
NEWTON_STEPS = 6


def grazing_intervals(law: Law, constant: float, sign: float) -> list[tuple[float, float]]:
    """Return the open intervals of a period in which sign * (constant + harmonic force) > 0.

    The force is a trigonometric polynomial, its zeros are those of an algebraic one on the unit
    circle, refined by Newton's method. Under a record they are isolated on each of its pieces by
    bounds of the derivatives.

    Parameters
    ----------
    law
        The law of a system with a period.
    constant
        The constant force.
    sign
        +1 or -1.

    Returns
    -------
    list of (float, float)
        Beginnings, in [0, period), and ends, up to one period later; (0, period) if it is
        positive all the time.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.model.system import law
    >>> grazing_intervals(law(pc.impact_oscillator(), pc.sine(1.0)), 0.0, -1.0)
    [(3.141592653589793, 6.283185307179586)]
    """
    n, period = int(law[0, at.N_HARMONICS]), float(law[0, at.PERIOD])
    if law[0, at.N_KNOTS] > 0.0:
        return _under_record(law, constant, sign, period)
    rows = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
    omega, cos, sin = rows[:, at.OMEGA], rows[:, at.COSINE], rows[:, at.SINE]
    zeros = _zeros(omega, cos, sin, constant, period)
    if zeros.size == 0:
        return [(0.0, period)] if sign * (constant + cos.sum()) > 0.0 else []
    ends = np.append(zeros[1:], zeros[0] + period)
    middles = 0.5 * (zeros + ends)
    force = constant + (cos * cos_of(np.outer(middles, omega))).sum(axis=1)
    force += (sin * sin_of(np.outer(middles, omega))).sum(axis=1)
    intervals: list[tuple[float, float]] = []
    for first, last, value in zip(zeros.tolist(), ends.tolist(), force.tolist(), strict=True):
        if sign * value > 0.0:
            _append(intervals, first, last)
    return intervals


def _append(intervals: list[tuple[float, float]], first: float, last: float) -> None:
    """Append an interval, or prolong the one before it: between them the force is zero at once."""
    # A double zero is one instant of an interval: a graze of zero acceleration.
    if intervals and intervals[-1][1] == first:
        first, _ = intervals.pop()
    intervals.append((first, last))


def _zeros(omega: Floats, cos: Floats, sin: Floats, constant: float, period: float) -> Floats:
    """Return the zeros of the force in [0, period), ascending; none where it is constant."""
    orders = np.rint(omega * period / (2.0 * np.pi)).astype(np.int64)
    most = int(orders.max(initial=0))
    if most == 0 or not (cos.any() or sin.any()):
        return np.empty(0)
    coefficients = np.zeros(2 * most + 1, dtype=np.complex128)
    coefficients[most] = constant
    for m, c, s in zip(orders, cos, sin, strict=True):
        coefficients[most - m] += 0.5 * complex(c, -s)
        coefficients[most + m] += 0.5 * complex(c, s)
    roots = polynomial_roots(coefficients)
    roots = roots[np.abs(modulus(roots) - 1.0) < NEAR]
    angles = atan2(roots.imag, roots.real)
    t = np.mod(angles / (2.0 * np.pi), 1.0) * period
    for _ in range(NEWTON_STEPS):
        phase = np.outer(t, omega)
        value = constant + (cos * cos_of(phase) + sin * sin_of(phase)).sum(axis=1)
        slope = (omega * (sin * cos_of(phase) - cos * sin_of(phase))).sum(axis=1)
        step = np.divide(value, slope, out=np.zeros_like(t), where=slope != 0.0)
        t = t - np.where(np.abs(step) < 1e-3 * period, step, 0.0)
    t = np.unique(np.mod(t, period))
    return t[np.diff(t, prepend=-1.0) > 1e-14 * period]


# A stretch this short, as a part of the period, that bounds leave open holds a double zero.
SHORTEST = 1e-13
HALVINGS = 60


def _under_record(
    law: Law, constant: float, sign: float, period: float
) -> list[tuple[float, float]]:
    knots = [sum(knot_time(law, k, 0.0)) for k in range(int(law[0, at.N_KNOTS]))]
    edges = np.unique(np.append(np.mod([*knots, 0.0], period), period)).tolist()
    intervals: list[tuple[float, float]] = []
    for first, last in pairwise(edges):
        force = _PieceForce.of(law, constant, sign, 0.5 * (first + last))
        for begin, end in pairwise([first, *force.zeros(first, last, SHORTEST * period), last]):
            if force(0.5 * (begin + end)) > 0.0:
                _append(intervals, begin, end)
    if len(intervals) > 1 and intervals[0][0] == 0.0 and intervals[-1][1] == period:
        # A period begins within an interval.
        (_, end), *others, (begin, _) = intervals
        intervals = [*others, (begin, end + period)]
    return intervals


@dataclass(frozen=True)
class _PieceForce:
    """The force on a piece of a record: level + slope (t - middle) + harmonics, times a sign."""

    middle: float
    level: float
    slope: float
    omega: Floats
    cos: Floats
    sin: Floats

    @classmethod
    def of(cls, law: Law, constant: float, sign: float, middle: float) -> _PieceForce:
        """Return the force of the piece that holds an instant."""
        rows = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + int(law[0, at.N_HARMONICS]) - 1]
        force, slope = record_at(law, middle, 0.0)
        cos, sin = sign * rows[:, at.COSINE], sign * rows[:, at.SINE]
        level, omega = sign * (constant + force), rows[:, at.OMEGA].copy()
        return cls(middle, level, sign * slope, omega, cos, sin)

    def __call__(self, t: float) -> float:
        """Return the force at an instant."""
        phase = self.omega * t
        tones = self.cos * cos_of(phase) + self.sin * sin_of(phase)
        return float(self.level + self.slope * (t - self.middle) + tones.sum())

    def rate(self, t: float) -> float:
        """Return its derivative."""
        phase = self.omega * t
        tones = self.omega * (self.sin * cos_of(phase) - self.cos * sin_of(phase))
        return float(self.slope + tones.sum())

    def zeros(self, low: float, high: float, shortest: float) -> Iterator[float]:
        """Yield the simple zeros between two instants, ascending."""
        bend = float((self.omega**2 * (np.abs(self.cos) + np.abs(self.sin))).sum())
        if bend == 0.0 and self.slope == 0.0:
            return
        stack = [(low, high)]
        while stack:
            a, b = stack.pop()
            half, middle = 0.5 * (b - a), 0.5 * (a + b)
            value, rate = self(middle), self.rate(middle)
            if abs(value) > abs(rate) * half + 0.5 * bend * half * half:
                continue
            if abs(rate) > bend * half:
                if (self(a) < 0.0) != (self(b) < 0.0):
                    yield self._between(a, b)
            elif half > shortest:
                stack += [(middle, b), (a, middle)]

    def _between(self, a: float, b: float) -> float:
        """Return the only zero between two instants of different signs."""
        rises = self(b) > self(a)
        for _ in range(HALVINGS):
            middle = 0.5 * (a + b)
            if not a < middle < b:
                break
            if (self(middle) < 0.0) == rises:
                a = middle
            else:
                b = middle
        return 0.5 * (a + b)
