"""Basins: all motions from a rectangle of starts approach one orbit.

Proven here: about an event of each orbit there is a set, a trap, from which all motions approach
the orbit, and all motions from each rectangle come into a trap of the orbit that it is said to go
to, or settle where they meet no stop. Section 11.10 of docs/theory/certified.md, with orbits by
11.6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import islice
from typing import Any, NamedTuple

from arithmetic import (
    Interval,
    Matrix,
    NotProvenError,
    Pair,
    angle,
    applied,
    bits,
    inverse_of,
    nearest,
    of,
    product,
    unit,
)
from flights import Event, Flight, Law, State, departing, met
from orbits import check_different, proven_orbit
from parts import Rectangle, proven_on_parts
from words import counted, phase_in_words, told

# Bits with which sets of motions are followed, the smallest part of a rectangle that is tried, and
# events after which they have come to their orbit.
SET_BITS, SMALLEST_PART, MOST_EVENTS = 64, Fraction(1, 2**10), 60


class Carried(NamedTuple):
    """A set after an event: all of it lies in image + derivative spread, if 0 belongs to the spread."""

    event: Event
    image: Pair
    derivative: Matrix


def carried(
    law: Law,
    number: int,
    departed: int | None,
    middle: State,
    axes: Matrix,
    spread: Pair,
    settling: int | None = None,
) -> Iterator[Carried]:
    """Yield the events of all motions from the states middle + axes spread, the same for all.

    The states are t and v after an event at a bound or, where there was none, x and v at one
    instant. By the mean value theorem, with the derivatives on all of the set. It ends where all
    motions are proven to meet no bound any more in region ``settling``, or after the most events.
    """
    total, whole, point = axes, _around(middle, departed, applied(axes, spread)), middle
    for _ in range(MOST_EVENTS):
        flight = Flight(law, number, whole)
        landing = flight.landing(departed, may_settle=number == settling)
        if landing is None:
            return
        event = met(flight, departed, landing)
        low, high = event.tau.fractions()
        narrow, enough = landing._replace(low=low, high=high), event.tau.width // 2**10
        point = met(Flight(law, number, point), departed, narrow, enough).after
        total = product(event.derivative, total)
        yield Carried(event, (point.t, point.v), total)
        dt, dv = applied(total, spread)
        t, x, v = event.after
        whole = State(t.both(point.t + dt), x, v.both(point.v + dv))
        number, departed = event.region, event.bound
    raise NotProvenError("the motions have not settled")


def _around(middle: State, departed: int | None, by: Pair) -> State:
    first, dv = by
    if departed is None:
        return State(middle.t, middle.x + first, middle.v + dv)
    return State(middle.t + first, middle.x, middle.v + dv)


class Trap(NamedTuple):
    """The states z + E w, abs(w) < 1, after events of a kind: z, in a box, is an event of an orbit."""

    bound: int
    region: int
    z: Pair
    inverse: Matrix

    def holds(self, law: Law, found: Carried, spread: Pair) -> bool:
        """Return whether all of a set lies inside, whole periods later or not."""
        event, (t, v), _ = found
        if (event.bound, event.region) != (self.bound, self.region):
            return False
        period = law.period()
        later, faster = t - self.z[0], v - self.z[1]
        turns = nearest(later.middle(), period)
        c, d = applied(self.inverse, (later - turns * period, faster))
        (e, f), (g, h) = product(self.inverse, found.derivative)
        # The norm is convex: it is largest at a corner.
        corners = [(Interval(p, p), Interval(q, q)) for p in spread[0] for q in spread[1]]
        norms = [(c + e * p + f * q).square() + (d + g * p + h * q).square() for p, q in corners]
        return all(norm.high < unit() for norm in norms)


def _count_parts(whole: Rectangle, holds: Callable[[Rectangle], bool], said: str) -> int:
    """Prove what is to hold on all parts of a rectangle; count them."""
    return sum(proven_on_parts(whole, lambda part: holds(part) or None, said, SMALLEST_PART))


def _middle(part: Rectangle) -> tuple[Pair, Pair]:
    """Return the middle of a rectangle, and all vectors from there to its points."""
    (a, b), (c, d) = part
    x, y = (of((low - high) / 2, (high - low) / 2) for low, high in part)
    return (of((a + b) / 2), of((c + d) / 2)), (x, y)


def trap_of(law: Law, orbit: Any, claim: Any) -> Trap:
    """Return a set about an event of a proven orbit from which all motions approach the orbit.

    On parts of a parallelogram about the innermost ellipse the derivative of the map from an event
    to the same one some rounds of the orbit later makes all vectors shorter, by the norm of the
    ellipse. From each stage, a multiple of it, all motions come into the one before.
    """
    if claim["event"] >= len(orbit["events"]) or claim["rounds"] < 1:
        raise NotProvenError("a trap has no event of its orbit, or no rounds")
    if any(stage < 1 for stage in claim["stages"]):
        raise NotProvenError("a stage of a trap is below 1")
    event, ((a, b), (c, d)) = orbit["events"][claim["event"]], claim["axes"]
    kind, axes = (event["bound"], event["region"]), ((of(a), of(b)), (of(c), of(d)))
    inverse = inverse_of(a, b, c, d)
    trap = Trap(*kind, (of(*event["t"]), of(*event["v"])), inverse)
    n = claim["rounds"] * sum((it["bound"], it["region"]) == kind for it in orbit["events"])
    if n > MOST_EVENTS:
        raise NotProvenError(f"the rounds of a trap have more than {MOST_EVENTS} events")
    middle = trap.z[0].middle(), trap.z[1].middle()
    off = applied(inverse, (trap.z[0] - middle[0], trap.z[1] - middle[1]))

    def carried_from(part: Rectangle, by: Matrix) -> tuple[Iterator[Carried], Pair]:
        center, spread = _middle(part)
        t, v = (p + q for p, q in zip(middle, applied(by, center), strict=True))
        start = departing(law, kind[1], kind[0], (t, v))
        return carried(law, kind[1], kind[0], start, by, spread), spread

    def shrinks(part: Rectangle) -> bool:
        of_kind = (
            found for found in carried_from(part, axes)[0]
            if (found.event.bound, found.event.region) == kind
        )  # fmt: skip
        (p, q), (r, s) = product(inverse, next(islice(of_kind, n - 1, None)).derivative)
        # Both singular values of a matrix are below 1 if (1 - s^2)(1 - S^2) > 0 and s S < 1.
        size, det = p.square() + q.square() + r.square() + s.square(), p * s - q * r
        return bool((size - det.square()).high < unit() and det.size < unit())

    # The ellipse is about z, which is not the middle of its box.
    reach = 1 + Fraction(off[0].size + off[1].size, unit())
    whole = ((-reach, reach), (-reach, reach))
    _count_parts(whole, shrinks, "a trap is not proven to be mapped into itself")
    for stage in claim["stages"]:
        wider = tuple((stage * p, stage * q) for p, q in axes)
        inner = trap

        def comes_in(part: Rectangle, by: Any = wider, inner: Trap = inner) -> bool:
            from_middle = (max(low, -high, Fraction(0)) for low, high in part)
            if sum(x * x for x in from_middle) > reach * reach:
                return True
            motions, spread = carried_from(part, by)
            return any(inner.holds(law, found, spread) for found in motions)

        said = f"from stage {stage} of a trap motions are not proven to come in"
        _count_parts(whole, comes_in, said)
        (p, q), (r, s) = inverse
        trap = trap._replace(inverse=((p / stage, q / stage), (r / stage, s / stage)))
    return trap


def proven_basins(law: Law, claims: Any) -> str:
    """Prove of rectangles of starts that all motions from them approach the orbit that is claimed."""
    cells, orbits, steady = claims["cells"], claims["orbits"], claims["steady"]
    if not cells:
        raise NotProvenError("no cell is claimed")
    for it in cells:
        if it["x"][0] >= it["x"][1] or it["v"][0] >= it["v"][1]:
            raise NotProvenError(f"{_cell_said(it)} has no area")
        if it["to"] >= len(orbits) + len(steady):
            raise NotProvenError(f"{_cell_said(it)} goes to an orbit that is not there")
        _region_of(law, it)
    _check_disjoint(cells)
    said = [proven_orbit(law, it["orbit"]) for it in orbits]
    check_different(law, [it["orbit"] for it in orbits])
    for number in steady:
        if number >= len(law.regions) or steady.count(number) > 1:
            raise NotProvenError(f"region {number} is none, or stands twice")
        region = law.regions[number]
        if region.stiffness <= 0 or region.damping <= 0:
            raise NotProvenError(f"in region {number} motions do not decay")
        said.append(f"The motion in region {number} that repeats itself and meets no stop.")
    with bits(SET_BITS):
        traps = [[trap_of(law, it["orbit"], trap) for trap in it["traps"]] for it in orbits]
        fates: list[Any] = [*traps, *steady]
        n_parts = sum(check_cell(law, claims["t"], it, fates[it["to"]]) for it in cells)
    areas = [Fraction(0)] * len(fates)
    for it in cells:
        (a, b), (c, d) = it["x"], it["v"]
        areas[it["to"]] += (b - a) * (d - c)
    head = (
        f"From all starts at t = {phase_in_words(claims['t'])} in {counted(len(cells), 'rectangle')} of the "
        f"plane of x and v, which share no area, motions approach the orbits that are said, whole periods "
        f"of the force later or not (proven on {counted(n_parts, 'part')} of the rectangles). Nothing is "
        f"claimed of other starts."
    )
    lines = [head]
    for k, (orbit, area) in enumerate(zip(said, areas, strict=True)):
        own = [it for it in cells if it["to"] == k]
        if own:
            (a, b), (c, d) = (
                (told(min(it[key][0] for it in own)), told(max(it[key][1] for it in own)))
                for key in "xv"
            )
            lines.append(
                f"Orbit {k}: {orbit}\n  {counted(len(own), 'rectangle')} with an area of {told(area)}, "
                f"rounded down, from x = {a} to {b} and v = {c} to {d}, about, go to orbit {k}."
            )
    return "\n".join(lines)


def _cell_said(cell: Any) -> str:
    return f"the rectangle at x = {told(cell['x'][0])}, v = {told(cell['v'][0])}"


def _region_of(law: Law, cell: Any) -> int:
    """Return the region between the stops in which all of a rectangle lies."""
    low, high = cell["x"]
    for number in range(len(law.regions)):
        if all(
            sign * (law.bounds[bound].at - (high if sign > 0 else low)) > 0
            for bound, sign in law.sides(number)
        ):
            return number
    raise NotProvenError(f"{_cell_said(cell)} lies on a stop or beyond a wall")


def _check_disjoint(cells: Sequence[Any]) -> None:
    open_ones: list[Any] = []
    for cell in sorted(cells, key=lambda it: it["x"][0]):
        open_ones = [it for it in open_ones if it["x"][1] > cell["x"][0]]
        for it in open_ones:
            if it["v"][0] < cell["v"][1] and cell["v"][0] < it["v"][1]:
                raise NotProvenError(f"{_cell_said(cell)} overlaps another one")
        open_ones.append(cell)


def check_cell(law: Law, instant: Any, cell: Any, fate: Any) -> int:
    """Prove where all motions from a rectangle go, by parts of it; count these."""
    region, is_steady, t = _region_of(law, cell), isinstance(fate, int), angle(instant)
    axes = (of(1), of(0)), (of(0), of(1))

    def goes_there(part: Rectangle) -> bool:
        (x, v), spread = _middle(part)
        settling = fate if is_steady else None
        motions = carried(law, region, None, State(t, x, v), axes, spread, settling)
        if is_steady:
            # They end where all motions settle.
            return all(True for _ in motions)
        return any(trap.holds(law, found, spread) for found in motions for trap in fate)

    said = f"the starts of {_cell_said(cell)} are not proven to go where it says"
    return _count_parts((cell["x"], cell["v"]), goes_there, said)
