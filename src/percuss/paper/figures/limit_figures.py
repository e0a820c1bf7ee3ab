"""Pictures of the two limits: a stiff spring for a wall, and a rounded kink."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import bilinear_oscillator
from percuss.motion.simulate import simulate
from percuss.paper.claims.bilinear_limit import (
    first_delays,
    graze,
    graze_error,
    impact_run,
    local_orders,
    saturation_speed,
    time_errors,
)
from percuss.paper.claims.limits import GRAZES
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, label, panels, styled
from percuss.paper.models.motions import impact_speeds
from percuss.paper.models.smooth_law import rounded_magnitude
from percuss.paper.models.smoothing_errors import (
    BELOW,
    CHAOTIC_RADII,
    RADII,
    chaotic_errors,
    crossing_errors,
    grazing_errors,
    grazing_jump,
    stiff_errors,
    time_gained,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

STIFFNESSES = 10.0 ** np.arange(4, 15)
IMPACTS = (2, 4, 6)
BEATING = (1e3, 1e4)
STIFF = (1e2, 1e4, 1e6)
STIFF_RADII = np.geomspace(0.3, 1e-4, 15)
LOOKS = (COLOURS["limit"], COLOURS["stiff"], COLOURS["soft"])


def limit_of_stiffness() -> Dataset:
    """Return the errors of impact times and at a graze over k-, and two beats."""
    import xarray as xr

    chosen = [k - 1 for k in IMPACTS]
    delays = [time_errors(float(k))[chosen] for k in STIFFNESSES]
    grazes = {name: graze(*which) for name, which in GRAZES.items()}
    jumps = [[abs(graze_error(one, float(k))) for k in STIFFNESSES] for one in grazes.values()]
    data = {
        "delay": (("stiffness", "impact"), np.array(delays)),
        "first_order": ("impact", first_delays(impact_run())[chosen]),
        "jump": (("graze", "stiffness"), np.array(jumps)),
        "predicted": ("stiffness", [grazes["low"].predicted(float(k)) for k in STIFFNESSES]),
        "largest": ("beat", [saturation_speed(2, k) for k in BEATING]),
    }
    for k in BEATING:
        run = simulate(
            bilinear_oscillator(stiffness_below=k), sine(2), t_end=1.1 * math.pi * math.sqrt(1e4)
        )
        times, speeds = impact_speeds(run)
        count = min(len(times), len(speeds))
        data[f"t_{k:.0f}"] = (f"entry_{k:.0f}", times[:count])
        data[f"v_{k:.0f}"] = (f"entry_{k:.0f}", speeds[:count])
    coords = {"stiffness": STIFFNESSES, "impact": list(IMPACTS), "graze": list(GRAZES)}
    return xr.Dataset(data, coords=coords | {"beat": list(BEATING)})


def _limit_caption(data: Dataset) -> str:
    k = data.stiffness.values[-2:]
    delay, low, high = (
        float(local_orders(k, values[-2:])[0])
        for values in (data.delay.values[:, -1], data.jump.values[0], data.jump.values[1])
    )
    return (
        "How the bilinear oscillator (stiffness 1 above, k₋ below) tends to the impact oscillator. "
        "(a) How much later impacts 2, 4 and 6 come under cos 1.7t; the dotted lines are the "
        f"derived delays. The last slope of impact 6 is {delay:.4f}. (b) The velocity gained at a "
        f"graze: slope {low:.3f} where the stiff oscillator arrives too low, {high:.3f} where it "
        "passes above. (c) For finite k₋ the resonance under sin 2t is a beat, up to "
        "4√k₋/3π (dotted); the impact oscillator grows for ever."
    )


@styled
def _draw_limit(data: Dataset) -> Picture:
    figure, (delays, jumps, beats) = panels(3, 2.6, share_x=False)
    k = data.stiffness.values
    for look, impact in zip(LOOKS, data.impact.values, strict=True):
        one = data.sel(impact=impact)
        delays.loglog(k, one.delay, ".", color=look, ms=6, label=f"impact {impact}")
        delays.loglog(k, float(one.first_order) / np.sqrt(k), ":", color=look, lw=1.0)
    delays.set_ylabel(r"delay $t_j(k_-)-t_j$")
    words = {"low": "arrives too low", "high": "passes above"}
    for look, name in zip(LOOKS[1:], words, strict=True):
        jumps.loglog(k, data.jump.sel(graze=name), ".", color=look, ms=6, label=words[name])
    jumps.loglog(k, data.predicted, ":", color=LOOKS[1], lw=1.0)
    high = data.jump.sel(graze="high").values
    jumps.loglog(k, high[-1] * np.sqrt(k[-1] / k), ":", color=LOOKS[2], lw=1.0)
    jumps.set_ylabel("error after a graze")
    for ax in (delays, jumps):
        ax.set_xlabel("stiffness $k_-$")
        ax.legend(loc="upper right")
    for look, k_below in zip(LOOKS[1:], data.beat.values, strict=True):
        _draw_beat(beats, data, float(k_below), look)
    longest = float(data[f"t_{BEATING[-1]:.0f}"].max())
    beats.plot([0, longest], [0, longest * 4 / 3 / math.pi], color=LOOKS[0], label="a wall")
    beats.set(xlim=(0, longest), ylim=(0, 78), xlabel="time $t$", ylabel="speed after an impact")
    beats.legend(loc="upper right")
    for ax, letter, words_above in (
        (delays, "a", "away from grazing"),
        (jumps, "b", "at a graze"),
        (beats, "c", r"under $\sin 2t$, from rest"),
    ):
        label(ax, words_above, letter)
    return figure


def _draw_beat(ax: Axes, data: Dataset, stiffness: float, look: str) -> None:
    t, v = data[f"t_{stiffness:.0f}"], data[f"v_{stiffness:.0f}"]
    power = round(math.log10(stiffness))
    ax.plot(t, v, color=look, label=f"$k_-=10^{power}$")
    ax.axhline(float(data.largest.sel(beat=stiffness)), color=look, lw=0.8, ls=":")


def smoothed_law() -> Dataset:
    """Return the rounded force laws and what the rounding changes."""
    import xarray as xr

    x = np.linspace(-1.5, 1.5, 301)
    mean, half = 0.5 * (1.0 + 4.0), 0.5 * (4.0 - 1.0)
    shapes = {
        "kink": rounded_magnitude(x, 0.0),
        "parabola": rounded_magnitude(x, 1.0),
        "hyperbola": rounded_magnitude(x, 1.0, "hyperbola"),
    }
    times, errors = chaotic_errors()
    stiff = [[abs(stiff_errors(k, float(r))[0]) for r in STIFF_RADII] for k in STIFF]
    return xr.Dataset(
        {
            "force": (("shape", "x"), [mean * x - half * m for m in shapes.values()]),
            "crossing": ("radius", crossing_errors()),
            "hyperbola": ("radius", crossing_errors("hyperbola")),
            "grazing": ("radius", grazing_errors()),
            "jump": ("radius", grazing_jump(RADII)),
            "stiff": (("stiffness", "stiff_radius"), stiff),
            "chaotic": (("chaotic_radius", "t"), errors),
            "gained": time_gained()[0],
            "gained_error": time_gained()[1],
        },
        coords={
            "shape": list(shapes),
            "x": x,
            "radius": RADII,
            "stiffness": list(STIFF),
            "stiff_radius": STIFF_RADII,
            "t": times,
            "chaotic_radius": list(CHAOTIC_RADII),
        },
    )


def _smoothed_caption(data: Dataset) -> str:
    crossing, grazing = (
        float(local_orders(data.radius.values, data[name].values)[-4:].mean())
        for name in ("crossing", "grazing")
    )
    return (
        "What a kink rounded with radius rho changes. (a) The force law for rho = 1, k₊ = 1, k₋ = 4. "
        f"(b) The error with k₋ = {BELOW:g}: order {crossing:.3f} in rho (largest up to t = 20, all "
        f"crossings of x = 0 fast) and {grazing:.3f} at a touch of x = 0; dotted, the derived "
        "jump. (c) After one impact, for three k₋: once rho exceeds the penetration V/√k₋ the "
        "rounded spring acts as a wall at rho, and the error is of first order (dashed: rho/3, as a "
        "guide). (d) Where the bilinear motion is chaotic (cos 2.6t) errors grow exponentially: a "
        f"tenth of rho gains {float(data.gained):.0f} +- {float(data.gained_error):.0f} units of time "
        "in the mean over many starts."
    )


@styled
def _draw_smoothed(data: Dataset) -> Picture:
    figure, (law, orders, stiff, chaos) = panels(4, 2.7, columns=2, share_x=False)
    names = {"kink": "bilinear", "parabola": "parabola", "hyperbola": "hyperbola"}
    for look, (shape, name) in zip(("black", *LOOKS[:2]), names.items(), strict=True):
        law.plot(data.x, data.force.sel(shape=shape), color=look, label=name, lw=1.1)
    law.set(xlabel=r"$x/\rho$", ylabel="force of the springs", xlim=(-1.5, 1.5), ylim=(-6.5, 2))
    radius = data.radius.values
    for look, name, word in zip(
        (LOOKS[1], LOOKS[0], LOOKS[2]),
        ("grazing", "crossing", "hyperbola"),
        ("touch", "crossings", "same, hyperbola"),
        strict=True,
    ):
        orders.loglog(radius, data[name], ".", color=look, ms=5, label=word)
    orders.loglog(radius, data.jump, ":", color=LOOKS[1], lw=1.0)
    orders.set(xlabel=r"$\rho$", ylabel="error")
    for look, k in zip(LOOKS, data.stiffness.values, strict=True):
        power = round(math.log10(k))
        one = data.stiff.sel(stiffness=k)
        stiff.loglog(data.stiff_radius, one, ".-", color=look, lw=0.8, label=f"$k_-=10^{power}$")
    stiff.loglog(data.stiff_radius, data.stiff_radius / 3.0, "--", color="black", lw=0.7)
    stiff.set(xlabel=r"$\rho$", ylabel="error", ylim=(1e-11, 1))
    shades = np.linspace(0.15, 0.75, len(data.chaotic_radius))
    for shade, (name, one) in zip(shades, data.chaotic.groupby("chaotic_radius"), strict=True):
        power = round(math.log10(name))
        largest = np.maximum.accumulate(one.values.ravel())
        chaos.semilogy(data.t, largest, color=str(shade), label=rf"$\rho=10^{{{power}}}$", lw=1.0)
    chaos.set(xlabel="time $t$", ylabel="largest error so far", ylim=(1e-11, 10))
    for ax, letter in zip((law, orders, stiff, chaos), "abcd", strict=True):
        label(
            ax,
            {"a": "force law", "b": "small radius", "c": "stiff", "d": "chaotic"}[letter],
            letter,
        )
        ax.legend(loc="lower right", fontsize=7.5, handlelength=1.2)
    return figure


FIGURES = (
    Figure(
        "limit-stiff",
        "From bilinear to rigid",
        _limit_caption,
        limit_of_stiffness,
        _draw_limit,
    ),
    Figure("limit-smoothed", "A rounded kink", _smoothed_caption, smoothed_law, _draw_smoothed),
)
