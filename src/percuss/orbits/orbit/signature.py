"""Signatures of orbits: whether two of them are the same motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.kernels.law_columns import PERIOD
from percuss.model.system import System
from percuss.orbits.orbit.itinerary import TOLERANCE, Itinerary, entries_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit, in_lengths


@dataclass(frozen=True, slots=True)
class Signature:
    """Numbers that distinguish the orbits of a system.

    Attributes
    ----------
    counts
        Impacts and forcing periods.
    stops
        The stops met.
    times
        Cycles of the impacts; in free motion, intervals as parts of the period.
    speeds
        Velocities after the impacts; without impacts, x and v at t = 0.
    isolated
        Whether the orbit is no member of a family.
    """

    counts: tuple[float, int]
    stops: tuple[int, ...]
    times: tuple[float, ...]
    speeds: tuple[float, ...]
    isolated: bool

    def matches(self, other: Signature, tolerance: float = TOLERANCE) -> bool:
        """Return whether both are the same motion, or members of one family.

        Impacts are compared in their cyclic order. An orbit shifted by a forcing period is another
        one.
        """
        n = len(self.stops)
        if self.counts != other.counts or n != len(other.stops):
            return False
        if n == 0:
            return self._is_near(other, 0, tolerance)
        # A few numbers: plain Python is faster than arrays.
        shifts = [k for k in range(n) if self.stops == other.stops[k:] + other.stops[:k]]
        if not self.isolated and not other.isolated:
            return bool(shifts)
        return any(self._is_near(other, k, tolerance) for k in shifts)

    def _is_near(self, other: Signature, k: int, tolerance: float) -> bool:
        """Return whether the impacts are near those of the other, counted from its k-th."""
        scale = tolerance * max(map(abs, other.speeds))
        speeds = zip(self.speeds, other.speeds[k:] + other.speeds[:k], strict=True)
        if any(abs(own - others) > scale for own, others in speeds):
            return False
        times = zip(self.times, other.times[k:] + other.times[:k], strict=True)
        differences = (abs(own - others) for own, others in times)
        return all(min(part, 1.0 - part) <= tolerance for part in differences)


def signature_of_orbit(orbit: PeriodicOrbit) -> Signature:
    """Return the signature of an orbit."""
    impacts = orbit.impacts
    speeds = impacts.v_after if len(impacts) else np.array([orbit.x0, orbit.v0])
    times = impacts.cycle if orbit.n_periods else impacts.intervals / orbit.period
    counts = orbit.n_impacts, orbit.n_periods
    stops = tuple(impacts.stop.tolist())
    return Signature(counts, stops, tuple(times.tolist()), tuple(speeds.tolist()), orbit.isolated)


def signature_of(system: System, itinerary: Itinerary, *, isolated: bool) -> Signature:
    """Return the signature of an itinerary, a solution or a guess of one."""
    met = entries_of(system, itinerary.events)
    rows = [i for i, _ in met]
    t = itinerary.instants[rows]
    if itinerary.n_periods:
        times = (t / float(system.law[0, PERIOD])) % 1.0
    else:
        before = np.roll(t, 1)
        before[0] -= itinerary.period
        times = (t - before) / itinerary.period
    stops = tuple(stop for _, stop in met)
    speeds = tuple(itinerary.velocities[rows].tolist())
    counts = len(met), itinerary.n_periods
    return Signature(counts, stops, tuple(times.tolist()), speeds, isolated)


def are_same(one: PeriodicOrbit | StructureOrbit, other: PeriodicOrbit | StructureOrbit) -> bool:
    """Return whether two orbits of one system are the same motion, or members of one family.

    Either may be given from another of its periods on.

    Parameters
    ----------
    one, other
        Orbits of the same oscillator and forcing, or of the same structure and loads.

    Returns
    -------
    bool
        True for the same impacts, and for two that are not isolated and meet the same stops. Of
        structures for the same state at the beginning of one of the periods.
    """
    if isinstance(one, StructureOrbit):
        return isinstance(other, StructureOrbit) and _are_same_states(one, other)
    if isinstance(other, StructureOrbit):
        return False
    return signature_of_orbit(one).matches(signature_of_orbit(other))


def _are_same_states(one: StructureOrbit, other: StructureOrbit) -> bool:
    if one.n_periods != other.n_periods:
        return False
    period = one.period / one.n_periods
    strobes, state = (in_lengths(s, period) for s in (other.strobes, one.strobes[0]))
    size = max(float(np.abs(strobes).max()), float(np.abs(state).max()))
    return bool((np.abs(strobes - state).max(axis=1) <= TOLERANCE * size).any())
