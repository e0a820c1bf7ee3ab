"""Response charts: amplitude or impact velocity of all families over one parameter."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from percuss.errors import ParameterError
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.responses.response import CLOSED, Response, kinds_of
from percuss.plotting.family_labels import place_labels
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    Units,
    axes_for,
    fix_ticks,
    style,
    units_of,
)

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Quantity: TypeAlias = Literal["amplitude", "largest_displacement", "impact_velocity"]

WORDS = {
    "amplitude": "amplitude, half peak to peak",
    "largest_displacement": "largest displacement",
    "impact_velocity": "largest impact velocity",
}
# Of orbits that last 1, 2, ... forcing periods; of those without impacts it is grey.
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY_BLUE)
STABLE: dict[str, Any] = {"linestyle": "-", "linewidth": 1.7}
UNSTABLE: dict[str, Any] = {"linestyle": (0, (3.5, 1.8)), "linewidth": 1.1}
FORMAL: dict[str, Any] = {"linestyle": "-", "linewidth": 0.7, "alpha": 0.28}
MARKERS = {
    "fold": "o",
    "period_doubling": "s",
    "symmetry_breaking": "D",
    "branch_point": "X",
    "grazing": "v",
    "strong_resonance": "P",
}
MARK: dict[str, Any] = {
    "linestyle": "none",
    "markersize": 3.4,
    "markerfacecolor": "white",
    "markeredgecolor": BLACK,
    "markeredgewidth": 0.7,
}
OTHER: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3.5, "color": GREY}
# Room above the highest physical orbit.
ROOM = 1.08
# Ratio of the ends of a wide range.
WIDE = 4.0


def plot_response(
    response: Response,
    quantity: Quantity = "amplitude",
    ax: Axes | None = None,
    *,
    log_x: bool | None = None,
    log_y: bool = False,
    formal: bool = True,
    legend: bool = True,
    units: Units | None = None,
) -> Axes:
    """Draw a response chart: stable orbits solid, unstable ones dashed, formal ones faint.

    Each kind of orbit is labelled once, (impacts, forcing periods); the colour tells the periods.
    Special points of physical orbits are marked, and attractors of other kinds, as with sticking
    or without a period, are dots.

    Parameters
    ----------
    response
        What `percuss.response_curve` has returned.
    quantity
        "amplitude", half the distance between the extremes; "largest_displacement", the largest
        abs(x); or "impact_velocity", the largest one into a stop.
    ax
        Axes to draw on; default: those of a new figure.
    log_x, log_y
        Whether the axes are logarithmic; default: that of the parameter is where its range is
        wide, with ends of a ratio above 4.
    formal
        Whether to draw orbits that pass through a stop.
    legend
        Whether to explain lines, colours and marks.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes.

    Raises
    ------
    ParameterError
        If there is no such quantity, or no branch.
    """
    if quantity not in WORDS:
        raise ParameterError("quantity", quantity, f"none of {', '.join(WORDS)}")
    if not response.branches:
        raise ParameterError("response", response, "it has no branches")
    units = units_of(units)
    unit = units.velocity if quantity == "impact_velocity" else units.displacement
    columns: tuple[Floats, ...] = getattr(response, quantity)
    with style():
        ax = axes_for(ax)
        for branch, values in zip(response.branches, columns, strict=True):
            _draw(ax, branch, values, formal=formal)
        _mark(ax, response, columns)
        _dots(ax, response, quantity)
        ax.set_xlabel(response.path)
        ax.set_ylabel(f"{WORDS[quantity]} ({unit})")
        if log_x or (log_x is None and 0.0 < WIDE * response.low < response.high):
            _make_logarithmic(ax)
        _set_limits(ax, response, columns, log=log_y)
        _label(ax, response, columns)
        if legend:
            _explain(ax, response, formal=formal)
        fix_ticks(ax)
    return ax


def _colour(branch: Branch) -> str:
    n_periods, n_impacts = kinds_of(branch).max(axis=0).tolist()
    return COLOURS[(max(n_periods, 1) - 1) % len(COLOURS)] if n_impacts else GREY


def _draw(ax: Axes, branch: Branch, values: Floats, *, formal: bool) -> None:
    """Draw a branch, each stretch between two rows as its orbits are."""
    physical = _between_rows(branch, branch.admissible)
    stable = _between_rows(branch, np.isin(branch.stability, ["asymptotic", "elliptic"]))
    x_all, y_all = branch.values, values
    if branch.end_reason == CLOSED:
        # The first row comes again after the last one.
        x_all, y_all = np.append(x_all, x_all[0]), np.append(y_all, y_all[0])
        physical = np.append(physical, branch.admissible[0] & branch.admissible[-1])
        stable = np.append(stable, stable[-1])
    looks = [(physical & stable, STABLE, 2.0), (physical & ~stable, UNSTABLE, 1.8)]
    if formal:
        looks.append((~physical, FORMAL, 1.0))
    for which, look, order in looks:
        if which.any():
            x, y = _stretches(x_all, y_all, which)
            ax.plot(x, y, color=_colour(branch), zorder=order, **look)


def _between_rows(branch: Branch, flags: Flags) -> Flags:
    """Return what each stretch between two rows is: at a special point the row beside it tells."""
    special = np.zeros(len(branch), dtype=np.bool_)
    special[[point.row for point in branch.special_points]] = True
    left, right = flags[:-1], flags[1:]
    found = np.where(special[:-1] & ~special[1:], right, left & right)
    found = np.where(~special[:-1] & special[1:], left, found)
    return np.asarray(np.where(special[:-1] & special[1:], left | right, found))


def _stretches(x: Floats, y: Floats, which: Flags) -> tuple[Floats, Floats]:
    """Return the stretches as one line, broken by NaN where it leaves some out."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]]).astype(np.int8)))
    parts = [slice(i, j + 1) for i, j in zip(edges[::2], edges[1::2], strict=True)]
    gap = np.array([np.nan])
    return (
        np.concatenate([piece for part in parts for piece in (x[part], gap)]),
        np.concatenate([piece for part in parts for piece in (y[part], gap)]),
    )


