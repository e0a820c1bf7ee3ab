"""One motion of many: from event to event as `march` goes, keeping tallies and points only.

Its events pass through a small buffer, and what is wanted of a stretch is taken before the next
(`survey`).
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.kernels.compile import kernel
from percuss.kernels.flight import Start, constant_force, set_phases
from percuss.kernels.law import (
    LOWER,
    LOWER_KIND,
    LOWER_RESTITUTION,
    NUMBER,
    PLAIN,
    UPPER,
    UPPER_RESTITUTION,
    WALL,
    Law,
    Table,
)
from percuss.kernels.march import arrive, begin, skip_ahead, stay
from percuss.kernels.record import (
    AT_REST,
    BOUND,
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    FORCE,
    FREE_ABOVE,
    FREE_BELOW,
    HUGE,
    IMPACT,
    KIND,
    MOVING,
    N_EVENTS,
    N_GRAZES,
    N_IMPACTS,
    NEXT_REGION,
    OVERFLOW,
    REACHED_END,
    REACHED_LIMIT,
    REGION,
    SPENT,
    T_LOW,
    TOUCHED,
    V_AFTER,
    V_BEFORE,
    Integers,
    T,
    V,
    X,
)
from percuss.kernels.search import next_event
from percuss.kernels.survey import (
    END_V,
    END_X,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    clear_tally,
    end_at,
    is_strobe_due,
    move_neighbour,
    strobe,
    strobe_neighbour,
    survey,
    tally_event,
)
from percuss.kernels.tangent import event_saltation

# A lane: its law, state, counters, plan, tally and points.
Lane: TypeAlias = tuple[Law, Table, Integers, Table, Table, Table]
# Room that lanes use in turn: events, marks and grazes, and (3, n_harmonics, 2) for phases.
Room: TypeAlias = tuple[Table, Integers, Table, Table]
# What is wanted of all lanes: the most impacts, the section, and whether they are surveyed.
Wish: TypeAlias = tuple[int, int, bool]


@kernel
def begin_lane(lane: Lane, room: Room, wish: Wish) -> None:
    """Begin at the t, x and v of the state."""
    law, state, counters, plan, tally, points = lane
    events, marks, _, phases = room
    clear_tally(tally)
    counters[N_EVENTS] = 0
    begin(law, state, counters, phases[0], events, marks)
    last = counters[N_EVENTS] - 1
    tally_event(law, counters[REGION], events, marks, last, plan[SINCE], wish[1], tally, points)


@kernel
def follow(lane: Lane, room: Room, wish: Wish, patience: int, until_plain: bool) -> int:
    """Go on from event to event as `march` does; return why it stopped.

    ``until_plain`` stops it, MOVING, where the next flight may be plain.
    """
    law, state, counters, _, _, _ = lane
    set_phases(law, state[T], state[T_LOW], room[3][0])
    status = MOVING
    while status == MOVING:
        if may_be_plain(lane):
            if until_plain:
                return MOVING
            made = skip(lane, room, wish)
            if counters[N_IMPACTS] >= wish[0]:
                return REACHED_LIMIT
            if made == room[0].shape[0] - 2:
                # The buffer was full, and the next flight may be plain.
                continue
        if patience == 0:
            return SPENT
        patience -= 1
        status = turn(lane, room, wish)
    return status


@kernel
def may_be_plain(lane: Lane) -> bool:
    """Tell whether a lane is about to leave the one wall there is with a velocity off it."""
    law, state, counters, _, _, _ = lane
    region = counters[REGION]
    if law[region, PLAIN] != 1.0 or counters[TOUCHED] != 0:
        return False
    below = law[region, LOWER_KIND] == WALL
    sign = 1.0 if below else -1.0
    free = state[FREE_BELOW] + state[FREE_ABOVE]
    return (
        free == 0.0 and state[X] == law[region, LOWER if below else UPPER] and sign * state[V] > 0.0
    )


@kernel
def skip(lane: Lane, room: Room, wish: Wish) -> int:
    """Make the impacts that are plain, as many as the buffer holds; return their number."""
    law, state, counters, plan, _, _ = lane
    counters[N_EVENTS] = 0
    x, start = flight_of(state)
    skip_ahead(law, state, counters, room[3][0], room[0], room[1], plan[UNTIL], wish[0])
    made = counters[N_EVENTS]
    if made > 0:
        held = counters[TOUCHED] != 0
        gather(lane, room, wish, counters[REGION], x, start, held, made)
    return made


@kernel
def turn(lane: Lane, room: Room, wish: Wish) -> int:
    """Go to the next event, whatever it is; return MOVING, or why there is none."""
    law, state, counters, plan, tally, _ = lane
    events, marks, grazes, phases = room
    counters[N_EVENTS] = 0
    counters[N_GRAZES] = 0
    x, start = flight_of(state)
    region = counters[REGION]
    held = counters[TOUCHED] != 0
    if held:
        status = stay(law, state, counters, phases[0], events, marks, plan[UNTIL])
    else:
        free = (state[FREE_BELOW], state[FREE_ABOVE])
        longest = (plan[UNTIL] - state[T]) - state[T_LOW]
        found = next_event(law, region, x, start, phases[0], phases[1], phases[2], free, longest)
        status = arrive(
            law, state, counters, phases[0], phases[1], events, marks, grazes, found, longest
        )
    if counters[N_EVENTS] > 0 or status in (REACHED_END, AT_REST):
        gather(lane, room, wish, region, x, start, held, counters[N_EVENTS])
    if status == REACHED_END and not (abs(tally[END_X]) < HUGE and abs(tally[END_V]) < HUGE):
        return OVERFLOW
    if counters[N_IMPACTS] >= wish[0] and status == MOVING:
        return REACHED_LIMIT
    return status


@kernel
def flight_of(state: Table) -> tuple[float, Start]:
    """Return from where, and how, a state flies on."""
    return state[X], (state[T], state[T_LOW], state[V], state[FORCE])


@kernel
def gather(
    lane: Lane, room: Room, wish: Wish, region: int, x: float, start: Start, held: bool, count: int
) -> None:
    """Take what is kept from the stretches that end with the events of the buffer, or at the end.

    Where there are several events, all but the first end a plain flight, or the tail of a
    chatter, from the wall where the state is now.
    """
    law, state, _, plan, tally, points = lane
    events, marks, _, _ = room
    for row in range(max(count, 1)):
        until = events[row, EVENT_T] if count > 0 else plan[UNTIL]
        if until >= plan[SINCE]:
            keep(lane, room, wish, region, x, start, held, (until, count == 0))
        if count == 0:
            arrival = room[3][1]
            set_phases(law, start[0], start[1], room[3][2])
            end_at(law, region, x, start, held, until, room[3][2], arrival, tally)
        else:
            if wish[1] == TANGENTS and (not held or marks[row, KIND] == CONTACT):
                pass_event(law, region, start, events, marks, row, room[3][2], tally)
            tally_event(law, region, events, marks, row, plan[SINCE], wish[1], tally, points)
            x = state[X]
            force = constant_force(law, region, x)
            start = (events[row, EVENT_T], events[row, EVENT_T_LOW], events[row, V_AFTER], force)
            held = marks[min(row + 1, count - 1), KIND] == CONTACT


@kernel
def keep(
    lane: Lane,
    room: Room,
    wish: Wish,
    region: int,
    x: float,
    start: Start,
    held: bool,
    end: tuple[float, bool],
) -> None:
    """Take strobes and extremes from a stretch; ``end`` is when, and whether it is the last."""
    law, _, _, plan, tally, points = lane
    _, section, surveyed = wish
    phases = room[3][2]
    arrival = room[3][1]
    # A strobe at the very instant of an event belongs to what follows.
    before = math.inf if end[1] else end[0]
    if section == STROBES and is_strobe_due(before, plan, tally):
        set_phases(law, start[0], start[1], phases)
        strobe(law, region, x, start, held, before, plan, phases, arrival, tally, points)
    if section == TANGENTS:
        strobe_neighbour(law, region, start, before, plan, tally, points)
    if surveyed and not held:
        set_phases(law, start[0], start[1], phases)
        span = (max(0.0, plan[SINCE] - start[0]), (end[0] - start[0]) - start[1])
        survey(law, region, x, start, span, phases, arrival, tally)


@kernel
def pass_event(
    law: Law,
    region: int,
    start: Start,
    events: Table,
    marks: Integers,
    row: int,
    phases: Table,
    tally: Table,
) -> None:
    """Take the neighbour along the flight to the event of a row, and over it."""
    t = events[row, EVENT_T]
    t_low = events[row, EVENT_T_LOW]
    kind = marks[row, KIND]
    event = (kind, marks[row, BOUND], region, marks[row, NEXT_REGION])
    jump = event_saltation(law, event, (t, t_low), events[row, V_BEFORE], phases)
    restitution = 1.0
    if kind == IMPACT:
        upper = marks[row, BOUND] > law[region, NUMBER]
        restitution = law[region, UPPER_RESTITUTION if upper else LOWER_RESTITUTION]
    if kind == CONTACT:
        restitution = 0.0
    s = (t - start[0]) + (t_low - start[1])
    move_neighbour(law, region, s, restitution, jump, tally)
