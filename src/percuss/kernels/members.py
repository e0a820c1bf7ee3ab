"""One motion of many, followed alone from event to event, with its observables and points."""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import Flight, constant_force, set_phases
from percuss.kernels.harmonic_observables import (
    carry_by_harmonic_flight,
    flight_summit,
    is_carried,
    is_over_early,
    side_of_wall,
)
from percuss.kernels.law_columns import HARMONIC, LOWER, LOWER_KIND, UPPER, WALL
from percuss.kernels.linear_observables import AT_KNOT
from percuss.kernels.loads import SAME_INSTANT, observe_loads
from percuss.kernels.march import begin, flight_of, fly, skip_ahead, stay
from percuss.kernels.observables import (
    AHEAD_V,
    AHEAD_X,
    END_V,
    END_X,
    PASSAGES,
    SEARCHED,
    SHRUNK,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    Member,
    clear_observables,
    end_at,
    forget_neighbour,
    is_strobe_due,
    keep_within,
    move_neighbour,
    note_place,
    observe_event,
    observe_extremes,
    observe_passages,
    observe_work,
    set_neighbour,
    strobe,
    strobe_neighbour,
)
from percuss.kernels.record import (
    AT_REST,
    BOUND,
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    FREE_ABOVE,
    FREE_BELOW,
    HUGE,
    IMPACT,
    KIND,
    KNOT,
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
    Run,
    T,
    V,
    X,
)
from percuss.kernels.restitution import kept_of_area
from percuss.kernels.tangent import event_saltation


class Options(NamedTuple):
    """Options of all members.

    ``section`` names the points that are kept (`observables`), ``with_extremes`` asks for the
    extremes, ``with_work`` for the work of the dashpots, ``with_loads`` for means over time,
    ``with_load_peaks`` for those of forces and accelerations beside them, and ``patience`` bounds
    the searches of each member before control returns.
    """

    max_impacts: int
    section: int
    with_extremes: bool
    with_work: bool
    with_loads: bool
    with_load_peaks: bool
    patience: int


@kernel
def begin_member(member: Member, options: Options) -> None:
    """Begin at the t, x and v of the state."""
    run = member.run
    clear_observables(member.values)
    run.counters[N_EVENTS] = 0
    begin(run)
    observe_event(member, run.counters[REGION], run.counters[N_EVENTS] - 1, options.section)


@kernel
def follow(member: Member, options: Options, until_harmonic: bool) -> int:
    """Go on from event to event as `march` does; return why it stopped.

    ``until_harmonic`` stops it, MOVING, where the next flight may be harmonic.
    """
    run = member.run
    set_phases(run.law, run.state[T], run.state[T_LOW], run.phases)
    status = MOVING
    patience = options.patience
    while status == MOVING:
        if may_be_harmonic(run):
            hops = is_hop(run)
            if until_harmonic and not hops:
                return MOVING
            # A hop is no harmonic flight: it need not be tried.
            made = 0 if hops else skip(member, options)
            if run.counters[N_IMPACTS] >= options.max_impacts:
                return REACHED_LIMIT
            if made == run.events.shape[0] - 2:
                # The buffer was full, and the next flight may be harmonic.
                continue
        if patience == 0:
            return SPENT
        patience -= 1
        status = next_stretch(member, options)
    return status


@kernel
def may_be_harmonic(run: Run) -> bool:
    """Return whether a motion is about to leave its only wall, with a velocity off it."""
    law, state, counters = run.law, run.state, run.counters
    region = counters[REGION]
    if law[region, HARMONIC] != 1.0 or counters[TOUCHED] != 0:
        return False
    below = law[region, LOWER_KIND] == WALL
    sign = 1.0 if below else -1.0
    free = state[FREE_BELOW] + state[FREE_ABOVE]
    return (
        free == 0.0 and state[X] == law[region, LOWER if below else UPPER] and sign * state[V] > 0.0
    )


