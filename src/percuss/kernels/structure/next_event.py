"""When a guard of a flight first falls to zero, with proof.

The walk goes in steps of doubling lengths, each as long as its tests can tell something. Over a
step the guard lies within M h^4 / 384 of the cubic through its ends, with M the bound of its fourth
derivative from the norms of the modes; so a quick mode of small amplitude does not shorten the
step. A step that is not clear is halved, down to the shortest, and there `first_root` decides as it
does for one mass (docs/theory/structures.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import ULP, Pair, cubic_minimum, quintic_root
from percuss.kernels.compile import formula, kernel
from percuss.kernels.event_location import (
    CLEAR,
    GRAZE,
    HIT,
    MAX_ITERATIONS,
    MOST_PIECES,
    NONE,
    ONE_MINIMUM,
    UNKNOWN,
    Root,
    has_small_terms,
    series_root,
    shape_of,
    within_bracket,
)
from percuss.kernels.next_event import PAUSE, STEPS_A_WALK, THIRD, WALK_SLACK
from percuss.kernels.structure.basis import (
    DRAG,
    DRIVE_ENTRIES,
    FORCE_COS,
    FORCE_SIN,
    GROWTH,
    HAS_RATES,
    IS_ON,
    N_LEVELS,
    QUICKEST,
    RATE_COS,
    RATE_SIN,
    SPRING,
    STEP_D,
    STEP_E,
    STEP_ENTRIES,
    STEP_HARMONIC,
    STEP_LENGTH,
    STEP_S,
    U_OF_U,
    W_OF_U,
    W_OF_W,
    WALK_ROWS,
    Basis,
)
from percuss.kernels.structure.flight import (
    BEND,
    DRIFT,
    DRIFT_SLOPE,
    MANY,
    PULL,
    RATE_SIZE,
    SECOND,
    SEEN_COLUMNS,
    SIZE,
    SLOPE,
    SPEED,
    VALUE,
    ModalFlight,
    U,
    W,
    arrive_in_rows,
    derivatives,
    derivatives_here,
    fourth_bound,
    move,
    see,
    shift,
    uncertainty,
)

# Rounding of one step, as a part of that of a walk.
OF_ONE_STEP = 0.01
# Walks between two checks for Ctrl-C.
WALKS_AT_ONCE = 4096


class GuardEvent(NamedTuple):
    """The next event of a flight: as `Root`, with the number of the guard that falls to zero."""

    verdict: np.int64
    s: float
    guard: int
    value: float
    rest: float


@formula
def no_event(s: float) -> GuardEvent:
    """Return that there is none up to s."""
    return GuardEvent(NONE, s, -1, 0.0, 0.0)


@formula
def step_on(
    flight: ModalFlight,
    level: int,
    s: float,
    modes: Floats,
    phases: Floats,
    after: Floats,
    turned: Floats,
) -> None:
    """Write into the rows ``after``, and ``turned``, modes and phases one step of a level later."""
    basis = flight.basis
    m = phases.shape[0]
    n = basis.modes.shape[0]
    if n < MANY:
        step = basis.steps[level]
        for j in range(n):
            u = modes[U, j]
            w = modes[W, j]
            pull = flight.pull[PULL, j] + flight.pull[SLOPE, j] * s
            slope = flight.pull[SLOPE, j]
            u1 = step[STEP_D, j] * pull + step[STEP_E, j] * slope
            w1 = step[STEP_S, j] * pull + step[STEP_D, j] * slope
            if basis.of_set[HAS_RATES] == 1.0:
                first, second, loss = step_of_rates(flight, step, j, s)
                u1 = u1 + first + second
                w1 -= loss
            for k in range(m):
                at = STEP_ENTRIES + STEP_HARMONIC * k
                in_cos = basis.drive[j, k, FORCE_COS]
                in_sin = basis.drive[j, k, FORCE_SIN]
                part = in_cos * phases[k, 0] + in_sin * phases[k, 1]
                quadrature = in_sin * phases[k, 0] - in_cos * phases[k, 1]
                u1 += part * step[at, j] + quadrature * step[at + 1, j]
                w1 += part * step[at + 2, j] + quadrature * step[at + 3, j]
                if basis.of_set[HAS_RATES] == 1.0:
                    first, second, loss = step_of_wave(basis, step, j, k, phases)
                    u1 = u1 + first + second
                    w1 -= loss
            after[U, j] = u1 + (step[U_OF_U, j] * u + step[STEP_S, j] * w)
            after[W, j] = w1 + (step[W_OF_U, j] * u + step[W_OF_W, j] * w)
    else:
        step_of_many(flight, level, s, modes, phases, after)
    for k in range(m):
        cosine = basis.turns[level, k, 0]
        sine = basis.turns[level, k, 1]
        turned[k, 0] = phases[k, 0] * cosine - phases[k, 1] * sine
        turned[k, 1] = phases[k, 1] * cosine + phases[k, 0] * sine


@formula
def step_of_rates(
    flight: ModalFlight, step: Floats, j: int, s: float
) -> tuple[float, float, float]:
    """Return two terms of u, and what w loses, by the constant input into u' and its slope."""
    drag = flight.basis.modes[j, DRAG]
    rate = flight.pull[DRIFT, j] + flight.pull[DRIFT_SLOPE, j] * s
    slope = flight.pull[DRIFT_SLOPE, j]
    return (
        rate * (step[STEP_S, j] + drag * step[STEP_D, j]),
        slope * (step[STEP_D, j] + drag * step[STEP_E, j]),
        flight.basis.modes[j, SPRING] * (rate * step[STEP_D, j] + slope * step[STEP_E, j]),
    )


