"""Zeros on a curve between two of its points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.numerics import norm
from percuss.orbits.curves.curve_equations import CurveEquations
from percuss.orbits.families.conditions import Point
from percuss.orbits.families.locating import Zero, changes_sign

__all__ = ["find_curve_zero"]

Floats = NDArray[np.float64]

# A bracket in scaled arclength that is as good as a point: the points themselves are known to
# some 1e-13.
CLOSE = 1e-11
MOST_STEPS = 60
# What is left of a function at a zero that it goes through, and where it was looked for in vain.
LEFT, LOST = 1e-4, 0.05
# Where else in the bracket to look, where the equations hardly hold.
ELSEWHERE = (0.5, 0.8, 0.2)


def find_curve_zero(equations: CurveEquations, a: Point, b: Point, name: str) -> Zero | None:
    """Return the zero of a condition between two points, by the Illinois method.

    Parameters
    ----------
    equations
        Those of the curve, settled at a point nearby.
    a, b
        Points at which the condition has opposite signs, or the second of which is a zero.
    name
        The condition.

    Returns
    -------
    Zero or None
        None if it gets lost.
    """
    chord = b.z - a.z
    length = norm(chord)
    low, high = (0.0, a.conditions[name], a.z), (1.0, b.conditions[name], b.z)
    size = abs(low[1]) + abs(high[1])
    best = high if abs(high[1]) < abs(low[1]) else low
    # The values that the secant is drawn through: that of an end which stays is halved.
    f_low, f_high, last = low[1], high[1], 0
    for _ in range(MOST_STEPS):
        width = high[0] - low[0]
        if width * length <= CLOSE:
            break
        secant = min(max(f_low / (f_low - f_high), 1e-3), 1.0 - 1e-3)
        if width * length < 1e3 * CLOSE or f_high == 0.0:
            secant = 0.5
        tried = _first_found(
            equations, (a.z, chord), [low[0] + part * width for part in (secant, *ELSEWHERE)]
        )
        if tried is None:
            break
        part, z = tried
        value = equations.condition(z, name)
        if changes_sign(low[1], value):
            high, f_high = (part, value, z), value
            f_low, last = (0.5 * f_low if last == 1 else f_low), 1
        else:
            low, f_low = (part, value, z), value
            f_high, last = (0.5 * f_high if last == -1 else f_high), -1
        if abs(value) <= abs(best[1]):
            best = part, value, z
    if high[0] - low[0] > LOST:
        return None
    through = abs(low[1]) + abs(high[1]) <= LEFT * size
    return Zero(best[0], best[2], equations.told(best[2])[0], (low[2], high[2]), through)


def _first_found(
    equations: CurveEquations, line: tuple[Floats, Floats], parts: list[float]
) -> tuple[float, Floats] | None:
    """Return the first of some places on a chord over which a point of the curve is found."""
    start, chord = line
    for part in parts:
        try:
            return part, equations.corrected(start + part * chord, chord / norm(chord))
        except PercussError:
            continue
    return None
