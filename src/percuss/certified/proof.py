"""What is proven of an orbit, before it is told as a result."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flint import arb

from percuss.certified.chain import Link
from percuss.certified.multipliers import Monodromy
from percuss.certified.numbers import precision

__all__ = ["Proof"]


@dataclass(frozen=True)
class Proof:
    """What is proven of an orbit, at the working precision.

    Attributes
    ----------
    chain, states, before
        The events, instants and velocities after them, and velocities before.
    period
        How long it lasts.
    monodromy
        Its derivative.
    admissible
        Whether it passes through no stop; None where that is open.
    isolated
        Whether it is alone.
    unique_within
        Part of period and speed within which it is proven to be the only one.
    reason
        What is open.
    start
        (x, v, t) of an orbit without events.
    """

    chain: list[Link]
    states: list[tuple[arb, arb]]
    before: list[arb]
    period: arb
    monodromy: Monodromy
    admissible: bool | None
    isolated: bool
    unique_within: float
    reason: str
    start: tuple[arb, arb, arb] | None = None
    sticking: bool = False

    def digits(self) -> float:
        """Return the fewest decimal digits of the events, as parts of the period and the speed."""
        with precision(64):
            fastest = max((abs(v) for _, v in self.states), key=float, default=arb(1))
            errors = [t.rad() / self.period for t, _ in self.states]
            errors += [v.rad() / fastest for _, v in self.states]
            if self.start is not None:
                x, v, _ = self.start
                errors += [x.rad() / abs(x).max(abs(v)), v.rad() / abs(v).max(abs(x))]
            worst = max((float(error.abs_upper()) for error in errors), default=0.0)
        return math.inf if worst == 0.0 else -math.log10(worst)