@formula
def step_of_wave(
    basis: Basis, step: Floats, j: int, k: int, phases: Floats
) -> tuple[float, float, float]:
    """Return two terms of u, and what w loses, by the input of a harmonic into u'."""
    at = STEP_ENTRIES + STEP_HARMONIC * k
    in_cos = basis.drive[j, k, RATE_COS]
    in_sin = basis.drive[j, k, RATE_SIN]
    part = in_cos * phases[k, 0] + in_sin * phases[k, 1]
    quadrature = in_sin * phases[k, 0] - in_cos * phases[k, 1]
    response = part * step[at, j] + quadrature * step[at + 1, j]
    return (
        part * step[at + 2, j] + quadrature * step[at + 3, j],
        basis.modes[j, DRAG] * response,
        basis.modes[j, SPRING] * response,
    )


@formula
def step_of_many(
    flight: ModalFlight, level: int, s: float, modes: Floats, phases: Floats, after: Floats
) -> None:
    """Write the modes one step later, row by row (`percuss.kernels.structure.flight.rates_of_many`)."""
    basis = flight.basis
    n = basis.modes.shape[0]
    step = basis.steps[level]
    u = after[U]
    w = after[W]
    step_row(flight.pull, s, step[STEP_D], step[STEP_E], u)
    step_row(flight.pull, s, step[STEP_S], step[STEP_D], w)
    has_rates = basis.of_set[HAS_RATES] == 1.0
    if has_rates:
        for j in range(n):
            first, second, _ = step_of_rates(flight, step, j, s)
            u[j] = u[j] + first + second
        for j in range(n):
            _, _, loss = step_of_rates(flight, step, j, s)
            w[j] -= loss
    for k in range(phases.shape[0]):
        at = STEP_ENTRIES + STEP_HARMONIC * k
        wave_row(basis.walk, k, phases, step[at], step[at + 1], u)
        wave_row(basis.walk, k, phases, step[at + 2], step[at + 3], w)
        if has_rates:
            for j in range(n):
                first, second, _ = step_of_wave(basis, step, j, k, phases)
                u[j] = u[j] + first + second
            for j in range(n):
                _, _, loss = step_of_wave(basis, step, j, k, phases)
                w[j] -= loss
    own_row(step[U_OF_U], step[STEP_S], modes, u)
    own_row(step[W_OF_U], step[W_OF_W], modes, w)


