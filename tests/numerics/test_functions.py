"""Elementary functions of numbers and arrays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import numerics

ONE = ["exp", "expm1", "log", "cos", "sin", "tan"]
X = np.linspace(0.1, 7.0, 60).reshape(3, 4, 5)


@pytest.mark.parametrize("name", ONE)
def test_numbers_small_and_large_arrays_have_the_same_bits(name: str) -> None:
    function = getattr(numerics, name)
    whole = function(X)

    assert whole.shape == X.shape
    np.testing.assert_array_equal(function(X[:, 0, 0]), whole[:, 0, 0])
    assert [function(x) for x in X.ravel().tolist()] == whole.ravel().tolist()
    np.testing.assert_allclose(whole, getattr(np, name)(X), rtol=4e-16)


def test_two_arguments_are_broadcast() -> None:
    y, x = X[0, 0], X[0, :, :1]

    np.testing.assert_allclose(numerics.atan2(y, x), np.arctan2(y, x), rtol=4e-16)
    np.testing.assert_allclose(numerics.hypot(y, x), np.hypot(y, x), rtol=4e-16)
    assert numerics.hypot(3.0, 4) == 5.0


def test_numbers_give_floats_and_arrays_without_shape_numpy_numbers() -> None:
    assert type(numerics.sin(1)) is float
    assert type(numerics.sin(np.float64(1.0))) is float
    assert isinstance(numerics.sin(np.array(1.0)), np.float64)


def test_phasors_and_powers() -> None:
    np.testing.assert_allclose(numerics.phasor(X), np.exp(1j * X), rtol=1e-15)
    np.testing.assert_allclose(numerics.power(2.0, X), 2.0**X, rtol=1e-14)
    computed = numerics.geometric(1e-3, 7.0, 9)
    np.testing.assert_allclose(computed, np.geomspace(1e-3, 7.0, 9), rtol=1e-14)
    assert (computed[0], computed[-1]) == (1e-3, 7.0)
    assert math.isclose(numerics.power(10.0, -3.0), 1e-3, rel_tol=1e-14)
