"""The derivative of a structure's motion by parameters, carried over its flights and events.

A column is the derivative of (x, v) at a fixed time. On a flight it obeys the flight's own
equation (`structure.columns`); at an event at which the clearance h falls with the speed h', the
neighbours arrive later by dt = -dh / h', and with the rates f of the state before and after it

    column+ = J (column- + f- dt) + dJ - f+ dt,

where the jump J of an impact and the change dJ of its restitution and its direction M^-1 c are
linear. In a contact the columns are those of the structure that the wall holds where it is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import kernel
from percuss.kernels.contact import FORCE_ROUNDING
from percuss.kernels.law_columns import FORCE_BOUND
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    KNOT,
    NEXT_REGION,
    RELEASE,
    SLOW_LANDING,
    START,
    V_AFTER,
    V_BEFORE,
)
from percuss.kernels.sample import flight_at, hop_of_tail
from percuss.kernels.sensitivity import moved_hop, moved_restitution
from percuss.kernels.structure.basis import DRAG, SELF_DRAG, SPRING, basis_of, wall_of
from percuss.kernels.structure.columns import (
    MovedSets,
    SeriesWorkspace,
    begin_series,
    column_changes,
    fill_columns,
    fill_modes,
    fill_phases,
    moved_force,
    new_series,
)
from percuss.kernels.structure.flight import ModalFlight, U, W, arrive, derivatives, inputs
from percuss.kernels.structure.run import StructureRun, load_at, restitution, value_of
from percuss.kernels.structure.sample import flight_after, held_after, tail_after
from percuss.kernels.structure.tangent import (
    carry,
    kept_of,
    pace,
    set_of_flight,
    strike_column,
    to_modes,
    to_places,
)

# Rows of the derivatives of an event: of its instant, and of the velocity of the clearance before
# and after it, which move along with it.
DT, DV_BEFORE, DV_AFTER = range(3)
MOVED_ENTRIES = 3
# Two walls are struck at one instant also by the neighbours where the instants of both move alike,
# to this part of them, and of the terms that they are differences of.
ALIKE, ROUNDED = 1e-9, 1e-12


class VariedRun(NamedTuple):
    """A motion whose derivatives are asked for: its record, the change and where it grazes walls.

    ``graze_times`` (k,) are the instants of grazes, in order, ``graze_stops`` (k,) the stops, and
    ``jumps`` (k, p) what each adds to the velocity of its clearance in each column, as an impulse
    does: NaN where the motion has no derivative, 0 on the side on which it passes without an
    impact.
    """

    run: StructureRun
    moved: MovedSets
    graze_times: Floats
    graze_stops: Integers
    jumps: Floats


class ColumnRecord(NamedTuple):
    """The columns of all events, of p parameters.

    instants: (n_events, 3, p), derivatives of each event's instant and of the velocities of its
    clearance; places: (n_events, 2, n, p), the columns of x and v just after it; gaps: (n_events,
    p), that of its clearance, which after an impact is far smaller than the place.
    """

    instants: Floats
    places: Floats
    gaps: Floats


class CarryWorkspace(NamedTuple):
    """Scratch: columns of modes and their changes (n, 2, p), of coordinates and theirs (2, n, p).

    ``gaps`` (s, p) are the derivatives of the clearances at the start of a flight, ``paces``
    (2, 2, n) the rates of the state before and after an event, ``forces`` (p,) those of a wall.
    """

    columns: Floats
    changes: Floats
    place: Floats
    shift: Floats
    gaps: Floats
    paces: Floats
    forces: Floats
    series: SeriesWorkspace


def new_columns(varied: VariedRun) -> tuple[ColumnRecord, CarryWorkspace]:
    """Return arrays for the columns of a run, and scratch."""
    run = varied.run
    rows, (n, m, r) = len(run.events), (len(run.begin), len(run.phases), len(run.records))
    s, p = varied.moved.levels.shape
    record = ColumnRecord(
        np.zeros((rows, MOVED_ENTRIES, p)), np.zeros((rows, 2, n, p)), np.zeros((rows, p))
    )
    work = CarryWorkspace(
        np.zeros((n, 2, p)),
        np.zeros((n, 2, p)),
        np.zeros((2, n, p)),
        np.zeros((2, n, p)),
        np.zeros((s, p)),
        np.zeros((2, 2, n)),
        np.zeros(p),
        new_series(n, m, r, p),
    )
    return record, work


@kernel
def time_to(run: StructureRun, row: int) -> float:
    """Return the time from the event before one to it."""
    s = run.events[row, EVENT_T] - run.events[row - 1, EVENT_T]
    return s + (run.events[row, EVENT_T_LOW] - run.events[row - 1, EVENT_T_LOW])


@kernel
def carry_columns(
    varied: VariedRun, begin: Floats, record: ColumnRecord, work: CarryWorkspace
) -> None:
    """Write the columns of each event of a run.

    ``begin`` (2 n + 1, p) are the derivatives of x, v and t of the start.
    """
    run = varied.run
    n, n_parameters = work.place.shape[1], work.place.shape[2]
    flight = flight_after(run, 0)
    pace(run.sets, run.marks[0, NEXT_REGION], flight, run.begin, run.phases, 0.0, work.paces[0])
    for p in range(n_parameters):
        late = begin[2 * n, p]
        record.instants[0, DT, p] = late
        for i in range(n):
            record.places[0, 0, i, p] = begin[i, p] - work.paces[0, 0, i] * late
            record.places[0, 1, i, p] = begin[n + i, p] - work.paces[0, 1, i] * late
    for row in range(1, run.events.shape[0]):
        s = time_to(run, row)
        b = set_of_flight(run, row - 1, False)
        fly(varied, record, row - 1, b, s, work)
        cross_columns(varied, record, row, s, work)


@kernel
def clear_of(varied: VariedRun, place: Floats, stop: int, p: int) -> float:
    """Return the derivative of the clearance to a stop from a column of the coordinates."""
    gap = -varied.moved.levels[stop, p]
    for i in range(place.shape[1]):
        gap += varied.run.sets.normals[stop, i] * place[0, i, p]
    return gap


@kernel
def flight_from(run: StructureRun, row: int) -> ModalFlight:
    """Return the flight by which neighbours move from an event: in a tail the wall holds them."""
    if tail_after(run, row) > 0.0:
        return held_after(run, row)
    return flight_after(run, row)


@kernel
def begin_columns(
    varied: VariedRun, record: ColumnRecord, row: int, b: int, work: CarryWorkspace
) -> None:
    """Write the columns of the modes of a set, and of all clearances, just after an event."""
    run, moved = varied.run, varied.moved
    place = work.place
    for i in range(place.shape[1]):
        for p in range(place.shape[2]):
            place[0, i, p] = record.places[row, 0, i, p] - moved.places[b, i, p]
            place[1, i, p] = record.places[row, 1, i, p]
    if tail_after(run, row) > 0.0:
        begin_tail(varied, record, row, b, work)
    else:
        to_modes(run.sets, b, place, work.columns)
    for k in range(work.gaps.shape[0]):
        for p in range(place.shape[2]):
            work.gaps[k, p] = clear_of(varied, record.places[row], k, p)
    kind = run.marks[row, KIND]
    if kind in (IMPACT, CROSSING):
        for p in range(place.shape[2]):
            work.gaps[run.marks[row, BOUND], p] = record.gaps[row, p]


@kernel
def begin_tail(
    varied: VariedRun, record: ColumnRecord, row: int, b: int, work: CarryWorkspace
) -> None:
    """Write the columns of the modes of a set that holds in the mean from the last impact on.

    The structure is held from an instant on that moves with the impact: the columns are taken to
    it by the rates of the hop, and back by those of the held structure.
    """
    run, place = varied.run, work.place
    stop = run.marks[row, BOUND]
    flight = flight_after(run, row)
    free = run.marks[row, NEXT_REGION]
    pace(run.sets, free, flight, run.begin, run.phases, 0.0, work.paces[0])
    for p in range(place.shape[2]):
        late = record.instants[row, DT, p]
        for i in range(place.shape[1]):
            place[0, i, p] += work.paces[0, 0, i] * late
            place[1, i, p] += work.paces[0, 1, i] * late
            # The wall takes the velocity of its clearance, along M^-1 c of each structure.
            place[1, i, p] -= varied.moved.reactions[b, stop, i, p] * run.events[row, V_AFTER]
    to_modes(run.sets, b, place, work.columns)
    held = held_after(run, row)
    for j in range(run.begin.shape[0]):
        force, _, _, rate, _, _ = inputs(held.basis, j, run.phases, held.pull, 0.0)
        spring = held.basis.modes[j, SPRING]
        drag = held.basis.modes[j, DRAG]
        for p in range(place.shape[2]):
            late = record.instants[row, DT, p]
            work.columns[j, U, p] -= (run.begin[j, W] + rate) * late
            slowed = spring * run.begin[j, U] + drag * run.begin[j, W]
            work.columns[j, W, p] -= (force - slowed) * late


@kernel
def fly(
    varied: VariedRun, record: ColumnRecord, row: int, b: int, s: float, work: CarryWorkspace
) -> None:
    """Take the columns of the modes from an event on by a time s, and write their changes."""
    run = varied.run
    begin_columns(varied, record, row, b, work)
    flight = flight_from(run, row)
    t = run.events[row, EVENT_T]
    t_low = run.events[row, EVENT_T_LOW]
    begin_series(flight, varied.moved, t, t_low, work.series)
    column_changes(flight, varied.moved, b, (t, 0.0, s), work.columns, work.changes, work.series)
    for j in range(work.columns.shape[0]):
        for part in range(2):
            for p in range(work.columns.shape[2]):
                work.columns[j, part, p] += work.changes[j, part, p]
    for k in range(varied.graze_times.shape[0]):
        since = (varied.graze_times[k] - t) - t_low
        if 0.0 < since <= s:
            add_jump(varied, b, k, s - since, work)


@kernel
def add_jump(varied: VariedRun, b: int, k: int, s: float, work: CarryWorkspace) -> None:
    """Add to the columns of the modes, and to their changes, what the jump at a graze has become a time s later."""
    sets = varied.run.sets
    kicks = work.series.columns[0]
    for i in range(work.shift.shape[1]):
        for p in range(work.shift.shape[2]):
            work.shift[0, i, p] = 0.0
            work.shift[1, i, p] = sets.impulses[varied.graze_stops[k], i] * varied.jumps[k, p]
    to_modes(sets, b, work.shift, kicks)
    carry(basis_of(sets, b), s, kicks)
    for j in range(kicks.shape[0]):
        for part in range(2):
            for p in range(kicks.shape[2]):
                work.columns[j, part, p] += kicks[j, part, p]
                work.changes[j, part, p] += kicks[j, part, p]


@kernel
def cross_columns(
    varied: VariedRun, record: ColumnRecord, row: int, s: float, work: CarryWorkspace
) -> None:
    """Write the columns just after an event, a time s after the one before it."""
    run, place = varied.run, work.place
    sets = run.sets
    b = set_of_flight(run, row - 1, False)
    kind = run.marks[row, KIND]
    to_places(sets, b, work.columns, place)
    to_places(sets, b, work.changes, work.shift)
    for i in range(place.shape[1]):
        for p in range(place.shape[2]):
            place[0, i, p] += varied.moved.places[b, i, p]
    if kind == CONTACT:
        come_to_contact(varied, record, row, work)
    elif kind == KNOT:
        pass_knot(varied, record, row, s, work)
    else:
        flight = flight_from(run, row - 1)
        modes = run.scratch[1, : run.begin.shape[0]]
        arrive(flight, s, modes)
        pace(sets, b, flight, modes, run.arrival, s, work.paces[0])
        if kind == RELEASE:
            release(varied, record, row, s, flight, work)
        else:
            meet(varied, record, row, work)
        following = flight_after(run, row)
        c = run.marks[row, NEXT_REGION]
        pace(sets, c, following, following.begin, following.phases, 0.0, work.paces[1])
        if kind != RELEASE or is_forced_off(run, row, s):
            shift_columns(varied, record, row, work)
    for i in range(place.shape[1]):
        for p in range(place.shape[2]):
            record.places[row, 0, i, p] = place[0, i, p]
            record.places[row, 1, i, p] = place[1, i, p]


@kernel
def meet(varied: VariedRun, record: ColumnRecord, row: int, work: CarryWorkspace) -> None:
    """Write how the instant of an impact or of the crossing of an edge moves."""
    run, place = varied.run, work.place
    sets = run.sets
    stop = run.marks[row, BOUND]
    is_out = run.marks[row, KIND] == CROSSING and run.events[row, V_AFTER] > 0.0
    speed = run.events[row, V_BEFORE]
    if is_out:
        # What falls is how deep the stop is pressed in.
        speed = -speed
    for p in range(place.shape[2]):
        fall = work.gaps[stop, p]
        size = abs(varied.moved.levels[stop, p])
        for i in range(place.shape[1]):
            fall += sets.normals[stop, i] * work.shift[0, i, p]
            size += abs(sets.normals[stop, i] * place[0, i, p])
        late = -fall / speed
        if run.marks[row, KIND] == SLOW_LANDING:
            # A speed within its rounding: the square root of a distance.
            late = math.nan
        elif is_at_once(run, row):
            other = record.instants[row - 1, DT, p]
            rounding = ROUNDED * size / abs(speed)
            if abs(late - other) > ALIKE * (abs(late) + abs(other)) + rounding:
                # Which wall is struck first depends on the sign of the change.
                late = math.nan
        record.instants[row, DT, p] = late
        faster = 0.0
        for i in range(place.shape[1]):
            faster += sets.normals[stop, i] * (place[1, i, p] + work.paces[0, 1, i] * late)
        record.instants[row, DV_BEFORE, p] = faster
        record.instants[row, DV_AFTER, p] = faster
        record.gaps[row, p] = -speed * late


@kernel
def is_at_once(run: StructureRun, row: int) -> bool:
    """Return whether an impact comes at the instant of the impact before it."""
    return (
        run.marks[row, KIND] == IMPACT
        and run.marks[row - 1, KIND] == IMPACT
        and run.events[row, EVENT_T] == run.events[row - 1, EVENT_T]
        and run.events[row, EVENT_T_LOW] == run.events[row - 1, EVENT_T_LOW]
    )


@kernel
def shift_columns(varied: VariedRun, record: ColumnRecord, row: int, work: CarryWorkspace) -> None:
    """Carry the columns of the coordinates to the instant of an event, over its jump, and back."""
    run, place, moved = varied.run, work.place, varied.moved
    stop = run.marks[row, BOUND]
    speed = run.events[row, V_BEFORE]
    after = run.events[row, V_AFTER]
    kept = 0.0
    if run.marks[row, KIND] == IMPACT:
        kept = kept_of(run.sets, stop, -speed)
    for p in range(place.shape[2]):
        late = record.instants[row, DT, p]
        for i in range(place.shape[1]):
            place[0, i, p] += work.paces[0, 0, i] * late
            place[1, i, p] += work.paces[0, 1, i] * late
        if run.marks[row, KIND] == IMPACT:
            strike_column(run.sets, stop, kept, place, p)
            region, bound = wall_of(run.sets, stop)
            rows = moved.walls[p, stop]
            lossy = moved_restitution(run.sets.walls[stop], rows, region, bound, -speed)
            for i in range(place.shape[1]):
                place[1, i, p] -= lossy * speed * run.sets.impulses[stop, i]
                place[1, i, p] += (after - speed) * moved.impulses[stop, i, p]
            faster = -kept * record.instants[row, DV_BEFORE, p] - lossy * speed
            record.instants[row, DV_AFTER, p] = faster
            record.gaps[row, p] = -after * late
        for i in range(place.shape[1]):
            place[0, i, p] -= work.paces[1, 0, i] * late
            place[1, i, p] -= work.paces[1, 1, i] * late


@kernel
def pass_knot(
    varied: VariedRun, record: ColumnRecord, row: int, s: float, work: CarryWorkspace
) -> None:
    """Write the columns after a knot, which moves with the pace of its record alone."""
    run, moved, place = varied.run, varied.moved, work.place
    instant = (run.events[row - 1, EVENT_T], run.events[row - 1, EVENT_T_LOW])
    load_at(run.sets, instant, run.phases, run.records)
    greatest = -1.0
    for k in range(run.records.shape[0]):
        before = run.records[k, 0] + run.records[k, 1] * s
        slope = run.records[k, 1]
        instant = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
        load_at(run.sets, instant, run.phases, run.records)
        jump = before - run.records[k, 0]
        turn = abs(slope - run.records[k, 1])
        instant = (run.events[row - 1, EVENT_T], run.events[row - 1, EVENT_T_LOW])
        load_at(run.sets, instant, run.phases, run.records)
        bound = run.sets.records[k, 0, FORCE_BOUND]
        if abs(jump) <= FORCE_ROUNDING * bound:
            jump = 0.0
        weight = abs(jump) if jump != 0.0 else 1e-16 * turn
        for p in range(place.shape[2]):
            late = -run.events[row, EVENT_T] * moved.paces[k, p]
            if weight > greatest:
                record.instants[row, DT, p] = late
            for i in range(place.shape[1]):
                place[1, i, p] += moved.record_pushes[k, i] * jump * late
        greatest = max(greatest, weight)


@kernel
def come_to_contact(
    varied: VariedRun, record: ColumnRecord, row: int, work: CarryWorkspace
) -> None:
    """Write how the begin of a contact moves: with the last impact, or with a chatter's sum."""
    run = varied.run
    stop = run.marks[row, BOUND]
    if tail_after(run, row - 1) > 0.0:
        moved_tail(varied, record, row, work)
        return
    for p in range(work.place.shape[2]):
        record.instants[row, DT, p] = record.instants[row - 1, DT, p]
        if row == 1 and run.marks[0, KIND] == START:
            # At rest on the wall: off it the structure would come back after a square root.
            off = clear_of(varied, record.places[0], stop, p)
            speed = 0.0
            for i in range(work.place.shape[1]):
                speed += run.sets.normals[stop, i] * record.places[0, 1, i, p]
            if off != 0.0 or speed != 0.0:
                record.instants[row, DT, p] = math.nan


