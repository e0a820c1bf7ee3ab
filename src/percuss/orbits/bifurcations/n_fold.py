"""The n-fold cover of a primitive orbit, and the primitive orbit of an n-fold cover."""

from __future__ import annotations

from percuss.model.exact import as_float
from percuss.orbits.bifurcations.family import Family
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["orbit_of_itinerary", "primitive_orbit", "settled"]


def primitive_orbit(orbit: PeriodicOrbit, times: int = 2) -> PeriodicOrbit:
    """Return the orbit that one covers several times, nearly or exactly.

    Parameters
    ----------
    orbit
        With events.
    times
        How often it covers the other.

    Returns
    -------
    PeriodicOrbit
        Of the same system.

    Raises
    ------
    ConvergenceError
        If there is none beside it.
    """
    return settled(orbit, orbit.itinerary.primitive(times))


def orbit_of_itinerary(
    orbit: PeriodicOrbit, itinerary: Itinerary, *, isolated: bool = True
) -> PeriodicOrbit:
    """Return an itinerary, a solution in the system of an orbit or a guess of one, as an orbit."""
    solution = Solution(itinerary.vector, orbit.residual, converged=True, isolated=isolated)
    system = orbit.oscillator, orbit.forcing
    return orbit_of_solution(*system, itinerary.events, solution, itinerary.n_periods)


def settled(orbit: PeriodicOrbit, guess: Itinerary) -> PeriodicOrbit:
    """Return the orbit with other events in the system of an orbit, by Newton's method.

    Raises
    ------
    ConvergenceError
        If there is none beside the guess.
    """
    rough = orbit_of_itinerary(orbit, guess)
    # Solved at a fixed parameter, whichever that is.
    value = as_float(orbit.oscillator.damping)
    family = Family(rough, "oscillator.damping", value, value + 1.0)
    start = family.start(rough, value)
    return family.solution(family.corrected(start, along_parameter(len(start))))
