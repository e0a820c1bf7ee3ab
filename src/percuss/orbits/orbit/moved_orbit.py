"""The derivative of a periodic orbit by parameters, from that of one period of its motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Complexes, Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels import record as columns
from percuss.kernels import sensitivity as engine
from percuss.kernels.flight import (
    Flight,
    constant_force,
    force_and_slopes,
    free_response,
    set_phases,
)
from percuss.kernels.flight_columns import (
    MOST_TERMS,
    Change,
    moved_constant_force,
    moved_drive,
    response_to_motion,
)
from percuss.kernels.law_columns import (
    DAMPING,
    N_HARMONICS,
    STIFFNESS,
)
from percuss.kernels.pieces import is_record, record_before
from percuss.kernels.record import MotionRecord, place_of_event, time_since_event
from percuss.kernels.restitution import kept_of_error, restitution_at
from percuss.kernels.tangent import event_saltation, propagator
from percuss.motion.accelerations import phases_at
from percuss.motion.moved_measures import MovedMeasure, MovedValue
from percuss.motion.moved_motion import MovedImpacts, workspace_of
from percuss.motion.oscillator_measures import measure_and_derivative
from percuss.motion.sensitivity import Sensitivity, sensitivity_of, slowing_of
from percuss.motion.tables import Impacts
from percuss.motion.trajectory import Trajectory
from percuss.numerics import matmul, solve_linear
from percuss.orbits.orbit.moved_monodromy import moved_kept

# Two multipliers whose distance is below this part of them are equal to rounding.
EQUAL = 1e-7
# A multiplier this near to 1 is there: the orbit is on a fold, or one of a family.
ON_FOLD = 1e-9


class ClosedMotion(NamedTuple):
    """A `PeriodicOrbit` as its derivative reads it; ``run`` is one period of its motion."""

    run: Trajectory
    impacts: Impacts
    period: float
    n_periods: int
    monodromy: Floats
    multipliers: Complexes
    isolated: bool


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OrbitSensitivity:
    """The derivative of a periodic orbit by parameters; made by `PeriodicOrbit.sensitivity`.

    Called with times in the period after t0, it gives the derivatives of x and v there.

    Attributes
    ----------
    paths
        The parameters, in their long form; the last axis of all arrays.
    x0, v0, t0, period
        (n_parameters,) arrays, of the orbit's fields of the same names. A forced orbit keeps its
        number of forcing periods; the cycle of free motion keeps its t0.
    impacts
        Those of the orbit's impacts, `t`, `v_before` and `v_after`.
    multipliers
        (2, n_parameters) complex array; NaN where two are equal, and with tables of restitution.
    motion
        That of one period of its motion.
    """

    paths: tuple[str, ...]
    x0: Floats
    v0: Floats
    t0: Floats
    period: Floats
    impacts: MovedImpacts
    multipliers: Complexes
    motion: Sensitivity

    def __repr__(self) -> str:
        """Return what it is the derivative by, in a line."""
        return f"<OrbitSensitivity: by {', '.join(self.paths)}>"

    def __call__(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return the derivatives of x and v at times t in the first period, which stay."""
        return self.motion(t)

    def of(self, measure: MovedMeasure) -> Floats:
        """Return the derivative of a measure of one period; see `Sensitivity.of`."""
        return self.measured(measure)[1]

    def measured(self, measure: str) -> MovedValue:
        """Return a measure of one period and its derivatives: the end moves with the period."""
        return measure_and_derivative(self.motion, measure, self.t0 + self.period)


def sensitivity_of_orbit(orbit: ClosedMotion, paths: Sequence[str]) -> OrbitSensitivity:
    """Return the derivative of an orbit by parameters; see `PeriodicOrbit.sensitivity`."""
    run = orbit.run
    still = sensitivity_of(run, paths, np.zeros((len(paths), 3)))
    if not still.differentiable:
        refuse_derivative(still.reason)
    period = np.zeros(len(still.paths))
    if orbit.n_periods:
        slower = slowing_of(still)
        refuse_frequency_alone(slower, still.paths)
        period = orbit.period * slower
    if len(orbit.impacts):
        begin, period = _moved_impact(orbit, still, period)
    else:
        begin = _moved_state(orbit, still, period)
    motion = sensitivity_of(run, paths, begin)
    return OrbitSensitivity(
        paths=motion.paths,
        x0=begin[:, 0],
        v0=begin[:, 1],
        t0=begin[:, 2],
        period=period,
        impacts=_impacts(orbit, motion),
        multipliers=_multipliers(orbit, motion, period),
        motion=motion,
    )


