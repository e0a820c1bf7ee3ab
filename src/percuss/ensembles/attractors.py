"""The attractors of many motions, and the attractor of each motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.ensembles.batch import BatchResult, Plan, exponents_of, tangent_plan
from percuss.ensembles.classification import LONGEST, LONGEST_OF_ALL, Arrays
from percuss.ensembles.decisions import (
    CHAOTIC,
    LEAST_SHARE,
    NO_START,
    PERIODIC,
    REST,
    SIDE,
    UNBOUNDED,
    agree,
    fill_cells,
    has_settled,
    is_chaotic,
    is_near,
    near_orbit,
    shares_in_cells,
    weight,
)
from percuss.ensembles.groups import Group, StructureGroup
from percuss.ensembles.repetition import period_of
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels import observables
from percuss.kernels.arithmetic import nearest
from percuss.kernels.law_columns import PERIOD
from percuss.model.acting_sets import StructureSystem
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.system import System, law, stop_rows
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.numerics import log
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits
from percuss.orbits.orbit.structure_orbit import structure_orbit_at


@dataclass(frozen=True, slots=True)
class Attractor:
    """An attractor, or the unbounded motions.

    Attributes
    ----------
    kind
        "periodic", "chaotic", "rest" or "unbounded".
    n_periods, n_impacts
        Forcing periods and impacts in one period of the orbit, infinitely many impacts with
        sticking; 0 and NaN where it is not periodic.
    strobes
        (n, 2) array, x and v once a forcing period, over one period of an orbit or many of a
        chaotic motion.
    exponent, error
        Largest Lyapunov exponent, of an orbit from its multipliers, and its standard error where
        it is taken from a motion [1/time]; NaN where unknown.
    residual
        By how much the refined periodic orbit fails to close, NaN where there is none.
    orbit
        The periodic orbit of an oscillator, to full accuracy; None where there is none or Newton's
        method failed.
    """

    kind: str
    n_periods: int = 0
    n_impacts: float = math.nan
    strobes: Floats = field(default_factory=lambda: np.full((1, 2), np.nan))
    exponent: float = math.nan
    error: float = math.nan
    residual: float = math.nan
    orbit: PeriodicOrbit | None = None

    @property
    def name(self) -> str:
        """(impacts, forcing periods) in one period of the orbit, or the kind."""
        if self.kind != "periodic":
            return self.kind
        return f"({self.n_impacts:g}, {self.n_periods})"


# Forcing periods in which a motion settles on its orbit, and how often as many are added: a weakly
# damped motion spirals around its orbit for long.
SETTLING, AGAIN = 500, 20
# Long transients that seemed periodic or chaotic are expensive: so many of each are tried.
MOST_FAILURES, MOST_TRANSIENTS = 1000, 100
# Orbits that are distinguished where every start has its own, as without a spring or damping.
MOST_ORBITS = 1000

GoOn: TypeAlias = Callable[[], bool]
Members: TypeAlias = Iterator[tuple[Integers, Attractor]]


def _always() -> bool:
    return True


def label_starts(
    system: AnyStrobed, arrays: Arrays, go_on: GoOn = _always
) -> tuple[Integers, list[Attractor]]:
    """Return the number of each start's attractor, and the attractors.

    Attractors are numbered in the order of their first starts. Undecided starts have -1, starts
    inside a wall -2.

    Parameters
    ----------
    system
        The system of all starts.
    arrays
        The classes of the starts, by the names of `CLASS_COLUMNS`.
    go_on
        Called before each attractor is computed; where it returns False the starts that are left
        stay undecided.
    """
    kind = arrays["kind"]
    labels = np.where(kind == NO_START, NO_START, -1).astype(np.int64)
    attractors: list[tuple[int, Attractor]] = []
    for value, members in (
        (PERIODIC, _periodic),
        (CHAOTIC, _chaotic),
        (REST, _resting),
        (UNBOUNDED, _unbounded),
    ):
        rows = np.flatnonzero(kind == value)
        for own_rows, attractor in members(system, arrays, rows, go_on) if len(rows) else ():
            attractors.append((int(own_rows[0]), attractor))
            labels[own_rows] = -3 - len(attractors)
    # By the first start that goes there.
    order = sorted(range(len(attractors)), key=lambda i: attractors[i][0])
    # In one array operation: many starts times many attractors would take long.
    number = np.zeros(len(attractors) + 4, dtype=np.int64)
    number[[i + 4 for i in order]] = np.arange(len(order))
    attracted = labels <= -4
    labels[attracted] = number[-labels[attracted]]
    return labels, [attractors[i][1] for i in order]


def _periodic(system: AnyStrobed, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:
    """Group periodic motions by the strobes of the orbits on which they settle."""
    left, failures, n_orbits = rows, 0, 0
    while len(left) and failures < MOST_FAILURES and n_orbits < MOST_ORBITS and go_on():
        strobe = np.asarray(arrays["strobe"][left[0]], dtype=np.float64)
        is_long = int(arrays["n_periods"][left[0]]) > LONGEST
        orbit = _settled(system, strobe, LONGEST_OF_ALL if is_long else LONGEST)
        same = np.zeros(len(left), dtype=np.bool_)
        strobes = np.ascontiguousarray(arrays["strobe"], dtype=np.float64)
        near_orbit(strobes, left, orbit.last, system.period, same)
        if len(orbit.strobes) == 0 or not same[0]:
            # A long transient: it stays undecided.
            left, failures = left[1:], failures + 1
            continue
        yield left[same], system.settled(orbit.strobes, orbit.n_impacts)
        left, n_orbits = left[~same], n_orbits + 1


@dataclass(frozen=True, slots=True)
class _Settled:
    """A motion that has settled on a periodic orbit, or has not: then there are no strobes.

    ``strobes`` over one period, when it first comes again; ``last`` those as near to the orbit as
    it comes, with which motions are compared; and ``n_impacts`` in one period.
    """

    strobes: Floats
    last: Floats
    n_impacts: float


def _settled(system: AnyStrobed, strobe: Floats, longest: int) -> _Settled:
    """Follow a motion until it has settled."""
    every = np.array([system.period])
    since = np.array([system.t0 + SETTLING * system.period])
    until = since + 2 * longest * system.period
    plan = Plan(since, every, until, section=observables.STROBES, n_points=2 * longest + 1)
    strobes = last = np.empty((0, len(strobe)))
    n_impacts = math.nan
    for _ in range(AGAIN):
        begin = np.array([[*strobe, system.t0]])
        result = system.group(begin).follow(plan)
        points = np.ascontiguousarray(np.nan_to_num(result.strobes[0]))
        strobe = points[-1]
        n_periods = int(period_of(points[np.newaxis], longest, every)[0])
        if n_periods == 0:
            continue
        last = points[:n_periods]
        if len(strobes) == 0:
            strobes = last
            counts = result.values[0, [observables.IMPACTS, observables.CONTACTS]].tolist()
            # One that sticks has impacts without end.
            n_impacts = nearest(counts[0] * n_periods / (2 * longest))
            n_impacts = math.inf if counts[1] > 0.0 else n_impacts
        if has_settled(points, n_periods, system.period):
            break
    return _Settled(strobes, last, n_impacts)


def _chaotic(system: AnyStrobed, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:
    """Group chaotic motions by their strobes and largest exponents."""
    left, failures = rows, 0
    while len(left) and failures < MOST_TRANSIENTS and go_on():
        chaos = Chaos.of(system, np.asarray(arrays["strobe"][left[0]], dtype=np.float64))
        if not chaos.persists:
            # A transient: it stays undecided.
            left, failures = left[1:], failures + 1
            continue
        same = same_chaos(system, chaos, arrays, left)
        same[0] = True
        yield (
            left[same],
            Attractor("chaotic", 0, math.nan, chaos.strobes, chaos.exponent, chaos.error),
        )
        left = left[~same]


def _resting(system: AnyStrobed, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:  # noqa: ARG001
    places = np.asarray(arrays["strobe"])[rows, 0]
    for place in np.unique(places):
        at = np.array([[place, 0.0]], dtype=np.float64)
        yield rows[places == place], Attractor("rest", strobes=at, exponent=-math.inf)


def _unbounded(system: AnyStrobed, arrays: Arrays, rows: Integers, go_on: GoOn) -> Members:  # noqa: ARG001
    yield rows, Attractor("unbounded")


# Periods of the run from which Newton's method starts.
ORBIT_PERIODS = 3


@dataclass(frozen=True, slots=True)
class StrobedSystem:
    """A periodically forced oscillator with its law, and the time t0 of a strobe."""

    osc: Oscillator
    force: Forcing
    law: Floats
    t0: float

    @classmethod
    def of(cls, osc: Oscillator, force: Forcing, t0: float) -> StrobedSystem:
        """Return a system with its law."""
        return cls(osc, force, law(osc, force), t0)

    def group(self, starts: Floats) -> Group:
        """Return motions from starts (n, 3)."""
        which = np.zeros(len(starts), dtype=np.int64)
        stops = stop_rows(self.osc)[np.newaxis]
        return Group(self.law[np.newaxis], which, starts, which, stops)

    def settled(self, strobes: Floats, n_impacts: float) -> Attractor:
        """Return the attractor of a periodic motion with these strobes, refined where possible."""
        n_periods = len(strobes)
        orbit = refined_orbit(self, strobes[0], n_periods, n_impacts)
        if orbit is None:
            return Attractor("periodic", n_periods, n_impacts, strobes)
        with np.errstate(divide="ignore"):
            exponent = float(log(np.abs(orbit.multipliers).max()) / orbit.period)
        refined = strobes_of_orbit(self, orbit, strobes[0])
        return Attractor(
            "periodic", orbit.n_periods, orbit.n_impacts, refined, exponent,
            residual=orbit.residual, orbit=orbit,
        )  # fmt: skip

    @property
    def period(self) -> float:
        """The forcing period [time]."""
        return float(self.law[0, PERIOD])

    def run(self, strobe: Floats, periods: int) -> Trajectory:
        """Return the motion over so many forcing periods from a strobe."""
        x, v = (float(part) for part in strobe)
        return simulate(self.osc, self.force, x, v, self.t0, t_end=self.t0 + periods * self.period)


@dataclass(frozen=True, slots=True)
class StrobedStructure:
    """A structure under loads with a period, and the time t0 of a strobe.

    ``on`` is the direction of the displacement that measures take.
    """

    system: StructureSystem
    t0: float
    on: Floats

    @property
    def period(self) -> float:
        """The period of the loads [time]."""
        return float(self.system.period or math.nan)

    def group(self, starts: Floats) -> StructureGroup:
        """Return motions from starts (n, 2 n_coordinates + 1)."""
        which = np.zeros(len(starts), dtype=np.int64)
        return StructureGroup((self.system,), which, starts, which, self.on)

    def settled(self, strobes: Floats, n_impacts: float) -> Attractor:
        """Return the attractor of a periodic motion with these strobes, refined where possible."""
        n_periods = len(strobes)
        phase = self.t0 / self.period
        exponent = residual = math.nan
        if phase == round(phase):
            try:
                orbit = structure_orbit_at(self.system, strobes[0], n_periods)
            except PercussError:
                return Attractor("periodic", n_periods, n_impacts, strobes)
            state = np.concatenate([orbit.x0, orbit.v0])
            if is_near(state, strobes[:1], self.period):
                strobes = strobes + (state - strobes[0]) * (np.arange(n_periods) == 0)[:, None]
                largest = float(np.abs(orbit.multipliers).max())
                exponent = float(log(largest) / orbit.period) if largest > 0.0 else -math.inf
                residual = orbit.residual
        return Attractor("periodic", n_periods, n_impacts, strobes, exponent, residual=residual)


AnyStrobed: TypeAlias = StrobedSystem | StrobedStructure


def refined_orbit(
    system: StrobedSystem, strobe: Floats, n_periods: int, n_impacts: float
) -> PeriodicOrbit | None:
    """Return the periodic orbit on which a motion has settled, None where Newton's method fails.

    Parameters
    ----------
    system
        The system.
    strobe
        (2,) array, x and v of the motion at a strobe.
    n_periods, n_impacts
        Forcing periods and impacts in one period of the orbit.
    """
    try:
        for orbit in _candidates(system, strobe, n_periods, n_impacts):
            strobes = strobes_of_orbit(system, orbit, strobe)
            if orbit.admissible and is_near(strobe, strobes, system.period):
                return orbit
    except (ConvergenceError, ParameterError):
        # The motion has not settled, or its impacts accumulate.
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
    elif math.isfinite(n_impacts):
        yield find_orbit(osc, force, n_impacts, n_periods, guess=run, formal=True)


def strobes_of_orbit(system: StrobedSystem, orbit: PeriodicOrbit, near: Floats) -> Floats:
    """Return x and v at the strobes of an orbit, (n_periods, 2) array, beginning near a place."""
    period = system.period
    first = system.t0 + math.ceil((orbit.t0 - system.t0) / period) * period
    t = first + np.arange(orbit.n_periods) * period
    strobes = np.stack(orbit.trajectory(2)(t), axis=1)
    weights = [weight(column, 2, period) for column in range(2)]
    closest = int(np.abs((strobes - near) * weights).max(axis=1).argmin())
    return np.roll(strobes, -closest, axis=0)


def impacts_at(
    system: StrobedSystem, stop: int, strobe: Floats, orbit: PeriodicOrbit | None, periods: int
) -> Floats:
    """Return cycle and speed after the impacts of an orbit or a motion at a stop, (n, 2) array."""
    impacts = orbit.impacts if orbit is not None else system.run(strobe, periods).impacts
    at_stop = impacts.stop == stop
    return np.stack([impacts.cycle[at_stop], np.abs(impacts.v_after[at_stop])], axis=1)


# Strobes that cover a chaotic attractor, and strobes of a motion that is compared with it.
FILLING, COMPARED = 4000, 40
# Forcing periods of the exponent of an attractor, and of a motion whose exponent seems to differ;
# and of that which tells whether it is chaotic still, after the strobes.
LONG = 16_384
LATE = 1024
# Motions that are compared at a time.
MOTIONS_AT_ONCE = 4096


@dataclass(frozen=True, slots=True)
class Chaos:
    """A chaotic motion that has covered its attractor: (n, 2 d) strobes, x and v at whole periods.

    ``exponent`` is the largest Lyapunov exponent, ``error`` its standard error [1/time];
    ``persists`` says whether the motion is still chaotic after a long time.
    """

    strobes: Floats
    exponent: float
    error: float
    persists: bool

    @classmethod
    def of(cls, system: AnyStrobed, strobe: Floats) -> Chaos:
        """Follow a chaotic motion from a strobe."""
        strobes = _strobes(system, strobe[np.newaxis], FILLING)[0]
        largest, error = _exponents(system, strobe[np.newaxis], LONG)
        end = strobes[-1:]
        late = _exponents(system, end, LATE)[0] if np.isfinite(end).all() else np.zeros(1)
        persists = is_chaotic(float(largest[0]), float(error[0]), system.period)
        persists = persists and is_chaotic(float(late[0]), 0.0, system.period)
        return cls(strobes, float(largest[0]), float(error[0]), persists)


def same_chaos(system: AnyStrobed, chaos: Chaos, arrays: Arrays, rows: Integers) -> Flags:
    """Return which chaotic motions, by their rows, are on the attractor that one has covered.

    They are where their strobes lie among those of the attractor and the exponents agree.
    """
    d = chaos.strobes.shape[1] // 2
    planes = [(i, d + i) for i in range(d)]
    cells = [_Cells(chaos.strobes[:, plane]) for plane in planes]
    same = np.zeros(len(rows), dtype=np.bool_)
    for first in range(0, len(rows), MOTIONS_AT_ONCE):
        part = rows[first : first + MOTIONS_AT_ONCE]
        starts = np.asarray(arrays["strobe"], dtype=np.float64)[part]
        places = _strobes(system, starts, COMPARED)
        # In the plane of each coordinate and its velocity.
        shares = [own.share(places[..., plane]) for own, plane in zip(cells, planes, strict=True)]
        among = np.min(shares, axis=0) > LEAST_SHARE
        own = np.asarray(arrays["exponent"], dtype=np.float64)[part]
        agree = _agree(chaos, own, np.asarray(arrays["exponent_error"], dtype=np.float64)[part])
        # A longer run decides: of many short ones some differ beyond their errors by chance.
        doubtful = np.flatnonzero(among & ~agree)
        if len(doubtful):
            agree[doubtful] = _agree(chaos, *_exponents(system, starts[doubtful], LONG))
        same[first : first + MOTIONS_AT_ONCE] = among & agree
    return same


def _agree(chaos: Chaos, exponents: Floats, errors: Floats) -> Flags:
    motions = zip(exponents.tolist(), errors.tolist(), strict=True)
    same = [agree(exponent, error, chaos.exponent, chaos.error) for exponent, error in motions]
    return np.array(same, dtype=np.bool_)


class _Cells:
    """The cells of a plane that contain an attractor, and their neighbours."""

    def __init__(self, cloud: Floats) -> None:
        self._frame = np.empty((2, 2))
        self._full = np.empty((SIDE, SIDE), dtype=np.int64)
        fill_cells(np.ascontiguousarray(cloud), self._frame, self._full)

    def share(self, places: Floats) -> Floats:
        """Return the share of the places (n, m, 2) of each motion that lie in the cells."""
        shares = np.empty(len(places))
        shares_in_cells(np.ascontiguousarray(places), self._frame, self._full, shares)
        return shares


def _strobes(system: AnyStrobed, starts: Floats, count: int) -> Floats:
    """Return strobes (n, count, 2) of motions, the first one included."""
    since = np.full(len(starts), system.t0)
    every = np.full(len(starts), system.period)
    plan = Plan(since, every, since + (count - 1) * every, observables.STROBES, count)
    return _follow(system, starts, plan).strobes


def _exponents(system: AnyStrobed, starts: Floats, periods: int) -> tuple[Floats, Floats]:
    """Return the largest exponents of motions and their standard errors."""
    since = np.full(len(starts), system.t0)
    plan = tangent_plan(np.full(len(starts), system.period), since, 0, periods)
    largest, _, error, _ = exponents_of(_follow(system, starts, plan), plan)
    return largest, error


def _follow(system: AnyStrobed, starts: Floats, plan: Plan) -> BatchResult:
    return system.group(np.column_stack([starts, plan.since])).follow(plan)
