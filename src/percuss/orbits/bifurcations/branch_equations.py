"""The equations of an orbit over parameters, and families of orbits along one of them."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels.flight import place
from percuss.kernels.law_columns import N_HARMONICS, PERIOD, Law
from percuss.kernels.shooting import AT, ShootingProblem, shoot
from percuss.model.exact import as_float
from percuss.model.expression import Expression
from percuss.model.paths import get_parameter, moved_fields, replace_parameters
from percuss.model.system import System
from percuss.motion.accelerations import acceleration_in
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.borders import Bordered
from percuss.orbits.bifurcations.force_jumps import Crossing, ForceJumps
from percuss.orbits.bifurcations.parameter_ranges import Ranges, own_value, range_around
from percuss.orbits.continuation.correct import WEAK, corrected, tangent_of
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.itinerary import Itinerary, entries_of, entry, is_plastic, is_wall
from percuss.orbits.orbit.over_period import fastest
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.solve import Solution, orbit_of_solution
from percuss.orbits.orbit.steady import steady_orbit

# Systems that are kept: the differences by two parameters take five.
SYSTEMS = 8


class OrbitEquations:
    """The equations of all orbits with the events of one, over some parameters.

    Parameters
    ----------
    orbit
        One of them.
    ranges
        Lowest and highest value of each parameter by its path; scaled it is from 0 to 1.
    events
        (n, 3) array, the events, where they are not those of the orbit.

    Attributes
    ----------
    own_values
        Those of the orbit.
    n
        Number of events; 0 for steady motion in one region, which needs no equations.
    scale, rows
        (2 n + 1,) arrays, units of the unknowns and of the residuals; empty without events.
    entries
        (row, stop, sign of the velocity before) of the events that meet a stop.
    walls
        Which events are impacts on walls.
    mirror
        Factor of the velocities when the events begin anew.
    """

    mirror = 1.0

    def __init__(
        self, orbit: PeriodicOrbit, ranges: Ranges, events: Integers | None = None
    ) -> None:
        self.system = orbit.system
        self.paths = tuple(ranges)
        self.lows = tuple(low for low, _ in ranges.values())
        self.highs = tuple(high for _, high in ranges.values())
        self.events = orbit.itinerary.events if events is None else events
        self.n_periods = orbit.n_periods
        self.own_values = tuple(own_value(orbit, path) for path in self.paths)
        law = self.system.law
        n = self.n = len(self.events)
        self.region = -1 if n else int(orbit.record[1][0, 2])
        self.speed = speed = fastest(orbit)
        self.scale = np.repeat([orbit.period, speed], [1 + n, n]) if n else np.empty(0)
        # Distance, velocity after it and, last, time.
        self.rows = np.array([orbit.period * speed, speed] * n + [orbit.period] * min(n, 1))
        met = entries_of(self.system, self.events)
        self._entry_rows = [row for row, _ in met]
        self.entries = [(i, stop, entry(self.system.oscillator, stop).sign) for i, stop in met]
        self.walls = is_wall(law, self.events)
        self.jumps = ForceJumps.of(law) if n else ForceJumps(())
        self._phases = np.empty((2, int(law[0, N_HARMONICS]), 2))
        self.system_at = lru_cache(SYSTEMS)(self._system_at)
        self.law_at = lru_cache(SYSTEMS)(self._law_at)

    @cached_property
    def _ratios(self) -> Floats:
        """Units of the unknowns over those of the residuals."""
        return np.asarray(self.scale / np.reshape(self.rows, (-1, 1)))

    def unknowns_of(self, orbit: PeriodicOrbit) -> Floats:
        """Return the scaled unknowns of an orbit with these events."""
        return orbit.itinerary.vector / self.scale if self.n else np.empty(0)

    def value_at(self, k: int, part: float) -> float:
        """Return the value of the k-th parameter at a scaled one; at 1 it is the highest."""
        low, high = self.lows[k], self.highs[k]
        return high if part == 1.0 else low + part * (high - low)

    def part_of(self, k: int, value: float) -> float:
        """Return the scaled value of the k-th parameter."""
        return (value - self.lows[k]) / (self.highs[k] - self.lows[k])

    def _system_at(self, values: tuple[float, ...]) -> System:
        """Return the system at values of the parameters."""
        changes = {path: float(value) for path, value in zip(self.paths, values, strict=True)}
        osc, force, _ = replace_parameters(*self.system, None, changes)
        return System(osc, force)

    def _law_at(self, values: tuple[float, ...]) -> Law:
        """Return the law at values of the parameters."""
        system, reason = self.system_at(values), ""
        law = system.law
        if law.shape != self.system.law.shape:
            reason = "the stops fall together there"
        elif self._entry_rows != [row for row, _ in entries_of(system, self.events)]:
            reason = "stops change places there, and events that enter one leave the other"
        if reason:
            given = values[0] if len(values) == 1 else values
            raise ParameterError(", ".join(self.paths), given, reason)
        return law

    def sides(self, unknowns: Floats, values: tuple[float, ...]) -> Integers:
        """Return the number of jumps of the force before each event and the return of the first.

        The equations are smooth where none of these numbers, (n + 1,), changes.
        """
        return self.sides_under(unknowns, self.law_at(values))

    def sides_under(self, unknowns: Floats, law: Law) -> Integers:
        """Return what `sides` does, under a law."""
        if not self.jumps:
            return np.zeros(self.n + 1, dtype=np.int64)
        t = np.cumsum(unknowns[: 1 + self.n]) * self.scale[0]
        return self.jumps.passed(law, t)

    def nearest_jump(self, unknowns: Floats, law: Law) -> float:
        """Return the part of the period between a jump of the force and the event nearest to one."""
        if not self.jumps or self.n == 0:
            return math.inf
        t = np.cumsum(unknowns[: self.n]) * self.scale[0]
        return min(self.jumps.nearest(law, instant) for instant in t.tolist()) / float(
            law[0, PERIOD]
        )

    def shot(self, unknowns: Floats, law: Law) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, under a law."""
        size = 2 * self.n + 1 if self.n else 0
        residual, matrix = np.empty(size), np.empty((size, size))
        if self.n == 0:
            return residual, matrix
        period = self.n_periods * float(law[0, PERIOD])
        problem = ShootingProblem(law, self.events, period, *self._phases)
        # A step that diverges may overflow, and the residual with it.
        with np.errstate(over="ignore", invalid="ignore"):
            given = unknowns * self.scale
            shoot(problem, given, residual, matrix)
            return residual / self.rows, matrix * self._ratios

    @cached_property
    def _returning(self) -> list[int]:
        """The flights that return to their bound."""
        ends = np.roll(self.events[:, AT], -1)
        return [i for i in range(self.n) if self.events[i, AT] == ends[i]]

    def regular_shot(self, unknowns: Floats, law: Law) -> tuple[Floats, Floats]:
        """Return what `shot` does, distances of flights that return to their bound by durations.

        So the equations stay regular as these go to zero, at a graze or where two impacts
        coincide, and a flight of zero duration is no solution by itself.
        """
        residual, matrix = self.shot(unknowns, law)
        if self._returning:
            self._divide_by_durations(law, unknowns, residual, matrix)
        return residual, matrix

    def _divide_by_durations(self, law: Law, z: Floats, residual: Floats, matrix: Floats) -> None:
        """Divide the distance residuals of flights that return to their bound by durations."""
        # A step that diverges may overflow; then Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for i in self._returning:
                duration = float(z[1 + i])
                if duration == 0.0:
                    # The limit: the velocity at the start, and half the acceleration.
                    residual[2 * i] = z[1 + self.n + i]
                    matrix[2 * i] = 0.0
                    matrix[2 * i, 1 + i] = 0.5 * self._acceleration(law, z, i)
                    matrix[2 * i, 1 + self.n + i] = 1.0
                    continue
                residual[2 * i] /= duration
                matrix[2 * i] /= duration
                matrix[2 * i, 1 + i] -= residual[2 * i] / duration

    def _acceleration(self, law: Law, z: Floats, i: int) -> float:
        """Return the scaled acceleration at the start of a flight."""
        bound, _, region = self.events[i].tolist()
        t, v = float(z[: 1 + i].sum()) * self.scale[0], float(z[1 + self.n + i]) * self.scale[-1]
        acceleration = acceleration_in(law, region, place(law, region, bound), v, t)
        return float(acceleration * self.scale[0] / self.scale[-1])

    def reversed_flights(self, here: Floats, new: Floats) -> list[int]:
        """Return the flights between impacts whose durations become negative at the second point.

        Such a flight is no motion: the impacts at its ends have coincided in between.
        """
        return [
            i for i in self._returning
            if self.walls[i] and self.walls[(i + 1) % self.n]
            and here[1 + i] >= -NO_TIME > new[1 + i]
        ]  # fmt: skip

    def is_coincidence(self, z: Floats, flights: list[int]) -> bool:
        """Return whether one of some flights has zero duration."""
        return bool(np.abs(z[[1 + i for i in flights]]).min() < NO_TIME)

    def orbit_at(self, unknowns: Floats, values: tuple[float, ...]) -> PeriodicOrbit:
        """Return the orbit of a solution."""
        system = self.system_at(values)
        if self.n == 0:
            return steady_orbit(system, self.region)
        law = self.law_at(values)
        residual, _ = self.shot(unknowns, law)
        largest = float(np.abs(residual * self.rows).max())
        vector = unknowns * self.scale
        # By rounding a mass that a plastic impact leaves at rest would turn at once.
        vector[1 + self.n :][is_plastic(law, self.events)] = 0.0
        itinerary = Itinerary.of_vector(self.events, vector, self.n_periods)
        return orbit_of_solution(system, Solution(itinerary, largest, True, True))

    def leaves_slowly(self, orbit: PeriodicOrbit) -> bool:
        """Return whether a soft stop is left without velocity, by the formal motion from beyond it.

        Velocities of either sign are two such motions: the branch turns, whatever the multipliers.
        """
        events, _ = orbit.record
        met = {row for row, *_ in self.entries}
        exits = [i or self.n for i in range(self.n) if i not in met and not self.walls[i]]
        speeds = np.abs(events[exits, 2])
        entries = np.abs(self.into_stops(orbit)).min(initial=np.inf)
        return bool(speeds.min(initial=np.inf) < SLOW * self.scale[-1] < entries)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop that is met; negative ones are formal."""
        events, _ = orbit.record
        return np.array([sign * events[i or self.n, 2] for i, _, sign in self.entries])


# Velocities below this part of the scale are zero where a branch turns.
SLOW = 1e-6
# Scaled residuals that need not become smaller.
ENOUGH = 1e-15
# Where another family crosses, Newton's method gains a factor of two a step only.
MOST_STEPS, MOST_NEAR_OTHERS = 12, 40
# Scaled step of the central difference by the parameter: h^2 and 1e-16/h are both small.
STEP = 1e-5
# Scaled durations that are zero at a special point, which is located to some 1e-12.
NO_TIME = 1e-6
# Where the parameter makes up this part of a step it is the coordinate; elsewhere arclength is.
MOSTLY_PARAMETER = 0.1
# Steps of the parameter between these, as parts of the range, give the derivative by it, if the
# tangent so found turns no more than by this cosine.
SHORT, LONG, STRAIGHT = 1e-7, 0.05, 0.995
# Least length of a step off a point at which families meet; factor to the next, shorter one; and
# largest correction as a part of the length, so that no other family is found.
LEAST, SHORTER, BENT = 1e-9, 0.25, 0.1
# Part of a step that no jump passes where two are very near each other.
TINY = 1e-7
# Determinants this near 1 are those of conservative motion.
CONSERVATIVE = 1e-12


class BranchEquations(OrbitEquations, Bordered):
    """The orbits with the events of one orbit, as points z = (scaled unknowns, scaled parameter).

    Scaled, the parameter goes from 0 at ``low`` to 1 at ``high``.
    """

    noun = "branch"
    order = 1

    def __init__(self, orbit: PeriodicOrbit, path: str, low: float, high: float) -> None:
        super().__init__(orbit, {path: (low, high)})
        self.path, self.low, self.high = path, low, high
        self.cyclic = slice(0, min(self.n, 1))
        self._others = _coincidences(self.system, path)

    @classmethod
    def around(cls, orbit: PeriodicOrbit, path: str) -> tuple[Self, Floats, float]:
        """Return the equations near an orbit, the point of it, and the value of the parameter."""
        value = own_value(orbit, path)
        family = cls(orbit, path, *range_around(value))
        return family, family.start(orbit, value), value

    def start(self, orbit: PeriodicOrbit, value: float) -> Floats:
        """Return the point of an orbit."""
        return np.append(self.unknowns_of(orbit), self.part_of(0, value))

    def values(self, z: Floats) -> tuple[float, ...]:
        """Return the parameter of a point."""
        return (self.value(z),)

    def value(self, z: Floats) -> float:
        """Return the parameter of a point."""
        return self.value_at(0, float(z[-1]))

    def residual(self, z: Floats, value: float) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, as `regular_shot`."""
        if self.n == 0:
            return np.empty(0), np.empty((0, 0))
        return self.regular_shot(z[:-1], self.law_at((float(value),)))

    def slope(self, z: Floats, known: float | None = None) -> Floats:
        """Return the derivative of the scaled residuals by the scaled parameter.

        With a ``known`` value of the parameter it is a difference of first order from there, which
        needs no new law.
        """
        if self.n == 0:
            return np.empty(0)
        if known is not None:
            step = (self.value(z) - known) / (self.high - self.low)
            before, here = self.residual(z, known)[0], self.residual(z, self.value(z))[0]
            with np.errstate(over="ignore", invalid="ignore"):
                return np.asarray((here - before) / step)
        # Not past another stop: beyond it the order of the stops differs.
        distances = (abs(self.part_of(0, at) - float(z[-1])) for at in self._others)
        step = min([STEP, *(0.5 * distance for distance in distances if distance > 0.0)])
        if self.jumps and not self._is_smooth(z, step):
            return self._one_sided_slope(z, step)
        sides = []
        for q in (z[-1] - step, z[-1] + step):
            try:
                sides.append((q, self.residual(z, self.low + q * (self.high - self.low))[0]))
            except ParameterError:
                # At the edge of the parameter's domain: a difference from one side.
                sides.append((float(z[-1]), self.residual(z, self.value(z))[0]))
        (q0, below), (q1, above) = sides
        # Where they are not finite Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((above - below) / (q1 - q0))

    def _sides_at(self, z: Floats, part: float) -> Integers:
        """Return `sides` of the unknowns of a point at another scaled parameter."""
        return self.sides(z[:-1], (self.low + part * (self.high - self.low),))

    def _is_smooth(self, z: Floats, step: float) -> bool:
        """Return whether no jump passes an event between two parameters about a point."""
        low, high = (self._sides_at(z, float(z[-1]) + sign * step) for sign in (-1.0, 1.0))
        return bool((low == high).all())

    def _one_sided_slope(self, z: Floats, step: float) -> Floats:
        """Return the derivative by the parameter from differences of second order to one side."""
        here = self._sides_at(z, float(z[-1]))
        sign = next(
            sign
            for sign in (1.0, -1.0, 0.0)
            if (self._sides_at(z, float(z[-1]) + 2.0 * sign * step) == here).all()
        )
        # Between two jumps less than four steps apart the error of a short one has to do.
        h = sign * step if sign else TINY * step
        width = self.high - self.low
        at = [self.residual(z, self.low + (float(z[-1]) + k * h) * width)[0] for k in range(3)]
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((4.0 * at[1] - 3.0 * at[0] - at[2]) / (2.0 * h))

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        """Return the point of the family as `_corrected` does, on this side of any border.

        Raises
        ------
        BorderError
            If an event passes a jump of the force on the way from the centre.
        """
        try:
            z = self._corrected(guess, normal, near_others=near_others)
        except ConvergenceError:
            self.check_border(guess)
            raise
        self.check_border(z)
        return z

    def passed(self, z: Floats) -> Integers:
        """Return the number of jumps of the force before each event of a point, (n,)."""
        return self.sides(z[:-1], self.values(z))[: self.n]

    def missed(self, z: Floats) -> Floats:
        """Return the residuals of a point."""
        return self.residual(z, self.value(z))[0]

    def beyond_jump(self, z: Floats, crossing: Crossing) -> float:
        """Return by how much of the period an event lies after a jump of the force."""
        at = self.jumps.instant(self.law_at(self.values(z)), crossing.jump)
        return float(z[: 1 + crossing.event].sum() - at / self.scale[0])

    def shifted(self, z: Floats, shifts: Floats) -> Floats:
        """Return a point with its events shifted by parts of the period; the first returns so."""
        moved = z.copy()
        moved[: 1 + self.n] += np.diff(np.append(shifts, shifts[0]), prepend=0.0)
        return moved

    def slope_of_border(self, z: Floats, crossing: Crossing) -> Floats:
        """Return the derivative of `beyond_jump` by a point."""
        slope = np.zeros(len(z))
        slope[: 1 + crossing.event] = 1.0
        ends = []
        for sign in (-1.0, 1.0):
            moved = z.copy()
            moved[-1] += sign * STEP
            ends.append(self.beyond_jump(moved, crossing))
        slope[-1] = (ends[1] - ends[0]) / (2.0 * STEP)
        return slope

    def halves_differ(self, orbit: PeriodicOrbit) -> float:
        """Return the difference of an orbit's halves, infinite where they are no halves."""
        return orbit.itinerary.halves_differ()

    def _corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        """Return the point of the family in the plane through a guess with this normal.

        Where another family crosses, the component towards it, of a small singular value, can be
        left as in the guess.

        Raises
        ------
        ConvergenceError
            If Newton's method finds none.
        ParameterError
            If the parameter cannot have the value.
        """
        # The derivative by the parameter is that at the guess; a fixed parameter needs none.
        slope = self.slope(guess) if normal[:-1].any() else np.zeros(len(guess) - 1)

        def equations(z: Floats) -> tuple[Floats, Floats]:
            residual, matrix = self.residual(z, self.value(z))
            return residual, np.column_stack([matrix, slope])

        steps = MOST_NEAR_OTHERS if near_others else MOST_STEPS
        weak = WEAK if near_others else 0.0
        z, error, is_solved = corrected(
            equations, guess, normal, steps=steps, enough=ENOUGH, size=self.size, weak=weak
        )
        if not is_solved:
            what = "Newton's method finds no orbit"
            raise ConvergenceError(what, z, error * self.size(z), "take smaller steps")
        return z

    def derivatives(self, z: Floats, known: float | None = None) -> Floats:
        """Return the derivatives of the scaled residuals by unknowns and parameter."""
        _, matrix = self.residual(z, self.value(z))
        return np.column_stack([matrix, self.slope(z, known)])

    def tangent(self, z: Floats, before: Floats, known: float | None = None) -> Floats:
        """Return the unit tangent of the family, on the side of an earlier one."""
        return tangent_of(self.derivatives(z, known), before)

    def started(self, orbit: PeriodicOrbit, value: float) -> Point[Self]:
        """Return the point of an orbit, with its tangent towards larger values."""
        z = self.start(orbit, value)
        tangent = self.tangent(z, along_parameter(len(z)))
        return Point(z, tangent, orbit, self.tests(orbit), self)

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent and its tests.

        After a step of the parameter that is neither short nor long the tangent is that of the
        difference from the earlier point, which needs no new law.
        """
        stepped = SHORT < abs(z[-1] - before.z[-1]) < LONG
        if stepped and self.jumps:
            there, here = (self._sides_at(z, float(one[-1])) for one in (before.z, z))
            stepped = bool((there == here).all())
        known = self.value(before.z) if stepped else None
        orbit = self.solution(z)
        tangent = self.tangent(z, before.tangent, known)
        if stepped and dot(before.tangent, tangent) < STRAIGHT:
            tangent = self.tangent(z, before.tangent)
        return Point(z, tangent, orbit, self.tests(orbit), self)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point with an exact tangent.

        Near another family that of a difference may be wrong.
        """
        return dataclasses.replace(point, tangent=self.tangent(point.z, point.tangent))

    def recentre(self, point: Point[Self] | None) -> None:
        """Take a point as that whose side of the borders `corrected` keeps to; None for any side."""
        self.border = None
        self.centre = point.z if point is not None and self.jumps else None

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:  # noqa: ARG002
        """Return the normal of Newton's hyperplane: the parameter's if it changes enough."""
        fixed = abs(tangent[-1]) > MOSTLY_PARAMETER
        return along_parameter(len(tangent)) if fixed else tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the longest step from a point, in proportion to its velocities."""
        return largest * self.size(point.z)

    def stepped_off(
        self,
        start: Floats,
        direction: Floats,
        length: float,
        *,
        signs: tuple[float, ...] = (1.0,),
        is_wanted: Callable[[PeriodicOrbit], bool] = lambda _: True,
    ) -> tuple[PeriodicOrbit | None, str]:
        """Return an orbit a step away from where families meet, or why there is none.

        Parameters
        ----------
        start
            The point at which they meet.
        direction
            Unit vector along this family.
        length
            Length of the first step that is tried.
        signs
            Sides of the start.
        is_wanted
            Condition on the orbit.
        """
        why = ""
        while length >= LEAST:
            for sign in signs:
                guess = start + sign * length * direction
                try:
                    z = self.corrected(guess, direction)
                    orbit = self.solution(z)
                except PercussError as error:
                    why = str(error)
                    continue
                if norm(z - guess) < BENT * length and is_wanted(orbit):
                    return orbit, ""
                why = "the family bends away"
            length *= SHORTER
        return None, why

    def tests(self, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the functions of the orbit whose zeros are special points.

        Those of the multipliers are multiplied by the impact velocities, by which the monodromy
        matrix is divided: so they are smooth through a graze.
        """
        tests: dict[str, float] = {"clearance": min(orbit.grazing_margin, 1e300)}
        into = self.into_stops(orbit)
        for k, speed in enumerate(into):
            tests[f"velocity {k}"] = float(speed)
        determinant = float(np.prod(orbit.multipliers).real)
        if self.n_periods:
            # Conservative families have it all along.
            beyond = determinant - 1.0
            tests["torus"] = beyond if abs(beyond) >= CONSERVATIVE else 0.0
        if self.n == 0:
            return tests
        speeds = [v for (i, _, _), v in zip(self.entries, into, strict=True) if self.walls[i]]
        weight = float(np.prod(speeds))
        trace = float(np.trace(orbit.monodromy))
        if not self.n_periods:
            # One multiplier of free motion is 1 all along; two cycles meet where both are.
            tests["multiplier 1"] = weight * (1.0 - determinant)
            return tests
        tests["multiplier 1"] = weight * (1.0 - trace + determinant)
        tests["multiplier -1"] = weight * (1.0 + trace + determinant)
        if abs(determinant - 1.0) < CONSERVATIVE:
            tests["third"], tests["fourth"] = weight * (1.0 + trace), weight * trace
        return tests

    def test(self, z: Floats, name: str) -> float:
        """Return one of these functions at a point."""
        return self.tests(self.solution(z))[name]

    def enters_soft_stop(self, name: str) -> bool:
        """Return whether a test is the velocity of an entry into a soft stop."""
        return name.startswith("velocity") and not self.walls[self.entries[int(name.split()[1])][0]]

    def size(self, z: Floats) -> float:
        """Return the ratio of the velocities to those of the first orbit, at least 1."""
        return max(1.0, float(np.abs(z[1 + self.n : -1]).max(initial=0.0)))

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        return self.orbit_at(z[:-1], self.values(z))


