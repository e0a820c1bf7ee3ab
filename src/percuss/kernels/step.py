"""Steps of the walk along a flight, several ahead at once, as linear maps.

The state after 1, 2, ... STEPS_AHEAD steps is a fixed linear map of the state before them, of the
constant force and of the two parts of each harmonic: its columns of the law are filled once, from
the closed form. The maps lie side by side, so that one vector instruction makes several steps.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import (
    SLOPE_TERMS,
    free_response,
    harmonic_response,
    harmonic_size,
    slope_response,
)
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    GROWTH,
    N_HARMONICS,
    N_REGIONS,
    OMEGA,
    SINE,
    STEP,
    STEP_COS,
    STEP_SIN,
    STEPS_AHEAD,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    V_OF_COS,
    V_OF_FORCE,
    V_OF_SIN,
    V_OF_V,
    V_OF_X,
    WALK_SIZE,
    X_OF_COS,
    X_OF_FORCE,
    X_OF_SIN,
    X_OF_V,
    X_OF_X,
    Law,
)
from percuss.kernels.pieces import is_record
from percuss.kernels.vectors import Eight, eight_at, shifted

Walk: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]


class Ahead(NamedTuple):
    """Displacements and velocities before and after each of the steps ahead."""

    y: Eight
    v: Eight
    y1: Eight
    v1: Eight


@kernel
def fill_steps(law: Law) -> None:
    """Fill the columns of the steps in the rows of all regions and responses from their others."""
    n = int(law[0, N_HARMONICS])
    for number in range(int(law[0, N_REGIONS])):
        region = FIRST_HARMONIC + n + number * (1 + n)
        law[region, WALK_SIZE] = 0.0
        for k in range(STEPS_AHEAD):
            size = fill_step(law, region, k)
            if k == 0 or law[region, GROWTH] == 0.0:
                # Where a motion grows no more than one step is made.
                law[region, WALK_SIZE] = max(law[region, WALK_SIZE], size)


@kernel
def fill_step(law: Law, region: int, k: int) -> float:
    """Fill the columns of the place after k + 1 steps in a region; return the size of its terms."""
    s = (k + 1.0) * law[region, STEP]
    impulse, even, rise = free_response(law, region, s)
    law[region, X_OF_X + k] = even + law[region, DAMPING] * impulse
    law[region, X_OF_V + k] = impulse
    law[region, V_OF_X + k] = -law[region, STIFFNESS] * impulse
    law[region, V_OF_V + k] = even - law[region, DAMPING] * impulse
    law[region, X_OF_FORCE + k] = rise
    size = abs(rise)
    for j in range(int(law[0, N_HARMONICS])):
        harmonic = FIRST_HARMONIC + j
        response = region + 1 + j
        if is_record(law, j):
            # The force and less its slope stand for the two parts of a harmonic.
            to_slope = slope_response(law, region, s, impulse, rise)
            law[response, X_OF_COS + k] = rise
            law[response, X_OF_SIN + k] = -to_slope
            law[response, V_OF_COS + k] = impulse
            law[response, V_OF_SIN + k] = -rise
            # The force changes by the slope, which stays.
            law[response, STEP_COS + k] = 1.0
            law[response, STEP_SIN + k] = -s
            size = max(size, SLOPE_TERMS * abs(to_slope))
            continue
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        to_cos, to_sin = harmonic_response(law, region, j, s, impulse, even, turn)
        law[response, X_OF_COS + k] = to_cos
        law[response, X_OF_SIN + k] = to_sin
        law[response, V_OF_COS + k] = impulse - law[harmonic, OMEGA] * to_sin
        law[response, V_OF_SIN + k] = law[harmonic, OMEGA] * to_cos
        law[response, STEP_COS + k] = turn[0]
        law[response, STEP_SIN + k] = turn[1]
        size = max(size, harmonic_size(law, region, j, s, impulse, even))
    return size


@formula
def set_parts(law: Law, phases: Floats, parts: Floats) -> None:
    """Write the two parts of each harmonic at the instant of ``phases``, which may be ``parts``.

    They are those of `flight.parts_of`, written out here: as a pair they slow runs under records.
    """
    for j in range(phases.shape[0]):
        cosine = phases[j, 0]
        sine = phases[j, 1]
        harmonic = FIRST_HARMONIC + j
        parts[j, 0] = law[harmonic, COSINE] * cosine + law[harmonic, SINE] * sine
        parts[j, 1] = law[harmonic, SINE] * cosine - law[harmonic, COSINE] * sine


@formula
def size_of_steps(law: Law, region: int, force: float, parts: Floats, y: float, v: float) -> float:
    """Return the size that bounds the rounding of the steps ahead from (y, v) and the parts."""
    forces = abs(force)
    for j in range(parts.shape[0]):
        forces += abs(parts[j, 0]) + abs(parts[j, 1])
    return abs(y) + law[region, STEP] * abs(v) + 0.5 * law[region, WALK_SIZE] * forces


@formula
def walk_ahead(law: Law, region: int, force: float, parts: Floats, y: float, v: float) -> Ahead:
    """Return the places before and after each of the steps ahead, from (y, v) and the parts."""
    y1 = eight_at(law, region, X_OF_FORCE) * force
    v1 = eight_at(law, region, V_OF_FORCE) * force
    y1 = y1 + (eight_at(law, region, X_OF_X) * y + eight_at(law, region, X_OF_V) * v)
    v1 = v1 + (eight_at(law, region, V_OF_X) * y + eight_at(law, region, V_OF_V) * v)
    for j in range(parts.shape[0]):
        part = parts[j, 0]
        quadrature = parts[j, 1]
        row = region + 1 + j
        y1 = y1 + (eight_at(law, row, X_OF_COS) * part + eight_at(law, row, X_OF_SIN) * quadrature)
        v1 = v1 + (eight_at(law, row, V_OF_COS) * part + eight_at(law, row, V_OF_SIN) * quadrature)
    return Ahead(shifted(y, y1), shifted(v, v1), y1, v1)


@formula
def turned_parts(law: Law, region: int, j: int, parts: Floats, k: int) -> tuple[float, float]:
    """Return the parts of a harmonic k steps later."""
    part = parts[j, 0]
    quadrature = parts[j, 1]
    if k == 0:
        return part, quadrature
    cosine = law[region + 1 + j, STEP_COS + k - 1]
    sine = law[region + 1 + j, STEP_SIN + k - 1]
    # The slope of a record stays.
    back = 0.0 if is_record(law, j) else sine
    return part * cosine + quadrature * sine, quadrature * cosine - part * back


@formula
def turn_parts(law: Law, region: int, parts: Floats) -> None:
    """Turn the parts of all harmonics by all the steps ahead."""
    for j in range(parts.shape[0]):
        parts[j, 0], parts[j, 1] = turned_parts(law, region, j, parts, STEPS_AHEAD)


@formula
def derivatives_ahead(
    law: Law, region: int, force: float, parts: Floats, k: int, y: float, v: float
) -> tuple[float, float]:
    """Return the second and the third derivative k steps after the parts, at (y, v)."""
    pull = force
    slope = 0.0
    for j in range(parts.shape[0]):
        part, quadrature = turned_parts(law, region, j, parts, k)
        pull += part
        slope += law[FIRST_HARMONIC + j, OMEGA] * quadrature
    drag = 2.0 * law[region, DAMPING]
    second = pull - drag * v - law[region, STIFFNESS] * y
    return second, slope - drag * second - law[region, STIFFNESS] * v


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
