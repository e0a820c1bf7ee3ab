"""From one family of periodic orbits to another that starts from it."""

from __future__ import annotations

import math
from typing import overload

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.numerics import directions, matmul, norm
from percuss.orbits.bifurcations.border_doubling import doubled_at_border
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    grazing_contacts,
    merged,
    without,
)
from percuss.orbits.bifurcations.multiple_covers import orbit_of_itinerary, primitive_orbit
from percuss.orbits.bifurcations.parameter_ranges import own_value, range_around
from percuss.orbits.bifurcations.soft_grazing import is_soft, orbit_beyond
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.bifurcations.structure_branch import StructureSpecialPoint
from percuss.orbits.bifurcations.structure_switching import switch_structure_branch
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

# Kinds of points at which another family starts, and what to say of the others.
SWITCHED = ("period_doubling", "symmetry_breaking", "branch_point", "grazing", "border_collision")
OTHERS = {
    "fold": "the family turns there, and no other one starts",
    "chatter": "impacts accumulate there, and the orbits beyond it stick",
    "corner": "the same orbits continue beyond it, if any do",
    "strong_resonance": "the orbits that bifurcate there are no branch of this family",
    "torus": "what starts there is an invariant torus, no periodic orbit",
}
# Scaled length of the step onto the other family, and of that past a graze.
FIRST, FIRST_PAST_GRAZE = 1e-2, 1e-3
# Directions of singular values below this part of the largest are free.
FREE = 1e-4


@overload
def switch_branch(point: SpecialPoint, *, other_side: bool = False) -> PeriodicOrbit: ...
@overload
def switch_branch(point: StructureSpecialPoint, *, other_side: bool = False) -> StructureOrbit: ...
def switch_branch(
    point: SpecialPoint | StructureSpecialPoint, *, other_side: bool = False
) -> PeriodicOrbit | StructureOrbit:
    """Return the first orbit of the family that starts at a special point of another.

    At a period doubling that is the orbit of twice the period; where a symmetry breaks, one of
    the two that mirror each other; at a branch point, an orbit of the family that crosses; at a
    graze, one with another impact, or without the one of zero velocity; at a border collision, the
    orbit of twice the period that has the impact before the jump of the force and after it in turn,
    where one starts. In the first three cases
    the equations are those of the orbit, at a doubling of its two-fold cover; they have two small
    singular values, one along the branch, and the step goes along the other (Keller 1977,
    section 5; Seydel 2010, section 5.6). Newton's method corrects it with the length of that step
    fixed and the parameter free.

    Parameters
    ----------
    point
        Of kind "period_doubling", "symmetry_breaking", "branch_point", "grazing" or
        "border_collision"; of a structure one of the first three.
    other_side
        Whether to step in the opposite direction, not at a graze: to the mirrored orbit, the same
        doubled orbit a period later, or the other half of a family that crosses.

    Returns
    -------
    PeriodicOrbit or StructureOrbit
        Ready for `continue_orbit` along the same parameter. From the doubled branch, at the
        "period_doubling" from which it bifurcates, it is the primitive orbit: the `detail` of the
        point says so.

    Raises
    ------
    ParameterError
        If no other family starts at such a point.
    ConvergenceError
        If none is found there.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.6, 2.7)})
    >>> doubled = switch_branch(branch.special_points[0])
    >>> doubled.n_impacts, doubled.n_periods, doubled.stability
    (2, 2, 'asymptotic')
    """
    if isinstance(point, StructureSpecialPoint):
        return switch_structure_branch(point, other_side=other_side)
    if not isinstance(point, SpecialPoint):
        raise ParameterError("point", point, "no special point; a branch has some, or none")
    if point.kind not in SWITCHED:
        reason = f"a point of kind {point.kind}; {OTHERS.get(point.kind, 'no other family starts')}"
        raise ParameterError("point", point.value, reason)
    orbit = point.orbit
    if math.isinf(orbit.n_impacts):
        reason = "an orbit with sticking; its own family goes on, and no other starts"
        raise ParameterError("point", point.value, reason)
    if point.kind == "grazing":
        return orbit_past_graze(orbit, point.path)
    if len(orbit.itinerary) == 0:
        raise ParameterError("point", point.value, "an orbit without impacts; no other starts")
    if point.kind == "border_collision":
        return doubled_at_border(orbit, point.path, -1.0 if other_side else 1.0)
    tangent = point.tangent
    if point.kind == "period_doubling":
        if orbit.itinerary.halves_differ() < FREE:
            return primitive_orbit(orbit)
        single, double = orbit.itinerary, orbit.itinerary.repeated(2)
        orbit = orbit_of_itinerary(orbit, double, isolated=orbit.isolated)
        if tangent is not None:
            along = Itinerary.of_vector(single.events, tangent[:-1], 1).repeated(2)
            tangent = np.append(along.vector, tangent[-1])
    return _stepped_off(orbit, point.path, tangent, -1.0 if other_side else 1.0)


