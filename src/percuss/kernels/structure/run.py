"""The arrays that `march` of structures reads and writes, and the flight from their state."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import formula
from percuss.kernels.flight import set_phases
from percuss.kernels.pieces import next_knot, record_at
from percuss.kernels.record import (
    N_EVENTS,
    N_GRAZES,
    T_LOW,
    T,
)
from percuss.kernels.restitution import restitution_at
from percuss.kernels.structure.basis import (
    CONSTANT,
    DRAG,
    IS_WALL,
    OF_U,
    OF_W,
    SPRING,
    Basis,
    Sets,
    basis_of,
    wall_of,
)
from percuss.kernels.structure.flight import (
    ModalFlight,
    U,
    W,
    fed,
    set_pull,
)

# Of the counters: the index of the set; one that is wanted and not known yet, -1 for none.
SET, WANTED = 0, 5
COUNTERS = 6
# Of the state: besides T and T_LOW, the greatest impact speed so far.
FASTEST = 2
STATE_ENTRIES = 3
# Rows over the modes that a walk needs: modes before and after a step, and their rates.
WALK_ARRAYS = 9
# Another reason why `march` comes back: a set of acting stops is met for the first time.
NEW_SET = 8


class StructureRun(NamedTuple):
    """All that `march` reads and writes.

    ``begin`` (n, 2) are the modes after the last event, in the set of `counters`; ``order`` (s,)
    how many derivatives of each guard vanish there, or less the doubt of its value where that is
    kept (`chatter.near_walls`), and ``free`` (s,) up to when it is known to be positive. ``rows``
    (9, n) is scratch as ``scratch`` is. ``states`` holds the modes after each event.
    """

    sets: Sets
    state: Floats
    counters: Integers
    begin: Floats
    order: Floats
    free: Floats
    pull: Floats
    phases: Floats
    records: Floats
    values: Floats
    later: Floats
    arrival: Floats
    at: Floats
    scratch: Floats
    rows: Floats
    events: Floats
    marks: Integers
    states: Floats
    grazes: Floats


def new_run(sets: Sets, capacity: int, grazes: int = 16) -> StructureRun:
    """Return the arrays of a run for at most so many events and grazes."""
    n, m = sets.modes.shape[1], sets.turns.shape[2]
    s, r = sets.stops.shape[0], sets.records.shape[0]
    return StructureRun(
        sets,
        np.zeros(STATE_ENTRIES),
        np.zeros(COUNTERS, dtype=np.int64),
        np.zeros((n, 2)),
        np.zeros(s),
        np.zeros(s),
        np.zeros((4, n)),
        np.zeros((m, 2)),
        np.zeros((r, 2)),
        np.zeros(s),
        np.zeros((n, 2)),
        np.zeros((m, 2)),
        np.zeros(2),
        np.zeros((8, max(n, m, s, 1), 6)),
        np.zeros((WALK_ARRAYS, n)),
        np.empty((capacity, 4)),
        np.empty((capacity, 3), dtype=np.int64),
        np.empty((capacity, n, 2)),
        np.empty((grazes, 5)),
    )


@formula
def flight_of(run: StructureRun) -> ModalFlight:
    """Return the flight from the last event."""
    return flight_with(run, basis_of(run.sets, run.counters[SET]), run.values, run.order)


@formula
def flight_with(run: StructureRun, basis: Basis, values: Floats, order: Floats) -> ModalFlight:
    """Return a flight of the run's modes and loads, whose guards have these values and orders."""
    return ModalFlight(
        basis,
        run.begin,
        run.pull,
        run.phases,
        run.records,
        values,
        order,
        run.later,
        run.arrival,
        run.at,
    )


@formula
def begin_flight(run: StructureRun, basis: Basis, values: Floats, order: Floats) -> ModalFlight:
    """Return such a flight with its inputs filled in, of which nothing has been evaluated yet."""
    flight = flight_with(run, basis, values, order)
    flight.at[0] = -1.0
    set_pull(flight)
    return flight


@formula
def load_at(sets: Sets, instant: tuple[float, float], phases: Floats, records: Floats) -> None:
    """Write phases, and values and slopes of the records, at an instant."""
    if phases.shape[0] > 0:
        set_phases(sets.law[0], instant[0], instant[1], phases)
    for k in range(records.shape[0]):
        records[k, 0], records[k, 1] = record_at(sets.records[k], instant[0], instant[1])


@formula
def set_off(run: StructureRun) -> ModalFlight:
    """Begin a flight at the instant and with the modes of the state, all else from these."""
    for i in range(run.free.shape[0]):
        run.free[i] = 0.0
    return prepare(run)


@formula
def prepare(run: StructureRun) -> ModalFlight:
    """Return the flight of the state, whose guards are searched as far as they are."""
    load_at(run.sets, (run.state[T], run.state[T_LOW]), run.phases, run.records)
    basis = basis_of(run.sets, run.counters[SET])
    flight = begin_flight(run, basis, run.values, run.order)
    for i in range(run.values.shape[0]):
        if run.order[i] == 0.0:
            run.values[i] = value_of(flight, i)
        elif run.order[i] > 0.0:
            run.values[i] = 0.0
    return flight


