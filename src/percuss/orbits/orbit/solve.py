"""Periodic orbits as solutions of the equations of their flights.

Newton's method solves the equations of an itinerary, families of solutions included; from a
solution the orbit is made as a value.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.arithmetic import later
from percuss.kernels.flight import Flight, constant_force, move_over_knots, place, set_phases
from percuss.kernels.law_columns import DAMPING, N_HARMONICS, PERIOD, Law
from percuss.kernels.restitution import kept_of_area
from percuss.kernels.sample import cycles
from percuss.kernels.shooting import (
    AFTER,
    AT,
    BEFORE,
    SINGULAR,
    SMALLEST_STEP,
    WEAK,
    ShootingProblem,
    advance,
    factor,
    iterate,
)
from percuss.kernels.tangent import neighbours
from percuss.model.oscillator import mass_of
from percuss.model.system import System
from percuss.motion.tables import Impacts
from percuss.numerics import (
    directions,
    dot,
    exp,
    is_finite,
    least_squares,
    matmul,
)
from percuss.orbits.orbit.itinerary import Itinerary, entries_of, events_of_record, is_wall
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import (
    Stability,
    multipliers_of,
    stability_of,
    stability_of_cycle,
)
from percuss.orbits.orbit.turning_points import margin_of, penetrations_of, turning_points_of

MOST_STEPS = 40
# Scaled residuals of a solution: far above rounding, far below those of any other iterate.
SOLVED = 1e-11
# From a solution Newton's next step, as a part of the unknowns, is shorter.
FAR = 1e-3
# Scaled residuals and singular values that rounding alone makes.
ROUNDING = 1e-13
# Flights shorter than this part of the period may be solutions of zero duration.
SHORT = 1e-6
# A family is distinguished from a fold by a step of this size along it, and the residuals there.
ALONG = 1e-3
ON_FAMILY = 1e-10


@dataclass(frozen=True, slots=True)
class Solution:
    """The last iterate of Newton's method, and its largest residual.

    It is isolated if it is no member of a family of solutions.
    """

    itinerary: Itinerary
    residual: float
    converged: bool
    isolated: bool


def solve(system: System, guess: Itinerary) -> Solution:
    """Solve the equations of an itinerary.

    Where the solutions form a family the step is that of least norm, which leads to the member
    next to the guess.

    Parameters
    ----------
    system
        Oscillator and forcing.
    guess
        Events, and approximate instants and velocities. With n_periods = 0 the motion is free: its
        period is unknown, and the instant of its first event stays as it is.

    Returns
    -------
    Solution
        The last iterate, converged or not.
    """
    events, law = guess.events, system.law
    equations = _Equations(law, events, guess.n_periods)
    unknowns, size = equations.improved(guess.vector)
    for i, (bound, before, _) in enumerate(events.tolist()):
        if factor(law, before, bound, 0.0) == 0.0:
            # After a plastic impact the velocity is zero, without rounding.
            unknowns[1 + len(events) + i] = 0.0
    itinerary = Itinerary.of_vector(events, unknowns, guess.n_periods)
    is_solved = size < SOLVED and not equations.stands_still(unknowns)
    if guess.n_periods == 0 and not itinerary.velocities.any():
        is_solved &= _strikes(law, itinerary)
    converged = is_solved and equations.is_near(unknowns)
    isolated = not (converged and equations.is_on_family(unknowns))
    return Solution(itinerary, equations.largest(unknowns), converged, isolated)


class _Equations:
    """The equations of an itinerary, with the workspace of the kernels."""

    def __init__(self, law: Law, events: Integers, n_periods: int) -> None:
        self.law, self.events, self.n_periods = law, events, n_periods
        self.n = len(events)
        period = n_periods * float(law[0, PERIOD])
        harmonics = int(law[0, N_HARMONICS])
        size = 2 * self.n + 1
        self.problem = ShootingProblem(law, events, period, *np.empty((2, harmonics, 2)))
        self.residual, self.matrix = np.empty(size), np.empty((size, size))

    def iterated(self, unknowns: Floats, best: Floats, steps: int) -> tuple[int, float, int]:
        """Iterate from the unknowns; return why it ended, the least residual and the steps left."""
        return iterate(self.problem, unknowns, self.residual, self.matrix, best, steps)

    def at(self, unknowns: Floats) -> None:
        """Set scaled residuals and Jacobian."""
        self.iterated(unknowns, np.empty_like(unknowns), 0)
        if self.starts_from_rest(unknowns):
            # The kernels take 1 as the scale of velocities that are all zero.
            _, speed = self.scales(unknowns)
            with np.errstate(over="ignore", invalid="ignore"):
                self.residual[:-1] /= speed
                self.matrix[:-1] /= speed
                self.matrix[:, 1 + self.n :] *= speed

    def starts_from_rest(self, unknowns: Floats) -> bool:
        """Return whether every flight does, as after plastic impacts."""
        return not unknowns[1 + self.n :].any()

    def advance(self, unknowns: Floats, step: Floats) -> float:
        """Add a scaled step to the unknowns, as the kernels do; return its size."""
        if self.starts_from_rest(unknowns):
            step = step.copy()
            step[1 + self.n :] *= self.scales(unknowns)[1]
        return float(advance(unknowns, step, self.n))

    def improved(self, unknowns: Floats) -> tuple[Floats, float]:
        """Return the best iterate, and its largest scaled residual."""
        best, iterate_ = np.empty_like(unknowns), np.empty_like(unknowns)
        least, steps = math.inf, MOST_STEPS
        while True:
            why, size, steps = self.iterated(unknowns, iterate_, steps)
            if size < least or least == math.inf:
                least, best = size, iterate_.copy()
            if why != SINGULAR or steps == 0:
                break
            # A step of least norm has no part along the smallest singular values.
            self.at(unknowns)
            if not is_finite(self.matrix, self.residual):
                break
            step = least_squares(self.matrix, -self.residual, WEAK)
            steps -= 1
            if self.advance(unknowns, step) < SMALLEST_STEP:
                break
        if math.isfinite(least) and self.starts_from_rest(best):
            self.at(best)
            least = float(np.abs(self.residual).max())
        return best, least

    def largest(self, unknowns: Floats) -> float:
        """Return the largest residual, unscaled."""
        self.at(unknowns)
        time, speed = self.scales(unknowns)
        rows = np.array([time * speed, speed] * self.n + [time])
        return float(np.abs(self.residual * rows).max())

    def scales(self, unknowns: Floats) -> tuple[float, float]:
        """Return the scales of time and velocity, as the kernels take them.

        Where every flight starts from rest the scale is the velocity with which they end.
        """
        time = float(np.abs(unknowns[1 : 1 + self.n]).mean())
        speed = float(np.abs(unknowns[1 + self.n :]).max())
        if self.starts_from_rest(unknowns) and time > 0.0:
            itinerary = Itinerary.of_vector(self.events, unknowns, self.n_periods)
            speed = float(np.abs(_record(self.law, itinerary)[0][1:, columns.V_BEFORE]).max())
        return time or 1.0, speed or 1.0

    def stands_still(self, unknowns: Floats) -> bool:
        """Return whether a flight has zero duration, which solves its equation too.

        A short hop comes back with the opposite velocity.
        """
        durations, speeds = unknowns[1 : 1 + self.n].tolist(), unknowns[1 + self.n :].tolist()
        for i in range(self.n):
            if durations[i] >= SHORT * sum(durations):
                continue
            following = (i + 1) % self.n
            bound = self.events[following, AT]
            before = int(self.events[following, BEFORE])
            kept = factor(self.law, before, int(bound), speeds[following])
            if self.events[i, AT] == bound and speeds[following] * kept * speeds[i] > 0.0:
                return True
        return False

    def is_near(self, unknowns: Floats) -> bool:
        """Return whether a solution lies near, from the length of Newton's next step.

        Where motions grow without bound the residuals vanish at infinity only, and that step is as
        long as the unknowns; at a solution, even a double one, it is short.
        """
        self.at(unknowns)
        if not is_finite(self.matrix, self.residual):
            return False
        if np.abs(self.residual).max() < ROUNDING:
            return True
        step = least_squares(self.matrix, self.residual, ROUNDING)
        return float(np.abs(step).max()) < FAR

    def is_on_family(self, unknowns: Floats) -> bool:
        """Return whether the solution is one of a family; at a fold it is not, to second order."""
        self.at(unknowns)
        sizes, rows = directions(self.matrix)
        weak = rows[sizes < math.sqrt(WEAK) * sizes[0]]
        return any(self._has_neighbour(unknowns, direction) for direction in weak)

    def _has_neighbour(self, unknowns: Floats, direction: Floats) -> bool:
        guess = unknowns.copy()
        self.advance(guess, ALONG * direction)
        neighbour, size = self.improved(guess)
        scale = np.repeat(self.scales(unknowns), [1 + self.n, self.n])
        distance = float(np.abs((neighbour - unknowns) / scale).max())
        return size < ON_FAMILY and distance > 0.1 * ALONG


def _strikes(law: Law, itinerary: Itinerary) -> bool:
    """Return whether free motion that leaves all of its events at rest meets one with a velocity.

    Else it is rest, or a grazing free oscillation: no motion with impacts. Velocities are compared
    with those that the force at the stop makes within a flight.
    """
    if not itinerary.durations.all():
        return False
    events, _ = _record(law, itinerary)
    bound, _, region = itinerary.events[0].tolist()
    force = abs(constant_force(law, region, place(law, region, bound)))
    least = SHORT * force * float(itinerary.durations.max())
    return bool(np.abs(events[1:, columns.V_BEFORE]).max() > least)


def orbit_of_solution(system: System, solution: Solution) -> PeriodicOrbit:
    """Return the orbit of a solution.

    Parameters
    ----------
    system
        Oscillator and forcing.
    solution
        A solution of `solve`; its first event meets a stop.

    Returns
    -------
    PeriodicOrbit
        Admissible or not.
    """
    law, traced = system.law, _traced(system.law, solution)
    itinerary, events, marks = traced.itinerary, traced.events, traced.marks
    period = itinerary.period
    if itinerary.n_periods:
        period = itinerary.n_periods * float(law[0, PERIOD])
    bound, _, region = itinerary.events[0].tolist()
    x0 = place(law, region, bound)
    turns = turning_points_of(law, events, marks, x0, float(events[-1, columns.EVENT_T]))
    impacts = impacts_of_record(system, events, marks)
    penetrations = penetrations_of(system.oscillator, turns)
    return PeriodicOrbit(
        oscillator=system.oscillator,
        forcing=system.forcing,
        x0=x0,
        v0=float(itinerary.velocities[0]),
        t0=itinerary.start,
        impacts=impacts,
        n_impacts=len(impacts),
        n_periods=itinerary.n_periods,
        period=period,
        monodromy=traced.monodromy,
        multipliers=multipliers_of(
            traced.monodromy, traced.determinant, is_free=not itinerary.n_periods
        ),
        stability=traced.stability,
        # A flight of negative duration solves the equations formally, too.
        admissible=len(penetrations) == 0 and not (itinerary.durations < 0.0).any(),
        grazing_margin=margin_of(turns),
        passages=penetrations,
        min_impact_speed=float(np.abs(impacts.v_before).min()),
        isolated=solution.isolated,
        residual=solution.residual,
        _events=events,
        _marks=marks,
        _sequence=itinerary.events,
        _vector=itinerary.vector,
    )


def attracts(system: System, solution: Solution) -> bool:
    """Return whether neighbours approach the orbit of a solution, without making the orbit."""
    return _traced(system.law, solution).stability == "asymptotic"


@dataclass(frozen=True, slots=True)
class _Traced:
    """The motion over the itinerary of a solution: its record, and what becomes of neighbours."""

    itinerary: Itinerary
    events: Floats
    marks: Integers
    monodromy: Floats
    determinant: float
    stability: Stability


def _traced(law: Law, solution: Solution) -> _Traced:
    itinerary = in_first_period(law, solution.itinerary)
    events, marks = _record(law, itinerary)
    monodromy = _monodromy(law, events, marks)
    determinant, conservative = _determinant(law, itinerary, events)
    stability = stability_of(monodromy, determinant, conservative=conservative)
    if not itinerary.n_periods:
        stability = stability_of_cycle(determinant, conservative=conservative)
    return _Traced(itinerary, events, marks, monodromy, determinant, stability)


def _determinant(law: Law, itinerary: Itinerary, events: Floats) -> tuple[float, bool]:
    """Return the determinant of the monodromy matrix, and whether it is 1 by construction.

    It is the product of r^2 over the impacts times exp(-2 integral of the damping); where the
    restitution depends on the speed u, of r d(r u)/du. ``events`` are those of a record.
    """
    walls, speeds = is_wall(law, itinerary.events), np.abs(events[:, columns.V_BEFORE])
    factors = [
        kept_of_area(law, int(row[BEFORE]), int(row[AT]), speeds[i or len(walls)])
        if walls[i]
        else 1.0
        for i, row in enumerate(itinerary.events)
    ]
    dampings = law[itinerary.events[:, AFTER], DAMPING]
    conservative = all(abs(value) == 1.0 for value in factors) and not dampings.any()
    decay = exp(-2.0 * dot(dampings, itinerary.durations))
    return float(np.prod(np.square(factors))) * decay, conservative


def in_first_period(law: Law, itinerary: Itinerary) -> Itinerary:
    """Return the itinerary with its first event in the first forcing period."""
    period = float(law[0, PERIOD])
    if period == 0.0:
        return itinerary
    start = itinerary.start - period * math.floor(itinerary.start / period)
    return dataclasses.replace(itinerary, start=start if start < period else 0.0)


def _record(law: Law, itinerary: Itinerary) -> tuple[Floats, Integers]:
    """Return the record that `march` would have written, from the first event to it again."""
    rows, n = itinerary.events, len(itinerary)
    phases, arrival = (np.empty((int(law[0, N_HARMONICS]), 2)) for _ in range(2))
    events = np.zeros((n + 1, columns.EVENT_COLUMNS))
    marks = np.empty((n + 1, columns.MARK_COLUMNS), dtype=np.int64)
    walls = is_wall(law, rows)
    t, t_low, v = itinerary.start, 0.0, float(itinerary.velocities[0])
    events[0] = t, t_low, v, v
    marks[0] = columns.START, -1, rows[0, AFTER]
    for i in range(n):
        following = (i + 1) % n
        region = int(rows[i, AFTER])
        force = constant_force(law, region, place(law, region, int(rows[i, AT])))
        set_phases(law, t, t_low, phases)
        s = float(itinerary.durations[i])
        flight = Flight(law, region, (t, t_low, v, force), phases, arrival)
        _, before = move_over_knots(flight, s)
        t, t_low = later(t, t_low, s)
        v = float(itinerary.velocities[following])
        events[i + 1] = t, t_low, before, v
        kind = columns.IMPACT if walls[following] else columns.CROSSING
        marks[i + 1] = kind, rows[following, AT], rows[following, AFTER]
    return events, marks


def _monodromy(law: Law, events: Floats, marks: Integers) -> Floats:
    """Return the derivative of (x, v) over a record, NaN with an impact of zero velocity."""
    out, product = np.empty((1, 4)), np.eye(2)
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    flights = [slice(0, len(events))]
    if (np.diff(events[:, columns.EVENT_T]) < 0.0).any():
        # Formal flights of negative duration: records in the order of time hold one flight each.
        flights = [slice(i, i + 2) for i in range(len(events) - 1)]
    for flight in flights:
        end = events[flight][-1:, columns.EVENT_T].copy()
        record = columns.MotionRecord(law, 0.0, events[flight], marks[flight])
        neighbours(record, end, True, phases, out)
        with np.errstate(invalid="ignore"):
            product = matmul(out.reshape(2, 2), product)
    return product


def impacts_of_record(system: System, events: Floats, marks: Integers) -> Impacts:
    """Return the impacts of one period, entries into soft stops among them.

    Parameters
    ----------
    system
        Oscillator and forcing.
    events, marks
        A record whose START is just after an impact and whose last event is that impact again.

    Returns
    -------
    Impacts
        The one at the START first.
    """
    law, kinds = system.law, marks[:, columns.KIND]
    met = {
        i + 1: stop
        for i, stop in entries_of(system, events_of_record(marks))
        if kinds[i + 1] in (columns.IMPACT, columns.CROSSING)
    }
    last = len(events) - 1
    rows = [last, *(i for i in met if i != last)]
    instants = [0, *rows[1:]]
    t = events[instants, columns.EVENT_T].copy()
    t_low = events[instants, columns.EVENT_T_LOW].copy()
    cycle = np.full(len(rows), np.nan)
    if law[0, PERIOD] > 0.0:
        cycles(law, t, t_low, cycle)
    before = np.roll(t, 1)
    before[0] -= events[last, columns.EVENT_T] - events[0, columns.EVENT_T]
    return Impacts(
        t=t,
        v_before=events[rows, columns.V_BEFORE].copy(),
        v_after=events[rows, columns.V_AFTER].copy(),
        stop=np.array([met[i] for i in rows], dtype=np.int64),
        cycle=cycle,
        intervals=t - before,
        mass=mass_of(system.oscillator),
        units=system.oscillator.units,
    )
