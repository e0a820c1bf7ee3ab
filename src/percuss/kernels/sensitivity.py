"""The derivative of a motion by parameters: its columns, carried over flights and events.

A column is the derivative of (x, v) at a fixed time. On a flight it obeys the flight's own
equation (`flight_columns`); at an event the neighbours arrive at another instant, and

    dt = (dd - dx) / v,   dv_before = dv + a_before dt,
    dv_after = -k dv_before - dr v_before,   dx' = dd - v_after dt,   dv' = dv_after - a_after dt

with the wall's displacement dd, the restitution's change dr and k the derivative of r(u) u. After
an event x is kept as its excess over the place of the event: in a chatter the hops are far
smaller than the place. A contact ends all memory; its start and its release have derivatives of
their own (docs/theory/sensitivities.md). A graze of a wall adds a jump to the velocity: NaN, since
the motion has no derivative there, 0 on the side without an impact, and on the other one the
coefficient of the square root.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import Pair, logarithm
from percuss.kernels.compile import formula, kernel
from percuss.kernels.contact import FORCE_ROUNDING
from percuss.kernels.flight import Flight, constant_force, force_and_slopes, place, set_phases
from percuss.kernels.flight_columns import (
    Change,
    ColumnWorkspace,
    column_after,
    moved_constant_force,
    moved_drive,
    respond,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    FORCE_BOUND,
    KNOT_RESTITUTION,
    KNOT_SPEED,
    KNOTS_LEFT,
    LOWER,
    LOWER_ENTRY,
    LOWER_RESTITUTION,
    N_HARMONICS,
    NUMBER,
    OMEGA,
    SLOW_ROOT,
    UPPER,
    UPPER_ENTRY,
    UPPER_RESTITUTION,
    Law,
)
from percuss.kernels.overdamped import (
    FADED,
    derivatives_by_parts,
    is_known_by_parts,
    time_to_fade,
)
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    KIND,
    KNOT,
    NEXT_REGION,
    RELEASE,
    SLOW_LANDING,
    V_AFTER,
    V_BEFORE,
    MotionRecord,
    flight_after,
    place_of_event,
    time_since_event,
)
from percuss.kernels.restitution import (
    kept_of_error,
    restitution_at,
    slow_restitution,
    table_of,
)
from percuss.kernels.sample import flight_at, hop_of_tail, is_tail
from percuss.kernels.tangent import propagator

# Columns of a row of `out`: the derivatives of the event's instant and of the velocities before and
# after it; the place of the event; and at a fixed time the excess of x after it over that, and v.
# Of these two the last one is v less the fast root times the excess: it sets off the slow part of
# an overdamped flight, and next to a strong dashpot it is what is left of both.
DT, DV_BEFORE, DV_AFTER, BASE, OFF, SPEED, PULL = range(7)
SENSITIVITY_COLUMNS = 7
# Columns of `begin`: the derivatives of x, v and t of the start.
BEGIN_X, BEGIN_V, BEGIN_T = range(3)


class VariedRecord(NamedTuple):
    """A motion whose derivatives are asked for: its record, the change and where it grazes walls.

    ``graze_times`` (n,) are the instants of grazes, in order, and ``jumps`` (n, n_parameters) what
    each adds to the velocity of each column: NaN where the motion has no derivative, 0 on the side
    on which it passes the wall without an impact.
    """

    record: MotionRecord
    change: Change
    graze_times: Floats
    jumps: Floats


@kernel
def moved_restitution(law: Law, rows: Floats, region: int, bound: int, speed: float) -> float:
    """Return the derivative of a wall's restitution at a fixed speed."""
    table = table_of(law, region, bound)
    if table == 0:
        lower = bound == int(law[region, NUMBER])
        return rows[region, LOWER_RESTITUTION if lower else UPPER_RESTITUTION]
    knot = table
    for _ in range(int(law[table, KNOTS_LEFT])):
        if law[knot + 1, KNOT_SPEED] > speed:
            break
        knot += 1
    if speed < law[table, KNOT_SPEED] or law[knot, KNOTS_LEFT] == 0.0:
        return rows[knot, KNOT_RESTITUTION]
    width = law[knot + 1, KNOT_SPEED] - law[knot, KNOT_SPEED]
    part = (speed - law[knot, KNOT_SPEED]) / width
    slope = (law[knot + 1, KNOT_RESTITUTION] - law[knot, KNOT_RESTITUTION]) / width
    low = rows[knot, KNOT_RESTITUTION] - slope * rows[knot, KNOT_SPEED]
    high = rows[knot + 1, KNOT_RESTITUTION] - slope * rows[knot + 1, KNOT_SPEED]
    return low + (high - low) * part


