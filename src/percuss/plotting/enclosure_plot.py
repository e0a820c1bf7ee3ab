"""A certified motion over time, and below it how wide its proven enclosure is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from percuss.errors import ParameterError
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
    from percuss.certified import Balls, CertifiedRun

__all__ = ["plot_enclosure"]

Floats = npt.NDArray[np.float64]

# Points of the curve, some 30 microseconds each, and how many of them between two events.
MOST_POINTS, MOST_BETWEEN = 6000, 48
# Size of a mark [point], and how many events keep marks of the largest size apart.
LARGEST_MARK, LEAST_MARK, APART = 3.5, 1.0, 50
# Parts of the height: of the radii below, and free between them and the motion.
RADII, FREE = 0.36, 0.06
LOG10_2 = float(np.log10(2.0))


def plot_enclosure(
    proven: CertifiedRun, ax: Axes | None = None, *, units: Units | None = None
) -> Axes:
    """Draw a certified motion over time, and below it the logarithm of its proven radius.

    The radii are those of the balls, far below what a float can tell: a straight rise is an error
    that grows exponentially, as in chaos.

    Parameters
    ----------
    proven
        What `percuss.certify` has returned for a run.
    ax
        Axes to draw on; default: those of a new figure.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes of the motion, in their upper part; those of the radii share their time and have
        their scale on the right, and an event is marked at the radius of its time. Axes of a new
        figure have a legend.

    Raises
    ------
    ParameterError
        If it is no certified run.
    MissingExtraError
        If python-flint is not there.
    """
    from percuss.certified import CertifiedRun

    if not isinstance(proven, CertifiedRun):
        reason = "not a certified run; percuss.certify(run) makes one"
        raise ParameterError("proven", proven, reason)
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
    lower.plot(t, _log10_radii(x), color=GREEN, linewidth=1.0, label="radius of $x$")
    events = (("o", "impact", proven.impacts.t), ("x", "crossing", proven.crossings.t))
    for mark, name, balls in events:
        if len(balls):
            size = max(LEAST_MARK, LARGEST_MARK * min(1.0, APART / len(balls)) ** 0.5)
            lower.plot(balls.mid(), _log10_radii(balls), mark, color=BLACK, markersize=size,
                       label=f"of {name}s")  # fmt: skip


def _log10_radii(balls: Balls) -> Floats:
    """Return log10 of the radii, also of those far below the least float; NaN where it is 0."""
    found = np.full(len(balls), np.nan)
    for i, ball in enumerate(balls.arbs):
        radius = ball.rad()
        if ball.is_finite() and not radius.is_zero():
            mantissa, exponent = radius.man_exp()
            found[i] = float(np.log10(float(int(mantissa)))) + int(exponent) * LOG10_2
    return found


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
