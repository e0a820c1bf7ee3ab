"""Basin fractions: over one parameter stacked, over two as a chart of one attractor."""

from __future__ import annotations

from collections import Counter

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.patches import Patch

from percuss.errors import ParameterError
from percuss.plotting.basin_plot import CLASS_COLOURS, OTHERS
from percuss.plotting.cells import draw_cells, edges_of, path_label
from percuss.plotting.chart_plot import HATCH, MISSING
from percuss.plotting.style import Units, axes_for, fix_ticks, style, units_of

__all__ = ["plot_fractions"]


def plot_fractions(
    fractions: xr.Dataset,
    ax: Axes | None = None,
    *,
    attractor: int | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw which part of the starts goes to which attractor.

    Over one parameter all parts are stacked, those of the largest first, and the undecided last.
    Over two parameters it is a chart of one attractor, blank where that does not exist.

    Parameters
    ----------
    fractions
        What `percuss.basin_fractions` has returned.
    ax
        Axes to draw on; default: those of a new figure.
    attractor
        Number of the attractor that a chart over two parameters shows; default: the one to which
        most starts go.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes, with a legend, or with a colour bar.

    Raises
    ------
    ParameterError
        If it is something else, there is no such attractor, or one is named where all are drawn.
    """
    units = units_of(units)
    if "fraction" not in fractions or fractions["fraction"].ndim not in (2, 3):
        reason = "not what percuss.basin_fractions returns"
        raise ParameterError("fractions", sorted(map(str, fractions)), reason)
    if fractions["fraction"].ndim == 3:
        return _draw_chart(fractions, ax, attractor, units)
    if attractor is not None:
        raise ParameterError("attractor", attractor, "over one parameter all of them are drawn")
    return _draw_stack(fractions, ax, units)


def _draw_stack(fractions: xr.Dataset, ax: Axes | None, units: Units) -> Axes:
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


def _draw_chart(
    fractions: xr.Dataset, ax: Axes | None, attractor: int | None, units: Units
) -> Axes:
    across, upwards = (str(dim) for dim in fractions["fraction"].dims[1:])
    every = fractions["fraction"].transpose("attractor", upwards, across).to_numpy()
    n = len(every)
    if attractor is None:
        attractor = int(np.argmax(every.sum(axis=(1, 2)))) if n else 0
    if not 0 <= attractor < n:
        raise ParameterError("attractor", attractor, f"the number of none; there are {n}")
    exists = fractions["exists"].transpose("attractor", upwards, across).to_numpy()[attractor]
    with style():
        ax = axes_for(ax)
        x, y = (fractions[dim].to_numpy() for dim in (across, upwards))
        ax.set_facecolor(MISSING)
        ax.patch.set_hatch("////")
        ax.patch.set_edgecolor(HATCH)
        shown = draw_cells(
            ax, x, y, np.ma.masked_where(~exists, every[attractor]),
            cmap=mpl.colormaps["cividis"], norm=Normalize(0.0, 1.0),
        )  # fmt: skip
        for dim, set_label in ((across, ax.set_xlabel), (upwards, ax.set_ylabel)):
            set_label(path_label(fractions, dim, units))
        bar = ax.figure.colorbar(shown, ax=ax, pad=0.02, fraction=0.06)
        bar.set_label(f"part of the starts that go to {_label(fractions, attractor)}")
        bar.outline.set_linewidth(0.6)
        if not exists.all():
            label = "it does not exist"
            handle = Patch(facecolor=MISSING, edgecolor=HATCH, hatch="////", label=label)
            ax.legend(
                handles=[handle], loc="lower left", bbox_to_anchor=(0.0, 1.01), borderaxespad=0.0
            )
        fix_ticks(ax)
    return ax


def _label(fractions: xr.Dataset, i: int) -> str:
    """Return the names that an attractor has along the parameter, in order, a few of them.

    Over two parameters those that it has most often come first.
    """
    own = fractions["name"].to_numpy()[i]
    names = [str(name) for name in own.ravel() if name]
    if own.ndim == 2:
        counts = Counter(names).most_common()
        different = [name for name, _ in counts]
        return ", ".join([*different[:2], "..."] if len(different) > 3 else different)
    different = [name for k, name in enumerate(names) if k == 0 or names[k - 1] != name]
    if len(different) > 3:
        different = [*different[:2], "...", different[-1]]
    return ", ".join(different)
