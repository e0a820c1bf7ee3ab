"""The modes between two events in closed form, and what the guards see of them.

A flight is given by its basis, the modes at its start and the phases of the loads there. Its
changes since the start are computed, not its values: a hop far below the rounding of the
displacements is resolved as far as the modes themselves allow.
"""

from __future__ import annotations

from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin, exponential
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import (
    ROUNDING,
    SERIES_LIMIT,
    free_response,
    harmonic_response,
    harmonic_size,
    slope_response,
)
from percuss.kernels.law_columns import (
    FIRST_HARMONIC,
    OMEGA,
    QUICKEST,
    TURNS,
    TURNS_LOW,
)
from percuss.kernels.structure.basis import (
    CONSTANT,
    DRAG,
    DRIVE_ENTRIES,
    FORCE,
    FORCE_COS,
    FORCE_SIN,
    GROWTH,
    HAS_RATES,
    IS_FED,
    OF_NORM,
    OF_U,
    OF_W,
    RATE,
    RATE_COS,
    RATE_SIN,
    ROOT,
    SPRING,
    SURGES,
    TWIST,
    WALK_ROWS,
    Basis,
    row_of,
)

# Columns of a flight's input into a mode: into w' and u', constant and slope.
PULL, SLOPE, DRIFT, DRIFT_SLOPE = range(4)
PULL_COLUMNS = 4
# Columns of a mode's state.
U, W = range(2)
# Rows of the rates of the modes: first and second derivatives, and the norm of the second ones.
U_FIRST, W_FIRST, U_SECOND, W_SECOND, NORM = range(5)
# From so many modes on they are taken in loops of one row each, which become vector instructions.
MANY = 12
# Columns of what is seen of a guard: value, slope, second derivative, bound of the fourth without
# the growth over the stretch, and the sums of the magnitudes of the terms of value and slope.
VALUE, SPEED, SECOND, BEND, SIZE, RATE_SIZE = range(6)
SEEN_COLUMNS = 6
# Terms of a mode's power series below these phases: what is left is less than 1e-17 of the sum.
FEW_TERMS, MORE_TERMS, MOST_TERMS = 8, 11, 17
SMALL, MIDDLE = 0.02, 0.12
# 1 / n for n = 1, 2, ...
INVERSES = tuple(1.0 / n for n in range(1, MOST_TERMS + 1))


class ModalFlight(NamedTuple):
    """A flight: its basis, the modes (n, 2), inputs (n, 4), phases (m, 2) and records (r, 2) at its start.

    ``values`` (s,) are the guards there: exactly 0 where ``order`` (s,), the number of derivatives
    that are known to vanish counted from the value, is positive, and known to -order where that is
    negative. ``later`` (n, 2), ``arrival``
    (m, 2) are scratch: modes and phases at the time last evaluated.
    """

    basis: Basis
    begin: Floats
    pull: Floats
    phases: Floats
    records: Floats
    values: Floats
    order: Floats
    later: Floats
    arrival: Floats
    at: Floats


@formula
def set_pull(flight: ModalFlight) -> None:
    """Fill the constant input into each mode, and its slope, from the records at the start."""
    basis = flight.basis
    for j in range(basis.modes.shape[0]):
        flight.pull[PULL, j] = basis.modes[j, FORCE]
        flight.pull[DRIFT, j] = basis.modes[j, RATE]
        flight.pull[SLOPE, j] = 0.0
        flight.pull[DRIFT_SLOPE, j] = 0.0
        for k in range(flight.records.shape[0]):
            into = basis.record_drive[j, k, 0]
            flight.pull[PULL, j] += into * flight.records[k, 0]
            flight.pull[SLOPE, j] += into * flight.records[k, 1]
            into = basis.record_drive[j, k, 1]
            flight.pull[DRIFT, j] += into * flight.records[k, 0]
            flight.pull[DRIFT_SLOPE, j] += into * flight.records[k, 1]


