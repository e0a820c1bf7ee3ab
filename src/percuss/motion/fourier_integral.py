"""The Fourier integral of a run: the integral of x exp(-i w t) over a window, in closed form.

On a flight x'' + 2 a x' + K x = G + harmonics. Two integrations by parts turn the integral of
x exp(-i w t) into

    (K - w^2 + 2 i a w) X = F - [(v + (2 a + i w) x) exp(-i w t)] between the flight's ends,

with F that of the forces; that of a record is a sum over the pieces between its knots. Flights that
follow one another in the same region share F, so that only the jumps of the velocity remain. Where
the factor nearly vanishes its division would cost digits: there the closed form of the motion is
integrated by Gauss and Legendre's rule on panels of bounded phase, on which it is smooth. Neither
knows a sampling rate, so there is no aliasing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from percuss.arrays import Complexes, Flags, Floats, Integers
from percuss.kernels import record as columns
from percuss.kernels.flight import constant_force
from percuss.kernels.law_columns import (
    COSINE,
    DAMPING,
    FIRST_HARMONIC,
    LOWER,
    N_HARMONICS,
    N_KNOTS,
    NUMBER,
    OMEGA,
    QUICKEST,
    SINE,
    STIFFNESS,
    UPPER,
    Law,
)
from percuss.kernels.pieces import record_at
from percuss.model.system import region_rows
from percuss.motion.trajectory import Trajectory
from percuss.numerics import (
    cos,
    dot,
    gauss_points,
    modulus,
    panels,
    phasor,
    sin,
    times,
)

# Numbers, and the low parts of them.
SplitTimes: TypeAlias = tuple[Floats, Floats]


# A factor below this part of its own terms is not divided by.
NEAR_PART = 0.05
# Nodes a panel, and the phase of integrand and motion together that one covers, in radians: with
# p of them the rule is off by (p / 4)^32 / 32!, 1e-16 here.
NODES = 16
PANEL_PHASE = 8.0
# Frequencies and instants of one block of exponentials. Sums over more instants than this are sums
# of sums: in one go equal terms round alike, which cost 3e-12 over 300,000 of them.
ROWS, COLUMNS = 128, 512
# Below this half phase the mean of a ramp is its series: the closed form loses digits.
SHORT_HALF = 0.5
# Nodes of the quadrature in one go.
AT_ONCE = 1 << 17
# Splits a float into halves whose products are exact.
SPLITTER = 134217729.0


@dataclass(frozen=True, slots=True)
class Pieces:
    """Flights and contacts in order of time; their ends are counted from the window's start.

    Attributes
    ----------
    start, start_low, end, end_low
        (n,) arrays [time]: each instant is the sum of two floats.
    x0, v0, x1, v1
        (n,) arrays, the motion at the start and at the end.
    region
        (n,) array, row of the law that holds.
    in_contact
        (n,) bool array, true for contacts.
    """

    start: Floats
    start_low: Floats
    end: Floats
    end_low: Floats
    x0: Floats
    v0: Floats
    x1: Floats
    v1: Floats
    region: Integers
    in_contact: Flags


def fourier_integral(run: Trajectory, omega: Floats, low: float, high: float) -> Complexes:
    """Return the integral of x(t) exp(-i w (t - low)) over [low, high] for each w.

    Parameters
    ----------
    run
        The run.
    omega
        (n,) angular frequencies, of any sign [1/time].
    low, high
        The window [time], inside the run.

    Returns
    -------
    array
        (n,) complex numbers [length time].

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=3.141592653589793)
    >>> complex(fourier_integral(run, np.array([0.0]), 0.0, run.t_end)[0]).real
    2.0
    """
    law = run.system.law
    pieces = parts = _pieces_of(run, low, high)
    if law[0, N_KNOTS] > 0.0:
        parts = _pieces_of(run, low, high, cut_at_knots=True)
    forces = _constant_forces(law)
    total = _held(pieces, omega)
    for row in np.unique(pieces.region[~pieces.in_contact]):
        chosen = (pieces.region == row) & ~pieces.in_contact
        factor = law[row, STIFFNESS] - omega * omega + 2j * law[row, DAMPING] * omega
        is_near = modulus(factor) < NEAR_PART * _scale(law, row, pieces, chosen)
        by_parts = np.flatnonzero(~is_near)
        driven = _driving(law, pieces, chosen, omega[by_parts], low, forces[int(row)])
        ends = _ends(pieces, chosen, omega[by_parts], law[row, DAMPING])
        of_row = chosen
        if parts is not pieces:
            of_row = (parts.region == row) & ~parts.in_contact
            begins = parts.start[of_row], parts.start_low[of_row]
            until = parts.end[of_row], parts.end_low[of_row]
            driven = driven + record_integral(law, begins, until, omega[by_parts], low)
        total[by_parts] += (driven - ends) / factor[by_parts]
        total[is_near] += _panels(run, law, int(row), parts, of_row, omega[is_near], low)
    return total


def _pieces_of(run: Trajectory, low: float, high: float, *, cut_at_knots: bool = False) -> Pieces:
    """Cut the window [low, high] of a run at its events, and at the knots of a record."""
    law = run.system.law
    events, marks = run.record
    if not cut_at_knots and law[0, N_KNOTS] > 0.0:
        kept = marks[:, columns.KIND] != columns.KNOT
        kept[0] = True
        events, marks = events[kept], marks[kept]
    times = events[:, columns.EVENT_T]
    first = max(int(np.searchsorted(times, low, side="right")) - 1, 0)
    last = max(int(np.searchsorted(times, high, side="left")), first + 1)
    instants, lows = (
        times[first : last + 1].copy(),
        events[first : last + 1, columns.EVENT_T_LOW].copy(),
    )
    # The ends of the window are given as floats, and are no events unless they happen to be.
    if instants[0] < low:
        instants[0], lows[0] = low, 0.0
    instants, lows = np.append(instants[: last - first], high), np.append(lows[: last - first], 0.0)
    rest, rest_low = _difference(instants, low)
    rest_low += lows
    place = _places(run, law, marks)
    kind = marks[:, columns.KIND]
    # A mass that is held has no velocity; the column of a contact holds something else.
    moving = (kind != columns.CONTACT) & (kind != columns.RELEASE)
    before = np.where(moving, events[:, columns.V_BEFORE], 0.0)
    x0, v0 = place[first:last].copy(), events[first:last, columns.V_AFTER].copy()
    x1, v1 = np.append(place[first + 1 : last], 0.0), np.append(before[first + 1 : last], 0.0)
    if times[first] < low:
        x0[0], v0[0] = (float(value) for value in run(low))
    x1[-1], v1[-1] = (float(value) for value in run(high, limit="before"))
    region = marks[first:last, columns.NEXT_REGION].astype(np.int64)
    # What comes between the last listed hop of a chatter and its end is no higher than rounding.
    in_contact = kind[first:last] == columns.CONTACT
    in_contact[:-1] |= kind[first + 1 : last] == columns.CONTACT
    return Pieces(
        rest[:-1], rest_low[:-1], rest[1:], rest_low[1:], x0, v0, x1, v1, region, in_contact
    )


def _difference(instants: Floats, origin: float) -> tuple[Floats, Floats]:
    """Return instants - origin as the sums of two floats."""
    difference = instants - origin
    restored = instants - difference
    return difference, (instants - (difference + restored)) + (restored - origin)


def _places(run: Trajectory, law: Law, marks: Integers) -> Floats:
    """Return where each event happens."""
    rows = marks[:, columns.NEXT_REGION].astype(np.int64)
    is_lower = marks[:, columns.BOUND] == law[rows, NUMBER].astype(np.int64)
    place = np.where(is_lower, law[rows, LOWER], law[rows, UPPER])
    place[0] = run.x0
    return np.asarray(place, dtype=np.float64)


def _constant_forces(law: Law) -> dict[int, float]:
    """Return, for each region's row, the constant G of x'' + 2 a x' + K x = G + harmonics."""
    return {row: _constant(law, row) for row in region_rows(law)}


def _constant(law: Law, row: int) -> float:
    bounds = (law[row, LOWER], law[row, UPPER])
    at = min(max(0.0, bounds[0]), bounds[1])
    return float(constant_force(law, row, at) + law[row, STIFFNESS] * at)


def _scale(law: Law, row: int, pieces: Pieces, chosen: Flags) -> float:
    """Return the size of K - w^2 + 2 i a w below which the ends of a flight determine little."""
    shortest = float(np.median(pieces.end[chosen] - pieces.start[chosen]))
    return float(
        max(
            abs(law[row, STIFFNESS]),
            law[row, DAMPING] * law[row, DAMPING],
            1.0 / (shortest * shortest),
        )
    )


def _held(pieces: Pieces, omega: Floats) -> Complexes:
    """Return the part of the contacts, during which x does not change."""
    in_contact = pieces.in_contact
    start = (pieces.start[in_contact], pieces.start_low[in_contact])
    end = (pieces.end[in_contact], pieces.end_low[in_contact])
    held = pieces.x0[in_contact].astype(np.complex128)
    return integral_of_exponentials(start, end, omega, [(0.0, held)])


def _driving(
    law: Law,
    pieces: Pieces,
    chosen: Flags,
    omega: Floats,
    low: float,
    constant: float,
) -> Complexes:
    """Return the Fourier integral of the constant force and the harmonics over the flights."""
    start, end = _stretches(pieces, chosen)
    ones = np.ones(len(start[0]), dtype=np.complex128)
    parts = [(0.0, constant * ones)] if constant != 0.0 else []
    for j in range(int(law[0, N_HARMONICS]) - int(law[0, N_KNOTS] > 0.0)):
        row = law[FIRST_HARMONIC + j]
        # At the window's start the harmonic is Re(phasor).
        turn = complex(turned(np.array([row[OMEGA]]), np.array([low]), np.zeros(1))[0, 0])
        phasor = complex(row[COSINE], -row[SINE]) * turn.conjugate()
        parts.append((float(row[OMEGA]), 0.5 * phasor * ones))
        parts.append((-float(row[OMEGA]), 0.5 * phasor.conjugate() * ones))
    return integral_of_exponentials(start, end, omega, parts)


def _stretches(
    pieces: Pieces, chosen: Flags
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return the ends of what is left when flights that follow one another are joined."""
    edges = np.diff(np.concatenate([[0], chosen.astype(np.int8), [0]]))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    start = (pieces.start[first], pieces.start_low[first])
    return start, (pieces.end[last], pieces.end_low[last])


