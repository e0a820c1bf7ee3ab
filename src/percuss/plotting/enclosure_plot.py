"""Pictures of certified motions, orbits and special points, with the radii of their enclosures."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Polygon
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.oscillator import Wall
from percuss.model.units import Units
from percuss.numerics import hypot
from percuss.orbits.bifurcations.branch import Branch
from percuss.plotting.branch_plot import MARKERS, plot_branch
from percuss.plotting.labels import parameter_label
from percuss.plotting.marks import (
    CONTACT_STYLE,
    GRAZE_STYLE,
    draw_jumps,
    draw_stops,
    draw_unit_circle,
    stop_places,
)
from percuss.plotting.section_plot import explain, label_impact_surface
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SKY_BLUE,
    VERMILION,
    fix_ticks,
    label_once,
    label_phase_plane,
    picture,
    shared_docs,
    units_of,
)
from percuss.wording import counted

if TYPE_CHECKING:
    # Needs python-flint, without which there is no certified result.
    from percuss.certified import (
        Balls,
        CertifiedBasins,
        CertifiedBranch,
        CertifiedChaos,
        CertifiedOrbit,
        CertifiedPoint,
        CertifiedRun,
        CompleteList,
        ComplexBall,
    )


# Points of the curve, some 30 microseconds each, and the most of them between two events.
MOST_POINTS, MOST_BETWEEN = 6000, 48
# Sizes of a mark [point], and the number of events up to which marks have the largest one.
LARGEST_MARK, LEAST_MARK, FEW_EVENTS = 3.5, 1.0, 50
# Parts of the height: of the radii below, and of the gap between them and the motion.
RADII, FREE = 0.36, 0.06
# Points of each flight.
POINTS = 160
LOG10_2 = float(np.log10(2.0))
# Greatest part of a multiplier in the picture, and the least radius as a part of its width.
MOST, LEAST = 3.0, 0.025
# The corners of a set in its coordinates, closed; colours of the loops of a proof of chaos.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
LOOPS = (GREEN, ORANGE, SKY_BLUE)
# Colour and name of strips by what is proven of all of their orbits.
STRIPS = {
    "asymptotic": (BLUE, "asymptotically stable"),
    "elliptic": (GREEN, "elliptic"),
    "unstable": (VERMILION, "unstable"),
    "undecided": (BLACK, "stability open"),
}
# Colours of proven basins.
BASINS = (SKY_BLUE, ORANGE, GREEN, BLUE, VERMILION)
FORMAL = {False: "formal: through a stop", None: "open whether through a stop"}
# Sets nearer to the saddle than this part of the picture have no numbers.
CROWDED = 0.04
# Digits of a number in the picture.
MOST_DIGITS = 15


@shared_docs
def plot_enclosure(
    proven: CertifiedRun
    | CertifiedOrbit
    | CertifiedPoint
    | Sequence[CertifiedPoint]
    | CertifiedBranch
    | CertifiedChaos
    | CompleteList
    | CertifiedBasins,
    ax: Axes | None = None,
    *,
    branch: Branch | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw a certified result, and the logarithm of its proven radius.

    The radii are those of the balls, far below what a float resolves. In a motion over time a
    straight rise is an error that grows exponentially, as in chaos. An orbit is drawn as a phase
    portrait, with its multipliers in the complex plane: blue if they certainly lie inside the unit
    circle, red if outside, and black if their ball meets it. A branch is drawn as its strips, at
    their size, in the parameter and the velocity after the first event. The sets of a proof of
    chaos are drawn in the impact surface, at their size and with their numbers; best on the axes of
    `plot_manifolds`. A complete list is drawn there, too: the impacts of its orbits, the boxes in
    which each is proven to be alone, and those that are open. Proven basins are coloured cells of
    the plane of starts, open ones white.

    Parameters
    ----------
    proven
        What `percuss.certify` has returned for a run, an orbit, a branch, a special point, or a
        list of those for the special points of one branch; or what `percuss.certified.prove_chaos`
        or `percuss.certified.list_orbits` or `percuss.certified.prove_basins` has.
    ax
        Axes to draw on; default: those of a new figure. An orbit and special points leave a part
        of their area to further axes, to the right or below.
    branch
        The branch of special points.

    Returns
    -------
    Axes
        The axes of the motion, the portrait or the branch. Those of a motion are the upper part,
        and those of its radii share their time and have their scale on the right; an event is
        marked at the radius of its time. Axes of a new figure have a legend.

    Raises
    ------
    ParameterError
        If it is not a certified result, or an orbit, a branch or chaos that is not proven; if the
        branch is missing or over another parameter.
    MissingExtraError
        If python-flint is not installed.
    """
    from percuss.certified import (
        CertifiedBasins,
        CertifiedBranch,
        CertifiedChaos,
        CertifiedOrbit,
        CertifiedPoint,
        CertifiedRun,
        CompleteList,
    )

    if isinstance(proven, CertifiedChaos):
        return _draw_chaos(proven, ax, units)
    if isinstance(proven, CompleteList):
        return _draw_list(proven, ax, units)
    if isinstance(proven, CertifiedBasins):
        return _draw_basins(proven, ax, units)
    if isinstance(proven, CertifiedOrbit):
        return draw_certified_orbit(proven, ax, units_of(units, proven.oscillator))
    if isinstance(proven, CertifiedBranch):
        return _draw_branch(proven, ax, units)
    if isinstance(proven, CertifiedPoint):
        return draw_certified_points([proven], branch, ax, units_of(units))
    if isinstance(proven, list | tuple) and all(isinstance(p, CertifiedPoint) for p in proven):
        return draw_certified_points(proven, branch, ax, units_of(units))
    if not isinstance(proven, CertifiedRun):
        reason = "not a certified run, orbit or special point; percuss.certify(run) makes one"
        raise ParameterError("proven", proven, reason)
    return _draw_run(proven, ax, units)


