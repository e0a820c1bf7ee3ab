"""A curve in two parameters as a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Complexes, Flags, Floats
from percuss.model.oscillator import SoftStop
from percuss.motion.tables import HasTable
from percuss.numerics import norm
from percuss.orbits.bifurcations.bifurcation_origin import ENDS, Origin
from percuss.orbits.bifurcations.branch import CurveRows
from percuss.orbits.bifurcations.curve_equations import CurveEquations
from percuss.orbits.bifurcations.detector import COINCIDENCE
from percuss.orbits.bifurcations.origin_of_folds import origin_of_folds
from percuss.orbits.continuation.follow import Segment, unbounded_growth
from percuss.orbits.continuation.locate import Zero, changes_sign, locate
from percuss.orbits.continuation.problem import Point
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.table_units import with_units

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

CurveKind: TypeAlias = Literal["fold", "period_doubling", "symmetry_breaking", "grazing"]
CurvePointKind: TypeAlias = Literal[
    "cusp",
    "fold_grazing",
    "period_doubling_grazing",
    "symmetry_breaking_grazing",
    "resonant_grazing",
    "double_grazing",
    "degenerate_grazing",
    "degenerate_period_doubling",
    "degenerate_symmetry_breaking",
]


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """A point of codimension two: on a curve, and fulfilling one condition more.

    Attributes
    ----------
    kind
        "cusp" (two curves of folds meet and end), "fold_grazing", "period_doubling_grazing" and
        "symmetry_breaking_grazing" (an orbit with a multiplier of 1 or -1 grazes a stop),
        "resonant_grazing" (a neighbour of the grazing orbit comes back to the stop as fast as it
        left it, to first order: the square root in the return map has no effect),
        "double_grazing" (an orbit with two grazes), "degenerate_grazing" (a graze of zero
        acceleration), "degenerate_period_doubling" and "degenerate_symmetry_breaking" (a curve of
        folds ends on one of these: the orbits that fold come to be the two-fold cover of one that
        doubles, or a symmetric one).
    paths, values
        The two parameters and their values there.
    intervals
        Of each parameter, values between which it lies.
    status
        "located" if the intervals are below 1e-10 of the values, or of the ranges of the
        parameters, and the test function goes through zero; otherwise "bracketed".
    orbit
        The orbit there.
    row
        Its row in the curve.
    detail
        A description of the point.
    codimension
        Number of conditions: 2.
    """

    kind: CurvePointKind
    paths: tuple[str, str]
    values: tuple[float, float]
    intervals: tuple[tuple[float, float], tuple[float, float]]
    status: Literal["located", "bracketed"]
    orbit: PeriodicOrbit = field(repr=False)
    row: int
    detail: str
    codimension: int = 2


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Curve(CurveRows[PeriodicOrbit], HasTable):
    """Special points along a curve in two parameters, made by `continue_curve`; one row a point.

    Attributes
    ----------
    kind
        "fold", "period_doubling", "symmetry_breaking" or "grazing".
    paths
        Paths of the two parameters.
    values
        (n, 2) array, their values in each row.
    arclength
        (n,) array, distance along the curve, with the ranges of the parameters, the period and
        the largest velocity of the first orbit as units.
    multipliers
        (n, 2) complex array; of a grazing orbit those without the graze.
    stability
        (n,) array of texts, as in `PeriodicOrbit`; of a grazing orbit without the graze.
    admissible
        (n,) array, whether the orbit passes through no stop and meets each from its free side.
    orbits
        The orbits.
    special_points
        The points of codimension two found, in order; each is a row of the table.
    end_reason
        Why the curve ends where it does.
    """

    kind: CurveKind
    paths: tuple[str, str]
    values: Floats
    arclength: Floats
    multipliers: Complexes
    stability: NDArray[np.str_]
    admissible: Flags
    orbits: tuple[PeriodicOrbit, ...] = field(repr=False)
    special_points: tuple[CurvePoint, ...]
    end_reason: str

    def to_xarray(self) -> Dataset:
        """Return the table as a dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``; the points of codimension two along ``special_point``.

        Examples
        --------
        >>> import percuss as pc
        >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
        >>> calm = pc.find_orbit(osc, pc.cosine(1.3, amplitude=0.1), n_impacts=0)
        >>> branch = pc.continue_orbit(calm, over={"forcing.amplitude": (0.1, 1.0)})
        >>> ranges = {"forcing.omega": (1.2, 1.4), "forcing.amplitude": (0.1, 1.0)}
        >>> data = pc.continue_curve(branch.special_points[0], over=ranges).to_xarray()
        >>> data.value.dims, data.attrs["kind"]
        (('point', 'parameter'), 'grazing')
        """
        import xarray

        special = self.special_points
        values = np.array([point.values for point in special]).reshape(-1, 2)
        table = xarray.Dataset(
            {
                "value": (("point", "parameter"), self.values),
                "arclength": ("point", self.arclength),
                "multiplier_real": (("point", "multiplier"), self.multipliers.real),
                "multiplier_imag": (("point", "multiplier"), self.multipliers.imag),
                "stability": ("point", self.stability),
                "admissible": ("point", self.admissible),
                "special_kind": ("special_point", np.array([p.kind for p in special], dtype=str)),
                "special_value": (("special_point", "parameter"), values),
                "special_row": ("special_point", np.array([p.row for p in special], dtype=int)),
                "special_status": (
                    "special_point",
                    np.array([p.status for p in special], dtype=str),
                ),
            },
            coords={"parameter": list(self.paths)},
            attrs={"kind": self.kind, "end_reason": self.end_reason},
        )
        return with_units(table, self.orbits[0], *self.paths)


CurvesPoint: TypeAlias = Point[CurveEquations]
CurveRow: TypeAlias = tuple[CurvesPoint, CurvePoint | None]
LocatedPoint: TypeAlias = tuple[CurvePoint, CurvesPoint]

# Largest bracket of the parameters of a located point, as a part of them or of their ranges.
LOCATED = 1e-10
# At velocities below this part of the scale a turning point is the impact next to it.
SLOW = 1e-6
# Special points nearer than this are one.
SAME = 1e-8
# The part of the parameters in the tangent where velocities grow without bound.
STANDING = 1e-9


class CurveDetector:
    """Finds points of codimension two, and the ends of their curve.

    Parameters
    ----------
    kind
        The kind of curve.
    """

    def __init__(self, kind: CurveKind) -> None:
        self.kind = kind

    def stopped(
        self,
        here: CurvesPoint,
        reason: str,
    ) -> Segment[CurveEquations, CurvePoint]:
        """Return no points: none lies beyond the last."""
        return Segment([], here.problem.jump_met(here) or reason)

    def between(self, here: CurvesPoint, new: CurvesPoint) -> Segment[CurveEquations, CurvePoint]:
        """Return the points of codimension two between two points, up to the end of the curve."""
        lost = new.problem.lost_stop(new.tests)
        if lost:
            return Segment([], f"near {here.text} {lost}")
        rows: list[CurveRow] = [
            (point, special) for special, point in _points_between(self.kind, here, new)
        ]
        passed = origin_of_folds(here, new) if self.kind == "fold" else None
        if passed is not None:
            return self._up_to_origin(here, rows, *passed)
        orbits = here.problem.orbits
        before, after = (orbits.unknowns_of(each.orbit) for each in (here, new))
        reversed_ = orbits.reversed_flights(before, after)
        if reversed_:
            for k, (point, _) in enumerate(rows):
                if orbits.is_coincidence(orbits.unknowns_of(point.orbit), reversed_):
                    return Segment(rows[: k + 1], f"at {point.text} {COINCIDENCE}")
            return Segment(rows, f"beyond {(rows[-1][0] if rows else here).text} {COINCIDENCE}")
        change = _met_stop(here, new)
        if not change:
            growth = unbounded_growth(new, new.problem.size(new.z), STANDING)
            return Segment([*rows, (new, None)] if growth else rows, growth)
        last = rows[-1][0] if rows else new
        return Segment(rows, f"beyond {last.text} {change}")

    def _up_to_origin(
        self, here: CurvesPoint, rows: list[CurveRow], origin: Origin, zero: Zero
    ) -> Segment[CurveEquations, CurvePoint]:
        """Return the points up to where the orbits that fold come to simpler ones."""
        equations = here.problem
        kind, detail = ORIGINS[origin]
        special = _point(equations, kind, detail, zero, zero.orbit)
        point = Point(zero.z, here.tangent, *equations.evaluated(zero.z), equations)
        # Odd in the difference from the simpler orbit, the quadratic coefficient vanishes there, too.
        until = [
            row for row in rows
            if row[1] is not None and row[1].kind != "cusp"
            and norm(row[0].z - here.z) < norm(zero.z - here.z)
        ]  # fmt: skip
        return Segment([*until, (point, special)], f"at {point.text} {ENDS[origin]}")


def _points_between(kind: CurveKind, a: CurvesPoint, b: CurvesPoint) -> Iterator[LocatedPoint]:
    """Return the points of codimension two between two neighbours on a curve, with row -1.

    Parameters
    ----------
    kind
        The kind of curve.
    a, b
        The neighbours; the equations are settled at the first.
    """
    n = a.problem.pieces(a.z, b.z)
    before = a
    for k in range(1, n + 1):
        after = b if k == n else _between(a, b, k / n)
        yield from _points_of_piece(kind, before, after)
        before = after


def _between(a: CurvesPoint, b: CurvesPoint, part: float) -> CurvesPoint:
    chord = b.z - a.z
    z = a.problem.corrected(a.z + part * chord, chord / norm(chord))
    return Point(z, a.tangent, *a.problem.evaluated(z), a.problem)


def _points_of_piece(kind: CurveKind, a: CurvesPoint, b: CurvesPoint) -> Iterator[LocatedPoint]:
    equations = a.problem
    zeros: list[tuple[str, Zero]] = []
    changed = [name for name, v in a.tests.items() if changes_sign(v, b.tests[name])]
    # The clearance of a formal orbit vanishes with the velocity of the impact next to it.
    for name in sorted(changed, key=lambda name: name == "clearance"):
        if name == "clearance" and any(_is_slow(equations, zero.orbit) for _, zero in zeros):
            continue
        test, ends = partial(equations.test, name=name), (a.tests[name], b.tests[name])
        zero = locate(a, b, test, ends, near_others=False)
        if zero is not None:
            zeros.append((name, zero))
    zeros.sort(key=lambda named: named[1].part)
    last: LocatedPoint | None = None
    for name, zero in zeros:
        kind_of_zero, detail = _meaning(equations, kind, name)
        same = last is not None and norm(zero.z - last[1].z) < SAME
        if last is not None and same and last[0].kind == kind_of_zero:
            continue
        if last is not None:
            yield last
        orbit, tests = equations.evaluated(zero.z)
        point = Point(zero.z, a.tangent, orbit, tests, equations)
        last = _point(equations, kind_of_zero, detail, zero, orbit), point
    if last is not None:
        yield last


def with_point_at_start(
    kind: CurveKind, rows: list[CurveRow], start: CurvesPoint
) -> list[CurveRow]:
    """Return the rows of a curve with the point of codimension two that its start is, if it is one.

    A function that is zero all along the curve tells nothing.
    """
    k = next(k for k, (point, _) in enumerate(rows) if point is start)
    others = [point.tests for point, _ in rows[max(k - 1, 0) : k + 2] if point is not start]
    for name, value in start.tests.items():
        if value == 0.0 and any(tests[name] != 0.0 for tests in others):
            meaning = _meaning(start.problem, kind, name)
            zero = Zero(0.0, start.z, start.orbit, (start.z, start.z), goes_through=True)
            special = _point(start.problem, *meaning, zero, start.orbit)
            return [*rows[:k], (start, special), *rows[k + 1 :]]
    return rows


def _met_stop(a: CurvesPoint, b: CurvesPoint) -> str:
    """Return the soft stop that is met once more at the second point, "" for none."""
    if a.tests["clearance"] > 0.0 >= b.tests["clearance"]:
        for stop in b.orbit.passages.stop.tolist():
            if isinstance(a.problem.orbits.system.oscillator.stops[stop], SoftStop):
                return f"the orbit meets soft stop {stop} once more"
    return ""


def _is_slow(equations: CurveEquations, orbit: PeriodicOrbit) -> bool:
    orbits = equations.orbits
    if orbits.n == 0:
        return False
    return bool(np.abs(orbits.into_stops(orbit)).min() < SLOW * orbits.scale[-1])


def _point(
    equations: CurveEquations, kind: CurvePointKind, detail: str, zero: Zero, orbit: PeriodicOrbit
) -> CurvePoint:
    ends = [equations.values(z) for z in zero.ends]
    one, other = (sorted(pair) for pair in zip(*ends, strict=True))
    intervals = (one[0], one[1]), (other[0], other[1])
    values = equations.values(zero.z)
    whole = (
        high - low
        for low, high in zip(equations.equations.lows, equations.equations.highs, strict=True)
    )
    sizes = zip(intervals, values, whole, strict=True)
    near = all(
        high - low <= LOCATED * max(width, abs(value)) for (low, high), value, width in sizes
    )
    status: Literal["located", "bracketed"] = (
        "located" if near and zero.goes_through else "bracketed"
    )
    paths = cast("tuple[str, str]", equations.equations.paths)
    return CurvePoint(kind, paths, values, intervals, status, orbit, -1, detail)


# The points at which curves of folds end, by the simpler orbit that they come to.
ORIGINS: dict[Origin, tuple[CurvePointKind, str]] = {
    "doubled": ("degenerate_period_doubling", "folds end on the curve of period doublings"),
    "mirrored": ("degenerate_symmetry_breaking", "folds end on the curve of symmetry breakings"),
}
MEANINGS: dict[str, tuple[CurvePointKind, str]] = {
    "cusp": ("cusp", "two curves of folds meet and end"),
    "return": (
        "resonant_grazing",
        "a neighbour's velocity does not move it off the stop after a period: curves of folds and "
        + "of period doublings touch the curve of grazing",
    ),
    "acceleration": ("degenerate_grazing", "the graze has zero acceleration"),
}


def _meaning(equations: CurveEquations, kind: CurveKind, name: str) -> tuple[CurvePointKind, str]:
    if name in MEANINGS:
        return MEANINGS[name]
    if name == "multiplier 1":
        return "fold_grazing", "a multiplier of the grazing orbit is 1"
    if name == "multiplier -1":
        if equations.orbits.mirror < 0.0:
            return "symmetry_breaking_grazing", "the symmetry of the grazing orbit breaks"
        return "period_doubling_grazing", "a multiplier of the grazing orbit is -1"
    graze = "a turning point between two events grazes a stop"
    if name.startswith("velocity"):
        stop = equations.orbits.entries[int(name.split()[1])][1]
        graze = f"an impact on stop {stop} has no velocity"
    if kind == "grazing":
        return "double_grazing", f"besides, {graze}"
    return cast("CurvePointKind", f"{kind}_grazing"), graze
