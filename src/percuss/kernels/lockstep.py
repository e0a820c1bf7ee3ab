"""Harmonic flights of many motions in lockstep: one instruction moves eight of them.

Each motion has a *slot* of a *block*: one flat array, row after row, that holds the law, the state
and the intermediate numbers of a flight, so that a loop over the slots reads and writes whole
vectors. A round takes each motion of a block from one impact to the next by the formulas of
`harmonic_flight`, stage by stage; a stage is a loop over slots without branches, which the
compiler turns into vector instructions. The numbers of a motion go through the same operations
whatever the other slots hold, so its bits are those of `harmonic_flights`. Any other flight is
marked, and left to the caller.
"""

from __future__ import annotations

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import formula, kernel
from percuss.kernels.harmonic_flight import (
    MOST_ITERATIONS,
    Begin,
    Bounds,
    FreeMotion,
    HarmonicLanding,
    Place,
    bounds_of,
    carried_force,
    carry_force,
    clearance,
    harmonic_guess,
    harmonic_impact,
    harmonic_iteration,
    harmonic_landing,
    harmonic_step,
    harmonic_walk,
    is_end,
    is_first,
    margins,
    motion_of,
    pushes,
)
from percuss.kernels.law_columns import (
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
)
from percuss.kernels.next_event import STEPS_A_WALK
from percuss.kernels.record import FASTEST, T_LOW, T, V
from percuss.kernels.step import Walk, walk_of

# Slots of a block: two vectors of eight, of which one computes while the other waits.
SLOTS = 16
# Rows of a block: the law,
MOTION, WALK, BOUNDS = 0, 11, 23
PULL_COS, PULL_SIN, PULL, RESTITUTION, SIGN, T_END = range(31, 37)
# the last impact, and the flight from it,
AT, AT_LOW, SPEED, FASTEST_YET, PUSH, RATE = range(37, 43)
FOURTH, BOW, SLACK = range(43, 46)
# the walk,
MODE, COUNT, Y, W, WALK_PUSH, WALK_RATE = range(46, 52)
# the same once more, for each other step,
OTHER = 6
# the landing with the force turned along, and the impact.
S, BEFORE, S_LOW, TURNED_PUSH, TURNED_RATE = range(58, 63)
NEXT_AT, NEXT_AT_LOW, NEXT_SPEED, NEXT_PUSH, NEXT_RATE = range(63, 68)
# From when on impacts are kept, how many more may come, and 1 where nothing is left to do.
COUNTED_FROM, LEFT, DONE = range(68, 71)
# What is observed of flights (`lockstep_observables`): when the next strobe comes, and the place
# there; the highest point, and what it is found from;
STROBE, SEEN_Y, SEEN_V = range(71, 74)
SUMMIT, TOP, OTHER_TOP, TOP_FROM, TOP_Y, TOP_W, TOP_PUSH, TOP_RATE = range(74, 82)
# a neighbour and the logarithm of an area, after the last impact and after the one before, and what
# the impacts add to that.
NEAR_X, NEAR_V, AREA, WAS_X, WAS_V, WAS_AREA, LOG_KEPT = range(82, 89)
ROWS = 89
# The mode of a slot: empty; between flights; on the walk; on a step that ends in the wall; at a
# step that is not clear; landed; at something that is no harmonic flight.
ABSENT, READY, WALKING, ENDING, DOUBTFUL, LANDED, NOT_HARMONIC = (float(mode) for mode in range(7))
# With no more motions left in a block than this, one by one is quicker.
FEW = 3


