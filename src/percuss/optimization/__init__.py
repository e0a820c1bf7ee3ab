"""Design: settings at which an outcome is least, largest, or as wanted, by exact gradients."""

from __future__ import annotations

from percuss.lazy import public_names
from percuss.optimization.design import Attempt, Design, design
from percuss.optimization.outcomes import OutcomeName
from percuss.optimization.pareto import ParetoFront, pareto_front

__all__ = ["Attempt", "Design", "OutcomeName", "ParetoFront", "design", "pareto_front"]

__dir__ = public_names(__name__)
