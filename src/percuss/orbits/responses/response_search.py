"""The search behind a response chart: seeds, families, and a check by direct simulation."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

from percuss.orbits.finding.settled import Settled
from percuss.orbits.responses.families import Families, SeenAttractor, SettlingStarts
from percuss.progress import Progress, Report

# Simulated values for each searched value, which take about as long; starts at each; comparisons at
# most.
PER_SEARCH, STARTS, ROUNDS = 8, 12, 4
# Values at which attractors are compared at least each time.
LEAST_COMPARED = 16
# Values at which a motion without impacts is tried: without damping each resonance parts its branch.
VALUES_WITHOUT = 8
# Distance from special points at which attractors are compared, as a part of the range.
OFFSET = 0.004
# Multiples of this, modulo 1, are spread evenly (Weyl's sequence).
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

Seed = tuple[float, Any]


def search_families(
    families: Families, counts: tuple[int, int], seed: int, n_seeds: int, report: Report
) -> tuple[list[SeenAttractor], bool]:
    """Find and follow families until attractors at new values lie on them.

    Parameters
    ----------
    families
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
    progress = Progress(report, PER_SEARCH * n_seeds + each + n_compared)
    search = _ResponseSearch(families, counts, seed, progress)
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
        self, families: Families, counts: tuple[int, int], seed: int, progress: Progress
    ) -> None:
        self.families, self.counts, self.seed, self.progress = families, counts, seed, progress

    def _text(self, doing: str, value: float) -> str:
        return f"{doing} {self.families.path} = {value:.6g}"

    def _report(self, doing: str, value: float) -> Report:
        """Return the ``progress`` of a part of the work, which reports the whole by the clock."""

        def goes_on(done: float, total: float) -> bool:  # noqa: ARG001
            return self.progress.tick(f"{self._text(doing, value)}, {done:.0f} done")

        return goes_on

    def is_wanted(self, orbit: Any | None) -> bool:
        """Return whether an orbit is of the kinds looked for."""
        return (
            orbit is not None
            and orbit.n_impacts <= self.counts[0]
            and orbit.n_periods <= self.counts[1]
        )

    def searched(self, n_values: int) -> Iterator[Seed]:
        """Yield orbits that are searched for, stable or not."""
        for i in range(n_values):
            value = self.families.within.value((i + 0.5) / n_values)
            report = self._report("searching at", value)
            orbits = self.families.searched(value, self.counts, self.seed, report)
            yield from ((value, orbit) for orbit in orbits)
            if not self.progress.advance(PER_SEARCH, self._text("searched at", value)):
                return

    def settled(self, n_values: int) -> Iterator[Seed]:
        """Yield attractors; motions start at random and where those at the last value were."""
        before: list[Settled] = []
        for i in range(n_values):
            before = self._settled(i, (i + 0.5) / n_values, before)
            value = self.families.within.value((i + 0.5) / n_values)
            yield from ((value, seen.orbit) for seen in before if seen.orbit is not None)
            if self.progress.is_stopped:
                return
            known = self.families.in_closed_form(value, self.counts[1])
            yield from ((value, orbit) for orbit in known)

    def _settled(self, number: int, part: float, before: list[Settled]) -> list[Settled]:
        value = self.families.within.value(part)
        if self.progress.is_stopped or not self.progress.tick(self._text("settling at", value)):
            return []
        starts = SettlingStarts(STARTS, self.seed + number, [seen.state for seen in before])
        settled = self.families.settled(value, self.counts, starts)
        self.progress.advance(text=self._text("settled at", value))
        return settled

    def compared(self, round_number: int, n_values: int) -> Iterator[SeenAttractor]:
        """Yield attractors at values of their own, with the branches on which they lie."""
        first = round_number * n_values
        parts = sorted((GOLDEN * (first + i + 1)) % 1.0 for i in range(n_values))
        if round_number == 0:
            parts = sorted([*parts, *self._parts_at_special_points()])
        self.progress.total = max(self.progress.total, self.progress.done + len(parts))
        # Down the range, where the seeds were found going up: both ends of a hysteresis are seen.
        before: list[Settled] = []
        for i, part in enumerate(reversed(parts)):
            before = self._settled(10_000 + first + i, part, before)
            value = self.families.within.value(part)
            for motion in before:
                counts, speed = (motion.n_impacts, motion.n_periods), motion.impact_speed
                extremes, orbit = motion.extremes, motion.orbit
                yield self.seen(SeenAttractor(value, *counts, None, speed, extremes, orbit))

    def _parts_at_special_points(self) -> set[float]:
        """Return parts of the range on both sides of the special points of admissible orbits."""
        parts = set()
        for branch in self.families.branches:
            for point in branch.special_points:
                near = branch.admissible[max(point.row - 1, 0) : point.row + 2]
                part = round(self.families.within.part(point.value), 3)
                sides = (part - OFFSET, part + OFFSET) if near.any() else ()
                parts |= {side for side in sides if 0.0 < side < 1.0}
        return parts

    def seen(self, attractor: SeenAttractor) -> SeenAttractor:
        """Return an attractor with the branch on which it lies."""
        orbit = attractor.orbit
        if orbit is None or attractor.branch is not None or math.isinf(attractor.n_impacts):
            return attractor
        branch = self.families.branch_of(orbit, attractor.value)
        return dataclasses.replace(attractor, branch=branch)

    def follow_without_impacts(self) -> None:
        """Follow the linear response, in which no stop acts; formal where it is too large."""
        for i in range(VALUES_WITHOUT):
            value = self.families.within.value((i + 0.5) / VALUES_WITHOUT)
            if self.progress.is_stopped:
                return
            try:
                orbit = self.families.without_impacts(value)
            except LookupError:
                return
            if orbit is not None:
                self.families.add(orbit, value, self._report("following from", value))

    def follow(self, seeds: list[Seed]) -> None:
        """Follow orbits that are on no branch, and those that start at its period doublings."""
        # From the fastest on: their velocities and periods are the units of the steps.
        todo = sorted(seeds, key=lambda seed: self.families.slowness(seed[1]))
        while todo and not self.progress.is_stopped:
            value, orbit = todo.pop(0)
            if self.families.add(orbit, value, self._report("following from", value)):
                todo += self._doubled(self.families.branches[-1])

    def _doubled(self, branch: Any) -> Iterator[Seed]:
        """Yield the first orbits that start at period doublings of a branch."""
        for point in branch.special_points:
            twice = 2 * point.orbit.n_impacts, 2 * point.orbit.n_periods
            if point.kind != "period_doubling":
                continue
            if twice[0] > self.counts[0] or twice[1] > self.counts[1]:
                continue
            doubled = self.families.doubled(point)
            if doubled is not None and self.is_wanted(doubled[1]):
                yield doubled
