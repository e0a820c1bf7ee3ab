"""Long stretches that are free of events, by what the parts of a motion can do.

The walk of `search` takes steps of the fastest rate in a region. Where a fast part is small, as
what is left of a decay in a stiff stop or the answer to a force of very high frequency, and cannot
reach a bound, only the slow parts need to be looked at (docs/theory/first-event.md).
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.kernels.angles import cos_sin
from percuss.kernels.arithmetic import exponential, hypotenuse
from percuss.kernels.compile import kernel
from percuss.kernels.flight import Start, move
from percuss.kernels.law import (
    AMPLITUDE,
    COSINE,
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    OMEGA,
    OVERDAMPED,
    PER_STIFFNESS,
    RATE,
    SINE,
    SLOW_ROOT,
    STEP,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    Law,
    Table,
)
from percuss.kernels.response import free_response

# The phase of the quickest slow part over one stretch.
STRETCH_PHASE = 1.0
# What is compared is rounded like any flight; a clearance has to be larger than this part of the
# sizes involved.
SLACK = 1e-9
# A stretch is worth its search where it is this many steps of the walk.
WORTH = 128.0
# Stretches in one call: a few hundred ns each.
MOST_STRETCHES = 1000

# The free motion at some time: displacement and velocity of its oscillating or fast part, and the
# part of the slow one of two real roots.
Free: TypeAlias = tuple[float, float, float]


@kernel
def is_spread(law: Law, region: int, n: int) -> bool:
    """Tell whether the slowest part of a motion is so slow that a stretch may be worth it.

    That needs a spring, and no harmonic in exact resonance.
    """
    return slowest(law, region, n) * law[region, STEP] * WORTH < STRETCH_PHASE


@kernel
def slowest(law: Law, region: int, n: int) -> float:
    """Return the rate of the slowest part of a motion, infinite where the parts are not known."""
    if not law[region, STIFFNESS] > 0.0 or law[region, RATE] == 0.0:
        return math.inf
    rate = math.sqrt(law[region, STIFFNESS])
    if law[region, OVERDAMPED] == 1.0:
        rate = -law[region, SLOW_ROOT]
    for j in range(n):
        if law[region + 1 + j, GAIN_RE] == 0.0 and law[region + 1 + j, GAIN_IM] == 0.0:
            return math.inf
        rate = min(rate, law[FIRST_HARMONIC + j, OMEGA])
    return rate


@kernel
def coast(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    s: float,
    reach: tuple[float, float],
    longest: float,
) -> float:
    """Return a time since the start, at least s, up to which a flight provably meets no bound.

    Infinite if it never will. ``arrival`` is scratch; the parts of the motion must be known
    (`slowest`).
    """
    rate = slowest(law, region, phases.shape[0])
    least = WORTH * law[region, STEP]
    width = math.inf
    for _ in range(MOST_STRETCHES):
        if s >= longest:
            break
        y, v = move(law, region, start, phases, s, arrival)
        free = free_part(law, region, start[3], arrival, y, v)
        if is_clear(law, region, start[3], arrival, free, reach, math.inf):
            return math.inf
        if not is_clear(law, region, start[3], arrival, free, reach, least):
            break
        width = min(width, STRETCH_PHASE / rate)
        while width > least and not is_clear(law, region, start[3], arrival, free, reach, width):
            width *= 0.5
        s += max(width, least)
        width *= 4.0
    return s


@kernel
def free_part(law: Law, region: int, force: float, phases: Table, y: float, v: float) -> Free:
    """Return the free motion at (y, v): what the steady motions and the constant force leave."""
    z = y - force * law[region, PER_STIFFNESS]
    w = v
    for j in range(phases.shape[0]):
        steady, rate = steady_part(law, region, j, phases[j, 0], phases[j, 1])
        z -= steady
        w -= rate
    if law[region, OVERDAMPED] == 0.0:
        return z, w, 0.0
    late = (w - law[region, FAST_ROOT] * z) / (2.0 * law[region, RATE])
    z -= late
    return z, law[region, FAST_ROOT] * z, late


@kernel
def steady_part(law: Law, region: int, j: int, cosine: float, sine: float) -> tuple[float, float]:
    """Return (y, v) of the steady motion of a harmonic whose phase has this cosine and sine."""
    harmonic = FIRST_HARMONIC + j
    real = law[region + 1 + j, GAIN_RE]
    imaginary = law[region + 1 + j, GAIN_IM]
    in_phase = law[harmonic, COSINE] * cosine + law[harmonic, SINE] * sine
    quadrature = law[harmonic, SINE] * cosine - law[harmonic, COSINE] * sine
    # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
    y = in_phase * real + quadrature * imaginary
    return y, law[harmonic, OMEGA] * (quadrature * real - in_phase * imaginary)


@kernel
def is_clear(
    law: Law,
    region: int,
    force: float,
    phases: Table,
    free: Free,
    reach: tuple[float, float],
    width: float,
) -> bool:
    """Tell whether a motion is clear of both bounds for a time ``width``, which may be infinite.

    ``phases`` and ``free`` are those at its beginning. The parts that are slow over it stay
    together within the Bernstein coefficients of a cubic and its error, the others within their
    amplitudes, and the slow one of two real roots between its ends.
    """
    z, w, late = free
    middle = force * law[region, PER_STIFFNESS]
    y0 = 0.0
    v0 = 0.0
    y1 = 0.0
    v1 = 0.0
    error = 0.0
    size = abs(middle) + abs(late)
    for j in range(phases.shape[0]):
        gain = hypotenuse(law[region + 1 + j, GAIN_RE], law[region + 1 + j, GAIN_IM])
        swing = law[FIRST_HARMONIC + j, AMPLITUDE] * gain
        size += swing
        angle = law[FIRST_HARMONIC + j, OMEGA] * width
        if angle > STRETCH_PHASE:
            error += swing
            continue
        error += swing * angle**4 * (1.0 / 384.0)
        cosine = phases[j, 0]
        sine = phases[j, 1]
        y, v = steady_part(law, region, j, cosine, sine)
        y0 += y
        v0 += v
        turn = cos_sin(
            law[FIRST_HARMONIC + j, TURNS], law[FIRST_HARMONIC + j, TURNS_LOW], width, 0.0
        )
        y, v = steady_part(
            law, region, j, cosine * turn[0] - sine * turn[1], sine * turn[0] + cosine * turn[1]
        )
        y1 += y
        v1 += v
    rate = math.sqrt(law[region, STIFFNESS])
    swing = abs(z)
    if law[region, OVERDAMPED] == 1.0:
        rate = math.inf
    else:
        swing = hypotenuse(z, (w + law[region, DAMPING] * z) / law[region, RATE])
    size += swing
    if rate * width > STRETCH_PHASE:
        error += swing
    else:
        error += swing * (rate * width) ** 4 * (1.0 / 384.0)
        blow, even, _ = free_response(law, region, width)
        drag = law[region, DAMPING] * blow
        y0 += z
        v0 += w
        y1 += (even + drag) * z + blow * w
        v1 += (even - drag) * w - law[region, STIFFNESS] * blow * z
    low = min(y0, y1)
    high = max(y0, y1)
    if width < math.inf:
        third = width * (1.0 / 3.0)
        low = min(low, y0 + third * v0, y1 - third * v1)
        high = max(high, y0 + third * v0, y1 - third * v1)
    left = 0.0
    if late != 0.0:
        left = late * exponential(law[region, SLOW_ROOT] * width)
    low += middle + min(late, left) - error
    high += middle + max(late, left) + error
    slack = SLACK * (abs(low) + abs(high) + size)
    return low - slack > reach[0] and high + slack < reach[1]
