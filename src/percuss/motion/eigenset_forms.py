"""Closed forms of motions whose impact times are the eigenset, or the subset Y_m of it.

The oscillator is `impact_oscillator()`: x'' + x = f(t), x > 0, elastic wall at 0; lengths are
those of f, times those of 1/sqrt(stiffness) (Dyskin et al. 2012, eq. 5). Derivations:
docs/theory/paper-family.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_float, cos_sin, pi_times, whole
from percuss.model.forcing import Forcing, cosine
from percuss.motion.root import bisected
from percuss.numerics import cos, sin, tan

__all__ = [
    "SubsetMotion",
    "contact_time",
    "eigenset_motion",
    "subset_critical_velocity",
    "subset_forcing",
]


# A velocity given as a rounded decimal or a computed root may exceed the bound by its rounding.
ROUNDING = 1e-12


def eigenset_motion(v0: Exact, t: ArrayLike) -> tuple[Floats, Floats]:
    """Return the motion without forcing, whose impact times are the eigenset pi k.

    Parameters
    ----------
    v0
        Velocity at t = 0, where x = 0 [length/time], >= 0.
    t
        Times, >= 0, of any shape; at an impact the velocity is that after it.

    Returns
    -------
    tuple of arrays
        x and v, of t's shape: v0 sin(t - pi k) on [pi k, pi (k + 1)] (Dyskin et al. 2012, eq. 9).

    Raises
    ------
    ParameterError
        If v0 is negative.

    Examples
    --------
    >>> x, v = eigenset_motion(2.0, [0.5 * math.pi, 1.5 * math.pi])
    >>> x.tolist()
    [2.0, 2.0]
    """
    speed = as_float(v0)
    if speed < 0.0:
        raise ParameterError("v0", v0, "negative: into the wall")
    times = np.asarray(t, dtype=np.float64)
    since = times - np.floor(times / math.pi) * math.pi
    return speed * sin(since), speed * cos(since)


def subset_forcing(m: int) -> Forcing:
    """Return the force whose motions from x = 0 at t = 0 have the impact times Y_m.

    Y_m = {0, m pi, (m+1) pi, (2m+1) pi, ...} has the gaps m pi and pi in turn. The force is
    cos(pi/(m+1)) - (m-1)(m+3)/(m+1)^2 cos((2t + pi)/(m+1)); the factor (3-m)(m+5)/(m+1)^2 of
    Dyskin et al. 2012, eq. 12, does not belong to their motion (11).

    Parameters
    ----------
    m
        The longer gap in units of pi, >= 2.

    Returns
    -------
    Forcing
        Of the period (m+1) pi, with exact frequency, amplitude and phase.

    Raises
    ------
    ParameterError
        If m is not a whole number of at least 2.

    Examples
    --------
    >>> subset_forcing(2).harmonics
    (Harmonic(amplitude=Fraction(-5, 9), omega=Fraction(2, 3), phase=pi_times(1, 3)),)
    """
    _check_m(m)
    amplitude = Fraction(-(m - 1) * (m + 3), (m + 1) ** 2)
    phase = pi_times(1, m + 1)
    return cosine(Fraction(2, m + 1), amplitude, phase, constant=cos_sin(phase)[0])


def contact_time(m: int) -> float:
    """Return when the motion with the critical velocity of an odd m first touches the wall.

    It is the root of cot(t/(m+1)) + cot((t + pi)/(m+1)) = (m+1) cot t on (pi, 2 pi), which
    follows from both lines of Dyskin et al. 2012, eq. A6; a second touch, at m pi minus it,
    lies in the interval that they name.

    Parameters
    ----------
    m
        An odd number, >= 3.

    Returns
    -------
    float
        The time, in (pi, 2 pi).

    Raises
    ------
    ParameterError
        If m is no odd number of at least 3.

    Examples
    --------
    >>> contact_time(3) / math.pi
    1.5
    """
    _check_m(m)
    if m % 2 == 0:
        raise ParameterError("m", m, "even: there is no touch, an impact loses its velocity")
    gap = m + 1

    def tilt(t: float) -> float:
        ends = 1.0 / tan(t / gap) + 1.0 / tan((t + math.pi) / gap)
        return gap / tan(t) - ends

    return bisected(tilt, math.pi, 2.0 * math.pi)


def subset_critical_velocity(m: int) -> float:
    """Return V*(m), up to which an initial velocity gives the impact times Y_m.

    For even m the velocity of the impact at m pi, 2q - V0, falls to zero at
    V* = 2q = 4/(m+1) sin(pi/(m+1)) (Dyskin et al. 2012, eq. A4). For odd m the long flight
    touches the wall at `contact_time` (eqs. A5 to A8).

    Parameters
    ----------
    m
        The longer gap in units of pi, >= 2.

    Returns
    -------
    float
        The velocity, to rounding.

    Raises
    ------
    ParameterError
        If m is not a whole number of at least 2.

    Examples
    --------
    >>> round(subset_critical_velocity(2), 12), round(subset_critical_velocity(5), 12)
    (1.154700538379, 1.5)
    """
    _check_m(m)
    kick = _kick(m)
    if m % 2 == 0:
        return 2.0 * kick
    t = contact_time(m)
    return kick + 2.0 * sin(t / (m + 1)) * sin((t + math.pi) / (m + 1)) / -sin(t)


@dataclass(frozen=True, slots=True)
class SubsetMotion:
    """The motion under `subset_forcing` from x = 0, with the impact times Y_m.

    Called with times it gives x and v:
    x = A sin t - cos((2t + pi)/(m+1)) + cos(pi/(m+1)) with one A for each flight
    (Dyskin et al. 2012, eqs. 10 to 14).

    Parameters
    ----------
    m
        The longer gap in units of pi, >= 2.
    v0
        Velocity at t = 0, in [0, V*(m)]; at the two ends some impacts have no velocity.

    Raises
    ------
    ParameterError
        If m is not a whole number of at least 2, or v0 outside its range.

    Examples
    --------
    >>> motion = SubsetMotion(3, 0.5)
    >>> motion.impact_times(4) / math.pi
    array([3., 4., 7., 8.])
    >>> motion.velocities
    (0.5, 0.5)
    """

    m: int
    v0: Exact

    def __post_init__(self) -> None:
        highest = subset_critical_velocity(self.m)
        if not 0.0 <= as_float(self.v0) <= highest * (1.0 + ROUNDING):
            reason = f"outside [0, V*({self.m})], V* = {highest!r}, where the impact times are Y_m"
            raise ParameterError("v0", self.v0, reason)

    @property
    def forcing(self) -> Forcing:
        """The force, that of `subset_forcing`."""
        return subset_forcing(self.m)

    @property
    def velocities(self) -> tuple[float, ...]:
        """Velocities after the impacts of one repetition of the motion, the first that at t = 0.

        V0, V0 for odd m; V0, 2q - V0, 2q - V0, V0 for even m, q = 2/(m+1) sin(pi/(m+1)).
        """
        first = as_float(self.v0)
        if self.m % 2:
            return first, first
        second = max(2.0 * _kick(self.m) - first, 0.0)
        return first, second, second, first

    @property
    def amplitudes(self) -> tuple[float, ...]:
        """A of the flights of one repetition, t counted from the start of each period (m+1) pi."""
        kick, sign = _kick(self.m), 1.0 if self.m % 2 == 0 else -1.0
        found = []
        for start in self.velocities[::2]:
            found += [start - kick, kick * (1.0 + 2.0 * sign) - start]
        return tuple(found)

    @property
    def period(self) -> float:
        """Period of the motion [time]: (m+1) pi; twice that for even m, unless V0 = V*/2."""
        single = self.velocities[0] == self.velocities[-2]
        return (self.m + 1) * math.pi * (1 if single else 2)

    def impact_times(self, count: int) -> Floats:
        """Return the first impact times after t = 0 [time], (count,)."""
        if count < 0:
            raise ParameterError("count", count, "negative")
        index = np.arange(1, count + 1)
        return np.asarray((index // 2 * (self.m + 1) + index % 2 * self.m) * math.pi, np.float64)

    def __call__(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return (x, v) at times t >= 0 of any shape; at an impact the velocity after it."""
        times = np.asarray(t, dtype=np.float64)
        gap = self.m + 1
        number = np.floor(times / (gap * math.pi))
        since = times - number * gap * math.pi
        amplitudes = np.array(self.amplitudes)
        flight = np.where(since >= self.m * math.pi, 1, 0) + 2 * number.astype(np.int64)
        amplitude = amplitudes[flight % len(amplitudes)]
        # cos(pi/(m+1)) - cos((2t+pi)/(m+1)) as a product, which keeps its digits at the wall.
        free = 2.0 * sin(since / gap) * sin((since + math.pi) / gap)
        slope = 2.0 / gap * sin((2.0 * since + math.pi) / gap)
        return amplitude * sin(since) + free, amplitude * cos(since) + slope


def _kick(m: int) -> float:
    """Return q, the part of the initial velocity that is not A."""
    return 2.0 / (m + 1) * cos_sin(pi_times(1, m + 1))[1]


def _check_m(m: object) -> None:
    whole("m", m, 2)
