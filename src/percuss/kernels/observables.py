"""Observables and points of one motion of a batch, kept in place of its events.

A *stretch* is a flight, or a contact, between two events. Observables are counted from the instant
``since`` on, when a transient is over.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import ULP, Pair, arctangent, hypotenuse, logarithm, turns
from percuss.kernels.compile import formula, kernel
from percuss.kernels.event_location import within_bracket
from percuss.kernels.flight import (
    Flight,
    FlightStart,
    acceleration_and_jerk,
    derivative_bound,
    move,
)
from percuss.kernels.harmonic_flight import motion_of
from percuss.kernels.harmonic_observables import is_within, neighbour_in, place_in, shape_of_piece
from percuss.kernels.law_columns import (
    DAMPING,
    FORCE_BOUND,
    HARMONIC,
    LOWER,
    LOWER_ENTRY,
    NUMBER,
    PERIOD_TURNS,
    PERIOD_TURNS_LOW,
    QUICKEST,
    STEP,
    UPPER,
    UPPER_ENTRY,
    Law,
)
from percuss.kernels.linear_observables import LEVEL as SEARCHED_LEVEL
from percuss.kernels.linear_observables import PROGRESS_ENTRIES, Scratch, begin_search, state_at
from percuss.kernels.overdamped import (
    FADED,
    is_known_by_parts,
    pace_at,
    pace_until,
    slow_bound,
    slow_step,
)
from percuss.kernels.passages import next_passage
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    V_AFTER,
    V_BEFORE,
    Run,
)
from percuss.kernels.tangent import Matrix, product, propagator, scaled_propagator

# Entries of the observables of a motion, from ``since`` on: impacts and entries into soft stops,
# contacts, points written; the greatest impact speed; the least and the greatest x; the energy that
# impacts and the dashpots have taken, per unit mass; and x and v at the end, NaN before it.
IMPACTS, CONTACTS, POINTS, PEAK_SPEED, LOWEST, HIGHEST, LOST, DRAGGED, END_X, END_V = range(10)
# From the start on: where a neighbour is, the logarithm of the scale of that, and that of the
# factor of an area between neighbours.
AHEAD_X, AHEAD_V, STRETCHED, SHRUNK = range(10, 14)
# The loads, from ``since`` on (`loads`): the largest magnitudes of a stop's force and of the
# acceleration; the integrals of x^2, of the time in touch with a stop, and of the forcing's power.
PEAK_FORCE, PEAK_ACCELERATION, SQUARE, IN_TOUCH, WORK = range(14, 19)
# The progress of the search for passages (`linear_observables`).
SEARCHED = 19
N_OBSERVABLES = SEARCHED + PROGRESS_ENTRIES
# A longer row keeps the greatest impact speed of each of n stretches of time as well, from the
# start on: how many of their edges are passed, the n + 1 edges, and n speeds.
PASSED, EDGES = N_OBSERVABLES, N_OBSERVABLES + 1

# What a point is: nothing is written; (x, v) once a period; (cycle, v_after) at an impact on, or
# an entry into, a stop; (STRETCHED, SHRUNK, angle of the direction) once a period; (cycle, v) where
# a displacement is passed.
NO_POINTS, STROBES, IMPACT_POINTS, TANGENTS, PASSAGES = range(5)
# Columns of the points; the third is the bound's number, -1 for a strobe or a passage.
FIRST, SECOND, THIRD = range(3)
POINT_COLUMNS = 3

# Entries of the plan of a motion: observables and strobes begin at SINCE, strobes come every EVERY;
# the displacement whose passages are kept, and the sign of the velocity there, 0 for either.
SINCE, EVERY, UNTIL, LEVEL, WAY = range(5)
PLAN_ENTRIES = 5

# Nodes and weights of Gauss's rule with twelve points on [0, 1], and the steps of a search that it
# is applied to at once. Over a phase of h = 3 it leaves at most h^25 (12!)^4 / (25 (24!)^3) 2^23
# = 1e-19 of the integral of a square that is up to 1, whose phase is twice that of the motion.
NODES = (
    0.009219682876640378,
    0.0479413718147626,
    0.11504866290284765,
    0.20634102285669126,
    0.31608425050090994,
    0.43738329574426554,
    0.5626167042557344,
    0.6839157494990901,
    0.7936589771433087,
    0.8849513370971523,
    0.9520586281852375,
    0.9907803171233596,
)
WEIGHTS = (
    0.023587668193255706,
    0.05346966299765953,
    0.08003916427167321,
    0.10158371336153287,
    0.1167462682691773,
    0.12457352290670134,
    0.12457352290670134,
    0.1167462682691773,
    0.10158371336153287,
    0.08003916427167321,
    0.05346966299765953,
    0.023587668193255706,
)
POINTS_OF_A_SUM, STEPS_OF_A_SUM = 12, 3.0
# Steps to a turning point, from a secant, at most: the third of Newton's leaves rounding, but where
# a piece is long, as without a spring, halvings come before.
TURNING_STEPS = 60
# No piece of a flight is narrower than this part of a step.
NARROWEST = 1e-6
# Phase, or exponent, over which a neighbour is carried by the propagator itself.
LONGEST_PHASE = 200.0


class LoadSpace(NamedTuple):
    """Arrays that the loads of members are found in: a law, and what searches need."""

    derived: Law
    best: Floats
    scratch: Scratch


class Member(NamedTuple):
    """One motion of a batch: its run, its plan, and what is kept of it.

    ``stops`` are the columns of its stops (`linear_observables`).
    """

    run: Run
    plan: Floats
    values: Floats
    points: Floats
    stops: Floats
    loads: LoadSpace


@formula
def observe_event(member: Member, region: int, row: int, section: int) -> None:
    """Count the event of a row; ``region`` is the row of the region before it."""
    plan, values = member.plan, member.values
    law, events, marks = member.run.law, member.run.events, member.run.marks
    is_early = events[row, EVENT_T] < plan[SINCE]
    if is_early and values.shape[0] == N_OBSERVABLES:
        return
    kind = marks[row, KIND]
    if kind == CONTACT and not is_early:
        values[CONTACTS] += 1.0
    if kind == CROSSING:
        upper = marks[row, BOUND] > law[region, NUMBER]
        if law[region, UPPER_ENTRY if upper else LOWER_ENTRY] == 0.0:
            return
    elif kind != IMPACT:
        return
    if values.shape[0] > N_OBSERVABLES:
        note_peak(events[row, EVENT_T], abs(events[row, V_BEFORE]), values)
        if is_early:
            return
    instant = (events[row, EVENT_T], events[row, EVENT_T_LOW])
    speeds = (events[row, V_BEFORE], events[row, V_AFTER])
    observe_impact(member, instant, speeds, float(marks[row, BOUND]), section)


@formula
def observe_impact(member: Member, instant: Pair, speeds: Pair, bound: float, section: int) -> None:
    """Count an impact, or an entry into a soft stop; ``speeds`` are v before and after it."""
    values = member.values
    law = member.run.law
    before, after = speeds
    values[IMPACTS] += 1.0
    values[PEAK_SPEED] = max(values[PEAK_SPEED], abs(before))
    values[LOST] += 0.5 * (before - after) * (before + after)
    if section == IMPACT_POINTS:
        write_point(member, cycle_of(law, instant), after, bound)


@formula
def cycle_of(law: Law, instant: Pair) -> float:
    """Return the cycle of an instant, (t / period) mod 1."""
    part = turns(law[0, PERIOD_TURNS], law[0, PERIOD_TURNS_LOW], instant[0], instant[1])
    if part < 0.0:
        part += 1.0
    return part if part < 1.0 else 0.0


@formula
def observe_passages(
    member: Member, flight: Flight, x: float, in_contact: bool, until: float
) -> None:
    """Write the passages of a displacement on a stretch from x, which ends at ``until``."""
    plan, values = member.plan, member.values
    start = flight.start
    progress = values[SEARCHED : SEARCHED + PROGRESS_ENTRIES]
    progress[SEARCHED_LEVEL] = plan[LEVEL]
    begin_search(progress)
    scratch = member.loads.scratch
    longest = (until - start[0]) - start[1]
    passes = True
    while passes:
        passes, t, v = next_passage(flight, x - plan[LEVEL], in_contact, longest, progress, scratch)
        if passes and plan[SINCE] <= t <= plan[UNTIL] and plan[WAY] * v >= 0.0:
            write_point(member, cycle_of(flight.law, (t, 0.0)), v, -1.0)


@formula
def note_peak(t: float, speed: float, values: Floats) -> None:
    """Note the speed of an impact in the stretch of time that it falls into."""
    n = (values.shape[0] - EDGES - 1) // 2
    passed = int(values[PASSED])
    while passed <= n and t >= values[EDGES + passed]:
        passed += 1
    values[PASSED] = passed
    if 0 < passed <= n:
        peak = EDGES + n + passed
        values[peak] = max(values[peak], speed)


@formula
def write_point(member: Member, first: float, second: float, third: float) -> None:
    """Write a point over the oldest one."""
    values, points = member.values, member.points
    i = int(values[POINTS]) % points.shape[0]
    points[i, FIRST] = first
    points[i, SECOND] = second
    points[i, THIRD] = third
    values[POINTS] += 1.0


@formula
def is_strobe_due(member: Member, until: float) -> bool:
    """Return whether a strobe falls before ``until``."""
    instant = strobe_instant(member)
    return instant < until and instant <= member.plan[UNTIL]


@formula
def strobe_instant(member: Member) -> float:
    """Return the instant of the next strobe."""
    plan, values = member.plan, member.values
    return plan[SINCE] + values[POINTS] * plan[EVERY]


@kernel
def strobe(member: Member, flight: Flight, x: float, in_contact: bool, until: float) -> None:
    """Write the points of the strobes that fall on a stretch, up to ``until`` and not at it."""
    start = flight.start
    while is_strobe_due(member, until):
        instant = strobe_instant(member)
        y = 0.0
        v = 0.0
        s = (instant - start[0]) - start[1]
        if not in_contact:
            y, v = place_in(flight, max(s, 0.0))
        write_point(member, x + y, v, -1.0)


@kernel
def move_neighbour(
    law: Law, region: int, s: float, restitution: float, jump: Matrix, values: Floats
) -> None:
    """Take a neighbour along a flight and over the event at its end.

    ``jump`` is the event's saltation matrix, ``restitution`` the square root of its determinant.
    """
    stretch, x, v = stretched(law, region, s, jump, values)
    values[STRETCHED] += stretch
    lost = logarithm(restitution) if restitution > 0.0 else -math.inf
    values[SHRUNK] += 2.0 * (lost - law[region, DAMPING] * s)
    values[AHEAD_X] = x
    values[AHEAD_V] = v


@kernel
def stretched(
    law: Law, region: int, s: float, jump: Matrix, values: Floats
) -> tuple[float, float, float]:
    """Return the logarithm of a neighbour's distance over its scale, and the direction to it."""
    exponent = 0.0
    if s * law[region, QUICKEST] <= LONGEST_PHASE:
        matrix = propagator(law, region, s)
    else:
        # In a long flight the propagator itself would underflow.
        exponent, matrix = scaled_propagator(law, region, s)
    matrix = product(jump, matrix)
    ahead_x = values[AHEAD_X]
    ahead_v = values[AHEAD_V]
    x = matrix[0] * ahead_x + matrix[1] * ahead_v
    v = matrix[2] * ahead_x + matrix[3] * ahead_v
    size = hypotenuse(x, v)
    if size == 0.0:
        # In a contact all memory of the start is lost.
        return -math.inf, 0.0, 0.0
    return exponent + logarithm(size), x / size, v / size


