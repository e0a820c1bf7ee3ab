"""Velocities at the stops over the cycle of the forcing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection

from percuss.motion.trajectory import Trajectory
from percuss.plotting.samples import DRAWN_POINTS, window_of, within
from percuss.plotting.stops import GRAZE_STYLE
from percuss.plotting.style import Units, axes_for, fix_ticks, style

Floats = npt.NDArray[np.float64]

# One for each stop, in their order, so that two walls can be told apart.
MARKERS = ("o", "^", "s", "v", "P", "X")


@dataclass(frozen=True, slots=True)
class _Hits:
    """Impacts, or entries into soft stops, as arrays."""

    t: Floats
    cycle: Floats
    v: Floats
    stop: npt.NDArray[np.int64]
    what: str


def plot_impact_velocities(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the velocity after each impact over the cycle of the forcing.

    A run that enters soft stops and never hits a wall shows the velocities of the entries;
    without a period of the forcing they stand over time. The colour is the time.

    Parameters
    ----------
    run
        The run.
    ax
        Axes to draw on; default: those of a new figure.
    window
        First and last time of the impacts that are drawn; default: the whole run.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; with another one beside it, the scale of the colours.
    """
    units = units or Units()
    low, high = window_of(run, window)
    period = None if run.forcing is None else run.forcing.period
    hits = _hits(run, low, high, period)
    with style():
        ax = axes_for(ax)
        if hits.t.size:
            points = _scatter(ax, hits, period)
            if period is not None:
                bar = ax.figure.colorbar(points, ax=ax, pad=0.02)
                bar.set_label(f"time $t$ ({units.duration})")
                bar.outline.set_visible(False)
            _pad(ax, hits.v)
        else:
            ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
            ax.set_axis_off()
        if period is not None:
            _draw_grazes(ax, run, low, high, period)
            ax.set_xlim(-0.02, 1.02)
        ax.set_xlabel(
            f"time $t$ ({units.duration})" if period is None else "cycle (forcing periods)"
        )
        ax.set_ylabel(f"{hits.what}\n({units.velocity})")
        fix_ticks(ax)
    return ax


def _hits(run: Trajectory, low: float, high: float, period: float | None) -> _Hits:
    if len(run.impacts) or not len(run.crossings):
        shown = within(run.impacts.t, low, high)
        table = run.impacts
        return _Hits(
            t=table.t[shown],
            cycle=table.cycle[shown],
            v=table.v_after[shown],
            stop=table.stop[shown],
            what="velocity after impact $v$",
        )
    crossings = run.crossings
    shown = within(crossings.t, low, high) & (crossings.direction == "in")
    return _Hits(
        t=crossings.t[shown],
        cycle=crossings.t[shown] / (period or np.nan),
        v=crossings.v[shown],
        stop=crossings.stop[shown],
        what="velocity at entry $v$",
    )


def _scatter(ax: Axes, hits: _Hits, period: float | None) -> PathCollection:
    """Draw the hits, a marker for each stop, on one scale of colours; return the last."""
    stops = np.unique(hits.stop)
    for stop in stops:
        chosen = hits.stop == stop
        points = ax.scatter(
            hits.t[chosen] if period is None else _drawn_cycle(hits.cycle[chosen]),
            hits.v[chosen],
            c=hits.t[chosen],
            cmap="cividis",
            vmin=hits.t[0],
            vmax=hits.t[-1],
            s=24.0 if hits.t.size <= 1000 else 4.0,
            marker=MARKERS[stop % len(MARKERS)],
            linewidths=0.0,
            rasterized=hits.t.size > DRAWN_POINTS // 10,
            label=f"stop {stop}" if stops.size > 1 else None,
        )
    return points


def _draw_grazes(ax: Axes, run: Trajectory, low: float, high: float, period: float) -> None:
    shown = within(run.grazes.t, low, high)
    if shown.any():
        cycle = _drawn_cycle(run.grazes.t[shown] / period)
        ax.plot(cycle, np.zeros(cycle.size), **GRAZE_STYLE)


def _drawn_cycle(cycle: Floats) -> Floats:
    """Return the cycles with those a rounding below 1 at 0, where the others are."""
    return np.mod(np.round(cycle, 9), 1.0)


def _pad(ax: Axes, v: Floats) -> None:
    """Keep velocities that differ by rounding from filling the axis."""
    low, high = v.min(), v.max()
    margin = max(0.06 * (high - low), 0.05 * np.abs(v).max()) or 1.0
    ax.set_ylim(low - margin, high + margin)