@formula
def step_row(pull: Floats, s: float, rise: Floats, ramp: Floats, row: Floats) -> None:
    """Write what the constant input into w', and its slope, make of a row over a step."""
    force = pull[PULL]
    slope = pull[SLOPE]
    for j in range(force.shape[0]):
        row[j] = rise[j] * (force[j] + slope[j] * s) + ramp[j] * slope[j]


@formula
def wave_row(
    walk: Floats, k: int, phases: Floats, to_cos: Floats, to_sin: Floats, row: Floats
) -> None:
    """Add to a row what the input of a harmonic into w' makes of it over a step."""
    at = WALK_ROWS + DRIVE_ENTRIES * k
    in_cos = walk[at + FORCE_COS]
    in_sin = walk[at + FORCE_SIN]
    cosine = phases[k, 0]
    sine = phases[k, 1]
    for j in range(in_cos.shape[0]):
        part = in_cos[j] * cosine + in_sin[j] * sine
        row[j] += part * to_cos[j] + (in_sin[j] * cosine - in_cos[j] * sine) * to_sin[j]


@formula
def own_row(of_u: Floats, of_w: Floats, modes: Floats, row: Floats) -> None:
    """Add to a row what the modes themselves make of it over a step."""
    u = modes[U]
    w = modes[W]
    for j in range(of_u.shape[0]):
        row[j] += of_u[j] * u[j] + of_w[j] * w[j]


@formula
def copy_phases(source: Floats, target: Floats) -> None:
    """Copy the phases of harmonics."""
    for k in range(source.shape[0]):
        target[k, 0] = source[k, 0]
        target[k, 1] = source[k, 1]


@formula
def next_event(
    flight: ModalFlight, scratch: Floats, rows: Floats, free: Floats, longest: float
) -> GuardEvent:
    """Return the first passage of a guard through zero before ``longest``.

    ``free`` (stops,) are the times up to which each guard is known to be positive, and come back
    so. ``scratch`` (8, k, 6), of which the last array is the caller's, holds phases and what is
    seen along the walk; k is the largest number of modes, harmonics and stops. ``rows`` (9, n)
    holds the modes.
    """
    basis = flight.basis
    n = basis.modes.shape[0]
    n_guards = basis.levels.shape[0]
    modes = rows[0:2]
    after = rows[2:4]
    seen = scratch[2, :n_guards]
    seen1 = scratch[3, :n_guards]
    phases = scratch[4, : flight.phases.shape[0]]
    turned = scratch[5, : flight.phases.shape[0]]
    rates = rows[4:9]
    s = longest
    for i in range(n_guards):
        if basis.levels[i, IS_ON] == 1.0:
            s = min(s, free[i])
    if s >= longest:
        return no_event(longest)
    top = int(basis.of_set[N_LEVELS]) - 1
    level = top
    # Errors grow with the motion where it grows: begin each step from the closed form.
    steps_a_walk = STEPS_A_WALK if basis.of_set[GROWTH] == 0.0 else 1
    for _ in range(WALKS_AT_ONCE):
        if s > 0.0:
            arrive_in_rows(flight, s, modes)
            copy_phases(flight.arrival, phases)
        else:
            for j in range(n):
                modes[U, j] = flight.begin[j, U]
                modes[W, j] = flight.begin[j, W]
            copy_phases(flight.phases, phases)
        see(flight, modes, phases, s, rates, seen)
        steps = 0
        while steps < steps_a_walk:
            if s >= longest:
                return no_event(longest)
            level = level_of(flight, s, level, seen, free)
            width = basis.of_set[STEP_LENGTH] * (1 << level)
            step_on(flight, level, s, modes, phases, after, turned)
            see(flight, after, turned, s + width, rates, seen1)
            unclear = -1
            count = 0
            for i in range(n_guards):
                is_due = basis.levels[i, IS_ON] == 1.0 and free[i] < s + width
                if is_due and not is_clear(flight, i, s, width, seen, seen1, free):
                    count += 1
                    unclear = i
            if count > 0:
                event = no_event(s)
                if count == 1 and free[unclear] <= s:
                    event = crossing(flight, unclear, s, width, seen, seen1)
                if event.verdict == NONE and level > 0:
                    level -= 1
                    continue
                if event.verdict == NONE:
                    event = first_of_all(
                        flight, free, s, min(s + width, longest), seen, seen1, width
                    )
                if event.verdict != NONE:
                    if event.s > longest:
                        return no_event(longest)
                    return event
            elif level < top:
                level += 1
            s += width
            steps += 1
            for i in range(n_guards):
                free[i] = max(free[i], s)
            for j in range(n):
                modes[U, j] = after[U, j]
            for j in range(n):
                modes[W, j] = after[W, j]
            copy_phases(turned, phases)
            for i in range(n_guards):
                for k in range(SEEN_COLUMNS):
                    seen[i, k] = seen1[i, k]
    return GuardEvent(PAUSE, s, -1, 0.0, 0.0)


