"""Orbits of a structure that meet walls in a given order, through grazes and as formal orbits.

The map over the period has no derivative where a wall is grazed. Here the order of the impacts is
given, their instants are unknowns as well as the state, and flights pass through walls otherwise:
these equations are smooth where the velocity of an impact goes through zero
(docs/theory/structures.md).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ConvergenceError, ParameterError
from percuss.kernels.record import (
    BOUND,
    CROSSING,
    EVENT_T,
    EVENT_T_LOW,
    IMPACT,
    KIND,
    KNOT,
    N_EVENTS,
    NEXT_REGION,
    START,
    V_AFTER,
    V_BEFORE,
)
from percuss.kernels.restitution import kept_of_error, restitution_at
from percuss.kernels.structure.basis import wall_of
from percuss.kernels.structure.run import StructureRun, new_run
from percuss.kernels.structure.sensitivity import rates_at
from percuss.kernels.structure.tangent import carry_run
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.faults import draft
from percuss.model.moved_law import moved_period
from percuss.model.moved_structure import moved_structure
from percuss.model.oscillator import SoftStop, Wall
from percuss.model.paths import long_form
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.follow_structure import followed
from percuss.motion.structure_sensitivity import structure_sensitivity_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.numerics import determinant, dot, matmul, solve_linear
from percuss.orbits.bifurcations.borders import Bordered
from percuss.orbits.bifurcations.branch_equations import NO_TIME
from percuss.orbits.bifurcations.force_jumps import Crossing
from percuss.orbits.bifurcations.jumps_of_loads import JumpsOfLoads
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.orbits.bifurcations.structure_branch import (
    StructureEquations,
    tests_of_matrix,
)
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.structure_orbit import (
    MOST_EVENTS,
    PeriodMap,
    StructureOrbit,
    map_between,
    orbit_of_map,
    period_of,
)

__all__ = ["GRAZE", "StructureGraze", "WallEquations", "graze_of", "meets_walls_in_turn"]

# The events of orbits that neither stick nor land at rest.
IN_TURN = (START, IMPACT, CROSSING, KNOT)
# Impacts of an orbit whose instants are unknowns; with more its map over the period serves.
MOST_IMPACTS = 40
# Parts of the period: impacts nearer than the first come at one instant; instants of a motion and
# of its formal double differ by less than the second.
APART, ALIKE = 1e-9, 1e-6
# Instants of a flight at which its clearances are looked at, and steps to their least values.
LOOKED, REFINED = 48, 4
# The condition of a graze; speeds below this part of the unit are none at a graze.
GRAZE, SLOW = "graze", 1e-5
# How paths begin whose parameters move flights, and no impact.
OF_FLIGHTS = ("loads.", "structure.stiffness.", "structure.damping.")
# How long a flight lasts, in words.
UNTIL = "until its next impact"
# Clearances below this part of the unit of length are rounding.
ROUNDED = 1e-12


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


class OpenFlight(NamedTuple):
    """A flight that passes through walls.

    ``start`` and ``image`` are the states (x, v), (2 n,), at its instants; ``derivative`` that of
    the second by the first, and ``before``, ``after`` their rates of change.
    """

    begin: float
    end: float
    start: Floats
    image: Floats
    derivative: Floats
    after: Floats
    before: Floats
    record: StructureRun


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


class StructureGraze(NamedTuple):
    """A stop that an orbit touches at an instant without velocity."""

    stop: int
    t: float


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
        self.motions = lru_cache(32)(self._motion)

    def _opened(self, system: StructureSystem) -> StructureSystem:
        """Return the same structure without its walls, and without a soft stop that is touched."""
        grazed = -1 if self.graze is None else self.graze.stop
        return _without(system, grazed)

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
        paths = _paths_of_flights(names, _soft_stops(system, grazed))
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
            moved = _moved_end(opened, flight, paths, here, slower)
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
        late at its end as at its beginning, by -b . s. At a fixed time the state is then s + a b .
        s, of the rate of change a after the impact: the map moves that by N s.
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
            flight = _open_flight(opened, here, begin, end)
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

    def _met(self, system: StructureSystem, i: int) -> _Met:
        """Return the stop of an impact, or of the graze, which changes no velocity."""
        met = _met_at(system, self.walls[i])
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
            _state_at_zero(opened, motion.flights, period)
            if self.walls
            else motion.flights[0].start
        )
        grazed = -1 if self.graze is None else self.graze.stop
        soft = _soft_stops(system, grazed)
        record, image = _whole_record(system, (opened, soft), state, passage, period)
        matrix = np.zeros((2, len(state) // 2, len(state)))
        n = len(state) // 2
        matrix[0, :, :n], matrix[1, :, n:] = np.eye(n), np.eye(n)
        carry_run(record, period, matrix, np.zeros((n, 2, 2 * n)), np.zeros((2, 2, n)))
        whole = PeriodMap(image, matrix.reshape(2 * n, 2 * n), record)
        error = float(np.abs(motion.residual).max()) / max(1.0, float(np.abs(z).max()))
        speeds = np.delete(motion.speeds, [self.grazed]) if self.grazed >= 0 else motion.speeds
        slow = SLOW * float(self.units[-1]) if self.grazed >= 0 else 0.0
        admissible = bool((speeds > 0.0).all()) and _is_motion(system, state, passage, period, slow)
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
            "clearance": _least_clearance(orbit) / float(self.units[0]),
            **{f"velocity {i}": float(speed) for i, speed in enumerate(speeds)},
        }


class _Met(NamedTuple):
    """A stop as an impact has it: its clearance is normal . x - level; a jump goes along kick.

    A stop that is only touched has no law.
    """

    normal: Floats
    level: float
    kick: Floats
    law: Floats | None
    place: tuple[int, int]

    def restitution(self, speed: float) -> tuple[float, float]:
        """Return the restitution at a speed, and the derivative of the speed that is kept."""
        if self.law is None:
            # A velocity that is turned into its opposite, and that once more: it stays.
            return -1.0, -1.0
        real = max(speed, 0.0)
        return (
            float(restitution_at(self.law, *self.place, real)),
            float(kept_of_error(self.law, *self.place, real)),
        )


@lru_cache(128)
def _met_at(system: StructureSystem, stop: int) -> _Met:
    structure = system.structure
    sign, c = float(system.signs[stop]), structure.stop_directions[stop]
    along = solve_linear(structure.mass_matrix, c)
    own = structure.stops[stop]
    is_wall = isinstance(own, Wall)
    return _Met(
        sign * c,
        sign * as_float(own.at),
        sign * along / float((c * along).sum()),
        system.sets.walls[stop] if is_wall else None,
        wall_of(system.sets, stop) if is_wall else (0, 0),
    )


def _without(system: StructureSystem, grazed: int) -> StructureSystem:
    """Return the same structure without its walls, and without another stop."""
    structure = system.structure
    fields = {field.name: getattr(structure, field.name) for field in dataclasses.fields(structure)}
    soft = tuple(structure.stops[i] for i in _soft_stops(system, grazed))
    return StructureSystem.of(draft(Structure, **fields | {"stops": soft}), system.loads)


def _soft_stops(system: StructureSystem, grazed: int) -> list[int]:
    """Return the numbers of the soft stops that an opened structure keeps."""
    stops = enumerate(system.structure.stops)
    return [i for i, stop in stops if isinstance(stop, SoftStop) and i != grazed]


def _open_flight(opened: StructureSystem, start: Floats, begin: float, end: float) -> OpenFlight:
    """Return a flight of a structure without walls.

    Raises
    ------
    ConvergenceError
        If it lasts no time, or does not end.
    """
    n = len(start) // 2
    if not end > begin:
        raise ConvergenceError("two impacts change their order", start, math.nan, "")
    period = opened.period or 0.0
    shift = math.floor(begin / period) * period
    first, last = begin - shift, end - shift
    image, derivative, record = map_between(opened, start, (first, last), UNTIL)
    after, before = np.empty((2, n)), np.empty((2, n))
    rates_at(record, first, True, after)
    rates_at(record, last, True, before)
    return OpenFlight(
        begin,
        end,
        start,
        image,
        derivative,
        after.reshape(-1),
        before.reshape(-1),
        record,
    )


def _paths_of_flights(paths: Sequence[str], soft: Sequence[int]) -> tuple[str, ...] | None:
    """Return paths of parameters in the structure without walls, None if they move walls too.

    It keeps the soft stops with the given numbers.
    """
    within = []
    for path in paths:
        own = path
        if path.startswith("structure.stops."):
            _, _, stop, *rest = path.split(".")
            if int(stop) not in soft:
                return None
            own = ".".join(["structure.stops", str(soft.index(int(stop))), *rest])
        elif not path.startswith(OF_FLIGHTS):
            return None
        within.append(own)
    return tuple(within)


def _moved_end(
    opened: StructureSystem,
    flight: OpenFlight,
    paths: Sequence[str],
    start: Floats,
    slower: Floats,
) -> Floats | None:
    """Return the derivatives of a flight's end from those of its start, both (2 n, n_parameters).

    Its instants stay where they are in the period of the loads, whose logarithm's derivatives are
    given. None where it has no derivative.
    """
    n, record = len(start) // 2, flight.record
    period = opened.period or 0.0
    shift = math.floor(flight.begin / period) * period
    first, last = flight.begin - shift, flight.end - shift
    begin = StructureStart(flight.start[:n].tolist(), flight.start[n:].tolist(), first)
    run = StructureTrajectory.of_run(opened, begin, record, last, Outcome.reached_t_end)
    moved = structure_sensitivity_of(run, paths, np.vstack([start, first * slower]))
    if not moved.differentiable:
        return None
    end = np.concatenate(moved(last, limit="before")) + flight.before[:, None] * last * slower
    return end if np.isfinite(end).all() else None


def _state_at_zero(opened: StructureSystem, flights: Sequence[OpenFlight], period: float) -> Floats:
    """Return the state at whole periods, at which one of the flights passes."""
    for flight in flights:
        whole = math.ceil(flight.begin / period) * period
        if flight.begin < whole < flight.end:
            return _open_flight(opened, flight.start, flight.begin, whole).image
    # An impact at this very instant: the state after it.
    return min(
        flights,
        key=lambda candidate: abs(candidate.begin / period - round(candidate.begin / period)),
    ).start


def _whole_record(
    system: StructureSystem,
    without: tuple[StructureSystem, Sequence[int]],
    state: Floats,
    passage: Sequence[tuple[float, int]],
    period: float,
) -> tuple[StructureRun, Floats]:
    """Return the record of a motion over a period that meets walls at given instants, and its end.

    The opened structure comes with the numbers that its stops have among all.
    """
    opened, soft = without
    n, here, begin = len(state) // 2, state, 0.0
    parts: list[StructureRun] = []
    struck: list[tuple[int, float, float]] = []
    for end, stop in [*passage, (period, -1)]:
        if not end > begin:
            if not parts:
                continue
            raise ConvergenceError("two impacts change their order", here, math.nan, "")
        # From its own instant, in whichever period of the loads: the record is that of a run.
        here, _, record = map_between(opened, here, (begin, end), UNTIL, derivative=False)
        parts.append(record)
        begin = end
        if stop < 0:
            break
        wall = _met_at(system, stop)
        speed = -float((wall.normal * here[n:]).sum())
        rebound = wall.restitution(speed)[0] * speed
        here = here.copy()
        here[n:] += (speed + rebound) * wall.kick
        struck.append((stop, -speed, rebound))
    events, marks, states, sets = [], [], [], []
    for k, record in enumerate(parts):
        own = record.marks.copy()
        bounds = own[:, BOUND]
        own[:, BOUND] = [soft[i] if 0 <= i < len(soft) else i for i in bounds.tolist()]
        keys = [_widened(int(record.sets.keys[b]), soft) for b in own[:, NEXT_REGION].tolist()]
        row = record.events.copy()
        if k:
            stop, before, after = struck[k - 1]
            own[0, KIND], own[0, BOUND] = IMPACT, stop
            row[0, V_BEFORE], row[0, V_AFTER] = before, after
        events.append(row)
        marks.append(own)
        states.append(record.states)
        sets.append(keys)
    system.add(*(key for keys in sets for key in keys))
    index = {key: b for b, key in enumerate(system.sets.keys.tolist())}
    for own, keys in zip(marks, sets, strict=True):
        own[:, NEXT_REGION] = [index[key] for key in keys]
    whole = new_run(system.sets, 1)._replace(
        events=np.concatenate(events), marks=np.concatenate(marks), states=np.concatenate(states)
    )
    whole.counters[N_EVENTS] = len(whole.events)
    return whole, here


def _widened(key: int, soft: Sequence[int]) -> int:
    """Return the bits of a set with the numbers that soft stops have among all."""
    return sum(1 << i for k, i in enumerate(soft) if key >> k & 1)


def _is_motion(
    system: StructureSystem,
    state: Floats,
    passage: Sequence[tuple[float, int]],
    period: float,
    slow: float,
) -> bool:
    """Return whether the structure with its walls has the impacts of a formal motion, and no other.

    Impacts at lower speeds than ``slow`` count as none.
    """
    n = len(state) // 2
    for stop, wall in enumerate(system.structure.stops):
        if isinstance(wall, Wall):
            own = _met_at(system, stop)
            gap = float((own.normal * state[:n]).sum()) - own.level
            if gap < -ROUNDED * max(1.0, float(np.abs(state[:n]).max())):
                return False
    record, outcome = followed(system, (state[:n], state[n:], 0.0), period, MOST_EVENTS)
    if outcome is not Outcome.reached_t_end:
        return False
    kinds = record.marks[:, KIND]
    if not np.isin(kinds, IN_TURN).all():
        return False
    struck = np.flatnonzero((kinds == IMPACT) & (np.abs(record.events[:, V_BEFORE]) > slow))
    t = record.events[struck, EVENT_T] + record.events[struck, EVENT_T_LOW]
    inner = [(at, stop) for at, stop in passage if APART < at / period < 1.0 - APART]
    met = [
        (at, stop)
        for at, stop in zip(t.tolist(), record.marks[struck, BOUND].tolist(), strict=True)
        if APART < at / period < 1.0 - APART
    ]
    return len(met) == len(inner) and all(
        a[1] == b[1] and abs(a[0] - b[0]) < ALIKE * period for a, b in zip(met, inner, strict=True)
    )


def _least_clearance(orbit: StructureOrbit) -> float:
    """Return the least clearance to a wall at which the structure turns between impacts."""
    walls = [i for i, stop in enumerate(orbit.structure.stops) if isinstance(stop, Wall)]
    return _turns(orbit, walls)[0]


def _turns(orbit: StructureOrbit, stops: Sequence[int]) -> tuple[float, StructureGraze | None]:
    """Return the least clearance to one of some stops at which the structure turns, and where."""
    run = orbit.run
    ends = np.concatenate([[0.0], run.impacts.t, [run.t_end]])
    least, place = math.inf, None
    for stop in stops:
        own = _met_at(run.system, stop)
        for begin, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
            if end - begin > APART * run.t_end:
                gap, t = _least_in_flight(run, own, begin, end)
                if gap < least:
                    least, place = gap, StructureGraze(stop, t)
    return least, place


def graze_of(orbit: StructureOrbit) -> StructureGraze:
    """Return where an orbit at a graze touches a stop: at an impact without velocity, or a turn.

    Raises
    ------
    ParameterError
        If it touches none.
    """
    impacts, structure = orbit.run.impacts, orbit.structure
    _, v = orbit.run(np.linspace(0.0, orbit.period, 65))
    unit = float(np.abs(v).max())
    if len(impacts):
        k = int(np.argmin(np.abs(impacts.v_before)))
        size = float(np.abs(structure.stop_directions[int(impacts.stop[k])]).sum())
        if abs(float(impacts.v_before[k])) < SLOW * unit * size:
            return StructureGraze(int(impacts.stop[k]), float(impacts.t[k]))
    entered = orbit.run.crossings
    grazes = []
    for stop in range(len(structure.stops)):
        gap, place = _turns(orbit, [stop])
        if place is not None:
            grazes.append((abs(gap), place))
        slow = (entered.stop == stop) & (np.abs(entered.v) < math.sqrt(SLOW) * unit)
        if slow.any():
            grazes.append((0.0, StructureGraze(stop, float(entered.t[slow].mean()))))
    if not grazes:
        raise ParameterError("point", orbit, "its orbit touches no stop")
    return min(grazes)[1]


def _least_in_flight(
    run: StructureTrajectory, wall: _Met, begin: float, end: float
) -> tuple[float, float]:
    """Return the least clearance at which it turns within a flight, and when; inf without a turn."""
    t = np.linspace(begin, end, LOOKED)[1:-1]

    def seen(at: Floats) -> tuple[Floats, Floats]:
        x, v = run(at)
        gap = (x * wall.normal).sum(axis=-1) - wall.level
        return np.asarray(gap), np.asarray((v * wall.normal).sum(axis=-1))

    _, speed = seen(t)
    turns = np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))
    if len(turns) == 0:
        return math.inf, math.nan
    low, high, slow, fast = t[turns], t[turns + 1], speed[turns], speed[turns + 1]
    gap, at = np.full(len(turns), math.inf), low
    for _ in range(REFINED):
        at = low - slow * (high - low) / (fast - slow)
        gap, now = seen(at)
        below = now < 0.0
        low, slow = np.where(below, at, low), np.where(below, now, slow)
        high, fast = np.where(below, high, at), np.where(below, fast, now)
    least = int(np.argmin(gap))
    return float(gap[least]), float(at[least])
