"""Pictures of the resonances of the elastic impact oscillator: where, how fast, and why."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.paper.claims.resonances import GOLDEN, OF_ORDER
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, label, panels, styled
from percuss.paper.models.averaging import order, strength
from percuss.paper.models.resonance_runs import ensemble, run_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

MOTIONS, IMPACTS = 16, 10_000
# Not a ratio 2 p / q of small numbers: golden means between the neighbours that are.
BETWEEN = ("0.447", "0.618", "0.715", "0.927", "1.073", "1.382", "1.854", "2.164", "2.618", "3.131")
# For each order, and for none.
ORDER_COLOURS = {
    1: "#D55E00",
    2: "#E69F00",
    3: "#009E73",
    4: "#0072B2",
    5: "#56B4E9",
    6: "#CC79A7",
    7: "#000000",
    0: "#A0A0A0",
}
PORTRAITS = ("2", "1", "2/3", "0.618")


def _group(omega: Fraction) -> int:
    """Return the order q of 2 p / q up to 7, else 0."""
    _, q = order(omega)
    return q if q <= 7 else 0


def _scanned() -> list[Fraction]:
    ratios = {Fraction(2 * p, q) for q in range(1, 8) for p in range(1, 2 * q)}
    chosen = {omega for omega in ratios if Fraction(1, 4) < omega <= Fraction(10, 3)}
    return sorted(chosen | {Fraction(4)} | {Fraction(text) for text in BETWEEN})


def scan() -> Dataset:
    """Return the speeds that slow starts reach, over the frequency of the force."""
    import xarray as xr

    omegas = _scanned()
    runs = [ensemble(omega, MOTIONS, IMPACTS) for omega in omegas]
    return xr.Dataset(
        {
            "largest": ("omega", [float(np.median(one.largest[:, -1])) for one in runs]),
            "typical": ("omega", [float(np.median(one.typical[:, -1])) for one in runs]),
            "share": ("omega", [one.share_growing() for one in runs]),
            "order": ("omega", [_group(omega) for omega in omegas]),
            "ratio": ("omega", [str(omega) for omega in omegas]),
        },
        coords={"omega": [float(omega) for omega in omegas]},
        attrs={"motions": MOTIONS, "impacts": IMPACTS},
    )


def _scan_caption(data: Dataset) -> str:
    low, seven, none = (
        float(data.share[(data.order > least) & (data.order <= most) & (data.omega != 3.0)].mean())
        for least, most in ((0, 6), (6, 7), (-1, 0))
    )
    odd = float(data.share.sel(omega=3.0))
    return (
        f"Where x'' + x = cos(ωt + phase), x > 0, restitution 1 grows: {data.sizes['omega']} "
        f"frequencies, {data.motions} motions each with random phases and speeds below 2, followed "
        f"for {data.impacts} impacts. (a) Median of the largest speed, and (open) of the "
        "typical one. (b) Share of motions whose largest speed grew by 1.3 in the last decade. "
        f"The colour is q of ω = 2p/q; (c) names the frequencies. Up to 6 the share is {low:.2f} in the mean, at 7 it is "
        f"{seven:.2f} (growth that ends at a higher speed), elsewhere {none:.3f}, and {odd:.0f} "
        "at ω = 3."
    )


@styled
def _draw_scan(data: Dataset) -> Picture:
    figure, (speeds, shares, names) = panels(3, 2.6)
    for row, (q, colour) in enumerate(ORDER_COLOURS.items()):
        one = data.sel(omega=data.order == q)
        speeds.vlines(one.omega, one.typical, one.largest, color=colour, lw=0.8)
        speeds.semilogy(one.omega, one.largest, "o", color=colour, ms=4.5)
        speeds.semilogy(one.omega, one.typical, "o", color=colour, ms=4.5, mfc="white")
        shares.vlines(one.omega, 0.0, one.share, color=colour, lw=0.8)
        shares.plot(one.omega, one.share, "o", color=colour, ms=4.5, clip_on=False)
        for omega, ratio in zip(one.omega.values, one.ratio.values, strict=True):
            text = str(Fraction(ratio)) if q else f"{omega:g}"
            # The decimals are wide: every other one a line lower.
            lower = 0.0 if q else 0.7 * (list(one.omega.values).index(omega) % 2)
            names.text(
                omega,
                row + lower,
                text,
                color=colour,
                ha="center",
                va="center",
                fontsize=8 if q else 7,
            )
    speeds.set(ylabel=f"speed after {data.impacts} impacts", ylim=(0.5, 1e5))
    shares.set(ylabel="share that grows", ylim=(0, 1.05), xlim=(0.1, 4.2))
    names.set(xlabel=r"frequency $\omega$", ylabel="order", ylim=(len(ORDER_COLOURS), -0.6))
    rows = [f"$q={q}$" if q else "others" for q in ORDER_COLOURS]
    names.set_yticks(range(len(rows)), rows)
    for tick, colour in zip(names.get_yticklabels(), ORDER_COLOURS.values(), strict=True):
        tick.set_color(colour)
    label(speeds, "largest speed (filled) and typical speed (open), medians", "a")
    label(shares, "share of motions that still grow", "b")
    label(names, r"the frequencies $\omega=2p/q$ above, by order $q$", "c")
    return figure


def growth() -> Dataset:
    """Return how speeds grow with the number of impacts, for each order and for none."""
    import xarray as xr

    data: dict[str, tuple[str, object]] = {}
    exponents = []
    chosen = {**OF_ORDER, 0: (GOLDEN, 24, 20_000)}
    for q, followed in chosen.items():
        runs = ensemble(*followed)
        dimension = f"count_{q}"
        data[dimension] = (dimension, runs.counts)
        data[f"typical_{q}"] = (dimension, np.median(runs.typical, axis=0))
        data[f"largest_{q}"] = (dimension, np.median(runs.largest, axis=0))
        exponents.append(runs.exponent("typical"))
    data["exponent"] = ("q", [value for value, _ in exponents])
    data["exponent_error"] = ("q", [error for _, error in exponents])
    omegas = [str(followed[0]) for followed in chosen.values()]
    return xr.Dataset({**data, "ratio": ("q", omegas)}, coords={"q": list(chosen)})


def _growth_caption(data: Dataset) -> str:
    rates = ", ".join(
        f"{float(one.exponent):.3f} ± {float(one.exponent_error):.3f} (q = {int(q)})"
        for q, one in data.groupby("q")
        if int(q) > 0
        for one in (one.squeeze(),)
    )
    return (
        "How the typical speed (dots) and the largest one so far (thin lines) grow with the number "
        "of impacts, medians over an ensemble of slow starts with random phases. Dotted: slopes "
        f"1/q. Fitted exponents of the typical speed: {rates}. Without a ratio 2p/q the speed "
        "stays."
    )


@styled
def _draw_growth(data: Dataset) -> Picture:
    figure, (ax,) = panels(1, 4.2)
    for q in data.q.values.tolist():
        counts, typical = data[f"count_{q}"].values, data[f"typical_{q}"].values
        colour, ratio = ORDER_COLOURS[q], data.ratio.sel(q=q).item()
        name = rf"$q={q}$, $\omega={ratio}$" if q else rf"$\omega={float(Fraction(ratio)):.4f}$"
        ax.loglog(counts, typical, "o", color=colour, ms=4.5, label=name)
        ax.loglog(counts, data[f"largest_{q}"], color=colour, lw=0.7)
        slope = 1.0 / q if q else 0.0
        ax.loglog(counts, typical[-1] * (counts / counts[-1]) ** slope, ":", color=colour, lw=1.0)
    ax.set(xlabel="number of impacts", ylabel="speed after an impact")
    ax.legend(loc="upper left")
    return figure


def portraits() -> Dataset:
    """Return motions in the plane of speed and phase, and the levels of the averaged H."""
    import xarray as xr

    data: dict[str, object] = {}
    for text in PORTRAITS:
        omega = Fraction(text)
        largest = 60.0 if omega == 2 else 20.0
        for number, (phase, speed) in enumerate(_starts(omega, largest)):
            x, y = _plane(omega, phase, speed)
            inside = np.hypot(x, y) < 1.05 * largest
            name = f"{text.replace('/', '_')}_{number}"
            columns = {"x": x, "y": y, "grows": _grows(np.hypot(x, y))}
            data |= {f"{what}_{name}": (f"impact_{name}", v[inside]) for what, v in columns.items()}
    orders = [order(Fraction(text))[1] for text in PORTRAITS]
    strengths = [strength(Fraction(text)) for text in PORTRAITS]
    return xr.Dataset(
        {**data, "strength": ("ratio", strengths), "order": ("ratio", orders)},
        coords={"ratio": list(PORTRAITS)},
    )


def _starts(omega: Fraction, largest: float) -> list[tuple[float, float]]:
    """Return phases and speeds of starts, spread over the plane."""
    if omega == 2:
        # They come in from below and leave above.
        return [(-math.pi - angle, largest) for angle in (0.9, 1.2, 1.5, 1.8, 2.1)]
    if omega == 1:
        return [(math.pi * (k + 0.5) / 8.0, 8.0) for k in range(16)]
    if omega == Fraction(2, 3):
        return [(angle, speed) for speed in (6.0, 10.0, 15.0) for angle in (0.1, 0.6)]
    return [(0.0, speed) for speed in (3.0, 6.0, 10.0, 14.0, 18.0)]


def _plane(omega: Fraction, phase: float, speed: float) -> tuple[Floats, Floats]:
    """Return V (cos psi, sin psi) with psi in the middle of the flights."""
    hits = run_of(omega, phase, speed, 3000).impacts
    psi = 2.0 * math.pi * hits.cycle + phase + 0.5 * math.pi * float(omega)
    return hits.v_after * np.cos(psi), hits.v_after * np.sin(psi)


def _grows(speed: Floats) -> Flags:
    """Return where the speed grows, over 12 impacts: a whole number of turns of each order."""
    before, after = (np.clip(np.arange(speed.size) + shift, 0, speed.size - 1) for shift in (-6, 6))
    return np.asarray(speed[after] > speed[before], dtype=np.bool_)


def _portrait_caption(data: Dataset) -> str:
    numbers = ", ".join(
        f"{float(one.strength):.4g} at ω = {ratio}"
        for ratio, one in data.groupby("ratio")
        for one in (one.squeeze(),)
        if int(one.order) <= 4
    )
    return (
        "Motions in the plane V(cos ψ, sin ψ), with V the speed after an impact and ψ the phase of "
        "the force in the middle of the flight; grey, the levels of the averaged H = V²⁻ᵠ h cos "
        f"qψ, h = {numbers}. Vermilion: the speed grows over the next impacts; blue: it falls. "
        "First order: straight lines, all motions leave in one direction, which attracts. "
        "Second order: rays; the phase stays. Third order: petals; the outgoing directions repel, "
        "motions come back to low speeds, and leave again. Far from a ratio 2p/q "
        "of small numbers, the levels are circles, and nothing grows."
    )


@styled
def _draw_portraits(data: Dataset) -> Picture:
    figure, axes = panels(4, 2.8, columns=2, share_x=False)
    for ax, text, letter in zip(axes, PORTRAITS, "abcd", strict=True):
        _draw_levels(ax, data.sel(ratio=text), 60.0 if text == "2" else 20.0)
        number, stem = 0, text.replace("/", "_")
        while (name := f"{stem}_{number}") and f"x_{name}" in data:
            grows = data[f"grows_{name}"].values
            for chosen, colour in ((~grows, COLOURS["limit"]), (grows, COLOURS["stiff"])):
                x, y = (data[f"{what}_{name}"].values[chosen] for what in "xy")
                # As pixels: as paths the points would take megabytes.
                ax.plot(x, y, ".", color=colour, ms=1.6, rasterized=True)
            number += 1
        q = int(data.order.sel(ratio=text))
        label(ax, rf"$\omega={text}$, " + (f"order {q}" if q <= 6 else "none"), letter)
        ax.set(xlabel=r"$V\,\cos\,\psi$", ylabel=r"$V\,\sin\,\psi$")
    return figure


def _draw_levels(ax: Axes, one: Dataset, largest: float) -> None:
    """Draw levels of H, equally spaced in the speed at which they pass their best phase."""
    line = np.linspace(-largest, largest, 301)
    x, y = np.meshgrid(line, line)
    speed, angle = np.hypot(x, y) + 1e-9, np.arctan2(y, x)
    q = int(one.order)
    if q <= 6:
        level = speed ** (2 - q) * np.cos(q * angle)
        at = (largest * np.linspace(0.1, 0.9, 5)) ** (2.0 - q) if q != 2 else np.linspace(0, 0.9, 5)
        levels = np.unique(np.concatenate((-at, at)))
    else:
        level, levels = speed, largest * np.linspace(0.1, 0.9, 5)
    ax.contour(
        x, y, level, levels=np.sort(levels), colors="#BBBBBB", linewidths=0.6, linestyles="-"
    )
    ax.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")


FIGURES = (
    Figure("resonance-scan", "Which frequencies resonate", _scan_caption, scan, _draw_scan),
    Figure("resonance-growth", "How fast the speed grows", _growth_caption, growth, _draw_growth),
    Figure(
        "resonance-portraits",
        "Why: the averaged motion",
        _portrait_caption,
        portraits,
        _draw_portraits,
    ),
)
