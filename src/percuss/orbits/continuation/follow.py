"""Continuation along branches and curves: predictor, corrector, step length, ends and closure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar, cast

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.exact import real, whole
from percuss.numerics import dot, norm
from percuss.orbits.continuation.problem import BorderError, P, Point, along_parameter
from percuss.orbits.orbit.signature import are_same
from percuss.progress import Progress

S = TypeVar("S")

# Cosines of the angle between tangents: below the first a step is repeated with half its length;
# above the second the next one is longer.
TURNED, STRAIGHT = 0.97, 0.995
LONGER = 1.6
# Part of a step from one curve to another that is tried next.
SHORTER = 0.25
# The corrector may move a predicted point by this part of the step.
ASIDE = 0.5
# A closed curve has more points than this, and its last step passes the start within this part of
# its length.
FEWEST, PASSED = 5, 0.6

# Velocities grow without bound where they exceed the first orbit's by this factor, while the
# parameters all but stand.
LARGE = 1e6

# A parameter that changes by less than this part of a step does not tell a direction.
LEADING = 1e-9

# A test function below this part of its value at a neighbour has a zero there, but for rounding.
ZERO = 1e-6

STOPPED = "stopped by progress"


@dataclass(frozen=True, slots=True)
class StepLimits:
    """The most points each way, and their distances in scaled arclength."""

    max_points: int
    largest: float
    first: float = 1e-3
    least: float = 1e-9

    @classmethod
    def checked(cls, max_points: int, largest_step: float) -> StepLimits:
        """Return steps as a caller wants them, or raise a `ParameterError`."""
        max_points, largest_step = (
            whole("max_points", max_points, 1),
            real("largest_step", largest_step),
        )
        if not 0.0 < largest_step <= 1.0:
            raise ParameterError("largest_step", largest_step, "not above 0 and at most 1")
        return cls(max_points, largest_step)


@dataclass(frozen=True, slots=True)
class Segment(Generic[P, S]):
    """The part of a branch or curve between two neighbours.

    Attributes
    ----------
    rows
        Points with the special points among them, in order.
    end_reason
        Why the second neighbour does not belong to it; "" if it does.
    beyond
        The point, of this or another problem, that continues it then; None if it ends.
    is_astray
        Whether the second neighbour seems to lie on another branch or curve: a shorter step, where
        there is one, stays on this.
    """

    rows: list[tuple[Point[P], S | None]]
    end_reason: str = ""
    beyond: Point[P] | None = None
    is_astray: bool = False


class Detector(Protocol[P, S]):
    """Finds special points and ends of a branch or curve."""

    def between(self, here: Point[P], new: Point[P]) -> Segment[P, S]:
        """Return the part between two neighbours."""

    def stopped(self, here: Point[P], reason: str) -> Segment[P, S]:
        """Return the part beyond the last point, from which no step was found."""


def follow_both_ways(
    start: Point[P],
    direction: float,
    detector: Detector[P, S],
    steps: StepLimits,
    progress: Progress,
) -> tuple[list[tuple[Point[P], S | None]], str]:
    """Follow a branch or curve both ways, as `follow` does, and close the progress.

    ``direction`` has the sign in which the first parameter changes first.

    Returns
    -------
    tuple
        The rows from the end against the direction to the other end, and why they end there.
    """
    parameters = start.tangent[-len(start.problem.paths) :]
    leading = parameters[0] if abs(parameters[0]) > LEADING else parameters[-1]
    sign = math.copysign(1.0, direction) * math.copysign(1.0, leading)
    rows, why, closed = follow(start, sign, detector, steps, progress=progress)
    before: list[tuple[Point[P], S | None]] = []
    if not closed and why != STOPPED:
        before, why_before, closed = follow(start, -sign, detector, steps, progress=progress)
        if closed:
            # It has passed what the first way has found, and what it has not.
            rows, why = [], why_before
        elif before:
            why = f"{why_before}; at the other end {why}"
    progress.close()
    return [*reversed(before), (start, None), *rows], why


def unbounded_growth(new: Point[P], size: float, standing: float) -> str:
    """Return that velocities grow without bound towards a point, "" if they do not.

    ``size`` is their ratio to those of the first orbit; the parameters make up less than the part
    ``standing`` of a step there.
    """
    moved = norm(new.tangent[-len(new.problem.paths) :])
    grows = size > LARGE and moved < standing
    return f"the velocities grow without bound towards {new.text}" if grows else ""


def hides_zeros(here: Point[P], new: Point[P], rows: Sequence[tuple[Point[P], S | None]]) -> bool:
    """Return whether a test has one sign at two neighbours, and the other at a point between them.

    Then two of its zeros, or more, lie within the step.
    """
    for point, _ in rows:
        for name, value in point.tests.items():
            one, other = here.tests.get(name, math.nan), new.tests.get(name, math.nan)
            is_between = np.sign(one) == np.sign(other) == -np.sign(value) != 0.0
            if is_between and abs(value) > ZERO * max(abs(one), abs(other)):
                return True
    return False


def special_points_of(rows: Sequence[tuple[Point[P], S | None]]) -> tuple[S, ...]:
    """Return the special points among rows, each with the number of its row."""
    return tuple(
        dataclasses.replace(cast("Any", special), row=row)
        for row, (_, special) in enumerate(rows)
        if special is not None
    )


def follow(
    start: Point[P],
    sign: float,
    detector: Detector[P, S],
    steps: StepLimits,
    *,
    until: Callable[[S], bool] | None = None,
    progress: Progress | None = None,
) -> tuple[list[tuple[Point[P], S | None]], str, bool]:
    """Follow a branch or curve from a point along its tangent, or against it.

    Pseudo-arclength continuation (Keller 1977): a step along the tangent, or the cubic through the
    last two points, Newton's method in a plane across it, and steps as long as the tangent turns
    little.

    Parameters
    ----------
    start
        The first point.
    sign
        1.0 along its tangent, -1.0 against it.
    detector
        Finds special points between neighbours, and where the walk ends.
    steps
        Their length and number.
    until
        A condition on special points that ends the walk; the point is in the last row.
    progress
        Counts the points, and may end the walk.

    Returns
    -------
    tuple
        The rows after the start, why they end, and whether they close.
    """
    rows: list[tuple[Point[P], S | None]] = []
    here = dataclasses.replace(start, tangent=sign * start.tangent)
    curve, step = _straight(here), min(steps.first, steps.largest)
    while len(rows) < steps.max_points:
        end = _edge(here)
        if end:
            return rows, end, False
        here.problem.recentre(here)
        new, step, why = _step(here, curve, step, steps)
        segment = detector.stopped(here, why) if new is None else detector.between(here, new)
        if new is not None and segment.is_astray:
            shorter = SHORTER * min(step, norm(new.z - here.z))
            if shorter > steps.least:
                step = shorter
                continue
        for row in segment.rows:
            rows.append(row)
            if until is not None and row[1] is not None and until(row[1]):
                return rows, "", False
        if segment.beyond is None and (new is None or segment.end_reason):
            return rows, segment.end_reason, False
        if new is None or segment.beyond is not None:
            here = segment.beyond or here
            curve, step = _straight(here), min(steps.first, steps.largest)
            continue
        rows.append((new, None))
        if len(rows) > FEWEST and _is_back(start, new, sign, here):
            return rows, f"the {new.problem.noun} closed", True
        if new.problem.order > 1:
            curve = _curve(here, new)
        here = new
        path, value = here.problem.paths[0], here.problem.values(here.z)[0]
        if progress is not None and not progress.advance(text=f"{path} = {value:.6g}"):
            return rows, STOPPED, False
    return rows, f"max_points = {steps.max_points} reached", False


def _edge(here: Point[P]) -> str:
    """Return which end of a parameter's range is reached, "" if none is."""
    problem = here.problem
    for k, path in enumerate(problem.paths, start=-len(problem.paths)):
        part, outwards = here.z[k], here.tangent[k]
        if (part <= 0.0 and outwards < 0.0) or (part >= 1.0 and outwards > 0.0):
            return f"{path} = {problem.values(here.z)[k]:.12g} reached"
    return ""


