"""Which motions of many have gone to the same attractor, and what these attractors are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.ensembles.batch import BatchResult, Plan, exponents_of, follow_batch, tangent_plan
from percuss.ensembles.classification import (
    CERTAIN,
    CHAOTIC,
    LEAST_EXPONENT,
    LONGEST,
    LONGEST_OF_ALL,
    NO_START,
    PERIODIC,
    REST,
    UNBOUNDED,
    Arrays,
)
from percuss.ensembles.measures import period_of
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels import survey
from percuss.kernels.law import PERIOD
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.system import System
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.numerics import hypot, log
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits

__all__ = ["Attractor", "Chaos", "StrobedSystem", "impacts_at", "label_starts", "same_chaos"]


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
# distinguished.
MOST_ORBITS = 1000


@dataclass(frozen=True, slots=True)
class Attractor:
    """One attractor, or what motions do that have none.

    Attributes
    ----------
    kind
        "periodic", "chaotic", "rest" or "unbounded".
    n_periods, n_impacts
        Forcing periods and impacts in one period of the orbit, inf with sticking; 0 and NaN where it is not
        periodic.
    strobes
        (n, 2) array, x and v once a forcing period: over one period of the orbit, or many of a chaotic motion.
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
        """(impacts, forcing periods) in one period of the orbit, or the kind."""
        if self.kind != "periodic":
            return self.kind
        return f"({self.n_impacts:g}, {self.n_periods})"


GoOn: TypeAlias = Callable[[], bool]
Members: TypeAlias = Iterator[tuple[Integers, Attractor]]


def _always() -> bool:
    return True


