"""Steps along a curve in two parameters: their length, their direction and where they end."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.numerics import directions, dot, norm
from percuss.orbits.curves.curve import CurveKind, CurvePoint
from percuss.orbits.curves.curve_equations import CurveEquations
from percuss.orbits.curves.curve_points import curve_points_between, lost_stop, met_stop
from percuss.orbits.families.conditions import Point
from percuss.orbits.families.walk import STOPPED
from percuss.progress import Progress

__all__ = ["CurveRow", "CurveWalk"]

Floats = NDArray[np.float64]
CurveRow = tuple[Point, CurvePoint | None]

# Scaled arclength of the first step, of the least one and of the longest.
FIRST_STEP, LEAST_STEP, LONGEST_STEP = 1e-3, 1e-9, 0.25
# Cosines of the angle between tangents: below the first a step is made again, half as long;
# above the second the next one is longer.
TURNED, STRAIGHT = 0.97, 0.995
LONGER = 1.6
# Steps to where a soft stop is hardly met are made again, down to this.
NEAR_END = 1e-5


class CurveWalk:
    """The steps along a curve.

    Parameters
    ----------
    equations
        Those of the curve.
    kind
        What kind of curve it is.
    max_points
        The most steps one way.
    largest_step
        The longest step of the scaled parameters.
    progress
        Counts the steps.
    """

    def __init__(
        self,
        equations: CurveEquations,
        kind: CurveKind,
        max_points: int,
        largest_step: float,
        progress: Progress,
    ) -> None:
        self.equations, self.kind, self.progress = equations, kind, progress
        self.max_points, self.largest = max_points, largest_step

    def start(self, guess: Floats) -> Point:
        """Return the point of the curve next to a guess, with its tangent.

        Raises
        ------
        ConvergenceError
            If there is none.
        """
        _, rows = directions(self.equations.derivatives(guess))
        point = self._point(self.equations.corrected(guess, rows[-1]), rows[-1])
        self._start_derivatives = self._derivatives
        return point

    def along(self, start: Point, way: float) -> tuple[list[CurveRow], str, bool]:
        """Go one way; return the rows after the start, why they end, whether they close."""
        rows: list[CurveRow] = []
        here = dataclasses.replace(start, tangent=way * start.tangent)
        bend = np.zeros(len(here.z))
        step = FIRST_STEP
        self.equations.settle(here.z, self._start_derivatives)
        for _ in range(self.max_points):
            end = self._edge(here)
            if end:
                return rows, end, False
            path, value = self.equations.equations.paths[0], self.equations.values(here.z)[0]
            if not self.progress.advance(text=f"{path} = {value:.6g}"):
                return rows, STOPPED, False
            found, step, why = self._step(here, bend, step)
            if found is None:
                return rows, why, False
            lost = lost_stop(self.equations, found.conditions)
            if lost:
                return rows, f"near {self._told(here)} {lost}", False
            new = list(curve_points_between(self.equations, self.kind, here, found))
            change = met_stop(self.equations, here, found)
            rows += [(there, it) for it, there in new]
            if change:
                at = self._told(new[-1][1] if new else found)
                return rows, f"beyond {at} {change}", False
            rows.append((found, None))
            self.equations.settle(found.z, self._derivatives)
            if len(rows) > 5 and self._is_back(start, found, way, here):
                return rows, "the curve closed", True
            bend = (found.tangent - here.tangent) / norm(found.z - here.z)
            here = found
        return rows, f"max_points = {self.max_points} reached", False

    def _told(self, point: Point) -> str:
        pairs = zip(self.equations.equations.paths, self.equations.values(point.z), strict=True)
        return ", ".join(f"{path} = {value:.12g}" for path, value in pairs)

    def _edge(self, here: Point) -> str:
        for k, path in enumerate(self.equations.equations.paths):
            part, outwards = here.z[k - 2], here.tangent[k - 2]
            if (part <= 0.0 and outwards < 0.0) or (part >= 1.0 and outwards > 0.0):
                return f"{path} = {self.equations.values(here.z)[k]:.12g} reached"
        return ""

    def _step(self, here: Point, bend: Floats, step: float) -> tuple[Point | None, float, str]:
        """Return the next point and the step to try after it."""
        moved = norm(here.tangent[-2:])
        step = min(step, LONGEST_STEP, self.largest / max(moved, 1e-9))
        why = "the curve bends"
        while step > LEAST_STEP:
            try:
                found = self._tried(here, bend, step)
            except PercussError as error:
                found, why = None, str(error)
            if (
                found is not None
                and step > NEAR_END
                and lost_stop(self.equations, found.conditions)
            ):
                # The end is approached.
                found = None
            if found is not None:
                straight = dot(here.tangent, found.tangent) > STRAIGHT
                return found, step * LONGER if straight else step, ""
            step *= 0.5
        return None, step, f"no step of {LEAST_STEP:g} beyond {self._told(here)}: {why}"

    def _tried(self, here: Point, bend: Floats, step: float) -> Point | None:
        guess = here.z + step * here.tangent + (0.5 * step * step) * bend
        normal = here.tangent
        for k in (-2, -1):
            if not 0.0 <= guess[k] <= 1.0:
                edge = 0.0 if guess[k] < 0.0 else 1.0
                if here.tangent[k] == 0.0 or here.z[k] == edge:
                    continue
                shorter = (edge - here.z[k]) / here.tangent[k]
                if 0.0 < shorter < 2.0 * step:
                    guess = here.z + shorter * here.tangent
                    guess[k], step = edge, shorter
                    normal = np.zeros(len(guess))
                    normal[k] = 1.0
        z = self.equations.corrected(guess, normal)
        if normal is not here.tangent:
            k = int(np.argmax(normal))
            z[k] = guess[k]
        if (np.abs(z[-2:] - 0.5) > 0.5).any() or norm(z - guess) > 0.5 * step:
            return None
        found = self._point(z, here.tangent)
        return found if dot(here.tangent, found.tangent) > TURNED else None

    def _point(self, z: Floats, before: Floats) -> Point:
        self._derivatives = self.equations.derivatives(z)
        tangent = self.equations.tangent(self._derivatives, before)
        orbit, conditions = self.equations.told(z)
        return Point(z, tangent, orbit, conditions)

    def _is_back(self, start: Point, found: Point, way: float, before: Point) -> bool:
        """Tell whether the last step passed the start, whole periods apart."""
        apart = start.z - found.z
        apart[0] -= round(apart[0])
        step = norm(found.z - before.z)
        same_way = way * dot(start.tangent, found.tangent) > TURNED
        return same_way and norm(apart) < 0.6 * step
