"""Following a periodic orbit along a parameter, around folds and through grazing."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float
from percuss.model.paths import get_parameter
from percuss.orbits.branch import Branch
from percuss.orbits.family import Family
from percuss.orbits.periodic_orbit import PeriodicOrbit
from percuss.orbits.walk import Row, Walk

__all__ = ["continue_orbit"]


def continue_orbit(
    orbit: PeriodicOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
) -> Branch:
    """Follow a periodic orbit along a parameter, both ways, stable or not.

    The unknowns are the instants and velocities of the events, and the equations the closed
    forms of the flights between them (`find_orbit`): they are smooth where an impact loses its
    velocity, so that a branch goes through a graze as through any other point. Beyond it the
    orbits are formal, and flagged so. At a fold the branch turns.

    Parameters
    ----------
    orbit
        Where to begin, isolated and without sticking.
    over
        One parameter by its path, and the range to follow it in; the orbit's own value lies in
        it. The branch is told from the end towards the first value to that towards the second.
    max_points
        The most steps each way.
    largest_step
        The longest step, as a part of the range.

    Returns
    -------
    Branch
        A table, with `special_points` and `end_reason`.

    Raises
    ------
    ParameterError
        If there is no such parameter, the range does not hold the orbit's value, or the orbit
        is one of a family in one system or sticks.

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
    path, first, last, value = _checked(orbit, over)
    if max_points < 1:
        raise ParameterError("max_points", max_points, "less than one")
    if not 0.0 < largest_step <= 1.0:
        raise ParameterError("largest_step", largest_step, "not above 0 and at most 1")
    family = Family(orbit, path, min(first, last), max(first, last))
    walk = Walk(family, max_points, largest_step)
    start = walk.start(orbit, value)
    towards = math.copysign(1.0, last - first) * (math.copysign(1.0, start.tangent[-1]))
    ahead, why_ahead, closed = walk.along(start, towards)
    behind: list[Row] = []
    why = why_ahead
    if not closed:
        behind, why_behind, _ = walk.along(start, -towards)
        if behind:
            why = f"{why_behind}; at the other end {why_ahead}"
    return _branch(family, [*reversed(behind), (start, None), *ahead], why)


def _checked(
    orbit: PeriodicOrbit, over: Mapping[str, tuple[Phase, Phase]]
) -> tuple[str, float, float, float]:
    """Return the path, the range and the orbit's own value."""
    if len(over) != 1:
        raise ParameterError("over", over, "not one parameter and its range")
    ((path, given),) = over.items()
    value = as_float(get_parameter(orbit.oscillator, orbit.forcing, None, path))
    try:
        first, last = (as_float(end) for end in given)
    except (TypeError, ValueError) as error:
        raise ParameterError(path, given, "not a range of two numbers") from error
    if first == last or not min(first, last) <= value <= max(first, last):
        raise ParameterError(path, given, f"no range that holds the orbit's own value {value:.12g}")
    if math.isinf(orbit.n_impacts):
        raise ParameterError("orbit", orbit, "it sticks; only orbits without sticking are followed")
    if not orbit.isolated:
        raise ParameterError("orbit", orbit, "one of a family in one system; nothing tells which")
    return path, first, last, value


def _branch(family: Family, rows: list[Row], end_reason: str) -> Branch:
    points = [point for point, _ in rows]
    orbits = tuple(point.orbit for point in points)
    into = np.array([family.into_stops(orbit) for orbit in orbits]).reshape(len(rows), -1)
    steps = np.diff([point.z for point in points], axis=0)
    special = tuple(
        dataclasses.replace(it, row=row) for row, (_, it) in enumerate(rows) if it is not None
    )
    return Branch(
        path=family.path,
        values=np.array([family.value(point.z) for point in points]),
        arclength=np.append(0.0, np.cumsum(np.linalg.norm(steps, axis=1))),
        impact_velocity=into,
        multipliers=np.array([orbit.multipliers for orbit in orbits]),
        stability=np.array([orbit.stability for orbit in orbits]),
        admissible=np.array([orbit.admissible for orbit in orbits]) & (into > 0.0).all(axis=1),
        grazing_margin=np.array([orbit.grazing_margin for orbit in orbits]),
        orbits=orbits,
        special_points=special,
        end_reason=end_reason,
    )
