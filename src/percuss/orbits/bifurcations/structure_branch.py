"""Branches of a structure's periodic orbits along a parameter, with their special points."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Self, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Complexes, Flags, Floats
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import Phase, as_float
from percuss.model.paths import get_parameter, long_form, replace_parameters
from percuss.numerics import determinant, dot, matmul
from percuss.orbits.bifurcations.branch import Branch, BranchRows, OrbitRows
from percuss.orbits.bifurcations.branch_equations import range_about
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.orbits.continuation.correct import corrected, tangent_of
from percuss.orbits.continuation.follow import Segment, StepLimits, follow_both_ways
from percuss.orbits.continuation.locate import changes_sign, locate
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.moved_structure_orbit import closure_by_parameters
from percuss.orbits.orbit.structure_orbit import (
    PeriodMap,
    StructureOrbit,
    closing_error,
    multipliers_of_matrix,
    orbit_of_map,
    period_map,
)
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

__all__ = [
    "AnyBranch",
    "StructureBranch",
    "StructureEquations",
    "StructureRows",
    "StructureSpecialPoint",
    "continue_structure_orbit",
    "structure_parameter",
    "tests_of",
]

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
UPRIGHT = 0.05
# Systems that are kept.
SYSTEMS = 16
# A pair of multipliers on the unit circle nearer than this to a root of unity of low order is a
# strong resonance.
RESONANT = 1e-3
# A bracket in the parameter that is a location, as a part of it.
LOCATED = 1e-9
# An event this near to t = 0, as a part of the period, is passing it; parts of the range beyond.
STROBED, BEYOND = 1e-6, (100.0 * DIFFERENCE, 1e-4, 1e-3)

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
        pair of multipliers leaves the unit circle: Neimark-Sacker), "branch_point" (a multiplier of
        1 otherwise), "grazing" (a stop is touched: there is one contact more or less).
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
        """(m,) array, True: the orbits of a structure are motions."""
        return np.ones(len(self), dtype=np.bool_)


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

    @property
    def stability(self) -> NDArray[np.str_]:
        """(m,) array of "asymptotic" and "unstable", as branches of one displacement have it."""
        return np.where(self.is_stable, "asymptotic", "unstable")

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset along ``point``, for files and for pandas."""
        import xarray

        special = np.full(len(self), "", dtype="<U20")
        for point in self.special_points:
            special[point.row] = point.kind
        return xarray.Dataset(
            {
                "value": ("point", self.values, {"long_name": self.path}),
                "amplitude": (("point", "coordinate"), self.amplitude),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
                "is_stable": ("point", self.is_stable),
                "n_impacts": ("point", self.n_impacts),
                "special_point": ("point", special),
            },
            attrs={"path": self.path, "end_reason": self.end_reason},
        )

    def to_pandas(self) -> DataFrame:
        """Return the columns that have one number a row as a pandas.DataFrame."""
        table = self.to_xarray()
        return table[["value", "is_stable", "n_impacts", "special_point"]].to_dataframe()


AnyBranch: TypeAlias = Branch | StructureBranch


