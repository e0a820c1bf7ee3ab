"""Columns: the derivatives of a flight of a structure by parameters.

The derivative of a flight by a parameter at a fixed time, a *column*, obeys the flight's own
equation, forced by the change of the equation along the motion,

    M xi'' + C xi' + K xi = dF - dM x'' - dC x' - dK x.

In the modes of the flight, which do not move, the right-hand side is a matrix of the parameter
times the modes, and the change of the loads: no derivative of a mode is needed, which two equal
poles do not have. Modes and columns are followed together by their power series in steps of a few
radians: nothing is divided by a difference of poles, so that equal poles, resonance, critical
damping, free masses and growing motions are one code (docs/theory/sensitivities.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight_columns import MOST_TERMS, steps_of
from percuss.kernels.law_columns import FIRST_HARMONIC, OMEGA, TURNS, TURNS_LOW
from percuss.kernels.pieces import record_at
from percuss.kernels.structure.basis import (
    DRAG,
    FORCE_COS,
    FORCE_SIN,
    OF_U,
    OF_W,
    QUICKEST,
    RATE_COS,
    RATE_SIN,
    SPRING,
)
from percuss.kernels.structure.flight import (
    DRIFT,
    DRIFT_SLOPE,
    PULL,
    SLOPE,
    ModalFlight,
    U,
    W,
)

# Functions of time by which the change of a harmonic enters: cos(w t), sin(w t), t cos(w t) and t
# sin(w t).
WAVE_ENTRIES = 4


class MovedSets(NamedTuple):
    """What parameters change in the sets that a motion has met.

    With b sets, n modes and coordinates, s stops, m harmonics, r records and p parameters. What
    receives a force of coordinates are q = 2 n + s rows: u' and w' of each mode, and the guard of
    each wall that holds.

    - ``change`` (b, n, 2, q, p): what it receives of the modes; ``push`` (b, q, p): constants;
      ``waves`` (b, m, 4, q, p): of the harmonics; ``records`` (b, r, 3, q, p): of a record's value,
      of that at scale 1, and of t times its slope;
    - ``places`` (b, n, p): where held walls take the coordinates; ``reactions`` (b, s, n, p): the
      change of the velocities by which a wall stops the unit velocity of a clearance;
    - ``drags`` (b, s, p): those of SELF_DRAG; ``impulses`` (s, n, p): those of `Sets`;
    - ``levels`` (s, p): the places of stops along their clearances; ``walls``
      (p, s, rows, COLUMNS): of the laws of one wall;
    - ``paces`` (r, p): the logarithms of the records' paces; ``units`` (r, rows, COLUMNS): laws of
      the records at scale 1; ``record_pushes`` (r, n): the accelerations by records at value 1.
    """

    change: Floats
    push: Floats
    waves: Floats
    records: Floats
    places: Floats
    reactions: Floats
    drags: Floats
    impulses: Floats
    levels: Floats
    walls: Floats
    paces: Floats
    units: Floats
    record_pushes: Floats


class SeriesWorkspace(NamedTuple):
    """Scratch: power series of modes (terms, n, 2), columns (terms, n, 2, p), phases (terms, m, 2).

    ``present`` (n, 2) are the modes at the begin of a step; ``units`` (r, 2) values and slopes of
    the records at scale 1 at the start of the flight.
    """

    modes: Floats
    columns: Floats
    phases: Floats
    present: Floats
    units: Floats


def new_series(n: int, m: int, r: int, p: int) -> SeriesWorkspace:
    """Return scratch for n modes, m harmonics, r records and p parameters."""
    return SeriesWorkspace(
        np.zeros((MOST_TERMS + 1, n, 2)),
        np.zeros((MOST_TERMS + 1, n, 2, p)),
        np.zeros((MOST_TERMS + 1, m, 2)),
        np.zeros((n, 2)),
        np.zeros((r, 2)),
    )


@kernel
def unit_records(moved: MovedSets, t: float, t_low: float, units: Floats) -> None:
    """Write values and slopes of the records at scale 1, (r, 2), at an instant."""
    for k in range(units.shape[0]):
        units[k, 0], units[k, 1] = record_at(moved.units[k], t, t_low)


@kernel
def begin_series(
    flight: ModalFlight, moved: MovedSets, t: float, t_low: float, work: SeriesWorkspace
) -> None:
    """Take the modes and the records of a flight that starts at an instant."""
    for j in range(work.present.shape[0]):
        work.present[j, U] = flight.begin[j, U]
        work.present[j, W] = flight.begin[j, W]
    unit_records(moved, t, t_low, work.units)


@kernel
def fill_phases(
    flight: ModalFlight, since: float, h: float, terms: int, work: SeriesWorkspace
) -> None:
    """Write the Taylor coefficients of the harmonics' phases, of powers of s / h."""
    law = flight.basis.law
    for k in range(flight.phases.shape[0]):
        harmonic = FIRST_HARMONIC + k
        cos0 = flight.phases[k, 0]
        sin0 = flight.phases[k, 1]
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], since, 0.0)
        work.phases[0, k, 0] = cos0 * turn[0] - sin0 * turn[1]
        work.phases[0, k, 1] = sin0 * turn[0] + cos0 * turn[1]
        phase = law[harmonic, OMEGA] * h
        for i in range(terms):
            share = phase / (i + 1.0)
            work.phases[i + 1, k, 0] = -share * work.phases[i, k, 1]
            work.phases[i + 1, k, 1] = share * work.phases[i, k, 0]


