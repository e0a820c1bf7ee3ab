"""Where an orbit touches a stop without velocity, and the orbit that meets it there no more."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ConvergenceError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import acceleration_and_jerk, constant_force, set_phases
from percuss.kernels.law import Law
from percuss.kernels.shooting import AT, BEFORE, place
from percuss.model.exact import as_float
from percuss.model.law import law
from percuss.orbits.families.family import Family
from percuss.orbits.orbit.chain import entries_of, is_wall
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.passages import turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_orbit

__all__ = [
    "Touch",
    "acceleration_at",
    "accumulates",
    "fastest",
    "merged",
    "settled",
    "touches_of",
    "without",
]

Floats = NDArray[np.float64]

# Velocities below this part of the largest, and distances, are those of a touch: special points
# are located to some 1e-12 of the branch, and a distance is flat there.
SLOW = 1e-6
# Velocities that vanish together do so at different rates.
ACCUMULATED = 1e-4
# Where the largest velocity of an orbit is looked for.
INSTANTS = 65
# A turning point and an event of no velocity nearer than this part of the period are one touch.
BESIDE = 1e-3


@dataclass(frozen=True, slots=True)
class Touch:
    """A touch of a bound.

    Attributes
    ----------
    t
        Instant [time].
    bound
        Number of the bound.
    region
        Row of the region in which the orbit is before and after it.
    way
        Sign of the velocity with which it would pass.
    events
        Rows of the chain that happen there: one impact or several that fall together, the two
        crossings of an edge, or none.
    """

    t: float
    bound: int
    region: int
    way: float
    events: tuple[int, ...]


def fastest(orbit: PeriodicOrbit) -> float:
    """Return the largest velocity of an orbit, of 65 instants [length/time]."""
    run = orbit.trajectory()
    return float(np.abs(run(np.linspace(run.t0, run.t_end, INSTANTS))[1]).max()) or 1.0


def touches_of(orbit: PeriodicOrbit) -> list[Touch]:
    """Return the touches of an orbit at a graze, in the order of time."""
    table = law(orbit.oscillator, orbit.forcing)
    speed = fastest(orbit)
    found = merged(_at_events(orbit, table, SLOW * speed), orbit.period)
    for touch in _at_turns(orbit, table, SLOW * speed * orbit.period):
        apart = (abs(touch.t - other.t) % orbit.period for other in found)
        if all(min(by, orbit.period - by) > BESIDE * orbit.period for by in apart):
            found.append(touch)
    return sorted(found, key=lambda touch: touch.t)


def merged(touches: Iterable[Touch], period: float) -> list[Touch]:
    """Return touches with those of one bound at one instant of a period as one.

    Impacts fall together there; or an orbit goes round a shorter one, and touches in each round.
    """
    found: list[Touch] = []
    for touch in touches:
        for k, other in enumerate(found):
            apart = abs(touch.t - other.t) % period
            if touch.bound == other.bound and min(apart, period - apart) <= BESIDE * period:
                events = other.events + tuple(e for e in touch.events if e not in other.events)
                found[k] = dataclasses.replace(other, events=events)
                break
        else:
            found.append(touch)
    return found


def acceleration_at(table: Law, touch: Touch, t: float | None = None) -> float:
    """Return the acceleration at the bound of a touch, at rest there, at its instant or another."""
    phases = np.empty((int(table[0, at.N_HARMONICS]), 2))
    set_phases(table, touch.t if t is None else t, 0.0, phases)
    force = constant_force(table, touch.region, place(table, touch.region, touch.bound))
    return float(acceleration_and_jerk(table, touch.region, force, phases, 0.0, 0.0)[0])


def accumulates(orbit: PeriodicOrbit, row: int) -> bool:
    """Tell whether impacts accumulate where one has no velocity, a row of the orbit's chain.

    The force pushes into the wall there, and the impact before or after it has no velocity either:
    between them the mass stays. A motion that comes from beyond the wall may have one alone.
    """
    table = law(orbit.oscillator, orbit.forcing)
    n = len(orbit._chain)
    bound, before, _ = orbit._chain[row].tolist()
    way = 1.0 if bound > int(table[before, at.NUMBER]) else -1.0
    touch = Touch(float(orbit._events[row, columns.EVENT_T]), bound, before, way, (row,))
    beside = [(row + step) % n for step in (-1, 1)]
    slow = ACCUMULATED * fastest(orbit)
    others = [
        k for k in beside
        if k != row and orbit._chain[k, AT] == bound
        and abs(orbit._events[k or n, columns.V_BEFORE]) < slow
    ]  # fmt: skip
    return bool(others) and way * acceleration_at(table, touch) > 0.0


def _at_events(orbit: PeriodicOrbit, table: Law, slow: float) -> list[Touch]:
    chain, n = orbit._chain, len(orbit._chain)
    walls = is_wall(table, chain) if n else []
    found = []
    for i, _ in entries_of(orbit.oscillator, table, chain) if n else []:
        if abs(orbit._events[i or n, columns.V_BEFORE]) > slow:
            continue
        events: tuple[int, ...] = (i,)
        if not walls[i]:
            # Into the stop and out of it, or out of it and in again: what takes no time.
            inside, outside = orbit._unknowns[1 + i], orbit._unknowns[1 + (i - 1) % n]
            events = (i, (i + 1) % n) if abs(inside) <= abs(outside) else ((i - 1) % n, i)
        row = chain[events[0]]
        way = 1.0 if row[AT] > int(table[row[BEFORE], at.NUMBER]) else -1.0
        found.append(Touch(float(orbit._events[i, 0]), int(row[AT]), int(row[BEFORE]), way, events))
    return found


def _at_turns(orbit: PeriodicOrbit, table: Law, near: float) -> list[Touch]:
    """Return the turning points that touch a bound."""
    lasting = orbit.period if len(orbit._chain) else 1.5 * orbit.period
    turns = turns_of(table, orbit._events, orbit._marks, orbit.x0, orbit.t0 + lasting)
    found = []
    for i in range(len(turns.t)):
        if abs(turns.clearance[i]) > near or turns.t[i] - turns.t[0] > orbit.period * (1 - 1e-9):
            continue
        region = int(orbit._marks[turns.flight[i], columns.NEXT_REGION])
        bound = int(turns.bound[i])
        way = 1.0 if bound > int(table[region, at.NUMBER]) else -1.0
        found.append(Touch(float(turns.t[i]), bound, region, way, ()))
    return found


def without(orbit: PeriodicOrbit, touches: Sequence[Touch]) -> PeriodicOrbit:
    """Return the orbit of the same system that does not have the events of touches.

    Raises
    ------
    ConvergenceError
        If there is none beside it.
    """
    gone = {row for touch in touches for row in touch.events}
    if not gone:
        return orbit
    n = len(orbit._chain)
    table = law(orbit.oscillator, orbit.forcing)
    kept = [row for row in range(n) if row not in gone]
    # The first event meets a stop: so orbits begin.
    entries = [i for i, _ in entries_of(orbit.oscillator, table, orbit._chain) if i in kept]
    if not kept:
        if orbit.forcing is None:
            reason = "free motion that meets no stop has no orbit of its own"
            raise ConvergenceError(reason, None, np.nan, "look at motion with forcing")
        return steady_orbit(orbit.oscillator, orbit.forcing, touches[0].region)
    lasting, speeds = orbit._unknowns[1 : 1 + n], orbit._unknowns[1 + n :]
    first = kept.index(entries[0])
    kept = kept[first:] + [row + n for row in kept[:first]]
    merged = [
        sum(lasting[row % n] for row in range(one, following))
        for one, following in zip(kept, [*kept[1:], kept[0] + n], strict=True)
    ]
    kept = [row % n for row in kept]
    guess = np.concatenate([[orbit._events[kept[0], 0]], merged, speeds[kept]])
    chain = np.ascontiguousarray(orbit._chain[kept])
    return settled(orbit, chain, guess)


def settled(orbit: PeriodicOrbit, chain: columns.Integers, guess: Floats) -> PeriodicOrbit:
    """Return the orbit with other events in the system of an orbit, by Newton's method.

    Raises
    ------
    ConvergenceError
        If there is none beside the guess.
    """
    osc, force = orbit.oscillator, orbit.forcing
    rough = orbit_of_solution(
        osc, force, chain, Solution(guess, np.nan, converged=False, isolated=True), orbit.n_periods
    )
    # Any parameter will do: it is held.
    value = as_float(osc.damping)
    family = Family(rough, "oscillator.damping", value, value + 1.0)
    held = np.append(np.zeros(len(guess)), 1.0)
    return family.orbit(family.corrected(family.start(rough, value), held))
