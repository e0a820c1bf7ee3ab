"""From one family of periodic orbits to another that starts from it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.exact import as_float
from percuss.model.paths import get_parameter
from percuss.numerics import directions, matmul, norm
from percuss.orbits.families.family import Family
from percuss.orbits.families.graze_switching import orbit_past_graze
from percuss.orbits.families.rounds import doubled, doubled_unknowns, halves_differ, once_round
from percuss.orbits.families.special_points import SpecialPoint
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["switch_branch"]

Floats = NDArray[np.float64]

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
# Length of the step off, as a part of the period and of the largest velocity, and the least one.
FIRST, LEAST = 1e-2, 1e-9
SHORTER = 0.25
# By how much of its length a step may miss the family, so that what it finds is the family that
# starts here and no other.
BENT = 0.1
# Directions that the equations hold as weakly as this, as a part of the strongest, are free.
FREE = 1e-4


def switch_branch(point: SpecialPoint, *, other_side: bool = False) -> PeriodicOrbit:
    """Return the first orbit of the family that starts at a special point of another.

    At a period doubling that is the orbit of twice the period; where a symmetry breaks, one of
    the two that mirror each other; at a branch point, an orbit of the family that crosses; at a
    graze, one with another impact, or without the one that has no velocity. In the first three the
    equations are those of the orbit, gone round twice at a doubling; they hold two directions
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
    if len(orbit._chain) == 0:
        raise ParameterError("point", point.value, "an orbit without impacts; no other starts")
    tangent = point._tangent
    if point.kind == "period_doubling":
        if halves_differ(orbit) < FREE:
            return once_round(orbit)
        orbit = doubled(orbit)
        if tangent is not None:
            tangent = np.append(doubled_unknowns(tangent[:-1]), tangent[-1])
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
    size, why = FIRST, ""
    while size >= LEAST:
        guess = start + size * direction
        try:
            found = family.corrected(guess, direction)
            if norm(found - guess) < BENT * size:
                return family.orbit(found)
            why = "the family bends away"
        except PercussError as error:
            why = str(error)
        size *= SHORTER
    what = f"no other family found at {path} = {value:.12g}"
    raise ConvergenceError(what, None, np.nan, f"{why}; look whether the point is located")


def _across(family: Family, start: Floats, tangent: Floats | None) -> Floats:
    """Return the unit direction that the equations leave free and that is not the tangent's."""
    _, matrix = family.residual(start, family.value(start))
    slope = family.slope(start)
    sizes, rows = directions(np.column_stack([matrix, slope]))
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
