"""The equations of curves in two parameters: those of an orbit, and one condition.

A curve is the set of zeros of K equations in K + 1 unknowns, the last two of which are the
parameters. Folds, period doublings and symmetry breakings are told by a matrix that becomes
singular, and that by a number g from the bordered system [M b; c' 0] [q; g] = [0; 1] (Govaerts
2000, chapter 3): it vanishes where M is singular, and is as smooth as M, also where an impact has
no velocity.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError
from percuss.kernels.law import Law
from percuss.numerics import directions, dot, matmul, norm
from percuss.orbits.curves.return_equations import return_equations, unknowns_from_events
from percuss.orbits.families.equations import OrbitEquations
from percuss.orbits.families.family import solved
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["CurveEquations", "MultiplierCurve"]

Floats = NDArray[np.float64]
Values = tuple[float, float]

# Scaled residuals of a point: below the second they need not become smaller.
SOLVED, ENOUGH = 1e-12, 1e-13
MOST_STEPS, MOST_TIMES = 14, 3
# Scaled steps of central differences, where h^2 and 1e-16/h are both small, and of one-sided ones.
BESIDE, ASIDE = 1e-5, 1e-7


class CurveEquations(ABC):
    """The equations of a curve; the points are z = (scaled unknowns, two scaled parameters).

    Parameters
    ----------
    equations
        Those of the orbits.
    """

    def __init__(self, equations: OrbitEquations) -> None:
        self.equations = equations
        self._matrix: Floats | None = None

    @property
    def orbits(self) -> OrbitEquations:
        """The equations of the orbits that are told."""
        return self.equations

    @abstractmethod
    def residual(self, z: Floats) -> Floats:
        """Return the scaled residuals, (K,)."""

    @abstractmethod
    def by_unknowns(self, z: Floats) -> Floats:
        """Return their derivatives by all but the two parameters, (K, K - 1)."""

    @abstractmethod
    def orbit(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""

    @abstractmethod
    def conditions(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions whose zeros are points of codimension two."""

    def told(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the orbit of a point with these functions."""
        orbit = self.orbit(z)
        return orbit, self.conditions(z, orbit)

    def condition(self, z: Floats, name: str) -> float:
        """Return one of the functions, which may be cheaper than all of them."""
        return self.told(z)[1][name]

    def pieces(self, a: Floats, b: Floats) -> int:  # noqa: ARG002
        """Return in how many pieces the conditions change sign once at most between two points."""
        return 1

    def settle(self, z: Floats, derivatives: Floats) -> None:  # noqa: ARG002
        """Take a point, with its derivatives, as the one near which the next are looked for."""
        self._matrix = derivatives

    def values(self, z: Floats) -> Values:
        """Return the two parameters of a point."""
        one, other = (self.equations.value_at(k, float(z[k - 2])) for k in range(2))
        return one, other

    def table(self, z: Floats) -> Law:
        """Return the law of a point."""
        return self.equations.table_at(self.values(z))

    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives of the residuals, (K, K + 1); by the parameters as differences.

        They give directions only: what is found does not hang on their last digits.
        """
        here = self.residual(z)
        slopes = [self._slope(z, here, k) for k in (-2, -1)]
        return np.column_stack([self.by_unknowns(z), *slopes])

    def _slope(self, z: Floats, here: Floats, k: int) -> Floats:
        beside = z.copy()
        # Inwards: beyond the range there may be nothing.
        beside[k] += ASIDE if z[k] < 0.5 else -ASIDE
        return np.asarray((self.residual(beside) - here) / (beside[k] - z[k]))

    def tangent(self, derivatives: Floats, before: Floats) -> Floats:
        """Return the unit tangent of a curve with these derivatives, on the side of another."""
        right = np.append(np.zeros(len(before) - 1), 1.0)
        found = solved(np.vstack([derivatives, before]), right)
        return np.asarray(found / norm(found))

    def corrected(self, guess: Floats, normal: Floats) -> Floats:
        """Return the point of the curve in the plane through a guess with this normal.

        Broyden's method, from the derivatives at the settled point, or from new ones.

        Raises
        ------
        ConvergenceError
            If it finds none.
        ParameterError
            If the parameters cannot have the values.
        """
        z, size = guess, np.inf
        if self._matrix is not None:
            z, size = self._improved(guess, guess, np.vstack([self._matrix, normal]))
        for _ in range(MOST_TIMES):
            if size < SOLVED:
                break
            matrix = np.vstack([self.derivatives(z), normal])
            z, size = self._improved(z, guess, matrix)
        if size < SOLVED:
            return z
        raise ConvergenceError("no point of the curve found", guess, size, "take smaller steps")

    def _improved(self, start: Floats, guess: Floats, matrix: Floats) -> tuple[Floats, float]:
        """Return the best iterate of Broyden's method (1965), and what it misses by."""
        normal = matrix[-1].copy()
        z = best = start
        step = np.zeros(len(z))
        least, worse = np.inf, 0
        for k in range(MOST_STEPS):
            residual = np.append(self.residual(z), dot(normal, z - guess))
            size = float(np.abs(residual).max())
            worse += size > 0.5 * least
            if not size < 1e3 * least:
                break
            if size < least:
                best, least = z, size
            if least < ENOUGH or (worse and least < SOLVED) or worse > 2:
                break
            if k:
                matrix = matrix + np.outer(residual, step / dot(step, step))
            step = -solved(matrix, residual)
            z = z + step
        return best, least


class MultiplierCurve(CurveEquations):
    """Orbits with a multiplier of 1 (folds) or -1 (period doublings).

    Over half a period of symmetric orbits, -1 breaks the symmetry.

    Parameters
    ----------
    equations
        Those of the orbits.
    multiplier
        1.0 or -1.0.
    start
        The point at which to begin.
    """

    def __init__(self, equations: OrbitEquations, multiplier: float, start: Floats) -> None:
        super().__init__(equations)
        self.multiplier = multiplier
        self._edge(start)

    def _edge(self, z: Floats) -> None:
        """Take the null vectors at a point as the border of the matrix."""
        returns = self._returns(z[:-2], self.table(z))
        self._border = directions(returns.T)[1][-1], directions(returns)[1][-1]

    def _returns_of(self, matrix: Floats) -> Floats:
        equations = self.equations
        return return_equations(matrix, equations.n, self.multiplier, equations.mirror)

    def _returns(self, unknowns: Floats, table: Law) -> Floats:
        """Return the matrix that is singular at the multiplier."""
        _, matrix = self.equations.shot(unknowns, table)
        return self._returns_of(matrix)

    def settle(self, z: Floats, derivatives: Floats) -> None:
        """Take a point, with its derivatives, as the one near which the next are looked for."""
        left, right = self._null(self._returns(z[:-2], self.table(z)))
        sizes = norm(left), norm(right)
        self._border = left / sizes[0], right / sizes[1]
        matrix = derivatives.copy()
        # With null vectors of size 1 for its border, g changes by their former sizes.
        matrix[2 * self.equations.n + 1] /= sizes[0] * sizes[1]
        super().settle(z, matrix)

    def _bordered(self, returns: Floats) -> tuple[Floats, Floats]:
        """Return the bordered matrix, and the solution (q, g) of its equations."""
        left, right = self._border
        size = len(returns)
        whole = np.zeros((size + 1, size + 1))
        whole[:-1, :-1], whole[:-1, -1], whole[-1, :-1] = returns, left, right
        return whole, solved(whole, np.append(np.zeros(size), 1.0))

    def _null(self, returns: Floats) -> tuple[Floats, Floats]:
        """Return (psi, q), the null vectors of the matrix where it is singular."""
        whole, found = self._bordered(returns)
        return solved(whole.T, np.append(np.zeros(len(returns)), 1.0))[:-1], found[:-1]

    def residual(self, z: Floats) -> Floats:
        """Return those of the orbit, and g."""
        residual, matrix = self.equations.shot(z[:-2], self.table(z))
        returns = self._returns_of(matrix)
        return np.append(residual, self._bordered(returns)[1][-1])

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives: of g, by those of the matrix, -psi' dM q."""
        table, unknowns = self.table(z), z[:-2]
        _, matrix = self.equations.shot(unknowns, table)
        psi, q = self._null(self._returns_of(matrix))
        slopes = []
        for k in range(len(unknowns)):
            unit = np.zeros(len(unknowns))
            unit[k] = 1.0
            slopes.append(-dot(psi, matmul(self._change(unknowns, table, unit), q)))
        return np.vstack([matrix, slopes])

    def _change(self, unknowns: Floats, table: Law, direction: Floats) -> Floats:
        """Return the derivative of the matrix along a direction of the unknowns."""
        ahead, behind = (
            self._returns(unknowns + way * direction, table) for way in (BESIDE, -BESIDE)
        )
        return np.asarray((ahead - behind) / (2.0 * BESIDE))

    def orbit(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        return self.equations.orbit_at(z[:-2], self.values(z))

    def conditions(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return velocities, room to the stops and, of folds, the quadratic coefficient."""
        found = {"passage": min(orbit.grazing_margin, 1e300)}
        for k, speed in enumerate(self.equations.into_stops(orbit)):
            found[f"velocity {k}"] = float(speed)
        if self.multiplier == 1.0:
            found["cusp"] = self._bend(z)
        return found

    def _bend(self, z: Floats) -> float:
        """Return psi' F_uu q q, whose zeros are cusps (Kuznetsov 2004, section 8.2)."""
        unknowns, table = z[:-2], self.table(z)
        psi, q = self._null(self._returns(unknowns, table))
        psi, q = psi / norm(psi), q / norm(q)
        along = unknowns_from_events(q)
        return dot(psi, matmul(self._change(unknowns, table, along), q))
