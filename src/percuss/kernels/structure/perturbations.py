"""Orthonormal perturbations of a structure's motion, and the logarithms of what they have grown by.

Lyapunov exponents are the rates of these logarithms (Benettin et al. 1980, Meccanica 15, 9). A wall
that holds the structure takes perturbations away.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Floats
from percuss.kernels.arithmetic import hypotenuse, logarithm
from percuss.kernels.compile import kernel
from percuss.kernels.structure.basis import DRAG, IS_WALL, QUICKEST, Sets, basis_of
from percuss.kernels.structure.tangent import carry, carry_far, to_modes

# Phase of the quickest rate over which perturbations are carried by the propagator itself, and the
# part of one that counts as rounding where a wall takes what is behind it.
LONGEST_PHASE = 4.0
FORGOTTEN = 1e-12


class TangentSpace(NamedTuple):
    """Arrays in which perturbations are carried: (2, n, c), (n, 2, c), (2, 2, n) and (c,)."""

    place: Floats
    columns: Floats
    paces: Floats
    logs: Floats


@kernel
def is_held(sets: Sets, b: int) -> bool:
    """Return whether a wall holds the structure in a set."""
    for i in range(sets.stops.shape[0]):
        if sets.stops[i, IS_WALL] == 1.0 and sets.keys[b] & (1 << i):
            return True
    return False


@kernel
def renew(place: Floats, logs: Floats) -> None:
    """Put unit vectors orthogonal to all others, (2, n, c), in place of those that were lost."""
    for c in range(logs.shape[0]):
        if logs[c] > -math.inf:
            continue
        part = 0
        which = 0
        most = -1.0
        for i in range(2):
            for j in range(place.shape[1]):
                left = 1.0
                for other in range(logs.shape[0]):
                    left -= place[i, j, other] * place[i, j, other]
                if left > most:
                    part = i
                    which = j
                    most = left
        place[part, which, c] = 1.0
        for _ in range(2):
            for other in range(logs.shape[0]):
                if other == c:
                    continue
                along = 0.0
                for j in range(place.shape[1]):
                    along += place[0, j, c] * place[0, j, other]
                    along += place[1, j, c] * place[1, j, other]
                for j in range(place.shape[1]):
                    place[0, j, c] -= along * place[0, j, other]
                    place[1, j, c] -= along * place[1, j, other]
        size = 0.0
        for j in range(place.shape[1]):
            size = hypotenuse(size, hypotenuse(place[0, j, c], place[1, j, c]))
        for j in range(place.shape[1]):
            place[0, j, c] /= size
            place[1, j, c] /= size
        logs[c] = 0.0


@kernel
def copy_tangents(tangents: Floats, logs: Floats, space: TangentSpace) -> None:
    """Write perturbations and their logarithms into the space."""
    for c in range(logs.shape[0]):
        space.logs[c] = logs[c]
        for j in range(tangents.shape[1]):
            space.place[0, j, c] = tangents[0, j, c]
            space.place[1, j, c] = tangents[1, j, c]


@kernel
def carry_in_set(sets: Sets, b: int, s: float, space: TangentSpace) -> None:
    """Carry perturbations in a set over a time, (2, n, c) at first, then the modes' (n, 2, c)."""
    basis = basis_of(sets, b)
    to_modes(sets, b, space.place, space.columns)
    if s * sets.of_set[b, QUICKEST] <= LONGEST_PHASE:
        carry(basis, s, space.columns)
    else:
        carry_far(basis, s, space.columns, space.logs)


@kernel
def volume_rate(sets: Sets, b: int) -> float:
    """Return the rate at which volumes between neighbours shrink in a set, the trace of M^-1 C."""
    rate = 0.0
    for j in range(sets.modes.shape[1]):
        rate += sets.modes[b, j, DRAG]
    return rate


@kernel
def orthonormalise(place: Floats, logs: Floats, forgotten: float) -> None:
    """Make columns (2, n, c) orthonormal, and add the logarithms of what was left of each.

    A column of which no more than a part ``forgotten`` is left has grown by -inf, and stays zero.
    """
    n = place.shape[1]
    for c in range(place.shape[2]):
        before = 0.0
        for j in range(n):
            before = hypotenuse(before, hypotenuse(place[0, j, c], place[1, j, c]))
        # Twice: once leaves too much of the others where little is left.
        for _ in range(2):
            for other in range(c):
                along = 0.0
                for j in range(n):
                    along += place[0, j, c] * place[0, j, other]
                    along += place[1, j, c] * place[1, j, other]
                for j in range(n):
                    place[0, j, c] -= along * place[0, j, other]
                    place[1, j, c] -= along * place[1, j, other]
        size = 0.0
        for j in range(n):
            size = hypotenuse(size, hypotenuse(place[0, j, c], place[1, j, c]))
        is_left = size > forgotten * before and size > 0.0
        growth = -math.inf
        factor = 0.0
        if is_left:
            growth = logarithm(size)
            factor = 1.0 / size
        logs[c] += growth
        for j in range(n):
            place[0, j, c] *= factor
            place[1, j, c] *= factor
