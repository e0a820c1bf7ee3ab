"""Branches of a structure's periodic orbits along a parameter, with their special points."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Complexes, Flags, Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.oscillator import On
from percuss.model.paths import get_parameter, long_form, replace_parameters
from percuss.numerics import determinant, dot, matmul
from percuss.orbits.bifurcations.bifurcation_origin import Origin
from percuss.orbits.bifurcations.branch import Branch, BranchRows, OrbitRows
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.orbits.continuation.correct import corrected, tangent_of
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.moved_structure_orbit import closure_by_parameters
from percuss.orbits.orbit.over_period import states_over_period
from percuss.orbits.orbit.stability import stability_of_multipliers
from percuss.orbits.orbit.structure_orbit import (
    PeriodMap,
    StructureOrbit,
    closing_error,
    map_between,
    multipliers_of_matrix,
    orbit_of_map,
    period_map,
    period_of,
)
from percuss.orbits.orbit.symmetry import MIRRORED, is_symmetric_structure
from percuss.orbits.orbit.table_units import with_units

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

# Part of the range by which a parameter is moved for a difference, where the closed form has no
# derivative, and for conditions: its error slows the corrector a little, and no solution feels it.
DIFFERENCE = 1e-7
# Newton's steps, and relative residuals that need not become smaller.
STEPS, ENOUGH = 12, 1e-13
# A condition on multipliers is known less well than the orbit: residuals that are enough with it.
NEARLY = 1e-9
# Largest change of a derivative from one point to the next that is continued beyond, as a part of
# it, and how far, in distances of these points.
SMOOTH, FARTHEST = 0.5, 4.0
# Part of the parameter in a tangent above which Newton's method leaves it as it is.
UPRIGHT = 0.02
# Steps that are as short only where longer ones fail.
SHORT = 1e-6
# Systems that are kept.
SYSTEMS = 16
# Products of multipliers this near 1 are 1, in units of the rounding of large ones.
CONSERVATIVE = 1e-11
# An event this near to the state, as a part of the period, is passing it; phases of the loads at
# which the state may be instead.
STROBED, PHASES = 1e-6, tuple(k / 64 for k in range(64))

_KINDS: dict[str, SpecialPointKind] = {
    "multiplier 1": "branch_point",
    "multiplier -1": "period_doubling",
    "torus": "torus",
    "contacts": "grazing",
}


@dataclass(frozen=True, slots=True)
class StructureSpecialPoint:
    """A point of a branch at which the orbits change in kind.

    Attributes
    ----------
    kind
        "fold" (two orbits meet and end), "period_doubling" (a multiplier of -1), "torus" (a complex
        pair of multipliers leaves the unit circle: Neimark-Sacker), "symmetry_breaking" (a
        multiplier of 1 of an orbit that repeats itself mirrored after half its period: two that
        mirror each other start), "branch_point" (a multiplier of 1 otherwise), "grazing" (a stop is
        touched: there is one contact more or less), "border_collision" (an impact meets a jump of
        the loads: multipliers jump, and the branch may turn, a nonsmooth fold).
    path, value
        The parameter and its value there.
    status
        "located" if it is known to 1e-9 of the range, otherwise "bracketed".
    orbit
        The orbit there.
    row
        Its row in the branch.
    detail
        A description of the point.
    """

    kind: SpecialPointKind
    path: str
    value: float
    status: str
    orbit: StructureOrbit = field(repr=False)
    row: int
    detail: str

    def __repr__(self) -> str:
        """Return the point in a line."""
        return (
            f"<StructureSpecialPoint: {self.kind} at {self.path} = {self.value:.12g}, "
            f"{self.status}, row {self.row}; {self.detail}>"
        )


class StructureRows(OrbitRows[StructureOrbit]):
    """The common part of a structure's branches and curves."""

    __slots__ = ()

    @property
    def admissible(self) -> Flags:
        """(m,) array, whether each orbit is a motion: formal ones pass through walls."""
        return np.array([orbit.admissible for orbit in self.orbits], dtype=np.bool_)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureBranch(StructureRows, BranchRows[StructureOrbit]):
    """Periodic orbits of a structure along one parameter, made by `continue_orbit`.

    Attributes
    ----------
    path
        Path of the parameter.
    values
        (m,) array, its value in each row; it turns back at a fold.
    multipliers
        (m, 2 n) complex array, the largest of each orbit first.
    is_stable
        (m,) array, whether neighbours approach each orbit.
    n_impacts
        (m,) array, impacts on walls and entries into soft stops in a period.
    amplitude
        (m, n) array, half the distance between the least and the largest value of each coordinate,
        at 257 instants and the events of an orbit [length].
    orbits
        The orbits.
    special_points
        Those found, in order; each is a row.
    end_reason
        Why the branch ends where it does.
    """

    path: str
    values: Floats
    multipliers: Complexes
    is_stable: Flags
    n_impacts: Floats
    amplitude: Floats
    orbits: tuple[StructureOrbit, ...] = field(repr=False)
    special_points: tuple[StructureSpecialPoint, ...]
    end_reason: str

    def amplitude_of(self, on: On) -> Floats:
        """Return half the distance between the least and the largest displacement in each row.

        Parameters
        ----------
        on
            A coordinate, a direction, or the name of a point.

        Returns
        -------
        array
            (m,), taken at the same instants as `amplitude` [length].

        Raises
        ------
        ParameterError
            If there is no such coordinate or point.

        Examples
        --------
        >>> import percuss as pc
        >>> two = pc.chain([1, 1], [1, 1, 1], dashpots="0.1")
        >>> orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine("0.5")}))
        >>> branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("0.5", "0.6")})
        >>> bool((branch.amplitude_of((1, -1)) < branch.amplitude[:, 0]).all())
        True
        """
        if isinstance(on, int) and 0 <= on < self.amplitude.shape[1]:
            return self.amplitude[:, on]
        c = self.orbits[0].structure.direction(on)
        return np.array([float(amplitudes(orbit, c[:, None])[0]) for orbit in self.orbits])

    @property
    def stability(self) -> NDArray[np.str_]:
        """(m,) array of strings, to first order: as `StructureOrbit.stability` has it."""
        return np.array([stability_of_multipliers(row) for row in self.multipliers])

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset along ``point``, for files and for pandas."""
        import xarray

        special = np.full(len(self), "", dtype="<U20")
        for point in self.special_points:
            special[point.row] = point.kind
        table = xarray.Dataset(
            {
                "value": ("point", self.values, {"long_name": self.path}),
                "amplitude": (("point", "coordinate"), self.amplitude),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
                "is_stable": ("point", self.is_stable),
                "admissible": ("point", self.admissible),
                "n_impacts": ("point", self.n_impacts),
                "special_point": ("point", special),
            },
            attrs={"path": self.path, "end_reason": self.end_reason},
        )
        return with_units(table, self.orbits[0], self.path)

    def to_pandas(self) -> DataFrame:
        """Return the columns that have one number a row as a pandas.DataFrame."""
        table = self.to_xarray()
        return table[["value", "is_stable", "n_impacts", "special_point"]].to_dataframe()


AnyBranch: TypeAlias = Branch | StructureBranch


class StructureEquations:
    """The equations of a structure's orbits over parameters: the period map brings them back.

    The unknowns are the state at a phase of the loads, ``begin`` periods after t = 0, in units of
    the first orbit's size, and the parameters, scaled so that their ranges go from 0 to 1. With a
    condition, one of `tests_of` that is to be zero, there is one parameter more.

    Those of symmetric orbits may be of the half: half an orbit later the state is mirrored. Where a
    multiplier of that map is -1 the symmetry breaks; all of the orbit has the square of the map, and
    with it 1, at a point where no family of symmetric orbits turns (Swift & Wiesenfeld 1984).
    """

    order = 3
    cyclic = slice(0, 0)
    begin = 0.0

    def __init__(
        self,
        orbit: StructureOrbit,
        ranges: Mapping[str, tuple[float, float]],
        condition: str | None = None,
        *,
        is_half: bool = False,
    ) -> None:
        self.first, self.condition, self.is_half = orbit, condition, is_half
        self.noun = "branch" if condition is None else "curve"
        self.paths = tuple(ranges)
        self.lows, self.highs = zip(*ranges.values(), strict=True)
        self.n_periods = orbit.n_periods
        self.units = _scale_of(orbit)
        self.system_at = lru_cache(SYSTEMS)(self._system_at)
        self.keys: tuple[int, ...] = ()
        self.take_scale(self.units)

    def take_scale(self, scale: Floats) -> None:
        """Begin anew with unknowns of this scale, without the parameters."""
        self.scale, self.size = scale, len(scale)
        self.maps = lru_cache(SYSTEMS)(self._map)
        # What is computed at points alone: derivatives by the parameters, and of the condition.
        self.by_parameters = np.zeros((self.size, len(self.paths)))
        self.of_condition = np.zeros(self.size + len(self.paths))
        self.last: tuple[Floats, Floats, Floats] | None = None
        # The last two points with what was computed there.
        self.known: list[tuple[Floats, Floats, Floats]] = []

    def values(self, z: Floats) -> tuple[float, ...]:
        """Return the parameters of a point."""
        parts = z[self.size :].tolist()
        return tuple(
            high if part == 1.0 else low + part * (high - low)
            for part, low, high in zip(parts, self.lows, self.highs, strict=True)
        )

    def _system_at(self, values: tuple[float, ...]) -> StructureSystem:
        changes = dict(zip(self.paths, values, strict=True))
        structure, loads, _ = replace_parameters(
            self.first.structure, self.first.loads, None, changes
        )
        return StructureSystem.of(structure, loads)

    def _map(self, z: tuple[float, ...]) -> PeriodMap:
        point = np.array(z)
        state = point[: self.size] * self.scale
        system = self.system_at(self.values(point))
        # The sets that the last motion met: made at once they need one search less.
        system.add(*self.keys)
        turns = 0.5 * self.n_periods if self.is_half else float(self.n_periods)
        begin, period = self.begin, period_of(system)
        span = begin * period, (begin + turns) * period
        mapped = map_between(system, state, span, f"{turns:g} periods")
        self.keys = mapped.keys_met
        if not self.is_half:
            return mapped
        return mapped._replace(image=-mapped.image, derivative=-mapped.derivative)

    @property
    def kinds(self) -> Mapping[str, SpecialPointKind]:
        """The kinds of special points by the names of their tests."""
        return _KINDS

    @property
    def of_motions(self) -> tuple[str, ...]:
        """The tests at whose zeros motions become formal orbits: zeros among these are none."""
        return ()

    def unknowns(self, orbit: StructureOrbit) -> Floats:
        """Return the unknowns of an orbit, without parameters."""
        return self._state_at(orbit, self.begin * orbit.period / orbit.n_periods) / self.scale

    @staticmethod
    def _state_at(orbit: StructureOrbit, t: float) -> Floats:
        x, v = (orbit.x0, orbit.v0) if t == 0.0 else orbit.run(t)
        return np.concatenate([x, v])

    @property
    def origin(self) -> Origin:
        """From which simpler orbits a family of such orbits may originate."""
        return "mirrored" if self.n_periods % 2 else "doubled"

    def halves(self, orbit: StructureOrbit) -> Floats:
        """Return by how much the state half a period later differs from that of an orbit, scaled.

        From its mirror image where the orbit repeats after an odd number of periods.
        """
        sign = -1.0 if self.origin == "mirrored" else 1.0
        x, v = orbit.run(0.5 * orbit.period)
        return np.concatenate([x - sign * orbit.x0, v - sign * orbit.v0]) / self.units

    def is_symmetric(self, orbit: StructureOrbit) -> bool:
        """Return whether an orbit repeats itself mirrored after half its period."""
        return (
            self.origin == "mirrored"
            and is_symmetric_structure(orbit.structure, orbit.loads)
            and float(np.abs(self.halves(orbit)).max()) < MIRRORED
        )

    def simpler(self, orbit: StructureOrbit) -> Self | None:
        """Return the equations of the orbits from which a family originates, None if it cannot.

        Those of the orbits that some of the family cover twice; the same, of symmetric orbits.
        """
        if self.origin == "mirrored":
            return self if is_symmetric_structure(orbit.structure, orbit.loads) else None
        half = copy.copy(self)
        half.n_periods = self.n_periods // 2
        half.take_scale(self.scale)
        return half

    def once(self, z: Floats) -> Floats:
        """Return the point of the simpler equations near one: of the half, or its mirrored mean."""
        if self.origin == "doubled":
            return z
        state, orbit = z[: self.size], self.solution(z)
        later = (self.begin / orbit.n_periods + 0.5) % 1.0 * orbit.period
        half = self._state_at(orbit, later) / self.scale
        return np.append(0.5 * (state - half), z[self.size :])

    def twice(self, z: Floats) -> Floats:
        """Return the orbit of a point of the simpler equations as a point of these."""
        return z

    def closure(self, z: Floats) -> tuple[Floats, Floats]:
        """Return the scaled residuals of a point, and their derivative without the parameters."""
        mapped = self.maps(tuple(z.tolist()))
        matrix = mapped.derivative * (self.scale[None, :] / self.scale[:, None]) - np.eye(self.size)
        return mapped.image / self.scale - z[: self.size], matrix

    def conditions(self, z: Floats) -> Mapping[str, float]:
        """Return functions of a point that are zero at special points."""
        return tests_of_matrix(self.maps(tuple(z.tolist())).derivative)

    def tests(self, z: Floats, orbit: StructureOrbit) -> Mapping[str, float]:  # noqa: ARG002
        """Return functions that are zero, or jump, at special points, by their names."""
        return tests_of(orbit)

    def exact_derivatives(self, z: Floats, orbit: StructureOrbit) -> Floats | None:  # noqa: ARG002
        """Return how the image of an orbit's state depends on the parameters; None if not known."""
        if self.begin != 0.0 or self.is_half:
            return None
        return closure_by_parameters(orbit.closed_motion, self.paths)

    def image(self, z: Floats) -> Floats:
        """Return the scaled residuals of a point, without derivatives."""
        return self._with_condition(z, self.closure(z)[0])

    def _with_condition(self, z: Floats, residual: Floats) -> Floats:
        if self.condition is None:
            return residual
        return np.append(residual, self.conditions(z)[self.condition])

    def residual(self, z: Floats) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative, what is not computed as last known.

        That is brought up to date by what the computed derivatives leave of a step (Broyden 1965).
        """
        n = self.size
        closed, matrix_of_state = self.closure(z)
        residual = self._with_condition(z, closed)
        matrix = np.empty((len(residual), len(z)))
        matrix[:n, :n] = matrix_of_state
        if self.last is not None:
            step = z - self.last[0]
            along = step[n:]
            mean = 0.5 * (matrix[:n, :n] + self.last[2])
            if float(np.abs(along).max()) > DIFFERENCE:
                left = residual[:n] - self.last[1][:n] - matmul(mean, step[:n])
                left = left - matmul(self.by_parameters, along)
                self.by_parameters = self.by_parameters + left[:, None] * along / dot(along, along)
            if self.condition is not None and float(np.abs(step).max()) > DIFFERENCE:
                rest = residual[n] - self.last[1][n] - dot(self.of_condition, step)
                self.of_condition = self.of_condition + rest * step / dot(step, step)
        matrix[:n, n:] = self.by_parameters
        if self.condition is not None:
            matrix[n] = self.of_condition
        self.last = z, residual, matrix[:n, :n]
        return residual, matrix

    def _take_derivatives(self, z: Floats, orbit: StructureOrbit) -> None:
        """Compute anew the derivatives by the parameters, and of the condition by differences."""
        self.last, n = None, self.size
        exact = self.exact_derivatives(z, orbit)
        if exact is not None:
            widths = np.subtract(self.highs, self.lows)
            self.by_parameters = exact * widths / self.scale[:, None]
        first = 0 if self.condition is not None else n
        moved = range(first, len(z)) if exact is None or self.condition is not None else ()
        here = self.image(z)
        for k in moved:
            step = DIFFERENCE if k < n or z[k] < 0.5 else -DIFFERENCE
            beside = z.copy()
            beside[k] += step
            change = (self.image(beside) - here) / step
            if k >= n and exact is None:
                self.by_parameters[:, k - n] = change[:n]
            if self.condition is not None:
                self.of_condition[k] = change[n]
        own = z, self.by_parameters.copy(), self.of_condition.copy()
        self.known = [*self.known[-1:], own]

    def _take_from_known(self, z: Floats) -> None:
        """Continue what was computed at the last two points, where it changes little."""
        if not self.known:
            return
        here, by_parameters, of_condition = self.known[-1]
        self.by_parameters, self.of_condition = by_parameters, of_condition
        if len(self.known) == 1:
            return
        before, *earlier = self.known[0]
        chord = here - before
        square = dot(chord, chord)
        if square == 0.0:
            return
        part = dot(z - here, chord) / square
        changes = by_parameters - earlier[0], of_condition - earlier[1]
        sizes = np.abs(by_parameters), np.abs(of_condition)
        little = all(
            np.abs(change).max() <= SMOOTH * size.max(initial=0.0)
            for change, size in zip(changes, sizes, strict=True)
        )
        if little and abs(part) <= FARTHEST:
            self.by_parameters = by_parameters + part * changes[0]
            self.of_condition = of_condition + part * changes[1]

    def corrected(self, guess: Floats, normal: Floats, *, near_others: bool = False) -> Floats:  # noqa: ARG002
        """Return the solution in the plane through a guess with this normal."""
        self.last = None
        self._take_from_known(guess)
        z, error, is_solution = corrected(
            self.residual, guess, normal, steps=STEPS, enough=ENOUGH, size=_size
        )
        if not is_solution and not (self.condition is not None and error < NEARLY):
            place = ", ".join(
                f"{path} = {value:.12g}"
                for path, value in zip(self.paths, self.values(guess), strict=True)
            )
            raise ConvergenceError(f"no orbit at {place}", z, error, "take a smaller step")
        return z

    def solution(self, z: Floats) -> StructureOrbit:
        """Return the orbit of a solution."""
        state, system = z[: self.size] * self.scale, self.system_at(self.values(z))
        period = period_of(system)
        if self.begin != 0.0:
            span = self.begin * period, self.n_periods * period
            state = map_between(system, state, span, "a period", derivative=False).image
        elsewhere = self.begin != 0.0 or self.is_half
        mapped = (
            period_map(system, state, self.n_periods) if elsewhere else self.maps(tuple(z.tolist()))
        )
        error = closing_error(mapped, state, period)
        return orbit_of_map(system, state, self.n_periods, mapped, error)

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent, on the side of an earlier one's, and its tests."""
        point = self._point(z, before.tangent)
        if before.is_response and point.is_response:
            # However far its state turns in a resonance, the parameter goes on.
            onwards = math.copysign(1.0, before.tangent[-1] * point.tangent[-1])
            return dataclasses.replace(point, tangent=onwards * point.tangent)
        return point

    def started(self, orbit: StructureOrbit, values: Sequence[float]) -> Point[Self]:
        """Return the first point, of an orbit and the values of the parameters there."""
        state = self.unknowns(orbit)
        parts = [
            (value - low) / (high - low)
            for value, low, high in zip(values, self.lows, self.highs, strict=True)
        ]
        z = np.concatenate([state, parts])
        side = along_parameter(len(z))
        if self.condition is not None:
            self._take_derivatives(z, orbit)
            z = self.corrected(z, side)
        return self._point(z, side)

    def _point(self, z: Floats, side: Floats) -> Point[Self]:
        orbit = self.solution(z)
        self._take_derivatives(z, orbit)
        tangent = tangent_of(self.residual(z)[1], side)
        is_response = self.condition is None and orbit.is_steady
        return Point(z, tangent, orbit, self.tests(z, orbit), self, is_response)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point: its tangent is the best there is."""
        return point

    def recentre(self, point: Point[Self]) -> None:
        """Do nothing: the equations are the same everywhere."""

    def corrector_normal(self, tangent: Floats, step: float) -> Floats:
        """Return the normal of the corrector's plane: the parameter stays, except next to a fold.

        Another value of it is another system, whose modes take longer than many motions. Where
        steps are short there may be a fold just ahead: as next to a graze, behind which multipliers
        change as a square root.
        """
        if len(self.paths) == 1 and abs(tangent[-1]) > UPRIGHT and step > SHORT:
            return along_parameter(len(tangent))
        return tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:
        """Return the largest step, longer where the orbit has outgrown the first one's size."""
        return largest if point.is_response else largest * _size(point.z[: self.size])


