"""Pictures of fits: record, motion, impacts and residuals, what two parameters share, and profiles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from xarray import Dataset

from percuss.errors import ParameterError
from percuss.fitting.measured import quantity_dimensions
from percuss.fitting.result import Fit
from percuss.fitting.summaries import impacts_of, motion_of
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
    given_figure,
    shared_docs,
    style,
    units_of,
)

# Instants at which a motion is drawn, and of an ellipse.
POINTS, ROUND = 2000, 181
# Errors are small parts of values, whose labels are long.
MOST_TICKS = 3
# The sums of squares within which one and two parameters lie with 68 and 95 per cent.
PROFILE_LEVELS = ((1.0, "68 %"), (3.84, "95 %"))
ELLIPSES = ((2.2957, 0.35), (5.9915, 0.15))


@shared_docs
def plot_fit(
    fit: Fit,
    figure: Figure | None = None,
    *,
    record: int = 0,
    quantity: str | None = None,
    parameters: tuple[str, str] | None = None,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
) -> Figure:
    """Draw a fit: a record and the fitted motion, its impacts, the residuals, and an ellipse.

    Parameters
    ----------
    fit
        What `percuss.fit` has returned.
    record
        The number of the record, from 0.
    quantity
        What is drawn of the record; default: the first quantity that was measured.
    parameters
        The two parameters of the ellipse, by their paths; default: the first two.
    window
        First and last time that are drawn; default: the whole record.

    Returns
    -------
    Figure
        Above samples and motion of the fitted model; below the speeds of its impacts (of entries
        into soft stops open marks), and the residuals in standard deviations of the noise; beside
        these, for two parameters or more, the regions that hold both with 68 and 95 per cent, and
        each error alone.

    Raises
    ------
    ParameterError
        If it is no fit, or has no such record, quantity or parameter.
    """
    check_kind("fit", fit, Fit)
    units = units_of(units, fit.oscillator)
    rows = np.flatnonzero(fit.residuals.record.values == record)
    if not len(rows):
        n = 1 + int(fit.residuals.record.values.max())
        raise ParameterError("record", record, f"none of the {n} records, counted from 0")
    table = fit.residuals.isel(sample=rows)
    quantities = list(dict.fromkeys(table.quantity.values.tolist()))
    shown = quantities[0] if quantity is None else quantity
    if shown not in quantities:
        raise ParameterError("quantity", shown, f"none of those measured: {', '.join(quantities)}")
    pair = _pair(fit, parameters)
    table = table.isel(sample=np.flatnonzero(table.quantity.values == shown))
    with style(is_own=figure is None):
        figure = given_figure(figure, 10.0 if pair else 7.0, 5.8)
        ratios = [1.8, 1.0] if pair else [1.0]
        hits = impacts_of(fit)
        mine = hits["record"] == record
        heights = [2.4, 1.0, 1.0] if mine.any() else [2.2, 1.0]
        grid = figure.add_gridspec(
            len(heights), len(ratios), height_ratios=heights, width_ratios=ratios
        )
        above = figure.add_subplot(grid[0, 0])
        stacked = [above]
        _draw_record(fit, above, shown, record, table, window)
        if mine.any():
            middle = figure.add_subplot(grid[1, 0], sharex=above)
            _draw_impacts(middle, {name: column[mine] for name, column in hits.items()})
            speed = with_unit("impact\nspeed", "length/time", units)
            middle.set_ylabel(speed.removesuffix(" (dimensionless)"))
            stacked.append(middle)
        below = figure.add_subplot(grid[-1, 0], sharex=above)
        stacked.append(below)
        t, noise = table.t.values, table.noise.values
        name = "interval of impacts" if shown == "impact_times" else shown.replace("_", " ")
        above.set_ylabel(
            with_unit(f"{name}\n", quantity_dimensions(shown), units).replace("\n ", "\n")
        )
        below.axhspan(-1, 1, color=SKY_BLUE, alpha=0.3, linewidth=0)
        below.axhline(0, color=BLACK, linewidth=0.8)
        below.plot(t, table.residual.values / noise, ".", markersize=3, color=GREY)
        below.set_ylabel("residual\n($\\sigma$)")
        below.set_xlabel(with_unit("time", "time", units))
        if window is not None:
            above.set_xlim(*window)
        for ax in stacked[:-1]:
            ax.label_outer()
        figure.align_ylabels(stacked)
        if pair:
            beside = figure.add_subplot(grid[:, 1])
            _draw_ellipse(fit, beside, pair, units)
            beside.set_title("68 % and 95 %", fontsize=9.5)
        draw_legend(figure, stacked[:-1])
    return figure


@shared_docs
def plot_confidence(
    fit: Fit,
    figure: Figure | None = None,
    *,
    parameters: Sequence[str] | None = None,
    units: Units | None = None,
) -> Figure:
    """Draw the regions of confidence of all pairs of fitted parameters.

    Parameters
    ----------
    fit
        What `percuss.fit` has returned.
    parameters
        Their paths; default: all that have an error.

    Returns
    -------
    Figure
        A triangle of ellipses, which hold both parameters of a pair with 68 and 95 per cent, with
        the correlation of their errors above each.

    Raises
    ------
    ParameterError
        If it is no fit, has no such parameter, or fewer than two with an error.
    """
    check_kind("fit", fit, Fit)
    units = units_of(units, fit.oscillator)
    sure = _with_errors(fit)
    names = sure if parameters is None else [_fitted(fit, path) for path in parameters]
    if len(names) < 2:
        reason = f"{len(names)} with an error; a region of confidence needs two"
        raise ParameterError("parameters", parameters or list(fit.values), reason)
    for name in names:
        if name not in sure:
            raise ParameterError("parameters", name, "has no error; the data do not tell it")
    n = len(names) - 1
    with style(is_own=figure is None):
        figure = given_figure(figure, 1.4 + 2.4 * n, 0.8 + 2.2 * n)
        axes = figure.subplots(n, n, squeeze=False, sharex="col", sharey="row")
        for i, row in enumerate(axes):
            for j, ax in enumerate(row):
                if j > i:
                    ax.remove()
                    continue
                pair = names[j], names[i + 1]
                _draw_ellipse(fit, ax, pair, units)
                ax.set_title(f"correlation {_correlation(fit, pair):.2f}", fontsize=9.5)
                ax.label_outer()
        figure.align_labels()
    return figure


@shared_docs
def plot_profiles(
    fit: Fit,
    figure: Figure | None = None,
    *,
    parameters: Sequence[str] | None = None,
    n: int = 9,
    units: Units | None = None,
) -> Figure:
    """Draw profile likelihoods: how the misfit grows with a parameter, all others fitted anew.

    Parameters
    ----------
    fit
        What `percuss.fit` has returned.
    parameters
        Their paths; default: those whose profiles were asked for with `Fit.profile`, or else all
        that have an error.
    n
        Number of values of a profile that was not asked for yet.

    Returns
    -------
    Figure
        Of each parameter the profile, the parabola of its standard error, and the levels that hold
        it with 68 and 95 per cent.

    Raises
    ------
    ParameterError
        If it is no fit, has no such parameter, or none with an error.
    """
    check_kind("fit", fit, Fit)
    units = units_of(units, fit.oscillator)
    sure = _with_errors(fit)
    wanted = list(fit.profiles or sure) if parameters is None else list(parameters)
    if not wanted:
        raise ParameterError("fit", fit, "no parameter with an error; there are no profiles")
    names = [long_form(path, fit.oscillator, fit.forcing, fit.start) for path in wanted]
    profiles = [fit.profiles.get(name) or fit.profile(name, n=n) for name in names]
    with style(is_own=figure is None):
        width = 0.6 + 3.2 * len(names)
        figure = given_figure(figure, width, 3.4)
        axes = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
        for ax, name, profile in zip(axes, names, profiles, strict=True):
            at, error = fit.values[name], fit.errors[name]
            value = np.linspace(float(profile.value.min()), float(profile.value.max()), ROUND)
            ax.plot(value, ((value - at) / error) ** 2, "--", color=GREY, label="by its error")
            # Between its points as of a parabola: the signed root is a line.
            side = np.sign(profile.value.values - at)
            root = side * np.sqrt(np.maximum(profile.growth.values, 0.0))
            growth = np.interp(value, profile.value, root) ** 2
            ax.plot(value, growth, color=BLUE, label="profile")
            ax.plot(profile.value, profile.growth, "o", color=BLUE, markersize=4)
            for level, words in PROFILE_LEVELS:
                ax.axhline(level, color=BLACK, linewidth=0.8, linestyle=":")
                ax.annotate(
                    words, (1.0, level), xycoords=("axes fraction", "data"), ha="right",
                    xytext=(0, 2), textcoords="offset points", fontsize="small",
                )  # fmt: skip
            ax.set_xlabel(_label(fit, name, units))
            ax.set_ylim(bottom=-0.3)
            ax.xaxis.set_major_locator(MaxNLocator(MOST_TICKS))
            ax.ticklabel_format(axis="x", useOffset=False)
            fix_ticks(ax)
        axes[0].set_ylabel("growth of the misfit")
        draw_legend(figure, axes[:1])
    return figure


def _label(fit: Fit, path: str, units: Units) -> str:
    """Return the label of a parameter; one with a name of its own has that alone."""
    return label_of(fit.oscillator, fit.forcing, path, units) if "." in path else path


def _pair(fit: Fit, parameters: tuple[str, str] | None) -> tuple[str, str] | None:
    """Return the two parameters of the ellipse; None if there is none."""
    if parameters is not None:
        return _fitted(fit, parameters[0]), _fitted(fit, parameters[1])
    sure = _with_errors(fit)
    return (sure[0], sure[1]) if len(sure) > 1 else None


def _with_errors(fit: Fit) -> list[str]:
    """Return the parameters that the data tell."""
    return [path for path, error in fit.errors.items() if 0.0 < error < math.inf]


def _fitted(fit: Fit, path: str) -> str:
    """Return the long form of the path of a fitted parameter."""
    name = long_form(path, fit.oscillator, fit.forcing, fit.start)
    if name not in fit.values:
        raise ParameterError("parameters", path, "none of the fitted parameters")
    return name


def _correlation(fit: Fit, pair: tuple[str, str]) -> float:
    """Return the correlation of the errors of two parameters."""
    i, j = (list(fit.values).index(path) for path in pair)
    return float(fit.covariance[i, j] / math.sqrt(fit.covariance[i, i] * fit.covariance[j, j]))


def _draw_record(
    fit: Fit,
    ax: Axes,
    quantity: str,
    record: int,
    table: Dataset,
    window: tuple[float, float] | None,
) -> None:
    """Draw samples and the motion; of impact times the flights between them."""
    t, values, fitted = table.t.values, table.value.values, table.fitted.values
    begin, end = (float(t[0]), float(t[-1])) if window is None else window
    if quantity == "impact_times":
        flights = np.diff(values)
        ax.plot(values[1:], flights, ".", color=GREY, markersize=5, label="measured intervals")
        ax.plot(fitted[1:], np.diff(fitted), "-", color=BLUE, label="fit")
        return
    ax.plot(t, values, ".", color=GREY, markersize=3, label="samples")
    layout = fit.problem.layouts[record]
    first, last = float(layout.spans[0, 0]), float(layout.spans[-1, 1])
    times = np.linspace(max(begin, first), min(end, last), POINTS)
    ax.plot(times, motion_of(fit, quantity, times, record), color=BLUE, linewidth=1.0, label="fit")


def _draw_impacts(ax: Axes, hits: Mapping[str, Any]) -> None:
    """Draw the speed of each impact of the model, of entries into soft stops as open marks."""
    speeds, is_entry = np.abs(hits["v_before"]), hits["kind"] == "entry"
    ax.vlines(hits["t"], 0.0, speeds, color=VERMILION, linewidth=0.8)
    marks: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 3.5, "color": VERMILION}
    for some, fill, label in (
        (~is_entry, "full", "impacts of the model"),
        (is_entry, "none", "entries into soft stops"),
    ):
        if some.any():
            ax.plot(hits["t"][some], speeds[some], fillstyle=fill, label=label, **marks)
    ax.set_ylim(bottom=0.0)


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
    ax.set_xlabel(_label(fit, pair[0], units))
    ax.set_ylabel(_label(fit, pair[1], units))
    ax.xaxis.set_major_locator(MaxNLocator(MOST_TICKS))
    ax.ticklabel_format(useOffset=False)
    fix_ticks(ax)
