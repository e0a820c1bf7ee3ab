"""Bifurcation diagrams: points of the attractors over a parameter."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats, Integers
from percuss.ensembles.array_parts import PartOfJob, part_dataset
from percuss.ensembles.batch import MOST_IMPACTS, Plan, reason_of
from percuss.ensembles.datasets import (
    attributes_of,
    coordinates_of,
    warn_of_failures,
    warn_of_some,
    with_units,
)
from percuss.ensembles.engines import Engine, make_ready
from percuss.ensembles.grid import Grid, make_grid
from percuss.ensembles.groups import AnyGroup
from percuss.ensembles.job import Answer, Block, Column, Dimension, check_room, too_large
from percuss.ensembles.measures import MEASURES, SECTIONS, Window, measure_group, periods_at
from percuss.ensembles.repetition import is_free
from percuss.ensembles.run_job import execution_of, keep, run_job
from percuss.ensembles.store import (
    Store,
    check_vacant,
    has_store,
    make_folder,
    own_attributes,
    store_faults,
)
from percuss.ensembles.sweep import (
    IMPACTS_OF_A_CHUNK,
    NO_STROBES,
    check_counted,
    check_structure,
    cost_of,
    named_measures,
)
from percuss.ensembles.threads import check_going_on
from percuss.errors import OutputError, ParameterError
from percuss.execution import Execution
from percuss.kernels import observables
from percuss.kernels.record import HUGE, OVERFLOW
from percuss.model.acting_sets import within_walls
from percuss.model.exact import as_float, whole
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import On, Oscillator, Wall
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.sections import PoincareSection, SectionGiven, section_of
from percuss.progress import Report

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

Direction = Literal["forward", "backward"]
# Values that a range (low, high) of the parameter stands for.
VALUES = 401
# The starts by default: at rest at 0, of a structure in all coordinates.
AT_REST = ((0.0, 0.0),)
# The status of a value without a motion, besides those of the kernels.
FAULTY = -2
# The value of an integer column where nothing has been written.
NOT_DONE = -1
# The period of a value without a motion.
NO_PERIOD = -1


def bifurcation_diagram(
    osc: Oscillator | Structure,
    force: Forcing | Loads | None = None,
    *,
    over: Mapping[str, object],
    section: SectionGiven = "stroboscopic",
    on: On | None = None,
    starts: Sequence[Start | StructureStart | Sequence[Any]] = AT_REST,
    start: Start | StructureStart | Sequence[Any] | None = None,
    follow: Sequence[Direction] = ("forward", "backward"),
    transient: int = 200,
    points: int = 64,
    measures: Sequence[str] = (),
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
    part: Sequence[int] | None = None,
) -> Dataset:
    """Return points of the attractors over a parameter.

    On a *followed* branch the motion at each value of the parameter begins where the motion at the
    value before ended, at the same cycle: the forward and the backward branch show which attractors
    coexist (hysteresis). On the other branches every value begins at one of the starts.

    Parameters
    ----------
    osc, force
        The oscillator, and a forcing with a period; or a structure, and loads with a period. Or
        none, as of limit cycles: then the section is "impacts" or a place, and time is counted as
        in `sweep`.
    over
        One path, and a range (low, high) that stands for 401 values, or the values themselves, in
        the order in which they are followed forward. A path of the start needs ``follow=()``.
    section
        "stroboscopic": (x, v) once a forcing period; "impacts": (cycle, v_after) at impacts and
        at entries into soft stops. As the views of a run take it, ``{"cycle": 0.25}`` (x, v) at
        this cycle of the forcing (`Trajectory.stroboscopic`), and
        ``{"at": 0.3, "direction": "up"}`` (cycle, v) where x passes 0.3 (`Trajectory.section`).
    on
        Of a structure the coordinate, direction or point whose y = c . x and velocity are the
        points of a stroboscopic section, or that passes a place; needed there where there are
        several coordinates. At impacts the number of a stop, whose impacts alone are kept; None
        keeps those of all.
    starts
        Starts, each a `Start` or x0, v0; of a structure each a `StructureStart` or x0, v0 with a
        number for each coordinate; default: at rest at 0. Followed branches begin at the first one;
        at values where it lies behind a wall they have no points until they have begun.
    start
        One start, in place of several.
    follow
        Any of "forward" and "backward".
    transient
        Forcing periods that are left out at each value.
    points
        Points kept at each value, >= 2: forcing periods that are followed; of impacts and passages
        the last.
    measures
        Names of measures of `sweep`, taken over the same time.
    store, engine, n_workers, progress, part
        As in `sweep`. A followed branch is one chunk.

    Returns
    -------
    xarray.Dataset
        Over (branch, path, sample): `x` [length] and `v` [length/time], or `cycle`, `v_after`
        and `bound`, the stop, or `cycle` and `v` of passages; NaN where there are fewer. Without
        a forcing there is no `cycle`. Stops are counted upwards along x, from 0 where the lowest
        is a wall below, else from 1. Over (branch, path): `period`, that of the motion in forcing
        periods, without a forcing in time (0: none up to half of those followed, -1: there is no
        motion); the measures; and `reason`, why there is no motion. The attribute `failed` counts
        the values without one.

    Warns
    -----
    UserWarning
        If a branch has no points at some or all values: with their number, the first of them, and
        the commonest reason and its count.

    Raises
    ------
    ParameterError
        If there is no such path, or an axis is empty or not finite.

    Examples
    --------
    Period doubling at omega = 2.6533 (Budd & Dux 1994, in closed form):

    >>> import percuss as pc
    >>> data = pc.bifurcation_diagram(
    ...     pc.impact_oscillator(restitution=0.8), pc.cosine(2.5),
    ...     over={"forcing.omega": [2.64, 2.67]}, starts=[(0.0, 1.0)], follow=["forward"],
    ... )
    >>> data.period.sel(branch="forward").values
    array([1, 2])
    """
    execution = execution_of(store, engine, n_workers, progress, part)
    _check_lists(starts, follow)
    is_default = tuple(starts) == AT_REST
    if start is not None and not is_default:
        raise ParameterError("start", start, "given together with starts; give one")
    kept = section_of(section)
    along, of_stop = (on, -1) if kept.kind != "impacts" else (None, _stop_of(osc, on))
    begins: Sequence[Any] = (start,) if is_default else starts
    grids = [make_grid(osc, force, begin, over, VALUES, along) for begin in begins]
    _check(grids, kept, follow, points)
    named = named_measures(measures, grids[0].axes)
    if isinstance(osc, Structure):
        check_structure(named, grids[0])
    free = is_free(grids[0].force)
    if free and kept.kind == "stroboscopic":
        raise ParameterError("section", kept.given, NO_STROBES)
    window = Window(transient, points - 1)
    asked = (kept, window, named, free, of_stop)
    followed = FollowedBranches(*asked, grids[0], tuple(follow))
    afresh = FreshBranches(*asked, tuple(grids))
    parts = {job.part: job for job in (followed, afresh) if job.size}
    _make_ready(parts, execution)
    answers: list[Answer] = []
    for name, job in parts.items():
        if any(not answer.complete for answer in answers):
            # A study that was stopped in one part does not begin the next.
            arrays = {key: column.empty(job.size) for key, column in job.columns.items()}
            answers.append(Answer(arrays, {}, 0, complete=False))
        else:
            answers.append(run_job(job, execution.of_part(name)))
    if execution.part is not None:
        return part_dataset(answers, execution.part)
    names = [*follow, *(f"start {i}" for i in range(len(grids)))]
    # Followed branches begin at the first start.
    of_branches = [*(grids[0] for _ in follow), *grids]
    data = _dataset(of_branches, names, followed, answers)
    _warn(data)
    return keep(data, execution)


def _make_ready(
    parts: Mapping[str, FollowedBranches | FreshBranches], execution: Execution
) -> None:
    """Make the stores of all parts first: their status shows the whole work from the beginning."""
    store = execution.store
    if store is not None and has_store(store):
        with store_faults(store):
            own_attributes(store)
        raise OutputError(store, "holds another study, no diagram; choose another name")
    for job in parts.values():
        # Before anything is written.
        check_room(job)
    if store is None:
        return
    is_new = not any(has_store(store / name) for name in parts)
    if is_new:
        check_vacant(store, list(parts))
    make_ready(next(iter(parts.values())), execution.engine, is_new=is_new)
    make_folder(store)
    for name, job in parts.items():
        own = job if execution.part is None else PartOfJob(job, execution.part)
        Store(store / name, own).close()


def _warn(data: Dataset) -> None:
    """Warn of branches without any points, and of values where a branch has none."""
    reasons = data["reason"].values
    empty = (reasons != "").all(axis=1)
    if not data.attrs["complete"]:
        return
    if not (reasons != "").any() and all(
        np.isnan(data[name].values).all() for name in data.data_vars if "sample" in data[name].dims
    ):
        where = str(data.attrs["section"])
        n_values = reasons.shape[1]
        warnings.warn(
            f"no motion has a point on the section {where!r} at any of {n_values:,} values",
            stacklevel=3,
        )
    branches, values = np.nonzero((reasons != "") & ~empty[:, np.newaxis])
    if len(values):
        path = str(data["reason"].dims[1])
        first = f"{path} = {data[path].values[values[0]]} of {data['branch'].values[branches[0]]}"
        warn_of_some("values", reasons[branches, values], reasons.size, first, stacklevel=4)
    if empty.any():
        names = " and ".join(str(name) for name in data["branch"].values[empty])
        what = f"{names}: no points at any of {reasons.shape[1]:,} values"
        warn_of_failures(what, reasons[empty].ravel().tolist(), stacklevel=4)


def _check_lists(starts: object, follow: object) -> None:
    """Raise a `ParameterError` unless starts and directions are lists."""
    is_list = hasattr(starts, "__iter__") and not isinstance(starts, str)
    if not is_list or not all(
        isinstance(start, Start | StructureStart) or hasattr(start, "__iter__")
        for start in starts  # type: ignore[attr-defined]  # tested above
    ):
        raise ParameterError("starts", starts, "not a list of starts, such as [(0.0, 1.0)]")
    if isinstance(follow, str) or not hasattr(follow, "__iter__"):
        raise ParameterError("follow", follow, 'not a list, such as ["forward"]')
    names = list(follow)
    if len(set(names)) < len(names):
        raise ParameterError("follow", names, "the same twice")


def _stop_of(osc: object, on: On | None) -> int:
    """Return the number of the stop whose impacts are kept, -1 for those of all."""
    if on is None:
        return -1
    n = len(osc.stops) if isinstance(osc, Structure) else 0
    if isinstance(on, bool) or not isinstance(on, int) or not 0 <= on < n:
        stops = f"the stops are 0 to {n - 1}" if n else "there is none to choose"
        raise ParameterError("on", on, f"at impacts not the number of a stop; {stops}")
    return on


def _check(grids: list[Grid], section: PoincareSection, follow: Sequence[str], points: int) -> None:
    if not grids:
        raise ParameterError("starts", (), "none at all; give (x0, v0)")
    given = [axis.path for axis in grids[0].axes]
    if len(given) != 1:
        raise ParameterError("over", given, "a diagram has one axis, a parameter")
    if grids[0].axes[0].of_start and follow:
        reason = (
            "a diagram has one axis, of the motion; followed branches have no start, give follow=()"
        )
        raise ParameterError("over", given, reason)
    for name in follow:
        if name not in ("forward", "backward"):
            raise ParameterError("follow", name, "neither forward nor backward")
    points = whole("points", points, 2)
    problem = too_large([len(grids) + len(follow), grids[0].size], 3 * points)
    if problem is not None:
        raise ParameterError("points", points, f"{points:,} at each of {problem}")
    grid = grids[0]
    check_counted(grid.force, instead="ask sweep for a measure between=")
    if isinstance(grid.osc, Structure) and section.kind != "impacts" and not grid.on:
        # The sentence that says of what the displacement may be.
        grid.osc.direction(None)


def _dataset(grids: list[Grid], names: list[str], job: Branches, answers: list[Answer]) -> Dataset:
    import xarray

    grid, section = grids[0], job.section
    n = grid.size
    parts = {
        name: np.concatenate(
            [
                a.arrays[name].reshape(-1, n, *a.arrays[name].shape[a.arrays["period"].ndim :])
                for a in answers
            ]
        )
        for name in job.of_value
    }
    path = grid.axes[0].dimension
    sampled = ("branch", path, "sample")
    if section.kind == "stroboscopic":
        data: dict[str, Any] = {
            "x": (sampled, parts["points"][..., 0], {"units": "length"}),
            "v": (sampled, parts["points"][..., 1], {"units": "length/time"}),
        }
    elif section.kind == "passages":
        data = {
            "cycle": (sampled, parts["points"][..., 0], {"units": "1"}),
            "v": (sampled, parts["points"][..., 1], {"units": "length/time"}),
        }
    else:
        data = {
            "cycle": (sampled, parts["points"][..., 0], {"units": "1"}),
            "v_after": (sampled, parts["points"][..., 1], {"units": "length/time"}),
            "bound": (sampled, parts["points"][..., 2], {"units": "1"}),
        }
    if job.is_free:
        # Time has no origin without a forcing.
        data.pop("cycle", None)
    of_period = {"units": "time" if job.is_free else "1"}
    data["period"] = (("branch", path), parts["period"], of_period)
    for name in job.measures:
        measure = MEASURES[name]
        about = {
            "units": measure.dimensions_of(grid.osc, free=job.is_free),
            "long_name": measure.meaning_for(grid.osc, free=job.is_free),
        }
        data[name] = (("branch", path), parts[name], about)
    data["reason"] = (("branch", path), _reasons(grids, parts["status"]))
    complete = all(answer.complete for answer in answers)
    total = sum(answer.n_impacts for answer in answers)
    dataset = xarray.Dataset(
        data,
        coords=coordinates_of(grid.dimensions) | {"branch": names},
        attrs=attributes_of(grid.motion(), Answer({}, {}, total, complete))
        | {"section": section.label, "failed": failed_values(parts)},
    )
    return with_units(dataset, grid.osc.units)


def _reasons(grids: list[Grid], status: NDArray[np.generic]) -> NDArray[np.object_]:
    reasons = np.full(status.shape, "", dtype=object)
    still = np.zeros(1)
    for branch, k in zip(*np.nonzero(status != 0), strict=True):
        code = int(status[branch, k])
        reason = reason_of(code, Plan(still, still, still, max_impacts=MOST_IMPACTS))
        if code == FAULTY:
            _, faults = grids[branch].groups(int(k), int(k) + 1)
            reason = faults.get(0, "the branch does not begin outside the walls")
        elif code == NOT_DONE:
            reason = "not done yet"
        reasons[branch, k] = reason or ""
    return reasons


@dataclass(frozen=True, slots=True)
class Branches:
    """The jobs of a diagram: the section and the points kept at each value of the parameter."""

    part: ClassVar[str]
    section: PoincareSection
    window: Window
    measures: tuple[str, ...]
    is_free: bool
    of_stop: int

    @property
    def of_value(self) -> dict[str, Column]:
        """The columns of one value: points of the section, the period, the status, measures."""
        return {
            "points": Column(
                (self.window.periods + 1, observables.POINT_COLUMNS), dims=("sample", "entry")
            ),
            "period": Column(dtype="f8" if self.is_free else "i8"),
            "status": Column(dtype="i8"),
            **{name: Column() for name in self.measures},
        }

    def empty(self, n: int) -> Block:
        """Return a block for n values without a motion."""
        block = Block.empty(self.of_value, n)
        block.arrays["status"][:] = FAULTY
        return block

    def settings(self) -> dict[str, object]:
        """Return what tells this diagram from others of the same grid."""
        return {
            "kind": f"diagram, {self.part}",
            "section": self.section.label,
            "transient": self.window.transient,
            "points": self.window.periods + 1,
            **({"measures": list(self.measures)} if self.measures else {}),
            **({"stop": self.of_stop} if self.of_stop >= 0 else {}),
        }

    def fill(self, block: Block, group: AnyGroup, rows: Integers) -> Floats:
        """Follow motions, fill rows of a block with their points, and return where they end."""
        period = group.periods
        since = group.starts[:, -1] + self.window.transient * period
        until = since + self.window.periods * period
        cycle = self.section.cycle
        if cycle is not None:
            # The motion ends at the cycle at which it began, after the last strobe.
            since, until = (np.ceil(since / period - cycle) + cycle) * period, until + period
        plan = Plan(
            since,
            period,
            until,
            section=SECTIONS[self.section.kind],
            n_points=self.window.periods + 1,
            max_impacts=MOST_IMPACTS,
            level=self.section.at,
            sign=self.section.sign,
            timed=self.window.longest(period) if self.is_free else None,
            of_stop=self.of_stop,
        )
        result = group.follow(plan)
        bad = np.array([reason_of(int(status), plan) is not None for status in result.status])
        points = result.points.copy()
        points[bad] = np.nan
        strobes = np.where(bad[:, np.newaxis, np.newaxis], np.nan, result.strobes)
        longest = max(1, min(plan.n_points // 2, self.window.periods))
        kept = replace(result, points=points, strobes=strobes)
        n_periods = periods_at(kept, plan, self.window.periods, longest)
        if self.measures:
            values, _, count = measure_group(
                self.measures, group, self.window, MOST_IMPACTS, self.section
            )
            block.n_impacts += count
            for name in self.measures:
                block.arrays[name][rows] = values[name]
        block.arrays["points"][rows] = points
        block.arrays["period"][rows] = np.where(bad, NO_PERIOD, n_periods)
        block.arrays["status"][rows] = result.status
        block.n_impacts += int(result.n_impacts.sum())
        for i in np.flatnonzero(bad):
            block.reasons[int(rows[i])] = str(reason_of(int(result.status[i]), plan))
        return result.ends


@dataclass(frozen=True, slots=True)
class FreshBranches(Branches):
    """The job of the branches that begin at a start at each value; values are the fastest axis."""

    part: ClassVar = "afresh"
    grids: tuple[Grid, ...]

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.grids) * self.grids[0].size

    @property
    def chunk(self) -> int:
        """Points of a chunk."""
        each = self.window.transient + self.window.periods
        return min(2048, max(1, IMPACTS_OF_A_CHUNK // (each * cost_of(self.grids[0].osc))))

    @property
    def columns(self) -> dict[str, Column]:
        """Points of the section, and the period."""
        return self.of_value

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The starts, and the values."""
        names = tuple(f"start {i}" for i in range(len(self.grids)))
        return Dimension("branch", names), *self.grids[0].dimensions

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        starts = [repr(grid.start) for grid in self.grids]
        return self.grids[0].identity() | self.settings() | {"starts": starts}

    def compute(self, first: int, last: int) -> Block:
        """Follow the points of a chunk."""
        n = self.grids[0].size
        block = self.empty(last - first)
        for number in range(first // n, (last - 1) // n + 1):
            low, high = max(first - number * n, 0), min(last - number * n, n)
            groups, faults = self.grids[number].groups(low, high)
            place = number * n + low - first
            block.reasons |= {place + i: text for i, text in faults.items()}
            for group in groups:
                self.fill(block, group, place + group.rows)
        return block


@dataclass(frozen=True, slots=True)
class FollowedBranches(Branches):
    """The job of the followed branches; each is one point and one chunk."""

    part: ClassVar = "followed"
    grid: Grid
    follow: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of branches."""
        return len(self.follow)

    @property
    def each(self) -> str:
        """The name of its points, for the progress."""
        return f"followed branches of {self.grid.size:,} values"

    @property
    def chunk(self) -> int:
        """One branch."""
        return 1

    @property
    def columns(self) -> dict[str, Column]:
        """Those of `FreshBranches` over the values."""
        n, path = self.grid.size, self.grid.axes[0].path
        return {
            name: Column((n, *column.tail), column.dtype, (path, *column.dims))
            for name, column in self.of_value.items()
        }

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The directions."""
        return (Dimension("branch", self.follow),)

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        return self.grid.identity() | self.settings() | {"follow": list(self.follow)}

    def compute(self, first: int, last: int) -> Block:
        """Follow a branch; values without a motion are skipped."""
        n = self.grid.size
        block = Block.empty(self.columns, last - first)
        for branch in range(first, last):
            values = range(n) if self.follow[branch] == "forward" else range(n - 1, -1, -1)
            begin: Floats | None = None
            # The column of status holds the reasons of single values.
            for k in values:
                check_going_on()
                begin = self._step(block, branch - first, k, begin)
        return block

    def _step(self, block: Block, row: int, k: int, begin: Floats | None) -> Floats | None:
        groups, faults = self.grid.groups(k, k + 1)
        if begin is not None and faults:
            # The start of the grid may be inside a wall that has moved; the branch is not.
            groups, faults = _between_walls(self.grid, k, begin).groups(k, k + 1)
        if faults:
            block.arrays["status"][row, k] = FAULTY
            return begin
        group = groups[0]
        if begin is not None:
            starts = group.starts.copy()
            starts[0, :-1] = group.within_walls(begin)
            if not np.abs(starts[0, :-1]).max() < HUGE:
                # A wall has pushed it out of the range of floats' squares.
                block.arrays["status"][row, k] = OVERFLOW
                return begin
            group = group.beginning(np.zeros(1, dtype=np.int64), starts)
        step = self.empty(1)
        ends = self.fill(step, group, np.zeros(1, dtype=np.int64))
        for name, array in step.arrays.items():
            block.arrays[name][row, k] = array[0]
        block.n_impacts += step.n_impacts
        return ends[0] if np.isfinite(ends).all() else begin


def _between_walls(grid: Grid, k: int, state: Floats) -> Grid:
    """Return the grid that starts at a state, or at the walls that have moved past it."""
    try:
        osc, _, _ = grid.point(k)
    except ParameterError:
        return grid
    if isinstance(osc, Structure):
        begin = within_walls(osc, state).tolist()
        start = StructureStart(begin[: osc.n], begin[osc.n :])
        return replace(grid, start=start)
    x = float(state[0])
    for stop in osc.stops:
        if isinstance(stop, Wall):
            x = (max if stop.side == "below" else min)(x, as_float(stop.at))
    return replace(grid, start=Start(x, float(state[1])))


def failed_values(arrays: Mapping[str, NDArray[np.generic]]) -> int:
    """Return the number of values, of all branches, that are done and have no motion."""
    return int(((arrays["period"] == NO_PERIOD) & (arrays["status"] != NOT_DONE)).sum())
