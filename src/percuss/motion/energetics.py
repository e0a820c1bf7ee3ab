"""Forces and energy of a motion, from its positions and velocities."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags, Floats, row_of
from percuss.errors import ParameterError
from percuss.kernels.law_columns import N_HARMONICS
from percuss.kernels.sample import drive
from percuss.model.exact import as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, SoftStop, Stop
from percuss.model.system import System
from percuss.motion.tables import Contacts

__all__ = ["energy_at", "force_at", "forces_at"]

# What moves as a force pushes: its acceleration is the force.
FREE = Oscillator(stiffness=0)


def forces_at(
    system: System, contacts: Contacts, t: Floats, x: Floats, v: Floats
) -> dict[str, tuple[str | tuple[str, str], Floats]]:
    """Return spring, damping, forcing (n,) and stops (n_stops, n) as xarray variables."""
    oscillator, mass = system.of_unit_mass.oscillator, system.mass
    spring = -as_float(oscillator.stiffness) * x
    damping = -2.0 * as_float(oscillator.damping) * v
    driving = _driving_at(system, t)
    stops = np.zeros((len(oscillator.stops), len(t)))
    for i, stop in enumerate(oscillator.stops):
        if isinstance(stop, SoftStop):
            depth = x - as_float(stop.at)
            push = -as_float(stop.stiffness) * depth - 2.0 * as_float(stop.damping) * v
            stops[i] = np.where(_is_beyond(stop, depth), push, 0.0)
    # A mass in contact does not accelerate: the wall balances all other forces.
    others = spring + damping + driving + stops.sum(axis=0)
    for wall, start, release in zip(contacts.stop, contacts.start, contacts.release, strict=True):
        in_contact = (t >= start) & ~(t >= release)
        stops[wall] = np.where(in_contact, -others, stops[wall])
    return {
        "spring": ("t", mass * spring),
        "damping": ("t", mass * damping),
        "forcing": ("t", mass * driving),
        "stops": (("stop", "t"), mass * stops),
    }


def energy_at(system: System, x: Floats, v: Floats) -> Floats:
    """Return the kinetic energy and that of all springs."""
    oscillator = system.of_unit_mass.oscillator
    energy = 0.5 * v**2 + 0.5 * as_float(oscillator.stiffness) * x**2
    for stop in oscillator.stops:
        if isinstance(stop, SoftStop):
            depth = x - as_float(stop.at)
            stored = 0.5 * as_float(stop.stiffness) * depth**2
            energy = energy + np.where(_is_beyond(stop, depth), stored, 0.0)
    return np.asarray(system.mass * energy)


def _is_beyond(stop: Stop, depth: Floats) -> Flags:
    return depth > 0.0 if stop.side == "above" else depth < 0.0


def force_at(force: Forcing, t: ArrayLike) -> Floats:
    """Return the value of a force at times t.

    Parameters
    ----------
    force
        The forcing; those of loads are its ``forcings``.
    t
        Times, of any shape [time].

    Returns
    -------
    array
        Of t's shape, in the force's own dimension; where it jumps, the value after the jump.

    Raises
    ------
    ParameterError
        If it is no forcing, or a time is not finite.

    Examples
    --------
    >>> import percuss as pc
    >>> pc.force_at(pc.cosine(2, constant=1) + pc.record([0, 1, 4], [0, 3, 0]), [0.0, 2.0])
    array([2.        , 2.34635638])
    """
    if not isinstance(force, Forcing):
        raise ParameterError("force", force, "not a forcing; of loads give one of their forcings")
    times = np.asarray(t, dtype=np.float64)
    if not np.isfinite(times).all():
        wrong = times[~np.isfinite(times)]
        raise ParameterError("t", float(wrong[0]), "not a finite time")
    return _driving_at(System(FREE, force), times.reshape(-1)).reshape(times.shape)


def _driving_at(system: System, t: Floats) -> Floats:
    """Return the forcing at times t (n,), per unit mass."""
    if system.forcing is None:
        return np.zeros_like(t)
    harmonic = np.empty_like(t)
    drive(system.law, row_of(t), np.empty((int(system.law[0, N_HARMONICS]), 2)), harmonic)
    force = system.of_unit_mass.forcing
    assert force is not None
    return as_float(force.constant) + harmonic
