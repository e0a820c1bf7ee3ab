"""The envelope of a motion as a power of time, with the errors of its numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import real
from percuss.motion.spectrum import Quantity
from percuss.motion.trajectory import Trajectory
from percuss.numerics import dot, exp, log

GrowthKind: TypeAlias = Literal["grows", "decays", "bounded", "too_few"]

# Stretches of time, equal in its logarithm, whose mean peak is one point of the fit; and the
# fewest such points, and peaks in all, from which an exponent is fitted.
BLOCKS = 24
FEWEST_BLOCKS = 6
FEWEST_PEAKS = 12
# An envelope grows if its exponent is this many errors above 0, and the envelope rises by this
# part of itself over the fit.
CERTAIN = 3.0
LEAST_RISE = 0.05
# A lag-one correlation near 1 would make the error of a short series infinite.
MOST_CORRELATED = 0.9
# Points of a flight from which the search of its highest begins, and halvings of their distance.
POINTS = 17
HALVINGS = 45


@dataclass(frozen=True, slots=True)
class Growth:
    """The law peak = coefficient t^exponent of an envelope.

    Attributes
    ----------
    kind
        "grows" or "decays": the exponent differs from 0 by more than three errors, and the
        envelope changes by more than 5 % over the fit; "bounded" otherwise, as far as the run
        tells; "too_few" peaks.
    coefficient, coefficient_error
        The factor and its standard error [unit of the peaks / time^exponent].
    exponent, exponent_error
        The exponent and its standard error.
    start, end
        First and last time that was used, counted from t0 [time].
    n_points
        How many peaks were used.
    """

    kind: GrowthKind
    coefficient: float
    coefficient_error: float
    exponent: float
    exponent_error: float
    start: float
    end: float
    n_points: int


def growth(run: Trajectory, of: Quantity = "velocity", *, since: float | None = None) -> Growth:
    """Fit the envelope of a run by a power of the time since its start.

    The largest peak of each cycle is taken, a cycle being the forcing's period or two flights,
    whichever is longer. Their logarithms are averaged over 24 stretches equal in log t and fitted
    by least squares. Neighbouring residuals are alike where the law is not yet reached or the
    motion wanders, so the errors are those of fewer independent points: they are multiplied by
    sqrt((1 + c)/(1 - c)) with the correlation c of one residual with the next, where positive.

    Parameters
    ----------
    run
        The run.
    of
        "velocity": speeds at impacts (without walls, at the edges of soft stops);
        "displacement": the largest distance from 0 in each flight, exact.
    since
        Time after t0 from which on peaks are used [time], > 0; default: a hundredth of the run.

    Returns
    -------
    Growth
        The law, its errors, and in words whether the envelope grows.

    Raises
    ------
    ParameterError
        If the quantity is unknown or `since` not inside the run.

    Examples
    --------
    The main resonance grows linearly, by 4/3 in each pi (Dyskin et al. 2012, eq. 19):

    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(2), v0=0.0, t_end=1000.0)
    >>> law = growth(run)
    >>> law.kind, round(law.exponent, 3)
    ('grows', 1.0)
    >>> round(law.coefficient * 3.141592653589793, 2)
    1.33
    """
    if not isinstance(run, Trajectory):
        raise ParameterError("run", run, "not the run of an oscillator; simulate() returns one")
    if of not in ("velocity", "displacement"):
        raise ParameterError("of", of, "neither velocity nor displacement")
    duration = run.t_end - run.t0
    first = 0.01 * duration if since is None else real("since", since)
    if not 0.0 < first < duration:
        raise ParameterError("since", since, f"not between 0 and the run's {duration:g}")
    times, heights = _largest_of_cycles(run, *peaks(run, of))
    used = (times - run.t0 >= first) & (heights > 0.0)
    return fit_power_law(times[used] - run.t0, heights[used])


def peaks(run: Trajectory, of: Quantity = "velocity") -> tuple[Floats, Floats]:
    """Return the time and the size of the peak of each flight.

    Parameters
    ----------
    run
        The run.
    of
        "velocity" or "displacement", as in `growth`.

    Returns
    -------
    tuple of arrays
        Times [time] and peaks [length/time, or length], (n,) each.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(restitution=0.5), v0=1.0, max_impacts=3)
    >>> peaks(run)[1], peaks(run, "displacement")[1].round(12)
    (array([1.  , 0.5 , 0.25]), array([0.5 , 0.25]))
    """
    if of == "velocity":
        if len(run.impacts):
            speeds = np.maximum(np.abs(run.impacts.v_before), np.abs(run.impacts.v_after))
            return run.impacts.t, np.asarray(speeds)
        return run.crossings.t, np.abs(run.crossings.v)
    cuts = np.unique(np.concatenate([run.impacts.t, run.crossings.t]))
    if len(cuts) < 2:
        return np.empty(0), np.empty(0)
    return _highest_points(run, cuts[:-1], cuts[1:])


def _highest_points(run: Trajectory, start: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Return where abs(x) is largest in each flight, and that."""
    share = np.arange(1, POINTS) / POINTS
    t = start[:, np.newaxis] + np.multiply.outer(end - start, share)
    x = run(t)[0]
    rows, best = np.arange(len(start)), np.abs(x).argmax(axis=1)
    sign = np.sign(x[rows, best])
    step = (end - start) / POINTS
    # The speed away from 0 changes its sign between the neighbours of the largest: halve there.
    low, high = t[rows, best] - step, t[rows, best] + step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        is_rising = sign * run(middle)[1] > 0.0
        low, high = np.where(is_rising, middle, low), np.where(is_rising, high, middle)
    times = 0.5 * (low + high)
    return times, np.abs(run(times)[0])


