"""The maps of the modes over steps of doubling lengths, filled once from the closed form."""

from __future__ import annotations

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import kernel
from percuss.kernels.flight import free_response, harmonic_response, slope_response
from percuss.kernels.law_columns import FIRST_HARMONIC, OMEGA, TURNS, TURNS_LOW, Law
from percuss.kernels.structure.basis import (
    DRAG,
    SPRING,
    STEP_D,
    STEP_E,
    STEP_ENTRIES,
    STEP_HARMONIC,
    STEP_S,
    U_OF_U,
    W_OF_U,
    W_OF_W,
)


@kernel
def fill_steps(law: Law, modes: Floats, shortest: float, steps: Floats, turns: Floats) -> None:
    """Fill ``steps`` (l, ..., n) and ``turns`` (l, m, 2) for steps of lengths shortest * 2**l."""
    m = turns.shape[1]
    width = shortest
    for level in range(steps.shape[0]):
        for k in range(m):
            harmonic = FIRST_HARMONIC + k
            turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], width, 0.0)
            turns[level, k, 0], turns[level, k, 1] = turn
        for j in range(modes.shape[0]):
            row = FIRST_HARMONIC + m + j * (1 + m)
            step = steps[level, :, j]
            spring = modes[j, SPRING]
            impulse, even, rise = free_response(law, row, width)
            step[STEP_S] = impulse
            step[STEP_D] = rise
            step[STEP_E] = slope_response(law, row, width, impulse, rise)
            step[U_OF_U] = even + 0.5 * modes[j, DRAG] * impulse
            step[W_OF_U] = -spring * impulse
            step[W_OF_W] = even - 0.5 * modes[j, DRAG] * impulse
            for k in range(m):
                omega = law[FIRST_HARMONIC + k, OMEGA]
                turn = (turns[level, k, 0], turns[level, k, 1])
                to_cos, to_sin = harmonic_response(law, row, k, width, impulse, even, turn)
                at = STEP_ENTRIES + STEP_HARMONIC * k
                step[at] = to_cos
                step[at + 1] = to_sin
                step[at + 2] = impulse - omega * to_sin
                step[at + 3] = omega * to_cos
        width *= 2.0