def integral_of_exponentials(
    start: SplitTimes,
    end: SplitTimes,
    omega: Floats,
    parts: Sequence[tuple[float, Complexes]],
) -> Complexes:
    """Return the integral of the sum of weight exp(i shift t) exp(-i w t) over the stretches.

    ``parts`` are pairs of a shift and one weight for each stretch.
    """
    total = np.zeros(len(omega), dtype=np.complex128)
    duration = (end[0] - start[0]) + (end[1] - start[1])
    # About the middle of a stretch the integral is real.
    middle = 0.5 * (start[0] + end[0])
    rest = 0.5 * ((start[0] - middle) + (end[0] - middle)) + 0.5 * (start[1] + end[1])
    rotated = [
        times(weights * duration, turned(np.array([-shift]), middle, rest)[0])
        for shift, weights in parts
    ]
    for block, some in blocks(len(omega), len(duration)):
        w = omega[block]
        turn = turned(w, middle[some], rest[some])
        for (shift, _), weights in zip(parts, rotated, strict=True):
            half = np.multiply.outer(w - shift, 0.5 * duration[some])
            # The sine of a half over it, which is 1 at zero.
            mean = np.divide(sin(half), half, out=np.ones_like(half), where=half != 0.0)
            total[block] += times(mean * turn, weights[some]).sum(axis=-1)
    return total


