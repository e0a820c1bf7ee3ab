"""Where an orbit touches a stop without velocity, and the orbit that meets it there no more."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from percuss.errors import ConvergenceError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import acceleration_and_jerk, constant_force, place, set_phases
from percuss.kernels.law import Law
from percuss.kernels.shooting import AT, BEFORE
from percuss.model.law import law
from percuss.orbits.bifurcations.family import fastest
from percuss.orbits.bifurcations.n_fold import settled
from percuss.orbits.orbit.itinerary import entries_of, is_wall
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_orbit

__all__ = [
    "GrazingContact",
    "acceleration_at",
    "accumulates",
    "grazing_contacts",
    "merged",
    "without",
]


# Velocities below this part of the largest, and distances, are those of a touch: special points
# are located to some 1e-12 of the branch, and a distance is flat there.
SLOW = 1e-6
# Velocities that vanish together do so at different rates.
ACCUMULATED = 1e-4
# A turning point and an event of no velocity nearer than this part of the period are one touch.
BESIDE = 1e-3


@dataclass(frozen=True, slots=True)
class GrazingContact:
    """A contact with a bound without velocity.

    Attributes
    ----------
    t
        Instant [time].
    bound
        Number of the bound.
    region
        Row of the region in which the orbit is before and after it.
    sign
        Sign of the velocity with which it would pass.
    events
        Rows of the chain that happen there: one impact or several that fall together, the two
        crossings of an edge, or none.
    """

    t: float
    bound: int
    region: int
    sign: float
    events: tuple[int, ...]


def grazing_contacts(orbit: PeriodicOrbit) -> list[GrazingContact]:
    """Return the touches of an orbit at a graze, in the order of time."""
    table = law(orbit.oscillator, orbit.forcing)
    speed = fastest(orbit)
    found = merged(_at_events(orbit, table, SLOW * speed), orbit.period)
    for touch in _at_turns(orbit, table, SLOW * speed * orbit.period):
        apart = (abs(touch.t - other.t) % orbit.period for other in found)
        if all(min(by, orbit.period - by) > BESIDE * orbit.period for by in apart):
            found.append(touch)
    return sorted(found, key=lambda touch: touch.t)


def merged(contacts: Iterable[GrazingContact], period: float) -> list[GrazingContact]:
    """Return touches with those of one bound at one instant of a period as one.

    Impacts fall together there; or an orbit goes round a shorter one, and touches in each round.
    """
    found: list[GrazingContact] = []
    for touch in contacts:
        for k, other in enumerate(found):
            apart = abs(touch.t - other.t) % period
            if touch.bound == other.bound and min(apart, period - apart) <= BESIDE * period:
                events = other.events + tuple(e for e in touch.events if e not in other.events)
                found[k] = dataclasses.replace(other, events=events)
                break
        else:
            found.append(touch)
    return found


def acceleration_at(table: Law, touch: GrazingContact, t: float | None = None) -> float:
    """Return the acceleration at the bound of a touch, at rest there, at its instant or another."""
    phases = np.empty((int(table[0, at.N_HARMONICS]), 2))
    set_phases(table, touch.t if t is None else t, 0.0, phases)
    force = constant_force(table, touch.region, place(table, touch.region, touch.bound))
    return float(acceleration_and_jerk(table, touch.region, force, phases, 0.0, 0.0)[0])


def accumulates(orbit: PeriodicOrbit, row: int) -> bool:
    """Return whether impacts accumulate where one has no velocity, a row of the orbit's chain.

    The force pushes into the wall there, and the impact before or after it has no velocity either:
    between them the mass stays. A motion that comes from beyond the wall may have one alone.
    """
    table = law(orbit.oscillator, orbit.forcing)
    chain, (events, _) = orbit.itinerary.events, orbit.record
    n = len(chain)
    bound, before, _ = chain[row].tolist()
    sign = 1.0 if bound > int(table[before, at.NUMBER]) else -1.0
    touch = GrazingContact(float(events[row, columns.EVENT_T]), bound, before, sign, (row,))
    beside = [(row + step) % n for step in (-1, 1)]
    slow = ACCUMULATED * fastest(orbit)
    others = [
        k for k in beside
        if k != row and chain[k, AT] == bound
        and abs(events[k or n, columns.V_BEFORE]) < slow
    ]  # fmt: skip
    return bool(others) and sign * acceleration_at(table, touch) > 0.0


def _at_events(orbit: PeriodicOrbit, table: Law, slow: float) -> list[GrazingContact]:
    itinerary, (events, _) = orbit.itinerary, orbit.record
    chain, n = itinerary.events, len(itinerary)
    walls = is_wall(table, chain) if n else []
    found = []
    for i, _ in entries_of(orbit.oscillator, table, chain) if n else []:
        if abs(events[i or n, columns.V_BEFORE]) > slow:
            continue
        rows: tuple[int, ...] = (i,)
        if not walls[i]:
            # Into the stop and out of it, or out of it and in again: what takes no time.
            inside, outside = itinerary.durations[i], itinerary.durations[(i - 1) % n]
            rows = (i, (i + 1) % n) if abs(inside) <= abs(outside) else ((i - 1) % n, i)
        row = chain[rows[0]]
        sign = 1.0 if row[AT] > int(table[row[BEFORE], at.NUMBER]) else -1.0
        found.append(
            GrazingContact(float(events[i, 0]), int(row[AT]), int(row[BEFORE]), sign, rows)
        )
    return found


def _at_turns(orbit: PeriodicOrbit, table: Law, near: float) -> list[GrazingContact]:
    """Return the turning points that touch a bound."""
    turns, (_, marks) = orbit.turning_points, orbit.record
    found = []
    for i in range(len(turns.t)):
        if abs(turns.clearance[i]) > near or turns.t[i] - turns.t[0] > orbit.period * (1 - 1e-9):
            continue
        region = int(marks[turns.flight[i], columns.NEXT_REGION])
        bound = int(turns.bound[i])
        sign = 1.0 if bound > int(table[region, at.NUMBER]) else -1.0
        found.append(GrazingContact(float(turns.t[i]), bound, region, sign, ()))
    return found


def without(orbit: PeriodicOrbit, contacts: Sequence[GrazingContact]) -> PeriodicOrbit:
    """Return the orbit of the same system that does not have the events of touches.

    Raises
    ------
    ConvergenceError
        If there is none beside it.
    """
    gone = {row for touch in contacts for row in touch.events}
    if not gone:
        return orbit
    itinerary = orbit.itinerary
    entries = entries_of(orbit.oscillator, law(orbit.oscillator, orbit.forcing), itinerary.events)
    if len(gone) == len(itinerary):
        if orbit.forcing is None:
            reason = "free motion that meets no stop has no orbit of its own"
            raise ConvergenceError(reason, None, np.nan, "look at motion with forcing")
        return steady_orbit(orbit.oscillator, orbit.forcing, contacts[0].region)
    # The first event meets a stop: so orbits begin.
    first = next(row for row, _ in entries if row not in gone)
    return settled(orbit, itinerary.without(gone, first))
