"""Basin fractions over a parameter, stacked."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from percuss.errors import ParameterError
from percuss.plotting.basin_plot import CLASS_COLOURS, OTHERS
from percuss.plotting.cells import edges_of, path_label
from percuss.plotting.style import Units, axes_for, fix_ticks, style, units_of

__all__ = ["plot_fractions"]


def plot_fractions(
    fractions: xr.Dataset, ax: Axes | None = None, *, units: Units | None = None
) -> Axes:
    """Draw which part of the starts goes to which attractor, over a parameter.

    Parameters
    ----------
    fractions
        What `percuss.basin_fractions` has returned.
    ax
        Axes to draw on; default: those of a new figure.
    units
        Units on the axis; default: dimensionless.

    Returns
    -------
    Axes
        The axes: the parts on one another, those of the largest first, and the undecided last.

    Raises
    ------
    ParameterError
        If it is something else.
    """
    units = units_of(units)
    if "fraction" not in fractions or fractions["fraction"].ndim != 2:
        reason = "not what percuss.basin_fractions returns"
        raise ParameterError("fractions", sorted(map(str, fractions)), reason)
    path = str(fractions["fraction"].dims[1])
    along = np.argsort(fractions[path].to_numpy())
    x = edges_of(fractions[path].to_numpy()[along])
    parts = fractions["fraction"].to_numpy()[:, along]
    order = np.argsort(-parts.sum(axis=1), kind="stable")
    with style():
        ax = axes_for(ax)
        below = np.zeros(len(along))
        for place, i in enumerate(order):
            colour = CLASS_COLOURS[place] if place < len(CLASS_COLOURS) else OTHERS
            label = _label(fractions, int(i)) if place < len(CLASS_COLOURS) else None
            ax.stairs(below + parts[i], x, baseline=below, fill=True, color=colour, label=label)
            below = below + parts[i]
        undecided = fractions["undecided"].to_numpy()[along]
        if np.nanmax(undecided) > 0.0:
            ax.stairs(
                below + undecided, x, baseline=below, fill=True, facecolor="white",
                edgecolor=OTHERS, hatch="////", label="undecided",
            )  # fmt: skip
        ax.set(xlim=(x[0], x[-1]), ylim=(0.0, 1.0))
        ax.set_xlabel(path_label(fractions, path, units))
        ax.set_ylabel("part of the starts")
        ax.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.01), borderaxespad=0.0,
            ncols=3, handlelength=1.6, columnspacing=1.4,
        )  # fmt: skip
        fix_ticks(ax)
    return ax


def _label(fractions: xr.Dataset, i: int) -> str:
    """Return the names that an attractor has along the parameter, in order, a few of them."""
    names = [str(name) for name in fractions["name"].to_numpy()[i] if name]
    different = [name for k, name in enumerate(names) if k == 0 or names[k - 1] != name]
    if len(different) > 3:
        different = [*different[:2], "...", different[-1]]
    return ", ".join(different)
