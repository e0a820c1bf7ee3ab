"""A periodic orbit in the phase plane, and Floquet multipliers in the complex plane."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from percuss.arrays import Complexes, Flags, Floats
from percuss.errors import ParameterError
from percuss.model.exact import as_float
from percuss.model.oscillator import On, Wall
from percuss.model.units import Units
from percuss.orbits.bifurcations.structure_branch import AnyBranch
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.plotting.direction_view import Drawable, names_of, view_of
from percuss.plotting.labels import parameter_label
from percuss.plotting.marks import draw_jumps, draw_rest_points, draw_stops, draw_unit_circle
from percuss.plotting.samples import SampledMotion, sample_curve, window_of
from percuss.plotting.style import (
    BLUE,
    GREY,
    VERMILION,
    check_kind,
    label_phase_plane,
    picture,
    shared_docs,
    units_of,
)
from percuss.wording import counts_in_words

# Far beyond the circle a multiplier would shrink it: it is shown at the edge instead.
MOST = 3.0
COLOURS = "viridis"
# A formal orbit passes a wall by more than this part of its displacements.
THROUGH = 1e-9
# Of a new figure: the circle is round [inch].
SIZE = (5.4, 4.4)


@shared_docs
def plot_orbit(
    orbit: PeriodicOrbit | StructureOrbit,
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw a periodic orbit: velocity over displacement, with its stops.

    Impacts are dashed jumps. What a formal orbit does beyond a wall, or beyond the edge of a
    soft stop that it does not notice, is drawn faint and dashed.

    Parameters
    ----------
    orbit
        The orbit.

    Returns
    -------
    Axes
        The axes; the title gives impacts, periods, stability. Those of a new figure have a
        legend.

    Raises
    ------
    ParameterError
        If it is no orbit, or there is no such coordinate.
    """
    run: Drawable
    if isinstance(orbit, StructureOrbit):
        run = view_of(orbit, on)
    else:
        check_kind("orbit", orbit, PeriodicOrbit)
        run = view_of(orbit.trajectory(), on)
    units = units_of(units, run.oscillator)
    low, high = window_of(run, None)
    curve = sample_curve(run, (low, high))
    with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
        t, x, v = _broken_at_jumps(curve)
        beyond = _beyond(orbit, run, t, x)
        ax.plot(np.where(beyond, np.nan, x), v, color=BLUE, linewidth=1.5, label="orbit")
        if beyond.any():
            near = beyond | np.roll(beyond, 1) | np.roll(beyond, -1)
            ax.plot(
                np.where(near, x, np.nan), v, color=BLUE, linewidth=1.2, alpha=0.45,
                linestyle=(0, (4, 2)), label="passes through a stop",
            )  # fmt: skip
        impacts = run.impacts
        if len(impacts):
            # Of a structure an impact elsewhere is a jump here too.
            places, _ = run(impacts.t)
            draw_jumps(ax, places, impacts.v_before, impacts.v_after)
        draw_stops(ax, run, curve.x, "x")
        draw_rest_points(ax, run, low, high)
        label_phase_plane(ax, units, names_of(run))
        ax.set_title(_title(orbit, units))
    return ax


def _title(orbit: PeriodicOrbit | StructureOrbit, units: Units) -> str:
    counts = counts_in_words(orbit.n_impacts, orbit.n_periods)
    unit = f" {units.duration}" if units.time else ""
    formal = "" if orbit.admissible else ", not physical"
    return f"{counts}, T = {orbit.period:.6g}{unit}, {orbit.stability}{formal}"


def _broken_at_jumps(curve: SampledMotion) -> tuple[Floats, Floats, Floats]:
    """Return t, x and v with a gap after each sample that a jump follows."""
    after = np.flatnonzero(curve.jumps[:-1]) + 1
    t, x, v = (np.insert(values, after, np.nan) for values in (curve.t, curve.x, curve.v))
    return t, x, v


def _beyond(orbit: PeriodicOrbit | StructureOrbit, run: Drawable, t: Floats, x: Floats) -> Flags:
    """Return which samples of a formal orbit lie beyond a stop that it passes through."""
    beyond = np.zeros(len(x), dtype=np.bool_)
    if orbit.admissible:
        return beyond
    if isinstance(orbit, StructureOrbit):
        # It notices soft stops, and passes through walls alone.
        for stop in run.oscillator.stops:
            if isinstance(stop, Wall):
                depth = (x - as_float(stop.at)) * (-1.0 if stop.side == "below" else 1.0)
                beyond |= depth > THROUGH * np.nanmax(np.abs(x))
        return beyond
    passages = orbit.passages
    for instant, i in zip(passages.t, passages.stop, strict=True):
        stop = orbit.oscillator.stops[int(i)]
        place = as_float(stop.at)
        outside = x < place if stop.side == "below" else x > place
        # The samples without a gap around the instant.
        edges = np.flatnonzero(np.diff(outside.astype(np.int8), prepend=0, append=0))
        for first, last in edges.reshape(-1, 2):
            if np.nanmin(t[first:last]) <= instant <= np.nanmax(t[max(first - 1, 0) : last + 1]):
                beyond[first:last] = True
    return beyond


