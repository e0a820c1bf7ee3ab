"""Answers as labelled arrays."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.ensembles.grid import Grid
from percuss.ensembles.running import Answer
from percuss.ensembles.units import units_of

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["attributes_of", "coordinates_of", "dataset_of", "failures_of"]


def dataset_of(
    grid: Grid, answer: Answer, units: Mapping[str, str], meanings: Mapping[str, str]
) -> Dataset:
    """Return an answer with one number a point as a dataset over the axes of its grid."""
    import xarray

    dims = tuple(axis.path for axis in grid.axes)
    data: dict[str, Any] = {}
    for name, values in answer.arrays.items():
        about = {"units": units[name], "long_name": meanings[name]} if name in units else {}
        data[name] = (dims, values.reshape(grid.shape), about)
    return xarray.Dataset(
        data | failures_of(answer),
        coords=coordinates_of(grid),
        attrs=attributes_of(grid, answer),
    )


def coordinates_of(grid: Grid) -> dict[str, Any]:
    """Return a coordinate for each axis."""
    return {
        axis.path: (axis.path, axis.values, {"units": units_of(axis.path)}) for axis in grid.axes
    }


def failures_of(answer: Answer) -> dict[str, Any]:
    """Return which points have no answer, and why."""
    points = np.array(list(answer.reasons), dtype=np.int64)
    reasons = np.array(list(answer.reasons.values()), dtype=object)
    return {
        "point": ("failure", points, {"long_name": "number of the point, the last axis fastest"}),
        "reason": ("failure", reasons),
    }


def attributes_of(grid: Grid, answer: Answer) -> dict[str, Any]:
    """Return what was studied, with what, whether to its end, and how many points have failed."""
    return {
        "oscillator": repr(grid.osc),
        "forcing": repr(grid.force),
        "start": repr(grid.start),
        "percuss": metadata.version("percuss"),
        "n_impacts": answer.n_impacts,
        "complete": int(answer.complete),
        "failed": len(answer.reasons),
    }
