"""The itinerary of a motion: the sequence, instants and velocities of its events."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.law_columns import Law
from percuss.kernels.shooting import ITINERARY_COLUMNS
from percuss.model.oscillator import Oscillator, Wall, stops_in_words
from percuss.model.system import System, lines

# Itineraries that differ by less than this part of the period and of the largest velocity are the
# same: Newton's method finds an orbit to some 1e-12.
TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Itinerary:
    """The events of a periodic motion, in order.

    Attributes
    ----------
    events
        (n, 3) array, the bound of each event and the regions before and after it.
    start
        Instant of the first one [time].
    durations
        (n,) array, durations of the flights after the events [time].
    velocities
        (n,) array, velocities after the events [length/time]; (n, m) with m unknowns an event.
    n_periods
        Number of forcing periods; 0 without forcing.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    >>> twice = orbit.itinerary.repeated(2)
    >>> len(twice), twice.n_periods, len(twice.primitive(2))
    (2, 2, 1)
    """

    events: Integers
    start: float
    durations: Floats
    velocities: Floats
    n_periods: int

    @classmethod
    def of_vector(cls, events: Integers, vector: Floats, n_periods: int) -> Itinerary:
        """Return the itinerary with these unknowns: instant, durations, velocities."""
        n = len(events)
        start = float(vector[0]) if len(vector) else np.nan
        velocities = vector[1 + n :]
        if len(velocities) != n:
            velocities = velocities.reshape(n, -1)
        return cls(events, start, vector[1 : 1 + n], velocities, n_periods)

    def __len__(self) -> int:
        """Return the number of events."""
        return len(self.events)

    @property
    def vector(self) -> Floats:
        """The unknowns as one array: instant, durations, velocities."""
        return np.concatenate([[self.start], self.durations, self.velocities.ravel()])

    @property
    def period(self) -> float:
        """The sum of the durations [time]."""
        return float(self.durations.sum())

    @property
    def instants(self) -> Floats:
        """(n,) array, the instants of the events [time]."""
        return self.start + np.append(0.0, np.cumsum(self.durations[:-1]))[: len(self)]

    @property
    def times_covered(self) -> int:
        """How often the motion covers a primitive orbit; 1 if it is primitive itself."""
        n = len(self)
        tolerances = TOLERANCE * self.durations.sum(), TOLERANCE * np.abs(self.velocities).max()
        # A forced orbit lasts whole forcing periods; one of free motion needs none.
        most = n if self.n_periods == 0 else math.gcd(n, self.n_periods)
        for times in range(most, 1, -1):
            shift, rest = divmod(n, times)
            if (
                rest == self.n_periods % times == 0
                and (self.events == np.roll(self.events, shift, axis=0)).all()
                and _is_near(self.durations, shift, tolerances[0])
                and _is_near(self.velocities, shift, tolerances[1])
            ):
                return times
        return 1

    def repeated(self, times: int) -> Itinerary:
        """Return the n-fold cover of the motion."""
        events, durations, velocities = (
            np.concatenate([part] * times)
            for part in (self.events, self.durations, self.velocities)
        )
        return Itinerary(events, self.start, durations, velocities, times * self.n_periods)

    def primitive(self, times: int) -> Itinerary:
        """Return the primitive motion whose n-fold cover this is, or nearly: then the mean."""
        n = len(self) // times
        durations, velocities = (
            part.reshape(times, n, *part.shape[1:]).mean(axis=0)
            for part in (self.durations, self.velocities)
        )
        events = self.events[:n].copy()
        return Itinerary(events, self.start, durations, velocities, self.n_periods // times)

    def mirrored_mean(self) -> Itinerary:
        """Return the nearest motion whose second half mirrors the first."""
        first, second = np.split(self.velocities, 2)
        durations = self.durations.reshape(2, -1).mean(axis=0)
        velocities = 0.5 * (first - second)
        return Itinerary(
            self.events,
            self.start,
            np.append(durations, durations),
            np.concatenate([velocities, -velocities]),
            self.n_periods,
        )

    def halves_differ(self) -> float:
        """Return the difference of the two halves, in periods and largest velocities.

        Infinite if their events differ, or if the number of forcing periods is odd.
        """
        n = len(self)
        if n == 0 or n % 2 or self.n_periods % 2:
            return float("inf")
        if (self.events[: n // 2] != self.events[n // 2 :]).any():
            return float("inf")
        durations, velocities = (
            np.subtract(*np.split(part, 2)) for part in (self.durations, self.velocities)
        )
        fastest = float(np.abs(self.velocities).max()) or 1.0
        return float(max(np.abs(durations).max() / self.period, np.abs(velocities).max() / fastest))

    def without(self, rows: Collection[int], first: int) -> Itinerary:
        """Return the motion without the events of some rows, beginning with the row ``first``."""
        n, instants = len(self), self.instants
        kept = [(first + k) % n for k in range(n) if (first + k) % n not in rows]
        after = np.cumsum(np.roll(self.durations, -first))
        offsets = np.append(0.0, after)[[(row - first) % n for row in kept]]
        durations = np.diff(np.append(offsets, after[-1]))
        return Itinerary(
            np.ascontiguousarray(self.events[kept]),
            float(instants[first]),
            durations,
            self.velocities[kept],
            self.n_periods,
        )

    def inserted(
        self, instants: Floats, events: Integers, period: float
    ) -> tuple[Itinerary, Integers]:
        """Return the motion with more events, at zero velocity, and the order of old and new.

        Parameters
        ----------
        instants
            (m,) array, in the period after the start.
        events
            (m, 3) array.
        period
            Period of the motion [time]; nothing else gives it where there are no events.
        """
        every = np.append(self.instants, instants)
        order = np.argsort(every, kind="stable")
        added = np.zeros((len(instants), *self.velocities.shape[1:]))
        whole = Itinerary(
            np.concatenate([self.events, events])[order],
            float(every[order[0]]),
            np.diff(np.append(every[order], every[order[0]] + period)),
            np.concatenate([self.velocities, added])[order],
            self.n_periods,
        )
        return whole, order


def _is_near(values: Floats, shift: int, tolerance: float) -> bool:
    return bool((np.abs(values - np.roll(values, shift)) <= tolerance).all())


@dataclass(frozen=True, slots=True)
class Entry:
    """The event of meeting a stop.

    Attributes
    ----------
    stop
        Index of the stop.
    bound
        Number of the bound at which it lies.
    before, after
        Numbers of the regions before and after the event.
    sign
        Sign of the velocity before it.
    """

    stop: int
    bound: int
    before: int
    after: int
    sign: float


def row_of_region(law: Law, number: int) -> int:
    """Return the row of a region of a law."""
    return _row(int(law[0, at.N_HARMONICS]), number)


def _row(n_harmonics: int, number: int) -> int:
    return at.FIRST_HARMONIC + n_harmonics + number * (1 + n_harmonics)


def entry(osc: Oscillator, stop: int) -> Entry:
    """Return the event of meeting a stop from its free side.

    Parameters
    ----------
    osc
        The oscillator.
    stop
        Index into its stops.

    Returns
    -------
    Entry
        Bound and regions.

    Raises
    ------
    ParameterError
        If there is no such stop.

    Examples
    --------
    >>> import percuss as pc
    >>> entry(pc.backlash_oscillator(gap=1.0, stiffness=9.0), 1)
    Entry(stop=1, bound=2, before=1, after=2, sign=1.0)
    """
    if not 0 <= stop < len(osc.stops):
        reason = stops_in_words(osc)
        raise ParameterError("stop", stop, reason)
    layout = lines(osc)
    above = osc.stops[stop].side == "above"
    edges = zip(layout.wall, layout.edges, strict=True)
    bound = next(i for i, (wall, edge) in enumerate(edges) if wall == stop or stop in edge)
    before = bound - 1 if above else bound
    after = before
    if not isinstance(osc.stops[stop], Wall):
        after = bound if above else bound - 1
    return Entry(stop, bound, before, after, 1.0 if above else -1.0)


def events_of_stops(system: System, stops: Sequence[int]) -> Integers:
    """Return the events of a motion that meets these stops in turn, and then the first again.

    Between two of them it leaves the soft stops that lie between.

    Parameters
    ----------
    system
        Oscillator and forcing.
    stops
        Indices of the stops, in the order in which they are met; at least one.

    Returns
    -------
    array
        (n, 3), as `percuss.kernels.shooting` takes them.

    Raises
    ------
    ParameterError
        If there is no such stop, or another one lies between two of them.
    """
    law = system.law
    entries = [entry(system.oscillator, stop) for stop in stops]
    events: list[tuple[int, int, int]] = []
    for this, following in zip(entries, [*entries[1:], entries[0]], strict=True):
        events.append((this.bound, this.before, this.after))
        region = this.after
        while region != following.before:
            up = following.before > region
            row = row_of_region(law, region)
            if law[row, at.UPPER_ENTRY if up else at.LOWER_ENTRY] == 1.0:
                reason = f"between stops {this.stop} and {following.stop} another one is met"
                raise ParameterError("sequence", tuple(stops), reason)
            step = 1 if up else -1
            events.append((region + 1 if up else region, region, region + step))
            region += step
    rows = [[b, row_of_region(law, i), row_of_region(law, j)] for b, i, j in events]
    return np.array(rows, dtype=np.int64).reshape(-1, ITINERARY_COLUMNS)


def events_of_record(marks: Integers) -> Integers:
    """Return the impacts and crossings in a record of `march`, without its START."""
    before = marks[:-1, columns.NEXT_REGION]
    rows = np.column_stack([marks[1:, columns.BOUND], before, marks[1:, columns.NEXT_REGION]])
    return np.ascontiguousarray(rows, dtype=np.int64)


@lru_cache(maxsize=64)
def _entries(osc: Oscillator, n_harmonics: int) -> dict[tuple[int, int, int], int]:
    """Return the stop that each event meets, of those that meet one."""
    stops = {}
    for stop in reversed(range(len(osc.stops))):
        met = entry(osc, stop)
        stops[met.bound, _row(n_harmonics, met.before), _row(n_harmonics, met.after)] = stop
    return stops


def entries_of(system: System, events: Integers) -> list[tuple[int, int]]:
    """Return (row, stop) of the events that meet a stop; others leave one."""
    stops = _entries(system.oscillator, int(system.law[0, at.N_HARMONICS]))
    rows: Iterable[tuple[int, int, int]] = map(tuple, events.tolist())
    return [(i, stops[row]) for i, row in enumerate(rows) if row in stops]


def is_wall(law: Law, events: Integers) -> list[bool]:
    """Return of each event whether it is an impact on a wall."""
    kinds: list[bool] = []
    for bound, before, _ in events:
        lower = bound == int(law[before, at.NUMBER])
        kinds.append(bool(law[before, at.LOWER_KIND if lower else at.UPPER_KIND] == at.WALL))
    return kinds


def is_plastic(law: Law, events: Integers) -> list[bool]:
    """Return of each event whether it is an impact with restitution 0, whatever its speed."""
    plastic: list[bool] = []
    for (bound, before, _), hits in zip(events, is_wall(law, events), strict=True):
        lower = bound == int(law[before, at.NUMBER])
        restitution = law[before, at.LOWER_RESTITUTION if lower else at.UPPER_RESTITUTION]
        table = law[before, at.LOWER_TABLE if lower else at.UPPER_TABLE]
        plastic.append(bool(hits and restitution == table == 0.0))
    return plastic
