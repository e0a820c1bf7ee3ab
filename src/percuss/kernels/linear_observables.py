"""Zeros and extremes of a linear observable of a motion, from the record of its events.

A linear observable is a (x - reference) + b x' + c x'' + d x''' with constant a, b, c, d. In a
flight it obeys the equation of motion itself, under the same combination of the force and its
derivatives:

    h = a (x - reference) + b x' + c x'' + d x''',    h'' + 2 A h' + K h = a F + b F' + c F'' + d F'''.

So h is a flight too, under a law that differs in its harmonics only, and `next_event` finds where
it passes zero with the proof it has for stops: the crossings of a displacement, and with the
derivative of an observable its extremes. Each search begins at the zero before, with a state from
the closed form of the flight itself: no rounding is carried from zero to zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import ULP, Pair, later, two_sum
from percuss.kernels.compile import formula, kernel
from percuss.kernels.contact import FORCE_ROUNDING, push, release_time
from percuss.kernels.event_location import HIT, NONE, departure
from percuss.kernels.flight import (
    Flight,
    constant_force,
    force_and_slopes,
    four_derivatives,
    move,
    place,
    set_phases,
)
from percuss.kernels.law_columns import (
    AMPLITUDE,
    COSINE,
    FIRST_HARMONIC,
    FIRST_KNOT,
    FORCE_BOUND,
    KNOT_ENTRIES,
    KNOT_FORCE,
    KNOT_SLOPE,
    KNOT_T,
    KNOT_T_LOW,
    KNOTS_A_ROW,
    LOWER,
    N_FORCE_BOUNDS,
    N_HARMONICS,
    N_KNOTS,
    NUMBER,
    OMEGA,
    OUTSIDE_FORCE,
    SINE,
    STIFFNESS,
    STOP_BOUND,
    STOP_DRAG,
    STOP_STIFFNESS,
    UPPER,
    Law,
)
from percuss.kernels.next_event import first_passage
from percuss.kernels.overdamped import (
    SET_IN,
    derivatives_by_parts,
    is_known_by_parts,
    stage_until,
)
from percuss.kernels.pieces import is_record, next_knot, time_to_knot
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    NEXT_REGION,
    SLOW_LANDING,
    V_AFTER,
    V_BEFORE,
    MotionRecord,
    flight_after,
    place_of_event,
    time_since_event,
)
from percuss.kernels.restitution import restitution_at
from percuss.kernels.sample import tail_hop

# The weights of x - reference, x', x'' and x'''.
Weights: TypeAlias = tuple[float, float, float, float]
# The displacement and its first five derivatives.
Derivatives: TypeAlias = tuple[float, float, float, float, float, float]
# Entries of the extremes.
LEAST, T_LEAST, GREATEST, T_GREATEST = range(4)
# Entries of the progress of a search: the row of the record, the time since its event, the side of
# a level, the level, and 1 where the event is a knot of a record.
ROW, SINCE, SINCE_LOW, SIDE, LEVEL, AT_KNOT = range(6)
PROGRESS_ENTRIES = 6
# The last step to a zero is this small a part of the way to it, or the search knows better.
NEXT_TO = 1e-6
# The first hops of a chatter's tail hold its extremes: the later ones are smaller.
TAIL_HOPS = 2
# No event on a bound.
NOWHERE = (False, 0.0, 0.0, 0.0)


class Observable(NamedTuple):
    """A linear observable, and the law of its derivative (`derive_law`).

    ``acts`` are the numbers of the first and the last region in which it acts, ``bound`` the
    number of a wall's bound, -1 for none: in contact with that wall it is the force of the wall.
    """

    reference: float
    weights: Weights
    acts: tuple[int, int]
    bound: int
    derived: Law


@kernel
def stop_weights(stop: Floats) -> Weights:
    """Return the weights of the force of a stop from its columns; of a wall it is none in flight."""
    if stop[STOP_BOUND] >= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    return -stop[STOP_STIFFNESS], -stop[STOP_DRAG], 0.0, 0.0


@kernel
def slope_weights(weights: Weights, bound: int) -> Weights:
    """Return the weights of the derivative of an observable.

    In contact a wall bears what else acts: that changes with the force alone.
    """
    if bound >= 0:
        return 0.0, 1.0, 0.0, 0.0
    return 0.0, weights[0], weights[1], weights[2]


class Scratch(NamedTuple):
    """Arrays of the shape (n_harmonics, 2) for the phases of a flight and of the search in it."""

    phases: Floats
    arrival: Floats
    begin: Floats
    walker: Floats
    end: Floats


@kernel
def derive_law(law: Law, weights: Weights, derived: Law) -> None:
    """Write the forces of a linear observable into ``derived``, a copy of the law."""
    a, b, c, d = weights
    for order in range(N_FORCE_BOUNDS):
        derived[0, FORCE_BOUND + order] = 0.0
    for j in range(int(law[0, N_HARMONICS])):
        row = FIRST_HARMONIC + j
        omega = law[row, OMEGA]
        if is_record(law, j):
            derive_record(law, a, b, derived)
            continue
        # A derivative turns (cosine, sine) to (omega sine, -omega cosine).
        even = a - c * omega * omega
        odd = (b - d * omega * omega) * omega
        cosine = even * law[row, COSINE] + odd * law[row, SINE]
        sine = even * law[row, SINE] - odd * law[row, COSINE]
        derived[row, COSINE] = cosine
        derived[row, SINE] = sine
        size = math.sqrt(even * even + odd * odd) * law[row, AMPLITUDE]
        derived[row, AMPLITUDE] = size
        for order in range(N_FORCE_BOUNDS):
            derived[0, FORCE_BOUND + order] += size
            size *= omega


@kernel
def derive_record(law: Law, a: float, b: float, derived: Law) -> None:
    """Write the bounds of a times the record plus b times its slope into ``derived``."""
    row = FIRST_HARMONIC + int(law[0, N_HARMONICS]) - 1
    # No slope of the record is larger than that of the whole force.
    steepest = law[0, FORCE_BOUND + 1]
    size = abs(a) * law[row, AMPLITUDE] + abs(b) * steepest
    derived[row, AMPLITUDE] = size
    derived[0, FORCE_BOUND] += size
    derived[0, FORCE_BOUND + 1] += abs(a) * steepest


@kernel
def derive_knots(law: Law, weights: Weights, derived: Law) -> None:
    """Write the knots of a linear observable into ``derived``: contacts are searched with them.

    A flight ends at a knot, and its search begins with force and slope of the flight itself.
    """
    a, b, _, _ = weights
    derived[0, OUTSIDE_FORCE] = a * law[0, OUTSIDE_FORCE]
    for k in range(int(law[0, N_KNOTS])):
        row = int(law[0, FIRST_KNOT]) + k // KNOTS_A_ROW
        first = KNOT_ENTRIES * (k % KNOTS_A_ROW)
        slope = law[row, first + KNOT_SLOPE]
        derived[row, first + KNOT_T] = law[row, first + KNOT_T]
        derived[row, first + KNOT_T_LOW] = law[row, first + KNOT_T_LOW]
        derived[row, first + KNOT_FORCE] = a * law[row, first + KNOT_FORCE] + b * slope
        derived[row, first + KNOT_SLOPE] = a * slope


@formula
def state_at(flight: Flight, s: Pair) -> Derivatives:
    """Return y and its first five derivatives a time s[0] + s[1] after the start of a flight.

    ``arrival`` receives the phases at s[0]; the second part is far below a phase of 1.
    """
    law, region, start, phases, arrival = flight
    y = 0.0
    v = start[2]
    if s[0] > 0.0:
        y, v = move(flight, s[0])
    else:
        copy_phases(phases, arrival)
    second, third, fourth, fifth = four_derivatives(law, region, start[3], arrival, y, v)
    if is_known_by_parts(flight, s[0], SET_IN):
        v, second, third, fourth, fifth = derivatives_by_parts(flight, s[0])
    late = s[1]
    return (
        y + late * v,
        v + late * second,
        second + late * third,
        third + late * fourth,
        fourth + late * fifth,
        fifth,
    )


@kernel
def next_zero(
    flight: Flight,
    derived: Law,
    shift: float,
    weights: Weights,
    span: tuple[Pair, float, bool],
    scratch: Scratch,
) -> tuple[Pair, float]:
    """Return the next time at which a linear observable changes its sign, and the sign before.

    ``shift`` is where the flight begins minus the reference, ``derived`` the law of the
    observable. ``span`` is the times since the start of the flight between which it is searched,
    and whether the first is a zero already. Times are sums of two parts: a float alone would
    carry its rounding to the next zero. The time is infinite where there is none; the sign 0
    where the observable vanishes all the time.
    """
    left, right, at_zero = span
    before = 0.0
    while True:
        # What is left after a fast decay is less than the rounding of what was before it.
        until = stage_until(flight.law, flight.region, left[0], right)
        part = (left, until, at_zero)
        zero, sign = zero_in_stage(flight, derived, shift, weights, part, scratch)
        if before * sign < 0.0:
            return left, before
        if zero[0] < until or until == right:
            return zero, sign
        before = sign if sign != 0.0 else before
        left = (until, 0.0)
        at_zero = False


@kernel
def zero_in_stage(
    flight: Flight,
    derived: Law,
    shift: float,
    weights: Weights,
    span: tuple[Pair, float, bool],
    scratch: Scratch,
) -> tuple[Pair, float]:
    """Return what `next_zero` does, within one stage of a fast decay."""
    law, region, start, _, arrival = flight
    a, b, c, d = weights
    left, right, at_zero = span
    y, v, second, third, fourth, _ = state_at(flight, left)
    rest = b * v + c * second + d * third
    value = 0.0 if at_zero else a * (shift + y) + rest
    slope = a * v + b * second + c * third + d * fourth
    force = a * (start[3] - law[region, STIFFNESS] * y) - law[region, STIFFNESS] * rest
    t, t_low = later(start[0], start[1] + left[1], left[0])
    copy_phases(arrival, scratch.begin)
    for j in range(scratch.begin.shape[0]):
        if is_record(law, j):
            scratch.begin[j, 0] = a * arrival[j, 0] + b * arrival[j, 1]
            scratch.begin[j, 1] = a * arrival[j, 1]
    search = Flight(derived, region, (t, t_low, slope, force), scratch.begin, scratch.end)
    longest = right - left[0]
    sign = 1.0 if value > 0.0 else -1.0
    if value == 0.0:
        free = departure(search, 1.0, longest)
        if free >= longest:
            return (math.inf, 0.0), 0.0
        sign = 1.0 if free > 0.0 else -1.0
    reach = (-value, math.inf) if sign > 0.0 else (-math.inf, -value)
    known = (0.0, 0.0)
    while True:
        verdict, s, _, speed, s_low, known = first_passage(
            search, reach, scratch.walker, known, longest
        )
        if verdict == NONE or s > longest or not abs(speed) < math.inf:
            return (math.inf, 0.0), sign
        if verdict == HIT:
            break
    # At least the next float, so that a search always goes on.
    high, low = two_sum(left[0], max(s, ULP * left[0]))
    low += left[1] + s_low
    # One step from the closed form of the flight itself.
    y, v, second, third, fourth, _ = state_at(flight, (high, low))
    slope = a * v + b * second + c * third + d * fourth
    step = -(a * (shift + y) + b * v + c * second + d * third) / slope if slope != 0.0 else 0.0
    if abs(step) < NEXT_TO * s:
        high, low = two_sum(high, low + step)
    return (high, low), sign


@kernel
def copy_phases(source: Floats, target: Floats) -> None:
    """Write one array of phases into another."""
    for j in range(source.shape[0]):
        target[j, 0] = source[j, 0]
        target[j, 1] = source[j, 1]


@kernel
def note_value(best: Floats, value: float, t: float) -> None:
    """Note a value of the observable if it is the least or the greatest so far."""
    if value < best[LEAST]:
        best[LEAST] = value
        best[T_LEAST] = t
    if value > best[GREATEST]:
        best[GREATEST] = value
        best[T_GREATEST] = t


@kernel
def acts_in(observable: Observable, number: int) -> bool:
    """Return whether an observable acts in the region of a number."""
    return observable.acts[0] <= number <= observable.acts[1]


@kernel
def value_at(flight: Flight, shift: float, weights: Weights, y: float, v: float) -> float:
    """Return an observable at displacement y and velocity v; ``arrival`` holds the phases there."""
    law, region, start, _, arrival = flight
    a, b, c, d = weights
    total = a * (shift + y) + b * v
    if c != 0.0 or d != 0.0:
        second, third, _, _ = four_derivatives(law, region, start[3], arrival, y, v)
        total += c * second + d * third
    return total


@kernel
def extremes_in_flight(
    flight: Flight,
    x: float,
    observable: Observable,
    span: tuple[Pair, float],
    best: Floats,
    scratch: Scratch,
    budget: int,
) -> Pair:
    """Note the extremes inside a flight from x, its ends left out; return how far they are known.

    At most ``budget`` extremes are looked for.
    """
    law, region = flight.law, flight.region
    shift = x - observable.reference
    a, b, c, _ = observable.weights
    s, until = span
    lower, upper = law[region, LOWER] - x, law[region, UPPER] - x
    at_zero = False
    for _ in range(budget):
        s, _ = next_zero(
            flight, observable.derived, 0.0, (0.0, a, b, c), (s, until, at_zero), scratch
        )
        if not s[0] < until:
            return until, 0.0
        at_zero = True
        y, v, second, _, _, _ = state_at(flight, s)
        # Between two events nothing lies beyond a bound but by rounding.
        y = min(max(y, lower), upper)
        t, _ = later(flight.start[0], flight.start[1] + s[1], s[0])
        note_value(best, a * (shift + y) + b * v + c * second, t)
    return s


@kernel
def meeting(
    law: Law, events: Floats, marks: Integers, row: int
) -> tuple[bool, float, float, float]:
    """Return whether an event meets a bound with a velocity, and its place, velocity and instant."""
    kind = marks[row, KIND]
    if kind not in (IMPACT, CROSSING, SLOW_LANDING):
        return False, 0.0, 0.0, 0.0
    at = place(law, int(marks[row, NEXT_REGION]), int(marks[row, BOUND]))
    return True, at, events[row, V_BEFORE], events[row, EVENT_T]


@kernel
def note_limit(
    flight: Flight,
    x: float,
    observable: Observable,
    s: float,
    met: tuple[bool, float, float, float],
    best: Floats,
) -> None:
    """Note the observable a time s after the start of a flight; ``met`` is the event there."""
    law, region = flight.law, flight.region
    y = 0.0
    v = flight.start[2]
    if s > 0.0:
        y, v = move(flight, s)
    else:
        copy_phases(flight.phases, flight.arrival)
    t, _ = later(flight.start[0], flight.start[1], s)
    if met[0]:
        # At the event the mass is on the bound, with the velocity of the table.
        y = met[1] - x
        v = met[2]
        t = met[3]
    y = min(max(y, law[region, LOWER] - x), law[region, UPPER] - x)
    shift = x - observable.reference
    value = value_at(flight, shift, observable.weights, y, v)
    if is_known_by_parts(flight, s, SET_IN):
        a, b, c, d = observable.weights
        v, second, third, _, _ = derivatives_by_parts(flight, s)
        value = a * (shift + y) + b * v + c * second + d * third
    note_value(best, value, t)


@kernel
def note_tail(
    flight: Flight,
    x: float,
    tail: tuple[float, float, Pair],
    observable: Observable,
    best: Floats,
) -> None:
    """Note an observable at the ends and the summits of the first hops of a chatter's tail.

    ``tail`` is the wall's restitution, how long the tail lasts, and its end.
    """
    law, _, start, _, arrival = flight
    restitution, whole, end = tail
    shift = x - observable.reference
    share = 1.0
    s = 0.0
    for _ in range(TAIL_HOPS):
        duration = whole * share * (1.0 - restitution)
        v0 = start[2] * share
        for part in (0.0, 0.5, 1.0):
            t, t_low = later(start[0], start[1], s + part * duration)
            set_phases(law, t, t_low, arrival)
            y = v0 * duration * part * (1.0 - part)
            v = v0 * (1.0 - 2.0 * part)
            note_value(best, value_at(flight, shift, observable.weights, y, v), t)
        s += duration
        share *= restitution
    # Where the hops end the force still acts, and the contact has not begun.
    t, t_low = end
    set_phases(law, t, t_low, arrival)
    y, v = tail_hop(restitution, start[2], whole, whole)
    note_value(best, value_at(flight, shift, observable.weights, y, v), t)


@kernel
def extremes_in_contact(
    flight: Flight, x: float, observable: Observable, bound: int, span: Pair, best: Floats
) -> None:
    """Note an observable in contact with a wall, where the mass is at rest at x.

    The wall of the observable bears all other forces; its extremes are the zeros of the force's
    derivative, which are found as a release is. After a period they repeat themselves.
    """
    law, region, start, _, _ = flight
    a = observable.weights[0]
    s, until = span
    if bound != observable.bound:
        acts = acts_in(observable, int(law[region, NUMBER]))
        held = a * (x - observable.reference) if acts else 0.0
        note_value(best, held, later(start[0], start[1], s)[0])
        return
    force = constant_force(law, region, x)
    begin = (start[0], start[1])
    now = later(start[0], start[1], s)
    to_knot = time_to_knot(law, now[0], now[1])
    # A contact may end at a knot: what the force is after it is not the wall's to bear.
    rounding = 4.0 * ULP * until
    while s + to_knot <= until + rounding:
        end = s + to_knot
        extremes_of_wall(flight, force, observable.derived, begin, (s, end), best)
        instant = later(begin[0], begin[1], s)
        knot = next_knot(law, instant[0], instant[1])
        note_end_of_wall(flight, force, instant, knot, best)
        until -= (knot[0] - begin[0]) + (knot[1] - begin[1])
        begin = knot
        s = 0.0
        to_knot = time_to_knot(law, knot[0], knot[1])
        if not until > rounding:
            return
    extremes_of_wall(flight, force, observable.derived, begin, (s, until), best)
    instant = later(begin[0], begin[1], s)
    note_end_of_wall(flight, force, instant, later(begin[0], begin[1], until), best)


@kernel
def note_end_of_wall(flight: Flight, force: float, begin: Pair, end: Pair, best: Floats) -> None:
    """Note what a wall bears at the end of a piece of a record: where that jumps, from before."""
    law, _, _, phases, arrival = flight
    set_phases(law, begin[0], begin[1], phases)
    set_phases(law, end[0], end[1], arrival)
    for j in range(arrival.shape[0]):
        if is_record(law, j):
            since = (end[0] - begin[0]) + (end[1] - begin[1])
            arrival[j, 0] = phases[j, 0] + phases[j, 1] * since
    note_value(best, -(force + force_and_slopes(law, arrival)[0]), end[0])


@kernel
def extremes_of_wall(
    flight: Flight, force: float, derived: Law, start: Pair, span: Pair, best: Floats
) -> None:
    """Note what a wall bears of a constant force and the drive, in one piece without its end.

    ``span`` is counted from the instant ``start``.
    """
    law, arrival = flight.law, flight.arrival
    # A search takes a period from the instant from which its time is counted.
    origin = later(start[0], start[1], span[0])
    s = 0.0
    until = span[1] - span[0]
    while s < until:
        instant = later(origin[0], origin[1], s)
        set_phases(law, instant[0], instant[1], arrival)
        note_value(best, -(force + force_and_slopes(law, arrival)[0]), instant[0])
        bend = derived[0, FORCE_BOUND + 2]
        if not bend > 0.0:
            return
        # A record's slope is the force of the derived law.
        set_phases(derived, instant[0], instant[1], arrival)
        heading = push(derived, 0.0, instant, arrival)
        if heading == 0.0:
            s = until
            continue
        sign = -1.0 if heading > 0.0 else 1.0
        # Past a zero the sign is that of an instant at which its slope has made itself felt.
        begin = s
        released = False
        while not released:
            released, s, _ = release_time(
                derived, sign, 0.0, (origin[0], origin[1]), begin, until, arrival
            )
            if not s < until:
                break
            begin = s
        if s < until:
            instant = later(origin[0], origin[1], s)
            set_phases(law, instant[0], instant[1], arrival)
            note_value(best, -(force + force_and_slopes(law, arrival)[0]), instant[0])
            s += math.sqrt(8.0 * (FORCE_ROUNDING * derived[0, FORCE_BOUND] / bend))
        s = min(s, until)


@kernel
def begin_search(progress: Floats) -> None:
    """Begin the search of a stretch; the side of the level stays."""
    progress[SINCE] = 0.0
    progress[SINCE_LOW] = 0.0


@kernel
def extremes_of_record(
    record: MotionRecord,
    observable: Observable,
    span: Pair,
    progress: Floats,
    best: Floats,
    scratch: Scratch,
    budget: int,
) -> bool:
    """Note the extremes of an observable between two instants; return whether all are known.

    ``progress`` is where the last call stopped, zeros at first; a call takes some ``budget``
    searches, so that its caller can react.
    """
    events, marks = record.events, record.marks
    row = int(progress[ROW])
    for _ in range(budget):
        if row >= events.shape[0] or events[row, EVENT_T] > span[1]:
            return True
        # An instant that is given is no finer than a float: that of an event has both limits.
        until = max(0.0, span[1] - events[row, EVENT_T] - events[row, EVENT_T_LOW])
        is_last = row + 1 >= events.shape[0]
        if not is_last:
            until = min(until, time_since_event(events, row + 1))
        begin = max(0.0, span[0] - events[row, EVENT_T] - events[row, EVENT_T_LOW])
        if not is_last and span[0] <= events[row + 1, EVENT_T]:
            begin = min(begin, until)
        # A stretch of no duration before a contact is no part of the motion.
        empty = not is_last and until <= 0.0 and marks[row + 1, KIND] == CONTACT
        if begin <= until and not empty:
            since = (progress[SINCE], progress[SINCE_LOW])
            reached = extremes_in_stretch(
                record, row, observable, (begin, since, until), best, scratch, budget
            )
            if reached[0] < until:
                progress[ROW] = row
                progress[SINCE], progress[SINCE_LOW] = reached
                return False
        row += 1
        progress[ROW] = row
        begin_search(progress)
    return False


@kernel
def extremes_in_stretch(
    record: MotionRecord,
    row: int,
    observable: Observable,
    span: tuple[float, Pair, float],
    best: Floats,
    scratch: Scratch,
    budget: int,
) -> Pair:
    """Note the extremes of a stretch that begins with an event; return how far they are known.

    ``span`` is where the stretch begins, how far it is known already, and where it ends, since
    the event.
    """
    marks = record.marks
    begin, since, until = span
    x = place_of_event(record, row)
    flight = flight_after(record, row, scratch.phases, scratch.arrival)
    region = flight.region
    if marks[row, KIND] == CONTACT:
        bound = int(marks[row, BOUND])
        extremes_in_contact(flight, x, observable, bound, (begin, until), best)
        return until, 0.0
    if not acts_in(observable, int(record.law[region, NUMBER])):
        t, _ = later(flight.start[0], flight.start[1], begin)
        note_value(best, 0.0, t)
        return until, 0.0
    is_last = row + 1 >= record.events.shape[0]
    if is_last and marks[row, KIND] == IMPACT and flight.start[2] == 0.0:
        outward = 1.0 if int(marks[row, BOUND]) == int(record.law[region, NUMBER]) else -1.0
        if outward * state_at(flight, (0.0, 0.0))[2] < 0.0:
            # A record may end with a plastic impact: the wall would hold the mass.
            return until, 0.0
    if marks[row, KIND] == IMPACT and not is_last and marks[row + 1, KIND] == CONTACT:
        events = record.events
        bound, after = int(marks[row, BOUND]), abs(events[row, V_AFTER])
        restitution = restitution_at(record.law, region, bound, after)
        end = (events[row + 1, EVENT_T], events[row + 1, EVENT_T_LOW])
        tail = (restitution, time_since_event(events, row + 1), end)
        note_tail(flight, x, tail, observable, best)
        return until, 0.0
    met = (False, 0.0, 0.0, 0.0)
    if not is_last and until >= time_since_event(record.events, row + 1):
        met = meeting(record.law, record.events, marks, row + 1)
    if since[0] == 0.0:
        at_end = begin >= until
        note_limit(flight, x, observable, begin, met if at_end else NOWHERE, best)
    first = since if since[0] > begin else (begin, 0.0)
    reached = extremes_in_flight(flight, x, observable, (first, until), best, scratch, budget)
    if reached[0] >= until:
        note_limit(flight, x, observable, until, met, best)
    return reached
