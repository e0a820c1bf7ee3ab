"""A measure over any grid of parameters and starts."""

from __future__ import annotations

import inspect
import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.array_parts import part_dataset
from percuss.ensembles.batch import MOST_IMPACTS
from percuss.ensembles.datasets import (
    attributes_of,
    dataset_of,
    warn_of_failures,
    warn_of_some,
)
from percuss.ensembles.engines import Engine
from percuss.ensembles.fingerprint import fingerprint
from percuss.ensembles.grid import Axis, Grid, make_grid
from percuss.ensembles.job import Block, Column, Dimension, too_large
from percuss.ensembles.measures import MEASURES, STROBOSCOPIC, Window, measure_group
from percuss.ensembles.repetition import counting_period_of, is_free
from percuss.ensembles.run_job import execution_of, run_job
from percuss.ensembles.threads import check_wanted
from percuss.errors import ParameterError
from percuss.kernels import observables
from percuss.model.exact import Phase, as_float, two_of, whole
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import On, Oscillator
from percuss.model.periods import require_period
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.sections import PoincareSection, SectionGiven, section_of
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import beyond_record_of
from percuss.progress import Report
from percuss.wording import closest, counted

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

# Impacts of a compiled chunk, at about one a period: they take some tenths of a second, much longer
# than submitting and storing the chunk, and little memory. Making a law takes as long as 1000
# impacts.
IMPACTS_OF_A_CHUNK, OF_A_LAW = 2_000_000, 1000
# What an impact of a structure takes, in impacts of one mass: so much, and for each coordinate.
OF_A_STRUCTURE, OF_A_COORDINATE = 6, 4
LARGEST_CHUNK = 8192
# A study that would have more chunks than this, each with its own files, has larger chunks.
MOST_CHUNKS, LARGEST_OF_ALL = 20_000, 32_768
# Points of a chunk where a function of the user is called for each.
CALLS_OF_A_CHUNK = 16
# Characters shown of what a function has returned instead of a number.
LONGEST_TEXT = 60
# Values that are tested for NaN at a time.
LOOKED_AT = 1_000_000
# A table has one column of a name.
NO_STROBES = "without a forcing there are no strobes; give 'impacts' or {'at': 0.0}"
SAME_NAME = "the name of a measure that is asked for; give the parameter another name"