def record_integral(
    law: Law, begins: SplitTimes, ends: SplitTimes, omega: Floats, low: float
) -> Complexes:
    """Return the Fourier integral of the force of a record over parts that no knot cuts.

    Begins and ends are counted from ``low``, each with the low parts of its numbers.
    """
    (start, start_low), (end, end_low) = begins, ends
    duration = (end - start) + (end_low - start_low)
    middle = 0.5 * (start + end)
    rest = 0.5 * ((start - middle) + (end - middle)) + 0.5 * (start_low + end_low)
    instant = low + middle
    back = instant - low
    lost = (low - (instant - back)) + (middle - back) + rest
    ramps = np.array(list(map(partial(record_at, law), instant, lost))).reshape(-1, 2)
    forces, rises = ramps[:, 0] * duration, 0.5 * ramps[:, 1] * duration * duration
    total = np.zeros(len(omega), dtype=np.complex128)
    for block, some in blocks(len(omega), len(duration)):
        half = np.multiply.outer(omega[block], 0.5 * duration[some])
        mean = np.divide(sin(half), half, out=np.ones_like(half), where=half != 0.0)
        turn = turned(omega[block], middle[some], rest[some])
        weights = forces[some] * mean - 1j * (rises[some] * _first_bessel(half))
        total[block] += times(turn, weights).sum(axis=-1)
    return total


