"""The style of the paper's figures: panels for a phone's width, lines of any length."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags
from percuss.paper.figure import PrintedFrame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

# Inches: on a telephone 375 points wide the letters stay above 8 points.
WIDTH = 5.6
# Blue, vermilion and green of Okabe and Ito.
COLOURS = {
    "limit": "#0072B2",
    "stiff": "#D55E00",
    "soft": "#009E73",
    "steps": "#7A5195",
    "paper": "#6B6B6B",
}


def styled(draw: Callable[[Dataset], Picture]) -> Callable[[Dataset], Picture]:
    """Return a drawing function that draws in the style of `percuss.plotting`."""

    def draw_in_style(data: Dataset) -> Picture:
        from percuss.plotting.style import style

        with style():
            return draw(data)

    return draw_in_style


def panels(
    count: int, height: float = 2.1, *, columns: int = 1, share_x: bool = True
) -> tuple[Picture, list[Axes]]:
    """Return a figure and its axes, below one another or in a few columns.

    Parameters
    ----------
    count
        Number of axes.
    height
        Height of a row [inch].
    columns
        Number of columns.
    share_x
        Whether axes in one column share the range and the labels of their abscissa.
    """
    from percuss.plotting.style import fix_ticks, offscreen_figure

    rows = math.ceil(count / columns)
    figure = offscreen_figure(WIDTH, rows * height + 0.3)
    grid = figure.subplots(rows, columns, squeeze=False, sharex="col" if share_x else "none")
    axes = list(grid.flat)
    for ax in axes:
        fix_ticks(ax)
    for ax in axes[count:]:
        ax.remove()
    return figure, axes[:count]


def label(ax: Axes, text: str, letter: str = "") -> None:
    """Write what a panel shows above it, on the left."""
    words = f"({letter}) {text}" if letter else text
    ax.set_title(words, loc="left", fontsize=10.0)


def draw_curve(
    ax: Axes, t: ArrayLike, values: ArrayLike, jumps: ArrayLike | None = None, **look: Any
) -> None:
    """Draw values over time; more than 20,000 points become the extremes of each pixel column.

    Parameters
    ----------
    ax
        The axes.
    t, values
        (n,) arrays, t increasing.
    jumps
        (n,) array, true where the line breaks between a point and the next; default: nowhere.
    **look
        As `matplotlib.axes.Axes.plot` takes them.
    """
    from percuss.plotting.samples import reduce_to_columns, separated

    times = np.asarray(t, dtype=np.float64)
    broken: Flags = np.zeros(times.size, dtype=np.bool_)
    if jumps is not None:
        broken = np.asarray(jumps, dtype=np.bool_)
    times, kept, broken = reduce_to_columns(times, np.asarray(values, dtype=np.float64), broken)
    ax.plot(separated(times, broken), separated(kept, broken), **look)


def draw_motion(
    ax: Axes, data: Dataset, name: str, what: str, *, scale: float = 1.0, **look: Any
) -> None:
    """Draw the displacement ("x") or the velocity ("v") of a run in a `motion_dataset`.

    Velocities are joined over an impact by their vertical jump, as in the paper.
    """
    look = {"color": COLOURS.get(name), "linewidth": 1.0, **look}
    draw_curve(ax, data[f"t_{name}"].values / scale, data[f"{what}_{name}"].values, **look)


def draw_envelope(
    ax: Axes, t_end: float, factor: float, text: str, *, signs: Sequence[int] = (1,)
) -> None:
    """Draw factor sqrt(t), on either side of zero where `signs` says so, above what is drawn."""
    from matplotlib.patheffects import withStroke

    t = np.linspace(0.0, t_end, 400)
    # A white edge keeps the dashes visible on the ink of the motion.
    look: dict[str, Any] = {"color": "black", "ls": (0, (4, 2)), "lw": 1.3, "zorder": 5}
    edge = [withStroke(linewidth=3.2, foreground="white")]
    for sign in signs:
        name = text if sign == signs[0] else None
        ax.plot(t, sign * factor * np.sqrt(t), label=name, path_effects=edge, **look)


def draw_frame(
    ax: Axes,
    frame: PrintedFrame,
    *,
    x: tuple[float, float] | None = None,
    y: tuple[float, float] | None = None,
    note: bool = True,
) -> None:
    """Show the printed frame, or more with the frame as a thin rectangle; ticks as printed.

    Parameters
    ----------
    ax
        The axes, linear or logarithmic.
    frame
        The printed frame.
    x, y
        What is shown where the motion goes beyond the printed numbers; default: their range.
    note
        Whether to say beside the title what is dotted.
    """
    from matplotlib.patches import Rectangle

    ax.set(xlim=x or frame.across, ylim=y or frame.upwards, xticks=frame.x, yticks=frame.y)
    if {x, y} <= {None, frame.across, frame.upwards}:
        return
    (left, right), (low, high) = frame.across, frame.upwards
    rectangle = Rectangle((left, low), right - left, high - low, fill=False, gid="printed frame")
    rectangle.set(edgecolor=COLOURS["paper"], lw=0.8, ls=":", clip_on=False, zorder=4)
    ax.add_patch(rectangle)
    if note:
        ax.set_title("dotted: printed numbers", loc="right", fontsize=7.5, color=COLOURS["paper"])


def reach(column: ArrayLike, printed: tuple[float, float]) -> tuple[float, float]:
    """Return the printed range, with 5 % of room where the values go beyond it."""
    values = np.asarray(column, dtype=np.float64)
    least, greatest = float(np.nanmin(values)), float(np.nanmax(values))
    low, high = printed
    room = 0.05 * (max(greatest, high) - min(least, low))
    return low if least >= low else least - room, high if greatest <= high else greatest + room
