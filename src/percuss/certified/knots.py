"""Events that may be at a knot of a record: what their order changes, where that is little."""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallPair
from percuss.certified.contact import Hops
from percuss.certified.numbers import constant_of, largest_abs, order_of, span
from percuss.certified.pieces import Moment
from percuss.certified.step import Arrival, Departure
from percuss.certified.system import BallSystem

# The window is so short that nothing else changes: as a part of the time in which anything does.
SHORT = 1e-3
# A velocity is so many times what can change it in the window.
FAST = 8


def is_first(one: Moment, other: Moment) -> bool:
    """Return whether an instant is not after another.

    Raises
    ------
    Undecided
        If the balls leave it open.
    """
    if one.time is not None and other.time is not None:
        return order_of(one.time, other.time) <= 0
    if one.t > other.t or one.t <= other.t:
        return bool(one.t <= other.t)
    reason = f"whether the run ends before the knot of the record at t = {float(other.t):.12g}"
    raise Undecided("precision", f"{reason} is open")


class Blur(NamedTuple):
    """What the order of an event and a knot can change.

    Attributes
    ----------
    t, v
        Of the instant and the velocity of the event.
    around
        The instants that event and knot may have, and all between them.
    window
        A bound of their distance.
    jump
        Bound of the difference of the forces in it.
    """

    t: arb
    v: arb
    around: arb
    window: arb
    jump: arb

    def after(self, system: BallSystem, region: int, bound: int, v: arb) -> BallPair:
        """Return what it changes of instant and velocity just after the event.

        Raises
        ------
        Undecided
            If the motion may meet another bound, or this one again, within the window.
        """
        ends, places = system.regions[region], law_of(system).places
        opposite = ends.upper if ends.lower == bound else ends.lower
        far = 2 * abs(v) * self.window
        if opposite is not None and not abs(places[opposite] - places[bound]) > far:
            raise Undecided("precision", "two events may lie within the radius of a knot")
        return _changes(self.window, self.jump, v, _strongest(system, region, bound, v))

    def states(self, system: BallSystem, regions: tuple[int, int], bound: int, v: BallPair) -> Hops:
        """Return balls of all states in the window, in either order.

        ``regions`` and ``v`` are those before and after the event.
        """
        place, both = law_of(system).places[bound], v[0].union(v[1])
        most = max((_strongest(system, region, bound, both) for region in regions), key=float)
        return Hops(
            self.around.upper(),
            place + span(2 * both.abs_upper() * self.window),
            both + span(self.v.abs_upper() + 2 * self.window * (most + self.jump)),
        )


def blur_at_knot(system: BallSystem, start: Departure, arrival: Arrival, knot: Moment) -> Blur:
    """Return what the order of an event and a knot changes, if the event comes in either order.

    Let both lie in a window w, and the forces before and after the knot differ by J in it. Motions
    that are under one for a part of the window, and under the other else, differ by J w in velocity
    and J w^2/2 in position: the event, at a velocity v that is larger than all changes of
    velocity in the window, comes once, earlier or later by J w^2/2v.

    Raises
    ------
    Undecided
        If it may not come, or a second knot lies within the radius.
    """
    law, where = law_of(system), f"the knot of the record at t = {float(knot.t):.12g}"
    t, v = arrival.box
    window = 3 * 2 * t.union(knot.t).rad()
    following = law.next_knot(start.piece + 1)
    if following is not None and not t.union(knot.t) + span(window) < following.t:
        raise Undecided(
            "precision", f"an event lies within its radius of two knots, one is {where}"
        )
    before, after = (law.ramp(start.piece + k, knot) for k in (0, 1))
    assert before is not None
    assert after is not None
    steep = window * (before.upper_slope() + after.upper_slope())
    jump = (constant_of(after.force - before.force).abs_upper() + steep).abs_upper()
    pace = max(max(r.pace, largest_abs(constant_of(r.damping))) for r in law.regions)
    if not window * max(pace, 1e-300) < SHORT:
        reason = f"whether an event comes before or after {where} is open, by {float(window):.2g}"
        raise Undecided("precision", reason)
    most = _strongest(system, start.region, arrival.bound, v)
    try:
        by_t, by_v = _changes(window, jump, v, most)
    except Undecided:
        reason = f"whether an event without speed to speak of comes before {where} is open"
        raise Undecided("precision", reason) from None
    return Blur(by_t, by_v, t.union(knot.t) + by_t, window, jump)


def _strongest(system: BallSystem, region: int, bound: int, v: arb) -> arb:
    """Return a bound of the acceleration at a bound with a velocity."""
    law = law_of(system)
    linear = law.regions[region]
    total = constant_of(linear.constant).abs_upper() + sum(law.strength)
    total += (constant_of(linear.stiffness) * law.places[bound]).abs_upper()
    total += (4 * constant_of(linear.damping) * v).abs_upper()
    if law.record is not None:
        total += law.record.extremes.abs_upper()
    return total.abs_upper()


def _changes(window: arb, jump: arb, v: arb, most: arb) -> BallPair:
    """Return what the order changes of instant and velocity, with as much again for the rest."""
    if not abs(v) > FAST * window * (most + jump):
        raise Undecided("precision", "an event at a knot has no speed to speak of")
    by_t = 2 * jump * window * window / v.abs_lower()
    return span(by_t), span(2 * jump * window + by_t * most)
