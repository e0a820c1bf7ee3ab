"""The growth of an invariant curve: a parabola at the saddle, and its images, refined where they bend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.numerics import atan2, hypot, power, solve_linear

GrowthEnd: TypeAlias = Literal["length", "max_points", "no_image", "collapse", "interrupted"]
# Points of the piece next to the saddle, before it is refined.
FIRST_POINTS = 17
# Parts of that piece nearer than this are neighbouring floats: a distance there is a jump.
FINEST = 1e-9
# Neighbours may turn the curve by so much [rad] if they are not closer than this part of the
# spacing already.
TURN, CLOSE = 0.15, 0.05
# Images of the fundamental domain, and refinements of each, at most.
MOST_IMAGES, MOST_REFINEMENTS = 2000, 1000
# An image shorter than this part of the spacing has shrunk to a point.
COLLAPSED = 1e-6


@dataclass(frozen=True, slots=True)
class Grown:
    """A manifold as points in a row.

    Attributes
    ----------
    points
        (n, d) array.
    piece
        (n,) array, number of the continuous piece that each belongs to, ascending from 0.
    arclength
        (n,) array, length of the pieces so far, in the units of the scale.
    image
        (n,) array, how often the map was applied to each.
    end
        Why it ends.
    """

    points: Floats
    piece: Integers
    arclength: Floats
    image: Integers
    end: GrowthEnd


@dataclass(slots=True)
class Grower:
    """Maps the fundamental domain of a manifold, from s / lambda to s, forward.

    Attributes
    ----------
    forward, differences
        The map, which moves points off the saddle and keeps their side, and differences.
    local
        The manifold next to the saddle.
    side
        +1 or -1, the side of the saddle.
    scale
        (2,) array, units of length.
    spacing
        Largest distance of neighbours, in these units.
    """

    forward: PointMap
    differences: Difference
    local: LocalManifold
    side: float
    scale: Floats
    spacing: float

    def begin(self, parts: Floats) -> Floats:
        """Return the points of the fundamental domain at parts from 0 to 1 of it."""
        reach = self.side * self.local.reach
        return self.local.at(reach * power(self.local.multiplier, parts - 1.0))

    def refined(
        self, parts: Floats, points: Floats, image: int, longest: float, capacity: int
    ) -> tuple[Floats, Floats, bool]:
        """Return the parts and their images, refined where neighbours are too distant.

        At most a length of ``longest`` and ``capacity`` points are refined; the flag says whether
        that was all.
        """
        for _ in range(MOST_REFINEMENTS):
            gaps = np.diff(parts)
            # Chords are no longer than their arcs, jumps have no length.
            chords = np.where(gaps > FINEST, np.nan_to_num(self.sizes(points)), 0.0)
            before = np.cumsum(chords) - chords
            wide = self._wide(points)
            wide &= (gaps > FINEST) & (before < longest)
            count = int(wide.sum())
            if count == 0:
                return parts, points, len(parts) <= capacity
            if len(parts) + count > capacity:
                break
            new = (parts[:-1] + 0.5 * gaps)[wide]
            mapped = self.begin(new)
            for _ in range(image):
                mapped = self.forward(mapped)
            order = np.argsort(np.concatenate([parts, new]), kind="stable")
            parts = np.concatenate([parts, new])[order]
            points = np.concatenate([points, mapped])[order]
        return parts, points, False

    def sizes(self, points: Floats) -> Floats:
        """Return the (n - 1,) distances of neighbours, in units of the scale."""
        return _lengths(self.steps(points))

    def steps(self, points: Floats) -> Floats:
        """Return the (n - 1, d) differences of neighbours, in units of the scale."""
        return np.asarray(self.differences(points[:-1], points[1:]) / self.scale)

    def _wide(self, points: Floats) -> Flags:
        """Return between which neighbours another point is needed."""
        steps, sizes = self.steps(points), self.sizes(points)
        known = np.isfinite(points[:, 0])
        wide: Flags = np.logical_or(sizes > self.spacing, known[1:] != known[:-1])
        cross = _areas(steps[:-1], steps[1:])
        along = (steps[:-1] * steps[1:]).sum(axis=1)
        sharp = np.abs(atan2(cross, along)) > TURN
        large = sizes > CLOSE * self.spacing
        wide[:-1] |= sharp & large[:-1]
        wide[1:] |= sharp & large[1:]
        return wide


def _lengths(steps: Floats) -> Floats:
    """Return the lengths of vectors, (n, d)."""
    lengths = hypot(steps[:, 0], steps[:, 1])
    for column in steps.T[2:]:
        lengths = hypot(lengths, column)
    return np.asarray(lengths)


def _areas(one: Floats, other: Floats) -> Floats:
    """Return the areas that pairs of vectors (n, d) span, in the plane with a sign."""
    if one.shape[1] == 2:
        return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    squares = (one * one).sum(axis=1) * (other * other).sum(axis=1)
    along = (one * other).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(squares - along * along, 0.0)))


def grow(grower: Grower, length: float, max_points: int, go_on: Callable[[float], bool]) -> Grown:
    """Grow one branch of a manifold from its saddle on.

    Its points are images of points of a fundamental domain: none is interpolated. Where images
    of neighbours are too distant, or turn too sharply, the domain is divided between them, and the
    new point mapped as often. Where neighbours remain distant the manifold is cut.

    Parameters
    ----------
    grower
        The map and the manifold next to the saddle.
    length
        Length of the branch, in the units of the scale.
    max_points
        Points after which no more are made.
    go_on
        Called with the part of the length that is done; stops by returning False.

    Returns
    -------
    Grown
        The branch.
    """
    local = grower.local
    n_inner = min(2 + int(local.reach / grower.spacing), max_points)
    inner = np.linspace(0.0, local.reach / local.multiplier, n_inner)
    blocks = [local.at(grower.side * inner)]
    parts = np.linspace(0.0, 1.0, FIRST_POINTS)
    points = grower.begin(parts)
    done, count = float(inner[-1]), len(inner)
    end: GrowthEnd = "no_image"
    for image in range(MOST_IMAGES):
        points = points if image == 0 else grower.forward(points)
        parts, points, enough = grower.refined(
            parts, points, image, length - done, max_points - count
        )
        sizes = grower.sizes(points)
        travelled = done + np.cumsum(np.where(sizes <= grower.spacing, sizes, 0.0))
        # Points beyond the length or the capacity are not refined.
        last = int(np.searchsorted(travelled, length))
        if not enough:
            coarse = (sizes > grower.spacing) & (np.diff(parts) > FINEST)
            last = min(last, int(np.argmax(coarse)) if coarse.any() else len(coarse))
            last = min(last, max_points - count)
        blocks.append(points[1 : last + 2 if enough else last + 1])
        count += len(blocks[-1])
        added, done = float(travelled[-1]) - done, float(travelled[-1])
        if done >= length:
            end = "length"
        elif not enough:
            end = "max_points"
        elif np.isnan(points).any(axis=1).all():
            end = "no_image"
        elif added <= COLLAPSED * grower.spacing:
            end = "collapse"
        elif not go_on(done / length):
            end = "interrupted"
        else:
            continue
        break
    images = np.repeat(np.arange(-1, len(blocks) - 1), [len(block) for block in blocks]).clip(0)
    return _joined(grower, np.concatenate(blocks), images, length, end)


def _joined(
    grower: Grower, points: Floats, image: Integers, length: float, end: GrowthEnd
) -> Grown:
    """Return the branch, cut into its continuous pieces and at its length."""
    sizes = grower.sizes(points)
    joined = sizes <= grower.spacing
    arclength = np.concatenate([[0.0], np.cumsum(np.where(joined, sizes, 0.0))])
    piece = np.concatenate([[0], np.cumsum(~joined)])
    kept = np.isfinite(points).all(axis=1) & (arclength <= length)
    # A point that nothing joins to another is no piece of a curve.
    kept &= np.append(False, joined) | np.append(joined, False)
    _, numbers = np.unique(piece[kept], return_inverse=True)
    return Grown(points[kept], numbers, arclength[kept], image[kept], end)


# Maps (n, d) points to (n, d) points, NaN without an image.
PointMap: TypeAlias = Callable[[Floats], Floats]
Difference: TypeAlias = Callable[[Floats, Floats], Floats]
# Step of the second difference of the map, as a part of the size: it leaves an error of 1e-8.
STEP = 1e-4
# A parabola is good where its image misses it by less than this part of the size.
TOLERANCE = 1e-10
LONGEST, SHORTEST = 0.02, 1e-7


@dataclass(frozen=True, slots=True)
class LocalManifold:
    """The parabola saddle + s e + s^2 h, whose image under the map has lambda s for s.

    Attributes
    ----------
    saddle, direction, bend
        (d,) arrays: the fixed point, e and h.
    multiplier
        lambda, of modulus above 1, as the map stretches the parabola.
    reach
        Largest s at which it is good.
    defect
        By how much the image misses it there, in the units of the scale.
    """

    saddle: Floats
    direction: Floats
    bend: Floats
    multiplier: float
    reach: float
    defect: float

    def at(self, s: Floats) -> Floats:
        """Return (n, d) points."""
        column = s[:, None]
        return np.asarray(self.saddle + column * (self.direction + column * self.bend))


def local_manifold(
    forward: PointMap,
    differences: Difference,
    saddle: Floats,
    jacobian: Floats,
    direction: Floats,
    multiplier: float,
    scale: Floats,
) -> LocalManifold:
    """Return the manifold next to a saddle, to second order where that is better.

    Parameters
    ----------
    forward, differences
        The map, under which points on the manifold move off the saddle, and differences.
    saddle
        (d,) array, its fixed point.
    jacobian
        (d, d) array, its derivative there.
    direction, multiplier
        Eigenvector, of length 1 in the units of the scale, and eigenvalue.
    scale
        (2,) array, units of length.

    Returns
    -------
    LocalManifold
        With a defect above `TOLERANCE` where the map is not smooth next to the saddle.
    """
    straight = LocalManifold(saddle, direction, np.zeros(len(saddle)), multiplier, LONGEST, 0.0)
    bent = replace(straight, bend=_bend(forward, differences, straight, jacobian))
    reach = LONGEST
    while reach >= SHORTEST:
        tried = [
            _with_defect(forward, differences, replace(local, reach=reach), scale)
            for local in (straight, bent)
        ]
        best = min(tried, key=lambda local: local.defect)
        if best.defect <= TOLERANCE:
            break
        reach *= 0.5
    return best


def _with_defect(
    forward: PointMap, differences: Difference, local: LocalManifold, scale: Floats
) -> LocalManifold:
    s = local.reach * np.array([1.0, 0.7, 0.3, -1.0, -0.7, -0.3])
    missed = differences(forward(local.at(s / local.multiplier)), local.at(s)) / scale
    # Without an image it misses by any length.
    defect = np.nan_to_num(_lengths(missed), nan=np.inf).max()
    return replace(local, defect=float(defect))


def _bend(
    forward: PointMap, differences: Difference, line: LocalManifold, jacobian: Floats
) -> Floats:
    """Return h, from the terms of second order of the map: (J - lambda^2) h = -F''(e, e) / 2."""
    points = forward(line.at(np.array([-STEP, STEP])))
    sides = differences(np.broadcast_to(line.saddle, (2, len(line.saddle))), points)
    second = sides.sum(axis=0) / (STEP * STEP)
    if not np.isfinite(second).all():
        return np.zeros(len(line.saddle))
    matrix = jacobian - line.multiplier * line.multiplier * np.eye(len(line.saddle))
    return np.asarray(solve_linear(matrix, -0.5 * second))
