"""The equations of symmetric orbits: those of the half period after which they are mirrored.

An orbit of a symmetric system that repeats itself mirrored after half a period is told by its
first half. Its multipliers are the squares of those of the map over half a period and a mirror:
where one of these is -1 the symmetry breaks, as a period doubles where one of the others is
(Swift & Wiesenfeld 1984).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError
from percuss.kernels.law import Law
from percuss.kernels.record import Integers
from percuss.numerics import matmul
from percuss.orbits.families.equations import OrbitEquations, Ranges
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["HalfEquations"]

Floats = NDArray[np.float64]

# By how much, scaled, the second half may miss the equations that the first one solves.
MIRRORED = 1e-9


class HalfEquations(OrbitEquations):
    """The equations of the first half of symmetric orbits.

    The unknowns are the instant of the first event and the durations and velocities of the first
    half; after it comes the first event, mirrored.

    Parameters
    ----------
    orbit
        One of them, symmetric.
    ranges
        As for `OrbitEquations`.
    chain
        (2 m, 3) array, all events, where they are not those of the orbit.
    """

    mirror = -1.0

    def __init__(self, orbit: PeriodicOrbit, ranges: Ranges, chain: Integers | None = None) -> None:
        super().__init__(orbit, ranges, chain)
        self.whole = OrbitEquations(orbit, ranges, chain)
        n, m = self.whole.n, self.whole.n // 2
        self.n = m
        self.scale = np.repeat([self.scale[0], self.scale[-1]], [1 + m, m])
        self.rows = np.append(self.rows[: 2 * m], self.rows[-1])
        self.ways = [way for way in self.ways if way[0] < m]
        self.walls = self.walls[:m]
        unit = np.eye(m)
        self._copies = np.zeros((2 * n + 1, 2 * m + 1))
        self._copies[0, 0] = 1.0
        self._copies[1 : 1 + n, 1 : 1 + m] = np.vstack([unit, unit])
        self._copies[1 + n :, 1 + m :] = np.vstack([unit, self.mirror * unit])

    def unknowns_of(self, orbit: PeriodicOrbit) -> Floats:
        """Return the scaled unknowns of an orbit with these events."""
        whole = self.whole.unknowns_of(orbit)
        n = self.whole.n
        return np.concatenate([whole[: 1 + self.n], whole[1 + n : 1 + n + self.n]])

    def shot(self, unknowns: Floats, table: Law) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, under a law."""
        residual, matrix = self.whole.shot(matmul(self._copies, unknowns), table)
        kept = np.append(np.arange(2 * self.n), 4 * self.n)
        return residual[kept], matmul(matrix, self._copies)[kept]

    def orbit_at(self, unknowns: Floats, values: tuple[float, ...]) -> PeriodicOrbit:
        """Return the orbit of a solution.

        Raises
        ------
        ConvergenceError
            If the second half does not mirror the first: the system is not symmetric.
        """
        whole = matmul(self._copies, unknowns)
        residual, _ = self.whole.shot(whole, self.table_at(values))
        apart = float(np.abs(residual).max())
        if apart > MIRRORED:
            what = "the system is not symmetric, and no orbit mirrors itself"
            raise ConvergenceError(what, unknowns, apart, "vary what keeps the symmetry")
        return self.whole.orbit_at(whole, values)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop with which it is met in the first half."""
        return self.whole.into_stops(orbit)[: len(self.ways)]
