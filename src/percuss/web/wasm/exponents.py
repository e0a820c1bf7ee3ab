"""The largest Lyapunov exponent of one motion, as the page shows it.

`percuss.ensembles.lyapunov_exponents` has it with the same bits, and much besides.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.ensembles.decisions import (
    BLOCKS,
    ERROR,
    LARGEST,
    ORBIT_PERIODS,
    SMALLEST,
    drift_of_points,
    exponents_of_points,
    orbit_exponents,
    period_of_points,
    rounding_of,
    sign_of_exponent,
)
from percuss.ensembles.lyapunov import LONGEST
from percuss.kernels.arithmetic import hypotenuse
from percuss.kernels.compile import kernel
from percuss.kernels.law_columns import PERIOD
from percuss.kernels.observables import END_V, END_X, FIRST, IMPACTS, STROBES, TANGENTS
from percuss.kernels.record import AT_REST, REACHED_END
from percuss.web.facts import PERIODS, TRANSIENT
from percuss.web.wasm.basins import Space, follow_from

# What is written: the exponent [1/time], its error, and 1 where neighbours part, -1 where they
# meet.
OUT_VALUE, OUT_ERROR, OUT_SIGN, OUT_ENTRIES = range(4)


@kernel
def largest_exponent(space: Space, start: Floats, out: Floats) -> bool:
    """Write the exponent of the motion from (x0, v0, t0); return whether there is one."""
    period = space.law[0, PERIOD]
    since = start[2] + TRANSIENT * period
    every = PERIODS / BLOCKS * period
    until = since + BLOCKS * every
    times = (since, every, until)
    status = follow_from(space, start[0], start[1], start[2], times, TANGENTS)
    if status not in (REACHED_END, AT_REST):
        return False
    exponents_of_points(space.points, until - since, every, space.rates, space.exponents)
    out[OUT_VALUE] = max(space.exponents[LARGEST], space.exponents[SMALLEST])
    drift = drift_of_points(space.points, every, space.rates)
    out[OUT_ERROR] = hypotenuse(space.exponents[ERROR], drift)
    if math.isfinite(space.points[BLOCKS, FIRST]):
        size = max(abs(space.points[0, FIRST]), abs(space.points[BLOCKS, FIRST]))
        out[OUT_ERROR] += rounding_of(2.0 * space.values[IMPACTS], size) / (until - since)
        of_orbit(space, until, period, out)
    out[OUT_SIGN] = sign_of_exponent(out[OUT_VALUE], out[OUT_ERROR], PERIODS, period)
    return True


@kernel
def of_orbit(space: Space, t: float, period: float, out: Floats) -> None:
    """Write the exponent of a periodic orbit where the motion has come to one."""
    x, v = space.values[END_X], space.values[END_V]
    until = t + 2 * LONGEST * period
    follow_from(space, x, v, t, (t, period, until), STROBES)
    n_periods = period_of_points(space.strobes[: 2 * LONGEST + 1], LONGEST, period)
    if n_periods == 0:
        return
    step = period * n_periods
    follow_from(space, x, v, t, (t, step, t + ORBIT_PERIODS * step), TANGENTS)
    points = space.points[: ORBIT_PERIODS + 1]
    so_far = (TRANSIENT + PERIODS) / n_periods
    n_events = 2.0 * space.values[IMPACTS] / ORBIT_PERIODS
    if orbit_exponents(points, step, so_far, n_events, space.exponents):
        out[OUT_VALUE] = space.exponents[0]
        out[OUT_ERROR] = space.exponents[2]
