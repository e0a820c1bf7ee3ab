"""A whole run as one NetCDF file, and back."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from percuss.io.files import OutputFiles
from percuss.io.reading import NETCDF_ATTRIBUTE
from percuss.io.record import Record, make_record
from percuss.motion.trajectory import Trajectory

SAMPLES = 2001

TABLES = ("impacts", "crossings", "contacts", "grazes")


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
    FileNotFoundError
        If there is no such file.
    OSError
        If it is no NetCDF file; both in one sentence.
    """
    if not Path(path).exists():
        raise FileNotFoundError(f"{path}: no such file")
    try:
        with xr.open_datatree(path, engine="h5netcdf") as tree:
            return tree.load()
    except OSError as error:
        raise OSError(f"{path}: not a NetCDF file that percuss can read") from error


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
    """Return a table of events as NetCDF can hold it."""
    dataset: xr.Dataset = getattr(run, name).to_dataset()
    # NetCDF knows texts of any length, but no array of none without a length.
    texts = {
        key: column.astype(object) for key, column in dataset.items() if column.dtype.kind == "U"
    }
    return dataset.assign(texts)
