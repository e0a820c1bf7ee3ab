"""The phase portrait: velocity over displacement."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from percuss.motion.trajectory import Trajectory
from percuss.plotting.jumps import draw_jumps
from percuss.plotting.samples import (
    DRAWN_POINTS,
    Curve,
    distinct_jumps,
    reduce_to_pixels,
    sample_curve,
    window_of,
    within,
)
from percuss.plotting.stops import draw_rest_points, draw_stops, stop_places
from percuss.plotting.style import BLUE, Units, axes_for, draw_legend, fix_ticks, style, units_of

# Hollow, unlike the dots of impact velocities beside it.
START_STYLE: dict[str, Any] = {
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": "white",
    "markeredgecolor": BLUE,
    "markeredgewidth": 1.4,
    "linestyle": "none",
    "label": "start",
    "zorder": 3.0,
}


def plot_phase_portrait(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the velocity over the displacement; an impact is a vertical dashed jump at its stop.

    Parameters
    ----------
    run
        The run.
    ax
        Axes to draw on; default: those of a new figure.
    window
        First and last time of the part that is drawn; default: the whole run.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; those of a new figure have a legend.
    """
    units = units_of(units)
    low, high = window_of(run, window)
    curve = sample_curve(run, (low, high))
    with style():
        is_alone, ax = ax is None, axes_for(ax)
        x, v = reduce_to_pixels(curve)
        # A long line is drawn finely, so that its loops stay apart; very long ones stay an image
        # inside an SVG, which would be large otherwise.
        width = float(np.clip(1.2 * math.sqrt(40.0 / (1.0 + _length(curve))), 0.35, 1.2))
        ax.plot(x, v, color=BLUE, linewidth=width, rasterized=x.size > DRAWN_POINTS)
        if low == run.t0:
            # Before the impact of a start that runs into a wall.
            ax.plot(run.x0, run.v0, **START_STYLE)
        _draw_jumps(ax, run, low, high)
        draw_stops(ax, run, curve.x, "x")
        draw_rest_points(ax, run, low, high)
        ax.set_xlabel(f"displacement $x$ ({units.displacement})")
        ax.set_ylabel(f"velocity $v$ ({units.velocity})")
        fix_ticks(ax)
        if is_alone:
            draw_legend(ax.figure, [ax])
    return ax


def _length(curve: Curve) -> float:
    """Return the length of the line, in units of the width and the height of the picture."""
    dx, dv = (np.diff(values) / (np.ptp(values) or 1.0) for values in (curve.x, curve.v))
    return float(np.hypot(dx, dv)[~curve.jumps[:-1]].sum())


def _draw_jumps(ax: Axes, run: Trajectory, low: float, high: float) -> None:
    shown = within(run.impacts.t, low, high)
    if shown.any():
        impacts = run.impacts
        places = stop_places(run, impacts.stop[shown])
        before, after = impacts.v_before[shown], impacts.v_after[shown]
        apart = distinct_jumps(places, before, after)
        draw_jumps(ax, places[apart], before[apart], after[apart])
