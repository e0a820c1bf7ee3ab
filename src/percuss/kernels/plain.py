"""Plain flights in a row: one harmonic, one wall, from the wall and back to it.

This is `search`, `landing` and `march` for the commonest case, written as one loop whose numbers
stay in registers: 2.5 times as fast. Whatever is not plain it leaves to them untouched: a
flight that comes near a graze, a short or a long one, a slow impact.
"""

from __future__ import annotations

import math

from percuss.kernels.angles import cos_sin
from percuss.kernels.compile import kernel
from percuss.kernels.contact import SLOW
from percuss.kernels.doubled import later
from percuss.kernels.landing import is_settled, series_root
from percuss.kernels.law import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    FORCE_BOUND,
    GAIN_IM,
    GAIN_RE,
    HALF_TURNS,
    HALF_TURNS_LOW,
    LOWER_FORCE,
    LOWER_KIND,
    LOWER_RESTITUTION,
    OMEGA,
    PER_STIFFNESS,
    QUICKEST,
    SINE,
    STEP,
    STEP_COS,
    STEP_SIN,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    TWICE_PER_RATE,
    UPPER_FORCE,
    UPPER_RESTITUTION,
    V_OF_COS,
    V_OF_FORCE,
    V_OF_SIN,
    V_OF_V,
    V_OF_X,
    WALL,
    X_OF_COS,
    X_OF_FORCE,
    X_OF_SIN,
    X_OF_V,
    X_OF_X,
    Law,
    Table,
)
from percuss.kernels.record import EVENT_T, EVENT_T_LOW, HUGE, V_AFTER, V_BEFORE
from percuss.kernels.response import SERIES_LIMIT
from percuss.kernels.search import STEPS_A_WALK, THIRD, WALK_SLACK, cubic_minimum, quintic_root

# Looks at a landing: most are settled by the second, slow ones need more.
MOST_LOOKS = 6


@kernel
def plain_flights(
    law: Law,
    region: int,
    begin: tuple[float, float, float, float],
    t_end: float,
    phases: Table,
    events: Table,
    first: int,
    last: int,
) -> tuple[int, float]:
    """Fly from impact to impact while that is plain; return how many, and the fastest speed.

    ``begin`` is (t, t_low, v, fastest impact speed so far). Rows ``first`` to ``last`` of the
    events' table receive the impacts.
    """
    t, t_low, v0, fastest = begin
    sign = 1.0 if law[region, LOWER_KIND] == WALL else -1.0
    restitution = law[region, LOWER_RESTITUTION if sign > 0.0 else UPPER_RESTITUTION]
    force = law[region, LOWER_FORCE if sign > 0.0 else UPPER_FORCE]
    push = law[FIRST_HARMONIC, COSINE] * phases[0, 0] + law[FIRST_HARMONIC, SINE] * phases[0, 1]
    rate = law[FIRST_HARMONIC, SINE] * phases[0, 0] - law[FIRST_HARMONIC, COSINE] * phases[0, 1]
    for row in range(first, last):
        begin = (sign * force, sign * push, sign * rate, sign * v0)
        s, v, rest = plain_flight(law, region, begin)
        t1, t1_low = later(t, t_low, s)
        t1, t1_low = later(t1, t1_low, rest)
        v *= sign
        speed = restitution * abs(v)
        # Each comparison is also false for the NaN of a flight that is not plain.
        if not (t1 < t_end and speed > SLOW * fastest and speed < HUGE):
            return row - first, fastest
        fastest = max(fastest, abs(v))
        t = t1
        t_low = t1_low
        v0 = sign * speed
        cosine, sine = cos_sin(law[FIRST_HARMONIC, TURNS], law[FIRST_HARMONIC, TURNS_LOW], t, t_low)
        push = law[FIRST_HARMONIC, COSINE] * cosine + law[FIRST_HARMONIC, SINE] * sine
        rate = law[FIRST_HARMONIC, SINE] * cosine - law[FIRST_HARMONIC, COSINE] * sine
        events[row, EVENT_T] = t
        events[row, EVENT_T_LOW] = t_low
        events[row, V_BEFORE] = v
        events[row, V_AFTER] = v0
    return max(0, last - first), fastest


