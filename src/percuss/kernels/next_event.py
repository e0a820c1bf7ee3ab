"""The next event: where a flight first meets either bound of its region.

The flight is walked in steps of a fixed length. A step costs a few multiplications, for the state
after it is a fixed linear map of the state and of the force's phasors before it. On each step the
displacement lies between the Bernstein coefficients of the cubic through both ends, to within
h^4 / 384 times a bound of the fourth derivative: where these clear both bounds, no event has been
passed; any other step goes to `event_location`. Steps never enter a result: an event is computed
from the closed form at the start of the flight.

The steps are those of the fastest rate of a region. Where a fast part is small, as what is left of
a decay in a stiff stop or the answer to a force of very high frequency, and cannot reach a bound,
the amplitudes of the parts prove longer stretches free of events (`event_free_until`).
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import (
    Pair,
    cos_sin,
    cubic_minimum,
    exponential,
    hypotenuse,
    quintic_root,
)
from percuss.kernels.compile import formula, kernel
from percuss.kernels.event_location import HIT, NONE, Root, departure, first_root, locate_root
from percuss.kernels.flight import (
    Flight,
    derivative_bound,
    free_response,
    move,
    parts_of,
    uncertainty,
)
from percuss.kernels.law_columns import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    FORCE_BOUND,
    GAIN_IM,
    GAIN_RE,
    GROWTH,
    LOWER,
    OMEGA,
    OVERDAMPED,
    PER_STIFFNESS,
    RATE,
    SIMPLE,
    SLOW_ROOT,
    STEP,
    STEPS_AHEAD,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    UPPER,
    Law,
)
from percuss.kernels.step import (
    Ahead,
    derivatives_ahead,
    set_parts,
    size_of_steps,
    turn_parts,
    walk_ahead,
)
from percuss.kernels.vectors import (
    Eight,
    counting,
    entry_of,
    first_not_positive,
    greatest,
    least,
    magnitude,
    shifted,
)

# The phase of the quickest slow part over one stretch.
STRETCH_PHASE = 1.0
# Displacements are rounded here as in any flight; a clearance has to be larger than this part of
# the sizes involved.
COAST_SLACK = 1e-12
# A stretch is worth its search where it is this many steps of the walk.
WORTH = 128.0
# Stretches in one call: a few hundred ns each.
MOST_STRETCHES = 1000
# The free motion at some time: displacement and velocity of its oscillating or fast part, and the
# part of the slow one of two real roots.
Free: TypeAlias = tuple[float, float, float]
# After so many steps the walk starts afresh from the closed form: its own rounding stays below
# the slack, and a long flight can be left and taken up again without changing a bit.
STEPS_A_WALK = 64
# Walks of one flight between two calls of `event_free_until`, the first after one walk.
WALKS_TO_A_COAST = 8
# Allowance for the rounding of amplitudes, far more than it is.
AMPLITUDE_SLACK = 1e-9
# Rounding of a walk relative to the sizes of its terms: 64 steps of some 20 roundings each, with
# a margin of 30.
WALK_SLACK = 1e-11
THIRD = 1.0 / 3.0
# A flight is taken for a hop where, at the acceleration of its start, it lasts less than this part
# of a step, and that acceleration is no rounding of the forces. At BEYOND times its end it is in
# the wall, by this part of its first velocity times the time.
HOP = 0.8
LEAST_FALL = 1e-6
BEYOND = 1.25
HOP_DEPTH = 0.05
PAUSE = np.int64(3)  # the fourth verdict: no event up to the place reached


class NextEvent(NamedTuple):
    """The next event of a flight: as `Root`, at the lower (side -1) or the upper (+1) bound.

    ``free`` are the times up to which the lower and the upper bound are known to be clear.
    """

    verdict: np.int64
    s: float
    side: float
    value: float
    rest: float
    free: Pair


@kernel
def is_spread(law: Law, region: int, n: int) -> bool:
    """Return whether the slowest part of a motion is so slow that a stretch may be worth it.

    That needs a spring, no harmonic in exact resonance, and free motion that does not grow.
    """
    return slowest(law, region, n) * law[region, STEP] * WORTH < STRETCH_PHASE


@kernel
def slowest(law: Law, region: int, n: int) -> float:
    """Return the rate of the slowest part of a motion, infinite where the parts are not known."""
    if not law[region, STIFFNESS] > 0.0 or law[region, GROWTH] > 0.0:
        return math.inf
    rate = math.sqrt(law[region, STIFFNESS])
    if law[region, OVERDAMPED] == 1.0:
        rate = -law[region, SLOW_ROOT]
    for j in range(n):
        if law[region + 1 + j, GAIN_RE] == 0.0 and law[region + 1 + j, GAIN_IM] == 0.0:
            return math.inf
        rate = min(rate, law[FIRST_HARMONIC + j, OMEGA])
    return rate


@kernel
def event_free_until(
    flight: Flight,
    s: float,
    reach: tuple[float, float],
    longest: float,
) -> float:
    """Return a time since the start, at least s, up to which a flight provably has no event.

    Infinite if it never will. ``arrival`` is scratch; the parts of the motion must be known
    (`slowest`).
    """
    law, region, start, phases, arrival = flight
    rate = slowest(law, region, phases.shape[0])
    least = WORTH * law[region, STEP]
    width = math.inf
    for _ in range(MOST_STRETCHES):
        if s >= longest:
            break
        y, v = move(flight, s)
        free = free_part(law, region, start[3], arrival, y, v)
        if is_clear(law, region, start[3], arrival, free, reach, math.inf):
            return math.inf
        if not is_clear(law, region, start[3], arrival, free, reach, least):
            break
        width = min(width, STRETCH_PHASE / rate)
        while width > least and not is_clear(law, region, start[3], arrival, free, reach, width):
            width *= 0.5
        s += max(width, least)
        width *= 4.0
    return s


@kernel
def free_part(law: Law, region: int, force: float, phases: Floats, y: float, v: float) -> Free:
    """Return the free motion at (y, v): what the steady motions and the constant force leave."""
    z = y - force * law[region, PER_STIFFNESS]
    w = v
    for j in range(phases.shape[0]):
        steady, rate = steady_part(law, region, j, phases[j, 0], phases[j, 1])
        z -= steady
        w -= rate
    if law[region, OVERDAMPED] == 0.0:
        return z, w, 0.0
    slow = (w - law[region, FAST_ROOT] * z) / (2.0 * law[region, RATE])
    z -= slow
    return z, law[region, FAST_ROOT] * z, slow


@kernel
def steady_part(law: Law, region: int, j: int, cosine: float, sine: float) -> tuple[float, float]:
    """Return (y, v) of the steady motion of a harmonic whose phase has this cosine and sine."""
    harmonic = FIRST_HARMONIC + j
    real = law[region + 1 + j, GAIN_RE]
    imaginary = law[region + 1 + j, GAIN_IM]
    in_phase, quadrature = parts_of(law, harmonic, cosine, sine)
    # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
    y = in_phase * real + quadrature * imaginary
    return y, law[harmonic, OMEGA] * (quadrature * real - in_phase * imaginary)


@kernel
def steady_ends(
    law: Law, region: int, phases: Floats, width: float, size: float
) -> tuple[float, float, float, float, float, float]:
    """Return the steady motions over a stretch as (y, v, y, v at its ends, error, size).

    Those that are slow over it are summed at both ends, with the error of the cubic between them;
    the others add their amplitudes to the error. All add their amplitudes to ``size``.
    """
    y0 = 0.0
    v0 = 0.0
    y1 = 0.0
    v1 = 0.0
    error = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        gain = hypotenuse(law[region + 1 + j, GAIN_RE], law[region + 1 + j, GAIN_IM])
        swing = law[harmonic, AMPLITUDE] * gain
        size += swing
        angle = law[harmonic, OMEGA] * width
        if angle > STRETCH_PHASE:
            error += swing
            continue
        error += swing * angle**4 * (1.0 / 384.0)
        cosine = phases[j, 0]
        sine = phases[j, 1]
        y, v = steady_part(law, region, j, cosine, sine)
        y0 += y
        v0 += v
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], width, 0.0)
        cosine, sine = cosine * turn[0] - sine * turn[1], sine * turn[0] + cosine * turn[1]
        y, v = steady_part(law, region, j, cosine, sine)
        y1 += y
        v1 += v
    return y0, v0, y1, v1, error, size


@kernel
def is_clear(
    law: Law,
    region: int,
    force: float,
    phases: Floats,
    free: Free,
    reach: tuple[float, float],
    width: float,
) -> bool:
    """Return whether a motion is clear of both bounds for a time ``width``, which may be infinite.

    ``phases`` and ``free`` are those at its beginning. The parts that are slow over it stay
    together within the Bernstein coefficients of a cubic and its error, the others within their
    amplitudes, and the slow one of two real roots between its ends.
    """
    z, w, slow = free
    middle = force * law[region, PER_STIFFNESS]
    y0, v0, y1, v1, error, size = steady_ends(law, region, phases, width, abs(middle) + abs(slow))
    rate = math.sqrt(law[region, STIFFNESS])
    swing = abs(z)
    if law[region, OVERDAMPED] == 1.0:
        rate = math.inf
    elif law[region, RATE] == 0.0:
        # (z + b t) exp(-a t), the fourth derivative of which is below a^4 (abs(z) + 5 abs(b) / a).
        swing += 5.0 * abs(w + law[region, DAMPING] * z) / law[region, DAMPING]
    else:
        swing = hypotenuse(z, (w + law[region, DAMPING] * z) / law[region, RATE])
    size += swing
    if rate * width > STRETCH_PHASE:
        error += swing
    else:
        error += swing * (rate * width) ** 4 * (1.0 / 384.0)
        impulse, even, _ = free_response(law, region, width)
        drag = law[region, DAMPING] * impulse
        y0 += z
        v0 += w
        y1 += (even + drag) * z + impulse * w
        v1 += (even - drag) * w - law[region, STIFFNESS] * impulse * z
    low = min(y0, y1)
    high = max(y0, y1)
    if width < math.inf:
        third = width * (1.0 / 3.0)
        low = min(low, y0 + third * v0, y1 - third * v1)
        high = max(high, y0 + third * v0, y1 - third * v1)
    left = 0.0
    if slow != 0.0:
        left = slow * exponential(law[region, SLOW_ROOT] * width)
    low += middle + min(slow, left) - error
    high += middle + max(slow, left) + error
    slack = COAST_SLACK * (abs(low) + abs(high) + size)
    return low - slack > reach[0] and high + slack < reach[1]


@formula
def no_event(s: float, free: Pair) -> NextEvent:
    """Return that there is none up to s."""
    return NextEvent(NONE, s, 0.0, 0.0, 0.0, free)


@formula
def next_event(flight: Flight, x: float, walker: Floats, free: Pair, longest: float) -> NextEvent:
    """Return the next event of a flight, NONE if there is none before ``longest``.

    ``free`` is (0, 0) at the start; what comes back is to be passed in again after a GRAZE or a
    PAUSE.
    """
    law, region = flight.law, flight.region
    reach = (law[region, LOWER] - x, law[region, UPPER] - x)
    return first_passage(flight, reach, walker, free, longest)


@formula
def first_passage(
    flight: Flight, reach: Pair, walker: Floats, free: Pair, longest: float
) -> NextEvent:
    """Return what `next_event` does, for any two levels ``reach`` of the displacement y."""
    law, region, start, phases, _ = flight
    step = law[region, STEP]
    s = min(free[0], free[1])
    if s >= longest:
        return no_event(longest, free)
    if step == 0.0:
        end = s + fall_time(start[2], start[3], reach, longest)
        if end > s:
            event = first_event(flight, reach, free, end)
            if event.verdict != NONE:
                return event
        return no_event(longest, free)
    walks = int(s / (step * STEPS_A_WALK))
    if walks % WALKS_TO_A_COAST == 1 and is_spread(law, region, phases.shape[0]):
        # On a long flight only the slow parts may count.
        s = event_free_until(flight, s, reach, longest)
        free = (max(free[0], s), max(free[1], s))
        if s >= longest:
            return no_event(longest, free)
    y, v, load = set_out(flight, walker, s)
    if s > 0.0 and stays_clear(law, region, start[3], walker, y, v, reach):
        return no_event(longest, free)
    second, third = derivatives_ahead(law, region, start[3], walker, 0, y, v)
    if s == 0.0 and v * second < 0.0 and 2.0 * abs(v) < HOP * step * abs(second):
        event = event_of_hop(flight, reach, free, second, third)
        if event.verdict != NONE:
            return event
    # An error grows where the motion can: there each step begins from the closed form.
    count = 1 if law[region, GROWTH] > 0.0 else STEPS_AHEAD
    for _ in range(STEPS_A_WALK // STEPS_AHEAD):
        load += size_of_steps(law, region, start[3], walker, y, v)
        ahead = walk_ahead(law, region, start[3], walker, y, v)
        at = (s, y, v, second, third, load)
        margin, is_doubtful = margins_ahead(law, region, reach, at, ahead)
        k = 0 if is_doubtful else first_not_positive(margin, 0)
        while k < count:
            begin = s + step * k
            if begin >= longest:
                break
            known = (max(free[0], begin), max(free[1], begin))
            event = event_of_step(flight, walker, reach, known, (begin, load), ahead, k)
            if event.verdict != NONE:
                return event
            k = first_not_positive(margin, k + 1)
        s += step * count
        free = (max(free[0], s), max(free[1], s))
        if s >= longest:
            return no_event(longest, free)
        if count < STEPS_AHEAD:
            break
        turn_parts(law, region, walker)
        y = entry_of(ahead.y1, STEPS_AHEAD - 1)
        v = entry_of(ahead.v1, STEPS_AHEAD - 1)
        second, third = derivatives_ahead(law, region, start[3], walker, 0, y, v)
    return NextEvent(PAUSE, s, 0.0, 0.0, 0.0, free)


@kernel
def event_of_hop(flight: Flight, reach: Pair, free: Pair, second: float, third: float) -> NextEvent:
    """Return the landing of a hop from a bound, NONE where this search leaves it open.

    ``second`` and ``third`` are the derivatives at its start. The criterion of the first root is
    that of `event_of_step`.
    """
    law, region, v = flight.law, flight.region, flight.start[2]
    sign = 1.0 if v > 0.0 else -1.0
    far = reach[1] if v > 0.0 else -reach[0]
    least_fall = LEAST_FALL * (abs(flight.start[3]) + law[0, FORCE_BOUND])
    leaves = (reach[0] if v > 0.0 else reach[1]) == 0.0 and max(free[0], free[1]) == 0.0
    if not (leaves and abs(second) > least_fall):
        return no_event(0.0, free)
    step = law[region, STEP]
    fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, step)
    rise, fall, turn = abs(v), -sign * second, sign * third
    # Where the cubic of its start comes back, and a place where the hop is beyond the bound.
    inside = 0.25 * fall * fall - 2.0 * THIRD * rise * turn
    if not inside > 0.0:
        return no_event(0.0, free)
    guess = 2.0 * rise / (0.5 * fall + math.sqrt(inside))
    right = BEYOND * guess
    rest = right * right * fourth * (1.0 / 24.0)
    beyond = rise + right * (0.5 * THIRD * right * turn - 0.5 * fall + rest)
    highest = right * (rise + right * (0.5 * fall + 0.5 * THIRD * right * abs(turn) + rest))
    if not (right <= step and beyond < -HOP_DEPTH * rise and 2.0 * highest < far):
        return no_event(0.0, free)
    end, speed, s_low = locate_root(flight, (sign, 0.0), (0.0, right, guess))
    least = fourth * end**4 * (1.0 / 287.0)
    if THIRD * end * rise > least and -THIRD * end * sign * speed > least:
        return NextEvent(HIT, end, -sign, speed, s_low, free)
    return no_event(0.0, free)


@formula
def set_out(flight: Flight, walker: Floats, s: float) -> tuple[float, float, float]:
    """Return (y, v) where a walk begins, and the part of ``walk_error``'s load from before it.

    ``walker`` receives the parts of the force there.
    """
    law, region, start, phases, _ = flight
    y = 0.0
    v = start[2]
    step = law[region, STEP]
    load = step * step * (abs(start[3]) + law[0, FORCE_BOUND])
    if s > 0.0:
        y, v = move(Flight(law, region, start, phases, walker), s)
        set_parts(law, walker, walker)
    else:
        set_parts(law, phases, walker)
    if s > 0.0 or law[region, GROWTH] > 0.0:
        # The closed form that this walk begins from is rounded itself.
        doubt = uncertainty(flight, s)
        load = (doubt + uncertainty(flight, s + step)) / WALK_SLACK
    return y, v, load


@formula
def margins_ahead(
    law: Law,
    region: int,
    reach: tuple[float, float],
    begin: tuple[float, float, float, float, float, float],
    ahead: Ahead,
) -> tuple[Eight, bool]:
    """Return lower bounds of the clearance on the steps ahead, and whether the first is in doubt.

    ``begin`` is s, y, v, the second and the third derivative where they begin, and the load of
    ``walk_error``. A step that is clear here is clear to `clearances`, whose bound of the fourth
    derivative is that of the step alone.
    """
    s, y, v, second, third, load = begin
    step = law[region, STEP]
    sizes = magnitude(ahead.y) + magnitude(ahead.y1)
    sizes = sizes + (magnitude(ahead.v) + magnitude(ahead.v1)) * step
    slack = (sizes + load) * WALK_SLACK
    # Where the first step leaves a bound, what counts is the clearance divided by the time.
    rise = step * THIRD * v
    leaves_lower = s == 0.0 and reach[0] == 0.0
    leaves_upper = s == 0.0 and reach[1] == 0.0
    inner = ahead.y + ahead.v * (step * THIRD)
    last = ahead.y1 - ahead.v1 * (step * THIRD)
    low = least(least(inner, last), least(shifted(rise if leaves_lower else y, ahead.y1), ahead.y1))
    high = greatest(
        greatest(inner, last), greatest(shifted(rise if leaves_upper else y, ahead.y1), ahead.y1)
    )
    margin = least(low - reach[0], reach[1] - high) - slack
    # These come last: they wait for the derivatives.
    part = step**4 * (1.0 / 384.0)
    growth = law[region, BOUND_OF_V] * step * law[0, FORCE_BOUND + 2]
    fourth = law[region, BOUND_OF_X] * abs(second) + law[region, BOUND_OF_V] * abs(third)
    fourth += law[0, FORCE_BOUND + 2] + growth
    margin = (margin - counting() * (growth * part)) - fourth * part
    leaves = leaves_lower or leaves_upper
    return margin, leaves and not abs(rise) > (384.0 / 72.0) * fourth * part


@kernel
def stays_clear(
    law: Law,
    region: int,
    force: float,
    parts: Floats,
    y: float,
    v: float,
    reach: tuple[float, float],
) -> bool:
    """Return whether the amplitudes of a simple motion at (y, v) keep it off both bounds for ever.

    The steady part has the harmonic's amplitude times the gain, and sqrt(z^2 + z'^2 / K) of the
    free part z does not grow.
    """
    if law[region, SIMPLE] == 0.0:
        return False
    gain_re = law[region + 1, GAIN_RE]
    gain_im = law[region + 1, GAIN_IM]
    omega = law[FIRST_HARMONIC, OMEGA]
    push, rate = parts[0, 0], parts[0, 1]
    middle = force * law[region, PER_STIFFNESS]
    z = y - middle - (push * gain_re + rate * gain_im)
    w = v + omega * (push * gain_im - rate * gain_re)
    swing = law[FIRST_HARMONIC, AMPLITUDE] * math.sqrt(gain_re * gain_re + gain_im * gain_im)
    most = swing + math.sqrt(z * z + w * w * law[region, PER_STIFFNESS])
    most += AMPLITUDE_SLACK * (most + abs(middle))
    return middle - most > reach[0] and middle + most < reach[1]


@kernel
def fall_time(v: float, force: float, reach: tuple[float, float], longest: float) -> float:
    """Return a time within which a motion at constant acceleration meets any bound it ever does."""
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
        # Never 0, so that a start on a bound with a velocity into it is an event at once.
        time = max(2.0 * distance / speed, 1.0)
    return min(time, longest)


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
            below = min(first - bend * (1.0 / 72.0), min(last, y1) - error)
        if reach[1] == 0.0:
            above = -max(first + bend * (1.0 / 72.0), max(last, y1) + error)
    return below, above


@kernel
def walk_error(
    step: float, load: float, before: tuple[float, float], after: tuple[float, float]
) -> float:
    """Return a bound on the rounding of a step's ends; ``load`` is what the walk has gathered."""
    places = abs(before[0]) + abs(after[0])
    return WALK_SLACK * (load + places + step * (abs(before[1]) + abs(after[1])))


