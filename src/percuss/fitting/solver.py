"""Least squares over parameters and nodes: Gauss-Newton's steps, from loose links to firm ones.

A segment need not end at the next node at first: the defects are equations with a weight that grows
from step to step. While it is small, all segments stay near their samples, and the equations are
nearly linear in the parameters (docs/theory/fitting.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.fitting.effort import Effort
from percuss.fitting.losses import Loss
from percuss.fitting.measured import MeasuredSamples
from percuss.fitting.shooting import Layout, Shots, shoot
from percuss.kernels.condense import Chain, condense, expand
from percuss.kernels.segments import DISPLACEMENT, OF_STOP, VELOCITY
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.structure import Structure
from percuss.numerics import log
from percuss.numerics.linear import least_squares, matmul, norm

# Weights of the links in standard errors of the nodes: at first, the factor of a step, at last.
LOOSE, FIRMER, FIRM = 1.0, 10.0, 1e5
# From this weight on samples have the loss that was asked for.
TAUT = 1e3
# Defects, and residuals at first, beyond this many of their weights count less.
TORN = 10.0
# A link is torn for good if it misses by more than this part of the nodes' standard errors.
HELD = 0.1
# A segment's sum of squares so large that of noise one in three hundred thousand is, as a normal
# variable beyond so many standard deviations, is not noise; squares count up to that of so many
# standard deviations, for one outlier is no stretch.
STRAINED, OUTLYING = 4.5, 5.0
# Weight by which a node's state keeps its value where no sample determines it.
ANCHOR = 1e-6
# Damping: at first, and its factors after failure and success.
DAMPING, MORE, LESS = 1e-2, 8.0, 0.125
# Links become firmer after a step that achieves this part of the decrease it promised; below this
# mean square, after any.
KEPT, GOOD = 0.5, 2.0
# A search ends where a step moves nothing by more than this part of its standard error, squared.
CLOSE = 1e-6
# Most steps, and trials of a step; and how often links are loosened again.
MOST_STEPS, MOST_TRIALS, MOST_LOOSENINGS = 150, 10, 4
# The width of a kink, in intervals between samples.
KINK = 0.1
# By so much, in these intervals, the instant of an event at a soft stop may be off in the end. More
# lets it stand on the side of a sample that suits the noise.
LATE = 0.03
# Where no step makes the misfit smaller, one below this part of a standard error, squared, is none.
NO_STEP = 0.01
# The same at a kink, from which derivatives between both sides lead a little.
AT_KINK = 0.1
# Singular values below this part of the largest one count as zero.
WEAK = 1e-11
# The end of a search whose motions cost more and more.
SPENT = "the motions that were tried have too many events to go on"
# The loss of the samples until the links are firm.
ROBUST = Loss("cauchy", TORN)


@dataclass(frozen=True, eq=False)
class FitProblem:
    """The least-squares problem of a fit.

    Attributes
    ----------
    osc
        The oscillator, or the structure.
    layouts
        The records and their nodes.
    paths, low, high
        The parameters and their bounds, infinite where there is none.
    node_errors
        (d,) array, standard errors of the d numbers of a node by the samples around it.
    priors
        (n, 3) array: the parameter, its mean, its standard deviation.
    loss
        Of the residuals.
    ask
        Called after each run; False ends the search.
    tear
        Defects beyond this many of their weights count less, as in Cauchy's loss.
    keep
        Called with the problem and the point after each step that is taken.
    effort
        What its runs may cost.
    """

    osc: Oscillator | Structure
    layouts: Sequence[Layout]
    paths: tuple[str, ...]
    low: Floats
    high: Floats
    node_errors: Floats
    priors: Floats
    loss: Loss
    ask: Callable[[], bool]
    tear: float = TORN
    keep: Callable[[FitProblem, FitPoint], None] | None = None
    effort: Effort | None = None

    def shoot(self, values: Floats, nodes: Floats) -> Shots | None:
        """Return the runs from all nodes, None if there are none that can be followed."""
        named = dict(zip(self.paths, values.tolist(), strict=True))
        try:
            shots = shoot(self.osc, self.layouts, named, nodes, self.effort)
        except ParameterError:
            return None
        return shots if shots.is_complete else None

    @property
    def is_spent(self) -> bool:
        """Whether no further run may be made."""
        return self.effort is not None and self.effort.is_spent

    def loss_at(self, weight: float) -> Loss:
        """Return the loss while links have a weight: stretches that miss an impact pull less.

        Forces of stops are known in contacts only, and keep their weight.
        """
        return ROBUST if self.starts_robust and weight < TAUT else self.loss

    @cached_property
    def starts_robust(self) -> bool:
        """Whether something else than forces was measured, and no loss was asked for."""
        measured = [layout.record.samples.kinds < OF_STOP for layout in self.layouts]
        return self.loss.name == "linear" and any(bool(some.any()) for some in measured)

    def is_continuous(self, samples: MeasuredSamples) -> Flags:
        """Return which samples are of a quantity that does not jump at events."""
        has_walls = any(isinstance(stop, Wall) for stop in self.osc.stops)
        smooth = samples.kinds == DISPLACEMENT
        return np.asarray(smooth if has_walls else smooth | (samples.kinds == VELOCITY))

    @property
    def linked(self) -> Flags:
        """Whether another segment of the same record follows each."""
        parts = [np.arange(len(layout)) < len(layout) - 1 for layout in self.layouts]
        return np.concatenate(parts)


@dataclass(frozen=True, slots=True, eq=False)
class FitEquations:
    """The residuals at a point, in standard deviations, and their derivatives.

    ``segment`` (n,) is the segment of each, ``right`` (n,) measured less computed, ``rows``
    (n, n_parameters + d) the derivatives of the latter; ``defects`` (n_segments, d) by what each
    segment misses the next node. They are in the order of segments; ``order`` has where each was.
    """

    segment: Integers
    right: Floats
    rows: Floats
    defects: Floats
    order: Integers

    @property
    def residuals(self) -> Floats:
        """The residuals of each record's samples, then of its impacts, in standard deviations."""
        in_order = np.empty_like(self.right)
        in_order[self.order] = self.right
        return in_order


@dataclass(frozen=True, slots=True, eq=False)
class FitPoint:
    """Values of the parameters with the runs from all nodes.

    In ``loose`` equations a sample within an interval of an event is on the side that suits it
    better, for the instant of the event may be off by as much, and derivatives pass from one side
    to the other; in the others the former only where jumps at walls tell the side.
    """

    values: Floats
    shots: Shots
    equations: FitEquations
    loose: FitEquations

    def equations_at(self, weight: float) -> FitEquations:
        """Return the equations while links have a weight."""
        return self.equations if weight >= TAUT else self.loose

    def cost(self, problem: FitProblem, weight: float) -> float:
        """Return the sum of the losses, with links of a weight."""
        equations = self.equations_at(weight)
        links = weight * weight * squares_of_defects(problem, equations.defects)
        if problem.tear < math.inf:
            links = problem.tear**2 * log(1.0 + links / problem.tear**2)
        whole = problem.loss_at(weight).sum(equations.right) + float(links.sum())
        for row, mean, sigma in problem.priors.tolist():
            whole += ((self.values[int(row)] - mean) / sigma) ** 2
        return whole


def squares_of_defects(problem: FitProblem, defects: Floats) -> Floats:
    """Return the square of the defect of each link, in standard errors of the nodes."""
    parts = defects / problem.node_errors
    return np.asarray((parts * parts).sum(axis=1))


def point_at(problem: FitProblem, values: Floats, nodes: Floats) -> FitPoint | None:
    """Return the point with these values and nodes, None if there is none."""
    shots = problem.shoot(values, nodes)
    if shots is None:
        return None
    has_walls_alone = all(isinstance(stop, Wall) for stop in problem.osc.stops)
    equations = equations_of(problem, shots, 1.0 if has_walls_alone else LATE, 0.0)
    return FitPoint(values, shots, equations, equations_of(problem, shots, 1.0, KINK))


def equations_of(problem: FitProblem, shots: Shots, near: float, kink: float) -> FitEquations:
    """Return the residuals of all samples and impacts.

    Samples ``near`` an event, in intervals between samples, are on the side that suits them better;
    the derivatives of those within a ``kink`` are between both sides.
    """
    defects = np.zeros_like(shots.ends)
    linked = np.flatnonzero(problem.linked)
    defects[linked] = shots.ends[linked] - shots.nodes[linked + 1]
    segments: list[Integers] = []
    rights: list[Floats] = []
    rows: list[Floats] = []
    sample = node = 0
    for layout in problem.layouts:
        some = layout.record.samples
        own = slice(sample, sample + len(some))
        counts = np.diff(layout.first)
        segments.append(np.repeat(np.arange(node, node + len(layout)), counts))
        parts = _sided(some, shots, own, (near, kink), problem.is_continuous(some))
        rights.append(parts[0])
        rows.append(parts[1])
        impacts = layout.record.impacts
        if len(impacts):
            segment, right, row = _matched(layout, shots.hits, node)
            segments.append(segment)
            rights.append(right)
            rows.append(row)
        sample += len(some)
        node += len(layout)
    segment = np.concatenate(segments)
    order = np.argsort(segment, kind="stable")
    return FitEquations(
        segment[order], np.concatenate(rights)[order], np.concatenate(rows)[order], defects, order
    )


def _sided(
    some: MeasuredSamples,
    shots: Shots,
    own: slice,
    reaches: tuple[float, float],
    is_continuous: Flags,
) -> tuple[Floats, Floats]:
    """Return residuals and rows of samples, those near events on the side that fits better.

    What is continuous is the same on both sides, but its derivatives are not: next to the event
    they pass from one to the other, or a search would oscillate across the kink.
    """
    near, kink = reaches
    both = (some.values[:, None] - shots.values[own]) / some.noise[:, None]
    rows = shots.rows[own] / some.noise[:, None, None]
    right, row = both[:, 0].copy(), rows[:, 0].copy()
    near_event = np.flatnonzero(np.isfinite(shots.away[own]))
    jumps = ~is_continuous[near_event]
    away = shots.away[own][near_event] / some.reach
    better = np.abs(both[near_event, 1]) < np.abs(both[near_event, 0])
    other = near_event[jumps & better & (away <= near)]
    right[other], row[other] = both[other, 1], rows[other, 1]
    bent = ~jumps & (away < kink)
    beside, share = near_event[bent], 0.5 - 0.5 * away[bent] / (kink or 1.0)
    row[beside] += share[:, None] * (rows[beside, 1] - rows[beside, 0])
    return right, row


# A measured impact that no run has counts as this many standard deviations.
UNSEEN = 100.0


def _matched(layout: Layout, hits: Floats, node: int) -> tuple[Integers, Floats, Floats]:
    """Return segments, residuals and rows of impact times: each with the nearest of the runs.

    Where nothing else was measured each lies in a segment of its own, and is met there.
    """
    impacts = layout.record.impacts
    hits = hits[(hits[:, 0] >= node) & (hits[:, 0] < node + len(layout))]
    own = node + np.searchsorted(layout.spans[:, 0], impacts.t, side="right") - 1
    own = np.maximum(own, node)
    distance = np.abs(hits[None, :, 1] - impacts.t[:, None])
    if not len(layout.record.samples):
        distance = np.where(hits[None, :, 0] == own[:, None], distance, np.inf)
    n, width = len(impacts), hits.shape[1] - 2
    segment, right, rows = own.astype(np.int64), np.full(n, UNSEEN), np.zeros((n, width))
    if len(hits):
        nearest = np.argmin(distance, axis=1)
        met = np.isfinite(distance[np.arange(n), nearest])
        hit = hits[nearest[met]]
        segment[met] = hit[:, 0].astype(np.int64)
        right[met] = (impacts.t[met] - hit[:, 1]) / impacts.noise[met]
        rows[met] = hit[:, 2:] / impacts.noise[met, None]
    return segment, right, rows


