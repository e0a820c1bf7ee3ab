"""Whole results as NetCDF files, and back."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import xarray as xr

from percuss.ensembles.datasets import write_whole
from percuss.errors import PercussError
from percuss.io.exactly import decoded, encoded
from percuss.io.files import OutputFiles, tell_size
from percuss.io.orbit_tables import orbits_dataset, orbits_of_dataset
from percuss.io.reading import NETCDF_ATTRIBUTE
from percuss.io.record import Record, make_record
from percuss.io.results import SAMPLES, kind_of
from percuss.io.table import check_suffix
from percuss.motion.trajectory import Trajectory
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

TABLES = ("impacts", "crossings", "contacts", "grazes")
# Where a result lies beside the tables that are for reading.
EXACT, ORBITS, DATA = "exact", "orbits", "data"


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
        A run, with the groups motion, impacts, crossings, contacts and grazes; an orbit, with
        the group motion; a list of orbits; a branch, a curve or a response; or a dataset of an
        ensemble.
    path
        The file, with the suffix ``.nc``.
    study, command
        As in `percuss.io.make_record`; the file's attributes hold the record.
    samples
        Number of equally spaced times in the group ``motion``, >= 2.
    force
        Whether a file of that name may be replaced.

    Raises
    ------
    OutputError
        If the suffix is another one, the file exists and `force` is false, or cannot be written.
    ParameterError
        If it is no result of percuss.
    """
    check_suffix(path, ".nc")
    record = make_record(result, study=study, command=command)
    with OutputFiles(path, force=force) as files:
        write_netcdf(result, files[path], record, samples=samples)


def write_netcdf(result: Any, path: Path, record: Record, *, samples: int = SAMPLES) -> None:
    """Write a result under the name `path`."""
    kind = kind_of(result)
    groups = {"/": xr.Dataset(attrs=_attributes(record, kind.title, kind.name))}
    if kind.name == "motion":
        groups |= _of_motion(result, samples)
    elif kind.name == "dataset":
        groups[f"/{DATA}"] = _writable(result)
    else:
        groups |= _of_orbits(result, kind.tables(result), samples)
    tell_size(path, sum(group.nbytes for group in groups.values()))
    write_whole(xr.DataTree.from_dict(groups), path)


def _of_motion(run: Trajectory, samples: int) -> dict[str, xr.Dataset]:
    tables = {f"/{name}": _writable(getattr(run, name).to_dataset()) for name in TABLES}
    return {"/motion": run.sample(samples), **tables}


def _of_orbits(result: Any, tables: dict[str, xr.Dataset], samples: int) -> dict[str, xr.Dataset]:
    """Return the tables for reading, and the result as it is: its orbits, and all else as JSON."""
    # By identity: a special point's orbit is a row of its branch, and stays so.
    orbits: dict[int, PeriodicOrbit] = {}
    places: dict[int, int] = {}

    def number(value: Any) -> dict[str, int] | None:
        if not isinstance(value, PeriodicOrbit):
            return None
        orbits.setdefault(id(value), value)
        return {"orbit": places.setdefault(id(value), len(places))}

    text = json.dumps(encoded(result, number))
    groups = {f"/{name}": _writable(table) for name, table in tables.items()}
    if isinstance(result, PeriodicOrbit):
        groups["/motion"] = result.trajectory().sample(samples)
    if orbits:
        groups[f"/{ORBITS}"] = orbits_dataset(list(orbits.values()))
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
    DataTree, PeriodicOrbit, list, Branch, Curve, Response or Dataset
        A run as its groups, whose attributes hold the record; anything else as it was saved, every
        field to the bit. All in memory; the file is closed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    OSError
        If it is no NetCDF file, or holds no result of percuss that is whole; each in one sentence.
    """
    if not Path(path).exists():
        raise FileNotFoundError(f"{path}: no such file")
    try:
        with xr.open_datatree(path, engine="h5netcdf") as opened:
            tree = opened.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise OSError(f"{path}: not a NetCDF file that percuss can read") from error
    if NETCDF_ATTRIBUTE not in tree.attrs:
        raise OSError(f"{path}: holds no result of percuss")
    if DATA in tree.children:
        return tree[DATA].to_dataset()
    if EXACT not in tree.children:
        return tree
    try:
        return _result(tree)
    except (KeyError, ValueError, TypeError, IndexError, AttributeError, PercussError) as error:
        raise OSError(f"{path}: damaged, or of another version of percuss ({error})") from error


def _result(tree: xr.DataTree) -> Any:
    orbits = orbits_of_dataset(tree[ORBITS].to_dataset()) if ORBITS in tree.children else []
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
    # NetCDF knows texts of any length, but no array of none without a length.
    names: Iterable[Any] = [*dataset.data_vars, *dataset.coords]
    texts = {key: dataset[key].astype(object) for key in names if dataset[key].dtype.kind == "U"}
    flags = {key: dataset[key].astype("i1") for key in names if dataset[key].dtype.kind == "b"}
    return dataset.assign(texts | {k: v for k, v in flags.items() if k in dataset.data_vars})
