"""Attractors told apart: which motions of many have gone to the same one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.chaos import Chaos, same_chaos
from percuss.ensembles.fates import (
    CHAOTIC,
    LONGEST,
    LONGEST_OF_ALL,
    NO_START,
    PERIODIC,
    REST,
    UNBOUNDED,
    Arrays,
)
from percuss.ensembles.lanes import Plan, follow_lanes
from percuss.ensembles.measures import period_of
from percuss.ensembles.refining import NEAR, System, refined_orbit, strobes_of_orbit
from percuss.kernels import survey
from percuss.numerics import log
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["Attractor", "label_starts"]

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Forcing periods after which an orbit has come to its limit, and how often it is given as many
# again: a weakly damped motion turns about its limit for long.
SETTLING, AGAIN = 500, 20
# A motion that turns out to be the slow beginning of something else costs a while: so many
# periodic ones are tried, and so many chaotic ones.
MOST_FAILURES, MOST_TRANSIENTS = 1000, 100
# Starts that are compared with an orbit at a time: of a million, each array on the way would take
# as much memory as a third of the answer.
AT_ONCE = 65_536
# Where every start has an orbit of its own, as without a spring or without damping, these many are
# told apart.
MOST_ORBITS = 1000


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor, or what motions do that have none.

    Attributes
    ----------
    kind
        "periodic", "chaotic", "rest" or "unbounded".
    n_periods, n_impacts
        Forcing periods and impacts of one round, inf with sticking; 0 and NaN where it is not
        periodic.
    strobes
        (n, 2) array, x and v at whole periods: of a whole round, or many of a chaotic motion.
    exponent, error
        Largest Lyapunov exponent, of an orbit from its multipliers, and its standard error where
        it is taken from a motion [1/time]; NaN where it is not known.
    orbit
        The periodic orbit, to full accuracy; None where it is not periodic or was not found.
    """

    kind: str
    n_periods: int = 0
    n_impacts: float = math.nan
    strobes: Floats = field(default_factory=lambda: np.full((1, 2), np.nan))
    exponent: float = math.nan
    error: float = math.nan
    orbit: PeriodicOrbit | None = None

    @property
    def name(self) -> str:
        """(impacts, forcing periods) of one round, or the kind."""
        if self.kind != "periodic":
            return self.kind
        return f"({self.n_impacts:g}, {self.n_periods})"


def label_starts(system: System, arrays: Arrays) -> tuple[Numbers, list[Attractor]]:
    """Return the number of each start's attractor, and the attractors.

    Numbers are given in the order of the starts, so they depend on nothing else. A start that was
    not decided has -1, one that is none -2.

    Parameters
    ----------
    system
        What moves; the same for all starts.
    arrays
        What has become of each, by the names of `FateColumns`.
    """
    kind = arrays["kind"]
    labels = np.where(kind == NO_START, NO_START, -1).astype(np.int64)
    found: list[tuple[int, Attractor]] = []
    for value, members in (
        (PERIODIC, _periodic),
        (CHAOTIC, _chaotic),
        (REST, _resting),
        (UNBOUNDED, _unbounded),
    ):
        rows = np.flatnonzero(kind == value)
        for those, attractor in members(system, arrays, rows) if len(rows) else ():
            found.append((int(those[0]), attractor))
            labels[those] = -3 - len(found)
    # By the first start that goes there.
    order = sorted(range(len(found)), key=lambda i: found[i][0])
    # All at once: with many starts and many attractors one at a time would take long.
    number = np.zeros(len(found) + 4, dtype=np.int64)
    number[[i + 4 for i in order]] = np.arange(len(order))
    attracted = labels <= -4
    labels[attracted] = number[-labels[attracted]]
    return labels, [found[i][1] for i in order]


Members = Iterator[tuple[Numbers, Attractor]]


