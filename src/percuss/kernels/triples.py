"""Numbers of 159 bits, as sums of three doubles.

They stand for the exact rationals of `percuss.model.ratios` where there is only a double's
arithmetic, in a browser: sums, products, quotients and roots are right to a relative 2**-150, so
that rounded once to a double they give the double that the exact value gives. Each function here
has one of the same name there (docs/decisions/024-webassembly.md).

Sizes between 1e-200 and 1e200 neither overflow nor lose digits.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from percuss.kernels.arithmetic import nearest, two_product, two_sum
from percuss.kernels.compile import kernel

Triple: TypeAlias = tuple[float, float, float]

# pi, to 2**-160.
PI = (3.141592653589793, 1.2246467991473532e-16, -2.9947698097183397e-33)
# A sum smaller than this part of its terms is one of numbers that are no finite sums, and 0.
CANCELLED = 2.0**-140


@kernel
def normal(a: float, b: float, c: float) -> Triple:
    """Return the sum of three doubles of falling size with parts that do not overlap."""
    high, middle = two_sum(a, b)
    middle, low = two_sum(middle, c)
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    return high, middle, low


@kernel
def number(x: float) -> Triple:
    """Return a double as it is."""
    return x, 0.0, 0.0


@kernel
def negative(a: Triple) -> Triple:
    """Return -a."""
    return -a[0], -a[1], -a[2]


@kernel
def sign(a: Triple) -> float:
    """Return 1, 0 or -1."""
    return 0.0 if a[0] == 0.0 else math.copysign(1.0, a[0])


@kernel
def magnitude(a: Triple) -> Triple:
    """Return the absolute value."""
    return negative(a) if a[0] < 0.0 else a


@kernel
def plain_sum(a: Triple, b: Triple) -> Triple:
    """Return a + b, to 2**-158 of the larger one."""
    high, error = two_sum(a[0], b[0])
    middle, error_2 = two_sum(a[1], b[1])
    middle, error = two_sum(middle, error)
    return normal(high, middle, (a[2] + b[2]) + (error + error_2))


@kernel
def add(a: Triple, b: Triple) -> Triple:
    """Return a + b, 0 where they cancel."""
    total = plain_sum(a, b)
    if abs(total[0]) <= CANCELLED * max(abs(a[0]), abs(b[0])):
        return 0.0, 0.0, 0.0
    return total


@kernel
def subtract(a: Triple, b: Triple) -> Triple:
    """Return a - b, 0 where they cancel."""
    return add(a, negative(b))


@kernel
def multiply(a: Triple, b: Triple) -> Triple:
    """Return a b."""
    high, error = two_product(a[0], b[0])
    first, error_1 = two_product(a[0], b[1])
    second, error_2 = two_product(a[1], b[0])
    middle, lost_1 = two_sum(first, second)
    middle, lost_2 = two_sum(middle, error)
    low = (a[0] * b[2] + a[1] * b[1] + a[2] * b[0]) + (error_1 + error_2)
    return normal(high, middle, low + (lost_1 + lost_2))


@kernel
def divide(a: Triple, b: Triple) -> Triple:
    """Return a / b."""
    quotient = (a[0] / b[0], 0.0, 0.0)
    for _ in range(3):
        rest = plain_sum(a, negative(multiply(quotient, b)))
        quotient = plain_sum(quotient, (rest[0] / b[0], 0.0, 0.0))
    return quotient


@kernel
def root(a: Triple) -> Triple:
    """Return the square root of a number that is not negative."""
    if a[0] == 0.0:
        return a
    whole = (math.sqrt(a[0]), 0.0, 0.0)
    for _ in range(3):
        rest = plain_sum(a, negative(multiply(whole, whole)))
        whole = plain_sum(whole, (rest[0] / (2.0 * whole[0]), 0.0, 0.0))
    return whole


@kernel
def rounded(a: Triple) -> float:
    """Return the nearest double, with one rounding."""
    middle, low = two_sum(a[1], a[2])
    if low != 0.0:
        # To odd: what lies half way between two doubles goes to the side of the rest.
        bits = np.float64(middle).view(np.int64)
        if bits & 1 == 0:
            bits += 1 if (low > 0.0) == (middle > 0.0) else -1
        middle = np.int64(bits).view(np.float64)
    return a[0] + middle


@kernel
def rounded_pair(a: Triple) -> tuple[float, float]:
    """Return the number as the sum of two doubles, each rounded once."""
    high = rounded(a)
    return high, rounded(plain_sum(a, (-high, 0.0, 0.0)))


@kernel
def nearest_whole(a: Triple) -> Triple:
    """Return the nearest whole number, the even one of two, below 2**51."""
    return nearest(rounded(a)), 0.0, 0.0
