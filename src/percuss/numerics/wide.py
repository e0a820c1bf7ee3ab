"""Matrices with twice the digits of a double, each entry the sum of two."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError
from percuss.kernels import eigenvalues
from percuss.kernels import wide as kernels


class Wide:
    """A matrix of numbers (high, low), each the sum of two doubles: about 30 digits.

    Parameters
    ----------
    parts
        (n, m, 2) array.

    Examples
    --------
    >>> third = Wide.of([[Fraction(1, 3)]])
    >>> ((3.0 * third) - Wide.of([[1.0]])).rounded
    array([[0.]])
    """

    __slots__ = ("parts",)

    def __init__(self, parts: Floats) -> None:
        self.parts = parts

    @staticmethod
    def of(matrix: Floats | Iterable[Iterable[float | Fraction]]) -> Wide:
        """Return a matrix of doubles or fractions."""
        if isinstance(matrix, np.ndarray):
            return Wide(np.stack([matrix, np.zeros_like(matrix)], axis=-1))
        rows = [[_halves(number) for number in row] for row in matrix]
        return Wide(np.array(rows, dtype=np.float64).reshape(len(rows), -1, 2))

    @staticmethod
    def zeros(n: int, m: int) -> Wide:
        """Return a matrix of zeros."""
        return Wide(np.zeros((n, m, 2)))

    @staticmethod
    def unit(n: int) -> Wide:
        """Return a unit matrix."""
        return Wide.of(np.eye(n))

    @property
    def rounded(self) -> Floats:
        """The matrix in doubles, (n, m)."""
        return np.asarray(self.parts[..., 0])

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return self.parts.shape[0], self.parts.shape[1]

    @property
    def T(self) -> Wide:  # noqa: N802 - the name that all arrays give it
        """The matrix with its rows as columns."""
        return Wide(self.parts.transpose(1, 0, 2))

    def __len__(self) -> int:
        return len(self.parts)

    def __getitem__(self, which: Any) -> Wide:
        """Return some rows, or rows and columns by slices and `numpy.ix_`."""
        return Wide(self.parts[which])

    def __setitem__(self, which: Any, value: Wide) -> None:
        self.parts[which] = value.parts

    def __add__(self, other: Wide) -> Wide:
        return self._plus((1.0, 0.0), other)

    def __sub__(self, other: Wide) -> Wide:
        return self._plus((-1.0, 0.0), other)

    def __neg__(self) -> Wide:
        return Wide(-self.parts)

    def __mul__(self, other: Wide) -> Wide:
        """Return a multiple of another matrix; this one has one entry."""
        high, low = self.parts.reshape(2).tolist()
        return Wide(np.zeros(other.parts.shape))._plus((high, low), other)

    def __rmul__(self, factor: float) -> Wide:
        return Wide(np.zeros(self.parts.shape))._plus((factor, 0.0), self)

    def __matmul__(self, other: Wide) -> Wide:
        out = np.empty((len(self), other.shape[1], 2))
        # Copies: for arrays of another order, or not to be written to, kernels would be compiled
        # anew.
        kernels.multiply(np.array(self.parts, order="C"), np.array(other.parts, order="C"), out)
        return Wide(out)

    def _plus(self, factor: tuple[float, float], other: Wide) -> Wide:
        out = np.array(self.parts, order="C")
        added = np.array(other.parts, order="C")
        kernels.add_multiple(factor, added.reshape(-1, 2), out.reshape(-1, 2))
        return Wide(out)

    def columns_times(self, factors: Floats) -> Wide:
        """Return the matrix with each column multiplied by a double of (m,)."""
        return self @ Wide.of(np.diag(factors))

    def solve(self, right: Wide) -> Wide:
        """Return the solution of self x = right.

        Raises
        ------
        ConvergenceError
            If the matrix is singular.
        """
        solution = np.array(right.parts, order="C")
        if not kernels.solve(np.array(self.parts, order="C"), solution):
            what = f"the {len(self)} linear equations are singular"
            raise ConvergenceError(what, None, math.nan, "move a little away from this point")
        return Wide(solution)

    def inverse(self) -> Wide:
        """Return the inverse of a square matrix; errors as `solve`."""
        return self.solve(Wide.unit(len(self)))

    def cholesky(self) -> Wide:
        """Return the lower triangle L of L L^T = self, symmetric and positive definite.

        Raises
        ------
        ConvergenceError
            If it is not.
        """
        lower = np.zeros_like(self.parts)
        if not kernels.factorise(np.ascontiguousarray(self.parts), lower):
            raise ConvergenceError("a matrix is not positive definite", None, math.nan, "")
        return Wide(lower)

    def orthonormal(self) -> Wide:
        """Return rows that are orthonormal to all digits, from some that are to those of doubles."""
        rest = Wide.unit(len(self)) - self @ self.T
        return self + 0.5 * (rest @ self)

    def symmetric_modes(self) -> tuple[Wide, Wide]:
        """Return the eigenvalues of a symmetric matrix, upwards, (n, 1), and its eigenvectors as rows.

        Raises
        ------
        ConvergenceError
            If the rotations do not come to an end: an entry is no finite number.
        """
        n = len(self)
        work, rows = np.array(self.rounded), np.eye(n)
        if eigenvalues.diagonalise(work, rows):
            vectors = Wide.of(rows).orthonormal()
            turned = np.array((vectors @ self @ vectors.T).parts, order="C")
            if kernels.diagonalise(turned, vectors.parts):
                values = Wide(turned[np.arange(n), np.arange(n)].reshape(n, 1, 2))
                order = np.argsort(values.rounded[:, 0], kind="stable")
                return values[order], vectors[order]
        raise ConvergenceError("no eigenvalues of a symmetric matrix found", None, math.nan, "")


def _halves(number: float | Fraction) -> tuple[float, float]:
    high = float(number)
    low = float(Fraction(number) - Fraction(high)) if isinstance(number, Fraction) else 0.0
    return high, low