def _draw_chaos(proven: CertifiedChaos, ax: Axes | None, units: Units | None) -> Axes:
    """Draw the sets of a proof of chaos in the impact surface, at their size, with their numbers."""
    if not proven:
        raise ParameterError("proven", proven, f"chaos is not proven: {proven.reason}")
    units, is_alone = units_of(units, proven.orbit.oscillator), ax is None
    period = proven.orbit.period / proven.orbit.n_periods
    middle = np.array(proven.sets[0].center) / [period, 1.0] % [1.0, np.inf]
    loop_of = {i: number for number, loop in enumerate(proven.loops) for i in loop[1:]}
    with picture(ax) as ax:
        for i, hset in enumerate(proven.sets):
            number = loop_of.get(i, 0)
            colour = (BLACK, *LOOPS)[number] if number <= len(LOOPS) else GREY
            center, u, s = (np.array(pair) / [period, 1.0] for pair in hset)
            center[0] %= 1.0
            corners = np.array([center + a * u + b * s for a, b in CORNERS])
            name = f"loop of {len(proven.loops[number])} impacts" if number else "saddle's set"
            ax.plot(*corners.T, color=colour, linewidth=1.0, zorder=3.0)
            ax.plot(
                *center, "o", color=colour, markersize=2.5, zorder=3.0, label=label_once(ax, name)
            )
            if i > 0 and hypot(*(center - middle)) < CROWDED:
                continue
            ax.annotate(
                str(i), tuple(center), textcoords="offset points", xytext=(3, 3), fontsize=6, color=colour,
                zorder=3.1,
            )  # fmt: skip
        label_impact_surface(ax, units)
        bound = math.floor(1e4 * proven.entropy.mid()) / 1e4
        ax.set_title(f"proven: topological entropy $\\geq$ {bound:g} an impact")
        explain(ax, alone=is_alone)
    return ax


