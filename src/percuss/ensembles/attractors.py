"""Attractors told apart: which motions of many have gone to the same one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.lanes import Plan, follow_lanes
from percuss.ensembles.measures import period_of
from percuss.kernels import survey
from percuss.kernels.law import PERIOD

__all__ = ["CHAOTIC", "PERIODIC", "REST", "UNBOUNDED", "Attractor", "label_starts"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# The kinds of what a start goes to, as they are stored.
PERIODIC, CHAOTIC, REST, UNBOUNDED = range(4)
_NAMES = ("periodic", "chaotic", "rest", "unbounded")

# Forcing periods after which an orbit has come to its limit; and its longest period.
REFINED, LONGEST = 500, 16
# Strobes of the same periodic orbit are nearer to one another than this part of its size: motions
# that were called periodic agree with themselves to 1e-6 only.
NEAR = 1e-4
# Strobes that fill a chaotic attractor, and how near to one of them, in parts of the attractor's
# size, most strobes of another motion on it come.
STROBES_OF_CHAOS = 4000
NEAR_CHAOS, MOST = 0.02, 0.95
# Strobes of a motion that is asked for its attractor.
ASKED = 40


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor, or what motions do that have none.

    Attributes
    ----------
    kind
        "periodic", "chaotic", "rest" or "unbounded".
    n_periods, n_impacts
        Forcing periods and impacts of one round; 0 and NaN where it is not periodic.
    strobe
        x and v at whole periods, of one of the strobes; NaN for unbounded motions.
    """

    kind: str
    n_periods: int
    n_impacts: float
    strobe: tuple[float, float]


def label_starts(job: Any, arrays: Mapping[str, NDArray[Any]]) -> tuple[Numbers, list[Attractor]]:
    """Return the number of each start's attractor, and the attractors.

    Numbers are given in the order of the starts, so they depend on nothing else. A start that was
    not decided has -1, one that is none -2.

    Parameters
    ----------
    job
        The job of `basins`.
    arrays
        Its answer.
    """
    kind = arrays["kind"]
    labels = np.where(kind == -2, -2, -1).astype(np.int64)
    found: list[tuple[int, Attractor]] = []
    for value, members in (
        (PERIODIC, _periodic),
        (CHAOTIC, _chaotic),
        (REST, _resting),
        (UNBOUNDED, _unbounded),
    ):
        rows = np.flatnonzero(kind == value)
        for those, attractor in members(job, arrays, rows) if len(rows) else []:
            found.append((int(those[0]), attractor))
            labels[those] = -3 - len(found)
    # By the first start that goes there.
    order = sorted(range(len(found)), key=lambda i: found[i][0])
    for number, i in enumerate(order):
        labels[labels == -4 - i] = number
    return labels, [found[i][1] for i in order]


Members = list[tuple[Numbers, Attractor]]


def _periodic(job: Any, arrays: Mapping[str, NDArray[Any]], rows: Numbers) -> Members:
    """Match motions with one another by the strobes of a whole round, followed to its limit."""
    found: Members = []
    left = rows
    while len(left):
        first = left[0]
        orbit, n_impacts = _round(job, int(first), arrays["strobe"][first])
        size = float(np.abs(orbit).max(initial=0.0)) or 1.0
        distance = np.full(len(left), np.inf)
        for point in orbit:
            apart = np.abs(arrays["strobe"][left] - point).max(axis=1)
            distance = np.minimum(distance, apart)
        same = distance <= NEAR * size
        if not same[0]:
            # It was the slow beginning of something else: not decided.
            left = left[1:]
            continue
        strobe = (float(orbit[0, 0]), float(orbit[0, 1]))
        found.append((left[same], Attractor(_NAMES[PERIODIC], len(orbit), n_impacts, strobe)))
        left = left[~same]
    return found


def _round(job: Any, row: int, strobe: Floats) -> tuple[Floats, float]:
    """Return the strobes of a round of a periodic motion after a long time, and its impacts."""
    (group,), _ = job.grid.lanes(row, row + 1)
    period = group.laws[group.which, 0, PERIOD]
    begin = np.array([[strobe[0], strobe[1], group.starts[0, 2] if job.stop is None else 0.0]])
    since = begin[:, 2] + REFINED * period
    until = since + 2 * LONGEST * period
    plan = Plan(since, period, until, section=survey.STROBES, n_points=2 * LONGEST + 1)
    lanes = follow_lanes(group.laws, group.which, begin, plan)
    points = np.nan_to_num(lanes.points[:, :, :2])
    n_periods = int(period_of(points, LONGEST)[0])
    n_impacts = round(float(lanes.tallies[0, survey.IMPACTS]) * n_periods / (2 * LONGEST))
    return points[0, :n_periods], float(n_impacts)


def _chaotic(job: Any, arrays: Mapping[str, NDArray[Any]], rows: Numbers) -> Members:
    """Match motions by whether their strobes lie among those of a long one."""
    found: Members = []
    left = rows
    while len(left):
        first = left[0]
        cloud = _strobes(job, int(first), arrays["strobe"][first], STROBES_OF_CHAOS)
        size = np.ptp(cloud, axis=0)
        size[size == 0.0] = 1.0
        same = np.array([_is_among(job, arrays, int(row), cloud, size) for row in left])
        same[0] = True
        strobe = (float(cloud[0, 0]), float(cloud[0, 1]))
        found.append((left[same], Attractor(_NAMES[CHAOTIC], 0, np.nan, strobe)))
        left = left[~same]
    return found


def _is_among(
    job: Any, arrays: Mapping[str, NDArray[Any]], row: int, cloud: Floats, size: Floats
) -> bool:
    own = _strobes(job, row, arrays["strobe"][row], ASKED)
    apart = np.abs((own[:, np.newaxis] - cloud) / size).max(axis=2).min(axis=1)
    return bool((apart < NEAR_CHAOS).mean() > MOST)


def _resting(job: Any, arrays: Mapping[str, NDArray[Any]], rows: Numbers) -> Members:  # noqa: ARG001
    found: Members = []
    for place in np.unique(arrays["strobe"][rows, 0]):
        those = rows[arrays["strobe"][rows, 0] == place]
        found.append((those, Attractor(_NAMES[REST], 0, np.nan, (float(place), 0.0))))
    return found


def _unbounded(job: Any, arrays: Mapping[str, NDArray[Any]], rows: Numbers) -> Members:  # noqa: ARG001
    return [(rows, Attractor(_NAMES[UNBOUNDED], 0, np.nan, (np.nan, np.nan)))]


def _strobes(job: Any, row: int, strobe: Floats, count: int) -> Floats:
    """Return so many strobes from one on, that one included."""
    (group,), _ = job.grid.lanes(row, row + 1)
    period = group.laws[group.which, 0, PERIOD]
    begin = np.array([[strobe[0], strobe[1], group.starts[0, 2] if job.stop is None else 0.0]])
    since = begin[:, 2].copy()
    until = since + (count - 1) * period
    plan = Plan(since, period, until, section=survey.STROBES, n_points=count)
    if count == 1:
        return begin[:, :2]
    lanes = follow_lanes(group.laws, group.which, begin, plan)
    return np.asarray(lanes.points[0, :, :2])
