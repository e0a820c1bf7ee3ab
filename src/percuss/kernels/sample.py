"""The motion at any instants, from the record of events."""

from __future__ import annotations

import math

from percuss.arrays import Floats, Integers
from percuss.kernels.arithmetic import ULP, cos_sin, exponential, logarithm, turns
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import (
    Flight,
    force_and_slopes,
    move,
    parts_of,
    set_phases,
    uncertainty,
)
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    GAIN_RE,
    GAP_IM,
    GAP_RE,
    HALF_TURNS,
    HALF_TURNS_LOW,
    LOWER,
    N_HARMONICS,
    NEAR,
    OMEGA,
    OVERDAMPED,
    PER_STIFFNESS,
    PERIOD,
    PERIOD_TURNS,
    PERIOD_TURNS_LOW,
    QUICKEST,
    SIMPLE,
    TURNS,
    TURNS_LOW,
    TWICE_PER_RATE,
    UPPER,
    Law,
)
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    NEXT_REGION,
    V_AFTER,
    V_BEFORE,
    MotionRecord,
    flight_after,
    place_of_event,
    time_since_event,
)
from percuss.kernels.restitution import restitution_at

# Below this phase the fast formula would lose more than three digits of what the force has done
# (1 / phase**2 ulp of it), which shows in a hop that is slow from its start.
EARLY = 1.0 / 16.0


@kernel
def flight_at(events: Floats, t: float, after: bool) -> int:
    """Return the number of the event from which the motion at t comes.

    ``after`` takes the last event not later than t, else the last one before it.
    """
    low = 0
    high = events.shape[0]
    while high - low > 1:
        middle = (low + high) // 2
        time = events[middle, EVENT_T]
        if time < t or (after and time == t):
            low = middle
        else:
            high = middle
    return low


@kernel
def evaluate(
    record: MotionRecord,
    instants: Floats,
    after: bool,
    phases: Floats,
    arrival: Floats,
    motion: Floats,
) -> None:
    """Write x and v at each of ``instants`` (n,) into ``motion`` (2, n)."""
    events = record.events
    i = 0
    while i < instants.shape[0]:
        event = flight_at(events, instants[i], after)
        # Instants that follow within the same flight are taken together.
        end = i + 1
        until = events[event + 1, EVENT_T] if event + 1 < events.shape[0] else math.inf
        while end < instants.shape[0] and instants[i] <= instants[end] < until:
            end += 1
        fill(record, event, instants, (i, end), phases, arrival, motion)
        i = end


@kernel
def fill(
    record: MotionRecord,
    event: int,
    instants: Floats,
    rows: tuple[int, int],
    phases: Floats,
    arrival: Floats,
    motion: Floats,
) -> None:
    """Write x and v at those instants, first to last, of one flight or contact from an event."""
    law, events, marks = record.law, record.events, record.marks
    x = place_of_event(record, event)
    flight = flight_after(record, event, phases, arrival)
    region = flight.region
    t, t_low, v0, _ = flight.start
    moving = marks[event, KIND] != CONTACT
    soonest = math.inf
    if is_tail(events, marks, event):
        fill_tail(record, x, event, instants, rows, motion)
        return
    if moving and is_plain(law, region):
        soonest = EARLY / min(law[region, QUICKEST], law[FIRST_HARMONIC, OMEGA])
        undamped_motion(flight, instants, rows, motion)
    for i in range(rows[0], rows[1]):
        # At the event's own float the motion is that of the event.
        s = (instants[i] - t) - t_low if instants[i] != t else 0.0
        if not s > soonest:
            y = 0.0
            v = v0
            if moving and s > 0.0:
                y, v = move(flight, s)
            motion[0, i] = y
            motion[1, i] = v
        motion[0, i] += x
        # Between two events nothing lies beyond a bound but by rounding, and in formal orbits.
        bound = min(max(motion[0, i], law[region, LOWER]), law[region, UPPER])
        excess = abs(motion[0, i] - bound)
        if excess > 0.0:
            doubt = 0.0
            if s > 0.0:
                doubt = uncertainty(flight, s)
            if excess <= doubt + ULP * abs(bound):
                motion[0, i] = bound


