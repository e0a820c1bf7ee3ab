"""How an oscillator at rest responds: to a blow, to a constant force, to a harmonic.

A flight that starts from y = 0 with velocity v is, in every linear regime,

    y(s) = v S(s) + g D(s) + sum_j Re[ (force phasor)_j Q_j(s) ],

where with the characteristic roots r1, r2 and divided differences of the exponential

    S = s exp[r1 s, r2 s],   D = s^2 exp[r1 s, r2 s, 0],   Q = s^2 exp[r1 s, r2 s, i w s].

These are entire functions of all their arguments: critical damping, k = 0, resonance are no
special cases of the formula, only of its evaluation. Each function below takes the form that
loses no digits where it is used (docs/theory/flight.md).
"""

from __future__ import annotations

from percuss.kernels.angles import cos_sin
from percuss.kernels.arithmetic import (
    cosine_sine,
    exponential,
    exponential_less_one,
    exponentials,
)
from percuss.kernels.compile import kernel
from percuss.kernels.law import (
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    GAP_IM,
    GAP_RE,
    HALF_TURNS,
    HALF_TURNS_LOW,
    NEAR,
    OMEGA,
    OVERDAMPED,
    PER_STIFFNESS,
    QUICKEST,
    RATE,
    SLOW_ROOT,
    STIFFNESS,
    TWICE_PER_RATE,
    Law,
)

# Below this phase the power series is used: there the closed forms lose digits to cancellation,
# and above it the series needs more than its terms.
SERIES_LIMIT = 0.5
# With abs(rate * s) <= 1/2 the terms from here on are below 0.5**18 / 18! of the sum.
MOST_TERMS = 20.0
NEGLIGIBLE = 1e-18


@kernel
def free_response(law: Law, region: int, s: float) -> tuple[float, float, float]:
    """Return (S, c, D) at s: the response to a unit blow, S' + a S, the response to a unit force.

    S'' + 2 a S' + K S = 0 with S(0) = 0, S'(0) = 1; c is exp(-a s) cos(RATE s) or its hyperbolic
    form, so that S' = c - a S; D is the integral of S.
    """
    damping = law[region, DAMPING]
    rate = law[region, RATE]
    if law[region, OVERDAMPED] == 1.0:
        slow = exponential(law[region, SLOW_ROOT] * s)
        shrink = exponential_less_one(-2.0 * rate * s)
        blow = slow * (-shrink) / (2.0 * rate)
        even = slow * (1.0 + 0.5 * shrink)
        if law[region, QUICKEST] * s < SERIES_LIMIT:
            force = force_series(damping, law[region, STIFFNESS], s)
        elif abs(law[region, SLOW_ROOT]) < -0.5 * law[region, FAST_ROOT]:
            fast = exponential_less_one(law[region, FAST_ROOT] * s) / law[region, FAST_ROOT]
            late = s
            if law[region, SLOW_ROOT] != 0.0:
                late = exponential_less_one(law[region, SLOW_ROOT] * s) / law[region, SLOW_ROOT]
            force = (late - fast) / (2.0 * rate)
        else:
            force = (1.0 - even - damping * blow) * law[region, PER_STIFFNESS]
        return blow, even, force
    shrink = 1.0
    lost = 0.0
    if damping > 0.0:
        shrink, lost = exponentials(-damping * s)
    if rate == 0.0:
        blow = shrink * s
        even = shrink
        square = 0.0
    else:
        half_cos, half_sin = cos_sin(law[region, HALF_TURNS], law[region, HALF_TURNS_LOW], s, 0.0)
        square = 2.0 * half_sin * half_sin
        blow = shrink * half_sin * half_cos * law[region, TWICE_PER_RATE]
        # Of the two forms the one whose square is the small one.
        even = shrink * (1.0 - square if square < 1.0 else 2.0 * half_cos * half_cos - 1.0)
    if law[region, QUICKEST] * s < SERIES_LIMIT:
        force = force_series(damping, law[region, STIFFNESS], s)
    elif damping == 0.0:
        force = square * law[region, PER_STIFFNESS]
    else:
        # 1 - even, without the cancellation of small damping near a whole period.
        force = (shrink * square - lost - damping * blow) * law[region, PER_STIFFNESS]
    return blow, even, force


@kernel
def force_series(damping: float, stiffness: float, s: float) -> float:
    """Return D(s) by its power series, for small s."""
    drag = 2.0 * damping * s
    spring = stiffness * s * s
    before = 0.0
    term = 0.5 * s * s
    total = term
    n = 3.0
    while n < MOST_TERMS and abs(term) + abs(before) > NEGLIGIBLE * abs(total):
        following = -(drag * term + spring * before / (n - 1.0)) / n
        before = term
        term = following
        total += term
        n += 1.0
    return total


