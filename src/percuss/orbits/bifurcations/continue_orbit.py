"""Continuation of a periodic orbit along a parameter, around folds and through grazing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import overload

import numpy as np

from percuss.arrays import Floats
from percuss.model.exact import Phase
from percuss.orbits.bifurcations.branch import Branch, branch_of
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.continue_structure import continue_structure_orbit
from percuss.orbits.bifurcations.detector import BranchDetector
from percuss.orbits.bifurcations.parameter_ranges import checked_range
from percuss.orbits.bifurcations.sticking_branch import sticking_branch
from percuss.orbits.bifurcations.structure_branch import StructureBranch
from percuss.orbits.continuation.follow import StepLimits, follow_both_ways
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.progress import Progress, Report


@overload
def continue_orbit(
    orbit: PeriodicOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Branch: ...
@overload
def continue_orbit(
    orbit: StructureOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> StructureBranch: ...
def continue_orbit(
    orbit: PeriodicOrbit | StructureOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Branch | StructureBranch:
    """Follow a periodic orbit along a parameter, both ways, stable or not.

    The unknowns are the instants and velocities of the events, and the equations the closed
    forms of the flights between them (`find_orbit`): they are smooth where an impact velocity goes
    through zero, so that a branch passes a graze as any other point. Beyond it the orbits are
    formal, and flagged so. At a fold the branch turns. At the graze of a soft stop there are
    admissible orbits beyond, which meet the stop once more or less: the branch continues with their
    events (docs/theory/grazing.md).

    Orbits without impacts are sums over harmonics and modes, whose dynamic stiffnesses
    k - w^2 + 2 i a w tell of a resonance between two steps however narrow it is: such steps are
    shortened until its grazes are seen. At a resonance without damping the branch ends.

    An orbit with sticking is followed as the motion from its release (multipliers 0). Its branch
    ends where the duration of the contact goes to zero, or where it is never released, and passes
    grazes, at which impacts appear and vanish.

    The orbits of a structure are those that its map over the period brings back, which is smooth
    where a soft stop is grazed. Those that meet no stop are followed by the parameter alone. Where
    they meet walls, the instants of these impacts are unknowns too, so that the branch passes the
    grazes of walls; beyond them the orbits are formal. Orbits of structures that stick end at such
    a graze. A complex pair of multipliers that leaves the unit circle is a "torus" point.

    Parameters
    ----------
    orbit
        Where to begin, isolated: of an oscillator, or of a structure.
    over
        One parameter by its path, and the range to follow it in; the orbit's own value lies in
        it. The branch goes from its end towards the first value to that towards the second.
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
    if isinstance(orbit, StructureOrbit):
        return continue_structure_orbit(
            orbit, over, max_points=max_points, largest_step=largest_step, progress=progress
        )
    path, first, last, value = checked_range(orbit, over, may_stick=True)
    steps = StepLimits.checked(max_points, largest_step)
    reported = Progress(progress, 2 * steps.max_points, "orbits", is_bound=True)
    if math.isinf(orbit.n_impacts):
        branch = sticking_branch(orbit, path, value, (first, last), steps, reported)
        reported.close()
        return branch
    family = BranchEquations(orbit, path, min(first, last), max(first, last))
    start = family.started(orbit, value)
    rows, why = follow_both_ways(start, last - first, BranchDetector(), steps, reported)
    velocities = _padded([point.problem.into_stops(point.orbit) for point, _ in rows])
    return branch_of(rows, velocities, why)


def _padded(rows: list[Floats]) -> Floats:
    """Return rows of different length as one array, filled up with NaN."""
    out = np.full((len(rows), max(map(len, rows))), np.nan)
    for row, values in zip(out, rows, strict=True):
        row[: len(values)] = values
    return out
