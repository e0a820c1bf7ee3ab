"""The style of all pictures: colours, fonts, units, labels, legends, and the words for parameters.

Nothing of matplotlib is changed globally.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar, cast

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import AutoLocator, MaxNLocator
from matplotlib.transforms import offset_copy

from percuss.errors import ParameterError
from percuss.model.units import Units

# The palette of Okabe and Ito, which people with any of the colour blindnesses can distinguish.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#6B6B6B"
# Colours of several curves, in turn.
COLOUR_CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY_BLUE)

# Entries in a row of a legend below a figure.
MOST_IN_A_ROW = 6
# Width of a digit of a tick's label and of the gap to the next, in sizes of its font.
DIGIT, TICK_GAP = 0.6, 1.0
# Ticks of an axis whose labels are too long for matplotlib's own choice, and the part of its width
# that titles and scales beside it may leave.
MOST_TICKS, LEFT = 8, 0.85
# From the ticks to the title of an axis, where the factor of the ticks stands between them [point].
BELOW_FACTOR = 13.0

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
}
# What the colours stand on in a figure of our own, whatever style holds outside.
PAPER: dict[str, Any] = {
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "axes.facecolor": "white",
    "axes.grid": False,
    **dict.fromkeys(
        ("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), "black"
    ),
}


class HasUnits(Protocol):
    """A model, or what stands for one."""

    @property
    def units(self) -> Units | None:
        """What its numbers are measured in."""


# What means the same in every plot function.
SHARED_PARAMETERS = {
    "ax": "ax\n    Axes to draw on; default: those of a new figure.",
    "figure": "figure\n    An empty figure; default: a new one.",
    "window": "window\n    First and last time that are drawn; default: the whole run.",
    "on": "on\n    Of a structure the coordinate, direction or point that is drawn, with the stops on its "
    "line;\n    default: the line of its first stop.",
    "units": "units\n    Units on the axes; default: those of the oscillator, or dimensionless.",
    **dict.fromkeys(
        ("xlabel", "ylabel"),
        "xlabel, ylabel\n    Titles of the axes; default: what they carry, with its unit.",
    ),
}
SHARED_RETURNS = "Returns\n-------\nAxes\n    The axes.\n"
PlotFunction = TypeVar("PlotFunction", bound=Callable[..., Any])


def shared_docs(plot: PlotFunction) -> PlotFunction:
    """Add what plot functions share to a docstring: parameters such as `ax`, and the result.

    A parameter or result that the docstring describes itself keeps that description. The order is
    that of the signature; a parameter that is described nowhere is an error.
    """
    if plot.__doc__ is None:  # python -OO
        return plot
    heading = "Parameters\n----------\n"
    summary, text = inspect.cleandoc(plot.__doc__).split(heading, 1)
    section, _, rest = text.partition("\n\n")
    entries = {
        name: entry
        for entry in re.split(r"\n(?=\S)", section)
        for name in entry.splitlines()[0].split(", ")
    }
    described = SHARED_PARAMETERS | entries
    # One entry may describe two parameters.
    ordered = dict.fromkeys(described[name] for name in inspect.signature(plot).parameters)
    returns = "" if rest.startswith("Returns\n") else f"{SHARED_RETURNS}\n"
    parameters = "\n".join(ordered)
    plot.__doc__ = f"{summary}{heading}{parameters}\n\n{returns}{rest}".rstrip()
    return plot


def units_of(units: Units | None, oscillator: HasUnits | None = None) -> Units:
    """Return the units of a picture: those given, or those of the oscillator.

    In them a dollar is a dollar, not the beginning of mathematics.

    Raises
    ------
    ParameterError
        If they are no `Units`.
    """
    if units is None:
        units = None if oscillator is None else oscillator.units
    if units is None:
        return Units()
    if not isinstance(units, Units):
        raise ParameterError("units", units, 'not a Units; write Units("m", "s")')
    plain = (name.replace("$", r"\$") for name in (units.length, units.time, units.mass))
    return Units(*plain)


# Results that oscillators alone have.
ALONE = ("SingularitySet", "VelocityGap")


def check_kind(name: str, value: object, kind: type) -> None:
    """Raise a ParameterError if what is to be drawn is of another kind."""
    if not isinstance(value, kind):
        is_structure = type(value).__name__ in ("StructureOrbit", "StructureTrajectory")
        none = ", which structures do not have" if is_structure and kind.__name__ in ALONE else ""
        raise ParameterError(name, value, f"not a {kind.__name__}{none}")


@contextmanager
def style(*, is_own: bool = True) -> Iterator[None]:
    """Return a context in which new artists look like percuss's, and no other do.

    In a figure of our own they stand on white paper; one that is given keeps the style that holds.

    A backend that is loaded in it, as by the first figure in a notebook, says whether figures are
    shown by themselves. That stays: without it the second figure would not be seen.
    """
    is_interactive = mpl.is_interactive()
    try:
        # The names that matplotlib takes are typed from 3.11 on only.
        with mpl.rc_context(cast("Any", STYLE | PAPER if is_own else STYLE)):
            try:
                yield
            finally:
                is_interactive = mpl.is_interactive()
    finally:
        mpl.interactive(is_interactive)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure that pyplot shows, of a size in inches."""
    # pyplot chooses a backend when it is imported; the other functions here need none.
    from matplotlib import pyplot as plt

    return plt.figure(FigureClass=ShownOnce, figsize=(width, height), layout="constrained")


