"""Landings whose speed is lost in their own rounding: the mass comes to the wall at rest.

A motion may meet a wall with a velocity of exactly zero while the force turns against it. What
rounding leaves of that velocity would bounce for ever. Here such a landing is found, and its
instant is taken from the derivatives of the flight (docs/theory/first-event.md, section 7).
"""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.contact import FORCE_ROUNDING
from percuss.kernels.flight import (
    ROUNDING,
    Start,
    acceleration_and_jerk,
    derivative_bound,
    move,
    uncertainties,
)
from percuss.kernels.landing import ULP
from percuss.kernels.law import DAMPING, FORCE_BOUND, STEP, STIFFNESS, Law, Table
from percuss.kernels.response import free_response

# The terms of a closed form are at most so many times v0 s + (force) s^2, for K >= 0.
MOST_OF_TERMS = 1024.0
# Newton's steps to where the velocity or the acceleration is zero, and halvings to where the
# clearance leaves its doubt.
NEWTON_STEPS = 8
DOUBLINGS = 200
HALVINGS = 40


@kernel
def is_fast(law: Law, region: int, start: Start, distance: float, s: float, v: float) -> bool:
    """Tell whether a landing is beyond doubt an impact, from bounds that cost next to nothing."""
    if law[region, STIFFNESS] < 0.0:
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
    """Tell whether the velocity keeps its sign wherever the clearance is within its doubt.

    Over 2 doubt / speed to both sides the velocity changes by less than half of itself, by the
    magnitudes of the second and third ``derivatives`` and the bound of the fourth.
    """
    second, third = derivatives
    if not speed > 2.0 * doubt_of_speed:
        return False
    width = 2.0 * doubt / speed
    if law[region, STIFFNESS] < 0.0 and width > law[region, STEP]:
        return False
    fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, width)
    change = width * (second + width * (0.5 * third + width * fourth * (1.0 / 6.0)))
    return 2.0 * change <= speed


@kernel
def rest_at_landing(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    bound: tuple[float, float],
    landed: tuple[float, float],
    longest: float,
) -> tuple[bool, float, tuple[float, float, float]]:
    """Return whether the mass may come to the wall at rest, when, and errors.

    These are the error of the instant, its part that is later, and the doubt of the clearance.

    ``bound`` is (sign, distance) with the clearance sign * (y - distance), and ``landed`` (s, v).
    It may where the clearance is within its rounding and the velocity too: at the landing itself,
    where the acceleration passes through zero (the force turns towards the wall), or at a turning
    point. A hop that never leaves its doubt ends where it is below the wall beyond doubt.
    """
    sign, distance = bound
    s, v = landed
    doubt, doubt_of_speed = uncertainties(law, region, start, phases, s)
    doubt += ULP * abs(distance)
    if start[2] == 0.0 and distance == 0.0:
        # From a release the constant force is what the harmonics leave, with their rounding.
        blow, _, rise = free_response(law, region, s)
        doubt += FORCE_ROUNDING * law[0, FORCE_BOUND] * abs(rise)
        doubt_of_speed += FORCE_ROUNDING * law[0, FORCE_BOUND] * abs(blow)
    y, v = move(law, region, start, phases, s, arrival)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    if is_certain(law, region, abs(v), (abs(second), abs(third)), doubt, doubt_of_speed):
        return False, s, (0.0, 0.0, doubt)
    # Where the acceleration turns towards the wall the velocity is nearest to zero.
    turn = zero_near(law, region, start, phases, arrival, s, True)
    flat = is_at_rest(law, region, start, phases, arrival, bound, turn, doubt, doubt_of_speed)
    if flat and turn <= longest and sign * third < 0.0:
        s = turn
    else:
        foot = zero_near(law, region, start, phases, arrival, s, False)
        rests = is_at_rest(law, region, start, phases, arrival, bound, foot, doubt, doubt_of_speed)
        if not (rests or abs(v) <= doubt_of_speed):
            return False, s, (0.0, 0.0, doubt)
        if distance == 0.0 and foot < s:
            s = min(longest, leaves(law, region, start, phases, arrival, bound, s, 1.0, -doubt))
    first = leaves(law, region, start, phases, arrival, bound, s, -1.0, doubt)
    last = leaves(law, region, start, phases, arrival, bound, s, 1.0, -doubt)
    return True, s, (last - first, last - s, doubt)


@kernel
def zero_near(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    s: float,
    of_acceleration: bool,
) -> float:
    """Return the zero of the acceleration, or of the velocity, next to s, or -1 without one."""
    y, v = move(law, region, start, phases, s, arrival)
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
        y, v = move(law, region, start, phases, s, arrival)
        second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        value, slope = (second, third) if of_acceleration else (v, second)
        step = -value / slope if slope != 0.0 else 0.0
    return s


@kernel
def is_at_rest(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    bound: tuple[float, float],
    s: float,
    doubt: float,
    doubt_of_speed: float,
) -> bool:
    """Tell whether clearance and velocity at s are zero to within their doubts."""
    if not s > 0.0:
        return False
    y, v = move(law, region, start, phases, s, arrival)
    return abs(bound[0] * (y - bound[1])) <= doubt and bound[0] * v >= -doubt_of_speed


@kernel
def leaves(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    bound: tuple[float, float],
    s: float,
    way: float,
    limit: float,
) -> float:
    """Return where, from s forwards (1) or back (-1), the clearance is next beyond a limit.

    Beyond is above a positive limit and below a negative one; back, no farther than the start.
    """
    inner = s
    width = ULP * s
    outer = s
    for _ in range(DOUBLINGS):
        outer = max(0.0, s + way * width)
        y, _ = move(law, region, start, phases, outer, arrival)
        if abs(limit) <= math.copysign(1.0, limit) * bound[0] * (y - bound[1]) or outer == 0.0:
            break
        inner = outer
        width *= 2.0
    for _ in range(HALVINGS):
        middle = 0.5 * (inner + outer)
        y, _ = move(law, region, start, phases, middle, arrival)
        if abs(limit) <= math.copysign(1.0, limit) * bound[0] * (y - bound[1]):
            outer = middle
        else:
            inner = middle
    return outer
