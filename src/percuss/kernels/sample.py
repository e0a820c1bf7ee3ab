"""The motion at any instants, from the record of events."""

from __future__ import annotations

import math

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import turns
from percuss.kernels.flight import constant_force, force_and_slopes, move, set_phases
from percuss.kernels.law import (
    COSINE,
    FIRST_HARMONIC,
    LOWER,
    NUMBER,
    OMEGA,
    PERIOD_TURNS,
    PERIOD_TURNS_LOW,
    QUICKEST,
    SIMPLE,
    SINE,
    UPPER,
    Law,
    Table,
)
from percuss.kernels.plain import plain_state
from percuss.kernels.record import (
    BOUND,
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    KIND,
    NEXT_REGION,
    RELEASE,
    START,
    V_AFTER,
    Integers,
)
from percuss.kernels.response import SERIES_LIMIT


@kernel
def flight_at(events: Table, t: float, after: bool) -> int:
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
    law: Law,
    events: Table,
    marks: Integers,
    x0: float,
    instants: Table,
    after: bool,
    phases: Table,
    arrival: Table,
    motion: Table,
) -> None:
    """Write x and v at each of ``instants`` (n,) into ``motion`` (2, n)."""
    i = 0
    while i < instants.shape[0]:
        event = flight_at(events, instants[i], after)
        # Instants that follow within the same flight are taken together.
        end = i + 1
        until = events[event + 1, EVENT_T] if event + 1 < events.shape[0] else math.inf
        while end < instants.shape[0] and instants[i] <= instants[end] < until:
            end += 1
        fill(law, events, marks, x0, event, instants[i:end], phases, arrival, motion[:, i:end])
        i = end


@kernel
def fill(
    law: Law,
    events: Table,
    marks: Integers,
    x0: float,
    event: int,
    instants: Table,
    phases: Table,
    arrival: Table,
    motion: Table,
) -> None:
    """Write x and v at instants of one flight, or contact, that begins with an event."""
    region = int(marks[event, NEXT_REGION])
    t = events[event, EVENT_T]
    t_low = events[event, EVENT_T_LOW]
    v0 = events[event, V_AFTER]
    x = x0
    if marks[event, KIND] != START:
        x = law[region, LOWER if marks[event, BOUND] == law[region, NUMBER] else UPPER]
    set_phases(law, t, t_low, phases)
    force = constant_force(law, region, x)
    if marks[event, KIND] == RELEASE:
        force = -force_and_slopes(law, phases)[0]
    simple = law[region, SIMPLE] == 1.0 and marks[event, KIND] != CONTACT
    soonest = math.inf
    if simple:
        soonest = SERIES_LIMIT / min(law[region, QUICKEST], law[FIRST_HARMONIC, OMEGA])
    push = 0.0
    rate = 0.0
    if simple:
        push = law[FIRST_HARMONIC, COSINE] * phases[0, 0] + law[FIRST_HARMONIC, SINE] * phases[0, 1]
        rate = law[FIRST_HARMONIC, SINE] * phases[0, 0] - law[FIRST_HARMONIC, COSINE] * phases[0, 1]
    for i in range(instants.shape[0]):
        # At the event's own float the motion is that of the event.
        s = (instants[i] - t) - t_low if instants[i] != t else 0.0
        y = 0.0
        v = v0
        if s > soonest:
            y, kept, won, _, _ = plain_state(law, region, (force, push, rate, v0), s)
            v = kept + won
        elif marks[event, KIND] != CONTACT and s > 0.0:
            y, v = move(law, region, (t, t_low, v0, force), phases, s, arrival)
        motion[0, i] = x + y
        motion[1, i] = v


@kernel
def cycles(law: Law, t: Table, t_low: Table, out: Table) -> None:
    """Write the cycle of each instant, (t / period) mod 1, into ``out``."""
    for i in range(t.shape[0]):
        part = turns(law[0, PERIOD_TURNS], law[0, PERIOD_TURNS_LOW], t[i], t_low[i])
        if part < 0.0:
            part += 1.0
        # A rounding below a whole turn is that turn.
        out[i] = part if part < 1.0 else 0.0


@kernel
def drive(law: Law, instants: Table, phases: Table, out: Table) -> None:
    """Write the harmonic part of the force at each of ``instants`` into ``out``."""
    for i in range(instants.shape[0]):
        set_phases(law, instants[i], 0.0, phases)
        out[i] = force_and_slopes(law, phases)[0]
