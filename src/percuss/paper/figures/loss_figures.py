"""Pictures of the resonances with losses: speeds over the frequency, and how peaks fall."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Floats
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import label, panels, styled
from percuss.paper.models.resonance_losses import (
    cycle_work,
    gain,
    half_peak,
    largest_speeds,
    lossy,
    lost_share,
    peak_and_width,
    peak_orbit,
    response,
    saddle_speed,
    single_impact_speed,
    stiff,
    stiff_resonance,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

__all__ = ["FIGURES"]


LOSSES = ((0.98, 0.0), (0.9, 0.0), (0.8, 0.02), (0.6, 0.05))
EVEN = (2, 4, 6)
STIFFNESSES, DAMPINGS = (4.0, 25.0, 1e4), (0.02, 0.1)
MULTIPLES = (1, 2, 3)
# Shares of the speed lost at an impact, over which heights and widths are shown.
LOST = (0.4, 0.2, 0.1, 0.05, 0.025)
HALF_LOST = (0.2, 0.1, 0.05, 0.025, 0.0125)
SADDLES = ("2/3", "4/3", "1/2")
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9")


def _scanned(lost: float) -> Floats:
    """Return frequencies, closer together where peaks are."""
    peaks = [n + 2.0 * lost / math.pi * np.linspace(-2.0, 2.0, 17) for n in EVEN]
    half = 1.0 + lost**2 * np.linspace(-1.5, 0.3, 13)
    found = np.concatenate([np.linspace(0.3, 6.8, 261), half, *peaks])
    return np.unique(found[(found >= 0.3) & (found <= 6.8)])


def curves() -> Dataset:
    """Return speeds and displacements of the impact oscillator over the frequency."""
    import xarray as xr

    data = {}
    for k, (restitution, damping) in enumerate(LOSSES):
        lost = lost_share(restitution, damping)
        omegas = _scanned(lost)
        starts = (0.0, 1.0, 3.0, 0.5 * gain(2) / lost)
        speeds, widest = response(lossy(restitution, damping), omegas, starts, int(20 / lost))
        form = np.full(omegas.size, np.nan)
        for n in EVEN:
            near = np.abs(omegas - n) < 0.9
            form[near] = single_impact_speed(omegas[near], n // 2, restitution, damping)
        name = f"frequency_{k}"
        data[name] = (name, omegas)
        for what, values in (("speed", speeds), ("displacement", widest), ("form", form)):
            data[f"{what}_{k}"] = (name, values)
    both = np.array(LOSSES)
    coords = {"restitution": ("loss", both[:, 0]), "damping": ("loss", both[:, 1])}
    return xr.Dataset(data, coords=coords)


def _curves_caption(data: Dataset) -> str:
    said, off = [], 0.0
    for k, (r, a) in enumerate(zip(data.restitution.values, data.damping.values, strict=True)):
        omegas, speeds = data[f"frequency_{k}"].values, data[f"speed_{k}"].values
        tops = [_top(omegas, speeds, n, 0.2) for n in EVEN]
        ratios = speeds[tops] / data[f"form_{k}"].values[tops]
        off = max(off, float(np.abs(ratios - 1.0).max()))
        heights = ", ".join(f"{speed:.3g}" for speed in speeds[tops])
        near_one = float(speeds[_top(omegas, speeds, 1.0, 0.02)])
        said.append(f"{heights} at 2, 4, 6 and {near_one:.3g} at 1 (r = {r:g}, a = {a:g})")
    return (
        "The impact oscillator under cos ωt with losses: the largest impact speed and the largest "
        "displacement of the attractors that four starts find. Dotted, the closed form of the motion "
        "with one impact in ω/2 periods; the tops of the peaks differ from it by "
        f"{off:.0e} of their height at most. Speeds: {'; '.join(said)}."
    )


def _top(omegas: Floats, speeds: Floats, at: float, within: float) -> int:
    """Return where the speed is largest near a frequency."""
    return int(np.argmax(np.where(np.abs(omegas - at) < within, speeds, -math.inf)))


@styled
def _draw_curves(data: Dataset) -> Picture:
    figure, (top, bottom) = panels(2, 2.7)
    for k, colour in zip(range(len(LOSSES)), COLOURS, strict=False):
        r, a = float(data.restitution[k]), float(data.damping[k])
        name = f"$r={r:g}$" + (f", $a={a:g}$" if a else "")
        omegas = data[f"frequency_{k}"]
        top.plot(omegas, data[f"form_{k}"], ":", color=colour, lw=1.0)
        top.plot(omegas, data[f"speed_{k}"], color=colour, lw=1.0, label=name)
        bottom.plot(omegas, data[f"displacement_{k}"], color=colour, lw=1.0)
    top.set(yscale="log", ylabel="impact speed", ylim=(0.15, 150))
    top.legend(loc="upper right", ncols=2)
    bottom.set(yscale="log", ylabel="displacement", xlabel=r"frequency $\omega$")
    bottom.set_xticks([1, 2, 3, 4, 5, 6])
    label(top, "largest impact speed", "a")
    label(bottom, "largest displacement", "b")
    return figure


def bilinear() -> Dataset:
    """Return entry speeds and displacements of bilinear oscillators over the frequency."""
    import xarray as xr

    data, heights = {}, np.empty((len(STIFFNESSES), len(DAMPINGS), len(MULTIPLES)))
    for k, below in enumerate(STIFFNESSES):
        resonance = stiff_resonance(below)
        cycle = 2.0 * math.pi / resonance
        for j, damping in enumerate(DAMPINGS):
            peaks = [m + 2.0 * damping * np.linspace(-2.0, 2.0, 17) for m in MULTIPLES]
            ratios = np.unique(np.concatenate([np.linspace(0.2, 3.5, 166), *peaks]))
            starts = (0.0, 1.0, 5.0)
            found = response(stiff(below, damping), ratios * resonance, starts, int(6 / damping))
            name = f"{k}_{j}"
            data[f"ratio_{name}"] = (f"ratio_{name}", ratios)
            data[f"speed_{name}"] = (f"ratio_{name}", found[0])
            data[f"displacement_{name}"] = (f"ratio_{name}", found[1])
            heights[k, j] = [cycle_work(below, m) / (damping * cycle) for m in MULTIPLES]
    coords = {"stiffness": list(STIFFNESSES), "damping": list(DAMPINGS), "m": list(MULTIPLES)}
    return xr.Dataset({**data, "height": (("stiffness", "damping", "m"), heights)}, coords=coords)


def _bilinear_caption(data: Dataset) -> str:
    said, halves = [], []
    for k, below in enumerate(data.stiffness.values.tolist()):
        ratios, speeds = data[f"ratio_{k}_0"].values, data[f"speed_{k}_0"].values
        found = [float(speeds[_top(ratios, speeds, m, 0.1)]) for m in MULTIPLES]
        derived = data.height.values[k, 0]
        pairs = ", ".join(f"{v:.3g} ({h:.3g})" for v, h in zip(found, derived, strict=True))
        said.append(f"{pairs} for k₋ = {below:g}")
        for j, damping in enumerate(data.damping.values.tolist()):
            ratios, speeds = data[f"ratio_{k}_{j}"].values, data[f"speed_{k}_{j}"].values
            top = float(speeds[_top(ratios, speeds, 0.5, 0.04)])
            halves.append(f"{top:.3g} (k₋ = {below:g}, a = {damping:g})")
    return (
        "Bilinear oscillators, stiffness 1 above 0 and k₋ below, damping on both sides, over the "
        "frequency in units of the resonant one: soft (4), harder, and nearly a wall (10⁴). Circles: "
        "the height J/(aT) of first order. Peaks at 1, 2, 3 for "
        f"a = {float(data.damping[0]):g}, with that height in brackets: {'; '.join(said)}. Near half "
        f"the resonant frequency the largest speeds are {', '.join(halves)}."
    )


@styled
def _draw_bilinear(data: Dataset) -> Picture:
    figure, axes = panels(3, 2.3)
    shown = (("speed", 0), ("speed", 1), ("displacement", 0))
    for ax, (what, j), letter in zip(axes, shown, "abc", strict=True):
        damping = float(data.damping[j])
        for k, colour in zip(range(len(STIFFNESSES)), COLOURS, strict=False):
            name = f"$k_{{-}}={float(data.stiffness[k]):g}$"
            ax.plot(data[f"ratio_{k}_{j}"], data[f"{what}_{k}_{j}"], color=colour, lw=1, label=name)
            if what == "speed":
                ax.plot(data.m, data.height[k, j], "o", mfc="none", color=colour, ms=5)
        ax.set(yscale="log", ylabel="entry speed" if what == "speed" else "displacement")
        label(ax, f"largest {'entry speed' if what == 'speed' else what}, $a={damping:g}$", letter)
    axes[0].legend(loc="upper right", ncols=3)
    axes[0].set_ylim(top=100)
    axes[-1].set(xlabel=r"frequency over the resonant one, $\omega/\Omega_r$")
    return figure


def peaks() -> Dataset:
    """Return heights and widths of peaks over the loss, measured on motions and orbits."""
    import xarray as xr

    heights, widths = np.empty((2, len(EVEN), len(LOST)))
    for i, n in enumerate(EVEN):
        for j, lost in enumerate(LOST):
            omegas = n + lost / math.pi * np.linspace(-2.5, 2.5, 41)
            transient = int(14 / lost) * n // 2
            speeds = largest_speeds(lossy(1.0 - lost, 0.0), omegas, gain(n) / lost, transient)
            heights[i, j], widths[i, j] = peak_and_width(omegas, speeds)
    half = [half_peak(lost) for lost in HALF_LOST]
    saddles = np.array([[_saddle(Fraction(text), lost) for lost in LOST] for text in SADDLES])
    balance = [[saddle_speed(Fraction(text), lost) for lost in LOST] for text in SADDLES]
    return xr.Dataset(
        {
            "height": (("n", "lost"), heights),
            "width": (("n", "lost"), widths),
            "half_height": ("half_lost", [peak.height for peak in half]),
            "half_width": ("half_lost", [peak.width for peak in half]),
            "saddle": (("ratio", "lost"), saddles),
            "balance": (("ratio", "lost"), np.array(balance)),
        },
        coords={
            "n": list(EVEN),
            "lost": list(LOST),
            "half_lost": list(HALF_LOST),
            "ratio": list(SADDLES),
        },
    )


def _saddle(omega: Fraction, lost: float) -> float:
    """Return the speed of the unstable orbit, NaN where there is none."""
    from percuss.errors import ParameterError

    try:
        orbit = peak_orbit(omega, 1.0 - lost)
    except ParameterError:
        return math.nan
    return (
        float(np.abs(orbit.impacts.v_before).max()) if orbit.stability == "unstable" else math.nan
    )


def _slope(x: Floats, y: Floats) -> float:
    """Return the power of x between the last two points."""
    return float(np.log(y[-1] / y[-2]) / np.log(x[-1] / x[-2]))


def _peaks_caption(data: Dataset) -> str:
    lost, half = data.lost.values, data.half_lost.values
    falls = ", ".join(f"{_slope(lost, data.height.sel(n=n).values):.3f}" for n in EVEN)
    broadens = ", ".join(f"{_slope(lost, data.width.sel(n=n).values):.3f}" for n in EVEN)
    return (
        "Peaks of the impact oscillator over the share λ of its speed that is lost at an impact "
        f"(a = 0). Filled: motions at n = 2, 4, 6; their heights go as λ to the power {falls}, their "
        f"widths at 1/√2 as {broadens} (last two points). Squares: the half-harmonic, with the "
        f"powers {_slope(half, data.half_height.values):.3f} and "
        f"{_slope(half, data.half_width.values):.3f}. Open: unstable orbits of higher orders, on "
        "which gain and loss balance, and which no motion stays at. Lines: the derived leading terms "
        "2n/((n²-1)λ), (π/4λ)^½ + π/(4√2), and 2λ/π; dotted, λ²/2, for comparison."
    )


@styled
def _draw_peaks(data: Dataset) -> Picture:
    figure, (top, bottom) = panels(2, 3.1)
    fine = np.geomspace(0.01, 0.5, 60)
    for n, colour in zip(EVEN, COLOURS, strict=False):
        top.plot(fine, gain(n) / fine, color=colour, lw=0.8)
        top.plot(data.lost, data.height.sel(n=n), "o", color=colour, label=rf"$\omega={n}$")
        bottom.plot(data.lost, data.width.sel(n=n), "o", color=colour, ms=9 - n)
    colour = COLOURS[3]
    above = math.pi / (4.0 * math.sqrt(2.0))
    top.plot(fine, np.sqrt(math.pi / 4.0 / fine) + above, color=colour, lw=0.8)
    top.plot(data.half_lost, data.half_height, "s", color=colour, label=r"$\omega=1$")
    for text, colour, marker in zip(SADDLES, ("#555555",) * 3, "v^D", strict=True):
        one = data.saddle.sel(ratio=text)
        name = rf"$\omega={text}$, unstable"
        top.plot(data.lost, one, marker, ms=5, color=colour, mfc="none", label=name)
    bottom.plot(fine, 2.0 * fine / math.pi, color="#888888", lw=0.8)
    bottom.plot(fine, 0.5 * fine**2, ":", color="#888888", lw=1.0)
    bottom.plot(data.half_lost, data.half_width, "s", color=COLOURS[3])
    top.set(xscale="log", yscale="log", ylabel="height of the peak")
    top.legend(loc="upper right", ncols=2, fontsize=8)
    bottom.set(
        yscale="log", ylabel="width of the peak", xlabel=r"share lost at an impact, $\lambda$"
    )
    label(top, "impact speed at the peak", "a")
    label(bottom, r"width in $\omega$ at $1/\sqrt{2}$ of the height", "b")
    return figure


FIGURES = (
    Figure(
        "losses-curves",
        "Resonance curves of the impact oscillator with losses",
        _curves_caption,
        curves,
        _draw_curves,
    ),
    Figure(
        "losses-bilinear",
        "Resonance curves of bilinear oscillators, soft and hard",
        _bilinear_caption,
        bilinear,
        _draw_bilinear,
    ),
    Figure(
        "losses-peaks",
        "How the peaks fall and broaden",
        _peaks_caption,
        peaks,
        _draw_peaks,
    ),
)
