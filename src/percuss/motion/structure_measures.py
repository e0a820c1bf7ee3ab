"""The derivatives of measures of a structure's run: of its extremes, means and shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.kernels import record as events_of
from percuss.kernels.sample import flight_at
from percuss.kernels.structure import sensitivity as engine
from percuss.kernels.structure.basis import QUICKEST
from percuss.kernels.structure.columns import unit_records
from percuss.kernels.structure.run import load_at
from percuss.kernels.structure.sample import tail_after
from percuss.model.exact import as_float
from percuss.model.oscillator import On, SoftStop, Wall
from percuss.motion.extremes import Extrema, QuantityName
from percuss.motion.moved_measures import MovedStretch, MovedValue, moved_measure, nodes_of
from percuss.motion.moved_structure_motion import MovedStructureMotion, scratch_of
from percuss.numerics import inverse, matmul, solve_linear


def structure_measure_and_derivative(
    d: MovedStructureMotion, measure: str, on: On | None = None, longer: Floats | None = None
) -> MovedValue:
    """Return a measure of a structure's run and its derivatives; see `StructureSensitivity.of`.

    ``longer`` are the derivatives of the run's end where it moves, as that of an orbit's period.
    """
    of_one = measure.endswith(("displacement", "acceleration"))
    direction = d.run.structure.direction(on) if of_one else np.zeros(d.run.structure.n)
    return moved_measure(_MeasuredStructure(d, direction, longer), measure)


@dataclass(frozen=True, slots=True)
class _MeasuredStructure:
    """A run of a structure with its derivative, as measures of y = c . x read it."""

    derivative: MovedStructureMotion
    direction: Floats
    longer: Floats | None

    @property
    def stops(self) -> Sequence[Wall | SoftStop]:
        return self.derivative.run.structure.stops

    @property
    def instants(self) -> tuple[Floats, Floats]:
        d = self.derivative
        instants, moved = (
            d.run.record.events[:, events_of.EVENT_T],
            d.columns.instants[:, engine.DT],
        )
        # A run that ends at an event ends with it, else at a fixed instant.
        last = np.zeros_like(moved[-1:]) if d.run.t_end > instants[-1] else moved[-1:]
        if self.longer is not None:
            last = self.longer[None]
        return np.append(instants, d.run.t_end), np.concatenate([moved, last])

    @property
    def in_contact(self) -> Flags:
        record = self.derivative.run.record
        return np.asarray(record.sets.keys[record.marks[:, events_of.NEXT_REGION]] != 0)

    def extremes(self, of: QuantityName, stop: int) -> Extrema:
        if of == "stop_force":
            return self.derivative.run.extremes(of, stop)
        return self.derivative.run.extremes(of, on=tuple(self.direction.tolist()))

    def values_at(self, of: QuantityName, stop: int, t: float) -> list[MovedValue]:
        d = self.derivative
        rows = np.flatnonzero(d.run.record.events[:, events_of.EVENT_T] == t)
        if len(rows) == 0:
            limits = [(t, True)]
            if _is_in_tail(d, t):
                # In a hop, which lasts no time, the structure moves as before the last impact.
                before = d.run.record.events[flight_at(d.run.record.events, t, True)]
                limits.append((float(before[events_of.EVENT_T]), False))
        else:
            limits = [(t, True)] if rows[0] == 0 else [(t, True), (t, False)]
        values = [_quantity(d, self.direction, (of, stop), side, self.longer) for side in limits]
        if of == "acceleration" and len(rows) and rows[0] > 0 and _ends_tail(d, int(rows[0])):
            values.append(_before_rest(d, self.direction, values[0], (rows[0] - 1, rows[-1])))
        return values

    def stretch(self, of: str, row: int, span: tuple[float, float]) -> MovedStretch:
        d, record = self.derivative, self.derivative.run.record
        b = int(record.marks[row, events_of.NEXT_REGION])
        t, w = nodes_of(span, float(record.sets.of_set[b, QUICKEST]))
        (x, v), (dx, dv) = d.run(t), d(t)
        ends = [d.run(span[0]), d.run(span[1], "before")]
        if (record.marks[row + 1 : row + 2, events_of.KIND] == events_of.CONTACT).any():
            # In the tail of a chatter hops are of no account: the wall holds in the mean.
            (x, v), (dx, dv) = _mean_motion(d, t)
            (first_x, last_x), (first_v, last_v) = _mean_motion(d, np.array(span))[0]
            ends = [(first_x, first_v), (last_x, last_v)]
        if of == "rms_displacement":
            c = self.direction
            y, dy = (x * c).sum(axis=-1), (dx * c[:, None]).sum(axis=1)
            values, moved = y * y, 2.0 * y[:, None] * dy
            first, last = (float((c * state[0]).sum()) ** 2 for state in ends)
        else:
            force, change = _loads(d, row, np.array([*t, *span]))
            values = (force[:-2] * v).sum(axis=-1)
            moved = (change[:-2] * v[..., None] + force[:-2, :, None] * dv).sum(axis=1)
            first, last = (
                float((push * state[1]).sum()) for push, state in zip(force[-2:], ends, strict=True)
            )
        total = float((w * values).sum())
        return MovedStretch(total, (w[:, None] * moved).sum(axis=0), first, last)

    def from_unit_mass(self, mean: MovedValue) -> MovedValue:
        return mean


def _is_in_tail(d: MovedStructureMotion, t: float) -> bool:
    """Return whether an instant lies in the summed tail of a chatter, which moves as one."""
    record = d.run.record
    return tail_after(record, flight_at(record.events, t, True)) > 0.0


def _ends_tail(d: MovedStructureMotion, row: int) -> bool:
    """Return whether an event is the rest in which the summed tail of a chatter ends."""
    return bool(tail_after(d.run.record, row - 1) > 0.0)


def _before_rest(
    d: MovedStructureMotion, c: Floats, held: MovedValue, rows: tuple[int, int]
) -> MovedValue:
    """Return the acceleration that ends a chatter, from that of the structure which rests then.

    They differ by what the walls that begin to hold push with, over the mass as far as other walls
    leave it free: by P c_s R for a reaction R, where dP = -P dM P.
    """
    record, structure = d.run.record, d.run.structure
    before, after = (
        int(record.sets.keys[record.marks[row, events_of.NEXT_REGION]]) for row in rows
    )
    kept, new = (
        [i for i, stop in enumerate(structure.stops) if isinstance(stop, Wall) and key >> i & 1]
        for key in (before, after & ~before)
    )
    t = float(record.events[rows[-1], events_of.EVENT_T])
    free = inverse(structure.mass_matrix)
    if kept:
        normals = structure.stop_directions[kept]
        along = matmul(free, normals.T)
        free = free - matmul(along, solve_linear(matmul(normals, along), along.T))
    value, moved = held
    to = matmul(free, c)
    for i in new:
        normal = structure.stop_directions[i]
        push, change = _quantity(d, c, ("stop_force", i), (t, True), None)
        yields = matmul(free, normal)
        value -= float(matmul(to, normal)) * push
        heavier = np.array([matmul(to, matmul(each, yields)) for each in d.moved.mass])
        moved = moved - matmul(to, normal) * change + heavier * push
    return value, np.asarray(moved)


def _quantity(
    d: MovedStructureMotion,
    c: Floats,
    which: tuple[str, int],
    side: tuple[float, bool],
    longer: Floats | None,
) -> MovedValue:
    """Return a quantity on one side of an instant, and its derivative along with an event there."""
    (of, stop), (t, after) = which, side
    run, record = d.run, d.run.record
    at_event = record.events[:, events_of.EVENT_T] == t
    rows = np.flatnonzero(at_event)
    late = np.zeros(len(d.paths))
    if len(rows):
        late = d.columns.instants[rows[-1] if after else rows[0], engine.DT]
    elif longer is not None and t == run.t_end:
        late = longer
    elif _is_in_tail(d, t):
        late = d.columns.instants[flight_at(record.events, t, True), engine.DT]
    orders, moved, force = _taylor(d, t, after, stop)
    # Along with the event: each order moves by the next one.
    moved = moved + orders[1:, :, None] * late
    if of in ("displacement", "acceleration"):
        order = 0 if of == "displacement" else 2
        return float((c * orders[order]).sum()), (c[:, None] * moved[order]).sum(axis=0)
    b = int(record.marks[flight_at(record.events, t, after), events_of.NEXT_REGION])
    if not int(record.sets.keys[b]) >> stop & 1:
        return 0.0, np.zeros(len(d.paths))
    acting, sign = run.structure.stops[stop], float(run.system.signs[stop])
    if not isinstance(acting, SoftStop):
        value, rate, column = force
        return sign * value, sign * (column + rate * late)
    c = run.structure.stop_directions[stop]
    (y, speed), (dy, faster) = (
        [(c * orders[k]).sum() for k in range(2)],
        [(c[:, None] * moved[k]).sum(axis=0) for k in range(2)],
    )
    away, stiffer, damped = d.moved.stops[:, stop].T
    depth = y - as_float(acting.at)
    value = -as_float(acting.stiffness) * depth - as_float(acting.damping) * speed
    column = -stiffer * depth - as_float(acting.stiffness) * (dy - away)
    column = column - damped * speed - as_float(acting.damping) * faster
    return float(value), np.asarray(column)


def _taylor(
    d: MovedStructureMotion, t: float, after: bool, stop: int
) -> tuple[Floats, Floats, tuple[float, float, Floats]]:
    """Return x and its first three derivatives, the columns of the first three of these.

    Shapes (4, n) and (3, n, n_parameters); and of the guard of a stop its value, its rate and its
    column.
    """
    varied = scratch_of(d.varied)
    _, work = engine.new_columns(varied)
    guard = np.zeros(2)
    b = engine.taylor_at(varied, d.columns, (t, after, stop), work, guard)
    sets, n = varied.run.sets, len(varied.run.begin)
    shape = sets.shape[b].reshape(2 * n, n).T
    orders, moved = np.zeros((4, n)), np.zeros((3, n, len(d.paths)))
    factorial = 1.0
    for k in range(4):
        factorial *= max(k, 1)
        orders[k] = factorial * matmul(shape, work.series.modes[k].reshape(-1))
        if k < 3:
            moved[k] = factorial * matmul(shape, work.series.columns[k].reshape(2 * n, -1))
    orders[0] += sets.offset[b]
    moved[0] += varied.moved.places[b]
    return orders, moved, (float(guard[0]), float(guard[1]), work.forces.copy())


def taylor_of(
    d: MovedStructureMotion, t: float, *, after: bool, stop: int
) -> tuple[Floats, Floats]:
    """Return x and its first three derivatives at an instant, and the columns of three of these.

    Parameters
    ----------
    d
        The derivative of a motion.
    t, after
        The instant, and on which side of an event there.
    stop
        The stop of the event.

    Returns
    -------
    (4, n) and (3, n, n_parameters) arrays
        The columns are those at a fixed time.
    """
    orders, moved, _ = _taylor(d, t, after, stop)
    return orders, moved


def _mean_motion(
    d: MovedStructureMotion, times: Floats
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return (x, v) and their columns in the mean of a chatter's tail."""
    series = [_taylor(d, float(t), True, d.run.structure.n)[:2] for t in times]
    x, v = (np.array([orders[k] for orders, _ in series]) for k in range(2))
    dx, dv = (np.array([moved[k] for _, moved in series]) for k in range(2))
    return (x, v), (dx, dv)


