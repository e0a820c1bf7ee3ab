"""Exact rationals as pairs of integers, for the formulas of the law.

Each function has one of the same name in `percuss.kernels.triples`, for numbers of 159 bits; the
formulas themselves stand once, in `percuss.kernels.law_formulas`, and `exact` gives them this
arithmetic. Nothing is reduced to lowest terms, which would take most of the time.
"""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeAlias

from percuss.kernels import law_formulas
from percuss.kernels.compile import uncompiled

# Numerator and denominator, which is positive.
Ratio: TypeAlias = tuple[int, int]

# 80 decimals: phases up to 1e40 are reduced with more than 1e-30 to spare.
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
# Bits of a root: more than its two doubles hold.
ROOT_BITS = 240


def ratio_of(value: Fraction) -> Ratio:
    """Return a fraction as a pair."""
    return value.numerator, value.denominator


def _number(x: float) -> Ratio:
    return x.as_integer_ratio()


def _negative(a: Ratio) -> Ratio:
    return -a[0], a[1]


def _sign(a: Ratio) -> float:
    return float((a[0] > 0) - (a[0] < 0))


def _magnitude(a: Ratio) -> Ratio:
    return abs(a[0]), a[1]


def _add(a: Ratio, b: Ratio) -> Ratio:
    return a[0] * b[1] + b[0] * a[1], a[1] * b[1]


def _subtract(a: Ratio, b: Ratio) -> Ratio:
    return a[0] * b[1] - b[0] * a[1], a[1] * b[1]


def _multiply(a: Ratio, b: Ratio) -> Ratio:
    return a[0] * b[0], a[1] * b[1]


def _divide(a: Ratio, b: Ratio) -> Ratio:
    n, d = a[0] * b[1], a[1] * b[0]
    return (n, d) if d > 0 else (-n, -d)


def _root(a: Ratio) -> Ratio:
    return _root_of(Fraction(*a))


@functools.lru_cache(maxsize=1024)
def _root_of(value: Fraction) -> Ratio:
    n, d = value.numerator, value.denominator
    shift = max(0, ROOT_BITS + (d.bit_length() - n.bit_length()) // 2)
    return math.isqrt((n << (2 * shift)) // d), 1 << shift


def _rounded(a: Ratio) -> float:
    # Division of integers is correctly rounded, whatever they have in common.
    return a[0] / a[1]


def _rounded_pair(a: Ratio) -> tuple[float, float]:
    high = a[0] / a[1]
    p, q = high.as_integer_ratio()
    return high, (a[0] * q - p * a[1]) / (a[1] * q)


def _nearest_whole(a: Ratio) -> Ratio:
    return round(Fraction(*a)), 1


_ARITHMETIC: dict[str, Any] = {
    "PI": ratio_of(PI),
    "number": _number,
    "negative": _negative,
    "sign": _sign,
    "magnitude": _magnitude,
    "add": _add,
    "subtract": _subtract,
    "multiply": _multiply,
    "divide": _divide,
    "root": _root,
    "rounded": _rounded,
    "rounded_pair": _rounded_pair,
    "nearest_whole": _nearest_whole,
}


@functools.cache
def exact(formula: Callable[..., Any]) -> Callable[..., Any]:
    """Return a formula of `law_formulas` in exact rationals, as plain Python.

    Parameters
    ----------
    formula
        One of its functions. Where it takes or returns a ``Triple`` the result has a `Ratio`.

    Returns
    -------
    Callable
        The same formula.

    Examples
    --------
    >>> exact(law_formulas.turns_per_time)((1, 3), 2)
    (0.05305164769729845, -3.279779445863748e-18)
    """
    plain: Any = getattr(formula, "py_func", formula)
    names: dict[str, Any] = {}
    for name in plain.__code__.co_names:
        value = plain.__globals__.get(name)
        if name in _ARITHMETIC:
            names[name] = _ARITHMETIC[name]
        elif getattr(value, "__module__", "") == law_formulas.__name__:
            names[name] = exact(value)
        elif callable(value):
            names[name] = uncompiled(value)
    around = {**plain.__globals__, **names}
    return types.FunctionType(plain.__code__, around, plain.__name__)
