"""Runs: a motion meets its stops at these instants, and at no others.

Proven here: from a start that is given exactly a motion has the events of a certificate up to the
last of them, each at an instant and with velocities within the intervals that are claimed. Event
follows event, each proven to be the first after the one before. Section 11.5 of
docs/theory/certified.md.
"""

from __future__ import annotations

from typing import Any

from arithmetic import HopelessError, NotProvenError, angle, bits, of, with_first
from flights import Flight, Law, State, met
from words import near, phase_in_words, told

# Bits with which a run is tried.
RUN_BITS = (256, 512, 1024, 2048, 4096, 8192)


def proven_run(law: Law, text: Any) -> str:
    """Prove that a motion has these events and no others up to the last, each inside its intervals."""
    events, begin = text["events"], text["start"]
    if not events:
        raise NotProvenError("no event is claimed")

    def with_bits(n: int) -> None:
        with bits(n):
            _check_events(law, begin, events)

    with_first(RUN_BITS, with_bits)
    first, last = events[0]["t"], events[-1]["t"]
    return (
        f"The motion from x = {begin['x']}, v = {begin['v']} at t = {phase_in_words(begin['t'])} meets "
        f"the stops at {len(events)} instants and no others up to the last of them, the first between "
        f"{near(first)}, the last between {near(last)}; each instant and the velocities before "
        f"and after lie in the intervals of the certificate."
    )


def _check_events(law: Law, begin: Any, events: Any) -> None:
    state, number, departed = _start(law, begin)
    for k, claim in enumerate(events, start=1):
        event = met(Flight(law, number, state), departed)
        state, number, departed = event.after, event.region, event.bound
        if departed != claim["bound"]:
            raise HopelessError(f"event {k} is at bound {departed}")
        ours = {"t": state.t, "v_before": event.v_before, "v_after": state.v}
        for name, value in ours.items():
            low, high = value.fractions()
            least, most = claim[name]
            if high < least or low > most:
                raise HopelessError(f"{name} of event {k} is {told(low)}")
            if not (least <= low and high <= most):
                raise NotProvenError(f"{name} of event {k} is not known to the digits claimed")


def _start(law: Law, begin: Any) -> tuple[State, int, int | None]:
    """Return the start of a run, its region and the bound that it departs from."""
    x, v = begin["x"], begin["v"]
    state = State(angle(begin["t"]), of(x), of(v))
    for number in range(len(law.regions)):
        sides = [
            (bound, sign, sign * (law.bounds[bound].at - x)) for bound, sign in law.sides(number)
        ]
        if any(gap < 0 for _, _, gap in sides):
            continue
        departed, sign = next(((bound, sign) for bound, sign, gap in sides if gap == 0), (None, 0))
        flight = Flight(law, number, state)
        # From rest on a bound a motion goes where the force points, which is the same on both
        # sides.
        away = flight.acceleration(flight.force(of(0)), state.x, state.v) if v == 0 else of(v)
        if departed is None or (sign * away).high < 0:
            return state, number, departed
    raise NotProvenError("the start is beyond a wall, or stays on a stop")
