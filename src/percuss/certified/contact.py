"""A mass at a wall: the end of a chatter, contact, release, and the force that moves it from rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw, coarse_bits, constant_of, law_of
from percuss.certified.event_location import interval_newton
from percuss.certified.first_root import Bracket, Level
from percuss.certified.flight import Push
from percuss.certified.numbers import (
    ball,
    between,
    precision,
    span,
    time_ball,
    upper,
)
from percuss.certified.step import search_along
from percuss.certified.system import BallSystem, Tone
from percuss.model.exact import Phase, angle, rational_cosine

__all__ = [
    "Hold",
    "Hops",
    "Released",
    "chatter_end",
    "first_push",
    "first_push_at",
    "rational_terms",
    "release",
    "rests_for_ever",
]


# Derivatives of the force that are computed before it counts as undecided.
LAST_ORDER = 12
MOST_STEPS = 60


def rests_for_ever(law: BallLaw, region: int, x: Fraction) -> bool:
    """Return whether no force ever acts on a mass at rest; False where a number is a range."""
    if not law.system.is_exact:
        return False
    amplitudes = (law.system.strength(tone) for tone in law.system.tones)
    return _force_at_rest(law, region, x) == 0 and not any(amplitudes)


def first_push_at(
    law: BallLaw, region: int, x: Fraction, t: arb, time: Phase | None = None
) -> tuple[int, int]:
    """Return the order and the sign of the first derivative of x that moves a mass at rest.

    Returns (0, 0) where the force is zero for ever. ``time`` is the instant t exactly, where it is
    known so.
    """
    if rests_for_ever(law, region, x):
        return 0, 0
    if time is None:
        return first_push(law, region, ball(x), law.phasors(t))
    phasors = law.phasors_at(time)
    return first_push(law, region, ball(x), phasors, partial(_derivative, law, region, x, time))


def first_push(
    law: BallLaw,
    region: int,
    x: arb,
    phasors: list[tuple[arb, arb]],
    exact: Callable[[int], Fraction | None] = lambda _: None,
) -> tuple[int, int]:
    """Return order and sign as `first_push_at`, from phasors and the rational derivatives known."""
    push = Push(law, region, phasors, x, 0)
    waves = (constant_of(part) for _, at, slope in push.drive for part in (at, slope))
    if constant_of(push.rest).is_zero() and all(part.is_zero() for part in waves):
        return 0, 0
    for order, value in enumerate(push.taylor(LAST_ORDER)):
        number = constant_of(value)
        if number > 0 or number < 0:
            return order + 2, 1 if number > 0 else -1
        if number.is_zero():
            continue
        rational = exact(order)
        if rational is None:
            reason = "the force on a mass at rest on a stop may be zero or not"
            raise Undecided("force", reason)
        if rational != 0:
            return order + 2, 1 if rational > 0 else -1
    raise Undecided("force", f"{LAST_ORDER} derivatives of the force are zero where it rests")


def _force_at_rest(law: BallLaw, region: int, x: Fraction) -> Fraction:
    """Return the force without harmonics on a mass at rest."""
    linear = law.system.regions[region]
    return law.system.constant(linear) - law.system.stiffness(linear) * x


def _derivative(law: BallLaw, region: int, x: Fraction, time: Phase, order: int) -> Fraction | None:
    """Return a derivative of the force at an exact time, None where it is not surely rational."""
    if not law.system.is_exact:
        return None
    terms = rational_terms(law.system, law.system.tones, time, order)
    if terms is None:
        return None
    constant = _force_at_rest(law, region, x) if order == 0 else Fraction(0)
    return constant + sum(value for value, _ in terms)


def rational_terms(
    system: BallSystem, tones: Sequence[Tone], time: Phase, order: int
) -> list[tuple[Fraction, Fraction]] | None:
    """Return a derivative of each harmonic at an exact time, and its frequency, as rationals.

    None where one is not surely rational.
    """
    times, plus = angle(time)
    terms = []
    for tone in tones:
        omega = system.frequency(tone)
        phase = tone.phase[0] + omega * times + Fraction(order, 2)
        cosine = rational_cosine(phase, tone.phase[1] + omega * plus)
        if cosine is None:
            return None
        terms.append((system.strength(tone) * omega**order * cosine, omega))
    return terms


class Hold(NamedTuple):
    """A contact: region, bound and start, and order of the force's first derivative not zero there."""

    region: int
    bound: int
    since: arb
    order: int = 0
    time: Phase | None = None


class Hops(NamedTuple):
    """The hops of a chatter after the last listed one: balls of their end and of all states."""

    end: arb
    x: arb
    v: arb


class Released(NamedTuple):
    """The instant of a release; None where it never comes, or not by the end."""

    t: arb | None
    for_ever: bool


