"""Grazing along a branch: a turning point of the orbits passes a stop.

An orbit one of whose impacts has zero normal velocity is, as a motion, the orbit without that
impact whose turning point touches the stop; that orbit goes on smoothly in the parameter.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.branch import (
    ParameterBranch,
    boxed,
    is_positive,
    parameter_size,
    root_of,
    stretch_around,
    system_at,
    system_over,
)
from percuss.certified.event_location import fourth_around, interval_newton, is_narrow
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import ball, constant_of, span
from percuss.certified.properties import admissible_of
from percuss.certified.shooting import (
    OrbitEvent,
    Shooting,
    States,
    check_inside,
    events_of,
    guess_of,
    region_of_row,
    vector_of,
)
from percuss.certified.steady import steady_admissible, steady_flight, steady_pieces
from percuss.certified.step import Departure, began, flight_of
from percuss.certified.system import BallSystem, system_of
from percuss.kernels.law_columns import PERIOD
from percuss.model.system import law, lines
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.turning_points import turning_points_of

# Newton's steps to a turning point; each doubles the digits.
MOST_STEPS = 60


class TurningPoint(NamedTuple):
    """A turning point: its time, where it is the only one, and its distance from the stop.

    The distance is negative beyond the stop; times are since the start of the flight, or of the
    piece of a record, whose number in the flight is ``piece``.
    """

    s: arb
    isolating: arb
    clearance: arb
    piece: int = 0


@dataclass(frozen=True)
class TurningBranch:
    """Orbits with a turning point near a stop.

    Attributes
    ----------
    branch, events, guess
        The orbits, their events, and states nearly after these; none for steady motion.
    flight, region
        The flight with the turning point, and its region.
    bound, s
        The stop's bound, and the time of the turning point in the flight, nearly; of steady motion
        its instant.
    """

    branch: ParameterBranch
    events: list[OrbitEvent]
    guess: States
    flight: int
    region: int
    bound: int
    s: float

    def turning_point(self, flight: EnclosedFlight, system: BallSystem, near: arb) -> TurningPoint:
        """Return the turning point near a time of all flights, proven by an interval Newton step."""
        s = near
        for _ in range(MOST_STEPS):
            (_, v, a), _ = flight.derivatives(s, 2)
            if v.abs_lower() < 4 * v.rad():
                break
            s = (s - (v / a).mid()).mid()
        (x, v, a, j), size = flight.derivatives(s, 3)

        def slope(trial: arb) -> arb:
            if not is_narrow(flight, trial):
                raise Undecided("precision", "the turning point was not enclosed")
            jerk = j.abs_upper() + trial * fourth_around(flight, s, trial, size)
            return a + span(trial * jerk)

        # Wide beside the last bits of s, in which the turning points of neighbours differ.
        least = abs(s) * arb(2) ** -(ctx.prec // 2)
        step, trial = interval_newton(v, slope, (2 * v.abs_upper() / a.abs_lower()).max(least))
        sign = 1 if system.regions[self.region].lower == self.bound else -1
        place = law_of(system).places[self.bound]
        clearance = sign * (x + step * span(v.abs_upper()) - place)
        return TurningPoint(s + step, s + span(trial), clearance)

    def clearance(self, value: Fraction) -> arb:
        """Return about the clearance at a value of the parameter."""
        if not self.guess:
            return self._on_steady(self._system_at(value)).clearance
        equations, states = self.branch.solution(value, self.guess)
        return self._on_orbit(equations, boxed(equations, states)[0]).clearance

    def over(self, low: Fraction, high: Fraction) -> tuple[arb, arb, bool | None]:
        """Prove that orbit and turning point go on smoothly from low to high.

        Returns
        -------
        tuple
            The clearances at low and high of this one turning point; and whether all of these
            orbits are admissible, None where that is open.
        """
        ends = []
        if not self.guess:
            system = system_over(self.branch.system, self.branch.path, low, high)
            turning = self._on_steady(system)
            period = constant_of(law_of(system).period(1))
            admissible = steady_admissible(system, self.region, period)[0]
            for end in (low, high):
                ends.append(self._on_steady(self._system_at(end), turning))
            return *clearances_at_ends(turning, ends), admissible
        over = self.branch.over(low, high)
        _, states = self.branch.solution((low + high) / 2, self.guess)
        box, trial = boxed(over, states)
        turning = self._on_orbit(over, box)
        for end in (low, high):
            equations, at_end = self.branch.solution(end, states)
            inner, _ = boxed(equations, at_end)
            check_inside(vector_of(trial), vector_of(inner))
            ends.append(self._on_orbit(equations, inner, turning))
        return *clearances_at_ends(turning, ends), admissible_of(over, box)[0]

    def _system_at(self, value: Fraction) -> BallSystem:
        return system_at(self.branch.system, self.branch.path, value)

    def _on_steady(self, system: BallSystem, known: TurningPoint | None = None) -> TurningPoint:
        law = law_of(system)
        if system.record is None:
            near = arb(self.s) if known is None else known.s.mid()
            return self.turning_point(steady_flight(law, self.region), system, near)
        pieces = steady_pieces(system, self.region, constant_of(law.period(1)))
        starts, ends = zip(*pieces, strict=True)
        return self._on_pieces(system, list(starts), ends[-1], known)

    def _on_orbit(
        self, equations: Shooting, states: States, known: TurningPoint | None = None
    ) -> TurningPoint:
        pieces = [start for start, _ in equations.pieces_of_flight(self.flight, states)]
        end = equations.end_of_flight(self.flight, states)
        return self._on_pieces(equations.system, pieces, end, known)

    def _on_pieces(
        self, system: BallSystem, pieces: list[Departure], end: arb, known: TurningPoint | None
    ) -> TurningPoint:
        """Return the turning point on the piece of a record that a known one has, or where it is."""
        begins = [began(piece, whole=True) for piece in pieces]
        if known is None:
            since = [float(begin.mid() - begins[0].mid()) for begin in begins]
            number = bisect_right(since, self.s) - 1
            near = arb(self.s) - arb(since[number])
        else:
            number, near = known.piece, known.s.mid()
        flight = flight_of(system, pieces[number], whole=True)
        turning = self.turning_point(flight, system, near)._replace(piece=number)
        later = [*begins[1:], end][number] - begins[number]
        if len(pieces) > 1 and not (turning.isolating > 0 and turning.isolating < later):
            reason = "whether the turning point is before or after a knot of the record is open"
            raise Undecided("precision", reason)
        return turning


def clearances_at_ends(turning: TurningPoint, ends: list[TurningPoint]) -> tuple[arb, arb]:
    """Return the clearances at both ends of a branch, if it has one and the same turning point.

    Raises
    ------
    Undecided
        If that at an end may be another one.
    """
    if not all(turning.isolating.contains(end.s) and turning.piece == end.piece for end in ends):
        raise Undecided("precision", "the turning points at the ends may be two")
    return ends[0].clearance, ends[1].clearance


def grazing_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which a turning point passes a stop.

    And whether the orbits are admissible apart from that, None where that is open.
    """
    branch, value = turning_branch(point, path), Fraction(point.value)
    size = branch.branch.size
    zero = root_of(branch.clearance, value, size)
    low, high = stretch_around(zero, size, digits)
    before, after, admissible = branch.over(low, high)
    if is_positive(before) == is_positive(after):
        raise Undecided("precision", "the turning point is not proven to pass the stop")
    return ball(low).union(ball(high)), admissible


