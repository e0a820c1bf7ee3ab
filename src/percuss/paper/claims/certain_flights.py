"""Fast flights under sin(n t), n odd: all of them last pi, from every phase of the force."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from flint import arb

from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.families import ReflectedMotion, returns_reversed
from percuss.certified.numbers import ball, precision
from percuss.certified.system import system_of
from percuss.model.exact import as_fraction
from percuss.model.forcing import sine
from percuss.paper.claims.comparisons import WALL

__all__ = ["all_flights_last_pi"]

BITS = 96
# Parts that a period of the force is cut into, at most.
MOST_PARTS = 4096


@cache
def all_flights_last_pi(n: int, v: str) -> bool:
    """Return whether it is proven that no flight under sin(n t) from the wall with v ends before pi.

    Then none with a higher velocity does, since that adds a positive multiple of sin s; all of
    them return their velocity. As the flights of the elastic wall can be run backwards, those that
    end with v or more have begun so: a motion below v stays below it.

    Parameters
    ----------
    n
        An odd number, >= 3.
    v
        The velocity.

    Examples
    --------
    >>> all_flights_last_pi(3, "0.4")
    False
    """
    system = system_of(WALL, sine(n))
    # In units of pi; a little more than a period of the force, 2/n.
    pending, parts = [(Fraction(0), Fraction(2, n) + Fraction(1, 100))], 0
    with precision(BITS):
        if not returns_reversed(system, 0, 0):
            return False
        while pending:
            low, high = pending.pop()
            if _last_pi(system, low, high, v):
                continue
            parts += 1
            if parts > MOST_PARTS:
                return False
            middle = (low + high) / 2
            pending += [(low, middle), (middle, high)]
    return True


def _last_pi(system: object, low: Fraction, high: Fraction, v: str) -> bool:
    """Return whether all flights that begin between two multiples of pi are proven to last pi."""
    t = arb.pi() * ball(low).union(ball(high))
    motion = ReflectedMotion(system, t, ball(as_fraction(v)))  # type: ignore[arg-type]
    try:
        motion.fly()
    except Undecided:
        return False
    return motion.zero == 0 and motion.half_periods == 1
