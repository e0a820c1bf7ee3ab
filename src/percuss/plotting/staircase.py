"""How far the impact times run ahead of, or behind, those of the free oscillator."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from percuss.errors import ParameterError
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.trajectory import Trajectory
from percuss.plotting.samples import reduce_to_columns
from percuss.plotting.style import BLUE, GREY, Units, axes_for, fix_ticks, style, units_of

# More impacts than this are a line without markers.
MOST_MARKERS = 400


def plot_staircase(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    spacing: float | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw t_k - k T_0 over the number k of the impact, T_0 being the eigenset's spacing.

    On the eigenset the points lie on the line at zero; on a shifted eigenset on another
    horizontal line; a missing impact lifts them by T_0, an additional one lowers them by as much.

    Parameters
    ----------
    run
        The run; without walls, the entries into soft stops are taken.
    ax
        Axes to draw on; default: those of a new figure.
    spacing
        T_0 [time], > 0; default: 2 pi over the resonant frequency.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes.

    Raises
    ------
    ParameterError
        If no spacing is given and the free oscillator has none, or it is not positive.
    """
    if spacing is None:
        spacing = 2.0 * np.pi / resonant_frequency(run.oscillator)
    elif not 0.0 < spacing < np.inf:
        raise ParameterError("spacing", spacing, "not a positive number")
    units = units_of(units)
    times = run.impacts.t
    if len(times) == 0:
        times = run.crossings.t[run.crossings.direction == "in"]
    k = np.arange(1, len(times) + 1)
    ahead = (times - run.t0) - k * spacing
    with style():
        ax = axes_for(ax)
        ax.axhline(0.0, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
        if len(times):
            shown, heights, _ = reduce_to_columns(
                k.astype(np.float64), ahead, np.zeros(len(times), dtype=np.bool_)
            )
            marker = "o" if len(times) <= MOST_MARKERS else ""
            ax.plot(shown, heights, color=BLUE, linewidth=0.9, marker=marker, markersize=3.2)
            _pad(ax, float(ahead.min()), float(ahead.max()), spacing)
        else:
            ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
        ax.set_xlabel("number of the impact $k$")
        ax.set_ylabel(f"$t_k - k\\,T_0$\n({units.duration})")
        fix_ticks(ax)
    return ax


def _pad(ax: Axes, low: float, high: float, spacing: float) -> None:
    """Keep the line at zero in sight, and rounding from filling the axis."""
    low, high = min(low, 0.0), max(high, 0.0)
    margin = max(0.06 * (high - low), 0.01 * spacing)
    ax.set_ylim(low - margin, high + margin)
