"""Guesses for Newton's method: stretches of motions that almost close."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.law_columns import Law
from percuss.kernels.shooting import AFTER, AT, BEFORE
from percuss.model.exact import as_float, two_of
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.system import System
from percuss.motion.entries import entry_rows
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.trajectory import Trajectory
from percuss.numerics import power
from percuss.orbits.finding.search_budget import SearchBudget
from percuss.orbits.orbit.itinerary import (
    Itinerary,
    entries_of,
    entry,
    events_of_record,
    events_of_stops,
    row_of_region,
)
from percuss.orbits.orbit.knots import without_knots
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.propagator import Propagator
from percuss.orbits.orbit.solve import in_first_period
from percuss.wording import counted

# Motions that are followed from each stop.
STARTS = 200
# Motions of a batch of a search for all orbits, from each stop.
BATCH = 50
# Free motion without losses is periodic from every start.
FREE_STARTS = 20
# Impacts of a motion beyond those of the longest orbit.
MORE_IMPACTS = 3
# Guesses at random for given events.
SCATTERED = 200
# Motions that are followed from each stop until they settle, and their impacts.
LONG, SETTLING = 6, 400
# Largest distance of the ends of a stretch, in cycles and as a part of the velocities.
NEAR = 0.35


def starts_of(system: System, n_batches: int = 0) -> int:
    """Return the number of starts that `guesses`, or so many of `batches`, follow at most."""
    short = FREE_STARTS if system.period is None else n_batches * BATCH or STARTS
    return len(system.oscillator.stops) * (short + LONG)


def guesses(
    system: System, counts: tuple[int, int], seed: int, budget: SearchBudget, *, exactly: bool
) -> Iterator[Guess]:
    """Yield guesses of orbits, from random starts at the stops.

    Parameters
    ----------
    system
        Oscillator and forcing.
    counts
        Most impacts and most forcing periods.
    seed
        Of the random starts.
    budget
        Counts the starts, and may end the search.
    exactly
        Whether to yield only those of as many impacts and periods.

    Yields
    ------
    Guess
        Stretches of motions whose ends are near each other.
    """
    starts = (FREE_STARTS if system.period is None else STARTS), LONG
    random = np.random.default_rng(seed)
    yield from _from_stops(system, counts, starts, random, budget, exactly=exactly)


def batches(
    system: System, counts: tuple[int, int], seed: int, budget: SearchBudget, n_batches: int
) -> Iterator[Iterator[Guess]]:
    """Yield guesses as `guesses` does, in so many batches of 50 starts from each stop."""
    random = np.random.default_rng(seed)
    for batch in range(n_batches):
        starts = BATCH, 0 if batch else LONG
        yield _from_stops(system, counts, starts, random, budget, exactly=False)
        if not budget.goes_on():
            return


def _from_stops(
    system: System,
    counts: tuple[int, int],
    starts: tuple[int, int],
    random: np.random.Generator,
    budget: SearchBudget,
    *,
    exactly: bool,
) -> Iterator[Guess]:
    """Yield the guesses in short and long motions, ``starts`` of each, from each stop."""
    for stop in range(len(system.oscillator.stops)):
        for record, duration in _motions(system, counts, stop, starts, random):
            budget.followed(duration)
            for guess in guesses_in(system, record, *counts, exactly=exactly):
                yield replace(guess, trial=budget.n_done)
            budget.start_is_done()
            if not budget.goes_on():
                return


def _motions(
    system: System,
    counts: tuple[int, int],
    stop: int,
    starts: tuple[int, int],
    random: np.random.Generator,
) -> Iterator[tuple[tuple[Floats, Integers], float]]:
    """Yield record and duration of motions: short ones of a few impacts, and long ones."""
    (n_short, n_long), (max_impacts, max_periods) = starts, counts
    runs, osc = Propagator(system), system.oscillator
    period, speed = float(runs.law[0, at.PERIOD]), scale_of_speed(system)
    sign, x0 = _sign_after(osc, stop), as_float(osc.stops[stop].at)
    for i in range(n_short + n_long):
        t0 = random.random() * period
        v0 = sign * speed * power(10.0, random.uniform(-2.0, 0.7))
        n_impacts = max_impacts + MORE_IMPACTS if i < n_short else SETTLING
        t_end = math.inf
        if period > 0.0:
            t_end = t0 + (n_impacts + 2) * max_periods * period
        events, marks = without_knots(*runs.follow(x0, v0, t0, t_end=t_end, n_impacts=n_impacts))
        if i >= n_short:
            last = 6 * max_impacts * (len(osc.stops) + 1)
            events, marks = events[-last:], marks[-last:]
        end = t_end if math.isfinite(t_end) and len(events) < 2 else float(events[-1, 0])
        yield (events.copy(), marks.copy()), end - t0


def scattered(
    system: System,
    stops: tuple[int, ...],
    n_periods: int,
    seed: int,
    budget: SearchBudget,
) -> Iterator[Guess]:
    """Yield guesses of orbits that meet given stops in turn, at random instants and velocities.

    They need not be near any motion, so that formal orbits are found from them as well.

    Parameters
    ----------
    system
        Oscillator and forcing; the forcing has a period.
    stops
        The stops met, in order.
    n_periods
        Forcing periods.
    seed
        Of the random numbers.
    budget
        Counts the guesses, and may end the search.

    Yields
    ------
    Guess
        All with the same sequence of events.
    """
    law, events = system.law, events_of_stops(system, stops)
    n, period = len(events), float(law[0, at.PERIOD])
    random = np.random.default_rng(seed)
    speed, signs = scale_of_speed(system), signs_after(law, events)
    for _ in range(SCATTERED):
        durations = random.exponential(size=n) + 0.05
        durations *= n_periods * period / durations.sum()
        velocities = signs * speed * 10.0 ** random.uniform(-1.5, 0.7, size=n)
        start = random.random() * period
        yield Guess(Itinerary(events, start, durations, velocities, n_periods), len(stops))
        budget.start_is_done()
        if not budget.goes_on():
            return


def signs_after(law: Law, events: Integers) -> Floats:
    """Return the sign of the velocity after each event."""
    signs = np.sign(events[:, AFTER] - events[:, BEFORE]).astype(np.float64)
    lower = events[:, AT] == law[events[:, BEFORE], at.NUMBER]
    return np.where(signs == 0.0, np.where(lower, 1.0, -1.0), signs)


def scale_of_speed(system: System) -> float:
    """Return the order of the velocities that forcing, springs and gaps cause."""
    (osc, force), law = system.of_unit_mass, system.law
    n = int(law[0, at.N_HARMONICS])
    rows = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
    # A record has no frequency but that of its period.
    slowest = 2.0 * math.pi / (float(law[0, at.PERIOD]) or 1.0)
    omega = np.where(rows[:, at.OMEGA] > 0.0, rows[:, at.OMEGA], slowest)
    speed = float((rows[:, at.AMPLITUDE] / omega).sum()) if n else 0.0
    spring = math.sqrt(abs(as_float(osc.stiffness)))
    speed += spring * max((abs(as_float(stop.at)) for stop in osc.stops), default=0.0)
    if force is not None:
        constant = abs(as_float(force.constant))
        speed += constant * (float(law[0, at.PERIOD]) or 1.0) * 0.5
    return speed or 1.0


def guesses_in(
    system: System,
    record: tuple[Floats, Integers],
    max_impacts: int,
    max_periods: int,
    *,
    near: float = NEAR,
    exactly: bool = False,
) -> Iterator[Guess]:
    """Yield the stretches of a record that almost close, from impact to impact.

    Stretches with contact are left out. An infinite ``near`` takes all that end at their stop;
    ``exactly`` only those with as many impacts and periods.
    """
    (states, marks), law = record, system.law
    events = events_of_record(marks)
    kinds = marks[1:, columns.KIND]
    free = (kinds == columns.IMPACT) | (kinds == columns.CROSSING)
    met = [i for i, _ in entries_of(system, events) if free[i]]
    # There are many pairs: plain numbers are faster than arrays.
    stuck = [0, *np.cumsum(~free).tolist()]
    bounds, regions = events[:, AT].tolist(), events[:, AFTER].tolist()
    t = states[1:, columns.EVENT_T] + states[1:, columns.EVENT_T_LOW]
    v = states[1:, columns.V_AFTER]
    instants, speeds = t.tolist(), v.tolist()
    period = float(law[0, at.PERIOD])
    for k, first in enumerate(met):
        for n_impacts in range(max_impacts if exactly else 1, max_impacts + 1):
            if k + n_impacts >= len(met):
                break
            last = met[k + n_impacts]
            if stuck[last + 1] > stuck[first]:
                break
            same = bounds[first] == bounds[last] and regions[first] == regions[last]
            change, size = abs(speeds[last] - speeds[first]), abs(speeds[last]) + abs(speeds[first])
            if not same or (change > 0.0 and change > near * size):
                continue
            n_periods = 0
            if period > 0.0:
                cycles = (instants[last] - instants[first]) / period
                n_periods = round(cycles)
                change = abs(cycles - n_periods)
                if math.isinf(near):
                    n_periods = max(n_periods, 1)
                least = max_periods if exactly else 1
                if not least <= n_periods <= max_periods or change > near:
                    continue
            durations = np.diff(t[first : last + 1])
            rows = events[first:last].copy()
            # The first event recurs at the end, from the region before that event.
            rows[0, BEFORE] = events[last, BEFORE]
            itinerary = Itinerary(rows, instants[first], durations, v[first:last].copy(), n_periods)
            yield Guess(itinerary, n_impacts)


@dataclass(frozen=True, slots=True)
class Guess:
    """A start of Newton's method.

    Attributes
    ----------
    itinerary
        Events, instants and velocities.
    n_impacts
        Impacts of the orbit; its other events are exits from soft stops.
    trial
        Number of the start of a search from which it comes.
    """

    itinerary: Itinerary
    n_impacts: int
    trial: int = 0

    @property
    def n_periods(self) -> int:
        """Forcing periods of the orbit."""
        return self.itinerary.n_periods

    def primitive(self, itinerary: Itinerary, times: int) -> Guess:
        """Return a solution of the guess that covers a primitive orbit as a guess of that."""
        return Guess(itinerary.primitive(times), self.n_impacts // times, self.trial)


GivenGuess: TypeAlias = tuple[float, float] | Trajectory | PeriodicOrbit


def guess_of(
    system: System,
    n_impacts: int,
    n_periods: int,
    sequence: Sequence[int] | None,
    given: GivenGuess,
) -> Guess:
    """Return the start of Newton's method that a caller gives.

    Parameters
    ----------
    system
        Oscillator and forcing.
    n_impacts, n_periods
        Impacts and periods of the orbit.
    sequence
        Stops that it meets, or None.
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
        return _of_orbit(system, n_impacts, n_periods, given)
    if isinstance(given, Trajectory):
        return _of_run(system, n_impacts, n_periods, given)
    reason = "neither two finite numbers (cycle, v_after) nor a run nor an orbit"
    impact = two_of(as_float, "guess", given, reason)
    return _of_impact(system, n_impacts, n_periods, sequence, impact)


