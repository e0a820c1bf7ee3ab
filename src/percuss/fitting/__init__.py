"""Parameters of oscillators from what was measured of their motion."""

from __future__ import annotations

from percuss.fitting.fit import fit
from percuss.fitting.losses import LossName
from percuss.fitting.result import Fit

__all__ = ["Fit", "LossName", "fit"]
