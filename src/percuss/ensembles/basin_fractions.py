"""Basin fractions over a parameter, each attractor followed from one value to the next."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.basins import UNITS, columns_of
from percuss.ensembles.datasets import attributes_of, coordinates_of
from percuss.ensembles.engines import Engine
from percuss.ensembles.fates import STAGE, Fates, Rules
from percuss.ensembles.grid import Grid, LanesOf, check_whole, make_grid, walls_of
from percuss.ensembles.job import Dimension
from percuss.ensembles.matching import Followed, follow_attractors
from percuss.ensembles.running import Answer, Report, keep, run_job
from percuss.ensembles.sweep import identity_of
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["basin_fractions"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Values that a range (low, high) of the parameter stands for.
VALUES = 51


def basin_fractions(
    osc: Oscillator,
    force: Forcing | None,
    *,
    over: Mapping[str, object],
    x0: tuple[Phase, Phase],
    v0: tuple[Phase, Phase],
    t0: Phase = 0.0,
    n_starts: int = 1000,
    seed: int = 0,
    periods: int = 1000,
    escape: float = 1e6,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
) -> Dataset:
    """Return which part of random starts goes to which attractor, over a parameter.

    The same starts are taken at each value of the parameter. An attractor is carried on from one
    value to the next: its points at the one are followed at the other, and where they go is the
    same attractor, through changes of its period and into chaos. Of two that go to the same one,
    the nearer is carried on and the other has ended. So an attractor is found, too, whose basin
    holds none of the starts: its fraction is 0 until it ends.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    over
        One path, and a range (low, high), which is taken in 51 values, or the values themselves.
    x0, v0
        Ranges (low, high) in which the starts are drawn, all places equally likely [length],
        [length/time].
    t0
        Time of the starts [time].
    n_starts
        How many starts, >= 1. Those inside a wall count for nothing.
    seed
        Of the random numbers.
    periods, escape
        As in `basins`.
    store, engine, n_workers, progress
        As in `sweep`.

    Returns
    -------
    xarray.Dataset
        Over the attractors and the path: `fraction`, and `fraction_error`, its standard error;
        `exists`; `kind`, `name`, `n_periods`, `n_impacts`, `x`, `v_strobe`, `exponent`,
        `exponent_error` and `residual` as in `basins`, NaN and empty where it does not exist.
        Over the path: `undecided`, the part of the starts that was not decided, and `n_starts`,
        those outside the walls. Attractors are numbered as they appear.

    Raises
    ------
    ParameterError
        If there is no such path, a range is none, or the forcing has no period.

    Examples
    --------
    The motion without impacts begins where it no longer touches the wall, at 0.794:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
    >>> found = pc.basin_fractions(osc, pc.cosine(1.5), n_starts=100, x0=(-4, 0.7), v0=(-4, 4),
    ...                            over={"oscillator.stops.0.at": [0.7, 1.2, 1.7]})
    >>> found.name.values.tolist()
    [['(1, 1)', '(1, 1)', '(1, 1)'], ['', '(0, 1)', '(0, 1)']]
    """
    if force is None or force.period is None:
        raise ParameterError("forcing.period", None, "basins need a periodic forcing")
    check_whole("periods", periods, STAGE)
    check_whole("n_starts", n_starts, 1)
    check_whole("seed", seed, 0)
    grid = make_grid(osc, force, Start(0.0, 0.0, t0), over, VALUES)
    if len(grid.axes) != 1 or grid.axes[0].of_start:
        given = [axis.path for axis in grid.axes]
        raise ParameterError("over", given, "fractions have one axis, a parameter of the motion")
    box = (_range("x0", x0), _range("v0", v0))
    rules = Rules(as_float(t0), False, periods, float(escape))
    told = identity_of(grid) | {
        "kind": "basin fractions", "box": repr(box), "n_starts": n_starts, "seed": seed,
    }  # fmt: skip
    drawn = Scattered(grid, box, n_starts, seed)
    job = Fates(drawn, rules, tuple(told.items()))
    answer = run_job(job, store, engine, n_workers, progress)
    followed = follow_attractors(grid, rules, answer.arrays, n_starts)
    return keep(_dataset(grid, answer, followed), store)


def _range(name: str, ends: object) -> tuple[float, float]:
    try:
        low, high = (as_float(end) for end in ends)  # type: ignore[attr-defined]  # else told
    except (TypeError, ValueError) as error:
        raise ParameterError(name, ends, "not a range (low, high)") from error
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(name, ends, "not a range from a low to a higher finite number")
    return low, high


@dataclass(frozen=True, slots=True)
class Scattered:
    """The same random starts at each value of a parameter; the starts are the faster axis."""

    grid: Grid
    box: tuple[tuple[float, float], tuple[float, float]]
    n_starts: int
    seed: int

    @property
    def size(self) -> int:
        """Number of starts, counted at each value."""
        return self.grid.size * self.n_starts

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The parameter, and the number of the start."""
        numbers = tuple(float(i) for i in range(self.n_starts))
        return (*self.grid.dimensions, Dimension("start", numbers))

    def lanes(self, first: int, last: int) -> tuple[list[LanesOf], dict[int, str]]:
        """Return the lanes of the starts from first to last."""
        draw = np.random.default_rng(self.seed).random((self.n_starts, 2))
        low, high = np.array(self.box).T
        places = low + draw * (high - low)
        found: list[LanesOf] = []
        faults: dict[int, str] = {}
        for k in range(first // self.n_starts, (last - 1) // self.n_starts + 1):
            begin = k * self.n_starts
            those = np.arange(max(first - begin, 0), min(last - begin, self.n_starts))
            rows = begin + those - first
            # The grid's own start may be inside a wall; its law does not depend on it.
            try:
                table, t0 = law_at(self.grid, k)
            except ParameterError as error:
                faults |= {int(row): str(error) for row in rows}
                continue
            walls = walls_of(table[np.newaxis])
            inside = (places[those, 0] < walls[0][0]) | (places[those, 0] > walls[1][0])
            faults |= {int(row): "inside a wall" for row in rows[inside]}
            outside = those[~inside]
            starts = np.column_stack([places[outside], np.full(len(outside), t0)])
            which = np.zeros(len(outside), dtype=np.int64)
            found.append(LanesOf(table[np.newaxis], which, starts, rows[~inside]))
        return found, faults


def law_at(grid: Grid, k: int) -> tuple[Floats, float]:
    """Return the law at a value, and the time of the starts."""
    osc, force, start = grid.point(k)
    return law(osc, force), as_float(start.t0)


def _dataset(grid: Grid, answer: Answer, followed: Sequence[Followed]) -> Dataset:
    import xarray

    path = grid.axes[0].path
    n = 1 + max((number for one in followed for number in one.attractors), default=-1)
    shape = (n, len(followed))
    dims = ("attractor", path)
    texts = {name: np.full(shape, "", dtype=object) for name in ("kind", "name")}
    numbers = {name: np.full(shape, np.nan) for name in columns_of(None)}
    fraction, error = np.zeros(shape), np.zeros(shape)
    exists = np.zeros(shape, dtype=np.bool_)
    for k, one in enumerate(followed):
        for number, attractor in one.attractors.items():
            exists[number, k] = True
            texts["kind"][number, k], texts["name"][number, k] = attractor.kind, attractor.name
            fraction[number, k], error[number, k] = one.fractions[number]
            for name, value in columns_of(attractor).items():
                numbers[name][number, k] = value
    data: dict[str, Any] = {
        "fraction": (dims, fraction),
        "fraction_error": (dims, error),
        "exists": (dims, exists),
        **{name: (dims, values) for name, values in texts.items()},
        **{
            name: (dims, values, {"units": UNITS.get(name, "1")})
            for name, values in numbers.items()
        },
        "undecided": (path, np.array([one.undecided for one in followed])),
        "n_starts": (path, np.array([one.n_starts for one in followed], dtype=np.int64)),
    }
    return xarray.Dataset(data, coords=coordinates_of(grid), attrs=attributes_of(grid, answer))
