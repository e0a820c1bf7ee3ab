"""Velocities at the stops over the cycle of the forcing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection

from percuss.motion.trajectory import Trajectory
from percuss.plotting.samples import DRAWN_POINTS, topmost, window_of, within
from percuss.plotting.stops import GRAZE_STYLE
from percuss.plotting.style import (
    BLUE,
    GREY,
    Units,
    axes_for,
    draw_legend,
    fix_ticks,
    style,
    units_of,
)

Floats = npt.NDArray[np.float64]

# One for each stop, in their order, so that two can be told apart; entries have open ones.
IMPACT_MARKERS = ("o", "^", "s", "v", "P", "X")
ENTRY_MARKERS = ("x", "+", "1", "2", "3", "4")


@dataclass(frozen=True, slots=True)
class _Hits:
    """Impacts on one wall, or entries into one soft stop, as arrays."""

    t: Floats
    v: Floats
    cycle: Floats
    stop: int
    is_entry: bool

    @property
    def label(self) -> str:
        return f"entry into stop {self.stop}" if self.is_entry else f"impact on stop {self.stop}"

    @property
    def marker(self) -> str:
        markers = ENTRY_MARKERS if self.is_entry else IMPACT_MARKERS
        return markers[self.stop % len(markers)]


def plot_impact_velocities(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the velocity after each impact over the cycle of the forcing.

    Entries into soft stops are drawn too, by open markers, with the velocity at the entry. The
    colour is the time; without a period of the forcing the time is the axis instead.

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
        The axes; with another one beside it, the scale of the colours. Those of a new figure have
        a legend.
    """
    units = units_of(units)
    low, high = window_of(run, window)
    period = None if run.forcing is None else run.forcing.period
    groups = _groups(run, low, high, period)
    with style():
        is_alone, ax = ax is None, axes_for(ax)
        if groups:
            points = [_scatter(ax, hits, groups, period) for hits in groups]
            if period is not None:
                bar = ax.figure.colorbar(points[0], ax=ax, pad=0.02)
                bar.set_label(f"time $t$ ({units.duration})")
                bar.outline.set_visible(False)
            if len(groups) > 1:
                _name_markers(ax, groups)
            _pad(ax, np.concatenate([hits.v for hits in groups]))
        else:
            ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
            ax.set_axis_off()
        if period is not None:
            _draw_grazes(ax, run, low, high, period)
            ax.set_xlim(-0.02, 1.02)
        ax.set_xlabel(
            f"time $t$ ({units.duration})" if period is None else "cycle (forcing periods)"
        )
        ax.set_ylabel(f"{_what(groups)} $v$\n({units.velocity})")
        fix_ticks(ax)
        if is_alone:
            draw_legend(ax.figure, [ax])
    return ax


def _groups(run: Trajectory, low: float, high: float, period: float | None) -> list[_Hits]:
    """Return what is drawn: the impacts on each wall and the entries into each soft stop."""
    impacts, crossings = run.impacts, run.crossings
    hit = within(impacts.t, low, high)
    entered = within(crossings.t, low, high) & (crossings.direction == "in")
    groups = []
    for stop in range(len(run.oscillator.stops)):
        shown = hit & (impacts.stop == stop)
        if shown.any():
            t, cycle = impacts.t[shown], impacts.cycle[shown]
            groups.append(_Hits(t, impacts.v_after[shown], cycle, stop, is_entry=False))
        shown = entered & (crossings.stop == stop)
        if shown.any():
            t = crossings.t[shown]
            groups.append(_Hits(t, crossings.v[shown], t / (period or np.nan), stop, is_entry=True))
    return groups


def _what(groups: list[_Hits]) -> str:
    kinds = {hits.is_entry for hits in groups}
    if kinds == {True}:
        return "velocity at entry"
    return "velocity after impact" if kinds != {True, False} else "velocity after impact, at entry"


def _scatter(ax: Axes, hits: _Hits, groups: list[_Hits], period: float | None) -> PathCollection:
    """Draw the hits on one stop; the scale of the colours is that of all."""
    x = hits.t if period is None else _drawn_cycle(hits.cycle)
    seen = topmost(x, hits.v)
    size = sum(other.t.size for other in groups)
    points: PathCollection = ax.scatter(
        x[seen],
        hits.v[seen],
        c=BLUE if period is None else hits.t[seen],
        cmap=None if period is None else "cividis",
        vmin=None if period is None else min(other.t[0] for other in groups),
        vmax=None if period is None else max(other.t[-1] for other in groups),
        s=24.0 if size <= 1000 else 4.0,
        marker=hits.marker,
        linewidths=1.0 if hits.is_entry else 0.0,
        rasterized=hits.t.size > DRAWN_POINTS // 10,
    )
    return points


def _name_markers(ax: Axes, groups: list[_Hits]) -> None:
    """Give the legend the markers in grey, since their colour is the time."""
    for hits in groups:
        ax.plot([], [], hits.marker, color=GREY, markersize=5.0, label=hits.label)


def _draw_grazes(ax: Axes, run: Trajectory, low: float, high: float, period: float) -> None:
    shown = within(run.grazes.t, low, high)
    if shown.any():
        cycle = _drawn_cycle(run.grazes.t[shown] / period)
        seen = topmost(cycle, np.zeros(cycle.size))
        ax.plot(cycle[seen], np.zeros(seen.size), **GRAZE_STYLE)


def _drawn_cycle(cycle: Floats) -> Floats:
    """Return the cycles with those a rounding below 1 at 0, where the others are."""
    return np.mod(np.round(cycle, 9), 1.0)


def _pad(ax: Axes, v: Floats) -> None:
    """Keep velocities that differ by rounding from filling the axis."""
    low, high = v.min(), v.max()
    margin = max(0.06 * (high - low), 0.05 * np.abs(v).max()) or 1.0
    ax.set_ylim(low - margin, high + margin)
