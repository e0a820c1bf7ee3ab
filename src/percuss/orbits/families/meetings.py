"""How a branch goes on where its orbits meet a soft stop that they did not meet, or no more.

There the order of events changes. A soft stop's force begins with zero, so that the motion depends
smoothly enough on its start: beyond the graze there is one orbit as well, and it has the two
crossings of the stop's edge more, or less (docs/theory/grazing.md). At the graze itself these two
take no time; the equations are regular there (`Family.residual`), and so the branch goes on from it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import EDGE, N_HARMONICS
from percuss.kernels.record import Integers
from percuss.model.law import law
from percuss.numerics import norm
from percuss.orbits.families.family import WEAK, Family, bordered
from percuss.orbits.families.touches import Touch, acceleration_at, touches_of, without
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.passages import turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["is_soft", "orbit_beyond", "start_beyond"]

Floats = NDArray[np.float64]

# Scaled steps off the graze that tell on which side a stop is not met, and the least one.
ASIDE, NEAREST, NEARER = 1e-4, 1e-8, 0.1
# Length of a step that tells which way the parameter goes, and what stands for that way.
OPENED, TINY = 1e-5, 1e-300
# Length of the first step beyond it, and the least one.
FIRST, LEAST, SHORTER = 1e-3, 1e-9, 0.25
# By how much of its length a step may miss the family.
BENT = 0.1


def orbit_beyond(family: Family, orbit: PeriodicOrbit, value: float) -> PeriodicOrbit | None:
    """Return an orbit a little beyond a graze of soft stops, with the events that it has there.

    Parameters
    ----------
    family
        The orbits up to the graze.
    orbit
        The one at the graze.
    value
        The parameter there.

    Returns
    -------
    PeriodicOrbit or None
        In the same range of the parameter; None if there is none near.
    """
    begun = start_beyond(family, orbit, value)
    if begun is None:
        return None
    other, z, tangent = begun
    step = FIRST
    while step >= LEAST:
        guess = z + step * tangent
        try:
            found = other.corrected(guess, tangent)
            if norm(found - guess) < BENT * step and 0.0 <= found[-1] <= 1.0:
                return other.orbit(found)
        except PercussError:
            pass
        step *= SHORTER
    return None


def start_beyond(
    family: Family, orbit: PeriodicOrbit, value: float
) -> tuple[Family, Floats, Floats] | None:
    """Return the family beyond a graze of soft stops, the graze as its point, and its tangent.

    Parameters
    ----------
    family
        The orbits up to the graze.
    orbit
        The one at the graze.
    value
        The parameter there.

    Returns
    -------
    tuple or None
        The unit tangent points away from the graze; None if there is none.
    """
    touches = [touch for touch in touches_of(orbit) if is_soft(orbit, touch)]
    met = [touch for touch in touches if touch.events]
    if not touches or len(met) not in (0, len(touches)):
        return None
    try:
        if met:
            return _without_meetings(family, without(orbit, met), value, met)
        return _with_meetings(family, orbit, value, touches)
    except PercussError:
        return None


def is_soft(orbit: PeriodicOrbit, touch: Touch) -> bool:
    """Tell whether a touch is one of a soft stop's edge."""
    table = law(orbit.oscillator, orbit.forcing)
    upper = touch.way > 0.0
    return bool(table[touch.region, at.UPPER_KIND if upper else at.LOWER_KIND] == EDGE)


def _without_meetings(
    family: Family, base: PeriodicOrbit, value: float, touches: list[Touch]
) -> tuple[Family, Floats, Floats] | None:
    """Return the family that meets the stops no more, on the side where it does not reach them."""
    simpler = Family(base, family.path, family.low, family.high)
    z = simpler.start(base, value)
    along = np.append(np.zeros(len(z) - 1), 1.0)
    tangent = simpler.tangent(z, along)
    part = ASIDE
    while part >= NEAREST:
        ways = []
        for way in (-1.0, 1.0):
            try:
                beside = simpler.orbit(simpler.corrected(z + way * part * tangent, tangent))
            except PercussError:
                continue
            depths = [_depth(beside, touch) for touch in touches]
            if all(depth < 0.0 for depth in depths):
                ways.append(way)
            elif all(depth > 0.0 for depth in depths):
                ways.append(-way)
        if ways and min(ways) == max(ways):
            return simpler, z, ways[0] * tangent
        part *= NEARER
    return None


def _depth(orbit: PeriodicOrbit, touch: Touch) -> float:
    """Return the depth of the turning point that a touch has become."""
    table = law(orbit.oscillator, orbit.forcing)
    lasting = orbit.period if len(orbit._chain) else 1.5 * orbit.period
    turns = turns_of(table, orbit._events, orbit._marks, orbit.x0, orbit.t0 + lasting)
    apart = (turns.t - touch.t) % orbit.period
    apart = np.minimum(apart, orbit.period - apart)
    apart[turns.bound != touch.bound] = math.inf
    if not len(apart) or not math.isfinite(apart.min()):
        return math.nan
    return -float(turns.clearance[int(np.argmin(apart))])


def _with_meetings(
    family: Family, orbit: PeriodicOrbit, value: float, touches: list[Touch]
) -> tuple[Family, Floats, Floats]:
    """Return the family that meets the stops which an orbit touches, from no time in them on."""
    table = law(orbit.oscillator, orbit.forcing)
    period, n = orbit.period, len(orbit._chain)
    # Instants, events, velocities after them, and how the flights and velocities open.
    rows: list[tuple[float, list[int], float, float, float]] = []
    for i in range(n):
        t, v = float(orbit._events[i, columns.EVENT_T]), float(orbit._unknowns[1 + n + i])
        rows.append((t, orbit._chain[i].tolist(), v, 0.0, 0.0))
    step = 1 + int(table[0, N_HARMONICS])
    for touch in touches:
        beyond = touch.region + int(touch.way) * step
        t = orbit.t0 + (touch.t - orbit.t0) % period
        short = 2.0 / abs(acceleration_at(table, touch))
        rows.append((t, [touch.bound, touch.region, beyond], 0.0, short, touch.way))
        rows.append((t, [touch.bound, beyond, touch.region], 0.0, 0.0, -touch.way))
    rows.sort(key=lambda row: row[0])
    instants = np.array([row[0] for row in rows])
    lasting = np.diff(np.append(instants, instants[0] + period))
    chain: Integers = np.array([row[1] for row in rows], dtype=np.int64)
    unknowns = np.concatenate([instants[:1], lasting, [row[2] for row in rows]])
    osc, force = orbit.oscillator, orbit.forcing
    solution = Solution(unknowns, orbit.residual, converged=True, isolated=True)
    touching = orbit_of_solution(osc, force, chain, solution, orbit.n_periods)
    other = Family(touching, family.path, family.low, family.high)
    opened = [[0.0], [row[3] for row in rows], [row[4] for row in rows]]
    direction = np.append(np.concatenate(opened) / other.scale, 0.0)
    direction /= norm(direction)
    z = other.corrected(other.start(touching, value), direction, beside_others=True)
    _, matrix = other.residual(z, value)
    right = np.append(np.zeros(len(z) - 1), 1.0)
    # Where several stops are touched each may be met alone: the equations hold that weakly.
    tangent = bordered(matrix, other.slope(z), direction, right, WEAK)
    # The parameter goes with the square of the velocity: what is left of it is a sign.
    tangent[-1] = 0.0
    tangent /= norm(tangent)
    beside = other.corrected(z + OPENED * tangent, tangent, beside_others=True)
    tangent[-1] = math.copysign(TINY, beside[-1] - z[-1])
    return other, z, tangent
