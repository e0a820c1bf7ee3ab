"""The runs of a structure from many nodes, with what is measured of them and its derivatives.

What `kernels.segments` is for one mass: each segment is a run from a node with a state of its own,
whose 2 n numbers are unknowns beside the parameters. The columns of a run go from sample to sample,
not from the last event to each.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import kernel
from percuss.kernels.record import (
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    FULL,
    HUGE,
    IMPACT,
    KIND,
    N_EVENTS,
    N_GRAZES,
    OVERFLOW,
    REACHED_END,
    SLOW_LANDING,
    SPENT,
    V_AFTER,
    T,
)
from percuss.kernels.sample import flight_at
from percuss.kernels.segments import (
    ACCELERATION,
    CHANGE_OF_AT,
    CHANGE_OF_DAMPING,
    CHANGE_OF_STIFFNESS,
    IS_BEGUN,
    N_HITS,
    N_SEARCHES,
    NO_LIMIT,
    OF_STOP,
    PATIENCE,
    SEGMENT,
    SegmentResults,
    event_beside,
    write_nothing,
)
from percuss.kernels.structure.basis import DRAG, IS_WALL, SPRING, basis_of
from percuss.kernels.structure.columns import (
    begin_series,
    column_changes,
    fill_columns,
    fill_modes,
    fill_phases,
    moved_force,
)
from percuss.kernels.structure.flight import ModalFlight, U, W, arrive, derivatives
from percuss.kernels.structure.march import march
from percuss.kernels.structure.run import (
    NEW_SET,
    SET,
    WANTED,
    StructureRun,
    decompose,
    displace,
    value_of,
)
from percuss.kernels.structure.sample import evaluate, tail_after
from percuss.kernels.structure.sensitivity import (
    DT,
    CarryWorkspace,
    ColumnRecord,
    VariedRun,
    begin_columns,
    carry_columns,
    columns_at,
    flight_from,
)
from percuss.kernels.structure.tangent import set_of_flight, to_places

# A quantity of a coordinate or point is its number and this many times that of the place.
OF_PLACE = 1 << 16


class StructureSegments(NamedTuple):
    """Where segments begin and end, and the samples of each.

    spans: (n, 2), the instants; nodes: (n, n_x, 2), x and v at the first; sets: (n,), the acting
    stops there; begins: (n, 2 n_x + 1, p), the columns of x, v and t there. Sample i, of those from
    first[k] to first[k + 1] in segment k, is of quantities[i] at instants[i]; directions:
    (n_places, n_x), c of each place. Of stops (s, 3) at, stiffness and damping, with their changes
    (p, s, 3), and signs (s,), 1 where the clearance grows with y.
    """

    spans: Floats
    nodes: Floats
    sets: Integers
    begins: Floats
    first: Integers
    instants: Floats
    quantities: Integers
    reach: float
    directions: Floats
    stops: Floats
    moved_stops: Floats
    signs: Floats
    stop_directions: Floats


class SegmentScratch(NamedTuple):
    """Scratch: the columns of all events, and what stands at one instant.

    There ``place`` (n_x, 2) and ``whole`` (1, n_x, 2) are the coordinates with their velocities,
    ``column`` (1, 2, n_x, p) their columns, ``rates`` (n_x,) the accelerations and ``paces`` (n_x,
    p) the columns of these; ``instant`` is (1,).
    """

    record: ColumnRecord
    work: CarryWorkspace
    place: Floats
    whole: Floats
    instant: Floats
    column: Floats
    paces: Floats
    rates: Floats


@kernel
def follow_structure_segments(
    varied: VariedRun,
    segments: StructureSegments,
    scratch: SegmentScratch,
    results: SegmentResults,
    progress: Integers,
) -> int:
    """Follow segments from where they were left; return bits of a set that is not known, or -1.

    ``progress`` is that of `percuss.kernels.segments`; control returns after some `PATIENCE`
    searches too.
    """
    run = varied.run
    before = progress[N_SEARCHES]
    while progress[SEGMENT] < segments.spans.shape[0]:
        if progress[N_SEARCHES] - before >= PATIENCE:
            return -1
        k = progress[SEGMENT]
        if progress[IS_BEGUN] == 0:
            begin_segment(run, segments, k)
            progress[IS_BEGUN] = 1
        status = march_on(run, segments.spans[k, 1], progress)
        if status == NEW_SET:
            # The sets have other arrays then, and so has the run, which begins anew.
            progress[IS_BEGUN] = 0
            return run.counters[WANTED]
        if status == SPENT:
            continue
        if status == REACHED_END:
            n = run.counters[N_EVENTS]
            results.counts[k] = n - 1
            observe_segment(record_of(varied, n), segments, k, scratch, results, progress)
        else:
            results.counts[k] = -1
        progress[SEGMENT] += 1
        progress[IS_BEGUN] = 0
    return -1


@kernel
def record_of(varied: VariedRun, n: int) -> VariedRun:
    """Return the run with the rows of its first events alone."""
    run = varied.run
    own = StructureRun(
        run.sets,
        run.state,
        run.counters,
        run.begin,
        run.order,
        run.free,
        run.pull,
        run.phases,
        run.records,
        run.values,
        run.later,
        run.arrival,
        run.at,
        run.scratch,
        run.rows,
        run.events[:n],
        run.marks[:n],
        run.states[:n],
        run.grazes,
    )
    return VariedRun(own, varied.moved, varied.graze_times, varied.graze_stops, varied.jumps)


@kernel
def begin_segment(run: StructureRun, segments: StructureSegments, k: int) -> None:
    """Write the state of a node."""
    for i in range(run.state.shape[0]):
        run.state[i] = 0.0
    for i in range(run.counters.shape[0]):
        run.counters[i] = 0
    for i in range(run.order.shape[0]):
        run.order[i] = 0.0
    run.state[T] = segments.spans[k, 0]
    run.counters[SET] = segments.sets[k]
    decompose(run.sets, segments.sets[k], segments.nodes[k], run.begin)


@kernel
def march_on(run: StructureRun, t_end: float, progress: Integers) -> int:
    """March towards the end, without keeping grazes; SPENT if that is to be gone on with."""
    for j in range(run.begin.shape[0]):
        for part in range(2):
            if not abs(run.begin[j, part]) < HUGE:
                return OVERFLOW
    before = run.counters[N_EVENTS]
    status = march(run, t_end, NO_LIMIT, PATIENCE)
    made = run.counters[N_EVENTS] - before + run.counters[N_GRAZES] + 1
    progress[N_SEARCHES] += made
    has_room = run.counters[N_EVENTS] + run.order.shape[0] + 2 <= run.events.shape[0]
    if status == FULL and run.counters[N_GRAZES] > 0 and has_room:
        status = SPENT
    run.counters[N_GRAZES] = 0
    return status


@kernel
def observe_segment(
    varied: VariedRun,
    segments: StructureSegments,
    k: int,
    scratch: SegmentScratch,
    results: SegmentResults,
    progress: Integers,
) -> None:
    """Write samples, end and hits of a segment that has been followed."""
    run, work = varied.run, scratch.work
    n = run.events.shape[0]
    record = ColumnRecord(
        scratch.record.instants[:n], scratch.record.places[:n], scratch.record.gaps[:n]
    )
    carry_columns(varied, segments.begins[k], record, work)
    tidy(record)
    present = -1
    since = 0.0
    for i in range(segments.first[k], segments.first[k + 1]):
        t = segments.instants[i]
        row = flight_at(run.events, t, True)
        s = max((t - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW], 0.0)
        b = set_of_flight(run, row, row == n - 1)
        if tail_after(run, row) > 0.0:
            observe_tail(varied, record, segments, (i, row), scratch, results)
            present = -1
            continue
        if row != present:
            begin_columns(varied, record, row, b, work)
            flight = flight_from(run, row)
            start = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
            begin_series(flight, varied.moved, start[0], start[1], work.series)
            present, since = row, 0.0
        flight = flight_of_row(varied, b)
        go_to(flight, varied, b, (run.events[row, EVENT_T], since, s - since), work)
        since = s
        observe_side(varied, segments, (i, 0, row, b), s, scratch, results)
        if observe_beside(varied, record, segments, (i, row), scratch, results):
            present = -1
    scratch.instant[0] = segments.spans[k, 1]
    evaluate(run, scratch.instant, True, scratch.whole)
    columns_at(varied, record, scratch.instant, True, work, scratch.column)
    n_x = scratch.place.shape[0]
    for i in range(n_x):
        for part in range(2):
            results.ends[k, part * n_x + i] = scratch.whole[0, i, part]
            for p in range(results.end_rows.shape[2]):
                results.end_rows[k, part * n_x + i, p] = scratch.column[0, part, i, p]
    note_hits(run, record, k, results, progress)


@kernel
def flight_of_row(varied: VariedRun, b: int) -> ModalFlight:
    """Return the flight whose modes, loads and inputs stand in the run's scratch."""
    run = varied.run
    return ModalFlight(
        basis_of(run.sets, b),
        run.begin,
        run.pull,
        run.phases,
        run.records,
        run.values,
        run.order,
        run.later,
        run.arrival,
        run.at,
    )


