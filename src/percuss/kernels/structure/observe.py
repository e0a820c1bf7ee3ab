"""Turning points of an observable of a structure along a run, and its passages of a level.

An observable is linear in the modes and the loads under each set of acting stops, and so is its
derivative: it is a guard as a clearance is, and `next_event` finds its falls through zero with the
same proof. A guard and its negative take turns: after a fall of the one the other is positive.
"""

from __future__ import annotations

from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import ULP, Pair, later
from percuss.kernels.compile import kernel
from percuss.kernels.event_location import GRAZE, HIT
from percuss.kernels.flight import set_phases
from percuss.kernels.next_event import PAUSE
from percuss.kernels.record import BOUND, EVENT_T, EVENT_T_LOW, HUGE, NEXT_REGION
from percuss.kernels.sample import flight_at
from percuss.kernels.structure.basis import CONSTANT, IS_ON, QUICKEST, basis_with
from percuss.kernels.structure.flight import (
    ModalFlight,
    arrive,
    derivatives,
    move,
    uncertainty,
)
from percuss.kernels.structure.next_event import next_event
from percuss.kernels.structure.run import (
    StructureRun,
    begin_flight,
    decompose,
    displace,
    restitution,
    speed_of,
    value_of,
)
from percuss.kernels.structure.sample import flight_after, held_after, tail_after

# The rows of a gauge: the observable, the function whose zeros are sought, and its negative.
OBSERVED, RISING, FALLING = range(3)
GAUGE_ROWS = 3
# Entries of the progress along a run: the stretch, two for each event, the second that of a tail
# after its first hop; whether it has begun; the instant from which it goes on; which of the two
# rows is watched, 0 before the first; and a stop that does not press in a tail, -1 for none.
STRETCH, INSIDE, NOW, NOW_LOW, WATCHED, STOP = range(6)
PROGRESS_ENTRIES = 6
# Columns of what is written: the instant, the observable there, that of the function whose zeros
# are sought, and the kind of the row.
AT_T, AT_VALUE, AT_SLOPE, AT_KIND = range(4)
TRACE_COLUMNS = 4
BEGIN, PASSAGE, END = range(3)


class Gauge(NamedTuple):
    """An observable and the function whose zeros are sought, in b sets, as `Sets` has guards.

    acts: (b,), whether the observable is anything but 0; guard: (b, 3, n, 3); levels: (b, 3,
    LEVEL_COLUMNS); feed: (b, 3, m, 2); record_feed, slope_feed: (b, 3, r), what the values and the
    slopes of records add. The rest is scratch: levels of the present flight, its values, orders and
    how far it is searched (3,), and arrays of the search.
    """

    acts: Floats
    guard: Floats
    levels: Floats
    feed: Floats
    record_feed: Floats
    slope_feed: Floats
    present: Floats
    values: Floats
    order: Floats
    free: Floats
    scratch: Floats


@kernel
def gauge_flight(run: StructureRun, gauge: Gauge, b: int) -> ModalFlight:
    """Return the flight of the run's modes and loads in a set, with the rows of a gauge as its guards."""
    for i in range(GAUGE_ROWS):
        for k in range(gauge.present.shape[1]):
            gauge.present[i, k] = gauge.levels[b, i, k]
        for k in range(run.records.shape[0]):
            gauge.present[i, CONSTANT] += gauge.slope_feed[b, i, k] * run.records[k, 1]
    basis = basis_with(
        run.sets, b, gauge.guard[b], gauge.present, gauge.feed[b], gauge.record_feed[b]
    )
    return begin_flight(run, basis, gauge.values, gauge.order)


@kernel
def observe_at(run: StructureRun, gauge: Gauge, instants: Floats, after: bool, out: Floats) -> None:
    """Write an observable at instants of a run, (n_times,)."""
    gauge.order[OBSERVED] = 0.0
    for k in range(instants.shape[0]):
        row = flight_at(run.events, instants[k], after)
        b = run.marks[row, NEXT_REGION]
        out[k] = 0.0
        if gauge.acts[b] == 0.0:
            continue
        flight_after(run, row)
        flight = gauge_flight(run, gauge, b)
        gauge.values[OBSERVED] = value_of(flight, OBSERVED)
        s = (instants[k] - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW]
        move(flight, s)
        out[k] = derivatives(flight, OBSERVED, s, False)[0]


@kernel
def first_hop(run: StructureRun, row: int, tail: float) -> float:
    """Return how long the first hop of a chatter's tail lasts."""
    stop = run.marks[row + 1, BOUND]
    flight = flight_after(run, row)
    speed = speed_of(flight.basis, stop, run.begin)
    return tail * (1.0 - restitution(run.sets, stop, speed))