def stops_that_are_moved(system: System, path: str) -> tuple[str, dict[int, Expression]]:
    """Return the places of the stops that a parameter moves, and its name in these expressions.

    Examples
    --------
    >>> import percuss as pc
    >>> gap = pc.parameter("gap", "0.5")
    >>> system = System(pc.backlash_oscillator(2 * gap, 100), pc.cosine(2))
    >>> name, places = stops_that_are_moved(system, "gap")
    >>> {stop: str(place) for stop, place in places.items()}
    {0: '-2*gap', 1: '2*gap'}
    """
    name, moved = moved_fields(*system, None, path)
    matches = (
        (re.fullmatch(r"oscillator\.stops\.(\d+)\.at", field), moved[field]) for field in moved
    )
    return name, {int(match[1]): place for match, place in matches if match}


def _coincidences(system: System, path: str) -> list[float]:
    """Return the values at which a stop that is moved meets another, places taken as linear."""
    name, moved = stops_that_are_moved(system, path)
    rates = {stop: float(place.derivative(name)) for stop, place in moved.items()}
    places = [as_float(stop.at) for stop in system.oscillator.stops]
    coincidences = []
    for stop, rate in rates.items():
        for other, at in enumerate(places):
            if rate == rates.get(other, 0.0):
                continue
            if moved[stop].is_parameter and other not in moved:
                coincidences.append(at)
            else:
                value = as_float(get_parameter(*system, None, path))
                coincidences.append(value + (at - places[stop]) / (rate - rates.get(other, 0.0)))
    return coincidences
