"""Folds: the curve of orbits goes by one of its own coordinates, and the parameter turns.

With one coordinate given, the others and the parameter solve regular equations. Along that curve
the parameter's derivative is a nonzero factor times 1 - trace + determinant; where this changes
its sign the parameter is extremal.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb, arb_mat, arb_series, ctx

from percuss.certified.balls import Undecided
from percuss.certified.branch import (
    exact_ball,
    exact_value,
    root_of,
    system_at,
    system_over,
)
from percuss.certified.flight import EnclosedFlight
from percuss.certified.law import BallLaw, constant_of, law_of
from percuss.certified.orbits import monodromy_over, shooting_of
from percuss.certified.properties import admissible_of
from percuss.certified.shooting import (
    Image,
    Link,
    Residual,
    Shooting,
    Solved,
    greatest,
    krawczyk,
    matrix_of,
    pairs,
)
from percuss.certified.system import BallSystem, system_of
from percuss.orbits.bifurcations.special_points import SpecialPoint

__all__ = ["fold_of"]

MOST_STEPS = 60
COARSE = 128


@dataclass(frozen=True)
class OrbitsAlong:
    """The orbits along one of their coordinates, number ``along``; the parameter takes its place."""

    system: BallSystem
    chain: list[Link]
    n_periods: int
    path: str
    along: int

    def equations(self, value: arb) -> Shooting:
        """Return the equations for a ball of the parameter."""
        if value.is_exact():
            system = system_at(self.system, self.path, exact_value(value))
        else:
            middle = exact_value(value)
            apart = exact_value(value.rad().upper()) * 2
            system = system_over(self.system, self.path, middle - apart, middle + apart)
        return Shooting(system, self.chain, law_of(system).period(self.n_periods))

    def split(self, w: list[arb], eta: arb) -> tuple[list[arb], arb]:
        """Return the states, with the given coordinate, and the parameter."""
        z = list(w)
        value = z[self.along]
        z[self.along] = eta
        return z, value

    def residual(self, eta: arb) -> CurveResidual:
        """Return the equations, with the other coordinates and the parameter as unknowns."""
        return CurveResidual(self, eta)

    def with_column(self, matrix: arb_mat, w: list[arb], eta: arb) -> arb_mat:
        """Return a derivative with that by the parameter in place of that by the coordinate."""
        z, value = self.split(w, eta)
        column = self._by_parameter(self.equations(value), pairs(z), value)
        table = matrix.tolist()
        for row, entry in zip(table, column, strict=True):
            row[self.along] = entry
        return arb_mat(table)

    @staticmethod
    def coarse() -> int:
        """Return the bits of derivatives."""
        return min(ctx.prec, COARSE)

    def _by_parameter(
        self, equations: Shooting, states: list[tuple[arb, arb]], value: arb
    ) -> list[arb]:
        """Return the derivative of the equations by the parameter."""
        cap = ctx.cap
        ctx.cap = 2
        try:
            series = arb_series([value, arb(1)])
            law = BallLaw(equations.system, self.path, series)  # type: ignore[arg-type]
            n = len(states)
            column = [arb(0)] * (2 * n)
            for i in range(n):
                following = (i + 1) % n
                by_t, by_v = self._flight_by_parameter(equations, law, states, i)
                if following == 0:
                    by_t = by_t - _slope(law.period(self.n_periods))
                column[2 * following], column[2 * following + 1] = by_t, by_v
        finally:
            ctx.cap = cap
        return column

    def _flight_by_parameter(
        self, equations: Shooting, law: BallLaw, states: list[tuple[arb, arb]], i: int
    ) -> tuple[arb, arb]:
        n = len(states)
        following = (i + 1) % n
        link, end = self.chain[i], self.chain[following]
        t, v = states[i]
        until = states[following][0] + (equations.period if following == 0 else 0)
        there = equations.arrival(i, states[i], until, self.coarse())
        flight = EnclosedFlight(law, link.after, law.turns(t), law.places[link.bound], v)
        (x1, v1, a1), _ = flight.derivatives(there.box[0] - t, 2)
        later = -(_slope(x1) - _slope(law.places[end.bound])) / constant_of(v1)
        faster = _slope(v1) + constant_of(a1) * later
        if not end.wall:
            return later, faster
        kept = -law.number(f"oscillator.stops.{end.stop}.restitution")
        return later, constant_of(kept) * faster + _slope(kept) * constant_of(v1)

    def solution(self, eta: arb, guess: list[arb]) -> list[arb]:
        """Return the orbit and the parameter at a value of the coordinate."""
        w = [value.mid() for value in guess]
        residual = self.residual(eta)
        for _ in range(MOST_STEPS):
            try:
                missed = residual.value(w).mid()
                step = residual.derivative(w).mid().solve(missed)
            except ZeroDivisionError:
                break
            w = [(value - step[k, 0]).mid() for k, value in enumerate(w)]
            if greatest(step) < arb(2) ** -int(0.6 * ctx.prec):
                return w
        raise Undecided("precision", "Newton's method finds no orbit along the fold")


class CurveResidual(Residual):
    """The equations at a value of the coordinate; the parameter is the unknown in its place."""

    def __init__(self, curve: OrbitsAlong, eta: arb) -> None:
        super().__init__(self._images)
        self.curve, self.eta = curve, eta

    def _images(self, w: list[arb]) -> list[Image]:
        z, value = self.curve.split(w, self.eta)
        return self.curve.equations(value).images(pairs(z), self.curve.coarse())

    def value(self, z: list[arb]) -> arb_mat:
        """Return by how much the orbit misses itself."""
        return self._missed(z, self.curve.split(z, self.eta)[0])

    def derivative(self, z: list[arb]) -> arb_mat:
        """Return the derivative by the other coordinates and the parameter."""
        return self.curve.with_column(super().derivative(z), z, self.eta)


def fold_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter at a fold.

    And whether the orbits of the stretch pass through no stop, None where that is open.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    equations, guess = shooting_of(system, point.orbit)
    z = [value for state in guess for value in state]
    along = _null_coordinate(equations, guess)
    curve = OrbitsAlong(system, equations.chain, point.orbit.n_periods, path, along)
    w = list(z)
    w[along] = arb(point.value)

    def test(eta: Fraction) -> arb:
        nonlocal w
        w = curve.solution(exact_ball(eta).mid(), w)
        return _turning(curve, w, exact_ball(eta).mid())

    start = exact_value(z[along])
    size = Fraction(max(abs(float(z[along])), 1e-3))
    zero = root_of(test, start, size / 10**8)
    width = size / 10 ** (digits + 3)
    whole = exact_ball(zero - width).union(exact_ball(zero + width))
    curves = _solved(curve, curve.solution(exact_ball(zero).mid(), w), whole)
    signs = []
    for eta in (zero - width, zero + width):
        near = exact_ball(eta).mid()
        box = _solved(curve, curve.solution(near, w), near).box
        if not all(outer.contains(inner) for outer, inner in zip(curves.trial, box, strict=True)):
            raise Undecided("precision", "the ends of the curve lie outside of its box")
        found = _turning(curve, box, near)
        if not (found > 0 or found < 0):
            raise Undecided("precision", "the sign at an end of the curve is open")
        signs.append(bool(found > 0))
    if signs[0] == signs[1]:
        raise Undecided("precision", "the parameter does not turn on this stretch")
    states, value = curve.split(curves.box, whole)
    return value, admissible_of(curve.equations(value), pairs(states))[0]


def _solved(curve: OrbitsAlong, middle: list[arb], eta: arb) -> Solved:
    """Return the boxes of the orbits for a ball of the coordinate."""
    residual = curve.residual(eta)
    return krawczyk(residual.value, residual.derivative, middle)


def _turning(curve: OrbitsAlong, w: list[arb], eta: arb) -> arb:
    """Return 1 - trace + determinant."""
    z, value = curve.split(w, eta)
    equations = curve.equations(value)
    monodromy, _ = monodromy_over(equations, pairs(z))
    return 1 - monodromy.trace + monodromy.determinant


def _null_coordinate(equations: Shooting, states: list[tuple[arb, arb]]) -> int:
    """Return the coordinate that changes most where the equations are singular."""
    matrix = matrix_of([image.derivative for image in equations.images(states, ctx.prec)])
    n = matrix.nrows()
    floats = np.array([[float(matrix[i, j]) for j in range(n)] for i in range(n)])
    speed = max(abs(float(v)) for _, v in states)
    scale = np.array([float(equations.period), speed] * (n // 2))
    null = np.linalg.svd(floats * scale)[2][-1]
    return int(np.argmax(np.abs(null)))


def _slope(number: object) -> arb:
    """Return the derivative by the parameter."""
    return arb(0) if isinstance(number, arb) else number[1]  # type: ignore[index]
