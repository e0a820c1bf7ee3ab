"""The settings at which an outcome is least, largest, or as wanted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, cast, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import Exact, Phase, as_float, real, whole
from percuss.model.faults import check_mapping
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads, loads_of
from percuss.model.oscillator import Oscillator
from percuss.model.paths import get_parameter, long_form, replace_parameters
from percuss.model.periods import require_period
from percuss.model.start import Start, start_of
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart, structure_start
from percuss.model.system import System
from percuss.motion.simulate import run_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.optimization.outcomes import AnyOrbit, AnySensitivity, OutcomeName, check_outcome
from percuss.optimization.search import (
    MET,
    MOST_MOTIONS,
    DesignSearch,
    Goal,
    OutcomeLimits,
    SearchEnd,
    Trials,
    Wanted,
)
from percuss.optimization.trials import OnOrbit, OnRun, OnStructureOrbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.pictures import HasPicture
from percuss.progress import Progress, Report
from percuss.wording import counted

# Parameters whose values are right or wrong whatever the others are.
OWN_LIMITS = (".restitution", ".stiffness", ".damping", ".mass")
# More searches than anybody waits for.
MOST_RESTARTS = 100_000


@dataclass(frozen=True, slots=True)
class Attempt:
    """One search of a design.

    Attributes
    ----------
    values, value
        The parameters where it ended, and the outcome there.
    reason
        Why that is no optimum; empty if it is one.
    """

    values: dict[str, float]
    value: float
    reason: str


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Design(HasPicture):
    """The best setting that was found; made by `design`.

    Attributes
    ----------
    outcome, goal
        The outcome that was asked for, and the goal.
    value
        The outcome there.
    values
        The free parameters, by their long paths.
    bounds
        Their ranges.
    outcomes, limits
        The outcomes with limits, and these: the least and the largest value, None for no limit.
    active
        The paths and the outcomes that are at an end of their ranges.
    gradient
        (n_parameters,) array, the derivatives of the outcome.
    oscillator, forcing, start
        The model at this setting, of a structure with its loads; the start of a run.
    orbit, run
        The orbit, None for a run; and the run, of an orbit one period.
    derivative
        The derivative of the orbit or the run by the free parameters.
    converged, reason
        Whether it is an optimum that keeps all limits, and why not.
    attempts
        All searches, the best first.
    n_settings, n_begun
        How many settings were tried to begin from, and at how many of them there was a motion.
    n_motions
        How many motions were computed.
    """

    picture: ClassVar = "plot_design"

    outcome: str
    goal: Goal
    value: float
    values: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    outcomes: dict[str, float]
    limits: dict[str, OutcomeLimits]
    active: tuple[str, ...]
    gradient: Floats
    oscillator: Oscillator | Structure
    forcing: Forcing | Loads | None
    start: Start | StructureStart | None
    orbit: AnyOrbit | None
    run: Trajectory | StructureTrajectory
    derivative: AnySensitivity
    converged: bool
    reason: str
    attempts: tuple[Attempt, ...]
    n_settings: int
    n_begun: int
    n_motions: int

    def __repr__(self) -> str:
        """Return setting and outcome in a line."""
        where = ", ".join(f"{path} = {value:.6g}" for path, value in self.values.items())
        ends = f"; {self.reason}" if self.reason else ""
        few = f"; begun at {self.begun}" if self.n_begun < self.n_settings else ""
        return f"<Design: {self.outcome} {self.value:.6g} at {where}{ends}{few}>"

    @property
    def begun(self) -> str:
        """At how many of the settings there was a motion to begin with, in words."""
        return f"{self.n_begun} of {counted(self.n_settings, 'setting')}"


def design(
    outcome: OutcomeName | str,
    osc: Oscillator | Structure,
    force: Forcing | Loads | Mapping[Any, Forcing] | None = None,
    *,
    free: Mapping[str, tuple[Exact, Exact]],
    goal: Literal["least", "largest"] | Exact = "least",
    subject_to: Mapping[Any, tuple[Exact | None, Exact | None]] | None = None,
    on: Literal["orbit", "run"] | AnyOrbit = "orbit",
    start: Start | StructureStart | Sequence[Any] | None = None,
    t_end: Phase | None = None,
    periods: Exact | None = None,
    max_impacts: int | None = None,
    restarts: int = 4,
    seed: int = 0,
    progress: Report = None,
) -> Design:
    """Find the setting of free parameters at which an outcome is least, largest, or as wanted.

    SciPy's SLSQP searches with derivatives exact to rounding, from the given setting and from
    others in the box, and on each attractor that is found there. At a setting where the attractor
    ends, the next one is taken.

    Parameters
    ----------
    outcome
        A measure as `Sensitivity.of` takes it; of orbits "period" [time], "multiplier" (the
        largest modulus) and "grazing_margin" [length] too. Of a structure "max_displacement_2" and
        the like are of a coordinate, "max_displacement_tip" of a point; it has no grazing margin.
    osc, force
        The oscillator and its forcing, or a structure and its loads, which give all other
        parameters, and the first setting.
    free
        The free parameters and their ranges; paths of the start too where it is of a run, and
        names of parameters in expressions.
    goal
        "least", "largest", or a value: then the setting next to the given one that has it, in
        units of the ranges.
    subject_to
        Least and largest values of other outcomes, None for no limit.
    on
        "orbit": one period of an attracting orbit; an orbit: that with the same events, stable
        or not; "run": a motion from a start.
    start, t_end, periods, max_impacts
        Start and limits of the run, as `simulate` takes them.
    restarts
        Settings from which searches begin beside the given one, and motions at each of them that
        settle on attractors, >= 0.
    seed
        Of the restarts.
    progress
        True shows a line on the error stream after two seconds; a function ``(done, total) ->
        bool`` is called after each motion, and ends the search by returning False.

    Returns
    -------
    Design
        The best one that keeps all limits; if there is none the nearest, with the reason.

    Raises
    ------
    ParameterError
        If there is no such outcome or parameter, a range has no two ends in order, or the run is
        not one that `simulate` follows.
    ConvergenceError
        If no motion is found from which to begin.
    MissingExtraError
        If SciPy is missing.

    Examples
    --------
    The place of a wall at which an orbit meets it fastest:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    >>> best = pc.design(
    ...     "peak_impact_velocity", osc, pc.cosine(2), goal="largest", restarts=0,
    ...     free={"oscillator.stops.0.at": (-0.3, 0.3)},
    ... )
    >>> best
    <Design: peak_impact_velocity 3.90248 at oscillator.stops.0.at = -0.00686677>
    """
    on_orbit = on != "run"
    if not isinstance(on, PeriodicOrbit | StructureOrbit) and on not in ("orbit", "run"):
        raise ParameterError("on", on, 'neither "orbit" nor "run", nor an orbit')
    model, own_force = _model(osc, force)
    begin: Start | StructureStart | None = None
    if on_orbit:
        _refuse_limits(start, t_end, periods, max_impacts)
        trials = _on_orbit(model, own_force, on)
    else:
        begin = structure_start(model, start) if isinstance(model, Structure) else start_of(start)
        limits: dict[str, Any] = {"t_end": t_end, "periods": periods, "max_impacts": max_impacts}
        run_of(model, own_force, begin, **limits)
        trials = OnRun(model, own_force, begin, limits)
    wanted = _wanted(outcome, goal, subject_to or {}, model, of_orbit=on_orbit)
    box = _box((model, own_force), begin, free)
    restarts = whole("restarts", restarts, 0, MOST_RESTARTS)
    seed = whole("seed", seed, 0, math.inf)
    given = {path: as_float(get_parameter(model, own_force, begin, path)) for path in box}
    line = Progress(progress, MOST_MOTIONS * (restarts + 1), "motions", is_bound=True)
    try:
        return _best(DesignSearch(trials, wanted, box, given, line), restarts, seed)
    finally:
        line.close()


def _model(osc: Any, force: Any) -> tuple[Oscillator | Structure, Forcing | Loads | None]:
    """Return the model and the force on it, checked."""
    if isinstance(osc, Structure):
        loads = loads_of(osc, force)
        StructureSystem.of(osc, loads)
        return osc, loads
    return tuple(System.of(osc, force))  # type: ignore[return-value]


def _on_orbit(model: Oscillator | Structure, force: Forcing | Loads | None, on: Any) -> Trials:
    """Return the trials of attracting orbits, or of one that was given."""
    if isinstance(model, Structure):
        assert isinstance(force, Loads)
        if isinstance(on, PeriodicOrbit):
            raise ParameterError("on", on, "an orbit of an oscillator, not of this structure")
        require_period(force, "a periodic orbit needs loads of one period")
        return OnStructureOrbit(model, force, on if isinstance(on, StructureOrbit) else None)
    if isinstance(on, StructureOrbit):
        raise ParameterError("on", on, "an orbit of a structure, not of this oscillator")
    assert not isinstance(force, Loads)
    return OnOrbit(System(model, force), on if isinstance(on, PeriodicOrbit) else None)


def _refuse_limits(*given: object) -> None:
    for name, value in zip(("start", "t_end", "periods", "max_impacts"), given, strict=True):
        if value is not None:
            raise ParameterError(name, value, 'that of a run, which on="run" asks for')


def _wanted(
    outcome: str,
    goal: Any,
    subject_to: Mapping[Any, tuple[Any, Any]],
    model: Oscillator | Structure,
    *,
    of_orbit: bool,
) -> Wanted:
    """Return what is wanted, checked."""
    check_outcome(outcome, model, of_orbit=of_orbit)
    if isinstance(goal, str) and goal in get_args(Literal["least", "largest"]):
        aim = cast("Goal", goal)
    else:
        try:
            aim = as_float(goal)
        except ParameterError:
            reason = 'neither "least" nor "largest" nor a number'
            raise ParameterError("goal", goal, reason) from None
    limits: dict[str, OutcomeLimits] = {}
    check_mapping("subject_to", subject_to, "{outcome: (least, largest)}, one may be None")
    for name, ends in subject_to.items():
        check_outcome(name, model, of_orbit=of_orbit)
        if not _is_pair(ends) or ends[0] is None is ends[1]:
            raise ParameterError(
                f"subject_to.{name}", ends, "not (least, largest), one may be None"
            )
        low, high = (None if end is None else real(f"subject_to.{name}", end) for end in ends)
        if low is not None and high is not None and low > high:
            raise ParameterError(f"subject_to.{name}", ends, "the least is above the largest")
        limits[name] = low, high
    return Wanted(outcome, aim, limits)


def _box(
    system: tuple[Any, Any],
    start: Start | StructureStart | None,
    free: Mapping[str, tuple[Any, Any]],
) -> dict[str, tuple[float, float]]:
    """Return the ranges of the parameters by their long paths."""
    if not free:
        raise ParameterError("free", free, 'no parameter; give one as {"forcing.omega": (1, 2)}')
    check_mapping("free", free, "{path: (least, largest)}")
    box: dict[str, tuple[float, float]] = {}
    for path, ends in free.items():
        name = long_form(path, *system, start)
        if name in box:
            raise ParameterError("free", path, "the same parameter, named twice")
        if not _is_pair(ends):
            raise ParameterError(f"free.{path}", ends, "not a range (least, largest)")
        low, high = (real(f"free.{path}", end) for end in ends)
        if not low < high:
            raise ParameterError(f"free.{path}", ends, "the least is not below the largest")
        if name.endswith(OWN_LIMITS):
            _check_ends(system, path, name, (low, high))
        box[name] = low, high
    return box


def _check_ends(system: tuple[Any, Any], path: str, name: str, ends: tuple[float, float]) -> None:
    """Refuse ends that no other parameters would make possible; other parts without a model bound."""
    for end in ends:
        try:
            replace_parameters(*system, None, {name: end})
        except ParameterError as error:
            reason = f"the model does not allow {end:g}: {error}"
            raise ParameterError(f"free.{path}", ends, reason) from None


def _is_pair(given: object) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2


def _settings(search: DesignSearch, restarts: int, seed: int) -> list[dict[str, float]]:
    """Return the given setting, and others in a Latin hypercube of the box."""
    random = np.random.default_rng(seed)
    n = len(search.paths)
    columns = [random.permutation(restarts) + random.random(restarts) for _ in range(n)]
    places = [search.given, *(np.array(row) / restarts for row in zip(*columns, strict=True))]
    return [search.values(place) for place in places]


def _best(search: DesignSearch, restarts: int, seed: int) -> Design:
    """Search from several settings, and return the best end."""
    ends: list[SearchEnd] = []
    n_settings = n_begun = 0
    for values in _settings(search, restarts, seed):
        if search.progress.is_stopped and ends:
            break
        firsts = search.trials.first(values, restarts + 1, seed)
        usable = [first for first in firsts if search.is_usable(first)]
        n_settings, n_begun = n_settings + 1, n_begun + bool(usable)
        for first in usable:
            if search.progress.is_stopped and ends:
                break
            ends.append(search.run(first))
    if not ends:
        advice = (
            "widen the ranges of the free parameters, or give the orbit or start of another one"
        )
        raise ConvergenceError("no motion to begin a design from", None, math.nan, advice)
    best = ends[0]
    for end in ends[1:]:
        if search.is_better(end, best):
            best = end
    return _design(search, best, ends, (n_settings, n_begun))


def _design(
    search: DesignSearch, best: SearchEnd, ends: list[SearchEnd], begun: tuple[int, int]
) -> Design:
    trial, wanted = best.trial, search.wanted
    value, gradient = trial.outcome(wanted.outcome)
    place = search.place(trial.values)
    at_ends = np.minimum(place, 1.0 - place) < MET
    at_end = [path for path, is_at_end in zip(search.paths, at_ends, strict=True) if is_at_end]
    limited = [row.name for row in wanted.kept(trial) if abs(row.value) < MET]
    others = sorted((end for end in ends if end is not best), key=lambda end: bool(end.reason))
    return Design(
        outcome=wanted.outcome,
        goal=wanted.goal,
        value=value,
        values=trial.values,
        bounds=search.box,
        outcomes={name: trial.outcome(name)[0] for name in wanted.limits},
        limits=dict(wanted.limits),
        active=tuple(at_end + limited),
        gradient=gradient,
        oscillator=trial.model,
        forcing=trial.force,
        start=trial.start,
        orbit=trial.orbit,
        run=trial.run,
        derivative=trial.derivative,
        converged=not best.reason,
        reason=best.reason,
        attempts=tuple(
            Attempt(end.trial.values, end.trial.outcome(wanted.outcome)[0], end.reason)
            for end in [best, *others]
        ),
        n_settings=begun[0],
        n_begun=begun[1],
        n_motions=search.n_trials,
    )
