"""Damped modes of x'' + C x' + K x = 0 in real pairs, whatever the damping is."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from percuss.arrays import Complexes, Flags, Floats
from percuss.errors import ConvergenceError
from percuss.kernels import eigenvalues as kernels
from percuss.numerics.linear import inverse, matmul, solve_linear

__all__ = ["ModePairs", "mode_pairs", "symmetric_modes"]

# Below these many units of rounding of the largest entry a matrix counts as symmetric, a coupling
# of two modes by damping as none, and two eigenvalues as one.
ROUNDING = 2.0**-50
# Newton's steps that refine a pair; two are usual.
REFINEMENTS = 12
# A pair that is this much larger than what it is made of has lost so many digits to another pair.
MOST_CONDITION = 1e5
# Two real roots nearer than this part of their size take the mean of their shapes as a start.
NEAR = 1e-4
# Roots below this part of the damping are 0.
STILL = 1e-7
# k, d, of_u and of_w of a pair.
RealPair: TypeAlias = tuple[float, float, Floats, Floats]


class ModePairs(NamedTuple):
    """Pairs (u, w) with u' = w and w' = -k u - d w, and what they are to x and x'.

    Attributes
    ----------
    spring, drag
        (n,) arrays, k and d of each pair.
    of_u, of_w
        (n, n) arrays, columns: x = of_u u + of_w w.
    inverse
        (n, 2, 2 n) array: (u, w) of each pair from (x, x').
    """

    spring: Floats
    drag: Floats
    of_u: Floats
    of_w: Floats
    inverse: Floats


def symmetric_modes(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the eigenvalues of a symmetric matrix, upwards, and its eigenvectors as rows.

    Examples
    --------
    >>> values, rows = symmetric_modes(np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> values
    array([1., 3.])
    """
    work, rows = np.array(matrix, dtype=np.float64), np.eye(len(matrix))
    if not kernels.diagonalise(work, rows):
        raise ConvergenceError("no eigenvalues of a symmetric matrix found", None, math.nan, "")
    values = np.diag(work).copy()
    order = np.argsort(values, kind="stable")
    return values[order], rows[order]


def mode_pairs(stiffness: Floats, damping: Floats) -> ModePairs:
    """Return the modes of x'' + C x' + K x = 0 in real pairs.

    Where damping does not couple the modes of K these are real modes, each a pair of its own. What
    it couples falls apart into pairs of complex modes, or of real roots: a pair, and not a root, is
    what is refined, so that two equal roots (critical damping) lose no digits.

    Parameters
    ----------
    stiffness, damping
        (n, n) arrays, K and C of unit masses; neither need be symmetric.

    Raises
    ------
    ConvergenceError
        If two pairs coincide so nearly that their shapes lose more than five digits, or if free
        masses are coupled by their velocities so that two of them have a root 0 without a drift:
        no pair, whose double root drifts, has such roots.

    Examples
    --------
    >>> pairs = mode_pairs(np.diag([1.0, 4.0]), np.diag([0.1, 0.2]))
    >>> pairs.spring, pairs.drag
    (array([1., 4.]), array([0.1, 0.2]))
    """
    n = len(stiffness)
    if n == 0:
        nothing = np.zeros((0, 0))
        return ModePairs(np.zeros(0), np.zeros(0), nothing, nothing, np.zeros((0, 2, 0)))
    basis = np.eye(n)
    if _is_symmetric(stiffness):
        values, basis = symmetric_modes(0.5 * (stiffness + stiffness.T))
        if _is_symmetric(damping):
            basis = _turned(values, basis, damping)
        stiffness = np.diag(values)
    damping = matmul(matmul(basis, damping), basis.T)
    largest = max(float(np.abs(damping).max()), 0.0)
    size = math.sqrt(max(float(np.abs(stiffness).max()), 0.0))
    couples = (np.abs(damping) > ROUNDING * largest) & ~np.eye(n, dtype=bool)
    couples |= (np.abs(stiffness) > ROUNDING * size * size) & ~np.eye(n, dtype=bool)
    coupled = np.flatnonzero(couples.any(axis=0) | couples.any(axis=1))
    alone = np.setdiff1d(np.arange(n), coupled)
    spring, drag = np.zeros(n), np.zeros(n)
    of_u, of_w = np.zeros((n, n)), np.zeros((n, n))
    back = np.zeros((n, 2, 2 * n))
    # What rounding leaves of a free mass's spring would let it drift away, or oscillate.
    spring[alone] = _cleaned(np.diag(stiffness), size * size)[alone]
    drag[alone] = _cleaned(np.diag(damping), largest)[alone]
    of_u[alone, alone] = 1.0
    back[alone, 0, alone] = 1.0
    back[alone, 1, n + alone] = 1.0
    if len(coupled):
        some = np.ix_(coupled, coupled)
        pairs = _coupled_pairs(stiffness[some], damping[some])
        spring[coupled], drag[coupled] = pairs.spring, pairs.drag
        of_u[some], of_w[some] = pairs.of_u, pairs.of_w
        m = len(coupled)
        for part in range(2):
            rows = np.zeros((m, 2 * n))
            rows[:, coupled] = pairs.inverse[:, part, :m]
            rows[:, n + coupled] = pairs.inverse[:, part, m:]
            back[coupled, part] = rows
    turn = np.zeros((2 * n, 2 * n))
    turn[:n, :n], turn[n:, n:] = basis, basis
    whole = matmul(back.reshape(2 * n, 2 * n), turn).reshape(n, 2, 2 * n)
    return ModePairs(spring, drag, matmul(basis.T, of_u), matmul(basis.T, of_w), whole)


def _cleaned(values: Floats, size: float) -> Floats:
    return np.where(np.abs(values) <= ROUNDING * size, 0.0, values)


def _is_symmetric(matrix: Floats) -> bool:
    return bool((np.abs(matrix - matrix.T) <= ROUNDING * np.abs(matrix).max()).all())


def _turned(values: Floats, rows: Floats, damping: Floats) -> Floats:
    """Return the rows, turned among those of one eigenvalue so that damping does not couple them."""
    rows = rows.copy()
    size = max(float(np.abs(values).max()), 0.0)
    first = 0
    for last in range(1, len(values) + 1):
        if last == len(values) or values[last] - values[last - 1] > ROUNDING * size:
            if last - first > 1:
                some = rows[first:last]
                inside = matmul(matmul(some, damping), some.T)
                _, turns = symmetric_modes(0.5 * (inside + inside.T))
                rows[first:last] = matmul(turns, some)
            first = last
    return rows


def _coupled_pairs(stiffness: Floats, damping: Floats) -> ModePairs:
    n = len(stiffness)
    roots = _roots(stiffness, damping)
    pairs, roots = _free_pairs(stiffness, damping, roots)
    pairs += [_refined(stiffness, damping, *pair) for pair in _roots_in_pairs(roots)]
    spring, drag = (np.array([pair[i] for pair in pairs]) for i in (0, 1))
    of_u, of_w = (np.array([pair[i] for pair in pairs]).T for i in (2, 3))
    whole = np.zeros((2 * n, 2 * n))
    whole[:n, 0::2], whole[:n, 1::2] = of_u, of_w
    whole[n:, 0::2], whole[n:, 1::2] = -of_w * spring, of_u - of_w * drag
    back = inverse(whole)
    sizes = np.sqrt((whole * whole).sum(axis=0)) * np.sqrt((back * back).sum(axis=1))
    # Velocities and displacements differ in size by the rates: only what is much larger is lost.
    rates = np.sqrt(np.abs(spring)) + np.abs(drag)
    spread = float(rates.max() / max(float(rates.min()), 1e-300)) if n > 1 else 1.0
    if float(sizes.max()) > MOST_CONDITION * max(1.0, spread):
        what = "two pairs of complex modes coincide to five digits and more"
        raise ConvergenceError(what, None, float(sizes.max()), "change the damping a little")
    return ModePairs(spring, drag, of_u, of_w, back.reshape(n, 2, 2 * n))


def _free_pairs(
    stiffness: Floats, damping: Floats, roots: Complexes
) -> tuple[list[RealPair], Complexes]:
    """Return the pairs of several free masses with dashpots, and the roots of all others.

    Each may rest anywhere, a root 0, and what it has of speed decays, a real root. Of equal roots
    that are no double ones none makes a pair with another: a root 0 goes with one that decays.
    """
    largest = float(np.abs(stiffness).max())
    free = np.abs(np.diag(stiffness)) <= ROUNDING * largest
    is_diagonal = bool(
        (np.abs(stiffness - np.diag(np.diag(stiffness))) <= ROUNDING * largest).all()
    )
    if not is_diagonal or int(free.sum()) < 2:
        return [], roots
    order = np.argsort(np.abs(roots), kind="stable")
    count = int(free.sum())
    is_real = np.abs(roots.imag) <= 1e-7 * np.abs(roots.real)
    real = [j for j in order[count:].tolist() if is_real[j]][:count]
    if len(real) < count:
        return [], roots
    stiffness = np.where(free[:, None] | free[None, :], 0.0, stiffness)
    pairs: list[RealPair] = []
    for j in real:
        rate, shape = _real_mode(stiffness, damping, float(roots[j].real), free)
        rest = np.where(free, shape, 0.0)
        pairs.append((0.0, -rate, rest, (shape - rest) / rate))
    return pairs, np.delete(roots, [*order[:count].tolist(), *real])


def _real_mode(
    stiffness: Floats, damping: Floats, root: float, free: Flags
) -> tuple[float, Floats]:
    """Return a real root and its shape, whose largest entry of a free mass is 1."""
    n = len(stiffness)
    shape = _shape(stiffness, damping, complex(root)).real
    i = int(np.argmax(np.where(free, np.abs(shape), -1.0)))
    shape = shape / shape[i]
    for _ in range(REFINEMENTS):
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = root * root * np.eye(n) + root * damping + stiffness
        matrix[:n, n] = 2.0 * root * shape + matmul(damping, shape)
        matrix[n, i] = 1.0
        step = solve_linear(matrix, np.append(-matmul(matrix[:n, :n], shape), 0.0))
        shape, root = shape + step[:n], root + float(step[n])
        if float(np.abs(step[:n]).max()) < 1e-9 and abs(step[n]) < 1e-9 * abs(root):
            return root, shape
    what = "the decay of a free mass did not converge"
    raise ConvergenceError(what, None, float(np.abs(step).max()), "change the damping a little")


def _roots(stiffness: Floats, damping: Floats) -> Complexes:
    """Return the 2 n roots of det(s^2 + s C + K) = 0."""
    n = len(stiffness)
    # Velocities in units of their mode's rate: both halves of the matrix are then of one size.
    rates = np.sqrt(np.abs(np.diag(stiffness)))
    rates[rates == 0.0] = max(float(np.abs(damping).max()), float(rates.max()), 1e-300)
    matrix = np.zeros((2 * n, 2 * n), dtype=np.complex128)
    matrix[:n, n:] = np.diag(rates)
    matrix[n:, :n] = -stiffness / rates[:, None]
    matrix[n:, n:] = -damping * (rates[None, :] / rates[:, None])
    values = np.empty(2 * n, dtype=np.complex128)
    if not kernels.eigenvalues(matrix, values):
        raise ConvergenceError("no roots of a damped structure found", None, math.nan, "")
    return values


def _roots_in_pairs(roots: Complexes) -> list[tuple[complex, complex]]:
    """Return the roots in pairs: each with its conjugate, the real ones with their neighbours."""
    sizes = np.abs(roots.real) + np.abs(roots.imag)
    scale = float(sizes.max())
    above = sorted((z for z in roots.tolist() if z.imag > 0.0), key=lambda z: (z.imag, z.real))
    below = sorted((z for z in roots.tolist() if z.imag < 0.0), key=lambda z: (-z.imag, z.real))
    real = [z for z in roots.tolist() if z.imag == 0.0]
    pairs, left = [], []
    for z in above:
        partners = [b for b in below if abs(b.real - z.real) + abs(b.imag + z.imag) <= 1e-5 * scale]
        best = min(
            partners, key=lambda b: abs(b.real - z.real) + abs(b.imag + z.imag), default=None
        )
        if best is None or abs(z.imag) <= 1e-7 * (abs(z.real) + 1e-9 * scale):
            left.append(z)
            continue
        below.remove(best)
        mean = complex(0.5 * (z.real + best.real), 0.5 * (z.imag - best.imag))
        pairs.append((mean, mean.conjugate()))
    alone = sorted(z.real for z in [*real, *left, *below])
    return pairs + [(complex(a), complex(b)) for a, b in zip(alone[::2], alone[1::2], strict=True)]


def _refined(
    stiffness: Floats, damping: Floats, one: complex, other: complex
) -> tuple[float, float, Floats, Floats]:
    """Return (k, d, of_u, of_w) of the pair with two roots, by Newton's method."""
    n = len(stiffness)
    k, d = (one * other).real, -(one + other).real
    shapes = [_shape(stiffness, damping, root) for root in (one, other)]
    i = int(
        np.argmax([abs(a) * abs(b) for a, b in zip(*(s.tolist() for s in shapes), strict=True)])
    )
    shapes = [shape / shape[i] for shape in shapes]
    if abs(one - other) > NEAR * (abs(one) + abs(other)):
        of_w = ((shapes[0] - shapes[1]) / (one - other)).real
    else:
        of_w = np.zeros(n)
    of_u = (shapes[0] - one * of_w).real
    best = math.inf
    for _ in range(REFINEMENTS):
        try:
            step = _newton_step(stiffness, damping, i, (k, d, of_u, of_w))
        except ConvergenceError as error:
            if max(abs(one), abs(other)) > STILL * (float(np.abs(damping).max()) + abs(d)):
                raise
            what = "masses that are free, and coupled by their velocities, rest at any place"
            advice = "give each a weak spring to the ground; two roots 0 are no pair there"
            raise ConvergenceError(what, None, math.nan, advice) from error
        of_u, of_w = of_u + step[:n], of_w + step[n : 2 * n]
        k, d = k + float(step[2 * n]), d + float(step[2 * n + 1])
        rate = math.sqrt(abs(k)) + abs(d)
        size = float(np.abs(step[:n]).max()) + rate * float(np.abs(step[n : 2 * n]).max())
        size += abs(step[2 * n]) / (rate * rate) + abs(step[2 * n + 1]) / rate if rate > 0 else 0.0
        if not size < 0.5 * best:
            break
        best = size
    if not best < 1e-9:
        what = "a pair of modes did not converge"
        raise ConvergenceError(what, None, best, "change the damping a little")
    return k, d, of_u, of_w


def _shape(stiffness: Floats, damping: Floats, root: complex) -> Complexes:
    """Return the shape of the mode of a root, by inverse iteration."""
    n = len(stiffness)
    square = root * root
    real = stiffness + root.real * damping + square.real * np.eye(n)
    imaginary = root.imag * damping + square.imag * np.eye(n)
    # A root that is exact would leave nothing to divide by; that of a free mass, rows of zeros.
    matrix = np.block([[real, -imaginary], [imaginary, real]])
    sizes = np.abs(matrix).max(axis=1)
    largest = float(sizes.max()) or 1.0
    matrix += np.diag(np.where(sizes > 0.0, sizes, largest) * 2.0**-50)
    vector = np.ones(2 * n)
    for _ in range(3):
        vector = solve_linear(matrix, vector)
        vector = vector / np.abs(vector).max()
    return vector[:n] + 1j * vector[n:]


def _newton_step(
    stiffness: Floats, damping: Floats, i: int, pair: tuple[float, float, Floats, Floats]
) -> Floats:
    """Return the step (of_u, of_w, k, d) for which both parts of the pair obey the equation.

    With x = P u + Q w the velocity is P1 u + Q1 w, P1 = -k Q and Q1 = P - d Q, the acceleration
    -k Q1 u + (P1 - d Q1) w. The pair is fixed by P_i = 1, Q_i = 0.
    """
    k, d, p, q = pair
    n = len(p)
    unit = np.eye(n)
    p1, q1 = -k * q, p - d * q
    p2, q2 = -k * q1, p1 - d * q1
    rest = np.zeros(2 * n + 2)
    rest[:n] = p2 + matmul(damping, p1) + matmul(stiffness, p)
    rest[n : 2 * n] = q2 + matmul(damping, q1) + matmul(stiffness, q)
    rest[2 * n], rest[2 * n + 1] = p[i] - 1.0, q[i]
    slopes = np.zeros((2 * n + 2, 2 * n + 2))
    slopes[:n, :n] = -k * unit + stiffness
    slopes[:n, n : 2 * n] = k * d * unit - k * damping
    slopes[:n, 2 * n] = -q1 - matmul(damping, q)
    slopes[:n, 2 * n + 1] = k * q
    slopes[n : 2 * n, :n] = -d * unit + damping
    slopes[n : 2 * n, n : 2 * n] = (d * d - k) * unit - d * damping + stiffness
    slopes[n : 2 * n, 2 * n] = -q
    slopes[n : 2 * n, 2 * n + 1] = -q1 + d * q - matmul(damping, q)
    slopes[2 * n, i] = 1.0
    slopes[2 * n + 1, n + i] = 1.0
    return -solve_linear(slopes, rest)
