"""Whether an answer fits into memory, asked before anything is done for it."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

__all__ = ["memory", "too_large"]

# Bytes that are taken for the memory of a machine that does not tell.
UNTOLD = 1 << 44
# Bytes of a number.
NUMBER = 8


def memory() -> int:
    """Return how much memory this machine has [bytes]."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return UNTOLD


def too_large(shape: Sequence[int], each: int = 1) -> str | None:
    """Return why an answer is too large for this machine, None where it is not.

    Parameters
    ----------
    shape
        Points along each axis.
    each
        Numbers of 8 bytes for each point.

    Examples
    --------
    >>> too_large([100, 100])
    >>> print(too_large([10**5] * 3).partition(";")[0])
    1,000,000,000,000,000 points, whose answer takes 8,000,000 GB
    """
    size = NUMBER * math.prod(shape) * each
    if size <= memory():
        return None
    points = f"{math.prod(shape):,} points" if math.prod(shape) != 1 else "1 point"
    return (
        f"{points}, whose answer takes {_gigabytes(size)}; this machine has "
        f"{_gigabytes(memory())} of memory"
    )


def _gigabytes(size: int) -> str:
    value = size / 1e9
    return f"{value:,.0f} GB" if value >= 10.0 else f"{value:.2g} GB"
