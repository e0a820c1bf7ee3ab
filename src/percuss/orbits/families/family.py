"""The equations of an orbit as one parameter goes along, and their solutions near a guess."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.flight import acceleration_and_jerk, constant_force, set_phases
from percuss.kernels.law import N_HARMONICS, Law
from percuss.kernels.shooting import AT, place
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.numerics import dot, least_squares, norm, solve_linear
from percuss.orbits.families.corners import stop_that_is_moved
from percuss.orbits.families.equations import OrbitEquations
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Family", "bordered", "solved"]

Floats = NDArray[np.float64]

# Scaled residuals of a solution, as a part of its own size: rounding of a chain is some 1e-15.
SOLVED = 1e-12
# Residuals that are rounded by more than the orbit is large: no step from there leads anywhere,
# though it may lead back where an unknown enters linearly and its digits cancel by chance.
LOST = 2.0**52
# Where another family crosses Newton's method gains a factor of two a step only.
MOST_STEPS, MOST_BESIDE_OTHERS = 12, 40
# Scaled step of the central difference by the parameter: h^2 and 1e-16/h are both small.
BESIDE = 1e-5
# Singular values below this part of the largest.
WEAK = 1e-7
# Scaled durations that a special point, located to some 1e-12, leaves of no time.
NO_TIME = 1e-6


class Family(OrbitEquations):
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
        super().__init__(orbit, {path: (low, high)})
        self.path, self.low, self.high = path, low, high
        moved = stop_that_is_moved(path)
        stops = enumerate(self.oscillator.stops)
        self._others = [] if moved is None else [as_float(s.at) for k, s in stops if k != moved]
        ends = np.roll(self.chain[:, AT], -1)
        self._returning = [i for i in range(self.n) if self.chain[i, AT] == ends[i]]
        self._hops = [i for i in self._returning if self.walls[i] and self.walls[(i + 1) % self.n]]

    def start(self, orbit: PeriodicOrbit, value: float) -> Floats:
        """Return the point of an orbit."""
        return np.append(self.unknowns_of(orbit), self.part_of(0, value))

    def value(self, z: Floats) -> float:
        """Return the parameter of a point."""
        return self.value_at(0, float(z[-1]))

    def system(self, value: float) -> tuple[Oscillator, Forcing | None]:
        """Return what moves, at a value of the parameter."""
        return self.system_at((float(value),))

    def table(self, value: float) -> Law:
        """Return the law at a value of the parameter."""
        return self.table_at((float(value),))

    def residual(self, z: Floats, value: float) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns.

        Distances that a flight misses the bound by that it comes from are told by its duration,
        as a mean velocity: so the equations stay regular where it lasts no time, at a graze or
        where two impacts fall together, and no flight of no time solves them by itself.
        """
        if self.n == 0:
            return np.empty(0), np.empty((0, 0))
        table = self.table(value)
        residual, matrix = self.shot(z[:-1], table)
        if self._returning:
            self._tell_by_duration(table, z, residual, matrix)
        return residual, matrix

    def _tell_by_duration(self, table: Law, z: Floats, residual: Floats, matrix: Floats) -> None:
        """Divide the distances by which flights miss the bound that they come from by durations."""
        # A step that goes astray may overflow; then Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for i in self._returning:
                lasting = float(z[1 + i])
                if lasting == 0.0:
                    # The limit: the velocity at the start, and half the acceleration.
                    residual[2 * i] = z[1 + self.n + i]
                    matrix[2 * i] = 0.0
                    matrix[2 * i, 1 + i] = 0.5 * self._acceleration(table, z, i)
                    matrix[2 * i, 1 + self.n + i] = 1.0
                    continue
                residual[2 * i] /= lasting
                matrix[2 * i] /= lasting
                matrix[2 * i, 1 + i] -= residual[2 * i] / lasting

    def _acceleration(self, table: Law, z: Floats, i: int) -> float:
        """Return the scaled acceleration at the start of a flight."""
        bound, _, region = self.chain[i].tolist()
        phases = np.empty((int(table[0, N_HARMONICS]), 2))
        set_phases(table, float(z[: 1 + i].sum()) * self.scale[0], 0.0, phases)
        force = constant_force(table, region, place(table, region, bound))
        v = float(z[1 + self.n + i]) * self.scale[-1]
        found, _ = acceleration_and_jerk(table, region, force, phases, 0.0, v)
        return float(found * self.scale[0] / self.scale[-1])

    def turns_back(self, here: Floats, found: Floats) -> list[int]:
        """Return the flights between impacts that last less than no time at the second point only.

        Such a flight is no motion: the impacts at its ends have fallen together on the way.
        """
        return [i for i in self._hops if here[1 + i] >= -NO_TIME > found[1 + i]]

    def is_together(self, z: Floats, flights: list[int]) -> bool:
        """Tell whether one of some flights lasts no time."""
        return bool(np.abs(z[[1 + i for i in flights]]).min() < NO_TIME)

    def slope(self, z: Floats, known: float | None = None) -> Floats:
        """Return the derivative of the scaled residuals by the scaled parameter.

        With a value whose law is known already it is a difference from there, of first order.
        """
        if self.n == 0:
            return np.empty(0)
        if known is not None:
            apart = (self.value(z) - known) / (self.high - self.low)
            there, here = self.residual(z, known)[0], self.residual(z, self.value(z))[0]
            with np.errstate(over="ignore", invalid="ignore"):
                return np.asarray((here - there) / apart)
        sides = []
        # Not past another stop: there the order of stops is another one.
        others = (abs(self.part_of(0, at) - float(z[-1])) for at in self._others)
        apart = min([BESIDE, *(0.5 * room for room in others if room > 0.0)])
        for q in (z[-1] - apart, z[-1] + apart):
            try:
                sides.append((q, self.residual(z, self.low + q * (self.high - self.low))[0]))
            except ParameterError:
                # On the edge of what the parameter can be: a difference from one side.
                sides.append((float(z[-1]), self.residual(z, self.value(z))[0]))
        (q0, below), (q1, above) = sides
        # Where they are not finite Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore"):
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
        for _ in range(MOST_BESIDE_OTHERS if beside_others else MOST_STEPS):
            residual, matrix = self.residual(z, self.value(z))
            size = float(np.abs(residual).max(initial=0.0))
            if not size < LOST:
                break
            if size < SOLVED * self.size(z) and (size >= 0.5 * least or size < 1e-15):
                return z
            least = min(least, size)
            if fixed:
                z[:-1] -= solved(matrix, residual)
            else:
                right = np.append(-residual, dot(normal, guess - z))
                z = z + bordered(matrix, slope, normal, right, WEAK if beside_others else 0.0)
        residual, _ = self.residual(z, self.value(z))
        worst = float(np.abs(residual).max(initial=0.0))
        if worst < SOLVED * self.size(z):
            return z
        raise ConvergenceError("Newton's method finds no orbit", z, worst, "take smaller steps")

    def tangent(self, z: Floats, before: Floats, known: float | None = None) -> Floats:
        """Return the unit tangent of the family, on the side of an earlier one."""
        _, matrix = self.residual(z, self.value(z))
        slope = self.slope(z, known)
        found = bordered(matrix, slope, before, np.append(np.zeros(len(z) - 1), 1.0))
        return np.asarray(found / norm(found))

    def size(self, z: Floats) -> float:
        """Return how much larger the velocities are than those of the first orbit, at least 1."""
        return max(1.0, float(np.abs(z[1 + self.n : -1]).max(initial=0.0)))

    def orbit(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        return self.orbit_at(z[:-1], (self.value(z),))


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
            return solve_linear(matrix, right)
        except ConvergenceError:
            weak = WEAK
    return least_squares(matrix, right, weak)
