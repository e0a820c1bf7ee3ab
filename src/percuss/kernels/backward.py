"""A motion followed back in time, event by event.

A motion runs back in short stretches of the closed form, `flight.move` at negative times, for
which its power series have all digits. The first event of a stretch is found as in
`event_location`: by Taylor's theorem with a bound of the fourth derivative, which needs no damping
of the right sign. A stretch ends at a knot of a record, behind which the force is another one.
At a wall the velocity before an impact is that after it, divided by the restitution: without
restitution, and in a contact, the past is not determined (docs/theory/impact-surface.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import ULP, Pair, exponential, later
from percuss.kernels.compile import kernel
from percuss.kernels.event_location import (
    CLEAR,
    FLAT,
    ONE_MINIMUM,
    UNKNOWN,
    shape_of,
    within_bracket,
)
from percuss.kernels.flight import Flight, acceleration_and_jerk, constant_force, move, set_phases
from percuss.kernels.law_columns import (
    FIRST_HARMONIC,
    FORCE_BOUND,
    LOWER,
    LOWER_KIND,
    N_HARMONICS,
    N_KNOTS,
    NUMBER,
    OMEGA,
    QUICKEST,
    STIFFNESS,
    UPPER,
    UPPER_KIND,
    WALL,
    Law,
)
from percuss.kernels.pieces import begin_of_piece, record_before
from percuss.kernels.restitution import speed_before

# Columns of the state: instant, displacement from PLACE, velocity, PLACE, the events met, and
# the size of the flight so far.
T, T_LOW, Y, V, PLACE, EVENTS, SIZE = range(7)
STATE_ENTRIES = 7
# Columns of a hit: instant, velocity after it, and the events met later in time.
HIT_T, HIT_T_LOW, HIT_V, HIT_EVENTS = range(4)
HIT_COLUMNS = 4

# Why a motion ended: at its last hit, at its time, at an impact without restitution, at an instant
# from which no motion leads back (rest, or a velocity against the wall's normal), too fast, or
# after too many events.
AT_HITS, AT_TIME, NO_RESTITUTION, NO_PAST, TOO_FAST, TOO_MANY = range(6)

# The longest stretch, as a phase of the fastest motion or harmonic: that of the power series.
PART = 0.5
# Relative rounding of a stretch, of the sizes of its terms.
ROUNDING = 32.0 * ULP
# Relative rounding of a whole flight: a touch less deep does not count.
TOUCH = 64.0 * ULP
MOST_EVENTS = 100_000
HALVINGS = 60


class Past(NamedTuple):
    """A motion followed back in one region: its state, and the constant force at its PLACE.

    ``phases`` are those at the state's instant, ``arrival`` is scratch (n_harmonics, 2).
    """

    law: Law
    region: int
    state: Floats
    force: float
    phases: Floats
    arrival: Floats


@kernel
def bound_of_fourth(law: Law, region: int, second: float, third: float, width: float) -> float:
    """Return a bound on abs(x'''') over the ``width`` before an instant.

    u = x'' obeys u'' = f'' - 2 a u' - K u, and with q = QUICKEST, 2 a <= q and abs(K) <= q**2:
    E = abs(u') + q abs(u) grows by at most F + 2 q E, forwards and backwards in time.
    """
    quickest = law[region, QUICKEST]
    force = law[0, FORCE_BOUND + 2]
    energy = abs(third) + quickest * abs(second) + force * width
    return force + quickest * energy * exponential(2.0 * quickest * width)


@kernel
def time_to_leave(first: float, second: float, third: float, fourth: float, width: float) -> float:
    """Return how long a clearance that starts at 0 is surely positive, at most ``width``.

    ``first`` to ``third`` are its derivatives, of which the first that is not zero is positive;
    0 if it is negative.
    """
    third = abs(third) + fourth * width
    if first != 0.0:
        bend = abs(second) + width * third
        free = 1.8 * first / bend if bend > 0.0 else width
    else:
        free = 2.7 * second / third if third > 0.0 else width
        if second == 0.0:
            free = 0.0
    return max(0.0, min(free, width))


@kernel
def flight_back(past: Past) -> Flight:
    """Return the flight to be followed back; its force is that where it starts."""
    law, region, state, force, phases, arrival = past
    start = (state[T], state[T_LOW], state[V], force - law[region, STIFFNESS] * state[Y])
    return Flight(law, region, start, phases, arrival)


@kernel
def retreat(past: Past, s: float) -> None:
    """Take a state back by s."""
    law, state, phases = past.law, past.state, past.phases
    flight = flight_back(past)
    y, v = move(flight, -s)
    state[Y] += y
    state[V] = v
    state[T], state[T_LOW] = later(state[T], state[T_LOW], -s)
    set_phases_before(law, state[T], state[T_LOW], phases)


@kernel
def set_phases_before(law: Law, t: float, t_low: float, phases: Floats) -> None:
    """Set the phases at an instant; at a knot of a record those of the piece before it."""
    set_phases(law, t, t_low, phases)
    if law[0, N_KNOTS] > 0.0:
        last = phases.shape[0] - 1
        phases[last, 0], phases[last, 1] = record_before(law, t, t_low)


@kernel
def retreat_within_piece(past: Past, width: float, knot: Pair) -> None:
    """Take a state back by a width, or to a knot as far back."""
    law, state = past.law, past.state
    to_knot = (state[T] - knot[0]) + (state[T_LOW] - knot[1])
    retreat(past, width)
    if width == to_knot:
        state[T], state[T_LOW] = knot
        set_phases_before(law, state[T], state[T_LOW], past.phases)


@kernel
def root_before(
    past: Past,
    bound: Pair,
    right: float,
) -> float:
    """Return how long before a state the clearance was zero.

    It is positive at the state and has one zero within ``right``.
    """
    state = past.state
    sign, distance = bound
    flight = flight_back(past)
    left = 0.0
    s = 0.5 * right
    for _ in range(HALVINGS + 20):
        y, v = move(flight, -s)
        clearance = sign * ((state[Y] - distance) + y)
        if clearance > 0.0:
            left = s
        else:
            right = s
        step = sign * clearance / v if v != 0.0 else 2.0 * right
        if abs(step) <= ULP * s:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    return s


@kernel
def turn_before(
    past: Past,
    bound: Pair,
    right: float,
) -> tuple[float, float]:
    """Return how long ago the velocity was zero, and the clearance then.

    It has one zero within ``right``.
    """
    state = past.state
    sign, distance = bound
    flight = flight_back(past)
    left = 0.0
    clearance = 0.0
    for _ in range(HALVINGS):
        s = 0.5 * (left + right)
        y, v = move(flight, -s)
        clearance = sign * ((state[Y] - distance) + y)
        # Back in time the clearance falls while the velocity leads off the bound.
        if sign * v > 0.0:
            left = s
        else:
            right = s
        if not left < 0.5 * (left + right) < right:
            break
    return 0.5 * (left + right), clearance


@kernel
def zero_on(
    past: Past,
    bound: Pair,
    piece: tuple[float, float],
    shape: int,
) -> float:
    """Return how long before a state a bound was met, infinite if not on this piece.

    ``piece`` is its duration, and the depth up to which a touch does not count.
    """
    state = past.state
    sign, distance = bound
    if shape in (CLEAR, FLAT):
        return math.inf
    width, doubt = piece
    flight = flight_back(past)
    y, v = move(flight, -width)
    end = width
    clearance = sign * ((state[Y] - distance) + y)
    if clearance > 0.0 and shape == ONE_MINIMUM and sign * state[V] > 0.0 and sign * v < 0.0:
        end, clearance = turn_before(past, bound, width)
        clearance += doubt
    if clearance > 0.0:
        return math.inf
    return root_before(past, bound, end)


@kernel
def meet_before(
    past: Past,
    longest: float,
    fastest: float,
) -> float:
    """Take a state back to the last event before it, or by ``longest``; return the event's side.

    The side is -1 at the lower bound, +1 at the upper, 0 at the end of ``longest``, 2 for a mass
    that has always been at rest. A velocity against the normal of a bound is an event at once.
    """
    law, region, state, force, phases = past.law, past.region, past.state, past.force, past.phases
    low = law[region, LOWER] - state[PLACE]
    high = law[region, UPPER] - state[PLACE]
    part = longest_part(law, region, longest)
    width = part
    elapsed = 0.0
    knot = (-math.inf, 0.0)
    while elapsed < longest and abs(state[V]) < fastest:
        width = min(width, longest - elapsed)
        if law[0, N_KNOTS] > 0.0:
            _, _, t, t_low = begin_of_piece(law, state[T], state[T_LOW])
            knot = (t, t_low)
            width = min(width, (state[T] - t) + (state[T_LOW] - t_low))
        second, third = acceleration_and_jerk(law, region, force, phases, state[Y], state[V])
        fourth = bound_of_fourth(law, region, second, third, width)
        # Back in time the odd derivatives change their signs.
        ends = (state[Y] <= low, state[Y] >= high)
        if ends[0] or ends[1]:
            sign = 1.0 if ends[0] else -1.0
            first = -sign * state[V]
            width = time_to_leave(first, sign * second, third, fourth, width)
            if width == 0.0:
                return -sign if first < 0.0 else 2.0
        size = abs(state[Y]) + width * (abs(state[V]) + width * (abs(force) + law[0, FORCE_BOUND]))
        state[SIZE] = max(state[SIZE], size)
        bends = (second, third, fourth)
        below, above = shapes_on(state, (low, high), ends, bends, width, ROUNDING * size)
        if UNKNOWN in (below, above) and width > 8.0 * ULP * part:
            width *= 0.5
            continue
        piece = (width, TOUCH * state[SIZE])
        first = zero_on(past, (1.0, low), piece, below)
        last = zero_on(past, (-1.0, high), piece, above)
        s = min(first, last)
        if s < math.inf:
            retreat(past, s)
            state[Y] = low if first <= last else high
            return -1.0 if first <= last else 1.0
        retreat_within_piece(past, width, knot)
        elapsed += width
        width = min(2.0 * width, part)
    return 0.0


@kernel
def shapes_on(
    state: Floats,
    reach: tuple[float, float],
    ends: tuple[bool, bool],
    bends: tuple[float, float, float],
    width: float,
    doubt: float,
) -> tuple[int, int]:
    """Return the shapes of the clearances below and above over a width back in time.

    ``ends`` are whether each is at its bound already, ``bends`` are the second and third
    derivative and a bound of the fourth.
    """
    low, high = reach
    second, third, fourth = bends
    below = CLEAR
    if low > -math.inf and not ends[0]:
        below = shape_of(state[Y] - low, -state[V], second, -third, fourth, width, doubt)
    above = CLEAR
    if high < math.inf and not ends[1]:
        above = shape_of(high - state[Y], state[V], -second, third, fourth, width, doubt)
    return below, above


@kernel
def longest_part(law: Law, region: int, longest: float) -> float:
    """Return the length of the longest stretch."""
    fastest = law[region, QUICKEST]
    for j in range(int(law[0, N_HARMONICS])):
        fastest = max(fastest, law[FIRST_HARMONIC + j, OMEGA])
    return PART / fastest if fastest > 0.0 else longest


@kernel
def cross_back(law: Law, state: Floats, region: int, side: float) -> tuple[int, int]:
    """Take a state at a bound back over it; return the region before and a status, -1 if none."""
    kind = law[region, LOWER_KIND if side < 0.0 else UPPER_KIND]
    x = law[region, LOWER if side < 0.0 else UPPER]
    state[PLACE] = x
    state[Y] = 0.0
    state[SIZE] = 0.0
    if kind == WALL:
        bound = int(law[region, NUMBER]) + (1 if side > 0.0 else 0)
        speed = speed_before(law, region, bound, abs(state[V]))
        if speed == math.inf:
            return region, NO_RESTITUTION
        state[V] = -math.copysign(speed, state[V])
        return region, -1
    rows = 1 + int(law[0, N_HARMONICS])
    return region + (rows if side > 0.0 else -rows), -1


@kernel
def trace_back(
    law: Law,
    region: int,
    state: Floats,
    wanted: tuple[int, float],
    limits: Pair,
    hits: Floats,
    scratch: Floats,
) -> tuple[int, int, int]:
    """Follow a motion back until ``hits`` (n, HIT_COLUMNS) are full, or by the first of ``limits``.

    ``wanted`` is the number of a bound and a sign: a hit is an impact on that bound, or a crossing
    of it with a velocity of that sign. The motion also ends where it was faster than the second of
    ``limits``: back in time impacts accumulate between two walls, each slower than the one before
    it. Return why it ended, the number of hits and the region's row.
    """
    longest, fastest = limits
    phases = scratch[0]
    begin = state[T]
    begin_low = state[T_LOW]
    count = 0
    set_phases_before(law, state[T], state[T_LOW], phases)
    while state[EVENTS] < MOST_EVENTS:
        force = constant_force(law, region, state[PLACE])
        left = longest - ((begin - state[T]) + (begin_low - state[T_LOW]))
        past = Past(law, region, state, force, phases, scratch[1])
        side = meet_before(past, left, fastest)
        if not abs(state[V]) < fastest:
            return TOO_FAST, count, region
        if side == 0.0:
            return AT_TIME, count, region
        if side == 2.0:
            return NO_PAST, count, region
        bound = int(law[region, NUMBER]) + (1 if side > 0.0 else 0)
        wall = law[region, LOWER_KIND if side < 0.0 else UPPER_KIND] == WALL
        state[EVENTS] += 1.0
        if bound == wanted[0] and (wall or wanted[1] * state[V] > 0.0):
            hits[count, HIT_T] = state[T]
            hits[count, HIT_T_LOW] = state[T_LOW]
            hits[count, HIT_V] = state[V]
            hits[count, HIT_EVENTS] = state[EVENTS] - 1.0
            count += 1
            if count == hits.shape[0]:
                return AT_HITS, count, region
        region, status = cross_back(law, state, region, side)
        if status >= 0:
            return status, count, region
    return TOO_MANY, count, region


@kernel
def trace_batch(
    law: Law,
    regions: Integers,
    states: Floats,
    wanted: tuple[int, float],
    limits: Pair,
    hits: Floats,
    ends: Integers,
    scratch: Floats,
) -> None:
    """Follow each motion back as `trace_back` does.

    ``regions`` (n,) are their rows, ``states`` (n, STATE_ENTRIES), ``hits`` (n, m, HIT_COLUMNS);
    ``ends`` (n, 2) receives the reason and the number of hits; ``scratch`` is (2, n_harmonics, 2).
    """
    for i in range(regions.shape[0]):
        status, count, region = trace_back(
            law, regions[i], states[i], wanted, limits, hits[i], scratch
        )
        ends[i, 0] = status
        ends[i, 1] = count
        regions[i] = region
