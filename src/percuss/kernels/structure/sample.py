"""The motion of a structure at any instants, from the record of its events."""

from __future__ import annotations

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import kernel
from percuss.kernels.record import EVENT_T, EVENT_T_LOW, NEXT_REGION
from percuss.kernels.sample import flight_at
from percuss.kernels.structure.basis import basis_of
from percuss.kernels.structure.flight import ModalFlight, U, W, arrive, set_pull
from percuss.kernels.structure.march import StructureRun, displace, load_at


@kernel
def flight_after(run: StructureRun, row: int) -> ModalFlight:
    """Return the flight that begins with an event of a record, of which the modes are changed."""
    for j in range(run.begin.shape[0]):
        run.begin[j, U] = run.states[row, j, U]
        run.begin[j, W] = run.states[row, j, W]
    instant = (run.events[row, EVENT_T], run.events[row, EVENT_T_LOW])
    load_at(run.sets, instant, run.phases, run.records)
    flight = ModalFlight(
        basis_of(run.sets, run.marks[row, NEXT_REGION]),
        run.begin,
        run.pull,
        run.phases,
        run.records,
        run.values,
        run.order,
        run.later,
        run.arrival,
        run.at,
    )
    flight.at[0] = -1.0
    set_pull(flight)
    return flight


@kernel
def evaluate(run: StructureRun, times: Floats, after: bool, place: Floats) -> None:
    """Write displacements and velocities, (n_times, n_x, 2), of a record at instants within it.

    At the very instant of an event they are those after it, or those before.
    """
    for k in range(times.shape[0]):
        row = flight_at(run.events, times[k], after)
        flight = flight_after(run, row)
        s = (times[k] - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW]
        modes = run.scratch[0, : run.begin.shape[0]]
        arrive(flight, s, modes)
        displace(run.sets, run.marks[row, NEXT_REGION], modes, place[k])


@kernel
def evaluate_modes(run: StructureRun, times: Floats, rows: Integers, modes: Floats) -> None:
    """Write the modes (n_times, n, 2) at instants, each in the flight that its row begins."""
    for k in range(times.shape[0]):
        flight = flight_after(run, rows[k])
        s = (times[k] - run.events[rows[k], EVENT_T]) - run.events[rows[k], EVENT_T_LOW]
        arrive(flight, s, modes[k])
