"""An orbit gone round twice, and the shorter orbit that one goes round several times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.model.exact import as_float
from percuss.orbits.families.family import Family
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["doubled", "doubled_unknowns", "halves_differ", "once_round"]

Floats = NDArray[np.float64]


def doubled(orbit: PeriodicOrbit) -> PeriodicOrbit:
    """Return an orbit gone round twice."""
    chain = np.concatenate([orbit._chain, orbit._chain])
    unknowns = doubled_unknowns(orbit._unknowns)
    solution = Solution(unknowns, orbit.residual, converged=True, isolated=orbit.isolated)
    return orbit_of_solution(orbit.oscillator, orbit.forcing, chain, solution, 2 * orbit.n_periods)


def doubled_unknowns(unknowns: Floats) -> Floats:
    """Return instant, durations and velocities of one round as those of two."""
    n = len(unknowns) // 2
    instant, lasting, speeds = unknowns[:1], unknowns[1 : 1 + n], unknowns[1 + n :]
    return np.concatenate([instant, lasting, lasting, speeds, speeds])


def once_round(orbit: PeriodicOrbit, times: int = 2) -> PeriodicOrbit:
    """Return the shorter orbit that one goes round several times, nearly or exactly.

    Parameters
    ----------
    orbit
        With events.
    times
        How often it goes round.

    Returns
    -------
    PeriodicOrbit
        Of the same system.

    Raises
    ------
    ConvergenceError
        If there is none beside it.
    """
    n = len(orbit._chain)
    m = n // times
    lasting = orbit._unknowns[1 : 1 + n].reshape(times, m).mean(axis=0)
    speeds = orbit._unknowns[1 + n :].reshape(times, m).mean(axis=0)
    guess = np.concatenate([orbit._unknowns[:1], lasting, speeds])
    solution = Solution(guess, orbit.residual, converged=True, isolated=True)
    osc, force = orbit.oscillator, orbit.forcing
    shorter = orbit_of_solution(osc, force, orbit._chain[:m], solution, orbit.n_periods // times)
    # Any parameter will do: it is held.
    value = as_float(osc.damping)
    family = Family(shorter, "oscillator.damping", value, value + 1.0)
    held = np.append(np.zeros(2 * m + 1), 1.0)
    return family.orbit(family.corrected(family.start(shorter, value), held))


def halves_differ(orbit: PeriodicOrbit) -> float:
    """Return by how much the halves of an orbit differ, in periods and largest velocities.

    Infinite if they are not alike in their events, or the orbit lasts an odd number of forcing
    periods.
    """
    n = len(orbit._chain)
    if n == 0 or n % 2 or orbit.n_periods % 2:
        return float("inf")
    if (orbit._chain[: n // 2] != orbit._chain[n // 2 :]).any():
        return float("inf")
    lasting = orbit._unknowns[1 : 1 + n].reshape(2, -1) / orbit.period
    speeds = orbit._unknowns[1 + n :].reshape(2, -1)
    fastest = float(np.abs(speeds).max()) or 1.0
    apart = np.concatenate([lasting[0] - lasting[1], (speeds[0] - speeds[1]) / fastest])
    return float(np.abs(apart).max())