@formula
def move(flight: ModalFlight, s: float) -> None:
    """Write into ``later`` the changes of the modes a time s after the start, and the phases there."""
    basis, begin, pull, phases = flight.basis, flight.begin, flight.pull, flight.phases
    law = basis.law
    m = phases.shape[0]
    flight.at[0] = s
    fastest = 0.0
    for k in range(m):
        harmonic = FIRST_HARMONIC + k
        fastest = max(fastest, law[harmonic, OMEGA])
        cosine, sine = cos_sin(law[harmonic, TURNS], law[harmonic, TURNS_LOW], s, 0.0)
        flight.arrival[k, 0] = phases[k, 0] * cosine - phases[k, 1] * sine
        flight.arrival[k, 1] = phases[k, 1] * cosine + phases[k, 0] * sine
    for j in range(basis.modes.shape[0]):
        row = row_of(basis, j)
        spring = basis.modes[j, SPRING]
        drag = basis.modes[j, DRAG]
        phase = max(law[row, QUICKEST], fastest) * s
        if phase < SERIES_LIMIT:
            flight.later[j, U], flight.later[j, W] = early(flight, j, s, phase)
            continue
        u0 = begin[j, U]
        w0 = begin[j, W]
        impulse, even, rise = free_response(law, row, s)
        force = pull[PULL, j] - spring * u0
        u = force * rise
        w = (force - drag * w0) * impulse - spring * w0 * rise
        if pull[SLOPE, j] != 0.0 or pull[DRIFT_SLOPE, j] != 0.0:
            ramp = slope_response(law, row, s, impulse, rise)
            u += pull[SLOPE, j] * ramp + pull[DRIFT_SLOPE, j] * (rise + drag * ramp)
            w += pull[SLOPE, j] * rise - pull[DRIFT_SLOPE, j] * spring * ramp
        if basis.of_set[HAS_RATES] == 1.0:
            u += pull[DRIFT, j] * (impulse + drag * rise)
            w -= pull[DRIFT, j] * spring * rise
        for k in range(m):
            omega = law[FIRST_HARMONIC + k, OMEGA]
            cos0 = phases[k, 0]
            sin0 = phases[k, 1]
            turn = (
                flight.arrival[k, 0] * cos0 + flight.arrival[k, 1] * sin0,
                flight.arrival[k, 1] * cos0 - flight.arrival[k, 0] * sin0,
            )
            to_cos, to_sin = harmonic_response(law, row, k, s, impulse, even, turn)
            speed_cos = impulse - omega * to_sin
            speed_sin = omega * to_cos
            in_cos = basis.drive[j, k, FORCE_COS]
            in_sin = basis.drive[j, k, FORCE_SIN]
            in_phase = in_cos * cos0 + in_sin * sin0
            quadrature = in_sin * cos0 - in_cos * sin0
            u += in_phase * to_cos + quadrature * to_sin
            w += in_phase * speed_cos + quadrature * speed_sin
            if basis.of_set[HAS_RATES] == 1.0:
                in_cos = basis.drive[j, k, RATE_COS]
                in_sin = basis.drive[j, k, RATE_SIN]
                in_phase = in_cos * cos0 + in_sin * sin0
                quadrature = in_sin * cos0 - in_cos * sin0
                response = in_phase * to_cos + quadrature * to_sin
                u += in_phase * speed_cos + quadrature * speed_sin + drag * response
                w -= spring * response
        flight.later[j, U] = w0 * impulse + u
        flight.later[j, W] = w


@formula
def early(flight: ModalFlight, j: int, s: float, phase: float) -> tuple[float, float]:
    """Return the changes of a mode at a small phase, from its power series.

    That of the pair with all its inputs: the closed forms have a series for each response.
    """
    basis, pull, phases = flight.basis, flight.pull, flight.phases
    terms = MOST_TERMS if phase > MIDDLE else (MORE_TERMS if phase > SMALL else FEW_TERMS)
    spring = basis.modes[j, SPRING]
    drag = basis.modes[j, DRAG]
    has_rates = basis.of_set[HAS_RATES] == 1.0
    u = flight.begin[j, U]
    w = flight.begin[j, W]
    force = pull[PULL, j]
    rate = pull[DRIFT, j]
    next_force = pull[SLOPE, j] * s
    next_rate = pull[DRIFT_SLOPE, j] * s
    sum_u = 0.0
    sum_w = 0.0
    for k in range(max(1, phases.shape[0])):
        part = 0.0
        quadrature = 0.0
        of_rate = 0.0
        quadrature_of_rate = 0.0
        turn = 0.0
        if phases.shape[0] > 0:
            turn = basis.law[FIRST_HARMONIC + k, OMEGA] * s
            cosine = phases[k, 0]
            sine = phases[k, 1]
            in_cos = basis.drive[j, k, FORCE_COS]
            in_sin = basis.drive[j, k, FORCE_SIN]
            part = in_cos * cosine + in_sin * sine
            quadrature = in_sin * cosine - in_cos * sine
            if has_rates:
                in_cos = basis.drive[j, k, RATE_COS]
                in_sin = basis.drive[j, k, RATE_SIN]
                of_rate = in_cos * cosine + in_sin * sine
                quadrature_of_rate = in_sin * cosine - in_cos * sine
        # The n-th derivatives times s^n / n!; the first pass holds what is no harmonic as well.
        for n in range(terms):
            step = s * INVERSES[n]
            u, w = (
                step * (w + (rate + of_rate)),
                step * ((force + part) - (spring * u + drag * w)),
            )
            sum_u += u
            sum_w += w
            angle = turn * INVERSES[n]
            part, quadrature = angle * quadrature, -angle * part
            if has_rates:
                of_rate, quadrature_of_rate = angle * quadrature_of_rate, -angle * of_rate
            force = next_force
            rate = next_rate
            next_force = 0.0
            next_rate = 0.0
        u = 0.0
        w = 0.0
        force = 0.0
        rate = 0.0
    return sum_u, sum_w


