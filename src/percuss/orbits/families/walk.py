"""Steps along a family of orbits: their length, their direction and where they end."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError, PercussError
from percuss.model.stops import SoftStop
from percuss.numerics import dot, norm
from percuss.orbits.families.conditions import Point, conditions_of, leaves_soft_stop
from percuss.orbits.families.family import Family
from percuss.orbits.families.meetings import start_beyond
from percuss.orbits.families.special_points import (
    SpecialPoint,
    corner_point,
    special_points_between,
)
from percuss.orbits.families.touches import fastest
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.same import are_same
from percuss.progress import Progress

__all__ = ["STOPPED", "Row", "Walk"]

Floats = NDArray[np.float64]
Row = tuple[Point, SpecialPoint | None]

# Scaled arclength of the first step and of the least one.
FIRST_STEP, LEAST_STEP = 1e-3, 1e-9
# Cosines of the angle between tangents: below the first a step is made again, half as long;
# above the second the next one is longer.
TURNED, STRAIGHT = 0.97, 0.995
LONGER = 1.6
# Where the parameter makes up this part of a step it is the coordinate; elsewhere arclength is.
MOSTLY_PARAMETER = 0.1
# Steps of the parameter between these give its derivative, as a part of the range.
SHORT, LONG = 1e-7, 0.05

# A branch that ends this near to a corner, in scaled parameter, ends there.
AT_CORNER = 1e-6
# Velocities so much larger than the first orbit's, and a parameter that goes so much less than
# they do, grow without bound.
LARGE, STANDING = 1e6, 1e-13
# Velocities and distances at a graze, as a part of the velocity and the period.
AT_GRAZE = 1e-9

STOPPED = "stopped by progress"
FELL_TOGETHER = "impacts fall together: beyond, a flight would last less than no time"


class Walk:
    """The steps along a family."""

    def __init__(self, family: Family, max_points: int, largest_step: float) -> None:
        self.family, self.max_points, self.largest = family, max_points, largest_step

    def start(self, orbit: PeriodicOrbit, value: float) -> Point:
        """Return the orbit as a point, with its tangent."""
        z = self.family.start(orbit, value)
        before = np.zeros(len(z))
        before[-1] = 1.0
        tangent = self.family.tangent(z, before)
        return Point(z, tangent, orbit, conditions_of(self.family, orbit), self.family)

    def along(
        self,
        start: Point,
        way: float,
        *,
        until: Callable[[SpecialPoint], bool] | None = None,
        progress: Progress | None = None,
    ) -> tuple[list[Row], str, bool]:
        """Go one way; return the rows after the start, why they end, whether they close.

        ``until`` ends it at a special point, which then is the last row; ``progress``
        counts the orbits, and may end it too.
        """
        rows: list[Row] = []
        walk, here = self, dataclasses.replace(start, tangent=way * start.tangent)
        step = first = min(FIRST_STEP, self.largest)
        while len(rows) < self.max_points:
            end = walk._edge(here)
            if end is not None:
                return rows, end, False
            found, step, why = walk._step(here, step)
            if found is None:
                if here.z[-1] in (0.0, 1.0):
                    return rows, walk._reached(here), False
                corner = walk._corner(here)
                if corner is None or corner[1] is None:
                    return rows, why, False
                at = f"{walk.family.path} = {corner[1].value:.12g}"
                return [*rows, corner], f"at {at} {corner[1].detail}", False
            new = walk._specials(here, found)
            last, why, changes = walk._last(here, found, new)
            for row in new[: last + 1]:
                rows.append(row)
                if until is not None and row[1] is not None and until(row[1]):
                    return rows, row[1].detail, False
            if why:
                graze = here if last < 0 else new[last][0]
                other = walk._beyond(graze) if changes else None
                if other is None:
                    return rows, why, False
                walk, here = other
                step = first
                continue
            rows.append((found, None))
            if len(rows) > 5 and walk._is_back(start, found, way, here):
                return rows, "the branch closed", True
            here = found
            text = f"{walk.family.path} = {walk.family.value(here.z):.6g}"
            if progress is not None and not progress.advance(text=text):
                return rows, STOPPED, False
        return rows, f"max_points = {self.max_points} reached", False

    def _specials(self, here: Point, found: Point) -> list[Row]:
        """Return the special points between two points, in order."""
        between = special_points_between(self.family, here, found)
        new: list[Row] = [(it, special) for special, it in between]
        corner = corner_point(self.family, here, self.family.value(found.z), is_end=False)
        if corner is not None:
            new.append((corner[1], corner[0]))
            new.sort(key=lambda row: norm(row[0].z - here.z))
        return new

    def _corner(self, here: Point) -> Row | None:
        """Return the corner at which the parameter can go no further, None if it is none."""
        beyond = self.family.value(here.z + np.sign(here.tangent[-1]) * AT_CORNER)
        corner = corner_point(self.family, here, beyond, is_end=True)
        return None if corner is None else (corner[1], corner[0])

    def _beyond(self, graze: Point) -> tuple[Walk, Point] | None:
        """Return the walk that goes on beyond a graze of a soft stop, and the graze as its start."""
        begun = start_beyond(self.family, graze.orbit, self.family.value(graze.z))
        if begun is None:
            return None
        family, z, tangent = begun
        z[-1] = min(max(z[-1], 0.0), 1.0)
        orbit = family.orbit(z)
        conditions = conditions_of(family, orbit)
        near = AT_GRAZE * fastest(orbit)
        for name, value in conditions.items():
            # What the graze zeroes, to rounding, changes no sign there again.
            room = name == "passage" and abs(value) < near * orbit.period
            if room or (name.startswith("velocity") and abs(value) < near):
                conditions[name] = 0.0
        walk = Walk(family, self.max_points, self.largest)
        return walk, Point(z, tangent, orbit, conditions, family)

    def _last(self, here: Point, found: Point, new: list[Row]) -> tuple[int, str, bool]:
        """Return which of the special points after a point ends the family, and why, if one does.

        At soft stops another order of events takes over, and this one means nothing; the last
        entry tells whether it is that.
        """
        change = self._change(here, found)
        together = self.family.turns_back(here.z, found.z)
        for k, (point, it) in enumerate(new):
            at = f"{self.family.path} = {self.family.value(point.z):.12g}"
            grazes = it is not None and it.kind == "grazing"
            if grazes and together and self.family.is_together(point.z, together):
                why = (
                    f"at {at} impacts fall together: beyond, a flight would last less than no time"
                )
                return k, why, False
            if change and grazes:
                return k, f"beyond {at} {change}", True
            if it is not None and it.kind == "chatter":
                return k, f"at {at} {it.detail}, and hops cannot be told apart", False
            if it is not None and it.kind == "period_doubling" and "twice" in it.detail:
                return k, f"at {at} the orbit is a shorter one gone round twice", False
            if it is not None and it.kind == "symmetry_breaking" and "start" in it.detail:
                return (
                    k,
                    f"at {at} the orbit is symmetric; beyond it lies the mirrored family",
                    False,
                )
        if together:
            # It was begun where they do.
            return (
                -1,
                f"at {self.family.path} = {self.family.value(here.z):.12g} {FELL_TOGETHER}",
                False,
            )
        if change and here.conditions["passage"] == 0.0:
            return (
                -1,
                f"beyond {self.family.path} = {self.family.value(here.z):.12g} {change}",
                True,
            )
        return len(new), "", False

    def _change(self, here: Point, found: Point) -> str:
        """Tell how an orbit's meetings with soft stops change between two points, "" if not."""
        for k, (_, stop, _) in enumerate(self.family.ways):
            name = f"velocity {k}"
            met = here.conditions[name] > 0.0
            if met and found.conditions[name] <= 0.0 and leaves_soft_stop(self.family, name):
                return f"the orbit does not meet soft stop {stop}"
        if here.conditions["passage"] >= 0.0 > found.conditions["passage"]:
            for stop in found.orbit.passages.stop.tolist():
                if isinstance(self.family.oscillator.stops[stop], SoftStop):
                    return f"the orbit meets soft stop {stop} once more"
        return ""

    def _edge(self, here: Point) -> str | None:
        part, outwards = here.z[-1], here.tangent[-1]
        if (part <= 0.0 and outwards < 0.0) or (part >= 1.0 and outwards > 0.0):
            return self._reached(here)
        if self.family.size(here.z) > LARGE and abs(outwards) < STANDING:
            at = f"{self.family.path} = {self.family.value(here.z):.12g}"
            return f"the velocities grow without bound towards {at}"
        return None

    def _reached(self, here: Point) -> str:
        return f"{self.family.path} = {self.family.value(here.z):.12g} reached"

    def _step(self, here: Point, step: float) -> tuple[Point | None, float, str]:
        """Return the next point and the step to try after it."""
        why, invalid = "", False
        while step > LEAST_STEP:
            try:
                found = self._tried(here, step)
            except PercussError as error:
                found, why = None, str(error)
                invalid = isinstance(error, ParameterError)
            if found is None:
                # A tangent from a difference may point aside where another family is near.
                exact = self.family.tangent(here.z, here.tangent)
                here = dataclasses.replace(here, tangent=exact)
            if found is not None:
                straight = dot(here.tangent, found.tangent) > STRAIGHT
                longest = min(self.largest * self.family.size(found.z), step * LONGER)
                return found, longest if straight else step, ""
            step *= 0.5
        at = f"{self.family.path} = {self.family.value(here.z):.12g}"
        if invalid:
            return None, step, f"beyond {at} there is no such system: {why}"
        return None, step, f"no step of {LEAST_STEP:g} beyond {at}: {why or 'the branch bends'}"

    def _tried(self, here: Point, step: float) -> Point | None:
        guess = here.z + step * here.tangent
        normal = here.tangent
        outside = not 0.0 <= guess[-1] <= 1.0
        if outside and here.tangent[-1] != 0.0:
            edge = 0.0 if guess[-1] < 0.0 else 1.0
            guess = here.z + (edge - here.z[-1]) / here.tangent[-1] * here.tangent
            guess[-1] = edge
        along_parameter = outside or abs(here.tangent[-1]) > MOSTLY_PARAMETER
        if along_parameter:
            normal = np.zeros(len(guess))
            normal[-1] = 1.0
        z = self.family.corrected(guess, normal)
        if not 0.0 <= z[-1] <= 1.0 or norm(z - guess) > 0.5 * step:
            return None
        stepped = SHORT < abs(z[-1] - here.z[-1]) < LONG
        known = self.family.value(here.z) if stepped else None
        orbit = self.family.orbit(z)
        tangent = self.family.tangent(z, here.tangent, known)
        if known is not None and dot(here.tangent, tangent) < STRAIGHT:
            tangent = self.family.tangent(z, here.tangent)
        found = Point(z, tangent, orbit, conditions_of(self.family, orbit), self.family)
        return found if dot(here.tangent, found.tangent) > TURNED else None

    def _is_back(self, start: Point, found: Point, way: float, before: Point) -> bool:
        """Tell whether the last step passed the start, whole periods apart."""
        if self.family is not start.family:
            return self._is_back_by_others(start, found, before)
        apart = start.z - found.z
        if len(apart) > 1:
            apart[0] -= round(apart[0])
        step = norm(found.z - before.z)
        same_way = way * dot(start.tangent, found.tangent) > TURNED
        return same_way and norm(apart) < 0.6 * step

    def _is_back_by_others(self, start: Point, found: Point, before: Point) -> bool:
        """Tell whether the last step passed the start after other events have come and gone."""
        value = start.z[-1]
        if (before.z[-1] - value) * (found.z[-1] - value) > 0.0 or before.z[-1] == found.z[-1]:
            return False
        if len(found.orbit._chain) != len(start.orbit._chain):
            return False
        part = (value - before.z[-1]) / (found.z[-1] - before.z[-1])
        held = np.append(np.zeros(len(found.z) - 1), 1.0)
        try:
            there = self.family.corrected(before.z + part * (found.z - before.z), held)
            return are_same(self.family.orbit(there), start.orbit)
        except PercussError:
            return False
