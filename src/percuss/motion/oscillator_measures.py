"""The derivatives of measures of an oscillator's run: of its extremes, means and shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.kernels import record as events_of
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight import force_and_slopes, set_phases
from percuss.kernels.flight_columns import fastest_rate, moved_drive
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    FORCING_CONSTANT,
    MASS,
    N_HARMONICS,
    N_KNOTS,
    NUMBER,
    OMEGA,
    ORIGIN,
    ORIGIN_FORCE,
    STIFFNESS,
)
from percuss.kernels.overdamped import slow_step, time_to_fade
from percuss.kernels.pieces import begin_of_piece, is_record, piece_at, record_at, record_before
from percuss.kernels.sample import flight_at, is_tail
from percuss.model.exact import as_float
from percuss.model.oscillator import SoftStop, Wall
from percuss.model.system import touching_stops
from percuss.motion.accelerations import phases_at
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.moved_measures import MovedStretch, MovedValue, moved_measure, nodes_of
from percuss.motion.moved_motion import MovedMotion


class _Limit(NamedTuple):
    """A state on one side of an instant (t, t_low), and its derivatives where that moves by dt."""

    t: tuple[float, float]
    after: bool
    x: float
    v: float
    dx: Floats
    dv: Floats
    dt: Floats
    region: int
    held: bool


def measure_and_derivative(
    d: MovedMotion, measure: str, longer: Floats | None = None
) -> MovedValue:
    """Return a measure of a run and its derivatives; see `Sensitivity.of`.

    ``longer`` are the derivatives of the run's end where it moves, as that of an orbit's period.
    """
    return moved_measure(_MeasuredOscillator(d, longer), measure)


@dataclass(frozen=True, slots=True)
class _MeasuredOscillator:
    """A run of an oscillator with its derivative, as measures read it."""

    derivative: MovedMotion
    longer: Floats | None

    @property
    def stops(self) -> Sequence[Wall | SoftStop]:
        return self.derivative.run.oscillator.stops

    @property
    def instants(self) -> tuple[Floats, Floats]:
        return _ends(self.derivative, self.longer)

    @property
    def in_contact(self) -> Flags:
        run = self.derivative.run
        numbers = run.system.law[:, NUMBER]
        return np.array(
            [
                row[events_of.KIND] == events_of.CONTACT
                or bool(touching_stops(run.oscillator, int(numbers[row[events_of.NEXT_REGION]])))
                for row in run.record[1]
            ]
        )

    def extremes(self, of: QuantityName, stop: int) -> Extrema:
        return self.derivative.run.extremes(of, stop)

    def values_at(self, of: QuantityName, stop: int, t: float) -> list[MovedValue]:
        d = self.derivative
        return [_quantity(d, limit, of, stop) for limit in _limits(d, t, self.longer)]

    def stretch(self, of: str, row: int, span: tuple[float, float]) -> MovedStretch:
        return _stretch(self.derivative, of, row, span)

    def from_unit_mass(self, mean: MovedValue) -> MovedValue:
        value, column = mean
        d = self.derivative
        mass, heavier = float(d.run.system.law[0, MASS]), d.moved.change.rows[:, 0, MASS]
        return mass * value, np.asarray(mass * column + heavier * value)


def _limits(d: MovedMotion, t: float, longer: Floats | None) -> list[_Limit]:
    """Return the states at an instant: two at an event, which they move along with."""
    events, marks = d.run.record
    rows = np.flatnonzero(events[:, events_of.EVENT_T] == t)
    x, v = (float(value) for value in d.run(t))
    if len(rows) == 0:
        dx, dv = d(t)
        row = flight_at(events, t, True)
        still = _limit(d, row, ((t, 0.0), True, x, v), (dx, dv, np.zeros(len(d.paths))))
        if still.held and _is_knot(d, t):
            return _sides_of_knot(d, still)
        if longer is None or t != d.run.t_end:
            return [still]
        # The last flight goes on to the end, and not over a knot there.
        last = still._replace(t=(t, -float(np.spacing(t))), after=False)
        rate = 0.0 if last.held else _acceleration(d, last)[0]
        return [last._replace(dx=dx + v * longer, dv=dv + rate * longer, dt=longer)]
    limits = []
    for row in rows.tolist():
        columns, after = d.columns[row], float(events[row, events_of.V_AFTER])
        at = t, float(events[row, events_of.EVENT_T_LOW])
        late = columns[:, engine.DT]
        dx = columns[:, engine.BASE] + columns[:, engine.OFF] + after * late
        moved = dx, columns[:, engine.DV_AFTER], late
        limits.append(_limit(d, row, (at, True, x, after), moved))
        is_held = marks[row, events_of.KIND] == events_of.CONTACT
        if is_held and row > 0 and is_tail(events, marks, row - 1):
            # Before it comes to rest the mass has the acceleration that ends the chatter.
            limits.append(limits[-1]._replace(after=False, held=False))
        if row > 0 and not is_held:
            before = float(events[row, events_of.V_BEFORE])
            if marks[row, events_of.KIND] == events_of.KNOT:
                before = after
            moved = dx, columns[:, engine.DV_BEFORE], late
            limits.append(_limit(d, row - 1, (at, False, x, before), moved))
    return limits


def _is_knot(d: MovedMotion, t: float) -> bool:
    """Return whether a knot of the record falls on an instant, to the last place."""
    law, last = d.run.system.law, float(np.spacing(t))
    knot, turn, *_ = begin_of_piece(law, t, -last)
    return bool(law[0, N_KNOTS] > 0.0 and piece_at(law, t, last) != (knot, turn))


def _sides_of_knot(d: MovedMotion, still: _Limit) -> list[_Limit]:
    """Return the states on both sides of a knot, which is no event where a wall holds the mass."""
    law, rows = d.run.system.law, d.moved.change.rows
    t, last = still.t[0], float(np.spacing(still.t[0]))
    late = -t * rows[:, FIRST_HARMONIC + int(law[0, N_HARMONICS]) - 1, OMEGA]
    here = still._replace(dt=late)
    return [here._replace(t=(t, last)), here._replace(t=(t, -last), after=False)]


def _limit(
    d: MovedMotion,
    row: int,
    state: tuple[tuple[float, float], bool, float, float],
    moved: tuple[Floats, Floats, Floats],
) -> _Limit:
    marks = d.run.record[1]
    is_held = bool(marks[row, events_of.KIND] == events_of.CONTACT)
    return _Limit(*state, *moved, int(marks[row, events_of.NEXT_REGION]), is_held)


def _quantity(d: MovedMotion, at: _Limit, of: QuantityName, stop: int) -> MovedValue:
    """Return a quantity at an instant, and its derivative."""
    if of == "displacement":
        return at.x, at.dx
    if of == "acceleration":
        return (0.0, np.zeros_like(at.dx)) if at.held else _acceleration(d, at)
    mass = d.run.system.mass
    row = d.moved.stops[:, stop]
    acting = d.run.system.of_unit_mass.oscillator.stops[stop]
    number = int(d.run.system.law[at.region, NUMBER])
    if isinstance(acting, SoftStop):
        if stop not in touching_stops(d.run.oscillator, number):
            return 0.0, np.zeros_like(at.dx)
        k, drag, depth = (
            as_float(acting.stiffness),
            2.0 * as_float(acting.damping),
            at.x - as_float(acting.at),
        )
        force = -k * depth - drag * at.v
        moved = -row[:, 1] * depth - k * (at.dx - row[:, 0]) - 2.0 * row[:, 2] * at.v - drag * at.dv
    elif at.held:
        # What holds the mass: without it, it would have this acceleration.
        force, moved = _acceleration(d, at)
        force, moved = -force, -moved
    else:
        return 0.0, np.zeros_like(at.dx)
    heavier = d.moved.change.rows[:, 0, MASS]
    return mass * force, mass * moved + heavier * force


def _acceleration(d: MovedMotion, at: _Limit) -> MovedValue:
    """Return the acceleration that the law gives, and its derivative."""
    law, change = d.run.system.law, d.moved.change
    phases = phases_at(law, *at.t)
    n = len(phases)
    jump = np.zeros(len(change.rows))
    if not at.after and n > 0 and is_record(law, n - 1):
        phases[-1] = record_before(law, *at.t)
        before, after = (side(change.unit, *at.t)[0] for side in (record_before, record_at))
        jump = change.rows[:, FIRST_HARMONIC + n - 1, COSINE] * (before - after)
    drive, slope, _ = force_and_slopes(law, phases)
    row, moved = law[at.region], change.rows[:, at.region]
    force = row[ORIGIN_FORCE] - row[STIFFNESS] * (at.x - row[ORIGIN]) + drive
    drives = [moved_drive(law, rows, change.unit, *at.t, phases)[0] for rows in change.rows]
    column = moved[:, ORIGIN_FORCE] - moved[:, STIFFNESS] * at.x - row[STIFFNESS] * at.dx
    column += np.array(drives) + jump + slope * at.dt
    column -= 2.0 * (moved[:, DAMPING] * at.v + row[DAMPING] * at.dv)
    return float(force - 2.0 * row[DAMPING] * at.v), column


def _ends(d: MovedMotion, longer: Floats | None) -> tuple[Floats, Floats]:
    """Return instants of all events and of the end, and their derivatives."""
    events = d.run.record[0]
    instants, moved = events[:, events_of.EVENT_T], d.columns[..., engine.DT]
    # A run that ends at an event ends with it, else at an instant that stays or moves by itself.
    last = moved[-1:]
    if d.run.t_end > instants[-1]:
        last = np.zeros_like(last) if longer is None else longer[np.newaxis]
    return np.append(instants, d.run.t_end), np.concatenate([moved, last])


def _stretch(d: MovedMotion, measure: str, row: int, span: tuple[float, float]) -> MovedStretch:
    events, marks = d.run.record
    is_square = measure == "rms_displacement"
    # In the tail of a chatter the force is constant and the mass comes back to the wall.
    if not is_square and is_tail(events, marks, row):
        return MovedStretch(0.0, np.zeros(len(d.paths)), 0.0, 0.0)
    law, region = d.run.system.law, int(marks[row, events_of.NEXT_REGION])
    fades, slow_rate = time_to_fade(law, region), 1.0 / slow_step(law, region)
    t, w = nodes_of(span, _rate(d, row), fades=fades, slow_rate=slow_rate)
    (x, v), (dx, dv) = d.run(t), d(t)
    if is_square:
        value, limits = x * x, d.run(span)[0] ** 2
        column = 2.0 * x[:, np.newaxis] * dx + 0.0 * dv
    else:
        force, change = _forces(d, t, row)
        value, column = force * v, force[:, np.newaxis] * dv + v[:, np.newaxis] * change
        speeds = np.array([events[row, events_of.V_AFTER], _speed_at_end(d, row)])
        limits = _forces(d, np.array(span), row)[0] * speeds
    moved = (w[:, np.newaxis] * column).sum(axis=0)
    return MovedStretch(float((w * value).sum()), moved, float(limits[0]), float(limits[1]))


def _speed_at_end(d: MovedMotion, row: int) -> float:
    """Return the velocity at the end of the flight after an event."""
    events, marks = d.run.record
    if row + 1 == len(events):
        return float(d.run(d.run.t_end, "before")[1])
    at_knot = marks[row + 1, events_of.KIND] == events_of.KNOT
    return float(events[row + 1, events_of.V_AFTER if at_knot else events_of.V_BEFORE])


def _rate(d: MovedMotion, row: int) -> float:
    """Return the largest rate of the motion after an event."""
    law = d.run.system.law
    n = int(law[0, N_HARMONICS])
    omegas = law[FIRST_HARMONIC : FIRST_HARMONIC + n, OMEGA].tolist()
    region = int(d.run.record[1][row, events_of.NEXT_REGION])
    return float(max([fastest_rate(law, region), *omegas]))


def _forces(d: MovedMotion, t: Floats, row: int) -> tuple[Floats, Floats]:
    """Return the force per unit mass in the flight of an event, and its derivatives."""
    law, change = d.run.system.law, d.moved.change
    begin, low = d.run.record[0][row, [events_of.EVENT_T, events_of.EVENT_T_LOW]].tolist()
    phases = phases_at(law, begin, low)
    piece = phases[-1:].copy()
    forces = np.empty(len(t))
    drives = np.empty((len(t), len(d.paths)))
    for i, instant in enumerate(t.tolist()):
        set_phases(law, instant, 0.0, phases)
        if len(phases) and law[FIRST_HARMONIC + len(phases) - 1, OMEGA] < 0.0:
            # Up to the next knot and at it: the piece that began with the event.
            phases[-1, 0], phases[-1, 1] = (
                piece[0, 0] + piece[0, 1] * (instant - begin),
                piece[0, 1],
            )
        forces[i] = force_and_slopes(law, phases)[0] + law[0, FORCING_CONSTANT]
        drives[i] = [
            moved_drive(law, rows, change.unit, instant, 0.0, phases)[0] for rows in change.rows
        ]
    return forces, drives + change.rows[:, 0, FORCING_CONSTANT]
