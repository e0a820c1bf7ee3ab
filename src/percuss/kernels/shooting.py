"""The equations of a periodic motion: a chain of flights that closes after a period.

The unknowns are the instant of the first event, the durations of the flights and the velocities
after the events; between them stands the closed form of `flight`. A flight is followed in its own
region whether or not it passes through a bound on the way: such motions are formal, and tell
where physical ones end. The order of events is given as a *chain*, one row an event.
"""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import later
from percuss.kernels.flight import (
    Start,
    acceleration_and_jerk,
    constant_force,
    move,
    set_phases,
    uncertainty,
)
from percuss.kernels.landing import MAX_ITERATIONS
from percuss.kernels.law import (
    LOWER,
    LOWER_KIND,
    LOWER_RESTITUTION,
    NUMBER,
    STEP,
    UPPER,
    UPPER_KIND,
    UPPER_RESTITUTION,
    WALL,
    Law,
    Table,
)
from percuss.kernels.record import Integers
from percuss.kernels.tangent import delayed_start, propagator

# Columns of a chain: number of the bound, row of the region before the event and after it.
AT, BEFORE, AFTER = range(3)
CHAIN_COLUMNS = 3

# A step of the search for turning points, as a part of a step of the search for events: there
# the cubic through the velocities at both ends is off by 1e-5 of their change.
PART = 0.25


@kernel
def place(law: Law, region: int, bound: int) -> float:
    """Return the position of a bound of a region."""
    return law[region, LOWER if bound == int(law[region, NUMBER]) else UPPER]


@kernel
def factor(law: Law, region: int, bound: int) -> float:
    """Return the velocity after an event at a bound of a region as a part of that before."""
    if bound == int(law[region, NUMBER]):
        return -law[region, LOWER_RESTITUTION] if law[region, LOWER_KIND] == WALL else 1.0
    return -law[region, UPPER_RESTITUTION] if law[region, UPPER_KIND] == WALL else 1.0


@kernel
def shoot(
    law: Law,
    chain: Integers,
    unknowns: Table,
    period: float,
    phases: Table,
    arrival: Table,
    residual: Table,
    jacobian: Table,
) -> None:
    """Write by how much a chain of n flights misses its events, and the derivatives of that.

    ``unknowns`` (2 n + 1,) are the instant of event 0, the durations of the flights that follow
    events 0, 1, ..., and the velocities after these events. Residuals 2 i and 2 i + 1 are the
    distance by which the flight from event i misses the place of the next, and the velocity
    after the next less what the event makes of the one before; the last is the sum of the
    durations less ``period``.
    """
    n = chain.shape[0]
    jacobian[:, :] = 0.0
    t = unknowns[0]
    t_low = 0.0
    total = -period
    for i in range(n):
        following = (i + 1) % n
        region = chain[i, AFTER]
        s = unknowns[1 + i]
        v0 = unknowns[1 + n + i]
        x = place(law, region, chain[i, AT])
        start = (t, t_low, v0, constant_force(law, region, x))
        set_phases(law, t, t_low, phases)
        y, v = move(law, region, start, phases, s, arrival)
        acceleration, _ = acceleration_and_jerk(law, region, start[3], arrival, y, v)
        _, x_of_v, _, v_of_v = propagator(law, region, s)
        x_of_t, v_of_t = delayed_start(law, region, phases, s)
        kept = factor(law, region, chain[following, AT])
        residual[2 * i] = y - (place(law, region, chain[following, AT]) - x)
        residual[2 * i + 1] = unknowns[1 + n + following] - kept * v
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


@kernel
def turning_points(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    longest: float,
    out: Table,
) -> int:
    """Write (s, y, doubt) of the turning points inside a flight to ``out`` (m, 3); return how many.

    ``doubt`` bounds the rounding error of y. The ends are none. Stops when ``out`` is full.
    """
    v = start[2]
    before, _ = acceleration_and_jerk(law, region, start[3], phases, 0.0, v)
    step = longest / 16.0
    if law[region, STEP] > 0.0:
        step = longest / math.ceil(longest / min(PART * law[region, STEP], step))
    found = 0
    s = 0.0
    while s < longest and found < out.shape[0]:
        end = min(s + step, longest)
        if longest - end < 0.5 * step:
            end = longest
        y, after = move(law, region, start, phases, end, arrival)
        acceleration, _ = acceleration_and_jerk(law, region, start[3], arrival, y, after)
        # From rest it goes where it is accelerated to, and may have turned already.
        way = v if v != 0.0 else before
        middle = end
        if way * after > 0.0 and way * before < 0.0 and after * acceleration > 0.0:
            # It may turn twice: look at where the velocity is least.
            middle = s + (end - s) * before / (before - acceleration)
            _, least = move(law, region, start, phases, middle, arrival)
            if not way * least < 0.0:
                middle = end
        if middle < end or way * after < 0.0:
            out[found, 0], out[found, 1] = turn(law, region, start, phases, arrival, way, s, middle)
            found += 1
        if middle < end and found < out.shape[0]:
            out[found, 0], out[found, 1] = turn(
                law, region, start, phases, arrival, -way, middle, end
            )
            found += 1
        if after == 0.0 and end < longest and found < out.shape[0]:
            out[found, 0] = end
            out[found, 1] = y
            found += 1
        v = after
        before = acceleration
        s = end
    for i in range(found):
        out[i, 2] = uncertainty(law, region, start, phases, out[i, 0])
    return found


@kernel
def turn(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    way: float,
    left: float,
    right: float,
) -> tuple[float, float]:
    """Return (s, y) where the velocity, with the sign of ``way`` before, changes it."""
    s = 0.5 * (left + right)
    y = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(law, region, start, phases, s, arrival)
        if v == 0.0:
            break
        if v * way > 0.0:
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
