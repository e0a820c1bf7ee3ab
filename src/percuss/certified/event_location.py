"""The root in a bracket as a ball: Newton's steps, then an interval Newton step as the proof."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from typing import NamedTuple

from flint import arb, arb_poly, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.first_root import Bracket, Level
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import constant_of, largest_abs, precision, span

# Newton's steps; each doubles the digits.
MOST_STEPS = 40
# Interval steps, each in a trial that is wider by a factor.
TRIALS, WIDER = 4, 4
# A flight this short, as a part of the time in which anything changes, is summed by Taylor.
SHORT = 0.05
MOST_TERMS = 600
# How long a trial may be, as a part of the same time: on longer ones the velocity hardly keeps its
# sign. The bounds hold on any.
NARROW = 0.4


def interval_newton(value: arb, slope: Callable[[arb], arb], trial: arb) -> tuple[arb, arb]:
    """Return the interval Newton step to the one root of a function, and the trial around it.

    Parameters
    ----------
    value
        The function at the point from which the step leads.
    slope
        Its derivative within a trial, the distance from that point.
    trial
        The distance to begin with.
    """
    for _ in range(TRIALS):
        step = -(value / slope(trial))
        if step.abs_upper() <= trial:
            return step, trial
        trial = WIDER * trial
    raise Undecided("precision", "no interval Newton step stays within its trial")


class TooManyTerms(Exception):  # noqa: N818
    """The series of a hop converges too slowly for so many bits."""


class Landing(NamedTuple):
    """The time of flight, and velocity and acceleration at its end.

    Within ``isolating`` each of the flights has this root only.
    """

    s: arb
    v: arb
    a: arb
    isolating: arb


class Roots(NamedTuple):
    """The landing of the midpoint, to all bits, and that of the whole set."""

    point: Landing
    whole: Landing


def solve(
    point: EnclosedFlight,
    whole: EnclosedFlight,
    bracket: Bracket,
    bits: int,
    *,
    summed: bool = True,
    isolation: arb | None = None,
) -> Roots:
    """Return the landings in a bracket of the flight from a midpoint, and of those from the set.

    Parameters
    ----------
    point, whole
        The flight, made at the working precision, and the flights, made at ``bits``.
    bracket
        Where the roots of all of them are.
    bits
        Precision for the set.
    summed
        Whether short hops may be summed by their series.
    isolation
        Distance from the root within which others are to be excluded, where that can be done; None
        for what the proof needs.

    Raises
    ------
    Undecided
        If the balls leave open whether these are the roots, of one and the same branch.
    """
    pace = pace_of(whole)
    if summed and bracket.from_start and min(bracket.high, 2.0 * bracket.guess) * pace < SHORT:
        with contextlib.suppress(TooManyTerms):
            return roots_near(point, whole, bracket, bits, isolation)
    level = bracket.level
    start = newton(point, level, bracket.guess, bracket)
    return _both(
        lambda: _landing(point, level, start),
        lambda within: _landing(whole, level, +start, within),
        start,
        bracket,
        bits,
        isolation,
    )


def _both(
    of_point: Callable[[], Landing],
    of_whole: Callable[[arb | None], Landing],
    start: arb,
    bracket: Bracket,
    bits: int,
    isolation: arb | None,
) -> Roots:
    """Return the landings of the midpoint and of the set, of one and the same root each."""
    first = of_point()
    with precision(bits):
        second = of_whole(isolation)
        if not second.isolating.contains(first.s):
            second = of_whole(4 * (first.s - start).abs_upper())
        if not second.isolating.contains(first.s):
            raise Undecided("precision", "two roots of a flight are not separated")
        if not (second.s > bracket.low and second.s < bracket.high):
            raise Undecided(
                "precision", "the box of motions is too wide for its impact to be enclosed"
            )
        if not (first.s > bracket.low and first.s < bracket.high):
            raise Undecided("precision", "the root is at the end of its bracket")
    return Roots(first, second)


def pace_of(flight: EnclosedFlight) -> float:
    """Return the rate of the fastest change of a flight."""
    damping = largest_abs(constant_of(flight.region.damping))
    return max([flight.region.pace, damping, *(wave.pace for wave in flight.waves)])


def is_narrow(flight: EnclosedFlight, trial: arb) -> bool:
    """Return whether a trial is short beside all times of a flight."""
    return bool(trial * pace_of(flight) < NARROW)


def newton(flight: EnclosedFlight, level: Level, guess: float, bracket: Bracket) -> arb:
    """Return about where a flight crosses a level, an exact number."""
    s = arb(guess)
    for _ in range(MOST_STEPS):
        (x, v), _ = flight.derivatives(s, 1)
        gap = x - level.at
        step = (gap / v).mid()
        moved = (s - step).mid()
        if not (moved >= bracket.low and moved <= bracket.high):
            moved = ((s + (bracket.low if step > 0 else bracket.high)) / 2).mid()
        # Nothing is left of the distance but its rounding.
        if gap.abs_lower() < 4 * gap.rad():
            return moved
        s = moved
    return s


def _landing(flight: EnclosedFlight, level: Level, s: arb, isolation: arb | None = None) -> Landing:
    """Return the crossing nearest to s, proven by an interval Newton step."""
    (x, v, a, j), size = flight.derivatives(s, 3)
    gap = x - level.at
    if not (v > 0 or v < 0):
        raise Undecided("graze", "an impact may be without velocity")

    def slope(trial: arb) -> arb:
        if not is_narrow(flight, trial):
            reason = "the box is too wide: the instant of an event is known to within "
            reason += f"{float(trial):.2g}, beyond {NARROW / pace_of(flight):.2g}"
            raise Undecided("precision", reason)
        fourth = fourth_around(flight, s, trial, size)
        bend = span(a.abs_upper() + trial * (j.abs_upper() + trial * fourth))
        if (v + bend * trial).contains(0):
            reason = "the velocity of an event may be zero at some of the instants that it may "
            reason += f"be at, within {float(trial):.2g}"
            raise Undecided("graze", reason)
        return v + bend * trial

    step, trial = _widest_step(gap, slope, 2 * gap.abs_upper() / v.abs_lower(), isolation)
    jerk = j + span(trial * fourth_around(flight, s, trial, size))
    mean = a + step * span(jerk.abs_upper())
    return Landing(s + step, v + step * mean, a + step * jerk, s + span(trial))


def _widest_step(
    value: arb, slope: Callable[[arb], arb], needed: arb, isolation: arb | None
) -> tuple[arb, arb]:
    """Return an interval Newton step: if it can be, in a trial without other roots."""
    if isolation is not None and not isolation <= needed:
        with contextlib.suppress(Undecided):
            return interval_newton(value, slope, needed.max(isolation))
    return interval_newton(value, slope, needed)


def fourth_around(flight: EnclosedFlight, s: arb, trial: arb, size: float) -> float:
    """Return a bound of the fourth derivative within a trial around s.

    Backwards a dashpot makes the norm of `EnclosedFlight.bound` grow, by exp(2 abs(a) h) at most.
    """
    h = 1.001 * float(trial)
    backwards = math.exp(2.001 * largest_abs(constant_of(flight.region.damping)) * h)
    return backwards * flight.bound(4, float(s), h, size)


def roots_near(
    point: EnclosedFlight,
    whole: EnclosedFlight,
    bracket: Bracket,
    bits: int,
    isolation: arb | None = None,
) -> Roots:
    """Return the landings of hops far shorter than all times of the motion.

    They return to the level that they left; their Taylor series at the start, divided by s^m
    where the m-th derivative is the first, keeps all bits however low the hop.
    """
    sign, m = bracket.level.sign, point.order
    # Beyond the root or the bracket's end, as the trials of the interval steps reach.
    longest = min(2.0 * bracket.high, 4.0 * bracket.guess)
    series = _Series(point, sign, m, longest, ctx.prec)
    start = series.newton(bracket.guess)
    with precision(bits):
        coarse = _Series(whole, sign, m, longest, bits)
    return _both(
        lambda: series.landing(start),
        lambda within: coarse.landing(+start, within),
        start,
        bracket,
        bits,
        isolation,
    )


def _log2(value: arb) -> float:
    """Return about the logarithm of a positive number, minus infinity of zero."""
    return -math.inf if value.is_zero() else float(value.log()) / math.log(2)


class _Series:
    """The Taylor series of a flight at its start, and that of its distance divided by s^m."""

    def __init__(
        self, flight: EnclosedFlight, sign: int, m: int, longest: float, bits: int
    ) -> None:
        # The quotient by s^m is as small as its first coefficient.
        first = constant_of(flight.taylor(max(m, 2))[m])
        if first.contains(0):
            raise Undecided("graze", "whether a hop leaves its stop is open")
        scale = _log2(abs(first).lower())
        n = 8
        while True:
            bound = flight.series_bound(n + 1, longest)
            # In logarithms: the terms may be beyond the floats.
            small = _log2(bound) + (n + 1 - m) * math.log2(longest)
            small -= math.lgamma(n + 2) / math.log(2)
            if small < scale - bits - 10 or n > MOST_TERMS:
                break
            n += 8
        if n > MOST_TERMS:
            raise TooManyTerms
        series = [constant_of(c) for c in flight.taylor(n)]
        series[0] = arb(0)
        self.n, self.m, self.bound = n, m, bound
        self.whole = arb_poly([sign * c for c in series])
        self.divided = arb_poly([sign * c for c in series[m:]])
        self.sign, self.longest = sign, longest

    def rest(self, s: arb, k: int) -> arb:
        """Return the remainder of the k-th derivative of the distance at s."""
        power = self.n + 1 - k
        return span(self.bound * s.abs_upper() ** power / arb(power).fac())

    def newton(self, guess: float) -> arb:
        """Return about where the distance is zero."""
        slope = self.divided.derivative()
        s = arb(guess)
        for _ in range(MOST_STEPS):
            value = self.divided(s)
            step = (value / slope(s)).mid()
            s = (s - step).mid()
            if value.abs_lower() < 4 * value.rad() or abs(step) < s * arb(2) ** (2 - ctx.prec):
                return s
        return s

    def landing(self, s: arb, isolation: arb | None = None) -> Landing:
        """Return the crossing nearest to s, proven by an interval Newton step."""
        m = self.m
        value = self.divided(s) + self.rest(s, 0) / s**m
        slopes = self.divided.derivative()

        def slope(trial: arb) -> arb:
            around = s + span(trial)
            if not around < self.longest:
                reason = "the balls are too wide for the end of a hop, by the hop itself"
                raise Undecided("precision", reason)
            # R'/s^m - m R/s^(m+1) is the slope of the remainder's quotient.
            rest = self.rest(around, 1) / around**m + m * self.rest(around, 0) / around ** (m + 1)
            if (slopes(around) + rest).contains(0):
                raise Undecided("graze", "a hop may end without velocity, within the radius")
            return slopes(around) + rest

        needed = 2 * value.abs_upper() / slopes(s).abs_lower()
        step, trial = _widest_step(value, slope, needed, isolation)
        at, speeds = s + step, self.whole.derivative()
        v = speeds(at) + self.rest(at, 1)
        a = speeds.derivative()(at) + self.rest(at, 2)
        return Landing(at, self.sign * v, self.sign * a, s + span(trial))