@formula
def event_of_step(
    flight: Flight,
    walker: Floats,
    reach: tuple[float, float],
    free: tuple[float, float],
    begin: tuple[float, float],
    ahead: Ahead,
    k: int,
) -> NextEvent:
    """Return the first event of a step, at once where it is a simple crossing.

    ``begin`` is the time at its beginning, and the load of ``walk_error``; ``walker`` holds the
    parts of the force k steps before.

    A root is the first one if the cubic through the beginning and the root has Bernstein
    coefficients above a twelfth of fourth * width^4 / 24 (and a margin for rounding), for
    tau^2 (1 - tau)^2 is at most a twelfth of the sum of the two inner Bernstein polynomials.
    """
    law, region, start = flight.law, flight.region, flight.start
    s, load = begin
    y, v = entry_of(ahead.y, k), entry_of(ahead.v, k)
    y1, v1 = entry_of(ahead.y1, k), entry_of(ahead.v1, k)
    step = law[region, STEP]
    second, third = derivatives_ahead(law, region, start[3], walker, k, y, v)
    fourth = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, step)
    margins = clearances(reach, s, step, load, (y, v), (y1, v1), fourth)
    if margins[0] > 0.0 and margins[1] > 0.0:
        return no_event(s + step, free)
    if (margins[0] > 0.0) != (margins[1] > 0.0) and max(free[0], free[1]) <= s:
        sign = 1.0 if margins[1] > 0.0 else -1.0
        distance = reach[0] if margins[1] > 0.0 else reach[1]
        slack = walk_error(step, load, (y, v), (y1, v1))
        begins = sign * (y - distance)
        from_bound = s == 0.0 and distance == 0.0
        if (begins > slack or from_bound) and sign * (y1 - distance) < -slack:
            second1, _ = derivatives_ahead(law, region, start[3], walker, k + 1, y1, v1)
            pace = sign * step
            ends = (begins, pace * v, pace * step * second)
            ends1 = (sign * (y1 - distance), pace * v1, pace * step * second1)
            bracket = (s, s + step, s + step * quintic_root(ends, ends1))
            end, speed, s_low = locate_root(flight, (sign, distance), bracket)
            width = end - s
            least = fourth * width**4 * (1.0 / 287.0) + (0.0 if from_bound else slack)
            if begins + THIRD * width * sign * v > least and -THIRD * width * sign * speed > least:
                return NextEvent(HIT, end, -sign, speed, s_low, free)
        elif begins > slack and sign * (y1 - distance) > slack:
            lowest = cubic_minimum(
                begins, step * sign * v, sign * (y1 - distance), step * sign * v1
            )
            if lowest > fourth * step**4 * (1.0 / 384.0) + slack:
                return no_event(s + step, free)
    return first_event(flight, reach, free, s + step)


