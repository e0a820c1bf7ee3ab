"""The period of a force where one is needed, and what is said where there is none."""

from __future__ import annotations

import math
import sys

from percuss.errors import ParameterError
from percuss.model.forcing import PERIOD_TOLERANCE, Forcing
from percuss.model.loads import Loads

# A longer period, counted in turns of the slowest harmonic, is no help: 1 and 1.41421 have one of
# 100,000 turns.
MOST_TURNS = 100
# A frequency is written as a fraction with at most this denominator.
MOST_DENOMINATOR = 10**6


def require_period(force: Forcing | Loads | None, why: str, *, instead: str = "") -> float:
    """Return the period of a force, or raise a `ParameterError` where it has none.

    Parameters
    ----------
    force
        A forcing, the loads of a structure, or None for free motion.
    why
        Why one is needed, as a sentence.
    instead
        What can be given in place of a period.

    Returns
    -------
    float
        The period [time].

    Raises
    ------
    ParameterError
        If the force has no period; it names the one that its harmonics have in common, if any.

    Examples
    --------
    >>> import percuss as pc
    >>> round(require_period(pc.cosine(2), "a section needs a periodic forcing"), 6)
    3.141593
    >>> try:
    ...     require_period(pc.cosine("1.5") + pc.sine(3), "a section needs a periodic forcing")
    ... except pc.ParameterError as error:
    ...     print(error.reason.partition("; ")[2])
    give "4*pi/3", which its harmonics have in common, as period= of Forcing
    """
    period = None if force is None else force.period
    if period is not None:
        return period
    path, parts, kind = "forcing.period", "harmonics", "Forcing"
    if isinstance(force, Loads):
        path, parts, kind = "loads.period", "loads", "Loads"
    found = None if force is None else period_in_common(force)
    ways = []
    if found is not None:
        ways.append(f'"{found}", which its {parts} have in common, as period= of {kind}')
    elif force is not None and not force.is_constant:
        ways.append(f"period= of {kind} where it has one")
    if instead:
        ways.append(instead)
    raise ParameterError(path, None, f"{why}; give {', or '.join(ways)}" if ways else why)


def period_in_common(force: Forcing | Loads) -> str | None:
    """Return the period that the harmonics of a force have in common, as a multiple of pi.

    It is that of frequencies whose ratios are fractions up to rounding, where it has at most 100
    turns of the slowest harmonic. None where there is no such period, and with a record.

    Examples
    --------
    >>> import percuss as pc
    >>> period_in_common(pc.cosine(0.8) + pc.cosine(1.2))
    '5*pi'
    >>> period_in_common(pc.cosine(1) + pc.cosine("1.41421")) is None
    True
    """
    forcings = force.forcings if isinstance(force, Loads) else (force,)
    omegas = sorted({part.omega for forcing in forcings for part in forcing.components()})
    if not omegas or any(forcing.record is not None for forcing in forcings):
        return None
    ratios = [(omega / omegas[0]).limit_denominator(MOST_TURNS) for omega in omegas]
    turns = math.lcm(*(ratio.denominator for ratio in ratios))
    slowest = omegas[0].limit_denominator(MOST_DENOMINATOR)
    off = max(abs(omega / slowest - ratio) for omega, ratio in zip(omegas, ratios, strict=True))
    # The slowest is that fraction up to the rounding of a double; an irrational one is none.
    is_fraction = abs(omegas[0] / slowest - 1) <= sys.float_info.epsilon
    if not is_fraction or turns > MOST_TURNS or turns * off > PERIOD_TOLERANCE:
        return None
    multiple = 2 * turns / slowest
    times = "" if multiple.numerator == 1 else f"{multiple.numerator}*"
    over = "" if multiple.denominator == 1 else f"/{multiple.denominator}"
    return f"{times}pi{over}"
