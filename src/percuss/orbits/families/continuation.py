"""Following a periodic orbit along a parameter, around folds and through grazing."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.model.exact import Phase, real, whole
from percuss.numerics import norm
from percuss.orbits.families.branch import Branch
from percuss.orbits.families.conditions import Point
from percuss.orbits.families.family import Family
from percuss.orbits.families.ranges import checked_range
from percuss.orbits.families.sticking_branch import sticking_branch
from percuss.orbits.families.walk import STOPPED, Row, Walk
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.progress import Progress, Report

__all__ = ["continue_orbit"]

Floats = NDArray[np.float64]


def continue_orbit(
    orbit: PeriodicOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Branch:
    """Follow a periodic orbit along a parameter, both ways, stable or not.

    The unknowns are the instants and velocities of the events, and the equations the closed
    forms of the flights between them (`find_orbit`): they are smooth where an impact loses its
    velocity, so that a branch goes through a graze as through any other point. Beyond it the
    orbits are formal, and flagged so. At a fold the branch turns. Where the orbits meet a soft
    stop that they did not meet, or no more, there are physical ones beyond: the branch goes on
    with their events (docs/theory/grazing.md).

    An orbit with sticking is followed as the motion from its release (multipliers 0): it ends where
    the contact lasts no time or is not left, and goes through grazes, where impacts come and go.

    Parameters
    ----------
    orbit
        Where to begin, isolated.
    over
        One parameter by its path, and the range to follow it in; the orbit's own value lies in
        it. The branch is told from the end towards the first value to that towards the second.
    max_points
        The most steps each way.
    largest_step
        The longest step, as a part of the range.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each step with the number of orbits and the
        most there can be, and stops the branch by returning False.

    Returns
    -------
    Branch
        A table, with `special_points` and `end_reason`.

    Raises
    ------
    ParameterError
        If there is no such parameter, the range does not hold the orbit's value, or the orbit
        is one of a family in one system.

    Examples
    --------
    Down to the fold, back on the unstable orbits, and through the graze on formal ones:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> orbit = pc.find_orbit(osc, pc.cosine(1.0))
    >>> branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (1.0, 0.05)})
    >>> for point in branch.special_points:
    ...     print(point.kind, round(point.value, 9))
    fold 0.099970754
    grazing 0.1
    period_doubling 0.107276459
    """
    path, first, last, value = checked_range(orbit, over, may_stick=True)
    max_points = whole("max_points", max_points, 1)
    largest_step = real("largest_step", largest_step)
    if not 0.0 < largest_step <= 1.0:
        raise ParameterError("largest_step", largest_step, "not above 0 and at most 1")
    reported = Progress(progress, 2 * max_points, "orbits", is_bound=True)
    if math.isinf(orbit.n_impacts):
        branch = sticking_branch(
            orbit, path, value, (first, last),
            max_points=max_points, largest_step=largest_step, progress=reported,
        )  # fmt: skip
        reported.close()
        return branch
    family = Family(orbit, path, min(first, last), max(first, last))
    walk = Walk(family, max_points, largest_step)
    start = walk.start(orbit, value)
    towards = math.copysign(1.0, last - first) * (math.copysign(1.0, start.tangent[-1]))
    ahead, why_ahead, closed = walk.along(start, towards, progress=reported)
    behind: list[Row] = []
    why = why_ahead
    if not closed and why != STOPPED:
        behind, why_behind, _ = walk.along(start, -towards, progress=reported)
        if behind:
            why = f"{why_behind}; at the other end {why_ahead}"
    reported.close()
    return _branch(family, [*reversed(behind), (start, None), *ahead], why)


def _branch(family: Family, rows: list[Row], end_reason: str) -> Branch:
    points = [point for point, _ in rows]
    orbits = tuple(point.orbit for point in points)
    into = _padded([(point.family or family).into_stops(point.orbit) for point in points])
    special = tuple(
        dataclasses.replace(it, row=row) for row, (_, it) in enumerate(rows) if it is not None
    )
    return Branch(
        path=family.path,
        values=np.array([family.value(point.z) for point in points]),
        arclength=np.append(0.0, np.cumsum([_apart(*pair) for pair in pairwise(points)])),
        impact_velocity=into,
        multipliers=np.array([orbit.multipliers for orbit in orbits]),
        stability=np.array([orbit.stability for orbit in orbits]),
        admissible=np.array([orbit.admissible for orbit in orbits]) & ~(into <= 0.0).any(axis=1),
        grazing_margin=np.array([orbit.grazing_margin for orbit in orbits]),
        orbits=orbits,
        special_points=special,
        end_reason=end_reason,
    )


def _padded(rows: list[Floats]) -> Floats:
    """Return rows of different length as one array, with NaN where there is nothing."""
    out = np.full((len(rows), max(map(len, rows))), np.nan)
    for row, values in zip(out, rows, strict=True):
        row[: len(values)] = values
    return out


def _apart(one: Point, other: Point) -> float:
    """Return the distance of two points; by the parameter where their events differ."""
    if one.family is other.family:
        return norm(other.z - one.z)
    return abs(float(other.z[-1] - one.z[-1]))
