"""The equations of an orbit over parameters, and families of orbits along one of them."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.kernels.flight import acceleration_and_jerk, constant_force, place, set_phases
from percuss.kernels.law import N_HARMONICS, PERIOD, Law
from percuss.kernels.shooting import AT, ShootingProblem, shoot
from percuss.model.exact import Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.paths import get_parameter, replace_parameters
from percuss.numerics import dot, norm
from percuss.orbits.continuation.correct import WEAK, corrected, tangent_of
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.itinerary import entries_of, entry, is_wall
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import Solution
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.steady import steady_orbit

__all__ = [
    "Family",
    "OrbitEquations",
    "Ranges",
    "checked_range",
    "fastest",
    "own_value",
    "range_about",
    "stop_that_is_moved",
]

Ranges = Mapping[str, tuple[float, float]]

# Where the largest velocity of an orbit is looked for.
INSTANTS = 65
# Systems and laws that are kept: the differences by two parameters take five.
LAWS = 8


def fastest(orbit: PeriodicOrbit) -> float:
    """Return the largest velocity of an orbit, of 65 instants [length/time]."""
    run = orbit.trajectory()
    return float(np.abs(run(np.linspace(run.t0, run.t_end, INSTANTS))[1]).max()) or 1.0


class OrbitEquations:
    """The equations of all orbits with the events of one, over some parameters.

    Parameters
    ----------
    orbit
        One of them.
    ranges
        Lowest and highest value of each parameter by its path; scaled it is from 0 to 1.
    chain
        (n, 3) array, the events, where they are not those of the orbit.

    Attributes
    ----------
    own_values
        Those of the orbit.
    n
        How many events there are; 0 for steady motion in one region, which needs no equations.
    scale, rows
        (2 n + 1,) arrays, units of the unknowns and of the residuals; empty without events.
    entries
        (row of the chain, stop, sign of the velocity before) of the events that meet a stop.
    walls
        Which events are impacts on walls.
    mirror
        What the velocities are multiplied with when the events begin anew.
    """

    mirror = 1.0

    def __init__(self, orbit: PeriodicOrbit, ranges: Ranges, chain: Integers | None = None) -> None:
        self.oscillator, self.forcing = orbit.oscillator, orbit.forcing
        self.paths = tuple(ranges)
        self.lows = tuple(low for low, _ in ranges.values())
        self.highs = tuple(high for _, high in ranges.values())
        self.chain = orbit.itinerary.events if chain is None else chain
        self.n_periods = orbit.n_periods
        own = (get_parameter(self.oscillator, self.forcing, None, path) for path in self.paths)
        self.own_values = tuple(as_float(value) for value in own)
        table = law(orbit.oscillator, orbit.forcing)
        self.shape = table.shape
        self.region = int(orbit.record[1][0, 2]) if len(self.chain) == 0 else -1
        n = self.n = len(self.chain)
        speed = fastest(orbit)
        self.scale = np.repeat([orbit.period, speed], [1 + n, n]) if n else np.empty(0)
        # Distance, velocity after it and, last, time.
        self.rows = np.array([orbit.period * speed, speed] * n + [orbit.period] * min(n, 1))
        self.entries = [(i, stop, entry(self.oscillator, stop).sign)
                     for i, stop in entries_of(self.oscillator, table, self.chain)]  # fmt: skip
        self.walls = is_wall(table, self.chain)
        harmonics = int(table[0, N_HARMONICS])
        self._phases = np.empty((2, harmonics, 2))
        self._systems: dict[tuple[float, ...], tuple[Oscillator, Forcing | None]] = {}
        self._tables: dict[tuple[float, ...], Law] = {}

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

    def system_at(self, values: tuple[float, ...]) -> tuple[Oscillator, Forcing | None]:
        """Return what moves, at values of the parameters."""
        if values not in self._systems:
            if len(self._systems) > LAWS:
                self._systems.pop(next(iter(self._systems)))
            changes = {path: float(value) for path, value in zip(self.paths, values, strict=True)}
            osc, force, _ = replace_parameters(self.oscillator, self.forcing, None, changes)
            self._systems[values] = osc, force
        return self._systems[values]

    def table_at(self, values: tuple[float, ...]) -> Law:
        """Return the law at values of the parameters."""
        if values not in self._tables:
            if len(self._tables) > LAWS:
                self._tables.pop(next(iter(self._tables)))
            table = law(*self.system_at(values))
            if table.shape != self.shape:
                given = values[0] if len(values) == 1 else values
                raise ParameterError(", ".join(self.paths), given, "the stops fall together there")
            self._tables[values] = table
        return self._tables[values]

    def shot(self, unknowns: Floats, table: Law) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns, under a law."""
        size = 2 * self.n + 1 if self.n else 0
        residual, matrix = np.empty(size), np.empty((size, size))
        if self.n == 0:
            return residual, matrix
        period = self.n_periods * float(table[0, PERIOD])
        problem = ShootingProblem(table, self.chain, period, *self._phases)
        # A step that goes astray may overflow: the residual tells.
        with np.errstate(over="ignore", invalid="ignore"):
            given = unknowns * self.scale
            shoot(problem, given, residual, matrix)
            return residual / self.rows, matrix * (self.scale / np.reshape(self.rows, (-1, 1)))

    def orbit_at(self, unknowns: Floats, values: tuple[float, ...]) -> PeriodicOrbit:
        """Return the orbit of a solution."""
        osc, force = self.system_at(values)
        if self.n == 0:
            assert force is not None
            return steady_orbit(osc, force, self.region)
        residual, _ = self.shot(unknowns, self.table_at(values))
        largest = float(np.abs(residual * self.rows).max())
        solution = Solution(unknowns * self.scale, largest, converged=True, isolated=True)
        return orbit_of_solution(osc, force, self.chain, solution, self.n_periods)

    def into_stops(self, orbit: PeriodicOrbit) -> Floats:
        """Return the velocity into each stop with which it is met; negative ones are formal."""
        events, _ = orbit.record
        return np.array([sign * events[i or self.n, 2] for i, _, sign in self.entries])


