"""The derivatives of measures of a run: of its extremes, means and shares."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels import record as events_of
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight import force_and_slopes, set_phases
from percuss.kernels.flight_columns import fastest_rate, moved_drive
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    FORCING_CONSTANT,
    MASS,
    N_HARMONICS,
    NUMBER,
    OMEGA,
    ORIGIN,
    ORIGIN_FORCE,
    STIFFNESS,
)
from percuss.kernels.sample import flight_at, is_tail
from percuss.model.exact import as_float
from percuss.model.oscillator import SoftStop
from percuss.model.system import touching_stops
from percuss.motion.extremes import QuantityName
from percuss.motion.moved_motion import MovedMotion
from percuss.numerics import gauss_legendre

__all__ = ["MovedMeasure", "MovedValue", "measure_and_derivative"]

MovedMeasure = Literal[
    "max_displacement",
    "min_displacement",
    "peak_displacement",
    "peak_acceleration",
    "peak_stop_force",
    "peak_impact_velocity",
    "rms_displacement",
    "mean_power",
    "contact_share",
]
# Nodes of Gauss's rule on a part of a flight, and the phase of the fastest motion in a part: its
# error is below 1e-16.
NODES, PHASE = 16, 3.0


class _Limit(NamedTuple):
    """A state on one side of an instant, and its derivatives where that moves by dt."""

    t: float
    x: float
    v: float
    dx: Floats
    dv: Floats
    dt: Floats
    region: int
    held: bool


# A value and its derivatives.
MovedValue: TypeAlias = tuple[float, Floats]


def measure_and_derivative(d: MovedMotion, measure: str) -> MovedValue:
    """Return a measure of a run and its derivatives; see `Sensitivity.of`."""
    if measure not in get_args(MovedMeasure):
        known = ", ".join(get_args(MovedMeasure))
        raise ParameterError("measure", measure, f"none of those that have a derivative: {known}")
    if measure == "peak_impact_velocity":
        return _of_fastest_impact(d)
    if measure == "contact_share":
        return _of_contact_share(d)
    if measure in ("rms_displacement", "mean_power"):
        return _of_mean(d, measure)
    if measure == "peak_acceleration":
        return _of_peak(d, "acceleration")
    if measure == "peak_stop_force":
        stops = range(len(d.run.oscillator.stops))
        peaks = [d.run.extremes("stop_force", stop).peak for stop in stops]
        if not peaks or max(peaks) == 0.0:
            return 0.0, np.zeros(len(d.paths))
        return _of_peak(d, "stop_force", int(np.argmax(peaks)))
    if measure == "peak_displacement":
        return _of_peak(d, "displacement")
    ends = d.run.extremes("displacement")
    if measure == "max_displacement":
        return _of_value(d, "displacement", 0, ends.maximum, ends.t_maximum)
    return _of_value(d, "displacement", 0, ends.minimum, ends.t_minimum)


def _of_peak(d: MovedMotion, of: QuantityName, stop: int = 0) -> MovedValue:
    ends = d.run.extremes(of, stop)
    if ends.maximum >= -ends.minimum:
        return _of_value(d, of, stop, ends.maximum, ends.t_maximum)
    value, moved = _of_value(d, of, stop, ends.minimum, ends.t_minimum)
    return -value, -moved


def _of_value(d: MovedMotion, of: QuantityName, stop: int, value: float, t: float) -> MovedValue:
    """Return an extreme value of a quantity, which it has at t, and its derivatives."""
    found = [_quantity(d, limit, of, stop) for limit in _limits(d, t)]
    return value, min(found, key=lambda pair: abs(pair[0] - value))[1]


def _limits(d: MovedMotion, t: float) -> list[_Limit]:
    """Return the states at an instant: two at an event, which they move along with."""
    events, marks = d.run.record
    rows = np.flatnonzero(events[:, events_of.EVENT_T] == t)
    x, v = (float(value) for value in d.run(t))
    if len(rows) == 0:
        dx, dv = d(t)
        row = flight_at(events, t, True)
        return [_limit(d, row, (t, x, v), (dx, dv, np.zeros(len(d.paths))))]
    limits = []
    for row in rows.tolist():
        columns, after = d.columns[row], float(events[row, events_of.V_AFTER])
        late = columns[:, engine.DT]
        dx = columns[:, engine.BASE] + columns[:, engine.OFF] + after * late
        limits.append(_limit(d, row, (t, x, after), (dx, columns[:, engine.DV_AFTER], late)))
        is_held = marks[row, events_of.KIND] == events_of.CONTACT
        if row > 0 and not is_held:
            before = float(events[row, events_of.V_BEFORE])
            if marks[row, events_of.KIND] == events_of.KNOT:
                before = after
            limits.append(
                _limit(d, row - 1, (t, x, before), (dx, columns[:, engine.DV_BEFORE], late))
            )
    return limits


def _limit(
    d: MovedMotion,
    row: int,
    state: tuple[float, float, float],
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
    it = d.run.system.of_unit_mass.oscillator.stops[stop]
    number = int(d.run.system.law[at.region, NUMBER])
    if isinstance(it, SoftStop):
        if stop not in touching_stops(d.run.oscillator, number):
            return 0.0, np.zeros_like(at.dx)
        k, drag, depth = as_float(it.stiffness), 2.0 * as_float(it.damping), at.x - as_float(it.at)
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
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    set_phases(law, at.t, 0.0, phases)
    drive, slope, _ = force_and_slopes(law, phases)
    row, moved = law[at.region], change.rows[:, at.region]
    force = row[ORIGIN_FORCE] - row[STIFFNESS] * (at.x - row[ORIGIN]) + drive
    drives = [moved_drive(law, rows, change.unit, at.t, 0.0, phases)[0] for rows in change.rows]
    column = moved[:, ORIGIN_FORCE] - moved[:, STIFFNESS] * at.x - row[STIFFNESS] * at.dx
    column += np.array(drives) + slope * at.dt
    column -= 2.0 * (moved[:, DAMPING] * at.v + row[DAMPING] * at.dv)
    return float(force - 2.0 * row[DAMPING] * at.v), column


def _of_fastest_impact(d: MovedMotion) -> MovedValue:
    into = d.run.crossings.direction == "in"
    speeds = np.concatenate([d.run.impacts.v_before, d.run.crossings.v[into]])
    moved = np.concatenate([d.impacts.v_before, d.crossings.v[into]])
    if len(speeds) == 0:
        return 0.0, np.zeros(len(d.paths))
    fastest = int(np.argmax(np.abs(speeds)))
    speed = float(speeds[fastest])
    return abs(speed), np.asarray(math.copysign(1.0, speed) * moved[fastest])


def _ends(d: MovedMotion) -> tuple[Floats, Floats]:
    """Return instants of all events and of the end, and their derivatives."""
    events = d.run.record[0]
    instants, moved = events[:, events_of.EVENT_T], d.columns[..., engine.DT]
    # A run that ends at an event ends with it, else at an instant that stays.
    if d.run.t_end > instants[-1]:
        moved = np.concatenate([moved, np.zeros((1, len(d.paths)))])
    else:
        moved = np.concatenate([moved, moved[-1:]])
    return np.append(instants, d.run.t_end), moved


def _of_contact_share(d: MovedMotion) -> MovedValue:
    marks, law = d.run.record[1], d.run.system.law
    touches = np.array(
        [
            row[events_of.KIND] == events_of.CONTACT
            or bool(touching_stops(d.run.oscillator, int(law[row[events_of.NEXT_REGION], NUMBER])))
            for row in marks
        ]
    )
    instants, moved = _ends(d)
    whole, longer = instants[-1] - instants[0], moved[-1] - moved[0]
    share = float(np.diff(instants)[touches].sum()) / whole
    held = np.diff(moved, axis=0)[touches].sum(axis=0)
    return share, np.asarray((held - share * longer) / whole)


def _of_mean(d: MovedMotion, measure: str) -> MovedValue:
    """Return the root of the mean of x^2, or the mean of the force times v, and its derivatives."""
    law, events = d.run.system.law, d.run.record[0]
    of = _square if measure == "rms_displacement" else _power
    instants, moved = _ends(d)
    marks = d.run.record[1]
    at_knot = marks[:, events_of.KIND] == events_of.KNOT
    column_of_v = np.where(at_knot, events_of.V_AFTER, events_of.V_BEFORE)
    before = np.append(
        events[np.arange(len(events)), column_of_v][1:], d.run(d.run.t_end, "before")[1]
    )
    total, column = 0.0, np.zeros(len(d.paths))
    for row in range(len(events)):
        begin, end = float(instants[row]), float(instants[row + 1])
        # In the tail of a chatter the force is constant and the mass comes back to the wall.
        if not end > begin or (of is _power and is_tail(events, marks, row)):
            continue
        t, w = _nodes(d, row, begin, end)
        value, moved_value = of(d, t, *d.run(t), row)
        total += float((w * value).sum())
        column += (w[:, np.newaxis] * moved_value(*d(t))).sum(axis=0)
        v = np.array([events[row, events_of.V_AFTER], before[row]])
        limits = of(d, np.array([begin, end]), d.run([begin, end])[0], v, row)[0]
        column += limits[1] * moved[row + 1] - limits[0] * moved[row]
    whole, longer = instants[-1] - instants[0], moved[-1] - moved[0]
    mean = total / whole
    column = (column - mean * longer) / whole
    if measure == "rms_displacement":
        root = math.sqrt(mean)
        return root, np.asarray(column / (2.0 * root) if root > 0.0 else column)
    mass, heavier = float(law[0, MASS]), d.moved.change.rows[:, 0, MASS]
    return mass * mean, np.asarray(mass * column + heavier * mean)


def _nodes(d: MovedMotion, row: int, begin: float, end: float) -> tuple[Floats, Floats]:
    """Return the nodes and the weights of an integral over the stretch after an event."""
    law = d.run.system.law
    n = int(law[0, N_HARMONICS])
    omegas = law[FIRST_HARMONIC : FIRST_HARMONIC + n, OMEGA].tolist()
    region = int(d.run.record[1][row, events_of.NEXT_REGION])
    rate = max([fastest_rate(law, region), *omegas])
    nodes, weights = gauss_legendre(NODES)
    edges = np.linspace(begin, end, max(1, math.ceil((end - begin) * rate / PHASE)) + 1)
    middles, halves = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    t = (middles[:, np.newaxis] + halves[:, np.newaxis] * nodes).reshape(-1)
    return t, (halves[:, np.newaxis] * weights).reshape(-1)


def _square(
    d: MovedMotion,  # noqa: ARG001
    t: Floats,  # noqa: ARG001
    x: Floats,
    v: Floats,  # noqa: ARG001
    row: int,  # noqa: ARG001
) -> tuple[Floats, Callable[[Floats, Floats], Floats]]:
    """Return x^2, and its derivative from those of x and v."""
    return x * x, lambda dx, dv: 2.0 * x[:, np.newaxis] * dx + 0.0 * dv


def _power(
    d: MovedMotion,
    t: Floats,
    x: Floats,  # noqa: ARG001
    v: Floats,
    row: int,
) -> tuple[Floats, Callable[[Floats, Floats], Floats]]:
    """Return the force per unit mass times v after an event, as `_square` does."""
    law, change = d.run.system.law, d.moved.change
    begin, low = d.run.record[0][row, [events_of.EVENT_T, events_of.EVENT_T_LOW]].tolist()
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    set_phases(law, begin, low, phases)
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
    drives += change.rows[:, 0, FORCING_CONSTANT]
    return forces * v, lambda dx, dv: (  # noqa: ARG005
        forces[:, np.newaxis] * dv + v[:, np.newaxis] * drives
    )
