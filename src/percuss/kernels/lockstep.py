"""Plain flights of many lanes in lockstep: one instruction moves eight of them.

A round takes each lane on a `bench` from one impact to the next by the `formulas` of plain
flights, stage by stage; a stage is a loop over seats without branches, which the compiler turns
into vector instructions. A lane's numbers go through the same operations whoever sits beside it,
so its bits are those of `plain_flights`. What is not plain is marked, and left to the caller.
"""

from __future__ import annotations

from percuss.kernels.angles import cos_sin
from percuss.kernels.bench import (
    ABSENT,
    AT,
    AT_LOW,
    BEFORE,
    BOUNDS,
    BOW,
    COUNT,
    DONE,
    DOUBTFUL,
    ENDING,
    FASTEST_YET,
    FOURTH,
    LANDED,
    LEFT,
    MODE,
    NEXT_AT,
    NEXT_AT_LOW,
    NEXT_SPEED,
    NOT_PLAIN,
    OTHER,
    PULL,
    PULL_COS,
    PULL_SIN,
    PUSH,
    RATE,
    REST,
    RESTITUTION,
    SEATS,
    SINCE,
    SLACK,
    SPEED,
    T_END,
    WALK_PUSH,
    WALK_RATE,
    WALKING,
    S,
    W,
    Y,
    begin_at,
    bounds_at,
    motion_at,
    place_at,
    walk_at,
)
from percuss.kernels.compile import formula, kernel
from percuss.kernels.formulas import (
    clearance,
    is_end,
    is_first,
    margins,
    plain_guess,
    plain_impact,
    plain_look,
    plain_step,
    pushes,
)
from percuss.kernels.law import Table
from percuss.kernels.plain import MOST_LOOKS, plain_landing, plain_walk
from percuss.kernels.search import STEPS_A_WALK

# So many of a bench are followed one by one, which is quicker then.
FEW = 3


@kernel
def fly_round(bench: Table) -> int:
    """Take each lane on a bench to its next impact; return how many are not DONE with that.

    Those have landed at an impact that is to be kept or is their last, or are NOT_PLAIN.
    """
    take_off(bench)
    walk_on(bench)
    aim(bench)
    land_all(bench)
    return strike_all(bench)


@kernel
def take_off(bench: Table) -> None:
    """Begin a flight where the flight before has ended."""
    for i in range(SEATS):
        t = bench[NEXT_AT * SEATS + i]
        t_low = bench[NEXT_AT_LOW * SEATS + i]
        speed = bench[NEXT_SPEED * SEATS + i]
        motion = motion_at(bench, i)
        bounds = bounds_at(bench, i)
        pull = (bench[PULL_COS * SEATS + i], bench[PULL_SIN * SEATS + i])
        push, rate = pushes(pull, cos_sin(motion[9], motion[10], t, t_low))
        fourth, bow, slack = margins(motion, bounds, (bench[PULL * SEATS + i], push, rate, speed))
        fastest = max(bench[FASTEST_YET * SEATS + i], abs(bench[BEFORE * SEATS + i]))
        bench[FASTEST_YET * SEATS + i] = fastest
        bench[AT * SEATS + i] = t
        bench[AT_LOW * SEATS + i] = t_low
        bench[SPEED * SEATS + i] = speed
        bench[PUSH * SEATS + i] = push
        bench[RATE * SEATS + i] = rate
        bench[FOURTH * SEATS + i] = fourth
        bench[BOW * SEATS + i] = bow
        bench[SLACK * SEATS + i] = slack
        bench[COUNT * SEATS + i] = 0.0
        bench[Y * SEATS + i] = 0.0
        bench[W * SEATS + i] = speed
        bench[WALK_PUSH * SEATS + i] = push
        bench[WALK_RATE * SEATS + i] = rate
        mode = bench[MODE * SEATS + i]
        bench[MODE * SEATS + i] = ABSENT if mode == ABSENT else WALKING