@kernel
def stretch_of(run: StructureRun, stretch: int) -> tuple[int, float, float]:
    """Return the set of a stretch, and when it begins and ends, counted from its event."""
    row = stretch // 2
    tail = tail_after(run, row)
    hop = 0.0
    if tail > 0.0:
        hop = first_hop(run, row, tail)
    if stretch % 2 == 1:
        b = run.marks[min(row + 1, run.marks.shape[0] - 1), NEXT_REGION]
        return b, hop, tail
    if tail > 0.0:
        return run.marks[row, NEXT_REGION], 0.0, hop
    whole = HUGE
    if row + 1 < run.events.shape[0]:
        whole = (run.events[row + 1, EVENT_T] - run.events[row, EVENT_T]) + (
            run.events[row + 1, EVENT_T_LOW] - run.events[row, EVENT_T_LOW]
        )
    return run.marks[row, NEXT_REGION], 0.0, whole


@kernel
def set_out(run: StructureRun, stretch: int, s: float, progress: Floats) -> None:
    """Take the run's modes and loads to a time s after the event of a stretch."""
    row = stretch // 2
    # After the first hop of a tail the wall holds the structure in the mean.
    flight = held_after(run, row) if stretch % 2 == 1 else flight_after(run, row)
    instant = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
    go_on(run, flight, instant, (s, 0.0), progress)


@kernel
def go_on(run: StructureRun, flight: ModalFlight, instant: Pair, s: Pair, progress: Floats) -> None:
    """Take modes and loads on by the time s, a pair, from the instant of a flight's start."""
    since = s[0] + s[1]
    if since > 0.0:
        arrive(flight, since, run.begin)
    t, t_low = later(instant[0], instant[1], s[0])
    progress[NOW], progress[NOW_LOW] = later(t, t_low, s[1])
    if run.phases.shape[0] > 0:
        set_phases(run.sets.law[0], progress[NOW], progress[NOW_LOW], run.phases)
    for k in range(run.records.shape[0]):
        # A flight is in one piece of a record, also where it ends at a knot to within rounding.
        run.records[k, 0] += since * run.records[k, 1]


@kernel
def trace(run: StructureRun, gauge: Gauge, span: Pair, progress: Floats, rows: Floats) -> int:
    """Write what an observable does between two instants of a run; return how many rows.

    Each stretch gives a BEGIN, its PASSAGEs through zero, and an END. Where it
    passes at an event to within rounding, that is one passage if it has another sign after the
    event than before. Called again where the rows were filled, it goes on.
    """
    count = 0
    while count + 4 <= rows.shape[0]:
        stretch = int(progress[STRETCH])
        row = stretch // 2
        if row >= run.events.shape[0] or run.events[row, EVENT_T] > span[1]:
            break
        b, first, last = stretch_of(run, stretch)
        if not last > first and (stretch % 2 == 1 or row + 1 < run.events.shape[0]):
            # No tail, or two events of one instant: there is no motion between.
            progress[STRETCH] += 1.0
            continue
        t, t_low = run.events[row, EVENT_T], run.events[row, EVENT_T_LOW]
        begins = max(first, (span[0] - t) - t_low)
        ends = max(first, min(last, (span[1] - t) - t_low))
        if begins > last and row + 1 < run.events.shape[0]:
            # An instant that is given is no finer than a float: that of an event has both limits.
            begins = last if span[0] <= run.events[row + 1, EVENT_T] else begins
        if begins > ends:
            progress[STRETCH] += 1.0
            continue
        acts = gauge.acts[b]
        if stretch % 2 == 1 and run.marks[row + 1, BOUND] == progress[STOP]:
            # The impulses of a tail are no force.
            acts = 0.0
        if acts == 0.0:
            note_trace(rows, count, t + begins, 0.0, 0.0, BEGIN)
            progress[STRETCH] += 1.0
            count += 1
            continue
        if progress[INSIDE] == 0.0:
            set_out(run, stretch, begins, progress)
            flight = gauge_flight(run, gauge, b)
            count = begin_trace(flight, gauge, progress, rows, count)
            progress[INSIDE] = 1.0
        flight = gauge_flight(run, gauge, b)
        longest = ends - ((progress[NOW] - t) + (progress[NOW_LOW] - t_low))
        watched = int(progress[WATCHED])
        gauge.present[OBSERVED, IS_ON] = 0.0
        gauge.present[RISING, IS_ON] = 1.0 if watched == RISING else 0.0
        gauge.present[FALLING, IS_ON] = 1.0 if watched == FALLING else 0.0
        verdict, s, _, slope, s_low = next_event(
            flight, gauge.scratch, run.rows, gauge.free, longest
        )
        if verdict in (PAUSE, GRAZE):
            continue
        if (
            verdict == HIT
            and abs(slope) < HUGE
            and (s == 0.0 or abs(slope) * (longest - s) > doubt_at(flight, watched, longest))
        ):
            count = pass_through(run, flight, gauge, (s, s_low, slope), progress, rows, count)
            continue
        move(flight, max(longest, 0.0))
        value = derivatives(flight, OBSERVED, longest, False)[0]
        note_trace(rows, count, t + ends, value, 0.0, END)
        count += 1
        if stretch % 2 == 1 and ends == last:
            set_out(run, stretch, ends, progress)
            count = note_end_of_tail(run, gauge, stretch, rows, count)
        progress[STRETCH] += 1.0
        progress[INSIDE] = 0.0
    return count


