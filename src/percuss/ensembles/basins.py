"""Basins of attraction: to which attractor each start goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.attractors import (
    CHAOTIC,
    LONGEST,
    PERIODIC,
    REST,
    UNBOUNDED,
    label_starts,
)
from percuss.ensembles.datasets import attributes_of, coordinates_of
from percuss.ensembles.engines import Engine
from percuss.ensembles.grid import Grid, LanesOf, check_whole, make_grid
from percuss.ensembles.job import Block, Column
from percuss.ensembles.lanes import MOST_IMPACTS, Lanes, Plan, follow_lanes
from percuss.ensembles.measures import period_of
from percuss.ensembles.running import Report, run_job
from percuss.ensembles.sweep import identity_of
from percuss.ensembles.tangents import exponents_of, tangent_plan
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels import survey
from percuss.kernels.law import PERIOD
from percuss.model.exact import Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.model.stops import Wall

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["basins"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# A start is followed so many forcing periods at a time, the last of which tell whether it has
# become periodic, of up to half as many periods.
STAGE, LOOKED_AT = 40, 2 * LONGEST
# What is left is called chaotic where its largest exponent over so many periods is above 0 by
# three errors, and by this much times the frequency.
PERIODS_OF_AN_EXPONENT = 512
CERTAIN, LEAST_EXPONENT = 3.0, 1e-3


def basins(
    osc: Oscillator,
    force: Forcing | None,
    *,
    x0: object = None,
    v0: object = None,
    cycle: object = None,
    v: object = None,
    stop: int = 0,
    t0: Phase = 0.0,
    periods: int = 1000,
    escape: float = 1e6,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
) -> Dataset:
    """Find the attractors that the starts of a grid go to, and which start goes to which.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    x0, v0
        Values of the start [length], [length/time]: the two axes, at the time t0.
    cycle, v
        Instead of these: starts at the wall ``stop``, at these cycles in [0, 1) and with these
        speeds >= 0 off it [length/time].
    stop
        Index of that wall among the oscillator's stops.
    t0
        Time of the start [time].
    periods
        Forcing periods after which a start that has not been decided stays so.
    escape
        A motion that goes farther than this [length], or than the forcing's frequency times this
        in speed, is unbounded.
    store, engine, n_workers, progress
        As in `sweep`.

    Returns
    -------
    xarray.Dataset
        `basin` over both axes: the number of an attractor, -1 where it was not decided in the
        time given, -2 where the start is no start (inside a wall). Over `attractor`: its `kind`
        ("periodic", "chaotic", "rest", "unbounded"), `n_periods` and `n_impacts` of one round
        (0 and NaN unless periodic), `x` and `v` of a strobe at the cycle of t0, `fraction` of the
        decided and undecided starts, and `fraction_error`, its standard error were the starts
        drawn at random.

    Raises
    ------
    ParameterError
        If an axis is empty or not finite, or the forcing has no period.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)
    >>> found = pc.basins(osc, pc.cosine(1.5), x0=[-3.4, -3.3, 0.37, 0.38], v0=[0.0])
    >>> [str(found.kind.values[i]) for i in found.basin.values[:, 0]]
    ['periodic', 'periodic', 'periodic', 'periodic']
    >>> found.n_impacts.values[found.basin.values[:, 0]]
    array([1., 0., 0., 1.])
    """
    if force is None or force.period is None:
        raise ParameterError("forcing.period", None, "basins need a periodic forcing")
    check_whole("periods", periods, STAGE)
    grid, at_wall = _grid(osc, force, (x0, v0), (cycle, v), stop, t0)
    job = Basins(grid, at_wall, periods, float(escape))
    answer = run_job(job, store, engine, n_workers, progress)
    return _dataset(job, grid, answer)


def _grid(
    osc: Oscillator,
    force: Forcing,
    places: tuple[object, object],
    impacts: tuple[object, object],
    stop: int,
    t0: Phase,
) -> tuple[Grid, int | None]:
    """Return the grid of the starts, and the stop that they lie at, None where they do not."""
    if (places[0] is None) != (places[1] is None) or (impacts[0] is None) != (impacts[1] is None):
        raise ParameterError("x0", places[0], "give x0 and v0, or cycle and v")
    if (places[0] is None) == (impacts[0] is None):
        raise ParameterError("x0", places[0], "give either x0 and v0, or cycle and v")
    if places[0] is not None:
        return make_grid(
            osc, force, Start(0.0, 0.0, t0), {"start.x0": places[0], "start.v0": places[1]}
        ), None
    if not 0 <= stop < len(osc.stops) or not isinstance(osc.stops[stop], Wall):
        raise ParameterError("stop", stop, "the number of no wall; give x0 and v0")
    grid = make_grid(
        osc, force, Start(osc.stops[stop].at, 0.0), {"start.t0": impacts[0], "start.v0": impacts[1]}
    )
    for path, values, high in (
        ("cycle", grid.axes[0].values, 1.0),
        ("v", grid.axes[1].values, None),
    ):
        if values.min() < 0.0 or (high is not None and values.max() >= high):
            wrong = values.min() if values.min() < 0.0 else values.max()
            raise ParameterError(path, float(wrong), "outside [0, 1)" if high else "negative")
    return grid, stop


@dataclass(frozen=True, slots=True)
class Basins:
    """The job: what has become of each start."""

    grid: Grid
    stop: int | None
    periods: int
    escape: float

    @property
    def size(self) -> int:
        """Number of starts."""
        return self.grid.size

    @property
    def chunk(self) -> int:
        """Starts of a chunk."""
        return 2048

    @property
    def columns(self) -> Mapping[str, Column]:
        """The kind; the period in forcing periods and impacts in one; a strobe."""
        return {
            "kind": Column(dtype="i8"),
            "n_periods": Column(dtype="i8"),
            "n_impacts": Column(),
            "strobe": Column((2,)),
        }

    def identity(self) -> dict[str, object]:
        """Return what makes it this study."""
        return identity_of(self.grid) | {
            "kind": "basins",
            "stop": self.stop,
            "periods": self.periods,
            "escape": self.escape,
        }

    def compute(self, first: int, last: int) -> Block:
        """Follow the starts of a chunk until each is decided."""
        groups, faults = self.grid.lanes(first, last)
        block = Block({name: column.empty(last - first) for name, column in self.columns.items()})
        block.arrays["kind"][list(faults)] = NO_START
        for group in groups:
            self._follow(block, group)
        return block

    def _starts(self, group: LanesOf) -> Floats:
        if self.stop is None:
            return group.starts
        starts = group.starts.copy()
        # The axes stand for the cycle and the speed off the wall.
        starts[:, 2] *= group.laws[group.which, 0, PERIOD]
        if self.grid.osc.stops[self.stop].side == "above":
            starts[:, 1] *= -1.0
        return starts

    def _follow(self, block: Block, group: LanesOf) -> None:
        starts = self._starts(group)
        period = group.laws[group.which, 0, PERIOD]
        left = np.arange(len(starts))
        begun = starts.copy()
        for stage in range(-(-self.periods // STAGE)):
            until = self._until(period[left], stage + 1)
            plan = Plan(
                until - LOOKED_AT * period[left],
                period[left],
                until,
                section=survey.STROBES,
                n_points=LOOKED_AT + 1,
                max_impacts=MOST_IMPACTS,
            )
            lanes = follow_lanes(group.laws, group.which[left], begun[left], plan)
            block.n_impacts += int(lanes.n_impacts.sum())
            decided = self._decide(block, group.rows[left], lanes, period[left])
            begun[left, :2] = lanes.tallies[:, [survey.END_X, survey.END_V]]
            begun[left, 2] = until
            lost = ~np.isfinite(begun[left]).all(axis=1)
            left = left[~(decided | lost)]
            if len(left) == 0:
                return
        plan = tangent_plan(
            group.laws, group.which[left], begun[left, 2], 0, PERIODS_OF_AN_EXPONENT
        )
        lanes = follow_lanes(group.laws, group.which[left], begun[left], plan)
        block.n_impacts += int(lanes.n_impacts.sum())
        largest, _, error, _ = exponents_of(lanes, plan)
        chaotic = largest > np.maximum(CERTAIN * error, LEAST_EXPONENT / period[left])
        rows = group.rows[left[chaotic]]
        block.arrays["kind"][rows] = CHAOTIC
        block.arrays["strobe"][rows] = begun[left[chaotic], :2]

    def _until(self, period: Floats, stage: int) -> Floats:
        t0 = 0.0 if self.stop is not None else as_float(self.grid.start.t0)
        # One period more for starts at the wall, which begin within the first.
        return np.asarray(t0 + (stage * STAGE + (self.stop is not None)) * period)

    def _decide(
        self, block: Block, rows: Numbers, lanes: Lanes, period: Floats
    ) -> NDArray[np.bool_]:
        """Write down what is decided; return which lanes that are."""
        strobes = lanes.points[:, :, :2]
        ended = lanes.status == columns.REACHED_END
        rest = lanes.status == columns.AT_REST
        end, speed = lanes.tallies[:, survey.END_X], lanes.tallies[:, survey.END_V]
        # At the strobe x may be on its way past 0, and the speed large.
        far = np.maximum(np.abs(end), np.abs(speed) * period / (2.0 * np.pi)) > self.escape
        unbounded = (lanes.status == columns.OVERFLOW) | (ended & far)
        found = period_of(np.nan_to_num(strobes), LONGEST)
        periodic = ended & ~unbounded & (found > 0)
        kinds = block.arrays["kind"]
        kinds[rows[rest]], kinds[rows[unbounded]] = REST, UNBOUNDED
        kinds[rows[periodic]] = PERIODIC
        block.arrays["n_periods"][rows[periodic]] = found[periodic]
        per_period = lanes.tallies[:, survey.IMPACTS] / LOOKED_AT
        block.arrays["n_impacts"][rows[periodic]] = np.round((per_period * found)[periodic])
        # A held mass has its place as strobe.
        place = np.where(
            rest[:, np.newaxis], lanes.state[:, [columns.X, columns.V]], strobes[:, -1]
        )
        decided = rest | unbounded | periodic
        bounded = decided & ~unbounded
        block.arrays["strobe"][rows[bounded]] = place[bounded]
        return np.asarray(decided)


# The kind of a point that is inside a wall.
NO_START = -2


def _dataset(job: Basins, grid: Grid, answer: Any) -> Dataset:
    import xarray

    arrays = answer.arrays
    labels, found = label_starts(job, arrays)
    dims = tuple(axis.path for axis in grid.axes)
    coords = coordinates_of(grid)
    if job.stop is not None:
        dims = ("cycle", "v")
        units = ("1", "length/time")
        coords = {
            name: (name, axis.values, {"units": unit})
            for name, axis, unit in zip(dims, grid.axes, units, strict=True)
        }
    started = labels != NO_START
    n = max(int(started.sum()), 1)
    fraction = np.array([(labels == i).sum() / n for i in range(len(found))])
    error = np.sqrt(fraction * (1.0 - fraction) / n)
    strobes = np.array([one.strobe for one in found]).reshape(-1, 2)
    data = {
        "basin": (dims, labels.reshape(grid.shape)),
        "kind": ("attractor", np.array([one.kind for one in found], dtype=object)),
        "n_periods": ("attractor", np.array([one.n_periods for one in found], dtype=np.int64)),
        "n_impacts": ("attractor", np.array([one.n_impacts for one in found], dtype=np.float64)),
        "x": ("attractor", strobes[:, 0], {"units": "length"}),
        "v_strobe": ("attractor", strobes[:, 1], {"units": "length/time"}),
        "fraction": ("attractor", fraction),
        "fraction_error": ("attractor", error),
    }
    attrs = attributes_of(grid, answer) | {"undecided": float((labels == -1).sum() / n)}
    return xarray.Dataset(data, coords=coords, attrs=attrs)
