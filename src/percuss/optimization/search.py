"""The search for the best setting from one start: SciPy's SLSQP with exact gradients."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, MissingExtraError
from percuss.optimization.trials import Trial
from percuss.progress import Progress

__all__ = [
    "MET",
    "MOST_MOTIONS",
    "DesignSearch",
    "Goal",
    "OutcomeLimits",
    "SearchEnd",
    "Trials",
    "Wanted",
]

Goal: TypeAlias = Literal["least", "largest"] | float
OutcomeLimits: TypeAlias = tuple[float | None, float | None]

# SLSQP ends when a step changes the scaled outcome by less; the most motions of a search, and how
# often it begins again, without what it knows of curvatures, where its line search fails.
CLOSE, MOST_MOTIONS, RENEWALS = 1e-13, 200, 3
# A wanted value is out of reach of the search where so many motions come no nearer to it.
MOST_VAIN = 30
# A setting without a motion this near to the best one, in sides of the box, is a bound of it.
AT_BOUND = 1e-6
# Limits are met to this part of their scale, and active this near.
MET = 1e-7
# Places in the box this near to a side are on it.
ROUNDING = 1e-14
# Cost of a setting without a motion, in scaled outcomes: the line search shortens its step.
WITHOUT_MOTION = 10.0
# How SLSQP ends where its line search fails.
NO_DESCENT = 8


class Trials(Protocol):
    """The maker of a search's motions."""

    def first(self, values: Mapping[str, float], n: int, seed: int) -> list[Trial]:
        """Return the motions at a setting from which searches begin."""

    def at(self, values: Mapping[str, float], near: Trial) -> Trial | None:
        """Return the motion at a setting, None if there is none."""


class Kept(NamedTuple):
    """A limit as a scaled number that must not be negative, and its derivatives."""

    name: str
    value: float
    slope: Floats


@dataclass(frozen=True)
class Wanted:
    """The outcome, the goal and the limits of a design.

    Attributes
    ----------
    outcome, goal
        The outcome, and whether it shall be least, largest or have a value.
    limits
        The least and the largest values of outcomes, None for no limit.
    """

    outcome: str
    goal: Goal
    limits: Mapping[str, OutcomeLimits]

    def kept(self, trial: Trial) -> list[Kept]:
        """Return the limits at a motion."""
        rows = []
        for name, ends in self.limits.items():
            value, slope = trial.outcome(name)
            for end, sign in zip(ends, (1.0, -1.0), strict=True):
                if end is not None:
                    part = sign / _scale(end)
                    rows.append(Kept(name, part * (value - end), part * slope))
        return rows

    def missed(self, trial: Trial) -> Kept | None:
        """Return the limit, or the wanted value, that a motion misses most; None if none."""
        rows = self.kept(trial)
        if not isinstance(self.goal, str):
            value, slope = trial.outcome(self.outcome)
            rows.append(Kept(self.outcome, -abs(value - self.goal) / _scale(self.goal), slope))
        worst = min(rows, key=lambda row: row.value, default=None)
        return worst if worst is not None and worst.value < -MET else None


class SearchEnd(NamedTuple):
    """The end of a search: the motion there, and why it is no optimum."""

    trial: Trial
    reason: str


