"""Where the numbers of lanes in lockstep lie.

Each lane has a *seat*: a column of a bench, in which lie its law, its state and what a flight
works with. A bench is one flat array, row after row, so that a loop over its seats reads and
writes whole vectors.
"""

from __future__ import annotations

from percuss.kernels.compile import formula, kernel
from percuss.kernels.formulas import (
    Begin,
    Bounds,
    Motion,
    Place,
    Walk,
    bounds_of,
    motion_of,
    walk_of,
)
from percuss.kernels.law import (
    COSINE,
    FIRST_HARMONIC,
    LOWER_FORCE,
    LOWER_KIND,
    LOWER_RESTITUTION,
    SINE,
    UPPER_FORCE,
    UPPER_RESTITUTION,
    WALL,
    Law,
    Table,
)
from percuss.kernels.record import FASTEST, T_LOW, T, V

# Seats of a bench: two vectors of eight, of which one computes while the other waits.
SEATS = 16

# Rows of a bench: the law,
MOTION, WALK, BOUNDS = 0, 11, 23
PULL_COS, PULL_SIN, PULL, RESTITUTION, SIGN, T_END = range(31, 37)
# the last impact, and the flight from it,
AT, AT_LOW, SPEED, FASTEST_YET, PUSH, RATE = range(37, 43)
FOURTH, BOW, SLACK = range(43, 46)
# the walk,
MODE, COUNT, Y, W, WALK_PUSH, WALK_RATE = range(46, 52)
# the same once more, for each other step,
OTHER = 6
# the landing, and the impact.
S, BEFORE, REST, NEXT_AT, NEXT_AT_LOW, NEXT_SPEED = range(58, 64)
# From when on impacts are kept, how many there may be yet, and 1 where nothing is left to do.
SINCE, LEFT, DONE = range(64, 67)
ROWS = 67

# What a seat's lane is at: there is none; between flights; on the walk; on a step that ends in the wall; at a step that
# is not clear; landed; at something that is not plain.
ABSENT, READY, WALKING, ENDING, DOUBTFUL, LANDED, NOT_PLAIN = (float(mode) for mode in range(7))


@kernel
def sit(bench: Table, seat: int, law: Law, region: int, since: float, t_end: float) -> None:
    """Give a lane with this law a seat; impacts from ``since`` on are told to the caller."""
    motion = motion_of(law, region)
    for k in range(11):
        bench[(MOTION + k) * SEATS + seat] = motion[k]
    walk = walk_of(law, region)
    for k in range(12):
        bench[(WALK + k) * SEATS + seat] = walk[k]
    bounds = bounds_of(law, region)
    for k in range(8):
        bench[(BOUNDS + k) * SEATS + seat] = bounds[k]
    lower = law[region, LOWER_KIND] == WALL
    sign = 1.0 if lower else -1.0
    bench[SIGN * SEATS + seat] = sign
    bench[PULL_COS * SEATS + seat] = sign * law[FIRST_HARMONIC, COSINE]
    bench[PULL_SIN * SEATS + seat] = sign * law[FIRST_HARMONIC, SINE]
    bench[PULL * SEATS + seat] = sign * law[region, LOWER_FORCE if lower else UPPER_FORCE]
    restitution = law[region, LOWER_RESTITUTION if lower else UPPER_RESTITUTION]
    bench[RESTITUTION * SEATS + seat] = restitution
    bench[SINCE * SEATS + seat] = since
    bench[T_END * SEATS + seat] = t_end


@kernel
def get_ready(bench: Table, seat: int, state: Table, left: int) -> None:
    """Let the lane on a seat fly on from its state, at the wall with velocity off it.

    ``left`` is the number of impacts that it may make.
    """
    bench[LEFT * SEATS + seat] = float(left)
    bench[DONE * SEATS + seat] = 1.0
    bench[NEXT_AT * SEATS + seat] = state[T]
    bench[NEXT_AT_LOW * SEATS + seat] = state[T_LOW]
    bench[NEXT_SPEED * SEATS + seat] = bench[SIGN * SEATS + seat] * state[V]
    bench[FASTEST_YET * SEATS + seat] = state[FASTEST]
    bench[BEFORE * SEATS + seat] = 0.0
    bench[MODE * SEATS + seat] = READY


