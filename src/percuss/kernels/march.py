"""A motion from event to event, from one state to the limits of a run."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import Pair, later
from percuss.kernels.compile import cold, formula, kernel
from percuss.kernels.contact import FORCE_ROUNDING, chatter_time, push, release_time
from percuss.kernels.event_location import GRAZE, NONE, is_fast, rest_at_landing
from percuss.kernels.flight import Flight, constant_force, force_and_slopes, move, set_phases
from percuss.kernels.harmonic_flight import harmonic_flights
from percuss.kernels.law_columns import (
    EDGE,
    FIRST_HARMONIC,
    FORCE_BOUND,
    HARMONIC,
    LOWER,
    LOWER_ENTRY,
    LOWER_FORCE,
    LOWER_KIND,
    NUMBER,
    PERIOD,
    UPPER,
    UPPER_ENTRY,
    UPPER_FORCE,
    UPPER_KIND,
    WALL,
)
from percuss.kernels.next_event import PAUSE, NextEvent, next_event
from percuss.kernels.pieces import next_knot, time_to_knot
from percuss.kernels.record import (
    AT_REST,
    BOUND,
    CARRIED_T,
    CONTACT,
    CONTACT_UNTIL,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    FASTEST,
    FORCE,
    FREE_ABOVE,
    FREE_BELOW,
    FULL,
    GRAZE_BOUND,
    GRAZE_CLEARANCE,
    GRAZE_ERROR,
    GRAZE_T,
    GRAZE_T_LOW,
    HELD,
    HUGE,
    IMPACT,
    KIND,
    KNOT,
    MOVING,
    N_EVENTS,
    N_GRAZES,
    N_IMPACTS,
    NEXT_REGION,
    NO_MORE,
    OVERFLOW,
    REACHED_END,
    REACHED_LIMIT,
    REGION,
    RELEASE,
    SLOW_LANDING,
    SPENT,
    START,
    T_LOW,
    TOUCHED,
    V_AFTER,
    V_BEFORE,
    Run,
    T,
    V,
    X,
)
from percuss.kernels.restitution import restitution_at

# More than the rounding of a sum of times between knots, as a factor.
LONGER = 1.01
# Harmonic impacts between two checks of the patience.
PLAIN_AT_ONCE = 10_000


@kernel
def march(run: Run, t_end: float, max_impacts: int, patience: int) -> int:
    """Go on from event to event, or begin; return why it stopped.

    ``patience`` bounds the searches before control returns to the caller (SPENT).
    """
    law, state, counters, events, grazes = run.law, run.state, run.counters, run.events, run.grazes
    if counters[N_EVENTS] == 0:
        begin(run)
    status = MOVING
    is_harmonic = law[counters[REGION], HARMONIC] == 1.0
    while status == MOVING:
        if counters[N_EVENTS] + 2 > len(events) or counters[N_GRAZES] + 1 > len(grazes):
            return FULL
        if patience == 0:
            return SPENT
        patience -= 1
        if is_harmonic and counters[TOUCHED] == 0 and state[FREE_BELOW] + state[FREE_ABOVE] == 0.0:
            skip_ahead(run, t_end, max_impacts)
            if counters[N_IMPACTS] >= max_impacts:
                return REACHED_LIMIT
        if counters[N_EVENTS] + 2 > len(events):
            return FULL
        status = stay(run, t_end) if counters[TOUCHED] != 0 else fly(run, t_end)
        if counters[N_IMPACTS] >= max_impacts and status == MOVING:
            return REACHED_LIMIT
    return status


@kernel
def skip_ahead(run: Run, t_end: float, max_impacts: int) -> None:
    """Make the impacts of harmonic flights, from a state on the wall with velocity off it."""
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    events, marks = run.events, run.marks
    region = counters[REGION]
    sign = 1.0 if law[region, LOWER_KIND] == WALL else -1.0
    wall = law[region, LOWER if sign > 0.0 else UPPER]
    if state[X] != wall or not sign * state[V] > 0.0:
        return
    first = counters[N_EVENTS]
    last = min(len(events) - 2, first + min(max_impacts - counters[N_IMPACTS], PLAIN_AT_ONCE))
    made = harmonic_flights(law, region, state, t_end, phases, events, first, last)
    if made == 0:
        return
    bound = int(law[region, NUMBER]) + (0 if sign > 0.0 else 1)
    for i in range(first, first + made):
        marks[i, KIND] = IMPACT
        marks[i, BOUND] = bound
        marks[i, NEXT_REGION] = region
    counters[N_EVENTS] += made
    counters[N_IMPACTS] += made
    state[FORCE] = law[region, LOWER_FORCE if sign > 0.0 else UPPER_FORCE]
    set_phases(law, state[T], state[T_LOW], phases)


@kernel
def begin(run: Run) -> None:
    """Complete a state of which t, x and v are given, and record it as the START.

    On the edge of a soft stop and on a wall the first derivative that is not zero is the direction
    of the motion; a mass at rest that a wall holds is in CONTACT.
    """
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    x = state[X]
    v = state[V]
    n = phases.shape[0]
    set_phases(law, state[T], state[T_LOW], phases)
    region = FIRST_HARMONIC + n
    while x > law[region, UPPER]:
        region += 1 + n
    heading = v
    if v == 0.0:
        heading = push(law, constant_force(law, region, x), (state[T], state[T_LOW]), phases)
    if heading == 0.0:
        # Nothing ever moves it.
        state[FREE_BELOW] = math.inf
        state[FREE_ABOVE] = math.inf
    if x == law[region, UPPER] and law[region, UPPER_KIND] == EDGE and heading > 0.0:
        region += 1 + n
    state[FORCE] = constant_force(law, region, x)
    state[CARRIED_T] = math.nan
    counters[REGION] = region
    below = x == law[region, LOWER] and law[region, LOWER_KIND] == WALL
    above = x == law[region, UPPER] and law[region, UPPER_KIND] == WALL
    note(run, START, -1, v, v)
    if v == 0.0 and below and heading <= 0.0:
        counters[TOUCHED] = 1
        note(run, CONTACT, int(law[region, NUMBER]), 0.0, 0.0)
    elif v == 0.0 and above and heading >= 0.0:
        counters[TOUCHED] = -1
        note(run, CONTACT, int(law[region, NUMBER]) + 1, 0.0, 0.0)


@kernel
def flight_of(run: Run, phases: Floats) -> Flight:
    """Return the flight from the state of a run, with these phases at its start."""
    state = run.state
    start = (state[T], state[T_LOW], state[V], state[FORCE])
    return Flight(run.law, run.counters[REGION], start, phases, run.arrival)


@formula
def fly(run: Run, t_end: float) -> int:
    """Fly to the next event or graze; return MOVING, or why there is none."""
    state = run.state
    free = (state[FREE_BELOW], state[FREE_ABOVE])
    longest = (t_end - state[T]) - state[T_LOW]
    to_knot = time_to_knot(run.law, state[T], state[T_LOW])
    until = min(longest, to_knot)
    event = next_event(flight_of(run, run.phases), state[X], run.walker, free, until)
    if to_knot < longest and (event.verdict == NONE or event.s >= to_knot):
        return pass_knot(run, to_knot)
    return arrive(run, event, longest)


@cold
def pass_knot(run: Run, s: float) -> int:
    """Begin a flight under the next piece of the record, a time s later."""
    law, state = run.law, run.state
    region = run.counters[REGION]
    y, v = move(flight_of(run, run.phases), s)
    if not abs(v) < HUGE:
        return OVERFLOW
    # Between two events nothing lies beyond a bound but by rounding.
    state[X] = min(max(state[X] + y, law[region, LOWER]), law[region, UPPER])
    state[V] = v
    state[T], state[T_LOW] = next_knot(law, state[T], state[T_LOW])
    state[FORCE] = constant_force(law, region, state[X])
    state[FREE_BELOW] = 0.0
    state[FREE_ABOVE] = 0.0
    set_phases(law, state[T], state[T_LOW], run.phases)
    note(run, KNOT, -1, state[X], v)
    return MOVING


@kernel
def arrive(run: Run, event: NextEvent, longest: float) -> int:
    """Carry out the event that `next_event` returned."""
    law, state, phases = run.law, run.state, run.phases
    flight = flight_of(run, phases)
    region = flight.region
    verdict, s, side, value, rest, free = event
    if verdict == NONE or s > longest:
        return REACHED_END if longest < math.inf else NO_MORE
    state[FREE_BELOW], state[FREE_ABOVE] = free
    if verdict == PAUSE:
        return MOVING
    t, t_low = later(state[T], state[T_LOW], s)
    if verdict == GRAZE:
        bound = law[region, NUMBER] + (1.0 if side > 0.0 else 0.0)
        note_graze(run, (t, t_low), bound, value, rest)
        return MOVING
    if not abs(value) < HUGE:
        return OVERFLOW
    is_wall = law[region, LOWER_KIND if side < 0.0 else UPPER_KIND] == WALL
    at_rest = False
    errors = (0.0, 0.0, 0.0)
    distance = law[region, LOWER if side < 0.0 else UPPER] - state[X]
    if is_wall and not is_fast(law, region, flight.start, distance, s, value):
        at_rest, s, errors = rest_at_landing(flight, (-side, distance), (s, value), longest)
    t, t_low = later(t, t_low, rest)
    if at_rest:
        t, t_low = later(state[T], state[T_LOW], s)
    state[T] = t
    state[T_LOW] = t_low
    state[FREE_BELOW] = 0.0
    state[FREE_ABOVE] = 0.0
    # Computed afresh: phases turned along from flight to flight would drift from the instant.
    set_phases(law, t, t_low, phases)
    if at_rest:
        come_to_rest(run, side, value, errors)
    elif is_wall:
        strike(run, side, value)
    else:
        cross(run, side, value)
    return MOVING


@kernel
def cross(run: Run, side: float, v: float) -> None:
    """Pass the edge of a soft stop: the velocity stays, springs and dashpots change."""
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    region = counters[REGION]
    bound = int(law[region, NUMBER])
    counters[N_IMPACTS] += int(law[region, UPPER_ENTRY if side > 0.0 else LOWER_ENTRY])
    if side > 0.0:
        state[X] = law[region, UPPER]
        bound += 1
        region += 1 + phases.shape[0]
    else:
        state[X] = law[region, LOWER]
        region -= 1 + phases.shape[0]
    counters[REGION] = region
    state[V] = v
    state[FORCE] = constant_force(law, region, state[X])
    note(run, CROSSING, bound, v, v)


@kernel
def strike(run: Run, side: float, v: float) -> None:
    """Rebound from a wall, and where this is the tail of a chatter go to its end."""
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    region = counters[REGION]
    bound = int(law[region, NUMBER])
    if side > 0.0:
        bound += 1
        state[X] = law[region, UPPER]
        state[FORCE] = law[region, UPPER_FORCE]
    else:
        state[X] = law[region, LOWER]
        state[FORCE] = law[region, LOWER_FORCE]
    speed = restitution_at(law, region, bound, abs(v)) * abs(v)
    state[V] = -side * speed if speed > 0.0 else 0.0
    note(run, IMPACT, bound, v, state[V])
    counters[N_IMPACTS] += 1
    if speed == 0.0:
        if side * push(law, state[FORCE], (state[T], state[T_LOW]), phases) >= 0.0:
            counters[TOUCHED] = -1 if side > 0.0 else 1
            note(run, CONTACT, bound, 0.0, 0.0)
        return
    state[FASTEST] = max(state[FASTEST], abs(v))
    time, error = chatter_time(law, region, side, speed, state[FASTEST], state[FORCE], phases)
    # A chatter that a knot may interrupt is not summed.
    if 0.0 <= time < time_to_knot(law, state[T], state[T_LOW]):
        state[T], state[T_LOW] = later(state[T], state[T_LOW], time)
        state[V] = 0.0
        set_phases(law, state[T], state[T_LOW], phases)
        counters[TOUCHED] = -1 if side > 0.0 else 1
        note(run, CONTACT, bound, error, 0.0)


@kernel
def come_to_rest(run: Run, side: float, v: float, errors: tuple[float, float, float]) -> None:
    """Come to rest at a wall: a contact where the force holds the mass there, else a graze.

    ``errors`` are those of `rest_at_landing`.
    """
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    region = counters[REGION]
    bound = int(law[region, NUMBER]) + (1 if side > 0.0 else 0)
    state[X] = law[region, UPPER if side > 0.0 else LOWER]
    state[FORCE] = law[region, UPPER_FORCE if side > 0.0 else LOWER_FORCE]
    state[V] = 0.0
    note(run, SLOW_LANDING, bound, v, 0.0)
    # It counts as an impact, so that the limit also ends motions that land at rest for ever.
    counters[N_IMPACTS] += 1
    pressing = side * (state[FORCE] + force_and_slopes(law, phases)[0])
    # Within the rounding of the force the contact's release decides, from where the mass would
    # beyond doubt be in the wall.
    if pressing >= -FORCE_ROUNDING * (abs(state[FORCE]) + law[0, FORCE_BOUND]):
        counters[TOUCHED] = -1 if side > 0.0 else 1
        state[CONTACT_UNTIL] = errors[1]
        note(run, CONTACT, bound, errors[0], 0.0)
        return
    note_graze(run, (state[T], state[T_LOW]), float(bound), 0.0, errors[2])


@kernel
def stay(run: Run, t_end: float) -> int:
    """Stay in contact with a wall until the force changes sign."""
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    region = counters[REGION]
    normal = counters[TOUCHED]
    longest = (t_end - state[T]) - state[T_LOW]
    instant = (state[T], state[T_LOW])
    to_knot = time_to_knot(law, state[T], state[T_LOW])
    until = min(longest, to_knot)
    released, s, free = release_time(
        law, float(normal), state[FORCE], instant, state[CONTACT_UNTIL], until, phases
    )
    if to_knot < longest and to_knot <= s < math.inf:
        state[HELD] += to_knot
        stay_past_knot(run)
        # Under a force that repeats, a wall that has held the mass for a period holds it for ever.
        period = law[0, PERIOD]
        return AT_REST if period > 0.0 and state[HELD] > LONGER * period else MOVING
    if s > longest:
        return REACHED_END if s < math.inf else AT_REST
    if not released:
        state[CONTACT_UNTIL] = s
        return AT_REST if s == math.inf else MOVING
    state[T], state[T_LOW] = later(state[T], state[T_LOW], s)
    state[CONTACT_UNTIL] = 0.0
    state[HELD] = 0.0
    counters[TOUCHED] = 0
    set_phases(law, state[T], state[T_LOW], phases)
    # The force is zero at a release; what rounding has left of it would decide the take-off.
    state[FORCE] = -force_and_slopes(law, phases)[0]
    state[FREE_BELOW if normal > 0 else FREE_ABOVE] = free
    bound = int(law[region, NUMBER]) + (1 if normal < 0 else 0)
    note(run, RELEASE, bound, 0.0, 0.0)
    return MOVING


@cold
def stay_past_knot(run: Run) -> None:
    """Stay in contact under the next piece of the record, unless its force pulls at once."""
    law, state, counters, phases = run.law, run.state, run.counters, run.phases
    normal = counters[TOUCHED]
    state[T], state[T_LOW] = next_knot(law, state[T], state[T_LOW])
    state[CONTACT_UNTIL] = 0.0
    set_phases(law, state[T], state[T_LOW], phases)
    if not normal * push(law, state[FORCE], (state[T], state[T_LOW]), phases) > 0.0:
        return
    state[HELD] = 0.0
    counters[TOUCHED] = 0
    region = counters[REGION]
    note(run, RELEASE, int(law[region, NUMBER]) + (1 if normal < 0 else 0), 0.0, 0.0)
    drive = force_and_slopes(law, phases)[0]
    if abs(state[FORCE] + drive) > FORCE_ROUNDING * (abs(state[FORCE]) + law[0, FORCE_BOUND]):
        # The force has jumped: the flight does not begin with none, as after other releases.
        note(run, KNOT, -1, state[X], 0.0)
    else:
        state[FORCE] = -drive


@kernel
def note(run: Run, kind: np.int64, bound: int, before: float, v_after: float) -> None:
    """Write the event at the state's instant into the record; ``before`` is its V_BEFORE."""
    state, counters, events, marks = run.state, run.counters, run.events, run.marks
    i = counters[N_EVENTS]
    events[i, EVENT_T] = state[T]
    events[i, EVENT_T_LOW] = state[T_LOW]
    events[i, V_BEFORE] = before
    events[i, V_AFTER] = v_after
    marks[i, KIND] = kind
    marks[i, BOUND] = bound
    marks[i, NEXT_REGION] = counters[REGION]
    counters[N_EVENTS] = i + 1


@kernel
def note_graze(run: Run, instant: Pair, bound: float, clearance: float, error: float) -> None:
    """Write a graze into the record."""
    counters, grazes = run.counters, run.grazes
    i = counters[N_GRAZES]
    grazes[i, GRAZE_T] = instant[0]
    grazes[i, GRAZE_T_LOW] = instant[1]
    grazes[i, GRAZE_BOUND] = bound
    grazes[i, GRAZE_CLEARANCE] = clearance
    grazes[i, GRAZE_ERROR] = error
    counters[N_GRAZES] = i + 1
