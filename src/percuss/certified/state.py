"""Position and velocity at a time, from the pieces of a march."""

from __future__ import annotations

from bisect import bisect_right

from flint import arb

from percuss.certified.cloud import Pair, applied
from percuss.certified.contact import Hold, Hops
from percuss.certified.flight import propagator
from percuss.certified.law import law_of
from percuss.certified.numbers import between, time_ball
from percuss.certified.record import Record
from percuss.certified.step import Departure, flight_of
from percuss.certified.system import System
from percuss.errors import ParameterError
from percuss.model.exact import Phase

__all__ = ["state_at"]


def state_at(system: System, record: Record, time: Phase) -> Pair:
    """Return balls of x and v at a time; at an event, of both of its sides.

    Raises
    ------
    ParameterError
        If the time lies outside of what is proven.
    """
    t = time_ball(time)
    pieces = record.pieces
    if not pieces or t < pieces[0].start or t > record.until:
        first = pieces[0].start if pieces else record.until
        reason = f"outside of what is proven, {float(first):.12g} to {float(record.until):.12g}"
        raise ParameterError("t", time, reason)
    # Instants of pieces rise, but where a hop and the end of its chatter share one.
    last = bisect_right([float(piece.start) for piece in pieces], float(t))
    found: Pair | None = None
    for i in range(min(last, len(pieces) - 1), -1, -1):
        if t < pieces[i].start:
            continue
        following = pieces[i + 1].start if i + 1 < len(pieces) else None
        if following is not None and t > following:
            break
        here = _on_piece(system, pieces[i].what, t)
        found = here if found is None else (between(found[0], here[0]), between(found[1], here[1]))
    assert found is not None
    return found


def _on_piece(system: System, what: Departure | Hold | Hops, t: arb) -> Pair:
    if isinstance(what, Hops):
        return what.x, what.v
    if isinstance(what, Hold):
        return law_of(system).places[what.bound], arb(0)
    began = what.cloud.middle[0] if what.time is None else time_ball(what.time)
    s = t - began
    whole, point = flight_of(system, what, whole=True), flight_of(system, what, whole=False)
    (x, v), _ = point.derivatives(s, 1)
    a11, a12, a21, a22 = propagator(whole.region, s)
    v0, a0 = whole.v0, whole.a0
    by_t = -(a11 * v0 + a12 * a0), -(a21 * v0 + a22 * a0)
    dt, dv = applied(what.cloud.axes, what.cloud.spread)
    return x + by_t[0] * dt + a12 * dv, v + by_t[1] * dt + a22 * dv
