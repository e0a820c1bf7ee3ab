"""The equations of an orbit as one parameter goes along, and their solutions near a guess."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.law import N_HARMONICS, PERIOD, Law
from percuss.kernels.shooting import shoot
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameter
from percuss.orbits.chain import entries_of, entry, is_wall
from percuss.orbits.making import orbit_of_solution
from percuss.orbits.newton import Solution
from percuss.orbits.periodic_orbit import PeriodicOrbit
from percuss.orbits.steady import steady_orbit

__all__ = ["Family"]

Floats = NDArray[np.float64]

# Scaled residuals of a solution: rounding of a chain is some 1e-15.
SOLVED = 1e-12
MOST_STEPS = 12
# Scaled step of the central difference by the parameter: h^2 and 1e-16/h are both small.
BESIDE = 1e-5
# Where the largest velocity of an orbit is looked for.
INSTANTS = 65
# Singular values below this part of the largest.
WEAK = 1e-7


class Family:
    """The orbits with the events of one orbit, as points z = (scaled unknowns, scaled parameter).

    Parameters
    ----------
    orbit
        One of them.
    path
        Path of the parameter.
    low, high
        Its range; scaled it is from 0 to 1.
    """

    def __init__(self, orbit: PeriodicOrbit, path: str, low: float, high: float) -> None:
        self.oscillator, self.forcing = orbit.oscillator, orbit.forcing
        self.path, self.low, self.high = path, low, high
        self.chain, self.n_periods = orbit._chain, orbit.n_periods
        table = law(orbit.oscillator, orbit.forcing)
        self.shape = table.shape
        self.region = int(orbit._marks[0, 2]) if len(self.chain) == 0 else -1
        n = self.n = len(self.chain)
        run = orbit.trajectory()
        speed = float(np.abs(run(np.linspace(run.t0, run.t_end, INSTANTS))[1]).max()) or 1.0
        self.scale = np.repeat([orbit.period, speed], [1 + n, n]) if n else np.empty(0)
        # Distance, velocity after it and, last, time.
        self.rows = np.array([orbit.period * speed, speed] * n + [orbit.period] * min(n, 1))
        self.ways = [(i, stop, entry(self.oscillator, stop).way)
                     for i, stop in entries_of(self.oscillator, table, self.chain)]  # fmt: skip
        self.walls = is_wall(table, self.chain)
        harmonics = int(table[0, N_HARMONICS])
        self._phases = np.empty((2, harmonics, 2))
        self._tables: dict[float, Law] = {}

    def start(self, orbit: PeriodicOrbit, value: float) -> Floats:
        """Return the point of an orbit."""
        unknowns = orbit._unknowns / self.scale if self.n else np.empty(0)
        return np.append(unknowns, (value - self.low) / (self.high - self.low))

    def value(self, z: Floats) -> float:
        """Return the parameter of a point."""
        part = float(z[-1])
        return self.high if part == 1.0 else self.low + part * (self.high - self.low)

    def system(self, value: float) -> tuple[Oscillator, Forcing | None]:
        """Return what moves, at a value of the parameter."""
        osc, force, _ = replace_parameter(
            self.oscillator, self.forcing, None, self.path, float(value)
        )
        return osc, force

    def table(self, value: float) -> Law:
        """Return the law at a value of the parameter."""
        if value not in self._tables:
            if len(self._tables) > 8:
                self._tables.pop(next(iter(self._tables)))
            table = law(*self.system(value))
            if table.shape != self.shape:
                raise ParameterError(self.path, value, "the stops fall together there")
            self._tables[value] = table
        return self._tables[value]

    def residual(self, z: Floats, value: float) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns."""
        size = 2 * self.n + 1 if self.n else 0
        residual, matrix = np.empty(size), np.empty((size, size))
        if self.n == 0:
            return residual, matrix
        table = self.table(value)
        period = self.n_periods * float(table[0, PERIOD])
        unknowns = z[:-1] * self.scale
        phases, arrival = self._phases
        shoot(table, self.chain, unknowns, period, phases, arrival, residual, matrix)
        return residual / self.rows, matrix * (self.scale / np.reshape(self.rows, (-1, 1)))

    def slope(self, z: Floats, known: float | None = None) -> Floats:
        """Return the derivative of the scaled residuals by the scaled parameter.

        With a value whose law is known already it is a difference from there, of first order.
        """
        if self.n == 0:
            return np.empty(0)
        if known is not None:
            apart = (self.value(z) - known) / (self.high - self.low)
            there, here = self.residual(z, known)[0], self.residual(z, self.value(z))[0]
            return np.asarray((here - there) / apart)
        sides = []
        for q in (z[-1] - BESIDE, z[-1] + BESIDE):
            try:
                sides.append((q, self.residual(z, self.low + q * (self.high - self.low))[0]))
            except ParameterError:
                # On the edge of what the parameter can be: a difference from one side.
                sides.append((float(z[-1]), self.residual(z, self.value(z))[0]))
        (q0, below), (q1, above) = sides
        return np.asarray((above - below) / (q1 - q0))

    def corrected(self, guess: Floats, normal: Floats, *, beside_others: bool = False) -> Floats:
        """Return the point of the family in the plane through a guess with this normal.

        Where another family crosses, the direction to it, which the equations hold weakly, can be
        left as the guess has it.

        Raises
        ------
        ConvergenceError
            If Newton's method finds none.
        ParameterError
            If the parameter cannot have the value.
        """
        z = guess.copy()
        fixed = not normal[:-1].any()
        slope = np.empty(0) if fixed else self.slope(z)
        least = np.inf
        for _ in range(MOST_STEPS):
            residual, matrix = self.residual(z, self.value(z))
            size = float(np.abs(residual).max(initial=0.0))
            if not np.isfinite(size):
                break
            if size < SOLVED and (size >= 0.5 * least or size < 1e-15):
                return z
            least = min(least, size)
            if fixed:
                z[:-1] -= solved(matrix, residual)
            else:
                right = np.append(-residual, normal @ (guess - z))
                z = z + bordered(matrix, slope, normal, right, WEAK if beside_others else 0.0)
        residual, _ = self.residual(z, self.value(z))
        if np.abs(residual).max(initial=0.0) < SOLVED:
            return z
        worst = float(np.abs(residual).max())
        raise ConvergenceError("Newton's method finds no orbit", z, worst, "take smaller steps")

    def tangent(self, z: Floats, before: Floats, known: float | None = None) -> Floats:
        """Return the unit tangent of the family, on the side of an earlier one."""
        _, matrix = self.residual(z, self.value(z))
        slope = self.slope(z, known)
        found = bordered(matrix, slope, before, np.append(np.zeros(len(z) - 1), 1.0))
        return np.asarray(found / np.linalg.norm(found))

    def orbit(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        osc, force = self.system(self.value(z))
        if self.n == 0:
            assert force is not None
            return steady_orbit(osc, force, self.region)
        residual, _ = self.residual(z, self.value(z))
        largest = float(np.abs(residual * self.rows).max())
        solution = Solution(z[:-1] * self.scale, largest, converged=True, isolated=True)
        return orbit_of_solution(osc, force, self.chain, solution, self.n_periods)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop with which it is met; negative ones are formal."""
        return np.array([way * orbit._events[i or self.n, 2] for i, _, way in self.ways])


def bordered(
    matrix: Floats, slope: Floats, normal: Floats, right: Floats, weak: float = 0.0
) -> Floats:
    """Solve the equations and one more, along a normal."""
    n = len(right)
    whole = np.empty((n, n))
    whole[:-1, :-1], whole[:-1, -1], whole[-1] = matrix, slope, normal
    return solved(whole, right, weak)


def solved(matrix: Floats, right: Floats, weak: float = 0.0) -> Floats:
    """Solve linear equations; of least norm where they are singular, or weaker than this."""
    if weak == 0.0:
        try:
            return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
        except np.linalg.LinAlgError:
            weak = WEAK
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=weak)[0], dtype=np.float64)