@kernel
def first_event(
    flight: Flight,
    reach: tuple[float, float],
    free: tuple[float, float],
    end: float,
) -> NextEvent:
    """Return the first event up to ``end``, each bound searched from where it is known free."""
    start = flight.start
    from_lower, from_upper = free
    if from_lower == 0.0 and reach[0] == 0.0:
        from_lower = departure(flight, 1.0, end)
        if from_lower == 0.0:
            return NextEvent(HIT, 0.0, -1.0, start[2], 0.0, free)
    if from_upper == 0.0 and reach[1] == 0.0:
        from_upper = departure(flight, -1.0, end)
        if from_upper == 0.0:
            return NextEvent(HIT, 0.0, 1.0, start[2], 0.0, free)
    below = Root(NONE, end, 0.0, 0.0, end)
    if reach[0] > -math.inf:
        below = first_root(flight, (1.0, reach[0]), (from_lower, end))
    if reach[1] < math.inf:
        above = first_root(flight, (-1.0, reach[1]), (from_upper, below.s))
        if above.verdict != NONE:
            free = (from_lower, above.free)
            return NextEvent(above.verdict, above.s, 1.0, above.value, above.rest, free)
    if below.verdict != NONE:
        free = (below.free, below.s)
        return NextEvent(below.verdict, below.s, -1.0, below.value, below.rest, free)
    return no_event(end, (end, end))
