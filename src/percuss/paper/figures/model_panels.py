"""Panels that show the impact limit and the paper's bilinear models one below the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from percuss.paper.figure import PrintedFrame
from percuss.paper.figures.drawing import (
    COLOURS,
    draw_curve,
    draw_frame,
    draw_motion,
    label,
    panels,
    reach,
)
from percuss.paper.models.motions import MODEL_LABELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset


def model_of(name: str) -> str:
    """Return which of the models a run of a figure is: "above_limit" is the limit."""
    return name.rsplit("_", maxsplit=1)[-1]


def heading(name: str, before: str = "") -> str:
    """Return the heading of a panel: what is particular, and the model."""
    return f"{before}{MODEL_LABELS[model_of(name)]}"


def time_panels(
    data: Dataset,
    names: Sequence[str],
    what: str,
    frame: PrintedFrame,
    *,
    more: int = 0,
    envelope: float = 0.0,
    height: float = 1.65,
) -> tuple[Picture, list[Axes]]:
    """Draw the displacement ("x") or velocity ("v") of runs over time, one below the other.

    Parameters
    ----------
    data
        A `motion_dataset`.
    names
        The runs.
    what
        "x" or "v".
    frame
        The printed frame of each.
    more
        How many panels are left empty below.
    envelope
        Greatest value of an envelope, to be shown too.
    height
        Height of a panel [inch].
    """
    # A stop that yields is entered by less than can be seen.
    low = 0.0 if what == "x" else -math.inf
    figure, axes = panels(len(names) + more, height)
    values = np.concatenate([data[f"{what}_{name}"].values for name in names])
    values = np.concatenate([np.maximum(values, low), [envelope]])
    for ax, name in zip(axes, names, strict=False):
        draw_motion(ax, data, name, what, color=COLOURS[model_of(name)], linewidth=0.6)
        ax.set_ylabel("$x(t)$" if what == "x" else r"$\dot x(t)$")
        # One scale for all, so that they can be compared.
        draw_frame(ax, frame, y=reach(values, frame.upwards))
        ax.tick_params(axis="y", labelsize=8.0)
        label(ax, heading(name), "abcd"[names.index(name)])
    axes[-1].set_xlabel("$t$")
    return figure, axes


def portraits(
    data: Dataset,
    names: Sequence[str],
    headings: Sequence[str],
    frame: PrintedFrame,
    until: float,
) -> Picture:
    """Draw the phase portraits of runs in the printed frame, two in a row.

    Parameters
    ----------
    data
        A `motion_dataset`.
    names, headings
        The runs, and what stands above them.
    frame
        The printed frame.
    until
        The time until which the motion is drawn; later loops are shown in light grey where they
        end inside the frame.
    """
    figure, axes = panels(len(names), 3.0, columns=2, share_x=False)
    x_shown = reach([frame.across[0], 1.1 * frame.across[1]], frame.across)
    for ax, name, text, letter in zip(axes, names, headings, "abcdef", strict=False):
        t, x, v = (data[f"{what}_{name}"].values for what in "txv")
        if x.max() < frame.across[1] + frame.x[1] - frame.x[0]:
            ax.plot(x[t >= until], v[t >= until], color="0.75", lw=0.4)
        ax.plot(x[t <= until], v[t <= until], color=COLOURS[model_of(name)], lw=0.6)
        draw_frame(ax, frame, x=x_shown, y=reach([-6.5, 6.5], frame.upwards), note=False)
        ax.set(xlabel="$x$", ylabel=r"$\dot x$")
        label(ax, text, letter)
    return figure


def spectra(
    data: Dataset, names: Sequence[str], headings: Sequence[str], frames: Sequence[PrintedFrame]
) -> Picture:
    """Draw power spectra in their printed frames, with the resonant frequency 2 marked.

    In grey the same under a Hann window. All panels show the decades of the tallest frame.
    """
    figure, axes = panels(len(names), 1.9)
    # S(0) lies up to a decade above the highest number, less than a printed step.
    decades = min(frame.upwards[0] for frame in frames), 10.0 * frames[0].upwards[1]
    for ax, name, text, frame, letter in zip(axes, names, headings, frames, "abcd", strict=False):
        omega = data[f"omega_{name}"].values
        ax.axvline(2.0, color="0.45", lw=0.9, ls="--", zorder=0)
        for what, colour, width in (("smooth", "0.62", 0.6), ("S", COLOURS[model_of(name)], 0.8)):
            kept = np.maximum(data[f"{what}_{name}"].values, decades[0] * 1e-3)
            draw_curve(ax, omega, kept, color=colour, lw=width)
        ax.set(yscale="log")
        draw_frame(ax, frame, y=decades)
        ax.set_yticks(max((one.y for one in frames), key=len))
        ax.set_ylabel(r"$S(\omega)$")
        label(ax, text, letter)
    axes[-1].set_xlabel(r"$\omega$")
    return figure
