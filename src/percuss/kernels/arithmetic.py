"""Arithmetic from sums and products alone, so that each machine gives the same bits.

The C library's elementary functions differ between its versions and, where it has variants with
fused multiplication, between processors; NumPy's and a compiler's vector forms differ from both.
What IEEE 754 rounds correctly, + - * / and the square root, is the same everywhere, and kernels
are compiled without contraction; a fused product stands only where its answer is exact. Methods and
coefficients are those of fdlibm (Sun Microsystems 1993); all answers are right to one unit in the
last place.

Sums and products that keep their rounding errors are those of Dekker 1971 and Knuth 1969. An
instant is the exact sum of a pair ``(t, t_low)``: at t = 2e6 one ulp of t alone is 4.7e-10, far
more than the rounding of a flight. Rates in turns per time are pairs as well, so that
the phase of a harmonic has 16 digits at any instant.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.compile import error_of_product, formula, kernel

Pair: TypeAlias = tuple[float, float]

ULP = 2.220446049250313e-16  # of 1

# Adding and subtracting 1.5 * 2**52 rounds a double below 2**51 to the nearest integer.
ROUNDER = 6755399441055744.0
# Splits a double into two halves of 26 bits (Veltkamp).
SPLITTER = 134217729.0


@kernel
def nearest(x: float) -> float:
    """Return the integer nearest to x, for abs(x) < 2**51."""
    return (x + ROUNDER) - ROUNDER


@kernel
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and the rounding error."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@error_of_product
def product_error(a: float, b: float, product: float) -> float:
    """Return a * b - product, where ``product`` is a * b rounded."""
    split = SPLITTER * a
    a_high = split - (split - a)
    a_low = a - a_high
    split = SPLITTER * b
    b_high = split - (split - b)
    b_low = b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@kernel
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return a * b rounded, and the rounding error."""
    product = a * b
    return product, product_error(a, b, product)


@kernel
def plus(a: Pair, b: Pair) -> Pair:
    """Return the sum of two pairs, to 2**-104 of the sizes of both."""
    total, error = two_sum(a[0], b[0])
    return two_sum(total, error + (a[1] + b[1]))


@kernel
def times(a: Pair, b: Pair) -> Pair:
    """Return the product of two pairs, to a relative 2**-102."""
    product, error = two_product(a[0], b[0])
    return two_sum(product, error + (a[0] * b[1] + a[1] * b[0]))


@kernel
def over(a: Pair, n: float) -> Pair:
    """Return a pair divided by a double, to a relative 2**-102."""
    quotient = a[0] / n
    product, error = two_product(quotient, n)
    return two_sum(quotient, (((a[0] - product) - error) + a[1]) / n)


@kernel
def later(t: float, t_low: float, s: float) -> tuple[float, float]:
    """Return the instant a time s after (t, t_low), as a pair."""
    total, error = two_sum(t, s)
    return two_sum(total, error + t_low)


@kernel
def turns(rate: float, rate_low: float, t: float, t_low: float) -> float:
    """Return (rate * t) mod 1 in [-1/2, 1/2], to a relative error of a few 1e-16.

    The whole turns are removed exactly before anything is rounded, so that a phase near a whole
    turn keeps its digits: the sine of it, near zero, does too.
    """
    product, error = two_product(rate, t)
    error += rate * t_low + rate_low * t
    part = (product - nearest(product)) + error
    return part - nearest(part)


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
    # Summed in pairs (Estrin): shorter chains of operations that depend on each other.
    square = z * z
    sine = (S1 + z * S2) + square * ((S3 + z * S4) + square * (S5 + z * S6))
    sine = angle + (angle * z) * sine
    half = 0.5 * z
    rest = square * ((C1 + z * C2) + square * ((C3 + z * C4) + square * (C5 + z * C6)))
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + rest)
    # Without branches: the next quarter cannot be predicted.
    turned = int(quarter) & 3
    cosine, sine = (sine, cosine) if turned & 1 else (cosine, sine)
    if (turned + 1) & 2:
        cosine = -cosine
    if turned & 2:
        sine = -sine
    return cosine, sine


