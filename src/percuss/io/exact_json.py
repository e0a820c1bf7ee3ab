"""Values of percuss as JSON, read back with the same types and bits."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from typing import Any

import numpy as np

from percuss.model.exact import PiTimes
from percuss.model.expression import Expression
from percuss.model.faults import faults, raise_first
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure

# Only values of these packages are made from what a file names.
_PACKAGES = ("percuss.model.", "percuss.motion.", "percuss.orbits.")
Replaced = Callable[[Any], Any]


def encoded(value: Any, replaced: Replaced | None = None) -> Any:
    """Return a value in types that JSON has.

    Parameters
    ----------
    value
        Numbers, exact ones too, texts, arrays, tuples, lists, dictionaries, and the values of
        percuss made of these.
    replaced
        Returns a JSON value for what is kept elsewhere, None for everything else.

    Returns
    -------
    object
        Floats as they are: their JSON text reads back to the same bits.

    Raises
    ------
    TypeError
        If it contains a value of another type.

    Examples
    --------
    >>> encoded((1, Fraction(1, 3)))
    {'tuple': [1, {'fraction': '1/3'}]}
    """
    elsewhere = None if replaced is None else replaced(value)
    if elsewhere is not None:
        return elsewhere
    for kind, encode in _ENCODERS.items():
        if isinstance(value, kind):
            return encode(value, lambda part: encoded(part, replaced))
    kind = type(value)
    name = f"{kind.__module__}.{kind.__qualname__}"
    if not dataclasses.is_dataclass(value) or not name.startswith(_PACKAGES):
        raise TypeError(f"{name} has no place in a file")
    fields = {f.name: encoded(getattr(value, f.name), replaced) for f in dataclasses.fields(value)}
    return {"value": name, "fields": fields}


def decoded(text: Any, kept: Callable[[int], Any] | None = None) -> Any:
    """Return the value that `encoded` made into JSON.

    Parameters
    ----------
    text
        The result of `encoded`.
    kept
        Returns what is kept elsewhere, by its number.

    Returns
    -------
    object
        The value.

    Raises
    ------
    ValueError, KeyError, TypeError
        If it is not the result of `encoded`.

    Examples
    --------
    >>> decoded(encoded((1, Fraction(1, 3))))
    (1, Fraction(1, 3))
    """
    if isinstance(text, list):
        return [decoded(part, kept) for part in text]
    if not isinstance(text, dict):
        return text
    if "orbit" in text:
        if kept is None:
            raise KeyError("orbit")
        return kept(int(text["orbit"]))
    if "value" in text:
        return _made(text["value"], {k: decoded(v, kept) for k, v in text["fields"].items()})
    ((tag, content),) = text.items()
    return _DECODERS[tag](content, lambda part: decoded(part, kept))


def _made(name: str, fields: dict[str, Any]) -> Any:
    """Return a frozen value with these fields, as they are."""
    module, _, own = name.rpartition(".")
    if not name.startswith(_PACKAGES):
        raise ValueError(f"{name} is no value of percuss")
    kind: Any = getattr(import_module(module), own)
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        raise ValueError(f"{name} is no value of percuss")
    value = object.__new__(kind)
    for field in dataclasses.fields(kind):
        if field.name in fields:
            object.__setattr__(value, field.name, fields[field.name])
        elif field.default is not dataclasses.MISSING:
            # A field that is newer than the file.
            object.__setattr__(value, field.name, field.default)
        else:
            raise KeyError(f"{name}.{field.name}")
    if isinstance(value, Expression):
        return Expression(value.text, value.parameters)
    if isinstance(value, Oscillator | Forcing | Structure | Loads):
        raise_first(faults(value))
    return value


def _array(value: Any, _: Replaced) -> Any:
    content = value.view(np.float64) if value.dtype.kind == "c" else value
    return {"array": [value.dtype.str, list(value.shape), content.ravel().tolist()]}


def _array_of(content: Any, _: Replaced) -> Any:
    dtype, shape, values = content
    if np.dtype(dtype).kind == "c":
        return np.array(values, dtype=np.float64).view(dtype).reshape(shape)
    return np.array(values, dtype=dtype).reshape(shape)


# In this order: True is an int, and a NumPy scalar may be a float.
_ENCODERS: dict[Any, Callable[[Any, Replaced], Any]] = {
    np.generic: lambda value, part: part(value.item()),
    bool | int | float | str | None: lambda value, _: value,
    complex: lambda value, _: {"complex": [value.real, value.imag]},
    Fraction: lambda value, _: {"fraction": str(value)},
    Decimal: lambda value, _: {"decimal": str(value)},
    PiTimes: lambda value, _: {"pi": [str(value.times), str(value.plus)]},
    np.ndarray: _array,
    tuple: lambda value, part: {"tuple": [part(item) for item in value]},
    list: lambda value, part: [part(item) for item in value],
    dict: lambda value, part: {"dict": [[part(k), part(v)] for k, v in value.items()]},
}
_DECODERS: dict[str, Callable[[Any, Replaced], Any]] = {
    "complex": lambda content, _: complex(*content),
    "fraction": lambda content, _: Fraction(content),
    "decimal": lambda content, _: Decimal(content),
    "pi": lambda content, _: PiTimes(Fraction(content[0]), Fraction(content[1])),
    "array": _array_of,
    "tuple": lambda content, part: tuple(part(item) for item in content),
    "dict": lambda content, part: {part(k): part(v) for k, v in content},
}
