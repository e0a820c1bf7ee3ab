"""What the examinations of statements have in common."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from percuss.arrays import Floats
from percuss.model.oscillator import impact_oscillator
from percuss.motion.trajectory import Trajectory
from percuss.paper.evidence import Comparison, compare
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding, Statement

__all__ = ["ROUNDING", "WALL", "apart", "furthest", "last_unchanged", "latest", "near", "stated"]


WALL = impact_oscillator()
# Of a hundred impacts of a motion without chaos, and of closed forms evaluated in doubles.
ROUNDING = 1e-10


def near(
    what: str, measured: float, expected: float = 0.0, tolerance: float = ROUNDING
) -> Comparison:
    """Return the check of a number, by default of a difference that is zero but for rounding.

    Examples
    --------
    >>> near("largest difference", 3e-15).outcome
    'agrees'
    """
    return compare(what, float(measured), float(expected), tolerance)


def apart(one: Floats, other: Floats) -> float:
    """Return the largest difference of two arrays.

    Examples
    --------
    >>> apart(np.array([1.0, 2.0]), np.array([1.0, 2.5]))
    0.5
    """
    return float(np.abs(one - other).max())


def furthest(run: Trajectory, expected: Floats) -> float:
    """Return the largest distance of the impact times of a run from the first expected ones.

    Infinite if the run has more impacts than are expected, or none.

    Examples
    --------
    >>> import percuss as pc
    >>> furthest(pc.simulate(WALL, v0=1.0, max_impacts=2), np.pi * np.arange(1, 4))
    0.0
    """
    times = run.impacts.t
    if not 0 < len(times) <= len(expected):
        return math.inf
    return float(np.abs(times - expected[: len(times)]).max())


def latest(run: Trajectory, index: int, default: float) -> float:
    """Return the time of an impact, or the default where the run has no such impact."""
    return float(run.impacts.t[index]) if len(run.impacts) > index else default


def last_unchanged(unchanged: Callable[[float], bool], low: float, high: float) -> float:
    """Return where a condition that holds at `low` ends, by halving down to rounding.

    Examples
    --------
    >>> last_unchanged(lambda x: x * x <= 2.0, 0.0, 2.0)
    1.414213562373095
    """
    while low < (middle := 0.5 * (low + high)) < high:
        if unchanged(middle):
            low = middle
        else:
            high = middle
    return low


def stated(theory: str, method: str) -> Callable[..., Statement]:
    """Return what makes the statements of a family: (id, reference, claim, find, formula, method).

    Parameters
    ----------
    theory
        File of docs/theory with the derivations.
    method
        How they are examined, where a statement does not say it for itself.
    """

    def make(
        id: str,
        reference: str,
        claim: str,
        find: Callable[[], Finding],
        formula: Formula | str = "",
        method: str = method,
    ) -> Statement:
        return Statement(id, reference, claim, method, find, formula, theory)

    return make
