"""A whole run as one NetCDF file, and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from percuss.io.files import OutputFiles
from percuss.io.reading import NETCDF_ATTRIBUTE
from percuss.io.record import Record, make_record
from percuss.motion.trajectory import Trajectory

SAMPLES = 2001

# The columns of each table of events, and what they are.
TABLES: dict[str, dict[str, str]] = {
    "impacts": {
        "t": "time of the impact",
        "v_before": "velocity before the impact",
        "v_after": "velocity after the impact",
        "stop": "index of the stop that is hit",
        "cycle": "time in forcing periods, modulo 1",
        "impulse": "impulse of the stop per unit mass",
    },
    "crossings": {
        "t": "time of the crossing",
        "v": "velocity at the crossing",
        "stop": "index of the soft stop",
        "direction": "in or out of the soft stop",
    },
    "contacts": {
        "start": "time at which the motion comes to rest on the stop",
        "release": "time of the release, NaN if it has not come yet",
        "stop": "index of the stop",
        "n_impacts": "number of impacts listed before the contact",
        "error_bound": "bound of the error of the start",
    },
    "grazes": {
        "t": "time of the touch",
        "stop": "index of the stop",
        "clearance": "distance from the stop",
        "error_bound": "bound of the error of the clearance",
    },
}


def save_netcdf(
    run: Trajectory,
    path: Path | str,
    *,
    study: str | None = None,
    command: str | None = None,
    samples: int = SAMPLES,
    force: bool = False,
) -> None:
    """Save a run as NetCDF with the groups motion, impacts, crossings, contacts and grazes.

    Parameters
    ----------
    run
        The run.
    path
        The file.
    study, command
        As in `percuss.io.make_record`; the file's attributes hold the record.
    samples
        Number of equally spaced times in the group ``motion``, >= 2.
    force
        Whether a file of that name may be replaced.

    Raises
    ------
    OutputError
        If the file exists and `force` is false, or cannot be written.
    """
    with OutputFiles(path, force=force) as files:
        record = make_record(run, study=study, command=command)
        write_netcdf(run, files[path], record, samples=samples)


def write_netcdf(run: Trajectory, path: Path, record: Record, *, samples: int = SAMPLES) -> None:
    """Write a run under the name `path`."""
    groups = {
        "/": xr.Dataset(attrs=_attributes(record)),
        "/motion": run.sample(samples),
        **{f"/{name}": _event_dataset(run, name) for name in TABLES},
    }
    xr.DataTree.from_dict(groups).to_netcdf(path, engine="h5netcdf")


def load_netcdf(path: Path | str) -> xr.DataTree:
    """Load what `save_netcdf` saved.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    xarray.DataTree
        The groups, in memory; the file is closed. Its attributes hold the record.

    Raises
    ------
    OSError
        If there is no such file, or it is no NetCDF file.
    """
    with xr.open_datatree(path, engine="h5netcdf") as tree:
        return tree.load()


def _attributes(record: Record) -> dict[str, str]:
    return {
        "title": "percuss: one motion",
        NETCDF_ATTRIBUTE: record.text(),
        "study": record.study,
        "command": record.command,
        "date": record.date,
        "outcome": record.outcome,
        **{f"{package}_version": version for package, version in record.versions},
    }


def _event_dataset(run: Trajectory, name: str) -> xr.Dataset:
    """Return a table of events along a dimension of its own name."""
    table, dimension = getattr(run, name), name.removesuffix("s")
    columns = {}
    for column, meaning in TABLES[name].items():
        values = np.asarray(getattr(table, column))
        # NetCDF knows texts of any length, but no array of none without a length.
        values = values.astype(object) if values.dtype.kind == "U" else values
        columns[column] = (dimension, values, {"long_name": meaning})
    return xr.Dataset(columns)
