"""Results to files and back: NetCDF, CSV and pictures, each with the record that repeats it."""

from __future__ import annotations

from percuss.lazy import lazy_names

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

__all__ = list(_MODULES)

__getattr__, __dir__ = lazy_names(__name__, _MODULES)
