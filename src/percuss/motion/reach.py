"""Whether a flight can meet a bound at all, from the amplitudes of its parts."""

from __future__ import annotations

import math

from percuss.kernels.flight import Start, move
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
    STIFFNESS,
    UPPER,
    Law,
    Table,
)


def steady(law: Law, region: int, force: float, phases: Table) -> tuple[float, float, float]:
    """Return the steady motion y and v at the instant of ``phases``, and its largest swing.

    Infinite where there is none: K <= 0, or a harmonic too near to resonance.
    """
    stiffness = law[region, STIFFNESS]
    if stiffness <= 0.0:
        return math.inf, math.inf, math.inf
    y = force / stiffness
    v = 0.0
    swing = 0.0
    n = phases.shape[0]
    for j in range(n):
        harmonic = FIRST_HARMONIC + j
        response = region + 1 + j
        real = law[response, GAIN_RE]
        imaginary = law[response, GAIN_IM]
        if real == 0.0 and imaginary == 0.0:
            return math.inf, math.inf, math.inf
        in_phase = law[harmonic, COSINE] * phases[j, 0] + law[harmonic, SINE] * phases[j, 1]
        quadrature = law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
        y += in_phase * real + quadrature * imaginary
        v -= law[harmonic, OMEGA] * (in_phase * imaginary - quadrature * real)
        swing += law[harmonic, AMPLITUDE] * math.hypot(real, imaginary)
    return y, v, swing


def envelope(law: Law, region: int, z: float, w: float) -> float:
    """Return a bound on all later displacements of free motion from (z, w)."""
    if law[region, OVERDAMPED] == 1.0:
        late = (w - law[region, FAST_ROOT] * z) / (2.0 * law[region, RATE])
        return abs(late) + abs(z - late)
    if law[region, RATE] == 0.0:
        return math.inf
    return math.hypot(z, (w + law[region, DAMPING] * z) / law[region, RATE])


def never_meets(
    law: Law,
    region: int,
    x: float,
    start: Start,
    phases: Table,
    arrival: Table,
    s: float,
) -> bool:
    """Tell whether a flight provably meets no bound from a time s after its start on.

    True only by the sum of amplitudes: of the steady harmonics, and of what is left of the free
    motion.
    """
    if law[region, LOWER] == -math.inf and law[region, UPPER] == math.inf:
        return True
    y, v = move(law, region, start, phases, s, arrival)
    steady_y, steady_v, swing = steady(law, region, start[3], arrival)
    if swing == math.inf:
        return False
    swing += envelope(law, region, y - steady_y, v - steady_v)
    middle = x + start[3] / law[region, STIFFNESS]
    return middle - swing > law[region, LOWER] and middle + swing < law[region, UPPER]
