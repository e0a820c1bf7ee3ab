"""Elementary functions against mpmath, over all doubles."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numba
import numpy as np
import pytest

from percuss.arrays import Floats
from percuss.kernels import arithmetic
from percuss.kernels.compile import kernel, uncompiled
from percuss.kernels.parts import has_fused_products, is_portable

SIDES = [5e-324, 2.2250738585072014e-308, 1e-300, 1e-17, 0.5, 1.0, 2.0, 1e17, 1e300]
ENDS = [709.782712893384, 709.7827128933841, -708.4, -745.1332191019411, -745.1332191019412]


def evaluated(which: int, x: Floats, y: Floats | None = None) -> Floats:
    out = np.empty_like(x)
    arithmetic.evaluate(which, x, x if y is None else y, out)
    return out


def worst(computed: Floats, exact: Callable[[int], mpmath.mpf]) -> float:
    """Return the largest error, in units in the last place of the exact value."""
    errors = [0.0]
    with mpmath.workprec(300):
        for i, value in enumerate(computed.tolist()):
            right = exact(i)
            nearest = float(right)
            if right == 0 or math.isinf(nearest):
                assert value == nearest
                continue
            errors.append(float(abs(mpmath.mpf(value) - right)) / math.ulp(nearest))
    return max(errors)


def spread(seed: int, low: float, high: float, n: int = 400) -> Floats:
    """Return numbers of both signs, even in their logarithm."""
    random = np.random.default_rng(seed)
    return np.asarray(random.choice([-1.0, 1.0], n) * 10.0 ** random.uniform(low, high, n))


def test_exponentials_are_right_to_one_unit_up_to_both_ends() -> None:
    random = np.random.default_rng(1)
    parts = [spread(2, -300, 2.85), random.uniform(-2, 2, 400), random.uniform(-745, 709, 400)]
    x = np.concatenate([*parts, ENDS, [0.0, 5e-324, -5e-324]])

    whole = evaluated(arithmetic.EXPONENTIAL, x)
    less = evaluated(arithmetic.EXPONENTIAL_LESS_ONE, x)

    assert worst(whole, lambda i: mpmath.exp(mpmath.mpf(float(x[i])))) < 1.0
    assert worst(less, lambda i: mpmath.expm1(mpmath.mpf(float(x[i])))) < 1.0


def test_the_logarithm_is_right_to_one_unit_for_all_positive_doubles() -> None:
    random = np.random.default_rng(3)
    near_one = 1.0 + spread(4, -16, -1)
    x = np.concatenate([np.abs(spread(5, -323, 308)), near_one, random.uniform(0.4, 3, 400), SIDES])

    computed = evaluated(arithmetic.LOGARITHM, x)

    assert worst(computed, lambda i: mpmath.log(mpmath.mpf(float(x[i])))) < 1.0


def test_cosine_and_sine_are_right_to_one_unit_up_to_huge_angles() -> None:
    quarters = np.arange(-40.0, 40.0) * (0.5 * math.pi)
    # The last is the double next to a multiple of pi/2 among all.
    hard = [1e5 * math.pi, 1220995254068917.5, 6381956970095103.0 * 2.0**-3, *SIDES[:-2]]
    x = np.concatenate([spread(6, -300, 15.3), spread(7, -3, 3), quarters, hard])

    cosine, sine = (evaluated(which, x) for which in (arithmetic.COSINE, arithmetic.SINE))

    assert worst(cosine, lambda i: mpmath.cos(mpmath.mpf(float(x[i])))) < 1.0
    assert worst(sine, lambda i: mpmath.sin(mpmath.mpf(float(x[i])))) < 1.0
    tangent = evaluated(arithmetic.TANGENT, x)
    assert worst(tangent, lambda i: mpmath.tan(mpmath.mpf(float(x[i])))) < 2.5


def test_angles_and_lengths_are_right_to_two_units_over_all_ratios() -> None:
    y = np.concatenate([spread(8, -150, 150), spread(9, -1, 1), [0.0, -0.0, 1.0, -1.0, 3e-310]])
    x = np.concatenate([spread(10, -150, 150), spread(11, -1, 1), [-1.0, -1.0, 0.0, -0.0, 4e-310]])

    angle = evaluated(arithmetic.ARCTANGENT, y, x)
    length = evaluated(arithmetic.HYPOTENUSE, y, x)

    # mpmath knows no negative zero.
    some = np.array([i for i in range(len(x)) if x[i] != 0.0 and y[i] != 0.0])
    pairs = [(mpmath.mpf(float(y[i])), mpmath.mpf(float(x[i]))) for i in some]
    assert worst(angle[some], lambda i: mpmath.atan2(*pairs[i])) < 2.0
    assert worst(length[some], lambda i: mpmath.hypot(*pairs[i])) < 0.51
    assert angle[-5:-1].tolist() == [math.pi, -math.pi, math.pi / 2, -math.pi / 2]


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf])
def test_what_is_no_finite_number_has_the_limits_as_values(x: float) -> None:
    expected = {
        arithmetic.EXPONENTIAL: math.exp(x),
        arithmetic.EXPONENTIAL_LESS_ONE: math.expm1(x),
        arithmetic.LOGARITHM: math.log(x) if not x < 0.0 else math.nan,
        arithmetic.COSINE: math.nan,
        arithmetic.SINE: math.nan,
        arithmetic.ARCTANGENT: math.atan2(x, x),
        arithmetic.HYPOTENUSE: math.hypot(x, x),
    }
    for which, value in expected.items():
        np.testing.assert_equal(evaluated(which, np.array([x])), [value])


def test_plain_python_gives_the_bits_of_the_compiled_functions() -> None:
    x = np.concatenate([spread(12, -20, 2.8), ENDS, [0.0, -0.0, math.inf, math.nan]])
    y = np.roll(x, 7)
    pairs = {arithmetic.ARCTANGENT: "arctangent", arithmetic.HYPOTENUSE: "hypotenuse"}

    whole, less = zip(*(uncompiled(arithmetic.exponentials)(v) for v in x.tolist()), strict=True)
    cosine, sine = zip(*(uncompiled(arithmetic.cosine_sine)(v) for v in x.tolist()), strict=True)
    logarithm = [uncompiled(arithmetic.logarithm)(v) for v in x.tolist()]

    np.testing.assert_array_equal(evaluated(arithmetic.EXPONENTIAL, x), whole)
    np.testing.assert_array_equal(evaluated(arithmetic.EXPONENTIAL_LESS_ONE, x), less)
    np.testing.assert_array_equal(evaluated(arithmetic.COSINE, x), cosine)
    np.testing.assert_array_equal(evaluated(arithmetic.SINE, x), sine)
    np.testing.assert_array_equal(evaluated(arithmetic.LOGARITHM, x), logarithm)
    for which, name in pairs.items():
        plain = uncompiled(getattr(arithmetic, name))
        expected = [plain(*pair) for pair in zip(x.tolist(), y.tolist(), strict=True)]
        np.testing.assert_array_equal(evaluated(which, x, y), expected)


@kernel
def errors_of_products(a: Floats, b: Floats, out: Floats) -> None:
    for i in range(a.shape[0]):
        _, out[i] = arithmetic.two_product(a[i], b[i])


def portable_errors_of_products(a: Floats, b: Floats, out: Floats) -> None:
    for i in range(a.shape[0]):
        product = a[i] * b[i]
        out[i] = arithmetic.product_error(a[i], b[i], product)


def test_the_error_of_a_product_is_exact_with_and_without_a_fused_product() -> None:
    rng = np.random.default_rng(11)
    a = rng.normal(size=2000) * 10.0 ** rng.uniform(-60, 60, 2000)
    b = rng.normal(size=2000) * 10.0 ** rng.uniform(-60, 60, 2000)
    exact = [
        float(Fraction(x) * Fraction(y) - Fraction(x * y))
        for x, y in zip(a.tolist(), b.tolist(), strict=True)
    ]

    here, portable = np.empty(2000), np.empty(2000)
    errors_of_products(a, b, here)
    token = is_portable.set(True)
    try:
        assert not has_fused_products()
        njit: Any = numba.njit
        njit(portable_errors_of_products)(a, b, portable)
    finally:
        is_portable.reset(token)
    plain = np.empty(2000)
    portable_errors_of_products(a, b, plain)

    assert here.tolist() == portable.tolist() == plain.tolist() == exact