def _moved_impact(orbit: ClosedMotion, still: Sensitivity, period: Floats) -> tuple[Floats, Floats]:
    """Return the derivatives of (x, v, t) at the impact at which an orbit starts, and the period's.

    By the map from it to itself a period later: with its derivative A by the instant and the
    velocity, and c that by the parameters, (1 - A) (dt, dv) = c - (dT, 0). Free motion keeps its
    instant, and dT is an unknown in place of dt.
    """
    run, paths = orbit.run, still.paths
    wall = still.columns[-1][:, engine.BASE]
    held = np.column_stack([wall, np.zeros((len(paths), 2))])
    by_path = sensitivity_of(run, paths, held).columns[-1][:, [engine.DT, engine.DV_AFTER]]
    matrix = np.eye(2) - _map_of_impact(still)
    if orbit.n_periods:
        late, faster = _solved(orbit, matrix, by_path - np.outer(period, [1.0, 0.0])).T
        return np.column_stack([wall, faster, late]), period
    matrix[:, 0] = 1.0, 0.0
    period, faster = _solved(orbit, matrix, by_path).T
    return np.column_stack([wall, faster, np.zeros(len(paths))]), period


def _map_of_impact(still: Sensitivity) -> Floats:
    """Return the derivative of the last impact's instant and velocity by those of the start."""
    rows, unit = still.varied.change
    unmoved = Change(np.zeros((2, *rows.shape[1:])), unit)
    varied = still.varied._replace(change=unmoved, jumps=np.empty((0, 2)))
    out = np.empty((len(still.columns), 2, engine.SENSITIVITY_COLUMNS))
    work = workspace_of(varied.record.law, 2)
    engine.carry(varied, np.eye(3)[[engine.BEGIN_T, engine.BEGIN_V]], work, out)
    moved: Floats = out[-1][:, [engine.DT, engine.DV_AFTER]].T
    return moved


def _moved_state(orbit: ClosedMotion, still: Sensitivity, period: Floats) -> Floats:
    """Return the derivatives of (x, v, t) at the start of an orbit without impacts.

    With M the monodromy and c the column of a period from a fixed start, the column w of the
    state at t0 obeys w = M w + c + z' dT.
    """
    end = np.stack(still(orbit.run.t_end, limit="before"), axis=-1)
    right = end + period[:, np.newaxis] * _rate(orbit)
    state = _solved(orbit, np.eye(2) - orbit.monodromy, right)
    return np.column_stack([state, np.zeros(len(state))])


def refuse_derivative(reason: str) -> NoReturn:
    """Raise the error of an orbit that has no derivative."""
    advice = f"{reason}; take it at another value of a parameter"
    raise ConvergenceError("the orbit has no derivative", None, math.nan, advice)


def _rate(orbit: ClosedMotion) -> Floats:
    """Return the velocity and the acceleration at the end of a period without impacts.

    Where a forcing jumps there, they are those before the jump.
    """
    law, (_, marks) = orbit.run.system.law, orbit.run.record
    region = int(marks[0, columns.NEXT_REGION])
    phases = phases_at(law, orbit.run.t0)
    n = len(phases)
    if n > 0 and is_record(law, n - 1):
        phases[-1] = record_before(law, orbit.run.t_end, -float(np.spacing(orbit.run.t_end)))
    force = constant_force(law, region, orbit.run.x0) + force_and_slopes(law, phases)[0]
    return np.array([orbit.run.v0, force - 2.0 * law[region, DAMPING] * orbit.run.v0])


