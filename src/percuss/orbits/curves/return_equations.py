"""How neighbours of a periodic orbit return: the linearised equations of a chain.

With the changes dt of the instants of the events and dv of the velocities after them as unknowns,
neighbours that come back multiplied by mu obey M(mu) (dt, dv) = 0. There det M(mu) is the
characteristic polynomial of the monodromy matrix times the velocities of the events: nothing is
divided by the velocity of an impact, and M is smooth where that vanishes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["return_equations", "unknowns_from_events"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def return_equations(matrix: Floats, n: int, multiplier: float, mirror: float = 1.0) -> Floats:
    """Return M(mu) from the scaled derivatives that `percuss.kernels.shooting.shoot` writes.

    Parameters
    ----------
    matrix
        (2 n + 1, 2 n + 1) array, derivatives by the first instant, the durations and the
        velocities, with one unit of time and one of velocity.
    n
        How many events there are.
    multiplier
        mu.
    mirror
        -1.0 where the events begin anew mirrored, after half a period.

    Returns
    -------
    array
        (2 n, 2 n), by dt_0, ..., dt_(n-1), dv_0, ..., dv_(n-1).
    """
    into, of, factors, constants = _places(n, multiplier, mirror)
    sums = np.bincount(into, factors * matrix.ravel()[of], minlength=4 * n * n)
    return np.asarray((sums + constants).reshape(2 * n, 2 * n))


@lru_cache(maxsize=64)
def _places(n: int, multiplier: float, mirror: float) -> tuple[Integers, Integers, Floats, Floats]:
    """Return which entries of M are sums of which of the derivatives, by which factors."""
    terms: list[tuple[int, int, float]] = []
    constants = np.zeros(4 * n * n)
    for i in range(n):
        following = (i + 1) % n
        # After the last event comes the first one, once round.
        end = multiplier if following == 0 else 1.0
        for row in (2 * i, 2 * i + 1):
            here, there = 2 * n * row, (2 * n + 1) * row
            # Events that come later begin one flight later, and let the one before last longer.
            terms += [(here + i, there, 1.0), (here + i, there + 1 + i, -1.0)]
            terms += [(here + following, there + 1 + i, end)]
            terms += [(here + n + i, there + 1 + n + i, 1.0)]
        # The velocity after an event stands in its own row, with the factor 1.
        own = 2 * n * (2 * i + 1) + n + following
        turned = mirror if following == 0 else 1.0
        constants[own] += turned * end - (turned if n == 1 else 0.0)
    into, of, factors = zip(*terms, strict=True)
    return np.array(into), np.array(of), np.array(factors), constants


def unknowns_from_events(changes: Floats) -> Floats:
    """Return changes of the unknowns of a chain from those of its events, with mu = 1.

    Parameters
    ----------
    changes
        (2 n,) array, dt and dv.

    Returns
    -------
    array
        (2 n + 1,), of the first instant, the durations and the velocities.
    """
    n = len(changes) // 2
    instants = changes[:n]
    return np.concatenate([instants[:1], np.roll(instants, -1) - instants, changes[n:]])
