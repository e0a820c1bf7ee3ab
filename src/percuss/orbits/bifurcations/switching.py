"""From one family of periodic orbits to another that starts from it."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.exact import as_float
from percuss.model.paths import get_parameter
from percuss.numerics import directions, matmul, norm
from percuss.orbits.bifurcations.family import Family, own_value
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    grazing_contacts,
    merged,
    without,
)
from percuss.orbits.bifurcations.n_fold import orbit_of_itinerary, primitive_orbit
from percuss.orbits.bifurcations.soft_grazing import is_soft, orbit_beyond
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["orbit_past_graze", "switch_branch"]


# Kinds of points at which another family starts, and what to say of the others.
SWITCHED = ("period_doubling", "symmetry_breaking", "branch_point", "grazing")
OTHERS = {
    "fold": "the family turns there, and no other one starts",
    "chatter": "impacts accumulate there, and those beyond stick",
    "corner": "the same orbits go on beyond it, where they do",
    "strong_resonance": "the orbits born there are no branch of this family",
}
# Half the range of the parameter that is the unit of its steps, as a part of its value.
BESIDE = 0.01
# Length of the step off, as a part of the period and of the largest velocity, and past a graze.
FIRST, FIRST_PAST_GRAZE = 1e-2, 1e-3
# Directions that the equations hold as weakly as this, as a part of the strongest, are free.
FREE = 1e-4


def switch_branch(point: SpecialPoint, *, other_side: bool = False) -> PeriodicOrbit:
    """Return the first orbit of the family that starts at a special point of another.

    At a period doubling that is the orbit of twice the period; where a symmetry breaks, one of
    the two that mirror each other; at a branch point, an orbit of the family that crosses; at a
    graze, one with another impact, or without the one that has no velocity. In the first three the
    equations are those of the orbit, of its two-fold cover at a doubling; they hold two directions
    weakly, one along the branch, and the step goes along the other (Keller 1977, section 5; Seydel
    2010, section 5.6). Newton's method follows it with the length of that step held and the
    parameter free.

    Parameters
    ----------
    point
        Of kind "period_doubling", "symmetry_breaking", "branch_point" or "grazing".
    other_side
        Not at a graze: step the other way: to the mirrored orbit, the same doubled orbit a period
        later, or to the other half of a family that crosses.

    Returns
    -------
    PeriodicOrbit
        Ready for `continue_orbit` along the same parameter. Where a doubled family is born from
        a shorter orbit that doubles, a "period_doubling" of either branch, it is from the doubled
        branch that shorter orbit: the `detail` of the point says so.

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
    tangent = point._tangent
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
    """Return an orbit a step away, along what the equations leave free beside the tangent."""
    value = as_float(get_parameter(orbit.oscillator, orbit.forcing, None, path))
    beside = BESIDE * abs(value) or BESIDE
    family = Family(orbit, path, value - beside, value + beside)
    start = family.start(orbit, value)
    direction = side * _across(family, start, tangent)
    found, why = family.stepped_off(start, direction, FIRST)
    if found is not None:
        return found
    what = f"no other family found at {path} = {value:.12g}"
    raise ConvergenceError(what, None, np.nan, f"{why}; look whether the point is located")


def _across(family: Family, start: Floats, tangent: Floats | None) -> Floats:
    """Return the unit direction that the equations leave free and that is not the tangent's."""
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
    # One and the same side on every machine.
    largest = int(np.argmax(np.abs(across)))
    return np.asarray(across * np.sign(across[largest]))


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
    contacts = grazing_contacts(orbit)
    found: PeriodicOrbit | None = None
    if any(is_soft(orbit, touch) for touch in contacts):
        family = Family(orbit, path, value - beside, value + beside)
        found = orbit_beyond(family, orbit, value)
    elif _all_with_impacts(orbit, contacts):
        found = _without_impacts(orbit, path, (value - beside, value + beside), contacts)
    else:
        added = [touch for touch in contacts if not touch.events]
        found = _with_impacts(orbit, path, (value - beside, value + beside), added)
    if found is None:
        advice = "look whether the graze is located, and whether another one lies beside it"
        raise ConvergenceError(f"no other family found at {where}", None, np.nan, advice)
    return found


def _all_with_impacts(orbit: PeriodicOrbit, contacts: list[GrazingContact]) -> bool:
    """Return whether an orbit, or a shorter one that it goes round, has an impact at each touch."""
    if all(touch.events for touch in contacts):
        return True
    if not any(touch.events for touch in contacts):
        return False
    return all(touch.events for touch in merged(contacts, without(orbit, contacts).period))


def _without_impacts(
    orbit: PeriodicOrbit, path: str, ends: tuple[float, float], contacts: list[GrazingContact]
) -> PeriodicOrbit | None:
    """Return an orbit that does not come to the stop, on the side where that is so."""
    base = without(orbit, contacts)
    family = Family(base, path, *ends)
    start = family.start(base, own_value(base, path))
    held = along_parameter(len(start))
    for sign in (-1.0, 1.0):
        try:
            found = family.solution(family.corrected(start + sign * FIRST_PAST_GRAZE * held, held))
        except PercussError:
            continue
        if found.admissible:
            return found
    return None


def _with_impacts(
    orbit: PeriodicOrbit, path: str, ends: tuple[float, float], contacts: list[GrazingContact]
) -> PeriodicOrbit | None:
    """Return an orbit with an impact at each touch."""
    instants = np.array([orbit.t0 + (touch.t - orbit.t0) % orbit.period for touch in contacts])
    rows = [[touch.bound, touch.region, touch.region] for touch in contacts]
    itinerary, _ = orbit.itinerary.inserted(instants, np.array(rows, dtype=np.int64), orbit.period)
    grazing = orbit_of_itinerary(orbit, itinerary)
    family = Family(grazing, path, *ends)
    start = family.start(grazing, own_value(orbit, path))
    tangent = family.tangent(start, along_parameter(len(start)))
    found, _ = family.stepped_off(
        start, tangent, FIRST_PAST_GRAZE, signs=(-1.0, 1.0),
        is_wanted=lambda orbit: bool((family.into_stops(orbit) > 0.0).all()),
    )  # fmt: skip
    return found
