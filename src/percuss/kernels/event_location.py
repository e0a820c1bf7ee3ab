"""Where a flight first meets a bound: the first root of its clearance, with proof.

A stretch is cut until on each piece the clearance is provably positive, or provably has at most
one zero or one turning point, which is then computed. The bounds are Taylor's theorem with the
remainder of `derivative_bound`; docs/theory/first-event.md has the proof.

A motion may meet a wall with a velocity of exactly zero while the force turns against it. The
rounding of that velocity would bounce for ever: `rest_at_landing` recognises such a landing and
takes its instant from the derivatives of the flight (docs/theory/first-event.md, section 7).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.kernels.arithmetic import ULP, Pair
from percuss.kernels.compile import formula, kernel
from percuss.kernels.contact import FORCE_ROUNDING
from percuss.kernels.flight import (
    ROUNDING,
    Flight,
    FlightStart,
    acceleration_and_jerk,
    derivative_bound,
    force_derivative,
    four_derivatives,
    free_response,
    move,
    uncertainties,
    uncertainty,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FORCE_BOUND,
    GROWTH,
    QUICKEST,
    STEP,
    STIFFNESS,
    Law,
)

# The last correction is made with the series alone when it is this small a phase.
SMALL_PHASE = 3e-4
MAX_ITERATIONS = 80
# Verdicts; int64, so that a `Root` has one type.
NONE, HIT, GRAZE = (np.int64(verdict) for verdict in range(3))
# Shapes of the clearance on a piece.
UNKNOWN, CLEAR, ONE_ZERO, ONE_MINIMUM, FLAT = 0, 1, 2, 3, 4
# Pieces of one stretch.
MOST_PIECES = 10_000
# A departure is decided by its first derivative that is not zero, up to this order.
LAST_ORDER = 12
# The terms of a closed form are at most so many times v0 s + (force) s^2, for K >= 0.
MOST_OF_TERMS = 1024.0
# Newton's steps to where the velocity or the acceleration is zero, and halvings to where the
# clearance leaves its doubt.
NEWTON_STEPS = 8
DOUBLINGS = 200
HALVINGS = 40


class Root(NamedTuple):
    """What a search for the first root of a clearance has found, up to the time s.

    ``value`` is the velocity of a HIT, or the clearance of a GRAZE, and ``rest`` what is to be
    added to the s of a HIT unrounded, or the rounding bound of that clearance. ``free`` is the time
    up to which there is no further root.
    """

    verdict: np.int64
    s: float
    value: float
    rest: float
    free: float


@kernel
def locate_root(
    flight: Flight,
    bound: Pair,
    bracket: tuple[float, float, float],
) -> tuple[float, float, float]:
    """Return (s, v, s_low) where the clearance sign * (y - distance) falls to zero.

    The root is s + s_low: a float alone would leave the mass off the bound by v times its rounding.

    ``bound`` is (sign, distance) and ``bracket`` (left, right, guess): positive at the left, not
    positive at the right, one root between. ``flight.arrival`` is scratch.
    """
    law, region, start, _, arrival = flight
    sign, distance = bound
    left, right, s = bracket
    force = start[3]
    v = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(flight, s)
        clearance = sign * (y - distance)
        if clearance > 0.0:
            left = s
        else:
            right = s
        second, third, fourth, fifth = four_derivatives(law, region, force, arrival, y, v)
        step = series_root(clearance, sign * v, sign * second, sign * third, sign * fourth)
        if left <= s + step <= right:
            sixth = derivative_bound(law, region, law[0, FORCE_BOUND + 4], fourth, fifth, 0.0)
            end = s + step
            settled = is_settled(
                law[region, QUICKEST], step, s, v, (second, third, fourth, fifth, sixth)
            )
            # A step is rounded to its own size: one longer than the flight would leave that in it.
            if settled and abs(step) <= end:
                bend = third * 0.5 + step * (fourth * (1.0 / 6.0) + step * fifth * (1.0 / 24.0))
                return end, v + step * (second + step * bend), step - (end - s)
            s = end
        else:
            middle = 0.5 * (left + right)
            if not left < middle < right:
                break
            s = middle
    return s, v, 0.0


@formula
def within_bracket(s: float, left: float, right: float) -> float:
    """Return a guess if it lies in a bracket, else the middle, which has no room in a narrow one."""
    return s if left < s < right else 0.5 * (left + right)


@formula
def is_settled(
    quickest: float,
    step: float,
    s: float,
    v: float,
    derivatives: tuple[float, float, float, float, float],
) -> bool:
    """Return whether the series can make the last step to a root without loss.

    ``derivatives`` are the second to the fifth, and a bound of the sixth. The inverse series is
    that of `series_root`: the terms that it leaves out are products of the terms of the second to
    the fourth, which a force may make large in a slow motion, however small the phase is.
    """
    second, third, fourth, fifth, sixth = derivatives
    size = abs(step)
    square = step * step
    missed = (sixth * size + abs(fifth)) * square * square * size
    return size <= 2.0 * ULP * s or (
        size * quickest <= SMALL_PHASE
        and has_small_terms(size, v, second, third, fourth)
        and sixth * square * square * size <= 32.0 * ULP * abs(v)
        and missed <= 32.0 * ULP * abs(v) * s
    )


@formula
def has_small_terms(size: float, v: float, second: float, third: float, fourth: float) -> bool:
    """Return whether the terms of the second to the fourth derivative are small over a step."""
    square = size * size
    small = SMALL_PHASE * abs(v)
    return (
        size * abs(second) <= small
        and square * abs(third) <= SMALL_PHASE * small
        and square * size * abs(fourth) <= SMALL_PHASE * SMALL_PHASE * small
    )


@formula
def series_root(value: float, first: float, second: float, third: float, fourth: float) -> float:
    """Return the root next to 0 of the quartic with these derivatives at 0, to fourth order.

    Far from the root the series may give any step, even zero: where it is not between
    half and twice Newton's step, that is returned.
    """
    if first == 0.0:
        return 0.0 if value == 0.0 else math.inf
    over = 1.0 / first
    q = -value * over
    c2 = 0.5 * second * over
    c3 = third * over * (1.0 / 6.0)
    c4 = fourth * over * (1.0 / 24.0)
    # The series of the inverse function.
    part = 1.0 - q * (c2 - q * (2.0 * c2 * c2 - c3 - q * (5.0 * c2 * (c2 * c2 - c3) + c4)))
    return q * part if 0.5 < part < 2.0 else q


@kernel
def lowest(
    flight: Flight,
    bound: Pair,
    left: float,
    right: float,
) -> tuple[float, float, float]:
    """Return (s, clearance, rounding bound) at the one turning point of a convex stretch."""
    law, region, start, _, arrival = flight
    sign, distance = bound
    force = start[3]
    s = 0.5 * (left + right)
    clearance = second = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(flight, s)
        clearance = sign * (y - distance)
        speed = sign * v
        if speed < 0.0:
            left = s
        else:
            right = s
        second, _ = acceleration_and_jerk(law, region, force, arrival, y, v)
        step = -v / second if second != 0.0 else 0.0
        if abs(step) <= 2.0 * ULP * s:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    # Between two doubles the clearance may be less than at either.
    error = uncertainty(flight, s) + ULP * abs(distance) + 8.0 * abs(second) * (ULP * s) ** 2
    return s, clearance, error


@kernel
def first_root(flight: Flight, bound: Pair, span: Pair) -> Root:
    """Return the first root of the clearance sign * (y - distance), which begins positive.

    ``bound`` is (sign, distance) and ``span`` (left, right). ``flight.arrival`` is scratch.
    """
    law, region, start, _, arrival = flight
    sign, distance = bound
    left, right = span
    if not left < right:
        return Root(NONE, right, 0.0, 0.0, right)
    y, v = move(flight, left)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    doubt = uncertainty(flight, left)
    doubt = 2.0 * max(doubt, uncertainty(flight, right)) + ULP * abs(distance)
    width = right - left
    # Where the clearance was last seen to be positive beyond doubt, or the search began.
    sure = left
    for _ in range(MOST_PIECES):
        width = min(width, right - left)
        fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, width)
        if not fourth < math.inf:
            # Outside the range of floats; the velocity NaN says so.
            return Root(HIT, left, math.nan, 0.0, left)
        gap = sign * (y - distance)
        speed = sign * v
        shape = shape_of(gap, speed, sign * second, sign * third, fourth, width, doubt)
        if shape == UNKNOWN and width > 8.0 * ULP * (left + width):
            width *= 0.5
            continue
        after = left + width
        dips = shape == ONE_MINIMUM and speed <= 0.0
        piece = (left, after)
        foot, y, v = foot_of(flight, bound, piece, dips, doubt)
        end, clearance, error = foot
        if end < after and abs(clearance) <= error:
            return Root(GRAZE, end, clearance, error, after)
        if clearance < -error:
            bracket = (sure, end, 0.5 * (sure + end))
            s, v, s_low = locate_root(flight, bound, bracket)
            return Root(HIT, s, v, s_low, s)
        clearance = sign * (y - distance)
        if shape == CLEAR or clearance > doubt:
            if sure < left and gap <= 0.0:
                return Root(GRAZE, left, gap, doubt, after)
            sure = after
        if after >= right:
            return Root(NONE, right, 0.0, 0.0, right)
        second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        left = after
        width *= 2.0
    # This has never happened; the answer is that nothing is known from here on.
    return Root(GRAZE, left, sign * (y - distance), math.inf, right)


@kernel
def foot_of(
    flight: Flight,
    bound: Pair,
    piece: Pair,
    dips: bool,
    doubt: float,
) -> tuple[tuple[float, float, float], float, float]:
    """Return the decisive point of a piece as (s, clearance, doubt), and (y, v) at its end.

    It is the minimum where the clearance ``dips`` and rises again, to zero within rounding at
    least, otherwise the end. ``bound`` is (sign, distance); ``flight.arrival`` receives the phases
    at the end.
    """
    sign, distance = bound
    left, after = piece
    y, v = move(flight, after)
    clearance = sign * (y - distance)
    if clearance <= 0.0:
        doubt = uncertainty(flight, after) + ULP * abs(distance)
    if dips and sign * v > 0.0 and clearance >= -doubt:
        foot = lowest(flight, bound, left, after)
        y, v = move(flight, after)
        return foot, y, v
    return (after, clearance, doubt), y, v


@kernel
def shape_of(
    gap: float,
    speed: float,
    second: float,
    third: float,
    fourth: float,
    width: float,
    doubt: float,
) -> int:
    """Return what the clearance can do over ``width``, from its derivatives at the left end.

    Each derivative is a polynomial plus a remainder that ``fourth`` bounds; a polynomial lies
    between the least and the greatest of its Bernstein coefficients. FLAT is a clearance that
    stays within ``doubt`` of zero.
    """
    end_second = second + third * width
    middle_speed = speed + 0.5 * second * width
    end_speed = middle_speed + 0.5 * end_second * width
    rise = speed * width
    bend = second * width * width
    end_gap = gap + rise + 0.5 * bend + third * width**3 / 6.0
    least = min(gap, gap + rise / 3.0, gap + 2.0 * rise / 3.0 + bend / 6.0, end_gap)
    if least - fourth * width**4 / 24.0 > doubt:
        return CLEAR
    most = max(
        abs(gap), abs(gap + rise / 3.0), abs(gap + 2.0 * rise / 3.0 + bend / 6.0), abs(end_gap)
    )
    if most + fourth * width**4 / 24.0 <= doubt:
        return FLAT
    slack = fourth * width**3 / 6.0
    if min(speed, middle_speed, end_speed) - slack > 0.0:
        return CLEAR
    if max(speed, middle_speed, end_speed) + slack < 0.0:
        return ONE_ZERO
    slack = 0.5 * fourth * width * width
    if max(second, end_second) + slack < 0.0:
        return ONE_ZERO
    if min(second, end_second) - slack > 0.0:
        return ONE_MINIMUM
    return UNKNOWN


@kernel
def departure(
    flight: Flight,
    sign: float,
    longest: float,
) -> float:
    """Return a time up to which a flight that starts on a bound is free of it, 0 if not at all.

    With m the first derivative that is not zero, the clearance is at least
    s^m / m! (abs(y^(m)) - s / (m + 1) * bound of y^(m+1)). A mass that stays at rest is free for
    ``longest``.
    """
    law, region, start, phases, _ = flight
    _, _, value, force = start
    following, _ = acceleration_and_jerk(law, region, force, phases, 0.0, value)
    for order in range(1, LAST_ORDER):
        if value != 0.0:
            break
        jerk = force_derivative(law, phases, order)
        value, following = (
            following,
            jerk - 2.0 * law[region, DAMPING] * following - law[region, STIFFNESS] * value,
        )
    else:
        return longest
    if sign * value < 0.0:
        return 0.0
    width = longest
    for _ in range(64):
        bound = abs(following) + width * derivative_bound(
            law, region, law[0, FORCE_BOUND + order], value, following, width
        )
        free = 0.9 * (order + 1) * abs(value) / bound if bound > 0.0 else longest
        if free >= width:
            return width
        # A shorter width has a smaller bound: this goes up to the best of the two.
        width = max(free, 0.25 * width)
    return free


@kernel
def is_fast(law: Law, region: int, start: FlightStart, distance: float, s: float, v: float) -> bool:
    """Return whether a landing is beyond doubt an impact, by cheap bounds."""
    if law[region, GROWTH] > 0.0:
        return False
    _, _, v0, force = start
    pull = abs(force) + law[0, FORCE_BOUND]
    terms = MOST_OF_TERMS * ROUNDING
    doubt = terms * s * (abs(v0) + pull * s) + ULP * abs(distance)
    speed = abs(v)
    drag = 2.0 * law[region, DAMPING]
    second = pull + drag * speed + law[region, STIFFNESS] * abs(distance)
    third = law[0, FORCE_BOUND + 1] + drag * second + law[region, STIFFNESS] * speed
    return is_certain(law, region, speed, (second, third), doubt, terms * (abs(v0) + pull * s))


@kernel
def is_certain(
    law: Law,
    region: int,
    speed: float,
    derivatives: tuple[float, float],
    doubt: float,
    doubt_of_speed: float,
) -> bool:
    """Return whether the velocity keeps its sign wherever the clearance is within its doubt.

    Over 2 doubt / speed to both sides the velocity changes by less than half of itself, by the
    magnitudes of the second and third ``derivatives`` and the bound of the fourth.
    """
    second, third = derivatives
    if not speed > 2.0 * doubt_of_speed:
        return False
    width = 2.0 * doubt / speed
    if law[region, GROWTH] > 0.0 and width > law[region, STEP]:
        return False
    fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, width)
    change = width * (second + width * (0.5 * third + width * fourth * (1.0 / 6.0)))
    return 2.0 * change <= speed


@kernel
def rest_at_landing(
    flight: Flight,
    bound: tuple[float, float],
    landed: tuple[float, float],
    longest: float,
) -> tuple[bool, float, tuple[float, float, float]]:
    """Return whether the mass may come to the wall at rest, when, and three errors.

    The errors are that of the instant, its part that is later, and the doubt of the clearance.

    ``bound`` is (sign, distance) with the clearance sign * (y - distance), and ``landed`` (s, v).
    Rest is possible where clearance and velocity are both within their rounding: at the landing
    itself, where the acceleration passes through zero (the force turns towards the wall), or at a
    turning point. A hop that never leaves its doubt ends where it is below the wall beyond doubt.
    """
    law, region, start, _, arrival = flight
    sign, distance = bound
    s, v = landed
    doubt, doubt_of_speed = uncertainties(flight, s)
    doubt += ULP * abs(distance)
    if start[2] == 0.0 and distance == 0.0:
        # From a release the constant force is what the harmonics leave, with their rounding.
        impulse, _, rise = free_response(law, region, s)
        doubt += FORCE_ROUNDING * law[0, FORCE_BOUND] * abs(rise)
        doubt_of_speed += FORCE_ROUNDING * law[0, FORCE_BOUND] * abs(impulse)
    y, v = move(flight, s)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    if is_certain(law, region, abs(v), (abs(second), abs(third)), doubt, doubt_of_speed):
        return False, s, (0.0, 0.0, doubt)
    # Where the acceleration turns towards the wall the velocity is nearest to zero.
    turn = zero_near(flight, s, True)
    flat = is_at_rest(flight, bound, turn, doubt, doubt_of_speed)
    if flat and turn <= longest and sign * third < 0.0:
        s = turn
    else:
        foot = zero_near(flight, s, False)
        at_rest = is_at_rest(flight, bound, foot, doubt, doubt_of_speed)
        if not (at_rest or abs(v) <= doubt_of_speed):
            return False, s, (0.0, 0.0, doubt)
        if distance == 0.0 and foot < s:
            s = min(longest, crossing_time(flight, bound, s, 1.0, -doubt))
    first = crossing_time(flight, bound, s, -1.0, doubt)
    last = crossing_time(flight, bound, s, 1.0, -doubt)
    return True, s, (last - first, last - s, doubt)


@kernel
def zero_near(
    flight: Flight,
    s: float,
    of_acceleration: bool,
) -> float:
    """Return the zero of the acceleration, or of the velocity, next to s, or -1 without one."""
    law, region, start, _, arrival = flight
    y, v = move(flight, s)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    # The nearer root of the parabola that the velocity is here; what follows are Newton's steps.
    step = -second / third if third != 0.0 else math.inf
    if not of_acceleration:
        inside = second * second - 2.0 * third * v
        below = second + math.copysign(math.sqrt(max(0.0, inside)), second)
        step = -2.0 * v / below if below != 0.0 else math.inf
    for _ in range(NEWTON_STEPS):
        if not 0.0 < s + step < 2.0 * s:
            return -1.0
        s += step
        if abs(step) <= ULP * s:
            break
        y, v = move(flight, s)
        second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        value, slope = (second, third) if of_acceleration else (v, second)
        step = -value / slope if slope != 0.0 else 0.0
    return s


@kernel
def is_at_rest(
    flight: Flight,
    bound: tuple[float, float],
    s: float,
    doubt: float,
    doubt_of_speed: float,
) -> bool:
    """Return whether clearance and velocity at s are zero to within their doubts."""
    if not s > 0.0:
        return False
    y, v = move(flight, s)
    return abs(bound[0] * (y - bound[1])) <= doubt and bound[0] * v >= -doubt_of_speed


@kernel
def crossing_time(
    flight: Flight,
    bound: tuple[float, float],
    s: float,
    sign: float,
    limit: float,
) -> float:
    """Return where, from s forwards (1) or back (-1), the clearance next passes a limit.

    It rises above a positive limit and falls below a negative one. The search back ends at the
    start of the flight.
    """
    inner = s
    width = ULP * s
    outer = s
    for _ in range(DOUBLINGS):
        outer = max(0.0, s + sign * width)
        y, _ = move(flight, outer)
        if abs(limit) <= math.copysign(1.0, limit) * bound[0] * (y - bound[1]) or outer == 0.0:
            break
        inner = outer
        width *= 2.0
    for _ in range(HALVINGS):
        middle = 0.5 * (inner + outer)
        y, _ = move(flight, middle)
        if abs(limit) <= math.copysign(1.0, limit) * bound[0] * (y - bound[1]):
            outer = middle
        else:
            inner = middle
    return outer
