"""Loads of one motion of a batch: peaks of forces and accelerations, and means over time.

All is taken stretch by stretch from the closed form. Peaks are those of linear observables, found
with the proof that holds for events (`linear_observables`), with both limits at a jump. Integrals
are summed by Gauss's rule over parts of a step of the search, with so many nodes that what is left
is rounding.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import Pair
from percuss.kernels.compile import kernel
from percuss.kernels.flight import Flight, force_and_slopes, move, set_phases
from percuss.kernels.law_columns import (
    FIRST_KNOT,
    FORCING_CONSTANT,
    LOWER,
    LOWER_KIND,
    N_KNOTS,
    N_REGIONS,
    NUMBER,
    STOP_AT,
    STOP_BOUND,
    STOP_FIRST,
    STOP_LAST,
    WALL,
    Law,
)
from percuss.kernels.linear_observables import (
    GREATEST,
    LEAST,
    NOWHERE,
    Observable,
    Weights,
    derive_knots,
    derive_law,
    extremes_in_contact,
    extremes_in_flight,
    meeting,
    note_limit,
    note_tail,
    slope_weights,
    stop_weights,
)
from percuss.kernels.observables import (
    IN_TOUCH,
    NODES,
    PEAK_ACCELERATION,
    PEAK_FORCE,
    POINTS_OF_A_SUM,
    SINCE,
    SQUARE,
    WEIGHTS,
    WORK,
    Member,
    parts_of_a_sum,
)
from percuss.kernels.overdamped import pace_until
from percuss.kernels.record import (
    CONTACT,
    EVENT_T,
    EVENT_T_LOW,
    KIND,
)
from percuss.kernels.restitution import restitution_at

# Instants that differ by less than this part of them are one.
SAME_INSTANT = 4.0 * 2.0**-52
# Extremes of one flight: as many as it has.
ALL = 1 << 62


@kernel
def observe_loads(
    member: Member,
    flight: Flight,
    x: float,
    in_contact: bool,
    row: int,
    end: tuple[Pair, bool],
    with_load_peaks: bool,
) -> None:
    """Record the loads of a stretch; ``end`` is its end, and whether no event of a row is there.

    ``with_load_peaks`` asks for those of forces and accelerations beside the means. The instant
    has both its parts: a contact may begin at the very instant of an impact.
    """
    law, region, start, phases, _ = flight
    values = member.values
    until = (end[0][0] - start[0]) + (end[0][1] - start[1])
    # An event within rounding of the window's begin is at it, and has both limits.
    begin = max(0.0, min((member.plan[SINCE] - start[0]) - start[1], until))
    is_tail = in_contact and not end[1] and member.run.marks[row, KIND] == CONTACT
    if until < begin or (is_tail and until <= 0.0):
        return
    if end[1] and until <= SAME_INSTANT * abs(end[0][0]) and start[0] > member.plan[SINCE]:
        # Nor is the window's end behind an event that rounding alone keeps before it.
        return
    if in_contact:
        values[SQUARE] += x * x * (until - begin)
    else:
        set_phases(law, start[0], start[1], phases)
        integrate(flight, x, (begin, until), values)
    held = in_contact and not is_tail
    if held or is_in_touch(member.stops, int(law[region, NUMBER])):
        values[IN_TOUCH] += until - begin
    if with_load_peaks:
        observe_peaks(member, flight, x, row, (begin, until, in_contact, is_tail, end[1]))


@kernel
def observe_peaks(
    member: Member,
    flight: Flight,
    x: float,
    row: int,
    span: tuple[float, float, bool, bool, bool],
) -> None:
    """Record the peaks of acceleration and forces in a stretch; ``span`` as `peak_of` takes it."""
    law, values = flight.law, member.values
    last = int(law[0, N_REGIONS]) - 1
    acceleration = (0.0, 0.0, 1.0, 0.0)
    peak = peak_of(member, flight, x, row, span, (0.0, acceleration, (0, last), -1))
    values[PEAK_ACCELERATION] = max(values[PEAK_ACCELERATION], peak)
    for i in range(member.stops.shape[0]):
        stop = member.stops[i]
        acts = (int(stop[STOP_FIRST]), int(stop[STOP_LAST]))
        what = (stop[STOP_AT], stop_weights(stop), acts, int(stop[STOP_BOUND]))
        peak = peak_of(member, flight, x, row, span, what)
        values[PEAK_FORCE] = max(values[PEAK_FORCE], peak)


@kernel
def is_in_touch(stops: Floats, number: int) -> bool:
    """Return whether a soft stop acts in a region."""
    acting = 0
    for i in range(stops.shape[0]):
        acting += 1 if stops[i, STOP_FIRST] <= number <= stops[i, STOP_LAST] else 0
    return acting > 0


@kernel
def integrate(flight: Flight, x: float, span: tuple[float, float], values: Floats) -> None:
    """Add the integrals of x^2, and of the power of the forcing, over a part of a flight."""
    law, region = flight.law, flight.region
    begin, end = span
    while begin < end:
        until = pace_until(law, region, begin, end)
        count, step = parts_of_a_sum(law, region, begin, until)
        square = 0.0
        work = 0.0
        for i in range(count):
            left = begin + i * step
            for k in range(POINTS_OF_A_SUM):
                y, v = move(flight, left + step * NODES[k])
                force = law[0, FORCING_CONSTANT] + force_and_slopes(law, flight.arrival)[0]
                square += WEIGHTS[k] * (x + y) * (x + y)
                work += WEIGHTS[k] * force * v
        values[SQUARE] += step * square
        values[WORK] += step * work
        begin = until


@kernel
def peak_of(
    member: Member,
    flight: Flight,
    x: float,
    row: int,
    span: tuple[float, float, bool, bool, bool],
    what: tuple[float, Weights, tuple[int, int], int],
) -> float:
    """Return the largest magnitude of a linear observable in a stretch.

    ``span`` is where it begins and ends, since the flight's start, whether it is a contact, whether
    it is the tail of a chatter, and whether it ends without an event. ``what`` are the observable's
    reference, weights, regions and bound.
    """
    law, region, start, phases, _ = flight
    begin, until, in_contact, is_tail, is_last = span
    reference, weights, acts, bound = what
    loads = member.loads
    number = int(law[region, NUMBER])
    if not in_contact and not acts[0] <= number <= acts[1]:
        return 0.0
    copy_law(law, loads.derived)
    derive_law(law, slope_weights(weights, bound), loads.derived)
    if in_contact and law[0, N_KNOTS] > 0.0:
        derive_knots(law, slope_weights(weights, bound), loads.derived)
    observable = Observable(reference, weights, acts, bound, loads.derived)
    best = loads.best
    best[LEAST] = math.inf
    best[GREATEST] = -math.inf
    wall = number
    if not (law[region, LOWER_KIND] == WALL and x == law[region, LOWER]):
        wall = number + 1
    events, marks = member.run.events, member.run.marks
    if is_tail:
        if acts[0] <= number <= acts[1]:
            end = (events[row, EVENT_T], events[row, EVENT_T_LOW])
            tail = (restitution_at(law, region, wall, abs(start[2])), until, end)
            note_tail(flight, x, tail, observable, best)
    elif in_contact:
        if law[0, N_KNOTS] > 0.0:
            # A jump within rounding of the window's begin is at it, and has both limits.
            begin = max(0.0, begin - SAME_INSTANT * abs(member.plan[SINCE]))
        extremes_in_contact(flight, x, observable, wall, (begin, until), best)
    else:
        met = NOWHERE if is_last else meeting(law, events, marks, row)
        set_phases(law, start[0], start[1], phases)
        note_limit(flight, x, observable, begin, NOWHERE, best)
        extremes_in_flight(flight, x, observable, ((begin, 0.0), until), best, loads.scratch, ALL)
        note_limit(flight, x, observable, until, met, best)
    return max(0.0, -best[LEAST], best[GREATEST])


@kernel
def copy_law(source: Law, target: Law) -> None:
    """Write one law, without the knots of a record, into another of the same shape."""
    rows = source.shape[0]
    if source[0, N_KNOTS] > 0.0:
        rows = int(source[0, FIRST_KNOT])
    for i in range(rows):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]
