"""Response charts: branches over the frequency with their labels, and the velocity gap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.model.structure import Structure
from percuss.model.units import Units
from percuss.orbits.bifurcations.structure_branch import AnyBranch
from percuss.orbits.responses.response import CLOSED, Response, kinds_of
from percuss.orbits.responses.velocity_gap import VelocityGap
from percuss.plotting.branch_plot import (
    MARKERS,
    between_rows,
    drawn_as_stable,
    owner_of,
    parameter_of,
    reach_of,
    stretches,
)
from percuss.plotting.direction_view import direction_name
from percuss.plotting.style import (
    BLACK,
    COLOUR_CYCLE,
    GREY,
    check_kind,
    figure_of,
    picture,
    refuse_axes,
    shared_docs,
    units_of,
)
from percuss.wording import counted

ResponseQuantity: TypeAlias = Literal["amplitude", "largest_displacement", "impact_velocity"]

WORDS = {
    "amplitude": "amplitude, half peak to peak",
    "largest_displacement": "largest displacement",
    "impact_velocity": "largest impact velocity",
}
STABLE: dict[str, Any] = {"linestyle": "-", "linewidth": 1.7}
UNSTABLE: dict[str, Any] = {"linestyle": (0, (3.5, 1.8)), "linewidth": 1.1}
FORMAL: dict[str, Any] = {"linestyle": "-", "linewidth": 0.7, "alpha": 0.28}
MARK: dict[str, Any] = {
    "linestyle": "none",
    "markersize": 3.4,
    "markerfacecolor": "white",
    "markeredgecolor": BLACK,
    "markeredgewidth": 0.7,
}
OTHER: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3.5, "color": GREY}
# Space above the highest physical orbit.
HEADROOM = 1.08
# Ratio of the ends of a wide range.
WIDE = 4.0
# Which stretches, how they look, and in which order.
Look = tuple[Flags, dict[str, Any], float]
Label = tuple[str, str, Floats, Flags]

SIZE = 8.5
# Width of a letter and height of a line, as parts of the size of the font.
LETTER, HIGH = 0.56, 1.15
# Points of a curve at which its label is tried, and distances of its middle from them [lines].
TRIED, DISTANCES = 48, (0.95, 1.5, 2.3)
DIRECTIONS = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
# Curves are taken as points at most so far apart; points farther than the second are two curves.
DENSE, TORN = 2.5, 80.0
# What it costs to cover a point of a curve, to be a line farther off, to stand at a worse place,
# and to stand at the foot of a curve and not at its top.
COVERED, FARTHER, WORSE, FOOT = 1.0, 0.4, 3.0, 2.0

# Width and height of a new figure [inch], with the legend beside it or without.
WIDE_FIGURE, FIGURE = (8.4, 4.0), (6.4, 4.0)
# Where the legend stands.
BESIDE = (1.01, 1.0)


@shared_docs
def plot_response(
    response: Response,
    quantity: ResponseQuantity = "amplitude",
    ax: Axes | None = None,
    *,
    log_x: bool | None = None,
    log_y: bool = False,
    formal: bool = True,
    legend: bool = True,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw a response chart: stable orbits solid, unstable ones dashed, formal ones faint.

    Each kind of orbit is labelled once, (impacts, forcing periods); the colour shows the periods,
    and grey no impacts.
    Special points of physical orbits are marked, and attractors of other kinds, as with sticking
    or without a period, are dots.

    Parameters
    ----------
    response
        What `percuss.response_curve` has returned.
    quantity
        "amplitude", half the distance between the extremes; "largest_displacement", the largest
        abs(x); or "impact_velocity", the largest one into a stop.
    log_x, log_y
        Whether the axes are logarithmic; default: that of the parameter is where its range is
        wide, with ends of a ratio above 4.
    formal
        Whether to draw orbits that pass through a stop.
    legend
        Whether to explain lines, colours and marks.

    Raises
    ------
    ParameterError
        If there is no such quantity, or no branch.
    """
    refuse_axes("quantity", quantity)
    if quantity not in WORDS:
        raise ParameterError("quantity", quantity, f"none of {', '.join(WORDS)}")
    check_kind("response", response, Response)
    if not response.branches:
        raise ParameterError("response", response, "it has no branches")
    units = units_of(units, owner_of(response.branches[0]))
    unit = units.velocity if quantity == "impact_velocity" else units.displacement
    columns: tuple[Floats, ...] = getattr(response, quantity)
    with picture(ax, WIDE_FIGURE if legend else FIGURE, labels=(xlabel, ylabel)) as ax:
        for branch, values in zip(response.branches, columns, strict=True):
            _draw(ax, branch, values, formal=formal)
        _mark(ax, response, columns)
        _dots(ax, response, quantity)
        ax.set_xlabel(parameter_of(response.branches[0], units))
        ax.set_ylabel(f"{_words(response, quantity)} ({unit})")
        if log_x or (log_x is None and 0.0 < WIDE * response.low < response.high):
            _make_logarithmic(ax)
        _set_limits(ax, response, columns, log=log_y)
        if legend:
            _explain(ax, response, formal=formal)
        # Beside the legend, which takes its part of the width.
        _label(ax, response, columns)
    return ax


