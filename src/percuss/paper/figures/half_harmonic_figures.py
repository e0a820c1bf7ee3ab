"""Figures 10 to 13: the half-harmonic resonance from rest."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Floats
from percuss.model.harmonic_forces import sine
from percuss.motion.growth import growth, peaks
from percuss.motion.half_harmonic import half_harmonic_growth
from percuss.motion.trajectory import Trajectory
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, draw_envelope, label, styled
from percuss.paper.figures.model_panels import heading, portraits, spectra, time_panels
from percuss.paper.figures.power import SCALE_IN_WORDS, with_power
from percuss.paper.figures.printed_frames import FRAMES
from percuss.paper.models.motions import (
    MODEL_LABELS,
    STEP_TOLERANCE,
    motion_dataset,
    simulate_all,
    step_columns,
    step_through,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

T_END = 400
PRINTED_FACTOR = 0.61
# Highest frequency of the spectra.
HIGHEST = 30.0
# The portrait fits the printed frame until then.
PORTRAIT_END = 65.0
NAMES = ("limit", "stiff", "soft")
ALL_NAMES = (*NAMES, "steps")
# The envelope is fitted where the motion has forgotten its start.
FITTED_FROM = 40.0


def runs() -> dict[str, Trajectory]:
    """Return the half-harmonic from rest: the limit and both bilinear oscillators."""
    return simulate_all(sine(1), 0, T_END)


@cache
def motions() -> Dataset:
    """Return the three motions, the second also by steps, and the law of the limit's growth."""
    data = motion_dataset(runs(), v0=0.0, printed_factor=PRINTED_FACTOR)
    limit = runs()["limit"]
    data = data.assign(step_columns("steps", step_through(sine(1), 0, T_END)))
    for what in ("velocity", "displacement"):
        law = growth(limit, what, since=FITTED_FROM)
        data.attrs[f"{what}_factor"] = law.coefficient
        data.attrs[f"{what}_exponent"] = law.exponent
        data.attrs[f"{what}_exponent_error"] = law.exponent_error
    data = data.assign(_peaks())
    last = half_harmonic_growth(float(limit.impacts.t[-1]), float(limit.impacts.v_after[-1]))
    return data.assign_attrs(asymptotic_factor=last.constant)


def _peaks() -> dict[str, tuple[str, Floats]]:
    """Return the peaks of speed and displacement of the limit, and when they occur."""
    limit = runs()["limit"]
    (t_v, v), (t_x, x) = peaks(limit, "velocity"), peaks(limit, "displacement")
    columns = {"peak_t_v": t_v, "peak_v": v, "peak_t_x": t_x, "peak_x": x}
    return {name: (f"point_of_{name[-1]}", column) for name, column in columns.items()}


def _law(data: Dataset, what: str) -> str:
    """Return the fitted envelope of the limit in words."""
    attrs = data.attrs
    return (
        f"{attrs[f'{what}_factor']:.3f} t^({attrs[f'{what}_exponent']:.3f} ± "
        f"{attrs[f'{what}_exponent_error']:.3f})"
    )


def _greatest(data: Dataset, what: str) -> str:
    """Return the greatest values of the four motions as a list."""
    values = [float(np.abs(data[f"{what}_{name}"].values).max()) for name in ALL_NAMES]
    return f"{', '.join(f'{value:.3f}' for value in values[:-1])} and {values[-1]:.3f}"


def _caption_velocity(data: Dataset) -> str:
    return (
        "Velocity of the half-harmonic resonance x'' + x = sin t from rest. (a) In the exact limit "
        f"the impact velocity grows as {_law(data, 'velocity')}, fitted from t = {FITTED_FROM:g} "
        "on; the factor b of the asymptotics b sqrt t, computed from the last impact, is "
        f"{data.asymptotic_factor:.5f}; dashed, {PRINTED_FACTOR:g} sqrt t, the factor printed in "
        "figure 11 (figure 10 bears none). The bilinear oscillator "
        "of the article, solved exactly with 2e4 as the ratio of frequencies (b) and of their "
        "squares (c), and (b) once more as the article computed it, by Runge-Kutta, here to a "
        f"coarse {STEP_TOLERANCE:g} a step (d). "
        f"Greatest speeds to t = {T_END}: {_greatest(data, 'v')}. {_alternation(data, 'v')}"
    )


def _caption_displacement(data: Dataset) -> str:
    return (
        "Displacement of the motions of figure 10. (a) In the limit the highest points of the flights grow "
        f"as {_law(data, 'displacement')}; dashed, {PRINTED_FACTOR:g} sqrt t, which the article "
        "fitted by eye. (b), (c) The bilinear oscillator, exactly; (d) by Runge-Kutta. Greatest "
        f"displacements: {_greatest(data, 'x')}. {_alternation(data, 'x')}"
    )


def _alternation(data: Dataset, what: str) -> str:
    """Return what panel (e) shows in words."""
    t, height = data[f"peak_t_{what}"].values, data[f"peak_{what}"].values
    late = height[t >= FITTED_FROM] / np.sqrt(t[t >= FITTED_FROM])
    lower, higher = sorted(float(np.median(late[k::2])) for k in (0, 1))
    last = sorted(float(factor) for factor in late[-2:])
    return (
        "(e) The peaks of (a) over sqrt t: they alternate, so that an envelope fitted by eye "
        f"depends on which it touches. From t = {FITTED_FROM:g} on the medians of the higher and "
        f"of the lower ones are {higher:.3f} and {lower:.3f}, the last two {last[1]:.3f} and "
        f"{last[0]:.3f}; both sorts tend to {data.asymptotic_factor:.4f} (full line)."
    )


