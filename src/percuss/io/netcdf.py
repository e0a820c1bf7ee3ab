"""Whole results as NetCDF files, and back."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from percuss.ensembles.datasets import write_whole
from percuss.errors import PercussError, check_installed
from percuss.io.column_units import Columns
from percuss.io.exact_json import decoded, encoded
from percuss.io.files import OutputFiles, say_size
from percuss.io.fit_tables import fit_datasets
from percuss.io.ragged import parted, ragged_columns
from percuss.io.record import NETCDF_ATTRIBUTE, Record, make_record
from percuss.io.results import SAMPLES, ResultKind, kind_of, table_of
from percuss.io.structure_orbits import structure_orbits_dataset, structure_orbits_of_dataset
from percuss.io.table import check_suffix
from percuss.model.oscillator import mass_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.tables import Impacts
from percuss.motion.trajectory import Trajectory
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.orbits.orbit.turning_points import Passages

TABLES = ("impacts", "crossings", "contacts", "grazes")
# Groups of the exact result; the others are tables for other programs.
EXACT, ORBITS, OF_STRUCTURES, DATA = "exact", "orbits", "orbits_of_structures", "data"
# The attribute of the root that names those of the file.
OF_FILE = "attributes_of_the_file"

# What NetCDF files need: the modules of the extra of that name.
OF_NETCDF = ("h5netcdf", "h5py")


def save_netcdf(
    result: Any,
    path: Path | str,
    *,
    study: str | None = None,
    command: str | None = None,
    samples: int = SAMPLES,
    force: bool = False,
) -> None:
    """Save a result as NetCDF, with the record that repeats it.

    Parameters
    ----------
    result
        A run, an orbit, a list of orbits, a branch, a curve, a response, a design, a front, a fit,
        or a dataset of an ensemble. The main table is at the root, where
        ``xarray.open_dataset(path)`` finds it: the motion of a run or an orbit, the table of what
        else it is. Groups hold the other tables, such as impacts, crossings, contacts and grazes of
        a run.
    path
        The file, with the suffix ``.nc``.
    study, command
        As in `percuss.io.make_record`; the file's attributes hold the record.
    samples
        Number of equally spaced times of a motion, >= 2.
    force
        Whether a file of that name may be replaced.

    Raises
    ------
    OutputError
        If the suffix is another one, the file exists and `force` is false, or cannot be written.
    ParameterError
        If it is no result of percuss.
    MissingExtraError
        If h5netcdf or h5py is not installed.
    """
    check_suffix(path, ".nc")
    check_netcdf()
    record = make_record(result, study=study, command=command)
    with OutputFiles(path, force=force) as files:
        write_netcdf(result, files[path], record, samples=samples)


def check_netcdf() -> None:
    """Raise a `MissingExtraError` unless the packages that NetCDF files need are installed."""
    check_installed("a NetCDF file", "netcdf", *OF_NETCDF)


def write_netcdf(result: Any, path: Path, record: Record, *, samples: int = SAMPLES) -> None:
    """Write a result under the name `path`."""
    kind = kind_of(result)
    if kind.name == "motion":
        groups = _of_motion(result, samples)
    elif kind.name == "dataset":
        groups = {"/": _writable(result)}
    elif kind.name == "design":
        groups = _of_design(result, kind, samples)
    elif kind.name == "fit":
        groups = {name: _writable(data) for name, data in fit_datasets(result, samples).items()}
    else:
        groups = _of_orbits(result, kind, samples)
    own = _attributes(record, kind.title, kind.name)
    # What the result says of itself stays, and is told from what the file says.
    mine = {key: value for key, value in own.items() if key not in groups["/"].attrs}
    groups["/"] = groups["/"].assign_attrs(mine | {OF_FILE: json.dumps(sorted(mine))})
    say_size(path, sum(group.nbytes for group in groups.values()))
    write_whole(xr.DataTree.from_dict(groups), path)


def _of_motion(run: Trajectory | StructureTrajectory, samples: int) -> dict[str, xr.Dataset]:
    tables = {f"/{name}": _writable(getattr(run, name).to_xarray()) for name in TABLES}
    return {"/": _samples_of(run, samples), **tables}


def _samples_of(run: Trajectory | StructureTrajectory, samples: int) -> xr.Dataset:
    """Return the motion over its samples: groups would take an index by time for their own."""
    data = run.sample(samples)
    model = run.structure if isinstance(run, StructureTrajectory) else run.oscillator
    if model.stops:
        # Groups inherit the coordinates of the root: theirs would hide the stops of the events.
        data = data.assign(stop_force=run.forces(data.t.values).stops.drop_vars("stop"))
    data = data.rename_dims(t="sample")
    return data.drop_indexes("t").drop_attrs(deep=False)


def _of_design(result: Any, kind: ResultKind, samples: int) -> dict[str, xr.Dataset]:
    """Return the tables of a design or a front, and of a design its motion."""
    main, *others = kind.columns.items()
    groups = {"/": _writable(_table_of(main[1](result)))}
    # Tables of another length than that of the root need a dimension of their own.
    groups |= {f"/{name}": _writable(_table_of(columns(result), name)) for name, columns in others}
    if not hasattr(result, "run"):
        return groups
    motion = _of_motion(result.run, samples)
    return groups | {"/motion": motion.pop("/")} | motion


def _table_of(columns: Columns, dim: str = "row") -> xr.Dataset:
    """Return the table of a list of results as a dataset, a row for each of its rows."""
    data = {}
    for name, column in columns.items():
        values = np.array(np.asarray(column).tolist())
        texts = values.dtype.kind not in "iuf"
        data[name] = (dim, np.array([str(v) for v in column], dtype=object) if texts else values)
    return xr.Dataset(data)


def _of_orbits(result: Any, kind: ResultKind, samples: int) -> dict[str, xr.Dataset]:
    """Return the tables, and the exact result: its orbits, and all else as JSON."""
    tables = kind.tables(result)
    if isinstance(result, PeriodicOrbit):
        main = _samples_of(result.trajectory(), samples)
    elif isinstance(result, StructureOrbit):
        main, *events = _of_motion(result.run, samples).values()
        tables = dict(zip(TABLES, events, strict=True)) | tables
    elif len(tables) == 1 and not isinstance(result, list | tuple):
        # Without an index, as above.
        main = next(iter(tables.values()))
        main = main.drop_indexes(list(main.indexes))
        tables = {}
    else:
        main = _table_of(table_of(result, next(iter(kind.columns))))
    # By identity: the orbit of a special point is a row of its branch, and stays so.
    orbits: dict[int, Any] = {}
    places: dict[int, int] = {}

    def number(value: Any) -> dict[str, int] | None:
        if not isinstance(value, PeriodicOrbit | StructureOrbit):
            return None
        orbits.setdefault(id(value), value)
        return {"orbit": places.setdefault(id(value), len(places))}

    text = json.dumps(encoded(result, number))
    groups = {"/": _writable(main)}
    groups |= {f"/{name}": _writable(table) for name, table in tables.items()}
    if orbits:
        every = list(orbits.values())
        if isinstance(every[0], StructureOrbit):
            groups[f"/{OF_STRUCTURES}"] = structure_orbits_dataset(every)
        else:
            groups[f"/{ORBITS}"] = orbits_dataset(every)
    groups[f"/{EXACT}"] = xr.Dataset({"result": ((), text)})
    return groups


def load_netcdf(path: Path | str) -> Any:
    """Load what `save_netcdf` saved.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    DataTree, PeriodicOrbit, StructureOrbit, list, a branch, a curve, Response or Dataset
        A run as a tree, its motion at the root and its events in groups; the attributes hold the
        record; so are a design, a front and a fit. Other results, those of structures too, as they
        were saved, every field to the bit. All in memory; the file is closed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    OSError
        If it is no NetCDF file, or holds no complete result of percuss.
    """
    if not Path(path).exists():
        raise FileNotFoundError(f"{path}: no such file")
    check_netcdf()
    try:
        with xr.open_datatree(path, engine="h5netcdf") as opened:
            tree = opened.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise OSError(f"{path}: not a NetCDF file that percuss can read") from error
    if NETCDF_ATTRIBUTE not in tree.attrs:
        raise OSError(f"{path}: holds no result of percuss")
    if DATA in tree.children:  # of version 0.1
        return tree[DATA].to_dataset()
    if tree.attrs.get("kind") == "dataset":
        data = tree.to_dataset()
        data.attrs = {k: v for k, v in data.attrs.items() if k not in _of_file(data)}
        return data
    if EXACT not in tree.children:
        return tree
    try:
        return _result(tree)
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, PercussError) as error:
        raise OSError(f"{path}: damaged, or of another version of percuss ({error})") from error


def _of_file(data: xr.Dataset) -> list[str]:
    """Return the attributes that are the file's, and not the result's."""
    return [OF_FILE, *json.loads(str(data.attrs.get(OF_FILE, "[]")))]


def _result(tree: xr.DataTree) -> Any:
    orbits: list[Any] = []
    if ORBITS in tree.children:
        orbits = list(orbits_of_dataset(tree[ORBITS].to_dataset()))
    elif OF_STRUCTURES in tree.children:
        orbits = list(structure_orbits_of_dataset(tree[OF_STRUCTURES].to_dataset()))
    text = tree[EXACT].to_dataset()["result"].item()
    return decoded(json.loads(text), orbits.__getitem__)


def _attributes(record: Record, title: str, kind: str) -> dict[str, str]:
    return {
        "title": f"percuss: {title}",
        "kind": kind,
        NETCDF_ATTRIBUTE: record.text(),
        "study": record.study,
        "command": record.command,
        "date": record.date,
        "outcome": record.outcome,
        **{f"{package}_version": version for package, version in record.versions},
    }


def _writable(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset as NetCDF can hold it."""
    # As objects: NetCDF has texts of any length, but no empty array of texts of a fixed length.
    names: Iterable[Any] = [*dataset.data_vars, *dataset.coords]
    texts = {key: dataset[key].astype(object) for key in names if dataset[key].dtype.kind == "U"}
    flags = {key: dataset[key].astype("i1") for key in names if dataset[key].dtype.kind == "b"}
    return dataset.assign(texts | {k: v for k, v in flags.items() if k in dataset.data_vars})


