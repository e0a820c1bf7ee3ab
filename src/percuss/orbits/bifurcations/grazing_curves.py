"""Curves of grazing: orbits that touch a stop with no velocity.

A touch is an event in which nothing happens: the equations are those of a chain with that event,
and that the velocity there is zero. Motion without events is known in closed form, and then two
equations are left, for the instant of the touch: no velocity, and no distance to the stop.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from percuss.arrays import Floats
from percuss.kernels import law as at
from percuss.kernels import record as columns
from percuss.kernels.flight import (
    acceleration_and_jerk,
    constant_force,
    force_derivative,
    place,
    set_phases,
)
from percuss.kernels.law import N_HARMONICS, PERIOD, Law, Table
from percuss.kernels.tangent import propagator
from percuss.motion.reach import steady
from percuss.numerics import determinant
from percuss.orbits.bifurcations.curve_equations import CurveEquations, return_equations
from percuss.orbits.bifurcations.family import OrbitEquations
from percuss.orbits.bifurcations.grazing_contact import GrazingContact
from percuss.orbits.orbit.itinerary import Itinerary, row_of_region
from percuss.orbits.orbit.passages import Passages
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = [
    "GrazingCurve",
    "SteadyGrazingCurve",
    "elastic",
    "is_on_wall",
    "mirrored",
    "others_of",
    "room_beside",
    "touched",
]


# Distances to a stop below this part of the scale are none.
NO_ROOM = 1e-10


class GrazingCurve(CurveEquations):
    """Orbits with impacts that touch a stop besides.

    Parameters
    ----------
    equations
        Those of the chain that begins with the touch.
    others
        Those of the chain without it.
    touch
        The touch.
    first
        Which of its other events those begin with: one that meets a stop.
    """

    def __init__(
        self, equations: OrbitEquations, others: OrbitEquations, touch: GrazingContact, first: int
    ) -> None:
        super().__init__(equations)
        self.others, self.touch, self.first = others, touch, first

    @property
    def orbits(self) -> OrbitEquations:
        """The equations of the orbits that are told: those without the touch."""
        return self.others

    def unknowns_of(self, others: Itinerary, period: float) -> Floats:
        """Return the scaled unknowns of an orbit with these other events."""
        n = self.equations.n
        span = period if self.equations.mirror > 0.0 else 0.5 * period
        instants = np.append(self.touch.t, others.instants[: n - 1])
        lasting = np.diff(np.append(instants, self.touch.t + span))
        unknowns = np.concatenate([instants[:1], lasting, [0.0], others.velocities[: n - 1]])
        return np.asarray(unknowns / self.equations.scale)

    def residual(self, z: Floats) -> Floats:
        """Return those of the chain, and the velocity of the touch."""
        table = self.table(z)
        residual, _ = self.equations.shot(z[:-2], table)
        last = 2 * self.equations.n - 1
        rigid = elastic(table, self.touch.region)
        residual[last] = self.equations.shot(z[:-2], rigid)[0][last]
        return np.append(residual, z[1 + self.equations.n])

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives."""
        table = self.table(z)
        _, matrix = self.equations.shot(z[:-2], table)
        last = 2 * self.equations.n - 1
        rigid = elastic(table, self.touch.region)
        matrix[last] = self.equations.shot(z[:-2], rigid)[1][last]
        speed = np.zeros(len(matrix))
        speed[1 + self.equations.n] = 1.0
        return np.vstack([matrix, speed])

    def _unknowns_without(self, z: Floats) -> Floats:
        """Return the scaled unknowns of the orbit without the touch."""
        n = self.equations.n
        t, lasting, speeds = z[0], z[1 : 1 + n], z[1 + n : 1 + 2 * n]
        joined = np.append(lasting[1:-1], lasting[-1] + lasting[0])
        t += lasting[0] + joined[: self.first].sum()
        after = np.append(speeds[1 + self.first :], self.others.mirror * speeds[1 : 1 + self.first])
        mine = np.concatenate([[t], np.roll(joined, -self.first), after])
        return np.asarray(mine * np.delete(self.equations.scale, [1, 1 + n]) / self.others.scale)

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point, without the touch."""
        return self.others.orbit_at(self._unknowns_without(z), self.values(z))

    def told(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the orbit of a point, which touches the stop, with the functions."""
        orbit, found = super().told(z)
        return touched(orbit, found), found

    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions that tell the touch, the other impacts and the multipliers."""
        table = self.table(z)
        instant = float(z[0] * self.equations.scale[0])
        in_halves = self.equations.mirror < 0.0
        room = room_beside(orbit, table, instant, in_halves=in_halves)
        small = NO_ROOM * float(self.equations.rows[0])
        found = {"passage": 0.0 if abs(room) < small else room}
        found["acceleration"] = -self.touch.sign * _acceleration(table, self.touch, instant)
        into = self.others.into_stops(orbit)
        for k, speed in enumerate(into):
            found[f"velocity {k}"] = float(speed)
        _, matrix = self.others.shot(self._unknowns_without(z), table)
        for name, multiplier in (("one", 1.0), ("minus one", -1.0)):
            n, mirror = self.others.n, self.others.mirror
            returns = return_equations(matrix, n, multiplier, mirror)
            found[name] = determinant(returns)
        if is_on_wall(table, self.touch):
            found["return"] = self._return(z[:-2], table)
        return found

    def _return(self, unknowns: Floats, table: Law) -> float:
        """Return the derivative of x after one period by the velocity of the touch.

        It is a determinant, and has the other impact velocities as factors.
        """
        n = self.equations.n
        _, matrix = self.equations.shot(unknowns, table)
        around = return_equations(matrix, n, 0.0)[: 2 * n - 1, 1:]
        return determinant(around)


class SteadyGrazingCurve(CurveEquations):
    """Motions without impacts that touch a stop, in closed form.

    Parameters
    ----------
    equations
        Those of the motion, which are none.
    touch
        The touch.
    n_periods
        Forcing periods between the impacts of the orbits that begin there.
    """

    def __init__(self, equations: OrbitEquations, touch: GrazingContact, n_periods: int) -> None:
        super().__init__(equations)
        self.touch, self.n_periods = touch, n_periods
        table = equations.table_at(equations.own_values)
        phases = np.empty((int(table[0, N_HARMONICS]), 2))
        set_phases(table, touch.t, 0.0, phases)
        y, _ = steady(table, touch.region, phases).sum(axis=0)
        self._length, self._time = abs(float(y)) or 1.0, float(table[0, PERIOD])

    def _at_touch(self, z: Floats) -> tuple[float, float, float, float]:
        """Return room, velocity and acceleration at the instant, and the forcing's period."""
        table, region = self.table(z), self.touch.region
        period = float(table[0, PERIOD])
        instant = float(z[0]) * period
        phases = np.empty((int(table[0, N_HARMONICS]), 2))
        set_phases(table, instant, 0.0, phases)
        y, v = (float(each) for each in steady(table, region, phases).sum(axis=0))
        gap = _from_mean(table, region, place(table, region, self.touch.bound))
        acceleration, _ = acceleration_and_jerk(table, region, 0.0, phases, y, v)
        return self.touch.sign * (gap - y), v, acceleration, period

    def residual(self, z: Floats) -> Floats:
        """Return the velocity at the instant, and the distance to the stop."""
        room, v, *_ = self._at_touch(z)
        return np.array([v * self._time, room]) / self._length

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives by the instant."""
        _, v, acceleration, period = self._at_touch(z)
        slopes = np.array([[acceleration * self._time], [-self.touch.sign * v]])
        return slopes * (period / self._length)

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the motion of a point."""
        return self.equations.orbit_at(np.empty(0), self.values(z))

    def told(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the motion of a point, which touches the stop, with the functions."""
        orbit, found = super().told(z)
        return touched(orbit, found), found

    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions that tell the touch."""
        instant = float(z[0]) * float(self.table(z)[0, PERIOD])
        room = room_beside(orbit, self.table(z), instant)
        small = NO_ROOM * self._length
        return {"passage": 0.0 if abs(room) < small else room, **self._of_touch(z)}

    def _of_touch(self, z: Floats) -> dict[str, float]:
        table, region = self.table(z), self.touch.region
        _, _, acceleration, period = self._at_touch(z)
        found = {"acceleration": -self.touch.sign * acceleration}
        if is_on_wall(table, self.touch):
            found["return"] = propagator(table, region, self.n_periods * period)[1]
        return found

    def test(self, z: Floats, name: str) -> float:
        """Return one of the functions; but for the room it needs no orbit."""
        if name == "passage":
            return super().test(z, name)
        return self._of_touch(z)[name]

    def pieces(self, a: Floats, b: Floats) -> int:
        """Return in how many pieces the tests change sign once at most between two points.

        At low frequencies free motion swings often in a period.
        """
        half_swings = [self._swings(z) for z in (a, b)]
        return 1 + int(2.0 * abs(half_swings[1] - half_swings[0]))

    def _swings(self, z: Floats) -> float:
        """Return how many half swings free motion makes between the impacts."""
        table, region = self.table(z), self.touch.region
        square = table[region, at.STIFFNESS] - table[region, at.DAMPING] ** 2
        lasting = self.n_periods * float(table[0, PERIOD])
        return float(np.sqrt(max(square, 0.0))) * lasting / np.pi


def _acceleration(table: Law, touch: GrazingContact, instant: float) -> float:
    """Return the acceleration at rest at the bound of a touch."""
    phases = np.empty((int(table[0, N_HARMONICS]), 2))
    set_phases(table, instant, 0.0, phases)
    force = constant_force(table, touch.region, place(table, touch.region, touch.bound))
    return float(force + force_derivative(table, phases, 0))


def _from_mean(table: Law, region: int, x: float) -> float:
    """Return the way from the mean position of steady motion to a bound, without cancellation."""
    stiffness = float(table[region, at.STIFFNESS])
    if stiffness == 0.0:
        # Without a spring it may be anywhere, and is taken in the middle.
        return x - 0.5 * float(table[region, at.LOWER] + table[region, at.UPPER])
    return -float(constant_force(table, region, x)) / stiffness


# Turning points this near to the touch, as a part of the period, are the touch.
SAME = 1e-6


def others_of(orbit: PeriodicOrbit, touch: GrazingContact) -> Itinerary:
    """Return the events of an orbit that touches a stop, from the touch on."""
    itinerary = orbit.itinerary
    events = orbit.record[0][: len(itinerary)]
    after = touch.t + np.mod(events[:, columns.EVENT_T] - touch.t, orbit.period)
    order = np.argsort(after)
    chain = np.ascontiguousarray(itinerary.events[order])
    instants = after[order]
    durations = np.diff(np.append(instants, instants[0] + orbit.period))
    velocities = events[order, columns.V_AFTER]
    return Itinerary(chain, float(instants[0]), durations, velocities, orbit.n_periods)


def is_on_wall(table: Law, touch: GrazingContact) -> bool:
    """Return whether a touch is that of a wall."""
    kind = at.UPPER_KIND if touch.sign > 0.0 else at.LOWER_KIND
    return bool(table[touch.region, kind] == at.WALL)


def mirrored(table: Law, touch: GrazingContact) -> GrazingContact:
    """Return the touch of the opposite stop in a symmetric system."""
    n_regions = int(table[0, at.N_REGIONS])
    region = row_of_region(table, n_regions - 1 - int(table[touch.region, at.NUMBER]))
    return GrazingContact(touch.t, n_regions - touch.bound, region, -touch.sign, ())


def elastic(table: Law, region: int) -> Table:
    """Return the law with elastic walls round a region: there a touch tells its velocity."""
    changed = table.copy()
    changed[region, at.LOWER_RESTITUTION] = changed[region, at.UPPER_RESTITUTION] = 1.0
    return changed


def room_beside(
    orbit: PeriodicOrbit, table: Law, instant: float, *, in_halves: bool = False
) -> float:
    """Return the least distance to a stop at the turning points other than the touch.

    ``in_halves`` leaves out the touch of the opposite stop half a period later, too.
    """
    turns = orbit.turning_points
    period = orbit.period if len(orbit.itinerary) else float(table[0, PERIOD])
    if in_halves:
        period *= 0.5
    apart = np.mod(turns.t - instant + 0.5 * period, period) - 0.5 * period
    others = turns.clearance[np.abs(apart) > SAME * period]
    return float(others.min()) if len(others) else 1e300


def touched(orbit: PeriodicOrbit, tests: Mapping[str, float]) -> PeriodicOrbit:
    """Return an orbit that touches a stop as one whose distance to it is 0, without rounding.

    Parameters
    ----------
    orbit
        As it is computed.
    tests
        Those of `percuss.orbits.bifurcations.grazing_curves`: room, velocities, and the acceleration away
        from the stop.
    """
    room = tests["passage"]
    speeds = [value for name, value in tests.items() if name.startswith("velocity")]
    passages = orbit.passages
    beyond = passages.depth > (-0.5 * room if room < 0.0 else np.inf)
    kept = Passages(passages.t[beyond], passages.stop[beyond], passages.depth[beyond])
    return dataclasses.replace(
        orbit,
        grazing_margin=min(0.0, room),
        passages=kept,
        admissible=room >= 0.0 and min(speeds, default=1.0) > 0.0 < tests["acceleration"],
    )
