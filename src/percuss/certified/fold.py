"""Folds: the curve of orbits runs along one of its own coordinates, and the parameter turns.

With one coordinate given, the others and the parameter solve regular equations. Along that curve
the parameter's derivative is a nonzero factor times 1 - trace + determinant; where this changes
its sign the parameter is extremal.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat, arb_series, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw
from percuss.certified.branch import NEXT_TO_ZERO, is_positive, root_of, system_at, system_over
from percuss.certified.cloud import BallPair
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import ball, constant_of, exact_value
from percuss.certified.pieces import Moment
from percuss.certified.properties import admissible_of, monodromy_of
from percuss.certified.shooting import (
    Image,
    OrbitEvent,
    Residual,
    Shooting,
    Solved,
    States,
    Vector,
    check_inside,
    krawczyk,
    matrix_of,
    newton,
    pairs,
    shooting_of,
    vector_of,
)
from percuss.certified.system import BallSystem, system_of
from percuss.numerics import directions
from percuss.orbits.bifurcations.special_points import SpecialPoint

# Bits of derivatives.
COARSE = 128


@contextmanager
def law_along(system: BallSystem, path: str, value: arb) -> Iterator[BallLaw]:
    """Yield the law as series, to first order, in a parameter about a ball of its values."""
    cap = ctx.cap
    ctx.cap = 2
    try:
        yield BallLaw(system, path, arb_series([value, arb(1)]))  # type: ignore[arg-type]
    finally:
        ctx.cap = cap


@dataclass(frozen=True)
class OrbitCurve:
    """The orbits of one sequence of events, along which coordinates and a parameter change.

    Attributes
    ----------
    system, path
        The system, and the path of the parameter in it.
    events, n_periods
        Those of the orbits.
    mirrored
        Whether the orbits are symmetric, and the coordinates those of half of each.
    """

    system: BallSystem
    events: list[OrbitEvent]
    n_periods: int
    path: str
    mirrored: bool = field(default=False, kw_only=True)

    def equations(self, value: arb) -> Shooting:
        """Return the equations for a ball of the parameter."""
        middle = exact_value(value)
        if value.is_exact():
            system = system_at(self.system, self.path, middle)
        else:
            radius = exact_value(value.rad().upper()) * 2
            system = system_over(self.system, self.path, middle - radius, middle + radius)
        return self.equations_of(system)

    def equations_of(self, system: BallSystem) -> Shooting:
        """Return the equations of a system."""
        return Shooting.of(system, self.events, self.n_periods, mirrored=self.mirrored)

    @staticmethod
    def coarse() -> int:
        """Return the bits of derivatives."""
        return min(ctx.prec, COARSE)

    def by_parameter(
        self, equations: Shooting, states: States, value: arb, bits: int | None = None
    ) -> Vector:
        """Return the derivative of the equations by the parameter, to some bits or the usual ones."""
        with law_along(equations.system, self.path, value) as law:
            images = [self._flight_by_parameter(equations, law, states, i, bits or self.coarse())
                      for i in range(len(states))]  # fmt: skip
            by_t, by_v = images[-1]
            later = slope_of(law.period(self.n_periods))
            images[-1] = (by_t - later / 2, -by_v) if self.mirrored else (by_t - later, by_v)
        # The last flight leads to the first event.
        return vector_of([images[-1], *images[:-1]])

    def _flight_by_parameter(
        self, equations: Shooting, law: BallLaw, states: States, i: int, bits: int
    ) -> tuple[arb, arb]:
        event, following = equations.events[i], equations.next_event(i)
        t, v = states[i]
        arrival, _ = equations.arrival(i, states, bits)
        pieces = [start.piece for start, _ in equations.pieces_of_flight(i, states)]
        place, begin = law.places[event.bound], Moment(t)
        flight = flight_from(law, event.after, begin, (place, v), pieces[0])
        for piece in pieces[1:]:
            # The knot may move with the parameter: its instant is a series, too.
            knot = law.next_knot(piece - 1)
            assert knot is not None
            (x, speed), _ = flight.derivatives(knot.t - begin.t, 1)
            begin, flight = knot, flight_from(law, event.after, knot, (x, speed), piece)
        (x1, v1, a1), _ = flight.derivatives(arrival.box[0] - begin.t, 2)
        later = -(slope_of(x1) - slope_of(law.places[following.bound])) / constant_of(v1)
        faster = slope_of(v1) + constant_of(a1) * later
        return later, slope_after(equations, law, following, constant_of(v1), faster)


@dataclass(frozen=True)
class OrbitsAlong(OrbitCurve):
    """The orbits along one of their coordinates, number ``along``; the parameter takes its place."""

    along: int

    def split(self, w: Vector, eta: arb) -> tuple[Vector, arb]:
        """Return the states, with the given coordinate, and the parameter."""
        z = list(w)
        value, z[self.along] = z[self.along], eta
        return z, value

    def with_column(self, matrix: arb_mat, w: Vector, eta: arb, bits: int) -> arb_mat:
        """Return a derivative with that by the parameter in place of that by the coordinate."""
        z, value = self.split(w, eta)
        column = self.by_parameter(self.equations(value), pairs(z), value, bits)
        table = matrix.tolist()
        for row, entry in zip(table, column, strict=True):
            row[self.along] = entry
        return arb_mat(table)

    def solution(self, eta: arb, guess: Vector) -> Vector:
        """Return the orbit and the parameter at a value of the coordinate."""
        # Newton's method doubles digits with derivatives to all bits alone.
        residual = CurveResidual(self, eta, ctx.prec)

        def step(w: Vector) -> arb_mat:
            missed = residual.value(w).mid()
            return residual.derivative(w).mid().solve(missed)

        return newton(step, guess)

    def enclosed(self, middle: Vector, eta: arb) -> Solved:
        """Return the boxes of the orbits for a ball of the coordinate."""
        residual = CurveResidual(self, eta, self.coarse())
        return krawczyk(residual.value, residual.derivative, middle)

    def fold_function(self, w: Vector, eta: arb) -> arb:
        """Return 1 - trace + determinant."""
        z, value = self.split(w, eta)
        monodromy, _ = monodromy_of(self.equations(value), pairs(z))
        return 1 - monodromy.trace + monodromy.determinant


def flight_from(
    law: BallLaw, region: int, moment: Moment, state: BallPair, piece: int
) -> EnclosedFlight:
    """Return the flight from a state under a piece of the record, numbers or series."""
    ramp = law.ramp(piece, moment)
    return EnclosedFlight(law, region, law.phasors(moment.t), *state, ramp=ramp)


class CurveResidual(Residual):
    """The equations at a value of the coordinate; the parameter is the unknown in its place.

    Derivatives have so many bits.
    """

    def __init__(self, curve: OrbitsAlong, eta: arb, bits: int) -> None:
        super().__init__(self._images)
        self.curve, self.eta, self.bits = curve, eta, bits

    def _images(self, w: Vector) -> list[Image]:
        z, value = self.curve.split(w, self.eta)
        return self.curve.equations(value).images(pairs(z), self.bits)

    def value(self, z: Vector) -> arb_mat:
        """Return by how much the orbit misses itself."""
        return self.missed(z, self.curve.split(z, self.eta)[0])

    def derivative(self, z: Vector) -> arb_mat:
        """Return the derivative by the other coordinates and the parameter."""
        return self.curve.with_column(super().derivative(z), z, self.eta, self.bits)


class Turn(NamedTuple):
    """A stretch of a coordinate on which the parameter turns: middle, half-width, and the orbit there."""

    curve: OrbitsAlong
    middle: Fraction
    half: Fraction
    orbit: Vector


def turn_of(point: SpecialPoint, path: str, digits: int) -> Turn:
    """Return about where the parameter turns along a coordinate, and a stretch for so many digits."""
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    equations, guess = shooting_of(system, point.orbit)
    w = vector_of(guess)
    along = _null_coordinate(equations, guess)
    curve = OrbitsAlong(system, equations.events, point.orbit.n_periods, path, along)
    start, w[along] = exact_value(w[along]), arb(point.value)

    def test(eta: Fraction) -> arb:
        nonlocal w
        w = curve.solution(ball(eta).mid(), w)
        return curve.fold_function(w, ball(eta).mid())

    scale = _scale(equations, guess)[along]
    size = max(abs(start), Fraction(scale) * NEXT_TO_ZERO)
    zero = root_of(test, start, size)
    return Turn(curve, zero, size / 10 ** (digits + 3), curve.solution(ball(zero).mid(), w))


def fold_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter at a fold.

    And whether the orbits of the stretch are admissible, None where that is open.
    """
    curve, zero, width, w = turn_of(point, path, digits)
    whole = ball(zero - width).union(ball(zero + width))
    solved = curve.enclosed(w, whole)
    signs = []
    for eta in (zero - width, zero + width):
        near = ball(eta).mid()
        box = curve.enclosed(curve.solution(near, w), near).box
        check_inside(solved.trial, box)
        signs.append(is_positive(curve.fold_function(box, near)))
    if signs[0] == signs[1]:
        raise Undecided("precision", "the parameter is not proven to turn")
    z, value = curve.split(solved.box, whole)
    return value, admissible_of(curve.equations(value), pairs(z))[0]


def _null_coordinate(equations: Shooting, states: States) -> int:
    """Return the coordinate that changes most where the equations are singular."""
    matrix = matrix_of(equations.images(states, ctx.prec))
    n = matrix.nrows()
    floats = np.array([[float(matrix[i, j]) for j in range(n)] for i in range(n)])
    _, rows = directions(floats * np.array(_scale(equations, states)))
    return int(np.argmax(np.abs(rows[-1])))


def _scale(equations: Shooting, states: States) -> list[float]:
    """Return the sizes of instants and velocities."""
    speed = max(abs(float(v)) for _, v in states)
    return [float(equations.period), speed] * len(states)


def slope_after(equations: Shooting, law: BallLaw, event: OrbitEvent, v: arb, faster: arb) -> arb:
    """Return the derivative of the velocity after an event, ``faster`` that of the one before, v."""
    if not event.wall:
        return faster
    # By the velocity, and by the parameter at the same velocity.
    kept = -event.passed(equations.system, v).kept
    return kept * faster + slope_of(law.rebound(event.stop or 0, v).after)


def slope_of(number: object) -> arb:
    """Return the derivative by the parameter."""
    return arb(0) if isinstance(number, arb) else number[1]  # type: ignore[index]
