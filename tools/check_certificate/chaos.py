"""Chaos: a motion follows every walk through a graph.

Proven here: the images of parts of sets lie across other sets (covering relations), the sets are
disjoint, and the walks along the graph of these relations grow as is claimed, which bounds the
topological entropy of the map of departures from one bound. Section 11.11 of
docs/theory/certified.md, with section 10, says why motions follow all walks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import ceil, floor
from typing import Any, NamedTuple

from arithmetic import (
    HopelessError,
    Interval,
    Matrix,
    NotProvenError,
    Pair,
    applied,
    exponential,
    hull,
    inverse_of,
    of,
    product,
    unit,
    with_first,
)
from flights import Flight, Law, State, departing, met
from parts import Rectangle, Side, proven_on_parts
from words import told

# Parts are made smaller until a derivative is known on each to within this part of its largest
# entry: the first of these that suffices. After so many parts it may be wider.
NARROW, PARTS = tuple(Fraction(1, n) for n in (12, 100, 400, 1600)), 3000
# The smallest part of a strip that is tried, and events from one departure to the next.
SMALLEST_PART, MOST_EVENTS = Fraction(1, 2**24), 64


class Set(NamedTuple):
    """A parallelogram of (t, v): center +- unstable +- stable."""

    center: tuple[Fraction, Fraction]
    unstable: tuple[Fraction, Fraction]
    stable: tuple[Fraction, Fraction]

    def box(self, u: Side, s: Side) -> Pair:
        """Return the (t, v) of all points whose coordinates lie between two each."""
        t, v = (
            of(self.center[i]) + of(*u) * of(self.unstable[i]) + of(*s) * of(self.stable[i])
            for i in range(2)
        )
        return t, v

    def coordinates(self) -> Matrix:
        (a, c), (b, d) = self.unstable, self.stable
        return inverse_of(a, b, c, d)

    def axes(self) -> Matrix:
        (a, c), (b, d) = self.unstable, self.stable
        return (of(a), of(b)), (of(c), of(d))

    def duration(self) -> Fraction:
        """Return half of how much the instants of its points differ."""
        return abs(self.unstable[0]) + abs(self.stable[0])


class Map(NamedTuple):
    """The map from one departure from a bound into a region to the next."""

    law: Law
    bound: int
    region: int

    def image(self, box: Pair) -> tuple[State, Matrix]:
        """Return the images of a box of (t, v), and the derivative there."""
        state = departing(self.law, self.region, self.bound, box)
        event = met(Flight(self.law, self.region, state), self.bound)
        total = event.derivative
        for _ in range(MOST_EVENTS):
            if event.bound == self.bound and event.region == self.region:
                return event.after, total
            event = met(Flight(self.law, event.region, event.after), event.bound)
            total = product(event.derivative, total)
        raise NotProvenError(f"{MOST_EVENTS} events at other stops before the next one of the map")


def proven_chaos(law: Law, text: Any) -> str:
    """Prove covering relations, that the sets are disjoint, and the growth of the number of walks."""
    sets, transitions = [Set(**it) for it in text["sets"]], text["transitions"]
    bound, region, growth, period = text["bound"], text["region"], text["growth"], law.period()
    for i, first in enumerate(sets):
        if 2 * first.duration() * unit() >= period.low:
            raise NotProvenError(f"set {i} is longer than a period")
        with _told_of(f"of set {i}"):
            first.coordinates()
        for j in range(i):
            with _told_of(f"sets {j} and {i} are not proven to be apart"):
                if not are_apart(period, sets[j], first):
                    raise NotProvenError("they may have points in common")
    if not sets or any(max(it["from"], it["to"]) >= len(sets) for it in transitions):
        raise NotProvenError(f"there are no sets, or a transition leads beyond the {len(sets)}")
    if growth <= 1:
        raise NotProvenError(f"a growth of {growth} is no chaos")
    _check_growth(len(sets), {(it["from"], it["to"]) for it in transitions}, growth)
    entropy = _logarithm(growth)
    if entropy == 0:
        raise NotProvenError(f"a growth of {told(growth)} a step is too little to be told")
    for it in transitions:
        with _told_of(f"from set {it['from']} to set {it['to']}"):
            _check_covering(Map(law, bound, region), sets, it)
    return (
        f"The map from one departure from bound {bound} into region {region} to the next, with t modulo "
        f"the period of the force, {2 / law.base} pi, is chaotic: for every endless walk along the "
        f"{len(transitions)} transitions between the {len(sets)} sets of the certificate, which are "
        f"disjoint, there is a motion that visits the sets in its order, and for every closed walk one "
        f"that is periodic. The topological entropy of the map on these motions is at least "
        f"{told(entropy)} an impact."
    )


@contextmanager
def _told_of(what: str) -> Iterator[None]:
    """Say of what it is that something is not proven."""
    try:
        yield
    except NotProvenError as error:
        raise NotProvenError(f"{what}: {error}") from None


def are_apart(period: Interval, one: Set, other: Set) -> bool:
    """Return whether two sets have no point in common, whole periods later or not."""
    reach, distance = one.duration() + other.duration(), one.center[0] - other.center[0]
    # Whole periods by which the instants of the other one may be moved to some of the first.
    (low, _), (_, high) = ((of(distance + by) / period).fractions() for by in (-reach, reach))
    first, last = ceil(low), floor(high)
    # Each is shorter than a period, so more are of a distance that is not known well.
    return last - first < 3 and all(
        _are_apart_by(one, other, n * period) for n in range(first, last + 1)
    )


def _are_apart_by(one: Set, other: Set, shift: Interval) -> bool:
    """Return whether a side of one of two sets lies between them."""
    for a, b, sign in ((one, other, 1), (other, one, -1)):
        t = of(b.center[0] - a.center[0]) + sign * shift
        v = of(b.center[1] - a.center[1])
        to_a = a.coordinates()
        axes = product(to_a, b.axes())
        for k in range(2):
            middle = to_a[k][0] * t + to_a[k][1] * v
            if middle.least > unit() + axes[k][0].size + axes[k][1].size:
                return True
    return False


def _check_covering(of_departures: Map, sets: Sequence[Set], claim: Any) -> None:
    """Prove that the image of a strip of one set lies across another."""
    first, second, at, half = sets[claim["from"]], sets[claim["to"]], claim["at"], claim["half"]
    if not (half > 0 and abs(at) + half <= 1):
        raise NotProvenError("the strip is not in its set")
    shift = claim["turns"] * of_departures.law.period()
    to_second = second.coordinates()
    image, _ = of_departures.image(first.box((at, at), (Fraction(0), Fraction(0))))
    t, v = image.t - shift - of(second.center[0]), image.v - of(second.center[1])
    u, s = applied(to_second, (t, v))
    axes = product(first.axes(), ((of(half), of(0)), (of(0), of(1))))

    def lies_across(narrow: Fraction) -> None:
        parts = []
        for derivative in _derivatives(of_departures, first, (at - half, at + half), narrow):
            part = product(to_second, product(derivative, axes))
            (u_by_u, _), (s_by_u, s_by_s) = part
            if u_by_u.size <= unit() + u.least or s.least + s_by_u.least + s_by_s.least >= unit():
                raise HopelessError("the image is too short along, or too far across")
            parts.append(part)
        (u_by_u, u_by_s), (s_by_u, s_by_s) = (
            tuple(hull([part[i][j] for part in parts]) for j in range(2)) for i in range(2)
        )
        # The unstable sides are carried to u +- u_by_u, and some way beside.
        beyond = u_by_u.least - u.size - u_by_s.size
        within = s.size + s_by_u.size + s_by_s.size
        if beyond <= unit() or within >= unit():
            raise NotProvenError(
                f"the image reaches {told(Fraction(beyond, unit()))} along and "
                f"{told(Fraction(within, unit()))} across, which should be above and below 1"
            )

    with_first(NARROW, lies_across)


def _derivatives(of_departures: Map, first: Set, along: Side, narrow: Fraction) -> Iterator[Matrix]:
    """Yield derivatives of the map that hold on parts of a strip, which together are all of it."""
    n_tried = 0

    def narrow_enough(part: Rectangle) -> Matrix | None:
        nonlocal n_tried
        n_tried += 1
        _, derivative = of_departures.image(first.box(*part))
        entries = [entry for row in derivative for entry in row]
        is_narrow = max(e.width for e in entries) <= narrow * max(e.size for e in entries)
        return derivative if is_narrow or n_tried > PARTS else None

    strip, said = (along, (Fraction(-1), Fraction(1))), "the map of a strip is open"
    half = (along[1] - along[0]) / 2
    lengths = half * max(map(abs, first.unstable)), max(map(abs, first.stable))
    return proven_on_parts(strip, narrow_enough, said, SMALLEST_PART, lengths)


def _check_growth(n: int, transitions: set[tuple[int, int]], growth: Fraction) -> None:
    """Prove that the walks of k steps grow as growth^k at least.

    A vector y >= 0, not 0, with A y >= growth y for the matrix A of the graph gives that (Collatz
    and Wielandt); one is made by many steps from (1, ..., 1) with rounding, which the check
    forgives.
    """
    following: list[list[int]] = [[] for _ in range(n)]
    for i, j in transitions:
        following[i].append(j)
    y = [1 << 200] * n
    for _ in range(4000):
        moved = [sum(y[j] for j in row) + y[i] for i, row in enumerate(following)]
        top = max(moved)
        y = [(value << 200) // top for value in moved]
    if any(sum(y[j] for j in row) < growth * y[i] for i, row in enumerate(following)):
        raise NotProvenError(f"the walks are not proven to grow by {told(growth)} a step")


def _logarithm(value: Fraction) -> Fraction:
    """Return a number, of six decimals, not above the natural logarithm."""
    low, high = 0, 10**6 * ceil(value).bit_length()
    while high - low > 1:
        middle = (low + high) // 2
        fits = exponential(of(Fraction(middle, 10**6))).high <= of(value).low
        low, high = (middle, high) if fits else (low, middle)
    return Fraction(low, 10**6)
