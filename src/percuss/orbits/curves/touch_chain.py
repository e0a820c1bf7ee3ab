"""Orbits that touch a stop, as the chain of their other events with the touch as one more."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import PERIOD, Law, Table
from percuss.kernels.record import Integers
from percuss.orbits.families.touches import Touch
from percuss.orbits.orbit.chain import row_of_region
from percuss.orbits.orbit.passages import Passages, turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Others", "elastic", "is_on_wall", "mirrored", "others_of", "room_beside", "touched"]

Floats = NDArray[np.float64]

# Turning points this near to the touch, as a part of the period, are the touch.
SAME = 1e-6


@dataclass(frozen=True, slots=True)
class Others:
    """The events of an orbit from a touch on, which is none of them.

    Attributes
    ----------
    chain
        (m, 3) array, the events.
    instants, velocities
        (m,) arrays, when they happen, after the touch, and the velocities after them.
    """

    chain: Integers
    instants: Floats
    velocities: Floats


def others_of(orbit: PeriodicOrbit, touch: Touch) -> Others:
    """Return the events of an orbit that touches a stop, from the touch on."""
    events = orbit._events[: len(orbit._chain)]
    after = touch.t + np.mod(events[:, columns.EVENT_T] - touch.t, orbit.period)
    order = np.argsort(after)
    chain = np.ascontiguousarray(orbit._chain[order])
    return Others(chain, after[order], events[order, columns.V_AFTER])


def is_on_wall(table: Law, touch: Touch) -> bool:
    """Tell whether a touch is that of a wall."""
    kind = at.UPPER_KIND if touch.way > 0.0 else at.LOWER_KIND
    return bool(table[touch.region, kind] == at.WALL)


def mirrored(table: Law, touch: Touch) -> Touch:
    """Return the touch of the opposite stop in a symmetric system."""
    n_regions = int(table[0, at.N_REGIONS])
    region = row_of_region(table, n_regions - 1 - int(table[touch.region, at.NUMBER]))
    return Touch(touch.t, n_regions - touch.bound, region, -touch.way, ())


def elastic(table: Law, region: int) -> Table:
    """Return the law with elastic walls round a region: there a touch tells its velocity."""
    changed = table.copy()
    changed[region, at.LOWER_RESTITUTION] = changed[region, at.UPPER_RESTITUTION] = 1.0
    return changed


def room_beside(
    orbit: PeriodicOrbit, table: Law, instant: float, *, in_halves: bool = False
) -> float:
    """Return the least distance to a stop at the turning points other than the touch.

    ``in_halves`` leaves out the touch of the opposite stop half a period later, too.
    """
    # The ends of a flight are no turning points of it.
    lasting = orbit.period if len(orbit._chain) else 1.5 * orbit.period
    turns = turns_of(table, orbit._events, orbit._marks, orbit.x0, orbit.t0 + lasting)
    period = orbit.period if len(orbit._chain) else float(table[0, PERIOD])
    if in_halves:
        period *= 0.5
    apart = np.mod(turns.t - instant + 0.5 * period, period) - 0.5 * period
    others = turns.clearance[np.abs(apart) > SAME * period]
    return float(others.min()) if len(others) else 1e300


def touched(orbit: PeriodicOrbit, conditions: Mapping[str, float]) -> PeriodicOrbit:
    """Return an orbit that touches a stop as one whose distance to it is 0, without rounding.

    Parameters
    ----------
    orbit
        As it is computed.
    conditions
        Those of `percuss.orbits.curves.grazing_curves`: room, velocities, and the acceleration away
        from the stop.
    """
    room = conditions["passage"]
    speeds = [value for name, value in conditions.items() if name.startswith("velocity")]
    passages = orbit.passages
    beyond = passages.depth > (-0.5 * room if room < 0.0 else np.inf)
    kept = Passages(passages.t[beyond], passages.stop[beyond], passages.depth[beyond])
    return dataclasses.replace(
        orbit,
        grazing_margin=min(0.0, room),
        passages=kept,
        admissible=room >= 0.0 and min(speeds, default=1.0) > 0.0 < conditions["acceleration"],
    )
