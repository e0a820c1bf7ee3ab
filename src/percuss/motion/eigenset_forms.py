"""Closed forms of motions whose impact times are the eigenset, or the subset Y_m of it.

The oscillator is `impact_oscillator()`: x'' + x = f(t), x > 0, elastic wall at 0; lengths are
those of f, times those of 1/sqrt(stiffness) (Dyskin et al. 2012, eq. 5). The force is none, that of
`subset_forcing` (docs/theory/paper-family.md) or sin(n t), eq. 17 (docs/theory/paper-harmonics.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_float, cos_sin, pi_times, real, reals, whole
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import cosine, sine
from percuss.model.start import late_problem
from percuss.numerics import cos, sin, tan

# A velocity given as a rounded decimal or a computed root may miss a bound by its rounding.
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
        If v0 is negative, or a time is negative, not finite, or later than phases are exact.

    Examples
    --------
    >>> x, v = eigenset_motion(2.0, [0.5 * math.pi, 1.5 * math.pi])
    >>> x.tolist()
    [2.0, 2.0]
    """
    speed, times = real("v0", v0), reals("t", t)
    if speed < 0.0:
        raise ParameterError("v0", v0, "negative: into the wall")
    outside = ~((times >= 0.0) & (times < math.inf))
    if outside.any():
        raise ParameterError("t", float(times[outside][0]), "not a finite time of at least 0")
    latest = float(times.max(initial=0.0))
    problem = late_problem(latest, 0.5 / math.pi)
    if problem is not None:
        raise ParameterError("t", latest, problem)
    s, c = sin(times), cos(times)
    # A time within its rounding of an impact is that of the impact.
    is_impact = np.abs(s) <= np.spacing(times)
    x, v = np.where(is_impact, 0.0, np.abs(s)), np.where(is_impact, 1.0, np.sign(s) * c)
    return speed * x, speed * v


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
    m = whole("m", m, 2)
    amplitude = Fraction(-(m - 1) * (m + 3), (m + 1) ** 2)
    phase = pi_times(1, m + 1)
    return cosine(Fraction(2, m + 1), amplitude, phase, constant=cos_sin(phase)[0])


