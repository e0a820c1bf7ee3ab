"""A study as a value: read, check, write and run study files."""

from __future__ import annotations

from percuss.lazy import lazy_names

# Running needs xarray and matplotlib, a template needs neither: each name loads its own module.
_MODULES = {
    "Basins": "kinds.basins",
    "Branch": "kinds.branch",
    "Certify": "tables",
    "Curve": "kinds.curve",
    "Design": "kinds.design",
    "Diagram": "kinds.diagram",
    "Draw": "tables",
    "Fit": "kinds.fit",
    "FitRecord": "fit_records",
    "Limits": "tables",
    "Lyapunov": "kinds.lyapunov",
    "Motion": "kinds.motion",
    "Orbit": "kinds.orbit",
    "Orbits": "kinds.orbits",
    "Response": "kinds.response",
    "Save": "tables",
    "Sought": "kinds.orbit",
    "Span": "axes",
    "Steps": "kinds.branch",
    "Study": "study",
    "StudyFault": "tables",
    "StudyResult": "running",
    "Sweep": "kinds.sweep",
    "kind_names": "study",
    "load_study": "reading",
    "output_files": "running",
    "parse_study": "reading",
    "run_study": "running",
    "study_schema": "schema",
    "study_text": "study",
    "template_names": "templates",
    "template_text": "templates",
}

__all__ = list(_MODULES)

__getattr__, __dir__ = lazy_names(__name__, _MODULES)
