"""Many periodic orbits as one dataset, every field to the bit, and back."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import xarray as xr

from percuss.io.exactly import decoded, encoded
from percuss.motion.tables import Impacts
from percuss.orbits.orbit.passages import Passages
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["orbits_dataset", "orbits_of_dataset"]

# Fields that are tables of columns of one length.
_TABLES: dict[str, type[Any]] = {"impacts": Impacts, "passages": Passages}
_MODEL = ("oscillator", "forcing")


def orbits_dataset(orbits: Sequence[PeriodicOrbit]) -> xr.Dataset:
    """Return orbits as a dataset over ``orbit``.

    Numbers are columns. An array whose length differs from orbit to orbit stands in one long
    array, one orbit's rows after another's; its ``_count`` says how many are whose. `model` holds
    the different pairs of oscillator and forcing, `of_model` which of them an orbit has.

    Parameters
    ----------
    orbits
        The orbits, at least one.

    Returns
    -------
    xarray.Dataset
        From which `orbits_of_dataset` makes the same orbits.
    """
    models: dict[str, int] = {}
    for orbit in orbits:
        models.setdefault(_model_text(orbit), len(models))
    data: dict[str, Any] = {
        "model": ("model_number", np.array(list(models), dtype=object)),
        "of_model": ("orbit", np.array([models[_model_text(orbit)] for orbit in orbits])),
    }
    for field in dataclasses.fields(PeriodicOrbit):
        name, first = field.name, getattr(orbits[0], field.name)
        if name in _MODEL:
            continue
        values = [getattr(orbit, name) for orbit in orbits]
        if name in _TABLES:
            columns = [column.name for column in dataclasses.fields(_TABLES[name])]
            data |= _ragged(name, {f"{name}.{column}": [getattr(value, column) for value in values]
                                   for column in columns})  # fmt: skip
        elif isinstance(first, np.ndarray):
            data |= _ragged(name, {name: values})
        else:
            data[name] = ("orbit", _column(values))
    return xr.Dataset(data)


def orbits_of_dataset(data: xr.Dataset) -> list[PeriodicOrbit]:
    """Return the orbits of a dataset that `orbits_dataset` made.

    Raises
    ------
    KeyError, ValueError, TypeError, IndexError
        If it is nothing of the kind.
    """
    models = [decoded(json.loads(text)) for text in data["model"].values]
    names = [field.name for field in dataclasses.fields(PeriodicOrbit) if field.name not in _MODEL]
    columns = {name: list(_values(data, name)) for name in names}
    orbits = []
    for i, number in enumerate(data["of_model"].values.tolist()):
        oscillator, forcing = models[number]
        fields = {name: columns[name][i] for name in names}
        orbits.append(PeriodicOrbit(oscillator, forcing, **fields))
    return orbits


def _model_text(orbit: PeriodicOrbit) -> str:
    return json.dumps(encoded((orbit.oscillator, orbit.forcing)))


def _column(values: list[Any]) -> Any:
    """Return numbers or texts as an array that NetCDF can hold."""
    if isinstance(values[0], str):
        return np.array(values, dtype=object)
    if isinstance(values[0], bool):
        return np.array(values, dtype=np.int8)
    # A number of impacts may be infinite.
    whole = all(isinstance(value, int) for value in values)
    return np.array(values, dtype=np.int64 if whole else np.float64)


def _ragged(name: str, columns: dict[str, list[Any]]) -> dict[str, Any]:
    """Return arrays of several lengths one after another, columns of one table alike."""
    counts = [len(array) for array in next(iter(columns.values()))]
    data: dict[str, Any] = {f"{name}_count": ("orbit", np.array(counts, dtype=np.int64))}
    for path, arrays in columns.items():
        whole = np.concatenate(arrays)
        if whole.dtype.kind == "c":
            whole = np.stack([whole.real, whole.imag], axis=-1)
        tail = tuple(f"{name}_column{i}" for i in range(1, whole.ndim))
        data[path] = ((f"{name}_row", *tail), whole, {"sample_dimension": "orbit"})
    return data


def _values(data: xr.Dataset, name: str) -> Iterator[Any]:
    """Give the values of a field, orbit after orbit."""
    if name in _TABLES:
        kind = _TABLES[name]
        names = [column.name for column in dataclasses.fields(kind)]
        parts = [list(_split(data, name, f"{name}.{column}")) for column in names]
        yield from (kind(*columns) for columns in zip(*parts, strict=True))
    elif f"{name}_count" in data:
        yield from _split(data, name, name)
    else:
        kinds = {field.name: field.type for field in dataclasses.fields(PeriodicOrbit)}
        for value in data[name].values.tolist():
            yield _number(value, str(kinds[name]), name)


def _split(data: xr.Dataset, name: str, path: str) -> Iterator[Any]:
    whole = data[path].values
    if name == "multipliers":
        whole = np.ascontiguousarray(whole).view(np.complex128)[..., 0]
    if path.endswith((".stop", "_chain", "_marks")):
        whole = whole.astype(np.int64)
    ends = np.cumsum(data[f"{name}_count"].values)
    if ends[-1] != len(whole):
        raise ValueError(f"{path} has {len(whole)} rows, not {ends[-1]}")
    yield from (part.copy() for part in np.split(whole, ends[:-1]))


def _number(value: Any, kind: str, name: str) -> Any:
    if kind == "bool":
        return bool(value)
    if name == "n_impacts" and isinstance(value, float) and math.isfinite(value):
        return int(value)
    return value
