"""The equations of a periodic motion and Newton's method for them.

The motion is a sequence of flights that closes after a period. The unknowns are the instant of the
first event, the durations of the flights and the velocities after the events; each flight is the
closed form of `flight`. A flight is followed in its own region whether or not it passes through a
bound on the way: such motions are formal, and show where physical ones end. The event sequence
is given as an array, the *itinerary*, one row an event.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import later
from percuss.kernels.compile import kernel
from percuss.kernels.event_location import MAX_ITERATIONS
from percuss.kernels.flight import (
    Flight,
    acceleration_and_jerk,
    constant_force,
    move,
    move_over_knots,
    place,
    set_phases,
    uncertainty,
)
from percuss.kernels.law_columns import (
    LOWER_KIND,
    NUMBER,
    UPPER_KIND,
    WALL,
    Law,
)
from percuss.kernels.linear import eliminate
from percuss.kernels.overdamped import slow_step, time_to_fade
from percuss.kernels.pieces import time_to_knot
from percuss.kernels.restitution import kept_of_error, restitution_at
from percuss.kernels.tangent import delayed_start, propagator

# Columns of an itinerary: number of the bound, row of the region before the event and after it.
AT, BEFORE, AFTER = range(3)
ITINERARY_COLUMNS = 3
# A step of the search for turning points, as a part of a step of the search for events: there
# the cubic through the velocities at both ends is off by 1e-5 of their change.
PART = 0.25
# Why `iterate` came back: steps are down to rounding; the equations are singular to within WEAK,
# so that a step of least norm has to be made; no more steps; numbers out of range.
SETTLED, SINGULAR, SPENT, LOST = range(4)
# Scaled steps below this are rounding; so are steps below the second that gain nothing.
SMALLEST_STEP = 1e-13
SMALL_STEP = 1e-9
# Pivots below this part of the largest entry.
WEAK = 1e-10


class ShootingProblem(NamedTuple):
    """A periodic motion to be found: its law, itinerary, and period.

    ``phases`` and ``arrival`` (n_harmonics, 2) are scratch.
    """

    law: Law
    itinerary: Integers
    period: float
    phases: Floats
    arrival: Floats


@kernel
def factor(law: Law, region: int, bound: int, v: float) -> float:
    """Return the velocity after an event at a bound of a region as a part of that before, v."""
    kind = law[region, LOWER_KIND if bound == int(law[region, NUMBER]) else UPPER_KIND]
    return -restitution_at(law, region, bound, abs(v)) if kind == WALL else 1.0


@kernel
def factor_of_error(law: Law, region: int, bound: int, v: float) -> float:
    """Return the derivative of the velocity after an event by that before, v."""
    kind = law[region, LOWER_KIND if bound == int(law[region, NUMBER]) else UPPER_KIND]
    return -kept_of_error(law, region, bound, abs(v)) if kind == WALL else 1.0


@kernel
def shoot(problem: ShootingProblem, unknowns: Floats, residual: Floats, jacobian: Floats) -> None:
    """Write the residuals of n flights, and their derivatives by the unknowns.

    ``unknowns`` (2 n + 1,) are the instant of event 0, the durations of the flights that follow
    events 0, 1, ..., and the velocities after these events. Residuals 2 i and 2 i + 1 are the
    distance by which the flight from event i misses the place of the next, and the velocity
    after the next less what the event makes of the one before; the last is the sum of the
    durations less ``period``. A ``period`` of 0 is that of free motion, which is unknown: in place
    of the last equation event 0 stays where it is.
    """
    law, itinerary, period, phases, arrival = problem
    n = itinerary.shape[0]
    jacobian[:, :] = 0.0
    t = unknowns[0]
    t_low = 0.0
    total = -period
    for i in range(n):
        following = (i + 1) % n
        region = itinerary[i, AFTER]
        s = unknowns[1 + i]
        v0 = unknowns[1 + n + i]
        x = place(law, region, itinerary[i, AT])
        start = (t, t_low, v0, constant_force(law, region, x))
        flight = Flight(law, region, start, phases, arrival)
        set_phases(law, t, t_low, phases)
        y, v = move_over_knots(flight, s)
        acceleration, _ = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        x_of_x, x_of_v, v_of_x, v_of_v = propagator(law, region, s)
        x_of_t, v_of_t = delayed_start(law, region, phases, s)
        if time_to_knot(law, t, t_low) < s:
            # A delay moves the end along the motion, and takes what the start would have moved.
            begin, _ = acceleration_and_jerk(law, region, start[3], phases, 0.0, v0)
            x_of_t = v - (x_of_x * v0 + x_of_v * begin)
            v_of_t = acceleration - (v_of_x * v0 + v_of_v * begin)
        bound = itinerary[following, AT]
        kept = factor_of_error(law, region, bound, v)
        residual[2 * i] = y - (place(law, region, bound) - x)
        residual[2 * i + 1] = unknowns[1 + n + following] - factor(law, region, bound, v) * v
        for k in range(1 + i):
            # Event 0 and each duration before this flight shift it.
            jacobian[2 * i, k] = x_of_t
            jacobian[2 * i + 1, k] = -kept * v_of_t
        jacobian[2 * i, 1 + i] = v
        jacobian[2 * i + 1, 1 + i] = -kept * acceleration
        jacobian[2 * i, 1 + n + i] = x_of_v
        jacobian[2 * i + 1, 1 + n + i] = -kept * v_of_v
        jacobian[2 * i + 1, 1 + n + following] += 1.0
        jacobian[2 * n, 1 + i] = 1.0
        total += s
        t, t_low = later(t, t_low, s)
    residual[2 * n] = total
    if period == 0.0:
        residual[2 * n] = 0.0
        for k in range(1 + 2 * n):
            jacobian[2 * n, k] = 1.0 if k == 0 else 0.0


@kernel
def turning_points(
    flight: Flight,
    longest: float,
    search_step: float,
    out: Floats,
) -> int:
    """Write (s, y, doubt) of the turning points inside a flight to ``out`` (m, 3); return how many.

    ``search_step`` is the step of the walk (`next_event`), in which the fastest part of the motion
    turns by a radian; 0 at constant acceleration. After the fast decay of an overdamped stop the
    slow parts decide. ``doubt`` bounds the rounding error of y. The ends do not count. It stops
    when ``out`` is full.
    """
    law, region, start, phases, arrival = flight
    v = start[2]
    before, _ = acceleration_and_jerk(law, region, start[3], phases, 0.0, v)
    step = longest / 16.0
    if search_step > 0.0:
        step = longest / math.ceil(longest / min(PART * search_step, step))
    slower = max(step, min(PART * slow_step(law, region), longest / 16.0))
    fades = time_to_fade(law, region)
    count = 0
    s = 0.0
    while s < longest and count < out.shape[0]:
        width = step if s < fades else slower
        end = min(s + width, longest)
        if longest - end < 0.5 * width:
            end = longest
        y, after = move(flight, end)
        acceleration, _ = acceleration_and_jerk(law, region, start[3], arrival, y, after)
        # From rest it moves along its acceleration, and may have turned already.
        sign = v if v != 0.0 else before
        middle = end
        if sign * after > 0.0 and sign * before < 0.0 and after * acceleration > 0.0:
            # It may turn twice: take the point where the velocity is least.
            middle = s + (end - s) * before / (before - acceleration)
            _, least = move(flight, middle)
            if not sign * least < 0.0:
                middle = end
        if middle < end or sign * after < 0.0:
            out[count, 0], out[count, 1] = turn(flight, sign, s, middle)
            count += 1
        if middle < end and count < out.shape[0]:
            out[count, 0], out[count, 1] = turn(flight, -sign, middle, end)
            count += 1
        if after == 0.0 and end < longest and count < out.shape[0]:
            out[count, 0] = end
            out[count, 1] = y
            count += 1
        v = after
        before = acceleration
        s = end
    for i in range(count):
        out[i, 2] = uncertainty(flight, out[i, 0])
    return count


@kernel
def turn(
    flight: Flight,
    sign: float,
    left: float,
    right: float,
) -> tuple[float, float]:
    """Return (s, y) where the velocity, with the sign of ``sign`` before, changes it."""
    law, region, start, _, arrival = flight
    s = 0.5 * (left + right)
    y = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(flight, s)
        if v == 0.0:
            break
        if v * sign > 0.0:
            left = s
        else:
            right = s
        second, _ = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        middle = s - v / second if second != 0.0 else left
        if not left < middle < right:
            middle = 0.5 * (left + right)
        if abs(middle - s) <= 4.5e-16 * s:
            break
        s = middle
    return s, y


@kernel
def scales(unknowns: Floats, n: int) -> tuple[float, float]:
    """Return the scales of time, the mean duration, and of velocity, the greatest one."""
    time = 0.0
    speed = 0.0
    for i in range(n):
        time += abs(unknowns[1 + i]) / n
        speed = max(speed, abs(unknowns[1 + n + i]))
    # With r = 0 every flight may start from rest.
    return time if time > 0.0 else 1.0, speed if speed > 0.0 else 1.0


@kernel
def equations(
    problem: ShootingProblem, unknowns: Floats, residual: Floats, matrix: Floats
) -> float:
    """Write scaled residuals and the Jacobian by scaled unknowns; return the largest residual."""
    n = problem.itinerary.shape[0]
    shoot(problem, unknowns, residual, matrix)
    time, speed = scales(unknowns, n)
    last = 2 * n
    size = 0.0
    for i in range(last + 1):
        scale = time
        if i < last:
            scale = speed * time if i % 2 == 0 else speed
        residual[i] /= scale
        # Infinite for NaN.
        size = max(size, abs(residual[i])) if residual[i] == residual[i] else math.inf
        for k in range(last + 1):
            matrix[i, k] *= (time if k <= n else speed) / scale
    return size


@kernel
def advance(unknowns: Floats, step: Floats, n: int) -> float:
    """Add a scaled step to the unknowns, durations kept above a tenth; return its size.

    Far from a solution only the direction of the step is right: it is cut to the scales.
    """
    time, speed = scales(unknowns, n)
    size = 0.0
    for k in range(2 * n + 1):
        size = max(size, abs(step[k]))
    part = 1.0 / size if size > 1.0 else 1.0
    for i in range(n):
        shorter = -step[1 + i] * time
        if shorter * part > 0.9 * unknowns[1 + i]:
            part = 0.9 * unknowns[1 + i] / shorter
    for k in range(2 * n + 1):
        unknowns[k] += part * step[k] * (time if k <= n else speed)
    return size


@kernel
def copy(source: Floats, target: Floats) -> None:
    """Write one row of numbers into another."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel
def iterate(
    problem: ShootingProblem,
    unknowns: Floats,
    residual: Floats,
    matrix: Floats,
    best: Floats,
    steps: int,
) -> tuple[int, float, int]:
    """Improve the unknowns; return (why it came back, best scaled residual, steps left).

    ``best`` (2 n + 1,) receives the unknowns with that residual, ``unknowns`` the last ones.
    """
    itinerary = problem.itinerary
    n = itinerary.shape[0]
    size = equations(problem, unknowns, residual, matrix)
    least = size
    copy(unknowns, best)
    while steps > 0:
        if not size < math.inf:
            return LOST, least, steps
        for i in range(2 * n + 1):
            residual[i] = -residual[i]
        if not eliminate(matrix, residual, WEAK):
            return SINGULAR, least, steps
        moved = advance(unknowns, residual, n)
        steps -= 1
        size = equations(problem, unknowns, residual, matrix)
        gained = size < least
        if gained:
            least = size
            copy(unknowns, best)
        if moved < SMALLEST_STEP or (moved < SMALL_STEP and not gained):
            return SETTLED, least, steps
    return SPENT, least, steps