# Scaled residuals that need not become smaller.
ENOUGH = 1e-15
# Where another family crosses Newton's method gains a factor of two a step only.
MOST_STEPS, MOST_BESIDE_OTHERS = 12, 40
# Scaled step of the central difference by the parameter: h^2 and 1e-16/h are both small.
BESIDE = 1e-5
# Scaled durations that a special point, located to some 1e-12, leaves of no time.
NO_TIME = 1e-6
# Where the parameter makes up this part of a step it is the coordinate; elsewhere arclength is.
MOSTLY_PARAMETER = 0.1
# Steps of the parameter between these give its derivative, as a part of the range, where the
# tangent so found turns no more than by this cosine.
SHORT, LONG, STRAIGHT = 1e-7, 0.05, 0.995
# Least length of a step off a point at which families meet, and by how much of its length it may
# miss the family, so that what it finds is the family that starts there and no other.
LEAST, SHORTER, BENT = 1e-9, 0.25, 0.1
# Determinants this near to 1 are those of conservative motion.
CONSERVATIVE = 1e-12


class Family(OrbitEquations):
    """The orbits with the events of one orbit, as points z = (scaled unknowns, scaled parameter).

    Parameters
    ----------
    orbit
        One of them.
    path
        Path of the parameter.
    low, high
        Its range; scaled it is from 0 to 1.
    """

    noun = "branch"
    order = 1

    def __init__(self, orbit: PeriodicOrbit, path: str, low: float, high: float) -> None:
        super().__init__(orbit, {path: (low, high)})
        self.path, self.low, self.high = path, low, high
        moved = stop_that_is_moved(path)
        stops = enumerate(self.oscillator.stops)
        self._others = [] if moved is None else [as_float(s.at) for k, s in stops if k != moved]
        ends = np.roll(self.chain[:, AT], -1)
        self._returning = [i for i in range(self.n) if self.chain[i, AT] == ends[i]]
        self._hops = [i for i in self._returning if self.walls[i] and self.walls[(i + 1) % self.n]]

    def start(self, orbit: PeriodicOrbit, value: float) -> Floats:
        """Return the point of an orbit."""
        return np.append(self.unknowns_of(orbit), self.part_of(0, value))

    def values(self, z: Floats) -> tuple[float, ...]:
        """Return the parameter of a point."""
        return (self.value(z),)

    def value(self, z: Floats) -> float:
        """Return the parameter of a point."""
        return self.value_at(0, float(z[-1]))

    def system(self, value: float) -> tuple[Oscillator, Forcing | None]:
        """Return what moves, at a value of the parameter."""
        return self.system_at((float(value),))

    def table(self, value: float) -> Law:
        """Return the law at a value of the parameter."""
        return self.table_at((float(value),))

    def residual(self, z: Floats, value: float) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative by the scaled unknowns.

        Distances that a flight misses the bound by that it comes from are told by its duration,
        as a mean velocity: so the equations stay regular where it lasts no time, at a graze or
        where two impacts fall together, and no flight of no time solves them by itself.
        """
        if self.n == 0:
            return np.empty(0), np.empty((0, 0))
        table = self.table(value)
        residual, matrix = self.shot(z[:-1], table)
        if self._returning:
            self._tell_by_duration(table, z, residual, matrix)
        return residual, matrix

    def _tell_by_duration(self, table: Law, z: Floats, residual: Floats, matrix: Floats) -> None:
        """Divide the distances by which flights miss the bound that they come from by durations."""
        # A step that goes astray may overflow; then Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for i in self._returning:
                lasting = float(z[1 + i])
                if lasting == 0.0:
                    # The limit: the velocity at the start, and half the acceleration.
                    residual[2 * i] = z[1 + self.n + i]
                    matrix[2 * i] = 0.0
                    matrix[2 * i, 1 + i] = 0.5 * self._acceleration(table, z, i)
                    matrix[2 * i, 1 + self.n + i] = 1.0
                    continue
                residual[2 * i] /= lasting
                matrix[2 * i] /= lasting
                matrix[2 * i, 1 + i] -= residual[2 * i] / lasting

    def _acceleration(self, table: Law, z: Floats, i: int) -> float:
        """Return the scaled acceleration at the start of a flight."""
        bound, _, region = self.chain[i].tolist()
        phases = np.empty((int(table[0, N_HARMONICS]), 2))
        set_phases(table, float(z[: 1 + i].sum()) * self.scale[0], 0.0, phases)
        force = constant_force(table, region, place(table, region, bound))
        v = float(z[1 + self.n + i]) * self.scale[-1]
        found, _ = acceleration_and_jerk(table, region, force, phases, 0.0, v)
        return float(found * self.scale[0] / self.scale[-1])

    def turns_back(self, here: Floats, found: Floats) -> list[int]:
        """Return the flights between impacts that last less than no time at the second point only.

        Such a flight is no motion: the impacts at its ends have fallen together on the way.
        """
        return [i for i in self._hops if here[1 + i] >= -NO_TIME > found[1 + i]]

    def is_together(self, z: Floats, flights: list[int]) -> bool:
        """Return whether one of some flights lasts no time."""
        return bool(np.abs(z[[1 + i for i in flights]]).min() < NO_TIME)

    def slope(self, z: Floats, known: float | None = None) -> Floats:
        """Return the derivative of the scaled residuals by the scaled parameter.

        With a value whose law is known already it is a difference from there, of first order.
        """
        if self.n == 0:
            return np.empty(0)
        if known is not None:
            apart = (self.value(z) - known) / (self.high - self.low)
            there, here = self.residual(z, known)[0], self.residual(z, self.value(z))[0]
            with np.errstate(over="ignore", invalid="ignore"):
                return np.asarray((here - there) / apart)
        sides = []
        # Not past another stop: there the order of stops is another one.
        others = (abs(self.part_of(0, at) - float(z[-1])) for at in self._others)
        apart = min([BESIDE, *(0.5 * room for room in others if room > 0.0)])
        for q in (z[-1] - apart, z[-1] + apart):
            try:
                sides.append((q, self.residual(z, self.low + q * (self.high - self.low))[0]))
            except ParameterError:
                # On the edge of what the parameter can be: a difference from one side.
                sides.append((float(z[-1]), self.residual(z, self.value(z))[0]))
        (q0, below), (q1, above) = sides
        # Where they are not finite Newton's method ends.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((above - below) / (q1 - q0))

    def corrected(self, guess: Floats, normal: Floats, *, beside_others: bool = False) -> Floats:
        """Return the point of the family in the plane through a guess with this normal.

        Where another family crosses, the direction to it, which the equations hold weakly, can be
        left as the guess has it.

        Raises
        ------
        ConvergenceError
            If Newton's method finds none.
        ParameterError
            If the parameter cannot have the value.
        """
        # The derivative by the parameter is that at the guess; it is none where that is fixed.
        slope = self.slope(guess) if normal[:-1].any() else np.zeros(len(guess) - 1)

        def equations(z: Floats) -> tuple[Floats, Floats]:
            residual, matrix = self.residual(z, self.value(z))
            return residual, np.column_stack([matrix, slope])

        steps = MOST_BESIDE_OTHERS if beside_others else MOST_STEPS
        weak = WEAK if beside_others else 0.0
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

        After a step of the parameter that is neither short nor long its tangent is told by the
        difference of the equations from there, which needs no new law.
        """
        stepped = SHORT < abs(z[-1] - before.z[-1]) < LONG
        known = self.value(before.z) if stepped else None
        orbit = self.solution(z)
        tangent = self.tangent(z, before.tangent, known)
        if stepped and dot(before.tangent, tangent) < STRAIGHT:
            tangent = self.tangent(z, before.tangent)
        return Point(z, tangent, orbit, self.tests(orbit), self)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point with an exact tangent.

        One from a difference may point aside where another family is near.
        """
        return dataclasses.replace(point, tangent=self.tangent(point.z, point.tangent))

    def settle(self, point: Point[Self]) -> None:
        """Keep nothing: Newton's method needs no point near the guess."""

    def plane(self, tangent: Floats) -> Floats:
        """Return the normal of the plane to correct in: the parameter's, where that goes along."""
        fixed = abs(tangent[-1]) > MOSTLY_PARAMETER
        return along_parameter(len(tangent)) if fixed else tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the longest step from a point: as much longer as its velocities are larger."""
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
            Where they meet.
        direction
            Unit vector along this one.
        length
            Of the first step that is tried.
        signs
            On which sides of the start.
        is_wanted
            What the orbit has to be.
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
        """Return the functions whose zeros are special points, as far as the orbit tells them.

        Those of the multipliers carry the product of the impact velocities: the monodromy matrix
        has that in its denominator, and so they are smooth through a graze.
        """
        tests: dict[str, float] = {"passage": min(orbit.grazing_margin, 1e300)}
        into = self.into_stops(orbit)
        for k, speed in enumerate(into):
            tests[f"velocity {k}"] = float(speed)
        if self.n == 0:
            return tests
        speeds = [v for (i, _, _), v in zip(self.entries, into, strict=True) if self.walls[i]]
        weight = float(np.prod(speeds))
        trace = float(np.trace(orbit.monodromy))
        determinant = float(np.prod(orbit.multipliers).real)
        tests["one"] = weight * (1.0 - trace + determinant)
        tests["minus one"] = weight * (1.0 + trace + determinant)
        if abs(determinant - 1.0) < CONSERVATIVE:
            tests["third"], tests["fourth"] = weight * (1.0 + trace), weight * trace
        return tests

    def test(self, z: Floats, name: str) -> float:
        """Return one of these functions at a point."""
        return self.tests(self.solution(z))[name]

    def enters_soft_stop(self, name: str) -> bool:
        """Return whether a test is the velocity into a soft stop: without it none is met."""
        return name.startswith("velocity") and not self.walls[self.entries[int(name.split()[1])][0]]

    def size(self, z: Floats) -> float:
        """Return how much larger the velocities are than those of the first orbit, at least 1."""
        return max(1.0, float(np.abs(z[1 + self.n : -1]).max(initial=0.0)))

    def solution(self, z: Floats) -> PeriodicOrbit:
        """Return the orbit of a point."""
        return self.orbit_at(z[:-1], self.values(z))


def own_value(orbit: PeriodicOrbit, path: str) -> float:
    """Return the value that a parameter has in the system of an orbit."""
    return as_float(get_parameter(orbit.oscillator, orbit.forcing, None, path))


def range_about(
    value: float, path: str, given: tuple[Phase, Phase], whose: str
) -> tuple[float, float]:
    """Return the ends of the range of a parameter, which has to hold its own value."""
    try:
        first, last = (as_float(end) for end in given)
    except (TypeError, ValueError) as error:
        raise ParameterError(path, given, "not a range of two numbers") from error
    if first == last or not min(first, last) <= value <= max(first, last):
        reason = f"no range that holds the {whose}'s own value {value:.12g}"
        raise ParameterError(path, given, reason)
    return first, last


def checked_range(
    orbit: PeriodicOrbit, over: Mapping[str, tuple[Phase, Phase]], *, may_stick: bool = False
) -> tuple[str, float, float, float]:
    """Return the path, the range and the orbit's own value.

    Raises
    ------
    ParameterError
        If there is no such parameter, the range does not hold the orbit's value, or the orbit is
        one of a family in one system or sticks, where it may not.
    """
    if len(over) != 1:
        raise ParameterError("over", over, "not one parameter and its range")
    ((path, given),) = over.items()
    value = own_value(orbit, path)
    first, last = range_about(value, path, given, "orbit")
    if math.isinf(orbit.n_impacts) and not may_stick:
        reason = "it sticks, and after a release nothing doubles; continue_orbit follows it"
        raise ParameterError("orbit", orbit, reason)
    if not orbit.isolated:
        raise ParameterError("orbit", orbit, "one of a family in one system; nothing tells which")
    return path, first, last, value


def stop_that_is_moved(path: str) -> int | None:
    """Return the index of the stop whose position a path names, None for another parameter.

    Examples
    --------
    >>> stop_that_is_moved("oscillator.stops.1.at")
    1
    """
    found = re.fullmatch(r"oscillator\.stops\.(\d+)\.at", path)
    return int(found[1]) if found else None
