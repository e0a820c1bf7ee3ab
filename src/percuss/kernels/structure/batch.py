"""Many motions of one structure in one call, and what is kept of each in place of its events.

The members of a batch go one after another from event to event as `march` does, through a small
record whose rows are observed and dropped. A member waits, NEW_SET, where it first meets a set of
acting stops; once the set is made, it goes on. The result of a member does not depend on the
others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import logarithm
from percuss.kernels.compile import kernel
from percuss.kernels.loads import SAME_INSTANT
from percuss.kernels.observables import (
    CONTACTS,
    EVERY,
    IMPACT_POINTS,
    IMPACTS,
    N_OBSERVABLES,
    PEAK_SPEED,
    POINTS,
    SHRUNK,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    clear_observables,
    note_peak,
)
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    FULL,
    HUGE,
    IMPACT,
    KIND,
    MOVING,
    N_EVENTS,
    N_GRAZES,
    NEXT_REGION,
    OVERFLOW,
    REACHED_END,
    SLOW_LANDING,
    SPENT,
    START,
    T_LOW,
    V_AFTER,
    V_BEFORE,
    T,
)
from percuss.kernels.structure.basis import find
from percuss.kernels.structure.flight import arrive
from percuss.kernels.structure.march import march
from percuss.kernels.structure.perturbations import (
    FORGOTTEN,
    TangentSpace,
    carry_in_set,
    copy_tangents,
    is_held,
    orthonormalise,
    renew,
    volume_rate,
)
from percuss.kernels.structure.run import NEW_SET, SET, StructureRun, decompose, displace
from percuss.kernels.structure.sample import flight_after
from percuss.kernels.structure.tangent import (
    cross,
    kept_of_volume,
    set_of_flight,
    settle,
    to_places,
)
from percuss.kernels.structure.views import Views, observe_views

# The status of a member that has not begun.
NEW = -1
# Columns of a point of an impact.
IMPACT_COLUMNS = 3


class StructureMembers(NamedTuple):
    """Many motions, a row for each.

    ``starts`` (k, 2 n + 1) are x, v and t; ``keys`` (k,) the bits of the stops that act there;
    ``state``, ``counters``, ``begin``, ``order`` and ``free`` are those of a `StructureRun`, and so
    are ``clearances``, its values.
    ``values`` and ``points`` are as `percuss.kernels.observables` has them, points with x and v of
    a strobe, or t, v after and the stop of an impact, or the logarithms of the growth of
    perturbations and of their volume. ``ends`` (k, 2 n) are x and v at the end. ``tangents``
    (k, 2, n, c) are c orthonormal perturbations after the last event, ``logs`` (k, c) what they
    have grown by.
    """

    starts: Floats
    keys: Integers
    plans: Floats
    status: Integers
    state: Floats
    counters: Integers
    begin: Floats
    order: Floats
    free: Floats
    clearances: Floats
    values: Floats
    points: Floats
    ends: Floats
    tangents: Floats
    logs: Floats


class StructureOptions(NamedTuple):
    """Options of all members, as `percuss.kernels.batch.Options` has them.

    ``of_stop`` is the stop whose impacts are points, -1 for all; ``with_views`` asks for what is
    seen beside the clearances.
    """

    max_impacts: int
    section: int
    of_stop: int
    with_views: bool
    patience: int


@kernel
def follow_members(
    members: StructureMembers,
    run: StructureRun,
    viewer: StructureRun,
    views: Views,
    space: TangentSpace,
    options: StructureOptions,
    stop: Integers,
) -> None:
    """Follow each member to its limits, or until it waits for a set or for more rows, or its patience ends.

    ``run`` is used by the members in turn; ``viewer`` has the same record, and arrays of its own
    for what is seen. The call returns once another thread sets ``stop``.
    """
    for i in range(members.status.shape[0]):
        if stop[0] != 0:
            return
        status = members.status[i]
        if status in (NEW, NEW_SET, SPENT, FULL):
            load(members, i, run)
            status = follow_member(members, i, run, viewer, views, space, options, stop)
            members.status[i] = status
            store(members, i, run)


@kernel
def load(members: StructureMembers, i: int, run: StructureRun) -> None:
    """Write a member into the run: where it was, or where it starts."""
    for k in range(run.state.shape[0]):
        run.state[k] = members.state[i, k]
    for k in range(run.counters.shape[0]):
        run.counters[k] = members.counters[i, k]
    for k in range(run.order.shape[0]):
        run.order[k] = members.order[i, k]
        run.free[k] = members.free[i, k]
        run.values[k] = members.clearances[i, k]
    for j in range(run.begin.shape[0]):
        run.begin[j, 0] = members.begin[i, j, 0]
        run.begin[j, 1] = members.begin[i, j, 1]
    if members.status[i] == NEW:
        n = run.sets.offset.shape[1]
        place = run.scratch[6, :n]
        for j in range(n):
            place[j, 0] = members.starts[i, j]
            place[j, 1] = members.starts[i, n + j]
        b = find(run.sets, members.keys[i])
        decompose(run.sets, b, place, run.begin)
        run.counters[SET] = b
        run.state[T] = members.starts[i, 2 * n]
        clear_observables(members.values[i])
    elif run.counters[N_EVENTS] > 0:
        # The last event is the first row again.
        begin_record(run, START)


@kernel
def begin_record(run: StructureRun, kind: np.int64) -> None:
    """Write the state as the first row of the record, and drop all others."""
    run.events[0, EVENT_T] = run.state[T]
    run.events[0, EVENT_T_LOW] = run.state[T_LOW]
    run.marks[0, KIND] = kind
    run.marks[0, BOUND] = -1
    run.marks[0, NEXT_REGION] = run.counters[SET]
    for j in range(run.begin.shape[0]):
        run.states[0, j, 0] = run.begin[j, 0]
        run.states[0, j, 1] = run.begin[j, 1]
    run.counters[N_EVENTS] = 1
    run.counters[N_GRAZES] = 0


@kernel
def keep_last(run: StructureRun, last: int) -> None:
    """Drop all rows of a full record but the last, with what it was."""
    stop, before, after = (
        run.marks[last, BOUND],
        run.events[last, V_BEFORE],
        run.events[last, V_AFTER],
    )
    begin_record(run, run.marks[last, KIND])
    run.marks[0, BOUND] = stop
    run.events[0, V_BEFORE] = before
    run.events[0, V_AFTER] = after


@kernel
def store(members: StructureMembers, i: int, run: StructureRun) -> None:
    """Keep where a member is."""
    for k in range(run.state.shape[0]):
        members.state[i, k] = run.state[k]
    for k in range(run.counters.shape[0]):
        members.counters[i, k] = run.counters[k]
    for k in range(run.order.shape[0]):
        members.order[i, k] = run.order[k]
        members.free[i, k] = run.free[k]
        members.clearances[i, k] = run.values[k]
    for j in range(run.begin.shape[0]):
        members.begin[i, j, 0] = run.begin[j, 0]
        members.begin[i, j, 1] = run.begin[j, 1]


@kernel
def follow_member(
    members: StructureMembers,
    i: int,
    run: StructureRun,
    viewer: StructureRun,
    views: Views,
    space: TangentSpace,
    options: StructureOptions,
    stop: Integers,
) -> int:
    """Go on as `march` does, and observe each record; return why the motion came to an end.

    FULL: the record is too small for all events of one instant.
    """
    until = members.plans[i, UNTIL]
    patience = options.patience
    status = MOVING
    while status == MOVING and stop[0] == 0:
        status = march(run, until, options.max_impacts, patience)
        last = run.counters[N_EVENTS] - 1
        for row in range(last):
            t = run.events[row + 1, EVENT_T]
            end = (t, run.events[row + 1, EVENT_T_LOW], t)
            observe_stretch(members, i, viewer, views, space, options, row, end)
            if options.section == TANGENTS:
                carry_tangents(members, i, viewer, space, row)
            observe_event(members, i, viewer, options, row + 1)
        is_empty = last <= 0 and run.counters[N_GRAZES] < run.grazes.shape[0]
        if status == FULL and not is_empty:
            keep_last(run, last)
            status = MOVING
        elif status == REACHED_END:
            end = (until, 0.0, math.inf)
            observe_stretch(members, i, viewer, views, space, options, last, end)
            end_at(members, i, viewer, last, until)
            for k in range(members.ends.shape[1]):
                if not abs(members.ends[i, k]) < HUGE:
                    status = OVERFLOW
    return SPENT if status == MOVING else status


@kernel
def end_at(members: StructureMembers, i: int, viewer: StructureRun, row: int, until: float) -> None:
    """Write where a motion ends."""
    n = viewer.sets.offset.shape[1]
    place = viewer.scratch[6, :n]
    place_at(viewer, row, until, place)
    for j in range(n):
        members.ends[i, j] = place[j, 0]
        members.ends[i, n + j] = place[j, 1]


@kernel
def place_at(viewer: StructureRun, row: int, instant: float, place: Floats) -> None:
    """Write displacements and velocities, (n, 2), at an instant of the flight of a row."""
    flight = flight_after(viewer, row)
    s = (instant - viewer.events[row, EVENT_T]) - viewer.events[row, EVENT_T_LOW]
    modes = viewer.scratch[0, : viewer.begin.shape[0]]
    arrive(flight, s, modes)
    displace(viewer.sets, viewer.marks[row, NEXT_REGION], modes, place)


@kernel
def observe_event(
    members: StructureMembers, i: int, viewer: StructureRun, options: StructureOptions, row: int
) -> None:
    """Count the event of a row."""
    values = members.values[i]
    events, marks = viewer.events, viewer.marks
    is_early = events[row, EVENT_T] < members.plans[i, SINCE]
    kind = marks[row, KIND]
    if kind == CONTACT and not is_early:
        values[CONTACTS] += 1.0
    is_entry = kind == CROSSING and events[row, V_AFTER] < 0.0
    if kind != IMPACT and not is_entry:
        return
    if values.shape[0] > N_OBSERVABLES:
        note_peak(events[row, EVENT_T], abs(events[row, V_BEFORE]), values)
    if is_early:
        return
    values[IMPACTS] += 1.0
    values[PEAK_SPEED] = max(values[PEAK_SPEED], abs(events[row, V_BEFORE]))
    if options.section == IMPACT_POINTS and options.of_stop in (-1, marks[row, BOUND]):
        point = members.points[i, next_point(members, i)]
        point[0] = events[row, EVENT_T]
        point[1] = events[row, V_AFTER] if kind == IMPACT else events[row, V_BEFORE]
        point[2] = marks[row, BOUND]


@kernel
def next_point(members: StructureMembers, i: int) -> int:
    """Return the row of the next point, which is the oldest one."""
    count = int(members.values[i, POINTS])
    members.values[i, POINTS] = count + 1.0
    return count % members.points.shape[1]


@kernel
def observe_stretch(
    members: StructureMembers,
    i: int,
    viewer: StructureRun,
    views: Views,
    space: TangentSpace,
    options: StructureOptions,
    row: int,
    end: tuple[float, float, float],
) -> None:
    """Record strobes and what is seen on the flight of a row.

    ``end`` is its instant (t, t_low) and the time before which its strobes lie: a strobe at the
    very instant of an event belongs to what follows, one at the end of the motion to the last
    flight.
    """
    plan = members.plans[i]
    values = members.values[i]
    t, t_low, before = end
    if options.with_views:
        start = (viewer.events[row, EVENT_T], viewer.events[row, EVENT_T_LOW])
        right = (t - start[0]) + (t_low - start[1])
        # An event within rounding of the window's begin is at it, and has both limits.
        is_seen = t >= plan[SINCE] - SAME_INSTANT * abs(plan[SINCE])
        if before > t and start[0] > plan[SINCE]:
            # Nor is the window's end behind an event that rounding alone keeps before it.
            is_seen = is_seen and right > SAME_INSTANT * abs(t)
        # Between two events of one instant there is no motion.
        if is_seen and (right > 0.0 or before > t):
            left = min(max(0.0, plan[SINCE] - start[0]), right)
            observe_views(viewer, views, row, (left, right), values)
    if t < plan[SINCE]:
        return
    if options.section == TANGENTS:
        strobe_tangents(members, i, viewer, space, row, before)
    if options.section == STROBES:
        instant = plan[SINCE] + values[POINTS] * plan[EVERY]
        n = viewer.sets.offset.shape[1]
        place = viewer.scratch[6, :n]
        while instant < before and instant <= plan[UNTIL]:
            place_at(viewer, row, instant, place)
            point = members.points[i, next_point(members, i)]
            for j in range(n):
                point[j] = place[j, 0]
                point[n + j] = place[j, 1]
            instant = plan[SINCE] + values[POINTS] * plan[EVERY]


@kernel
def strobe_tangents(
    members: StructureMembers,
    i: int,
    viewer: StructureRun,
    space: TangentSpace,
    row: int,
    before: float,
) -> None:
    """Write the logarithms at the strobes that fall on the flight of a row."""
    plan = members.plans[i]
    values = members.values[i]
    instant = plan[SINCE] + values[POINTS] * plan[EVERY]
    while instant < before and instant <= plan[UNTIL]:
        b = set_of_flight(viewer, row, before == math.inf)
        s = (instant - viewer.events[row, EVENT_T]) - viewer.events[row, EVENT_T_LOW]
        copy_tangents(members.tangents[i], members.logs[i], space)
        if b != viewer.marks[row, NEXT_REGION]:
            settle(viewer, row, space.place, space.paces[0, 0])
        carry_in_set(viewer.sets, b, max(s, 0.0), space)
        to_places(viewer.sets, b, space.columns, space.place)
        orthonormalise(space.place, space.logs, 0.0)
        point = members.points[i, next_point(members, i)]
        count = space.logs.shape[0]
        for c in range(count):
            point[c] = space.logs[c]
        point[count] = values[SHRUNK] - volume_rate(viewer.sets, b) * s
        instant = plan[SINCE] + values[POINTS] * plan[EVERY]


@kernel
def carry_tangents(
    members: StructureMembers, i: int, viewer: StructureRun, space: TangentSpace, row: int
) -> None:
    """Carry the perturbations along the flight of a row and over the event at its end."""
    sets = viewer.sets
    events, marks = viewer.events, viewer.marks
    s = events[row + 1, EVENT_T] - events[row, EVENT_T]
    s += events[row + 1, EVENT_T_LOW] - events[row, EVENT_T_LOW]
    b = set_of_flight(viewer, row, False)
    copy_tangents(members.tangents[i], members.logs[i], space)
    if b != marks[row, NEXT_REGION]:
        settle(viewer, row, space.place, space.paces[0, 0])
    carry_in_set(sets, b, s, space)
    cross(viewer, row, s, space.place, space.columns, space.paces)
    kind = marks[row + 1, KIND]
    kept = 1.0
    if kind == IMPACT:
        kept = kept_of_volume(sets, marks[row + 1, BOUND], -events[row + 1, V_BEFORE])
    if kind in (CONTACT, SLOW_LANDING):
        kept = 0.0
    # What a contact leaves of a perturbation may be rounding alone.
    orthonormalise(space.place, space.logs, FORGOTTEN if kept == 0.0 else 0.0)
    if events[row + 1, EVENT_T] < members.plans[i, SINCE]:
        # Before the time that is measured others are taken for those that a wall has taken.
        kept = 1.0 if kept == 0.0 else kept
        if not is_held(sets, marks[row + 1, NEXT_REGION]):
            renew(space.place, space.logs)
    values = members.values[i]
    lost = logarithm(kept) if kept > 0.0 else -math.inf
    values[SHRUNK] += 2.0 * lost
    values[SHRUNK] -= volume_rate(sets, b) * s
    for c in range(space.logs.shape[0]):
        members.logs[i, c] = space.logs[c]
        for j in range(space.place.shape[1]):
            members.tangents[i, 0, j, c] = space.place[0, j, c]
            members.tangents[i, 1, j, c] = space.place[1, j, c]
