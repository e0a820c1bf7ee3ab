"""Fits: the parameters of a model from measurements of its motion."""

from __future__ import annotations

from percuss.fitting.fit import fit
from percuss.fitting.losses import LossName
from percuss.fitting.result import Fit

__all__ = ["Fit", "LossName", "fit"]