class StructureEquations:
    """The equations of a structure's orbits over parameters: the period map brings them back.

    The unknowns are the state at t = 0, in units of the first orbit's size, and the parameters,
    scaled so that their ranges go from 0 to 1. With a condition, one of `tests_of` that is to be
    zero, there is one parameter more.
    """

    order = 2

    def __init__(
        self,
        orbit: StructureOrbit,
        ranges: Mapping[str, tuple[float, float]],
        condition: str | None = None,
    ) -> None:
        self.first, self.condition = orbit, condition
        self.noun = "branch" if condition is None else "curve"
        self.paths = tuple(ranges)
        self.lows, self.highs = zip(*ranges.values(), strict=True)
        self.n_periods = orbit.n_periods
        self.scale = _scale_of(orbit)
        self.size = len(self.scale)
        self.system_at = lru_cache(SYSTEMS)(self._system_at)
        self.maps = lru_cache(SYSTEMS)(self._map)
        # What is computed at points alone: derivatives by the parameters, and of the condition.
        n_unknowns = self.size + len(self.paths)
        self.by_parameters = np.zeros((self.size, len(self.paths)))
        self.of_condition = np.zeros(n_unknowns)
        self.last: tuple[Floats, Floats, Floats] | None = None
        self.keys: tuple[int, ...] = ()
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
        there = period_map(system, state, self.n_periods)
        self.keys = there.keys_met
        return there

    def image(self, z: Floats) -> Floats:
        """Return the scaled residuals of a point, without derivatives."""
        there = self.maps(tuple(z.tolist()))
        residual = there.image / self.scale - z[: self.size]
        if self.condition is None:
            return residual
        return np.append(residual, tests_of_matrix(there.derivative)[self.condition])

    def residual(self, z: Floats) -> tuple[Floats, Floats]:
        """Return scaled residuals and their derivative, what is not computed as last known.

        That is brought up to date by what the computed derivatives leave of a step (Broyden 1965).
        """
        n = self.size
        residual = self.image(z)
        there = self.maps(tuple(z.tolist()))
        matrix = np.empty((len(residual), len(z)))
        matrix[:n, :n] = there.derivative * (self.scale[None, :] / self.scale[:, None])
        matrix[:n, :n] -= np.eye(n)
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
        exact = closure_by_parameters(orbit.closed_motion, self.paths)
        if exact is not None:
            widths = np.subtract(self.highs, self.lows)
            self.by_parameters = exact * widths / self.scale[:, None]
        first = 0 if self.condition is not None else n
        moved = range(first, len(z)) if exact is None or self.condition is not None else ()
        here = self.image(z)
        for k in moved:
            step = DIFFERENCE if k < n or z[k] < 0.5 else -DIFFERENCE
            there = z.copy()
            there[k] += step
            change = (self.image(there) - here) / step
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
        part = dot(z - here, chord) / dot(chord, chord)
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
        there, state = self.maps(tuple(z.tolist())), z[: self.size] * self.scale
        system = self.system_at(self.values(z))
        return orbit_of_map(system, state, self.n_periods, there, closing_error(there, state))

    def point(self, z: Floats, before: Point[Self]) -> Point[Self]:
        """Return a solution with its tangent, on the side of an earlier one's, and its tests."""
        return self._point(z, before.tangent)

    def started(self, orbit: StructureOrbit, values: Sequence[float]) -> Point[Self]:
        """Return the first point, of an orbit and the values of the parameters there."""
        state = np.concatenate([orbit.x0, orbit.v0]) / self.scale
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
        return Point(z, tangent, orbit, tests_of(orbit), self)

    def refined(self, point: Point[Self]) -> Point[Self]:
        """Return the point: its tangent is the best there is."""
        return point

    def recentre(self, point: Point[Self]) -> None:
        """Do nothing: the equations are the same everywhere."""

    def corrector_normal(self, tangent: Floats) -> Floats:
        """Return the normal of the corrector's plane: the parameter stays, except next to a fold.

        Another value of it is another system, whose modes take longer than many motions.
        """
        if len(self.paths) == 1 and abs(tangent[-1]) > UPRIGHT:
            return along_parameter(len(tangent))
        return tangent

    def longest_step(self, point: Point[Self], largest: float) -> float:  # noqa: ARG002
        """Return the largest step."""
        return largest


def _scale_of(orbit: StructureOrbit) -> Floats:
    """Return units of displacements and velocities, (2 n,): what stops and the orbit reach to."""
    structure = orbit.structure
    x, v = orbit.run(np.linspace(0.0, orbit.run.t_end, 65))
    places = [
        abs(as_float(stop.at)) / float(np.abs(c).max())
        for stop, c in zip(structure.stops, structure.stop_directions, strict=True)
    ]
    length, speed = float(np.abs(x).max()), float(np.abs(v).max())
    longer = max([length, *places])
    speed *= longer / length if length > 0.0 else 1.0
    return np.repeat([longer or 1.0, speed or 1.0], structure.n)


