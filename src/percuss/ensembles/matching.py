"""Attractors carried on from one value of a parameter to the next."""

from __future__ import annotations

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
    """What there is at one value of the parameter.

    Attributes
    ----------
    attractors
        By number, the same from value to value.
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


def follow_attractors(grid: Grid, rules: Rules, arrays: Arrays, n_starts: int) -> list[Followed]:
    """Return the attractors at each value of a grid's parameter, in the order of its values.

    Parameters
    ----------
    grid
        The values.
    rules
        When a start is decided.
    arrays
        What has become of the starts, by the names of `FateColumns`, those of a value together.
    n_starts
        Starts at each value.
    """
    found: list[Followed] = []
    known: dict[int, Attractor] = {}
    n_known = 0
    for k in range(grid.size):
        own = {name: array[k * n_starts : (k + 1) * n_starts] for name, array in arrays.items()}
        try:
            osc, force, _ = grid.point(k)
        except ParameterError:
            # A value that has no motion is passed over, as nothing was started there.
            found.append(Followed({}, {}, float("nan"), 0))
            continue
        assert force is not None
        system = System.of(osc, force, rules.t0)
        seeds = [(number, place) for number, one in known.items() for place in _seeds(one)]
        fates = _fates(system, rules, [place for _, place in seeds])
        both = {name: np.concatenate([own[name], fates[name]]) for name in own}
        labels, attractors = label_starts(system, both)
        numbers = _matched(known, attractors, labels[n_starts:], [number for number, _ in seeds])
        for i in range(len(attractors)):
            if i not in numbers:
                numbers[i], n_known = n_known, n_known + 1
        part, error, undecided, n = fractions_of(labels[:n_starts], len(attractors))
        known = {numbers[i]: one for i, one in enumerate(attractors)}
        fractions = {numbers[i]: (float(part[i]), float(error[i])) for i in range(len(attractors))}
        found.append(Followed(dict(sorted(known.items())), fractions, undecided, n))
    return found


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
    known: dict[int, Attractor],
    attractors: Sequence[Attractor],
    labels: Numbers,
    owners: Sequence[int],
) -> dict[int, int]:
    """Return the numbers of those attractors that points of a known one have gone to."""
    links: list[tuple[float, int, int]] = []
    for number, one in known.items():
        gone = np.array([label for label, owner in zip(labels, owners, strict=True)
                         if owner == number and label >= 0], dtype=np.int64)  # fmt: skip
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
    return numbers


def _distance(one: Attractor, other: Attractor) -> float:
    """Return how far the points of two attractors are from one another, in the mean."""
    if one.kind == "unbounded" or other.kind == "unbounded":
        return float("inf")
    a, b = (it.strobes[np.isfinite(it.strobes).all(axis=1)][:500] for it in (one, other))
    apart = np.abs(a[:, np.newaxis] - b).max(axis=2)
    return float(0.5 * (apart.min(axis=0).mean() + apart.min(axis=1).mean()))
