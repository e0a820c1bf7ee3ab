"""The first touch of one bound on a stretch of a flight, decided with proof.

The stretch is cut until on each piece the clearance is provably positive, or provably has at most
one zero or one turning point, which is then looked at. The bounds are Taylor's theorem with the
remainder of ``derivative_bound``; docs/theory/first-event.md has the proof.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.kernels.compile import kernel
from percuss.kernels.flight import (
    Start,
    acceleration_and_jerk,
    derivative_bound,
    force_derivative,
    move,
    uncertainty,
)
from percuss.kernels.landing import ULP, land, lowest
from percuss.kernels.law import DAMPING, FORCE_BOUND, STIFFNESS, Law, Table

Pair: TypeAlias = tuple[float, float]

# Verdicts.
NONE, HIT, GRAZE = 0, 1, 2
# Shapes of the clearance on a piece.
UNKNOWN, CLEAR, ONE_ZERO, ONE_MINIMUM, FLAT = 0, 1, 2, 3, 4
# Pieces of one stretch.
MOST_PIECES = 10_000
# A departure is decided by its first derivative that is not zero, up to this order.
LAST_ORDER = 12


@kernel
def first_touch(
    law: Law, region: int, start: Start, phases: Table, arrival: Table, bound: Pair, span: Pair
) -> tuple[int, float, float, float, float]:
    """Return (verdict, s, v or clearance, rounding bound, free up to) of the first touch.

    ``bound`` is (sign, distance) and ``span`` (left, right): the clearance sign * (y - distance)
    is positive at the left. For a HIT the third entry is the
    velocity and the fourth what is to be added to s, for a GRAZE the third is the clearance. ``arrival`` holds the phases of a HIT.
    """
    sign, distance = bound
    left, right = span
    if not left < right:
        return NONE, right, 0.0, 0.0, right
    y, v = move(law, region, start, phases, left, arrival)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    doubt = uncertainty(law, region, start, phases, left)
    doubt = 2.0 * max(doubt, uncertainty(law, region, start, phases, right)) + ULP * abs(distance)
    width = right - left
    # Where the clearance was last seen to be positive beyond doubt, or the search began.
    sure = left
    for _ in range(MOST_PIECES):
        width = min(width, right - left)
        fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, width)
        if not fourth < math.inf:
            # Beyond the range of floats; the velocity says so.
            return HIT, left, math.nan, 0.0, left
        gap = sign * (y - distance)
        speed = sign * v
        shape = shape_of(gap, speed, sign * second, sign * third, fourth, width, doubt)
        if shape == UNKNOWN and width > 8.0 * ULP * (left + width):
            width *= 0.5
            continue
        after = left + width
        dips = shape == ONE_MINIMUM and speed <= 0.0
        piece = (left, after)
        foot, y, v = foot_of(law, region, start, phases, arrival, bound, piece, dips, doubt)
        end, beyond, error = foot
        if dips and sign * v > 0.0 and sign * (y - distance) > 0.0 and abs(beyond) <= error:
            return GRAZE, end, beyond, error, after
        if beyond < -error:
            bracket = (sure, end, 0.5 * (sure + end))
            s, v, rest = land(law, region, start, phases, arrival, sign, distance, bracket)
            return HIT, s, v, rest, s
        beyond = sign * (y - distance)
        if shape == CLEAR or beyond > doubt:
            if sure < left and gap <= 0.0:
                return GRAZE, left, gap, doubt, after
            sure = after
        if after >= right:
            return NONE, right, 0.0, 0.0, right
        second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        left = after
        width *= 2.0
    # Never seen: say that nothing is known of the rest.
    return GRAZE, left, sign * (y - distance), math.inf, right


@kernel
def foot_of(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    bound: Pair,
    piece: Pair,
    dips: bool,
    doubt: float,
) -> tuple[tuple[float, float, float], float, float]:
    """Return where a piece decides itself, as (s, clearance, doubt), and (y, v) at its end.

    That is its end, but where the clearance ``dips`` on it and rises again the minimum. ``bound``
    is (sign, distance); ``arrival`` receives the phases at the end.
    """
    sign, distance = bound
    left, after = piece
    y, v = move(law, region, start, phases, after, arrival)
    beyond = sign * (y - distance)
    if beyond <= 0.0:
        doubt = uncertainty(law, region, start, phases, after) + ULP * abs(distance)
    elif dips and sign * v > 0.0:
        foot = lowest(law, region, start, phases, arrival, sign, distance, left, after)
        y, v = move(law, region, start, phases, after, arrival)
        return foot, y, v
    return (after, beyond, doubt), y, v


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
    """Tell what the clearance can do over ``width``, from its derivatives at the left end.

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
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    sign: float,
    longest: float,
) -> float:
    """Return a time up to which a flight that starts on a bound is free of it, 0 if not at all.

    With m the first derivative that is not zero, the clearance is at least
    s^m / m! (abs(y^(m)) - s / (m + 1) * bound of y^(m+1)). Infinite for a motion that is none.
    """
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
