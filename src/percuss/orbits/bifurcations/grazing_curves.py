"""Curves of grazing: orbits that touch a stop at zero velocity.

A graze is an event without effect: the equations are those of the itinerary with this event, and
that its velocity is zero. Motion without events is known in closed form, which leaves two equations
for the instant of the graze: zero velocity, and zero clearance.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Self

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.flight import (
    acceleration_and_jerk,
    constant_force,
    place,
)
from percuss.kernels.law_columns import N_KNOTS, PERIOD, Law
from percuss.kernels.tangent import propagator
from percuss.motion.accelerations import phases_at
from percuss.motion.reach import steady
from percuss.numerics import determinant
from percuss.orbits.bifurcations.branch_equations import NO_TIME, OrbitEquations
from percuss.orbits.bifurcations.curve_equations import CurveEquations, return_equations
from percuss.orbits.bifurcations.grazing_contact import GrazingContact, acceleration_at
from percuss.orbits.continuation.problem import Point
from percuss.orbits.orbit.itinerary import Itinerary, row_of_region
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_state
from percuss.orbits.orbit.turning_points import Passages

# Clearances below this part of the scale are zero.
ZERO = 1e-10


class GrazingCurve(CurveEquations):
    """Orbits with impacts that also graze a stop.

    Parameters
    ----------
    equations
        Those of the itinerary that begins with the graze.
    others
        Those of the itinerary without it.
    contact
        The graze.
    first
        The other event with which ``others`` begin: one that meets a stop.
    """

    def __init__(
        self, equations: OrbitEquations, others: OrbitEquations, contact: GrazingContact, first: int
    ) -> None:
        super().__init__(equations)
        self.others, self.contact, self.first = others, contact, first

    @property
    def orbits(self) -> OrbitEquations:
        """The equations of the orbits of the curve: those without the graze."""
        return self.others

    def unknowns_of(self, others: Itinerary, period: float) -> Floats:
        """Return the scaled unknowns of an orbit with these other events."""
        n = self.equations.n
        span = period if self.equations.mirror > 0.0 else 0.5 * period
        instants = np.append(self.contact.t, others.instants[: n - 1])
        durations = np.diff(np.append(instants, self.contact.t + span))
        unknowns = np.concatenate([instants[:1], durations, [0.0], others.velocities[: n - 1]])
        return np.asarray(unknowns / self.equations.scale)

    def at_impact(self, z: Floats) -> bool:
        """Return whether the graze coincides with another event.

        At the end of a plastic impact that is no graze: it is there whatever the parameters are.
        """
        return bool(np.abs(z[[1, self.equations.n]]).min() < NO_TIME)

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent, on the side of an earlier one's, and its tests."""
        if self.at_impact(z):
            what = "the graze comes to coincide with an impact"
            raise ConvergenceError(what, z, 0.0, "take smaller steps")
        return super().point(z, before)

    def residual(self, z: Floats) -> Floats:
        """Return those of the itinerary, and the velocity of the graze."""
        residual, _ = self._shot(z)
        return np.append(residual, z[1 + self.equations.n])

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives."""
        _, matrix = self._shot(z)
        speed = np.zeros(len(matrix))
        speed[1 + self.equations.n] = 1.0
        return np.vstack([matrix, speed])

    def _shot(self, z: Floats) -> tuple[Floats, Floats]:
        """Return residuals and derivatives of the itinerary, where the graze keeps its velocity."""
        law, last = self.law_of(z), 2 * self.equations.n - 1
        residual, matrix = self.equations.shot(z[:-2], law)
        rigid = self.equations.shot(z[:-2], elastic(law, self.contact.region))
        residual[last], matrix[last] = rigid[0][last], rigid[1][last]
        return residual, matrix

    def _unknowns_without(self, z: Floats) -> Floats:
        """Return the scaled unknowns of the orbit without the graze."""
        n = self.equations.n
        t, durations, speeds = z[0], z[1 : 1 + n], z[1 + n : 1 + 2 * n]
        joined = np.append(durations[1:-1], durations[-1] + durations[0])
        t += durations[0] + joined[: self.first].sum()
        after = np.append(speeds[1 + self.first :], self.others.mirror * speeds[1 : 1 + self.first])
        mine = np.concatenate([[t], np.roll(joined, -self.first), after])
        return np.asarray(mine * np.delete(self.equations.scale, [1, 1 + n]) / self.others.scale)

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point, without the graze."""
        return self.others.orbit_at(self._unknowns_without(z), self.values(z))

    def evaluated(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the orbit of a point, which grazes the stop, with the functions."""
        orbit, tests = super().evaluated(z)
        return grazing_orbit(orbit, tests), tests

    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions of the graze, the other impacts and the multipliers."""
        law, unknowns = self.law_of(z), self._unknowns_without(z)
        instant = float(z[0] * self.equations.scale[0])
        in_halves = self.equations.mirror < 0.0
        # The orbit may be given from another period of the force on.
        shift = orbit.itinerary.start - float(unknowns[0] * self.others.scale[0])
        clearance = other_clearance(orbit, law, instant + shift, in_halves=in_halves)
        small = ZERO * float(self.equations.rows[0])
        tests = {"clearance": 0.0 if abs(clearance) < small else clearance}
        tests["acceleration"] = -self.contact.sign * acceleration_at(law, self.contact, instant)
        into = self.others.into_stops(orbit)
        for k, speed in enumerate(into):
            tests[f"velocity {k}"] = float(speed)
        _, matrix = self.others.shot(unknowns, law)
        for name, multiplier in (("multiplier 1", 1.0), ("multiplier -1", -1.0)):
            n, mirror = self.others.n, self.others.mirror
            returns = return_equations(matrix, n, multiplier, mirror)
            tests[name] = determinant(returns)
        if is_on_wall(law, self.contact):
            tests["return"] = self._return(z[:-2], law)
        return tests

    def _return(self, unknowns: Floats, law: Law) -> float:
        """Return the derivative of x after one period by the velocity of the graze.

        It is a determinant, with the other impact velocities as factors.
        """
        n = self.equations.n
        _, matrix = self.equations.shot(unknowns, law)
        around = return_equations(matrix, n, 0.0)[: 2 * n - 1, 1:]
        return determinant(around)


class SteadyGrazingCurve(CurveEquations):
    """Motions without impacts that graze a stop, in closed form.

    Parameters
    ----------
    equations
        Those of the motion, which are none.
    contact
        The graze.
    n_periods
        Forcing periods between the impacts of the orbits that begin there.
    """

    def __init__(self, equations: OrbitEquations, contact: GrazingContact, n_periods: int) -> None:
        super().__init__(equations)
        self.contact, self.n_periods = contact, n_periods
        law = equations.law_at(equations.own_values)
        _, y, _, _ = _steady_at(law, contact.region, contact.t)
        self._length, self._time = abs(y) or 1.0, float(law[0, PERIOD])

    def _at_graze(self, z: Floats) -> tuple[float, float, float, float]:
        """Return clearance, velocity and acceleration at the instant, and the forcing's period."""
        law, region = self.law_of(z), self.contact.region
        period = float(law[0, PERIOD])
        mean, y, v, acceleration = _steady_at(law, region, float(z[0]) * period)
        bound = place(law, region, self.contact.bound)
        gap = bound - mean if law[0, N_KNOTS] > 0.0 else _from_mean(law, region, bound)
        return self.contact.sign * (gap - y), v, acceleration, period

    def residual(self, z: Floats) -> Floats:
        """Return the velocity at the instant, and the clearance."""
        clearance, v, *_ = self._at_graze(z)
        return np.array([v * self._time, clearance]) / self._length

    def by_unknowns(self, z: Floats) -> Floats:
        """Return the derivatives by the instant."""
        _, v, acceleration, period = self._at_graze(z)
        slopes = np.array([[acceleration * self._time], [-self.contact.sign * v]])
        return slopes * (period / self._length)

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the motion of a point."""
        return self.equations.orbit_at(np.empty(0), self.values(z))

    def evaluated(self, z: Floats) -> tuple[PeriodicOrbit, dict[str, float]]:
        """Return the motion of a point, which grazes the stop, with the functions."""
        orbit, tests = super().evaluated(z)
        return grazing_orbit(orbit, tests), tests

    def tests(self, z: Floats, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions of the graze."""
        instant = float(z[0]) * float(self.law_of(z)[0, PERIOD])
        clearance = other_clearance(orbit, self.law_of(z), instant)
        small = ZERO * self._length
        return {"clearance": 0.0 if abs(clearance) < small else clearance, **self._of_graze(z)}

    def _of_graze(self, z: Floats) -> dict[str, float]:
        law, region = self.law_of(z), self.contact.region
        _, _, acceleration, period = self._at_graze(z)
        tests = {"acceleration": -self.contact.sign * acceleration}
        if is_on_wall(law, self.contact):
            tests["return"] = propagator(law, region, self.n_periods * period)[1]
        return tests

    def test(self, z: Floats, name: str) -> float:
        """Return one of the functions; only the clearance needs the orbit."""
        if name == "clearance":
            return super().test(z, name)
        return self._of_graze(z)[name]

    def pieces(self, a: Floats, b: Floats) -> int:
        """Return the number of pieces between two points in which tests change sign once at most.

        At low frequencies free motion makes many swings in a period.
        """
        half_swings = [self._swings(z) for z in (a, b)]
        return 1 + int(2.0 * abs(half_swings[1] - half_swings[0]))

    def _swings(self, z: Floats) -> float:
        """Return the number of half swings of free motion between the impacts."""
        law, region = self.law_of(z), self.contact.region
        square = law[region, at.STIFFNESS] - law[region, at.DAMPING] ** 2
        duration = self.n_periods * float(law[0, PERIOD])
        return float(np.sqrt(max(square, 0.0))) * duration / np.pi


def _steady_at(law: Law, region: int, t: float) -> tuple[float, float, float, float]:
    """Return x0, x - x0, v and acceleration of steady motion at an instant.

    x0 is a point of the region under a record, and the mean, given as NaN, under harmonics.
    """
    phases = phases_at(law, t)
    if law[0, N_KNOTS] > 0.0:
        y, v = steady_state(law, region, t)
        x0, force = float(law[region, at.ORIGIN]), float(law[region, at.ORIGIN_FORCE])
    else:
        y, v = (float(each) for each in steady(law, region, phases).sum(axis=0))
        x0, force = math.nan, 0.0
    acceleration, _ = acceleration_and_jerk(law, region, force, phases, y, v)
    return x0, y, v, float(acceleration)


def _from_mean(law: Law, region: int, x: float) -> float:
    """Return the distance from the mean of steady motion to a bound, without cancellation."""
    stiffness = float(law[region, at.STIFFNESS])
    if stiffness == 0.0:
        # Without a spring any displacement is an equilibrium; the middle is taken.
        return x - 0.5 * float(law[region, at.LOWER] + law[region, at.UPPER])
    return -float(constant_force(law, region, x)) / stiffness


# Turning points this near the graze, as a part of the period, are the graze.
SAME = 1e-6


def others_of(orbit: PeriodicOrbit, contact: GrazingContact) -> Itinerary:
    """Return the itinerary of an orbit that grazes a stop, from the graze on."""
    itinerary = orbit.itinerary
    events = orbit.record[0][: len(itinerary)]
    after = contact.t + np.mod(events[:, columns.EVENT_T] - contact.t, orbit.period)
    order = np.argsort(after)
    rows = np.ascontiguousarray(itinerary.events[order])
    instants = after[order]
    durations = np.diff(np.append(instants, instants[0] + orbit.period))
    velocities = events[order, columns.V_AFTER]
    return Itinerary(rows, float(instants[0]), durations, velocities, orbit.n_periods)


def is_on_wall(law: Law, contact: GrazingContact) -> bool:
    """Return whether a grazing contact is that of a wall."""
    kind = at.UPPER_KIND if contact.sign > 0.0 else at.LOWER_KIND
    return bool(law[contact.region, kind] == at.WALL)


def mirrored(law: Law, contact: GrazingContact) -> GrazingContact:
    """Return the graze of the opposite stop in a symmetric system."""
    n_regions = int(law[0, at.N_REGIONS])
    region = row_of_region(law, n_regions - 1 - int(law[contact.region, at.NUMBER]))
    return GrazingContact(contact.t, n_regions - contact.bound, region, -contact.sign, ())


def elastic(law: Law, region: int) -> Floats:
    """Return the law with elastic walls round a region, at which a graze keeps its velocity."""
    changed = law.copy()
    changed[region, at.LOWER_RESTITUTION] = changed[region, at.UPPER_RESTITUTION] = 1.0
    changed[region, at.LOWER_TABLE] = changed[region, at.UPPER_TABLE] = 0.0
    return changed


def other_clearance(
    orbit: PeriodicOrbit, law: Law, instant: float, *, in_halves: bool = False
) -> float:
    """Return the least clearance at the turning points other than the graze.

    ``in_halves`` leaves out the graze of the opposite stop half a period later, too.
    """
    turns = orbit.turning_points
    period = orbit.period if len(orbit.itinerary) else float(law[0, PERIOD])
    if in_halves:
        period *= 0.5
    distances = np.mod(turns.t - instant + 0.5 * period, period) - 0.5 * period
    others = turns.clearance[np.abs(distances) > SAME * period]
    return float(others.min()) if len(others) else 1e300


def grazing_orbit(orbit: PeriodicOrbit, tests: Mapping[str, float]) -> PeriodicOrbit:
    """Return an orbit that grazes a stop as one whose clearance is 0, without rounding.

    Parameters
    ----------
    orbit
        As it is computed.
    tests
        Other clearance, velocities, and the acceleration away from the stop.
    """
    clearance = tests["clearance"]
    speeds = [value for name, value in tests.items() if name.startswith("velocity")]
    passages = orbit.passages
    deep = passages.depth > (-0.5 * clearance if clearance < 0.0 else np.inf)
    penetrations = Passages(passages.t[deep], passages.stop[deep], passages.depth[deep])
    return dataclasses.replace(
        orbit,
        grazing_margin=min(0.0, clearance),
        passages=penetrations,
        admissible=clearance >= 0.0 and min(speeds, default=1.0) > 0.0 < tests["acceleration"],
    )
