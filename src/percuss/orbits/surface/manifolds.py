"""Stable and unstable manifolds of saddle orbits."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.exact import real, whole
from percuss.model.faults import as_tuple
from percuss.motion.tables import HasTable
from percuss.numerics import inverse, matmul
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.orbits.orbit.table_units import with_units
from percuss.orbits.surface.manifold_branch import ManifoldBranch, ManifoldKind
from percuss.orbits.surface.manifold_growth import (
    TOLERANCE,
    Grower,
    Grown,
    LocalManifold,
    PointMap,
    grow,
    local_manifold,
)
from percuss.orbits.surface.maps import impact_map, stroboscopic_map
from percuss.orbits.surface.saddles import (
    SAMPLES,
    ImpactSection,
    SaddlePoints,
    Section,
    SectionKind,
    StroboscopicSection,
    check_saddle,
    points_at_impacts,
    points_at_strobes,
)
from percuss.orbits.surface.structure_manifolds import StructureManifolds, structure_manifolds
from percuss.pictures import HasPicture
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

# Lengths of a branch beyond which motions are not followed back in time.
FAR = 10.0


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Manifolds(HasPicture, HasTable):
    """Stable and unstable manifolds of a saddle orbit; made by `manifolds`.

    Attributes
    ----------
    orbit
        The orbit.
    section
        "stroboscopic": the plane (x, v) at one cycle; "impact": the surface (cycle, v_after).
    cycle
        Cycle of a stroboscopic section, else NaN.
    stop
        Stop of an impact surface, else -1.
    saddles
        (m, 2) array, the points of the orbit in the section.
    unstable_directions, stable_directions
        (m, 2) arrays, eigenvectors there, of length 1 in units of the scale.
    multipliers
        (2,) array, of one period of the orbit: unstable and stable.
    scale
        (2,) array, the units in which lengths are measured.
    branches
        The halves of the manifolds.
    """

    picture: ClassVar = "plot_manifolds"

    orbit: PeriodicOrbit
    section: SectionKind
    cycle: float
    stop: int
    saddles: Floats
    unstable_directions: Floats
    stable_directions: Floats
    multipliers: Floats
    scale: Floats
    branches: tuple[ManifoldBranch, ...] = field(repr=False)

    @property
    def stable(self) -> tuple[ManifoldBranch, ...]:
        """The branches on which motions approach the orbit."""
        return tuple(branch for branch in self.branches if branch.kind == "stable")

    @property
    def unstable(self) -> tuple[ManifoldBranch, ...]:
        """The branches on which motions leave the orbit."""
        return tuple(branch for branch in self.branches if branch.kind == "unstable")

    def __repr__(self) -> str:
        """Return the manifolds in a line."""
        count = [sum(map(len, half)) for half in (self.stable, self.unstable)]
        where = f"at cycle {self.cycle:g}" if self.stop < 0 else f"of stop {self.stop}"
        return (
            f"<Manifolds: {self.section} section {where}, {len(self.saddles)} saddle points; "
            f"{count[0]} points stable, {count[1]} unstable>"
        )

    def to_xarray(self) -> Dataset:
        """Return all points as one dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``, with the numbers of branch and piece; quantities of whole branches
            along ``branch``.
        """
        import xarray

        names = ("x", "v") if self.section == "stroboscopic" else ("cycle", "v_after")
        points = np.concatenate([branch.points for branch in self.branches] or [np.empty((0, 2))])
        sizes = [len(branch) for branch in self.branches]
        of_points = {
            name: np.concatenate([getattr(b, name) for b in self.branches] or [np.empty(0)])
            for name in ("piece", "arclength")
        }
        whole: dict[str, tuple[str, object]] = {
            name: ("branch", np.array([getattr(b, name) for b in self.branches], dtype=kind))
            for name, kind in (("kind", str), ("saddle", int), ("side", int), ("end_reason", str))
        }
        columns = {name: ("point", points[:, i]) for i, name in enumerate(names)}
        columns |= {name: ("point", values) for name, values in of_points.items()}
        columns["number"] = ("point", np.repeat(np.arange(len(sizes)), sizes))
        attrs = {"section": self.section, "cycle": self.cycle, "stop": self.stop}
        return with_units(xarray.Dataset({**columns, **whole}, attrs=attrs), self.orbit)


@overload
def manifolds(
    orbit: PeriodicOrbit,
    *,
    section: SectionKind = "stroboscopic",
    cycle: float = 0.0,
    stop: int | None = None,
    length: float = 10.0,
    spacing: float = 0.01,
    max_points: int = 20_000,
    kinds: tuple[ManifoldKind, ...] = ("stable", "unstable"),
    progress: Report = None,
) -> Manifolds: ...
@overload
def manifolds(
    orbit: StructureOrbit,
    *,
    cycle: float = 0.0,
    length: float = 10.0,
    spacing: float = 0.01,
    max_points: int = 20_000,
    kinds: tuple[ManifoldKind, ...] = ("stable", "unstable"),
    progress: Report = None,
) -> StructureManifolds: ...
def manifolds(
    orbit: Any,
    *,
    section: SectionKind = "stroboscopic",
    cycle: float = 0.0,
    stop: int | None = None,
    length: float = 10.0,
    spacing: float = 0.01,
    max_points: int = 20_000,
    kinds: tuple[ManifoldKind, ...] = ("stable", "unstable"),
    progress: Report = None,
) -> Any:
    """Grow the stable and the unstable manifold of a saddle orbit in a section.

    Each point is an exact image, under the map or its inverse, of a point of the manifold next
    to the saddle, which is known to second order; none is interpolated. The stable one is grown
    by following motions back in time: off a wall with its velocity divided by -restitution.
    Where a map jumps the manifold is cut.

    Of a structure's orbit with exactly one multiplier outside the unit circle the unstable manifold
    is a curve in the space of all coordinates and velocities, at one cycle of the loads; the stable
    one is of one dimension less than that space, and is not grown.

    Parameters
    ----------
    orbit
        A saddle: one multiplier outside and one inside the unit circle, neither 0; of a structure
        one outside, and none on it.
    section
        "stroboscopic": (x, v) at one cycle; "impact": (cycle, v_after) at a stop.
    cycle
        Cycle of the stroboscopic section.
    stop
        Stop of the impact surface; default: that of the orbit's first impact.
    length
        Length of each branch, > 0. Units of length are the ranges of x and v on the orbit, or 1
        without any range, of a structure the largest of all coordinates and of all velocities; in
        the impact surface a cycle and the largest impact velocity.
    spacing
        Largest distance of neighbouring points in these units, > 0.
    max_points
        Points of a branch after which no more are made, >= 2.
    kinds
        Which to grow; of a structure "unstable" is among them.
    progress
        True shows a line on the error stream; a function ``(done, total) -> bool`` is called with
        the number of branches, and stops by returning False: those grown so far are returned.

    Returns
    -------
    Manifolds, StructureManifolds
        Two branches of each kind for each point of the orbit in the section.

    Raises
    ------
    ParameterError
        If the orbit is no saddle, or not physical; if the stable manifold is wanted and a
        restitution of 0 leaves no way back; if the section does not fit; if a number is out of
        its range.
    ConvergenceError
        If the map is not smooth next to the orbit.

    Notes
    -----
    Fundamental domains and point spacing: Hobson (1993), J. Comput. Phys. 104, 14; Krauskopf &
    Osinga (1998), J. Comput. Phys. 146, 404.

    Examples
    --------
    Between no stops the manifolds of an inverted pendulum are straight lines, whose slopes are
    the characteristic roots:

    >>> import percuss as pc
    >>> osc = pc.Oscillator(stiffness=-1.0, damping=0.1)
    >>> orbit = pc.find_orbit(osc, pc.cosine(2.0), n_impacts=0)
    >>> grown = pc.manifolds(orbit, length=2.0)
    >>> x, v = (grown.unstable[0].points - grown.saddles[0]).T
    >>> round(float(v[-1] / x[-1]), 9), round((1 + 0.1**2) ** 0.5 - 0.1, 9)
    (0.904987562, 0.904987562)

    Two masses, of which one meets a wall: between two orbits that attract lies a saddle, whose
    unstable manifold leads to both.

    >>> two = pc.chain([1, 1], [1, 1, 0], "0.1", [pc.Wall("0.5", "above", "0.7", on=1)])
    >>> orbits = pc.find_orbits(two, pc.Loads({0: pc.cosine("0.9", amplitude="0.3")}), 1, 1)
    >>> (saddle,) = (orbit for orbit in orbits if not orbit.is_stable)
    >>> grown = pc.manifolds(saddle, length=0.3, spacing=0.05)
    >>> [branch.end_reason for branch in grown.branches], grown.saddles.shape
    (['length', 'length'], (1, 4))
    """
    wanted = as_tuple(kinds)
    if not isinstance(wanted, tuple) or not all(kind in ("stable", "unstable") for kind in wanted):
        raise ParameterError("kinds", kinds, 'not some of "stable" and "unstable", such as a tuple')
    kinds = wanted
    max_points = whole("max_points", max_points, 2)
    if isinstance(orbit, StructureOrbit):
        if section != "stroboscopic" or stop is not None:
            raise ParameterError("section", section, "of a structure there is the stroboscopic one")
        return structure_manifolds(orbit, cycle, length, spacing, max_points, kinds, progress)
    check_saddle(orbit)
    cycle, length, spacing = real("cycle", cycle), real("length", length), real("spacing", spacing)
    _check(section, length, spacing)
    surface, saddles, stop = _section(orbit, section, cycle, stop, length)
    multipliers = orbit.multipliers.real.copy()
    unstable, stable = (saddles.directions(float(value)) for value in multipliers)
    eigen = {"unstable": (unstable, multipliers[0]), "stable": (stable, multipliers[1])}
    reported = Progress(progress, 2 * len(saddles.points) * len(kinds))
    branches: list[ManifoldBranch] = []

    def part_done(part: float) -> bool:
        return reported.reach(len(branches) + min(part, 1.0))

    for kind, i in product(kinds, range(len(saddles.points))):
        if not reported.is_stopped:
            vectors, value = eigen[kind]
            forward, local = _local(surface, kind, saddles, i, vectors[i], float(value))
        for side in (1, -1):
            if reported.is_stopped:
                break
            grower = Grower(
                forward, surface.differences, local, float(side), saddles.scale, spacing
            )
            grown = grow(grower, length, max_points, part_done)
            branches.append(_branch(surface, kind, i, side, grown))
            reported.reach(len(branches))
    reported.close()
    return Manifolds(
        orbit=orbit,
        section=section,
        cycle=cycle % 1.0 if section == "stroboscopic" else float("nan"),
        stop=-1 if stop is None else stop,
        saddles=saddles.points,
        unstable_directions=unstable,
        stable_directions=stable,
        multipliers=multipliers,
        scale=saddles.scale,
        branches=tuple(branches),
    )


def _section(
    orbit: PeriodicOrbit, kind: SectionKind, cycle: float, stop: int | None, length: float
) -> tuple[Section, SaddlePoints, int | None]:
    """Return the section, where the orbit meets it, and the stop of an impact surface."""
    assert orbit.forcing is not None
    if kind == "stroboscopic":
        saddles = points_at_strobes(orbit, cycle % 1.0)
        fastest = _fastest(orbit, saddles, length)
        strobe = stroboscopic_map(orbit.oscillator, orbit.forcing, cycle=cycle % 1.0)
        return StroboscopicSection(strobe, fastest), saddles, None
    if stop is None:
        stop = int(orbit.impacts.stop[0]) if len(orbit.impacts) else None
    saddles = points_at_impacts(orbit, stop)
    next_impact = impact_map(orbit.oscillator, orbit.forcing, stop or 0)
    return ImpactSection(next_impact, _fastest(orbit, saddles, length)), saddles, stop


def _check(section: SectionKind, length: float, spacing: float) -> None:
    if section not in ("stroboscopic", "impact"):
        raise ParameterError("section", section, "neither stroboscopic nor impact")
    for name, value in (("length", length), ("spacing", spacing)):
        if not value > 0.0:
            raise ParameterError(name, value, "not a finite positive number")


def _fastest(orbit: PeriodicOrbit, saddles: SaddlePoints, length: float) -> float:
    """Return a velocity far above those of a branch without jumps.

    An orbit that leaves a stop slowly is fast elsewhere.
    """
    run = orbit.trajectory()
    largest = float(np.abs(run(np.linspace(run.t0, run.t0 + orbit.period, SAMPLES))[1]).max())
    return largest + FAR * (1.0 + length) * max(largest, float(saddles.scale[1]))


def _local(
    surface: Section,
    kind: ManifoldKind,
    saddles: SaddlePoints,
    i: int,
    direction: Floats,
    multiplier: float,
) -> tuple[PointMap, LocalManifold]:
    """Return the map that stretches a manifold, and the manifold next to its saddle."""
    jacobian = saddles.jacobians[i]
    if kind == "stable":
        jacobian, multiplier = inverse(jacobian), 1.0 / multiplier
    steps = len(saddles.points)
    if multiplier < 0.0:
        # Points change sides with each period of the orbit: two periods keep them.
        steps, jacobian, multiplier = 2 * steps, matmul(jacobian, jacobian), multiplier**2
    step = surface.forward if kind == "unstable" else surface.backward

    def forward(points: Floats) -> Floats:
        for _ in range(steps):
            points = step(points)
        return points

    local = local_manifold(
        forward,
        surface.differences,
        saddles.points[i],
        jacobian,
        direction,
        multiplier,
        saddles.scale,
    )
    if not local.defect <= TOLERANCE:
        where = tuple(saddles.points[i].tolist())
        raise ConvergenceError(
            f"the {kind} manifold has no smooth beginning at its saddle {where}",
            where,
            local.defect,
            "the orbit nearly grazes, or is not found well enough; try another section",
        )
    return forward, local


def _branch(
    surface: Section, kind: ManifoldKind, i: int, side: int, grown: Grown
) -> ManifoldBranch:
    points = grown.points
    if isinstance(surface, ImpactSection):
        points = np.column_stack([points[:, 0] % 1.0, points[:, 1]])
    return ManifoldBranch(kind, i, side, points, grown.piece, grown.arclength, grown.end)
