"""Faults of the values that a user gave: all of them, as a list.

A constructor raises the first fault; a study reports every fault with its dotted path.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import cache, singledispatch
from typing import Any, TypeGuard, TypeVar, cast

from percuss.errors import ParameterError
from percuss.model.exact import (
    NOT_A_NUMBER,
    Exact,
    PiTimes,
    as_float,
    number_problem,
    phase_problem,
    plain,
)
from percuss.model.expression import meant_by
from percuss.wording import shown

Model = TypeVar("Model")

# Names of units by what they measure, with their power of ten of the SI unit, where that is whole.
UNITS: dict[str, dict[str, int | None]] = {
    "length": {"km": 3, "m": 0, "cm": -2, "mm": -3, "um": -6, "µm": -6, "nm": -9, "in": None,
               "ft": None},
    "time": {"s": 0, "ms": -3, "us": -6, "µs": -6, "ns": -9, "min": None, "h": None},
    "mass": {"t": 3, "kg": 0, "g": -3, "mg": -6, "lb": None},
    "force": {"N": 0, "kN": 3, "MN": 6, "mN": -3, "lbf": None},
}  # fmt: skip
# Rates and stiffnesses are squared, and squared again, in bounds.
LARGEST_SCALE = 1e70


@dataclass(frozen=True, slots=True)
class Fault:
    """A parameter whose value the model cannot take, and why.

    Parameters
    ----------
    name
        Dotted path of the parameter.
    value
        What was given.
    reason
        What is wrong with it, and what would be right.

    Examples
    --------
    >>> print(Fault("oscillator.stops.0.restitution", -0.1, "outside [0, 1]"))
    oscillator.stops.0.restitution = -0.1: outside [0, 1]
    """

    name: str
    value: object
    reason: str

    def __str__(self) -> str:
        return f"{self.name} = {shown(self.value)}: {self.reason}"


@singledispatch
def faults(value: object, prefix: str | None = None) -> list[Fault]:
    """Return all faults of a part of the model.

    A value that was constructed has none; `draft` gives one that may.

    Parameters
    ----------
    value
        A stop, an oscillator, a structure, a harmonic, a forcing, loads or a start.
    prefix
        Dotted path of the value, put before the names; by default ``oscillator``, ``structure``,
        ``forcing``, ``loads`` or ``start``, and nothing for a stop or a harmonic of its own.

    Returns
    -------
    list of Fault
        Empty if nothing is wrong.

    Raises
    ------
    TypeError
        If the value is no part of the model.

    Examples
    --------
    >>> from percuss.model import Wall
    >>> for fault in faults(draft(Wall, at="here", side="below", restitution=1.1), "wall"):
    ...     print(fault.name)
    wall.at
    wall.restitution
    """
    raise TypeError(f"{type(value).__name__} is no part of the model ({prefix or 'no prefix'})")


def draft(kind: type[Model], /, **fields: object) -> Model:
    """Return a part of the model that has not been checked, whose faults `faults` then lists.

    Parameters
    ----------
    kind
        Wall, SoftStop, Oscillator, Structure, Harmonic, FourierTerm, ForceRecord, Forcing, Loads,
        Start or StructureStart.
    **fields
        Its fields by name, the parts of a part as drafts themselves.

    Returns
    -------
    Model
        The value; without faults it is as good as one that was constructed.

    Raises
    ------
    TypeError
        If a field is unknown, or one without default is missing.

    Examples
    --------
    >>> from percuss.model import Oscillator, Wall
    >>> wall = draft(Wall, at=0, side="left", restitution=2)
    >>> [fault.name for fault in faults(draft(Oscillator, damping="a", stops=(wall,)))]
    ['oscillator.damping', 'oscillator.stops.0.side', 'oscillator.stops.0.restitution']
    """
    value = object.__new__(kind)
    for own, name, default in _fields_of(cast("Any", kind)):
        if name not in fields and default is dataclasses.MISSING:
            raise TypeError(f"{kind.__name__} needs {name}")
        object.__setattr__(value, own, as_tuple(plain(fields.pop(name, default))))
    if fields:
        raise TypeError(f"{kind.__name__} has no {', '.join(fields)}")
    return value


def field_values(value: Any) -> dict[str, Any]:
    """Return the fields of a part of the model by their names."""
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}


@cache
def _fields_of(kind: Any) -> tuple[tuple[str, str, Any], ...]:
    """Return the fields of a part of the model: name, the name by which it is given, and default."""
    # Forcing keeps the period that was given under another name.
    return tuple(
        (field.name, field.metadata.get("given_as", field.name), field.default)
        for field in dataclasses.fields(kind)
    )


def raise_first(problems: Iterable[Fault]) -> None:
    """Raise the first fault, if there is one, as a `ParameterError`."""
    for fault in problems:
        raise ParameterError(fault.name, fault.value, fault.reason)


def check_mapping(name: str, value: object, meant: str, n: int | None = None) -> None:
    """Refuse what is no mapping, of n names where that is given, such as a list of paths.

    Examples
    --------
    >>> check_mapping("free", ["forcing.omega"], "{path: (least, largest)}")
    Traceback (most recent call last):
    percuss.errors.ParameterError: free = ['forcing.omega']: not {path: (least, largest)}
    """
    if not isinstance(value, Mapping) or (n is not None and len(value) != n):
        raise ParameterError(name, value, f"not {meant}")


def make_plain(value: object, *names: str) -> None:
    """Turn NumPy scalars in the fields of a frozen value into Python numbers, texts kept."""
    for name in names:
        object.__setattr__(value, name, plain(getattr(value, name)))


def plain_number(value: object) -> Any:
    """Return a scalar as `plain` does; a multiple of pi, and the text of an expression, as that.

    Examples
    --------
    >>> plain_number("4*pi**2"), plain_number("2.8"), plain_number("high")
    (expression('4*pi**2'), '2.8', 'high')
    """
    number = plain(value)
    is_meant = isinstance(number, str | PiTimes) and number_problem(number) == NOT_A_NUMBER
    return meant_by(number) if is_meant else number  # type: ignore[arg-type]


def make_numbers(value: object, *names: str) -> None:
    """Turn the fields of a frozen value that are numbers into Python's, or into expressions."""
    for name in names:
        object.__setattr__(value, name, plain_number(getattr(value, name)))


