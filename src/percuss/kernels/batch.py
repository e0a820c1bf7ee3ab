"""Many motions in one call: lane after lane, without Python between them.

A lane is a motion that is one of many. What it keeps is its state, tallies and some points
(`survey`); its events pass through a small buffer that all lanes use in turn. A lane depends on
its own law, start and plan alone, so the bits are the same whatever lanes are called together.
"""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.flight import Start, constant_force, set_phases
from percuss.kernels.law import (
    LOWER_RESTITUTION,
    NUMBER,
    PLAIN,
    UPPER_RESTITUTION,
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
    IMPACT,
    KIND,
    MOVING,
    N_EVENTS,
    N_GRAZES,
    N_IMPACTS,
    NEXT_REGION,
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
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    clear_tally,
    end_at,
    move_neighbour,
    strobe,
    strobe_neighbour,
    survey,
    tally_event,
)
from percuss.kernels.tangent import event_saltation

# Rows of the buffer of events, and of the one for grazes, which are only counted.
BUFFER = 130
GRAZES = 4
# The status of a lane that has not begun.
NEW = -1


@kernel
def run_lanes(
    laws: Table,
    which: Integers,
    states: Table,
    counters: Integers,
    status: Integers,
    plans: Table,
    max_impacts: int,
    patience: int,
    section: int,
    surveyed: bool,
    tallies: Table,
    points: Table,
    events: Table,
    marks: Integers,
    grazes: Table,
    room: Table,
) -> None:
    """Follow each lane from its state to its limits, or until its patience is spent.

    ``laws`` are stacked, and ``which`` is the number of each lane's law. A lane whose status is
    NEW begins at the t, x and v of its state, one that is SPENT is taken up where it was; others
    are left alone. ``points`` is (n, m, 3), of which m is at least 1. ``room`` is
    (3, n_harmonics, 2).
    """
    for i in range(which.shape[0]):
        if status[i] != NEW and status[i] != SPENT:
            continue
        law = laws[which[i]]
        counters[i, N_EVENTS] = 0
        if status[i] == NEW:
            clear_tally(tallies[i])
            begin(law, states[i], counters[i], room[0], events, marks)
            tally_event(
                law,
                counters[i, REGION],
                events,
                marks,
                counters[i, N_EVENTS] - 1,
                plans[i, SINCE],
                section,
                tallies[i],
                points[i],
            )
        set_phases(law, states[i, T], states[i, T_LOW], room[0])
        status[i] = follow(
            law,
            states[i],
            counters[i],
            room[0],
            room[1],
            room[2],
            events,
            marks,
            grazes,
            plans[i],
            max_impacts,
            patience,
            section,
            surveyed,
            tallies[i],
            points[i],
        )


@kernel
def follow(
    law: Law,
    state: Table,
    counters: Integers,
    phases: Table,
    arrival: Table,
    walker: Table,
    events: Table,
    marks: Integers,
    grazes: Table,
    plan: Table,
    max_impacts: int,
    patience: int,
    section: int,
    surveyed: bool,
    tally: Table,
    points: Table,
) -> int:
    """Go on from event to event as `march` does; return why it stopped."""
    t_end = plan[UNTIL]
    status = MOVING
    plain = law[counters[REGION], PLAIN] == 1.0
    while status == MOVING:
        if patience == 0:
            return SPENT
        patience -= 1
        counters[N_EVENTS] = 0
        counters[N_GRAZES] = 0
        if plain and counters[TOUCHED] == 0 and state[FREE_BELOW] + state[FREE_ABOVE] == 0.0:
            x, start = flight_of(state)
            skip_ahead(law, state, counters, phases, events, marks, t_end, max_impacts)
            made = counters[N_EVENTS]
            if made > 0:
                gather(
                    law,
                    counters[REGION],
                    x,
                    start,
                    False,
                    state,
                    made,
                    events,
                    marks,
                    plan,
                    section,
                    surveyed,
                    walker,
                    arrival,
                    tally,
                    points,
                )
            if counters[N_IMPACTS] >= max_impacts:
                return REACHED_LIMIT
            if made == events.shape[0] - 2:
                # The buffer was full, and the next flight may be plain.
                continue
            counters[N_EVENTS] = 0
        x, start = flight_of(state)
        region = counters[REGION]
        held = counters[TOUCHED] != 0
        if held:
            status = stay(law, state, counters, phases, events, marks, t_end)
        else:
            free = (state[FREE_BELOW], state[FREE_ABOVE])
            longest = (t_end - state[T]) - state[T_LOW]
            found = next_event(law, region, x, start, phases, arrival, walker, free, longest)
            status = arrive(law, state, counters, phases, events, marks, grazes, found, longest)
        if counters[N_EVENTS] > 0 or status in (REACHED_END, AT_REST):
            gather(
                law,
                region,
                x,
                start,
                held,
                state,
                counters[N_EVENTS],
                events,
                marks,
                plan,
                section,
                surveyed,
                walker,
                arrival,
                tally,
                points,
            )
        if counters[N_IMPACTS] >= max_impacts and status == MOVING:
            return REACHED_LIMIT
    return status


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


@kernel
def flight_of(state: Table) -> tuple[float, Start]:
    """Return from where, and how, a state flies on."""
    return state[X], (state[T], state[T_LOW], state[V], state[FORCE])


@kernel
def gather(
    law: Law,
    region: int,
    x: float,
    start: Start,
    held: bool,
    state: Table,
    count: int,
    events: Table,
    marks: Integers,
    plan: Table,
    section: int,
    surveyed: bool,
    phases: Table,
    arrival: Table,
    tally: Table,
    points: Table,
) -> None:
    """Take what is kept from the stretches that end with the events of the buffer, or at the end.

    Where there are several events, all but the first end a plain flight, or the tail of a
    chatter, from the wall where the state is now. ``phases`` and ``arrival`` are scratch.
    """
    for row in range(max(count, 1)):
        until = events[row, EVENT_T] if count > 0 else plan[UNTIL]
        if until >= plan[SINCE]:
            set_phases(law, start[0], start[1], phases)
            if section == STROBES:
                # A strobe at the very instant of an event belongs to what follows.
                before = until if count > 0 else math.inf
                strobe(law, region, x, start, held, before, plan, phases, arrival, tally, points)
            if section == TANGENTS:
                before = until if count > 0 else math.inf
                strobe_neighbour(law, region, start, before, plan, tally, points)
            if surveyed and not held:
                span = (max(0.0, plan[SINCE] - start[0]), (until - start[0]) - start[1])
                survey(law, region, x, start, span, phases, arrival, tally)
        if count == 0:
            set_phases(law, start[0], start[1], phases)
            end_at(law, region, x, start, held, until, phases, arrival, tally)
        else:
            if section == TANGENTS and (not held or marks[row, KIND] == CONTACT):
                pass_event(law, region, start, events, marks, row, phases, tally)
            tally_event(law, region, events, marks, row, plan[SINCE], section, tally, points)
            x = state[X]
            force = constant_force(law, region, x)
            start = (events[row, EVENT_T], events[row, EVENT_T_LOW], events[row, V_AFTER], force)
            held = marks[min(row + 1, count - 1), KIND] == CONTACT