def label_starts(
    system: StrobedSystem, arrays: Arrays, go_on: GoOn = _always
) -> tuple[Integers, list[Attractor]]:
    """Return the number of each start's attractor, and the attractors.

    Integers are given in the order of the starts, so they depend on nothing else. A start that was
    not decided has -1, one that is none -2.

    Parameters
    ----------
    system
        What moves; the same for all starts.
    arrays
        What has become of each, by the names of `CLASS_COLUMNS`.
    go_on
        Called before each attractor is looked for; where it returns False the starts that are
        left stay undecided.
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
        for those, attractor in members(system, arrays, rows, go_on) if len(rows) else ():
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


def _periodic(system: StrobedSystem, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:
    """Match motions with one another by the strobes over one period of the orbit, followed to its limit."""
    left, failures, found = rows, 0, 0
    while len(left) and failures < MOST_FAILURES and found < MOST_ORBITS and go_on():
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


def _are_near(strobes: Floats, rows: Integers, orbit: Floats) -> Flags:
    size = float(np.abs(orbit).max(initial=0.0)) or 1.0
    near = np.zeros(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        own = strobes[rows[part]]
        for point in orbit:
            near[part] |= np.abs(own - point).max(axis=1) <= NEAR * size
    return near


def _orbit_of(system: StrobedSystem, strobe: Floats, longest: int) -> Attractor:
    """Return the attractor that a periodic motion settles on, refined where it can be."""
    strobes, n_impacts = _settled_strobes(system, strobe, longest)
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


def _settled_strobes(system: StrobedSystem, strobe: Floats, longest: int) -> tuple[Floats, float]:
    """Return strobes and impacts over one period of a periodic motion after a long time."""
    which, every = np.zeros(1, dtype=np.int64), np.array([system.period])
    since = np.array([system.t0 + SETTLING * system.period])
    until = since + 2 * longest * system.period
    plan = Plan(since, every, until, section=survey.STROBES, n_points=2 * longest + 1)
    for _ in range(AGAIN):
        begin = np.array([[*strobe, system.t0]])
        result = follow_batch(system.law[np.newaxis], which, begin, plan)
        points = np.nan_to_num(result.points[:, :, :2])
        n_periods = int(period_of(points, longest)[0])
        if n_periods:
            break
        strobe = points[0, -1]
    n_impacts = round(float(result.tallies[0, survey.IMPACTS]) * n_periods / (2 * longest))
    return points[0, :n_periods], float(n_impacts)


def _chaotic(system: StrobedSystem, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:
    """Match motions by their strobes and their largest exponents."""
    left, failures = rows, 0
    while len(left) and failures < MOST_TRANSIENTS and go_on():
        chaos = Chaos.of(system, np.asarray(arrays["strobe"][left[0]], dtype=np.float64))
        if not chaos.persists:
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


def _resting(system: StrobedSystem, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:  # noqa: ARG001
    places = np.asarray(arrays["strobe"])[rows, 0]
    for place in np.unique(places):
        at = np.array([[place, 0.0]], dtype=np.float64)
        yield rows[places == place], Attractor("rest", strobes=at, exponent=-math.inf)


def _unbounded(system: StrobedSystem, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:  # noqa: ARG001
    yield rows, Attractor("unbounded")


# Strobes of the same periodic orbit are nearer to one another than this part of its size: motions
# that were called periodic agree with themselves to 1e-6 from one period to the next, and one that turns
# about its limit may be a hundred times as far from it.
NEAR = 3e-4
# Periods of an orbit that a run covers, from which Newton's method starts.
ORBIT_PERIODS = 3


@dataclass(frozen=True, slots=True)
class StrobedSystem:
    """What moves, and when its strobes are taken.

    Attributes
    ----------
    osc, force
        What moves; the forcing has a period.
    law
        Its law.
    t0
        An instant of a strobe [time].
    """

    osc: Oscillator
    force: Forcing
    law: Floats
    t0: float

    @classmethod
    def of(cls, osc: Oscillator, force: Forcing, t0: float) -> StrobedSystem:
        """Return a system with its law."""
        return cls(osc, force, law(osc, force), t0)

    @property
    def period(self) -> float:
        """The forcing period [time]."""
        return float(self.law[0, PERIOD])

    def run(self, strobe: Floats, periods: int) -> Trajectory:
        """Return the motion from a strobe on over so many forcing periods."""
        x, v = (float(part) for part in strobe)
        return simulate(self.osc, self.force, x, v, self.t0, t_end=self.t0 + periods * self.period)


def refined_orbit(
    system: StrobedSystem, strobe: Floats, n_periods: int, n_impacts: float
) -> PeriodicOrbit | None:
    """Return the periodic orbit that a motion has settled on, None where none is found there.

    Parameters
    ----------
    system
        What moves.
    strobe
        (2,) array, x and v of the motion at a strobe.
    n_periods, n_impacts
        Forcing periods and impacts in one period of the orbit.

    Returns
    -------
    PeriodicOrbit or None
        The orbit, whose strobes lie where the motion's do.
    """
    try:
        for orbit in _candidates(system, strobe, n_periods, n_impacts):
            strobes = strobes_of_orbit(system, orbit, strobe)
            size = float(np.abs(strobes).max(initial=0.0)) or 1.0
            if orbit.admissible and np.abs(strobes[0] - strobe).max() <= NEAR * size:
                return orbit
    except (ConvergenceError, ParameterError):
        # It has not settled enough, or lies where impacts accumulate.
        return None
    return None


def _candidates(
    system: StrobedSystem, strobe: Floats, n_periods: int, n_impacts: float
) -> Iterator[PeriodicOrbit]:
    osc, force = system.osc, system.force
    if n_impacts == 0:
        for region in regions(system.law):
            try:
                yield steady_orbit(System(osc, force), region)
            except ConvergenceError:
                continue
        return
    run = system.run(strobe, ORBIT_PERIODS * n_periods)
    last = run.t_end - n_periods * system.period
    if len(run.contacts) and run.contacts.start[-1] >= last:
        yield from sticking_orbits(System(osc, force), n_periods)
    else:
        yield find_orbit(osc, force, n_impacts, n_periods, guess=run, formal=True)


def strobes_of_orbit(system: StrobedSystem, orbit: PeriodicOrbit, near: Floats) -> Floats:
    """Return x and v of an orbit at all of its strobes, the one nearest to a place first.

    Returns
    -------
    (n_periods, 2) array
        In the order of time.
    """
    period = system.period
    first = system.t0 + math.ceil((orbit.t0 - system.t0) / period) * period
    t = first + np.arange(orbit.n_periods) * period
    strobes = np.stack(orbit.trajectory(2)(t), axis=1)
    nearest = int(np.abs(strobes - near).max(axis=1).argmin())
    return np.roll(strobes, -nearest, axis=0)


def impacts_at(
    system: StrobedSystem, stop: int, strobe: Floats, orbit: PeriodicOrbit | None, periods: int
) -> Floats:
    """Return cycle and speed after the impacts at a stop, of an orbit or of a motion.

    Returns
    -------
    (n, 2) array
        One row an impact.
    """
    impacts = orbit.impacts if orbit is not None else system.run(strobe, periods).impacts
    there = impacts.stop == stop
    return np.stack([impacts.cycle[there], np.abs(impacts.v_after[there])], axis=1)


# Strobes that fill an attractor, those of a motion that is asked for its attractor, and the cells
# along each axis in which they are compared.
FILLING, ASKED, CELLS = 4000, 40, 50
# Most strobes of a motion lie in a cell of the attractor or next to one.
MOST = 0.95
# Forcing periods of the exponent of an attractor, and of a motion that seems to have another.
LONG = 16_384
# Exponents that differ by more than so many standard errors are not the same.
DIFFERENT = 6.0
# Motions that are asked at a time.
MOTIONS_AT_ONCE = 4096


@dataclass(frozen=True, slots=True)
class Chaos:
    """A chaotic motion that has gone over its attractor.

    Attributes
    ----------
    strobes
        (n, 2) array, x and v at whole periods.
    exponent, error
        Largest Lyapunov exponent and its standard error [1/time].
    persists
        Whether it is still chaotic at the end of a long time.
    """

    strobes: Floats
    exponent: float
    error: float
    persists: bool

    @classmethod
    def of(cls, system: StrobedSystem, strobe: Floats) -> Chaos:
        """Follow a chaotic motion from a strobe on."""
        strobes = _strobes(system, strobe[np.newaxis], FILLING)[0]
        largest, error = _exponents(system, strobe[np.newaxis], LONG)
        end = strobes[-1:]
        late = _exponents(system, end, LONG // 16)[0] if np.isfinite(end).all() else np.zeros(1)
        persists = bool(
            largest[0] > max(CERTAIN * error[0], LEAST_EXPONENT / system.period)
            and late[0] > LEAST_EXPONENT / system.period
        )
        return cls(strobes, float(largest[0]), float(error[0]), persists)


def same_chaos(system: StrobedSystem, chaos: Chaos, arrays: Arrays, rows: Integers) -> Flags:
    """Return which chaotic motions are on an attractor.

    Parameters
    ----------
    system
        What moves.
    chaos
        A motion that has gone over the attractor.
    arrays
        What has become of each start, by the names of `CLASS_COLUMNS`.
    rows
        (n,) array, the starts that are asked.

    Returns
    -------
    (n,) array
        True where strobes lie among those of the attractor and the exponents agree.
    """
    cells = _Cells(chaos.strobes)
    same = np.zeros(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), MOTIONS_AT_ONCE):
        those = rows[first : first + MOTIONS_AT_ONCE]
        starts = np.asarray(arrays["strobe"], dtype=np.float64)[those]
        among = cells.share(_strobes(system, starts, ASKED)) > MOST
        own = np.asarray(arrays["exponent"], dtype=np.float64)[those]
        agree = _agree(chaos, own, np.asarray(arrays["exponent_error"], dtype=np.float64)[those])
        # A long look: of many motions some are beyond the errors of short ones by chance.
        doubtful = np.flatnonzero(among & ~agree)
        if len(doubtful):
            agree[doubtful] = _agree(chaos, *_exponents(system, starts[doubtful], LONG))
        same[first : first + MOTIONS_AT_ONCE] = among & agree
    return same


def _agree(chaos: Chaos, exponents: Floats, errors: Floats) -> Flags:
    difference = np.abs(exponents - chaos.exponent)
    return np.asarray(difference <= DIFFERENT * hypot(errors, chaos.error))


class _Cells:
    """The cells of the plane that an attractor lies in, and those next to them."""

    def __init__(self, cloud: Floats) -> None:
        cloud = cloud[np.isfinite(cloud).all(axis=1)]
        self._low = cloud.min(axis=0)
        width = np.ptp(cloud, axis=0)
        self._size = np.where(width > 0.0, width, 1.0) / CELLS
        # Two cells of room on all sides: a place outside is in the outermost, which are empty.
        i, j = self._cell(cloud)
        full = np.zeros((CELLS + 5, CELLS + 5), dtype=np.bool_)
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                full[i + di, j + dj] = True
        self._full = full

    def _cell(self, places: Floats) -> tuple[Integers, Integers]:
        cells = np.floor((places - self._low) / self._size)
        number = np.clip(np.nan_to_num(cells, nan=-2.0), -2, CELLS + 2).astype(np.int64) + 2
        return number[..., 0], number[..., 1]

    def share(self, places: Floats) -> Floats:
        """Return which part of the places (n, m, 2) of each motion lies there."""
        return np.asarray(self._full[self._cell(places)].mean(axis=1))


def _strobes(system: StrobedSystem, starts: Floats, count: int) -> Floats:
    """Return so many strobes (n, count, 2) of each motion from one on, that one included."""
    since = np.full(len(starts), system.t0)
    every = np.full(len(starts), system.period)
    plan = Plan(since, every, since + (count - 1) * every, survey.STROBES, count)
    return np.asarray(_follow(system, starts, plan).points[:, :, :2])


def _exponents(system: StrobedSystem, starts: Floats, periods: int) -> tuple[Floats, Floats]:
    """Return the largest exponent of each motion and its standard error."""
    since = np.full(len(starts), system.t0)
    plan = tangent_plan(np.full(len(starts), system.period), since, 0, periods)
    largest, _, error, _ = exponents_of(_follow(system, starts, plan), plan)
    return largest, error


def _follow(system: StrobedSystem, starts: Floats, plan: Plan) -> BatchResult:
    begin = np.column_stack([starts, plan.since])
    which = np.zeros(len(starts), dtype=np.int64)
    return follow_batch(system.law[np.newaxis], which, begin, plan)
