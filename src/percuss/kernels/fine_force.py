"""The force to twice the digits of a double, where its sign is lost in the rounding of its terms.

A force that is a difference of larger terms, such as 3 - 4 cos t + cos 2t next to t = 0, has no
digits left in doubles where it is below some 1e-15 of them. Taken as exact, the doubles of the law
and of the instant define it there as well: sums in pairs of doubles give it to 1e-28 of its terms.
Slow, and asked only where doubles leave the sign open.
"""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import Pair, nearest, over, plus, times, two_product, two_sum
from percuss.kernels.law import (
    COSINE,
    FIRST_HARMONIC,
    FORCE_BOUND,
    N_HARMONICS,
    SINE,
    TURNS,
    TURNS_LOW,
    Law,
)

# 2 pi less its double.
TWO_PI = (2.0 * math.pi, 2.449293598294706414e-16)
# Terms of the series of cos and sin up to an eighth of a turn: what is left is below 2**-104.
MOST_TERMS = 27
# Rounding of the force and its derivatives, relative to the sum of their terms and to what the
# rounding of the instant's phase makes of them: 2**-94, with room for a hundred roundings.
FINE_ROUNDING = 5e-29
# The force's derivatives that its series on a piece is made of; the next one bounds the rest.
ORDERS = 10

# What the pressing force does over a piece: undecided, positive, falling, zero within rounding.
UNDECIDED, PRESSES, FALLS, VANISHES = 0, 1, 2, 3


@kernel
def fine_cos_sin(rate: float, rate_low: float, t: float, t_low: float) -> tuple[Pair, Pair]:
    """Return cos and sin of 2 pi (rate + rate_low) (t + t_low) as pairs."""
    product, error = two_product(rate, t)
    quarter = nearest(4.0 * product)
    phase = two_sum(product - 0.25 * quarter, error)
    phase = plus(phase, two_product(rate, t_low))
    other, other_error = two_product(rate_low, t)
    phase = plus(phase, (other, other_error + rate_low * t_low))
    # Late instants have a second part that is turns as well.
    more = nearest(4.0 * phase[0])
    phase = plus(phase, (-0.25 * more, 0.0))
    turned = (int(quarter) + int(more)) & 3
    angle = times(TWO_PI, phase)
    cosine = (1.0, 0.0)
    sine = angle
    term = angle
    for n in range(2, MOST_TERMS + 1):
        term = over(times(term, angle), -float(n) if n & 1 == 0 else float(n))
        # A sign changes at each second term: 1, a, -a^2 / 2, -a^3 / 6, a^4 / 24 ...
        if n & 1 == 0:
            cosine = plus(cosine, term)
        else:
            sine = plus(sine, term)
    if turned & 1:
        cosine, sine = sine, cosine
    if (turned + 1) & 2:
        cosine = (-cosine[0], -cosine[1])
    if turned & 2:
        sine = (-sine[0], -sine[1])
    return cosine, sine


@kernel
def fine_force(law: Law, force: float, instant: Pair, order: int) -> float:
    """Return the derivative of that order of the whole force, ``force`` being its constant part."""
    total = (force if order == 0 else 0.0, 0.0)
    for j in range(int(law[0, N_HARMONICS])):
        harmonic = FIRST_HARMONIC + j
        cosine, sine = fine_cos_sin(
            law[harmonic, TURNS], law[harmonic, TURNS_LOW], instant[0], instant[1]
        )
        in_cos = law[harmonic, COSINE]
        in_sin = law[harmonic, SINE]
        if order & 1:
            # The derivative turns the phasor by a quarter.
            in_cos, in_sin = in_sin, -in_cos
        if order & 2:
            in_cos = -in_cos
            in_sin = -in_sin
        part = plus(times((in_cos, 0.0), cosine), times((in_sin, 0.0), sine))
        omega = times(TWO_PI, (law[harmonic, TURNS], law[harmonic, TURNS_LOW]))
        for _ in range(order):
            part = times(part, omega)
        total = plus(total, part)
    return total[0] + total[1]


@kernel
def fine_tolerance(law: Law, force: float, instant: Pair, order: int) -> float:
    """Return a bound on the rounding of `fine_force`."""
    size = law[0, FORCE_BOUND + order] + law[0, FORCE_BOUND + order + 1] * abs(instant[0])
    return FINE_ROUNDING * (size + abs(force))


@kernel
def pressing_shape(law: Law, force: float, sign: float, instant: Pair, width: float) -> int:
    """Tell what the pressing force -sign * f does from an instant on, for a time ``width``.

    Its Taylor polynomial of degree ORDERS - 1 departs from it by F_ORDERS width^ORDERS / ORDERS!
    at most; the terms of the polynomial are taken at their worst.
    """
    tolerance = fine_tolerance(law, force, instant, 0)
    value = -sign * fine_force(law, force, instant, 0)
    slope = -sign * fine_force(law, force, instant, 1)
    fall = 0.0
    rise_of_slope = 0.0
    size = abs(slope) * width
    scale = width
    for order in range(2, ORDERS + 1):
        part = law[0, FORCE_BOUND + order] if order == ORDERS else 0.0
        if order < ORDERS:
            part = -sign * fine_force(law, force, instant, order)
        rise_of_slope += max(part, 0.0) * scale
        scale *= width / order
        fall += min(part, -part if order == ORDERS else 0.0) * scale
        size += abs(part) * scale
    if abs(value) + size <= tolerance:
        return VANISHES
    if value + min(0.0, slope * width) + fall > tolerance:
        return PRESSES
    if slope + rise_of_slope < 0.0:
        return FALLS
    return UNDECIDED
