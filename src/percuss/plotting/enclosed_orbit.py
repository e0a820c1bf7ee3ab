"""A certified orbit: its phase portrait, the radius along it, and its multipliers as balls."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from percuss.errors import ParameterError
from percuss.plotting.jumps import draw_jumps
from percuss.plotting.stops import draw_stops, stop_places
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    VERMILION,
    Units,
    draw_legend,
    fix_ticks,
    new_figure,
    style,
)

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import Balls, CertifiedOrbit, ComplexBall

__all__ = ["draw_certified_orbit", "log10_radii"]

Floats = npt.NDArray[np.float64]

# Points of each flight.
POINTS = 160
LOG10_2 = float(np.log10(2.0))
# Multipliers are drawn up to here, and balls no smaller than this part of the picture.
MOST, LEAST = 3.0, 0.025


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
    times = _times(proven)
    x, v = proven(np.concatenate(times))
    ends = np.cumsum([len(part) for part in times])[:-1]
    with style():
        is_alone = ax is None
        ax = new_figure(9.0, 4.4).add_subplot() if ax is None else ax
        upper, lower = _beside(ax)
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
        _draw_radii(lower, times, (x, v), units)
        _draw_multipliers(upper, proven)
        for axes in (ax, upper, lower):
            fix_ticks(axes)
        if is_alone:
            draw_legend(ax.figure, [ax, lower])
    return ax


def _title(proven: CertifiedOrbit) -> str:
    known = {
        True: "passes through no stop",
        False: "passes through a stop",
        None: "may pass through a stop",
    }
    alone = "alone with these events" if proven.isolated else "one of a family"
    stability = proven.stability
    if stability == "undecided":
        stability = "stability undecided"
    return f"proven: {alone}, {known[proven.admissible]}, {stability}"


def _beside(ax: Axes) -> tuple[Axes, Axes]:
    """Give the right part of the axes to two others, one above the other."""
    figure, spec = ax.get_figure(), ax.get_subplotspec()
    assert figure is not None
    if spec is None:
        return ax.inset_axes((1.25, 0.55, 0.7, 0.45)), ax.inset_axes((1.25, 0.0, 0.7, 0.4))
    parts = spec.subgridspec(1, 2, width_ratios=(1.35, 1.0))
    ax.set_subplotspec(parts[0])
    right = parts[1].subgridspec(2, 1, height_ratios=(1.35, 1.0))
    return figure.add_subplot(right[0]), figure.add_subplot(right[1])


def _times(proven: CertifiedOrbit) -> list[Floats]:
    """Return times of each flight, inside of it for certain."""
    period, first = proven.period.mid(), proven.t0.mid()
    states = proven._motion.states if proven._motion is not None else []
    cuts = np.array([float(t) for t, _ in states] or [first])
    cuts = np.append(cuts, cuts[0] + period)
    parts = []
    for low, high in itertools.pairwise(cuts):
        inset = 1e-7 * (high - low)
        parts.append(np.linspace(low + inset, high - inset, POINTS))
    return parts


def log10_radii(balls: Balls) -> Floats:
    """Return log10 of the radii, also of those far below the least float; NaN where it is 0."""
    found = np.full(len(balls), np.nan)
    for i, ball in enumerate(balls.arbs):
        radius = ball.rad()
        if ball.is_finite() and not radius.is_zero():
            mantissa, exponent = radius.man_exp()
            found[i] = float(np.log10(float(int(mantissa)))) + int(exponent) * LOG10_2
    return found


def _draw_radii(ax: Axes, times: list[Floats], balls: tuple[Balls, Balls], units: Units) -> None:
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
    """Return how far a number can be from the middle of its ball."""
    value = ball.acb
    return float(np.hypot(float(value.real.rad()), float(value.imag.rad())) * (1.0 + 1e-12))


def _draw_multipliers(ax: Axes, proven: CertifiedOrbit) -> None:
    """Draw the unit circle and the multipliers, with their radii in words."""
    values = [ball.mid() for ball in proven.multipliers]
    radii = [_radius(ball) for ball in proven.multipliers]
    far = max([1.0, *(max(abs(value.real), abs(value.imag)) for value in values)])
    edge = 1.25 * min(far, MOST)
    ax.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GREY, linewidth=1.0, zorder=1.0))
    for draw in (ax.axhline, ax.axvline):
        draw(0.0, color=GREY, linewidth=0.5, zorder=0.5)
    for value, radius in zip(values, radii, strict=True):
        outside = abs(value) - radius > 1.0
        colour = VERMILION if outside else BLUE if abs(value) + radius < 1.0 else BLACK
        shown = complex(np.clip(value.real, -edge, edge), np.clip(value.imag, -edge, edge))
        size = max(radius, LEAST * edge)
        ax.add_patch(Circle((shown.real, shown.imag), size, color=colour, zorder=3.0))
        if shown != value:
            ax.annotate(f"{value.real:.3g}", (shown.real, shown.imag), (0.0, 6.0),
                        textcoords="offset points", ha="right", fontsize="small")  # fmt: skip
    ax.set_xlim(-edge, edge)
    ax.set_ylim(-edge, edge)
    ax.set_aspect("equal")
    largest = max(radii)
    ax.set_xlabel(f"multipliers, radius at most {largest:.0e}" if largest else "multipliers, exact")
