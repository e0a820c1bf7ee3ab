"""Matrices with twice the digits of a double, against fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from tests.kernels.uncompiled import python_of

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels import wide as kernels
from percuss.numerics import Wide

SMALL = 2.0**-96


def exact(matrix: Wide) -> list[list[Fraction]]:
    return [[Fraction(high) + Fraction(low) for high, low in row] for row in matrix.parts.tolist()]


def drawn(rng: np.random.Generator, n: int, m: int) -> Wide:
    """Return numbers of 100 digits in base two."""
    return Wide.of(rng.uniform(-1, 1, (n, m))) + 2.0**-53 * Wide.of(rng.uniform(-1, 1, (n, m)))


def size(matrix: Wide) -> float:
    return float(max(abs(entry) for row in exact(matrix) for entry in row))


def test_sums_and_products_are_those_of_fractions() -> None:
    rng = np.random.default_rng(5)
    a, b = drawn(rng, 3, 4), drawn(rng, 4, 2)
    third = Wide.of([[Fraction(1, 3)]])

    product, multiple = exact(a @ b), exact(third * a)

    for i in range(3):
        for j in range(2):
            total = sum(exact(a)[i][k] * exact(b)[k][j] for k in range(4))
            assert abs(product[i][j] - total) < SMALL
        assert abs(multiple[i][0] - exact(a)[i][0] / 3) < SMALL
    assert size((a + a) - 2.0 * a) == 0.0


@pytest.mark.parametrize("n", [1, 4, 9])
def test_solutions_factors_and_modes_give_the_matrix_back(n: int) -> None:
    rng = np.random.default_rng(n)
    a = drawn(rng, n, n)
    square = a @ a.T
    lower = square.cholesky()
    values, rows = square.symmetric_modes()

    assert size(a @ a.solve(Wide.unit(n)) - Wide.unit(n)) < 1e4 * SMALL
    assert size(lower @ lower.T - square) < 1e2 * SMALL
    assert size(rows @ rows.T - Wide.unit(n)) < 1e2 * SMALL
    diagonal = Wide.zeros(n, n)
    diagonal[np.arange(n), np.arange(n)] = values[:, 0]
    assert size(rows.T @ diagonal @ rows - square) < 1e3 * SMALL
    assert (np.diff(values.rounded[:, 0]) >= 0.0).all()


def test_an_eigenvalue_beside_one_of_1e16_keeps_its_digits() -> None:
    """The product of the two is the determinant, 3 * 1e16 - 1."""
    values, _ = Wide.of(
        [[Fraction(10**16), Fraction(1)], [Fraction(1), Fraction(3)]]
    ).symmetric_modes()

    low, high = (sum(map(Fraction, number), Fraction(0)) for number in values.parts[:, 0].tolist())
    assert abs(float(low * high / (3 * 10**16 - 1) - 1)) < 1e-29
    assert abs(float((low + high) / (10**16 + 3) - 1)) < 1e-29


def test_a_singular_matrix_and_one_that_is_not_positive_are_told() -> None:
    singular: Floats = np.array([[1.0, 2.0], [2.0, 4.0]])
    with pytest.raises(ConvergenceError, match="the 2 linear equations are singular"):
        Wide.of(singular).inverse()
    with pytest.raises(ConvergenceError, match="not positive definite"):
        Wide.of(singular - np.eye(2)).cholesky()


def test_kernels_do_in_python_what_they_do_compiled() -> None:
    rng = np.random.default_rng(8)
    a = drawn(rng, 3, 3)
    compiled, plain = np.empty((3, 3, 2)), np.empty((3, 3, 2))
    kernels.multiply(a.parts, a.parts, compiled)
    python_of(kernels.multiply)(a.parts, a.parts, plain)
    np.testing.assert_array_equal(compiled, plain)

    square = np.ascontiguousarray((a @ a.T).parts)
    for kernel in (kernels.factorise, kernels.diagonalise):
        results = []
        for call in (kernel, python_of(kernel)):
            matrix, out = square.copy(), Wide.unit(3).parts.copy()
            assert call(matrix, out)
            results.append((matrix, out))
        np.testing.assert_array_equal(results[0], results[1])
