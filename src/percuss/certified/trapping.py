"""Sets about stable orbits that all motions in them never leave again, and in which they settle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.cloud import BallMatrix, BallPair, Cloud, applied, times
from percuss.certified.covering import ImageOfSet, ImpactSurface, halves_of
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.shooting import OrbitEvent
from percuss.certified.system import BallSystem

# A set is mapped into itself, made smaller by this at least.
SHRINKS = 0.999
# Radii that are tried, in units of the period and the orbit's velocity: the first, and by how much
# the next is smaller.
LARGEST, SMALLER, TRIALS = 0.3, 0.7, 30
# Rounds of the orbit after which a set is to be mapped into itself.
ROUNDS = (1, 3)
# Parts into which a set is divided for its derivatives.
MOST_PARTS = 96
# Stretches shorter than this part of the spread of a set are not worth a try.
SHORTEST = 0.25
# From a set that is wider by this all motions are proven to come into the set before; parts into
# which it is divided for that, the smallest of their sides, and the events after which they should
# be there.
WIDER, MOST_PARTS_OF_STAGE, SMALLEST_SIDE, MOST_RETURNS = 1.25, 400, 2.0**-6, 20
# By how much the set on which the derivatives are known is larger, for the radius of its middle.
MARGIN = 2.0**-20


class Trap(NamedTuple):
    """The ellipse of states z + E w, abs(w) < 1, after an event; z is a point of an orbit exactly.

    Motions from it come into the ellipse z + F w and do not leave that; E is a multiple of F.

    Attributes
    ----------
    event
        The kind of the event.
    state
        Balls that hold z: instant and velocity.
    axes, inverse
        E, exact, and balls of its inverse.
    within
        F, exact.
    rounds
        Rounds of the orbit after which the ellipse of F is mapped into itself.
    stages
        Multiples of F, from each of which motions are proven to come into the one before: E last.
    """

    event: OrbitEvent
    state: BallPair
    axes: BallMatrix
    inverse: BallMatrix
    within: BallMatrix
    rounds: int
    stages: tuple[float, ...] = ()

    def holds(self, event: OrbitEvent, cloud: Cloud, period: arb) -> bool:
        """Return whether all states of a set after an event lie inside, whole periods later or not."""
        if event != self.event:
            return False
        t, v = cloud.middle
        t = t - self.state[0]
        t = t - round(float(t / period)) * period
        c1, c2 = applied(self.inverse, (t, v - self.state[1]))
        (a, b), (c, d) = times(self.inverse, cloud.axes)
        r, s = cloud.spread
        # The norm is convex: it is largest at a corner.
        return all(
            (c1 + a * p + b * q) ** 2 + (c2 + c * p + d * q) ** 2 < 1
            for p in (r.lower(), r.upper())
            for q in (s.lower(), s.upper())
        )

    def outline(self, points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        """Return the states at some points (cosine, sine) of its edge, about."""
        t, v = (float(value) for value in self.state)
        (a, b), (c, d) = ((float(x) for x in row) for row in self.axes)
        return [(t + a * p + b * q, v + c * p + d * q) for p, q in points]


@dataclass(frozen=True)
class _Return:
    """The map F^n from events of an orbit to the same ones a period of it later."""

    surface: ImpactSurface
    n: int

    def image(self, cloud: Cloud) -> ImageOfSet:
        """Return the image of the middle of a set, and the derivative on all of it."""
        image = self.surface.image(cloud, _finest(cloud))
        product = image.derivative
        for _ in range(self.n - 1):
            cloud = cloud.image(image.middle, image.derivative)
            image = self.surface.image(cloud, _finest(cloud))
            product = times(image.derivative, product)
        return ImageOfSet(image.middle, product)


def _finest(cloud: Cloud) -> float:
    """Return a length of stretches that a set is too wide for."""
    return SHORTEST * float(cloud.box()[0].rad())


def traps_about(system: BallSystem, orbit: CertifiedOrbit, go_on: Callable[[], bool]) -> list[Trap]:
    """Return sets about the impacts of an orbit, proven to be mapped into themselves.

    Parameters
    ----------
    system
        The exact system, without a record.
    orbit
        Proven to be asymptotically stable, and to have events.
    go_on
        Asked before each part of a set is followed; False ends the search for larger sets.

    Raises
    ------
    Undecided
        If no set is proven to be one.
    """
    events = orbit.events
    if not events:
        raise Undecided("precision", "the events of the orbit are not known")
    kind = next((event for event, _ in events if event.wall), events[0][0])
    states = [state for event, state in events if event == kind]
    back = _Return(ImpactSurface(system, kind), len(states))
    scale = float(back.surface.period), max(float(abs(v)) for _, v in states)
    return [_wider(back.surface, _trap(back, state, scale, go_on), go_on) for state in states]


def _trap(
    back: _Return, state: BallPair, scale: tuple[float, float], go_on: Callable[[], bool]
) -> Trap:
    """Return the largest of the sets that are mapped into themselves after some rounds."""
    axes = _axes(back, state, scale)
    best: Trap | None = None
    least = LARGEST * SMALLER**TRIALS
    for rounds in ROUNDS:
        radius = LARGEST
        while radius > least:
            trap = _scaled(back.surface.event, state, axes, radius, rounds)
            if _is_mapped_into_itself(replace(back, n=rounds * back.n), trap, go_on):
                best, least = trap, radius
                break
            radius *= SMALLER
    if best is None:
        raise Undecided("precision", "no set about the orbit is proven to be mapped into itself")
    return best


def _axes(back: _Return, state: BallPair, scale: tuple[float, float]) -> BallMatrix:
    """Return about the axes in which the derivative turns and shrinks: real parts of eigenvectors."""
    point = Cloud.of(state[0].mid(), state[1].mid())
    (a, b), (c, d) = back.image(point).derivative
    t, v = scale
    # In units of the scales.
    a, b, c, d = (value.mid() for value in (a, b * v / t, c * t / v, d))
    half, det = (a + d) / 2, a * d - b * c
    inside = (half * half - det).mid()
    root = abs(inside).sqrt().mid()
    if b.is_zero() and c.is_zero():
        columns = (arb(1), arb(0)), (arb(0), arb(1))
    elif inside > 0:
        columns = _eigenvector(a, b, c, d, half + root), _eigenvector(a, b, c, d, half - root)
    elif abs(b) > abs(c):
        columns = (b, half - a), (arb(0), root)
    else:
        columns = (half - d, c), (root, arb(0))
    # The columns of a pair keep their ratio.
    sizes = [(x * x + y * y).sqrt() for x, y in columns]
    if not inside > 0:
        sizes = [sizes[0].max(sizes[1])] * 2
    (x1, y1), (x2, y2) = (
        ((x * t / size).mid(), (y * v / size).mid())
        for (x, y), size in zip(columns, sizes, strict=True)
    )
    return (x1, x2), (y1, y2)


def _eigenvector(a: arb, b: arb, c: arb, d: arb, value: arb) -> BallPair:
    first, second = (b, value - a), (value - d, c)
    sizes = [abs(x) + abs(y) for x, y in (first, second)]
    return first if sizes[0] > sizes[1] else second


def _scaled(
    event: OrbitEvent, state: BallPair, axes: BallMatrix, radius: float, rounds: int
) -> Trap:
    (a, b), (c, d) = (((radius * x).mid(), (radius * y).mid()) for x, y in axes)
    size = a * d - b * c
    if size.contains(0):
        raise Undecided("precision", "the axes of the orbit's derivative are parallel")
    inverse = (d / size, -b / size), (-c / size, a / size)
    return Trap(event, state, ((a, b), (c, d)), inverse, ((a, b), (c, d)), rounds)


def _wider(surface: ImpactSurface, trap: Trap, go_on: Callable[[], bool]) -> Trap:
    """Return the largest ellipse, by stages, from which all motions are proven to come into a trap."""
    while True:
        stage = WIDER ** (len(trap.stages) + 1)
        scaled = _scaled(trap.event, trap.state, trap.within, stage, trap.rounds)
        wider = scaled._replace(within=trap.within, stages=(*trap.stages, stage))
        try:
            if not _all_come_into(surface, wider, trap, go_on):
                return trap
        except Undecided:
            return trap
        trap = wider


def _all_come_into(
    surface: ImpactSurface, outer: Trap, inner: Trap, go_on: Callable[[], bool]
) -> bool:
    """Return whether all motions from an ellipse are proven to come into another one."""
    middle = outer.state[0].mid(), outer.state[1].mid()
    unit = arb(0, 1.0 + 2.0 * MARGIN)
    parts, done = [Cloud(middle, outer.axes, (unit, unit))], 0
    while parts:
        if not go_on():
            return False
        part = parts.pop()
        done += 1
        if _is_outside(outer, middle, part) or _comes_into(surface, part, inner):
            continue
        sides = [float(side.rad()) for side in part.spread]
        if done + len(parts) > MOST_PARTS_OF_STAGE or max(sides) < SMALLEST_SIDE:
            return False
        parts += halves_of(part)
    return True


def _is_outside(trap: Trap, middle: BallPair, part: Cloud) -> bool:
    """Return whether a part of a parallelogram about an ellipse has no state of it."""
    off = applied(trap.inverse, (part.middle[0] - middle[0], part.middle[1] - middle[1]))
    near = [
        (abs(value) - side.rad()).lower().max(arb(0))
        for value, side in zip(off, part.spread, strict=True)
    ]
    return bool(near[0] ** 2 + near[1] ** 2 > (1.0 + 4.0 * MARGIN) ** 2)


def _comes_into(surface: ImpactSurface, cloud: Cloud, trap: Trap) -> bool:
    for _ in range(MOST_RETURNS):
        try:
            image = surface.image(cloud, _finest(cloud))
        except Undecided:
            return False
        cloud = cloud.image(image.middle, image.derivative)
        if trap.holds(surface.event, cloud, surface.period):
            return True
    return False


def _is_mapped_into_itself(back: _Return, trap: Trap, go_on: Callable[[], bool]) -> bool:
    """Return whether the derivative is proven to shrink the norm abs(w) on all of the set."""
    middle = trap.state[0].mid(), trap.state[1].mid()
    offset = applied(trap.inverse, (trap.state[0] - middle[0], trap.state[1] - middle[1]))
    if not all(abs(value) < MARGIN for value in offset):
        return False
    unit = arb(0, 1.0 + 2.0 * MARGIN)
    parts, done = [Cloud(middle, trap.axes, (unit, unit))], 0
    while parts:
        if not go_on():
            return False
        part = parts.pop()
        done += 1
        if _shrinks(back, trap, part):
            continue
        # Where the middle itself is not nearer afterwards smaller parts do not help.
        middle_alone = replace(part, spread=(arb(0), arb(0)))
        if done + len(parts) > MOST_PARTS or not _shrinks(back, trap, middle_alone):
            return False
        parts += halves_of(part)
    return True


def _shrinks(back: _Return, trap: Trap, part: Cloud) -> bool:
    """Return whether the derivative is proven to make all vectors shorter on a part of a set."""
    try:
        derivative = back.image(part).derivative
    except Undecided:
        return False
    return bool(_norm_squared(times(trap.inverse, times(derivative, trap.axes))) < SHRINKS**2)


def _norm_squared(matrix: BallMatrix) -> arb:
    """Return a bound of the square of the Euclidean norm of a matrix."""
    (a, b), (c, d) = matrix
    size, det = (a * a + b * b + c * c + d * d).upper(), (a * d - b * c).abs_lower()
    rest = (size * size - 4 * det * det).upper()
    return (size + rest.max(arb(0)).sqrt()) / 2
