"""Where a flight meets a bound, once it is known to do so exactly once on a stretch."""

from __future__ import annotations

import math

from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import (
    Start,
    acceleration_and_jerk,
    derivative_bound,
    four_derivatives,
    move,
    uncertainty,
)
from percuss.kernels.law import FIRST_HARMONIC, FORCE_BOUND, OMEGA, QUICKEST, Law, Table

# The last correction is made with the series alone when it is this small a phase.
SMALL_PHASE = 3e-4
ULP = 2.220446049250313e-16
MAX_ITERATIONS = 80


@kernel
def land(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    sign: float,
    distance: float,
    bracket: tuple[float, float, float],
) -> tuple[float, float, float]:
    """Return (s, v, rest) where the clearance sign * (y - distance) falls to zero.

    The root is s + rest: a float alone would leave the mass off the bound by v times its rounding.

    ``bracket`` is (left, right, guess): positive at the left, not positive at the right, one
    root between. ``arrival`` receives the phases there.
    """
    left, right, s = bracket
    force = start[3]
    v = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(law, region, start, phases, s, arrival)
        clearance = sign * (y - distance)
        if clearance > 0.0:
            left = s
        else:
            right = s
        second, third, fourth, fifth = four_derivatives(law, region, force, arrival, y, v)
        step = series_root(clearance, sign * v, sign * second, sign * third, sign * fourth)
        if left <= s + step <= right:
            sixth = derivative_bound(law, region, law[0, FORCE_BOUND + 4], fourth, fifth, 0.0)
            end = s + step
            settled = is_settled(law[region, QUICKEST], step, s, v, (second, fifth, sixth))
            # A step is rounded to its own size: one longer than the flight would leave that in it.
            if settled and abs(step) <= end:
                turn_by(law, arrival, step)
                rest = third * 0.5 + step * (fourth * (1.0 / 6.0) + step * fifth * (1.0 / 24.0))
                return end, v + step * (second + step * rest), step - (end - s)
            s = end
        else:
            middle = 0.5 * (left + right)
            if not left < middle < right:
                break
            s = middle
    return s, v, 0.0


@formula
def is_settled(
    quickest: float, step: float, s: float, v: float, derivatives: tuple[float, float, float]
) -> bool:
    """Tell whether the series can make the last step to a root without loss.

    ``derivatives`` are the second and the fifth, and a bound of the sixth.
    """
    second, fifth, sixth = derivatives
    size = abs(step)
    square = step * step
    missed = (sixth * size + abs(fifth)) * square * square * size
    return size <= 2.0 * ULP * s or (
        size * quickest <= SMALL_PHASE
        and size * abs(second) <= SMALL_PHASE * abs(v)
        and sixth * square * square * size <= 32.0 * ULP * abs(v)
        and missed <= 32.0 * ULP * abs(v) * s
    )


@formula
def series_root(value: float, first: float, second: float, third: float, fourth: float) -> float:
    """Return the root next to 0 of the quartic with these derivatives at 0, to fourth order.

    Far from the root the series may give any step, by chance even none: where it is not between
    half and twice Newton's step, that is returned.
    """
    if first == 0.0:
        return 0.0 if value == 0.0 else math.inf
    over = 1.0 / first
    q = -value * over
    c2 = 0.5 * second * over
    c3 = third * over * (1.0 / 6.0)
    c4 = fourth * over * (1.0 / 24.0)
    # The series of the inverse function.
    part = 1.0 - q * (c2 - q * (2.0 * c2 * c2 - c3 - q * (5.0 * c2 * (c2 * c2 - c3) + c4)))
    return q * part if 0.5 < part < 2.0 else q


@kernel
def turn_by(law: Law, phases: Table, step: float) -> None:
    """Advance ``phases`` by a step of a small phase."""
    for j in range(phases.shape[0]):
        angle = law[FIRST_HARMONIC + j, OMEGA] * step
        square = angle * angle
        less = square * (0.5 - square / 24.0)
        sine_of_angle = angle * (1.0 - square * (1.0 - square / 20.0) / 6.0)
        cosine = phases[j, 0]
        sine = phases[j, 1]
        phases[j, 0] = cosine - sine_of_angle * sine - less * cosine
        phases[j, 1] = sine + sine_of_angle * cosine - less * sine


@kernel
def lowest(
    law: Law,
    region: int,
    start: Start,
    phases: Table,
    arrival: Table,
    sign: float,
    distance: float,
    left: float,
    right: float,
) -> tuple[float, float, float]:
    """Return (s, clearance, rounding bound) at the one turning point of a convex stretch."""
    force = start[3]
    s = 0.5 * (left + right)
    clearance = 0.0
    for _ in range(MAX_ITERATIONS):
        y, v = move(law, region, start, phases, s, arrival)
        clearance = sign * (y - distance)
        speed = sign * v
        if speed < 0.0:
            left = s
        else:
            right = s
        second, _ = acceleration_and_jerk(law, region, force, arrival, y, v)
        step = -v / second if second != 0.0 else 0.0
        if abs(step) <= 2.0 * ULP * s:
            break
        s += step
        if not left < s < right:
            s = 0.5 * (left + right)
            if not left < s < right:
                break
    error = uncertainty(law, region, start, phases, s) + ULP * abs(distance)
    return s, clearance, error
