"""A bifurcation diagram as a raster of densities, each direction in a colour of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_rgb
from matplotlib.patches import Patch

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.model.units import Units
from percuss.plotting.cells import EVEN, check_table, draw_cells
from percuss.plotting.direction_view import combination
from percuss.plotting.labels import path_label, with_unit
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    VERMILION,
    colour_bar,
    legend_above,
    picture,
    shared_docs,
    units_of,
)

# Cells upwards: about one for every pixel of an axes 4 inches high at 120 dots per inch.
ROWS = 480
# Points of one direction lie among those of another within so many cells: chaos leaves gaps.
NEAR_COLUMNS, NEAR_ROWS = 1, 6
# A cell with so large a part of the points at a value belongs to a line, drawn this much thicker.
LINE, THICKER = 1 / 32, 1
# More values of a parameter than this that are not equally spaced are put into so many columns.
COLUMNS = 900
# The faintest cell with a point in it, as a part of the full colour.
FAINTEST = 0.35
# Where a few points lie so many times farther out than the others, the others are looked at.
FAR_OUT, SHARE = 4.0, 0.05
# Points that differ by less than this part of their size differ by rounding.
ROUNDING = 1e-9
NAMES = {
    "x": "x at whole periods",
    "v": "v at whole periods",
    "cycle": "cycle of impacts",
    "v_after": "velocity after impacts",
}
COLOURS = {"forward": BLUE, "backward": VERMILION, "both": BLACK, "from the starts": GREEN}


@shared_docs
def plot_diagram(
    diagram: xr.Dataset,
    ax: Axes | None = None,
    *,
    quantity: str | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw a bifurcation diagram, any number of points, by how many of them lie in each cell.

    Cells that hold points of the forward branch, of the backward one, and of both have colours
    of their own; where points of neither lie, those begun afresh from the starts are drawn. The
    colour is the fuller, the more points lie there, on a logarithmic scale.

    Parameters
    ----------
    diagram
        What `percuss.bifurcation_diagram` has returned.
    quantity
        "x" or "v" at whole periods or another cycle; of impacts "v_after" or "cycle"; of the
        passages of a displacement "v" or "cycle". Default: "x", "v_after" or "v".

    Returns
    -------
    Axes
        The axes, with a legend and a colour bar.

    Raises
    ------
    ParameterError
        If there is no such quantity.
    """
    check_table("diagram", diagram, "percuss.bifurcation_diagram", "branch", "period")
    units = units_of(units)
    name = quantity or next(key for key in ("x", "v_after", "v") if key in diagram)
    if name not in diagram or name not in NAMES:
        known = " nor ".join(key for key in NAMES if key in diagram)
        raise ParameterError("quantity", quantity, f"neither {known}")
    (path,) = (str(dim) for dim in diagram["period"].dims if dim != "branch")
    x = diagram[path].to_numpy()
    groups = _groups(diagram, name)
    low, high = _range(groups)
    counts = {key: _thickened(_counts(x, values, low, high)) for key, values in groups.items()}
    columns = _columns(x)
    layers = _layers(counts)
    norm = LogNorm(1, max(2, *(int(count.max()) for count in layers.values())))
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        rows = np.linspace(low, high, ROWS + 1)
        middles = 0.5 * (rows[1:] + rows[:-1])
        draw_cells(ax, columns, middles, _coloured(layers, norm))
        ax.set_xlabel(path_label(diagram, path, units))
        ax.set_ylabel(
            with_unit(_name_of(diagram, name), str(diagram[name].attrs.get("units", "")), units)
        )
        used = [key for key in COLOURS if key in layers and layers[key].any()]
        if not used:
            where = str(diagram.attrs.get("section", "")) or name
            ax.text(0.5, 0.5, f"no points: {where}", transform=ax.transAxes, ha="center")
            return ax
        _add_bar(ax, norm, COLOURS[used[0]] if len(used) == 1 else BLACK)
        if len(used) > 1:
            handles = [Patch(color=COLOURS[key], label=key) for key in used]
            legend_above(ax, handles=handles, ncols=len(used))
    return ax


def _name_of(diagram: xr.Dataset, name: str) -> str:
    """Return a quantity in words, with the section at which it is taken."""
    section = str(diagram.attrs.get("section", ""))
    if "=" not in section:
        return NAMES[name].replace("x at", f"{_line_of(diagram)} at")
    return f"cycle of passages of {section}" if name == "cycle" else f"{name} at {section}"


def _line_of(diagram: xr.Dataset) -> str:
    """Return the displacement in the diagram: x, or that of a structure as a formula."""
    on = str(diagram.attrs.get("on", ""))
    return (
        f"${combination([float(c) for c in on.strip('()').split(',') if c.strip()])}$"
        if "(" in on
        else "x"
    )