@dataclass(eq=False)
class FitDescent:
    """A search, and where it ended.

    Attributes
    ----------
    point
        The best point.
    triangle
        (n, n_parameters + 1) array: the equations of the parameters after the nodes are eliminated,
        as many as there are parameters, numbers of a state and priors.
    n_runs
        How often all segments were followed.
    is_settled
        Whether the last steps were far below the standard errors.
    reason
        Why it ended otherwise.
    weight
        Of the links between segments, in the last steps.
    """

    point: FitPoint
    triangle: Floats
    n_runs: int = 0
    is_settled: bool = False
    reason: str = ""
    weight: float = field(default=LOOSE)

    def strained(self, errors: float = STRAINED, size: float = 1.0) -> Integers:
        """Return the segments whose samples are missed by more than by noise.

        The cube root of their sum of squares, which is nearly normal (Wilson and Hilferty 1931,
        Proc. Natl. Acad. Sci. 17, 684), is so many standard ``errors`` too large; ``size`` is that
        of the noise, in units of the assumed one.
        """
        right, segment = self.point.equations.right, self.point.equations.segment
        n = len(self.point.equations.defects)
        counts = np.bincount(segment, minlength=n)
        squares = np.minimum(np.square(right / size), OUTLYING * OUTLYING)
        sums = np.bincount(segment, weights=squares, minlength=n)
        spread = 2.0 / (9.0 * np.maximum(counts, 1))
        return np.flatnonzero(sums > counts * (1.0 - spread + errors * np.sqrt(spread)) ** 3)

    def torn(self, problem: FitProblem) -> Integers:
        """Return the segments that do not end at the next node."""
        squares = squares_of_defects(problem, self.point.equations.defects)
        return np.flatnonzero(squares > HELD * HELD)


def descend(problem: FitProblem, start: FitPoint, weight: float = LOOSE) -> FitDescent:
    """Go from a point to the least squares.

    Parameters
    ----------
    problem
        The problem.
    start
        Where to begin.
    weight
        Of the links at first.

    Returns
    -------
    FitDescent
        Where it ended.
    """
    descent = FitDescent(start, np.zeros((0, len(problem.paths) + 1)), weight=weight)
    damping, loosened = 0.0, 0
    for _ in range(MOST_STEPS):
        before = descent.point.cost(problem, descent.weight)
        step = FitStep.of(problem, descent.point, descent.weight)
        descent.triangle = step.triangle
        trial, damping = _tried(problem, descent, step, before, damping)
        if not problem.ask():
            descent.reason = "the search was stopped"
            return descent
        if problem.is_spent:
            descent.reason = SPENT
            return descent
        if trial is None:
            if descent.weight >= TAUT and _is_least(problem, descent, step):
                descent.is_settled = True
                return descent
            if descent.weight <= LOOSE or loosened == MOST_LOOSENINGS:
                descent.reason = "no step makes the misfit smaller"
                return descent
            descent.weight, damping, loosened = (
                max(descent.weight / FIRMER, LOOSE),
                0.0,
                loosened + 1,
            )
            continue
        moved = matmul(step.triangle[:, :-1], trial.values - descent.point.values)
        promised = step.promised(problem, descent.point, damping)
        after = trial.cost(problem, descent.weight)
        descent.point = trial
        if problem.keep is not None:
            problem.keep(problem, trial)
        if descent.weight >= FIRM and norm(moved) ** 2 < CLOSE:
            descent.triangle = FitStep.of(problem, trial, descent.weight).triangle
            descent.is_settled = True
            return descent
        share = (before - after) / max(promised, 1e-300)
        is_good = share > KEPT or after < GOOD * len(trial.equations.right)
        if share > KEPT:
            damping = damping * LESS if damping > 1e-6 else 0.0
        if is_good and damping < 1.0:
            descent.weight = min(descent.weight * FIRMER, FIRM)
    descent.reason = f"{MOST_STEPS} steps were not enough"
    return descent


def _is_least(problem: FitProblem, descent: FitDescent, step: FitStep) -> bool:
    """Return whether the step, which makes nothing better, is none.

    A least misfit may be a kink, where an impact meets a sample: the step with derivatives between
    both sides is none there.
    """
    point, weight = descent.point, descent.weight
    bent = FitStep.of(problem, replace(point, equations=point.loose), weight)
    for some, limit in ((step, NO_STEP), (bent, AT_KINK)):
        moved = matmul(some.triangle[:, :-1], some.parameters(problem, point.values, 0.0))
        if norm(moved) ** 2 < limit:
            return True
    return False


def _tried(
    problem: FitProblem, descent: FitDescent, step: FitStep, before: float, damping: float
) -> tuple[FitPoint | None, float]:
    """Return the point of a step that makes the cost smaller, and its damping."""
    for _ in range(MOST_TRIALS):
        values, nodes = step.taken(problem, descent.point, damping)
        trial = point_at(problem, values, nodes)
        descent.n_runs += 1
        if problem.is_spent:
            break
        if trial is not None:
            after = trial.cost(problem, descent.weight)
            if after < before * (1.0 + 1e-9) + CLOSE:
                return trial, damping
        damping = max(damping * MORE, DAMPING)
    return None, damping


