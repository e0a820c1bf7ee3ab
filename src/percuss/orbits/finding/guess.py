"""Where Newton's method starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.kernels.record import Integers

__all__ = ["Guess"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Guess:
    """Where to start Newton's method.

    Attributes
    ----------
    chain
        (n, 3) array, the events.
    unknowns
        (2 n + 1,) array: instant of event 0, durations, velocities after the events.
    n_impacts, n_periods
        What the orbit would have.
    trial
        Which start of a search it comes from.
    """

    chain: Integers
    unknowns: Floats
    n_impacts: int
    n_periods: int
    trial: int = 0