def sweep(
    measure: str | Callable[..., float] | Sequence[str],
    osc: Oscillator | Structure,
    force: Forcing | Loads | None = None,
    *,
    over: Mapping[str, object],
    paired: bool = False,
    on: On | None = None,
    start: Start | StructureStart | Sequence[Any] | None = None,
    transient: int = 200,
    periods: int = 64,
    between: Sequence[Phase] | None = None,
    section: SectionGiven = "stroboscopic",
    max_impacts: int = MOST_IMPACTS,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
    part: Sequence[int] | None = None,
) -> Dataset:
    """Measure every motion of a grid of parameters and starts.

    Parameters
    ----------
    measure
        One or several of "peak_displacement", "min_displacement", "max_displacement",
        "rms_displacement", "peak_impact_velocity", "peak_acceleration", "peak_stop_force",
        "contact_share", "mean_power", "impacts_per_period", "period", "dissipated_energy",
        "largest_lyapunov_exponent", "growth_exponent", which run compiled. Or a function: of a
        run, of (osc, force), or of (osc, force, start), that returns a number.
    osc, force
        The oscillator and its forcing, or a structure and its loads; ``over`` replaces some of
        their parameters.
    over
        The axes of the grid, by the dotted path of a parameter or of a number of the start: a
        range (low, high), which stands for 101 values, or the values themselves. Without axes,
        {}, there is one point.
    paired
        Whether the values of ``over`` are taken together, the first of each path, then the second
        of each, in place of all combinations: for random samples, or the rows of a table. The
        dimension is ``sample``, and the parameters are coordinates along it.
    on
        Of a structure the coordinate, direction or point whose displacement is measured: needed
        for measures of a displacement or an acceleration, and where "period" is found at a place,
        where there are several coordinates.
    start
        Where the motions start: a `Start`, or x0 [length], v0 [length/time] and where wanted
        t0 [time]; of a structure a `StructureStart`, or these with a number for each coordinate;
        default: at rest at 0.
    transient, periods
        Forcing periods that are left out, and that are measured after them; the run that a
        function is given holds both. Without a forcing time is counted in units of
        2 pi / sqrt(k), the period of free vibration.
    between
        Two instants (first, last) [time] between which is measured, in place of these: under an
        irregular sea, or any other forcing without a period.
    section
        Where the measure "period" is found, as `bifurcation_diagram` takes it; default: once a
        forcing period. Without a forcing, as of a limit cycle, it is "impacts" or a place such
        as ``{"at": 0.0, "direction": "up"}``, and the period is a time.
    max_impacts
        Impacts after which a motion is abandoned, >= 1.
    store
        Folder of a Zarr store: finished chunks in it are not computed again. An answer that memory
        cannot hold needs one, and is then read from its disk.
    engine
        "threads", "processes", the address of a Dask scheduler ("tcp://...") or a client of one.
    n_workers
        Threads or processes; default: the cores that this process may use.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called now and then, and ends the sweep by returning False.
    part
        Which part of a job array is computed, as (i, n) the i-th of n, from 1: into a store of its
        own beside ``store``, where `merge_parts` puts all of them together. The dataset has no
        data then, but the attributes `points`, those that are done, and `complete`.

    Returns
    -------
    xarray.Dataset
        A variable for each measure over one dimension for each path, as it was asked for, or over
        ``sample``. Points without an answer hold NaN, and `reason` over the dimension `failure`
        says why; `point` is their number in the grid, the last axis the fastest; the attribute
        `failed` counts them. The bits do not depend on the engine. As a table of pandas it is
        ``data.drop_dims("failure").to_dataframe()``.

    Warns
    -----
    UserWarning
        If a measure has no answer for any point, or some points have none: with their number, the
        parameters of the first, and the commonest reason and its count.

    Raises
    ------
    ParameterError
        If there is no such measure or path, an axis is empty or not finite, paired axes differ in
        length, or there is no room for the answer.
    EngineError
        If points kill three worker processes, or a cluster is lost.
    OutputError
        If the store is of another study or cannot be written.

    Examples
    --------
    >>> import percuss as pc
    >>> data = pc.sweep(
    ...     "period", pc.impact_oscillator(restitution=0.8), pc.cosine(2.5),
    ...     over={"forcing.omega": [2.5, 2.67, 2.8]}, start=(0.0, 1.0),
    ... )
    >>> data.period.values
    array([1., 2., 0.])

    Two settings of both parameters:

    >>> data = pc.sweep(
    ...     "period", pc.impact_oscillator(), pc.cosine(2.5), start=(0.0, 1.0), paired=True,
    ...     over={"forcing.omega": [2.5, 2.67], "oscillator.stops.0.restitution": [0.7, 0.8]},
    ... )
    >>> data.period.dims, data.period.values, data["forcing.omega"].values
    (('sample',), array([1., 2.]), array([2.5 , 2.67]))
    """
    execution = execution_of(store, engine, n_workers, progress, part)
    grid = make_grid(osc, force, start, over, on=on, paired=paired)
    window = Window(transient, periods, _span(between, grid, measure))
    work = _work(measure, grid, window, max_impacts, section_of(section))
    answer = run_job(work, execution, is_read_from_disk=True)
    if execution.part is not None:
        return part_dataset([answer], execution.part)
    nowhere = [name for name in work.names if not _has_any(answer.arrays[name])]
    if answer.complete and answer.reasons and not nowhere:
        first = grid.words(next(iter(answer.reasons)))
        warn_of_some("points", answer.reasons.values(), work.size, first)
    if nowhere and answer.complete:
        verb = "has" if len(nowhere) == 1 else "have"
        # A function of the user may return NaN without a reason.
        silent = ["it returned NaN"] * (work.size - len(answer.reasons))
        warn_of_failures(
            f"{' and '.join(nowhere)} {verb} no answer for any of {counted(work.size, 'point')}",
            [*answer.reasons.values(), *silent],
        )
    # The columns of its store are the whole result: no other file is needed.
    about = attributes_of(grid.motion(), answer)
    beyond = _beyond_record(grid, window)
    if beyond:
        about["record"] = beyond
    return dataset_of(work.dimensions, work.columns, answer, about)


