"""A root between two ends, to the last bit."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["bisected"]


def bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that falls through zero does so.

    Parameters
    ----------
    function
        Positive just above `low`, negative just below `high`, with one change of sign; it is not
        evaluated at the ends.
    low, high
        The ends.

    Returns
    -------
    float
        A double next to the change of sign.

    Examples
    --------
    >>> bisected(lambda x: 2.0 - x * x, 0.0, 2.0)
    1.414213562373095
    """
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle
