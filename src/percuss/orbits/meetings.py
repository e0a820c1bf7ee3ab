"""How a branch goes on where its orbits meet a soft stop that they did not meet, or no more.

There the order of events changes. A soft stop's force begins with zero, so that the motion depends
smoothly enough on its start: beyond the graze there is one orbit as well, and it has the two
crossings of the stop's edge more, or less (docs/theory/grazing.md).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from percuss.errors import PercussError
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.law import EDGE, N_HARMONICS, Law
from percuss.kernels.record import Integers
from percuss.model.law import law
from percuss.orbits.family import Family
from percuss.orbits.passages import turns_of
from percuss.orbits.periodic_orbit import PeriodicOrbit
from percuss.orbits.touches import Touch, acceleration_at, settled, touches_of, without

__all__ = ["is_soft", "orbit_beyond"]

Floats = NDArray[np.float64]

# Beyond the graze by this part of the range, at most and at least.
FARTHEST, NEAREST, NEARER = 2e-3, 1e-9, 0.25
# Velocities and durations at the stop are those of a parabola within this factor.
PARABOLIC = 2.0


def orbit_beyond(family: Family, orbit: PeriodicOrbit, value: float) -> PeriodicOrbit | None:
    """Return an orbit a little beyond a graze of soft stops, with the events that it has there.

    Parameters
    ----------
    family
        The orbits up to the graze.
    orbit
        The one at the graze.
    value
        The parameter there.

    Returns
    -------
    PeriodicOrbit or None
        In the same range of the parameter; None if there is none near.
    """
    touches = [touch for touch in touches_of(orbit) if is_soft(orbit, touch)]
    met = [touch for touch in touches if touch.events]
    if not touches or len(met) not in (0, len(touches)):
        return None
    try:
        base = without(orbit, met)
    except PercussError:
        return None
    simpler = Family(base, family.path, family.low, family.high)
    part = FARTHEST
    while part >= NEAREST:
        for way in (-1.0, 1.0):
            beside = value + way * part * (family.high - family.low)
            if not family.low <= beside <= family.high:
                continue
            found = _beside(simpler, base, value, beside, touches)
            if found is not None and bool(met) == (len(found._chain) == len(base._chain)):
                return found
        part *= NEARER
    return None


def is_soft(orbit: PeriodicOrbit, touch: Touch) -> bool:
    """Tell whether a touch is one of a soft stop's edge."""
    table = law(orbit.oscillator, orbit.forcing)
    upper = touch.way > 0.0
    return bool(table[touch.region, at.UPPER_KIND if upper else at.LOWER_KIND] == EDGE)


def _beside(
    family: Family, base: PeriodicOrbit, value: float, beside: float, touches: list[Touch]
) -> PeriodicOrbit | None:
    """Return the physical orbit at a value of the parameter beside a graze."""
    start = family.start(base, value)
    held = np.append(np.zeros(len(start) - 1), 1.0)
    guess = start.copy()
    guess[-1] = (beside - family.low) / (family.high - family.low)
    try:
        formal = family.orbit(family.corrected(guess, held))
        depths = [_depth(formal, touch) for touch in touches]
        if all(depth < 0.0 for _, depth in depths):
            return formal
        if not all(depth > 0.0 for _, depth in depths):
            return None
        return _with_meetings(formal, touches, depths)
    except PercussError:
        return None


def _depth(orbit: PeriodicOrbit, touch: Touch) -> tuple[float, float]:
    """Return instant and depth of the turning point that a touch has become."""
    table = law(orbit.oscillator, orbit.forcing)
    lasting = orbit.period if len(orbit._chain) else 1.5 * orbit.period
    turns = turns_of(table, orbit._events, orbit._marks, orbit.x0, orbit.t0 + lasting)
    apart = (turns.t - touch.t) % orbit.period
    apart = np.minimum(apart, orbit.period - apart)
    apart[turns.bound != touch.bound] = math.inf
    if not len(apart) or not math.isfinite(apart.min()):
        return touch.t, math.nan
    nearest = int(np.argmin(apart))
    return float(turns.t[nearest]), -float(turns.clearance[nearest])


def _with_meetings(
    formal: PeriodicOrbit, touches: list[Touch], depths: list[tuple[float, float]]
) -> PeriodicOrbit | None:
    """Return the orbit that meets the stops which a formal one passes by these depths."""
    table = law(formal.oscillator, formal.forcing)
    period, n = formal.period, len(formal._chain)
    rows: list[tuple[float, list[int], float]] = []
    for i in range(n):
        v = float(formal._unknowns[1 + n + i])
        rows.append((float(formal._events[i, columns.EVENT_T]), formal._chain[i].tolist(), v))
    expected = []
    step = 1 + int(table[0, N_HARMONICS])
    for touch, (turn, depth) in zip(touches, depths, strict=True):
        away = abs(acceleration_at(table, touch, turn))
        speed = math.sqrt(2.0 * away * depth)
        beyond = touch.region + int(touch.way) * step
        t = formal.t0 + (turn - formal.t0) % period
        into = [touch.bound, touch.region, beyond]
        out = [touch.bound, beyond, touch.region]
        rows.append((t - speed / away, into, touch.way * speed))
        rows.append((t + speed / away, out, -touch.way * speed))
        expected.append((into, speed, 2.0 * speed / away))
    rows.sort(key=lambda row: row[0])
    return _settled(formal, rows, expected)


def _settled(
    formal: PeriodicOrbit,
    rows: list[tuple[float, list[int], float]],
    expected: list[tuple[list[int], float, float]],
) -> PeriodicOrbit | None:
    table = law(formal.oscillator, formal.forcing)
    # The first event meets a stop: so orbits begin.
    if len(formal._chain) == 0:
        first = next(k for k, row in enumerate(rows) if _enters(table, row[1]))
        rows = rows[first:] + [(t + formal.period, row, v) for t, row, v in rows[:first]]
    instants = np.array([t for t, _, _ in rows])
    lasting = np.diff(np.append(instants, instants[0] + formal.period))
    chain: Integers = np.array([row for _, row, _ in rows], dtype=np.int64)
    guess = np.concatenate([instants[:1], lasting, [v for _, _, v in rows]])
    found = settled(formal, chain, guess)
    n = len(chain)
    for into, speed, short in expected:
        i = next(k for k in range(n) if chain[k].tolist() == into and _near(lasting[k], short))
        v, s = abs(found._unknowns[1 + n + i]), found._unknowns[1 + i]
        if not (_near(v, speed) and _near(s, short)):
            return None
    return found


def _enters(table: Law, row: list[int]) -> bool:
    """Tell whether a row of a chain enters a soft stop."""
    bound, before, _ = row
    upper = bound > int(table[before, at.NUMBER])
    return bool(table[before, at.UPPER_ENTRY if upper else at.LOWER_ENTRY] == 1.0)


def _near(one: float, other: float) -> bool:
    return other / PARABOLIC < one < other * PARABOLIC