@kernel
def is_hop(run: Run) -> bool:
    """Return whether the flight from the only wall is over too soon for a harmonic one."""
    side = side_of_wall(run.law, run.counters[REGION], run.state[X])
    return is_over_early(flight_of(run, run.phases), side)


@kernel
def skip(member: Member, options: Options) -> int:
    """Make the impacts of harmonic flights, as many as the buffer holds; return their number."""
    run = member.run
    run.counters[N_EVENTS] = 0
    x, past = run.state[X], flight_of(run, run.walker)
    skip_ahead(run, member.plan[UNTIL], options.max_impacts)
    made = run.counters[N_EVENTS]
    if made > 0:
        observe_stretches(member, options, past, x, run.counters[TOUCHED] != 0, made)
    return made


@kernel
def next_stretch(member: Member, options: Options) -> int:
    """Go to the next event of any kind; return MOVING, or why there is none."""
    run, plan, values = member.run, member.plan, member.values
    counters = run.counters
    counters[N_EVENTS] = 0
    counters[N_GRAZES] = 0
    x, past = run.state[X], flight_of(run, run.walker)
    in_contact = counters[TOUCHED] != 0
    status = stay(run, plan[UNTIL]) if in_contact else fly(run, plan[UNTIL])
    if counters[N_EVENTS] > 0 or status in (REACHED_END, AT_REST):
        observe_stretches(member, options, past, x, in_contact, counters[N_EVENTS])
    elif in_contact and run.state[T] >= plan[SINCE] - SAME_INSTANT * abs(plan[SINCE]):
        # A knot of a record in contact is no event: what came before it is observed here.
        knot = (run.state[T], run.state[T_LOW])
        if options.section == STROBES and knot[0] >= plan[SINCE] and is_strobe_due(member, knot[0]):
            strobe(member, past, x, in_contact, knot[0])
        if options.with_loads and knot != (past.start[0], past.start[1]):
            observe_loads(member, past, x, in_contact, 0, (knot, True), options.with_load_peaks)
    if status == REACHED_END and not (abs(values[END_X]) < HUGE and abs(values[END_V]) < HUGE):
        return OVERFLOW
    if counters[N_IMPACTS] >= options.max_impacts and status == MOVING:
        return REACHED_LIMIT
    return status


@kernel
def observe_stretches(
    member: Member, options: Options, flight: Flight, x: float, in_contact: bool, count: int
) -> None:
    """Observe the stretches that end with the events of the buffer, or at the end of the motion.

    The first is a flight from x, or a contact. Where there are several events, all but the first
    end a harmonic flight, or the tail of a chatter, from the wall where the state is now.
    """
    run, plan = member.run, member.plan
    law, region, start, phases, arrival = flight
    events, marks = run.events, run.marks
    for row in range(max(count, 1)):
        past = Flight(law, region, start, phases, arrival)
        until = events[row, EVENT_T] if count > 0 else plan[UNTIL]
        if options.section == TANGENTS and in_contact and until > plan[SINCE]:
            forget_neighbour(member.values)
        low = events[row, EVENT_T_LOW] if count > 0 else 0.0
        if until >= plan[SINCE]:
            observe_stretch(member, options, past, x, in_contact, (until, low, count == 0))
        if options.with_loads and until >= plan[SINCE] - SAME_INSTANT * abs(plan[SINCE]):
            end = ((until, low), count == 0)
            observe_loads(member, past, x, in_contact, row, end, options.with_load_peaks)
        if count == 0:
            set_phases(law, start[0], start[1], phases)
            end_at(past, x, in_contact, until, member.values)
        else:
            if options.section == TANGENTS and (not in_contact or marks[row, KIND] == CONTACT):
                carry_neighbour(member, past, x, row)
            observe_event(member, region, row, options.section)
            member.values[SEARCHED + AT_KNOT] = 1.0 if marks[row, KIND] == KNOT else 0.0
            x = run.state[X]
            force = constant_force(law, region, x)
            start = (events[row, EVENT_T], events[row, EVENT_T_LOW], events[row, V_AFTER], force)
            in_contact = marks[min(row + 1, count - 1), KIND] == CONTACT


