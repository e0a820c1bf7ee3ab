"""The motion between two events in closed form, and bounds on its derivatives.

A flight is given by its region, its start (an instant, a velocity, the constant force there) and
the displacement y from where it starts. Measured from the start, a hop far below one ulp of x is
resolved. In every linear regime

    y(s) = v S(s) + g D(s) + sum_j Re[ (force phasor)_j Q_j(s) ] + h E(s),

where with the characteristic roots r1, r2 and divided differences of the exponential

    S = s exp[r1 s, r2 s],   D = s^2 exp[r1 s, r2 s, 0],   Q = s^2 exp[r1 s, r2 s, i w s],
    E = s^3 exp[r1 s, r2 s, 0, 0],

with the slope h of the record in the law, whose force at the start is a part of g (`pieces`).
These are entire functions of all their arguments: critical damping, k = 0 and resonance are
special cases of their evaluation only. Each function below takes the form that loses no digits
where it is used (docs/theory/flight.md).
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from percuss.arrays import Floats
from percuss.kernels.arithmetic import (
    ULP,
    Pair,
    cos_sin,
    cosine_sine,
    exponential,
    exponential_less_one,
    exponentials,
    hypotenuse,
)
from percuss.kernels.compile import cold, formula, kernel
from percuss.kernels.law_columns import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    GAP_IM,
    GAP_RE,
    GROWTH,
    HALF_TURNS,
    HALF_TURNS_LOW,
    LOWER,
    LOWER_FORCE,
    NEAR,
    NUMBER,
    OMEGA,
    ORIGIN,
    ORIGIN_FORCE,
    OVERDAMPED,
    PER_STIFFNESS,
    QUICKEST,
    RATE,
    SINE,
    SLOW_ROOT,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    TWICE_PER_RATE,
    UPPER,
    UPPER_FORCE,
    Law,
)
from percuss.kernels.pieces import is_record, next_knot, record_at, time_to_knot

# Below this phase the power series is used: there the closed forms lose digits to cancellation,
# and above it the series needs more than its terms.
SERIES_LIMIT = 0.5
# With abs(rate * s) <= 1/2 the terms from here on are below 0.5**18 / 18! of the sum.
MOST_TERMS = 20.0
NEGLIGIBLE = 1e-18
# The response to a slope cancels more in its closed forms, and its series less.
SLOPE_SERIES_LIMIT = 3.0
MOST_SLOPE_TERMS = 60.0
# Its rounding, relative to it, in terms of that of the other responses.
SLOPE_TERMS = 4.0
# The start of a flight: (t, t_low, velocity, constant force).
FlightStart: TypeAlias = tuple[float, float, float, float]
# Relative error allowed for each term of a flight: the sum of the roundings in S, D, Q_j and in
# the velocity and forces they multiply (docs/theory/first-event.md counts them).
ROUNDING = 16 * ULP


class Flight(NamedTuple):
    """A flight: its law, the row of its region, its start and the phases there.

    ``phases`` (n_harmonics, 2) are cos and sin of w_j t at the start. ``arrival``, of the same
    shape, is scratch: it receives the phases at the time last evaluated.
    """

    law: Law
    region: int
    start: FlightStart
    phases: Floats
    arrival: Floats


@kernel
def free_response(law: Law, region: int, s: float) -> tuple[float, float, float]:
    """Return (S, c, D) at s: the responses to a unit impulse and a unit force, c = S' + a S.

    S'' + 2 a S' + K S = 0 with S(0) = 0, S'(0) = 1; c is exp(-a s) cos(RATE s) or its hyperbolic
    form, so that S' = c - a S; D is the integral of S.
    """
    damping = law[region, DAMPING]
    rate = law[region, RATE]
    if law[region, OVERDAMPED] == 1.0:
        slow = exponential(law[region, SLOW_ROOT] * s)
        shrink = exponential_less_one(-2.0 * rate * s)
        impulse = slow * (-shrink) / (2.0 * rate)
        even = slow * (1.0 + 0.5 * shrink)
        if law[region, QUICKEST] * s < SERIES_LIMIT:
            first = 0.5 * s * s
            force = response_series(damping, law[region, STIFFNESS], s, first, 3.0, MOST_TERMS)
        elif are_apart(law[region, SLOW_ROOT], law[region, FAST_ROOT]):
            slow_part = mean_of_exponential(law[region, SLOW_ROOT], s)
            fast_part = mean_of_exponential(law[region, FAST_ROOT], s)
            force = (slow_part - fast_part) / (2.0 * rate)
        else:
            force = (1.0 - even - damping * impulse) * law[region, PER_STIFFNESS]
        return impulse, even, force
    shrink = 1.0
    lost = 0.0
    if damping != 0.0:
        shrink, lost = exponentials(-damping * s)
    if rate == 0.0:
        impulse = shrink * s
        even = shrink
        square = 0.0
    else:
        half_cos, half_sin = cos_sin(law[region, HALF_TURNS], law[region, HALF_TURNS_LOW], s, 0.0)
        square = 2.0 * half_sin * half_sin
        impulse = shrink * half_sin * half_cos * law[region, TWICE_PER_RATE]
        # Of the two forms the one whose square is the small one.
        even = shrink * (1.0 - square if square < 1.0 else 2.0 * half_cos * half_cos - 1.0)
    if law[region, QUICKEST] * s < SERIES_LIMIT:
        first = 0.5 * s * s
        force = response_series(damping, law[region, STIFFNESS], s, first, 3.0, MOST_TERMS)
    elif damping == 0.0:
        force = square * law[region, PER_STIFFNESS]
    else:
        # 1 - even, without the cancellation of small damping near a whole period.
        force = (shrink * square - lost - damping * impulse) * law[region, PER_STIFFNESS]
    return impulse, even, force


@kernel
def are_apart(one: float, other: float) -> bool:
    """Return whether one of two roots is less than half as large as the other."""
    return min(abs(one), abs(other)) < 0.5 * max(abs(one), abs(other))


@kernel
def mean_of_exponential(root: float, s: float) -> float:
    """Return the integral of exp(root s) from 0 to s."""
    return exponential_less_one(root * s) / root if root != 0.0 else s


@kernel
def response_series(
    damping: float, stiffness: float, s: float, first: float, n: float, most: float
) -> float:
    """Return by its power series, for small s, what repeated integration makes of S.

    ``first`` is its first term, s^(n - 1) / (n - 1)!: n = 3 gives D(s), n = 4 its integral E(s).
    """
    drag = 2.0 * damping * s
    spring = stiffness * s * s
    before = 0.0
    term = first
    total = term
    while n < most and abs(term) + abs(before) > NEGLIGIBLE * abs(total):
        following = -(drag * term + spring * before / (n - 1.0)) / n
        before = term
        term = following
        total += term
        n += 1.0
    return total


@cold
def slope_response(law: Law, region: int, s: float, impulse: float, rise: float) -> float:
    """Return E(s), the response to a force of slope 1: the integral of D.

    ``impulse`` and ``rise`` are S(s) and D(s).
    """
    damping = law[region, DAMPING]
    stiffness = law[region, STIFFNESS]
    slow = law[region, SLOW_ROOT]
    fast = law[region, FAST_ROOT]
    if law[region, QUICKEST] * s < SLOPE_SERIES_LIMIT:
        return response_series(damping, stiffness, s, s * s * s / 6.0, 4.0, MOST_SLOPE_TERMS)
    if law[region, OVERDAMPED] == 1.0 and are_apart(slow, fast):
        return (twice_integrated(slow, s) - twice_integrated(fast, s)) / (2.0 * law[region, RATE])
    # S + 2 a D + K E = s, the equation of D integrated: elsewhere it would lose digits.
    return (s - impulse - 2.0 * damping * rise) * law[region, PER_STIFFNESS]


@kernel
def twice_integrated(root: float, s: float) -> float:
    """Return (exp(r s) - 1 - r s) / r^2: exp(r s) integrated twice from 0."""
    exponent = root * s
    if abs(exponent) >= SERIES_LIMIT:
        return (exponential_less_one(exponent) - exponent) / (root * root)
    term = 0.5 * s * s
    total = term
    n = 3.0
    while n < MOST_TERMS and abs(term) > NEGLIGIBLE * total:
        term *= exponent / n
        total += term
        n += 1.0
    return total


@formula
def harmonic_response(
    law: Law, region: int, j: int, s: float, impulse: float, even: float, turn: tuple[float, float]
) -> tuple[float, float]:
    """Return (Re Q_j, Im Q_j) at s: the responses to cos(w_j s) and to sin(w_j s).

    ``impulse`` and ``even`` are S(s) and c(s); ``turn`` is (cos, sin) of w_j s.
    """
    omega = law[FIRST_HARMONIC + j, OMEGA]
    response = region + 1 + j
    if max(law[region, QUICKEST], omega) * s < SERIES_LIMIT:
        return harmonic_series(law[region, DAMPING], law[region, STIFFNESS], omega, s)
    if law[response, NEAR] == 1.0:
        return near_response(law, region, j, s, impulse, even, turn)
    over_re = turn[0] - even - law[region, DAMPING] * impulse
    over_im = turn[1] - omega * impulse
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


@formula
def near_response(
    law: Law, region: int, j: int, s: float, impulse: float, even: float, turn: tuple[float, float]
) -> tuple[float, float]:
    """Return (Re Q_j, Im Q_j) at s with i w_j at, or near, a characteristic root r1.

    Of two real roots r1 is that of the smaller size, with negative damping the smaller one.
    Q = [F(r1) - F(r2)] / (r1 - r2) with F(r) = (exp(i w s) - exp(r s)) / (i w - r), and
    F(r1) = exp(r1 s) expm1(gap s) / gap, smooth as the gap closes.
    """
    response = region + 1 + j
    gap_re = law[response, GAP_RE]
    gap_im = law[response, GAP_IM]
    # r1 - r2, and the exponentials of both roots: half their sum, and half their difference.
    apart_re = 2.0 * law[region, RATE] * law[region, OVERDAMPED]
    apart_im = 2.0 * law[region, RATE] - apart_re
    near_power = even + 0.5 * apart_re * impulse
    if apart_re > 0.0 and law[region, DAMPING] < 0.0:
        apart_re = -apart_re
        near_power = exponential(law[region, FAST_ROOT] * s)
    root_re = 0.5 * apart_re * impulse
    root_im = 0.5 * apart_im * impulse
    if (gap_re * gap_re + gap_im * gap_im) * s * s > 1.0:
        near_re, near_im = quotient(turn[0] - near_power, turn[1] - root_im, gap_re, gap_im)
    else:
        # exp(r1 s) times (exp(gap s) - 1) / gap, or s where the gap is closed.
        mean_re = s
        mean_im = 0.0
        if gap_re != 0.0 or gap_im != 0.0:
            _, half = cosine_sine(0.5 * gap_im * s)
            cosine, sine = cosine_sine(gap_im * s)
            grow = exponential_less_one(gap_re * s)
            top_re = grow * cosine - 2.0 * half * half
            top_im = (1.0 + grow) * sine
            mean_re, mean_im = quotient(top_re, top_im, gap_re, gap_im)
        near_re = near_power * mean_re - root_im * mean_im
        near_im = near_power * mean_im + root_im * mean_re
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


@kernel
def place(law: Law, region: int, bound: int) -> float:
    """Return the position of a bound of a region."""
    return law[region, LOWER if bound == int(law[region, NUMBER]) else UPPER]


@kernel
def constant_force(law: Law, region: int, x: float) -> float:
    """Return G - K x: the constant force at x, without cancellation at the region's bounds."""
    if x == law[region, LOWER]:
        return law[region, LOWER_FORCE]
    if x == law[region, UPPER]:
        return law[region, UPPER_FORCE]
    return law[region, ORIGIN_FORCE] - law[region, STIFFNESS] * (x - law[region, ORIGIN])