def _mark(ax: Axes, response: Response, columns: tuple[Floats, ...]) -> None:
    """Mark the special points of physical orbits."""
    for branch, values in zip(response.branches, columns, strict=True):
        for point in branch.special_points:
            rows = slice(max(point.row - 1, 0), point.row + 2)
            if branch.admissible[rows].any() and np.isfinite(values[point.row]):
                look = MARK | {"marker": MARKERS.get(point.kind, "o")}
                ax.plot([point.value], [values[point.row]], zorder=3.0, **look)


def _dots(ax: Axes, response: Response, quantity: Quantity) -> None:
    """Draw attractors that are on no branch as dots."""
    others = [it for it in response.attractors if it.branch is None]
    values = {
        "amplitude": [it.extremes.amplitude for it in others],
        "largest_displacement": [it.extremes.largest for it in others],
        "impact_velocity": [it.impact_speed for it in others],
    }[quantity]
    if others:
        ax.plot([it.value for it in others], values, zorder=1.5, **OTHER)


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
    if physical.size:
        low, high = float(physical.min()), float(physical.max())
        ax.set_ylim(low / ROOM**3 if log else 0.0, high * (ROOM**3 if log else ROOM))


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
            colour = _colour(response.branches[family.branches[0]])
            labels.append((text, colour, points, np.concatenate(best)))
    place_labels(ax, labels, curves)


def _explain(ax: Axes, response: Response, *, formal: bool) -> None:
    """Draw the legend: how lines and marks look, and what colours mean."""
    looks = [("stable", STABLE), ("unstable", UNSTABLE)]
    if formal and not all(branch.admissible.all() for branch in response.branches):
        looks.append(("formal: passes through a stop", FORMAL))
    handles = [Line2D([], [], color=BLACK, label=text, **look) for text, look in looks]
    periods = sorted({it.n_periods for it in response.families if it.n_impacts and it.ranges})
    for n in periods:
        colour = COLOURS[(n - 1) % len(COLOURS)]
        text = "1 forcing period" if n == 1 else f"{n} forcing periods"
        handles.append(Line2D([], [], color=colour, linewidth=1.7, label=text))
    if any(it.n_impacts == 0 and it.ranges for it in response.families):
        handles.append(Line2D([], [], color=GREY, linewidth=1.7, label="without impacts"))
    kinds = [line.get_marker() for line in ax.lines]
    for kind, marker in MARKERS.items():
        if marker in kinds:
            look = MARK | {"marker": marker}
            handles.append(Line2D([], [], label=kind.replace("_", " "), **look))
    if any(it.branch is None for it in response.attractors):
        handles.append(Line2D([], [], label="other attractors", **OTHER))
    ax.legend(handles=handles, loc="best", fontsize=8.5, handlelength=2.4, labelspacing=0.3)
