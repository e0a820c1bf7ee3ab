"""Branch switching: the family of a structure's orbits that starts at a special point of another."""

from __future__ import annotations

import numpy as np

from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.exact import as_float
from percuss.model.paths import get_parameter
from percuss.numerics import directions
from percuss.orbits.bifurcations.parameter_ranges import range_around
from percuss.orbits.bifurcations.structure_branch import StructureEquations, StructureSpecialPoint
from percuss.orbits.orbit.structure_orbit import StructureOrbit, covered_twice

# Scaled lengths of the step: next to a graze the other family bends soon.
STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5)
# The other family is there if a step comes back with this part of its length: that from the halves
# of orbits that cover the one, or mirror it, to the whole; these too go on along the parameter.
KEPT = 0.3


def switch_structure_branch(
    point: StructureSpecialPoint, *, other_side: bool = False
) -> StructureOrbit:
    """Return the first orbit of the family that starts at a special point of a structure.

    At a period doubling, or a branch point, the derivative of the map over its period turns one
    direction into its opposite, or leaves it as it is. The step goes along it, its length is kept,
    and the parameter is free.

    Raises
    ------
    ParameterError
        If no other family starts at such a point, or its orbit is formal.
    ConvergenceError
        If none is found there.
    """
    if point.kind not in ("period_doubling", "symmetry_breaking", "branch_point"):
        reason = f"a point of kind {point.kind} of a structure; no other family is known there"
        raise ParameterError("point", point.value, reason)
    if not point.orbit.admissible:
        reason = (
            "its orbit is formal, it passes through a wall; the family beside it is not followed"
        )
        raise ParameterError("point", point.value, reason)
    orbit, doubles = point.orbit, point.kind == "period_doubling"
    value = as_float(get_parameter(orbit.structure, orbit.loads, None, point.path))
    cover = covered_twice(orbit) if doubles else orbit
    equations = StructureEquations(cover, {point.path: range_around(value)})
    start = equations.started(cover, [value])
    turned = orbit.monodromy * (equations.scale[None, :] / equations.scale[:, None])
    weakest = directions(turned + (1.0 if doubles else -1.0) * np.eye(equations.size))[1][-1]
    largest = int(np.argmax(np.abs(weakest)))
    sign = np.sign(weakest[largest]) * (-1.0 if other_side else 1.0)
    along = np.append(sign * weakest, 0.0)
    for length in STEPS:
        try:
            z = equations.corrected(start.z + length * along, along)
            other = equations.solution(z)
        except PercussError:
            continue
        if point.kind == "branch_point":
            moved = equations.unknowns(other) - start.z[:-1]
        else:
            moved = equations.halves(other)
        if np.abs(moved).max() > KEPT * length:
            return other
    what = f"no other family found at {point.path} = {value:.12g}"
    raise ConvergenceError(what, None, np.nan, "look whether the point is located")
