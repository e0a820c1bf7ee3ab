"""Many motions in one call, without Python between them.

Lanes whose flights are plain sit on benches and go from impact to impact in lockstep
(`lockstep`). A lane that comes to anything else is followed alone until it is plain again
(`lane`), and any that is left over when few are seated. A lane depends on its own law, start and
plan alone, and both ways give it the same bits, so they are the same whatever lanes are called
together.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from percuss.kernels.bench import (
    AT,
    AT_LOW,
    BEFORE,
    DONE,
    LANDED,
    LEFT,
    MODE,
    NEXT_AT,
    NEXT_AT_LOW,
    NEXT_SPEED,
    SEATS,
    SIGN,
    SPEED,
    change_seat,
    get_ready,
    get_up,
    sit,
)
from percuss.kernels.bench import SINCE as SINCE_ROW
from percuss.kernels.compile import formula, kernel
from percuss.kernels.flight import Start, set_phases
from percuss.kernels.lane import Lane, Room, Wish, begin_lane, follow, gather, turn
from percuss.kernels.law import NUMBER, Table
from percuss.kernels.lockstep import fly_round
from percuss.kernels.record import (
    BOUND,
    EVENT_T,
    EVENT_T_LOW,
    FORCE,
    IMPACT,
    KIND,
    MOVING,
    N_IMPACTS,
    NEXT_REGION,
    REACHED_LIMIT,
    REGION,
    SPENT,
    T_LOW,
    TOUCHED,
    V_AFTER,
    V_BEFORE,
    Integers,
    T,
    X,
)
from percuss.kernels.survey import (
    SINCE,
    STROBES,
    TALLIES,
    TANGENTS,
    UNTIL,
    is_strobe_due,
    note_peak,
    strobe,
    tally_impact,
)

# Rows of the buffer of events, and of the one for grazes, which are only counted.
BUFFER = 130
GRAZES = 4
# Benches of a call: their numbers fit the fastest memory.
BENCHES = 4
# With fewer lanes a round takes longer than following each.
FEWEST = 3
# As int64 and not int, for which numba would compile a function anew.
ONE = np.int64(1)
# The status of a lane that has not begun.
NEW = -1


# Many lanes: their laws, stacked, and the number of each one's law; states, counters, status,
# plans, tallies and points.
Crowd: TypeAlias = tuple[Table, Integers, Table, Integers, Integers, Table, Table, Table]


@kernel
def run_lanes(
    crowd: Crowd,
    room: Room,
    wish: Wish,
    patience: int,
    benches: Table,
    seated: Integers,
    stop: Integers,
) -> None:
    """Follow each lane from its state to its limits, or until its patience is spent.

    A lane whose status is NEW begins at the t, x and v of its state, one that is SPENT is taken
    up where it was; others are left alone. ``benches`` are zeros, and ``seated`` has room for who
    sits there. Once the only entry of ``stop``, which another thread may write, is not 0 all is
    left where it is.
    """
    n = crowd[1].shape[0]
    many = n > FEWEST
    taken = 0
    i = 0
    while (i < n or taken > 0) and stop[0] == 0:
        i, taken = fill_benches(crowd, room, wish, patience, benches, seated, stop, i, taken, many)
        many = taken > FEWEST
        k = 0
        while k * SEATS < taken:
            if not many or fly_round(benches[k]) > 0:
                taken = serve(crowd, room, wish, patience, benches, seated, k, taken, many)
            k += 1


@formula
def lane_of(crowd: Crowd, i: int) -> Lane:
    """Return what belongs to one lane."""
    laws, which, states, counters, _, plans, tallies, points = crowd
    return laws[which[i]], states[i], counters[i], plans[i], tallies[i], points[i]


@kernel
def fill_benches(
    crowd: Crowd,
    room: Room,
    wish: Wish,
    patience: int,
    benches: Table,
    seated: Integers,
    stop: Integers,
    i: int,
    taken: int,
    many: bool,
) -> tuple[int, int]:
    """Bring lanes from the i-th on to where they are plain, until all seats are taken.

    Return who is next, and how many seats are taken. Where there are not ``many`` lanes they are
    followed to their ends.
    """
    status = crowd[4]
    while i < status.shape[0] and taken < seated.shape[0] and stop[0] == 0:
        if status[i] == NEW or status[i] == SPENT:
            lane = lane_of(crowd, i)
            if status[i] == NEW:
                begin_lane(lane, room, wish)
            status[i] = follow(lane, room, wish, patience, many)
            if status[i] == MOVING:
                take_seat(lane, wish, benches[taken // SEATS], taken % SEATS)
                seated[taken] = i
                taken += 1
        i += 1
    return i, taken


@kernel
def serve(
    crowd: Crowd,
    room: Room,
    wish: Wish,
    patience: int,
    benches: Table,
    seated: Integers,
    k: int,
    taken: int,
    many: bool,
) -> int:
    """Do what a round of a bench has left to do; return how many seats are taken then."""
    status = crowd[4]
    bench = benches[k]
    seat = 0
    while seat < SEATS and k * SEATS + seat < taken:
        i = seated[k * SEATS + seat]
        landed = many and bench[MODE * SEATS + seat] == LANDED
        if landed and count_impact(lane_of(crowd, i), room, wish, bench, seat):
            bench[DONE * SEATS + seat] = 1.0
        if many and bench[DONE * SEATS + seat] == 1.0 and bench[LEFT * SEATS + seat] > 0.0:
            seat += 1
            continue
        status[i] = attend(lane_of(crowd, i), room, wish, patience, bench, seat, many)
        if status[i] == MOVING:
            seat += 1
            continue
        # Who sits there then is looked at next.
        taken -= 1
        seated[k * SEATS + seat] = seated[taken]
        change_seat(benches[taken // SEATS], taken % SEATS, bench, seat)
    return taken


@kernel
def take_seat(lane: Lane, wish: Wish, bench: Table, seat: int) -> None:
    """Seat a lane that leaves its wall."""
    law, state, counters, plan, tally, _ = lane
    from_start = wish[1] == TANGENTS or tally.shape[0] > TALLIES
    since = -math.inf if from_start else plan[SINCE]
    sit(bench, seat, law, counters[REGION], since, plan[UNTIL])
    get_ready(bench, seat, state, wish[0] - counters[N_IMPACTS])


@kernel
def attend(
    lane: Lane, room: Room, wish: Wish, patience: int, bench: Table, seat: int, many: bool
) -> int:
    """Do what a round has left to do for a lane; return MOVING where it keeps its seat."""
    law, state, counters, _, _, _ = lane
    counters[N_IMPACTS] = wish[0] - int(bench[LEFT * SEATS + seat])
    if not many:
        get_up(bench, seat, state)
        return follow(lane, room, wish, patience, many)
    if bench[MODE * SEATS + seat] == LANDED:
        if bench[DONE * SEATS + seat] == 0.0:
            gather_one(lane, room, wish, bench, seat)
        bench[DONE * SEATS + seat] = 1.0
        if counters[N_IMPACTS] < wish[0]:
            return MOVING
        get_up(bench, seat, state)
        return REACHED_LIMIT
    get_up(bench, seat, state)
    set_phases(law, state[T], state[T_LOW], room[3][0])
    status = turn(lane, room, wish)
    if status == MOVING:
        status = follow(lane, room, wish, patience, many)
    if status == MOVING:
        get_ready(bench, seat, state, wish[0] - counters[N_IMPACTS])
    return status


@formula
def count_impact(lane: Lane, room: Room, wish: Wish, bench: Table, seat: int) -> bool:
    """Take what is kept from a plain flight and its impact; False where it is more than that."""
    law, _, _, plan, tally, points = lane
    _, section, surveyed = wish
    until = bench[NEXT_AT * SEATS + seat]
    if bench[DONE * SEATS + seat] == 1.0 or until < bench[SINCE_ROW * SEATS + seat]:
        return True
    if section == TANGENTS or surveyed:
        return False
    if tally.shape[0] > TALLIES:
        note_peak(until, abs(bench[BEFORE * SEATS + seat]), tally)
        if until < plan[SINCE]:
            return True
    if section == STROBES and is_strobe_due(until, plan, tally):
        strobe_seat(lane, room, bench, seat, until)
    sign = bench[SIGN * SEATS + seat]
    speeds = (sign * bench[BEFORE * SEATS + seat], sign * bench[NEXT_SPEED * SEATS + seat])
    instant = (until, bench[NEXT_AT_LOW * SEATS + seat])
    tally_impact(law, instant, speeds, 0.0 if sign > 0.0 else 1.0, section, tally, points)
    return True


@formula
def strobe_seat(lane: Lane, room: Room, bench: Table, seat: int, until: float) -> None:
    """Write the strobes of the flight that a round has made."""
    law, state, counters, plan, tally, points = lane
    start = start_of(bench, seat, state)
    phases = room[3]
    set_phases(law, start[0], start[1], phases[2])
    held = counters[TOUCHED] != 0
    region = counters[REGION]
    strobe(law, region, state[X], start, held, until, plan, phases[2], phases[1], tally, points)


@formula
def start_of(bench: Table, seat: int, state: Table) -> Start:
    """Return how the flight that a round has made began."""
    v = bench[SIGN * SEATS + seat] * bench[SPEED * SEATS + seat]
    return bench[AT * SEATS + seat], bench[AT_LOW * SEATS + seat], v, state[FORCE]


@kernel
def gather_one(lane: Lane, room: Room, wish: Wish, bench: Table, seat: int) -> None:
    """Take what is kept from the flight and the impact that a round has made."""
    law, state, counters, _, _, _ = lane
    events, marks, _, _ = room
    sign = bench[SIGN * SEATS + seat]
    start = start_of(bench, seat, state)
    region = counters[REGION]
    events[0, EVENT_T] = bench[NEXT_AT * SEATS + seat]
    events[0, EVENT_T_LOW] = bench[NEXT_AT_LOW * SEATS + seat]
    events[0, V_BEFORE] = sign * bench[BEFORE * SEATS + seat]
    events[0, V_AFTER] = sign * bench[NEXT_SPEED * SEATS + seat]
    marks[0, KIND] = IMPACT
    marks[0, BOUND] = int(law[region, NUMBER]) + (0 if sign > 0.0 else 1)
    marks[0, NEXT_REGION] = region
    held = counters[TOUCHED] != 0
    gather(lane, room, wish, region, state[X], start, held, int(ONE))
