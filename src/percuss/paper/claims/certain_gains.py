"""Two impacts under sin t in ball arithmetic: what the velocity gains, and how the phase drifts."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from percuss.arrays import Floats
from percuss.model.forcing import sine
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain import certain_run
from percuss.paper.claims.evidence import WALL

__all__ = ["exponent_of_drift", "mean_gain", "two_proven_impacts"]

# Instant, and velocity after it; None where it is not proven.
State = tuple["arb", "arb"]


def two_proven_impacts(t: float, v: float) -> State | None:
    """Return the second impact after one at t that leaves with v, as balls."""
    proven = certain_run(simulate(WALL, sine(1), v0=v, t0=t, max_impacts=2))
    if proven is None:
        return None
    return proven.impacts.t.arbs[1], proven.impacts.v_after.arbs[1]


def mean_gain(v: float, states: Sequence[State | None]) -> tuple[float, float] | None:
    """Return the mean of v (V - v) over second impacts with V, and its radius."""
    known = [state for state in states if state is not None]
    if len(known) < len(states):
        return None

    mean = sum((arb(v) * (after - arb(v)) for _, after in known), arb(0)) / len(known)
    return float(mean.mid()), float(mean.rad()) + 1e-15


def exponent_of_drift(
    t: float, velocities: Floats, states: Sequence[State | None]
) -> tuple[float, float] | None:
    """Return p of a drift of the phase as V^-p over two impacts, by least squares, and its radius."""
    known = [state for state in states if state is not None]
    if len(known) < len(states):
        return None

    logs = [arb(float(v)).log() for v in velocities]
    drifts = [abs(instant - arb(t) - 2 * arb.pi()).log() for instant, _ in known]
    mean = sum(logs, arb(0)) / len(logs)
    apart = [log - mean for log in logs]
    slope = sum((a * d for a, d in zip(apart, drifts, strict=True)), arb(0))
    slope = -slope / sum((a * a for a in apart), arb(0))
    return float(slope.mid()), float(slope.rad()) + 1e-15
