"""The arrays in which a run keeps its state and its record.

The state is in small arrays, so that a run can be left at any event and taken up again with the
same bits; events, marks and grazes are written into arrays of the caller, with the columns named
below.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import kernel
from percuss.kernels.flight import Flight, constant_force, force_and_slopes, place, set_phases
from percuss.kernels.law_columns import N_HARMONICS, Law

# What an event is: column KIND of the marks.
# (As int64 and not int, for which numba would compile a function anew for each value.)
# After a SLOW_LANDING, whose speed is lost in its own rounding, the mass is at rest on the wall.
# A KNOT is no event of the motion: the force has another slope from there on (`pieces`).
IMPACT, CROSSING, CONTACT, RELEASE, START, SLOW_LANDING, KNOT = (
    np.int64(kind) for kind in range(7)
)

# Why `march` came back.
MOVING, REACHED_END, REACHED_LIMIT, AT_REST, OVERFLOW, NO_MORE, FULL, SPENT = range(8)

# Entries of the state: the last event's instant, place, velocity after it, and constant force;
# how far the flight, or contact, from it has been searched; the greatest impact speed so far; for
# how long a contact has lasted up to the last knot, at which its instant is then.
T, T_LOW, X, V, FORCE, FREE_BELOW, FREE_ABOVE, CONTACT_UNTIL, FASTEST, HELD = range(10)
# What the last harmonic flight has left for the search of the next, and the instant of its end.
CARRIED_T, CARRIED_T_LOW, CARRIED_PUSH, CARRIED_RATE = range(10, 14)
STATE_ENTRIES = 14
# Entries of the counters: the region's row; the wall touched, as the sign of its normal (0 in
# flight); and how many events, impacts or entries into soft stops, and grazes there were.
REGION, TOUCHED, N_EVENTS, N_IMPACTS, N_GRAZES = range(5)
COUNTERS = 5

# Columns of `events`. In place of a velocity before it a CONTACT has the error bound of its
# instant, and a KNOT the position.
EVENT_T, EVENT_T_LOW, V_BEFORE, V_AFTER = range(4)
CONTACT_ERROR = KNOT_X = V_BEFORE
EVENT_COLUMNS = 4
# Columns of `marks`: kind of the event, number of the bound, row of the region that follows.
KIND, BOUND, NEXT_REGION = range(3)
MARK_COLUMNS = 3
# Columns of `grazes`.
GRAZE_T, GRAZE_T_LOW, GRAZE_BOUND, GRAZE_CLEARANCE, GRAZE_ERROR = range(5)
GRAZE_COLUMNS = 5

# Beyond this the squares in a bound would overflow.
HUGE = 1e150


class Run(NamedTuple):
    """All that `march` reads and writes: the law, the state, scratch, and the record.

    ``phases`` (n_harmonics, 2) are cos and sin of w_j t at the last event; ``arrival`` and
    ``walker`` of the same shape are scratch: the phases at the time last evaluated, and
    along the steps of the search (docs/decisions/014-tuples-of-arrays.md).
    """

    law: Law
    state: Floats
    counters: Integers
    phases: Floats
    arrival: Floats
    walker: Floats
    events: Floats
    marks: Integers
    grazes: Floats


class MotionRecord(NamedTuple):
    """What has happened in a run that began at x0: its law, events and marks."""

    law: Law
    x0: float
    events: Floats
    marks: Integers


@kernel
def place_of_event(record: MotionRecord, row: int) -> float:
    """Return where the mass is at an event."""
    marks = record.marks
    if marks[row, KIND] == START:
        return record.x0
    if marks[row, KIND] == KNOT:
        return record.events[row, KNOT_X]
    return place(record.law, int(marks[row, NEXT_REGION]), int(marks[row, BOUND]))


@kernel
def flight_after(record: MotionRecord, row: int, phases: Floats, arrival: Floats) -> Flight:
    """Return the flight, or contact, that begins with an event; ``phases`` receive those there."""
    law, events = record.law, record.events
    region = int(record.marks[row, NEXT_REGION])
    set_phases(law, events[row, EVENT_T], events[row, EVENT_T_LOW], phases)
    force = constant_force(law, region, place_of_event(record, row))
    if record.marks[row, KIND] == RELEASE:
        # The force is zero at a release (see `march.stay`).
        force = -force_and_slopes(law, phases)[0]
    start = (events[row, EVENT_T], events[row, EVENT_T_LOW], events[row, V_AFTER], force)
    return Flight(law, region, start, phases, arrival)


@kernel
def time_since_event(events: Floats, row: int) -> float:
    """Return the time from the event before that of a row."""
    before = row - 1
    return (events[row, EVENT_T] - events[before, EVENT_T]) + (
        events[row, EVENT_T_LOW] - events[before, EVENT_T_LOW]
    )


def new_run(law: Law, capacity: int, grazes: int = 16) -> Run:
    """Return the arrays of a run for at most so many events and grazes."""
    phases = np.zeros((3, int(law[0, N_HARMONICS]), 2))
    return Run(
        law,
        np.zeros(STATE_ENTRIES),
        np.zeros(COUNTERS, dtype=np.int64),
        phases[0],
        phases[1],
        phases[2],
        np.empty((capacity, EVENT_COLUMNS)),
        np.empty((capacity, MARK_COLUMNS), dtype=np.int64),
        np.empty((grazes, GRAZE_COLUMNS)),
    )
