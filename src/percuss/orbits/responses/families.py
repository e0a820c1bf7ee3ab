"""The families of periodic orbits found along a parameter, whatever it is that moves."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.numerics import log, power
from percuss.orbits.finding.settled import Settled
from percuss.orbits.orbit.extremes import Extremes
from percuss.progress import Report

# Ranges whose ends have a larger ratio are divided by ratios, others by differences.
WIDE = 4.0


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
    orbit: Any | None = field(repr=False)

    def on(self, place: Mapping[int, int]) -> SeenAttractor:
        """Return the same with another numbering of the branches."""
        new = None if self.branch is None else place[self.branch]
        return dataclasses.replace(self, branch=new)


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


class SettlingStarts(NamedTuple):
    """The starts of motions that are followed until they settle: so many at random, and others."""

    n: int
    seed: int
    also: Sequence[tuple[float, ...]]


@dataclass(slots=True)
class Families(ABC):
    """The branches found so far, and how more of them are found; each kind of model has its own.

    Attributes
    ----------
    path, within
        The parameter and its range.
    branches
        Each family once.
    left_out
        Orbits that cannot be followed, with their values and the reasons.
    """

    path: str
    within: Range
    branches: list[Any] = field(default_factory=list)
    left_out: list[tuple[float, Any, str]] = field(default_factory=list)

    @abstractmethod
    def force(self, value: float) -> Forcing | Loads | None:
        """Return the force there; raise the error of a value that the parameter cannot have."""

    @abstractmethod
    def searched(
        self, value: float, counts: tuple[int, int], seed: int, report: Report
    ) -> Iterable[Any]:
        """Return orbits at a value that are searched for, stable or not."""

    @abstractmethod
    def in_closed_form(self, value: float, max_periods: int) -> Iterable[Any]:
        """Yield orbits at a value that need no search."""

    @abstractmethod
    def settled(
        self, value: float, counts: tuple[int, int], starts: SettlingStarts
    ) -> list[Settled]:
        """Return the attractors to which motions settle at a value."""

    @abstractmethod
    def without_impacts(self, value: float) -> Any | None:
        """Return the linear response at a value, None where it has to be tried at another one.

        Raises
        ------
        LookupError
            If the model has none at any value.
        """

    @abstractmethod
    def doubled(self, point: Any) -> tuple[float, Any] | None:
        """Return the first orbit that starts at a period doubling, and its value; None for none."""

    @abstractmethod
    def branch_of(self, orbit: Any, value: float) -> int | None:
        """Return the number of the branch on which an orbit of this value lies, None if on none."""

    @abstractmethod
    def followed(self, orbit: Any, value: float, report: Report) -> Any:
        """Return the branch of an orbit, as far as ``report`` lets it be followed."""

    @abstractmethod
    def refusal(self, orbit: Any) -> str | None:
        """Return why an orbit is not followed, None if it can be."""

    @abstractmethod
    def slowness(self, orbit: Any) -> float:
        """Return the order in which orbits are followed."""

    @abstractmethod
    def extremes(self, orbit: Any) -> Extremes:
        """Return the extremes of an orbit's displacement."""

    @abstractmethod
    def impact_velocities(self, branch: Any) -> Floats:
        """Return the largest velocity into a stop of each orbit of a branch, NaN without one."""

    def add(self, orbit: Any, value: float, report: Report) -> bool:
        """Follow an orbit unless it is on a branch already, and return whether it was followed."""
        reason = self.refusal(orbit)
        if reason is not None:
            self.left_out.append((value, orbit, reason))
            return False
        if self.branch_of(orbit, value) is not None:
            return False
        try:
            branch = self.followed(orbit, value, report)
        except (ConvergenceError, ParameterError) as error:
            self.left_out.append((value, orbit, str(error)))
            return False
        if self._is_known(branch):
            return False
        self.branches.append(branch)
        return True

    def _is_known(self, branch: Any) -> bool:
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