PER_LN_2 = 1.4426950408889634
# ln 2 in two parts, of which the first has 32 bits: its product with the exponent is exact.
LN_2_HIGH, LN_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
# Below this exp(x) is lost in any sum; its exponent is still that of a normal double.
LEAST_DECAY = -700.0
# Bits of a double below its exponent, and what is added to this.
MANTISSA, BIAS = 52, 1023
# 1 / n! for n = 2 to 13: later terms are less than 2**-56 of the sum.
E2, E3, E4, E5 = 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0
E6, E7, E8, E9 = 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362880.0
E10, E11, E12, E13 = 1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0


@formula
def decay(x: float) -> tuple[float, float]:
    """Return exp(x) and expm1(x) for x <= 0, each to a relative error of a few 1e-16."""
    x = max(x, LEAST_DECAY)
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


# What `evaluate` computes.
EXPONENTIAL, EXPONENTIAL_LESS_ONE, LOGARITHM, COSINE, SINE, TANGENT = range(6)
ARCTANGENT, HYPOTENUSE, PHASOR = range(6, 9)

# exp(x) is infinite above the first, 0 below the second.
LARGEST, LEAST = 709.782712893384, -745.1332191019412
# Beyond these powers of two the 1 of exp(x) - 1, or exp(x), is below rounding.
ONE_LOST = 60.0

# Coefficients of log(1 + f) in s = f / (2 + f), error below 2**-58.
L1, L2, L3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
L4, L5, L6 = 2.222219843214978396e-01, 1.818357216161805012e-01, 1.531383769920937332e-01
L7 = 1.479819860511658591e-01
ROOT_HALF = 0.7071067811865476

# pi/2 in three doubles, and 2/pi.
QUARTER, QUARTER_LOW = 1.5707963267948966, 6.123233995736766e-17
QUARTER_LEAST = -1.4973849048591698e-33
PER_QUARTER = 0.6366197723675814
# Above it an ulp is half a radian or more: the remainder by the double 2 pi stands for the angle.
LARGEST_ANGLE = 2.0**51

# atan(x) = x - x (odd and even part of a polynomial in x^2), abs(x) < 7/16.
A0, A1, A2 = 3.33333333333329318027e-01, -1.99999999998764832476e-01, 1.42857142725034663711e-01
A3, A4, A5 = -1.11111104054623557880e-01, 9.09088713343650656196e-02, -7.69187620504482999495e-02
A6, A7, A8 = 6.66107313738753120669e-02, -5.83357013379057348645e-02, 4.97687799461593236017e-02
A9, A10 = -3.65315727442169155270e-02, 1.62858201153657823623e-02
# atan of 1/2, 1, 3/2 and infinity in two doubles, and pi.
ATAN_HIGH = (
    4.63647609000806093515e-01,
    7.85398163397448278999e-01,
    9.82793723247329054082e-01,
    1.57079632679489655800e00,
)
ATAN_LOW = (
    2.26987774529616870924e-17,
    3.06161699786838301793e-17,
    1.39033110312309984516e-17,
    6.12323399573676603587e-17,
)
HALF_TURN, HALF_TURN_LOW = 3.141592653589793, 1.2246467991473532e-16

# Squares of sizes between these neither overflow nor lose digits.
SMALL, LARGE = 2.0**-400, 2.0**400
UP, DOWN = 2.0**600, 2.0**-600


@kernel
def exponentials(x: float) -> tuple[float, float]:
    """Return exp(x) and exp(x) - 1."""
    if not x <= LARGEST:
        return (x, x) if math.isnan(x) else (math.inf, math.inf)
    if x < LEAST:
        return 0.0, -1.0
    halvings = nearest(x * PER_LN_2)
    high = x - halvings * LN_2_HIGH
    low = halvings * LN_2_LOW
    r = high - low
    rest = (high - r) - low
    square = r * r
    fourth = square * square
    second = (E2 + r * E3) + square * (E4 + r * E5)
    middle = (E6 + r * E7) + square * (E8 + r * E9)
    last = (E10 + r * E11) + square * (E12 + r * E13)
    # exp(r + rest) - 1 = r + small.
    small = square * (second + fourth * (middle + fourth * last)) + (rest + r * rest)
    whole, error = two_sum(1.0, r)
    # In two steps: a power of two may lie beyond the doubles, above and below.
    half = np.int64(0.5 * halvings)
    other = np.int64(halvings) - half
    scale = np.int64((half + BIAS) << MANTISSA).view(np.float64)
    scale_2 = np.int64((other + BIAS) << MANTISSA).view(np.float64)
    value = ((whole + (error + small)) * scale) * scale_2
    if halvings > ONE_LOST:
        return value, value
    if halvings < -ONE_LOST:
        return value, -1.0
    scale *= scale_2
    total, error = two_sum(scale - 1.0, scale * r)
    return value, total + (error + scale * small)


