"""Special points of a structure's orbits along curves in two parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float
from percuss.model.faults import check_mapping
from percuss.model.paths import long_form
from percuss.numerics import directions, dot, matmul
from percuss.orbits.bifurcations.branch import CurveRows
from percuss.orbits.bifurcations.open_flights import graze_of
from percuss.orbits.bifurcations.parameter_ranges import ranges_of_curve
from percuss.orbits.bifurcations.structure_branch import (
    StructureEquations,
    StructureRows,
    StructureSpecialPoint,
    begun_anew,
    structure_parameter,
    tests_of_matrix,
)
from percuss.orbits.bifurcations.wall_equations import (
    GRAZE,
    WallEquations,
    meets_walls_in_turn,
)
from percuss.orbits.continuation.follow import (
    Segment,
    StepLimits,
    follow_both_ways,
    special_points_of,
)
from percuss.orbits.continuation.locate import changes_sign, locate
from percuss.orbits.continuation.problem import Point
from percuss.orbits.orbit.structure_orbit import (
    StructureOrbit,
    map_between,
    multipliers_of_matrix,
)
from percuss.orbits.orbit.symmetry import SYMMETRY_LOST, is_symmetric_structure, keep_symmetry
from percuss.orbits.orbit.table_units import with_units
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    from xarray import Dataset

# Of the kinds of special points that have curves: the test that is zero along it.
CONDITIONS = {
    "fold": "multiplier 1",
    "period_doubling": "multiplier -1",
    "torus": "torus",
    "symmetry_breaking": "multiplier -1",
    "grazing": GRAZE,
}
# Cosines of the angle of a pair on the unit circle at strong resonances 1:q.
RESONANCES = {"resonance_1_1": 1.0, "resonance_1_2": -1.0, "resonance_1_3": -0.5,
              "resonance_1_4": 0.0}  # fmt: skip
OTHERS = {"multiplier 1": "fold", "multiplier -1": "doubling", "torus": "torus"}
CUSP = "cusp"
# Multipliers nearer to 1 or -1 than this are two of them there: a double one moves as the root of
# what a point is off.
DOUBLE = 1e-3
# A clearance that is none where a curve stops, as a part of the unit of lengths: next to a graze
# the multipliers change as its square root, and steps end a little before it.
TOUCHED = 1e-5
# Instants at which an orbit is looked at for that.
LOOKED = 4097
# Scaled step of central differences, where h^2 and 1e-16/h are both small.
CENTRAL = 1e-5
FORMAL = "formal: where the symmetry of orbits breaks that pass through a stop is not followed"
# The order in which two of them are named.
ORDER = ("fold", "doubling", "torus", "symmetry_breaking", "grazing")


@dataclass(frozen=True, slots=True)
class StructureCurvePoint:
    """A point of codimension two on a curve.

    Attributes
    ----------
    kind
        "cusp" (two curves of folds meet and end); "resonance_1_3" and "resonance_1_4" where the
        pair of a torus point has that angle, "resonance_1_1" and "resonance_1_2" where two
        multipliers are 1, or -1: a curve of torus points meets one of folds, or doublings, there;
        "fold_doubling", "fold_torus", "doubling_torus", "fold_symmetry_breaking",
        "torus_symmetry_breaking", "fold_grazing", "doubling_grazing" and "torus_grazing" where two
        conditions hold together: at grazes those of the orbit without the impact that begins, where
        a symmetry breaks those of the map over half the orbit.
    paths, values
        The two parameters and their values there.
    orbit
        The orbit there.
    row
        Its row in the curve.
    """

    kind: str
    paths: tuple[str, str]
    values: tuple[float, float]
    orbit: StructureOrbit = field(repr=False)
    row: int


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class StructureCurve(StructureRows, CurveRows[StructureOrbit]):
    """Special points of a structure's orbits along a curve, made by `continue_curve`.

    Between two strong resonances 1:1, or 1:2, the pair on a curve of torus points is real, each the
    inverse of the other: there it is a curve of neutral saddles, at which no torus is born.

    Attributes
    ----------
    kind
        "fold", "period_doubling", "torus", "symmetry_breaking" or "grazing".
    paths
        Paths of the two parameters.
    values
        (m, 2) array, their values in each row.
    multipliers
        (m, 2 n) complex array, the largest of each orbit first.
    orbits
        The orbits.
    special_points
        The points of codimension two found, in order; each is a row.
    end_reason
        Why the curve ends where it does.
    """

    kind: str
    paths: tuple[str, str]
    values: Floats
    multipliers: Complexes
    orbits: tuple[StructureOrbit, ...] = field(repr=False)
    special_points: tuple[StructureCurvePoint, ...]
    end_reason: str

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset along ``point``, for files and for pandas."""
        import xarray

        table = xarray.Dataset(
            {
                "value": (("point", "parameter"), self.values),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
            },
            coords={"parameter": list(self.paths)},
            attrs={"kind": self.kind, "end_reason": self.end_reason},
        )
        return with_units(table, self.orbits[0], *self.paths)