@kernel
def keep_within(values: Floats) -> None:
    """Give a neighbour whose distance leaves the range of floats another scale."""
    x = values[AHEAD_X]
    v = values[AHEAD_V]
    if is_within((x, v)):
        return
    size = hypotenuse(x, v)
    values[STRETCHED] += logarithm(size)
    values[AHEAD_X] = x / size
    values[AHEAD_V] = v / size


@formula
def strobe_neighbour(member: Member, region: int, start: FlightStart, until: float) -> None:
    """Write the logarithms at the strobes that fall on a stretch, up to ``until``."""
    law, values = member.run.law, member.values
    while is_strobe_due(member, until):
        s = max((strobe_instant(member) - start[0]) - start[1], 0.0)
        if law[region, HARMONIC] == 1.0 and s * law[region, QUICKEST] < LONGEST_PHASE:
            ahead = (values[AHEAD_X], values[AHEAD_V])
            write_neighbour(member, region, s, neighbour_in(motion_of(law, region), s, ahead))
            continue
        stretch, x, v = stretched(law, region, s, (1.0, 0.0, 0.0, 1.0), values)
        shrunk = values[SHRUNK] - 2.0 * law[region, DAMPING] * s
        # After a contact no neighbour is left.
        write_point(member, values[STRETCHED] + stretch, shrunk, arctangent(v, x))