def begun_anew(here: Point[StructureEquations]) -> Point[StructureEquations] | None:
    """Return a point with the state of its orbit far from all events, None where it is not near one.

    A state that is solved for jumps where an impact passes it, from one side of the impact to the
    other, and has a kink where a stop with a dashpot, whose force jumps, is entered or left.
    """
    equations, run, n = here.problem, here.orbit.run, here.problem.size
    if n > 2 * here.orbit.structure.n:
        # The state just after an impact is solved for, wherever it is.
        return None
    turns = here.orbit.n_periods
    events = np.concatenate([run.impacts.t, run.crossings.t]) / run.t_end
    held = np.column_stack([run.contacts.start, run.contacts.release]) / run.t_end

    def distance(begin: float) -> float:
        part = begin / turns
        if ((held[:, 0] <= part) & ~(held[:, 1] < part)).any():
            return 0.0
        return float(np.abs((events - part + 0.5) % 1.0 - 0.5).min(initial=1.0))

    begin = max(PHASES, key=distance)
    if distance(equations.begin) > STROBED or distance(begin) <= STROBED:
        return None
    other = copy.copy(equations)
    other.begin = begin
    other.take_scale(equations.scale)
    try:
        point = other.started(here.orbit, equations.values(here.z))
    except PercussError:
        return None
    sign = math.copysign(1.0, dot(point.tangent[n:], here.tangent[n:]))
    return dataclasses.replace(point, tangent=sign * point.tangent)


