"""Statements about impact times that hold exactly, for the first N impacts or for all.

Let a wall with r = 1 lie at the equilibrium of a spring K without damping, and let every harmonic
have a whole multiple n >= 2 of sqrt(K) as its frequency. From an impact at t0, after half a
natural period pi/sqrt(K), the distance to the wall is twice what the even harmonics alone do at
t0: if that is zero, the mass is back at the wall exactly, and the velocity after the impact has
changed by -2 P', with P' the velocity of what the even harmonics alone do at t0. So the instants
t0 + k pi/sqrt(K) are impacts, unless one comes earlier. Every other flight differs by
(V' - V) sin(sqrt(K) s)/sqrt(K) only: where the velocity does not fall, the first two flights
decide for all, and where it falls the last two (Dyskin et al. 2012, sections 3 and 4). Whether it
falls, by however little, is decided in rationals where the harmonics' sines are rational at t0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from percuss.certified.ball_arithmetic import Ball, Undecided
from percuss.certified.ball_law import BallLaw, law_of, system_for
from percuss.certified.cloud import Cloud
from percuss.certified.contact import first_push_at, rational_terms
from percuss.certified.families import ReflectedMotion, is_one_elastic_wall
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import ball, precision, time_ball
from percuss.certified.pieces import Moment
from percuss.certified.step import Departure, first_bracket
from percuss.certified.system import BallSystem, Tone, system_of
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, as_fraction, pi_times, whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, impact_oscillator
from percuss.motion.eigenset_forms import subset_forcing

BITS = 192
# Of the constant of a subset's force: far narrower than what the search can tell.
CONSTANT_BITS = 4 * BITS
MOST_DIGITS, MOST_IMPACTS = 1000, 100_000
# Half the bits separate a touch from a passage: twice those of the digits, and some.
BITS_PER_DIGIT, MARGIN = 7, 64


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is proven about a statement.

    Attributes
    ----------
    holds
        True and False are proven; None is open.
    n_impacts
        The number of impacts that it is about; `math.inf` for all.
    reason
        The proof in words, or what is open.
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
    """Return whether the impacts of a start on the wall are t0 + k pi/sqrt(K), exactly.

    Parameters
    ----------
    osc, force
        An oscillator with one wall; the forcing, None for free motion.
    v0
        Velocity at the wall at t0, off it [length/time].
    t0
        Instant of the start [time].
    n_impacts
        The number of impacts, >= 1, None for all of them.

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
        n_impacts = whole("n_impacts", n_impacts, 1)
    return _kept(system_of(osc, force), v0, t0, n_impacts, BITS)


def _kept(system: BallSystem, v0: Exact, t0: Phase, n_impacts: int | None, bits: int) -> Verdict:
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

    A greater velocity V' adds (V' - V) sin(sqrt(K) s)/sqrt(K), which is positive over the flight,
    to the distance to the wall: a motion that keeps to the eigenset with V does so with V'.

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
        From a velocity for which they provably leave it to one for which they keep to it.

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
    digits = whole("digits", digits, 1, MOST_DIGITS)
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
            # The middle is the velocity itself, or too close to it: one of its sides decides.
            offset = (above - below) / 64
            sides = [keeps(middle + side * offset) for side in (-1, 1)]
            if sides[0] is not False and sides[1] is not True:
                break
            below = middle - offset if sides[0] is False else below
            above = middle + offset if sides[1] is True else above
        elif holds:
            above = middle
        else:
            below = middle
    with precision(bits):
        return Ball(ball(below).union(ball(above)))


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
            return _subset_verdict(exact, m, ball(start))
    except Undecided as question:
        return Verdict(None, math.inf, question.reason)


def _subset_verdict(system: BallSystem, m: int, v0: arb) -> Verdict:
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
        start = Departure(0, Cloud.of(t, v), 0)
        bracket, _, _ = first_bracket(system, start, 1.01 * gap * math.pi)
        place = bracket.place_of(gap * pi)
        if place == 1:
            earlier = f"{name} flight {k // 2} meets the wall before {gap} pi"
            return Verdict(False, math.inf, earlier)
        if place != 0:
            raise Undecided("precision", f"the end of {name} flight {k // 2} is open")
    reason = f"{len(flights)} flights end on Y_{m} and not before, and those decide for all"
    return Verdict(True, math.inf, reason)


