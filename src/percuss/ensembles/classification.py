"""The classification of starts by their long-term motion: the part of basins done in chunks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Flags, Floats, Integers
from percuss.ensembles.batch import (
    MOST_IMPACTS,
    BatchResult,
    Plan,
    exponents_of,
    tangent_plan,
)
from percuss.ensembles.decisions import (
    CHAOTIC,
    NO_START,
    PERIODIC,
    REST,
    UNDECIDED,
    is_chaotic,
    kinds_of_motions,
)
from percuss.ensembles.groups import AnyGroup
from percuss.ensembles.job import Block, Column, Dimension
from percuss.kernels import observables
from percuss.kernels import record as columns

Arrays = Mapping[str, NDArray[np.generic]]

# The longest period of a motion that is sought first, in forcing periods.
LONGEST = 16
# A start is followed for so many forcing periods at a time; the last of them, twice the longest
# period, show whether it has become periodic.
STAGE, COMPARED = 40, 2 * LONGEST
# Motions without such a period after all that time may have one of up to 128. It is sought in 1024
# motions at a time, because all their strobes are kept.
LONGEST_OF_ALL, AT_ONCE = 128, 1024
# The largest exponent of the others is taken over so many periods.
PERIODS_OF_AN_EXPONENT = 512
# Starts of a chunk; each takes fifty impacts or more.
CHUNK = 8192

CLASS_COLUMNS = {
    "kind": Column(dtype="i8"),
    "n_periods": Column(dtype="i8"),
    "n_impacts": Column(),
    "strobe": Column((2,), dims=("entry",)),
    "exponent": Column(units="1/time"),
    "exponent_error": Column(units="1/time"),
}


def class_columns(n: int) -> dict[str, Column]:
    """Return the columns of the classes of motions of n coordinates, 1 for an oscillator."""
    return CLASS_COLUMNS | {"strobe": Column((2 * n,), dims=("entry",))}


class Starts(Protocol):
    """Starts of motions, as a `Grid` has them."""

    @property
    def size(self) -> int:
        """Number of starts."""
        ...

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes, whose lengths multiply to the size."""
        ...

    def groups(self, first: int, last: int) -> tuple[Sequence[AnyGroup], dict[int, str]]:
        """Return the starts from first to last in groups, and the faults of the others."""
        ...


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules by which a start is classified.

    Attributes
    ----------
    t0
        When strobes begin [time]: that of the starts, or 0 for starts at a wall.
    within
        Whether starts begin within the first forcing period after t0, not at it.
    periods
        Forcing periods after which an undecided start stays undecided.
    escape
        A motion that goes farther than this [length] is unbounded.
    """

    t0: float
    within: bool
    periods: int
    escape: float

    def follow(self, group: AnyGroup) -> tuple[dict[str, NDArray[np.generic]], int]:
        """Follow starts until each is decided; return their columns and the number of impacts."""
        n = len(group.starts)
        columns_of_group = class_columns((group.starts.shape[1] - 1) // 2)
        classes: dict[str, NDArray[np.generic]] = {
            name: column.empty(n) for name, column in columns_of_group.items()
        }
        n_impacts = 0
        period = group.periods
        left, begun = np.arange(n), group.starts.copy()
        for stage in range(-(-self.periods // STAGE)):
            # One period more for starts at a wall, which begin within the first.
            until = self.t0 + ((stage + 1) * STAGE + self.within) * period[left]
            plan = Plan(
                until - COMPARED * period[left],
                period[left],
                until,
                section=observables.STROBES,
                n_points=COMPARED + 1,
                max_impacts=MOST_IMPACTS,
            )
            result = group.beginning(left, begun[left]).follow(plan)
            n_impacts += int(result.n_impacts.sum())
            decided = self._decide(classes, left, result, period[left])
            begun[left, :-1] = result.ends
            begun[left, -1] = until
            lost = ~np.isfinite(begun[left]).all(axis=1)
            left = left[~(decided | lost)]
            if len(left) == 0:
                return classes, n_impacts
        n_impacts += _exponents(classes, group, left, begun)
        left = left[classes["kind"][left] == -1]
        for part in np.split(left, range(AT_ONCE, len(left), AT_ONCE)):
            n_impacts += self._find_long_periods(classes, group, part, begun[part])
        return classes, n_impacts

    def _find_long_periods(
        self, classes: Arrays, group: AnyGroup, rows: Integers, begun: Floats
    ) -> int:
        """Classify motions of long periods; return the number of impacts."""
        if len(rows) == 0:
            return 0
        period, since = group.periods[rows], begun[:, -1].copy()
        until = since + 2 * LONGEST_OF_ALL * period
        plan = Plan(since, period, until, observables.STROBES, 2 * LONGEST_OF_ALL + 1)
        result = group.beginning(rows, begun).follow(plan)
        self._decide(classes, rows, result, period)
        return int(result.n_impacts.sum())

    def _decide(
        self, classes: Arrays, rows: Integers, result: BatchResult, period: Floats
    ) -> Flags:
        """Classify motions by their last strobes; return which of them are decided."""
        compared = result.points.shape[1] - 1
        strobes = result.strobes
        kinds, n_periods = np.empty((2, len(rows)), dtype=np.int64)
        ends, points = (np.ascontiguousarray(array) for array in (result.ends, strobes))
        kinds_of_motions(result.status, ends, points, period, self.escape, kinds, n_periods)
        periodic, rest = kinds == PERIODIC, kinds == REST
        decided = kinds != UNDECIDED
        classes["kind"][rows[decided]] = kinds[decided]
        classes["n_periods"][rows[periodic]] = n_periods[periodic]
        per_period = result.values[:, observables.IMPACTS] / compared
        classes["n_impacts"][rows[periodic]] = np.round((per_period * n_periods)[periodic])
        # The strobe of a mass at rest is its place.
        place = strobes[:, -1].copy()
        if rest.any():
            place[rest] = result.state[rest][:, [columns.X, columns.V]]
        bounded = rest | periodic
        classes["strobe"][rows[bounded]] = place[bounded]
        return np.asarray(decided)


def _exponents(classes: Arrays, group: AnyGroup, left: Integers, begun: Floats) -> int:
    """Classify the chaotic motions by their largest exponents; return the number of impacts."""
    period = group.periods[left]
    plan = tangent_plan(period, begun[left, -1], 0, PERIODS_OF_AN_EXPONENT)
    result = group.beginning(left, begun[left]).follow(plan)
    largest, _, error, _ = exponents_of(result, plan)
    motions = zip(largest.tolist(), error.tolist(), period.tolist(), strict=True)
    chaotic = np.array([is_chaotic(*motion) for motion in motions], dtype=np.bool_)
    rows = left[chaotic]
    classes["kind"][rows] = CHAOTIC
    classes["strobe"][rows] = begun[rows, :-1]
    classes["exponent"][rows], classes["exponent_error"][rows] = largest[chaotic], error[chaotic]
    return int(result.n_impacts.sum())


@dataclass(frozen=True, slots=True)
class Classification:
    """The job: the class of each start.

    Attributes
    ----------
    starts
        The starts.
    rules
        The rules of their classification.
    study
        What tells this study from others.
    n_coordinates
        Of the structure; 1 of an oscillator.
    """

    starts: Starts
    rules: Rules
    study: tuple[tuple[str, object], ...]
    n_coordinates: int = 1

    @property
    def size(self) -> int:
        """Number of starts."""
        return self.starts.size

    @property
    def chunk(self) -> int:
        """Starts of a chunk."""
        return CHUNK

    @property
    def columns(self) -> dict[str, Column]:
        """Kind; period in forcing periods, and impacts in one; a strobe; the largest exponent."""
        return class_columns(self.n_coordinates)

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes of the starts."""
        return self.starts.dimensions

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        return dict(self.study) | {"periods": self.rules.periods, "escape": self.rules.escape}

    def compute(self, first: int, last: int) -> Block:
        """Follow the starts of a chunk until each is decided."""
        groups, faults = self.starts.groups(first, last)
        block = Block.empty(self.columns, last - first)
        block.arrays["kind"][list(faults)] = NO_START
        for group in groups:
            classes, n_impacts = self.rules.follow(group)
            for name, array in classes.items():
                block.arrays[name][group.rows] = array
            block.n_impacts += n_impacts
        return block
