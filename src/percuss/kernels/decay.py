"""The exponential of a decay, without the C library: lanes in lockstep take it as vectors."""

from __future__ import annotations

import numpy as np

from percuss.kernels.compile import formula
from percuss.kernels.doubled import nearest

PER_LN_2 = 1.4426950408889634
# ln 2 in two parts, of which the first has 32 bits: its product with the exponent is exact.
LN_2_HIGH, LN_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
# Below this the answer is 0 beside anything it is added to, and its exponent still a double's.
LEAST = -700.0
# Bits of a double below its exponent, and what is added to this.
MANTISSA, BIAS = 52, 1023
# 1 / n! for n = 2 to 13: beyond, less than 2**-56 of the sum.
E2, E3, E4, E5 = 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0
E6, E7, E8, E9 = 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362880.0
E10, E11, E12, E13 = 1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0


@formula
def decay(x: float) -> tuple[float, float]:
    """Return exp(x) and expm1(x) for x <= 0, either to a relative error of a few 1e-16."""
    x = max(x, LEAST)
    halvings = nearest(x * PER_LN_2)
    r = (x - halvings * LN_2_HIGH) - halvings * LN_2_LOW
    square = r * r
    fourth = square * square
    low = (E2 + r * E3) + square * (E4 + r * E5)
    middle = (E6 + r * E7) + square * (E8 + r * E9)
    high = (E10 + r * E11) + square * (E12 + r * E13)
    part = r + square * (low + fourth * (middle + fourth * high))
    scale = np.int64((np.int64(halvings) + BIAS) << MANTISSA).view(np.float64)
    part *= scale
    return scale + part, (scale - 1.0) + part
