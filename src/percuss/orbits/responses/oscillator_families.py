"""The families of an oscillator's orbits: what its search finds, and how each is followed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.paths import get_parameter, replace_parameter
from percuss.model.system import System
from percuss.orbits.bifurcations.branch import Branch, largest_velocities
from percuss.orbits.bifurcations.continue_orbit import continue_orbit
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.bifurcations.switching import switch_branch
from percuss.orbits.finding.find import find_orbits
from percuss.orbits.finding.found import FoundOrbits
from percuss.orbits.finding.refine_guess import Known
from percuss.orbits.finding.settled import Settled, settled_motions
from percuss.orbits.finding.single_impact import has_closed_form, single_impact_orbits
from percuss.orbits.orbit.extremes import Extremes, extremes_of
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import solve
from percuss.orbits.orbit.steady import free_region, steady_orbit
from percuss.orbits.responses.families import Families, SettlingStarts
from percuss.progress import Report

# Half the width of the first stretch in which an orbit is followed, as a part of the range.
FIRST_WIDTH = 0.04
# Most rows each way: a family that takes more continues among formal orbits.
MAX_POINTS = 800
# Longest steps, as parts of a stretch; without impacts no unknown tells how a resonance bends.
LARGEST_STEP, SMALL_STEP = 0.02, 0.002


@dataclass(slots=True, kw_only=True)
class OscillatorFamilies(Families):
    """The branches of an oscillator's orbits.

    ``base`` holds oscillator and forcing, at any value of the parameter.
    """

    base: System
    branches: list[Branch] = field(default_factory=list)
    left_out: list[tuple[float, PeriodicOrbit, str]] = field(default_factory=list)
    _known: dict[float, tuple[Known, int, list[int]]] = field(default_factory=dict)

    def system(self, value: float) -> System:
        """Return the system at a value of the parameter."""
        osc, force, _ = replace_parameter(*self.base, None, self.path, value)
        return System(osc, force)

    def branch_of(self, orbit: PeriodicOrbit, value: float) -> int | None:
        """Return the number of the branch on which an orbit of this value lies, None if on none."""
        known, owners = self._orbits_at(value)
        if orbit.n_impacts == 0:
            region = int(orbit.record[1][0, 2])
            for i, branch in enumerate(self.branches):
                is_alike = (branch[0].n_impacts, branch[0].record[1][0, 2]) == (0, region)
                if is_alike and _reaches(branch, value):
                    return i
            return None
        signature = known.signature(orbit.itinerary, isolated=orbit.isolated)
        for other, owner in zip(known.signatures, owners, strict=True):
            if signature.matches(other):
                return owner
        return None

    def force(self, value: float) -> Forcing | None:
        """Return the forcing there."""
        return self.system(value).forcing

    def searched(
        self, value: float, counts: tuple[int, int], seed: int, report: Report
    ) -> FoundOrbits[PeriodicOrbit] | tuple[()]:
        """Return what `find_orbits` finds; without stops there is nothing to search for."""
        osc, force = self.system(value)
        return find_orbits(osc, force, *counts, seed, progress=report) if osc.stops else ()

    def in_closed_form(self, value: float, max_periods: int) -> Iterator[PeriodicOrbit]:
        """Yield the physical orbits with one impact on a wall, which need no search."""
        system = self.system(value)
        osc, force = system
        assert force is not None
        for stop in range(len(osc.stops)):
            if has_closed_form(system, stop):
                for n_periods in range(1, max_periods + 1):
                    orbits = single_impact_orbits(osc, force, n_periods, stop)
                    yield from (orbit for orbit in orbits if orbit.admissible)

    def settled(
        self, value: float, counts: tuple[int, int], starts: SettlingStarts
    ) -> list[Settled]:
        """Return the attractors to which motions settle at a value."""
        pairs = [(x, v) for x, v in starts.also]
        return settled_motions(
            self.system(value), *counts, n_starts=starts.n, seed=starts.seed, also=pairs
        )

    def without_impacts(self, value: float) -> PeriodicOrbit | None:
        """Return the linear response, in which no stop acts; formal where it is too large."""
        system = self.system(value)
        region = free_region(system)
        if region is None:
            raise LookupError
        try:
            return steady_orbit(system, region)
        except ConvergenceError:
            # At resonance without damping there is none, but at other values.
            return None

    def doubled(self, point: SpecialPoint) -> tuple[float, PeriodicOrbit] | None:
        """Return the first orbit of twice the period, if it is physical."""
        if not point.orbit.admissible:
            return None
        try:
            doubled = switch_branch(point)
        except PercussError:
            # Doubled orbits that the search finds are followed from there.
            return None
        if doubled.n_periods != 2 * point.orbit.n_periods or not doubled.admissible:
            return None
        return as_float(get_parameter(*doubled.system, None, point.path)), doubled

    def refusal(self, orbit: PeriodicOrbit) -> str | None:
        """Return why an orbit is not followed: it sticks."""
        sticks = math.isinf(orbit.n_impacts)
        return "it sticks, and what sticks is not followed" if sticks else None

    def slowness(self, orbit: PeriodicOrbit) -> float:
        """Return the order: from the fastest on; its velocities are the units of the steps."""
        return -float(abs(orbit.impacts.v_after).max(initial=0.0))

    def extremes(self, orbit: PeriodicOrbit) -> Extremes:
        """Return the extremes of an orbit's displacement."""
        return extremes_of(orbit)

    def impact_velocities(self, branch: Branch) -> Floats:
        """Return the largest velocity into a stop of each orbit of a branch."""
        return largest_velocities(branch)

    def followed(self, orbit: PeriodicOrbit, value: float, report: Report) -> Branch:
        """Follow an orbit as far as its branch is admissible, in stretches that grow.

        Formal parts of a branch may continue without end.
        """
        width = FIRST_WIDTH if orbit.n_impacts else 1.0
        part = self.within.part(value)
        down, up = width, width
        while True:
            low, high = self.within.value(part - down), self.within.value(part + up)
            step = LARGEST_STEP if orbit.n_impacts else SMALL_STEP
            branch = continue_orbit(
                orbit,
                {self.path: (low, high)},
                max_points=MAX_POINTS,
                largest_step=step,
                progress=report,
            )
            physical = branch.values[branch.admissible]
            grow_down = low > self.within.low and bool((physical <= low).any())
            grow_up = high < self.within.high and bool((physical >= high).any())
            if not (grow_down or grow_up):
                return branch
            down, up = down * (3.0 if grow_down else 1.0), up * (3.0 if grow_up else 1.0)

    def _orbits_at(self, value: float) -> tuple[Known, list[int]]:
        """Return the orbits of all branches at a value, and the branch of each."""
        system = self.system(value)
        if value not in self._known:
            self._known[value] = Known(system), 0, []
        known, done, owners = self._known[value]
        for number in range(done, len(self.branches)):
            for guess in _crossings(self.branches[number], value, float(system.law[0, PERIOD])):
                solution = solve(system, guess)
                if solution.converged and known.add(solution):
                    owners.append(number)
        self._known[value] = known, len(self.branches), owners
        return known, owners


