"""Comparisons that are certain where ball arithmetic decides, and numerical where it does not."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from flint import arb

from percuss.arrays import Floats
from percuss.certified import (
    Ball,
    CertifiedRun,
    certify,
    critical_velocity,
    keeps_eigenset,
    keeps_subset,
)
from percuss.certified.numbers import precision
from percuss.model.exact import Exact, Phase
from percuss.model.forcing import Forcing
from percuss.model.start import Start
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.evidence import ROUNDING, WALL, condition, furthest, near
from percuss.paper.statement import Check

__all__ = [
    "certain_condition",
    "certain_run",
    "eigenset_kept",
    "impacts_at",
    "in_ball",
    "limit_velocity",
    "subset_constant",
    "subset_kept",
]


# Of a constant that no fraction is: far more digits than are asked of any result.
CONSTANT_BITS = 512


def in_ball(what: str, ball: Ball, expected: float = 0.0, tolerance: float = ROUNDING) -> Check:
    """Return the check of a number that is enclosed by a ball.

    Examples
    --------
    >>> from percuss.certified import Ball
    >>> from flint import arb
    >>> in_ball("a third", Ball(arb(1) / 3), 0.33, 0.01).is_certain
    True
    """
    return Check(what, ball.mid(), float(expected), tolerance, ball.radius())


def eigenset_kept(
    what: str,
    force: Forcing | None,
    v0: Exact,
    numerical: Callable[[], bool],
    *,
    kept: bool = True,
    t0: Phase = 0,
) -> Check:
    """Return the check that all impacts of a start are those of the eigenset, or that they leave it.

    Parameters
    ----------
    what
        What is compared.
    force, v0, t0
        The force on the elastic impact oscillator, and the start on its wall.
    numerical
        Says whether the first impacts do as expected, where no proof is to be had.
    kept
        Whether they are expected to keep to it.

    Returns
    -------
    Check
        Certain, for all impacts, if the ball arithmetic decides; else a condition.

    Examples
    --------
    >>> import percuss as pc
    >>> eigenset_kept("n = 3", pc.sine(3), "0.51", lambda: True).is_certain
    True
    """
    holds = keeps_eigenset(WALL, force, v0, t0).holds
    if holds is None:
        return condition(what, numerical())
    return Check(what, float(holds is kept), 1.0, 0.0, 0.0)


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


def subset_kept(what: str, m: int, v0: float, numerical: Callable[[], Check]) -> Check:
    """Return the check that all impacts of a start are those of Y_m, under its force exactly.

    Parameters
    ----------
    what
        What is compared: the distance of the impact times from those of Y_m.
    m, v0
        Which Y_m, and the start on the wall at t = 0.
    numerical
        Gives the check where no proof is to be had, or they are not those of Y_m.
    """
    if keeps_subset(m, v0).holds is True:
        return Check(what, 0.0, 0.0, ROUNDING, 0.0)
    return numerical()


@cache
def subset_constant(m: int) -> Mapping[str, Ball]:
    """Return the constant cos(pi/(m+1)) of the force of Y_m as a ball.

    The model's is a double; in a ball this narrow the constant is meant exactly.
    """
    with precision(CONSTANT_BITS):
        return {"forcing.constant": Ball((arb.pi() / (m + 1)).cos())}


def certain_condition(what: str, holds: bool, is_certain: bool) -> Check:
    """Return the check of a condition that is proven to hold or not to, or only found to.

    Examples
    --------
    >>> certain_condition("two is even", True, True).is_certain
    True
    """
    return Check(what, float(holds), 1.0, radius=0.0 if is_certain else None)


def impacts_at(
    what: str,
    run: Trajectory,
    expected: Floats,
    tolerance: float = ROUNDING,
    start: Start | None = None,
    over: Mapping[str, Ball] | None = None,
) -> Check:
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
    Check
        Certain where the run can be proven.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(WALL, pc.sine(2), v0=1, max_impacts=3)
    >>> impacts_at("times", run, np.pi * np.arange(1, 4)).passed
    True
    """
    proven = certain_run(run, start, over)
    if proven is None or not 0 < len(run.impacts) <= len(expected):
        return near(what, furthest(run, expected), tolerance=tolerance)
    first = expected[: len(run.impacts)]
    times = proven.impacts.t
    # What the radii, and the rounding of what is expected, leave open.
    open_part = float(times.radius().max() + 2.0 * np.spacing(np.abs(first)).max())
    apart = float(np.abs(times.mid() - first).max())
    return Check(what, apart, 0.0, tolerance, math.nextafter(open_part, math.inf))
