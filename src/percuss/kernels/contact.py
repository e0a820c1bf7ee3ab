"""The end of a chatter, contact with a wall, and release from it.

A force that is a difference of larger terms, such as 3 - 4 cos t + cos 2t next to t = 0, has no
digits left in doubles where it is below some 1e-15 of them. There it is summed in pairs of doubles
to 1e-28 of its terms (`fine_force`), the doubles of the law and of the instant taken as exact.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import (
    ULP,
    Pair,
    later,
    nearest,
    over,
    plus,
    times,
    two_product,
    two_sum,
)
from percuss.kernels.compile import cold, kernel
from percuss.kernels.flight import force_and_slopes, force_derivative, set_phases
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    FORCE_BOUND,
    KNOT_FORCE,
    KNOT_SLOPE,
    LOWER,
    N_HARMONICS,
    N_KNOTS,
    NUMBER,
    OUTSIDE_FORCE,
    PERIOD,
    QUICKEST,
    SINE,
    TURNS,
    TURNS_LOW,
    UPPER,
    Law,
)
from percuss.kernels.pieces import is_record, knot_entry, knot_time, piece_at
from percuss.kernels.restitution import slow_restitution

# 2 pi less its double.
FINE_TWO_PI = (2.0 * math.pi, 2.449293598294706414e-16)
# Terms of the series of cos and sin up to an eighth of a turn: what is left is below 2**-104.
MOST_TERMS = 27
# Rounding of the force and its derivatives, relative to the sum of their terms and to what the
# rounding of the instant's phase makes of them: 2**-94, a margin for a hundred roundings.
FINE_ROUNDING = 5e-29
# The force's derivatives that its series on a piece is made of; the next one bounds the rest.
ORDERS = 10
# What the pressing force does over a piece: undecided, positive, falling, zero within rounding.
UNDECIDED, PRESSES, FALLS, VANISHES = 0, 1, 2, 3
# Hops are listed until the rest of the chatter lasts this part of the time in which the force
# and the oscillator change, which makes its sum good to 1e-10 of itself ...
CHATTER_LIMIT = 1e-5
# ... and until they are slower than this part of the fastest impact of the run so far.
SLOW = 1e-6
# Force below which its sign is rounding, relative to the sum of its terms.
FORCE_ROUNDING = 8 * ULP
# Derivatives of the force that are evaluated before it counts as identically zero.
LAST_ORDER = 11
# Steps towards a release before the search pauses.
RELEASE_STEPS = 4096
# Pieces of a stretch on which doubles leave the sign of the force open, and halvings to a zero.
FINE_STEPS = 2000
# A zero is simple where the force falls over the time in which its slope may change by so much
# more than the doubt about it: rounding then moves the zero by less than 1e-6 of that time.
SIMPLE_ZERO = 1e6
BISECTIONS = 60


@kernel
def fine_cos_sin(rate: float, rate_low: float, t: float, t_low: float) -> tuple[Pair, Pair]:
    """Return cos and sin of 2 pi (rate + rate_low) (t + t_low) as pairs."""
    product, error = two_product(rate, t)
    quarter = nearest(4.0 * product)
    phase = two_sum(product - 0.25 * quarter, error)
    phase = plus(phase, two_product(rate, t_low))
    other, other_error = two_product(rate_low, t)
    phase = plus(phase, (other, other_error + rate_low * t_low))
    # At late instants the second part holds whole turns as well.
    more = nearest(4.0 * phase[0])
    phase = plus(phase, (-0.25 * more, 0.0))
    turned = (int(quarter) + int(more)) & 3
    angle = times(FINE_TWO_PI, phase)
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
        if is_record(law, j):
            total = plus(total, fine_record(law, instant, order))
            continue
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
        omega = times(FINE_TWO_PI, (law[harmonic, TURNS], law[harmonic, TURNS_LOW]))
        for _ in range(order):
            part = times(part, omega)
        total = plus(total, part)
    return total[0] + total[1]


@kernel
def fine_record(law: Law, instant: Pair, order: int) -> Pair:
    """Return the derivative of that order of the record's force as a pair."""
    k, turn = piece_at(law, instant[0], instant[1])
    if order > 1 or k < 0:
        return (law[0, OUTSIDE_FORCE] if order == 0 else 0.0), 0.0
    slope = knot_entry(law, k, KNOT_SLOPE)
    if order == 1:
        return slope, 0.0
    begin = knot_time(law, k, turn)
    since = plus(instant, (-begin[0], -begin[1]))
    return plus((knot_entry(law, k, KNOT_FORCE), 0.0), times((slope, 0.0), since))


@kernel
def fine_tolerance(law: Law, force: float, instant: Pair, order: int) -> float:
    """Return a bound on the rounding of `fine_force`."""
    size = law[0, FORCE_BOUND + order] + law[0, FORCE_BOUND + order + 1] * abs(instant[0])
    return FINE_ROUNDING * (size + abs(force))


