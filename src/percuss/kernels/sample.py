"""The motion at any instants, from the record of events."""

from __future__ import annotations

from percuss.kernels.compile import kernel
from percuss.kernels.doubled import turns
from percuss.kernels.flight import constant_force, force_derivative, move, set_phases
from percuss.kernels.law import LOWER, NUMBER, PERIOD_TURNS, PERIOD_TURNS_LOW, UPPER, Law, Table
from percuss.kernels.march import (
    BOUND,
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    KIND,
    NEXT_REGION,
    RELEASE,
    START,
    V_AFTER,
    Integers32,
)


@kernel
def flight_at(events: Table, t: float, after: bool, guess: int) -> int:
    """Return the number of the event from which the motion at t comes.

    ``after`` takes the last event not later than t, else the last one before it. ``guess`` is
    where to look first: instants mostly come in order.
    """
    low = 0
    high = events.shape[0]
    if events[guess, EVENT_T] < t:
        low = guess
        if guess + 1 < high and t < events[guess + 1, EVENT_T]:
            return guess
    # The event is `low`, or between it and `high`.
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
    marks: Integers32,
    x0: float,
    instants: Table,
    after: bool,
    phases: Table,
    arrival: Table,
    motion: Table,
) -> None:
    """Write x and v at each of ``instants`` (n,) into ``motion`` (2, n)."""
    event = 0
    known = -1
    x = 0.0
    v = 0.0
    force = 0.0
    for i in range(instants.shape[0]):
        event = flight_at(events, instants[i], after, event)
        region = int(marks[event, NEXT_REGION])
        if event != known:
            known = event
            x = x0
            if marks[event, KIND] != START:
                side = LOWER if marks[event, BOUND] == law[region, NUMBER] else UPPER
                x = law[region, side]
            v = events[event, V_AFTER]
            set_phases(law, events[event, EVENT_T], events[event, EVENT_T_LOW], phases)
            force = constant_force(law, region, x)
            if marks[event, KIND] == RELEASE:
                force = -force_derivative(law, phases, 0)
        motion[0, i] = x
        motion[1, i] = v
        s = (instants[i] - events[event, EVENT_T]) - events[event, EVENT_T_LOW]
        if marks[event, KIND] != CONTACT and s > 0.0:
            y, motion[1, i] = move(
                law, region, (events[event, EVENT_T], 0.0, v, force), phases, s, arrival
            )
            motion[0, i] = x + y


@kernel
def cycles(law: Law, t: Table, t_low: Table, out: Table) -> None:
    """Write the cycle of each instant, (t / period) mod 1, into ``out``."""
    for i in range(t.shape[0]):
        part = turns(law[0, PERIOD_TURNS], law[0, PERIOD_TURNS_LOW], t[i], t_low[i])
        if part < 0.0:
            part += 1.0
        out[i] = part if part < 1.0 else 0.0


@kernel
def drive(law: Law, instants: Table, phases: Table, out: Table) -> None:
    """Write the harmonic part of the force at each of ``instants`` into ``out``."""
    for i in range(instants.shape[0]):
        set_phases(law, instants[i], 0.0, phases)
        out[i] = force_derivative(law, phases, 0)
