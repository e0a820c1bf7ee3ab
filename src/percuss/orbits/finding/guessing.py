"""From what a user gives as a guess to where Newton's method starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.law import PERIOD, Law, Table
from percuss.kernels.record import Integers
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.trajectory import Trajectory
from percuss.orbits.finding.search import Guess, guesses_in, ways_after
from percuss.orbits.orbit.chain import chain_of_stops, entries_of, entry, row_of_region
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.short_runs import ShortRuns

__all__ = ["GivenGuess", "counts_of_run", "guess_of"]

GivenGuess: TypeAlias = tuple[float, float] | Trajectory | PeriodicOrbit
Floats = NDArray[np.float64]


def guess_of(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: int,
    n_periods: int,
    sequence: Sequence[int] | None,
    given: GivenGuess,
) -> Guess:
    """Return where to start Newton's method.

    Parameters
    ----------
    osc, force
        What moves.
    n_impacts, n_periods
        The orbit that is looked for.
    sequence
        The stops that it meets, or None.
    given
        (cycle, v_after), a run, or an orbit.

    Returns
    -------
    Guess
        Events, times and velocities.

    Raises
    ------
    ParameterError
        If what is given does not fit the orbit or is not physical.
    """
    if isinstance(given, PeriodicOrbit):
        return _of_orbit(osc, force, n_impacts, n_periods, given)
    if isinstance(given, Trajectory):
        return _of_run(osc, force, n_impacts, n_periods, given)
    try:
        cycle, v = (as_float(number) for number in given)
    except (TypeError, ValueError):
        reason = "neither (cycle, v_after) nor a run nor an orbit"
        raise ParameterError("guess", given, reason) from None
    if not (math.isfinite(cycle) and math.isfinite(v)):
        raise ParameterError("guess", given, "not two finite numbers")
    return _of_impact(osc, force, n_impacts, n_periods, sequence, (cycle, v))


def counts_of_run(run: Trajectory) -> tuple[float, int]:
    """Return the impacts and forcing periods of the pattern that a run repeats, else (1, 1).

    With contact in its last repetition it is sticking: infinitely many impacts.
    """
    pattern = classify_impact_times(run)
    n_periods = pattern.n_periods or 1
    if run.forcing is not None and run.forcing.period is not None and len(run.contacts):
        last = run.t_end - n_periods * run.forcing.period
        if run.contacts.start[-1] >= last:
            return math.inf, n_periods
    return (pattern.n_impacts, n_periods) if pattern.n_impacts else (1, 1)


def _of_orbit(
    osc: Oscillator, force: Forcing | None, n_impacts: int, n_periods: int, orbit: PeriodicOrbit
) -> Guess:
    """Take over events and velocities, and times as parts of the period."""
    own = len(orbit.impacts)
    times = n_impacts // own if own else 0
    periods = orbit.n_periods
    if math.isinf(orbit.n_impacts) or n_impacts != times * own or times < 1:
        raise ParameterError("guess", orbit, f"an orbit of another kind than {n_impacts} impacts")
    if periods and n_periods != times * periods:
        reason = f"its {periods} forcing periods do not go with {n_periods} of the orbit"
        raise ParameterError("guess", orbit, reason)
    table = law(osc, force)
    if len(table) != len(law(orbit.oscillator, orbit.forcing)):
        raise ParameterError("guess", orbit, "an orbit with other stops or harmonics")
    n = len(orbit._chain)
    scale = 1.0
    if periods:
        scale = n_periods * float(table[0, PERIOD]) / (times * orbit.period)
    t0, lasting, speeds = orbit._unknowns[0], orbit._unknowns[1 : 1 + n], orbit._unknowns[1 + n :]
    unknowns = np.concatenate(
        [[t0 * scale], np.tile(lasting * scale, times), np.tile(speeds, times)]
    )
    return Guess(np.tile(orbit._chain, (times, 1)), unknowns, n_impacts, times * periods)


def _of_run(
    osc: Oscillator, force: Forcing | None, n_impacts: int, n_periods: int, run: Trajectory
) -> Guess:
    """Take the last stretch of a run that nearly closes."""
    if run.oscillator != osc or run.forcing != force:
        raise ParameterError("guess", run, "a run of another oscillator or forcing")
    # Room for the stretch, and for crossings out of soft stops.
    last = 4 * (n_impacts + 1) * (1 + len(osc.stops))
    record = run._events[-last:], run._marks[-last:]
    table = law(osc, force)
    every = list(guesses_in(osc, table, record, n_impacts, n_periods))
    fitting = [guess for guess in every if guess.n_impacts == n_impacts]
    fitting = [guess for guess in fitting if guess.n_periods in (0, n_periods)]
    if not fitting:
        reason = f"it does not come near to {n_impacts} impacts in {n_periods} periods at its end"
        if len(run.contacts):
            reason += "; with contact ask for n_impacts=math.inf"
        raise ParameterError("guess", run, reason)
    return fitting[-1]


def _of_impact(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: int,
    n_periods: int,
    sequence: Sequence[int] | None,
    impact: tuple[float, float],
) -> Guess:
    """Follow the motion from an impact; where it meets other stops, space the events evenly."""
    cycle, v = impact
    table = law(osc, force)
    stop = _stop_left_with(osc, v) if sequence is None else sequence[0]
    _check_way(osc, stop, v)
    stops = tuple(sequence) if sequence is not None else None
    period = float(table[0, PERIOD])
    t0 = cycle * period
    runs = ShortRuns(osc, force)
    place = as_float(osc.stops[stop].at)
    end = t0 + (n_periods + 1) * period if period else math.inf
    events, marks = runs.follow(place, v, t0, t_end=end, n_impacts=n_impacts)
    # The start is told as the impact that it is meant to follow.
    chain = chain_of_stops(osc, table, stops or (stop,) * n_impacts)
    record = _with_first(osc, table, stop, events.copy(), marks.copy())
    for guess in guesses_in(osc, table, record, n_impacts, 10**6, near=math.inf):
        met = tuple(k for _, k in entries_of(osc, table, guess.chain))
        if guess.n_impacts == n_impacts and (stops is None or met == stops):
            return _closed(guess, n_periods if period else 0, period)
    if not period:
        raise ParameterError("guess", impact, "the motion from it does not come back")
    n = len(chain)
    even = np.full(n, n_periods * period / n)
    unknowns = np.concatenate([[t0], even, abs(v) * ways_after(table, chain)])
    return Guess(chain, unknowns, n_impacts, n_periods)


def _stop_left_with(osc: Oscillator, v: float) -> int:
    """Return the first stop after whose impact a velocity has this sign."""
    for stop in range(len(osc.stops)):
        if _way_after(osc, stop) * v >= 0.0:
            return stop
    reason = "no stop of the oscillator is left with a velocity of this sign"
    raise ParameterError("guess", v, reason)


def _way_after(osc: Oscillator, stop: int) -> float:
    """Return the sign of a velocity after meeting a stop: off a wall, into a soft stop."""
    way = entry(osc, stop).way
    return -way if isinstance(osc.stops[stop], Wall) else way


def _check_way(osc: Oscillator, stop: int, v: float) -> None:
    if _way_after(osc, stop) * v < 0.0:
        kind = "into the wall" if isinstance(osc.stops[stop], Wall) else "out of the stop"
        reason = f"{kind} {stop}; v_after is the velocity after the impact there"
        raise ParameterError("guess", v, reason)


def _with_first(
    osc: Oscillator, table: Law, stop: int, events: Table, marks: Integers
) -> tuple[Table, Integers]:
    """Return a record in which the start is the impact that it is meant to follow."""
    it = entry(osc, stop)
    kind = columns.IMPACT if isinstance(osc.stops[stop], Wall) else columns.CROSSING
    first = columns.START, -1, row_of_region(table, it.before)
    marks[0] = kind, it.bound, row_of_region(table, it.after)
    return np.concatenate([events[:1], events]), np.concatenate([[first], marks])


def _closed(guess: Guess, n_periods: int, period: float) -> Guess:
    """Return a guess whose flights last as long as the orbit that is looked for."""
    if n_periods == 0:
        return guess
    n = len(guess.chain)
    unknowns = guess.unknowns.copy()
    unknowns[1 : 1 + n] *= n_periods * period / unknowns[1 : 1 + n].sum()
    return Guess(guess.chain, unknowns, guess.n_impacts, n_periods)
