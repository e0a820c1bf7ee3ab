"""Axes to draw on that no screen shows."""

from __future__ import annotations

from matplotlib.axes import Axes

from percuss.plotting import offscreen_figure


def new_axes() -> Axes:
    ax: Axes = offscreen_figure().add_subplot()
    return ax
