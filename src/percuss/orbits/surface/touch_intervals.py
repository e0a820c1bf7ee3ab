"""When a mass may touch a stop without speed: where the force leads it away again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from percuss.kernels import law as at
from percuss.kernels.law import Law
from percuss.numerics import atan2, modulus, polynomial_roots
from percuss.numerics import cos as cos_of
from percuss.numerics import sin as sin_of

__all__ = ["touch_intervals"]

Floats = NDArray[np.float64]

# Roots of the polynomial this near to the unit circle are looked at.
NEAR = 1e-5
NEWTON_STEPS = 6


def touch_intervals(table: Law, constant: float, sign: float) -> list[tuple[float, float]]:
    """Return the open intervals of a period in which sign * (constant + harmonic force) > 0.

    The force is a trigonometric polynomial, its zeros are those of an algebraic one on the unit
    circle, refined by Newton's method.

    Parameters
    ----------
    table
        The law of an oscillator, with a period.
    constant
        The constant force.
    sign
        +1 or -1.

    Returns
    -------
    list of (float, float)
        Beginnings, in [0, period), and ends, up to one period later; (0, period) if it is
        positive all the time.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.model.law import law
    >>> touch_intervals(law(pc.impact_oscillator(), pc.sine(1.0)), 0.0, -1.0)
    [(3.141592653589793, 6.283185307179586)]
    """
    n, period = int(table[0, at.N_HARMONICS]), float(table[0, at.PERIOD])
    rows = table[at.FIRST_HARMONIC : at.FIRST_HARMONIC + n]
    omega, cos, sin = rows[:, at.OMEGA], rows[:, at.COSINE], rows[:, at.SINE]
    zeros = _zeros(omega, cos, sin, constant, period)
    if zeros.size == 0:
        return [(0.0, period)] if sign * (constant + cos.sum()) > 0.0 else []
    ends = np.append(zeros[1:], zeros[0] + period)
    middles = 0.5 * (zeros + ends)
    force = constant + (cos * cos_of(np.outer(middles, omega))).sum(axis=1)
    force += (sin * sin_of(np.outer(middles, omega))).sum(axis=1)
    found: list[tuple[float, float]] = []
    for first, last, value in zip(zeros.tolist(), ends.tolist(), force.tolist(), strict=True):
        if sign * value <= 0.0:
            continue
        if found and found[-1][1] == first:
            # A double zero between: a touch of no acceleration, one instant of an interval.
            found[-1] = (found[-1][0], last)
        else:
            found.append((first, last))
    return found


def _zeros(omega: Floats, cos: Floats, sin: Floats, constant: float, period: float) -> Floats:
    """Return the zeros of the force in [0, period), ascending; none where it is constant."""
    orders = np.rint(omega * period / (2.0 * np.pi)).astype(np.int64)
    most = int(orders.max(initial=0))
    if most == 0 or not (cos.any() or sin.any()):
        return np.empty(0)
    coefficients = np.zeros(2 * most + 1, dtype=np.complex128)
    coefficients[most] = constant
    for m, c, s in zip(orders, cos, sin, strict=True):
        coefficients[most - m] += 0.5 * complex(c, -s)
        coefficients[most + m] += 0.5 * complex(c, s)
    roots = polynomial_roots(coefficients)
    roots = roots[np.abs(modulus(roots) - 1.0) < NEAR]
    angles = atan2(roots.imag, roots.real)
    t = np.mod(angles / (2.0 * np.pi), 1.0) * period
    for _ in range(NEWTON_STEPS):
        phase = np.outer(t, omega)
        value = constant + (cos * cos_of(phase) + sin * sin_of(phase)).sum(axis=1)
        slope = (omega * (sin * cos_of(phase) - cos * sin_of(phase))).sum(axis=1)
        step = np.divide(value, slope, out=np.zeros_like(t), where=slope != 0.0)
        t = t - np.where(np.abs(step) < 1e-3 * period, step, 0.0)
    t = np.unique(np.mod(t, period))
    return t[np.diff(t, prepend=-1.0) > 1e-14 * period]
