"""Closed forms of motions on the eigenset under the force sin(n t).

The oscillator is `impact_oscillator()`: x'' + x = sin(n t), x > 0, elastic wall at 0
(Dyskin et al. 2012, eq. 17). Derivations: docs/theory/paper-harmonics.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_float, whole
from percuss.model.forcing import Forcing, sine
from percuss.motion.root import bisected
from percuss.numerics import cos, sin, tan

__all__ = ["HarmonicMotion", "harmonic_contact_time", "harmonic_critical_velocity"]


# A velocity given as a rounded decimal or a computed root may miss the bound by its rounding.
ROUNDING = 1e-12


def harmonic_contact_time(n: int) -> float:
    """Return when the motion with the critical velocity of an odd n first touches the wall.

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
        The time, in (pi, 2 pi); by symmetry another touch comes at 3 pi minus it.

    Raises
    ------
    ParameterError
        If n is no odd number of at least 3.

    Examples
    --------
    >>> harmonic_contact_time(3) / math.pi
    1.5
    """
    return math.pi + _touch(n)


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
    eta = _touch(n)
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
        _check_n(self.n)
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


def _touch(n: int) -> float:
    """Return where sin(n eta)/sin(eta) is lowest on (0, pi)."""
    _check_n(n)
    if n % 2 == 0:
        raise ParameterError("n", n, "even: every velocity gives the eigenset")

    def tilt(eta: float) -> float:
        return n / tan(n * eta) - 1.0 / tan(eta)

    return bisected(tilt, math.pi / n, 2.0 * math.pi / n)


def _check_n(n: object) -> None:
    whole("n", n, 2)
