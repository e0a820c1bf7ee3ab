"""Where Newton's method starts: stretches of motions that almost close."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import Law, Table
from percuss.kernels.record import Integers
from percuss.kernels.shooting import AFTER, AT, BEFORE
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.numerics import power
from percuss.orbits.finding.guess import Guess
from percuss.orbits.finding.looking import Looking
from percuss.orbits.orbit.chain import chain_of_record, chain_of_stops, entries_of, entry
from percuss.orbits.orbit.short_runs import ShortRuns

__all__ = ["Guess", "batches", "guesses", "guesses_in", "scale_of_speed", "scattered", "starts_of"]

Floats = NDArray[np.float64]

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
    looking: Looking,
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
        yield from _stretches(motions, (max_impacts, max_periods), looking, exactly=exactly)
        if not looking.goes_on():
            return


def batches(
    osc: Oscillator,
    force: Forcing,
    max_impacts: int,
    max_periods: int,
    seed: int,
    looking: Looking,
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
        yield _batch(osc, force, counts, LONG if batch == 0 else 0, random, looking)
        if not looking.goes_on():
            return


def _batch(
    osc: Oscillator,
    force: Forcing,
    counts: tuple[int, int],
    n_long: int,
    random: np.random.Generator,
    looking: Looking,
) -> Iterator[Guess]:
    for stop in range(len(osc.stops)):
        motions = _motions(osc, force, counts, (stop, BATCH, n_long), random)
        yield from _stretches(motions, counts, looking)
        if not looking.goes_on():
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
    runs = ShortRuns(osc, force)
    period, speed = float(runs.law[0, at.PERIOD]), scale_of_speed(osc, force, runs.law)
    way = entry(osc, stop).way * (-1.0 if isinstance(osc.stops[stop], Wall) else 1.0)
    place = as_float(osc.stops[stop].at)
    max_impacts, max_periods = counts
    for i in range(n_short + n_long):
        t0 = random.random() * period
        v0 = way * speed * power(10.0, random.uniform(-2.0, 0.7))
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
    looking: Looking,
    *,
    exactly: bool = False,
) -> Iterator[Guess]:
    """Yield the guesses in motions."""
    for motion in motions:
        looking.followed(motion.lasted)
        found = guesses_in(motion.osc, motion.law, motion.record, *counts, exactly=exactly)
        for guess in found:
            yield replace(guess, trial=looking.n_done)
        looking.start_is_done()
        if not looking.goes_on():
            return


def scattered(
    osc: Oscillator,
    force: Forcing,
    stops: tuple[int, ...],
    n_periods: int,
    seed: int,
    looking: Looking,
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
    chain = chain_of_stops(osc, table, stops)
    n, period = len(chain), float(table[0, at.PERIOD])
    random = np.random.default_rng(seed)
    speed, ways = scale_of_speed(osc, force, table), ways_after(table, chain)
    for _ in range(SCATTERED):
        lasting = random.exponential(size=n) + 0.05
        lasting *= n_periods * period / lasting.sum()
        speeds = ways * speed * 10.0 ** random.uniform(-1.5, 0.7, size=n)
        unknowns = np.concatenate([[random.random() * period], lasting, speeds])
        yield Guess(chain, unknowns, len(stops), n_periods)
        looking.start_is_done()
        if not looking.goes_on():
            return


def ways_after(table: Law, chain: Integers) -> Floats:
    """Return the sign of the velocity after each event of a chain."""
    ways = np.sign(chain[:, AFTER] - chain[:, BEFORE]).astype(np.float64)
    lower = chain[:, AT] == table[chain[:, BEFORE], at.NUMBER]
    return np.where(ways == 0.0, np.where(lower, 1.0, -1.0), ways)


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
    chain = chain_of_record(marks)
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
