"""The origin of a family: where it bifurcates from a simpler one.

Along doubled orbits, or one of a mirrored pair, the origin is a turn of the parameter with two
small singular values, which the equations locate to half of the digits only. Along the simpler
orbits it is the simple zero of a multiplier's condition.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.branch_equations import BranchEquations, OrbitEquations
from percuss.orbits.bifurcations.multiple_covers import primitive_orbit
from percuss.orbits.continuation.locate import Zero, locate_near
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import is_symmetric_system

Origin: TypeAlias = Literal["doubled", "mirrored"]

# Why a family ends at its origin, and what the origin of a mirrored one is.
ENDS: dict[Origin, str] = {
    "doubled": "the orbit is the two-fold cover of a shorter one",
    "mirrored": "the orbit is symmetric; beyond it lies the mirrored family",
}
MIRRORS = "the orbit is symmetric; two that mirror each other start"

# Largest difference of the halves of an orbit at the origin of its family, where it grows as a
# square root.
ONE_AND_THE_SAME = 1e-4
# Differences below this are rounding.
ROUNDING = 1e-9


def origin_of(family: BranchEquations, orbit: PeriodicOrbit) -> Origin | None:
    """Return which simpler orbit one equals, to the digits of a turn of the parameter."""
    if orbit.itinerary.halves_differ() < ONE_AND_THE_SAME:
        return "doubled"
    half = family.n // 2
    if family.n % 2 or not half or orbit.n_periods % 2 == 0:
        return None
    scaled = family.unknowns_of(orbit)
    difference = np.abs(_symmetric(family, scaled) - scaled).max()
    return "mirrored" if difference < ONE_AND_THE_SAME else None


def _origin_between(a: Point[BranchEquations], b: Point[BranchEquations]) -> Origin | None:
    """Return which simpler orbit the family passes between two points, None for none.

    Beyond it come the same orbits, a period later or mirrored: their difference from the simpler
    one changes its sign.
    """
    parts = _difference_at(a), _difference_at(b)
    if parts[0] is None or parts[1] is None or dot(parts[0], parts[1]) >= 0.0:
        return None
    return "mirrored" if a.orbit.n_periods % 2 else "doubled"


def _difference_at(point: Point[BranchEquations]) -> Floats | None:
    return difference_from_simpler(point.problem, point.z[:-1], point.orbit)


def difference_from_simpler(
    family: OrbitEquations, scaled: Floats, orbit: PeriodicOrbit
) -> Floats | None:
    """Return the difference of an orbit from the simpler one of which it may originate.

    Of the durations and velocities among its scaled unknowns; None where there is no simpler one,
    or it is the simpler one.
    """
    n = family.n
    if n == 0 or n % 2:
        return None
    if orbit.n_periods % 2:
        difference = (scaled - _symmetric(family, scaled))[1:]
        exists = is_symmetric_system(*orbit.system)
    else:
        halves = scaled[1:].reshape(2, 2, -1)
        difference = (halves[:, 0] - halves[:, 1]).ravel()
        exists = orbit.itinerary.halves_differ() < np.inf
    return difference if exists and np.abs(difference).max() > ROUNDING else None


def origin_passed(a: Point[BranchEquations], b: Point[BranchEquations]) -> Zero | None:
    """Return the origin of a family whose parameter turns between two points."""
    origin = _origin_between(a, b)
    one, other = _difference_at(a), _difference_at(b)
    if origin is None or one is None or other is None:
        return None
    part = norm(one) / norm(one - other)
    z = a.z + part * (b.z - a.z)
    family = a.problem
    rough = Zero(part, z, family.solution(z), (a.z, b.z), goes_through=False)
    return located_origin(family, rough, origin)


def _symmetric(family: OrbitEquations, scaled: Floats) -> Floats:
    """Return scaled unknowns with the second half of the orbit mirroring the first."""
    return Itinerary.of_vector(family.events, scaled, family.n_periods).mirrored_mean().vector


def located_origin(family: BranchEquations, zero: Zero, origin: Origin) -> Zero | None:
    """Return where the simpler orbit has the multiplier, None if it is not found."""
    try:
        if origin == "doubled":
            simple = primitive_orbit(zero.orbit)
            simpler = BranchEquations(simple, family.path, family.low, family.high)
            start = simpler.start(simple, family.value(zero.z))
            test = partial(simpler.test, name="multiplier -1")
            along = along_parameter(len(start))
            origin_zero = locate_near(simpler, start, along, test, near_others=False)
        else:
            simpler = family
            start = np.append(_symmetric(family, zero.z[:-1]), zero.z[-1])
            test = partial(family.test, name="multiplier 1")
            origin_zero = locate_near(family, start, along_parameter(len(start)), test)
        if origin_zero is None:
            return None
        lift = _lift(simpler, family, origin)
        z, ends = lift(origin_zero.z), (lift(origin_zero.ends[0]), lift(origin_zero.ends[1]))
        orbit = family.solution(z)
        return dataclasses.replace(origin_zero, part=zero.part, z=z, orbit=orbit, ends=ends)
    except PercussError:
        return None


def _lift(
    simpler: BranchEquations, family: BranchEquations, origin: Origin
) -> Callable[[Floats], Floats]:
    """Return the map of points of the simpler family to those of the other."""

    def twice(z: Floats) -> Floats:
        primitive = Itinerary.of_vector(simpler.events, z[:-1] * simpler.scale, simpler.n_periods)
        return np.append(primitive.repeated(2).vector / family.scale, z[-1])

    def symmetric(z: Floats) -> Floats:
        return np.append(_symmetric(family, z[:-1]), z[-1])

    return twice if origin == "doubled" else symmetric
