"""Oscillators that meet stops: exact between impacts, no impact ever missed.

The equation is x'' + 2 a x' + k x = f(t) + stops, for unit mass. Describe an oscillator and a
forcing, follow the motion with `simulate`, draw it with `percuss.plotting`.

>>> import percuss as pc
>>> run = pc.simulate(pc.impact_oscillator(restitution=0.8), pc.cosine(2.0), v0=1.0, t_end=50.0)
>>> run.outcome.value
'the run reached t_end'
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

# Where each public name lives; its module is loaded at its first use.
_HOMES = {
    "errors": ("MissingExtraError", "OutputError", "ParameterError",
               "PercussError", "StudyError"),
    "model": ("Forcing", "Harmonic", "Oscillator", "SoftStop", "Start", "Wall",
              "backlash_oscillator", "ball_on_table", "bilinear_oscillator", "cosine", "fourier",
              "impact_oscillator", "pi_times", "sine"),
    "motion": ("Contacts", "Crossings", "Grazes", "ImpactTimes", "Impacts", "Outcome",
               "Trajectory", "classify_impact_times", "eigenset", "resonant_frequency", "simulate"),
    "io": ("load_netcdf", "save_csv", "save_netcdf"),
}  # fmt: skip
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}
_SUBPACKAGES = ("errors", "io", "model", "motion", "plotting", "studies")

__all__ = ["__version__", *sorted(_HOME_OF)]


def __getattr__(name: str) -> Any:
    if name in _HOME_OF:
        return getattr(importlib.import_module(f"percuss.{_HOME_OF[name]}"), name)
    if name in _SUBPACKAGES:
        return importlib.import_module(f"percuss.{name}")
    raise AttributeError(f"module 'percuss' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_SUBPACKAGES])
