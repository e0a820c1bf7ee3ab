"""What bounds the fourth derivatives of guards over a step, and how long steps may be."""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.compile import kernel
from percuss.kernels.structure.basis import (
    DRAG,
    FORCE_COS,
    FORCE_SIN,
    GROWTH,
    HAS_RATES,
    N_LEVELS,
    OF_NORM,
    OF_U,
    OF_W,
    QUICKEST,
    RATE,
    RATE_COS,
    RATE_SIN,
    ROOT,
    SPRING,
    STEP_LENGTH,
    SURGE,
    SURGES,
    TWIST,
)

# The shortest step of the search, as a phase of the quickest rate, and how often it is doubled at
# most: a mode that a quick one leaves behind sets the longest.
SHORTEST_PHASE = 0.25
MOST_DOUBLINGS = 14
# The longest step is this phase of the slowest rate.
LONGEST_PHASE = 2.0
# Where the motion grows the bounds over a step hold a factor exp(phase).
GROWING_PHASE = 0.5
# Without any rate the motion is a cubic, and steps may have any length [time].
ANY_STEP = 2.0**-8


@kernel
def pace_of(spring: float, drag: float) -> float:
    """Return a bound of the rate at which a mode grows, and of its turning."""
    return 0.5 * abs(drag) + math.sqrt(0.25 * drag * drag + abs(spring))


@kernel
def fill_mode_bounds(
    modes: Floats, drive: Floats, record_drive: Floats, omegas: Floats, of_set: Floats
) -> None:
    """Fill the columns ROOT and SURGE of modes (n, ...), and the columns of their set.

    With K >= 0 the norm sqrt(K) |u| + |w| is that of the energy, which no free motion raises, with
    negative damping d by exp(|d| s) at most; with K < 0 it is p |u| + |w|, which grows by exp(p s),
    p = |d| / 2 + sqrt(d^2 / 4 + |K|) (docs/theory/structures.md).
    """
    growth = 0.0
    quickest = 0.0
    slowest = math.inf
    has_rates = 0.0
    for k in range(omegas.shape[0]):
        quickest = max(quickest, omegas[k])
        if omegas[k] > 0.0:
            slowest = min(slowest, omegas[k])
    for j in range(modes.shape[0]):
        spring = modes[j, SPRING]
        drag = modes[j, DRAG]
        pace = pace_of(spring, drag)
        root = math.sqrt(abs(spring))
        modes[j, ROOT] = root if spring >= 0.0 else pace
        growth = max(growth, pace if spring < 0.0 else max(0.0, -drag))
        for rate in (root, abs(drag)):
            quickest = max(quickest, rate)
            if rate > 0.0:
                slowest = min(slowest, rate)
        surge = 0.0
        has_rates = max(has_rates, abs(modes[j, RATE]))
        for k in range(omegas.shape[0]):
            force = length(drive[j, k, FORCE_COS], drive[j, k, FORCE_SIN])
            into_rate = length(drive[j, k, RATE_COS], drive[j, k, RATE_SIN])
            surge += omegas[k] * omegas[k] * (force + modes[j, ROOT] * into_rate)
            has_rates = max(has_rates, into_rate)
        for k in range(record_drive.shape[1]):
            has_rates = max(has_rates, abs(record_drive[j, k, 1]))
        modes[j, SURGE] = surge
    of_set[QUICKEST] = quickest
    of_set[GROWTH] = growth
    of_set[HAS_RATES] = 1.0 if has_rates > 0.0 else 0.0
    of_set[STEP_LENGTH] = ANY_STEP
    of_set[N_LEVELS] = MOST_DOUBLINGS + 1
    if quickest > 0.0:
        of_set[STEP_LENGTH] = SHORTEST_PHASE / quickest
        longest = LONGEST_PHASE / slowest
        if growth > 0.0:
            longest = min(longest, GROWING_PHASE / growth)
        levels = 1
        width = 2.0 * of_set[STEP_LENGTH]
        while levels <= MOST_DOUBLINGS and width <= longest:
            levels += 1
            width *= 2.0
        of_set[N_LEVELS] = levels


@kernel
def length(a: float, b: float) -> float:
    """Return the length of a vector."""
    return math.sqrt(a * a + b * b)


@kernel
def fill_guard_bounds(
    modes: Floats, drive: Floats, omegas: Floats, guard: Floats, feed: Floats, levels: Floats
) -> None:
    """Fill what bounds the fourth derivatives of guards: OF_NORM, SURGES and TWIST.

    ``modes`` (n, ...) and ``drive`` (n, m, 4) are those of a set, ``omegas`` (m,) the frequencies
    of the harmonics; ``guard`` is (s, n, 3), ``feed`` (s, m, 2) and ``levels`` (s, ...).
    """
    for i in range(guard.shape[0]):
        surges = 0.0
        for j in range(modes.shape[0]):
            spring = modes[j, SPRING]
            drag = modes[j, DRAG]
            p = -spring * guard[i, j, OF_W]
            q = guard[i, j, OF_U] - drag * guard[i, j, OF_W]
            p, q = -spring * q, p - drag * q
            if spring > 0.0:
                norm = math.sqrt(p * p / spring + q * q)
            elif spring < 0.0:
                norm = abs(p) / pace_of(spring, drag) + abs(q)
            else:
                norm = abs(q)
            guard[i, j, OF_NORM] = norm
            surges += norm * modes[j, SURGE]
        levels[i, SURGES] = surges
        twist = 0.0
        for k in range(omegas.shape[0]):
            omega = omegas[k]
            cube = omega * omega * omega
            # Phasors, cosine - i sine, of what enters in the fourth derivative.
            real = omega * cube * feed[i, k, 0]
            imaginary = -omega * cube * feed[i, k, 1]
            for j in range(modes.shape[0]):
                p = guard[i, j, OF_U]
                q = guard[i, j, OF_W]
                p1 = -modes[j, SPRING] * q
                q1 = p - modes[j, DRAG] * q
                cosine = p * drive[j, k, RATE_COS] + q * drive[j, k, FORCE_COS]
                sine = p * drive[j, k, RATE_SIN] + q * drive[j, k, FORCE_SIN]
                real -= cube * sine
                imaginary -= cube * cosine
                cosine = p1 * drive[j, k, RATE_COS] + q1 * drive[j, k, FORCE_COS]
                sine = p1 * drive[j, k, RATE_SIN] + q1 * drive[j, k, FORCE_SIN]
                real -= omega * omega * cosine
                imaginary += omega * omega * sine
            twist += length(real, imaginary)
        levels[i, TWIST] = twist
