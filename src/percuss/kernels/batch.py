"""Many motions in one call, without Python between them.

Members whose flights are harmonic are loaded into the slots of SIMD blocks and go from impact to
impact in lockstep (`lockstep`). At any other event a member is followed alone, from event to event
as `march` does, until its flights are harmonic again; so are the last members when few slots are
in use.

A member depends on its own law, start and plan alone, and both ways give it the same bits, so the
results are the same whatever motions are batched together. Its events pass through a small buffer,
from which its observables and points are computed (`observables`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import logarithm
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import Flight, constant_force, set_phases
from percuss.kernels.harmonic_observables import (
    carry_by_harmonic_flight,
    flight_summit,
    is_carried,
    is_over_early,
    is_within,
    side_of_wall,
)
from percuss.kernels.law_columns import (
    HARMONIC,
    LOWER,
    LOWER_KIND,
    NUMBER,
    UPPER,
    WALL,
)
from percuss.kernels.linear_observables import AT_KNOT
from percuss.kernels.loads import observe_loads
from percuss.kernels.lockstep import (
    AREA,
    AT,
    AT_LOW,
    BEFORE,
    COUNTED_FROM,
    DONE,
    LANDED,
    LEFT,
    LOG_KEPT,
    MODE,
    MOTION,
    NEAR_V,
    NEAR_X,
    NEXT_AT,
    NEXT_AT_LOW,
    NEXT_SPEED,
    RESTITUTION,
    SEEN_V,
    SEEN_Y,
    SIGN,
    SLOTS,
    SPEED,
    STROBE,
    SUMMIT,
    WAS_X,
    fly_round,
    load_law,
    load_state,
    move_slot,
    store_state,
)
from percuss.kernels.lockstep_observables import (
    carry_neighbours,
    find_summits,
    see_neighbours,
    see_strobes,
)
from percuss.kernels.march import begin, flight_of, fly, skip_ahead, stay
from percuss.kernels.observables import (
    AHEAD_V,
    AHEAD_X,
    END_V,
    END_X,
    N_OBSERVABLES,
    PASSAGES,
    SEARCHED,
    SHRUNK,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    LoadSpace,
    Member,
    clear_observables,
    end_at,
    is_strobe_due,
    keep_within,
    move_neighbour,
    note_peak,
    note_place,
    observe_event,
    observe_extremes,
    observe_impact,
    observe_passages,
    observe_work,
    strobe,
    strobe_instant,
    strobe_neighbour,
    write_neighbour,
    write_point,
)
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

# Rows of the buffer of events, and of the one for grazes, which are only counted.
BUFFER = 130
GRAZES = 4
# Blocks of a call: their numbers fit the fastest memory.
BLOCKS = 4
# With no more motions than this a round takes longer than following each.
FEWEST = 3
# As int64 and not int, for which numba would compile a function anew.
ONE = np.int64(1)
# The status of a member that has not begun.
NEW = -1


class Batch(NamedTuple):
    """Many motions: their laws, stacked, and the number of each one's law; then a row for each.

    ``stops`` (n_laws, n_stops, columns) belong to the laws.
    """

    laws: Floats
    which: Integers
    states: Floats
    counters: Integers
    status: Integers
    plans: Floats
    values: Floats
    points: Floats
    stops: Floats


class Workspace(NamedTuple):
    """Arrays that members use in turn: buffers of a record, and (3, n_harmonics, 2) for phases."""

    events: Floats
    marks: Integers
    grazes: Floats
    phases: Floats
    loads: LoadSpace


class Options(NamedTuple):
    """Options of all members.

    ``section`` names the points that are kept (`observables`), ``with_extremes`` asks for the
    extremes, ``with_work`` for the work of the dashpots, ``with_loads`` for means over time,
    ``with_load_peaks`` for those of forces and accelerations beside them, and ``patience`` bounds the
    searches of each member before control returns.
    """

    max_impacts: int
    section: int
    with_extremes: bool
    with_work: bool
    with_loads: bool
    with_load_peaks: bool
    patience: int


class Blocks(NamedTuple):
    """The SIMD blocks of a call, zeros at first, and which member is in each of their slots."""

    numbers: Floats
    occupants: Integers


@formula
def member_of(batch: Batch, workspace: Workspace, i: int) -> Member:
    """Return one motion of a batch, with the arrays that it works in."""
    run = Run(
        batch.laws[batch.which[i]],
        batch.states[i],
        batch.counters[i],
        workspace.phases[0],
        workspace.phases[1],
        workspace.phases[2],
        workspace.events,
        workspace.marks,
        workspace.grazes,
    )
    stops = batch.stops[batch.which[i]]
    return Member(run, batch.plans[i], batch.values[i], batch.points[i], stops, workspace.loads)


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
    elif in_contact and run.state[T] >= plan[SINCE]:
        # A knot of a record in contact is no event: what came before it is observed here.
        knot = (run.state[T], run.state[T_LOW])
        if options.section == STROBES and is_strobe_due(member, knot[0]):
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
        if until >= plan[SINCE]:
            low = events[row, EVENT_T_LOW] if count > 0 else 0.0
            observe_stretch(member, options, past, x, in_contact, (until, low, count == 0))
            if options.with_loads:
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
    event = (kind, marks[row, BOUND], region, marks[row, NEXT_REGION])
    jump = event_saltation(law, event, (t, t_low), v, phases)
    restitution = 1.0
    if kind == IMPACT:
        restitution = kept_of_area(law, region, int(marks[row, BOUND]), abs(v))
    if kind == CONTACT:
        restitution = 0.0
    move_neighbour(law, region, s, restitution, jump, values)


@kernel
def run_batch(
    batch: Batch, workspace: Workspace, options: Options, blocks: Blocks, stop: Integers
) -> None:
    """Follow each member from its state to its limits, or until its patience is spent.

    A member whose status is NEW begins at the t, x and v of its state, one that is SPENT is
    resumed where it was; others are left alone. The call returns once another thread
    sets the only entry of ``stop`` to a value other than 0.
    """
    n = batch.which.shape[0]
    many = n > FEWEST
    taken = 0
    i = 0
    while (i < n or taken > 0) and stop[0] == 0:
        i, taken = fill_blocks(batch, workspace, options, blocks, stop, i, taken, many)
        many = taken > FEWEST
        k = 0
        while k * SLOTS < taken:
            if not many or fly_and_see(options, blocks.numbers[k]) > 0:
                taken = serve_block(batch, workspace, options, blocks, k, taken, many)
            k += 1


@formula
def fly_and_see(options: Options, block: Floats) -> int:
    """Make a round, and what it takes to observe its flights; return how many are to be served."""
    left = fly_round(block)
    if options.section == TANGENTS:
        left += carry_neighbours(block)
        if left > 0:
            see_neighbours(block)
    if left > 0 and options.section == STROBES:
        see_strobes(block)
    if left > 0 and options.with_extremes:
        find_summits(block)
    return left


@kernel
def fill_blocks(
    batch: Batch,
    workspace: Workspace,
    options: Options,
    blocks: Blocks,
    stop: Integers,
    i: int,
    taken: int,
    many: bool,
) -> tuple[int, int]:
    """Bring members from the i-th on to harmonic flights, until all slots are taken.

    Return who is next, and how many slots are taken. Where there are not ``many`` members they
    are followed to their ends.
    """
    status = batch.status
    while i < status.shape[0] and taken < blocks.occupants.shape[0] and stop[0] == 0:
        if status[i] == NEW or status[i] == SPENT:
            member = member_of(batch, workspace, i)
            if status[i] == NEW:
                begin_member(member, options)
            status[i] = follow(member, options, many)
            if status[i] == MOVING:
                load_slot(member, options, blocks.numbers[taken // SLOTS], taken % SLOTS)
                blocks.occupants[taken] = i
                taken += 1
        i += 1
    return i, taken


@kernel
def serve_block(
    batch: Batch,
    workspace: Workspace,
    options: Options,
    blocks: Blocks,
    k: int,
    taken: int,
    many: bool,
) -> int:
    """Finish a round for the members of a block; return how many slots are taken then."""
    status = batch.status
    block = blocks.numbers[k]
    slot = 0
    while slot < SLOTS and k * SLOTS + slot < taken:
        i = blocks.occupants[k * SLOTS + slot]
        landed = many and block[MODE * SLOTS + slot] == LANDED
        if landed and count_impact(member_of(batch, workspace, i), options, block, slot):
            block[DONE * SLOTS + slot] = 1.0
        if many and block[DONE * SLOTS + slot] == 1.0 and block[LEFT * SLOTS + slot] > 0.0:
            slot += 1
            continue
        status[i] = serve_slot(member_of(batch, workspace, i), options, block, slot, many)
        if status[i] == MOVING:
            slot += 1
            continue
        # The last slot that is taken fills the gap, and is served next.
        taken -= 1
        blocks.occupants[k * SLOTS + slot] = blocks.occupants[taken]
        move_slot(blocks.numbers[taken // SLOTS], taken % SLOTS, block, slot)
    return taken


@formula
def load_slot(member: Member, options: Options, block: Floats, slot: int) -> None:
    """Load a member that leaves its wall into a slot."""
    run, plan, values = member.run, member.plan, member.values
    law, region = run.law, run.counters[REGION]
    since = -math.inf if values.shape[0] > N_OBSERVABLES else plan[SINCE]
    load_law(block, slot, law, region, since, plan[UNTIL])
    block[LOG_KEPT * SLOTS + slot] = 2.0 * logarithm(block[RESTITUTION * SLOTS + slot])
    load_member(member, options, block, slot)


@formula
def load_member(member: Member, options: Options, block: Floats, slot: int) -> None:
    """Load the state of a member into its slot, with what is observed of it."""
    run = member.run
    load_state(block, slot, run.state, options.max_impacts - run.counters[N_IMPACTS])
    load_strobe(member, block, slot)
    load_neighbour(member.values, block, slot)


@formula
def load_strobe(member: Member, block: Floats, slot: int) -> None:
    """Load the instant of the next strobe into a slot."""
    instant = strobe_instant(member)
    block[STROBE * SLOTS + slot] = instant if instant <= member.plan[UNTIL] else math.inf


@formula
def load_neighbour(values: Floats, block: Floats, slot: int) -> None:
    """Load a neighbour into a slot."""
    block[NEAR_X * SLOTS + slot] = values[AHEAD_X]
    block[NEAR_V * SLOTS + slot] = values[AHEAD_V]
    block[AREA * SLOTS + slot] = values[SHRUNK]


@formula
def store_member(member: Member, options: Options, block: Floats, slot: int) -> None:
    """Store the state of a slot into its member, with what is observed of it."""
    store_state(block, slot, member.run.state)
    if options.section == TANGENTS:
        store_neighbour(block, slot, NEAR_X, member.values)


@formula
def store_neighbour(block: Floats, slot: int, first: int, values: Floats) -> None:
    """Store a neighbour, from one of three rows on."""
    values[AHEAD_X] = block[first * SLOTS + slot]
    values[AHEAD_V] = block[(first + 1) * SLOTS + slot]
    values[SHRUNK] = block[(first + 2) * SLOTS + slot]


@formula
def serve_slot(member: Member, options: Options, block: Floats, slot: int, many: bool) -> int:
    """Finish a round for a member; return MOVING where it keeps its slot."""
    run = member.run
    state, counters = run.state, run.counters
    counters[N_IMPACTS] = options.max_impacts - int(block[LEFT * SLOTS + slot])
    if not many:
        store_member(member, options, block, slot)
        return follow(member, options, many)
    if block[MODE * SLOTS + slot] == LANDED:
        if block[DONE * SLOTS + slot] == 0.0:
            observe_landing(member, options, block, slot)
        block[DONE * SLOTS + slot] = 1.0
        if counters[N_IMPACTS] < options.max_impacts:
            return MOVING
        store_member(member, options, block, slot)
        return REACHED_LIMIT
    store_member(member, options, block, slot)
    set_phases(run.law, state[T], state[T_LOW], run.phases)
    status = next_stretch(member, options)
    if status == MOVING:
        status = follow(member, options, many)
    if status == MOVING:
        load_member(member, options, block, slot)
    return status


@formula
def count_impact(member: Member, options: Options, block: Floats, slot: int) -> bool:
    """Count a harmonic flight and its impact; return False where more of it is kept."""
    plan, values = member.plan, member.values
    until = block[NEXT_AT * SLOTS + slot]
    if block[DONE * SLOTS + slot] == 1.0:
        return True
    if options.section == TANGENTS:
        keep_neighbour(member, block, slot)
    if until < block[COUNTED_FROM * SLOTS + slot]:
        return True
    if options.with_loads or options.section == PASSAGES:
        return False
    if options.with_work and block[(MOTION + 1) * SLOTS + slot] > 0.0:
        return False
    sign = block[SIGN * SLOTS + slot]
    if options.with_extremes and until >= plan[SINCE]:
        is_whole = block[AT * SLOTS + slot] >= plan[SINCE]
        top = block[SUMMIT * SLOTS + slot]
        if not (is_whole and notes_summit(member.run.state[X], sign, top, values)):
            return False
    if values.shape[0] > N_OBSERVABLES:
        note_peak(until, abs(block[BEFORE * SLOTS + slot]), values)
        if until < plan[SINCE]:
            return True
    if options.section == STROBES and block[STROBE * SLOTS + slot] < until:
        note_strobes(member, block, slot, until)
    if options.section == TANGENTS and block[STROBE * SLOTS + slot] < until:
        note_neighbour_strobes(member, block, slot, until)
    speeds = (sign * block[BEFORE * SLOTS + slot], sign * block[NEXT_SPEED * SLOTS + slot])
    instant = (until, block[NEXT_AT_LOW * SLOTS + slot])
    observe_impact(member, instant, speeds, 0.0 if sign > 0.0 else 1.0, options.section)
    return True


@formula
def note_strobes(member: Member, block: Floats, slot: int, until: float) -> None:
    """Write the points of the strobes on the flight that a round has made."""
    x = member.run.state[X]
    write_point(member, x + block[SEEN_Y * SLOTS + slot], block[SEEN_V * SLOTS + slot], -1.0)
    if is_strobe_due(member, until):
        flight = landed_flight(member.run, block, slot)
        set_phases(flight.law, flight.start[0], flight.start[1], flight.phases)
        strobe(member, flight, x, member.run.counters[TOUCHED] != 0, until)
    load_strobe(member, block, slot)


@formula
def note_neighbour_strobes(member: Member, block: Floats, slot: int, until: float) -> None:
    """Write the logarithms at the strobes on the flight that a round has made."""
    store_neighbour(block, slot, WAS_X, member.values)
    flight = landed_flight(member.run, block, slot)
    start = flight.start
    s = max((block[STROBE * SLOTS + slot] - start[0]) - start[1], 0.0)
    ahead = (block[SEEN_Y * SLOTS + slot], block[SEEN_V * SLOTS + slot])
    write_neighbour(member, flight.region, s, ahead)
    strobe_neighbour(member, flight.region, start, until)
    load_strobe(member, block, slot)


@formula
def keep_neighbour(member: Member, block: Floats, slot: int) -> None:
    """Keep the distance of a neighbour within the range of floats."""
    values = member.values
    if not is_within((block[NEAR_X * SLOTS + slot], block[NEAR_V * SLOTS + slot])):
        store_neighbour(block, slot, NEAR_X, values)
        keep_within(values)
        load_neighbour(values, block, slot)


@formula
def landed_flight(run: Run, block: Floats, slot: int) -> Flight:
    """Return the flight that a round has made, with phases of its own."""
    v = block[SIGN * SLOTS + slot] * block[SPEED * SLOTS + slot]
    start = (block[AT * SLOTS + slot], block[AT_LOW * SLOTS + slot], v, run.state[FORCE])
    return Flight(run.law, run.counters[REGION], start, run.walker, run.arrival)


@formula
def observe_landing(member: Member, options: Options, block: Floats, slot: int) -> None:
    """Observe the flight and the impact of a round."""
    run = member.run
    events, marks = run.events, run.marks
    sign = block[SIGN * SLOTS + slot]
    flight = landed_flight(run, block, slot)
    events[0, EVENT_T] = block[NEXT_AT * SLOTS + slot]
    events[0, EVENT_T_LOW] = block[NEXT_AT_LOW * SLOTS + slot]
    events[0, V_BEFORE] = sign * block[BEFORE * SLOTS + slot]
    events[0, V_AFTER] = sign * block[NEXT_SPEED * SLOTS + slot]
    marks[0, KIND] = IMPACT
    marks[0, BOUND] = int(run.law[flight.region, NUMBER]) + (0 if sign > 0.0 else 1)
    marks[0, NEXT_REGION] = flight.region
    in_contact = run.counters[TOUCHED] != 0
    if options.section == TANGENTS:
        store_neighbour(block, slot, WAS_X, member.values)
    observe_stretches(member, options, flight, run.state[X], in_contact, int(ONE))
    load_strobe(member, block, slot)
    load_neighbour(member.values, block, slot)
