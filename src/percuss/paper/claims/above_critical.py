"""Above the critical velocity of Y_m: which motions are chaotic, by the fate of neighbours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from percuss.certified import keeps_subset
from percuss.io.study_text import motion_text
from percuss.motion.eigenset_forms import subset_critical_velocity, subset_forcing
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.comparisons import WALL
from percuss.paper.evidence import Enclosure, Measurement, counted
from percuss.paper.statement import Finding, Statement

# Of the numbers m, and of V*.
NUMBERS = tuple(range(2, 8))
PARTS = (1.01, 1.05, 1.3, 2.0, 4.0)
# How far apart two neighbours start [velocity].
APART = 1e-9
# When their impacts are compared; those that are together then, again five times later: for
# m = 4, V0 = 4 V* they begin to part after t = 8000.
FIRST, LAST = 4000.0, 20_000.0
# Neighbours on invariant curves part in proportion to the number of impacts; in units of the first
# distance and an impact the factor is at most about 10. Those of a chaotic motion part by far more.
LINEAR, PARTED = 100.0, 1e-3
# Impact times of doubles near LAST, carried over some thousand impacts that do not amplify.
ROUNDING = 1e-8


@dataclass(frozen=True)
class Neighbours:
    """Two motions that start APART, and what becomes of them.

    Parameters
    ----------
    m, v0
        Which Y_m, and the lower velocity of the two starts.
    goes_on
        Whether the motion was followed up to the end.
    distance
        Largest distance of impact times of the same number, in the last tenth of the run.
    impacts
        How many impacts that were.
    """

    m: int
    v0: float
    goes_on: bool
    distance: float
    impacts: int

    @property
    def growth(self) -> float:
        """How much the distance grew at an impact, in units of the first distance."""
        return self.distance / APART / self.impacts


def _run(m: int, v0: float, t_end: float) -> Trajectory:
    return simulate(WALL, subset_forcing(m), v0=v0, t_end=t_end)


def _follow(m: int, v0: float, t_end: float) -> Neighbours:
    one, other = (_run(m, v, t_end) for v in (v0, v0 + APART))
    both = min(len(one.impacts), len(other.impacts))
    last = slice(both - both // 10, both)
    return Neighbours(
        m,
        v0,
        one.outcome.name == "reached_t_end",
        float(np.abs(one.impacts.t[last] - other.impacts.t[last]).max()),
        both,
    )


@cache
def neighbours_above(parts: tuple[float, ...] = PARTS) -> tuple[Neighbours, ...]:
    """Return the motions for m = 2 to 7 from some multiples of V*, each with a neighbour."""
    neighbours = []
    for m in NUMBERS:
        for part in parts:
            pair = _follow(m, part * subset_critical_velocity(m), FIRST)
            if pair.distance < PARTED:
                pair = _follow(m, pair.v0, LAST)
            neighbours.append(pair)
    return tuple(neighbours)


def fastest_parting(pairs: tuple[Neighbours, ...]) -> Trajectory:
    """Return the motion whose neighbour parts fastest."""
    pair = max(pairs, key=lambda pair: pair.growth)
    return _run(pair.m, pair.v0, FIRST)


def is_chaotic(pair: Neighbours) -> bool:
    """Return whether two neighbours part faster than in proportion to the number of impacts."""
    return pair.growth > LINEAR


def _leaving(pairs: tuple[Neighbours, ...]) -> Enclosure:
    """Return how many of them provably have an impact that is none of Y_m."""
    leaving = sum(keeps_subset(pair.m, pair.v0).holds is False for pair in pairs)
    what = f"motions of {len(pairs)} with an impact that is none of Y_m"
    return Enclosure(what, leaving, 0.0, len(pairs), len(pairs), len(pairs))


def _above(parts: tuple[float, ...] = PARTS) -> Finding:
    """Follow motions above V*, each with a neighbour."""
    pairs = neighbours_above(parts)
    chaotic = [pair for pair in pairs if is_chaotic(pair)]
    regular = [pair for pair in pairs if not is_chaotic(pair)]
    going = counted(
        f"motions of {len(pairs)} (m = 2 to 7, up to {max(parts):g} V*) that go on",
        sum(pair.goes_on for pair in pairs),
        len(pairs),
    )
    printed = counted(
        "motions whose neighbours part faster than in proportion to the number of impacts",
        len(chaotic),
        len(pairs),
    )
    gap = (
        Measurement(
            "of the others: largest growth of the distance an impact, in units of the first one",
            max((pair.growth for pair in regular), default=math.nan),
            0.0,
            LINEAR / 5,
            ROUNDING / APART / 1000,
        ),
        Measurement(
            "of those: least growth of the distance an impact",
            min((pair.growth for pair in chaotic), default=math.nan),
            LINEAR * 5,
            math.inf,
            ROUNDING / APART / 1000,
        ),
    )
    which = ", ".join(_named(pair) for pair in regular)
    return Finding(
        (going, _leaving(pairs), printed),
        (going, _leaving(pairs), *gap),
        "the impact times are others than Y_m, but not always irregular: for some m and V0 they "
        "are chaotic, for others, as for m = 3 at 4 V*, quasi-periodic",
        remark=f"From each V0 a second motion starts {APART:g} faster. In {len(chaotic)} of the "
        f"{len(pairs)} motions the distance between the impacts of the two grows exponentially: "
        f"they are chaotic. In the other {len(regular)} it grows in proportion to the number of "
        f"impacts up to t = {LAST:g}: {which}. Their speeds stay within narrow bands. The counts "
        "belong to this choice of m and V0.",
        study=motion_text(fastest_parting(pairs)),
    )


def _named(pair: Neighbours) -> str:
    return f"m = {pair.m} from {pair.v0 / subset_critical_velocity(pair.m):.3g} V*"


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        id="above-critical",
        reference="section 3",
        claim="Above V* solutions exist, but involve different, irregular impact times.",
        method="30 simulated motions, each with a neighbour; ball arithmetic for leaving Y_m",
        find=_above,
        theory="paper-family.md",
    ),
)