def _words(response: Response, quantity: ResponseQuantity) -> str:
    """Return the name of a quantity, with the displacement of a structure that it is of."""
    if response.on is None or quantity == "impact_velocity":
        return WORDS[quantity]
    structure = owner_of(response.branches[0])
    assert isinstance(structure, Structure)
    return f"{WORDS[quantity]}, ${direction_name(structure, response.on)}$"


def _colour(branch: AnyBranch) -> str:
    n_periods, n_impacts = kinds_of(branch).max(axis=0).tolist()
    return _colour_of_period(max(n_periods, 1)) if n_impacts else GREY


def _colour_of_period(n_periods: int) -> str:
    """Return the colour of orbits that last so many forcing periods."""
    return COLOUR_CYCLE[(n_periods - 1) % len(COLOUR_CYCLE)]


def _draw(ax: Axes, branch: AnyBranch, values: Floats, *, formal: bool) -> None:
    """Draw a branch, each stretch between two rows as its orbits are."""
    physical = between_rows(branch.admissible, branch)
    stable = between_rows(drawn_as_stable(branch), branch)
    flies = kinds_of(branch)[:, 1] == 0
    free = between_rows(flies, branch)
    x_all, y_all = branch.values, values
    if branch.end_reason == CLOSED:
        # The first row comes again after the last one.
        x_all, y_all = np.append(x_all, x_all[0]), np.append(y_all, y_all[0])
        physical = np.append(physical, branch.admissible[0] & branch.admissible[-1])
        stable = np.append(stable, stable[-1])
        free = np.append(free, flies[0] & flies[-1])
    looks = _looks(physical, stable, formal=formal)
    for rows, colour in ((~free, _colour(branch)), (free, GREY)):
        own = [(which & rows, look, order) for which, look, order in looks]
        _draw_stretches(ax, x_all, y_all, own, colour)


def _looks(physical: Flags, stable: Flags, *, formal: bool) -> list[Look]:
    """Return which stretches look as those of stable, unstable and formal orbits."""
    looks: list[Look] = [
        (physical & stable, STABLE, 2.0),
        (physical & ~stable, UNSTABLE, 1.8),
    ]
    return [*looks, (~physical, FORMAL, 1.0)] if formal else looks


def _draw_stretches(ax: Axes, x: Floats, y: Floats, looks: Sequence[Look], colour: str) -> None:
    """Draw the stretches of one look as one line, broken by NaN where it leaves some out."""
    points = np.column_stack([x, y])
    gap = np.full((1, 2), np.nan)
    for which, look, order in looks:
        parts = [part for rows, shown in stretches(which) if shown for part in (points[rows], gap)]
        if parts:
            ax.plot(*np.concatenate(parts).T, color=colour, zorder=order, **look)


def _mark(ax: Axes, response: Response, columns: tuple[Floats, ...]) -> None:
    """Mark the special points of physical orbits."""
    for branch, values in zip(response.branches, columns, strict=True):
        for point in branch.special_points:
            rows = slice(max(point.row - 1, 0), point.row + 2)
            if branch.admissible[rows].any() and np.isfinite(values[point.row]):
                ax.plot([point.value], [values[point.row]], zorder=3.0, **_mark_of(point.kind))


def _dots(ax: Axes, response: Response, quantity: ResponseQuantity) -> None:
    """Draw attractors that are on no branch as dots."""
    others = [attractor for attractor in response.attractors if attractor.branch is None]
    values = {
        "amplitude": [attractor.extremes.amplitude for attractor in others],
        "largest_displacement": [attractor.extremes.largest for attractor in others],
        "impact_velocity": [attractor.impact_speed for attractor in others],
    }[quantity]
    if others:
        ax.plot([attractor.value for attractor in others], values, zorder=1.5, **OTHER)


