"""Borders of the equations of orbits: an event that meets a jump of the force.

The equations are smooth where no event passes a jump, and continuous there. A problem of
continuation keeps to the side of its centre, and knows the point on the border that a step would
pass.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import PercussError
from percuss.numerics import norm
from percuss.orbits.bifurcations.force_jumps import Crossing, crossings
from percuss.orbits.continuation.correct import solved
from percuss.orbits.continuation.problem import BorderError

# Newton's steps to a border, residuals of a point on it, and the part of the period off it at
# which derivatives are those of one side.
STEPS, ENOUGH, OFF = 20, 1e-12, 1e-7
# A border further away than this, in steps that would pass it, is not the one that was passed.
FAR = 3.0


class ReachedBorder(NamedTuple):
    """A point on a border.

    ``sides`` (n,) is 1.0 for events that lie after the jump they meet there, as the centre has it,
    -1.0 for those before, 0.0 for events that meet none.
    """

    crossing: Crossing
    z: Floats
    sides: Floats


class Bordered(ABC):
    """The part of a problem of continuation that keeps to one side of its borders."""

    border: ReachedBorder | None = None
    centre: Floats | None = None

    @abstractmethod
    def passed(self, z: Floats) -> Integers:
        """Return the number of jumps of the force before each event of a point, (n,)."""

    @abstractmethod
    def beyond_jump(self, z: Floats, crossing: Crossing) -> float:
        """Return by how much of the period an event lies after a jump of the force."""

    @abstractmethod
    def slope_of_border(self, z: Floats, crossing: Crossing) -> Floats:
        """Return the derivative of `beyond_jump` by a point."""

    @abstractmethod
    def shifted(self, z: Floats, shifts: Floats) -> Floats:
        """Return a point with its events, (n,), shifted by parts of the period."""

    @abstractmethod
    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives of the residuals by a point."""

    @abstractmethod
    def missed(self, z: Floats) -> Floats:
        """Return the residuals of a point."""

    def by_side(self, z: Floats, sides: Floats) -> Floats:
        """Return the derivatives at a point of a border from the sides of its events."""
        return self.derivatives(self.shifted(z, OFF * sides))

    def check_border(self, z: Floats, *, is_located: bool = True) -> None:
        """Find the border that lies between the centre and a point.

        Raises
        ------
        BorderError
            If there is one.
        """
        if self.centre is None:
            return
        before = self.passed(self.centre)
        crossed = crossings(before, self.passed(z))
        if not crossed:
            return
        parts = [self._part_before(self.centre, z, crossing) for crossing in crossed]
        first = int(np.argmin(parts))
        self.border = None
        if is_located:
            sides = np.zeros(len(before))
            for each in crossed:
                sides[each.event] = -each.side
            guess = self.centre + parts[first] * (z - self.centre)
            at = self._on_border(guess, crossed[first], sides)
            if at is not None and norm(at - self.centre) <= FAR * norm(z - self.centre):
                self.border = ReachedBorder(crossed[first], at, self._sides(at, before))
        what = "an event meets a jump of the force"
        raise BorderError(what, is_located=self.border is not None)

    def _part_before(self, here: Floats, there: Floats, crossing: Crossing) -> float:
        """Return the part of the way between two points at which an event meets a jump."""
        before, after = (self.beyond_jump(one, crossing) for one in (here, there))
        return float(before / (before - after)) if before != after else 0.5

    def _sides(self, z: Floats, passed: Integers) -> Floats:
        """Return the sides of events that meet a jump, from the numbers of jumps before them."""
        sides = np.zeros(len(passed))
        for i, count in enumerate(passed.tolist()):
            for jump, side in ((count, -1.0), (count - 1, 1.0)):
                if abs(self.beyond_jump(z, Crossing(i, jump, side))) < OFF:
                    sides[i] = side
        return sides

    def _on_border(self, z: Floats, crossing: Crossing, sides: Floats) -> Floats | None:
        """Return the point near a guess at which an event meets a jump, None if there is none.

        Newton's method: the equations are continuous, and the border is a plane, so that after
        the first step only derivatives along it matter, which both sides share.
        """
        least, best = math.inf, z
        for _ in range(STEPS):
            try:
                matrix = self.by_side(z, sides)
                missed = np.append(self.missed(z), self.beyond_jump(z, crossing))
                border = self.slope_of_border(z, crossing)
            except PercussError:
                return None
            error = float(np.abs(missed).max()) / max(1.0, float(np.abs(z).max()))
            if not error < least:
                break
            least, best = error, z
            z = z + solved(np.vstack([matrix, border]), -missed)
        return best if least < ENOUGH else None
