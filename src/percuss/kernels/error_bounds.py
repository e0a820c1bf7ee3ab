"""Bounds on the error of the start of each contact, by all rounding before it.

The rounding of each flight and event is carried along by the exact linear maps of the flights and
events that follow; nonlinear terms are bounded and added, so that the bound is rigorous and not
of first order only. The possible errors of an event form a zonotope: the sums of *generators*,
each a pair (error of its instant, of the velocity after it) times a number in [-1, 1]. Motions are
compared at equal times since their last event, so that a shift in time stays a shift in time; at
a knot of a record, whose instant is its own, the pair is the error of (x, v) at this instant. A
contact forgets all errors but that of its own instant (docs/theory/error-bounds.md has the proof).
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import ULP, Pair, cubic_minimum, exponential, later
from percuss.kernels.compile import kernel
from percuss.kernels.contact import CHATTER_LIMIT, FORCE_ROUNDING
from percuss.kernels.flight import (
    ROUNDING,
    Flight,
    acceleration_and_jerk,
    constant_force,
    derivative_bound,
    force_and_slopes,
    growth_of_rounding,
    move,
    place,
    set_phases,
    sizes,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FORCE_BOUND,
    GROWTH,
    LOWER,
    N_KNOTS,
    NUMBER,
    ORIGIN,
    ORIGIN_FORCE,
    QUICKEST,
    STEP,
    STIFFNESS,
    UPPER,
    Law,
)
from percuss.kernels.pieces import time_to_knot
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CONTACT_ERROR,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    KNOT,
    KNOT_X,
    NEXT_REGION,
    RELEASE,
    SLOW_LANDING,
    START,
    V_AFTER,
    V_BEFORE,
    MotionRecord,
    flight_after,
    place_of_event,
    time_since_event,
)
from percuss.kernels.restitution import (
    TABLE_ROUNDING,
    bend_of_impact,
    kept_of_error,
    restitution_at,
    table_of,
)
from percuss.kernels.tangent import delayed_start, propagator

# Generators that are kept. When they are used up the smaller half is merged, which is small
# compared with the rest.
GENERATORS = 96
# Generators that one event adds at most.
ADDED = 8
# Roundings of a landing's last step, relative to v: those of `event_location.is_settled`, and of
# the sum.
LANDING = 40 * ULP
# Rounding of a knot's instant, a sum of two doubles, relative to it.
KNOT_ROUNDING = 8 * ULP * ULP
# An error is carried on as long as it moves a velocity by no more than this part of it ...
PART = 0.25
# ... and an instant by no more than this part of the quickest motion's own time.
PHASE = 0.1
# Steps on one flight before its bound is infinite.
MOST_STEPS = 200_000
# Shortest step on which a flight is bounded, as a part of the flight.
SHORTEST = 1e-9

# A zonotope: the two rows of its generators, how many there are as one number, and scratch.
Errors: TypeAlias = tuple[Floats, Integers, Floats]


@kernel
def contact_errors(
    record: MotionRecord,
    begins: tuple[float, float, float],
    phases: Floats,
    arrival: Floats,
    errors: Errors,
    out: Floats,
) -> None:
    """Write a bound on the error of each contact's instant into ``out`` (n_contacts,).

    ``begins`` are the errors of x, v and t at the START; ``phases`` and ``arrival``
    (n_harmonics, 2) and ``errors`` are scratch. Where the errors may have changed what happens,
    infinity is written, for all contacts from there on.
    """
    events, marks = record.events, record.marks
    count = 0
    known = True
    # The errors of x and of the constant force at the start of the next flight.
    place = begins[0]
    doubt = 0.0
    for row in range(events.shape[0]):
        kind = marks[row, KIND]
        known = known and total(errors, 0) < math.inf
        if kind == CONTACT:
            out[count] = math.inf
            if known:
                out[count] = error_of_contact(record, row, begins[2], phases, errors)
                known = out[count] < math.inf
            count += 1
        elif kind == START:
            add(errors, begins[2], 0.0)
            add(errors, 0.0, begins[1])
            doubt = doubt_at_start(record, begins[0])
            known = is_between_knots(record, row, begins[2])
        elif kind == RELEASE:
            known = known and events[row, EVENT_T] - events[row - 1, EVENT_T] > out[count - 1]
            doubt = release_errors(record, row, phases, errors)
            if is_at_knot(record, row):
                # By the jump of the force, at its instant.
                errors[1][0] = 0
                doubt = 0.0
            known = known and is_between_knots(record, row, total(errors, 0))
        elif kind == SLOW_LANDING:
            # The window of the landing holds the rounding of its own flight, and of none before.
            known = known and errors[1][0] == 0 and place == 0.0
        elif kind == KNOT and marks[row - 1, KIND] == RELEASE and is_at_knot(record, row - 1):
            doubt = 0.0
        elif known:
            known = carry_along_flight(record, row, (place, doubt), phases, arrival, errors)
            place = 0.0
            doubt = 0.0
            if kind == KNOT:
                doubt = doubt_at_knot(record, row)
            else:
                known = known and is_between_knots(record, row, total(errors, 0))


@kernel
def add(errors: Errors, x: float, v: float) -> None:
    """Add a generator."""
    rows, count, _ = errors
    if x != 0.0 or v != 0.0:
        rows[0, count[0]] = x
        rows[1, count[0]] = v
        count[0] += 1


@kernel
def total(errors: Errors, row: int) -> float:
    """Return the largest error of x (row 0) or v (row 1); infinity where there is none."""
    rows, count, _ = errors
    size = 0.0
    for i in range(count[0]):
        size += abs(rows[row, i])
    # A NaN bounds nothing.
    if not size < math.inf:
        return math.inf
    return size


@kernel
def merge_smaller_half(errors: Errors) -> None:
    """Merge the smaller half of the generators into two where the next event may need more.

    The two span the parallelogram, along the largest of those merged, that holds them all.
    Position and velocity are compared by their own totals.
    """
    rows, count, size = errors
    n = int(count[0])
    if n + ADDED <= GENERATORS:
        return
    scale_x = max(total(errors, 0), 1e-300)
    scale_v = max(total(errors, 1), 1e-300)
    # Sorted by insertion: they are nearly in order.
    for i in range(n):
        x = rows[0, i]
        v = rows[1, i]
        far = abs(x) / scale_x + abs(v) / scale_v
        k = i
        while k > 0 and size[0, k - 1] < far:
            rows[0, k] = rows[0, k - 1]
            rows[1, k] = rows[1, k - 1]
            size[0, k] = size[0, k - 1]
            k -= 1
        rows[0, k] = x
        rows[1, k] = v
        size[0, k] = far
    half = n // 2
    along_x = rows[0, half] / scale_x
    along_v = rows[1, half] / scale_v
    length = math.sqrt(along_x * along_x + along_v * along_v)
    if not length > 0.0:
        count[0] = half
        return
    along_x /= length
    along_v /= length
    along = 0.0
    across = 0.0
    for i in range(half, n):
        x = rows[0, i] / scale_x
        v = rows[1, i] / scale_v
        along += abs(along_x * x + along_v * v)
        across += abs(along_x * v - along_v * x)
    count[0] = half
    add(errors, along * along_x * scale_x, along * along_v * scale_v)
    add(errors, -across * along_v * scale_x, across * along_x * scale_v)


@kernel
def doubt_at_start(record: MotionRecord, place: float) -> float:
    """Return the error of the constant force of the first flight, for that of its place."""
    law, x0, marks = record.law, record.x0, record.marks
    region = int(marks[0, NEXT_REGION])
    stiffness = abs(law[region, STIFFNESS])
    if x0 == law[region, LOWER] or x0 == law[region, UPPER]:
        return stiffness * place
    pull = stiffness * (abs(x0) + abs(law[region, ORIGIN]))
    return stiffness * place + 2.0 * ULP * (abs(law[region, ORIGIN_FORCE]) + pull)


@kernel
def doubt_at_knot(record: MotionRecord, row: int) -> float:
    """Return the rounding of the constant force of the flight from a knot."""
    law = record.law
    region = int(record.marks[row, NEXT_REGION])
    x = abs(place_of_event(record, row)) + abs(law[region, ORIGIN])
    return 2.0 * ULP * (abs(law[region, ORIGIN_FORCE]) + abs(law[region, STIFFNESS]) * x)


@kernel
def is_at_knot(record: MotionRecord, row: int) -> bool:
    """Return whether the row after this one is that of a knot at the same instant."""
    after = row + 1
    if after >= record.events.shape[0] or record.marks[after, KIND] != KNOT:
        return False
    return time_since_event(record.events, after) == 0.0


@kernel
def is_between_knots(record: MotionRecord, row: int, time_error: float) -> bool:
    """Return whether no knot lies within twice an error of the instant of a row, if that has one."""
    law, events = record.law, record.events
    if law[0, N_KNOTS] == 0.0 or time_error == 0.0:
        return True
    t, t_low = events[row, EVENT_T], events[row, EVENT_T_LOW]
    early = later(t, t_low, -2.0 * time_error)
    return time_to_knot(law, early[0], early[1]) > 4.0 * time_error


@kernel
def is_one_piece(record: MotionRecord, row: int, time: float) -> bool:
    """Return whether a row comes by a time, and the rounding of its instant, before the next knot."""
    t, t_low = record.events[row, EVENT_T], record.events[row, EVENT_T_LOW]
    return time_to_knot(record.law, t, t_low) > time


@kernel
def release_errors(record: MotionRecord, row: int, phases: Floats, errors: Errors) -> float:
    """Forget all errors at a release but its own; return that of the constant force after it.

    The flight is computed with a force that is zero at the instant found, and that of the motion
    is zero at its own.
    """
    law, events, marks = record.law, record.events, record.marks
    errors[1][0] = 0
    region = int(marks[row, NEXT_REGION])
    set_phases(law, events[row, EVENT_T], events[row, EVENT_T_LOW], phases)
    force = constant_force(law, region, place(law, region, int(marks[row, BOUND])))
    harmonic, slope, _ = force_and_slopes(law, phases)
    rounding = FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND])
    doubt = abs(force + harmonic) + rounding
    # The release is where the force changes sign: as far off as the doubt is of its slope.
    time_error = 2.0 * doubt / abs(slope) if slope != 0.0 else math.inf
    if not law[0, FORCE_BOUND + 2] * time_error < 0.5 * abs(slope):
        add(errors, math.inf, 0.0)
        return 0.0
    add(errors, time_error, 0.0)
    return doubt


@kernel
def carry_along_flight(
    record: MotionRecord,
    row: int,
    begins: Pair,
    phases: Floats,
    arrival: Floats,
    errors: Errors,
) -> bool:
    """Carry the errors along the flight to the event or knot of a row; return False if too large.

    ``begins`` are the errors of x and of the constant force at its start; from a knot those of x
    are among the generators.
    """
    law, events, marks = record.law, record.events, record.marks
    merge_smaller_half(errors)
    x = place_of_event(record, row - 1)
    flight = flight_after(record, row - 1, phases, arrival)
    region = flight.region
    s = time_since_event(events, row)
    released = marks[row - 1, KIND] == RELEASE
    from_knot = marks[row - 1, KIND] == KNOT
    to_knot = marks[row, KIND] == KNOT
    v = events[row, V_AFTER if to_knot else V_BEFORE]
    ends = (v, events[row, EVENT_T], events[row, EVENT_T_LOW])
    time_error = 0.0 if from_knot else total(errors, 0)
    far = total(errors, 0) if from_knot else begins[0]
    if from_knot and (x == law[region, LOWER] or x == law[region, UPPER]) and errors[1][0] > 0:
        # The motion may not be on the bound.
        return False
    # A flight that begins later is under another force all the time.
    shift = law[0, FORCE_BOUND + 1] * time_error
    spread = (far, total(errors, 1), begins[1] + shift)
    if not keeps_clear(flight, x, (released, to_knot), s, ends, spread):
        return False
    matrix = propagator(law, region, s)
    by_time = delayed_start(law, region, phases, s)
    rows, count, moved = errors
    for i in range(count[0]):
        by_first = (matrix[0], matrix[2]) if from_knot else by_time
        moved[0, i] = matrix[1] * rows[1, i] + by_first[0] * rows[0, i]
        rows[1, i] = matrix[3] * rows[1, i] + by_first[1] * rows[0, i]
        if from_knot:
            rows[0, i] = 0.0
    # From here on a generator is (of the instant at which the flight began, of v, of y) at s.
    move_by(errors, matrix[0] * begins[0], matrix[2] * begins[0])
    growth = growth_of_errors(law, region, s)
    bent = begins[1] + 0.5 * law[0, FORCE_BOUND + 2] * time_error * time_error
    move_by(errors, 0.5 * s * s * bent * growth, 0.0)
    move_by(errors, 0.0, s * bent * growth)
    size, speed = sizes(flight, s)
    rounding = ROUNDING * growth_of_rounding(law, region, s)
    distance = rounding * size + LANDING * abs(v) * s
    if to_knot:
        move_by(errors, distance, 0.0)
        move_by(errors, 0.0, rounding * speed)
        return stop_at_knot(flight, record, row, x, shift, errors)
    bound = place(law, region, int(marks[row, BOUND]))
    if bound != x:
        distance += ULP * (abs(bound) + abs(x))
    move_by(errors, distance, 0.0)
    move_by(errors, 0.0, rounding * speed + LANDING * abs(v))
    set_phases(law, events[row, EVENT_T], events[row, EVENT_T_LOW], phases)
    second, _ = acceleration_and_jerk(law, region, flight.start[3], phases, bound - x, v)
    if not carry_over_event(law, region, v, second, shift, errors):
        return False
    if marks[row, KIND] == IMPACT:
        at = int(marks[row, BOUND])
        restitution = restitution_at(law, region, at, abs(v))
        kept = kept_of_error(law, region, at, abs(v))
        bent = bend_of_impact(law, region, at, abs(v), total(errors, 1))
        rounding = 2.0 * ULP if table_of(law, region, at) == 0 else TABLE_ROUNDING
        for i in range(count[0]):
            rows[1, i] *= -kept
        add(errors, 0.0, rounding * restitution * abs(v) + bent)
    return True


@kernel
def stop_at_knot(
    flight: Flight, record: MotionRecord, row: int, x: float, shift: float, errors: Errors
) -> bool:
    """Turn errors at the end of a flight, a time after its start, into those at a knot's instant.

    A flight that begins later by dt has lasted for so much less: it is behind by v dt and a dt.
    ``shift`` is by how much its force may differ.
    """
    law, region, start, _, arrival = flight
    events = record.events
    rows, count, moved = errors
    s = time_since_event(events, row)
    y, v = move(flight, s)
    second, _ = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    far = 0.0
    for i in range(count[0]):
        far += abs(moved[0, i])
    fast = total(errors, 1)
    time_error = total(errors, 0)
    if not time_error * law[region, QUICKEST] <= PHASE:
        return False
    pull = 2.0 * abs(law[region, DAMPING]) * fast + abs(law[region, STIFFNESS]) * far + shift
    jerk = jerk_near(law, region, abs(v) + fast, abs(second) + pull, time_error)
    bend = abs(second) + pull + jerk * time_error
    for i in range(count[0]):
        moved[0, i] -= v * rows[0, i]
        rows[1, i] -= second * rows[0, i]
        rows[0, i] = moved[0, i]
    # The instant of the knot, the time up to it, and the place are rounded.
    late = KNOT_ROUNDING * abs(events[row, EVENT_T]) + 2.0 * ULP * s
    reached = events[row, KNOT_X]
    off = ULP * (abs(x) + abs(reached))
    if reached == law[region, LOWER] or reached == law[region, UPPER]:
        # Moved to the bound, by no more than the motion may be off.
        off += total(errors, 0)
    off += (fast + 0.5 * bend * time_error) * time_error
    add(errors, off + 2.0 * late * (abs(v) + late * abs(second)), 0.0)
    more = (pull + jerk * time_error) * time_error
    add(errors, 0.0, more + 2.0 * late * (abs(second) + 2.0 * law[0, FORCE_BOUND]))
    return True


@kernel
def move_by(errors: Errors, y: float, v: float) -> None:
    """Add a generator that moves the end of a flight and not its beginning."""
    rows, count, moved = errors
    if y != 0.0 or v != 0.0:
        rows[0, count[0]] = 0.0
        rows[1, count[0]] = v
        moved[0, count[0]] = y
        count[0] += 1


@kernel
def growth_of_errors(law: Law, region: int, s: float) -> float:
    """Return the factor by which an error of a displacement may grow in a time s.

    With negative damping c + a S, S / s and 2 D / s^2 are below exp(2 GROWTH s).
    """
    if law[region, GROWTH] == 0.0:
        return 1.0
    doubled = 2.0 if law[region, DAMPING] < 0.0 else 1.0
    return exponential(doubled * law[region, GROWTH] * s)


@kernel
def carry_over_event(
    law: Law, region: int, v: float, second: float, shift: float, errors: Errors
) -> bool:
    """Turn errors of y and v at the end of a flight into those of the event's instant and velocity.

    The motion itself meets the bound within ``time_error`` of the flight's end, and once, if its
    velocity keeps its sign there. ``shift`` is by how much its force may differ.
    """
    rows, count, moved = errors
    far = 0.0
    for i in range(count[0]):
        far += abs(moved[0, i])
    if far == 0.0:
        return True
    speed = abs(v)
    fast = total(errors, 1)
    time_error = 1.5 * far / speed if speed > 0.0 else math.inf
    if not time_error * law[region, QUICKEST] <= PHASE:
        return False
    pull = 2.0 * abs(law[region, DAMPING]) * fast + abs(law[region, STIFFNESS]) * far + shift
    jerk = jerk_near(law, region, speed + fast, abs(second) + pull, time_error)
    bend = abs(second) + pull + jerk * time_error
    if not fast + bend * time_error <= PART * speed:
        return False
    for i in range(count[0]):
        delay = -moved[0, i] / v
        rows[0, i] += delay
        rows[1, i] += second * delay
    more = (fast * time_error + 0.5 * bend * time_error * time_error) / speed
    add(errors, more, second * more)
    add(errors, 0.0, (pull + jerk * time_error) * time_error)
    return True


@kernel
def jerk_near(law: Law, region: int, speed: float, bend: float, s: float) -> float:
    """Return a bound of x''' up to a short time s before and after x' and x'' of these sizes.

    Backwards the damping makes it grow, by less than two as s is short.
    """
    return 2.0 * derivative_bound(law, region, law[0, FORCE_BOUND + 1], speed, bend, s)


@kernel
def keeps_clear(
    flight: Flight,
    x: float,
    kind: tuple[bool, bool],
    s: float,
    ends: tuple[float, float, float],
    spread: tuple[float, float, float],
) -> bool:
    """Return whether all motions within the errors of a flight meet nothing before it ends.

    ``kind`` is whether it begins with a release, and whether it ends at a knot; ``ends`` are the
    velocity and the instant at the end, ``spread`` the errors of x, v and of the constant force at
    the start. At first a motion goes away from a bound where it began, at last
    towards that where it ends; in between it is bounded on steps as long as possible.
    """
    law, region, start, phases, arrival = flight
    fast = spread[1]
    released, to_knot = kind
    _, _, v0, force = start
    longest = min(s, law[region, STEP]) if law[region, STEP] > 0.0 else s
    if longest == 0.0:
        return True
    second, third = acceleration_and_jerk(law, region, force, phases, 0.0, v0)
    left = 0.0
    if x == law[region, LOWER] or x == law[region, UPPER]:
        if released:
            second = 0.0
        left = time_away(law, region, (v0, second, third), fast, longest)
        if not left > 0.0:
            return False
    reach = (law[region, LOWER] - x, law[region, UPPER] - x)
    if to_knot:
        return is_clear(flight, reach, (left, s), longest, spread)
    set_phases(law, ends[1], ends[2], arrival)
    v1 = ends[0]
    y1 = 0.0
    if v1 > 0.0 or v1 < 0.0:
        y1 = (law[region, UPPER] if v1 > 0.0 else law[region, LOWER]) - x
    last, _ = acceleration_and_jerk(law, region, force, arrival, y1, v1)
    right = s - time_away(law, region, (v1, last, 0.0), 0.0, longest)
    return is_clear(flight, reach, (left, right), longest, spread)


@kernel
def time_away(
    law: Law,
    region: int,
    derivatives: tuple[float, float, float],
    fast: float,
    longest: float,
) -> float:
    """Return for how long a motion with these first three derivatives keeps its direction.

    The first derivative that is not zero keeps half of its size that long. Return 0 where its
    error may reverse it.
    """
    v, second, third = derivatives
    if v != 0.0:
        if not fast <= PART * abs(v):
            return 0.0
        bend = abs(second) + jerk_near(law, region, abs(v), abs(second), longest) * longest
        return min(longest, 0.5 * abs(v) / bend) if bend > 0.0 else longest
    if second != 0.0:
        jerk = jerk_near(law, region, 0.0, abs(second), longest)
        return min(longest, 0.5 * abs(second) / jerk) if jerk > 0.0 else longest
    force_bound = law[0, FORCE_BOUND + 2]
    snap = 2.0 * derivative_bound(law, region, force_bound, 0.0, abs(third), longest)
    return min(longest, 0.5 * abs(third) / snap) if snap > 0.0 else 0.0


@kernel
def is_clear(
    flight: Flight,
    reach: tuple[float, float],
    span: tuple[float, float],
    longest: float,
    spread: tuple[float, float, float],
) -> bool:
    """Return whether a part of a flight keeps farther from both bounds than its errors reach."""
    law, region, start, _, arrival = flight
    left, right = span
    width = longest
    y, v = move(flight, left)
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    for _ in range(MOST_STEPS):
        if left >= right:
            return True
        width = min(width, right - left)
        end = left + width
        bow = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, width)
        y1, v1 = move(flight, end)
        needed = bow * width**4 / 384.0 + reach_of_errors(flight, end, spread)
        a = width * v
        b = width * v1
        lowest = (
            cubic_minimum(y - reach[0], a, y1 - reach[0], b) if reach[0] > -math.inf else needed
        )
        highest = (
            cubic_minimum(reach[1] - y, -a, reach[1] - y1, -b) if reach[1] < math.inf else needed
        )
        if lowest >= needed and highest >= needed:
            left = end
            y = y1
            v = v1
            second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
            width = min(2.0 * width, longest)
        else:
            width *= 0.5
            if not width > SHORTEST * span[1]:
                return False
    return False


@kernel
def reach_of_errors(
    flight: Flight,
    s: float,
    spread: tuple[float, float, float],
) -> float:
    """Return a bound on the error of x within a time s of a flight's start, rounding included."""
    law, region = flight.law, flight.region
    far, fast, doubt = spread
    rounding = ROUNDING * growth_of_rounding(law, region, s)
    size = (far + s * fast + 0.5 * s * s * doubt) * growth_of_errors(law, region, s)
    return 2.0 * (size + rounding * sizes(flight, s)[0])


@kernel
def error_of_contact(
    record: MotionRecord, row: int, start_error: float, phases: Floats, errors: Errors
) -> float:
    """Return a bound on the error of a contact's instant; infinity if it may not happen."""
    law, events, marks = record.law, record.events, record.marks
    low = abs(events[row, EVENT_T_LOW])
    if marks[row - 1, KIND] == START:
        return start_error + low
    if marks[row - 1, KIND] == SLOW_LANDING:
        if not is_between_knots(record, row, events[row, CONTACT_ERROR]):
            return math.inf
        return events[row, CONTACT_ERROR] + low
    before = row - 1
    if marks[before, KIND] == KNOT:
        return math.inf
    region = int(marks[before, NEXT_REGION])
    upper = marks[before, BOUND] != law[region, NUMBER]
    set_phases(law, events[before, EVENT_T], events[before, EVENT_T_LOW], phases)
    force = constant_force(law, region, place(law, region, int(marks[before, BOUND])))
    harmonic, slope, _ = force_and_slopes(law, phases)
    side = 1.0 if upper else -1.0
    pressing = side * (force + harmonic)
    time_error = total(errors, 0)
    whole = time_since_event(events, row)
    # All of the chatter is under one piece of a record.
    if law[0, N_KNOTS] > 0.0 and not is_one_piece(record, before, 2.0 * (time_error + whole)):
        return math.inf
    # The contact is certain only if the force presses at all instants at which it may begin.
    change = abs(slope) + law[0, FORCE_BOUND + 2] * time_error
    doubt = FORCE_ROUNDING * (abs(force) + law[0, FORCE_BOUND])
    if not (doubt + change * time_error < 0.5 * pressing):
        return math.inf
    speed = abs(events[before, V_AFTER])
    if speed == 0.0:
        return time_error + low
    fast = total(errors, 1) / speed
    pace = max(abs(slope) / pressing, math.sqrt(law[0, FORCE_BOUND + 2] / pressing))
    pace = max(pace, law[region, QUICKEST])
    if not (fast <= PART and pace * time_error <= PHASE):
        return math.inf
    # The time left is in proportion to the speed and to 1 / force, to the order of its smallness.
    rows, count, _ = errors
    size = 0.0
    for i in range(count[0]):
        gain = -side * rows[1, i] / speed - rows[0, i] * side * slope / pressing
        size += abs(rows[0, i] + whole * gain)
    off = fast + pace * time_error
    size += whole * (4.0 * off * off + 10.0 * whole * pace * off)
    if table_of(law, region, int(marks[before, BOUND])) > 0:
        # The time left is in proportion to the speed but for the change of the restitution.
        size += 2.0 * CHATTER_LIMIT * whole * off
    return size + events[row, CONTACT_ERROR] + low
