"""A study of many motions as work in chunks, each of which can be done anywhere and at any time."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError

__all__ = [
    "BYTES_OF_A_NUMBER", "Answer", "Block", "Column", "Dimension", "Job", "check_room", "chunks_of", "in_gigabytes",
    "memory", "numbers_of", "spans_of", "too_large",
]  # fmt: skip

# Bytes that are taken for the memory of a machine that does not say.
UNTOLD = 1 << 44
# Bytes of a number.
BYTES_OF_A_NUMBER = 8
# Where Linux says what is available, and what a group of processes may have and has.
AVAILABLE = Path("/proc/meminfo")
GROUP_MOST, GROUP_TAKEN = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")


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
        """Return an array for n points: NaN, or -1."""
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
    """Raise a `ParameterError` unless memory or disk can hold the answer.

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


def memory() -> int:
    """Return how much memory there is to be had now [bytes]: free, or in use as a cache only."""
    try:
        found = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return UNTOLD
    with contextlib.suppress(OSError, ValueError, StopIteration):
        rows = (line.split() for line in AVAILABLE.read_text(encoding="ascii").splitlines())
        found = min(found, 1024 * next(int(row[1]) for row in rows if row[0] == "MemAvailable:"))
    with contextlib.suppress(OSError, ValueError):
        # "max" where there is no limit, which is no number.
        most = int(GROUP_MOST.read_text(encoding="ascii"))
        found = min(found, most - int(GROUP_TAKEN.read_text(encoding="ascii")))
    return max(0, found)


def free_on_disk(path: Path) -> int:
    """Return how many bytes a disk has free, on which a folder is or will be made."""
    there = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    return shutil.disk_usage(there).free


def too_large(shape: Sequence[int], each: int = 1, store: Path | None = None) -> str | None:
    """Return why an answer is too large for this machine, None where it is not.

    Parameters
    ----------
    shape
        Points along each axis.
    each
        Numbers of 8 bytes for each point.
    store
        Folder on whose disk the answer is kept, and from which it is read where memory cannot
        hold it; None keeps it in memory.

    Examples
    --------
    >>> too_large([100, 100])
    >>> print(too_large([10**5] * 3).partition(";")[0])
    1,000,000,000,000,000 points, whose answer takes 8,000,000 GB
    """
    size = BYTES_OF_A_NUMBER * math.prod(shape) * each
    free = memory()
    if size <= free:
        return None
    points = f"{math.prod(shape):,} points" if math.prod(shape) != 1 else "1 point"
    takes = f"{points}, whose answer takes {in_gigabytes(size)}"
    if store is None:
        return f"{takes}; this machine has {in_gigabytes(free)} of memory to be had"
    # Its chunks, and the answer as it is put together.
    disk = free_on_disk(store)
    if 2 * size <= disk:
        return None
    return f"{takes} in a store and as much beside it; its disk has {in_gigabytes(disk)} free"


def in_gigabytes(size: int) -> str:
    """Return a number of bytes as one reads it.

    Examples
    --------
    >>> in_gigabytes(12_800_000_000), in_gigabytes(480_000_000)
    ('13 GB', '0.48 GB')
    """
    value = size / 1e9
    return f"{value:,.0f} GB" if value >= 10.0 else f"{value:.2g} GB"
