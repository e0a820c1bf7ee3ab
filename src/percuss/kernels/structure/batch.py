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
from percuss.kernels.arithmetic import Pair, hypotenuse, logarithm
from percuss.kernels.compile import kernel
from percuss.kernels.event_location import within_bracket
from percuss.kernels.loads import SAME_INSTANT
from percuss.kernels.observables import (
    CONTACTS,
    EVERY,
    HIGHEST,
    IMPACT_POINTS,
    IMPACTS,
    IN_TOUCH,
    LOWEST,
    N_OBSERVABLES,
    PEAK_FORCE,
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
from percuss.kernels.structure.basis import (
    DRAG,
    IS_ON,
    IS_WALL,
    QUICKEST,
    STEP_LENGTH,
    Basis,
    Sets,
    basis_of,
    basis_with,
    find,
)
from percuss.kernels.structure.flight import (
    SECOND,
    SPEED,
    VALUE,
    ModalFlight,
    arrive,
    arrive_in_rows,
    derivatives,
    move,
    see,
)
from percuss.kernels.structure.march import march
from percuss.kernels.structure.run import (
    NEW_SET,
    SET,
    StructureRun,
    decompose,
    displace,
    flight_with,
    value_of,
)
from percuss.kernels.structure.sample import flight_after
from percuss.kernels.structure.tangent import (
    carry,
    carry_far,
    cross,
    kept_of_volume,
    set_of_flight,
    settle,
    to_modes,
    to_places,
)

# The status of a member that has not begun.
NEW = -1
# Phase of the quickest rate between two nodes at which what is seen is compared, in shortest steps;
# the nodes of a motion without any rate, a cubic; and steps to a turning point.
STEPS_OF_A_NODE = 2.0
NODES_OF_A_CUBIC = 16
TURNING_STEPS = 60
# Phase of the quickest rate over which perturbations are carried by the propagator itself, and the
# part of one that counts as rounding where a wall takes what is behind it.
LONGEST_PHASE = 4.0
FORGOTTEN = 1e-12
# Columns of a point of an impact.
IMPACT_COLUMNS = 3


class Views(NamedTuple):
    """What is seen of a motion beside the clearances: y = c . x first, then the stops' forces.

    Each is linear in modes and loads, and the arrays are those of `Sets` for guards.
    """

    guard: Floats
    levels: Floats
    feed: Floats
    record_feed: Floats


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


class TangentSpace(NamedTuple):
    """Arrays in which perturbations are carried: (2, n, c), (n, 2, c), (2, 2, n) and (c,)."""

    place: Floats
    columns: Floats
    paces: Floats
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
def observe_views(
    viewer: StructureRun, views: Views, row: int, span: tuple[float, float], values: Floats
) -> None:
    """Record the extremes of what is seen, and the time in touch, on a part of the flight of a row.

    Turning points are those between neighbouring nodes at which the slope has different signs, or
    between which it turns on the other side of zero.
    """
    b = viewer.marks[row, NEXT_REGION]
    left, right = span
    if viewer.sets.keys[b] != 0:
        values[IN_TOUCH] += max(0.0, right - left)
    flight_after(viewer, row)
    flight = seen_flight(viewer, views, b)
    n_views = views.levels.shape[1]
    seen = viewer.scratch[2, :n_views]
    seen1 = viewer.scratch[3, :n_views]
    modes = viewer.rows[0:2]
    rates = viewer.rows[4:9]
    for k in range(n_views):
        flight.values[k] = value_of(flight, k)
    arrive_in_rows(flight, left, modes)
    see(flight, modes, flight.arrival, left, rates, seen)
    note_views(flight.basis, seen, values)
    count = NODES_OF_A_CUBIC
    if flight.basis.of_set[QUICKEST] > 0.0:
        width = STEPS_OF_A_NODE * flight.basis.of_set[STEP_LENGTH]
        count = max(1, math.ceil((right - left) / width))
    step = (right - left) / count
    for node in range(count):
        s = left + node * step
        arrive_in_rows(flight, s + step, modes)
        see(flight, modes, flight.arrival, s + step, rates, seen1)
        note_views(flight.basis, seen1, values)
        for k in range(n_views):
            if flight.basis.levels[k, IS_ON] == 1.0:
                turns = seen[k, SPEED], seen[k, SECOND], seen1[k, SPEED], seen1[k, SECOND]
                note_turns(flight, k, (s, s + step), turns, values)
            seen[k, SPEED] = seen1[k, SPEED]
            seen[k, SECOND] = seen1[k, SECOND]


@kernel
def seen_flight(viewer: StructureRun, views: Views, b: int) -> ModalFlight:
    """Return the flight of the viewer whose guards are the views."""
    basis = basis_with(
        viewer.sets, b, views.guard[b], views.levels[b], views.feed[b], views.record_feed[b]
    )
    return flight_with(viewer, basis, viewer.values, viewer.order)


@kernel
def note_views(basis: Basis, seen: Floats, values: Floats) -> None:
    """Note what is seen at an instant."""
    for k in range(seen.shape[0]):
        if basis.levels[k, IS_ON] == 1.0:
            note_view(k, seen[k, VALUE], values)


@kernel
def note_view(k: int, value: float, values: Floats) -> None:
    """Note a value of the displacement, or of a stop's force."""
    if k == 0:
        values[LOWEST] = min(values[LOWEST], value)
        values[HIGHEST] = max(values[HIGHEST], value)
    else:
        values[PEAK_FORCE] = max(values[PEAK_FORCE], abs(value))


@kernel
def note_turns(
    flight: ModalFlight,
    k: int,
    span: Pair,
    slopes: tuple[float, float, float, float],
    values: Floats,
) -> None:
    """Note a view where it turns between two nodes; ``slopes`` are first and second derivatives."""
    left, right = span
    slope, bend, slope1, bend1 = slopes
    if slope == 0.0:
        slope = bend
    if slope * slope1 < 0.0:
        note_view(k, turning_value(flight, k, left, right, slope), values)
    elif slope * bend < 0.0 and slope1 * bend1 > 0.0:
        # It has slowed down and sped up: in between it may have gone the other way.
        s, least = slowest_at(flight, k, left, right, bend)
        if slope * least < 0.0:
            note_view(k, turning_value(flight, k, left, s, slope), values)
            note_view(k, turning_value(flight, k, s, right, least), values)


@kernel
def slowest_at(
    flight: ModalFlight, k: int, left: float, right: float, bend: float
) -> tuple[float, float]:
    """Return where the slope of a view turns, and the slope there.

    The second derivative has the sign of ``bend`` at the left, and another one at the right.
    """
    s = 0.5 * (left + right)
    slope = 0.0
    for _ in range(TURNING_STEPS):
        move(flight, s)
        _, slope, second, third, _, _ = derivatives(flight, k, s, False)
        if second * bend > 0.0:
            left = s
        else:
            right = s
        step = -second / third if third != 0.0 else 0.0
        if abs(second * step) <= 1e-16 * abs(slope) or not left < right:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    return s, slope


@kernel
def turning_value(flight: ModalFlight, k: int, left: float, right: float, slope: float) -> float:
    """Return a view where its slope vanishes, between two times at which its signs differ."""
    s = 0.5 * (left + right)
    value = 0.0
    for _ in range(TURNING_STEPS):
        move(flight, s)
        value, first, second, _, _, _ = derivatives(flight, k, s, False)
        if first * slope > 0.0:
            left = s
        else:
            right = s
        step = -first / second if second != 0.0 else 0.0
        if abs(first * step) <= 1e-16 * abs(value) or not left < right:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    return value


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


@kernel
def is_held(sets: Sets, b: int) -> bool:
    """Return whether a wall holds the structure in a set."""
    for i in range(sets.stops.shape[0]):
        if sets.stops[i, IS_WALL] == 1.0 and sets.keys[b] & (1 << i):
            return True
    return False


@kernel
def renew(place: Floats, logs: Floats) -> None:
    """Put unit vectors orthogonal to all others, (2, n, c), in place of those that were lost."""
    for c in range(logs.shape[0]):
        if logs[c] > -math.inf:
            continue
        part = 0
        which = 0
        most = -1.0
        for i in range(2):
            for j in range(place.shape[1]):
                left = 1.0
                for other in range(logs.shape[0]):
                    left -= place[i, j, other] * place[i, j, other]
                if left > most:
                    part = i
                    which = j
                    most = left
        place[part, which, c] = 1.0
        for _ in range(2):
            for other in range(logs.shape[0]):
                if other == c:
                    continue
                along = 0.0
                for j in range(place.shape[1]):
                    along += place[0, j, c] * place[0, j, other]
                    along += place[1, j, c] * place[1, j, other]
                for j in range(place.shape[1]):
                    place[0, j, c] -= along * place[0, j, other]
                    place[1, j, c] -= along * place[1, j, other]
        size = 0.0
        for j in range(place.shape[1]):
            size = hypotenuse(size, hypotenuse(place[0, j, c], place[1, j, c]))
        for j in range(place.shape[1]):
            place[0, j, c] /= size
            place[1, j, c] /= size
        logs[c] = 0.0


@kernel
def copy_tangents(tangents: Floats, logs: Floats, space: TangentSpace) -> None:
    """Write perturbations and their logarithms into the space."""
    for c in range(logs.shape[0]):
        space.logs[c] = logs[c]
        for j in range(tangents.shape[1]):
            space.place[0, j, c] = tangents[0, j, c]
            space.place[1, j, c] = tangents[1, j, c]


@kernel
def carry_in_set(sets: Sets, b: int, s: float, space: TangentSpace) -> None:
    """Carry perturbations in a set over a time, (2, n, c) at first, then the modes' (n, 2, c)."""
    basis = basis_of(sets, b)
    to_modes(sets, b, space.place, space.columns)
    if s * sets.of_set[b, QUICKEST] <= LONGEST_PHASE:
        carry(basis, s, space.columns)
    else:
        carry_far(basis, s, space.columns, space.logs)


@kernel
def volume_rate(sets: Sets, b: int) -> float:
    """Return the rate at which volumes between neighbours shrink in a set, the trace of M^-1 C."""
    rate = 0.0
    for j in range(sets.modes.shape[1]):
        rate += sets.modes[b, j, DRAG]
    return rate


@kernel
def orthonormalise(place: Floats, logs: Floats, forgotten: float) -> None:
    """Make columns (2, n, c) orthonormal, and add the logarithms of what was left of each.

    A column of which no more than a part ``forgotten`` is left has grown by -inf, and stays zero.
    """
    n = place.shape[1]
    for c in range(place.shape[2]):
        before = 0.0
        for j in range(n):
            before = hypotenuse(before, hypotenuse(place[0, j, c], place[1, j, c]))
        # Twice: once leaves too much of the others where little is left.
        for _ in range(2):
            for other in range(c):
                along = 0.0
                for j in range(n):
                    along += place[0, j, c] * place[0, j, other]
                    along += place[1, j, c] * place[1, j, other]
                for j in range(n):
                    place[0, j, c] -= along * place[0, j, other]
                    place[1, j, c] -= along * place[1, j, other]
        size = 0.0
        for j in range(n):
            size = hypotenuse(size, hypotenuse(place[0, j, c], place[1, j, c]))
        is_left = size > forgotten * before and size > 0.0
        growth = -math.inf
        factor = 0.0
        if is_left:
            growth = logarithm(size)
            factor = 1.0 / size
        logs[c] += growth
        for j in range(n):
            place[0, j, c] *= factor
            place[1, j, c] *= factor
