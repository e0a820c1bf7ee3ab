"""Orbits of a structure that meet walls in a given order, through grazes and as formal orbits.

The map over the period has no derivative where a wall is grazed. Here the order of the impacts is
given, their instants are unknowns as well as the state, and flights pass through walls otherwise:
these equations are smooth where the velocity of an impact goes through zero
(docs/theory/structures.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError
from percuss.kernels.record import (
    KIND,
)
from percuss.model.acting_sets import StructureSystem
from percuss.model.moved_law import moved_period
from percuss.model.moved_structure import moved_structure
from percuss.model.oscillator import Wall
from percuss.model.paths import long_form
from percuss.numerics import determinant, dot, matmul, solve_linear
from percuss.orbits.bifurcations.borders import Bordered
from percuss.orbits.bifurcations.branch_equations import NO_TIME
from percuss.orbits.bifurcations.force_jumps import Crossing
from percuss.orbits.bifurcations.jumps_of_loads import JumpsOfLoads
from percuss.orbits.bifurcations.open_flights import (
    APART,
    IN_TURN,
    SLOW,
    MetStop,
    OpenFlight,
    StructureGraze,
    is_motion,
    least_clearance,
    met_at,
    moved_end,
    open_flight,
    paths_of_flights,
    soft_stops,
    state_at_zero,
    whole_record,
    without_walls,
)
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.orbits.bifurcations.structure_branch import (
    StructureEquations,
    tests_of_matrix,
)
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.structure_orbit import (
    PeriodMap,
    StructureOrbit,
    derivative_at,
    orbit_of_map,
    period_of,
)

# Impacts of an orbit whose instants are unknowns; with more its map over the period serves.
MOST_IMPACTS = 40
# The condition of a graze.
GRAZE = "graze"


def meets_walls_in_turn(orbit: StructureOrbit) -> bool:
    """Return whether an orbit of a structure with walls has few impacts, each at its own instant."""
    run = orbit.run
    if not any(isinstance(stop, Wall) for stop in orbit.structure.stops) or len(run.contacts):
        return False
    t = run.impacts.t
    if len(t) > MOST_IMPACTS or not np.isin(run.record.marks[:, KIND], IN_TURN).all():
        return False
    gaps = np.diff(np.append(t, t[:1] + orbit.period))
    return bool((gaps > APART * orbit.period).all())


@dataclass(frozen=True, slots=True)
class WallMotion:
    """The motion from just after the first impact to just after it, a period later.

    Attributes
    ----------
    flights
        The flights; each ends at an impact, the only one of a motion without impacts at its period.
    residual, derivative
        What is to be zero, scaled, (2 n + k,): by how much the state does not come back, and the
        clearances at the impacts; and its derivative by the state, scaled, and the instants in
        periods.
    speeds
        (k,) velocities into the walls, in the order of the unknowns.
    """

    flights: tuple[OpenFlight, ...]
    residual: Floats
    derivative: Floats
    speeds: Floats


class WallEquations(StructureEquations, Bordered):
    """The equations of orbits that meet walls in a given order.

    The unknowns are the state after the first impact, in units of the first orbit's size, the
    instants of the impacts, in periods, and the parameters; of an orbit without impacts the state
    at t = 0. A stop that is touched besides counts as an impact that changes nothing.
    """

    def __init__(
        self,
        orbit: StructureOrbit,
        ranges: Mapping[str, tuple[float, float]],
        condition: str | None = None,
        graze: StructureGraze | None = None,
    ) -> None:
        super().__init__(orbit, ranges, condition)
        impacts, self.graze = orbit.run.impacts, graze
        contacts = list(zip(impacts.t.tolist(), impacts.stop.tolist(), strict=True))
        speeds = np.abs(impacts.v_before).tolist()
        if graze is not None:
            near = APART * orbit.period
            kept = [k for k, (t, _) in enumerate(contacts) if abs(t - graze.t) > near]
            contacts, speeds = [contacts[k] for k in kept], [speeds[k] for k in kept]
            contacts.append((graze.t, graze.stop))
            # It is the first where there is no impact.
            speeds.append(0.0)
        # The fastest comes first: its own graze comes last.
        first = contacts[int(np.argmax(speeds))][0] if contacts else 0.0
        contacts = sorted((t + orbit.period if t < first else t, stop) for t, stop in contacts)
        self.instants = np.array([t for t, _ in contacts])
        self.walls = tuple(stop for _, stop in contacts)
        late = None if graze is None else graze.t + (orbit.period if graze.t < first else 0.0)
        self.grazed = -1 if late is None else self.instants.tolist().index(late)
        self.jumps = JumpsOfLoads.of(StructureSystem.of(orbit.structure, orbit.loads))
        self.opened_at = lru_cache(16)(self._opened)
        self.take_scale(np.concatenate([self.units, np.ones(len(self.walls))]))

    def take_scale(self, scale: Floats) -> None:
        """Begin anew with unknowns of this scale, without the parameters."""
        super().take_scale(scale)
        self.cyclic = slice(len(self.units), self.size)
        self.motions = lru_cache(32)(self._motion)

    def _opened(self, system: StructureSystem) -> StructureSystem:
        """Return the same structure without its walls, and without a soft stop that is touched."""
        grazed = -1 if self.graze is None else self.graze.stop
        return without_walls(system, grazed)

    @property
    def kinds(self) -> Mapping[str, SpecialPointKind]:
        """The kinds of special points by the names of their tests."""
        speeds: dict[str, SpecialPointKind] = {
            f"velocity {i}": "grazing" for i in range(len(self.walls))
        }
        return {**super().kinds, "clearance": "grazing", **speeds}

    @property
    def of_motions(self) -> tuple[str, ...]:
        """The tests at whose zeros motions become formal orbits: zeros among these are none."""
        return ("clearance", *(f"velocity {i}" for i in range(len(self.walls))))

    def unknowns(self, orbit: StructureOrbit) -> Floats:
        """Return the unknowns of an orbit."""
        if not self.walls:
            return super().unknowns(orbit)
        state = np.concatenate(orbit.run(float(self.instants[0]), limit="after"))
        return np.concatenate([state / self.units, self.instants / orbit.period])

    def simpler(self, orbit: StructureOrbit) -> Self | None:
        """Return the equations of the orbits from which a family originates, None if it cannot."""
        half, k = super().simpler(orbit), len(self.walls) // 2
        if self.origin == "mirrored":
            return half if len(self.walls) == 2 * k else None
        if half is None or self.walls[:k] != self.walls[k:]:
            return None
        half.walls, half.instants = self.walls[:k], self.instants[:k]
        half.take_scale(self.scale[: len(self.units) + k])
        half.recentre(None)
        return half

    def once(self, z: Floats) -> Floats:
        """Return the point of the simpler equations near one: of the half, or its mirrored mean."""
        state, instants, parameters = np.split(z, [len(self.units), self.size])
        k = len(instants) // 2
        if self.origin == "doubled":
            return np.concatenate([state, 2.0 * instants[:k], parameters])
        if k == 0:
            return super().once(z)
        half = self.motions(tuple(z.tolist())).flights[k].start / self.units
        first = 0.5 * (instants[:k] + instants[k:] - 0.5)
        return np.concatenate([0.5 * (state - half), first, first + 0.5, parameters])

    def twice(self, z: Floats) -> Floats:
        """Return the orbit of a point of the simpler equations as a point of these."""
        if self.origin == "mirrored":
            return z
        state, instants, parameters = np.split(z, [len(self.units), len(z) - len(self.paths)])
        return np.concatenate([state, 0.5 * instants, 0.5 * instants + 0.5, parameters])

    def coincide(self, here: Floats, new: Floats) -> bool:
        """Return whether two impacts on one wall come to one instant from a point to the next.

        There their velocities vanish, and so do the derivatives of their clearances: any instant
        near is a solution to rounding.
        """
        first, k = len(self.units), len(self.walls)
        before, after = (
            np.diff(z[first : first + k], append=z[first : first + 1] + 1.0) for z in (here, new)
        )
        return any(
            wall == following and b < a and b < NO_TIME
            for wall, following, a, b in zip(
                self.walls,
                (*self.walls[1:], *self.walls[:1]),
                before.tolist(),
                after.tolist(),
                strict=True,
            )
        )

    def closure(self, z: Floats) -> tuple[Floats, Floats]:
        """Return the scaled residuals of a point, and their derivative without the parameters."""
        motion = self.motions(tuple(z.tolist()))
        return motion.residual, motion.derivative

    def recentre(self, point: Point[Self] | None) -> None:
        """Take a point as that whose side of the borders `corrected` keeps to; None for any side."""
        self.border = None
        self.centre = point.z if point is not None and len(self.jumps.cycles) else None

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:
        """Return the solution in the plane through a guess, on this side of any border.

        Raises
        ------
        BorderError
            If an impact passes a jump of the loads on the way from the centre.
        """
        alone = self.condition is None
        try:
            z = super().corrected(guess, normal, near_others=near_others)
        except ConvergenceError:
            self.check_border(guess, is_located=alone)
            raise
        self.check_border(z, is_located=alone)
        return z

    def _cycles(self, z: Floats) -> Floats:
        """Return the instants of the impacts, in periods of the loads."""
        return z[len(self.units) : self.size] * self.n_periods

    def passed(self, z: Floats) -> Integers:
        """Return the number of jumps of the loads before each impact."""
        return self.jumps.passed(self._cycles(z))

    def missed(self, z: Floats) -> Floats:
        """Return the residuals of a point."""
        return self.closure(z)[0]

    def beyond_jump(self, z: Floats, crossing: Crossing) -> float:
        """Return by how much of the period an impact lies after a jump of the loads."""
        at = self.jumps.instant(crossing.jump)
        return float(self._cycles(z)[crossing.event] - at) / self.n_periods

    def slope_of_border(self, z: Floats, crossing: Crossing) -> Floats:
        """Return the derivative of `beyond_jump` by a point: jumps stay where they are in a period."""
        return along_parameter(len(z), len(self.units) + crossing.event)

    def shifted(self, z: Floats, shifts: Floats) -> Floats:
        """Return a point with its impacts shifted by parts of the period."""
        moved = z.copy()
        moved[len(self.units) : self.size] += shifts
        return moved

    def derivatives(self, z: Floats) -> Floats:
        """Return the derivatives of the residuals by a point; nothing that is known changes."""
        kept = self.known, self.last, self.by_parameters
        self._take_derivatives(z, self.first)
        matrix = self.residual(z)[1]
        self.known, self.last, self.by_parameters = kept
        return matrix

    def halves_differ(self, orbit: StructureOrbit) -> float:  # noqa: ARG002
        """Return infinity: the doubled orbits of structures are not compared."""
        return math.inf

    def jumps_at(self, event: int, z: Floats) -> bool:
        """Return whether the load that jumps at an impact next to a jump pushes on its wall."""
        return self.jumps.pushes(self._cycles(z)[event], self.walls[event])

    def exact_derivatives(self, z: Floats, orbit: StructureOrbit) -> Floats | None:  # noqa: ARG002
        """Return how the state after a period, and the clearances, depend on the parameters.

        At fixed instants in periods. None for parameters that move an impact itself, whose
        equations are smooth; and where a flight has no derivative.
        """
        system = self.system_at(self.values(z))
        grazed = -1 if self.graze is None else self.graze.stop
        names = [long_form(path, self.first.structure, self.first.loads) for path in self.paths]
        paths = paths_of_flights(names, soft_stops(system, grazed))
        if paths is None:
            return None
        opened, motion = self.opened_at(system), self.motions(tuple(z.tolist()))
        rates = np.array([loads.rates for loads in moved_structure(opened, None, paths).loads])
        slower = moved_period(rates.T, opened.structure, opened.loads, paths)
        if not np.isfinite(slower).all():
            # The period is that of several loads, and no function of one of them.
            return None
        n2, k = len(self.units), len(self.walls)
        here, gaps, n = np.zeros((n2, len(paths))), np.zeros((k, len(paths))), n2 // 2
        for i, flight in enumerate(motion.flights):
            moved = moved_end(opened, flight, paths, here, slower)
            if moved is None:
                return None
            here = moved
            if k:
                j = (i + 1) % k
                wall = self._met(system, j)
                gaps[j] = matmul(wall.normal[None, :], here[:n])[0]
                of_speed = -matmul(wall.normal[None, :], here[n:])[0]
                _, kept = wall.restitution(motion.speeds[j])
                here[n:] += (1.0 + kept) * wall.kick[:, None] * of_speed
        return np.concatenate([here, gaps / float(self.units[0])])

    def conditions(self, z: Floats) -> Mapping[str, float]:
        """Return functions of a point that are zero at special points."""
        motion = self.motions(tuple(z.tolist()))
        speeds = motion.speeds / float(self.units[-1])
        if self.graze is not None:
            return {GRAZE: float(speeds[self.grazed])}
        of_matrix = tests_of_matrix(self._of_map(motion))
        return of_matrix | {
            "multiplier 1": determinant(motion.derivative),
            "multiplier -1": of_matrix["multiplier -1"] * float(np.prod(speeds)),
        }

    def _of_map(self, motion: WallMotion) -> Floats:
        """Return the derivative of the map over the period, from the first impact on.

        With the instants eliminated, the state moves by N s in a period, if the first impact is as
        late at its end as at its beginning, by -b . s. At a fixed time the state is then
        s + a b . s, of the rate of change a after the impact: the map moves that by N s.
        """
        matrix, n = motion.derivative, len(self.units)
        moved = matrix[:n, :n]
        if self.walls:
            later = solve_linear(matrix[n:, n:], matrix[n:, :n])
            moved = moved - matmul(matrix[:n, n:], later)
            first, last = motion.flights[0], motion.flights[-1]
            rate = first.after * (last.end - first.begin) / self.units
            along = matmul(moved, rate[:, None])
            moved = moved - along * later[:1] / (1.0 + dot(later[0], rate))
        return moved + np.eye(n)

    def _motion(self, z: tuple[float, ...]) -> WallMotion:
        point = np.array(z)
        system = self.system_at(self.values(point))
        opened, period = self.opened_at(system), self.n_periods * period_of(system)
        n2, k = len(self.units), len(self.walls)
        state, instants = point[:n2] * self.units, point[n2 : n2 + k] * period
        moved = np.zeros((n2, n2 + k))
        moved[:, :n2] = np.diag(self.units)
        here, flights, gaps, of_gaps = state, [], np.zeros(k), np.zeros((k, n2 + k))
        speeds = np.zeros(k)
        begins = instants if k else np.zeros(1)
        ends = np.append(begins[1:], begins[0] + period)
        for i, (begin, end) in enumerate(zip(begins.tolist(), ends.tolist(), strict=True)):
            flight = open_flight(opened, here, begin, end)
            flights.append(flight)
            here = flight.image
            if k == 0:
                moved = matmul(flight.derivative, moved)
                break
            moved[:, n2 + i] -= flight.after * period
            moved = matmul(flight.derivative, moved)
            j = (i + 1) % k
            moved[:, n2 + j] += flight.before * period
            wall = self._met(system, j)
            n = n2 // 2
            gaps[j] = float((wall.normal * here[:n]).sum()) - wall.level
            of_gaps[j] = matmul(wall.normal[None, :], moved[:n])[0]
            speeds[j] = -float((wall.normal * here[n:]).sum())
            of_speed = -matmul(wall.normal[None, :], moved[n:])[0]
            ratio, kept = wall.restitution(speeds[j])
            here = here.copy()
            here[n:] += (1.0 + ratio) * speeds[j] * wall.kick
            moved[n:] += (1.0 + kept) * wall.kick[:, None] * of_speed
        moved[:, :n2] -= np.diag(self.units)
        length = float(self.units[0])
        return WallMotion(
            tuple(flights),
            np.concatenate([(here - state) / self.units, gaps / length]),
            np.concatenate([moved / self.units[:, None], of_gaps / length]),
            speeds,
        )

    def _met(self, system: StructureSystem, i: int) -> MetStop:
        """Return the stop of an impact, or of the graze, which changes no velocity."""
        met = met_at(system, self.walls[i])
        return met._replace(law=None) if i == self.grazed else met

    def solution(self, z: Floats) -> StructureOrbit:
        """Return the orbit of a solution, which may be formal."""
        motion = self.motions(tuple(z.tolist()))
        system = self.system_at(self.values(z))
        period = self.n_periods * period_of(system)
        # Rounding may leave the last instants of a period on its other side.
        instants = [flight.end % period for flight in motion.flights] if self.walls else []
        order = sorted(range(len(instants)), key=instants.__getitem__)
        met = [(i + 1) % len(self.walls) for i in order]
        passage = [
            (instants[i], self.walls[j])
            for i, j in zip(order, met, strict=True)
            if j != self.grazed
        ]
        opened = self.opened_at(system)
        state = (
            state_at_zero(opened, motion.flights, period) if self.walls else motion.flights[0].start
        )
        grazed = -1 if self.graze is None else self.graze.stop
        soft = soft_stops(system, grazed)
        record, image = whole_record(system, (opened, soft), state, passage, period)
        whole = PeriodMap(image, derivative_at(record, period), record)
        error = float(np.abs(motion.residual).max()) / max(1.0, float(np.abs(z).max()))
        speeds = np.delete(motion.speeds, [self.grazed]) if self.grazed >= 0 else motion.speeds
        slow = SLOW * float(self.units[-1]) if self.grazed >= 0 else 0.0
        admissible = bool((speeds > 0.0).all()) and is_motion(system, state, passage, period, slow)
        return orbit_of_map(system, state, self.n_periods, whole, error, admissible=admissible)

    def tests(self, z: Floats, orbit: StructureOrbit) -> Mapping[str, float]:
        """Return functions that are zero, or jump, at special points, by their names.

        The monodromy grows beyond all bounds where a velocity goes to zero: multiplied by it, what
        is asked of its eigenvalues stays smooth.
        """
        motion = self.motions(tuple(z.tolist()))
        speeds = motion.speeds / float(self.units[-1])
        of_matrix = tests_of_matrix(orbit.monodromy)
        entries = int((orbit.run.crossings.direction == "in").sum())
        return {
            "multiplier 1": determinant(motion.derivative),
            "multiplier -1": of_matrix["multiplier -1"] * float(np.prod(speeds)),
            "torus": of_matrix["torus"] if orbit.admissible else math.nan,
            "contacts": float(entries),
            "clearance": least_clearance(orbit) / float(self.units[0]),
            **{f"velocity {i}": float(speed) for i, speed in enumerate(speeds)},
        }
