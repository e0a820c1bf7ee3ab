"""What the column of a table holds by its head: a quantity, and its unit in that of the model."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import TypeAlias

from percuss.arrays import Floats
from percuss.model.faults import UNITS
from percuss.model.units import Units

# Other names of the quantities that columns hold.
ALIASES = {
    "t": ("time", "timestamp"),
    "displacement": ("x", "position", "disp"),
    "velocity": ("v", "vel"),
    "acceleration": ("a", "acc", "accel"),
    "stop_force": ("contact_force",),
    "impact_times": ("impact_time", "impacts"),
    "noise": ("sigma",),
}
# Dimensions of the quantities, as powers of mass, length and time.
_ACCELERATION, _FORCE = (0, 1, -2), (1, 1, -2)
POWERS = {
    "t": ((0, 0, 1),),
    "displacement": ((0, 1, 0),),
    "velocity": ((0, 1, -1),),
    "acceleration": (_ACCELERATION,),
    # Of an oscillator of unit mass it is an acceleration.
    "stop_force": (_FORCE, _ACCELERATION),
    "impact_times": ((0, 0, 1),),
}
# Of the force of a record: either.
DIMENSIONS_OF_HEADS = POWERS | {"force": (_FORCE, _ACCELERATION)}
_OF_KIND = {"mass": (1, 0, 0), "length": (0, 1, 0), "time": (0, 0, 1), "force": _FORCE}
# Units in kg, m, s and N that are no power of ten of these, and other names of units.
FACTORS = {"in": 0.0254, "ft": 0.3048, "min": 60.0, "h": 3600.0, "lb": 0.45359237,
           "lbf": 4.4482216152605}  # fmt: skip
SAME = {"sec": "s", "second": "s", "seconds": "s", "msec": "ms", "milliseconds": "ms",
        "meter": "m", "meters": "m", "metre": "m", "metres": "m"}  # fmt: skip
# Standard gravity, the unit of many accelerometers [m/s^2].
GRAVITY = 9.80665
NO_UNIT = ("", "-", "1", "dimensionless")
_IN_BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*")

# A factor to kg, m and s, and the powers of these.
UnitOfColumn: TypeAlias = "tuple[float, tuple[int, int, int]]"


@dataclass(frozen=True, slots=True)
class FileColumn:
    """A column that is read: its place, its name in the file, what it is, and its unit."""

    place: int
    title: str
    quantity: str
    unit: str


def quantity_named(name: str) -> str | None:
    """Return the quantity that a column of this name holds; None if there is none.

    Examples
    --------
    >>> quantity_named("Time"), quantity_named("stop force 1"), quantity_named("temperature")
    ('t', 'stop_force_1', None)
    """
    plain = re.sub(r"\W+", "_", name.strip().lower()).strip("_")
    for quantity, others in ALIASES.items():
        if plain == quantity or plain in others:
            return quantity
    stem, _, number = plain.rpartition("_")
    return plain if stem == "stop_force" and number.isdigit() else None


def kind_of(quantity: str | None) -> str:
    """Return what a quantity is of, without the number of its stop, its coordinate or its point.

    Examples
    --------
    >>> kind_of("stop_force_1"), kind_of("acceleration_tip"), kind_of("t"), kind_of("force")
    ('stop_force', 'acceleration', 't', 'force')
    """
    name = quantity or ""
    return next((kind for kind in POWERS if kind != "t" and name.startswith(f"{kind}_")), name)


def known_names() -> str:
    """Return the names of quantities as a list in words."""
    return ", ".join(name for name in POWERS if name != "t")


def name_and_unit(cell: str, quantity: str | None = None) -> tuple[str, str]:
    """Return the name and the unit in the head of a column, of a quantity that is known otherwise.

    >>> name_and_unit("x [mm]"), name_and_unit("Time / s"), name_and_unit("t_ms"), name_and_unit("stop_force")
    (('x', 'mm'), ('Time', 's'), ('t', 'ms'), ('stop_force', ''))
    >>> name_and_unit("Kraft, kN"), name_and_unit("f_kN", "force"), name_and_unit("Zeit in ms", "t")
    (('Kraft', 'kN'), ('f', 'kN'), ('Zeit', 'ms'))
    """
    bracketed = _IN_BRACKETS.fullmatch(cell)
    if bracketed:
        return bracketed[1], bracketed[2]
    said = (cell, "")
    for sign in ("/", ",", " in ", "_", " "):
        name, _, unit = cell.rpartition(sign) if sign in "_ " else cell.partition(sign)
        known = quantity or quantity_named(name)
        parsed = unit_of(unit.strip(), known) if name.strip() else None
        if parsed is None:
            continue
        if parsed[1] in DIMENSIONS_OF_HEADS.get(kind_of(known), ()):
            return name.strip(), unit.strip()
        # A word or a letter at the end of any name may be a unit by chance.
        if sign not in "_ " and known in (None, "force") and not said[1]:
            said = name.strip(), unit.strip()
    return said


def unit_of(text: str, quantity: str | None) -> UnitOfColumn | None:
    """Return the factor of a unit to kg, m and s, and the powers of these; None if it is none.

    >>> unit_of("mm/s", None), unit_of("m/s²", None), unit_of("kN", None)
    ((0.001, (0, 1, -1)), (1.0, (0, 1, -2)), (1000.0, (1, 1, -2)))
    """
    if kind_of(quantity) == "acceleration" and text in ("g", "gn", "g0"):
        return GRAVITY, _ACCELERATION
    text = text.replace("²", "^2").replace("μ", "µ").replace("·", " ").replace("**", "^")
    factor, powers = 1.0, [0, 0, 0]
    for place, part in enumerate(text.replace("*", " ").split("/")):
        for word in part.split():
            match = re.fullmatch(r"([a-zA-Zµ]+)\^?(-?\d)?", word)
            base = _base_unit(match[1]) if match else None
            if match is None or base is None:
                return None
            power = int(match[2] or 1) * (-1 if place else 1)
            factor *= base[0] ** power
            powers = [own + power * more for own, more in zip(powers, base[1], strict=True)]
    return (factor, (powers[0], powers[1], powers[2])) if any(powers) else None


def _base_unit(name: str) -> UnitOfColumn | None:
    name = SAME.get(name.lower(), name)
    for kind, powers in _OF_KIND.items():
        if name in UNITS[kind]:
            exponent = UNITS[kind][name]
            return (FACTORS[name] if exponent is None else float(f"1e{exponent}")), powers
    return None


def factor_of(column: FileColumn, units: Units | None) -> tuple[float, str]:
    """Return the factor that converts a column into the units of the model, or a fault."""
    quantity = kind_of(column.quantity)
    if column.unit in NO_UNIT or quantity not in POWERS:
        return 1.0, ""
    has_units = _has_units(units)
    parsed = unit_of(column.unit, quantity)
    if parsed is None:
        known = f'"{column.title}": no unit that percuss knows; remove it, or convert the column'
        return 1.0, known if has_units else ""
    factor, powers = parsed
    if powers not in POWERS[quantity]:
        return 1.0, f'"{column.title}": {column.unit} is no unit of {_thing(quantity)}'
    if not has_units or units is None:
        reason = f'"{column.title}": the model has no units to convert {column.unit} into; give '
        hint = (
            'oscillator.units, such as {length = "m", time = "s"}, or units=pc.Units("m", "s"), '
            "or on the page the units in Explore"
        )
        return 1.0, "" if factor == 1.0 else reason + hint
    return _into(units, parsed, column)


def force_factor(
    column: FileColumn, units: Units | None, quantity: str, *, has_amplitude: bool
) -> tuple[float, str]:
    """Return the factor that converts a force into the units of the model, or a fault.

    A unit of another quantity, as of the elevation of waves, needs an amplitude, which is then the
    force of each of it.
    """
    parsed = unit_of(column.unit, quantity)
    if column.unit == "g" and not _has_units(units) and not has_amplitude:
        reason = "without units of the model nothing says whether g is gravity or a gram"
        return 1.0, f'"{column.title}": {reason}; give them, or convert the column'
    if quantity == "force" and column.unit == "g" and _has_units(units):
        # As a gram it would be a thousandth of what an accelerometer means.
        reason = "g may be the acceleration of gravity, which it is with per_mass = true, or a gram"
        return 1.0, f'"{column.title}": {reason}; convert the column into m/s^2 or kg'
    allowed = (_FORCE,) if quantity == "force" else POWERS[quantity]
    if column.unit in NO_UNIT:
        return 1.0, ""
    if parsed is not None and parsed[1] in allowed:
        own = "acceleration" if parsed[1] == _ACCELERATION else "stop_force"
        return factor_of(replace(column, quantity=own), units)
    if has_amplitude and parsed is not None and units is not None and _has_units(units):
        return _into(units, parsed, column)
    if has_amplitude or (parsed is None and not _has_units(units)):
        return 1.0, ""
    wrong = f'"{column.title}": {column.unit} is no unit of {_thing(quantity)}'
    meant = _meant(column.unit) if parsed is None else ""
    if meant:
        return 1.0, f'{wrong}; did you mean "{meant}"?'
    is_length = parsed is not None and parsed[1] == _OF_KIND["length"]
    each = units.length if is_length and units is not None and units.length else column.unit
    advice = f"give amplitude, the force of each {each}"
    if parsed is not None and parsed[1] in (_FORCE, _ACCELERATION):
        # A mass divides a force, and no acceleration.
        advice = (
            "with per_mass = true it is an acceleration"
            if quantity == "force"
            else "without per_mass it is a force"
        )
    return 1.0, f"{wrong}; {advice}"


def _into(units: Units, unit: UnitOfColumn, column: FileColumn) -> tuple[float, str]:
    """Return the factor that converts a unit into those of a model, or a fault."""
    factor, powers = unit
    for name, power in zip((units.mass, units.length, units.time), powers, strict=True):
        base = _base_unit(name)
        if power and base is None:
            reason = f"the model's unit {name}" if name else "a model without all of its units"
            return 1.0, f'"{column.title}": {column.unit} cannot be converted for {reason}'
        factor /= (base[0] if base else 1.0) ** power
    # Powers of ten as they are read, not as rounded quotients.
    nearest = float(f"{factor:.0e}")
    return (nearest if math.isclose(factor, nearest) else factor), ""


def _meant(unit: str) -> str:
    """Return the unit that is written so but for capitals; empty if there is none."""
    known = (name for kind in _OF_KIND for name in UNITS[kind])
    return next((name for name in known if name.lower() == unit.lower()), "")


def _has_units(units: Units | None) -> bool:
    return units is not None and bool(units.length or units.time)


def converted(values: Floats, factor: float) -> Floats:
    """Return values times a factor; by a power of ten below 1 divided, which is exact to rounding."""
    inverse = round(1.0 / factor)
    return values / inverse if factor < 1.0 and 1.0 / inverse == factor else values * factor


def _thing(quantity: str) -> str:
    """Return what a quantity is measured as."""
    return {"t": "time", "impact_times": "time", "displacement": "length", "stop_force": "force"}.get(
        quantity, quantity
    )  # fmt: skip