@dataclass(frozen=True, slots=True, eq=False)
class FitStep:
    """The linear equations at a point, with the nodes eliminated."""

    chain: Chain
    factors: Floats
    triangle: Floats
    weights: Floats

    @classmethod
    def of(cls, problem: FitProblem, point: FitPoint, weight: float) -> FitStep:
        """Return the equations at a point, with links of a weight."""
        equations, n_p = point.equations_at(weight), len(problem.paths)
        square = weight * weight * squares_of_defects(problem, equations.defects)
        links = weight / np.sqrt(1.0 + square / problem.tear**2)
        kept = problem.loss_at(weight).weights(equations.right)
        n = len(equations.defects)
        counts = np.bincount(equations.segment, minlength=n)
        first = np.concatenate([[0], np.cumsum(counts)])
        chain = Chain(
            equations.rows * kept[:, None], equations.right * kept, first,
            point.shots.end_rows, equations.defects, problem.linked,
            links[:, None] / problem.node_errors, ANCHOR / problem.node_errors,
        )  # fmt: skip
        d = equations.defects.shape[1]
        width = 2 * d + n_p + 1
        factors = np.zeros((n, d, width))
        carried = np.zeros((d + n_p, d + n_p + 1))
        condense(chain, factors, carried, np.zeros((3 * d + n_p + int(counts.max()), width)))
        rows = [carried[:, d:]]
        for row, mean, sigma in problem.priors.tolist():
            prior = np.zeros((1, n_p + 1))
            prior[0, int(row)], prior[0, -1] = 1.0 / sigma, (mean - point.values[int(row)]) / sigma
            rows.append(prior)
        return cls(chain, factors, np.concatenate(rows), kept)

    def parameters(self, problem: FitProblem, values: Floats, damping: float) -> Floats:
        """Return the step of the parameters that stays within their bounds."""
        matrix, right = self.triangle[:, :-1], self.triangle[:, -1]
        n = matrix.shape[1]
        sizes = np.sqrt((matrix * matrix).sum(axis=0))
        units = np.where(sizes > 0.0, sizes, 1.0)
        whole = np.concatenate([matrix / units, math.sqrt(damping) * np.eye(n)])
        right = np.concatenate([right, np.zeros(n)])
        step, free = np.zeros(n), sizes > 0.0
        for _ in range(n):
            if not free.any():
                break
            rest = right - matmul(whole[:, ~free], step[~free])
            step[free] = least_squares(whole[:, free], rest, WEAK)
            ahead = values + step / units
            out = free & ((ahead < problem.low) | (ahead > problem.high))
            if not out.any():
                break
            at_bound = np.clip(ahead, problem.low, problem.high)
            step[out] = ((at_bound - values) * units)[out]
            free &= ~out
        return step / units

    def states(self, step: Floats) -> Floats:
        """Return the steps of the nodes."""
        states = np.zeros(self.factors.shape[:2])
        expand(self.factors, step, states)
        return states

    def taken(self, problem: FitProblem, point: FitPoint, damping: float) -> tuple[Floats, Floats]:
        """Return parameters and nodes after the step."""
        step = self.parameters(problem, point.values, damping)
        values = np.clip(point.values + step, problem.low, problem.high)
        return values, point.shots.nodes + self.states(step)

    def promised(self, problem: FitProblem, point: FitPoint, damping: float) -> float:
        """Return by how much the sum of squares of the linear equations becomes smaller."""
        chain, n_p = self.chain, len(problem.paths)
        step = self.parameters(problem, point.values, damping)
        states = self.states(step)
        segment = np.repeat(np.arange(len(states)), np.diff(chain.first))
        left = chain.right - matmul(chain.rows[:, :n_p], step)
        left -= (chain.rows[:, n_p:] * states[segment]).sum(axis=1)
        ends = chain.defects + matmul(chain.end_rows[:, :, :n_p], step)
        ends += (chain.end_rows[:, :, n_p:] * states[:, None, :]).sum(axis=2)
        ends[:-1] -= states[1:]
        ends = np.where(chain.linked[:, None], ends, 0.0)
        before = (chain.right**2).sum() + ((chain.weights * chain.defects) ** 2).sum()
        after = (left**2).sum() + ((chain.weights * ends) ** 2).sum()
        return float(before - after)
