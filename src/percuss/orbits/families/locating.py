"""Zeros on a branch between two of its points."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, PercussError
from percuss.numerics import norm
from percuss.orbits.families.conditions import Point
from percuss.orbits.families.family import Family
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Zero", "changes_sign", "find_zero"]

Floats = NDArray[np.float64]

# A bracket in scaled arclength that is as good as a point.
CLOSE = 1e-12
MOST_STEPS = 80
# How often Newton's method may find nothing, at which parts of the bracket it is tried then, and
# how long a bracket may be that is given nevertheless, as a part of the chord.
MOST_LOST, ASIDE, LOST = 12, (0.5, 0.25, 0.75, 0.4, 0.6, 0.1, 0.9), 1e-2


@dataclass(frozen=True, slots=True)
class Zero:
    """A zero on the chord between two points; `part` is how far along it lies."""

    part: float
    z: Floats
    orbit: PeriodicOrbit
    ends: tuple[Floats, Floats]
    goes_through: bool


def changes_sign(before: float, after: float) -> bool:
    """Tell whether a condition reaches or passes zero from one point to the next."""
    return before != 0.0 and np.sign(before) * np.sign(after) <= 0.0


def find_zero(
    family: Family,
    a: Point,
    b: Point,
    test: Callable[[Floats, PeriodicOrbit], float],
    *,
    beside_others: bool = True,
) -> Zero | None:
    """Return a zero of a function on the family between two points, None if it gets lost.

    ``beside_others`` is for zeros at which another family may cross; the equations then hold one
    direction more weakly, and solving them so takes longer.
    """
    chord = b.z - a.z
    length = norm(chord)
    normal = chord / length
    tolerance = CLOSE / length

    def at(part: float) -> tuple[float, Floats, PeriodicOrbit]:
        guess = a.z + part * chord
        try:
            z = family.corrected(guess, normal, beside_others=beside_others)
        except ConvergenceError:
            z = family.corrected(guess, normal, beside_others=not beside_others)
        if norm(z - guess) > length:
            raise ConvergenceError("Newton's method leaves the chord", z, math.nan, "look aside")
        orbit = family.orbit(z)
        return test(z, orbit), z, orbit

    low, high = (0.0, test(a.z, a.orbit), a.z), (1.0, test(b.z, b.orbit), b.z)
    best, orbit = (high, b.orbit) if abs(high[1]) < abs(low[1]) else (low, a.orbit)
    size = abs(low[1]) + abs(high[1])
    lost = 0
    for k in range(MOST_STEPS):
        if high[0] - low[0] <= tolerance or best[1] == 0.0 or lost > MOST_LOST:
            break
        part = _next(low, high, tolerance, halve=k % 3 == 2)
        if lost:
            # Newton's method gets lost very near to another family, and not beside it.
            part = low[0] + ASIDE[lost % len(ASIDE)] * (high[0] - low[0])
        try:
            value, z, there = at(part)
        except PercussError:
            lost += 1
            continue
        if changes_sign(low[1], value):
            high = part, value, z
        else:
            low = part, value, z
        if abs(value) <= abs(best[1]):
            best, orbit = (part, value, z), there
    if lost > MOST_LOST and high[0] - low[0] > LOST:
        return None
    ends = (best[2], best[2]) if best[1] == 0.0 else (low[2], high[2])
    through = abs(low[1]) + abs(high[1]) <= 1e-4 * size or best[1] == 0.0
    return Zero(best[0], best[2], orbit, ends, through)


def _next(
    low: tuple[float, float, Floats],
    high: tuple[float, float, Floats],
    tolerance: float,
    *,
    halve: bool,
) -> float:
    """Return where to look next: on the secant, a tolerance off the ends, or in the middle."""
    width = high[0] - low[0]
    fraction = low[1] / (low[1] - high[1])
    if halve or not 0.0 <= fraction <= 1.0:
        return low[0] + 0.5 * width
    # From an end into the bracket: so that the other end comes near, too.
    room = min(0.5 * width, 0.5 * tolerance)
    return min(max(low[0] + fraction * width, low[0] + room), high[0] - room)
