"""The paper's own integrator: fourth-order Runge-Kutta with adaptive step, on the bilinear law."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.kernels.compile import kernel

__all__ = ["POINTS", "SteppedMotion", "runge_kutta"]

Floats = NDArray[np.float64]

# Of the paper, over the whole interval.
POINTS = 2**20
# Steps no shorter than this are tried: below, t + h is t.
SHORTEST = 1e-13


@dataclass(frozen=True)
class SteppedMotion:
    """A motion at equally spaced times, from steps.

    Attributes
    ----------
    t, x, v
        (n + 1,) arrays: time, position and velocity.
    n_steps
        How many steps were tried.
    """

    t: Floats
    x: Floats
    v: Floats
    n_steps: int


def runge_kutta(
    stiffness_below: float,
    omega: float,
    phase: float,
    *,
    v0: float,
    t_end: float,
    tolerance: float,
    n_points: int = POINTS,
) -> SteppedMotion:
    """Integrate x'' + k(x) x = cos(omega t + phase) from x = 0 by steps.

    Classical Runge-Kutta steps of fourth order; each is compared with two half steps, and
    halves its length until they agree. The paper names neither its error test nor its tolerance:
    here the larger absolute difference of x and v must not exceed `tolerance`, and the step
    starts anew from each of the points.

    Parameters
    ----------
    stiffness_below
        k(x) for x < 0; above it is 1 [1/time^2].
    omega, phase
        Angular frequency [1/time] and phase [rad] of the force, whose amplitude is 1.
    v0
        Velocity at t = 0 [length/time].
    t_end
        Time of the end [time].
    tolerance
        Of each step; 0 takes one plain step from point to point.
    n_points
        Number of intervals between points.

    Returns
    -------
    SteppedMotion
        The motion at the points.

    Examples
    --------
    Free motion above the stop:

    >>> motion = runge_kutta(
    ...     4e8, 2.0, 0.5 * math.pi, v0=1.0, t_end=1.0, tolerance=1e-6, n_points=100
    ... )
    >>> exact = math.sin(1.0) * (1 - 2 / 3) + math.sin(2.0) / 3  # x'' + x = -sin 2t
    >>> abs(motion.x[-1] - exact) < 1e-9
    np.True_
    """
    motion = np.zeros((n_points + 1, 2))
    motion[0, 1] = v0
    n_steps = _integrate(motion, t_end / n_points, stiffness_below, omega, phase, tolerance)
    t = np.linspace(0.0, t_end, n_points + 1)
    return SteppedMotion(t, motion[:, 0].copy(), motion[:, 1].copy(), int(n_steps))


@kernel
def _acceleration(t: float, x: float, below: float, omega: float, phase: float) -> float:
    return math.cos(omega * t + phase) - (x if x >= 0.0 else below * x)


@kernel
def _step(
    t: float, x: float, v: float, h: float, below: float, omega: float, phase: float
) -> tuple[float, float]:
    """Take one classical step."""
    a1 = _acceleration(t, x, below, omega, phase)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(t + 0.5 * h, x + 0.5 * h * v, below, omega, phase)
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(t + 0.5 * h, x + 0.5 * h * v2, below, omega, phase)
    v4 = v + h * a3
    a4 = _acceleration(t + h, x + h * v3, below, omega, phase)
    return (
        x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4),
        v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
    )


@kernel
def _integrate(
    motion: Floats, spacing: float, below: float, omega: float, phase: float, tolerance: float
) -> int:
    """Fill the points, and return how many steps were tried."""
    tried = 0
    x, v = motion[0, 0], motion[0, 1]
    for i in range(len(motion) - 1):
        done, h = 0.0, spacing
        while done < spacing:
            t = i * spacing + done
            last = done + h >= spacing * (1.0 - 1e-12)
            if last:
                h = spacing - done
            tried += 1
            whole_x, whole_v = _step(t, x, v, h, below, omega, phase)
            if tolerance == 0.0:
                x, v = whole_x, whole_v
                break
            half_x, half_v = _step(t, x, v, 0.5 * h, below, omega, phase)
            two_x, two_v = _step(t + 0.5 * h, half_x, half_v, 0.5 * h, below, omega, phase)
            error = max(abs(two_x - whole_x), abs(two_v - whole_v))
            if error > tolerance and h > SHORTEST:
                h *= 0.5
                continue
            x, v = two_x, two_v
            done = spacing if last else done + h
            if error < 0.02 * tolerance:
                h *= 2.0
        motion[i + 1, 0], motion[i + 1, 1] = x, v
    return tried