def _straight(here: Point[P]) -> tuple[Floats, Floats]:
    """Return no second and third derivatives by arclength."""
    return np.zeros(len(here.z)), np.zeros(len(here.z))


def _curve(before: Point[P], here: Point[P]) -> tuple[Floats, Floats]:
    """Return the second and third derivatives that the last two points with their tangents tell.

    Of the parabola, or of the cubic.
    """
    chord = here.z - before.z
    length = norm(chord)
    turn = (here.tangent - before.tangent) / length
    if here.problem.order == 2:
        return turn, np.zeros(len(chord))
    rest = (here.tangent - chord / length) / length
    return 6.0 * rest - 2.0 * turn, (12.0 * rest - 6.0 * turn) / length


def _step(
    here: Point[P], curve: tuple[Floats, Floats], step: float, steps: StepLimits
) -> tuple[Point[P] | None, float, str]:
    """Return the next point and the step to try after it, or why there is none."""
    why, invalid = "", False
    problem = here.problem
    step = min(step, problem.longest_step(here, steps.largest))
    while step > steps.least:
        try:
            new = _tried(here, curve, step)
        except BorderError as border:
            new, why, invalid = None, str(border), False
            if border.is_located:
                return None, step, why
        except PercussError as error:
            new, why, invalid = None, str(error), isinstance(error, ParameterError)
        if new is not None:
            if here.is_response and not new.is_response:
                step = norm(new.z - here.z)
            straight = here.is_response or dot(here.tangent, new.tangent) > STRAIGHT
            return new, step * LONGER if straight else step, ""
        here = problem.refined(here)
        step *= 0.5
    if invalid:
        return None, step, f"beyond {here.text} there is no such system: {why}"
    why = why or f"the {problem.noun} bends"
    return None, step, f"no step of {steps.least:g} beyond {here.text}: {why}"