@kernel
def go_to(
    flight: ModalFlight,
    varied: VariedRun,
    b: int,
    times: tuple[float, float, float],
    work: CarryWorkspace,
) -> None:
    """Take modes and columns of the scratch along a flight; ``times`` as `column_changes` has them."""
    column_changes(flight, varied.moved, b, times, work.columns, work.changes, work.series)
    for j in range(work.columns.shape[0]):
        for part in range(2):
            for p in range(work.columns.shape[2]):
                work.columns[j, part, p] += work.changes[j, part, p]


@kernel
def note_hits(
    run: StructureRun, record: ColumnRecord, k: int, results: SegmentResults, progress: Integers
) -> None:
    """Write the impacts and the entries into soft stops of a segment."""
    for row in range(1, run.events.shape[0]):
        kind = run.marks[row, KIND]
        is_hit = kind in (IMPACT, SLOW_LANDING)
        if kind == CROSSING:
            is_hit = run.events[row, V_AFTER] < 0.0
        if is_hit and progress[N_HITS] < results.hits.shape[0]:
            hit = results.hits[progress[N_HITS]]
            hit[0] = k
            hit[1] = run.events[row, EVENT_T]
            for p in range(record.instants.shape[2]):
                hit[2 + p] = record.instants[row, DT, p]
            progress[N_HITS] += 1


