"""Motion that repeats itself mirrored after half a period, and its map over that half."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.errors import ParameterError
from percuss.kernels import record as columns
from percuss.kernels.law_columns import N_HARMONICS, Law
from percuss.kernels.tangent import neighbours
from percuss.model.exact import as_fraction
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, SoftStop, Stop
from percuss.model.restitution import restitution_knots
from percuss.model.structure import Structure

# How far a frequency may be from a whole multiple of the forcing's, as for a given period.
WHOLE = 1e-9
# Of states half a period apart: orbits are found to some 1e-12.
MIRRORED = 1e-8
# Parts of the ranges of parameters at which a system is asked whether it keeps its symmetry.
ASKED = (0.25, 0.75)
# What is said where it does not.
SYMMETRY_LOST = "the symmetry is lost when they vary, and there is no curve on which it breaks"


def is_symmetric_system(osc: Oscillator, force: Forcing | None) -> bool:
    """Return whether the system is unchanged under (x, t) -> (-x, t + half a forcing period).

    The stops come in mirrored pairs, and the forcing has odd multiples of its frequency only, and
    no constant.

    Parameters
    ----------
    osc, force
        Oscillator and forcing; None for free motion, which any shift of time leaves unchanged.

    Returns
    -------
    bool
        By the exact values of the parameters.

    Examples
    --------
    >>> import percuss as pc
    >>> backlash = pc.backlash_oscillator(gap=1.0, stiffness=9.0)
    >>> is_symmetric_system(backlash, pc.cosine(2.0))
    True
    >>> is_symmetric_system(backlash, pc.cosine(2.0, constant=0.1))
    False
    """
    stops = sorted(_identity(stop, mirrored=False) for stop in osc.stops)
    if stops != sorted(_identity(stop, mirrored=True) for stop in osc.stops):
        return False
    if force is None:
        return True
    if force.harmonics and force.period is None:
        return False
    return _has_odd_harmonics(force, lambda omega: _is_odd(omega, force))


def is_symmetric_structure(structure: Structure, loads: Loads) -> bool:
    """Return whether a structure is unchanged under (x, t) -> (-x, t + half a period of the loads).

    The stops come in mirrored pairs, and the loads have odd multiples of their frequency only, and
    no constant.

    Examples
    --------
    >>> import percuss as pc
    >>> between = [pc.Wall(1, "above", "0.7", on=1), pc.Wall(-1, "below", "0.7", on=1)]
    >>> two = pc.chain([1, 1], [1, 1, 1], dashpots="0.1", stops=between)
    >>> is_symmetric_structure(two, pc.Loads({0: pc.cosine(2)}))
    True
    >>> is_symmetric_structure(two, pc.Loads({0: pc.cosine(2, constant=1)}))
    False
    """
    pairs = list(zip(structure.stops, structure.stop_directions.tolist(), strict=True))
    images = (
        sorted((_identity(stop, mirrored=mirrored), along) for stop, along in pairs)
        for mirrored in (False, True)
    )
    period = loads.period
    return (
        next(images) == next(images)
        and period is not None
        and all(
            _has_odd_harmonics(force, lambda omega: _turns_oddly(omega, period))
            for force in loads.forcings
        )
    )


def keep_symmetry(
    is_symmetric: Callable[[tuple[float, ...]], bool],
    values: Sequence[float],
    ranges: Iterable[tuple[float, float]],
) -> bool:
    """Return whether a system stays symmetric when any one of its parameters varies.

    Parameters
    ----------
    is_symmetric
        Whether it is, at values of the parameters.
    values, ranges
        Those of the system, and the least and the largest of each.

    Examples
    --------
    >>> keep_symmetry(lambda values: values[0] == 1.0, (1.0, 2.0), [(0.0, 2.0), (0.0, 4.0)])
    False
    """
    for k, (low, high) in enumerate(ranges):
        for part in ASKED:
            changed = (*values[:k], low + part * (high - low), *values[k + 1 :])
            try:
                if not is_symmetric(changed):
                    return False
            except ParameterError:
                # The parameter cannot have this value without the other one.
                continue
    return True


def _identity(stop: Stop, *, mirrored: bool) -> tuple[object, ...]:
    """Return numbers that distinguish a stop, or its mirror image, from others."""
    at, above = as_fraction(stop.at), stop.side == "above"
    if isinstance(stop, SoftStop):
        numbers: tuple[object, ...] = 1, as_fraction(stop.stiffness), as_fraction(stop.damping)
    else:
        numbers = 0, restitution_knots(stop.restitution)
    return (-at, not above, *numbers) if mirrored else (at, above, *numbers)


def _has_odd_harmonics(force: Forcing, is_odd: Callable[[object], bool]) -> bool:
    """Return whether a force has odd harmonics only, and no constant.

    A record is not looked at: an orbit under one is told as any other.
    """
    return (
        as_fraction(force.constant) == 0
        and force.record is None
        and all(is_odd(part.omega) for part in force.components() if part.cos or part.sin)
    )


def _is_odd(omega: object, force: Forcing) -> bool:
    if force.frequency is not None:
        ratio = as_fraction(omega) / force.frequency  # type: ignore[arg-type]
        return ratio.denominator == 1 and ratio.numerator % 2 == 1
    assert force.period is not None
    return _turns_oddly(omega, force.period)


def _turns_oddly(omega: object, period: float) -> bool:
    """Return whether a harmonic turns an odd number of times in a period."""
    turns = float(as_fraction(omega)) * period / (2.0 * math.pi)  # type: ignore[arg-type]
    return abs(turns - round(turns)) < WHOLE * max(1.0, turns) and round(turns) % 2 == 1


def is_mirrored_state(one: tuple[float, float], other: tuple[float, float], scale: Floats) -> bool:
    """Return whether two states (x, v) are each other's mirror image, to what orbits are found.

    With a symmetric system, and half an odd number of forcing periods between them, then the
    whole orbit repeats itself mirrored: its mirror image is the motion from the second state.
    """
    return bool((np.abs(np.add(one, other)) <= MIRRORED * scale).all())


def half_multipliers(law: Law, events: Floats, marks: Integers) -> tuple[complex, complex]:
    """Return the multipliers of the map over half a symmetric orbit, mirrored.

    Their squares are those of the orbit. Where one is -1 the symmetry breaks: two orbits start
    that are each other's mirror image. Where one is +1 symmetric orbits meet
    (Swift & Wiesenfeld 1984).

    Parameters
    ----------
    law
        The law of the motion.
    events, marks
        The record of the orbit, an even number of events after its START.
    """
    half = (len(events) - 1) // 2
    phases, out = np.empty((int(law[0, N_HARMONICS]), 2)), np.empty((1, 4))
    instant = events[half : half + 1, columns.EVENT_T].copy()
    record = columns.MotionRecord(law, 0.0, events[: half + 1], marks[: half + 1])
    neighbours(record, instant, True, phases, out)
    trace = -float(out[0, 0] + out[0, 3])
    determinant = float(out[0, 0] * out[0, 3] - out[0, 1] * out[0, 2])
    root = cmath.sqrt(0.25 * trace * trace - determinant)
    return 0.5 * trace + root, 0.5 * trace - root
