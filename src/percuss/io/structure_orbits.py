"""Periodic orbits of structures as a dataset, and back to the bit."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from percuss.io.exact_json import decoded, encoded
from percuss.io.ragged import parted, ragged_columns
from percuss.kernels.record import N_EVENTS, N_GRAZES, NEXT_REGION
from percuss.kernels.structure.run import SET, StructureRun, new_run
from percuss.model.acting_sets import StructureSystem
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.orbits.orbit.structure_orbit import StructureOrbit

# Values of the model, of which many orbits have the same; arrays of the record of the motion.
MODEL = ("structure", "loads")
RECORD = ("events", "marks", "states", "grazes", "state")
ARRAYS = ("x0", "v0", "multipliers", "monodromy")
NUMBERS = {"n_periods": int, "residual": float, "admissible": bool}


def structure_orbits_dataset(orbits: Sequence[StructureOrbit]) -> xr.Dataset:
    """Return orbits of structures as a dataset over ``orbit``.

    Each has its numbers, and the record of its motion as the kernels wrote it, from which the
    tables of events follow. Sets of acting stops are told by their bits, not by the order in which
    a process happened to meet them. The different structures and loads are held once.

    Parameters
    ----------
    orbits
        The orbits, at least one.

    Returns
    -------
    xarray.Dataset
        The dataset from which `structure_orbits_of_dataset` makes the same orbits.
    """
    data: dict[str, Any] = {}
    for name in MODEL:
        texts = [json.dumps(encoded(getattr(orbit, name))) for orbit in orbits]
        numbers = {text: i for i, text in enumerate(dict.fromkeys(texts))}
        data[name] = (f"{name}_number", np.array(list(numbers), dtype=object))
        data[f"of_{name}"] = ("orbit", np.array([numbers[text] for text in texts]))
    for name, kind in NUMBERS.items():
        values = [getattr(orbit, name) for orbit in orbits]
        stored = np.int8 if kind is bool else np.int64 if kind is int else np.float64
        data[name] = ("orbit", np.array(values, dtype=stored))
    for name in ARRAYS:
        data |= ragged_columns(name, {name: [getattr(orbit, name) for orbit in orbits]})
    for name in RECORD:
        arrays = [_array_of(orbit.run.record, name) for orbit in orbits]
        data |= ragged_columns(f"run_{name}", {f"run_{name}": arrays})
    start = [orbit.run.start for orbit in orbits]
    ends = [(orbit.run.t0, orbit.run.t_end) for orbit in orbits]
    data["run_start"] = ("orbit", np.array([json.dumps(encoded(s)) for s in start], dtype=object))
    data["run_ends"] = (("orbit", "end"), np.array(ends))
    return xr.Dataset(data)


def structure_orbits_of_dataset(data: xr.Dataset) -> list[StructureOrbit]:
    """Return the orbits of a dataset that `structure_orbits_dataset` made.

    Raises
    ------
    KeyError, ValueError, TypeError, IndexError
        If the dataset is of another form.
    """
    model = {name: [decoded(json.loads(text)) for text in data[name].values] for name in MODEL}
    arrays = {name: list(parted(data, name, name)) for name in ARRAYS}
    records = {name: list(parted(data, f"run_{name}", f"run_{name}")) for name in RECORD}
    orbits = []
    for i, text in enumerate(data["run_start"].values):
        structure, loads = (model[name][int(data[f"of_{name}"].values[i])] for name in MODEL)
        system = StructureSystem.of(structure, loads)
        record = _record_of(system, {name: records[name][i] for name in RECORD})
        end = float(data["run_ends"].values[i, 1])
        start = decoded(json.loads(text))
        run = StructureTrajectory.of_run(system, start, record, end, Outcome.reached_t_end)
        own: dict[str, Any] = {name: kind(data[name].values[i]) for name, kind in NUMBERS.items()}
        own |= {name: arrays[name][i] for name in ARRAYS}
        orbits.append(StructureOrbit(structure=structure, loads=loads, run=run, **own))
    return orbits


def _array_of(record: StructureRun, name: str) -> Any:
    """Return an array of a record, in marks the bits of the acting stops for the set's number."""
    array = getattr(record, name)
    if name == "marks":
        array = array.copy()
        array[:, NEXT_REGION] = record.sets.keys[array[:, NEXT_REGION]]
    return array


def _record_of(system: StructureSystem, arrays: dict[str, Any]) -> StructureRun:
    """Return a record of these arrays, with the sets of acting stops that it meets."""
    marks = arrays["marks"].astype(np.int64)
    marks[:, NEXT_REGION] = system.numbers_of(marks[:, NEXT_REGION].tolist())
    fresh = new_run(system.sets, 0, 0)
    fresh.counters[N_EVENTS], fresh.counters[N_GRAZES] = len(marks), len(arrays["grazes"])
    fresh.counters[SET] = marks[-1, NEXT_REGION]
    return fresh._replace(**arrays | {"marks": marks})