@kernel
def exponential(x: float) -> float:
    """Return exp(x)."""
    return exponentials(x)[0]


@kernel
def exponential_less_one(x: float) -> float:
    """Return exp(x) - 1."""
    return exponentials(x)[1]


@kernel
def logarithm(x: float) -> float:
    """Return the natural logarithm; -inf at 0, NaN below."""
    if not x > 0.0:
        return -math.inf if x == 0.0 else math.nan
    if x == math.inf:
        return x
    mantissa, doublings = math.frexp(x)
    if mantissa < ROOT_HALF:
        mantissa *= 2.0
        doublings -= 1
    f = mantissa - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    series = w * (L2 + w * (L4 + w * L6)) + z * (L1 + w * (L3 + w * (L5 + w * L7)))
    half = 0.5 * f * f
    return doublings * LN_2_HIGH - ((half - (s * (half + series) + doublings * LN_2_LOW)) - f)


@kernel
def cosine_sine(x: float) -> tuple[float, float]:
    """Return cos(x) and sin(x)."""
    if not abs(x) <= LARGEST_ANGLE:
        if not abs(x) < math.inf:
            return math.nan, math.nan
        x %= 4.0 * QUARTER
    quarter = nearest(x * PER_QUARTER)
    # What is left of the angle, as a pair: each product is exact, the first difference too.
    product, error = two_product(quarter, QUARTER)
    product_2, error_2 = two_product(quarter, QUARTER_LOW)
    total, low = two_sum(x - product, -error)
    total, low_2 = two_sum(total, -product_2)
    low += low_2 - (error_2 + quarter * QUARTER_LEAST)
    if abs(total) > 0.8:
        # For a large angle the quotient itself is rounded to the wrong side.
        once = math.copysign(1.0, total)
        quarter += once
        total, low_2 = two_sum(total, -once * QUARTER)
        low += low_2 - once * QUARTER_LOW
    angle = total + low
    low -= angle - total
    z = angle * angle
    square = z * z
    sine = S2 + z * S3 + square * (S4 + z * (S5 + z * S6))
    cube = z * angle
    sine = angle - ((z * (0.5 * low - cube * sine) - low) - cube * S1)
    half = 0.5 * z
    rest = square * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))))
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + (rest - angle * low))
    turned = int(quarter) & 3
    if turned & 1:
        cosine, sine = sine, cosine
    if (turned + 1) & 2:
        cosine = -cosine
    if turned & 2:
        sine = -sine
    return cosine, sine


@kernel
def arctangent(y: float, x: float) -> float:
    """Return the angle of the point (x, y), in [-pi, pi]."""
    if math.isnan(x) or math.isnan(y):
        return math.nan
    up = abs(y)
    along = abs(x)
    if up == math.inf and along == math.inf:
        up = along = 1.0
    if up == 0.0 and along == 0.0:
        angle = 0.0
    elif up > along * 2.0**66:
        return math.copysign(QUARTER, y)
    else:
        ratio = up / along
        k = -1
        if ratio >= 2.4375:
            k = 3
            ratio = -along / up
        elif ratio >= 1.1875:
            k = 2
            ratio = (ratio - 1.5) / (1.0 + 1.5 * ratio)
        elif ratio >= 0.6875:
            k = 1
            ratio = (ratio - 1.0) / (ratio + 1.0)
        elif ratio >= 0.4375:
            k = 0
            ratio = (2.0 * ratio - 1.0) / (2.0 + ratio)
        z = ratio * ratio
        w = z * z
        even = z * (A0 + w * (A2 + w * (A4 + w * (A6 + w * (A8 + w * A10)))))
        odd = w * (A1 + w * (A3 + w * (A5 + w * (A7 + w * A9))))
        angle = ratio - ratio * (even + odd)
        if k >= 0:
            angle = ATAN_HIGH[k] - ((ratio * (even + odd) - ATAN_LOW[k]) - ratio)
    if math.copysign(1.0, x) < 0.0:
        angle = HALF_TURN - (angle - HALF_TURN_LOW)
    return math.copysign(angle, y)