def _periodic(system: System, arrays: Arrays, rows: Numbers) -> Members:
    """Match motions with one another by the strobes of a whole round, followed to its limit."""
    left, failures, found = rows, 0, 0
    while len(left) and failures < MOST_FAILURES and found < MOST_ORBITS:
        strobe = np.asarray(arrays["strobe"][left[0]], dtype=np.float64)
        is_long = int(arrays["n_periods"][left[0]]) > LONGEST
        attractor = _orbit_of(system, strobe, LONGEST_OF_ALL if is_long else LONGEST)
        same = _are_near(np.asarray(arrays["strobe"]), left, attractor.strobes)
        if attractor.n_periods == 0 or not same[0]:
            # It was the slow beginning of something else: not decided.
            left, failures = left[1:], failures + 1
            continue
        yield left[same], attractor
        left, found = left[~same], found + 1


def _are_near(strobes: Floats, rows: Numbers, orbit: Floats) -> NDArray[np.bool_]:
    size = float(np.abs(orbit).max(initial=0.0)) or 1.0
    near = np.zeros(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        own = strobes[rows[part]]
        for point in orbit:
            near[part] |= np.abs(own - point).max(axis=1) <= NEAR * size
    return near


def _orbit_of(system: System, strobe: Floats, longest: int) -> Attractor:
    """Return the attractor that a periodic motion settles on, refined where it can be."""
    strobes, n_impacts = _round(system, strobe, longest)
    n_periods = len(strobes)
    if n_periods == 0:
        return Attractor("periodic")
    orbit = refined_orbit(system, strobes[0], n_periods, n_impacts)
    if orbit is None:
        return Attractor("periodic", n_periods, n_impacts, strobes)
    with np.errstate(divide="ignore"):
        exponent = float(log(np.abs(orbit.multipliers).max()) / orbit.period)
    refined = strobes_of_orbit(system, orbit, strobes[0])
    return Attractor("periodic", orbit.n_periods, orbit.n_impacts, refined, exponent, orbit=orbit)


def _round(system: System, strobe: Floats, longest: int) -> tuple[Floats, float]:
    """Return the strobes of a round of a periodic motion after a long time, and its impacts."""
    which, every = np.zeros(1, dtype=np.int64), np.array([system.period])
    since = np.array([system.t0 + SETTLING * system.period])
    until = since + 2 * longest * system.period
    plan = Plan(since, every, until, section=survey.STROBES, n_points=2 * longest + 1)
    for _ in range(AGAIN):
        begin = np.array([[*strobe, system.t0]])
        lanes = follow_lanes(system.table[np.newaxis], which, begin, plan)
        points = np.nan_to_num(lanes.points[:, :, :2])
        n_periods = int(period_of(points, longest)[0])
        if n_periods:
            break
        strobe = points[0, -1]
    n_impacts = round(float(lanes.tallies[0, survey.IMPACTS]) * n_periods / (2 * longest))
    return points[0, :n_periods], float(n_impacts)


def _chaotic(system: System, arrays: Arrays, rows: Numbers) -> Members:
    """Match motions by their strobes and their largest exponents."""
    left, failures = rows, 0
    while len(left) and failures < MOST_TRANSIENTS:
        chaos = Chaos.of(system, np.asarray(arrays["strobe"][left[0]], dtype=np.float64))
        if not chaos.lasts:
            # It was a transient: not decided.
            left, failures = left[1:], failures + 1
            continue
        same = same_chaos(system, chaos, arrays, left)
        same[0] = True
        yield (
            left[same],
            Attractor("chaotic", 0, math.nan, chaos.strobes, chaos.exponent, chaos.error),
        )
        left = left[~same]


def _resting(system: System, arrays: Arrays, rows: Numbers) -> Members:  # noqa: ARG001
    places = np.asarray(arrays["strobe"])[rows, 0]
    for place in np.unique(places):
        at = np.array([[place, 0.0]], dtype=np.float64)
        yield rows[places == place], Attractor("rest", strobes=at, exponent=-math.inf)


def _unbounded(system: System, arrays: Arrays, rows: Numbers) -> Members:  # noqa: ARG001
    yield rows, Attractor("unbounded")