@kernel
def note_end_of_tail(
    run: StructureRun, gauge: Gauge, stretch: int, rows: Floats, count: int
) -> int:
    """Write an observable where the hops end, at the present instant; return how many rows then.

    All forces still act there, and the contact has not begun.
    """
    row = stretch // 2
    free = run.marks[row, NEXT_REGION]
    if gauge.acts[free] == 0.0:
        return count
    place = run.scratch[6, : run.sets.offset.shape[1]]
    displace(run.sets, run.marks[row + 1, NEXT_REGION], run.begin, place)
    decompose(run.sets, free, place, run.begin)
    flight = gauge_flight(run, gauge, free)
    note_trace(rows, count, run.events[row + 1, EVENT_T], value_of(flight, OBSERVED), 0.0, END)
    return count + 1


@kernel
def doubt_at(flight: ModalFlight, i: int, s: float) -> float:
    """Return within which rounding a guard is zero at a time s."""
    return 4.0 * uncertainty(flight, i, s)


@kernel
def begin_trace(
    flight: ModalFlight, gauge: Gauge, progress: Floats, rows: Floats, count: int
) -> int:
    """Write the BEGIN of a stretch, and the passage at its event; return how many rows then."""
    gauge.order[OBSERVED] = 0.0
    gauge.values[OBSERVED] = value_of(flight, OBSERVED)
    note_trace(rows, count, progress[NOW], gauge.values[OBSERVED], 0.0, BEGIN)
    count += 1
    value = value_of(flight, RISING)
    gauge.order[RISING] = 0.0
    doubt = uncertainty(flight, RISING, 0.0)
    doubt += 4.0 * ULP * abs(gauge.present[RISING, CONSTANT])
    before = int(progress[WATCHED])
    if abs(value) <= doubt:
        order = order_of_zero(flight, RISING, doubt)
        set_guard(gauge, max(before, RISING), 0.0, order, progress)
        return count
    side = RISING if value > 0.0 else FALLING
    set_guard(gauge, side, abs(value), 0.0, progress)
    if before not in (0, side):
        slope = derivatives(flight, RISING, 0.0, True)[1]
        note_trace(rows, count, progress[NOW], gauge.values[OBSERVED], slope, PASSAGE)
        count += 1
    return count


@kernel
def order_of_zero(flight: ModalFlight, i: int, doubt: float) -> float:
    """Return the order of a guard's zero at the start of a flight, up to 3.

    ``doubt`` is the rounding of its value. A wall lets go without an acceleration: the velocity
    there has a double zero, whose slope is rounding alone, that of all forces which cancel.
    """
    _, first, second, _, _, _ = derivatives(flight, i, 0.0, True)
    rate = flight.basis.of_set[QUICKEST]
    if rate > 0.0:
        doubt = max(doubt, uncertainty(flight, i, 1.0 / rate))
    if abs(first) > doubt * rate:
        return 1.0
    return 2.0 if abs(second) > doubt * rate * rate else 3.0


@kernel
def set_guard(gauge: Gauge, side: int, value: float, order: float, progress: Floats) -> None:
    """Watch one of the two rows from here on, which has a value, or exactly a zero of an order."""
    for i in range(RISING, GAUGE_ROWS):
        gauge.values[i] = value if i == side else -value
        gauge.order[i] = order
        gauge.free[i] = 0.0
    progress[WATCHED] = side


@kernel
def pass_through(
    run: StructureRun,
    flight: ModalFlight,
    gauge: Gauge,
    fall: tuple[float, float, float],
    progress: Floats,
    rows: Floats,
    count: int,
) -> int:
    """Go on from where the guard falls through zero; ``fall`` is (s, s_low, its slope)."""
    s, s_low, slope = fall
    watched = int(progress[WATCHED])
    is_start = s == 0.0 and progress[STRETCH] == 0.0
    if s > 0.0:
        go_on(run, flight, (progress[NOW], progress[NOW_LOW]), (s, s_low), progress)
        gauge.values[OBSERVED] = value_of(flight, OBSERVED)
    if not is_start:
        slope = slope if watched == RISING else -slope
        note_trace(rows, count, progress[NOW], gauge.values[OBSERVED], slope, PASSAGE)
        count += 1
    # At the start of a flight the order of the zero is known, after it a passage has a slope.
    order = 1.0 if s > 0.0 else max(1.0, gauge.order[watched])
    set_guard(gauge, FALLING if watched == RISING else RISING, 0.0, order, progress)
    return count


@kernel
def note_trace(rows: Floats, count: int, t: float, value: float, slope: float, kind: int) -> None:
    """Write a row of a trace."""
    rows[count, AT_T] = t
    rows[count, AT_VALUE] = value
    rows[count, AT_SLOPE] = slope
    rows[count, AT_KIND] = kind