def _draw_list(proven: CompleteList, ax: Axes | None, units: Units | None) -> Axes:
    """Draw a list of orbits in the impact surface, with what is open of it."""
    units, is_alone = units_of(units, proven.oscillator), ax is None
    with picture(ax) as ax:
        for boxes, colour, alpha, name in (
            (proven.open_boxes, ORANGE, 0.7, "open"),
            (proven.boxes, SKY_BLUE, 0.5, "one solution, proven"),
        ):
            for low, high, bottom, top in boxes:
                # A box over the end of a cycle is at both ends.
                for turn in (-1.0, 0.0, 1.0):
                    across = (low + turn, high + turn, high + turn, low + turn)
                    if across[0] < 1.0 and across[1] > 0.0:
                        label = label_once(ax, name)
                        ax.fill(across, (bottom, bottom, top, top), color=colour, alpha=alpha,
                                linewidth=0.0, label=label)  # fmt: skip
        for orbit in (*proven.orbits, *proven.shorter):
            on_stop = orbit.impacts.stop == proven.stop
            cycles, v = (
                balls.mid()[on_stop] for balls in (orbit.impacts.cycle, orbit.impacts.v_after)
            )
            colour, name = STRIPS[orbit.stability]
            label = label_once(
                ax, name if orbit.n_periods == proven.periods else f"shorter, {name}"
            )
            ax.plot(cycles, v, "o", color=colour, markersize=4.5, zorder=3.0, label=label,
                    fillstyle="full" if orbit.n_periods == proven.periods else "none")  # fmt: skip
        label_impact_surface(ax, units)
        low, high = proven.speeds
        stop = proven.oscillator.stops[proven.stop]
        # Away from a wall, into a soft stop.
        sign = -1.0 if (stop.side == "above") is isinstance(stop, Wall) else 1.0
        ax.set_ylim(*sorted((sign * low, sign * high)))
        known = "complete" if proven.complete else f"{proven.open_part:.2g} of the region is open"
        sought = f"{counted(proven.impacts, 'impact')} in {counted(proven.periods, 'period')}"
        ax.set_title(f"orbits of {sought}, {known}")
        explain(ax, alone=is_alone)
    return ax


def _draw_basins(proven: CertifiedBasins, ax: Axes | None, units: Units | None) -> Axes:
    """Draw the cells of proven basins, each in the colour of its attractor, and what is open."""
    units, is_alone = units_of(units, proven.oscillator), ax is None
    colours = [BASINS[k % len(BASINS)] for k in range(len(proven.attractors))]
    total = (sum(proven.areas) + proven.open_area) or 1.0
    with picture(ax) as ax:
        # Label -2 is the first row: a wall.
        table = np.array([to_rgb(name) for name in (BLACK, "white", *colours)])
        ax.pcolormesh(proven.x0, proven.v0, table[proven.labels.T + 2], rasterized=True)
        for k, (orbit, colour) in enumerate(zip(proven.attractors, colours, strict=True)):
            name = f"({orbit.n_impacts:g}, {orbit.n_periods})"
            share = f"proven: to {name}, {100.0 * proven.areas[k] / total:.1f} %"
            ax.plot([], [], "s", color=colour, label=share)
        ax.plot([], [], "s", markerfacecolor="white", markeredgecolor=GREY,
                label=f"open, {100.0 * proven.open_area / total:.1f} %")  # fmt: skip
        if (proven.labels == -2).any():
            ax.plot([], [], "s", color=BLACK, label="beyond a wall")
        label_phase_plane(ax, units, ("$x_0$", "$v_0$"))
        ax.set_title(f"proven basins: {100.0 * proven.decided:.1f} % decided, the rest is open")
        explain(ax, alone=is_alone)
    return ax