@formula
def shift(flight: ModalFlight, s: float, step: float) -> None:
    """Move the modes last evaluated, at s, on by a step of a small phase."""
    basis = flight.basis
    for j in range(basis.modes.shape[0]):
        force, slope, bend, rate, rate_slope, rate_bend = inputs(
            basis, j, flight.arrival, flight.pull, s
        )
        spring = basis.modes[j, SPRING]
        drag = basis.modes[j, DRAG]
        u = flight.begin[j, U] + flight.later[j, U]
        w = flight.begin[j, W] + flight.later[j, W]
        u1 = w + rate
        w1 = force - spring * u - drag * w
        u2 = w1 + rate_slope
        w2 = slope - spring * u1 - drag * w1
        u3 = w2 + rate_bend
        w3 = bend - spring * u2 - drag * w2
        flight.later[j, U] += step * (u1 + step * (0.5 * u2 + step * (1.0 / 6.0) * u3))
        flight.later[j, W] += step * (w1 + step * (0.5 * w2 + step * (1.0 / 6.0) * w3))
    flight.at[0] = s + step


@formula
def arrive(flight: ModalFlight, s: float, modes: Floats) -> None:
    """Write into ``modes`` (n, 2) the modes a time s after the start."""
    if flight.at[0] != s:
        move(flight, s)
    for j in range(modes.shape[0]):
        modes[j, U] = flight.begin[j, U] + flight.later[j, U]
        modes[j, W] = flight.begin[j, W] + flight.later[j, W]


@formula
def inputs(
    basis: Basis, j: int, phases: Floats, pull: Floats, s: float
) -> tuple[float, float, float, float, float, float]:
    """Return the input into w' of a mode with its first two derivatives, and those into u'."""
    law = basis.law
    force = pull[PULL, j] + pull[SLOPE, j] * s
    slope = pull[SLOPE, j]
    bend = 0.0
    rate = pull[DRIFT, j] + pull[DRIFT_SLOPE, j] * s
    rate_slope = pull[DRIFT_SLOPE, j]
    rate_bend = 0.0
    for k in range(phases.shape[0]):
        omega = law[FIRST_HARMONIC + k, OMEGA]
        cosine = phases[k, 0]
        sine = phases[k, 1]
        in_cos = basis.drive[j, k, FORCE_COS]
        in_sin = basis.drive[j, k, FORCE_SIN]
        part = in_cos * cosine + in_sin * sine
        force += part
        slope += omega * (in_sin * cosine - in_cos * sine)
        bend -= omega * omega * part
        if basis.of_set[HAS_RATES] == 1.0:
            in_cos = basis.drive[j, k, RATE_COS]
            in_sin = basis.drive[j, k, RATE_SIN]
            part = in_cos * cosine + in_sin * sine
            rate += part
            rate_slope += omega * (in_sin * cosine - in_cos * sine)
            rate_bend -= omega * omega * part
    return force, slope, bend, rate, rate_slope, rate_bend


@formula
def fed(basis: Basis, i: int, phases: Floats, records: Floats, s: float, order: int) -> float:
    """Return the part of a guard, or of its derivative of that order, that the loads enter directly."""
    total = 0.0
    if basis.levels[i, IS_FED] == 0.0:
        return total
    for k in range(phases.shape[0]):
        in_cos = basis.feed[i, k, 0]
        in_sin = basis.feed[i, k, 1]
        part = in_cos * phases[k, 0] + in_sin * phases[k, 1]
        if order & 1:
            part = in_sin * phases[k, 0] - in_cos * phases[k, 1]
        scale = -1.0 if order & 2 else 1.0
        for _ in range(order):
            scale *= basis.law[FIRST_HARMONIC + k, OMEGA]
        total += scale * part
    for k in range(records.shape[0]):
        if order == 0:
            total += basis.record_feed[i, k] * (records[k, 0] + records[k, 1] * s)
        elif order == 1:
            total += basis.record_feed[i, k] * records[k, 1]
    return total