@kernel
def moved_tail(varied: VariedRun, record: ColumnRecord, row: int, work: CarryWorkspace) -> None:
    """Write the derivative of the instant at which a chatter ends.

    That of the sum in `march.chatter_time`, from the second and third derivatives of the clearance.
    """
    run, moved, series = varied.run, varied.moved, work.series
    stop = run.marks[row, BOUND]
    b = run.marks[row - 1, NEXT_REGION]
    place = work.shift
    for i in range(place.shape[1]):
        for p in range(place.shape[2]):
            place[0, i, p] = record.places[row - 1, 0, i, p] - moved.places[b, i, p]
            place[1, i, p] = record.places[row - 1, 1, i, p]
    to_modes(run.sets, b, place, series.columns[0])
    flight = flight_after(run, row - 1)
    t = run.events[row - 1, EVENT_T]
    begin_series(flight, moved, t, run.events[row - 1, EVENT_T_LOW], series)
    for j in range(run.begin.shape[0]):
        series.modes[0, j, U] = run.begin[j, U]
        series.modes[0, j, W] = run.begin[j, W]
    fill_phases(flight, 0.0, 1.0, 3, series)
    fill_modes(flight, 0.0, 1.0, 3, series)
    fill_columns(flight, moved, b, (t, 0.0, 1.0), 3, series)
    _, _, second, third, fourth, _ = derivatives(flight, stop, 0.0, True)
    speed = run.events[row - 1, V_AFTER]
    ratio = restitution(run.sets, stop, speed)
    region, bound = wall_of(run.sets, stop)
    push = -second
    tau = 2.0 * speed / (push * (1.0 - ratio))
    bent = third / push - 1.5 * flight.basis.levels[stop, SELF_DRAG]
    guard = flight.basis.guard[stop]
    for p in range(place.shape[2]):
        late = record.instants[row - 1, DT, p]
        moved_second = third * late
        moved_third = fourth * late
        for j in range(run.begin.shape[0]):
            for part in range(2):
                moved_second += 2.0 * guard[j, part] * series.columns[2, j, part, p]
                moved_third += 6.0 * guard[j, part] * series.columns[3, j, part, p]
        lossy = moved_restitution(run.sets.walls[stop], moved.walls[p, stop], region, bound, 0.0)
        weaker = moved_second / push
        longer = record.instants[row - 1, DV_AFTER, p] / speed + weaker + lossy / (1.0 - ratio)
        moved_bent = (moved_third + third * weaker) / push - 1.5 * moved.drags[b, stop, p]
        longer = tau * longer * (1.0 + 2.0 * bent * tau / 3.0) + tau * tau * moved_bent / 3.0
        record.instants[row, DT, p] = late + longer


