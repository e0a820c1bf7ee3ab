"""The envelope b t^p of impact velocities, by least squares."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["power_law"]


def power_law(t: ArrayLike, values: ArrayLike) -> tuple[float, float, float]:
    """Fit b t^p to values, by least squares of the logarithms.

    Parameters
    ----------
    t, values
        (n,) arrays, positive, n >= 3.

    Returns
    -------
    tuple of float
        The factor b, the exponent p, and the standard error of p.

    Examples
    --------
    >>> t = np.arange(1.0, 50.0)
    >>> [round(number, 12) + 0.0 for number in power_law(t, 0.6 * np.sqrt(t))]
    [0.6, 0.5, 0.0]
    """
    x, y = np.log(np.asarray(t)), np.log(np.asarray(values))
    slope, level = np.polyfit(x, y, 1)
    residual = y - (slope * x + level)
    spread = float(np.sum((x - x.mean()) ** 2))
    error = math.sqrt(float(np.sum(residual**2)) / (x.size - 2) / spread)
    return math.exp(float(level)), float(slope), error
