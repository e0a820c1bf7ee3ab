"""How far a flight provably meets nothing, from the amplitudes of its parts.

The search of the kernels takes steps of the fastest motion in a region. A mass that is pressed
into a stiff stop trembles fast about a slow motion: where the trembling cannot reach a bound,
only the slow part needs to be looked at. Asked only when a flight has gone on for long.
"""

from __future__ import annotations

import math

import numpy as np

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

__all__ = ["free_until"]

# Slow steps in one call, each about 0.1 ms; and the phase of the quickest harmonic in one.
MOST_STEPS = 2000
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
    if law[region, STIFFNESS] <= 0.0 or law[region, RATE] == 0.0:
        return s
    gain = law[region + 1 : region + 1 + len(phases), (GAIN_RE, GAIN_IM)]
    if (gain == 0.0).all(axis=1).any():
        return s
    omega = law[FIRST_HARMONIC : FIRST_HARMONIC + len(phases), OMEGA]
    swing = law[FIRST_HARMONIC : FIRST_HARMONIC + len(phases), AMPLITUDE] * np.hypot(*gain.T)
    step = STEP_PHASE / float(omega.max()) if len(omega) else longest - s
    error = float((swing * omega**4).sum()) * step**4 / 384.0 if len(omega) else 0.0
    arrival = np.empty_like(phases)
    for _ in range(MOST_STEPS):
        if s >= longest:
            break
        y, v = move(law, region, start, phases, s, arrival)
        here = steady(law, region, start[3], arrival)
        late, fast = free_parts(law, region, y - here[0], v - here[1])
        middle = start[3] / law[region, STIFFNESS]
        size = float(swing.sum()) + abs(late) + fast
        if misses(reach, middle - size, middle + size, abs(middle) + size):
            return math.inf
        set_phases(law, *later(start[0], start[1], s + step), arrival)
        there = steady(law, region, start[3], arrival)
        # The slow root's part goes one way: it stays between its ends.
        end = late * math.exp(law[region, SLOW_ROOT] * step)
        coefficients = (
            here[0],
            here[0] + step * here[1] / 3.0,
            there[0] - step * there[1] / 3.0,
            there[0],
        )
        low = min(coefficients) + min(late, end) - fast - error
        high = max(coefficients) + max(late, end) + fast + error
        if not misses(reach, low, high, abs(middle) + size):
            break
        s += step
    return s


def misses(reach: tuple[float, float], low: float, high: float, size: float) -> bool:
    """Tell whether displacements between low and high stay clear of both bounds.

    ``size`` is that of the terms they are sums of.
    """
    slack = SLACK * (abs(low) + abs(high) + size)
    return low - slack > reach[0] and high + slack < reach[1]


def steady(law: Law, region: int, force: float, phases: Table) -> tuple[float, float]:
    """Return y and v of the steady motion at the instant of ``phases``, for K > 0."""
    y = force / law[region, STIFFNESS]
    v = 0.0
    for j in range(len(phases)):
        harmonic = FIRST_HARMONIC + j
        real = law[region + 1 + j, GAIN_RE]
        imaginary = law[region + 1 + j, GAIN_IM]
        in_phase = law[harmonic, COSINE] * phases[j, 0] + law[harmonic, SINE] * phases[j, 1]
        quadrature = law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
        y += in_phase * real + quadrature * imaginary
        v -= law[harmonic, OMEGA] * (in_phase * imaginary - quadrature * real)
    return y, v


def free_parts(law: Law, region: int, z: float, w: float) -> tuple[float, float]:
    """Return the slow root's part of free motion from (z, w), and a bound on all the rest."""
    if law[region, OVERDAMPED] == 1.0:
        late = (w - law[region, FAST_ROOT] * z) / (2.0 * law[region, RATE])
        return late, abs(z - late)
    return 0.0, math.hypot(z, (w + law[region, DAMPING] * z) / law[region, RATE])
