"""The bilinear oscillator with its kink rounded, followed by Runge-Kutta steps."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.forcing import Forcing
from percuss.numerics import hypot
from percuss.paper.models.runge_kutta import Spring, harmonics_of, integrate

Rounding = Literal["parabola", "hyperbola"]

_ROUNDINGS = ("parabola", "hyperbola")


def rounded_magnitude(x: ArrayLike, radius: float, rounding: Rounding = "parabola") -> Floats:
    """Return |x| with its kink rounded.

    The bilinear force is k+ x above 0 and k- x below, in one term
    (k+ + k-) x / 2 - (k- - k+) |x| / 2; the smoothed law has this function in place of |x|.
    "parabola" is (x^2 + radius^2) / (2 radius) for |x| < radius and |x| beyond: once
    differentiable, of curvature 1 / radius. "hyperbola" is sqrt(x^2 + radius^2): infinitely often
    differentiable, with the same curvature at 0.

    Parameters
    ----------
    x
        Position, of any shape [length].
    radius
        Radius of the rounding [length], >= 0; 0 is the kink itself.
    rounding
        Which curve.

    Returns
    -------
    array
        At least |x|, and at most the radius more; of x's shape.

    Raises
    ------
    ParameterError
        If the radius is negative or not finite, or the rounding is unknown.

    Examples
    --------
    >>> rounded_magnitude([-2.0, 0.0, 0.5, 1.0], 1.0)
    array([2.   , 0.5  , 0.625, 1.   ])
    """
    _check(radius, rounding)
    place = np.asarray(x, dtype=np.float64)
    plain = np.abs(place)
    if radius == 0.0:
        return plain
    if rounding == "hyperbola":
        return np.asarray(hypot(place, radius))
    inside = plain < radius
    return np.where(inside, (place**2 + radius**2) / (2.0 * radius), plain)


def growth_rate(stiffness_above: float, stiffness_below: float) -> float:
    """Return the rate lambda of the bound |x - x_rounded| <= radius (e^(lambda t) - 1).

    lambda = |k- - k+| / (2 sqrt(2 (k- + k+))), from Gronwall's inequality
    (docs/theory/smoothed-law.md).

    Parameters
    ----------
    stiffness_above, stiffness_below
        k+ and k- [1/time^2], with a positive sum.

    Returns
    -------
    float
        lambda [1/time].

    Examples
    --------
    >>> growth_rate(1.0, 17.0)
    1.3333333333333333
    """
    difference = abs(stiffness_below - stiffness_above)
    return difference / (2.0 * math.sqrt(2.0 * (stiffness_below + stiffness_above)))


def smooth_motion(
    force: Forcing,
    t: ArrayLike,
    x0: float,
    v0: float,
    *,
    stiffness_below: float,
    radius: float,
    stiffness_above: float = 1.0,
    damping: float = 0.0,
    rounding: Rounding = "parabola",
    tolerance: float = 1e-14,
) -> tuple[Floats, Floats]:
    """Follow the oscillator with the smoothed law.

    x'' + 2 a x' + (k+ + k-) x / 2 - (k- - k+) m(x) / 2 = f(t), with m of `rounded_magnitude`.

    Parameters
    ----------
    force
        The forcing.
    t
        (n,) array, increasing times; the motion starts at the first [time].
    x0, v0
        Position [length] and velocity [length/time] at the start.
    stiffness_below, stiffness_above
        k- and k+ [1/time^2].
    radius
        Radius of the rounding [length], >= 0.
    damping
        a [1/time].
    rounding
        Which curve rounds the kink.
    tolerance
        Of a step, in units of length and of velocity (`runge_kutta.runge_kutta`).

    Returns
    -------
    tuple of array
        x [length] and v [length/time] at t, (n,) each.

    Raises
    ------
    ParameterError
        If the radius is negative or the rounding is unknown.

    Examples
    --------
    >>> import percuss as pc
    >>> t = [0.0, 1.0, 2.0]
    >>> x, v = smooth_motion(pc.cosine(2), t, 1.0, 0.0, stiffness_below=9.0, radius=1e-6)
    >>> exact = pc.simulate(pc.bilinear_oscillator(stiffness_below=9), pc.cosine(2), x0=1, t_end=2)
    >>> bool(abs(x - exact(t)[0]).max() < 1e-9)
    True
    """
    _check(radius, rounding)
    times = np.asarray(t, dtype=np.float64)
    spring = Spring(
        float(stiffness_above),
        float(stiffness_below),
        float(damping),
        float(radius),
        rounding == "hyperbola",
    )
    motion = np.empty((len(times), 2))
    motion[0] = x0, v0
    integrate(motion, times, spring, harmonics_of(force), tolerance)
    return motion[:, 0].copy(), motion[:, 1].copy()


def _check(radius: float, rounding: str) -> None:
    if not 0.0 <= radius < math.inf:
        raise ParameterError("radius", radius, "not a finite length >= 0")
    if rounding not in _ROUNDINGS:
        raise ParameterError("rounding", rounding, 'neither "parabola" nor "hyperbola"')