@kernel
def tidy(record: ColumnRecord) -> None:
    """Take a column as zero where there is none, at a landing at rest."""
    instants, places, gaps = record.instants, record.places, record.gaps
    for row in range(gaps.shape[0]):
        for p in range(gaps.shape[1]):
            if math.isnan(gaps[row, p]):
                gaps[row, p] = 0.0
            for i in range(instants.shape[1]):
                if math.isnan(instants[row, i, p]):
                    instants[row, i, p] = 0.0
            for part in range(2):
                for i in range(places.shape[2]):
                    if math.isnan(places[row, part, i, p]):
                        places[row, part, i, p] = 0.0


@kernel
def observe_beside(
    varied: VariedRun,
    record: ColumnRecord,
    segments: StructureSegments,
    where: tuple[int, int],
    scratch: SegmentScratch,
    results: SegmentResults,
) -> bool:
    """Write what a sample would be on the other side of an event near it; return whether it is.

    ``where`` are the sample and the event before it.
    """
    i, row = where
    run, work = varied.run, scratch.work
    events, marks = run.events, run.marks
    t = segments.instants[i]
    results.away[i] = math.inf
    beside = event_beside(events, marks, row, t, segments.reach)
    if beside < 1 or not IMPACT <= marks[beside, KIND] <= CONTACT:
        return False
    other = beside if beside > row else beside - 1
    if tail_after(run, other) > 0.0:
        return False
    results.away[i] = abs(t - events[beside, EVENT_T])
    b = set_of_flight(run, other, other == events.shape[0] - 1)
    begin_columns(varied, record, other, b, work)
    flight = flight_from(run, other)
    start = (events[other, EVENT_T], events[other, EVENT_T_LOW])
    begin_series(flight, varied.moved, start[0], start[1], work.series)
    s = (t - start[0]) - start[1]
    go_to(flight, varied, b, (start[0], 0.0, s), work)
    observe_side(varied, segments, (i, 1, other, b), s, scratch, results)
    return True