@kernel
def load_law(block: Floats, slot: int, law: Law, region: int, since: float, t_end: float) -> None:
    """Load a law into a slot; impacts from ``since`` on are passed to the caller."""
    motion = motion_of(law, region)
    for k in range(11):
        block[(MOTION + k) * SLOTS + slot] = motion[k]
    walk = walk_of(law, region)
    for k in range(12):
        block[(WALK + k) * SLOTS + slot] = walk[k]
    bounds = bounds_of(law, region)
    for k in range(8):
        block[(BOUNDS + k) * SLOTS + slot] = bounds[k]
    lower = law[region, LOWER_KIND] == WALL
    sign = 1.0 if lower else -1.0
    block[SIGN * SLOTS + slot] = sign
    block[PULL_COS * SLOTS + slot] = sign * law[FIRST_HARMONIC, COSINE]
    block[PULL_SIN * SLOTS + slot] = sign * law[FIRST_HARMONIC, SINE]
    block[PULL * SLOTS + slot] = sign * law[region, LOWER_FORCE if lower else UPPER_FORCE]
    restitution = law[region, LOWER_RESTITUTION if lower else UPPER_RESTITUTION]
    block[RESTITUTION * SLOTS + slot] = restitution
    block[COUNTED_FROM * SLOTS + slot] = since
    block[T_END * SLOTS + slot] = t_end


@kernel
def load_state(block: Floats, slot: int, state: Floats, left: int) -> None:
    """Load the state of a slot: at the wall, with a velocity off it.

    ``left`` is the number of impacts it may still make.
    """
    block[LEFT * SLOTS + slot] = float(left)
    block[DONE * SLOTS + slot] = 1.0
    block[NEXT_AT * SLOTS + slot] = state[T]
    block[NEXT_AT_LOW * SLOTS + slot] = state[T_LOW]
    block[NEXT_SPEED * SLOTS + slot] = block[SIGN * SLOTS + slot] * state[V]
    block[FASTEST_YET * SLOTS + slot] = state[FASTEST]
    block[BEFORE * SLOTS + slot] = 0.0
    block[MODE * SLOTS + slot] = READY
    pull = (block[PULL_COS * SLOTS + slot], block[PULL_SIN * SLOTS + slot])
    carried = carried_force(motion_at(block, slot), pull, state)
    block[NEXT_PUSH * SLOTS + slot] = carried[0]
    block[NEXT_RATE * SLOTS + slot] = carried[1]


@kernel
def store_state(block: Floats, slot: int, state: Floats) -> None:
    """Store the motion of a slot into its state."""
    state[T] = block[NEXT_AT * SLOTS + slot]
    state[T_LOW] = block[NEXT_AT_LOW * SLOTS + slot]
    state[V] = block[SIGN * SLOTS + slot] * block[NEXT_SPEED * SLOTS + slot]
    before = abs(block[BEFORE * SLOTS + slot])
    state[FASTEST] = max(block[FASTEST_YET * SLOTS + slot], before)
    carry_force((block[NEXT_PUSH * SLOTS + slot], block[NEXT_RATE * SLOTS + slot]), state)


@kernel
def move_slot(block: Floats, slot: int, target: Floats, other: int) -> None:
    """Move a motion to another slot, which may be its own, and leave the first one empty."""
    for k in range(ROWS):
        target[k * SLOTS + other] = block[k * SLOTS + slot]
    block[MODE * SLOTS + slot] = ABSENT


@formula
def motion_at(block: Floats, i: int) -> FreeMotion:
    """Return `motion_of` the law of a slot."""
    return (
        block[MOTION * SLOTS + i],
        block[(MOTION + 1) * SLOTS + i],
        block[(MOTION + 2) * SLOTS + i],
        block[(MOTION + 3) * SLOTS + i],
        block[(MOTION + 4) * SLOTS + i],
        block[(MOTION + 5) * SLOTS + i],
        block[(MOTION + 6) * SLOTS + i],
        block[(MOTION + 7) * SLOTS + i],
        block[(MOTION + 8) * SLOTS + i],
        block[(MOTION + 9) * SLOTS + i],
        block[(MOTION + 10) * SLOTS + i],
    )