def counts_of_run(run: Trajectory) -> tuple[float, int]:
    """Return the impacts and forcing periods of the pattern that a run repeats, else (1, 1).

    With contact in its last repetition it is sticking: infinitely many impacts.
    """
    # Of a run that meets both kinds of stop the entries are impacts of the orbit too.
    times = np.unique(np.concatenate([run.impacts.t, run.crossings.t[entry_rows(run)]]))
    pattern = classify_impact_times(times, run.oscillator, run.forcing)
    n_periods = pattern.n_periods or 1
    if run.forcing is not None and run.forcing.period is not None and len(run.contacts):
        last = run.t_end - n_periods * run.forcing.period
        if run.contacts.start[-1] >= last:
            return math.inf, n_periods
    if not pattern.n_impacts:
        return 1, 1
    if pattern.n_periods:
        return pattern.n_impacts, n_periods
    # Between stops that are alike the times repeat before the stops do.
    met = [stop for _, stop in entries_of(run.system, events_of_record(run.record[1]))]
    for n_impacts in range(pattern.n_impacts, len(met) // 2 + 1, pattern.n_impacts):
        if met[-n_impacts:] == met[-2 * n_impacts : -n_impacts]:
            return n_impacts, 1
    return pattern.n_impacts, 1


def _of_orbit(system: System, n_impacts: int, n_periods: int, orbit: PeriodicOrbit) -> Guess:
    """Return the itinerary of an orbit of a similar system, with the times scaled by the period."""
    own = len(orbit.impacts)
    times = n_impacts // own if own else 0
    periods = orbit.n_periods
    if math.isinf(orbit.n_impacts) or n_impacts != times * own or times < 1:
        raise ParameterError(
            "guess", orbit, f"an orbit of another kind than {counted(n_impacts, 'impact')}"
        )
    if periods and n_periods != times * periods:
        reason = f"its {periods} forcing periods do not go with {n_periods} of the orbit"
        raise ParameterError("guess", orbit, reason)
    law = system.law
    if len(law) != len(orbit.system.law):
        raise ParameterError("guess", orbit, "an orbit with other stops or harmonics")
    scale = 1.0
    if periods:
        scale = n_periods * float(law[0, at.PERIOD]) / (times * orbit.period)
    itinerary = orbit.itinerary.repeated(times)
    start, durations = scale * itinerary.start, scale * itinerary.durations
    return Guess(replace(itinerary, start=start, durations=durations), n_impacts)


def _of_run(system: System, n_impacts: int, n_periods: int, run: Trajectory) -> Guess:
    """Return the last stretch of a run that nearly closes, from the first period on.

    Late in a run the rounding of its instants is larger than the residuals of a solution.
    """
    if (run.oscillator, run.forcing) != system:
        raise ParameterError("guess", run, "a run of another oscillator or forcing")
    # Enough events for the stretch, crossings out of soft stops among them.
    last = 4 * (n_impacts + 1) * (1 + len(system.oscillator.stops))
    events, marks = without_knots(*run.record)
    record = events[-last:], marks[-last:]
    fitting = [
        guess
        for guess in guesses_in(system, record, n_impacts, n_periods)
        if guess.n_impacts == n_impacts and guess.n_periods in (0, n_periods)
    ]
    if not fitting:
        sought = f"{counted(n_impacts, 'impact')} in {counted(n_periods, 'period')}"
        reason = f"it does not come near to {sought} at its end"
        if len(run.contacts):
            reason += "; with contact ask for n_impacts=math.inf"
        raise ParameterError("guess", run, reason)
    last_one = fitting[-1]
    return replace(last_one, itinerary=in_first_period(system.law, last_one.itinerary))


def _of_impact(
    system: System,
    n_impacts: int,
    n_periods: int,
    sequence: Sequence[int] | None,
    impact: tuple[float, float],
) -> Guess:
    """Follow the motion from an impact; where it meets other stops, space the events evenly."""
    (cycle, v), osc, law = impact, system.oscillator, system.law
    stop = _stop_left_with(osc, v) if sequence is None else sequence[0]
    _check_sign(osc, stop, v)
    stops = tuple(sequence) if sequence is not None else None
    period = float(law[0, at.PERIOD])
    t0 = cycle * period
    x0 = as_float(osc.stops[stop].at)
    end = t0 + (n_periods + 1) * period if period else math.inf
    states, marks = Propagator(system).follow(x0, v, t0, t_end=end, n_impacts=n_impacts)
    # The start stands for the impact before it.
    events = events_of_stops(system, stops or (stop,) * n_impacts)
    record = _with_first(system, stop, *without_knots(states.copy(), marks.copy()))
    for guess in guesses_in(system, record, n_impacts, 10**6, near=math.inf):
        met = tuple(k for _, k in entries_of(system, guess.itinerary.events))
        if guess.n_impacts == n_impacts and (stops is None or met == stops):
            return _closed(guess, n_periods if period else 0, period)
    if not period:
        raise ParameterError("guess", impact, "the motion from it does not come back")
    durations = np.full(len(events), n_periods * period / len(events))
    velocities = abs(v) * signs_after(law, events)
    return Guess(Itinerary(events, t0, durations, velocities, n_periods), n_impacts)


def _stop_left_with(osc: Oscillator, v: float) -> int:
    """Return the first stop whose impacts leave a velocity of this sign."""
    for stop in range(len(osc.stops)):
        if _sign_after(osc, stop) * v >= 0.0:
            return stop
    reason = "no stop of the oscillator is left with a velocity of this sign"
    raise ParameterError("guess", v, reason)


def _sign_after(osc: Oscillator, stop: int) -> float:
    """Return the sign of the velocity after an impact: off a wall, into a soft stop."""
    sign = entry(osc, stop).sign
    return -sign if isinstance(osc.stops[stop], Wall) else sign


def _check_sign(osc: Oscillator, stop: int, v: float) -> None:
    if _sign_after(osc, stop) * v < 0.0:
        kind = "into the wall" if isinstance(osc.stops[stop], Wall) else "out of the stop"
        reason = f"{kind} {stop}; v_after is the velocity after the impact there"
        raise ParameterError("guess", v, reason)


def _with_first(
    system: System, stop: int, states: Floats, marks: Integers
) -> tuple[Floats, Integers]:
    """Return a record in which the start is the impact before it."""
    osc, law = system.oscillator, system.law
    met = entry(osc, stop)
    kind = columns.IMPACT if isinstance(osc.stops[stop], Wall) else columns.CROSSING
    first = columns.START, -1, row_of_region(law, met.before)
    marks[0] = kind, met.bound, row_of_region(law, met.after)
    return np.concatenate([states[:1], states]), np.concatenate([[first], marks])


def _closed(guess: Guess, n_periods: int, period: float) -> Guess:
    """Return a guess with the durations scaled to so many periods."""
    if n_periods == 0:
        return guess
    itinerary = guess.itinerary
    durations = itinerary.durations * (n_periods * period / itinerary.durations.sum())
    return Guess(replace(itinerary, durations=durations, n_periods=n_periods), guess.n_impacts)
