"""Pictures of fits: the record with the fitted motion, the residuals, and what two parameters share."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from percuss.arrays import Floats
from percuss.ensembles.grid import units_of as dimensions_of
from percuss.errors import ParameterError
from percuss.fitting.result import Fit
from percuss.model.paths import long_form
from percuss.model.units import Units
from percuss.plotting.labels import label_of, with_unit
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    SKY_BLUE,
    VERMILION,
    check_kind,
    draw_legend,
    fix_ticks,
    new_figure,
    style,
    units_of,
)

__all__ = ["plot_fit"]

# Instants at which a motion is drawn, and of an ellipse.
POINTS, ROUND = 2000, 181
# The sums of squares within which one and two parameters lie with 68 and 95 per cent.
ELLIPSES = ((2.2957, 0.35), (5.9915, 0.15))
DIMENSIONS = {
    "displacement": "length",
    "velocity": "length/time",
    "acceleration": "length/time^2",
    "impact_times": "time",
}


def plot_fit(
    fit: Fit,
    figure: Figure | None = None,
    *,
    quantity: str | None = None,
    parameters: tuple[str, str] | None = None,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Figure:
    """Draw a fit: the first record and the fitted motion, the residuals, and a confidence ellipse.

    Parameters
    ----------
    fit
        What `percuss.fit` has returned.
    figure
        An empty figure; default: a new one.
    quantity
        What is drawn of the record; default: the first quantity that was measured.
    parameters
        The two parameters of the ellipse, by their paths; default: the first two.
    window
        First and last time that are drawn; default: the whole record.
    units
        Units on the axes; default: those of the oscillator, or dimensionless.

    Returns
    -------
    Figure
        Above samples, motion and impacts of the fitted model (as marks at the bottom); below the
        residuals in standard deviations of the noise; beside these, for two parameters or more, the
        regions that hold both with 68 and 95 per cent, and each error alone.

    Raises
    ------
    ParameterError
        If it is no fit, or has no such quantity or parameter.
    """
    check_kind("fit", fit, Fit)
    units = units_of(units, fit.oscillator)
    table = fit.residuals.isel(sample=np.flatnonzero(fit.residuals.record.values == 0))
    there = list(dict.fromkeys(table.quantity.values.tolist()))
    shown = there[0] if quantity is None else quantity
    if shown not in there:
        raise ParameterError("quantity", shown, f"none of those measured: {', '.join(there)}")
    pair = _pair(fit, parameters)
    table = table.isel(sample=np.flatnonzero(table.quantity.values == shown))
    with style():
        figure = new_figure(10.0 if pair else 7.0, 4.6) if figure is None else figure
        ratios = [1.8, 1.0] if pair else [1.0]
        grid = figure.add_gridspec(2, len(ratios), height_ratios=[2.0, 1.0], width_ratios=ratios)
        above = figure.add_subplot(grid[0, 0])
        below = figure.add_subplot(grid[1, 0], sharex=above)
        t, noise = table.t.values, table.noise.values
        _draw_record(fit, above, shown, t, table.value.values, window)
        above.set_ylabel(with_unit(shown.replace("_", " "), _dimensions(shown), units))
        below.axhspan(-1, 1, color=SKY_BLUE, alpha=0.3, linewidth=0)
        below.axhline(0, color=BLACK, linewidth=0.8)
        below.plot(t, table.residual.values / noise, ".", markersize=3, color=GREY)
        below.set_ylabel("residual ($\\sigma$)")
        below.set_xlabel(with_unit("time", "time", units))
        if window is not None:
            above.set_xlim(*window)
        above.label_outer()
        figure.align_ylabels([above, below])
        if pair:
            _draw_ellipse(fit, figure.add_subplot(grid[:, 1]), pair, units)
        draw_legend(figure, [above])
    return figure


def _dimensions(quantity: str) -> str:
    return DIMENSIONS.get(quantity, "mass length/time^2")


def _pair(fit: Fit, parameters: tuple[str, str] | None) -> tuple[str, str] | None:
    """Return the two parameters of the ellipse; None if there is none."""
    if parameters is not None:
        first, second = (
            long_form(path, fit.oscillator, fit.forcing, fit.start) for path in parameters
        )
        for name, path in ((first, parameters[0]), (second, parameters[1])):
            if name not in fit.values:
                raise ParameterError("parameters", path, "none of the fitted parameters")
        return first, second
    sure = [path for path, error in fit.errors.items() if 0.0 < error < math.inf]
    return (sure[0], sure[1]) if len(sure) > 1 else None


def _draw_record(
    fit: Fit, ax: Axes, quantity: str, t: Floats, values: Floats, window: tuple[float, float] | None
) -> None:
    """Draw samples and the motion; of impact times the flights between them."""
    begin, end = (float(t[0]), float(t[-1])) if window is None else window
    if quantity == "impact_times":
        flights = np.diff(values)
        ax.plot(values[1:], flights, ".", color=GREY, markersize=5, label="measured intervals")
        fitted = fit.residuals.fitted.values[fit.residuals.record.values == 0]
        ax.plot(fitted[1:], np.diff(fitted), "-", color=BLUE, label="fit")
        return
    ax.plot(t, values, ".", color=GREY, markersize=3, label="samples")
    first, last = float(fit.nodes[0, 0]), float(fit.problem.layouts[0].spans[-1, 1])
    times = np.linspace(max(begin, first), min(end, last), POINTS)
    ax.plot(times, fit.of(quantity, times), color=BLUE, linewidth=1.0, label="fit")
    hits = fit.impacts[(fit.impacts >= begin) & (fit.impacts <= end)]
    low = ax.get_ylim()[0]
    marks = {"linestyle": "", "marker": "|", "markersize": 7, "color": VERMILION}
    ax.plot(hits, np.full(len(hits), low), label="impacts of the model", clip_on=False, **marks)  # type: ignore[arg-type]
    ax.set_ylim(bottom=low)


def _draw_ellipse(fit: Fit, ax: Axes, pair: tuple[str, str], units: Units) -> None:
    """Draw the regions of two parameters, and the error of each."""
    paths = list(fit.values)
    i, j = (paths.index(path) for path in pair)
    covariance = fit.covariance[np.ix_([i, j], [i, j])]
    x, y = fit.values[pair[0]], fit.values[pair[1]]
    across = math.sqrt(covariance[0, 0])
    slope = covariance[0, 1] / across
    rest = math.sqrt(max(covariance[1, 1] - slope * slope, 0.0))
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND)
    for square, shade in reversed(ELLIPSES):
        size = math.sqrt(square)
        cosine, sine = size * np.cos(turn), size * np.sin(turn)
        ax.fill(
            x + across * cosine,
            y + slope * cosine + rest * sine,
            color=BLUE,
            alpha=shade,
            linewidth=0,
        )
    ax.errorbar(
        [x], [y], xerr=[fit.errors[pair[0]]], yerr=[fit.errors[pair[1]]], fmt="o", color=BLACK,
        markersize=4, capsize=3,
    )  # fmt: skip
    ax.set_xlabel(label_of(pair[0], dimensions_of(pair[0], fit.oscillator, fit.forcing), units))
    ax.set_ylabel(label_of(pair[1], dimensions_of(pair[1], fit.oscillator, fit.forcing), units))
    ax.set_title("68 % and 95 %", fontsize=9.5)
    fix_ticks(ax)
