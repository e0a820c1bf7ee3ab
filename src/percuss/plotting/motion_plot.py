"""Pictures of a run: over time, in the phase plane, at its impacts, all in one; its spectrum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.oscillator import On, Oscillator
from percuss.model.units import Units
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.entries import entry_rows
from percuss.motion.spectrum import spectrum
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.plotting.cells import check_table
from percuss.plotting.direction_view import DirectionView, Drawable, names_of, view_of
from percuss.plotting.marks import (
    GRAZE_STYLE,
    draw_contacts_in_time,
    draw_grazes_in_time,
    draw_jumps,
    draw_rest_points,
    draw_stops,
)
from percuss.plotting.samples import (
    DRAWN_POINTS,
    MOST_JUMPS,
    SampledMotion,
    distinct_jumps,
    reduce_to_columns,
    reduce_to_pixels,
    sample_in_full,
    separated,
    topmost,
    window_of,
    within,
)
from percuss.plotting.style import (
    BLUE,
    GREY,
    ORANGE,
    HasUnits,
    draw_legend,
    given_figure,
    label_phase_plane,
    picture,
    shared_docs,
    style,
    title_figure,
    units_of,
)

if TYPE_CHECKING:
    from xarray import Dataset

DrawnRun: TypeAlias = Trajectory | StructureTrajectory | PeriodicOrbit | StructureOrbit

# Width of a curve [point], and the number of events above which it is drawn thinner.
WIDTH = 1.3
DISTINCT = 60
# Hollow, unlike the dots of impact velocities beside it.
START_STYLE: dict[str, Any] = {
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": "white",
    "markeredgecolor": BLUE,
    "markeredgewidth": 1.4,
    "linestyle": "none",
    "label": "start",
    "zorder": 3.0,
}

# One for each stop, in their order, so that they are distinct; entries have open ones.
IMPACT_MARKERS = ("o", "^", "s", "v", "P", "X")
ENTRY_MARKERS = ("x", "+", "1", "2", "3", "4")
# More impacts than this are a line without markers.
MOST_MARKERS = 400
# Lines further below the highest than the first are rounding, and not drawn; a curve, which has
# zeros between its side lobes, is cut at the second.
ROUNDING, DEPTH = 1e-14, 1e-10
# Of a new figure [inch].
SIZE = (8.0, 9.0)


@shared_docs
def plot_displacement(
    run: DrawnRun,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw the displacement over time, with the stops, the contacts and the grazes.

    Parameters
    ----------
    run
        The run.

    Returns
    -------
    Axes
        The axes; those of a new figure have a legend.
    """
    view = view_of(run, on)
    units = units_of(units, view.oscillator)
    low, high = window_of(view, window)
    curve = sample_in_full(view, (low, high))
    with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
        t, x, _ = reduce_to_columns(curve.t, curve.x, np.zeros_like(curve.jumps))
        ax.plot(t, x, color=BLUE, linewidth=WIDTH * _thinness(view, low, high))
        draw_stops(ax, view, curve.x, "y")
        _finish_over_time(ax, view, (low, high), units, velocity=False)
    return ax


