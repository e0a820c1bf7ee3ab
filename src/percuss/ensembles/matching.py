"""Attractors carried on from one value of the parameters to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.attractors import Attractor, label_starts
from percuss.ensembles.basins import fractions_of
from percuss.ensembles.fates import Arrays, Rules
from percuss.ensembles.grid import Grid, LanesOf, walls_of
from percuss.ensembles.refining import System
from percuss.errors import ParameterError

__all__ = ["Followed", "follow_attractors"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Points of an attractor that are followed at the next value: of an orbit all, of a chaotic one
# these, the most of which tell.
SEEDS = 9


@dataclass(frozen=True, slots=True)
class Followed:
    """What there is at one point of the parameters.

    Attributes
    ----------
    attractors
        By number, the same from point to point.
    fractions
        Part of the starts that go there and its standard error, by number.
    undecided
        Part of the starts that were not decided.
    n_starts
        Starts outside the walls.
    """

    attractors: dict[int, Attractor]
    fractions: dict[int, tuple[float, float]]
    undecided: float
    n_starts: int


# At a point whose parameters are outside their domains.
NO_MOTION = Followed({}, {}, math.nan, 0)


def follow_attractors(grid: Grid, rules: Rules, arrays: Arrays, n_starts: int) -> list[Followed]:
    """Return the attractors at each point of a grid of parameters, in the order of its points.

    Parameters
    ----------
    grid
        The values of one parameter or of several.
    rules
        When a start is decided.
    arrays
        What has become of the starts, by the names of `FateColumns`, those of a point together.
    n_starts
        Starts at each point.
    """
    found: list[Followed] = []
    n_known = 0
    meetings: list[tuple[int, int]] = []
    for k in range(grid.size):
        own = {name: array[k * n_starts : (k + 1) * n_starts] for name, array in arrays.items()}
        try:
            osc, force, _ = grid.point(k)
        except ParameterError:
            # A value that has no motion is passed over, as nothing was started there.
            found.append(NO_MOTION)
            continue
        assert force is not None
        system = System.of(osc, force, rules.t0)
        known = [pair for one in _before(found, grid.shape, k) for pair in one.attractors.items()]
        seeds = [(owner, place) for owner, (_, it) in enumerate(known) for place in _seeds(it)]
        fates = _fates(system, rules, [place for _, place in seeds])
        both = {name: np.concatenate([own[name], fates[name]]) for name in own}
        labels, attractors = label_starts(system, both)
        owners = [owner for owner, _ in seeds]
        numbers, met = _matched(known, attractors, labels[n_starts:], owners)
        meetings += met
        for i in range(len(attractors)):
            if i not in numbers:
                numbers[i], n_known = n_known, n_known + 1
        part, error, undecided, n = fractions_of(labels[:n_starts], len(attractors))
        there = sorted((numbers[i], i) for i in range(len(attractors)))
        found.append(
            Followed(
                {number: attractors[i] for number, i in there},
                {number: (float(part[i]), float(error[i])) for number, i in there},
                undecided,
                n,
            )
        )
    return _joined(found, meetings)


def _before(found: Sequence[Followed], shape: Sequence[int], k: int) -> list[Followed]:
    """Return what there is at the points before, one along each axis, the last axis first."""
    before = []
    stride = 1
    for length in reversed(shape):
        for steps in range(1, k // stride % length + 1):
            one = found[k - steps * stride]
            if one is not NO_MOTION:
                before.append(one)
                break
        stride *= length
    return before


def _joined(found: Sequence[Followed], meetings: Sequence[tuple[int, int]]) -> list[Followed]:
    """Give one number to those that have met and are never at the same point.

    What appears at two places of a chart and is carried on from both is one attractor.
    """
    where: dict[int, set[int]] = {}
    for k, one in enumerate(found):
        for number in one.attractors:
            where.setdefault(number, set()).add(k)
    root = {number: number for number in where}
    for pair in meetings:
        low, high = sorted(root[number] for number in pair)
        if low != high and not where[low] & where[high]:
            where[low] |= where.pop(high)
            root = {number: low if it == high else it for number, it in root.items()}
    dense = {number: i for i, number in enumerate(sorted(where))}
    return [
        replace(
            one,
            attractors={dense[root[number]]: it for number, it in one.attractors.items()},
            fractions={dense[root[number]]: it for number, it in one.fractions.items()},
        )
        for one in found
    ]


def _seeds(attractor: Attractor) -> Floats:
    """Return points of an attractor; none where motions have no place."""
    if attractor.kind == "unbounded":
        return np.empty((0, 2))
    points = attractor.strobes
    return points[:: max(1, len(points) // SEEDS)][:SEEDS] if len(points) > SEEDS else points


def _fates(system: System, rules: Rules, places: Sequence[Floats]) -> Arrays:
    """Return what becomes of points of the attractors before."""
    starts = np.column_stack([np.reshape(places, (len(places), 2)), np.full(len(places), rules.t0)])
    low, high = walls_of(system.table[np.newaxis])
    # A wall may have moved over them.
    starts[:, 0] = np.clip(starts[:, 0], low[0], high[0])
    which = np.zeros(len(starts), dtype=np.int64)
    group = LanesOf(system.table[np.newaxis], which, starts, which)
    return replace(rules, within=False).follow(group)[0]


def _matched(
    known: Sequence[tuple[int, Attractor]],
    attractors: Sequence[Attractor],
    labels: Numbers,
    owners: Sequence[int],
) -> tuple[dict[int, int], list[tuple[int, int]]]:
    """Return the numbers of those attractors that points of a known one have gone to.

    And the pairs of numbers of which both have gone to the same one.
    """
    links: list[tuple[float, int, int]] = []
    for k, (number, one) in enumerate(known):
        gone = np.array([label for label, owner in zip(labels, owners, strict=True)
                         if owner == k and label >= 0], dtype=np.int64)  # fmt: skip
        if one.kind == "unbounded":
            links += [(0.0, number, i) for i, it in enumerate(attractors) if it.kind == one.kind]
        elif len(gone):
            there = int(np.bincount(gone).argmax())
            links.append((_distance(one, attractors[there]), number, there))
    numbers: dict[int, int] = {}
    taken: set[int] = set()
    for _, number, there in sorted(links):
        if there not in numbers and number not in taken:
            numbers[there] = number
            taken.add(number)
    met = [(numbers[there], number) for _, number, there in links if number not in taken]
    return numbers, met


def _distance(one: Attractor, other: Attractor) -> float:
    """Return how far the points of two attractors are from one another, in the mean."""
    if one.kind == "unbounded" or other.kind == "unbounded":
        return float("inf")
    a, b = (it.strobes[np.isfinite(it.strobes).all(axis=1)][:500] for it in (one, other))
    apart = np.abs(a[:, np.newaxis] - b).max(axis=2)
    return float(0.5 * (apart.min(axis=0).mean() + apart.min(axis=1).mean()))
