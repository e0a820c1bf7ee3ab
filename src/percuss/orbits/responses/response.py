"""The response chart: all families of periodic orbits that are found along one parameter."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import Phase, as_float, two_of, whole
from percuss.model.faults import check_mapping
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import On, Oscillator
from percuss.model.paths import long_form
from percuss.model.periods import require_period
from percuss.model.structure import Structure
from percuss.model.system import System
from percuss.motion.tables import HasTable
from percuss.orbits.bifurcations.structure_branch import AnyBranch
from percuss.orbits.orbit.table_units import with_units
from percuss.orbits.responses.families import Families, Range, SeenAttractor
from percuss.orbits.responses.oscillator_families import OscillatorFamilies
from percuss.orbits.responses.response_search import search_families
from percuss.orbits.responses.structure_families import StructureFamilies
from percuss.pictures import HasPicture
from percuss.progress import Report

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

Interval = tuple[float, float]

# The end reason of a closed branch.
CLOSED = "the branch closed"


@dataclass(frozen=True, slots=True)
class FamilyRange:
    """The orbits of one kind in a chart.

    Attributes
    ----------
    n_impacts, n_periods
        Impacts and forcing periods of an orbit.
    branches
        Numbers of the branches.
    ranges
        Intervals of the parameter with admissible orbits.
    stable_ranges
        Intervals with stable admissible orbits.
    """

    n_impacts: int
    n_periods: int
    branches: tuple[int, ...]
    ranges: tuple[Interval, ...]
    stable_ranges: tuple[Interval, ...]


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Response(HasPicture, HasTable):
    """All families of periodic orbits found along one parameter, made by `response_curve`.

    Attributes
    ----------
    path
        Path of the parameter.
    low, high
        Its range.
    max_impacts, max_periods
        The longest orbits that were looked for.
    branches
        The families, stable and unstable, each a `Branch` or a `StructureBranch`; those with fewer
        periods and impacts first. At soft stops impacts come and go along a branch.
    amplitude
        A (n,) array for each branch: half the distance between the least and the largest
        displacement of each orbit [length], exact extremes.
    largest_displacement
        A (n,) array for each branch: the largest abs(x) [length].
    impact_velocity
        A (n,) array for each branch: the largest velocity into a stop [length/time]; NaN without
        impacts.
    attractors
        The attractors of direct simulation at other values of the parameter, and their branches.
    left_out
        Orbits that were found and not followed: value, orbit and reason.
    complete
        False if the search was stopped.
    on
        Of a structure the coordinate, direction or point whose y = c . x the displacements are.
    """

    picture: ClassVar = "plot_response"

    path: str
    low: float
    high: float
    max_impacts: int
    max_periods: int
    branches: tuple[Any, ...]
    amplitude: tuple[Floats, ...]
    largest_displacement: tuple[Floats, ...]
    impact_velocity: tuple[Floats, ...]
    attractors: tuple[SeenAttractor, ...]
    left_out: tuple[tuple[float, Any, str], ...] = field(repr=False)
    complete: bool
    on: On | None = None

    @property
    def missed(self) -> tuple[SeenAttractor, ...]:
        """Periodic attractors of the kinds looked for that are on no branch."""
        return tuple(
            attractor
            for attractor in self.attractors
            if attractor.branch is None
            and attractor.n_impacts <= self.max_impacts
            and 1 <= attractor.n_periods <= self.max_periods
        )

    @property
    def special_points(self) -> tuple[Any, ...]:
        """The special points of admissible orbits, branch after branch."""
        return tuple(
            point
            for branch in self.branches
            for point in branch.special_points
            if branch.admissible[max(point.row - 1, 0) : point.row + 2].any()
        )

    @property
    def families(self) -> tuple[FamilyRange, ...]:
        """The kinds of orbits, with the ranges in which they exist and are stable."""
        kinds: dict[tuple[int, int], list[tuple[int, Flags]]] = {}
        for number, branch in enumerate(self.branches):
            each = kinds_of(branch)
            for kind in np.unique(each, axis=0).tolist():
                of_kind = (each == kind).all(axis=1)
                kinds.setdefault((kind[0], kind[1]), []).append((number, of_kind))
        families = []
        for n_periods, n_impacts in sorted(kinds):
            members = kinds[n_periods, n_impacts]
            physical = [
                (self.branches[k], rows & self.branches[k].admissible) for k, rows in members
            ]
            stable = _union([i for b, rows in physical for i in _runs(b, rows & b.is_stable)])
            ranges = _union([i for b, rows in physical for i in _runs(b, rows)])
            numbers = tuple(number for number, _ in members)
            families.append(FamilyRange(n_impacts, n_periods, numbers, ranges, stable))
        return tuple(families)

    def __repr__(self) -> str:
        """Return the chart in a line."""
        kinds = ", ".join(f"({kind.n_impacts}, {kind.n_periods})" for kind in self.families)
        missed = f"{len(self.missed)} missed" if self.missed else "none missed"
        stopped = "" if self.complete else "; stopped before its end"
        return (
            f"<Response: {len(self.branches)} branches over {self.path} from {self.low:.6g} to "
            f"{self.high:.6g}, (impacts, periods) {kinds}; {len(self.attractors)} attractors "
            f"compared, {missed}{stopped}>"
        )

    def to_xarray(self) -> Dataset:
        """Return the chart as one table, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            All rows of all branches along ``point``, with ``branch``; the attractors along
            ``attractor``; the special points along ``special_point``.
        """
        import xarray

        quantities = {
            "amplitude": self.amplitude,
            "largest_displacement": self.largest_displacement,
            "impact_velocity": self.impact_velocity,
        }
        columns = rows_of(self.path, self.branches, quantities)
        columns |= special_rows_of(self.branches) | attractor_rows_of(self.attractors)
        table = xarray.Dataset(columns, attrs={"path": self.path, "complete": int(self.complete)})
        if not self.branches:
            return table
        return with_units(table, self.branches[0].orbits[0], self.path)


def response_curve(
    osc: Oscillator | Structure,
    force: Forcing | Loads | Mapping[On, Forcing],
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    on: On | None = None,
    max_impacts: int = 4,
    max_periods: int = 3,
    seed: int = 0,
    n_seeds: int = 16,
    progress: Report = None,
) -> Response:
    """Find and follow all families of periodic orbits along one parameter, stable or not.

    At values spread over the range motions are followed from many starts to their attractors,
    and orbits, unstable ones too, are searched for from stretches of motions that almost close
    (`find_orbits`). Orbits that lie on no branch yet are followed both ways (`continue_orbit`), and
    so are the orbits that start at period doublings. Then attractors at other values, and near
    special points, are compared with the branches. Those that lie on none are followed, too, and
    others are compared, until nothing new is found, four times at most: `missed` holds those that
    were new in the last comparison. Unstable families without a connection to stable ones can be
    missed without notice.

    Of a structure the search is the same: unstable orbits are searched for by Newton's method from
    states that almost return, and all branches are followed over the whole range, through folds,
    doublings, torus points and the grazes of soft stops (`continue_orbit`).

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period all over the range. Or a structure and its loads.
    over
        One parameter by its path, and its range.
    on
        Of a structure the coordinate, direction or point whose displacement y = c . x is measured;
        needed where there are several coordinates. Impact velocities are those of all stops.
    max_impacts, max_periods
        The longest orbits to look for, >= 1.
    seed
        Of the random starts: the same seed, the same chart.
    n_seeds
        At how many values orbits are searched for; attractors at eight times as many.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each value, and once a second while orbits are
        searched for or followed; False ends the search with what is done.

    Returns
    -------
    Response
        Branches with their quantities, and what they were compared with.

    Raises
    ------
    ParameterError
        If there is no such parameter, or a number or the range does not fit.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=0.2, side="above", damping=0.05)
    >>> chart = response_curve(osc, pc.cosine(1.0), over={"forcing.omega": (1.0, 1.5)},
    ...                        max_impacts=1, max_periods=1, n_seeds=2)
    >>> for low, high in chart.families[-1].stable_ranges:
    ...     print(f"{low:.6f} to {high:.6f}")
    1.000000 to 1.064834
    1.130040 to 1.500000

    Of two masses, of which one meets a stiff stop, the amplitude of the first:

    >>> stop = pc.SoftStop(at=1, side="above", stiffness=100, on=0)
    >>> chain = pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [stop])
    >>> chart = response_curve(chain, pc.Loads({1: pc.cosine(1, "0.1")}), on=0, n_seeds=1,
    ...                        over={"loads.0.omega": ("0.74", "0.76")}, max_periods=1)
    >>> [point.kind for branch in chart.branches for point in branch.special_points]
    ['period_doubling', 'fold']
    """
    families = _checked(osc, force, over, on)
    seed, n_seeds = whole("seed", seed, 0, math.inf), whole("n_seeds", n_seeds, 1)
    counts = whole("max_impacts", max_impacts, 1), whole("max_periods", max_periods, 1)
    attractors, complete = search_families(families, counts, seed, n_seeds, progress)
    return _response(families, counts, attractors, complete=complete, on=on)


def _checked(
    osc: Oscillator | Structure, force: object, over: Mapping[str, tuple[Phase, Phase]],
    on: On | None,
) -> Families:  # fmt: skip
    """Return the families of what moves, none of them found yet."""
    if force is None:
        raise ParameterError("force", force, "not a Forcing; a response is one to a forcing")
    check_mapping("over", over, "one parameter and its range", 1)
    ((given, ends),) = over.items()
    within = _range_of(given, ends)
    families: Families
    if isinstance(osc, Structure):
        loads = loads_of(osc, force)
        osc.direction(on)
        path = long_form(given, osc, loads)
        base = StructureSystem.of(osc, loads)
        families = StructureFamilies(path=path, within=within, base=base, on=on)
    else:
        system = System.of(osc, force)
        if on is not None:
            raise ParameterError("on", on, "given for an oscillator, which has one displacement")
        long_form(given, osc, system.forcing)
        families = OscillatorFamilies(path=given, within=within, base=system)
    for end in (within.low, within.high):
        require_period(families.force(end), "a periodic orbit needs a periodic forcing")
    return families


def _range_of(path: str, given: tuple[Phase, Phase]) -> Range:
    low, high = sorted(two_of(as_float, path, given, "not a range of two numbers"))
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(path, given, "not a range of two different finite numbers")
    return Range(low, high)


def _response(
    families: Families,
    counts: tuple[int, int],
    attractors: list[SeenAttractor],
    *,
    complete: bool,
    on: On | None,
) -> Response:
    order = sorted(range(len(families.branches)), key=lambda k: _rank(families.branches[k]))
    branches = tuple(families.branches[k] for k in order)
    numbers = {old: new for new, old in enumerate(order)}
    extremes = [[families.extremes(orbit) for orbit in branch.orbits] for branch in branches]
    return Response(
        path=families.path,
        low=families.within.low,
        high=families.within.high,
        max_impacts=counts[0],
        max_periods=counts[1],
        branches=branches,
        amplitude=tuple(np.array([row.amplitude for row in rows]) for rows in extremes),
        largest_displacement=tuple(np.array([row.largest for row in rows]) for rows in extremes),
        impact_velocity=tuple(families.impact_velocities(branch) for branch in branches),
        attractors=tuple(attractor.on(numbers) for attractor in attractors),
        left_out=tuple(families.left_out),
        complete=complete,
        on=on,
    )


def _rank(branch: AnyBranch) -> tuple[int, float, float]:
    n_periods, n_impacts = kinds_of(branch).max(axis=0).tolist()
    return n_periods, n_impacts, float(branch.values.min())


def _runs(branch: AnyBranch, flags: Flags) -> list[Interval]:
    """Return the intervals that stretches of flagged neighbours cover, special points at the ends.

    A special point lies on an edge: the flag of its own row is rounding.
    """
    special = np.zeros(len(flags), dtype=np.bool_)
    special[[point.row for point in branch.special_points]] = True
    sure = np.concatenate([[False], flags & ~special, [False]])
    flags = np.where(special, sure[:-2] | sure[2:], flags)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    parts = [branch.values[i:j] for i, j in zip(edges[::2], edges[1::2], strict=True)]
    if branch.end_reason == CLOSED and flags[0] and flags[-1]:
        # The last row is next to the first one.
        parts.append(branch.values[[-1, 0]])
    return [(float(part.min()), float(part.max())) for part in parts]


def _union(intervals: list[Interval]) -> tuple[Interval, ...]:
    joined: list[Interval] = []
    for low, high in sorted(intervals):
        if joined and low <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(high, joined[-1][1])
        else:
            joined.append((low, high))
    return tuple(joined)


def kinds_of(branch: AnyBranch) -> Integers:
    """Return (forcing periods, impacts) of each row: at soft stops impacts come and go."""
    return np.array([(orbit.n_periods, orbit.n_impacts) for orbit in branch.orbits], dtype=np.int64)


def rows_of(
    path: str, branches: Sequence[AnyBranch], quantities: Mapping[str, Sequence[Floats]]
) -> dict[str, Any]:
    """Return the columns of all rows of all branches."""
    counts = [len(branch) for branch in branches]

    def joined(parts: Iterable[NDArray[Any]], kind: type) -> NDArray[Any]:
        return np.concatenate([np.empty(0, dtype=kind), *parts])

    each = {
        "branch": joined((np.full(n, k) for k, n in enumerate(counts)), int),
        "n_impacts": joined((kinds_of(b)[:, 1] for b in branches), int),
        "n_periods": joined((kinds_of(b)[:, 0] for b in branches), int),
        "value": joined((b.values for b in branches), float),
        **{name: joined(columns, float) for name, columns in quantities.items()},
        "stability": joined((b.stability.astype(str) for b in branches), str),
        "admissible": joined((b.admissible for b in branches), bool),
    }
    table: dict[str, Any] = {name: ("point", column) for name, column in each.items()}
    table["value"] = ("point", each["value"], {"long_name": path})
    return table


def special_rows_of(branches: Sequence[AnyBranch]) -> dict[str, Any]:
    """Return the columns of the special points."""
    points = [(k, point) for k, b in enumerate(branches) for point in b.special_points]
    return {
        "special_branch": ("special_point", np.array([k for k, _ in points], dtype=int)),
        "special_kind": ("special_point", np.array([p.kind for _, p in points], dtype=str)),
        "special_value": ("special_point", np.array([p.value for _, p in points], dtype=float)),
        "special_row": ("special_point", np.array([p.row for _, p in points], dtype=int)),
    }


def attractor_rows_of(seen: Sequence[SeenAttractor]) -> dict[str, Any]:
    """Return the columns of the attractors."""

    def column(values: Iterable[Any], kind: type) -> tuple[str, NDArray[Any]]:
        return "attractor", np.array(list(values), dtype=kind)

    numbers = column(
        (-1 if attractor.branch is None else attractor.branch for attractor in seen), int
    )
    return {
        "attractor_value": column((attractor.value for attractor in seen), float),
        "attractor_n_impacts": column((attractor.n_impacts for attractor in seen), float),
        "attractor_n_periods": column((attractor.n_periods for attractor in seen), int),
        "attractor_branch": (*numbers, {"none": -1}),
        "attractor_amplitude": column((attractor.extremes.amplitude for attractor in seen), float),
        "attractor_impact_velocity": column((attractor.impact_speed for attractor in seen), float),
    }