def _size(z: Floats) -> float:
    return max(1.0, float(np.abs(z).max()))


def tests_of(orbit: StructureOrbit) -> Mapping[str, float]:
    """Return functions that are zero, or jump, at special points, by their names."""
    return tests_of_matrix(orbit.monodromy) | {"contacts": float(orbit.n_impacts)}


def tests_of_matrix(monodromy: Floats) -> dict[str, float]:
    """Return functions of the derivative of the period map that are zero at special points.

    The product of m_i m_j - 1 over all pairs of multipliers is zero at a torus point, and where two
    real ones are inverse to each other, which is none.
    """
    unit = np.eye(len(monodromy))
    pairs = 1.0 + 0.0j
    values = multipliers_of_matrix(monodromy).tolist()
    for i, a in enumerate(values):
        for b in values[i + 1 :]:
            pairs *= a * b - 1.0
    return {
        "multiplier 1": determinant(monodromy - unit),
        "multiplier -1": determinant(monodromy + unit),
        "torus": pairs.real,
    }


class _BranchDetector:
    """Finds special points between neighbours."""

    def between(
        self, here: Point[StructureEquations], new: Point[StructureEquations]
    ) -> Segment[StructureEquations, StructureSpecialPoint]:
        """Return the special points between two neighbours, in order."""
        equations = here.problem
        found = []
        turns = here.tangent[-1] * new.tangent[-1] < 0.0
        for name, kind in _KINDS.items():
            ends = (here.tests[name], new.tests[name])
            if name == "contacts":
                middle = 0.5 * (ends[0] + ends[1])
                ends = (ends[0] - middle, ends[1] - middle)
            else:
                middle = 0.0
            if not changes_sign(*ends) or (ends[0] == 0.0 == ends[1]):
                continue

            def test(z: Floats, name: str = name, middle: float = middle) -> float:
                return tests_of(equations.solution(z))[name] - middle

            zero = locate(here, new, test, ends)
            if zero is None:
                continue
            orbit = cast("StructureOrbit", zero.orbit)
            is_fold = name == "multiplier 1" and turns
            detail = _detail("fold" if is_fold else kind, orbit, ends)
            if detail is None:
                continue
            width = abs(zero.ends[0][-1] - zero.ends[1][-1])
            special = StructureSpecialPoint(
                "fold" if is_fold else kind,
                equations.paths[0],
                equations.values(zero.z)[0],
                "located" if width <= LOCATED else "bracketed",
                orbit,
                -1,
                detail,
            )
            point = Point(zero.z, new.tangent, zero.orbit, tests_of(orbit), equations)
            found.append((zero.part, point, special))
        found.sort(key=lambda one: one[0])
        return Segment([(point, special) for _, point, special in found])

    def stopped(
        self,
        here: Point[StructureEquations],
        reason: str,
    ) -> Segment[StructureEquations, StructureSpecialPoint]:
        """Return what is beyond the last point: the same branch where an event is at t = 0."""
        return Segment([], reason, _past_the_strobe(here))


def _past_the_strobe(here: Point[StructureEquations]) -> Point[StructureEquations] | None:
    """Return the point at which the event next to t = 0 has passed it, None if there is none.

    There the state at t = 0, which is solved for, jumps from one side of the impact to the other,
    or has a kink where a stop with a dashpot, whose force jumps, is entered or left.
    """
    equations, run = here.problem, here.orbit.run
    times = np.sort(np.concatenate([run.impacts.t, run.crossings.t]))
    way = math.copysign(1.0, here.tangent[-1])
    for limit, at in (("after", times[:1]), ("before", times[-1:])):
        distance = np.abs(at - (0.0 if limit == "after" else run.t_end))
        if not (distance < STROBED * run.t_end).any():
            continue
        state = np.concatenate(run(float(at[0]), limit=limit)) / equations.scale
        for step in BEYOND:
            part = here.z[-1] + way * step
            if not 0.0 <= part <= 1.0:
                return None
            try:
                normal = along_parameter(len(here.z))
                z = equations.corrected(np.append(state, part), normal)
                point = equations.started(equations.solution(z), equations.values(z))
                return dataclasses.replace(point, tangent=way * point.tangent)
            except PercussError:
                continue
    return None