@formula
def moved_place(rows: Floats, law: Law, region: int, bound: int) -> float:
    """Return the derivative of the position of a bound of a region."""
    return rows[region, LOWER if bound == int(law[region, NUMBER]) else UPPER]


@kernel
def carry(varied: VariedRecord, begin: Floats, work: ColumnWorkspace, out: Floats) -> None:
    """Write the columns of each event into ``out`` (n_events, n_parameters, columns).

    ``begin`` (n_parameters, 3) are the derivatives of x, v and t of the start.
    """
    record, graze_times = varied.record, varied.graze_times
    law, events, marks = record.law, record.events, record.marks
    n_passed = 0
    now, then = work.phases, work.arrival
    flight = flight_after(record, 0, now, work.scratch)
    start_row(flight, begin, out)
    for n in range(1, events.shape[0]):
        first = n_passed
        while n_passed < graze_times.shape[0] and graze_times[n_passed] <= events[n, EVENT_T]:
            n_passed += 1
        kind = marks[n, KIND]
        following = flight_after(record, n, then, work.scratch)
        drive, slope, _ = force_and_slopes(law, then)
        force = following.start[3] + drive
        if kind == CONTACT:
            come_to_contact(varied, n, then, out)
        elif kind == RELEASE:
            release(varied, n, slope, then, out)
        else:
            s = time_since_event(events, n)
            fly(varied, flight, n - 1, s, work, out)
            for k in range(first, n_passed):
                add_jump(varied, flight.region, n - 1, k, s, work)
            rates = rates_before(record, n, flight, s, then, force)
            if kind == KNOT:
                last = now.shape[0] - 1
                jump = (now[last, 0] + now[last, 1] * s) - then[last, 0]
                pass_knot(varied, n, jump, force, work, out)
            elif kind == CROSSING:
                cross(varied, n, force, rates, work, out)
            else:
                strike(varied, n, force, rates, work, out)
        flight = following
        now, then = then, now


@kernel
def start_row(flight: Flight, begin: Floats, out: Floats) -> None:
    """Write the row of the START."""
    law, region, (_, _, v, force), phases, _ = flight
    force += force_and_slopes(law, phases)[0]
    for p in range(begin.shape[0]):
        row = out[0, p]
        row[DT] = begin[p, BEGIN_T]
        row[DV_BEFORE] = begin[p, BEGIN_V]
        row[DV_AFTER] = begin[p, BEGIN_V]
        row[BASE] = begin[p, BEGIN_X]
        set_off(row, law, region, v, force, 0.0)


@kernel
def rates_before(
    record: MotionRecord, n: int, flight: Flight, s: float, arrival: Floats, force: float
) -> Pair:
    """Return the velocity and the acceleration with which a flight of a time s comes to an event.

    ``arrival`` are the phases there and ``force`` the force without damping. After a fast decay
    dashpot and force balance but for the inertia: there both come from the parts of the flight.
    """
    if is_known_by_parts(flight, s, FADED):
        parts = Flight(flight.law, flight.region, flight.start, flight.phases, arrival)
        rates = derivatives_by_parts(parts, s)
        return rates[0], rates[1]
    v = record.events[n, V_BEFORE]
    return v, force - 2.0 * record.law[flight.region, DAMPING] * v


@formula
def set_off(row: Floats, law: Law, region: int, v: float, force: float, push: float) -> None:
    """Write the column at a fixed time, of a flight that sets off with v later by the row's DT.

    ``force`` is that without damping, ``push`` what is added to the velocity.
    """
    late = row[DT]
    row[OFF] = -v * late
    row[SPEED] = row[DV_AFTER] - (force - 2.0 * law[region, DAMPING] * v) * late + push
    # The acceleration less the fast root times v: both roots add up to -2 a.
    row[PULL] = row[DV_AFTER] - (force + law[region, SLOW_ROOT] * v) * late + push


@formula
def fly(
    varied: VariedRecord, flight: Flight, row: int, s: float, work: ColumnWorkspace, out: Floats
) -> None:
    """Write (OFF, SPEED) of all columns a time s after an event into ``work.ends``."""
    record, change = varied.record, varied.change
    law = record.law
    x = place_of_event(record, row)
    faded = s >= time_to_fade(law, flight.region)
    respond(flight, s, change, work)
    for p in range(out.shape[1]):
        rows = change.rows[p]
        begin = (out[row, p, OFF], out[row, p, PULL if faded else SPEED])
        force = moved_constant_force(law, rows, flight.region, x, out[row, p, BASE])
        off, speed = column_after(flight, rows, change.unit, begin, force, work)
        work.ends[p, 0] = off
        work.ends[p, 1] = speed