def _draw_branch(proven: CertifiedBranch, ax: Axes | None, units: Units | None) -> Axes:
    """Draw the strips of a branch, at their size, and the special points that lie on it."""
    if not proven.stretches:
        raise ParameterError("proven", proven, f"nothing of the branch is proven: {proven.reason}")
    units, is_alone = units_of(units, proven.oscillator), ax is None
    outlines = proven.outlines()
    with picture(ax) as ax:
        for corners, stability, admissible in outlines:
            colour, name = STRIPS.get(stability, STRIPS["undecided"])
            if not admissible:
                colour, name = GREY, FORMAL[admissible]
            ax.add_patch(
                Polygon(corners, facecolor=colour, edgecolor=colour, linewidth=0.8, alpha=0.8)
            )
            # Its name in the legend, and a size for the axes: a patch has none.
            ax.plot(*corners.T, color=colour, linewidth=0.8, label=label_once(ax, name))
        for point in proven.special_points:
            value = point.value.mid()
            at = min(outlines, key=lambda it: float(abs(it[0][:, 0].mean() - value)))[0]
            place = (value, float(at[:, 1].mean()))
            ax.plot(*place, MARKERS[point.kind], color=BLACK, markersize=4.5, zorder=4.0)
            low, high = ax.get_xlim()
            right = value > 0.5 * (low + high)
            ax.annotate(
                f"{point.kind.replace('_', ' ')}\n{point.value.text(MOST_DIGITS)}", place,
                (-10.0 if right else 10.0, -4.0 * (point.kind != "fold")),
                textcoords="offset points", va="center" if point.kind == "fold" else "top",
                ha="right" if right else "left", fontsize="x-small", zorder=4.0,
                path_effects=[withStroke(linewidth=2.5, foreground="white")],
            )  # fmt: skip
        ax.set_xlabel(parameter_label(cast("Any", proven), proven.path, units))
        ax.set_ylabel(f"velocity after event 0 ({units.velocity})")
        ends = "from end to end" if proven.complete else "with gaps"
        ax.set_title(f"proven in {len(proven)} strips, {ends}")
        ax.margins(0.08)
        fix_ticks(ax)
        explain(ax, alone=is_alone)
    return ax


def _draw_run(proven: CertifiedRun, ax: Axes | None, units: Units | None) -> Axes:
    """Draw a motion over time, and below it its radii."""
    units = units_of(units, proven.oscillator)
    t = _times(proven)
    x, _ = proven(t)
    with picture(ax, (8.0, 4.8), legend=True) as ax:
        ax.plot(t, x.mid(), color=BLUE, linewidth=1.1, label="motion")
        draw_stops(ax, cast("Any", proven), x.mid(), "y")
        _draw_rest(ax, proven, t)
        lower = ax.twinx()
        _draw_radii(lower, proven, t, x)
        _share_the_height(ax, lower)
        if not proven.complete:
            ax.axvline(t[-1], color=BLACK, linestyle=":", linewidth=1.1, label="the proof ends")
        if t[-1] > t[0]:
            ax.set_xlim(t[0], t[-1] + (0.02 * (t[-1] - t[0]) if not proven.complete else 0.0))
        ax.set_xlabel(f"time $t$ ({units.duration})")
        ax.set_ylabel(f"displacement $x$\n({units.displacement})", loc="top")
        lower.set_ylabel("log$_{10}$ of radius", color=GREEN, loc="bottom")
        fix_ticks(lower)
        lower.tick_params(axis="y", colors=GREEN)
    return ax


