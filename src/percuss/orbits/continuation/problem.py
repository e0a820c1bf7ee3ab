"""Problems of continuation: equations with one unknown more than there are equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError


class BorderError(PercussError):
    """The equations have other derivatives beyond a border that a step would pass.

    ``is_located`` where the problem knows the point on the border, so that shorter steps tell
    nothing more.
    """

    def __init__(self, what: str, *, is_located: bool) -> None:
        super().__init__(what)
        self.is_located = is_located


class Problem(Protocol):
    """Equations whose solutions are curves of points z, vectors of any length.

    Attributes
    ----------
    noun
        The name of such a curve: "branch" or "curve".
    paths
        Paths of the parameters: the last unknowns, scaled so that their ranges go from 0 to 1.
    order
        Order of the predictor: 1 for the tangent, 2 for a parabola through the last points, which
        pays where the derivatives are expensive, and 3 for a cubic, where all is; between two
        points guesses are cubics then, too.
    cyclic
        The unknowns that are instants, in periods: whole periods apart they are the same.
    n_periods
        Periods of the forces after which a solution repeats.
    """

    noun: str
    paths: tuple[str, ...]
    order: int
    cyclic: slice
    n_periods: int

    def values(self, z: Floats) -> tuple[float, ...]:
        """Return the parameters of a point."""

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        """Return the solution in the plane through a guess with this normal.

        Raises
        ------
        ConvergenceError
            If there is none near.
        ParameterError
            If the parameters cannot have the values.
        BorderError
            If it, or the guess, lies beyond a border of the equations.
        """

    def solution(self, z: Floats) -> Any:
        """Return the orbit of a solution: of one displacement, or of a structure."""

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent, on the side of an earlier one's, and its tests."""

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return a point from which no step was found, with the best tangent there is."""

    def recentre(self, point: Point[Self]) -> None:
        """Make a point the centre of the neighbourhood in which the next are computed."""

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:
        """Return the normal of the hyperplane of Newton's correction of a point a step ahead."""

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the longest step from a point, from the largest that the caller wants."""


P = TypeVar("P", bound=Problem)


@dataclass(frozen=True, slots=True)
class Point(Generic[P]):
    """A solution of a problem.

    Attributes
    ----------
    z
        Unknowns and parameters, scaled.
    tangent
        Of unit length.
    orbit
        The solution itself.
    tests
        Functions that are zero at special points, by their names.
    problem
        The problem that it solves.
    is_response
        Whether it is the one linear response at its parameter: the next is found from any distance.
    """

    z: Floats
    tangent: Floats
    orbit: Any
    tests: Mapping[str, float]
    problem: P
    is_response: bool = False

    @property
    def text(self) -> str:
        """Its parameters in words."""
        pairs = zip(self.problem.paths, self.problem.values(self.z), strict=True)
        return ", ".join(f"{path} = {value:.12g}" for path, value in pairs)


def along_parameter(size: int, k: int = -1) -> Floats:
    """Return the unit vector of one of the parameters: the normal of a plane that fixes it."""
    unit = np.zeros(size)
    unit[k] = 1.0
    return unit