def refuse_frequency_alone(slower: Floats, paths: Sequence[str]) -> None:
    """Raise ParameterError where a parameter leaves the forces without a period."""
    for path in np.array(paths)[np.isnan(slower)].tolist():
        reason = "moved alone it leaves the forcing without a period; tie the frequencies"
        raise ParameterError("paths", path, reason)


def _solved(orbit: ClosedMotion, matrix: Floats, right: Floats) -> Floats:
    """Return the solution of two equations for each of the (n, 2) right-hand sides."""
    near = np.abs(orbit.multipliers - 1.0) < ON_FOLD
    if near.sum() > (0 if orbit.n_periods else 1) or not orbit.isolated:
        refuse_derivative("it is on a fold, or one of a family")
    return np.stack([np.asarray(solve_linear(matrix, row)) for row in right])


def _impacts(orbit: ClosedMotion, motion: Sensitivity) -> MovedImpacts:
    """Return the derivatives of the orbit's impacts, the first one at its start."""
    events, marks = motion.run.record
    kinds = marks[:, columns.KIND]
    met = np.flatnonzero((kinds == columns.IMPACT) | (kinds == columns.CROSSING))
    # The last event is the first one again; a crossing out of a soft stop is no impact of the
    # orbit.
    instants = events[met, columns.EVENT_T]
    speeds = events[met, columns.V_AFTER]
    rows, at = [], []
    for k in range(len(orbit.impacts)):
        if k == 0:
            rows.append(len(events) - 1)
            at.append(0)
            continue
        t, v = float(orbit.impacts.t[k]), float(orbit.impacts.v_after[k])
        nearest = int(met[np.argmin(np.abs(instants - t) + np.abs(speeds - v))])
        rows.append(nearest)
        at.append(nearest)
    derivatives = motion.columns
    return MovedImpacts(
        derivatives[at, :, engine.DT],
        derivatives[rows, :, engine.DV_BEFORE],
        derivatives[rows, :, engine.DV_AFTER],
    )


def _multipliers(orbit: ClosedMotion, motion: Sensitivity, period: Floats) -> Complexes:
    """Return the derivatives of the multipliers."""
    if not orbit.monodromy.any():
        return np.zeros((2, len(motion.paths)), dtype=np.complex128)
    derivatives = np.empty((2, len(motion.paths)), dtype=np.complex128)
    for p in range(len(motion.paths)):
        # Without impacts the period ends in a flight, after the last of the forcing's knots.
        free_end = None if len(orbit.impacts) else float(period[p])
        matrix, moved, relative = _moved_monodromy(motion, p, free_end)
        determinant = complex(np.prod(orbit.multipliers))
        trace, moved_trace = float(np.trace(matrix)), float(np.trace(moved))
        for i, value in enumerate(orbit.multipliers):
            if not orbit.n_periods:
                derivatives[i, p] = 0.0 if abs(value - 1.0) < ON_FOLD else relative * value
                continue
            apart = 2.0 * value - trace
            change = value * moved_trace - relative * determinant
            derivatives[i, p] = change / apart if abs(apart) > EQUAL * abs(value) else np.nan
    return derivatives


def _moved_monodromy(
    motion: Sensitivity, p: int, free_end: float | None
) -> tuple[Floats, Floats, float]:
    """Return the monodromy of a period, its derivative, and that of its determinant's logarithm.

    `free_end` is the derivative of the end of a period that ends without an event.
    """
    law, (events, marks) = motion.run.system.law, motion.run.record
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    matrix, moved, relative = np.eye(2), np.zeros((2, 2)), 0.0
    last = len(events)
    for n in range(1, last + (free_end is not None)):
        region = int(marks[n - 1, columns.NEXT_REGION])
        if n < last:
            s, end = time_since_event(events, n), float(motion.columns[n, p, engine.DT])
        else:
            s, end = motion.run.t_end - float(events[-1, columns.EVENT_T]), free_end or 0.0
        longer = end - float(motion.columns[n - 1, p, engine.DT])
        own, change = _moved_propagator(motion, p, region, s, longer)
        rows = motion.moved.change.rows[p]
        relative -= 2.0 * (rows[region, DAMPING] * s + law[region, DAMPING] * longer)
        matrix, moved = matmul(own, matrix), matmul(change, matrix) + matmul(own, moved)
        if n == last:
            break
        event = (int(marks[n, columns.KIND]), int(marks[n, columns.BOUND]), region,
                 int(marks[n, columns.NEXT_REGION]))  # fmt: skip
        instant = float(events[n, columns.EVENT_T]), float(events[n, columns.EVENT_T_LOW])
        v = float(events[n, columns.V_BEFORE])
        jump = np.reshape(event_saltation(law, event, instant, v, phases), (2, 2))
        change, of_jump = _moved_saltation(motion, p, n, phases)
        relative += of_jump
        matrix, moved = matmul(jump, matrix), matmul(change, matrix) + matmul(jump, moved)
    return matrix, moved, relative


