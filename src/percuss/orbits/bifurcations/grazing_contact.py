"""Grazing contacts of an orbit, and the orbit without their events."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from percuss.errors import ConvergenceError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.flight import place
from percuss.kernels.law_columns import Law
from percuss.kernels.shooting import AT
from percuss.motion.accelerations import acceleration_in
from percuss.orbits.bifurcations.multiple_covers import settled
from percuss.orbits.orbit.itinerary import entries_of, is_wall
from percuss.orbits.orbit.over_period import fastest
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_orbit

# Velocities below this part of the largest, and clearances, are zero at a graze: special points are
# located to some 1e-12 of the branch, and the clearance is quadratic there.
SLOW = 1e-6
# Velocities that vanish together do so at different rates.
ACCUMULATED = 1e-4
# A turning point and an event of zero velocity nearer than this part of the period are one graze.
SAME_GRAZE = 1e-3


@dataclass(frozen=True, slots=True)
class GrazingContact:
    """A contact with a bound at zero velocity.

    Attributes
    ----------
    t
        Instant [time].
    bound
        Number of the bound.
    region
        Row of the region in which the orbit is before and after it.
    sign
        Sign of a velocity beyond the bound.
    events
        Rows of the events there: one impact or several that coincide, the two crossings of an
        edge, or none.
    """

    t: float
    bound: int
    region: int
    sign: float
    events: tuple[int, ...]


def grazing_contacts(orbit: PeriodicOrbit) -> list[GrazingContact]:
    """Return the grazing contacts of an orbit, in the order of time."""
    speed = fastest(orbit)
    contacts = merged(_at_events(orbit, SLOW * speed), orbit.period)
    for contact in _at_turns(orbit, SLOW * speed * orbit.period):
        if not any(_is_same(contact, other, orbit.period) for other in contacts):
            contacts.append(contact)
    return sorted(contacts, key=lambda contact: contact.t)


def _is_same(one: GrazingContact, other: GrazingContact, period: float) -> bool:
    """Return whether two contacts are at the same instant of a period."""
    distance = abs(one.t - other.t) % period
    return min(distance, period - distance) <= SAME_GRAZE * period


def merged(contacts: Iterable[GrazingContact], period: float) -> list[GrazingContact]:
    """Return grazing contacts, those of one bound at one instant of a period as one.

    Impacts coincide there; or an orbit covers a primitive one, and grazes in each of its periods.
    """
    different: list[GrazingContact] = []
    for contact in contacts:
        for k, other in enumerate(different):
            if contact.bound == other.bound and _is_same(contact, other, period):
                events = other.events + tuple(e for e in contact.events if e not in other.events)
                different[k] = dataclasses.replace(other, events=events)
                break
        else:
            different.append(contact)
    return different


def acceleration_at(law: Law, contact: GrazingContact, t: float | None = None) -> float:
    """Return the acceleration at rest at the bound of a contact, at its instant or another."""
    x = place(law, contact.region, contact.bound)
    return acceleration_in(law, contact.region, x, 0.0, contact.t if t is None else t)


def accumulates(orbit: PeriodicOrbit, row: int) -> bool:
    """Return whether impacts accumulate at an impact of zero velocity, a row of the itinerary.

    The force pushes into the wall there, and the impact before or after it has zero velocity too:
    between them the mass stays. Formal motion from beyond the wall may have a single one.
    """
    law = orbit.system.law
    rows, (events, _) = orbit.itinerary.events, orbit.record
    n = len(rows)
    contact = _at_event(orbit, row, (row,))
    slow = ACCUMULATED * fastest(orbit)
    others = [
        k
        for k in ((row - 1) % n, (row + 1) % n)
        if k != row
        and rows[k, AT] == contact.bound
        and abs(events[k or n, columns.V_BEFORE]) < slow
    ]
    return bool(others) and contact.sign * acceleration_at(law, contact) > 0.0


def _at_event(orbit: PeriodicOrbit, i: int, rows: tuple[int, ...]) -> GrazingContact:
    """Return the contact at the instant of an event, of some rows of the itinerary."""
    t = float(orbit.record[0][i, columns.EVENT_T])
    bound, before, _ = orbit.itinerary.events[rows[0]].tolist()
    sign = 1.0 if bound > int(orbit.system.law[before, at.NUMBER]) else -1.0
    return GrazingContact(t, bound, before, sign, rows)


def _at_events(orbit: PeriodicOrbit, slow: float) -> list[GrazingContact]:
    """Return the contacts at events of zero velocity."""
    itinerary, (events, _), law = orbit.itinerary, orbit.record, orbit.system.law
    n = len(itinerary)
    walls = is_wall(law, itinerary.events)
    contacts = []
    for i, _ in entries_of(orbit.system, itinerary.events):
        if abs(events[i or n, columns.V_BEFORE]) > slow:
            continue
        rows: tuple[int, ...] = (i,)
        if not walls[i]:
            # Into the stop and out of it, or out of it and in again: whichever takes no time.
            inside, outside = itinerary.durations[i], itinerary.durations[(i - 1) % n]
            rows = (i, (i + 1) % n) if abs(inside) <= abs(outside) else ((i - 1) % n, i)
        contacts.append(_at_event(orbit, i, rows))
    return contacts


def _at_turns(orbit: PeriodicOrbit, near: float) -> list[GrazingContact]:
    """Return the contacts at turning points."""
    turns, (_, marks), law = orbit.turning_points, orbit.record, orbit.system.law
    contacts = []
    for i in range(len(turns.t)):
        if abs(turns.clearance[i]) > near or turns.t[i] - turns.t[0] > orbit.period * (1 - 1e-9):
            continue
        region = int(marks[turns.flight[i], columns.NEXT_REGION])
        bound = int(turns.bound[i])
        sign = 1.0 if bound > int(law[region, at.NUMBER]) else -1.0
        contacts.append(GrazingContact(float(turns.t[i]), bound, region, sign, ()))
    return contacts


def without(orbit: PeriodicOrbit, contacts: Sequence[GrazingContact]) -> PeriodicOrbit:
    """Return the orbit of the same system without the events of grazing contacts.

    Raises
    ------
    ConvergenceError
        If there is none near it.
    """
    removed = {row for contact in contacts for row in contact.events}
    if not removed:
        return orbit
    itinerary = orbit.itinerary
    if len(removed) == len(itinerary):
        if orbit.forcing is None:
            reason = "free motion that meets no stop has no orbit of its own"
            raise ConvergenceError(reason, None, np.nan, "look at motion with forcing")
        return steady_orbit(orbit.system, contacts[0].region)
    # An orbit begins with an event that meets a stop.
    entries = entries_of(orbit.system, itinerary.events)
    first = next((row for row, _ in entries if row not in removed), None)
    if first is None:
        reason = "without its grazing contacts the motion leaves a stop that it does not meet"
        raise ConvergenceError(reason, None, np.nan, "look at another graze")
    return settled(orbit, itinerary.without(removed, first))


def in_time_of(
    base: PeriodicOrbit, orbit: PeriodicOrbit, contacts: Sequence[GrazingContact]
) -> list[GrazingContact]:
    """Return grazing contacts of an orbit at their instants of the orbit without their events.

    That is the same orbit, and may be given from another period of the force on.
    """
    if base.n_periods < 2 or len(base.itinerary) == 0:
        return list(contacts)
    force_period = orbit.period / orbit.n_periods
    events = orbit.record[0][: len(orbit.itinerary)]
    fastest_event = float(np.abs(events[:, columns.V_AFTER]).max()) or 1.0

    def difference(later: int) -> float:
        """Return how far the first event of the base is from all events, some periods later."""
        t = base.t0 + later * force_period - events[:, columns.EVENT_T]
        apart = np.abs(np.mod(t / orbit.period + 0.5, 1.0) - 0.5)
        faster = np.abs(base.v0 - events[:, columns.V_AFTER]) / fastest_event
        return float((apart + faster).min())

    later = min(range(orbit.n_periods), key=difference)
    return [
        dataclasses.replace(contact, t=contact.t - later * force_period) for contact in contacts
    ]
