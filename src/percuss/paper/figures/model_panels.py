"""Panels that show the impact limit and the paper's bilinear models one below the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from percuss.paper.figures.drawing import COLOURS, draw_curve, draw_motion, label, panels
from percuss.paper.models.motions import MODEL_LABELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

__all__ = ["portraits", "spectra", "time_panels"]

Panel = tuple[str, str, str]  # name of the run, colour's name, heading


def model_of(name: str) -> str:
    """Return which of the models a run of a figure is: "above_limit" is the limit."""
    return name.rsplit("_", maxsplit=1)[-1]


def heading(name: str, before: str = "") -> str:
    """Return the heading of a panel: what is particular, and the model."""
    return f"{before}{MODEL_LABELS[model_of(name)]}"


def time_panels(
    data: Dataset, names: Sequence[str], what: str, *, scale: float = 1.0, height: float = 1.65
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
    scale
        Unit of the time axis: 1 or pi.
    height
        Height of a panel [inch].
    """
    figure, axes = panels(len(names), height)
    values = [data[f"{what}_{name}"].values for name in names]
    low, high = (extreme(extreme(column) for column in values) for extreme in (min, max))
    room = 0.06 * (high - low)
    for ax, name in zip(axes, names, strict=True):
        draw_motion(ax, data, name, what, scale=scale, color=COLOURS[model_of(name)], linewidth=0.8)
        ax.set_ylabel("$x(t)$" if what == "x" else r"$\dot x(t)$")
        ax.set_xlim(0, float(data[f"t_{name}"].values[-1]) / scale)
        # One scale for all, so that they can be compared.
        ax.set_ylim(low if what == "x" else low - room, high + room)
    axes[-1].set_xlabel(r"$t/\pi$" if scale == math.pi else "$t$")
    return figure, axes


def portraits(
    data: Dataset, names: Sequence[str], headings: Sequence[str], *, columns: int = 2
) -> Picture:
    """Draw the phase portraits of runs."""
    figure, axes = panels(len(names), 2.2, columns=columns, share_x=False)
    for ax, name, text, letter in zip(axes, names, headings, "abcdef", strict=False):
        x, v = data[f"x_{name}"].values, data[f"v_{name}"].values
        ax.plot(x, v, color=COLOURS[model_of(name)], lw=0.5)
        ax.axvline(0.0, color="0.6", lw=0.6, zorder=0)
        ax.set(xlabel="$x$", ylabel=r"$\dot x$")
        label(ax, text, letter)
    return figure


def spectra(
    data: Dataset, names: Sequence[str], headings: Sequence[str], *, lowest: float
) -> Picture:
    """Draw power spectra on a logarithmic scale, with the resonant frequency 2 marked."""
    figure, axes = panels(len(names), 1.7)
    for ax, name, text, letter in zip(axes, names, headings, "abcdef", strict=False):
        omega, power = data[f"omega_{name}"].values, data[f"S_{name}"].values
        ax.axvline(2.0, color="0.45", lw=0.9, ls="--", zorder=0)
        kept = np.maximum(power, lowest * 1e-3)
        draw_curve(ax, omega, kept, color=COLOURS[model_of(name)], lw=0.7)
        ax.set(yscale="log", xlim=(0, omega[-1]), ylim=(lowest, 4 * power.max()))
        ax.set_ylabel(r"$S(\omega)$")
        label(ax, text, letter)
    axes[-1].set_xlabel(r"$\omega$")
    return figure