@formula
def level_of(flight: ModalFlight, s: float, level: int, seen: Floats, free: Floats) -> int:
    """Return the highest level, from one down, at which the tests of a step may tell something.

    They ask for a bound of the fourth derivative that is small beside what the guard is, or falls
    by; where it ends follows from its derivatives at the beginning.
    """
    basis = flight.basis
    width = basis.of_set[STEP_LENGTH] * (1 << level)
    for i in range(basis.levels.shape[0]):
        while level > 0 and basis.levels[i, IS_ON] == 1.0 and free[i] < s + width:
            bend = fourth_bound(basis, i, seen[i, BEND], width) * width * width * width * width
            falls = -width * (seen[i, SPEED] + 0.5 * width * seen[i, SECOND])
            y = seen[i, VALUE]
            ends = y - falls
            room = 8.0 * falls
            if ends > 0.0:
                room = 384.0 * min(y, ends)
                if s == 0.0 and flight.order[i] == 1.0:
                    room = min(384.0 * ends, 24.0 * width * seen[i, SPEED])
            if bend <= room:
                break
            level -= 1
            width *= 0.5
    return level


@formula
def slack_of(i: int, width: float, seen: Floats, seen1: Floats) -> float:
    """Return a bound on what a walk has rounded away in a guard."""
    sizes = seen[i, SIZE] + seen1[i, SIZE] + width * (seen[i, RATE_SIZE] + seen1[i, RATE_SIZE])
    return WALK_SLACK * sizes


@formula
def is_clear(
    flight: ModalFlight, i: int, s: float, width: float, seen: Floats, seen1: Floats, free: Floats
) -> bool:
    """Return whether a guard stays positive over a step."""
    y = seen[i, VALUE]
    y1 = seen1[i, VALUE]
    v = seen[i, SPEED]
    v1 = seen1[i, SPEED]
    bend = fourth_bound(flight.basis, i, seen[i, BEND], width) * width * width * width * width
    slack = slack_of(i, width, seen, seen1)
    error = bend * (1.0 / 384.0) + slack
    first = y + THIRD * width * v
    last = y1 - THIRD * width * v1
    if s == 0.0 and flight.order[i] == 1.0:
        # tau^2 (1 - tau)^2 is at most a third of the first Bernstein polynomial; the value at the
        # beginning is exactly zero, and what counts is the clearance divided by the time.
        rise = THIRD * width * v
        slack *= OF_ONE_STEP
        return rise - bend * (1.0 / 72.0) > slack and min(last, y1) > bend * (1.0 / 384.0) + slack
    if free[i] > s:
        return False
    if min(y, y1) > error:
        if min(first, last) > error:
            return True
        return cubic_minimum(y, width * v, y1, width * v1) > error
    return False


