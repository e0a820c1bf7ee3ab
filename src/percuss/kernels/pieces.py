"""The record in a law: a force that is linear, or constant, between knots.

The record stands in the last of the harmonics' rows. In place of the cosine and the sine of a
phase, its row of the phases holds the force and its slope; with COSINE 1, SINE 0 and OMEGA -1 the
sums of the harmonics then hold for it as well, up to the force's first derivative, and higher ones
vanish inside a piece. A flight ends at the next knot, so that it is under one piece alone.

The knots lie behind the regions, `KNOTS_A_ROW` to a row: instant, what its double misses, force and
slope from there on. Before the first knot the force is a constant; a repeated record begins again
after each of its periods (docs/decisions/019-records.md).
"""

from __future__ import annotations

import math

from percuss.kernels.arithmetic import Pair, two_product, two_sum
from percuss.kernels.compile import cold, kernel
from percuss.kernels.law_columns import (
    FIRST_HARMONIC,
    FIRST_KNOT,
    KNOT_ENTRIES,
    KNOT_FORCE,
    KNOT_SLOPE,
    KNOT_T,
    KNOT_T_LOW,
    KNOTS_A_ROW,
    N_KNOTS,
    OMEGA,
    OUTSIDE_FORCE,
    REPEAT,
    REPEAT_LOW,
    Law,
)


@kernel
def is_record(law: Law, j: int) -> bool:
    """Return whether the j-th of the harmonics' rows is that of a record."""
    return law[FIRST_HARMONIC + j, OMEGA] < 0.0


@kernel
def knot_entry(law: Law, k: int, entry: int) -> float:
    """Return an entry of the k-th knot."""
    return law[int(law[0, FIRST_KNOT]) + k // KNOTS_A_ROW, KNOT_ENTRIES * (k % KNOTS_A_ROW) + entry]


@kernel
def knot_time(law: Law, k: int, turn: float) -> Pair:
    """Return the instant of the k-th knot in a turn of the record, as a normal sum of two."""
    t = knot_entry(law, k, KNOT_T)
    t_low = knot_entry(law, k, KNOT_T_LOW)
    if turn == 0.0:
        return t, t_low
    shift, rest = two_product(turn, law[0, REPEAT])
    high, low = two_sum(shift, t)
    return two_sum(high, low + (rest + turn * law[0, REPEAT_LOW] + t_low))


@kernel
def is_reached(law: Law, k: int, turn: float, t: float, t_low: float) -> bool:
    """Return whether a knot is at, or before, an instant."""
    high, low = knot_time(law, k, turn)
    return (t - high) + (t_low - low) >= 0.0


@kernel
def piece_at(law: Law, t: float, t_low: float) -> tuple[int, float]:
    """Return the last knot at or before an instant and its turn, -1 before the first of all."""
    turn = 0.0
    n = int(law[0, N_KNOTS])
    if law[0, REPEAT] > 0.0:
        turn = float(math.floor((t - knot_entry(law, 0, KNOT_T)) / law[0, REPEAT]))
        # The quotient is rounded: by comparison with the knots themselves it is one turn off.
        if not is_reached(law, 0, turn, t, t_low):
            turn -= 1.0
        elif is_reached(law, 0, turn + 1.0, t, t_low):
            turn += 1.0
    low = -1
    high = n
    while high - low > 1:
        middle = (low + high) // 2
        if is_reached(law, middle, turn, t, t_low):
            low = middle
        else:
            high = middle
    return low, turn


@cold
def record_at(law: Law, t: float, t_low: float) -> Pair:
    """Return the force of the record and its slope at an instant, at a knot those after it."""
    k, turn = piece_at(law, t, t_low)
    if k < 0:
        return law[0, OUTSIDE_FORCE], 0.0
    high, low = knot_time(law, k, turn)
    slope = knot_entry(law, k, KNOT_SLOPE)
    return knot_entry(law, k, KNOT_FORCE) + slope * ((t - high) + (t_low - low)), slope


@kernel
def next_knot(law: Law, t: float, t_low: float) -> Pair:
    """Return the instant of the first knot after an instant; infinite where there is none."""
    k, turn = piece_at(law, t, t_low)
    k += 1
    if k == int(law[0, N_KNOTS]):
        if law[0, REPEAT] == 0.0:
            return math.inf, 0.0
        k = 0
        turn += 1.0
    return knot_time(law, k, turn)


@kernel
def begin_of_piece(law: Law, t: float, t_low: float) -> tuple[int, float, float, float]:
    """Return the last knot strictly before an instant, its turn, and its instant; -1 for none.

    Before the first knot of all the instant is that far back.
    """
    k, turn = piece_at(law, t, t_low)
    if k >= 0:
        high, low = knot_time(law, k, turn)
        if (t - high) + (t_low - low) > 0.0:
            return k, turn, high, low
        k -= 1
    if k < 0 and law[0, REPEAT] > 0.0:
        k = int(law[0, N_KNOTS]) - 1
        turn -= 1.0
    if k < 0:
        return k, turn, -math.inf, 0.0
    high, low = knot_time(law, k, turn)
    return k, turn, high, low


@kernel
def record_before(law: Law, t: float, t_low: float) -> Pair:
    """Return the force of the record and its slope at an instant, at a knot those before it."""
    k, _, high, low = begin_of_piece(law, t, t_low)
    if k < 0:
        return law[0, OUTSIDE_FORCE], 0.0
    slope = knot_entry(law, k, KNOT_SLOPE)
    return knot_entry(law, k, KNOT_FORCE) + slope * ((t - high) + (t_low - low)), slope


@kernel
def time_to_knot(law: Law, t: float, t_low: float) -> float:
    """Return the time from an instant to the next knot; infinite without one."""
    return time_to_next_knot(law, t, t_low) if law[0, N_KNOTS] > 0.0 else math.inf


@cold
def time_to_next_knot(law: Law, t: float, t_low: float) -> float:
    """Return the time from an instant to the next knot of a record; infinite behind the last."""
    high, low = next_knot(law, t, t_low)
    if high == math.inf:
        return math.inf
    return (high - t) + (low - t_low)
