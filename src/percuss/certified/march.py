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
from percuss.certified.cloud import Cloud
from percuss.certified.contact import (
    Hold,
    Hops,
    chatter_end,
    first_push_at,
    release,
    rests_for_ever,
)
from percuss.certified.numbers import ball, time_ball
from percuss.certified.step import Arrival, Departure, first_arrival
from percuss.certified.system import BallSystem
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_fraction
from percuss.model.start import Start
from percuss.progress import RunProgress

__all__ = [
    "ContactRow",
    "CrossingRow",
    "Ending",
    "GrazeRow",
    "ImpactRow",
    "MarchLimits",
    "MarchRecord",
    "Piece",
    "march",
    "moved_in_words",
    "on_stop",
    "start_used",
]

# Events, hops of a chatter among them.
MOST_EVENTS = 100_000
# Hops are listed until they are slower than this part of the fastest impact, as in float runs.
SLOW = 1e-6


def on_stop(system: BallSystem, start: Start) -> Fraction:
    """Return the exact position of a start.

    A float that equals a stop's place as a float is that place exactly, since `simulate` starts on
    the stop; text or a fraction is taken as it was given, however close to the stop.
    """
    x = as_fraction(start.x0)
    if isinstance(start.x0, float):
        for bound in system.bounds:
            if float(bound.at) == start.x0:
                return bound.at
    return x


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
    return start if x == as_fraction(start.x0) else replace(start, x0=x)


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
    """A flight, a contact or the rest of a chatter, from an instant on."""

    start: arb
    what: Departure | Hold | Hops


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
        return sum(isinstance(piece.what, Hops) for piece, _ in pairwise(self.pieces))

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
        start = self.now.cloud.box()[0] if isinstance(self.now, Departure) else self.now.since
        if flies and self.now.time is not None:
            start = time_ball(self.now.time)
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
        x, v, t = on_stop(self.system, start), as_fraction(start.v0), time_ball(start.t0)
        self.record.until, self.record.begin = t, start.t0
        self._check_inside(start, x)
        bound = next((i for i, b in enumerate(self.system.bounds) if b.at == x), None)
        region = self._region_at(x)
        order, direction = 1, (v > 0) - (v < 0)
        if v == 0 and rests_for_ever(self.law, region, x):
            order = 0
        elif v == 0 and bound is not None:
            order, direction = first_push_at(self.law, region, x, t, start.t0)
        wall = None if bound is None else self.system.bounds[bound].wall
        if bound is not None and wall is None and direction > 0:
            region = self._above(bound)
        cloud = Cloud.of(t.mid(), ball(v))
        departure = Departure(region, x, cloud, bound, order, start.t0)
        if bound is not None and wall is not None and v * self._inward(region, bound) > 0:
            self._depart(departure, t)
            self._strike(bound, t, ball(v), None)
            if self.record.n_entries >= self.limits.max_impacts:
                self._finish(Ending.reached_max_impacts, t)
        elif bound is not None and v == 0 and self._sticks(region, bound, direction):
            self._hold(region, bound, t, max(0, order - 2), start.t0)
        elif order == 0:
            # No force ever moves it.
            self.record.pieces.append(Piece(t, Hops(t, ball(x), arb(0))))
            self._finish(Ending.at_rest)
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

    def _depart(self, start: Departure, t: arb) -> None:
        self.now = start
        self.record.pieces.append(Piece(t, start))

    def _fly(self, start: Departure) -> bool:
        arrival = first_arrival(self.system, start, self.limits.end, self.width)
        if arrival is None:
            if not self.limits.end.is_finite():
                raise Undecided("no_event", "the motion provably meets no stop again")
            return self._finish(Ending.reached_t_end)
        t, v = arrival.box
        if t > self.limits.end:
            return self._finish(Ending.reached_t_end)
        self._check_number()
        if not arrival.sign * v < 0:
            self.record.grazes.append(GrazeRow(t, self._stop_at(arrival.bound), arb(0)))
            raise Undecided("graze", "an impact may be without velocity, within the radius")
        wall = self.system.bounds[arrival.bound].wall
        if not t < self.limits.end:
            if wall is not None:
                self._list_impact(wall, t, v)
                return self._finish_open(t, "impact")
            self._list_crossing(arrival)
            return self._finish_open(t, "crossing")
        if wall is not None:
            self._strike(arrival.bound, t, v, (start, arrival))
        else:
            self._cross(start, arrival)
        if self.record.n_entries >= self.limits.max_impacts:
            return self._finish(Ending.reached_max_impacts, t)
        return True

    def _check_number(self) -> None:
        if len(self.record.impacts) + len(self.record.crossings) >= MOST_EVENTS:
            raise Undecided("most_events", f"{MOST_EVENTS} events, the most that are listed")

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

    def _cross(self, start: Departure, arrival: Arrival) -> None:
        self._list_crossing(arrival)
        t, bound = arrival.box[0], self.system.bounds[arrival.bound]
        region = self._above(arrival.bound) if arrival.sign < 0 else self._below(arrival.bound)
        cloud = start.cloud.image(arrival.point, arrival.derivative)
        self._depart(Departure(region, bound.at, cloud, arrival.bound), t)

    def _list_impact(self, wall: int, t: arb, v: arb) -> arb:
        """List an impact, and return the velocity after it."""
        path = f"oscillator.stops.{wall}.restitution"
        # An irrational number is not 0, whatever its ball holds.
        after = -self.law.number(path) * v if self.system.numbers[path] else arb(0)
        self.record.impacts.append(ImpactRow(t, v, after, wall))
        self.record.n_entries += 1
        return after

    def _strike(self, bound: int, t: arb, v: arb, flight: tuple[Departure, Arrival] | None) -> None:
        """Rebound from a wall; flight is None for an impact at the start."""
        wall = self.system.bounds[bound].wall
        assert wall is not None
        assert self.now is not None
        path = f"oscillator.stops.{wall}.restitution"
        r = self.law.number(path)
        after = self._list_impact(wall, t, v)
        region, at = self.now.region, self.system.bounds[bound].at
        if self.system.numbers[path] == 0:
            self._land(region, bound, t, self.now.time if flight is None else None)
            return
        sign = -self._inward(region, bound)
        if flight is None:
            assert isinstance(self.now, Departure)
            cloud = Cloud.of(self.now.cloud.middle[0], after)
            self.record.pieces.clear()
            self._depart(Departure(region, at, cloud, bound, 1, self.now.time), t)
        else:
            start, arrival = flight
            by_t, by_v = arrival.derivative
            derivative = by_t, (-r * by_v[0], -r * by_v[1])
            point = arrival.point[0], -r * arrival.point[1]
            self._depart(Departure(region, at, start.cloud.image(point, derivative), bound), t)
        self.fastest = max(self.fastest, float(v.abs_lower()))
        if r < 1 and after.abs_upper() < SLOW * self.fastest:
            speed = sign * after
            finest = ball(self.limits.finest) * (abs(t).upper() + self.width)
            rest = chatter_end(self.system, region, bound, sign, (t, speed), r, finest)
            if rest is not None and not self.record.n_entries >= self.limits.max_impacts:
                self._end_chatter(region, bound, t, rest)

    def _end_chatter(self, region: int, bound: int, t: arb, hops: Hops) -> None:
        """Go to the end of a chatter, unless the motion ends before that."""
        if hops.end > self.limits.end:
            return
        self.record.pieces[-1] = Piece(t, hops)
        self._hold(region, bound, hops.end)

    def _land(self, region: int, bound: int, t: arb, time: Phase | None = None) -> None:
        """Continue from a wall without velocity."""
        x = self.system.bounds[bound].at
        order, direction = first_push_at(self.law, region, x, t, time)
        if self._sticks(region, bound, direction):
            self._hold(region, bound, t, max(0, order - 2), time)
        else:
            cloud = Cloud.of(t if time is None else t.mid(), arb(0))
            self._depart(Departure(region, x, cloud, bound, order, time), t)

    def _hold(
        self, region: int, bound: int, t: arb, order: int = 0, time: Phase | None = None
    ) -> None:
        if not t < self.limits.end:
            raise Undecided("chatter", "a contact begins within its radius of t_end")
        wall = self.system.bounds[bound].wall
        assert wall is not None
        n = len(self.record.impacts)
        self.record.contacts.append(ContactRow(t, None, wall, n))
        self.now = Hold(region, bound, t, order, time)
        self.record.pieces.append(Piece(t, self.now))

    def _wait(self, hold: Hold) -> bool:
        end = self.limits.end
        t, for_ever = release(self.system, hold, end)
        if t is None or t > end:
            return self._finish(Ending.at_rest if for_ever else Ending.reached_t_end)
        self._check_number()
        self.record.contacts[-1] = self.record.contacts[-1]._replace(release=t)
        if not t < end:
            return self._finish_open(t, "release")
        x = self.system.bounds[hold.bound].at
        self._depart(Departure(hold.region, x, Cloud.of(t, arb(0)), hold.bound, 3), t)
        return True
