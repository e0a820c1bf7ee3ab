"""The motion in balls from event to event, and its record."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallPair, Cloud
from percuss.certified.contact import (
    Hold,
    Hops,
    chatter_end,
    first_push_at,
    is_still,
    release,
)
from percuss.certified.knots import Blur, blur_at_knot, is_first
from percuss.certified.numbers import ball, is_exact, time_ball
from percuss.certified.pieces import Moment
from percuss.certified.step import Arrival, Departure, at_moment, began, first_arrival
from percuss.certified.system import BallSystem, Bound, check_told_apart
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, as_fraction
from percuss.model.start import Start
from percuss.progress import RunProgress

# Events, hops of a chatter among them, and pieces of a record.
MOST_EVENTS = 100_000
# Hops are listed until they are slower than this part of the fastest impact, as in float runs.
SLOW = 1e-6


def on_stop(system: BallSystem, start: Start) -> Fraction:
    """Return the exact position of a start; next to it where it is irrational.

    A float that equals a stop's place as a float is that place exactly, since `simulate` starts on
    the stop; text or a fraction is taken as it was given, however close to the stop.

    Raises
    ------
    ParameterError
        If balls cannot tell an irrational place from another.
    """
    x = as_fraction(start.x0)
    for bound in system.bounds:
        if isinstance(start.x0, float) and float(bound.at) == start.x0:
            return bound.at
        place = _place_of(system, bound)
        if place == start.x0:
            return bound.at
        check_told_apart("x0", start.x0, place)
    return x


def _place_of(system: BallSystem, bound: Bound) -> Exact:
    """Return the place of a bound as it was given."""
    stop = bound.wall if bound.wall is not None else bound.edges[0]
    return system.oscillator.stops[stop].at


def start_used(system: BallSystem, start: Start) -> Start:
    """Return the exact start of which a proof holds.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.certified.system import system_of
    >>> start_used(system_of(pc.impact_oscillator(wall="0.3"), None), pc.Start(0.3, 1))
    Start(x0=Fraction(3, 10), v0=1, t0=0.0)
    """
    x = on_stop(system, start)
    if x == as_fraction(start.x0):
        return start
    places = (_place_of(system, bound) for bound in system.bounds if bound.at == x)
    irrational = (place for place in places if not is_exact(place))
    return replace(start, x0=next(irrational, x))


def moved_in_words(used: Start, given: Start) -> str:
    """Return words that say that a start was moved to a stop; none if it was not."""
    if used == given:
        return ""
    return f"; started on the stop, at x0 = {used.x0} for {given.x0}"


class Ending(Enum):
    """How a proof ended; the value is the sentence to show.

    Examples
    --------
    >>> Ending.graze.value
    'the proof ends at a touch that the balls cannot decide'
    """

    reached_t_end = "proven up to t_end"
    reached_max_impacts = "proven up to max_impacts (impacts and entries into soft stops)"
    at_rest = "the mass provably came to rest at a stop for good"
    impact_at_t_end = "proven up to t_end; the last event lies within its radius of it"
    graze = "the proof ends at a touch that the balls cannot decide"
    force = "the proof ends at rest on a stop, where the sign of the force is open"
    chatter = "the proof ends in a chatter whose end lies within the radius, or too far"
    no_event = "the proof ends in a flight in which no event was found"
    most_events = "the proof ends after the most events that are listed"
    interrupted = "the proof was interrupted; it holds what was done"
    precision = "the proof ends where the balls have grown too wide"


class ImpactRow(NamedTuple):
    """An impact."""

    t: arb
    v_before: arb
    v_after: arb
    stop: int


class CrossingRow(NamedTuple):
    """A crossing of the edge of a soft stop."""

    t: arb
    v: arb
    stop: int
    direction: str


class ContactRow(NamedTuple):
    """A contact; the release is None if it did not come."""

    start: arb
    release: arb | None
    stop: int
    n_impacts: int


class GrazeRow(NamedTuple):
    """A touch that the balls cannot decide."""

    t: arb
    stop: int
    clearance: arb


class Piece(NamedTuple):
    """A flight, a contact or the rest of a chatter, from an instant on; at a knot it only goes on."""

    start: arb
    what: Departure | Hold | Hops
    at_knot: bool = False


@dataclass
class MarchRecord:
    """Events and pieces of a motion, and how its proof ended.

    ``width`` is a time in which little changes: the scale of instants near 0. ``begin`` and ``end``
    are the exact times of start and limit.
    """

    bits: int
    width: float = 1.0
    impacts: list[ImpactRow] = field(default_factory=list)
    crossings: list[CrossingRow] = field(default_factory=list)
    contacts: list[ContactRow] = field(default_factory=list)
    grazes: list[GrazeRow] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    until: arb = field(default_factory=lambda: arb(0))
    ending: Ending = Ending.reached_t_end
    reason: str = ""
    n_entries: int = 0
    begin: Phase | None = None
    end: Phase | None = None
    _earliest: list[float] = field(default_factory=list, repr=False)

    @property
    def accumulations(self) -> int:
        """Number of chatters that end."""
        hops = (piece for piece, _ in pairwise(self.pieces) if not piece.at_knot)
        return sum(isinstance(piece.what, Hops) for piece in hops)

    def earliest(self) -> list[float]:
        """Return, for each piece, a float before which neither it nor a later one begins."""
        if len(self._earliest) != len(self.pieces):
            earliest, least = [], math.inf
            for piece in reversed(self.pieces):
                least = min(least, math.nextafter(float(piece.start.lower()), -math.inf))
                earliest.append(least)
            self._earliest = earliest[::-1]
        return self._earliest


class MarchLimits:
    """Where a motion ends: at an instant, or after impacts and entries into soft stops.

    ``finest`` is the greatest half-width of the end of a chatter, as a part of the time.
    """

    def __init__(self, t_end: Phase | None, max_impacts: int | None, finest: Fraction) -> None:
        self.t_end = t_end
        self.max_impacts = 2**62 if max_impacts is None else max_impacts
        self.finest = finest
        self.end = arb.pos_inf() if t_end is None else time_ball(t_end)
        self.time = t_end if t_end is None or is_exact(t_end) else None


def march(
    system: BallSystem, start: Start, limits: MarchLimits, progress: RunProgress | None = None
) -> MarchRecord:
    """Follow a motion in balls of the working precision; never raises Undecided."""
    state = BallMotion(system, limits)
    try:
        state.begin(start)
        while state.advance() and state.report(progress):
            pass
    except KeyboardInterrupt:
        state.stop(Undecided("interrupted", ""))
    except Undecided as question:
        state.stop(question)
    return state.record


class BallMotion:
    """The state of a motion between two events, in a flight or a contact."""

    def __init__(self, system: BallSystem, limits: MarchLimits) -> None:
        self.system, self.limits = system, limits
        self.law = law_of(system)
        self.now: Departure | Hold | None = None
        self.fastest = 0.0
        fastest = max([region.pace for region in self.law.regions] + self.law.paces)
        # Without springs and harmonics there is no time scale.
        self.width = 1.0 / fastest if fastest > 1e-38 else 1.0
        self.record = MarchRecord(ctx.prec, self.width, end=limits.t_end)

    def advance(self) -> bool:
        """Go to the next event, and return whether there may be more."""
        if isinstance(self.now, Departure):
            return self._fly(self.now)
        if isinstance(self.now, Hold):
            return self._wait(self.now)
        return False

    def report(self, progress: RunProgress | None) -> bool:
        """Report the progress, and end the proof where that is wanted."""
        t = float(self.record.pieces[-1].start) if self.record.pieces else 0.0
        if progress is not None and not progress.reach_event(t, self.record.n_entries):
            raise Undecided("interrupted", "")
        return True

    def stop(self, question: Undecided) -> None:
        """Record why the proof ends."""
        self.record.ending = Ending[question.kind]
        self.record.reason = question.reason
        if self.now is None:
            return
        flies = isinstance(self.now, Departure)
        start = (
            began(self.now, whole=True) if isinstance(self.now, Departure) else self.now.moment.t
        )
        self.record.until = start
        graze = question.graze
        if graze is not None:
            self.record.until = start + arb(graze.low)
            if flies and question.kind == "graze":
                t = start + arb(graze.low).union(arb(graze.high))
                row = GrazeRow(t, self._stop_at(graze.bound), arb(0, graze.clearance))
                self.record.grazes.append(row)

    def begin(self, start: Start) -> None:
        """Begin with a flight, an impact, a contact or rest, by the start."""
        x, v, moment = on_stop(self.system, start), as_fraction(start.v0), Moment.of(start.t0)
        if v == 0 and not is_exact(start.v0):
            raise ParameterError("v0", start.v0, "not told from 0 by 4800 bits")
        t, speed, piece = moment.t, time_ball(start.v0), self.law.piece_at(moment)
        self.record.until, self.record.begin = t, start.t0
        self._check_inside(start, x)
        bound = next((i for i, b in enumerate(self.system.bounds) if b.at == x), None)
        region = self._region_at(x)
        order, direction = 1, (v > 0) - (v < 0)
        still = v == 0 and is_exact(start.x0) and is_still(self.law, region, x, piece)
        if still:
            order = 0
        elif v == 0 and bound is not None:
            order, direction = first_push_at(self.law, region, bound, moment, piece)
        wall = None if bound is None else self.system.bounds[bound].wall
        if bound is not None and wall is None and direction > 0:
            region = self._above(bound)
        cloud = Cloud.of(time_ball(start.x0) if bound is None else t.mid(), speed)
        departure = Departure(region, cloud, bound, order, moment, piece)
        if bound is not None and wall is not None and v * self._inward(region, bound) > 0:
            self._depart(departure, t)
            self._strike(bound, t, speed, None)
            if self.record.n_entries >= self.limits.max_impacts:
                self._finish(Ending.reached_max_impacts, t)
        elif bound is not None and v == 0 and self._sticks(region, bound, direction):
            self._hold(Hold(region, bound, moment, max(0, order - 2), piece, still))
        elif order == 0 and self.law.next_knot(piece) is None:
            # No force ever moves it.
            place = time_ball(start.x0) if bound is None else self.law.places[bound]
            self.record.pieces.append(Piece(t, Hops(t, place, arb(0))))
            self._finish(Ending.at_rest)
        elif order == 0 and bound is not None:
            self._rest(Hold(region, bound, moment, 0, piece, still=True))
        elif order == 0:
            self._depart(replace(departure, order=1), t)
        else:
            self._depart(departure, t)

    def _check_inside(self, start: Start, x: Fraction) -> None:
        for end, sign in ((self.system.regions[0].lower, -1), (self.system.regions[-1].upper, 1)):
            if end is not None and sign * (x - self.system.bounds[end].at) > 0:
                at = self.system.bounds[end].at
                side = "below" if sign < 0 else "above"
                reason = f"{side} the wall at x = {at}, by {float(abs(x - at)):.3g}"
                raise ParameterError("x0", start.x0, reason)

    def _region_at(self, x: Fraction) -> int:
        for number, region in enumerate(self.system.regions):
            if region.upper is None or x <= self.system.bounds[region.upper].at:
                return number
        return len(self.system.regions) - 1

    def _above(self, bound: int) -> int:
        return next(i for i, region in enumerate(self.system.regions) if region.lower == bound)

    def _below(self, bound: int) -> int:
        return next(i for i, region in enumerate(self.system.regions) if region.upper == bound)

    def _inward(self, region: int, bound: int) -> int:
        """Return the direction into a bound from a region."""
        return -1 if self.system.regions[region].lower == bound else 1

    def _sticks(self, region: int, bound: int, direction: int) -> bool:
        """Return whether a mass at rest stays at a wall, under a force into it or none."""
        wall = self.system.bounds[bound].wall
        return wall is not None and direction in (0, self._inward(region, bound))

    def _depart(self, start: Departure, t: arb, *, at_knot: bool = False) -> None:
        self.now = start
        self.record.pieces.append(Piece(t, start, at_knot))

    def _next_knot(self, piece: int) -> Moment | None:
        """Return the knot at the end of a piece, None where the motion ends by then."""
        knot = self.law.next_knot(piece)
        if knot is None or is_first(Moment(self.limits.end, self.limits.time), knot):
            return None
        return knot

    def _fly(self, start: Departure) -> bool:
        knot = self._next_knot(start.piece)
        if knot is not None:
            return self._fly_to_knot(start, knot)
        arrival = first_arrival(self.system, start, self.limits.end, self.width)
        if arrival is None:
            if not self.limits.end.is_finite():
                raise Undecided("no_event", "the motion provably meets no stop again")
            return self._finish(Ending.reached_t_end)
        if arrival.box[0] > self.limits.end:
            return self._finish(Ending.reached_t_end)
        return self._arrive(start, arrival, in_time=bool(arrival.box[0] < self.limits.end))

    def _fly_to_knot(self, start: Departure, knot: Moment) -> bool:
        arrival = first_arrival(self.system, start, knot.t, self.width, knot=True)
        if arrival is None or arrival.box[0] > knot.t:
            self._check_number()
            following, _ = at_moment(self.system, start, knot, start.piece + 1)
            self._depart(following, knot.t, at_knot=True)
            return True
        if arrival.box[0] < knot.t:
            return self._arrive(start, arrival, in_time=True)
        blur = blur_at_knot(self.system, start, arrival, knot)
        t, v = arrival.box[0] + blur.t, arrival.box[1] + blur.v
        met = replace(
            arrival, point=(arrival.point[0] + blur.t, arrival.point[1] + blur.v), box=(t, v)
        )
        if not t < self.limits.end and self.limits.end.is_finite():
            raise Undecided("precision", "whether an event at a knot comes by t_end is open")
        return self._arrive(replace(start, piece=start.piece + 1), met, in_time=True, blur=blur)

    def _arrive(
        self, start: Departure, arrival: Arrival, *, in_time: bool, blur: Blur | None = None
    ) -> bool:
        """Go on from the end of a flight; one that may be at a knot is blurred by that."""
        t, v = arrival.box
        self._check_number()
        if not arrival.sign * v < 0:
            self.record.grazes.append(GrazeRow(t, self._stop_at(arrival.bound), arb(0)))
            raise Undecided("graze", "an impact may be without velocity, within the radius")
        wall = self.system.bounds[arrival.bound].wall
        if not in_time:
            if wall is not None:
                self._list_impact(wall, t, v)
                return self._finish_open(t, "impact")
            self._list_crossing(arrival)
            return self._finish_open(t, "crossing")
        if wall is not None:
            self._strike(arrival.bound, t, v, (start, arrival), blur)
        else:
            self._cross(start, arrival, blur)
        if self.record.n_entries >= self.limits.max_impacts:
            return self._finish(Ending.reached_max_impacts, t)
        return True

    def _check_number(self) -> None:
        if len(self.record.impacts) + len(self.record.crossings) >= MOST_EVENTS:
            raise Undecided("most_events", f"{MOST_EVENTS} events, the most that are listed")
        if len(self.record.pieces) >= 2 * MOST_EVENTS:
            reason = f"{2 * MOST_EVENTS} flights and pieces of the record, the most that are kept"
            raise Undecided("most_events", reason)

    def _finish_open(self, t: arb, event: str) -> bool:
        """End with an event that comes by t_end or just after it."""
        start = self.record.pieces[-1].start.lower()
        self._finish(Ending.impact_at_t_end, t.lower().max(start))
        self.record.reason = f"whether the last {event} that is listed comes by t_end is open"
        return False

    def _finish(self, ending: Ending, until: arb | None = None) -> bool:
        self.record.ending = ending
        self.record.until = self.limits.end if until is None else until
        self.now = None
        return False

    def _stop_at(self, number: int) -> int:
        bound = self.system.bounds[number]
        return bound.wall if bound.wall is not None else bound.edges[0]

    def _list_crossing(self, arrival: Arrival) -> None:
        t, v = arrival.box
        bound = self.system.bounds[arrival.bound]
        up = arrival.sign < 0
        for stop in bound.edges:
            above = self.system.oscillator.stops[stop].side == "above"
            direction = "in" if above == up else "out"
            self.record.crossings.append(CrossingRow(t, v, stop, direction))
        if any((self.system.oscillator.stops[stop].side == "above") == up for stop in bound.edges):
            self.record.n_entries += 1

    def _cross(self, start: Departure, arrival: Arrival, blur: Blur | None) -> None:
        self._list_crossing(arrival)
        region = self._above(arrival.bound) if arrival.sign < 0 else self._below(arrival.bound)
        t, point = arrival.box[0], arrival.point
        if blur is not None:
            more = blur.after(self.system, region, arrival.bound, arrival.box[1])
            t, point = t + more[0], (point[0] + more[0], point[1] + more[1])
            regions = start.region, region
            self._note_blur(
                blur, regions, arrival.bound, (arrival.box[1], arrival.box[1] + more[1])
            )
        cloud = start.cloud.image(point, arrival.derivative)
        self._depart(Departure(region, cloud, arrival.bound, piece=start.piece), t)

    def _note_blur(self, blur: Blur, regions: tuple[int, int], bound: int, v: BallPair) -> None:
        """Keep what the motion is around an event at a knot, whose order is open."""
        states = blur.states(self.system, regions, bound, v)
        self.record.pieces.append(Piece(blur.around.lower(), states, at_knot=True))

    def _list_impact(self, wall: int, t: arb, v: arb) -> arb:
        """List an impact, and return the velocity after it."""
        after = self.law.rebound(wall, v).after
        self.record.impacts.append(ImpactRow(t, v, after, wall))
        self.record.n_entries += 1
        return after

    def _strike(
        self,
        bound: int,
        t: arb,
        v: arb,
        flight: tuple[Departure, Arrival] | None,
        blur: Blur | None = None,
    ) -> None:
        """Rebound from a wall; flight is None for an impact at the start."""
        wall = self.system.bounds[bound].wall
        assert wall is not None
        assert isinstance(self.now, Departure)
        after = self._list_impact(wall, t, v)
        region, piece = self.now.region, self.now.piece if flight is None else flight[0].piece
        if self.law.is_plastic(wall):
            moment = self.now.moment if flight is None else None
            self._land(region, bound, moment or Moment(t), piece, blur)
            return
        sign = -self._inward(region, bound)
        if flight is None:
            cloud = Cloud.of(self.now.cloud.middle[0], after)
            self.record.pieces.clear()
            self._depart(Departure(region, cloud, bound, 1, self.now.moment, piece), t)
        else:
            start, arrival = flight
            by_t, by_v = arrival.derivative
            kept = self.law.rebound(wall, v).kept
            derivative = by_t, (-kept * by_v[0], -kept * by_v[1])
            point = arrival.point[0], self.law.rebound(wall, arrival.point[1]).after
            if blur is not None:
                more = blur.after(self.system, region, bound, after)
                t, point = t + more[0], (point[0] + more[0], point[1] + more[1])
                self._note_blur(blur, (region, region), bound, (v, after + more[1]))
            cloud = start.cloud.image(point, derivative)
            self._depart(Departure(region, cloud, bound, piece=piece), t)
        self.fastest = max(self.fastest, float(v.abs_lower()))
        if after.abs_upper() < SLOW * self.fastest:
            speed = sign * after
            finest = ball(self.limits.finest) * (abs(t).upper() + self.width)
            # Twice the speed is allowed for, and not reached.
            r = self.law.slow_restitution(wall, 2 * abs(v))
            rest = chatter_end(self.system, region, bound, sign, (t, speed), r, finest, piece)
            if rest is not None and not self.record.n_entries >= self.limits.max_impacts:
                self._end_chatter(region, bound, t, rest)

    def _end_chatter(self, region: int, bound: int, t: arb, hops: Hops) -> None:
        """Go to the end of a chatter, unless the motion ends before that."""
        if hops.end > self.limits.end:
            return
        self.record.pieces[-1] = Piece(t, hops)
        assert isinstance(self.now, Departure)
        self._hold(Hold(region, bound, Moment(hops.end), piece=self.now.piece))

    def _land(
        self, region: int, bound: int, moment: Moment, piece: int, blur: Blur | None = None
    ) -> None:
        """Continue from a wall without velocity."""
        order, direction = first_push_at(self.law, region, bound, moment, piece)
        if blur is not None:
            v = self.record.impacts[-1].v_before, arb(0)
            self._note_blur(blur, (region, region), bound, v)
            # Before the knot too, the force has to hold the mass.
            before = first_push_at(self.law, region, bound, moment, piece - 1)
            if before != (2, direction) or direction != self._inward(region, bound):
                raise Undecided("precision", "whether a landing comes before a knot is open")
        if self._sticks(region, bound, direction):
            self._hold(Hold(region, bound, moment, max(0, order - 2), piece, order == 0))
            return
        exact = moment.time is not None
        cloud = Cloud.of(moment.t.mid() if exact else moment.t, arb(0))
        start = Departure(region, cloud, bound, order, moment if exact else None, piece)
        self._depart(start, moment.t)

    def _hold(self, hold: Hold) -> None:
        t = hold.moment.t
        if not t < self.limits.end:
            raise Undecided("chatter", "a contact begins within its radius of t_end")
        wall = self.system.bounds[hold.bound].wall
        assert wall is not None
        n = len(self.record.impacts)
        self.record.contacts.append(ContactRow(t, None, wall, n))
        self._rest(hold)

    def _rest(self, hold: Hold, *, at_knot: bool = False) -> None:
        """Stay at a bound; at the edge of a soft stop, where no force acts, that is no contact."""
        self.now = hold
        self.record.pieces.append(Piece(hold.moment.t, hold, at_knot))

    def _wait(self, hold: Hold) -> bool:
        knot = self._next_knot(hold.piece)
        end = self.limits.end if knot is None else knot.t
        t, for_ever = release(self.system, hold, end, knot)
        if for_ever or (knot is None and (t is None or t > end)):
            return self._finish(Ending.at_rest if for_ever else Ending.reached_t_end)
        self._check_number()
        if t is None:
            assert knot is not None
            return self._wait_at_knot(hold, knot)
        self._release(t)
        if knot is None and not t < end:
            return self._finish_open(t, "release")
        start = Departure(hold.region, Cloud.of(t, arb(0)), hold.bound, 3, piece=hold.piece)
        self._depart(start, t)
        return True

    def _wait_at_knot(self, hold: Hold, knot: Moment) -> bool:
        """Stay on a stop at a knot, or leave it there."""
        region, bound, piece = hold.region, hold.bound, hold.piece + 1
        order, direction = first_push_at(self.law, region, bound, knot, piece)
        if order == 0 or self._sticks(region, bound, direction):
            if self._has_waited_for_a_period(knot):
                return self._finish(Ending.at_rest)
            following = Hold(region, bound, knot, max(0, order - 2), piece, order == 0)
            self._rest(following, at_knot=True)
            return True
        if self.system.bounds[bound].wall is None:
            region = self._above(bound) if direction > 0 else self._below(bound)
        else:
            self._release(knot.t)
        cloud = Cloud.of(knot.t.mid(), arb(0))
        self._depart(Departure(region, cloud, bound, order, knot, piece), knot.t)
        return True

    def _release(self, t: arb) -> None:
        self.record.contacts[-1] = self.record.contacts[-1]._replace(release=t)

    def _has_waited_for_a_period(self, knot: Moment) -> bool:
        """Return whether a stay is as long as a period of the forcing, and so for ever."""
        try:
            period = self.law.period(1)
        except Undecided:
            return False
        stays = (piece for piece in reversed(self.record.pieces) if not piece.at_knot)
        return bool(knot.t - next(stays).start > period)