def contact_time(m: int) -> float:
    """Return when the motion with the critical velocity of an odd m first reaches the wall again.

    It is the root of cot(t/(m+1)) + cot((t + pi)/(m+1)) = (m+1) cot t on (pi, 2 pi), which
    follows from both lines of Dyskin et al. 2012, eq. A6; a second contact, at m pi minus it,
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
    _check_odd("m", m, "there is no contact, an impact loses its velocity")
    gap = m + 1

    def tilt(t: float) -> float:
        ends = 1.0 / tan(t / gap) + 1.0 / tan((t + math.pi) / gap)
        return gap / tan(t) - ends

    return _bisected(tilt, math.pi, 2.0 * math.pi)


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
    whole("m", m, 2)
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
        amplitudes = []
        for start in self.velocities[::2]:
            amplitudes += [start - kick, kick * (1.0 + 2.0 * sign) - start]
        return tuple(amplitudes)

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


def harmonic_contact_time(n: int) -> float:
    """Return when the motion with the critical velocity of an odd n first reaches the wall again.

    It is pi + eta, where eta is the root of n cot(n eta) = cot(eta) on (pi/n, 2 pi/n). With
    xi = pi/2 - eta this is tan(xi) = n tan(n xi) (Dyskin et al. 2012, eq. 25), of whose roots it
    is the largest below pi/2.

    Parameters
    ----------
    n
        An odd number, >= 3.

    Returns
    -------
    float
        The time, in (pi, 2 pi); by symmetry another contact comes at 3 pi minus it.

    Raises
    ------
    ParameterError
        If n is no odd number of at least 3.

    Examples
    --------
    >>> harmonic_contact_time(3) / math.pi
    1.5
    """
    return math.pi + _deepest(n)


def harmonic_critical_velocity(n: int) -> float:
    """Return V_max(n): an initial velocity up to it gives impacts beyond the eigenset.

    It is (n - min sin(n eta)/sin(eta))/(n^2 - 1) for odd n; n V_max tends to 1.2172336...
    (Dyskin et al. 2012, eqs. 24 to 26).

    Parameters
    ----------
    n
        An odd number, >= 3; for even n no velocity does.

    Returns
    -------
    float
        The velocity, to rounding.

    Raises
    ------
    ParameterError
        If n is no odd number of at least 3.

    Examples
    --------
    >>> harmonic_critical_velocity(3), round(harmonic_critical_velocity(5), 12)
    (0.5, 0.260416666667)
    """
    eta = _deepest(n)
    return (n - sin(n * eta) / sin(eta)) / (n * n - 1)


@dataclass(frozen=True, slots=True)
class HarmonicMotion:
    """The motion under sin(n t) from x = 0, with the eigenset as impact times.

    Called with times it gives x and v: x = A_k sin t - sin(n t)/(n^2 - 1) on
    [pi k, pi (k + 1)]. For even n it is a resonance (Dyskin et al. 2012, eqs. 18, 19), for odd n
    a steady oscillation of the period 2 pi (eqs. 20, 21).

    Parameters
    ----------
    n
        Multiple of the natural frequency, >= 2.
    v0
        Velocity at t = 0, >= 0; for odd n at least V_max(n).

    Raises
    ------
    ParameterError
        If n is not a whole number of at least 2, or v0 outside its range.

    Examples
    --------
    >>> HarmonicMotion(2, 0.0).velocity([0, 1, 2, 3])
    array([0.        , 1.33333333, 2.66666667, 4.        ])
    >>> HarmonicMotion(3, "0.6").velocity([0, 1])
    array([0.6, 0.6])
    """

    n: int
    v0: Exact

    def __post_init__(self) -> None:
        whole("n", self.n, 2)
        lowest = harmonic_critical_velocity(self.n) if self.n % 2 else 0.0
        if not as_float(self.v0) >= lowest * (1.0 - ROUNDING):
            why = f"below V_max({self.n}) = {lowest!r}" if self.n % 2 else "negative"
            raise ParameterError("v0", self.v0, f"{why}: the impact times are not the eigenset")

    @property
    def forcing(self) -> Forcing:
        """The force sin(n t)."""
        return sine(self.n)

    def velocity(self, k: ArrayLike) -> Floats:
        """Return V_k, the velocity after the impact at pi k, for indices k >= 0 of any shape."""
        index = np.asarray(k, dtype=np.int64)
        gain = 0.0 if self.n % 2 else 2.0 * self._share
        return np.asarray(as_float(self.v0) + gain * index, dtype=np.float64)

    def amplitude(self, k: ArrayLike) -> Floats:
        """Return A_k of the flight from pi k, for indices k >= 0 of any shape."""
        index = np.asarray(k, dtype=np.int64)
        return np.where(index % 2, -1.0, 1.0) * self._height(index)

    def __call__(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return (x, v) at times t >= 0 of any shape; at an impact the velocity after it."""
        times = np.asarray(t, dtype=np.float64)
        index = np.floor(times / math.pi).astype(np.int64)
        since = times - index * math.pi
        height = self._height(index)
        # sin(n t) has changed its sign with each half turn of n t.
        force = np.where((self.n * index) % 2, -1.0, 1.0) / (self.n**2 - 1)
        x = height * sin(since) - force * sin(self.n * since)
        v = height * cos(since) - self.n * force * cos(self.n * since)
        return x, v

    @property
    def _share(self) -> float:
        return self.n / (self.n**2 - 1)

    def _height(self, index: Integers) -> Floats:
        """Return (-1)^k A_k, the amplitude with t counted from the impact."""
        sign = np.where((self.n * index) % 2, -1.0, 1.0)
        return np.asarray(self.velocity(index) + sign * self._share, dtype=np.float64)


def _check_odd(name: str, number: int, otherwise: str) -> None:
    """Raise a ParameterError if a number is not odd and above 1; it says what even ones do."""
    if whole(name, number, 2) % 2 == 0:
        raise ParameterError(name, number, f"even: {otherwise}")


def _kick(m: int) -> float:
    """Return q, the part of the initial velocity that is not A."""
    return 2.0 / (m + 1) * cos_sin(pi_times(1, m + 1))[1]


def _deepest(n: int) -> float:
    """Return where sin(n eta)/sin(eta) is lowest on (0, pi)."""
    _check_odd("n", n, "every velocity gives the eigenset")

    def tilt(eta: float) -> float:
        return n / tan(n * eta) - 1.0 / tan(eta)

    return _bisected(tilt, math.pi / n, 2.0 * math.pi / n)


def _bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function falls through zero, to the last bit.

    It is positive just above ``low``, negative just below ``high``, and changes its sign once; it
    is not evaluated at the ends.
    """
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle
