"""From a special point of a branch to the equations of the curve through it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.kernels.law import PERIOD
from percuss.kernels.record import Integers
from percuss.model.law import law
from percuss.orbits.curves.curve_equations import CurveEquations, MultiplierCurve
from percuss.orbits.curves.grazing_curves import GrazingCurve, SteadyGrazingCurve
from percuss.orbits.curves.half_equations import HalfEquations
from percuss.orbits.curves.touch_chain import mirrored, others_of
from percuss.orbits.families.equations import OrbitEquations, Ranges
from percuss.orbits.families.special_points import SpecialPoint
from percuss.orbits.families.touches import Touch, touches_of, without
from percuss.orbits.orbit.chain import entries_of
from percuss.orbits.orbit.making import orbit_of_solution
from percuss.orbits.orbit.newton import solve
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.symmetry import is_symmetric_system

__all__ = ["KINDS", "equations_of"]

Floats = NDArray[np.float64]

KINDS = ("fold", "period_doubling", "symmetry_breaking", "grazing")
# Of the halves of a doubled orbit where it comes from: they part with a square root.
ONE_AND_THE_SAME = 1e-4


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
    if point.kind == "period_doubling":
        orbit = _once_round(orbit)
    if orbit.n_periods == 0:
        raise ParameterError("point", point, "the motion is free; curves need a forcing")
    if point.kind == "symmetry_breaking":
        if not _keep_symmetry(orbit, ranges):
            reason = "the symmetry is lost when they vary, and there is no curve on which it breaks"
            raise ParameterError("over", tuple(ranges), reason)
        equations: OrbitEquations = HalfEquations(orbit, ranges)
    else:
        equations = OrbitEquations(orbit, ranges)
    start = np.append(equations.unknowns_of(orbit), _parts(equations))
    return MultiplierCurve(equations, 1.0 if point.kind == "fold" else -1.0, start), start


def _parts(equations: OrbitEquations) -> Floats:
    own = enumerate(equations.own_values)
    return np.array([equations.part_of(k, value) for k, value in own])


def _of_graze(orbit: PeriodicOrbit, ranges: Ranges) -> tuple[CurveEquations, Floats]:
    touches = touches_of(orbit)
    if not touches or orbit.forcing is None:
        reason = "the orbit touches no stop" if orbit.forcing else "it is free; curves need a force"
        raise ParameterError("point", orbit, reason)
    touch, calm = touches[0], without(orbit, touches)
    table = law(orbit.oscillator, orbit.forcing)
    equations = OrbitEquations(calm, ranges)
    parts = _parts(equations)
    if equations.n == 0:
        cycle = touch.t / float(table[0, PERIOD])
        return SteadyGrazingCurve(equations, touch, orbit.n_periods), np.append(cycle, parts)
    others = others_of(calm, touch)
    first = entries_of(calm.oscillator, table, others.chain)[0][0]
    kept = np.roll(others.chain, -first, axis=0)
    row, half = _row(touch), len(others.chain) // 2
    if _keep_symmetry(calm, ranges):
        opposite = _row(mirrored(table, touch))
        chain = np.array([row, *others.chain[:half], opposite, *others.chain[half:]])
        with_touch: OrbitEquations = HalfEquations(calm, ranges, chain)
        equations = HalfEquations(calm, ranges, kept)
    else:
        with_touch = OrbitEquations(calm, ranges, np.array([row, *others.chain]))
        equations = OrbitEquations(calm, ranges, kept)
    curve = GrazingCurve(with_touch, equations, touch, first)
    return curve, np.append(curve.unknowns_of(others, orbit.period), parts)


def _row(touch: Touch) -> Integers:
    """Return a touch as an event of a chain, after which the region is the same."""
    return np.array([touch.bound, touch.region, touch.region], dtype=np.int64)


def _keep_symmetry(orbit: PeriodicOrbit, ranges: Ranges) -> bool:
    """Tell whether an orbit is symmetric, and the system remains so when the parameters vary."""
    if not orbit.symmetric:
        return False
    equations = OrbitEquations(orbit, ranges)
    for k in range(len(equations.paths)):
        for part in (0.25, 0.75):
            values = list(equations.own_values)
            values[k] = equations.value_at(k, part)
            try:
                system = equations.system_at(tuple(values))
            except ParameterError:
                # A value that the parameter cannot have alone tells nothing.
                continue
            if not is_symmetric_system(*system):
                return False
    return True


def _once_round(orbit: PeriodicOrbit) -> PeriodicOrbit:
    """Return the orbit itself, or the shorter one that it goes round twice."""
    n = len(orbit._chain)
    half = n // 2
    if n % 2 or orbit.n_periods % 2:
        return orbit
    lasting, speeds = orbit._unknowns[1 : 1 + n], orbit._unknowns[1 + n :]
    apart = np.append(
        (lasting[:half] - lasting[half:]) / orbit.period,
        (speeds[:half] - speeds[half:]) / np.abs(speeds).max(),
    )
    if np.abs(apart).max() > ONE_AND_THE_SAME:
        return orbit
    table = law(orbit.oscillator, orbit.forcing)
    mean = [0.5 * (each[:half] + each[half:]) for each in (lasting, speeds)]
    guess = np.concatenate([orbit._unknowns[:1], *mean])
    chain, n_periods = orbit._chain[:half].copy(), orbit.n_periods // 2
    found = solve(table, chain, guess, n_periods * float(table[0, PERIOD]))
    found = dataclasses.replace(found, converged=True, isolated=True)
    return orbit_of_solution(orbit.oscillator, orbit.forcing, chain, found, n_periods)