def _largest_of_cycles(run: Trajectory, times: Floats, heights: Floats) -> tuple[Floats, Floats]:
    if len(times) < FEWEST_PEAKS:
        return times, heights
    period = (run.forcing.period if run.forcing is not None else None) or 0.0
    flight = float(times[-1] - times[0]) / (len(times) - 1)
    cycle = np.floor((times - run.t0) / max(period, 2.0 * flight)).astype(np.int64)
    starts = np.flatnonzero(np.diff(cycle, prepend=cycle[0] - 1))
    order = np.lexsort((heights, cycle))
    largest = order[np.append(starts[1:], len(times)) - 1]
    return times[largest], heights[largest]


def fit_power_law(times: Floats, heights: Floats) -> Growth:
    """Fit heights = coefficient times^exponent, as `growth` does with the peaks it has chosen.

    Parameters
    ----------
    times
        (n,) array, increasing, > 0 [time].
    heights
        (n,) array, > 0.

    Returns
    -------
    Growth
        The law.

    Examples
    --------
    >>> t = np.linspace(1.0, 1000.0, 500)
    >>> law = fit_power_law(t, 2.0 * t**0.5)
    >>> round(law.coefficient, 9), round(law.exponent, 9), law.kind
    (2.0, 0.5, 'grows')
    """
    n = len(times)
    start, end = (float(times[0]), float(times[-1])) if n else (math.nan, math.nan)
    points = _means(log(times), log(heights)) if n >= FEWEST_PEAKS else np.empty((2, 0))
    if points.shape[1] < FEWEST_BLOCKS:
        return Growth("too_few", math.nan, math.nan, math.nan, math.nan, start, end, n)
    # About the middle the two numbers of the line do not depend on one another.
    middle = float(points[0].mean())
    log_t, log_height = points[0] - middle, points[1]
    spread = dot(log_t, log_t)
    exponent = dot(log_t, log_height) / spread
    level = float(log_height.mean())
    residuals = log_height - level - exponent * log_t
    variance = _variance(residuals)
    exponent_error = math.sqrt(variance / spread)
    coefficient = exp(level - exponent * middle)
    relative = math.sqrt(variance / len(log_t) + variance / spread * middle * middle)
    kind = _kind(exponent, exponent_error, log(end / start))
    return Growth(
        kind, coefficient, coefficient * relative, exponent, exponent_error, start, end, n
    )


def _means(log_t: Floats, log_height: Floats) -> Floats:
    """Return the means (2, m) over stretches equal in log t, without the empty ones."""
    width = (log_t[-1] - log_t[0]) / BLOCKS or 1.0
    block = np.minimum((log_t - log_t[0]) / width, BLOCKS - 1).astype(np.int64)
    counts = np.bincount(block)
    filled = counts > 0
    sums = [np.bincount(block, values)[filled] for values in (log_t, log_height)]
    return np.asarray(np.stack(sums) / counts[filled])


def _variance(residuals: Floats) -> float:
    """Return the variance of the residuals, made larger by their correlation."""
    n = len(residuals)
    square = dot(residuals, residuals)
    if square == 0.0:
        return 0.0
    # The two fitted numbers pull the estimate down by about 2/n each.
    correlation = dot(residuals[1:], residuals[:-1]) / square + 4.0 / n
    correlation = min(max(correlation, 0.0), MOST_CORRELATED)
    return square / (n - 2) * (1.0 + correlation) / (1.0 - correlation)


def _kind(exponent: float, error: float, log_span: float) -> GrowthKind:
    if abs(exponent) <= CERTAIN * error or abs(exponent) * log_span < LEAST_RISE:
        return "bounded"
    return "grows" if exponent > 0.0 else "decays"
