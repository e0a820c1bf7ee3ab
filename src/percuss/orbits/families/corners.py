"""Where two stops that an orbit meets come to lie at one place."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from percuss.model.exact import as_float
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

if TYPE_CHECKING:
    # It asks here which stop its parameter moves.
    from percuss.orbits.families.family import Family

__all__ = ["corner_between", "stop_that_is_moved"]

Floats = NDArray[np.float64]


def stop_that_is_moved(path: str) -> int | None:
    """Return the index of the stop whose position a path names, None for another parameter.

    Examples
    --------
    >>> stop_that_is_moved("oscillator.stops.1.at")
    1
    """
    found = re.fullmatch(r"oscillator\.stops\.(\d+)\.at", path)
    return int(found[1]) if found else None


def corner_between(
    family: Family, orbit: PeriodicOrbit, first: float, last: float
) -> tuple[float, int, int] | None:
    """Return the value at which the stop that is moved comes to another one, and both stops.

    Parameters
    ----------
    family
        The orbits along the position of a stop.
    orbit
        One of them; it has to meet both.
    first, last
        Values of the parameter; the corner nearest to the first is returned, not at it.

    Returns
    -------
    tuple or None
        None if there is none.
    """
    moved = stop_that_is_moved(family.path)
    if moved is None or moved not in orbit.sequence:
        return None
    found = []
    for other, stop in enumerate(family.oscillator.stops):
        at = as_float(stop.at)
        if other != moved and other in orbit.sequence and (at - first) * (at - last) <= 0.0:
            found.append((abs(at - first), at, other))
    found = [it for it in found if it[0] > 0.0]
    if not found:
        return None
    _, at, other = min(found)
    return at, moved, other
