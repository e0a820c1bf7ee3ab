"""Zeros of polynomials, and the nodes of Gauss's rule, without the eigenvalues of LAPACK."""

from __future__ import annotations

import math

import numpy as np

from percuss.arrays import Complexes, Floats, Integers, numbers_within
from percuss.errors import ConvergenceError
from percuss.numerics.functions import cos, phasor

# Simple zeros take some ten steps, double ones gain a bit a step down to half the digits.
MOST_STEPS = 500
# Steps as a part of the zeros below which they are rounding, and of double zeros too.
SETTLED = 1e-15
# Newton's steps to a node of Gauss's rule, from a guess of three digits.
NEWTON_STEPS = 6


def polynomial_roots(coefficients: Complexes) -> Complexes:
    """Return all zeros of a polynomial, by Aberth's and Ehrlich's simultaneous Newton steps.

    Parameters
    ----------
    coefficients
        (n + 1,) array, that of the highest power first.

    Returns
    -------
    array
        (n,), without those that zero coefficients at the front take to infinity.

    Raises
    ------
    ConvergenceError
        If a coefficient is no finite number.

    Examples
    --------
    >>> sorted(polynomial_roots(np.array([2.0, -6.0, 4.0])).real.round(12).tolist())
    [1.0, 2.0]
    """
    given = np.trim_zeros(np.asarray(coefficients, dtype=np.complex128), "f")
    if not np.isfinite(given).all():
        what = "a polynomial has coefficients that are no finite numbers"
        raise ConvergenceError(what, None, math.nan, "take smaller ones")
    at_zero = len(given) - len(np.trim_zeros(given, "b"))
    terms = [complex(value) for value in np.trim_zeros(given, "b")]
    n = len(terms) - 1
    if n < 1:
        return np.zeros(max(at_zero, 0), dtype=np.complex128)
    slopes = [term * (n - k) for k, term in enumerate(terms[:-1])]
    # On the circle of the mean size of all zeros, and not mirrored about the axes.
    size = math.sqrt(_square(terms[-1]) / _square(terms[0]))
    radius = math.ldexp(1.0, round(math.frexp(size)[1] / n)) if size > 0.0 else 1.0
    zeros = [radius * complex(z) for z in phasor(2.0 * math.pi * (np.arange(n) + 0.3) / n)]
    for _ in range(MOST_STEPS):
        largest = 0.0
        for k, z in enumerate(zeros):
            value, slope = _horner(terms, z), _horner(slopes, z)
            if value == 0.0:
                continue
            repulsion = sum((1.0 / (z - w) for w in zeros if w != z), 0.0j)
            below = slope - value * repulsion
            if below == 0.0:
                continue
            step = value / below
            zeros[k] = z - step
            largest = max(largest, _square(step) / (_square(z) or 1.0))
        if largest < SETTLED * SETTLED:
            break
    return np.array(zeros + [0.0j] * at_zero)


def _square(z: complex) -> float:
    return z.real * z.real + z.imag * z.imag


def _horner(terms: list[complex], z: complex) -> complex:
    value = 0.0j
    for term in terms:
        value = value * z + term
    return value


def gauss_legendre(n: int) -> tuple[Floats, Floats]:
    """Return the nodes and weights of Gauss's rule on [-1, 1].

    Parameters
    ----------
    n
        How many.

    Returns
    -------
    nodes, weights : array
        (n,) each, the nodes ascending.

    Examples
    --------
    >>> nodes, weights = gauss_legendre(2)
    >>> nodes.round(12), weights.round(12)
    (array([-0.57735027,  0.57735027]), array([1., 1.]))
    """
    x = -cos(math.pi * (np.arange(1.0, n + 1.0) - 0.25) / (n + 0.5))
    for _ in range(NEWTON_STEPS):
        value, slope = _legendre(n, x)
        x = x - value / slope
    # The middle one is zero, and the others are mirrored, to the last bit.
    x = 0.5 * (x - x[::-1])
    _, slope = _legendre(n, x)
    return x, 2.0 / ((1.0 - x * x) * slope * slope)


def panels(start: Floats, end: Floats, counts: Integers) -> tuple[Floats, Floats]:
    """Return left ends and widths of the equal parts of stretches, so many of each, maybe none."""
    width = np.repeat((end - start) / np.maximum(counts, 1), counts)
    return np.repeat(start, counts) + numbers_within(counts) * width, width


def gauss_points(left: Floats, width: Floats, n: int) -> tuple[Floats, Floats]:
    """Return the places and weights, (n_panels * n,), of Gauss's rule on each of some panels.

    Examples
    --------
    >>> x, weights = gauss_points(np.array([0.0, 1.0]), np.array([1.0, 1.0]), 3)
    >>> float((weights * x**5).sum().round(12))
    10.666666666667
    """
    nodes, weights = gauss_legendre(n)
    half = 0.5 * width[:, np.newaxis]
    points = left[:, np.newaxis] + half * (1.0 + nodes)
    return points.reshape(-1), (half * weights).reshape(-1)


def _legendre(n: int, x: Floats) -> tuple[Floats, Floats]:
    """Return the Legendre polynomial and its derivative."""
    before, current = np.ones_like(x), x
    for k in range(2, n + 1):
        before, current = current, ((2 * k - 1) * x * current - (k - 1) * before) / k
    return current, n * (before - x * current) / (1.0 - x * x)