def repeats_after(
    osc: Oscillator,
    force: Forcing | None,
    v0: Exact,
    n_impacts: int,
    t0: Phase = 0,
) -> Verdict:
    """Return whether a motion from the wall is periodic with so many impacts, exactly.

    Where it is, all motions nearby are as well: the derivative over the period is the identity.

    Parameters
    ----------
    osc, force
        An oscillator with an elastic wall at the equilibrium of its spring, without damping, and
        harmonics of odd multiples, 3 or more, of its frequency.
    v0
        Velocity at the wall at t0, off it [length/time].
    n_impacts
        After how many impacts it comes back, >= 1.
    t0
        Instant of the start [time].

    Returns
    -------
    Verdict
        True: the phase of the force and the velocity after the last of these impacts are those of
        the start. False: they are not. None where the balls leave it open, as next to a graze.

    Raises
    ------
    ParameterError
        If the number of impacts is not a whole one from 1 on.

    Examples
    --------
    Below the critical velocity of the third harmonic there are six impacts in 4 pi
    (docs/theory/third-harmonic.md), but for a part of the range:

    >>> import percuss as pc
    >>> wall = pc.impact_oscillator()
    >>> [repeats_after(wall, pc.sine(3), v0, 6).holds for v0 in ("0.45", "0.495")]
    [True, False]
    """
    n_impacts = whole("n_impacts", n_impacts, 1, MOST_IMPACTS)
    system = system_of(osc, force)
    try:
        with precision(BITS):
            if not is_one_elastic_wall(system):
                reason = "the closed form of flights that return reversed does not hold"
                return Verdict(None, n_impacts, reason)
            motion = ReflectedMotion(system, time_ball(t0), ball(as_fraction(v0)))
            return _return_verdict(motion, n_impacts)
    except Undecided as question:
        return Verdict(None, n_impacts, question.reason)


def _return_verdict(motion: ReflectedMotion, n: int) -> Verdict:
    """Return whether the motion returns: by its zeros, exactly, or else by its phase and velocity."""
    v_start = motion.v
    for _ in range(n):
        motion.fly()
    if motion.is_closed:
        reason = f"the last impact is at the start's zero, {motion.half_periods} half periods later"
        return Verdict(True, n, f"{reason}, exactly")
    system = motion.system
    # By what acts: a period that was given may be a multiple of the least.
    for omega in {system.frequency(tone) for tone in system.tones if system.strength(tone)}:
        turns = (motion.t - motion.times[0]) * ball(omega) / (2 * arb.pi())
        if not turns.contains_integer():
            return Verdict(False, n, "the last impact is at another phase of the force")
    if not motion.v.overlaps(v_start):
        return Verdict(False, n, "the velocity after the last impact is another one")
    raise Undecided("precision", "the motion comes back within the radius; no closed form says so")


