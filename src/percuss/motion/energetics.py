"""Forces and energy of a motion, from its positions and velocities."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags, Floats, Integers, row_of
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.flight import force_and_slopes, set_phases
from percuss.kernels.law_columns import N_HARMONICS, NUMBER, STOP_FIRST, STOP_LAST
from percuss.kernels.sample import drive
from percuss.model.exact import as_float, reals
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, SoftStop, Stop
from percuss.model.start import late_problem
from percuss.model.system import System, stop_rows, turns_of
from percuss.motion.tables import Contacts

# What moves as a force pushes: its acceleration is the force.
FREE = Oscillator(stiffness=0)


# Forces and energies beyond the largest double are infinite, sums of them no number.
@np.errstate(over="ignore", invalid="ignore")
def forces_at(
    system: System,
    contacts: Contacts,
    t: Floats,
    x: Floats,
    v: Floats,
    record: tuple[Floats, Integers] | None = None,
) -> dict[str, tuple[str | tuple[str, str], Floats]]:
    """Return spring, damping, forcing (n,) and stops (n_stops, n) as xarray variables.

    With the record of the motion, its events and marks, they are those after an event at its very
    instant; without it a soft stop acts where the mass is beyond it.
    """
    oscillator, mass = system.of_unit_mass.oscillator, system.mass
    spring = -as_float(oscillator.stiffness) * x
    damping = -2.0 * as_float(oscillator.damping) * v
    driving = _driving_at(system, t, None if record is None else record[0])
    stops = np.zeros((len(oscillator.stops), len(t)))
    for i, stop in enumerate(oscillator.stops):
        if isinstance(stop, SoftStop):
            depth = x - as_float(stop.at)
            push = -as_float(stop.stiffness) * depth - 2.0 * as_float(stop.damping) * v
            presses = _is_beyond(stop, depth)
            if record is not None:
                presses = _is_pressed(system, i, record, t)
            stops[i] = np.where(presses, push, 0.0)
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


@np.errstate(over="ignore", invalid="ignore")
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


def _is_pressed(system: System, stop: int, record: tuple[Floats, Integers], t: Floats) -> Flags:
    """Return whether a soft stop acts after each of times t, by the regions of a record."""
    events, marks = record
    rows = np.searchsorted(events[:, columns.EVENT_T], t, side="right") - 1
    numbers = system.law[marks[np.maximum(rows, 0), columns.NEXT_REGION], NUMBER]
    row = stop_rows(system.oscillator)[stop]
    return np.asarray((row[STOP_FIRST] <= numbers) & (numbers <= row[STOP_LAST]))


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
        If it is no forcing, or a time is not finite or later than 1e14 periods.

    Examples
    --------
    >>> import percuss as pc
    >>> pc.force_at(pc.cosine(2, constant=1) + pc.record([0, 1, 4], [0, 3, 0]), [0.0, 2.0])
    array([2.        , 2.34635638])
    """
    if not isinstance(force, Forcing):
        raise ParameterError("force", force, "not a forcing; of loads give one of their forcings")
    times = reals("t", t)
    if not np.isfinite(times).all():
        wrong = times[~np.isfinite(times)]
        raise ParameterError("t", float(wrong[0]), "not a finite time")
    system = System(FREE, force)
    latest = float(np.abs(times).max(initial=0.0))
    problem = late_problem(latest, max(turns_of(system.law)[1], default=0.0))
    if problem is not None:
        raise ParameterError("t", latest, problem)
    return _driving_at(system, times.reshape(-1)).reshape(times.shape)


def force_in_run(force: Forcing, t: Floats, events: Floats) -> Floats:
    """Return a force at times t (n,) of a run, at the very instant of one of its events that after it."""
    return _driving_at(System(FREE, force), t, events)


def _driving_at(system: System, t: Floats, events: Floats | None = None) -> Floats:
    """Return the forcing at times t (n,), per unit mass; after a jump at the instant of an event."""
    if system.forcing is None:
        return np.zeros_like(t)
    law, force = system.law, system.of_unit_mass.forcing
    assert force is not None
    phases = np.empty((int(law[0, N_HARMONICS]), 2))
    varying = np.empty_like(t)
    drive(law, row_of(t), phases, varying)
    if events is not None and force.record is not None:
        rows = np.searchsorted(events[:, columns.EVENT_T], t, side="right") - 1
        # The instant of a knot is a sum of two floats, of which an event's time is the first.
        at_event = events[rows, columns.EVENT_T] == t
        for i in np.flatnonzero(at_event).tolist():
            set_phases(law, t[i], events[rows[i], columns.EVENT_T_LOW], phases)
            varying[i] = force_and_slopes(law, phases)[0]
    return as_float(force.constant) + varying