@kernel
def fill_modes(
    flight: ModalFlight, since: float, h: float, terms: int, work: SeriesWorkspace
) -> None:
    """Write the Taylor coefficients of the modes, of powers of s / h, behind those of order 0."""
    basis = flight.basis
    for i in range(terms):
        step = h / (i + 1.0)
        for j in range(work.present.shape[0]):
            force = 0.0
            rate = 0.0
            if i == 0:
                force = flight.pull[PULL, j] + flight.pull[SLOPE, j] * since
                rate = flight.pull[DRIFT, j] + flight.pull[DRIFT_SLOPE, j] * since
            elif i == 1:
                force = flight.pull[SLOPE, j] * h
                rate = flight.pull[DRIFT_SLOPE, j] * h
            for k in range(flight.phases.shape[0]):
                cosine = work.phases[i, k, 0]
                sine = work.phases[i, k, 1]
                force += basis.drive[j, k, FORCE_COS] * cosine
                force += basis.drive[j, k, FORCE_SIN] * sine
                rate += basis.drive[j, k, RATE_COS] * cosine + basis.drive[j, k, RATE_SIN] * sine
            u = work.modes[i, j, U]
            w = work.modes[i, j, W]
            work.modes[i + 1, j, U] = step * (w + rate)
            work.modes[i + 1, j, W] = step * (
                force - basis.modes[j, SPRING] * u - basis.modes[j, DRAG] * w
            )


@formula
def add_times(factor: float, vector: Floats, first: int, out: Floats) -> None:
    """Add to ``out`` a number times as many entries of a vector, from one on."""
    for k in range(out.shape[0]):
        out[k] += factor * vector[first + k]


@formula
def add_loads(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    first: int,
    i: int,
    times: tuple[float, float, float],
    work: SeriesWorkspace,
    out: Floats,
) -> None:
    """Add to ``out`` the i-th Taylor coefficient of what rows receive of the loads.

    The rows of all parameters lie side by side, (q p,); ``first`` is where ``out`` begins.
    ``times`` are the instant of the flight's start, the time since then and h.
    """
    t, since, h = times
    now = t + since
    if i == 0:
        add_times(1.0, moved.push[b].reshape(-1), first, out)
    for k in range(flight.phases.shape[0]):
        cosine = work.phases[i, k, 0]
        sine = work.phases[i, k, 1]
        late_cosine = now * cosine
        late_sine = now * sine
        if i > 0:
            late_cosine += h * work.phases[i - 1, k, 0]
            late_sine += h * work.phases[i - 1, k, 1]
        add_times(cosine, moved.waves[b, k, 0].reshape(-1), first, out)
        add_times(sine, moved.waves[b, k, 1].reshape(-1), first, out)
        add_times(late_cosine, moved.waves[b, k, 2].reshape(-1), first, out)
        add_times(late_sine, moved.waves[b, k, 3].reshape(-1), first, out)
    if i > 1:
        return
    for k in range(flight.records.shape[0]):
        slope = flight.records[k, 1]
        unit_slope = work.units[k, 1]
        value = slope * h
        unit = unit_slope * h
        late = slope * h
        if i == 0:
            value = flight.records[k, 0] + slope * since
            unit = work.units[k, 0] + unit_slope * since
            late = slope * now
        add_times(value, moved.records[b, k, 0].reshape(-1), first, out)
        add_times(unit, moved.records[b, k, 1].reshape(-1), first, out)
        add_times(late, moved.records[b, k, 2].reshape(-1), first, out)


