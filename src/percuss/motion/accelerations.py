"""What drives an oscillator at one instant: the phases of its forcing, and the acceleration."""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.flight import acceleration_and_jerk, constant_force, set_phases
from percuss.kernels.law_columns import N_HARMONICS, Law


def phases_at(law: Law, t: float, t_low: float = 0.0) -> Floats:
    """Return what `set_phases` writes at t + t_low: (n_harmonics, 2)."""
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    set_phases(law, t, t_low, phases)
    return phases


def acceleration_in(
    law: Law, region: int, x: float, v: float, t: float, t_low: float = 0.0
) -> float:
    """Return x'' by the law of a region, of the state (x, v) at t + t_low."""
    force = constant_force(law, region, x)
    return float(acceleration_and_jerk(law, region, force, phases_at(law, t, t_low), 0.0, v)[0])
