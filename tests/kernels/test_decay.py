"""The exponential of a decay against mpmath."""

from __future__ import annotations

import mpmath
import numpy as np
from tests.kernels.uncompiled import python_of

from percuss.kernels.arithmetic import decay

ULP = 2.0**-52


def test_both_values_are_right_to_a_few_roundings() -> None:
    rng = np.random.default_rng(2)
    points = [0.0, -5e-324, -1e-300, -1e-17, -0.34657359027997264, -0.34657359027997270, -700.0]
    points += [*-(10.0 ** rng.uniform(-20.0, 2.8, 2000)), *-rng.uniform(0.0, 3.0, 2000)]
    with mpmath.workdps(40):
        for x in points:
            whole, less = python_of(decay)(float(x))
            exact = mpmath.exp(mpmath.mpf(x))
            assert abs(whole - exact) <= 2.0 * ULP * exact, x
            exact = mpmath.expm1(mpmath.mpf(x))
            assert abs(less - exact) <= 2.0 * ULP * abs(exact), x


def test_no_decay_at_all_is_exact() -> None:
    assert python_of(decay)(0.0) == (1.0, 0.0)


def test_far_below_all_is_gone() -> None:
    whole, less = python_of(decay)(-1e9)
    assert 0.0 <= whole < 1e-300
    assert less == -1.0


def test_compiled_it_has_the_same_bits() -> None:
    for x in (-0.0, -1e-9, -0.3, -1.0, -17.5, -699.0):
        assert decay(x) == python_of(decay)(x)