def _moved_propagator(
    motion: Sensitivity, p: int, region: int, s: float, longer: float
) -> tuple[Floats, Floats]:
    """Return the propagator of a flight and its derivative."""
    law, rows = motion.run.system.law, motion.moved.change.rows[p]
    damping, stiffness = law[region, DAMPING], law[region, STIFFNESS]
    stiffer, damped = rows[region, STIFFNESS], 2.0 * rows[region, DAMPING]
    own = np.reshape(propagator(law, region, s), (2, 2))
    impulse = free_response(law, region, s)[0]
    nothing = np.empty((0, 2))
    flight = Flight(law, region, (0.0, 0.0, 1.0, 0.0), nothing, nothing)
    twice, rate, bend = response_to_motion(flight, s, np.zeros(MOST_TERMS))
    moved = -stiffer * twice - damped * rate
    moved_rate = -stiffer * rate - damped * bend
    change = np.array(
        [
            [moved_rate + 2.0 * damping * moved + damped * impulse, moved],
            [-stiffer * impulse - stiffness * moved, moved_rate],
        ]
    )
    equation = np.array([[0.0, 1.0], [-stiffness, -2.0 * damping]])
    return own, change + longer * matmul(equation, own)


def _moved_saltation(motion: Sensitivity, p: int, n: int, phases: Floats) -> tuple[Floats, float]:
    """Return the derivative of an event's saltation matrix, and of its determinant's logarithm."""
    law, (events, marks) = motion.run.system.law, motion.run.record
    rows, unit = motion.moved.change
    rows = rows[p]
    before, after = (int(marks[i, columns.NEXT_REGION]) for i in (n - 1, n))
    kind, bound = marks[n, columns.KIND], int(marks[n, columns.BOUND])
    if kind == columns.CROSSING:
        jump = 2.0 * (rows[before, DAMPING] - rows[after, DAMPING])
        return np.array([[0.0, 0.0], [jump, 0.0]]), 0.0
    if kind != columns.IMPACT:
        return np.zeros((2, 2)), 0.0
    v, column = float(events[n, columns.V_BEFORE]), motion.columns[n, p]
    t, t_low = float(events[n, columns.EVENT_T]), float(events[n, columns.EVENT_T_LOW])
    set_phases(law, t, t_low, phases)
    drive, slope, _ = force_and_slopes(law, phases)
    record = MotionRecord(law, motion.run.x0, events, marks)
    x = place_of_event(record, n)
    force = constant_force(law, before, x) + drive
    moved = moved_drive(law, rows, unit, t, t_low, phases)[0] + slope * column[engine.DT]
    moved += moved_constant_force(law, rows, before, x, column[engine.BASE])
    faster = float(column[engine.DV_BEFORE])
    speed, faster_speed = abs(v), math.copysign(1.0, v) * faster
    r, kept = (of(law, before, bound, speed) for of in (restitution_at, kept_of_error))
    lossy = engine.moved_restitution(law, rows, before, bound, speed)
    lossy += (kept - r) / speed * faster_speed
    bent = moved_kept(law, rows, (before, bound), speed, faster_speed)
    across = bent * force / v + (1.0 + kept) * (moved - force * faster / v) / v
    across += 2.0 * (rows[before, DAMPING] * (r - kept) + law[before, DAMPING] * (lossy - bent))
    return np.array([[-lossy, 0.0], [across, -bent]]), lossy / r + bent / kept if r else 0.0
