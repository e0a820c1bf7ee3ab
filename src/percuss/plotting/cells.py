"""Numbers over two axes as coloured cells, hatched where there is none."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from percuss.arrays import Floats
from percuss.errors import ParameterError

# Values that are equally spaced to this part of a step are drawn as an image.
EVEN = 1e-6
# Behind cells without a number.
MISSING: dict[str, Any] = {"facecolor": "#FFFFFF", "edgecolor": "#C8C8C8", "hatch": "////"}


# Values in equal ratios, at least so many, have a logarithmic axis where their ends have this ratio.
FEWEST, WIDE = 4, 4.0


def is_logarithmic(values: Floats) -> bool:
    """Return whether an axis of values in order is logarithmic: their ratios are equal.

    Examples
    --------
    >>> is_logarithmic(np.array([1.0, 2, 4, 8])), is_logarithmic(np.array([1.0, 2, 3, 4]))
    (True, False)
    """
    if len(values) < FEWEST or not 0.0 < WIDE * values[0] < values[-1]:
        return False
    return _is_even(np.log(values))


def edges_of(values: Floats) -> Floats:
    """Return the edges of the cells around values in order: half way to the next on their axis.

    Examples
    --------
    >>> edges_of(np.array([1.0, 2.0, 4.0]))
    array([0.5, 1.5, 3. , 5. ])
    """
    if is_logarithmic(values):
        logs = np.log(values)
        step = 0.5 * (logs[-1] - logs[0]) / (len(logs) - 1)
        return np.asarray(np.exp(np.append(logs - step, logs[-1] + step)))
    if len(values) == 1:
        half = 0.5 * (abs(float(values[0])) or 1.0)
        return np.array([values[0] - half, values[0] + half])
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = values[0] - (middle[0] - values[0]), values[-1] + (values[-1] - middle[-1])
    return np.concatenate([[first], middle, [last]])


def draw_cells(ax: Axes, x: Floats, y: Floats, cells: npt.NDArray[Any], **look: Any) -> Any:
    """Draw a cell around each pair of values, and return what can have a colour bar.

    Parameters
    ----------
    ax
        Where.
    x, y
        (n,) and (m,) arrays, the values along the axes, in any order.
    cells
        (m, n) array of numbers or (m, n, 4) array of colours.
    **look
        For matplotlib: a colour map and its norm.
    """
    along, upwards = np.argsort(x), np.argsort(y)
    cells = cells[upwards][:, along]
    left, low = edges_of(x[along]), edges_of(y[upwards])
    if is_logarithmic(x[along]):
        ax.set_xscale("log")
    if is_logarithmic(y[upwards]):
        ax.set_yscale("log")
    if all(_is_even(edges) for edges in (left, low)):
        extent = (left[0], left[-1], low[0], low[-1])
        return ax.imshow(
            cells, origin="lower", extent=extent, aspect="auto", interpolation="nearest", **look
        )
    return ax.pcolormesh(left, low, cells, rasterized=True, **look)


def hatch_missing(ax: Axes) -> None:
    """Hatch the background, which is seen where a cell has no number."""
    ax.patch.set(**MISSING)


def missing_patch(label: str) -> Patch:
    """Return the entry of a legend for the hatched background."""
    return Patch(**MISSING, label=label)


def check_table(name: str, data: object, of: str, *columns: str) -> None:
    """Raise a `ParameterError` unless data is the table that a function returns.

    Parameters
    ----------
    name
        Name of the argument.
    data
        What was given.
    of
        The function.
    *columns
        Columns and coordinates by which its xarray.Dataset is known.

    Examples
    --------
    >>> check_table("data", xr.DataArray([1.0], name="period"), "percuss.sweep")
    Traceback (most recent call last):
    percuss.errors.ParameterError: data = 'period': one column of a table; give the whole Dataset \
that percuss.sweep returns
    >>> check_table("basins", xr.Dataset({"period": 1.0}), "percuss.basins", "basin")
    Traceback (most recent call last):
    percuss.errors.ParameterError: basins = ['period']: not what percuss.basins returns
    """
    whole = f"give the whole Dataset that {of} returns"
    if isinstance(data, xr.DataArray):
        raise ParameterError(name, str(data.name), f"one column of a table; {whole}")
    if not isinstance(data, xr.Dataset):
        raise ParameterError(name, type(data).__name__, f"no table; {whole}")
    if any(column not in data for column in columns):
        raise ParameterError(name, sorted(map(str, data)), f"not what {of} returns")


def _is_even(edges: Floats) -> bool:
    steps = np.diff(edges)
    return bool(np.ptp(steps) <= EVEN * np.abs(steps).max())
