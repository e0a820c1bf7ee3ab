"""After which time a motion repeats itself, from its points on a section."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from percuss.arrays import Flags, Floats, Integers
from percuss.ensembles.decisions import SAME, SETTLED, periods_of_motions
from percuss.kernels.law_columns import PERIOD, STIFFNESS
from percuss.kernels.structure.basis import SPRING
from percuss.model.acting_sets import StructureSystem
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.model.system import law, region_rows


def is_free(force: Forcing | Loads | None) -> bool:
    """Return whether motions have no forcing but a constant, and so no period of their own."""
    return force is None or force.is_constant


def counting_periods(laws: Floats, which: Integers) -> Floats:
    """Return the time in which each motion is counted [time], (n,) array.

    It is the period of its forcing. Without a forcing it is 2 pi / sqrt(abs(k)), with the least
    stiffness k of a region that is not 0, or 2 pi if all are.

    Examples
    --------
    >>> from percuss.model import Oscillator, cosine
    >>> from percuss.model.system import law
    >>> laws = np.stack([law(Oscillator(4.0), None)])
    >>> counting_periods(laws, np.zeros(1, dtype=int)) / np.pi
    array([1.])
    """
    periods = laws[:, 0, PERIOD].copy()
    for i in np.flatnonzero(periods == 0.0).tolist():
        stiffness = np.abs(laws[i, region_rows(laws[i]), STIFFNESS])
        least = stiffness[stiffness > 0.0].min(initial=np.inf)
        periods[i] = 2.0 * math.pi / np.sqrt(least if np.isfinite(least) else 1.0)
    return np.asarray(periods[which])


def counting_period(system: StructureSystem) -> float:
    """Return the time in which motions of a structure are counted [time].

    It is the period of its loads. Without a load it is 2 pi / sqrt(abs(k)), with the least k of a
    mode with no stop acting that is not 0, or 2 pi if all are.

    Examples
    --------
    >>> from percuss.model import Structure
    >>> counting_period(StructureSystem.of(Structure(mass=[1, 1], stiffness=[4, 9]), None)) / np.pi
    1.0
    """
    if system.period is not None:
        return system.period
    stiffness = np.abs(system.sets.modes[0, :, SPRING])
    least = stiffness[stiffness > 0.0].min(initial=np.inf)
    return float(2.0 * math.pi / np.sqrt(least if np.isfinite(least) else 1.0))


def counting_period_of(osc: Oscillator | Structure, force: Any) -> float:
    """Return the time in which a motion is counted [time]."""
    if isinstance(osc, Structure):
        return counting_period(StructureSystem.of(osc, force))
    return float(counting_periods(law(osc, force)[np.newaxis], np.zeros(1, dtype=np.int64))[0])


def period_of(points: Floats, longest: int, every: Floats) -> Integers:
    """Return the period of each motion in forcing periods, 0 where it does not repeat itself.

    Parameters
    ----------
    points
        (n, m, 2 d) array of x and v, one a period.
    longest
        The longest period considered, in forcing periods, below m.
    every
        (n,) array, the forcing periods [time].

    Returns
    -------
    (n,) array
        The least period p at which all strobes agree with those p later to 1e-6 of the motion's
        size, where those of a shorter one that divides it are apart by more than 1e-4. A velocity
        counts as what it moves in a radian of the forcing.

    Examples
    --------
    >>> alternating = np.array([[[1.0, 0.0], [2.0, 0.0]] * 4])
    >>> period_of(alternating, 4, np.array([1.0]))
    array([2])
    """
    periods = np.zeros(len(points), dtype=np.int64)
    periods_of_motions(np.ascontiguousarray(points), longest, every, periods)
    return periods


def impact_periods(points: Floats, impacts: Floats, periods: int) -> Integers:
    """Return the periods of motions in forcing periods, from their impacts.

    Parameters
    ----------
    points
        (n, m, 3) array of (cycle, v_after, bound), NaN where there are fewer.
    impacts
        (n,) array, the numbers of impacts in ``periods`` forcing periods.
    periods
        Forcing periods in which they were counted.

    Returns
    -------
    (n,) array
        0 where half of the points show no period, or where they are still settling on one.
    """
    counts = _repeated_points(points)
    n_periods = np.zeros(len(points), dtype=np.int64)
    repeats = counts > 0
    n_periods[repeats] = np.round(counts[repeats] * periods / impacts[repeats])
    return n_periods


def repeat_times(points: Floats, longest: Floats) -> Floats:
    """Return the times after which motions repeat themselves, from the instants of their points.

    Parameters
    ----------
    points
        (n, m, 3) array of (t / ``longest`` mod 1, velocity, bound), in order of time; NaN where
        there are fewer.
    longest
        (n,) array [time], more than passes between the first point and the last.

    Returns
    -------
    (n,) array
        Times [time]; 0 where half of the points show none.

    Examples
    --------
    Points of both signs of the velocity, 1.5 and 0.5 apart:

    >>> t = np.array([0.0, 1.5, 2.0, 3.5, 4.0, 5.5, 6.0])
    >>> v = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    >>> points = np.stack([t / 16, v, np.zeros(7)], axis=1)
    >>> repeat_times(points[np.newaxis], np.array([16.0]))
    array([2.])
    """
    t = points[:, :, 0]
    passed = np.diff(t, axis=1)
    passed -= np.floor(passed)
    most = np.nan_to_num(passed).max(axis=1, initial=0.0, keepdims=True)
    after = points[:, 1:].copy()
    # A quarter at most: as a cycle it does not wrap.
    after[:, :, 0] = 0.25 * passed / np.where(most > 0.0, most, 1.0)
    counts = _repeated_points(after)
    elapsed = np.cumsum(np.nan_to_num(passed), axis=1)
    last = (~np.isnan(passed)).sum(axis=1) - 1
    rows = np.arange(len(points))
    # Until the last point: there the motion has settled best.
    times = elapsed[rows, last] - elapsed[rows, np.maximum(last - counts, 0)]
    return np.where(counts > 0, longest * times, 0.0)


def _repeated_points(points: Floats) -> Integers:
    """Return the least number of points after which they come again, 0 where they do not."""
    counts = np.zeros(len(points), dtype=np.int64)
    # The last pair of points rules out most numbers, and most motions.
    hopeful = _repeats_at_end(points)
    for count in (1 + np.flatnonzero(hopeful.any(axis=0))).tolist():
        rows = np.flatnonzero(hopeful[:, count - 1])
        rows = rows[_repeats(points[rows], count, SAME)]
        # The first number that fits decides, if only that there is none.
        hopeful[rows] = False
        # As of strobes: smaller differences of a divisor are the end of a transient.
        distinct = np.ones(len(rows), dtype=np.bool_)
        for q in (q for q in range(1, count // 2 + 1) if count % q == 0):
            distinct &= ~_repeats(points[rows], q, SETTLED * SAME)
        counts[rows[distinct]] = count
    return counts


def _repeats_at_end(points: Floats) -> Flags:
    """Return (n, m // 2) whether the last point of a motion is the one so many points before."""
    n, m = points.shape[:2]
    last = (~np.isnan(points[:, :, 1])).sum(axis=1) - 1
    before = last[:, np.newaxis] - np.arange(1, m // 2 + 1)
    rows = np.arange(n)[:, np.newaxis]
    step = points[rows, np.maximum(last, 0)[:, np.newaxis]] - points[rows, np.maximum(before, 0)]
    return np.asarray(_is_same(points, step, SAME) & (before >= 0))


def _repeats(points: Floats, count: int, tolerance: float) -> Flags:
    """Return which rows of points are, within a part of their size, those so many points later."""
    step = points[:, count:] - points[:, :-count]
    known = ~np.isnan(step[:, :, 1])
    same = _is_same(points, step, tolerance)
    return np.asarray((same | ~known).all(axis=1) & (known.sum(axis=1) >= count))


def _is_same(points: Floats, step: Floats, tolerance: float) -> Flags:
    """Return which differences of points are none, within a part of the size of all points."""
    speed = np.nan_to_num(np.abs(points[:, :, 1])).max(axis=1, keepdims=True)
    turn = np.abs(step[:, :, 0] - np.round(step[:, :, 0]))
    near = (turn <= tolerance) & (np.abs(step[:, :, 1]) <= tolerance * speed)
    return np.asarray(near & (step[:, :, 2] == 0.0))
