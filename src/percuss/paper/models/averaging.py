"""The force on fast flights between elastic impacts, averaged over its cycle.

The oscillator is x'' + x = cos(omega t + phase), x > 0, restitution 1; speeds are in units of the
force's amplitude. docs/theory/resonances.md derives all of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Complexes, Floats

# What is neglected falls as speed^-2, and the two speeds remove that too; rounding grows as
# speed^order.
_SPEEDS = (10.0, 20.0)


@dataclass(frozen=True)
class Averaged:
    """The averaged motion at omega = 2 p / q: what varies slowly over q flights.

    The energy E = V^2 / 2 and the time drift of the impacts obey Hamilton's equations with
    H = V^(2 - q) strength cos(q psi) + twist V^-4, psi the phase of the force in the middle of a
    flight; so V^q can grow at the rate 2 p q |strength|, and in no other power.

    Parameters
    ----------
    p, q
        Of omega / 2 in lowest terms.
    strength
        The part of H that depends on the phase, at leading order.
    twist
        The first part that does not.
    """

    p: int
    q: int
    strength: float
    twist: float

    @property
    def rate(self) -> float:
        """Growth of V^q per unit time in the best phase."""
        return 2.0 * self.p * self.q * abs(self.strength)

    @property
    def balance(self) -> float:
        """Speed at which both parts of H are as large, for q != 6."""
        return float(abs(self.strength / self.twist) ** (1.0 / (self.q - 6)))


def order(omega: Fraction) -> tuple[int, int]:
    """Return p and q of omega = 2 p / q, in lowest terms.

    Examples
    --------
    >>> order(Fraction(2, 3)), order(Fraction(1))
    ((1, 3), (1, 2))
    """
    half = omega / 2
    return half.numerator, half.denominator


def kick(omega: float) -> float:
    """Return K = 2 cos(pi omega / 2) / (1 - omega^2), pi / 2 at omega = 1.

    A fast flight of speed V in whose middle the force has phase psi lasts K cos(psi) / V longer
    than pi, and ends faster by omega K sin(psi).

    Examples
    --------
    >>> round(kick(2.0), 12), round(kick(1.0), 12), abs(kick(3.0)) < 1e-15
    (0.666666666667, 1.570796326795, True)
    """
    # 2 cos(pi w / 2) / (1 - w^2) = pi sinc((1 - w) / 2) / (1 + w), without the pole at w = 1.
    turn = 0.5 * math.pi * (1.0 - omega)
    sinc = numerics.sin(turn) / turn if turn != 0.0 else 1.0
    return math.pi * sinc / (1.0 + omega)


def strength(omega: Fraction) -> float:
    """Return the strength of the averaged force for omega = 2 p / q, q <= 4, in closed form.

    Parameters
    ----------
    omega
        The frequency of the force.

    Returns
    -------
    float
        K / pi for q = 1; 1/8 for omega = 1 and 0 for the other odd ones (q = 2);
        K^3 (1 - omega^2) / (12 pi) for q = 3; K^4 omega (1 - omega^2) tan(pi omega / 2) / (24 pi)
        for q = 4; NaN for others.

    Examples
    --------
    >>> round(strength(Fraction(2, 3)) * math.pi, 12), strength(Fraction(3))
    (0.27, 0.0)
    """
    _, q = order(omega)
    w = float(omega)
    k = kick(w)
    if q == 1:
        return k / math.pi
    if q == 2:
        return 0.125 if omega == 1 else 0.0
    if q == 3:
        return k**3 * (1.0 - w * w) / (12.0 * math.pi)
    if q == 4:
        return k**4 * w * (1.0 - w * w) * numerics.tan(0.5 * math.pi * w) / (24.0 * math.pi)
    return math.nan


def fast_flight(phase: Floats, speed: Floats, omega: float) -> tuple[Floats, Floats, Floats]:
    """Follow fast flights from impact to impact, each about pi long, from the closed form.

    Parameters
    ----------
    phase
        (n,) array, phase of the force at the start of each flight [rad].
    speed
        (n,) array, V after the impact, well above the force's amplitude.
    omega
        The frequency.

    Returns
    -------
    tuple of array
        Phase and V after the next impact, and by how much the flight is longer than pi.

    Examples
    --------
    >>> after = fast_flight(np.array([0.3]), np.array([5.0]), 2.0)
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.cosine(2, phase=0.3), v0=5, max_impacts=1)
    >>> bool(abs(after[1][0] - run.impacts.v_after[0]) < 1e-13)
    True
    """
    start = numerics.phasor(phase)
    longer = np.zeros_like(speed)
    for _ in range(6):
        x, v = _flight(phase, start, speed, omega, longer)
        longer = longer - x / v
    _, v = _flight(phase, start, speed, omega, longer)
    return phase + omega * (math.pi + longer), -v, longer


def _flight(
    phase: Floats, start: Complexes, speed: Floats, omega: float, longer: Floats
) -> tuple[Floats, Floats]:
    """Return x and v at a time pi + longer after the start, the phasor of whose phase is given."""
    t = math.pi + longer
    turned, end = numerics.phasor(t), numerics.phasor(phase + omega * t)
    c, s = turned.real, turned.imag
    if omega == 1.0:
        x = speed * s + 0.5 * (t * end.imag - start.imag * s)
        v = speed * c + 0.5 * (end.imag + t * end.real - start.imag * c)
        return x, v
    gain = 1.0 / (1.0 - omega * omega)
    start_x, start_v = gain * start.real, speed + gain * omega * start.imag
    x = start_v * s - start_x * c + gain * end.real
    v = start_v * c + start_x * s - gain * omega * end.imag
    return x, v


def mean_delays(omega: float, speeds: Floats, flights: int = 2000) -> Floats:
    """Return by how much fast flights are longer than pi in the long run.

    The delays are averaged with weights exp(-1/(s(1-s))), which for quasi-periodic motions
    converges faster than any power of the number of flights.

    Parameters
    ----------
    omega
        Frequency of the force, no ratio 2 p / q of small numbers.
    speeds
        (n,) array, V at the start, in phase with the force.
    flights
        How many flights are averaged.

    Returns
    -------
    array
        (n,) mean delays.

    Examples
    --------
    >>> float((mean_delays(0.618, np.array([20.0])) * 20.0**6)[0].round(2))
    0.45
    """
    phase, v = np.zeros_like(speeds), speeds
    delays = np.empty((flights, len(speeds)))
    for k in range(flights):
        phase, v, delays[k] = fast_flight(phase, v, omega)
    s = (np.arange(flights) + 0.5) / flights
    return np.asarray(np.average(delays, axis=0, weights=numerics.exp(-1.0 / (s * (1.0 - s)))))


@cache
def averaged(omega: Fraction) -> Averaged:
    """Return the averaged motion at omega = 2 p / q, measured on q fast flights in a row.

    The energy's change over q flights is projected on sin(q psi), and their mean delay gives the
    twist.

    Parameters
    ----------
    omega
        The frequency of the force.

    Returns
    -------
    Averaged
        Its strength is good to about 1e-5 of itself, its twist to 1e-2 (and means nothing for
        q < 5, where terms of lower order hide it).

    Examples
    --------
    >>> found = averaged(Fraction(2, 3))
    >>> found.q, abs(found.strength / strength(Fraction(2, 3)) - 1) < 1e-5
    (3, True)
    """
    p, q = order(omega)
    coarse, fine = (np.array(_measure(float(omega), p, q, speed)) for speed in _SPEEDS)
    best = (4.0 * fine - coarse) / 3.0
    return Averaged(p, q, float(best[0]), float(best[1]))


def strengths_at(omega: Fraction, speeds: Sequence[float]) -> list[float]:
    """Return the strength as flights at some speeds show it, with an error of order speed^-2.

    Examples
    --------
    >>> [round(found / strength(Fraction(4)), 4) for found in strengths_at(Fraction(4), (10.0, 20.0))]
    [0.9998, 1.0]
    """
    p, q = order(omega)
    return [_measure(float(omega), p, q, speed)[0] for speed in speeds]


def _measure(omega: float, p: int, q: int, speed: float) -> tuple[float, float]:
    """Return strength and twist, with an error of order speed^-2."""
    start = 2.0 * math.pi * np.arange(8 * q) / (8 * q)
    phase, v = start, np.full(8 * q, speed)
    delay = np.zeros(8 * q)
    for _ in range(q):
        phase, v, longer = fast_flight(phase, v, omega)
        delay += longer
    lasting = q * math.pi
    power = 0.5 * (v - speed) * (v + speed) / lasting * speed ** (q - 2)
    # q times the phase in the middle of a flight is q times that at its start and p half turns.
    strength_now = (-1) ** p * 2.0 * float(np.mean(power * numerics.sin(q * start))) / (q * omega)
    return strength_now, float(np.mean(delay)) / lasting * speed**6 / -4.0