@kernel
def is_tail(events: Floats, marks: Integers, row: int) -> bool:
    """Return whether what follows an event is the summed tail of a chatter."""
    if marks[row, KIND] != IMPACT or events[row, V_AFTER] == 0.0:
        return False
    return row + 1 < events.shape[0] and bool(marks[row + 1, KIND] == CONTACT)


@kernel
def fill_tail(
    record: MotionRecord,
    x: float,
    event: int,
    instants: Floats,
    rows: tuple[int, int],
    motion: Floats,
) -> None:
    """Write x and v at those instants between a chatter's last listed impact and its end."""
    law, events, marks = record.law, record.events, record.marks
    region = int(marks[event, NEXT_REGION])
    # That of the slow impacts of the tail.
    restitution = restitution_at(law, region, int(marks[event, BOUND]), abs(events[event, V_AFTER]))
    t = events[event, EVENT_T]
    t_low = events[event, EVENT_T_LOW]
    whole = time_since_event(events, event + 1)
    for i in range(rows[0], rows[1]):
        s = (instants[i] - t) - t_low if instants[i] != t else 0.0
        y, v = tail_hop(restitution, events[event, V_AFTER], whole, s)
        motion[0, i] = x + y
        motion[1, i] = v


@kernel
def tail_hop(restitution: float, v0: float, whole: float, s: float) -> tuple[float, float]:
    """Return (y, v) a time s after the last listed impact of a chatter that ends at ``whole``.

    The hops of the tail, which are summed and not listed, last and rise less by the restitution
    from one to the next; so far they are exact to CHATTER_LIMIT of their own size.
    """
    share, since = hop_of_tail(restitution, whole, s)
    duration = whole * share * (1.0 - restitution)
    if duration == 0.0:
        return 0.0, 0.0
    part = min(max(since / duration, 0.0), 1.0)
    v = v0 * share
    return v * duration * part * (1.0 - part), v * (1.0 - 2.0 * part)


@kernel
def hop_of_tail(restitution: float, whole: float, s: float) -> tuple[float, float]:
    """Return the share of the hop of a chatter's tail at a time s, and the time since its start.

    The share is that of its duration and velocity in those of the first hop, 0 after the end.
    """
    left = 1.0 - s / whole
    if not left > 0.0:
        return 0.0, 0.0
    count = max(0, int(logarithm(left) / logarithm(restitution)))
    share = exponential(count * logarithm(restitution))
    # The hop in which s lies, whatever the last digit of the logarithms.
    if left > share and count > 0:
        count -= 1
        share = exponential(count * logarithm(restitution))
    elif left <= share * restitution:
        share *= restitution
    return share, s - whole * (1.0 - share)


@kernel
def is_plain(law: Law, region: int) -> bool:
    """Return whether a region has one harmonic and no damping, off resonance or exactly in it."""
    if law[0, N_HARMONICS] != 1.0 or law[region, DAMPING] != 0.0:
        return False
    return law[region, SIMPLE] == 1.0 or is_resonant(law, region)


@kernel
def is_resonant(law: Law, region: int) -> bool:
    """Return whether the only harmonic has the frequency of an undamped motion."""
    near = law[region, OVERDAMPED] == 0.0 and law[region + 1, NEAR] == 1.0
    return near and law[region + 1, GAP_RE] == 0.0 and law[region + 1, GAP_IM] == 0.0


