"""The families of a structure's orbits: what its search finds, and how each is followed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.loads import Loads
from percuss.model.oscillator import On
from percuss.model.paths import get_parameter, replace_parameters
from percuss.orbits.bifurcations.continue_structure import continue_structure_orbit
from percuss.orbits.bifurcations.structure_branch import StructureBranch, StructureSpecialPoint
from percuss.orbits.bifurcations.structure_switching import switch_structure_branch
from percuss.orbits.continuation.follow import STOPPED
from percuss.orbits.finding.settled import Settled
from percuss.orbits.finding.structure_settled import (
    extremes_of_motion,
    largest_speed,
    returning_orbits,
    settled_structures,
)
from percuss.orbits.orbit.extremes import Extremes
from percuss.orbits.orbit.signature import are_same
from percuss.orbits.orbit.structure_orbit import StructureOrbit, structure_orbit_at
from percuss.orbits.responses.families import Families, SettlingStarts
from percuss.progress import Report

# Longest step, as a part of the range, and most rows each way.
LARGEST_STEP, MAX_POINTS = 0.05, 2000
# A small part of a range, and what a smaller family has on both sides, as a part of its own range.
SMALL, BESIDE = 0.25, 0.25


@dataclass(slots=True, kw_only=True)
class StructureFamilies(Families):
    """The branches of a structure's orbits.

    ``base`` holds the structure and its loads, at any value of the parameter; ``on`` is the
    coordinate, direction or point whose extremes are taken.
    """

    base: StructureSystem
    on: On | None
    branches: list[StructureBranch] = field(default_factory=list)
    left_out: list[tuple[float, StructureOrbit, str]] = field(default_factory=list)
    _known: dict[float, tuple[int, list[tuple[StructureOrbit, int]]]] = field(default_factory=dict)

    def system(self, value: float) -> StructureSystem:
        """Return the system at a value of the parameter."""
        changes = {self.path: value}
        structure, loads, _ = replace_parameters(
            self.base.structure, self.base.loads, None, changes
        )
        return StructureSystem.of(structure, loads)

    def force(self, value: float) -> Loads:
        """Return the loads there."""
        return self.system(value).loads

    def searched(
        self,
        value: float,
        counts: tuple[int, int],
        seed: int,
        report: Report,  # noqa: ARG002
    ) -> Iterator[StructureOrbit]:
        """Return orbits next to motions that almost close, stable or not."""
        yield from returning_orbits(self.system(value), counts[1], seed)

    def in_closed_form(self, value: float, max_periods: int) -> tuple[()]:  # noqa: ARG002
        """Return nothing: no orbit of several masses is known without a search."""
        return ()

    def settled(
        self, value: float, counts: tuple[int, int], starts: SettlingStarts
    ) -> list[Settled]:
        """Return the attractors to which motions settle at a value."""
        return settled_structures(
            self.system(value),
            counts[1],
            self.on,
            n_starts=starts.n,
            seed=starts.seed,
            also=starts.also,
        )

    def without_impacts(self, value: float) -> StructureOrbit | None:
        """Return the orbit to which Newton's method leads from rest, if it meets no stop."""
        system = self.system(value)
        try:
            orbit = structure_orbit_at(system, np.zeros(2 * system.structure.n), 1)
        except PercussError:
            return None
        return orbit if orbit.n_impacts == 0 else None

    def doubled(self, point: StructureSpecialPoint) -> tuple[float, StructureOrbit] | None:
        """Return the first orbit of twice the period."""
        try:
            doubled = switch_structure_branch(point)
        except PercussError:
            # Doubled orbits that the search finds are followed from there.
            return None
        value = as_float(get_parameter(doubled.structure, doubled.loads, None, point.path))
        return (value, doubled) if self.within.low <= value <= self.within.high else None

    def branch_of(self, orbit: StructureOrbit, value: float) -> int | None:
        """Return the number of the branch on which an orbit of this value lies, None if on none."""
        return next(
            (owner for known, owner in self._orbits_at(value) if are_same(orbit, known)), None
        )

    def followed(
        self,
        orbit: StructureOrbit,
        value: float,  # noqa: ARG002
        report: Report,
    ) -> StructureBranch:
        """Follow an orbit over the whole range: all on its branch are motions.

        A family that takes a small part of it is followed again, in steps of that size.
        """
        low, high = self.within.low, self.within.high
        while True:
            branch = continue_structure_orbit(
                orbit,
                {self.path: (low, high)},
                max_points=MAX_POINTS,
                largest_step=LARGEST_STEP,
                progress=report,
            )
            least, most = float(branch.values.min()), float(branch.values.max())
            if most - least >= SMALL * (high - low) or STOPPED in branch.end_reason:
                return branch
            beside = BESIDE * (most - least) or SMALL * (high - low)
            low, high = max(low, least - beside), min(high, most + beside)

    def refusal(self, orbit: StructureOrbit) -> None:  # noqa: ARG002
        """Return None: orbits that stick are followed, too."""
        return

    def slowness(self, orbit: StructureOrbit) -> float:
        """Return the order: short orbits first."""
        return orbit.n_periods

    def extremes(self, orbit: StructureOrbit) -> Extremes:
        """Return the extremes of an orbit's displacement."""
        return extremes_of_motion(orbit.run, self.on)

    def impact_velocities(self, branch: StructureBranch) -> Floats:
        """Return the largest velocity into a stop of each orbit of a branch."""
        return np.array([largest_speed(orbit.run) for orbit in branch.orbits])

    def _orbits_at(self, value: float) -> list[tuple[StructureOrbit, int]]:
        """Return the orbits of all branches at a value, with the branch of each."""
        done, known = self._known.get(value, (0, []))
        for number in range(done, len(self.branches)):
            known += [(orbit, number) for orbit in self._crossings(self.branches[number], value)]
        self._known[value] = len(self.branches), known
        return known

    def _crossings(self, branch: StructureBranch, value: float) -> Iterator[StructureOrbit]:
        """Yield the orbits between neighbouring rows of a branch, at a value of the parameter."""
        system, off = self.system(value), branch.values - value
        between = (off[:-1] * off[1:] < 0.0) | (off[:-1] == 0.0)
        if off[-1] == 0.0 and len(off) > 1:
            between[-1] = True
        for row in np.flatnonzero(between).tolist():
            one, other = branch.orbits[row], branch.orbits[row + 1]
            if not (one.admissible or other.admissible):
                continue
            part = float(off[row] / (off[row] - off[row + 1])) if off[row] != off[row + 1] else 0.0
            a, b = (np.concatenate([orbit.x0, orbit.v0]) for orbit in (one, other))
            try:
                yield structure_orbit_at(system, a + part * (b - a), one.n_periods)
            except ConvergenceError:
                continue