@formula
def arrive_in_rows(flight: ModalFlight, s: float, modes: Floats) -> None:
    """Write into the rows ``modes`` the modes a time s after the start."""
    if flight.at[0] != s:
        move(flight, s)
    for j in range(flight.begin.shape[0]):
        modes[U, j] = flight.begin[j, U] + flight.later[j, U]
        modes[W, j] = flight.begin[j, W] + flight.later[j, W]


@formula
def see(
    flight: ModalFlight, modes: Floats, phases: Floats, s: float, rates: Floats, seen: Floats
) -> None:
    """Write into ``seen`` (stops, 6) what the guards see of the ``modes`` at a time s.

    ``modes`` are rows; ``rates`` is scratch of five rows.
    """
    basis = flight.basis
    n = basis.modes.shape[0]
    if n < MANY:
        for j in range(n):
            force, slope, _, rate, rate_slope, _ = inputs(basis, j, phases, flight.pull, s)
            spring = basis.modes[j, SPRING]
            drag = basis.modes[j, DRAG]
            u1 = modes[W, j] + rate
            w1 = force - spring * modes[U, j] - drag * modes[W, j]
            u2 = w1 + rate_slope
            w2 = slope - spring * u1 - drag * w1
            rates[U_FIRST, j] = u1
            rates[W_FIRST, j] = w1
            rates[U_SECOND, j] = u2
            rates[W_SECOND, j] = w2
            rates[NORM, j] = basis.modes[j, ROOT] * abs(u2) + abs(w2)
    else:
        rates_of_many(flight, modes, phases, s, rates)
    for i in range(seen.shape[0]):
        value = basis.levels[i, CONSTANT]
        speed = 0.0
        second = 0.0
        bend = 0.0
        size = abs(value)
        rate_size = 0.0
        if basis.levels[i, IS_FED] == 1.0:
            value += fed(basis, i, phases, flight.records, s, 0)
            speed += fed(basis, i, phases, flight.records, s, 1)
            second += fed(basis, i, phases, flight.records, s, 2)
            size += abs(value)
        # Summed in registers: sums in an array would wait for their stores, mode by mode.
        for j in range(n):
            p = basis.guard[i, j, OF_U]
            q = basis.guard[i, j, OF_W]
            of_u = p * modes[U, j]
            of_w = q * modes[W, j]
            value += of_u + of_w
            size += abs(of_u) + abs(of_w)
            of_u = p * rates[U_FIRST, j]
            of_w = q * rates[W_FIRST, j]
            speed += of_u + of_w
            rate_size += abs(of_u) + abs(of_w)
            second += p * rates[U_SECOND, j] + q * rates[W_SECOND, j]
            bend += basis.guard[i, j, OF_NORM] * rates[NORM, j]
        seen[i, VALUE] = value
        seen[i, SPEED] = speed
        seen[i, SECOND] = second
        seen[i, BEND] = bend
        seen[i, SIZE] = size
        seen[i, RATE_SIZE] = rate_size


