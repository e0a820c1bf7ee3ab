"""A manifold grown from its piece next to the saddle, image after image."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.numerics import atan2, hypot, power
from percuss.orbits.surface.local_manifold import Difference, LocalManifold, PointMap

__all__ = ["Grower", "Grown", "GrowthEnd", "grow"]

Floats = NDArray[np.float64]
GrowthEnd: TypeAlias = Literal["length", "max_points", "no_image", "collapse", "interrupted"]

# Points of the piece next to the saddle, before it is refined.
FIRST_POINTS = 17
# Parts of that piece nearer than this have no digits between them: what lies apart is a jump.
FINEST = 1e-9
# Neighbours may turn the curve by so much [rad] if they are not closer than this part of the
# spacing already.
TURN, CLOSE = 0.15, 0.05
MOST_IMAGES = 2000
MOST_ROUNDS = 1000
# An image shorter than this part of the spacing has shrunk to a point.
COLLAPSED = 1e-6


@dataclass(frozen=True, slots=True)
class Grown:
    """A manifold as points in a row.

    Attributes
    ----------
    points
        (n, 2) array.
    piece
        (n,) array, number of the continuous piece that each belongs to, ascending from 0.
    arclength
        (n,) array, length of the pieces so far, in the units of the scale.
    image
        (n,) array, how often the map was applied to come there.
    end
        Why it ends.
    """

    points: Floats
    piece: NDArray[np.int64]
    arclength: Floats
    image: NDArray[np.int64]
    end: GrowthEnd


@dataclass(slots=True)
class Grower:
    """Takes the fundamental domain of a manifold, from s / lambda to s, through its images.

    Attributes
    ----------
    forth, apart
        The map, which moves points off the saddle without changing sides, and differences.
    local
        The manifold next to the saddle.
    way
        +1 or -1, the side of the saddle.
    scale
        (2,) array, units of length.
    spacing
        Largest distance of neighbours, in these units.
    """

    forth: PointMap
    apart: Difference
    local: LocalManifold
    way: float
    scale: Floats
    spacing: float

    def begin(self, parts: Floats) -> Floats:
        """Return the points of the fundamental domain at parts from 0 to 1 of it."""
        reach = self.way * self.local.reach
        return self.local.at(reach * power(self.local.multiplier, parts - 1.0))

    def refined(
        self, parts: Floats, points: Floats, image: int, longest: float, room: int
    ) -> tuple[Floats, Floats, bool]:
        """Return the parts and their images with new ones where neighbours lie apart.

        No more is done than for a length of ``longest`` and ``room`` points; the flag tells
        whether that was enough.
        """
        for _ in range(MOST_ROUNDS):
            gaps = np.diff(parts)
            # Chords are no longer than their arcs, jumps have no length.
            chords = np.where(gaps > FINEST, np.nan_to_num(self.sizes(points)), 0.0)
            before = np.cumsum(chords) - chords
            wide = self._wide(points)
            wide &= (gaps > FINEST) & (before < longest)
            count = int(wide.sum())
            if count == 0:
                return parts, points, len(parts) <= room
            if len(parts) + count > room:
                break
            new = (parts[:-1] + 0.5 * gaps)[wide]
            made = self.begin(new)
            for _ in range(image):
                made = self.forth(made)
            order = np.argsort(np.concatenate([parts, new]), kind="stable")
            parts = np.concatenate([parts, new])[order]
            points = np.concatenate([points, made])[order]
        return parts, points, False

    def sizes(self, points: Floats) -> Floats:
        """Return the (n - 1,) distances of neighbours, in units of the scale."""
        steps = self.steps(points)
        return np.asarray(hypot(steps[:, 0], steps[:, 1]))

    def steps(self, points: Floats) -> Floats:
        """Return the (n - 1, 2) differences of neighbours, in units of the scale."""
        return np.asarray(self.apart(points[:-1], points[1:]) / self.scale)

    def _wide(self, points: Floats) -> NDArray[np.bool_]:
        """Tell between which neighbours another point is wanted."""
        steps, sizes = self.steps(points), self.sizes(points)
        known = np.isfinite(points[:, 0])
        wide: NDArray[np.bool_] = np.logical_or(sizes > self.spacing, known[1:] != known[:-1])
        cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
        along = (steps[:-1] * steps[1:]).sum(axis=1)
        sharp = np.abs(atan2(cross, along)) > TURN
        large = sizes > CLOSE * self.spacing
        wide[:-1] |= sharp & large[:-1]
        wide[1:] |= sharp & large[1:]
        return wide


def grow(grower: Grower, length: float, max_points: int, go_on: Callable[[float], bool]) -> Grown:
    """Grow one branch of a manifold from its saddle on.

    Its points are images of points of a fundamental domain: none is interpolated. Where images
    of neighbours lie apart, or turn too sharply, the domain is divided between them, and the new
    point taken through all images. What lies apart in the end is cut.

    Parameters
    ----------
    grower
        The map and the manifold next to the saddle.
    length
        Length of the branch, in the units of the scale.
    max_points
        Points after which no more are made.
    go_on
        Told what part of the length is done; False stops.

    Returns
    -------
    Grown
        The branch.
    """
    local = grower.local
    n_inner = min(2 + int(local.reach / grower.spacing), max_points)
    inner = np.linspace(0.0, local.reach / local.multiplier, n_inner)
    blocks = [local.at(grower.way * inner)]
    parts = np.linspace(0.0, 1.0, FIRST_POINTS)
    now = grower.begin(parts)
    done, count = float(inner[-1]), len(inner)
    end: GrowthEnd = "no_image"
    for image in range(MOST_IMAGES):
        now = now if image == 0 else grower.forth(now)
        parts, now, enough = grower.refined(parts, now, image, length - done, max_points - count)
        sizes = grower.sizes(now)
        travelled = done + np.cumsum(np.where(sizes <= grower.spacing, sizes, 0.0))
        # What lies beyond the length, or beyond what there was room for, is not refined.
        last = int(np.searchsorted(travelled, length))
        if not enough:
            coarse = (sizes > grower.spacing) & (np.diff(parts) > FINEST)
            last = min(last, int(np.argmax(coarse)) if coarse.any() else len(coarse))
            last = min(last, max_points - count)
        blocks.append(now[1 : last + 2 if enough else last + 1])
        count += len(blocks[-1])
        added, done = float(travelled[-1]) - done, float(travelled[-1])
        if done >= length:
            end = "length"
        elif not enough:
            end = "max_points"
        elif np.isnan(now).any(axis=1).all():
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
    grower: Grower, points: Floats, image: NDArray[np.int64], length: float, end: GrowthEnd
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