def _tried(here: Point[P], curve: tuple[Floats, Floats], step: float) -> Point[P] | None:
    """Return the point a step away, None if the step is too long."""
    problem, n = here.problem, len(here.problem.paths)
    if here.is_response:
        new = _next_response(here, step)
        if new is not None:
            return new
        # Beyond a graze the branch may turn back at once: as far, in arclength.
        step = min(step / max(abs(float(here.tangent[-1])), step), 1.0)
    guess = here.z + step * here.tangent
    guess = guess + (0.5 * step * step) * (curve[0] + (step / 3.0) * curve[1])
    normal = problem.corrector_normal(here.tangent, step)
    for k in range(-n, 0):
        edge = 0.0 if guess[k] < 0.0 else 1.0
        if 0.0 <= guess[k] <= 1.0 or here.tangent[k] == 0.0:
            continue
        shorter = (edge - here.z[k]) / here.tangent[k]
        if 0.0 < shorter < 2.0 * step:
            guess = here.z + shorter * here.tangent
            guess[k] = edge
            normal = along_parameter(len(guess), k)
    z = problem.corrected(guess, normal)
    outside = (np.abs(z[-n:] - 0.5) > 0.5).any()
    if outside or norm(z - guess) > ASIDE * step:
        return None
    new = problem.point(z, here)
    return new if dot(here.tangent, new.tangent) > TURNED else None


def _next_response(here: Point[P], step: float) -> Point[P] | None:
    """Return the response at a parameter that is a step on, None where there is none."""
    guess, onwards = here.z.copy(), math.copysign(step, here.tangent[-1])
    guess[-1] = min(max(float(guess[-1]) + onwards, 0.0), 1.0)
    try:
        z = here.problem.corrected(guess, along_parameter(len(guess)))
    except ConvergenceError:
        return None
    new = here.problem.point(z, here)
    return new if new.is_response else None


def _is_back(start: Point[P], new: Point[P], sign: float, before: Point[P]) -> bool:
    """Return whether the last step passed the start, whole periods of the forces apart."""
    return (new.problem is start.problem and _is_at_start(start, new, sign, before)) or (
        (new.problem is not start.problem or new.problem.n_periods > 1)
        and _is_back_at_its_value(start, new, before)
    )


def _is_at_start(start: Point[P], new: Point[P], sign: float, before: Point[P]) -> bool:
    """Return whether the last step passed the start, whole periods of the orbit apart."""
    difference = start.z - new.z
    cyclic = new.problem.cyclic
    difference[cyclic] -= np.round(difference[cyclic])
    step = norm(new.z - before.z)
    along = sign * dot(start.tangent, new.tangent) > TURNED
    return along and norm(difference) < PASSED * step


def _is_back_at_its_value(start: Point[P], new: Point[P], before: Point[P]) -> bool:
    """Return whether the last step passed the orbit of the start, where it may be another point.

    The unknowns are others after other problems have taken over, and where the orbit, of several
    periods of the forces, is given from another of them on.
    """
    value, last, now = start.z[-1], before.z[-1], new.z[-1]
    if (last - value) * (now - value) > 0.0 or last == now or len(new.z) != len(start.z):
        return False
    guess = before.z + (value - last) / (now - last) * (new.z - before.z)
    try:
        z = new.problem.corrected(guess, along_parameter(len(guess)))
        return are_same(new.problem.solution(z), start.orbit)
    except PercussError:
        return False
