"""Basins of attraction in the plane of their starts, and basin fractions over parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.units import Units
from percuss.plotting.cells import check_table, draw_cells, edges_of, hatch_missing, missing_patch
from percuss.plotting.labels import label_axes, path_label
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    colour_bar,
    legend_above,
    picture,
    shared_docs,
    units_of,
)

# Of the attractors with the largest basins, in order; the others share one.
CLASS_COLOURS = (SKY_BLUE, ORANGE, GREEN, PURPLE, BLUE, VERMILION, "#F0E442")
OTHERS, UNDECIDED, NO_START = "#9A9A9A", "#FFFFFF", "#4D4D4D"
# Basins are this much paler than the attractors in them.
PALE = 0.45
# Entries in a row of the legend, and how they are spaced.
ROW = 3
SPACING: dict[str, Any] = {"handlelength": 1.6, "columnspacing": 1.4}
# Lines of the manifolds: stable ones bound basins.
MANIFOLD_LINES: dict[str, Any] = {"stable": "-", "unstable": (0, (3, 1.5))}


@shared_docs
def plot_basins(
    basins: xr.Dataset,
    ax: Axes | None = None,
    *,
    manifolds: Any = (),
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw basins in the plane of the starts, the attractors in them, and saddles' manifolds.

    Parameters
    ----------
    basins
        What `percuss.basins` has returned.
    manifolds
        Curves to draw over them, in the plane of the starts: what `percuss.manifolds` has
        returned, (n, 2) arrays, or a mapping of "stable" and "unstable" to such arrays; a
        sequence of any of these, too. Stable ones, which bound basins, are solid, unstable ones
        dashed; an array alone counts as stable.

    Returns
    -------
    Axes
        The axes, with a legend above that names the classes and the parts of the starts.

    Raises
    ------
    ParameterError
        If there are no basins, or a manifold is no curve.
    """
    check_table("basins", basins, "percuss.basins", "basin")
    units = units_of(units)
    across, upwards = (str(dim) for dim in basins["basin"].dims)
    colours = _colours_of(basins)
    labels = basins["basin"].transpose(upwards, across).to_numpy()
    # Label -2 is the first row.
    table = np.array([to_rgb(NO_START), to_rgb(UNDECIDED), *(_pale(colour) for colour in colours)])
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        x, y = (basins[dim].to_numpy() for dim in (across, upwards))
        draw_cells(ax, x, y, table[labels + 2])
        limits = ax.get_xlim(), ax.get_ylim()
        drawn = _draw_manifolds(ax, manifolds)
        _draw_attractors(ax, basins, colours)
        ax.set(xlim=limits[0], ylim=limits[1])
        label_axes(ax, basins, across, upwards, units)
        _add_legend(ax, basins, colours, drawn)
    return ax


def class_names(basins: xr.Dataset) -> list[str]:
    """Return the names of attractors; those of the same name with a number."""
    names = [str(name) for name in basins["name"].to_numpy()]
    counts: Counter[str] = Counter()
    numbered = []
    for name in names:
        counts[name] += 1
        numbered.append(name if names.count(name) == 1 else f"{name} no. {counts[name]}")
    return numbered


def _colours_of(basins: xr.Dataset) -> list[str]:
    """Return the colour of each attractor, by the sizes of their basins."""
    order = np.argsort(-basins["fraction"].to_numpy(), kind="stable")
    colours = [OTHERS] * len(order)
    for colour, number in zip(CLASS_COLOURS, order, strict=False):
        colours[int(number)] = colour
    return colours


