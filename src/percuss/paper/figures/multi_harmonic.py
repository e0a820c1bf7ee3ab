"""Figure 5: the multi-harmonic resonances n = 2, 4 and 6."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.simulate import simulate
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, draw_curve, draw_frame, panels, reach, styled
from percuss.paper.figures.printed_frames import FRAMES
from percuss.paper.figures.words import within
from percuss.paper.models.motions import motion_dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

HARMONICS = (2, 4, 6)
T_END = 8 * math.pi
LOOKS = dict(zip(HARMONICS, (COLOURS["limit"], COLOURS["stiff"], COLOURS["soft"]), strict=True))


def resonances() -> Dataset:
    """Return the motions from rest under sin 2t, sin 4t and sin 6t, and their impact velocities."""
    # A little beyond the last impact, which rounding may put on either side of the end.
    runs = {
        f"n{n}": simulate(impact_oscillator(), sine(n), x0=0, v0=0, t_end=T_END + 0.01)
        for n in HARMONICS
    }
    data = motion_dataset(runs, v0=0.0)
    gains, printed, off = [], [], []
    for n in HARMONICS:
        times, speeds = data[f"impact_t_n{n}"].values, data[f"impact_v_n{n}"].values
        gains.append(float(np.diff(speeds, prepend=0.0).mean()))
        printed.append(2 * n / (n * n - 1))
        off.append(float(np.abs(times - math.pi * np.arange(1, times.size + 1)).max()))
    columns = {"gain": gains, "printed_gain": printed, "time_error": off}
    return data.assign({name: ("n", value) for name, value in columns.items()}).assign_coords(
        n=list(HARMONICS)
    )


def _caption(data: Dataset) -> str:
    gains = ", ".join(
        f"{float(gain):.12f} for n = {int(n)}" for n, gain in zip(data.n, data.gain, strict=True)
    )
    apart = float(np.abs(data.gain - data.printed_gain).max())
    return (
        "Multi-harmonic resonances x'' + x = sin nt from rest (the article does not state V0; its "
        f"plot agrees with V0 = 0). The velocity gained at an impact is {gains}: 2n/(n^2-1) of "
        f"(19) {within(apart)}. The impact times are kπ "
        f"{within(float(data.time_error.max()))}. Dotted: the impact velocities, on straight lines."
    )


@styled
def _draw(data: Dataset) -> Picture:
    figure, (ax,) = panels(1, 3.4)
    for n in HARMONICS:
        t, x = data[f"t_n{n}"].values / math.pi, data[f"x_n{n}"].values
        draw_curve(ax, t, x, color=LOOKS[n], label=f"$n={n}$")
        times, speeds = data[f"impact_t_n{n}"].values / math.pi, data[f"impact_v_n{n}"].values
        ax.plot(times, speeds, ":", color=LOOKS[n], marker=".", lw=1.0, clip_on=False)
    (frame,) = FRAMES["fig5"]
    top = max(float(data[f"{what}_n{n}"].max()) for n in HARMONICS for what in ("x", "impact_v"))
    draw_frame(ax, frame, y=reach([0.0, top], frame.upwards))
    ax.set(xlabel=r"$t/\pi$", ylabel="displacement $x(t)$")
    ax.legend(loc="upper left")
    return figure


FIGURES = (
    Figure("fig5", "Multi-harmonic resonances", _caption, resonances, _draw, FRAMES["fig5"]),
)