def _stepped_off(
    orbit: PeriodicOrbit, path: str, tangent: Floats | None, side: float
) -> PeriodicOrbit:
    """Return an orbit a step away, along the free direction that is not the tangent."""
    family, start, value = BranchEquations.around(orbit, path)
    direction = side * _across(family, start, tangent)
    other, why = family.stepped_off(start, direction, FIRST)
    if other is not None:
        return other
    what = f"no other family found at {path} = {value:.12g}"
    raise ConvergenceError(what, None, np.nan, f"{why}; look whether the point is located")


def _across(family: BranchEquations, start: Floats, tangent: Floats | None) -> Floats:
    """Return the unit vector of the free direction that is not the tangent."""
    sizes, rows = directions(family.derivatives(start))
    if sizes[-2] > FREE * sizes[0]:
        what = f"the orbit at {family.path} = {family.value(start):.12g} has no second direction"
        raise ConvergenceError(what, None, np.nan, "take a special point of a branch")
    free = rows[-2:]
    if tangent is None:
        along = free[:, -1].copy()
    else:
        along = matmul(free, tangent / np.append(family.scale, family.high - family.low))
    along /= norm(along)
    across = along[0] * free[1] - along[1] * free[0]
    # The same sign on every machine.
    largest = int(np.argmax(np.abs(across)))
    return np.asarray(across * np.sign(across[largest]))


def orbit_past_graze(orbit: PeriodicOrbit, path: str) -> PeriodicOrbit:
    """Return an orbit of the other family that starts at a graze.

    Where a turning point grazes a stop that is one with another impact there; where an impact has
    zero velocity, one without it. Either is admissible there.

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
    where = f"{path} = {value:.12g}"
    contacts = grazing_contacts(orbit)
    if any(is_soft(orbit, contact) for contact in contacts):
        other = orbit_beyond(BranchEquations(orbit, path, *range_around(value)), orbit, value)
    elif _all_with_impacts(orbit, contacts):
        other = _without_impacts(orbit, path, contacts)
    else:
        added = [contact for contact in contacts if not contact.events]
        other = _with_impacts(orbit, path, added)
    if other is None:
        advice = "look whether the graze is located, and whether another one lies beside it"
        raise ConvergenceError(f"no other family found at {where}", None, np.nan, advice)
    return other


def _all_with_impacts(orbit: PeriodicOrbit, contacts: list[GrazingContact]) -> bool:
    """Return whether an orbit, or a primitive one that it covers, has an impact at each graze."""
    if all(contact.events for contact in contacts):
        return True
    if not any(contact.events for contact in contacts):
        return False
    return all(contact.events for contact in merged(contacts, without(orbit, contacts).period))


def _without_impacts(
    orbit: PeriodicOrbit, path: str, contacts: list[GrazingContact]
) -> PeriodicOrbit | None:
    """Return an orbit that does not reach the stop, on the side where it is admissible."""
    family, start, _ = BranchEquations.around(without(orbit, contacts), path)
    normal = along_parameter(len(start))
    for step in (-FIRST_PAST_GRAZE, FIRST_PAST_GRAZE):
        try:
            other = family.solution(family.corrected(start + step * normal, normal))
        except PercussError:
            continue
        if other.admissible:
            return other
    return None


def _with_impacts(
    orbit: PeriodicOrbit, path: str, contacts: list[GrazingContact]
) -> PeriodicOrbit | None:
    """Return an orbit with an impact at each graze."""
    instants = np.array([orbit.t0 + (contact.t - orbit.t0) % orbit.period for contact in contacts])
    rows = [[contact.bound, contact.region, contact.region] for contact in contacts]
    itinerary, _ = orbit.itinerary.inserted(instants, np.array(rows, dtype=np.int64), orbit.period)
    family, start, _ = BranchEquations.around(orbit_of_itinerary(orbit, itinerary), path)
    tangent = family.tangent(start, along_parameter(len(start)))
    other, _ = family.stepped_off(
        start, tangent, FIRST_PAST_GRAZE, signs=(-1.0, 1.0),
        is_wanted=lambda orbit: bool((family.into_stops(orbit) > 0.0).all()),
    )  # fmt: skip
    return other