@kernel
def plain_flight(
    law: Law, region: int, begin: tuple[float, float, float, float]
) -> tuple[float, float, float]:
    """Return (s, v, rest of s) of the return to the wall, NaN where the flight is not plain.

    Turned so that the motion is at y > 0. ``begin`` is the constant force, the harmonic one and
    its derivative by the frequency, and the velocity, at the start.
    """
    force, push, rate, v = begin
    fourth, size = largest(law, region, begin)
    step = law[region, STEP]
    third = THIRD * step
    bow = fourth * step**4 * (1.0 / 384.0)
    slack = WALK_SLACK * (size + step * step * (abs(force) + law[0, FORCE_BOUND]))
    lift = law[region, X_OF_FORCE] * force
    haste = law[region, V_OF_FORCE] * force
    y = 0.0
    # On the first step the clearance is that after division by the time (see `clearances`).
    least = third * v - (384.0 / 72.0) * bow + slack
    for i in range(STEPS_A_WALK):
        y1 = lift + law[region + 1, X_OF_COS] * push + law[region + 1, X_OF_SIN] * rate
        v1 = haste + law[region + 1, V_OF_COS] * push + law[region + 1, V_OF_SIN] * rate
        push1 = push * law[region + 1, STEP_COS] + rate * law[region + 1, STEP_SIN]
        rate1 = rate * law[region + 1, STEP_COS] - push * law[region + 1, STEP_SIN]
        y1 += law[region, X_OF_X] * y + law[region, X_OF_V] * v
        v1 += law[region, V_OF_X] * y + law[region, V_OF_V] * v
        inner = min(y + third * v, y1 - third * v1)
        if not min(least, y1 - bow, inner - bow) > slack:
            if y1 < -slack and (i == 0 or y > slack):
                here = (step * i, y, v, push)
                return plain_end(law, region, begin, here, (y1, v1, push1), fourth, slack)
            if i == 0 or not min(y, y1) > slack:
                return math.nan, math.nan, math.nan
            if not cubic_minimum(y, step * v, y1, step * v1) > bow + slack:
                return math.nan, math.nan, math.nan
        y = y1
        v = v1
        push = push1
        rate = rate1
        least = y - bow
    return math.nan, math.nan, math.nan


@kernel
def largest(law: Law, region: int, begin: tuple[float, float, float, float]) -> tuple[float, float]:
    """Return bounds of the fourth derivative and of the sizes in a whole flight.

    The free part, of the amplitude that it starts with or less, has the rate sqrt(K), the steady
    part that of the harmonic.
    """
    force, push, rate, v0 = begin
    omega = law[FIRST_HARMONIC, OMEGA]
    gain_re = law[region + 1, GAIN_RE]
    gain_im = law[region + 1, GAIN_IM]
    stiffness = law[region, STIFFNESS]
    z = -force * law[region, PER_STIFFNESS] - (push * gain_re + rate * gain_im)
    w = v0 + omega * (push * gain_im - rate * gain_re)
    turned = (w + law[region, DAMPING] * z) * 0.5 * law[region, TWICE_PER_RATE]
    free = math.sqrt(z * z + turned * turned)
    swing = law[FIRST_HARMONIC, AMPLITUDE] * (abs(gain_re) + abs(gain_im))
    square = omega * omega
    fourth = stiffness * stiffness * free + square * square * swing
    pace = law[region, STEP] * max(omega, law[region, QUICKEST])
    size = (free + swing) * (2.0 + 2.0 * pace) + 2.0 * abs(force) * law[region, PER_STIFFNESS]
    return fourth, size


@kernel
def plain_end(
    law: Law,
    region: int,
    begin: tuple[float, float, float, float],
    here: tuple[float, float, float, float],
    there: tuple[float, float, float],
    fourth: float,
    slack: float,
) -> tuple[float, float, float]:
    """Return (s, v, rest of s) at the wall on a step that passes it, NaN if that is not plainly the first.

    ``here`` is s, y, v and push at the beginning of the step, ``there`` y, v and push at its
    end. The proof is that of `meeting`.
    """
    s, y, v, push = here
    y1, v1, push1 = there
    step = law[region, STEP]
    drag = 2.0 * law[region, DAMPING]
    second = begin[0] + push - drag * v - law[region, STIFFNESS] * y
    second1 = begin[0] + push1 - drag * v1 - law[region, STIFFNESS] * y1
    part = quintic_root((y, step * v, step * step * second), (y1, step * v1, step * step * second1))
    end, speed, rest = plain_landing(law, region, begin, s + step * part)
    width = end - s
    least = fourth * width**4 * (1.0 / 287.0) + (slack if s > 0.0 else 0.0)
    first = y + THIRD * width * v > least and -THIRD * width * speed > least
    if first and end <= s + step:
        return end, speed, rest
    return math.nan, math.nan, math.nan


