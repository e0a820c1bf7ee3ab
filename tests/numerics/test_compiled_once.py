"""Kernels of linear algebra are compiled once, whatever the order of an array and its flags."""

from __future__ import annotations

from typing import Any

import numpy as np

from percuss.kernels import linear, wide
from percuss.numerics import Wide
from percuss.numerics.linear import determinant, solve_linear


def test_arrays_of_any_order_and_those_that_are_not_written_to_have_one_form() -> None:
    random = np.random.default_rng(0)
    plain = random.standard_normal((4, 4)) + 4 * np.eye(4)
    frozen = plain.copy()
    frozen.flags.writeable = False
    for matrix in (plain, np.asfortranarray(plain), plain[::-1, ::-1], frozen):
        right = matrix @ np.ones(4)
        np.testing.assert_allclose(solve_linear(matrix, right), 1, rtol=1e-12)
        assert determinant(matrix) != 0.0
        both = Wide.of(matrix) @ Wide.of(matrix).T + Wide.of(matrix)
        assert both.shape == (4, 4)
    parts = Wide.of(plain).parts.copy()
    parts.flags.writeable = False
    assert ((Wide(parts) @ Wide(parts)) - Wide(parts)).shape == (4, 4)
    kernels: list[Any] = [linear.eliminate, wide.multiply, wide.add_multiple]
    for compiled in kernels:
        assert len(compiled.signatures) == 1
