"""The units in which the numbers of a model are measured: names for labels, nothing is converted."""

from __future__ import annotations

import re
from dataclasses import dataclass

from percuss.errors import ParameterError
from percuss.model.faults import UNITS, unit_problem

# Dimensions of what a mass is part of.
FORCE = "mass length/time^2"
# Dimensions of a frequency f that counts periods, where omega = 2 pi f counts radians.
CYCLES = "cycle/time"
_PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n"}
_WORD = re.compile(r"(length|time|mass)(?:\^(\d))?")


@dataclass(frozen=True, slots=True)
class Units:
    """Names of the units of length, time and mass; empty texts mean dimensionless.

    They only name what the numbers of a model are measured in: no number is converted. An
    oscillator that has units gives them to its tables, files and pictures.

    Parameters
    ----------
    length, time, mass
        Any names. Of km, m, cm, mm, um, nm, s, ms, us, ns, t, kg, g and mg forces, energies and
        powers have names of their own, such as kN for t, m and s. All others, such as "ft",
        "meters" or "d" for the diameter of a wheel, are labels: a force in them is written out.

    Raises
    ------
    ParameterError
        If a name is no text, or that of a unit of something else.

    Examples
    --------
    >>> units = Units("m", "s", "t")
    >>> units.velocity, units.of("mass length/time^2"), units.of("mass/time^2")
    ('m/s', 'kN', 'kN/m')
    >>> Units("meters", "s", "kg").of("mass length/time^2")
    'kg meters/s^2'
    """

    length: str = ""
    time: str = ""
    mass: str = ""

    def __post_init__(self) -> None:
        for name in ("length", "time", "mass"):
            problem = unit_problem(name, getattr(self, name))
            if problem is not None:
                raise ParameterError(f"units.{name}", getattr(self, name), problem)

    @property
    def displacement(self) -> str:
        """Unit of a displacement."""
        return self.length or "dimensionless"

    @property
    def duration(self) -> str:
        """Unit of a time."""
        return self.time or "dimensionless"

    @property
    def velocity(self) -> str:
        """Unit of a velocity."""
        if not self.length and not self.time:
            return "dimensionless"
        return f"{self.length or '1'}/{self.time}" if self.time else self.length

    def of(self, dimensions: str) -> str:
        """Return the unit of a quantity.

        Parameters
        ----------
        dimensions
            Its dimensions, such as ``"length/time^2"``.

        Returns
        -------
        str
            Its unit; a dimension without a unit stays as it is.

        Examples
        --------
        >>> Units("m", "s").of("length/time^2"), Units("m", "s", "kg").of("mass length^2/time^3")
        ('m/s^2', 'W')
        >>> Units("m", "s").of("1/time"), Units("m", "s").of("cycle/time")
        ('1/s', 'Hz')
        """
        if dimensions == CYCLES and self.time in _HERTZ:
            return _HERTZ[self.time]
        return self._named(dimensions) or _WORD.sub(self._replaced, dimensions)

    def _replaced(self, word: re.Match[str]) -> str:
        name = getattr(self, word[1]) or word[1]
        return f"{name}^{word[2]}" if word[2] else name

    def _named(self, dimensions: str) -> str:
        """Return a name with N, J or W in it; empty where there is none."""
        powers = [UNITS[name].get(getattr(self, name)) for name in ("mass", "length", "time")]
        wanted = exponents_of(dimensions)
        for letter, (mass, length, time), more in _NAMED:
            if wanted != (mass, length, time):
                continue
            # More is what stands beside the letter, such as /length for a stiffness.
            rest = exponents_of(more)
            own = tuple(total - part for total, part in zip(wanted, rest, strict=True))
            power = _power(powers, own)
            if power in _PREFIXES:
                return f"{_PREFIXES[power]}{letter}{_WORD.sub(self._replaced, more)}"
        return ""


_HERTZ = {"s": "Hz", "ms": "kHz", "us": "MHz", "ns": "GHz"}
# Name, powers of mass, length and time, and what stands beside the name.
_NAMED = (
    ("N", (1, 1, -2), ""),
    ("J", (1, 2, -2), ""),
    ("W", (1, 2, -3), ""),
    ("N", (1, 1, -1), " time"),
    ("N", (1, 0, -2), "/length"),
    ("N", (1, 0, -1), " time/length"),
)


def exponents_of(dimensions: str) -> tuple[int, ...]:
    """Return the powers of mass, length and time in a text of dimensions.

    Examples
    --------
    >>> exponents_of("mass length/time^2"), exponents_of("rad")
    ((1, 1, -2), (0, 0, 0))
    """
    powers = {"mass": 0, "length": 0, "time": 0}
    for sign, part in zip((1, -1), dimensions.split("/"), strict=False):
        for name, power in _WORD.findall(part):
            powers[name] += sign * int(power or 1)
    return tuple(powers.values())


def _power(powers: list[int | None], exponents: tuple[int, ...]) -> int | None:
    """Return the power of ten of a product of units, None where one is unknown."""
    total = 0
    for power, exponent in zip(powers, exponents, strict=True):
        if exponent and power is None:
            return None
        total += exponent * (power or 0)
    return total


def in_units(units: Units | None, dimensions: str) -> str:
    """Return the unit of a quantity, or without units its dimensions.

    Examples
    --------
    >>> in_units(None, "length/time"), in_units(Units("mm", "ms"), "length/time")
    ('length/time', 'mm/ms')
    """
    return dimensions if units is None else units.of(dimensions)


def is_unit(text: str) -> bool:
    """Return whether a text names a unit, not dimensions nor nothing.

    Examples
    --------
    >>> is_unit("m/s"), is_unit("length/time"), is_unit("1")
    (True, False, False)
    """
    return text not in ("", "1", "rad") and _WORD.search(text) is None