def _detail(kind: SpecialPointKind, orbit: StructureOrbit, ends: tuple[float, float]) -> str | None:
    """Return a point in words, None where it is none."""
    values = orbit.multipliers
    if kind == "grazing":
        return f"{abs(ends[1] - ends[0]):g} contact {'more' if ends[1] > ends[0] else 'less'}"
    if kind in ("fold", "branch_point"):
        return "two orbits meet and end" if kind == "fold" else "a multiplier of 1"
    if kind == "period_doubling":
        return "a multiplier of -1"
    above = values[values.imag > 1e-9]
    if len(above) == 0:
        return None
    sizes = np.abs(np.array([math.hypot(z.real, z.imag) for z in above.tolist()]) - 1.0)
    z = complex(above[int(np.argmin(sizes))])
    if float(sizes.min()) > 1e-4:
        return None
    for q, cosine in ((3, -0.5), (4, 0.0)):
        if abs(z.real - cosine) < RESONANT:
            return f"a pair of multipliers on the unit circle, strong resonance 1:{q}"
    return f"a pair of multipliers {z.real:.6g} +- {z.imag:.6g} i on the unit circle"


def continue_structure_orbit(
    orbit: StructureOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> StructureBranch:
    """Follow a structure's orbit along a parameter, both ways, stable or not.

    The arguments are those of `continue_orbit`. The equations are those of the map over the period:
    all orbits on the branch are motions that exist. The branch passes the grazes of soft stops; at
    a wall, whose graze takes the derivative away, it may end there.

    Raises
    ------
    ParameterError
        If there is no such parameter, or the range does not hold the orbit's value.
    """
    if len(over) != 1:
        raise ParameterError("over", dict(over), "not one parameter by its path and range")
    ((given, ends),) = over.items()
    path, value = structure_parameter(orbit, given)
    first, last = range_about(value, path, ends, "orbit")
    steps = StepLimits.checked(max_points, largest_step)
    reported = Progress(progress, 2 * steps.max_points, "orbits", is_bound=True)
    equations = StructureEquations(orbit, {path: (min(first, last), max(first, last))})
    start = equations.started(orbit, [value])
    towards = math.copysign(1.0, last - first) * math.copysign(1.0, start.tangent[-1])
    rows, why = follow_both_ways(start, towards, _BranchDetector(), steps, reported)
    reported.close()
    orbits = tuple(cast("StructureOrbit", point.orbit) for point, _ in rows)
    special = tuple(
        dataclasses.replace(found, row=row)
        for row, (_, found) in enumerate(rows)
        if found is not None
    )
    return StructureBranch(
        path=path,
        values=np.array([equations.values(point.z)[0] for point, _ in rows]),
        multipliers=np.array([one.multipliers for one in orbits]),
        is_stable=np.array([one.is_stable for one in orbits]),
        n_impacts=np.array([one.n_impacts for one in orbits]),
        amplitude=np.array([_amplitudes(one) for one in orbits]),
        orbits=orbits,
        special_points=special,
        end_reason=why,
    )


def structure_parameter(orbit: StructureOrbit, path: str) -> tuple[str, float]:
    """Return the long form of a parameter's path, and its value in the system of an orbit."""
    path = long_form(path, orbit.structure, orbit.loads)
    return path, as_float(get_parameter(orbit.structure, orbit.loads, None, path))


def _amplitudes(orbit: StructureOrbit) -> Floats:
    run = orbit.run
    times = np.concatenate([np.linspace(0.0, run.t_end, 257), run.impacts.t, run.crossings.t])
    x, _ = run(times)
    return np.asarray(0.5 * (x.max(axis=0) - x.min(axis=0)))
