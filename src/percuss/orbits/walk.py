"""Steps along a family of orbits: their length, their direction and where they end."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.model.stops import SoftStop
from percuss.orbits.conditions import Point, conditions_of, leaves_soft_stop
from percuss.orbits.family import Family
from percuss.orbits.periodic_orbit import PeriodicOrbit
from percuss.orbits.special_points import SpecialPoint, goes_round_twice, special_points_between

__all__ = ["Row", "Walk"]

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
SHORT, LONG = 1e-7, 0.02


class Walk:
    """The steps along a family."""

    def __init__(self, family: Family, max_points: int, largest_step: float) -> None:
        self.family, self.max_points, self.largest = family, max_points, largest_step

    def start(self, orbit: PeriodicOrbit, value: float) -> Point:
        """Return the orbit as a point, with its tangent."""
        z = self.family.start(orbit, value)
        before = np.zeros(len(z))
        before[-1] = 1.0
        return Point(z, self.family.tangent(z, before), orbit, conditions_of(self.family, orbit))

    def along(self, start: Point, way: float) -> tuple[list[Row], str, bool]:
        """Go one way; return the rows after the start, why they end, whether they close."""
        rows: list[Row] = []
        here = dataclasses.replace(start, tangent=way * start.tangent)
        step = min(FIRST_STEP, self.largest)
        for _ in range(self.max_points):
            end = self._edge(here)
            if end is not None:
                return rows, end, False
            found, step, why = self._step(here, step)
            if found is None:
                return rows, why, False
            new: list[Row] = [
                (it, there) for there, it in special_points_between(self.family, here, found)
            ]
            last, change = self._last(here, found, new)
            if change:
                return rows + new[: last + 1], change, False
            rows += new
            rows.append((found, None))
            if len(rows) > 5 and _is_back(start, found, way, here):
                return rows, "the branch closed", True
            here = found
        return rows, f"max_points = {self.max_points} reached", False

    def _last(self, here: Point, found: Point, new: list[Row]) -> tuple[int, str]:
        """Return which of the special points after a point ends the branch, and why, if one does.

        At soft stops another order of events takes over, and this one means nothing.
        """
        change = self._change(here, found)
        for k, (point, it) in enumerate(new):
            at = f"{self.family.path} = {self.family.value(point.z):.12g}"
            if change and it is not None and it.kind == "grazing":
                return k, f"beyond {at} {change}"
            doubles = it is not None and it.kind == "period_doubling"
            if doubles and goes_round_twice(self.family, point.orbit):
                return k, f"at {at} the orbit is a shorter one gone round twice"
        return 0, ""

    def _change(self, here: Point, found: Point) -> str:
        """Tell how an orbit's meetings with soft stops change between two points, "" if not."""
        for k, (_, stop, _) in enumerate(self.family.ways):
            name = f"velocity {k}"
            met = here.conditions[name] > 0.0
            if met and found.conditions[name] <= 0.0 and leaves_soft_stop(self.family, name):
                return f"the orbit does not meet soft stop {stop}"
        if here.conditions["passage"] > 0.0 >= found.conditions["passage"]:
            for stop in found.orbit.passages.stop.tolist():
                if isinstance(self.family.oscillator.stops[stop], SoftStop):
                    return f"the orbit meets soft stop {stop} once more"
        return ""

    def _edge(self, here: Point) -> str | None:
        part, outwards = here.z[-1], here.tangent[-1]
        if (part <= 0.0 and outwards < 0.0) or (part >= 1.0 and outwards > 0.0):
            return f"{self.family.path} = {self.family.value(here.z):.12g} reached"
        return None

    def _step(self, here: Point, step: float) -> tuple[Point | None, float, str]:
        """Return the next point and the step to try after it."""
        why = ""
        while step > LEAST_STEP:
            try:
                found = self._tried(here, step)
            except PercussError as error:
                found, why = None, str(error)
            if found is None:
                # A tangent from a difference may point aside where another family is near.
                exact = self.family.tangent(here.z, here.tangent)
                here = dataclasses.replace(here, tangent=exact)
            if found is not None:
                straight = float(here.tangent @ found.tangent) > STRAIGHT
                longest = min(self.largest, step * LONGER)
                return found, longest if straight else step, ""
            step *= 0.5
        at = f"{self.family.path} = {self.family.value(here.z):.12g}"
        return None, step, f"no step of {LEAST_STEP:g} beyond {at}: {why or 'the branch bends'}"

    def _tried(self, here: Point, step: float) -> Point | None:
        guess = here.z + step * here.tangent
        normal = here.tangent
        outside = not 0.0 <= guess[-1] <= 1.0
        if outside:
            edge = 0.0 if guess[-1] < 0.0 else 1.0
            guess = here.z + (edge - here.z[-1]) / here.tangent[-1] * here.tangent
            guess[-1] = edge
        along_parameter = outside or abs(here.tangent[-1]) > MOSTLY_PARAMETER
        if along_parameter:
            normal = np.zeros(len(guess))
            normal[-1] = 1.0
        z = self.family.corrected(guess, normal)
        if not 0.0 <= z[-1] <= 1.0 or np.linalg.norm(z - guess) > 0.5 * step:
            return None
        stepped = SHORT < abs(z[-1] - here.z[-1]) < LONG
        known = self.family.value(here.z) if along_parameter and stepped else None
        orbit = self.family.orbit(z)
        tangent = self.family.tangent(z, here.tangent, known)
        if known is not None and here.tangent @ tangent < STRAIGHT:
            tangent = self.family.tangent(z, here.tangent)
        found = Point(z, tangent, orbit, conditions_of(self.family, orbit))
        return found if here.tangent @ found.tangent > TURNED else None


def _is_back(start: Point, found: Point, way: float, before: Point) -> bool:
    """Tell whether the last step passed the start, whole periods apart."""
    apart = start.z - found.z
    if len(apart) > 1:
        apart[0] -= round(apart[0])
    step = float(np.linalg.norm(found.z - before.z))
    same_way = way * float(start.tangent @ found.tangent) > TURNED
    return same_way and float(np.linalg.norm(apart)) < 0.6 * step
