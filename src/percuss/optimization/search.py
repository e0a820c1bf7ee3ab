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

Goal: TypeAlias = Literal["least", "largest"] | float
OutcomeLimits: TypeAlias = tuple[float | None, float | None]

# SLSQP ends when a step changes the scaled outcome by less; the most motions of a search, and how
# often it begins again at its best one, without what it knows of curvatures, where that is no optimum.
CLOSE, MOST_MOTIONS, RENEWALS = 1e-13, 200, 3
# What is wanted is out of reach of the search where so many motions come no nearer to it.
MOST_VAIN = 30
# Where an attractor ends, a search goes on along the next one, on so many.
MOST_ATTRACTORS = 4
# So many steps beyond the end of an attractor are enough: SLSQP would creep towards it.
MOST_BEYOND = 6
# A setting without a motion this near to the best one, in sides of the box, is a bound of it; so
# many times as near what ends the attractor is zero, as its derivatives have it: twice at a fold.
AT_BOUND, BESIDE = 1e-8, 10
# Slope of an optimum, in scaled outcomes a side of the box, that nothing holds: of 148 designs those
# where SLSQP had ended well were below 1e-5, those at kinks, jumps and ends of attractors above 0.02.
FLAT = 1e-4
# Limits are met to this part of their scale, and active this near.
MET = 1e-7
# Places in the box this near to a side are on it.
ROUNDING = 1e-14
# Cost of a setting without a motion, in scaled outcomes: the line search shortens its step.
WITHOUT_MOTION = 10.0
# Why a setting is no optimum.
KINK = "no step makes it better, though its slope is not zero: it has a kink or a jump there"
NO_ORBIT = (
    "its attractor ends beside it, and the search does not go along that end; "
    "a limit of grazing_margin or multiplier leads along there"
)
NO_RUN = "beside it the parameters make no run, and the search does not go along there"


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
            off, scale = value - self.goal, _scale(self.goal)
            rows.append(Kept(self.outcome, -abs(off) / scale, -np.sign(off) / scale * slope))
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

    def shortfall(self, trial: Trial) -> str:
        """Return what a motion does not keep to, as a reason; empty if it keeps to all."""
        missed = self.wanted.missed(trial)
        if missed is None:
            return ""
        value = trial.outcome(missed.name)[0]
        return (
            f"no setting was found that keeps to what is wanted of {missed.name}: it is {value:.6g}"
        )

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

        end, most, begin = None, MOST_MOTIONS, first
        for _ in range(MOST_ATTRACTORS):
            path = _Path(self, begin, most)
            found = path.searched(minimize)
            end = found if end is None or self.is_better(found, end) else end
            other = path.next_attractor()
            if other is None or self.progress.is_stopped:
                break
            begin, most = other, most - len(path.known)
        assert end is not None
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
            return SearchEnd(best, self.shortfall(best))
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


class _StopSearchError(Exception):
    """A search ends before its optimum, for the reason given."""


class _BeyondError(Exception):
    """A search has stepped beyond the end of its attractor often enough."""


