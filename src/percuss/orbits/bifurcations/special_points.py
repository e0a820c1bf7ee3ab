"""Special points of a branch: folds, period doublings, grazes and others."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.model.exact import as_float
from percuss.numerics import atan2, norm
from percuss.orbits.bifurcations.bifurcation_origin import (
    MIRRORS,
    located_origin,
    origin_of,
    origin_passed,
)
from percuss.orbits.bifurcations.branch_equations import (
    BranchEquations,
    stops_that_are_moved,
)
from percuss.orbits.bifurcations.grazing import GrazeAnalysis, analysed_graze
from percuss.orbits.bifurcations.grazing_contact import accumulates
from percuss.orbits.bifurcations.soft_grazing import until_soft_graze
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.over_period import fastest
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import half_multipliers

SpecialPointKind: TypeAlias = Literal[
    "fold",
    "period_doubling",
    "symmetry_breaking",
    "branch_point",
    "grazing",
    "chatter",
    "corner",
    "strong_resonance",
    "torus",
    "border_collision",
]

# A bracket in the parameter that is a location, as a part of it or of its range.
LOCATED = 1e-10
# Distance from a corner at which its orbit is taken, in scaled parameter.
CORNER = 1e-11
# At velocities below this part of the scale a turning point is the impact next to it.
SLOW = 1e-6
# Multipliers at the zeros of the conditions, and their largest distance from these.
EDGES, ON_EDGE = {"multiplier 1": 1.0, "multiplier -1": -1.0}, 1e-3
# Special points nearer than this are one.
SAME = 1e-9
TWO_FOLD = "the orbit is the two-fold cover of one that doubles here: switch_branch returns it"
LEFT = "a soft stop is left without velocity"
# Depths and durations below this part of the size of a grazing orbit belong to the graze.
GRAZED = 1e-9


@dataclass(frozen=True, slots=True)
class SpecialPoint:
    """A point of a branch at which the orbits change in kind.

    Attributes
    ----------
    kind
        "fold" (two orbits meet and end), "period_doubling" (a multiplier of -1, or, as `detail`
        says, the origin of a branch of doubled orbits),
        "symmetry_breaking" (the multiplier of the map over half a symmetric orbit is -1),
        "branch_point" (a multiplier of 1 otherwise), "grazing" (an impact of no velocity, or a
        turning point that touches a stop), "chatter" (impacts lose their velocity together
        while the force pushes into the wall: they accumulate), "corner" (two stops that are met
        come to lie at one place), "strong_resonance" (of a conservative family, trace -1 or 0),
        "torus" (a complex pair of multipliers crosses the unit circle, Neimark-Sacker: there an
        invariant torus starts; only negative damping makes areas grow), "border_collision" (an
        impact meets a jump of the force: the multipliers jump, and the branch may turn, a nonsmooth
        fold; those of `orbit` are those of one of the two sides).
    path, value
        The parameter and its value there.
    interval
        Values of the parameter between which it lies; at a fold both lie on one side of it.
    status
        "located" if the interval is at most 1e-10 of the value, or of the range of the parameter,
        and the test function goes through zero there without a jump; otherwise "bracketed".
    orbit
        The orbit there.
    row
        Its row in the branch.
    detail
        A description of the point.
    codimension
        Number of conditions: 1.
    tangent
        (n,) array, chord of the branch across the point, by unknowns and parameter; None where
        none is known.
    """

    kind: SpecialPointKind
    path: str
    value: float
    interval: tuple[float, float]
    status: Literal["located", "bracketed"]
    orbit: PeriodicOrbit = field(repr=False)
    row: int
    detail: str
    codimension: int = 1
    tangent: Floats | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        """Return the point in a line."""
        formal = "" if self.admissible else "; formal, the orbit passes through a stop"
        return (
            f"<SpecialPoint: {self.kind} at {self.path} = {self.value:.12g}, {self.status}, "
            f"row {self.row}; {self.detail}{formal}>"
        )

    @property
    def admissible(self) -> bool:
        """Whether the orbit there passes through no stop; grazing it is no penetration."""
        orbit = self.orbit
        if orbit.admissible or self.kind != "grazing":
            return orbit.admissible
        speed = fastest(orbit)
        durations = orbit.itinerary.durations
        deepest = float(orbit.passages.depth.max(initial=0.0))
        shortest = float(durations.min(initial=0.0))
        return deepest <= GRAZED * speed * orbit.period and shortest >= -GRAZED * orbit.period

    @property
    def graze(self) -> GrazeAnalysis | None:
        """The effect of a graze on the motions near it, computed on demand.

        None for other kinds of points, for orbits with sticking, and for orbits that graze several
        stops, but two that mirror each other.
        """
        if self.kind != "grazing" or math.isinf(self.orbit.n_impacts):
            return None
        try:
            return analysed_graze(self.orbit, self.path)
        except PercussError:
            return None


def coincidence_point(
    here: Point[BranchEquations], end: float, *, is_end: bool
) -> tuple[SpecialPoint, Point[BranchEquations]] | None:
    """Return the corner between a point of a family and a value of the parameter, None for none.

    At the corner itself the stops are one, and the equations differ: its orbit is one next to it.
    """
    family = here.problem
    value = family.value(here.z)
    stops = coincident_stops(here.orbit, family.path, value, end)
    if stops is None:
        return None
    at, moved, other = stops
    detail = f"stops {moved} and {other} come to lie at one place"
    point = here
    if not is_end:
        guess = here.z.copy()
        guess[-1] = (at - family.low) / (family.high - family.low) - CORNER * np.sign(at - value)
        z = family.corrected(guess, along_parameter(len(guess)))
        orbit = family.solution(z)
        point = Point(z, here.tangent, orbit, family.tests(orbit), family)
    ends = sorted((family.value(point.z), at))
    exact = ends[1] - ends[0] <= LOCATED * max(family.high - family.low, abs(at)) or not is_end
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    special = SpecialPoint(
        "corner", family.path, at, (ends[0], ends[1]), status, point.orbit, -1, detail
    )
    return special, point


def special_points_between(
    a: Point[BranchEquations], b: Point[BranchEquations]
) -> Iterator[tuple[SpecialPoint, Point[BranchEquations]]]:
    """Return the special points between two neighbours on a branch, in order, with row -1."""
    family = a.problem
    b, zeros = until_soft_graze(a, b)
    changed = [
        name
        for name in a.tests
        if not family.enters_soft_stop(name)
        and changes_sign(a.tests[name], b.tests.get(name, math.nan))
    ]
    turns = a.tangent[-1] * b.tangent[-1] < 0.0
    passed = origin_passed(a, b) if turns else None
    if passed is not None:
        # There the equations have two small singular values: it is located along the simpler orbit.
        zeros.append(("fold", passed))
        changed = [name for name in changed if name != "multiplier 1"]
    for name in changed:
        test, ends = partial(family.test, name=name), (a.tests[name], b.tests[name])
        zero = locate(a, b, test, ends, near_others=name == "multiplier 1")
        if zero is not None:
            zeros.append((name, zero))
    if turns and passed is None and "multiplier 1" not in changed:

        def test_of_turn(z: Floats) -> float:
            return float(family.tangent(z, a.tangent)[-1])

        zero = locate(a, b, test_of_turn, (test_of_turn(a.z), test_of_turn(b.z)))
        if zero is not None:
            zeros.append(("fold", zero))
    zeros = [(name, _at_origin(a, name, zero, turns=turns)) for name, zero in zeros]
    zeros.sort(key=lambda named: named[1].part)
    yield from _merged((a, b), list(_own_zeros(a.problem, zeros, turns=turns)), turns=turns)


def _own_zeros(
    family: BranchEquations, zeros: list[tuple[str, Zero]], *, turns: bool
) -> Iterator[tuple[str, Zero]]:
    """Yield the zeros that are points of their own kind, up to the graze of a soft stop.

    There the branch ends. Some conditions vanish with those of other kinds.
    """
    grazes = any(name.startswith("velocity") for name, _ in zeros)
    leaves = any(family.enters_soft_stop(name) for name, _ in zeros)
    # The clearance of a formal orbit vanishes with the velocity of the impact next to it; and at
    # the graze of a soft stop the branch turns, as velocities of either sign are one motion.
    hidden = {"clearance", "multiplier 1", "fold", "multiplier -1"} if leaves else {"clearance"}
    for name, zero in zeros:
        if name in hidden and grazes and _is_slow(family, zero.orbit):
            continue
        is_fold = turns and name == "multiplier 1"
        if name in EDGES and not is_fold and not _has_multiplier(zero, EDGES[name]):
            continue
        if name == "torus" and not (zero.orbit.multipliers.imag != 0.0).any():
            # A neutral saddle: the product of two real multipliers is 1.
            continue
        yield name, zero
        if family.enters_soft_stop(name):
            return


def _merged(
    ends: tuple[Point[BranchEquations], Point[BranchEquations]],
    zeros: list[tuple[str, Zero]],
    *,
    turns: bool,
) -> Iterator[tuple[SpecialPoint, Point[BranchEquations]]]:
    """Return zeros as special points, those of one kind at one place as one."""
    a, b = ends
    family = a.problem
    last: tuple[SpecialPoint, Point[BranchEquations]] | None = None
    for name, zero in zeros:
        kind, detail = _meaning(a, name, zero.orbit, turns=turns)
        if last is not None and last[0].kind == kind and _is_at(zero, last[1]):
            last = dataclasses.replace(last[0], detail=_joined(last[0].detail, detail)), last[1]
            continue
        if last is not None:
            yield last
        tangent = family.tangent(zero.z, a.tangent)
        point = Point(zero.z, tangent, zero.orbit, family.tests(zero.orbit), family)
        # Where branches cross the tangent is that of the points, as the equations have two.
        chord = (1.0 - zero.part) * a.tangent + zero.part * b.tangent
        chord = chord * np.append(family.scale, family.high - family.low)
        last = dataclasses.replace(_special(family, kind, detail, zero), tangent=chord), point
    if last is not None:
        yield last


def _joined(one: str, other: str) -> str:
    """Return two details of a point as one; those of impacts on one stop are joined."""
    together = other.replace("an impact", "impacts").replace("has no", "have no")
    return together if one in (other, together) else f"{one}, and {other}"


def _has_multiplier(zero: Zero, edge: float) -> bool:
    """Return whether a multiplier is at the edge; the condition also vanishes with a velocity."""
    return not zero.goes_through or bool(np.abs(zero.orbit.multipliers - edge).min() < ON_EDGE)


def _is_at(zero: Zero, other: Point[BranchEquations]) -> bool:
    return norm(zero.z - other.z) < SAME


def _is_slow(family: BranchEquations, orbit: PeriodicOrbit) -> bool:
    return bool(np.abs(family.into_stops(orbit)).min() < SLOW * family.scale[-1])


def _special(
    family: BranchEquations, kind: SpecialPointKind, detail: str, zero: Zero
) -> SpecialPoint:
    low, high = sorted(family.value(z) for z in zero.ends)
    value = family.value(zero.z)
    exact = zero.goes_through and high - low <= LOCATED * max(family.high - family.low, abs(value))
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    return SpecialPoint(kind, family.path, value, (low, high), status, zero.orbit, -1, detail)


def _meaning(
    a: Point[BranchEquations], name: str, orbit: PeriodicOrbit, *, turns: bool
) -> tuple[SpecialPointKind, str]:
    family = a.problem
    if name.startswith("velocity"):
        row, stop, _ = family.entries[int(name.split()[1])]
        if family.walls[row] and accumulates(orbit, row):
            return "chatter", f"impacts on stop {stop} accumulate: the force pushes into it"
        return "grazing", f"an impact on stop {stop} has no velocity"
    if name == "clearance":
        return "grazing", "a turning point between two events grazes a stop"
    if name == "multiplier -1":
        return "period_doubling", "a multiplier is -1"
    if name == "torus":
        turn = 0.5 * atan2(abs(orbit.multipliers[0].imag), orbit.multipliers[0].real) / math.pi
        return "torus", f"a complex pair of multipliers crosses the unit circle, {turn:.6g} turns"
    if name == "third":
        return "strong_resonance", "the multipliers are third roots of 1"
    if name == "fourth":
        return "strong_resonance", "the multipliers are fourth roots of 1"
    if turns:
        origin = origin_of(family, orbit)
        if origin == "doubled" and a.orbit.itinerary.halves_differ() > SAME:
            return "period_doubling", TWO_FOLD
        if origin == "mirrored" and not a.orbit.symmetric:
            return "symmetry_breaking", MIRRORS
        if family.leaves_slowly(orbit):
            return "grazing", LEFT
        return "fold", "two orbits meet and end"
    if orbit.symmetric and family.n % 2 == 0 and _breaks(orbit):
        return "symmetry_breaking", "a multiplier of the map over half the symmetric orbit is -1"
    return "branch_point", "a multiplier is 1, and the parameter does not turn"


def _breaks(orbit: PeriodicOrbit) -> bool:
    """Return whether the multiplier 1 of a symmetric orbit is the square of -1, not of 1."""
    over_half = half_multipliers(orbit.system.law, *orbit.record)
    return min(abs(each + 1.0) for each in over_half) < min(abs(each - 1.0) for each in over_half)


def _at_origin(a: Point[BranchEquations], name: str, zero: Zero, *, turns: bool) -> Zero:
    """Return a zero where one family starts from another as the simpler of the two locates it."""
    if name not in ("multiplier 1", "fold"):
        return zero
    family = a.problem
    origin = origin_of(family, zero.orbit)
    symmetric = origin == "mirrored" and a.orbit.symmetric
    if origin is None or symmetric == turns:
        # No family starts; or symmetric orbits fold.
        return zero
    return located_origin(family, zero, origin) or zero


def coincident_stops(
    orbit: PeriodicOrbit, path: str, first: float, last: float
) -> tuple[float, int, int] | None:
    """Return the value at which the stop that is moved comes to another one, and both stops.

    Parameters
    ----------
    orbit
        An orbit of the family; it meets both stops.
    path
        Path of the parameter.
    first, last
        Values of the parameter; the corner nearest to the first is returned, not at it.

    Returns
    -------
    tuple or None
        None if there is none.
    """
    name, moved = stops_that_are_moved(orbit.system, path)
    places, met = [as_float(stop.at) for stop in orbit.oscillator.stops], set(orbit.sequence)

    def place(stop: int, value: float) -> float:
        return as_float(moved[stop].replaced({name: value})) if stop in moved else places[stop]

    coincident = []
    for stop in moved.keys() & met:
        for other in met - {stop}:
            if moved[stop].is_parameter and other not in moved:
                at: float | None = places[other]
            else:
                at = _crossing(lambda v: place(stop, v) - place(other, v), first, last)  # noqa: B023
            if at is not None and at != first and (at - first) * (at - last) <= 0.0:
                coincident.append((abs(at - first), at, stop, other))
    if not coincident:
        return None
    _, at, stop, other = min(coincident)
    return at, stop, other


def _crossing(distance: Callable[[float], float], first: float, last: float) -> float | None:
    """Return where a distance changes its sign between two values, None for nowhere."""
    low, high = first, last
    is_positive = distance(low) > 0.0
    if (distance(high) > 0.0) == is_positive:
        return None
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if (distance(middle) > 0.0) == is_positive else (low, middle)
    return min((low, high), key=lambda value: abs(distance(value)))
