"""Curves of orbits up to a graze: the velocity of an impact goes to zero along them.

With the instants of the events among the unknowns, and one equation for the place and one for the
velocity at the end of each flight, the equations of an orbit are smooth where an impact is without
velocity. Along that velocity, down to zero, they have strips like any others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw, law_of
from percuss.certified.cloud import BallMatrix, Cloud, times
from percuss.certified.fold import OrbitCurve, flight_from, law_along, slope_after, slope_of
from percuss.certified.numbers import ball, between, constant_of, exact_value, largest_abs
from percuss.certified.pieces import Moment
from percuss.certified.properties import meets_first
from percuss.certified.shooting import Shooting, States, Vector, pairs
from percuss.certified.step import (
    Departure,
    bracket_within,
    event_derivative,
    flight_of,
    levels_of,
    moved_by,
    state_in_flight,
    width_of,
)
from percuss.certified.strips import StripChain, StripEquations, StripWalk, Tube, split_along
from percuss.certified.system import BallSystem

# Tubes that lead to the graze, at most, and the least part of the way that one is tried for.
MOST_TUBES, LEAST_PART = 200, Fraction(1, 2**10)
# How far the first tube begins beyond the end of the chain; Newton steps to the middle of a tube.
OVERLAP, STEPS, FEW_BITS = 1.0 + 2.0**-8, 4, 20
# Times before and after a slow impact in which the acceleration lifts off, as parts of the fastest
# change of the motion: tried in turn.
LIFTS = (2.0**-2, 2.0**-4, 2.0**-6, 2.0**-8)
# The greatest velocity of one tube next to a graze, as a part of that of other events: tried in
# turn.
PARTS_OF_SPEED = tuple(Fraction(1, 2**n) for n in (16, 24, 32))


@dataclass(frozen=True)
class GrazeEnd:
    """Orbits from the end of a chain to a graze, proven to be motions that go on from the chain.

    Attributes
    ----------
    number
        Of the event without velocity.
    tubes
        In order to the graze.
    value
        A ball that holds the parameter there.
    parameters
        Numbers between which the parameters of all orbits lie.
    stability
        "unstable" if all orbits with an impact of some velocity there are, else "undecided".
    """

    number: int
    tubes: tuple[Tube, ...]
    value: arb
    parameters: tuple[Fraction, Fraction]
    stability: str

    def holds(self, point: Sequence[float]) -> bool:
        """Return whether a point (instants, velocities, parameter) lies where its orbits alone are."""
        box = [arb(value) for value in point]
        return any(tube.has_only(box) for tube in self.tubes)


class _TimedEquations(StripEquations):
    """x - d and what becomes of v, minus the next velocity, at the instant of each next event."""

    def value(self, u: Vector) -> arb_mat:
        """Return by how much a point misses."""
        equations, states = self.at(u[-1]), pairs(u[:-1])
        missed: list[list[arb]] = []
        for i, (_, v) in enumerate(_following(states)):
            following = equations.next_event(i)
            start, s = _flight(equations, states, i)
            (x, speed), _ = flight_of(equations.system, start, whole=True).derivatives(s, 1)
            place = law_of(equations.system).places[following.bound]
            missed += [[x - place], [following.passed(equations.system, speed).after - v]]
        return arb_mat(missed)

    def derivative(self, u: Vector, *, checked: bool = True) -> list[list[arb]]:
        """Return the rows of the derivative on a box, the column of the parameter last."""
        del checked
        equations, states = self.at(u[-1]), pairs(u[:-1])
        columns = self._by_parameter(equations, states, u[-1])
        rows = []
        for i in range(len(states)):
            j = (i + 1) % len(states)
            start, s = _flight(equations, states, i)
            whole = flight_of(equations.system, start, whole=True)
            (_, v, a), _ = whole.derivatives(s, 2)
            (x_t, x_v), (v_t, v_v) = moved_by(start, whole, s)
            kept = -equations.next_event(i).passed(equations.system, v).kept
            place, velocity = [arb(0)] * len(u), [arb(0)] * len(u)
            for row, by_t, by_v, by_end in ((place, x_t, x_v, v), (velocity, v_t, v_v, a)):
                row[2 * i] += by_t
                row[2 * i + 1] += by_v
                row[2 * j] += by_end
            velocity = [kept * entry for entry in velocity]
            velocity[2 * j + 1] -= 1
            place[-1], velocity[-1] = columns[i]
            rows += [place, velocity]
        return rows

    def _by_parameter(
        self, equations: Shooting, states: States, value: arb
    ) -> list[tuple[arb, arb]]:
        with law_along(equations.system, self.curve.path, value) as law:
            n = len(states)
            return [self._flight_by_parameter(equations, law, states, i) for i in range(n)]

    def _flight_by_parameter(
        self, equations: Shooting, law: BallLaw, states: States, i: int
    ) -> tuple[arb, arb]:
        event, following, (t, v) = equations.events[i], equations.next_event(i), states[i]
        flight = flight_from(law, event.after, Moment(t), (law.places[event.bound], v), 0)
        _, s = _flight(equations, states, i)
        (x1, v1, a1), _ = flight.derivatives(s, 2)
        # The last flight ends a period after the first event.
        later = slope_of(law.period(self.curve.n_periods)) if i + 1 == len(states) else arb(0)
        by_x = slope_of(x1) + constant_of(v1) * later - slope_of(law.places[following.bound])
        by_v = slope_of(v1) + constant_of(a1) * later
        return by_x, slope_after(equations, law, following, constant_of(v1), by_v)


def along_of(number: int) -> int:
    """Return the coordinate that is the velocity after an event."""
    return 2 * number + 1


def _following(states: States) -> States:
    return [*states[1:], states[0]]


def _flight(equations: Shooting, states: States, i: int) -> tuple[Departure, arb]:
    """Return the departure from event i, and how long the flight from it is."""
    return equations.departure(i, states[i]), equations.end_of_flight(i, states) - states[i][0]


def graze_at_end(
    part: StripChain,
    *,
    at_begin: bool = False,
    within: tuple[float, float] = (-math.inf, math.inf),
) -> GrazeEnd | None:
    """Return the orbits from the end of a chain, or its begin, to a graze; None where it has none.

    ``within`` are values that the parameter does not leave on the way.

    Raises
    ------
    Undecided
        If an impact is slow there, and a graze is not proven.
    """
    curve, strip = part.curve, part.strips[0 if at_begin else -1]
    tube = strip.tube
    end = strip.end if not at_begin else tube.low if strip.end == tube.high else tube.high
    box = tube.end(end)
    with suppress(Undecided):
        box = StripWalk(StripEquations(curve), part.scale, 0.0).closer(tube, end, box)
    number = _slowing(part, box, tube, forward=(end == tube.high))
    if curve.mirrored or number is None:
        return None
    if curve.system.record is not None or curve.system.tables:
        raise Undecided("kind", "up to a graze under a record, or with a table of restitutions")
    return _to_graze(part, box, number, within)


def _slowing(part: StripChain, box: Vector, tube: Tube, *, forward: bool) -> int | None:
    """Return the impact that comes to rest first beyond the end of a chain, by the tangent there."""
    sign = 1 if forward else -1
    ways = {}
    for k, event in enumerate(part.curve.events):
        v, slope = float(box[along_of(k)]), sign * float(tube.tangent[along_of(k)])
        if event.wall and v * slope < 0:
            ways[k] = -v / slope
    return min(ways, key=lambda k: ways[k], default=None)


def graze_about(
    curve: OrbitCurve, scale: Vector, point: Vector, number: int, away: int
) -> GrazeEnd:
    """Return the orbits next to a graze, from a point near it at which an event has no velocity.

    In one tube, as wide as one is proven. ``away`` is the sign of velocities off the stop.

    Raises
    ------
    Undecided
        If none is proven.
    """
    along = along_of(number)
    equations = _TimedEquations(curve)
    walk = StripWalk(equations, scale, 0.0)
    for part in PARTS_OF_SPEED:
        begin = away * Fraction(float(scale[along])) * part
        guess = list(point)
        guess[along] = ball(begin / 2).mid()
        try:
            for _ in range(STEPS):
                guess, _ = walk.corrected(guess, along)
            tube = walk.tube(along, min(begin, Fraction(0)), max(begin, Fraction(0)), guess)
            states = _check_motions(equations, tube, number, away)
        except Undecided as question:
            fault = question
            continue
        unstable = _are_unstable(equations.at(tube.box()[-1]), states, number)
        stability = "unstable" if unstable else "undecided"
        value = walk.closer(tube, Fraction(0), tube.end(Fraction(0)))[-1]
        return GrazeEnd(number, (tube,), value, tube.parameters, stability)
    raise fault


def _to_graze(part: StripChain, box: Vector, number: int, within: tuple[float, float]) -> GrazeEnd:
    """Return the orbits along the velocity of an impact, from that in a box to velocity zero."""
    along = along_of(number)
    equations = _TimedEquations(part.curve)
    walk = StripWalk(equations, part.scale, 0.0)
    tubes: list[Tube] = []
    unstable = True
    ends = [box[-1]]
    position = box
    # From a little before the end, so that the orbit there lies in the first tube.
    away = 1 if box[along].mid() > 0 else -1
    # Numbers of few bits, whose halves and quarters the precision holds.
    size = 2.0 ** (math.frexp(float(abs(box[along])))[1] - FEW_BITS)
    begin = away * math.ceil(float(abs(box[along]).upper()) * OVERLAP / size) * Fraction(size)
    step, least = begin, abs(begin) * LEAST_PART
    while True:
        near = begin - step
        if away * near < abs(begin) * Fraction(1, 2**30):
            near = Fraction(0)
        guess = [value.mid() for value in position]
        guess[along] = ball((begin + near) / 2).mid()
        try:
            for _ in range(STEPS):
                guess, _ = walk.corrected(guess, along)
            tube = walk.tube(along, min(begin, near), max(begin, near), guess)
            _check_goes_on(tube, position)
            states = _check_motions(equations, tube, number, away)
            closer = walk.closer(tube, near, tube.end(near))
        except Undecided:
            step /= 2
            if abs(step) < least:
                raise
            continue
        if not within[0] <= float(closer[-1]) <= within[1]:
            raise Undecided("graze", "the way to a graze leaves the branch")
        tubes.append(tube)
        unstable = unstable and _are_unstable(equations.at(tube.box()[-1]), states, number)
        position = closer
        ends.append(position[-1])
        if near == 0:
            with suppress(Undecided):
                position = walk.closer(tube, near, position)
            ends[-1] = position[-1]
            stability = "unstable" if unstable else "undecided"
            parameters = _between(equations, tubes, ends)
            return GrazeEnd(number, tuple(tubes), position[-1], parameters, stability)
        if len(tubes) > MOST_TUBES:
            raise Undecided("precision", "the way to the graze is too long")
        begin, step = near, min(2 * step, near, key=abs)


def _between(
    equations: StripEquations, tubes: Sequence[Tube], ends: Sequence[arb]
) -> tuple[Fraction, Fraction]:
    """Return numbers between which all parameters of tubes lie, from those at their ends.

    Of the first tube what lies beyond the end of the chain is left out.
    """
    found: list[Fraction] = []
    for tube, pair in zip(tubes, pairwise(ends), strict=True):
        others, column = split_along(equations.derivative(tube.box()), tube.along)
        own = tube.parameters
        with suppress(ZeroDivisionError):
            if not others.solve(column)[others.nrows() - 1, 0].contains(0):
                # The parameter grows or falls along all of the tube.
                values = [exact_value(end) for p in pair for end in (p.lower(), p.upper())]
                own = min(values), max(values)
        found += own
    return min(found), max(found)


def _check_goes_on(tube: Tube, position: Vector) -> None:
    if not tube.has_only(position):
        raise Undecided("precision", "the orbits of one strip leave the next one")


def _check_motions(equations: StripEquations, tube: Tube, number: int, away: int) -> States:
    """Return the states of a tube; prove that its orbits meet the stops at their events alone.

    That with velocity zero touches the stop there instead. ``away`` is the sign of velocities off
    it.

    Raises
    ------
    Undecided
        If that is not proven.
    """
    box = tube.box()
    shooting, states = equations.at(box[-1]), pairs(box[:-1])
    t, v = states[number]
    states[number] = t, v.intersection(between(arb(0), away * abs(v).upper()))
    n = len(states)
    before = (number - 1) % n
    for i in range(n):
        if i not in (before, number) and not meets_first(shooting, i, states):
            raise Undecided("graze", f"flight {i} passes through a stop before its end")
    start, _ = _flight(shooting, states, number)
    pace = width_of(shooting.system, flight_of(shooting.system, start, whole=True))
    for lift in LIFTS:
        with suppress(Undecided):
            if _slow_flights_are_clear(shooting, states, number, away, lift * pace):
                return states
    raise Undecided("graze", "whether the flights next to the slow impact meet no stop is open")


def _are_unstable(equations: Shooting, states: States, number: int) -> bool:
    """Return whether all orbits are proven to be unstable whose slow impact has some velocity.

    The velocity v before that impact is a divisor of their derivative over a period. Times v, that
    is known on all of a tube; if its trace is above 2 v and the determinant at most 1, a multiplier
    lies outside of the circle.
    """
    system = equations.system
    if any(system.damping(region) < 0 for region in system.regions):
        return False
    total: BallMatrix = (arb(1), arb(0)), (arb(0), arb(1))
    divisor = arb(0)
    with suppress(Undecided):
        for i in range(len(states)):
            start, s = _flight(equations, states, i)
            whole = flight_of(system, start, whole=True)
            (_, v, a), _ = whole.derivatives(s, 2)
            (x_t, x_v), (v_t, v_v) = moved = moved_by(start, whole, s)
            by_t, by_v = (-x_t, -x_v), (v * v_t - a * x_t, v * v_v - a * x_v)
            if (i + 1) % len(states) == number:
                divisor = v
            else:
                by_t, by_v = event_derivative(moved, (v, a))
            kept = -equations.next_event(i).passed(system, v).kept
            total = times((by_t, (kept * by_v[0], kept * by_v[1])), total)
        return bool(abs(total[0][0] + total[1][1]) > 2 * abs(divisor))
    return False


def _slow_flights_are_clear(
    equations: Shooting, states: States, number: int, away: int, lift: float
) -> bool:
    """Return whether the flights to and from a slow impact meet nothing but its stop there.

    From ``lift`` before to ``lift`` after it the acceleration points off the stop: by Taylor's
    theorem the motion is off it then. Before and after that, the search for the first event
    decides.
    """
    system, n = equations.system, len(states)
    before = (number - 1) % n
    start, s = _flight(equations, states, number)
    whole = flight_of(system, start, whole=True)
    # The time after the impact at an instant that is common to all orbits.
    instant = (states[number][0].upper() + lift).mid()
    lifted = between(arb(0), instant - states[number][0].lower())
    (x, _, a), _ = whole.derivatives(lifted, 2)
    into, duration = _flight(equations, states, before)
    arriving = flight_of(system, into, whole=True)
    late = duration.lower() - lift
    if not late > 0:
        return False
    (y, _, b), _ = arriving.derivatives(between(late, duration.upper()), 2)
    if not (away * a > 0 and away * b > 0):
        return False
    others = [level for level in levels_of(system, start.region) if level.bound != start.bound]
    if not all(level.sign * (z - level.at) > 0 for level in others for z in (x, y)):
        return False
    x, v = state_in_flight(system, start, instant)
    event = equations.events[number]
    after = Departure(event.after, Cloud.of(x, v), None, 1, Moment(instant))
    rest = states[number][0] + s - instant
    if before == number:
        # One flight leads from the impact to itself: the last part of it is covered by ``late``.
        left = rest.upper() - lift
        return bool(left < 0) or _meets_nothing(system, after, left)
    if not _meets_nothing(system, into, duration.upper() - lift):
        return False
    bracket, _, _ = bracket_within(system, after, 2.0 * largest_abs(rest))
    following = equations.next_event(number)
    return (
        bracket is not None
        and bracket.level.bound == following.bound
        and bracket.place_of(rest) == 0
    )


def _meets_nothing(system: BallSystem, start: Departure, longest: arb) -> bool:
    """Return whether all flights of a departure are proven to meet no bound in a time."""
    bracket, _, _ = bracket_within(system, start, largest_abs(longest))
    return bracket is None or bool(longest < bracket.low)