@kernel
def walk_on(bench: Table) -> None:
    """Walk until each lane is at a step that ends in the wall, or is not plain."""
    for _ in range(STEPS_A_WALK // 2):
        # There and back between two sets of rows: read and written at once a row is slow.
        step_all(bench, 0, OTHER)
        if step_all(bench, OTHER, 0) <= FEW:
            break
    for i in range(SEATS):
        mode = bench[MODE * SEATS + i]
        if mode in (WALKING, DOUBTFUL):
            walk_alone(bench, i)


@formula
def step_all(bench: Table, source: int, target: int) -> int:
    """Make one step; return how many lanes go on from it."""
    walking = 0
    for i in range(SEATS):
        walk = walk_at(bench, i)
        step = bench[BOUNDS * SEATS + i]
        pull = bench[PULL * SEATS + i]
        bow = bench[BOW * SEATS + i]
        slack = bench[SLACK * SEATS + i]
        mode = bench[(source + MODE) * SEATS + i]
        count = bench[(source + COUNT) * SEATS + i]
        here = (
            bench[(source + Y) * SEATS + i],
            bench[(source + W) * SEATS + i],
            bench[(source + WALK_PUSH) * SEATS + i],
            bench[(source + WALK_RATE) * SEATS + i],
        )
        there = plain_step(walk, pull, here)
        clear = clearance(step, count == 0.0, here, there, bow, slack) > slack
        stops = ENDING if is_end(count == 0.0, here, there, slack) else DOUBTFUL
        walks = mode == WALKING
        goes = walks & clear
        bench[(target + MODE) * SEATS + i] = stops if walks & (not clear) else mode
        bench[(target + COUNT) * SEATS + i] = count + 1.0 if goes else count
        bench[(target + Y) * SEATS + i] = there[0] if goes else here[0]
        bench[(target + W) * SEATS + i] = there[1] if goes else here[1]
        bench[(target + WALK_PUSH) * SEATS + i] = there[2] if goes else here[2]
        bench[(target + WALK_RATE) * SEATS + i] = there[3] if goes else here[3]
        walking += int(goes)
    return walking


@kernel
def walk_alone(bench: Table, i: int) -> None:
    """Walk on with one lane: the last of its bench, or one whose step is in doubt."""
    margin = (bench[BOW * SEATS + i], bench[SLACK * SEATS + i])
    step = bench[BOUNDS * SEATS + i]
    count = int(bench[COUNT * SEATS + i])
    k, here, _ = plain_walk(
        walk_at(bench, i), step, bench[PULL * SEATS + i], margin, count, place_at(bench, i)
    )
    bench[MODE * SEATS + i] = ENDING if k >= 0 else NOT_PLAIN
    bench[COUNT * SEATS + i] = float(k)
    bench[Y * SEATS + i] = here[0]
    bench[W * SEATS + i] = here[1]
    bench[WALK_PUSH * SEATS + i] = here[2]
    bench[WALK_RATE * SEATS + i] = here[3]


@kernel
def aim(bench: Table) -> None:
    """Guess where in their last steps the lanes land."""
    for i in range(SEATS):
        step = bench[BOUNDS * SEATS + i]
        here = place_at(bench, i)
        there = plain_step(walk_at(bench, i), bench[PULL * SEATS + i], here)
        part = plain_guess(motion_at(bench, i), step, bench[PULL * SEATS + i], here, there)
        bench[S * SEATS + i] = step * bench[COUNT * SEATS + i] + step * part


@kernel
def land_all(bench: Table) -> None:
    """Look at the landings until they are settled, the last few alone."""
    looks = MOST_LOOKS
    left = SEATS
    while left > FEW and looks > 0:
        left = look_all(bench)
        looks -= 1
    if left == 0:
        return
    for i in range(SEATS):
        s = bench[S * SEATS + i]
        if bench[MODE * SEATS + i] == ENDING and s > 0.0:
            end, v, rest = plain_landing(
                motion_at(bench, i), bounds_at(bench, i), begin_at(bench, i), s, looks
            )
            bench[S * SEATS + i] = end
            bench[BEFORE * SEATS + i] = v
            bench[REST * SEATS + i] = rest
            bench[MODE * SEATS + i] = LANDED if end > 0.0 else NOT_PLAIN


@kernel
def look_all(bench: Table) -> int:
    """Look once; return how many landings are left."""
    left = 0
    for i in range(SEATS):
        mode = bench[MODE * SEATS + i]
        s = bench[S * SEATS + i]
        looks = (mode == ENDING) & (s > 0.0)
        # All is read before anything is written, or else the loop is none of vectors.
        before = bench[BEFORE * SEATS + i]
        rest_before = bench[REST * SEATS + i]
        motion = motion_at(bench, i)
        bounds = bounds_at(bench, i)
        settled, end, v, rest = plain_look(motion, bounds, begin_at(bench, i), s if looks else 1.0)
        bench[S * SEATS + i] = end if looks else s
        bench[BEFORE * SEATS + i] = v if looks else before
        bench[REST * SEATS + i] = rest if looks else rest_before
        bench[MODE * SEATS + i] = LANDED if looks & settled else mode
        left += int(looks & (not settled) & (end > 0.0))
    return left


@kernel
def strike_all(bench: Table) -> int:
    """Rebound where a landing is plainly the first of its flight and its impact is plain."""
    not_done = 0
    for i in range(SEATS):
        mode = bench[MODE * SEATS + i]
        step = bench[BOUNDS * SEATS + i]
        slack = bench[SLACK * SEATS + i]
        landed = (bench[S * SEATS + i], bench[BEFORE * SEATS + i], bench[REST * SEATS + i])
        here = place_at(bench, i)
        s = step * bench[COUNT * SEATS + i]
        first = is_first(here, s, landed, step, bench[FOURTH * SEATS + i], slack)
        instant = (bench[AT * SEATS + i], bench[AT_LOW * SEATS + i])
        restitution = bench[RESTITUTION * SEATS + i]
        fastest = bench[FASTEST_YET * SEATS + i]
        t, t_low, speed, plain = plain_impact(
            instant, landed, restitution, fastest, bench[T_END * SEATS + i]
        )
        fine = (mode == LANDED) & first & plain
        absent = mode == ABSENT
        left = bench[LEFT * SEATS + i] - (1.0 if fine else 0.0)
        done = absent | (fine & (t < bench[SINCE * SEATS + i]) & (left > 0.0))
        not_done += int(not done)
        bench[DONE * SEATS + i] = 1.0 if done else 0.0
        bench[LEFT * SEATS + i] = left
        bench[MODE * SEATS + i] = LANDED if fine else (ABSENT if absent else NOT_PLAIN)
        bench[NEXT_AT * SEATS + i] = t if fine else instant[0]
        bench[NEXT_AT_LOW * SEATS + i] = t_low if fine else instant[1]
        bench[NEXT_SPEED * SEATS + i] = speed if fine else bench[SPEED * SEATS + i]
        bench[BEFORE * SEATS + i] = landed[1] if fine else 0.0
    return not_done