@kernel
def set_phases(law: Law, t: float, t_low: float, phases: Floats) -> None:
    """Write cos and sin of w_j (t + t_low), or force and slope of a record, into ``phases``."""
    n = phases.shape[0]
    # A record has the last row: in a loop with its call all constants would be kept at hand.
    has_record = n > 0 and is_record(law, n - 1)
    for j in range(n - 1 if has_record else n):
        harmonic = FIRST_HARMONIC + j
        cosine, sine = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], t, t_low)
        phases[j, 0] = cosine
        phases[j, 1] = sine
    if has_record:
        phases[n - 1, 0], phases[n - 1, 1] = record_at(law, t, t_low)


@formula
def parts_of(law: Law, harmonic: int, cosine: float, sine: float) -> Pair:
    """Return the two parts of a harmonic, by its row, where its phase has this cosine and sine.

    They are A cos + B sin and B cos - A sin: the harmonic, and its derivative by the phase.
    """
    return (
        law[harmonic, COSINE] * cosine + law[harmonic, SINE] * sine,
        law[harmonic, SINE] * cosine - law[harmonic, COSINE] * sine,
    )


@kernel
def force_derivative(law: Law, phases: Floats, order: int) -> float:
    """Return the derivative of that order of the harmonic force, at the instant of ``phases``."""
    total = 0.0
    for j in range(phases.shape[0]):
        if order > 1 and is_record(law, j):
            continue
        harmonic = FIRST_HARMONIC + j
        part, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        # A derivative turns the phasor (part, quadrature) by a quarter and scales it by w.
        turned = quadrature if order & 1 else part
        scale = 1.0
        for _ in range(order):
            scale *= law[harmonic, OMEGA]
        total += -scale * turned if order & 2 else scale * turned
    return total


