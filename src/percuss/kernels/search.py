"""When is the next event: the first meeting of a flight with either bound of its region.

The flight is walked in steps of a fixed length. A step costs a few multiplications, for the state
after it is a fixed linear map of the state and of the force's phasors before it. On each step the
displacement lies between the Bernstein coefficients of the cubic through both ends, to within
h^4 / 384 times a bound of the fourth derivative: where these clear both bounds, no event has been
passed. Else the step is looked at closely (``touch``). Steps never enter a result: what is
found is computed from the closed form at the flight's start.
"""

from __future__ import annotations

import math

from percuss.kernels.coasting import coast, is_spread
from percuss.kernels.compile import kernel
from percuss.kernels.doubled import later
from percuss.kernels.flight import Start, acceleration_and_jerk, move, set_phases, uncertainty
from percuss.kernels.landing import land
from percuss.kernels.law import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    FIRST_HARMONIC,
    FORCE_BOUND,
    GAIN_IM,
    GAIN_RE,
    LOWER,
    OMEGA,
    PER_STIFFNESS,
    SIMPLE,
    SINE,
    STEP,
    STEP_COS,
    STEP_SIN,
    STIFFNESS,
    UPPER,
    V_OF_COS,
    V_OF_FORCE,
    V_OF_SIN,
    V_OF_V,
    V_OF_X,
    X_OF_COS,
    X_OF_FORCE,
    X_OF_SIN,
    X_OF_V,
    X_OF_X,
    Law,
    Table,
)
from percuss.kernels.polynomials import cubic_minimum, quintic_root
from percuss.kernels.touch import HIT, NONE, departure, first_touch

# After so many steps the walk starts afresh from the closed form: its own rounding stays below
# the slack, and a long flight can be left and taken up again without changing a bit.
STEPS_A_WALK = 64
# Walks of one flight between two looks at what its slow parts alone would do, the first after one.
WALKS_TO_A_COAST = 8
# Room for the rounding of amplitudes, far more than it is.
AMPLITUDE_SLACK = 1e-9
# Rounding of a walk relative to the sizes of its terms: 64 steps of some 20 roundings each, with
# a margin of 30.
WALK_SLACK = 1e-11

THIRD = 1.0 / 3.0

PAUSE = 3  # the fourth verdict: no event up to the place reached


@kernel
def next_event(
    law: Law,
    region: int,
    x: float,
    start: Start,
    phases: Table,
    arrival: Table,
    walker: Table,
    free: tuple[float, float],
    longest: float,
) -> tuple[int, float, float, float, float, tuple[float, float]]:
    """Return (verdict, s, side, v or clearance, rounding bound, free) of the next event.

    ``free`` tells up to where the lower and the upper bound are known to be clear: (0, 0) at the
    start; what is returned there is to be handed in again after a GRAZE or a PAUSE. ``side`` is
    -1 for the lower bound and +1 for the upper; a HIT comes with its velocity and, in place of
    the bound, what is to be added to s unrounded, a GRAZE with its clearance. No event before
    ``longest`` is NONE.
    """
    reach = (law[region, LOWER] - x, law[region, UPPER] - x)
    step = law[region, STEP]
    s = min(free[0], free[1])
    if s >= longest:
        return NONE, longest, 0.0, 0.0, 0.0, free
    if step == 0.0:
        end = s + fall_time(start[2], start[3], reach, longest)
        if end > s:
            found = look(law, region, start, phases, arrival, reach, free, end)
            if found[0] != NONE:
                return found
        return NONE, longest, 0.0, 0.0, 0.0, free
    walks = int(s / (step * STEPS_A_WALK))
    if walks % WALKS_TO_A_COAST == 1 and is_spread(law, region, phases.shape[0]):
        # Of a flight that goes on for long only the slow parts may count.
        s = coast(law, region, start, phases, arrival, s, reach, longest)
        free = (max(free[0], s), max(free[1], s))
        if s >= longest:
            return NONE, longest, 0.0, 0.0, 0.0, free
    steps, y, v, load = set_out(law, region, start, phases, walker, s)
    if s > 0.0 and stays_clear(law, region, start[3], walker, y, v, reach):
        return NONE, longest, 0.0, 0.0, 0.0, free
    force_bound = law[0, FORCE_BOUND + 2] * (1.0 + law[region, BOUND_OF_V] * step)
    for _ in range(steps):
        if s >= longest:
            return NONE, longest, 0.0, 0.0, 0.0, free
        second, third = acceleration_and_jerk(law, region, start[3], walker, y, v)
        pulls = law[region, BOUND_OF_X] * abs(second) + law[region, BOUND_OF_V] * abs(third)
        fourth = force_bound + pulls
        after = step_on(law, region, start[3], walker, y, v)
        margins = clearances(reach, s, step, load, (y, v), after, fourth)
        if not (margins[0] > 0.0 and margins[1] > 0.0):
            here = (s, y, v, second, fourth, load)
            found = meeting(
                law, region, start, phases, arrival, walker, reach, free, margins, here, after
            )
            if found[0] != NONE:
                return found
        s += step
        free = (max(free[0], s), max(free[1], s))
        y, v = after
    return PAUSE, s, 0.0, 0.0, 0.0, free


