"""Power spectra of the figures, from the exact Fourier integral."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.motion.spectrum import spectrum
from percuss.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["with_power"]


def with_power(data: Dataset, runs: dict[str, Trajectory], highest: float) -> Dataset:
    """Return a dataset with the power spectrum S_<name> over omega_<name> of each run.

    Parameters
    ----------
    data
        Where to add the columns.
    runs
        The runs; all of each is used, under a Hann window.
    highest
        Highest angular frequency [1/time].

    Returns
    -------
    xarray.Dataset
        S = |X|^2 with X the mean of x exp(-i omega t) under the window: a line A cos(omega t) has
        the height A^2/4. The Fourier integral is exact (no aliasing), at the multiples of 2 pi over
        the duration.
    """
    columns = {}
    for name, run in runs.items():
        step = 2.0 * math.pi / (run.t_end - run.t0)
        omega = step * np.arange(math.floor(highest / step) + 1)
        amplitude = spectrum(run, "exact", omega=omega, window="hann").amplitude.values
        columns[f"omega_{name}"] = (f"{name}_line", omega, {"long_name": "angular frequency"})
        columns[f"S_{name}"] = (f"{name}_line", amplitude**2 / 4, {"long_name": "power spectrum"})
    return data.assign(columns)
