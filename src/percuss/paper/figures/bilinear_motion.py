"""Figures 1 and 2: the bilinear oscillator, its force laws, and a motion off resonance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import bilinear_oscillator
from percuss.model.system import System
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.energetics import forces_at
from percuss.motion.simulate import simulate
from percuss.motion.tables import no_contacts
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
from percuss.paper.models.motions import impact_speeds, motion_dataset

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

RATIO = 20  # w-^2 / w+^2 of figure 2
DETUNING = 1.01
PERIODS = 60
# Puts both greatest displacements at the tops of the printed axes.
AMPLITUDE = "0.72"


def force_laws() -> Dataset:
    """Return the return force of the bilinear oscillator over the displacement."""
    import xarray as xr

    x = np.linspace(-0.35, 1.5, 371)
    osc = bilinear_oscillator(stiffness_above=1, stiffness_below=RATIO)
    rest = np.zeros_like(x)
    acting = xr.Dataset(forces_at(System(osc, None), no_contacts(None), rest, x, rest))
    total = acting["spring"].values + acting["stops"].sum("stop").values
    return xr.Dataset(
        {"force": ("x", -total, {"long_name": "return force k(x) x"})},
        coords={"x": x},
        attrs={"stiffness_above": 1.0, "stiffness_below": float(RATIO)},
    )


def _caption_laws(data: Dataset) -> str:
    x, force = data.x.values, data.force.values
    slopes = [float(np.polyfit(x[side], force[side], 1)[0]) for side in (x < 0, x > 0)]
    return (
        "The bilinear oscillator (a), its return force (b), and that of the impact oscillator (c), "
        "to which it tends as the stiffness below grows without bound. The slopes drawn in (b) are "
        f"{slopes[0]:.6g} for x < 0 and {slopes[1]:.6g} for x > 0, the ratio of figure 2."
    )


def _draw_oscillator(ax: Axes) -> None:
    turns = np.linspace(0.0, 1.0, 200)
    spring = 0.12 * np.sin(2 * np.pi * 6 * turns) * ((turns > 0.12) & (turns < 0.88))
    ax.plot(0.25 + 1.75 * turns, 0.45 + spring, color="black", linewidth=1.2)
    ax.plot([0.25, 0.25], [0.0, 0.9], color="black", linewidth=2)
    ax.plot([0.25, 4.2], [0.0, 0.0], color="black", linewidth=1)
    for y in np.linspace(0.05, 0.9, 6):
        ax.plot([0.08, 0.25], [y - 0.12, y], color="black", linewidth=0.8)
    ax.fill([2.0, 2.9, 2.9, 2.0], [0.1, 0.1, 0.8, 0.8], facecolor="#dbe7f1", edgecolor="black")
    for wheel in (2.2, 2.7):
        ax.plot(wheel, 0.05, "o", color="black", markersize=4)
    arrow = {"arrowstyle": "-|>", "color": COLOURS["stiff"], "linewidth": 1.5}
    ax.annotate("", (3.6, 0.45), (2.9, 0.45), arrowprops=arrow)
    ax.text(3.65, 0.45, "$f(t)$", va="center")
    ax.text(1.1, 0.72, "$k(x)$", ha="center")
    ax.text(2.45, 0.45, "1", ha="center", va="center")
    ax.annotate("", (3.2, -0.22), (2.45, -0.22), arrowprops={**arrow, "color": "black"})
    ax.plot([2.45, 2.45], [-0.32, -0.02], color="black", linewidth=0.8)
    ax.text(3.25, -0.22, "$x$", va="center")
    ax.set(xlim=(0.0, 4.3), ylim=(-0.4, 1.0), aspect="equal")
    ax.axis("off")


@styled
def _draw_laws(data: Dataset) -> Picture:
    from percuss.plotting.style import fix_ticks, offscreen_figure

    figure = offscreen_figure(5.6, 4.2)
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.5))
    oscillator = figure.add_subplot(grid[0, :])
    _draw_oscillator(oscillator)
    label(oscillator, "unit mass on a nonlinear spring", "a")
    bilinear, impact = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    x, force = data.x.values, data.force.values
    bilinear.plot(x, force, color=COLOURS["limit"], linewidth=1.8)
    free = x >= 0
    impact.plot(x[free], force[free], color=COLOURS["limit"], linewidth=1.8)
    impact.plot([0, 0], [force.min(), 0], color=COLOURS["limit"], linewidth=1.8)
    label(bilinear, "bilinear", "b")
    label(impact, "impact", "c")
    bilinear.text(-0.28, -3.0, r"$\omega_-^2$", ha="right")
    bilinear.text(0.75, 1.3, r"$\omega_+^2$", ha="center")
    for ax in (bilinear, impact):
        ax.axhline(0.0, color="black", linewidth=0.6)
        ax.axvline(0.0, color="black", linewidth=0.6)
        ax.set(xlim=(-0.6, 1.5), ylim=(force.min(), 2.5), xlabel="displacement $x$")
        fix_ticks(ax)
    bilinear.set_ylabel("return force $k(x)\\,x$")
    return figure


def off_resonance() -> Dataset:
    """Return the motion of figure 2, over 60 resonant periods from rest."""
    osc = bilinear_oscillator(stiffness_above=1, stiffness_below=RATIO)
    resonance = resonant_frequency(osc)
    omega = DETUNING * resonance
    t_end = PERIODS * 2 * math.pi / resonance
    run = simulate(osc, cosine(omega, AMPLITUDE), x0=0, v0=0, t_end=t_end)
    data = motion_dataset(
        {"run": run}, omega=omega, resonant_frequency=resonance, amplitude=float(AMPLITUDE)
    )
    times, _ = impact_speeds(run)
    flights = np.diff(times) * omega / (2 * math.pi)
    return data.assign(flight_in_forcing_periods=("flight", flights))


def _caption_motion(data: Dataset) -> str:
    turns = data.t_run.values * data.resonant_frequency / (2 * math.pi)
    x, flights = data.x_run.values, data.flight_in_forcing_periods.values
    early, late = x[turns <= 7].max(), x[turns >= 56].max()
    tops = [frame.upwards[1] for frame in FRAMES["fig2"]]
    wanted = [
        data.amplitude * top / height for top, height in zip(tops, (early, late), strict=True)
    ]
    drift = float(np.sum(flights - 1.0))
    return (
        "Bilinear oscillator with w-^2/w+^2 = 20, no damping, driven at 1.01 W_r = "
        f"{data.omega:.6f}, at the start (a) and the end (b) of 60 resonant periods. The article "
        "states neither the amplitude nor the phase of the force, nor the start; chosen: force "
        f"{data.amplitude:g} cos ωt (w+ = 1), start at rest at x = 0. The greatest displacements "
        f"are then {early:.4g} in (a) and {late:.4g} in (b); displacements are proportional to the "
        f"amplitude, and {wanted[0]:.3f} and {wanted[1]:.3f} would put them at {tops[0]:g} and "
        f"{tops[1]:g}, the last numbers on the printed axes. The motion goes down to "
        f"{x[turns <= 7].min():.3g} and {x.min():.3g}, less than one printed step below 0. The "
        f"time from one impact to the next goes from {flights[0]:.4f} to {flights[-1]:.4f} forcing "
        f"periods and is {flights.min():.4f} at least: over {flights.size} flights the "
        f"impacts drift by {drift:.3f} of a period against the force."
    )


@styled
def _draw_off_resonance(data: Dataset) -> Picture:
    figure, axes = panels(2, 2.2, share_x=False)
    turns = data.t_run.values * data.resonant_frequency / (2 * math.pi)
    impacts = data.impact_t_run.values * data.resonant_frequency / (2 * math.pi)
    for ax, frame in zip(axes, FRAMES["fig2"], strict=True):
        low, high = (round(end) for end in frame.across)
        shown = (turns >= low - 0.1) & (turns <= high + 0.1)
        x = data.x_run.values[shown]
        draw_curve(ax, turns[shown], x, color=COLOURS["limit"])
        marked = impacts[(impacts >= low) & (impacts <= high)]
        ax.plot(marked, np.zeros_like(marked), "o", color=COLOURS["stiff"], ms=4, clip_on=False)
        whole = np.arange(low, high + 1)
        ax.vlines(whole / DETUNING, 0, 1, transform=ax.get_xaxis_transform(), lw=0.5, color="0.8")
        draw_frame(ax, frame, y=reach(x, frame.upwards))
        ax.set(xlabel=r"$\Omega_r t / 2\pi$", ylabel="displacement $x$")
        words = "end; dots: entries, lines: forcing periods" if frame.panel == "b" else "beginning"
        label(ax, words, frame.panel)
    return figure


FIGURES = (
    Figure("fig1", "The oscillator and its force laws", _caption_laws, force_laws, _draw_laws),
    Figure(
        "fig2",
        "Bilinear oscillator 1 % above resonance",
        _caption_motion,
        off_resonance,
        _draw_off_resonance,
        FRAMES["fig2"],
    ),
)
