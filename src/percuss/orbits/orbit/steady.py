"""Orbits that meet no stop: the steady motion inside one region, in closed form."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.law_columns import Law
from percuss.kernels.tangent import propagator
from percuss.model.oscillator import mass_of
from percuss.model.system import System
from percuss.motion.accelerations import phases_at
from percuss.motion.reach import IDENTITY, periodic_state, steady
from percuss.motion.tables import Impacts
from percuss.numerics import exp
from percuss.orbits.orbit.itinerary import row_of_region
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of, stability_of
from percuss.orbits.orbit.turning_points import (
    TurningPoints,
    margin_of,
    penetrations_of,
    turning_points_of,
)


def regions(law: Law) -> list[int]:
    """Return the rows of all regions, upwards."""
    return [row_of_region(law, number) for number in range(int(law[0, at.N_REGIONS]))]


def free_region(system: System) -> int | None:
    """Return the row of the region in which no stop acts, None if there is none."""
    layout, stops = system.lines, system.oscillator.stops
    edges = [(i, stops[k].side) for i, here in enumerate(layout.edges) for k in here]
    first = max((i for i, side in edges if side == "below"), default=0)
    last = min((i for i, side in edges if side == "above"), default=len(layout.at) - 1)
    return None if first + 1 > last else row_of_region(system.law, first)


def steady_orbit(system: System, region: int) -> PeriodicOrbit:
    """Return the periodic motion of one region, which may leave the region formally.

    Parameters
    ----------
    system
        Oscillator and forcing; the forcing has a period.
    region
        The region's row in the law.

    Returns
    -------
    PeriodicOrbit
        Of one forcing period, without impacts.

    Raises
    ------
    ConvergenceError
        If there is none: at resonance without damping, or without a spring under a mean force.
    """
    law = system.law
    n = int(law[0, at.N_HARMONICS])
    period = float(law[0, at.PERIOD])
    if law[0, at.N_KNOTS] > 0.0:
        y, v = steady_state(law, region, 0.0)
        start = float(law[region, at.ORIGIN]) + y, v, period
        return _orbit(system, region, start, *_started(v, region))
    x0 = _mean(law, region)
    gains = law[region + 1 : region + 1 + n]
    moved = law[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n, at.AMPLITUDE] > 0.0
    resonant = moved & (gains[:, at.GAIN_RE] == 0.0) & (gains[:, at.GAIN_IM] == 0.0)
    if x0 is None or resonant.any():
        why = "at resonance without damping" if resonant.any() else "under a mean force, springless"
        reason = f"no periodic motion without impacts, {why}: it grows without bound"
        raise ConvergenceError(reason, None, math.nan, "add damping, or ask for impacts")
    y, v0 = steady(law, region, phases_at(law, 0.0)).sum(axis=0)
    x0 += float(y)
    return _orbit(system, region, (x0, float(v0), period), *_started(float(v0), region))


def _started(v0: float, region: int) -> tuple[Floats, Integers]:
    """Return the record of a motion without events."""
    events = np.array([[0.0, 0.0, v0, v0]])
    return events, np.array([[columns.START, -1, region]], dtype=np.int64)


def steady_state(law: Law, region: int, t: float) -> tuple[float, float]:
    """Return (x - ORIGIN, v) of the periodic motion of a region under a repeated record.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    state = periodic_state(law, region, t)
    if state is None:
        reason = (
            "no one periodic motion without impacts: in resonance without damping, or springless"
        )
        raise ConvergenceError(reason, None, math.nan, "add damping, or ask for impacts")
    return state


def _mean(law: Law, region: int) -> float | None:
    """Return the mean position of steady motion, None if there is none."""
    row = law[region]
    if row[at.STIFFNESS] != 0.0:
        return float(row[at.ORIGIN] + row[at.ORIGIN_FORCE] / row[at.STIFFNESS])
    if row[at.ORIGIN_FORCE] != 0.0:
        return None
    # Any displacement is an equilibrium: the middle of the region is farthest from its bounds.
    low, high = float(row[at.LOWER]), float(row[at.UPPER])
    return 0.5 * (low + high) if math.isfinite(low) and math.isfinite(high) else 0.0


def _orbit(
    system: System,
    region: int,
    start: tuple[float, float, float],
    events: Floats,
    marks: Integers,
) -> PeriodicOrbit:
    x0, v0, period = start
    law = system.law
    monodromy = np.array(propagator(law, region, period)).reshape(2, 2)
    damping = float(law[region, at.DAMPING])
    shrunk = exp(-2.0 * damping * period)
    turns = _one_period_of(turning_points_of(law, events, marks, x0, 1.5 * period), period)
    penetrations = penetrations_of(system.oscillator, turns)
    none = np.empty(0)
    no_stop = np.empty(0, dtype=np.int64)
    # Without a spring any displacement is an equilibrium.
    loose = float(law[region, at.STIFFNESS]) == 0.0
    return PeriodicOrbit(
        oscillator=system.oscillator,
        forcing=system.forcing,
        x0=x0,
        v0=v0,
        t0=0.0,
        impacts=Impacts(
            none,
            none,
            none,
            no_stop,
            none,
            none,
            mass_of(system.oscillator),
            system.oscillator.units,
        ),
        n_impacts=0,
        n_periods=1,
        period=period,
        monodromy=monodromy,
        multipliers=multipliers_of(monodromy, shrunk),
        stability=stability_of(monodromy, shrunk, conservative=damping == 0.0),
        admissible=len(penetrations) == 0,
        grazing_margin=margin_of(turns),
        passages=penetrations,
        min_impact_speed=math.nan,
        isolated=not (loose or float(np.abs(monodromy - np.eye(2)).max()) < IDENTITY),
        residual=0.0,
        _events=events,
        _marks=marks,
        _sequence=np.empty((0, 3), dtype=np.int64),
        _vector=np.array([0.0]),
    )


def _one_period_of(turns: TurningPoints, period: float) -> TurningPoints:
    """Return the turning points of one period, from the first on."""
    first = turns.t[0] if len(turns.t) else 0.0
    kept = turns.t < first + period * (1.0 - 1e-9)
    return TurningPoints(
        turns.t[kept] % period,
        turns.clearance[kept],
        turns.bound[kept],
        turns.flight[kept],
        turns.doubt[kept],
    )