@kernel
def add_jump(
    varied: VariedRecord, region: int, row: int, k: int, s: float, work: ColumnWorkspace
) -> None:
    """Add to ``work.ends`` what the jump at a graze has become a time s after the event before it."""
    events = varied.record.events
    before = (varied.graze_times[k] - events[row, EVENT_T]) - events[row, EVENT_T_LOW]
    _, to_x, _, to_v = propagator(varied.record.law, region, s - before)
    for p in range(work.ends.shape[0]):
        work.ends[p, 0] += to_x * varied.jumps[k, p]
        work.ends[p, 1] += to_v * varied.jumps[k, p]


@formula
def strike(
    varied: VariedRecord, n: int, force: float, rates: Pair, work: ColumnWorkspace, out: Floats
) -> None:
    """Write the row of an impact; ``force`` is that at the wall without damping.

    ``rates`` are velocity and acceleration before it.
    """
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    region = int(marks[n - 1, NEXT_REGION])
    bound = int(marks[n, BOUND])
    before, acceleration = rates
    after = events[n, V_AFTER]
    kept = kept_of_error(law, region, bound, abs(before))
    for p in range(out.shape[1]):
        rows = change.rows[p]
        row = out[n, p]
        moved = moved_place(rows, law, region, bound)
        late = ((moved - out[n - 1, p, BASE]) - work.ends[p, 0]) / before
        row[BASE] = moved
        if marks[n, KIND] == SLOW_LANDING:
            # A speed within its rounding: the square root of a distance.
            late = math.nan
        row[DT] = late
        row[DV_BEFORE] = work.ends[p, 1] + acceleration * late
        change_of_r = moved_restitution(law, rows, region, bound, abs(before))
        row[DV_AFTER] = -kept * row[DV_BEFORE] - change_of_r * before
        set_off(row, law, region, after, force, 0.0)


@kernel
def cross(
    varied: VariedRecord, n: int, force: float, rates: Pair, work: ColumnWorkspace, out: Floats
) -> None:
    """Write the row of a crossing of the edge of a soft stop; arguments as those of `strike`."""
    record, change = varied.record, varied.change
    law, marks = record.law, record.marks
    before = int(marks[n - 1, NEXT_REGION])
    after = int(marks[n, NEXT_REGION])
    bound = int(marks[n, BOUND])
    v, acceleration = rates
    upwards = bound != int(law[before, NUMBER])
    for p in range(out.shape[1]):
        rows = change.rows[p]
        row = out[n, p]
        moved = moved_place(rows, law, before, bound)
        late = ((moved - out[n - 1, p, BASE]) - work.ends[p, 0]) / v
        row[DT] = late
        row[DV_BEFORE] = work.ends[p, 1] + acceleration * late
        row[DV_AFTER] = row[DV_BEFORE]
        row[BASE] = moved
        # Stops that share an edge may move apart: each jumps at its own.
        jumps = rows[before, UPPER_ENTRY if upwards else LOWER_ENTRY]
        set_off(row, law, after, v, force, jumps if upwards else -jumps)


@kernel
def pass_knot(
    varied: VariedRecord, n: int, jump: float, force: float, work: ColumnWorkspace, out: Floats
) -> None:
    """Write the row of a knot, over which the force falls by ``jump`` to ``force``."""
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    t = events[n, EVENT_T]
    if marks[n - 1, KIND] == RELEASE and time_since_event(events, n) == 0.0:
        # Held up to the knot, by a wall that cancelled the force.
        jump = -force
    elif abs(jump) <= FORCE_ROUNDING * law[0, FORCE_BOUND]:
        jump = 0.0
    for p in range(out.shape[1]):
        row = out[n, p]
        late = knot_delay(law, change.rows[p], t)
        row[DT] = late
        row[BASE] = out[n - 1, p, BASE] + work.ends[p, 0]
        row[OFF] = 0.0
        row[SPEED] = work.ends[p, 1] + jump * late
        row[PULL] = row[SPEED]
        slowing = 2.0 * law[int(marks[n, NEXT_REGION]), DAMPING] * events[n, V_AFTER]
        row[DV_BEFORE] = work.ends[p, 1] + (force + jump - slowing) * late
        row[DV_AFTER] = row[SPEED] + (force - slowing) * late