@shared_docs
def plot_multipliers(
    what: PeriodicOrbit | StructureOrbit | AnyBranch,
    ax: Axes | None = None,
    *,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw the multipliers of an orbit, or of a branch along its parameter, and the unit circle.

    Those with a real or imaginary part beyond 3 stand as triangles at the edge.

    Parameters
    ----------
    what
        A periodic orbit or a branch of orbits, also of a structure; of a branch the points are
        coloured by the parameter.

    Raises
    ------
    ParameterError
        If it is neither.
    """
    if not isinstance(what, PeriodicOrbit | StructureOrbit | AnyBranch):
        raise ParameterError("what", what, "neither an orbit nor a branch")
    values = what.multipliers if isinstance(what, AnyBranch) else what.multipliers[None]
    far = max(1.0, float(np.abs(np.stack([values.real, values.imag])).max(initial=0.0)))
    edge = 1.12 * min(far, MOST)
    with picture(ax, SIZE, labels=(xlabel, ylabel)) as ax:
        draw_unit_circle(ax, edge)
        if isinstance(what, AnyBranch):
            _draw_branch(ax, what, edge)
        else:
            _draw_orbit(ax, values[0], edge)
        ax.set_xlabel("real part of the multiplier")
        ax.set_ylabel("imaginary part of the multiplier")
    return ax


def _draw_orbit(ax: Axes, values: Complexes, edge: float) -> None:
    inside = np.abs(values) <= 1.0
    for chosen, colour, label in (
        (inside, BLUE, "in or on the circle"),
        (~inside, VERMILION, "outside"),
    ):
        if chosen.any():
            x, y, beyond = _placed(values[chosen], edge)
            ax.plot(x, y, "o", color=colour, markersize=6.0, label=label, zorder=3.0)
            _point_out(ax, values[chosen][beyond], x[beyond], y[beyond], colour)
    _explain(ax)


def _draw_branch(ax: Axes, branch: AnyBranch, edge: float) -> None:
    first = branch.orbits[0]
    owner = first.structure if isinstance(first, StructureOrbit) else first.oscillator
    units = units_of(None, owner)
    low, high = float(branch.values.min()), float(branch.values.max())
    lines = None
    for column in _followed(branch.multipliers).T:
        x, y, _ = _placed(column, edge)
        points = np.column_stack([x, y])
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        # Through infinity, at a graze, it comes back from the other side.
        joined = np.hypot(*(points[1:] - points[:-1]).T) < edge
        # Where a pair becomes real it meets on the axis, between two orbits.
        joined &= (y[1:] == 0.0) == (y[:-1] == 0.0)
        lines = LineCollection(list(pieces[joined]), cmap=COLOURS, linewidths=2.2, zorder=2.5)
        lines.set_array(0.5 * (branch.values[:-1] + branch.values[1:])[joined])
        lines.set_clim(low, high)
        ax.add_collection(lines)
        # The orbits themselves: between them the line is a chord.
        ax.scatter(x, y, s=7.0, c=branch.values, cmap=COLOURS, vmin=low, vmax=high, zorder=2.6)
    for row, marker, label in ((0, "o", "first orbit"), (-1, "s", "last orbit")):
        x, y, _ = _placed(branch.multipliers[row], edge)
        ax.plot(
            x, y, marker, markersize=5.5, markerfacecolor="white", markeredgecolor=GREY,
            label=label, zorder=3.0,
        )  # fmt: skip
    if lines is not None:
        ax.figure.colorbar(
            lines, ax=ax, label=parameter_label(branch.orbits[0], branch.path, units)
        )
    _explain(ax)


def _explain(ax: Axes) -> None:
    """Put the legend above the axes: inside it would lie on the circle."""
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _followed(values: Complexes) -> Complexes:
    """Return multipliers, exchanged where needed, so that each column is continuous.

    Of more than two the nearest ones of two rows belong together first.
    """
    columns = values.copy()
    n = columns.shape[1]
    for row in range(1, len(columns)):
        straight = np.abs(columns[row] - columns[row - 1]).sum()
        if n == 2:
            crossed = np.abs(columns[row, ::-1] - columns[row - 1]).sum()
            if crossed < straight:
                columns[row] = columns[row, ::-1].copy()
            continue
        distances = np.abs(columns[row][None] - columns[row - 1][:, None])
        order = np.empty(n, dtype=np.int64)
        for _ in range(n):
            old, new = np.unravel_index(int(np.argmin(distances)), distances.shape)
            order[old] = new
            distances[old] = distances[:, new] = np.inf
        columns[row] = columns[row][order]
    return columns


def _placed(values: Complexes, edge: float) -> tuple[Floats, Floats, Flags]:
    """Return where values are drawn, and which of them lie beyond the picture."""
    inner = 0.97 * edge
    beyond = np.maximum(np.abs(values.real), np.abs(values.imag)) > edge
    limit = np.where(beyond, inner, math.inf)
    return (
        np.clip(values.real, -limit, limit),
        np.clip(values.imag, -limit, limit),
        np.asarray(beyond),
    )


def _point_out(ax: Axes, values: Complexes, x: Floats, y: Floats, colour: str) -> None:
    """Mark values beyond the picture with a triangle that points to them, and with the value."""
    for value, place, height in zip(values, x, y, strict=True):
        marker = ">" if value.real > 0.0 else "<"
        ax.plot([place], [height], marker, color=colour, markersize=8.0, zorder=3.0)
        ax.annotate(
            f"{value.real:.4g}",
            (place, height),
            xytext=(0.0, 9.0),
            textcoords="offset points",
            ha="right" if value.real > 0.0 else "left",
            fontsize=9.0,
        )
