"""From the solution of a chain's equations to the orbit as a value."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import later
from percuss.kernels.flight import Flight, constant_force, move, place, set_phases
from percuss.kernels.law import DAMPING, N_HARMONICS, PERIOD, Law, Table
from percuss.kernels.sample import cycles
from percuss.kernels.shooting import AFTER, AT, BEFORE, factor
from percuss.kernels.tangent import neighbours
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.motion.tables import Impacts
from percuss.numerics import dot, exp, matmul
from percuss.orbits.orbit.itinerary import entries_of, events_of_record, is_wall
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.passages import margin_of, passages_of, turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of, stability_of

__all__ = ["impacts_of_record", "orbit_of_solution"]


def orbit_of_solution(
    osc: Oscillator,
    force: Forcing | None,
    chain: Integers,
    solution: Solution,
    n_periods: int,
) -> PeriodicOrbit:
    """Return the orbit that solves the equations of a chain.

    Parameters
    ----------
    osc, force
        What moves.
    chain
        (n, 3) array, the events; the first one meets a stop.
    solution
        What `solve` found for it.
    n_periods
        How many forcing periods it lasts; 0 where there is none.

    Returns
    -------
    PeriodicOrbit
        Admissible or not.
    """
    table = law(osc, force)
    unknowns = _in_first_period(table, solution.unknowns)
    n = len(chain)
    period = float(unknowns[1 : 1 + n].sum())
    if n_periods:
        period = n_periods * float(table[0, PERIOD])
    events, marks = _record(table, chain, unknowns)
    x0 = place(table, int(chain[0, AFTER]), int(chain[0, AT]))
    monodromy = _monodromy(table, events, marks)
    determinant, conservative = determinant_of(table, chain, unknowns[1 : 1 + n])
    turns = turns_of(table, events, marks, x0, float(events[-1, columns.EVENT_T]))
    impacts = impacts_of_record(osc, table, events, marks)
    passages = passages_of(osc, turns)
    return PeriodicOrbit(
        oscillator=osc,
        forcing=force,
        x0=x0,
        v0=float(unknowns[1 + n]),
        t0=float(unknowns[0]),
        impacts=impacts,
        n_impacts=len(impacts),
        n_periods=n_periods,
        period=period,
        monodromy=monodromy,
        multipliers=multipliers_of(monodromy, determinant),
        stability=stability_of(monodromy, determinant, conservative=conservative),
        # A flight that lasts less than no time solves the equations formally, too.
        admissible=len(passages) == 0 and not (unknowns[1 : 1 + n] < 0.0).any(),
        grazing_margin=margin_of(turns),
        passages=passages,
        min_impact_speed=float(np.abs(impacts.v_before).min()),
        isolated=solution.isolated,
        residual=solution.residual,
        _events=events,
        _marks=marks,
        _chain=chain,
        _unknowns=unknowns,
    )


def determinant_of(table: Law, chain: Integers, durations: Floats) -> tuple[float, bool]:
    """Return the determinant of the monodromy matrix, and whether it is 1 by construction.

    It is the product of r^2 over the impacts times exp(-2 integral of the damping).
    """
    factors = [factor(table, int(row[BEFORE]), int(row[AT])) for row in chain]
    dampings = table[chain[:, AFTER], DAMPING]
    conservative = all(abs(value) == 1.0 for value in factors) and not dampings.any()
    decay = exp(-2.0 * dot(dampings, durations))
    return float(np.prod(np.square(factors))) * decay, conservative


def _in_first_period(table: Law, unknowns: Floats) -> Floats:
    """Return the unknowns with event 0 in the first forcing period."""
    period = float(table[0, PERIOD])
    if period == 0.0:
        return unknowns
    moved = unknowns.copy()
    moved[0] -= period * math.floor(moved[0] / period)
    if moved[0] >= period:
        moved[0] = 0.0
    return moved


def _record(table: Law, chain: Integers, unknowns: Floats) -> tuple[Table, Integers]:
    """Return the record that `march` would have written, from the first event to it again."""
    n = len(chain)
    phases, arrival = (np.empty((int(table[0, N_HARMONICS]), 2)) for _ in range(2))
    events = np.zeros((n + 1, columns.EVENT_COLUMNS))
    marks = np.empty((n + 1, columns.MARK_COLUMNS), dtype=np.int64)
    walls = is_wall(table, chain)
    t, t_low = float(unknowns[0]), 0.0
    v = float(unknowns[1 + n])
    events[0] = t, t_low, v, v
    marks[0] = columns.START, -1, chain[0, AFTER]
    for i in range(n):
        following = (i + 1) % n
        region = int(chain[i, AFTER])
        force = constant_force(table, region, place(table, region, int(chain[i, AT])))
        set_phases(table, t, t_low, phases)
        s = float(unknowns[1 + i])
        _, before = move(Flight(table, region, (t, t_low, v, force), phases, arrival), s)
        t, t_low = later(t, t_low, s)
        v = float(unknowns[1 + n + following])
        events[i + 1] = t, t_low, before, v
        kind = columns.IMPACT if walls[following] else columns.CROSSING
        marks[i + 1] = kind, chain[following, AT], chain[following, AFTER]
    return events, marks


def _monodromy(table: Law, events: Table, marks: Integers) -> Floats:
    out, whole = np.empty((1, 4)), np.eye(2)
    phases = np.empty((int(table[0, N_HARMONICS]), 2))
    flights = [slice(0, len(events))]
    if (np.diff(events[:, columns.EVENT_T]) < 0.0).any():
        # A formal flight goes back in time: a record in order of time has none.
        flights = [slice(i, i + 2) for i in range(len(events) - 1)]
    for flight in flights:
        end = events[flight][-1:, columns.EVENT_T].copy()
        record = columns.MotionRecord(table, 0.0, events[flight], marks[flight])
        neighbours(record, end, True, phases, out)
        # NaN where an impact has no speed.
        with np.errstate(invalid="ignore"):
            whole = matmul(out.reshape(2, 2), whole)
    return whole


def impacts_of_record(osc: Oscillator, table: Law, events: Table, marks: Integers) -> Impacts:
    """Return the impacts of one period, entries into soft stops among them.

    Parameters
    ----------
    osc
        The oscillator.
    table
        Its law.
    events, marks
        A record whose START is just after an impact and whose last event is that impact again.

    Returns
    -------
    Impacts
        The one at the START first.
    """
    kinds = marks[:, columns.KIND]
    chain = events_of_record(marks)
    met = {
        i + 1: stop
        for i, stop in entries_of(osc, table, chain)
        if kinds[i + 1] in (columns.IMPACT, columns.CROSSING)
    }
    last = len(events) - 1
    rows = [last, *(i for i in met if i != last)]
    instants = [0, *rows[1:]]
    t = events[instants, columns.EVENT_T].copy()
    t_low = events[instants, columns.EVENT_T_LOW].copy()
    cycle = np.full(len(rows), np.nan)
    if table[0, PERIOD] > 0.0:
        cycles(table, t, t_low, cycle)
    before = np.roll(t, 1)
    before[0] -= events[last, columns.EVENT_T] - events[0, columns.EVENT_T]
    return Impacts(
        t=t,
        v_before=events[rows, columns.V_BEFORE].copy(),
        v_after=events[rows, columns.V_AFTER].copy(),
        stop=np.array([met[i] for i in rows], dtype=np.int64),
        cycle=cycle,
        intervals=t - before,
    )
