"""One step of the walk along a flight, as a linear map.

The state after a step is a fixed linear map of the state before it, of the constant force and of
the force's phasors: its columns of the law are filled once, from the closed form.
"""

from __future__ import annotations

from typing import TypeAlias

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import kernel
from percuss.kernels.flight import free_response, harmonic_response, slope_response
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    N_HARMONICS,
    N_REGIONS,
    OMEGA,
    SINE,
    STEP,
    STEP_COS,
    STEP_SIN,
    STEP_SIN_OF_COS,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    V_OF_COS,
    V_OF_FORCE,
    V_OF_SIN,
    V_OF_V,
    V_OF_X,
    X_OF_COS,
    X_OF_FORCE,
    X_OF_SIN,
    X_OF_V,
    X_OF_X,
    Law,
)

Walk: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]


@kernel
def fill_steps(law: Law) -> None:
    """Fill the columns of the step in the rows of all regions and responses from their others."""
    n = int(law[0, N_HARMONICS])
    for number in range(int(law[0, N_REGIONS])):
        region = FIRST_HARMONIC + n + number * (1 + n)
        step = law[region, STEP]
        impulse, even, rise = free_response(law, region, step)
        law[region, X_OF_X] = even + law[region, DAMPING] * impulse
        law[region, X_OF_V] = impulse
        law[region, V_OF_X] = -law[region, STIFFNESS] * impulse
        law[region, V_OF_V] = even - law[region, DAMPING] * impulse
        law[region, X_OF_FORCE] = rise
        law[region, V_OF_FORCE] = impulse
        for j in range(n):
            harmonic = FIRST_HARMONIC + j
            response = region + 1 + j
            if law[harmonic, OMEGA] < 0.0:
                # The force and less its slope stand for the two parts of a harmonic.
                law[response, X_OF_COS] = rise
                law[response, X_OF_SIN] = -slope_response(law, region, step, impulse, rise)
                law[response, V_OF_COS] = impulse
                law[response, V_OF_SIN] = -rise
                # The force changes by the slope, which stays.
                law[response, STEP_COS] = 1.0
                law[response, STEP_SIN] = -step
                continue
            turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], step, 0.0)
            to_cos, to_sin = harmonic_response(law, region, j, step, impulse, even, turn)
            law[response, X_OF_COS] = to_cos
            law[response, X_OF_SIN] = to_sin
            law[response, V_OF_COS] = impulse - law[harmonic, OMEGA] * to_sin
            law[response, V_OF_SIN] = law[harmonic, OMEGA] * to_cos
            law[response, STEP_COS] = turn[0]
            law[response, STEP_SIN] = turn[1]
            law[response, STEP_SIN_OF_COS] = turn[1]


@kernel
def step_on(
    law: Law, region: int, force: float, walker: Floats, y: float, v: float
) -> tuple[float, float]:
    """Return (y, v) one step later, and turn the phases in ``walker`` along."""
    # The state's own terms come last: a step then waits for little of the step before.
    y1 = law[region, X_OF_FORCE] * force
    v1 = law[region, V_OF_FORCE] * force
    for j in range(walker.shape[0]):
        harmonic = FIRST_HARMONIC + j
        response = region + 1 + j
        cosine = walker[j, 0]
        sine = walker[j, 1]
        in_phase = law[harmonic, COSINE] * cosine + law[harmonic, SINE] * sine
        quadrature = law[harmonic, SINE] * cosine - law[harmonic, COSINE] * sine
        y1 += law[response, X_OF_COS] * in_phase + law[response, X_OF_SIN] * quadrature
        v1 += law[response, V_OF_COS] * in_phase + law[response, V_OF_SIN] * quadrature
        walker[j, 0] = cosine * law[response, STEP_COS] - sine * law[response, STEP_SIN]
        walker[j, 1] = sine * law[response, STEP_COS] + cosine * law[response, STEP_SIN_OF_COS]
    y1 += law[region, X_OF_X] * y + law[region, X_OF_V] * v
    v1 += law[region, V_OF_X] * y + law[region, V_OF_V] * v
    return y1, v1


@kernel
def walk_of(law: Law, region: int) -> Walk:
    """Return the map of a region with one harmonic, as `harmonic_flight.harmonic_step` takes it."""
    return (
        law[region, X_OF_FORCE],
        law[region, V_OF_FORCE],
        law[region + 1, X_OF_COS],
        law[region + 1, X_OF_SIN],
        law[region + 1, V_OF_COS],
        law[region + 1, V_OF_SIN],
        law[region + 1, STEP_COS],
        law[region + 1, STEP_SIN],
        law[region, X_OF_X],
        law[region, X_OF_V],
        law[region, V_OF_X],
        law[region, V_OF_V],
    )
