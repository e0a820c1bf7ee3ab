"""Figures 3, 4 and A1: the family of motions whose impact times are Y_m."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Floats
from percuss.model.oscillator import impact_oscillator
from percuss.motion.eigenset_forms import (
    SubsetMotion,
    subset_critical_velocity,
    subset_forcing,
)
from percuss.motion.simulate import simulate
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import (
    COLOURS,
    draw_curve,
    draw_frame,
    label,
    panels,
    reach,
    styled,
)
from percuss.paper.figures.printed_frames import FRAMES
from percuss.paper.figures.words import within
from percuss.paper.models.motions import motion_dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

VELOCITIES = {"rest": 0.0, "middle": 0.5, "fast": 2.0 / math.sqrt(3.0)}
VELOCITY_LABELS = {"rest": "$V_0=0$", "middle": "$V_0=0.5$", "fast": r"$V_0=2/\sqrt{3}$"}
LOOKS = {"rest": COLOURS["limit"], "middle": COLOURS["stiff"], "fast": COLOURS["soft"]}


def _motions(m: int, periods: int) -> Dataset:
    """Return the motions from the three velocities, and how far they are from (11) and Y_m."""
    t_end = periods * (m + 1) * math.pi
    # A little beyond the last impact, which rounding may put on either side of the end.
    runs = {
        name: simulate(impact_oscillator(), subset_forcing(m), x0=0, v0=v0, t_end=t_end + 0.01)
        for name, v0 in VELOCITIES.items()
    }
    t = np.linspace(0.0, t_end, 20_001)
    times, motion = [], []
    for name, v0 in VELOCITIES.items():
        form = SubsetMotion(m, v0)
        # With V0 = 0 or V*(m) some impacts have no velocity: the simulation lists them as grazes.
        instants = np.sort(np.concatenate([runs[name].impacts.t, runs[name].grazes.t]))
        times.append(_distance(instants, form.impact_times(2 * periods)))
        motion.append(float(np.abs(form(t)[0] - runs[name](t)[0]).max()))
    columns = {"time_error": ("velocity", times), "motion_error": ("velocity", motion)}
    data = motion_dataset(runs, m=m, critical_velocity=subset_critical_velocity(m))
    return data.assign(columns).assign_coords(velocity=list(VELOCITIES.values()))


def _distance(found: Floats, expected: Floats) -> float:
    """Return the largest difference of two sets of times; infinite if one has more than the other.

    A touch may be listed twice, from either side: times closer than 1e-6 count once.
    """
    distinct = found[np.diff(found, prepend=-math.inf) > 1e-6]
    if distinct.size != expected.size:
        return math.inf
    return float(np.abs(distinct - expected).max())


def _caption_family(data: Dataset) -> str:
    m = int(data.m)
    period = SubsetMotion(m, 0.5).period / math.pi
    return (
        f"The example for m = {m}, simulated under the force x'' + x of (11), from V0 = 0, 0.5 and "
        f"2/√3. The impact times are those of Y_{m} {within(float(data.time_error.max()))}, and "
        f"the motion is (11) {within(float(data.motion_error.max()))}, with the amplitude A = V0 - "
        f"q on the long flights; the period is {period:g}π. The greatest velocity of the family, "
        f"V*({m}), is {data.critical_velocity:.12f}. Dots: the impact times."
    )


@styled
def _draw_family(data: Dataset) -> Picture:
    m = int(data.m)
    figure, (ax,) = panels(1, 3.3)
    for name, text in VELOCITY_LABELS.items():
        t, x = data[f"t_{name}"].values, data[f"x_{name}"].values
        draw_curve(ax, t / math.pi, x, color=LOOKS[name], label=text)
    (frame,) = FRAMES[f"fig{m + 1}"]
    last = round(frame.across[1])
    times = SubsetMotion(m, 0).impact_times(last) / math.pi
    times = times[times <= last]
    ax.plot(times, np.zeros_like(times), "o", color="black", ms=4, clip_on=False, zorder=3)
    x = np.concatenate([data[f"x_{name}"].values for name in VELOCITY_LABELS])
    draw_frame(ax, frame, y=reach(np.maximum(x, 0.0), frame.upwards))
    ax.set(xlabel=r"$t/\pi$", ylabel="displacement $x_*(t)$")
    # Beside the words on the right, above the axes too.
    ax.legend(ncols=3, loc="upper left", bbox_to_anchor=(-0.03, 1.12), columnspacing=1.2)
    return figure


def touching_curves() -> Dataset:
    """Return u(t) and w(t) of figure A1, whose contact limits the initial velocity."""
    import xarray as xr

    data: dict[str, object] = {}
    attrs: dict[str, float] = {}
    for m, v0 in ((2, 1.2), (3, 2.0)):
        # u = A sin t with the amplitudes (13), q being the velocity of -w at t = 0.
        q = 2.0 / (m + 1) * math.sin(math.pi / (m + 1))
        amplitudes = (v0 - q, -v0 + q * (1.0 + 2.0 * (-1.0) ** m))
        # Both limits at m pi, where u changes its amplitude.
        flights = [np.linspace(0.0, m, 301) * math.pi, np.linspace(m, m + 1, 101) * math.pi]
        u = np.concatenate([a * np.sin(t) for a, t in zip(amplitudes, flights, strict=True)])
        t = np.concatenate(flights)
        w = np.cos((2.0 * t + math.pi) / (m + 1)) - math.cos(math.pi / (m + 1))
        point = f"m{m}_point"
        data |= {f"t_m{m}": (point, t), f"u_m{m}": (point, u), f"w_m{m}": (point, w)}
        attrs[f"v0_m{m}"] = v0
        attrs[f"critical_velocity_m{m}"] = subset_critical_velocity(m)
        attrs[f"least_gap_m{m}"] = float((u - w)[np.abs(np.sin(t)) > 1e-3].min())
    return xr.Dataset(data, attrs=attrs)


def _caption_curves(data: Dataset) -> str:
    parts = []
    for m in (2, 3):
        gap = data.attrs[f"least_gap_m{m}"]
        verdict = "u stays above w" if gap > 0 else f"u falls below w by up to {-gap:.4f}"
        limit = data.attrs[f"critical_velocity_m{m}"]
        v0 = data.attrs[f"v0_m{m}"]
        parts.append(f"m = {m}, V0 = {v0:g} against V*({m}) = {limit:.6f}: {verdict}")
    return (
        "The motion (11) is x = u - w; it is valid while u(t) = A sin t stays at or above "
        f"w(t). {'; '.join(parts)}. Where u falls below w the oscillator has hit the wall before, "
        "and its impact times are no longer Y_m."
    )


@styled
def _draw_curves(data: Dataset) -> Picture:
    figure, axes = panels(2, 2.3, share_x=False)
    for ax, m, frame in zip(axes, (2, 3), FRAMES["figA1"], strict=True):
        t = data[f"t_m{m}"].values / math.pi
        u, w = data[f"u_m{m}"].values, data[f"w_m{m}"].values
        ax.plot(t, u, color=COLOURS["limit"], label="$u(t)$")
        ax.plot(t, w, color=COLOURS["stiff"], label="$w(t)$")
        ax.fill_between(t, u, w, where=u < w, color=COLOURS["stiff"], alpha=0.3, lw=0)
        ax.axhline(0, color="0.6", linewidth=0.6)
        draw_frame(ax, frame, x=(0.0, m + 1.0), y=reach([u, w], frame.upwards))
        ax.set(xlabel=r"$t/\pi$", ylabel="$u$, $w$")
        label(ax, f"$m={m}$, $V_0={data.attrs[f'v0_m{m}']:g}$", frame.panel)
        ax.legend(loc="lower left" if m == 2 else "lower right")
    return figure


FIGURES = (
    Figure(
        "fig3",
        "The example, m = 2",
        _caption_family,
        partial(_motions, 2, 2),
        _draw_family,
        FRAMES["fig3"],
    ),
    Figure(
        "fig4",
        "The example, m = 3",
        _caption_family,
        partial(_motions, 3, 2),
        _draw_family,
        FRAMES["fig4"],
    ),
    Figure(
        "figA1",
        "The curves that give V*",
        _caption_curves,
        touching_curves,
        _draw_curves,
        FRAMES["figA1"],
    ),
)
