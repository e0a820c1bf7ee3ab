"""Families of one system as they are collected: each followed once, and asked for its orbits."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.law import PERIOD
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameter
from percuss.numerics import log, power
from percuss.orbits.families.branch import Branch
from percuss.orbits.families.continuation import continue_orbit
from percuss.orbits.finding.refine import Known, solved
from percuss.orbits.finding.search import Guess
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Following", "Range"]

Floats = NDArray[np.float64]

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
            region = int(orbit._marks[0, 2])
            for i, branch in enumerate(self.branches):
                if (branch[0].n_impacts, branch[0]._marks[0, 2]) == (0, region):
                    return i if _reaches(branch, value) else None
            return None
        guess = Guess(orbit._chain, orbit._unknowns, int(orbit.n_impacts), orbit.n_periods)
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
        """Tell whether a branch is one of those that there are: near a birth two halves mix up."""
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
    n = len(one._chain)
    if n == 0 or not np.array_equal(one._chain, other._chain):
        return None
    steps = branch.values[row + 1] - branch.values[row]
    part = (value - branch.values[row]) / steps if steps else 0.0
    a, b = one._unknowns.copy(), other._unknowns.copy()
    a[: 1 + n] *= one.n_periods / one.period
    b[: 1 + n] *= other.n_periods / other.period
    b[0] += round(a[0] - b[0])
    unknowns = a + part * (b - a)
    unknowns[: 1 + n] *= period
    return Guess(one._chain, unknowns, int(one.n_impacts), one.n_periods)