def _pale(colour: str) -> tuple[float, float, float]:
    red, green, blue = (1.0 - PALE * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue


def _draw_attractors(ax: Axes, basins: xr.Dataset, colours: list[str]) -> None:
    points = [name for name in basins if str(name).startswith("attractor_")]
    if len(points) < 2:
        # Over a direction of starts an attractor has no place in the plane.
        return
    x, y = (basins[name].to_numpy() for name in points)
    for i, colour in enumerate(colours):
        finite = np.isfinite(x[i]) & np.isfinite(y[i])
        if str(basins["kind"].to_numpy()[i]) == "chaotic":
            ax.plot(x[i, finite], y[i, finite], ".", color=BLACK, markersize=1.6, rasterized=True)
        else:
            ax.plot(
                x[i, finite], y[i, finite], "o", color=colour, markersize=7.0,
                markeredgecolor=BLACK, markeredgewidth=1.0,
            )  # fmt: skip


def _draw_manifolds(ax: Axes, given: Any) -> list[str]:
    """Draw curves, and return which kinds there are."""
    drawn: list[str] = []
    for kind, curve in _curves(given, "stable"):
        ax.plot(*curve.T, color=BLACK, linewidth=1.1, linestyle=MANIFOLD_LINES[kind])
        if kind not in drawn:
            drawn.append(kind)
    return drawn


def _curves(given: Any, kind: str) -> Iterable[tuple[str, Floats]]:
    """Yield each curve with its kind, out of manifolds, mappings, arrays and sequences of them."""
    if isinstance(given, Mapping):
        for name in ("stable", "unstable"):
            yield from _curves(given.get(name, ()), name)
        return
    if hasattr(given, "branches"):
        yield from _curves(given.branches, kind)
        return
    if hasattr(given, "pieces"):
        yield from _curves(given.pieces, given.kind)
        return
    if isinstance(given, np.ndarray):
        if given.ndim != 2 or given.shape[1] != 2:
            raise ParameterError("manifolds", given.shape, "not a curve, an array of shape (n, 2)")
        yield kind, given
        return
    if not isinstance(given, Iterable):
        raise ParameterError("manifolds", given, "neither curves nor manifolds")
    for item in given:
        yield from _curves(item, kind)


def _add_legend(ax: Axes, basins: xr.Dataset, colours: list[str], drawn: list[str]) -> None:
    fractions = basins["fraction"].to_numpy()
    handles: list[Any] = []
    for i in np.argsort(-fractions, kind="stable"):
        if colours[i] != OTHERS:
            text = f"{class_names(basins)[i]}: {_percent(float(fractions[i]))}"
            handles.append(Patch(facecolor=_pale(colours[i]), edgecolor=GREY, label=text))
    rest = [i for i, colour in enumerate(colours) if colour == OTHERS]
    if rest:
        text = f"{len(rest)} others: {_percent(float(fractions[rest].sum()))}"
        handles.append(Patch(facecolor=_pale(OTHERS), edgecolor=GREY, label=text))
    undecided = float(basins.attrs.get("undecided", 0.0))
    if undecided > 0.0:
        text = f"undecided: {_percent(undecided)}"
        handles.append(Patch(facecolor=UNDECIDED, edgecolor=GREY, label=text))
    if bool((basins["basin"] == -2).any()):
        handles.append(Patch(facecolor=NO_START, edgecolor=GREY, label="inside a wall"))
    for kind in drawn:
        line, label = MANIFOLD_LINES[kind], f"{kind} manifold"
        handles.append(Line2D([], [], color=BLACK, linestyle=line, label=label))
    legend_above(ax, handles=handles, ncols=min(ROW, len(handles)), **SPACING)


def _percent(part: float) -> str:
    return f"{part:.1%}" if part >= 0.001 or part == 0.0 else f"{part:.1e}"


@shared_docs
def plot_fractions(
    fractions: xr.Dataset,
    ax: Axes | None = None,
    *,
    attractor: int | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw which part of the starts goes to which attractor.

    Over one parameter all parts are stacked, those of the largest first, and the undecided last.
    Over two parameters it is a chart of one attractor, blank where that does not exist.

    Parameters
    ----------
    fractions
        What `percuss.basin_fractions` has returned.
    attractor
        Number of the attractor that a chart over two parameters shows; default: the one to which
        most starts go.

    Returns
    -------
    Axes
        The axes, with a legend, or with a colour bar.

    Raises
    ------
    ParameterError
        If it is something else, there is no such attractor, or one is named where all are drawn.
    """
    check_table("fractions", fractions, "percuss.basin_fractions", "fraction")
    units = units_of(units)
    if fractions["fraction"].ndim not in (2, 3):
        reason = "not what percuss.basin_fractions returns"
        raise ParameterError("fractions", sorted(map(str, fractions)), reason)
    if fractions["fraction"].ndim == 3:
        return _draw_chart(fractions, ax, attractor, units, (xlabel, ylabel))
    if attractor is not None:
        raise ParameterError("attractor", attractor, "over one parameter all of them are drawn")
    return _draw_stack(fractions, ax, units, (xlabel, ylabel))


def _draw_stack(
    fractions: xr.Dataset, ax: Axes | None, units: Units, labels: tuple[str | None, str | None]
) -> Axes:
    path = str(fractions["fraction"].dims[1])
    along = np.argsort(fractions[path].to_numpy())
    x = edges_of(fractions[path].to_numpy()[along])
    parts = np.nan_to_num(fractions["fraction"].to_numpy()[:, along])
    order = np.argsort(-parts.sum(axis=1), kind="stable")
    with picture(ax, labels=labels) as ax:
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
        legend_above(ax, ncols=ROW, **SPACING)
    return ax


def _draw_chart(
    fractions: xr.Dataset,
    ax: Axes | None,
    attractor: int | None,
    units: Units,
    labels: tuple[str | None, str | None],
) -> Axes:
    across, upwards = (str(dim) for dim in fractions["fraction"].dims[1:])
    every = fractions["fraction"].transpose("attractor", upwards, across).to_numpy()
    n = len(every)
    if attractor is None:
        attractor = int(np.argmax(np.nansum(every, axis=(1, 2)))) if n else 0
    if not 0 <= attractor < n:
        raise ParameterError("attractor", attractor, f"the number of none; there are {n}")
    exists = fractions["exists"].transpose("attractor", upwards, across).to_numpy()[attractor]
    with picture(ax, labels=labels) as ax:
        x, y = (fractions[dim].to_numpy() for dim in (across, upwards))
        hatch_missing(ax)
        shown = draw_cells(
            ax, x, y, np.ma.masked_where(~exists, every[attractor]),
            cmap=mpl.colormaps["cividis"], norm=Normalize(0.0, 1.0),
        )  # fmt: skip
        label_axes(ax, fractions, across, upwards, units)
        colour_bar(ax, shown, f"part of the starts that go to {_label(fractions, attractor)}")
        if not exists.all():
            legend_above(ax, handles=[missing_patch("it does not exist")])
    return ax


def _label(fractions: xr.Dataset, i: int) -> str:
    """Return the names that an attractor has along the parameter, in order, a few of them.

    Over two parameters those that it has most often come first.
    """
    table = fractions["name"].to_numpy()[i]
    names = [str(name) for name in table.ravel() if name]
    if table.ndim == 2:
        counts = Counter(names).most_common()
        different = [name for name, _ in counts]
        return ", ".join([*different[:2], "..."] if len(different) > 3 else different)
    different = [name for k, name in enumerate(names) if k == 0 or names[k - 1] != name]
    if len(different) > 3:
        different = [*different[:2], "...", different[-1]]
    return ", ".join(different)
