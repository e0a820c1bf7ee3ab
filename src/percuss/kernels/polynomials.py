"""Roots and minima of the polynomials that stand for a motion on one step of a search."""

from __future__ import annotations

import math

from percuss.kernels.compile import formula, kernel

# Steps to the root of a quintic: two leave what the motion departs from it.
GUESSES = 2


@kernel
def cubic_minimum(y: float, v: float, y1: float, v1: float) -> float:
    """Return the least value on [0, 1] of the cubic with these end values and slopes."""
    square = 3.0 * (y1 - y) - 2.0 * v - v1
    cube = v + v1 - 2.0 * (y1 - y)
    least = min(y, y1)
    root = square * square - 3.0 * cube * v
    if root > 0.0:
        # Of both turning points the one with upward curvature, in the form that does not cancel.
        part = -v / (square + math.sqrt(root)) if square > 0.0 else 1.0
        if square <= 0.0 and cube != 0.0:
            part = (math.sqrt(root) - square) / (3.0 * cube)
        if 0.0 < part < 1.0:
            least = min(least, y + part * (v + part * (square + cube * part)))
    return least


@formula
def quintic_root(ends: tuple[float, float, float], ends1: tuple[float, float, float]) -> float:
    """Return about where in (0, 1) the quintic with these values and derivatives falls to zero.

    It begins above zero, or at zero and rising, and ends below.
    """
    c0, c1, twice = ends
    c2 = 0.5 * twice
    value = ends1[0] - c0 - c1 - c2
    slope = ends1[1] - c1 - twice
    curve = 0.5 * (ends1[2] - twice)
    c3 = 10.0 * value - 4.0 * slope + curve
    c4 = -15.0 * value + 7.0 * slope - 2.0 * curve
    c5 = 6.0 * value - 3.0 * slope + curve
    # From where the chord meets zero; on the first step from a wall, that of the quotient by time.
    high = c0 if c0 > 0.0 else c1
    fall = high - ends1[0]
    part = high / fall if high > 0.0 and fall > high else 0.5
    for _ in range(GUESSES):
        # Halley's method, and half the way to where the root lies if that leaves the step.
        square = part * part
        value = (c0 + part * c1) + square * ((c2 + part * c3) + square * (c4 + part * c5))
        slope = (c1 + part * twice) + square * ((3.0 * c3 + part * 4.0 * c4) + square * 5.0 * c5)
        bend = (twice + part * 6.0 * c3) + square * (12.0 * c4 + part * 20.0 * c5)
        below = slope * slope - 0.5 * value * bend
        better = part - value * slope / below if below != 0.0 else -1.0
        half = 0.5 * (part + 1.0) if value > 0.0 else 0.5 * part
        part = better if 0.0 < better < 1.0 else half
    return part
