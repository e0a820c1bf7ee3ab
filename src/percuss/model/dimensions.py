"""Dimensions of parameters, by their paths."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from percuss.model.expression import Expression
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.paths import moved_fields
from percuss.model.structure import Structure
from percuss.model.units import CYCLES, FORCE, in_units

# Dimensions of parameters by the last word of their paths.
UNITS = {
    "mass": "mass",
    "stiffness": "1/time^2",
    "damping": "1/time",
    "at": "length",
    "restitution": "1",
    "speeds": "length/time",
    "values": "1",
    "amplitude": "length/time^2",
    "omega": "1/time",
    "phase": "rad",
    "constant": "length/time^2",
    "period": "time",
    "cos": "length/time^2",
    "sin": "length/time^2",
    "x0": "length",
    "v0": "length/time",
    "t0": "time",
}
# With a mass these are forces per length and per velocity, and forces.
_OF_MASS = {"stiffness": "mass/time^2", "damping": "mass/time"}
_OF_FORCE = ("amplitude", "constant", "cos", "sin")


def dimensions_of(path: str, osc: object = None, force: Forcing | Loads | None = None) -> str:
    """Return the dimensions of a parameter in length, time, mass and radians, from its path.

    Examples
    --------
    >>> dimensions_of("oscillator.stops.0.at"), dimensions_of("forcing.cos.0")
    ('length', 'length/time^2')
    >>> dimensions_of("oscillator.stiffness", Oscillator.from_mass(2, 50))
    'mass/time^2'

    A named parameter has those of the number that it is, but for a factor:

    >>> import percuss as pc
    >>> w = pc.parameter("w", 2)
    >>> dimensions_of("w", Oscillator(), pc.cosine(w, amplitude=w**2))
    '1/time'
    >>> dimensions_of("f", Oscillator(), pc.cosine(pc.pi_times(2) * pc.parameter("f", 2)))
    'cycle/time'
    """
    if "." not in path and isinstance(osc, Oscillator | Structure):
        return dimensions_of_named(moved_fields(osc, force, None, path).fields, osc, force)
    words = [word for word in path.split(".") if not word.isdigit()]
    name = words[-1]
    own: Forcing | None
    if isinstance(force, Loads):
        number = path.split(".")[1]
        of_loads = words[0] == "loads" and number.isdigit()
        own = force.forcings[int(number)] if of_loads else None
    else:
        own = force
    record = None if own is None else own.record
    if words[-2:] == ["record", "amplitude"] and record is not None and record.omega is None:
        # The factor of samples, which have their own units.
        return "1"
    if isinstance(osc, Structure) or (isinstance(osc, Oscillator) and osc.mass is not None):
        if name in _OF_MASS:
            return _OF_MASS[name]
        if name in _OF_FORCE and own is not None and not own.is_per_mass:
            return FORCE
    return UNITS[name]


def unit_of_setting(path: str, osc: Oscillator | Structure, force: Forcing | Loads | None) -> str:
    """Return the unit of a parameter or, where its model has no units, its dimensions.

    A parameter with a name of its own is shown without a unit.
    """
    return in_units(osc.units, dimensions_of(path, osc, force) if "." in path else "")


def dimensions_of_named(
    moved: Mapping[str, Expression], osc: object, force: Forcing | Loads | None
) -> str:
    """Return the dimensions of the field that is a multiple of a named parameter; "" for none.

    In a frequency 2 pi f the parameter counts cycles, and in 2 pi / T it is a time.
    """
    for path, value in moved.items():
        factor, is_frequency = value.factor, path.endswith(".omega")
        if is_frequency and value.is_reciprocal:
            return "time"
        if factor is not None:
            counts_cycles = is_frequency and factor.angle() == (Fraction(2), Fraction(0))
            return CYCLES if counts_cycles else dimensions_of(path, osc, force)
    return ""
