"""Orbits that meet no stop: the steady motion inside one region, in closed form."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Integers
from percuss.errors import ConvergenceError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import set_phases
from percuss.kernels.law import Law, Table
from percuss.kernels.tangent import propagator
from percuss.model.forcing import Forcing
from percuss.model.law import law, lines
from percuss.model.oscillator import Oscillator
from percuss.motion.reach import steady
from percuss.motion.tables import Impacts
from percuss.numerics import exp
from percuss.orbits.orbit.itinerary import row_of_region
from percuss.orbits.orbit.passages import TurningPoints, margin_of, passages_of, turns_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.stability import multipliers_of, stability_of

__all__ = ["free_region", "regions", "steady_orbit"]


# A monodromy matrix so near to the identity makes every free motion periodic too.
IDENTITY = 1e-10


def regions(table: Law) -> list[int]:
    """Return the rows of all regions, upwards."""
    return [row_of_region(table, number) for number in range(int(table[0, at.N_REGIONS]))]


def free_region(osc: Oscillator, table: Law) -> int | None:
    """Return the row of the region in which no stop acts, None if there is none."""
    layout = lines(osc)
    low = [i for i, edges in enumerate(layout.edges) for k in edges
           if osc.stops[k].side == "below"]  # fmt: skip
    high = [i for i, edges in enumerate(layout.edges) for k in edges
            if osc.stops[k].side == "above"]  # fmt: skip
    first = max(low, default=0)
    if first + 1 > min(high, default=len(layout.at) - 1):
        return None
    return row_of_region(table, first)


def steady_orbit(osc: Oscillator, force: Forcing, region: int) -> PeriodicOrbit:
    """Return the periodic motion that stays in one region, whether it fits into it or not.

    Parameters
    ----------
    osc, force
        What moves, under a forcing with a period.
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
    table = law(osc, force)
    n = int(table[0, at.N_HARMONICS])
    period = float(table[0, at.PERIOD])
    phases = np.empty((n, 2))
    set_phases(table, 0.0, 0.0, phases)
    x0 = _mean(table, region)
    gains = table[region + 1 : region + 1 + n]
    moved = table[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n, at.AMPLITUDE] > 0.0
    resonant = moved & (gains[:, at.GAIN_RE] == 0.0) & (gains[:, at.GAIN_IM] == 0.0)
    if x0 is None or resonant.any():
        why = "at resonance without damping" if resonant.any() else "under a mean force, springless"
        reason = f"no periodic motion without impacts, {why}: it grows without bound"
        raise ConvergenceError(reason, None, math.nan, "add damping, or ask for impacts")
    y, v0 = steady(table, region, phases).sum(axis=0)
    x0 += float(y)
    events = np.array([[0.0, 0.0, float(v0), float(v0)]])
    marks = np.array([[columns.START, -1, region]], dtype=np.int64)
    return _orbit(osc, force, region, (x0, float(v0), period), events, marks)


def _mean(table: Law, region: int) -> float | None:
    """Return the mean position of steady motion, None if there is none."""
    row = table[region]
    if row[at.STIFFNESS] != 0.0:
        return float(row[at.ORIGIN] + row[at.ORIGIN_FORCE] / row[at.STIFFNESS])
    if row[at.ORIGIN_FORCE] != 0.0:
        return None
    # Anywhere: where there is most room.
    low, high = float(row[at.LOWER]), float(row[at.UPPER])
    return 0.5 * (low + high) if math.isfinite(low) and math.isfinite(high) else 0.0


def _orbit(
    osc: Oscillator,
    force: Forcing,
    region: int,
    start: tuple[float, float, float],
    events: Table,
    marks: Integers,
) -> PeriodicOrbit:
    x0, v0, period = start
    table = law(osc, force)
    monodromy = np.array(propagator(table, region, period)).reshape(2, 2)
    damping = float(table[region, at.DAMPING])
    determinant = exp(-2.0 * damping * period)
    turns = _one_period_of(turns_of(table, events, marks, x0, 1.5 * period), period)
    passages = passages_of(osc, turns)
    none = np.empty(0)
    nowhere = np.empty(0, dtype=np.int64)
    # Without a spring, and at rest in its place, a mass may be anywhere.
    loose = float(table[region, at.STIFFNESS]) == 0.0
    return PeriodicOrbit(
        oscillator=osc,
        forcing=force,
        x0=x0,
        v0=v0,
        t0=0.0,
        impacts=Impacts(none, none, none, nowhere, none, none),
        n_impacts=0,
        n_periods=1,
        period=period,
        monodromy=monodromy,
        multipliers=multipliers_of(monodromy, determinant),
        stability=stability_of(monodromy, determinant, conservative=damping == 0.0),
        admissible=len(passages) == 0,
        grazing_margin=margin_of(turns),
        passages=passages,
        min_impact_speed=math.nan,
        isolated=not (loose or float(np.abs(monodromy - np.eye(2)).max()) < IDENTITY),
        residual=0.0,
        _events=events,
        _marks=marks,
        _chain=np.empty((0, 3), dtype=np.int64),
        _unknowns=np.array([0.0]),
    )


def _one_period_of(turns: TurningPoints, period: float) -> TurningPoints:
    """Return those of a period, from the first of them on: the ends of a flight are none."""
    first = turns.t[0] if len(turns.t) else 0.0
    kept = turns.t < first + period * (1.0 - 1e-9)
    return TurningPoints(
        turns.t[kept] % period,
        turns.clearance[kept],
        turns.bound[kept],
        turns.flight[kept],
        turns.doubt[kept],
    )
