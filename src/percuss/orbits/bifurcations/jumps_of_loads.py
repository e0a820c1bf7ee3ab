"""The instants at which loads on a structure jump, as parts of their common period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.law_columns import REPEAT
from percuss.model.acting_sets import StructureSystem
from percuss.numerics import matmul, solve_linear
from percuss.orbits.bifurcations.force_jumps import ForceJumps

# Jumps nearer than this part of the period are one; pushes below this part of the largest are none.
SAME, LEAST = 1e-9, 1e-12


@dataclass(frozen=True, slots=True)
class JumpsOfLoads:
    """The jumps of all records on a structure.

    Attributes
    ----------
    cycles
        (m,) array, their instants in the common period as parts of it, in order.
    push
        (m, n_stops) array, whether the acceleration of the clearance of a stop jumps with each.
    """

    cycles: Floats
    push: Integers

    @classmethod
    def of(cls, system: StructureSystem) -> Self:
        """Return the jumps of the loads of a system with a common period.

        The order of the instants does not change with a parameter: records whose periods change
        apart have no common one.

        Examples
        --------
        >>> import percuss as pc
        >>> chain = pc.chain([1, 1], [1, 1, 0], stops=(pc.Wall(1, "above", 0.8, on=0),))
        >>> loads = pc.Loads({0: pc.square_wave(1), 1: pc.square_wave(2)}, period=pc.pi_times(2))
        >>> jumps = JumpsOfLoads.of(StructureSystem.of(chain, loads))
        >>> jumps.cycles, jumps.push.ravel()
        (array([0.  , 0.25, 0.5 , 0.75]), array([1, 0, 1, 0]))
        """
        structure, records, period = system.structure, system.records, system.period
        n_stops = len(structure.stops)
        found: list[tuple[float, Integers]] = []
        directions = [
            direction
            for direction, forcing in zip(
                system.loads.directions(structure), system.loads.forcings, strict=True
            )
            if forcing.record is not None
        ]
        for law, direction in zip(records, directions, strict=True):
            jumps = ForceJumps.of(law)
            if not jumps or period is None:
                continue
            along = solve_linear(structure.mass_matrix, direction)
            pushes = np.abs(matmul(structure.stop_directions, along)) if n_stops else np.empty(0)
            pushed = (pushes > LEAST * float(np.abs(along).max())).astype(np.int64)
            for jump in range(len(jumps.knots) * round(period / float(law[0, REPEAT]))):
                cycle = jumps.instant(law, jump) / period % 1.0
                found.append((0.0 if cycle > 1.0 - SAME else cycle, pushed))
        found.sort(key=lambda one: one[0])
        cycles: list[float] = []
        push: list[Integers] = []
        for cycle, pushed in found:
            if cycles and cycle - cycles[-1] < SAME:
                push[-1] = np.maximum(push[-1], pushed)
            else:
                cycles.append(cycle)
                push.append(pushed)
        return cls(np.array(cycles), np.array(push, dtype=np.int64).reshape(-1, n_stops))

    def instant(self, jump: int) -> float:
        """Return the instant of a jump by its number, in periods."""
        turn, k = divmod(jump, len(self.cycles))
        return turn + float(self.cycles[k])

    def passed(self, t: Floats) -> Integers:
        """Return how many jumps lie at or before some instants in periods, from t = 0 on."""
        turns = np.floor(t)
        before = np.searchsorted(self.cycles, t - turns, side="right")
        return np.asarray(turns.astype(np.int64) * len(self.cycles) + before)

    def pushes(self, t: float, stop: int) -> bool:
        """Return whether the jump nearest to an instant pushes on a stop."""
        distance = np.abs((t - self.cycles + 0.5) % 1.0 - 0.5)
        return bool(self.push[int(np.argmin(distance)), stop])