def _draw(data: Dataset, what: str) -> Picture:
    (frame,) = FRAMES["fig11" if what == "x" else "fig10"]
    figure, axes = time_panels(data, ALL_NAMES, what, frame, more=1)
    text = rf"${PRINTED_FACTOR:g}\,\sqrt{{t}}$"
    for ax in axes[:-1]:
        draw_envelope(ax, T_END, PRINTED_FACTOR, text, signs=(1,) if what == "x" else (1, -1))
    axes[-2].legend(loc="upper left", handlelength=2.6)
    _draw_peaks(axes[-1], data, what)
    return figure


def _draw_peaks(ax: Axes, data: Dataset, what: str) -> None:
    """Draw peaks over sqrt t, with one mark for every other peak."""
    t, height = data[f"peak_t_{what}"].values, data[f"peak_{what}"].values
    for k, fill in ((0, COLOURS["limit"]), (1, "white")):
        factor = height[k::2] / np.sqrt(t[k::2])
        ax.plot(t[k::2], factor, "o-", color=COLOURS["limit"], mfc=fill, ms=3.5, lw=0.5)
    ax.axhline(PRINTED_FACTOR, color="black", ls=(0, (4, 2)), lw=1.3)
    ax.axhline(data.asymptotic_factor, color="black", lw=0.9)
    ax.set(ylim=(0.4, 0.8), ylabel="peaks $/\\sqrt{t}$")
    label(ax, "peaks of (a), filled and open in turn", "e")


@styled
def _draw_velocity(data: Dataset) -> Picture:
    return _draw(data, "v")


@styled
def _draw_displacement(data: Dataset) -> Picture:
    return _draw(data, "x")


def _caption_portraits(data: Dataset) -> str:
    t, x = data.t_limit.values, data.x_limit.values
    ends = [
        f"x = {float(data[f'x_{name}'].max()):.2f}, |v| = "
        f"{float(np.abs(data[f'v_{name}'].values).max()):.2f}"
        for name in ALL_NAMES
    ]
    (frame,) = FRAMES["fig12"]
    return (
        f"Phase portraits of the motions of figure 10, to t = {PORTRAIT_END:g}: the limit passes "
        f"x = {frame.across[1]:g}, the last number of the printed portrait, first at t = "
        f"{float(t[np.argmax(x > frame.across[1])]):.1f}. "
        "(a) The limit; (b) 2e4 as ratio of frequencies; (c) as ratio of their squares; (d) (b) by "
        f"Runge-Kutta. The printed motion lasts to t = {T_END}, and by then the four are at "
        f"(a) {ends[0]}; (b) {ends[1]}; (c) {ends[2]}; (d) {ends[3]}. Only (c) stays within a step "
        "of the printed numbers to the end (grey). But its loops are irregular, and the article calls "
        "its own regular; and it stays below half of the printed axes of figures 10 and 11, which "
        "reach 15 and 12. So the authors' stiffness is not that of (c): 2e4 is the ratio of "
        "frequencies, and the printed portrait shows the beginning of the motion only."
    )


@styled
def _draw_portraits(data: Dataset) -> Picture:
    ratios = [MODEL_LABELS[name].split(", ")[1] for name in ("stiff", "soft")]
    headings = ["limit", *ratios, "by Runge-Kutta"]
    return portraits(data, ALL_NAMES, headings, FRAMES["fig12"][0], PORTRAIT_END)


def power() -> Dataset:
    """Return the power spectra of the three motions."""
    import xarray as xr

    return with_power(xr.Dataset(attrs=dict(motions().attrs)), runs(), HIGHEST)


def _share_even(data: Dataset, name: str) -> float:
    """Return the share of the power, the mean apart, within 0.1 of an even frequency."""
    omega, s = data[f"omega_{name}"].values, data[f"smooth_{name}"].values
    moving = omega > 0.2
    near = np.abs(omega - 2.0 * np.round(omega / 2.0)) < 0.1
    return float(s[moving & near].sum() / s[moving].sum())


def _caption_power(data: Dataset) -> str:
    shares = [_share_even(data, name) for name in NAMES]
    tops = [float(data[f"S_{name}"].max()) for name in NAMES]
    lows = [float(data[f"S_{name}"].min()) for name in NAMES]
    return (
        f"Power spectra of the motions of figure 10 to t = {T_END}, on the scale of figure 8: "
        f"{SCALE_IN_WORDS}. Highest and lowest values: (a) {tops[0]:.2g} and {lows[0]:.1g}, (b) "
        f"{tops[1]:.2g} and {lows[1]:.1g}, (c) {tops[2]:.2g} and {lows[2]:.1g}. Grey: under a Hann "
        "window; dashed, the resonant "
        "frequency 2. Share of the windowed power, the mean apart, within 0.1 of an even "
        f"frequency: (a) {shares[0]:.4f}, (b) {shares[1]:.4f}, (c) {shares[2]:.4f}."
    )


@styled
def _draw_power(data: Dataset) -> Picture:
    return spectra(data, NAMES, [heading(name) for name in NAMES], 3 * FRAMES["fig13"])


FIGURES = (
    Figure(
        "fig10",
        "Half-harmonic, velocity",
        _caption_velocity,
        motions,
        _draw_velocity,
        FRAMES["fig10"],
    ),
    Figure(
        "fig11",
        "Half-harmonic, displacement",
        _caption_displacement,
        motions,
        _draw_displacement,
        FRAMES["fig11"],
    ),
    Figure(
        "fig12",
        "Half-harmonic, phase portrait",
        _caption_portraits,
        motions,
        _draw_portraits,
        FRAMES["fig12"],
    ),
    Figure(
        "fig13",
        "Half-harmonic, power spectrum",
        _caption_power,
        power,
        _draw_power,
        FRAMES["fig13"],
    ),
)
