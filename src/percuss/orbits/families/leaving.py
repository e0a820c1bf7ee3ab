"""Where the orbits of a family meet a soft stop no more, as an end of a stretch of it.

A velocity of either sign into a soft stop is one motion, once in it after no time and once before:
the family turns at the graze and comes back formally. What lies before the graze is looked for
between it and the last point that meets the stop.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.numerics import norm
from percuss.orbits.families.conditions import Point, condition, conditions_of, leaves_soft_stop
from percuss.orbits.families.family import Family
from percuss.orbits.families.locating import Zero, changes_sign, find_zero

__all__ = ["until_left"]

Floats = NDArray[np.float64]

# Soft stops that are left at parts of a chord nearer than this are left together.
TOGETHER = 1e-6
# Length of a step that tells how the parameter comes to the graze, and what stands for that way.
BEFORE, TINY = 1e-5, 1e-300
# Distances to a stop below this part of the scale are those of the touch.
TOUCHED = 1e-9


def until_left(family: Family, a: Point, b: Point) -> tuple[Point, list[tuple[str, Zero]]]:
    """Return the end of the stretch on which all stops are met, and the zeros at the graze there.

    Without a soft stop that is left between the two points the end is the second of them.
    """
    found = []
    for name, before in a.conditions.items():
        if leaves_soft_stop(family, name) and changes_sign(
            before, b.conditions.get(name, math.nan)
        ):
            # Where two stops are left together each may be met or formally not: families cross.
            zero = find_zero(family, a, b, condition(family, name))
            if zero is not None:
                found.append((name, zero))
    if not found:
        return b, []
    found.sort(key=lambda it: it[1].part)
    first = found[0][1]
    met = [(name, zero) for name, zero in found if zero.part - first.part < TOGETHER]
    conditions = conditions_of(family, first.orbit)
    for name, _ in met:
        conditions[name] = 0.0
    if abs(conditions["passage"]) < TOUCHED * float(family.rows[0]):
        del conditions["passage"]
    tangent = _coming(family, first, b.z - a.z)
    end = Point(first.z, tangent, first.orbit, conditions, family)
    return end, [(name, dataclasses.replace(zero, part=1.0)) for name, zero in met]


def _coming(family: Family, zero: Zero, chord: Floats) -> Floats:
    """Return the unit direction of the chord, with the sign of the parameter's way to the graze."""
    along = chord / norm(chord)
    try:
        before = family.corrected(zero.z - BEFORE * along, along, beside_others=True)
        way = float(zero.z[-1] - before[-1])
    except PercussError:
        way = 0.0
    tangent = along.copy()
    tangent[-1] = math.copysign(TINY, way) if way else 0.0
    return np.asarray(tangent)