def _first_bessel(y: Floats) -> Floats:
    """Return (sin y - y cos y) / y^2, the spherical Bessel function of order 1."""
    square = y * y
    series = np.ones_like(y)
    for n in (6, 5, 4, 3, 2, 1):
        series = 1.0 - square * series / (2.0 * n * (2.0 * n + 3.0))
    is_short = np.abs(y) < SHORT_HALF
    safe = np.where(is_short, 1.0, square)
    return np.where(is_short, y * series / 3.0, (sin(y) - y * cos(y)) / safe)


def _ends(pieces: Pieces, chosen: Flags, omega: Floats, damping: float) -> Complexes:
    """Return what integration by parts leaves at the ends of the flights.

    Between two flights of the same region only the velocity may jump.
    """
    n = len(chosen)
    velocity, place = np.zeros(n + 1), np.zeros(n + 1)
    velocity[1:] += np.where(chosen, pieces.v1, 0.0)
    velocity[:-1] -= np.where(chosen, pieces.v0, 0.0)
    place[1:] += np.where(chosen, pieces.x1, 0.0)
    place[:-1] -= np.where(chosen, pieces.x0, 0.0)
    instants = np.append(pieces.start, pieces.end[-1])
    lows = np.append(pieces.start_low, pieces.end_low[-1])
    used = (velocity != 0.0) | (place != 0.0)
    instants, lows = instants[used], lows[used]
    weights = np.stack([velocity[used] + 2.0 * damping * place[used], place[used]], axis=1)
    total = np.zeros(len(omega), dtype=np.complex128)
    for block, some in blocks(len(omega), len(instants)):
        turn = turned(omega[block], instants[some], lows[some])
        first, second = ((turn * column).sum(axis=-1) for column in weights[some].T)
        total[block] += first + 1j * omega[block] * second
    return total


def _panels(
    run: Trajectory,
    law: Law,
    row: int,
    pieces: Pieces,
    chosen: Flags,
    omega: Floats,
    low: float,
) -> Complexes:
    """Return the integral over the flights of a region by Gauss and Legendre's rule."""
    total = np.zeros(len(omega), dtype=np.complex128)
    if len(omega) == 0:
        return total
    n = int(law[0, N_HARMONICS])
    harmonics = law[FIRST_HARMONIC : FIRST_HARMONIC + n, OMEGA]
    fastest = float(np.abs(omega).max() + max(law[row, QUICKEST], harmonics.max(initial=0.0)))
    start, end = pieces.start[chosen], pieces.end[chosen]
    counts = np.ceil((end - start) * fastest / PANEL_PHASE).astype(np.int64)
    counts = np.maximum(counts, 1)
    t, share = gauss_points(*panels(start, end, counts), NODES)
    values = share * run(np.clip(low + t, run.t0, run.t_end))[0]
    add_exponentials(total, values, t, omega, AT_ONCE)
    return total


def add_exponentials(
    total: Complexes, values: Floats, t: Floats, omega: Floats, at_once: int
) -> None:
    """Add the sum of values times exp(-i w t) for each frequency, so many values at once."""
    for i in range(0, len(t), at_once):
        some = slice(i, i + at_once)
        for k, w in enumerate(omega.tolist()):
            phase = w * t[some]
            total[k] += complex(dot(values[some], cos(phase)), -dot(values[some], sin(phase)))


def turned(omega: Floats, t: Floats, t_low: Floats) -> Complexes:
    """Return exp(-i w t), of shape (w, t); the product's rounding is made good."""
    phase = np.multiply.outer(omega, t)
    w_high, w_low = _halves(omega)
    t_high, t_rest = _halves(t)
    error = np.multiply.outer(w_high, t_high)
    error -= phase
    # The products that are left, and the low part of the instants.
    for w, rest in ((w_high, t_rest), (w_low, t_high + t_rest), (omega, t_low)):
        error += np.multiply.outer(w, rest)
    whole = phasor(phase)
    cosine, sine = whole.real, whole.imag
    turn = np.empty(phase.shape, dtype=np.complex128)
    np.multiply(error, sine, out=phase)
    np.subtract(cosine, phase, out=turn.real)
    np.multiply(error, cosine, out=error)
    error += sine
    np.negative(error, out=turn.imag)
    return turn


def _halves(values: Floats) -> tuple[Floats, Floats]:
    scaled = SPLITTER * values
    high = scaled - (scaled - values)
    return high, values - high


def blocks(n: int, width: int) -> Iterator[tuple[slice, slice]]:
    """Yield pieces of a table of n frequencies and so many instants."""
    for i in range(0, n, ROWS):
        for j in range(0, width, COLUMNS):
            yield slice(i, i + ROWS), slice(j, j + COLUMNS)
