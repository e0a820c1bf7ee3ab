"""Whether an answer fits into memory or onto a disk, asked before anything is done for it."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

__all__ = ["in_gigabytes", "memory", "room_on_disk", "too_large"]

# Bytes that are taken for the memory of a machine that does not tell.
UNTOLD = 1 << 44
# Bytes of a number.
NUMBER = 8
# Where Linux tells what is available, and what a group of processes may have and has.
AVAILABLE = Path("/proc/meminfo")
GROUP_MOST, GROUP_TAKEN = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")


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


def room_on_disk(path: Path) -> int:
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
    size = NUMBER * math.prod(shape) * each
    free = memory()
    if size <= free:
        return None
    points = f"{math.prod(shape):,} points" if math.prod(shape) != 1 else "1 point"
    takes = f"{points}, whose answer takes {in_gigabytes(size)}"
    if store is None:
        return f"{takes}; this machine has {in_gigabytes(free)} of memory to be had"
    # Its chunks, and the answer as it is put together.
    disk = room_on_disk(store)
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
