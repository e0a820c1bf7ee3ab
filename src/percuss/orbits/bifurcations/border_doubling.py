"""The orbit of twice the period that starts where an impact meets a jump of the force."""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.law_columns import REPEAT
from percuss.numerics import dot
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.force_jumps import Crossing
from percuss.orbits.bifurcations.multiple_covers import orbit_of_itinerary, primitive_orbit
from percuss.orbits.continuation.correct import tangent_of
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

# Scaled length of the first step that is tried, and the part of the period by which an impact is
# moved off a jump for the derivatives there.
FIRST, OFF = 1e-2, 1e-6
# Halves of an orbit nearer than this are one.
SAME = 1e-6
# Sine of the angle to the border below which an impact stays at the jump.
ALONG = 1e-9


def doubled_at_border(orbit: PeriodicOrbit, path: str, side: float) -> PeriodicOrbit:
    """Return the orbit that has an impact before a jump of the force and after it in turn.

    Parameters
    ----------
    orbit
        The one whose impact is at the jump.
    path
        Path of the parameter.
    side
        1.0, or -1.0 for the same orbit a period later.

    Raises
    ------
    ParameterError
        If no such orbit starts there: the multipliers pass no -1 from one side to the other.
    ConvergenceError
        If none is found.
    """
    n = len(orbit.itinerary)
    if orbit.itinerary.halves_differ() < SAME:
        return primitive_orbit(orbit)
    cover = orbit_of_itinerary(orbit, orbit.itinerary.repeated(2))
    family, z, value = BranchEquations.around(cover, path)
    first = _nearest_jump(family, z, n)
    turns = round(orbit.period / float(family.system.law[0, REPEAT]))
    second = Crossing(first.event + n, first.jump + turns * len(family.jumps.knots), 1.0)
    matrix = family.derivatives(z + side * OFF * _apart(family.n, first.event, n))
    tangent = tangent_of(matrix, along_parameter(len(z)))
    rates = [side * dot(family.slope_of_border(z, each), tangent) for each in (first, second)]
    if rates[0] * rates[1] >= 0.0 or min(map(abs, rates)) < ALONG:
        reason = (
            "a border collision without doubling: the same orbits continue beyond it, or two end"
        )
        raise ParameterError("point", value, reason)
    # The first impact comes earlier, and the second later; the other way round for the other side.
    other, why = family.stepped_off(z, tangent if rates[0] < 0.0 else -tangent, FIRST)
    if other is None:
        what = f"no orbit of twice the period found at {path} = {value:.12g}"
        raise ConvergenceError(what, None, np.nan, why)
    return other


def _nearest_jump(family: BranchEquations, z: Floats, n: int) -> Crossing:
    """Return the impact of the first period that is nearest to a jump, and that jump."""
    passed = family.sides(z[:-1], family.values(z))[:n]
    impacts = [i for i in range(n) if family.walls[i]]
    candidates = [
        Crossing(i, jump, -1.0) for i in impacts for jump in (int(passed[i]) - 1, int(passed[i]))
    ]
    return min(candidates, key=lambda each: abs(family.beyond_jump(z, each)))


def _apart(n: int, i: int, shift: int) -> Floats:
    """Return the change of a point that moves event i earlier, and event i + shift later."""
    change = np.zeros(2 * n + 2)
    for event, way in ((i, -1.0), (i + shift, 1.0)):
        change[event] += way
        change[event + 1] -= way
    if i == 0:
        # It closes the orbit, too: its return is as early.
        change[n] -= 1.0
    return change
