"""An overdamped flight by its parts: a fast decay, a slow one, and the answer to each harmonic.

Far above critical damping the fast root r2 is many orders of size above all other rates, and soon
nothing is left of its part: then a flight needs steps of its slow parts only. Its derivatives are
sums over the parts. From x and v they would lose all their digits: the equation of motion gives
x'' as what is left of forces that balance but for the inertia.
"""

from __future__ import annotations

import math

from percuss.kernels.arithmetic import Pair, exponential
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import Flight, are_apart, parts_of
from percuss.kernels.law_columns import (
    AMPLITUDE,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    N_HARMONICS,
    OMEGA,
    OVERDAMPED,
    RATE,
    SLOW_ROOT,
    STEP,
    Law,
)
from percuss.kernels.pieces import is_record

# The phase of the fast decay after which it is nothing: exp(-200) is 1e-87, so that its fifth
# derivative too is below rounding where it is 1e12 times as fast as the rest.
FADED = 200.0
# A search over so much of it still knows its end to 1e-7 of what is there: exp(-20) is 2e-9.
STAGE = 20.0
# Before the fast part has turned by this phase the parts of a start from rest cancel.
SET_IN = 1.0


@kernel
def fast_time(law: Law, region: int) -> float:
    """Return in which time the fast decay of a region falls to 1 / e; infinite without one."""
    slow, fast = law[region, SLOW_ROOT], law[region, FAST_ROOT]
    if law[region, OVERDAMPED] == 0.0 or not fast < 0.0 or not are_apart(slow, fast):
        return math.inf
    return -1.0 / fast


@kernel
def slow_step(law: Law, region: int) -> float:
    """Return in which time the slow motion turns by a radian; infinite where it rests."""
    rate = abs(law[region, SLOW_ROOT])
    for j in range(int(law[0, N_HARMONICS])):
        if law[FIRST_HARMONIC + j, AMPLITUDE] > 0.0:
            rate = max(rate, law[FIRST_HARMONIC + j, OMEGA])
    return 1.0 / rate if rate > 0.0 else math.inf


@kernel
def time_to_fade(law: Law, region: int) -> float:
    """Return the time after which nothing is left of a region's fast decay; infinite without one."""
    return FADED * fast_time(law, region)


@kernel
def pace_at(law: Law, region: int, s: float) -> float:
    """Return in which time a flight turns by a radian, a time s after its start.

    It is the step of the search for events (`next_event`), 0 at constant acceleration, and that of
    the slow motion where the fast decay is over.
    """
    return slow_step(law, region) if s >= time_to_fade(law, region) else law[region, STEP]


@formula
def pace_until(law: Law, region: int, s: float, end: float) -> float:
    """Return up to which time, ``end`` at most, a flight keeps the pace that it has at s < end."""
    fades = time_to_fade(law, region)
    return fades if s < fades < end else end


@kernel
def stage_until(law: Law, region: int, s: float, end: float) -> float:
    """Return up to which time, ``end`` at most, what is left of a fast decay has one size."""
    time = fast_time(law, region)
    stage = STAGE * time
    k = 1.0
    while k * STAGE <= FADED and k * stage <= s:
        k += 1.0
    return min(k * stage, end) if k * STAGE <= FADED else end


@kernel
def is_known_by_parts(flight: Flight, s: float, phase: float) -> bool:
    """Return whether the parts of a flight are known at s, ``phase`` of its fast decay being over.

    Under a record they are not.
    """
    law, region, n = flight.law, flight.region, flight.phases.shape[0]
    return s >= phase * fast_time(law, region) and (n == 0 or not is_record(law, n - 1))


@kernel
def slow_speed(flight: Flight) -> float:
    """Return the velocity that the slow root has at the start of a flight.

    With its slow root r1 and its fast one r2, a free velocity v whose derivative is w has the slow
    part (w - r2 v) / (r1 - r2). Of each force F exp(i w s) that leaves F r1 / (r1 - i w).
    """
    law, region, start, phases, _ = flight
    slow = law[region, SLOW_ROOT]
    pull = start[3] + slow * start[2]
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        omega = law[harmonic, OMEGA]
        in_phase, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        pull += slow * (slow * in_phase + omega * quadrature) / (slow * slow + omega * omega)
    return pull / (2.0 * law[region, RATE])


@kernel
def derivatives_by_parts(flight: Flight, s: float) -> tuple[float, float, float, float, float]:
    """Return the first to the fifth derivative of a flight a time s after its start.

    ``arrival`` holds the phases there.
    """
    law, region, start, phases, arrival = flight
    begins = slow_speed(flight)
    slow = law[region, SLOW_ROOT]
    fast = law[region, FAST_ROOT]
    first = begins * exponential(slow * s)
    second = slow * first
    third = slow * second
    fourth = slow * third
    fifth = slow * fourth
    left = start[2] - begins
    for j in range(arrival.shape[0]):
        v, _ = steady_speed(law, region, j, (phases[j, 0], phases[j, 1]))
        left -= v
        v, turned = steady_speed(law, region, j, (arrival[j, 0], arrival[j, 1]))
        omega = law[FIRST_HARMONIC + j, OMEGA]
        square = omega * omega
        first += v
        second += omega * turned
        third -= square * v
        fourth -= square * omega * turned
        fifth += square * square * v
    left *= exponential(fast * s)
    square = fast * fast
    return (
        first + left,
        second + fast * left,
        third + square * left,
        fourth + square * fast * left,
        fifth + square * square * left,
    )


@kernel
def steady_speed(law: Law, region: int, j: int, phase: Pair) -> Pair:
    """Return the velocity of the steady motion of a harmonic, and that a quarter turn later.

    ``phase`` is the cosine and the sine of its phase.
    """
    harmonic = FIRST_HARMONIC + j
    real = law[region + 1 + j, GAIN_RE]
    imaginary = law[region + 1 + j, GAIN_IM]
    in_phase, quadrature = parts_of(law, harmonic, phase[0], phase[1])
    omega = law[harmonic, OMEGA]
    # The displacement is the phasor in_phase - i quadrature, times the gain.
    return (
        omega * (quadrature * real - in_phase * imaginary),
        -omega * (in_phase * real + quadrature * imaginary),
    )


@kernel
def slow_bound(flight: Flight) -> float:
    """Return a bound on abs(x'''') of a flight whose fast decay is over, and that does not grow."""
    law, region = flight.law, flight.region
    bound = abs(slow_speed(flight) * law[region, SLOW_ROOT] ** 3)
    for j in range(flight.phases.shape[0]):
        gain = abs(law[region + 1 + j, GAIN_RE]) + abs(law[region + 1 + j, GAIN_IM])
        bound += gain * law[FIRST_HARMONIC + j, AMPLITUDE] * law[FIRST_HARMONIC + j, OMEGA] ** 4
    return bound
