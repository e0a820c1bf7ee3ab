"""The half-harmonic resonance of the elastic impact oscillator, x'' + x = sin t or cos t for x > 0.

Time is in units of the reciprocal natural frequency, the force has amplitude 1. The derivations
are in docs/theory/half-harmonic.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.simulate import simulate
from percuss.numerics import atan2, cos, sin


def half_harmonic_flight(
    elapsed: ArrayLike, t_k: ArrayLike, v_k: ArrayLike
) -> tuple[Floats, Floats]:
    """Return the motion under sin t after an impact, in closed form.

    x = v_k sin s + (s/2) sin t_k sin s + (1/2) cos t_k (sin s - s cos s) with s = t - t_k; it
    holds up to the next impact, where tan s = s cos t_k / (2 v_k + cos t_k + s sin t_k). The
    equation printed as (29) by Dyskin et al. 2012 lacks the last term.

    Parameters
    ----------
    elapsed
        Time s since the impact [time].
    t_k
        Time of the impact [time].
    v_k
        Velocity just after it [length/time], >= 0.

    Returns
    -------
    tuple of arrays
        Position [length] and velocity [length/time].

    Examples
    --------
    >>> x, v = half_harmonic_flight(math.pi, 0.0, 1.0)
    >>> round(float(x), 12), round(float(v), 12)
    (1.570796326795, -1.0)
    """
    s, t, v = (np.asarray(value, dtype=np.float64) for value in (elapsed, t_k, v_k))
    sin_s, cos_s = sin(s), cos(s)
    x = (v + 0.5 * s * sin(t)) * sin_s + 0.5 * cos(t) * (sin_s - s * cos_s)
    speed = v * cos_s + 0.5 * sin(t) * (sin_s + s * cos_s) + 0.5 * cos(t) * s * sin_s
    return x, speed


def half_harmonic_impact(t_k: float, v_k: float) -> tuple[float, float]:
    """Return the next impact under sin t: its time, and the velocity just after it.

    The first root of the flight, with the proof of `simulate` that none came before it.

    Parameters
    ----------
    t_k
        Time of the impact before [time].
    v_k
        Velocity just after it [length/time], > 0.

    Returns
    -------
    tuple
        Time [time] and velocity [length/time].

    Raises
    ------
    ParameterError
        If v_k is not positive: a mass at rest on the stop may stay there.

    Examples
    --------
    On the eigenset, cos t_k = 0, the velocity changes by pi/2 a half-period:

    >>> t, v = half_harmonic_impact(math.pi / 2, 1.0)
    >>> abs(t - 1.5 * math.pi) < 1e-12, abs(v - 1.0 - math.pi / 2) < 1e-12
    (True, True)
    """
    if not v_k > 0.0:
        raise ParameterError("v_k", v_k, "not positive; `simulate` follows a start at rest")
    run = simulate(impact_oscillator(), sine(1), v0=v_k, t0=t_k, max_impacts=1)
    return float(run.impacts.t[0]), float(run.impacts.v_after[0])


def half_harmonic_expansion(t_k: ArrayLike, v_k: ArrayLike) -> tuple[Floats, Floats]:
    """Return the next impact under sin t for a large velocity.

    t_{k+1} = t_k + pi + (pi/2) c/V - (pi^2/4) s c/V^2 + O(V^-3) and
    V_{k+1} = V + (pi/2) s + (pi/2) (s + (pi/4) c) c/V + O(V^-2), with s = sin t_k, c = cos t_k.
    It replaces (31) and (32) of Dyskin et al. 2012.

    Parameters
    ----------
    t_k
        Time of an impact [time].
    v_k
        Velocity just after it [length/time], large beside 1.

    Returns
    -------
    tuple of arrays
        Time [time] and velocity [length/time] of the next impact.

    Examples
    --------
    >>> t, v = half_harmonic_expansion(1.0, 1e4)
    >>> exact_t, exact_v = half_harmonic_impact(1.0, 1e4)
    >>> bool(abs(t - exact_t) < 1e-10), bool(abs(v - exact_v) < 1e-7)
    (True, True)
    """
    t, v = np.asarray(t_k, dtype=np.float64), np.asarray(v_k, dtype=np.float64)
    s, c = sin(t), cos(t)
    excess = 0.5 * math.pi * c / v * (1.0 - 0.5 * math.pi * s / v)
    gain = 0.5 * math.pi * (s + (s + 0.25 * math.pi * c) * c / v)
    return t + math.pi + excess, v + gain


def half_harmonic_two_impacts(t_k: ArrayLike, v_k: ArrayLike) -> Floats:
    """Return the velocity two impacts on, under sin t, for a large velocity.

    V_{k+2} = V_k + (pi/2) sin(2 t_k) / V_k + O(V_k^-2), in place of (33) of Dyskin et al. 2012.
    The phase t_k modulo pi is the same two impacts on, but for O(V_k^-3). Time and velocity are
    those of `half_harmonic_expansion`.

    Examples
    --------
    >>> float(half_harmonic_two_impacts(math.pi / 4, 100.0))
    100.01570796326794
    """
    t, v = np.asarray(t_k, dtype=np.float64), np.asarray(v_k, dtype=np.float64)
    return np.asarray(v + 0.5 * math.pi * sin(2.0 * t) / v)


def half_harmonic_invariant(t_k: ArrayLike, v_k: ArrayLike) -> Floats:
    """Return the quantity that impacts under sin t leave unchanged, up to 3 V^-7.

    The error was measured from V = 5 on. Up to V^-4 the invariant is the mean over one flight of
    cos 2 theta, where theta is the direction of the vector v_k (cos t_k, sin t_k) + (0, s/2), which
    the secular terms of the flight draw; for large velocities it tends to cos 2 psi, psi the limit
    of the phase t_k modulo pi. Below V = 1.5 it is hardly constant. See
    docs/theory/half-harmonic.md.

    Parameters
    ----------
    t_k
        Time of an impact [time].
    v_k
        Velocity just after it [length/time], > 0.

    Returns
    -------
    array
        The invariant, in [-1, 1] for all but the smallest velocities.

    Examples
    --------
    >>> before = half_harmonic_invariant(1.0, 20.0)
    >>> after = half_harmonic_invariant(*half_harmonic_impact(1.0, 20.0))
    >>> bool(abs(after - before) < 3 / 20.0**7)
    True
    """
    t, v = np.asarray(t_k, dtype=np.float64), np.asarray(v_k, dtype=np.float64)
    s, c = sin(t), cos(t)
    across, along = np.abs(v * c), v * s
    turned = atan2(0.5 * math.pi * across, across * across + along * (along + 0.5 * math.pi))
    square, fourth = s * s, c * c * (c * c)
    ratio = math.pi / v
    fifth = ratio * ratio * ratio / 16.0 * s * square * fourth / (v * v)
    sixth = 13.0 * (ratio * ratio) * (ratio * ratio) / 288.0 * square * fourth
    sixth *= (1.0 - 4.0 * square) / (v * v)
    return np.asarray(4.0 * across / math.pi * turned - 1.0 + fifth + sixth)


@dataclass(frozen=True, slots=True)
class HalfHarmonicGrowth:
    """The law by which impact velocities grow: W^2 = constant^2 t + logarithm ln t + O(1).

    W is the velocity freed of the alternation between one impact and the next, which is
    (pi/4) |sin phase| up and down.

    Attributes
    ----------
    phase
        Limit of the impact times modulo pi, in (-pi/2, pi/2] [rad].
    rate
        Growth of W^2 [(length/time)^2/time], sin(2 phase) / 2; negative where velocities fall.
    logarithm
        Factor of ln t in W^2 [(length/time)^2].
    """

    phase: float
    rate: float
    logarithm: float

    @property
    def constant(self) -> float:
        """The factor b of the envelope b sqrt(t), at most 1/sqrt(2); NaN where velocities fall."""
        return math.sqrt(self.rate) if self.rate >= 0.0 else math.nan


def half_harmonic_growth(t_k: float, v_k: float) -> HalfHarmonicGrowth:
    """Return the law of growth that an impact under sin t leads to.

    The phase psi of the impacts tends to a limit that the start decides, and neither attracts nor
    repels; b = sqrt(sin(2 psi) / 2) for the velocity and the displacement, where cos 2 psi is
    `half_harmonic_invariant`. In closed form for a start at t = 0 with a large velocity V0:
    b = sqrt(pi / (2 sqrt(3) V0)) (1 + O(V0^-2)). See docs/theory/half-harmonic.md.

    Parameters
    ----------
    t_k
        Time of an impact [time].
    v_k
        Velocity just after it [length/time]; the error of the rate is of order v_k^-7.

    Returns
    -------
    HalfHarmonicGrowth
        Phase, rate and logarithmic correction; the latter without limit as sin(2 psi) tends to 0.

    Raises
    ------
    ParameterError
        If v_k is too small for the expansion.

    Examples
    --------
    >>> round(half_harmonic_growth(0.0, 100.0).constant, 8)
    0.0952258
    >>> round(half_harmonic_growth(math.pi / 4, 1e6).constant, 8)  # the largest is 1/sqrt(2)
    0.70710678
    """
    invariant = float(half_harmonic_invariant(t_k, v_k)) if v_k > 0.0 else math.nan
    if not abs(invariant) <= 1.0:
        raise ParameterError("v_k", v_k, "too small: the expansion for large velocities fails")
    middle = v_k * cos(t_k) * (v_k * sin(t_k) + 0.25 * math.pi)
    sin_2 = math.copysign(math.sqrt((1.0 - invariant) * (1.0 + invariant)), middle)
    logarithm = math.nan
    if sin_2 != 0.0:
        ratio = (1.0 + 3.0 * invariant - 2.0 * invariant * invariant * invariant) / (sin_2 * sin_2)
        logarithm = -(math.pi * math.pi) / 48.0 * ratio
    return HalfHarmonicGrowth(0.5 * atan2(sin_2, invariant), 0.5 * sin_2, logarithm)


def cosine_eigenset_motion(t: ArrayLike, v0: float) -> tuple[Floats, Floats]:
    """Return the motion under cos t from the stop at t = 0, x'' + x = cos t.

    x = (v0 + s/2) sin s on [2 pi j, 2 pi j + pi] and (v0 + (pi - s)/2) sin s on the half-period
    after it, s counted from the last multiple of pi (Dyskin et al. 2012, eq. 38). For v0 = 0 the
    mass reaches the stop at 2 pi j with no speed: impacts are at the odd multiples of pi only.
    The velocity returned at an impact is that after it; a negative v0 is a ParameterError.

    Examples
    --------
    >>> x, v = cosine_eigenset_motion([0.0, math.pi / 2, math.pi], 0.0)
    >>> x / math.pi, v / math.pi
    (array([0.  , 0.25, 0.  ]), array([0.        , 0.15915494, 0.5       ]))
    """
    if not v0 >= 0.0:
        raise ParameterError("v0", v0, "negative")
    times = np.asarray(t, dtype=np.float64)
    count = np.floor(times / math.pi)
    s = times - math.pi * count
    sign = 1.0 - 2.0 * np.mod(count, 2.0)
    factor = v0 + 0.5 * np.where(sign > 0.0, s, math.pi - s)
    return factor * sin(s), factor * cos(s) + 0.5 * sign * sin(s)
