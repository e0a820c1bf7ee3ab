"""Newton's method on the equations of a chain of flights, families included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError
from percuss.kernels.law import N_HARMONICS, Law
from percuss.kernels.shooting import (
    AT,
    BEFORE,
    SINGULAR,
    SMALLEST_STEP,
    WEAK,
    ShootingProblem,
    advance,
    factor,
    iterate,
)
from percuss.numerics import directions, inverse, is_finite, least_squares, norm

__all__ = ["Solution", "solve"]


MOST_STEPS = 40
# Residuals of a solution, as a part of the scales: far above rounding, far below any other.
SOLVED = 1e-11
# Newton's next step from a solution, as a part of the unknowns, is smaller.
FAR = 1e-3
# Residuals, and singular values, that rounding alone can make.
ROUNDING = 1e-13
# Flights that last this part of the whole are looked at: do they go anywhere?
SHORT = 1e-6
# A family is told from a fold by a step of this size along it, and what remains to be solved.
ALONG = 1e-3
ON_FAMILY = 1e-10


@dataclass(frozen=True, slots=True)
class Solution:
    """Where Newton's method ended.

    Attributes
    ----------
    unknowns
        (2 n + 1,) array, those of `percuss.kernels.shooting.shoot`.
    residual
        Largest residual [length, length/time, time].
    converged
        Whether that is a solution.
    isolated
        Whether no other solution lies beside it.
    """

    unknowns: Floats
    residual: float
    converged: bool
    isolated: bool


def solve(table: Law, chain: Integers, guess: Floats, period: float | None) -> Solution:
    """Solve the equations of a chain, from a guess of its unknowns.

    Where the solutions form a family the step is that of least norm, which leads to the member
    next to the guess.

    Parameters
    ----------
    table
        The law.
    chain
        (n, 3) array, the events.
    guess
        (2 n + 1,) array: instant of event 0, durations of the flights, velocities after events.
    period
        What the durations sum to [time]; None for free motion, whose period is unknown and
        whose event 0 stays where it is.

    Returns
    -------
    Solution
        The last iterate, converged or not.
    """
    system = _LinearSystem(table, chain, period)
    unknowns, size = system.improved(np.array(guess, dtype=np.float64))
    for i, (bound, before, _) in enumerate(chain.tolist()):
        if factor(table, before, bound) == 0.0:
            # A plastic impact leaves no velocity, not even rounding.
            unknowns[1 + len(chain) + i] = 0.0
    converged = size < SOLVED and not system.stands_still(unknowns) and system.is_near(unknowns)
    isolated = not (converged and system.is_on_family(unknowns))
    return Solution(unknowns, system.largest(unknowns), converged, isolated)


class _LinearSystem:
    """The equations of a chain, and room for the kernels."""

    def __init__(self, table: Law, chain: Integers, period: float | None) -> None:
        self.law, self.chain = table, chain
        self.n = len(chain)
        self.period = period or 0.0
        harmonics = int(table[0, N_HARMONICS])
        size = 2 * self.n + 1
        scratch = np.empty((harmonics, 2)), np.empty((harmonics, 2))
        self.problem = ShootingProblem(table, chain, self.period, *scratch)
        self.residual, self.matrix = np.empty(size), np.empty((size, size))

    def iterated(self, unknowns: Floats, best: Floats, steps: int) -> tuple[int, float, int]:
        """Go on from the unknowns; return why it came back, the least residual, steps left."""
        return iterate(self.problem, unknowns, self.residual, self.matrix, best, steps)

    def at(self, unknowns: Floats) -> None:
        """Set scaled residuals and Jacobian."""
        self.iterated(unknowns, np.empty_like(unknowns), 0)

    def improved(self, unknowns: Floats) -> tuple[Floats, float]:
        """Return the best iterate, and its largest scaled residual."""
        best, found = np.empty_like(unknowns), np.empty_like(unknowns)
        least, steps = math.inf, MOST_STEPS
        while True:
            why, size, steps = self.iterated(unknowns, found, steps)
            if size < least or least == math.inf:
                least, best = size, found.copy()
            if why != SINGULAR or steps == 0:
                return best, least
            # Directions that the equations hold so weakly are left as they are.
            self.at(unknowns)
            if not is_finite(self.matrix, self.residual):
                return best, least
            step = least_squares(self.matrix, -self.residual, WEAK)
            steps -= 1
            if advance(unknowns, step, self.n) < SMALLEST_STEP:
                return best, least

    def largest(self, unknowns: Floats) -> float:
        """Return the largest residual, without a scale."""
        self.at(unknowns)
        time, speed = self.scales(unknowns)
        rows = np.array([time * speed, speed] * self.n + [time])
        return float(np.abs(self.residual * rows).max())

    def scales(self, unknowns: Floats) -> tuple[float, float]:
        """Return the scales of time and velocity, as the kernels take them."""
        time = float(np.abs(unknowns[1 : 1 + self.n]).mean())
        return time or 1.0, float(np.abs(unknowns[1 + self.n :]).max()) or 1.0

    def stands_still(self, unknowns: Floats) -> bool:
        """Return whether a flight ends where it starts: zero duration solves its equation too.

        A short hop comes back with the opposite velocity. Free motion whose events all have no
        velocity is rest, or a free oscillation that touches: no motion with impacts.
        """
        lasting, speeds = unknowns[1 : 1 + self.n].tolist(), unknowns[1 + self.n :].tolist()
        if self.period == 0.0 and not any(speeds):
            return True
        for i in range(self.n):
            if lasting[i] >= SHORT * sum(lasting):
                continue
            following = (i + 1) % self.n
            bound = self.chain[following, AT]
            kept = factor(self.law, int(self.chain[following, BEFORE]), int(bound))
            if self.chain[i, AT] == bound and speeds[following] * kept * speeds[i] > 0.0:
                return True
        return False

    def is_near(self, unknowns: Floats) -> bool:
        """Tell a solution from a motion that almost closes, the better the faster it is.

        Where motions grow for ever residuals vanish at infinity only, and Newton's next step is
        as large as the unknowns; at a solution, even a double one, it is small.
        """
        self.at(unknowns)
        if not is_finite(self.matrix, self.residual):
            return False
        if np.abs(self.residual).max() < ROUNDING:
            return True
        step = least_squares(self.matrix, self.residual, ROUNDING)
        return float(np.abs(step).max()) < FAR

    def is_on_family(self, unknowns: Floats) -> bool:
        """Return whether solutions lie beside this one: at a fold the equations only begin to hold."""
        self.at(unknowns)
        if _is_regular(self.matrix):
            return False
        sizes, rows = directions(self.matrix)
        weak = rows[sizes < math.sqrt(WEAK) * sizes[0]]
        return any(self._goes_on(unknowns, direction) for direction in weak)

    def _goes_on(self, unknowns: Floats, direction: Floats) -> bool:
        beside = unknowns.copy()
        advance(beside, ALONG * direction, self.n)
        found, size = self.improved(beside)
        scale = np.repeat(self.scales(unknowns), [1 + self.n, self.n])
        return size < ON_FAMILY and float(np.abs((found - unknowns) / scale).max()) > 0.1 * ALONG


def _is_regular(matrix: Floats) -> bool:
    """Return whether no direction is weak, by norms that bound the singular values: faster."""
    try:
        sizes = norm(matrix) * norm(inverse(matrix))
    except ConvergenceError:
        return False
    return sizes * math.sqrt(WEAK) < 1.0
