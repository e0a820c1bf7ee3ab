"""Newton's method on the equations of a chain of flights (`percuss.kernels.shooting`)."""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.law import Law, Table
from percuss.kernels.linear import eliminate
from percuss.kernels.record import Integers
from percuss.kernels.shooting import shoot

# Why `iterate` came back: steps are down to rounding; the equations are singular to within WEAK,
# so that a step of least norm has to be made; no more steps; numbers out of range.
SETTLED, SINGULAR, SPENT, LOST = range(4)

# Scaled steps below this are rounding; so are steps below the second that gain nothing.
SMALLEST_STEP = 1e-13
SMALL_STEP = 1e-9
# Pivots below this part of the largest entry.
WEAK = 1e-10


@kernel
def scales(unknowns: Table, n: int) -> tuple[float, float]:
    """Return the scales of time, the mean duration, and of velocity, the greatest one."""
    time = 0.0
    speed = 0.0
    for i in range(n):
        time += abs(unknowns[1 + i]) / n
        speed = max(speed, abs(unknowns[1 + n + i]))
    # With r = 0 every flight may start from rest.
    return time if time > 0.0 else 1.0, speed if speed > 0.0 else 1.0


@kernel
def equations(
    law: Law,
    chain: Integers,
    unknowns: Table,
    period: float,
    phases: Table,
    arrival: Table,
    residual: Table,
    matrix: Table,
) -> float:
    """Write scaled residuals and the Jacobian by scaled unknowns; return the largest residual.

    A ``period`` of 0 is that of free motion, which is unknown: event 0 then stays where it is.
    """
    n = chain.shape[0]
    shoot(law, chain, unknowns, period, phases, arrival, residual, matrix)
    time, speed = scales(unknowns, n)
    last = 2 * n
    if period == 0.0:
        residual[last] = 0.0
        for k in range(last + 1):
            matrix[last, k] = 1.0 if k == 0 else 0.0
    size = 0.0
    for i in range(last + 1):
        scale = time
        if i < last:
            scale = speed * time if i % 2 == 0 else speed
        residual[i] /= scale
        # Larger than any number where it is none.
        size = max(size, abs(residual[i])) if residual[i] == residual[i] else math.inf
        for k in range(last + 1):
            matrix[i, k] *= (time if k <= n else speed) / scale
    return size


@kernel
def advance(unknowns: Table, step: Table, n: int) -> float:
    """Add a scaled step to the unknowns, durations kept above a tenth; return its size.

    Far from a solution the step tells the way, not the distance: it is cut to the scales.
    """
    time, speed = scales(unknowns, n)
    size = 0.0
    for k in range(2 * n + 1):
        size = max(size, abs(step[k]))
    part = 1.0 / size if size > 1.0 else 1.0
    for i in range(n):
        shorter = -step[1 + i] * time
        if shorter * part > 0.9 * unknowns[1 + i]:
            part = 0.9 * unknowns[1 + i] / shorter
    for k in range(2 * n + 1):
        unknowns[k] += part * step[k] * (time if k <= n else speed)
    return size


@kernel
def copy(source: Table, target: Table) -> None:
    """Write one row of numbers into another."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel
def iterate(
    law: Law,
    chain: Integers,
    unknowns: Table,
    period: float,
    phases: Table,
    arrival: Table,
    residual: Table,
    matrix: Table,
    best: Table,
    steps: int,
) -> tuple[int, float, int]:
    """Improve the unknowns; return (why it came back, best scaled residual, steps left).

    ``best`` (2 n + 1,) receives the unknowns with that residual, ``unknowns`` the last ones.
    """
    n = chain.shape[0]
    size = equations(law, chain, unknowns, period, phases, arrival, residual, matrix)
    least = size
    copy(unknowns, best)
    while steps > 0:
        if not size < math.inf:
            return LOST, least, steps
        for i in range(2 * n + 1):
            residual[i] = -residual[i]
        if not eliminate(matrix, residual, WEAK):
            return SINGULAR, least, steps
        moved = advance(unknowns, residual, n)
        steps -= 1
        size = equations(law, chain, unknowns, period, phases, arrival, residual, matrix)
        gained = size < least
        if gained:
            least = size
            copy(unknowns, best)
        if moved < SMALLEST_STEP or (moved < SMALL_STEP and not gained):
            return SETTLED, least, steps
    return SPENT, least, steps