@kernel
def get_up(bench: Table, seat: int, state: Table) -> None:
    """Write where the lane on a seat is into its state."""
    state[T] = bench[NEXT_AT * SEATS + seat]
    state[T_LOW] = bench[NEXT_AT_LOW * SEATS + seat]
    state[V] = bench[SIGN * SEATS + seat] * bench[NEXT_SPEED * SEATS + seat]
    before = abs(bench[BEFORE * SEATS + seat])
    state[FASTEST] = max(bench[FASTEST_YET * SEATS + seat], before)


@kernel
def change_seat(bench: Table, seat: int, target: Table, other: int) -> None:
    """Move a lane to another seat, which may be its own, and leave the first one empty."""
    for k in range(ROWS):
        target[k * SEATS + other] = bench[k * SEATS + seat]
    bench[MODE * SEATS + seat] = ABSENT


@formula
def motion_at(bench: Table, i: int) -> Motion:
    """Return `motion_of` the law of a seat."""
    return (
        bench[MOTION * SEATS + i],
        bench[(MOTION + 1) * SEATS + i],
        bench[(MOTION + 2) * SEATS + i],
        bench[(MOTION + 3) * SEATS + i],
        bench[(MOTION + 4) * SEATS + i],
        bench[(MOTION + 5) * SEATS + i],
        bench[(MOTION + 6) * SEATS + i],
        bench[(MOTION + 7) * SEATS + i],
        bench[(MOTION + 8) * SEATS + i],
        bench[(MOTION + 9) * SEATS + i],
        bench[(MOTION + 10) * SEATS + i],
    )


@formula
def walk_at(bench: Table, i: int) -> Walk:
    """Return `walk_of` the law of a seat."""
    return (
        bench[WALK * SEATS + i],
        bench[(WALK + 1) * SEATS + i],
        bench[(WALK + 2) * SEATS + i],
        bench[(WALK + 3) * SEATS + i],
        bench[(WALK + 4) * SEATS + i],
        bench[(WALK + 5) * SEATS + i],
        bench[(WALK + 6) * SEATS + i],
        bench[(WALK + 7) * SEATS + i],
        bench[(WALK + 8) * SEATS + i],
        bench[(WALK + 9) * SEATS + i],
        bench[(WALK + 10) * SEATS + i],
        bench[(WALK + 11) * SEATS + i],
    )


@formula
def bounds_at(bench: Table, i: int) -> Bounds:
    """Return `bounds_of` the law of a seat."""
    return (
        bench[BOUNDS * SEATS + i],
        bench[(BOUNDS + 1) * SEATS + i],
        bench[(BOUNDS + 2) * SEATS + i],
        bench[(BOUNDS + 3) * SEATS + i],
        bench[(BOUNDS + 4) * SEATS + i],
        bench[(BOUNDS + 5) * SEATS + i],
        bench[(BOUNDS + 6) * SEATS + i],
        bench[(BOUNDS + 7) * SEATS + i],
    )


@formula
def begin_at(bench: Table, i: int) -> Begin:
    """Return how the flight of a seat begins."""
    return (
        bench[PULL * SEATS + i],
        bench[PUSH * SEATS + i],
        bench[RATE * SEATS + i],
        bench[SPEED * SEATS + i],
    )


@formula
def place_at(bench: Table, i: int) -> Place:
    """Return where the walk of a seat is."""
    return (
        bench[Y * SEATS + i],
        bench[W * SEATS + i],
        bench[WALK_PUSH * SEATS + i],
        bench[WALK_RATE * SEATS + i],
    )
