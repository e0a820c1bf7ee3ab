"""What a parameter's range has to be for an orbit to be followed in it."""

from __future__ import annotations

import math
from collections.abc import Mapping

from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float
from percuss.model.paths import get_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["checked_range", "own_value"]


def own_value(orbit: PeriodicOrbit, path: str) -> float:
    """Return the value that a parameter has in the system of an orbit."""
    return as_float(get_parameter(orbit.oscillator, orbit.forcing, None, path))


def checked_range(
    orbit: PeriodicOrbit, over: Mapping[str, tuple[Phase, Phase]], *, may_stick: bool = False
) -> tuple[str, float, float, float]:
    """Return the path, the range and the orbit's own value.

    Raises
    ------
    ParameterError
        If there is no such parameter, the range does not hold the orbit's value, or the orbit is
        one of a family in one system or sticks, where it may not.
    """
    if len(over) != 1:
        raise ParameterError("over", over, "not one parameter and its range")
    ((path, given),) = over.items()
    value = own_value(orbit, path)
    try:
        first, last = (as_float(end) for end in given)
    except (TypeError, ValueError) as error:
        raise ParameterError(path, given, "not a range of two numbers") from error
    if first == last or not min(first, last) <= value <= max(first, last):
        raise ParameterError(path, given, f"no range that holds the orbit's own value {value:.12g}")
    if math.isinf(orbit.n_impacts) and not may_stick:
        reason = "it sticks, and after a release nothing doubles; continue_orbit follows it"
        raise ParameterError("orbit", orbit, reason)
    if not orbit.isolated:
        raise ParameterError("orbit", orbit, "one of a family in one system; nothing tells which")
    return path, first, last, value