@kernel
def write_neighbour(member: Member, region: int, s: float, ahead: Pair) -> None:
    """Write the logarithms at a strobe, a time s after the start of a flight."""
    values = member.values
    shrunk = values[SHRUNK] - 2.0 * member.run.law[region, DAMPING] * s
    size = hypotenuse(ahead[0], ahead[1])
    stretch = logarithm(size) if size > 0.0 else -math.inf
    write_point(member, values[STRETCHED] + stretch, shrunk, arctangent(ahead[1], ahead[0]))


@kernel
def observe_extremes(flight: Flight, x: float, span: Pair, values: Floats) -> None:
    """Record the extremes of x on a part of a flight, counted from the flight's start.

    It is passed in pieces, of a step or less: v keeps its sign on a piece, or goes one way, or
    the piece lies between the extremes that are known already
    (docs/theory/first-event.md, "The highest point").
    """
    law, region = flight.law, flight.region
    s, end = span
    y, _ = move(flight, s)
    note_inside(law, region, x + y, values)
    while s < end:
        until = pace_until(law, region, s, end)
        observe_pieces(flight, x, (s, until), values)
        s = until


@kernel
def observe_pieces(flight: Flight, x: float, span: Pair, values: Floats) -> None:
    """Record the extremes of x on a part of a flight of one pace, without its beginning."""
    law, region, start, _, arrival = flight
    s, end = span
    y, v = move(flight, s)
    step = law[region, STEP] if law[region, STEP] > 0.0 else end - s
    slow = is_known_by_parts(flight, s, FADED)
    bound = 0.0
    if slow:
        step = min(slow_step(law, region), end - s)
        bound = slow_bound(flight)
    width = step
    second, third = acceleration_and_jerk(law, region, start[3], arrival, y, v)
    while s < end:
        s1 = min(end, s + width)
        y1, v1 = move(flight, s1)
        piece = s1 - s
        if not slow:
            bound = derivative_bound(law, region, law[0, FORCE_BOUND + 2], second, third, piece)
        turns, bends, low, high = shape_of_piece(piece, (y, v), (y1, v1), bound)
        known = values[LOWEST] <= x + low and x + high <= values[HIGHEST]
        if turns and not bends and not known and width > NARROWEST * step:
            width *= 0.5
            continue
        second, third = acceleration_and_jerk(law, region, start[3], arrival, y1, v1)
        if turns and not known and v * v1 < 0.0:
            top = x + turning_point(flight, (s, v), (s1, v1))
            note_inside(law, region, top, values)
        note_inside(law, region, x + y1, values)
        s = s1
        y = y1
        v = v1
        width = min(2.0 * width, step)


