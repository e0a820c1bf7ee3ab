"""Times as they are given to a result: an array of numbers, each taken exactly."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from percuss.errors import ParameterError
from percuss.model.exact import Phase, phase_problem, plain

__all__ = ["exact_times"]


def exact_times(t: ArrayLike | Phase) -> tuple[list[Phase], tuple[int, ...]]:
    """Return times one after the other, as exact as they were given, and their shape.

    Raises
    ------
    ParameterError
        If one is no finite number.

    Examples
    --------
    >>> exact_times(["1/3", 0.5])
    (['1/3', 0.5], (2,))
    >>> exact_times("pi/2")
    (['pi/2'], ())
    """
    # As objects: NumPy would round fractions, and turn numbers beside a text into texts.
    array = np.asarray(t, dtype=object)
    found = []
    for value in array.reshape(-1):
        number = plain(value)
        problem = phase_problem(number)
        if problem is not None:
            raise ParameterError("t", number, problem)
        found.append(cast("Phase", number))
    return found, array.shape