@formula
def walk_at(block: Floats, i: int) -> Walk:
    """Return `walk_of` the law of a slot."""
    return (
        block[WALK * SLOTS + i],
        block[(WALK + 1) * SLOTS + i],
        block[(WALK + 2) * SLOTS + i],
        block[(WALK + 3) * SLOTS + i],
        block[(WALK + 4) * SLOTS + i],
        block[(WALK + 5) * SLOTS + i],
        block[(WALK + 6) * SLOTS + i],
        block[(WALK + 7) * SLOTS + i],
        block[(WALK + 8) * SLOTS + i],
        block[(WALK + 9) * SLOTS + i],
        block[(WALK + 10) * SLOTS + i],
        block[(WALK + 11) * SLOTS + i],
    )


@formula
def bounds_at(block: Floats, i: int) -> Bounds:
    """Return `bounds_of` the law of a slot."""
    return (
        block[BOUNDS * SLOTS + i],
        block[(BOUNDS + 1) * SLOTS + i],
        block[(BOUNDS + 2) * SLOTS + i],
        block[(BOUNDS + 3) * SLOTS + i],
        block[(BOUNDS + 4) * SLOTS + i],
        block[(BOUNDS + 5) * SLOTS + i],
        block[(BOUNDS + 6) * SLOTS + i],
        block[(BOUNDS + 7) * SLOTS + i],
    )


@formula
def begin_at(block: Floats, i: int) -> Begin:
    """Return how the flight of a slot begins."""
    return (
        block[PULL * SLOTS + i],
        block[PUSH * SLOTS + i],
        block[RATE * SLOTS + i],
        block[SPEED * SLOTS + i],
    )


@formula
def place_at(block: Floats, i: int) -> Place:
    """Return where the walk of a slot is."""
    return (
        block[Y * SLOTS + i],
        block[W * SLOTS + i],
        block[WALK_PUSH * SLOTS + i],
        block[WALK_RATE * SLOTS + i],
    )


@formula
def landing_at(block: Floats, i: int) -> HarmonicLanding:
    """Return the landing of a slot."""
    return (
        block[S * SLOTS + i],
        block[BEFORE * SLOTS + i],
        block[S_LOW * SLOTS + i],
        block[TURNED_PUSH * SLOTS + i],
        block[TURNED_RATE * SLOTS + i],
    )


@kernel
def fly_round(block: Floats) -> int:
    """Take each motion of a block to its next impact; return how many are not DONE.

    Those have landed at an impact that is to be kept or is their last, or are NOT_HARMONIC.
    """
    take_off(block)
    walk_on(block)
    aim(block)
    land_all(block)
    return strike_all(block)


@kernel
def take_off(block: Floats) -> None:
    """Begin a flight where the flight before has ended."""
    for i in range(SLOTS):
        t = block[NEXT_AT * SLOTS + i]
        t_low = block[NEXT_AT_LOW * SLOTS + i]
        speed = block[NEXT_SPEED * SLOTS + i]
        motion = motion_at(block, i)
        bounds = bounds_at(block, i)
        pull = (block[PULL_COS * SLOTS + i], block[PULL_SIN * SLOTS + i])
        push, rate = pushes(pull, cos_sin(motion[9], motion[10], t, t_low))
        carried = (block[NEXT_PUSH * SLOTS + i], block[NEXT_RATE * SLOTS + i])
        force = block[PULL * SLOTS + i]
        fourth, bow, slack = margins(motion, bounds, (force, carried[0], carried[1], speed))
        fastest = max(block[FASTEST_YET * SLOTS + i], abs(block[BEFORE * SLOTS + i]))
        block[FASTEST_YET * SLOTS + i] = fastest
        block[AT * SLOTS + i] = t
        block[AT_LOW * SLOTS + i] = t_low
        block[SPEED * SLOTS + i] = speed
        block[PUSH * SLOTS + i] = push
        block[RATE * SLOTS + i] = rate
        block[FOURTH * SLOTS + i] = fourth
        block[BOW * SLOTS + i] = bow
        block[SLACK * SLOTS + i] = slack
        block[COUNT * SLOTS + i] = 0.0
        block[Y * SLOTS + i] = 0.0
        block[W * SLOTS + i] = speed
        block[WALK_PUSH * SLOTS + i] = carried[0]
        block[WALK_RATE * SLOTS + i] = carried[1]
        mode = block[MODE * SLOTS + i]
        block[MODE * SLOTS + i] = ABSENT if mode == ABSENT else WALKING


