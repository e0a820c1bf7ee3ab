"""Linear algebra of small real matrices: sums in a fixed order, and finite entries only.

BLAS and LAPACK choose their order of summation by the processor, and an infinite or missing entry
makes them raise errors of their own, print warnings, or not return.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels import linear as kernels

# Squares of sizes with exponents in between neither overflow nor vanish.
MOST_DOUBLINGS = 400
# Rounds of balancing; a few are usual. What a power of two makes smaller by less is not worth one.
MOST_ROUNDS, WORTH = 100, 0.95
# The distance of 1 from the next double.
LAST_PLACE = 2.0**-52


def is_finite(*arrays: Floats) -> bool:
    """Return whether all entries of all arrays are finite numbers.

    Examples
    --------
    >>> is_finite(np.eye(2), np.array([np.inf]))
    False
    """
    # Searches ask this most often, and a generator takes twice as long.
    for array in arrays:  # noqa: SIM110
        if not np.isfinite(array).all():
            return False
    return True


def balanced(matrix: Floats) -> Floats:
    """Return a similar matrix whose rows and columns are of like size (Parlett and Reinsch 1969).

    Eigenvalues are found to a rounding of the largest entry, and of states that have displacements
    and velocities this depends on the unit of time. Powers of two change no digit.

    Examples
    --------
    >>> balanced(np.array([[0.5, 2.0**40], [2.0**-38, 0.5]]))
    array([[0.5, 2. ],
           [2. , 0.5]])
    """
    matrix = np.array(matrix, dtype=np.float64)
    if not is_finite(matrix):
        return matrix
    for _ in range(MOST_ROUNDS):
        settled = True
        for i in range(len(matrix)):
            sizes = np.abs(matrix)
            own = float(sizes[i, i])
            column, row = float(sizes[:, i].sum()) - own, float(sizes[i].sum()) - own
            if not (0.0 < column < math.inf and 0.0 < row < math.inf):
                continue
            factor = 2.0 ** round(0.5 * (math.frexp(row)[1] - math.frexp(column)[1]))
            if factor * column + row / factor < WORTH * (column + row):
                matrix[:, i] *= factor
                matrix[i] /= factor
                settled = False
        if settled:
            break
    return matrix


def dot(a: Floats, b: Floats) -> float:
    """Return the sum of the products of two vectors' entries; inf where it is beyond all floats.

    Examples
    --------
    >>> dot(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    11.0
    """
    with np.errstate(over="ignore"):
        return float((a * b).sum())


def norm(a: Floats) -> float:
    """Return the root of the sum of the squares of all entries, without overflow on the way.

    Examples
    --------
    >>> norm(np.array([3.0, 4.0]))
    5.0
    """
    largest = float(np.abs(a).max(initial=0.0))
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    doublings = math.frexp(largest)[1]
    if abs(doublings) < MOST_DOUBLINGS:
        return math.sqrt(float((a * a).sum()))
    b = np.ldexp(a, -doublings)
    return math.ldexp(math.sqrt(float((b * b).sum())), doublings)


def matmul(a: Floats, b: Floats) -> Floats:
    """Return the product of a matrix with a matrix or a vector, or of a vector with a matrix.

    Examples
    --------
    >>> matmul(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([1.0, 1.0]))
    array([3., 7.])
    """
    if b.ndim == 1:
        return np.asarray((a * b).sum(axis=-1))
    return np.asarray((a[..., :, None] * b).sum(axis=-2))


def solve_linear(matrix: Floats, right: Floats) -> Floats:
    """Solve a square system of linear equations.

    Parameters
    ----------
    matrix
        (n, n) array.
    right
        (n,) array, or (n, m) for m systems at once.

    Returns
    -------
    array
        Of the shape of ``right``.

    Raises
    ------
    ConvergenceError
        If the matrix is singular, or an entry no finite number.

    Examples
    --------
    >>> solve_linear(np.array([[2.0, 0.0], [0.0, 4.0]]), np.array([2.0, 2.0]))
    array([1. , 0.5])
    """
    _check(matrix, right)
    if right.ndim == 1:
        solution = np.array(right, np.float64)
        _eliminate(matrix, solution)
        return solution
    solutions = np.array(right.T, np.float64, order="C")
    for column in solutions:
        _eliminate(matrix, column)
    return np.ascontiguousarray(solutions.T)


def _eliminate(matrix: Floats, right: Floats) -> None:
    """Put the solution into the right side."""
    if not kernels.eliminate(np.array(matrix, np.float64, order="C"), right, 0.0):
        what = f"the {len(matrix)} linear equations are singular"
        raise ConvergenceError(what, None, math.nan, "move a little away from this point")


def inverse(matrix: Floats) -> Floats:
    """Return the inverse of a square matrix.

    Raises
    ------
    ConvergenceError
        If it is singular, or an entry no finite number.

    Examples
    --------
    >>> inverse(np.array([[2.0, 0.0], [0.0, 4.0]]))
    array([[0.5 , 0.  ],
           [0.  , 0.25]])
    """
    return solve_linear(matrix, np.eye(len(matrix)))


def cholesky(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the lower triangle L of L L^T = matrix, and its pivots.

    Parameters
    ----------
    matrix
        (n, n) array, symmetric and finite.

    Returns
    -------
    lower : array
        (n, n).
    pivots : array
        (n,), the squares of L's diagonal: what elimination leaves of each diagonal entry. If one is
        not above its own rounding, the matrix is not positive definite: the elimination ends there,
        and L and the pivots after it are NaN.

    Examples
    --------
    >>> cholesky(np.array([[4.0, 2.0], [2.0, 2.0]]))
    (array([[2., 0.],
           [1., 1.]]), array([4., 1.]))
    >>> cholesky(np.array([[1.0, 2.0], [2.0, 1.0]]))[1]
    array([ 1., -3.])
    """
    n = len(matrix)
    lower, pivots = np.zeros((n, n)), np.full(n, math.nan)
    for k in range(n):
        pivots[k] = matrix[k, k] - dot(lower[k, :k], lower[k, :k])
        if not pivots[k] > n * LAST_PLACE * abs(matrix[k, k]):
            lower[k:] = math.nan
            break
        lower[k, k] = math.sqrt(pivots[k])
        rest = matrix[k + 1 :, k] - (lower[k + 1 :, :k] * lower[k, :k]).sum(axis=1)
        lower[k + 1 :, k] = rest / lower[k, k]
    return lower, pivots


def determinant(matrix: Floats) -> float:
    """Return the determinant of a square matrix, NaN where an entry is no finite number.

    Examples
    --------
    >>> determinant(np.array([[1.0, 2.0], [3.0, 4.0]]))
    -2.0
    """
    if not is_finite(matrix):
        return math.nan
    if len(matrix) == 2:
        (a, b), (c, d) = matrix.tolist()
        return float(a * d - b * c)
    pivots = np.array(matrix, np.float64, order="C")
    sign = kernels.eliminate(pivots, np.zeros(len(pivots)), 0.0)
    return float(math.prod(np.diag(pivots).tolist(), start=sign))


def directions(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the singular values and their directions (the right singular vectors).

    Parameters
    ----------
    matrix
        (m, n) array.

    Returns
    -------
    sizes : array
        (n,), the largest first.
    directions : array
        (n, n), orthonormal rows; those of singular value zero span the null space.

    Raises
    ------
    ConvergenceError
        If an entry is no finite number.

    Examples
    --------
    >>> sizes, rows = directions(np.array([[0.0, 2.0], [0.0, 0.0]]))
    >>> sizes, rows[0]
    (array([2., 0.]), array([0., 1.]))
    """
    sizes, _, rows = _turned(matrix)
    return sizes, rows


def least_squares(matrix: Floats, right: Floats, weak: float) -> Floats:
    """Return the least-squares solution of linear equations that has the least norm.

    Parameters
    ----------
    matrix
        (m, n) array.
    right
        (m,) array.
    weak
        Singular values below this part of the largest count as zero.

    Returns
    -------
    array
        (n,).

    Raises
    ------
    ConvergenceError
        If an entry is no finite number.

    Examples
    --------
    >>> least_squares(np.array([[1.0, 1.0]]), np.array([2.0]), 1e-12)
    array([1., 1.])
    """
    _check(matrix, right)
    sizes, images, rows = _turned(matrix)
    solution = np.zeros(matrix.shape[1])
    for size, image, row in zip(sizes.tolist(), images, rows, strict=True):
        if size > weak * sizes[0]:
            # In two steps: the square of a size may lie beyond the doubles.
            solution += dot(image / size, right) / size * row
    return solution


def leverages(matrix: Floats, weak: float) -> Floats:
    """Return how much of each equation a least-squares solution takes for itself, 0 to 1.

    They are the diagonal of the projection on the columns, and their sum is the rank; a residual
    has one degree of freedom less its leverage.

    Parameters
    ----------
    matrix
        (m, n) array. Its columns may be of any size.
    weak
        Singular values below this part of the largest count as zero.

    Returns
    -------
    array
        (m,).

    Raises
    ------
    ConvergenceError
        If an entry is no finite number.

    Examples
    --------
    >>> leverages(np.array([[1.0], [2.0], [0.0]]), 1e-12)
    array([0.2, 0.8, 0. ])
    """
    _check(matrix)
    scales = np.sqrt(np.square(matrix).sum(axis=0))
    sizes, images, _ = _turned(matrix / np.where(scales > 0.0, scales, 1.0))
    shares = np.zeros(len(matrix))
    for size, image in zip(sizes.tolist(), images, strict=True):
        if size > weak * sizes[0]:
            shares += np.square(image / size)
    return shares


def fit_line(x: Floats, y: Floats) -> tuple[float, float]:
    """Return the slope of the least-squares line through points, and its standard error.

    Parameters
    ----------
    x, y
        (n,) arrays; the x are not all the same.

    Returns
    -------
    slope, error : float
        The error is NaN for fewer than three points.

    Examples
    --------
    >>> fit_line(np.array([0.0, 1.0, 2.0]), np.array([1.0, 3.0, 5.0]))
    (2.0, 0.0)
    """
    # About the mean of x, slope and level are independent.
    steps = x - x.mean()
    spread = dot(steps, steps)
    slope = dot(steps, y) / spread
    rest = y - y.mean() - slope * steps
    variance = dot(rest, rest) / (len(x) - 2) if len(x) > 2 else math.nan
    return slope, math.sqrt(variance / spread)


def _check(*arrays: Floats) -> None:
    if not is_finite(*arrays):
        what = "linear equations have entries that are no finite numbers"
        raise ConvergenceError(what, None, math.nan, "start nearer to the solution")


def _turned(matrix: Floats) -> tuple[Floats, Floats, Floats]:
    """Return singular values, images of the directions, and the directions themselves."""
    _check(matrix)
    n = matrix.shape[1]
    # Scaling by a power of two keeps squares in range, and all digits.
    doublings = math.frexp(float(np.abs(matrix).max(initial=0.0)))[1]
    images, rows = np.ldexp(np.ascontiguousarray(matrix.T), -doublings), np.eye(n)
    if not kernels.orthogonalise(images, rows):
        what = f"no singular values of a matrix of {matrix.shape} found"
        raise ConvergenceError(what, None, math.nan, "start nearer to the solution")
    sizes = np.sqrt((images * images).sum(axis=1))
    order = np.argsort(-sizes, kind="stable")
    return np.ldexp(sizes[order], doublings), np.ldexp(images[order], doublings), rows[order]
