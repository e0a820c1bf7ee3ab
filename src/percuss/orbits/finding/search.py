"""Where Newton's method starts: stretches of motions that almost close."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import PERIOD, Law, Table
from percuss.kernels.shooting import AFTER, AT, BEFORE
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.trajectory import Trajectory
from percuss.numerics import power
from percuss.orbits.finding.search_budget import SearchBudget
from percuss.orbits.orbit.itinerary import (
    entries_of,
    entry,
    events_of_record,
    events_of_stops,
    row_of_region,
)
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.propagator import Propagator

__all__ = [
    "GivenGuess",
    "Guess",
    "batches",
    "counts_of_run",
    "guess_of",
    "guesses",
    "guesses_in",
    "scale_of_speed",
    "scattered",
    "starts_of",
]


# Motions that are followed from each stop, and how many impacts of each.
STARTS = 200
# Motions of a batch of a search for all orbits, from each stop.
BATCH = 50
# Free motion without losses repeats itself wherever it starts.
FREE_STARTS = 20
IMPACTS = 3
# Guesses at random for given events.
SCATTERED = 200
# Motions that are followed for long, to where they settle.
LONG = 6
SETTLING = 400
# How far apart the ends of a stretch may be, in cycles and as a part of the velocities.
NEAR = 0.35


def starts_of(osc: Oscillator, table: Law, n_batches: int = 0) -> int:
    """Return from how many starts `guesses` looks at most."""
    if table[0, at.PERIOD] == 0.0:
        return len(osc.stops) * (FREE_STARTS + LONG)
    return len(osc.stops) * ((n_batches * BATCH if n_batches else STARTS) + LONG)


def guesses(
    osc: Oscillator,
    force: Forcing | None,
    max_impacts: int,
    max_periods: int,
    seed: int,
    budget: SearchBudget,
    *,
    exactly: bool = False,
) -> Iterator[Guess]:
    """Yield guesses of orbits, from random starts at the stops.

    Parameters
    ----------
    osc, force
        What moves.
    max_impacts, max_periods
        The longest orbits to look for.
    seed
        Of the random starts.
    looking
        Is told of each start, and may end the search.
    exactly
        Take those with as many impacts and periods only.

    Yields
    ------
    Guess
        Stretches of motions whose ends are near to each other.
    """
    starts = STARTS if force is not None and force.period is not None else FREE_STARTS
    random = np.random.default_rng(seed)
    for stop in range(len(osc.stops)):
        motions = _motions(osc, force, (max_impacts, max_periods), (stop, starts, LONG), random)
        yield from _stretches(motions, (max_impacts, max_periods), budget, exactly=exactly)
        if not budget.goes_on():
            return


def batches(
    osc: Oscillator,
    force: Forcing,
    max_impacts: int,
    max_periods: int,
    seed: int,
    budget: SearchBudget,
    n_batches: int,
) -> Iterator[Iterator[Guess]]:
    """Yield guesses of orbits, batch by batch.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    max_impacts, max_periods
        The longest orbits to look for.
    seed
        Of the random starts.
    looking
        Is told of each start, and may end the search.
    n_batches
        How many batches at most; each has 50 starts from each stop.

    Yields
    ------
    iterator of Guess
        Those of a batch.
    """
    random, counts = np.random.default_rng(seed), (max_impacts, max_periods)
    for batch in range(n_batches):
        yield _batch(osc, force, counts, LONG if batch == 0 else 0, random, budget)
        if not budget.goes_on():
            return


def _batch(
    osc: Oscillator,
    force: Forcing,
    counts: tuple[int, int],
    n_long: int,
    random: np.random.Generator,
    budget: SearchBudget,
) -> Iterator[Guess]:
    for stop in range(len(osc.stops)):
        motions = _motions(osc, force, counts, (stop, BATCH, n_long), random)
        yield from _stretches(motions, counts, budget)
        if not budget.goes_on():
            return


@dataclass(frozen=True, slots=True)
class _Motion:
    """A motion that was followed from a stop: its record, and for how long."""

    osc: Oscillator
    law: Law
    record: tuple[Table, Integers]
    lasted: float


def _motions(
    osc: Oscillator,
    force: Forcing | None,
    counts: tuple[int, int],
    starts: tuple[int, int, int],
    random: np.random.Generator,
) -> Iterator[_Motion]:
    """Follow motions from a stop, so many for a few impacts and so many for long."""
    stop, n_short, n_long = starts
    runs = Propagator(osc, force)
    period, speed = float(runs.law[0, at.PERIOD]), scale_of_speed(osc, force, runs.law)
    sign = entry(osc, stop).sign * (-1.0 if isinstance(osc.stops[stop], Wall) else 1.0)
    place = as_float(osc.stops[stop].at)
    max_impacts, max_periods = counts
    for i in range(n_short + n_long):
        t0 = random.random() * period
        v0 = sign * speed * power(10.0, random.uniform(-2.0, 0.7))
        n_impacts = max_impacts + IMPACTS if i < n_short else SETTLING
        t_end = math.inf
        if period > 0.0:
            t_end = t0 + (n_impacts + 2) * max_periods * period
        events, marks = runs.follow(place, v0, t0, t_end=t_end, n_impacts=n_impacts)
        if i >= n_short:
            last = 6 * max_impacts * (len(osc.stops) + 1)
            events, marks = events[-last:], marks[-last:]
        lasted = t_end if math.isfinite(t_end) and len(events) < 2 else float(events[-1, 0])
        yield _Motion(osc, runs.law, (events.copy(), marks.copy()), lasted - t0)


def _stretches(
    motions: Iterator[_Motion],
    counts: tuple[int, int],
    budget: SearchBudget,
    *,
    exactly: bool = False,
) -> Iterator[Guess]:
    """Yield the guesses in motions."""
    for motion in motions:
        budget.followed(motion.lasted)
        found = guesses_in(motion.osc, motion.law, motion.record, *counts, exactly=exactly)
        for guess in found:
            yield replace(guess, trial=budget.n_done)
        budget.start_is_done()
        if not budget.goes_on():
            return


def scattered(
    osc: Oscillator,
    force: Forcing,
    stops: tuple[int, ...],
    n_periods: int,
    seed: int,
    budget: SearchBudget,
) -> Iterator[Guess]:
    """Yield guesses of orbits that meet given stops in turn, times and velocities at random.

    They need not be near to any motion, so that formal orbits are found from them as well.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    stops
        The stops met, in order.
    n_periods
        Forcing periods.
    seed
        Of the random numbers.
    looking
        Is told of each guess, and may end the search.

    Yields
    ------
    Guess
        All of one chain.
    """
    table = law(osc, force)
    chain = events_of_stops(osc, table, stops)
    n, period = len(chain), float(table[0, at.PERIOD])
    random = np.random.default_rng(seed)
    speed, signs = scale_of_speed(osc, force, table), signs_after(table, chain)
    for _ in range(SCATTERED):
        lasting = random.exponential(size=n) + 0.05
        lasting *= n_periods * period / lasting.sum()
        speeds = signs * speed * 10.0 ** random.uniform(-1.5, 0.7, size=n)
        unknowns = np.concatenate([[random.random() * period], lasting, speeds])
        yield Guess(chain, unknowns, len(stops), n_periods)
        budget.start_is_done()
        if not budget.goes_on():
            return


def signs_after(table: Law, chain: Integers) -> Floats:
    """Return the sign of the velocity after each event of a chain."""
    signs = np.sign(chain[:, AFTER] - chain[:, BEFORE]).astype(np.float64)
    lower = chain[:, AT] == table[chain[:, BEFORE], at.NUMBER]
    return np.where(signs == 0.0, np.where(lower, 1.0, -1.0), signs)


def scale_of_speed(osc: Oscillator, force: Forcing | None, table: Law) -> float:
    """Return a scale of the velocities that forcing, springs and gaps give."""
    n = int(table[0, at.N_HARMONICS])
    rows = table[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
    speed = float((rows[:, at.AMPLITUDE] / rows[:, at.OMEGA]).sum()) if n else 0.0
    spring = math.sqrt(abs(as_float(osc.stiffness)))
    speed += spring * max((abs(as_float(stop.at)) for stop in osc.stops), default=0.0)
    if force is not None:
        constant = abs(as_float(force.constant))
        speed += constant * (float(table[0, at.PERIOD]) or 1.0) * 0.5
    return speed or 1.0


def guesses_in(
    osc: Oscillator,
    table: Law,
    record: tuple[Table, Integers],
    max_impacts: int,
    max_periods: int,
    *,
    near: float = NEAR,
    exactly: bool = False,
) -> Iterator[Guess]:
    """Yield the stretches of a record that almost close, from impact to impact.

    Stretches with contact are left out. An infinite ``near`` takes all that end at their stop;
    ``exactly`` those with as many impacts and periods only.
    """
    events, marks = record
    chain = events_of_record(marks)
    kinds = marks[1:, columns.KIND]
    free = (kinds == columns.IMPACT) | (kinds == columns.CROSSING)
    met = [i for i, _ in entries_of(osc, table, chain) if free[i]]
    # Many pairs are looked at: plain numbers are faster than arrays.
    stuck = [0, *np.cumsum(~free).tolist()]
    places, regions = chain[:, AT].tolist(), chain[:, AFTER].tolist()
    t = events[1:, columns.EVENT_T] + events[1:, columns.EVENT_T_LOW]
    v = events[1:, columns.V_AFTER]
    instants, speeds = t.tolist(), v.tolist()
    period = float(table[0, at.PERIOD])
    for k, first in enumerate(met):
        for n_impacts in range(max_impacts if exactly else 1, max_impacts + 1):
            if k + n_impacts >= len(met):
                break
            last = met[k + n_impacts]
            if stuck[last + 1] > stuck[first]:
                break
            same = places[first] == places[last] and regions[first] == regions[last]
            apart, size = abs(speeds[last] - speeds[first]), abs(speeds[last]) + abs(speeds[first])
            if not same or (apart > 0.0 and apart > near * size):
                continue
            n_periods = 0
            if period > 0.0:
                lasting = (instants[last] - instants[first]) / period
                n_periods = round(lasting)
                apart = abs(lasting - n_periods)
                if math.isinf(near):
                    n_periods = max(n_periods, 1)
                least = max_periods if exactly else 1
                if not least <= n_periods <= max_periods or apart > near:
                    continue
            between = np.diff(t[first : last + 1])
            unknowns = np.concatenate([[t[first]], between, v[first:last]])
            rows = chain[first:last].copy()
            # The first event comes again at the end, out of the region it comes from then.
            rows[0, 1] = chain[last, 1]
            yield Guess(rows, unknowns, n_impacts, n_periods)


@dataclass(frozen=True, slots=True)
class Guess:
    """Where to start Newton's method.

    Attributes
    ----------
    chain
        (n, 3) array, the events.
    unknowns
        (2 n + 1,) array: instant of event 0, durations, velocities after the events.
    n_impacts, n_periods
        What the orbit would have.
    trial
        Which start of a search it comes from.
    """

    chain: Integers
    unknowns: Floats
    n_impacts: int
    n_periods: int
    trial: int = 0


GivenGuess: TypeAlias = tuple[float, float] | Trajectory | PeriodicOrbit


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
        reason = "neither two finite numbers (cycle, v_after) nor a run nor an orbit"
        raise ParameterError("guess", given, reason) from None
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
    scale = 1.0
    if periods:
        scale = n_periods * float(table[0, PERIOD]) / (times * orbit.period)
    itinerary = orbit.itinerary.repeated(times)
    unknowns = itinerary.vector
    unknowns[: 1 + len(itinerary)] *= scale
    return Guess(itinerary.events, unknowns, n_impacts, times * periods)


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
    runs = Propagator(osc, force)
    place = as_float(osc.stops[stop].at)
    end = t0 + (n_periods + 1) * period if period else math.inf
    events, marks = runs.follow(place, v, t0, t_end=end, n_impacts=n_impacts)
    # The start is told as the impact that it is meant to follow.
    chain = events_of_stops(osc, table, stops or (stop,) * n_impacts)
    record = _with_first(osc, table, stop, events.copy(), marks.copy())
    for guess in guesses_in(osc, table, record, n_impacts, 10**6, near=math.inf):
        met = tuple(k for _, k in entries_of(osc, table, guess.chain))
        if guess.n_impacts == n_impacts and (stops is None or met == stops):
            return _closed(guess, n_periods if period else 0, period)
    if not period:
        raise ParameterError("guess", impact, "the motion from it does not come back")
    n = len(chain)
    even = np.full(n, n_periods * period / n)
    unknowns = np.concatenate([[t0], even, abs(v) * signs_after(table, chain)])
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
    sign = entry(osc, stop).sign
    return -sign if isinstance(osc.stops[stop], Wall) else sign


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
