"""How every picture looks: colours, fonts, axis labels. Nothing here is changed globally."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any, cast

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from percuss.errors import ParameterError

# The palette of Okabe and Ito, which people with any of the colour blindnesses can distinguish.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#6B6B6B"

# Of the entries of a legend.
MOST_IN_A_ROW = 6

STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 10.0,
    "axes.labelsize": 11.0,
    "axes.titlesize": 11.0,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "xtick.labelsize": 9.5,
    "ytick.labelsize": 9.5,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "butt",
    "hatch.linewidth": 0.7,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


@dataclass(frozen=True, slots=True)
class Units:
    """Units of length and time for the labels of the axes; empty texts mean dimensionless.

    They only name what the numbers of the run are measured in: no number is converted.

    Examples
    --------
    >>> Units("m", "s").velocity, Units().velocity
    ('m/s', 'dimensionless')
    """

    length: str = ""
    time: str = ""

    @property
    def displacement(self) -> str:
        """Unit of a displacement."""
        return _plain(self.length) or "dimensionless"

    @property
    def duration(self) -> str:
        """Unit of a time."""
        return _plain(self.time) or "dimensionless"

    @property
    def velocity(self) -> str:
        """Unit of a velocity."""
        if not self.length and not self.time:
            return "dimensionless"
        length, time = _plain(self.length), _plain(self.time)
        return f"{length or '1'}/{time}" if time else length


def _plain(text: str) -> str:
    """Return a text in which a dollar is a dollar, not the beginning of mathematics."""
    return text.replace("$", r"\$")


def units_of(units: Units | None) -> Units:
    """Return the units of a picture, dimensionless by default.

    Raises
    ------
    ParameterError
        If they are no `Units`.
    """
    if units is None:
        return Units()
    if not isinstance(units, Units):
        raise ParameterError("units", units, 'not a Units; write Units("m", "s")')
    return units


def style() -> AbstractContextManager[None]:
    """Return a context in which new artists look like percuss's, and no other do."""
    # The names that matplotlib takes are typed from 3.11 on only.
    return mpl.rc_context(cast("Any", STYLE))


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure that pyplot shows, of a size in inches."""
    # pyplot chooses a backend when it is imported; the other functions here need none.
    from matplotlib import pyplot as plt

    return plt.figure(FigureClass=ShownOnce, figsize=(width, height), layout="constrained")


class ShownOnce(Figure):
    """A figure that a notebook shows once, also where it is the last line of a cell.

    At the end of a cell the inline backend shows each figure that is open and closes it; one that
    has been shown as the value of the cell is closed already.
    """

    def _ipython_display_(self) -> None:
        if "inline" in mpl.get_backend():
            from matplotlib import pyplot as plt

            plt.close(self)
        # Shown as every figure is.
        raise NotImplementedError


def offscreen_figure(width: float = 8.0, height: float = 9.0) -> Figure:
    """Return an empty figure for a file, which no window ever shows.

    Parameters
    ----------
    width, height
        Size [inch].

    Returns
    -------
    Figure
        The figure, for the argument `figure` of `percuss.plotting.plot_motion`.
    """
    with style():
        return Figure(figsize=(width, height), layout="constrained")


@contextmanager
def picture(
    ax: Axes | None, size: tuple[float, float] = (6.4, 4.0), *, legend: bool = False
) -> Iterator[Axes]:
    """Yield axes to draw a picture on: those given, or the only ones of a new figure.

    Parameters
    ----------
    ax
        The axes, or None.
    size
        Of a new figure [inch].
    legend
        Whether a new figure has a legend, below all its axes.
    """
    with style():
        drawn = new_figure(*size).add_subplot() if ax is None else ax
        yield drawn
        fix_ticks(drawn)
        if legend and ax is None:
            draw_legend(drawn.figure, drawn.figure.axes)


def draw_legend(figure: Figure | SubFigure, panels: Iterable[Axes]) -> None:
    """Draw one legend for all panels below them, each label once, as it looks in the last."""
    entries: dict[str, Artist] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            entries[label] = handle
    if entries:
        figure.legend(
            list(entries.values()),
            list(entries),
            loc="outside lower center",
            ncols=min(len(entries), MOST_IN_A_ROW),
        )


def fix_ticks(ax: Axes) -> None:
    """Keep the look of the ticks, which matplotlib makes when it draws, after the context."""
    ax.tick_params(
        direction=STYLE["xtick.direction"],
        labelsize=STYLE["xtick.labelsize"],
        width=0.8,
        length=3.5,
    )
