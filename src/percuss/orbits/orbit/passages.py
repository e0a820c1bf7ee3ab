"""How near an orbit comes to the stops between its events, and where it passes through one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import Flight, constant_force, place, set_phases
from percuss.kernels.law import N_HARMONICS, Law, Table
from percuss.kernels.shooting import turning_points
from percuss.model.law import lines
from percuss.model.oscillator import Oscillator

__all__ = [
    "Passages",
    "TurningPoints",
    "flight_turns",
    "flights_of",
    "passages_of",
    "turns_of",
]


# Turning points of a flight for which there is room at first.
ROOM = 64
ULP = 2.220446049250313e-16


@dataclass(frozen=True, slots=True, repr=False)
class Passages:
    """Where a formal orbit passes through stops: at its turning points beyond them.

    Attributes
    ----------
    t
        (n,) array, instants of the turning points [time].
    stop
        (n,) array, index into the oscillator's `stops`.
    depth
        (n,) array, how far beyond the stop [length], > 0.
    """

    t: Floats
    stop: Integers
    depth: Floats

    def __len__(self) -> int:
        """Return the number of passages."""
        return len(self.t)

    def __repr__(self) -> str:
        """Tell the number of passages and the depth of the deepest."""
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
        (n,) array, distance to the nearer bound of the region, negative beyond it [length].
    bound
        (n,) array, number of that bound.
    flight
        (n,) array, number of the event that the flight comes from.
    doubt
        (n,) array, bound on the rounding error of `clearance` [length].
    """

    t: Floats
    clearance: Floats
    bound: Integers
    flight: Integers
    doubt: Floats


def turns_of(table: Law, events: Table, marks: Integers, x0: float, t_end: float) -> TurningPoints:
    """Return the turning points of all flights of a record up to t_end.

    A record of its start alone is that of a steady motion: no event ever disturbs it.
    """
    is_steady = len(events) == 1 and marks[0, columns.KIND] == columns.START
    rows: list[tuple[float, float, int, int, float]] = []
    for i, region, x, start, duration in flights_of(table, events, marks, x0, t_end):
        for s, y, doubt in flight_turns(table, region, x, start, duration, is_steady=is_steady):
            distance = _clearance(table, region, x, y)
            rows.append((start[0] + s, *distance, i, doubt + ULP * abs(x)))
    found = list(zip(*rows, strict=True)) if rows else [()] * 5
    floats = (np.array(found[k], dtype=np.float64) for k in (0, 1, 4))
    t_, clearance, doubts = floats
    bound, flight = (np.array(found[k], dtype=np.int64) for k in (2, 3))
    return TurningPoints(t_, clearance, bound, flight, doubts)


def flights_of(
    table: Law, events: Table, marks: Integers, x0: float, t_end: float
) -> Iterator[tuple[int, int, float, tuple[float, float, float], float]]:
    """Yield the row, region, place, start (t, t_low, v) and duration of each flight of a record."""
    ends = [*events[1:], np.array([t_end, 0.0, 0.0, 0.0])]
    for i, (event, mark, end) in enumerate(zip(events, marks, ends, strict=True)):
        t, t_low = float(event[columns.EVENT_T]), float(event[columns.EVENT_T_LOW])
        duration = float((end[columns.EVENT_T] - t) + (end[columns.EVENT_T_LOW] - t_low))
        if mark[columns.KIND] == columns.CONTACT or duration <= 0.0:
            continue
        region, x = int(mark[columns.NEXT_REGION]), x0
        if mark[columns.KIND] != columns.START:
            x = place(table, region, int(mark[columns.BOUND]))
        yield i, region, x, (t, t_low, float(event[columns.V_AFTER])), duration


def flight_turns(
    table: Law,
    region: int,
    x: float,
    start: tuple[float, float, float],
    duration: float,
    *,
    is_steady: bool,
) -> Table:
    """Return (s, y, doubt) of the turning points of a flight, (n, 3).

    Steady motion holds no free motion: its harmonics alone say how fast it may turn, however fast
    the free motion would be.
    """
    n = int(table[0, N_HARMONICS])
    phases, arrival = np.empty((n, 2)), np.empty((n, 2))
    set_phases(table, start[0], start[1], phases)
    whole = (*start, constant_force(table, region, x))
    search_step = float(table[region, at.STEP])
    if is_steady:
        harmonics = table[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
        fastest = harmonics[harmonics[:, at.AMPLITUDE] > 0.0, at.OMEGA].max(initial=0.0)
        search_step = 1.0 / fastest if fastest > 0.0 else 0.0
    room = ROOM
    while True:
        out = np.empty((room, 3))
        flight = Flight(table, region, whole, phases, arrival)
        found = turning_points(flight, duration, search_step, out)
        if found < room:
            return out[:found]
        room *= 8


def _clearance(table: Law, region: int, x: float, y: float) -> tuple[float, int]:
    """Return distance to, and number of, the nearer bound of a region at x + y."""
    number = int(table[region, at.NUMBER])
    below = (x - float(table[region, at.LOWER])) + y
    above = (float(table[region, at.UPPER]) - x) - y
    return (below, number) if below <= above else (above, number + 1)


def passages_of(osc: Oscillator, turns: TurningPoints) -> Passages:
    """Return those turning points that lie beyond a stop, more than rounding can tell."""
    beyond = turns.clearance < -turns.doubt
    layout = lines(osc)
    stops = [wall if wall is not None else edges[0] if edges else -1
             for wall, edges in zip(layout.wall, layout.edges, strict=True)]  # fmt: skip
    stop = np.array(stops, dtype=np.int64)[turns.bound[beyond]]
    return Passages(turns.t[beyond], stop, -turns.clearance[beyond])


def margin_of(turns: TurningPoints, counted: Flags | None = None) -> float:
    """Return the least clearance, 0 where rounding cannot tell its sign; inf without a turn."""
    clearance = np.where(np.abs(turns.clearance) <= turns.doubt, 0.0, turns.clearance)
    if counted is not None:
        clearance = clearance[counted]
    return float(clearance.min()) if clearance.size else math.inf
