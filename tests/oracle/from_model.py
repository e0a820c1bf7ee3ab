"""The oracle's problem of what a user of percuss describes, every number exact."""

from __future__ import annotations

import mpmath
from tests.oracle.curves import Harmonic
from tests.oracle.event_driven import Problem, Soft, Wall, number

import percuss as pc
from percuss.model.exact import angle, as_fraction
from percuss.model.forcing import FourierTerm

# More digits than any test asks for.
DIGITS = 300


def problem_of(oscillator: pc.Oscillator, force: pc.Forcing | None = None) -> Problem:
    """Return the same equation, per unit mass, for `event_driven.simulate`."""
    if oscillator.mass is not None:
        force = None if force is None else force.acceleration_of(oscillator.mass)
        oscillator = oscillator.of_unit_mass()
    stops: list[Wall | Soft] = []
    for stop in oscillator.stops:
        at = as_fraction(stop.at)
        if isinstance(stop, pc.Wall):
            stops.append(Wall(at, stop.side, as_fraction(stop.restitution)))
        else:
            stiffness, damping = as_fraction(stop.stiffness), as_fraction(stop.damping)
            stops.append(Soft(at, stop.side, stiffness, damping))
    if force is None:
        force = pc.Forcing()
    return Problem(
        as_fraction(oscillator.damping),
        as_fraction(oscillator.stiffness),
        as_fraction(force.constant),
        tuple(_harmonic(part, force) for part in force.harmonics),
        tuple(stops),
    )


def _harmonic(part: pc.Harmonic | FourierTerm, force: pc.Forcing) -> Harmonic:
    if isinstance(part, FourierTerm):
        assert force.base is not None
        omega = part.n * as_fraction(force.base)
        return Harmonic(omega, as_fraction(part.cos), as_fraction(part.sin))
    with mpmath.workdps(DIGITS):
        times, plus = (number(value) for value in angle(part.phase))
        turn = mpmath.expjpi(times) * mpmath.expj(plus)
        amplitude = number(as_fraction(part.amplitude))
        return Harmonic(as_fraction(part.omega), amplitude * turn.real, -amplitude * turn.imag)
