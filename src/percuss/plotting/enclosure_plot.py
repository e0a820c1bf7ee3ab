"""What was certified, and how wide the proven enclosure is: motions, orbits, special points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from percuss.errors import ParameterError
from percuss.orbits.bifurcations.branch import Branch
from percuss.plotting.enclosed_orbit import draw_certified_orbit, log10_radii
from percuss.plotting.enclosed_points import draw_certified_points
from percuss.plotting.stops import CONTACT_STYLE, GRAZE_STYLE, draw_stops, stop_places
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    Units,
    draw_legend,
    fix_ticks,
    new_figure,
    style,
    units_of,
)

if TYPE_CHECKING:
    # Needs python-flint; a picture of what was proven is asked for where that is there.
    from percuss.certified import Balls, CertifiedOrbit, CertifiedPoint, CertifiedRun

__all__ = ["plot_enclosure"]

Floats = npt.NDArray[np.float64]

# Points of the curve, some 30 microseconds each, and how many of them between two events.
MOST_POINTS, MOST_BETWEEN = 6000, 48
# Size of a mark [point], and how many events keep marks of the largest size apart.
LARGEST_MARK, LEAST_MARK, APART = 3.5, 1.0, 50
# Parts of the height: of the radii below, and free between them and the motion.
RADII, FREE = 0.36, 0.06


def plot_enclosure(
    proven: CertifiedRun | CertifiedOrbit | CertifiedPoint | Sequence[CertifiedPoint],
    ax: Axes | None = None,
    *,
    branch: Branch | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw what was certified, and the logarithm of its proven radius.

    The radii are those of the balls, far below what a float can tell. In a motion over time a
    straight rise is an error that grows exponentially, as in chaos. An orbit is drawn as a phase
    portrait, with its multipliers in the plane: those that are certain to lie inside of the unit
    circle are blue, those outside of it red, and those whose ball touches it black.

    Parameters
    ----------
    proven
        What `percuss.certify` has returned for a run, an orbit, a special point, or a list of
        those for the special points of one branch.
    ax
        Axes to draw on; default: those of a new figure. For an orbit and for special points they
        are made smaller, for others beside or below them.
    branch
        The branch of special points.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes of the motion, the portrait or the branch. Those of a motion are the upper part,
        and those of its radii share their time and have their scale on the right; an event is
        marked at the radius of its time. Axes of a new figure have a legend.

    Raises
    ------
    ParameterError
        If it is nothing certified, an orbit that is not proven, or the branch is missing or over
        another parameter.
    MissingExtraError
        If python-flint is not there.
    """
    from percuss.certified import CertifiedOrbit, CertifiedPoint, CertifiedRun

    if isinstance(proven, CertifiedOrbit):
        return draw_certified_orbit(proven, ax, units_of(units))
    if isinstance(proven, CertifiedPoint):
        return draw_certified_points([proven], branch, ax, units_of(units))
    if isinstance(proven, list | tuple) and all(isinstance(p, CertifiedPoint) for p in proven):
        return draw_certified_points(proven, branch, ax, units_of(units))
    if not isinstance(proven, CertifiedRun):
        reason = "not a certified run, orbit or special point; percuss.certify(run) makes one"
        raise ParameterError("proven", proven, reason)
    return _draw_run(proven, ax, units)


def _draw_run(proven: CertifiedRun, ax: Axes | None, units: Units | None) -> Axes:
    """Draw a motion over time, and below it its radii."""
    units = units_of(units)
    t = _times(proven)
    x, _ = proven(t)
    with style():
        is_alone, ax = ax is None, new_figure(8.0, 4.8).add_subplot() if ax is None else ax
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
        for axes in (ax, lower):
            fix_ticks(axes)
        lower.tick_params(axis="y", colors=GREEN)
        if is_alone:
            draw_legend(ax.figure, [ax, lower])
    return ax


def _times(proven: CertifiedRun) -> Floats:
    """Return times at and between the events, all of them certainly inside of what is proven."""
    low, high = proven.known_times
    if not proven.t_end.arb.is_finite():
        # At rest for ever, of which a little is shown.
        high += 0.06 * (high - low) or 1.0
    if not high > low:
        return np.array([low])
    pieces = np.array([float(piece.start) for piece in proven._record.pieces])
    inside = pieces[(pieces > low) & (pieces < high)]
    cuts = np.unique(np.concatenate([[low], inside, [high]]))
    # Of very many flights some are left out: they fill an area.
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
            size = max(LEAST_MARK, LARGEST_MARK * min(1.0, APART / len(balls)) ** 0.5)
            lower.plot(balls.mid(), log10_radii(balls), mark, color=BLACK, markersize=size,
                       label=f"of {name}s")  # fmt: skip


def _draw_rest(ax: Axes, proven: CertifiedRun, t: Floats) -> None:
    """Draw contacts as thick lines at their stop, and the touch at which a proof has ended."""
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
    """Give the upper part to the motion and the lower one to the radii, ticks only in their own."""
    low, high = ax.get_ylim()
    upper_part = 1.0 - RADII - FREE
    ax.set_ylim(high - (high - low) / upper_part, high)
    ax.set_yticks([tick for tick in MaxNLocator(5).tick_values(low, high) if low <= tick <= high])
    bottom, top = lower.get_ylim()
    # Less than a digit is no growth.
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
