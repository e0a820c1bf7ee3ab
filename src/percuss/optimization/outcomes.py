"""The outcomes of a motion that a design asks for, and their derivatives."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.motion.moved_measures import MovedMeasure
from percuss.motion.oscillator_measures import measure_and_derivative
from percuss.motion.sensitivity import Sensitivity
from percuss.orbits.orbit.moved_orbit import OrbitSensitivity
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["AnySensitivity", "OutcomeName", "check_outcome", "outcome_names", "outcome_of"]

# The outcomes that orbits alone have.
OfOrbit: TypeAlias = Literal["grazing_margin", "multiplier", "period"]
OutcomeName: TypeAlias = MovedMeasure | OfOrbit
AnySensitivity: TypeAlias = Sensitivity | OrbitSensitivity


def outcome_names(*, of_orbit: bool) -> tuple[str, ...]:
    """Return the names of the outcomes of an orbit, or of a run."""
    return get_args(MovedMeasure) + (get_args(OfOrbit) if of_orbit else ())


def check_outcome(name: object, *, of_orbit: bool) -> None:
    """Raise ParameterError unless it is the name of an outcome of an orbit, or of a run."""
    known = outcome_names(of_orbit=of_orbit)
    if name not in known:
        whose = "an orbit" if of_orbit else "a run"
        reason = f"none of the outcomes of {whose} with a derivative: {', '.join(known)}"
        raise ParameterError("outcome", name, reason)


def outcome_of(orbit: PeriodicOrbit | None, d: AnySensitivity, name: str) -> tuple[float, Floats]:
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
        return measure_and_derivative(d, name)
    assert orbit is not None
    if name == "period":
        return orbit.period, d.period
    if name == "multiplier":
        return _largest_multiplier(orbit, d)
    if name == "grazing_margin":
        return orbit.grazing_margin, _moved_margin(orbit, d)
    return measure_and_derivative(d.motion, name)


def _largest_multiplier(orbit: PeriodicOrbit, d: OrbitSensitivity) -> tuple[float, Floats]:
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
    if not len(turns.t):
        return np.zeros(len(d.paths))
    k = int(np.argmin(turns.clearance))
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