def half_map(orbit: StructureOrbit) -> Floats:
    """Return the derivative of the map over half a symmetric orbit, mirrored."""
    state, half = np.concatenate([orbit.x0, orbit.v0]), 0.5 * orbit.period
    return -map_between(orbit.run.system, state, (0.0, half), "half of it").derivative


class _CurveDetector:
    """Finds points of codimension two between neighbours on a curve."""

    def __init__(self, kind: str) -> None:
        self.condition = CONDITIONS[kind]
        self.own = kind if kind in ORDER else OTHERS[self.condition]

    def map_of(self, orbit: StructureOrbit) -> Floats:
        """Return the derivative of the map whose multipliers are looked at."""
        return half_map(orbit) if self.own == "symmetry_breaking" else orbit.monodromy

    def tests(self, orbit: StructureOrbit) -> Mapping[str, float]:
        """Return functions that are zero at such points: by kind."""
        tests, functions = tests_of_matrix(self.map_of(orbit)), {}
        if self.condition == "torus":
            # Of two real ones the mean goes on smoothly.
            mean = 0.5 * sum(_pair_on_circle(orbit.multipliers.tolist())).real
            functions = {kind: mean - cosine for kind, cosine in RESONANCES.items()}
        for name, other in OTHERS.items():
            if self.condition != name:
                pair = sorted((self.own, other), key=ORDER.index)
                functions["_".join(pair)] = tests[name]
        return functions

    def kind_of(self, kind: str, orbit: StructureOrbit) -> str | None:
        """Return the kind of a point at which the test of a kind is zero, None if it is none.

        The test for torus points is zero where two multipliers are 1, or -1, too, and at a neutral
        saddle; on a curve of torus points the others are zero at strong resonances.
        """
        if "torus" not in kind:
            return kind
        values = multipliers_of_matrix(self.map_of(orbit)).tolist()
        for name, double in (("resonance_1_1", 1.0), ("resonance_1_2", -1.0)):
            if sum(abs(value - double) < DOUBLE for value in values) > 1:
                # On a curve of torus points the angle of the pair tells of it. Of a symmetric orbit
                # the multipliers are those of half of it.
                others = {"torus": None, "symmetry_breaking": kind}
                return others.get(self.own, name)
        return kind if self.own == "torus" or _pair_on_circle(values)[0].imag != 0.0 else None

    def between(
        self, here: Point[StructureEquations], new: Point[StructureEquations]
    ) -> Segment[StructureEquations, StructureCurvePoint]:
        """Return the points of codimension two between two neighbours, in order."""
        equations = here.problem
        before, after = dict(self.tests(here.orbit)), dict(self.tests(new.orbit))
        side = np.zeros(equations.size)
        if self.condition == "multiplier 1":
            side = null_vectors(equations.closure(here.z)[1])[0]
            before[CUSP], after[CUSP] = (bend(equations, p.z, side) for p in (here, new))
        rows, is_astray = [], False
        for kind, value in before.items():
            ends = value, after[kind]
            if not changes_sign(*ends):
                continue

            def test(z: Floats, kind: str = kind) -> float:
                if kind == CUSP:
                    return bend(equations, z, side)
                return self.tests(equations.solution(z))[kind]

            zero = locate(here, new, test, ends)
            if zero is None or not zero.goes_through:
                is_astray = True
                continue
            found = self.kind_of(kind, zero.orbit)
            if found is None:
                continue
            values = cast("tuple[float, float]", equations.values(zero.z))
            paths = cast("tuple[str, str]", equations.paths)
            special = StructureCurvePoint(found, paths, values, zero.orbit, -1)
            point = Point(zero.z, new.tangent, zero.orbit, new.tests, equations)
            rows.append((zero.part, point, special))
        rows.sort(key=lambda row: row[0])
        return Segment([(point, special) for _, point, special in rows], is_astray=is_astray)

    def stopped(
        self, here: Point[StructureEquations], reason: str
    ) -> Segment[StructureEquations, StructureCurvePoint]:
        """Return what is beyond the last point: the same curve where an event is at its state."""
        if self.condition != GRAZE:
            stop = _touched_stop(here.problem, here.orbit)
            reason += "" if stop is None else f"; the orbit grazes stop {stop} there"
        return Segment([], reason, begun_anew(here))


