"""Bifurcation diagrams: the points of the attractors over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.datasets import attributes_of, coordinates_of
from percuss.ensembles.engines import Engine
from percuss.ensembles.grid import Grid, LanesOf, check_whole, make_grid, walls_of
from percuss.ensembles.job import Block, Column
from percuss.ensembles.lanes import MOST_IMPACTS, Plan, follow_lanes, reason_of
from percuss.ensembles.measures import SAME, Window, period_of
from percuss.ensembles.running import Answer, Report, run_job
from percuss.ensembles.sweep import identity_of
from percuss.errors import ParameterError
from percuss.kernels import survey
from percuss.kernels.law import PERIOD
from percuss.model.exact import Phase
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["bifurcation_diagram"]

Floats = NDArray[np.float64]
Section = Literal["stroboscopic", "impacts"]
Direction = Literal["forward", "backward"]
_SECTIONS = {"stroboscopic": survey.STROBES, "impacts": survey.IMPACT_POINTS}


def bifurcation_diagram(
    osc: Oscillator,
    force: Forcing | None,
    *,
    over: Mapping[str, object],
    section: Section = "stroboscopic",
    starts: Sequence[Start | Sequence[Phase]] = ((0.0, 0.0),),
    follow: Sequence[Direction] = ("forward", "backward"),
    transient: int = 200,
    points: int = 64,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
) -> Dataset:
    """Return the points of the attractors over a parameter.

    A branch is *followed* when each value of the parameter begins where the motion at the value
    before ended, at the same cycle: forward and backward then show which attractors coexist
    (hysteresis). Besides, every value begins afresh from each of the starts.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    over
        One path and its values, in the order in which they are followed forward.
    section
        "stroboscopic": (x, v) once a forcing period; "impacts": (cycle, v_after) at impacts and
        at entries into soft stops.
    starts
        Starts, each a `Start` or x0, v0. The first is where the followed branches begin.
    follow
        Any of "forward" and "backward".
    transient
        Forcing periods that are left out at each value.
    points
        Points kept at each value, >= 2: forcing periods that are followed; of impacts the last.
    store, engine, n_workers, progress
        As in `sweep`. A followed branch is one piece of work.

    Returns
    -------
    xarray.Dataset
        Over (branch, path, sample): `x` [length] and `v` [length/time], or `cycle`, `v_after`
        and `stop`; NaN where there are fewer impacts. Over (branch, path): `period`, after how
        many forcing periods the motion repeats itself (0: none up to half of those followed), and
        `reason`, why there is nothing.

    Raises
    ------
    ParameterError
        If there is no such path, or an axis is empty or not finite.

    Examples
    --------
    Period doubling at omega = 2.6533 (Budd & Dux 1994, in closed form):

    >>> import percuss as pc
    >>> found = pc.bifurcation_diagram(
    ...     pc.impact_oscillator(restitution=0.8), pc.cosine(2.5),
    ...     over={"forcing.omega": [2.64, 2.67]}, starts=[(0.0, 1.0)], follow=["forward"],
    ... )
    >>> found.period.sel(branch="forward").values
    array([1, 2])
    """
    grids = [make_grid(osc, force, start, over) for start in starts]
    _check(grids, force, section, follow, points)
    window = Window(transient, points - 1)
    answers = []
    for job, part in (
        (Followed(grids[0], tuple(follow), section, window), "followed"),
        (Afresh(tuple(grids), section, window), "afresh"),
    ):
        folder = None if store is None else Path(store) / part
        if job.size > 0:
            answers.append(run_job(job, folder, engine, n_workers, progress))
    names = [*follow, *(f"start {i}" for i in range(len(grids)))]
    return _dataset(grids[0], names, section, answers)


def _check(
    grids: list[Grid], force: Forcing | None, section: str, follow: Sequence[str], points: int
) -> None:
    if not grids:
        raise ParameterError("starts", (), "none at all; give (x0, v0)")
    if len(grids[0].axes) != 1 or grids[0].axes[0].of_start:
        given = [axis.path for axis in grids[0].axes]
        raise ParameterError("over", given, "a diagram has one axis, a parameter of the motion")
    if section not in _SECTIONS:
        raise ParameterError("section", section, f"neither {' nor '.join(_SECTIONS)}")
    for name in follow:
        if name not in ("forward", "backward"):
            raise ParameterError("follow", name, "neither forward nor backward")
    check_whole("points", points, 2)
    if force is None or force.period is None:
        raise ParameterError("forcing.period", None, "a diagram needs a periodic forcing")


def _plan(group: LanesOf, section: str, window: Window) -> Plan:
    period = group.laws[group.which, 0, PERIOD]
    since = group.starts[:, 2] + window.transient * period
    return Plan(
        since,
        period,
        since + window.periods * period,
        section=_SECTIONS[section],
        n_points=window.periods + 1,
        max_impacts=MOST_IMPACTS,
    )


@dataclass(frozen=True, slots=True)
class Afresh:
    """The job of the branches that begin anew at each value: (start, value), values fastest."""

    grids: tuple[Grid, ...]
    section: str
    window: Window

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.grids) * self.grids[0].size

    @property
    def chunk(self) -> int:
        """Points of a chunk."""
        return max(1, min(2048, 300_000 // (self.window.transient + self.window.periods)))

    @property
    def columns(self) -> dict[str, Column]:
        """Points of the section, and the period."""
        return _columns(self.window)

    def identity(self) -> dict[str, object]:
        """Return what makes it this study."""
        starts = [repr(grid.start) for grid in self.grids]
        return identity_of(self.grids[0]) | _identity(self) | {"starts": starts}

    def compute(self, first: int, last: int) -> Block:
        """Follow the points of a chunk."""
        n = self.grids[0].size
        block = _empty(self, last - first)
        for number in range(first // n, (last - 1) // n + 1):
            low, high = max(first - number * n, 0), min(last - number * n, n)
            groups, faults = self.grids[number].lanes(low, high)
            place = number * n + low - first
            block.reasons |= {place + i: text for i, text in faults.items()}
            for group in groups:
                _fill(block, group, place + group.rows, self.section, self.window)
        return block


@dataclass(frozen=True, slots=True)
class Followed:
    """The job of the branches that are followed; each is one point, and a chunk."""

    grid: Grid
    follow: tuple[str, ...]
    section: str
    window: Window

    @property
    def size(self) -> int:
        """Number of branches."""
        return len(self.follow)

    @property
    def chunk(self) -> int:
        """One branch."""
        return 1

    @property
    def columns(self) -> dict[str, Column]:
        """Those of `Afresh` over the values."""
        n = self.grid.size
        return {
            name: Column((n, *column.tail), column.dtype)
            for name, column in _columns(self.window).items()
        }

    def identity(self) -> dict[str, object]:
        """Return what makes it this study."""
        return identity_of(self.grid) | _identity(self) | {"follow": list(self.follow)}

    def compute(self, first: int, last: int) -> Block:
        """Follow a branch; a value that has no motion is passed over."""
        n = self.grid.size
        block = Block({name: column.empty(last - first) for name, column in self.columns.items()})
        for branch in range(first, last):
            values = range(n) if self.follow[branch] == "forward" else range(n - 1, -1, -1)
            begin: Floats | None = None
            # The reasons of single values travel in the column of status.
            for k in values:
                begin = self._step(block, branch - first, k, begin)
        return block

    def _step(self, block: Block, row: int, k: int, begin: Floats | None) -> Floats | None:
        groups, faults = self.grid.lanes(k, k + 1)
        if begin is not None and faults:
            # The grid's own start may be inside a wall that has moved; the branch is not.
            grid = replace(self.grid, start=Start(float(begin[0]), float(begin[1])))
            groups, faults = grid.lanes(k, k + 1)
        if faults:
            block.arrays["status"][row, k] = FAULTY
            return begin
        group = groups[0]
        if begin is not None:
            low, high = walls_of(group.laws)
            starts = group.starts.copy()
            starts[0, :2] = min(max(begin[0], low[0]), high[0]), begin[1]
            group = replace(group, starts=starts)
        one = _empty(self, 1)
        ends = _fill(one, group, np.zeros(1, dtype=np.int64), self.section, self.window)
        for name, array in one.arrays.items():
            block.arrays[name][row, k] = array[0]
        block.n_impacts += one.n_impacts
        return ends[0] if np.isfinite(ends).all() else begin


# The status of a value that has no motion at all, besides those of the kernels.
FAULTY = -2
# What a column of whole numbers holds where nothing has been written.
NOT_DONE = -1


def _columns(window: Window) -> dict[str, Column]:
    return {
        "points": Column((window.periods + 1, survey.POINT_COLUMNS)),
        "period": Column(dtype="i8"),
        "status": Column(dtype="i8"),
    }


def _empty(job: Afresh | Followed, n: int) -> Block:
    block = Block({name: column.empty(n) for name, column in _columns(job.window).items()})
    block.arrays["status"][:] = FAULTY
    return block


def _identity(job: Afresh | Followed) -> dict[str, object]:
    return {
        "kind": f"diagram, {type(job).__name__.lower()}",
        "section": job.section,
        "transient": job.window.transient,
        "points": job.window.periods + 1,
    }


def _fill(
    block: Block, group: LanesOf, rows: NDArray[np.int64], section: str, window: Window
) -> Floats:
    """Follow lanes, put what is kept of them into rows of a block, and return where they end."""
    plan = _plan(group, section, window)
    lanes = follow_lanes(group.laws, group.which, group.starts, plan)
    bad = np.array([reason_of(int(status), plan) is not None for status in lanes.status])
    points = lanes.points.copy()
    points[bad] = np.nan
    block.arrays["points"][rows] = points
    block.arrays["period"][rows] = np.where(bad, -1, _period(lanes.tallies, points, section))
    block.arrays["status"][rows] = lanes.status
    block.n_impacts += int(lanes.n_impacts.sum())
    for i in np.flatnonzero(bad):
        block.reasons[int(rows[i])] = str(reason_of(int(lanes.status[i]), plan))
    return np.asarray(lanes.tallies[:, [survey.END_X, survey.END_V]])


def _period(tallies: Floats, points: Floats, section: str) -> NDArray[np.int64]:
    longest = points.shape[1] // 2
    if section == "stroboscopic":
        return period_of(points[:, :, :2], max(1, min(longest, points.shape[1] - 1)))
    return impact_periods(points, tallies[:, survey.IMPACTS], points.shape[1] - 1)


def impact_periods(points: Floats, impacts: Floats, periods: int) -> NDArray[np.int64]:
    """Return the forcing periods after which motions repeat themselves, from their impacts.

    Parameters
    ----------
    points
        (n, m, 3) array of (cycle, v_after, bound), NaN where there are fewer.
    impacts
        (n,) array, how many impacts there were in ``periods`` forcing periods.
    periods
        How many were counted.

    Returns
    -------
    (n,) array
        0 where none is found among half of the points.
    """
    n, m = points.shape[:2]
    found = np.zeros(n, dtype=np.int64)
    speed = np.nan_to_num(np.abs(points[:, :, 1])).max(axis=1, keepdims=True)
    for count in range(m // 2, 0, -1):
        step = points[:, count:] - points[:, :-count]
        turn = np.abs(step[:, :, 0] - np.round(step[:, :, 0]))
        known = ~np.isnan(step[:, :, 1])
        same = (turn <= SAME) & (np.abs(step[:, :, 1]) <= SAME * speed) & (step[:, :, 2] == 0.0)
        repeats = (same | ~known).all(axis=1) & (known.sum(axis=1) >= count)
        with np.errstate(divide="ignore"):
            found = np.where(repeats, np.round(count * periods / impacts), found).astype(np.int64)
    return found


def _dataset(grid: Grid, names: list[str], section: str, answers: list[Answer]) -> Dataset:
    import xarray

    n = grid.size
    parts = {
        name: np.concatenate(
            [
                a.arrays[name].reshape(-1, n, *a.arrays[name].shape[a.arrays["period"].ndim :])
                for a in answers
            ]
        )
        for name in ("points", "period", "status")
    }
    path = grid.axes[0].path
    sampled = ("branch", path, "sample")
    if section == "stroboscopic":
        data: dict[str, Any] = {
            "x": (sampled, parts["points"][..., 0], {"units": "length"}),
            "v": (sampled, parts["points"][..., 1], {"units": "length/time"}),
        }
    else:
        data = {
            "cycle": (sampled, parts["points"][..., 0], {"units": "1"}),
            "v_after": (sampled, parts["points"][..., 1], {"units": "length/time"}),
            "bound": (sampled, parts["points"][..., 2], {"units": "1"}),
        }
    data["period"] = (("branch", path), parts["period"], {"units": "1"})
    data["reason"] = (("branch", path), _reasons(grid, parts["status"]))
    complete = all(answer.complete for answer in answers)
    total = sum(answer.n_impacts for answer in answers)
    return xarray.Dataset(
        data,
        coords=coordinates_of(grid) | {"branch": names},
        attrs=attributes_of(grid, Answer({}, {}, total, complete)) | {"section": section},
    )


def _reasons(grid: Grid, status: NDArray[np.generic]) -> NDArray[np.object_]:
    found = np.full(status.shape, "", dtype=object)
    still = np.zeros(1)
    for branch, k in zip(*np.nonzero(status != 0), strict=True):
        code = int(status[branch, k])
        reason = reason_of(code, Plan(still, still, still, max_impacts=MOST_IMPACTS))
        if code == FAULTY:
            _, faults = grid.lanes(int(k), int(k) + 1)
            reason = faults.get(0, "the branch does not begin outside the walls")
        elif code == NOT_DONE:
            reason = "not done yet"
        found[branch, k] = reason or ""
    return found
