"""Results to files and back: NetCDF, CSV and pictures, each with the record that repeats it."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = [
    "OutputFiles",
    "Record",
    "check_output",
    "load_netcdf",
    "load_record",
    "make_record",
    "motion_text",
    "parse_record",
    "save_csv",
    "save_figure",
    "save_netcdf",
]

# NetCDF needs xarray, which takes a second to import: each name loads its own module.
_MODULES = {
    "OutputFiles": "files",
    "Record": "record",
    "check_output": "files",
    "load_netcdf": "netcdf",
    "load_record": "record",
    "make_record": "record",
    "motion_text": "study_text",
    "parse_record": "record",
    "save_csv": "table",
    "save_figure": "figures",
    "save_netcdf": "netcdf",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
