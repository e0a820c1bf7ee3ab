"""The points of a saddle orbit in a section, and the directions of its manifolds there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.numerics import directions, matmul
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.surface.maps import impact_map, stroboscopic_map

__all__ = ["SaddlePoints", "check_saddle", "points_at_impacts", "points_at_strobes"]

Floats = NDArray[np.float64]

# Multipliers this near to the unit circle, as a part of 1, leave no saddle.
HYPERBOLIC = 1e-6
# An impact this near to the instant of a section, as a part of a period, is at it.
AT_SECTION = 1e-6
# Points of an orbit whose ranges are its size.
SAMPLES = 257


@dataclass(frozen=True, slots=True)
class SaddlePoints:
    """The points of a saddle orbit in a section.

    Attributes
    ----------
    points
        (m, 2) array, in their order along the orbit.
    jacobians
        (m, 2, 2) array, derivative over one turn of the orbit at each.
    scale
        (2,) array, units in which lengths are measured.
    """

    points: Floats
    jacobians: Floats
    scale: Floats

    def directions(self, multiplier: float) -> Floats:
        """Return the (m, 2) eigenvectors of a multiplier, of length 1 in the units of the scale."""
        found = np.empty_like(self.points)
        for i, matrix in enumerate(self.jacobians):
            scaled = matrix * self.scale / self.scale[:, None]
            vector = directions(scaled - multiplier * np.eye(2))[1][-1]
            # Pointing to greater x or cycle, or upwards.
            first = vector[0] if abs(vector[0]) > 1e-12 else vector[1]
            found[i] = math.copysign(1.0, first) * vector * self.scale
        return found


def check_saddle(orbit: PeriodicOrbit) -> None:
    """Raise a ParameterError if an orbit is no saddle that motions follow."""
    if orbit.forcing is None or orbit.forcing.period is None:
        reason = "a section needs a periodic forcing"
        raise ParameterError("forcing.period", None, reason)
    if not orbit.admissible:
        reason = "it passes through a stop: no motion follows it"
        raise ParameterError("orbit", orbit, reason)
    large, small = (complex(value) for value in orbit.multipliers)
    if small == 0.0:
        reason = (
            "a multiplier is 0: a contact, or an impact with restitution 0, forgets the past, "
            "and there is no map back in time to grow a stable manifold with"
        )
        raise ParameterError("orbit", orbit, reason)
    is_saddle = large.imag == 0.0 and abs(large) > 1.0 + HYPERBOLIC and abs(small) < 1.0 - HYPERBOLIC  # fmt: skip
    if not is_saddle:
        reason = f"no saddle: its multipliers have moduli {abs(large):.6g} and {abs(small):.6g}"
        raise ParameterError("orbit", orbit, reason)


def points_at_strobes(orbit: PeriodicOrbit, cycle: float) -> SaddlePoints:
    """Return the points of an orbit in the plane (x, v) at a cycle.

    Parameters
    ----------
    orbit
        A saddle.
    cycle
        The cycle, in [0, 1).

    Returns
    -------
    SaddlePoints
        One point a forcing period; the scale is the range of x and of v on the orbit.

    Raises
    ------
    ParameterError
        If the orbit meets a stop at that very cycle.
    """
    assert orbit.forcing is not None
    assert orbit.forcing.period is not None
    period = orbit.forcing.period
    away = (orbit.impacts.cycle - cycle + 0.5) % 1.0 - 0.5
    if away.size and np.abs(away).min() < AT_SECTION:
        raise ParameterError("cycle", cycle, "the orbit has an impact at it; choose another one")
    run = orbit.trajectory(2)
    first = math.ceil(run.t0 / period - cycle) + cycle
    t = (first + np.arange(orbit.n_periods)) * period
    points = np.stack(run(t), axis=1)
    step = stroboscopic_map(orbit.oscillator, orbit.forcing, cycle=cycle)
    x, v = run(np.linspace(run.t0, run.t0 + orbit.period, SAMPLES))
    scale = np.array([np.ptp(x) or 1.0, np.ptp(v) or 1.0])
    return SaddlePoints(points, _turns(step.jacobian(*points.T)), scale)


def points_at_impacts(orbit: PeriodicOrbit, stop: int | None) -> SaddlePoints:
    """Return the points of an orbit in the impact surface of a stop.

    Parameters
    ----------
    orbit
        A saddle.
    stop
        Index of the stop.

    Returns
    -------
    SaddlePoints
        One point an impact on it; the scale is a cycle and the largest impact velocity.

    Raises
    ------
    ParameterError
        If the orbit does not meet the stop.
    """
    assert orbit.forcing is not None
    on_it = orbit.impacts.stop == stop
    if not on_it.any():
        raise ParameterError("stop", stop, "the orbit does not meet it")
    points = np.stack([orbit.impacts.cycle[on_it], orbit.impacts.v_after[on_it]], axis=1)
    step = impact_map(orbit.oscillator, orbit.forcing, int(stop or 0))
    scale = np.array([1.0, float(np.abs(orbit.impacts.v_after[on_it]).max())])
    return SaddlePoints(points, _turns(step.jacobian(*points.T)), scale)


def _turns(steps: Floats) -> Floats:
    """Return the product of all steps that begins with each of them."""
    found = []
    for i in range(len(steps)):
        turn = np.eye(2)
        for step in np.roll(steps, -i, axis=0):
            turn = matmul(step, turn)
        found.append(turn)
    return np.array(found)
