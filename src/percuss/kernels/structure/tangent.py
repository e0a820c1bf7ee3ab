"""The derivative of a structure's motion by its start, carried over flights and events.

Columns of displacements and velocities are carried flight by flight in the modes, and across each
event by the jump of a motion that meets it a little earlier or later (Aizerman & Gantmakher 1958;
the "saltation matrix").
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin, exponential, logarithm
from percuss.kernels.compile import kernel
from percuss.kernels.flight import free_response
from percuss.kernels.law_columns import (
    DAMPING,
    FAST_ROOT,
    HALF_TURNS,
    HALF_TURNS_LOW,
    OVERDAMPED,
    RATE,
    SLOW_ROOT,
    TWICE_PER_RATE,
    Law,
)
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    NEXT_REGION,
    RELEASE,
    SLOW_LANDING,
    V_AFTER,
    V_BEFORE,
)
from percuss.kernels.restitution import kept_of_area, kept_of_error
from percuss.kernels.structure.basis import (
    DRAG,
    OF_U,
    OF_W,
    SPRING,
    Basis,
    Sets,
    basis_of,
    row_of,
    wall_of,
)
from percuss.kernels.structure.flight import ModalFlight, U, W, arrive, inputs
from percuss.kernels.structure.run import StructureRun, walls_of
from percuss.kernels.structure.sample import flight_after


@kernel
def carry(basis: Basis, s: float, columns: Floats) -> None:
    """Carry derivatives of the modes, (n, 2, c), over a flight of length s."""
    for j in range(columns.shape[0]):
        impulse, even, _ = free_response(basis.law, row_of(basis, j), s)
        spring = basis.modes[j, SPRING]
        drag = 0.5 * basis.modes[j, DRAG] * impulse
        # No difference from 1: what a long flight leaves of a perturbation may be far less.
        u_of_u = even + drag
        w_of_w = even - drag
        for c in range(columns.shape[2]):
            u = columns[j, U, c]
            w = columns[j, W, c]
            columns[j, U, c] = u_of_u * u + impulse * w
            columns[j, W, c] = w_of_w * w - spring * impulse * u


@kernel
def carry_far(basis: Basis, s: float, columns: Floats, logs: Floats) -> None:
    """Carry derivatives of the modes, (n, 2, c), over a long flight, and add to their logarithms.

    Each part of a mode keeps its exponential apart. Columns are eliminated in their order, from the
    part that is the largest after the flight: a column that grows less than another is not lost
    beside it, and the spaces of the first ones are what they were.
    """
    n = columns.shape[0]
    for j in range(n):
        turn_mode(basis.law, row_of(basis, j), s, columns[j])
    for c in range(columns.shape[2]):
        mode, part, most = 0, 0, -math.inf
        for j in range(n):
            for i in range(2):
                if columns[j, i, c] != 0.0:
                    exponent = exponent_of(basis.law, row_of(basis, j), i, s)
                    size = exponent + logarithm(abs(columns[j, i, c]))
                    if size > most:
                        mode, part, most = j, i, size
        if most == -math.inf:
            continue
        for other in range(c + 1, columns.shape[2]):
            share = columns[mode, part, other] / columns[mode, part, c]
            for j in range(n):
                for i in range(2):
                    columns[j, i, other] -= share * columns[j, i, c]
            # What is left of rounding there would outgrow all else.
            columns[mode, part, other] = 0.0
        greatest = exponent_of(basis.law, row_of(basis, mode), part, s)
        logs[c] += greatest
        for j in range(n):
            for i in range(2):
                if columns[j, i, c] != 0.0:
                    exponent = exponent_of(basis.law, row_of(basis, j), i, s) - greatest
                    # In two steps: neither overflows where what it is applied to is small.
                    half = exponential(0.5 * exponent)
                    columns[j, i, c] = columns[j, i, c] * half * half
    for j in range(n):
        join_parts(basis.law, row_of(basis, j), s, columns[j])


@kernel
def is_parted(law: Law, row: int, s: float) -> bool:
    """Return whether the two exponentials of a mode are apart after a time s."""
    return law[row, OVERDAMPED] == 1.0 and 2.0 * law[row, RATE] * s > 1.0


@kernel
def exponent_of(law: Law, row: int, part: int, s: float) -> float:
    """Return the exponent after a time s of a part of a mode, as `turn_mode` has the two."""
    if is_parted(law, row, s):
        return law[row, SLOW_ROOT if part == 0 else FAST_ROOT] * s
    return -law[row, DAMPING] * s


@kernel
def turn_mode(law: Law, row: int, s: float, columns: Floats) -> None:
    """Write the parts of a mode after a time s, (2, c), without their exponentials, from u and w.

    They are the shares p and q of the slow and the fast exponential, w - FAST u = 2 RATE p, where
    these are apart; else u and b = w + a u, of which u = exp(-a s) (C u + S b) and
    b = exp(-a s) (K' S u + C b) with K' = a^2 - K.
    """
    rate = law[row, RATE]
    even, impulse = 1.0, s
    bend = 0.0
    if not is_parted(law, row, s):
        if law[row, OVERDAMPED] == 1.0:
            bend = rate * rate
            growth = exponential(rate * s)
            even = 0.5 * (growth + 1.0 / growth)
            impulse = 0.5 * (growth - 1.0 / growth) / rate
        elif rate > 0.0:
            bend = -rate * rate
            half_cos, half_sin = cos_sin(law[row, HALF_TURNS], law[row, HALF_TURNS_LOW], s, 0.0)
            even = (half_cos - half_sin) * (half_cos + half_sin)
            impulse = half_sin * half_cos * law[row, TWICE_PER_RATE]
    for c in range(columns.shape[1]):
        u, w = columns[U, c], columns[W, c]
        if is_parted(law, row, s):
            columns[0, c] = (w - law[row, FAST_ROOT] * u) / (2.0 * rate)
            columns[1, c] = (law[row, SLOW_ROOT] * u - w) / (2.0 * rate)
        else:
            b = w + law[row, DAMPING] * u
            columns[0, c] = even * u + impulse * b
            columns[1, c] = bend * impulse * u + even * b


@kernel
def join_parts(law: Law, row: int, s: float, columns: Floats) -> None:
    """Write u and w of a mode from its parts, (2, c), as `turn_mode` has them."""
    for c in range(columns.shape[1]):
        p, q = columns[0, c], columns[1, c]
        if is_parted(law, row, s):
            columns[U, c] = p + q
            columns[W, c] = law[row, SLOW_ROOT] * p + law[row, FAST_ROOT] * q
        else:
            columns[W, c] = q - law[row, DAMPING] * p


@kernel
def to_modes(sets: Sets, b: int, place: Floats, columns: Floats) -> None:
    """Write derivatives of the modes of a set, (n, 2, c), from those of the coordinates, (2, n, c)."""
    n = place.shape[1]
    for j in range(columns.shape[0]):
        for part in range(2):
            for c in range(columns.shape[2]):
                total = 0.0
                for i in range(n):
                    total += sets.inverse[b, i, part, j] * place[0, i, c]
                    total += sets.inverse[b, n + i, part, j] * place[1, i, c]
                columns[j, part, c] = total


@kernel
def to_places(sets: Sets, b: int, columns: Floats, place: Floats) -> None:
    """Write derivatives of the coordinates, (2, n, c), from those of the modes of a set."""
    for i in range(place.shape[1]):
        for c in range(place.shape[2]):
            x = 0.0
            v = 0.0
            for j in range(columns.shape[0]):
                p = sets.shape[b, j, 0, i]
                q = sets.shape[b, j, 1, i]
                u = columns[j, U, c]
                w = columns[j, W, c]
                x += p * u + q * w
                v += p * w - q * (sets.modes[b, j, SPRING] * u + sets.modes[b, j, DRAG] * w)
            place[0, i, c] = x
            place[1, i, c] = v


@kernel
def pace(
    sets: Sets, b: int, flight: ModalFlight, modes: Floats, phases: Floats, s: float, out: Floats
) -> None:
    """Write the time derivatives of displacements and velocities, (2, n), a time s into a flight."""
    basis = flight.basis
    for i in range(out.shape[1]):
        out[0, i] = 0.0
        out[1, i] = 0.0
    for j in range(modes.shape[0]):
        force, slope, _, rate, rate_slope, _ = inputs(basis, j, phases, flight.pull, s)
        u1 = modes[j, W] + rate
        w1 = force - basis.modes[j, SPRING] * modes[j, U] - basis.modes[j, DRAG] * modes[j, W]
        u2 = w1 + rate_slope
        w2 = slope - basis.modes[j, SPRING] * u1 - basis.modes[j, DRAG] * w1
        for i in range(out.shape[1]):
            p = sets.shape[b, j, 0, i]
            q = sets.shape[b, j, 1, i]
            out[0, i] += p * u1 + q * w1
            out[1, i] += p * u2 + q * w2


@kernel
def carry_run(
    run: StructureRun, t_end: float, place: Floats, columns: Floats, paces: Floats
) -> None:
    """Carry derivatives of the coordinates, (2, n, c), from the start of a record to ``t_end``.

    ``columns`` (n, 2, c) and ``paces`` (2, 2, n) are scratch. A chatter that is summed, and a
    landing at rest, take the derivative of the motion that the wall holds from there on.
    """
    last = run.events.shape[0] - 1
    for row in range(last + 1):
        if row < last:
            s = run.events[row + 1, EVENT_T] - run.events[row, EVENT_T]
            s += run.events[row + 1, EVENT_T_LOW] - run.events[row, EVENT_T_LOW]
        else:
            s = (t_end - run.events[row, EVENT_T]) - run.events[row, EVENT_T_LOW]
        b = set_of_flight(run, row, row == last)
        if b != run.marks[row, NEXT_REGION]:
            settle(run, row, place, paces[0, 0])
        to_modes(run.sets, b, place, columns)
        carry(basis_of(run.sets, b), s, columns)
        if row < last:
            cross(run, row, s, place, columns, paces)
        else:
            to_places(run.sets, b, columns, place)


@kernel
def settle(run: StructureRun, row: int, place: Floats, pushes: Floats) -> None:
    """Add to derivatives what dashpots do while the tail of a chatter closes a gap, ``pushes`` (n,).

    A neighbour is off the wall by what it has of the clearance, of the order of the last hop's
    speed; until it rests dashpots have changed the momentum of the other coordinates as much.
    """
    stop = run.marks[row + 1, BOUND]
    push_of_kick(run.sets, run.marks[row, NEXT_REGION], stop, pushes)
    for c in range(place.shape[2]):
        gap = 0.0
        for i in range(place.shape[1]):
            gap += run.sets.normals[stop, i] * place[0, i, c]
        for i in range(place.shape[1]):
            place[1, i, c] -= gap * pushes[i]


@kernel
def set_of_flight(run: StructureRun, row: int, is_last: bool) -> int:
    """Return the set by which neighbours move from the event of a row to the next.

    From the last impact that is listed before a chatter the wall holds in the mean.
    """
    if not is_last and run.marks[row + 1, KIND] == CONTACT:
        return run.marks[row + 1, NEXT_REGION]
    return run.marks[row, NEXT_REGION]


@kernel
def delay_of(run: StructureRun, row: int, place: Floats, c: int) -> float:
    """Return by how much an event is late, from derivatives of the coordinates just after it.

    One that jumps the forces may let a wall go, which is as late. A knot is at its own instant.
    """
    stop = run.marks[row, BOUND]
    if run.marks[row, KIND] == IMPACT:
        speed = run.events[row, V_AFTER]
    elif run.marks[row, KIND] == CROSSING:
        # Its speed is that at which a clearance falls or, on the way out, how deep the stop is
        # pressed in.
        is_out = run.events[row, V_AFTER] > 0.0
        speed = -run.events[row, V_BEFORE] if is_out else run.events[row, V_BEFORE]
    else:
        return 0.0
    fall = 0.0
    for i in range(place.shape[1]):
        fall += run.sets.normals[stop, i] * place[0, i, c]
    return -fall / speed if speed != 0.0 else 0.0


@kernel
def cross(
    run: StructureRun, row: int, s: float, place: Floats, columns: Floats, paces: Floats
) -> None:
    """Write derivatives of the coordinates just after the event that ends the flight of a row.

    ``columns`` (n, 2, c) are those of the modes just before it, a time s into the flight, and
    ``paces`` (2, 2, n) is scratch.
    """
    sets = run.sets
    b = set_of_flight(run, row, False)
    kind = run.marks[row + 1, KIND]
    to_places(sets, b, columns, place)
    if kind not in (IMPACT, CROSSING, RELEASE, SLOW_LANDING):
        return
    stop = run.marks[row + 1, BOUND]
    flight = flight_after(run, row)
    modes = run.scratch[1, : run.begin.shape[0]]
    arrive(flight, s, modes)
    pace(sets, b, flight, modes, run.arrival, s, paces[0])
    speed = run.events[row + 1, V_BEFORE]
    kept = 0.0
    if kind == IMPACT:
        kept = kept_of(sets, stop, -speed)
    after = flight_after(run, row + 1)
    c_after = run.marks[row + 1, NEXT_REGION]
    pace(sets, c_after, after, after.begin, after.phases, 0.0, paces[1])
    # `flight_after` has written over the modes of the flight before: its basis stays.
    before = sets.guard[b, stop]
    is_plain = kind == IMPACT and c_after == b and sets.keys[b] & walls_of(sets) == 0
    if is_plain:
        push_of_kick(sets, b, stop, paces[1, 1])
    for c in range(place.shape[2]):
        fall = 0.0
        for j in range(columns.shape[0]):
            fall += before[j, OF_U] * columns[j, U, c] + before[j, OF_W] * columns[j, W, c]
        if is_plain:
            bounce_column(
                sets, stop, (fall, speed, run.events[row + 1, V_AFTER]), kept, paces, place, c
            )
            continue
        # A release, where the force of the wall is zero, is no jump of anything.
        delay = 0.0
        if kind in (IMPACT, CROSSING) and speed != 0.0:
            delay = -fall / speed
        elif kind == RELEASE and s == 0.0:
            delay = delay_of(run, row, place, c)
        for i in range(place.shape[1]):
            place[0, i, c] += paces[0, 0, i] * delay
            place[1, i, c] += paces[0, 1, i] * delay
        if kind in (IMPACT, SLOW_LANDING):
            strike_column(sets, stop, kept, place, c)
        for i in range(place.shape[1]):
            place[0, i, c] -= paces[1, 0, i] * delay
            place[1, i, c] -= paces[1, 1, i] * delay


@kernel
def push_of_kick(sets: Sets, b: int, stop: int, out: Floats) -> None:
    """Write the change of the accelerations (n,) by a kick that changes a clearance's velocity by 1."""
    for i in range(out.shape[0]):
        out[i] = 0.0
    for j in range(sets.kick.shape[2]):
        spring = sets.modes[b, j, SPRING]
        drag = sets.modes[b, j, DRAG]
        u1 = sets.kick[b, stop, j, W]
        w1 = -spring * sets.kick[b, stop, j, U] - drag * u1
        w2 = -spring * u1 - drag * w1
        for i in range(out.shape[0]):
            out[i] += sets.shape[b, j, 0, i] * w1 + sets.shape[b, j, 1, i] * w2


@kernel
def bounce_column(
    sets: Sets,
    stop: int,
    impact: tuple[float, float, float],
    kept: float,
    paces: Floats,
    place: Floats,
    c: int,
) -> None:
    """Carry a column across an impact that changes the motion along its impulse alone.

    ``impact`` is (change of the clearance, velocity before, after); ``paces`` hold the
    accelerations before in [0, 1] and those of `push_of_kick` in [1, 1]. What two large terms would
    leave, each divided by a small velocity, stands here as it is: hops of a chatter lose no digits.
    """
    fall, speed, rebound = impact
    n = place.shape[1]
    ratio = (rebound - speed) / speed
    change = 0.0
    pull = 0.0
    for i in range(n):
        change += sets.normals[stop, i] * place[1, i, c]
        pull += sets.normals[stop, i] * paces[0, 1, i]
    change -= pull * fall / speed
    for i in range(n):
        along = sets.impulses[stop, i]
        place[0, i, c] += ratio * fall * along
        place[1, i, c] += ratio * fall * paces[1, 1, i] - (1.0 + kept) * change * along


@kernel
def kept_of(sets: Sets, i: int, speed: float) -> float:
    """Return the derivative of the speed after an impact by that before it."""
    region, bound = wall_of(sets, i)
    return kept_of_error(sets.walls[i], region, bound, speed)


@kernel
def kept_of_volume(sets: Sets, i: int, speed: float) -> float:
    """Return the square root of the factor of a volume between neighbours over an impact."""
    region, bound = wall_of(sets, i)
    return kept_of_area(sets.walls[i], region, bound, speed)


@kernel
def strike_column(sets: Sets, stop: int, kept: float, place: Floats, c: int) -> None:
    """Carry a column of the coordinates' derivatives, (2, n, c), across the jump of an impact."""
    n = place.shape[1]
    change = 0.0
    for i in range(n):
        change += sets.normals[stop, i] * place[1, i, c]
    for i in range(n):
        place[1, i, c] -= (1.0 + kept) * change * sets.impulses[stop, i]