@kernel
def is_forced_off(run: StructureRun, row: int, s: float) -> bool:
    """Return whether a release, a time s after the event before it, is one by a jump of the forces.

    They jump at a knot, at the edge of a soft stop with a dashpot, and at an impact of another
    wall.
    """
    return s == 0.0 and run.marks[row - 1, KIND] != START


@kernel
def release(
    varied: VariedRun,
    record: ColumnRecord,
    row: int,
    s: float,
    flight: ModalFlight,
    work: CarryWorkspace,
) -> None:
    """Write how the instant moves at which the force of a wall falls to zero."""
    run = varied.run
    stop = run.marks[row, BOUND]
    is_forced = is_forced_off(run, row, s)
    b = set_of_flight(run, row - 1, False)
    fall = derivatives(flight, stop, s, False)[1]
    t = run.events[row - 1, EVENT_T]
    moved_force(flight, varied.moved, b, stop, (t, s), work.columns, work.series, work.forces)
    for p in range(work.forces.shape[0]):
        late = math.nan
        if is_forced:
            late = record.instants[row - 1, DT, p]
        elif fall != 0.0:
            late = -work.forces[p] / fall
        record.instants[row, DT, p] = late


@kernel
def columns_at(
    varied: VariedRun,
    record: ColumnRecord,
    instants: Floats,
    after: bool,
    work: CarryWorkspace,
    motion: Floats,
) -> None:
    """Write the columns of x and v at each instant into ``motion`` (k, 2, n, p)."""
    run = varied.run
    events = run.events
    for k in range(instants.shape[0]):
        row = flight_at(events, instants[k], after)
        s = (instants[k] - events[row, EVENT_T]) - events[row, EVENT_T_LOW]
        if instants[k] == events[row, EVENT_T]:
            s = 0.0
        is_last = row == events.shape[0] - 1
        b = set_of_flight(run, row, is_last)
        fly(varied, record, row, b, s, work)
        to_places(run.sets, b, work.columns, motion[k])
        for i in range(motion.shape[2]):
            for p in range(motion.shape[3]):
                motion[k, 0, i, p] += varied.moved.places[b, i, p]
        if tail_after(run, row) > 0.0:
            add_hop(varied, record, row, s, motion[k])


