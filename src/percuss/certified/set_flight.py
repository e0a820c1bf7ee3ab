"""Flights of wide sets of states from event to event."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import coarse_bits, law_of
from percuss.certified.cloud import BallMatrix, BallPair, applied
from percuss.certified.first_root import Bracket, Level, Touch
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import between, precision
from percuss.certified.shooting import OrbitEvent
from percuss.certified.step import (
    Departure,
    began,
    flight_of,
    landed,
    levels_of,
    search_along,
    width_of,
)
from percuss.certified.system import BallSystem

# How far beyond a time the next event is looked for, as a part of that time: a root at the very end
# is found on either side of it then.
BEYOND = 1.25
# Interval Newton steps that make the instants of an event narrower.
STEPS = 2


class SlowEvents(NamedTuple):
    """What may be done with events that are too slow, of sets that are too wide.

    Attributes
    ----------
    finest
        Stretches of flights below this length are not tried.
    slow
        Motions with an event slower than this are left out.
    glancing
        Where it is open which states of a set have an event, it is noted if it is slower than this.
    """

    finest: float = 0.0
    slow: float = 0.0
    glancing: float = 0.0


ALL_EVENTS = SlowEvents()


class FoundEvents(NamedTuple):
    """What the search along all flights of a set finds: a bracket or none, and touches before it."""

    bracket: Bracket | None
    touches: list[Touch]
    whole: EnclosedFlight
    coarse: int


class SetPassage(NamedTuple):
    """The next event of all states of a set.

    Attributes
    ----------
    event
        The event.
    point, derivative
        Instant and velocity after it of the flight from the middle of the set, and their derivative
        by the coordinates of the set on all of it.
    box
        Instant and velocity after it of all states.
    following
        The departure from it.
    """

    event: OrbitEvent
    point: BallPair
    derivative: BallMatrix
    box: BallPair
    following: Departure

    def image_of(self, state: BallPair, start: Departure) -> BallPair:
        """Return instant and velocity after the event from a small ball of states in the set."""
        t, v = start.cloud.middle
        dt, dv = applied(self.derivative, (state[0] - t, state[1] - v))
        return self.point[0] + dt, self.point[1] + dv


def search_set(
    system: BallSystem, start: Departure, longest: float, slow: SlowEvents = ALL_EVENTS
) -> FoundEvents:
    """Return where all flights of a set meet a stop first, and where some of them may before.

    Parameters
    ----------
    system
        The exact system, without a record.
    start
        The departure of the set.
    longest
        The time up to which an event is looked for.
    slow
        What is done with slow events; by default nothing.

    Raises
    ------
    Undecided
        If the balls leave it open.
    """
    bits = sorted({coarse_bits(system), ctx.prec})
    for coarse in bits:
        with precision(coarse):
            whole = flight_of(system, start, whole=True)
            levels, width = levels_of(system, start.region), width_of(system, whole)
            search = search_along(
                system, whole, levels, start.bound, start.order, width, **slow._asdict()
            )
            try:
                bracket = search.first(BEYOND * longest)
            except Undecided as question:
                if question.graze is not None and question.graze.low > longest:
                    return FoundEvents(None, search.touches, whole, coarse)
                if coarse == bits[-1]:
                    raise
                continue
            if bracket is not None and bracket.low > longest:
                bracket = None
            return FoundEvents(bracket, search.touches, whole, coarse)
    raise AssertionError


def next_passage(system: BallSystem, start: Departure, found: FoundEvents) -> SetPassage | None:
    """Return the next event of a set of states, None where none of them meets a stop.

    With slow events left out it is that of all states that have none; the derivative is that of the
    formal flights, through such events.

    Raises
    ------
    Undecided
        If the balls leave open when it comes.
    """
    if found.bracket is None:
        return None
    arrival = landed(system, start, found.whole, found.bracket, found.coarse)
    if not arrival.sign * arrival.box[1] < 0:
        raise Undecided("graze", "an impact of the set may be without velocity")
    event = event_at(system, start.region, arrival.bound, arrival.sign)
    rebound = event.passed(system, arrival.box[1])
    point = arrival.point[0], event.passed(system, arrival.point[1]).after
    by_t, by_v = arrival.derivative
    derivative: BallMatrix = (by_t, (-rebound.kept * by_v[0], -rebound.kept * by_v[1]))
    following = Departure(event.after, start.cloud.image(point, derivative), event.bound)
    box = arrival.box[0], rebound.after
    return SetPassage(event, point, derivative, box, following)


def possible_events(
    system: BallSystem, start: Departure, found: FoundEvents
) -> Iterator[tuple[OrbitEvent, BallPair]]:
    """Yield balls of instants and velocities after all events that may be the first of a set's states.

    But those that are slow by `SlowEvents`.
    """
    first = began(start, whole=True)
    for touch in found.touches:
        event = event_at(system, start.region, touch.level.bound, touch.level.sign)
        fastest = arb(touch.speed)
        v = -touch.level.sign * between(arb(0), fastest)
        yield event, (first + between(arb(touch.low), arb(touch.high)), _after(system, event, v))
    if found.bracket is not None:
        level = found.bracket.level
        event = event_at(system, start.region, level.bound, level.sign)
        s, v = _instants(system, found.whole, found.bracket, level)
        yield event, (first + s, _after(system, event, v))


def _after(system: BallSystem, event: OrbitEvent, v: arb) -> arb:
    return event.passed(system, v).after


def _instants(
    system: BallSystem, whole: EnclosedFlight, bracket: Bracket, level: Level
) -> tuple[arb, arb]:
    """Return balls of the times of flight to the root in a bracket, and of the velocities there."""
    s = between(arb(bracket.low), arb(bracket.far))
    place = law_of(system).places[level.bound]
    for _ in range(STEPS):
        (_, v), _ = whole.derivatives(s, 1)
        if v.contains(0):
            break
        middle = s.mid()
        (x, _), _ = whole.derivatives(middle, 1)
        narrower = middle - (x - place) / v
        if not narrower.overlaps(s):
            break
        s = s.intersection(narrower)
    (_, v), _ = whole.derivatives(s, 1)
    # It falls to the level there, and none rises.
    still = between(arb(0), -level.sign * v.abs_upper())
    return s, v.intersection(still) if v.overlaps(still) else still


def event_at(system: BallSystem, region: int, bound: int, sign: int) -> OrbitEvent:
    """Return the event at the end of a flight in a region; the bound lies below it with +1."""
    wall = system.bounds[bound].wall
    if wall is not None:
        return OrbitEvent(bound, region, region, wall, wall=True)
    after = region - sign
    stops, side = system.oscillator.stops, "above" if after > region else "below"
    edges = system.bounds[bound].edges
    stop = next((i for i in edges if stops[i].side == side), None)
    return OrbitEvent(bound, region, after, stop, wall=False)
