"""What the orbit's derivative around a graze implies for the motions beside it, in words."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from percuss.numerics import atan2, determinant, power, sin

__all__ = ["Scenario", "consequence"]

Scenario: TypeAlias = Literal["continuous", "jump", "undecided"]

# Multipliers as near as this are not told apart.
NEAR = 1e-9
# Between these values of the larger multiplier what follows a graze changes (docs/theory/grazing.md).
OVERLAP, CHAOS = 0.25, 2.0 / 3.0
# Of an impact's effect, when it turns towards the wall: depths at which that is felt are smaller
# than this squared, as a part of those at which the graze is felt at all.
FORGOTTEN = 1e-6


def consequence(monodromy: NDArray[np.float64], *, is_wall: bool) -> tuple[Scenario, str]:
    """Return what follows a graze, from the derivative of (x, v) around it without the touch.

    Parameters
    ----------
    monodromy
        (2, 2) array.
    is_wall
        Whether the stop is a wall; at a soft one the derivative is continuous.

    Returns
    -------
    tuple of str
        The scenario, and a sentence.

    Examples
    --------
    >>> consequence(np.array([[0.5, 0.3], [0.0, 0.2]]), is_wall=True)[0]
    'continuous'
    >>> print(consequence(np.array([[0.5, -0.3], [0.0, 0.2]]), is_wall=True)[1])
    a jump: an impact moves the mass so that it comes back to the wall faster, again and again; \
what attracts beyond the graze is elsewhere
    """
    trace, area = float(np.trace(monodromy)), determinant(monodromy)
    discriminant = 0.25 * trace * trace - area
    if abs(trace) > 1.0 + area:
        return "undecided", "the orbit is unstable without the touch; what follows is not local"
    if not is_wall:
        words = "continuous: the map's correction is of order 3/2 in the depth, the multipliers "
        words += "change with its square root from those without the touch, and the orbit lives on"
        return "continuous", words
    transfer = float(monodromy[0, 1])
    if abs(transfer) < NEAR:
        words = "a velocity at the touch does not come back to the stop after a period: resonant"
        return "undecided", words
    if discriminant < -NEAR:
        return _of_complex(trace, area, transfer)
    larger = 0.5 * trace + np.sqrt(max(discriminant, 0.0)) * np.sign(trace)
    if larger <= 0.0 or transfer < 0.0:
        words = "a jump: an impact moves the mass so that it comes back to the wall faster, again "
        words += "and again; what attracts beyond the graze is elsewhere"
        return "jump", words
    return "continuous", _continuous(float(larger))


def _of_complex(trace: float, determinant: float, transfer: float) -> tuple[Scenario, str]:
    """Return what follows where neighbours turn round the orbit without the touch."""
    size = math.sqrt(determinant)
    part = min(max(0.5 * trace / size, -1.0), 1.0)
    angle = atan2(math.sqrt((1.0 - part) * (1.0 + part)), part)
    # How many periods after an impact its effect first is towards the wall, and how much is left.
    periods = 1 if transfer < 0.0 else int(np.pi // angle) + 1
    left = abs(power(size, periods - 1.0) * sin(periods * angle) / sin(angle))
    if left < FORGOTTEN:
        words = _continuous(float(size))
        return "continuous", f"{words} (the multipliers are complex, with an angle of {angle:.2g})"
    words = f"a jump: the multipliers are complex, so that {counted(periods)} after an impact the "
    words += "mass comes back to the wall faster; what attracts beyond the graze is elsewhere"
    return "jump", words


def counted(periods: int) -> str:
    """Return a number of periods in words."""
    return "one period" if periods == 1 else f"{periods} periods"


def _continuous(larger: float) -> str:
    """Return what grows from a graze with real positive multipliers, by the larger one."""
    words = "continuous, with impact velocities below a multiple of the square root of the "
    words += f"distance to the graze; the larger multiplier {larger:.4g} "
    if larger > CHAOS:
        return words + "is above 2/3: chaos from the graze on, without windows"
    if larger > OVERLAP:
        words += "lies between 1/4 and 2/3: orbits with one impact in ever more periods towards "
        return words + "the graze, with chaos between their windows"
    words += "is below 1/4: orbits with one impact in ever more periods towards the graze, "
    return words + "whose windows overlap"