def _loads(d: MovedStructureMotion, row: int, times: Floats) -> tuple[Floats, Floats]:
    """Return the loads on the coordinates in the flight of an event, and their derivatives.

    Shapes (n_times, n) and (n_times, n, n_parameters).
    """
    system, varied = d.run.system, scratch_of(d.varied)
    run, n = varied.run, d.run.structure.n
    begin, low = run.events[row, [events_of.EVENT_T, events_of.EVENT_T_LOW]].tolist()
    load_at(run.sets, (begin, low), run.phases, run.records)
    records = run.records.copy()
    units = np.zeros_like(records)
    unit_records(varied.moved, begin, low, units)
    vectors = _load_vectors(d)
    changes = [np.moveaxis(np.array(part), 0, -1) for part in zip(*d.moved.loads, strict=True)]
    force, moved = np.zeros((len(times), n)), np.zeros((len(times), n, len(d.paths)))
    for i, t in enumerate(times.tolist()):
        load_at(run.sets, (t, 0.0), run.phases, run.records)
        force[i], moved[i] = vectors[0], changes[0]
        for k in range(system.shape[2]):
            parts = [run.phases[k, 0], run.phases[k, 1]]
            parts += [t * part for part in parts]
            for part, value in enumerate(parts):
                force[i] += vectors[1][k, part] * value if part < 2 else 0.0
                moved[i] += changes[1][k, part] * value
        for k in range(len(records)):
            value = records[k, 0] + records[k, 1] * (t - begin)
            force[i] += vectors[2][k] * value
            moved[i] += changes[2][k, 0] * value
            moved[i] += changes[2][k, 1] * (units[k, 0] + units[k, 1] * (t - begin))
            moved[i] += changes[2][k, 2] * (t * records[k, 1])
    return force, moved


def _load_vectors(d: MovedStructureMotion) -> tuple[Floats, Floats, Floats]:
    """Return the constant loads (n,), those of cosines and sines (m, 2, n), and records (r, n)."""
    system = d.run.system
    n, _, m, _ = system.shape
    directions = system.loads.directions(system.structure)
    constant, waves, records = np.zeros(n), np.zeros((m, 2, n)), []
    for c, force in zip(directions, system.loads.forcings, strict=True):
        constant += as_float(force.constant) * c
        for component in force.components():
            k = system.omegas.index(component.omega)
            waves[k] += np.stack([component.cos * c, component.sin * c])
        if force.record is not None:
            records.append(c)
    return constant, waves, np.array(records).reshape(len(records), n)