@kernel
def add_hop(varied: VariedRun, record: ColumnRecord, row: int, s: float, place: Floats) -> None:
    """Add the column of a hop in a chatter's tail to those of the mean motion, along M^-1 c."""
    run = varied.run
    stop = run.marks[row, BOUND]
    speed = run.events[row, V_AFTER]
    ratio = restitution(run.sets, stop, speed)
    whole = tail_after(run, row)
    hop = hop_of_tail(ratio, whole, s)
    region, bound = wall_of(run.sets, stop)
    for p in range(place.shape[2]):
        lossy = moved_restitution(
            run.sets.walls[stop], varied.moved.walls[p, stop], region, bound, 0.0
        )
        late = record.instants[row, DT, p]
        longer = record.instants[row + 1, DT, p] - late
        faster = record.instants[row, DV_AFTER, p]
        off, moved_v = moved_hop(ratio, speed, whole, hop, (faster, lossy, late, longer))
        for i in range(place.shape[1]):
            place[0, i, p] += run.sets.impulses[stop, i] * off
            place[1, i, p] += run.sets.impulses[stop, i] * moved_v


@kernel
def rates_at(run: StructureRun, t: float, after: bool, out: Floats) -> None:
    """Write velocities and accelerations (2, n) at an instant, on one side of an event there."""
    row = flight_at(run.events, t, after)
    flight = flight_from(run, row)
    s = max((t - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW], 0.0)
    modes = run.scratch[1, : run.begin.shape[0]]
    arrive(flight, s, modes)
    b = set_of_flight(run, row, row == run.events.shape[0] - 1)
    pace(run.sets, b, flight, modes, run.arrival, s, out)