def given_figure(figure: object, width: float, height: float) -> Figure:
    """Return the figure to draw on: the one given, or a new one of this size.

    Raises
    ------
    ParameterError
        If it is no figure.
    """
    if figure is None:
        return new_figure(width, height)
    if not isinstance(figure, Figure | SubFigure):
        reason = "no figure of matplotlib; a picture of several panels makes its own axes"
        raise ParameterError("figure", figure, reason)
    return cast("Figure", figure)


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


def figure_of(artist: Artist) -> Figure | None:
    """Return the whole figure in which an artist is; `get_figure(root=True)` of matplotlib 3.10."""
    part = artist.get_figure()
    return None if part is None else cast("Figure | None", part.figure)


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
    ax: Axes | None,
    size: tuple[float, float] = (6.4, 4.0),
    *,
    legend: bool = False,
    labels: tuple[str | None, str | None] = (None, None),
) -> Iterator[Axes]:
    """Yield axes to draw a picture on: those given, or the only ones of a new figure.

    A new figure has a size [inch] and, with `legend`, a legend below all its axes. `labels` are
    titles of the axes that replace what the picture writes there. What the axes show already stays
    in sight.
    """
    with style(is_own=ax is None):
        axes = new_figure(*size).add_subplot() if ax is None else _given_axes(ax)
        seen = (axes.get_xlim(), axes.get_ylim()) if axes.has_data() else None
        yield axes
        if seen is not None:
            _keep_in_sight(axes, *seen)
        if labels[0] is not None:
            axes.set_xlabel(labels[0])
        if labels[1] is not None:
            axes.set_ylabel(labels[1])
        fix_ticks(axes)
        for axis in (axes.xaxis, axes.yaxis):
            axis.label.set_wrap(True)
        if legend and ax is None:
            draw_legend(axes.figure, axes.figure.axes)


def refuse_axes(name: str, value: object) -> None:
    """Raise a ParameterError where axes stand in the place of an argument before them."""
    if isinstance(value, Axes):
        raise ParameterError(name, value, f"axes in the place of the {name}; give them as ax=")


def _given_axes(ax: object) -> Axes:
    if not isinstance(ax, Axes):
        raise ParameterError("ax", ax, "not axes of matplotlib; other arguments are given by name")
    return ax


