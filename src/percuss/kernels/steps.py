"""The linear map over one step of the search, written into a law's tables."""

from __future__ import annotations

from percuss.kernels.angles import cos_sin
from percuss.kernels.compile import kernel
from percuss.kernels.law import (
    DAMPING,
    FIRST_HARMONIC,
    N_HARMONICS,
    N_REGIONS,
    OMEGA,
    STEP,
    STEP_COS,
    STEP_SIN,
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
from percuss.kernels.response import free_response, harmonic_response


@kernel
def fill_steps(law: Law) -> None:
    """Fill the step columns of ``regions`` and ``responses`` from their other columns."""
    n = int(law[0, N_HARMONICS])
    for number in range(int(law[0, N_REGIONS])):
        region = FIRST_HARMONIC + n + number * (1 + n)
        step = law[region, STEP]
        blow, even, rise = free_response(law, region, step)
        law[region, X_OF_X] = even + law[region, DAMPING] * blow
        law[region, X_OF_V] = blow
        law[region, V_OF_X] = -law[region, STIFFNESS] * blow
        law[region, V_OF_V] = even - law[region, DAMPING] * blow
        law[region, X_OF_FORCE] = rise
        law[region, V_OF_FORCE] = blow
        for j in range(n):
            harmonic = FIRST_HARMONIC + j
            response = region + 1 + j
            turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], step, 0.0)
            to_cos, to_sin = harmonic_response(law, region, j, step, blow, even, turn)
            law[response, X_OF_COS] = to_cos
            law[response, X_OF_SIN] = to_sin
            law[response, V_OF_COS] = blow - law[harmonic, OMEGA] * to_sin
            law[response, V_OF_SIN] = law[harmonic, OMEGA] * to_cos
            law[response, STEP_COS] = turn[0]
            law[response, STEP_SIN] = turn[1]
