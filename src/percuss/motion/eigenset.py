"""The impact times and the resonant frequency of the oscillator without forcing."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels.law_columns import (
    DAMPING,
    FIRST_HARMONIC,
    LOWER_KIND,
    N_REGIONS,
    OVERDAMPED,
    RATE,
    UPPER_KIND,
    WALL,
)
from percuss.model.exact import MOST_ROWS, Exact, real, whole
from percuss.model.oscillator import Oscillator
from percuss.model.system import System


def eigenset(osc: Oscillator, count: int, t0: Exact = 0.0) -> Floats:
    """Return the first impact times of the free oscillator that leaves its stop at t0.

    They do not depend on the velocity. For a wall they are t0 + pi m / W with
    W = sqrt(k - a^2) (Dyskin et al. 2012, section 3); for one soft stop they are the entries
    into it.

    Parameters
    ----------
    osc
        An oscillator with one stop, at its equilibrium x = 0.
    count
        How many, >= 0; the start itself is none of them.
    t0
        Time of the start [time].

    Returns
    -------
    array
        (count,) times [time].

    Raises
    ------
    ParameterError
        If the times depend on the amplitude (a stop away from the equilibrium, or several), or
        the oscillator does not come back to its stop.

    Examples
    --------
    >>> import percuss as pc
    >>> eigenset(pc.impact_oscillator(), 3)
    array([3.14159265, 6.28318531, 9.42477796])
    """
    count = whole("count", count, 0, MOST_ROWS)
    off, inside = _half_periods(osc)
    times = off + (off + inside) * np.arange(count, dtype=np.float64)
    return np.asarray(real("t0", t0) + times)


def resonant_frequency(osc: Oscillator) -> float:
    """Return the angular frequency of the free oscillation against the stop.

    2 W+ W- / (W+ + W-) with W = sqrt(k - a^2) on either side, 2 W+ for a wall (Dyskin et al.
    2012, eq. 2).

    Parameters
    ----------
    osc
        An oscillator with one stop, at its equilibrium x = 0.

    Returns
    -------
    float
        The frequency [1/time].

    Raises
    ------
    ParameterError
        If it depends on the amplitude (a stop away from the equilibrium, or several), or the
        oscillator does not come back to its stop.

    Examples
    --------
    >>> import percuss as pc
    >>> resonant_frequency(pc.bilinear_oscillator(stiffness_below=4.0))
    1.3333333333333333
    """
    return 2.0 * math.pi / sum(_half_periods(osc))


def _half_periods(osc: Oscillator) -> tuple[float, float]:
    """Return how long the free oscillator stays off its stop, and in it."""
    system = System.of(osc, None)
    bounds = [at for at in system.lines.at if at is not None]
    if len(bounds) != 1 or bounds[0] != 0:
        places = ", ".join(str(float(at)) for at in bounds) or "none"
        reason = (
            f"stops at {places}; without exactly one stop, at the equilibrium x = 0, "
            "times between impacts depend on the amplitude"
        )
        raise ParameterError("oscillator.stops", len(bounds), reason)
    law = system.law
    halves = []
    for row in law[FIRST_HARMONIC : FIRST_HARMONIC + int(law[0, N_REGIONS])]:
        if row[OVERDAMPED] == 1.0 or row[RATE] == 0.0:
            reason = f"damping {row[DAMPING]:g} lets the mass creep back, it does not oscillate"
            raise ParameterError("oscillator.damping", float(row[DAMPING]), reason)
        halves.append(math.pi / float(row[RATE]))
    if WALL in (law[FIRST_HARMONIC, LOWER_KIND], law[FIRST_HARMONIC, UPPER_KIND]):
        return halves[0], 0.0
    above = osc.stops[0].side == "above"
    return (halves[0], halves[1]) if above else (halves[1], halves[0])
