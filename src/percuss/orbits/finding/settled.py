"""The attractors to which motions from many starts settle in direct simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError
from percuss.kernels import record as columns
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import as_float
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.system import System
from percuss.numerics import power
from percuss.orbits.finding.search import Guess, guesses_in, scale_of_speed
from percuss.orbits.finding.search_budget import SearchBudget
from percuss.orbits.orbit.extremes import Extremes, extremes_of, extremes_of_record
from percuss.orbits.orbit.knots import without_knots
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.propagator import Propagator
from percuss.orbits.orbit.signature import are_same
from percuss.orbits.orbit.solve import attracts, orbit_of_solution, solve
from percuss.orbits.orbit.steady import regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits

# Forcing periods of a stage of a run and of the end of it that is examined, and the most stages.
STAGE, TAIL, STAGES = 60, 25, 5
# Largest distance of the ends of a stretch of a motion that is near its orbit.
NEAR = 0.05
# Stretches of one length that are tried: a motion that settles comes nearer with each, or in turns
# where it spirals in slowly.
LATEST = 10
# In the last stage orbits have up to so many times the impacts and periods that are asked for.
LONGER = 4
# Distance of the last stretch from its orbit, in cycles and as a part of the velocity.
CLOSE = 0.1
# A motion this near a known attractor has settled on it.
ARRIVED = 1e-6


@dataclass(frozen=True, slots=True)
class Settled:
    """The attractor of a motion.

    Attributes
    ----------
    n_impacts, n_periods
        Impacts and forcing periods of the orbit; inf with sticking; NaN and 0 without a period.
    orbit
        The `PeriodicOrbit` or `StructureOrbit`; None where no period was found.
    state
        (x, v) at a whole number of periods near the end of the run; of a structure all of them.
    impact_speed
        The largest, of the orbit or near the end of the run [length/time]; NaN without impacts.
    extremes
        Of the orbit, or of the end of the run.
    """

    n_impacts: float
    n_periods: int
    orbit: Any | None
    state: tuple[float, ...]
    impact_speed: float
    extremes: Extremes


def settled_motions(
    system: System,
    max_impacts: int,
    max_periods: int,
    *,
    n_starts: int,
    seed: int,
    also: Sequence[tuple[float, float]] = (),
    budget: SearchBudget | None = None,
) -> list[Settled]:
    """Follow motions from many starts for long and return their attractors, each once.

    Parameters
    ----------
    system
        Oscillator and forcing; the forcing has a period.
    max_impacts, max_periods
        The longest orbits that are searched for first; then those up to four times as long.
    n_starts
        Number of motions: one from rest, the others at random.
    seed
        Of the random starts.
    also
        More starts, (x, v) at t = 0; those beyond a wall are left out.
    budget
        Counts the starts, and may end the search.

    Returns
    -------
    list of Settled
        Motions for which no period was found count as one attractor.
    """
    search = _Search(system, (max_impacts, max_periods), budget)
    starts = [(x, v, 0.0) for x, v in also if _is_free(system.oscillator, x)]
    for start in starts + _starts(system, n_starts, seed):
        search.follow(start)
        if budget is not None:
            budget.start_is_done()
            if not budget.goes_on():
                break
    return search.attractors


def _is_free(osc: Oscillator, x: float) -> bool:
    walls = [stop for stop in osc.stops if isinstance(stop, Wall)]
    return all(x <= as_float(w.at) if w.side == "above" else x >= as_float(w.at) for w in walls)


def _starts(system: System, n_starts: int, seed: int) -> list[tuple[float, float, float]]:
    """Return (x, v, t0) of starts at the stops and at rest, at any phase."""
    random, osc = np.random.default_rng(seed), system.oscillator
    period, speed = float(system.law[0, PERIOD]), scale_of_speed(system)
    places = [as_float(stop.at) for stop in osc.stops] or [0.0]
    rest = 0.0
    for stop in osc.stops:
        at = as_float(stop.at)
        rest = min(rest, at) if stop.side == "above" else max(rest, at)
    starts = [(rest, 0.0, 0.0)]
    for i in range(n_starts - 1):
        x = places[i % len(places)]
        sign = -1.0 if osc.stops and osc.stops[i % len(places)].side == "above" else 1.0
        v = sign * speed * power(10.0, random.uniform(-1.5, 0.7))
        starts.append((x, v, random.random() * period))
    return starts


class _Search:
    """The attractors of one system that have been found."""

    def __init__(
        self, system: System, counts: tuple[int, int], budget: SearchBudget | None
    ) -> None:
        self.system, self.counts, self.budget = system, counts, budget
        self.runs = Propagator(system)
        self.period = float(self.runs.law[0, PERIOD])
        self.attractors: list[Settled] = []

    @cached_property
    def sticking(self) -> list[PeriodicOrbit]:
        return sticking_orbits(self.system, self.counts[1])

    def follow(self, start: tuple[float, float, float]) -> None:
        """Follow a motion, and add its attractor if that is new."""
        x, v, t0 = start
        for stage in range(STAGES):
            end = t0 + STAGE * self.period
            record = self.runs.follow(x, v, t0, t_end=end)
            if self.budget is not None:
                self.budget.followed(STAGE * self.period)
                if not self.budget.goes_on():
                    return
            x, v = self.runs.state_at(x, end)
            t0 = end % self.period
            if not (math.isfinite(x) and math.isfinite(v)):
                return
            if any(_is_on(known, record, self.period) for known in self.attractors):
                return
            tail = _tail(record, end, self.period)
            orbit = self._orbit_of(tail, LONGER if stage == STAGES - 1 else 1)
            if orbit is not None:
                self._add(orbit, (x, v))
                return
        if all(known.orbit is not None for known in self.attractors):
            extremes = extremes_of_record(self.runs.law, *tail, start[0], end)
            self.attractors.append(Settled(math.nan, 0, None, (x, v), _fastest(tail), extremes))

    def _add(self, orbit: PeriodicOrbit, state: tuple[float, float]) -> None:
        known = [other.orbit for other in self.attractors if other.orbit is not None]
        if any(are_same(orbit, other) for other in known):
            return
        speed = float(np.abs(orbit.impacts.v_before).max()) if orbit.n_impacts else math.nan
        counts = orbit.n_impacts, orbit.n_periods
        self.attractors.append(Settled(*counts, orbit, state, speed, extremes_of(orbit)))

    def _orbit_of(self, tail: tuple[Floats, Integers], longer: int) -> PeriodicOrbit | None:
        """Return the attracting orbit on which a motion ends, None if none is found."""
        events, marks = tail
        kinds = marks[1:, columns.KIND]
        if len(kinds) == 0:
            return _without_impacts(self.system, int(marks[0, columns.NEXT_REGION]))
        if (kinds == columns.CONTACT).any():
            return self.sticking[0] if self.sticking else None
        # The shortest stretch that closes is the orbit.
        most = longer * self.counts[0], longer * self.counts[1]
        last = 3 * (most[0] + 1) * (len(self.system.oscillator.stops) + 1)
        record = events[-last:], marks[-last:]
        guesses = list(guesses_in(self.system, record, *most, near=NEAR))
        for _, alike in groupby(sorted(guesses, key=_length), key=_length):
            for guess in list(alike)[-LATEST:]:
                orbit = _attractor(self.system, guess)
                if orbit is not None:
                    return orbit
        return None


def _length(guess: Guess) -> tuple[int, int]:
    return guess.n_periods, guess.n_impacts


def _tail(record: tuple[Floats, Integers], end: float, period: float) -> tuple[Floats, Integers]:
    """Return the last part of a record; its first row stands for a start."""
    events, marks = without_knots(*record)
    first = int(np.searchsorted(events[:, columns.EVENT_T], end - TAIL * period))
    return events[max(first - 1, 0) :].copy(), marks[max(first - 1, 0) :].copy()


def _fastest(tail: tuple[Floats, Integers]) -> float:
    events, marks = tail
    met = np.isin(marks[1:, columns.KIND], [columns.IMPACT, columns.CROSSING])
    speeds = np.abs(events[1:, columns.V_BEFORE])[met]
    return float(speeds.max()) if len(speeds) else math.nan


def _is_on(known: Settled, record: tuple[Floats, Integers], period: float) -> bool:
    """Return whether the last event of a record is one of a known orbit."""
    orbit = known.orbit
    if orbit is None or orbit.n_impacts == 0 or math.isinf(orbit.n_impacts):
        return False
    events, _ = without_knots(*record)
    last, own = events[-1], orbit.record[0][1:]
    if len(events) <= len(own):
        return False
    speed = float(np.abs(own[:, columns.V_AFTER]).max())
    cycles = (last[columns.EVENT_T] - own[:, columns.EVENT_T]) / period
    phases = np.abs(cycles - np.round(cycles))
    velocities = np.abs(own[:, columns.V_AFTER] - last[columns.V_AFTER]) / speed
    return bool((np.maximum(phases, velocities) < ARRIVED).any())


def _without_impacts(system: System, region: int) -> PeriodicOrbit | None:
    """Return the steady motion of a region, if it attracts and stays there."""
    if region not in regions(system.law):
        return None
    try:
        orbit = steady_orbit(system, region)
    except ConvergenceError:
        return None
    return orbit if orbit.is_stable and orbit.admissible else None


def _attractor(system: System, guess: Guess) -> PeriodicOrbit | None:
    """Return the orbit next to a stretch of a motion, if there is one and it attracts."""
    solution = solve(system, guess.itinerary)
    if not solution.converged:
        return None
    near, stretch = solution.itinerary, guess.itinerary
    distances = np.abs(near.vector - stretch.vector)
    largest = np.repeat(
        [stretch.period, np.abs(stretch.velocities).max()], [1 + len(near), len(near)]
    )
    if (distances > CLOSE * largest).any():
        return None
    times = near.times_covered
    if times > 1:
        solution = solve(system, near.primitive(times))
    if not attracts(system, solution):
        return None
    orbit = orbit_of_solution(system, solution)
    return orbit if orbit.admissible else None
