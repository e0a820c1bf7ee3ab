"""Marks on axes for the events of a motion: stops, contacts, grazes, and jumps of the velocity."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib.artist import allow_rasterization
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from percuss.arrays import Flags, Floats, Integers
from percuss.model.exact import as_float
from percuss.model.oscillator import Stop, Wall
from percuss.plotting.direction_view import Drawable
from percuss.plotting.samples import distinct_spans, within
from percuss.plotting.style import BLUE, GREY, ORANGE, PURPLE, VERMILION, figure_of

# Share of the drawn range that lies beyond the motion on either side.
MARGIN = 0.06
# A stop further away than this share of the range is not shown: it would shrink the motion.
NEARBY = 0.3
CONTACT_STYLE: dict[str, Any] = {"color": VERMILION, "label": "contact"}
GRAZE_STYLE: dict[str, Any] = {
    "marker": "D",
    "markersize": 6.0,
    "markerfacecolor": "white",
    "markeredgecolor": PURPLE,
    "markeredgewidth": 1.6,
    "linestyle": "none",
    "label": "graze",
    "zorder": 6.0,
}

# Length of a dash and of a gap [point].
DASH, GAP = 3.2, 2.2


def draw_stops(
    ax: Axes,
    run: Drawable,
    x: Floats,
    axis: Literal["x", "y"],
    share: tuple[float, float] = (0.0, 1.0),
) -> None:
    """Draw the stops near a motion and set the limits of the axis that carries x.

    The displacements that are drawn, `x`, decide which stops are near. They take a share of the
    other axis, from 0 to 1.
    """
    near = _nearby(run, x)
    places = [as_float(stop.at) for stop in near]
    low, high = min([x.min(), *places]), max([x.max(), *places])
    margin = MARGIN * (high - low) or 0.5 * max(abs(low), 1.0)
    low, high = low - margin, high + margin
    (ax.set_xlim if axis == "x" else ax.set_ylim)(low, high)
    for stop in near:
        _draw_stop(ax, stop, (10.0 * (high - low), 0.7 * margin), axis, share)


def _nearby(run: Drawable, x: Floats) -> list[Stop]:
    reach = NEARBY * (x.max() - x.min())
    low, high = x.min() - reach, x.max() + reach
    return [stop for stop in run.oscillator.stops if low <= as_float(stop.at) <= high]


def _draw_stop(
    ax: Axes,
    stop: Stop,
    depths: tuple[float, float],
    axis: Literal["x", "y"],
    share: tuple[float, float],
) -> None:
    """Draw a wall as a line with a hatched strip behind it, a soft stop as a shaded region.

    The region and the strip are so deep.
    """
    far, depth = depths
    span, line = (ax.axvspan, ax.axvline) if axis == "x" else (ax.axhspan, ax.axhline)
    at = as_float(stop.at)
    outward = -1.0 if stop.side == "below" else 1.0
    if isinstance(stop, Wall):
        span(
            at,
            at + outward * depth,
            *share,
            facecolor="none",
            edgecolor=GREY,
            hatch="//////",
            lw=0.0,
        )
        line(at, *share, color=GREY, linewidth=0.7, zorder=1.5, label="wall")
    else:
        span(
            at, at + outward * far, *share, facecolor=ORANGE, alpha=0.15, lw=0.0, label="soft stop"
        )
        line(at, *share, color=ORANGE, linewidth=0.9, zorder=1.5)


def stop_places(run: Drawable, stops: Integers) -> Floats:
    """Return the displacement at each of the stops of an event table."""
    at = np.array([as_float(stop.at) for stop in run.oscillator.stops], dtype=np.float64)
    return at[stops] if at.size else np.zeros(stops.shape)


def draw_unit_circle(ax: Axes, edge: float) -> None:
    """Draw the unit circle and both axes in the plane of multipliers, up to an edge."""
    ax.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GREY, linewidth=1.0, zorder=1.0))
    for line in (ax.axhline, ax.axvline):
        line(0.0, color=GREY, linewidth=0.5, zorder=0.5)
    ax.set(xlim=(-edge, edge), ylim=(-edge, edge), aspect="equal")


def draw_contacts_in_time(
    ax: Axes, run: Drawable, low: float, high: float, *, velocity: bool
) -> None:
    """Draw each contact in [low, high] as a thick line, at the stop or at zero velocity."""
    start, release, shown = _contacts_within(run, low, high)
    if shown.any():
        places = stop_places(run, run.contacts.stop[shown])
        heights = 0.0 * places if velocity else places
        first, last = np.maximum(start[shown], low), np.minimum(release[shown], high)
        distinct = distinct_spans(first, last, heights, high - low)
        first, last, heights = first[distinct], last[distinct], heights[distinct]
        ax.hlines(heights, first, last, linewidth=3.5, zorder=4.0, color=VERMILION)
        # A contact may be too short for a line to be seen.
        ax.plot(first, heights, "s", markersize=4.5, zorder=5.0, **CONTACT_STYLE)


def _contacts_within(run: Drawable, low: float, high: float) -> tuple[Floats, Floats, Flags]:
    """Return beginnings and ends of all contacts, and which of them fall into [low, high]."""
    start = run.contacts.start
    release = np.where(np.isnan(run.contacts.release), run.t_end, run.contacts.release)
    return start, release, (start <= high) & (release >= low)


def draw_grazes_in_time(
    ax: Axes, run: Drawable, low: float, high: float, *, velocity: bool
) -> None:
    """Mark each graze in [low, high], at the stop or at zero velocity."""
    shown = within(run.grazes.t, low, high)
    if shown.any():
        places = stop_places(run, run.grazes.stop[shown])
        heights, t = 0.0 * places if velocity else places, run.grazes.t[shown]
        distinct = distinct_spans(t, t, heights, high - low)
        ax.plot(t[distinct], heights[distinct], **GRAZE_STYLE)


def draw_rest_points(ax: Axes, run: Drawable, low: float, high: float) -> None:
    """Mark contacts and grazes in [low, high] in the phase plane."""
    _, _, in_contact = _contacts_within(run, low, high)
    if in_contact.any():
        places = stop_places(run, np.unique(run.contacts.stop[in_contact]))
        ax.plot(places, 0.0 * places, "s", markersize=6.5, zorder=5.0, **CONTACT_STYLE)
    grazed = within(run.grazes.t, low, high)
    if grazed.any():
        places = stop_places(run, np.unique(run.grazes.stop[grazed]))
        ax.plot(places, 0.0 * places, **GRAZE_STYLE)


class Jumps(LineCollection):
    """Vertical dashed lines whose dashes fall on the same heights.

    In a phase portrait all impacts on one stop lie on one another: dashes counted from the start
    of each line would fill each other's gaps and look solid.
    """

    @allow_rasterization  # type: ignore[untyped-decorator]
    def draw(self, renderer: RendererBase) -> None:
        """Draw the lines; the offsets follow the size and the limits of the axes."""
        bottoms = [np.asarray(path.vertices)[0] for path in self.get_paths()]
        figure = figure_of(self)
        if bottoms and figure is not None:
            heights = self.get_transform().transform(np.array(bottoms))[:, 1]
            points = heights * 72.0 / figure.dpi
            offsets = np.nan_to_num(np.mod(points, DASH + GAP))
            self.set_linestyle([(float(offset), (DASH, GAP)) for offset in offsets])
        super().draw(renderer)


def draw_jumps(ax: Axes, at: Floats, before: Floats, after: Floats, **options: Any) -> Jumps:
    """Draw the jumps of the velocity from `before` to `after` at the abscissas `at`.

    Options are properties of the collection, which has one line for each impact.
    """
    low, high = np.minimum(before, after), np.maximum(before, after)
    lines = np.stack([np.column_stack([at, low]), np.column_stack([at, high])], axis=1)
    # A width of 1 keeps dashes in points: matplotlib scales them with the width.
    jumps = Jumps(list(lines), colors=BLUE, linewidths=1.0, linestyles=(0, (DASH, GAP)), **options)
    jumps.set_label("impact")
    jumps.set_capstyle("butt")
    ax.add_collection(jumps)
    ax.autoscale_view()
    return jumps
