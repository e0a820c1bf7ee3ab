"""Comparisons that the examinations of statements share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from percuss.arrays import Floats
from percuss.model.oscillator import impact_oscillator
from percuss.motion.trajectory import Trajectory
from percuss.paper.evidence import Comparison, compare
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding, Statement

WALL = impact_oscillator()
# Of a hundred impacts of a motion without chaos, and of closed forms evaluated in doubles.
ROUNDING = 1e-10
# The error of some hundred impacts of such a motion in doubles.
DOUBLES = 1e-12
# And of one flight, or of a closed form.
ONE_FLIGHT = 1e-13


@dataclass(frozen=True)
class WithError:
    """A number that was measured, and its error."""

    value: float
    error: float


def extrapolated(values: Sequence[float], ratio: float) -> WithError:
    """Return the limit of a sequence whose distance from it falls by a ratio at each step.

    Parameters
    ----------
    values
        Two or more, from the coarse to the fine.
    ratio
        Of the distances of neighbours from the limit, above 1.

    Returns
    -------
    WithError
        The limit from the last two values. Its error is the change from the limit one step
        before; of two values, all that is removed from the last.

    Examples
    --------
    >>> extrapolated([1.5, 1.25, 1.125], 2.0)
    WithError(value=1.0, error=0.0)
    >>> extrapolated([1.5, 1.25], 2.0)
    WithError(value=1.0, error=0.25)
    """
    limits = [fine + (fine - coarse) / (ratio - 1.0) for coarse, fine in pairwise(values)]
    before = limits[-2] if len(limits) > 1 else values[-1]
    return WithError(float(limits[-1]), abs(float(limits[-1] - before)))


def last_of(values: Sequence[float] | Floats) -> WithError:
    """Return the last of a sequence that converges, its last change as the error.

    Examples
    --------
    >>> last_of([2.5, 2.25, 2.125])
    WithError(value=2.125, error=0.125)
    """
    return WithError(float(values[-1]), abs(float(values[-1] - values[-2])))


def agreement(what: str, found: WithError, expected: float, tolerance: float) -> Comparison:
    """Return the comparison of a measured number with the one that a statement gives.

    Examples
    --------
    >>> agreement("two", WithError(1.999, 0.0005), 2.0, 0.01).outcome
    'agrees'
    """
    return compare(what, found.value, expected, tolerance, error=found.error)


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
