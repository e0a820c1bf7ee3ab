"""Position and velocity at a time, from the pieces of a march."""

from __future__ import annotations

import math
from bisect import bisect_right

from flint import arb, ctx

from percuss.certified.cloud import Pair, applied
from percuss.certified.contact import Hold, Hops
from percuss.certified.flight import propagator
from percuss.certified.law import law_of
from percuss.certified.numbers import between, order_of, precision, time_ball
from percuss.certified.record import Ending, MarchRecord
from percuss.certified.step import Departure, flight_of
from percuss.certified.system import System
from percuss.errors import ParameterError
from percuss.model.exact import Phase

__all__ = ["is_proven", "state_at"]

FLOAT_BITS = 64
# Up to the very end that was asked for; the others end at an event or before a question.
TO_THE_END = (Ending.reached_t_end, Ending.at_rest)


def is_proven(record: MarchRecord, time: Phase) -> bool:
    """Tell whether a time lies within what is proven, for certain."""
    if record.begin is not None and order_of(time, record.begin) < 0:
        return False
    if record.ending in TO_THE_END and record.end is not None:
        return order_of(time, record.end) <= 0
    with precision(max(FLOAT_BITS, ctx.prec)):
        # A float is exact here, however few bits were worked with. What follows an event may
        # have an event of its own within the radius.
        return bool(time_ball(time) <= record.until)


def state_at(system: System, record: MarchRecord, time: Phase) -> Pair:
    """Return balls of x and v at a time; at an event, of both of its sides.

    Raises
    ------
    ParameterError
        If the time lies outside of what is proven.
    """
    t = time_ball(time)
    pieces = record.pieces
    if not pieces or t < pieces[0].start or not is_proven(record, time):
        first = pieces[0].start if pieces else record.until
        reason = f"outside of what is proven, {float(first):.12g} to {float(record.until):.12g}"
        raise ParameterError("t", time, reason)
    found: Pair | None = None
    latest = math.nextafter(float(t.upper()), math.inf)
    for i in range(bisect_right(record.earliest(), latest) - 1, -1, -1):
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
    # By the mean value theorem, with the derivatives of all flights, each from its own start.
    all_ = s if what.time is not None else t - what.cloud.box()[0]
    whole, point = flight_of(system, what, whole=True), flight_of(system, what, whole=False)
    (x, v), _ = point.derivatives(s, 1)
    a11, a12, a21, a22 = propagator(whole.region, all_)
    v0, a0 = whole.v0, whole.a0
    by_t = -(a11 * v0 + a12 * a0), -(a21 * v0 + a22 * a0)
    dt, dv = applied(what.cloud.axes, what.cloud.spread)
    return x + by_t[0] * dt + a12 * dv, v + by_t[1] * dt + a22 * dv