@kernel
def undamped_motion(
    flight: Flight, instants: Floats, rows: tuple[int, int], motion: Floats
) -> None:
    """Write y and v at each of ``instants`` for one harmonic without damping.

    Numbers in registers, no branches and no series: what lies within a small phase of the start
    has lost digits here.
    """
    law, region, start, phases, _ = flight
    t, t_low, v0, force = start
    amplitude = law[region + 1, GAIN_RE]
    push, rate = parts_of(law, FIRST_HARMONIC, phases[0, 0], phases[0, 1])
    omega = law[FIRST_HARMONIC, OMEGA]
    turn = law[FIRST_HARMONIC, TURNS]
    turn_low = law[FIRST_HARMONIC, TURNS_LOW]
    half_turn = law[region, HALF_TURNS]
    half_turn_low = law[region, HALF_TURNS_LOW]
    per_rate = law[region, TWICE_PER_RATE]
    per_stiffness = law[region, PER_STIFFNESS]
    resonant = is_resonant(law, region)
    # Views that begin at 0: with an index that may be negative the loop would be no vectors.
    given = instants[rows[0] : rows[1]]
    y = motion[0, rows[0] : rows[1]]
    v = motion[1, rows[0] : rows[1]]
    for i in range(given.shape[0]):
        s = (given[i] - t) - t_low
        half_cos, half_sin = cos_sin(half_turn, half_turn_low, s, 0.0)
        square = 2.0 * half_sin * half_sin
        impulse = half_sin * half_cos * per_rate
        if resonant:
            to_push = 0.5 * s * impulse
            to_rate = 0.25 * per_rate * (impulse - s * (1.0 - square))
        else:
            cosine, sine = cos_sin(turn, turn_low, s, 0.0)
            to_push = (cosine - (1.0 - square)) * amplitude
            to_rate = (sine - omega * impulse) * amplitude
        moved = force * square * per_stiffness + push * to_push + rate * to_rate
        y[i] = v0 * impulse + moved
        won = force * impulse + push * (impulse - omega * to_rate) + rate * omega * to_push
        v[i] = v0 * (1.0 - square) + won


@kernel
def cycles(law: Law, t: Floats, t_low: Floats, out: Floats) -> None:
    """Write the cycle of each instant, (t / period) mod 1, into ``out``."""
    for i in range(t.shape[0]):
        out[i] = cycle_of(law[0, PERIOD_TURNS], law[0, PERIOD_TURNS_LOW], t[i], t_low[i])


@kernel
def impact_columns(
    law: Law, events: Floats, marks: Integers, out: Floats, bounds: Integers
) -> None:
    """Write what is asked of impacts, of which there are as many as columns of ``out`` (5, n).

    Its rows are the instant, the velocities before and after, the cycle, which is NaN without a
    period, and the time since the impact, or start, before. ``bounds`` receive those they meet.
    """
    rate = law[0, PERIOD_TURNS]
    rate_low = law[0, PERIOD_TURNS_LOW]
    has_period = law[0, PERIOD] > 0.0
    before = 0
    n = 0
    for i in range(1, events.shape[0]):
        if marks[i, KIND] != IMPACT:
            continue
        t = events[i, EVENT_T]
        t_low = events[i, EVENT_T_LOW]
        out[0, n] = t
        out[1, n] = events[i, V_BEFORE]
        out[2, n] = events[i, V_AFTER]
        out[3, n] = cycle_of(rate, rate_low, t, t_low) if has_period else math.nan
        since = t - events[before, EVENT_T]
        out[4, n] = since + (t_low - events[before, EVENT_T_LOW])
        bounds[n] = marks[i, BOUND]
        before = i
        n += 1


@formula
def cycle_of(rate: float, rate_low: float, t: float, t_low: float) -> float:
    """Return the cycle of an instant, from the period's turns per time."""
    part = turns(rate, rate_low, t, t_low)
    part = part + 1.0 if part < 0.0 else part
    # A rounding below a whole turn is that turn.
    return part if part < 1.0 else 0.0


@kernel
def drive(law: Law, instants: Floats, phases: Floats, out: Floats) -> None:
    """Write the harmonic part of the force at each of ``instants`` into ``out``."""
    for i in range(instants.shape[0]):
        set_phases(law, instants[i], 0.0, phases)
        out[i] = force_and_slopes(law, phases)[0]
