"""Pictures of results; the only user of matplotlib."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = [
    "Units",
    "offscreen_figure",
    "plot_branch",
    "plot_displacement",
    "plot_impact_velocities",
    "plot_motion",
    "plot_phase_portrait",
    "plot_spectrum",
    "plot_staircase",
    "plot_velocity",
]

# matplotlib is slow to import: it loads with the first of these that is used.
_MODULES = {
    "Units": "style",
    "offscreen_figure": "style",
    "plot_branch": "branch_plot",
    "plot_displacement": "time_plots",
    "plot_impact_velocities": "impact_plot",
    "plot_motion": "motion_figure",
    "plot_phase_portrait": "portrait",
    "plot_spectrum": "spectrum_plot",
    "plot_staircase": "staircase",
    "plot_velocity": "time_plots",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
