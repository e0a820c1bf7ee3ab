"""One motion, from its start to its limits."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, cast, overload

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats, Integers
from percuss.errors import LimitWarning, ParameterError
from percuss.kernels import march as engine
from percuss.kernels import record as columns
from percuss.kernels.law_columns import (
    DAMPING,
    FORCING_CONSTANT,
    GROWTH,
    LOWER,
    N_KNOTS,
    N_REGIONS,
    ORIGIN,
    ORIGIN_FORCE,
    PERIOD,
    STIFFNESS,
    UPPER,
    Law,
)
from percuss.kernels.sample import cycles, evaluate
from percuss.model.exact import Exact, Phase, as_float, as_fraction, plain
from percuss.model.expression import Expression, parameters_in
from percuss.model.faults import raise_first
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.start import (
    MOST_PERIODS,
    Start,
    end_after_periods,
    limit_faults,
    periods_faults,
    start_of,
    wall_faults,
)
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart, structure_start
from percuss.model.system import System, check_phases, turns_of
from percuss.motion.extremes import extremes_of_motion
from percuss.motion.instants import last_moderate
from percuss.motion.reach import SLACK, drifts_off, free_until, misses, periodic_state
from percuss.motion.trajectory import AnyRun, Outcome, Trajectory
from percuss.numerics import expm1
from percuss.progress import RunProgress
from percuss.wording import counted

if TYPE_CHECKING:
    from percuss.motion.structures import StructureTrajectory

_Number = TypeVar("_Number", np.float64, np.int64)

# Without `max_impacts`. Ten million impacts take 0.9 GB: elastic hops on a wall can be that many.
MOST_IMPACTS = 10_000_000

# Searches between two checks of the keyboard and the progress.
PATIENCE = 50_000
# Rows for events at first: untouched memory costs nothing.
FIRST_CAPACITY = 1_000_000
LARGEST_GROWTH = 1_000_000

_OUTCOMES = {
    columns.REACHED_END: Outcome.reached_t_end,
    columns.REACHED_LIMIT: Outcome.reached_max_impacts,
    columns.AT_REST: Outcome.at_rest,
    columns.OVERFLOW: Outcome.overflow,
    columns.NO_MORE: Outcome.no_more_impacts,
}


@overload
def simulate(
    osc: Oscillator,
    force: Forcing | None = None,
    x0: Exact = 0.0,
    v0: Exact = 0.0,
    t0: Phase = 0.0,
    *,
    start: Start | Sequence[Phase] | None = None,
    t_end: Phase | None = None,
    periods: Exact | None = None,
    max_impacts: int | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> Trajectory: ...


@overload
def simulate(
    osc: Structure,
    force: Loads | Mapping[Any, Forcing] | Forcing | None = None,
    x0: Iterable[Exact] | Exact = 0.0,
    v0: Iterable[Exact] | Exact = 0.0,
    t0: Phase = 0.0,
    *,
    start: StructureStart | Sequence[Any] | None = None,
    t_end: Phase | None = None,
    periods: Exact | None = None,
    max_impacts: int | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> StructureTrajectory: ...


def simulate(
    osc: Oscillator | Structure,
    force: Any = None,
    x0: Any = 0.0,
    v0: Any = 0.0,
    t0: Phase = 0.0,
    *,
    start: Any = None,
    t_end: Phase | None = None,
    periods: Exact | None = None,
    max_impacts: int | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> Trajectory | StructureTrajectory:
    """Follow one motion from event to event, in closed form between them.

    No impact is missed: a stretch is passed over only when a bound proves that it holds none
    (docs/theory/first-event.md). A start on a wall with v0 into it is an impact at t0; with
    v0 = 0 and a force into it, a contact.

    A number (`Exact`) is an int, float, Fraction, Decimal or a text such as ``"2.8"`` or
    ``"1/3"``, which is taken exactly; a time may be a multiple of pi too, as ``"20*pi"``.

    Parameters
    ----------
    osc
        The oscillator, or a structure of n coordinates.
    force
        The forcing, of a structure its `Loads`; None for free motion.
    x0, v0, t0
        Position [length], velocity [length/time] and time [time] of the start; (n,) positions and
        velocities of a structure, which rests at 0 without them.
    start
        The start in place of these: a `Start`, (x0, v0) or (x0, v0, t0), as all functions take it;
        a `StructureStart` or the same pairs for a structure.
    t_end
        Time of the end [time], after t0; needed for a structure, unless `periods` are given.
    periods
        Number of forcing periods from t0 to the end, > 0, in place of `t_end`.
    max_impacts
        Number of impacts after which to stop, >= 1; an entry into a soft stop counts as one, and
        so does a landing at rest.
        Without it the run stops at ten million, which elastic hops on a wall can reach.
    progress
        True shows a line on the error stream for runs longer than two seconds; a function
        ``(done, total) -> bool``, with the share of the run that is done and 1, is called about
        once a second, and stops the run by returning False.

    Returns
    -------
    Trajectory or StructureTrajectory
        The motion, its events, and in `outcome` how it ended. Growth without bound, chatter and
        rest are outcomes, no errors; Ctrl-C ends a run with what was done. A motion that grows
        beyond 1e150 is kept up to there, at `t_end`.

    Warns
    -----
    LimitWarning
        If the run ends at ten million impacts without `max_impacts`.

    Raises
    ------
    ParameterError
        If a number is not finite, the start lies inside a wall, t_end is not after t0 or either
        later than 1e14 periods, there is no limit at all, `periods` are given together with
        t_end or for a forcing without a period, or `start` together with x0, v0 or t0. Of a
        structure, if there is not one number for each coordinate.
    ConvergenceError
        If the modes of a structure cannot be told apart, or walls hold one displacement twice.

    Examples
    --------
    The third harmonic from just above its critical velocity (Dyskin et al. 2012, eq. 24):

    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, t_end=94.25)
    >>> len(run.impacts), run.outcome.name
    (30, 'reached_t_end')
    >>> run.impacts.t[:3] / 3.141592653589793
    array([1., 2., 3.])

    Two masses, of which the first strikes the second:

    >>> pair = pc.impact_pair(masses=[1, 2], gap="0.5", restitution="0.7")
    >>> run = pc.simulate(pair, v0=[1, 0], t_end=1)
    >>> run.impacts.t, run(1)[1].round(12)
    (array([0.5]), array([-0.13333333,  0.56666667]))
    """
    if isinstance(osc, Structure):
        from percuss.motion.follow_structure import follow_structure

        _refuse_both(start, x0, v0, t0)
        begin_there = structure_start(osc, start, x0, v0, t0)
        run = follow_structure(
            osc, force, begin_there, t_end, periods, max_impacts, MOST_IMPACTS, progress
        )
        _warn_at_limit(run, max_impacts)
        return run
    system, begins = System.of(osc, force), _start(start, x0, v0, t0)
    x0, v0, t0 = begins.x0, begins.v0, begins.t0
    raise_first(wall_faults(osc, "x0" if start is None else "start.x0", x0))
    if periods is not None:
        raise_first(periods_faults(force, periods, t_end))
        t_end = end_after_periods(cast("Forcing", force), begins.t0, periods)
    raise_first(limit_faults(begins.t0, t_end, max_impacts, periods))
    if any(isinstance(value, Expression) for value in (x0, v0, t0, t_end, periods)):
        parameters_in(*system, begins, t_end, periods)  # one name has one value
    limit = MOST_IMPACTS if max_impacts is None else min(int(max_impacts), 2**62)
    begin, end = as_float(begins.t0), math.inf if t_end is None else as_float(t_end)
    _check_times(system.law, begin, end)
    march = _March(system, as_float(begins.x0), as_float(begins.v0), begin, limit)
    outcome = march.run(end, limit, RunProgress(progress, begin, end, limit))
    stopped: Phase = march.last_time
    if outcome in (Outcome.reached_t_end, Outcome.at_rest) and t_end is not None:
        stopped = cast("Phase", plain(t_end))
    if outcome is Outcome.overflow or (outcome is Outcome.reached_t_end and march.may_grow):
        last = march.last_moderate(end)
        if outcome is Outcome.overflow or last < end:
            stopped, outcome = last, Outcome.overflow
    reached = outcome in (Outcome.reached_t_end, Outcome.at_rest)
    lasts = None if periods is None or not reached else cast("Exact", plain(periods))
    motion = Trajectory.of_record(system, march.record(), stopped, outcome, begins, lasts)
    _warn_at_limit(motion, max_impacts)
    return motion


def _warn_at_limit(run: AnyRun, max_impacts: int | None) -> None:
    """Warn that a run has ended at the limit of impacts where the caller gave none."""
    if run.outcome is Outcome.reached_max_impacts and max_impacts is None:
        message = (
            f"the run ended at t = {run.t_end:.10g} after {counted(MOST_IMPACTS, 'impact')}, the limit "
            "without max_impacts; give max_impacts to follow it further"
        )
        warnings.warn(message, LimitWarning, stacklevel=3)


def run_of(model: Any, force: Any, start: Any, **limits: Any) -> Trajectory | StructureTrajectory:
    """Return the run of an oscillator or a structure from a start, as `simulate` does."""
    run: Trajectory | StructureTrajectory = simulate(model, force, start=start, **limits)
    return run


def _start(start: object, x0: Exact, v0: Exact, t0: Phase) -> Start:
    """Return the start of a run from either form."""
    _refuse_both(start, x0, v0, t0)
    return Start(x0, v0, t0) if start is None else start_of(start)


def _refuse_both(start: object, x0: object, v0: object, t0: object) -> None:
    """Refuse a start that is given in both forms."""
    if start is None:
        return
    for name, value in (("x0", x0), ("v0", v0), ("t0", t0)):
        if not (isinstance(value, float) and value == 0.0):
            raise ParameterError(name, value, "given together with start; give one")


def _check_times(law: Law, t0: float, t_end: float) -> None:
    """Refuse times so late that a phase there has no digits left."""
    free, _ = turns_of(law)
    fastest = check_phases(law, t0, t_end)
    slowest = min((turns for turns in free if turns > 0.0), default=math.inf)
    if t_end == math.inf and fastest > MOST_PERIODS * slowest:
        reason = (
            f"needed where the fastest part of the motion is {fastest / slowest:.3g} times as "
            f"fast as the slowest; phases are exact over {MOST_PERIODS:g} periods"
        )
        raise ParameterError("t_end", None, reason)


def _longer(rows: NDArray[_Number]) -> NDArray[_Number]:
    """Return rows with more behind them that hold nothing yet."""
    n = len(rows)
    longer = np.empty((n + min(n, LARGEST_GROWTH), *rows.shape[1:]), rows.dtype)
    longer[:n] = rows
    return longer


class _March:
    """The engine's arrays during a run: they grow with the events."""

    def __init__(self, system: System, x0: float, v0: float, t0: float, limit: int) -> None:
        self.system, law = system, system.law
        # Each entry into a soft stop, which counts as an impact, has an exit that does not.
        events = limit + 4 + (limit if law[0, N_REGIONS] > 1 else 0)
        self.arrays = columns.new_run(law, min(events, FIRST_CAPACITY))
        self.state, self.counters = self.arrays.state, self.arrays.counters
        self.state[columns.T], self.state[columns.X], self.state[columns.V] = t0, x0, v0
        self.start = (x0, v0)

    @property
    def last_time(self) -> float:
        """The time of the last event."""
        return float(self.state[columns.T])

    def run(self, end: float, limit: int, progress: RunProgress) -> Outcome:
        """March to the limits, or until the user stops it."""
        try:
            while True:
                status = engine.march(self.arrays, end, limit, PATIENCE)
                if status in _OUTCOMES:
                    return _OUTCOMES[status]
                if status == columns.FULL:
                    if end == math.inf and self._is_out_of_reach():
                        return Outcome.no_more_impacts
                    self._grow()
                elif self._look_far(end) == math.inf and end == math.inf:
                    return Outcome.no_more_impacts
                searched = max(self.state[columns.FREE_BELOW], self.state[columns.CONTACT_UNTIL])
                if not progress.reach_event(
                    self.last_time + searched, int(self.counters[columns.N_IMPACTS])
                ):
                    return Outcome.interrupted
        except KeyboardInterrupt:
            return Outcome.interrupted
        finally:
            progress.close()

    @property
    def may_grow(self) -> bool:
        """Return whether the last stretch is a flight that may grow beyond all bounds."""
        flies = self.counters[columns.TOUCHED] == 0
        return bool(flies and self.arrays.law[self.counters[columns.REGION], GROWTH] > 0.0)

    def last_moderate(self, end: float) -> float:
        """Return up to when, at most ``end``, the last flight stays below HUGE.

        One that begins beyond that is kept as long as it has numbers.
        """
        return last_moderate(self._is_below, self.last_time, end)

    def _is_below(self, limit: float, t: float) -> bool:
        """Return whether position and velocity at t are numbers below a limit."""
        if not t < math.inf:
            return False
        law, phases = self.arrays.law, np.empty_like(self.arrays.phases)
        n = int(self.counters[columns.N_EVENTS])
        so_far = columns.MotionRecord(
            law, self.start[0], self.arrays.events[:n], self.arrays.marks[:n]
        )
        motion = np.empty((2, 1))
        with np.errstate(over="ignore", invalid="ignore"):
            evaluate(so_far, np.array([t]), True, phases, np.empty_like(phases), motion)
        return bool((np.abs(motion) < limit).all())

    def _look_far(self, end: float) -> float:
        """Move on the search of a long flight; return how far it is free of events."""
        if self.counters[columns.TOUCHED] != 0:
            return 0.0
        state = [float(value) for value in self.state]
        start = (state[columns.T], state[columns.T_LOW], state[columns.V], state[columns.FORCE])
        searched = min(state[columns.FREE_BELOW], state[columns.FREE_ABOVE])
        if searched == 0.0:
            return 0.0
        longest = end - state[columns.T]
        free = free_until(
            self.arrays.law,
            int(self.counters[columns.REGION]),
            state[columns.X],
            start,
            self.arrays.phases,
            searched,
            longest,
        )
        for side in (columns.FREE_BELOW, columns.FREE_ABOVE):
            self.state[side] = max(self.state[side], min(free, longest))
        return free

    def _is_out_of_reach(self) -> bool:
        """Return whether the motion under a repeated record provably meets no bound any more.

        It is the periodic motion of its region and a free motion, whose energy does not grow.
        """
        law, region = self.arrays.law, int(self.counters[columns.REGION])
        period, stiffness = float(law[0, PERIOD]), float(law[region, STIFFNESS])
        flies = self.counters[columns.TOUCHED] == 0 and law[region, GROWTH] == 0.0
        if not (flies and law[0, N_KNOTS] > 0.0 and period > 0.0):
            return False
        if stiffness == 0.0:
            return self._drifts_away(region, period)
        if not stiffness > 0.0:
            return False
        states = [periodic_state(law, region, t) for t in (0.0, self._cycle() * period)]
        if None in states:
            return False
        (y0, v0), (y, v) = cast("list[tuple[float, float]]", states)
        origin, x = float(law[region, ORIGIN]), float(self.state[columns.X])
        free = math.hypot(x - origin - y, (float(self.state[columns.V]) - v) / math.sqrt(stiffness))
        low, high = float(law[region, LOWER]), float(law[region, UPPER])
        if not low < origin + y0 < high:
            return False
        whole = self._without_events(origin + y0, v0, 0.0, period)
        if whole is None:
            return False
        ends = extremes_of_motion(self.system, whole, (0.0, period), "displacement", 0)
        return misses((low, high), ends.minimum - free, ends.maximum + free, abs(x) + free)

    def _drifts_away(self, region: int, period: float) -> bool:
        """Return whether a mass without spring under a repeated record meets no bound any more."""
        law, force = self.arrays.law, self.system.forcing
        record = None if force is None else force.record
        if force is None or record is None or law[region, ORIGIN_FORCE] != law[0, FORCING_CONSTANT]:
            return False
        mean = as_fraction(force.constant) + record.mean
        t = self._cycle() * period
        x, v = float(self.state[columns.X]), float(self.state[columns.V])
        whole = self._without_events(x, v, t, t + period)
        if whole is None:
            return False
        phases, motion = np.empty_like(self.arrays.phases), np.empty((2, 1))
        end = np.array([t + period])
        evaluate(whole, end, True, phases, np.empty_like(phases), motion)
        drift, size = float(motion[0, 0]) - x, abs(x) + period * (abs(v) + abs(float(motion[1, 0])))
        doubt, damping = SLACK * size, float(law[region, DAMPING])
        reach = float(law[region, LOWER]), float(law[region, UPPER])
        if mean == 0 and damping > 0.0:
            # It drifts on for a geometric series.
            rest = (abs(drift) + doubt) / -expm1(-2.0 * damping * period)
            ends = extremes_of_motion(self.system, whole, (t, t + period), "displacement", 0)
            return misses(reach, ends.minimum - rest, ends.maximum + rest, size)
        return drifts_off(reach, drift, doubt, mean)

    def _cycle(self) -> float:
        """Return the cycle of the last event."""
        # Of a late time the digits of its place in the period are in both of its parts.
        cycle, now = np.empty(1), self.state[[columns.T, columns.T_LOW]]
        cycles(self.arrays.law, now[:1], now[1:], cycle)
        return float(cycle[0])

    def _without_events(
        self, x: float, v: float, t: float, end: float
    ) -> columns.MotionRecord | None:
        """Return the motion from a state to an end, None where it meets a bound."""
        other = _March(self.system, x, v, t, 1)
        if other.run(end, 1, RunProgress(None, t, end, 1)) is not Outcome.reached_t_end:
            return None
        _, events, marks, _ = other.record()
        if not np.isin(marks[:, columns.KIND], (columns.START, columns.KNOT)).all():
            return None
        return columns.MotionRecord(self.arrays.law, x, events, marks)

    def _grow(self) -> None:
        """Lengthen the arrays of events and grazes."""
        events, marks, grazes = self.arrays.events, self.arrays.marks, self.arrays.grazes
        n = len(events)
        if self.counters[columns.N_EVENTS] + 2 > n:
            events, marks = _longer(events), _longer(marks)
        if self.counters[columns.N_GRAZES] + 1 > len(grazes):
            grazes = np.concatenate([grazes, np.empty_like(grazes)])
        self.arrays = self.arrays._replace(events=events, marks=marks, grazes=grazes)

    def record(self) -> tuple[tuple[float, float], Floats, Integers, Floats]:
        """Return what happened, without the rows that are not used."""
        n = int(self.counters[columns.N_EVENTS])
        events, marks = self.arrays.events[:n], self.arrays.marks[:n]
        if n < 0.9 * len(self.arrays.events):
            # The next run finds the rows that are given back whole: memory that it need not touch
            # for the first time, which costs more than the copy.
            events, marks = events.copy(), marks.copy()
        grazes = self.arrays.grazes[: int(self.counters[columns.N_GRAZES])].copy()
        return self.start, events, marks, grazes