@formula
def rates_of_many(
    flight: ModalFlight, modes: Floats, phases: Floats, s: float, rates: Floats
) -> None:
    """Write the rates of the modes into rows: what `see` does for few modes, sum by sum the same.

    A loop writes one row: with two, the compiler would have to tell too many arrays apart.
    """
    basis = flight.basis
    n = basis.modes.shape[0]
    has_rates = basis.of_set[HAS_RATES] == 1.0
    spring = basis.walk[SPRING]
    drag = basis.walk[DRAG]
    root = basis.walk[ROOT]
    u = modes[U]
    w = modes[W]
    u1 = rates[U_FIRST]
    w1 = rates[W_FIRST]
    u2 = rates[U_SECOND]
    w2 = rates[W_SECOND]
    norm = rates[NORM]
    # At first the inputs into w' and u' and their slopes stand in the rows.
    write_line(flight.pull[PULL], flight.pull[SLOPE], s, w1)
    write_line(flight.pull[SLOPE], flight.pull[SLOPE], 0.0, w2)
    if has_rates:
        write_line(flight.pull[DRIFT], flight.pull[DRIFT_SLOPE], s, u1)
        write_line(flight.pull[DRIFT_SLOPE], flight.pull[DRIFT_SLOPE], 0.0, u2)
    for k in range(phases.shape[0]):
        omega = basis.law[FIRST_HARMONIC + k, OMEGA]
        at = WALK_ROWS + DRIVE_ENTRIES * k
        in_cos = basis.walk[at + FORCE_COS]
        in_sin = basis.walk[at + FORCE_SIN]
        add_wave(in_cos, in_sin, phases[k], omega, w1, w2)
        if has_rates:
            in_cos = basis.walk[at + RATE_COS]
            in_sin = basis.walk[at + RATE_SIN]
            add_wave(in_cos, in_sin, phases[k], omega, u1, u2)
    take_rates(w, has_rates, u1)
    for j in range(n):
        w1[j] = w1[j] - spring[j] * u[j] - drag[j] * w[j]
    take_rates(w1, has_rates, u2)
    for j in range(n):
        w2[j] = w2[j] - spring[j] * u1[j] - drag[j] * w1[j]
    for j in range(n):
        norm[j] = root[j] * abs(u2[j]) + abs(w2[j])


@formula
def add_wave(
    in_cos: Floats, in_sin: Floats, phase: Floats, omega: float, row: Floats, slope: Floats
) -> None:
    """Add what a harmonic puts into the modes to a row, and its rate to another."""
    cosine = phase[0]
    sine = phase[1]
    for j in range(row.shape[0]):
        row[j] += in_cos[j] * cosine + in_sin[j] * sine
    for j in range(row.shape[0]):
        slope[j] += omega * (in_sin[j] * cosine - in_cos[j] * sine)


@formula
def take_rates(rates: Floats, has_inputs: bool, row: Floats) -> None:
    """Write rates into a row, in which the inputs to be added stand if there are any."""
    if has_inputs:
        for j in range(row.shape[0]):
            row[j] = rates[j] + row[j]
    else:
        for j in range(row.shape[0]):
            row[j] = rates[j]


@formula
def write_line(at_start: Floats, slope: Floats, s: float, row: Floats) -> None:
    """Write a constant and a slope over a time into a row."""
    for j in range(at_start.shape[0]):
        row[j] = at_start[j] + slope[j] * s


@kernel
def derivatives(
    flight: ModalFlight, i: int, s: float, is_begin: bool
) -> tuple[float, float, float, float, float, float]:
    """Return a guard with its first four derivatives, and what `fourth_bound` takes for its bend.

    ``later`` and ``arrival`` are those at s, or those of the start are taken.
    """
    return derivatives_here(flight, i, s, is_begin)


@formula
def derivatives_here(
    flight: ModalFlight, i: int, s: float, is_begin: bool
) -> tuple[float, float, float, float, float, float]:
    """Return what `derivatives` does, written out: to pass a flight takes as long as this."""
    basis = flight.basis
    phases = flight.phases if is_begin else flight.arrival
    y = flight.values[i]
    if not is_begin and basis.levels[i, IS_FED] == 1.0:
        y += fed(basis, i, phases, flight.records, s, 0)
        y -= fed(basis, i, flight.phases, flight.records, 0.0, 0)
    first = fed(basis, i, phases, flight.records, s, 1)
    second = fed(basis, i, phases, flight.records, s, 2)
    third = fed(basis, i, phases, flight.records, s, 3)
    fourth = fed(basis, i, phases, flight.records, s, 4)
    bound = 0.0
    for j in range(basis.modes.shape[0]):
        force, slope, bend, rate, rate_slope, rate_bend = inputs(basis, j, phases, flight.pull, s)
        # Third and fourth derivatives of the harmonics' input.
        twist = 0.0
        rate_twist = 0.0
        for k in range(phases.shape[0]):
            omega = basis.law[FIRST_HARMONIC + k, OMEGA]
            cube = omega * omega * omega
            cosine = phases[k, 0]
            sine = phases[k, 1]
            twist -= cube * (
                basis.drive[j, k, FORCE_SIN] * cosine - basis.drive[j, k, FORCE_COS] * sine
            )
            rate_twist -= cube * (
                basis.drive[j, k, RATE_SIN] * cosine - basis.drive[j, k, RATE_COS] * sine
            )
        spring = basis.modes[j, SPRING]
        drag = basis.modes[j, DRAG]
        u = flight.begin[j, U]
        w = flight.begin[j, W]
        p = basis.guard[i, j, OF_U]
        q = basis.guard[i, j, OF_W]
        if not is_begin:
            y += p * flight.later[j, U] + q * flight.later[j, W]
            u += flight.later[j, U]
            w += flight.later[j, W]
        u1 = w + rate
        w1 = force - spring * u - drag * w
        u2 = w1 + rate_slope
        w2 = slope - spring * u1 - drag * w1
        u3 = w2 + rate_bend
        w3 = bend - spring * u2 - drag * w2
        u4 = w3 + rate_twist
        w4 = twist - spring * u3 - drag * w3
        first += p * u1 + q * w1
        second += p * u2 + q * w2
        third += p * u3 + q * w3
        fourth += p * u4 + q * w4
        bound += basis.guard[i, j, OF_NORM] * (basis.modes[j, ROOT] * abs(u2) + abs(w2))
    return y, first, second, third, fourth, bound


