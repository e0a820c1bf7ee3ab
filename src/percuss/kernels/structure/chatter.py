"""The end of a chatter at one wall, and clearances that are smaller than the rounding of a place."""

from __future__ import annotations

import math

from percuss.kernels.arithmetic import ULP
from percuss.kernels.compile import kernel
from percuss.kernels.contact import CHATTER_LIMIT, SLOW
from percuss.kernels.record import (
    T_LOW,
    T,
)
from percuss.kernels.structure.basis import (
    DRAG,
    IS_ON,
    IS_WALL,
    OF_U,
    OF_W,
    SELF_DRAG,
    SPRING,
)
from percuss.kernels.structure.flight import (
    ModalFlight,
    U,
    W,
    derivatives,
    fourth_bound,
    move,
    uncertainty,
)
from percuss.kernels.structure.run import FASTEST, SET, StructureRun, next_of_all, restitution

# A change of restitution over the slow hops of a chatter that its sum leaves out.
SAME = 1e-11
# Impacts slower than this part of the fastest keep the clearances to other walls.
HOPS = 1e-3


@kernel
def keep_near_walls(run: StructureRun, flight: ModalFlight, i: int, s: float) -> None:
    """Keep how near the structure is to the other walls of a chatter, at the impact on wall i.

    The value that the modes give is known to the rounding of the whole displacement. Where hops at
    two walls shrink at once that is soon all there is; but since a wall was struck its clearance is
    a sum of changes, and these have digits of their own. ``scratch[5]`` takes value and doubt.
    """
    near = run.scratch[5]
    for k in range(run.order.shape[0]):
        near[k, 1] = 0.0
        was_touched = run.order[k] == 1.0 or run.order[k] < 0.0
        if k != i and was_touched and run.sets.stops[k, IS_WALL] == 1.0:
            if flight.at[0] != s:
                move(flight, s)
            near[k, 0] = derivatives(flight, k, s, False)[0]
            near[k, 1] = uncertainty(flight, k, s)


@kernel
def take_near_walls(run: StructureRun) -> None:
    """Go on with the clearances that were kept, to walls that are neither touched nor hold."""
    held = run.sets.keys[run.counters[SET]]
    near = run.scratch[5]
    for k in range(run.order.shape[0]):
        if near[k, 1] > 0.0 and run.order[k] == 0.0 and not held & (1 << k):
            run.order[k] = -near[k, 1]
            run.values[k] = near[k, 0]


@kernel
def chatter_time(
    run: StructureRun, flight: ModalFlight, i: int, speed: float
) -> tuple[float, float]:
    """Return (time to the end of a chatter, its error bound), or (-1, 0) where none is summed.

    As `percuss.kernels.contact.chatter_time`, with the clearance's own derivatives.
    """
    sets, state = run.sets, run.state
    _, _, second, third, _, bend = derivatives(flight, i, 0.0, True)
    push = -second
    if not (push > 0.0 and speed <= SLOW * state[FASTEST]):
        return -1.0, 0.0
    ratio = restitution(sets, i, speed)
    if ratio >= 1.0 or abs(ratio - restitution(sets, i, 0.0)) > SAME * (1.0 - ratio):
        return -1.0, 0.0
    drag = 0.5 * flight.basis.levels[i, SELF_DRAG]
    total = 2.0 * speed / (push * (1.0 - ratio))
    fourth = fourth_bound(flight.basis, i, bend, 2.0 * total)
    pace = max(abs(third) / push + 4.0 * abs(drag), math.sqrt(fourth / push))
    if total * pace > CHATTER_LIMIT:
        return -1.0, 0.0
    time = total * (1.0 + (third / push - 3.0 * drag) * total / 3.0)
    knot = next_of_all(sets, state[T], state[T_LOW])
    if not 2.0 * time < (knot[0] - state[T]) + (knot[1] - state[T_LOW]):
        return -1.0, 0.0
    # Nothing else is met meanwhile.
    for k in range(run.order.shape[0]):
        if k != i and flight.basis.levels[k, IS_ON] == 1.0:
            y, first, curve, twist, _, bound = derivatives(flight, k, 0.0, True)
            fall = max(0.0, -first) + time * (abs(curve) + time * (abs(twist) + time * bound))
            if not y > 4.0 * time * fall + uncertainty(flight, k, time):
                return -1.0, 0.0
    spread = total * pace
    rounding = 64.0 * ULP * (1.0 + size_of_push(flight, i) / push)
    return time, total * (spread * spread + rounding)


@kernel
def size_of_push(flight: ModalFlight, i: int) -> float:
    """Return the sum of the magnitudes of the terms of a guard's second derivative."""
    basis = flight.basis
    total = 0.0
    for j in range(flight.begin.shape[0]):
        u = abs(flight.begin[j, U])
        w = abs(flight.begin[j, W])
        spring = abs(basis.modes[j, SPRING])
        drag = abs(basis.modes[j, DRAG])
        force = abs(flight.pull[0, j]) + spring * u + drag * w
        for k in range(flight.phases.shape[0]):
            force += abs(basis.drive[j, k, 0]) + abs(basis.drive[j, k, 1])
        total += abs(basis.guard[i, j, OF_U]) * force
        total += abs(basis.guard[i, j, OF_W]) * (spring * w + drag * force)
    return total
