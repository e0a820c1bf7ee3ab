"""The formulas of a law's rows, in whichever arithmetic they are given.

They are written once, in terms of `percuss.kernels.triples`, and run in two arithmetics: in Python
with the exact rationals of `percuss.model.ratios`, in a browser compiled, with numbers of 159 bits.
Either way an entry is rounded once, and is the same double (docs/decisions/024-webassembly.md).
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cosine_sine, exponential, hypotenuse
from percuss.kernels.compile import kernel
from percuss.kernels.law_columns import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    DAMPING,
    FAST_ROOT,
    FORCE_BOUND,
    GAIN_IM,
    GAIN_RE,
    GAP_IM,
    GAP_RE,
    GROWTH,
    HALF_TURNS,
    HALF_TURNS_LOW,
    HARMONIC,
    LOWER_KIND,
    LOWER_TABLE,
    N_FORCE_BOUNDS,
    NEAR,
    NOTHING,
    OMEGA,
    OVERDAMPED,
    PER_STIFFNESS,
    QUICKEST,
    RATE,
    SIMPLE,
    SINE,
    SLOW_ROOT,
    STEP,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    TWICE_PER_RATE,
    UPPER_KIND,
    UPPER_TABLE,
    WALL,
)
from percuss.kernels.triples import (
    PI,
    Triple,
    add,
    divide,
    magnitude,
    multiply,
    nearest_whole,
    negative,
    number,
    root,
    rounded,
    rounded_pair,
    sign,
    subtract,
)

# The largest phase of the fastest motion, or harmonic, that a step of the search covers, in
# radians: there the cubic through a step's ends is off by 1/384 of the amplitude at most.
STEP_PHASE = 1.0
# Where the free motion grows the bound over a step holds a factor exp(phase).
GROWING_STEP_PHASE = 0.5
# A harmonic is near a root when the inverse of its gain is this small a part of its own terms.
NEAR_PART = 1.0 / 16.0
# Above this part in floats it is far from a root for certain: rounding is far smaller than the
# difference of the two.
FAR_PART = 0.07


@kernel
def turns_per_time(value: Triple, halves: float) -> tuple[float, float]:
    """Return a rate over so many times pi as the sum of two doubles."""
    return rounded_pair(divide(value, multiply(number(halves), PI)))


@kernel
def phasor(times: Triple, plus: Triple) -> tuple[float, float]:
    """Return cosine and sine of ``times * pi + plus``, exact at multiples of pi/2 and pi/6."""
    turned = multiply(number(2.0), times)
    if sign(plus) != 0.0:
        turned = multiply(number(2.0), add(times, divide(plus, PI)))
    quarters = nearest_whole(turned)
    rest = subtract(times, multiply(number(0.5), quarters))
    is_sixth = sign(subtract(multiply(number(6.0), magnitude(rest)), number(1.0))) == 0.0
    if sign(plus) == 0.0 and is_sixth:
        cosine = math.sqrt(0.75)
        sine = math.copysign(0.5, sign(rest))
    else:
        cosine, sine = cosine_sine(rounded(add(multiply(rest, PI), plus)))
    # Adding zero turns -0.0 into 0.0.
    fours = nearest_whole(divide(subtract(quarters, number(1.5)), number(4.0)))
    quarter = rounded(subtract(quarters, multiply(number(4.0), fours)))
    if quarter == 0.0:
        return cosine, sine
    if quarter == 1.0:
        return -sine + 0.0, cosine
    if quarter == 2.0:
        return -cosine, -sine + 0.0
    return sine, -cosine


@kernel
def period_of(omega: Triple) -> float:
    """Return the period of an angular frequency."""
    return rounded(divide(multiply(number(2.0), PI), omega))


@kernel
def fill_harmonic(row: Floats, omega: Triple, cosine: float, sine: float) -> None:
    """Fill the row of a harmonic."""
    row[COSINE] = cosine
    row[SINE] = sine
    row[OMEGA] = rounded(omega)
    row[TURNS], row[TURNS_LOW] = turns_per_time(omega, 2.0)
    row[AMPLITUDE] = hypotenuse(cosine, sine)


@kernel
def bound_force(header: Floats, harmonic: Floats) -> None:
    """Add the force of a harmonic to the bounds of the force and its derivatives."""
    power = harmonic[AMPLITUDE]
    for order in range(N_FORCE_BOUNDS):
        header[FORCE_BOUND + order] += power
        power *= harmonic[OMEGA]


@kernel
def less_spring(force: Triple, stiffness: Triple, x: Triple, at: Triple) -> Triple:
    """Return a force less that of a spring at x whose end is at another point."""
    return subtract(force, multiply(stiffness, subtract(x, at)))


@kernel
def fill_motion(row: Floats, stiffness: Triple, damping: Triple) -> None:
    """Fill the rates of the free motion x'' + 2 (damping) x' + (stiffness) x = 0."""
    k = rounded(stiffness)
    a = rounded(damping)
    discriminant = subtract(stiffness, multiply(damping, damping))
    rate = root(magnitude(discriminant))
    row[STIFFNESS] = k
    row[DAMPING] = a
    row[RATE] = rounded(rate)
    row[HALF_TURNS], row[HALF_TURNS_LOW] = turns_per_time(rate, 4.0)
    row[TWICE_PER_RATE] = 2.0 / row[RATE] if sign(rate) != 0.0 else 0.0
    row[PER_STIFFNESS] = 0.0
    if sign(stiffness) != 0.0:
        row[PER_STIFFNESS] = rounded(divide(number(1.0), stiffness))
    row[GROWTH] = -a if a < 0.0 else 0.0
    if sign(discriminant) < 0.0:
        row[OVERDAMPED] = 1.0
        # The root of the larger size cancels nothing, and the product of both is the stiffness.
        largest = subtract(rate, damping)
        if sign(damping) >= 0.0:
            largest = negative(add(damping, rate))
        one = rounded(largest)
        other = rounded(divide(stiffness, largest))
        row[SLOW_ROOT] = max(one, other)
        row[FAST_ROOT] = min(one, other)
        row[GROWTH] = max(0.0, row[SLOW_ROOT])
    row[QUICKEST] = max(math.sqrt(abs(k)), 2.0 * abs(a))


