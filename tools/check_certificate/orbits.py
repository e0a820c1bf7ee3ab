"""Periodic orbits: one, and one only, lies in the boxes of a certificate.

Proven here: flights from box to box, and back to the first after some periods, have exactly one
solution (Krawczyk), and that is a motion, which meets the stops at these events and no others. Its
stability follows from trace and determinant of the derivative once round. Section 11.6 of
docs/theory/certified.md, whose equations 11.7 uses for branches.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from math import ceil
from typing import Any, NamedTuple

from arithmetic import (
    Interval,
    Matrix,
    NotProvenError,
    Pair,
    bits,
    dual,
    hull,
    nearest,
    of,
    product,
    with_first,
)
from flights import COARSE, Flight, Law, departing, met
from words import near

# How long before a touch x'' is to point off the wall, in units of the longest step: the first of
# these that suffices.
LIFTS = tuple(Fraction(1, n) for n in (2, 8, 32, 128, 512))
# The most bits that the shortest side of a box asks for, and how many times as many are tried.
MOST_BITS, MORE_BITS = 8192, (1, 2, 4)


def proven_orbit(law: Law, text: Any) -> str:
    """Prove by Krawczyk's operator that one periodic orbit, and one only, lies in the boxes."""
    claims, periods = text["events"], text["periods"]
    n = len(claims)
    if n == 0 or periods < 1:
        raise NotProvenError("an orbit has one event at least, and one period")
    if any(claim[name][0] >= claim[name][1] for claim in claims for name in "tv"):
        raise NotProvenError("an interval of the orbit is empty, or one point")
    cycle = Cycle(law, claims, periods)
    sizes = [high - low for claim in claims for low, high in (claim["t"], claim["v"])]
    stability = with_first(bits_to_try(sizes), lambda n: _proven(cycle, n))
    if text["stability"] not in (stability, "undecided"):
        raise NotProvenError(f"the orbit is {stability}, not {text['stability']}")
    said = {"asymptotic": "Neighbouring motions approach it.", "unstable": "It is unstable."}.get(
        stability if text["stability"] == stability else "", "Nothing is claimed of its stability."
    )
    return (
        f"There is one periodic orbit, and one only, whose {n} events in {periods} periods of the force, "
        f"{2 * periods / law.base} pi long, lie in the boxes of the certificate, the first at t "
        f"between {near(claims[0]['t'])}; it meets the stops at these events and no others. {said}"
    )


def bits_to_try(sizes: Iterable[Fraction]) -> list[int]:
    """Return bits for sides of boxes, first some to spare beyond those of the shortest one.

    Under a law with small numbers, as slow ones have, more bits are lost.
    """
    enough = max((COARSE, *(ceil(1 / size).bit_length() + 64 for size in sizes)))
    return [min(enough, MOST_BITS) * times for times in MORE_BITS]


