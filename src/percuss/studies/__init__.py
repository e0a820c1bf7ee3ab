"""A study as a value: read, check, write and run study files."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = [
    "Draw",
    "EngineersModel",
    "Limits",
    "Save",
    "Study",
    "StudyFault",
    "StudyResult",
    "load_study",
    "output_files",
    "parse_study",
    "run_study",
    "study_text",
    "template_names",
    "template_text",
]

# Running needs xarray and matplotlib, a template needs neither: each name loads its own module.
_MODULES = {
    "Draw": "study",
    "EngineersModel": "study",
    "Limits": "study",
    "Save": "study",
    "Study": "study",
    "StudyFault": "faults",
    "StudyResult": "running",
    "load_study": "reading",
    "output_files": "running",
    "parse_study": "reading",
    "run_study": "running",
    "study_text": "study",
    "template_names": "templates",
    "template_text": "templates",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