def _groups(diagram: xr.Dataset, name: str) -> dict[str, Floats]:
    """Return the points of each direction and those from the starts, (values, points) each."""
    groups: dict[str, Floats] = {}
    path = next(dim for dim in diagram["period"].dims if dim != "branch")
    for branch in diagram["branch"].to_numpy():
        key = str(branch) if branch in ("forward", "backward") else "from the starts"
        values = diagram[name].sel(branch=branch).transpose(path, "sample").to_numpy()
        groups[key] = np.concatenate([groups[key], values], axis=1) if key in groups else values
    return groups


def _range(groups: dict[str, Floats]) -> tuple[float, float]:
    """Return the range of the vertical axis, without a few points that are far out."""
    every = np.concatenate([values[np.isfinite(values)] for values in groups.values()])
    if len(every) == 0:
        return -1.0, 1.0
    low, high = float(every.min()), float(every.max())
    inner, outer = (float(q) for q in np.percentile(every, [SHARE, 100.0 - SHARE]))
    if high - low > FAR_OUT * (outer - inner) > 0.0:
        low, high = inner, outer
    size = max(abs(low), abs(high))
    margin = 0.03 * (high - low) if high - low > ROUNDING * size else 0.5 * (size or 1.0)
    return low - margin, high + margin


def _columns(x: Floats) -> Floats:
    """Return the middles of the columns: the values, unless they are many and at odd distances."""
    inside = np.sort(x)
    steps = np.diff(inside)
    if len(x) <= COLUMNS or np.ptp(steps) <= EVEN * steps.max():
        return inside
    return np.linspace(inside[0], inside[-1], COLUMNS)


def _counts(x: Floats, values: Floats, low: float, high: float) -> Integers:
    """Return how many points lie in each cell, (rows, columns)."""
    columns = _columns(x)
    column = np.abs(columns - x[:, np.newaxis]).argmin(axis=1)
    rows = np.floor((values - low) / (high - low) * ROWS)
    inside = np.isfinite(rows) & (rows >= 0) & (rows < ROWS)
    number = np.where(inside, rows, 0.0).astype(np.int64) * len(columns) + column[:, np.newaxis]
    counts = np.bincount(number[inside], minlength=ROWS * len(columns))
    return counts.reshape(ROWS, len(columns)).astype(np.int64)


def _layers(counts: dict[str, Integers]) -> dict[str, Integers]:
    """Return the counts of the cells of each colour; a cell has one."""
    layers: dict[str, Integers] = {}
    near = {key: _near(count > 0, NEAR_ROWS, NEAR_COLUMNS) for key, count in counts.items()}
    if "forward" in counts and "backward" in counts:
        both = near["forward"] & near["backward"]
        layers["both"] = np.where(both, counts["forward"] + counts["backward"], 0)
        layers["forward"] = np.where(both, 0, counts["forward"])
        layers["backward"] = np.where(both, 0, counts["backward"])
    else:
        layers |= {key: counts[key] for key in ("forward", "backward") if key in counts}
    if "from the starts" in counts:
        fresh = counts["from the starts"]
        covered = np.zeros(fresh.shape, dtype=np.bool_)
        for key in layers:
            covered |= near.get(key, covered)
        layers["from the starts"] = np.where(covered, 0, fresh)
    return layers


def _near(full: npt.NDArray[Any], rows: int, columns: int) -> npt.NDArray[Any]:
    """Return the largest value among the cells within so many rows and columns of each."""
    largest = full.copy()
    for axis, reach in ((0, rows), (1, columns)):
        # Each pass reads what the one before has left.
        source = largest.copy()
        for step in range(1, reach + 1):
            head = [slice(None), slice(None)]
            tail = [slice(None), slice(None)]
            head[axis], tail[axis] = slice(step, None), slice(None, -step)
            largest[tuple(head)] = np.maximum(largest[tuple(head)], source[tuple(tail)])
            largest[tuple(tail)] = np.maximum(largest[tuple(tail)], source[tuple(head)])
    return largest


def _thickened(counts: Integers) -> Integers:
    """Return counts in which lines of a few points at each value can be seen."""
    lines = np.where(counts >= LINE * counts.sum(axis=0), counts, 0)
    return np.asarray(np.maximum(counts, _near(lines, THICKER, 0)))


def _coloured(layers: dict[str, Integers], norm: LogNorm) -> Floats:
    shape = next(iter(layers.values())).shape
    picture = np.zeros((*shape, 4))
    for key, count in layers.items():
        full = count > 0
        share = FAINTEST + (1.0 - FAINTEST) * np.clip(np.asarray(norm(count[full])), 0.0, 1.0)
        picture[full, :3] = to_rgb(COLOURS[key])
        picture[full, 3] = share
    return picture


def _add_bar(ax: Axes, norm: LogNorm, colour: str) -> None:
    red, green, blue = to_rgb(colour)
    faint = (1 - FAINTEST * (1 - red), 1 - FAINTEST * (1 - green), 1 - FAINTEST * (1 - blue))
    shades = LinearSegmentedColormap.from_list("density", [faint, (red, green, blue)])
    colour_bar(ax, ScalarMappable(norm, shades), "points in a cell", fraction=0.05)
