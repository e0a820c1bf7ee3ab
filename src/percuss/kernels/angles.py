"""Cosine and sine of a phase that grows for ever."""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import nearest, two_product

TWO_PI = 2.0 * math.pi

# Minimax polynomials on [-pi/4, pi/4], error below 2**-57 (the coefficients of fdlibm's
# k_sin.c and k_cos.c, Sun Microsystems 1993).
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@kernel
def cos_sin(rate: float, rate_low: float, t: float, t_low: float) -> tuple[float, float]:
    """Return cos and sin of 2 pi (rate + rate_low) (t + t_low), for a rate in turns per time.

    Quarter turns come off exactly before anything is rounded: at quarter turns the answer is
    exact, and next to them the small one of the two keeps its relative precision. It is a
    polynomial, free of branches, and no call of the C library.
    """
    product, error = two_product(rate, t)
    quarter = nearest(4.0 * product)
    angle = TWO_PI * ((product - 0.25 * quarter) + (error + (rate * t_low + rate_low * t)))
    z = angle * angle
    # Summed in pairs (Estrin), so that less waits for less.
    square = z * z
    sine = (S1 + z * S2) + square * ((S3 + z * S4) + square * (S5 + z * S6))
    sine = angle + (angle * z) * sine
    half = 0.5 * z
    rest = square * ((C1 + z * C2) + square * ((C3 + z * C4) + square * (C5 + z * C6)))
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + rest)
    # A choice without branches: which quarter comes next is as good as random.
    turned = int(quarter) & 3
    cosine, sine = (sine, cosine) if turned & 1 else (cosine, sine)
    if (turned + 1) & 2:
        cosine = -cosine
    if turned & 2:
        sine = -sine
    return cosine, sine
