"""The points of codimension two on a curve, between two neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from percuss.model.stops import SoftStop
from percuss.numerics import norm
from percuss.orbits.curves.curve import CurveKind, CurvePoint, CurvePointKind
from percuss.orbits.curves.curve_equations import CurveEquations
from percuss.orbits.curves.curve_zeros import find_curve_zero
from percuss.orbits.families.conditions import Point
from percuss.orbits.families.locating import Zero, changes_sign
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["curve_points_between", "lost_stop", "met_stop"]

Floats = NDArray[np.float64]
Found: TypeAlias = tuple[CurvePoint, Point]

# Brackets in the parameters that are a location, as a part of them.
LOCATED = 1e-10
# Velocities below this part of the scale are too small to tell a passage beside an impact.
SLOW = 1e-6
# Velocities into a soft stop below this part of the scale: it is hardly met.
HARDLY = 1e-4
# Special points nearer than this are one.
SAME = 1e-8


def curve_points_between(
    equations: CurveEquations, kind: CurveKind, a: Point, b: Point
) -> Iterator[Found]:
    """Return the points of codimension two between two neighbours on a curve, with row -1.

    Parameters
    ----------
    equations
        Those of the curve, settled at ``a``.
    kind
        What kind of curve it is.
    a, b
        The neighbours.
    """
    n = equations.pieces(a.z, b.z)
    before = a
    for k in range(1, n + 1):
        after = b if k == n else _between(equations, a, b, k / n)
        yield from _points_of_piece(equations, kind, before, after)
        before = after


def _between(equations: CurveEquations, a: Point, b: Point, part: float) -> Point:
    chord = b.z - a.z
    z = equations.corrected(a.z + part * chord, chord / norm(chord))
    return Point(z, a.tangent, *equations.told(z))


def _points_of_piece(
    equations: CurveEquations, kind: CurveKind, a: Point, b: Point
) -> Iterator[Found]:
    zeros: list[tuple[str, Zero]] = []
    changed = [name for name, v in a.conditions.items() if changes_sign(v, b.conditions[name])]
    # Where an impact has no velocity a formal orbit has a passage beside it, which vanishes too.
    for name in sorted(changed, key=lambda name: name == "passage"):
        if name == "passage" and any(_is_slow(equations, zero.orbit) for _, zero in zeros):
            continue
        zero = find_curve_zero(equations, a, b, name)
        if zero is not None:
            zeros.append((name, zero))
    zeros.sort(key=lambda found: found[1].part)
    last: Found | None = None
    for name, zero in zeros:
        it, detail = _meaning(equations, kind, name)
        same = last is not None and norm(zero.z - last[1].z) < SAME
        if last is not None and same and last[0].kind == it:
            continue
        if last is not None:
            yield last
        orbit, conditions = equations.told(zero.z)
        there = Point(zero.z, a.tangent, orbit, conditions)
        last = _point(equations, it, detail, zero, orbit), there
    if last is not None:
        yield last


def lost_stop(equations: CurveEquations, conditions: Mapping[str, float]) -> str:
    """Tell which soft stop is hardly met, "" if none is.

    There the time inside the stop vanishes, and a factor of the equations with it: they tell
    folds no more. The curves on the other side, and that of grazing, lead to the point itself.
    """
    orbits = equations.orbits
    for k, (row, stop, _) in enumerate(orbits.ways):
        slowest = HARDLY * orbits.scale[-1]
        if not orbits.walls[row] and conditions[f"velocity {k}"] < slowest:
            return f"the orbit hardly meets soft stop {stop}"
    return ""


def met_stop(equations: CurveEquations, a: Point, b: Point) -> str:
    """Tell which soft stop is met once more from one point to the next, "" if none is."""
    if a.conditions["passage"] > 0.0 >= b.conditions["passage"]:
        for stop in b.orbit.passages.stop.tolist():
            if isinstance(equations.orbits.oscillator.stops[stop], SoftStop):
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
    sizes = zip(intervals, values, strict=True)
    near = all(high - low <= LOCATED * max(1.0, abs(value)) for (low, high), value in sizes)
    status: Literal["located", "bracketed"] = (
        "located" if near and zero.goes_through else "bracketed"
    )
    paths = cast("tuple[str, str]", equations.equations.paths)
    return CurvePoint(kind, paths, values, intervals, status, orbit, -1, detail)


MEANINGS: dict[str, tuple[CurvePointKind, str]] = {
    "cusp": ("cusp", "two curves of folds meet and end"),
    "return": (
        "resonant_grazing",
        "a neighbour's velocity does not bring it off the stop once round: curves of folds and "
        + "of period doublings touch the curve of grazing",
    ),
    "acceleration": ("degenerate_grazing", "the touch has no acceleration"),
}


def _meaning(equations: CurveEquations, kind: CurveKind, name: str) -> tuple[CurvePointKind, str]:
    if name in MEANINGS:
        return MEANINGS[name]
    if name == "one":
        return "fold_grazing", "a multiplier of the grazing orbit is 1"
    if name == "minus one":
        if equations.orbits.mirror < 0.0:
            return "symmetry_breaking_grazing", "the symmetry of the grazing orbit breaks"
        return "period_doubling_grazing", "a multiplier of the grazing orbit is -1"
    touch = "a turning point between two events touches a stop"
    if name.startswith("velocity"):
        stop = equations.orbits.ways[int(name.split()[1])][1]
        touch = f"an impact on stop {stop} has no velocity"
    if kind == "grazing":
        return "double_grazing", f"besides, {touch}"
    return cast("CurvePointKind", f"{kind}_grazing"), touch