def _make_logarithmic(ax: Axes) -> None:
    """Make the axis of the parameter logarithmic, with plain numbers on it."""
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _set_limits(ax: Axes, response: Response, columns: tuple[Floats, ...], *, log: bool) -> None:
    """Show the whole range of the parameter, and all physical orbits."""
    pairs = zip(response.branches, columns, strict=True)
    physical = np.concatenate([values[branch.admissible] for branch, values in pairs])
    physical = physical[np.isfinite(physical)]
    ax.set_xlim(response.low, response.high)
    if log:
        ax.set_yscale("log")
        physical = physical[physical > 0.0]
    low, high = physical.min(initial=math.inf), physical.max(initial=0.0)
    if not log:
        high = min(high, reach_of(response.branches, columns))
    # Where all is at rest the axis is matplotlib's.
    if high > 0.0:
        ax.set_ylim(low / HEADROOM**3 if log else 0.0, high * (HEADROOM**3 if log else HEADROOM))


def _label(ax: Axes, response: Response, columns: tuple[Floats, ...]) -> None:
    curves, labels = [], []
    for family in response.families:
        x, y, best = [], [], []
        for number in family.branches:
            branch, values = response.branches[number], columns[number]
            kind = family.n_periods, family.n_impacts
            shown = branch.admissible & np.isfinite(values) & (kinds_of(branch) == kind).all(axis=1)
            x.append(branch.values[shown])
            y.append(values[shown])
            best.append(branch.is_stable[shown])
        points = np.column_stack([np.concatenate(x), np.concatenate(y)])
        curves.append(points)
        if len(points):
            text = f"({family.n_impacts}, {family.n_periods})"
            of_impacts = _colour(response.branches[family.branches[0]])
            colour = of_impacts if family.n_impacts else GREY
            labels.append((text, colour, points, np.concatenate(best)))
    place_labels(ax, labels, curves)


def _explain(ax: Axes, response: Response, *, formal: bool) -> None:
    """Draw the legend: how lines and marks look, and what colours mean."""
    looks = [("stable", STABLE), ("unstable", UNSTABLE)]
    if formal and not all(branch.admissible.all() for branch in response.branches):
        looks.append(("formal: passes through a stop", FORMAL))
    handles = [Line2D([], [], color=BLACK, label=text, **look) for text, look in looks]
    families = [family for family in response.families if family.ranges]
    periods = sorted({family.n_periods for family in families if family.n_impacts})
    for n in periods:
        colour = _colour_of_period(n)
        text = counted(n, "forcing period")
        handles.append(Line2D([], [], color=colour, linewidth=1.7, label=text))
    if any(family.n_impacts == 0 for family in families):
        handles.append(Line2D([], [], color=GREY, linewidth=1.7, label="without impacts"))
    kinds = [line.get_marker() for line in ax.lines]
    for kind, marker in MARKERS.items():
        if marker in kinds:
            handles.append(Line2D([], [], label=kind.replace("_", " "), **_mark_of(kind)))
    if any(attractor.branch is None for attractor in response.attractors):
        handles.append(Line2D([], [], label="other attractors", **OTHER))
    _legend_beside(ax, handles)


def _legend_beside(ax: Axes, handles: list[Line2D]) -> None:
    """Draw the legend beside the axes: the families fill the plane, and it hides none of them."""
    ax.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=BESIDE,
        borderaxespad=0.0,
        fontsize=8.5,
        handlelength=2.4,
        labelspacing=0.3,
    )


