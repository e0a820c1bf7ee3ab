"""Statements about motions that come back exactly after so many impacts.

The closed form is that of `reflections`.
"""

from __future__ import annotations

from flint import arb

from percuss.certified.balls import Undecided
from percuss.certified.families import Rounds, returns_reversed
from percuss.certified.numbers import ball, precision, time_ball
from percuss.certified.statements import BITS, Verdict
from percuss.certified.system import BallSystem, system_of
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase, as_fraction
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator

__all__ = ["repeats_after"]

MOST_IMPACTS = 100_000


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
    if isinstance(n_impacts, bool) or not 1 <= n_impacts <= MOST_IMPACTS:
        reason = f"not a whole number from 1 to {MOST_IMPACTS}"
        raise ParameterError("n_impacts", n_impacts, reason)
    system = system_of(osc, force)
    try:
        with precision(BITS):
            if not _has_closed_form(system):
                reason = "the closed form of flights that return reversed does not hold"
                return Verdict(None, n_impacts, reason)
            return _verdict(Rounds(system, time_ball(t0), ball(as_fraction(v0))), n_impacts)
    except Undecided as question:
        return Verdict(None, n_impacts, question.reason)


def _has_closed_form(system: BallSystem) -> bool:
    return (
        len(system.bounds) == 1
        and system.bounds[0].wall is not None
        and system.numbers["oscillator.stops.0.restitution"] == 1
        and returns_reversed(system, 0, 0)
    )


def _verdict(rounds: Rounds, n: int) -> Verdict:
    """Fly, and see whether the motion is where it began; by where it is if no zero says so."""
    began = rounds.v
    for _ in range(n):
        rounds.fly()
    if rounds.is_closed:
        reason = f"the last impact is at the start's zero, {rounds.turns} half periods later"
        return Verdict(True, n, f"{reason}, exactly")
    system = rounds.system
    # By what acts: a period that was given may be a multiple of the least.
    for omega in {system.frequency(tone) for tone in system.tones if system.strength(tone)}:
        turns = (rounds.t - rounds.times[0]) * ball(omega) / (2 * arb.pi())
        if not turns.contains_integer():
            return Verdict(False, n, "the last impact is at another phase of the force")
    if not rounds.v.overlaps(began):
        return Verdict(False, n, "the velocity after the last impact is another one")
    raise Undecided("precision", "the motion comes back within the radius; no closed form says so")
