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
from percuss.plotting.style import BLUE, Units, axes_for, draw_legend, fix_ticks, style, units_of

# Width of a curve [point], and how many events keep curves of that width apart.
WIDTH = 1.3
APART = 60


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
        The axes; those of a new figure have a legend.
    """
    units = units_of(units)
    low, high = window_of(run, window)
    curve = sample_curve(run, (low, high))
    with style():
        is_alone, ax = ax is None, axes_for(ax)
        t, x, _ = reduce_to_columns(curve.t, curve.x, np.zeros_like(curve.jumps))
        ax.plot(t, x, color=BLUE, linewidth=WIDTH * _thinness(run, low, high))
        draw_stops(ax, run, curve.x, "y")
        draw_contacts_in_time(ax, run, low, high, velocity=False)
        draw_grazes_in_time(ax, run, low, high, velocity=False)
        _finish(ax, low, high, units, f"displacement $x$\n({units.displacement})")
        if is_alone:
            draw_legend(ax.figure, [ax])
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
        The axes; those of a new figure have a legend. With more than 2,000 impacts the jumps are part of the solid line.
    """
    units = units_of(units)
    low, high = window_of(run, window)
    curve = sample_curve(run, (low, high))
    shown = within(run.impacts.t, low, high)
    is_dashed = 0 < shown.sum() <= MOST_JUMPS
    with style():
        is_alone, ax = ax is None, axes_for(ax)
        t, v, jumps = reduce_to_columns(curve.t, curve.v, curve.jumps & is_dashed)
        thinness = _thinness(run, low, high)
        ax.plot(separated(t, jumps), separated(v, jumps), color=BLUE, linewidth=WIDTH * thinness)
        if is_dashed:
            impacts = run.impacts
            before, after = impacts.v_before[shown], impacts.v_after[shown]
            # Not thinner: matplotlib shortens the dashes with the width.
            draw_jumps(ax, impacts.t[shown], before, after, alpha=thinness**2)
        draw_contacts_in_time(ax, run, low, high, velocity=True)
        draw_grazes_in_time(ax, run, low, high, velocity=True)
        _finish(ax, low, high, units, f"velocity $v$\n({units.velocity})")
        if is_alone:
            draw_legend(ax.figure, [ax])
    return ax


def _thinness(run: Trajectory, low: float, high: float) -> float:
    """Return how thin the lines are drawn, 1 to 0.4, so that many stay apart."""
    n = within(run.impacts.t, low, high).sum() + within(run.crossings.t, low, high).sum()
    if n > MOST_JUMPS:
        # They fill an area.
        return 1.0
    return float(np.clip(np.sqrt(APART / max(n, 1)), 0.4, 1.0))


def _finish(ax: Axes, low: float, high: float, units: Units, ylabel: str) -> None:
    if high > low:
        ax.set_xlim(low, high)
    ax.set_xlabel(f"time $t$ ({units.duration})")
    ax.set_ylabel(ylabel)
    fix_ticks(ax)