def check_counted(force: Forcing | Loads | None, *, instead: str = "between=") -> None:
    """Raise a `ParameterError` if a forcing has no period in which time could be counted."""
    if force is not None and not is_free(force):
        why = "time is counted in forcing periods, and this forcing has none"
        require_period(force, why, instead=instead)


def span_of(between: object, t0: float, names: Sequence[str] = ()) -> tuple[float, float]:
    """Return the two instants between which motions from t0 are measured.

    Raises
    ------
    ParameterError
        If they are not two instants in order, after the start, or a measure of whole periods is
        asked for.

    Examples
    --------
    >>> span_of((0, "10*pi"), 0.0)
    (0.0, 31.41592653589793)
    """
    first, last = two_of(as_float, "between", between, "not two instants (first, last)")
    if not -math.inf < first < last < math.inf:
        raise ParameterError("between", between, "not two instants, the second after the first")
    if first < t0:
        raise ParameterError("between", between, f"begins before the start at t0 = {t0:.12g}")
    whole_periods = [name for name in names if MEASURES[name].counts_periods]
    if whole_periods:
        reason = "counted over whole periods; give transient and periods in place of between"
        raise ParameterError("measure", whole_periods[0], reason)
    return first, last


def _beyond_record(grid: Grid, window: Window) -> str:
    """Return what acts beyond the samples of a record, if motions are followed so far."""
    if window.between is None:
        return ""
    return beyond_record_of(grid.force, float(as_float(grid.start.t0)), window.between[1])


def _span(between: object, grid: Grid, measure: object) -> tuple[float, float] | None:
    if between is None:
        return None
    starts = [axis.values.max() for axis in grid.axes if axis.path == "start.t0"]
    names = () if callable(measure) else named_measures(measure, (), "measure")
    return span_of(between, float(max([as_float(grid.start.t0), *starts])), names)


def named_measures(
    given: object, axes: Sequence[Axis] = (), name: str = "measures"
) -> tuple[str, ...]:
    """Return the built-in measures of a list of names, or of one name.

    Raises
    ------
    ParameterError
        If there is no such measure, or one has the name of an axis.
    """
    if isinstance(given, str) or not hasattr(given, "__iter__"):
        given = (given,)
    names: list[str] = []
    for each in given:
        if callable(each):
            own = getattr(each, "__name__", repr(each))
            raise ParameterError(name, own, "one function at a time; a list holds names")
        if not isinstance(each, str) or each not in MEASURES:
            functions = ", and no function" if name == "measure" else ""
            raise ParameterError(name, each, _no_measure(each, functions))
        names.append(each)
    for axis in axes:
        if axis.dimension in names:
            raise ParameterError("over", axis.dimension, SAME_NAME)
    return tuple(names)


def _has_any(values: NDArray[np.generic]) -> bool:
    """Return whether any value, of possibly more than memory holds, is a number."""
    parts = range(0, len(values), LOOKED_AT)
    return any(not np.isnan(values[i : i + LOOKED_AT]).all() for i in parts)


