"""Special points along a branch, its ends, and its continuation with other events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from percuss.errors import PercussError
from percuss.model.oscillator import SoftStop
from percuss.numerics import norm
from percuss.orbits.bifurcations.bifurcation_origin import ENDS, MIRRORS
from percuss.orbits.bifurcations.border_collision import Border, border_reached, effect_of
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.soft_grazing import start_beyond
from percuss.orbits.bifurcations.special_points import (
    LEFT,
    TWO_FOLD,
    SpecialPoint,
    coincidence_point,
    special_points_between,
)
from percuss.orbits.continuation.follow import Segment, hides_zeros, unbounded_growth
from percuss.orbits.continuation.locate import turns_through_zero
from percuss.orbits.continuation.problem import Point
from percuss.orbits.orbit.over_period import fastest
from percuss.orbits.orbit.resonance import changes_much, passes_resonance

Row: TypeAlias = tuple[Point[BranchEquations], SpecialPoint | None]

# A branch that ends this near a corner, in scaled parameter, ends at it.
AT_CORNER = 1e-6
# The component of the parameter in the tangent where velocities grow without bound.
STANDING = 1e-13
# Velocities and distances at a graze, as a part of the velocity and the period.
AT_GRAZE = 1e-9

COINCIDENCE = "impacts coincide: beyond it a flight would have a negative duration"


class BranchDetector:
    """Finds special points between orbits, and the ends of their branch."""

    def stopped(
        self, here: Point[BranchEquations], reason: str
    ) -> Segment[BranchEquations, SpecialPoint]:
        """Return what is beyond the last point: a border with the branch beyond it, or an end.

        It ends at the end of the range, or at a corner.
        """
        try:
            border = border_reached(here)
        except PercussError as error:
            return Segment([], f"beyond {here.text} {reason}: {error}")
        if border is not None:
            return self._across(here, border)
        if here.z[-1] in (0.0, 1.0):
            return Segment([], f"{here.text} reached")
        family = here.problem
        beyond = family.value(here.z + np.sign(here.tangent[-1]) * AT_CORNER)
        corner = coincidence_point(here, beyond, is_end=True)
        if corner is None:
            return Segment([], reason)
        special, point = corner
        return Segment(
            [(point, special)], f"at {family.path} = {special.value:.12g} {special.detail}"
        )

    def _across(
        self, here: Point[BranchEquations], border: Border[BranchEquations]
    ) -> Segment[BranchEquations, SpecialPoint]:
        """Return the special points up to a border, the border, and the branch beyond it."""
        until: Segment[BranchEquations, SpecialPoint] = Segment([])
        if border.before.z is not here.z:
            until = self.between(here, border.before)
        if until.end_reason:
            return until
        row: list[Row] = []
        if here.problem.walls[border.event]:
            row = [(border.point, _border_collision(here.problem, border))]
        return Segment([*until.rows, *row], border.end_reason, border.beyond)

    def between(
        self, here: Point[BranchEquations], new: Point[BranchEquations]
    ) -> Segment[BranchEquations, SpecialPoint]:
        """Return the special points between two orbits, up to the end of the family.

        At the graze of a soft stop a family with other events continues the branch.
        """
        family = here.problem
        ends = here.orbit, new.orbit
        if family.n == 0 and (changes_much(*ends, family.speed) or passes_resonance(*ends)):
            # Where no step is short enough the motion has no bound.
            return Segment(
                [], f"the velocities grow without bound beyond {here.text}", is_astray=True
            )
        if family.n == 0 and _hides_grazes(here, new):
            return Segment([], is_astray=True)
        rows: list[Row] = [(point, kind) for kind, point in special_points_between(here, new)]
        is_astray = hides_zeros(here, new, rows) or _hides_branch_point(here, new, rows)
        corner = coincidence_point(here, family.value(new.z), is_end=False)
        if corner is not None:
            rows.append((corner[1], corner[0]))
            rows.sort(key=lambda row: norm(row[0].z - here.z))
        change = _change(here, new)
        reversed_ = family.reversed_flights(here.z, new.z)
        for k, (point, special) in enumerate(rows):
            if special is None:
                continue
            is_graze = special.kind == "grazing" and special.detail != LEFT
            if is_graze and reversed_ and family.is_coincidence(point.z, reversed_):
                why = f"at {point.text} {COINCIDENCE}"
                return Segment(rows[: k + 1], why, is_astray=is_astray)
            if is_graze and change:
                return _changed(rows[: k + 1], point, change)
            why = _end_at(special)
            if why:
                return Segment(rows[: k + 1], f"at {point.text} {why}", is_astray=is_astray)
        if reversed_:
            # The walk began at the coincidence.
            return Segment([], f"at {here.text} {COINCIDENCE}")
        if change and here.tests["clearance"] == 0.0:
            return _changed([], here, change)
        growth = unbounded_growth(new, family.size(new.z), STANDING)
        return Segment([*rows, (new, None)] if growth else rows, growth, is_astray=is_astray)


def _hides_grazes(here: Point[BranchEquations], new: Point[BranchEquations]) -> bool:
    """Return whether a motion without events reaches a stop, or comes off one, within a step alone."""
    family, chord = here.problem, new.z - here.z

    def clearance(part: float) -> float:
        return family.test(here.z + part * chord, "clearance")

    return turns_through_zero(clearance, (here.tests["clearance"], new.tests["clearance"]))


def _hides_branch_point(
    here: Point[BranchEquations], new: Point[BranchEquations], rows: Sequence[Row]
) -> bool:
    """Return whether a branch turns within a step on which the sign of 1 - a multiplier is kept.

    At a fold it changes; so it does once more within the step, where another branch crosses.
    """
    ends = [point.tests.get("multiplier 1", 0.0) for point in (here, new)]
    return ends[0] * ends[1] > 0.0 and any(
        special is not None
        and special.kind == "fold"
        and not here.problem.leaves_slowly(point.orbit)
        for point, special in rows
    )


def _border_collision(family: BranchEquations, border: Border[BranchEquations]) -> SpecialPoint:
    stop = next(stop for row, stop, _ in family.entries if row == border.event)
    return SpecialPoint(
        "border_collision",
        family.path,
        family.value(border.point.z),
        border.interval,
        "located",
        border.point.orbit,
        -1,
        f"an impact on stop {stop} meets a jump of the force{effect_of(border)}",
        tangent=border.chord * np.append(family.scale, family.high - family.low),
    )


def _end_at(special: SpecialPoint) -> str:
    """Return why a special point ends a branch, "" if it does not."""
    if special.kind == "chatter":
        return f"{special.detail}, and the hops have no number"
    if special.kind == "period_doubling" and TWO_FOLD in special.detail:
        return ENDS["doubled"]
    if special.kind == "symmetry_breaking" and MIRRORS in special.detail:
        return ENDS["mirrored"]
    return ""


def _changed(
    rows: list[Row], graze: Point[BranchEquations], change: str
) -> Segment[BranchEquations, SpecialPoint]:
    """Return a stretch that ends at the graze of a soft stop, and the family beyond it."""
    return Segment(rows, f"beyond {graze.text} {change}", _beyond(graze))


def _beyond(graze: Point[BranchEquations]) -> Point[BranchEquations] | None:
    """Return the graze of a soft stop as the first point of the family beyond it."""
    start = start_beyond(graze.problem, graze.orbit, graze.problem.value(graze.z))
    if start is None:
        return None
    family, z, tangent = start
    z[-1] = min(max(z[-1], 0.0), 1.0)
    orbit = family.solution(z)
    tests = family.tests(orbit)
    near = AT_GRAZE * fastest(orbit)
    for name, value in tests.items():
        # Tests that vanish at the graze are set to zero, so that they do not change sign again.
        is_zero = name == "clearance" and abs(value) < near * orbit.period
        if is_zero or (name.startswith("velocity") and abs(value) < near):
            tests[name] = 0.0
    return Point(z, tangent, orbit, tests, family)


def _change(here: Point[BranchEquations], new: Point[BranchEquations]) -> str:
    """Return the soft stop that is met once more or less at the second point, "" for none."""
    family = here.problem
    for k, (_, stop, _) in enumerate(family.entries):
        name = f"velocity {k}"
        met = here.tests[name] > 0.0
        if met and new.tests[name] <= 0.0 and family.enters_soft_stop(name):
            return f"the orbit does not meet soft stop {stop}"
    if here.tests["clearance"] >= 0.0 > new.tests["clearance"]:
        for stop in new.orbit.passages.stop.tolist():
            if isinstance(family.system.oscillator.stops[stop], SoftStop):
                return f"the orbit meets soft stop {stop} once more"
    return ""