def _proven(cycle: Cycle, n: int) -> str:
    """Prove an orbit in the boxes of its events with so many bits; return its stability."""
    with bits(n):
        boxes = [(of(*claim["t"]), of(*claim["v"])) for claim in cycle.events]
        middles = [(t.middle(), v.middle()) for t, v in boxes]
        shot, missed = shot_of(cycle, boxes), shot_of(cycle, middles).missed
        rows = [row[:-1] for row in shot.rows]
        widths = [
            Interval(-((box.width + 1) // 2) - 1, (box.width + 1) // 2 + 1)
            for pair in boxes
            for box in pair
        ]
        check_inside(widths, contracted(inverse(rows), rows, widths, missed))
        check_first(cycle, boxes)
        return stability_of(shot.monodromy)


class Leg(NamedTuple):
    """A flight of an orbit from event k to the next one, or its image under the symmetry of the law."""

    k: int
    following: int
    # The next event, where the flight comes to it.
    bound: int
    region: int
    # -1 if that is the image of the first event of the orbit, and what is later than it.
    sign: int
    later: Any


class Cycle(NamedTuple):
    """The events of an orbit, the last of which leads to the first after some periods.

    After half a period more than a whole number it leads to the mirror image of the first.
    """

    law: Law
    events: Sequence[Any]
    periods: Fraction | int

    def legs(self) -> Iterator[Leg]:
        if any(event["bound"] >= len(self.law.bounds) for event in self.events):
            raise NotProvenError("an event is at a bound that there is not")
        for k, following in enumerate([*range(1, len(self.events)), 0]):
            event = self.events[following]
            bound, region, sign, later = event["bound"], event["region"], 1, dual(0)
            if following == 0:
                later = dual(self.periods * (self.law.dual or self.law).period())
                if self.periods.denominator == 2:
                    bounds, regions = len(self.law.bounds) - 1, len(self.law.regions) - 1
                    bound, region, sign = bounds - bound, regions - region, -1
            yield Leg(k, following, bound, region, sign, later)


class Shot(NamedTuple):
    """Flights from all events of an orbit, at the instants of the next ones.

    By how much places and velocities miss these events; the derivative of that by all instants and
    velocities, and by the parameter; and that of the state after the last flight by the first one.
    """

    missed: list[Interval]
    rows: list[list[Interval]]
    monodromy: Matrix


def flights_of(
    cycle: Cycle, states: Sequence[Pair], slow: int | None
) -> Iterator[tuple[Leg, Flight, int, Interval]]:
    """Yield the flights from all events, the bounds they depart from, and how long they are.

    Event ``slow`` may have no velocity.
    """
    law, events, _ = cycle
    for leg in cycle.legs():
        bound, number, (t, v) = events[leg.k]["bound"], events[leg.k]["region"], states[leg.k]
        # A wall that keeps nothing leaves the mass at rest, whatever the interval of v.
        rests = law.bounds[bound].restitution == 0
        state = t, of(0) if rests else v
        start = departing(law, number, bound, state, may_rest=rests or leg.k == slow)
        tau = states[leg.following][0] + leg.later.value - t
        if tau.low <= 0:
            raise NotProvenError("an event does not come after the one before it")
        yield leg, Flight(law, number, start), bound, tau


def shot_of(cycle: Cycle, states: Sequence[Pair], slow: int | None = None) -> Shot:
    """Return by how much an orbit misses its events. Which bound is first is left to `check_first`.

    With an event ``slow`` the derivative of the state is that times its velocity, by which it would
    be divided; the equations have no divisor.
    """
    law, n, zero = cycle.law, len(cycle.events), of(0)
    missed: list[Interval] = []
    rows: list[list[Interval]] = []
    total = ((of(1), zero), (zero, of(1)))
    for leg, flight, departed, tau in flights_of(cycle, states, slow):
        kept, region = law.rebound(flight.number, leg.bound, leg.region - flight.number)
        if region != leg.region:
            raise NotProvenError("an event does not lead into its region")
        kept, (x, v) = leg.sign * kept, flight.at(tau)
        # Where x is, which is at the bound for the orbit alone.
        a = flight.acceleration(flight.force(tau), x, v)
        (x_t, x_v), (v_t, v_v) = flight.by_start(tau, departed)
        x_p, v_p, kept_p = _by_parameter(flight, departed, leg.bound, tau)
        if law.bounds[departed].restitution == 0:
            x_v = v_v = zero
        missed += [x - of(law.bounds[leg.bound].at), kept * v - states[leg.following][1]]
        # As in `met`.
        ratio, times = (kept, kept * v) if leg.following == slow else (1 / v, of(1))
        t_t, t_v = -(x_t * ratio), -(x_v * ratio)
        by_v = kept * (times * v_t + a * t_t), kept * (times * v_v + a * t_v)
        total = product(((t_t, t_v), by_v), total)
        # The end is later with the next instant, and with the periods by the parameter.
        later = leg.later.slope
        place, speed = [zero] * (2 * n + 1), [zero] * (2 * n + 1)
        k, j = 2 * leg.k, 2 * leg.following
        for row, ends in (
            (place, ((k, x_t), (k + 1, x_v), (j, v), (-1, x_p + v * later))),
            (speed, ((k, v_t), (k + 1, v_v), (j, a), (-1, v_p + a * later))),
        ):
            for i, entry in ends:
                row[i] = row[i] + entry
        speed = [kept * entry for entry in speed]
        speed[j + 1] = speed[j + 1] - 1
        speed[-1] = speed[-1] + leg.sign * kept_p * v
        rows += [place, speed]
    return Shot(missed, rows, total)


def _by_parameter(
    flight: Flight, departed: int, bound: int, tau: Interval
) -> tuple[Interval, Interval, Interval]:
    """Return the derivative of x - bound and v at an instant, and of what is kept, by the parameter."""
    law = flight.law.dual
    if law is None:
        return of(0), of(0), of(0)
    start = flight.start._replace(x=of(law.bounds[departed].at))
    x, v = Flight(law, flight.number, start).at(tau)
    at, restitution = law.bounds[bound]
    return dual(x - at).slope, dual(v).slope, -dual(restitution or 0).slope


def check_first(cycle: Cycle, states: Sequence[Pair], slow: int | None = None) -> None:
    """Prove that orbits with these events meet the stops at them and at no others."""
    for leg, flight, departed, tau in flights_of(cycle, states, slow):
        if leg.following == slow:
            _check_touch(flight, departed, leg.bound, tau)
            continue
        first = met(flight, departed)
        # There is one root where the first event is or this one may be: v keeps its sign.
        _, v = flight.at(hull([first.tau, tau]))
        if (first.bound, first.region) != (leg.bound, leg.region) or v.least == 0:
            raise NotProvenError("the events of the orbit are not those claimed")


def _check_touch(flight: Flight, departed: int, bound: int, tau: Interval) -> None:
    """Prove that a flight which ends on a wall at tau with no or little speed meets nothing before.

    Shortly before, x'' points off the wall: by Taylor's theorem at the end, where the velocity is
    not off it, the motion is off it then.
    """
    restitution, sides = flight.law.bounds[bound].restitution, flight.law.sides(flight.number)
    if restitution is None or of(restitution).low <= 0 or bound not in dict(sides):
        raise NotProvenError(
            "the event without velocity is on no wall, or on one that keeps nothing"
        )

    def proven(lift: Fraction) -> None:
        first, last = tau.fractions()
        until = first - lift * flight.numbers.steps.longest
        if until <= 0 or flight.landing(departed, until=until) is not None:
            raise NotProvenError("that the flight to a touch meets nothing before is open")
        x, v, _ = flight.on_step(until, last - until)
        a = flight.acceleration(flight.force(of(until, last)), x, v)
        for other, sign in sides:
            gap = sign * (of(flight.law.bounds[other].at) - x)
            if (sign * a).high >= 0 if other == bound else gap.low <= 0:
                raise NotProvenError("that x'' points off the wall before a touch is open")

    with_first(LIFTS, proven)


def contracted(
    approximate: Sequence[Sequence[Fraction]],
    rows: Sequence[Sequence[Interval]],
    widths: Sequence[Interval],
    missed: Sequence[Interval],
) -> list[Interval]:
    """Return (1 - C J) W - C missed: all zeros of equations in a box W about a point lie there."""
    n, moved = len(rows), []
    for i, row in enumerate(approximate):
        c, part = [of(entry) for entry in row], of(0)
        for j in range(n):
            entry = of(int(i == j))
            for k in range(n):
                entry = entry - c[k] * rows[k][j]
            part = part + entry * widths[j] - c[j] * missed[j]
        moved.append(part)
    return moved


def check_inside(widths: Sequence[Interval], moved: Sequence[Interval]) -> None:
    """Prove that one zero, and one only, lies in a box (Krawczyk)."""
    for width, part in zip(widths, moved, strict=True):
        # By 3 units inside of the widened box: inside of what is claimed, which `of` rounded
        # outward.
        if not Interval(width.low + 3, width.high - 3).holds(part):
            raise NotProvenError("the boxes are not proven to hold an orbit")


def inverse(rows: Sequence[Sequence[Interval]]) -> list[list[Fraction]]:
    """Return about the inverse of a matrix; what it is used for is checked."""
    n, unit = len(rows), 1 << 100
    wide = [
        [*(e.middle().fractions()[0] for e in row), *(Fraction(int(i == j)) for j in range(n))]
        for i, row in enumerate(rows)
    ]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(wide[i][k]))
        if wide[pivot][k] == 0:
            raise NotProvenError("the equations of the orbit are singular")
        wide[k], wide[pivot] = wide[pivot], wide[k]
        wide[k] = [Fraction(round(e / wide[k][k] * unit), unit) for e in wide[k]]
        for i in range(n):
            if i != k and wide[i][k]:
                factor = wide[i][k]
                pairs = zip(wide[i], wide[k], strict=True)
                wide[i] = [Fraction(round((a - factor * b) * unit), unit) for a, b in pairs]
    return [row[n:] for row in wide]


def stability_of(m: Matrix) -> str:
    """Return what trace and determinant say of the multipliers."""
    (a, b), (c, d) = m
    trace, determinant, one = a + d, a * d - b * c, of(1)
    if trace.size < (one + determinant).low and determinant.size < one.low:
        return "asymptotic"
    if trace.least > (one + determinant).high or determinant.least > one.high:
        return "unstable"
    return "undecided"


def check_different(law: Law, orbits: Sequence[Any]) -> None:
    """Prove that no two orbits are one, whole periods later or not: one has an event of its own."""
    states = [[(of(*it["t"]), of(*it["v"])) for it in orbit["events"]] for orbit in orbits]
    for i, first in enumerate(states):
        for j in range(i):
            if any(_may_be_one(law.period(), first[0], other) for other in states[j]):
                raise NotProvenError(f"orbits {j} and {i} may be one")


def _may_be_one(period: Interval, one: Pair, other: Pair) -> bool:
    """Return whether two events may be the same, whole periods apart."""
    t, v = one[0] - other[0], one[1] - other[1]
    n = nearest(t, period)
    is_wide = 2 * (one[0].width + other[0].width) > period.low
    return v.least == 0 and (is_wide or any((t - k * period).least == 0 for k in (n - 1, n, n + 1)))
