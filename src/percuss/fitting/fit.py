"""The fit of a model to measurements of its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from os import PathLike
from typing import Any, Literal

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.fitting.kept_search import KeptSearch, file_of
from percuss.fitting.losses import Loss, LossName
from percuss.fitting.measured import (
    IMPACT_TIMES,
    MeasuredRecord,
    read_samples,
)
from percuss.fitting.noise import check_noise
from percuss.fitting.plausibility import beyond_force, check_plausible, too_coarse
from percuss.fitting.result import Fit, result_of
from percuss.fitting.search import FitSearch
from percuss.fitting.solver import FitProblem
from percuss.kernels.segments import OF_STOP
from percuss.model.exact import Exact, as_float, real
from percuss.model.faults import check_mapping, raise_first
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.paths import long_form, replace_parameters
from percuss.model.start import Start, start_of, wall_faults
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart, structure_start
from percuss.model.system import System
from percuss.progress import Progress, Report
from percuss.wording import counted

MOST_RUNS = 300


def fit(
    data: Any,
    osc: Oscillator | Structure,
    force: Forcing | Loads | Mapping[Any, Any] | Sequence[Any] | None = None,
    *,
    free: Mapping[str, Exact | tuple[Exact, Exact]],
    start: Literal["free"] | Start | StructureStart | Sequence[Any] = "free",
    noise: Any = None,
    columns: Mapping[str, str] | None = None,
    prior: Mapping[str, tuple[Exact, Exact]] | None = None,
    loss: LossName = "linear",
    loss_scale: float = 1.0,
    resume: Fit | None = None,
    store: str | PathLike[str] | None = None,
    progress: Report = None,
) -> Fit:
    """Fit parameters of an oscillator or a structure to measurements of its motion.

    Multiple shooting: the record is cut at nodes whose states are unknowns beside the parameters,
    so that chaos does not lead a search astray. Gauss-Newton's steps have derivatives exact to
    rounding, through all impacts; events may come, go and change their order on the way.

    Parameters
    ----------
    data
        Samples of `displacement`, `velocity`, `acceleration` or `stop_force` (`stop_force_1` for
        the second stop) at instants `t`: an xarray.Dataset or DataArray, a pandas.DataFrame, a
        mapping of arrays, or the path of a CSV file with these names, or `time`, `x`, `v`, `a`, and
        perhaps units, which are converted into those of the oscillator; instants need not be even,
        nor in order, and NaN are left out. A `stop_force` is that on the mass: of a stop above it
        is negative. Or `impact_times` alone, or beside them. Of a structure
        `acceleration_2` is that of a coordinate, `acceleration_tip` of a point. A list of these:
        several records.
    osc, force
        The oscillator and its forcing, or a structure and its loads, which give all other
        parameters; a list of forcings for several records.
    free
        The parameters by their paths, those of a given start and names in expressions too: a range
        (least, largest), in which the guess is looked for, or a guess.
    start
        "free": the state at the first sample is unknown too; else the start, as `simulate` takes
        it, or a list of starts.
    noise
        Standard deviation of the data: a number, an array, or a mapping of these by quantity;
        without it that of `attrs["noise"]`, and else estimated from the residuals. In the units of
        the model, into which columns of a file are converted.
    columns
        Names of the columns of a file by quantity, such as ``{"t": "Clock", "displacement":
        "Laser 2"}``, with their units or without; quantities that are not named keep their own
        names, and "" leaves one out.
    prior
        Mean and standard deviation of parameters, from what was known before.
    loss, loss_scale
        As `scipy.optimize.least_squares` has it: "linear", "soft_l1", "huber", "cauchy" or
        "arctan", and the residual in standard deviations beyond which it counts less.
    resume
        A fit of the same data and parameters to go on from, such as one that was stopped: the
        search begins with its values and nodes.
    store
        A file, such as "rig.fit", in which the search keeps where it is: interrupted, even killed,
        the same call goes on from there.
    progress
        True shows a line on the error stream after two seconds; a function ``(done, total) ->
        bool`` is called after each step, and ends the search by returning False.

    Returns
    -------
    Fit
        The parameters with their errors; where the search did not converge the best ones, with the
        reason.

    Raises
    ------
    ParameterError
        If data, ranges or start are not as described, there are fewer values than unknowns, samples
        lie before the start, or are all the same, forces of stops have the wrong sign, or there is
        less than a sample in two periods of the force; and for impact times alone of a structure.
    OutputError
        If the store cannot be written, or holds something else.

    Examples
    --------
    The gap and the restitution of a rig, from its motion with some noise:

    >>> import numpy as np
    >>> import percuss as pc
    >>> rig = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    >>> t = np.linspace(0, 60, 800)
    >>> x, v = pc.simulate(rig, pc.cosine(2), v0=0.5, t_end=60)(t)
    >>> x += 0.01 * np.random.default_rng(1).standard_normal(800)
    >>> model = pc.impact_oscillator("0.6", wall="0.3", side="above", damping="0.05")
    >>> pc.fit(
    ...     {"t": t, "displacement": x}, model, pc.cosine(2), noise=0.01,
    ...     free={"oscillator.stops.0.at": 0.3, "oscillator.stops.0.restitution": 0.6},
    ... )
    <Fit: oscillator.stops.0.at = 0.19995 ± 0.00011, oscillator.stops.0.restitution = 0.80007 ± \