@kernel
def fill_columns(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    times: tuple[float, float, float],
    terms: int,
    work: SeriesWorkspace,
) -> None:
    """Write the Taylor coefficients of the columns, of powers of s / h, behind those of order 0."""
    basis = flight.basis
    n, n_parameters = work.columns.shape[1], work.columns.shape[3]
    width = 2 * n * n_parameters
    for i in range(terms):
        step = times[2] / (i + 1.0)
        following = work.columns[i + 1].reshape(width)
        for k in range(width):
            following[k] = 0.0
        # All rows in one long loop: it becomes vector instructions.
        add_loads(flight, moved, b, 0, i, times, work, following)
        for other in range(n):
            for part in range(2):
                value = work.modes[i, other, part]
                add_times(value, moved.change[b, other, part].reshape(-1), 0, following)
        for j in range(n):
            spring = basis.modes[j, SPRING]
            drag = basis.modes[j, DRAG]
            for p in range(n_parameters):
                u = work.columns[i, j, U, p]
                w = work.columns[i, j, W, p]
                work.columns[i + 1, j, U, p] = step * (work.columns[i + 1, j, U, p] + w)
                whole = work.columns[i + 1, j, W, p] - (spring * u + drag * w)
                work.columns[i + 1, j, W, p] = step * whole


@kernel
def column_changes(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    times: tuple[float, float, float],
    columns: Floats,
    changes: Floats,
    work: SeriesWorkspace,
) -> None:
    """Write into ``changes`` (n, 2, p) those of ``columns`` over a time of a flight.

    ``times`` are the instant of the flight's start, how long after it the columns are, and the
    time, of either sign. `begin_series` has been called for the flight, and the modes of ``work``
    are those of the columns; they are taken along.
    """
    t, begin, s = times
    n, n_parameters = changes.shape[0], changes.shape[2]
    width = 2 * n * n_parameters
    for j in range(n):
        for part in range(2):
            for p in range(n_parameters):
                changes[j, part, p] = 0.0
    if s == 0.0:
        return
    count, terms = steps_of(abs(s) * flight.basis.of_set[QUICKEST])
    h = s / count
    for number in range(count):
        since = begin + number * h
        for j in range(n):
            for part in range(2):
                work.modes[0, j, part] = work.present[j, part]
                for p in range(n_parameters):
                    work.columns[0, j, part, p] = columns[j, part, p] + changes[j, part, p]
        fill_phases(flight, since, h, terms, work)
        fill_modes(flight, since, h, terms, work)
        fill_columns(flight, moved, b, (t, since, h), terms, work)
        for j in range(n):
            for part in range(2):
                change = 0.0
                for i in range(terms, 0, -1):
                    change += work.modes[i, j, part]
                work.present[j, part] += change
        # The smallest terms first, into the coefficients of order 0, which are spent.
        spent = work.columns[0].reshape(width)
        for k in range(width):
            spent[k] = 0.0
        for i in range(terms, 0, -1):
            term = work.columns[i].reshape(width)
            for k in range(width):
                spent[k] += term[k]
        for j in range(n):
            for part in range(2):
                for p in range(n_parameters):
                    changes[j, part, p] += work.columns[0, j, part, p]


@kernel
def moved_force(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    stop: int,
    times: tuple[float, float],
    columns: Floats,
    work: SeriesWorkspace,
    out: Floats,
) -> None:
    """Write the derivative (p,) of the force of a wall that holds, at a fixed instant.

    ``times`` are the instant of the flight's start and the time since then; ``columns`` (n, 2, p)
    are those at the instant, to which `column_changes` has taken the modes.
    """
    modes = work.present
    n = modes.shape[0]
    row = 2 * n + stop
    for p in range(out.shape[0]):
        out[p] = 0.0
    fill_phases(flight, times[1], 0.0, 0, work)
    first = row * out.shape[0]
    add_loads(flight, moved, b, first, 0, (times[0], times[1], 0.0), work, out)
    guard = flight.basis.guard[stop]
    for j in range(n):
        for p in range(out.shape[0]):
            out[p] += moved.change[b, j, U, row, p] * modes[j, U]
            out[p] += moved.change[b, j, W, row, p] * modes[j, W]
            out[p] += guard[j, OF_U] * columns[j, U, p] + guard[j, OF_W] * columns[j, W, p]
