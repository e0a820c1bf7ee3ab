"""The n-fold cover of a primitive orbit, and the primitive orbit of an n-fold cover."""

from __future__ import annotations

from percuss.model.exact import as_float
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import Solution, orbit_of_solution


def primitive_orbit(orbit: PeriodicOrbit, times: int = 2) -> PeriodicOrbit:
    """Return the primitive orbit that one covers several times, nearly or exactly.

    Raises
    ------
    ConvergenceError
        If there is none near it.
    """
    return settled(orbit, orbit.itinerary.primitive(times))


def orbit_of_itinerary(
    orbit: PeriodicOrbit, itinerary: Itinerary, *, isolated: bool = True
) -> PeriodicOrbit:
    """Return an itinerary, a solution in the system of an orbit or a guess of one, as an orbit."""
    solution = Solution(itinerary, orbit.residual, converged=True, isolated=isolated)
    return orbit_of_solution(orbit.system, solution)


def settled(orbit: PeriodicOrbit, guess: Itinerary) -> PeriodicOrbit:
    """Return the orbit with other events in the system of an orbit, by Newton's method.

    Raises
    ------
    ConvergenceError
        If there is none near the guess.
    """
    rough = orbit_of_itinerary(orbit, guess)
    # Solve at fixed parameters: any of them serves.
    value = as_float(orbit.oscillator.damping)
    family = BranchEquations(rough, "oscillator.damping", value, value + 1.0)
    start = family.start(rough, value)
    return family.solution(family.corrected(start, along_parameter(len(start))))
