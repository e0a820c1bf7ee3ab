"""The certified special points of a branch: where they are, and how wide their balls are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from percuss.errors import ParameterError
from percuss.orbits.bifurcations.branch import Branch
from percuss.plotting.branch_plot import plot_branch
from percuss.plotting.enclosed_orbit import log10_radii
from percuss.plotting.style import GREEN, GREY, Units, fix_ticks, new_figure, style

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import CertifiedPoint

__all__ = ["draw_certified_points"]

# How many characters of a number stand in the picture.
MOST_DIGITS = 15


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
    with style():
        if ax is None:
            ax = new_figure(8.0, 5.2).add_subplot()
        spec, figure = ax.get_subplotspec(), ax.get_figure()
        if spec is None or figure is None:
            raise ParameterError("ax", ax, "not a subplot of a figure")
        parts = spec.subgridspec(2, 1, height_ratios=(2.6, 1.0))
        ax.set_subplotspec(parts[0])
        lower = figure.add_subplot(parts[1], sharex=ax)
        plot_branch(branch, ax, units=units)
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
        lower.set_xlabel(branch.path)
        lower.set_ylabel("log$_{10}$ of radius", color=GREEN)
        fix_ticks(lower)
    return ax


def _write(ax: Axes, point: CertifiedPoint, place: tuple[float, float], k: int) -> None:
    """Write the number beside its mark, on the side where there is room."""
    low, high = ax.get_xlim()
    right = place[0] < 0.5 * (low + high)
    text = point.value.text(MOST_DIGITS) if point.value.radius() else f"{point.value.mid():.15g}"
    ax.annotate(text, place, (6.0 if right else -6.0, 4.0 + 9.0 * (k % 2)),
                textcoords="offset points", ha="left" if right else "right", fontsize="x-small")  # fmt: skip
