"""A mass at a wall: the end of a chatter, contact, release, and the force that moves it from rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from flint import arb, ctx

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import BallLaw, coarse_bits, law_of
from percuss.certified.event_location import interval_newton
from percuss.certified.first_root import Bracket, Level
from percuss.certified.flight import Push
from percuss.certified.numbers import between, constant_of, largest_abs, precision, span
from percuss.certified.pieces import Moment
from percuss.certified.step import beyond, search_along
from percuss.certified.system import BallSystem, Tone
from percuss.model.exact import Phase, angle, as_fraction, rational_cosine

# Derivatives of the force that are computed before it counts as undecided.
LAST_ORDER = 12
MOST_STEPS = 60


def is_still(law: BallLaw, region: int, x: Fraction, piece: int) -> bool:
    """Return whether no force acts on a mass at rest, as long as a piece of the record lasts.

    False where a number is a range.
    """
    if not law.system.is_exact:
        return False
    amplitudes = (law.system.strength(tone) for tone in law.system.tones)
    if any(amplitudes):
        return False
    force = _force_at_rest(law, region, x)
    if law.record is None:
        return force == 0
    first, last = law.record.forces(piece)
    return first == last and force + as_fraction(law.record.record.amplitude) * first == 0


def first_push_at(
    law: BallLaw, region: int, bound: int, moment: Moment, piece: int = 0
) -> tuple[int, int]:
    """Return the order and the sign of the first derivative of x that moves a mass at rest.

    Returns (0, 0) where the force is zero for ever, or as long as the piece of a record lasts.
    """
    x, time = law.system.bounds[bound].at, moment.time
    if is_still(law, region, x, piece):
        return 0, 0
    phasors = law.phasors(moment.t) if time is None else law.phasors_at(time)
    push = Push(law, region, phasors, law.places[bound], 0, law.ramp(piece, moment))
    if time is None:
        return first_push(push)
    return first_push(push, partial(_derivative, law, region, x, time, piece))


def first_push(
    push: Push, exact: Callable[[int], Fraction | None] = lambda _: None
) -> tuple[int, int]:
    """Return order and sign as `first_push_at`, with the derivatives known as rationals."""
    waves = (constant_of(part) for _, at, slope in push.drive for part in (at, slope))
    still = constant_of(push.rest).is_zero() and push.slope is None
    if still and all(part.is_zero() for part in waves):
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


def _derivative(
    law: BallLaw, region: int, x: Fraction, time: Phase, piece: int, order: int
) -> Fraction | None:
    """Return a derivative of the force at an exact time, None where it is not surely rational."""
    if not law.system.is_exact:
        return None
    terms = rational_terms(law.system, law.system.tones, time, order)
    if terms is None:
        return None
    constant = _force_at_rest(law, region, x) if order == 0 else Fraction(0)
    if law.record is not None:
        ramp = law.record.rational(piece, time, order)
        if ramp is None:
            return None
        constant += ramp
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
    """A contact under one piece of the record, from an instant on.

    Attributes
    ----------
    region, bound
        Where.
    moment
        Since when.
    order
        Order of the force's first derivative that is not zero there.
    piece
        Number of the record's piece; 0 without a record.
    still
        Whether no force acts at all.
    """

    region: int
    bound: int
    moment: Moment
    order: int = 0
    piece: int = 0
    still: bool = False


class Hops(NamedTuple):
    """The hops of a chatter after the last listed one, or an event at a knot in either order.

    Balls of their end and of all states.
    """

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
    piece: int = 0,
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
        A ball that holds that of all slower impacts, below 1.
    finest
        Greatest half-width of the instant.
    piece
        Number of the record's piece, in which the chatter has to end.
    """
    law = law_of(system)
    linear = law.regions[region]
    t, speed = box
    x = law.places[bound]
    ramp = law.ramp(piece, Moment(t))
    push = Push(law, region, law.phasors(t), x, 0, ramp)
    force = -sign * sum((at for _, at, _ in push.drive), push.rest)
    if not (force > 0 and restitution < 1):
        return None
    longest = 8 * speed.abs_upper() / (force.abs_lower() * (1 - restitution))
    knot = law.next_knot(piece)
    if knot is not None:
        longest = longest.min(knot.t - t)
    # Up to twice the speed and twice the height are allowed for; neither is reached.
    fast, high = 2 * speed.abs_upper(), speed.abs_upper() ** 2 / force.abs_lower() * 2
    change = sum((wave.size * wave.pace for wave in push.waves), 0.0) * 1.00001
    steep = arb(0) if ramp is None else ramp.upper_slope()
    doubt = (
        longest * (change + steep) + 2 * abs(linear.damping) * fast + abs(linear.stiffness) * high
    )
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


