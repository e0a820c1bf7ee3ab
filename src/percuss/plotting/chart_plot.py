"""Charts: a number of the attractor over two parameters, or over one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize, TwoSlopeNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from percuss.arrays import Flags, Floats
from percuss.ensembles.grid import SAMPLE
from percuss.errors import ParameterError
from percuss.model.units import Units
from percuss.plotting.cells import (
    check_table,
    draw_cells,
    hatch_missing,
    is_logarithmic,
    missing_patch,
)
from percuss.plotting.labels import label_axes, path_label, with_unit
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    colour_bar,
    legend_above,
    picture,
    refuse_axes,
    shared_docs,
    units_of,
)

# No period found, and periods 1, 2, ... , the last colour for all longer ones: neighbours differ in
# lightness, too.
PERIODS = (
    "#1A1A1A", "#56B4E9", "#0072B2", "#F0E442", "#E69F00", "#009E73", "#CC79A7", "#D55E00",
    "#8C510A", "#B8B8B8",
)  # fmt: skip
MINUS_INFINITY = "#8FCFB2"
# Dots over one parameter that are drawn small.
MANY = 400
# Dots over two parameters: their colour where there is no answer, the area of all together, and the
# least and largest of one [point^2].
NO_ANSWER, DOTS, DOT_SIZES = "#A0A0A0", 12_000.0, (3.0, 30.0)
# The colours span all but this part of the values, in percent, at either end.
FAR_OUT = 0.5


@shared_docs
def plot_chart(
    data: xr.Dataset,
    measure: str | None = None,
    ax: Axes | None = None,
    *,
    over: Sequence[str] | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw a measure over two parameters in colours, with a colour bar.

    Periods have a colour each. What has both signs, as a Lyapunov exponent, has one hue for
    either, and 0 is white between them. Paired settings are dots, in place of cells.

    Parameters
    ----------
    data
        What `percuss.sweep` has returned, over two paths, or over paired values of several.
    measure
        Which of its measures; default: the first.
    over
        The two parameters, across and upwards; default: the first two.

    Returns
    -------
    Axes
        The axes; points without an answer are hatched.

    Raises
    ------
    ParameterError
        If there is no such measure or parameter, or it is not over two paths.
    """
    units = units_of(units)
    name = _measure_of(data, measure, 2)
    across, upwards = _axes_of(data, name, over, 2)
    is_paired = data[name].ndim == 1
    dims = data[name].dims if is_paired else (upwards, across)
    values = data[name].transpose(*dims).to_numpy().astype(np.float64)
    scale = _periods(values) if _is_count(data, name) else _shades(values)
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        x, y = (data[dim].to_numpy() for dim in (across, upwards))
        if is_paired:
            shown = _draw_dots(ax, x, y, values, scale)
        else:
            shown = _draw_grid(ax, x, y, values, scale)
        label_axes(ax, data, across, upwards, units)
        _add_bar(ax, _name_of(data, name, units), scale, shown)
        _add_legend(ax, values, is_paired=is_paired)
    return ax


def _draw_grid(ax: Axes, x: Floats, y: Floats, values: Floats, scale: _Scale) -> Any:
    """Draw a cell for each number, and return what can have a colour bar."""
    hatch_missing(ax)
    seen = np.where(np.isneginf(values), np.nan, values)
    shown = draw_cells(ax, x, y, np.ma.masked_invalid(seen), cmap=scale.map, norm=scale.norm)
    if np.isneginf(values).any():
        # An exponent of minus infinity: the motion sticks, and forgets its start there.
        sticking = np.ma.masked_where(~np.isneginf(values), np.zeros_like(values))
        draw_cells(ax, x, y, sticking, cmap=ListedColormap([MINUS_INFINITY]))
    return shown


