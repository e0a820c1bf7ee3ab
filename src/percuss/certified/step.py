"""One flight of a set of states, from its start to the first stop that it meets."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import coarse_bits, law_of
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, applied
from percuss.certified.event_location import solve
from percuss.certified.first_root import Bracket, Level, Search
from percuss.certified.flight import BallPropagator, EnclosedFlight, SmoothFunction, propagator
from percuss.certified.numbers import ball, precision, time_ball, upper
from percuss.certified.system import BallSystem
from percuss.model.exact import Phase

__all__ = [
    "Arrival",
    "Departure",
    "event_derivative",
    "first_arrival",
    "first_bracket",
    "flight_of",
    "landed",
    "levels_of",
]

# The shortest stretch, far above the least float.
LEAST = 1e-120


@dataclass(frozen=True, slots=True)
class Departure:
    """The start of a flight.

    Attributes
    ----------
    region
        Number of the region.
    x
        The exact position.
    cloud
        The instants and velocities.
    bound
        Number of the bound at x, None between bounds.
    order
        Order of the first derivative of x that is not zero.
    time
        The instant, where it is exact; the cloud then has no width in time.
    """

    region: int
    x: Fraction
    cloud: Cloud
    bound: int | None = None
    order: int = 1
    time: Phase | None = None


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
    t, v = start.cloud.box() if whole else start.cloud.middle
    phasors = law.phasors(t) if start.time is None else law.phasors_at(start.time)
    if start.order > 1:
        v = arb(0)
    x = ball(start.x) if start.bound is None else law.places[start.bound]
    return EnclosedFlight(law, start.region, phasors, x, v, start.order)


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
) -> Search:
    """Return the search along a curve from a bound (None: from inside), at the working precision.

    ``order`` is that of the first derivative at the start that is not zero, ``width`` about the
    length of a stretch.
    """
    return Search(
        curve,
        levels,
        next((level for level in levels if level.bound == started), None),
        order,
        width=width,
        least=max(LEAST, 2.0 ** (-0.45 * ctx.prec) * width),
        sharp=ctx.prec > coarse_bits(system),
    )


def first_arrival(system: BallSystem, start: Departure, end: arb, width: float) -> Arrival | None:
    """Return where a departure first meets a bound, None if it does not before an instant."""
    bits = ctx.prec
    coarse = coarse_bits(system)
    try:
        return _arrival(system, start, end, width, coarse)
    except Undecided as open_question:
        if coarse == bits or open_question.kind not in ("graze", "precision"):
            raise
    return _arrival(system, start, end, width, bits)


def _arrival(
    system: BallSystem, start: Departure, end: arb, width: float, coarse: int
) -> Arrival | None:
    with precision(coarse):
        whole = flight_of(system, start, whole=True)
        levels = levels_of(system, start.region)
        if not levels or _never_reaches(whole, levels, start):
            return None
        search = search_along(system, whole, levels, start.bound, start.order, width)
        began = start.cloud.box()[0] if start.time is None else time_ball(start.time)
        longest = upper(end - began) if end.is_finite() else float("inf")
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
    bits = sorted({coarse_bits(system), ctx.prec})
    for coarse in bits:
        with precision(coarse):
            whole = flight_of(system, start, whole=True)
            levels, width = levels_of(system, start.region), width_of(system, whole)
            search = search_along(system, whole, levels, start.bound, start.order, width)
            try:
                bracket = search.first(longest)
            except Undecided:
                if coarse == bits[-1]:
                    raise
                continue
        if bracket is not None:
            return bracket, whole, coarse
        break
    raise Undecided("no_event", f"a flight meets no stop within {longest:.6g}")


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
    summed = start.order <= 2 or start.time is not None
    first, all_ = solve(point, whole, fine, coarse, summed=summed, isolation=isolation)
    with precision(coarse):
        by = propagator(whole.region, all_.s)
        derivative = event_derivative(by, (whole.v0, whole.a0), (all_.v, all_.a))
        dt, dv = applied(derivative, applied(start.cloud.axes, start.cloud.spread))
    began = start.cloud.middle[0] if start.time is None else time_ball(start.time)
    at = began + first.s, first.v
    box = at[0] + dt, at[1] + dv
    return Arrival(level.bound, level.sign, at, derivative, box, all_.s, all_.isolating)


def event_derivative(by: BallPropagator, before: BallPair, after: BallPair) -> BallMatrix:
    """Return the derivative of instant and velocity at an event by those at the one before.

    A start later by dt is, at a fixed instant, one that is displaced by (-v, -a) dt; and an
    event comes later by -dx/v. ``before`` and ``after`` are velocity and acceleration at start
    and end of the flight, ``by`` is its propagator.
    """
    (v0, a0), (v1, a1) = before, after
    a11, a12, a21, a22 = by
    x_by_t, v_by_t = -(a11 * v0 + a12 * a0), -(a21 * v0 + a22 * a0)
    t_by_t, t_by_v = -(x_by_t / v1), -(a12 / v1)
    return (t_by_t, t_by_v), (v_by_t + a1 * t_by_t, a22 + a1 * t_by_v)


def _never_reaches(flight: EnclosedFlight, levels: list[Level], start: Departure) -> bool:
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
