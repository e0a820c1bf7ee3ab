"""Motions at many times in ball arithmetic: sums of them, and how far they are apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from flint import arb

from percuss.arrays import Floats
from percuss.certified import Ball
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run
from percuss.paper.claims.evidence import near
from percuss.paper.statement import Check

__all__ = ["MotionPart", "furthest_apart", "sum_is_zero"]

# A factor, a run, and a number of its force that is a ball.
MotionPart = tuple[float, Trajectory, "Mapping[str, Ball] | None"]


def furthest_apart(parts: Sequence[MotionPart], t: Floats) -> arb | None:
    """Return a ball of the largest absolute value of a sum of motions at some times.

    Parameters
    ----------
    parts
        The motions with their factors, which are taken exactly.
    t
        The times, exactly these doubles.

    Returns
    -------
    arb or None
        None where a run is not proven up to its end.
    """
    proven = [certain_run(run, over=over) for _, run, over in parts]
    if any(run is None for run in proven):
        return None

    columns = [run(t)[0].arbs for run in proven if run is not None]
    factors = [arb(factor) for factor, _, _ in parts]
    found = arb(0)
    for row in zip(*columns, strict=True):
        value = sum((f * x for f, x in zip(factors, row, strict=True)), arb(0))
        found = found.max(abs(value))
    return found


def sum_is_zero(
    what: str,
    parts: Sequence[MotionPart],
    t: Floats,
    numerical: Callable[[], float],
    tolerance: float,
) -> Check:
    """Return the check that a sum of motions is zero at some times, certain where it is proven.

    Parameters
    ----------
    what
        What is compared.
    parts, t
        As for `furthest_apart`.
    numerical
        Says how far it is from that by floats, where no proof is to be had.
    tolerance
        Largest value that counts as zero.
    """
    largest = furthest_apart(parts, t)
    if largest is None:
        return near(what, numerical(), tolerance=tolerance)
    return Check(what, float(largest.mid()), 0.0, tolerance, float(largest.rad()) + 1e-20)
