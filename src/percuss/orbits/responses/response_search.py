"""The search behind a response chart: seeds, families, and a check by direct simulation."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from percuss.errors import ConvergenceError, PercussError
from percuss.model.exact import as_float
from percuss.model.law import law
from percuss.model.paths import get_parameter
from percuss.orbits.families.branch import Branch
from percuss.orbits.families.switching import switch_branch
from percuss.orbits.finding.find import find_orbits
from percuss.orbits.finding.settled import Settled, settled_motions
from percuss.orbits.finding.single_impact import has_closed_form, single_impact_orbits
from percuss.orbits.orbit.extremes import Extremes
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import free_region, steady_orbit
from percuss.orbits.responses.following import Following
from percuss.progress import Progress, Report

__all__ = ["SeenAttractor", "search_families"]

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
    search = _Search(following, counts, seed, progress)
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


class _Search:
    """The steps of a search on one system."""

    def __init__(
        self, following: Following, counts: tuple[int, int], seed: int, progress: Progress
    ) -> None:
        self.following, self.counts, self.seed, self.progress = following, counts, seed, progress

    def is_wanted(self, orbit: PeriodicOrbit | None) -> bool:
        """Tell whether an orbit is of the kinds looked for."""
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
