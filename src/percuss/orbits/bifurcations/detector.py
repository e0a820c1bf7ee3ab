"""What a branch of orbits passes, and where it ends or goes on with other events."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from percuss.model.stops import SoftStop
from percuss.numerics import norm
from percuss.orbits.bifurcations.family import Family, fastest
from percuss.orbits.bifurcations.soft_grazing import start_beyond
from percuss.orbits.bifurcations.special_points import (
    SpecialPoint,
    coincidence_point,
    special_points_between,
)
from percuss.orbits.continuation.follow import Segment
from percuss.orbits.continuation.problem import Point

__all__ = ["BranchDetector", "Row"]

Row: TypeAlias = tuple[Point[Family], SpecialPoint | None]

# A branch that ends this near to a corner, in scaled parameter, ends there.
AT_CORNER = 1e-6
# Velocities so much larger than the first orbit's, and a parameter that goes so much less than
# they do, grow without bound.
LARGE, STANDING = 1e6, 1e-13
# Velocities and distances at a graze, as a part of the velocity and the period.
AT_GRAZE = 1e-9

FELL_TOGETHER = "impacts fall together: beyond, a flight would last less than no time"


class BranchDetector:
    """Finds special points between orbits, and the ends of their branch."""

    def stopped(self, here: Point[Family], reason: str) -> Segment[Family, SpecialPoint]:
        """Return the end of the range, or the corner, at which the parameter can go no further."""
        if here.z[-1] in (0.0, 1.0):
            return Segment([], f"{here.text} reached")
        family = here.problem
        beyond = family.value(here.z + np.sign(here.tangent[-1]) * AT_CORNER)
        corner = coincidence_point(here, beyond, is_end=True)
        if corner is None:
            return Segment([], reason)
        special, there = corner
        return Segment(
            [(there, special)], f"at {family.path} = {special.value:.12g} {special.detail}"
        )

    def between(self, here: Point[Family], found: Point[Family]) -> Segment[Family, SpecialPoint]:
        """Return the special points between two orbits as far as the family goes.

        At soft stops another order of events takes over, and this one means nothing.
        """
        family = here.problem
        new: list[Row] = [(it, special) for special, it in special_points_between(here, found)]
        corner = coincidence_point(here, family.value(found.z), is_end=False)
        if corner is not None:
            new.append((corner[1], corner[0]))
            new.sort(key=lambda row: norm(row[0].z - here.z))
        change = _change(here, found)
        together = family.turns_back(here.z, found.z)
        for k, (point, it) in enumerate(new):
            if it is None:
                continue
            if it.kind == "grazing" and together and family.is_together(point.z, together):
                return Segment(new[: k + 1], f"at {point.text} {FELL_TOGETHER}")
            if it.kind == "grazing" and change:
                return _changed(new[: k + 1], point, change)
            why = _end_at(it)
            if why:
                return Segment(new[: k + 1], f"at {point.text} {why}")
        if together:
            # It was begun where they do.
            return Segment([], f"at {here.text} {FELL_TOGETHER}")
        if change and here.tests["passage"] == 0.0:
            return _changed([], here, change)
        if family.size(found.z) > LARGE and abs(found.tangent[-1]) < STANDING:
            why = f"the velocities grow without bound towards {found.text}"
            return Segment([*new, (found, None)], why)
        return Segment(new)


def _end_at(special: SpecialPoint) -> str:
    """Return why a special point ends a branch, "" if it does not."""
    if special.kind == "chatter":
        return f"{special.detail}, and hops cannot be told apart"
    if special.kind == "period_doubling" and "twice" in special.detail:
        return "the orbit is a shorter one gone round twice"
    if special.kind == "symmetry_breaking" and "start" in special.detail:
        return "the orbit is symmetric; beyond it lies the mirrored family"
    return ""


def _changed(rows: list[Row], graze: Point[Family], change: str) -> Segment[Family, SpecialPoint]:
    """Return a stretch that ends at the graze of a soft stop, and the family beyond it."""
    return Segment(rows, f"beyond {graze.text} {change}", _beyond(graze))


def _beyond(graze: Point[Family]) -> Point[Family] | None:
    """Return the graze of a soft stop as the first point of the family beyond it."""
    begun = start_beyond(graze.problem, graze.orbit, graze.problem.value(graze.z))
    if begun is None:
        return None
    family, z, tangent = begun
    z[-1] = min(max(z[-1], 0.0), 1.0)
    orbit = family.solution(z)
    tests = family.tests(orbit)
    near = AT_GRAZE * fastest(orbit)
    for name, value in tests.items():
        # What the graze zeroes, to rounding, changes no sign there again.
        room = name == "passage" and abs(value) < near * orbit.period
        if room or (name.startswith("velocity") and abs(value) < near):
            tests[name] = 0.0
    return Point(z, tangent, orbit, tests, family)


def _change(here: Point[Family], found: Point[Family]) -> str:
    """Return how an orbit's meetings with soft stops change between two points, "" if not."""
    family = here.problem
    for k, (_, stop, _) in enumerate(family.entries):
        name = f"velocity {k}"
        met = here.tests[name] > 0.0
        if met and found.tests[name] <= 0.0 and family.enters_soft_stop(name):
            return f"the orbit does not meet soft stop {stop}"
    if here.tests["passage"] >= 0.0 > found.tests["passage"]:
        for stop in found.orbit.passages.stop.tolist():
            if isinstance(family.oscillator.stops[stop], SoftStop):
                return f"the orbit meets soft stop {stop} once more"
    return ""