@kernel
def pressing_shape(law: Law, force: float, sign: float, instant: Pair, width: float) -> int:
    """Return what the pressing force -sign * f does from an instant on, for a time ``width``.

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


@kernel
def push(law: Law, force: float, instant: tuple[float, float], phases: Floats) -> float:
    """Return the first derivative of x that is not zero, at rest at the place of ``force``.

    Its sign is the direction in which the mass sets off; 0 for a mass that stays at rest. The
    derivatives of the force decide, since x^(m + 2) = f^(m) as long as all before it vanish. A
    derivative that is lost in the rounding of its terms is computed again in pairs of doubles.
    ``phases`` are those at the ``instant``.
    """
    constant = force
    for order in range(LAST_ORDER):
        value = force_derivative(law, phases, order) + constant
        if abs(value) > FORCE_ROUNDING * (law[0, FORCE_BOUND + order] + abs(constant)):
            return value
        value = fine_force(law, constant, instant, order)
        if abs(value) > fine_tolerance(law, constant, instant, order):
            return value
        constant = 0.0
    return 0.0


@kernel
def chatter_time(
    law: Law,
    region: int,
    side: float,
    speed: float,
    fastest: float,
    force: float,
    phases: Floats,
) -> tuple[float, float]:
    """Return (time left to the accumulation, error bound) of a chatter, (-1, 0) if it is none."""
    if speed > SLOW * fastest:
        return -1.0, 0.0
    return sum_of_hops(law, region, side, speed, force, phases)


@cold
def sum_of_hops(
    law: Law, region: int, side: float, speed: float, force: float, phases: Floats
) -> tuple[float, float]:
    """Return what `chatter_time` does, of hops that are slow beside the impacts before them.

    With p the force towards the wall, q = speed / p and e = -(p' / p + a), hops last
    2 q (1 + 2 e q / 3) and send q to r q (1 + 4 e q / 3), to second order; the sum is

        T = tau (1 + e tau / 3),   tau = 2 q / (1 - r).

    A restitution r + r' u of slow impacts makes it longer by tau r' u / (1 - r^2). It holds if
    over 2 tau the force keeps its sign, which its derivatives' bounds prove, and the first hop
    meets nothing else (docs/theory/chatter.md). ``side`` is -1 at a wall below and +1 at one above.
    """
    bound = int(law[region, NUMBER]) + (1 if side > 0.0 else 0)
    restitution, bend = slow_restitution(law, region, bound, speed)
    if restitution >= 1.0:
        return -1.0, 0.0
    harmonic, slope, _ = force_and_slopes(law, phases)
    pressing = side * (force + harmonic)
    if pressing <= 0.0:
        return -1.0, 0.0
    tau = 2.0 * speed / (pressing * (1.0 - restitution))
    change = side * slope / pressing
    pace = max(abs(change), math.sqrt(law[0, FORCE_BOUND + 2] / pressing))
    pace = max(pace, law[region, QUICKEST])
    gap = law[region, UPPER] - law[region, LOWER]
    spread = abs(bend) * speed / (1.0 - restitution)
    if tau * pace + spread > CHATTER_LIMIT or speed * speed > pressing * gap:
        return -1.0, 0.0
    tilt = -(change + law[region, DAMPING])
    error = tau * (tau * pace + 2.0 * spread) ** 2 + 4.0 * ULP * tau
    # The force is a difference of terms that may be far larger.
    error += FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND]) / pressing * tau
    longer = bend * speed / (1.0 - restitution * restitution)
    return tau * (1.0 + (tilt * tau / 3.0 + longer)), error


@kernel
def release_time(
    law: Law,
    sign: float,
    force: float,
    instant: tuple[float, float],
    begin: float,
    longest: float,
    phases: Floats,
) -> tuple[bool, float, float]:
    """Return (True, time, free) of a contact's release, or (False, time before it, 0).

    The contact began at ``instant`` and is known to last up to ``begin``. Each step stays where
    the force towards the wall is positive by the bound of its second derivative. It releases
    where it changes sign, not where it touches zero. Where doubles leave the sign open, pairs of
    doubles decide (`fine_release`); ``free`` is then a time after the release over which the
    wall is known to pull. ``phases`` is scratch; ``sign`` is +1 for a wall below and -1 for one
    above.
    """
    bend = law[0, FORCE_BOUND + 2]
    tolerance = FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND])
    steep = FORCE_ROUNDING * law[0, FORCE_BOUND + 1]
    # In contact for ever. A force whose maximum is zero within rounding is searched over a period,
    # if it has one.
    most = sign * force + law[0, FORCE_BOUND]
    if most < -tolerance or (most <= 0.0 and law[0, PERIOD] == 0.0):
        return False, math.inf, 0.0
    s = begin
    for _ in range(RELEASE_STEPS):
        if s > longest:
            break
        if law[0, PERIOD] > 0.0 and s > 1.01 * law[0, PERIOD]:
            return False, math.inf, 0.0
        t, t_low = later(instant[0], instant[1], s)
        set_phases(law, t, t_low, phases)
        harmonic, slope, _ = force_and_slopes(law, phases)
        pressing = -sign * (force + harmonic)
        slope = -sign * slope
        # Where the force falls by more than the tolerance in one ulp of s, that ulp decides.
        doubt = tolerance + abs(slope) * ULP * s
        if pressing > doubt and bend == 0.0:
            # Under a record alone the force is linear up to the next knot.
            s = s - pressing / slope if slope < 0.0 else longest + max(longest, 1.0)
            if s > longest:
                break
            return True, s, 0.0
        if pressing > doubt:
            # Divided first: the squares of small forces would underflow.
            back = slope / bend
            root = math.sqrt(back * back + 2.0 * (pressing / bend))
            if slope < 0.0 and law[0, N_KNOTS] > 0.0:
                # Of a record it may be so steep that the difference would be nothing.
                s += 2.0 * (pressing / bend) / (root - back)
            else:
                s += back + root
            continue
        # The slope keeps its sign to the zero and as far beyond as doubles leave it open.
        back = slope / bend if bend > 0.0 else math.inf
        room = (abs(pressing) + tolerance) / bend if bend > 0.0 else 0.0
        if slope < -steep and back * back > SIMPLE_ZERO * room:
            return True, max(begin, s - pressing / slope), 0.0
        # Some time later in any case: as far as doubles would not see a force that touches zero.
        least = s
        if bend > 0.0 or law[0, N_KNOTS] == 0.0:
            least = s + math.sqrt(8.0 * (tolerance / bend))
        released, s, free = fine_release(law, sign, force, instant, s, longest, doubt)
        if released or s > longest:
            return released, s, free
        s = max(s, least)
    return False, s, 0.0


@kernel
def fine_release(
    law: Law,
    sign: float,
    force: float,
    instant: tuple[float, float],
    s: float,
    longest: float,
    doubt: float,
) -> tuple[bool, float, float]:
    """Go on from s as `release_time` does, where the pressing force is within ``doubt`` of zero.

    The stretch is cut into pieces on which the force provably presses, or falls and so has one
    zero at most, or vanishes within the rounding of pairs of doubles. Returns as soon as doubles
    decide the sign again, with the time up to which there is no release.
    """
    width = quiet_time(law)
    for _ in range(FINE_STEPS):
        if s > longest:
            break
        now = later(instant[0], instant[1], s)
        pressing = -sign * fine_force(law, force, now, 0)
        if pressing > 2.0 * doubt:
            break
        if pressing < -fine_tolerance(law, force, now, 0):
            return True, s, pulling_time(law, sign, force, now)
        shape = pressing_shape(law, force, sign, now, width)
        if shape == UNDECIDED and width > 8.0 * ULP * s:
            width *= 0.5
            continue
        then = later(instant[0], instant[1], s + width)
        end = -sign * fine_force(law, force, then, 0)
        if shape not in (PRESSES, VANISHES) and end < -fine_tolerance(law, force, then, 0):
            right = s + width
            s, free = fine_zero(law, sign, force, instant, s, right)
            return True, s, free
        s += width
        width *= 2.0
    return False, s, 0.0


@kernel
def quiet_time(law: Law) -> float:
    """Return a time over which the force changes little, to begin with."""
    slope = law[0, FORCE_BOUND + 1]
    return law[0, FORCE_BOUND] / slope if slope > 0.0 else 1.0


@kernel
def fine_zero(
    law: Law, sign: float, force: float, instant: tuple[float, float], left: float, right: float
) -> tuple[float, float]:
    """Return the zero of the force between two times, by bisection, and the time left after it."""
    end = right
    for _ in range(BISECTIONS):
        middle = 0.5 * (left + right)
        if not left < middle < right:
            break
        if -sign * fine_force(law, force, later(instant[0], instant[1], middle), 0) > 0.0:
            left = middle
        else:
            right = middle
    return right, end - right


@kernel
def pulling_time(law: Law, sign: float, force: float, instant: tuple[float, float]) -> float:
    """Return a time over which the wall provably pulls from an instant on.

    Where none is proven it is the last and tiny width, after which no departure is sought.
    """
    width = quiet_time(law)
    for _ in range(BISECTIONS):
        if pressing_shape(law, force, -sign, instant, width) == PRESSES:
            return width
        if pressing_shape(law, force, sign, instant, width) == FALLS:
            return width
        width *= 0.5
    return width
