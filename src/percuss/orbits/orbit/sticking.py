"""Orbits with sticking: from a release to a release.

The release from a wall does not depend on the past: it is where the force lets go. So a motion
that sticks once starts afresh from one of finitely many instants of the cycle, and is periodic
as soon as one of them comes back, exactly. Its multipliers are zero.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Flags, Integers
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import later
from percuss.kernels.flight import place
from percuss.kernels.law import PERIOD, Law, Table
from percuss.kernels.sample import cycles
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.orbits.orbit.itinerary import entry
from percuss.orbits.orbit.making import impacts_of_record
from percuss.orbits.orbit.passages import TurningPoints, margin_of, passages_of, turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.propagator import Propagator

__all__ = ["releases_of", "sticking_orbit_near", "sticking_orbits"]

EventRecord = tuple[Table, Integers]

# Instants of the cycle at which a wall is asked whether it holds the mass.
ASKED = 64
# Impacts of a forcing period: hops on a wall with restitution near 1 are many.
MOST_IMPACTS = 10_000
# Releases, as parts of a cycle, that are one and the same; and those of similar systems.
SAME, GOES_ON = 1e-9, 0.1
# Turning points so soon after a release, as a part of the period, are the release: the mass leaves
# from rest, as the cube of time, and rounding makes it turn.
AT_RELEASE = 1e-6


def sticking_orbits(osc: Oscillator, force: Forcing, max_periods: int) -> list[PeriodicOrbit]:
    """Return all orbits with sticking that last at most so many forcing periods.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    max_periods
        How many forcing periods to follow a motion from each release.

    Returns
    -------
    list of PeriodicOrbit
        The shorter first.

    Examples
    --------
    >>> import percuss as pc
    >>> osc, force = pc.ball_on_table(amplitude="1.2", omega=1, gravity=1, restitution="0.5")
    >>> sticking_orbits(osc, force, 4)
    [<PeriodicOrbit: sticking in 1 forcing period, T = 6.28319, asymptotic, \
abs(multipliers) 0, 0>]
    """
    runs = Propagator(osc, force)
    period = float(runs.law[0, PERIOD])
    found: list[PeriodicOrbit] = []
    seen: list[tuple[int, float]] = []
    for wall, held, _ in _releases(runs, osc, period):
        for record, n_periods in _returns(runs, osc, wall, held, period, max_periods):
            events, _ = record
            key = wall, _cycle(runs.law, events[0])
            if any(_same(key, other) for other in seen):
                continue
            orbit = _orbit(osc, force, runs.law, record, n_periods)
            seen += _releases_of(runs.law, osc, record)
            found.append(orbit)
    return sorted(found, key=lambda orbit: orbit.n_periods)


def releases_of(orbit: PeriodicOrbit) -> list[tuple[int, float]]:
    """Return (wall, cycle) of each release of an orbit with sticking, in the order of time."""
    table = law(orbit.oscillator, orbit.forcing)
    return _releases_of(table, orbit.oscillator, orbit.record)


def sticking_orbit_near(
    osc: Oscillator, force: Forcing, orbit: PeriodicOrbit
) -> PeriodicOrbit | None:
    """Return the orbit with sticking that goes on from one of a similar system.

    A release that lies near to one of that orbit comes back after as many forcing periods.

    Parameters
    ----------
    osc, force
        What moves.
    orbit
        With sticking, of a system with as many stops.

    Returns
    -------
    PeriodicOrbit or None
        None if no such release comes back so.
    """
    runs = Propagator(osc, force)
    period = float(runs.law[0, PERIOD])
    there = _releases(runs, osc, period)
    known = releases_of(orbit)
    # It is told from the first impact after its last release: so this one is, too.
    for stop, cycle in known[-1:] + known[:-1]:
        for wall, held, again in there:
            apart = abs(cycle - again)
            if wall != stop or min(apart, 1.0 - apart) > GOES_ON:
                continue
            for record, n in _returns(runs, osc, wall, held, period, orbit.n_periods):
                if n == orbit.n_periods:
                    return _orbit(osc, force, runs.law, record, n)
    return None


def _releases(runs: Propagator, osc: Oscillator, period: float) -> list[tuple[int, float, float]]:
    """Return (wall, an instant at which it holds the mass, cycle) for each release of a period."""
    found: list[tuple[int, float, float]] = []
    known: list[tuple[int, float]] = []
    for stop, it in enumerate(osc.stops):
        # Elastic hops never end: no motion comes to stick there.
        if not isinstance(it, Wall) or as_float(it.restitution) == 1.0:
            continue
        for asked in np.arange(ASKED) * (period / ASKED):
            events, marks = runs.follow(as_float(it.at), 0.0, asked, t_end=asked + 1.02 * period,
                                        n_impacts=1)  # fmt: skip
            kinds = marks[:3, columns.KIND]
            if len(kinds) < 3 or kinds[1] != columns.CONTACT or kinds[2] != columns.RELEASE:
                continue
            key = stop, _cycle(runs.law, events[2])
            if not any(_same(key, other) for other in known):
                known.append(key)
                found.append((stop, float(asked), key[1]))
    return found


def _returns(
    runs: Propagator, osc: Oscillator, wall: int, held: float, period: float, max_periods: int
) -> list[tuple[EventRecord, int]]:
    """Return the motion from a release to the same one again, and the periods it took."""
    at = as_float(osc.stops[wall].at)
    end = held + (max_periods + 1.1) * period
    limit = MOST_IMPACTS * max_periods
    events, marks = runs.follow(at, 0.0, held, t_end=end, n_impacts=limit)
    bound = entry(osc, wall).bound
    first = events[2]
    released = np.flatnonzero(
        (marks[:, columns.KIND] == columns.RELEASE) & (marks[:, columns.BOUND] == bound)
    )
    for i in released[1:]:
        lasted = events[i] - first
        time = lasted[columns.EVENT_T] + lasted[columns.EVENT_T_LOW]
        n = round(time / period)
        if 1 <= n <= max_periods and abs(time - n * period) <= SAME * period:
            record = events[2 : i + 1].copy(), marks[2 : i + 1].copy()
            # An orbit is told from an impact; one that only lands at rest has none.
            return [(record, n)] if (record[1][:, columns.KIND] == columns.IMPACT).any() else []
    return []


def _releases_of(table: Law, osc: Oscillator, record: EventRecord) -> list[tuple[int, float]]:
    """Return (wall, cycle) of the releases in a record."""
    events, marks = record
    stops = {entry(osc, i).bound: i for i, it in enumerate(osc.stops) if isinstance(it, Wall)}
    return [
        (stops[int(mark[columns.BOUND])], _cycle(table, event))
        for event, mark in zip(events, marks, strict=True)
        if mark[columns.KIND] == columns.RELEASE
    ]


def _cycle(table: Law, event: Table) -> float:
    out = np.empty(1)
    t, t_low = event[columns.EVENT_T], event[columns.EVENT_T_LOW]
    cycles(table, np.array([t]), np.array([t_low]), out)
    return float(out[0])


def _same(one: tuple[int, float], other: tuple[int, float]) -> bool:
    apart = abs(one[1] - other[1])
    return one[0] == other[0] and min(apart, 1.0 - apart) <= SAME


def _orbit(
    osc: Oscillator, force: Forcing, table: Law, record: EventRecord, n_periods: int
) -> PeriodicOrbit:
    """Return the orbit that goes round a record, told from its first impact on."""
    period = n_periods * float(table[0, PERIOD])
    events, marks = _from_first_impact(*record, period)
    x0 = place(table, int(marks[-1, columns.NEXT_REGION]), int(marks[-1, columns.BOUND]))
    turns = turns_of(table, events, marks, x0, float(events[-1, columns.EVENT_T]))
    turns = _after_releases(turns, events, marks, period)
    passages = passages_of(osc, turns)
    first, last = record[0][0], record[0][-1]
    missed = (last[columns.EVENT_T] - first[columns.EVENT_T] - period) + (
        last[columns.EVENT_T_LOW] - first[columns.EVENT_T_LOW]
    )
    return PeriodicOrbit(
        oscillator=osc,
        forcing=force,
        x0=x0,
        v0=float(events[0, columns.V_AFTER]),
        t0=float(events[0, columns.EVENT_T]),
        impacts=impacts_of_record(osc, table, events, marks),
        n_impacts=math.inf,
        n_periods=n_periods,
        period=period,
        monodromy=np.zeros((2, 2)),
        multipliers=np.zeros(2, dtype=np.complex128),
        stability="asymptotic",
        admissible=len(passages) == 0,
        grazing_margin=margin_of(turns, _not_in_hops(turns, marks)),
        passages=passages,
        min_impact_speed=0.0,
        isolated=True,
        residual=abs(float(missed)),
        _events=events,
        _marks=marks,
        _chain=np.empty((0, 3), dtype=np.int64),
        _unknowns=np.empty(0),
    )


def _from_first_impact(events: Table, marks: Integers, period: float) -> EventRecord:
    """Return a record from a release to a release as one from an impact to that impact."""
    i = int(np.flatnonzero(marks[:, columns.KIND] == columns.IMPACT)[0])
    again = np.concatenate([events[i:], events[1 : i + 1]])
    kinds = np.concatenate([marks[i:], marks[1 : i + 1]])
    # The first impact goes into the first forcing period, and comes once more at the end.
    start = -period * math.floor(float(events[i, columns.EVENT_T]) / period)
    for k, row in enumerate(again):
        shift = start + (period if k >= len(events) - i else 0.0)
        instant = later(row[columns.EVENT_T], row[columns.EVENT_T_LOW], shift)
        row[columns.EVENT_T], row[columns.EVENT_T_LOW] = instant
    kinds[0] = columns.START, -1, kinds[0, columns.NEXT_REGION]
    again[0, columns.V_BEFORE] = again[0, columns.V_AFTER]
    return again, kinds


def _after_releases(
    turns: TurningPoints, events: Table, marks: Integers, period: float
) -> TurningPoints:
    """Return turning points without those that rounding makes of a release."""
    since = turns.t - events[turns.flight, columns.EVENT_T]
    released = marks[turns.flight, columns.KIND] == columns.RELEASE
    kept = ~released | (since > AT_RELEASE * period)
    return TurningPoints(
        turns.t[kept], turns.clearance[kept], turns.bound[kept], turns.flight[kept],
        turns.doubt[kept],
    )  # fmt: skip


def _not_in_hops(turns: TurningPoints, marks: Integers) -> Flags:
    """Tell which turning points are not the one of a flight from a wall back to it."""
    bounds = marks[:, columns.BOUND].copy()
    bounds[0] = bounds[-1]
    flights = np.minimum(turns.flight, len(marks) - 2)
    alone = np.bincount(turns.flight, minlength=len(marks))[turns.flight] == 1
    return np.asarray(~(alone & (bounds[flights] == bounds[flights + 1])))
