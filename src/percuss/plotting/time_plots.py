"""Displacement and velocity over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from percuss.motion.trajectory import Trajectory
from percuss.plotting.jumps import draw_jumps
from percuss.plotting.samples import (
    MOST_JUMPS,
    reduce_to_columns,
    sample_curve,
    separated,
    window_of,
    within,
)
from percuss.plotting.stops import draw_contacts_in_time, draw_grazes_in_time, draw_stops
from percuss.plotting.style import BLUE, Units, axes_for, fix_ticks, style


def plot_displacement(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the displacement over time, with the stops, the contacts and the grazes.

    Parameters
    ----------
    run
        The run.
    ax
        Axes to draw on; default: those of a new figure.
    window
        First and last time that are drawn; default: the whole run.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes.
    """
    units = units or Units()
    low, high = window_of(run, window)
    curve = sample_curve(run, (low, high))
    with style():
        ax = axes_for(ax)
        t, x, _ = reduce_to_columns(curve.t, curve.x, np.zeros_like(curve.jumps))
        ax.plot(t, x, color=BLUE)
        draw_stops(ax, run, curve.x, "y")
        draw_contacts_in_time(ax, run, low, high, velocity=False)
        draw_grazes_in_time(ax, run, low, high, velocity=False)
        _finish(ax, low, high, units, f"displacement $x$\n({units.displacement})")
    return ax


def plot_velocity(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the velocity over time; an impact is a vertical dashed jump.

    Parameters
    ----------
    run
        The run.
    ax
        Axes to draw on; default: those of a new figure.
    window
        First and last time that are drawn; default: the whole run.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes. With more than 2,000 impacts the jumps are part of the solid line.
    """
    units = units or Units()
    low, high = window_of(run, window)
    curve = sample_curve(run, (low, high))
    shown = within(run.impacts.t, low, high)
    is_dashed = 0 < shown.sum() <= MOST_JUMPS
    with style():
        ax = axes_for(ax)
        t, v, jumps = reduce_to_columns(curve.t, curve.v, curve.jumps & is_dashed)
        ax.plot(separated(t, jumps), separated(v, jumps), color=BLUE)
        if is_dashed:
            impacts = run.impacts
            draw_jumps(ax, impacts.t[shown], impacts.v_before[shown], impacts.v_after[shown])
        draw_contacts_in_time(ax, run, low, high, velocity=True)
        draw_grazes_in_time(ax, run, low, high, velocity=True)
        _finish(ax, low, high, units, f"velocity $v$\n({units.velocity})")
    return ax


def _finish(ax: Axes, low: float, high: float, units: Units, ylabel: str) -> None:
    if high > low:
        ax.set_xlim(low, high)
    ax.set_xlabel(f"time $t$ ({units.duration})")
    ax.set_ylabel(ylabel)
    fix_ticks(ax)
