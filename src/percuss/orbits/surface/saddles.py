"""Saddles of the maps, and the sections in which their manifolds lie."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.kernels import backward as engine
from percuss.kernels import law_columns as at
from percuss.kernels.restitution import speed_before
from percuss.model.exact import as_float
from percuss.model.oscillator import Wall
from percuss.model.periods import require_period
from percuss.model.system import System
from percuss.numerics import directions, matmul
from percuss.orbits.orbit.itinerary import entry
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.surface.backward import BackwardMotions
from percuss.orbits.surface.maps import ImpactMap, StroboscopicMap, impact_map, stroboscopic_map

# Multipliers this near the unit circle make no saddle.
HYPERBOLIC = 1e-6
# An impact this near the instant of a section, as a part of a period, is at it.
AT_SECTION = 1e-6
# Points of an orbit that show how far and how fast it is.
SAMPLES = 257


@dataclass(frozen=True, slots=True)
class SaddlePoints:
    """The points of a saddle orbit in a section.

    Attributes
    ----------
    points
        (m, 2) array, in their order along the orbit.
    jacobians
        (m, 2, 2) array, derivative over one period of the orbit at each.
    scale
        (2,) array, units in which lengths are measured.
    """

    points: Floats
    jacobians: Floats
    scale: Floats

    def directions(self, multiplier: float) -> Floats:
        """Return the (m, 2) eigenvectors of a multiplier, of length 1 in the units of the scale."""
        vectors = np.empty_like(self.points)
        for i, matrix in enumerate(self.jacobians):
            scaled = matrix * self.scale / self.scale[:, None]
            vector = directions(scaled - multiplier * np.eye(2))[1][-1]
            # The sign is that of growing x or cycle, else of growing v.
            first = vector[0] if abs(vector[0]) > 1e-12 else vector[1]
            vectors[i] = math.copysign(1.0, first) * vector * self.scale
        return vectors


def check_saddle(orbit: PeriodicOrbit) -> None:
    """Raise a ParameterError if an orbit is no saddle that motions follow."""
    if not isinstance(orbit, PeriodicOrbit):
        raise ParameterError("orbit", orbit, "not a periodic orbit; find_orbit() finds one")
    require_period(orbit.forcing, "a section needs a periodic forcing")
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
    hyperbolic = abs(large) > 1.0 + HYPERBOLIC and abs(small) < 1.0 - HYPERBOLIC
    if large.imag != 0.0 or not hyperbolic:
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
    distances = (orbit.impacts.cycle - cycle + 0.5) % 1.0 - 0.5
    if distances.size and np.abs(distances).min() < AT_SECTION:
        raise ParameterError("cycle", cycle, "the orbit has an impact at it; choose another one")
    run = orbit.trajectory(2)
    first = math.ceil(run.t0 / period - cycle) + cycle
    t = (first + np.arange(orbit.n_periods)) * period
    points = np.stack(run(t), axis=1)
    step = stroboscopic_map(orbit.oscillator, orbit.forcing, cycle=cycle)
    x, v = run(np.linspace(run.t0, run.t0 + orbit.period, SAMPLES))
    scale = np.array([np.ptp(x) or 1.0, np.ptp(v) or 1.0])
    return SaddlePoints(points, _over_period(step.jacobian(*points.T)), scale)


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
    return SaddlePoints(points, _over_period(step.jacobian(*points.T)), scale)


def _over_period(steps: Floats) -> Floats:
    """Return the product of all steps that begins with each of them."""
    products = []
    for i in range(len(steps)):
        product = np.eye(2)
        for step in np.roll(steps, -i, axis=0):
            product = matmul(step, product)
        products.append(product)
    return np.array(products)


SectionKind: TypeAlias = Literal["stroboscopic", "impact"]

# Forcing periods in which the preceding impact is searched for.
LONGEST = 100.0


def images_of(
    points: Floats, step: Callable[[Floats], Iterable[Floats]], allowed: Flags | bool = True
) -> Floats:
    """Return the images of (n, 2) points under a map; NaN for NaN and where it is not allowed."""
    known = np.isfinite(points).all(axis=1) & allowed
    images = np.full_like(points, np.nan)
    images[known] = np.stack(list(step(points[known])), axis=1)
    return images


@dataclass(frozen=True, slots=True)
class StroboscopicSection:
    """The plane (x, v) at one cycle, and the maps over one forcing period.

    Motions beyond the velocity ``fastest`` [length/time] are not followed back.
    """

    map: StroboscopicMap
    fastest: float

    def forward(self, points: Floats) -> Floats:
        """Return (n, 2) points one period later; NaN for NaN."""
        return images_of(points, lambda some: self.map(*self._inside(some)))

    def backward(self, points: Floats) -> Floats:
        """Return (n, 2) points one period earlier; NaN where there was no such motion."""
        motions = BackwardMotions(System(self.map.oscillator, self.map.forcing))
        period = float(motions.law[0, at.PERIOD])

        def step(some: Floats) -> Iterator[Floats]:
            x, v = self._inside(some)
            t = np.full(len(x), (1.0 + self.map.cycle) * period)
            past = motions.follow(t, x, v, period, fastest=self.fastest)
            ends = self._inside(np.stack([past.x_end, past.v_end], axis=1))
            return (np.where(past.status == engine.AT_TIME, end, np.nan) for end in ends)

        return images_of(points, step)

    def differences(self, first: Floats, second: Floats) -> Floats:
        """Return the differences between points."""
        return second - first

    def _inside(self, points: Floats) -> tuple[Floats, Floats]:
        """Return x and v of points, moved out of walls that rounding put them in."""
        x = points[:, 0]
        for stop in self.map.oscillator.stops:
            if isinstance(stop, Wall):
                wall = as_float(stop.at)
                x = np.maximum(x, wall) if stop.side == "below" else np.minimum(x, wall)
        return x, points[:, 1]


@dataclass(frozen=True, slots=True)
class ImpactSection:
    """The impact surface (cycle, v_after) of a stop, and the maps to the next impact on it."""

    map: ImpactMap
    fastest: float

    def forward(self, points: Floats) -> Floats:
        """Return (n, 2) points at the next impact; NaN where there is none, or after a contact."""
        return images_of(points, lambda some: self.map(*some.T), points[:, 1] != 0.0)

    def backward(self, points: Floats) -> Floats:
        """Return (n, 2) points at the impact before; NaN where there was none."""
        known = np.isfinite(points).all(axis=1)
        images = np.full_like(points, np.nan)
        osc, number = self.map.oscillator, self.map.stop
        stop, entered = osc.stops[number], entry(osc, number)
        motions = BackwardMotions(System(osc, self.map.forcing))
        before = points[known, 1].copy()
        if isinstance(stop, Wall):
            row = motions.row(entered.before)
            for i, v in enumerate(before):
                speed = speed_before(motions.law, row, entered.bound, abs(v))
                if speed == math.inf:
                    return images
                before[i] = -math.copysign(speed, v)
        period = float(motions.law[0, at.PERIOD])
        past = motions.follow(
            points[known, 0] * period,
            as_float(stop.at),
            before,
            LONGEST * period,
            region=motions.row(entered.before),
            bound=entered.bound,
            sign=entered.sign,
            fastest=self.fastest,
        )
        images[known] = np.stack([past.t[:, 0] / period % 1.0, past.v[:, 0]], axis=1)
        return images

    def differences(self, first: Floats, second: Floats) -> Floats:
        """Return the differences between points, less whole cycles."""
        differences = second - first
        differences[:, 0] = (differences[:, 0] + 0.5) % 1.0 - 0.5
        return np.asarray(differences)


Section: TypeAlias = StroboscopicSection | ImpactSection
