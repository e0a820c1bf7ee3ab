"""The search for a fit: guesses, nodes and descents, with other nodes where these fail."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.fitting.effort import Effort
from percuss.fitting.guess import Windows, best_start, extremes_of, lay_out, windows_of
from percuss.fitting.losses import Loss
from percuss.fitting.measured import MeasuredRecord
from percuss.fitting.noise import (
    MEDIAN_SQUARE,
    groups_of,
    whiteness_of,
    with_noise_of_residuals,
)
from percuss.fitting.shooting import Layout
from percuss.fitting.solver import (
    FIRM,
    LOOSE,
    STRAINED,
    FitDescent,
    FitPoint,
    FitProblem,
    FitStep,
    descend,
    point_at,
)
from percuss.fitting.structure_guess import lay_out_structure
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.paths import replace_parameters
from percuss.model.structure import Structure
from percuss.progress import Progress

# From node to node, in periods of the fastest part of the motion, one after the other where the
# search fails.
CYCLES = (1.0, 0.5, 0.33, 2.0)
# The share of stretches of a whole motion that may be begun anew.
MOST_WRONG = 0.5
# How often torn stretches are begun anew with the same nodes.
MENDINGS = 3
# Stretches that are missed by so many standard errors are begun anew, too: it may be noise.
DOUBTFUL = 3.0
# Shifts of a node's state that are tried, in its standard errors.
_SIZES = (0.0, 0.3, -0.3, 1.0, -1.0, 3.0, -3.0, 9.0, -9.0, 25.0, -25.0)
SHIFTS = np.array([(x, v) for x in _SIZES[:9] for v in _SIZES])
# A residual counts as no more than this where states are tried: where there may be outliers too.
MOST_RESIDUAL, MOST_OF_OUTLIERS = 100.0, 10.0
# Guesses in ranges: for one range, and the most.
GUESSES, MOST_GUESSES = 8, 64
# The half of the range of a phase, a little more than half a turn: no end of it is a bound. Phases
# of it that are tried, and the part of the largest misfit of flights below which the least one
# tells it.
TURN, N_PHASES, TOLD = 1.1 * math.pi, 25, 0.8
# A mean square of the residuals above this many of its standard errors is not explained.
UNLIKELY = 6.0
# One above so many, or runs of one sign so many standard deviations fewer than of noise, make
# descents from other nodes worth while.
SUSPECT = 3.0
# Where the noise was estimated: residuals this many times as large as neighbours differ.
MUCH_LARGER = 3.0
# How often data are weighed anew by the noise of their residuals, and the change of it that is
# none.
MOST_WEIGHINGS, SAME_NOISE = 20, 1.001
# Two misfits are the same to this part.
SAME = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class FitCandidate:
    """The end of a descent: what is wrong with it, and the problem that it solved."""

    problem: FitProblem
    descent: FitDescent
    reason: str
    n_runs: int

    @property
    def misfit(self) -> float:
        """The mean square of the residuals."""
        return float(np.mean(np.square(self.descent.point.equations.right)))


class FitSearch:
    """A search for the parameters of one or several records.

    Parameters
    ----------
    osc
        The oscillator, or the structure.
    records
        What was measured.
    guesses
        The parameters by their paths.
    low, high
        Their bounds.
    ranged
        Which of them were given as ranges, in which a guess is sought.
    priors, loss
        See `FitProblem`.
    progress
        Counts the steps.
    before
        Problem and nodes of a search to go on from, with the values of the guesses; None: a new
        one.
    keep
        See `FitProblem`.
    asked
        The names that parameters were asked for by, by their paths.
    """

    def __init__(
        self,
        osc: Oscillator | Structure,
        records: Sequence[MeasuredRecord],
        guesses: dict[str, float],
        low: Floats,
        high: Floats,
        ranged: Flags,
        priors: Floats,
        loss: Loss,
        progress: Progress,
        before: tuple[FitProblem, Floats] | None = None,
        keep: Callable[[FitProblem, FitPoint], None] | None = None,
        asked: Mapping[str, str] | None = None,
    ) -> None:
        self.osc, self.records, self.paths = osc, list(records), tuple(guesses)
        self.guess = np.clip(np.array(list(guesses.values())), low, high)
        self.low, self.high, self.ranged = low, high, ranged
        self.priors, self.loss, self.progress = priors, loss, progress
        self.n_runs, self.before, self.keep = 0, before, keep
        self.effort, self.asked = Effort(progress.tick), dict(asked or {})
        self._windows: Windows | None = None

    def best(self) -> FitCandidate:
        """Return the best candidate of descents with several distances of nodes."""
        best = self._gone_on()
        if best is not None and (not best.reason or self._is_over):
            return self._with_noise(self._closed(best))
        values = self._possible() if best is None else best.descent.point.values
        for attempt, cycles in enumerate(CYCLES):
            problem, nodes = self._laid_out(values, cycles)
            is_first = attempt == 0 and best is None
            begin = self._begin(problem, nodes, values, is_first=is_first)
            if begin is None:
                if self._is_over:
                    break
                continue
            candidate = self._mended(self._descended(problem, begin))
            again = best is not None and _is_same(candidate, best)
            if best is None or _is_better(candidate, best):
                best = candidate
            is_fine = not candidate.reason and not self._is_doubtful(candidate)
            if is_fine or again or self._is_over:
                break
            values = best.descent.point.values
        if best is None:
            reason = "no motion can be followed from the guess; give others"
            raise ParameterError(
                "free", dict(zip(self.paths, self.guess.tolist(), strict=True)), reason
            )
        return self._with_noise(self._closed(best))

    def turned(self) -> FitSearch | None:
        """Return the search from other phases, where the loggers may have begun; None without any.

        They are those that flights without stops tell best. Where these tell none, as forces of
        stops do not, guesses of phases become ranges of a whole turn.
        """
        phases = np.array([path.endswith(".phase") for path in self.paths])
        guess, low, high = self.guess.copy(), self.low.copy(), self.high.copy()
        is_told = isinstance(self.osc, Oscillator)
        for row in np.flatnonzero(phases):
            is_range = bool(self.ranged[row])
            ends = (low[row], high[row]) if is_range else (guess[row] - TURN, guess[row] + TURN)
            tried = np.tile(guess, (N_PHASES, 1))
            tried[:, row] = np.linspace(*ends, N_PHASES)
            misfits = [self._misfit_of_flights(values) for values in tried] if is_told else [0.0]
            is_told = is_told and min(misfits) < TOLD * max(misfits)
            guess = tried[int(np.argmin(misfits))] if is_told else guess
            if not is_told and not is_range:
                low[row], high[row] = ends
        moved = phases & (is_told | ~self.ranged)
        if not moved.any():
            return None
        other = FitSearch(
            self.osc, self.records, dict(zip(self.paths, guess.tolist(), strict=True)), low, high,
            self.ranged & ~phases if is_told else self.ranged | phases, self.priors, self.loss,
            self.progress, None, self.keep, self.asked,
        )  # fmt: skip
        other.n_runs = self.n_runs
        return other

    def _misfit_of_flights(self, values: Floats) -> float:
        """Return by how much most stretches of the records miss flights without stops."""
        assert isinstance(self.osc, Oscillator)
        named = dict(zip(self.paths, values.tolist(), strict=True))
        return sum(
            float(np.median(windows_of(self.osc, record, named).misfits))
            for record in self.records
            if len(record.samples)
        )

    @property
    def _is_over(self) -> bool:
        """Whether the caller, or the effort, allows no further run."""
        return self.progress.is_stopped or self.effort.is_spent

    def _possible(self) -> Floats:
        """Return the guess, or where it makes no model the first one in the ranges that does."""
        record, first = self.records[0], None
        tried: list[Floats] = [self.guess, *self._guesses(self.guess)]
        for values in tried:
            try:
                replace_parameters(
                    self.osc, record.force, record.start,
                    dict(zip(self.paths, values.tolist(), strict=True)),
                )  # fmt: skip
            except ParameterError as error:
                first = first or error
            else:
                return values
        assert first is not None
        if not self.ranged.any():
            raise first
        ends = {
            path: (float(low), float(high))
            for path, low, high, is_range in zip(
                self.paths, self.low, self.high, self.ranged, strict=True
            )
            if is_range
        }
        reason = f"no values tried in the ranges make a model; in their middle {first.name} is "
        raise ParameterError("free", ends, reason + first.reason) from first

    def _gone_on(self) -> FitCandidate | None:
        """Return where a search ends that begins where another one was; None without one."""
        if self.before is None:
            return None
        problem, nodes = self.before
        problem = replace(
            problem, low=self.low, high=self.high, priors=self.priors, loss=self.loss,
            ask=self.progress.advance, keep=self.keep, effort=self.effort,
        )  # fmt: skip
        begin = self._point_at(problem, self.guess, nodes)
        return None if begin is None else self._mended(self._descended(problem, begin))

    def _closed(self, candidate: FitCandidate) -> FitCandidate:
        """Return the best candidate whose segments connect, where the best of all is torn."""
        if not len(candidate.descent.torn(candidate.problem)) or self._is_over:
            return candidate
        problem = replace(candidate.problem, tear=math.inf)
        point = candidate.descent.point
        begin = self._point_at(problem, point.values, point.shots.nodes)
        if begin is None:
            return candidate
        other = self._descended(problem, begin)
        return candidate if len(other.descent.torn(problem)) else other

    def _laid_out(self, values: Floats, cycles: float) -> tuple[FitProblem, Floats]:
        """Return the problem with nodes at some distance, and their states."""
        named = dict(zip(self.paths, values.tolist(), strict=True))
        layouts: list[Layout] = []
        states: list[Floats] = []
        errors: list[Floats] = []
        for record in self.records:
            if isinstance(self.osc, Structure):
                layout, nodes, error = lay_out_structure(self.osc, record, named, cycles)
            else:
                windows = windows_of(self.osc, record, named)
                layout, nodes = lay_out(self.osc, record, windows, cycles)
                error = _node_errors(record, windows)
                self._windows = windows
            layouts.append(layout)
            states.append(nodes)
            errors.append(error)
        problem = FitProblem(
            self.osc, layouts, self.paths, self.low, self.high,
            np.median(np.array(errors), axis=0), self.priors, self.loss, self.progress.advance,
            keep=self.keep, effort=self.effort,
        )  # fmt: skip
        return problem, np.concatenate(states)

    def _begin(
        self, problem: FitProblem, nodes: Floats, values: Floats, *, is_first: bool
    ) -> FitPoint | None:
        """Return the best of the guesses."""
        tried = self._guesses(values) if is_first else [values]
        points = []
        for guess in tried:
            if self._is_over:
                break
            point = self._point_at(problem, guess, nodes)
            if point is not None:
                points.append(point)
        return min(points, key=lambda point: point.cost(problem, LOOSE), default=None)

    def _guesses(self, values: Floats) -> list[Floats]:
        """Return guesses: that given, places in the ranges, and walls where the motion turns."""
        n = int(self.ranged.sum())
        guesses = [values]
        if n:
            guesses = []
            for i in range(min(MOST_GUESSES, GUESSES << (n - 1))):
                guess = values.copy()
                places = np.array([_halton(i + 1, base) for base in _PRIMES[:n]])
                low, high = self.low[self.ranged], self.high[self.ranged]
                guess[self.ranged] = low + places * (high - low)
                guesses.append(guess)
        walls = self._walls()
        if not walls:
            return guesses
        moved, passed = [], n > 0
        for guess in guesses:
            other = guess.copy()
            for row, (at, side) in walls.items():
                passed = passed or side * (at - guess[row]) > 0.0
                other[row] = min(max(at, self.low[row]), self.high[row])
            moved.append(other)
        # A wall that the motion passes is none.
        return moved if passed else [*guesses, *moved]

    def _walls(self) -> dict[int, tuple[float, float]]:
        """Return the free places of walls: how far the motion goes there, and on which side."""
        places: dict[int, tuple[float, float]] = {}
        if self._windows is None:
            return places
        good = self._windows.good()
        if not len(good.t) or not len(self.records[0].samples):
            return places
        least, largest = extremes_of(good)
        for i, stop in enumerate(self.osc.stops):
            path = f"oscillator.stops.{i}.at"
            if isinstance(stop, Wall) and path in self.paths:
                above = stop.side == "above"
                places[self.paths.index(path)] = (largest, 1.0) if above else (least, -1.0)
        return places

    def _descended(self, problem: FitProblem, begin: FitPoint) -> FitCandidate:
        """Return where a descent ends."""
        descent = descend(problem, begin, LOOSE)
        self.n_runs += descent.n_runs
        return FitCandidate(problem, descent, self._reason(problem, descent), self.n_runs)

    def _mended(self, candidate: FitCandidate) -> FitCandidate:
        """Return the candidate after torn stretches were followed anew from their own samples."""
        for _ in range(MENDINGS):
            torn = candidate.descent.torn(candidate.problem)
            wrong = np.union1d(torn, self._strained(candidate.descent, DOUBTFUL))
            if not len(wrong) or self._is_over:
                break
            # Small misfits of most segments are not caused by single impacts.
            is_whole = candidate.descent.is_settled and not len(torn)
            if is_whole and len(wrong) > max(MOST_WRONG * len(candidate.problem.linked), 3):
                break
            begin = self._begun_anew(candidate, wrong)
            if begin is None:
                break
            other = self._descended(candidate.problem, begin)
            if not _is_better(other, candidate):
                break
            candidate = other
        return candidate

    def _strained(self, descent: FitDescent, errors: float = STRAINED) -> Integers:
        """Return the segments that noise does not explain, of the size that it was given or has."""
        if self._is_noise_known:
            return descent.strained(errors)
        right = descent.point.equations.right
        size = math.sqrt(float(np.median(right * right)) / MEDIAN_SQUARE) or 1.0
        return descent.strained(errors, size)

    @property
    def _is_noise_known(self) -> bool:
        return not any(
            some.is_estimated.any()
            for record in self.records
            for some in (record.samples, record.impacts)
        )

    def _is_doubtful(self, candidate: FitCandidate) -> bool:
        """Return whether residuals that may be noise are rather large, or hang together.

        Other nodes may then lead to a better end.
        """
        residuals = candidate.descent.point.equations.residuals
        limit = 1.0 + SUSPECT * math.sqrt(2.0 / len(residuals))
        is_large = self._is_noise_known and self.loss.name == "linear"
        return (is_large and candidate.misfit > limit) or (
            whiteness_of(candidate.problem.layouts, residuals) < -SUSPECT
        )

    def _begun_anew(self, candidate: FitCandidate, wrong: Integers) -> FitPoint | None:
        """Return the point with better states of the nodes at the ends of some segments.

        Less than the noise of a node may decide whether a slow impact happens: states around the
        one by its own samples are tried.
        """
        problem, point = candidate.problem, candidate.descent.point
        if isinstance(self.osc, Structure):
            return None
        named = dict(zip(self.paths, point.values.tolist(), strict=True))
        nodes, ends, row = point.shots.nodes.copy(), point.shots.ends.copy(), 0
        for layout in problem.layouts:
            good = windows_of(self.osc, layout.record, named).good()
            for k in np.union1d(wrong, wrong + 1).tolist():
                if not row + layout.is_fixed <= k < row + len(layout):
                    continue
                centres = [nodes[k]]
                if k > row and len(good.t):
                    centres.append(
                        good.states[np.argmin(np.abs(good.t - layout.spans[k - row, 0]))]
                    )
                elif len(good.t):
                    # From the first window that is a flight straight back, or off a wall between.
                    x, v = good.first_states[0].tolist()
                    late = float(good.begin[0] - layout.spans[0, 0])
                    centres += [np.array([x - v * late, v]), np.array([x, -v])]
                before = ends[k - 1] if k > row else None
                after = nodes[k + 1] if k + 1 < row + len(layout) else None
                tried = np.concatenate([at + SHIFTS * problem.node_errors for at in centres])
                most = MOST_RESIDUAL if self.loss.name == "linear" else MOST_OF_OUTLIERS
                nodes[k], ends[k] = best_start(
                    self.osc, layout, k - row, named, tried, (problem.node_errors, most),
                    (before, after), self.effort,
                )  # fmt: skip
            row += len(layout)
        return self._point_at(problem, point.values, nodes)

    def _point_at(self, problem: FitProblem, values: Floats, nodes: Floats) -> FitPoint | None:
        """Return the runs from nodes, which are counted, at values; None where there are none."""
        self.n_runs += 1
        return point_at(problem, values, nodes)

    def _reason(self, problem: FitProblem, descent: FitDescent) -> str:
        """Return why a descent has not found what explains the data; empty if it has."""
        torn = descent.torn(problem)
        if self.progress.is_stopped:
            return descent.reason or "the search was stopped"
        if len(torn):
            begin, end = _span(problem, torn[0])
            return (
                f"no admissible motion explains the samples between t = {begin:.6g} and {end:.6g}"
                + _others(len(torn) - 1)
                + "; check the units, the frequency of the force, and give what is uncertain as ranges"
            )
        if misfit := self._misfit(problem, descent, is_weighed=False):
            return misfit
        known = self._is_noise_known
        strained = self._strained(descent)
        # Where most are, residuals have long tails everywhere.
        is_told = known or len(strained) <= MOST_WRONG * len(problem.linked)
        if is_told and self.loss.name == "linear" and len(strained):
            begin, end = _span(problem, strained[0])
            noise = "their noise" if known else "the noise of the others"
            return (
                f"the samples between t = {begin:.6g} and {end:.6g} are missed by more than {noise}"
                + _others(len(strained) - 1)
            )
        return "" if descent.is_settled else descent.reason

    def _misfit(self, problem: FitProblem, descent: FitDescent, *, is_weighed: bool) -> str:
        """Return by how much the residuals are too large; empty if they are not.

        Unless ``is_weighed``, that data without a noise have that of their residuals, their weight
        may pull the motion off those with one.
        """
        residuals = descent.point.equations.residuals
        guessed = np.concatenate([
            samples.is_estimated
            for layout in problem.layouts
            for samples in (layout.record.samples, layout.record.impacts)
        ])  # fmt: skip
        words = "no admissible motion near the guess explains the data: "
        for is_guessed in (False, True):
            own = residuals[guessed == is_guessed]
            if not len(own) or (is_guessed and is_weighed):
                continue
            squares = np.square(own)
            misfit = float(np.mean(squares))
            if self.loss.name != "linear":
                misfit = float(np.median(squares)) / MEDIAN_SQUARE
            is_strict = not is_guessed and (is_weighed or self._is_noise_known)
            limit = 1.0 + UNLIKELY * math.sqrt(2.0 / len(own)) if is_strict else MUCH_LARGER**2
            if misfit > limit and is_guessed:
                times = math.sqrt(misfit)
                return (
                    f"{words}the residuals are {times:.3g} times as large as the noise between "
                    "neighbouring values"
                )
            if misfit > limit:
                return f"{words}chi2 is {misfit:.3g} where 1 was to be expected"
        return ""

    def _with_noise(self, candidate: FitCandidate) -> FitCandidate:
        """Return the candidate with the noise that its residuals have, where that was not given."""
        if self._is_noise_known:
            return candidate
        for _ in range(MOST_WEIGHINGS):
            before = candidate.descent.point
            layouts, change = with_noise_of_residuals(candidate.problem, before)
            # A motion that was followed before.
            problem = replace(candidate.problem, layouts=layouts, effort=None)
            point = self._point_at(problem, before.values, before.shots.nodes)
            if point is None:
                return candidate
            is_moved = self._has_weights and not candidate.reason
            if is_moved:
                descent = descend(problem, point, FIRM)
                self.n_runs += descent.n_runs
            else:
                descent = _at_point(problem, candidate.descent, point)
            reason = candidate.reason
            if is_moved:
                reason = self._misfit(problem, descent, is_weighed=True)
            candidate = FitCandidate(problem, descent, reason, self.n_runs)
            if not is_moved or change < SAME_NOISE:
                break
        return candidate

    @property
    def _has_weights(self) -> bool:
        """Whether the best values depend on what the noise of some data is."""
        groups = [
            groups_of(samples)
            for record in self.records
            for samples in (record.samples, record.impacts)
        ]
        is_robust = self.loss.name != "linear"
        return sum(map(len, groups)) > 1 or len(self.priors) > 0 or is_robust


def _span(problem: FitProblem, k: int) -> list[float]:
    """Return when a segment begins and ends."""
    return list(np.concatenate([layout.spans for layout in problem.layouts])[k].tolist())


def _others(n: int) -> str:
    """Return how many stretches there are beside the one that is named."""
    return f", and {n} other stretch{'es' if n > 1 else ''}" if n else ""


def _at_point(problem: FitProblem, descent: FitDescent, point: FitPoint) -> FitDescent:
    """Return a descent at the same place under another noise."""
    triangle = FitStep.of(problem, point, FIRM).triangle
    return FitDescent(point, triangle, 0, descent.is_settled, descent.reason, descent.weight)


def _is_same(one: FitCandidate, other: FitCandidate) -> bool:
    """Return whether two descents have ended at one solution: the second explains no more."""
    if len(one.descent.torn(one.problem)) or len(other.descent.torn(other.problem)):
        return False
    settled = one.descent.is_settled and other.descent.is_settled
    return settled and abs(one.misfit - other.misfit) < SAME * other.misfit


def _is_better(one: FitCandidate, other: FitCandidate) -> bool:
    keys = [
        (bool(candidate.reason), len(candidate.descent.torn(candidate.problem)), candidate.misfit)
        for candidate in (one, other)
    ]
    return keys[0] < keys[1]


def _node_errors(record: MeasuredRecord, windows: Windows) -> Floats:
    """Return the standard errors of x and v of a node by the samples around it."""
    good = windows.good()
    if len(good.t):
        errors = np.median(good.errors, axis=0)
        if (errors > 0.0).all():
            return np.asarray(errors)
    samples = record.samples if len(record.samples) else record.impacts
    size = float(np.median(samples.noise))
    length = (record.end - record.begin) / max(len(samples) - 1, 1) or 1.0
    return np.array([size, size / length])


_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


def _halton(i: int, base: int) -> float:
    """Return the i-th of a sequence of places spread over (0, 1) (Halton 1960)."""
    place, part = 0.0, 1.0
    while i:
        part /= base
        i, digit = divmod(i, base)
        place += part * digit
    return place