def chatter_end(
    system: BallSystem,
    region: int,
    bound: int,
    sign: int,
    box: tuple[arb, arb],
    restitution: arb,
    finest: arb,
) -> Hops | None:
    """Return the end of the hops after an impact, None where its enclosure is too wide yet.

    With the acceleration towards the wall between P1 and P2 throughout, hops are between 2 u/P2
    and 2 u/P1 long and end with speeds between u (P1/P2)^(1/2) and u (P2/P1)^(1/2): the sum lies
    between two geometric series (docs/theory/certified.md).

    Parameters
    ----------
    region, bound, sign
        The wall: sign is +1 at a wall below.
    box
        Instant, and speed u > 0 after the impact.
    restitution
        Below 1.
    finest
        Greatest half-width of the instant.
    """
    law = law_of(system)
    linear = law.regions[region]
    t, speed = box
    x = law.places[bound]
    push = Push(law, region, law.phasors(t), x, 0)
    force = -sign * sum((at for _, at, _ in push.drive), push.rest)
    if not force > 0:
        return None
    longest = 8 * speed.abs_upper() / (force.abs_lower() * (1 - restitution))
    # Up to twice the speed and twice the height are allowed for; neither is reached.
    fast, high = 2 * speed.abs_upper(), speed.abs_upper() ** 2 / force.abs_lower() * 2
    change = sum((wave.size * wave.pace for wave in push.waves), 0.0) * 1.00001
    doubt = longest * change + 2 * abs(linear.damping) * fast + abs(linear.stiffness) * high
    least, most = force.abs_lower() - doubt, force.abs_upper() + doubt
    if not (least > 0 and 2 * least > force.abs_lower()):
        return None
    ratio = (most / least).sqrt()
    if not (ratio < 2 and restitution * ratio < arb("0.999999999")):
        return None
    late = 2 * speed / least / (1 - restitution * ratio)
    early = 2 * speed / most / (1 - restitution / ratio)
    ends = system.regions[region]
    opposite = ends.upper if sign > 0 else ends.lower
    if not late < longest or not (opposite is None or sign * (law.places[opposite] - x) > high):
        return None
    end = between(t + early, t + late)
    if not end.rad() < finest:
        return None
    return Hops(end, x + sign * between(arb(0), high), span(fast))


def release(system: BallSystem, hold: Hold, end: arb) -> Released:
    """Return the end of a contact: the first change of sign of the force towards the wall."""
    question = None
    for coarse in sorted({coarse_bits(system), ctx.prec}):
        try:
            return _release(system, hold, end, coarse)
        except Undecided as open_question:
            if open_question.kind != "graze":
                raise
            question = open_question
    assert question is not None
    if question.graze is None:
        raise question
    reason = f"the force on the mass at rest comes within {question.graze.clearance:.3g} of zero"
    raise Undecided("graze", reason, question.graze)


def _push_of(system: BallSystem, hold: Hold, since: arb) -> Push:
    law = law_of(system)
    phasors = law.phasors(since) if hold.time is None else law.phasors_at(hold.time)
    return Push(law, hold.region, phasors, law.places[hold.bound], hold.order)


def _release(system: BallSystem, hold: Hold, end: arb, coarse: int) -> Released:
    sign = 1 if system.regions[hold.region].lower == hold.bound else -1
    with precision(coarse):
        since = hold.since
        push = _push_of(system, hold, since)
        if hold.time is None and -sign * push.derivatives(arb(0), 1)[0][0] > 0:
            # It holds at all instants at which the contact may begin: one of them stands for all.
            since = since.mid()
            push = _push_of(system, hold, since)
        level = Level(hold.bound, -sign, arb(0))
        moving = any(system.strength(tone) for tone in system.tones)
        if (system.is_exact and not moving) or _holds_for_ever(push, sign):
            return Released(None, for_ever=True)
        longest = upper(end - since) if end.is_finite() else math.inf
        period = _period(system)
        started = hold.bound if hold.order else None
        width = 1.0 / max((wave.pace for wave in push.waves), default=1.0)
        search = search_along(system, push, [level], started, hold.order, width)
        bracket = search.first(min(longest, period))
        if bracket is None:
            # Without a root in a period there is none ever.
            return Released(None, for_ever=period <= longest)
    middle = hold.since.mid()
    start = middle if hold.time is None else time_ball(hold.time)
    zero = _zero(_push_of(system, hold, middle), bracket, sign)
    return Released(start + zero, for_ever=False)


def _zero(push: Push, bracket: Bracket, sign: int) -> arb:
    """Return the one zero of the force in a bracket."""
    s = arb(bracket.guess)
    for _ in range(MOST_STEPS):
        (value, slope), _ = push.derivatives(s, 1)
        if value.abs_lower() < 4 * value.rad():
            break
        s = (s - (value / slope).mid()).mid()
    (value, slope), _ = push.derivatives(s, 1)
    bend = push.bound(2, 0.0, 0.0, 0.0)

    def slopes(trial: arb) -> arb:
        around = slope + arb(0, trial * bend)
        if not sign * around > 0:
            raise Undecided("graze", "the force may touch zero where a contact could end")
        return around

    step, _ = interval_newton(value, slopes, 2 * value.abs_upper() / slope.abs_lower())
    if not (s + step > bracket.low and s + step < bracket.high):
        raise Undecided("precision", "a release is at the end of its bracket")
    return s + step


def _holds_for_ever(push: Push, sign: int) -> bool:
    """Return whether the constant part of the force exceeds the sum of all harmonics."""
    return bool(-sign * constant_of(push.rest) > sum(wave.size for wave in push.waves))


def _period(system: BallSystem) -> float:
    """Return more than the period of the forcing, infinity where it has none."""
    force = system.forcing
    if force is None or not force.harmonics or force.frequency is None:
        return math.inf
    return 1.000001 * upper(constant_of(law_of(system).period(1)))
