"""Continuation where an event of the orbit meets a jump of the force.

An impact on either side of a jump has different accelerations about it, and with them another
saltation matrix: the map over the period is continuous, its derivative jumps. So the branch is
continuous with a corner, a border collision, at which it goes on or turns, and the multipliers
jump. At the edge of a soft stop the saltation matrix does not depend on the force: there the branch
is smooth (docs/theory/border-collisions.md).
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.bifurcation_origin import ENDS
from percuss.orbits.bifurcations.borders import ReachedBorder
from percuss.orbits.bifurcations.force_jumps import Crossing
from percuss.orbits.continuation.correct import tangent_of
from percuss.orbits.continuation.problem import Point, Problem

# Lengths of the steps off a border onto either side, the first that succeeds, and half the length
# of the interval in which it is located, in scaled arclength.
STEPS_OFF, LOCATED = (1e-7, 1e-6, 1e-5), 1e-11
# Halves that differ by less than this part of the difference a step before are the same there.
SAME = 0.1
COVER = "the orbit is the two-fold cover of one that meets it, too; switch_branch returns that"


class BorderedProblem(Problem, Protocol):
    """A problem of continuation with borders (`percuss.orbits.bifurcations.borders`)."""

    border: ReachedBorder | None
    centre: Floats | None

    def by_side(self, z: Floats, sides: Floats) -> Floats:
        """Return the derivatives at a point of a border from the sides of its events."""

    def beyond_jump(self, z: Floats, crossing: Crossing) -> float:
        """Return by how much of the period an event lies after a jump of the force."""

    def slope_of_border(self, z: Floats, crossing: Crossing) -> Floats:
        """Return the derivative of `beyond_jump` by a point."""

    def halves_differ(self, orbit: Any) -> float:
        """Return the difference of an orbit's halves, infinite where they are no halves."""

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution as a point."""


B = TypeVar("B", bound=BorderedProblem)


@dataclass(frozen=True, slots=True)
class Border(Generic[B]):
    """A point of a branch at which an event meets a jump of the force.

    Attributes
    ----------
    event
        The row of the event.
    point
        The point itself.
    before, beyond
        Points next to it, on this side and on the other; None where the branch ends at it.
    chord
        Sum of the unit tangents of both sides.
    interval
        Ends of the part of the branch in which it lies.
    end_reason
        Why the branch ends at it, "" where it goes on.
    """

    event: int
    point: Point[B]
    before: Point[B]
    beyond: Point[B] | None
    chord: Floats
    interval: tuple[float, float]
    end_reason: str


def border_reached(here: Point[B]) -> Border[B] | None:
    """Return the border that the last step from a point would have passed, None if there is none.

    Raises
    ------
    ConvergenceError
        If there is no orbit next to it on one of its sides.
    """
    problem = here.problem
    if problem.border is None:
        return None
    crossing, z, sides = problem.border
    problem.border = problem.centre = None
    towards = here.tangent if dot(here.tangent, z - here.z) > 0.0 else z - here.z
    tangents = [_one_sided(here, sign * sides, (z, towards, crossing)) for sign in (1.0, -1.0)]
    before = _stepped(here, z, crossing, -1.0, tangents[0])
    if norm(before.z - z) > norm(here.z - z):
        before = dataclasses.replace(here, tangent=tangents[0])
    point = dataclasses.replace(before, z=z, orbit=problem.solution(z))
    beyond: Point[B] | None = None
    end_reason = ""
    if problem.halves_differ(point.orbit) < SAME * problem.halves_differ(before.orbit):
        end_reason = f"at {point.text} {ENDS['doubled']}"
    else:
        try:
            beyond = _stepped(here, z, crossing, 1.0, tangents[1])
        except ConvergenceError:
            if 0.0 < z[-1] + STEPS_OFF[0] * tangents[1][-1] < 1.0:
                raise
            end_reason = f"{point.text} reached"
    ends = [
        problem.values(z + sign * LOCATED * tangent)[0]
        for sign, tangent in zip((-1.0, 0.0, 1.0), (tangents[0], z, tangents[1]), strict=True)
    ]
    interval = min(ends), max(ends)
    chord = tangents[0] + tangents[1]
    return Border(crossing.event, point, before, beyond, chord, interval, end_reason)


def _one_sided(here: Point[B], sides: Floats, at: tuple[Floats, Floats, Crossing]) -> Floats:
    """Return the unit tangent on one side of a border, in the direction in which it is passed."""
    z, towards, crossing = at
    tangent = tangent_of(here.problem.by_side(z, sides), towards)
    rate = crossing.side * dot(here.problem.slope_of_border(z, crossing), tangent)
    return tangent if rate > 0.0 else -tangent


def _stepped(
    here: Point[B], z: Floats, crossing: Crossing, sign: float, tangent: Floats
) -> Point[B]:
    """Return the point a small step off a border, -1 before it, 1 beyond."""
    problem, error = here.problem, "it lies on the other side"
    for length in STEPS_OFF:
        try:
            stepped = problem.corrected(z + sign * length * tangent, tangent)
        except PercussError as caught:
            error = str(caught)
            continue
        inside = 0.0 <= stepped[-1] <= 1.0
        if inside and sign * crossing.side * problem.beyond_jump(stepped, crossing) > 0.0:
            point = problem.point(stepped, dataclasses.replace(here, tangent=tangent))
            return dataclasses.replace(point, tangent=tangent)
    what = f"no orbit next to the jump of the force: {error}"
    raise ConvergenceError(what, z, math.nan, "follow the branch from its other side")


def effect_of(border: Border[B]) -> str:
    """Return in words what a border collision does, from the orbits on both sides.

    By the signs of det(1 - M) and det(1 + M) on the two sides (Feigin 1970; di Bernardo et al.
    1999).
    """
    if border.beyond is None:
        return f": {COVER}" if "cover" in border.end_reason else ""
    before, beyond = border.before, border.beyond
    one, other = before.orbit.multipliers, beyond.orbit.multipliers
    also = "; an orbit of twice the period starts" if _at(one, -1.0) * _at(other, -1.0) < 0 else ""
    sizes = f"{_moduli(one)} to {_moduli(other)}"
    if before.tangent[-1] * beyond.tangent[-1] < 0.0:
        return f": two orbits meet and end, a nonsmooth fold, abs(multipliers) {sizes}{also}"
    stable = [bool(each.orbit.is_stable) for each in (before, beyond)]
    change = ""
    if stable[0] != stable[1]:
        change = ", from stable to unstable" if stable[0] else ", from unstable to stable"
    return f": the branch goes on, and abs(multipliers) jump from {sizes}{change}{also}"


def _at(multipliers: Complexes, edge: float) -> float:
    """Return the characteristic polynomial of an orbit at a real number."""
    return float(np.prod(multipliers - edge).real)


def _moduli(multipliers: Complexes) -> str:
    """Return the moduli of the two largest multipliers."""
    sizes = sorted((abs(each) for each in multipliers.tolist()), reverse=True)
    return ", ".join(f"{size:.4g}" for size in sizes[:2])
