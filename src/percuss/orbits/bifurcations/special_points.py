"""Where the orbits of a branch are born, die, double or touch a stop."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.model.exact import as_float
from percuss.model.law import law
from percuss.numerics import norm
from percuss.orbits.bifurcations.bifurcation_origin import located_origin, origin_of, origin_passed
from percuss.orbits.bifurcations.family import Family, fastest, stop_that_is_moved
from percuss.orbits.bifurcations.grazing import GrazeAnalysis, analysed_graze
from percuss.orbits.bifurcations.grazing_contact import accumulates
from percuss.orbits.bifurcations.soft_grazing import until_soft_graze
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import half_multipliers

__all__ = ["SpecialPoint", "SpecialPointKind", "coincidence_point", "special_points_between"]

SpecialPointKind: TypeAlias = Literal[
    "fold",
    "period_doubling",
    "symmetry_breaking",
    "branch_point",
    "grazing",
    "chatter",
    "corner",
    "strong_resonance",
]

# A bracket in the parameter that is a location, as a part of it.
LOCATED = 1e-10
# How far beside a corner its orbit is taken, in scaled parameter.
CORNER = 1e-11
# Velocities below this part of the scale are too small to tell a passage beside an impact.
SLOW = 1e-6
# Multipliers that the conditions bring to the edge of stability, and how near they come.
EDGES, ON_EDGE = {"one": 1.0, "minus one": -1.0}, 1e-3
# Special points nearer than this are one.
SAME = 1e-9
_DOUBLES = "which doubles here: switch_branch returns that one"
# What is no more than this part of the size of a grazing orbit is the touch.
TOUCH = 1e-9


@dataclass(frozen=True, slots=True)
class SpecialPoint:
    """A point of a branch at which the orbits change in kind.

    Attributes
    ----------
    kind
        "fold" (two orbits meet and end), "period_doubling" (a multiplier of -1, or, as `detail`
        tells, the birth of the orbits of a branch from shorter ones that double),
        "symmetry_breaking" (the multiplier of the map over half a symmetric orbit is -1),
        "branch_point" (a multiplier of 1 otherwise), "grazing" (an impact of no velocity, or a
        turning point that touches a stop), "chatter" (impacts lose their velocity together
        while the force pushes into the wall: they accumulate), "corner" (two stops that are met
        come to lie at one place), "strong_resonance" (of a conservative family, trace -1 or 0).
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

    kind: SpecialPointKind
    path: str
    value: float
    interval: tuple[float, float]
    status: Literal["located", "bracketed"]
    orbit: PeriodicOrbit = field(repr=False)
    row: int
    detail: str
    codimension: int = 1
    # Of the branch there, by unknowns and parameter.
    _tangent: Floats | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        """Tell the point in a line."""
        formal = "" if self.admissible else "; formal, the orbit passes through a stop"
        return (
            f"<SpecialPoint: {self.kind} at {self.path} = {self.value:.12g}, {self.status}, "
            f"row {self.row}; {self.detail}{formal}>"
        )

    @property
    def admissible(self) -> bool:
        """Whether the orbit there passes through no stop; the touch of a graze is no passage."""
        orbit = self.orbit
        if orbit.admissible or self.kind != "grazing":
            return orbit.admissible
        speed = fastest(orbit)
        durations = orbit.itinerary.durations
        deepest = float(orbit.passages.depth.max(initial=0.0))
        shortest = float(durations.min(initial=0.0))
        return deepest <= TOUCH * speed * orbit.period and shortest >= -TOUCH * orbit.period

    @property
    def graze(self) -> GrazeAnalysis | None:
        """What a graze implies for the motions beside it, worked out on demand.

        None for other kinds of points, for orbits with sticking, and where a touch is none of one stop, or of two that
        mirror each other, alone.
        """
        if self.kind != "grazing" or math.isinf(self.orbit.n_impacts):
            return None
        try:
            return analysed_graze(self.orbit, self.path)
        except PercussError:
            return None


