"""The ranges of parameters over which branches and curves go."""

from __future__ import annotations

import math
from collections.abc import Mapping

from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float, two_of
from percuss.model.faults import check_mapping
from percuss.model.paths import get_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

Ranges = Mapping[str, tuple[float, float]]

# Half the range of a parameter in which another family is looked for, as a part of its value.
HALF_RANGE = 0.01


def own_value(orbit: PeriodicOrbit, path: str) -> float:
    """Return the value that a parameter has in the system of an orbit."""
    return as_float(get_parameter(*orbit.system, None, path))


def range_about(
    value: float, path: str, given: tuple[Phase, Phase], whose: str
) -> tuple[float, float]:
    """Return the ends of the range of a parameter, which has to contain its own value."""
    first, last = two_of(as_float, path, given, "not a range of two numbers")
    if first == last or not min(first, last) <= value <= max(first, last):
        reason = f"no range that holds the {whose}'s own value {repr(value).removesuffix('.0')}"
        raise ParameterError(path, given, reason)
    return first, last


def range_around(value: float) -> tuple[float, float]:
    """Return the range of a parameter in which another family is looked for, and the unit of steps."""
    half = HALF_RANGE * abs(value) or HALF_RANGE
    return value - half, value + half


def ranges_of_curve(
    over: Mapping[str, tuple[Phase, Phase]], names: list[str], values: list[float]
) -> tuple[Ranges, float]:
    """Return the ranges of two parameters, upwards, and the direction along the first.

    Parameters
    ----------
    over
        The parameters by their paths, and the first and last value of each.
    names, values
        Their long forms, and their values at the point of the curve.

    Raises
    ------
    ParameterError
        If they are one parameter, or a range does not hold the value.
    """
    if names[0] == names[1]:
        raise ParameterError("over", tuple(over), f"twice the same parameter, {names[0]}")
    ranges, signs = {}, []
    for (path, given), value in zip(over.items(), values, strict=True):
        first, last = range_about(value, path, given, "point")
        ranges[path] = min(first, last), max(first, last)
        signs.append(math.copysign(1.0, last - first))
    return ranges, signs[0]


def checked_range(
    orbit: PeriodicOrbit, over: Mapping[str, tuple[Phase, Phase]], *, may_stick: bool = False
) -> tuple[str, float, float, float]:
    """Return the path, the range and the orbit's own value.

    Raises
    ------
    ParameterError
        If it is no orbit, there is no such parameter, the range does not hold the orbit's value, or
        the orbit is one of a family in one system or sticks, where it may not.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise ParameterError("orbit", orbit, "not a periodic orbit; find_orbit() finds one")
    check_mapping("over", over, "one parameter and its range", 1)
    ((path, given),) = over.items()
    value = own_value(orbit, path)
    first, last = range_about(value, path, given, "orbit")
    if math.isinf(orbit.n_impacts) and not may_stick:
        reason = "it sticks, and after a release nothing doubles; continue_orbit follows it"
        raise ParameterError("orbit", orbit, reason)
    if not orbit.isolated:
        raise ParameterError("orbit", orbit, "one of a family in one system; nothing tells which")
    return path, first, last, value
