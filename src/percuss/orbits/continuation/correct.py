"""The corrector: Newton's method in a plane, with computed or updated derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.numerics import dot, least_squares, norm, solve_linear

# Residuals, (K,), and their derivatives, (K, K + 1), at a point.
Equations: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]

# Singular values below this part of the largest.
WEAK = 1e-7
# Residuals of a solution, as a part of its own size: rounding of a sequence of flights is some
# 1e-15.
SOLVED = 1e-12
# Residuals whose rounding errors exceed the orbit: steps from there are meaningless.
LOST = 2.0**52


def corrected(
    equations: Equations,
    guess: Floats,
    normal: Floats,
    *,
    steps: int,
    enough: float,
    size: Callable[[Floats], float] = lambda _: 1.0,
    weak: float = 0.0,
) -> tuple[Floats, float, bool]:
    """Solve equations in the plane through a guess with this normal.

    Where the plane fixes one unknown it is left as it is, and its derivatives are not used.

    Parameters
    ----------
    equations, guess, normal
        Residuals and derivatives at a point; (K + 1,) arrays.
    steps, enough
        The most steps, and relative residuals that need not become smaller.
    size
        The scale of a point.
    weak
        Directions weaker than this part of the strongest stay as the guess has them.

    Returns
    -------
    tuple
        The best iterate, its relative residual, and whether that is a solution.
    """
    along = np.flatnonzero(normal)
    fixed = int(along[0]) if len(along) == 1 else None
    z = best = guess.copy()
    least = np.inf
    for _ in range(steps + 1):
        residual, matrix = equations(z)
        largest = float(np.abs(residual).max(initial=0.0))
        if not largest < LOST:
            break
        error = largest / size(z)
        stalls = error >= 0.5 * least
        if error < least:
            best, least = z, error
        if least < enough or (stalls and least < SOLVED):
            break
        if fixed is not None:
            change = solved(np.delete(matrix, fixed, axis=1), -residual)
            z = z + np.insert(change, fixed % len(z), 0.0)
        else:
            right = np.append(-residual, dot(normal, guess - z))
            z = z + solved(np.vstack([matrix, normal]), right, weak)
    return best, least, least < SOLVED


class Broyden:
    """Equations with derivatives that are updated by each step (Broyden 1965).

    The matrix is that of the derivatives near the first point, (K, K + 1).
    """

    def __init__(self, residual: Callable[[Floats], Floats], matrix: Floats) -> None:
        self.residual, self.matrix = residual, matrix
        self.last: Floats | None = None

    def __call__(self, z: Floats) -> tuple[Floats, Floats]:
        """Return residuals and derivatives at the next iterate."""
        residual = self.residual(z)
        if self.last is not None:
            step = z - self.last
            # Residuals that overflow end the iteration.
            with np.errstate(over="ignore", invalid="ignore"):
                self.matrix = self.matrix + np.outer(residual, step / dot(step, step))
        self.last = z
        return residual, self.matrix


def tangent_of(matrix: Floats, before: Floats) -> Floats:
    """Return the unit vector along which derivatives vanish, on the side of another vector."""
    direction = solved(np.vstack([matrix, before]), np.append(np.zeros(len(before) - 1), 1.0))
    return np.asarray(direction / norm(direction))


def solved(matrix: Floats, right: Floats, weak: float = 0.0) -> Floats:
    """Solve linear equations; of least norm where they are singular, or weaker than this."""
    if weak == 0.0:
        try:
            return solve_linear(matrix, right)
        except ConvergenceError:
            weak = WEAK
    return least_squares(matrix, right, weak)
