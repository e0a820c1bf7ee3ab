"""The functions of an orbit that special points zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.orbits.families.family import Family
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Point", "condition", "conditions_of", "leaves_soft_stop"]

Floats = NDArray[np.float64]

# Determinants this near to 1 are those of conservative motion.
CONSERVATIVE = 1e-12


@dataclass(frozen=True, slots=True)
class Point:
    """A point of a family with its tangent, its orbit and the functions that special points zero."""

    z: Floats
    tangent: Floats
    orbit: PeriodicOrbit
    conditions: dict[str, float]
    family: Family | None = None


def conditions_of(family: Family, orbit: PeriodicOrbit) -> dict[str, float]:
    """Return the functions whose zeros are special points, as far as the orbit alone tells them.

    Those of the multipliers carry the product of the impact velocities: the monodromy matrix has
    that in its denominator, and so they are smooth through a graze.
    """
    found: dict[str, float] = {"passage": min(orbit.grazing_margin, 1e300)}
    into = family.into_stops(orbit)
    for k, speed in enumerate(into):
        found[f"velocity {k}"] = float(speed)
    if family.n == 0:
        return found
    speeds = [v for (i, _, _), v in zip(family.ways, into, strict=True) if family.walls[i]]
    weight = float(np.prod(speeds))
    trace = float(np.trace(orbit.monodromy))
    determinant = float(np.prod(orbit.multipliers).real)
    found["one"] = weight * (1.0 - trace + determinant)
    found["minus one"] = weight * (1.0 + trace + determinant)
    if abs(determinant - 1.0) < CONSERVATIVE:
        found["third"], found["fourth"] = weight * (1.0 + trace), weight * trace
    return found


def leaves_soft_stop(family: Family, name: str) -> bool:
    """Tell whether a condition is the velocity into a soft stop: without it the stop is not met."""
    return name.startswith("velocity") and not family.walls[family.ways[int(name.split()[1])][0]]


def condition(family: Family, name: str) -> Callable[[Floats, PeriodicOrbit], float]:
    """Return one of the conditions as a function of a point and its orbit."""
    return lambda _, orbit: conditions_of(family, orbit)[name]