class DesignSearch:
    """Searches in a box of parameters, whose sides are the units of its steps.

    Parameters
    ----------
    trials
        Makes the motions.
    wanted
        What is wanted of them.
    box
        Least and largest value of each parameter.
    given
        The setting next to which a wanted value is looked for.
    progress
        Counts the motions.
    """

    def __init__(
        self,
        trials: Trials,
        wanted: Wanted,
        box: Mapping[str, tuple[float, float]],
        given: Mapping[str, float],
        progress: Progress,
    ) -> None:
        self.trials, self.wanted, self.progress = trials, wanted, progress
        self.box, self.paths = dict(box), tuple(box)
        self.low, high = np.array(list(box.values())).T
        self.width = high - self.low
        self.given_values = dict(given)
        self.given = np.clip(self.place(given), 0.0, 1.0)
        self.n_trials = 0
        self.made: list[Trial] = []

    def values(self, place: Floats) -> dict[str, float]:
        """Return the parameters at a place in the box, each side from 0 to 1."""
        # What differs from an end by rounding is at the end.
        near = np.where(np.abs(place - np.round(place)) < ROUNDING, np.round(place), place)
        inside = self.low + np.clip(near, 0.0, 1.0) * self.width
        return dict(zip(self.paths, inside.tolist(), strict=True))

    def place(self, values: Mapping[str, float]) -> Floats:
        """Return where in the box a setting is."""
        return np.asarray((np.array(list(values.values())) - self.low) / self.width)

    def distance(self, trial: Trial) -> float:
        """Return how far a setting is from the given one, in sides of the box."""
        return float(np.sqrt(np.square(self.place(trial.values) - self.given).sum()))

    def is_better(self, one: SearchEnd, other: SearchEnd) -> bool:
        """Return whether a search ended at the better setting."""
        kept, also_kept = (self.wanted.missed(end.trial) is None for end in (one, other))
        if kept != also_kept:
            return kept
        if not kept:
            return self.miss(one.trial) < self.miss(other.trial)
        if not isinstance(self.wanted.goal, str):
            return self.distance(one.trial) < self.distance(other.trial)
        sign = -1.0 if self.wanted.goal == "largest" else 1.0
        mine, its = (end.trial.outcome(self.wanted.outcome)[0] for end in (one, other))
        if bool(one.reason) != bool(other.reason) and abs(mine - its) < MET * _scale(its):
            return not one.reason
        return sign * mine < sign * its

    def miss(self, trial: Trial) -> float:
        """Return by how much a motion misses what is wanted of it, in its scale; 0 if it does not."""
        missed = self.wanted.missed(trial)
        return 0.0 if missed is None else -missed.value

    def is_usable(self, trial: Trial) -> bool:
        """Return whether all that is wanted of a motion has a derivative."""
        try:
            outcomes = [trial.outcome(name) for name in (self.wanted.outcome, *self.wanted.limits)]
        except ConvergenceError:
            return False
        return all(np.isfinite([value, *slope]).all() for value, slope in outcomes)

    def run(self, first: Trial) -> SearchEnd:
        """Go from a motion to the next optimum."""
        try:
            from scipy.optimize import minimize
        except ImportError:
            raise MissingExtraError("a design needs SciPy", "design") from None

        path = _Path(self, first)
        try:
            place, ending = self._descended(path, minimize)
        except _StopSearchError as stop:
            end = SearchEnd(path.best, str(stop))
        else:
            trial = path.near(place)
            end = SearchEnd(trial, self._reason(trial, ending))
        if isinstance(self.wanted.goal, str) or not end.reason or self.progress.is_stopped:
            return end
        return self._towards(end, float(self.wanted.goal))

    def _towards(self, end: SearchEnd, goal: float) -> SearchEnd:
        """Return the motion whose outcome is nearest to a value that a search has not reached."""
        between = self._between(goal)
        if between is not None and self.miss(between) == 0.0:
            return SearchEnd(between, "")
        name, trial = self.wanted.outcome, end.trial
        below = trial.outcome(name)[0] < goal
        limits = dict(self.wanted.limits)
        low, high = limits.get(name, (None, None))
        limits[name] = (low, goal) if below else (goal, high)
        wanted = Wanted(name, "largest" if below else "least", limits)
        other = DesignSearch(self.trials, wanted, self.box, self.given_values, self.progress)
        nearest = other.run(trial)
        self.n_trials += other.n_trials
        self.made += other.made
        best = min(trial, nearest.trial, self._between(goal) or trial, key=self.miss)
        if self.miss(best) == 0.0:
            return SearchEnd(best, "")
        missed = self.wanted.missed(best)
        assert missed is not None
        if missed.name != name:
            return SearchEnd(best, self._reason(best, 0))
        value = best.outcome(name)[0]
        reason = f"{name} = {goal:.6g} is out of reach: the nearest that was found is {value:.6g}"
        return SearchEnd(best, f"{reason}; {nearest.reason}" if nearest.reason else reason)

    def _between(self, goal: float) -> Trial | None:
        """Return the motion with a value on the line between two that were made on its two sides.

        None where there are no two such motions, or none between them.
        """
        from scipy.optimize import brentq

        def excess(trial: Trial) -> float:
            return trial.outcome(self.wanted.outcome)[0] - goal

        sides = [[trial for trial in self.made if sign * excess(trial) > 0.0] for sign in (-1, 1)]
        ends = {trial: self.place(trial.values) for side in sides for trial in side}

        def distance(pair: tuple[Trial, ...]) -> float:
            return float(np.ptp([ends[trial] for trial in pair], 0).max())

        pair = min(product(*sides), key=distance, default=None)
        if pair is None:
            return None
        last, low, high = pair[0], ends[pair[0]], ends[pair[1]]

        def excess_at(part: float) -> float:
            nonlocal last
            self.n_trials += 1
            trial = self.trials.at(self.values(low + part * (high - low)), last)
            if trial is None or not self.is_usable(trial) or not self.progress.advance():
                raise _StopSearchError
            last = trial
            return excess(trial)

        try:
            brentq(excess_at, 0.0, 1.0, xtol=1e-15)
        except (_StopSearchError, ValueError):
            # Without a motion between, or another one at an end than the one that was made there.
            return None
        return last

    def _descended(self, path: _Path, minimize: Callable[..., Any]) -> tuple[Floats, int]:
        """Return where SLSQP ended, and how."""
        place = self.place(path.last.values)
        for _ in range(1 + RENEWALS):
            result = minimize(
                path.cost,
                place,
                jac=path.slope,
                method="SLSQP",
                bounds=[(0.0, 1.0)] * len(place),
                constraints=path.constraints(),
                options={"ftol": CLOSE, "maxiter": MOST_MOTIONS},
            )
            again = int(result.status) == NO_DESCENT and not np.array_equal(result.x, place)
            place = result.x
            if not again:
                break
        return place, int(result.status)

    def _reason(self, trial: Trial, ending: int) -> str:
        missed = self.wanted.missed(trial)
        if missed is not None:
            value = trial.outcome(missed.name)[0]
            return f"no setting was found that keeps to what is wanted of {missed.name}: it is {value:.6g}"
        if ending == NO_DESCENT:
            return (
                "no step makes it better, though its derivatives are not zero: it has a kink there"
            )
        return ""


