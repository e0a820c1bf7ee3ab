"""The search behind a response chart: seeds, families, and a check by direct simulation."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import as_float
from percuss.model.paths import get_parameter, replace_parameter
from percuss.model.system import System
from percuss.numerics import log, power
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.bifurcations.continue_orbit import continue_orbit
from percuss.orbits.bifurcations.switching import switch_branch
from percuss.orbits.finding.find import find_orbits
from percuss.orbits.finding.refine_guess import Known
from percuss.orbits.finding.settled import Settled, settled_motions
from percuss.orbits.finding.single_impact import has_closed_form, single_impact_orbits
from percuss.orbits.orbit.extremes import Extremes
from percuss.orbits.orbit.itinerary import Itinerary
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import solve
from percuss.orbits.orbit.steady import free_region, steady_orbit
from percuss.progress import Progress, Report

__all__ = ["Following", "Range", "SeenAttractor", "search_families"]

# Simulated values for each searched value; starts at each; comparisons at most.
PER_SEARCH, STARTS, ROUNDS = 8, 12, 4
# Values at which attractors are compared at least each time.
LEAST_COMPARED = 16
# Values at which a motion without impacts is tried.
VALUES_WITHOUT = 3
# Distance from special points at which attractors are compared, as a part of the range.
OFFSET = 0.004
# Multiples of this, modulo 1, are spread evenly (Weyl's sequence).
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

Seed = tuple[float, PeriodicOrbit]


@dataclass(frozen=True, slots=True)
class SeenAttractor:
    """The attractor of a direct simulation.

    Attributes
    ----------
    value
        The parameter.
    n_impacts, n_periods
        Impacts and forcing periods of the orbit; inf with sticking; NaN and 0 without a period.
    branch
        Number of the branch on which it lies, None for none.
    impact_speed
        The largest [length/time]; NaN without impacts.
    extremes
        Least and largest displacement.
    orbit
        The orbit; None where no period was found.
    """

    value: float
    n_impacts: float
    n_periods: int
    branch: int | None
    impact_speed: float
    extremes: Extremes
    orbit: PeriodicOrbit | None = field(repr=False)

    def on(self, place: Mapping[int, int]) -> SeenAttractor:
        """Return the same with another numbering of the branches."""
        new = None if self.branch is None else place[self.branch]
        return dataclasses.replace(self, branch=new)


def search_families(
    following: Following, counts: tuple[int, int], seed: int, n_seeds: int, report: Report
) -> tuple[list[SeenAttractor], bool]:
    """Find and follow families until attractors at new values lie on them.

    Parameters
    ----------
    following
        The branches, to which new ones are added.
    counts
        Most impacts and most periods.
    seed
        Of the random starts.
    n_seeds
        At how many values orbits are searched for.
    report
        As `percuss.response_curve` takes ``progress``.

    Returns
    -------
    list of SeenAttractor, bool
        The attractors that were compared, and whether the search was completed.
    """
    each = PER_SEARCH * n_seeds
    n_compared = max(LEAST_COMPARED, each // 2)
    progress = Progress(report, n_seeds + each + n_compared)
    search = _ResponseSearch(following, counts, seed, progress)
    try:
        seeds = list(search.searched(n_seeds)) + list(search.settled(each))
        search.follow_without_impacts()
        search.follow([(value, orbit) for value, orbit in seeds if search.is_wanted(orbit)])
        seen: list[SeenAttractor] = []
        for number in range(ROUNDS):
            compared = list(search.compared(number, n_compared))
            new = [
                (attractor.value, attractor.orbit)
                for attractor in compared
                if attractor.branch is None and attractor.orbit is not None
            ]
            seen += compared
            seeds = [seed for seed in new if search.is_wanted(seed[1])]
            if progress.is_stopped or not seeds:
                break
            if number < ROUNDS - 1:
                search.follow(seeds)
                seen = [search.seen(attractor) for attractor in seen]
    finally:
        progress.close()
    return seen, not progress.is_stopped


class _ResponseSearch:
    """The steps of a search on one system."""

    def __init__(
        self, following: Following, counts: tuple[int, int], seed: int, progress: Progress
    ) -> None:
        self.following, self.counts, self.seed, self.progress = following, counts, seed, progress

    def is_wanted(self, orbit: PeriodicOrbit | None) -> bool:
        """Return whether an orbit is of the kinds looked for."""
        return (
            orbit is not None
            and orbit.n_impacts <= self.counts[0]
            and orbit.n_periods <= self.counts[1]
        )

    def searched(self, n_values: int) -> Iterator[Seed]:
        """Yield orbits that are searched for, stable or not."""
        for i in range(n_values):
            value = self.following.within.value((i + 0.5) / n_values)
            if not self.progress.advance(text=f"searching at {self.following.path} = {value:.6g}"):
                return
            osc, force = self.following.system(value)
            if osc.stops:
                orbits = find_orbits(osc, force, *self.counts, self.seed)
                yield from ((value, orbit) for orbit in orbits)

    def settled(self, n_values: int) -> Iterator[Seed]:
        """Yield attractors; motions start at random and where those at the last value were."""
        before: list[Settled] = []
        for i in range(n_values):
            before = self._settled(i, (i + 0.5) / n_values, before)
            value = self.following.within.value((i + 0.5) / n_values)
            yield from ((value, seen.orbit) for seen in before if seen.orbit is not None)
            yield from ((value, orbit) for orbit in self._in_closed_form(value))

    def _in_closed_form(self, value: float) -> Iterator[PeriodicOrbit]:
        """Yield the physical orbits with one impact on a wall, which need no search."""
        if self.progress.is_stopped:
            return
        system = self.following.system(value)
        osc, force = system
        assert force is not None
        for stop in range(len(osc.stops)):
            if has_closed_form(system, stop):
                for n_periods in range(1, self.counts[1] + 1):
                    orbits = single_impact_orbits(osc, force, n_periods, stop)
                    yield from (orbit for orbit in orbits if orbit.admissible)

    def _settled(self, number: int, part: float, before: list[Settled]) -> list[Settled]:
        value = self.following.within.value(part)
        if not self.progress.advance(text=f"settling at {self.following.path} = {value:.6g}"):
            return []
        return settled_motions(
            self.following.system(value),
            *self.counts,
            n_starts=STARTS,
            seed=self.seed + number,
            also=[seen.state for seen in before],
        )

    def compared(self, round_number: int, n_values: int) -> Iterator[SeenAttractor]:
        """Yield attractors at values of their own, with the branches on which they lie."""
        first = round_number * n_values
        parts = sorted((GOLDEN * (first + i + 1)) % 1.0 for i in range(n_values))
        if round_number == 0:
            parts = sorted([*parts, *self._parts_at_special_points()])
        # Down the range, where the seeds were found going up: both ends of a hysteresis are seen.
        before: list[Settled] = []
        for i, part in enumerate(reversed(parts)):
            before = self._settled(10_000 + first + i, part, before)
            value = self.following.within.value(part)
            for motion in before:
                counts, speed = (motion.n_impacts, motion.n_periods), motion.impact_speed
                extremes, orbit = motion.extremes, motion.orbit
                yield self.seen(SeenAttractor(value, *counts, None, speed, extremes, orbit))

    def _parts_at_special_points(self) -> set[float]:
        """Return parts of the range on both sides of the special points of admissible orbits."""
        parts = set()
        for branch in self.following.branches:
            for point in branch.special_points:
                near = branch.admissible[max(point.row - 1, 0) : point.row + 2]
                part = round(self.following.within.part(point.value), 3)
                sides = (part - OFFSET, part + OFFSET) if near.any() else ()
                parts |= {side for side in sides if 0.0 < side < 1.0}
        return parts

    def seen(self, attractor: SeenAttractor) -> SeenAttractor:
        """Return an attractor with the branch on which it lies."""
        orbit = attractor.orbit
        if orbit is None or attractor.branch is not None or math.isinf(attractor.n_impacts):
            return attractor
        branch = self.following.branch_of(orbit, attractor.value)
        return dataclasses.replace(attractor, branch=branch)

    def follow_without_impacts(self) -> None:
        """Follow the linear response, in which no stop acts; formal where it is too large."""
        for i in range(VALUES_WITHOUT):
            value = self.following.within.value((i + 0.5) / VALUES_WITHOUT)
            system = self.following.system(value)
            region = free_region(system)
            if region is None:
                return
            try:
                orbit = steady_orbit(system, region)
            except ConvergenceError:
                # At resonance without damping there is none, but at other values.
                continue
            self.following.add(orbit, value)
            return

    def follow(self, seeds: list[Seed]) -> None:
        """Follow orbits that are on no branch, and those that start at its period doublings."""
        # From the fastest on: their velocities and periods are the units of the steps.
        todo = sorted(seeds, key=_slowness)
        while todo and not self.progress.is_stopped:
            value, orbit = todo.pop(0)
            if self.following.add(orbit, value):
                todo += self._doubled(self.following.branches[-1])

    def _doubled(self, branch: Branch) -> Iterator[Seed]:
        """Yield the first orbits that start at period doublings of a branch."""
        for point in branch.special_points:
            twice = 2 * point.orbit.n_impacts, 2 * point.orbit.n_periods
            if point.kind != "period_doubling" or not point.orbit.admissible:
                continue
            if twice[0] > self.counts[0] or twice[1] > self.counts[1]:
                continue
            try:
                doubled = switch_branch(point)
            except PercussError:
                # Doubled orbits that the search finds are followed from there.
                continue
            if self.is_wanted(doubled) and doubled.n_periods == twice[1] and doubled.admissible:
                value = get_parameter(*doubled.system, None, point.path)
                yield as_float(value), doubled


def _slowness(seed: Seed) -> float:
    return -float(abs(seed[1].impacts.v_after).max(initial=0.0))


# Half the width of the first stretch in which an orbit is followed, as a part of the range.
FIRST_WIDTH = 0.04
# Ranges whose ends have a larger ratio are divided by ratios, others by differences.
WIDE = 4.0
# Most rows each way: a family that takes more continues among formal orbits.
MAX_POINTS = 800
# Longest steps, as parts of a stretch; without impacts no unknown tells how a resonance bends.
LARGEST_STEP, SMALL_STEP = 0.02, 0.002


@dataclass(frozen=True, slots=True)
class Range:
    """The range of a parameter, divided evenly: by ratios where it is wide, else by differences."""

    low: float
    high: float

    @property
    def by_ratios(self) -> bool:
        """Whether equal parts have equal ratios."""
        return self.low > 0.0 and self.high > WIDE * self.low

    def value(self, part: float) -> float:
        """Return the value at a part of the range, from 0 to 1."""
        if part <= 0.0 or part >= 1.0:
            return self.low if part <= 0.0 else self.high
        if self.by_ratios:
            return self.low * power(self.high / self.low, part)
        return self.low + part * (self.high - self.low)

    def part(self, value: float) -> float:
        """Return at which part of the range a value lies."""
        if self.by_ratios:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


@dataclass(slots=True)
class Following:
    """The branches found so far.

    Attributes
    ----------
    base
        Oscillator and forcing, at any value of the parameter.
    path, within
        The parameter and its range.
    branches
        Each family once.
    left_out
        Orbits that cannot be followed, with their values and the reasons.
    """

    base: System
    path: str
    within: Range
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
                if (branch[0].n_impacts, branch[0].record[1][0, 2]) == (0, region):
                    return i if _reaches(branch, value) else None
            return None
        signature = known.signature(orbit.itinerary, isolated=orbit.isolated)
        for other, owner in zip(known.signatures, owners, strict=True):
            if signature.matches(other):
                return owner
        return None

    def add(self, orbit: PeriodicOrbit, value: float) -> bool:
        """Follow an orbit unless it is on a branch already, and return whether it was followed."""
        if math.isinf(orbit.n_impacts):
            self.left_out.append((value, orbit, "it sticks, and what sticks is not followed"))
            return False
        if self.branch_of(orbit, value) is not None:
            return False
        try:
            branch = self._followed(orbit, value)
        except (ConvergenceError, ParameterError) as error:
            self.left_out.append((value, orbit, str(error)))
            return False
        if self._is_known(branch):
            return False
        self.branches.append(branch)
        return True

    def _is_known(self, branch: Branch) -> bool:
        """Return whether a branch is a known one, which may be found by its other half."""
        physical = np.flatnonzero(branch.admissible)
        special = [point.row for point in branch.special_points]
        physical = physical[~np.isin(physical, special)]
        if len(physical) == 0:
            return False
        rows = physical[[len(physical) // 4, (3 * len(physical)) // 4]].tolist()
        return all(
            self.branch_of(branch[row], float(branch.values[row])) is not None for row in rows
        )

    def _followed(self, orbit: PeriodicOrbit, value: float) -> Branch:
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
                orbit, {self.path: (low, high)}, max_points=MAX_POINTS, largest_step=step
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
