"""The attractors and the near returns of a structure's motions from many starts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.kernels.structure.sample import evaluate
from percuss.model.acting_sets import StructureSystem, within_walls
from percuss.model.oscillator import On
from percuss.model.structure_start import StructureStart
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.numerics import power
from percuss.orbits.finding.settled import (
    ARRIVED,
    CLOSE,
    LONGER,
    NEAR,
    STAGE,
    STAGES,
    TAIL,
    Settled,
)
from percuss.orbits.orbit.extremes import Extremes
from percuss.orbits.orbit.signature import are_same
from percuss.orbits.orbit.structure_orbit import (
    PeriodMap,
    StructureOrbit,
    in_lengths,
    period_map,
    period_of,
    structure_orbit_at,
)

# Motions whose near returns are looked at, returns of each, and how near they are.
RETURNING, TRIED, RETURNED = 3, 4, 0.3
# States nearer to each other than this part of a motion lead to one orbit.
APART = 0.02


def settled_structures(
    system: StructureSystem,
    max_periods: int,
    on: On | None,
    *,
    n_starts: int,
    seed: int,
    also: Sequence[tuple[float, ...]] = (),
) -> list[Settled]:
    """Follow motions from many starts for long and return their attractors, each once.

    Parameters
    ----------
    system
        The structure under loads with a period.
    max_periods
        The longest orbits that are looked for first; then those up to four times as long.
    on
        Whose extremes are taken.
    n_starts
        Number of motions: one from rest, the others at random.
    seed
        Of the random starts.
    also
        More starts, (x, v) at t = 0, which are moved out of walls.

    Returns
    -------
    list of Settled
        Motions for which no period was found count as one attractor.
    """
    attractors: list[Settled] = []
    known = [within_walls(system.structure, np.array(state)) for state in also]
    for state in [*known, *_starts(system, n_starts, seed)]:
        try:
            motion = _settled(system, state, max_periods, on, attractors)
        except PercussError:
            # It does not last: impacts accumulate, or the modes of a set are not found.
            continue
        if motion is not None:
            attractors.append(motion)
    return attractors


def returning_orbits(
    system: StructureSystem, max_periods: int, seed: int
) -> Iterator[StructureOrbit]:
    """Yield orbits, stable or not, next to stretches of motions that almost close.

    A motion that has come near an unstable orbit almost repeats for a while; Newton's method leads
    from there to it.
    """
    orbits: list[StructureOrbit] = []
    for state in _starts(system, RETURNING + 1, seed)[1:]:
        try:
            strobes = _strobes(system, period_map(system, state, STAGE, derivative=False), STAGE)
        except PercussError:
            continue
        places = in_lengths(strobes, period_of(system))
        for n_periods in range(1, max_periods + 1):
            for row in _near_returns(places, n_periods)[:TRIED]:
                orbit = primitive_orbit(system, strobes[row], n_periods)
                if orbit is not None and not any(are_same(orbit, known) for known in orbits):
                    orbits.append(orbit)
                    yield orbit


def orbits_from_start(
    system: StructureSystem, state: Floats, max_periods: int
) -> Iterator[StructureOrbit]:
    """Yield the orbits to which Newton's method leads from a start and from its motion.

    It begins at the start itself, for each number of periods, and where the motion almost closes:
    on its way it passes near unstable orbits, and at its end it is on a stable one. States that
    are near one from which an orbit was sought are left out.
    """
    try:
        strobes = _strobes(system, period_map(system, state, STAGE, derivative=False), STAGE + 1)
    except PercussError:
        strobes = state[None, :]
    places = in_lengths(strobes, period_of(system))
    size = float(np.abs(places).max())
    for n_periods in range(1, max_periods + 1):
        tried: list[Floats] = []
        for row in [0, *_near_returns(places, n_periods)]:
            near = (np.abs(places[row] - other).max() <= APART * size for other in tried)
            if any(near):
                continue
            tried.append(places[row])
            orbit = primitive_orbit(system, strobes[row], n_periods)
            if orbit is not None:
                yield orbit
            if len(tried) > TRIED:
                break


def _near_returns(places: Floats, n_periods: int) -> list[int]:
    """Return the rows from which a motion almost closes after so many periods, the nearest first.

    ``places`` are its strobes in lengths.
    """
    if n_periods >= len(places):
        return []
    far = np.abs(places[n_periods:] - places[:-n_periods]).max(axis=1)
    far = far / np.abs(places).max()
    around = np.concatenate([[np.inf], far, [np.inf]])
    least = (far <= around[:-2]) & (far <= around[2:]) & (far < RETURNED)
    rows = np.flatnonzero(least)
    nearest: list[int] = rows[np.argsort(far[rows], kind="stable")].tolist()
    return nearest


def extremes_of_motion(
    run: StructureTrajectory, on: On | None, between: tuple[float, float] | None = None
) -> Extremes:
    """Return the extremes of y = c . x."""
    extrema = run.extremes("displacement", on=on, between=between)
    return Extremes(extrema.minimum, extrema.maximum)


def largest_speed(run: StructureTrajectory) -> float:
    """Return the largest velocity y' into a stop, NaN if none is met."""
    crossings = run.crossings
    entries = crossings.v[crossings.direction == "in"]
    speeds = np.abs(np.concatenate([run.impacts.v_before, entries]))
    return float(speeds.max()) if len(speeds) else math.nan


