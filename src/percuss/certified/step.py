"""One flight of a set of states, from its start to the first stop that it meets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import coarse_bits, law_of
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, applied
from percuss.certified.event_location import solve
from percuss.certified.first_root import Bracket, Level, Search
from percuss.certified.flight import EnclosedFlight, SmoothFunction, propagator
from percuss.certified.numbers import largest_abs, precision
from percuss.certified.pieces import Moment
from percuss.certified.system import BallSystem

# The shortest stretch, far above the least float.
LEAST = 1e-120
# A search up to a knot goes on by this part of its time, so that a root at the knot is inside it.
BEYOND = 2.0**-10
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Departure:
    """The start of a flight.

    Attributes
    ----------
    region
        Number of the region.
    cloud
        From a bound the instants and velocities, else the positions and velocities.
    bound
        Number of the bound, None between bounds.
    order
        Order of the first derivative of x that is not zero.
    moment
        The instant of all starts, which the cloud then has not; between bounds there is one.
    piece
        Number of the record's piece; 0 without a record.
    """

    region: int
    cloud: Cloud
    bound: int | None = None
    order: int = 1
    moment: Moment | None = None
    piece: int = 0


@dataclass(frozen=True, slots=True)
class Arrival:
    """The end of a flight: its first event.

    Attributes
    ----------
    bound, sign
        Number of the bound, and +1 for one below the flight.
    point
        Instant and velocity of the flight from the middle of the cloud.
    derivative
        Of instant and velocity with respect to those of the departure, on the whole cloud.
    box
        Instant and velocity of all.
    duration, isolating
        Duration of all flights, and a wider ball in which each of them has this root only.
    """

    bound: int
    sign: int
    point: BallPair
    derivative: BallMatrix
    box: BallPair
    duration: arb
    isolating: arb


def flight_of(system: BallSystem, start: Departure, *, whole: bool) -> EnclosedFlight:
    """Return the flight from the middle of a departure's cloud, or those from all of it."""
    law = law_of(system)
    first, v = start.cloud.box() if whole else start.cloud.middle
    moment = start.moment or Moment(first)
    phasors = law.phasors(moment.t) if moment.time is None else law.phasors_at(moment.time)
    if start.order > 1:
        v = arb(0)
    x = first if start.bound is None else law.places[start.bound]
    ramp = law.ramp(start.piece, moment)
    return EnclosedFlight(law, start.region, phasors, x, v, start.order, ramp)


def began(start: Departure, *, whole: bool) -> arb:
    """Return the instant of the middle of a departure's cloud, or those of all of it."""
    if start.moment is not None:
        return start.moment.t
    return start.cloud.box()[0] if whole else start.cloud.middle[0]


def levels_of(system: BallSystem, region: int) -> list[Level]:
    """Return the bounds of a region as levels, at the working precision."""
    places, ends = law_of(system).places, system.regions[region]
    return [
        Level(bound, sign, places[bound])
        for bound, sign in ((ends.lower, 1), (ends.upper, -1))
        if bound is not None
    ]


def width_of(system: BallSystem, flight: EnclosedFlight) -> float:
    """Return about the length of a stretch of a flight, by the fastest part of the motion."""
    return 1.0 / max([flight.region.pace, *law_of(system).paces, 1e-6])


def search_along(
    system: BallSystem,
    curve: SmoothFunction,
    levels: list[Level],
    started: int | None,
    order: int,
    width: float,
    *,
    finest: float = 0.0,
    slow: float = 0.0,
    glancing: float = 0.0,
) -> Search:
    """Return the search along a curve from a bound (None: from inside), at the working precision.

    ``order`` is that of the first derivative at the start that is not zero, ``width`` about the
    length of a stretch, ``finest`` one below which no stretch of a wide set is worth a try;
    ``slow`` and ``glancing`` are those of `Search`.
    """
    return Search(
        curve,
        levels,
        next((level for level in levels if level.bound == started), None),
        order,
        width=width,
        least=max(LEAST, finest, 2.0 ** (-0.45 * ctx.prec) * width),
        sharp=ctx.prec > coarse_bits(system),
        slow=slow,
        glancing=glancing,
    )


def beyond(search: Callable[[float], T], longest: float, *, knot: bool) -> T:
    """Return what a search finds up to a time; at a knot a little beyond it, if that is decided."""
    if knot:
        try:
            return search(longest * (1.0 + BEYOND))
        except Undecided:
            pass
    return search(longest)


def first_arrival(
    system: BallSystem, start: Departure, end: arb, width: float, *, knot: bool = False
) -> Arrival | None:
    """Return where a departure first meets a bound, None if it does not before an instant.

    With ``knot`` that is one, next to which an event is found on either side of it.
    """
    if knot:
        return beyond(
            lambda later: _first_arrival(system, start, later, width),
            largest_abs(end - began(start, whole=True)),
            knot=True,
        )
    longest = largest_abs(end - began(start, whole=True)) if end.is_finite() else float("inf")
    return _first_arrival(system, start, longest, width)


def _first_arrival(
    system: BallSystem, start: Departure, longest: float, width: float
) -> Arrival | None:
    bits = ctx.prec
    coarse = coarse_bits(system)
    try:
        return _arrival(system, start, longest, width, coarse)
    except Undecided as open_question:
        if coarse == bits or open_question.kind not in ("graze", "precision"):
            raise
    return _arrival(system, start, longest, width, bits)


