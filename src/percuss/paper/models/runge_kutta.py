"""The paper's own integrator: fourth-order Runge-Kutta with adaptive step.

It follows the bilinear law, and the law with its kink rounded, which has no closed form. Its
results are the same bits on every machine, unlike those of a library that calls BLAS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.kernels.arithmetic import cos_sin
from percuss.kernels.compile import kernel
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import cosine
from percuss.model.system import turns_per_time

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
    Free motion above the wall:

    >>> motion = runge_kutta(
    ...     4e8, 2.0, 0.5 * math.pi, v0=1.0, t_end=1.0, tolerance=1e-6, n_points=100
    ... )
    >>> exact = math.sin(1.0) * (1 - 2 / 3) + math.sin(2.0) / 3  # x'' + x = -sin 2t
    >>> abs(motion.x[-1] - exact) < 1e-9
    np.True_
    """
    motion = np.zeros((n_points + 1, 2))
    motion[0, 1] = v0
    t = np.linspace(0.0, t_end, n_points + 1)
    force = harmonics_of(cosine(omega, phase=phase))
    n_steps = integrate(motion, t, Spring(1.0, stiffness_below), force, tolerance)
    return SteppedMotion(t, motion[:, 0].copy(), motion[:, 1].copy(), int(n_steps))


class Spring(NamedTuple):
    """The force of the springs and of the dashpot, as the kernel takes it.

    Attributes
    ----------
    above, below
        Stiffness for x > 0 and for x < 0 [1/time^2].
    damping
        a of the term 2 a x' [1/time].
    radius
        Of the rounding of the kink at x = 0 [length]; 0 is the kink itself.
    is_hyperbola
        Whether the rounding is the hyperbola, else the parabola (`smooth_law.rounded_magnitude`).
    """

    above: float
    below: float
    damping: float = 0.0
    radius: float = 0.0
    is_hyperbola: bool = False


def harmonics_of(force: Forcing) -> Floats:
    """Return the harmonics of a forcing as the kernel takes them.

    Returns
    -------
    array
        (n, 4): the turns per time in two parts, the coefficients of the cosine and of the sine;
        a constant is a harmonic without turns.

    Examples
    --------
    >>> import percuss as pc
    >>> harmonics_of(pc.Forcing(constant=2.0))
    array([[0., 0., 2., 0.]])
    """
    rows = [(0.0, 0.0, as_float(force.constant), 0.0)] if force.constant else []
    rows += [(*turns_per_time(part.omega, 2), part.cos, part.sin) for part in force.components()]
    return np.array(rows, dtype=np.float64).reshape(-1, 4)


@kernel
def _acceleration(spring: Spring, harmonics: Floats, t: float, x: float, v: float) -> float:
    push = 0.0
    for i in range(len(harmonics)):
        cosine, sine = cos_sin(harmonics[i, 0], harmonics[i, 1], t, 0.0)
        push += harmonics[i, 2] * cosine + harmonics[i, 3] * sine
    radius = spring.radius
    if radius == 0.0 or (abs(x) >= radius and not spring.is_hyperbola):
        return (
            push - (spring.above * x if x >= 0.0 else spring.below * x) - 2.0 * spring.damping * v
        )
    square = x * x + radius * radius
    magnitude = math.sqrt(square) if spring.is_hyperbola else square / (2.0 * radius)
    mean, half = 0.5 * (spring.above + spring.below), 0.5 * (spring.below - spring.above)
    return push - (mean * x - half * magnitude) - 2.0 * spring.damping * v


@kernel
def _step(
    spring: Spring, harmonics: Floats, t: float, x: float, v: float, h: float
) -> tuple[float, float]:
    """Take one classical step."""
    a1 = _acceleration(spring, harmonics, t, x, v)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(spring, harmonics, t + 0.5 * h, x + 0.5 * h * v, v2)
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(spring, harmonics, t + 0.5 * h, x + 0.5 * h * v2, v3)
    v4 = v + h * a3
    a4 = _acceleration(spring, harmonics, t + h, x + h * v3, v4)
    return (
        x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4),
        v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
    )


@kernel
def integrate(
    motion: Floats, t: Floats, spring: Spring, harmonics: Floats, tolerance: float
) -> int:
    """Integrate from point to point, and return how many steps were tried.

    Parameters
    ----------
    motion
        (n, 2) array of x and v: the first row is the start, the others are filled.
    t
        (n,) increasing times of the points.
    spring
        The force of the springs.
    harmonics
        Of `harmonics_of`.
    tolerance
        As in `runge_kutta`.
    """
    tried = 0
    x, v = motion[0, 0], motion[0, 1]
    for i in range(len(motion) - 1):
        spacing = t[i + 1] - t[i]
        done, h = 0.0, spacing
        while done < spacing:
            now = t[i] + done
            last = done + h >= spacing * (1.0 - 1e-12)
            if last:
                h = spacing - done
            tried += 1
            whole_x, whole_v = _step(spring, harmonics, now, x, v, h)
            if tolerance == 0.0:
                x, v = whole_x, whole_v
                break
            half_x, half_v = _step(spring, harmonics, now, x, v, 0.5 * h)
            two_x, two_v = _step(spring, harmonics, now + 0.5 * h, half_x, half_v, 0.5 * h)
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
