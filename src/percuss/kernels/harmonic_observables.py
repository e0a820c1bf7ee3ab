"""What is observed of harmonic flights: places, the highest point, and where a neighbour goes.

One motion and many in lockstep share these formulas, free of branches, so that both see the same
bits; they go by the instants of a flight alone (`lockstep_observables`). A flight is mirrored so
that the motion is at y > 0.
"""

from __future__ import annotations

import math

from percuss.kernels.arithmetic import ULP, Pair, cos_sin, decay, logarithm
from percuss.kernels.compile import formula, kernel
from percuss.kernels.event_location import series_root
from percuss.kernels.flight import SERIES_LIMIT, Flight, FlightStart, move
from percuss.kernels.harmonic_flight import (
    Begin,
    Bounds,
    FreeMotion,
    Place,
    bounds_of,
    harmonic_state,
    harmonic_step,
    margins,
    motion_of,
    pushes,
)
from percuss.kernels.law_columns import (
    COSINE,
    FIRST_HARMONIC,
    HARMONIC,
    LOWER,
    LOWER_KIND,
    LOWER_RESTITUTION,
    SINE,
    UPPER,
    UPPER_RESTITUTION,
    WALL,
    Law,
)
from percuss.kernels.next_event import STEPS_A_WALK, THIRD
from percuss.kernels.step import Walk, walk_of
from percuss.kernels.tangent import Matrix

# What the second derivative and the first depart from those of a step's cubic, as displacements
# and in terms of the departure of y itself (docs/theory/first-event.md, "The highest point").
BEND, SLOPE = 16.0 / 3.0, 1.1
# A flight that is in its wall at this part of the least time of a harmonic one, by this part of its
# first velocity times the time, is none.
EARLY, EARLY_DEPTH = 0.9, 1e-3
# Newton's steps to a turning point, from a chord.
GUESSES = 2
# Size between which a neighbour's distance is left as it is.
NEAREST, FARTHEST = 1e-100, 1e100


@formula
def begin_of(flight: Flight, sign: float) -> Begin:
    """Return how a flight under one harmonic begins, mirrored where ``sign`` is -1."""
    law, _, start, phases, _ = flight
    pull = (sign * law[FIRST_HARMONIC, COSINE], sign * law[FIRST_HARMONIC, SINE])
    push, rate = pushes(pull, (phases[0, 0], phases[0, 1]))
    return sign * start[3], push, rate, sign * start[2]


@formula
def harmonic_place(motion: FreeMotion, begin: Begin, s: float) -> Pair:
    """Return (y, v) a time s after the beginning."""
    y, kept, won, _, _ = harmonic_state(motion, begin, s)
    return y, kept + won


@formula
def place_in(flight: Flight, s: float) -> Pair:
    """Return (y, v) a time s after the beginning of a flight of any kind.

    ``flight.arrival`` may receive the phases there.
    """
    law, region = flight.law, flight.region
    if law[region, HARMONIC] == 1.0:
        return harmonic_place(motion_of(law, region), begin_of(flight, 1.0), s)
    return move(flight, s)


@formula
def is_far(bounds: Bounds, s: float) -> bool:
    """Return whether a time is long enough for the closed form without a series."""
    return bounds[2] * s > SERIES_LIMIT


@kernel
def is_over_early(flight: Flight, sign: float) -> bool:
    """Return whether a flight from the wall has met it before a harmonic landing may.

    By Taylor's theorem: as in `next_event.event_of_hop`.
    """
    motion, bounds = motion_of(flight.law, flight.region), bounds_of(flight.law, flight.region)
    force, push, rate, v0 = begin_of(flight, sign)
    omega = motion[2]
    second = force + push - 2.0 * motion[1] * v0
    third = omega * rate - 2.0 * motion[1] * second - motion[0] * v0
    until = EARLY * SERIES_LIMIT / bounds[2]
    bend = omega * omega * bounds[3]
    fourth = bend + bounds[6] * abs(second) + bounds[7] * (abs(third) + until * bend)
    fall = third * (1.0 / 6.0) + until * fourth * (1.0 / 24.0)
    return v0 + until * (0.5 * second + until * fall) < -EARLY_DEPTH * v0


