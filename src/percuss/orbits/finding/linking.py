"""Guesses of orbits put together from flights of several motions.

A motion that passes near an unstable orbit leaves it before it has gone round: with a multiplier
of 1000 one start of a thousand comes back. Flights from stop to stop, each near the orbit, are met
far more often. A closed sequence of flights, each ending near the start of the next, is a guess
for Newton's method, which takes the starts of all flights as unknowns.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import Law, Table
from percuss.kernels.record import Integers
from percuss.kernels.shooting import AFTER, AT, BEFORE
from percuss.model.oscillator import Oscillator
from percuss.orbits.finding.guess import Guess
from percuss.orbits.orbit.chain import chain_of_record, entries_of

__all__ = ["Flights"]

Floats = NDArray[np.float64]

# How far a flight may end from the start of the next one: in cycles, plus as a part of the
# velocities.
GAP = 0.15
# Closed sequences of each length that are tried, the best closed first, and the side of the cells
# in which one of them is enough.
TRIED = 60
CELL = 0.1
# The longest sequences, and how many are followed on to longer ones.
LONGEST = 4
MOST_PATHS = 20_000


@dataclass(frozen=True, slots=True)
class _Flight:
    """From a stop to the next stop: events on the way, and where it starts and ends."""

    rows: Integers
    times: Floats
    speeds: Floats
    arrives_from: int
    trial: int


class Flights:
    """The flights of some motions of one system.

    Parameters
    ----------
    osc
        The oscillator.
    table
        Its law, of a forcing with a period.
    """

    def __init__(self, osc: Oscillator, table: Law) -> None:
        self._osc, self._law = osc, table
        self._period = float(table[0, at.PERIOD])
        self._flights: list[_Flight] = []
        # Stop and region, cycle and velocity, of both ends.
        self._starts: list[tuple[int, int, float, float]] = []
        self._ends: list[tuple[int, int, float, float]] = []

    def add(self, record: tuple[Table, Integers], trial: int) -> None:
        """Add the flights of a motion, but those with contact."""
        events, marks = record
        chain = chain_of_record(marks)
        kinds = marks[1:, columns.KIND]
        free = (kinds == columns.IMPACT) | (kinds == columns.CROSSING)
        met = [i for i, _ in entries_of(self._osc, self._law, chain) if free[i]]
        t = events[1:, columns.EVENT_T] + events[1:, columns.EVENT_T_LOW]
        v = events[1:, columns.V_AFTER]
        for first, last in pairwise(met):
            if not free[first : last + 1].all():
                continue
            rows = chain[first:last].copy()
            self._flights.append(
                _Flight(rows, t[first : last + 1], v[first:last], int(chain[last, BEFORE]), trial)
            )
            for ends, k in ((self._starts, first), (self._ends, last)):
                place, region = int(chain[k, AT]), int(chain[k, AFTER])
                ends.append((place, region, float(t[k]) / self._period % 1.0, float(v[k])))

    def closed(self, max_impacts: int, max_periods: int) -> Iterator[Guess]:
        """Yield closed sequences of 2 to max_impacts flights, those of each length best first."""
        if len(self._flights) < 2:
            return
        gaps = self._gaps()
        paths = np.arange(len(gaps))[:, np.newaxis]
        misses = np.zeros(len(gaps))
        for _ in range(2, min(max_impacts, LONGEST) + 1):
            following = gaps[paths[:, -1]]
            # A sequence begins with the first of its flights: the others are turned about.
            following[np.arange(len(gaps)) < paths[:, :1]] = np.inf
            row, new = np.nonzero(following < GAP)
            paths = np.column_stack([paths[row], new])
            misses = np.maximum(misses[row], following[row, new])
            if len(paths) > MOST_PATHS:
                kept = np.argsort(misses, kind="stable")[:MOST_PATHS]
                paths, misses = paths[kept], misses[kept]
            whole = np.maximum(misses, gaps[paths[:, -1], paths[:, 0]])
            order = np.argsort(whole, kind="stable")
            yield from self._best(paths[order[whole[order] < GAP]], max_periods)

    def _gaps(self) -> Floats:
        """Return how far the end of each flight is from the start of each, inf elsewhere."""
        starts, ends = np.array(self._starts), np.array(self._ends)
        apart = np.abs(ends[:, np.newaxis, 2] - starts[:, 2])
        apart = np.minimum(apart, 1.0 - apart)
        sizes = np.abs(ends[:, np.newaxis, 3]) + np.abs(starts[:, 3])
        off = np.abs(ends[:, np.newaxis, 3] - starts[:, 3])
        gaps = apart + np.divide(off, sizes, out=np.zeros_like(off), where=sizes > 0.0)
        gaps[(ends[:, np.newaxis, :2] != starts[:, :2]).any(axis=2)] = np.inf
        return np.asarray(gaps)

    def _best(self, paths: Integers, max_periods: int) -> Iterator[Guess]:
        seen = set()
        for path in paths.tolist():
            if len(seen) >= TRIED:
                return
            if len(set(path)) < len(path):
                continue
            cell = tuple(round(self._starts[k][2] / CELL) for k in path)
            if cell in seen:
                continue
            seen.add(cell)
            guess = self._joined([self._flights[k] for k in path], max_periods)
            if guess is not None:
                yield guess

    def _joined(self, flights: list[_Flight], max_periods: int) -> Guess | None:
        durations = np.concatenate([np.diff(flight.times) for flight in flights])
        n_periods = round(float(durations.sum()) / self._period)
        if not 1 <= n_periods <= max_periods:
            return None
        rows = [flight.rows.copy() for flight in flights]
        for k, row in enumerate(rows):
            row[0, BEFORE] = flights[k - 1].arrives_from
        speeds = np.concatenate([flight.speeds for flight in flights])
        unknowns = np.concatenate([flights[0].times[:1], durations, speeds])
        trial = flights[0].trial
        return Guess(np.concatenate(rows), unknowns, len(flights), n_periods, trial)