def _arrival(
    system: BallSystem, start: Departure, longest: float, width: float, coarse: int
) -> Arrival | None:
    with precision(coarse):
        whole = flight_of(system, start, whole=True)
        levels = levels_of(system, start.region)
        if not levels or never_reaches(whole, levels, start):
            return None
        search = search_along(system, whole, levels, start.bound, start.order, width)
        bracket = search.first(longest)
    if bracket is None:
        return None
    return landed(system, start, whole, bracket, coarse)


def first_bracket(
    system: BallSystem, start: Departure, longest: float
) -> tuple[Bracket, EnclosedFlight, int]:
    """Return where all flights of a departure first meet a bound, those flights, and their bits.

    The bits are the fewest that decide.

    Raises
    ------
    Undecided
        If the balls leave it open, or the flights meet no bound in this time.
    """
    bracket, whole, coarse = bracket_within(system, start, longest)
    if bracket is None:
        raise Undecided("no_event", f"a flight meets no stop within {longest:.6g}")
    return bracket, whole, coarse


def bracket_within(
    system: BallSystem, start: Departure, longest: float
) -> tuple[Bracket | None, EnclosedFlight, int]:
    """Return what `first_bracket` does; no bracket where the flights meet no bound in a time."""
    bits = sorted({coarse_bits(system), ctx.prec})
    for coarse in bits:
        with precision(coarse):
            whole = flight_of(system, start, whole=True)
            levels, width = levels_of(system, start.region), width_of(system, whole)
            search = search_along(system, whole, levels, start.bound, start.order, width)
            try:
                return search.first(longest), whole, coarse
            except Undecided:
                if coarse == bits[-1]:
                    raise
    raise AssertionError


def landed(
    system: BallSystem,
    start: Departure,
    whole: EnclosedFlight,
    bracket: Bracket,
    coarse: int,
    isolation: arb | None = None,
) -> Arrival:
    """Return the arrival in a bracket.

    ``whole`` are the flights from all of the cloud, made at ``coarse`` bits, which serve for all
    but the root of the flight from the middle. Within ``isolation`` of the root others are
    excluded, where that can be done.
    """
    point = flight_of(system, start, whole=False)
    level = next(
        level for level in levels_of(system, start.region) if level.bound == bracket.level.bound
    )
    fine = bracket._replace(level=level)
    # The series takes derivatives below the order for zero, which they are not at all starts.
    summed = start.order <= 2 or start.moment is not None
    first, all_ = solve(point, whole, fine, coarse, summed=summed, isolation=isolation)
    with precision(coarse):
        moved = moved_by(start, whole, all_.s)
        derivative = event_derivative(moved, (all_.v, all_.a))
        dt, dv = applied(derivative, applied(start.cloud.axes, start.cloud.spread))
    at = began(start, whole=False) + first.s, first.v
    box = at[0] + dt, at[1] + dv
    return Arrival(level.bound, level.sign, at, derivative, box, all_.s, all_.isolating)


def moved_by(start: Departure, whole: EnclosedFlight, s: arb) -> BallMatrix:
    """Return the derivative of (x, v) at a fixed instant by the coordinates of a departure's cloud.

    A start from a bound later by dt is, at a fixed instant, one that is displaced by (-v, -a) dt.
    """
    a11, a12, a21, a22 = propagator(whole.region, s)
    if start.bound is None:
        return (a11, a12), (a21, a22)
    v0, a0 = whole.v0, whole.a0
    return (-(a11 * v0 + a12 * a0), a12), (-(a21 * v0 + a22 * a0), a22)


def event_derivative(moved: BallMatrix, after: BallPair) -> BallMatrix:
    """Return the derivative of instant and velocity at an event, which comes later by -dx/v.

    ``moved`` is that of (x, v) at a fixed instant, ``after`` velocity and acceleration there.
    """
    (x_by_first, x_by_v), (v_by_first, v_by_v) = moved
    v1, a1 = after
    t_by_first, t_by_v = -(x_by_first / v1), -(x_by_v / v1)
    return (t_by_first, t_by_v), (v_by_first + a1 * t_by_first, v_by_v + a1 * t_by_v)


def state_on(system: BallSystem, start: Departure, t: arb) -> tuple[BallPair, BallMatrix]:
    """Return (x, v) of the flight from the middle of a cloud at an instant, and the derivative.

    By the mean value theorem that of all flights, each after the time since its own start.
    """
    whole, point = flight_of(system, start, whole=True), flight_of(system, start, whole=False)
    (x, v), _ = point.derivatives(t - began(start, whole=False), 1)
    return (x, v), moved_by(start, whole, t - began(start, whole=True))


def state_in_flight(system: BallSystem, start: Departure, t: arb) -> BallPair:
    """Return balls of x and v of all flights of a departure at an instant."""
    (x, v), derivative = state_on(system, start, t)
    dx, dv = applied(derivative, applied(start.cloud.axes, start.cloud.spread))
    return x + dx, v + dv


def at_moment(
    system: BallSystem, start: Departure, moment: Moment, piece: int
) -> tuple[Departure, BallMatrix]:
    """Return the departure from an instant of a flight into a piece of the record.

    With the derivative by the coordinates of the cloud it came from.
    """
    point, derivative = state_on(system, start, moment.t)
    cloud = start.cloud.image(point, derivative)
    return Departure(start.region, cloud, None, 1, moment, piece), derivative


def never_reaches(flight: EnclosedFlight, levels: list[Level], start: Departure) -> bool:
    """Return whether the motion is proven to stay away from all levels for ever."""
    if start.bound is not None:
        return False
    reach = flight.reach()
    if reach is None:
        return False
    low, high = reach
    return all(
        level.at < low - 1e-9 * abs(low) if level.sign > 0 else level.at > high + 1e-9 * abs(high)
        for level in levels
    )
