"""Impact velocity against gap of single-impact orbits: the ellipses of Budd and Dux."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from percuss.errors import ParameterError
from percuss.orbits.responses.velocity_gap import VelocityGap
from percuss.plotting.response_plot import COLOURS, FORMAL, MARK, MARKERS, STABLE, UNSTABLE
from percuss.plotting.style import BLACK, Units, axes_for, fix_ticks, style, units_of

__all__ = ["plot_velocity_gap"]


def plot_velocity_gap(
    curves: VelocityGap | Sequence[VelocityGap],
    ax: Axes | None = None,
    *,
    units: Units | None = None,
) -> Axes:
    """Draw impact velocity against gap: stable orbits solid, unstable dashed, formal faint.

    Parameters
    ----------
    curves
        One or several that `percuss.velocity_gap_curve` has returned.
    ax
        Axes to draw on; default: those of a new figure.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; folds and grazes are marked, each curve is labelled (1, forcing periods).

    Raises
    ------
    ParameterError
        If there is no curve.
    """
    several = [curves] if isinstance(curves, VelocityGap) else list(curves)
    if not several:
        raise ParameterError("curves", curves, "no curve to draw")
    units = units_of(units)
    with style():
        ax = axes_for(ax)
        for curve in several:
            _draw(ax, curve)
        ax.axvline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        ax.set_ylim(bottom=0.0)
        ax.set_xlabel(f"gap, from the equilibrium to the wall ({units.displacement})")
        ax.set_ylabel(f"impact velocity ({units.velocity})")
        _explain(ax)
        fix_ticks(ax)
    return ax


def _draw(ax: Axes, curve: VelocityGap) -> None:
    colour = COLOURS[(curve.n_periods - 1) % len(COLOURS)]
    # The grazes at the ends are no orbits: there the row beside them tells.
    physical = np.concatenate([curve.admissible[1:2], curve.admissible[2:-1], [False]])
    physical[-1] = curve.admissible[-2]
    stable = curve.is_stable[1:].copy()
    stable[-1] = curve.is_stable[-2]
    looks = (
        (physical & stable, STABLE, 2.0),
        (physical & ~stable, UNSTABLE, 1.8),
        (~physical, FORMAL, 1.0),
    )
    for which, look, order in looks:
        x, y = curve.gap.copy(), curve.velocity.copy()
        hidden = np.ones(len(x), dtype=np.bool_)
        hidden[:-1] &= ~which
        hidden[1:] &= ~which
        x[hidden] = np.nan
        ax.plot(x, y, color=colour, zorder=order, **look)
    top = int(np.argmax(curve.velocity))
    ax.plot([curve.fold], [curve.fold_velocity], MARKERS["fold"], zorder=3.0, **_without_line())
    ax.plot([-curve.graze, curve.graze], [0.0, 0.0], MARKERS["grazing"], zorder=3.0,
            clip_on=False, **_without_line())  # fmt: skip
    ax.annotate(
        f"(1, {curve.n_periods})",
        (float(curve.gap[top]), float(curve.velocity[top])),
        xytext=(0.0, 6.0),
        textcoords="offset points",
        ha="center",
        fontsize=9.0,
        color=colour,
    )


def _without_line() -> dict[str, Any]:
    return {name: value for name, value in MARK.items() if name != "linestyle"}


def _explain(ax: Axes) -> None:
    looks = (("stable", STABLE), ("unstable", UNSTABLE), ("passes through the wall", FORMAL))
    handles = [Line2D([], [], color=BLACK, label=text, **look) for text, look in looks]
    for kind, text in (("fold", "fold"), ("grazing", "impact without velocity")):
        handles.append(Line2D([], [], label=text, **MARK | {"marker": MARKERS[kind]}))
    ax.legend(handles=handles, loc="best", fontsize=8.5, labelspacing=0.3)
