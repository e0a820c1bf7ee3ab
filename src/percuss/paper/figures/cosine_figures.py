"""Figures 14 and 15: cosine forcing from rest, where the limit and the paper differ."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.harmonic_forces import cosine
from percuss.motion.half_harmonic import cosine_eigenset_motion
from percuss.motion.trajectory import Trajectory
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import draw_envelope, styled
from percuss.paper.figures.model_panels import time_panels
from percuss.paper.figures.printed_frames import FRAMES
from percuss.paper.figures.words import within
from percuss.paper.models.motions import (
    STEP_TOLERANCE,
    motion_dataset,
    simulate_all,
    step_columns,
    step_through,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

T_END = 900
PRINTED_FACTOR = {"v": 0.31, "x": 0.29}
NAMES = ("limit", "stiff", "soft", "steps")


def runs() -> dict[str, Trajectory]:
    """Return x'' + x = cos t from rest: the limit and both bilinear oscillators."""
    return simulate_all(cosine(1), 0, T_END)


@cache
def motions() -> Dataset:
    """Return the three motions, the second also by steps, and the limit's distance from (38)."""
    data = motion_dataset(runs(), v0=0.0)
    t = np.linspace(0.0, T_END, 90_001)
    closed, _ = cosine_eigenset_motion(t, 0.0)
    off = float(np.abs(runs()["limit"](t)[0] - closed).max())
    steps = step_columns("steps", step_through(cosine(1), 0, T_END))
    return data.assign(steps).assign_attrs(closed_form_error=off)


def _caption_velocity(data: Dataset) -> str:
    ends = [float(np.abs(data[f"v_{name}"].values).max()) for name in NAMES]
    last = [_last_speed(data, name) for name in NAMES]
    return (
        "Velocity under x'' + x = cos t from rest. (a) The exact limit does not grow: it repeats "
        "after 2π, is at rest on the wall at each 2πk and strikes it with π/2 in between (greatest "
        f"speed {ends[0]:.6f}), as (38) with V_0 = 0 says {within(data.closed_form_error)} to "
        f"t = {T_END}. The bilinear oscillator of the article does not keep to "
        "this motion: solved exactly, with 2e4 as the ratio of frequencies (b) and of "
        f"their squares (c), its greatest speeds are {ends[1]:.3f} and {ends[2]:.3f}, at the end "
        f"{last[1]:.3f} and {last[2]:.3f}; (b) computed as in the article by Runge-Kutta, here to a coarse "
        f"{STEP_TOLERANCE:g} a step (d), {ends[3]:.3f}, at the end {last[3]:.3f}. Dashed, the printed "
        f"{PRINTED_FACTOR['v']:g} sqrt t, {PRINTED_FACTOR['v'] * T_END**0.5:.2f} at the end."
    )


def _last_speed(data: Dataset, name: str) -> float:
    """Return the greatest speed in the last period of 2 pi."""
    t, v = data[f"t_{name}"].values, data[f"v_{name}"].values
    return float(np.abs(v[t > T_END - 2.0 * np.pi]).max())


def _caption_displacement(data: Dataset) -> str:
    ends = [float(data[f"x_{name}"].max()) for name in NAMES]
    return (
        "Displacement of the same motions. Greatest values to t = "
        f"{T_END}: (a) in the limit {ends[0]:.4f}, reached in every period of 2π; the bilinear "
        f"oscillator solved exactly (b), (c) {ends[1]:.3f} and {ends[2]:.3f}; by Runge-Kutta (d) "
        f"{ends[3]:.3f}. Dashed, the printed {PRINTED_FACTOR['x']:g} sqrt t."
    )


def _draw(data: Dataset, what: str) -> Picture:
    factor = PRINTED_FACTOR[what]
    (frame,) = FRAMES["fig15" if what == "x" else "fig14"]
    figure, axes = time_panels(data, NAMES, what, frame, envelope=factor * T_END**0.5)
    signs = (1,) if what == "x" else (1, -1)
    for ax in axes:
        draw_envelope(ax, T_END, factor, rf"${factor:g}\,\sqrt{{t}}$", signs=signs)
    axes[-1].legend(loc="upper left", handlelength=2.6)
    return figure


@styled
def _draw_velocity(data: Dataset) -> Picture:
    return _draw(data, "v")


@styled
def _draw_displacement(data: Dataset) -> Picture:
    return _draw(data, "x")


FIGURES = (
    Figure(
        "fig14",
        "Cosine forcing, velocity",
        _caption_velocity,
        motions,
        _draw_velocity,
        FRAMES["fig14"],
    ),
    Figure(
        "fig15",
        "Cosine forcing, displacement",
        _caption_displacement,
        motions,
        _draw_displacement,
        FRAMES["fig15"],
    ),
)
