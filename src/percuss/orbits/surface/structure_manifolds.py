"""The unstable manifold of a structure's orbit with one unstable direction, a curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.acting_sets import StructureSystem, is_before_walls
from percuss.model.exact import real
from percuss.model.oscillator import On
from percuss.motion.tables import HasTable
from percuss.numerics import directions, matmul, norm
from percuss.orbits.orbit.stability import ON_CIRCLE
from percuss.orbits.orbit.structure_orbit import StructureOrbit, map_between
from percuss.orbits.orbit.table_units import with_units
from percuss.orbits.surface.manifold_branch import ManifoldBranch
from percuss.orbits.surface.manifold_growth import TOLERANCE, Grower, grow, local_manifold
from percuss.pictures import HasPicture
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    from xarray import Dataset

# Instants at which the range of an orbit is taken.
SAMPLES = 257


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureManifolds(HasPicture, HasTable):
    """The unstable manifold of an orbit of a structure; made by `manifolds`.

    Attributes
    ----------
    orbit
        The orbit.
    cycle
        The cycle of the loads at which it is taken.
    saddles
        (m, 2 n) array, x and v of the orbit there.
    directions
        (m, 2 n) array, eigenvectors of the unstable multiplier, of length 1 in units of the scale.
    multiplier
        The unstable multiplier, of one period of the orbit.
    scale
        (2 n,) array, the units in which lengths are measured: the largest range of a coordinate,
        and of a velocity, on the orbit.
    branches
        The halves of the manifold of each point.
    """

    picture: ClassVar = "plot_manifolds"

    orbit: StructureOrbit
    cycle: float
    saddles: Floats
    directions: Floats
    multiplier: float
    scale: Floats
    branches: tuple[ManifoldBranch, ...] = field(repr=False)

    def displacement(self, on: On) -> list[Floats]:
        """Return the continuous pieces as (y, y'), y = c . x, (m, 2) arrays.

        Parameters
        ----------
        on
            A coordinate, a direction or the name of a point.
        """
        c = self.orbit.structure.direction(on)
        n = len(c)
        return [
            np.stack([matmul(piece[:, :n], c), matmul(piece[:, n:], c)], axis=1)
            for branch in self.branches
            for piece in branch.pieces
        ]

    def __repr__(self) -> str:
        """Return the manifold in a line."""
        points = sum(map(len, self.branches))
        return (
            f"<StructureManifolds: at cycle {self.cycle:g}, {len(self.saddles)} saddle points; "
            f"{points} points unstable>"
        )

    def to_xarray(self) -> Dataset:
        """Return all points as one dataset along ``point``, with x and v over ``coordinate``."""
        import xarray

        n = self.saddles.shape[1] // 2
        points = np.concatenate([branch.points for branch in self.branches])
        columns = {
            "x": (("point", "coordinate"), points[:, :n]),
            "v": (("point", "coordinate"), points[:, n:]),
        }
        sizes = [len(branch) for branch in self.branches]
        of_points = {
            "piece": np.concatenate([branch.piece for branch in self.branches]),
            "arclength": np.concatenate([branch.arclength for branch in self.branches]),
            "number": np.repeat(np.arange(len(sizes)), sizes),
        }
        of_branches = {
            name: np.array([getattr(branch, name) for branch in self.branches])
            for name in ("saddle", "side", "end_reason")
        }
        table = xarray.Dataset(
            {
                **columns,
                **{name: ("point", values) for name, values in of_points.items()},
                **{name: ("branch", values) for name, values in of_branches.items()},
            },
            attrs={"cycle": self.cycle},
        )
        return with_units(table, self.orbit)


def structure_manifolds(
    orbit: StructureOrbit,
    cycle: float,
    length: float,
    spacing: float,
    max_points: int,
    kinds: Sequence[str],
    progress: Report,
) -> StructureManifolds:
    """Grow the unstable manifold of an orbit of a structure; the arguments are those of `manifolds`.

    Raises
    ------
    ParameterError
        If it is no curve, or a number is out of its range.
    ConvergenceError
        If the map is not smooth next to the orbit.
    """
    _check(orbit, kinds)
    cycle, length, spacing = (
        real(name, value)
        for name, value in (("cycle", cycle), ("length", length), ("spacing", spacing))
    )
    for name, value in (("length", length), ("spacing", spacing)):
        if not value > 0.0:
            raise ParameterError(name, value, "not a finite positive number")
    strobe = _Strobe(orbit, cycle % 1.0)
    saddles = strobe.points_of_orbit()
    multiplier = float(orbit.multipliers[0].real)
    reported = Progress(progress, 2 * len(saddles))
    branches: list[ManifoldBranch] = []
    vectors = []

    def part_done(part: float) -> bool:
        return reported.reach(len(branches) + min(part, 1.0))

    for i, saddle in enumerate(saddles):
        jacobian = strobe.derivative(saddle)
        # In units of the scale, in which it has the length 1.
        scaled = jacobian * (strobe.scale[None, :] / strobe.scale[:, None])
        vector = directions(scaled - multiplier * np.eye(len(scaled)))[1][-1]
        vectors.append(strobe.scale * (vector / norm(vector)))
        # Points change sides with each period of the orbit where it is negative: two keep them.
        twice = multiplier < 0.0
        steps = orbit.n_periods * (2 if twice else 1)

        def forward(points: Floats, steps: int = steps) -> Floats:
            return strobe.images(points, steps)

        local = local_manifold(
            forward, _differences, saddle, matmul(jacobian, jacobian) if twice else jacobian,
            vectors[-1], multiplier * multiplier if twice else multiplier, strobe.scale,
        )  # fmt: skip
        if not local.defect <= TOLERANCE:
            raise ConvergenceError(
                "the unstable manifold has no smooth beginning at its saddle",
                saddle,
                local.defect,
                "the orbit nearly grazes, or is not found well enough; try another cycle",
            )
        for side in (1, -1):
            if reported.is_stopped:
                break
            grower = Grower(forward, _differences, local, float(side), strobe.scale, spacing)
            grown = grow(grower, length, max_points, part_done)
            branches.append(
                ManifoldBranch(
                    "unstable", i, side, grown.points, grown.piece, grown.arclength, grown.end
                )
            )
            reported.reach(len(branches))
    reported.close()
    return StructureManifolds(
        orbit, cycle % 1.0, saddles, np.array(vectors), multiplier, strobe.scale, tuple(branches)
    )


def _check(orbit: StructureOrbit, kinds: Sequence[str]) -> None:
    sizes = np.abs(orbit.multipliers)
    n_unstable = int((sizes > 1.0 + ON_CIRCLE).sum())
    n_neutral = int((np.abs(sizes - 1.0) <= ON_CIRCLE).sum())
    if "unstable" not in kinds:
        reason = f"of a structure a surface of {len(sizes) - n_unstable} dimensions, not a curve"
        raise ParameterError("kinds", kinds, reason)
    if n_unstable != 1 or n_neutral:
        reason = (
            f"{n_unstable} multipliers outside the unit circle and {n_neutral} on it: only with "
            "exactly one outside, and none on it, the unstable manifold is a curve"
        )
        raise ParameterError("orbit", orbit, reason)
    if not orbit.admissible:
        raise ParameterError("orbit", orbit, "formal: no motion follows it")


class _Strobe:
    """The map of a structure from a cycle of its loads to the same a period later."""

    def __init__(self, orbit: StructureOrbit, cycle: float) -> None:
        self.orbit = orbit
        self.system = StructureSystem.of(orbit.structure, orbit.loads)
        self.period = orbit.period / orbit.n_periods
        self.begin = cycle * self.period
        x, v = orbit.run(np.linspace(0.0, orbit.run.t_end, SAMPLES))
        ranges = (float(np.ptp(part, axis=0).max()) or 1.0 for part in (x, v))
        self.scale = np.repeat(list(ranges), orbit.structure.n)

    def points_of_orbit(self) -> Floats:
        """Return x and v of the orbit at the cycle, (n_periods, 2 n)."""
        times = self.begin + self.period * np.arange(self.orbit.n_periods)
        return np.concatenate(self.orbit.run(times), axis=1)

    def derivative(self, state: Floats) -> Floats:
        """Return the derivative of the map over the orbit's period at one of its points."""
        end = self.begin + self.orbit.period
        return map_between(self.system, state, (self.begin, end), "a period").derivative

    def images(self, points: Floats, periods: int) -> Floats:
        """Return the images of points (k, 2 n) after so many periods, NaN without one."""
        end = self.begin + periods * self.period
        images = np.full(points.shape, np.nan)
        for k, state in enumerate(points):
            if not (np.isfinite(state).all() and is_before_walls(self.orbit.structure, state)):
                continue
            try:
                span = self.begin, end
                mapped = map_between(self.system, state, span, "a period", derivative=False)
            except PercussError:
                # It does not last, as where hops accumulate at two walls at once.
                continue
            images[k] = mapped.image
        return images


def _differences(one: Floats, other: Floats) -> Floats:
    return np.asarray(other - one)
