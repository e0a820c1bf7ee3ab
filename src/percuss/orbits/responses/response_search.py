"""The search behind a response chart: seeds, families, and a check by direct simulation."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels.law import PERIOD
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import get_parameter, replace_parameter
from percuss.numerics import log, power
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.bifurcations.continue_orbit import continue_orbit
from percuss.orbits.bifurcations.switching import switch_branch
from percuss.orbits.finding.find import find_orbits
from percuss.orbits.finding.refine_guess import Known, solved
from percuss.orbits.finding.search import Guess
from percuss.orbits.finding.settled import Settled, settled_motions
from percuss.orbits.finding.single_impact import has_closed_form, single_impact_orbits
from percuss.orbits.orbit.extremes import Extremes
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import free_region, steady_orbit
from percuss.progress import Progress, Report

__all__ = ["Following", "Range", "SeenAttractor", "search_families"]

# Values with motions for each value with a search; starts at each; rounds of comparison at most.
PER_SEARCH, STARTS, ROUNDS = 8, 12, 4
# Values at which attractors are compared in a round, at least.
LEAST_COMPARED = 16
# Values at which a motion without impacts is asked for.
VALUES_WITHOUT = 3
# How far beside special points attractors are compared, as a part of the range.
BESIDE = 0.004
# Parts of the range that are nowhere near to one another (Weyl's sequence).
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

Seed = tuple[float, PeriodicOrbit]


@dataclass(frozen=True, slots=True)
class SeenAttractor:
    """What a direct simulation came to.

    Attributes
    ----------
    value
        The parameter.
    n_impacts, n_periods
        Of one round; inf with sticking; NaN and 0 where no period was found.
    branch
        Number of the branch on which it lies, None for none.
    impact_speed
        The largest [length/time]; NaN without impacts.
    extremes
        How far it swings.
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
        Where the branches are collected.
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
        The attractors of the rounds of comparison, and whether it came to its end.
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
            new = [it for it in compared if it.branch is None and it.orbit is not None]
            seen += compared
            if progress.is_stopped or not any(search.is_wanted(it.orbit) for it in new):
                break
            if number < ROUNDS - 1:
                found = [(it.value, it.orbit) for it in new if it.orbit is not None]
                search.follow([seed for seed in found if search.is_wanted(seed[1])])
                seen = [search.seen(it) for it in seen]
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
                found = find_orbits(osc, force, *self.counts, self.seed)
                yield from ((value, orbit) for orbit in found)

    def settled(self, n_values: int) -> Iterator[Seed]:
        """Yield attractors; motions start at random and where those at the last value were."""
        before: list[Settled] = []
        for i in range(n_values):
            before = self._settled(i, (i + 0.5) / n_values, before)
            value = self.following.within.value((i + 0.5) / n_values)
            yield from ((value, it.orbit) for it in before if it.orbit is not None)
            yield from ((value, orbit) for orbit in self._in_closed_form(value))

    def _in_closed_form(self, value: float) -> Iterator[PeriodicOrbit]:
        """Yield the physical orbits with one impact on a wall, which need no search."""
        if self.progress.is_stopped:
            return
        osc, force = self.following.system(value)
        for stop in range(len(osc.stops)):
            if has_closed_form(osc, force, stop):
                for n_periods in range(1, self.counts[1] + 1):
                    found = single_impact_orbits(osc, force, n_periods, stop)
                    yield from (orbit for orbit in found if orbit.admissible)

    def _settled(self, number: int, part: float, before: list[Settled]) -> list[Settled]:
        value = self.following.within.value(part)
        if not self.progress.advance(text=f"settling at {self.following.path} = {value:.6g}"):
            return []
        osc, force = self.following.system(value)
        return settled_motions(
            osc,
            force,
            *self.counts,
            n_starts=STARTS,
            seed=self.seed + number,
            also=[it.state for it in before],
        )

    def compared(self, round_number: int, n_values: int) -> Iterator[SeenAttractor]:
        """Yield attractors at values of their own, with the branches on which they lie."""
        first = round_number * n_values
        parts = sorted((GOLDEN * (first + i + 1)) % 1.0 for i in range(n_values))
        if round_number == 0:
            parts = sorted([*parts, *self._beside_special_points()])
        # Down the range, where the seeds were found going up: both ends of a hysteresis are seen.
        before: list[Settled] = []
        for i, part in enumerate(reversed(parts)):
            before = self._settled(10_000 + first + i, part, before)
            value = self.following.within.value(part)
            for it in before:
                counts = it.n_impacts, it.n_periods
                here = SeenAttractor(value, *counts, None, it.impact_speed, it.extremes, it.orbit)
                yield self.seen(here)

    def _beside_special_points(self) -> set[float]:
        """Return parts of the range on both sides of where physical orbits change in kind."""
        found = set()
        for branch in self.following.branches:
            for point in branch.special_points:
                near = branch.admissible[max(point.row - 1, 0) : point.row + 2]
                part = round(self.following.within.part(point.value), 3)
                sides = (part - BESIDE, part + BESIDE) if near.any() else ()
                found |= {side for side in sides if 0.0 < side < 1.0}
        return found

    def seen(self, it: SeenAttractor) -> SeenAttractor:
        """Return an attractor with the branch on which it lies."""
        if it.orbit is None or it.branch is not None or math.isinf(it.n_impacts):
            return it
        return dataclasses.replace(it, branch=self.following.branch_of(it.orbit, it.value))

    def follow_without_impacts(self) -> None:
        """Follow the motion free of all stops, formal where it is too large: the linear response."""
        for i in range(VALUES_WITHOUT):
            value = self.following.within.value((i + 0.5) / VALUES_WITHOUT)
            osc, force = self.following.system(value)
            region = free_region(osc, law(osc, force))
            if region is None:
                return
            try:
                orbit = steady_orbit(osc, force, region)
            except ConvergenceError:
                # At resonance without damping there is none; there is beside it.
                continue
            self.following.add(orbit, value)
            return

    def follow(self, seeds: list[Seed]) -> None:
        """Follow orbits that are on no branch, and those that start at their period doublings."""
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
                # Where doubled orbits are found otherwise, they are followed from there.
                continue
            if self.is_wanted(doubled) and doubled.n_periods == twice[1] and doubled.admissible:
                value = get_parameter(doubled.oscillator, doubled.forcing, None, point.path)
                yield as_float(value), doubled


