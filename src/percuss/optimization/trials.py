"""The motion at each setting of the parameters that a search tries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.paths import replace_parameters
from percuss.model.start import Start
from percuss.model.system import System
from percuss.motion.sensitivity import sensitivity_of
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.optimization.outcomes import AnySensitivity, outcome_of
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.finding.settled import settled_motions
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import orbit_of_solution, solve

__all__ = ["OnOrbit", "OnRun", "Trial"]

# The longest orbits on which a motion is looked for, in impacts and in forcing periods.
MOST_IMPACTS, MOST_PERIODS = 4, 4


@dataclass(frozen=True, eq=False)
class Trial:
    """A motion at a setting, with its outcomes.

    Attributes
    ----------
    values
        The values of the free parameters, by their paths.
    system, start
        Oscillator, forcing and, of a run, the start.
    orbit
        The orbit; None for a run.
    run
        The run; of an orbit one period.
    """

    values: dict[str, float]
    system: System
    start: Start | None
    orbit: PeriodicOrbit | None
    run: Trajectory
    _known: dict[str, tuple[float, Floats]] = field(default_factory=dict, repr=False)

    @cached_property
    def derivative(self) -> AnySensitivity:
        """The derivative of the motion by the free parameters."""
        paths = tuple(self.values)
        if self.orbit is None:
            return sensitivity_of(self.run, paths)
        return self.orbit.sensitivity(paths)

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


class OnRun:
    """Runs from one start, within the same limits."""

    def __init__(self, system: System, start: Start, limits: Mapping[str, Any]) -> None:
        self.system, self.start, self.limits = system, start, dict(limits)

    def first(self, values: Mapping[str, float], n: int, seed: int) -> list[Trial]:  # noqa: ARG002
        """Return the run at a setting, if there is one."""
        trial = self.at(values, None)
        return [] if trial is None else [trial]

    def at(self, values: Mapping[str, float], near: Trial | None) -> Trial | None:  # noqa: ARG002
        """Return the run at a setting, None if the model does not allow that."""
        try:
            osc, force, start = replace_parameters(*self.system, self.start, values)
            run = simulate(osc, force, start=start, **self.limits)
        except ParameterError:
            return None
        return Trial(dict(values), System(osc, force), start, None, run)


class OnOrbit:
    """Attracting orbits; or, where one is given, that orbit, stable or not."""

    def __init__(self, system: System, orbit: PeriodicOrbit | None = None) -> None:
        self.system, self.orbit = system, orbit

    def first(self, values: Mapping[str, float], n: int, seed: int) -> list[Trial]:
        """Return the orbits at a setting: of n motions from rest and at random."""
        if self.orbit is not None:
            trial = self._followed(values, self.orbit)
            return [] if trial is None else [trial]
        system = self._system(values)
        if system is None:
            return []
        return [_trial(values, orbit) for orbit in _attractors(system, n, seed)]

    def at(self, values: Mapping[str, float], near: Trial | None) -> Trial | None:
        """Return the orbit at a setting that goes on from one near by, else the next attractor."""
        assert near is not None
        assert near.orbit is not None
        trial = self._followed(values, near.orbit)
        if trial is not None or self.orbit is not None:
            return trial
        system = self._system(values)
        if system is None:
            return None
        orbits = _attractors(system, 1, 0, (near.orbit.x0, near.orbit.v0))
        return _trial(values, orbits[0]) if orbits else None

    def _system(self, values: Mapping[str, float]) -> System | None:
        try:
            return System(*replace_parameters(*self.system, None, values)[:2])
        except ParameterError:
            return None

    def _followed(self, values: Mapping[str, float], near: PeriodicOrbit) -> Trial | None:
        """Return the orbit with the same events, if there is one and it may be it."""
        system = self._system(values)
        if system is None or not len(near.itinerary):
            return None
        solution = solve(system, near.itinerary)
        if not solution.converged or solution.itinerary.times_covered > 1:
            return None
        orbit = orbit_of_solution(system, solution)
        fits = orbit.admissible and (orbit.is_stable or self.orbit is not None)
        return _trial(values, orbit) if fits else None


def _trial(values: Mapping[str, float], orbit: PeriodicOrbit) -> Trial:
    return Trial(dict(values), orbit.system, None, orbit, orbit.trajectory())


def _attractors(
    system: System, n: int, seed: int, *also: tuple[float, float]
) -> Sequence[PeriodicOrbit]:
    """Return the attracting orbits to which motions settle."""
    if system.period is None:
        try:
            orbit = find_orbit(*system, formal=True)
        except (ConvergenceError, ParameterError):
            return []
        return [orbit] if orbit.is_stable and orbit.admissible else []
    settled = settled_motions(system, MOST_IMPACTS, MOST_PERIODS, n_starts=n, seed=seed, also=also)
    return [motion.orbit for motion in settled if motion.orbit is not None]
