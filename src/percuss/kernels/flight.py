"""How the oscillator moves between two events: the closed form, and bounds on its derivatives.

A flight is told by its region, its start (an instant, a velocity, the constant force there) and
the displacement y from where it starts. Measuring from the start is what lets a hop far below
one ulp of x be seen. ``phases`` holds cos and sin of w_j t at the start, one row a harmonic.
"""

from __future__ import annotations

from typing import TypeAlias

from percuss.kernels.angles import cos_sin
from percuss.kernels.compile import kernel
from percuss.kernels.law import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    LOWER,
    LOWER_FORCE,
    NEAR,
    OMEGA,
    ORIGIN,
    ORIGIN_FORCE,
    QUICKEST,
    RATE,
    SINE,
    SLOW_ROOT,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    UPPER,
    UPPER_FORCE,
    Law,
    Table,
)
from percuss.kernels.response import SERIES_LIMIT, free_response, harmonic_response

# A flight's start: (t, t_low, velocity, constant force).
Start: TypeAlias = tuple[float, float, float, float]

# Relative error allowed for each term of a flight: the sum of the roundings in S, D, Q_j and in
# the velocity and forces they multiply (docs/theory/first-event.md counts them).
ROUNDING = 16 * 2.220446049250313e-16


@kernel
def constant_force(law: Law, region: int, x: float) -> float:
    """Return G - K x: the constant force at x, without cancellation at the region's bounds."""
    if x == law[region, LOWER]:
        return law[region, LOWER_FORCE]
    if x == law[region, UPPER]:
        return law[region, UPPER_FORCE]
    return law[region, ORIGIN_FORCE] - law[region, STIFFNESS] * (x - law[region, ORIGIN])


@kernel
def set_phases(law: Law, t: float, t_low: float, phases: Table) -> None:
    """Write cos and sin of w_j (t + t_low) into the rows of ``phases``."""
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cosine, sine = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], t, t_low)
        phases[j, 0] = cosine
        phases[j, 1] = sine


@kernel
def force_derivative(law: Law, phases: Table, order: int) -> float:
    """Return the derivative of that order of the harmonic force, at the instant of ``phases``."""
    total = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        part = law[harmonic, COSINE] * phases[j, 0] + law[harmonic, SINE] * phases[j, 1]
        quadrature = law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        # A derivative turns the phasor (part, quadrature) by a quarter and scales it by w.
        turned = quadrature if order & 1 else part
        scale = 1.0
        for _ in range(order):
            scale *= law[harmonic, OMEGA]
        total += -scale * turned if order & 2 else scale * turned
    return total


@kernel
def force_and_slopes(law: Law, phases: Table) -> tuple[float, float, float]:
    """Return the harmonic force and its first two derivatives at the instant of ``phases``."""
    force = 0.0
    slope = 0.0
    bend = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        part = law[harmonic, COSINE] * phases[j, 0] + law[harmonic, SINE] * phases[j, 1]
        quadrature = law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        omega = law[harmonic, OMEGA]
        force += part
        slope += omega * quadrature
        bend -= omega * omega * part
    return force, slope, bend


@kernel
def move(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    s: float,
    arrival: Table,
) -> tuple[float, float]:
    """Return (y, v) a time s after the start, and write the phases there into ``arrival``."""
    _, _, v0, force = start
    blow, even, rise = free_response(law, region, s)
    # What the forces do is summed first: each rounding of the whole would stay in it.
    y = force * rise
    v = force * blow - v0 * law[region, DAMPING] * blow
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cos0 = phases[j, 0]
        sin0 = phases[j, 1]
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        arrival[j, 0] = cos0 * turn[0] - sin0 * turn[1]
        arrival[j, 1] = sin0 * turn[0] + cos0 * turn[1]
        to_cos, to_sin = harmonic_response(law, region, j, s, blow, even, turn)
        in_phase = law[harmonic, COSINE] * cos0 + law[harmonic, SINE] * sin0
        quadrature = law[harmonic, SINE] * cos0 - law[harmonic, COSINE] * sin0
        y += in_phase * to_cos + quadrature * to_sin
        # Q' = S + i w Q.
        omega = law[harmonic, OMEGA]
        v += in_phase * (blow - omega * to_sin) + quadrature * omega * to_cos
    return v0 * blow + y, v0 * even + v