class _Eigenset:
    """The flights of a start on the wall, if the closed form holds."""

    def __init__(self, system: BallSystem, v0: Fraction, t0: Phase) -> None:
        self.system, self.v0, self.t0 = system, v0, t0
        if system.irrational:
            raise Undecided("precision", "the closed form is of rational numbers")
        if system.record is not None:
            raise Undecided("precision", "the closed form is of harmonics, and there is a record")
        if len(system.bounds) != 1 or system.bounds[0].wall is None:
            raise Undecided("precision", "not one wall alone")
        self.sign = 1 if system.regions[0].lower == 0 else -1
        self.stiffness, self.multiples = self._multiples()
        self.law: BallLaw = law_of(system)
        self.gain = self._gain()

    def _multiples(self) -> tuple[Fraction, list[int]]:
        """Return the stiffness, and each harmonic's frequency as a multiple of its root."""
        system, region = self.system, self.system.regions[0]
        k = system.stiffness(region)
        if system.damping(region) != 0 or not k > 0:
            raise Undecided("precision", "not a spring without damping")
        if system.numbers.get("oscillator.stops.0.restitution") != 1:
            raise Undecided("precision", "not an elastic wall")
        if not system.is_equilibrium(region, system.bounds[0].at):
            raise Undecided("precision", "the wall is not at the equilibrium")
        multiples = []
        for tone in system.tones:
            ratio = system.frequency(tone) ** 2 / k
            root = math.isqrt(ratio.numerator)
            if ratio.denominator != 1 or root * root != ratio.numerator or root < 2:
                reason = "a harmonic is no whole multiple, 2 or more, of the natural frequency"
                raise Undecided("precision", reason)
            multiples.append(root)
        return k, multiples

    def _gain(self) -> Fraction | arb:
        """Return the growth of the velocity off the wall at each impact.

        A fraction wherever it is known as one, since its sign is then known too.
        """
        pairs = list(zip(self.system.tones, self.multiples, strict=True))
        even = [tone for tone, n in pairs if n % 2 == 0]
        place = self._at_start(even, 0)
        if place is None or place != 0:
            raise Undecided("precision", "the even harmonics do not vanish at the start, exactly")
        speed = self._at_start(even, 1)
        if speed is None:
            phasors = self.law.phasors_at(self.t0)
            waves = EnclosedFlight(self.law, 0, phasors, self.law.places[0], arb(0)).waves
            speeds = [
                w.omega * w.q for w, n in zip(waves, self.multiples, strict=True) if n % 2 == 0
            ]
            return -2 * self.sign * sum(speeds, arb(0))
        return -2 * self.sign * speed

    def _at_start(self, tones: list[Tone], order: int) -> Fraction | None:
        """Return position (order 0) or velocity (1) of the response to harmonics at the start.

        None where it is not surely rational.
        """
        terms = rational_terms(self.system, tones, self.t0, order)
        if terms is None:
            return None
        return sum((value / (self.stiffness - omega**2) for value, omega in terms), Fraction(0))

    def verdict(self, n_impacts: float) -> Verdict:
        """Return the verdict for so many impacts.

        Flights of the same harmonics differ by their velocity only, and the distance to the wall
        grows with it: the slowest of these decide, the first two where the velocity does not
        fall, the last two where it does. Where that is open, all four do.
        """
        if self.gain < 0 and math.isinf(n_impacts):
            reason = "the velocity falls from impact to impact, until they leave the eigenset"
            return Verdict(False, n_impacts, reason)
        rises, falls = bool(self.gain >= 0), bool(self.gain < 0)
        if not (rises or falls) and math.isinf(n_impacts):
            raise Undecided("precision", "whether the velocity falls from impact to impact is open")
        first = [] if falls else [0, 1]
        last = [] if rises else [int(n_impacts) - 2, int(n_impacts) - 1]
        deciding = sorted({k for k in (*first, *last) if 0 <= k < n_impacts})
        if any(self._velocity(k) < 0 for k in deciding):
            reason = "the velocity is used up before the last of these impacts"
            return Verdict(False, n_impacts, reason)
        for k in deciding:
            if not self._is_clear(k):
                reason = f"flight {k} meets the wall before half a natural period"
                return Verdict(False, n_impacts, reason)
        which = "the first two" if rises else "the last two" if falls else "the first and last two"
        reason = f"{which} flights meet the wall after half a natural period and not before"
        return Verdict(True, n_impacts, f"{reason}, and those decide for all")

    def _start_of(self, k: int) -> Phase:
        """Return the start of a flight, so many half natural periods after the first."""
        if not self.system.tones:
            # Nothing depends on it, and the root of the stiffness may be irrational.
            return self.t0
        natural = self.system.frequency(self.system.tones[0]) / self.multiples[0]
        return pi_times(k / natural) + self.t0

    def _velocity(self, k: int) -> arb:
        """Return the velocity off the wall with which a flight begins.

        A sum of rationals is rounded once: zero stays zero, and no sign is lost.
        """
        start = self.sign * self.v0
        if isinstance(self.gain, Fraction):
            return ball(start + k * self.gain)
        return ball(start) + k * self.gain

    def _is_clear(self, k: int) -> bool:
        """Return whether a flight meets the wall first after half a natural period."""
        speed, time = self._velocity(k), self._start_of(k)
        t, order = time_ball(time), 1
        if speed.is_zero():
            order, direction = first_push_at(self.law, 0, 0, Moment(t, time))
            if direction != self.sign:
                return False
        half = arb.pi() / ball(self.stiffness).sqrt()
        cloud = Cloud.of(t.mid(), self.sign * speed)
        start = Departure(0, cloud, 0, order, Moment(t, time))
        bracket, _, _ = first_bracket(self.system, start, 2.0 * float(half))
        position = bracket.place_of(half)
        if position is None or position < 0:
            raise Undecided("precision", "whether the first impact is after half a period is open")
        return position == 0