@formula
def side_of_wall(law: Law, region: int, x: float) -> float:
    """Return 1 for a place at the only wall of a harmonic region if that is below, -1 if above.

    0 anywhere else.
    """
    if law[region, HARMONIC] != 1.0:
        return 0.0
    below = law[region, LOWER_KIND] == WALL
    if x != law[region, LOWER if below else UPPER]:
        return 0.0
    return 1.0 if below else -1.0


@formula
def fourth_of_step(
    motion: FreeMotion, bounds: Bounds, force: float, before: Place, fourth: float
) -> float:
    """Return a bound of the fourth derivative on a step, from where it begins.

    ``fourth`` is that of `margins` for the whole flight; where its parts cancel it is far too
    large.
    """
    y, v, push, rate = before
    step, omega = bounds[0], motion[2]
    drag = 2.0 * motion[1]
    second = force + push - drag * v - motion[0] * y
    third = omega * rate - drag * second - motion[0] * v
    bend = omega * omega * bounds[3]
    return min(fourth, bend + bounds[6] * abs(second) + bounds[7] * (abs(third) + step * bend))


@formula
def top_of_step(step: float, before: Place, after: Place, fourth: float, slack: float) -> float:
    """Return an upper bound of y on a step, -inf where y rises or falls all the way.

    ``fourth`` is a bound of the fourth derivative, ``slack`` an allowance for rounding.
    """
    third = THIRD * step
    square = step * step
    bow = fourth * (square * square) * (1.0 / 384.0)
    rise = third * before[1]
    rise2 = third * after[1]
    inner = before[0] + rise
    inner1 = after[0] - rise2
    rise1 = inner1 - inner
    bends = max(rise1 - rise, rise2 - rise1) < -(BEND * bow + 4.0 * slack)
    doubt = SLOPE * bow + slack
    rises = (min(rise, rise1, rise2) > doubt) | (bends & (rise2 > slack))
    falls = (max(rise, rise1, rise2) < -doubt) | (bends & (rise < -slack))
    top = max(before[0], after[0], inner, inner1) + (bow + slack)
    return -math.inf if rises | falls else top


@formula
def shape_of_piece(
    width: float, before: Pair, after: Pair, bound: float
) -> tuple[bool, bool, float, float]:
    """Return whether v may vanish on a piece, whether it goes one way, and bounds of y.

    ``before`` and ``after`` are (y, v) at its ends, ``bound`` one of the fourth derivative.
    """
    third = THIRD * width
    bow = bound * width**4 * (1.0 / 384.0)
    rise = third * before[1]
    rise2 = third * after[1]
    inner = before[0] + rise
    inner1 = after[0] - rise2
    rise1 = inner1 - inner
    slope = SLOPE * bow
    bend = BEND * bow
    turns = not (min(rise, rise1, rise2) > slope or max(rise, rise1, rise2) < -slope)
    more = max(rise1 - rise, rise2 - rise1)
    less = min(rise1 - rise, rise2 - rise1)
    bends = more < -bend or less > bend
    low = min(before[0], after[0], inner, inner1) - bow
    high = max(before[0], after[0], inner, inner1) + bow
    return turns, bends, low, high


@formula
def turning_guess(
    motion: FreeMotion, step: float, force: float, before: Place, after: Place
) -> float:
    """Return the part of a step after which v vanishes, by the cubic through v and x''."""
    y, v, push, _ = before
    y1, v1, push1, _ = after
    drag = 2.0 * motion[1]
    slope = step * (force + push - drag * v - motion[0] * y)
    slope1 = step * (force + push1 - drag * v1 - motion[0] * y1)
    fall = v1 - v
    square = 3.0 * fall - 2.0 * slope - slope1
    cube = slope + slope1 - 2.0 * fall
    part = min(max(-v / fall, 0.0), 1.0)
    for _ in range(GUESSES):
        value = v + part * (slope + part * (square + part * cube))
        rate = slope + part * (2.0 * square + part * 3.0 * cube)
        part = min(max(part - value / rate, 0.0), 1.0)
    return part