def coincidence_point(
    beside: Point[Family], end: float, *, is_end: bool
) -> tuple[SpecialPoint, Point[Family]] | None:
    """Return the corner between a point of a family and a value of the parameter, None for none.

    At the corner itself the stops are one, and the equations others: its orbit is the one beside.
    """
    family = beside.problem
    value = family.value(beside.z)
    found = coincident_stops(beside.orbit, family.path, value, end)
    if found is None:
        return None
    at, moved, other = found
    detail = f"stops {moved} and {other} come to lie at one place"
    there = beside
    if not is_end:
        guess = beside.z.copy()
        guess[-1] = (at - family.low) / (family.high - family.low) - CORNER * np.sign(at - value)
        z = family.corrected(guess, along_parameter(len(guess)))
        orbit = family.solution(z)
        there = Point(z, beside.tangent, orbit, family.tests(orbit), family)
    ends = sorted((family.value(there.z), at))
    exact = ends[1] - ends[0] <= LOCATED * max(1.0, abs(at)) or not is_end
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    special = SpecialPoint(
        "corner", family.path, at, (ends[0], ends[1]), status, there.orbit, -1, detail
    )
    return special, there


def special_points_between(
    a: Point[Family], b: Point[Family]
) -> Iterator[tuple[SpecialPoint, Point[Family]]]:
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
        # There the equations hold two directions weakly; the simpler orbit tells it.
        zeros.append(("fold", passed))
        changed = [name for name in changed if name != "one"]
    for name in changed:
        test, ends = partial(family.test, name=name), (a.tests[name], b.tests[name])
        zero = locate(a, b, test, ends, beside_others=name == "one")
        if zero is not None:
            zeros.append((name, zero))
    if turns and passed is None and "one" not in changed:

        def test_of_turn(z: Floats) -> float:
            return float(family.tangent(z, a.tangent)[-1])

        zero = locate(a, b, test_of_turn, (test_of_turn(a.z), test_of_turn(b.z)))
        if zero is not None:
            zeros.append(("fold", zero))
    zeros = [(name, _at_origin(a, name, zero, turns=turns)) for name, zero in zeros]
    yield from _told((a, b), sorted(zeros, key=lambda found: found[1].part), turns=turns)


def _told(
    ends: tuple[Point[Family], Point[Family]], zeros: list[tuple[str, Zero]], *, turns: bool
) -> Iterator[tuple[SpecialPoint, Point[Family]]]:
    """Return zeros in order as special points, those of one kind at one place as one."""
    a, b = ends
    family = a.problem
    touched = any(name.startswith("velocity") for name, _ in zeros)
    leaves = any(family.enters_soft_stop(name) for name, _ in zeros)
    # The passage of a formal orbit vanishes with the velocity of the impact beside it; and a
    # soft stop that is left after no time turns the branch, as a velocity of either sign is one.
    hidden = {"passage", "one", "fold", "minus one"} if leaves else {"passage"}
    last: tuple[SpecialPoint, Point[Family]] | None = None
    for name, zero in zeros:
        if name in hidden and touched and _is_slow(family, zero.orbit):
            continue
        if (
            name in EDGES
            and not (turns and name == "one")
            and not _has_multiplier(zero, EDGES[name])
        ):
            continue
        kind, detail = _meaning(a, name, zero.orbit, turns=turns)
        if last is not None and last[0].kind == kind and _is_at(zero, last[1]):
            last = dataclasses.replace(last[0], detail=_joined(last[0].detail, detail)), last[1]
            continue
        if last is not None:
            yield last
        tangent = family.tangent(zero.z, a.tangent)
        there = Point(zero.z, tangent, zero.orbit, family.tests(zero.orbit), family)
        # Where branches cross the equations do not tell their tangents apart; the points do.
        chord = (1.0 - zero.part) * a.tangent + zero.part * b.tangent
        chord = chord * np.append(family.scale, family.high - family.low)
        it = dataclasses.replace(_special(family, kind, detail, zero), _tangent=chord)
        last = it, there
        if family.enters_soft_stop(name):
            break
    if last is not None:
        yield last


def _joined(one: str, other: str) -> str:
    """Return two things that happen at a point in words; impacts on a stop are told together."""
    together = other.replace("an impact", "impacts").replace("has no", "have no")
    return together if one in (other, together) else f"{one}, and {other}"