@shared_docs
def plot_velocity(
    run: DrawnRun,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw the velocity over time; an impact is a vertical dashed jump.

    Parameters
    ----------
    run
        The run.

    Returns
    -------
    Axes
        The axes; those of a new figure have a legend. With more than 2,000 impacts the jumps are
        part of the solid line.
    """
    view = view_of(run, on)
    units = units_of(units, view.oscillator)
    low, high = window_of(view, window)
    curve = sample_in_full(view, (low, high))
    shown = within(view.impacts.t, low, high)
    is_dashed = 0 < shown.sum() <= MOST_JUMPS
    with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
        t, v, jumps = reduce_to_columns(curve.t, curve.v, curve.jumps & is_dashed)
        thinness = _thinness(view, low, high)
        ax.plot(separated(t, jumps), separated(v, jumps), color=BLUE, linewidth=WIDTH * thinness)
        if is_dashed:
            impacts = view.impacts
            before, after = impacts.v_before[shown], impacts.v_after[shown]
            # Not thinner: matplotlib shortens the dashes with the width.
            draw_jumps(ax, impacts.t[shown], before, after, alpha=thinness**2)
        _finish_over_time(ax, view, (low, high), units, velocity=True)
    return ax


def _thinness(run: Drawable, low: float, high: float) -> float:
    """Return how thin the lines are drawn, 1 to 0.4, so that many stay apart."""
    n = within(run.impacts.t, low, high).sum() + within(run.crossings.t, low, high).sum()
    if n > MOST_JUMPS:
        # They fill an area.
        return 1.0
    return float(np.clip(np.sqrt(DISTINCT / max(n, 1)), 0.4, 1.0))


def _finish_over_time(
    ax: Axes, run: Drawable, window: tuple[float, float], units: Units, *, velocity: bool
) -> None:
    """Draw contacts and grazes, and name the axes of a displacement or velocity over time."""
    low, high = window
    draw_contacts_in_time(ax, run, low, high, velocity=velocity)
    draw_grazes_in_time(ax, run, low, high, velocity=velocity)
    if high > low:
        ax.set_xlim(low, high)
    ax.set_xlabel(f"time $t$ ({units.duration})")
    x, v = names_of(run)
    x, v = f"displacement {x}\n({units.displacement})", f"velocity {v}\n({units.velocity})"
    ax.set_ylabel(v if velocity else x)


@shared_docs
def plot_phase_portrait(
    run: DrawnRun,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
    against: On | None = None,
) -> Axes:
    """Draw the velocity over the displacement; an impact is a vertical dashed jump at its stop.

    Parameters
    ----------
    run
        The run.
    against
        Of a structure another displacement, drawn upwards in place of the velocity: a pair of
        coordinates, with the stops of both, where an impact is a corner.

    Returns
    -------
    Axes
        The axes; those of a new figure have a legend.
    """
    view = view_of(run, on)
    units = units_of(units, view.oscillator)
    low, high = window_of(view, window)
    curve = sample_in_full(view, (low, high))
    if against is not None:
        other = view_of(run, against)
        with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
            _draw_pair(ax, view, other, curve, units)
        return ax
    with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
        _draw_orbit(ax, curve)
        if low == view.t0:
            # Before the impact of a start that runs into a wall.
            ax.plot(view.x0, view.v0, **START_STYLE)
        _draw_jumps(ax, view, low, high)
        draw_stops(ax, view, curve.x, "x")
        draw_rest_points(ax, view, low, high)
        label_phase_plane(ax, units, names_of(view))
    return ax


def _draw_pair(
    ax: Axes, view: Drawable, other: Drawable, curve: SampledMotion, units: Units
) -> None:
    """Draw one displacement over another, with the stops of both."""
    # At an impact a displacement goes on; what was left out does not.
    gaps = curve.jumps & np.append(np.diff(curve.t) > 0.0, False)
    pair = SampledMotion(curve.t, curve.x, other(curve.t)[0], gaps)
    _draw_orbit(ax, pair)
    if curve.t[0] == view.t0:
        ax.plot(view.x0, other.x0, **START_STYLE)
    draw_stops(ax, view, pair.x, "x")
    draw_stops(ax, other, pair.v, "y")
    for label, seen in ((ax.set_xlabel, view), (ax.set_ylabel, other)):
        label(f"displacement {names_of(seen)[0]} ({units.displacement})")


def _draw_orbit(ax: Axes, curve: SampledMotion) -> None:
    """Draw a line in the plane: a long one finely, so that its loops stay apart."""
    x, v = reduce_to_pixels(curve)
    width = float(np.clip(1.2 * math.sqrt(40.0 / (1.0 + _length(curve))), 0.35, 1.2))
    # Very long ones stay an image inside an SVG, which would be large otherwise.
    ax.plot(x, v, color=BLUE, linewidth=width, rasterized=x.size > DRAWN_POINTS)


def _length(curve: SampledMotion) -> float:
    """Return the length of the line, in units of the width and the height of the picture."""
    dx, dv = (np.diff(values) / (np.ptp(values) or 1.0) for values in (curve.x, curve.v))
    return float(np.hypot(dx, dv)[~curve.jumps[:-1]].sum())


def _draw_jumps(ax: Axes, run: Drawable, low: float, high: float) -> None:
    shown = within(run.impacts.t, low, high)
    if shown.any():
        impacts = run.impacts
        # Of a structure an impact elsewhere is a jump here too.
        places, _ = run(impacts.t[shown])
        before, after = impacts.v_before[shown], impacts.v_after[shown]
        distinct = distinct_jumps(places, before, after)
        draw_jumps(ax, places[distinct], before[distinct], after[distinct])


@dataclass(frozen=True, slots=True)
class _Hits:
    """Impacts on one wall, or entries into one soft stop, as arrays."""

    t: Floats
    v: Floats
    cycle: Floats
    stop: int
    is_entry: bool

    @property
    def label(self) -> str:
        return f"entry into stop {self.stop}" if self.is_entry else f"impact on stop {self.stop}"

    @property
    def marker(self) -> str:
        markers = ENTRY_MARKERS if self.is_entry else IMPACT_MARKERS
        return markers[self.stop % len(markers)]


@shared_docs
def plot_impact_velocities(
    run: DrawnRun,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw the velocity after each impact over the cycle of the forcing.

    Entries into soft stops are drawn too, by open markers, with the velocity at the entry. The
    colour is the time; without a period of the forcing the time is the axis instead.

    Parameters
    ----------
    run
        The run.
    window
        First and last time of the impacts that are drawn; default: the whole run.
    on
        Of a structure the coordinate, direction or point whose velocity is drawn, at the stops on
        its line; default: at each stop the velocity towards or from it.

    Returns
    -------
    Axes
        The axes; with another one beside it, the scale of the colours. Those of a new figure have
        a legend.
    """
    hits_of = _met(run, on)
    units = units_of(units, hits_of.units)
    period = hits_of.period
    low, high = window_of(cast("Drawable", hits_of.run), window)
    groups = _groups(hits_of, low, high)
    with picture(ax, legend=True, labels=(xlabel, ylabel)) as ax:
        if groups:
            points = [_scatter(ax, hits, groups, period) for hits in groups]
            if period is not None:
                bar = ax.figure.colorbar(points[0], ax=ax, pad=0.02)
                bar.set_label(f"time $t$ ({units.duration})")
                bar.outline.set_visible(False)
            if len(groups) > 1:
                _name_markers(ax, groups)
            _pad_speeds(ax, np.concatenate([hits.v for hits in groups]))
        else:
            ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
            ax.set_axis_off()
        if period is not None:
            _draw_grazes(ax, hits_of.run.grazes.t, low, high, period)
            ax.set_xlim(-0.02, 1.02)
        ax.set_xlabel(
            f"time $t$ ({units.duration})" if period is None else "cycle (forcing periods)"
        )
        ax.set_ylabel(f"{_what(groups)} $v$\n({units.velocity})")
    return ax


@dataclass(frozen=True, slots=True)
class _MetStops:
    """What has impacts and crossings, the numbers of their stops, units, and a period."""

    run: Drawable | StructureTrajectory
    stops: Sequence[int]
    units: HasUnits
    period: float | None


def _met(run: DrawnRun, on: On | None) -> _MetStops:
    """Return the run of an oscillator, or one of a structure, whole or along a direction."""
    if isinstance(run, StructureOrbit):
        run = run.run
    if isinstance(run, StructureTrajectory):
        period = run.loads.period
        if on is None:
            return _MetStops(run, range(len(run.structure.stops)), run.structure, period)
        view = view_of(run, on)
        assert isinstance(view, DirectionView)
        return _MetStops(view, view.stop_numbers, run.structure, period)
    alone = view_of(run, on)
    assert isinstance(alone, Trajectory)
    period = None if alone.forcing is None else alone.forcing.period
    return _MetStops(alone, range(len(alone.oscillator.stops)), alone.oscillator, period)


def _groups(met: _MetStops, low: float, high: float) -> list[_Hits]:
    """Return what is drawn: the impacts on each wall and the entries into each soft stop."""
    impacts, crossings, period = met.run.impacts, met.run.crossings, met.period
    hit = within(impacts.t, low, high)
    entered = within(crossings.t, low, high) & (crossings.direction == "in")
    groups = []
    for row, stop in enumerate(met.stops):
        shown = hit & (impacts.stop == row)
        if shown.any():
            t, cycle = impacts.t[shown], impacts.cycle[shown]
            groups.append(_Hits(t, impacts.v_after[shown], cycle, stop, is_entry=False))
        shown = entered & (crossings.stop == row)
        if shown.any():
            t = crossings.t[shown]
            groups.append(_Hits(t, crossings.v[shown], t / (period or np.nan), stop, is_entry=True))
    return groups


def _what(groups: list[_Hits]) -> str:
    kinds = {hits.is_entry for hits in groups}
    if kinds == {True}:
        return "velocity at entry"
    return "velocity after impact" if kinds != {True, False} else "velocity after impact, at entry"


def _scatter(ax: Axes, hits: _Hits, groups: list[_Hits], period: float | None) -> PathCollection:
    """Draw the hits on one stop; the scale of the colours is that of all."""
    x = hits.t if period is None else _drawn_cycle(hits.cycle)
    seen = topmost(x, hits.v)
    size = sum(other.t.size for other in groups)
    points: PathCollection = ax.scatter(
        x[seen],
        hits.v[seen],
        c=BLUE if period is None else hits.t[seen],
        cmap=None if period is None else "cividis",
        vmin=None if period is None else min(other.t[0] for other in groups),
        vmax=None if period is None else max(other.t[-1] for other in groups),
        s=24.0 if size <= 1000 else 4.0,
        marker=hits.marker,
        linewidths=1.0 if hits.is_entry else 0.0,
        rasterized=hits.t.size > DRAWN_POINTS // 10,
    )
    return points


def _name_markers(ax: Axes, groups: list[_Hits]) -> None:
    """Give the legend the markers in grey, since their colour is the time."""
    for hits in groups:
        ax.plot([], [], hits.marker, color=GREY, markersize=5.0, label=hits.label)


def _draw_grazes(ax: Axes, t: Floats, low: float, high: float, period: float) -> None:
    shown = within(t, low, high)
    if shown.any():
        cycle = _drawn_cycle(t[shown] / period)
        seen = topmost(cycle, np.zeros(cycle.size))
        ax.plot(cycle[seen], np.zeros(seen.size), **GRAZE_STYLE)


def _drawn_cycle(cycle: Floats) -> Floats:
    """Return the cycles with those a rounding below 1 at 0, where the others are."""
    return np.mod(np.round(cycle, 9), 1.0)


def _pad_speeds(ax: Axes, v: Floats) -> None:
    """Keep velocities that differ by rounding from filling the axis."""
    low, high = v.min(), v.max()
    margin = max(0.06 * (high - low), 0.05 * np.abs(v).max()) or 1.0
    ax.set_ylim(low - margin, high + margin)


@shared_docs
def plot_staircase(
    run: Trajectory | StructureTrajectory,
    ax: Axes | None = None,
    *,
    spacing: float | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw t_k - k T_0 over the number k of the impact, T_0 being the eigenset's spacing.

    On the eigenset the points lie on the line at zero; on a shifted eigenset on another
    horizontal line; a missing impact lifts them by T_0, an additional one lowers them by as much.

    Parameters
    ----------
    run
        The run; without walls, the entries into soft stops are taken.
    spacing
        T_0 [time], > 0; default: 2 pi over the resonant frequency. Structures have several of
        these, and need it.

    Raises
    ------
    ParameterError
        If no spacing is given and the free oscillator has none, or it is not positive.
    """
    met = _met(run, None)
    if spacing is None and isinstance(run, Trajectory):
        spacing = 2.0 * np.pi / resonant_frequency(run.oscillator)
    elif spacing is None:
        reason = "a structure has several resonant frequencies; give the time between two impacts"
        raise ParameterError("spacing", spacing, reason)
    elif not 0.0 < spacing < np.inf:
        raise ParameterError("spacing", spacing, "not a positive number")
    units = units_of(units, met.units)
    times = run.impacts.t
    if len(times) == 0:
        times = run.crossings.t[entry_rows(run)]
    k = np.arange(1, len(times) + 1)
    ahead = (times - run.t0) - k * spacing
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        ax.axhline(0.0, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
        if len(times):
            shown, heights, _ = reduce_to_columns(
                k.astype(np.float64), ahead, np.zeros(len(times), dtype=np.bool_)
            )
            marker = "o" if len(times) <= MOST_MARKERS else ""
            ax.plot(shown, heights, color=BLUE, linewidth=0.9, marker=marker, markersize=3.2)
            _pad_lead(ax, float(ahead.min()), float(ahead.max()), spacing)
        else:
            ax.text(0.5, 0.5, "no impacts", transform=ax.transAxes, ha="center", va="center")
        ax.xaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
        ax.set_xlabel("number of the impact $k$")
        ax.set_ylabel(f"$t_k - k\\,T_0$\n({units.duration})")
    return ax


def _pad_lead(ax: Axes, low: float, high: float, spacing: float) -> None:
    """Keep the line at zero in sight, and rounding from filling the axis."""
    low, high = min(low, 0.0), max(high, 0.0)
    margin = max(0.06 * (high - low), 0.01 * spacing)
    ax.set_ylim(low - margin, high + margin)


@shared_docs
def plot_spectrum(
    result: Dataset | DrawnRun,
    ax: Axes | None = None,
    *,
    resonance: float | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw the amplitudes of a spectrum over the angular frequency.

    Parameters
    ----------
    result
        What `percuss.spectrum` or `percuss.line_spectrum` has returned; or a run or an orbit, whose
        exact spectrum is then drawn.
    resonance
        Resonant frequency, marked by a vertical line [1/time]; default: that of the run's
        oscillator, if it has one.
    on
        Of the run of a structure the coordinate, direction or point whose displacement is taken.

    Returns
    -------
    Axes
        The axes; the lines of a periodic motion are drawn as lines.

    Raises
    ------
    ParameterError
        If it is something else.
    """
    if isinstance(result, StructureOrbit):
        result = result.run
    if isinstance(result, StructureTrajectory):
        units = units_of(units, result.structure)
        result = spectrum(result, on=on)
    elif isinstance(result, Trajectory | PeriodicOrbit):
        units = units_of(units, result.oscillator)
        resonance = _resonance(result.oscillator) if resonance is None else resonance
        result = spectrum(result) if isinstance(result, Trajectory) else result.spectrum()
    else:
        check_table("result", result, "percuss.spectrum", "omega", "amplitude")
        units = units_of(units)
    omega = np.asarray(result["omega"].values, dtype=np.float64)
    amplitude = np.asarray(result["amplitude"].values, dtype=np.float64)
    is_velocity = result.attrs["of"] == "velocity"
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        ax.set_yscale("log")
        highest = float(amplitude.max(initial=0.0))
        if highest == 0.0:
            ax.text(0.5, 0.5, "no motion", transform=ax.transAxes, ha="center", va="center")
        elif "line" in result.dims:
            _draw_lines(ax, omega, amplitude, ROUNDING * highest)
        else:
            _draw_curve(ax, omega, amplitude, DEPTH * highest)
        if resonance is not None:
            ax.axvline(resonance, color=ORANGE, linewidth=1.0, label="resonant frequency")
            ax.legend(loc="upper right")
        if len(omega) > 1:
            ax.set_xlim(float(omega.min()), float(omega.max()))
        unit = "dimensionless" if units.duration == "dimensionless" else f"1/{units.duration}"
        ax.set_xlabel(f"angular frequency $\\omega$ ({unit})")
        what = "velocity" if is_velocity else "displacement"
        of_what = units.velocity if is_velocity else units.displacement
        ax.set_ylabel(f"amplitude of the {what}\n({of_what})")
    return ax


def _resonance(oscillator: Oscillator) -> float | None:
    try:
        return resonant_frequency(oscillator)
    except ParameterError:
        return None


def _draw_curve(ax: Axes, omega: Floats, amplitude: Floats, floor: float) -> None:
    order = np.argsort(omega, kind="stable")
    no_jumps = np.zeros(len(omega), dtype=np.bool_)
    shown, heights, _ = reduce_to_columns(
        omega[order], np.maximum(amplitude[order], floor), no_jumps
    )
    ax.plot(shown, heights, color=BLUE, linewidth=0.8)


def _draw_lines(ax: Axes, omega: Floats, amplitude: Floats, floor: float) -> None:
    seen = amplitude > floor
    heights = amplitude[seen]
    if heights.size == 0:
        return
    bottom = 0.5 * float(heights.min())
    ax.vlines(omega[seen], bottom, heights, color=BLUE, linewidth=1.0)
    ax.plot(omega[seen], heights, "o", color=BLUE, markersize=3.0)
    ax.set_ylim(bottom, 2.0 * float(heights.max()))


@shared_docs
def plot_motion(
    run: DrawnRun,
    figure: Figure | None = None,
    *,
    title: str = "",
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    on: On | None = None,
) -> Figure:
    """Draw a run in four panels: x(t), v(t), the phase portrait and the impact velocities.

    Parameters
    ----------
    run
        The run, of a structure along one line; `plot_coordinates` draws several.
    on
        Of a structure the coordinate, direction or point that is drawn; default: the line of its
        first stop, and in the last panel the impacts on all stops.
    figure
        An empty figure to draw on, such as `offscreen_figure`; default: a new one.
    title
        Title of the figure.

    Returns
    -------
    Figure
        The figure.
    """
    with style(is_own=figure is None):
        figure = given_figure(figure, *SIZE)
        # Two parts, so that the scale of colours below takes no space from the curves above.
        parts = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.35, 1.0])
        upper, lower = parts[:, 0]
        panels = {
            **upper.subplot_mosaic([["x"], ["v"]]),
            **lower.subplot_mosaic([["portrait", "impacts"]]),
        }
        panels["x"].sharex(panels["v"])
        plot_displacement(run, panels["x"], window=window, units=units, on=on)
        plot_velocity(run, panels["v"], window=window, units=units, on=on)
        plot_phase_portrait(run, panels["portrait"], window=window, units=units, on=on)
        plot_impact_velocities(run, panels["impacts"], window=window, units=units, on=on)
        panels["x"].set_xlabel("")
        panels["x"].tick_params(labelbottom=False)
        upper.align_ylabels([panels["x"], panels["v"]])
        if title:
            title_figure(figure, title, fontsize=12.0)
        draw_legend(figure, panels.values())
    return figure
