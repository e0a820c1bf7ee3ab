"""The growth under sin t without bound, proven: bounds of the impact map over a box of states.

With epsilon = 1/V two impacts change the phase by epsilon^3 times a number, and V^2 by another.
Ball arithmetic with power series bounds both over a box, and that closes an induction.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_series

from percuss.certified.numbers import ball, between, precision

BITS = 128
# The remainder of the phase is of the third order.
TERMS = 4
# A box is cut into so many phases and so many epsilons, each bounded by itself.
PARTS = 24, 12
# How far a flight may end from pi: its sine is not monotonic further out.
REACH = Fraction(1, 2)
# Of the enclosure of the root, each by the one before.
ROUNDS = 4


@dataclass(frozen=True)
class GrowthBounds:
    """What two impacts do at the least and at the most, over a box of phases and velocities.

    Parameters
    ----------
    gain
        V^2 grows by this at least: (V + g)^2 - V^2 >= 2 V g.
    drift
        The phase moves by this over V^3 at most.
    """

    gain: arb
    drift: arb

    def total_drift(self, velocity: arb) -> arb:
        """Return the most that the phase moves in all impacts after one with a velocity.

        The sum of drift (V^2 + gain j)^(-3/2) over j, by its first term and an integral.
        """
        return self.drift * (1 / velocity**3 + 2 / (self.gain * velocity))


def growth_bounds(low: Fraction, high: Fraction, velocity: Fraction) -> GrowthBounds:
    """Return what two impacts do for t_k modulo pi from low to high, and V of at least a velocity.

    Raises
    ------
    ArithmeticError
        If a flight from the box is not shown to end within REACH of pi.
    """
    n_phases, n_eps = PARTS
    with precision(BITS):
        step, part = (high - low) / n_phases, 1 / (velocity * n_eps)
        bounds = [
            _two_impacts(_between(low + i * step, step), _between(j * part, part))
            for i in range(n_phases)
            for j in range(n_eps)
        ]
        gain = min((slope.lower() for slope, _ in bounds), key=float)
        drift = max((third.abs_upper() for _, third in bounds), key=float)
        return GrowthBounds(2 * gain, drift)


def _between(low: Fraction, width: Fraction) -> arb:
    return between(ball(low), ball(low + width))


def _two_impacts(phase: arb, eps: arb) -> tuple[arb, arb]:
    """Return enclosures of the first coefficient of the gain, and of the third of the drift.

    A function of epsilon whose terms below the n-th vanish is epsilon^n times its n-th
    coefficient about some point between 0 and epsilon: here about all points of the ball.
    """
    e = _series(eps, arb(1))
    t = _series(phase)
    excess, gain = _flight(t, e)
    later, other = _flight(t + arb.pi() + excess, e / (1 + e * gain))
    gain, drift = gain + other, excess + later
    return gain[1], drift[TERMS - 1]


def _flight(t: arb_series, e: arb_series) -> tuple[arb_series, arb_series]:
    """Return how much longer than pi a flight lasts, and how much faster the next one begins."""
    sin, cos = t.sin(), t.cos()

    def excess_of(excess: arb_series) -> arb_series:
        interval = arb.pi() + excess
        return (e * interval * cos / (2 + e * (cos + interval * sin))).atan()

    first = between(-ball(REACH), ball(REACH))
    if not first.contains(excess_of(_series(first))[0]):
        raise ArithmeticError("a flight is not shown to end near pi")
    for _ in range(ROUNDS):
        # A root lies in the image of what it lies in.
        first = excess_of(_series(first))[0]
    excess = _series(first)
    # Each coefficient enters its own equation with the factor 1 - slope.
    slope = excess_of(_series(first, arb(1)) + 0 * e)[1] - excess_of(_series(first))[1]
    for n in range(1, TERMS):
        coefficient = excess_of(excess)[n] / (1 - slope)
        excess = excess + arb_series([0] * n + [coefficient], prec=TERMS)
    interval = arb.pi() + excess
    bent = interval * cos * excess.cos() / (2 + e * (cos + interval * sin))
    gain = -bent * (excess / 2).tan() + cos / 2 * interval * excess.sin()
    return excess, gain + sin / 2 * (excess.sin() + interval * excess.cos())


def _series(*coefficients: arb) -> arb_series:
    return arb_series(list(coefficients), prec=TERMS)
