"""Motions at many times in ball arithmetic: sums of them, and how far they are apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import arb

from percuss.arrays import Floats
from percuss.certified import Ball, CertifiedRun
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.evidence import Enclosure

# A factor, a run, and a number of its force that is a ball.
MotionPart = tuple[float, Trajectory, "Mapping[str, Ball] | None"]


def furthest_apart(parts: Sequence[MotionPart], t: Floats, *, velocity: bool = False) -> arb | None:
    """Return a ball of the largest absolute value of a sum of motions at some times.

    Parameters
    ----------
    parts
        The motions with their factors, which are taken exactly.
    t
        The times, exactly these doubles.
    velocity
        Whether the velocities are added, in place of the displacements.

    Returns
    -------
    arb or None
        None where a run is not proven up to its end.
    """
    proven: list[CertifiedRun] = []
    for _, run, over in parts:
        certain = certain_run(run, over=over)
        if certain is None:
            return None
        proven.append(certain)

    columns = [run(t)[int(velocity)].arbs for run in proven]
    factors = [arb(factor) for factor, _, _ in parts]
    furthest = arb(0)
    for row in zip(*columns, strict=True):
        value = sum((f * x for f, x in zip(factors, row, strict=True)), arb(0))
        furthest = furthest.max(abs(value))
    return furthest


def sum_within(
    what: str,
    parts: Sequence[MotionPart],
    t: Floats,
    most: float,
    *,
    velocity: bool = False,
) -> Enclosure:
    """Return the check that a sum of motions is at most so large at some times.

    Parameters
    ----------
    what
        What is compared.
    parts, t, velocity
        As for `furthest_apart`.
    most
        The largest absolute value that agrees.
    """
    return enclosed(what, furthest_apart(parts, t, velocity=velocity), -most, most)