def _draw_dots(ax: Axes, x: Floats, y: Floats, values: Floats, scale: _Scale) -> Any:
    """Draw a dot for each number, and return what can have a colour bar."""
    size = float(np.clip(DOTS / max(len(values), 1), *DOT_SIZES))
    known, sticks = np.isfinite(values), np.isneginf(values)
    # White is a number, too: an edge tells it from the background.
    look: dict[str, Any] = {"s": size, "linewidths": 0.2, "edgecolors": GREY}
    ax.scatter(x[sticks], y[sticks], color=MINUS_INFINITY, s=size)
    none = ~known & ~sticks
    ax.scatter(x[none], y[none], s=size, marker="x", color=NO_ANSWER, linewidths=0.8)
    return ax.scatter(x[known], y[known], c=values[known], cmap=scale.map, norm=scale.norm, **look)


@shared_docs
def plot_sweep(
    data: xr.Dataset,
    measure: str | None = None,
    ax: Axes | None = None,
    *,
    over: str | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw a measure over one parameter; points without an answer leave gaps.

    Paired settings are dots, as another parameter may vary with the one that is drawn. Values in
    equal ratios have a logarithmic axis.

    Parameters
    ----------
    data
        What `percuss.sweep` has returned, over one path, or over paired values of several.
    measure
        Which of its measures; default: the first.
    over
        The parameter; default: the first.

    Raises
    ------
    ParameterError
        If there is no such measure or parameter, or it is not over one path.
    """
    units = units_of(units)
    name = _measure_of(data, measure, 1)
    (path,) = _axes_of(data, name, None if over is None else [over], 1)
    order = np.argsort(data[path].to_numpy(), kind="stable")
    x, y = data[path].to_numpy()[order], data[name].to_numpy()[order]
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        whole = _is_count(data, name) or len(x) < 20 or path not in data[name].dims
        dots = {"marker": ".", "linestyle": "none", "markersize": 6.0 if len(x) < MANY else 2.5}
        look = dots if whole else {"linewidth": 1.0}
        ax.plot(x, np.where(np.isfinite(y), y, np.nan), color=BLUE, **look)
        if not whole:
            alone = _is_alone(np.isfinite(y))
            ax.plot(x[alone], y[alone], ".", color=BLUE, markersize=3.0)
        if not np.isfinite(y).any():
            ax.text(0.5, 0.5, "no answer", transform=ax.transAxes, ha="center")
            if x[0] < x[-1]:
                ax.set_xlim(x[0], x[-1])
        if np.nanmin(np.where(np.isfinite(y), y, np.nan), initial=0.0) < 0.0:
            ax.axhline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        if is_logarithmic(x):
            ax.set_xscale("log")
        ax.set_xlabel(path_label(data, path, units))
        ax.set_ylabel(_name_of(data, name, units))
    return ax


def _is_alone(answered: Flags) -> Flags:
    """Return which answers have none on either side, so that no line reaches them."""
    around = np.concatenate([[False], answered, [False]])
    return np.asarray(answered & ~around[:-2] & ~around[2:])


@dataclass(frozen=True, slots=True)
class _Scale:
    """How numbers become colours.

    Attributes
    ----------
    map, norm
        As matplotlib takes them.
    ticks, labels
        Of the colour bar; None for matplotlib's own.
    extend
        At which ends numbers lie beyond the bar.
    """

    map: Colormap
    norm: Normalize
    ticks: list[float] | None = None
    labels: list[str] | None = None
    extend: str = "neither"


def _measure_of(data: xr.Dataset, measure: str | None, n_axes: int) -> str:
    check_table("data", data, "percuss.sweep")
    refuse_axes("measure", measure)
    known = [
        str(name)
        for name, values in data.data_vars.items()
        if values.size
        and (
            (count := len(_parameters_of(data, str(name)))) == n_axes
            or (values.dims == (SAMPLE,) and count > n_axes)
        )
        and all(part.dtype.kind in "fi" for part in (values, *(data[dim] for dim in values.dims)))
        and "failure" not in values.dims
    ]
    if not known:
        dims = [str(dim) for dim in data.coords]
        wanted = "one parameter" if n_axes == 1 else "two parameters"
        other = "; plot_chart draws two" if n_axes == 1 else "; plot_sweep draws one"
        raise ParameterError("data", dims, f"no measure over {wanted}{other}")
    if measure is not None and measure not in known:
        raise ParameterError("measure", measure, f"none of {', '.join(known)}")
    return measure or known[0]


def _parameters_of(data: xr.Dataset, name: str) -> list[str]:
    """Return the parameters of a measure: its dimensions, or those that samples have."""
    dims = data[name].dims
    if dims != (SAMPLE,):
        return [str(dim) for dim in dims]
    return [str(other) for other in data.coords if other != SAMPLE and data[other].dims == dims]


def _axes_of(data: xr.Dataset, name: str, over: object, n_axes: int) -> list[str]:
    """Return the parameters of the axes: those asked for, or the first ones."""
    known = _parameters_of(data, name)
    if over is None:
        return known[:n_axes]
    asked: list[Any] = list(over) if isinstance(over, list | tuple) else [over]
    if not all(one in known for one in asked) or not len(asked) == len(set(asked)) == n_axes:
        if n_axes == 1:
            reason = f"not the path of a parameter of the data; these are {', '.join(known)}"
            raise ParameterError("over", asked[0], reason)
        reason = f"not {n_axes} different parameters of the data; these are {', '.join(known)}"
        raise ParameterError("over", over, reason)
    return asked


def _periods(values: Floats) -> _Scale:
    """Return a colour for each period, the last one for all that are longer."""
    most = len(PERIODS) - 2
    longest = int(min(np.nanmax(values, initial=1.0), most + 1))
    colours = list(PERIODS[: longest + 1])
    labels = ["none", *(str(p) for p in range(1, longest + 1))]
    if longest > most:
        colours[-1], labels[-1] = PERIODS[-1], f"> {most}"
    edges = np.arange(-0.5, longest + 1.0)
    edges[-1] = np.inf if longest > most else edges[-1]
    norm = BoundaryNorm([*edges[:-1], longest + 0.5], len(colours), clip=True)
    return _Scale(ListedColormap(colours), norm, [float(p) for p in range(longest + 1)], labels)


def _shades(values: Floats) -> _Scale:
    """Return shades for numbers: one hue, or one for either sign."""
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return _Scale(mpl.colormaps["cividis"], Normalize(0.0, 1.0))
    low, high = (float(q) for q in np.percentile(finite, [FAR_OUT, 100.0 - FAR_OUT]))
    if low == high:
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    # Rounding beyond the ends is no number beyond them.
    tolerance = 1e-9 * (high - low)
    below, above = bool((finite < low - tolerance).any()), bool((finite > high + tolerance).any())
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}.get(
        (below, above), "both"
    )
    if low < 0.0 < high:
        return _Scale(mpl.colormaps["PuOr_r"], TwoSlopeNorm(0.0, low, high), extend=extend)
    return _Scale(mpl.colormaps["cividis"], Normalize(low, high), extend=extend)


def _add_legend(ax: Axes, values: Floats, *, is_paired: bool) -> None:
    """Explain what has no number in the colour bar."""
    handles: list[Artist] = []
    if np.isneginf(values).any():
        handles.append(Patch(color=MINUS_INFINITY, label="minus infinity"))
    if np.isnan(values).any():
        cross = Line2D([], [], marker="x", color=NO_ANSWER, linestyle="none", label="no answer")
        handles.append(cross if is_paired else missing_patch("no answer"))
    if handles:
        legend_above(ax, handles=handles, ncols=2)


def _add_bar(ax: Axes, label: str, scale: _Scale, shown: Any) -> None:
    source = shown if scale.labels is None else ScalarMappable(scale.norm, scale.map)
    bar = colour_bar(ax, source, label, extend=scale.extend)
    if scale.ticks is not None and scale.labels is not None:
        bar.set_ticks(scale.ticks, labels=scale.labels)
        bar.ax.tick_params(length=0.0, which="both")


def _is_count(data: xr.Dataset, name: str) -> bool:
    """Return whether a measure is a period in forcing periods, not a time."""
    return name == "period" and str(data[name].attrs.get("units", "1")) == "1"


def _name_of(data: xr.Dataset, name: str, units: Units) -> str:
    if _is_count(data, name):
        return "forcing periods of the orbit"
    words = name.replace("_", " ").replace("lyapunov", "Lyapunov")
    return with_unit(words, str(data[name].attrs.get("units", "1")), units)
