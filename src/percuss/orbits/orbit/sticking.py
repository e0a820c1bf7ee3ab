"""Orbits with sticking: from a release to a release.

The release from a wall does not depend on the past: it is where the force on the mass changes its
sign. So a motion that sticks once starts afresh from one of finitely many instants of the cycle,
and is periodic, exactly, as soon as one of them recurs. Its multipliers are zero.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import later
from percuss.kernels.flight import place
from percuss.kernels.law_columns import N_KNOTS, PERIOD, Law
from percuss.kernels.pieces import begin_of_piece, knot_time
from percuss.kernels.sample import cycles
from percuss.model.exact import as_float
from percuss.model.oscillator import Wall
from percuss.model.restitution import restitution_at_rest
from percuss.model.system import System
from percuss.orbits.orbit.itinerary import entry
from percuss.orbits.orbit.knots import without_knots
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.propagator import Propagator
from percuss.orbits.orbit.solve import impacts_of_record
from percuss.orbits.orbit.turning_points import (
    TurningPoints,
    margin_of,
    penetrations_of,
    turning_points_of,
)

EventRecord: TypeAlias = tuple[Floats, Integers]
# The wall, and the cycle of its release.
Release: TypeAlias = tuple[int, float]

# Instants of the cycle at which contact with a wall is tried.
INSTANTS = 64
# Pieces of a record in which it is tried, too, at most.
MOST_PIECES = 256
# Impacts in a forcing period at most: hops on a wall with restitution near 1 are many.
MOST_IMPACTS = 10_000
# Distance in cycles of releases that are the same, and of the same release in similar systems.
SAME, SIMILAR = 1e-9, 0.1
# A turning point so soon after a release, as a part of the period, is rounding: the displacement
# grows as the cube of time.
AT_RELEASE = 1e-6


def sticking_orbits(system: System, max_periods: int) -> list[PeriodicOrbit]:
    """Return all orbits with sticking of at most so many forcing periods.

    Parameters
    ----------
    system
        Oscillator and forcing; the forcing has a period.
    max_periods
        Forcing periods for which a motion is followed from each release.

    Returns
    -------
    list of PeriodicOrbit
        The shorter first.

    Examples
    --------
    >>> import percuss as pc
    >>> ball = pc.ball_on_table(amplitude="1.2", omega=1, gravity=1, restitution="0.5")
    >>> sticking_orbits(System(*ball), 4)
    [<PeriodicOrbit: sticking in 1 forcing period, T = 6.28319, asymptotic, \
abs(multipliers) 0, 0>]
    """
    runs = Propagator(system)
    orbits: list[PeriodicOrbit] = []
    known: list[Release] = []
    for release, start in _releases(runs):
        for record, n_periods in _returns(runs, release[0], start, max_periods):
            if any(_distance(release, other) <= SAME for other in known):
                continue
            known += _releases_of(system, record)
            orbits.append(_orbit(system, record, n_periods))
    return sorted(orbits, key=lambda orbit: orbit.n_periods)


def releases_of(orbit: PeriodicOrbit) -> list[Release]:
    """Return the releases of an orbit with sticking, in the order of time."""
    return _releases_of(orbit.system, orbit.record)


def sticking_orbit_near(system: System, orbit: PeriodicOrbit) -> PeriodicOrbit | None:
    """Return the orbit with sticking that continues one of a similar system.

    It has a release near one of that orbit, which recurs after as many forcing periods.

    Parameters
    ----------
    system
        Oscillator and forcing.
    orbit
        With sticking, of a system with as many stops.

    Returns
    -------
    PeriodicOrbit or None
        None if no such release recurs so.
    """
    runs = Propagator(system)
    releases = _releases(runs)
    known = releases_of(orbit)
    # An orbit begins with the first impact after its last release, and so does its continuation.
    for other in known[-1:] + known[:-1]:
        for release, start in releases:
            if _distance(release, other) > SIMILAR:
                continue
            for record, n in _returns(runs, release[0], start, orbit.n_periods):
                if n == orbit.n_periods:
                    return _orbit(system, record, n)
    return None


def _releases(runs: Propagator) -> list[tuple[Release, float]]:
    """Return each release of a period, with an instant of the contact before it."""
    period = float(runs.law[0, PERIOD])
    releases: list[tuple[Release, float]] = []
    for number, stop in enumerate(runs.system.oscillator.stops):
        # Elastic hops never end: no motion comes to stick there.
        if not isinstance(stop, Wall) or restitution_at_rest(stop.restitution) == 1.0:
            continue
        for start in _instants(runs.law, period):
            end = start + 1.02 * period
            events, marks = _follow(runs, as_float(stop.at), start, end, 1)
            kinds = marks[:3, columns.KIND]
            if len(kinds) < 3 or kinds[1] != columns.CONTACT or kinds[2] != columns.RELEASE:
                continue
            release = number, _cycle(runs.law, events[2])
            if not any(_distance(release, other) <= SAME for other, _ in releases):
                releases.append((release, start))
    return releases


def _instants(law: Law, period: float) -> list[float]:
    """Return instants of a period at which contact is tried; of a record one in each piece."""
    instants = np.arange(INSTANTS) * (period / INSTANTS)
    if law[0, N_KNOTS] > 0.0:
        knots = [sum(knot_time(law, k, 0.0)) for k in range(int(law[0, N_KNOTS]))]
        edges = np.unique(np.mod([*knots, 0.0, period], period))
        edges = np.append(edges, period)
        middles = 0.5 * (edges[1:] + edges[:-1])
        step = -(-len(middles) // MOST_PIECES)
        instants = np.sort(np.append(instants, middles[::step]))
    return [float(t) for t in instants]


def _follow(runs: Propagator, x: float, start: float, end: float, n_impacts: int) -> EventRecord:
    """Return the motion from rest at x, without the knots of a record but those that release it."""
    return without_knots(*runs.follow(x, 0.0, start, t_end=end, n_impacts=n_impacts))


def _returns(
    runs: Propagator, wall: int, start: float, max_periods: int
) -> list[tuple[EventRecord, int]]:
    """Return the motion from a release to the same one again, and its number of periods."""
    osc, period = runs.system.oscillator, float(runs.law[0, PERIOD])
    at = as_float(osc.stops[wall].at)
    end = start + (max_periods + 1.1) * period
    limit = MOST_IMPACTS * max_periods
    events, marks = _follow(runs, at, start, end, limit)
    bound = entry(osc, wall).bound
    first = events[2]
    released = np.flatnonzero(
        (marks[:, columns.KIND] == columns.RELEASE) & (marks[:, columns.BOUND] == bound)
    )
    for i in released[1:]:
        since = events[i] - first
        time = since[columns.EVENT_T] + since[columns.EVENT_T_LOW]
        n = round(time / period)
        if 1 <= n <= max_periods and abs(time - n * period) <= SAME * period:
            record = events[2 : i + 1].copy(), marks[2 : i + 1].copy()
            # An orbit begins with an impact; one that lands at rest only has none.
            return [(record, n)] if (record[1][:, columns.KIND] == columns.IMPACT).any() else []
    return []


def _releases_of(system: System, record: EventRecord) -> list[Release]:
    """Return the releases in a record."""
    osc, (events, marks) = system.oscillator, record
    walls = {entry(osc, k).bound: k for k, stop in enumerate(osc.stops) if isinstance(stop, Wall)}
    return [
        (walls[int(mark[columns.BOUND])], _cycle(system.law, event))
        for event, mark in zip(events, marks, strict=True)
        if mark[columns.KIND] == columns.RELEASE
    ]


def _cycle(law: Law, event: Floats) -> float:
    out = np.empty(1)
    t, t_low = event[columns.EVENT_T], event[columns.EVENT_T_LOW]
    cycles(law, np.array([t]), np.array([t_low]), out)
    return float(out[0])


def _distance(one: Release, other: Release) -> float:
    """Return the distance of two releases in cycles; inf of those from different walls."""
    distance = abs(one[1] - other[1])
    return min(distance, 1.0 - distance) if one[0] == other[0] else math.inf


def _orbit(system: System, record: EventRecord, n_periods: int) -> PeriodicOrbit:
    """Return the orbit of a record from a release to a release, from its first impact on."""
    law = system.law
    period = n_periods * float(law[0, PERIOD])
    events, marks = _from_first_impact(law, *record, period)
    x0 = place(law, int(marks[-1, columns.NEXT_REGION]), int(marks[-1, columns.BOUND]))
    turns = turning_points_of(law, events, marks, x0, float(events[-1, columns.EVENT_T]))
    turns = _after_releases(turns, events, marks, period)
    penetrations = penetrations_of(system.oscillator, turns)
    first, last = record[0][0], record[0][-1]
    missed = (last[columns.EVENT_T] - first[columns.EVENT_T] - period) + (
        last[columns.EVENT_T_LOW] - first[columns.EVENT_T_LOW]
    )
    return PeriodicOrbit(
        oscillator=system.oscillator,
        forcing=system.forcing,
        x0=x0,
        v0=float(events[0, columns.V_AFTER]),
        t0=float(events[0, columns.EVENT_T]),
        impacts=impacts_of_record(system, events, marks),
        n_impacts=math.inf,
        n_periods=n_periods,
        period=period,
        monodromy=np.zeros((2, 2)),
        multipliers=np.zeros(2, dtype=np.complex128),
        stability="asymptotic",
        admissible=len(penetrations) == 0,
        grazing_margin=margin_of(turns, _not_in_hops(turns, marks)),
        passages=penetrations,
        min_impact_speed=0.0,
        isolated=True,
        residual=abs(float(missed)),
        _events=events,
        _marks=marks,
        _sequence=np.empty((0, 3), dtype=np.int64),
        _vector=np.empty(0),
    )


def _from_first_impact(law: Law, events: Floats, marks: Integers, period: float) -> EventRecord:
    """Return a record from a release to a release as one from an impact to that impact."""
    i = int(np.flatnonzero(marks[:, columns.KIND] == columns.IMPACT)[0])
    again = np.concatenate([events[i:], events[1 : i + 1]])
    kinds = np.concatenate([marks[i:], marks[1 : i + 1]])
    # The first impact lies in the first forcing period, and comes once more at the end.
    start = -period * math.floor(float(events[i, columns.EVENT_T]) / period)
    for k, row in enumerate(again):
        shift = start + (period if k >= len(events) - i else 0.0)
        instant = later(row[columns.EVENT_T], row[columns.EVENT_T_LOW], shift)
        row[columns.EVENT_T], row[columns.EVENT_T_LOW] = instant
    # A knot that releases the mass stays on the record's, whatever the rounding of the period.
    for k in np.flatnonzero(kinds[:, columns.KIND] == columns.KNOT).tolist():
        t = float(again[k, columns.EVENT_T])
        instant = begin_of_piece(law, t, float(np.spacing(t)))[2:]
        again[k - 1 : k + 1, [columns.EVENT_T, columns.EVENT_T_LOW]] = instant
    kinds[0] = columns.START, -1, kinds[0, columns.NEXT_REGION]
    again[0, columns.V_BEFORE] = again[0, columns.V_AFTER]
    return again, kinds


def _after_releases(
    turns: TurningPoints, events: Floats, marks: Integers, period: float
) -> TurningPoints:
    """Return turning points without those that are rounding at a release."""
    since = turns.t - events[turns.flight, columns.EVENT_T]
    released = marks[turns.flight, columns.KIND] == columns.RELEASE
    kept = ~released | (since > AT_RELEASE * period)
    return TurningPoints(
        turns.t[kept], turns.clearance[kept], turns.bound[kept], turns.flight[kept],
        turns.doubt[kept],
    )  # fmt: skip


def _not_in_hops(turns: TurningPoints, marks: Integers) -> Flags:
    """Return which turning points are not the single one of a hop on a wall."""
    bounds = marks[:, columns.BOUND].copy()
    bounds[0] = bounds[-1]
    # Where a jump of a record releases the mass, the flight begins with the knot.
    knots = np.flatnonzero(marks[:, columns.KIND] == columns.KNOT)
    bounds[knots] = bounds[knots - 1]
    flights = np.minimum(turns.flight, len(marks) - 2)
    alone = np.bincount(turns.flight, minlength=len(marks))[turns.flight] == 1
    return np.asarray(~(alone & (bounds[flights] == bounds[flights + 1])))