@kernel
def force_and_slopes(law: Law, phases: Floats) -> tuple[float, float, float]:
    """Return the harmonic force and its first two derivatives at the instant of ``phases``."""
    force = 0.0
    slope = 0.0
    bend = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        part, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        omega = law[harmonic, OMEGA]
        force += part
        slope += omega * quadrature
        if omega > 0.0:
            bend -= omega * omega * part
    return force, slope, bend


@formula
def move(flight: Flight, s: float) -> tuple[float, float]:
    """Return (y, v) a time s after the start; ``flight.arrival`` receives the phases there."""
    law, region, start, phases, arrival = flight
    _, _, v0, force = start
    if v0 == 0.0 and force == 0.0 and phases.shape[0] == 0:
        # At rest, also where what would move from there grows beyond all numbers.
        return 0.0, 0.0
    impulse, even, rise = free_response(law, region, s)
    # The terms of the forces are summed first: a rounding of the larger whole would stay in it.
    y = force * rise
    v = force * impulse - v0 * law[region, DAMPING] * impulse
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cos0 = phases[j, 0]
        sin0 = phases[j, 1]
        if is_record(law, j):
            arrival[j, 0] = cos0 + sin0 * s
            arrival[j, 1] = sin0
            y += cos0 * rise + sin0 * slope_response(law, region, s, impulse, rise)
            v += cos0 * impulse + sin0 * rise
            continue
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        arrival[j, 0] = cos0 * turn[0] - sin0 * turn[1]
        arrival[j, 1] = sin0 * turn[0] + cos0 * turn[1]
        to_cos, to_sin = harmonic_response(law, region, j, s, impulse, even, turn)
        in_phase, quadrature = parts_of(law, harmonic, cos0, sin0)
        y += in_phase * to_cos + quadrature * to_sin
        # Q' = S + i w Q.
        omega = law[harmonic, OMEGA]
        v += in_phase * (impulse - omega * to_sin) + quadrature * omega * to_cos
    return v0 * impulse + y, v0 * even + v


