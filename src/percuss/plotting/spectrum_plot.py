"""The spectrum of a motion, on a logarithmic scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.spectrum import spectrum
from percuss.motion.trajectory import Trajectory
from percuss.plotting.samples import reduce_to_columns
from percuss.plotting.style import (
    BLUE,
    ORANGE,
    Units,
    picture,
    units_of,
)

if TYPE_CHECKING:
    from xarray import Dataset


# Lines further below the highest than the first are rounding, and not drawn; a curve, which has
# zeros between its side lobes, is cut at the second.
ROUNDING, DEPTH = 1e-14, 1e-10


def plot_spectrum(
    result: Dataset | Trajectory,
    ax: Axes | None = None,
    *,
    resonance: float | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw the amplitudes of a spectrum over the angular frequency.

    Parameters
    ----------
    result
        What `percuss.spectrum` or `percuss.line_spectrum` has returned; or a run, whose exact
        spectrum is then drawn.
    ax
        Axes to draw on; default: those of a new figure.
    resonance
        Resonant frequency, marked by a vertical line [1/time]; default: that of the run's
        oscillator, if it has one.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; the lines of a periodic motion are drawn as lines.
    """
    units = units_of(units)
    if isinstance(result, Trajectory):
        resonance = _resonance(result) if resonance is None else resonance
        result = spectrum(result)
    omega = np.asarray(result["omega"].values, dtype=np.float64)
    amplitude = np.asarray(result["amplitude"].values, dtype=np.float64)
    is_velocity = result.attrs["of"] == "velocity"
    with picture(ax) as ax:
        ax.set_yscale("log")
        highest = float(amplitude.max(initial=0.0)) or 1.0
        if "line" in result.dims:
            _draw_lines(ax, omega, amplitude, ROUNDING * highest)
        else:
            _draw_curve(ax, omega, amplitude, DEPTH * highest)
        if resonance is not None:
            ax.axvline(resonance, color=ORANGE, linewidth=1.0, label="resonant frequency")
            ax.legend(loc="upper right")
        if len(omega) > 1:
            ax.set_xlim(float(omega.min()), float(omega.max()))
        unit = "dimensionless" if units.duration == "dimensionless" else f"1/{units.duration}"
        ax.set_xlabel(f"angular frequency $\\omega$ ({unit})")
        what = "velocity" if is_velocity else "displacement"
        of_what = units.velocity if is_velocity else units.displacement
        ax.set_ylabel(f"amplitude of the {what}\n({of_what})")
    return ax


def _resonance(run: Trajectory) -> float | None:
    try:
        return resonant_frequency(run.oscillator)
    except ParameterError:
        return None


def _draw_curve(ax: Axes, omega: Floats, amplitude: Floats, floor: float) -> None:
    order = np.argsort(omega, kind="stable")
    no_jumps = np.zeros(len(omega), dtype=np.bool_)
    shown, heights, _ = reduce_to_columns(
        omega[order], np.maximum(amplitude[order], floor), no_jumps
    )
    ax.plot(shown, heights, color=BLUE, linewidth=0.8)


def _draw_lines(ax: Axes, omega: Floats, amplitude: Floats, floor: float) -> None:
    seen = amplitude > floor
    heights = amplitude[seen]
    if heights.size == 0:
        return
    bottom = 0.5 * float(heights.min())
    ax.vlines(omega[seen], bottom, heights, color=BLUE, linewidth=1.0)
    ax.plot(omega[seen], heights, "o", color=BLUE, markersize=3.0)
    ax.set_ylim(bottom, 2.0 * float(heights.max()))
