"""Parallelograms of an impact surface, and the proof that the image of one covers another.

An h-set is a parallelogram with an unstable and a stable pair of sides. One covers another under a
map if its image lies across the other: between the stable sides, and beyond the unstable ones, on
either side of them. Along a closed chain of coverings there is a periodic orbit (Zgliczynski &
Gidea, J. Differential Equations 202 (2004) 32).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, applied, times
from percuss.certified.numbers import between, precision
from percuss.certified.set_flight import SlowEvents, next_passage, search_set
from percuss.certified.shooting import OrbitEvent
from percuss.certified.step import Departure
from percuss.certified.system import BallSystem

# Flights up to this many periods are searched.
LONGEST = 100.0
# Events on other bounds before the next one on the surface.
MOST_EVENTS = 64
# A derivative known to within this part of its largest entry is not made narrower by smaller boxes.
NARROW = 0.04
# Parts into which a set is divided.
MOST_PARTS = 512
# By how much more than it needs an image has to reach: the floats of a strip, which what covers the
# whole set has to cover too, are rounded by less.
SLACK = 1e-6
# Bits in which the middles of parts are exact.
EXACT = 2048


class HSet(NamedTuple):
    """A parallelogram of instants and velocities after an impact; its floats are exact numbers.

    Attributes
    ----------
    center
        Instant and velocity.
    unstable, stable
        Vectors from the center to the middle of an unstable and of a stable side.
    """

    center: tuple[float, float]
    unstable: tuple[float, float]
    stable: tuple[float, float]

    def strip(self, at: float, half: float) -> HSet:
        """Return the part between the stable sides from at - half to at + half along the unstable.

        In units of the half-length of the unstable direction. What covers the whole covers the
        part.
        """
        (t, v), (dt, dv) = self.center, self.unstable
        return HSet((t + at * dt, v + at * dv), (half * dt, half * dv), self.stable)

    def cloud(self) -> Cloud:
        """Return the set in the form that flights take."""
        axes: BallMatrix = (
            (arb(self.unstable[0]), arb(self.stable[0])),
            (arb(self.unstable[1]), arb(self.stable[1])),
        )
        unit = arb(0, 1)
        return Cloud((arb(self.center[0]), arb(self.center[1])), axes, (unit, unit))

    def coordinates(self) -> BallMatrix:
        """Return the matrix that takes a vector to the coordinates of the set, in which it is [-1, 1]^2.

        Raises
        ------
        Undecided
            If the sides are not proven to be independent.
        """
        (a, c), (b, d) = self.unstable, self.stable
        size = arb(a) * d - arb(b) * c
        if size.contains(0):
            raise Undecided("precision", "the sides of a set are parallel")
        return (arb(d) / size, -arb(b) / size), (-arb(c) / size, arb(a) / size)


class Covering(NamedTuple):
    """The image of a set in the coordinates of another.

    Attributes
    ----------
    sign
        Whether it keeps (+1) or reverses (-1) the unstable direction.
    beyond
        By how much the images of the unstable sides lie beyond those of the other set, at least.
    within
        Greatest distance of the image from the middle between the stable sides, below 1.
    turns
        Forcing periods by which the image is later than the other set.
    """

    sign: int
    beyond: float
    within: float
    turns: int


class ImageOfSet(NamedTuple):
    """The image of the middle of a set, and the derivative of the map on all of it."""

    middle: BallPair
    derivative: BallMatrix


@dataclass(frozen=True, slots=True)
class ImpactSurface:
    """The events of one kind, and the map from each to the next of them.

    Attributes
    ----------
    system
        The exact system, without a record.
    event
        The kind: its bound, and the regions before and after it.
    """

    system: BallSystem
    event: OrbitEvent

    @property
    def period(self) -> arb:
        """Period of the forcing at the working precision."""
        return law_of(self.system).period(1)

    def image(self, cloud: Cloud, finest: float = 0.0) -> ImageOfSet:
        """Return the image of the middle of a set of states, and the derivative on all of it.

        Stretches of flights below ``finest`` are not tried.

        Raises
        ------
        Undecided
            If the balls leave open which events come next.
        """
        start = Departure(self.event.after, cloud, self.event.bound)
        longest = LONGEST * float(self.period.upper())
        product: BallMatrix | None = None
        point = cloud.middle
        for _ in range(MOST_EVENTS):
            search = search_set(self.system, start, longest, SlowEvents(finest))
            passage = next_passage(self.system, start, search)
            if passage is None:
                raise Undecided("no_event", f"a flight meets no stop within {longest:.6g}")
            by = passage.derivative
            product = by if product is None else times(by, product)
            point = passage.image_of(point, start)
            if passage.event == self.event:
                return ImageOfSet(point, product)
            start = passage.following
        raise Undecided("no_event", f"{MOST_EVENTS} events on other stops before the next impact")


def image_of(surface: ImpactSurface, first: HSet) -> ImageOfSet:
    """Return what `ImpactSurface.image` does, with the derivative of all parts of a divided set.

    The set is divided until the derivative of each part is narrow. By the mean value theorem two
    points of the set have images whose difference is a mean of these derivatives times theirs.

    Raises
    ------
    Undecided
        If it is open still on the smallest parts.
    """
    cloud = first.cloud()
    middle = surface.image(Cloud(cloud.middle, cloud.axes, (arb(0), arb(0)))).middle
    derivative: BallMatrix | None = None
    for part in _derivatives(surface, cloud):
        derivative = part if derivative is None else _joined(derivative, part)
    assert derivative is not None
    return ImageOfSet(middle, derivative)


def _derivatives(surface: ImpactSurface, cloud: Cloud) -> Iterator[BallMatrix]:
    parts, done = [cloud], 0
    while parts:
        part = parts.pop()
        done += 1
        try:
            derivative = surface.image(part).derivative
        except Undecided:
            if done + len(parts) > MOST_PARTS:
                raise
            parts += halves_of(part)
            continue
        if _is_narrow(derivative) or done + len(parts) > MOST_PARTS:
            yield derivative
        else:
            parts += halves_of(part)


def _is_narrow(derivative: BallMatrix) -> bool:
    entries = [entry for row in derivative for entry in row]
    widest = max(float(entry.rad()) for entry in entries)
    return widest <= NARROW * max(float(entry.abs_upper()) for entry in entries)


def halves_of(cloud: Cloud) -> list[Cloud]:
    """Return the two halves of a set, divided across its longer side."""
    columns = zip(*cloud.axes, strict=True)
    sides = [
        float(max(abs(entry) for entry in column)) * float(spread.rad())
        for column, spread in zip(columns, cloud.spread, strict=True)
    ]
    k = int(sides[1] > sides[0])
    half = cloud.spread[k].rad() / 2
    halves = []
    with precision(EXACT):
        for sign in (-1, 1):
            shift = [cloud.spread[0].mid(), cloud.spread[1].mid()]
            shift[k] = shift[k] + sign * half
            moved = applied(cloud.axes, (shift[0], shift[1]))
            middle = (cloud.middle[0] + moved[0], cloud.middle[1] + moved[1])
            if not all(value.is_exact() for value in middle):
                raise Undecided("precision", "a set is divided into parts too small")
            spread = [arb(0, side.rad()) for side in cloud.spread]
            spread[k] = arb(0, half)
            halves.append(Cloud(middle, cloud.axes, (spread[0], spread[1])))
    return halves


def _joined(a: BallMatrix, b: BallMatrix) -> BallMatrix:
    (a11, a12), (a21, a22) = a
    (b11, b12), (b21, b22) = b
    return (between(a11, b11), between(a12, b12)), (between(a21, b21), between(a22, b22))


def covering(surface: ImpactSurface, image: ImageOfSet, first: HSet, second: HSet) -> Covering:
    """Return how the image of a set covers another, for certain.

    Parameters
    ----------
    surface
        The map.
    image
        Of ``first``, by `image_of`.
    first, second
        The set that is mapped, and the one that its image may cover.

    Raises
    ------
    Undecided
        If it is not proven to.
    """
    seen = seen_from(surface, image, first, second)
    (u_by_u, u_by_s), (s_by_u, s_by_s) = seen.derivative
    # The unstable sides are at u +- u_by_u, and some way beside.
    beyond = u_by_u.abs_lower() - abs(seen.middle[0]) - abs(u_by_s)
    within = abs(seen.middle[1]) + abs(s_by_u) + abs(s_by_s)
    if not (within < 1 - SLACK and beyond > 1 + SLACK):
        reason = "a set is not proven to cover another: its image reaches "
        reason += (
            f"{float(beyond.lower()):.3g} along and {float(within.upper()):.3g} across, which "
        )
        raise Undecided("precision", reason + "should be above and below 1")
    sign = 1 if u_by_u > 0 else -1
    return Covering(
        sign, float(beyond.lower()), float(within.upper()), turns_between(surface, image, second)
    )


def turns_between(surface: ImpactSurface, image: ImageOfSet, second: HSet) -> int:
    """Return by how many forcing periods an image is later than a set."""
    return round(float((image.middle[0] - second.center[0]) / surface.period))


def seen_from(surface: ImpactSurface, image: ImageOfSet, first: HSet, second: HSet) -> ImageOfSet:
    """Return the image of a set in the coordinates of both: of its middle, and the derivative."""
    to_second = second.coordinates()
    derivative = times(to_second, times(image.derivative, first.cloud().axes))
    t, v = image.middle
    t = t - turns_between(surface, image, second) * surface.period
    return ImageOfSet(applied(to_second, (t - second.center[0], v - second.center[1])), derivative)


def are_disjoint(surface: ImpactSurface, first: HSet, second: HSet) -> bool:
    """Return whether two sets are proven to have no state in common, whole periods apart or not.

    Sets shorter than a period whose instants are less than two periods apart may have one at a
    shift by a period or none; of others nothing is said.
    """
    reach = [abs(arb(s.unstable[0])) + abs(arb(s.stable[0])) for s in (first, second)]
    apart = abs(arb(first.center[0]) - second.center[0])
    if not (all(2 * r < surface.period for r in reach) and apart + sum(reach) < 2 * surface.period):
        return False
    return all(_are_apart(surface, first, second, n) for n in (-1, 0, 1))


def _are_apart(surface: ImpactSurface, first: HSet, second: HSet, turns: int) -> bool:
    """Return whether a side of one of two parallelograms separates it from the other."""
    t = second.center[0] - arb(first.center[0]) + turns * surface.period
    offset = t, second.center[1] - arb(first.center[1])
    for one, other in ((first, second), (second, first)):
        to_one = one.coordinates()
        middle = applied(to_one, offset)
        by_u, by_s = (applied(to_one, (arb(x), arb(y))) for x, y in (other.unstable, other.stable))
        if any(abs(middle[k]) > 1 + abs(by_u[k]) + abs(by_s[k]) for k in (0, 1)):
            return True
    return False