0.00012; chi2 0.966>
    """
    records = _records(data, osc, force, start, (noise, columns))
    names, low, high, ranged = _box(osc, records, free)
    _check_starts(osc, records, names, np.where(ranged, [low, high], [*names.values()]))
    priors = _priors(osc, records, prior, names)
    _check_count(osc, records, names)
    _check_walls(osc, records, names)
    check_noise(osc, records)
    check_plausible(osc, records)
    line = Progress(progress, MOST_RUNS, "runs", is_bound=True)
    kept = None if store is None else KeptSearch(file_of(store), osc, records, tuple(names))
    before = None if resume is None else _before(resume, records, names)
    if before is None and kept is not None:
        before = _begun(kept, names)
    search = FitSearch(
        osc, records, names, low, high, ranged, priors, Loss(loss, loss_scale), line, before,
        None if kept is None else kept.keep,
        {long_form(path, osc, records[0].force, records[0].start): path for path in free},
    )  # fmt: skip
    try:
        best = search.best()
        if best.reason and not line.is_stopped and (turned := search.turned()) is not None:
            other = turned.best()
            if not other.reason:
                search, best = turned, other
        reason = best.reason or too_coarse(records)
        if reason and not line.is_stopped and (beyond := beyond_force(records)):
            reason = f"{reason}; {beyond}"
        best = replace(best, reason=reason)
        if kept is not None:
            kept.write(best.problem, best.descent.point)
        return result_of(search, best)
    finally:
        line.close()


def _records(
    data: Any,
    osc: Oscillator | Structure,
    force: Any,
    start: Any,
    told: tuple[Any, Mapping[str, str] | None],
) -> list[MeasuredRecord]:
    """Return the records, checked; ``told`` are their noise and the names of columns."""
    noise, columns = told
    several = isinstance(data, Sequence) and not isinstance(data, str)
    whole = list(data) if several else [data]
    if not whole:
        raise ParameterError("data", data, "no record")
    n = len(whole)
    forces = list(force) if isinstance(force, Sequence) else [force] * n
    starts = [start] * n
    if several and isinstance(start, Sequence) and not isinstance(start, str):
        is_list = len(start) > 0 and isinstance(start[0], Start | Sequence)
        if isinstance(osc, Structure):
            # A start of two lists is one start; a list of starts has one for each record.
            is_list = isinstance(start, list)
        starts = list(start) if is_list else starts
    for name, some in (("force", forces), ("start", starts)):
        if len(some) != n:
            raise ParameterError(name, len(some), f"of {n} records")
    records = []
    for its_data, given_force, its_start in zip(whole, forces, starts, strict=True):
        its_force = loads_of(osc, given_force) if isinstance(osc, Structure) else given_force
        if not isinstance(osc, Structure):
            System.of(osc, its_force)
        samples, impacts = read_samples(its_data, noise, osc, columns)
        is_free = its_start is None or _is_free(its_start)
        begin: Start | StructureStart | None = None
        if isinstance(osc, Structure):
            begin = None if is_free else structure_start(replace(osc, stops=()), its_start)
            if not len(samples):
                reason = "alone say too little of a structure; give samples beside them"
                raise ParameterError("data", IMPACT_TIMES, reason)
        else:
            begin = None if is_free else start_of(its_start)
        record = MeasuredRecord(samples, impacts, its_force, begin)
        if begin is not None and record.begin < as_float(begin.t0):
            reason = f"before the start at t0 = {begin.t0}"
            raise ParameterError("data.t", record.begin, reason)
        records.append(record)
    return records


def _check_starts(
    osc: Oscillator | Structure,
    records: Sequence[MeasuredRecord],
    names: Mapping[str, float],
    ends: Floats,
) -> None:
    """Refuse a start inside a wall; one whose place is free is where it leaves the most room."""
    free = {name.partition(".")[2]: ends[:, k].tolist() for k, name in enumerate(names)}
    stops = []
    for i, stop in enumerate(osc.stops):
        places = free.get(f"stops.{i}.at")
        far = 1 if stop.side == "above" else 0
        stops.append(stop if places is None else replace(stop, at=places[far]))
    placed = replace(osc, stops=tuple(stops))
    for record in records:
        if isinstance(placed, Structure) and record.start is not None:
            structure_start(placed, record.start)
        elif isinstance(placed, Oscillator) and isinstance(record.start, Start):
            raise_first(wall_faults(placed, "start.x0", record.start.x0))


def _check_walls(
    osc: Oscillator | Structure, records: Sequence[MeasuredRecord], names: Mapping[str, float]
) -> None:
    """Refuse a restitution where the forces of rigid walls are all that was measured."""
    rigid = [OF_STOP + i for i, stop in enumerate(osc.stops) if isinstance(stop, Wall)]
    bouncing = [name for name in names if ".restitution" in name]
    for record in records:
        is_alone = len(record.samples) and np.isin(record.samples.kinds, rigid).all()
        if len(record.impacts) or not is_alone or not bouncing:
            return
    reason = (
        "not told by the force of a rigid wall alone, which is zero in flight, and whose impulses "
        "lie between the samples; give a motion or impact_times beside it"
    )
    raise ParameterError("free", bouncing[0], reason)


def _is_free(start: object) -> bool:
    if isinstance(start, str) and start != "free":
        raise ParameterError("start", start, 'neither "free" nor a start')
    return isinstance(start, str)


def _box(
    osc: Oscillator | Structure, records: Sequence[MeasuredRecord], free: Mapping[str, Any]
) -> tuple[dict[str, float], Floats, Floats, Flags]:
    """Return guesses by long paths, their bounds, and which are ranges."""
    if not free:
        reason = 'no parameter; give one as {"oscillator.damping": 0.1}'
        raise ParameterError("free", free, reason)
    check_mapping("free", free, "{path: (least, largest)} or {path: guess}")
    first = records[0]
    guesses: dict[str, float] = {}
    low, high, ranged = [], [], []
    for path, given in free.items():
        if path.startswith("start.") and first.start is None:
            raise ParameterError("free", path, 'of a start that is free as a whole: start="free"')
        name = long_form(path, osc, first.force, first.start)
        if name in guesses:
            raise ParameterError("free", path, "the same parameter, named twice")
        is_range = isinstance(given, Sequence) and not isinstance(given, str)
        ends = [real(f"free.{path}", end) for end in (given if is_range else (given,))]
        if is_range and (len(ends) != 2 or not ends[0] < ends[1]):
            raise ParameterError(f"free.{path}", given, "not a range (least, largest)")
        for end in ends:
            _check_value(osc, records, path, name, end)
        natural = _natural_bounds(osc, first, name)
        low.append(max(ends[0], natural[0]) if is_range else natural[0])
        high.append(min(ends[-1], natural[1]) if is_range else natural[1])
        guesses[name] = 0.5 * (low[-1] + high[-1]) if is_range else ends[0]
        ranged.append(is_range)
    return guesses, np.array(low), np.array(high), np.array(ranged)


def _check_value(
    osc: Oscillator | Structure,
    records: Sequence[MeasuredRecord],
    path: str,
    name: str,
    value: float,
) -> None:
    """Refuse a guess, or an end of a range, that the model does not allow."""
    for record in records:
        try:
            replace_parameters(osc, record.force, record.start, {name: value})
        except ParameterError as error:
            reason = f"the model does not allow it: {error}"
            raise ParameterError(f"free.{path}", value, reason) from None


def _natural_bounds(
    osc: Oscillator | Structure, record: MeasuredRecord, name: str
) -> tuple[float, float]:
    """Return the values that a parameter can have: a wall's not beyond the start, and the like."""
    if ".restitution" in name and ".speeds" not in name:
        return 0.0, 1.0
    for i, stop in enumerate(osc.stops):
        own = f"{'structure' if isinstance(osc, Structure) else 'oscillator'}.stops.{i}."
        if name == f"{own}at" and isinstance(stop, Wall) and record.start is not None:
            if isinstance(record.start, StructureStart):
                c = osc.stop_directions[i]  # type: ignore[union-attr]
                x0 = float((c * record.start.x).sum())
            else:
                x0 = as_float(record.start.x0)
            return (x0, np.inf) if stop.side == "above" else (-np.inf, x0)
        if name in (f"{own}stiffness", f"{own}damping"):
            return 0.0, np.inf
    return (0.0, np.inf) if name == "oscillator.mass" else (-np.inf, np.inf)


