"""The pattern that impact times repeat, or settle to.

For a pattern of m impacts in n forcing periods T the deviations are e_k = t_{k+m} - t_k - n T.
They vanish on a periodic orbit with this pattern; near it one repetition E_k = (e_{km}, ...,
e_{km+m-1}) follows from the two before,

    E_{k+2} = p E_{k+1} - q E_k,

since the return map is linear there; the roots of z^2 = p z - q are the multipliers of the orbit.
A motion settles to the pattern if the recurrence holds, its multipliers lie inside the unit
circle, and the deviations fall by them, with a rate that does not fade: where the true pattern
is a longer one, the deviations of a shorter one tend to constants instead. A multiple of the
pattern settles as well, therefore short patterns are tried first.

Instants carry rounding. Each flight adds an error of the size of its own rounding, and the errors
of all flights up to an instant t sum at most to some roundings of t itself: smaller deviations
mean nothing.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats
from percuss.numerics import log

# A pattern is believed when it is seen three times, and in so many times at least.
REPETITIONS = 3
FEWEST = 6
# Times repeat themselves when they are equal within this part of the mean interval.
TOLERANCE = 1e-8
# Rounding of all flights together, in units of the last digit of the last time.
ROUNDINGS = 64
# A deviation decides the recurrence when it is so many times larger than rounding.
SIGNIFICANT = 100.0
# Repetitions in which a decay is seen, at least: three thirds of four.
FEWEST_REPETITIONS = 12
# Windows of a decay: each is by this part of the repetitions shorter than the one before.
SHRINK = 0.85
# The recurrence holds within this part of the deviations.
LINEAR = 0.03
# The deviations fall by this factor from the first to the last third of a window ...
FALL = 0.4
# ... and the fall from the second third to the last is at least this part of the one before, in
# logarithms. It is 1 for a geometric decay and 0 for a plateau; t^(-3/2), by which deviations of
# twice a pattern fall where its period doubles, has 0.74.
STEADY = 0.85
# A pattern is refuted by a multiple of it if what the deviations of the multiple still add up to
# is below this part of its own: those tend to other values than 0. Were it a pattern, with the
# multiplier z, the part would be 1/abs(1 - z), 1/2 at least.
REFUTING = 0.35
# Multiples that may refute, and the repetitions that show what their deviations add up to.
MOST_TIMES = 6
FEWEST_OF_MULTIPLE = 6
# Determinants of two equations below this part of their entries are rounding.
SINGULAR = 1e-10
# Deviations further from 0 than this part of a forcing period belong to other patterns.
SAME = 0.25


@dataclass(frozen=True, slots=True)
class Pattern:
    """The pattern of a set of times.

    Attributes
    ----------
    n_impacts, n_periods
        So many impacts in so many forcing periods; n_periods is 0 where there is no period.
    is_settling
        Whether the times still come nearer to it.
    rate
        The deviations fall as exp(-rate t) [1/time]; NaN where they have fallen.
    deviation
        Largest deviation of the times that repeat; while they settle, of the last repetition.
    n_used
        How many times that rests on.
    """

    n_impacts: int
    n_periods: int
    is_settling: bool
    rate: float
    deviation: float
    n_used: int


def find_pattern(times: Floats, period: float | None, *, is_dissipative: bool) -> Pattern | None:
    """Return the smallest pattern that times repeat or settle to, None if they show none.

    Parameters
    ----------
    times
        (n,) array, increasing [time].
    period
        Of the forcing [time], None if it has none.
    is_dissipative
        Whether neighbours can approach: without losses no motion settles.

    Returns
    -------
    Pattern or None
        None also for fewer than six times.

    Examples
    --------
    >>> k = np.arange(40.0)
    >>> pattern = find_pattern(k + 0.1 * (-0.8) ** k, 1.0, is_dissipative=True)
    >>> pattern.n_impacts, pattern.is_settling, round(pattern.rate, 6)
    (1, True, 0.223144)
    """
    if len(times) < FEWEST:
        return None
    mean = float(times[-1] - times[0]) / (len(times) - 1)
    rounding = ROUNDINGS * float(np.spacing(np.abs(times[[0, -1]]).max()))
    # Without losses a small deviation stays: times that differ by more than rounding are those of
    # a quasi-periodic motion.
    equal = max(TOLERANCE * mean, rounding) if is_dissipative else rounding
    for n_impacts in _candidates(times, period):
        pattern = _repeating(times, n_impacts, period, equal)
        if pattern is None and is_dissipative:
            pattern = _settling(times, n_impacts, period, rounding)
        if pattern is not None:
            return pattern
    return None


def _candidates(times: Floats, period: float | None) -> Iterator[int]:
    """Yield the lengths of patterns whose last deviations are not too large, upwards.

    Of a million times most lengths fail here, on a few times each.
    """
    lengths = np.arange(1, (len(times) - 1) // REPETITIONS + 1)
    for n_last in (2, 8, 32):
        known = lengths[2 * lengths >= n_last]
        if len(known) == 0:
            break
        back = np.arange(n_last)
        lags = times[-1 - back] - times[-1 - back - known[:, np.newaxis]]
        unit = period if period is not None else float(lags.mean()) if lags.size else 1.0
        whole = np.round(lags[:, :1] / unit) * unit if period is not None else lags[:, :1]
        passes = (np.abs(lags - whole) <= SAME * unit).all(axis=1) & (whole[:, 0] > 0.0)
        lengths = np.concatenate([lengths[2 * lengths < n_last], known[passes]])
    yield from lengths.tolist()


def _repeating(times: Floats, n_impacts: int, period: float | None, equal: float) -> Pattern | None:
    """Return a pattern that the last times repeat, three times at least."""
    least = max((REPETITIONS - 1) * n_impacts, FEWEST - 1)
    lags = times[n_impacts:] - times[:-n_impacts]
    if len(lags) < least:
        return None
    n_periods, duration = _duration(lags, n_impacts, period)
    off = np.abs(lags - duration)
    if not (off[-least:] <= equal).all():
        return None
    outside = np.flatnonzero(off > equal)
    first = int(outside[-1]) + 1 if len(outside) else 0
    deviation = float(off[first:].max())
    return Pattern(n_impacts, n_periods, False, math.nan, deviation, len(times) - first)


def _settling(
    times: Floats, n_impacts: int, period: float | None, rounding: float
) -> Pattern | None:
    """Return the pattern that times come nearer to, by multipliers inside the unit circle.

    It has as many impacts as are given, or is a part of that.
    """
    off, n_periods, duration = _deviations(times, n_impacts, period)
    if len(off) < FEWEST_REPETITIONS:
        return None
    sizes = np.abs(off).max(axis=1)
    far = np.flatnonzero(sizes > SAME * (period if period is not None else duration))
    significant = np.flatnonzero(sizes > SIGNIFICANT * rounding)
    first = int(far[-1]) + 1 if len(far) else 0
    last = int(significant[-1]) + 1 if len(significant) else 0
    while last - first >= FEWEST_REPETITIONS:
        multiplier = _multiplier(off[first:last])
        if multiplier is not None:
            # Both ends, counted in times from the last one.
            window = (len(off) - first) * n_impacts, (len(off) - last) * n_impacts
            if any(
                _refutes(times, n_impacts, times_round * n_impacts, period, window)
                for times_round in range(2, MOST_TIMES + 1)
            ):
                return None
            parts = _parts_that_settle(times, (n_impacts, n_periods), period, window)
            if parts == 0:
                return None
            rate = -log(multiplier) / duration if multiplier > 0.0 else math.inf
            own = off if parts == 1 else _deviations(times, n_impacts // parts, period)[0]
            deviation = float(np.abs(own[-1]).max())
            counts = n_impacts // parts, n_periods // parts
            return Pattern(*counts, True, rate, deviation, window[0] + n_impacts)
        first = last - int(SHRINK * (last - first))
    return None


def _refutes(
    times: Floats, n_impacts: int, multiple: int, period: float | None, window: tuple[int, int]
) -> bool:
    """Return whether a multiple of a pattern shows that its deviations do not tend to 0.

    The deviations of the pattern change by those of the multiple; what these still add up to, by
    their own multiplier, is all that they can change by.
    """
    # Without a period the limit of the deviations is not known.
    if period is None or (len(times) - multiple) // multiple < FEWEST_OF_MULTIPLE:
        return False
    of_multiple = _within(_deviations(times, multiple, period)[0], multiple, window)
    own = _within(_deviations(times, n_impacts, period)[0], n_impacts, window)
    if len(of_multiple) < FEWEST_OF_MULTIPLE or len(own) < FEWEST_OF_MULTIPLE:
        return False
    multiplier = _modulus(*_recurrence(of_multiple)[:2])
    if multiplier >= 1.0:
        return False
    # Of a whole third: single deviations may pass through 0.
    return _thirds(of_multiple)[2] < REFUTING * (1.0 - multiplier) * _thirds(own)[2]


def _parts_that_settle(
    times: Floats, counts: tuple[int, int], period: float | None, window: tuple[int, int]
) -> int:
    """Return of how many equal parts a pattern that times settle to is made, 0 where unknown.

    The deviations of a part fall as those of the whole if the part is a pattern by itself, and
    tend to constants if it is not.
    """
    n_impacts, n_periods = counts
    fall = _fall(_within(_deviations(times, n_impacts, period)[0], n_impacts, window))
    for parts in range(n_impacts, 1, -1):
        if n_impacts % parts or n_periods % parts:
            continue
        part = n_impacts // parts
        off, periods, _ = _deviations(times, part, period)
        if periods * parts != n_periods or _refutes(times, part, n_impacts, period, window):
            continue
        return parts if _fall(_within(off, part, window)) >= 0.5 * fall else 0
    return 1


def _within(off: Floats, n_impacts: int, window: tuple[int, int]) -> Floats:
    """Return the repetitions inside a window, whose ends are counted in times from the last."""
    first, last = (max(len(off) - end // n_impacts, 0) for end in window)
    return off[first:last]


def _fall(off: Floats) -> float:
    """Return the logarithm by which deviations fall from the first to the last third."""
    early, _, late = _thirds(off)
    return log(early / late) if late > 0.0 else math.inf


def _deviations(times: Floats, n_impacts: int, period: float | None) -> tuple[Floats, int, float]:
    """Return the deviations (k, m) of repetitions, how many periods one lasts, and how long."""
    lags = times[n_impacts:] - times[:-n_impacts]
    n_periods, duration = _duration(lags, n_impacts, period)
    # Without a known period repetitions are compared with one another.
    off = lags - duration if period is not None else lags[n_impacts:] - lags[:-n_impacts]
    count = len(off) // n_impacts
    return off[len(off) - count * n_impacts :].reshape(count, n_impacts), n_periods, duration


def _thirds(off: Floats) -> tuple[float, float, float]:
    """Return the root mean squares of the deviations in the thirds of a window."""
    n = len(off) // 3
    early, middle, late = (
        math.sqrt(float(np.square(off[i * n : (i + 1) * n]).mean())) for i in range(3)
    )
    return early, middle, late


def _duration(lags: Floats, n_impacts: int, period: float | None) -> tuple[int, float]:
    """Return how many forcing periods the last repetition lasts, and how long."""
    if period is None:
        # The lags of a whole pattern share the error of each time.
        return 0, float(lags[-n_impacts:].mean())
    n_periods = round(float(lags[-1]) / period)
    return n_periods, n_periods * period


def _multiplier(off: Floats) -> float | None:
    """Return the modulus of the leading multiplier of deviations (k, m) that decay by it."""
    early, middle, late = _thirds(off)
    if not 0.0 < late <= FALL * early or not late < middle < early:
        return None
    if log(middle / late) < STEADY * log(early / middle):
        return None
    p, q, error = _recurrence(off)
    if error > LINEAR:
        return None
    multiplier = _modulus(p, q)
    if not multiplier < 1.0:
        return None
    predicted = -2.0 * (len(off) // 3) * log(multiplier) if multiplier > 0.0 else math.inf
    seen = log(early / late)
    return multiplier if 0.5 * seen <= predicted <= 2.0 * seen else None


def _modulus(p: float, q: float) -> float:
    """Return the larger modulus of the roots of z^2 = p z - q."""
    root = cmath.sqrt(0.25 * p * p - q)
    return max(abs(0.5 * p + root), abs(0.5 * p - root))


def _recurrence(off: Floats) -> tuple[float, float, float]:
    """Return p, q of E_{k+2} = p E_{k+1} - q E_k by least squares, and the error of the fit.

    Each equation is divided by its largest entry, so that late ones count as early ones do.
    """
    rows = np.stack([off[:-2], off[1:-1], off[2:]])
    sizes = np.abs(rows).max(axis=(0, 2), keepdims=True)
    old, now, new = rows / np.where(sizes > 0.0, sizes, 1.0)
    oo, on, nn = float((old * old).sum()), float((old * now).sum()), float((now * now).sum())
    ow, nw = float((old * new).sum()), float((now * new).sum())
    determinant = oo * nn - on * on
    if determinant <= SINGULAR * oo * nn:
        # One multiplier alone: each repetition is that times the one before.
        p, q = (nw / nn if nn > 0.0 else 0.0), 0.0
    else:
        p, q = (oo * nw - on * ow) / determinant, (on * nw - nn * ow) / determinant
    residual = new - p * now + q * old
    return p, q, math.sqrt(float(np.square(residual).mean()))
