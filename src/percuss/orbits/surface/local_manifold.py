"""A manifold next to its saddle: a parabola, as long as it is good."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.numerics import hypot, solve_linear

__all__ = ["TOLERANCE", "LocalManifold", "local_manifold"]

Floats = NDArray[np.float64]
# Takes (n, 2) points to (n, 2) points, NaN where there is no image.
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
        (2,) arrays: the fixed point, e and h.
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
        """Return (n, 2) points."""
        column = s[:, None]
        return np.asarray(self.saddle + column * (self.direction + column * self.bend))


def local_manifold(
    forth: PointMap,
    apart: Difference,
    saddle: Floats,
    jacobian: Floats,
    direction: Floats,
    multiplier: float,
    scale: Floats,
) -> LocalManifold:
    """Return the manifold next to a saddle, to second order where that is better.

    Parameters
    ----------
    forth, apart
        The map, under which points on the manifold move off the saddle, and differences.
    saddle
        (2,) array, its fixed point.
    jacobian
        (2, 2) array, its derivative there.
    direction, multiplier
        Eigenvector, of length 1 in the units of the scale, and eigenvalue.
    scale
        (2,) array, units of length.

    Returns
    -------
    LocalManifold
        With a defect above `TOLERANCE` where the map is not smooth next to the saddle.
    """
    bend = _bend(forth, apart, saddle, jacobian, direction, multiplier, STEP)
    reach = LONGEST
    while reach >= SHORTEST:
        tried = [
            _with_defect(
                forth, apart, LocalManifold(saddle, direction, h, multiplier, reach, 0.0), scale
            )
            for h in (np.zeros(2), bend)
        ]
        found = min(tried, key=lambda local: local.defect)
        if found.defect <= TOLERANCE:
            break
        reach *= 0.5
    return found


def _with_defect(
    forth: PointMap, apart: Difference, local: LocalManifold, scale: Floats
) -> LocalManifold:
    s = local.reach * np.array([1.0, 0.7, 0.3, -1.0, -0.7, -0.3])
    missed = apart(forth(local.at(s / local.multiplier)), local.at(s)) / scale
    # Without an image it misses by any length.
    defect = np.nan_to_num(hypot(missed[:, 0], missed[:, 1]), nan=np.inf).max()
    return replace(local, defect=float(defect))


def _bend(
    forth: PointMap,
    apart: Difference,
    saddle: Floats,
    jacobian: Floats,
    direction: Floats,
    multiplier: float,
    step: float,
) -> Floats:
    """Return h, from the terms of second order of the map: (J - lambda^2) h = -F''(e, e) / 2."""
    points = forth(saddle + step * np.array([[-1.0], [1.0]]) * direction)
    sides = apart(np.broadcast_to(saddle, (2, 2)), points)
    second = sides.sum(axis=0) / (step * step)
    if not np.isfinite(second).all():
        return np.zeros(2)
    found = solve_linear(jacobian - multiplier * multiplier * np.eye(2), -0.5 * second)
    return np.asarray(found)
