"""Types of arrays, each named once."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
Complexes: TypeAlias = NDArray[np.complex128]
Integers: TypeAlias = NDArray[np.int64]
Flags: TypeAlias = NDArray[np.bool_]


def row_of(values: ArrayLike) -> Floats:
    """Return numbers of any shape as one row that a kernel takes: contiguous and writable.

    Each kernel is compiled for one layout of its arrays; one of read-only numbers would be another
    program, and cost the user seconds.

    Examples
    --------
    >>> row_of([[1, 2], [3, 4]])
    array([1., 2., 3., 4.])
    """
    return np.require(values, np.float64, ["C", "W"]).reshape(-1)


def numbers_within(counts: Integers) -> Integers:
    """Return each member's number in its group, of so many: of (2, 0, 3) it is (0, 1, 0, 1, 2)."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
