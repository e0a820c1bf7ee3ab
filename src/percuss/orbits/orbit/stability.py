"""The multipliers of an orbit, and its stability."""

from __future__ import annotations

import cmath
import math
from typing import Literal, TypeAlias

import numpy as np

from percuss.arrays import Complexes, Floats

Stability: TypeAlias = Literal["asymptotic", "elliptic", "parabolic", "unstable"]

# A trace this near to the edge of stability, as a part of the matrix, is on it: orbits are
# found to some 1e-12, and a conservative family lies there exactly.
ON_EDGE = 1e-9
# A multiplier within this distance of the unit circle may be on it: an orbit is known to some
# 1e-12.
ON_CIRCLE = 1e-9
# Where two multipliers that are inverse to each other meet at +1 or -1, each has half of the digits.
NEAR_EDGE = math.sqrt(ON_EDGE)


def multipliers_of(monodromy: Floats, determinant: float, *, is_free: bool = False) -> Complexes:
    """Return the eigenvalues of a 2x2 matrix whose determinant is known exactly, larger first.

    One of free motion is 1, along the orbit, and the other one the determinant.
    The smaller one is the determinant over the larger: it keeps its digits however far the two
    are apart. Of a conjugate pair the one with positive imaginary part comes first.

    Examples
    --------
    >>> import numpy as np
    >>> multipliers_of(np.array([[4.0, 0.0], [1.0, 0.5]]), 2.0).real
    array([4. , 0.5])
    """
    if is_free:
        return np.array([max(1.0, determinant), min(1.0, determinant)], dtype=np.complex128)
    half = 0.5 * float(np.trace(monodromy))
    root = cmath.sqrt(half * half - determinant)
    first = half + (root if half >= 0.0 else -root)
    if root.imag != 0.0:
        return np.array([complex(half, abs(root.imag)), complex(half, -abs(root.imag))])
    second = determinant / first if first != 0.0 else 0.0j
    return np.array([first, second])


def stability_of(monodromy: Floats, determinant: float, *, conservative: bool) -> Stability:
    """Return the stability of an orbit to first order, from its monodromy matrix.

    With D its determinant, both multipliers lie inside the unit circle if D < 1 and
    abs(trace) < 1 + D: "asymptotic". Otherwise it is "elliptic", a conjugate pair on the circle,
    "parabolic", a multiplier at +1 or -1, or "unstable". A motion is conservative if it has neither
    dashpots nor restitutions below 1.

    Examples
    --------
    >>> import numpy as np
    >>> stability_of(np.array([[0.0, 1.0], [-0.5, 0.2]]), 0.5, conservative=False)
    'asymptotic'
    """
    edge = 1.0 + (1.0 if conservative else determinant)
    trace = abs(float(np.trace(monodromy)))
    size = float(np.abs(monodromy).max())
    if not math.isfinite(size):
        return "unstable"
    size = max(1.0, size)
    if determinant > 1.0 and not conservative:
        return "unstable"
    if trace > edge + ON_EDGE * size:
        return "unstable"
    if trace >= edge - ON_EDGE * size:
        return "parabolic"
    return "elliptic" if conservative else "asymptotic"


def stability_of_multipliers(multipliers: Complexes) -> Stability:
    """Return the stability of an orbit to first order, from multipliers of any number.

    "asymptotic" where all lie inside the unit circle, and "unstable" where one lies outside.
    Between, those on the circle are complex pairs, "elliptic", or one is +1 or -1, "parabolic".

    Examples
    --------
    >>> import numpy as np
    >>> stability_of_multipliers(np.array([0.6 + 0.8j, 0.6 - 0.8j, 0.5, 0.1]))
    'elliptic'
    """
    sizes = np.abs(multipliers)
    if (sizes < 1.0 - ON_CIRCLE).all():
        return "asymptotic"
    if not np.isfinite(sizes).all():
        return "unstable"
    from_edge = np.minimum(np.abs(multipliers - 1.0), np.abs(multipliers + 1.0))
    inverse = np.abs(np.outer(multipliers, multipliers) - 1.0) <= ON_CIRCLE
    np.fill_diagonal(inverse, False)
    is_at_edge = (from_edge <= ON_CIRCLE) | ((from_edge <= NEAR_EDGE) & inverse.any(axis=0))
    if (sizes[~is_at_edge] > 1.0 + ON_CIRCLE).any():
        return "unstable"
    return "parabolic" if is_at_edge.any() else "elliptic"


def stability_of_cycle(determinant: float, *, conservative: bool) -> Stability:
    """Return the stability of a limit cycle of free motion to first order.

    A neighbour along the cycle stays one, by a multiplier of 1; the distance of all others shrinks
    by the determinant in a period. Motions without losses are a family: "parabolic".

    Examples
    --------
    >>> stability_of_cycle(0.8, conservative=False), stability_of_cycle(1.0, conservative=True)
    ('asymptotic', 'parabolic')
    """
    if conservative or abs(determinant - 1.0) <= ON_EDGE:
        return "parabolic"
    return "asymptotic" if determinant < 1.0 else "unstable"
