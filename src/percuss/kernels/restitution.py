"""The velocity after an impact, from one coefficient of restitution or a table over the speed.

A table is linear between its knots and constant beyond them, and the speed after an impact grows
with that before it, so that each speed after has one before. A knot is a row of the law
(`law_columns`), the knots of a table follow one another.
"""

from __future__ import annotations

import math

from percuss.kernels.arithmetic import ULP
from percuss.kernels.compile import cold, kernel
from percuss.kernels.law_columns import (
    KNOT_RESTITUTION,
    KNOT_SPEED,
    KNOTS_LEFT,
    LOWER_RESTITUTION,
    LOWER_TABLE,
    NUMBER,
    UPPER_RESTITUTION,
    UPPER_TABLE,
    Law,
)

# Hops at the end of a chatter land a little faster than they set out.
MARGIN = 1.001
# Relative rounding of a restitution between two knots, and of the speed after the impact.
TABLE_ROUNDING = 8.0 * ULP


@kernel
def table_of(law: Law, region: int, bound: int) -> int:
    """Return the row of the first knot of a wall's table, 0 where its restitution is one number."""
    lower = bound == int(law[region, NUMBER])
    return int(law[region, LOWER_TABLE if lower else UPPER_TABLE])


@kernel
def constant_restitution(law: Law, region: int, bound: int) -> float:
    """Return the restitution of a wall of a region; of one with a table, that of slow impacts."""
    lower = bound == int(law[region, NUMBER])
    return law[region, LOWER_RESTITUTION if lower else UPPER_RESTITUTION]


@cold
def on_table(law: Law, table: int, speed: float) -> tuple[float, float]:
    """Return the restitution at a speed and its derivative; at a knot that above it."""
    knot = table
    for _ in range(int(law[table, KNOTS_LEFT])):
        if law[knot + 1, KNOT_SPEED] > speed:
            break
        knot += 1
    below = speed < law[table, KNOT_SPEED]
    if below or law[knot, KNOTS_LEFT] == 0.0:
        return law[knot, KNOT_RESTITUTION], 0.0
    slope = slope_after(law, knot)
    return law[knot, KNOT_RESTITUTION] + slope * (speed - law[knot, KNOT_SPEED]), slope


@kernel
def slope_after(law: Law, knot: int) -> float:
    """Return the derivative of the restitution by the speed between a knot and the next."""
    rise = law[knot + 1, KNOT_RESTITUTION] - law[knot, KNOT_RESTITUTION]
    return rise / (law[knot + 1, KNOT_SPEED] - law[knot, KNOT_SPEED])


@kernel
def restitution_at(law: Law, region: int, bound: int, speed: float) -> float:
    """Return the restitution r of a wall of a region at an impact of a speed."""
    table = table_of(law, region, bound)
    if table == 0:
        return constant_restitution(law, region, bound)
    return on_table(law, table, speed)[0]


@kernel
def kept_of_error(law: Law, region: int, bound: int, speed: float) -> float:
    """Return the derivative of r(u) u, the speed after an impact, by the speed u before it."""
    table = table_of(law, region, bound)
    if table == 0:
        return constant_restitution(law, region, bound)
    restitution, slope = on_table(law, table, speed)
    return restitution + slope * speed


@kernel
def kept_of_area(law: Law, region: int, bound: int, speed: float) -> float:
    """Return the square root of the factor of an impact on areas of the phase plane."""
    if table_of(law, region, bound) == 0:
        return constant_restitution(law, region, bound)
    kept = restitution_at(law, region, bound, speed) * kept_of_error(law, region, bound, speed)
    return math.sqrt(kept)


@kernel
def bend_of_impact(law: Law, region: int, bound: int, speed: float, error: float) -> float:
    """Return how far the error of the speed after an impact may be off its linear part.

    The derivative of r(u) u is linear between the knots: within ``error`` of a speed it differs
    most from that at the speed next to a knot or at an end.
    """
    table = table_of(law, region, bound)
    if table == 0:
        return 0.0
    kept = kept_of_error(law, region, bound, speed)
    low = max(speed - error, 0.0)
    high = speed + error
    most = max(
        abs(kept_of_error(law, region, bound, low) - kept),
        abs(kept_of_error(law, region, bound, high) - kept),
    )
    for i in range(int(law[table, KNOTS_LEFT]) + 1):
        knot = table + i
        at = law[knot, KNOT_SPEED]
        if low <= at <= high:
            after = slope_after(law, knot) if law[knot, KNOTS_LEFT] > 0.0 else 0.0
            before = slope_after(law, knot - 1) if i > 0 else 0.0
            most = max(most, abs(law[knot, KNOT_RESTITUTION] + after * at - kept))
            most = max(most, abs(law[knot, KNOT_RESTITUTION] + before * at - kept))
    return most * error


@kernel
def slow_restitution(law: Law, region: int, bound: int, speed: float) -> tuple[float, float]:
    """Return (r, r') at rest, if r + r' u holds for all impacts up to a speed; else (1, 0)."""
    table = table_of(law, region, bound)
    if table == 0:
        return constant_restitution(law, region, bound), 0.0
    fastest = MARGIN * speed
    at_rest = law[table, KNOT_RESTITUTION]
    if fastest <= law[table, KNOT_SPEED] or law[table, KNOTS_LEFT] == 0.0:
        return at_rest, 0.0
    if law[table, KNOT_SPEED] == 0.0 and fastest <= law[table + 1, KNOT_SPEED]:
        return at_rest, slope_after(law, table)
    return 1.0, 0.0


@kernel
def speed_before(law: Law, region: int, bound: int, speed: float) -> float:
    """Return the speed before an impact after which it is ``speed``; infinite where r = 0."""
    table = table_of(law, region, bound)
    if table == 0:
        restitution = constant_restitution(law, region, bound)
        return speed / restitution if restitution > 0.0 else math.inf
    knot = table
    for _ in range(int(law[table, KNOTS_LEFT])):
        if law[knot + 1, KNOT_RESTITUTION] * law[knot + 1, KNOT_SPEED] > speed:
            break
        knot += 1
    restitution = law[knot, KNOT_RESTITUTION]
    at = law[knot, KNOT_SPEED]
    if speed <= restitution * at or law[knot, KNOTS_LEFT] == 0.0:
        return speed / restitution
    # The larger root of slope u^2 + first u = speed, without cancellation.
    slope = slope_after(law, knot)
    first = restitution - slope * at
    return 2.0 * speed / (first + math.sqrt(first * first + 4.0 * slope * speed))