def _keep_in_sight(ax: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Widen the limits of the axes, if need be, to those of the picture before."""
    for seen, now, widen in (
        (x, ax.get_xbound(), ax.set_xbound),
        (y, ax.get_ybound(), ax.set_ybound),
    ):
        low, high = min(*seen, *now), max(*seen, *now)
        if (low, high) != now:
            widen(low, high)


def title_figure(figure: Figure | SubFigure, title: str, **look: Any) -> None:
    """Write a title above all panels, in several lines if it is long; a dollar is a dollar."""
    figure.suptitle(title, parse_math=False, wrap=True, **look)


def label_phase_plane(ax: Axes, units: Units, names: tuple[str, str] = ("$x$", "$v$")) -> None:
    """Name the axes of a phase portrait: displacement to the right, velocity upwards."""
    ax.set_xlabel(f"displacement {names[0]} ({units.displacement})")
    ax.set_ylabel(f"velocity {names[1]} ({units.velocity})")


def label_once(ax: Axes, label: str) -> str | None:
    """Return a label for the next artist, None where an artist of these axes has it already."""
    return None if label in ax.get_legend_handles_labels()[1] else label


def legend_above(ax: Axes, **options: Any) -> None:
    """Draw a legend above the axes, from their left edge on; options are those of a legend."""
    # 0.01 of the height keeps the frame of the axes free.
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.01), "borderaxespad": 0.0}
    if _has_factor(ax.yaxis):
        figure = figure_of(ax)
        above = offset_copy(ax.transAxes, figure, y=STYLE["font.size"] + 3.0, units="points")
        place["bbox_transform"] = above
    ax.legend(**place, **options)


def colour_bar(ax: Axes, source: Any, label: str, **options: Any) -> Colorbar:
    """Draw a colour bar on the right of the axes."""
    bar = ax.figure.colorbar(source, ax=ax, **{"pad": 0.02, "fraction": 0.06} | options)
    bar.set_label(label)
    bar.outline.set_linewidth(0.6)
    return bar


def draw_legend(figure: Figure | SubFigure, panels: Iterable[Axes]) -> None:
    """Draw one legend for all panels below them, each label once, as it looks in the last."""
    entries: dict[str, Artist] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            entries[label] = handle
    for columns in range(min(len(entries), MOST_IN_A_ROW), 0, -1):
        legend = figure.legend(
            list(entries.values()), list(entries), loc="outside lower center", ncols=columns
        )
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            break
        legend.remove()


def fix_ticks(ax: Axes) -> None:
    """Keep the look of the ticks, which matplotlib makes when it draws, after the context.

    Where their labels would run together there are fewer of them to the right.
    """
    ax.tick_params(
        direction=STYLE["xtick.direction"],
        labelsize=STYLE["xtick.labelsize"],
        width=0.8,
        length=3.5,
    )
    axis = ax.xaxis
    if isinstance(axis.get_major_locator(), AutoLocator):
        _part_labels(ax, axis)
    if _has_factor(axis):
        axis.labelpad = BELOW_FACTOR


def _part_labels(ax: Axes, axis: XAxis) -> None:
    """Take fewer ticks, until their labels stand apart."""
    figure = figure_of(ax)
    assert figure is not None
    width = LEFT * ax.get_position().width * figure.get_figwidth() * 72.0
    low, high = sorted(ax.get_xlim())
    for most in range(MOST_TICKS, 1, -1):
        places = [place for place in axis.get_majorticklocs() if low <= place <= high]
        labels = axis.get_major_formatter().format_ticks(places)
        letters = max((len(label) for label in labels), default=0)
        step = STYLE["xtick.labelsize"] * (DIGIT * letters + TICK_GAP)
        if (len(labels) - 1) * step <= width:
            break
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


def _has_factor(axis: XAxis | YAxis) -> bool:
    """Return whether the labels of the ticks have a factor or an offset, which stands apart."""
    formatter = axis.get_major_formatter()
    formatter.set_locs(list(axis.get_majorticklocs()))
    return bool(formatter.get_offset())
