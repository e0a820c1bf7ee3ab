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
    responses,
    saddle_speed,
    single_impact_speed,
    stiff,
    stiff_resonance,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import DataArray, Dataset

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
    frequencies = np.concatenate([np.linspace(0.3, 6.8, 196), half, *peaks])
    return np.unique(frequencies[(frequencies >= 0.3) & (frequencies <= 6.8)])


def curves() -> Dataset:
    """Return speeds and displacements of the impact oscillator over the frequency."""
    import xarray as xr

    data: dict[str, object] = {}
    for k, (restitution, damping) in enumerate(LOSSES):
        lost = lost_share(restitution, damping)
        omegas = _scanned(lost)
        starts = (0.0, 1.0, 3.0, 0.5 * gain(2) / lost)
        responses_of = responses(lossy(restitution, damping), omegas, starts, int(20 / lost))
        form = np.full(omegas.size, np.nan)
        for n in EVEN:
            near = np.abs(omegas - n) < 0.9
            form[near] = single_impact_speed(omegas[near], n // 2, restitution, damping)
        name = f"frequency_{k}"
        data[name] = (name, omegas)
        data[f"form_{k}"] = (name, form)
        for what, values in zip(("speed", "displacement"), responses_of, strict=True):
            data[f"{what}_{k}"] = ((name, "start"), values)
    both = np.array(LOSSES)
    coords = {"restitution": ("loss", both[:, 0]), "damping": ("loss", both[:, 1])}
    return xr.Dataset(data, coords=coords)


def _curves_caption(data: Dataset) -> str:
    said, off = [], 0.0
    for k, (r, a) in enumerate(zip(data.restitution.values, data.damping.values, strict=True)):
        omegas, speeds = data[f"frequency_{k}"].values, _largest(data[f"speed_{k}"])
        tops = [_top(omegas, speeds, n, 0.2) for n in EVEN]
        ratios = speeds[tops] / data[f"form_{k}"].values[tops]
        off = max(off, float(np.abs(ratios - 1.0).max()))
        heights = ", ".join(f"{speed:.3g}" for speed in speeds[tops])
        near_one = float(speeds[_top(omegas, speeds, 1.0, 0.02)])
        said.append(f"{heights} at 2, 4, 6 and {near_one:.3g} at 1 (r = {r:g}, a = {a:g})")
    return (
        "The impact oscillator under cos ωt with losses: the largest impact speed (left) and the "
        "largest displacement (right) of the attractor that each of four starts finds, a dot each; "
        "dots above one another are several attractors, or an irregular one. Grey, the closed form "
        "of the motion with one impact in ω/2 periods; the tops of the peaks differ from it by "
        f"{off:.0e} of their height at most. Speeds: {'; '.join(said)}."
    )


def _top(omegas: Floats, speeds: Floats, at: float, within: float) -> int:
    """Return where the speed is largest near a frequency."""
    return int(np.argmax(np.where(np.abs(omegas - at) < within, speeds, -math.inf)))


def _largest(values: DataArray) -> Floats:
    """Return the largest over the starts."""
    return np.asarray(np.nanmax(values.values, axis=1), dtype=np.float64)


def _dots(ax: Axes, x: DataArray, values: DataArray, colour: str, text: str = "") -> None:
    """Draw a dot for each start, on a logarithmic scale."""
    across = np.repeat(x.values, values.sizes["start"])
    # As pixels: as paths the dots would take megabytes.
    ax.semilogy(across, values.values.ravel(), ".", ms=2.6, mew=0, color=colour, rasterized=True)
    ax.plot([], [], "o", ms=4, color=colour, label=text or None)
    # Ticks between the decades cannot be told apart in so small panels.
    ax.minorticks_off()


@styled
def _draw_curves(data: Dataset) -> Picture:
    figure, axes = panels(2 * len(LOSSES), 1.6, columns=2)
    for k, (left, right) in enumerate(zip(axes[::2], axes[1::2], strict=True)):
        r, a = float(data.restitution[k]), float(data.damping[k])
        omegas = data[f"frequency_{k}"]
        _dots(left, omegas, data[f"speed_{k}"], COLOURS[0])
        left.plot(omegas, data[f"form_{k}"], color="0.5", lw=1.0, zorder=1)
        _dots(right, omegas, data[f"displacement_{k}"], COLOURS[2])
        left.set(ylim=(0.1, 150), xlim=(0.2, 6.9), ylabel="impact speed")
        right.set(ylim=(0.1, 150), xlim=(0.2, 6.9), ylabel="displacement")
        label(left, f"$r={r:g}$, $a={a:g}$", "abcd"[k])
    for ax in axes[-2:]:
        ax.set(xlabel=r"frequency $\omega$", xticks=range(1, 7))
    return figure


def bilinear() -> Dataset:
    """Return entry speeds and displacements of bilinear oscillators over the frequency."""
    import xarray as xr

    data: dict[str, object] = {}
    heights = np.empty((len(STIFFNESSES), len(DAMPINGS), len(MULTIPLES)))
    for k, below in enumerate(STIFFNESSES):
        resonance = stiff_resonance(below)
        cycle = 2.0 * math.pi / resonance
        for j, damping in enumerate(DAMPINGS):
            peaks = [m + 2.0 * damping * np.linspace(-2.0, 2.0, 17) for m in MULTIPLES]
            ratios = np.unique(np.concatenate([np.linspace(0.2, 3.5, 133), *peaks]))
            starts = (0.0, 1.0, 5.0)
            of_bilinear = responses(
                stiff(below, damping), ratios * resonance, starts, int(6 / damping)
            )
            name = f"{k}_{j}"
            data[f"ratio_{name}"] = (f"ratio_{name}", ratios)
            for what, values in zip(("speed", "displacement"), of_bilinear, strict=True):
                data[f"{what}_{name}"] = ((f"ratio_{name}", "start"), values)
            heights[k, j] = [cycle_work(below, m) / (damping * cycle) for m in MULTIPLES]
    coords = {"stiffness": list(STIFFNESSES), "damping": list(DAMPINGS), "m": list(MULTIPLES)}
    return xr.Dataset({**data, "height": (("stiffness", "damping", "m"), heights)}, coords=coords)


def _bilinear_caption(data: Dataset) -> str:
    said, halves = [], []
    for k, below in enumerate(data.stiffness.values.tolist()):
        ratios, speeds = data[f"ratio_{k}_0"].values, _largest(data[f"speed_{k}_0"])
        speeds_at = [float(speeds[_top(ratios, speeds, m, 0.1)]) for m in MULTIPLES]
        derived = data.height.values[k, 0]
        pairs = ", ".join(f"{v:.3g} ({h:.3g})" for v, h in zip(speeds_at, derived, strict=True))
        said.append(f"{pairs} for k₋ = {below:g}")
        for j, damping in enumerate(data.damping.values.tolist()):
            ratios, speeds = data[f"ratio_{k}_{j}"].values, _largest(data[f"speed_{k}_{j}"])
            top = float(speeds[_top(ratios, speeds, 0.5, 0.04)])
            halves.append(f"{top:.3g} (k₋ = {below:g}, a = {damping:g})")
    return (
        "Bilinear oscillators, stiffness 1 above 0 and k₋ below, damping on both sides, over the "
        "frequency in units of the resonant one: soft (4), harder, and nearly a wall (10⁴). Left, the "
        "largest entry speed, right, the largest displacement of the attractor that each of three "
        "starts finds, a dot each. Circles: the height J/(aT) of first order. Peaks at 1, 2, 3 for "
        f"a = {float(data.damping[0]):g}, with that height in brackets: {'; '.join(said)}. Near half "
        f"the resonant frequency the largest speeds are {', '.join(halves)}."
    )


@styled
def _draw_bilinear(data: Dataset) -> Picture:
    figure, axes = panels(2 * len(STIFFNESSES), 1.9, columns=2)
    for k, (left, right) in enumerate(zip(axes[::2], axes[1::2], strict=True)):
        for j, colour in ((1, COLOURS[4]), (0, COLOURS[0])):
            name = f"{k}_{j}"
            text = f"$a={float(data.damping[j]):g}$"
            for ax, what in ((left, "speed"), (right, "displacement")):
                _dots(ax, data[f"ratio_{name}"], data[f"{what}_{name}"], colour, text)
            left.plot(data.m, data.height[k, j], "o", mfc="none", mec="black", mew=0.9, ms=6)
        left.set(ylim=(0.06, 60), xlim=(0.1, 3.6), ylabel="entry speed")
        right.set(ylim=(0.06, 60), xlim=(0.1, 3.6), ylabel="displacement")
        label(left, f"$k_{{-}}={float(data.stiffness[k]):g}$", "abc"[k])
    axes[1].legend(loc="upper right", handletextpad=0.1)
    for ax in axes[-2:]:
        ax.set(xlabel=r"$\omega/\Omega_r$", xticks=(1, 2, 3))
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
        yscale="log", ylabel="width of the peak", xlabel=r"share lost at an impact, $\varepsilon$"
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