@kernel
def set_out(
    law: Law, region: int, start: Start, phases: Table, walker: Table, s: float
) -> tuple[int, float, float, float]:
    """Return how many steps a walk from s may have, (y, v) there, and what forces do in a step.

    ``walker`` receives the phases there.
    """
    y = 0.0
    v = start[2]
    if s > 0.0:
        y, v = move(law, region, start, phases, s, walker)
    else:
        for j in range(phases.shape[0]):
            walker[j, 0] = phases[j, 0]
            walker[j, 1] = phases[j, 1]
    step = law[region, STEP]
    steps = STEPS_A_WALK
    load = step * step * (abs(start[3]) + law[0, FORCE_BOUND])
    if law[region, STIFFNESS] < 0.0:
        # An error grows here as fast as the motion can: begin each step from the closed form.
        steps = 1
    if s > 0.0 or steps == 1:
        # The closed form that this walk begins from is rounded itself.
        doubt = uncertainty(law, region, start, phases, s)
        load += (doubt + uncertainty(law, region, start, phases, s + step)) / WALK_SLACK
    return steps, y, v, load


@kernel
def stays_clear(
    law: Law,
    region: int,
    force: float,
    phases: Table,
    y: float,
    v: float,
    reach: tuple[float, float],
) -> bool:
    """Tell whether the amplitudes of a simple motion at (y, v) keep it off both bounds for ever.

    The steady part has the harmonic's amplitude times the gain, and sqrt(z^2 + z'^2 / K) of the
    free part z does not grow.
    """
    if law[region, SIMPLE] == 0.0:
        return False
    gain_re = law[region + 1, GAIN_RE]
    gain_im = law[region + 1, GAIN_IM]
    omega = law[FIRST_HARMONIC, OMEGA]
    push = law[FIRST_HARMONIC, COSINE] * phases[0, 0] + law[FIRST_HARMONIC, SINE] * phases[0, 1]
    rate = law[FIRST_HARMONIC, SINE] * phases[0, 0] - law[FIRST_HARMONIC, COSINE] * phases[0, 1]
    rest = force * law[region, PER_STIFFNESS]
    z = y - rest - (push * gain_re + rate * gain_im)
    w = v + omega * (push * gain_im - rate * gain_re)
    swing = law[FIRST_HARMONIC, AMPLITUDE] * math.sqrt(gain_re * gain_re + gain_im * gain_im)
    most = swing + math.sqrt(z * z + w * w * law[region, PER_STIFFNESS])
    most += AMPLITUDE_SLACK * (most + abs(rest))
    return rest - most > reach[0] and rest + most < reach[1]


@kernel
def fall_time(v: float, force: float, reach: tuple[float, float], longest: float) -> float:
    """Return a time within which motion at constant acceleration meets what it ever meets."""
    speed = abs(v)
    pull = abs(force)
    distance = 0.0
    if reach[0] > -math.inf:
        distance = -reach[0]
    if reach[1] < math.inf:
        distance = max(distance, reach[1])
    time = 0.0
    if pull > 0.0:
        # Out, back to where it started, and on to the farther bound.
        time = 2.0 * (speed + math.sqrt(speed * speed + 2.0 * pull * distance)) / pull
    elif speed > 0.0:
        # Some time at least: a start on a bound, into it, is met at once.
        time = max(2.0 * distance / speed, 1.0)
    return min(time, longest)


@kernel
def step_on(
    law: Law, region: int, force: float, walker: Table, y: float, v: float
) -> tuple[float, float]:
    """Return (y, v) one step later, and turn the phases in ``walker`` along."""
    # The state's own terms come last: a step then waits for little of the step before.
    y1 = law[region, X_OF_FORCE] * force
    v1 = law[region, V_OF_FORCE] * force
    for j in range(walker.shape[0]):
        harmonic = FIRST_HARMONIC + j
        response = region + 1 + j
        cosine = walker[j, 0]
        sine = walker[j, 1]
        in_phase = law[harmonic, COSINE] * cosine + law[harmonic, SINE] * sine
        quadrature = law[harmonic, SINE] * cosine - law[harmonic, COSINE] * sine
        y1 += law[response, X_OF_COS] * in_phase + law[response, X_OF_SIN] * quadrature
        v1 += law[response, V_OF_COS] * in_phase + law[response, V_OF_SIN] * quadrature
        walker[j, 0] = cosine * law[response, STEP_COS] - sine * law[response, STEP_SIN]
        walker[j, 1] = sine * law[response, STEP_COS] + cosine * law[response, STEP_SIN]
    y1 += law[region, X_OF_X] * y + law[region, X_OF_V] * v
    v1 += law[region, V_OF_X] * y + law[region, V_OF_V] * v
    return y1, v1