class _Path:
    """One search: its functions as SLSQP calls them, and what is known of its motions."""

    def __init__(self, search: DesignSearch, first: Trial, most: int) -> None:
        self.search, self.wanted, self.most = search, search.wanted, most
        self.scale = _scale(first.outcome(self.wanted.outcome)[0])
        self.known: dict[bytes, Trial | None] = {search.place(first.values).tobytes(): first}
        # Motions of other attractors, at places beyond the end of this one.
        self.others: dict[bytes, Trial] = {}
        # The motion from which SLSQP steps, on whose attractor a step stays.
        self.base = self.best = first
        self.n_vain = self.n_beyond = 0

    def searched(self, minimize: Callable[..., Any]) -> SearchEnd:
        """Return where SLSQP ends, begun again at its best motion as long as that gets better."""
        stopped = ""
        try:
            for _ in range(1 + RENEWALS):
                begin = self.best
                end = self._descended(minimize)
                if self._is_optimum(end):
                    return SearchEnd(end, "")
                self._go_to_bound()
                if not self.search.is_better(SearchEnd(self.best, ""), SearchEnd(begin, "?")):
                    break
        except _StopSearchError as stop:
            stopped = str(stop)
        return SearchEnd(self.best, self._reason(stopped))

    def _descended(self, minimize: Callable[..., Any]) -> Trial:
        """Return the motion where SLSQP ends, or the best one if that is better."""
        self.base, self.n_beyond = self.best, 0
        place = self.search.place(self.best.values)
        try:
            result = minimize(
                self.cost,
                place,
                jac=self.slope,
                method="SLSQP",
                bounds=[(0.0, 1.0)] * len(place),
                constraints=self.constraints(),
                options={"ftol": CLOSE, "maxiter": MOST_MOTIONS},
            )
        except _BeyondError:
            return self.best
        # Of two that are as good the last one, where SLSQP has met the limits.
        end = self.near(result.x)
        value, best = (trial.outcome(self.wanted.outcome)[0] for trial in (end, self.best))
        is_as_good = self.search.miss(end) == 0.0 and abs(value - best) < FLAT * self.scale
        return end if is_as_good else self.best

    def _is_optimum(self, trial: Trial) -> bool:
        """Return whether a motion keeps all limits and meets the condition of Karush, Kuhn and Tucker.

        The slope is a sum of the normals, inwards, of the ends of ranges, the limits and the ends of
        the attractor at which the motion is.
        """
        from scipy.optimize import nnls

        if self.search.miss(trial) > 0.0:
            return False
        if not isinstance(self.wanted.goal, str):
            return True
        place, width = self.search.place(trial.values), self.search.width
        slope = trial.outcome(self.wanted.outcome)[1] * width / self.scale
        away = np.eye(len(place))
        normals = [np.zeros(len(place)), *away[place < MET], *-away[place > 1.0 - MET]]
        normals += [row.slope * width for row in self.wanted.kept(trial) if row.value < MET]
        normals += self._ends(trial)
        sign = -1.0 if self.wanted.goal == "largest" else 1.0
        return bool(nnls(np.array(normals).T, sign * slope)[1] < FLAT)

    def _ends(self, trial: Trial) -> list[Floats]:
        """Return the normals of the end of the attractor at a motion, inwards; none inside it."""
        place, beyond = self.search.place(trial.values), self._beyond(trial)
        if beyond is None:
            return []
        if len(place) == 1:
            return [np.sign(place - beyond)]
        ends = [(value, slope * self.search.width) for value, slope in trial.ends()]
        sizes = [float(np.sqrt(np.square(slope).sum())) for _, slope in ends]
        return [
            slope / size
            for (value, slope), size in zip(ends, sizes, strict=True)
            if value < BESIDE * AT_BOUND * size
        ]

    def _go_to_bound(self) -> None:
        """Halve the way from the best motion to the next setting beyond it."""
        beyond = self._next_beyond(self.best)
        if beyond is None:
            return
        while self._distance(self.best, beyond) > 0.5 * AT_BOUND:
            best = self.base = self.best
            middle = 0.5 * (self.search.place(best.values) + beyond)
            self._trial(middle)
            if self.best is best:
                beyond = middle

    def _distance(self, trial: Trial, place: Floats) -> float:
        return float(np.abs(place - self.search.place(trial.values)).max())

    def _next_beyond(self, trial: Trial) -> Floats | None:
        """Return the nearest known place without a motion of this attractor, None if there is none."""
        places = [np.frombuffer(key) for key, known in self.known.items() if known is None]
        return min(places, key=lambda place: self._distance(trial, place), default=None)

    def _beyond(self, trial: Trial) -> Floats | None:
        """Return that place if it is so near that it bounds the motion, else None."""
        beyond = self._next_beyond(trial)
        is_near = beyond is not None and self._distance(trial, beyond) < AT_BOUND
        return beyond if is_near else None

    def next_attractor(self) -> Trial | None:
        """Return the motion of another attractor beyond the end of this one, None if there is none."""
        beyond = self._beyond(self.best)
        return None if beyond is None else self.others.get(beyond.tobytes())

    def _reason(self, stopped: str) -> str:
        """Return why the best motion is no optimum; empty if it is one."""
        if self._is_optimum(self.best):
            return ""
        shortfall = self.search.shortfall(self.best)
        if shortfall:
            return f"{shortfall}; {stopped}" if stopped else shortfall
        if self._beyond(self.best) is None:
            return stopped or KINK
        return NO_RUN if self.best.orbit is None else NO_ORBIT

    def near(self, place: Floats) -> Trial:
        """Return the motion at a place, or where there is none that from which SLSQP steps."""
        return self._trial(place) or self.base

    def _trial(self, place: Floats) -> Trial | None:
        key = place.tobytes()
        if key not in self.known:
            self.known[key] = self._made(place)
        return self.known[key]

    def _made(self, place: Floats) -> Trial | None:
        """Return the motion at a place, if there is one; on another attractor unless it is worse."""
        self.search.n_trials += 1
        if len(self.known) > self.most:
            raise _StopSearchError(f"{MOST_MOTIONS} motions were not enough")
        if not self.search.progress.advance():
            raise _StopSearchError("the search was stopped")
        trial = self.search.trials.at(self.search.values(place), self.base)
        if trial is None or not self.search.is_usable(trial):
            return None
        self.search.made.append(trial)
        self.n_vain += 1
        if self.search.is_better(SearchEnd(trial, ""), SearchEnd(self.best, "")):
            self.best, self.n_vain = trial, 0
        if self.n_vain > MOST_VAIN and self.search.miss(self.best) > 0.0:
            raise _StopSearchError(f"{MOST_VAIN} motions came no nearer to what is wanted")
        is_worse = self.search.is_better(SearchEnd(self.base, ""), SearchEnd(trial, ""))
        if trial.goes_on or not is_worse:
            return trial
        self.others[place.tobytes()] = trial
        return None

    def cost(self, place: Floats) -> float:
        """Return the cost, which is minimised."""
        trial = self._trial(place)
        if trial is None:
            self.n_beyond += 1
            if self.n_beyond > MOST_BEYOND:
                raise _BeyondError
            return self.cost(self.search.place(self.base.values)) + WITHOUT_MOTION
        if not isinstance(self.wanted.goal, str):
            return float(0.5 * np.square(place - self.search.given).sum())
        value = trial.outcome(self.wanted.outcome)[0] / self.scale
        return -value if self.wanted.goal == "largest" else value

    def slope(self, place: Floats) -> Floats:
        """Return the derivatives of the cost."""
        self.base = self.near(place)
        if not isinstance(self.wanted.goal, str):
            return place - self.search.given
        slope = self.base.outcome(self.wanted.outcome)[1] * self.search.width / self.scale
        return np.asarray(-slope if self.wanted.goal == "largest" else slope)

    def constraints(self) -> list[dict[str, Any]]:
        """Return the limits as constraints of SciPy."""
        rows: list[dict[str, Any]] = []
        if self.wanted.kept(self.base):
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
