"""Ragged columns: arrays whose length differs from orbit to orbit (CF conventions, 9.3)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr


def ragged_columns(name: str, columns: dict[str, list[Any]]) -> dict[str, Any]:
    """Return arrays of different lengths joined into one, for columns that share the lengths.

    Parameters
    ----------
    name
        Name of what they belong to; ``name_count`` holds the lengths.
    columns
        By the names of the columns an array for each orbit; complex ones get a last axis of two.

    Returns
    -------
    dict
        The variables of a dataset over ``orbit``.
    """
    counts = [len(array) for array in next(iter(columns.values()))]
    data: dict[str, Any] = {f"{name}_count": ("orbit", np.array(counts, dtype=np.int64))}
    for path, arrays in columns.items():
        whole = np.concatenate(arrays)
        if whole.dtype.kind == "c":
            whole = np.stack([whole.real, whole.imag], axis=-1)
        tail = tuple(f"{name}_column{i}" for i in range(1, whole.ndim))
        data[path] = ((f"{name}_row", *tail), whole, {"sample_dimension": "orbit"})
    return data


def parted(data: xr.Dataset, name: str, path: str) -> Iterator[Any]:
    """Yield the parts of a column that `ragged_columns` has made, one an orbit.

    Raises
    ------
    ValueError
        If the lengths do not fit the column.
    """
    whole = data[path].values
    if name == "multipliers":
        whole = np.ascontiguousarray(whole).view(np.complex128)[..., 0]
    if path.endswith((".stop", "_sequence", "_marks")):
        whole = whole.astype(np.int64)
    ends = np.cumsum(data[f"{name}_count"].values)
    if ends[-1] != len(whole):
        raise ValueError(f"{path} has {len(whole)} rows, not {ends[-1]}")
    yield from (part.copy() for part in np.split(whole, ends[:-1]))