@kernel
def observe_tail(
    varied: VariedRun,
    record: ColumnRecord,
    segments: StructureSegments,
    where: tuple[int, int],
    scratch: SegmentScratch,
    results: SegmentResults,
) -> None:
    """Write a sample in the summed tail of a chatter: what is no displacement, that of the mean."""
    i, row = where
    run, work = varied.run, scratch.work
    scratch.instant[0] = segments.instants[i]
    kind = segments.quantities[i] % OF_PLACE
    results.away[i] = math.inf
    if kind < ACCELERATION:
        c = segments.directions[segments.quantities[i] // OF_PLACE]
        evaluate(run, scratch.instant, True, scratch.whole)
        columns_at(varied, record, scratch.instant, True, work, scratch.column)
        write_nothing(results.values, results.rows, (i, 0))
        for j in range(c.shape[0]):
            results.values[i, 0] += c[j] * scratch.whole[0, j, kind]
            for p in range(results.rows.shape[2]):
                results.rows[i, 0, p] += c[j] * scratch.column[0, kind, j, p]
        return
    b = set_of_flight(run, row, False)
    begin_columns(varied, record, row, b, work)
    flight = flight_from(run, row)
    start = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
    begin_series(flight, varied.moved, start[0], start[1], work.series)
    s = max((scratch.instant[0] - start[0]) - start[1], 0.0)
    go_to(flight, varied, b, (start[0], 0.0, s), work)
    observe_side(varied, segments, (i, 0, row, b), s, scratch, results)


@kernel
def observe_side(
    varied: VariedRun,
    segments: StructureSegments,
    where: tuple[int, int, int, int],
    s: float,
    scratch: SegmentScratch,
    results: SegmentResults,
) -> None:
    """Write what is measured from the modes and columns of the scratch, a time s into a flight.

    ``where`` are the sample, its side, the event before and the set.
    """
    i, side, _, b = where
    run, work = varied.run, scratch.work
    kind = segments.quantities[i] % OF_PLACE
    place = scratch.place
    displace(run.sets, b, work.series.present, place)
    to_places(run.sets, b, work.columns, work.place)
    for j in range(place.shape[0]):
        for p in range(results.rows.shape[2]):
            work.place[0, j, p] += varied.moved.places[b, j, p]
    if kind >= OF_STOP:
        observe_stop(varied, segments, where, s, scratch, results)
        return
    if kind == ACCELERATION:
        accelerate(varied, where, s, scratch)
    c = segments.directions[segments.quantities[i] // OF_PLACE]
    value = 0.0
    for j in range(c.shape[0]):
        value += c[j] * (scratch.rates[j] if kind == ACCELERATION else place[j, kind])
    results.values[i, side] = value
    for p in range(results.rows.shape[2]):
        row = 0.0
        for j in range(c.shape[0]):
            if kind == ACCELERATION:
                row += c[j] * scratch.paces[j, p]
            else:
                row += c[j] * work.place[kind, j, p]
        results.rows[i, side, p] = row


@kernel
def accelerate(
    varied: VariedRun,
    where: tuple[int, int, int, int],
    s: float,
    scratch: SegmentScratch,
) -> None:
    """Write the accelerations of the coordinates and their columns, a time s into a flight."""
    _, _, row, b = where
    run, series = varied.run, scratch.work.series
    columns = scratch.work.columns
    flight = flight_of_row(varied, b)
    for j in range(columns.shape[0]):
        for part in range(2):
            series.modes[0, j, part] = series.present[j, part]
            for p in range(columns.shape[2]):
                series.columns[0, j, part, p] = columns[j, part, p]
    fill_phases(flight, s, 1.0, 1, series)
    fill_modes(flight, s, 1.0, 1, series)
    fill_columns(flight, varied.moved, b, (run.events[row, EVENT_T], s, 1.0), 1, series)
    sets = run.sets
    for i in range(scratch.rates.shape[0]):
        scratch.rates[i] = 0.0
        for p in range(columns.shape[2]):
            scratch.paces[i, p] = 0.0
        for j in range(columns.shape[0]):
            of_u = -sets.shape[b, j, 1, i] * sets.modes[b, j, SPRING]
            of_w = sets.shape[b, j, 0, i] - sets.shape[b, j, 1, i] * sets.modes[b, j, DRAG]
            scratch.rates[i] += of_u * series.modes[1, j, U] + of_w * series.modes[1, j, W]
            for p in range(columns.shape[2]):
                moved = of_u * series.columns[1, j, U, p] + of_w * series.columns[1, j, W, p]
                scratch.paces[i, p] += moved


@kernel
def observe_stop(
    varied: VariedRun,
    segments: StructureSegments,
    where: tuple[int, int, int, int],
    s: float,
    scratch: SegmentScratch,
    results: SegmentResults,
) -> None:
    """Write the force of a stop along its c, that of a wall where it holds; zero off it."""
    i, side, row, b = where
    run, work = varied.run, scratch.work
    which = segments.quantities[i] % OF_PLACE - OF_STOP
    write_nothing(results.values, results.rows, (i, side))
    if not run.sets.keys[b] >> which & 1:
        return
    if run.sets.stops[which, IS_WALL] == 1.0:
        flight = flight_of_row(varied, b)
        start = run.events[row, EVENT_T]
        run.values[which] = value_of(flight, which)
        modes = run.scratch[1, : run.begin.shape[0]]
        arrive(flight, s, modes)
        sign = segments.signs[which]
        results.values[i, side] = sign * derivatives(flight, which, s, False)[0]
        moved_force(
            flight, varied.moved, b, which, (start, s), work.columns, work.series, work.forces
        )
        for p in range(results.rows.shape[2]):
            results.rows[i, side, p] = sign * work.forces[p]
        return
    c = segments.stop_directions[which]
    spring, drag = segments.stops[which, 1], segments.stops[which, 2]
    depth, speed = -segments.stops[which, 0], 0.0
    for j in range(c.shape[0]):
        depth += c[j] * scratch.place[j, 0]
        speed += c[j] * scratch.place[j, 1]
    results.values[i, side] = -spring * depth - drag * speed
    for p in range(results.rows.shape[2]):
        own = segments.moved_stops[p, which]
        off, faster = -own[CHANGE_OF_AT], 0.0
        for j in range(c.shape[0]):
            off += c[j] * work.place[0, j, p]
            faster += c[j] * work.place[1, j, p]
        row_of = -own[CHANGE_OF_STIFFNESS] * depth - own[CHANGE_OF_DAMPING] * speed
        results.rows[i, side, p] = row_of - spring * off - drag * faster
