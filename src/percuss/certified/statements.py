"""Statements about impact times that hold exactly, for the first N impacts or for all.

Let a wall with r = 1 lie at the equilibrium of a spring K without damping, and let every harmonic
have a whole multiple n >= 2 of sqrt(K) as its frequency. From an impact at t0, after half a
natural period pi/sqrt(K), the distance to the wall is twice what the even harmonics alone do at
t0: if that is zero, the mass is back at the wall exactly, and the velocity after the impact has
changed by -2 P', with P' the velocity of what the even harmonics alone do at t0. So the instants
t0 + k pi/sqrt(K) are impacts, unless one comes earlier. Flights two apart differ by
(V' - V) sin(sqrt(K) s)/sqrt(K) only: where the velocity does not fall, the first two flights
decide for all, and where it falls the last two (Dyskin et al. 2012, sections 3 and 4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, ctx

from percuss.certified.at_rest import first_push
from percuss.certified.balls import Ball
from percuss.certified.flight import Flight
from percuss.certified.law import Law, coarse_bits, law_of
from percuss.certified.numbers import ball, precision
from percuss.certified.step import levels_of, search_along, width_of
from percuss.certified.system import System, system_of
from percuss.certified.undecided import Undecided
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, angle, as_fraction, plain
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator

__all__ = ["Verdict", "critical_velocity", "keeps_eigenset"]

BITS = 192
MOST_DIGITS = 1000
# A touch is told from a passage with half the bits: twice those of the digits, and some.
BITS_PER_DIGIT, MARGIN = 7, 64


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is proven about a statement.

    Attributes
    ----------
    holds
        True and False are proven; None is open.
    n_impacts
        For how many impacts; `math.inf` for all.
    reason
        How it is proven, or what is open.
    """

    holds: bool | None
    n_impacts: float
    reason: str

    def __bool__(self) -> bool:
        """Whether the statement is proven to hold; what is open is not."""
        return self.holds is True

    def __str__(self) -> str:
        """Return the verdict in words."""
        words = {True: "certified", False: "certified to be false", None: "open"}
        return f"{words[self.holds]}: {self.reason}"


def keeps_eigenset(
    osc: Oscillator,
    force: Forcing | None,
    v0: Exact,
    t0: Phase = 0,
    n_impacts: int | None = None,
) -> Verdict:
    """Tell whether the impacts of a start on the wall are t0 + k pi/sqrt(K), exactly.

    Parameters
    ----------
    osc, force
        An oscillator with one wall; the forcing, None for free motion.
    v0
        Velocity at the wall at t0, off it [length/time].
    t0
        Instant of the start [time].
    n_impacts
        For how many impacts, >= 1, None for all of them.

    Returns
    -------
    Verdict
        Open where the closed form does not hold, or the balls do not decide.

    Raises
    ------
    ParameterError
        If the velocity at the one wall is into it, or `n_impacts` is no whole number of at least 1.

    Examples
    --------
    The critical velocity of the third harmonic is 1/2 (Dyskin et al. 2012, eq. 24):

    >>> import percuss as pc
    >>> wall = pc.impact_oscillator()
    >>> [keeps_eigenset(wall, pc.sine(3), v0).holds for v0 in ("0.5000001", "0.4999999")]
    [True, False]
    """
    if n_impacts is not None:
        n_impacts = _whole("n_impacts", n_impacts, math.inf)
    return _kept(system_of(osc, force), v0, t0, n_impacts, BITS)


def _whole(name: str, value: object, most: float) -> int:
    value = plain(value)
    if isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= most:
        return value
    limits = "of at least 1" if math.isinf(most) else f"from 1 to {most}"
    raise ParameterError(name, value, f"not a whole number {limits}")


def _kept(system: System, v0: Exact, t0: Phase, n_impacts: int | None, bits: int) -> Verdict:
    number = math.inf if n_impacts is None else n_impacts
    speed = as_fraction(v0)
    if len(system.bounds) == 1 and system.bounds[0].wall is not None:
        below = system.regions[0].lower == 0
        if speed and (speed < 0) is below:
            sign = "negative" if below else "positive"
            raise ParameterError("v0", v0, f"{sign}: into the wall")
    try:
        with precision(bits):
            return _Eigenset(system, speed, t0).verdict(number)
    except Undecided as question:
        return Verdict(None, number, question.reason)


def critical_velocity(
    osc: Oscillator, force: Forcing | None, low: Exact, high: Exact, digits: int = 12
) -> Ball:
    """Return the velocity at the wall above which all impacts are in the eigenset, as a ball.

    A greater velocity adds (V' - V) sin(sqrt(K) s)/sqrt(K), which is positive over the flight, to
    the distance to the wall: what keeps to the eigenset with V does so with each V' above it.

    Parameters
    ----------
    osc, force
        As for `keeps_eigenset`.
    low, high
        Velocities for which the impacts provably leave it, and keep to it.
    digits
        Decimal digits wanted, 1 to 1000; the precision follows them.

    Returns
    -------
    Ball
        Between a velocity for which they provably leave it and one for which they keep to it;
        as wide as these are apart.

    Raises
    ------
    ParameterError
        If low or high is not so, or `digits` is no such whole number.

    Examples
    --------
    >>> import percuss as pc
    >>> critical_velocity(pc.impact_oscillator(), pc.sine(3), "0.4", "0.6").contains("0.5")
    True
    """
    digits = _whole("digits", digits, MOST_DIGITS)
    below, above = as_fraction(low), as_fraction(high)
    bits = max(BITS, BITS_PER_DIGIT * digits + MARGIN)
    system = system_of(osc, force)

    def keeps(v0: Fraction) -> bool | None:
        return _kept(system, v0, 0, None, bits).holds

    for name, value, wanted in (("low", below, False), ("high", above, True)):
        verdict = keeps_eigenset(osc, force, value)
        if verdict.holds is not wanted:
            raise ParameterError(name, value, f"not proven to be {name}; {verdict}")
    for _ in range(bits):
        if above - below <= abs(below + above) / 2 / 10**digits:
            break
        middle = (below + above) / 2
        holds = keeps(middle)
        if holds is None:
            # The middle is the velocity itself, or too near to it: from its sides.
            moved = (above - below) / 64
            sides = [keeps(middle + side * moved) for side in (-1, 1)]
            if sides[0] is not False and sides[1] is not True:
                break
            below = middle - moved if sides[0] is False else below
            above = middle + moved if sides[1] is True else above
        elif holds:
            above = middle
        else:
            below = middle
    with precision(bits):
        return Ball(ball(below).union(ball(above)))


