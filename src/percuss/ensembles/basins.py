"""Basins of attraction: the attractor of each start."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.array_parts import part_dataset
from percuss.ensembles.attractors import (
    AnyStrobed,
    Attractor,
    StrobedStructure,
    StrobedSystem,
    impacts_at,
    label_starts,
)
from percuss.ensembles.batch import MOST_IMPACTS
from percuss.ensembles.classification import CHUNK, STAGE, Classification, Rules, Starts
from percuss.ensembles.datasets import (
    attributes_of,
    coordinates_of,
    warn_of_failures,
    with_units,
)
from percuss.ensembles.decisions import NO_START, fraction_of
from percuss.ensembles.engines import Engine
from percuss.ensembles.grid import Grid, check_driven, make_grid
from percuss.ensembles.groups import AnyGroup
from percuss.ensembles.job import Answer, Dimension, spans_of
from percuss.ensembles.measures import MEASURES, Window, measure_group
from percuss.ensembles.run_job import execution_of, keep, run_job
from percuss.ensembles.sweep import check_structure, named_measures
from percuss.errors import ParameterError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import Phase, as_float, real, whole
from percuss.model.faults import is_row
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import On, Oscillator, Wall
from percuss.model.periods import require_period
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

# Values that a range (low, high) of the starts stands for.
VALUES = 201
# Points of a chaotic attractor in the result, to be drawn.
DRAWN = 1000


def basins(
    osc: Oscillator | Structure,
    force: Forcing | Loads | None,
    *,
    over: Mapping[Any, object] | None = None,
    on: On | None = None,
    x0: object = None,
    v0: object = None,
    start: Start | StructureStart | Sequence[Any] | None = None,
    cycle: object = None,
    v: object = None,
    stop: int = 0,
    t0: Phase = 0.0,
    periods: int = 1000,
    escape: float = 1e6,
    measures: Sequence[str] = (),
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
    part: Sequence[int] | None = None,
) -> Dataset:
    """Find the attractors of the starts of a grid, and their basins.

    Parameters
    ----------
    osc, force
        The oscillator, and a forcing with a period; or a structure, and loads with a period.
    over
        Of a structure the plane of the starts: two paths of numbers of the start, such as
        ``{"start.x0.0": (-1, 1), "start.v0.1": (-1, 1)}``, or directions (x, v) of 2 n numbers,
        along which the start moves. All other numbers are those of ``start``.
    on
        The coordinate, direction or point of a structure of which measures are taken.
    x0, v0
        Starts [length], [length/time]: the two axes, at the time t0, each a range (low, high),
        which stands for 201 values, or the values themselves.
    start
        The same as (x0, v0) or (x0, v0, t0), in place of these: ``start=((-1, 1), [0.0])``. A
        number, or a `Start`, is one value. Of a structure the start whose two numbers vary.
    cycle, v
        Instead of these: starts at the wall ``stop``, at cycles in [0, 1) and with speeds >= 0
        away from it [length/time].
    stop
        Index of that wall among the oscillator's stops.
    t0
        Time of the start [time].
    periods
        Forcing periods after which an undecided start stays undecided.
    escape
        A motion is unbounded where it goes farther than this [length], or where its speed exceeds
        this times the frequency of the forcing.
    measures
        Names of measures of `sweep`, taken on each attractor.
    store, engine, n_workers, progress, part
        As in `sweep`.

    Returns
    -------
    xarray.Dataset
        `basin` over both axes: the number of an attractor, -1 where the start stayed undecided,
        -2 where it lies inside a wall. Where every start has a periodic motion of its own, as
        without a spring, a thousand of them are distinguished.

        Over `attractor`: its `kind` ("periodic", "chaotic", "rest", "unbounded") and `name`,
        (impacts, periods) of an orbit; `n_impacts` and `n_periods` in one period of it (inf with
        sticking; NaN and 0 unless periodic); `x` and `v_strobe` of a strobe at the cycle of t0;
        `exponent`, the largest Lyapunov exponent [1/time], of an orbit from its multipliers, and
        `exponent_error` of a chaotic one; `residual` of the refined periodic orbit, NaN where there
        is none; `fraction` of the decided and undecided starts, and `fraction_error`, its standard
        error if the starts were drawn at random. The measures, over two periods of an orbit, 1000
        forcing periods of a chaotic motion; NaN of unbounded ones.

        Over `attractor` and `point`, the attractor in the plane of the starts: `attractor_x0` and
        `attractor_v0` at whole periods, or `attractor_cycle` and `attractor_v` at impacts. Of a
        structure `x` and `v_strobe` are over `coordinate`, too, and its attractors are given in the
        plane by `attractor_x0.0` and alike, where the axes are numbers of the start.

        The attribute `failed` counts the starts inside walls, `n_starts` the others, and
        `undecided` is the undecided part of these.

    Warns
    -----
    UserWarning
        If all starts lie inside walls, with the commonest reason and its count.

    Raises
    ------
    ParameterError
        If an axis is empty or not finite, or the forcing has no period.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)
    >>> data = pc.basins(osc, pc.cosine(1.5), x0=[-3.4, -3.3, 0.37, 0.38], v0=[0.0])
    >>> [str(data.name.values[i]) for i in data.basin.values[:, 0]]
    ['(1, 1)', '(0, 1)', '(0, 1)', '(1, 1)']
    """
    execution = execution_of(store, engine, n_workers, progress, part)
    force, periods, escape = checked_call(osc, force, periods, escape)
    names = named_measures(measures)
    if isinstance(osc, Structure):
        given = {"x0": x0, "v0": v0, "cycle": cycle, "v": v}
        grid, at_wall = _plane(osc, force, over, start, t0, on, given), None
        check_structure(names, grid)
        t0 = grid.start.t0
    else:
        if over is not None or on is not None:
            name, value = ("over", over) if over is not None else ("on", on)
            raise ParameterError(name, value, "given for an oscillator; give x0 and v0")
        x0, v0, t0 = start_ranges(start, x0, v0, t0)
        grid, at_wall = _grid(osc, cast("Forcing", force), (x0, v0), (cycle, v), stop, t0)
    begin = 0.0 if at_wall is not None else as_float(t0)
    rules = Rules(begin, at_wall is not None, periods, escape)
    identity = grid.identity() | {"kind": "basins", "stop": at_wall}
    identity |= {"measures": list(names)} if names else {}
    starts = grid if at_wall is None else AtWall(grid, at_wall)
    count = osc.n if isinstance(osc, Structure) else 1
    answer = run_job(Classification(starts, rules, tuple(identity.items()), count), execution)
    if execution.part is not None:
        return part_dataset([answer], execution.part)
    warn_without_starts(starts, answer)
    # A caller who has stopped the motions is not asked again.
    report = execution.progress if answer.complete else None
    reported = Progress(report, starts.size, "starts", done=starts.size)
    system: AnyStrobed
    if isinstance(osc, Structure):
        system = StrobedStructure(StructureSystem.of(osc, force), begin, grid.direction)
    else:
        system = StrobedSystem.of(osc, cast("Forcing", force), begin)
    labels, attractors = label_starts(
        system,
        answer.arrays,
        lambda: reported.advance(0, "refining the attractors"),
    )
    reported.close()
    answer = replace(answer, complete=answer.complete and not reported.is_stopped)
    return keep(_dataset(starts, system, answer, labels, attractors, names), execution)


def checked_call(
    osc: Oscillator | Structure, force: Any, periods: int, escape: float
) -> tuple[Any, int, float]:
    """Return the force, the periods and the distance of a call, or raise a ParameterError."""
    if isinstance(osc, Structure):
        force = loads_of(osc, force)
    check_driven(osc, force)
    require_period(force, "basins need a periodic forcing")
    periods, escape = whole("periods", periods, STAGE), real("escape", escape)
    if not escape > 0.0:
        raise ParameterError("escape", escape, "not a finite distance above 0")
    return force, periods, escape


def no_starts(answer: Answer) -> int:
    """Return the number of starts without a motion: inside a wall, or of an impossible model."""
    return int((answer.arrays["kind"] == NO_START).sum())


def warn_without_starts(starts: Starts, answer: Answer) -> None:
    """Warn, at the line that called the public function, if no start has a motion."""
    if starts.size and no_starts(answer) == starts.size:
        spans = spans_of(starts.size, CHUNK)
        reasons = [text for span in spans for text in starts.groups(*span)[1].values()]
        warn_of_failures("no motion starts anywhere", reasons, stacklevel=4)


def _plane(
    structure: Structure,
    loads: object,
    over: Mapping[Any, object] | None,
    start: object,
    t0: Phase,
    on: On | None,
    others: Mapping[str, object],
) -> Grid:
    """Return the grid of the starts of a structure in a plane."""
    for name, value in others.items():
        if value is not None:
            reason = 'given for a structure; give over={"start.x0.0": (-1, 1), "start.v0.0": ...}'
            raise ParameterError(name, value, reason)
    if not isinstance(over, Mapping) or len(over) != 2:
        reason = 'not two axes, such as {"start.x0.0": (-1, 1), "start.v0.0": (-1, 1)}'
        raise ParameterError("over", over, reason)
    grid = make_grid(structure, cast("Loads", loads), start, over, VALUES, on)
    for axis in grid.axes:
        if not axis.of_start or axis.path == "start.t0":
            reason = "no displacement or velocity of the start; a basin is over two of these"
            raise ParameterError("over", axis.dimension, reason)
    if as_float(t0) == 0.0:
        return grid
    return replace(grid, start=replace(cast("StructureStart", grid.start), t0=t0))


def _grid(
    osc: Oscillator,
    force: Forcing,
    places: tuple[object, object],
    impacts: tuple[object, object],
    stop: int,
    t0: Phase,
) -> tuple[Grid, int | None]:
    """Return the grid of the starts, and the wall at which they lie, None elsewhere."""
    stop = whole("stop", stop, 0)
    if (places[0] is None) != (places[1] is None) or (impacts[0] is None) != (impacts[1] is None):
        raise ParameterError("x0", places[0], "give x0 and v0, or cycle and v")
    if (places[0] is None) == (impacts[0] is None):
        raise ParameterError("x0", places[0], "give either x0 and v0, or cycle and v")
    if places[0] is not None:
        over = {"start.x0": places[0], "start.v0": places[1]}
        return make_grid(osc, force, Start(0.0, 0.0, t0), over, VALUES), None
    if stop >= len(osc.stops) or not isinstance(osc.stops[stop], Wall):
        raise ParameterError("stop", stop, "the number of no wall; give x0 and v0")
    if isinstance(impacts[0], tuple) and len(impacts[0]) == 2 and as_float(impacts[0][1]) == 1.0:
        # The end of a whole cycle is its beginning.
        impacts = np.linspace(as_float(impacts[0][0]), 1.0, VALUES, endpoint=False), impacts[1]
    over = {"start.t0": impacts[0], "start.v0": impacts[1]}
    grid = make_grid(osc, force, Start(osc.stops[stop].at, 0.0), over, VALUES)
    for path, values, high in (
        ("cycle", grid.axes[0].values, 1.0),
        ("v", grid.axes[1].values, None),
    ):
        if values.min() < 0.0 or (high is not None and values.max() >= high):
            wrong = values.min() if values.min() < 0.0 else values.max()
            raise ParameterError(path, float(wrong), "outside [0, 1)" if high else "negative")
    return grid, stop


@dataclass(frozen=True, slots=True)
class AtWall:
    """Starts at a wall, from a grid of cycles and speeds away from the wall."""

    grid: Grid
    stop: int

    @property
    def size(self) -> int:
        """Number of starts."""
        return self.grid.size

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """Cycle and speed."""
        cycle, v = (tuple(axis.values.tolist()) for axis in self.grid.axes)
        return Dimension("cycle", cycle), Dimension("v", v, "length/time")

    def groups(self, first: int, last: int) -> tuple[list[AnyGroup], dict[int, str]]:
        """Return the starts from first to last, in groups of one shape of law."""
        groups, faults = self.grid.groups(first, last)
        sign = -1.0 if self.grid.osc.stops[self.stop].side == "above" else 1.0
        return [self._at_wall(group, sign) for group in groups], faults

    def _at_wall(self, group: AnyGroup, sign: float) -> AnyGroup:
        starts = group.starts.copy()
        starts[:, 2] *= group.periods
        starts[:, 1] *= sign
        return replace(group, starts=starts)


def fractions_of(labels: Integers, n_attractors: int) -> tuple[Floats, Floats, float, int]:
    """Return fractions and their errors, the undecided fraction, and the number of starts."""
    n = int((labels != NO_START).sum())
    counts = [int((labels == i).sum()) for i in range(n_attractors)]
    part = np.array([fraction_of(count, n) for count in counts]).reshape(-1, 2)
    return part[:, 0], part[:, 1], fraction_of(int((labels == -1).sum()), n)[0], n


def columns_of(attractor: Attractor | None) -> dict[str, float]:
    """Return the numbers of an attractor as a dataset holds them; NaN where there is none."""
    known = attractor or Attractor("")
    return {
        "n_periods": known.n_periods if attractor else math.nan,
        "n_impacts": known.n_impacts,
        "x": float(known.strobes[0, 0]),
        "v_strobe": float(known.strobes[0, 1]),
        "exponent": known.exponent,
        "exponent_error": known.error,
        "residual": known.residual,
    }


def start_ranges(start: object, x0: object, v0: object, t0: Phase) -> tuple[object, object, Phase]:
    """Return x0, v0 and t0, which may be given as one start.

    Raises
    ------
    ParameterError
        If both are given, or the start has neither two nor three parts.

    Examples
    --------
    >>> start_ranges(((-1, 1), 0.5), None, None, 0.0)
    ((-1, 1), [0.5], 0.0)
    """
    if start is None:
        return x0, v0, t0
    if x0 is not None or v0 is not None:
        raise ParameterError("start", start, "given together with x0 or v0; give one")
    if isinstance(start, Start):
        start = (start.x0, start.v0, start.t0)
    parts = tuple(start) if is_row(start) else ()
    if not 2 <= len(parts) <= 3:
        raise ParameterError("start", start, "not (x0, v0) or (x0, v0, t0), ranges or values")
    if len(parts) == 3 and t0 != 0.0:
        raise ParameterError("start", start, f"holds t0, given together with t0 = {t0}")
    lists = [part if _is_list(part) else [part] for part in parts[:2]]
    return lists[0], lists[1], parts[2] if len(parts) == 3 else t0


def _is_list(part: object) -> bool:
    return not isinstance(part, str) and hasattr(part, "__len__") and np.ndim(part) > 0  # type: ignore[arg-type]  # a list


# Forcing periods over which the measures of a chaotic attractor are taken.
CHAOTIC_PERIODS = 1000


def measures_of(system: AnyStrobed, attractor: Attractor, names: Sequence[str]) -> dict[str, float]:
    """Return measures of an attractor, NaN of unbounded motions."""
    if not names or attractor.kind == "unbounded":
        return dict.fromkeys(names, math.nan)
    # A motion shows its period once it has come again.
    known = 2 * attractor.n_periods if attractor.kind == "periodic" else 2
    window = Window(0, CHAOTIC_PERIODS if attractor.kind == "chaotic" else known)
    group = system.group(np.array([[*attractor.strobes[0], system.t0]]))
    values, _, _ = measure_group(names, group, window, MOST_IMPACTS)
    return {name: float(values[name][0]) for name in names}


def about_measure(name: str, osc: Oscillator | Structure) -> dict[str, str]:
    """Return the attributes of a measure's variable."""
    measure = MEASURES[name]
    return {"units": measure.dimensions_of(osc), "long_name": measure.meaning_for(osc)}


