"""The smooth pieces of a run in a window of time, and their ends, as columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.flight import constant_force
from percuss.kernels.law import (
    FIRST_HARMONIC,
    LOWER,
    N_HARMONICS,
    NUMBER,
    STIFFNESS,
    UPPER,
    Law,
)
from percuss.model.law import law as law_of
from percuss.motion.trajectory import Trajectory

__all__ = ["Pieces", "constant_forces", "pieces_of"]


@dataclass(frozen=True, slots=True)
class Pieces:
    """Flights and contacts in order of time; their ends are counted from the window's start.

    Attributes
    ----------
    start, start_low, end, end_low
        (n,) arrays [time]: each instant is the sum of two floats.
    x0, v0, x1, v1
        (n,) arrays, the motion at the start and at the end.
    region
        (n,) array, row of the law that holds.
    in_contact
        (n,) bool array, true for contacts.
    """

    start: Floats
    start_low: Floats
    end: Floats
    end_low: Floats
    x0: Floats
    v0: Floats
    x1: Floats
    v1: Floats
    region: Integers
    in_contact: Flags


def pieces_of(run: Trajectory, low: float, high: float) -> Pieces:
    """Cut the window [low, high] of a run at its events."""
    law = law_of(run.oscillator, run.forcing)
    events, marks = run._events, run._marks
    times = events[:, columns.EVENT_T]
    first = max(int(np.searchsorted(times, low, side="right")) - 1, 0)
    last = max(int(np.searchsorted(times, high, side="left")), first + 1)
    instants, lows = (
        times[first : last + 1].copy(),
        events[first : last + 1, columns.EVENT_T_LOW].copy(),
    )
    # The ends of the window are given as floats, and are no events unless they happen to be.
    if instants[0] < low:
        instants[0], lows[0] = low, 0.0
    instants, lows = np.append(instants[: last - first], high), np.append(lows[: last - first], 0.0)
    rest, rest_low = _difference(instants, low)
    rest_low += lows
    place = _places(run, law, marks)
    kind = marks[:, columns.KIND]
    # A mass that is held has no velocity; the column of a contact holds something else.
    moving = (kind != columns.CONTACT) & (kind != columns.RELEASE)
    before = np.where(moving, events[:, columns.V_BEFORE], 0.0)
    x0, v0 = place[first:last].copy(), events[first:last, columns.V_AFTER].copy()
    x1, v1 = np.append(place[first + 1 : last], 0.0), np.append(before[first + 1 : last], 0.0)
    if times[first] < low:
        x0[0], v0[0] = (float(value) for value in run(low))
    x1[-1], v1[-1] = (float(value) for value in run(high, limit="before"))
    region = marks[first:last, columns.NEXT_REGION].astype(np.int64)
    # What comes between the last listed hop of a chatter and its end is no higher than rounding.
    in_contact = kind[first:last] == columns.CONTACT
    in_contact[:-1] |= kind[first + 1 : last] == columns.CONTACT
    return Pieces(
        rest[:-1], rest_low[:-1], rest[1:], rest_low[1:], x0, v0, x1, v1, region, in_contact
    )


def _difference(instants: Floats, origin: float) -> tuple[Floats, Floats]:
    """Return instants - origin as the sums of two floats."""
    difference = instants - origin
    back = instants - difference
    return difference, (instants - (difference + back)) + (back - origin)


def _places(run: Trajectory, law: Law, marks: Integers) -> Floats:
    """Return where each event happens."""
    rows = marks[:, columns.NEXT_REGION].astype(np.int64)
    is_lower = marks[:, columns.BOUND] == law[rows, NUMBER].astype(np.int64)
    place = np.where(is_lower, law[rows, LOWER], law[rows, UPPER])
    place[0] = run.x0
    return np.asarray(place, dtype=np.float64)


def constant_forces(law: Law) -> dict[int, float]:
    """Return, for each region's row, the constant G of x'' + 2 a x' + K x = G + harmonics."""
    n = int(law[0, N_HARMONICS])
    rows = range(FIRST_HARMONIC + n, len(law), 1 + n)
    return {row: _constant(law, row) for row in rows}


def _constant(law: Law, row: int) -> float:
    bounds = (law[row, LOWER], law[row, UPPER])
    at = min(max(0.0, bounds[0]), bounds[1])
    return float(constant_force(law, row, at) + law[row, STIFFNESS] * at)