def _times(proven: CertifiedRun) -> Floats:
    """Return times at and between the events, all certainly within the proven motion."""
    low, high = proven.known_times
    if not proven.t_end.arb.is_finite():
        # At rest for ever: a little of it is shown.
        high += 0.06 * (high - low) or 1.0
    if not high > low:
        return np.array([low])
    events = proven.event_times.mid()
    inside = events[(events > low) & (events < high)]
    cuts = np.unique(np.concatenate([[low], inside, [high]]))
    # Very many flights fill an area, so that some can be left out.
    cuts = cuts[:: max(1, cuts.size // (MOST_POINTS // 2))]
    cuts = cuts if cuts[-1] == high else np.append(cuts, high)
    between = max(1, min(MOST_BETWEEN, MOST_POINTS // cuts.size))
    steps = np.arange(between) / between
    t = (cuts[:-1, None] + np.diff(cuts)[:, None] * steps).ravel()
    return np.append(np.clip(t, low, high), high)


def _draw_radii(lower: Axes, proven: CertifiedRun, t: Floats, x: Balls) -> None:
    lower.plot(t, log10_radii(x), color=GREEN, linewidth=1.0, label="radius of $x$")
    events = (("o", "impact", proven.impacts.t), ("x", "crossing", proven.crossings.t))
    for mark, name, balls in events:
        if len(balls):
            size = max(LEAST_MARK, LARGEST_MARK * min(1.0, FEW_EVENTS / len(balls)) ** 0.5)
            lower.plot(balls.mid(), log10_radii(balls), mark, color=BLACK, markersize=size,
                       label=f"of {name}s")  # fmt: skip


def _draw_rest(ax: Axes, proven: CertifiedRun, t: Floats) -> None:
    """Draw contacts as thick lines at their stop, and the touch at which a proof ended."""
    run: Any = proven
    contacts, grazes = proven.contacts, proven.grazes
    if len(contacts):
        start, release = contacts.start.mid(), contacts.release.mid()
        last = np.where(np.isnan(release), t[-1], release)
        places = stop_places(run, contacts.stop)
        ax.hlines(places, start, last, linewidth=3.5, zorder=4.0, color=CONTACT_STYLE["color"])
        ax.plot(start, places, "s", markersize=4.5, zorder=5.0, **CONTACT_STYLE)
    if len(grazes):
        ax.plot(grazes.t.mid(), stop_places(run, grazes.stop), **GRAZE_STYLE)


def _share_the_height(ax: Axes, lower: Axes) -> None:
    """Divide the height between the motion and the radii below, each with ticks in its own part."""
    low, high = ax.get_ylim()
    upper_part = 1.0 - RADII - FREE
    ax.set_ylim(high - (high - low) / upper_part, high)
    ax.set_yticks([tick for tick in MaxNLocator(5).tick_values(low, high) if low <= tick <= high])
    bottom, top = lower.get_ylim()
    # The scale has one digit at least.
    bottom, top = (
        bottom - max(0.0, 0.5 * (1.0 - top + bottom)),
        max(top, 0.5 * (1.0 + top + bottom)),
    )
    lower.set_ylim(bottom, bottom + (top - bottom) / RADII)
    ticks = MaxNLocator(4).tick_values(bottom, top)
    lower.set_yticks([tick for tick in ticks if bottom <= tick <= top])
    lower.spines["right"].set_visible(True)
    lower.spines["right"].set_color(GREEN)
    lower.axhline(bottom + (top - bottom) * (1.0 + 0.5 * FREE / RADII), color=GREY, linewidth=0.5)


def draw_certified_orbit(proven: CertifiedOrbit, ax: Axes | None, units: Units) -> Axes:
    """Draw an orbit on the left part of axes, radius and multipliers on the right.

    Raises
    ------
    ParameterError
        If it is not proven, or sticks.
    """
    if not proven.is_drawable:
        reason = "not proven" if not proven.exists else "an orbit with contacts"
        hint = "percuss.certify(orbit.trajectory()) can be drawn"
        raise ParameterError("proven", proven, f"{reason}; {hint}")
    times = _orbit_times(proven)
    x, v = proven(np.concatenate(times))
    ends = np.cumsum([len(part) for part in times])[:-1]
    with picture(ax, (9.0, 4.4), legend=True) as ax:
        upper, lower = _axes_to_the_right(ax)
        gaps = np.split(x.mid(), ends), np.split(v.mid(), ends)
        for k, (xs, vs) in enumerate(zip(*gaps, strict=True)):
            ax.plot(xs, vs, color=BLUE, linewidth=1.4, label="orbit" if k == 0 else None)
        impacts = proven.impacts
        jumps = impacts.v_before.mid() != impacts.v_after.mid()
        if jumps.any():
            places = stop_places(cast("Any", proven), impacts.stop[jumps])
            draw_jumps(ax, places, impacts.v_before.mid()[jumps], impacts.v_after.mid()[jumps])
        draw_stops(ax, cast("Any", proven), x.mid(), "x")
        ax.set_xlabel(f"displacement $x$ ({units.displacement})")
        ax.set_ylabel(f"velocity $v$ ({units.velocity})")
        ax.set_title(_title(proven))
        _draw_orbit_radii(lower, times, (x, v), units)
        _draw_multipliers(upper, proven)
        for axes in (upper, lower):
            fix_ticks(axes)
    return ax


def _title(proven: CertifiedOrbit) -> str:
    known = {
        True: "passes through no stop",
        False: "passes through a stop",
        None: "may pass through a stop",
    }
    isolated = "alone with these events" if proven.isolated else "one of a family"
    stability = proven.stability
    if stability == "undecided":
        stability = "stability undecided"
    return f"proven: {isolated}, {known[proven.admissible]}, {stability}"


def _axes_to_the_right(ax: Axes) -> tuple[Axes, Axes]:
    """Return two axes, one above the other, in the right part of the area of others."""
    figure, spec = ax.get_figure(), ax.get_subplotspec()
    assert figure is not None
    if spec is None:
        return ax.inset_axes((1.25, 0.55, 0.7, 0.45)), ax.inset_axes((1.25, 0.0, 0.7, 0.4))
    parts = spec.subgridspec(1, 2, width_ratios=(1.35, 1.0))
    ax.set_subplotspec(parts[0])
    right = parts[1].subgridspec(2, 1, height_ratios=(1.35, 1.0))
    return figure.add_subplot(right[0]), figure.add_subplot(right[1])


def _orbit_times(proven: CertifiedOrbit) -> list[Floats]:
    """Return times of each flight, certainly within it."""
    period, first = proven.period.mid(), proven.t0.mid()
    events = proven.event_times
    cuts = events.mid() if len(events) else np.array([first])
    cuts = np.append(cuts, cuts[0] + period)
    parts = []
    for low, high in itertools.pairwise(cuts):
        inset = 1e-7 * (high - low)
        parts.append(np.linspace(low + inset, high - inset, POINTS))
    return parts


def log10_radii(balls: Balls) -> Floats:
    """Return log10 of the radii, also of those far below the least float; NaN for 0."""
    logarithms = np.full(len(balls), np.nan)
    for i, ball in enumerate(balls.arbs):
        radius = ball.rad()
        if ball.is_finite() and not radius.is_zero():
            mantissa, exponent = radius.man_exp()
            logarithms[i] = float(np.log10(float(int(mantissa)))) + int(exponent) * LOG10_2
    return logarithms


def _draw_orbit_radii(
    ax: Axes, times: list[Floats], balls: tuple[Balls, Balls], units: Units
) -> None:
    t = np.concatenate(times)
    since = t - t[0]
    for column, name, look in zip(balls, ("x", "v"), ("-", (0, (4, 2))), strict=True):
        ax.plot(since, log10_radii(column), color=GREEN, linewidth=1.1, linestyle=look,
                label=f"radius of ${name}$")  # fmt: skip
    for part in times[1:]:
        ax.axvline(part[0] - t[0], color=BLUE, linewidth=0.8, linestyle=(0, (3, 2)), zorder=0.5)
    ax.set_xlim(0.0, since[-1])
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.set_xlabel(f"time ({units.duration})")
    ax.set_ylabel("log$_{10}$ of radius")


def _radius(ball: ComplexBall) -> float:
    """Return a bound of a number's distance from the middle of its ball."""
    value = ball.acb
    return float(np.hypot(float(value.real.rad()), float(value.imag.rad())) * (1.0 + 1e-12))


def _draw_multipliers(ax: Axes, proven: CertifiedOrbit) -> None:
    """Draw the unit circle and the multipliers, with their radii in words."""
    values = [ball.mid() for ball in proven.multipliers]
    radii = [_radius(ball) for ball in proven.multipliers]
    largest = max([1.0, *(max(abs(value.real), abs(value.imag)) for value in values)])
    edge = 1.25 * min(largest, MOST)
    draw_unit_circle(ax, edge)
    for value, radius in zip(values, radii, strict=True):
        outside = abs(value) - radius > 1.0
        colour = VERMILION if outside else BLUE if abs(value) + radius < 1.0 else BLACK
        shown = complex(np.clip(value.real, -edge, edge), np.clip(value.imag, -edge, edge))
        size = max(radius, LEAST * edge)
        ax.add_patch(Circle((shown.real, shown.imag), size, color=colour, zorder=3.0))
        if shown != value:
            ax.annotate(f"{value.real:.3g}", (shown.real, shown.imag), (0.0, 6.0),
                        textcoords="offset points", ha="right", fontsize="small")  # fmt: skip
    radius = max(radii)
    ax.set_xlabel(f"multipliers\nradius at most {radius:.0e}" if radius else "multipliers, exact")


def draw_certified_points(
    points: Sequence[CertifiedPoint], branch: Branch | None, ax: Axes | None, units: Units
) -> Axes:
    """Draw a branch with its proven special points, and below it the radii of their balls.

    Raises
    ------
    ParameterError
        If the branch is missing, or is over another parameter.
    """
    from percuss.certified import Balls

    if branch is None:
        raise ParameterError("branch", branch, "the branch of the special points is needed")
    paths = sorted({point.path for point in points} | {branch.path})
    if any(point.point.path != branch.path for point in points):
        raise ParameterError("branch", branch, f"over another parameter: {' and '.join(paths)}")
    proven = [point for point in points if point.exists]
    with picture(ax, (8.0, 5.2)) as ax:
        spec, figure = ax.get_subplotspec(), ax.get_figure()
        if spec is None or figure is None:
            raise ParameterError("ax", ax, "not a subplot of a figure")
        parts = spec.subgridspec(2, 1, height_ratios=(2.6, 1.0))
        ax.set_subplotspec(parts[0])
        lower = figure.add_subplot(parts[1], sharex=ax)
        plot_branch(branch, ax, units=units)
        label = ax.get_xlabel()
        ax.set_xlabel("")
        ax.tick_params(labelbottom=False)
        values = np.array([point.value.mid() for point in proven])
        radii = log10_radii(Balls.of(point.value.arb for point in proven))
        for value in values:
            for axes in (ax, lower):
                axes.axvline(value, color=GREY, linewidth=0.6, zorder=0.4)
        shown = ~np.isnan(radii)
        lower.plot(values[shown], radii[shown], "o", color=GREEN, markersize=5.0)
        low = float(radii[shown].min()) - 1.0 if shown.any() else -1.0
        high = float(radii[shown].max()) + 1.5 if shown.any() else 1.0
        lower.set_ylim(low, high)
        for k, (point, radius) in enumerate(zip(proven, radii, strict=True)):
            place = (point.value.mid(), radius if np.isfinite(radius) else low)
            _write(lower, point, place, k)
        for point in points:
            if not point.exists:
                lower.plot([point.point.value], [low], "x", color=GREY, clip_on=False)
        if not points:
            lower.text(0.5, 0.5, "no special points", transform=lower.transAxes, ha="center")
            lower.set_yticks([])
        lower.set_xlabel(label)
        lower.set_ylabel("log$_{10}$ of radius", color=GREEN)
        fix_ticks(lower)
    return ax


def _write(ax: Axes, point: CertifiedPoint, place: tuple[float, float], k: int) -> None:
    """Write the number of a mark, to its right or left, whichever side is larger."""
    low, high = ax.get_xlim()
    right = place[0] < 0.5 * (low + high)
    text = point.value.text(MOST_DIGITS) if point.value.radius() else f"{point.value.mid():.15g}"
    ax.annotate(text, place, (6.0 if right else -6.0, 4.0 + 9.0 * (k % 2)),
                textcoords="offset points", ha="left" if right else "right", fontsize="x-small")  # fmt: skip