def _slowness(seed: Seed) -> float:
    return -float(abs(seed[1].impacts.v_after).max(initial=0.0))


# Half the width of the first stretch in which an orbit is followed, as a part of the range.
FIRST_WIDTH = 0.04
# Ranges whose ends have a larger ratio are divided by ratios, others by differences.
WIDE = 4.0
# Most rows each way: a family that takes more winds itself up among formal orbits.
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
    osc, force
        What moves, at any value of the parameter.
    path, within
        The parameter and its range.
    branches
        Each family once.
    left_out
        Orbits that cannot be followed, with the reason.
    """

    osc: Oscillator
    force: Forcing
    path: str
    within: Range
    branches: list[Branch] = field(default_factory=list)
    left_out: list[tuple[float, PeriodicOrbit, str]] = field(default_factory=list)
    _known: dict[float, tuple[Known, int, list[int]]] = field(default_factory=dict)

    def system(self, value: float) -> tuple[Oscillator, Forcing]:
        """Return what moves at a value of the parameter."""
        osc, force, _ = replace_parameter(self.osc, self.force, None, self.path, value)
        assert force is not None
        return osc, force

    def branch_of(self, orbit: PeriodicOrbit, value: float) -> int | None:
        """Return the number of the branch on which an orbit of this value lies, None if on none."""
        known, owners = self._orbits_at(value)
        if orbit.n_impacts == 0:
            region = int(orbit.record[1][0, 2])
            for i, branch in enumerate(self.branches):
                if (branch[0].n_impacts, branch[0].record[1][0, 2]) == (0, region):
                    return i if _reaches(branch, value) else None
            return None
        events, unknowns = orbit.itinerary.events, orbit.itinerary.vector
        guess = Guess(events, unknowns, int(orbit.n_impacts), orbit.n_periods)
        signature = known.signature(guess, isolated=orbit.isolated)
        for other, owner in zip(known.signatures, owners, strict=True):
            if signature.matches(other):
                return owner
        return None

    def add(self, orbit: PeriodicOrbit, value: float) -> bool:
        """Follow an orbit unless it is on a branch already; tell whether it was followed."""
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
        """Return whether a branch is one of those that there are: near a birth two halves mix up."""
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
        """Follow an orbit as far as there are physical ones, in stretches that grow.

        Formal orbits go on to any number of impacts in places where nothing moves that way.
        """
        width = FIRST_WIDTH if orbit.n_impacts else 1.0
        here = self.within.part(value)
        down, up = width, width
        while True:
            low, high = self.within.value(here - down), self.within.value(here + up)
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
        osc, force = self.system(value)
        if value not in self._known:
            self._known[value] = Known(osc, force), 0, []
        known, done, owners = self._known[value]
        for number in range(done, len(self.branches)):
            for guess in _crossings(self.branches[number], value, float(known.law[0, PERIOD])):
                solution = solved(osc, force, guess)
                if not solution.converged:
                    continue
                there = Guess(guess.chain, solution.unknowns, guess.n_impacts, guess.n_periods)
                if not known.holds(known.signature(there, isolated=solution.isolated)):
                    owners.append(number)
        self._known[value] = known, len(self.branches), owners
        return known, owners


def _reaches(branch: Branch, value: float) -> bool:
    return bool(branch.values.min() <= value <= branch.values.max())


def _crossings(branch: Branch, value: float, period: float) -> list[Guess]:
    """Return the orbits between neighbouring rows of a branch, at a value of the parameter."""
    off = branch.values - value
    rows = np.flatnonzero((off[:-1] * off[1:] < 0.0) | (off[:-1] == 0.0))
    guesses = [_between(branch, int(row), value, period) for row in rows]
    if len(off) and off[-1] == 0.0:
        guesses.append(_between(branch, len(off) - 2, value, period))
    return [guess for guess in guesses if guess is not None]


def _between(branch: Branch, row: int, value: float, period: float) -> Guess | None:
    """Return the orbit on the straight line between two rows, times as parts of the period."""
    one, other = branch[row], branch[row + 1]
    chain = one.itinerary.events
    n = len(chain)
    if n == 0 or not np.array_equal(chain, other.itinerary.events):
        return None
    steps = branch.values[row + 1] - branch.values[row]
    part = (value - branch.values[row]) / steps if steps else 0.0
    a, b = one.itinerary.vector, other.itinerary.vector
    a[: 1 + n] *= one.n_periods / one.period
    b[: 1 + n] *= other.n_periods / other.period
    b[0] += round(a[0] - b[0])
    unknowns = a + part * (b - a)
    unknowns[: 1 + n] *= period
    return Guess(chain, unknowns, int(one.n_impacts), one.n_periods)
