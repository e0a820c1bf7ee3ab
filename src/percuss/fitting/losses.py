"""Losses of residuals: their squares, or less where they are large."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.numerics import atan2, log

# The names of SciPy's `least_squares`.
LossName: TypeAlias = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]


@dataclass(frozen=True, slots=True)
class Loss:
    """A loss, rho(z) of z = (residual / scale)^2, with rho(z) = z for small z.

    Attributes
    ----------
    name
        As SciPy's `least_squares` has it.
    scale
        The residual, in standard deviations, beyond which it counts less.
    """

    name: LossName = "linear"
    scale: float = 1.0

    def __post_init__(self) -> None:
        """Refuse an unknown name and a scale that is not positive."""
        if self.name not in get_args(LossName):
            raise ParameterError("loss", self.name, f"none of {', '.join(get_args(LossName))}")
        if not self.scale > 0.0:
            raise ParameterError("loss_scale", self.scale, "not above 0")

    def sum(self, residuals: Floats) -> float:
        """Return the sum of the losses of residuals."""
        z = np.square(residuals / self.scale)
        if self.name == "linear":
            costs = z
        elif self.name == "soft_l1":
            costs = 2.0 * (np.sqrt(1.0 + z) - 1.0)
        elif self.name == "huber":
            costs = np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0)
        elif self.name == "cauchy":
            costs = log(1.0 + z)
        else:
            costs = atan2(z, np.ones_like(z))
        return float(costs.sum()) * self.scale * self.scale

    def weights(self, residuals: Floats) -> Floats:
        """Return what residuals are multiplied by, to the same gradient as a sum of squares."""
        z = np.square(residuals / self.scale)
        if self.name == "linear":
            return np.ones_like(z)
        if self.name == "soft_l1":
            squares = 1.0 / np.sqrt(1.0 + z)
        elif self.name == "huber":
            squares = 1.0 / np.sqrt(np.maximum(z, 1.0))
        elif self.name == "cauchy":
            squares = 1.0 / (1.0 + z)
        else:
            squares = 1.0 / (1.0 + z * z)
        return np.asarray(np.sqrt(squares))
