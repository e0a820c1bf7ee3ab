"""Zeros of a test function between two points of a branch or curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.numerics import norm
from percuss.orbits.continuation.problem import P, Point, along_parameter

# A bracket in scaled arclength that is as good as a point: the points themselves are known to
# some 1e-13.
CLOSE = 1e-12
MOST_STEPS = 80
# How often the corrector may fail, the parts of the bracket that are tried then, and the longest
# bracket that is accepted nevertheless, as a part of the chord.
MOST_LOST, ASIDE, LOST = 12, (0.5, 0.25, 0.75, 0.4, 0.6, 0.1, 0.9), 1e-2
# Points through which a guess is interpolated, and how far apart they are at least, as a part of
# the bracket.
NODES, APART = 4, 0.1
# Largest value of a function next to a zero that it goes through, as a part of those at the ends.
LEFT = 1e-4
# First and largest scaled distance of the ends of a bracket from a solution, and the factor between
# two.
NEAR, FAR, FARTHER = 1e-7, 1e-2, 4.0
# Part of a chord over which the slope of a test is taken.
NEXT = 1e-3


@dataclass(frozen=True, slots=True)
class Zero:
    """A zero on the chord between two points.

    Attributes
    ----------
    part
        Part of the chord at which it lies.
    z, orbit
        The point.
    ends
        Points between which it lies.
    goes_through
        Whether the function goes through zero there; otherwise it jumps.
    """

    part: float
    z: Floats
    orbit: Any
    ends: tuple[Floats, Floats]
    goes_through: bool


class Sample(NamedTuple):
    """A function's value at a part of a chord."""

    part: float
    value: float
    z: Floats


def changes_sign(before: float, after: float) -> bool:
    """Return whether a test reaches or passes zero from one point to the next."""
    return before != 0.0 and np.sign(before) * np.sign(after) <= 0.0


def turns_through_zero(at: Callable[[float], float], ends: tuple[float, float]) -> bool:
    """Return whether a test of one sign at both ends of a chord has the other between them.

    The test is given ``at`` a part of the chord. It is asked where its tangents at the ends meet.

    Examples
    --------
    >>> [turns_through_zero(lambda s: 0.3 - s * (1.0 - s) - low, (0.3 - low,) * 2) for low in (0, 0.1)]
    [False, True]
    """
    left, right = ends
    if not left * right > 0.0:
        return False
    rise = (at(NEXT) - left) / NEXT
    if rise * left >= 0.0:
        return False
    fall = (right - at(1.0 - NEXT)) / NEXT
    if fall * left <= 0.0:
        return False
    part = (right - fall - left) / (rise - fall)
    return 0.0 < part < 1.0 and (left + rise * part) * left <= 0.0 and at(part) * left < 0.0


def locate(
    a: Point[P],
    b: Point[P],
    test: Callable[[Floats], float],
    values: tuple[float, float],
    *,
    near_others: bool = True,
) -> Zero | None:
    """Return a zero of a test function between two points, None if it is not found.

    Parameters
    ----------
    a, b
        Two neighbours that solve one problem.
    test
        The function of a point.
    values
        Its values at both, of opposite signs; or the second is 0.
    near_others
        Whether other branches may cross at the zero: then a further singular value is small, and
        the corrector takes more steps.
    """
    problem = a.problem
    chord = b.z - a.z
    length = norm(chord)
    # A response turns far off the chord where it resonates. At its graze, next to which derivatives
    # by the parameter jump, the corrector does without these.
    are_responses = a.is_response and b.is_response
    goes_on = a.tangent[-1] * b.tangent[-1] > 0.0
    ends_response = goes_on and (a.is_response or b.is_response)
    is_upright = are_responses or ends_response
    normal = along_parameter(len(chord)) if is_upright else chord / length
    known = {0.0: a.z, 1.0: b.z}

    def at(part: float) -> Sample:
        guess = a.z + part * chord
        if problem.order == 3:
            # Where the equations are expensive.
            guess = _between(known, part)
        try:
            z = problem.corrected(guess, normal, near_others=near_others)
        except ConvergenceError:
            z = problem.corrected(guess, normal, near_others=not near_others)
        if norm(z - guess) > length and not are_responses:
            raise ConvergenceError("Newton's method leaves the chord", z, math.nan, "look aside")
        known[part] = z
        return Sample(part, test(z), z)

    ends = Sample(0.0, values[0], a.z), Sample(1.0, values[1], b.z)
    low, high, best, lost = bracketed(at, ends, CLOSE / length)
    if lost and high.part - low.part > LOST:
        return None
    through = abs(low.value) + abs(high.value) <= LEFT * (abs(values[0]) + abs(values[1]))
    if best.value == 0.0:
        low, high, through = best, best, True
    orbit = {0.0: a.orbit, 1.0: b.orbit}.get(best.part) or problem.solution(best.z)
    return Zero(best.part, best.z, orbit, (low.z, high.z), through)


