"""The elimination of nodes against one dense least-squares problem, in exact arithmetic's place."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from tests.kernels.uncompiled import python_of

from percuss.arrays import Floats
from percuss.kernels.condense import Chain, condense, expand, reflect

N_P = 3


def chain(seed: int, *, growth: float = 1.0) -> Chain:
    """Return equations of five segments, the third and fourth of two records that do not touch."""
    random = np.random.default_rng(seed)
    counts = [4, 0, 6, 3, 5]
    ends = random.standard_normal((5, 2, N_P + 2))
    ends[:, :, N_P:] *= growth
    return Chain(
        random.standard_normal((18, N_P + 2)),
        random.standard_normal(18),
        np.concatenate([[0], np.cumsum(counts)]),
        ends,
        random.standard_normal((5, 2)),
        np.array([True, True, False, True, False]),
        np.full((5, 2), 50.0),
        np.full(2, 1e-3),
    )


def dense(some: Chain) -> tuple[Floats, Floats]:
    """Return the same equations as one matrix, the parameters last."""
    rows, right = [], []

    def add(k: int, row: Floats, value: float, following: int = -1) -> None:
        whole = np.zeros(10 + N_P)
        whole[10:], whole[2 * k : 2 * k + 2] = row[:N_P], row[N_P:]
        if following >= 0:
            whole[following] -= 50.0
        rows.append(whole)
        right.append(value)

    for k in range(5):
        for i in range(some.first[k], some.first[k + 1]):
            add(k, some.rows[i], some.right[i])
        for j in range(2):
            anchor = np.zeros(N_P + 2)
            anchor[N_P + j] = 1e-3
            add(k, anchor, 0.0)
            if some.linked[k]:
                add(k, 50 * some.end_rows[k, j], -50 * some.defects[k, j], 2 * k + 2 + j)
    return np.array(rows), np.array(right)


def solved(some: Chain, *, plain: bool = False) -> tuple[Floats, Floats]:
    """Return parameters and nodes by elimination."""
    factors, carried = np.zeros((5, 2, 5 + N_P)), np.zeros((2 + N_P, 3 + N_P))
    run = python_of(condense) if plain else condense
    run(some, factors, carried, np.zeros((20, 5 + N_P)))
    step: Floats = np.linalg.lstsq(carried[:, 2:-1], carried[:, -1])[0].astype(np.float64)
    states = np.empty((5, 2))
    (python_of(expand) if plain else expand)(factors, step, states)
    return step, states


@pytest.mark.parametrize("plain", [False, True])
def test_elimination_is_the_least_squares_of_all_equations(plain: bool) -> None:
    some = chain(0)
    matrix, right = dense(some)
    wanted = np.linalg.lstsq(matrix, right)[0]
    step, states = solved(some, plain=plain)
    np.testing.assert_allclose(step, wanted[10:], rtol=1e-9)
    np.testing.assert_allclose(states.ravel(), wanted[:10], rtol=1e-9, atol=1e-12)


def test_links_that_spread_over_decades_lose_no_digits() -> None:
    """Against normal equations in rational numbers, which lose nothing."""
    some = chain(1, growth=1e4)
    matrix, right = dense(some)
    a = [[Fraction(x) for x in row] for row in matrix.tolist()]
    b = [Fraction(x) for x in right.tolist()]
    n = len(a[0])
    zero = Fraction(0)
    normal = [[sum((r[i] * r[j] for r in a), zero) for j in range(n)] for i in range(n)]
    rights = [sum((r[i] * y for r, y in zip(a, b, strict=True)), zero) for i in range(n)]
    for k in range(n):
        for i in range(k + 1, n):
            ratio = normal[i][k] / normal[k][k]
            normal[i] = [x - ratio * y for x, y in zip(normal[i], normal[k], strict=True)]
            rights[i] -= ratio * rights[k]
    wanted = [zero] * n
    for k in reversed(range(n)):
        known = sum((normal[k][j] * wanted[j] for j in range(k + 1, n)), zero)
        wanted[k] = (rights[k] - known) / normal[k][k]
    step, _ = solved(some)
    np.testing.assert_allclose(step, [float(x) for x in wanted[10:]], rtol=1e-9)


def test_reflections_keep_sums_of_squares_and_skip_empty_columns() -> None:
    random = np.random.default_rng(2)
    matrix = random.standard_normal((6, 4))
    matrix[:, 1] = 0.0
    before = matrix.T @ matrix
    reflect(matrix, 6, 3)
    np.testing.assert_allclose(matrix.T @ matrix, before, atol=1e-12)
    assert (matrix[1:, 0] == 0).all()
    assert (matrix[3:, 2] == 0).all()