def _scale_of(orbit: StructureOrbit) -> Floats:
    """Return units of displacements and velocities, (2 n,): what stops and the orbit reach to."""
    structure = orbit.structure
    x, v = states_over_period(orbit)
    places = [
        abs(as_float(stop.at)) / float(np.abs(c).max())
        for stop, c in zip(structure.stops, structure.stop_directions, strict=True)
    ]
    length, speed = float(np.abs(x).max()), float(np.abs(v).max())
    longer = max([length, *places])
    speed *= longer / length if length > 0.0 else 1.0
    return np.repeat([longer or 1.0, speed or 1.0], structure.n)


def amplitudes(orbit: StructureOrbit, directions: Floats | None = None) -> Floats:
    """Return half the range of the displacements along directions, (n, k); of all coordinates."""
    run = orbit.run
    times = np.concatenate([np.linspace(0.0, run.t_end, 257), run.impacts.t, run.crossings.t])
    x, _ = run(times)
    y = x if directions is None else matmul(x, directions)
    return np.asarray(0.5 * (y.max(axis=0) - y.min(axis=0)))


def _size(z: Floats) -> float:
    return max(1.0, float(np.abs(z).max()))


def tests_of(orbit: StructureOrbit) -> Mapping[str, float]:
    """Return functions that are zero, or jump, at special points, by their names."""
    return tests_of_matrix(orbit.monodromy) | {"contacts": float(orbit.n_impacts)}


def tests_of_matrix(monodromy: Floats) -> dict[str, float]:
    """Return functions of the derivative of the period map that are zero at special points.

    The product of m_i m_j - 1 over all pairs of multipliers is zero at a torus point, and where two
    real ones are inverse to each other, which is none. It is 0 where two are inverse to rounding: of
    a motion without losses they are all along.
    """
    unit = np.eye(len(monodromy))
    pairs = 1.0 + 0.0j
    values = multipliers_of_matrix(monodromy).tolist()
    for i, a in enumerate(values):
        for b in values[i + 1 :]:
            beyond = a * b - 1.0
            is_rounding = abs(beyond) < CONSERVATIVE * max(1.0, abs(a), abs(b)) ** 2
            pairs *= 0.0 if is_rounding else beyond
    return {
        "multiplier 1": determinant(monodromy - unit),
        "multiplier -1": determinant(monodromy + unit),
        "torus": pairs.real,
    }


def structure_parameter(orbit: StructureOrbit, path: str) -> float:
    """Return the value of a parameter in the system of an orbit."""
    path = long_form(path, orbit.structure, orbit.loads)
    return as_float(get_parameter(orbit.structure, orbit.loads, None, path))