def _priors(
    osc: Oscillator | Structure,
    records: Sequence[MeasuredRecord],
    prior: Mapping[str, Any] | None,
    names: Any,
) -> Floats:
    """Return the priors as rows of the parameter's number, its mean and its deviation."""
    rows = []
    check_mapping("prior", prior or {}, "{path: (mean, standard deviation)}")
    for path, given in (prior or {}).items():
        name = long_form(path, osc, records[0].force, records[0].start)
        if name not in names:
            raise ParameterError("prior", path, "none of the free parameters")
        if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
            raise ParameterError(f"prior.{path}", given, "not (mean, standard deviation)")
        mean, sigma = (real(f"prior.{path}", value) for value in given)
        if not sigma > 0.0:
            raise ParameterError(f"prior.{path}", sigma, "a standard deviation not above 0")
        rows.append((list(names).index(name), mean, sigma))
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _before(
    resume: Fit, records: Sequence[MeasuredRecord], names: dict[str, float]
) -> tuple[FitProblem, Floats]:
    """Return where a fit ended, with its values as guesses, if it is one of these data."""
    if list(resume.values) != list(names):
        reason = f"a fit of {', '.join(resume.values)}, not of {', '.join(names)}"
        raise ParameterError("resume", repr(resume), reason)
    old = [layout.record for layout in resume.problem.layouts]
    for given, before in zip_longest(records, old):
        record = given
        if record is not None and record.start is None and not len(record.samples):
            # The first impact of a motion whose start is unknown is that start.
            record = replace(record, impacts=record.impacts.taken(slice(1, None)))
        if record is None or before is None or not record.is_same_motion(before):
            raise ParameterError("resume", repr(resume), "a fit of other data")
    names.update(resume.values)
    return resume.problem, resume.nodes[:, 1:].copy()


def _begun(kept: KeptSearch, names: dict[str, float]) -> tuple[FitProblem, Floats] | None:
    """Return where the search in a store is, with its values as guesses, if there is one."""
    begun = kept.begun()
    if begun is None:
        return None
    problem, nodes, values = begun
    names.update(values)
    return problem, nodes


def _check_count(
    osc: Oscillator | Structure, records: Sequence[MeasuredRecord], names: Any
) -> None:
    """Refuse fewer values than unknowns."""
    count = sum(len(record) for record in records)
    of_start = 2 * osc.n if isinstance(osc, Structure) else 2
    unknowns = len(names) + sum(of_start for record in records if record.start is None)
    if count < unknowns:
        each = "two" if of_start == 2 else f"{of_start}"
        values = f"{counted(count, 'value')} for {counted(unknowns, 'unknown')}"
        starts = sum(record.start is None for record in records)
        reason = f"{values}; a free start has {each}" if starts else values
        raise ParameterError("data", count, reason)
