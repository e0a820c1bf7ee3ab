"""The motion at each setting of the parameters that a search tries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, TypeVar, cast

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import record as columns
from percuss.model.acting_sets import StructureSystem
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameters
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.system import System
from percuss.motion.simulate import run_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.optimization.outcomes import AnyOrbit, AnySensitivity, outcome_of
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.finding.settled import settled_motions
from percuss.orbits.finding.structure_settled import settled_structures
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import orbit_of_solution, solve
from percuss.orbits.orbit.steady import regions, steady_orbit
from percuss.orbits.orbit.structure_orbit import (
    StructureOrbit,
    find_structure_orbit,
    structure_orbit_at,
)

AnOrbit = TypeVar("AnOrbit", PeriodicOrbit, StructureOrbit)

# The longest orbits on which a motion is looked for, in impacts and in forcing periods.
MOST_IMPACTS, MOST_PERIODS = 4, 4


@dataclass(frozen=True, eq=False)
class Trial:
    """A motion at a setting, with its outcomes.

    Attributes
    ----------
    values
        The values of the free parameters, by their paths.
    model, force, start
        The oscillator and its forcing, or the structure and its loads; of a run the start.
    orbit
        The orbit; None for a run.
    run
        The run; of an orbit one period.
    goes_on
        Whether the motion near by goes on to it; else it is that of another attractor.
    """

    values: dict[str, float]
    model: Oscillator | Structure
    force: Forcing | Loads | None
    start: Start | StructureStart | None
    orbit: AnyOrbit | None
    run: Trajectory | StructureTrajectory
    goes_on: bool = True
    _known: dict[str, tuple[float, Floats]] = field(default_factory=dict, repr=False)

    @cached_property
    def derivative(self) -> AnySensitivity:
        """The derivative of the motion by the free parameters."""
        paths = tuple(self.values)
        return (self.run if self.orbit is None else self.orbit).sensitivity(paths)

    def outcome(self, name: str) -> tuple[float, Floats]:
        """Return an outcome and its derivatives.

        Raises
        ------
        ConvergenceError
            If an orbit has no derivative there.
        """
        if name not in self._known:
            self._known[name] = outcome_of(self.orbit, self.derivative, name)
        return self._known[name]

    def ends(self) -> list[tuple[float, Floats]]:
        """Return the numbers that are zero where its attractor ends, with their derivatives.

        The distance from a graze, and that of the largest multiplier from 1; none of a run.
        """
        if self.orbit is None:
            return []
        size, slope = self.outcome("multiplier")
        margin = [self.outcome("grazing_margin")] if isinstance(self.orbit, PeriodicOrbit) else []
        return [*margin, (1.0 - size, -slope)]


class OnRun:
    """Runs from one start, within the same limits."""

    def __init__(
        self,
        model: Oscillator | Structure,
        force: Forcing | Loads | None,
        start: Start | StructureStart,
        limits: Mapping[str, Any],
    ) -> None:
        self.model, self.force, self.start, self.limits = model, force, start, dict(limits)

    def first(self, values: Mapping[str, float], n: int, seed: int) -> list[Trial]:  # noqa: ARG002
        """Return the run at a setting, if there is one."""
        trial = self.at(values, None)
        return [] if trial is None else [trial]

    def at(self, values: Mapping[str, float], near: Trial | None) -> Trial | None:  # noqa: ARG002
        """Return the run at a setting, None if the model does not allow that."""
        try:
            moved = replace_parameters(self.model, self.force, self.start, values)
            run = run_of(*moved, **self.limits)
        except ParameterError:
            return None
        return Trial(dict(values), *moved, None, run)


class _OnOrbits(Generic[AnOrbit]):
    """Attracting orbits; or, where one is given, that orbit with its events, stable or not."""

    orbit: AnOrbit | None

    def first(self, values: Mapping[str, float], n: int, seed: int) -> list[Trial]:
        """Return the orbits at a setting: of n motions from rest and at random."""
        if self.orbit is not None:
            trial = self._followed(values, self.orbit)
            return [] if trial is None else [trial]
        return [_trial(values, orbit) for orbit in self._attractors(values, n, seed)]

    def at(self, values: Mapping[str, float], near: Trial | None) -> Trial | None:
        """Return the orbit at a setting that goes on from one near by, else the next attractor."""
        assert near is not None
        orbit = cast("AnOrbit", near.orbit)
        trial = self._followed(values, orbit)
        if trial is not None or self.orbit is not None:
            return trial
        state = tuple(np.ravel([orbit.x0, orbit.v0]).tolist())
        return _next(values, self._attractors(values, 1, 0, state), orbit)

    def _followed(self, values: Mapping[str, float], near: AnOrbit) -> Trial | None:
        """Return the orbit that goes on from another, if there is one and it may be it."""
        raise NotImplementedError

    def _attractors(
        self, values: Mapping[str, float], n: int, seed: int, *also: Any
    ) -> Sequence[AnOrbit]:
        """Return the attracting orbits to which motions settle."""
        raise NotImplementedError


class OnOrbit(_OnOrbits[PeriodicOrbit]):
    """Orbits of an oscillator."""

    def __init__(self, system: System, orbit: PeriodicOrbit | None = None) -> None:
        self.system, self.orbit = system, orbit

    def _system(self, values: Mapping[str, float]) -> System | None:
        try:
            return System(*replace_parameters(*self.system, None, values)[:2])
        except ParameterError:
            return None

    def _followed(self, values: Mapping[str, float], near: PeriodicOrbit) -> Trial | None:
        system = self._system(values)
        orbit = None if system is None else _with_events_of(near, system)
        if orbit is None or not orbit.admissible:
            return None
        return _trial(values, orbit) if orbit.is_stable or self.orbit is not None else None

    def _attractors(
        self, values: Mapping[str, float], n: int, seed: int, *also: Any
    ) -> Sequence[PeriodicOrbit]:
        system = self._system(values)
        if system is None:
            return []
        if system.period is None:
            try:
                orbit = find_orbit(*system, formal=True)
            except (ConvergenceError, ParameterError):
                return []
            return [orbit] if orbit.is_stable and orbit.admissible else []
        counts = MOST_IMPACTS, MOST_PERIODS
        settled = settled_motions(system, *counts, n_starts=n, seed=seed, also=also)
        return [motion.orbit for motion in settled if motion.orbit is not None]


class OnStructureOrbit(_OnOrbits[StructureOrbit]):
    """Orbits of a structure."""

    def __init__(
        self, structure: Structure, loads: Loads, orbit: StructureOrbit | None = None
    ) -> None:
        self.structure, self.loads, self.orbit = structure, loads, orbit

    def _system(self, values: Mapping[str, float]) -> StructureSystem | None:
        try:
            structure, loads, _ = replace_parameters(self.structure, self.loads, None, values)
            return StructureSystem.of(structure, loads)
        except ParameterError:
            return None

    def _followed(self, values: Mapping[str, float], near: StructureOrbit) -> Trial | None:
        system = self._system(values)
        if system is None:
            return None
        state = np.concatenate([near.x0, near.v0])
        try:
            orbit = structure_orbit_at(system, state, near.n_periods)
        except PercussError:
            return None
        fits = _events(orbit) == _events(near) if self.orbit is not None else orbit.is_stable
        return _trial(values, orbit) if fits else None

    def _attractors(
        self, values: Mapping[str, float], n: int, seed: int, *also: Any
    ) -> Sequence[StructureOrbit]:
        system = self._system(values)
        if system is None:
            return []
        settled = settled_structures(system, MOST_PERIODS, 0, n_starts=n, seed=seed, also=also)
        orbits = [motion.orbit for motion in settled if motion.orbit is not None]
        if not orbits and not also:
            # A motion that has not settled yet may be near the orbit that attracts it.
            try:
                orbit = find_structure_orbit(system.structure, system.loads)
            except PercussError:
                return []
            orbits = [orbit] if orbit.is_stable else []
        return orbits


def _events(orbit: AnyOrbit) -> list[list[int]]:
    """Return the kinds and the stops of an orbit's events."""
    marks = orbit.run.record.marks if isinstance(orbit, StructureOrbit) else orbit.record[1]
    events: list[list[int]] = marks[1:, [columns.KIND, columns.BOUND]].tolist()
    return events