@kernel
def knot_delay(law: Law, rows: Floats, t: float) -> float:
    """Return the derivative of the instant of a knot."""
    return -t * rows[FIRST_HARMONIC + int(law[0, N_HARMONICS]) - 1, OMEGA]


@kernel
def come_to_contact(varied: VariedRecord, n: int, phases: Floats, out: Floats) -> None:
    """Write the row of a contact, after a chatter, a plastic impact, or at the start."""
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    region = int(marks[n, NEXT_REGION])
    bound = int(marks[n, BOUND])
    chatters = is_tail(events, marks, n - 1)
    drive, slope, bend = force_and_slopes(law, phases)
    # At rest on the wall, and nothing holds it there: what lifts it does so for good.
    idle = constant_force(law, region, place(law, region, bound)) + drive == slope == bend == 0.0
    for p in range(out.shape[1]):
        rows = change.rows[p]
        row = out[n, p]
        moved = moved_place(rows, law, region, bound)
        row[DT] = out[n - 1, p, DT]
        if chatters:
            row[DT] += moved_tail(varied, n - 1, p, phases, out)
        elif n == 1 and (out[0, p, BASE] != moved or out[0, p, DV_AFTER] != 0.0):
            # At rest on the wall: off it by dx the mass would come back after sqrt(2 dx / force).
            row[DT] = math.nan
        row[DV_BEFORE] = 0.0
        row[DV_AFTER] = 0.0
        row[BASE] = moved
        row[OFF] = 0.0
        row[SPEED] = 0.0
        row[PULL] = 0.0
        if idle:
            t, t_low = events[n, EVENT_T], events[n, EVENT_T_LOW]
            push, rate = moved_drive(law, rows, change.unit, t, t_low, phases)
            push += moved_constant_force(law, rows, region, place(law, region, bound), moved)
            if math.isnan(row[DT]) or push != 0.0 or rate != 0.0:
                row[BASE] = math.nan
                row[SPEED] = math.nan


@kernel
def moved_tail(varied: VariedRecord, n: int, p: int, phases: Floats, out: Floats) -> float:
    """Return the derivative of the time from a chatter's last listed impact to its end.

    That of the sum in `contact.chatter_time`; ``phases`` is scratch.
    """
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    rows = change.rows[p]
    region = int(marks[n, NEXT_REGION])
    bound = int(marks[n, BOUND])
    side = -1.0 if bound == int(law[region, NUMBER]) else 1.0
    t = events[n, EVENT_T]
    t_low = events[n, EVENT_T_LOW]
    set_phases(law, t, t_low, phases)
    drive, slope, bend = force_and_slopes(law, phases)
    late = out[n, p, DT]
    force, rate = moved_drive(law, rows, change.unit, t, t_low, phases)
    x = place(law, region, bound)
    force += moved_constant_force(law, rows, region, x, out[n, p, BASE]) + slope * late
    rate += bend * late
    pressing = side * (constant_force(law, region, x) + drive)
    speed = abs(events[n, V_AFTER])
    faster = -side * out[n, p, DV_AFTER]
    restitution, bend_of_r = slow_restitution(law, region, bound, speed)
    moved_r = moved_restitution(law, rows, region, bound, 0.0)
    moved_bend = 0.0
    if bend_of_r != 0.0:
        moved_bend = (moved_restitution(law, rows, region, bound, speed) - moved_r) / speed
    lost = 1.0 - restitution
    tau = 2.0 * speed / (pressing * lost)
    stronger = side * force / pressing
    longer_tau = tau * (faster / speed - stronger + moved_r / lost)
    change_of_force = side * slope / pressing
    tilt = -(change_of_force + law[region, DAMPING])
    moved_tilt = -(side * rate / pressing - change_of_force * stronger + rows[region, DAMPING])
    square = 1.0 - restitution * restitution
    longer = bend_of_r * speed / square
    moved_longer = (moved_bend * speed + bend_of_r * faster) / square
    moved_longer += 2.0 * restitution * moved_r * longer / square
    first = longer_tau * (1.0 + (2.0 * tilt * tau / 3.0 + longer))
    return first + tau * (moved_tilt * tau / 3.0 + moved_longer)