@kernel
def clearances(
    reach: tuple[float, float],
    s: float,
    step: float,
    load: float,
    before: tuple[float, float],
    after: tuple[float, float],
    fourth: float,
) -> tuple[float, float]:
    """Return lower bounds of the clearance below and above during a step.

    On the first step from a bound, the clearance there is known to start at zero, and what
    counts is its sign after it has been divided by the time.
    """
    y, v = before
    y1, v1 = after
    first = y + step * THIRD * v
    last = y1 - step * THIRD * v1
    bend = fourth * step**4
    error = bend * (1.0 / 384.0) + walk_error(step, load, before, after)
    low = min(first, last, y1)
    high = max(first, last, y1)
    below = min(low, y) - reach[0] - error
    above = reach[1] - max(high, y) - error
    if s == 0.0:
        # tau^2 (1 - tau)^2 is at most a third of the first Bernstein polynomial.
        if reach[0] == 0.0:
            below = min(first - bend / 72.0, min(last, y1) - error)
        if reach[1] == 0.0:
            above = -max(first + bend / 72.0, max(last, y1) + error)
    return below, above


@kernel
def walk_error(
    step: float, load: float, before: tuple[float, float], after: tuple[float, float]
) -> float:
    """Return a bound on the rounding that a walk has gathered; ``load`` is what forces do in it."""
    places = abs(before[0]) + abs(after[0])
    return WALK_SLACK * (load + places + step * (abs(before[1]) + abs(after[1])))


@kernel
def meeting(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    walker: Table,
    reach: tuple[float, float],
    free: tuple[float, float],
    margins: tuple[float, float],
    here: tuple[float, float, float, float, float, float],
    after: tuple[float, float],
) -> tuple[int, float, float, float, float, tuple[float, float]]:
    """Return the first event of a step that is not clear, at once where it is a plain crossing.

    ``here`` is s, y, v, the second derivative at the beginning of the step, the bound of the
    fourth, and the load of ``walk_error``; ``after`` and ``walker`` are y, v and the phases at
    its end.

    A root is the first one if the cubic through the beginning and the root has Bernstein
    coefficients above a twelfth of fourth * width^4 / 24 (and room for rounding), for tau^2 (1 - tau)^2 is at most a
    twelfth of the sum of the two inner Bernstein polynomials.
    """
    s, y, v, second, fourth, load = here
    y1, v1 = after
    step = law[region, STEP]
    if (margins[0] > 0.0) != (margins[1] > 0.0) and max(free[0], free[1]) <= s:
        sign = 1.0 if margins[1] > 0.0 else -1.0
        distance = reach[0] if margins[1] > 0.0 else reach[1]
        slack = walk_error(step, load, (y, v), after)
        begins = sign * (y - distance)
        from_bound = s == 0.0 and distance == 0.0
        if (begins > slack or from_bound) and sign * (y1 - distance) < -slack:
            second1, _ = acceleration_and_jerk(law, region, start[3], walker, y1, v1)
            pace = sign * step
            ends = (begins, pace * v, pace * step * second)
            ends1 = (sign * (y1 - distance), pace * v1, pace * step * second1)
            bracket = (s, s + step, s + step * quintic_root(ends, ends1))
            end, speed, rest = land(law, region, start, phases, arrival, sign, distance, bracket)
            width = end - s
            least = fourth * width**4 * (1.0 / 287.0) + (0.0 if from_bound else slack)
            if begins + THIRD * width * sign * v > least and -THIRD * width * sign * speed > least:
                return HIT, end, -sign, speed, rest, free
        elif begins > slack and sign * (y1 - distance) > slack:
            lowest = cubic_minimum(
                begins, step * sign * v, sign * (y1 - distance), step * sign * v1
            )
            if lowest > fourth * step**4 * (1.0 / 384.0) + slack:
                return NONE, s + step, 0.0, 0.0, 0.0, free
    return look(law, region, start, phases, arrival, reach, free, s + step)


@kernel
def look(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    reach: tuple[float, float],
    free: tuple[float, float],
    end: float,
) -> tuple[int, float, float, float, float, tuple[float, float]]:
    """Return the first event up to ``end``, each bound searched from where it is known free."""
    from_lower, from_upper = free
    if from_lower == 0.0 and reach[0] == 0.0:
        from_lower = departure(law, region, start, phases, 1.0, end)
        if from_lower == 0.0:
            return HIT, 0.0, -1.0, start[2], 0.0, free
    if from_upper == 0.0 and reach[1] == 0.0:
        from_upper = departure(law, region, start, phases, -1.0, end)
        if from_upper == 0.0:
            return HIT, 0.0, 1.0, start[2], 0.0, free
    below = (NONE, end, 0.0, 0.0, end)
    if reach[0] > -math.inf:
        below = first_touch(law, region, start, phases, arrival, (1.0, reach[0]), (from_lower, end))
    if reach[1] < math.inf:
        verdict, s, value, error, clear = first_touch(
            law, region, start, phases, arrival, (-1.0, reach[1]), (from_upper, below[1])
        )
        if verdict != NONE:
            return verdict, s, 1.0, value, error, (from_lower, clear)
        if below[0] == HIT:
            instant = later(start[0], start[1], below[1])
            set_phases(law, instant[0], instant[1], arrival)
    if below[0] != NONE:
        return below[0], below[1], -1.0, below[2], below[3], (below[4], below[1])
    return NONE, end, 0.0, 0.0, 0.0, (end, end)
