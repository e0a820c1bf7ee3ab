"""Answers as labelled arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.ensembles.grid import Grid
from percuss.ensembles.job import Answer, Column, Dimension

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["attributes_of", "coordinates_of", "dataset_of", "motion_of"]


def dataset_of(
    dimensions: Iterable[Dimension],
    columns: Mapping[str, Column],
    answer: Answer,
    attributes: Mapping[str, object],
) -> Dataset:
    """Return an answer with one number a point as a dataset over its dimensions."""
    import xarray

    axes = tuple(dimensions)
    names, shape = tuple(it.name for it in axes), tuple(len(it.values) for it in axes)
    data: dict[str, Any] = {}
    for name, column in columns.items():
        about = {"units": column.units, "long_name": column.meaning}
        known = {key: text for key, text in about.items() if text}
        data[name] = (names, answer.arrays[name].reshape(shape), known)
    return xarray.Dataset(
        data | _failures(answer), coords=coordinates_of(axes), attrs=dict(attributes)
    )


def coordinates_of(dimensions: Iterable[Dimension]) -> dict[str, Any]:
    """Return a coordinate for each axis."""
    return {it.name: (it.name, np.array(it.values), {"units": it.units}) for it in dimensions}


def _failures(answer: Answer) -> dict[str, Any]:
    """Return which points have no answer, and why."""
    points = np.array(list(answer.reasons), dtype=np.int64)
    reasons = np.array(list(answer.reasons.values()), dtype=object)
    return {
        "point": ("failure", points, {"long_name": "number of the point, the last axis fastest"}),
        "reason": ("failure", reasons),
    }


def motion_of(grid: Grid) -> dict[str, str]:
    """Return what moves and from where, in words."""
    return {
        "oscillator": repr(grid.osc),
        "forcing": repr(grid.force),
        "start": repr(grid.start),
    }


def attributes_of(
    motion: Mapping[str, str], answer: Answer, version: str | None = None
) -> dict[str, object]:
    """Return what was studied, with what, whether to its end, and how many points have failed.

    Parameters
    ----------
    motion
        What `motion_of` returns.
    answer
        What came of it.
    version
        That of percuss which has computed it; default: this one.
    """
    return {
        **motion,
        "percuss": version or metadata.version("percuss"),
        "n_impacts": answer.n_impacts,
        "complete": int(answer.complete),
        "failed": len(answer.reasons),
    }
