"""Following folds, period doublings, symmetry breakings and grazes in two parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast, overload

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels.law_columns import PERIOD
from percuss.model.exact import Phase
from percuss.model.faults import check_mapping
from percuss.model.paths import long_form
from percuss.orbits.bifurcations.bifurcation_origin import ONE_AND_THE_SAME
from percuss.orbits.bifurcations.branch_equations import OrbitEquations
from percuss.orbits.bifurcations.curve import (
    Curve,
    CurveDetector,
    CurveKind,
    CurveRow,
    with_point_at_start,
)
from percuss.orbits.bifurcations.curve_equations import (
    CurveEquations,
    HalfEquations,
    MultiplierCurve,
)
from percuss.orbits.bifurcations.grazing_contact import (
    GrazingContact,
    grazing_contacts,
    in_time_of,
    without,
)
from percuss.orbits.bifurcations.grazing_curves import (
    GrazingCurve,
    SteadyGrazingCurve,
    mirrored,
    others_of,
)
from percuss.orbits.bifurcations.multiple_covers import primitive_orbit
from percuss.orbits.bifurcations.parameter_ranges import Ranges, own_value, ranges_of_curve
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.bifurcations.structure_branch import StructureSpecialPoint
from percuss.orbits.bifurcations.structure_curve import StructureCurve, continue_structure_curve
from percuss.orbits.continuation.follow import StepLimits, follow_both_ways, special_points_of
from percuss.orbits.orbit.itinerary import entries_of
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import SYMMETRY_LOST, is_symmetric_system, keep_symmetry
from percuss.progress import Progress, Report


@overload
def continue_curve(
    point: SpecialPoint,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Curve: ...
@overload
def continue_curve(
    point: StructureSpecialPoint,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> StructureCurve: ...
def continue_curve(
    point: SpecialPoint | StructureSpecialPoint,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> Curve | StructureCurve:
    """Follow a special point of a branch along a curve in two parameters, both ways.

    Folds, period doublings and symmetry breakings are followed as the orbits for which the
    equations of `continue_orbit` are singular, together with those equations (Govaerts 2000;
    Kuznetsov 2004, chapter 10); grazes as the orbits that graze a stop, motions without impacts
    in closed form. All equations are smooth where the velocity of an impact goes through zero: a
    curve of folds passes its end on the curve of grazing, and its orbits are formal beyond it.

    Of a structure folds, period doublings, torus points and grazes are followed, folds with their
    cusps, torus points with their strong resonances, grazes of walls and soft stops as orbits that
    touch without velocity.

    Parameters
    ----------
    point
        A fold, period doubling, symmetry breaking or graze, as `continue_orbit` finds them; of a
        structure a fold, period doubling, symmetry breaking, torus point or graze.
    over
        Two parameters by their paths, and the ranges to follow the curve in; the point's own
        values lie in them. The curve begins at its end towards the first value of the first
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
        If no curve goes through points of that kind, there are not two such parameters, a range
        does not hold the value at the point, or the symmetry that breaks is lost when they vary.
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
    if isinstance(point, StructureSpecialPoint):
        return continue_structure_curve(
            point, over, max_points=max_points, largest_step=largest_step, progress=progress
        )
    ranges, sign = _checked(point, over)
    steps = StepLimits.checked(max_points, largest_step)
    equations, guess = equations_of(point, ranges)
    kind = cast("CurveKind", point.kind)
    reported = Progress(progress, 2 * steps.max_points, "orbits", is_bound=True)
    start = equations.started(guess)
    rows, why = follow_both_ways(start, sign, CurveDetector(kind), steps, reported)
    return _curve(kind, equations, with_point_at_start(kind, rows, start), why)


def _checked(point: SpecialPoint, over: Mapping[str, tuple[Phase, Phase]]) -> tuple[Ranges, float]:
    """Return the ranges, upwards, and the direction along the first."""
    if not isinstance(point, SpecialPoint):
        raise ParameterError("point", point, "no special point of a branch")
    check_mapping("over", over, "two parameters and their ranges", 2)
    orbit = point.orbit
    names = [long_form(path, orbit.oscillator, orbit.forcing) for path in over]
    return ranges_of_curve(over, names, [own_value(orbit, path) for path in over])


def _curve(
    kind: CurveKind, equations: CurveEquations, rows: list[CurveRow], end_reason: str
) -> Curve:
    points = [point for point, _ in rows]
    orbits = tuple(point.orbit for point in points)
    steps = np.diff([point.z for point in points], axis=0)
    speeds = [
        min((v for name, v in point.tests.items() if name.startswith("velocity")), default=1.0)
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
        special_points=special_points_of(rows),
        end_reason=end_reason,
    )