@shared_docs
def plot_velocity_gap(
    curves: VelocityGap | Sequence[VelocityGap],
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw impact velocity against gap: stable orbits solid, unstable dashed, formal faint.

    Parameters
    ----------
    curves
        One or several that `percuss.velocity_gap_curve` has returned.

    Returns
    -------
    Axes
        The axes; folds and grazes are marked, each curve is labelled (1, forcing periods).

    Raises
    ------
    ParameterError
        If there is no curve.
    """
    several: list[VelocityGap] = (
        list(curves) if isinstance(curves, list | tuple) else [cast("VelocityGap", curves)]
    )
    if not several:
        raise ParameterError("curves", curves, "no curve to draw")
    for curve in several:
        check_kind("curves", curve, VelocityGap)
    units = units_of(units)
    with picture(ax, WIDE_FIGURE, labels=(xlabel, ylabel)) as ax:
        for curve in several:
            _draw_gap(ax, curve)
        ax.axvline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        ax.set_ylim(bottom=0.0)
        ax.set_xlabel(f"gap, from the equilibrium to the wall ({units.displacement})")
        ax.set_ylabel(f"impact velocity ({units.velocity})")
        _explain_gap(ax)
    return ax


def _draw_gap(ax: Axes, curve: VelocityGap) -> None:
    colour = _colour_of_period(curve.n_periods)
    # The grazes at the ends are no orbits: there the neighbouring row decides.
    physical = np.concatenate([curve.admissible[1:2], curve.admissible[2:-1], [False]])
    physical[-1] = curve.admissible[-2]
    stable = curve.is_stable[1:].copy()
    stable[-1] = curve.is_stable[-2]
    looks = _looks(physical, stable, formal=True)
    _draw_stretches(ax, curve.gap, curve.velocity, looks, colour)
    top = int(np.argmax(curve.velocity))
    ax.plot([curve.fold], [curve.fold_velocity], zorder=3.0, **_mark_of("fold"))
    ends = [-curve.graze, curve.graze]
    ax.plot(ends, [0.0, 0.0], zorder=3.0, clip_on=False, **_mark_of("grazing"))
    ax.annotate(
        f"(1, {curve.n_periods})",
        (float(curve.gap[top]), float(curve.velocity[top])),
        xytext=(0.0, 6.0),
        textcoords="offset points",
        ha="center",
        fontsize=9.0,
        color=colour,
    )


def _mark_of(kind: str) -> dict[str, Any]:
    """Return how a special point of a kind is marked."""
    return MARK | {"marker": MARKERS[kind]}


def _explain_gap(ax: Axes) -> None:
    looks = (("stable", STABLE), ("unstable", UNSTABLE), ("passes through the wall", FORMAL))
    handles = [Line2D([], [], color=BLACK, label=text, **look) for text, look in looks]
    for kind, text in (("fold", "fold"), ("grazing", "impact without velocity")):
        handles.append(Line2D([], [], label=text, **_mark_of(kind)))
    _legend_beside(ax, handles)


def place_labels(ax: Axes, labels: list[Label], curves: list[Floats]) -> None:
    """Write a label beside each curve, where it covers least; the limits of the axes are final.

    A label has a text, a colour, an (n, 2) array of the points of its curve, and which of them are
    better. The curves, (n, 2) arrays, are all that is not to be covered.
    """
    # In points of 1/72 inch, as offsets of texts are.
    figure = figure_of(ax)
    assert figure is not None
    # It gives the axes the place that they will have.
    figure.draw_without_rendering()
    scale = 72.0 / figure.dpi
    box = ax.get_window_extent()
    frame = scale * np.array([box.x0, box.y0, box.x1, box.y1])
    drawn = [scale * _dense(ax.transData.transform(curve)) for curve in curves if len(curve)]
    everything = np.concatenate(drawn) if drawn else np.empty((0, 2))
    taken: list[Floats] = []
    # Short curves have the least choice.
    for text, colour, points, better in sorted(labels, key=lambda label: len(label[2])):
        place = _best(scale, ax, text, points, better, everything, frame, taken)
        if place is None:
            continue
        anchor, offset, space = place
        taken.append(space)
        ax.annotate(text, anchor, xytext=offset, textcoords="offset points", ha="center",
                    va="center", fontsize=SIZE, color=colour, zorder=4.0,
                    annotation_clip=True)  # fmt: skip


def _dense(points: Floats) -> Floats:
    steps = np.diff(points, axis=0)
    far = np.abs(steps).max(axis=1)
    # What is far apart are two curves.
    near = far < TORN
    each = np.maximum(np.ceil(far[near] / DENSE).astype(int), 1)
    rows = np.repeat(np.flatnonzero(near), each)
    parts = np.concatenate([[], *(np.arange(n) / n for n in each)])[:, np.newaxis]
    return np.concatenate([points[rows] + parts * steps[rows], points])


def _best(
    scale: float,
    ax: Axes,
    text: str,
    points: Floats,
    better: Flags,
    everything: Floats,
    frame: Floats,
    taken: list[Floats],
) -> tuple[tuple[float, float], tuple[float, float], Floats] | None:
    """Return anchor, offset and space of the place that costs least, None if there is none."""
    half = 0.5 * SIZE * np.array([LETTER * len(text), HIGH])
    rows = np.unique(np.linspace(0, len(points) - 1, TRIED).round().astype(int))
    places = scale * ax.transData.transform(points[rows])
    top, height = places[:, 1].max(), float(np.ptp(places[:, 1])) or 1.0
    best, least = None, np.inf
    for row, place in zip(rows, places, strict=True):
        for distance in DISTANCES:
            for direction in DIRECTIONS:
                offset = np.array(direction) * (half + (distance - 0.5) * 0.5 * SIZE)
                middle = place + offset
                space = np.concatenate([middle - half, middle + half])
                if (space[:2] < frame[:2]).any() or (space[2:] > frame[2:]).any():
                    continue
                if any(
                    (space[:2] < box[2:]).all() and (box[:2] < space[2:]).all() for box in taken
                ):
                    continue
                inside = (np.abs(everything - middle) < half).all(axis=1).sum()
                cost = COVERED * inside + FARTHER * distance
                cost += WORSE * (not better[row]) + FOOT * (top - place[1]) / height
                if cost < least:
                    least = cost
                    anchor = float(points[row, 0]), float(points[row, 1])
                    best = anchor, (float(offset[0]), float(offset[1])), space
    return best