class _Eigenset:
    """The flights of a start on the wall, if the closed form holds."""

    def __init__(self, system: System, v0: Fraction, t0: Phase) -> None:
        self.system, self.v0 = system, v0
        self.times, self.plus = angle(t0)
        if len(system.bounds) != 1 or system.bounds[0].wall is None:
            raise Undecided("precision", "not one wall alone")
        self.sign = 1 if system.regions[0].lower == 0 else -1
        self.root, multiples = self._multiples()
        self.law: Law = law_of(system)
        self.turns = self.law.turns_at(t0)
        self.gain = self._gain(multiples)

    def _multiples(self) -> tuple[Fraction, list[int]]:
        """Return the stiffness, and each harmonic's frequency as a multiple of its root."""
        system, region = self.system, self.system.regions[0]
        k = system.stiffness(region)
        if system.damping(region) != 0 or not k > 0:
            raise Undecided("precision", "not a spring without damping")
        if system.numbers["oscillator.stops.0.restitution"] != 1:
            raise Undecided("precision", "not an elastic wall")
        if system.bounds[0].at * k != system.numbers["forcing.constant"]:
            raise Undecided("precision", "the wall is not at the equilibrium")
        found = []
        for tone in system.tones:
            ratio = system.frequency(tone) ** 2 / k
            root = math.isqrt(ratio.numerator)
            if ratio.denominator != 1 or root * root != ratio.numerator or root < 2:
                reason = "a harmonic is no whole multiple, 2 or more, of the natural frequency"
                raise Undecided("precision", reason)
            found.append(root)
        return k, found

    def _gain(self, multiples: list[int]) -> arb:
        """Return by how much the velocity off the wall grows at each impact."""
        flight = self._flight(self.turns, arb(0))
        place, speed = arb(0), arb(0)
        for wave, n in zip(flight.waves, multiples, strict=True):
            if n % 2 == 0:
                place, speed = place + wave.p, speed + wave.omega * wave.q
        if not place.is_zero():
            raise Undecided("precision", "the even harmonics do not vanish at the start, exactly")
        return -2 * speed * self.sign

    def verdict(self, n_impacts: float) -> Verdict:
        """Return the verdict for so many impacts."""
        speed = self.sign * ball(self.v0)
        if self.gain < 0 and math.isinf(n_impacts):
            reason = "the velocity falls from impact to impact, until they leave the eigenset"
            return Verdict(False, n_impacts, reason)
        first = 0
        if self.gain < 0:
            first = max(0, int(n_impacts) - 2)
        for k in (first, first + 1)[: int(min(n_impacts, 2))]:
            clear = self._is_clear(k, speed + k * self.gain)
            if not clear:
                earlier = f"flight {k} meets the wall before half a natural period"
                return Verdict(False, n_impacts, earlier)
        which = "the first two" if first == 0 else "the last two"
        reason = f"{which} flights meet the wall after half a natural period and not before"
        return Verdict(True, n_impacts, f"{reason}, and those decide for all")

    def _flight(self, turns: list[tuple[arb, arb]], v: arb, order: int = 1) -> Flight:
        return Flight(self.law, 0, turns, self.law.places[0], v, order)

    def _is_clear(self, k: int, speed: arb) -> bool:
        """Tell whether a flight meets the wall first after half a natural period."""
        turns = [
            (cosine, sine) if self._even(tone) or k % 2 == 0 else (-cosine, -sine)
            for (cosine, sine), tone in zip(self.turns, self.system.tones, strict=True)
        ]
        order = 1
        if speed.is_zero():
            order, way = first_push(self.law, 0, self.law.places[0], turns)
            if way != self.sign:
                return False
        elif speed < 0:
            return False
        half = arb.pi() / ball(self.root).sqrt()
        tries = sorted({coarse_bits(self.system), ctx.prec})
        for coarse in tries:
            with precision(coarse):
                flight = self._flight(turns, self.sign * speed, order)
                levels = levels_of(self.system, 0)
                width = width_of(self.system, flight)
                bound = levels[0].bound
                search = search_along(self.system, flight, levels, bound, order, width)
                try:
                    bracket = search.first(2.0 * float(half))
                except Undecided:
                    if coarse == tries[-1]:
                        raise
                    continue
            if bracket is not None and half > bracket.low and half < bracket.high:
                return True
            if bracket is not None and half > bracket.high:
                return False
            raise Undecided("precision", "the first impact is not told from half a period")
        raise Undecided("graze", "a turning point touches the wall within the radius")

    def _even(self, tone: object) -> bool:
        ratio = self.system.frequency(tone) ** 2 / self.root  # type: ignore[arg-type]
        return math.isqrt(ratio.numerator) % 2 == 0
