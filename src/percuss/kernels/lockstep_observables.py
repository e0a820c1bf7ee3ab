"""What is observed of many motions in lockstep, before their flights are left behind.

Each is a stage over the slots of a block, as those of `lockstep` are, by the formulas of
`harmonic_observables`. It sees the flights of a round that have just landed.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import formula, kernel
from percuss.kernels.harmonic_flight import Place, harmonic_step, margins, pushes
from percuss.kernels.harmonic_observables import (
    carried_over_impact,
    crest,
    fourth_of_step,
    harmonic_place,
    harmonic_summit,
    is_within,
    lost_area,
    neighbour_in,
    top_of_step,
)
from percuss.kernels.lockstep import (
    AREA,
    AT,
    AT_LOW,
    BEFORE,
    BOUNDS,
    COUNTED_FROM,
    DONE,
    FEW,
    FOURTH,
    LANDED,
    LOG_KEPT,
    MODE,
    NEAR_V,
    NEAR_X,
    NEXT_AT,
    NEXT_AT_LOW,
    OTHER,
    OTHER_TOP,
    PULL,
    PULL_COS,
    PULL_SIN,
    RESTITUTION,
    SEEN_V,
    SEEN_Y,
    SIGN,
    SLACK,
    SLOTS,
    STROBE,
    SUMMIT,
    TOP,
    TOP_FROM,
    TOP_PUSH,
    TOP_RATE,
    TOP_W,
    TOP_Y,
    WALK_PUSH,
    WALK_RATE,
    WAS_AREA,
    WAS_V,
    WAS_X,
    S,
    W,
    Y,
    begin_at,
    bounds_at,
    motion_at,
    walk_at,
)
from percuss.kernels.next_event import STEPS_A_WALK

# Pairs of steps that all others make for the last few.
PATIENCE = 4


@kernel
def see_strobes(block: Floats) -> None:
    """Find the places of the next strobes, where they fall on the flights."""
    if not any_strobe(block):
        return
    for i in range(SLOTS):
        sign = block[SIGN * SLOTS + i]
        y, v = harmonic_place(motion_at(block, i), begin_at(block, i), time_of_strobe(block, i))
        block[SEEN_Y * SLOTS + i] = sign * y
        block[SEEN_V * SLOTS + i] = sign * v


@kernel
def see_neighbours(block: Floats) -> None:
    """Find where neighbours are at the next strobes, where they fall on the flights."""
    if not any_strobe(block):
        return
    for i in range(SLOTS):
        ahead = (block[WAS_X * SLOTS + i], block[WAS_V * SLOTS + i])
        x, v = neighbour_in(motion_at(block, i), time_of_strobe(block, i), ahead)
        block[SEEN_Y * SLOTS + i] = x
        block[SEEN_V * SLOTS + i] = v


@formula
def any_strobe(block: Floats) -> bool:
    """Return whether a strobe falls on a flight."""
    due = 0
    for i in range(SLOTS):
        landed = block[MODE * SLOTS + i] == LANDED
        due += int(landed & (block[STROBE * SLOTS + i] < block[NEXT_AT * SLOTS + i]))
    return due > 0


@formula
def time_of_strobe(block: Floats, i: int) -> float:
    """Return when after the beginning of a flight the next strobe comes, 0 for none on it."""
    instant = block[STROBE * SLOTS + i]
    s = max((instant - block[AT * SLOTS + i]) - block[AT_LOW * SLOTS + i], 0.0)
    return s if instant < block[NEXT_AT * SLOTS + i] else 0.0


@kernel
def find_summits(block: Floats) -> None:
    """Find the highest points of the flights that are counted, NaN where they are left open."""
    begin_climb(block)
    patience = PATIENCE
    for k in range(0, STEPS_A_WALK, 2):
        climb(block, 0, OTHER, float(k))
        climbing = climb(block, OTHER, 0, k + 1.0)
        if climbing <= FEW:
            patience -= 1
        if climbing == 0 or patience == 0:
            break
    reach_summits(block)
    for i in range(SLOTS):
        # Those that others would wait for have been left on their way.
        if block[SUMMIT * SLOTS + i] == math.inf:
            block[SUMMIT * SLOTS + i] = harmonic_summit(
                motion_at(block, i),
                walk_at(block, i),
                bounds_at(block, i),
                begin_at(block, i),
                block[S * SLOTS + i],
            )


@formula
def begin_climb(block: Floats) -> None:
    """Go back to where the flights begin; S receives how long those last that are counted."""
    for i in range(SLOTS):
        t = block[NEXT_AT * SLOTS + i]
        counted = (block[MODE * SLOTS + i] == LANDED) & (t >= block[COUNTED_FROM * SLOTS + i])
        end = (t - block[AT * SLOTS + i]) + (
            block[NEXT_AT_LOW * SLOTS + i] - block[AT_LOW * SLOTS + i]
        )
        begin = begin_at(block, i)
        fourth, _, slack = margins(motion_at(block, i), bounds_at(block, i), begin)
        block[S * SLOTS + i] = end if counted else 0.0
        block[FOURTH * SLOTS + i] = fourth
        block[SLACK * SLOTS + i] = slack
        block[Y * SLOTS + i] = 0.0
        block[W * SLOTS + i] = begin[3]
        block[WALK_PUSH * SLOTS + i] = begin[1]
        block[WALK_RATE * SLOTS + i] = begin[2]
        block[TOP * SLOTS + i] = -math.inf
        block[OTHER_TOP * SLOTS + i] = -math.inf
        block[TOP_FROM * SLOTS + i] = 0.0
        block[TOP_Y * SLOTS + i] = 0.0
        block[TOP_W * SLOTS + i] = begin[3]
        block[TOP_PUSH * SLOTS + i] = begin[1]
        block[TOP_RATE * SLOTS + i] = begin[2]


@formula
def climb(block: Floats, source: int, target: int, k: float) -> int:
    """Make the k-th step, noting the highest; return how many flights go on from it."""
    climbing = 0
    for i in range(SLOTS):
        step = block[BOUNDS * SLOTS + i]
        end = block[S * SLOTS + i]
        before = (
            block[(source + Y) * SLOTS + i],
            block[(source + W) * SLOTS + i],
            block[(source + WALK_PUSH) * SLOTS + i],
            block[(source + WALK_RATE) * SLOTS + i],
        )
        greatest = block[TOP * SLOTS + i]
        other = block[OTHER_TOP * SLOTS + i]
        since = block[TOP_FROM * SLOTS + i]
        highest = top_place_at(block, i)
        pull = block[PULL * SLOTS + i]
        after = harmonic_step(walk_at(block, i), pull, before)
        fourth = fourth_of_step(
            motion_at(block, i), bounds_at(block, i), pull, before, block[FOURTH * SLOTS + i]
        )
        top = top_of_step(step, before, after, fourth, block[SLACK * SLOTS + i])
        top = top if step * k < end else -math.inf
        is_new = top > greatest
        block[OTHER_TOP * SLOTS + i] = max(other, min(greatest, top))
        block[TOP * SLOTS + i] = top if is_new else greatest
        block[TOP_FROM * SLOTS + i] = step * k if is_new else since
        block[TOP_Y * SLOTS + i] = before[0] if is_new else highest[0]
        block[TOP_W * SLOTS + i] = before[1] if is_new else highest[1]
        block[TOP_PUSH * SLOTS + i] = before[2] if is_new else highest[2]
        block[TOP_RATE * SLOTS + i] = before[3] if is_new else highest[3]
        block[(target + Y) * SLOTS + i] = after[0]
        block[(target + W) * SLOTS + i] = after[1]
        block[(target + WALK_PUSH) * SLOTS + i] = after[2]
        block[(target + WALK_RATE) * SLOTS + i] = after[3]
        goes = step * (k + 1.0) < end
        block[SUMMIT * SLOTS + i] = math.inf if goes else 0.0
        climbing += int(goes)
    return climbing


@formula
def top_place_at(block: Floats, i: int) -> Place:
    """Return where the highest step of a slot begins."""
    return (
        block[TOP_Y * SLOTS + i],
        block[TOP_W * SLOTS + i],
        block[TOP_PUSH * SLOTS + i],
        block[TOP_RATE * SLOTS + i],
    )


@formula
def reach_summits(block: Floats) -> None:
    """Go to the highest points from where the highest steps begin; inf stays inf."""
    for i in range(SLOTS):
        left = block[SUMMIT * SLOTS + i]
        highest = (
            block[TOP_FROM * SLOTS + i],
            block[OTHER_TOP * SLOTS + i],
            top_place_at(block, i),
        )
        top = crest(
            motion_at(block, i),
            walk_at(block, i),
            bounds_at(block, i),
            begin_at(block, i),
            highest,
            block[FOURTH * SLOTS + i],
        )
        top = top if block[TOP * SLOTS + i] > -math.inf else math.nan
        block[SUMMIT * SLOTS + i] = left if left == math.inf else top


@kernel
def carry_neighbours(block: Floats) -> int:
    """Carry neighbours along the flights and over the impacts; return how many are to be served.

    Those are the motions with a strobe on the flight, or a neighbour whose distance leaves the
    range of floats.
    """
    served = 0
    for i in range(SLOTS):
        motion = motion_at(block, i)
        landed = block[MODE * SLOTS + i] == LANDED
        t = block[NEXT_AT * SLOTS + i]
        t_low = block[NEXT_AT_LOW * SLOTS + i]
        pull = (block[PULL_COS * SLOTS + i], block[PULL_SIN * SLOTS + i])
        x = block[NEAR_X * SLOTS + i]
        v = block[NEAR_V * SLOTS + i]
        area = block[AREA * SLOTS + i]
        done = block[DONE * SLOTS + i]
        push, _ = pushes(pull, cos_sin(motion[9], motion[10], t, t_low))
        s = (t - block[AT * SLOTS + i]) + (t_low - block[AT_LOW * SLOTS + i])
        impact = (
            block[RESTITUTION * SLOTS + i],
            block[PULL * SLOTS + i] + push,
            block[BEFORE * SLOTS + i] if landed else -1.0,
        )
        x1, v1 = carried_over_impact(motion, s, impact, (x, v))
        is_due = block[STROBE * SLOTS + i] < t
        stops = landed & ((not is_within((x1, v1))) | is_due)
        served += int(stops & (done == 1.0))
        block[WAS_X * SLOTS + i] = x
        block[WAS_V * SLOTS + i] = v
        block[WAS_AREA * SLOTS + i] = area
        block[NEAR_X * SLOTS + i] = x1 if landed else x
        block[NEAR_V * SLOTS + i] = v1 if landed else v
        lost = lost_area(motion, s, block[LOG_KEPT * SLOTS + i])
        block[AREA * SLOTS + i] = area + lost if landed else area
        block[DONE * SLOTS + i] = 0.0 if stops else done
    return served
