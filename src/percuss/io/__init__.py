"""Results to files and back: NetCDF, CSV and pictures, each with the record that repeats it."""

from __future__ import annotations

from percuss.lazy import lazy_names

__all__ = [
    "OutputFiles",
    "Record",
    "check_output",
    "load_netcdf",
    "load_record",
    "make_record",
    "motion_text",
    "parse_record",
    "save_certificate",
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
    "save_certificate": "certificate_file",
    "save_csv": "table",
    "save_figure": "figures",
    "save_netcdf": "netcdf",
}


__getattr__, __dir__ = lazy_names(__name__, _MODULES)
