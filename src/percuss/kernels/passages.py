"""The passages of a level by a motion: each flight is searched with the proof that holds for stops."""

from __future__ import annotations

from percuss.arrays import Floats
from percuss.kernels.arithmetic import later
from percuss.kernels.compile import kernel
from percuss.kernels.flight import Flight
from percuss.kernels.law_columns import LOWER, UPPER
from percuss.kernels.linear_observables import (
    AT_KNOT,
    LEVEL,
    ROW,
    SIDE,
    SINCE,
    SINCE_LOW,
    Scratch,
    begin_search,
    next_zero,
    state_at,
)
from percuss.kernels.record import (
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    KIND,
    KNOT,
    MotionRecord,
    flight_after,
    place_of_event,
    time_since_event,
)

# Columns of the crossings of a level.
CROSSING_T, CROSSING_V = range(2)


@kernel
def heading_side(clearance: float, v: float) -> float:
    """Return the side of a level on which a motion is, or goes to from the level itself."""
    if clearance == 0.0:
        return 1.0 if v > 0.0 else -1.0
    return 1.0 if clearance > 0.0 else -1.0


@kernel
def next_passage(
    flight: Flight,
    shift: float,
    in_contact: bool,
    until: float,
    progress: Floats,
    scratch: Scratch,
) -> tuple[bool, float, float]:
    """Return whether a stretch passes a level once more up to ``until``, and (t, v) there.

    ``shift`` is where the stretch begins minus the level, and ``progress`` how far it is known. At
    the edge of a stop the passage is the event itself, at which the stretch begins; a start on the
    level is none, nor is a touch.
    """
    law, region, start, _, _ = flight
    lower, upper = law[region, LOWER], law[region, UPPER]
    level = progress[LEVEL]
    if not lower < level < upper:
        # On the other side of an edge that is the level, or far from it.
        side = 1.0 if level <= lower else -1.0
        passed = progress[SIDE] * side < 0.0
        progress[SIDE] = side
        return passed, start[0], start[2]
    s = (progress[SINCE], progress[SINCE_LOW])
    if in_contact or not s[0] < until:
        return False, 0.0, 0.0
    if progress[AT_KNOT] == 1.0 and s[0] == 0.0:
        # A passage that rounding puts between the two flights that a knot parts.
        side = heading_side(shift, start[2])
        if progress[SIDE] * side < 0.0:
            progress[SIDE] = side
            return True, start[0], start[2]
    at_zero = s[0] > 0.0 or shift == 0.0
    s, side = next_zero(flight, law, shift, (1.0, 0.0, 0.0, 0.0), (s, until, at_zero), scratch)
    progress[SIDE] = side
    progress[SINCE], progress[SINCE_LOW] = s
    if not s[0] < until:
        return False, 0.0, 0.0
    progress[SIDE] = -side
    _, v, _, _, _, _ = state_at(flight, s)
    t, _ = later(start[0], start[1] + s[1], s[0])
    return True, t, v


@kernel
def crossings_of_level(
    record: MotionRecord,
    level: float,
    end: float,
    progress: Floats,
    found: Floats,
    scratch: Scratch,
) -> int:
    """Write (t, v) of the passages of a level into ``found`` (n, 2); return how many.

    ``progress`` holds the row, the time since its event and the side of the level on which the
    motion is, zeros at first. When ``found`` is full the call returns, and the next one goes on.
    """
    events, marks = record.events, record.marks
    progress[LEVEL] = level
    count = 0
    while int(progress[ROW]) < events.shape[0]:
        row = int(progress[ROW])
        x = place_of_event(record, row)
        until = end - events[row, EVENT_T] - events[row, EVENT_T_LOW]
        if row + 1 < events.shape[0]:
            until = time_since_event(events, row + 1)
        flight = flight_after(record, row, scratch.phases, scratch.arrival)
        in_contact = marks[row, KIND] == CONTACT
        progress[AT_KNOT] = 1.0 if marks[row, KIND] == KNOT else 0.0
        passes = True
        while passes:
            if count == found.shape[0]:
                return count
            passes, t, v = next_passage(flight, x - level, in_contact, until, progress, scratch)
            if passes:
                found[count, CROSSING_T] = t
                found[count, CROSSING_V] = v
                count += 1
        progress[ROW] = row + 1.0
        begin_search(progress)
    return count