def _reaches(branch: Branch, value: float) -> bool:
    return bool(branch.values.min() <= value <= branch.values.max())


def _crossings(branch: Branch, value: float, period: float) -> list[Itinerary]:
    """Return the itineraries between neighbouring rows of a branch, at a value of the parameter."""
    distances = branch.values - value
    rows = np.flatnonzero((distances[:-1] * distances[1:] < 0.0) | (distances[:-1] == 0.0))
    guesses = [_between(branch, int(row), value, period) for row in rows]
    if len(distances) and distances[-1] == 0.0:
        guesses.append(_between(branch, len(distances) - 2, value, period))
    return [guess for guess in guesses if guess is not None]


def _between(branch: Branch, row: int, value: float, period: float) -> Itinerary | None:
    """Return the linear interpolation of two rows, with times as parts of the period."""
    one, other = branch[row], branch[row + 1]
    events = one.itinerary.events
    n = len(events)
    if n == 0 or not np.array_equal(events, other.itinerary.events):
        return None
    steps = branch.values[row + 1] - branch.values[row]
    part = (value - branch.values[row]) / steps if steps else 0.0
    a, b = one.itinerary.vector, other.itinerary.vector
    a[: 1 + n] *= one.n_periods / one.period
    b[: 1 + n] *= other.n_periods / other.period
    b[0] += round(a[0] - b[0])
    unknowns = a + part * (b - a)
    unknowns[: 1 + n] *= period
    return Itinerary.of_vector(events, unknowns, one.n_periods)
