"""The extremes of a quantity of an oracle's motion, by the zeros of its derivative."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
from mpmath import mp
from tests.oracle.curves import Flight, Force, Real
from tests.oracle.event_driven import Run, number
from tests.oracle.roots import Search

# The value is a sum of weights times x, x', x'' and so on.
Weights = tuple[Real, ...]


@dataclass(frozen=True)
class Combination:
    """A sum of derivatives of a flight, or of a force, from ``begin`` on."""

    of: Flight | Force
    weights: Weights
    begin: Real

    def value(self, s: Real) -> Real:
        """Return it at s."""
        return self.taylor(s, 0)[0]

    def taylor(self, s: Real, order: int) -> list[Real]:
        """Return its Taylor coefficients at s."""
        parts = self.of.taylor(self.begin + s, max(2, order + len(self.weights)))
        return [
            mpmath.fsum(
                weight * parts[n + i] * mpmath.factorial(n + i) / mpmath.factorial(n)
                for i, weight in enumerate(self.weights)
            )
            for n in range(order + 1)
        ]

    def bound(self, coefficients: list[Real], n: int, h: Real) -> Real:
        """Return a bound of the n-th derivative: it obeys the flight's equation itself."""
        force = self.of if isinstance(self.of, Force) else self.of.force
        push = mpmath.fsum(abs(w) * force.bound([], max(1, n + i), h)
                           for i, w in enumerate(self.weights))  # fmt: skip
        if isinstance(self.of, Force):
            return push
        k = self.of.k
        rho = mpmath.sqrt(abs(k)) if k else mp.one
        now = coefficients[n] * mpmath.factorial(n)
        slope = coefficients[n + 1] * mpmath.factorial(n + 1)
        start = mpmath.hypot(rho * now, slope)
        return (start + push * h) * mpmath.exp(abs(rho - k / rho) / 2 * h) / rho


def zeros(
    of: Flight | Force, weights: Weights, end: Real, digits: int, level: Real = 0
) -> list[Real]:
    """Return where a combination passes a level in (0, end)."""
    found: list[Real] = []
    begin = mp.zero
    tiny = mpmath.mpf(10) ** (-digits)
    while begin < end:
        curve = Combination(of, weights, begin)
        coefficients = curve.taylor(mp.zero, 8)
        coefficients[0] -= number(level)
        order = next((n for n, c in enumerate(coefficients) if abs(c) > tiny), None)
        if order is None:
            return found
        sign = 1 if coefficients[order] > 0 else -1
        root = Search(curve, number(level), sign, order, digits).first_root(end - begin)
        if root is None:
            return found
        begin += root
        found.append(begin)
    return found


def extremes(
    run: Run, weights: Weights, t_end: Real, edge: tuple[Real, int] | None = None
) -> tuple[Real, Real, Real, Real]:
    """Return (least, its instant, greatest, its instant) of a quantity up to t_end.

    ``edge`` is (at, side): the quantity is that of a soft stop, x counts from ``at`` and it acts
    beyond it, above with side 1.
    """
    digits = run.digits
    with mpmath.workdps(4 * digits + 20):
        weights = tuple(number(w) for w in weights)
        at = number(edge[0]) if edge else mp.zero
        values: list[tuple[Real, Real]] = []
        for t, following, piece in zip(
            run.starts, [*run.starts[1:], number(t_end)], run.pieces, strict=True
        ):
            end = following - t
            if end < 0 or (end == 0 and following < t_end):
                continue
            if not isinstance(piece, Flight):
                beyond = edge is None or edge[1] * (piece - at) > 0
                values.append((weights[0] * (piece - at) if beyond else mp.zero, t))
                continue
            middle = piece.value(end / 2)
            if edge is not None and edge[1] * (middle - at) <= 0:
                values.append((mp.zero, t))
                continue
            slope = (mp.zero, *weights)
            for s in [mp.zero, *zeros(piece, slope, end, digits), end]:
                shifted = Combination(piece, weights, s)
                values.append((shifted.value(mp.zero) - weights[0] * at, t + s))
        least, greatest = min(values, key=lambda v: v[0]), max(values, key=lambda v: v[0])
        return (*least, *greatest)
