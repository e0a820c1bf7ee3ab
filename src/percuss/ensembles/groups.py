"""Motions whose laws have one shape, or systems one structure, followed together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.batch import BatchResult, Plan, follow_batch
from percuss.ensembles.repetition import counting_period, counting_periods
from percuss.ensembles.structure_batch import follow_structures
from percuss.kernels import law_columns as at
from percuss.model.acting_sets import StructureSystem, within_walls
from percuss.model.system import region_rows


@dataclass(frozen=True, slots=True)
class Group:
    """The laws and starts of some points whose laws have one shape.

    Attributes
    ----------
    laws, which, starts
        As `follow_batch` takes them.
    rows
        (n,) array, their points, counted from the first one asked for.
    stops
        (n_laws, n_stops, columns) array, as `follow_batch` takes it; None where it is not needed.
    """

    laws: Floats
    which: Integers
    starts: Floats
    rows: Integers
    stops: Floats | None = None

    @property
    def is_forced(self) -> bool:
        """Whether the motions have a forcing with a period."""
        return bool(self.laws[0, 0, at.PERIOD] > 0.0)

    @property
    def periods(self) -> Floats:
        """(n,) array, the time in which each motion is counted [time]: the forcing's period."""
        return counting_periods(self.laws, self.which)

    def follow(self, plan: Plan) -> BatchResult:
        """Follow all motions to the end of a plan."""
        return follow_batch(self.laws, self.which, self.starts, plan, self.stops)

    def within_walls(self, state: Floats) -> Floats:
        """Return x and v of a state, at the wall of the first law where that has moved past it."""
        low, high = walls_of(self.laws)
        return np.array([min(max(state[0], low[0]), high[0]), state[1]])

    def beginning(self, rows: Integers, starts: Floats) -> Group:
        """Return some of the motions, from other starts."""
        return replace(self, which=self.which[rows], starts=starts, rows=self.rows[rows])


@dataclass(frozen=True, slots=True)
class StructureGroup:
    """The systems and starts of some points of a structure.

    Attributes
    ----------
    systems
        The structures under their loads.
    which, starts, on
        As `follow_structures` takes them.
    rows
        (n,) array, their points, counted from the first one asked for.
    """

    systems: tuple[StructureSystem, ...]
    which: Integers
    starts: Floats
    rows: Integers
    on: Floats

    @property
    def is_forced(self) -> bool:
        """Whether the motions have loads with a period."""
        return self.systems[0].period is not None

    @property
    def periods(self) -> Floats:
        """(n,) array, the time in which each motion is counted [time]: the loads' period."""
        return np.array([counting_period(system) for system in self.systems])[self.which]

    def follow(self, plan: Plan) -> BatchResult:
        """Follow all motions to the end of a plan."""
        return follow_structures(self.systems, self.which, self.starts, plan, self.on)

    def within_walls(self, state: Floats) -> Floats:
        """Return x and v of a state, at the walls of the first system that have moved past it."""
        return within_walls(self.systems[0].structure, state)

    def beginning(self, rows: Integers, starts: Floats) -> StructureGroup:
        """Return some of the motions, from other starts."""
        return replace(self, which=self.which[rows], starts=starts, rows=self.rows[rows])


AnyGroup: TypeAlias = Group | StructureGroup


def walls_of(laws: Floats) -> tuple[Floats, Floats]:
    """Return the places of the walls of laws, (n,) arrays, infinite where there is none.

    Parameters
    ----------
    laws
        (n, rows, columns) array of laws of one shape.
    """
    rows = region_rows(laws[0])
    lowest, highest = laws[:, rows[0]], laws[:, rows[-1]]
    low = np.where(lowest[:, at.LOWER_KIND] == at.WALL, lowest[:, at.LOWER], -np.inf)
    high = np.where(highest[:, at.UPPER_KIND] == at.WALL, highest[:, at.UPPER], np.inf)
    return low, high
