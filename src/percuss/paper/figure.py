"""A figure of the paper: how its data come about, how it is drawn, what it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # Both take a second to import, and listing the figures needs neither.
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

__all__ = ["Figure"]


@dataclass(frozen=True)
class Figure:
    """One figure, from its definition to its caption.

    Parameters
    ----------
    name
        Short name, unique: "fig6", "figA1", "averaging".
    title
        What it shows, in a few words.
    caption
        Sentences about the data, with the numbers computed from them.
    compute
        Computes the data; deterministic.
    draw
        Draws the data, and computes nothing that the data do not hold.

    Examples
    --------
    >>> import xarray as xr
    >>> def ends(data: xr.Dataset) -> str:
    ...     return f"x ends at {float(data.x[-1]):g}."
    >>> def line() -> xr.Dataset:
    ...     return xr.Dataset({"x": ("t", [0.0, 1.0])})
    >>> def picture(data: xr.Dataset) -> "Picture":
    ...     from percuss.plotting.style import offscreen_figure
    ...     drawn = offscreen_figure(4.0, 3.0)
    ...     drawn.add_subplot().plot(data.x)
    ...     return drawn
    >>> figure = Figure("line", "a line", ends, line, picture)
    >>> figure.caption(figure.compute())
    'x ends at 1.'
    """

    name: str
    title: str
    caption: Callable[[Dataset], str]
    compute: Callable[[], Dataset]
    draw: Callable[[Dataset], Picture]
