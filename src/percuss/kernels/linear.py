"""Small dense matrices in plain loops: each machine gives the same bits, unlike LAPACK."""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.compile import formula, kernel

# Rows are at right angles when their product is below the first part of their sizes; rows
# below the second part of the whole are rounding, and at right angles to nothing.
ORTHOGONAL, ROUNDING = 2.0**-52, 2.0**-50
# Each sweep doubles the digits once it has some; ten are usual.
MOST_SWEEPS = 60


@kernel
def eliminate(matrix: Floats, right: Floats, weak: float) -> int:
    """Solve matrix x = right in place, x into ``right``; return 0 if the matrix is singular.

    It counts as singular where a pivot is at most ``weak`` of the largest entry, or NaN. Otherwise
    return the sign by which the determinant differs from the product of the pivots, which are left
    in the diagonal.
    """
    n = matrix.shape[0]
    sign = 1
    largest = 0.0
    for i in range(n):
        for k in range(n):
            largest = max(largest, abs(matrix[i, k]))
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not abs(matrix[pivot, k]) > weak * largest:
            return 0
        if pivot != k:
            sign = -sign
        for j in range(k, n):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        right[k], right[pivot] = right[pivot], right[k]
        for i in range(k + 1, n):
            ratio = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= ratio * matrix[k, j]
            right[i] -= ratio * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
    return sign


@formula
def rotation(first: float, second: float, off: float) -> tuple[float, float, float]:
    """Return cosine, sine and tangent of Jacobi's rotation, which makes a product zero.

    ``first`` and ``second`` are those of two directions with themselves, and ``off``, which is not
    zero, is that of the two.
    """
    slope = 0.5 * (second - first) / off
    tangent = 1.0 / (abs(slope) + math.sqrt(1.0 + slope * slope))
    if slope < 0.0:
        tangent = -tangent
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    return cosine, cosine * tangent, tangent


@formula
def turn_rows(rows: Floats, i: int, j: int, cosine: float, sine: float) -> None:
    """Turn two rows of a matrix by an angle."""
    for k in range(rows.shape[1]):
        a = rows[i, k]
        b = rows[j, k]
        rows[i, k] = cosine * a - sine * b
        rows[j, k] = sine * a + cosine * b


@kernel
def orthogonalise(rows: Floats, turned: Floats) -> bool:
    """Turn rows until they are at right angles, and those of ``turned`` with them.

    With the columns of a matrix A as rows and a unit matrix this is the singular value
    decomposition by Hestenes' one-sided Jacobi method: row j becomes size_j times the left
    singular vector, ``turned[j]`` the right one. Squares of the entries must be finite. Returns
    whether all are at right angles.
    """
    n = rows.shape[0]
    m = rows.shape[1]
    whole = 0.0
    for i in range(n):
        for k in range(m):
            whole += rows[i, k] * rows[i, k]
    least = ROUNDING * ROUNDING * whole
    # A sum of m products is known to m roundings.
    square = ORTHOGONAL * m
    for _ in range(MOST_SWEEPS):
        settled = True
        for i in range(n - 1):
            for j in range(i + 1, n):
                first = 0.0
                second = 0.0
                both = 0.0
                for k in range(m):
                    first += rows[i, k] * rows[i, k]
                    second += rows[j, k] * rows[j, k]
                    both += rows[i, k] * rows[j, k]
                if min(first, second) <= least:
                    continue
                if abs(both) <= square * math.sqrt(first) * math.sqrt(second):
                    continue
                settled = False
                cosine, sine, _ = rotation(first, second, both)
                turn_rows(rows, i, j, cosine, sine)
                turn_rows(turned, i, j, cosine, sine)
        if settled:
            return True
    return False
