"""A number of the force that is a ball: the proof then holds for all values in it.

So a constant such as cos(pi/5), which no rational is, can be meant exactly.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from flint import arb

from percuss.certified.balls import Ball
from percuss.certified.numbers import ball
from percuss.certified.system import System
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_fraction
from percuss.model.paths import long_form

__all__ = ["Over", "range_of", "system_for", "too_wide"]

# By path: all values of a ball, or all between two numbers.
Over: TypeAlias = Mapping[str, Ball | tuple[Exact, Exact]]


def system_for(system: System, over: Over | None) -> System:
    """Return the system with one number of its force replaced by all of a range.

    Raises
    ------
    ParameterError
        If it is no number of the force that may be a ball, not one path, or an empty range.
    """
    if over is None:
        return system
    if len(over) != 1:
        raise ParameterError("over", dict(over), "not one parameter and its values")
    ((name, values),) = over.items()
    path = long_form(name, system.oscillator, system.forcing)
    allowed = ["forcing.constant", *(tone.amplitude for tone in system.tones)]
    if system.forcing is None or path not in allowed:
        reason = f"no number of the force that may be a ball; these may: {', '.join(allowed)}"
        raise ParameterError("over", name, reason)
    low, high = _ends(path, values)
    return dataclasses.replace(system, moved=(path, low, high))


def range_of(system: System) -> tuple[str, Ball] | None:
    """Return the number that a proof holds for all values of, and these; None for none."""
    if system.moved is None:
        return None
    path, low, high = system.moved
    return path, Ball(ball(low).union(ball(high)))


def too_wide(system: System) -> str:
    """Return the end of a reason why more bits do not help; empty without a range."""
    if system.moved is None:
        return ""
    path, low, high = system.moved
    if low == high:
        return ""
    return f"; the range of {path} is too wide, by its radius of {float(high - low) / 2:.2g}"


def _ends(path: str, values: Ball | tuple[Exact, Exact]) -> tuple[Fraction, Fraction]:
    if isinstance(values, Ball):
        if not values.arb.is_finite():
            raise ParameterError(f"over[{path!r}]", values, "a ball without a number")
        middle, radius = _exact(values.arb.mid()), _exact(values.arb.rad())
        return middle - radius, middle + radius
    try:
        low, high = (as_fraction(value) for value in values)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"over[{path!r}]", values, "neither a ball nor two numbers") from error
    if not low <= high:
        raise ParameterError(f"over[{path!r}]", values, "the first value is above the second")
    return low, high


def _exact(number: arb) -> Fraction:
    """Return an arb without radius as a fraction."""
    mantissa, exponent = number.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
