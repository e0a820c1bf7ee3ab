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
from percuss.kernels.flight import Flight, set_phases
from percuss.kernels.harmonic_observables import is_within
from percuss.kernels.law_columns import NUMBER
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
from percuss.kernels.members import (
    Options,
    begin_member,
    follow,
    next_stretch,
    notes_summit,
    observe_stretches,
)
from percuss.kernels.observables import (
    AHEAD_V,
    AHEAD_X,
    N_OBSERVABLES,
    PASSAGES,
    SHRUNK,
    SINCE,
    STROBES,
    TANGENTS,
    UNTIL,
    LoadSpace,
    Member,
    is_strobe_due,
    keep_within,
    note_peak,
    observe_impact,
    strobe,
    strobe_instant,
    strobe_neighbour,
    write_neighbour,
    write_point,
)
from percuss.kernels.record import (
    BOUND,
    EVENT_T,
    EVENT_T_LOW,
    FORCE,
    IMPACT,
    KIND,
    MOVING,
    N_IMPACTS,
    NEXT_REGION,
    REACHED_LIMIT,
    REGION,
    SPENT,
    T_LOW,
    TOUCHED,
    V_AFTER,
    V_BEFORE,
    Run,
    T,
    X,
)

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
