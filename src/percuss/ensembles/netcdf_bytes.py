"""NetCDF files written as one piece of bytes."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset, DataTree

__all__ = ["write_whole"]


def write_whole(result: Dataset | DataTree, path: Path) -> None:
    """Write a dataset or a tree of them as a NetCDF file.

    HDF5 that writes to a full disk by itself ends the whole process when it closes the file. So it
    writes to memory, and the file is written at once by Python, which raises.

    Parameters
    ----------
    result
        What to write.
    path
        The file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    with _without_cluster():
        content = result.to_netcdf(engine="h5netcdf")
    path.write_bytes(content)


def _without_cluster() -> contextlib.AbstractContextManager[Any]:
    """Have xarray write by itself: it asks for Dask's scheduler, which may be lost by now."""
    config = sys.modules.get("dask.config")
    return contextlib.nullcontext() if config is None else config.set(scheduler="synchronous")