KINDS = ("fold", "period_doubling", "symmetry_breaking", "grazing")


def equations_of(point: SpecialPoint, ranges: Ranges) -> tuple[CurveEquations, Floats]:
    """Return the equations of the curve through a special point, and the point as its first.

    Parameters
    ----------
    point
        One of the kinds that make curves.
    ranges
        Lowest and highest value of the two parameters by their paths.

    Raises
    ------
    ParameterError
        If the kind makes no curve.
    """
    if point.kind not in KINDS:
        known = ", ".join(KINDS[:-1])
        reason = f"no kind of point that a curve goes through here: {known} or {KINDS[-1]}"
        raise ParameterError("point.kind", point.kind, reason)
    if math.isinf(point.orbit.n_impacts):
        raise ParameterError("point", point, "its orbit sticks; curves are those of other orbits")
    if point.kind == "grazing":
        return _of_graze(point.orbit, ranges)
    orbit = point.orbit
    if point.kind == "period_doubling" and orbit.itinerary.halves_differ() <= ONE_AND_THE_SAME:
        # A doubled branch starts here: the curve is that of the orbit that doubles.
        orbit = primitive_orbit(orbit)
    if orbit.n_periods == 0:
        raise ParameterError("point", point, "the motion is free; curves need a forcing")
    if point.kind == "symmetry_breaking":
        if not _keep_symmetry(orbit, ranges):
            raise ParameterError("over", tuple(ranges), SYMMETRY_LOST)
        equations: OrbitEquations = HalfEquations(orbit, ranges)
    else:
        equations = OrbitEquations(orbit, ranges)
    start = np.append(equations.unknowns_of(orbit), _parts(equations))
    return MultiplierCurve(equations, 1.0 if point.kind == "fold" else -1.0, start), start


def _parts(equations: OrbitEquations) -> Floats:
    own = enumerate(equations.own_values)
    return np.array([equations.part_of(k, value) for k, value in own])


def _of_graze(orbit: PeriodicOrbit, ranges: Ranges) -> tuple[CurveEquations, Floats]:
    contacts = grazing_contacts(orbit)
    if not contacts or orbit.forcing is None:
        reason = "the orbit grazes no stop" if orbit.forcing else "it is free; curves need a force"
        raise ParameterError("point", orbit, reason)
    base = without(orbit, contacts)
    contact = in_time_of(base, orbit, contacts)[0]
    law = orbit.system.law
    equations = OrbitEquations(base, ranges)
    parts = _parts(equations)
    if equations.n == 0:
        cycle = contact.t / float(law[0, PERIOD])
        return SteadyGrazingCurve(equations, contact, orbit.n_periods), np.append(cycle, parts)
    others = others_of(base, contact)
    first = entries_of(base.system, others.events)[0][0]
    kept = np.roll(others.events, -first, axis=0)
    row, half = _row(contact), len(others.events) // 2
    if _keep_symmetry(base, ranges):
        opposite = _row(mirrored(law, contact))
        events = np.array([row, *others.events[:half], opposite, *others.events[half:]])
        with_graze: OrbitEquations = HalfEquations(base, ranges, events)
        equations = HalfEquations(base, ranges, kept)
    else:
        with_graze = OrbitEquations(base, ranges, np.array([row, *others.events]))
        equations = OrbitEquations(base, ranges, kept)
    curve = GrazingCurve(with_graze, equations, contact, first)
    start = np.append(curve.unknowns_of(others, orbit.period), parts)
    if curve.at_impact(start):
        reason = "the graze coincides with another event of the orbit, whatever the parameters are"
        raise ParameterError("point", orbit, f"{reason}; no curve goes through it")
    return curve, start


def _row(contact: GrazingContact) -> Integers:
    """Return a grazing contact as an event, after which the region is the same."""
    return np.array([contact.bound, contact.region, contact.region], dtype=np.int64)


def _keep_symmetry(orbit: PeriodicOrbit, ranges: Ranges) -> bool:
    """Return whether an orbit is symmetric, and its system for all values of the parameters."""
    if not orbit.symmetric:
        return False
    equations = OrbitEquations(orbit, ranges)

    def is_symmetric(values: tuple[float, ...]) -> bool:
        return is_symmetric_system(*equations.system_at(values))

    return keep_symmetry(is_symmetric, equations.own_values, ranges.values())
