"""What moves a mass at rest: the first derivative of the force that is not zero, and its sign.

Whether one is zero is told in rationals, where sines and cosines are rational: that the force
on a mass at rest on a stop is zero at its start is the rule with harmonics, no accident.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial

from flint import arb

from percuss.certified.flight import Push
from percuss.certified.law import Law, constant_of
from percuss.certified.numbers import ball, rational_cosine
from percuss.certified.undecided import Undecided
from percuss.model.exact import Phase, angle

__all__ = ["first_push", "first_push_at", "rests_for_ever"]

# The force's derivatives that are looked at before it counts as undecided.
LAST_ORDER = 12


def rests_for_ever(law: Law, region: int, x: Fraction) -> bool:
    """Tell whether no force ever acts on a mass at rest at a place; not with a moved number."""
    if law.system.moved is not None:
        return False
    amplitudes = (law.system.strength(tone) for tone in law.system.tones)
    return _still(law, region, x) == 0 and not any(amplitudes)


def first_push_at(
    law: Law, region: int, x: Fraction, t: arb, time: Phase | None = None
) -> tuple[int, int]:
    """Return the order and the sign of the first derivative of x that moves a mass at rest.

    Returns (0, 0) where the force is zero for ever.

    Parameters
    ----------
    law, region
        The equation: number of the region.
    x
        Where the mass is.
    t
        The instant.
    time
        The same exactly, where it is known so.

    Raises
    ------
    Undecided
        If a derivative may be zero or not.
    """
    if rests_for_ever(law, region, x):
        return 0, 0
    if time is None:
        return first_push(law, region, ball(x), law.turns(t))
    turns = law.turns_at(time)
    return first_push(law, region, ball(x), turns, partial(_derivative, law, region, x, time))


def first_push(
    law: Law,
    region: int,
    x: arb,
    turns: list[tuple[arb, arb]],
    exact: Callable[[int], Fraction | None] = lambda _: None,
) -> tuple[int, int]:
    """Return the same from cosines and sines of omega t, and derivatives in rationals if known.

    Raises
    ------
    Undecided
        If a derivative may be zero or not.
    """
    push = Push(law, region, turns, x, 0)
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


def _still(law: Law, region: int, x: Fraction) -> Fraction:
    """Return the force without harmonics on a mass at rest."""
    here = law.system.regions[region]
    return law.system.constant(here) - law.system.stiffness(here) * x


def _derivative(law: Law, region: int, x: Fraction, time: Phase, order: int) -> Fraction | None:
    """Return a derivative of the force at an exact time, None where it is not surely rational."""
    if law.system.moved is not None:
        return None
    times, plus = angle(time)
    total = _still(law, region, x) if order == 0 else Fraction(0)
    for tone in law.system.tones:
        omega = law.system.frequency(tone)
        turn = tone.phase[0] + omega * times + Fraction(order, 2)
        cosine = rational_cosine(turn, tone.phase[1] + omega * plus)
        if cosine is None:
            return None
        total += law.system.strength(tone) * omega**order * cosine
    return total
