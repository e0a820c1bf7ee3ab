"""Comparisons in ball arithmetic: certain where it decides, open where it does not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from flint import arb

from percuss.arrays import Floats
from percuss.certified import (
    Ball,
    Balls,
    CertifiedRun,
    certify,
    critical_velocity,
)
from percuss.certified.numbers import precision
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.start import Start
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.comparisons import ROUNDING, WALL
from percuss.paper.evidence import Comparison, Enclosure, compare

# Of a constant that no fraction is: far more digits than are asked of any result.
CONSTANT_BITS = 512
# The first events of a run are those that are proven, to this distance (relative where they are
# above 1); later ones of a chaotic motion may be lost in doubles, and that is why it is proven.
FIRST, FOLLOWED = 10, 1e-8
DIGITS = 12


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


def enclosed(what: str, value: arb | None, low: float, high: float) -> Enclosure:
    """Return the evidence that a ball gives; None, of what is not proven, leaves it open.

    Examples
    --------
    >>> enclosed("a half", arb(0.5), 0.0, 1.0).outcome, enclosed("?", None, 0.0, 1.0).outcome
    ('agrees', 'open')
    """
    if value is None:
        return Enclosure(what, math.nan, math.inf, low, high)
    ball = Ball(value)
    return Enclosure(what, ball.mid(), ball.radius(), low, high)


def certain_run(
    run: Trajectory,
    start: Start | None = None,
    over: Mapping[str, Ball] | None = None,
    digits: int = DIGITS,
) -> CertifiedRun | None:
    """Return a run that is proven up to its end, or None.

    None as well where the engine does not follow the proven motion: what is seen of the run
    elsewhere would be of another.

    Parameters
    ----------
    run
        The run.
    start
        Its exact start; default: the one that it was given.
    over
        A number of its force as a ball; default: that of the model, which may be a double.
    digits
        Of each event.
    """
    proven = certify(run, digits, start=start, over=over)
    is_whole = proven.complete and len(proven.impacts) == len(run.impacts)
    return proven if is_whole and _is_followed(run, proven) else None


def _is_followed(run: Trajectory, proven: CertifiedRun) -> bool:
    columns = (
        (run.impacts.t, proven.impacts.t),
        (run.impacts.v_after, proven.impacts.v_after),
        (run.crossings.t, proven.crossings.t),
        (run.crossings.v, proven.crossings.v),
    )
    return all(follows(seen[:FIRST], sure[:FIRST]) for seen, sure in columns)


def follows(seen: Floats, sure: Balls) -> bool:
    """Return whether numbers of the engine are those that are proven, but for rounding."""
    if len(seen) != len(sure):
        return False
    allowed = FOLLOWED * np.maximum(1.0, np.abs(seen)) + sure.radius()
    return bool(np.all(np.abs(seen - sure.mid()) <= allowed))


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
        Open where the run is not proven.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(WALL, pc.sine(2), v0=1, max_impacts=3)
    >>> impacts_at("times", run, np.pi * np.arange(1, 4)).outcome
    'agrees'
    """
    proven = certain_run(run, start, over)
    if proven is None:
        return enclosed(what, None, -tolerance, tolerance)
    if not 0 < len(run.impacts) <= len(expected):
        return compare(what, math.inf, 0.0, tolerance, 0.0)
    first = expected[: len(run.impacts)]
    times = proven.impacts.t
    # What the radii, and the rounding of what is expected, leave open.
    open_part = float(times.radius().max() + 2.0 * np.spacing(np.abs(first)).max())
    apart = float(np.abs(times.mid() - first).max())
    return compare(what, apart, 0.0, tolerance, math.nextafter(open_part, math.inf))