@formula
def value_of(flight: ModalFlight, i: int) -> float:
    """Return the value of a guard at the start of a flight."""
    basis = flight.basis
    value = basis.levels[i, CONSTANT] + fed(basis, i, flight.phases, flight.records, 0.0, 0)
    for j in range(flight.begin.shape[0]):
        value += basis.guard[i, j, OF_U] * flight.begin[j, U]
        value += basis.guard[i, j, OF_W] * flight.begin[j, W]
    return value


@formula
def speed_of(basis: Basis, i: int, modes: Floats) -> float:
    """Return the velocity of a clearance: the loads do not enter it."""
    speed = 0.0
    for j in range(modes.shape[0]):
        u = modes[j, U]
        w = modes[j, W]
        p = basis.guard[i, j, OF_U]
        q = basis.guard[i, j, OF_W]
        speed += p * w - q * (basis.modes[j, SPRING] * u + basis.modes[j, DRAG] * w)
    return speed


@formula
def speed_size(basis: Basis, i: int, modes: Floats) -> float:
    """Return the sum of the magnitudes of the terms of the velocity of a clearance."""
    size = 0.0
    for j in range(modes.shape[0]):
        u = abs(basis.modes[j, SPRING] * modes[j, U])
        w = abs(modes[j, W])
        p = abs(basis.guard[i, j, OF_U])
        q = abs(basis.guard[i, j, OF_W])
        size += p * w + q * (u + abs(basis.modes[j, DRAG]) * w)
    return size


@formula
def displace(sets: Sets, b: int, modes: Floats, place: Floats) -> None:
    """Write displacements and velocities of the coordinates, (n_x, 2), from the modes of a set."""
    for i in range(place.shape[0]):
        x = sets.offset[b, i]
        v = 0.0
        for j in range(modes.shape[0]):
            u = modes[j, U]
            w = modes[j, W]
            p = sets.shape[b, j, 0, i]
            q = sets.shape[b, j, 1, i]
            x += p * u + q * w
            v += p * w - q * (sets.modes[b, j, SPRING] * u + sets.modes[b, j, DRAG] * w)
        place[i, 0] = x
        place[i, 1] = v


@formula
def decompose(sets: Sets, b: int, place: Floats, modes: Floats) -> None:
    """Write the modes of a set from displacements and velocities of the coordinates."""
    n = place.shape[0]
    for j in range(modes.shape[0]):
        for part in range(2):
            total = 0.0
            for i in range(n):
                total += sets.inverse[b, i, part, j] * (place[i, 0] - sets.offset[b, i])
                total += sets.inverse[b, n + i, part, j] * place[i, 1]
            modes[j, part] = total


@formula
def change_set(run: StructureRun, b: int) -> None:
    """Take the modes of the state over into another set; velocities that it forbids are lost.

    What `displace` and `decompose` do, sum by sum the same, in loops of one row each, which become
    vector instructions: with the square of the number of modes there is nothing else at an event.
    """
    a = run.counters[SET]
    if b == a:
        return
    sets = run.sets
    n = sets.offset.shape[1]
    x = run.rows[0]
    v = run.rows[1]
    for i in range(n):
        x[i] = sets.offset[a, i]
        v[i] = 0.0
    for j in range(n):
        u = run.begin[j, U]
        w = run.begin[j, W]
        bent = sets.modes[a, j, SPRING] * u + sets.modes[a, j, DRAG] * w
        p = sets.shape[a, j, 0]
        q = sets.shape[a, j, 1]
        for i in range(n):
            x[i] += p[i] * u + q[i] * w
        for i in range(n):
            v[i] += p[i] * w - q[i] * bent
    for part in range(2):
        total = run.rows[2]
        for j in range(n):
            total[j] = 0.0
        for i in range(n):
            of_x = sets.inverse[b, i, part]
            of_v = sets.inverse[b, n + i, part]
            away = x[i] - sets.offset[b, i]
            speed = v[i]
            for j in range(n):
                total[j] = total[j] + of_x[j] * away + of_v[j] * speed
        for j in range(n):
            run.begin[j, part] = total[j]
    run.counters[SET] = b


@formula
def is_full(run: StructureRun) -> bool:
    """Return whether the record may lack room for the next event, or for a graze.

    An event takes a row, a contact of each wall at most, and one more where a chatter ends.
    """
    rows = run.counters[N_EVENTS] + run.order.shape[0] + 2
    return rows > run.events.shape[0] or run.counters[N_GRAZES] + 1 > run.grazes.shape[0]


@formula
def next_of_all(sets: Sets, t: float, t_low: float) -> tuple[float, float]:
    """Return the instant of the first knot of any record after an instant."""
    best = (math.inf, 0.0)
    for k in range(sets.records.shape[0]):
        knot = next_knot(sets.records[k], t, t_low)
        if (knot[0] - best[0]) + (knot[1] - best[1]) < 0.0 or best[0] == math.inf:
            best = knot
    return best


@formula
def clear_orders(run: StructureRun) -> None:
    """Forget which guards were at zero."""
    for i in range(run.order.shape[0]):
        run.order[i] = 0.0


@formula
def restitution(sets: Sets, i: int, speed: float) -> float:
    """Return the coefficient of restitution of a wall at a speed."""
    region, bound = wall_of(sets, i)
    return restitution_at(sets.walls[i], region, bound, speed)


@formula
def walls_of(sets: Sets) -> int:
    """Return the bits of all walls."""
    bits = 0
    for i in range(sets.stops.shape[0]):
        if sets.stops[i, IS_WALL] == 1.0:
            bits |= 1 << i
    return bits
