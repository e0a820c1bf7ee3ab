"""Following folds, period doublings, symmetry breakings and grazes in two parameters."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float, real, whole
from percuss.model.paths import get_parameter, long_form
from percuss.orbits.curves.curve import Curve, CurveKind
from percuss.orbits.curves.curve_equations import CurveEquations
from percuss.orbits.curves.curve_start import equations_of
from percuss.orbits.curves.curve_walk import CurveRow, CurveWalk
from percuss.orbits.families.special_points import SpecialPoint
from percuss.orbits.families.walk import STOPPED
from percuss.progress import Progress, Report

__all__ = ["continue_curve"]


def continue_curve(
    point: SpecialPoint,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Curve:
    """Follow a special point of a branch along a curve in two parameters, both ways.

    Folds, period doublings and symmetry breakings are followed as the orbits for which the
    equations of `continue_orbit` are singular, together with those equations (Govaerts 2000;
    Kuznetsov 2004, chapter 10); grazes as the orbits that touch a stop, motions without impacts
    in closed form. All is smooth where an impact loses its velocity: a curve of folds goes
    through its end on the curve of grazing, and its orbits are formal on the other side.

    Parameters
    ----------
    point
        A fold, period doubling, symmetry breaking or graze, as `continue_orbit` finds them.
    over
        Two parameters by their paths, and the ranges to follow the curve in; the point's own
        values lie in them. The curve is told from the end towards the first value of the first
        parameter.
    max_points
        The most steps each way.
    largest_step
        The longest step of the parameters, as a part of their ranges.
    progress
        True for a line on the error stream, or a function (orbits done, the most there can be)
        that returns False to stop; what was followed is returned.

    Returns
    -------
    Curve
        A table, with `special_points` of codimension two and `end_reason`.

    Raises
    ------
    ParameterError
        If no curve goes through points of that kind, there are not two such parameters, or a
        range does not hold the value at the point.
    ConvergenceError
        If the point is none of the curve: a symmetry breaking in a system without symmetry.

    Examples
    --------
    Where motion without impacts begins to touch the wall, the closed form is
    A = d sqrt((k - w^2)^2 + (2 a w)^2):

    >>> import math
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> calm = pc.find_orbit(osc, pc.cosine(1.0, amplitude=0.05), n_impacts=0)
    >>> branch = pc.continue_orbit(calm, over={"forcing.amplitude": (0.05, 0.5)})
    >>> ranges = {"forcing.omega": (0.8, 1.2), "forcing.amplitude": (0.05, 0.5)}
    >>> curve = pc.continue_curve(branch.special_points[0], over=ranges)
    >>> omega, amplitude = curve.values[-1]
    >>> bool(abs(amplitude - math.hypot(1.0 - omega**2, 0.1 * omega)) < 1e-12)
    True
    >>> for place in curve.special_points:
    ...     print(place.kind, round(place.values[0], 9))
    resonant_grazing 0.998749218
    """
    ranges, way = _checked(point, over)
    max_points = whole("max_points", max_points, 1)
    largest_step = real("largest_step", largest_step)
    if not 0.0 < largest_step <= 1.0:
        raise ParameterError("largest_step", largest_step, "not above 0 and at most 1")
    equations, guess = equations_of(point, ranges)
    kind = cast("CurveKind", point.kind)
    reported = Progress(progress, 2 * max_points, "orbits", is_bound=True)
    walk = CurveWalk(equations, kind, max_points, largest_step, reported)
    start = walk.start(guess)
    leading = start.tangent[-2] if abs(start.tangent[-2]) > 1e-9 else start.tangent[-1]
    towards = way * math.copysign(1.0, leading)
    ahead, why_ahead, closed = walk.along(start, towards)
    behind: list[CurveRow] = []
    why = why_ahead
    if not closed and why != STOPPED:
        behind, why_behind, _ = walk.along(start, -towards)
        if behind:
            why = f"{why_behind}; at the other end {why_ahead}"
    reported.close()
    return _curve(kind, equations, [*reversed(behind), (start, None), *ahead], why)


def _checked(
    point: SpecialPoint, over: Mapping[str, tuple[Phase, Phase]]
) -> tuple[dict[str, tuple[float, float]], float]:
    """Return the ranges, upwards, and the way along the first."""
    if not isinstance(point, SpecialPoint):
        raise ParameterError("point", point, "no special point of a branch")
    if len(over) != 2:
        raise ParameterError("over", over, "not two parameters and their ranges")
    orbit = point.orbit
    names = [long_form(path, orbit.oscillator, orbit.forcing) for path in over]
    if names[0] == names[1]:
        raise ParameterError("over", tuple(over), f"twice the same parameter, {names[0]}")
    ranges, ways = {}, []
    for path, given in over.items():
        value = as_float(get_parameter(orbit.oscillator, orbit.forcing, None, path))
        try:
            first, last = (as_float(end) for end in given)
        except (TypeError, ValueError) as error:
            raise ParameterError(path, given, "not a range of two numbers") from error
        if first == last or not min(first, last) <= value <= max(first, last):
            reason = f"no range that holds the point's own value {value:.12g}"
            raise ParameterError(path, given, reason)
        ranges[path] = min(first, last), max(first, last)
        ways.append(math.copysign(1.0, last - first))
    return ranges, ways[0]


def _curve(
    kind: CurveKind, equations: CurveEquations, rows: list[CurveRow], end_reason: str
) -> Curve:
    points = [point for point, _ in rows]
    orbits = tuple(point.orbit for point in points)
    steps = np.diff([point.z for point in points], axis=0)
    special = tuple(
        dataclasses.replace(it, row=row) for row, (_, it) in enumerate(rows) if it is not None
    )
    speeds = [
        min((v for name, v in point.conditions.items() if name.startswith("velocity")), default=1.0)
        for point in points
    ]
    return Curve(
        kind=kind,
        paths=cast("tuple[str, str]", equations.equations.paths),
        values=np.array([equations.values(point.z) for point in points]),
        arclength=np.append(0.0, np.cumsum(np.sqrt((steps * steps).sum(axis=1)))),
        multipliers=np.array([orbit.multipliers for orbit in orbits]),
        stability=np.array([orbit.stability for orbit in orbits]),
        admissible=np.array([orbit.admissible for orbit in orbits]) & (np.array(speeds) > 0.0),
        orbits=orbits,
        special_points=special,
        end_reason=end_reason,
    )
