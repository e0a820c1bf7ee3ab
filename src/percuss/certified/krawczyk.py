"""Existence and uniqueness of the solution of equations in a box, by Krawczyk's operator.

K = z - Y G(z) + (1 - Y G'(X)) (X - z) for the box X around z, with any matrix Y near the inverse
of the derivative. If K lies inside X, there is exactly one solution in X, and it lies in K.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from flint import arb, arb_mat

from percuss.certified.numbers import span
from percuss.certified.undecided import Undecided

__all__ = ["Solved", "krawczyk", "unique_in"]

Vector: TypeAlias = list[arb]
# Value of the equations at a point, and their derivative on a box.
Value: TypeAlias = Callable[[Vector], arb_mat]

ROUNDS = 6
WIDER = 4


class Solved(NamedTuple):
    """A box that holds exactly one solution, and the larger box in which it is the only one."""

    box: Vector
    trial: Vector


def krawczyk(value: Value, derivative: Value, point: Vector) -> Solved:
    """Return a box around a point that holds exactly one solution.

    Raises
    ------
    Undecided
        If the test fails: the solution is singular, or the box too wide.
    """
    n = len(point)
    inverse = _inverse(derivative(point))
    shift = inverse * value(point)
    trial = [2 * shift[i, 0].abs_upper() for i in range(n)]
    largest = max(trial, key=float)
    # A coordinate that moves by nothing at the point may still move on the box.
    trial = [size.max(largest / 2**20) for size in trial]
    for _ in range(ROUNDS):
        box = [z + span(size) for z, size in zip(point, trial, strict=True)]
        found = _image(inverse, shift, derivative(box), point, trial)
        if all(abs(new - z) < size for new, z, size in zip(found, point, trial, strict=True)):
            return Solved(found, box)
        trial = [WIDER * size for size in trial]
    raise Undecided("precision", "no box was found that the equations map into itself")


def unique_in(derivative: Value, value: Value, point: Vector, sizes: Vector) -> bool:
    """Tell whether the box of these half-widths holds exactly one solution, for certain."""
    try:
        inverse = _inverse(derivative(point))
        shift = inverse * value(point)
        box = [z + span(size) for z, size in zip(point, sizes, strict=True)]
        found = _image(inverse, shift, derivative(box), point, sizes)
    except Undecided:
        return False
    return all(abs(new - z) < size for new, z, size in zip(found, point, sizes, strict=True))


def _inverse(matrix: arb_mat) -> arb_mat:
    try:
        return matrix.mid().inv().mid()
    except ZeroDivisionError:
        raise Undecided("precision", "the equations are singular at the solution") from None


def _image(
    inverse: arb_mat, shift: arb_mat, slopes: arb_mat, point: Vector, trial: Vector
) -> Vector:
    """Return Krawczyk's operator on the box around a point."""
    n = len(point)
    left = arb_mat([[arb(int(i == j)) for j in range(n)] for i in range(n)]) - inverse * slopes
    moved = left * arb_mat([[span(size)] for size in trial])
    return [point[i] - shift[i, 0] + moved[i, 0] for i in range(n)]