class _StopSearchError(Exception):
    """A search ends before its optimum, for the reason given."""


class _Path:
    """The functions of one search, as SLSQP calls them."""

    def __init__(self, search: DesignSearch, first: Trial) -> None:
        self.search, self.wanted = search, search.wanted
        self.scale = _scale(first.outcome(self.wanted.outcome)[0])
        self.known: dict[bytes, Trial | None] = {search.place(first.values).tobytes(): first}
        self.last = self.best = first
        self.n_vain = 0

    def near(self, place: Floats) -> Trial:
        """Return the motion at a place, or where there is none the last one there was."""
        return self._trial(place) or self.last

    def _trial(self, place: Floats) -> Trial | None:
        key = place.tobytes()
        if key not in self.known:
            self.known[key] = self._made(place)
        trial = self.known[key]
        if trial is not None:
            self.last = trial
        return trial

    def _made(self, place: Floats) -> Trial | None:
        self.search.n_trials += 1
        if len(self.known) > MOST_MOTIONS:
            if self.is_at_bound():
                raise _StopSearchError("")
            raise _StopSearchError(f"{MOST_MOTIONS} motions were not enough")
        if not self.search.progress.advance():
            raise _StopSearchError("the search was stopped")
        trial = self.search.trials.at(self.search.values(place), self.last)
        if trial is None or not self.search.is_usable(trial):
            return None
        self.search.made.append(trial)
        self.n_vain += 1
        if self.search.is_better(SearchEnd(trial, ""), SearchEnd(self.best, "")):
            self.best, self.n_vain = trial, 0
        is_vain = self.n_vain > MOST_VAIN and not isinstance(self.wanted.goal, str)
        if is_vain and self.search.miss(self.best) > 0.0:
            raise _StopSearchError(f"{MOST_VAIN} motions came no nearer to what is wanted")
        return trial

    def is_at_bound(self) -> bool:
        """Return whether the best setting is next to one at which there is no motion."""
        own = self.search.place(self.best.values)
        places = [np.frombuffer(key) for key, trial in self.known.items() if trial is None]
        return any(float(np.abs(place - own).max()) < AT_BOUND for place in places)

    def cost(self, place: Floats) -> float:
        """Return the cost, which is minimised."""
        trial = self._trial(place)
        if trial is None:
            return self.cost(self.search.place(self.last.values)) + WITHOUT_MOTION
        if not isinstance(self.wanted.goal, str):
            return float(0.5 * np.square(place - self.search.given).sum())
        value = trial.outcome(self.wanted.outcome)[0] / self.scale
        return -value if self.wanted.goal == "largest" else value

    def slope(self, place: Floats) -> Floats:
        """Return the derivatives of the cost."""
        if not isinstance(self.wanted.goal, str):
            return place - self.search.given
        slope = self.near(place).outcome(self.wanted.outcome)[1] * self.search.width / self.scale
        return np.asarray(-slope if self.wanted.goal == "largest" else slope)

    def constraints(self) -> list[dict[str, Any]]:
        """Return the limits as constraints of SciPy."""
        rows: list[dict[str, Any]] = []
        if self.wanted.kept(self.last):
            rows.append(_constraint("ineq", self._kept, self._moved_kept))
        if not isinstance(self.wanted.goal, str):
            rows.append(_constraint("eq", self._missed, self._moved_missed))
        return rows

    def _kept(self, place: Floats) -> Floats:
        return np.array([row.value for row in self.wanted.kept(self.near(place))])

    def _moved_kept(self, place: Floats) -> Floats:
        rows = self.wanted.kept(self.near(place))
        return np.array([row.slope * self.search.width for row in rows])

    def _missed(self, place: Floats) -> float:
        value, _ = self.near(place).outcome(self.wanted.outcome)
        return (value - float(self.wanted.goal)) / _scale(float(self.wanted.goal))

    def _moved_missed(self, place: Floats) -> Floats:
        slope = self.near(place).outcome(self.wanted.outcome)[1]
        return np.asarray(slope * self.search.width / _scale(float(self.wanted.goal)))


def _constraint(
    kind: str, function: Callable[[Floats], Any], slope: Callable[[Floats], Floats]
) -> dict[str, Any]:
    return {"type": kind, "fun": function, "jac": slope}


def _scale(number: float) -> float:
    """Return the scale of an outcome, from a number near it."""
    return abs(number) or 1.0
