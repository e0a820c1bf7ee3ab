"""Columns: the derivatives of a flight by parameters, from few responses.

The derivative of a flight by a parameter, a *column*, obeys the equation of the flight itself,
forced by the change of the law along the motion,

    xi'' + 2 a xi' + K xi = dF - dK y - 2 da v + d(drive),

with y from the flight's start and dF the derivative of the constant force there. By linearity all
columns are sums of few responses: to y, to v, to the phases and to these times the time. Where
poles meet, or nearly, these are followed together with y by their power series in steps of a few
radians, from the recurrence of the equation itself: nothing is divided by a difference of poles,
so that resonance, critical damping, K = 0 and K < 0 are the same code and lose nothing. Where a
fast decay is over (`overdamped`) only the slow parts are followed so, in steps of their pace. An
oscillating flight away from resonance, and no shorter than half a radian, has them in closed form,
which takes a third of the time (docs/decisions/022-sensitivities.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import (
    Flight,
    free_response,
    harmonic_response,
    parts_of,
    quotient,
    slope_response,
)
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FAST_ROOT,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    LOWER,
    LOWER_FORCE,
    NEAR,
    OMEGA,
    ORIGIN_FORCE,
    OVERDAMPED,
    PER_STIFFNESS,
    RATE,
    SINE,
    SLOW_ROOT,
    STIFFNESS,
    TURNS,
    TURNS_LOW,
    UPPER,
    UPPER_FORCE,
    Law,
)
from percuss.kernels.overdamped import time_to_fade
from percuss.kernels.pieces import is_record, record_at

# A step of the series turns by so many radians at most: its largest term is then exp(4) = 55 times
# the sum at most, and a longer step saves less than it loses.
LONGEST_PHASE = 4.0
# The closed forms hold above this phase of the free motion, and this part of the damping.
LEAST_PHASE = 0.5
LEAST_RATE = 0.1
# Terms of a step, for steps of no phase and for each radian: the first term left out is below
# 1e-17 of the sum.
LEAST_TERMS = 14.0
TERMS_A_RADIAN = 5.6
MOST_TERMS = 40

# Entries of `shared`: the propagator, S and D with D' = S, E with E' = D; the responses to y and
# to v and the rate of the latter, the rate of the former being the response to v.
XX, XV, VX, VV, IMPULSE, RISE, RAMP, OF_Y, OF_V, RATE_OF_V = range(10)
SHARED_ENTRIES = 10
# Entries of a harmonic: the responses to cos(w s), sin(w s), s cos(w s), s sin(w s), and their
# rates.
TO_COS, TO_SIN, TO_LATE_COS, TO_LATE_SIN = 0, 1, 2, 3
RATES = 4
PHASE_ENTRIES = 8


class Change(NamedTuple):
    """The derivatives of a law by parameters.

    ``rows`` (n_parameters, n_rows, columns) are those of the law's own rows and columns, of its
    stiffness, damping, bounds, restitutions, forces at the bounds, harmonics and tables; in the
    column ORIGIN_FORCE stands the derivative of the constant force at 0, and in LOWER_ENTRY and
    UPPER_ENTRY those of the edges there, less that of the bound itself, times their dashpots 2 a
    upwards. The row of a record has the derivative of its scale in COSINE and that of the logarithm
    of its pace in OMEGA; ``unit`` is a law with the same record at scale 1.
    """

    rows: Floats
    unit: Law


class ColumnWorkspace(NamedTuple):
    """Scratch: phases at the start of a flight and at its end, and what `respond` writes."""

    phases: Floats
    arrival: Floats
    scratch: Floats
    shared: Floats
    waves: Floats
    series: Floats
    ends: Floats


@kernel
def fastest_rate(law: Law, region: int) -> float:
    """Return the magnitude of the larger characteristic root of a region."""
    if law[region, OVERDAMPED] == 1.0:
        return max(abs(law[region, SLOW_ROOT]), abs(law[region, FAST_ROOT]))
    return math.sqrt(abs(law[region, STIFFNESS]))


@kernel
def series_phase(law: Law, region: int, omega: float, s: float) -> float:
    """Return the phase through which the series go in a time s, under forces up to ``omega``."""
    if s >= time_to_fade(law, region):
        return s * max(abs(law[region, SLOW_ROOT]), omega)
    return abs(s) * max(fastest_rate(law, region), omega)


@kernel
def steps_of(phase: float) -> tuple[int, int]:
    """Return how many steps of the series a phase takes, and how many terms each has."""
    count = max(1, math.ceil(phase / LONGEST_PHASE))
    return count, min(MOST_TERMS, int(LEAST_TERMS + TERMS_A_RADIAN * phase / count))


@kernel
def fill_force(flight: Flight, since: float, h: float, terms: int, series: Floats) -> None:
    """Write the Taylor coefficients of h^2 times the whole force at a time after the start."""
    law = flight.law
    for n in range(terms):
        series[n] = 0.0
    square = h * h
    series[0] = square * flight.start[3]
    for j in range(flight.phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cos0 = flight.phases[j, 0]
        sin0 = flight.phases[j, 1]
        if is_record(law, j):
            series[0] += square * (cos0 + sin0 * since)
            series[1] += square * sin0 * h
            continue
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], since, 0.0)
        cosine = cos0 * turn[0] - sin0 * turn[1]
        sine = sin0 * turn[0] + cos0 * turn[1]
        part, quadrature = parts_of(law, harmonic, cosine, sine)
        part *= square
        quadrature *= square
        phase = law[harmonic, OMEGA] * h
        for n in range(terms):
            series[n] += part
            share = phase / (n + 1.0)
            part, quadrature = share * quadrature, -share * part


@kernel
def response_to_motion(flight: Flight, s: float, series: Floats) -> tuple[float, float, float]:
    """Return the response to y at s, its rate, which is the response to v, and the rate of that."""
    law, region, start, _, _ = flight
    damping = law[region, DAMPING]
    stiffness = law[region, STIFFNESS]
    omega = 0.0
    for j in range(flight.phases.shape[0]):
        omega = max(omega, law[FIRST_HARMONIC + j, OMEGA])
    count, terms = steps_of(series_phase(law, region, omega, s))
    h = s / count
    if s >= time_to_fade(law, region):
        return faded_response_to_motion(flight, s, count, terms, series)
    if h == 0.0:
        return 0.0, 0.0, 0.0
    drag = 2.0 * damping * h
    spring = stiffness * h * h
    y = 0.0
    v = start[2]
    of_y = 0.0
    of_v = 0.0
    for i in range(count):
        fill_force(flight, i * h, h, terms, series)
        y0 = y
        y1 = v * h
        r0 = of_y
        r1 = of_v * h
        v = y1
        y += y1
        of_v = r1
        of_y += r1
        order = 1.0
        for n in range(terms):
            per = 1.0 / (order * (order + 1.0))
            y2 = (series[n] - drag * order * y1 - spring * y0) * per
            r2 = (h * h * y0 - drag * order * r1 - spring * r0) * per
            order += 1.0
            y += y2
            v += order * y2
            of_y += r2
            of_v += order * r2
            y0 = y1
            y1 = y2
            r0 = r1
            r1 = r2
        v /= h
        of_v /= h
    return of_y, of_v, y - 2.0 * damping * of_v - stiffness * of_y


@kernel
def faded_response_to_motion(
    flight: Flight, s: float, count: int, terms: int, series: Floats
) -> tuple[float, float, float]:
    """Return what `response_to_motion` does, after the fast decay, by the parts of y.

    For each root r let u' = r u + F from v0, with the whole force F, and w' = r w + u from 0. Then

        y = (u1 - u2) / (r1 - r2),    S * y = (w1 + w2 - 2 y) / (r1 - r2)^2.

    The slow u1 and w1 are summed in ``count`` steps.
    """
    law, region, start, _, _ = flight
    slow = law[region, SLOW_ROOT]
    apart = 2.0 * law[region, RATE]
    h = s / count
    turn = slow * h
    u = start[2]
    w = 0.0
    for i in range(count):
        fill_force(flight, i * h, h, terms, series)
        # The Taylor coefficients of h u and of w.
        u0 = u * h
        w0 = w
        u = u0
        order = 1.0
        for n in range(terms):
            w0, u0 = (turn * w0 + u0) / order, (turn * u0 + series[n]) / order
            order += 1.0
            u += u0
            w += w0
        u /= h
    (force, slope), (u2, v2, a2), (w2, x2, b2) = fast_parts(flight, s)
    # The rates of u1 and w1, and the rates of these.
    v = slow * u + force
    a = slow * v + slope
    x = slow * w + u
    b = slow * x + v
    square = apart * apart
    return (
        ((w + w2) - 2.0 * (u - u2) / apart) / square,
        ((x + x2) - 2.0 * (v - v2) / apart) / square,
        ((b + b2) - 2.0 * (a - a2) / apart) / square,
    )


@kernel
def fast_parts(
    flight: Flight, s: float
) -> tuple[tuple[float, float], tuple[float, float, float], tuple[float, float, float]]:
    """Return force and rate, and u2 and w2 of `faded_response_to_motion` with two rates of each.

    What is left of them is the steady answer to the force.
    """
    law, region, start, phases, _ = flight
    fast = law[region, FAST_ROOT]
    constant, slope = start[3], 0.0
    u, v, a = 0.0, 0.0, 0.0
    w, x, b = 0.0, 0.0, 0.0
    force = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cos0 = phases[j, 0]
        sin0 = phases[j, 1]
        if is_record(law, j):
            constant += cos0 + sin0 * s
            slope += sin0
            u -= sin0 / fast**2
            v -= sin0 / fast
            w += 2.0 * sin0 / fast**3
            x += sin0 / fast**2
            continue
        omega = law[harmonic, OMEGA]
        turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        cosine = cos0 * turn[0] - sin0 * turn[1]
        sine = sin0 * turn[0] + cos0 * turn[1]
        part, quadrature = parts_of(law, harmonic, cosine, sine)
        force += part
        slope += omega * quadrature
        # The phasor of the force over i w - r2, once and twice.
        once = quotient(part, -quadrature, -fast, omega)
        twice = quotient(once[0], once[1], -fast, omega)
        u += once[0]
        v -= omega * once[1]
        a -= omega * omega * once[0]
        w += twice[0]
        x -= omega * twice[1]
        b -= omega * omega * twice[0]
    u -= constant / fast
    w += constant / fast**2
    return (constant + force, slope), (u, v, a), (w, x, b)


@kernel
def response_to_late_phase(
    law: Law, region: int, j: int, s: float
) -> tuple[float, float, float, float]:
    """Return the responses to s cos(w_j s) and to s sin(w_j s), and their rates."""
    omega = law[FIRST_HARMONIC + j, OMEGA]
    count, terms = steps_of(series_phase(law, region, omega, s))
    h = s / count
    if s >= time_to_fade(law, region):
        return faded_response_to_late_phase(law, region, j, s, count, terms)
    if h == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    drag = 2.0 * law[region, DAMPING] * h
    spring = law[region, STIFFNESS] * h * h
    u_re = 0.0
    u_im = 0.0
    v_re = 0.0
    v_im = 0.0
    for i in range(count):
        since = i * h
        turn = cos_sin(
            law[FIRST_HARMONIC + j, TURNS], law[FIRST_HARMONIC + j, TURNS_LOW], since, 0.0
        )
        # Of h^2 exp(i w s): the coefficients, and those before them for the factor s.
        now_re = h * h * turn[0]
        now_im = h * h * turn[1]
        before_re = 0.0
        before_im = 0.0
        a0 = u_re
        a1 = v_re * h
        b0 = u_im
        b1 = v_im * h
        u_re += a1
        v_re = a1
        u_im += b1
        v_im = b1
        order = 1.0
        for _ in range(terms):
            per = 1.0 / (order * (order + 1.0))
            a2 = (since * now_re + h * before_re - drag * order * a1 - spring * a0) * per
            b2 = (since * now_im + h * before_im - drag * order * b1 - spring * b0) * per
            before_re = now_re
            before_im = now_im
            share = omega * h / order
            now_re, now_im = -share * now_im, share * now_re
            order += 1.0
            u_re += a2
            v_re += order * a2
            u_im += b2
            v_im += order * b2
            a0 = a1
            a1 = a2
            b0 = b1
            b1 = b2
        v_re /= h
        v_im /= h
    return u_re, u_im, v_re, v_im


@kernel
def faded_response_to_late_phase(
    law: Law, region: int, j: int, s: float, count: int, terms: int
) -> tuple[float, float, float, float]:
    """Return what `response_to_late_phase` does, after the fast decay.

    With f = s exp(i w s) it is (u1 - u2) / (r1 - r2), where u' = r u + f: the slow part in
    ``count`` steps, and the fast one f / (i w - r2) - exp(i w s) / (i w - r2)^2.
    """
    harmonic = FIRST_HARMONIC + j
    omega = law[harmonic, OMEGA]
    slow, fast = law[region, SLOW_ROOT], law[region, FAST_ROOT]
    apart = 2.0 * law[region, RATE]
    h = s / count
    turn = slow * h
    u_re = 0.0
    u_im = 0.0
    for i in range(count):
        since = i * h
        now = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], since, 0.0)
        # Of h exp(i w s): the coefficients, and those before them for the factor s.
        now_re = h * now[0]
        now_im = h * now[1]
        before_re = 0.0
        before_im = 0.0
        a = u_re
        b = u_im
        order = 1.0
        for _ in range(terms):
            a = (turn * a + since * now_re + h * before_re) / order
            b = (turn * b + since * now_im + h * before_im) / order
            u_re += a
            u_im += b
            before_re = now_re
            before_im = now_im
            share = omega * h / order
            now_re, now_im = -share * now_im, share * now_re
            order += 1.0
    wave = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
    once = quotient(wave[0], wave[1], -fast, omega)
    twice = quotient(once[0], once[1], -fast, omega)
    fast_re = s * once[0] - twice[0]
    fast_im = s * once[1] - twice[1]
    v_re = slow * u_re + s * wave[0] - (once[0] - omega * fast_im)
    v_im = slow * u_im + s * wave[1] - (once[1] + omega * fast_re)
    return (u_re - fast_re) / apart, (u_im - fast_im) / apart, v_re / apart, v_im / apart


@formula
def is_plain(flight: Flight, s: float) -> bool:
    """Return whether the closed forms hold: poles apart, and phases that are not small."""
    law, region, _, _, _ = flight
    rate = law[region, RATE]
    if law[region, OVERDAMPED] == 1.0 or not rate * abs(s) > LEAST_PHASE:
        return False
    if not rate > LEAST_RATE * abs(law[region, DAMPING]):
        return False
    for j in range(flight.phases.shape[0]):
        if law[region + 1 + j, NEAR] == 1.0 and not is_record(law, j):
            return False
    return True


@formula
def plain_response_to_motion(
    flight: Flight, s: float, free: tuple[float, float, float], waves: Floats
) -> tuple[float, float, float]:
    """Return what `response_to_motion` does, in closed form, from S, c and D and the waves.

    With P = S * S, the response to S, the response to any response R to a force f is, since f
    makes R'' + 2 a R' + K R,

        S * R = (R - P' - (2 a + i w) P) / (K - w^2 + 2 i a w)   for f = exp(i w s).
    """
    law, region, start, phases, _ = flight
    impulse, even, rise = free
    damping = law[region, DAMPING]
    stiffness = law[region, STIFFNESS]
    _, _, v0, force = start
    square = 2.0 * law[region, RATE] * law[region, RATE]
    twice = (impulse - s * even) / square
    rate_of_twice = 0.5 * s * impulse - damping * twice
    of_rise = (rise - rate_of_twice - 2.0 * damping * twice) * law[region, PER_STIFFNESS]
    y = v0 * impulse + force * rise
    of_y = v0 * twice + force * of_rise
    of_v = v0 * rate_of_twice + force * twice
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        cos0 = phases[j, 0]
        sin0 = phases[j, 1]
        if is_record(law, j):
            ramp = slope_response(law, region, s, impulse, rise)
            of_ramp = (ramp - twice - 2.0 * damping * of_rise) * law[region, PER_STIFFNESS]
            y += cos0 * rise + sin0 * ramp
            of_y += cos0 * of_rise + sin0 * of_ramp
            of_v += cos0 * twice + sin0 * of_rise
            continue
        omega = law[harmonic, OMEGA]
        over_re = waves[j, TO_COS] - rate_of_twice - 2.0 * damping * twice
        over_im = waves[j, TO_SIN] - omega * twice
        gain_re = law[region + 1 + j, GAIN_RE]
        gain_im = law[region + 1 + j, GAIN_IM]
        to_cos = over_re * gain_re - over_im * gain_im
        to_sin = over_im * gain_re + over_re * gain_im
        part, quadrature = parts_of(law, harmonic, cos0, sin0)
        y += part * waves[j, TO_COS] + quadrature * waves[j, TO_SIN]
        of_y += part * to_cos + quadrature * to_sin
        of_v += part * (twice - omega * to_sin) + quadrature * omega * to_cos
    return of_y, of_v, y - 2.0 * damping * of_v - stiffness * of_y


@formula
def fill_wave(
    flight: Flight, j: int, s: float, free: tuple[float, float, float], wave: Floats
) -> tuple[float, float]:
    """Write the responses to cos(w s) and sin(w s), and their rates; return these two at s."""
    law, region, _, _, _ = flight
    harmonic = FIRST_HARMONIC + j
    omega = law[harmonic, OMEGA]
    turn = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
    to_cos, to_sin = harmonic_response(law, region, j, s, free[0], free[1], turn)
    wave[TO_COS] = to_cos
    wave[TO_SIN] = to_sin
    wave[RATES + TO_COS] = free[0] - omega * to_sin
    wave[RATES + TO_SIN] = omega * to_cos
    return turn


@kernel
def fill_late_wave(
    flight: Flight,
    j: int,
    s: float,
    free: tuple[float, float, float],
    turn: tuple[float, float],
    plain: bool,
    wave: Floats,
) -> None:
    """Write the responses to s cos(w s) and s sin(w s), and their rates.

    As the derivative of that to exp(i w s) by i w, with its gain G, in closed form
    W = G (s exp(i w s) - S - 2 (a + i w) Q).
    """
    law, region, _, _, _ = flight
    if not plain:
        late = response_to_late_phase(law, region, j, s)
        wave[TO_LATE_COS] = late[0]
        wave[TO_LATE_SIN] = late[1]
        wave[RATES + TO_LATE_COS] = late[2]
        wave[RATES + TO_LATE_SIN] = late[3]
        return
    omega = law[FIRST_HARMONIC + j, OMEGA]
    damping = law[region, DAMPING]
    gain_re = law[region + 1 + j, GAIN_RE]
    gain_im = law[region + 1 + j, GAIN_IM]
    rate = free[1] - damping * free[0]
    # First the response, then its rate.
    for k in range(0, RATES + 1, RATES):
        q_re = wave[k + TO_COS]
        q_im = wave[k + TO_SIN]
        push_re = s * turn[0] - free[0]
        push_im = s * turn[1]
        if k == RATES:
            push_re = turn[0] - omega * s * turn[1] - rate
            push_im = turn[1] + omega * s * turn[0]
        push_re -= 2.0 * (damping * q_re - omega * q_im)
        push_im -= 2.0 * (damping * q_im + omega * q_re)
        wave[k + TO_LATE_COS] = gain_re * push_re - gain_im * push_im
        wave[k + TO_LATE_SIN] = gain_re * push_im + gain_im * push_re


@formula
def respond(flight: Flight, s: float, change: Change, work: ColumnWorkspace) -> None:
    """Write the responses that the columns of a flight are made of, at a time s after its start."""
    law, region, _, _, _ = flight
    shared = work.shared
    free = free_response(law, region, s)
    impulse, even, rise = free
    drag = law[region, DAMPING] * impulse
    shared[XX] = even + drag
    shared[XV] = impulse
    shared[VX] = -law[region, STIFFNESS] * impulse
    shared[VV] = even - drag
    if s >= time_to_fade(law, region):
        # The slow part is left, set off by PULL (`sensitivity`).
        shared[XX] = 0.0
        shared[VX] = 0.0
        shared[VV] = law[region, SLOW_ROOT] * impulse
    shared[IMPULSE] = impulse
    shared[RISE] = rise
    shared[OF_Y] = 0.0
    shared[OF_V] = 0.0
    shared[RATE_OF_V] = 0.0
    rows = change.rows
    plain = is_plain(flight, s)
    motion_moves = False
    for p in range(rows.shape[0]):
        if rows[p, region, STIFFNESS] != 0.0 or rows[p, region, DAMPING] != 0.0:
            motion_moves = True
    for j in range(flight.phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        moves = False
        turns = False
        for p in range(rows.shape[0]):
            moves = moves or rows[p, harmonic, COSINE] != 0.0 or rows[p, harmonic, SINE] != 0.0
            turns = turns or rows[p, harmonic, OMEGA] != 0.0
        if is_record(law, j):
            shared[RAMP] = slope_response(law, region, s, impulse, rise)
        elif moves or turns or (motion_moves and plain):
            wave = work.waves[j]
            turn = fill_wave(flight, j, s, free, wave)
            for k in range(TO_LATE_COS, TO_LATE_SIN + 1):
                wave[k] = 0.0
                wave[RATES + k] = 0.0
            if turns:
                fill_late_wave(flight, j, s, free, turn, plain, wave)
    if motion_moves:
        of_motion = (0.0, 0.0, 0.0)
        if plain:
            of_motion = plain_response_to_motion(flight, s, free, work.waves)
        else:
            of_motion = response_to_motion(flight, s, work.series)
        shared[OF_Y], shared[OF_V], shared[RATE_OF_V] = of_motion


@formula
def moved_constant_force(law: Law, rows: Floats, region: int, x: float, moved: float) -> float:
    """Return the derivative of G - K x, with that of x; exactly zero where nothing moves it."""
    for bound, force in ((LOWER, LOWER_FORCE), (UPPER, UPPER_FORCE)):
        if x == law[region, bound]:
            return rows[region, force] - law[region, STIFFNESS] * (moved - rows[region, bound])
    pull = rows[region, ORIGIN_FORCE] - rows[region, STIFFNESS] * x
    return pull - law[region, STIFFNESS] * moved


@kernel
def moved_drive(
    law: Law, rows: Floats, unit: Law, t: float, t_low: float, phases: Floats
) -> tuple[float, float]:
    """Return the derivatives of the drive and of its rate at a fixed instant."""
    force = 0.0
    slope = 0.0
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        in_cos = rows[harmonic, COSINE]
        in_sin = rows[harmonic, SINE]
        turning = rows[harmonic, OMEGA]
        cosine = phases[j, 0]
        sine = phases[j, 1]
        if is_record(law, j):
            if in_cos != 0.0:
                value, rate = record_at(unit, t, t_low)
                force += in_cos * value
                slope += in_cos * rate
            force += turning * sine * t
            slope += turning * sine
            continue
        omega = law[harmonic, OMEGA]
        part, quadrature = parts_of(law, harmonic, cosine, sine)
        force += in_cos * cosine + in_sin * sine + turning * t * quadrature
        slope += omega * (in_sin * cosine - in_cos * sine)
        slope += turning * (quadrature - t * omega * part)
    return force, slope


@formula
def column_after(
    flight: Flight,
    rows: Floats,
    unit: Law,
    begin: tuple[float, float],
    force: float,
    work: ColumnWorkspace,
) -> tuple[float, float]:
    """Return the column of (y, v) where `respond` was asked, from that at the flight's start.

    ``force`` is the derivative of the constant force at the start.
    """
    law, region, start, phases, _ = flight
    t, t_low, _, _ = start
    shared = work.shared
    stiffer = rows[region, STIFFNESS]
    damped = 2.0 * rows[region, DAMPING]
    off = begin[0] * shared[XX] + begin[1] * shared[XV] + force * shared[RISE]
    speed = begin[0] * shared[VX] + begin[1] * shared[VV] + force * shared[IMPULSE]
    off -= stiffer * shared[OF_Y] + damped * shared[OF_V]
    speed -= stiffer * shared[OF_V] + damped * shared[RATE_OF_V]
    for j in range(phases.shape[0]):
        harmonic = FIRST_HARMONIC + j
        in_cos = rows[harmonic, COSINE]
        in_sin = rows[harmonic, SINE]
        turning = rows[harmonic, OMEGA]
        if in_cos == 0.0 and in_sin == 0.0 and turning == 0.0:
            continue
        cos0 = phases[j, 0]
        sin0 = phases[j, 1]
        if is_record(law, j):
            value, slope = record_at(unit, t, t_low)
            push = in_cos * value + turning * sin0 * t
            rate = in_cos * slope + turning * sin0
            off += push * shared[RISE] + rate * shared[RAMP]
            speed += push * shared[IMPULSE] + rate * shared[RISE]
            continue
        # d(C cos + S sin) with the phase's own change t dw: (t + s) (S cos - C sin) dw.
        force_part, slope_part = parts_of(law, harmonic, cos0, sin0)
        part = turning * slope_part
        quadrature = -turning * force_part
        in_phase = in_cos * cos0 + in_sin * sin0 + t * part
        across = in_sin * cos0 - in_cos * sin0 + t * quadrature
        wave = work.waves[j]
        off += in_phase * wave[TO_COS] + across * wave[TO_SIN]
        off += part * wave[TO_LATE_COS] + quadrature * wave[TO_LATE_SIN]
        speed += in_phase * wave[RATES + TO_COS] + across * wave[RATES + TO_SIN]
        speed += part * wave[RATES + TO_LATE_COS] + quadrature * wave[RATES + TO_LATE_SIN]
    return off, speed