@formula
def crossing(
    flight: ModalFlight, i: int, s: float, width: float, seen: Floats, seen1: Floats
) -> GuardEvent:
    """Return the HIT of the one guard of a step that is not clear, if it simply falls through zero.

    A root is the first one if the cubic through the beginning and the root has Bernstein
    coefficients above M w^4 / 288 (`percuss.kernels.next_event.event_of_step`).
    """
    slack = slack_of(i, width, seen, seen1)
    begins = seen[i, VALUE]
    from_bound = s == 0.0 and flight.order[i] == 1.0
    if not ((begins > slack or from_bound) and seen1[i, VALUE] < -slack):
        return no_event(s)
    fourth = fourth_bound(flight.basis, i, seen[i, BEND], width)
    if fourth * width * width * width * width > 8.0 * (begins - seen1[i, VALUE]):
        # The cubic says little yet.
        return no_event(s)
    begins = 0.0 if from_bound else begins
    square = width * width
    ends = (begins, width * seen[i, SPEED], square * seen[i, SECOND])
    ends1 = (seen1[i, VALUE], width * seen1[i, SPEED], square * seen1[i, SECOND])
    guess = s + width * quintic_root(ends, ends1)
    end, speed, s_low = locate_root(flight, i, (s, s + width, guess))
    part = end - s
    least = fourth * part * part * part * part * (1.0 / 287.0)
    least += 0.0 if from_bound else slack
    if begins + THIRD * part * seen[i, SPEED] > least and -THIRD * part * speed > least:
        # The clearance at a velocity's zero within rounding: sqrt(2 slack times the acceleration),
        # which over the step changes by no more than its fourth derivative allows.
        curve = abs(seen[i, SECOND]) + abs(seen1[i, SECOND]) + fourth * width * width
        flight.at[1] = 4.0 * slack * curve
        return GuardEvent(HIT, end, i, speed, s_low)
    return no_event(s)