def _work(
    measure: str | Callable[..., float] | Sequence[str],
    grid: Grid,
    window: Window,
    max_impacts: int,
    section: PoincareSection,
) -> Measured | Called:
    max_impacts = whole("max_impacts", max_impacts, 1)
    if callable(measure):
        return Called(grid, measure, window)
    names = named_measures(measure, grid.axes, "measure")
    if not names:
        raise ParameterError("measure", (), f"none at all; there are {', '.join(MEASURES)}")
    if isinstance(grid.osc, Structure):
        check_structure(names, grid)
    if window.between is None:
        check_counted(grid.force)
    needs_period = any(MEASURES[name].needs_strobes for name in names)
    if needs_period and is_free(grid.force) and section.kind == "stroboscopic":
        raise ParameterError("section", section.given, NO_STROBES)
    if needs_period and isinstance(grid.osc, Structure) and section.kind == "passages":
        _check_direction(grid)
    if needs_period:
        # Those of one motion at least are in memory at once.
        problem = too_large([1], observables.POINT_COLUMNS * (window.periods + 1))
        if problem is not None:
            reason = f"a period is found from a strobe in each; {problem}"
            raise ParameterError("periods", window.periods, reason)
    return Measured(grid, names, window, max_impacts, section)


def cost_of(osc: Oscillator | Structure) -> int:
    """Return about how many impacts of one mass one impact takes as long as.

    Examples
    --------
    >>> from percuss.model import impact_pair
    >>> cost_of(Oscillator()), cost_of(impact_pair([1, 1], gap=1))
    (1, 14)
    """
    return OF_A_STRUCTURE + OF_A_COORDINATE * osc.n if isinstance(osc, Structure) else 1


def _no_measure(name: object, functions: str) -> str:
    """Return what was meant: a measure like it, or one of a coordinate as `design` calls it."""
    measure, _, on = str(name).rpartition("_")
    if measure in MEASURES and MEASURES[measure].of_displacement:
        return f'no measure; write "{measure}" and on={on if on.isdecimal() else repr(on)}'
    alike = closest(str(name), MEASURES)
    return (
        f"none of {', '.join(MEASURES)}{functions}" if alike is None else f"did you mean {alike}?"
    )


def check_structure(names: Sequence[str], grid: Grid) -> None:
    """Raise unless a structure has these measures, of the displacement that was given."""
    for name in names:
        if not MEASURES[name].of_structures:
            known = ", ".join(name for name, measure in MEASURES.items() if measure.of_structures)
            raise ParameterError("measure", name, f"not for structures; there are {known}")
        if MEASURES[name].of_displacement:
            _check_direction(grid)


def _check_direction(grid: Grid) -> None:
    if not grid.on:
        # The sentence that says of what the displacement may be.
        cast("Structure", grid.osc).direction(None)


