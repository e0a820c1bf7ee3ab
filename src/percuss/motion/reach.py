"""Bounds of the time in which a flight provably meets no stop, for long walks of the kernels.

With a spring the answer is that of `next_event.event_free_until`, here for rates of
any spread. A mass without spring that drifts away is recognised.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import later
from percuss.kernels.flight import Flight, FlightStart, move, move_over_knots, set_phases
from percuss.kernels.law_columns import (
    AMPLITUDE,
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    GAIN_IM,
    GAIN_RE,
    GROWTH,
    LOWER,
    N_HARMONICS,
    OMEGA,
    ORIGIN_FORCE,
    PERIOD,
    SINE,
    STIFFNESS,
    UPPER,
    Law,
)
from percuss.kernels.next_event import event_free_until, slowest
from percuss.kernels.tangent import propagator
from percuss.numerics import determinant, exp, hypot, solve_linear

# A monodromy matrix so near to the identity makes every free motion periodic too.
IDENTITY = 1e-10


# Displacements are rounded here as in any flight; a clearance has to be larger than this part of
# the sizes involved.
SLACK = 1e-9


def free_until(
    law: Law,
    region: int,
    x: float,
    start: FlightStart,
    phases: Floats,
    s: float,
    longest: float,
) -> float:
    """Return a time since the start, at least s, up to which a flight provably meets no bound.

    Infinite if it never will.
    """
    reach = (law[region, LOWER] - x, law[region, UPPER] - x)
    if reach == (-math.inf, math.inf):
        return math.inf
    gain = law[region + 1 : region + 1 + len(phases), (GAIN_RE, GAIN_IM)]
    if law[region, GROWTH] > 0.0:
        return s
    if law[region, STIFFNESS] == 0.0 and not (gain == 0.0).all(axis=1).any():
        return math.inf if drifts_away(law, region, start, phases, s, reach) else s
    if slowest(law, region, len(phases)) == math.inf:
        return s
    flight = Flight(law, region, start, phases, np.empty_like(phases))
    return float(event_free_until(flight, s, reach, longest))


def misses(reach: tuple[float, float], low: float, high: float, size: float) -> bool:
    """Return whether displacements between low and high stay clear of both bounds.

    ``size`` is that of the terms they are sums of.
    """
    slack = SLACK * (abs(low) + abs(high) + size)
    return low - slack > reach[0] and high + slack < reach[1]


@np.errstate(over="ignore", invalid="ignore")
def steady(law: Law, region: int, phases: Floats) -> Floats:
    """Return (y, v) of the steady motion of each harmonic at the instant of ``phases``."""
    n = len(phases)
    rows = law[FIRST_HARMONIC : FIRST_HARMONIC + n]
    real, imaginary = law[region + 1 : region + 1 + n, (GAIN_RE, GAIN_IM)].T
    in_phase = rows[:, COSINE] * phases[:, 0] + rows[:, SINE] * phases[:, 1]
    quadrature = rows[:, SINE] * phases[:, 0] - rows[:, COSINE] * phases[:, 1]
    # The phasor in_phase - i quadrature, times the gain; v is that of i omega times it.
    y = in_phase * real + quadrature * imaginary
    v = -rows[:, OMEGA] * (in_phase * imaginary - quadrature * real)
    return np.column_stack([y, v])


def drifts_off(reach: tuple[float, float], drift: float, doubt: float, mean: Fraction) -> bool:
    """Return whether a mass without spring drifts off each bound that there is, from now on.

    Under a force of some period with a mean, what it moves in a period from t on changes one way
    with t: from ``drift`` now to what has the sign of the mean, or for good to it. Where neither
    leads to a bound the mass is never nearer to it than within the period that begins now.
    """
    if math.isfinite(reach[0]) and not (drift > doubt and mean >= 0):
        return False
    return not math.isfinite(reach[1]) or (drift < -doubt and mean <= 0)


def periodic_state(law: Law, region: int, t: float) -> tuple[float, float] | None:
    """Return (x - ORIGIN, v) at t of the periodic motion of a region under a repeated record.

    A period is an affine map of the state, whose fixed point it is; None where it has not one.
    """
    period = float(law[0, PERIOD])
    moved = _moved(law, region, (0.0, 0.0), period)
    rest = np.eye(2) - np.array(propagator(law, region, period)).reshape(2, 2)
    if not abs(determinant(rest)) > IDENTITY:
        return None
    y, v = solve_linear(rest, np.array(moved)).tolist()
    if t % period == 0.0:
        return y, v
    further, speed = _moved(law, region, (y, v), t % period)
    return y + further, speed


def _moved(law: Law, region: int, state: tuple[float, float], t: float) -> tuple[float, float]:
    """Return the change of x, and v, from t = 0 to t, of a state (x - ORIGIN, v) in a region."""
    phases, arrival = np.empty((2, int(law[0, N_HARMONICS]), 2))
    set_phases(law, 0.0, 0.0, phases)
    force = float(law[region, ORIGIN_FORCE]) - float(law[region, STIFFNESS]) * state[0]
    start = (0.0, 0.0, state[1], force)
    return move_over_knots(Flight(law, region, start, phases, arrival), t)


def drifts_away(
    law: Law, region: int, start: FlightStart, phases: Floats, s: float, reach: tuple[float, float]
) -> bool:
    """Return whether a mass without spring (K = 0) meets no bound after s, and never will.

    Its motion is the swing under the harmonics and a drift, which keeps its direction once it does
    not oppose the constant force.
    """
    at = np.empty_like(phases)
    y, _ = move(Flight(law, region, start, phases, at), s)
    set_phases(law, *later(start[0], start[1], s), at)
    y -= float(steady(law, region, at)[:, 0].sum())
    gain = hypot(*law[region + 1 : region + 1 + len(phases), (GAIN_RE, GAIN_IM)].T)
    swing = law[FIRST_HARMONIC : FIRST_HARMONIC + len(phases), (AMPLITUDE, OMEGA)].T
    size = float((swing[0] * gain).sum())
    speeds = float((swing[0] * swing[1] * gain).sum())
    # From the start of the flight, before the velocity is rounded.
    drift = start[2] - float(steady(law, region, phases)[:, 1].sum())
    doubt = SLACK * (abs(start[2]) + speeds)
    damping, force = law[region, DAMPING], start[3]
    low = high = y
    if damping > 0.0:
        # The drift decays to that at which the damping holds the constant force.
        far = y + (drift - 0.5 * force / damping) * exp(-2.0 * damping * s) / (2.0 * damping)
        low, high = min(y, far), max(y, far)
        sign = force
    elif force == 0.0:
        if 0.0 < abs(drift) <= doubt:
            return False
        sign = drift
    else:
        now = drift + force * s
        if abs(now) <= doubt or now * force < 0.0:
            return False
        sign = force
    if (sign < 0.0 and reach[0] > -math.inf) or (sign > 0.0 and reach[1] < math.inf):
        return False
    return misses(reach, low - size, high + size, abs(y) + size)