# Fields that are tables of columns of one length.
_TABLES: dict[str, type[Any]] = {"impacts": Impacts, "passages": Passages}
_MODEL = ("oscillator", "forcing")
# Fields of tables that are those of the model.
_OF_MODEL = ("mass", "units")


def orbits_dataset(orbits: Sequence[PeriodicOrbit]) -> xr.Dataset:
    """Return orbits as a dataset over ``orbit``.

    Numbers are columns. Arrays whose length differs from orbit to orbit are joined into one, with
    the lengths in a ``_count``. `model` holds the different pairs of oscillator and forcing,
    `of_model` the number of the pair of each orbit.

    Parameters
    ----------
    orbits
        The orbits, at least one.

    Returns
    -------
    xarray.Dataset
        The dataset from which `orbits_of_dataset` makes the same orbits.
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
            columns = _columns_of(_TABLES[name])
            data |= ragged_columns(name, {f"{name}.{column}": [getattr(value, column) for value in values]
                                   for column in columns})  # fmt: skip
        elif isinstance(first, np.ndarray):
            data |= ragged_columns(name, {name: values})
        else:
            data[name] = ("orbit", _column(values))
    return xr.Dataset(data)


def orbits_of_dataset(data: xr.Dataset) -> list[PeriodicOrbit]:
    """Return the orbits of a dataset that `orbits_dataset` made.

    Raises
    ------
    KeyError, ValueError, TypeError, IndexError
        If the dataset is of another form.
    """
    models = [decoded(json.loads(text)) for text in data["model"].values]
    names = [field.name for field in dataclasses.fields(PeriodicOrbit) if field.name not in _MODEL]
    columns = {name: list(_values(data, name)) for name in names}
    orbits = []
    for i, number in enumerate(data["of_model"].values.tolist()):
        oscillator, forcing = models[number]
        fields = {name: columns[name][i] for name in names}
        of_model = {"mass": mass_of(oscillator), "units": oscillator.units}
        fields["impacts"] = dataclasses.replace(fields["impacts"], **of_model)
        orbits.append(PeriodicOrbit(oscillator, forcing, **fields))
    return orbits


def _columns_of(kind: type[Any]) -> list[str]:
    """Return the names of the fields of a table that are its columns."""
    return [field.name for field in dataclasses.fields(kind) if field.name not in _OF_MODEL]


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


def _values(data: xr.Dataset, name: str) -> Iterator[Any]:
    """Yield the values of a field, one an orbit."""
    if name in _TABLES:
        kind = _TABLES[name]
        names = _columns_of(kind)
        parts = [list(parted(data, name, f"{name}.{column}")) for column in names]
        yield from (kind(*columns) for columns in zip(*parts, strict=True))
    elif f"{name}_count" in data:
        yield from parted(data, name, name)
    else:
        kinds = {field.name: field.type for field in dataclasses.fields(PeriodicOrbit)}
        for value in data[name].values.tolist():
            yield _number(value, str(kinds[name]), name)


def _number(value: Any, kind: str, name: str) -> Any:
    if kind == "bool":
        return bool(value)
    if name == "n_impacts" and isinstance(value, float) and math.isfinite(value):
        return int(value)
    return value
