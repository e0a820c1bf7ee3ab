"""The turning points of a motion between its events, their clearance, and penetrated stops."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.flight import Flight, constant_force, set_phases
from percuss.kernels.law_columns import N_HARMONICS, Law
from percuss.kernels.shooting import turning_points
from percuss.model.oscillator import Oscillator
from percuss.model.system import lines
from percuss.orbits.orbit.knots import pieces_of_flight

# Turning points of a flight: first length of the buffer, multiplied by eight while it is full.
FIRST_CAPACITY = 64
ULP = 2.220446049250313e-16


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Passages:
    """Where a formal orbit penetrates stops: its turning points beyond them.

    Attributes
    ----------
    t
        (n,) array, instants of the turning points [time].
    stop
        (n,) array, index into the oscillator's `stops`.
    depth
        (n,) array, distance beyond the stop [length], > 0.
    """

    t: Floats
    stop: Integers
    depth: Floats

    def __len__(self) -> int:
        """Return the number of penetrations."""
        return len(self.t)

    def __repr__(self) -> str:
        """Return the number of penetrations and the depth of the deepest."""
        deepest = f", the deepest {self.depth.max():.3g}" if len(self) else ""
        return f"<Passages: {len(self)}{deepest}>"


@dataclass(frozen=True, slots=True)
class TurningPoints:
    """The turning points of a motion between its events.

    Attributes
    ----------
    t
        (n,) array, instants [time].
    clearance
        (n,) array, distance to the nearer bound of the region [length], negative beyond it.
    bound
        (n,) array, number of that bound.
    flight
        (n,) array, number of the event that begins the flight.
    doubt
        (n,) array, bound on the rounding error of `clearance` [length].
    """

    t: Floats
    clearance: Floats
    bound: Integers
    flight: Integers
    doubt: Floats


def turning_points_of(
    law: Law, events: Floats, marks: Integers, x0: float, t_end: float
) -> TurningPoints:
    """Return the turning points of all flights of a record up to t_end.

    A record that holds its start only is that of a steady motion, without events.
    """
    is_steady = len(events) == 1 and marks[0, columns.KIND] == columns.START
    rows: list[tuple[float, float, int, int, float]] = []
    for i, region, x, start, duration in flights_of(law, events, marks, x0, t_end):
        for s, y, doubt in flight_turns(law, region, x, start, duration, is_steady=is_steady):
            distance = _clearance(law, region, x, y)
            rows.append((start[0] + s, *distance, i, doubt + ULP * abs(x)))
    columns_ = list(zip(*rows, strict=True)) if rows else [()] * 5
    t, clearance, doubts = (np.array(columns_[k], dtype=np.float64) for k in (0, 1, 4))
    bound, flight = (np.array(columns_[k], dtype=np.int64) for k in (2, 3))
    return TurningPoints(t, clearance, bound, flight, doubts)


def flights_of(
    law: Law, events: Floats, marks: Integers, x0: float, t_end: float
) -> Iterator[tuple[int, int, float, tuple[float, float, float], float]]:
    """Yield row, region, displacement, start (t, t_low, v) and duration of each flight."""
    record = columns.MotionRecord(law, x0, events, marks)
    ends = [*events[1:], np.array([t_end, 0.0, 0.0, 0.0])]
    for i, (event, mark, end) in enumerate(zip(events, marks, ends, strict=True)):
        t, t_low = float(event[columns.EVENT_T]), float(event[columns.EVENT_T_LOW])
        duration = float((end[columns.EVENT_T] - t) + (end[columns.EVENT_T_LOW] - t_low))
        if mark[columns.KIND] == columns.CONTACT or duration <= 0.0:
            continue
        region, x = int(mark[columns.NEXT_REGION]), columns.place_of_event(record, i)
        yield i, region, x, (t, t_low, float(event[columns.V_AFTER])), duration


def flight_turns(
    law: Law,
    region: int,
    x: float,
    start: tuple[float, float, float],
    duration: float,
    *,
    is_steady: bool,
) -> Floats:
    """Return (s, y, doubt) of the turning points of a flight, (n, 3).

    A steady motion holds no free motion: its harmonics alone bound how fast it turns.
    """
    if law[0, at.N_KNOTS] == 0.0:
        state = (*start, constant_force(law, region, x))
        return _turns_to(law, region, state, duration, is_steady=is_steady)
    force, stiffness = constant_force(law, region, x), float(law[region, at.STIFFNESS])
    parts = []
    for (t, t_low), y, v, duration_of_piece in pieces_of_flight(law, region, x, start, duration):
        since = (t - start[0]) + (t_low - start[1])
        if v == 0.0 and since > 0.0:
            # It turns at the knot itself, the end of two pieces.
            parts.append(np.array([[since, y, 0.0]]))
        state = (t, t_low, v, force - stiffness * y)
        turns = _turns_to(law, region, state, duration_of_piece, is_steady=False)
        parts.append(turns + np.array([since, y, 0.0]))
    return np.concatenate(parts)


def _turns_to(
    law: Law,
    region: int,
    state: tuple[float, float, float, float],
    duration: float,
    *,
    is_steady: bool,
) -> Floats:
    """Return (s, y, doubt) of the turning points of a flight under one piece of a record."""
    n = int(law[0, N_HARMONICS])
    phases, arrival = np.empty((n, 2)), np.empty((n, 2))
    set_phases(law, state[0], state[1], phases)
    search_step = float(law[region, at.STEP])
    if is_steady:
        harmonics = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
        fastest = harmonics[harmonics[:, at.AMPLITUDE] > 0.0, at.OMEGA].max(initial=0.0)
        search_step = 1.0 / fastest if fastest > 0.0 else 0.0
    capacity = FIRST_CAPACITY
    while True:
        out = np.empty((capacity, 3))
        flight = Flight(law, region, state, phases, arrival)
        count = turning_points(flight, duration, search_step, out)
        if count < capacity:
            return out[:count]
        capacity *= 8


def _clearance(law: Law, region: int, x: float, y: float) -> tuple[float, int]:
    """Return the distance to the nearer bound of a region at x + y, and the bound's number."""
    number = int(law[region, at.NUMBER])
    below = (x - float(law[region, at.LOWER])) + y
    above = (float(law[region, at.UPPER]) - x) - y
    return (below, number) if below <= above else (above, number + 1)


def penetrations_of(osc: Oscillator, turns: TurningPoints) -> Passages:
    """Return the turning points that lie beyond a stop by more than their rounding error."""
    deep = turns.clearance < -turns.doubt
    layout = lines(osc)
    stops = [wall if wall is not None else edges[0] if edges else -1
             for wall, edges in zip(layout.wall, layout.edges, strict=True)]  # fmt: skip
    stop = np.array(stops, dtype=np.int64)[turns.bound[deep]]
    return Passages(turns.t[deep], stop, -turns.clearance[deep])


def margin_of(turns: TurningPoints, counted: Flags | None = None) -> float:
    """Return the least clearance, 0 within its rounding error; inf without turning points."""
    clearance = np.where(np.abs(turns.clearance) <= turns.doubt, 0.0, turns.clearance)
    if counted is not None:
        clearance = clearance[counted]
    return float(clearance.min()) if clearance.size else math.inf