def locate_near(
    problem: P,
    start: Floats,
    direction: Floats,
    test: Callable[[Floats], float],
    *,
    near_others: bool = True,
) -> Zero | None:
    """Return the zero of a test function near a solution of one parameter, None for none.

    The arguments are those of `locate`; the direction is a unit vector along which solutions lie.

    Raises
    ------
    PercussError
        If the problem has no solution next to the given one.
    """
    distance = NEAR
    while distance <= FAR:
        a, b = (
            Point(
                problem.corrected(start + step * direction, direction), direction, None, {}, problem
            )
            for step in (-distance, distance)
        )
        values = test(a.z), test(b.z)
        if changes_sign(*values):
            return locate(a, b, test, values, near_others=near_others)
        distance *= FARTHER
    return None


def _between(known: dict[float, Floats], part: float) -> Floats:
    """Return the polynomial through a few known points at a part of the chord between them.

    Through its neighbours at either side first, and up to two others that are not too near to
    these. It stays in the plane of the chord: as a function of the part that is a straight line.
    """
    if part in known:
        return known[part]
    left = max(other for other in known if other < part)
    right = min(other for other in known if other > part)
    nodes = [left, right]
    for other in sorted(known, key=lambda other: abs(other - part)):
        if len(nodes) < NODES and min(abs(other - node) for node in nodes) > APART * (right - left):
            nodes.append(other)
    differences = [known[node] for node in nodes]
    for order in range(1, len(nodes)):
        for k in range(len(nodes) - 1, order - 1, -1):
            rise = differences[k] - differences[k - 1]
            differences[k] = rise / (nodes[k] - nodes[k - order])
    value = differences[-1]
    for k in range(len(nodes) - 2, -1, -1):
        value = differences[k] + (part - nodes[k]) * value
    return value


def bracketed(
    at: Callable[[float], Sample], ends: tuple[Sample, Sample], tolerance: float
) -> tuple[Sample, Sample, Sample, bool]:
    """Shrink a bracket about a change of sign.

    The function is given ``at`` a part of the chord, and at both ends; a bracket of the tolerance's
    length, as a part of the chord, is short enough. Returns both ends, the sample with the least
    value, and whether too many samples were lost.
    """
    low, high = ends
    best = high if abs(high.value) < abs(low.value) else low
    lost = 0
    for k in range(MOST_STEPS):
        if high.part - low.part <= tolerance or best.value == 0.0 or lost > MOST_LOST:
            break
        part = _next(low, high, tolerance, halve=k % 3 == 2)
        if lost:
            # Newton's method fails very near another branch only.
            part = low.part + ASIDE[lost % len(ASIDE)] * (high.part - low.part)
        try:
            sample = at(part)
        except PercussError:
            lost += 1
            continue
        if changes_sign(low.value, sample.value):
            high = sample
        else:
            low = sample
        if abs(sample.value) <= abs(best.value):
            best = sample
    return low, high, best, lost > MOST_LOST


def _next(low: Sample, high: Sample, tolerance: float, *, halve: bool) -> float:
    """Return the next part: on the secant, a tolerance off the ends, or in the middle."""
    width = high.part - low.part
    fraction = low.value / (low.value - high.value)
    if halve or not 0.0 <= fraction <= 1.0:
        return low.part + 0.5 * width
    # At a distance from the ends, so that the other end comes near, too.
    least = min(0.5 * width, 0.5 * tolerance)
    return min(max(low.part + fraction * width, low.part + least), high.part - least)