@formula
def note_inside(law: Law, region: int, x: float, values: Floats) -> None:
    """Record a displacement between two events: nothing lies beyond a bound but by rounding."""
    note_place(min(max(x, law[region, LOWER]), law[region, UPPER]), values)


@formula
def note_place(x: float, values: Floats) -> None:
    """Record a displacement where it is the least or the greatest so far."""
    values[LOWEST] = min(values[LOWEST], x)
    values[HIGHEST] = max(values[HIGHEST], x)


@kernel
def observe_work(flight: Flight, span: Pair, values: Floats) -> None:
    """Record the work of the dashpots on a part of a flight, counted from the flight's start."""
    law, region = flight.law, flight.region
    if law[region, DAMPING] == 0.0:
        return
    since, end = span
    drag = 0.0
    while since < end:
        until = pace_until(law, region, since, end)
        count, step = parts_of_a_sum(law, region, since, until)
        for i in range(count):
            left = since + i * step
            total = 0.0
            for k in range(POINTS_OF_A_SUM):
                _, v = move(flight, left + step * NODES[k])
                total += WEIGHTS[k] * v * v
            drag += step * total
        since = until
    values[DRAGGED] += 2.0 * law[region, DAMPING] * drag


@formula
def parts_of_a_sum(law: Law, region: int, since: float, until: float) -> tuple[int, float]:
    """Return into how many parts a stretch of one pace is cut to be summed, and their length."""
    duration = until - since
    pace = pace_at(law, region, since)
    longest = STEPS_OF_A_SUM * pace if pace > 0.0 else duration
    count = max(1, math.ceil(duration / longest))
    return count, duration / count