@kernel
def hypotenuse(x: float, y: float) -> float:
    """Return sqrt(x^2 + y^2), without overflow on the way."""
    x = abs(x)
    y = abs(y)
    if math.isinf(x) or math.isinf(y):
        return math.inf
    larger = max(x, y)
    smaller = min(x, y)
    if math.isnan(x) or math.isnan(y):
        return math.nan
    scale = 1.0
    if larger > LARGE:
        larger *= DOWN
        smaller *= DOWN
        scale = UP
    elif larger < SMALL:
        larger *= UP
        smaller *= UP
        scale = DOWN
    if smaller <= larger * 2.0**-54:
        return (larger + smaller) * scale
    root = math.sqrt(larger * larger + smaller * smaller)
    # The residual of its square, exact but for one rounding (Borges 2019).
    square, error = two_product(root, root)
    first, error_1 = two_product(larger, larger)
    second, error_2 = two_product(smaller, smaller)
    missing = ((first - square) + second) + ((error_1 + error_2) - error)
    return (root + missing / (2.0 * root)) * scale


@kernel
def evaluate(which: int, x: Floats, y: Floats, out: Floats) -> None:
    """Write a function of each entry of ``x``, or of each pair (x, y), into ``out``.

    ``y`` is ``x`` for functions of one argument. A phasor fills two entries, cosine and sine.
    """
    for i in range(x.shape[0]):
        if which == PHASOR:
            out[2 * i], out[2 * i + 1] = cosine_sine(x[i])
        elif which <= EXPONENTIAL_LESS_ONE:
            out[i] = exponentials(x[i])[which]
        elif which == LOGARITHM:
            out[i] = logarithm(x[i])
        elif which == ARCTANGENT:
            out[i] = arctangent(x[i], y[i])
        elif which == HYPOTENUSE:
            out[i] = hypotenuse(x[i], y[i])
        else:
            cosine, sine = cosine_sine(x[i])
            if which == COSINE:
                out[i] = cosine
            else:
                out[i] = sine if which == SINE else sine / cosine


# Steps to the root of a quintic: after two the error is the departure of the motion from it.
GUESSES = 2


@kernel
def cubic_minimum(y: float, v: float, y1: float, v1: float) -> float:
    """Return the least value on [0, 1] of the cubic with these end values and slopes."""
    square = 3.0 * (y1 - y) - 2.0 * v - v1
    cube = v + v1 - 2.0 * (y1 - y)
    least = min(y, y1)
    root = square * square - 3.0 * cube * v
    if root > 0.0:
        # Of both turning points the one with upward curvature, in the form that does not cancel.
        part = -v / (square + math.sqrt(root)) if square > 0.0 else 1.0
        if square <= 0.0 and cube != 0.0:
            part = (math.sqrt(root) - square) / (3.0 * cube)
        if 0.0 < part < 1.0:
            least = min(least, y + part * (v + part * (square + cube * part)))
    return least


@formula
def quintic_root(ends: tuple[float, float, float], ends1: tuple[float, float, float]) -> float:
    """Return an approximate zero in (0, 1) of the quintic with these values and derivatives.

    It begins above zero, or at zero and rising, and ends below zero.
    """
    c0, c1, twice = ends
    c2 = 0.5 * twice
    value = ends1[0] - c0 - c1 - c2
    slope = ends1[1] - c1 - twice
    curve = 0.5 * (ends1[2] - twice)
    c3 = 10.0 * value - 4.0 * slope + curve
    c4 = -15.0 * value + 7.0 * slope - 2.0 * curve
    c5 = 6.0 * value - 3.0 * slope + curve
    # Begin where the chord is zero; on the first step from a wall, the chord of value / time.
    high = c0 if c0 > 0.0 else c1
    fall = high - ends1[0]
    part = high / fall if high > 0.0 and fall > high else 0.5
    for _ in range(GUESSES):
        # Halley's method; bisection towards the root where that leaves the step.
        square = part * part
        value = (c0 + part * c1) + square * ((c2 + part * c3) + square * (c4 + part * c5))
        slope = (c1 + part * twice) + square * ((3.0 * c3 + part * 4.0 * c4) + square * 5.0 * c5)
        bend = (twice + part * 6.0 * c3) + square * (12.0 * c4 + part * 20.0 * c5)
        below = slope * slope - 0.5 * value * bend
        better = part - value * slope / below if below != 0.0 else -1.0
        half = 0.5 * (part + 1.0) if value > 0.0 else 0.5 * part
        part = better if 0.0 < better < 1.0 else half
    return part
