"""Where a branch of orbits begins to touch a stop: a turning point passes it.

An orbit one of whose impacts has no velocity is, as a motion, the orbit without that impact whose
turning point touches the stop there; that orbit goes on smoothly in the parameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb

from percuss.certified.balls import Undecided
from percuss.certified.branch import (
    boxed,
    equations_over,
    exact_ball,
    root_of,
    solution_at,
    system_at,
    system_over,
)
from percuss.certified.flight import EnclosedFlight
from percuss.certified.landing import NARROW, fourth_around, pace_of
from percuss.certified.law import constant_of, law_of
from percuss.certified.numbers import span
from percuss.certified.properties import admissible_of
from percuss.certified.shooting import Link, Shooting, States, chain_of, region_of_row
from percuss.certified.steady import steady_admissible, steady_flight
from percuss.certified.step import flight_of
from percuss.certified.system import BallSystem, system_of
from percuss.kernels.law import PERIOD
from percuss.model.law import law, lines
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.turning_points import turns_of

__all__ = ["touch_of"]


class TurningPoint(NamedTuple):
    """A turning point: when, where it is the only one, and how far from the stop.

    The distance is negative beyond the stop; times are since the start of the flight.
    """

    s: arb
    alone: arb
    clearance: arb


@dataclass(frozen=True)
class TurningBranch:
    """Orbits with a turning point near a stop.

    Attributes
    ----------
    chain, guess
        The events, and states nearly after them; none for steady motion.
    flight, region
        The flight with the turning point, and its region.
    bound, s
        The stop's bound, and the time of the turning point in the flight, nearly.
    """

    system: BallSystem
    path: str
    n_periods: int
    chain: list[Link]
    guess: States
    flight: int
    region: int
    bound: int
    s: float

    def turn(self, flight: EnclosedFlight, system: BallSystem, near: arb) -> TurningPoint:
        """Return the turning point near a time of all flights, proven by an interval Newton step.

        Raises
        ------
        Undecided
            If it is not enclosed.
        """
        s = near
        for _ in range(60):
            (_, v, a), _ = flight.derivatives(s, 2)
            if v.abs_lower() < 4 * v.rad():
                break
            s = (s - (v / a).mid()).mid()
        (x, v, a, j), size = flight.derivatives(s, 3)
        trial = 2 * v.abs_upper() / a.abs_lower()
        for _ in range(4):
            if not trial * pace_of(flight) < NARROW:
                break
            jerk = j.abs_upper() + trial * fourth_around(flight, s, trial, size)
            step = -(v / (a + span(trial * jerk)))
            if step.abs_upper() <= trial:
                sign = 1 if system.regions[self.region].lower == self.bound else -1
                moved = step * span(v.abs_upper())
                at = law_of(system).places[self.bound]
                return TurningPoint(s + step, s + span(trial), sign * (x + moved - at))
            trial = 4 * trial
        raise Undecided("precision", "the turning point was not enclosed")

    def at(self, value: Fraction) -> arb:
        """Return about the clearance at a value of the parameter."""
        system = system_at(self.system, self.path, value)
        if not self.chain:
            flight = steady_flight(law_of(system), self.region)
            return self.turn(flight, system, arb(self.s)).clearance
        there, states = solution_at(
            self.system, self.chain, self.n_periods, self.path, value, self.guess
        )
        return self._turn_of(there, boxed(there, states)[0], arb(self.s)).clearance

    def over(self, low: Fraction, high: Fraction) -> tuple[arb, arb, bool | None]:
        """Prove that orbit and turning point go on smoothly from low to high.

        Returns
        -------
        tuple
            The clearances at low and high of this one turning point; and whether all of these
            orbits pass through no stop, None where that is open.

        Raises
        ------
        Undecided
            If the balls leave it open.
        """
        if not self.chain:
            system = system_over(self.system, self.path, low, high)
            turn = self.turn(steady_flight(law_of(system), self.region), system, arb(self.s))
            period = law_of(system).period(1)
            admissible = steady_admissible(system, self.region, constant_of(period))[0]
            ends = []
            for end in (low, high):
                there = system_at(self.system, self.path, end)
                flight = steady_flight(law_of(there), self.region)
                ends.append(self.turn(flight, there, turn.s.mid()))
            return *_same(turn, ends), admissible
        all_ = equations_over(self.system, self.chain, self.n_periods, self.path, low, high)
        middle = (low + high) / 2
        _, states = solution_at(
            self.system, self.chain, self.n_periods, self.path, middle, self.guess
        )
        box, trial = boxed(all_, states)
        turn = self._turn_of(all_, box, arb(self.s))
        ends = []
        for end in (low, high):
            equations, at_end = solution_at(
                self.system, self.chain, self.n_periods, self.path, end, states
            )
            inside = boxed(equations, at_end)[0]
            for outer, inner in zip(trial, inside, strict=True):
                if not all(b.contains(s) for b, s in zip(outer, inner, strict=True)):
                    raise Undecided("precision", "the ends of the branch lie outside of its box")
            ends.append(self._turn_of(equations, inside, turn.s.mid()))
        return *_same(turn, ends), admissible_of(all_, box)[0]

    def _turn_of(self, equations: Shooting, states: States, near: arb) -> TurningPoint:
        start = equations.departure(self.flight, states[self.flight])
        flight = flight_of(equations.system, start, whole=True)
        return self.turn(flight, equations.system, near)


def _same(turn: TurningPoint, ends: list[TurningPoint]) -> tuple[arb, arb]:
    """Return the clearances at both ends, if the turning point there is that of all the branch."""
    if not all(turn.alone.contains(end.s) for end in ends):
        raise Undecided("precision", "the turning points at the ends may be two")
    return ends[0].clearance, ends[1].clearance


def touch_of(point: SpecialPoint, path: str, digits: int) -> tuple[arb, bool | None]:
    """Return a ball of the parameter in which a turning point passes a stop.

    And whether the orbits pass through no stop otherwise: None, unless it is proven that they do.
    """
    system = system_of(point.orbit.oscillator, point.orbit.forcing)
    impact = point.detail.startswith("an impact")
    branch = (_without_impact if impact else _with_passage)(system, path, point.orbit)
    value = Fraction(point.value)
    zero = root_of(branch.at, value, (abs(value) + 1) / 10**9)
    width = max(abs(zero), Fraction(1, 10**3)) / 10 ** (digits + 2)
    low, high = zero - width, zero + width
    before, after, admissible = branch.over(low, high)
    if not ((before > 0 and after < 0) or (before < 0 and after > 0)):
        raise Undecided("precision", "the turning point does not pass the stop on the stretch")
    return exact_ball(low).union(exact_ball(high)), admissible


def _without_impact(system: BallSystem, path: str, orbit: PeriodicOrbit) -> TurningBranch:
    """Return the branch of the orbits without the slowest impact."""
    chain = chain_of(system, orbit)
    n = len(chain)
    unknowns = orbit.itinerary.vector
    instants = unknowns[0] + np.concatenate([[0.0], np.cumsum(unknowns[1 : 1 + n])])
    entries = [i for i, link in enumerate(chain) if link.stop is not None]
    slow = min(entries, key=lambda i: abs(unknowns[1 + n + i]))
    # A soft stop that is entered without velocity is left at once.
    dropped = {slow} if chain[slow].wall else {slow, (slow + 1) % n}
    kept = [(slow + 1 + k) % n for k in range(n) if (slow + 1 + k) % n not in dropped]
    here = chain[slow]
    if not kept:
        t = arb(float(instants[slow]))
        return TurningBranch(
            system, path, orbit.n_periods, [], [], 0, here.before, here.bound, float(t)
        )
    period = float(law_of(system).period(orbit.n_periods))
    states: States = []
    first = instants[kept[0]]
    for i in kept:
        t = instants[i] if instants[i] >= first else instants[i] + period
        states.append((arb(float(t)), arb(float(unknowns[1 + n + i]))))
    last = len(kept) - 1
    s = (instants[slow] - instants[kept[-1]]) % period
    reduced = [chain[i] for i in kept]
    return TurningBranch(
        system, path, orbit.n_periods, reduced, states, last, here.before, here.bound, float(s)
    )


def _with_passage(system: BallSystem, path: str, orbit: PeriodicOrbit) -> TurningBranch:
    """Return the branch of orbits one of whose turning points is nearest to a stop."""
    table = law(orbit.oscillator, orbit.forcing)
    n, (events, marks) = len(orbit.itinerary), orbit.record
    end = float(events[-1, 0]) if n else 1.5 * float(table[0, PERIOD])
    turns = turns_of(table, events, marks, orbit.x0, end)
    if not len(turns.t):
        raise Undecided("precision", "the orbit has no turning point")
    k = int(np.argmin(np.abs(turns.clearance)))
    shift = 1 if lines(orbit.oscillator).at[0] is None else 0
    bound, flight = int(turns.bound[k]) - shift, int(turns.flight[k])
    s = float(turns.t[k]) - (float(events[flight, 0]) if n else 0.0)
    region = region_of_row(system, int(marks[flight, 2]))
    if n == 0:
        return TurningBranch(system, path, orbit.n_periods, [], [], 0, region, bound, s)
    chain = chain_of(system, orbit)
    unknowns = [float(value) for value in orbit.itinerary.vector]
    t, states = unknowns[0], []
    for i in range(n):
        states.append((arb(t), arb(unknowns[1 + n + i])))
        t += unknowns[1 + i]
    return TurningBranch(system, path, orbit.n_periods, chain, states, flight, region, bound, s)
