"""Homoclinic orbits of saddles in the impact surface."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import whole
from percuss.model.force_record import refuse_record
from percuss.numerics import hypot, inverse, matmul, power
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.surface.maps import ImpactMap, impact_map
from percuss.orbits.surface.saddles import check_saddle, images_of, points_at_impacts

# Points of the fundamental domain of an unstable manifold that are followed.
SAMPLES = 800
# Where it ends, in units of a cycle and of the orbit's largest velocity: the curvature of the
# manifold moves it by the square of this.
END = 1e-4
# Within this distance of the saddle, in the same units, its stable manifold is nearly straight.
NEAR = 0.15
# Halvings of a part of the domain: as many as a float has bits.
HALVINGS = 60
# Impacts after a motion has come near the saddle, in which it leaves it on one side.
LEAVES = 60
# Neighbouring motions that come back this near each other, in the same units, enclose a crossing.
RESOLVED = 1e-6


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class HomoclinicOrbit:
    """A motion that leaves a saddle orbit and comes back to it; of `homoclinic_orbits`.

    Attributes
    ----------
    orbit
        The saddle.
    stop
        Index of the stop of the impact surface.
    points
        (n, 2) array, (cycle, v_after) of its impacts on the stop, from next to the saddle to next
        to it; before and after these it follows the saddle's manifolds. How many they are hangs on
        roundings: it ends where these begin to carry it away.
    coordinates
        (n, 2) array, distances of the points from the saddle along its unstable and its stable
        direction, in units of a cycle and of the orbit's largest velocity.
    """

    orbit: PeriodicOrbit
    stop: int
    points: Floats
    coordinates: Floats = field(repr=False)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        """Return the orbit in a line."""
        far = float(hypot(self.coordinates[:, 0], self.coordinates[:, 1]).max())
        return f"<HomoclinicOrbit: {len(self)} impacts on stop {self.stop}, up to {far:.3g} away>"


def homoclinic_orbits(
    orbit: PeriodicOrbit,
    *,
    stop: int | None = None,
    most_orbits: int = 4,
    most_impacts: int = 30,
) -> tuple[HomoclinicOrbit, ...]:
    """Find homoclinic orbits of a saddle: motions that leave it and come back to it.

    A fundamental domain of the unstable manifold is followed forward. Where the images of two of
    its neighbouring points lie on different sides of the stable manifold next to the saddle, the
    manifolds cross in between; the crossing is found by halving, by the side on which a motion
    leaves the saddle again.

    Parameters
    ----------
    orbit
        A saddle with one impact on the stop: one multiplier outside and one inside the unit circle,
        neither 0.
    stop
        Index of the stop; default: that of the orbit's first impact.
    most_orbits
        Orbits after which no more are sought, >= 1.
    most_impacts
        Impacts in which a motion has to come back, >= 1.

    Returns
    -------
    tuple of HomoclinicOrbit
        In the order of the impacts that they need; none where none was found, which does not prove
        that there is none.

    Raises
    ------
    ParameterError
        If the orbit is no saddle, or not physical, or meets the stop never or more than once; under
        a record.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8"))
    >>> (found,) = homoclinic_orbits(orbit, most_orbits=1)
    >>> float(abs(found.coordinates).max().round(3))
    0.737
    """
    check_saddle(orbit)
    refuse_record(orbit.forcing, "a homoclinic orbit", "it is sought under harmonics alone")
    most_orbits = whole("most_orbits", most_orbits, 1)
    most_impacts = whole("most_impacts", most_impacts, 1)
    if stop is None:
        if not len(orbit.impacts):
            raise ParameterError("orbit", orbit, "meets no stop")
        stop = int(orbit.impacts.stop[0])
    saddles = points_at_impacts(orbit, stop)
    if len(saddles.points) != 1:
        reason = (
            f"{len(saddles.points)} impacts on stop {stop}; homoclinic orbits are sought of one"
        )
        raise ParameterError("orbit", orbit, reason)
    assert orbit.forcing is not None
    values = orbit.multipliers.real
    axes = np.stack([saddles.directions(float(value))[0] for value in values], axis=1)
    step = impact_map(orbit.oscillator, orbit.forcing, stop)
    search = _UnstableManifold(step, saddles.points[0], axes, float(values[0]))
    orbits = []
    for s, k in search.crossings(most_impacts):
        points = search.orbit_from(s, k)
        if points is not None:
            orbits.append(HomoclinicOrbit(orbit, stop, points, search.coordinates(points)))
        if len(orbits) == most_orbits:
            break
    return tuple(sorted(orbits, key=len))


@dataclass(frozen=True, slots=True)
class _UnstableManifold:
    """Follows the unstable manifold of a fixed point of an impact map.

    Attributes
    ----------
    map, saddle
        The map, and its fixed point.
    axes
        (2, 2) array, unstable and stable direction as columns.
    multiplier
        Of the unstable direction.
    """

    map: ImpactMap
    saddle: Floats
    axes: Floats
    multiplier: float

    def forward(self, points: Floats) -> Floats:
        """Return the next impacts of (n, 2) points; NaN where there is none."""
        return images_of(points, lambda some: self.map(*some.T))

    def coordinates(self, points: Floats) -> Floats:
        """Return distances from the saddle along the unstable and the stable direction."""
        moved = points - self.saddle
        moved[:, 0] = (moved[:, 0] + 0.5) % 1.0 - 0.5
        return matmul(moved, inverse(self.axes).T)

    def begin(self, s: Floats) -> Floats:
        """Return points of the unstable manifold, next to the saddle."""
        return np.asarray(self.saddle + s[:, None] * self.axes[:, 0])

    def crossings(self, most_impacts: int) -> list[tuple[tuple[float, float], int]]:
        """Return parts of the fundamental domain that come back on both sides, and after how long."""
        places: list[tuple[tuple[float, float], int]] = []
        stretch = abs(self.multiplier) if self.multiplier > 0.0 else self.multiplier**2
        for side in (1.0, -1.0) if self.multiplier > 0.0 else (1.0,):
            s = side * END * power(stretch, np.linspace(-1.0, 0.0, SAMPLES))
            points, used = self.begin(s), np.zeros(SAMPLES - 1, dtype=bool)
            for k in range(1, most_impacts + 1):
                points = self.forward(points)
                a, b = self.coordinates(points).T
                near = np.nan_to_num(np.maximum(abs(a), abs(b)), nan=np.inf) < NEAR
                crosses = near[:-1] & near[1:] & (a[:-1] * a[1:] < 0.0) & ~used
                used |= crosses
                places += [((s[i], s[i + 1]), k) for i in np.flatnonzero(crosses)]
        return sorted(places, key=lambda crossing: crossing[1])

    def side(self, s: float, k: int) -> float:
        """Return on which side of the stable manifold a motion comes back, as a sign.

        Its motion along the unstable direction tells it as soon as it is the larger one: farther
        from the saddle the manifolds bend.
        """
        points = self.begin(np.array([s]))
        for _ in range(k):
            points = self.forward(points)
        for number in range(LEAVES):
            a, b = self.coordinates(points)[0]
            if not max(abs(a), abs(b)) < NEAR:
                return math.nan
            if abs(a) > abs(b):
                return math.copysign(1.0, self.multiplier) ** number * float(a)
            points = self.forward(points)
        return 0.0

    def orbit_from(self, between: tuple[float, float], k: int) -> Floats | None:
        """Return the points of the homoclinic orbit in a part of the fundamental domain."""
        low, high = between
        first = self.side(low, k)
        if not first * self.side(high, k) < 0.0:
            return None
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            side = self.side(middle, k)
            if math.isnan(side):
                return None
            if side == 0.0:
                low = high = middle
            elif side * first > 0.0:
                low = middle
            else:
                high = middle
        points = [self.begin(np.array([low, high]))]
        for _ in range(k + LEAVES):
            points.append(self.forward(points[-1]))
        sides = self.coordinates(points[k])[:, 0]
        if not abs(sides[1] - sides[0]) < RESOLVED:
            # The map jumps there, or rounding does not tell on which side a motion comes back.
            return None
        orbit = np.array(points)[:, 0]
        sizes = np.nan_to_num(hypot(*self.coordinates(orbit).T), nan=np.inf)
        away = np.flatnonzero(sizes[k:] > NEAR)
        # It ends where it is nearest to the saddle: from there on rounding carries it away.
        last = k + int(np.argmin(sizes[k:][: away[0] if away.size else None]))
        return orbit[: last + 1]
