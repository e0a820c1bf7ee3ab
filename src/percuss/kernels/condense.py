"""Least squares over a chain of segments: the nodes' states are eliminated one after the other.

The unknowns are the states of the nodes and the parameters; the equations are those of the samples
in each segment, and that its end is the next node. One segment at a time, reflections eliminate
its node's state, and what is left is carried to the next: the orthogonal decomposition of the
whole matrix, whose condition number is not squared as in normal equations (docs/theory/fitting.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.arrays import Flags, Floats, Integers
from percuss.kernels.compile import kernel

# Columns of a smaller norm belong to parameters without effect.
TINY = 1e-140


class Chain(NamedTuple):
    """Weighted equations of a chain of n segments, in n_p parameters and d numbers a node.

    ``rows`` (n_samples, n_p + d) and ``right`` (n_samples,) are those of the samples, the segment's
    node last; ``first`` (n + 1,) the number of its first one. ``end_rows`` (n, d, n_p + d) and
    ``defects`` (n, d) say by how much the end of a segment misses the next node, ``linked`` (n,)
    whether there is one; ``weights`` (n, d) are those of these equations, and ``anchors`` (d,)
    those of a node's state being left as it is.
    """

    rows: Floats
    right: Floats
    first: Integers
    end_rows: Floats
    defects: Floats
    linked: Flags
    weights: Floats
    anchors: Floats


@kernel
def reflect(matrix: Floats, n_rows: int, n_columns: int) -> None:
    """Make the first columns of the first rows upper triangular by Householder's reflections."""
    width = matrix.shape[1]
    for k in range(min(n_columns, n_rows)):
        largest = 0.0
        for i in range(k, n_rows):
            largest = max(largest, abs(matrix[i, k]))
        if largest < TINY:
            # Less than rounding of anything: its squares would vanish.
            for i in range(k, n_rows):
                matrix[i, k] = 0.0
            continue
        square = 0.0
        for i in range(k, n_rows):
            part = matrix[i, k] / largest
            square += part * part
        size = math.sqrt(square) * largest
        pivot = matrix[k, k]
        if pivot > 0.0:
            size = -size
        # The reflection by u = column - size e_k, with u.u = 2 size (size - pivot).
        first = pivot - size
        for j in range(k + 1, width):
            product = first * matrix[k, j]
            for i in range(k + 1, n_rows):
                product += matrix[i, k] * matrix[i, j]
            share = product / (size * first)
            matrix[k, j] += share * first
            for i in range(k + 1, n_rows):
                matrix[i, j] += share * matrix[i, k]
        matrix[k, k] = size
        for i in range(k + 1, n_rows):
            matrix[i, k] = 0.0


@kernel
def condense(chain: Chain, factors: Floats, carried: Floats, space: Floats) -> None:
    """Eliminate the nodes; leave what is left of the parameters in ``carried``.

    ``factors`` (n, d, 2 d + n_p + 1) receive the d equations of each node: its state, the next
    one's, the parameters, the right side. ``carried`` (d + n_p, d + n_p + 1) holds equations in the
    next node's state and the parameters, zeros at first; ``space`` has 2 d + n_p + 1 columns and
    rows for ``carried``, the samples of a segment, and 2 d more.
    """
    d = chain.defects.shape[1]
    n_p = carried.shape[1] - d - 1
    width = 2 * d + n_p + 1
    for k in range(chain.first.shape[0] - 1):
        n = 0
        if chain.linked[k]:
            for j in range(d):
                weight = chain.weights[k, j]
                row = space[n]
                for i in range(d):
                    row[i] = weight * chain.end_rows[k, j, n_p + i]
                    row[d + i] = 0.0
                row[d + j] = -weight
                for p in range(n_p):
                    row[2 * d + p] = weight * chain.end_rows[k, j, p]
                row[width - 1] = -weight * chain.defects[k, j]
                n += 1
        for i in range(carried.shape[0]):
            row = space[n]
            for j in range(d):
                row[j] = carried[i, j]
                row[d + j] = 0.0
            for p in range(n_p + 1):
                row[2 * d + p] = carried[i, d + p]
            n += 1
        for j in range(d):
            row = space[n]
            for i in range(width):
                row[i] = 0.0
            row[j] = chain.anchors[j]
            n += 1
        for i in range(chain.first[k], chain.first[k + 1]):
            row = space[n]
            for j in range(d):
                row[j] = chain.rows[i, n_p + j]
                row[d + j] = 0.0
            for p in range(n_p):
                row[2 * d + p] = chain.rows[i, p]
            row[width - 1] = chain.right[i]
            n += 1
        reflect(space, n, width - 1)
        for i in range(d):
            for j in range(width):
                factors[k, i, j] = space[i, j]
        for i in range(carried.shape[0]):
            for j in range(width - d):
                carried[i, j] = space[d + i, d + j] if d + i < n else 0.0


@kernel
def expand(factors: Floats, step: Floats, states: Floats) -> None:
    """Write the steps of the nodes' states (n, d) that belong to a step of the parameters."""
    n, d = states.shape
    n_p = step.shape[0]
    for back in range(n):
        k = n - 1 - back
        for back_row in range(d):
            i = d - 1 - back_row
            rest = factors[k, i, 2 * d + n_p]
            for p in range(n_p):
                rest -= factors[k, i, 2 * d + p] * step[p]
            if k + 1 < n:
                for j in range(d):
                    rest -= factors[k, i, d + j] * states[k + 1, j]
            for j in range(i + 1, d):
                rest -= factors[k, i, j] * states[k, j]
            pivot = factors[k, i, i]
            states[k, i] = rest / pivot if pivot != 0.0 else 0.0