COLUMN_UNITS = {
    "x": "length",
    "v_strobe": "length/time",
    "exponent": "1/time",
    "exponent_error": "1/time",
}


def _dataset(
    starts: Grid | AtWall,
    system: AnyStrobed,
    answer: Answer,
    labels: Integers,
    attractors: Sequence[Attractor],
    measures: Sequence[str],
) -> Dataset:
    import xarray

    grid = starts.grid if isinstance(starts, AtWall) else starts
    dims = tuple(axis.name for axis in starts.dimensions)
    fraction, error, undecided, n = fractions_of(labels, len(attractors))
    data: dict[str, Any] = {
        "basin": (dims, labels.reshape(grid.shape)),
        "kind": ("attractor", np.array([attractor.kind for attractor in attractors], dtype=object)),
        "name": ("attractor", np.array([attractor.name for attractor in attractors], dtype=object)),
        "fraction": ("attractor", fraction),
        "fraction_error": ("attractor", error),
    }
    rows = [columns_of(attractor) for attractor in attractors]
    for name in columns_of(None):
        values = np.array([row[name] for row in rows], dtype=np.float64)
        if name == "n_periods":
            values = values.astype(np.int64)
        data[name] = ("attractor", values, {"units": COLUMN_UNITS.get(name, "1")})
    measured = [measures_of(system, attractor, measures) for attractor in attractors]
    for name in measures:
        values = np.array([row[name] for row in measured], dtype=np.float64)
        data[name] = ("attractor", values, about_measure(name, grid.osc))
    if isinstance(grid.osc, Structure):
        _set_coordinates(data, attractors, grid.osc.n)
    points = _points(starts, system, attractors)
    for i, (name, axis) in enumerate(zip(dims, starts.dimensions, strict=True)):
        short = name.removeprefix("start.")
        if grid.axes[i].along:
            continue
        data[f"attractor_{short}"] = (
            ("attractor", "point"), points[:, :, i], {"units": axis.units}
        )  # fmt: skip
    attrs = attributes_of(grid.motion(), answer) | {
        "failed": no_starts(answer), "undecided": undecided, "n_starts": n,
    }  # fmt: skip
    dataset = xarray.Dataset(data, coords=coordinates_of(starts.dimensions), attrs=attrs)
    return with_units(dataset, grid.osc.units)


