"""Elimination and singular values in plain loops."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss.kernels.compile import uncompiled
from percuss.kernels.linear import eliminate, orthogonalise


@pytest.mark.parametrize("size", [1, 2, 5, 11])
def test_elimination_solves_what_numpy_solves(size: int) -> None:
    random = np.random.default_rng(size)
    matrix, right = random.normal(size=(size, size)), random.normal(size=size)
    # A zero on the diagonal needs a pivot.
    matrix[0, 0] = 0.0 if size > 1 else 1.0
    expected = np.linalg.solve(matrix, right)

    for solver in (eliminate, uncompiled(eliminate)):
        reduced, solution = matrix.copy(), right.copy()
        sign = solver(reduced, solution, 0.0)
        np.testing.assert_allclose(solution, expected, rtol=1e-11)
        determinant = sign * math.prod(np.diag(reduced).tolist())
        assert determinant == pytest.approx(float(np.linalg.det(matrix)), rel=1e-11)


def test_elimination_refuses_a_singular_matrix() -> None:
    matrix = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [5.0, 7.0, 9.0]])

    assert not eliminate(matrix, np.ones(3), 1e-10)
    assert not eliminate(np.full((2, 2), math.nan), np.ones(2), 0.0)


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (2, 4), (7, 7), (9, 10), (20, 20)])
def test_rows_are_turned_to_right_angles_and_keep_the_matrix(shape: tuple[int, int]) -> None:
    matrix = np.random.default_rng(shape[1]).normal(size=shape)
    matrix[-1] = matrix[0]

    for turner in (orthogonalise, uncompiled(orthogonalise)) if shape[0] < 9 else (orthogonalise,):
        images, rows = np.ascontiguousarray(matrix.T), np.eye(shape[1])
        assert turner(images, rows)
        np.testing.assert_allclose(rows @ rows.T, np.eye(shape[1]), atol=1e-14)
        np.testing.assert_allclose(matrix @ rows.T, images.T, atol=1e-13)
        sizes = np.sort(np.sqrt((images * images).sum(axis=1)))[::-1][: min(shape)]
        np.testing.assert_allclose(sizes, np.linalg.svd(matrix)[1], atol=1e-13)


def test_columns_of_very_different_size_settle() -> None:
    matrix = np.array([[1.0, 1e-9, 1e-30], [1.0, 1e-9, 2e-30], [1.0, -1e-9, 0.0]])
    images, rows = np.ascontiguousarray(matrix.T), np.eye(3)

    assert orthogonalise(images, rows)
