"""Linear algebra without LAPACK: the same answers, and an error for what is no matrix of numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.numerics import (
    determinant,
    directions,
    dot,
    inverse,
    least_squares,
    leverages,
    matmul,
    norm,
    solve_linear,
)

RANDOM = np.random.default_rng(11)
SQUARE, RIGHT = RANDOM.normal(size=(6, 6)), RANDOM.normal(size=6)


def test_answers_are_those_of_lapack_to_rounding() -> None:
    np.testing.assert_allclose(solve_linear(SQUARE, RIGHT), np.linalg.solve(SQUARE, RIGHT))
    np.testing.assert_allclose(inverse(SQUARE), np.linalg.inv(SQUARE))
    np.testing.assert_allclose(matmul(SQUARE, SQUARE), SQUARE @ SQUARE)
    np.testing.assert_allclose(matmul(SQUARE, RIGHT), SQUARE @ RIGHT)
    assert determinant(SQUARE) == pytest.approx(float(np.linalg.det(SQUARE)))
    assert dot(RIGHT, RIGHT) == pytest.approx(norm(RIGHT) ** 2)


def test_weak_directions_are_left_out_of_least_squares() -> None:
    matrix = SQUARE.copy()
    matrix[-1] = matrix[0] + 1e-13 * matrix[1]

    solution = least_squares(matrix, RIGHT, 1e-10)

    np.testing.assert_allclose(solution, np.linalg.lstsq(matrix, RIGHT, rcond=1e-10)[0], rtol=1e-8)


def test_leverages_are_the_diagonal_of_the_projection_whatever_the_sizes_of_columns() -> None:
    matrix = RANDOM.normal(size=(9, 4)) * [1.0, 1e-9, 1e7, 1.0]
    matrix[:, 3] = 0.0
    own = matrix[:, :3]
    hat = own @ np.linalg.solve(own.T @ own, own.T)
    np.testing.assert_allclose(leverages(matrix, 1e-12), np.diag(hat), rtol=1e-4)
    assert leverages(matrix, 1e-12).sum() == pytest.approx(3)


@pytest.mark.parametrize("size", [1e-300, 1e300])
def test_sizes_near_both_ends_of_the_doubles_lose_nothing(size: float) -> None:
    matrix = size * np.array([[3.0, 0.0], [4.0, 1.0]])

    np.testing.assert_allclose(directions(matrix)[0] / size, directions(matrix / size)[0])
    np.testing.assert_allclose(
        least_squares(matrix, np.array([3.0, 4.0]), 1e-12) * size, [1.0, 0.0], atol=1e-15
    )
    assert norm(matrix[:, 0]) == pytest.approx(5.0 * size)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_entries_that_are_no_finite_numbers_are_refused_in_a_sentence(bad: float) -> None:
    matrix = SQUARE.copy()
    matrix[2, 3] = bad

    for call in (
        lambda: solve_linear(matrix, RIGHT),
        lambda: inverse(matrix),
        lambda: directions(matrix),
        lambda: least_squares(matrix, RIGHT, 1e-10),
        lambda: least_squares(SQUARE, bad * RIGHT, 1e-10),
    ):
        with pytest.raises(pc.ConvergenceError, match="no finite numbers"):
            call()
    assert math.isnan(determinant(matrix))


def test_singular_equations_are_refused_in_a_sentence() -> None:
    with pytest.raises(pc.ConvergenceError, match="the 2 linear equations are singular"):
        solve_linear(np.ones((2, 2)), np.ones(2))