@formula
def summit(
    motion: FreeMotion, bounds: Bounds, begin: Begin, turning: tuple[float, float], fourth: float
) -> float:
    """Return y at a turning point, NaN where one series does not reach it, or it is not the highest.

    ``turning`` is when a step begins and the part of it after which the point is, approximately;
    ``fourth`` bounds the fourth derivative on the step. The series is Taylor's of y, so that only
    the square of what it leaves of v is lost.
    """
    stiffness, damping, omega = motion[:3]
    before = bounds[0] * turning[1]
    s = turning[0] + before
    y, kept, won, push, rate = harmonic_state(motion, begin, s)
    drag = 2.0 * damping
    v = kept + won
    second = begin[0] + push - drag * v - stiffness * y
    third = omega * rate - drag * second - stiffness * v
    own = -omega * omega * push - drag * third - stiffness * second
    fifth = -omega * omega * omega * rate - drag * own - stiffness * third
    sixth = bounds[5] + bounds[6] * abs(own) + bounds[7] * abs(fifth)
    step = series_root(v, second, third, own, fifth)
    size = abs(step)
    square = step * step
    left = v + step * (second + step * (0.5 * third))
    left += square * step * (own * (1.0 / 6.0) + step * fifth * (1.0 / 24.0))
    gained = step * (v + step * (0.5 * second + step * third * (1.0 / 6.0)))
    gained += square * square * (own * (1.0 / 24.0) + step * fifth * (1.0 / 120.0))
    top = y + gained
    bend = second + size * abs(third) + 0.5 * square * fourth
    reached = (left * left < -ULP * top * bend) & (
        sixth * square * square * square < 180.0 * ULP * top
    )
    # The motion falls off to both ends of the step.
    early = before + size
    late = bounds[0] - before + size
    falls = bend - THIRD * third * early + fourth * early * (THIRD * size + early * (1.0 / 12.0))
    falls1 = bend + THIRD * third * late + fourth * late * (THIRD * size + late * (1.0 / 12.0))
    proven = (falls < 0.0) & (falls1 < 0.0) & is_far(bounds, s)
    return top if proven & reached else math.nan


@formula
def crest(
    motion: FreeMotion,
    walk: Walk,
    bounds: Bounds,
    begin: Begin,
    highest: tuple[float, float, Place],
    fourth: float,
) -> float:
    """Return the greatest y of a flight, NaN where it is left open.

    ``highest`` is when the step with the greatest upper bound begins, the bound of any other, and
    the place there; ``fourth`` bounds the fourth derivative on the whole flight.
    """
    s, other, before = highest
    after = harmonic_step(walk, begin[0], before)
    part = turning_guess(motion, bounds[0], begin[0], before, after)
    own = fourth_of_step(motion, bounds, begin[0], before, fourth)
    top = summit(motion, bounds, begin, (s, part), own)
    return top if other <= top else math.nan


@formula
def harmonic_summit(
    motion: FreeMotion, walk: Walk, bounds: Bounds, begin: Begin, end: float
) -> float:
    """Return the greatest y of a flight from the wall and back to it, a time ``end`` later.

    NaN where it is left open.
    """
    step = bounds[0]
    force, push, rate, v0 = begin
    fourth, _, slack = margins(motion, bounds, begin)
    before = (0.0, v0, push, rate)
    greatest = -math.inf
    other = -math.inf
    s = 0.0
    highest = before
    for k in range(STEPS_A_WALK):
        if not step * k < end:
            break
        after = harmonic_step(walk, force, before)
        own = fourth_of_step(motion, bounds, force, before, fourth)
        top = top_of_step(step, before, after, own, slack)
        other = max(other, min(greatest, top))
        if top > greatest:
            greatest = top
            s = step * k
            highest = before
        before = after
    is_walked = not step * STEPS_A_WALK < end
    top = crest(motion, walk, bounds, begin, (s, other, highest), fourth)
    return top if is_walked and greatest > -math.inf else math.nan