@formula
def locate_root(
    flight: ModalFlight, i: int, bracket: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return (s, slope, s_low) where a guard falls to zero; ``later`` holds the modes at s.

    ``bracket`` is (left, right, guess): positive at the left, not at the right, one root between.
    """
    left, right, s = bracket
    quickest = flight.basis.of_set[QUICKEST]
    first = 0.0
    for _ in range(MAX_ITERATIONS):
        move(flight, s)
        y, first, second, third, fourth, bend = derivatives_here(flight, i, s, False)
        if y > 0.0:
            left = s
        else:
            right = s
        step = series_root(y, first, second, third, fourth)
        if left <= s + step <= right:
            size = abs(step)
            fifth = quickest * (abs(fourth) + fourth_bound(flight.basis, i, bend, size))
            square = size * size
            settled = size <= 2.0 * ULP * s or (
                has_small_terms(size, first, second, third, fourth)
                and fifth * square * square <= 32.0 * ULP * abs(first)
            )
            end = s + step
            if settled and size <= end:
                shift(flight, s, step)
                flight.at[0] = end
                bent = third * 0.5 + step * fourth * (1.0 / 6.0)
                return end, first + step * (second + step * bent), step - (end - s)
            s = end
        else:
            middle = 0.5 * (left + right)
            if not left < middle < right:
                break
            s = middle
    return s, first, 0.0


@kernel
def departure(flight: ModalFlight, i: int, longest: float) -> float:
    """Return a time up to which a guard that begins at zero is positive, 0 if it is not at all.

    As `percuss.kernels.event_location.departure`, up to the third derivative; ``order`` says how
    many derivatives are known to vanish. A guard that none of these moves is free for ``longest``.
    """
    _, first, second, third, _, bend = derivatives(flight, i, 0.0, True)
    order = int(flight.order[i])
    value = first
    if order <= 1 and first != 0.0:
        order = 1
    elif order <= 2 and second != 0.0:
        order = 2
        value = second
    else:
        order = 3
        value = third
    if value == 0.0:
        return longest
    if value < 0.0:
        return 0.0
    width = longest
    quickest = flight.basis.of_set[QUICKEST]
    if width == math.inf:
        width = 1.0 / quickest if quickest > 0.0 else 1.0
        for _ in range(64):
            width *= 2.0
    free = 0.0
    for _ in range(256):
        bound = fourth_bound(flight.basis, i, bend, width)
        if order == 2:
            bound = abs(third) + width * bound
        elif order == 1:
            bound = abs(second) + width * (abs(third) + width * bound)
        free = 0.9 * (order + 1) * value / bound if bound > 0.0 else longest
        if free >= width:
            return width
        width = max(free, 0.25 * width)
    return free


@kernel
def first_of_all(
    flight: ModalFlight,
    free: Floats,
    s: float,
    end: float,
    seen: Floats,
    seen1: Floats,
    width: float,
) -> GuardEvent:
    """Return the first event of a step, each guard searched from where it is known free."""
    best = no_event(end)
    flight.at[1] = math.inf
    for i in range(free.shape[0]):
        if flight.basis.levels[i, IS_ON] == 0.0 or free[i] >= end:
            continue
        if free[i] <= s and is_clear(flight, i, s, width, seen, seen1, free):
            continue
        left = max(free[i], 0.0)
        if left == 0.0 and flight.order[i] > 0.0:
            left = departure(flight, i, end)
            if left == 0.0:
                _, first, _, _, _, _ = derivatives(flight, i, 0.0, True)
                return GuardEvent(HIT, 0.0, i, first, 0.0)
            free[i] = left
        if left >= best.s:
            continue
        root = first_root(flight, i, (left, best.s))
        free[i] = root.free
        if root.verdict != NONE:
            best = GuardEvent(root.verdict, root.s, i, root.value, root.rest)
    return best


@kernel
def first_root(flight: ModalFlight, i: int, span: Pair) -> Root:
    """Return the first root of a guard, as `percuss.kernels.event_location.first_root`."""
    left, right = span
    if not left < right:
        return Root(NONE, right, 0.0, 0.0, right)
    move(flight, left)
    doubt = 2.0 * max(uncertainty(flight, i, left), uncertainty(flight, i, right))
    y, first, second, third, _, bend = derivatives(flight, i, left, False)
    width = right - left
    sure = left
    if left == 0.0 and flight.order[i] == 0.0 and y < -doubt:
        return Root(HIT, 0.0, first, 0.0, 0.0)
    for _ in range(MOST_PIECES):
        width = min(width, right - left)
        fourth = fourth_bound(flight.basis, i, bend, width)
        if not fourth < math.inf:
            return Root(HIT, left, math.nan, 0.0, left)
        shape = shape_of(y, first, second, third, fourth, width, doubt)
        if shape == UNKNOWN and width > 8.0 * ULP * (left + width):
            width *= 0.5
            continue
        after = left + width
        gap = y
        dips = shape == ONE_MINIMUM and first <= 0.0
        move(flight, after)
        y, first, second, third, _, bend = derivatives(flight, i, after, False)
        foot = after
        clearance = y
        error = doubt
        if y <= 0.0:
            error = uncertainty(flight, i, after)
        # A dip may end where the piece does: at t_end, at a knot, or where another guard falls.
        if dips and first > 0.0 and y >= -error:
            foot, clearance, error = lowest(flight, i, left, after)
            move(flight, after)
            if abs(clearance) <= error:
                return Root(GRAZE, foot, clearance, error, after)
        if clearance < -error:
            s, speed, s_low = locate_root(flight, i, (sure, foot, 0.5 * (sure + foot)))
            return Root(HIT, s, speed, s_low, s)
        if shape == CLEAR or y > doubt:
            if sure < left and gap <= 0.0:
                return Root(GRAZE, left, gap, doubt, after)
            sure = after
        if after >= right:
            return Root(NONE, right, 0.0, 0.0, right)
        left = after
        width *= 2.0
    return Root(GRAZE, left, y, math.inf, right)


@kernel
def lowest(flight: ModalFlight, i: int, left: float, right: float) -> tuple[float, float, float]:
    """Return (s, value, rounding bound) at the one turning point of a convex stretch of a guard."""
    s = 0.5 * (left + right)
    value = second = 0.0
    for _ in range(MAX_ITERATIONS):
        move(flight, s)
        value, first, second, _, _, _ = derivatives(flight, i, s, False)
        if first < 0.0:
            left = s
        else:
            right = s
        step = -first / second if second != 0.0 else 0.0
        if abs(step) <= 2.0 * ULP * s:
            break
        s = within_bracket(s + step, left, right)
        if not left < s < right:
            break
    # Between two doubles the guard may be less than at either.
    return s, value, uncertainty(flight, i, s) + 8.0 * abs(second) * (ULP * s) ** 2