@kernel
def fill_steps_of_search(row: Floats, omega: float) -> None:
    """Fill the length of a search step, and the constants of ``derivative_bound``.

    For K >= 0 the energy norm of (x, v) does not grow without force, but for a < 0 by
    exp(2 abs(a) s) at most; for K < 0 the norm max(p abs(x), abs(v)) with
    p = abs(a) + sqrt(a^2 + abs(K)) grows by exp(p s) at most (docs/theory/first-event.md).
    """
    k = row[STIFFNESS]
    a = abs(row[DAMPING])
    fastest = max(row[QUICKEST], omega)
    if fastest > 0.0:
        row[STEP] = (GROWING_STEP_PHASE if row[GROWTH] > 0.0 else STEP_PHASE) / fastest
    if k < 0.0:
        pace = a + math.sqrt(a * a - k)
        growth = exponential(pace * row[STEP])
        row[BOUND_OF_X] = growth * pace * pace
        row[BOUND_OF_V] = growth * pace
    else:
        pace = 2.0 * a + math.sqrt(k)
        growth = exponential(2.0 * a * row[STEP]) if row[GROWTH] > 0.0 else 1.0
        row[BOUND_OF_X] = growth * pace * math.sqrt(k)
        row[BOUND_OF_V] = growth * pace


@kernel
def fill_response(row: Floats, stiffness: Triple, damping: Triple, omega: Triple) -> None:
    """Fill the row of the response of a free motion to a harmonic."""
    square_of_omega = multiply(omega, omega)
    real = subtract(stiffness, square_of_omega)
    imaginary = multiply(number(2.0), multiply(damping, omega))
    square = add(multiply(real, real), multiply(imaginary, imaginary))
    if sign(square) > 0.0:
        row[GAIN_RE] = rounded(divide(real, square))
        row[GAIN_IM] = rounded(divide(negative(imaginary), square))
    # Far from a root for certain: the exact comparison is not needed.
    k = rounded(stiffness)
    a = abs(rounded(damping))
    w = rounded(omega)
    if abs(k - w * w) + 2.0 * a * w > FAR_PART * (2.0 * a * a + w * w + abs(k)):
        return
    square_of_damping = multiply(damping, damping)
    discriminant = subtract(stiffness, square_of_damping)
    terms = add(add(square_of_damping, square_of_omega), magnitude(discriminant))
    excess = subtract(
        add(magnitude(real), magnitude(imaginary)), multiply(number(NEAR_PART), terms)
    )
    if sign(excess) > 0.0:
        return
    # (i w - r1) (i w - r2) is the gain; divided by the far factor it leaves the gap, unrounded.
    # Of two real roots the near one is that of the smaller size.
    row[NEAR] = 1.0
    rate = rounded(root(magnitude(discriminant)))
    far = (rounded(damping), w + rate)
    if sign(discriminant) < 0.0:
        far = (far[0] + math.copysign(rate, far[0]), w)
    row[GAP_RE], row[GAP_IM] = quotient((rounded(real), rounded(imaginary)), far)


@kernel
def quotient(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Return the quotient of two complex numbers (Smith 1962)."""
    if abs(b[0]) >= abs(b[1]):
        ratio = b[1] / b[0]
        size = b[0] + b[1] * ratio
        return (a[0] + a[1] * ratio) / size, (a[1] - a[0] * ratio) / size
    ratio = b[0] / b[1]
    size = b[0] * ratio + b[1]
    return (a[0] * ratio + a[1]) / size, (a[1] * ratio - a[0]) / size


@kernel
def mark_simple(row: Floats, response: Floats) -> None:
    """Mark a region where the only harmonic, away from resonance, meets an oscillating mass."""
    if response[NEAR] != 0.0:
        return
    oscillates = row[OVERDAMPED] == 0.0 and row[RATE] > 0.0
    has_table = row[LOWER_TABLE] + row[UPPER_TABLE] > 0.0
    lower = row[LOWER_KIND]
    upper = row[UPPER_KIND]
    has_one_wall = (lower == WALL and upper == NOTHING) or (lower == NOTHING and upper == WALL)
    if oscillates and row[GROWTH] == 0.0:
        row[SIMPLE] = 1.0
        if has_one_wall and not has_table:
            row[HARMONIC] = 1.0
