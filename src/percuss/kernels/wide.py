"""Small dense matrices with twice the digits of a double, in plain loops.

An entry is the sum of two doubles, (high, low), the last axis of its array. What is subtracted on
the way from a stiff matrix to its slow modes is then still known to 16 digits.
"""

from __future__ import annotations

import math

from percuss.arrays import Floats
from percuss.kernels.arithmetic import Pair, plus, times, two_sum
from percuss.kernels.compile import formula, kernel

# Of 1: what a rotation leaves of an entry, by the rounding of its products.
WIDE_ULP = 2.0**-95
# After a rotation in doubles two sweeps are usual.
MOST_SWEEPS = 60


@formula
def entry(a: Floats, i: int, j: int) -> Pair:
    """Return one entry of a matrix."""
    return a[i, j, 0], a[i, j, 1]


@formula
def put(a: Floats, i: int, j: int, value: Pair) -> None:
    """Write one entry of a matrix."""
    a[i, j, 0] = value[0]
    a[i, j, 1] = value[1]


@kernel
def less(a: Pair, b: Pair, c: Pair) -> Pair:
    """Return a - b c."""
    product = times(b, c)
    return plus(a, (-product[0], -product[1]))


@kernel
def divided(a: Pair, b: Pair) -> Pair:
    """Return a / b, to a relative 2**-100."""
    first = a[0] / b[0]
    rest = less(a, (first, 0.0), b)
    second = rest[0] / b[0]
    rest = less(rest, (second, 0.0), b)
    total, error = two_sum(first, second)
    return two_sum(total, error + rest[0] / b[0])


@kernel
def root_of(a: Pair) -> Pair:
    """Return the square root of a pair, to a relative 2**-100."""
    if not a[0] > 0.0:
        return 0.0, 0.0
    first = math.sqrt(a[0])
    rest = less(a, (first, 0.0), (first, 0.0))
    return two_sum(first, rest[0] / (2.0 * first))


@kernel
def add_multiple(factor: Pair, a: Floats, out: Floats) -> None:
    """Add a multiple of some entries, (n, 2), to others."""
    for i in range(a.shape[0]):
        term = times(factor, (a[i, 0], a[i, 1]))
        total = plus((out[i, 0], out[i, 1]), term)
        out[i, 0] = total[0]
        out[i, 1] = total[1]


@kernel
def multiply(a: Floats, b: Floats, out: Floats) -> None:
    """Write the product of two matrices."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = (0.0, 0.0)
            for k in range(a.shape[1]):
                total = plus(total, times(entry(a, i, k), entry(b, k, j)))
            put(out, i, j, total)


@kernel
def factorise(matrix: Floats, lower: Floats) -> bool:
    """Write L of L L^T = matrix, which is symmetric; return whether it is positive definite."""
    n = matrix.shape[0]
    for k in range(n):
        for i in range(k, n):
            total = entry(matrix, i, k)
            for j in range(k):
                total = less(total, entry(lower, i, j), entry(lower, k, j))
            if i == k:
                if not total[0] > 0.0:
                    return False
                put(lower, k, k, root_of(total))
            else:
                put(lower, i, k, divided(total, entry(lower, k, k)))
    return True


@kernel
def solve(matrix: Floats, right: Floats) -> bool:
    """Solve matrix x = right (n, m) in place; return whether there is a solution."""
    n, m = matrix.shape[0], right.shape[1]
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k, 0]) > abs(matrix[pivot, k, 0]):
                pivot = i
        if not abs(matrix[pivot, k, 0]) > 0.0:
            return False
        for part in range(2):
            for j in range(k, n):
                kept = matrix[k, j, part]
                matrix[k, j, part] = matrix[pivot, j, part]
                matrix[pivot, j, part] = kept
            for j in range(m):
                kept = right[k, j, part]
                right[k, j, part] = right[pivot, j, part]
                right[pivot, j, part] = kept
        for i in range(k + 1, n):
            if matrix[i, k, 0] == 0.0:
                continue
            ratio = divided(entry(matrix, i, k), entry(matrix, k, k))
            for j in range(k + 1, n):
                put(matrix, i, j, less(entry(matrix, i, j), ratio, entry(matrix, k, j)))
            for j in range(m):
                put(right, i, j, less(entry(right, i, j), ratio, entry(right, k, j)))
    for k in range(n - 1, -1, -1):
        for j in range(m):
            total = entry(right, k, j)
            for i in range(k + 1, n):
                total = less(total, entry(matrix, k, i), entry(right, i, j))
            put(right, k, j, divided(total, entry(matrix, k, k)))
    return True


@formula
def rotate(
    a: Floats, first: tuple[int, int], other: tuple[int, int], turn: tuple[Pair, Pair]
) -> None:
    """Replace two entries (a, b) by (c a - s b, s a + c b)."""
    cosine, sine = turn
    one = entry(a, first[0], first[1])
    two = entry(a, other[0], other[1])
    put(a, first[0], first[1], less(times(cosine, one), sine, two))
    put(a, other[0], other[1], plus(times(sine, one), times(cosine, two)))


@kernel
def diagonalise(matrix: Floats, vectors: Floats) -> bool:
    """Turn a symmetric matrix to diagonal form by Jacobi's rotations, the rows of ``vectors`` too.

    As `percuss.kernels.eigenvalues.diagonalise`: small eigenvalues of a positive matrix keep their
    relative digits. Returns whether all entries became zero.
    """
    n = matrix.shape[0]
    largest = 0.0
    for i in range(n):
        for k in range(n):
            largest = max(largest, abs(matrix[i, k, 0]))
    least = WIDE_ULP * WIDE_ULP * largest
    for _ in range(MOST_SWEEPS):
        settled = True
        for i in range(n - 1):
            for k in range(i + 1, n):
                off = matrix[i, k, 0]
                a, b = matrix[i, i, 0], matrix[k, k, 0]
                small = WIDE_ULP * math.sqrt(abs(a)) * math.sqrt(abs(b))
                if abs(off) <= max(small, least):
                    continue
                settled = False
                between = (b - a) + (matrix[k, k, 1] - matrix[i, i, 1])
                slope = 0.5 * between / off
                tangent = 1.0 / (abs(slope) + math.sqrt(1.0 + slope * slope))
                if slope < 0.0:
                    tangent = -tangent
                # The tangent is a double, and the rotation is one to all digits.
                square = times((tangent, 0.0), (tangent, 0.0))
                cosine = divided((1.0, 0.0), root_of(plus((1.0, 0.0), square)))
                turn = (cosine, times(cosine, (tangent, 0.0)))
                for j in range(n):
                    rotate(matrix, (j, i), (j, k), turn)
                for j in range(n):
                    rotate(matrix, (i, j), (k, j), turn)
                    rotate(vectors, (i, j), (k, j), turn)
                for j in range(n):
                    put(matrix, j, i, entry(matrix, i, j))
                    put(matrix, j, k, entry(matrix, k, j))
        if settled:
            return True
    return False
