"""Two impacts under sin t in ball arithmetic: what the velocity gains, and how fast it grows."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from percuss.certified.numbers import ball, precision
from percuss.model.exact import Exact
from percuss.model.harmonic_forces import sine
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run
from percuss.paper.claims.comparisons import WALL

# At V = 1e6 the change of V^2 is 1e-12 of it: so many digits leave 28.
DIGITS = 40
BITS = 256
# Instant, and velocity after it.
State = tuple[arb, arb]


def two_impacts(t: Exact, v: Exact) -> Trajectory:
    """Return two flights of (27) from an impact at t that leaves with v."""
    return simulate(WALL, sine(1), v0=v, t0=t, max_impacts=2)


def two_proven_impacts(t: Exact, v: Exact) -> State:
    """Return the second impact after one at t that leaves with v, as balls.

    Raises
    ------
    ArithmeticError
        If it is not proven.
    """
    proven = certain_run(two_impacts(t, v), digits=DIGITS)
    if proven is None or len(proven.impacts) != 2:
        raise ArithmeticError(f"the flights from t = {t}, V = {v} are not proven")
    return proven.impacts.t.arbs[1], proven.impacts.v_after.arbs[1]


def mean_gain(v: float, states: Sequence[State]) -> tuple[float, float]:
    """Return the mean of v (V - v) over second impacts with V, and its radius."""
    with precision(BITS):
        mean = sum((arb(v) * (after - arb(v)) for _, after in states), arb(0)) / len(states)
    return float(mean.mid()), float(mean.rad()) + 1e-15


def rate_over_two_impacts(t: str, v: int) -> tuple[float, float]:
    """Return V times the change of V over two impacts and their time, and its radius."""
    with precision(BITS):
        instant, after = two_proven_impacts(t, v)
        rate = v * (after - v) / (instant - ball(Fraction(t)))
    return float(rate.mid()), float(rate.rad()) + 1e-15


def excess_of_two_flights(t: str, v: int) -> tuple[float, float]:
    """Return V times what two flights last beyond 2 pi, and its radius."""
    with precision(BITS):
        instant, _ = two_proven_impacts(t, v)
        excess = v * (instant - ball(Fraction(t)) - 2 * arb.pi())
    return float(excess.mid()), float(excess.rad()) + 1e-15
