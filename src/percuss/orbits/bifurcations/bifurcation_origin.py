"""Where a family starts from a simpler one: its parameter turns, and the simpler one tells where.

Along a doubled orbit, or one of a mirrored pair, the start looks like a fold at which the equations
hold two directions weakly, and so they tell it to half of the digits. Along the simpler orbit it is
the simple zero of a multiplier's condition.
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
from percuss.orbits.bifurcations.family import Family
from percuss.orbits.bifurcations.n_fold import primitive_orbit
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = ["Origin", "located_origin", "origin_of", "origin_passed"]

Origin: TypeAlias = Literal["doubled", "mirrored"]

# Halves of an orbit where its family starts: they part with a square root.
ONE_AND_THE_SAME = 1e-4
# What is rounding in them.
NOT_APART = 1e-9
# How far from the start, in scaled parameter, the simpler orbit is looked at.
NEAR, FAR, FARTHER = 1e-7, 1e-2, 4.0


def origin_of(family: Family, orbit: PeriodicOrbit) -> Origin | None:
    """Tell what simpler orbit one is to the digits that a turning point has, None for none."""
    if orbit.itinerary.halves_differ() < ONE_AND_THE_SAME:
        return "doubled"
    half = family.n // 2
    if family.n % 2 or not half or orbit.n_periods % 2 == 0:
        return None
    scaled = family.unknowns_of(orbit)
    apart = np.abs(_symmetric(family, scaled) - scaled).max()
    return "mirrored" if apart < ONE_AND_THE_SAME else None


def _origin_between(a: Point[Family], b: Point[Family]) -> Origin | None:
    """Tell what simpler orbit the family passes between two points, None for none.

    Beyond it come the same orbits, a period later or mirrored: what tells them from the simpler one
    has turned round.
    """
    parts = _parting(a), _parting(b)
    if parts[0] is None or parts[1] is None or dot(parts[0], parts[1]) >= 0.0:
        return None
    return "mirrored" if a.orbit.n_periods % 2 else "doubled"


def _parting(point: Point[Family]) -> Floats | None:
    """Return what tells an orbit from the simpler one that its family may start from."""
    family, z = point.problem, point.z
    n = family.n
    if n == 0 or n % 2:
        return None
    if point.orbit.n_periods % 2:
        parting = z[1:-1] - _symmetric(family, z[:-1])[1:]
        exists = is_symmetric_system(*family.system(family.value(z)))
    else:
        halves = z[1:-1].reshape(2, 2, -1)
        parting = (halves[:, 0] - halves[:, 1]).ravel()
        exists = point.orbit.itinerary.halves_differ() < np.inf
    return parting if exists and np.abs(parting).max() > NOT_APART else None


def origin_passed(a: Point[Family], b: Point[Family]) -> Zero | None:
    """Return where a family that turns between two points starts from a simpler one."""
    origin = _origin_between(a, b)
    one, other = _parting(a), _parting(b)
    if origin is None or one is None or other is None:
        return None
    part = norm(one) / norm(one - other)
    z = a.z + part * (b.z - a.z)
    family = a.problem
    rough = Zero(part, z, family.solution(z), (a.z, b.z), goes_through=False)
    return located_origin(family, rough, origin)


def _symmetric(family: Family, scaled: Floats) -> Floats:
    """Return scaled unknowns with the second half of the orbit mirroring the first."""
    return Itinerary.of_vector(family.chain, scaled, family.n_periods).mirrored_mean().vector


def located_origin(family: Family, zero: Zero, origin: Origin) -> Zero | None:
    """Return where the simpler orbit has the multiplier, None if it is not found there."""
    try:
        if origin == "doubled":
            simple = primitive_orbit(zero.orbit)
            simpler = Family(simple, family.path, family.low, family.high)
            start = simpler.start(simple, family.value(zero.z))
            found = _found(simpler, start, "minus one")
        else:
            simpler = family
            start = np.append(_symmetric(family, zero.z[:-1]), zero.z[-1])
            found = _found(family, start, "one")
        if found is None:
            return None
        lift = _lift(simpler, family, origin)
        z = lift(found.z)
        ends = lift(found.ends[0]), lift(found.ends[1])
        return dataclasses.replace(found, part=zero.part, z=z, orbit=family.solution(z), ends=ends)
    except PercussError:
        return None


def _lift(simpler: Family, family: Family, origin: Origin) -> Callable[[Floats], Floats]:
    """Return what makes a point of the simpler family one of the other."""

    def twice(z: Floats) -> Floats:
        once = Itinerary.of_vector(simpler.chain, z[:-1] * simpler.scale, simpler.n_periods)
        return np.append(once.repeated(2).vector / family.scale, z[-1])

    def symmetric(z: Floats) -> Floats:
        return np.append(_symmetric(family, z[:-1]), z[-1])

    return twice if origin == "doubled" else symmetric


def _found(family: Family, start: Floats, name: str) -> Zero | None:
    """Return the zero of a condition along the parameter, near a solution."""
    held = along_parameter(len(start))
    apart = NEAR
    while apart <= FAR:
        ends = []
        for sign in (-1.0, 1.0):
            z = family.corrected(start + sign * apart * held, held)
            orbit = family.solution(z)
            ends.append(Point(z, held, orbit, family.tests(orbit), family))
        a, b = ends
        values = a.tests[name], b.tests[name]
        if changes_sign(*values):
            test = partial(family.test, name=name)
            return locate(a, b, test, values, beside_others=name == "one")
        apart *= FARTHER
    return None
