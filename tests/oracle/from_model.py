"""The oracle's problem of what a user of percuss describes, every number exact."""

from __future__ import annotations

import mpmath
from tests.oracle.curves import Harmonic
from tests.oracle.event_driven import Piece, Problem, Soft, Wall, number

import percuss as pc
from percuss.model.exact import angle, as_fraction
from percuss.model.force_record import ForceRecord
from percuss.model.forcing import FourierTerm
from percuss.model.restitution import restitution_knots

# More digits than any test asks for.
DIGITS = 300
# Repetitions of a record that are written down, a quarter more before t = 0, and an instant before
# all starts.
TURNS = 60
LONG_AGO = 10**6


def problem_of(oscillator: pc.Oscillator, force: pc.Forcing | None = None) -> Problem:
    """Return the same equation, per unit mass, for `event_driven.simulate`."""
    if oscillator.mass is not None:
        force = None if force is None else force.acceleration_of(oscillator.mass)
        oscillator = oscillator.of_unit_mass()
    stops: list[Wall | Soft] = []
    for stop in oscillator.stops:
        at = as_fraction(stop.at)
        if isinstance(stop, pc.Wall):
            knots = restitution_knots(stop.restitution)
            stops.append(Wall(at, stop.side, knots if len(knots) > 1 else knots[0][1]))
        else:
            stiffness, damping = as_fraction(stop.stiffness), as_fraction(stop.damping)
            stops.append(Soft(at, stop.side, stiffness, damping))
    if force is None:
        force = pc.Forcing()
    return Problem(
        as_fraction(oscillator.damping),
        as_fraction(oscillator.stiffness),
        as_fraction(force.constant),
        tuple(harmonic_of(part, force) for part in force.harmonics),
        tuple(stops),
        () if force.record is None else pieces_of(force.record),
    )


def pieces_of(record: ForceRecord) -> tuple[Piece, ...]:
    """Return the pieces of a record, a repeated one for so many turns."""
    with mpmath.workdps(DIGITS):
        pace = number(1 if record.omega is None else as_fraction(record.omega))
        size = number(as_fraction(record.amplitude))
        parts = [(number(a) * mpmath.pi + number(b)) / pace for a, b in map(angle, record.t)]
        forces = [size * number(as_fraction(f)) for f in record.f]
        linear = record.kind == "linear"
        turns = range(-TURNS // 4, TURNS) if record.repeat else range(1)
        inside = range(len(parts) - 1)
        pieces = [
            Piece(
                parts[i] + turn * (parts[-1] - parts[0]),
                forces[i],
                (forces[i + 1] - forces[i]) / (parts[i + 1] - parts[i]) if linear else number(0),
            )
            for turn in turns
            for i in inside
        ]
        if not record.repeat:
            outer = (forces[0], forces[-1]) if record.outside == "end" else (number(0), number(0))
            pieces = [Piece(number(-LONG_AGO), outer[0]), *pieces, Piece(parts[-1], outer[1])]
    return tuple(pieces)


def harmonic_of(part: pc.Harmonic | FourierTerm, force: pc.Forcing) -> Harmonic:
    if isinstance(part, FourierTerm):
        assert force.base is not None
        omega = part.n * as_fraction(force.base)
        return Harmonic(omega, as_fraction(part.cos), as_fraction(part.sin))
    with mpmath.workdps(DIGITS):
        times, plus = (number(value) for value in angle(part.phase))
        turn = mpmath.expjpi(times) * mpmath.expj(plus)
        amplitude = number(as_fraction(part.amplitude))
        return Harmonic(as_fraction(part.omega), amplitude * turn.real, -amplitude * turn.imag)
