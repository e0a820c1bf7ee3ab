"""Answers as labelled arrays and as files, and warnings of points without an answer."""

from __future__ import annotations

import contextlib
import re
import sys
import warnings
from collections import Counter
from collections.abc import Iterable, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.ensembles.job import Answer, Column, Dimension
from percuss.model.units import Units

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset, DataTree

# Reasons that differ only in their numbers count as one.
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")


def dataset_of(
    dimensions: Iterable[Dimension],
    columns: Mapping[str, Column],
    answer: Answer,
    attributes: Mapping[str, object],
    *,
    with_reasons: bool = True,
) -> Dataset:
    """Return an answer as a dataset over its dimensions and those of its columns.

    Parameters
    ----------
    dimensions, columns, answer
        The dimensions, columns and answer of a job.
    attributes
        The attributes of the dataset.
    with_reasons
        Whether it says which points have no answer, and why.
    """
    import xarray

    axes = tuple(dimensions)
    names, shape = [axis.name for axis in axes], [len(axis.values) for axis in axes]
    data: dict[str, Any] = {}
    for name, column in columns.items():
        values = answer.arrays[name]
        dims = column.dims or [f"{name}_{i}" for i in range(values.ndim - 1)]
        about = {"units": column.units, "long_name": column.meaning}
        known = {key: text for key, text in about.items() if text}
        data[name] = ((*names, *dims), values.reshape((*shape, *values.shape[1:])), known)
    data |= _failures(answer) if with_reasons else {}
    return xarray.Dataset(data, coords=coordinates_of(axes), attrs=dict(attributes))


def with_units(dataset: Dataset, units: Units | None) -> Dataset:
    """Return a dataset whose variables name their units in place of dimensions, where there are."""
    if units is not None:
        for variable in dataset.variables.values():
            if "units" in variable.attrs:
                variable.attrs["units"] = units.of(str(variable.attrs["units"]))
    return dataset


def coordinates_of(dimensions: Iterable[Dimension]) -> dict[str, Any]:
    """Return a coordinate for each axis, and for each parameter that varies along one."""
    return {
        one.name: (axis.name, np.array(one.values), {"units": one.units})
        for axis in dimensions
        for one in (axis, *axis.beside)
    }


def _failures(answer: Answer) -> dict[str, Any]:
    """Return the points without an answer and the reasons, as variables of a dataset."""
    points = np.array(list(answer.reasons), dtype=np.int64)
    reasons = np.array(list(answer.reasons.values()), dtype=object)
    return {
        "point": ("failure", points, {"long_name": "number of the point, the last axis fastest"}),
        "reason": ("failure", reasons),
    }


def attributes_of(
    motion: Mapping[str, str], answer: Answer, version: str | None = None
) -> dict[str, object]:
    """Return the attributes of a dataset: the study, the version, and how it ended.

    Parameters
    ----------
    motion
        The oscillator, the forcing and the start in words.
    answer
        The answer.
    version
        The version of percuss that has computed it; default: this one.
    """
    return {
        **motion,
        "percuss": version or metadata.version("percuss"),
        "n_impacts": answer.n_impacts,
        "complete": int(answer.complete),
        "failed": len(answer.reasons),
    }


def write_whole(result: Dataset | DataTree, path: Path) -> None:
    """Write a dataset or a tree of datasets as a NetCDF file.

    HDF5 ends the whole process where the disk is full when it closes a file. So HDF5 writes to
    memory, and Python, which raises an OSError, writes the file.
    """
    with _without_cluster():
        content = result.to_netcdf(engine="h5netcdf")
    path.write_bytes(content)


def _without_cluster() -> contextlib.AbstractContextManager[Any]:
    """Make xarray write without the scheduler of Dask, which may be lost by now."""
    config = sys.modules.get("dask.config")
    return contextlib.nullcontext() if config is None else config.set(scheduler="synchronous")


def commonest(reasons: Iterable[str]) -> tuple[str, int, int]:
    """Return the commonest reason, its number of points, and the number of other reasons.

    Parameters
    ----------
    reasons
        One for each point without an answer, at least one; of a traceback the last line counts.

    Returns
    -------
    tuple of str, int and int
        Of reasons that differ only in their numbers, the first stands for all.

    Examples
    --------
    >>> commonest(["x0 = -1: below the wall", "x0 = -2: below the wall", "mass = -1: not positive"])
    ('x0 = -1: below the wall', 2, 1)
    """
    lines = [(text.strip().splitlines() or [""])[-1] for text in reasons]
    kinds = [NUMBER.sub("#", line) for line in lines]
    (kind, count), *others = Counter(kinds).most_common()
    return lines[kinds.index(kind)], count, len(others)


def warn_of_some(
    things: str, reasons: Iterable[str], total: int, first: str, stacklevel: int = 3
) -> None:
    """Warn that some of many things have no answer, with the parameters of the first."""
    given = list(reasons)
    what = f"{len(given):,} of {total:,} {things} have no answer, the first at {first}"
    warn_of_failures(what, given, stacklevel + 1)


def warn_of_failures(what: str, reasons: Iterable[str], stacklevel: int = 3) -> None:
    """Warn that there is no answer, with the commonest reason and its count.

    Parameters
    ----------
    what
        The beginning of the sentence: what has no answer, and for how many points.
    reasons
        One for each of these points.
    stacklevel
        As `warnings.warn` takes it; default: the caller of the function that calls this one.
    """
    given = list(reasons)
    reason, count, others = commonest(given)
    which = "the commonest reason" if others else "the reason"
    message = f"{what}; {which} ({count:,} of {len(given):,}): {reason}"
    warnings.warn(message, stacklevel=stacklevel)
