"""Figures 6, 7 and 8: the third harmonic on either side of its critical velocity 1/2."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.forcing import sine
from percuss.motion.impact_times import ImpactTimes, classify_impact_times
from percuss.motion.trajectory import Trajectory
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import label, styled
from percuss.paper.figures.model_panels import heading, portraits, spectra, time_panels
from percuss.paper.figures.power import with_power
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

__all__ = ["FIGURES"]

ABOVE, BELOW = "0.51", "0.45"
T_END = 30 * math.pi
HIGHEST = 36.0
NAMES = ("above_limit", "below_limit", "below_stiff", "below_soft")
HEADINGS = (f"$V_0={ABOVE}$: ", f"$V_0={BELOW}$: ", f"$V_0={BELOW}$: ", f"$V_0={BELOW}$: ")


@cache
def runs() -> dict[str, Trajectory]:
    """Return the runs of the three figures: both velocities, and three models of the lower."""
    above = simulate_all(sine(3), ABOVE, T_END)
    below = simulate_all(sine(3), BELOW, T_END)
    return {
        "above_limit": above["limit"],
        **{f"below_{name}": run for name, run in below.items()},
    }


def motions() -> Dataset:
    """Return the motions, with the farthest that an impact lies from the eigenset."""
    data = motion_dataset(runs(), v0_above=float(ABOVE), v0_below=float(BELOW))
    for name in NAMES:
        k = data[f"impact_t_{name}"].values / math.pi
        data.attrs[f"off_eigenset_{name}"] = float(np.abs(k - np.round(k)).max()) * math.pi
    t = np.linspace(0.0, T_END, 20_001)
    for name in NAMES[:2]:
        later = t[t <= T_END - 4.0 * math.pi]
        apart = runs()[name](later + 4.0 * math.pi)[0] - runs()[name](later)[0]
        data.attrs[f"off_period_{name}"] = float(np.abs(apart).max())
    limit = runs()["below_limit"](t)[0]
    for name in ("below_stiff", "below_soft"):
        data.attrs[f"off_limit_{name}"] = float(np.abs(runs()[name](t)[0] - limit).max())
    data = data.assign(step_columns("below_steps", step_through(sine(3), BELOW, T_END)))
    few = np.minimum(data.t_below_steps.values, T_END)
    exact = runs()["below_stiff"](few)[0]
    data.attrs["off_exact_steps"] = float(np.abs(data.x_below_steps.values - exact).max())
    return data.assign_attrs(
        {f"impact_times_{name}": _words(classify_impact_times(runs()[name])) for name in NAMES}
    )


def _words(times: ImpactTimes) -> str:
    if times.kind == "periodic":
        return (
            f"periodic, {times.n_impacts} impacts in {times.n_periods} forcing periods "
            f"{within(times.deviation)}"
        )
    return {
        "settling": f"settling towards {times.n_impacts} in {times.n_periods} forcing periods",
        "eigenset": f"the eigenset {within(times.deviation)}",
        "no_period_found": f"without a period among the {times.n_used} examined",
    }.get(times.kind, times.kind.replace("_", " "))


def _caption_motions(data: Dataset) -> str:
    counts = [data.sizes[f"{name}_impact"] for name in NAMES]
    kinds = [data.attrs[f"impact_times_{name}"] for name in NAMES]
    return (
        "Third harmonic x'' + x = sin 3t above and below the critical velocity 1/2, to 30π. "
        f"(a) V0 = {ABOVE}: {counts[0]} impacts, {kinds[0]}. V0 = {BELOW}: (b) in the exact limit "
        f"{counts[1]} impacts, off the eigenset by up to {data.off_eigenset_below_limit:.3f}, "
        f"{kinds[1]}; (c) and (d) the bilinear oscillator of the paper, solved exactly with the "
        f"printed 2e4 as ratio of frequencies (impact times {kinds[2]}; x differs from the limit by up "
        f"to {data.off_limit_below_stiff:.2g}) and of their squares ({kinds[3]}; by up to "
        f"{data.off_limit_below_soft:.2g}); (e) what (c) becomes by Runge-Kutta, here to a coarse "
        f"{STEP_TOLERANCE:g} a step: off the exact solution by up to {data.off_exact_steps:.2g}."
    )


@styled
def _draw_motions(data: Dataset) -> Picture:
    names = (*NAMES, "below_steps")
    figure, axes = time_panels(data, names, "x", scale=math.pi, height=1.5)
    befores = (*HEADINGS, HEADINGS[-1])
    for ax, name, before, letter in zip(axes, names, befores, "abcde", strict=True):
        label(ax, heading(name, before), letter)
    return figure


def _caption_portraits(data: Dataset) -> str:
    fastest = [float(np.abs(data[f"v_{name}"].values).max()) for name in NAMES]
    return (
        f"Phase portraits of figure 6. (a) V0 = {ABOVE}: the curve closes after 4π "
        f"{within(data.off_period_above_limit)}, its greatest speed is {fastest[0]:.6f}. V0 = "
        f"{BELOW}: (b) the limit closes after 4π {within(data.off_period_below_limit)}, greatest "
        f"speed {fastest[1]:.6f}; (c) and (d) the bilinear oscillator at both readings, "
        f"{fastest[2]:.6f} and {fastest[3]:.6f}."
    )


@styled
def _draw_portraits(data: Dataset) -> Picture:
    short = (
        "$V_0=0.51$, limit",
        "$V_0=0.45$, limit",
        "$0.45$, $\\omega_-/\\omega_+=2\\cdot10^4$",
        "$0.45$, $\\omega_-^2/\\omega_+^2=2\\cdot10^4$",
    )
    return portraits(data, NAMES, short)


def power() -> Dataset:
    """Return the power spectra of the four motions up to omega = 36."""
    import xarray as xr

    return with_power(xr.Dataset(attrs=dict(motions().attrs)), runs(), HIGHEST)


def _share_off_lines(data: Dataset, name: str) -> float:
    """Return the share of the power from 18 to 36 that lies off the multiples of 1/2.

    The window widens a line to 0.133 on either side.
    """
    omega, s = data[f"omega_{name}"].values, data[f"S_{name}"].values
    upper = omega > HIGHEST / 2
    off = upper & (np.abs(2.0 * omega - np.round(2.0 * omega)) > 0.3)
    return float(s[off].sum() / s[upper].sum())


def _caption_power(data: Dataset) -> str:
    shares = [_share_off_lines(data, name) for name in NAMES]
    return (
        "Power spectra of figure 6, S = |X|^2 with X the mean of x exp(-iωt) over [0, 30π] under "
        "a Hann window (the exact Fourier integral, no aliasing): a line A cos ωt has the height A^2/4; dashed, the resonant frequency 2. "
        "Share of the power from 18 to 36 that is farther than 0.15 from a multiple of 1/2: (a) "
        f"{shares[0]:.1e}; (b) {shares[1]:.1e}; (c) {shares[2]:.1e}; (d) {shares[3]:.1e}."
    )


@styled
def _draw_power(data: Dataset) -> Picture:
    texts = [heading(name, before) for name, before in zip(NAMES, HEADINGS, strict=True)]
    return spectra(data, NAMES, texts, lowest=1e-12)


FIGURES = (
    Figure("fig6", "Third harmonic above and below", _caption_motions, motions, _draw_motions),
    Figure("fig7", "Their phase portraits", _caption_portraits, motions, _draw_portraits),
    Figure("fig8", "Their power spectra", _caption_power, power, _draw_power),
)
