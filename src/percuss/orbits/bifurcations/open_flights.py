"""Flights of a structure that pass through walls, the motions made of them, and where these touch.

The structure is opened: its walls are left out, and what happens at an impact is written between
two flights. Such motions are formal where a flight is beyond a wall on its way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.record import (
    BOUND,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    KNOT,
    N_EVENTS,
    NEXT_REGION,
    START,
    V_AFTER,
    V_BEFORE,
)
from percuss.kernels.restitution import kept_of_error, restitution_at
from percuss.kernels.structure.basis import wall_of
from percuss.kernels.structure.run import StructureRun, new_run
from percuss.kernels.structure.sensitivity import rates_at
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.faults import draft, field_values
from percuss.model.oscillator import SoftStop, Wall
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.follow_structure import followed
from percuss.motion.moved_structure_motion import scratch_run
from percuss.motion.structure_observables import observable_at, turning_points_of_run
from percuss.motion.structure_sensitivity import structure_sensitivity_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.numerics import dot, matmul, solve_linear
from percuss.orbits.orbit.over_period import states_over_period
from percuss.orbits.orbit.structure_orbit import (
    MOST_EVENTS,
    StructureOrbit,
    map_between,
)

# The events of orbits that neither stick nor land at rest.
IN_TURN = (START, IMPACT, CROSSING, KNOT)
# Parts of the period: impacts nearer than the first come at one instant; instants of a motion and
# of its formal double differ by less than the second.
APART, ALIKE = 1e-9, 1e-6
# The part of an orbit's largest speed below which it turns at the seam of its period: by the square
# of it clearances next to a turn differ.
SEAM = 1e-7
# Speeds below this part of the unit are none at a graze.
SLOW = 1e-5
# How paths begin whose parameters move flights, and no impact.
OF_FLIGHTS = ("loads.", "structure.stiffness.", "structure.damping.")
# How long a flight lasts, in words.
UNTIL = "until its next impact"
# Clearances below this part of the unit of length are rounding.
ROUNDED = 1e-12


class OpenFlight(NamedTuple):
    """A flight that passes through walls.

    ``start`` and ``image`` are the states (x, v), (2 n,), at its instants; ``derivative`` that of
    the second by the first, and ``before``, ``after`` their rates of change.
    """

    begin: float
    end: float
    start: Floats
    image: Floats
    derivative: Floats
    after: Floats
    before: Floats
    record: StructureRun


class StructureGraze(NamedTuple):
    """A stop that an orbit touches at an instant without velocity."""

    stop: int
    t: float


class MetStop(NamedTuple):
    """A stop as an impact has it: its clearance is normal . x - level; a jump goes along kick.

    A stop that is only touched has no law.
    """

    normal: Floats
    level: float
    kick: Floats
    law: Floats | None
    place: tuple[int, int]

    def restitution(self, speed: float) -> tuple[float, float]:
        """Return the restitution at a speed, and the derivative of the speed that is kept."""
        if self.law is None:
            # A velocity that is turned into its opposite, and that once more: it stays.
            return -1.0, -1.0
        real = max(speed, 0.0)
        return (
            float(restitution_at(self.law, *self.place, real)),
            float(kept_of_error(self.law, *self.place, real)),
        )


@lru_cache(128)
def met_at(system: StructureSystem, stop: int) -> MetStop:
    """Return a stop of a structure as an impact has it."""
    structure = system.structure
    sign, c = float(system.signs[stop]), structure.stop_directions[stop]
    along = solve_linear(structure.mass_matrix, c)
    own = structure.stops[stop]
    is_wall = isinstance(own, Wall)
    return MetStop(
        sign * c,
        sign * as_float(own.at),
        sign * along / float((c * along).sum()),
        system.sets.walls[stop] if is_wall else None,
        wall_of(system.sets, stop) if is_wall else (0, 0),
    )


def without_walls(system: StructureSystem, grazed: int) -> StructureSystem:
    """Return the same structure without its walls, and without another stop."""
    structure = system.structure
    soft = tuple(structure.stops[i] for i in soft_stops(system, grazed))
    opened = draft(Structure, **field_values(structure) | {"stops": soft})
    return StructureSystem.of(opened, system.loads)


def soft_stops(system: StructureSystem, grazed: int) -> list[int]:
    """Return the numbers of the soft stops that an opened structure keeps."""
    stops = enumerate(system.structure.stops)
    return [i for i, stop in stops if isinstance(stop, SoftStop) and i != grazed]


def open_flight(opened: StructureSystem, start: Floats, begin: float, end: float) -> OpenFlight:
    """Return a flight of a structure without walls.

    Raises
    ------
    ConvergenceError
        If it lasts no time, or does not end.
    """
    n = len(start) // 2
    if not end > begin:
        raise ConvergenceError("two impacts change their order", start, math.nan, "")
    period = opened.period or 0.0
    shift = math.floor(begin / period) * period
    first, last = begin - shift, end - shift
    image, derivative, record = map_between(opened, start, (first, last), UNTIL)
    after, before = np.empty((2, n)), np.empty((2, n))
    rates_at(record, first, True, after)
    rates_at(record, last, True, before)
    return OpenFlight(
        begin,
        end,
        start,
        image,
        derivative,
        after.reshape(-1),
        before.reshape(-1),
        record,
    )


def paths_of_flights(paths: Sequence[str], soft: Sequence[int]) -> tuple[str, ...] | None:
    """Return paths of parameters in the structure without walls, None if they move walls too.

    It keeps the soft stops with the given numbers.
    """
    within = []
    for path in paths:
        own = path
        if path.startswith("structure.stops."):
            _, _, stop, *rest = path.split(".")
            if int(stop) not in soft:
                return None
            own = ".".join(["structure.stops", str(soft.index(int(stop))), *rest])
        elif not path.startswith(OF_FLIGHTS):
            return None
        within.append(own)
    return tuple(within)


def moved_end(
    opened: StructureSystem,
    flight: OpenFlight,
    paths: Sequence[str],
    start: Floats,
    slower: Floats,
) -> Floats | None:
    """Return the derivatives of a flight's end from those of its start, both (2 n, n_parameters).

    Its instants stay where they are in the period of the loads, whose logarithm's derivatives are
    given. None where it has no derivative.
    """
    n, record = len(start) // 2, flight.record
    period = opened.period or 0.0
    shift = math.floor(flight.begin / period) * period
    first, last = flight.begin - shift, flight.end - shift
    begin = StructureStart(flight.start[:n].tolist(), flight.start[n:].tolist(), first)
    run = StructureTrajectory.of_run(opened, begin, record, last, Outcome.reached_t_end)
    moved = structure_sensitivity_of(run, paths, np.vstack([start, first * slower]))
    if not moved.differentiable:
        return None
    end = np.concatenate(moved(last, limit="before")) + flight.before[:, None] * last * slower
    return end if np.isfinite(end).all() else None


def state_at_zero(opened: StructureSystem, flights: Sequence[OpenFlight], period: float) -> Floats:
    """Return the state at whole periods, at which one of the flights passes."""
    for flight in flights:
        whole = math.ceil(flight.begin / period) * period
        if flight.begin < whole < flight.end:
            return open_flight(opened, flight.start, flight.begin, whole).image
    # An impact at this very instant: the state after it.
    return min(
        flights,
        key=lambda candidate: abs(candidate.begin / period - round(candidate.begin / period)),
    ).start


def whole_record(
    system: StructureSystem,
    without: tuple[StructureSystem, Sequence[int]],
    state: Floats,
    passage: Sequence[tuple[float, int]],
    period: float,
) -> tuple[StructureRun, Floats]:
    """Return the record of a motion over a period that meets walls at given instants, and its end.

    The opened structure comes with the numbers that its stops have among all.
    """
    opened, soft = without
    n, here, begin = len(state) // 2, state, 0.0
    parts: list[StructureRun] = []
    struck: list[tuple[int, float, float]] = []
    for end, stop in [*passage, (period, -1)]:
        if not end > begin:
            if not parts:
                continue
            raise ConvergenceError("two impacts change their order", here, math.nan, "")
        # From its own instant, in whichever period of the loads: the record is that of a run.
        here, _, record = map_between(opened, here, (begin, end), UNTIL, derivative=False)
        parts.append(record)
        begin = end
        if stop < 0:
            break
        wall = met_at(system, stop)
        speed = -float((wall.normal * here[n:]).sum())
        rebound = wall.restitution(speed)[0] * speed
        here = here.copy()
        here[n:] += (speed + rebound) * wall.kick
        struck.append((stop, -speed, rebound))
    events, marks, states, sets = [], [], [], []
    for k, record in enumerate(parts):
        own = record.marks.copy()
        bounds = own[:, BOUND]
        own[:, BOUND] = [soft[i] if 0 <= i < len(soft) else i for i in bounds.tolist()]
        keys = [_widened(int(record.sets.keys[b]), soft) for b in own[:, NEXT_REGION].tolist()]
        row = record.events.copy()
        if k:
            stop, before, after = struck[k - 1]
            own[0, KIND], own[0, BOUND] = IMPACT, stop
            row[0, V_BEFORE], row[0, V_AFTER] = before, after
        events.append(row)
        marks.append(own)
        states.append(record.states)
        sets.append(keys)
    for own, keys in zip(marks, sets, strict=True):
        own[:, NEXT_REGION] = system.numbers_of(keys)
    whole = new_run(system.sets, 1)._replace(
        events=np.concatenate(events), marks=np.concatenate(marks), states=np.concatenate(states)
    )
    whole.counters[N_EVENTS] = len(whole.events)
    return whole, here


def _widened(key: int, soft: Sequence[int]) -> int:
    """Return the bits of a set with the numbers that soft stops have among all."""
    return sum(1 << i for k, i in enumerate(soft) if key >> k & 1)


def is_motion(
    system: StructureSystem,
    state: Floats,
    passage: Sequence[tuple[float, int]],
    period: float,
    slow: float,
) -> bool:
    """Return whether the structure with its walls has the impacts of a formal motion, and no other.

    Impacts at lower speeds than ``slow`` count as none.
    """
    n = len(state) // 2
    for stop, wall in enumerate(system.structure.stops):
        if isinstance(wall, Wall):
            own = met_at(system, stop)
            gap = float((own.normal * state[:n]).sum()) - own.level
            if gap < -ROUNDED * max(1.0, float(np.abs(state[:n]).max())):
                return False
    record, outcome = followed(system, (state[:n], state[n:], 0.0), period, MOST_EVENTS)
    if outcome is not Outcome.reached_t_end:
        return False
    kinds = record.marks[:, KIND]
    if not np.isin(kinds, IN_TURN).all():
        return False
    struck = np.flatnonzero((kinds == IMPACT) & (np.abs(record.events[:, V_BEFORE]) > slow))
    t = record.events[struck, EVENT_T] + record.events[struck, EVENT_T_LOW]
    inner = [(at, stop) for at, stop in passage if APART < at / period < 1.0 - APART]
    met = [
        (at, stop)
        for at, stop in zip(t.tolist(), record.marks[struck, BOUND].tolist(), strict=True)
        if APART < at / period < 1.0 - APART
    ]
    return len(met) == len(inner) and all(
        a[1] == b[1] and abs(a[0] - b[0]) < ALIKE * period for a, b in zip(met, inner, strict=True)
    )


def least_clearance(orbit: StructureOrbit) -> float:
    """Return the least clearance to a wall at which the structure turns between impacts."""
    walls = [i for i, stop in enumerate(orbit.structure.stops) if isinstance(stop, Wall)]
    return _turns(orbit, walls)[0]


def _turns(orbit: StructureOrbit, stops: Sequence[int]) -> tuple[float, StructureGraze | None]:
    """Return the least clearance to one of some stops at which the structure turns, and where."""
    least, place = math.inf, None
    for stop in stops:
        for t, gap in _turns_before(orbit, stop):
            if gap < least:
                least, place = gap, StructureGraze(stop, t)
    return least, place


def _turns_before(orbit: StructureOrbit, stop: int) -> list[tuple[float, float]]:
    """Return the instants at which a structure turns before a stop, and its clearances there.

    At an impact of negative velocity, which is formal, it comes from behind the wall and goes back
    there: its turns next to it belong to the impact.
    """
    run, met = orbit.run, met_at(orbit.run.system, stop)
    instants, period, sign = run.impacts.t, run.t_end, float(run.system.signs[stop])
    record = scratch_run(run.record)
    turns = turning_points_of_run(record, met.normal, period)
    turns = turns[turns[:, 2] > 0.0]
    x, v = states_over_period(orbit)
    speeds = matmul(v, met.normal)
    if abs(speeds[0]) <= SEAM * float(np.abs(speeds).max()):
        # A turn at the seam of the period itself is neither after its start nor before its end.
        on, start = orbit.structure.stops[stop].on, np.zeros(1)
        rise = sign * float(observable_at(run.system, record, start, "acceleration", on=on)[0])
        if rise > 0.0:
            turns = np.vstack([turns, [0.0, dot(met.normal, x[0]), rise]])
    if len(instants):
        apart = np.abs(turns[:, :1] - instants)
        turns = turns[np.minimum(apart, period - apart).min(axis=1) > APART * period]
        # From the last impact on, so that the seam cuts no flight.
        turns = turns[np.argsort((turns[:, 0] - instants[-1]) % period)]
        flight = np.searchsorted(instants, turns[:, 0]) % len(instants)
        is_formal = (run.impacts.stop == stop) & (sign * run.impacts.v_before > 0.0)
        first, last = np.roll(is_formal, 1).astype(int), is_formal.astype(int)
        flights = [turns[flight == k] for k in range(len(instants))]
        turns = np.concatenate([
            own[begin : len(own) - end]
            for own, begin, end in zip(flights, first, last, strict=True)
        ])  # fmt: skip
    return [(t, y - met.level) for t, y, _ in turns.tolist()]


def graze_of(orbit: StructureOrbit) -> StructureGraze:
    """Return where an orbit at a graze touches a stop: at an impact without velocity, or a turn.

    Raises
    ------
    ParameterError
        If it touches none.
    """
    impacts, structure = orbit.run.impacts, orbit.structure
    _, v = states_over_period(orbit)
    unit = float(np.abs(v).max())
    if len(impacts):
        k = int(np.argmin(np.abs(impacts.v_before)))
        size = float(np.abs(structure.stop_directions[int(impacts.stop[k])]).sum())
        if abs(float(impacts.v_before[k])) < SLOW * unit * size:
            return StructureGraze(int(impacts.stop[k]), float(impacts.t[k]))
    entered = orbit.run.crossings
    grazes = []
    for stop in range(len(structure.stops)):
        gap, place = _turns(orbit, [stop])
        if place is not None:
            grazes.append((abs(gap), place))
        slow = (entered.stop == stop) & (np.abs(entered.v) < math.sqrt(SLOW) * unit)
        if slow.any():
            grazes.append((0.0, StructureGraze(stop, float(entered.t[slow].mean()))))
    if not grazes:
        raise ParameterError("point", orbit, "its orbit touches no stop")
    return min(grazes)[1]
