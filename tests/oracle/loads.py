"""Integrals over an oracle's motion: of x^2, of the forcing's power, and of the time in touch."""

from __future__ import annotations

from typing import Any

import mpmath
from mpmath import mp
from tests.oracle.curves import Flight, Real
from tests.oracle.event_driven import Piece, Problem, Run, Soft, number

# Parts of a unit of phase over which Gauss's rule is taken: with twelve nodes, which mpmath calls
# its third degree, it leaves 1e-35.
PARTS = 2
RULE: dict[str, Any] = {"method": "gauss-legendre", "maxdegree": 3}


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
            steps = int(mpmath.ceil(end * max(fastest, mpmath.sqrt(abs(piece.k))) * PARTS))
            nodes = mpmath.linspace(0, end, steps + 1)
            square += mpmath.quad(lambda s, p=piece: p.state(s)[0] ** 2, nodes, **RULE)
            knot = _knot(problem, t + end / 2)
            work += mpmath.quad(
                lambda s, p=piece, t=t, k=knot: _force(problem, t + s, k) * p.state(s)[1],
                nodes,
                **RULE,
            )
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
