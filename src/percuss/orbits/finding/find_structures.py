"""All periodic orbits of a structure that shooting from many starts finds."""

from __future__ import annotations

import math
from itertools import islice

import numpy as np

from percuss.errors import ParameterError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import whole
from percuss.model.loads import loads_of
from percuss.model.structure import Structure
from percuss.orbits.finding.found import (
    ENOUGH,
    FoundOrbits,
    check_effort,
    estimate_unseen,
)
from percuss.orbits.finding.structure_settled import (
    orbits_from_start,
    primitive_orbit,
    random_starts,
)
from percuss.orbits.orbit.signature import are_same
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.progress import Progress, Report

# Motions of a batch.
BATCH = 10


def find_structure_orbits(
    structure: Structure,
    loads: object,
    max_impacts: int = 3,
    max_periods: int = 4,
    seed: int = 0,
    *,
    formal: bool = False,
    effort: float = 1.0,
    progress: Report = None,
) -> FoundOrbits[StructureOrbit]:
    """Find all periodic orbits of a structure that a search from random starts finds, each once.

    The parameters are those of `percuss.find_orbits`, except ``formal``: Newton's method on the map
    over the period of the loads follows motions, of which none passes through a wall.

    Raises
    ------
    ParameterError
        If the loads have no common period, a number is out of range, or formal orbits are asked
        for.
    """
    max_impacts, max_periods = (
        whole("max_impacts", max_impacts, 1),
        whole("max_periods", max_periods, 1),
    )
    if formal:
        reason = "of a structure only orbits that are motions are searched for"
        raise ParameterError("formal", formal, reason)
    fewest, most = check_effort(effort)
    system = StructureSystem.of(structure, loads_of(structure, loads))
    search = _StructureSearch(system, max_impacts)
    # Without a stop that acts Newton's method is there at once.
    search.add(primitive_orbit(system, np.zeros(2 * structure.n), 1), None)
    n_starts = most * BATCH if structure.stops else 0
    work = Progress(progress, n_starts, "starts done")
    estimate = math.nan if n_starts else 0.0
    starts = islice(random_starts(system, seed), n_starts)
    for trial, state in enumerate(starts):
        for orbit in orbits_from_start(system, state, max_periods):
            search.add(orbit, trial)
        is_stopped = not work.advance()
        batches, left = divmod(trial + 1, BATCH)
        if batches >= fewest and left == 0:
            estimate = search.unseen()
        if is_stopped or estimate < ENOUGH:
            break
    work.close()
    search.orbits.sort(key=_order)
    return FoundOrbits(search.orbits, estimate, int(work.done))


class _StructureSearch:
    """The orbits found so far, and the starts that led to each."""

    def __init__(self, system: StructureSystem, max_impacts: int) -> None:
        self.system, self.max_impacts = system, max_impacts
        self.orbits: list[StructureOrbit] = []
        self._seen: list[tuple[StructureOrbit, set[int]]] = []

    def add(self, orbit: StructureOrbit | None, trial: int | None) -> None:
        """Count an orbit that a start led to, None for no start, and keep it if it is new."""
        if orbit is None:
            return
        trials = next((seen for known, seen in self._seen if are_same(orbit, known)), None)
        if trials is None:
            trials = set()
            self._seen.append((orbit, trials))
            if self._is_wanted(orbit):
                self.orbits.append(orbit)
        if trial is not None:
            trials.add(trial)

    def unseen(self) -> float:
        """Return the estimate of how many orbits of the wanted kind no start has led to."""
        wanted = set(map(id, self.orbits))
        return estimate_unseen(
            len(trials) for orbit, trials in self._seen if id(orbit) in wanted and trials
        )

    def _is_wanted(self, orbit: StructureOrbit) -> bool:
        return orbit.n_impacts <= self.max_impacts or len(orbit.run.contacts) > 0


def _order(orbit: StructureOrbit) -> tuple[int, int, bool, float]:
    return orbit.n_periods, orbit.n_impacts, not orbit.is_stable, -float(orbit.x0[0])