def turning_branch(point: SpecialPoint, path: str) -> TurningBranch:
    """Return the orbits one of whose turning points passes a stop at a graze."""
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    size = parameter_size(point.orbit, path, Fraction(point.value))
    impact = point.detail.startswith("an impact")
    return (_without_impact if impact else _with_passage)(system, path, size, point.orbit)


def _without_impact(
    system: BallSystem, path: str, size: Fraction, orbit: PeriodicOrbit
) -> TurningBranch:
    """Return the branch of the orbits without the slowest impact."""
    events, guess = events_of(system, orbit), guess_of(orbit)
    n = len(events)
    instants = [float(t) for t, _ in guess]
    entries = [i for i, event in enumerate(events) if event.stop is not None]
    slow = min(entries, key=lambda i: abs(float(guess[i][1])))
    # A soft stop that is entered without velocity is left at once.
    dropped = {slow} if events[slow].wall else {slow, (slow + 1) % n}
    kept = [(slow + 1 + k) % n for k in range(n) if (slow + 1 + k) % n not in dropped]
    region, bound = events[slow].before, events[slow].bound
    reduced = [events[i] for i in kept]
    equations = partial(Shooting.of, events=reduced, n_periods=orbit.n_periods)
    branch = ParameterBranch(system, path, equations, size)
    if not kept:
        s = _in_period(system, instants[slow])
        return TurningBranch(branch, [], [], 0, region, bound, s)
    period = float(law_of(system).period(orbit.n_periods))
    states: States = []
    for i in kept:
        later = 0.0 if instants[i] >= instants[kept[0]] else period
        states.append((arb(instants[i] + later), guess[i][1]))
    s = (instants[slow] - instants[kept[-1]]) % period
    return TurningBranch(branch, reduced, states, len(kept) - 1, region, bound, s)


def _with_passage(
    system: BallSystem, path: str, size: Fraction, orbit: PeriodicOrbit
) -> TurningBranch:
    """Return the branch of orbits one of whose turning points is nearest to a stop."""
    table = law(orbit.oscillator, orbit.forcing)
    n, (rows, marks) = len(orbit.itinerary), orbit.record
    end = float(rows[-1, 0]) if n else 1.5 * float(table[0, PERIOD])
    turns = turning_points_of(table, rows, marks, orbit.x0, end)
    if not len(turns.t):
        raise Undecided("precision", "the orbit has no turning point")
    k = int(np.argmin(np.abs(turns.clearance)))
    shift = 1 if lines(orbit.oscillator).at[0] is None else 0
    flight = int(turns.flight[k])
    t = float(turns.t[k])
    s = t - float(rows[flight, 0]) if n else _in_period(system, t)
    events = events_of(system, orbit) if n else []
    equations = partial(Shooting.of, events=events, n_periods=orbit.n_periods)
    return TurningBranch(
        branch=ParameterBranch(system, path, equations, size),
        events=events,
        guess=guess_of(orbit) if n else [],
        flight=flight if n else 0,
        region=region_of_row(system, int(marks[flight, 2])),
        bound=int(turns.bound[k]) - shift,
        s=s,
    )


def _in_period(system: BallSystem, t: float) -> float:
    """Return an instant of steady motion; under a record one in the first period."""
    return t if system.record is None else t % float(law_of(system).period(1))