@formula
def fourth_bound(basis: Basis, i: int, bend: float, width: float) -> float:
    """Return a bound of a guard's fourth derivative over a stretch that begins with ``bend``."""
    growth = 1.0
    if basis.of_set[GROWTH] > 0.0:
        growth = exponential(basis.of_set[GROWTH] * width)
    return basis.levels[i, TWIST] + growth * (bend + width * basis.levels[i, SURGES])


@kernel
def uncertainty(flight: ModalFlight, i: int, s: float) -> float:
    """Return a bound on the rounding error of a guard a time s after the start.

    It is that of its terms, each taken at the sum of the magnitudes of its parts. A guard that
    begins at exactly zero has no error of its value there.
    """
    basis, law = flight.basis, flight.basis.law
    size = abs(flight.values[i])
    if basis.levels[i, IS_FED] == 1.0:
        for k in range(flight.phases.shape[0]):
            size += abs(basis.feed[i, k, 0]) + abs(basis.feed[i, k, 1])
        for k in range(flight.records.shape[0]):
            push = abs(flight.records[k, 0]) + abs(flight.records[k, 1] * s)
            size += abs(basis.record_feed[i, k]) * push
    known = max(0.0, -flight.order[i])
    if flight.order[i] == 0.0:
        size += abs(basis.levels[i, CONSTANT])
    for j in range(basis.modes.shape[0]):
        row = row_of(basis, j)
        p = abs(basis.guard[i, j, OF_U])
        q = abs(basis.guard[i, j, OF_W])
        spring = abs(basis.modes[j, SPRING])
        drag = abs(basis.modes[j, DRAG])
        u0 = abs(flight.begin[j, U])
        w0 = abs(flight.begin[j, W])
        impulse, even, rise = free_response(law, row, s)
        impulse = abs(impulse)
        rise = abs(rise)
        ramp = 0.0
        if flight.pull[SLOPE, j] != 0.0 or flight.pull[DRIFT_SLOPE, j] != 0.0:
            ramp = abs(slope_response(law, row, s, impulse, rise))
        force = abs(flight.pull[PULL, j]) + spring * u0
        slope = abs(flight.pull[SLOPE, j])
        of_u = w0 * impulse + force * rise + slope * ramp
        of_w = (force + drag * w0) * impulse + spring * w0 * rise + slope * rise
        if basis.of_set[HAS_RATES] == 1.0:
            drift = abs(flight.pull[DRIFT, j])
            slope = abs(flight.pull[DRIFT_SLOPE, j])
            of_u += drift * (impulse + drag * rise) + slope * (rise + drag * ramp)
            of_w += spring * (drift * rise + slope * ramp)
        for k in range(flight.phases.shape[0]):
            omega = law[FIRST_HARMONIC + k, OMEGA]
            limit = harmonic_size(law, row, k, s, impulse, even)
            amplitude = abs(basis.drive[j, k, FORCE_COS]) + abs(basis.drive[j, k, FORCE_SIN])
            of_u += amplitude * limit
            of_w += amplitude * (impulse + omega * limit)
            amplitude = abs(basis.drive[j, k, RATE_COS]) + abs(basis.drive[j, k, RATE_SIN])
            of_u += amplitude * (impulse + (omega + drag) * limit)
            of_w += amplitude * spring * limit
        if flight.order[i] == 0.0:
            of_u += u0
            of_w += w0
        size += p * of_u + q * of_w
    return known + ROUNDING * size * (1.0 + basis.of_set[GROWTH] * s / 16.0)