def is_row(value: object) -> TypeGuard[Iterable[Any]]:
    """Whether a value is a list, an array or another iterable with an order; a text is a number.

    A dictionary and a set are none: of what they hold their keys, or no order, would be taken. Nor
    is an array without dimensions, which is a number.
    """
    is_without = isinstance(value, str | bytes | Mapping | AbstractSet)
    return isinstance(value, Iterable) and not is_without and getattr(value, "ndim", 1) != 0


def as_tuple(value: object) -> object:
    """Return a list or another row as a tuple, anything else unchanged."""
    return tuple(value) if is_row(value) else value


def dotted(prefix: str | None, name: str) -> str:
    """Return the path of a name below a prefix, which may be empty."""
    return f"{prefix}.{name}" if prefix else name


def number_faults(name: str, value: object) -> list[Fault]:
    """Return the fault of a value that is no finite number."""
    problem = number_problem(value)
    return [] if problem is None else [Fault(name, value, problem)]


def phase_faults(name: str, value: object) -> list[Fault]:
    """Return the fault of a value that is no phase."""
    problem = phase_problem(value)
    return [] if problem is None else [Fault(name, value, problem)]


def positive_faults(name: str, value: object, reason: str = "not positive") -> list[Fault]:
    """Return the fault of a value that is no number above zero."""
    problems = number_faults(name, value)
    if not problems and as_float(cast("Exact", value)) <= 0.0:
        return [Fault(name, value, reason)]
    return problems


def not_negative_faults(name: str, value: object, reason: str) -> list[Fault]:
    """Return the fault of a value that is no number of at least zero."""
    problems = number_faults(name, value)
    if not problems and as_float(cast("Exact", value)) < 0.0:
        return [Fault(name, value, reason)]
    return problems


def scale_faults(name: str, value: object) -> list[Fault]:
    """Return the fault of a number whose square would leave the range of floats; 0 is allowed."""
    problems = number_faults(name, value)
    size = 0.0 if problems else abs(as_float(cast("Exact", value)))
    if size != 0.0 and not 1.0 / LARGEST_SCALE <= size <= LARGEST_SCALE:
        reason = (
            f"not between {1.0 / LARGEST_SCALE:g} and {LARGEST_SCALE:g}; choose units in which it "
            "is nearer to 1"
        )
        return [Fault(name, value, reason)]
    return problems


def unit_problem(name: str, value: object) -> str | None:
    """Return why a text cannot name a unit of length, time or mass, None if it can."""
    if not isinstance(value, str):
        return "not a text"
    known = next((dimension for dimension in UNITS if value in UNITS[dimension]), name)
    return None if known == name else f"a unit of {known}, not of {name}"