def _starts(system: StructureSystem, n_starts: int, seed: int) -> list[Floats]:
    """Return so many starts."""
    return list(islice(random_starts(system, seed), n_starts))


def random_starts(system: StructureSystem, seed: int) -> Iterator[Floats]:
    """Yield starts (x, v) for ever: at rest, then around the motion that comes from rest."""
    random, n = np.random.default_rng(seed), system.structure.n
    rest = within_walls(system.structure, np.zeros(2 * n))
    try:
        here = period_map(system, rest, STAGE, derivative=False)
        sizes = np.abs(_strobes(system, here, TAIL)).max(axis=0)
    except PercussError:
        # The motion from rest does not last, as of a structure that is unstable there.
        sizes = np.zeros(2 * n)
    # In units of the largest of all coordinates: some may not have moved.
    units = np.repeat([float(sizes[:n].max()) or 1.0, float(sizes[n:].max()) or 1.0], n)
    yield rest
    while True:
        size = power(10.0, random.uniform(-1.0, 0.7))
        yield within_walls(system.structure, size * units * random.normal(size=2 * n))


def _settled(
    system: StructureSystem,
    state: Floats,
    max_periods: int,
    on: On | None,
    known: list[Settled],
) -> Settled | None:
    """Follow a motion in stages and return its attractor, None if that is known."""
    for stage in range(STAGES):
        here = period_map(system, state, STAGE, derivative=False)
        strobes = _strobes(system, here, TAIL)
        state = strobes[-1]
        if any(_has_arrived(state, seen.orbit) for seen in known):
            return None
        places = in_lengths(strobes, period_of(system))
        longest = max_periods * (LONGER if stage == STAGES - 1 else 1)
        for n_periods in range(1, min(longest, TAIL - 1) + 1):
            size = float(np.abs(places).max())
            if np.abs(places[-1] - places[-1 - n_periods]).max() > NEAR * size:
                continue
            orbit = primitive_orbit(system, state, n_periods)
            if orbit is None or not orbit.is_stable:
                continue
            begin = in_lengths(orbit.strobes[0], period_of(system))
            if np.abs(begin - places[-1]).max() > CLOSE * size:
                continue
            if any(
                isinstance(seen.orbit, StructureOrbit) and are_same(orbit, seen.orbit)
                for seen in known
            ):
                return None
            extremes = extremes_of_motion(orbit.run, on)
            speed, counts = largest_speed(orbit.run), (orbit.n_impacts, orbit.n_periods)
            return Settled(*counts, orbit, tuple(state.tolist()), speed, extremes)
    if any(seen.orbit is None for seen in known):
        return None
    run = _run(system, strobes[0], TAIL - 1)
    extremes, speed = extremes_of_motion(run, on), largest_speed(run)
    return Settled(math.nan, 0, None, tuple(state.tolist()), speed, extremes)


def _has_arrived(state: Floats, orbit: object) -> bool:
    if not isinstance(orbit, StructureOrbit):
        return False
    period = orbit.period / orbit.n_periods
    own, place = in_lengths(orbit.strobes, period), in_lengths(state, period)
    return bool((np.abs(own - place).max(axis=1) <= ARRIVED * np.abs(own).max()).any())


def primitive_orbit(
    system: StructureSystem, state: Floats, n_periods: int
) -> StructureOrbit | None:
    """Return the orbit next to a state, over its least period; None where none is found."""
    try:
        orbit = structure_orbit_at(system, state, n_periods)
        for part in range(1, n_periods):
            if n_periods % part == 0 and _repeats(orbit, part):
                return structure_orbit_at(system, orbit.strobes[0], part)
    except PercussError:
        return None
    return orbit


def _repeats(orbit: StructureOrbit, n_periods: int) -> bool:
    own = in_lengths(orbit.strobes, orbit.period / orbit.n_periods)
    return bool(np.abs(own[n_periods] - own[0]).max() <= ARRIVED * np.abs(own).max())


def _strobes(system: StructureSystem, here: PeriodMap, count: int) -> Floats:
    """Return (x, v) at the last ends of periods of a motion of a stage, (count, 2 n)."""
    period = float(system.period or math.nan)
    places = np.empty((count, system.structure.n, 2))
    times = (np.arange(STAGE - count + 1, STAGE + 1) * period).astype(np.float64)
    evaluate(here.record, times, True, places)
    return np.concatenate([places[:, :, 0], places[:, :, 1]], axis=1)


def _run(system: StructureSystem, state: Floats, n_periods: int) -> StructureTrajectory:
    n, end = system.structure.n, n_periods * float(system.period or math.nan)
    record = period_map(system, state, n_periods, derivative=False).record
    start = StructureStart(state[:n].tolist(), state[n:].tolist())
    return StructureTrajectory.of_run(system, start, record, end, Outcome.reached_t_end)
