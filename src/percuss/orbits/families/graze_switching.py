"""From the orbits on one side of a graze to those with a meeting more, or less."""

from __future__ import annotations

import numpy as np

from percuss.errors import ConvergenceError, PercussError
from percuss.kernels import record as columns
from percuss.kernels.record import Integers
from percuss.numerics import norm
from percuss.orbits.families.family import Family
from percuss.orbits.families.meetings import is_soft, orbit_beyond
from percuss.orbits.families.ranges import own_value
from percuss.orbits.families.touches import Touch, merged, touches_of, without
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["orbit_past_graze"]

# Half the range of the parameter that is the unit of its steps, as a part of its value.
BESIDE = 0.01
# Length of the step along the other family, and the least one.
FIRST, LEAST, SHORTER = 1e-3, 1e-9, 0.25
# By how much of its length a step may miss the family.
BENT = 0.1


def orbit_past_graze(orbit: PeriodicOrbit, path: str) -> PeriodicOrbit:
    """Return an orbit of the other family that starts at a graze.

    Where a turning point touches a stop that is one with another impact there; where an impact
    has no velocity, one without it. Either is physical there.

    Parameters
    ----------
    orbit
        The one at the graze.
    path
        Path of the parameter.

    Raises
    ------
    ConvergenceError
        If none is found.
    """
    value = own_value(orbit, path)
    beside = BESIDE * abs(value) or BESIDE
    where = f"{path} = {value:.12g}"
    touches = touches_of(orbit)
    found: PeriodicOrbit | None = None
    if any(is_soft(orbit, touch) for touch in touches):
        family = Family(orbit, path, value - beside, value + beside)
        found = orbit_beyond(family, orbit, value)
    elif _all_with_impacts(orbit, touches):
        found = _without_impacts(orbit, path, (value - beside, value + beside), touches)
    else:
        added = [touch for touch in touches if not touch.events]
        found = _with_impacts(orbit, path, (value - beside, value + beside), added)
    if found is None:
        advice = "look whether the graze is located, and whether another one lies beside it"
        raise ConvergenceError(f"no other family found at {where}", None, np.nan, advice)
    return found


def _all_with_impacts(orbit: PeriodicOrbit, touches: list[Touch]) -> bool:
    """Tell whether an orbit, or a shorter one that it goes round, has an impact at each touch."""
    if all(touch.events for touch in touches):
        return True
    if not any(touch.events for touch in touches):
        return False
    return all(touch.events for touch in merged(touches, without(orbit, touches).period))


def _without_impacts(
    orbit: PeriodicOrbit, path: str, ends: tuple[float, float], touches: list[Touch]
) -> PeriodicOrbit | None:
    """Return an orbit that does not come to the stop, on the side where that is so."""
    base = without(orbit, touches)
    family = Family(base, path, *ends)
    start = family.start(base, own_value(base, path))
    held = np.append(np.zeros(len(start) - 1), 1.0)
    for way in (-1.0, 1.0):
        try:
            found = family.orbit(family.corrected(start + way * FIRST * held, held))
        except PercussError:
            continue
        if found.admissible:
            return found
    return None


def _with_impacts(
    orbit: PeriodicOrbit, path: str, ends: tuple[float, float], touches: list[Touch]
) -> PeriodicOrbit | None:
    """Return an orbit with an impact at each touch."""
    n, period = len(orbit._chain), orbit.period
    rows = [
        (
            float(orbit._events[i, columns.EVENT_T]),
            orbit._chain[i].tolist(),
            float(orbit._unknowns[1 + n + i]),
        )
        for i in range(n)
    ]
    for touch in touches:
        t = orbit.t0 + (touch.t - orbit.t0) % period
        rows.append((t, [touch.bound, touch.region, touch.region], 0.0))
    rows.sort(key=lambda row: row[0])
    instants = np.array([t for t, _, _ in rows])
    lasting = np.diff(np.append(instants, instants[0] + period))
    chain: Integers = np.array([row for _, row, _ in rows], dtype=np.int64)
    unknowns = np.concatenate([instants[:1], lasting, [v for _, _, v in rows]])
    solution = Solution(unknowns, orbit.residual, converged=True, isolated=True)
    osc, force = orbit.oscillator, orbit.forcing
    grazing = orbit_of_solution(osc, force, chain, solution, orbit.n_periods)
    family = Family(grazing, path, *ends)
    start = family.start(grazing, own_value(orbit, path))
    tangent = family.tangent(start, np.append(np.zeros(len(start) - 1), 1.0))
    size = FIRST
    while size >= LEAST:
        for way in (-1.0, 1.0):
            guess = start + way * size * tangent
            try:
                z = family.corrected(guess, tangent)
            except PercussError:
                continue
            found = family.orbit(z)
            if norm(z - guess) < BENT * size and (family.into_stops(found) > 0.0).all():
                return found
        size *= SHORTER
    return None
