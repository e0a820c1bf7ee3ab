"""Integrals over an oracle's motion: of x^2, of the forcing's power, and of the time in touch."""

from __future__ import annotations

import mpmath
from mpmath import mp
from mpmath.calculus.quadrature import GaussLegendre
from tests.oracle.curves import Flight, Real
from tests.oracle.event_driven import Piece, Problem, Run, Soft, number

# Over a unit of phase Gauss's rule with twelve nodes, which mpmath calls its third degree, leaves
# 1e-27; they are made with many more digits than that.
DEGREE, BITS = 3, 300


def integrals(problem: Problem, run: Run, t_end: Real) -> tuple[Real, Real, Real]:
    """Return the integrals of x^2 and of the power of the forcing, and the time in touch."""
    # As many as the flights were made with.
    with mpmath.workdps(6 * run.digits + 20):
        square, work, touch = mp.zero, mp.zero, mp.zero
        fastest = max([mp.one, *(number(part.omega) for part in problem.harmonics)])
        for t, following, piece in zip(
            run.starts, [*run.starts[1:], number(t_end)], run.pieces, strict=True
        ):
            end = following - t
            if end <= 0:
                continue
            if not isinstance(piece, Flight):
                square += piece**2 * end
                touch += end
                continue
            steps = int(mpmath.ceil(end * max(fastest, mpmath.sqrt(abs(piece.k)))))
            half = end / (2 * steps)
            knot = _knot(problem, t + end / 2)
            for middle in (half * (2 * i + 1) for i in range(steps)):
                for node, weight in GaussLegendre(mp).calc_nodes(DEGREE, BITS):
                    s = middle + half * node
                    x, v = piece.state(s)
                    square += half * weight * x**2
                    work += half * weight * v * _force(problem, t + s, knot)
            if any(_touches(stop, piece.value(end / 2)) for stop in problem.stops):
                touch += end
        return square, work, touch


def _knot(problem: Problem, t: Real) -> Piece:
    """Return the piece of the record in which a flight is: its flights end at the knots."""
    before = [piece for piece in problem.pieces if number(piece.t) <= t]
    return max(before, key=lambda piece: number(piece.t), default=Piece(0, 0))


def _force(problem: Problem, t: Real, knot: Piece) -> Real:
    force = number(problem.constant)
    force += number(knot.force) + number(knot.slope) * (t - number(knot.t))
    for part in problem.harmonics:
        cosine, sine = mpmath.cos_sin(number(part.omega) * t)
        force += number(part.cos) * cosine + number(part.sin) * sine
    return force


def _touches(stop: object, x: Real) -> bool:
    if not isinstance(stop, Soft):
        return False
    depth = x - number(stop.at)
    return bool(depth > 0 if stop.side == "above" else depth < 0)
