"""Families of orbits by closed forms that hold exactly: flights that return reversed, reflections.

Let an elastic wall lie at the equilibrium of a spring without damping, under odd harmonics of its
frequency: each flight of half a natural period returns with its velocity reversed, whatever that
is. Shorter flights are reflections of curves that were flown before (docs/theory/certified.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias

from flint import acb, arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.cloud import Cloud
from percuss.certified.first_root import Bracket
from percuss.certified.numbers import ball
from percuss.certified.properties import Monodromy, Proof, admissible_of
from percuss.certified.shooting import OrbitEvent, Shooting, States, events_of
from percuss.certified.step import Departure, first_bracket, landed
from percuss.certified.system import BallSystem
from percuss.model.exact import as_fraction
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

# A curve: zeros at which the first one is reflected in turn, none twice running.
Word: TypeAlias = tuple[int, ...]


def odd_root(ratio: Fraction) -> int | None:
    """Return the odd whole number whose square this is, None if it is none.

    Examples
    --------
    >>> odd_root(Fraction(9)), odd_root(Fraction(4)), odd_root(Fraction(2))
    (3, None, None)
    """
    if ratio.denominator != 1 or ratio < 1:
        return None
    root = math.isqrt(ratio.numerator)
    return root if root * root == ratio.numerator and root % 2 else None


def returns_reversed(system: BallSystem, region_number: int, bound: int) -> bool:
    """Return whether all flights of a region from a bound to it reverse their velocity, exactly."""
    region = system.regions[region_number]
    k, a = system.stiffness(region), system.damping(region)
    if system.irrational or system.record is not None or a != 0 or not k > 0:
        return False
    if not system.is_equilibrium(region, system.bounds[bound].at):
        return False
    roots = [odd_root(system.frequency(tone) ** 2 / k) for tone in system.tones]
    return all(root is not None and root >= 3 for root in roots)


def is_one_elastic_wall(system: BallSystem) -> bool:
    """Return whether there is one elastic wall alone, to which all flights return reversed."""
    return (
        len(system.bounds) == 1
        and system.bounds[0].wall is not None
        and system.numbers.get("oscillator.stops.0.restitution") == 1
        and returns_reversed(system, 0, 0)
    )


def family_orbit(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    """Return the proof that an orbit, started exactly at its floats, is one of a family."""
    events = events_of(system, orbit)
    if is_one_elastic_wall(system) and not _is_full(system, events, orbit):
        return _reflected_orbit(system, orbit, events)
    for event, following in zip(events, [*events[1:], events[0]], strict=True):
        elastic = (
            not following.wall
            or system.numbers.get(f"oscillator.stops.{following.stop}.restitution") == 1
        )
        if not (
            elastic
            and event.bound == following.bound
            and returns_reversed(system, event.after, event.bound)
        ):
            raise Undecided("precision", "no closed form is known for orbits that are not isolated")
    if orbit.n_periods and not _is_full(system, events, orbit):
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    equations, states, before = _full_flights(system, events, orbit)
    admissible, reason = admissible_of(equations, states)
    return _parabolic(events, states, before, equations.period, admissible, reason)


def _start_of(orbit: PeriodicOrbit) -> tuple[arb, arb]:
    """Return instant and velocity after the first event, exactly the floats."""
    unknowns = orbit.itinerary.vector
    v = as_fraction(float(unknowns[1 + len(orbit.itinerary)]))
    return arb(float(unknowns[0])), ball(v)


def _reflected_orbit(system: BallSystem, orbit: PeriodicOrbit, events: list[OrbitEvent]) -> Proof:
    """Return the proof for an orbit with flights shorter than half a natural period."""
    motion = ReflectedMotion(system, *_start_of(orbit))
    states: States = []
    before: list[arb] = []
    for _ in events:
        states.append((motion.t, motion.v))
        before.append(motion.fly())
    if not motion.is_closed:
        raise Undecided("precision", "no closed form is known for orbits that are not isolated")
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    k = system.stiffness(system.regions[0])
    if frequency is None or (motion.half_periods * frequency) ** 2 != 4 * orbit.n_periods**2 * k:
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    period = motion.half_periods * motion.half
    return _parabolic(events, states, [before[-1], *before[:-1]], period, True, "")


def _parabolic(
    events: list[OrbitEvent],
    states: States,
    before: list[arb],
    period: arb,
    admissible: bool | None,
    reason: str,
) -> Proof:
    """Return the proof of an orbit all of whose neighbours are periodic as well."""
    one, zero = arb(1), arb(0)
    monodromy = Monodromy.of(((one, zero), (zero, one)), one, conservative=True)
    # Exactly the identity, where balls leave the stability open.
    monodromy = replace(monodromy, multipliers=(acb(1), acb(1)), stability="parabolic")
    return Proof(
        events, states, before, period, monodromy, admissible, isolated=False, reason=reason
    )


def _is_full(system: BallSystem, events: list[OrbitEvent], orbit: PeriodicOrbit) -> bool:
    """Return whether half natural periods add up to the forcing periods, exactly."""
    stiffnesses = {system.stiffness(system.regions[event.after]) for event in events}
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    if frequency is None or len(stiffnesses) != 1:
        return False
    k = stiffnesses.pop()
    return len(events) ** 2 * frequency**2 == 4 * orbit.n_periods**2 * k


def _full_flights(
    system: BallSystem, events: list[OrbitEvent], orbit: PeriodicOrbit
) -> tuple[Shooting, States, list[arb]]:
    """Return equations, states and velocities before the events of an orbit of full flights."""
    t, v = start, _ = _start_of(orbit)
    states: States = []
    before: list[arb] = []
    for event, following in zip(events, [*events[1:], events[0]], strict=True):
        states.append((t, v))
        k = system.stiffness(system.regions[event.after])
        t = t + arb.pi() / ball(k).sqrt()
        before.append(-v)
        v = following.passed(system, -v).after
    return Shooting(system, events, t - start), states, [before[-1], *before[:-1]]


@dataclass
class ReflectedMotion:
    """A motion on one wall, flight after flight, with a name for each zero of its curves.

    Attributes
    ----------
    system
        The exact system; its flights must return reversed (`returns_reversed`).
    t, v
        Instant and velocity after the last impact; at first those of the start.
    half
        Half a natural period, P.
    word
        The curve of the present flight; empty for that of the start.
    zero, half_periods
        Name of the zero at which the flight begins, 0 at the start, and by how many P this is
        later than when the zero was first found.
    zeros, times
        Names of the known zeros of each curve, and when each was first found.
    """

    system: BallSystem
    t: arb
    v: arb
    half: arb = field(init=False)
    word: Word = ()
    zero: int = 0
    half_periods: int = 0
    zeros: dict[Word, set[int]] = field(init=False)
    times: list[arb] = field(init=False)

    def __post_init__(self) -> None:
        """Begin at the start."""
        self.half = arb.pi() / ball(self.system.stiffness(self.system.regions[0])).sqrt()
        self.zeros, self.times = {(): {0}}, [self.t]

    @property
    def is_closed(self) -> bool:
        """Whether the motion is where it began, exactly, ``half_periods`` half natural periods later."""
        return not self.word and self.zero == 0 and self.half_periods > 0

    def fly(self) -> arb:
        """Fly to the next impact, and return the velocity before it."""
        off = 1 if self.system.regions[0].lower == 0 else -1
        if not off * self.v > 0:
            raise Undecided("graze", "whether the motion leaves the wall is open")
        start = Departure(0, Cloud.of(self.t, self.v), 0)
        bracket, whole, coarse = first_bracket(self.system, start, 2.0 * float(self.half))
        known = self._known_zero(bracket)
        if known is None:
            self.t, before = landed(self.system, start, whole, bracket, coarse).box
            self.zero, self.half_periods = len(self.times), 0
            self.times.append(self.t)
            self.zeros[self.word].add(self.zero)
        else:
            full = known[0] == self.zero
            self.zero, self.half_periods = known
            before = -self.v
            if not full:
                before = landed(self.system, start, whole, bracket, coarse).box[1]
            self.t = self.times[self.zero] + self.half_periods * self.half
        self.v = -before
        cancels = bool(self.word) and self.word[-1] == self.zero
        self.word = self.word[:-1] if cancels else (*self.word, self.zero)
        self.zeros.setdefault(self.word, set()).add(self.zero)
        return before

    def _known_zero(self, bracket: Bracket) -> tuple[int, int] | None:
        """Return the zero at which the flight ends, and its half periods, None for a new one.

        In the bracket the flight has one zero only: a known one that lies there is that zero.
        """
        for zero in sorted(self.zeros[self.word]):
            if zero == self.zero:
                # Exactly, without the radius of the start.
                half_periods, s = self.half_periods + 1, self.half
            else:
                later = (self.t - self.times[zero] + bracket.guess) / self.half
                half_periods = round(float(later))
                s = self.times[zero] + half_periods * self.half - self.t
            place = bracket.place_of(s)
            if place == 0:
                return zero, half_periods
            if place is None:
                raise Undecided("precision", "whether a flight ends at a known zero is open")
        return None
