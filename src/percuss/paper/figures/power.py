"""Power spectra of the figures on the printed scale, from the exact Fourier integral."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.arrays import Floats
from percuss.motion.spectrum import WindowName, spectrum
from percuss.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from xarray import Dataset

# Of the paper's computation: equidistant, both ends of the interval among them.
PRINTED_POINTS = 2**20
SCALE_IN_WORDS = (
    "S = |sum of x(t_j) exp(-iωt_j)|²/N over N = 2^20 points, both ends among them, no window: a "
    "line A cos ωt has the height 2^20 A²/4"
)


def power_of(
    run: Trajectory, highest: float, window: WindowName = "none", t_end: float | None = None
) -> tuple[Floats, Floats]:
    """Return the frequencies of the printed transform and the power at them, as printed.

    The sum over the points is that of the trapezoidal rule, whose integral is exact here: what lies
    above 10^4 times the highest frequency is not folded back.

    Parameters
    ----------
    run
        The run, from t = 0.
    highest
        Highest angular frequency [1/time].
    window
        "none", as printed, or "hann", whose mean is scaled to 1.
    t_end
        End of the interval; default: of the run.

    Returns
    -------
    tuple of array
        Frequencies, and |sum|²/N over N = `PRINTED_POINTS` points: the multiples of 2 pi over N
        steps, which are one step longer than the interval.
    """
    duration = run.t_end if t_end is None else t_end
    steps = PRINTED_POINTS - 1
    lowest = 2.0 * math.pi * steps / (PRINTED_POINTS * duration)
    omega: Floats = lowest * np.arange(math.floor(highest / lowest) + 1, dtype=np.float64)
    lines = spectrum(run, "exact", omega=omega, window=window, between=(0.0, duration))
    total = 0.5 * steps * (lines.cosine.values - 1j * lines.sine.values)
    if window == "none":
        # The sum counts both ends in full, the rule by half.
        first, last = run(np.array([0.0, duration]))[0]
        total += 0.5 * (first + last * np.exp(-1j * omega * duration))
    return omega, np.abs(total) ** 2 / PRINTED_POINTS


def with_power(data: Dataset, runs: dict[str, Trajectory], highest: float) -> Dataset:
    """Return a dataset with the power of each run over omega_<name>.

    Parameters
    ----------
    data
        Where to add the columns.
    runs
        The runs; all of each is used.
    highest
        Highest angular frequency [1/time].

    Returns
    -------
    xarray.Dataset
        With S_<name> as printed, and smooth_<name> under a Hann window, which keeps the lines
        apart.
    """
    columns = {}
    for name, run in runs.items():
        line = f"{name}_line"
        omega, power = power_of(run, highest)
        _, smooth = power_of(run, highest, "hann")
        columns[f"omega_{name}"] = (line, omega, {"long_name": "angular frequency"})
        columns[f"S_{name}"] = (line, power, {"long_name": "power spectrum"})
        columns[f"smooth_{name}"] = (line, smooth, {"long_name": "power, Hann window"})
    return data.assign(columns)
