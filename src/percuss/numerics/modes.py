"""Damped modes of x'' + C x' + K x = 0 in real pairs, whatever the damping is.

All is computed with twice the digits of a double and rounded at the end: a slow mode of a stiff
structure is what is left of much larger numbers, and so are two modes whose frequencies nearly
coincide.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Complexes, Flags, Floats
from percuss.errors import ConvergenceError
from percuss.kernels import eigenvalues as kernels
from percuss.numerics.linear import matmul, solve_linear
from percuss.numerics.wide import Wide

# Below these many units of rounding of the entries they come from, two opposite entries count as
# equal, a coupling of two modes by damping as none, and a spring as that of a free mass.
ROUNDING = 2.0**-50
# What sums with twice the digits leave of the largest entry.
WIDE_ROUNDING = 2.0**-92
# Newton's steps that refine a pair; three are usual, more where two pairs nearly coincide.
REFINEMENTS = 40
# A last step of Newton's method this small is one: what it leaves is far below a double.
SETTLED = 1e-15
# A pair that is this much larger than what it is made of has lost so many digits to another pair.
MOST_CONDITION = 1e5
# Two real roots nearer than this part of their size take the mean of their shapes as a start.
NEAR = 1e-4
# Roots below this part of the damping are 0.
STILL = 1e-7


class RealPair(NamedTuple):
    """A pair: k and d, of one entry, and what it is to x, (n, 1)."""

    spring: Wide
    drag: Wide
    of_u: Wide
    of_w: Wide


class ModePairs(NamedTuple):
    """Pairs (u, w) with u' = w and w' = -k u - d w, and what they are to x and x'.

    Attributes
    ----------
    spring, drag
        (n,) arrays, k and d of each pair.
    of_u, of_w
        (n, n), columns: x = of_u u + of_w w.
    inverse
        (2 n, 2 n): u and w of each pair in turn, from (x, x').
    """

    spring: Floats
    drag: Floats
    of_u: Wide
    of_w: Wide
    inverse: Wide


def symmetric_modes(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the eigenvalues of a symmetric matrix, upwards, and its eigenvectors as rows.

    Examples
    --------
    >>> values, rows = symmetric_modes(np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> values
    array([1., 3.])
    """
    values, rows = Wide.of(matrix).symmetric_modes()
    return values.rounded[:, 0], rows.rounded


def entry_sizes(matrix: Floats) -> Floats:
    """Return sizes d (n,) of the coordinates for which no entry (i, j) is larger than d_i d_j.

    Examples
    --------
    >>> entry_sizes(np.array([[4.0, -2.0], [-2.0, 9.0]]))
    array([2., 3.])
    """
    sizes = np.sqrt(np.abs(np.diag(matrix)))
    if (np.abs(matrix) <= (1.0 + 1e-12) * sizes[:, None] * sizes).all():
        return np.asarray(sizes)
    both = np.maximum(np.abs(matrix).max(axis=0), np.abs(matrix).max(axis=1))
    return np.asarray(np.sqrt(both))


def mode_pairs(
    stiffness: Wide, damping: Wide, sizes: tuple[Floats, Floats] | None = None
) -> ModePairs:
    """Return the modes of x'' + C x' + K x = 0 in real pairs.

    Where damping does not couple the modes of K these are real modes, each a pair of its own. What
    it couples falls apart into pairs of complex modes, or of real roots: a pair, and not a root, is
    what is refined, so that two equal roots (critical damping) lose no digits.

    Parameters
    ----------
    stiffness, damping
        (n, n), K and C of unit masses; neither need be symmetric.
    sizes
        (n,) arrays d for K and C: an entry (i, j) is known to a rounding of d_i d_j only. By
        default those of their `entry_sizes`.

    Raises
    ------
    ConvergenceError
        If two pairs coincide so nearly that their shapes lose more than five digits, or if free
        masses are coupled by their velocities so that two of them have a root 0 without a drift:
        no pair, whose double root drifts, has such roots.

    Examples
    --------
    >>> pairs = mode_pairs(Wide.of(np.diag([1.0, 4.0])), Wide.of(np.diag([0.1, 0.2])))
    >>> pairs.spring, pairs.drag
    (array([1., 4.]), array([0.1, 0.2]))
    """
    n = len(stiffness)
    if n == 0:
        nothing = Wide.zeros(0, 0)
        return ModePairs(np.zeros(0), np.zeros(0), nothing, nothing, nothing)
    if sizes is None:
        sizes = entry_sizes(stiffness.rounded), entry_sizes(damping.rounded)
    basis = Wide.unit(n)
    if _is_symmetric(stiffness, sizes[0]):
        values, basis = (0.5 * (stiffness + stiffness.T)).symmetric_modes()
        if _is_symmetric(damping, sizes[1]):
            basis = _turned(values.rounded[:, 0], basis, damping, sizes[0])
        stiffness = Wide.zeros(n, n)
        stiffness[np.arange(n), np.arange(n)] = values[:, 0]
    damping = basis @ damping @ basis.T
    springs, drags = (
        _doubts(basis.rounded, size, matrix)
        for size, matrix in zip(sizes, (stiffness.rounded, damping.rounded), strict=True)
    )
    # What rounding leaves of a free mass's spring would let it drift away, or oscillate.
    stiffness = Wide(stiffness.parts * (np.abs(stiffness.rounded) > springs)[..., None])
    damping = Wide(damping.parts * (np.abs(damping.rounded) > drags)[..., None])
    couples = (stiffness.rounded != 0.0) | (damping.rounded != 0.0)
    couples &= ~np.eye(n, dtype=bool)
    coupled = np.flatnonzero(couples.any(axis=0) | couples.any(axis=1))
    alone = np.setdiff1d(np.arange(n), coupled)
    spring, drag = np.zeros(n), np.zeros(n)
    of_u, of_w, back = Wide.zeros(n, n), Wide.zeros(n, n), Wide.zeros(2 * n, 2 * n)
    spring[alone] = np.diag(stiffness.rounded)[alone]
    drag[alone] = np.diag(damping.rounded)[alone]
    of_u.parts[alone, alone, 0] = 1.0
    back.parts[2 * alone, alone, 0] = 1.0
    back.parts[2 * alone + 1, n + alone, 0] = 1.0
    if len(coupled):
        some = np.ix_(coupled, coupled)
        pairs = _coupled_pairs(stiffness[some], damping[some])
        spring[coupled], drag[coupled] = pairs.spring, pairs.drag
        of_u[some], of_w[some] = pairs.of_u, pairs.of_w
        both = (
            np.concatenate([2 * coupled, 2 * coupled + 1]),
            np.concatenate([coupled, n + coupled]),
        )
        m = len(coupled)
        order = np.concatenate([2 * np.arange(m), 2 * np.arange(m) + 1])
        back[np.ix_(*both)] = pairs.inverse[order]
    turn = Wide.zeros(2 * n, 2 * n)
    turn[:n, :n], turn[n:, n:] = basis, basis
    return ModePairs(spring, drag, basis.T @ of_u, basis.T @ of_w, back @ turn)


def _doubts(basis: Floats, sizes: Floats, matrix: Floats) -> Floats:
    """Return what the rounding of the entries, and that of their sums, may be in the modes."""
    ends = matmul(np.abs(basis), sizes)
    return np.asarray(ROUNDING * ends[:, None] * ends + WIDE_ROUNDING * np.abs(matrix).max())


def _is_symmetric(matrix: Wide, sizes: Floats) -> bool:
    differences = np.abs((matrix - matrix.T).rounded)
    return bool((differences <= ROUNDING * sizes[:, None] * sizes).all())


def _turned(values: Floats, rows: Wide, damping: Wide, sizes: Floats) -> Wide:
    """Return the rows, turned among those of one eigenvalue so that damping does not couple them.

    Two eigenvalues are one where the rounding of the entries may part them.
    """
    doubts = ROUNDING * matmul(np.abs(rows.rounded), sizes) ** 2
    rows = Wide(rows.parts.copy())
    first = 0
    for last in range(1, len(values) + 1):
        if (
            last == len(values)
            or values[last] - values[last - 1] > doubts[last - 1 : last + 1].max()
        ):
            if last - first > 1:
                some = rows[first:last]
                inside = some @ damping @ some.T
                _, turns = (0.5 * (inside + inside.T)).symmetric_modes()
                rows[first:last] = turns @ some
            first = last
    return rows


def _coupled_pairs(stiffness: Wide, damping: Wide) -> ModePairs:
    """Return the pairs of modes that damping couples, sought in a unit of time that suits them.

    Shapes of displacements and of velocities are compared with each other: they are of one size
    where the fastest mode turns about once in a unit. A power of two changes no digit.
    """
    fastest = math.sqrt(float(np.abs(stiffness.rounded).max()))
    fastest = max(fastest, float(np.abs(damping.rounded).max()))
    unit = 2.0 ** -math.frexp(fastest)[1]
    pairs = _pairs_in_unit_time(Wide(stiffness.parts * unit * unit), Wide(damping.parts * unit))
    # w is a velocity, and so is the second half of what the inverse takes.
    back = pairs.inverse.parts.copy()
    back[1::2] /= unit
    back[:, len(stiffness) :] *= unit
    return ModePairs(
        pairs.spring / unit / unit,
        pairs.drag / unit,
        pairs.of_u,
        Wide(pairs.of_w.parts * unit),
        Wide(back),
    )


def _pairs_in_unit_time(stiffness: Wide, damping: Wide) -> ModePairs:
    n = len(stiffness)
    roots = _roots(stiffness.rounded, damping.rounded)
    pairs, roots = _free_pairs(stiffness, damping, roots)
    for one, other in _roots_in_pairs(stiffness.rounded, damping.rounded, roots):
        pairs.append(_refined(stiffness, damping, one, other))
    spring, drag = (np.array([pair[i].rounded[0, 0] for pair in pairs]) for i in (0, 1))
    of_u, of_w = (Wide(np.concatenate([pair[i].parts for pair in pairs], axis=1)) for i in (2, 3))
    whole = Wide.zeros(2 * n, 2 * n)
    whole[:n, 0::2], whole[:n, 1::2] = of_u, of_w
    whole[n:, 0::2], whole[n:, 1::2] = (
        -of_w.columns_times(spring),
        of_u - of_w.columns_times(drag),
    )
    try:
        back = whole.inverse()
    except ConvergenceError as error:
        raise _defective(math.inf) from error
    there, here = whole.rounded, back.rounded
    lost = np.sqrt((there * there).sum(axis=0)) * np.sqrt((here * here).sum(axis=1))
    # Velocities and displacements differ in size by the rates: only what is much larger is lost.
    rates = np.sqrt(np.abs(spring)) + np.abs(drag)
    spread = float(rates.max() / max(float(rates.min()), 1e-300)) if n > 1 else 1.0
    if not float(lost.max()) <= MOST_CONDITION * max(1.0, spread):
        what = "two pairs of modes coincide to five digits and more, and so do their shapes"
        advice = "change the stiffness or the damping a little"
        raise ConvergenceError(what, None, float(lost.max()), advice)
    return ModePairs(spring, drag, of_u, of_w, back)


def _defective(size: float) -> ConvergenceError:
    what = "two pairs of modes coincide in one shape"
    return ConvergenceError(what, None, size, "change the stiffness or the damping a little")


def _no_pair(one: complex, other: complex, damping: Wide, size: float) -> ConvergenceError:
    """Return why two roots make no pair."""
    scale = float(np.abs(damping.rounded).max()) + abs(one + other)
    if min(abs(one), abs(other)) > STILL * scale:
        return _defective(size)
    what = "masses that are free, and coupled by their velocities, rest at any place"
    advice = "give each a weak spring to the ground; two roots 0 are no pair there"
    return ConvergenceError(what, None, size, advice)


def _free_pairs(
    stiffness: Wide, damping: Wide, roots: Complexes
) -> tuple[list[RealPair], Complexes]:
    """Return the pairs of several free masses with dashpots, and the roots of all others.

    Each may rest anywhere, a root 0, and what it has of speed decays, a real root. Of equal roots
    that are no double ones none makes a pair with another: a root 0 goes with one that decays.
    """
    rounded = stiffness.rounded
    free = np.diag(rounded) == 0.0
    if np.count_nonzero(rounded) + int(free.sum()) > len(free) or int(free.sum()) < 2:
        return [], roots
    order = np.argsort(np.abs(roots), kind="stable")
    count = int(free.sum())
    is_real = np.abs(roots.imag) <= 1e-7 * np.abs(roots.real)
    real = [j for j in order[count:].tolist() if is_real[j]][:count]
    if len(real) < count:
        return [], roots
    nothing = Wide.zeros(1, 1)
    pairs: list[RealPair] = []
    for j in real:
        try:
            rate, shape = _real_mode(stiffness, damping, float(roots[j].real), free)
        except ConvergenceError:
            # It is a root 0 like the others.
            return [], roots
        rest = Wide(shape.parts * free[:, None, None])
        pairs.append(RealPair(nothing, -rate, rest, rate.inverse() * (shape - rest)))
    return pairs, np.delete(roots, [*order[:count].tolist(), *real])


def _real_mode(stiffness: Wide, damping: Wide, root: float, which: Flags) -> tuple[Wide, Wide]:
    """Return a real root and its shape, whose largest entry of some masses is 1."""
    n = len(stiffness)
    start = _shape(stiffness.rounded, damping.rounded, complex(root)).real
    i = int(np.argmax(np.where(which, np.abs(start), -1.0)))
    shape, rate = Wide.of((start / start[i])[:, None]), Wide.of(np.array([[root]]))
    best = math.inf
    for _ in range(REFINEMENTS):
        here, at = shape.rounded[:, 0], float(rate.rounded[0, 0])
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = at * at * np.eye(n) + at * damping.rounded + stiffness.rounded
        matrix[:n, n] = 2.0 * at * here + matmul(damping.rounded, here)
        matrix[n, i] = 1.0
        rest = rate * (rate * shape) + rate * (damping @ shape) + stiffness @ shape
        step = solve_linear(matrix, np.append(-rest.rounded[:, 0], 0.0))
        shape, rate = shape + Wide.of(step[:n, None]), rate + Wide.of(step[n:, None])
        size = max(float(np.abs(step[:n]).max()), abs(float(step[n])) / max(abs(at), 1e-300))
        if size <= SETTLED:
            return rate, shape
        if not size < 0.5 * best:
            break
        best = size
    what = "the decay of a real mode did not converge"
    raise ConvergenceError(what, None, size, "change the damping a little")


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


def _roots_in_pairs(
    stiffness: Floats, damping: Floats, roots: Complexes
) -> list[tuple[complex, complex]]:
    """Return the roots in pairs: each with its conjugate, the real ones with those of like shape.

    The two real roots of an overdamped mode are far apart, and those of many modes side by side:
    their shapes tell which belong together.
    """
    sizes = np.abs(roots.real) + np.abs(roots.imag)
    scale = float(sizes.max(initial=0.0))
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
    return pairs + _real_pairs(stiffness, damping, alone)


def _real_pairs(
    stiffness: Floats, damping: Floats, roots: list[float]
) -> list[tuple[complex, complex]]:
    """Return real roots in pairs of the most parallel shapes."""
    if len(roots) <= 2:
        return [(complex(a), complex(b)) for a, b in zip(roots[::2], roots[1::2], strict=True)]
    shapes = [_shape(stiffness, damping, complex(root)).real for root in roots]
    units = np.array([shape / math.sqrt(float((shape * shape).sum())) for shape in shapes])
    # Of equally parallel ones, as all are where two masses move, neighbours.
    likeness = np.round(np.abs(matmul(units, units.T)), 6)
    pairs = []
    left = list(range(len(roots)))
    while left:
        choices = [(likeness[a, b], a - b, -a, b) for a in left for b in left if a < b]
        _, _, minus_a, b = max(choices)
        pairs.append((complex(roots[-minus_a]), complex(roots[b])))
        left = [j for j in left if j not in (-minus_a, b)]
    return pairs


def _refined(stiffness: Wide, damping: Wide, one: complex, other: complex) -> RealPair:
    """Return the pair with two roots, by Newton's method."""
    try:
        return _refined_pair(stiffness, damping, one, other)
    except ConvergenceError as error:
        if one.imag != 0.0 or abs(one - other) <= NEAR * (abs(one) + abs(other)):
            raise
        failure = error
    # Two real roots of shapes that have little in common: each is refined alone.
    some = np.ones(len(stiffness), dtype=bool)
    try:
        first, shape = _real_mode(stiffness, damping, one.real, some)
        second, other_shape = _real_mode(stiffness, damping, other.real, some)
    except ConvergenceError:
        raise failure from None
    of_w = (first - second).inverse() * (shape - other_shape)
    return RealPair(first @ second, -(first + second), shape - first * of_w, of_w)


def _refined_pair(stiffness: Wide, damping: Wide, one: complex, other: complex) -> RealPair:
    n = len(stiffness)
    k, d = (one * other).real, -(one + other).real
    rounded = stiffness.rounded, damping.rounded
    shapes = [_shape(*rounded, root) for root in (one, other)]
    i = int(
        np.argmax([abs(a) * abs(b) for a, b in zip(*(s.tolist() for s in shapes), strict=True)])
    )
    shapes = [shape / shape[i] for shape in shapes]
    if abs(one - other) > NEAR * (abs(one) + abs(other)):
        of_w = ((shapes[0] - shapes[1]) / (one - other)).real
    else:
        of_w = np.zeros(n)
    of_u = (shapes[0] - one * of_w).real
    pair = RealPair(*(Wide.of(np.array(value).reshape(-1, 1)) for value in (k, d, of_u, of_w)))
    best = math.inf
    for _ in range(REFINEMENTS):
        try:
            step = _newton_step(stiffness, damping, i, pair)
        except ConvergenceError as error:
            raise _no_pair(one, other, damping, math.inf) from error
        parts = step[2 * n], step[2 * n + 1], step[:n], step[n : 2 * n]
        pair = RealPair(*(a + Wide.of(b.reshape(-1, 1)) for a, b in zip(pair, parts, strict=True)))
        rate = math.sqrt(abs(float(pair.spring.rounded[0, 0]))) + abs(
            float(pair.drag.rounded[0, 0])
        )
        size = float(np.abs(step[:n]).max()) + rate * float(np.abs(step[n : 2 * n]).max())
        size += abs(step[2 * n]) / (rate * rate) + abs(step[2 * n + 1]) / rate if rate > 0 else 0.0
        if size <= SETTLED * SETTLED or not size < 0.5 * best:
            best = min(best, size)
            break
        best = size
    if not best < SETTLED:
        raise _no_pair(one, other, damping, best)
    return pair


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
    sizes = np.where(sizes > 0.0, sizes, largest)
    for part in (2.0**-50, 3.0 * 2.0**-50):
        vector = np.ones(2 * n)
        try:
            for _ in range(3):
                vector = solve_linear(matrix + np.diag(part * sizes), vector)
                vector = vector / np.abs(vector).max()
        except ConvergenceError:
            # What was added has met the rounding of the root.
            continue
        return vector[:n] + 1j * vector[n:]
    raise ConvergenceError(
        "no shape of a mode found", None, math.nan, "change the damping a little"
    )


def _newton_step(stiffness: Wide, damping: Wide, i: int, pair: RealPair) -> Floats:
    """Return the step (of_u, of_w, k, d) for which both parts of the pair obey the equation.

    With x = P u + Q w the velocity is P1 u + Q1 w, P1 = -k Q and Q1 = P - d Q, the acceleration
    -k Q1 u + (P1 - d Q1) w. The pair is fixed by P_i = 1, Q_i = 0. What is left of the equation has
    twice the digits; its slopes need few.
    """
    n = len(stiffness)
    rest = np.zeros(2 * n + 2)
    of_u, of_w = _misses(stiffness, damping, pair)
    rest[:n], rest[n : 2 * n] = of_u.rounded[:, 0], of_w.rounded[:, 0]
    (k, d), (p, q) = (
        [part.rounded[0, 0] for part in pair[:2]],
        [part.rounded[:, 0] for part in pair[2:]],
    )
    rest[2 * n], rest[2 * n + 1] = p[i] - 1.0, q[i]
    stiff, damped, unit = stiffness.rounded, damping.rounded, np.eye(n)
    q1 = p - d * q
    slopes = np.zeros((2 * n + 2, 2 * n + 2))
    slopes[:n, :n] = -k * unit + stiff
    slopes[:n, n : 2 * n] = k * d * unit - k * damped
    slopes[:n, 2 * n] = -q1 - matmul(damped, q)
    slopes[:n, 2 * n + 1] = k * q
    slopes[n : 2 * n, :n] = -d * unit + damped
    slopes[n : 2 * n, n : 2 * n] = (d * d - k) * unit - d * damped + stiff
    slopes[n : 2 * n, 2 * n] = -q
    slopes[n : 2 * n, 2 * n + 1] = -q1 + d * q - matmul(damped, q)
    slopes[2 * n, i] = 1.0
    slopes[2 * n + 1, n + i] = 1.0
    return -solve_linear(slopes, rest)


def _misses(stiffness: Wide, damping: Wide, pair: RealPair) -> tuple[Wide, Wide]:
    """Return by how much the parts of a pair of u and of w miss the equation, (n, 1) each."""
    k, d, p, q = pair
    p1, q1 = -(k * q), p - d * q
    p2, q2 = -(k * q1), p1 - d * q1
    return p2 + damping @ p1 + stiffness @ p, q2 + damping @ q1 + stiffness @ q