@kernel
def flight_summit(flight: Flight, sign: float, end: float) -> float:
    """Return `harmonic_summit` of a flight from the wall and back to it."""
    law, region = flight.law, flight.region
    return harmonic_summit(
        motion_of(law, region),
        walk_of(law, region),
        bounds_of(law, region),
        begin_of(flight, sign),
        end,
    )


@formula
def harmonic_propagator(motion: FreeMotion, s: float) -> Matrix:
    """Return `tangent.propagator` of a flight, without branches."""
    half_cos, half_sin = cos_sin(motion[7], motion[8], s, 0.0)
    shrink = 1.0
    if motion[1] > 0.0:
        shrink, _ = decay(-motion[1] * s)
    square = 2.0 * half_sin * half_sin
    impulse = shrink * half_sin * half_cos * motion[5]
    even = shrink * (1.0 - square if square < 1.0 else 2.0 * half_cos * half_cos - 1.0)
    drag = motion[1] * impulse
    return even + drag, impulse, -motion[0] * impulse, even - drag


@formula
def carried_over_impact(
    motion: FreeMotion, s: float, impact: tuple[float, float, float], ahead: Pair
) -> Pair:
    """Return where a neighbour is after a flight of a time s and the impact that ends it.

    ``impact`` is the restitution, and force and velocity before it (`tangent.impact_saltation`).
    """
    restitution, force, v = impact
    x, rate = neighbour_in(motion, s, ahead)
    kick = (1.0 + restitution) * force / v
    return -restitution * x, kick * x - restitution * rate


@kernel
def carry_by_harmonic_flight(
    law: Law, start: FlightStart, region: int, end: Pair, v: float, ahead: Pair
) -> tuple[float, float, float]:
    """Return where a neighbour is after a flight from the only wall and its impact with v.

    The third number is what is added to the logarithm of an area's factor.
    """
    below = law[region, LOWER_KIND] == WALL
    restitution = law[region, LOWER_RESTITUTION if below else UPPER_RESTITUTION]
    motion = motion_of(law, region)
    s = (end[0] - start[0]) + (end[1] - start[1])
    pull = (law[FIRST_HARMONIC, COSINE], law[FIRST_HARMONIC, SINE])
    push, _ = pushes(pull, cos_sin(motion[9], motion[10], end[0], end[1]))
    x, rate = carried_over_impact(motion, s, (restitution, start[3] + push, v), ahead)
    return x, rate, lost_area(motion, s, 2.0 * logarithm(restitution))


@formula
def neighbour_in(motion: FreeMotion, s: float, ahead: Pair) -> Pair:
    """Return where a neighbour is a time s after the beginning of a flight."""
    matrix = harmonic_propagator(motion, s)
    return (
        matrix[0] * ahead[0] + matrix[1] * ahead[1],
        matrix[2] * ahead[0] + matrix[3] * ahead[1],
    )


@formula
def lost_area(motion: FreeMotion, s: float, of_impact: float) -> float:
    """Return the logarithm of the factor of an area, for a flight of a time s and its impact."""
    return of_impact - 2.0 * motion[1] * s


@formula
def is_within(ahead: Pair) -> bool:
    """Return whether a neighbour's distance is far from the limits of floats, or none is left."""
    size = abs(ahead[0]) + abs(ahead[1])
    return ((size > NEAREST) & (size < FARTHEST)) | (size == 0.0)


@formula
def is_carried(law: Law, region: int, s: float) -> bool:
    """Return whether `carried_over_impact` holds for a flight of a time s in a harmonic region."""
    bounds = bounds_of(law, region)
    return is_far(bounds, s) and s < STEPS_A_WALK * bounds[0]
