"""Instants at which a run is looked at: which of them lie in it, and on which side of an event."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels.record import HUGE
from percuss.model.exact import real
from percuss.motion.sections import section_of

# A computed time may lie outside the run by this many units in the last place.
ROUNDED = 4.0


def check_limit(limit: object) -> None:
    """Raise a ParameterError if a limit is neither that after an event nor that before it."""
    if limit not in ("after", "before"):
        raise ParameterError("limit", limit, 'neither "after" nor "before"')


def strobes(period: float, t0: float, t_end: float, cycle: float | None) -> Floats:
    """Return the instants of a run once a period, from its start or at a cycle in [0, 1)."""
    count = np.arange(int((t_end - t0) / period) + 2)
    if cycle is None:
        times = t0 + count * period
    else:
        part = section_of({"cycle": cycle}).cycle or 0.0
        first = math.ceil(t0 / period - part)
        times = (first + count + part) * period
    slack = ROUNDED * np.spacing(max(abs(t0), abs(t_end)))
    return np.asarray(times[(times >= t0 - slack) & (times <= t_end + slack)])


def span_within(between: Sequence[float] | None, t0: float, t_end: float) -> tuple[float, float]:
    """Return the instants between which a run from t0 to t_end is looked at."""
    if between is None:
        return t0, t_end
    if not hasattr(between, "__len__") or len(between) != 2:
        raise ParameterError("between", between, "not a pair of instants (first, last)")
    first, last = (real("between", t) for t in between)
    if not t0 <= first <= last <= t_end:
        reason = f"not two instants of the run, {t0!r} to {t_end!r}, in order"
        raise ParameterError("between", (first, last), reason)
    return first, last


def times_within(instants: Floats, t0: float, t_end: float) -> Floats:
    """Return the times moved into a run where only their rounding lies outside."""
    slack = ROUNDED * np.spacing(max(abs(t0), abs(t_end)))
    outside = ~((instants >= t0 - slack) & (instants <= t_end + slack))
    if outside.any():
        wrong = float(instants[outside].flat[0])
        raise ParameterError("t", wrong, f"outside the run, {t0!r} to {t_end!r}")
    return np.clip(instants, t0, t_end)


def last_moderate(is_below: Callable[[float, float], bool], low: float, end: float) -> float:
    """Return up to when, at most ``end``, a flight that begins at ``low`` stays below HUGE.

    One that begins beyond that is kept as long as it has numbers.

    Parameters
    ----------
    is_below
        Whether the motion is below a limit, its first argument, at an instant.
    low
        When the flight begins.
    end
        When it ends.

    Examples
    --------
    >>> round(last_moderate(lambda limit, t: t < math.log10(limit), 0.0, 400.0), 9)
    150.0
    """
    limit = HUGE
    if is_below(limit, end):
        return end
    if not is_below(limit, low):
        limit = math.inf
    step = 1.0
    while is_below(limit, low + step) and low + step < end:
        low, step = low + step, 2.0 * step
    high = min(end, low + step)
    if is_below(limit, high):
        return high
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if is_below(limit, middle) else (low, middle)
    return low
