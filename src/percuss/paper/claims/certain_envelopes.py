"""Envelopes in ball arithmetic: the highest points of proven flights, and a factor of sqrt(t)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TypeAlias

import numpy as np
from flint import arb

from percuss.certified import Ball, CertifiedRun
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run

# Times and values.
BallColumn: TypeAlias = "tuple[list[arb], list[arb]]"
# Steps that a flight is looked at with, and how often, each time more closely: so many give a
# factor of sqrt(t) to 1e-3, a tenth of what fits by eye leave open.
STEPS, ROUNDS = 24, 2


@cache
def proven_peaks(run: Trajectory) -> BallColumn | None:
    """Return balls of instant and height of the highest point of each flight between two events.

    Between two times of a grid x is at most that of one of them plus abs(v) h/2 + A h^2/8 with
    A >= abs(x''), so the highest point of a flight lies in those steps that can hold it.

    Parameters
    ----------
    run
        A run above one stop at 0, with k = 1 there, under harmonics whose amplitudes add up to 1.
        Of a soft stop the contacts, below it, are left out.

    Returns
    -------
    tuple of lists or None
        None where the run is not proven up to its end.
    """
    proven = certain_run(run)
    if proven is None:
        return None
    events = proven.impacts.t if len(proven.impacts) else proven.crossings.t
    ends = events.mid()
    # What the radii leave open at the ends of a flight.
    open_part = 4.0 * float(events.radius().max() + np.spacing(ends).max())
    above = proven(0.5 * (ends[:-1] + ends[1:]))[0].arbs
    peaks: BallColumn = [], []
    for low, high, x in zip(ends[:-1], ends[1:], above, strict=True):
        if x > 0:
            instant, height = _highest(proven, float(low), float(high), open_part)
            peaks[0].append(instant)
            peaks[1].append(height)
    return peaks


def _highest(proven: CertifiedRun, low: float, high: float, open_part: float) -> tuple[arb, arb]:
    """Return balls of instant and height of the highest point between two events."""
    begin, end = low + open_part, high - open_part
    best = highest = arb(0)
    # What is not in the steps that remain is lower: those are looked at again, more closely.
    for _ in range(ROUNDS):
        grid = np.linspace(begin, end, STEPS + 1)
        x, v = (column.arbs for column in proven(grid))
        step = arb(float(np.diff(grid).max()))
        # The motion stays below twice its greatest value on the grid, which the bounds then show.
        greatest = max(x, key=float).abs_upper()
        reach = step * step * (1 + 2 * greatest)
        tops = [place + abs(speed) * step + reach for place, speed in zip(x, v, strict=True)]
        if not all(top < 2 * greatest for top in tops):
            raise ArithmeticError("the grid is too coarse for this flight")
        for place in x:
            best = best.max(place)
        may = [i for i, top in enumerate(tops) if not top < best]
        highest = best
        for i in may:
            highest = highest.max(tops[i])
        begin, end = float(grid[max(0, may[0] - 1)]), float(grid[min(STEPS, may[-1] + 1)])
    return arb(begin).union(arb(end)), best.union(highest)


@cache
def proven_speeds(run: Trajectory) -> BallColumn | None:
    """Return balls of when a run hits its stop, and how fast it leaves it."""
    proven = certain_run(run)
    if proven is None:
        return None
    if len(proven.impacts):
        return list(proven.impacts.t.arbs), list(proven.impacts.v_after.arbs)
    is_entry = proven.crossings.direction == "in"
    entries = [t for t, ok in zip(proven.crossings.t.arbs, is_entry, strict=True) if ok]
    exits = [v for v, ok in zip(proven.crossings.v.arbs, is_entry, strict=True) if not ok]
    n = min(len(entries), len(exits))
    return entries[:n], exits[:n]


def factor_of_root(times: Sequence[arb], heights: Sequence[arb]) -> Ball:
    """Return a ball of the least squares factor of sqrt(t) through the higher of each two values.

    Where the balls do not tell which is higher, either may be.

    Examples
    --------
    >>> from flint import arb
    >>> t = [arb(k) for k in (1, 2, 4, 9)]
    >>> factor_of_root(t, [arb(0), 3 * arb(2).sqrt(), arb(1), arb(9)]).contains(3)
    True
    """
    above, below = arb(0), arb(0)
    for k in range(0, len(times) - len(times) % 2, 2):
        (t, other), (x, y) = times[k : k + 2], heights[k : k + 2]
        if y > x:
            t, x = other, y
        elif not x > y:
            t, x = t.union(other), x.max(y)
        above, below = above + t.sqrt() * x, below + t
    return Ball(above / below)
