"""Families of orbits by closed forms that hold exactly: subsets of the eigenset, reflections."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction

from flint import acb, arb, ctx

from percuss.certified.balls import Ball, Undecided
from percuss.certified.cloud import Cloud
from percuss.certified.first_root import Bracket
from percuss.certified.flight import EnclosedFlight
from percuss.certified.law import coarse_bits, system_for
from percuss.certified.numbers import ball, precision
from percuss.certified.properties import Monodromy, Proof, admissible_of
from percuss.certified.shooting import Link, Shooting, States, chain_of
from percuss.certified.statements import BITS, Verdict
from percuss.certified.step import (
    Departure,
    flight_of,
    landed,
    levels_of,
    search_along,
    width_of,
)
from percuss.certified.system import BallSystem, system_of
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_fraction
from percuss.model.oscillator import impact_oscillator
from percuss.motion.eigenset_forms import subset_forcing
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Rounds", "family_orbit", "first_impact", "keeps_subset", "odd_root", "returns_reversed"]


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
    if a != 0 or not k > 0:
        return False
    if not system.is_equilibrium(region, system.bounds[bound].at):
        return False
    roots = [odd_root(system.frequency(tone) ** 2 / k) for tone in system.tones]
    return all(root is not None and root >= 3 for root in roots)


def family_orbit(system: BallSystem, orbit: PeriodicOrbit) -> Proof:
    """Return the proof that an orbit, started exactly at its floats, is one of a family.

    Raises
    ------
    Undecided
        If the closed form above does not hold.
    """
    chain = chain_of(system, orbit)
    if _on_one_wall(system, chain) and not _fits(system, chain, orbit):
        return _round_orbit(system, orbit, chain)
    for link, following in zip(chain, [*chain[1:], chain[0]], strict=True):
        elastic = (
            not following.wall
            or system.numbers[f"oscillator.stops.{following.stop}.restitution"] == 1
        )
        if not (
            elastic
            and link.bound == following.bound
            and returns_reversed(system, link.after, link.bound)
        ):
            raise Undecided("precision", "no closed form is known for orbits that are not alone")
    if orbit.n_periods and not _fits(system, chain, orbit):
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    equations, states, before = _laid_out(system, chain, orbit)
    admissible, reason = admissible_of(equations, states)
    return _parabolic(chain, states, before, equations.period, admissible, reason)


def _on_one_wall(system: BallSystem, chain: list[Link]) -> bool:
    """Return whether there is one elastic wall alone, from which flights may return reversed."""
    return (
        len(system.bounds) == 1
        and all(link.wall for link in chain)
        and system.numbers["oscillator.stops.0.restitution"] == 1
        and returns_reversed(system, 0, 0)
    )


def _round_orbit(system: BallSystem, orbit: PeriodicOrbit, chain: list[Link]) -> Proof:
    """Return the proof for an orbit with flights of less than half a natural period."""
    n = len(chain)
    t, v = (
        arb(float(orbit.itinerary.vector[0])),
        ball(as_fraction(float(orbit.itinerary.vector[1 + n]))),
    )
    rounds = Rounds(system, t, v)
    states: States = []
    before = [arb(0)] * n
    for i in range(n):
        states.append((rounds.t, rounds.v))
        before[(i + 1) % n] = rounds.fly()
    if not rounds.is_closed:
        raise Undecided("precision", "no closed form is known for orbits that are not alone")
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    k = system.stiffness(system.regions[0])
    if frequency is None or (rounds.turns * frequency) ** 2 != 4 * orbit.n_periods**2 * k:
        raise Undecided("precision", "the flights do not add up to whole periods exactly")
    return _parabolic(chain, states, before, rounds.turns * rounds.half, True, "")


def _parabolic(
    chain: list[Link],
    states: States,
    before: list[arb],
    period: arb,
    admissible: bool | None,
    reason: str,
) -> Proof:
    """Return the proof of an orbit all of whose neighbours are periodic as well."""
    one, zero = arb(1), arb(0)
    identity = (one, zero), (zero, one)
    return Proof(
        chain=chain,
        states=states,
        before=before,
        period=period,
        monodromy=Monodromy(
            identity,
            arb(2),
            one,
            conservative=True,
            multipliers=(acb(1), acb(1)),
            stability="parabolic",
        ),
        admissible=admissible,
        isolated=False,
        unique_within=0.0,
        reason=reason,
    )


def _fits(system: BallSystem, chain: list[Link], orbit: PeriodicOrbit) -> bool:
    """Return whether the half periods add up to the forcing periods, exactly."""
    stiffnesses = {system.stiffness(system.regions[link.after]) for link in chain}
    frequency = None if orbit.forcing is None else orbit.forcing.frequency
    if frequency is None or len(stiffnesses) != 1:
        return False
    k = stiffnesses.pop()
    return len(chain) ** 2 * frequency**2 == 4 * orbit.n_periods**2 * k


def _laid_out(
    system: BallSystem, chain: list[Link], orbit: PeriodicOrbit
) -> tuple[Shooting, States, list[arb]]:
    """Return the events of the orbit that starts exactly at the floats of another."""
    n = len(chain)
    t, v = (
        arb(float(orbit.itinerary.vector[0])),
        ball(as_fraction(float(orbit.itinerary.vector[1 + n]))),
    )
    start = t
    states: States = []
    before = [arb(0)] * n
    for i, link in enumerate(chain):
        states.append((t, v))
        following = chain[(i + 1) % n]
        k = system.stiffness(system.regions[link.after])
        t = t + arb.pi() / ball(k).sqrt()
        before[(i + 1) % n] = -v
        v = following.kept(system) * -v
    return Shooting(system, chain, t - start), states, before


# A curve: zeros at which the first one is reflected in turn, none twice running.
Word = tuple[int, ...]


def first_impact(
    system: BallSystem, start: Departure, longest: float
) -> tuple[Bracket, EnclosedFlight, int]:
    """Return where a flight first meets a stop, for all of its starts.

    Raises
    ------
    Undecided
        If the balls leave it open, or it meets none in this time.
    """
    tries = sorted({coarse_bits(system), ctx.prec})
    for coarse in tries:
        with precision(coarse):
            whole = flight_of(system, start, whole=True)
            levels = levels_of(system, start.region)
            width = width_of(system, whole)
            search = search_along(system, whole, levels, start.bound, start.order, width)
            try:
                bracket = search.first(longest)
            except Undecided:
                if coarse == tries[-1]:
                    raise
                continue
        if bracket is not None:
            return bracket, whole, coarse
        break
    raise Undecided("no_event", "a flight meets no stop within a natural period")


@dataclass
class Rounds:
    """A motion on one wall, flight after flight, each zero by its name.

    Attributes
    ----------
    system
        The exact system; that its flights return reversed is for the caller to know.
    t, v
        Instant and velocity after the last impact; at first those of the start.
    half
        Half a natural period, P.
    word
        The curve that the motion now flies along; empty for that of the start.
    zero, turns
        Name of the zero it flies from, 0 that of the start, and by how many P this is later than
        when the zero was first found.
    zeros
        Of each curve the zeros that are known, by name, and when each was first found.
    """

    system: BallSystem
    t: arb
    v: arb
    half: arb = field(init=False)
    word: Word = ()
    zero: int = 0
    turns: int = 0
    zeros: dict[Word, set[int]] = field(init=False)
    times: list[arb] = field(init=False)

    def __post_init__(self) -> None:
        """Begin at the start."""
        self.half = arb.pi() / ball(self.system.stiffness(self.system.regions[0])).sqrt()
        self.zeros, self.times = {(): {0}}, [self.t]

    @property
    def is_closed(self) -> bool:
        """Whether the motion is where it began, exactly, ``turns`` half periods later."""
        return not self.word and self.zero == 0 and self.turns > 0

    def fly(self) -> arb:
        """Fly to the next impact, and return the velocity before it."""
        off = 1 if self.system.regions[0].lower == 0 else -1
        if not off * self.v > 0:
            raise Undecided("graze", "whether the motion leaves the wall is open")
        start = Departure(0, self.system.bounds[0].at, Cloud.of(self.t, self.v), 0)
        bracket, whole, coarse = first_impact(self.system, start, 2.0 * float(self.half))
        known = self._named(bracket)
        if known is None:
            there = landed(self.system, start, whole, bracket, coarse)
            self.t, before = there.box
            self.zero, self.turns = len(self.times), 0
            self.times.append(self.t)
            self.zeros[self.word].add(self.zero)
        else:
            full = known[0] == self.zero
            self.zero, self.turns = known
            before = -self.v
            if not full:
                before = landed(self.system, start, whole, bracket, coarse).box[1]
            self.t = self.times[self.zero] + self.turns * self.half
        self.v = -before
        cancels = bool(self.word) and self.word[-1] == self.zero
        self.word = self.word[:-1] if cancels else (*self.word, self.zero)
        self.zeros.setdefault(self.word, set()).add(self.zero)
        return before

    def _named(self, bracket: Bracket) -> tuple[int, int] | None:
        """Return the zero that the flight ends at, and its turns, None for a new one.

        In the bracket the flight has one zero only: one that lies there is that.
        """
        for zero in sorted(self.zeros[self.word]):
            if zero == self.zero:
                # Exactly, without the radius of the start.
                turns, s = self.turns + 1, self.half
            else:
                apart = (self.t - self.times[zero] + bracket.guess) / self.half
                turns = round(float(apart))
                s = self.times[zero] + turns * self.half - self.t
            where = bracket.place_of(s)
            if where == 0:
                return zero, turns
            if where is None:
                raise Undecided("precision", "whether a flight ends at a known zero is open")
        return None


# Of the constant: far narrower than what the search can tell.
CONSTANT_BITS = 4 * BITS


def keeps_subset(m: int, v0: Exact) -> Verdict:
    """Return whether the impacts of a start at t = 0 on the wall are those of Y_m, all of them.

    The oscillator is ``impact_oscillator()``, the force that of `percuss.subset_forcing` with
    its constant taken exactly, which in the model is a double.

    Parameters
    ----------
    m
        The longer gap in units of pi, >= 2.
    v0
        Velocity at the start [length/time], > 0.

    Returns
    -------
    Verdict
        For all impacts; open where the balls do not decide, as at the critical velocity itself.

    Raises
    ------
    ParameterError
        If m is not a whole number of at least 2, or v0 is negative.

    Examples
    --------
    The critical velocity for m = 5 is 3/2 (Dyskin et al. 2012, table 1):

    >>> [keeps_subset(5, v0).holds for v0 in ("1.4999999", "1.5000001")]
    [True, False]
    """
    force, start = subset_forcing(m), as_fraction(v0)
    if start < 0:
        raise ParameterError("v0", v0, "negative: into the wall")
    system = system_of(impact_oscillator(), force)
    with precision(CONSTANT_BITS):
        constant = Ball((arb.pi() / (m + 1)).cos())
    exact = system_for(system, {"forcing.constant": constant})
    try:
        with precision(BITS):
            return _verdict(exact, m, ball(start))
    except Undecided as question:
        return Verdict(None, math.inf, question.reason)


def _verdict(system: BallSystem, m: int, v0: arb) -> Verdict:
    pi = arb.pi()
    kick = 2 * (pi / (m + 1)).sin() / (m + 1)
    following = 2 * kick - v0 if m % 2 == 0 else v0
    # Long flights begin at 0, short ones at m pi, modulo the period (m+1) pi of the force.
    flights = [("long", arb(0), v0, m), ("short", m * pi, following, 1)]
    if m % 2 == 0:
        flights += [("long", arb(0), following, m), ("short", m * pi, v0, 1)]
    for k, (name, t, v, gap) in enumerate(flights):
        if not v > 0:
            if v < 0:
                reason = f"the flight before {name} flight {k // 2} would end out of the wall"
                return Verdict(False, math.inf, reason)
            raise Undecided("graze", "an impact has no velocity, within the radius")
        start = Departure(0, system.bounds[0].at, Cloud.of(t, v), 0)
        bracket, _, _ = first_impact(system, start, 1.01 * gap * math.pi)
        where = bracket.place_of(gap * pi)
        if where == 1:
            earlier = f"{name} flight {k // 2} meets the wall before {gap} pi"
            return Verdict(False, math.inf, earlier)
        if where != 0:
            raise Undecided("precision", f"the end of {name} flight {k // 2} is open")
    reason = f"{len(flights)} flights end on Y_{m} and not before, and those decide for all"
    return Verdict(True, math.inf, reason)
