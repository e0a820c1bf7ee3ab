"""Numbers over two axes as coloured cells, hatched where there is none; labels of the axes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from percuss.arrays import Floats
from percuss.ensembles.grid import units_of as dimensions_of
from percuss.model.units import Units, is_unit
from percuss.orbits.bifurcations.branch import Branch

# Values that are equally spaced to this part of a step are drawn as an image.
EVEN = 1e-6
# Behind cells without a number.
MISSING: dict[str, Any] = {"facecolor": "#FFFFFF", "edgecolor": "#C8C8C8", "hatch": "////"}
_DIMENSIONS = {"length": "displacement", "time": "duration", "length/time": "velocity"}


def edges_of(values: Floats) -> Floats:
    """Return the edges of the cells around values in order: half way to the next.

    Examples
    --------
    >>> edges_of(np.array([1.0, 2.0, 4.0]))
    array([0.5, 1.5, 3. , 5. ])
    """
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


def _is_even(edges: Floats) -> bool:
    steps = np.diff(edges)
    return bool(np.ptp(steps) <= EVEN * np.abs(steps).max())


def label_of(name: str, dimensions: str, units: Units | None) -> str:
    """Return the label of an axis: a parameter's path, with its unit where there are units.

    Examples
    --------
    >>> label_of("start.v0", "length/time", Units("m", "s"))
    'start.v0 (m/s)'
    """
    if is_unit(dimensions):
        return f"{name} ({dimensions})"
    measure = _DIMENSIONS.get(dimensions)
    if units is None or measure is None or units == Units():
        return name
    return f"{name} ({getattr(units, measure)})"


def label_axes(ax: Axes, data: xr.Dataset, across: str, upwards: str, units: Units) -> None:
    """Name both axes after the parameters that they carry."""
    ax.set_xlabel(path_label(data, across, units))
    ax.set_ylabel(path_label(data, upwards, units))


def path_label(data: xr.Dataset, path: str, units: Units | None) -> str:
    """Return the label of an axis over a parameter, in its short form where that is clear.

    Examples
    --------
    >>> forcing = {"forcing": "Forcing(harmonics=(Harmonic(amplitude=1.0, omega=2.5, phase=0.0),))"}
    >>> path = "forcing.harmonics.0.omega"
    >>> path_label(xr.Dataset(coords={path: [2.0]}, attrs=forcing), path, None)
    'forcing.omega'
    """
    forcing = str(data.attrs.get("forcing", ""))
    # Of several harmonics the number says which.
    is_only_one = forcing.count("Harmonic(") == 1 and "base=" not in forcing
    name = path.replace("forcing.harmonics.0.", "forcing.") if is_only_one else path
    return label_of(name, str(data[path].attrs.get("units", "")), units)


def parameter_label(branch: Branch, units: Units) -> str:
    """Return the label of an axis over the parameter of a branch, with its unit where there is one."""
    oscillator, forcing = branch.orbits[0].system
    if units == Units() or "." not in branch.path:
        return branch.path
    return f"{branch.path} ({units.of(dimensions_of(branch.path, oscillator, forcing))})"
