"""Where a family starts from a simpler one: its parameter turns, and the simpler one tells where.

Along a doubled orbit, or one of a mirrored pair, the start looks like a fold at which the equations
hold two directions weakly, and so they tell it to half of the digits. Along the simpler orbit it is
the simple zero of a multiplier's condition.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.numerics import dot, norm
from percuss.orbits.families.conditions import Point, condition, conditions_of
from percuss.orbits.families.family import Family
from percuss.orbits.families.locating import Zero, changes_sign, find_zero
from percuss.orbits.families.rounds import doubled_unknowns, halves_differ, once_round
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = ["Birth", "birth_of", "birth_passed", "located_birth"]

Floats = NDArray[np.float64]
Birth: TypeAlias = Literal["doubled", "mirrored"]

# Halves of an orbit where its family starts: they part with a square root.
ONE_AND_THE_SAME = 1e-4
# What is rounding in them.
NOT_APART = 1e-9
# How far from the start, in scaled parameter, the simpler orbit is looked at.
NEAR, FAR, FARTHER = 1e-7, 1e-2, 4.0


def birth_of(family: Family, orbit: PeriodicOrbit) -> Birth | None:
    """Tell what simpler orbit one is to the digits that a turning point has, None for none."""
    if halves_differ(orbit) < ONE_AND_THE_SAME:
        return "doubled"
    half = family.n // 2
    if family.n % 2 or not half or orbit.n_periods % 2 == 0:
        return None
    symmetric = _symmetric(family, orbit._unknowns / family.scale)
    apart = np.abs(symmetric - orbit._unknowns / family.scale).max()
    return "mirrored" if apart < ONE_AND_THE_SAME else None


def _birth_between(family: Family, a: Point, b: Point) -> Birth | None:
    """Tell what simpler orbit the family passes between two points, None for none.

    Beyond it come the same orbits, a period later or mirrored: what tells them from the simpler one
    has turned round.
    """
    parts = _parting(family, a), _parting(family, b)
    if parts[0] is None or parts[1] is None or dot(parts[0], parts[1]) >= 0.0:
        return None
    return "mirrored" if a.orbit.n_periods % 2 else "doubled"


def _parting(family: Family, point: Point) -> Floats | None:
    """Return what tells an orbit from the simpler one that its family may start from."""
    n, z = family.n, point.z
    if n == 0 or n % 2:
        return None
    if point.orbit.n_periods % 2:
        parting = z[1:-1] - _symmetric(family, z[:-1])[1:]
        exists = is_symmetric_system(*family.system(family.value(z)))
    else:
        halves = z[1:-1].reshape(2, 2, -1)
        parting = (halves[:, 0] - halves[:, 1]).ravel()
        exists = halves_differ(point.orbit) < np.inf
    return parting if exists and np.abs(parting).max() > NOT_APART else None


def birth_passed(family: Family, a: Point, b: Point) -> Zero | None:
    """Return where a family that turns between two points starts from a simpler one."""
    birth = _birth_between(family, a, b)
    one, other = _parting(family, a), _parting(family, b)
    if birth is None or one is None or other is None:
        return None
    part = norm(one) / norm(one - other)
    z = a.z + part * (b.z - a.z)
    rough = Zero(part, z, family.orbit(z), (a.z, b.z), goes_through=False)
    return located_birth(family, rough, birth)


def _symmetric(family: Family, scaled: Floats) -> Floats:
    """Return scaled unknowns with the second half of the orbit mirroring the first."""
    n = family.n
    lasting, speeds = scaled[1 : 1 + n].reshape(2, -1), scaled[1 + n :].reshape(2, -1)
    lasting, speeds = lasting.mean(axis=0), 0.5 * (speeds[0] - speeds[1])
    return np.concatenate([scaled[:1], lasting, lasting, speeds, -speeds])


def located_birth(family: Family, zero: Zero, birth: Birth) -> Zero | None:
    """Return where the simpler orbit has the multiplier, None if it is not found there."""
    try:
        if birth == "doubled":
            simple = once_round(zero.orbit)
            simpler = Family(simple, family.path, family.low, family.high)
            start = simpler.start(simple, family.value(zero.z))
            found = _found(simpler, start, "minus one")
        else:
            simpler = family
            start = np.append(_symmetric(family, zero.z[:-1]), zero.z[-1])
            found = _found(family, start, "one")
        if found is None:
            return None
        lift = _lift(simpler, family, birth)
        z = lift(found.z)
        ends = lift(found.ends[0]), lift(found.ends[1])
        return dataclasses.replace(found, part=zero.part, z=z, orbit=family.orbit(z), ends=ends)
    except PercussError:
        return None


def _lift(simpler: Family, family: Family, birth: Birth) -> Callable[[Floats], Floats]:
    """Return what makes a point of the simpler family one of the other."""

    def twice(z: Floats) -> Floats:
        return np.append(doubled_unknowns(z[:-1] * simpler.scale) / family.scale, z[-1])

    def symmetric(z: Floats) -> Floats:
        return np.append(_symmetric(family, z[:-1]), z[-1])

    return twice if birth == "doubled" else symmetric


def _found(family: Family, start: Floats, name: str) -> Zero | None:
    """Return the zero of a condition along the parameter, near a solution."""
    held = np.append(np.zeros(len(start) - 1), 1.0)
    apart = NEAR
    while apart <= FAR:
        ends = []
        for way in (-1.0, 1.0):
            z = family.corrected(start + way * apart * held, held)
            orbit = family.orbit(z)
            ends.append(Point(z, held, orbit, conditions_of(family, orbit)))
        a, b = ends
        if changes_sign(a.conditions[name], b.conditions[name]):
            return find_zero(family, a, b, condition(family, name), beside_others=name == "one")
        apart *= FARTHER
    return None