def _has_multiplier(zero: Zero, edge: float) -> bool:
    """Tell a multiplier that comes to the edge from an impact velocity that comes to zero."""
    return not zero.goes_through or bool(np.abs(zero.orbit.multipliers - edge).min() < ON_EDGE)


def _is_at(zero: Zero, other: Point[Family]) -> bool:
    return norm(zero.z - other.z) < SAME


def _is_slow(family: Family, orbit: PeriodicOrbit) -> bool:
    return bool(np.abs(family.into_stops(orbit)).min() < SLOW * family.scale[-1])


def _special(family: Family, kind: SpecialPointKind, detail: str, zero: Zero) -> SpecialPoint:
    low, high = sorted(family.value(z) for z in zero.ends)
    value = family.value(zero.z)
    exact = zero.goes_through and high - low <= LOCATED * max(1.0, abs(value))
    status: Literal["located", "bracketed"] = "located" if exact else "bracketed"
    return SpecialPoint(kind, family.path, value, (low, high), status, zero.orbit, -1, detail)


def _meaning(
    a: Point[Family], name: str, orbit: PeriodicOrbit, *, turns: bool
) -> tuple[SpecialPointKind, str]:
    family = a.problem
    if name.startswith("velocity"):
        row, stop, _ = family.entries[int(name.split()[1])]
        if family.walls[row] and accumulates(orbit, row):
            return "chatter", f"impacts on stop {stop} accumulate: the force pushes into it"
        return "grazing", f"an impact on stop {stop} has no velocity"
    if name == "passage":
        return "grazing", "a turning point between two events touches a stop"
    if name == "minus one":
        return "period_doubling", "a multiplier is -1"
    if name == "third":
        return "strong_resonance", "the multipliers are third roots of 1"
    if name == "fourth":
        return "strong_resonance", "the multipliers are fourth roots of 1"
    if turns:
        origin = origin_of(family, orbit)
        if origin == "doubled" and a.orbit.itinerary.halves_differ() > SAME:
            return "period_doubling", "the orbit is a shorter one gone round twice, " + _DOUBLES
        if origin == "mirrored" and not a.orbit.symmetric:
            return "symmetry_breaking", "the orbit is symmetric; two that mirror each other start"
        return "fold", "two orbits meet and end"
    if orbit.symmetric and family.n % 2 == 0 and _breaks(orbit):
        return "symmetry_breaking", "a multiplier of the map over half the symmetric orbit is -1"
    return "branch_point", "a multiplier is 1, and the parameter does not turn"


def _breaks(orbit: PeriodicOrbit) -> bool:
    """Return whether the multiplier 1 of a symmetric orbit is the square of -1, not of 1."""
    table = law(orbit.oscillator, orbit.forcing)
    over_half = half_multipliers(table, *orbit.record)
    return min(abs(each + 1.0) for each in over_half) < min(abs(each - 1.0) for each in over_half)


def _at_origin(a: Point[Family], name: str, zero: Zero, *, turns: bool) -> Zero:
    """Return a zero where one family starts from another as the simpler of the two locates it."""
    if name not in ("one", "fold"):
        return zero
    family = a.problem
    origin = origin_of(family, zero.orbit)
    symmetric = origin == "mirrored" and a.orbit.symmetric
    if origin is None or symmetric == turns:
        # Nothing starts; or symmetric orbits fold.
        return zero
    return located_origin(family, zero, origin) or zero


def coincident_stops(
    orbit: PeriodicOrbit, path: str, first: float, last: float
) -> tuple[float, int, int] | None:
    """Return the value at which the stop that is moved comes to another one, and both stops.

    Parameters
    ----------
    orbit
        One of a family; it has to meet both.
    path
        Path of the parameter.
    first, last
        Values of the parameter; the corner nearest to the first is returned, not at it.

    Returns
    -------
    tuple or None
        None if there is none.
    """
    moved = stop_that_is_moved(path)
    if moved is None or moved not in orbit.sequence:
        return None
    found = []
    for other, stop in enumerate(orbit.oscillator.stops):
        at = as_float(stop.at)
        if other != moved and other in orbit.sequence and (at - first) * (at - last) <= 0.0:
            found.append((abs(at - first), at, other))
    found = [it for it in found if it[0] > 0.0]
    if not found:
        return None
    _, at, other = min(found)
    return at, moved, other