def _trial(values: Mapping[str, float], orbit: AnyOrbit, *, goes_on: bool = True) -> Trial:
    if isinstance(orbit, StructureOrbit):
        return Trial(dict(values), orbit.structure, orbit.loads, None, orbit, orbit.run, goes_on)
    return Trial(dict(values), *orbit.system, None, orbit, orbit.trajectory(), goes_on)


def _with_events_of(near: PeriodicOrbit, system: System) -> PeriodicOrbit | None:
    """Return the orbit with the events of another, admissible or not; None if none is found."""
    if near.n_impacts == 0:
        region = int(near.record[1][0, columns.NEXT_REGION])
        try:
            return steady_orbit(system, region) if region in regions(system.law) else None
        except ConvergenceError:
            return None
    if not len(near.itinerary):
        return None
    solution = solve(system, near.itinerary)
    if not solution.converged or solution.itinerary.times_covered > 1:
        return None
    return orbit_of_solution(system, solution)


def _next(values: Mapping[str, float], orbits: Sequence[AnyOrbit], near: AnyOrbit) -> Trial | None:
    """Return the first attractor; one with as many events of each kind goes on from that near by."""
    if not orbits:
        return None
    own, other = ((orbit.n_periods, sorted(_events(orbit))) for orbit in (orbits[0], near))
    return _trial(values, orbits[0], goes_on=own == other)
