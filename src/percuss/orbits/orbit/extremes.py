"""How far a periodic motion swings: its exact extremes, from the closed form of its flights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.arrays import Integers
from percuss.kernels import record as columns
from percuss.kernels.flight import Flight, constant_force, set_phases
from percuss.kernels.law import N_HARMONICS, Law, Table
from percuss.kernels.shooting import place, turning_points
from percuss.model.law import law
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Extremes", "extremes_of", "extremes_of_record"]

# Turning points of a flight for which there is room at first.
ROOM = 64


@dataclass(frozen=True, slots=True)
class Extremes:
    """The least and the largest displacement of a periodic motion.

    Attributes
    ----------
    low, high
        Over a whole period [length].
    """

    low: float
    high: float

    @property
    def amplitude(self) -> float:
        """Half the distance between them [length]."""
        return 0.5 * (self.high - self.low)

    @property
    def largest(self) -> float:
        """The largest abs(x) [length]."""
        return max(abs(self.low), abs(self.high))


def extremes_of(orbit: PeriodicOrbit) -> Extremes:
    """Return the extremes of an orbit: of its turning points and its events, nothing is sampled.

    Between two events the motion is a formula, and its turning points are found as zeros of the
    velocity; at impacts it stops at the wall. A formal orbit is taken as its formula goes, beyond
    the stops that it passes through.

    Parameters
    ----------
    orbit
        Any periodic orbit, with sticking too.

    Returns
    -------
    Extremes
        To rounding.

    Examples
    --------
    Far from the wall the motion is the linear response, A = 1/sqrt((k - w^2)^2 + (2 a w)^2):

    >>> import math
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=5.0, side="above", damping=0.05)
    >>> orbit = pc.find_orbit(osc, pc.cosine(2.0), n_impacts=0)
    >>> abs(extremes_of(orbit).amplitude - 1.0 / math.hypot(3.0, 0.2)) < 1e-15
    True
    """
    table = law(orbit.oscillator, orbit.forcing)
    t_end = orbit.t0 + orbit.period
    if len(orbit.record[0]) == 1:
        # Without events a period and a half holds both extremes, wherever it starts.
        t_end += 0.5 * orbit.period
    return extremes_of_record(table, *orbit.record, orbit.x0, t_end)


def extremes_of_record(
    table: Law, events: Table, marks: Integers, x0: float, t_end: float
) -> Extremes:
    """Return the extremes of a motion between the first and the last row of its record.

    Parameters
    ----------
    table
        The law.
    events, marks
        What `march` has written; the first row may be any event.
    x0
        Where a record begins whose first row is its start [length].
    t_end
        Where the motion ends if there is no other row [time].
    """
    found = [x0] if marks[0, columns.KIND] == columns.START else []
    ends = events[1:] if len(events) > 1 else np.array([[t_end, 0.0, 0.0, 0.0]])
    for event, mark, end in zip(events, marks, ends, strict=False):
        region, x = int(mark[columns.NEXT_REGION]), x0
        if mark[columns.KIND] != columns.START:
            x = place(table, region, int(mark[columns.BOUND]))
            found.append(x)
        longest = (end[0] - event[0]) + (end[1] - event[1])
        if mark[columns.KIND] != columns.CONTACT and longest > 0.0:
            start = float(event[0]), float(event[1]), float(event[columns.V_AFTER])
            found += _turns(table, region, x, start, float(longest))
    return Extremes(min(found), max(found))


def _turns(
    table: Law, region: int, x: float, start: tuple[float, float, float], longest: float
) -> list[float]:
    """Return where a flight turns."""
    n = int(table[0, N_HARMONICS])
    phases, arrival = np.empty((n, 2)), np.empty((n, 2))
    set_phases(table, start[0], start[1], phases)
    whole = (*start, constant_force(table, region, x))
    room = ROOM
    while True:
        out = np.empty((room, 3))
        count = turning_points(Flight(table, region, whole, phases, arrival), longest, out)
        if count < room:
            return [x + y for y in out[:count, 1].tolist()]
        room *= 8
