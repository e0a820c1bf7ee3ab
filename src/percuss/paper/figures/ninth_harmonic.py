"""Figure 9: the periodic motion n = 9 just above its critical velocity."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.eigenset_forms import harmonic_critical_velocity
from percuss.motion.simulate import simulate
from percuss.paper.figure import Figure
from percuss.paper.figures.drawing import COLOURS, draw_curve, draw_frame, panels, reach, styled
from percuss.paper.figures.printed_frames import FRAMES
from percuss.paper.figures.words import within
from percuss.paper.models.motions import motion_dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture
    from xarray import Dataset

V0, N = "0.139", 9
PERIODS = 50


def ninth() -> Dataset:
    """Return one period of the motion, and how far its impact times stray in 50 periods."""
    osc = impact_oscillator()
    run = simulate(osc, sine(N), x0=0, v0=V0, t_end=2 * math.pi)
    long = simulate(osc, sine(N), x0=0, v0=V0, max_impacts=2 * PERIODS)
    times = math.pi * np.arange(1, 2 * PERIODS + 1)
    data = motion_dataset({"limit": run}, v0=float(V0))
    t, x = data.t_limit.values, data.x_limit.values
    second = t > math.pi
    # The lowest of the waves on the second flight: its interior minima come close to the wall.
    inner = np.flatnonzero((x[1:-1] < x[:-2]) & (x[1:-1] < x[2:]) & second[1:-1]) + 1
    return data.assign(
        time_error=float(np.abs(long.impacts.t - times).max()),
        clearance=float(x[inner].min()) if inner.size else float("nan"),
    )


def _caption(data: Dataset) -> str:
    return (
        f"Driven at n = {N} from V0 = {V0}, just above the critical velocity "
        f"{harmonic_critical_velocity(N):.12f}: one period. Over {PERIODS} periods the impact times are kπ "
        f"{within(float(data.time_error))}. On the second flight the lowest interior minimum clears "
        f"the wall by {float(data.clearance):.2e} only, which at the critical velocity is 0."
    )


@styled
def _draw(data: Dataset) -> Picture:
    figure, (ax,) = panels(1, 3.0)
    draw_curve(ax, data.t_limit.values / math.pi, data.x_limit.values, color=COLOURS["limit"])
    ax.plot([0, 1, 2], [0, 0, 0], "o", color="black", ms=4, clip_on=False, zorder=3)
    (frame,) = FRAMES["fig9"]
    draw_frame(ax, frame, y=reach(np.maximum(data.x_limit, 0.0), frame.upwards))
    ax.set(xlabel=r"$t/\pi$", ylabel="displacement $x(t)$")
    return figure


FIGURES = (
    Figure(
        "fig9", "Ninth harmonic above its critical velocity", _caption, ninth, _draw, FRAMES["fig9"]
    ),
)
