"""Pareto fronts: settings at which neither of two outcomes can gain without a loss of the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.optimization.design import Design, design
from percuss.optimization.outcomes import OutcomeName, outcome_of
from percuss.optimization.search import MOST_MOTIONS
from percuss.pictures import HasPicture
from percuss.progress import Progress, Report

# Two outcomes are the same to this part.
SAME = 1e-6
# How often the designs between the ends are sought anew, from an end that one of them has bettered.
MOST_PASSES = 3


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class ParetoFront(HasPicture):
    """The designs between two outcomes; made by `pareto_front`.

    Attributes
    ----------
    outcomes, goals
        The two outcomes, and whether each shall be least or largest.
    designs
        From the best of the first outcome to the best of the second.
    values
        (n, 2) array, the two outcomes of each.
    n_left_out
        How many more were found that one of these betters, or is.
    """

    picture: ClassVar = "plot_pareto"

    outcomes: tuple[str, str]
    goals: tuple[str, str]
    designs: tuple[Design, ...]
    values: Floats
    n_left_out: int = 0

    def __len__(self) -> int:
        """Return the number of designs."""
        return len(self.designs)

    def __repr__(self) -> str:
        """Return the ends in a line."""
        (a, b), (c, d) = self.values[0], self.values[-1]
        one, other = self.outcomes
        return (
            f"<ParetoFront: {len(self)} designs from {one} {a:.6g}, {other} {b:.6g} "
            f"to {one} {c:.6g}, {other} {d:.6g}>"
        )


def pareto_front(
    outcomes: tuple[OutcomeName | str, OutcomeName | str],
    osc: Oscillator | Structure,
    force: Forcing | Loads | Mapping[Any, Forcing] | None = None,
    *,
    free: Mapping[str, tuple[Exact, Exact]],
    goals: tuple[Literal["least", "largest"], Literal["least", "largest"]] = ("least", "least"),
    n: int = 9,
    restarts: int = 4,
    progress: Report = None,
    **settings: Any,
) -> ParetoFront:
    """Return the Pareto front of two outcomes: designs that no other betters in both.

    Of the designs between the two best ones the second outcome is limited, at equal distances,
    and the first is as good as it can be. Each search begins at the design before it too.

    Parameters
    ----------
    outcomes
        The two, as `design` takes them.
    osc, force, free
        As `design` takes them.
    goals
        Whether each shall be least or largest.
    n
        How many designs, >= 2; those that another one betters are left out.
    restarts, progress
        As `design` takes them, of all designs together. When it is stopped the front has the
        designs that were begun.
    **settings
        All else that `design` takes: `subject_to`, `on`, `start`, ...

    Returns
    -------
    ParetoFront
        The designs, from the best of the first outcome to that of the second.

    Raises
    ------
    ParameterError
        As `design`, and if n is below 2 or a goal is a value.
    ConvergenceError
        If no motion is found from which to begin.
    MissingExtraError
        If SciPy is missing.

    Examples
    --------
    A softer stop takes less force and gives way more:

    >>> import percuss as pc
    >>> stop = pc.SoftStop(at="0.2", side="above", stiffness=30)
    >>> front = pc.pareto_front(
    ...     ("peak_stop_force", "max_displacement"),
    ...     pc.Oscillator(damping="0.1", stops=[stop]), pc.cosine(2), n=3, restarts=0,
    ...     free={"oscillator.stops.0.stiffness": (5, 100)},
    ... )
    >>> front.values.round(4)
    array([[0.5584, 0.3117],
           [1.8717, 0.2964],
           [8.1074, 0.2811]])
    """
    _check(outcomes, goals, n)
    one, other = outcomes
    limits = dict(settings.pop("subject_to", None) or {})
    own = limits.pop(other, (None, None))
    most = MOST_MOTIONS * (restarts + 1) * (2 + MOST_PASSES * (n - 2))
    line = Progress(progress, most, "motions", is_bound=True)

    def best(of: str, goal: Any, near: Design | None, ends: tuple[Any, Any] = own) -> Design:
        system: Any = (osc, force) if near is None else (near.oscillator, near.forcing)
        again = {} if near is None or near.start is None else {"start": near.start}
        kept = limits if ends == (None, None) else {**limits, other: ends}
        done = line.done
        given = {**settings, **again, "restarts": restarts, "free": free, "subject_to": kept}
        return design(
            of, *system, goal=goal, progress=lambda count, _: line.reach(done + count), **given
        )

    def values_of(designs: list[Design]) -> Floats:
        return np.array([[_of(each, one), _of(each, other)] for each in designs])

    signs = np.where(np.array(goals) == "least", 1.0, -1.0)
    try:
        designs = [best(one, goals[0], None), best(other, goals[1], None)]
        for _ in range(MOST_PASSES):
            ends = designs[0], designs[-1]
            between = [ends[0]]
            begin, end = (_of(each, other) for each in ends)
            for limit in np.linspace(begin, end, n)[1:-1].tolist():
                if line.is_stopped:
                    break
                limited = (own[0], limit) if goals[1] == "least" else (limit, own[1])
                between.append(best(one, goals[0], between[-1], limited))
            designs = [*between, ends[1]]
            costs = signs * values_of(designs)
            front = [designs[i] for i in _undominated(costs)]
            # A design between the ends may be better than one of them, which was an optimum near by
            # alone: the front is shorter than was thought.
            if len(front) == n or line.is_stopped or {front[0], front[-1]} <= set(ends):
                break
            designs = [front[0], front[-1]]
    finally:
        line.close()
    n_left_out = len(designs) - len(front)
    return ParetoFront(outcomes, goals, tuple(front), values_of(front), n_left_out)


def _check(outcomes: tuple[str, str], goals: tuple[str, str], n: int) -> None:
    """Refuse what no front is between."""
    if len(set(outcomes)) != 2:
        raise ParameterError("outcomes", outcomes, "not two different outcomes")
    if not set(goals) <= {"least", "largest"}:
        raise ParameterError("goals", goals, 'not two of "least" and "largest"')
    if n < 2:
        raise ParameterError("n", n, "less than two")


def _of(design: Design, name: str) -> float:
    """Return an outcome of a design."""
    return outcome_of(design.orbit, design.derivative, name)[0]


def _undominated(costs: Floats) -> list[int]:
    """Return the rows that no other row betters in both columns, equal ones once, by the first column."""
    scale = np.abs(costs).max(axis=0) * SAME
    kept: list[int] = []
    for i, row in enumerate(costs):
        others = np.delete(costs, i, axis=0)
        better = (others <= row + scale).all(axis=1) & (others < row - scale).any(axis=1)
        again = any((np.abs(costs[j] - row) <= scale).all() for j in kept)
        if not better.any() and not again:
            kept.append(i)
    return sorted(kept, key=lambda i: costs[i, 0])