@kernel
def taylor_at(
    varied: VariedRun,
    record: ColumnRecord,
    which: tuple[float, bool, int],
    work: CarryWorkspace,
    guard: Floats,
) -> int:
    """Write the power series of modes and columns, three orders, at an instant into ``work``.

    ``which`` are the instant, whether it is after an event there, and a stop. The force of a wall
    that holds, with its rate, goes into ``guard`` (2,), and its column into the forces of ``work``.
    Returns the set.
    """
    run, series = varied.run, work.series
    t, after, stop = which
    row = flight_at(run.events, t, after)
    b = set_of_flight(run, row, row == run.events.shape[0] - 1)
    start = run.events[row, EVENT_T]
    s = max((t - start) - run.events[row, EVENT_T_LOW], 0.0)
    fly(varied, record, row, b, s, work)
    flight = flight_from(run, row)
    if stop < run.order.shape[0]:
        times = (start, s)
        moved_force(flight, varied.moved, b, stop, times, work.columns, series, work.forces)
        run.values[stop] = value_of(flight, stop)
        modes = run.scratch[1, : run.begin.shape[0]]
        arrive(flight, s, modes)
        guard[0], guard[1], _, _, _, _ = derivatives(flight, stop, s, False)
    for j in range(run.begin.shape[0]):
        for part in range(2):
            series.modes[0, j, part] = series.present[j, part]
            for p in range(work.columns.shape[2]):
                series.columns[0, j, part, p] = work.columns[j, part, p]
    fill_phases(flight, s, 1.0, 3, series)
    fill_modes(flight, s, 1.0, 3, series)
    fill_columns(flight, varied.moved, b, (start, s, 1.0), 3, series)
    return b
