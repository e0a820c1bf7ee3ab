"""Eigenvalues of small matrices in plain loops: each machine gives the same bits, unlike LAPACK."""

from __future__ import annotations

import math

from percuss.arrays import Complexes, Floats
from percuss.kernels.arithmetic import ULP
from percuss.kernels.compile import kernel
from percuss.kernels.linear import rotation, turn_rows

# Each sweep doubles the digits once it has some; ten are usual.
MOST_SWEEPS = 60
# Steps of the QR iteration for one eigenvalue; three are usual.
MOST_STEPS = 60
EXCEPTIONAL = 10


@kernel
def diagonalise(matrix: Floats, vectors: Floats) -> bool:
    """Turn a symmetric matrix to diagonal form by Jacobi's rotations, the rows of ``vectors`` too.

    Rows begin as a unit matrix and become the eigenvectors. An entry counts as zero below one unit
    of rounding of the geometric mean of its two diagonal entries, so that small eigenvalues of a
    positive matrix keep their relative digits. Returns whether all entries became zero.
    """
    n = matrix.shape[0]
    largest = 0.0
    for i in range(n):
        for k in range(n):
            largest = max(largest, abs(matrix[i, k]))
    least = ULP * ULP * largest
    for _ in range(MOST_SWEEPS):
        settled = True
        for i in range(n - 1):
            for k in range(i + 1, n):
                off = matrix[i, k]
                small = 0.5 * ULP * math.sqrt(abs(matrix[i, i])) * math.sqrt(abs(matrix[k, k]))
                if abs(off) <= max(small, least):
                    continue
                settled = False
                cosine, sine, tangent = rotation(matrix[i, i], matrix[k, k], off)
                matrix[i, i] -= tangent * off
                matrix[k, k] += tangent * off
                matrix[i, k] = 0.0
                matrix[k, i] = 0.0
                for j in range(n):
                    if j not in (i, k):
                        a = matrix[j, i]
                        b = matrix[j, k]
                        matrix[j, i] = cosine * a - sine * b
                        matrix[j, k] = sine * a + cosine * b
                        matrix[i, j] = matrix[j, i]
                        matrix[k, j] = matrix[j, k]
                turn_rows(vectors, i, k, cosine, sine)
        if settled:
            return True
    return False


@kernel
def square_root(z: complex) -> complex:
    """Return a square root of a complex number."""
    size = math.sqrt(z.real * z.real + z.imag * z.imag)
    if size == 0.0:
        return 0j
    real = math.sqrt(0.5 * (size + abs(z.real)))
    other = 0.5 * abs(z.imag) / real
    if z.real < 0.0:
        real, other = other, real
    return complex(real, other if z.imag >= 0.0 else -other)


@kernel
def size_of(z: complex) -> float:
    """Return the sum of the magnitudes of both parts."""
    return abs(z.real) + abs(z.imag)


@kernel
def eigenvalues(matrix: Complexes, values: Complexes) -> bool:
    """Write the eigenvalues of a matrix into ``values``; the matrix is lost.

    Reduction to Hessenberg form by elimination, then the QR iteration with Wilkinson's shift
    (Wilkinson & Reinsch 1971, II/13 and II/15). Returns whether it converged.
    """
    n = matrix.shape[0]
    for m in range(1, n - 1):
        pivot = m
        for i in range(m + 1, n):
            if size_of(matrix[i, m - 1]) > size_of(matrix[pivot, m - 1]):
                pivot = i
        if matrix[pivot, m - 1] == 0j:
            continue
        if pivot != m:
            for j in range(n):
                matrix[m, j], matrix[pivot, j] = matrix[pivot, j], matrix[m, j]
            for i in range(n):
                matrix[i, m], matrix[i, pivot] = matrix[i, pivot], matrix[i, m]
        for i in range(m + 1, n):
            ratio = matrix[i, m - 1] / matrix[m, m - 1]
            if ratio != 0j:
                for j in range(m - 1, n):
                    matrix[i, j] -= ratio * matrix[m, j]
                for j in range(n):
                    matrix[j, m] += ratio * matrix[j, i]
    high = n - 1
    steps = 0
    while high >= 0:
        low = high
        while low > 0:
            around = size_of(matrix[low, low]) + size_of(matrix[low - 1, low - 1])
            if size_of(matrix[low, low - 1]) <= ULP * around:
                matrix[low, low - 1] = 0j
                break
            low -= 1
        if low == high:
            values[high] = matrix[high, high]
            high -= 1
            steps = 0
            continue
        steps += 1
        if steps > MOST_STEPS:
            return False
        shift = matrix[high, high]
        if steps % EXCEPTIONAL == 0:
            shift += complex(size_of(matrix[high, high - 1]), 0.0)
        else:
            a = matrix[high - 1, high - 1]
            half = 0.5 * (a - shift)
            product = matrix[high - 1, high] * matrix[high, high - 1]
            root = square_root(half * half + product)
            if half.real * root.real + half.imag * root.imag < 0.0:
                root = -root
            if half + root != 0j:
                shift -= product / (half + root)
        qr_step(matrix, low, high, shift)
    return True


@kernel
def qr_step(matrix: Complexes, low: int, high: int, shift: complex) -> None:
    """Replace the block of a Hessenberg matrix by R Q + shift, of its QR decomposition less that."""
    for i in range(low, high + 1):
        matrix[i, i] -= shift
    # The rotation of two rows is applied to their columns once the next one is known.
    before_first = complex(1.0, 0.0)
    before_second = 0j
    for i in range(low, high):
        a = matrix[i, i]
        b = matrix[i + 1, i]
        whole = math.sqrt(a.real * a.real + a.imag * a.imag + b.real * b.real + b.imag * b.imag)
        first = a / whole if whole > 0.0 else complex(1.0, 0.0)
        second = b / whole if whole > 0.0 else 0j
        for j in range(i, high + 1):
            x = matrix[i, j]
            y = matrix[i + 1, j]
            matrix[i, j] = first.conjugate() * x + second.conjugate() * y
            matrix[i + 1, j] = first * y - second * x
        if i > low:
            turn_columns(matrix, low, i - 1, before_first, before_second)
        before_first = first
        before_second = second
    turn_columns(matrix, low, high - 1, before_first, before_second)
    for i in range(low, high + 1):
        matrix[i, i] += shift


@kernel
def turn_columns(matrix: Complexes, low: int, i: int, first: complex, second: complex) -> None:
    """Apply the conjugate of a rotation of rows i and i + 1 to the columns, down to its row."""
    for k in range(low, i + 2):
        x = matrix[k, i]
        y = matrix[k, i + 1]
        matrix[k, i] = x * first + y * second
        matrix[k, i + 1] = y * first.conjugate() - x * second.conjugate()
