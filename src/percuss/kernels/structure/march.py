"""The motion of a structure from event to event: impacts, contacts, releases, chatter, edges.

Impacts at one instant come one after another, the stop of the lowest index first, until no wall is
approached; which walls hold the structure then is decided by the signs of their forces.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import ULP, later
from percuss.kernels.compile import cold, formula, kernel
from percuss.kernels.contact import SLOW
from percuss.kernels.event_location import GRAZE, NONE
from percuss.kernels.next_event import PAUSE
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    FULL,
    GRAZE_BOUND,
    GRAZE_CLEARANCE,
    GRAZE_ERROR,
    GRAZE_T,
    GRAZE_T_LOW,
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
    RELEASE,
    SLOW_LANDING,
    SPENT,
    START,
    T_LOW,
    V_AFTER,
    V_BEFORE,
    T,
)
from percuss.kernels.structure.basis import (
    CONSTANT,
    IS_ON,
    IS_WALL,
    OF_U,
    OF_W,
    Basis,
    basis_of,
    find,
)
from percuss.kernels.structure.chatter import HOPS, chatter_time, keep_near_walls, take_near_walls
from percuss.kernels.structure.flight import (
    ModalFlight,
    U,
    W,
    arrive,
    derivatives,
    fed,
    move,
    uncertainty,
)
from percuss.kernels.structure.next_event import GuardEvent, next_event
from percuss.kernels.structure.run import (
    FASTEST,
    NEW_SET,
    SET,
    WANTED,
    StructureRun,
    change_set,
    clear_orders,
    decompose,
    displace,
    flight_of,
    is_full,
    load_at,
    next_of_all,
    prepare,
    restitution,
    set_off,
    speed_of,
    speed_size,
    walls_of,
)

# Column of the scratch that keeps up to when guards were known to be positive before a search.
SEARCHED = 4
# A speed below this part of the fastest impact is none: two chatters at once end there.
NO_SPEED = 1e-13
# A velocity at the start below this part of its terms is rounding of the modes.
STILL = 16.0 * ULP
# Impacts at one instant, after which what is left of the speeds counts as none.
MOST_AT_ONCE = 1000


@kernel
def march(run: StructureRun, t_end: float, max_impacts: int, patience: int) -> int:
    """Go on from event to event; return why this came to an end."""
    state, counters = run.state, run.counters
    if counters[N_EVENTS] == 0:
        if is_full(run):
            return FULL
        status = begin(run)
        if status != MOVING:
            return status
    flight = prepare(run)
    for _ in range(patience):
        if is_full(run):
            return FULL
        if counters[N_IMPACTS] >= max_impacts:
            return REACHED_LIMIT
        longest = (t_end - state[T]) - state[T_LOW]
        knot = next_of_all(run.sets, state[T], state[T_LOW])
        to_knot = (knot[0] - state[T]) + (knot[1] - state[T_LOW])
        for i in range(run.free.shape[0]):
            run.scratch[7, i, SEARCHED] = run.free[i]
        event = next_event(flight, run.scratch, run.rows, run.free, min(longest, to_knot))
        if event.verdict == PAUSE:
            return SPENT
        if event.verdict == NONE or event.s > longest:
            if not to_knot < longest:
                return REACHED_END
            pass_knot(run, to_knot, knot[0], knot[1])
        elif event.verdict == GRAZE:
            t, t_low = later(state[T], state[T_LOW], event.s)
            note_graze(run, (t, t_low), event.guard, event.value, event.rest)
            continue
        elif not abs(event.value) < HUGE:
            return OVERFLOW
        else:
            status = carry_out(run, flight, event)
            if status != MOVING:
                # The search is repeated as it was: no bit depends on which sets are known, or on
                # how many rows there are.
                for i in range(run.free.shape[0]):
                    run.free[i] = run.scratch[7, i, SEARCHED]
                return status
        flight = set_off(run)
    return SPENT


@kernel
def begin(run: StructureRun) -> int:
    """Record the START, from the modes of the set that acts there.

    A wall that is touched is struck, or holds the structure; an edge is passed as it is met.
    """
    flight = set_off(run)
    for i in range(run.values.shape[0]):
        if flight.basis.levels[i, IS_ON] == 1.0:
            doubt = uncertainty(flight, i, 0.0) + ULP * abs(flight.basis.levels[i, CONSTANT])
            speed = speed_of(flight.basis, i, run.begin)
            # At rest on a wall its force decides; with a velocity into it, there is an impact. One
            # within its own rounding is none: an impulse so small would change nothing.
            if abs(run.values[i]) <= doubt:
                still = abs(speed) <= STILL * speed_size(flight.basis, i, run.begin)
                run.order[i] = 2.0 if still else 1.0
    note(run, START, -1, 0.0, 0.0)
    if is_at_rest(run):
        status = hold(run, 0)
        if status == NEW_SET:
            run.counters[N_EVENTS] = 0
            clear_orders(run)
            return NEW_SET
        keep(run, 0)
    return MOVING


@cold
def pass_knot(run: StructureRun, s: float, t: float, t_low: float) -> None:
    """Go to a knot of a record, a time s after the last event."""
    arrive(flight_of(run), s, run.begin)
    run.state[T] = t
    run.state[T_LOW] = t_low
    clear_orders(run)
    note(run, KNOT, -1, 0.0, 0.0)


@formula
def carry_out(run: StructureRun, flight: ModalFlight, event: GuardEvent) -> int:
    """Carry out a HIT: MOVING; or NEW_SET or FULL, where nothing has changed.

    NEW_SET: a set is needed that is not known yet; FULL: the record has no room for all events of
    the instant.
    """
    state, counters, sets = run.state, run.counters, run.sets
    _, s, i, speed, s_low = event
    bit = 1 << i
    key = sets.keys[counters[SET]]
    is_impact = sets.stops[i, IS_WALL] == 1.0 and key & bit == 0
    # What holds the structure lets go for the instant of an impact.
    wanted = key & ~walls_of(sets) if is_impact else key ^ bit
    b = find(sets, wanted)
    if b < 0:
        counters[WANTED] = wanted
        return NEW_SET
    before = (state[T], state[T_LOW], state[FASTEST])
    old_set = counters[SET]
    impacts = counters[N_IMPACTS]
    rows = counters[N_EVENTS]
    is_at_rest_there = s == 0.0 and run.order[i] >= 2.0
    kept = run.scratch[7]
    order = 0.0
    slow = 0.0
    if not is_impact:
        order = order_of_edge(run, flight, i, s)
    else:
        for j in range(run.begin.shape[0]):
            kept[j, 0] = run.begin[j, U]
            kept[j, 1] = run.begin[j, W]
        for k in range(run.order.shape[0]):
            kept[k, 2] = run.order[k]
            kept[k, 3] = run.values[k]
        if -speed <= HOPS * state[FASTEST]:
            keep_near_walls(run, flight, i, s)
        if not speed * speed > run.at[1]:
            slow = rounding_speed(run, i, s)
    step_to(run, flight, s, s_low)
    change_set(run, b)
    clear_orders(run)
    if not is_impact:
        run.order[i] = order
        pass_edge(run, i, speed, is_at_rest_there)
        return MOVING
    status = strike(run, b, i, speed, slow, key & walls_of(sets))
    if status != MOVING:
        # Taken up again from the flight before, once the set is known or there is room.
        state[T], state[T_LOW], state[FASTEST] = before
        counters[SET] = old_set
        counters[N_IMPACTS] = impacts
        counters[N_EVENTS] = rows
        for j in range(run.begin.shape[0]):
            run.begin[j, U] = kept[j, 0]
            run.begin[j, W] = kept[j, 1]
        for k in range(run.order.shape[0]):
            run.order[k] = kept[k, 2]
            run.values[k] = kept[k, 3]
    return status


@cold
def rounding_speed(run: StructureRun, i: int, s: float) -> float:
    """Return the speed at a wall, a time s after the last event, that rounding alone can make."""
    flight = flight_of(run)
    move(flight, s)
    second = derivatives(flight, i, s, False)[2]
    return math.sqrt(2.0 * uncertainty(flight, i, s) * abs(second))


@formula
def order_of_edge(run: StructureRun, flight: ModalFlight, i: int, s: float) -> float:
    """Return the order of a guard's zero after the crossing of an edge, or the release of a wall.

    Where the force of a wall falls to zero the structure leaves it with no acceleration; where a
    jump of the forces has reversed it, at the begin of the flight, with one.
    """
    order = 1.0
    if run.sets.stops[i, IS_WALL] == 1.0:
        is_forced_off = s == 0.0 and run.values[i] < -uncertainty(flight, i, 0.0)
        order = 2.0 if is_forced_off else 3.0
    return max(order, run.order[i]) if s == 0.0 else order


@formula
def pass_edge(run: StructureRun, i: int, speed: float, is_at_rest_there: bool) -> None:
    """Record the crossing of the edge of a soft stop, or the release from a wall."""
    counters = run.counters
    if counters[N_EVENTS] == 1 and is_at_rest_there:
        # From rest at an edge the motion begins within the stop: nothing is crossed.
        keep(run, 0)
    elif run.sets.stops[i, IS_WALL] == 1.0:
        note(run, RELEASE, i, 0.0, 0.0)
    else:
        side = 1.0 if run.sets.keys[counters[SET]] & (1 << i) == 0 else -1.0
        counters[N_IMPACTS] += 1 if side < 0.0 else 0
        note(run, CROSSING, i, speed, side)


@formula
def step_to(run: StructureRun, flight: ModalFlight, s: float, s_low: float) -> None:
    """Move the state a time s + s_low on, with the modes there as far as doubles tell."""
    arrive(flight, s, run.begin)
    t, t_low = later(run.state[T], run.state[T_LOW], s)
    run.state[T], run.state[T_LOW] = later(t, t_low, s_low)


@formula
def strike(run: StructureRun, b: int, first: int, speed: float, slow: float, held: int) -> int:
    """Carry out the impacts of an instant, the first that of a wall at a given speed (negative).

    A speed below ``slow`` is lost in the rounding of the clearance: the structure is at rest there.
    ``held`` are the bits of the walls that held it before.
    """
    sets, state, counters = run.sets, run.state, run.counters
    is_hop = -speed <= HOPS * state[FASTEST]
    run.order[first] = 1.0
    for k in range(run.order.shape[0]):
        if held & (1 << k):
            run.order[k] = 2.0
    i = first
    if -speed <= slow:
        kick(run, b, first, -speed)
        run.order[first] = 2.0
        counters[N_IMPACTS] += 1
        note(run, SLOW_LANDING, first, speed, 0.0)
    else:
        v = speed
        for _ in range(MOST_AT_ONCE):
            if is_full(run):
                return FULL
            state[FASTEST] = max(state[FASTEST], -v)
            rebound = -restitution(sets, i, -v) * v
            if rebound <= NO_SPEED * state[FASTEST]:
                rebound = 0.0
            kick(run, b, i, rebound - v)
            # What rounding leaves of it is of one sign: over many impacts it would add up.
            kick(run, b, i, rebound - speed_of(basis_of(sets, b), i, run.begin))
            counters[N_IMPACTS] += 1
            run.order[i] = 1.0 if rebound > 0.0 else 2.0
            note(run, IMPACT, i, v, rebound)
            v = 0.0
            # The next wall that is approached: only those that are touched can be.
            for k in range(run.order.shape[0]):
                if run.order[k] > 0.0 and v == 0.0 and k != i:
                    approach = speed_of(basis_of(sets, b), k, run.begin)
                    if approach < -NO_SPEED * state[FASTEST]:
                        v = approach
                        i = k
                    elif approach > NO_SPEED * state[FASTEST]:
                        run.order[k] = 1.0
            if v == 0.0:
                break
    last = counters[N_EVENTS] - 1
    if is_at_rest(run):
        status = hold(run, held)
        if status == NEW_SET:
            return NEW_SET
        keep(run, last)
    if is_hop:
        take_near_walls(run)
    if run.order[i] == 1.0 and run.events[last, V_AFTER] <= SLOW * state[FASTEST]:
        return end_chatter(run, i, run.events[last, V_AFTER])
    return MOVING


@cold
def end_chatter(run: StructureRun, i: int, speed: float) -> int:
    """Go to the end of a chatter, if this impact of a wall is in the tail of one."""
    sets, state, counters = run.sets, run.state, run.counters
    time, error = chatter_time(run, set_off(run), i, speed)
    if not time > 0.0:
        return MOVING
    b = find(sets, sets.keys[counters[SET]] | (1 << i))
    if b < 0:
        counters[WANTED] = sets.keys[counters[SET]] | (1 << i)
        return NEW_SET
    # In the mean the wall holds the structure from here on; the hops are far below rounding.
    change_set(run, b)
    clear_orders(run)
    arrive(set_off(run), time, run.begin)
    state[T], state[T_LOW] = later(state[T], state[T_LOW], time)
    note(run, CONTACT, i, error, 0.0)
    return MOVING


@formula
def is_at_rest(run: StructureRun) -> bool:
    """Return whether the structure touches a wall at rest."""
    for k in range(run.order.shape[0]):
        if run.order[k] == 2.0 and run.sets.stops[k, IS_WALL] == 1.0:
            return True
    return False


@formula
def kick(run: StructureRun, b: int, i: int, change: float) -> None:
    """Change the velocity of a clearance by an impulse of its wall."""
    for j in range(run.begin.shape[0]):
        run.begin[j, U] += run.sets.kick[b, i, j, 0] * change
        run.begin[j, W] += run.sets.kick[b, i, j, 1] * change


@kernel
def hold(run: StructureRun, held: int) -> int:
    """Find the walls that hold the structure, of those that it touches at rest (order 2).

    All are tried; that with the largest force away from the structure is left, until none pulls.
    A contact begins at those that have not held it before; ``held`` are the bits of these.
    """
    sets, counters = run.sets, run.counters
    key = sets.keys[counters[SET]] & ~walls_of(sets)
    for k in range(run.order.shape[0]):
        if run.order[k] == 2.0 and sets.stops[k, IS_WALL] == 1.0:
            key |= 1 << k
    place = run.scratch[6, : sets.offset.shape[1]]
    trial = run.scratch[0, : run.begin.shape[0]]
    displace(sets, counters[SET], run.begin, place)
    for _ in range(run.order.shape[0] + 1):
        b = find(sets, key)
        if b < 0:
            counters[WANTED] = key
            return NEW_SET
        decompose(sets, b, place, trial)
        if key & walls_of(sets) == 0:
            break
        load_at(sets, (run.state[T], run.state[T_LOW]), run.phases, run.records)
        basis = basis_of(sets, b)
        least = 0.0
        which = -1
        for k in range(run.order.shape[0]):
            if key & (1 << k) and sets.stops[k, IS_WALL] == 1.0:
                force = force_of(basis, k, trial, run.phases, run.records)
                if force < least:
                    least = force
                    which = k
        if which < 0:
            break
        key &= ~(1 << which)
    for j in range(run.begin.shape[0]):
        run.begin[j, U] = trial[j, U]
        run.begin[j, W] = trial[j, W]
    counters[SET] = find(sets, key)
    for k in range(run.order.shape[0]):
        if run.order[k] == 2.0 and key & (1 << k):
            run.order[k] = 0.0
            if not held & (1 << k):
                note(run, CONTACT, k, 0.0, 0.0)
    return MOVING


@kernel
def force_of(basis: Basis, i: int, modes: Floats, phases: Floats, records: Floats) -> float:
    """Return the force by which a wall holds, 0 where that is within its rounding."""
    value = basis.levels[i, CONSTANT] + fed(basis, i, phases, records, 0.0, 0)
    size = abs(basis.levels[i, CONSTANT]) + abs(value)
    for j in range(modes.shape[0]):
        p = basis.guard[i, j, OF_U] * modes[j, U]
        q = basis.guard[i, j, OF_W] * modes[j, W]
        value += p + q
        size += abs(p) + abs(q)
    return 0.0 if abs(value) <= 64.0 * ULP * size else value


@formula
def note(run: StructureRun, kind: np.int64, stop: int, v_before: float, v_after: float) -> None:
    """Write the event at the state's instant into the record, with the modes after it."""
    state, counters = run.state, run.counters
    row = counters[N_EVENTS]
    run.events[row, EVENT_T] = state[T]
    run.events[row, EVENT_T_LOW] = state[T_LOW]
    run.events[row, V_BEFORE] = v_before
    run.events[row, V_AFTER] = v_after
    run.marks[row, KIND] = kind
    run.marks[row, BOUND] = stop
    counters[N_EVENTS] = row + 1
    keep(run, row)


@formula
def keep(run: StructureRun, first: int) -> None:
    """Write set and modes of the state into the rows from one on: they are of one instant."""
    for row in range(first, run.counters[N_EVENTS]):
        run.marks[row, NEXT_REGION] = run.counters[SET]
        for j in range(run.begin.shape[0]):
            run.states[row, j, U] = run.begin[j, U]
            run.states[row, j, W] = run.begin[j, W]


@kernel
def note_graze(
    run: StructureRun, instant: tuple[float, float], stop: int, value: float, error: float
) -> None:
    """Write a graze into the record."""
    row = run.counters[N_GRAZES]
    run.grazes[row, GRAZE_T] = instant[0]
    run.grazes[row, GRAZE_T_LOW] = instant[1]
    run.grazes[row, GRAZE_BOUND] = stop
    run.grazes[row, GRAZE_CLEARANCE] = value
    run.grazes[row, GRAZE_ERROR] = error
    run.counters[N_GRAZES] = row + 1