@kernel
def move_over_knots(flight: Flight, s: float) -> tuple[float, float]:
    """Return (y, v) as `move` does, a time s after the start, over any knots of a record."""
    law, region, start, _, arrival = flight
    t, t_low, v, force = start
    y = 0.0
    left = s
    piece = flight
    to_knot = time_to_knot(law, t, t_low)
    while to_knot < left:
        moved, v = move(piece, to_knot)
        y += moved
        t, t_low = next_knot(law, t, t_low)
        left = s - ((t - start[0]) + (t_low - start[1]))
        set_phases(law, t, t_low, arrival)
        # Phases may be read and written in one array: each is read before it is written.
        pull = force - law[region, STIFFNESS] * y
        piece = Flight(law, region, (t, t_low, v, pull), arrival, arrival)
        to_knot = time_to_knot(law, t, t_low)
    moved, v = move(piece, left)
    return y + moved, v


@kernel
def uncertainty(flight: Flight, s: float) -> float:
    """Return a bound on the rounding error of the displacement a time s after the start.

    It is the error of evaluation and that of a relative rounding of the starting velocity and of
    each force, which no later step can undo.
    """
    return uncertainties(flight, s)[0]


@kernel
def uncertainties(flight: Flight, s: float) -> tuple[float, float]:
    """Return bounds on the rounding errors of displacement and velocity (see `uncertainty`)."""
    law, region = flight.law, flight.region
    size, speed = sizes(flight, s)
    rounding = ROUNDING * growth_of_rounding(law, region, s)
    return size * rounding, speed * rounding


@kernel
def growth_of_rounding(law: Law, region: int, s: float) -> float:
    """Return the factor of rounding of a growing exponential, whose exponent is rounded too."""
    return 1.0 + max(0.0, law[region, GROWTH] * s) / 16.0


