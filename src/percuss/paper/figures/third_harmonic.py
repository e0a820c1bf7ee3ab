"""Figures 6, 7 and 8: the third harmonic on either side of its critical velocity 1/2."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.model.harmonic_forces import sine
from percuss.motion.impact_times import ImpactTimes, classify_impact_times
from percuss.motion.trajectory import Trajectory
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import (
    COLOURS,
    draw_frame,
    draw_motion,
    label,
    panels,
    reach,
    styled,
)
from percuss.paper.figures.model_panels import heading, model_of, spectra
from percuss.paper.figures.power import PRINTED_POINTS, SCALE_IN_WORDS, power_of, with_power
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

ABOVE, BELOW = "0.51", "0.45"
T_END = 30 * math.pi
HIGHEST = 36.0
NAMES = ("above_limit", "below_limit", "below_stiff", "below_soft")
DIFFERENCES = {
    "stiff": r"$\omega_-/\omega_+=2\cdot10^4$",
    "soft": r"$\omega_-^2/\omega_+^2=2\cdot10^4$",
    "steps": "Runge-Kutta",
}
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
    steps = step_through(sine(3), BELOW, T_END)
    data = data.assign(step_columns("below_steps", steps))
    few = np.minimum(data.t_below_steps.values, T_END)
    exact = runs()["below_stiff"](few)[0]
    data.attrs["off_exact_steps"] = float(np.abs(data.x_below_steps.values - exact).max())
    data = data.assign(_differences(data))
    return data.assign_attrs(
        {f"impact_times_{name}": _words(classify_impact_times(runs()[name])) for name in NAMES}
    )


def _differences(data: Dataset) -> dict[str, tuple[str, Floats]]:
    """Return how far the three computations of the lower motion are from the limit.

    The largest distance in each interval of pi.
    """
    t = np.minimum(data.t_below_steps.values, T_END)
    limit = runs()["below_limit"](t)[0]
    motions = {name: runs()[f"below_{name}"](t)[0] for name in ("stiff", "soft")}
    motions["steps"] = data.x_below_steps.values
    starts = np.searchsorted(t, math.pi * np.arange(30))
    return {
        f"difference_{name}": ("interval", np.maximum.reduceat(np.abs(x - limit), starts))
        for name, x in motions.items()
    }


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
        f"{kinds[1]}. (c) How far the bilinear oscillator of the article is from (b): solved exactly "
        f"with the printed 2e4 as ratio of frequencies (impact times {kinds[2]}; by up to "
        f"{data.off_limit_below_stiff:.2g}) and of their squares ({kinds[3]}; by up to "
        f"{data.off_limit_below_soft:.2g}), and the first by Runge-Kutta, here to a coarse "
        f"{STEP_TOLERANCE:g} a step: off its exact solution by up to {data.off_exact_steps:.2g}."
    )


@styled
def _draw_motions(data: Dataset) -> Picture:
    figure, axes = panels(3, 2.1)
    for ax, name, before, frame in zip(axes, NAMES, HEADINGS, FRAMES["fig6"], strict=False):
        draw_motion(ax, data, name, "x", scale=math.pi, color=COLOURS["limit"])
        draw_frame(ax, frame, y=reach(np.maximum(data[f"x_{name}"], 0.0), frame.upwards))
        ax.set_ylabel("$x(t)$")
        label(ax, heading(name, before), frame.panel)
    for name, text in DIFFERENCES.items():
        # Before the first impact all are alike.
        off = np.where(data[f"difference_{name}"] > 1e-6, data[f"difference_{name}"], np.nan)
        axes[2].plot(np.arange(off.size) + 0.5, off, ".-", color=COLOURS[name], lw=0.8, label=text)
    axes[2].set(yscale="log", ylim=(1e-5, 10), ylabel="distance", xlabel=r"$t/\pi$")
    axes[2].legend(loc="upper left", ncols=3, handlelength=1.4, columnspacing=1.2)
    label(
        axes[2],
        "largest distance from (b) in each interval of $\\pi$",
        "c",
    )
    return figure


def _caption_portraits(data: Dataset) -> str:
    fastest = [float(np.abs(data[f"v_{name}"].values).max()) for name in NAMES]
    return (
        f"Phase portraits of figure 6. (a) V0 = {ABOVE}: the curve closes after 4π "
        f"{within(data.off_period_above_limit)}, its greatest speed is {fastest[0]:.6f}. V0 = "
        f"{BELOW}: (b) the limit closes after 4π {within(data.off_period_below_limit)}, greatest "
        f"speed {fastest[1]:.6f}; below it, the bilinear oscillator with 2e4 as the ratio of "
        f"squares, which does not close, {fastest[3]:.6f}. With 2e4 as the ratio of frequencies "
        f"({fastest[2]:.6f}) the curve cannot be told from the limit's. Both panels have one scale."
    )


@styled
def _draw_portraits(data: Dataset) -> Picture:
    figure, axes = panels(2, 3.6, columns=2, share_x=False)
    runs_shown = (("above_limit",), ("below_soft", "below_limit"))
    x, v = (np.concatenate([data[f"{what}_{name}"] for name in NAMES]) for what in "xv")
    wide, tall = FRAMES["fig7"][0].across, reach(v, FRAMES["fig7"][0].upwards)
    for ax, names, frame in zip(axes, runs_shown, FRAMES["fig7"], strict=True):
        for name in names:
            model = model_of(name)
            text, width = (DIFFERENCES["soft"], 0.4) if model == "soft" else (model, 1.2)
            ax.plot(
                data[f"x_{name}"], data[f"v_{name}"], color=COLOURS[model], lw=width, label=text
            )
        draw_frame(ax, frame, x=reach(x, wide), y=tall, note=False)
        ax.tick_params(axis="x", labelsize=8.0)
        ax.set(xlabel="$x$", ylabel=r"$\dot x$", aspect="equal")
        label(ax, f"$V_0={ABOVE if frame.panel == 'a' else BELOW}$", frame.panel)
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def power() -> Dataset:
    """Return the power spectra of the four motions, and of the second over whole periods."""
    import xarray as xr

    data = with_power(xr.Dataset(attrs=dict(motions().attrs)), runs(), HIGHEST)
    omega, whole = power_of(runs()["below_limit"], HIGHEST, t_end=28.0 * math.pi)
    data.attrs["floor_of_whole_periods"] = float(np.median(whole[_between_lines(omega)]))
    return data


def _between_lines(omega: Floats) -> Flags:
    """Return which frequencies from 18 on are farther than 0.15 from a multiple of 1/2."""
    apart = np.abs(2.0 * omega - np.round(2.0 * omega))
    return np.asarray((omega > HIGHEST / 2.0) & (apart > 0.3), dtype=np.bool_)


def _share_off_lines(data: Dataset, name: str) -> float:
    """Return the share of the power from 18 to 36 that lies off the multiples of 1/2.

    The window widens a line to 0.133 on either side.
    """
    omega, s = data[f"omega_{name}"].values, data[f"smooth_{name}"].values
    return float(s[_between_lines(omega)].sum() / s[omega > HIGHEST / 2.0].sum())


def _caption_power(data: Dataset) -> str:
    shares = [_share_off_lines(data, name) for name in NAMES]
    omega, s = data.omega_above_limit.values, data.S_above_limit.values
    top, median = float(s.max()), float(np.median(s))
    duration = T_END**2 / PRINTED_POINTS
    floor = float(np.median(data.S_below_limit.values[_between_lines(omega)]))
    ends = [float(data[f"smooth_{name}"].values[omega > 32.0].max()) for name in NAMES[:2]]
    return (
        f"Power spectra of figure 6 on the printed scale, {SCALE_IN_WORDS}. The article does not "
        "state its normalisation; this one puts the exact Fourier series of (a) where it is "
        f"printed: the mean at {top:.3g} and, off the lines, the median at {median:.2g} (the last "
        "point repeats the first). Not divided by N they would be at "
        f"{top * PRINTED_POINTS:.2g} and {median * PRINTED_POINTS:.2g}, divided by N² at "
        f"{top / PRINTED_POINTS:.2g} and {median / PRINTED_POINTS:.2g}, as the square of the "
        f"integral at {top * duration:.3g} and {median * duration:.2g}. In (b) 30π is 7.5 periods: "
        f"what lies between the lines (median {floor:.2g} from 18 on) comes from the cut and falls "
        f"to {data.floor_of_whole_periods:.1g} over seven whole periods. The lines themselves fall "
        f"alike: from 32 to 36 the highest is {ends[0]:.2g} in (a) and {ends[1]:.2g} in (b). Grey: "
        "the same under a Hann window; dashed, the resonant frequency 2. Share of the windowed "
        "power from 18 to 36 that is farther than 0.15 from a multiple of 1/2: (a) "
        f"{shares[0]:.1e}; (b) {shares[1]:.1e}; (c) {shares[2]:.1e}; (d) {shares[3]:.1e}."
    )


@styled
def _draw_power(data: Dataset) -> Picture:
    texts = [heading(name, before) for name, before in zip(NAMES, HEADINGS, strict=True)]
    above, below = FRAMES["fig8"]
    return spectra(data, NAMES, texts, (above, below, below, below))


FIGURES = (
    Figure(
        "fig6",
        "Third harmonic above and below",
        _caption_motions,
        motions,
        _draw_motions,
        FRAMES["fig6"],
    ),
    Figure(
        "fig7",
        "Their phase portraits",
        _caption_portraits,
        motions,
        _draw_portraits,
        FRAMES["fig7"],
    ),
    Figure("fig8", "Their power spectra", _caption_power, power, _draw_power, FRAMES["fig8"]),
)
