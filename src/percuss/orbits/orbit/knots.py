"""The knots of a record in the motion of an orbit.

An orbit keeps its events alone; a run has a row for each knot, too (`kernels.record.KNOT`).
"""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.flight import Flight, constant_force, move, set_phases
from percuss.kernels.law_columns import N_HARMONICS, N_KNOTS, STIFFNESS, Law
from percuss.kernels.pieces import next_knot, time_to_knot

# Instant, displacement and velocity at the start of a piece, and its duration.
FlightPiece = tuple[tuple[float, float], float, float, float]


def pieces_of_flight(
    law: Law, region: int, x: float, start: tuple[float, float, float], duration: float
) -> list[FlightPiece]:
    """Return the pieces into which the knots of a record cut a flight.

    Parameters
    ----------
    law, region
        The law and the row of the region.
    x
        Where the flight begins [length].
    start
        Its instant in two parts, and its velocity.
    duration
        How long it lasts [time]; a formal one of a negative duration is not cut.

    Returns
    -------
    list of tuple
        For each piece its instant in two parts, the displacement since the start of the flight,
        the velocity, and its duration.
    """
    instant, v = (start[0], start[1]), start[2]
    y, left = 0.0, duration
    pieces: list[FlightPiece] = []
    phases, arrival = np.empty((2, int(law[0, N_HARMONICS]), 2))
    force = constant_force(law, region, x)
    while (to_knot := float(time_to_knot(law, *instant))) < left:
        pieces.append((instant, y, v, to_knot))
        set_phases(law, *instant, phases)
        state = (*instant, v, force - float(law[region, STIFFNESS]) * y)
        moved, v = move(Flight(law, region, state, phases, arrival), to_knot)
        y += moved
        instant = next_knot(law, *instant)
        left = duration - ((instant[0] - start[0]) + (instant[1] - start[1]))
    return [*pieces, (instant, y, v, left)]


def with_knots(
    law: Law, events: Floats, marks: Integers, x0: float, t_end: float
) -> tuple[Floats, Integers]:
    """Return a record of events with the rows of the knots between them.

    Parameters
    ----------
    law, events, marks
        The law, and a record without the knots of its force.
    x0
        Where it starts [length].
    t_end
        Where its last flight ends [time].
    """
    if law[0, N_KNOTS] == 0.0:
        return events, marks
    rows: list[Floats] = []
    kinds: list[Integers] = []
    ends = [*events[1:, :2], np.array([t_end, 0.0])]
    record = columns.MotionRecord(law, x0, events, marks)
    for i, (event, mark, end) in enumerate(zip(events, marks, ends, strict=True)):
        rows.append(event)
        kinds.append(mark)
        if mark[columns.KIND] == columns.CONTACT:
            continue
        t, t_low, _, v = (float(value) for value in event)
        region, x = int(mark[columns.NEXT_REGION]), columns.place_of_event(record, i)
        duration = float((end[0] - t) + (end[1] - t_low))
        for instant, y, speed, _ in pieces_of_flight(law, region, x, (t, t_low, v), duration)[1:]:
            rows.append(np.array([*instant, x + y, speed]))
            kinds.append(np.array([columns.KNOT, -1, region], dtype=np.int64))
    return np.array(rows), np.array(kinds, dtype=np.int64)


def without_knots(events: Floats, marks: Integers) -> tuple[Floats, Integers]:
    """Return a record of a run without the rows of knots; the first row stands for a start.

    A knot that has released the mass is kept: at another release no force acts.
    """
    is_knot = marks[:, columns.KIND] == columns.KNOT
    kept = ~is_knot
    if kept.all():
        return events, marks
    released = marks[:-1, columns.KIND] == columns.RELEASE
    at_once = (events[1:, :2] == events[:-1, :2]).all(axis=1)
    kept[1:] |= is_knot[1:] & released & at_once
    kept[:1] = True
    return events[kept], marks[kept]
