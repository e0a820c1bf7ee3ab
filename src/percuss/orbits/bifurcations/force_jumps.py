"""The instants at which a repeated record jumps, as borders that the events of an orbit may meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.kernels.law_columns import (
    FIRST_KNOT,
    KNOT_ENTRIES,
    KNOT_FORCE,
    KNOT_SLOPE,
    KNOT_T,
    KNOTS_A_ROW,
    N_KNOTS,
    REPEAT,
    Law,
)
from percuss.kernels.pieces import knot_time

# Jumps below this part of the largest force are rounding of a continuous record.
LEAST = 1e-12


@dataclass(frozen=True, slots=True)
class Crossing:
    """An event that passes a jump of the force.

    Attributes
    ----------
    event
        Its row in the itinerary.
    jump
        Number of the jump, counted on over the turns of the record.
    side
        1.0 if the event comes to lie after the jump, -1.0 if before it.
    """

    event: int
    jump: int
    side: float


@dataclass(frozen=True, slots=True)
class ForceJumps:
    """The knots at which the force of a repeated record jumps.

    Attributes
    ----------
    knots
        Their numbers in the record, (n,), in order; none where the force is continuous.
    """

    knots: tuple[int, ...]

    @classmethod
    def of(cls, law: Law) -> Self:
        """Return the jumps of a law.

        Examples
        --------
        >>> import percuss as pc
        >>> from percuss.model.system import System
        >>> osc = pc.impact_oscillator(0.8)
        >>> ForceJumps.of(System(osc, pc.square_wave(2)).law).knots
        (0, 1)
        >>> ForceJumps.of(System(osc, pc.triangle_wave(2)).law).knots
        ()
        """
        if not law[0, REPEAT] > 0.0:
            return cls(())
        knots = _knots(law)
        t, after = knots[:, KNOT_T], knots[:, KNOT_FORCE]
        lengths = np.diff(np.append(t, t[0] + law[0, REPEAT]))
        before = np.roll(after + knots[:, KNOT_SLOPE] * lengths, 1)
        least = LEAST * float(np.abs([after, before]).max(initial=0.0))
        return cls(tuple(np.flatnonzero(np.abs(after - before) > least).tolist()))

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self.knots)

    def instant(self, law: Law, jump: int) -> float:
        """Return the instant of a jump by its number."""
        turn, k = divmod(jump, len(self.knots))
        high, low = knot_time(law, self.knots[k], float(turn))
        return float(high + low)

    def passed(self, law: Law, t: Floats) -> Integers:
        """Return how many jumps lie at or before some instants, counted from the first turn on."""
        first = _knots(law)[list(self.knots), KNOT_T]
        turns = np.floor((t - first[0]) / law[0, REPEAT])
        inside = t - turns * law[0, REPEAT]
        before = np.searchsorted(first, inside, side="right")
        return np.asarray(turns.astype(np.int64) * len(first) + before)

    def nearest(self, law: Law, t: float) -> float:
        """Return how far an instant is from the nearest jump."""
        count = int(self.passed(law, np.array([t]))[0])
        return min(abs(t - self.instant(law, jump)) for jump in (count - 1, count))


def crossings(before: Integers, after: Integers) -> list[Crossing]:
    """Return which events pass a jump, from the numbers of jumps that lie before them."""
    return [
        Crossing(i, int(a if b > a else a - 1), 1.0 if b > a else -1.0)
        for i, (a, b) in enumerate(zip(before.tolist(), after.tolist(), strict=True))
        if a != b
    ]


def _knots(law: Law) -> Floats:
    """Return the knots of a law's record, one row each."""
    n, first = int(law[0, N_KNOTS]), int(law[0, FIRST_KNOT])
    rows = law[first : first - (-n // KNOTS_A_ROW), : KNOT_ENTRIES * KNOTS_A_ROW]
    return np.asarray(rows.reshape(-1, KNOT_ENTRIES)[:n])
