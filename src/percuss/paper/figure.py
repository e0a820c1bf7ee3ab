"""A figure of the paper: how its data come about, how it is drawn, what it says, its frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # Both take a second to import, and listing the figures needs neither.
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset


@dataclass(frozen=True)
class PrintedFrame:
    """The frame of a panel in the article: the numbers printed along its axes.

    An axis may end up to one step beyond its last number.

    Parameters
    ----------
    panel
        Letter of the panel; empty where the figure has one.
    x, y
        The numbers along the axes, increasing.
    x_end
        End of the horizontal axis where the article's text gives it; default: the last number.

    Examples
    --------
    >>> frame = PrintedFrame("a", (0, 10, 20), (0, 0.4, 0.8), x_end=30)
    >>> frame.across, frame.upwards, frame.text()
    ((0, 30), (0, 0.8), '(a) 0 to 30 by 0 to 0.8')
    """

    panel: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    x_end: float | None = None

    @property
    def across(self) -> tuple[float, float]:
        """Range of the horizontal axis."""
        return self.x[0], self.x[-1] if self.x_end is None else self.x_end

    @property
    def upwards(self) -> tuple[float, float]:
        """Range of the vertical axis."""
        return self.y[0], self.y[-1]

    def text(self) -> str:
        """Return the ranges in words."""
        (left, right), (low, high) = self.across, self.upwards
        before = f"({self.panel}) " if self.panel else ""
        return f"{before}{left:g} to {right:g} by {low:g} to {high:g}"


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
    frames
        Its frames in the article, where the figure is one of the article's.

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
    frames: tuple[PrintedFrame, ...] = ()

    def full_caption(self, data: Dataset) -> str:
        """Return the caption with the printed frames."""
        if not self.frames:
            return self.caption(data)
        ranges = "; ".join(frame.text() for frame in self.frames)
        return f"{self.caption(data)} Printed axes, dotted where the motion goes beyond their numbers: {ranges}."
