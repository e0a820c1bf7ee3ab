"""Harmonic flights in a row: one harmonic, one wall, from the wall and back to it.

A *harmonic flight* is an underdamped flight under one harmonic that begins and ends at the only
wall. This is `next_event`, `event_location` and `march` for the commonest case, written as one loop
whose numbers stay in registers: 2.5 times as fast. Everything else is left to them with the state
untouched: a flight near a graze, a short or a long one, a slow impact.

A search need not wait for the cosine and sine of the instant at which its flight begins: it goes by
the force that the landing before has turned along, right to 12 roundings. Those of the instant
enter the result alone. Both depend on the motion alone, however it is left and taken up again,
because the state carries that force (docs/decisions/004-harmonic-flights.md).

The arithmetic is in functions of numbers alone, free of branches; `lockstep` applies the same
functions to many motions at once, as vectors: the same operations in the same order, hence the
same bits. A flight is mirrored so that the motion is at y > 0.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.arrays import Floats
from percuss.kernels.arithmetic import (
    Pair,
    cos_sin,
    cubic_minimum,
    decay,
    later,
    quintic_root,
)
from percuss.kernels.compile import cold, formula, kernel
from percuss.kernels.contact import SLOW
from percuss.kernels.event_location import is_settled, series_root
from percuss.kernels.flight import SERIES_LIMIT
from percuss.kernels.law_columns import (
    AMPLITUDE,
    BOUND_OF_V,
    BOUND_OF_X,
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    FORCE_BOUND,
    GAIN_IM,
    GAIN_RE,
    HALF_TURNS,
    HALF_TURNS_LOW,
    LOWER_FORCE,
    LOWER_KIND,
    LOWER_RESTITUTION,
    OMEGA,
    PER_STIFFNESS,
    QUICKEST,
    SINE,
    STEP,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    TWICE_PER_RATE,
    UPPER_FORCE,
    UPPER_RESTITUTION,
    WALL,
    Law,
)
from percuss.kernels.next_event import STEPS_A_WALK, THIRD, WALK_SLACK
from percuss.kernels.record import (
    CARRIED_PUSH,
    CARRIED_RATE,
    CARRIED_T,
    CARRIED_T_LOW,
    EVENT_T,
    EVENT_T_LOW,
    FASTEST,
    HUGE,
    T_LOW,
    V_AFTER,
    V_BEFORE,
    T,
    V,
)
from percuss.kernels.step import Walk, walk_of

# Least speed of a harmonic landing times a step, as a part of the slack of the walk: 2e-6 of the
# size of the motion, above what rounding makes of a speed (docs/theory/first-event.md, section 7).
SLOWEST = 2e5
# A flight's beginning: the constant force, the harmonic one
# and its derivative by the frequency, and the velocity.
Begin: TypeAlias = tuple[float, float, float, float]
# On the walk: y, v, the harmonic force and its derivative by the frequency.
Place: TypeAlias = tuple[float, float, float, float]
# A landing: s, v, what is to be added to s, and the force and its derivative there, turned along.
HarmonicLanding: TypeAlias = tuple[float, float, float, float, float]
# What is needed of a law for the closed form and for bounds, in the order of `motion_of` and
# `bounds_of`; for a step of the walk see `step.walk_of`.
FreeMotion: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float
]
Bounds: TypeAlias = tuple[float, float, float, float, float, float, float, float]
# Iterations of a landing: most settle at the second, slow ones need more.
MOST_ITERATIONS = 6


@kernel
def motion_of(law: Law, region: int) -> FreeMotion:
    """Return what the closed form needs."""
    return (
        law[region, STIFFNESS],
        law[region, DAMPING],
        law[FIRST_HARMONIC, OMEGA],
        law[region + 1, GAIN_RE],
        law[region + 1, GAIN_IM],
        law[region, TWICE_PER_RATE],
        law[region, PER_STIFFNESS],
        law[region, HALF_TURNS],
        law[region, HALF_TURNS_LOW],
        law[FIRST_HARMONIC, TURNS],
        law[FIRST_HARMONIC, TURNS_LOW],
    )


@kernel
def bounds_of(law: Law, region: int) -> Bounds:
    """Return the step and what bounds are made of."""
    quickest = law[region, QUICKEST]
    fastest = max(quickest, law[FIRST_HARMONIC, OMEGA])
    # What a constant force does cancels as well where there is damping.
    damped = law[region, DAMPING] > 0.0
    return (
        law[region, STEP],
        fastest,
        quickest if damped else fastest,
        law[FIRST_HARMONIC, AMPLITUDE],
        law[0, FORCE_BOUND],
        law[0, FORCE_BOUND + 4],
        law[region, BOUND_OF_X],
        law[region, BOUND_OF_V],
    )


@formula
def pushes(pull: tuple[float, float], phase: tuple[float, float]) -> tuple[float, float]:
    """Return the harmonic force and its derivative by the frequency, from (A, B) and (cos, sin)."""
    return pull[0] * phase[0] + pull[1] * phase[1], pull[1] * phase[0] - pull[0] * phase[1]


@formula
def margins(motion: FreeMotion, bounds: Bounds, begin: Begin) -> tuple[float, float, float]:
    """Return bounds of the fourth derivative, of a step's departure from its cubic, of rounding.

    They hold for the whole flight. Its free part, of the amplitude that it starts with or less,
    has the rate sqrt(K), the steady part that of the harmonic.
    """
    force, push, rate, v0 = begin
    stiffness, damping, omega, gain_re, gain_im, twice_per_rate, per_stiffness, _, _, _, _ = motion
    step, fastest, _, amplitude, force_bound, _, _, _ = bounds
    z = -force * per_stiffness - (push * gain_re + rate * gain_im)
    w = v0 + omega * (push * gain_im - rate * gain_re)
    turned = (w + damping * z) * 0.5 * twice_per_rate
    free = math.sqrt(z * z + turned * turned)
    swing = amplitude * (abs(gain_re) + abs(gain_im))
    square = omega * omega
    fourth = stiffness * stiffness * free + square * square * swing
    size = (free + swing) * (2.0 + 2.0 * step * fastest)
    size += 2.0 * abs(force) * per_stiffness
    slack = WALK_SLACK * (size + step * step * (abs(force) + force_bound))
    return fourth, fourth * step**4 * (1.0 / 384.0), slack


@formula
def harmonic_step(walk: Walk, force: float, before: Place) -> Place:
    """Return the place one step later."""
    y, v, push, rate = before
    x_of_force, v_of_force, x_of_cos, x_of_sin, v_of_cos, v_of_sin = walk[:6]
    step_cos, step_sin, x_of_x, x_of_v, v_of_x, v_of_v = walk[6:]
    # The state's own terms come last: a step then waits for little of the step before.
    y1 = x_of_force * force + x_of_cos * push + x_of_sin * rate
    v1 = v_of_force * force + v_of_cos * push + v_of_sin * rate
    push1 = push * step_cos + rate * step_sin
    rate1 = rate * step_cos - push * step_sin
    y1 += x_of_x * y + x_of_v * v
    v1 += v_of_x * y + v_of_v * v
    return y1, v1, push1, rate1


@formula
def clearance(
    step: float, is_first_step: bool, before: Place, after: Place, bow: float, slack: float
) -> float:
    """Return a lower bound of y during a step.

    On the first step what stands for the clearance at its start is that after division by the
    time (see `next_event.clearances`), without an allowance for rounding.
    """
    third = THIRD * step
    rise = third * before[1]
    least = rise - (384.0 / 72.0) * bow + slack if is_first_step else before[0] - bow
    inner = min(before[0] + rise, after[0] - third * after[1])
    return min(least, after[0] - bow, inner - bow)


@formula
def is_end(is_first_step: bool, before: Place, after: Place, slack: float) -> bool:
    """Return whether a step begins beyond doubt inside and ends beyond doubt in the wall."""
    return after[0] < -slack and (is_first_step or before[0] > slack)


@formula
def harmonic_guess(
    motion: FreeMotion, step: float, force: float, before: Place, after: Place
) -> float:
    """Return the part of a step after which the mass meets the wall, approximately."""
    y, v, push, _ = before
    y1, v1, push1, _ = after
    drag = 2.0 * motion[1]
    second = force + push - drag * v - motion[0] * y
    second1 = force + push1 - drag * v1 - motion[0] * y1
    return quintic_root((y, step * v, step * step * second), (y1, step * v1, step * step * second1))


@formula
def harmonic_iteration(
    motion: FreeMotion, bounds: Bounds, begin: Begin, s: float
) -> tuple[bool, float, float, float, float, float]:
    """Return whether an iteration at s settles the landing, and the landing, or the next s.

    The next s is NaN, which never settles, where s is short.
    """
    stiffness, damping, omega, _, _, _, _, _, _, _, _ = motion
    _, fastest, pace, _, _, force_bound, bound_of_x, bound_of_v = bounds
    y, kept, won, push, rate = harmonic_state(motion, begin, s)
    drag = 2.0 * damping
    v = kept + won
    second = begin[0] + push - drag * v - stiffness * y
    third = omega * rate - drag * second - stiffness * v
    fourth = -omega * omega * push - drag * third - stiffness * second
    fifth = -omega * omega * omega * rate - drag * fourth - stiffness * third
    step = series_root(y, v, second, third, fourth)
    sixth = force_bound + bound_of_x * abs(fourth)
    sixth += bound_of_v * abs(fifth)
    settled = is_settled(fastest, step, s, v, (second, third, fourth, fifth, sixth))
    square = step * step
    gained = step * (second + step * (0.5 * third))
    gained += square * step * (fourth * (1.0 / 6.0) + step * fifth * (1.0 / 24.0))
    # Added last: a rounding of the large part would stay in the velocity.
    end = s + step
    far = pace * s > SERIES_LIMIT
    speed = kept + (won + gained)
    # By a phase of SMALL_PHASE at most: its fourth power is a rounding.
    turn = omega * step
    less = 0.5 * turn * turn
    turn -= turn * less * THIRD
    push1 = push + turn * rate - less * push
    rate1 = rate - turn * push - less * rate
    return settled and far, end if far else math.nan, speed, step - (end - s), push1, rate1


@formula
def harmonic_state(
    motion: FreeMotion, begin: Begin, s: float
) -> tuple[float, float, float, float, float]:
    """Return y, v in two parts, the harmonic force, and its derivative by the frequency, at s.

    The closed form of `move` for one harmonic, where no series is needed. The first part of v is
    what is left of the velocity at the start, mostly by far the larger.
    """
    force, push0, rate0, v0 = begin
    _, damping, omega, gain_re, gain_im, twice_per_rate, per_stiffness = motion[:7]
    half_turns, half_turns_low, turns, turns_low = motion[7:]
    half_cos, half_sin = cos_sin(half_turns, half_turns_low, s, 0.0)
    cosine, sine = cos_sin(turns, turns_low, s, 0.0)
    shrink = 1.0
    lost = 0.0
    if damping > 0.0:
        shrink, lost = decay(-damping * s)
    square = 2.0 * half_sin * half_sin
    impulse = shrink * half_sin * half_cos * twice_per_rate
    even = shrink * (1.0 - square)
    rise = (shrink * square - lost - damping * impulse) * per_stiffness
    over_re = cosine - even - damping * impulse
    over_im = sine - omega * impulse
    # The steady motion at the start, and its derivative by the phase.
    steady = push0 * gain_re + rate0 * gain_im
    slope = rate0 * gain_re - push0 * gain_im
    y = v0 * impulse + (force * rise + (over_re * steady + over_im * slope))
    won = (force + push0 - v0 * damping) * impulse
    won += over_re * (omega * slope) - over_im * (omega * steady)
    kept = v0 * even
    if half_cos * half_cos < 0.25:
        # Near half a period: -v0, unrounded, and the little that is missing to it.
        kept = -v0 * shrink
        won -= 2.0 * kept * half_cos * half_cos
    return y, kept, won, push0 * cosine + rate0 * sine, rate0 * cosine - push0 * sine


@formula
def is_first(
    before: Place,
    s: float,
    landed: HarmonicLanding,
    step: float,
    fourth: float,
    slack: float,
) -> bool:
    """Return whether a landing on the step that begins at s is clearly the first.

    The criterion is that of `event_of_step`; a speed that may be rounding leaves it open
    (`rest_at_landing`).
    """
    end, speed, _, _, _ = landed
    width = end - s
    third = THIRD * width
    least = fourth * width**4 * (1.0 / 287.0) + (slack if s > 0.0 else 0.0)
    fast = -speed * step > SLOWEST * slack
    return (
        fast
        and before[0] + third * before[1] > least
        and -third * speed > least
        and end <= s + step
    )


@formula
def harmonic_impact(
    instant: tuple[float, float],
    landed: HarmonicLanding,
    restitution: float,
    fastest: float,
    t_end: float,
) -> tuple[float, float, float, bool]:
    """Return (t, t_low, speed) after the impact that ends a flight, and whether it is regular."""
    t, t_low = later(instant[0], instant[1], landed[0])
    t, t_low = later(t, t_low, landed[2])
    speed = restitution * abs(landed[1])
    # Each comparison is also false for the NaN of a flight that is not harmonic.
    return t, t_low, speed, t < t_end and speed > SLOW * fastest and speed < HUGE


@formula
def carried_force(motion: FreeMotion, pull: Pair, state: Floats) -> Pair:
    """Return the harmonic force and its derivative at a state, as the last flight has left them.

    Where none has they are computed afresh.
    """
    if state[CARRIED_T] == state[T] and state[CARRIED_T_LOW] == state[T_LOW]:
        return state[CARRIED_PUSH], state[CARRIED_RATE]
    return pushes(pull, cos_sin(motion[9], motion[10], state[T], state[T_LOW]))


@formula
def carry_force(turned: Pair, state: Floats) -> None:
    """Keep the harmonic force and its derivative of the last landing in a state."""
    state[CARRIED_T] = state[T]
    state[CARRIED_T_LOW] = state[T_LOW]
    state[CARRIED_PUSH] = turned[0]
    state[CARRIED_RATE] = turned[1]


@kernel
def harmonic_flights(
    law: Law,
    region: int,
    state: Floats,
    t_end: float,
    phases: Floats,
    events: Floats,
    first: int,
    last: int,
) -> int:
    """Fly from impact to impact while flights are harmonic; return their number.

    The state's instant, velocity and fastest speed follow. Rows ``first`` to ``last`` of the
    events' table receive the impacts.
    """
    t, t_low, v0, fastest = state[T], state[T_LOW], state[V], state[FASTEST]
    sign = 1.0 if law[region, LOWER_KIND] == WALL else -1.0
    restitution = law[region, LOWER_RESTITUTION if sign > 0.0 else UPPER_RESTITUTION]
    force = sign * law[region, LOWER_FORCE if sign > 0.0 else UPPER_FORCE]
    pull = (sign * law[FIRST_HARMONIC, COSINE], sign * law[FIRST_HARMONIC, SINE])
    push, rate = pushes(pull, (phases[0, 0], phases[0, 1]))
    v0 *= sign
    carried = carried_force(motion_of(law, region), pull, state)
    made = 0
    for row in range(first, last):
        landed = harmonic_flight(law, region, (force, push, rate, v0), carried)
        t1, t1_low, speed, fine = harmonic_impact((t, t_low), landed, restitution, fastest, t_end)
        if not fine:
            break
        made += 1
        t = t1
        t_low = t1_low
        v0 = speed
        fastest = max(fastest, abs(landed[1]))
        carried = (landed[3], landed[4])
        phase = cos_sin(law[FIRST_HARMONIC, TURNS], law[FIRST_HARMONIC, TURNS_LOW], t, t_low)
        push, rate = pushes(pull, phase)
        events[row, EVENT_T] = t
        events[row, EVENT_T_LOW] = t_low
        events[row, V_BEFORE] = sign * landed[1]
        events[row, V_AFTER] = sign * v0
    state[T] = t
    state[T_LOW] = t_low
    state[V] = sign * v0
    state[FASTEST] = fastest
    carry_force(carried, state)
    return made


@formula
def harmonic_flight(law: Law, region: int, begin: Begin, carried: Pair) -> HarmonicLanding:
    """Return the return to the wall, NaN where this search leaves it open.

    The search goes by ``carried``, the force and its derivative as the flight before has left
    them: it need not wait for those of ``begin``, which are computed afresh.
    """
    motion = motion_of(law, region)
    bounds = bounds_of(law, region)
    step = bounds[0]
    force, v0 = begin[0], begin[3]
    fourth, bow, slack = margins(motion, bounds, (force, carried[0], carried[1], v0))
    at_wall = (0.0, v0, carried[0], carried[1])
    walk = walk_of(law, region)
    i, before, after = harmonic_walk(walk, step, force, (bow, slack), 0, at_wall)
    if i >= 0:
        guess = step * i + step * harmonic_guess(motion, step, force, before, after)
        settled, s, v, s_low, push, rate = harmonic_iteration(motion, bounds, begin, guess)
        landed = (s, v, s_low, push, rate)
        if not settled:
            landed = harmonic_landing(motion, bounds, begin, s, MOST_ITERATIONS - 1)
        if is_first(before, step * i, landed, step, fourth, slack):
            return landed
    return math.nan, math.nan, math.nan, math.nan, math.nan


@formula
def harmonic_walk(
    walk: Walk, step: float, force: float, margin: Pair, i: int, before: Place
) -> tuple[int, Place, Place]:
    """Walk on from step i to the one that ends in the wall; return which, and both its ends.

    It is -1 where the walk does not decide: a step may hold several roots, or there are too many
    steps. ``margin`` is the departure of a step from its cubic, and an allowance for rounding.
    """
    bow, slack = margin
    for k in range(i, STEPS_A_WALK):
        after = harmonic_step(walk, force, before)
        if not clearance(step, k == 0, before, after, bow, slack) > slack:
            if is_end(k == 0, before, after, slack):
                return k, before, after
            if k == 0 or not is_clear_yet(step, before, after, bow, slack):
                break
        before = after
    return -1, before, before


@kernel
def is_clear_yet(step: float, before: Place, after: Place, bow: float, slack: float) -> bool:
    """Return whether the minimum of its cubic clears a step that the coefficients do not."""
    y, v, _, _ = before
    y1, v1, _, _ = after
    return min(y, y1) > slack and cubic_minimum(y, step * v, y1, step * v1) > bow + slack


@cold
def harmonic_landing(
    motion: FreeMotion, bounds: Bounds, begin: Begin, guess: float, iterations: int
) -> HarmonicLanding:
    """Return the landing next to ``guess``, NaN where it is not settled."""
    s = guess
    for _ in range(iterations):
        if not s > 0.0:
            break
        settled, s, v, s_low, push, rate = harmonic_iteration(motion, bounds, begin, s)
        if settled:
            return s, v, s_low, push, rate
    return math.nan, math.nan, math.nan, math.nan, math.nan