def _set_coordinates(data: dict[str, Any], attractors: Sequence[Attractor], n: int) -> None:
    """Give the strobes of a structure's attractors by coordinate."""
    firsts = np.full((len(attractors), 2 * n), np.nan)
    for row, attractor in zip(firsts, attractors, strict=True):
        if attractor.strobes.shape[1] == 2 * n:
            row[:] = attractor.strobes[0]
    for name, part in (("x", firsts[:, :n]), ("v_strobe", firsts[:, n:])):
        data[name] = (("attractor", "coordinate"), part, {"units": COLUMN_UNITS[name]})


def _points(starts: Grid | AtWall, system: AnyStrobed, attractors: Sequence[Attractor]) -> Floats:
    """Return the attractors in the plane of the starts, NaN beyond their ends."""
    if isinstance(starts, AtWall) and isinstance(system, StrobedSystem):
        drawn = [
            np.empty((0, 2))
            if attractor.kind in ("rest", "unbounded")
            else impacts_at(system, starts.stop, attractor.strobes[0], attractor.orbit, DRAWN)
            for attractor in attractors
        ]
    else:
        grid = starts.grid if isinstance(starts, AtWall) else starts
        axes = [0 if a.along else grid.start_paths.index(a.path) for a in grid.axes]
        nowhere = np.full((1, 2), np.nan)
        drawn = [
            a.strobes[:, axes] if a.strobes.shape[1] > max(axes) else nowhere for a in attractors
        ]
    drawn = [part[:DRAWN] for part in drawn]
    points = np.full((len(attractors), max(map(len, drawn), default=0), 2), np.nan)
    for i, part in enumerate(drawn):
        points[i, : len(part)] = part
    return points
