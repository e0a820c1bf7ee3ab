"""Which orbits are one and the same."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.law import PERIOD, Law
from percuss.model.oscillator import Oscillator
from percuss.orbits.orbit.itinerary import entries_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Signature", "are_same", "repetitions", "signature_of", "signature_of_orbit"]


# Newton's method finds an orbit to some 1e-12; two that lie nearer than this are one.
TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class Signature:
    """What tells one orbit of a system from another.

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
        Whether it is no member of a family.
    """

    counts: tuple[float, int]
    stops: tuple[int, ...]
    times: tuple[float, ...]
    speeds: tuple[float, ...]
    isolated: bool

    def matches(self, other: Signature, tolerance: float = TOLERANCE) -> bool:
        """Return whether both are the same motion, or members of one family.

        They are compared impact by impact, whichever comes first in either; an orbit is another
        one a forcing period later.
        """
        n = len(self.stops)
        if self.counts != other.counts or n != len(other.stops):
            return False
        if n == 0:
            return self._is_near(other, 0, tolerance)
        # A few numbers: plain Python is faster than arrays.
        turned = [k for k in range(n) if self.stops == other.stops[k:] + other.stops[:k]]
        if not self.isolated and not other.isolated:
            return bool(turned)
        return any(self._is_near(other, k, tolerance) for k in turned)

    def _is_near(self, other: Signature, k: int, tolerance: float) -> bool:
        """Return whether the impacts are near to those of the other, counted from its k-th."""
        scale = tolerance * max(map(abs, other.speeds))
        speeds = zip(self.speeds, other.speeds[k:] + other.speeds[:k], strict=True)
        if any(abs(one - it) > scale for one, it in speeds):
            return False
        times = zip(self.times, other.times[k:] + other.times[:k], strict=True)
        apart = (abs(one - it) for one, it in times)
        return all(min(part, 1.0 - part) <= tolerance for part in apart)


def signature_of_orbit(orbit: PeriodicOrbit) -> Signature:
    """Return what tells an orbit from another one of the same system."""
    impacts = orbit.impacts
    speeds = impacts.v_after if len(impacts) else np.array([orbit.x0, orbit.v0])
    times = impacts.cycle if orbit.n_periods else impacts.intervals / orbit.period
    counts = orbit.n_impacts, orbit.n_periods
    stops = tuple(impacts.stop.tolist())
    return Signature(counts, stops, tuple(times.tolist()), tuple(speeds.tolist()), orbit.isolated)


def signature_of(
    osc: Oscillator,
    table: Law,
    chain: Integers,
    unknowns: Floats,
    n_periods: int,
    *,
    isolated: bool,
) -> Signature:
    """Return the same of a solution of the equations of a chain, or of a guess of one."""
    met = entries_of(osc, table, chain)
    rows = [i for i, _ in met]
    n = len(chain)
    lasting = unknowns[1 : 1 + n]
    t = (unknowns[0] + np.concatenate([[0.0], np.cumsum(lasting[:-1])]))[rows]
    if n_periods:
        times = (t / float(table[0, PERIOD])) % 1.0
    else:
        period = float(lasting.sum())
        before = np.roll(t, 1)
        before[0] -= period
        times = (t - before) / period
    stops = tuple(stop for _, stop in met)
    speeds = tuple(unknowns[1 + n :][rows].tolist())
    return Signature((len(met), n_periods), stops, tuple(times.tolist()), speeds, isolated)


def are_same(one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
    """Return whether two orbits of one system are the same motion, or members of one family.

    Parameters
    ----------
    one, other
        Orbits of the same oscillator and forcing.

    Returns
    -------
    bool
        True for the same impacts, and for two that are not isolated and meet the same stops.
    """
    return signature_of_orbit(one).matches(signature_of_orbit(other))


def repetitions(chain: Integers, unknowns: Floats, n_periods: int) -> int:
    """Return how often an orbit goes round in what was taken for one period."""
    n = len(chain)
    lasting, speeds = unknowns[1 : 1 + n], unknowns[1 + n :]
    tolerances = TOLERANCE * lasting.sum(), TOLERANCE * np.abs(speeds).max()
    # A forced orbit lasts whole forcing periods; one of free motion needs none.
    candidates = n if n_periods == 0 else math.gcd(n, n_periods)
    for times in range(candidates, 1, -1):
        if n % times or (n_periods and n_periods % times):
            continue
        shift = n // times
        if (
            (chain == np.roll(chain, shift, axis=0)).all()
            and (np.abs(lasting - np.roll(lasting, shift)) <= tolerances[0]).all()
            and (np.abs(speeds - np.roll(speeds, shift)) <= tolerances[1]).all()
        ):
            return times
    return 1
