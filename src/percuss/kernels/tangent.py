"""The derivative of a motion with respect to its start, in closed form.

Along a flight the difference of two neighbours obeys the free equation, so that its *propagator*
is exact whatever the forcing. At an event neighbours arrive at other times; the *saltation matrix*
carries their difference over it, taken at one time before and after (Kong et al. 2024,
arXiv:2306.06862, eq. 20). A contact ends all memory: the release does not depend on how the mass
came to the wall. Matrices are tuples (xx, xv, vx, vv), so that
dx' = xx dx + xv dv and dv' = vx dx + vv dv.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin, exponential_less_one
from percuss.kernels.compile import kernel
from percuss.kernels.flight import (
    constant_force,
    force_and_slopes,
    free_response,
    harmonic_response,
    parts_of,
    place,
    set_phases,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    HALF_TURNS,
    HALF_TURNS_LOW,
    OMEGA,
    OVERDAMPED,
    RATE,
    SLOW_ROOT,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
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
    V_BEFORE,
    MotionRecord,
    time_since_event,
)
from percuss.kernels.restitution import kept_of_error, restitution_at

Matrix: TypeAlias = tuple[float, float, float, float]


@kernel
def product(left: Matrix, right: Matrix) -> Matrix:
    """Return the matrix product: what ``right`` does first, and ``left`` after it."""
    return (
        left[0] * right[0] + left[1] * right[2],
        left[0] * right[1] + left[1] * right[3],
        left[2] * right[0] + left[3] * right[2],
        left[2] * right[1] + left[3] * right[3],
    )


@kernel
def propagator(law: Law, region: int, s: float) -> Matrix:
    """Return the derivative of (x, v) after a flight of a time s by (x, v) at its start."""
    impulse, even, _ = free_response(law, region, s)
    drag = law[region, DAMPING] * impulse
    return even + drag, impulse, -law[region, STIFFNESS] * impulse, even - drag


@kernel
def scaled_propagator(law: Law, region: int, s: float) -> tuple[float, Matrix]:
    """Return the propagator without its slowest exponential, and the exponent of that.

    However long the flight is, the matrix neither underflows nor overflows.
    """
    damping = law[region, DAMPING]
    rate = law[region, RATE]
    exponent = -damping * s
    if law[region, OVERDAMPED] == 1.0:
        exponent = law[region, SLOW_ROOT] * s
        shrink = exponential_less_one(-2.0 * rate * s)
        impulse = -shrink / (2.0 * rate)
        even = 1.0 + 0.5 * shrink
    elif rate == 0.0:
        impulse = s
        even = 1.0
    else:
        half_cos, half_sin = cos_sin(law[region, HALF_TURNS], law[region, HALF_TURNS_LOW], s, 0.0)
        impulse = half_sin * half_cos * law[region, TWICE_PER_RATE]
        even = (half_cos - half_sin) * (half_cos + half_sin)
    drag = damping * impulse
    matrix = (even + drag, impulse, -law[region, STIFFNESS] * impulse, even - drag)
    return exponent, matrix


@kernel
def impact_saltation(
    restitution: float, kept: float, force: float, damping: float, v: float
) -> Matrix:
    """Return the saltation matrix of an impact that comes with velocity v.

    ``force`` is that at the wall, without damping, and ``kept`` the derivative of r(u) u by the
    speed u: r where the restitution is one number. A neighbour that is ahead by dx arrives earlier
    by dx / v. In the entry (kept a_before + a_after) / v of the accelerations the damping cancels
    then, since the velocity after is -r v.
    """
    drag = 2.0 * damping * (restitution - kept)
    return -restitution, 0.0, (1.0 + kept) * force / v + drag, -kept


@kernel
def crossing_saltation(damping_before: float, damping_after: float) -> Matrix:
    """Return the saltation matrix of the edge of a soft stop.

    The force jumps there by the stop's dashpot alone, in proportion to the velocity.
    """
    return 1.0, 0.0, 2.0 * (damping_before - damping_after), 1.0


@kernel
def event_saltation(
    law: Law,
    event: tuple[int, int, int, int],
    instant: tuple[float, float],
    v: float,
    phases: Floats,
) -> Matrix:
    """Return the saltation matrix of an event: its kind, bound, region before and region after.

    ``v`` is the velocity before it; ``phases`` is scratch.
    """
    kind, bound, before, after = event
    if kind == CROSSING:
        return crossing_saltation(law[before, DAMPING], law[after, DAMPING])
    if kind == IMPACT:
        set_phases(law, instant[0], instant[1], phases)
        force = constant_force(law, before, place(law, before, bound))
        force += force_and_slopes(law, phases)[0]
        restitution = restitution_at(law, before, bound, abs(v))
        kept = kept_of_error(law, before, bound, abs(v))
        return impact_saltation(restitution, kept, force, law[before, DAMPING], v)
    if kind == CONTACT:
        return 0.0, 0.0, 0.0, 0.0
    return 1.0, 0.0, 0.0, 1.0


@kernel
def neighbours(
    record: MotionRecord, instants: Floats, after: bool, phases: Floats, out: Floats
) -> None:
    """Write the derivative of (x, v) at each of ``instants`` by (x, v) at the START.

    ``instants`` (n,) ascend, and row i of ``out`` (n, 4) receives the matrix for the i-th.
    ``after`` takes the side after an event at an instant of its own, else the side before it.
    """
    law, events, marks = record.law, record.events, record.marks
    matrix = (1.0, 0.0, 0.0, 1.0)
    region = int(marks[0, NEXT_REGION])
    t = events[0, EVENT_T]
    t_low = events[0, EVENT_T_LOW]
    i = 0
    for n in range(events.shape[0]):
        if n > 0:
            matrix = product(propagator(law, region, time_since_event(events, n)), matrix)
            t = events[n, EVENT_T]
            t_low = events[n, EVENT_T_LOW]
            following = int(marks[n, NEXT_REGION])
            event = (int(marks[n, KIND]), int(marks[n, BOUND]), region, following)
            jump = event_saltation(law, event, (t, t_low), events[n, V_BEFORE], phases)
            matrix = product(jump, matrix)
            region = following
        until = events[n + 1, EVENT_T] if n + 1 < events.shape[0] else math.inf
        while i < instants.shape[0]:
            if not (instants[i] < until or (instants[i] == until and not after)):
                break
            # At the event's own float the motion is that of the event.
            s = (instants[i] - t) - t_low if instants[i] != t else 0.0
            out[i, 0], out[i, 1], out[i, 2], out[i, 3] = product(propagator(law, region, s), matrix)
            i += 1


@kernel
def delayed_start(law: Law, region: int, phases: Floats, s: float) -> tuple[float, float]:
    """Return the derivative of (y, v) a time s after the start by the time of the start.

    Displacement and velocity at the start are kept, and so is s; ``phases`` are those of the
    start. It is the response to the rate of the force: no difference of large terms in short
    flights.
    """
    impulse, even, rise = free_response(law, region, s)
    dy = 0.0
    dv = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        omega = law[harmonic, OMEGA]
        if omega < 0.0:
            dy += phases[j, 1] * rise
            dv += phases[j, 1] * impulse
            continue
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        to_cos, to_sin = harmonic_response(law, region, j, s, impulse, even, turn)
        in_phase, quadrature = parts_of(law, harmonic, phases[j, 0], phases[j, 1])
        # The rate of the phasor (in_phase, quadrature) is omega (quadrature, -in_phase).
        dy += omega * (quadrature * to_cos - in_phase * to_sin)
        dv += omega * (quadrature * (impulse - omega * to_sin) - in_phase * omega * to_cos)
    return dy, dv
