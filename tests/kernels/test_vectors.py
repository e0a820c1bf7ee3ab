"""Vectors of eight doubles: compiled they have the bits of plain arrays."""

from __future__ import annotations

import math

import numpy as np
from tests.kernels.uncompiled import python_of

from percuss.arrays import Floats
from percuss.kernels.compile import kernel
from percuss.kernels.vectors import (
    WIDTH,
    counting,
    eight_at,
    entry_of,
    first_not_positive,
    greatest,
    least,
    magnitude,
    shifted,
)


@kernel
def combine(table: Floats, factor: float, out: Floats) -> int:
    """Write what each function makes of two rows; return the first that is not above zero."""
    a = eight_at(table, 0, 1)
    b = eight_at(table, 2, 0)
    smaller = least(a * factor + b, shifted(factor, a) * b)
    larger = greatest(factor - b, magnitude(a) - counting())
    difference = smaller - larger * b
    for k in range(WIDTH):
        out[0, k] = entry_of(smaller, k)
        out[1, k] = entry_of(larger, k)
        out[2, k] = entry_of(difference, k)
    return first_not_positive(difference, 0)


@kernel
def doubtful(table: Floats, k: int) -> int:
    """Return the first entry from the k-th on that is not above zero."""
    return first_not_positive(eight_at(table, 0, 0), k)


def test_compiled_they_have_the_bits_of_plain_arrays() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        table = rng.standard_normal((3, 11)) * 10.0 ** rng.uniform(-5.0, 5.0, (3, 11))
        one, other = np.empty((3, WIDTH)), np.empty((3, WIDTH))
        factor = float(rng.standard_normal())

        first = combine(table, factor, one)

        assert first == python_of(combine)(table, factor, other)
        np.testing.assert_array_equal(one, other)


def test_what_is_no_number_or_zero_is_not_positive() -> None:
    table = np.array([[1.0, 0.0, -0.0, math.nan, math.inf, -math.inf, 5e-324, -1.0]])

    firsts = [doubtful(table, k) for k in range(WIDTH + 1)]

    assert firsts == [python_of(doubtful)(table, k) for k in range(WIDTH + 1)]
    assert firsts == [1, 1, 2, 3, 5, 5, 7, 7, WIDTH]


def test_the_first_is_found_in_all_patterns() -> None:
    for pattern in range(1 << WIDTH):
        table = np.array([[-1.0 if pattern >> k & 1 else 1.0 for k in range(WIDTH)]])
        for k in range(WIDTH + 1):
            later = [i for i in range(k, WIDTH) if table[0, i] < 0.0]
            assert doubtful(table, k) == (later[0] if later else WIDTH)
