"""The motion of a structure at any instants, from the record of its events."""

from __future__ import annotations

from percuss.arrays import Floats
from percuss.kernels.compile import kernel
from percuss.kernels.record import BOUND, CONTACT, EVENT_T, EVENT_T_LOW, KIND, NEXT_REGION
from percuss.kernels.sample import flight_at, tail_hop
from percuss.kernels.structure.basis import DRAG, SPRING, basis_of
from percuss.kernels.structure.flight import ModalFlight, U, W, arrive
from percuss.kernels.structure.run import (
    StructureRun,
    begin_flight,
    decompose,
    displace,
    load_at,
    restitution,
    speed_of,
)


@kernel
def flight_after(run: StructureRun, row: int) -> ModalFlight:
    """Return the flight that begins with an event of a record, of which the modes are changed."""
    for j in range(run.begin.shape[0]):
        run.begin[j, U] = run.states[row, j, U]
        run.begin[j, W] = run.states[row, j, W]
    instant = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
    load_at(run.sets, instant, run.phases, run.records)
    return flight_in(run, run.marks[row, NEXT_REGION])


@kernel
def flight_in(run: StructureRun, b: int) -> ModalFlight:
    """Return the flight of the run's modes and loads in a set."""
    return begin_flight(run, basis_of(run.sets, b), run.values, run.order)


@kernel
def tail_after(run: StructureRun, row: int) -> float:
    """Return how long the summed tail of a chatter lasts that begins with an event; 0 for none.

    A contact comes at the instant of another event, or at the end of a tail.
    """
    if row + 1 >= run.events.shape[0] or run.marks[row + 1, KIND] != CONTACT:
        return 0.0
    whole = run.events[row + 1, EVENT_T] - run.events[row, EVENT_T]
    return whole + (run.events[row + 1, EVENT_T_LOW] - run.events[row, EVENT_T_LOW])


@kernel
def held_after(run: StructureRun, row: int) -> ModalFlight:
    """Return the motion in the mean from the begin of a tail on: the wall holds the structure."""
    flight_after(run, row)
    place = run.scratch[6, : run.sets.offset.shape[1]]
    displace(run.sets, run.marks[row, NEXT_REGION], run.begin, place)
    b = run.marks[row + 1, NEXT_REGION]
    decompose(run.sets, b, place, run.begin)
    return flight_in(run, b)


@kernel
def evaluate(run: StructureRun, times: Floats, after: bool, place: Floats) -> None:
    """Write displacements and velocities, (n_times, n_x, 2), of a record at instants within it.

    At the very instant of an event they are those after it, or those before.
    """
    modes = run.scratch[0, : run.begin.shape[0]]
    for k in range(times.shape[0]):
        row = flight_at(run.events, times[k], after)
        flight = flight_after(run, row)
        s = (times[k] - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW]
        b = run.marks[row, NEXT_REGION]
        tail = tail_after(run, row)
        if tail > 0.0:
            stop = run.marks[row + 1, BOUND]
            speed = speed_of(flight.basis, stop, run.begin)
            ratio = restitution(run.sets, stop, speed)
            y, v = tail_hop(ratio, speed, tail, max(s, 0.0))
            arrive(held_after(run, row), max(s, 0.0), modes)
            displace(run.sets, run.marks[row + 1, NEXT_REGION], modes, place[k])
            hop_along(run, b, stop, y, v, place[k])
            continue
        arrive(flight, s, modes)
        displace(run.sets, b, modes, place[k])


@kernel
def hop_along(run: StructureRun, b: int, stop: int, y: float, v: float, place: Floats) -> None:
    """Add a hop off a wall, the change of its clearance and of that velocity, to a place (n_x, 2).

    The structure hops along the jump of its velocities at an impact.
    """
    sets = run.sets
    for i in range(place.shape[0]):
        along = 0.0
        for j in range(run.begin.shape[0]):
            u = sets.kick[b, stop, j, U]
            w = sets.kick[b, stop, j, W]
            bent = sets.modes[b, j, SPRING] * u + sets.modes[b, j, DRAG] * w
            along += sets.shape[b, j, 0, i] * w - sets.shape[b, j, 1, i] * bent
        place[i, 0] += along * y
        place[i, 1] += along * v