@kernel
def harmonic_size(law: Law, region: int, j: int, s: float, impulse: float, even: float) -> float:
    """Return the sum of the magnitudes of the terms of Q_j at s, the response to a unit harmonic.

    No response to a bounded force exceeds the one to its bound while S >= 0, and that is less than
    twice as large where negative damping makes it grow.
    """
    omega = law[FIRST_HARMONIC + j, OMEGA]
    response = region + 1 + j
    damping = abs(law[region, DAMPING])
    limit = s * s if law[region, DAMPING] < 0.0 else 0.5 * s * s
    if s * max(law[region, QUICKEST], omega) >= SERIES_LIMIT:
        terms = 1.0 + abs(even) + (damping + omega) * abs(impulse)
        limit = terms * (abs(law[response, GAIN_RE]) + abs(law[response, GAIN_IM]))
        if law[response, NEAR] == 1.0:
            # What is near the root is built up for a time s, with damping for that of the gap.
            gap = hypotenuse(law[response, GAP_RE], law[response, GAP_IM])
            lasts = min(s, 2.0 / gap) if gap > 0.0 else s
            built = max(1.0, abs(even) + law[region, RATE] * abs(impulse))
            # The other root is no nearer than omega, and of two real ones than half their distance.
            other = max(omega, law[region, RATE] * law[region, OVERDAMPED])
            limit = lasts * built / law[region, RATE] + terms / other**2
    return limit


@kernel
def sizes(flight: Flight, s: float) -> tuple[float, float]:
    """Return the sums of the magnitudes of the terms of y and of v a time s after the start."""
    law, region, start, phases, _ = flight
    _, _, v0, force = start
    impulse, even, rise = free_response(law, region, s)
    size = abs(v0 * impulse) + abs(force * rise)
    damping = abs(law[region, DAMPING])
    speed = abs(v0) * (abs(even) + damping * abs(impulse)) + abs(force * impulse)
    n = phases.shape[0]
    for j in range(n):
        omega = law[FIRST_HARMONIC + j, OMEGA]
        if omega < 0.0:
            push = law[FIRST_HARMONIC + j, AMPLITUDE]
            slope = SLOPE_TERMS * abs(phases[j, 1])
            size += push * abs(rise) + slope * slope_response(law, region, s, impulse, rise)
            speed += push * abs(impulse) + slope * abs(rise)
            continue
        limit = harmonic_size(law, region, j, s, impulse, even)
        size += law[FIRST_HARMONIC + j, AMPLITUDE] * limit
        # Q' = S + i w Q.
        speed += law[FIRST_HARMONIC + j, AMPLITUDE] * (abs(impulse) + omega * limit)
    return size, speed


@kernel
def acceleration_and_jerk(
    law: Law, region: int, force: float, phases: Floats, y: float, v: float
) -> tuple[float, float]:
    """Return x'' and x''' at displacement y and velocity v, at the instant of ``phases``."""
    pull = 0.0
    slope = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        part, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        pull += part
        slope += law[harmonic, OMEGA] * quadrature
    second = force + pull - 2.0 * law[region, DAMPING] * v - law[region, STIFFNESS] * y
    third = slope - 2.0 * law[region, DAMPING] * second - law[region, STIFFNESS] * v
    return second, third


@formula
def four_derivatives(
    law: Law, region: int, force: float, phases: Floats, y: float, v: float
) -> tuple[float, float, float, float]:
    """Return the second to the fifth derivative of x, as `acceleration_and_jerk` does two."""
    pull = 0.0
    slope = 0.0
    bend = 0.0
    twist = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        omega = law[harmonic, OMEGA]
        part, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        pull += part
        slope += omega * quadrature
        if omega > 0.0:
            bend -= omega * omega * part
            twist -= omega * omega * omega * quadrature
    drag = 2.0 * law[region, DAMPING]
    second = force + pull - drag * v - law[region, STIFFNESS] * y
    third = slope - drag * second - law[region, STIFFNESS] * v
    fourth = bend - drag * third - law[region, STIFFNESS] * second
    fifth = twist - drag * fourth - law[region, STIFFNESS] * third
    return second, third, fourth, fifth


@kernel
def derivative_bound(
    law: Law, region: int, force_bound: float, lower: float, upper: float, s: float
) -> float:
    """Return a bound on abs(x^(m + 2)) over the next s, given x^(m) and x^(m + 1), m >= 1.

    Both obey the equation of motion with the force's m-th derivative, bounded by ``force_bound``,
    in place of the force, and their energy, or where K < 0 their norm, grows no faster than that,
    or with negative damping by the factor that the bounds hold
    (docs/theory/first-event.md). Valid for s up to one step of the region.
    """
    return (
        force_bound
        + law[region, BOUND_OF_X] * abs(lower)
        + law[region, BOUND_OF_V] * (abs(upper) + s * force_bound)
    )
