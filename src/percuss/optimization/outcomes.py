"""The outcomes of a motion that a design asks for, and their derivatives."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.oscillator import On, Oscillator
from percuss.model.structure import Structure
from percuss.motion.moved_measures import RIGID, MovedMeasure, has_rigid_stops
from percuss.motion.sensitivity import Sensitivity
from percuss.motion.structure_measures import structure_measure_and_derivative
from percuss.motion.structure_sensitivity import StructureSensitivity
from percuss.orbits.orbit.moved_orbit import OrbitSensitivity
from percuss.orbits.orbit.moved_structure_orbit import StructureOrbitSensitivity
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

# The outcomes that orbits alone have.
OfOrbit: TypeAlias = Literal["grazing_margin", "multiplier", "period"]
OutcomeName: TypeAlias = MovedMeasure | OfOrbit
AnyOrbit: TypeAlias = PeriodicOrbit | StructureOrbit
AnySensitivity: TypeAlias = (
    Sensitivity | OrbitSensitivity | StructureSensitivity | StructureOrbitSensitivity
)
# Measures of one coordinate, whose names go on with it in a structure of several.
_OF_PLACE = ("displacement", "acceleration")


def outcome_names(model: Oscillator | Structure, *, of_orbit: bool) -> tuple[str, ...]:
    """Return the names of the outcomes of an orbit, or of a run."""
    names: list[str] = list(get_args(MovedMeasure))
    if isinstance(model, Oscillator):
        return (*names, *(get_args(OfOrbit) if of_orbit else ()))
    if model.n > 1:
        points = [*map(str, range(model.n)), *(name for name, _ in model.points)]
        names = [
            full
            for name in names
            for full in (
                [f"{name}_{point}" for point in points] if name.endswith(_OF_PLACE) else [name]
            )
        ]
    return (*names, *(("multiplier", "period") if of_orbit else ()))


def check_outcome(name: object, model: Oscillator | Structure, *, of_orbit: bool) -> None:
    """Raise ParameterError unless it is the name of an outcome of an orbit, or of a run."""
    known = outcome_names(model, of_orbit=of_orbit)
    if name not in known:
        whose = "an orbit" if of_orbit else "a run"
        of = "" if isinstance(model, Oscillator) else " of this structure"
        reason = f"none of the outcomes of {whose}{of} with a derivative: {', '.join(known)}"
        raise ParameterError("outcome", name, reason)
    if name == "peak_stop_force" and has_rigid_stops(model.stops):
        raise ParameterError("outcome", name, RIGID)


def outcome_of(orbit: AnyOrbit | None, d: AnySensitivity, name: str) -> tuple[float, Floats]:
    """Return an outcome of a motion, and its derivatives.

    Parameters
    ----------
    orbit
        The orbit; None for a run.
    d
        The derivative of the orbit or the run by the parameters.
    name
        The outcome.

    Returns
    -------
    float and (n_parameters,) array
        The value and its derivatives, NaN where it has none.
    """
    if isinstance(d, Sensitivity):
        return d.measured(name)
    if isinstance(d, StructureSensitivity):
        return d.measured(*_of_place(name, d.run.structure))
    assert orbit is not None
    if name == "period":
        return orbit.period, d.period
    if name == "multiplier":
        return _largest_multiplier(orbit, d)
    if isinstance(d, StructureOrbitSensitivity):
        measure, on = _of_place(name, d.motion.run.structure)
        return structure_measure_and_derivative(d.motion, measure, on, d.period)
    assert isinstance(orbit, PeriodicOrbit)
    if name == "grazing_margin":
        return orbit.grazing_margin, _moved_margin(orbit, d)
    assert isinstance(d, OrbitSensitivity)
    return d.measured(name)


def _of_place(name: str, structure: Structure) -> tuple[str, On | None]:
    """Return the measure of an outcome, and the coordinate or the point that it is of."""
    for measure in get_args(MovedMeasure):
        if name.startswith(f"{measure}_"):
            point = name.removeprefix(f"{measure}_")
            return measure, int(point) if point.isdecimal() else point
    return name, 0 if structure.n == 1 else None


def _largest_multiplier(
    orbit: AnyOrbit, d: OrbitSensitivity | StructureOrbitSensitivity
) -> tuple[float, Floats]:
    """Return the modulus of the largest multiplier, of a cycle of that which is not 1."""
    sizes = np.abs(orbit.multipliers)
    i = int(np.argmax(sizes))
    if orbit.n_periods == 0:
        i = int(np.argmax(np.abs(orbit.multipliers - 1.0)))
    value, moved = orbit.multipliers[i], d.multipliers[i]
    size = float(sizes[i])
    return size, np.real(np.conj(value) * moved) / size if size > 0.0 else np.zeros(len(d.paths))


def _moved_margin(orbit: PeriodicOrbit, d: OrbitSensitivity) -> Floats:
    """Return the derivatives of the distance of the nearest turning point to a stop."""
    turns = orbit.turning_points
    if math.isinf(orbit.grazing_margin):
        return np.zeros(len(d.paths))
    # The turning points of the hops that end in a contact do not count.
    k = int(np.argmin(np.abs(turns.clearance - orbit.grazing_margin)))
    run, lines = d.motion.run, orbit.system.lines
    # Without events the turning points of one and a half periods are known, and the motion of one.
    t = run.t0 + (float(turns.t[k]) - run.t0) % orbit.period
    bound = int(turns.bound[k])
    wall = lines.wall[bound]
    stop = lines.edges[bound][0] if wall is None else wall
    # At a turning point the velocity is zero: its instant plays no part.
    away = d.motion(t)[0] - d.motion.moved.stops[:, stop, 0]
    place = lines.at[bound]
    assert place is not None
    above = float(run(t)[0]) > float(place)
    return np.asarray(away if above == (turns.clearance[k] > 0.0) else -away)