@kernel
def uncertainty(law: Law, region: int, start: Start, phases: Table, s: float) -> float:
    """Return a bound on the rounding error of the displacement a time s after the start.

    It is the error of evaluation and that of a relative rounding of the starting velocity and of
    each force, which no later care can undo.
    """
    return uncertainties(law, region, start, phases, s)[0]


@kernel
def uncertainties(
    law: Law, region: int, start: Start, phases: Table, s: float
) -> tuple[float, float]:
    """Return bounds on the rounding errors of displacement and velocity (see `uncertainty`)."""
    size, speed = sizes(law, region, start, phases, s)
    rounding = ROUNDING * growth_of_rounding(law, region, s)
    return size * rounding, speed * rounding


@kernel
def growth_of_rounding(law: Law, region: int, s: float) -> float:
    """Return the factor of what a growing exponential adds: the rounding of its exponent."""
    return 1.0 + max(0.0, law[region, SLOW_ROOT] * s) / 16.0


@kernel
def sizes(law: Law, region: int, start: Start, phases: Table, s: float) -> tuple[float, float]:
    """Return the sums of the magnitudes of the terms of y and of v a time s after the start."""
    _, _, v0, force = start
    blow, even, rise = free_response(law, region, s)
    size = abs(v0 * blow) + abs(force * rise)
    speed = abs(v0) * (abs(even) + law[region, DAMPING] * abs(blow)) + abs(force * blow)
    n = phases.shape[0]
    for j in range(n):
        response = region + 1 + j
        omega = law[FIRST_HARMONIC + j, OMEGA]
        # No response to a bounded force exceeds the one to its bound while S >= 0.
        limit = 0.5 * s * s
        if s * max(law[region, QUICKEST], omega) >= SERIES_LIMIT:
            terms = 1.0 + abs(even) + (law[region, DAMPING] + omega) * abs(blow)
            limit = terms * (abs(law[response, GAIN_RE]) + abs(law[response, GAIN_IM]))
            if law[response, NEAR] == 1.0:
                limit = (
                    s * (abs(even) + law[region, RATE] * abs(blow)) / law[region, RATE]
                    + terms / omega**2
                )
        size += law[FIRST_HARMONIC + j, AMPLITUDE] * limit
        # Q' = S + i w Q.
        speed += law[FIRST_HARMONIC + j, AMPLITUDE] * (abs(blow) + omega * limit)
    return size, speed


@kernel
def acceleration_and_jerk(
    law: Law, region: int, force: float, phases: Table, y: float, v: float
) -> tuple[float, float]:
    """Return x'' and x''' at displacement y and velocity v, at the instant of ``phases``."""
    pull = 0.0
    slope = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        pull += law[harmonic, COSINE] * phases[j, 0] + law[harmonic, SINE] * phases[j, 1]
        slope += law[harmonic, OMEGA] * (
            law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        )
    second = force + pull - 2.0 * law[region, DAMPING] * v - law[region, STIFFNESS] * y
    third = slope - 2.0 * law[region, DAMPING] * second - law[region, STIFFNESS] * v
    return second, third


@kernel
def four_derivatives(
    law: Law, region: int, force: float, phases: Table, y: float, v: float
) -> tuple[float, float, float, float]:
    """Return the second to the fifth derivative of x, as `acceleration_and_jerk` does two."""
    second, third = acceleration_and_jerk(law, region, force, phases, y, v)
    _, _, bend = force_and_slopes(law, phases)
    twist = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        omega = law[harmonic, OMEGA]
        quadrature = law[harmonic, SINE] * phases[j, 0] - law[harmonic, COSINE] * phases[j, 1]
        twist -= omega * omega * omega * quadrature
    drag = 2.0 * law[region, DAMPING]
    fourth = bend - drag * third - law[region, STIFFNESS] * second
    fifth = twist - drag * fourth - law[region, STIFFNESS] * third
    return second, third, fourth, fifth


@kernel
def derivative_bound(
    law: Law, region: int, force_bound: float, lower: float, upper: float, s: float
) -> float:
    """Return a bound on abs(x^(m + 2)) over the next s, given x^(m) and x^(m + 1), m >= 1.

    Both obey the equation of motion with the force's m-th derivative, bounded by ``force_bound``,
    in place of the force, and their energy, or where K < 0 their norm, grows no faster than that
    (docs/theory/first-event.md). Valid for s up to one step of the region.
    """
    return (
        force_bound
        + law[region, BOUND_OF_X] * abs(lower)
        + law[region, BOUND_OF_V] * (abs(upper) + s * force_bound)
    )