@kernel
def walk_on(block: Floats) -> None:
    """Walk until each motion is at a step that ends in the wall, or needs another search."""
    for _ in range(STEPS_A_WALK // 2):
        # Two sets of rows in turn: a loop that reads and writes the same row is slow.
        step_all(block, 0, OTHER)
        if step_all(block, OTHER, 0) <= FEW:
            break
    for i in range(SLOTS):
        mode = block[MODE * SLOTS + i]
        if mode in (WALKING, DOUBTFUL):
            walk_alone(block, i)


@formula
def step_all(block: Floats, source: int, target: int) -> int:
    """Make one step; return how many motions walk on from it."""
    walking = 0
    for i in range(SLOTS):
        walk = walk_at(block, i)
        step = block[BOUNDS * SLOTS + i]
        pull = block[PULL * SLOTS + i]
        bow = block[BOW * SLOTS + i]
        slack = block[SLACK * SLOTS + i]
        mode = block[(source + MODE) * SLOTS + i]
        count = block[(source + COUNT) * SLOTS + i]
        before = (
            block[(source + Y) * SLOTS + i],
            block[(source + W) * SLOTS + i],
            block[(source + WALK_PUSH) * SLOTS + i],
            block[(source + WALK_RATE) * SLOTS + i],
        )
        after = harmonic_step(walk, pull, before)
        clear = clearance(step, count == 0.0, before, after, bow, slack) > slack
        stops = ENDING if is_end(count == 0.0, before, after, slack) else DOUBTFUL
        walks = mode == WALKING
        goes = walks & clear
        block[(target + MODE) * SLOTS + i] = stops if walks & (not clear) else mode
        block[(target + COUNT) * SLOTS + i] = count + 1.0 if goes else count
        block[(target + Y) * SLOTS + i] = after[0] if goes else before[0]
        block[(target + W) * SLOTS + i] = after[1] if goes else before[1]
        block[(target + WALK_PUSH) * SLOTS + i] = after[2] if goes else before[2]
        block[(target + WALK_RATE) * SLOTS + i] = after[3] if goes else before[3]
        walking += int(goes)
    return walking


@kernel
def walk_alone(block: Floats, i: int) -> None:
    """Walk on with one motion: the last of its block, or one whose step is in doubt."""
    margin = (block[BOW * SLOTS + i], block[SLACK * SLOTS + i])
    step = block[BOUNDS * SLOTS + i]
    count = int(block[COUNT * SLOTS + i])
    k, after, _ = harmonic_walk(
        walk_at(block, i), step, block[PULL * SLOTS + i], margin, count, place_at(block, i)
    )
    block[MODE * SLOTS + i] = ENDING if k >= 0 else NOT_HARMONIC
    block[COUNT * SLOTS + i] = float(k)
    block[Y * SLOTS + i] = after[0]
    block[W * SLOTS + i] = after[1]
    block[WALK_PUSH * SLOTS + i] = after[2]
    block[WALK_RATE * SLOTS + i] = after[3]


@kernel
def aim(block: Floats) -> None:
    """Guess where in their last steps the motions land."""
    for i in range(SLOTS):
        step = block[BOUNDS * SLOTS + i]
        before = place_at(block, i)
        pull = block[PULL * SLOTS + i]
        after = harmonic_step(walk_at(block, i), pull, before)
        part = harmonic_guess(motion_at(block, i), step, pull, before, after)
        block[S * SLOTS + i] = step * block[COUNT * SLOTS + i] + step * part


@kernel
def land_all(block: Floats) -> None:
    """Iterate the landings until they are settled, the last few one by one."""
    iterations = MOST_ITERATIONS
    left = SLOTS
    while left > FEW and iterations > 0:
        left = iterate_all(block)
        iterations -= 1
    if left == 0:
        return
    for i in range(SLOTS):
        s = block[S * SLOTS + i]
        if block[MODE * SLOTS + i] == ENDING and s > 0.0:
            end, v, s_low, push, rate = harmonic_landing(
                motion_at(block, i), bounds_at(block, i), begin_at(block, i), s, iterations
            )
            block[S * SLOTS + i] = end
            block[BEFORE * SLOTS + i] = v
            block[S_LOW * SLOTS + i] = s_low
            block[TURNED_PUSH * SLOTS + i] = push
            block[TURNED_RATE * SLOTS + i] = rate
            block[MODE * SLOTS + i] = LANDED if end > 0.0 else NOT_HARMONIC


@kernel
def iterate_all(block: Floats) -> int:
    """Make one iteration of all landings; return how many are not settled."""
    left = 0
    for i in range(SLOTS):
        mode = block[MODE * SLOTS + i]
        s = block[S * SLOTS + i]
        active = (mode == ENDING) & (s > 0.0)
        # All reads come before all writes, without which the compiler makes no vectors of the loop.
        before = block[BEFORE * SLOTS + i]
        s_low_before = block[S_LOW * SLOTS + i]
        push_before = block[TURNED_PUSH * SLOTS + i]
        rate_before = block[TURNED_RATE * SLOTS + i]
        motion = motion_at(block, i)
        bounds = bounds_at(block, i)
        settled, end, v, s_low, push, rate = harmonic_iteration(
            motion, bounds, begin_at(block, i), s if active else 1.0
        )
        block[S * SLOTS + i] = end if active else s
        block[BEFORE * SLOTS + i] = v if active else before
        block[S_LOW * SLOTS + i] = s_low if active else s_low_before
        block[TURNED_PUSH * SLOTS + i] = push if active else push_before
        block[TURNED_RATE * SLOTS + i] = rate if active else rate_before
        block[MODE * SLOTS + i] = LANDED if active & settled else mode
        left += int(active & (not settled) & (end > 0.0))
    return left


@kernel
def strike_all(block: Floats) -> int:
    """Rebound where a landing is clearly the first of its flight and its impact is regular."""
    not_done = 0
    for i in range(SLOTS):
        mode = block[MODE * SLOTS + i]
        step = block[BOUNDS * SLOTS + i]
        slack = block[SLACK * SLOTS + i]
        landed = landing_at(block, i)
        carried = (block[NEXT_PUSH * SLOTS + i], block[NEXT_RATE * SLOTS + i])
        before = place_at(block, i)
        s = step * block[COUNT * SLOTS + i]
        first = is_first(before, s, landed, step, block[FOURTH * SLOTS + i], slack)
        instant = (block[AT * SLOTS + i], block[AT_LOW * SLOTS + i])
        restitution = block[RESTITUTION * SLOTS + i]
        fastest = block[FASTEST_YET * SLOTS + i]
        t, t_low, speed, regular = harmonic_impact(
            instant, landed, restitution, fastest, block[T_END * SLOTS + i]
        )
        fine = (mode == LANDED) & first & regular
        absent = mode == ABSENT
        left = block[LEFT * SLOTS + i] - (1.0 if fine else 0.0)
        done = absent | (fine & (t < block[COUNTED_FROM * SLOTS + i]) & (left > 0.0))
        not_done += int(not done)
        block[DONE * SLOTS + i] = 1.0 if done else 0.0
        block[LEFT * SLOTS + i] = left
        block[MODE * SLOTS + i] = LANDED if fine else (ABSENT if absent else NOT_HARMONIC)
        block[NEXT_AT * SLOTS + i] = t if fine else instant[0]
        block[NEXT_AT_LOW * SLOTS + i] = t_low if fine else instant[1]
        block[NEXT_SPEED * SLOTS + i] = speed if fine else block[SPEED * SLOTS + i]
        block[NEXT_PUSH * SLOTS + i] = landed[3] if fine else carried[0]
        block[NEXT_RATE * SLOTS + i] = landed[4] if fine else carried[1]
        block[BEFORE * SLOTS + i] = landed[1] if fine else 0.0
    return not_done