@kernel
def harmonic_response(
    law: Law, region: int, j: int, s: float, blow: float, even: float, turn: tuple[float, float]
) -> tuple[float, float]:
    """Return (Re Q_j, Im Q_j) at s: the responses to cos(w_j s) and to sin(w_j s).

    ``blow`` and ``even`` are S(s) and c(s); ``turn`` is (cos, sin) of w_j s.
    """
    omega = law[FIRST_HARMONIC + j, OMEGA]
    response = region + 1 + j
    if max(law[region, QUICKEST], omega) * s < SERIES_LIMIT:
        return harmonic_series(law[region, DAMPING], law[region, STIFFNESS], omega, s)
    if law[response, NEAR] == 1.0:
        return near_response(law, region, j, s, blow, even, turn)
    over_re = turn[0] - even - law[region, DAMPING] * blow
    over_im = turn[1] - omega * blow
    gain_re = law[response, GAIN_RE]
    gain_im = law[response, GAIN_IM]
    return (
        over_re * gain_re - over_im * gain_im,
        over_im * gain_re + over_re * gain_im,
    )


@kernel
def harmonic_series(
    damping: float, stiffness: float, omega: float, s: float
) -> tuple[float, float]:
    """Return (Re Q, Im Q) at s by the power series, for small s."""
    phase = omega * s
    drag = 2.0 * damping * s
    square = s * s
    force_re = 1.0
    force_im = 0.0
    term_re = 0.5 * square
    term_im = 0.0
    before_re = 0.0
    before_im = 0.0
    total_re = term_re
    total_im = term_im
    size = abs(term_re)
    n = 3.0
    while n < MOST_TERMS and size > NEGLIGIBLE * max(abs(total_re), abs(total_im)):
        # The force's own term, (i w s)**(n - 2) / (n - 2)!.
        force_re, force_im = -phase * force_im / (n - 2.0), phase * force_re / (n - 2.0)
        share = square / (n * (n - 1.0))
        next_re = share * (force_re - stiffness * before_re) - drag * term_re / n
        next_im = share * (force_im - stiffness * before_im) - drag * term_im / n
        # The equation is of third order: two terms in a row may vanish, three not.
        size = abs(next_re) + abs(next_im) + abs(term_re) + abs(term_im)
        size += abs(before_re) + abs(before_im)
        before_re = term_re
        before_im = term_im
        term_re = next_re
        term_im = next_im
        total_re += term_re
        total_im += term_im
        n += 1.0
    return total_re, total_im


@kernel
def near_response(
    law: Law, region: int, j: int, s: float, blow: float, even: float, turn: tuple[float, float]
) -> tuple[float, float]:
    """Return (Re Q_j, Im Q_j) at s with i w_j at, or near, a characteristic root r1.

    Q = [F(r1) - F(r2)] / (r1 - r2) with F(r) = (exp(i w s) - exp(r s)) / (i w - r), and
    F(r1) = exp(r1 s) expm1(gap s) / gap, smooth as the gap closes.
    """
    response = region + 1 + j
    gap_re = law[response, GAP_RE]
    gap_im = law[response, GAP_IM]
    # r1 - r2, and the exponentials of both roots: half their sum, and half their difference.
    apart_re = 2.0 * law[region, RATE] * law[region, OVERDAMPED]
    apart_im = 2.0 * law[region, RATE] - apart_re
    root_re = 0.5 * apart_re * blow
    root_im = 0.5 * apart_im * blow
    if (gap_re * gap_re + gap_im * gap_im) * s * s > 1.0:
        near_re, near_im = quotient(turn[0] - even - root_re, turn[1] - root_im, gap_re, gap_im)
    else:
        # exp(r1 s) times (exp(gap s) - 1) / gap, or s where the gap is closed.
        _, half = cosine_sine(0.5 * gap_im * s)
        cosine, sine = cosine_sine(gap_im * s)
        grow = exponential_less_one(gap_re * s)
        top_re = grow * cosine - 2.0 * half * half
        top_im = (1.0 + grow) * sine
        mean_re = s
        mean_im = 0.0
        if gap_re != 0.0 or gap_im != 0.0:
            mean_re, mean_im = quotient(top_re, top_im, gap_re, gap_im)
        near_re = (even + root_re) * mean_re - root_im * mean_im
        near_im = (even + root_re) * mean_im + root_im * mean_re
    # i w - r2 = (i w - r1) + (r1 - r2).
    far_re, far_im = quotient(
        turn[0] - even + root_re, turn[1] + root_im, gap_re + apart_re, gap_im + apart_im
    )
    return quotient(near_re - far_re, near_im - far_im, apart_re, apart_im)


@kernel
def quotient(a_re: float, a_im: float, b_re: float, b_im: float) -> tuple[float, float]:
    """Return the real and the imaginary part of a / b."""
    square = b_re * b_re + b_im * b_im
    return (a_re * b_re + a_im * b_im) / square, (a_im * b_re - a_re * b_im) / square
