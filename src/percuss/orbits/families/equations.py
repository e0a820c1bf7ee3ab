"""The equations of an orbit, scaled, at any values of some parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.kernels.law import N_HARMONICS, PERIOD, Law
from percuss.kernels.record import Integers
from percuss.kernels.shooting import ShootingProblem, shoot
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import get_parameter, replace_parameters
from percuss.orbits.orbit.chain import entries_of, entry, is_wall
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_orbit

__all__ = ["OrbitEquations", "Ranges"]

Floats = NDArray[np.float64]
Ranges = Mapping[str, tuple[float, float]]

# Where the largest velocity of an orbit is looked for.
INSTANTS = 65
# Systems and laws that are kept: the differences by two parameters take five.
LAWS = 8


class OrbitEquations:
    """The equations of all orbits with the events of one, over some parameters.

    Parameters
    ----------
    orbit
        One of them.
    ranges
        Lowest and highest value of each parameter by its path; scaled it is from 0 to 1.
    chain
        (n, 3) array, the events, where they are not those of the orbit.

    Attributes
    ----------
    own_values
        Those of the orbit.
    n
        How many events there are; 0 for steady motion in one region, which needs no equations.
    scale, rows
        (2 n + 1,) arrays, units of the unknowns and of the residuals; empty without events.
    ways
        (row of the chain, stop, sign of the velocity before) of the events that meet a stop.
    walls
        Which events are impacts on walls.
    mirror
        What the velocities are multiplied with when the events begin anew.
    """

    mirror = 1.0

    def __init__(self, orbit: PeriodicOrbit, ranges: Ranges, chain: Integers | None = None) -> None:
        self.oscillator, self.forcing = orbit.oscillator, orbit.forcing
        self.paths = tuple(ranges)
        self.lows = tuple(low for low, _ in ranges.values())
        self.highs = tuple(high for _, high in ranges.values())
        self.chain = orbit._chain if chain is None else chain
        self.n_periods = orbit.n_periods
        own = (get_parameter(self.oscillator, self.forcing, None, path) for path in self.paths)
        self.own_values = tuple(as_float(value) for value in own)
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
        self._systems: dict[tuple[float, ...], tuple[Oscillator, Forcing | None]] = {}
        self._tables: dict[tuple[float, ...], Law] = {}

    def unknowns_of(self, orbit: PeriodicOrbit) -> Floats:
        """Return the scaled unknowns of an orbit with these events."""
        return orbit._unknowns / self.scale if self.n else np.empty(0)

    def value_at(self, k: int, part: float) -> float:
        """Return the value of the k-th parameter at a scaled one; at 1 it is the highest."""
        low, high = self.lows[k], self.highs[k]
        return high if part == 1.0 else low + part * (high - low)

    def part_of(self, k: int, value: float) -> float:
        """Return the scaled value of the k-th parameter."""
        return (value - self.lows[k]) / (self.highs[k] - self.lows[k])

    def system_at(self, values: tuple[float, ...]) -> tuple[Oscillator, Forcing | None]:
        """Return what moves, at values of the parameters."""
        if values not in self._systems:
            if len(self._systems) > LAWS:
                self._systems.pop(next(iter(self._systems)))
            changes = {path: float(value) for path, value in zip(self.paths, values, strict=True)}
            osc, force, _ = replace_parameters(self.oscillator, self.forcing, None, changes)
            self._systems[values] = osc, force
        return self._systems[values]

    def table_at(self, values: tuple[float, ...]) -> Law:
        """Return the law at values of the parameters."""
        if values not in self._tables:
            if len(self._tables) > LAWS:
                self._tables.pop(next(iter(self._tables)))
            table = law(*self.system_at(values))
            if table.shape != self.shape:
                given = values[0] if len(values) == 1 else values
                raise ParameterError(", ".join(self.paths), given, "the stops fall together there")
            self._tables[values] = table
        return self._tables[values]

    def shot(self, unknowns: Floats, table: Law) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, under a law."""
        size = 2 * self.n + 1 if self.n else 0
        residual, matrix = np.empty(size), np.empty((size, size))
        if self.n == 0:
            return residual, matrix
        period = self.n_periods * float(table[0, PERIOD])
        problem = ShootingProblem(table, self.chain, period, *self._phases)
        # A step that goes astray may overflow: the residual tells.
        with np.errstate(over="ignore", invalid="ignore"):
            given = unknowns * self.scale
            shoot(problem, given, residual, matrix)
            return residual / self.rows, matrix * (self.scale / np.reshape(self.rows, (-1, 1)))

    def orbit_at(self, unknowns: Floats, values: tuple[float, ...]) -> PeriodicOrbit:
        """Return the orbit of a solution."""
        osc, force = self.system_at(values)
        if self.n == 0:
            assert force is not None
            return steady_orbit(osc, force, self.region)
        residual, _ = self.shot(unknowns, self.table_at(values))
        largest = float(np.abs(residual * self.rows).max())
        solution = Solution(unknowns * self.scale, largest, converged=True, isolated=True)
        return orbit_of_solution(osc, force, self.chain, solution, self.n_periods)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop with which it is met; negative ones are formal."""
        return np.array([way * orbit._events[i or self.n, 2] for i, _, way in self.ways])