def release(system: BallSystem, hold: Hold, end: arb, knot: Moment | None = None) -> Released:
    """Return the end of a contact: the first change of sign of the force towards the wall.

    Up to an instant, which may be that of a knot.
    """
    if hold.still:
        return Released(None, for_ever=law_of(system).next_knot(hold.piece) is None)
    question = None
    for coarse in sorted({coarse_bits(system), ctx.prec}):
        try:
            return _release(system, hold, end, coarse, knot)
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
    law, moment = law_of(system), hold.moment._replace(t=since)
    phasors = law.phasors(since) if moment.time is None else law.phasors_at(moment.time)
    ramp = law.ramp(hold.piece, moment)
    return Push(law, hold.region, phasors, law.places[hold.bound], hold.order, ramp)


def _release(
    system: BallSystem, hold: Hold, end: arb, coarse: int, knot: Moment | None
) -> Released:
    sign = 1 if system.regions[hold.region].lower == hold.bound else -1
    with precision(coarse):
        since, law = hold.moment.t, law_of(system)
        push = _push_of(system, hold, since)
        if hold.moment.time is None and -sign * push.derivatives(arb(0), 1)[0][0] > 0:
            # It holds at all instants at which the contact may begin: one of them stands for all.
            since = since.mid()
            push = _push_of(system, hold, since)
        level = Level(hold.bound, -sign, arb(0))
        moving = any(system.strength(tone) for tone in system.tones) or push.slope is not None
        if system.is_exact and not moving:
            return Released(None, for_ever=law.next_knot(hold.piece) is None)
        if _holds_for_ever(push, sign, law, hold):
            return Released(None, for_ever=True)
        longest = largest_abs(end - since) if end.is_finite() else math.inf
        period = _period(system)
        started = hold.bound if hold.order else None
        width = 1.0 / max((wave.pace for wave in push.waves), default=1.0)
        search = search_along(system, push, [level], started, hold.order, width)
        bracket = beyond(search.first, min(longest, period), knot=knot is not None)
        if bracket is None:
            # Without a root in a period there is none ever.
            return Released(None, for_ever=period <= longest and knot is None)
    # One instant stands for all, unless it is exact.
    start = hold.moment.t if hold.moment.time is not None else hold.moment.t.mid()
    t = start + _zero(_push_of(system, hold, start), bracket, sign)
    if knot is None or t < knot.t or t > knot.t:
        return Released(None if knot is not None and t > knot.t else t, for_ever=False)
    s = knot.t - start
    if s > bracket.low and s < bracket.high and knot.time is not None:
        region, x = hold.region, system.bounds[hold.bound].at
        if _derivative(law_of(system), region, x, knot.time, hold.piece, 0) == 0:
            # The one root in the bracket is the knot: what follows it decides.
            return Released(None, for_ever=False)
    reason = f"whether a contact ends before or after the knot at t = {float(knot.t):.12g} is open"
    raise Undecided("precision", reason)


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


def _holds_for_ever(push: Push, sign: int, law: BallLaw, hold: Hold) -> bool:
    """Return whether the constant part of the force exceeds the sum of all others."""
    constant = constant_of(push.rest)
    if law.record is not None:
        region = law.regions[hold.region]
        constant = constant_of(region.constant - region.stiffness * law.places[hold.bound])
        constant = constant + law.record.extremes
    return bool(-sign * constant > sum(wave.size for wave in push.waves))


def _period(system: BallSystem) -> float:
    """Return more than the period of the forcing, infinity where it has none."""
    force = system.forcing
    if system.record is not None or force is None or not force.harmonics or force.frequency is None:
        return math.inf
    return 1.000001 * largest_abs(constant_of(law_of(system).period(1)))
