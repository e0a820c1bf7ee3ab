"""Where the orbits of a branch are born, die, double or touch a stop."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.orbits.conditions import Point, conditions_of, leaves_soft_stop
from percuss.orbits.family import Family
from percuss.orbits.locating import Zero, changes_sign, find_zero
from percuss.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["Kind", "SpecialPoint", "goes_round_twice", "special_points_between"]

Floats = NDArray[np.float64]
Kind: TypeAlias = Literal[
    "fold", "period_doubling", "symmetry_breaking", "branch_point", "grazing", "strong_resonance"
]

# A bracket in the parameter that is a location, as a part of it.
LOCATED = 1e-10
# Velocities below this part of the scale are too small to tell a passage beside an impact.
SLOW = 1e-6
# Multipliers that the conditions bring to the edge of stability, and how near they come.
EDGES, ON_EDGE = {"one": 1.0, "minus one": -1.0}, 1e-3
# Special points nearer than this are one.
SAME = 1e-9
# Of the halves of an orbit that mirror each other.
MIRRORED = 1e-6
# Of the halves of a doubled orbit where it comes from: they part with a square root.
ONE_AND_THE_SAME = 1e-4


@dataclass(frozen=True, slots=True)
class SpecialPoint:
    """A point of a branch at which the orbits change in kind.

    Attributes
    ----------
    kind
        "fold" (two orbits meet and end), "period_doubling" (a multiplier of -1),
        "symmetry_breaking" (a multiplier of 1, of an orbit whose halves mirror each other),
        "branch_point" (a multiplier of 1 otherwise), "grazing" (an impact of no velocity, or a
        turning point that touches a stop), "strong_resonance" (of a conservative family, trace
        -1 or 0).
    path, value
        The parameter and its value there.
    interval
        Values of the parameter between which it lies; at a fold both lie on one side of it.
    status
        "located" if the interval is below 1e-10 of the value, or of 1 for smaller ones, and what
        changes sign goes through zero; otherwise "bracketed".
    orbit
        The orbit there.
    row
        Its row in the branch.
    detail
        What happens there, in words.
    codimension
        How many conditions it fulfils: 1.
    """

    kind: Kind
    path: str
    value: float
    interval: tuple[float, float]
    status: Literal["located", "bracketed"]
    orbit: PeriodicOrbit = field(repr=False)
    row: int
    detail: str
    codimension: int = 1


def special_points_between(
    family: Family, a: Point, b: Point
) -> Iterator[tuple[SpecialPoint, Point]]:
    """Return the special points between two neighbours on a branch, in order, with row -1."""
    changed = [
        name
        for name in a.conditions
        if changes_sign(a.conditions[name], b.conditions.get(name, math.nan))
    ]
    turns = a.tangent[-1] * b.tangent[-1] < 0.0
    zeros = []
    for name in changed:
        zero = find_zero(family, a, b, _test(family, name))
        if zero is not None:
            zeros.append((name, zero))
    if turns and "one" not in changed:
        zero = find_zero(family, a, b, lambda z, _: float(family.tangent(z, a.tangent)[-1]))
        if zero is not None:
            zeros.append(("fold", zero))
    yield from _told(family, a, sorted(zeros, key=lambda found: found[1].part), turns=turns)


def _told(
    family: Family, a: Point, zeros: list[tuple[str, Zero]], *, turns: bool
) -> Iterator[tuple[SpecialPoint, Point]]:
    """Return zeros in order as special points, those of one kind at one place as one."""
    touched = any(name.startswith("velocity") for name, _ in zeros)
    leaves = any(leaves_soft_stop(family, name) for name, _ in zeros)
    # The passage of a formal orbit vanishes with the velocity of the impact beside it; and a
    # soft stop that is left after no time turns the branch, as a velocity of either sign is one.
    hidden = {"passage", "one", "fold", "minus one"} if leaves else {"passage"}
    last: tuple[SpecialPoint, Point] | None = None
    for name, zero in zeros:
        if name in hidden and touched and _is_slow(family, zero.orbit):
            continue
        if (
            name in EDGES
            and not (turns and name == "one")
            and not _has_multiplier(zero, EDGES[name])
        ):
            continue
        kind, detail = _meaning(family, name, zero.orbit, turns=turns)
        if last is not None and last[0].kind == kind and _is_at(zero, last[1]):
            last = dataclasses.replace(last[0], detail=f"{last[0].detail}, and {detail}"), last[1]
            continue
        if last is not None:
            yield last
        tangent = family.tangent(zero.z, a.tangent)
        there = Point(zero.z, tangent, zero.orbit, conditions_of(family, zero.orbit))
        last = _special(family, kind, detail, zero), there
        if leaves_soft_stop(family, name):
            break
    if last is not None:
        yield last


def _has_multiplier(zero: Zero, edge: float) -> bool:
    """Tell a multiplier that comes to the edge from an impact velocity that comes to zero."""
    return not zero.goes_through or bool(np.abs(zero.orbit.multipliers - edge).min() < ON_EDGE)


def _is_at(zero: Zero, other: Point) -> bool:
    return float(np.linalg.norm(zero.z - other.z)) < SAME


def _is_slow(family: Family, orbit: PeriodicOrbit) -> bool:
    return bool(np.abs(family.into_stops(orbit)).min() < SLOW * family.scale[-1])


def _test(family: Family, name: str) -> Callable[[Floats, PeriodicOrbit], float]:
    return lambda _, orbit: conditions_of(family, orbit)[name]


def _special(family: Family, kind: Kind, detail: str, zero: Zero) -> SpecialPoint:
    low, high = sorted(family.value(z) for z in zero.ends)
    value = family.value(zero.z)
    exact = zero.goes_through and high - low <= LOCATED * max(1.0, abs(value))
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    return SpecialPoint(kind, family.path, value, (low, high), status, zero.orbit, -1, detail)


def _meaning(family: Family, name: str, orbit: PeriodicOrbit, *, turns: bool) -> tuple[Kind, str]:
    if name.startswith("velocity"):
        stop = family.ways[int(name.split()[1])][1]
        return "grazing", f"an impact on stop {stop} has no velocity"
    if name == "passage":
        return "grazing", "a turning point between two events touches a stop"
    if name == "minus one":
        return "period_doubling", "a multiplier is -1"
    if name == "third":
        return "strong_resonance", "the multipliers are third roots of 1"
    if name == "fourth":
        return "strong_resonance", "the multipliers are fourth roots of 1"
    if turns and goes_round_twice(family, orbit):
        return "period_doubling", "the orbit is a shorter one gone round twice, which doubles here"
    if turns:
        return "fold", "two orbits meet and end"
    if _is_symmetric(family, orbit):
        return "symmetry_breaking", "a multiplier of an orbit with mirrored halves is 1"
    return "branch_point", "a multiplier is 1, and the parameter does not turn"


def goes_round_twice(family: Family, orbit: PeriodicOrbit) -> bool:
    """Tell whether an orbit is a shorter one: there the shorter one doubles its period."""
    if family.n_periods % 2:
        return False
    return _halves_differ(family, orbit, 1.0) < ONE_AND_THE_SAME


def _is_symmetric(family: Family, orbit: PeriodicOrbit) -> bool:
    return _halves_differ(family, orbit, -1.0) < MIRRORED


def _halves_differ(family: Family, orbit: PeriodicOrbit, sign: float) -> float:
    """Return by how much the halves of an orbit differ, the second one mirrored by -1."""
    n = family.n
    if n == 0 or n % 2:
        return math.inf
    scaled = orbit._unknowns[1:] / family.scale[1:]
    half = n // 2
    lasting, speeds = scaled[:n], scaled[n:]
    apart = np.append(lasting[:half] - lasting[half:], speeds[:half] - sign * speeds[half:])
    return float(np.abs(apart).max())
