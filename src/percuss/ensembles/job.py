"""A job: a study of many motions in chunks that can be computed anywhere and in any order."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError

# Bytes assumed as the memory of a machine whose system does not tell.
UNTOLD = 1 << 44
# Bytes of a number.
BYTES_OF_A_NUMBER = 8
# Where Linux tells the available memory, and the limit and use of a control group.
AVAILABLE = Path("/proc/meminfo")
GROUP_MOST, GROUP_TAKEN = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")


@dataclass(frozen=True, slots=True)
class Column:
    """One array of the answer."""

    tail: tuple[int, ...] = ()  # shape of the entry of one point
    dtype: str = "f8"  # or "i8"
    dims: tuple[str, ...] = ()  # names of the dimensions of the tail
    units: str = "1"  # in length and time; "" where they are not known
    meaning: str = ""  # in a line; "" where the name says it

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
    beside
        Further coordinates along it: parameters that take their values together.
    """

    name: str
    values: tuple[float, ...] | tuple[str, ...]
    units: str = "1"
    beside: tuple[Dimension, ...] = ()

    def description(self) -> list[Any]:
        """Return it as JSON can hold it."""
        own: list[Any] = [self.name, list(self.values), self.units]
        return [*own, [other.description() for other in self.beside]] if self.beside else own

    @classmethod
    def of_description(cls, description: Sequence[Any]) -> Dimension:
        """Return what a description is of."""
        name, values, units, *beside = description
        others = tuple(cls.of_description(other) for own in beside for other in own)
        return cls(name, tuple(values), units, others)


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
        Number of impacts computed.
    """

    arrays: dict[str, NDArray[np.generic]]
    reasons: dict[int, str] = field(default_factory=dict)
    n_impacts: int = 0

    @classmethod
    def empty(cls, columns: Mapping[str, Column], n: int) -> Block:
        """Return that of n points without an answer yet."""
        return cls({name: column.empty(n) for name, column in columns.items()})


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a job.

    Attributes
    ----------
    arrays
        By column, (size, *tail) each; NaN and -1 where a chunk is missing.
    reasons
        Why points have no answer, by point, in order.
    n_impacts
        Number of impacts computed.
    complete
        False where it was stopped before its end.
    n_done
        Of a part of a job array the number of points that are done; its data stay in its store.
    """

    arrays: dict[str, NDArray[np.generic]]
    reasons: dict[int, str]
    n_impacts: int
    complete: bool
    n_done: int = 0


class Job(Protocol):
    """The work of an engine: pickled once, computed chunk by chunk in any order."""

    @property
    def size(self) -> int:
        """Number of points."""
        ...

    @property
    def chunk(self) -> int:
        """Points of a chunk; the same on every machine."""
        ...

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the answer."""
        ...

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes, whose lengths multiply to the size; the last is the fastest."""
        ...

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others, as JSON can hold it."""
        ...

    def compute(self, first: int, last: int) -> Block:
        """Return the answer for the points from first to last, the last not included."""
        ...


def check_room(job: Job, store: Path | None = None, hint: str = "") -> None:
    """Raise a `ParameterError`, which ends with a hint, unless memory can hold the answer.

    With a store the disk of its folder may hold it instead.
    """
    problem = too_large([job.size], numbers_of(job), store)
    if problem is not None:
        axes = job.dimensions
        shape = " x ".join(f"{len(axis.values):,}" for axis in axes)
        raise ParameterError(", ".join(axis.name for axis in axes), shape, problem + hint)


def numbers_of(job: Job) -> int:
    """Return how many numbers of 8 bytes the answer for one point has."""
    return sum(math.prod(column.tail) for column in job.columns.values())


def chunks_of(job: Job) -> list[tuple[int, int]]:
    """Return first and last point of each chunk, the last not included."""
    return spans_of(job.size, job.chunk)


def spans_of(size: int, chunk: int) -> list[tuple[int, int]]:
    """Return first and last point of chunks of this length, the last not included."""
    return [(first, min(first + chunk, size)) for first in range(0, size, chunk)]


def memory() -> int:
    """Return the available memory [bytes]: free, or in use as a cache only."""
    try:
        available = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return UNTOLD
    with contextlib.suppress(OSError, ValueError, StopIteration):
        rows = (line.split() for line in AVAILABLE.read_text(encoding="ascii").splitlines())
        kilobytes = next(int(row[1]) for row in rows if row[0] == "MemAvailable:")
        available = min(available, 1024 * kilobytes)
    with contextlib.suppress(OSError, ValueError):
        # Not a number, "max", where there is no limit.
        most = int(GROUP_MOST.read_text(encoding="ascii"))
        available = min(available, most - int(GROUP_TAKEN.read_text(encoding="ascii")))
    return max(0, available)


def free_on_disk(path: Path) -> int:
    """Return the free bytes of the disk on which a folder is or will be made."""
    existing = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    return shutil.disk_usage(existing).free


def too_large(shape: Sequence[int], each: int = 1, store: Path | None = None) -> str | None:
    """Return why an answer is too large for this machine, None where it is not.

    Parameters
    ----------
    shape
        Points along each axis.
    each
        Numbers of 8 bytes for each point.
    store
        Folder on whose disk the answer is kept where memory cannot hold it; None: in memory.

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
    # The chunks, and the answer that is put together from them.
    disk = free_on_disk(store)
    if 2 * size <= disk:
        return None
    return f"{takes} in a store and as much beside it; its disk has {in_gigabytes(disk)} free"


def in_gigabytes(size: int) -> str:
    """Return a number of bytes in words.

    Examples
    --------
    >>> in_gigabytes(12_800_000_000), in_gigabytes(480_000_000)
    ('13 GB', '0.48 GB')
    """
    value = size / 1e9
    return f"{value:,.0f} GB" if value >= 10.0 else f"{value:.2g} GB"