@dataclass(frozen=True, slots=True)
class OverGrid:
    """The grid whose points the jobs of a sweep share."""

    grid: Grid

    @property
    def size(self) -> int:
        """Number of points."""
        return self.grid.size

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes of the grid."""
        return self.grid.dimensions


@dataclass(frozen=True, slots=True)
class Measured(OverGrid):
    """The job of built-in measures."""

    names: tuple[str, ...]
    window: Window
    max_impacts: int
    section: PoincareSection = STROBOSCOPIC

    @property
    def chunk(self) -> int:
        """Points of a chunk."""
        followed = self.window.transient + self.window.periods
        each = followed + OF_A_LAW * self.grid.n_laws // self.size
        each *= cost_of(self.grid.osc)
        usual = min(LARGEST_CHUNK, max(1, IMPACTS_OF_A_CHUNK // each))
        return min(max(usual, self.size // MOST_CHUNKS), max(usual, LARGEST_OF_ALL))

    @property
    def columns(self) -> dict[str, Column]:
        """One number for each measure."""
        free = self.grid.force is None or self.grid.force.period is None
        return {
            name: Column(
                units=MEASURES[name].unit_of(self.grid.osc, free=free),
                meaning=MEASURES[name].meaning_for(self.grid.osc, free=free),
            )
            for name in self.names
        }

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        return self.grid.identity() | {
            "kind": "sweep",
            "measure": list(self.names),
            "transient": self.window.transient,
            "periods": self.window.periods,
            **({} if self.window.between is None else {"between": repr(self.window.between)}),
            "max_impacts": self.max_impacts,
            **({} if self.section.label == "stroboscopic" else {"section": self.section.label}),
        }

    def compute(self, first: int, last: int) -> Block:
        """Measure the points of a chunk."""
        groups, faults = self.grid.groups(first, last)
        block = Block({name: Column().empty(last - first) for name in self.names}, dict(faults))
        for group in groups:
            values, reasons, count = measure_group(
                self.names, group, self.window, self.max_impacts, self.section
            )
            for name in self.names:
                block.arrays[name][group.rows] = values[name]
            block.reasons |= {int(group.rows[i]): text for i, text in reasons.items()}
            block.n_impacts += count
        return block


@dataclass(frozen=True, slots=True)
class Called(OverGrid):
    """The job of a measure that is a function of the user."""

    measure: Callable[..., float]
    window: Window

    @property
    def names(self) -> tuple[str, ...]:
        """The function's name."""
        name = getattr(self.measure, "__name__", "measure")
        return ("measure" if name == "<lambda>" else name,)

    @property
    def chunk(self) -> int:
        """Points of a chunk."""
        return CALLS_OF_A_CHUNK

    @property
    def columns(self) -> dict[str, Column]:
        """One number."""
        return {self.names[0]: Column(units="")}

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others; of the function its fingerprint."""
        return self.grid.identity() | {
            "kind": "sweep",
            "measure": [getattr(self.measure, "__qualname__", repr(type(self.measure)))],
            "transient": self.window.transient,
            "periods": self.window.periods,
            **({} if self.window.between is None else {"between": repr(self.window.between)}),
            **fingerprint(self.measure),
        }

    def compute(self, first: int, last: int) -> Block:
        """Call the function for each point; what it raises is the reason of that point."""
        values = np.full(last - first, np.nan)
        block = Block({self.names[0]: values})
        for i in range(first, last):
            check_wanted()
            try:
                values[i - first] = _number(self.names[0], self._call(*self.grid.point(i)))
            except ParameterError as error:
                block.reasons[i - first] = str(error)
            except Exception:  # noqa: BLE001  a function of the user may raise anything
                block.reasons[i - first] = traceback.format_exc()
        return block

    def _call(self, osc: Any, force: Any, start: Start | StructureStart) -> Any:
        count = _positional(self.measure)
        if count >= 3:
            return self.measure(osc, force, start)
        if count == 2:
            return self.measure(osc, force)
        begin: tuple[Any, ...] = (start.x0, start.v0, start.t0)
        if self.window.between is not None:
            return self.measure(simulate(osc, force, *begin, t_end=self.window.between[1]))
        check_counted(force)
        length = (self.window.transient + self.window.periods) * counting_period_of(osc, force)
        t_end = float(start.t0) + length
        return self.measure(simulate(osc, force, *begin, t_end=t_end))


def _number(name: str, value: Any) -> float:
    """Return the answer of a measure as a number."""
    try:
        if not isinstance(value, str | bytes):
            return float(value)
    except (TypeError, ValueError):
        pass
    text = " ".join(repr(value).split())
    text = text if len(text) <= LONGEST_TEXT else f"{text[:LONGEST_TEXT]}..."
    raise ParameterError("measure", name, f"returned {text}, which is no number")


def _positional(function: Callable[..., float]) -> int:
    """Return the number of positional arguments that a function needs."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    parameters = inspect.signature(function).parameters.values()
    return sum(p.kind in kinds and p.default is p.empty for p in parameters)
