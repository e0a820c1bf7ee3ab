"""Comparisons that are certain where ball arithmetic decides, and numerical where it does not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from flint import arb

from percuss.arrays import Floats
from percuss.certified import (
    Ball,
    CertifiedRun,
    certify,
    critical_velocity,
)
from percuss.certified.numbers import precision
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.start import Start
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.comparisons import ROUNDING, WALL, furthest, near
from percuss.paper.evidence import Comparison, compare

__all__ = [
    "certain_run",
    "impacts_at",
    "in_ball",
    "limit_velocity",
    "subset_constant",
]


# Of a constant that no fraction is: far more digits than are asked of any result.
CONSTANT_BITS = 512


def in_ball(
    what: str, ball: Ball, expected: float = 0.0, tolerance: float = ROUNDING
) -> Comparison:
    """Return the comparison of a number that is enclosed by a ball.

    Examples
    --------
    >>> from percuss.certified import Ball
    >>> from flint import arb
    >>> in_ball("a third", Ball(arb(1) / 3), 0.33, 0.01).outcome
    'agrees'
    """
    return compare(what, ball.mid(), float(expected), tolerance, ball.radius())


@cache
def limit_velocity(force: Forcing, low: Exact, high: Exact) -> Ball:
    """Return the velocity above which all impacts keep to the eigenset."""
    return critical_velocity(WALL, force, low, high)


def certain_run(
    run: Trajectory, start: Start | None = None, over: Mapping[str, Ball] | None = None
) -> CertifiedRun | None:
    """Return a run that is proven up to its end, or None.

    Parameters
    ----------
    run
        The run.
    start
        Its exact start; default: the one that it was given.
    over
        A number of its force as a ball; default: that of the model, which may be a double.
    """
    proven = certify(run, start=start, over=over)
    return proven if proven.complete and len(proven.impacts) == len(run.impacts) else None


@cache
def subset_constant(m: int) -> Mapping[str, Ball]:
    """Return the constant cos(pi/(m+1)) of the force of Y_m as a ball.

    The model's is a double; in a ball this narrow the constant is meant exactly.
    """
    with precision(CONSTANT_BITS):
        return {"forcing.constant": Ball((arb.pi() / (m + 1)).cos())}


def impacts_at(
    what: str,
    run: Trajectory,
    expected: Floats,
    tolerance: float = ROUNDING,
    start: Start | None = None,
    over: Mapping[str, Ball] | None = None,
) -> Comparison:
    """Return the check that the impacts of a run are at the first of the expected times.

    Parameters
    ----------
    what
        What is compared: the largest distance.
    run
        The run.
    expected
        (n,) array, true to rounding, at least as many as there are impacts [time].
    tolerance
        Largest distance that counts as agreement [time].
    start, over
        As for `certain_run`.

    Returns
    -------
    Comparison
        Certain where the run can be proven.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(WALL, pc.sine(2), v0=1, max_impacts=3)
    >>> impacts_at("times", run, np.pi * np.arange(1, 4)).outcome
    'agrees'
    """
    proven = certain_run(run, start, over)
    if proven is None or not 0 < len(run.impacts) <= len(expected):
        return near(what, furthest(run, expected), tolerance=tolerance)
    first = expected[: len(run.impacts)]
    times = proven.impacts.t
    # What the radii, and the rounding of what is expected, leave open.
    open_part = float(times.radius().max() + 2.0 * np.spacing(np.abs(first)).max())
    apart = float(np.abs(times.mid() - first).max())
    return compare(what, apart, 0.0, tolerance, math.nextafter(open_part, math.inf))
