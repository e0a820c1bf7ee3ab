"""How far a flight provably meets nothing, from the amplitudes of its parts.

The search of the kernels takes steps of the fastest motion in a region. Where a fast part is
small, as the trembling of a mass that is pressed into a stiff stop, or the answer to a force of
very high frequency, and where it cannot reach a bound, only the slow parts need to be looked at.
A mass without spring that drifts away is seen to do so. Asked only when a flight has gone on for
long.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.kernels.doubled import later
from percuss.kernels.flight import Start, move, set_phases
from percuss.kernels.law import (
    AMPLITUDE,
    COSINE,
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    LOWER,
    OMEGA,
    OVERDAMPED,
    RATE,
    SINE,
    SLOW_ROOT,
    STIFFNESS,
    UPPER,
    Law,
    Table,
)
from percuss.numerics import exp, hypot

__all__ = ["free_until"]

Floats: TypeAlias = NDArray[np.float64]

# Slow steps in one call, each about 0.2 ms; and the phase of the quickest slow part in one.
MOST_STEPS = 1000
STEP_PHASE = 1.0
# What is compared here is rounded like any flight; a clearance has to be larger than this part
# of the sizes involved.
SLACK = 1e-9


def free_until(
    law: Law,
    region: int,
    x: float,
    start: Start,
    phases: Table,
    s: float,
    longest: float,
) -> float:
    """Return a time since the start, at least s, up to which a flight provably meets no bound.

    Infinite if it never will.
    """
    reach = (law[region, LOWER] - x, law[region, UPPER] - x)
    if reach == (-math.inf, math.inf):
        return math.inf
    gain = law[region + 1 : region + 1 + len(phases), (GAIN_RE, GAIN_IM)]
    if law[region, STIFFNESS] < 0.0 or (gain == 0.0).all(axis=1).any():
        return s
    if law[region, STIFFNESS] == 0.0:
        return math.inf if drifts_away(law, region, start, phases, s, reach) else s
    if law[region, RATE] == 0.0:
        return s
    for _ in range(MOST_STEPS):
        if s >= longest:
            break
        step = clear_step(law, region, start, phases, s, reach, longest - s)
        if step == 0.0:
            break
        s += step
    return s


def clear_step(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    s: float,
    reach: tuple[float, float],
    longest: float,
) -> float:
    """Return a time from s on that is clear of both bounds, for K > 0; 0 if none is seen.

    Of the parts of the motion, the fast ones count with their amplitudes; the slow ones stay
    within the Bernstein coefficients of a cubic and its error. What counts as slow is tried from
    the coarsest view on.
    """
    here, late = parts(law, region, start, phases, s)
    rates, sizes = rates_and_sizes(law, region, here)
    middle = start[3] / law[region, STIFFNESS]
    size = abs(middle) + float(sizes.sum()) + abs(late)
    slow_root = law[region, SLOW_ROOT]
    views = [(0.0, math.inf), (0.0, longest), (0.0, STEP_PHASE / -slow_root if slow_root else 0.0)]
    for rate, step in (*views, *((rate, STEP_PHASE / rate) for rate in np.sort(rates))):
        slow = rates <= rate
        low, high = slow_range(law, region, start, phases, s, step, here, slow)
        error = float(sizes[~slow].sum())
        if slow.any():
            square = rates[slow] * rates[slow] * (step * step)
            error += float((sizes[slow] * square * square).sum()) / 384.0
        # The slow root's part goes one way: it stays between its ends.
        left = late * exp(slow_root * step) if late else 0.0
        low += middle + min(late, left) - error
        high += middle + max(late, left) + error
        if misses(reach, low, high, size):
            return float(step)
    return 0.0


def slow_range(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    s: float,
    step: float,
    here: Floats,
    slow: NDArray[np.bool_],
) -> tuple[float, float]:
    """Return the least and greatest Bernstein coefficient of the slow parts over a step."""
    if not slow.any():
        return 0.0, 0.0
    there, _ = parts(law, region, start, phases, s + step)
    begin, end = here[slow].sum(axis=0), there[slow].sum(axis=0)
    coefficients = (
        begin[0],
        begin[0] + step * begin[1] / 3.0,
        end[0] - step * end[1] / 3.0,
        end[0],
    )
    return float(min(coefficients)), float(max(coefficients))


def misses(reach: tuple[float, float], low: float, high: float, size: float) -> bool:
    """Tell whether displacements between low and high stay clear of both bounds.

    ``size`` is that of the terms they are sums of.
    """
    slack = SLACK * (abs(low) + abs(high) + size)
    return low - slack > reach[0] and high + slack < reach[1]


def parts(law: Law, region: int, start: Start, phases: Table, s: float) -> tuple[Floats, float]:
    """Return (y, v) of each oscillating part at s, rows, and what the slow root leaves.

    One row a harmonic, in its steady motion, and last the free motion; the slow of two real
    roots is not in it.
    """
    at = np.empty_like(phases)
    y, v = move(law, region, start, phases, s, at)
    set_phases(law, *later(start[0], start[1], s), at)
    found = np.empty((len(phases) + 1, 2))
    found[:-1] = steady(law, region, at)
    y -= float(found[:-1, 0].sum()) + start[3] / law[region, STIFFNESS]
    v -= float(found[:-1, 1].sum())
    late = 0.0
    if law[region, OVERDAMPED] == 1.0:
        late = (v - law[region, FAST_ROOT] * y) / (2.0 * law[region, RATE])
        y -= late
        v = law[region, FAST_ROOT] * y
    found[-1] = y, v
    return found, late


def rates_and_sizes(law: Law, region: int, here: Floats) -> tuple[Floats, Floats]:
    """Return a frequency and a bound for ever of each of the `parts`."""
    n = len(here) - 1
    gain = hypot(*law[region + 1 : region + 1 + n, (GAIN_RE, GAIN_IM)].T)
    rows = law[FIRST_HARMONIC : FIRST_HARMONIC + n]
    y, v = here[-1]
    free, rate = abs(y), -law[region, FAST_ROOT]
    if law[region, OVERDAMPED] != 1.0:
        free = math.hypot(y, (v + law[region, DAMPING] * y) / law[region, RATE])
        rate = math.sqrt(law[region, STIFFNESS])
    return np.append(rows[:, OMEGA], rate), np.append(rows[:, AMPLITUDE] * gain, free)


def steady(law: Law, region: int, phases: Table) -> Floats:
    """Return (y, v) of the steady motion of each harmonic at the instant of ``phases``."""
    n = len(phases)
    rows = law[FIRST_HARMONIC : FIRST_HARMONIC + n]
    real, imaginary = law[region + 1 : region + 1 + n, (GAIN_RE, GAIN_IM)].T
    in_phase = rows[:, COSINE] * phases[:, 0] + rows[:, SINE] * phases[:, 1]
    quadrature = rows[:, SINE] * phases[:, 0] - rows[:, COSINE] * phases[:, 1]
    # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
    y = in_phase * real + quadrature * imaginary
    v = -rows[:, OMEGA] * (in_phase * imaginary - quadrature * real)
    return np.column_stack([y, v])


def drifts_away(
    law: Law, region: int, start: Start, phases: Table, s: float, reach: tuple[float, float]
) -> bool:
    """Tell whether a mass without spring (K = 0) meets no bound after s, and never will.

    Its motion is what the harmonics make it swing and a drift, which goes one way once it does
    not go against the constant force.
    """
    at = np.empty_like(phases)
    y, _ = move(law, region, start, phases, s, at)
    set_phases(law, *later(start[0], start[1], s), at)
    y -= float(steady(law, region, at)[:, 0].sum())
    gain = hypot(*law[region + 1 : region + 1 + len(phases), (GAIN_RE, GAIN_IM)].T)
    swing = law[FIRST_HARMONIC : FIRST_HARMONIC + len(phases), (AMPLITUDE, OMEGA)].T
    size = float((swing[0] * gain).sum())
    speeds = float((swing[0] * swing[1] * gain).sum())
    # From the start of the flight, where the velocity is not yet rounded by the way.
    drift = start[2] - float(steady(law, region, phases)[:, 1].sum())
    doubt = SLACK * (abs(start[2]) + speeds)
    damping, force = law[region, DAMPING], start[3]
    low = high = y
    if damping > 0.0:
        # The drift decays to that at which the damping holds the constant force.
        late = y + (drift - 0.5 * force / damping) * exp(-2.0 * damping * s) / (2.0 * damping)
        low, high = min(y, late), max(y, late)
        way = force
    elif force == 0.0:
        if 0.0 < abs(drift) <= doubt:
            return False
        way = drift
    else:
        now = drift + force * s
        if abs(now) <= doubt or now * force < 0.0:
            return False
        way = force
    if (way < 0.0 and reach[0] > -math.inf) or (way > 0.0 and reach[1] < math.inf):
        return False
    return misses(reach, low - size, high + size, abs(y) + size)
