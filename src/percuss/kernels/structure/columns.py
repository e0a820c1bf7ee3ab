"""What a flight of a structure makes of a change of its equation: its columns.

The derivative of a flight by a parameter at a time that stays, a *column*, obeys the flight's own
equation, forced by the change of the equation along the motion,

    M xi'' + C xi' + K xi = dF - dM x'' - dC x' - dK x.

In the modes of the flight, which do not move, the right-hand side is a matrix of the parameter times
the modes, and the change of the loads: no derivative of a mode is needed, which two equal poles do
not have. Modes and columns are followed together by their power series in steps of a few radians:
nothing is divided by a difference of poles, so that equal poles, resonance, critical damping, free
masses and growing motions are one code (docs/theory/sensitivities.md).
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

# What a harmonic pushes: cos(w t), sin(w t), t cos(w t) and t sin(w t).
WAVE_ENTRIES = 4


class MovedSets(NamedTuple):
    """What parameters change in the sets that a motion has met.

    With b sets, n modes and coordinates, s stops, m harmonics, r records and p parameters. What
    receives a force of coordinates are q = 2 n + s rows: u' and w' of each mode, and the watch of
    each wall that holds.

    change: (b, q, n, 2, p), what it receives of the modes; push: (b, q, p), constants; waves:
    (b, q, m, 4, p), of the harmonics; records: (b, q, r, 3, p), of a record's value, of that at
    scale 1, and of t times its slope; places: (b, n, p), where held walls take the coordinates, and
    reactions: (b, s, n, p), the change of the velocities by which a wall stops the unit velocity of
    a clearance; drags: (b, s, p), those of SELF_DRAG; impulses: (s, n, p), those of `Sets`; levels:
    (s, p), the places of stops along their clearances; walls: (p, s, rows, COLUMNS), of the laws of
    one wall; paces: (r, p), the logarithms of the records' paces; units: (r, rows, COLUMNS), laws of
    the records at scale 1; record_pushes: (r, n), the accelerations by records at value 1.
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
                force = flight.pull[j, PULL] + flight.pull[j, SLOPE] * since
                rate = flight.pull[j, DRIFT] + flight.pull[j, DRIFT_SLOPE] * since
            elif i == 1:
                force = flight.pull[j, SLOPE] * h
                rate = flight.pull[j, DRIFT_SLOPE] * h
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
def load_coefficients(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    row: int,
    i: int,
    times: tuple[float, float, float],
    work: SeriesWorkspace,
    out: Floats,
) -> None:
    """Add to ``out`` (p,) the i-th Taylor coefficient of what a row receives of the loads.

    ``times`` are the instant of the flight's start, the time since then and h.
    """
    t, since, h = times
    now = t + since
    n_parameters = out.shape[0]
    if i == 0:
        for p in range(n_parameters):
            out[p] += moved.push[b, row, p]
    for k in range(flight.phases.shape[0]):
        cosine = work.phases[i, k, 0]
        sine = work.phases[i, k, 1]
        late_cosine = now * cosine
        late_sine = now * sine
        if i > 0:
            late_cosine += h * work.phases[i - 1, k, 0]
            late_sine += h * work.phases[i - 1, k, 1]
        wave = moved.waves[b, row, k]
        for p in range(n_parameters):
            out[p] += wave[0, p] * cosine + wave[1, p] * sine
            out[p] += wave[2, p] * late_cosine + wave[3, p] * late_sine
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
        record = moved.records[b, row, k]
        for p in range(n_parameters):
            out[p] += record[0, p] * value + record[1, p] * unit + record[2, p] * late


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
    for i in range(terms):
        step = times[2] / (i + 1.0)
        for j in range(n):
            for part in range(2):
                row = 2 * j + part
                out = work.columns[i + 1, j, part]
                for p in range(n_parameters):
                    out[p] = 0.0
                load_coefficients(flight, moved, b, row, i, times, work, out)
                for other in range(n):
                    u = work.modes[i, other, U]
                    w = work.modes[i, other, W]
                    for p in range(n_parameters):
                        out[p] += moved.change[b, row, other, U, p] * u
                        out[p] += moved.change[b, row, other, W, p] * w
                for p in range(n_parameters):
                    if part == U:
                        out[p] += work.columns[i, j, W, p]
                    else:
                        out[p] -= basis.modes[j, SPRING] * work.columns[i, j, U, p]
                        out[p] -= basis.modes[j, DRAG] * work.columns[i, j, W, p]
                    out[p] *= step


@kernel
def column_changes(
    flight: ModalFlight,
    moved: MovedSets,
    b: int,
    t: float,
    s: float,
    columns: Floats,
    changes: Floats,
    work: SeriesWorkspace,
) -> None:
    """Write into ``changes`` (n, 2, p) those of ``columns`` over a time s from a flight's start.

    `begin_series` has been called for the flight, which begins at t.
    """
    n, n_parameters = changes.shape[0], changes.shape[2]
    for j in range(n):
        for part in range(2):
            for p in range(n_parameters):
                changes[j, part, p] = 0.0
    if not s > 0.0:
        return
    count, terms = steps_of(s * flight.basis.of_set[QUICKEST])
    h = s / count
    for number in range(count):
        since = number * h
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
                for p in range(n_parameters):
                    change = 0.0
                    for i in range(terms, 0, -1):
                        change += work.columns[i, j, part, p]
                    changes[j, part, p] += change


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
    """Write the derivative (p,) of the force of a wall that holds, at an instant that stays.

    ``times`` are the instant of the flight's start and the time since then; ``columns`` (n, 2, p)
    are those at the instant, to which `column_changes` has taken the modes.
    """
    modes = work.present
    n = modes.shape[0]
    row = 2 * n + stop
    for p in range(out.shape[0]):
        out[p] = 0.0
    fill_phases(flight, times[1], 0.0, 0, work)
    load_coefficients(flight, moved, b, row, 0, (times[0], times[1], 0.0), work, out)
    watch = flight.basis.watch[stop]
    for j in range(n):
        for p in range(out.shape[0]):
            out[p] += moved.change[b, row, j, U, p] * modes[j, U]
            out[p] += moved.change[b, row, j, W, p] * modes[j, W]
            out[p] += watch[j, OF_U] * columns[j, U, p] + watch[j, OF_W] * columns[j, W, p]
