"""Many short runs in one call, with the samples of each and their derivatives.

A *segment* is a run from a node, an instant with a state of its own, up to the next one. Each is
followed as `march` does, its columns are carried over its events, and both are evaluated where
there are samples and at its end. Nothing of a segment but these numbers is kept.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import constant_force, force_and_slopes, move, set_phases
from percuss.kernels.flight_columns import (
    LONGEST_PHASE,
    Change,
    ColumnWorkspace,
    fastest_rate,
    is_plain,
    moved_constant_force,
    moved_drive,
    series_phase,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    LOWER,
    LOWER_ENTRY,
    LOWER_KIND,
    MASS,
    N_REGIONS,
    NUMBER,
    OMEGA,
    STOP_AT,
    STOP_BOUND,
    STOP_DRAG,
    STOP_FIRST,
    STOP_LAST,
    STOP_STIFFNESS,
    UPPER,
    UPPER_ENTRY,
    UPPER_KIND,
    WALL,
    Law,
)
from percuss.kernels.march import march
from percuss.kernels.record import (
    AT_REST,
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    FULL,
    HUGE,
    IMPACT,
    KIND,
    KNOT,
    N_EVENTS,
    N_GRAZES,
    NEXT_REGION,
    OVERFLOW,
    REACHED_END,
    SLOW_LANDING,
    SPENT,
    MotionRecord,
    Run,
    T,
    V,
    X,
    flight_after,
    place_of_event,
)
from percuss.kernels.sample import evaluate, flight_at
from percuss.kernels.sensitivity import (
    BASE,
    BEGIN_X,
    DT,
    SPEED,
    VariedRecord,
    carry,
    columns_at,
    fly,
    moved_place,
)

# Quantities of samples; from OF_STOP on, the force of stop number quantity - OF_STOP.
DISPLACEMENT, VELOCITY, ACCELERATION, OF_STOP = range(4)
# Searches for events after which control returns to the caller.
PATIENCE = 500
# So many steps of the columns' series count as a search; more than some are too many for one
# segment: a second.
STEPS_A_SEARCH, MOST_STEPS = 64.0, 4e6
# Below so many they are not counted: a millisecond.
FEW_STEPS = 2e3
NO_LIMIT = 2**62
# How far segments were followed: the present one, whether its run has begun, how many hits and how
# many searches there were so far.
SEGMENT, IS_BEGUN, N_HITS, N_SEARCHES = range(4)
PROGRESS_ENTRIES = 4
# Columns of the change of a stop.
CHANGE_OF_AT, CHANGE_OF_STIFFNESS, CHANGE_OF_DAMPING = range(3)


class Segments(NamedTuple):
    """Where segments begin and end, and the samples of each.

    ``spans`` (n, 2) are the instants, ``nodes`` (n, 2) x and v at the first, which a node behind a
    wall is moved onto. ``begins`` (n, n_columns, 3) are the columns of x, v and t there.
    Sample i, of those from ``first[k]`` to ``first[k + 1]`` in segment k, is of a quantity at an
    instant; ``after`` says which limit it takes at an event.
    """

    spans: Floats
    nodes: Floats
    begins: Floats
    first: Integers
    instants: Floats
    quantities: Integers
    reach: float
    stops: Floats
    moved_stops: Floats


class SegmentSpace(NamedTuple):
    """Scratch: a run, columns of its events, and of one instant."""

    run: Run
    columns: Floats
    work: ColumnWorkspace
    begin: Floats
    instant: Floats
    motion: Floats
    moved: Floats
    graze_times: Floats
    jumps: Floats


class SegmentResults(NamedTuple):
    """What comes of each segment.

    ``values`` (n_samples, 2) and ``rows`` (n_samples, 2, n_columns) are the samples and their
    derivatives, and what they would be on the other side of an event that is ``away`` (n_samples,)
    from them, infinite where there is none; ``ends`` (n, 2) and ``end_rows`` (n, 2, n_columns)
    those of x and v at the end. ``hits`` (capacity, 2 + n_columns) are the impacts and entries into
    stops: segment, instant and its derivatives; ``counts`` (n,) the events of each segment,
    negative where it was not followed.
    """

    values: Floats
    rows: Floats
    away: Floats
    ends: Floats
    end_rows: Floats
    hits: Floats
    counts: Integers


@kernel
def follow_segments(
    law: Law,
    change: Change,
    segments: Segments,
    space: SegmentSpace,
    results: SegmentResults,
    progress: Integers,
) -> bool:
    """Follow segments from where they were left; return whether all are done.

    ``progress`` (PROGRESS_ENTRIES,) is zeros at first. Control returns after some `PATIENCE`
    searches, in the midst of a segment too: a motion without end must not keep its caller.
    """
    before = progress[N_SEARCHES]
    while progress[SEGMENT] < segments.spans.shape[0]:
        if progress[N_SEARCHES] - before >= PATIENCE:
            return False
        k = progress[SEGMENT]
        if progress[IS_BEGUN] == 0:
            begin_segment(law, change, segments, k, space)
            progress[IS_BEGUN] = 1
        status = march_on(space.run, segments.spans[k, 1], progress)
        if status == SPENT:
            continue
        note_segment(law, change, segments, status, space, results, progress)
        progress[SEGMENT] += 1
        progress[IS_BEGUN] = 0
    return True


@kernel
def note_segment(
    law: Law,
    change: Change,
    segments: Segments,
    status: int,
    space: SegmentSpace,
    results: SegmentResults,
    progress: Integers,
) -> None:
    """Write samples, end and hits of a segment whose run has come to an end."""
    run, k = space.run, progress[SEGMENT]
    n = run.counters[N_EVENTS]
    events, marks = run.events[:n], run.marks[:n]
    record = MotionRecord(law, segments.nodes[k, 0], events, marks)
    steps = steps_of_columns(record, segments, k, space.work)
    if status not in (REACHED_END, AT_REST) or not steps < MOST_STEPS:
        results.counts[k] = -1
        progress[N_SEARCHES] += PATIENCE
        return
    results.counts[k] = n - 1
    progress[N_SEARCHES] += int(steps / STEPS_A_SEARCH)
    varied = VariedRecord(record, change, space.graze_times, space.jumps)
    columns = space.columns[:n]
    carry(varied, space.begin, space.work, columns)
    tidy(columns)
    for i in range(segments.first[k], segments.first[k + 1]):
        observe_sample(varied, columns, segments, i, space, results)
    evaluate_at(varied, columns, segments.spans[k, 1], space)
    for j in range(2):
        results.ends[k, j] = space.motion[j, 0]
        for p in range(columns.shape[1]):
            results.end_rows[k, j, p] = space.moved[j, 0, p]
    for row in range(1, n):
        is_hit = marks[row, KIND] == IMPACT or marks[row, KIND] == SLOW_LANDING
        if marks[row, KIND] == CROSSING:
            is_hit = enters(law, marks, row)
        if is_hit and progress[N_HITS] < results.hits.shape[0]:
            hit = results.hits[progress[N_HITS]]
            hit[0] = k
            hit[1] = events[row, EVENT_T]
            for p in range(columns.shape[1]):
                hit[2 + p] = columns[row, p, DT]
            progress[N_HITS] += 1


@kernel
def steps_of_columns(
    record: MotionRecord, segments: Segments, k: int, work: ColumnWorkspace
) -> float:
    """Return how many steps the series of a segment's columns take, to all events and samples.

    While a fast part decays they are those of that.
    """
    law, events = record.law, record.events
    quickest = 0.0
    for j in range(work.phases.shape[0]):
        quickest = max(quickest, law[FIRST_HARMONIC + j, OMEGA])
    i, last = segments.first[k], segments.first[k + 1]
    fastest = quickest
    first = FIRST_HARMONIC + work.phases.shape[0]
    for region in range(int(law[0, N_REGIONS])):
        row_of_region = first + region * (1 + work.phases.shape[0])
        fastest = max(fastest, fastest_rate(law, row_of_region))
    # To all events, and twice to each sample, from no farther than the span.
    span = segments.spans[k, 1] - segments.spans[k, 0]
    if fastest * span * (1.0 + 2.0 * (last - i)) < LONGEST_PHASE * FEW_STEPS:
        return 0.0
    turned = 0.0
    for row in range(events.shape[0]):
        is_last = row + 1 == events.shape[0]
        end = segments.spans[k, 1] if is_last else events[row + 1, EVENT_T]
        turned += turned_in(record, row, end - events[row, EVENT_T], quickest, work)
        while i < last and (is_last or segments.instants[i] < end):
            t = segments.instants[i]
            turned += turned_in(record, row, t - events[row, EVENT_T], quickest, work)
            beside = event_beside(events, record.marks, row, t, segments.reach)
            if beside > 0:
                other = beside if beside > row else beside - 1
                turned += turned_in(record, other, t - events[other, EVENT_T], quickest, work)
            i += 1
    return turned / LONGEST_PHASE


@kernel
def turned_in(
    record: MotionRecord, row: int, s: float, quickest: float, work: ColumnWorkspace
) -> float:
    """Return the phase through which a series goes in a time s after an event: none in contact."""
    if record.marks[row, KIND] == CONTACT:
        return 0.0
    flight = flight_after(record, row, work.phases, work.scratch)
    if is_plain(flight, s):
        return 0.0
    return series_phase(record.law, flight.region, quickest, s)


@kernel
def event_beside(events: Floats, marks: Integers, row: int, t: float, reach: float) -> int:
    """Return the row of the event next to t that is no knot of a record, -1 if that is far.

    ``row`` is that of the last event before t. What is before an event is seen beside the flight
    that ends with it, and what is after it beside the one that it begins.
    """
    before, after = row, row + 1
    while before > 0 and marks[before, KIND] == KNOT and t - events[before, EVENT_T] <= reach:
        before -= 1
    while after < events.shape[0] and marks[after, KIND] == KNOT:
        if events[after, EVENT_T] - t > reach:
            break
        after += 1
    early = t - events[before, EVENT_T]
    late = events[after, EVENT_T] - t if after < events.shape[0] else math.inf
    return -1 if min(early, late) > reach else after if late < early else before


@kernel
def enters(law: Law, marks: Integers, row: int) -> bool:
    """Return whether a crossing goes into a soft stop: into the stiffer region."""
    before = int(marks[row - 1, NEXT_REGION])
    upwards = int(marks[row, BOUND]) != int(law[before, NUMBER])
    return law[before, UPPER_ENTRY if upwards else LOWER_ENTRY] == 1.0


@kernel
def begin_segment(
    law: Law, change: Change, segments: Segments, k: int, space: SegmentSpace
) -> None:
    """Write the state and the columns at a node, which is moved out of a wall."""
    run, begin = space.run, space.begin
    n_columns = begin.shape[0]
    for p in range(n_columns):
        for j in range(3):
            begin[p, j] = segments.begins[k, p, j]
    lowest = FIRST_HARMONIC + run.phases.shape[0]
    highest = lowest + (int(law[0, N_REGIONS]) - 1) * (1 + run.phases.shape[0])
    nodes = segments.nodes
    for region, kind, column in ((lowest, LOWER_KIND, LOWER), (highest, UPPER_KIND, UPPER)):
        depth = nodes[k, 0] - law[region, column]
        beyond = depth < 0.0 if column == LOWER else depth > 0.0
        if law[region, kind] != WALL or not beyond:
            continue
        nodes[k, 0] = law[region, column]
        bound = int(law[region, NUMBER]) + (0 if column == LOWER else 1)
        for p in range(n_columns):
            begin[p, BEGIN_X] = moved_place(change.rows[p], law, region, bound)
    for i in range(run.state.shape[0]):
        run.state[i] = 0.0
    for i in range(run.counters.shape[0]):
        run.counters[i] = 0
    run.state[T] = segments.spans[k, 0]
    run.state[X] = nodes[k, 0]
    run.state[V] = nodes[k, 1]


@kernel
def march_on(run: Run, t_end: float, progress: Integers) -> int:
    """March towards the end, without keeping grazes; SPENT if that is to be gone on with."""
    if not (abs(run.state[X]) < HUGE and abs(run.state[V]) < HUGE):
        return OVERFLOW
    before = run.counters[N_EVENTS]
    status = march(run, t_end, NO_LIMIT, PATIENCE)
    # An event, or a graze, each took one search at least.
    made = run.counters[N_EVENTS] - before + run.counters[N_GRAZES] + 1
    progress[N_SEARCHES] += PATIENCE if status == SPENT else made
    has_room = run.counters[N_EVENTS] + 2 <= run.events.shape[0]
    if status == FULL and run.counters[N_GRAZES] > 0 and has_room:
        status = SPENT
    run.counters[N_GRAZES] = 0
    return status


@kernel
def tidy(columns: Floats) -> None:
    """Take a column as zero where there is none, at a landing at rest."""
    for n in range(columns.shape[0]):
        for p in range(columns.shape[1]):
            for i in range(columns.shape[2]):
                if math.isnan(columns[n, p, i]):
                    columns[n, p, i] = 0.0


@kernel
def evaluate_at(varied: VariedRecord, columns: Floats, t: float, space: SegmentSpace) -> None:
    """Write x and v, and their columns, at an instant."""
    instant, work = space.instant, space.work
    instant[0] = t
    evaluate(varied.record, instant, True, work.phases, work.scratch, space.motion)
    columns_at(varied, columns, instant, True, work, space.moved)


@kernel
def observe_sample(
    varied: VariedRecord,
    columns: Floats,
    segments: Segments,
    i: int,
    space: SegmentSpace,
    results: SegmentResults,
) -> None:
    """Write what is measured at a sample, on both sides of an event near it, with derivatives."""
    t = segments.instants[i]
    events, marks = varied.record.events, varied.record.marks
    evaluate_at(varied, columns, t, space)
    row = flight_at(events, t, True)
    observe_side(varied, segments, i, (0, row), space, results)
    results.away[i] = math.inf
    beside = event_beside(events, marks, row, t, segments.reach)
    # In the order of the kinds: IMPACT, CROSSING, CONTACT.
    if beside < 1 or not IMPACT <= marks[beside, KIND] <= CONTACT:
        return
    other = beside if beside > row else beside - 1
    results.away[i] = abs(t - events[beside, EVENT_T])
    extrapolate(varied, columns, t, other, space)
    observe_side(varied, segments, i, (1, other), space, results)


@kernel
def extrapolate(
    varied: VariedRecord, columns: Floats, t: float, row: int, space: SegmentSpace
) -> None:
    """Write x, v and their columns beside the flight, or contact, that begins with an event."""
    record, work = varied.record, space.work
    events = record.events
    if record.marks[row, KIND] == CONTACT:
        space.motion[0, 0] = place_of_event(record, row)
        space.motion[1, 0] = 0.0
        for p in range(columns.shape[1]):
            space.moved[0, 0, p] = columns[row, p, BASE]
            space.moved[1, 0, p] = columns[row, p, SPEED]
        return
    flight = flight_after(record, row, work.phases, work.scratch)
    s = (t - events[row, EVENT_T]) - events[row, EVENT_T_LOW]
    y, v = move(flight, s)
    space.motion[0, 0] = place_of_event(record, row) + y
    space.motion[1, 0] = v
    fly(varied, flight, row, s, work, columns)
    for p in range(columns.shape[1]):
        space.moved[0, 0, p] = columns[row, p, BASE] + work.ends[p, 0]
        space.moved[1, 0, p] = work.ends[p, 1]


@kernel
def observe_side(
    varied: VariedRecord,
    segments: Segments,
    i: int,
    where: tuple[int, int],
    space: SegmentSpace,
    results: SegmentResults,
) -> None:
    """Write what is measured in the flight that begins with an event: side and row of that."""
    side = where[0]
    quantity = int(segments.quantities[i])
    if quantity < ACCELERATION:
        results.values[i, side] = space.motion[quantity, 0]
        for p in range(results.rows.shape[2]):
            results.rows[i, side, p] = space.moved[quantity, 0, p]
    elif quantity == ACCELERATION:
        observe_acceleration(varied, segments, i, where, space, results)
    elif segments.stops[quantity - OF_STOP, STOP_BOUND] >= 0.0:
        observe_wall(varied, segments, i, where, space, results)
    else:
        observe_stop(varied, segments, i, where, space, results)


@formula
def write_nothing(values: Floats, rows: Floats, where: tuple[int, int]) -> None:
    """Write a sample that is zero, and stays so, on a side."""
    i, side = where
    values[i, side] = 0.0
    for p in range(rows.shape[2]):
        rows[i, side, p] = 0.0


@formula
def moved_push(
    law: Law, change: Change, p: int, where: tuple[int, float, float], phases: Floats, moved: Floats
) -> float:
    """Return the derivative of a force without damping; ``where`` is region, place and instant."""
    region, x, t = where
    rows = change.rows[p]
    more = moved_drive(law, rows, change.unit, t, 0.0, phases)[0]
    return more + moved_constant_force(law, rows, region, x, moved[0, 0, p])


@kernel
def observe_acceleration(
    varied: VariedRecord,
    segments: Segments,
    i: int,
    where: tuple[int, int],
    space: SegmentSpace,
    results: SegmentResults,
) -> None:
    """Write the acceleration and its derivatives: that of a mass on a wall is zero."""
    side, row = where
    record, change = varied.record, varied.change
    law, marks, phases, t = record.law, record.marks, space.work.phases, segments.instants[i]
    region = int(marks[row, NEXT_REGION])
    x = space.motion[0, 0]
    v = space.motion[1, 0]
    if marks[row, KIND] == CONTACT:
        write_nothing(results.values, results.rows, (i, side))
        return
    set_phases(law, t, 0.0, phases)
    drag = 2.0 * law[region, DAMPING]
    push = constant_force(law, region, x) + force_and_slopes(law, phases)[0]
    results.values[i, side] = push - drag * v
    for p in range(results.rows.shape[2]):
        more = moved_push(law, change, p, (region, x, t), phases, space.moved)
        more -= 2.0 * change.rows[p, region, DAMPING] * v + drag * space.moved[1, 0, p]
        results.rows[i, side, p] = more


@kernel
def observe_wall(
    varied: VariedRecord,
    segments: Segments,
    i: int,
    where: tuple[int, int],
    space: SegmentSpace,
    results: SegmentResults,
) -> None:
    """Write the force of a wall on the mass in contact, and its derivatives; zero in flight."""
    side, row = where
    record, change = varied.record, varied.change
    law, marks, phases, t = record.law, record.marks, space.work.phases, segments.instants[i]
    region = int(marks[row, NEXT_REGION])
    stop = segments.stops[int(segments.quantities[i]) - OF_STOP]
    write_nothing(results.values, results.rows, (i, side))
    if marks[row, KIND] != CONTACT or float(marks[row, BOUND]) != stop[STOP_BOUND]:
        return
    x = space.motion[0, 0]
    mass = law[0, MASS]
    set_phases(law, t, 0.0, phases)
    push = constant_force(law, region, x) + force_and_slopes(law, phases)[0]
    results.values[i, side] = -mass * push
    for p in range(results.rows.shape[2]):
        more = moved_push(law, change, p, (region, x, t), phases, space.moved)
        results.rows[i, side, p] = -mass * more - change.rows[p, 0, MASS] * push


@kernel
def observe_stop(
    varied: VariedRecord,
    segments: Segments,
    i: int,
    where: tuple[int, int],
    space: SegmentSpace,
    results: SegmentResults,
) -> None:
    """Write the force of a soft stop on the mass, and its derivatives; zero off it."""
    side, row = where
    law, change = varied.record.law, varied.change
    which = int(segments.quantities[i]) - OF_STOP
    stop = segments.stops[which]
    number = law[int(varied.record.marks[row, NEXT_REGION]), NUMBER]
    write_nothing(results.values, results.rows, (i, side))
    if number < stop[STOP_FIRST] or number > stop[STOP_LAST]:
        return
    mass = law[0, MASS]
    v = space.motion[1, 0]
    depth = space.motion[0, 0] - stop[STOP_AT]
    push = -stop[STOP_STIFFNESS] * depth - stop[STOP_DRAG] * v
    results.values[i, side] = mass * push
    for p in range(results.rows.shape[2]):
        own = segments.moved_stops[p, which]
        more = -own[CHANGE_OF_STIFFNESS] * depth - 2.0 * own[CHANGE_OF_DAMPING] * v
        more -= stop[STOP_STIFFNESS] * (space.moved[0, 0, p] - own[CHANGE_OF_AT])
        more -= stop[STOP_DRAG] * space.moved[1, 0, p]
        results.rows[i, side, p] = mass * more + change.rows[p, 0, MASS] * push
