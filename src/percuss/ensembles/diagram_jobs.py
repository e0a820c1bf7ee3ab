"""The work of a bifurcation diagram: branches begun afresh at each value, and followed ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.grid import Grid, LanesOf, walls_of
from percuss.ensembles.job import Block, Column, Dimension
from percuss.ensembles.lanes import MOST_IMPACTS, Plan, follow_lanes, reason_of
from percuss.ensembles.measures import SAME, Window, period_of
from percuss.ensembles.sweep import IMPACTS_OF_A_CHUNK, identity_of
from percuss.errors import ParameterError
from percuss.kernels import survey
from percuss.kernels.law import PERIOD
from percuss.model.exact import as_float
from percuss.model.start import Start
from percuss.model.stops import Wall

__all__ = [
    "FAULTY",
    "NOT_DONE",
    "SECTIONS",
    "Afresh",
    "Followed",
    "failed_values",
    "impact_periods",
]

Floats = NDArray[np.float64]

SECTIONS = {"stroboscopic": survey.STROBES, "impacts": survey.IMPACT_POINTS}
# The status of a value that has no motion at all, besides those of the kernels.
FAULTY = -2
# What a column of whole numbers holds where nothing has been written.
NOT_DONE = -1
# The period of what has no motion.
NO_PERIOD = -1


def _plan(group: LanesOf, section: str, window: Window) -> Plan:
    period = group.laws[group.which, 0, PERIOD]
    since = group.starts[:, 2] + window.transient * period
    return Plan(
        since,
        period,
        since + window.periods * period,
        section=SECTIONS[section],
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
        each = self.window.transient + self.window.periods
        return min(2048, max(1, IMPACTS_OF_A_CHUNK // each))

    @property
    def columns(self) -> dict[str, Column]:
        """Points of the section, and the period."""
        return _columns(self.window)

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The starts, and the values."""
        names = tuple(f"start {i}" for i in range(len(self.grids)))
        return Dimension("branch", names), *self.grids[0].dimensions

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
    def each(self) -> str:
        """What one point is, for the progress."""
        return f"followed branches of {self.grid.size:,} values"

    @property
    def chunk(self) -> int:
        """One branch."""
        return 1

    @property
    def columns(self) -> dict[str, Column]:
        """Those of `Afresh` over the values."""
        n, path = self.grid.size, self.grid.axes[0].path
        return {
            name: Column((n, *column.tail), column.dtype, (path, *column.dims))
            for name, column in _columns(self.window).items()
        }

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The directions."""
        return (Dimension("branch", self.follow),)

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
            x0 = _between_walls(self.grid, k, float(begin[0]))
            grid = replace(self.grid, start=Start(x0, float(begin[1])))
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


def _between_walls(grid: Grid, k: int, x: float) -> float:
    """Return the place, or the wall that has moved past it."""
    try:
        osc, _, _ = grid.point(k)
    except ParameterError:
        return x
    for stop in osc.stops:
        if isinstance(stop, Wall):
            x = (max if stop.side == "below" else min)(x, as_float(stop.at))
    return x


def _columns(window: Window) -> dict[str, Column]:
    return {
        "points": Column((window.periods + 1, survey.POINT_COLUMNS), dims=("sample", "entry")),
        "period": Column(dtype="i8"),
        "status": Column(dtype="i8"),
    }


def _empty(job: Afresh | Followed, n: int) -> Block:
    block = Block({name: column.empty(n) for name, column in _columns(job.window).items()})
    block.arrays["status"][:] = FAULTY
    return block


def failed_values(arrays: Mapping[str, NDArray[np.generic]]) -> int:
    """Return at how many values of all branches there is nothing though they have been done."""
    return int(((arrays["period"] == NO_PERIOD) & (arrays["status"] != NOT_DONE)).sum())


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
    block.arrays["period"][rows] = np.where(bad, NO_PERIOD, _period(lanes.tallies, points, section))
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