@kernel
def turning_point(
    flight: Flight,
    left: Pair,
    right: Pair,
) -> float:
    """Return the displacement where v vanishes between two (s, v) of different signs."""
    s = left[0] + (right[0] - left[0]) * left[1] / (left[1] - right[1])
    low = left[0]
    high = right[0]
    y = 0.0
    for _ in range(TURNING_STEPS):
        y, v, second, _, _, _ = state_at(flight, (s, 0.0))
        # What is missing to the turning point is v^2 / (2 x'').
        if v * v <= ULP * abs(second * y):
            break
        if v * left[1] > 0.0:
            low = s
        else:
            high = s
        s = within_bracket(s - v / second if second != 0.0 else s, low, high)
        if not low < s < high:
            break
    return y


@kernel
def end_at(flight: Flight, x: float, in_contact: bool, until: float, values: Floats) -> None:
    """Record where a motion ends."""
    start = flight.start
    values[END_X] = x
    values[END_V] = 0.0
    if not in_contact:
        y, v = move(flight, max((until - start[0]) - start[1], 0.0))
        values[END_X] = x + y
        values[END_V] = v


@formula
def set_neighbour(values: Floats) -> None:
    """Set out with a neighbour: any direction turns into that of the fastest growth."""
    values[AHEAD_X] = 0.8
    values[AHEAD_V] = 0.6


@kernel
def forget_neighbour(values: Floats) -> None:
    """Leave no neighbour, as a contact does."""
    values[STRETCHED] = -math.inf
    values[SHRUNK] = -math.inf
    values[AHEAD_X] = 0.0
    values[AHEAD_V] = 0.0


@kernel
def clear_observables(values: Floats) -> None:
    """Set the observables of a motion that begins."""
    for i in range(N_OBSERVABLES):
        values[i] = 0.0
    values[LOWEST] = math.inf
    values[HIGHEST] = -math.inf
    values[END_X] = math.nan
    values[END_V] = math.nan
    set_neighbour(values)
