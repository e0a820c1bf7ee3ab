"""Continuation where an event of the orbit meets a jump of the force.

An impact on either side of a jump has different accelerations about it, and with them another
saltation matrix: the map over the period is continuous, its derivative jumps. So the branch is
continuous with a corner, a border collision, at which it goes on or turns, and the multipliers jump.
At the edge of a soft stop the saltation matrix does not depend on the force: there the branch is
smooth (docs/theory/border-collisions.md).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.force_jumps import Crossing
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.continuation.correct import tangent_of
from percuss.orbits.continuation.problem import Point
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Border", "border_reached"]

BranchPoint = Point[BranchEquations]

# Lengths of the steps off a border onto either side, the first that succeeds, and half the length
# of the interval in which it is located, in scaled arclength.
STEPS_OFF, LOCATED = (1e-7, 1e-6, 1e-5), 1e-11
# Halves that differ by less than this part of the difference a step before are the same there.
SAME = 0.1
COVER = ": the orbit is the two-fold cover of one that meets it, too; switch_branch returns that"


@dataclass(frozen=True, slots=True)
class Border:
    """A point of a branch at which an event meets a jump of the force.

    Attributes
    ----------
    point
        The point itself.
    before, beyond
        Points next to it, on this side and on the other; None where the range of the parameter ends
        at it.
    special
        What it is; None where the branch is smooth.
    """

    point: BranchPoint
    before: BranchPoint
    beyond: BranchPoint | None
    special: SpecialPoint | None
    end_reason: str = ""


def border_reached(here: BranchPoint) -> Border | None:
    """Return the border that the last step from a point would have passed, None if there is none.

    Raises
    ------
    ConvergenceError
        If there is no orbit next to it on one of its sides.
    """
    family = here.problem
    if family.border is None:
        return None
    crossing, z, shifts = family.border
    family.recentre(None)
    towards = here.tangent if dot(here.tangent, z - here.z) > 0.0 else z - here.z
    tangents = [_one_sided(family, z, crossing, way * shifts, towards) for way in (1.0, -1.0)]
    before = _stepped(family, z, crossing, -1.0, tangents[0])
    if norm(before.z - z) > norm(here.z - z):
        before = dataclasses.replace(here, tangent=tangents[0])
    point = Point(z, tangents[0], family.solution(z), before.tests, family)
    if _difference(point.orbit) < SAME * _difference(before.orbit):
        cover = _special(family, z, crossing, tangents, COVER)
        why = f"at {point.text} the orbit is the two-fold cover of a shorter one"
        return Border(point, before, None, cover, why)
    beyond: BranchPoint | None
    try:
        beyond = _stepped(family, z, crossing, 1.0, tangents[1])
    except ConvergenceError:
        if 0.0 < z[-1] + STEPS_OFF[0] * tangents[1][-1] < 1.0:
            raise
        beyond = None
    effect = "" if beyond is None else f": {_effect(before, beyond)}"
    is_wall = family.walls[crossing.event]
    special = _special(family, z, crossing, tangents, effect) if is_wall else None
    return Border(point, before, beyond, special, f"{point.text} reached" if beyond is None else "")


def _difference(orbit: PeriodicOrbit) -> float:
    """Return the difference of an orbit's halves, infinite where they are no halves."""
    return orbit.itinerary.halves_differ()


def _one_sided(
    family: BranchEquations, z: Floats, crossing: Crossing, shifts: Floats, towards: Floats
) -> Floats:
    """Return the unit tangent on one side of a border, towards the other side or away from it."""
    tangent = tangent_of(family.by_side(z, shifts), towards)
    rate = crossing.way * dot(family.slope_of_border(z, crossing), tangent)
    return tangent if rate > 0.0 else -tangent


def _stepped(
    family: BranchEquations, z: Floats, crossing: Crossing, way: float, tangent: Floats
) -> BranchPoint:
    """Return the point a small step off a border, -1 before it, 1 beyond."""
    error: PercussError | None = None
    for length in STEPS_OFF:
        guess = z + way * length * tangent
        try:
            there = family.corrected(guess, tangent)
        except PercussError as caught:
            error = caught
            continue
        inside = 0.0 <= there[-1] <= 1.0
        if inside and way * crossing.way * family.beyond_jump(there, crossing) > 0.0:
            orbit = family.solution(there)
            return Point(there, tangent, orbit, family.tests(orbit), family)
    what = f"no orbit next to the border: {error or 'it lies on the other side'}"
    raise ConvergenceError(what, z, np.nan, "follow the branch from either side")


def _special(
    family: BranchEquations,
    z: Floats,
    crossing: Crossing,
    tangents: list[Floats],
    effect: str,
) -> SpecialPoint:
    """Return the border collision of an impact."""
    ends = (family.value(z - LOCATED * tangents[0]), family.value(z + LOCATED * tangents[1]))
    stop = next(stop for row, stop, _ in family.entries if row == crossing.event)
    detail = f"an impact on stop {stop} meets a jump of the force{effect}"
    low, high = sorted((*ends, family.value(z)))[:: len(ends)]
    return SpecialPoint(
        "border_collision",
        family.path,
        family.value(z),
        (low, high),
        "located",
        family.solution(z),
        -1,
        detail,
        tangent=(tangents[0] + tangents[1]) * np.append(family.scale, family.high - family.low),
    )


def _effect(before: BranchPoint, beyond: BranchPoint) -> str:
    """Return in words what a border collision does, from the orbits on both sides.

    By the signs of det(1 - M) and det(1 + M) on the two sides (Feigin 1970; di Bernardo et al.
    1999).
    """
    one, other = before.orbit, beyond.orbit
    doubles = _at(one, -1.0) * _at(other, -1.0) < 0.0
    also = "; an orbit of twice the period starts" if doubles else ""
    sizes = " to ".join(_moduli(orbit) for orbit in (one, other))
    if before.tangent[-1] * beyond.tangent[-1] < 0.0:
        return f"two orbits meet and end, a nonsmooth fold, abs(multipliers) {sizes}{also}"
    change = ""
    if one.stability != other.stability:
        change = f", from {one.stability} to {other.stability}"
    return f"the branch goes on, and abs(multipliers) jump from {sizes}{change}{also}"


def _at(orbit: PeriodicOrbit, multiplier: float) -> float:
    """Return the characteristic polynomial of an orbit at a real number."""
    return float(np.prod(orbit.multipliers - multiplier).real)


def _moduli(orbit: PeriodicOrbit) -> str:
    """Return the moduli of the multipliers, the larger first."""
    sizes = sorted((abs(each) for each in orbit.multipliers.tolist()), reverse=True)
    return ", ".join(f"{size:.4g}" for size in sizes)