def _touched_stop(equations: StructureEquations, orbit: StructureOrbit) -> int | None:
    """Return the stop that an orbit at the end of a curve all but grazes, None if there is none."""
    run, (length, speed) = orbit.run, equations.units[[0, -1]]
    t = np.linspace(0.0, run.t_end, LOOKED)
    x, v = run(t)
    for k, (stop, normal) in enumerate(
        zip(orbit.structure.stops, orbit.structure.stop_directions, strict=True)
    ):
        gap, pace = matmul(x, normal) - as_float(stop.at), matmul(v, normal)
        met = (run.impacts.t[run.impacts.stop == k], run.crossings.t[run.crossings.stop == k])
        turns = (pace[:-1] * pace[1:] <= 0.0) & (np.histogram(np.concatenate(met), t)[0] == 0)
        speeds = (
            run.impacts.v_before[run.impacts.stop == k],
            run.crossings.v[run.crossings.stop == k],
        )
        slowest = np.abs(np.concatenate(speeds)).min(initial=math.inf)
        nearest = np.abs(gap[:-1][turns]).min(initial=math.inf)
        if nearest < TOUCHED * length or slowest < math.sqrt(TOUCHED) * speed:
            return k
    return None


def null_vectors(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the left and the right null vector of a singular matrix, of unit length.

    Examples
    --------
    >>> left, right = null_vectors(np.array([[1.0, 2.0], [3.0, 6.0]]))
    >>> bool(abs(left[0] + 3 * left[1]) < 1e-15), bool(abs(right[0] + 2 * right[1]) < 1e-15)
    (True, True)
    """
    return directions(matrix.T)[1][-1], directions(matrix)[1][-1]


def bend(equations: StructureEquations, z: Floats, side: Floats) -> float:
    """Return psi' F_uu q q of an orbit on a fold, whose zeros are cusps (Kuznetsov 2004, 8.2).

    The sign is that of the left null vector psi on the side of a vector.
    """
    left, right = null_vectors(equations.closure(z)[1])
    along = np.concatenate([CENTRAL * right, np.zeros(len(equations.paths))])
    ahead, behind = (equations.closure(z + step)[1] for step in (along, -along))
    second = dot(left, matmul((ahead - behind) / (2.0 * CENTRAL), right))
    return math.copysign(1.0, dot(left, side)) * second


def _pair_on_circle(values: Sequence[complex]) -> tuple[complex, complex]:
    """Return the two multipliers whose product is nearest to 1."""
    pairs = ((a, b) for i, a in enumerate(values) for b in values[i + 1 :])
    return min(
        pairs, key=lambda pair: abs(abs(pair[0] * pair[1]) - 1.0) + abs((pair[0] * pair[1]).imag)
    )


def continue_structure_curve(
    point: StructureSpecialPoint,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> StructureCurve:
    """Follow a special point of a structure's orbits in two parameters, both ways.

    The arguments are those of `continue_curve`. The equations are those of the orbit together with
    the condition on its multipliers, whose derivatives are differences; at a graze those of the
    orbit that touches the stop without velocity, where a symmetry breaks those of half the orbit.

    Raises
    ------
    ParameterError
        If no curve goes through points of that kind, there are not two such parameters, a range
        does not hold the value at the point, or the symmetry is lost when they vary.
    """
    if point.kind not in CONDITIONS:
        known = ", ".join(CONDITIONS)
        raise ParameterError("point", point.kind, f"no curve of a structure: of {known} there is")
    check_mapping("over", over, "two parameters and their ranges", 2)
    orbit = point.orbit
    names = [long_form(path, orbit.structure, orbit.loads) for path in over]
    values = [structure_parameter(orbit, path) for path in over]
    ranges, sign = ranges_of_curve(over, names, values)
    condition = CONDITIONS[point.kind]
    steps = StepLimits.checked(max_points, largest_step)
    reported = Progress(progress, 2 * steps.max_points, "orbits", is_bound=True)
    equations: StructureEquations
    if point.kind == "symmetry_breaking":
        if not orbit.admissible:
            raise ParameterError("point", point, FORMAL)
        equations = StructureEquations(orbit, ranges, condition, is_half=True)

        def is_symmetric(values: tuple[float, ...]) -> bool:
            system = equations.system_at(values)
            return is_symmetric_structure(system.structure, system.loads)

        if not keep_symmetry(is_symmetric, values, ranges.values()):
            raise ParameterError("over", tuple(ranges), SYMMETRY_LOST)
    elif point.kind == "grazing":
        equations = WallEquations(orbit, ranges, condition, graze_of(orbit))
    elif meets_walls_in_turn(orbit):
        equations = WallEquations(orbit, ranges, condition)
    else:
        equations = StructureEquations(orbit, ranges, condition)
    start = equations.started(orbit, values)
    rows, why = follow_both_ways(start, sign, _CurveDetector(point.kind), steps, reported)
    orbits: tuple[Any, ...] = tuple(place.orbit for place, _ in rows)
    return StructureCurve(
        kind=point.kind,
        paths=cast("tuple[str, str]", equations.paths),
        values=np.array([equations.values(place.z) for place, _ in rows]),
        multipliers=np.array([orbit.multipliers for orbit in orbits]),
        orbits=orbits,
        special_points=special_points_of(rows),
        end_reason=why,
    )