@kernel
def release(varied: VariedRecord, n: int, slope: float, phases: Floats, out: Floats) -> None:
    """Write the row of a release: the force at the wall, of that slope, is zero at its instant."""
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    region = int(marks[n, NEXT_REGION])
    bound = int(marks[n, BOUND])
    t = events[n, EVENT_T]
    t_low = events[n, EVENT_T_LOW]
    x = place(law, region, bound)
    at_knot = n + 1 < events.shape[0] and marks[n + 1, KIND] == KNOT
    at_knot = at_knot and time_since_event(events, n + 1) == 0.0
    for p in range(out.shape[1]):
        rows = change.rows[p]
        row = out[n, p]
        moved = moved_place(rows, law, region, bound)
        force, _ = moved_drive(law, rows, change.unit, t, t_low, phases)
        force += moved_constant_force(law, rows, region, x, moved)
        row[DT] = -force / slope if slope != 0.0 else math.nan
        if at_knot:
            row[DT] = knot_delay(law, rows, t)
        row[DV_BEFORE] = 0.0
        row[DV_AFTER] = 0.0
        row[BASE] = moved
        row[OFF] = 0.0
        row[SPEED] = 0.0
        row[PULL] = 0.0


@kernel
def columns_at(
    varied: VariedRecord,
    out: Floats,
    instants: Floats,
    after: bool,
    work: ColumnWorkspace,
    motion: Floats,
) -> None:
    """Write the columns of x and v at each instant into ``motion`` (2, n, n_parameters)."""
    record, graze_times = varied.record, varied.graze_times
    events, marks = record.events, record.marks
    for i in range(instants.shape[0]):
        row = flight_at(events, instants[i], after)
        s = (instants[i] - events[row, EVENT_T]) - events[row, EVENT_T_LOW]
        if instants[i] == events[row, EVENT_T]:
            s = 0.0
        if marks[row, KIND] == CONTACT:
            for p in range(out.shape[1]):
                motion[0, i, p] = out[row, p, BASE]
                motion[1, i, p] = out[row, p, SPEED]
        elif is_tail(events, marks, row):
            tail_columns(varied, out, row, s, i, motion)
        else:
            flight = flight_after(record, row, work.phases, work.scratch)
            fly(varied, flight, row, s, work, out)
            for k in range(graze_times.shape[0]):
                if events[row, EVENT_T] < graze_times[k] <= instants[i]:
                    add_jump(varied, flight.region, row, k, s, work)
            for p in range(out.shape[1]):
                motion[0, i, p] = out[row, p, BASE] + work.ends[p, 0]
                motion[1, i, p] = work.ends[p, 1]


@kernel
def tail_columns(
    varied: VariedRecord, out: Floats, row: int, s: float, i: int, motion: Floats
) -> None:
    """Write the columns in the summed tail of a chatter, of the parabolas that `sample` has there.

    Hop n begins at e = T (1 - r^n) with the velocity w = v r^n and is bent by
    p = 2 v / (T (1 - r)).
    """
    record, change = varied.record, varied.change
    law, events, marks = record.law, record.events, record.marks
    region = int(marks[row, NEXT_REGION])
    bound = int(marks[row, BOUND])
    v0 = events[row, V_AFTER]
    restitution = restitution_at(law, region, bound, abs(v0))
    whole = time_since_event(events, row + 1)
    hop = hop_of_tail(restitution, whole, s)
    for p in range(out.shape[1]):
        lossy = moved_restitution(law, change.rows[p], region, bound, 0.0)
        late = out[row, p, DT]
        moved = (out[row, p, DV_AFTER], lossy, late, out[row + 1, p, DT] - late)
        off, speed = moved_hop(restitution, v0, whole, hop, moved)
        motion[0, i, p] = out[row, p, BASE] + off
        motion[1, i, p] = speed


@kernel
def moved_hop(
    restitution: float,
    v0: float,
    whole: float,
    hop: tuple[float, float],
    moved: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Return the derivatives of a hop in the tail of a chatter, and of its velocity.

    The tail begins with the velocity v0 and lasts ``whole``; ``hop`` is what `hop_of_tail` gives.
    ``moved`` are the derivatives of v0, of the restitution, of the tail's begin and its duration.
    """
    share, since = hop
    faster, lossy, begin, longer = moved
    if share == 0.0:
        return 0.0, 0.0
    hops = logarithm(share) / logarithm(restitution) if restitution > 0.0 else 0.0
    moved_share = hops * share / restitution * lossy if hops > 0.0 else 0.0
    late = begin + longer * (1.0 - share) - whole * moved_share
    lost = 1.0 - restitution
    bend = 2.0 * v0 / (whole * lost)
    moved_bend = bend * (faster / v0 - longer / whole + lossy / lost)
    moved_v = faster * share + v0 * moved_share
    off = moved_v * since - v0 * share * late
    off += since * (bend * late - 0.5 * moved_bend * since)
    return off, moved_v - moved_bend * since + bend * late
