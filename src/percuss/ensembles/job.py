"""A study of many motions as work in chunks, each of which can be done anywhere and at any time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.sizes import too_large
from percuss.errors import ParameterError

__all__ = [
    "Answer",
    "Block",
    "Column",
    "Dimension",
    "Job",
    "check_room",
    "chunks_of",
    "numbers_of",
    "spans_of",
]


@dataclass(frozen=True, slots=True)
class Column:
    """One array of the answer.

    Attributes
    ----------
    tail
        Shape of the entry of one point.
    dtype
        "f8" or "i8".
    dims
        Names of the dimensions of the tail.
    units
        Its dimensions in length and time; "" where they are not known.
    meaning
        What it is, in a line; "" where its name says so.
    """

    tail: tuple[int, ...] = ()
    dtype: str = "f8"
    dims: tuple[str, ...] = ()
    units: str = "1"
    meaning: str = ""

    def empty(self, n: int) -> NDArray[np.generic]:
        """Return room for n points: NaN, or -1."""
        fill = np.nan if self.dtype == "f8" else -1
        return np.full((n, *self.tail), fill, dtype=self.dtype)


@dataclass(frozen=True, slots=True)
class Dimension:
    """One axis of the answer, whose points are all combinations of its axes' values.

    Attributes
    ----------
    name
        Name of the axis.
    values
        Its coordinates: numbers, or words.
    units
        Their dimensions in length and time.
    """

    name: str
    values: tuple[float, ...] | tuple[str, ...]
    units: str = "1"


@dataclass(slots=True)
class Block:
    """The answer for the points of a chunk.

    Attributes
    ----------
    arrays
        By column, (n, *tail) each.
    reasons
        Why points have no answer, by their place in the chunk.
    n_impacts
        How many impacts it took.
    """

    arrays: dict[str, NDArray[np.generic]]
    reasons: dict[int, str] = field(default_factory=dict)
    n_impacts: int = 0


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of a job.

    Attributes
    ----------
    arrays
        By column, (size, *tail) each; NaN and -1 where it has not been done.
    reasons
        Why points have no answer, by point, in order.
    n_impacts
        How many impacts it took.
    complete
        False where it was stopped before its end.
    """

    arrays: dict[str, NDArray[np.generic]]
    reasons: dict[int, str]
    n_impacts: int
    complete: bool


class Job(Protocol):
    """What engines do: pickled once, asked for its chunks in any order."""

    @property
    def size(self) -> int:
        """Number of points."""
        ...

    @property
    def chunk(self) -> int:
        """Points of a chunk; the same wherever the job is done."""
        ...

    @property
    def columns(self) -> Mapping[str, Column]:
        """What the answer holds."""
        ...

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes, whose lengths multiply to the size; the last is the fastest."""
        ...

    def identity(self) -> dict[str, object]:
        """Return what makes it this study, as JSON can hold it."""
        ...

    def compute(self, first: int, last: int) -> Block:
        """Return the answer for the points from first to last, the last not included."""
        ...


def check_room(job: Job, store: Path | None = None, hint: str = "") -> None:
    """Raise a `ParameterError` unless there is room for the answer.

    Parameters
    ----------
    job
        The work.
    store
        Folder on whose disk the answer may be, where memory cannot hold it; None: in memory.
    hint
        What would help.
    """
    problem = too_large([job.size], numbers_of(job), store)
    if problem is not None:
        axes = job.dimensions
        shape = " x ".join(f"{len(axis.values):,}" for axis in axes)
        raise ParameterError(", ".join(axis.name for axis in axes), shape, problem + hint)


def numbers_of(job: Job) -> int:
    """Return how many numbers of 8 bytes a point's answer has."""
    return sum(math.prod(column.tail) for column in job.columns.values())


def chunks_of(job: Job) -> list[tuple[int, int]]:
    """Return first and last point of each chunk, the last not included."""
    return spans_of(job.size, job.chunk)


def spans_of(size: int, chunk: int) -> list[tuple[int, int]]:
    """Return first and last of each chunk of so many points, the last not included."""
    return [(first, min(first + chunk, size)) for first in range(0, size, chunk)]