@formula
def observe_stretch(
    member: Member,
    options: Options,
    flight: Flight,
    x: float,
    in_contact: bool,
    end: tuple[float, float, bool],
) -> None:
    """Record strobes, extremes and work of a stretch.

    ``end`` is its end, as a pair, and whether it is the last.
    """
    law, region, start, phases, _ = flight
    since = member.plan[SINCE]
    # A strobe at the very instant of an event belongs to what follows.
    before = math.inf if end[2] else end[0]
    if options.section == STROBES and is_strobe_due(member, before):
        set_phases(law, start[0], start[1], phases)
        strobe(member, flight, x, in_contact, before)
    if options.section == TANGENTS:
        strobe_neighbour(member, region, start, before)
    if options.section == PASSAGES:
        set_phases(law, start[0], start[1], phases)
        observe_passages(member, flight, x, in_contact, end[0])
    if (options.with_extremes or options.with_work) and not in_contact:
        set_phases(law, start[0], start[1], phases)
        span = (max(0.0, since - start[0]), (end[0] - start[0]) - start[1])
        if options.with_extremes and not sees_summit(member, flight, x, end):
            observe_extremes(flight, x, span, member.values)
        if options.with_work:
            observe_work(flight, span, member.values)


@kernel
def sees_summit(member: Member, flight: Flight, x: float, end: tuple[float, float, bool]) -> bool:
    """Record the extremes of a flight from the only wall and back to it; return False for others."""
    law, region, start, _, _ = flight
    side = side_of_wall(law, region, x)
    if end[2] or not side * start[2] > 0.0 or start[0] < member.plan[SINCE]:
        return False
    top = flight_summit(flight, side, (end[0] - start[0]) + (end[1] - start[1]))
    return notes_summit(x, side, top, member.values)


@formula
def notes_summit(x: float, side: float, top: float, values: Floats) -> bool:
    """Record the extremes of a flight from a wall at x; return False where ``top`` is NaN."""
    if not top >= 0.0:
        return False
    note_place(x, values)
    note_place(x + side * top, values)
    return True


@formula
def carry_neighbour(member: Member, flight: Flight, x: float, row: int) -> None:
    """Carry the neighbour along a flight from x to the event of a row, and over it."""
    law, region, start, phases, _ = flight
    events, marks, values = member.run.events, member.run.marks, member.values
    t = events[row, EVENT_T]
    t_low = events[row, EVENT_T_LOW]
    v = events[row, V_BEFORE]
    kind = marks[row, KIND]
    s = (t - start[0]) + (t_low - start[1])
    from_wall = side_of_wall(law, region, x) * start[2] > 0.0
    if kind == IMPACT and from_wall and is_carried(law, region, s):
        ahead = (values[AHEAD_X], values[AHEAD_V])
        x1, v1, lost = carry_by_harmonic_flight(law, start, region, (t, t_low), v, ahead)
        values[AHEAD_X] = x1
        values[AHEAD_V] = v1
        values[SHRUNK] += lost
        keep_within(values)
        return
    is_early = t < member.plan[SINCE]
    if kind == CONTACT and is_early:
        # Before the time that is measured another neighbour is taken.
        set_neighbour(values)
        return
    event = (kind, marks[row, BOUND], region, marks[row, NEXT_REGION])
    jump = event_saltation(law, event, (t, t_low), v, phases)
    restitution = 1.0
    if kind == IMPACT:
        restitution = kept_of_area(law, region, int(marks[row, BOUND]), abs(v))
        restitution = 1.0 if is_early and restitution == 0.0 else restitution
    if kind == CONTACT:
        restitution = 0.0
    move_neighbour(law, region, s, restitution, jump, values)
