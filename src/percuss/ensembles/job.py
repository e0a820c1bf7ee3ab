"""A study of many motions as work in chunks, each of which can be done anywhere and at any time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Block", "Column", "Dimension", "Job", "chunks_of"]


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
        Its dimensions in length and time.
    """

    tail: tuple[int, ...] = ()
    dtype: str = "f8"
    dims: tuple[str, ...] = ()
    units: str = "1"

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


def chunks_of(job: Job) -> list[tuple[int, int]]:
    """Return first and last point of each chunk, the last not included."""
    return [(first, min(first + job.chunk, job.size)) for first in range(0, job.size, job.chunk)]
