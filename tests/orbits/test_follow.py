"""The walk along curves and the search for zeros on them, on equations with known solutions."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pytest
from numpy.linalg import solve

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.orbits.continuation.correct import Broyden, corrected
from percuss.orbits.continuation.follow import (
    STOPPED,
    Segment,
    StepLimits,
    follow,
    follow_both_ways,
)
from percuss.orbits.continuation.locate import locate
from percuss.orbits.continuation.problem import Point
from percuss.progress import Progress

STEPS = StepLimits(max_points=500, largest=0.05)


@dataclass(eq=False)
class Circle:
    """abs(u)^2 + (p - 1/2)^2 = radius^2 with u along a line in a space of some dimensions.

    The parameter p turns round at 1/2 +- radius.
    """

    radius: float
    dimension: int = 1
    # No solution is found beyond this value of the parameter.
    wall: float = math.inf
    noun: str = "circle"
    paths: tuple[str, ...] = ("p",)
    order: int = 1
    n_periods: int = 1
    cyclic = slice(0, 0)

    def values(self, z: Floats) -> tuple[float, ...]:
        return (float(z[-1]),)

    def residual(self, z: Floats) -> Floats:
        """Return the equations: all but the first direction of u have no part."""
        return np.append(z @ z - z[-1] + 0.25 - self.radius**2, z[1:-1])

    def slope(self, z: Floats) -> Floats:
        found = np.zeros((self.dimension, self.dimension + 1))
        found[0] = 2.0 * z
        found[0, -1] -= 1.0
        found[1:, 1:-1] = np.eye(self.dimension - 1)
        return found

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        del near_others
        z = guess.copy()
        for _ in range(20):
            step = solve(
                np.vstack([self.slope(z), normal]),
                -np.append(self.residual(z), normal @ (z - guess)),
            )
            z += step
            if np.abs(step).max() < 1e-14:
                break
        else:
            raise ConvergenceError("no point near", None, math.nan, "a shorter step")
        if z[-1] > self.wall:
            raise ParameterError("p", float(z[-1]), "beyond the wall")
        return z

    def solution(self, z: Floats) -> Any:
        return z

    def point(self, z: Floats, before: Point[Any]) -> Point[Circle]:
        return self.at(z, before.tangent)

    def at(self, z: Floats, along: Floats) -> Point[Circle]:
        tangent = solve(np.vstack([self.slope(z), along]), np.append(np.zeros(self.dimension), 1.0))
        tangent /= np.linalg.norm(tangent)
        return Point(z, tangent, cast("Any", z), {"fold": float(z[0])}, self)

    def start(self) -> Point[Circle]:
        """Return the point at p = 1/2 where u is largest."""
        z = np.zeros(self.dimension + 1)
        z[0], z[-1] = self.radius, 0.5
        up = np.zeros_like(z)
        up[-1] = 1.0
        return self.at(z, up)

    def refined(self, point: Point[Any]) -> Point[Circle]:
        return point

    def recentre(self, point: Point[Any]) -> None:
        pass

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:  # noqa: ARG002
        return tangent

    def longest_step(self, point: Point[Any], largest: float) -> float:
        del point
        return largest


class Folds:
    """Finds where the parameter turns round."""

    def between(self, here: Point[Circle], new: Point[Circle]) -> Segment[Circle, str]:
        values = here.tests["fold"], new.tests["fold"]
        if values[0] * values[1] > 0.0:
            return Segment([])
        zero = locate(here, new, lambda z: float(z[0]), values)
        assert zero is not None
        assert zero.goes_through
        return Segment([(new.problem.at(zero.z, here.tangent), "fold")])

    def stopped(self, here: Point[Circle], reason: str) -> Segment[Circle, str]:
        return Segment([(here, "end")], reason)


@pytest.mark.parametrize("dimension", [1, 2, 5])
def test_a_closed_curve_is_followed_round_its_folds_until_it_closes(dimension: int) -> None:
    circle = Circle(0.4, dimension)

    rows, why, closed = follow(circle.start(), 1.0, Folds(), STEPS)

    assert closed
    assert why == "the circle closed"
    assert max(np.abs(circle.residual(point.z)).max() for point, _ in rows) < 1e-14
    folds = [float(point.z[-1]) for point, special in rows if special]
    np.testing.assert_allclose(folds, [0.9, 0.1], atol=1e-12)
    # Neighbours are a step apart, and the last is beside the start.
    points = np.array([circle.start().z, *(point.z for point, special in rows if not special)])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    # The corrector moves a predicted point by half a step at most, across it.
    assert 0.0 < steps.min() <= steps.max() <= math.hypot(1.0, 0.5) * STEPS.largest
    assert steps.sum() == pytest.approx(2.0 * math.pi * circle.radius, rel=0.05)
    assert np.linalg.norm(rows[-1][0].z - circle.start().z) < 0.05


class Wave(Circle):
    """p = 1/2 + 1/5 sin(2 pi u): the same again where u has grown by 1."""

    def residual(self, z: Floats) -> Floats:
        return np.array([z[1] - 0.5 - 0.2 * math.sin(2.0 * math.pi * z[0])])

    def slope(self, z: Floats) -> Floats:
        return np.array([[-0.4 * math.pi * math.cos(2.0 * math.pi * z[0]), 1.0]])

    def start(self) -> Point[Circle]:
        u = 0.125
        return self.at(np.array([u, 0.5 + 0.2 * math.sin(2.0 * math.pi * u)]), np.array([0.0, 1.0]))


@pytest.mark.parametrize("is_instant", [False, True])
def test_only_instants_are_the_same_whole_periods_later(is_instant: bool) -> None:
    wave = Wave(0.2)
    wave.cyclic = slice(0, int(is_instant))

    rows, _, closed = follow(wave.start(), 1.0, Folds(), dataclasses.replace(STEPS, max_points=100))

    assert closed == is_instant
    assert (rows[-1][0].z[0] > 1.5) == (not is_instant)


def test_both_ways_end_at_the_ends_of_the_range() -> None:
    circle = Circle(0.6)

    rows, why = follow_both_ways(circle.start(), 1.0, Folds(), STEPS, Progress(None, 100.0))

    assert why == "p = 0 reached; at the other end p = 1 reached"
    values = [float(point.z[-1]) for point, _ in rows]
    assert [values[0], values[-1]] == [0.0, 1.0]
    assert (np.diff(values) > 0.0).all()


def test_the_end_tells_why_no_step_leads_on() -> None:
    rows, why, closed = follow(Circle(0.4, wall=0.7).start(), 1.0, Folds(), STEPS)

    assert not closed
    assert re.fullmatch(
        r"beyond p = 0.69999\d* there is no such system: p = 0.7\d*: beyond the wall", why
    )
    assert rows[-1][1] == "end"
    assert rows[-1][0].z[-1] == pytest.approx(0.7, abs=1e-8)


def test_a_walk_can_be_ended_at_something_special_by_the_caller_and_by_number() -> None:
    start = Circle(0.4).start()

    rows, _, _ = follow(start, -1.0, Folds(), STEPS, until=lambda special: special == "fold")
    assert rows[-1][1] == "fold"
    assert rows[-1][0].z[-1] == pytest.approx(0.1, abs=1e-12)

    rows, why, _ = follow(start, 1.0, Folds(), dataclasses.replace(STEPS, max_points=7))
    assert (len(rows), why) == (7, "max_points = 7 reached")

    progress = Progress(lambda done, _total: done < 3, 500.0)
    rows, why, _ = follow(start, 1.0, Folds(), STEPS, progress=progress)
    assert (len(rows), why) == (3, STOPPED)


def test_a_jump_is_told_from_a_zero_that_the_function_goes_through() -> None:
    circle = Circle(0.4)
    here = circle.start()
    there = circle.at(circle.corrected(here.z + 0.1 * here.tangent, here.tangent), here.tangent)

    def smooth(z: Floats) -> float:
        return float(z[-1]) - 0.55

    def jump(z: Floats) -> float:
        return math.copysign(1.0, smooth(z))

    for test, goes_through in ((smooth, True), (jump, False)):
        zero = locate(here, there, test, (test(here.z), test(there.z)))

        assert zero is not None
        assert zero.goes_through is goes_through
        assert zero.z[-1] == pytest.approx(0.55, abs=1e-11)
        assert abs(circle.residual(zero.z)[0]) < 1e-14


def test_residuals_that_overflow_end_the_correction_without_warnings() -> None:
    """Broyden's update multiplied infinity by 0."""
    equations = Broyden(lambda z: np.array([z[0] - 1.0 if z[0] < 0.5 else np.inf]), np.eye(1, 2))

    _, _, is_solved = corrected(equations, np.zeros(2), np.array([0.0, 1.0]), steps=5, enough=1e-13)

    assert not is_solved