@kernel
def plain_state(
    law: Law, region: int, begin: tuple[float, float, float, float], s: float
) -> tuple[float, float, float, float, float]:
    """Return y, v in two parts, the harmonic force, and its derivative by the frequency, at s.

    The closed form of `move` for one harmonic, where no series is needed. ``begin`` is the
    constant force, the harmonic one and its derivative by the frequency, and the velocity. The
    first part of v is what is left of the velocity at the start, mostly by far the larger.
    """
    force, push0, rate0, v0 = begin
    omega = law[FIRST_HARMONIC, OMEGA]
    damping = law[region, DAMPING]
    half_cos, half_sin = cos_sin(law[region, HALF_TURNS], law[region, HALF_TURNS_LOW], s, 0.0)
    cosine, sine = cos_sin(law[FIRST_HARMONIC, TURNS], law[FIRST_HARMONIC, TURNS_LOW], s, 0.0)
    shrink = math.exp(-damping * s) if damping > 0.0 else 1.0
    square = 2.0 * half_sin * half_sin
    blow = shrink * half_sin * half_cos * law[region, TWICE_PER_RATE]
    even = shrink * (1.0 - square)
    rise = square
    if damping > 0.0:
        rise = shrink * square - math.expm1(-damping * s) - damping * blow
    rise *= law[region, PER_STIFFNESS]
    over_re = cosine - even - damping * blow
    over_im = sine - omega * blow
    gain_re = law[region + 1, GAIN_RE]
    gain_im = law[region + 1, GAIN_IM]
    to_push = over_re * gain_re - over_im * gain_im
    to_rate = over_im * gain_re + over_re * gain_im
    y = v0 * blow + force * rise + push0 * to_push + rate0 * to_rate
    won = force * blow + push0 * (blow - omega * to_rate) + rate0 * omega * to_push
    won -= v0 * damping * blow
    kept = v0 * even
    if half_cos * half_cos < 0.25:
        # Near half a period: -v0, unrounded, and the little that is missing to it.
        kept = -v0 * shrink
        won -= 2.0 * kept * half_cos * half_cos
    return y, kept, won, push0 * cosine + rate0 * sine, rate0 * cosine - push0 * sine


@kernel
def plain_landing(
    law: Law, region: int, begin: tuple[float, float, float, float], guess: float
) -> tuple[float, float, float]:
    """Return (s, v, rest of s) at the wall next to ``guess``, NaN where a few looks do not settle it."""
    omega = law[FIRST_HARMONIC, OMEGA]
    drag = 2.0 * law[region, DAMPING]
    stiffness = law[region, STIFFNESS]
    s = guess
    slow = law[region, QUICKEST]
    pace = max(slow, omega)
    if law[region, DAMPING] > 0.0:
        # What a constant force does cancels there as well.
        pace = slow
    for _ in range(MOST_LOOKS):
        if not pace * s > SERIES_LIMIT:
            return math.nan, math.nan, math.nan
        y, kept, won, push, rate = plain_state(law, region, begin, s)
        v = kept + won
        second = begin[0] + push - drag * v - stiffness * y
        third = omega * rate - drag * second - stiffness * v
        fourth = -omega * omega * push - drag * third - stiffness * second
        fifth = -omega * omega * omega * rate - drag * fourth - stiffness * third
        step = series_root(y, v, second, third, fourth)
        sixth = law[0, FORCE_BOUND + 4] + law[region, BOUND_OF_X] * abs(fourth)
        sixth += law[region, BOUND_OF_V] * abs(fifth)
        if is_settled(law, region, step, s, v, (second, fifth, sixth)):
            rest = 0.5 * third + step * (fourth * (1.0 / 6.0) + step * fifth * (1.0 / 24.0))
            # Added last: each rounding of the large part would leave its mark on V for ever.
            end = s + step
            return end, kept + (won + step * (second + step * rest)), step - (end - s)
        s += step
    return math.nan, math.nan, math.nan
