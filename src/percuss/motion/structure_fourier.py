"""The Fourier integral of a structure's displacement over a window, in closed form.

Under one set of acting stops y = c . x is a constant and a sum over pairs of modes, y = sum of
p u + q w, with u' = w + b(t), w' = -k u - d w + g(t). Integration by parts over the pieces of the
window during which the set acts turns the integrals of u exp(-i w t) and w exp(-i w t) into

    (k - w^2 + i w d) U = G - E_w - (i w + d) (E_u - B),     W = i w U + E_u - B,

with B and G those of the inputs, and E_u, E_w the sums of the jumps at the ends of the pieces.
Where the factor nearly vanishes the mode is integrated by Gauss and Legendre's rule, as with one
mass (`percuss.motion.fourier_integral`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Complexes, Flags, Floats, Integers
from percuss.kernels.law_columns import FIRST_HARMONIC, OMEGA, QUICKEST
from percuss.kernels.record import CONTACT, EVENT_T, EVENT_T_LOW, KIND, NEXT_REGION
from percuss.kernels.structure import basis as at
from percuss.motion.fourier_integral import (
    NEAR_PART,
    NODES,
    PANEL_PHASE,
    SplitTimes,
    add_exponentials,
    blocks,
    integral_of_exponentials,
    record_integral,
    turned,
)
from percuss.motion.structure_observables import LinearForm, displacement_form, part_at
from percuss.motion.structures import StructureTrajectory
from percuss.numerics import (
    gauss_points,
    matmul,
    modulus,
    panels,
    times,
)

# Nodes of the quadrature in one go.
AT_ONCE = 1 << 17


@dataclass(frozen=True, slots=True)
class Stretches:
    """The pieces of a window between neighbouring events.

    Attributes
    ----------
    begins, ends
        Their instants, counted from the window's start [time], with the low parts.
    sets
        (k,) the set of each.
    first, last
        (k, n, 2) the modes at their begins and ends.
    in_tail
        (k,) whether it is the tail of a chatter.
    """

    begins: SplitTimes
    ends: SplitTimes
    sets: Integers
    first: Floats
    last: Floats
    in_tail: Flags


def structure_fourier_integral(
    run: StructureTrajectory, c: Floats, omega: Floats, low: float, high: float
) -> Complexes:
    """Return the integral of y(t) exp(-i w (t - low)) over [low, high] for each w, y = c . x.

    Parameters
    ----------
    run
        The run.
    c
        (n,) direction.
    omega
        (m,) angular frequencies, of any sign [1/time].
    low, high
        The window [time], inside the run.

    Returns
    -------
    array
        (m,) complex numbers [length time].

    Examples
    --------
    >>> import percuss as pc
    >>> pair = pc.impact_pair(masses=[1, 1], gap=1)
    >>> run = pc.simulate(pair, v0=[1, 0], t_end=4)
    >>> total = structure_fourier_integral(run, np.array([1.0, 0.0]), np.array([0.0]), 0.0, 4.0)
    >>> round(float(total[0].real), 12)
    4.0
    """
    record = run.record
    pieces = _pieces_of(run, low, high)
    total = np.zeros(len(omega), dtype=np.complex128)
    for b in np.unique(pieces.sets).tolist():
        total += _of_set(run, b, displacement_form(record.sets, b, c), pieces, omega, low)
    return total


def slowest_rate(run: StructureTrajectory) -> float:
    """Return the lowest frequency of the modes in the sets of a run [1/time], 0 without one."""
    springs = run.record.sets.modes[:, :, at.SPRING]
    return (
        math.sqrt(float(springs[springs > 0.0].min(initial=math.inf)))
        if (springs > 0.0).any()
        else 0.0
    )


def _pieces_of(run: StructureTrajectory, low: float, high: float) -> Stretches:
    record = run.record
    times_of, lows = record.events[:, EVENT_T], record.events[:, EVENT_T_LOW]
    # Of several events at one instant the last one begins a piece.
    rows = np.flatnonzero(np.append(np.diff(times_of) > 0.0, True))
    rows = rows[times_of[rows] < high]
    rows = rows[max(int(np.searchsorted(times_of[rows], low, side="right")) - 1, 0) :]
    edges, edge_lows = np.append(times_of[rows], high), np.append(lows[rows], 0.0)
    if edges[0] < low:
        edges[0], edge_lows[0] = low, 0.0
    x, v = run(edges[:-1], limit="after")
    x1, v1 = run(edges[1:], limit="before")
    sets = record.marks[rows, NEXT_REGION].astype(np.int64)
    following = np.minimum(rows + 1, len(times_of) - 1)
    # A wall that holds after a chatter holds during its tail, but for hops of the size of rounding.
    in_tail = (record.marks[following, KIND] == CONTACT) & (following > rows)
    ahead = record.marks[following, NEXT_REGION].astype(np.int64)
    in_tail &= sets != ahead
    sets = np.where(in_tail, ahead, sets)
    first, last = (_modes(record.sets, sets, *places) for places in ((x, v), (x1, v1)))
    rest = edges - low
    # What rounding takes of the difference.
    back = edges - rest
    rest_lows = (edges - (rest + back)) + (back - low) + edge_lows
    return Stretches(
        (rest[:-1], rest_lows[:-1]), (rest[1:], rest_lows[1:]), sets, first, last, in_tail
    )


def _modes(sets: at.Sets, of: Integers, x: Floats, v: Floats) -> Floats:
    """Return the modes (k, n, 2) of states in the sets ``of``."""
    inverse = sets.inverse[of].transpose(0, 3, 2, 1)
    states = np.concatenate([x - sets.offset[of], v], axis=1)
    return np.asarray((inverse * states[:, None, None, :]).sum(axis=-1))


def _of_set(
    run: StructureTrajectory,
    b: int,
    form: LinearForm,
    pieces: Stretches,
    omega: Floats,
    low: float,
) -> Complexes:
    """Return the part of the pieces of a set."""
    sets, chosen = run.record.sets, pieces.sets == b
    begins = pieces.begins[0][chosen], pieces.begins[1][chosen]
    ends = pieces.ends[0][chosen], pieces.ends[1][chosen]
    inputs = _inputs(run, b, (begins, ends), omega, low)
    total = np.asarray(form.constant * inputs[0], dtype=np.complex128)
    modes = np.flatnonzero((form.of_u != 0.0) | (form.of_w != 0.0))
    jumps = _jumps(pieces, chosen, modes, omega)
    shortest = float(np.median(ends[0] - begins[0]))
    for place, j in enumerate(modes.tolist()):
        p, q = float(form.of_u[j]), float(form.of_w[j])
        k, d = float(sets.modes[b, j, at.SPRING]), float(sets.modes[b, j, at.DRAG])
        factor = k - omega * omega + 1j * d * omega
        size = max(abs(k), 0.25 * d * d, 1.0 / (shortest * shortest))
        is_near = modulus(factor) < NEAR_PART * size
        far = np.flatnonzero(~is_near)
        w = omega[far]
        weights = _weights_of_inputs(sets, b, j)
        force, rate = ((column[:, None] * inputs[:, far]).sum(axis=0) for column in weights.T)
        of_u = jumps[2 * place][far] - rate
        drag = (1j * w + d).astype(np.complex128)
        u = (force - jumps[2 * place + 1][far] - times(drag, of_u)) / factor[far]
        total[far] += p * u + q * (1j * w * u + of_u)
        total[is_near] += _quadrature(run, b, (j, p, q), pieces, omega[is_near], low)
    return total


def _inputs(
    run: StructureTrajectory,
    b: int,
    spans: tuple[SplitTimes, SplitTimes],
    omega: Floats,
    low: float,
) -> Complexes:
    """Return the integrals of 1, of each harmonic's cosine and sine, and of each record."""
    sets = run.record.sets
    ones = np.ones(len(spans[0][0]), dtype=np.complex128)
    rows = [integral_of_exponentials(*spans, omega, [(0.0, ones)])]
    m = sets.turns.shape[2]
    for w in sets.law[b, FIRST_HARMONIC : FIRST_HARMONIC + m, OMEGA].tolist():
        # exp(i w t) of the absolute time, at the start of the window.
        turn = complex(turned(np.array([w]), np.array([low]), np.zeros(1))[0, 0]).conjugate()
        ahead = integral_of_exponentials(*spans, omega, [(w, turn * ones)])
        behind = integral_of_exponentials(*spans, omega, [(-w, turn.conjugate() * ones)])
        rows += [0.5 * (ahead + behind), -0.5j * (ahead - behind)]
    rows += [record_integral(law, *spans, omega, low) for law in sets.records]
    return np.array(rows)


def _weights_of_inputs(sets: at.Sets, b: int, j: int) -> Floats:
    """Return how much of each row of `_inputs` enters w' and u' of a mode, (rows, 2)."""
    mode, drive = sets.modes[b, j], sets.drive[b, j]
    rows = [(mode[at.FORCE], mode[at.RATE])]
    for harmonic in drive:
        rows.append((harmonic[at.FORCE_COS], harmonic[at.RATE_COS]))
        rows.append((harmonic[at.FORCE_SIN], harmonic[at.RATE_SIN]))
    rows += [tuple(row) for row in sets.record_drive[b, j]]
    return np.array(rows)


def _jumps(pieces: Stretches, chosen: Flags, modes: Integers, omega: Floats) -> Complexes:
    """Return E_u and E_w of each mode, rows of (2 modes, m)."""
    n = len(chosen)
    weights = np.zeros((n + 1, 2 * len(modes)))
    last, first = (part[:, modes].reshape(n, -1) for part in (pieces.last, pieces.first))
    weights[1:] += np.where(chosen[:, None], last, 0.0)
    weights[:-1] -= np.where(chosen[:, None], first, 0.0)
    instants = np.append(pieces.begins[0], pieces.ends[0][-1])
    lows = np.append(pieces.begins[1], pieces.ends[1][-1])
    used = (weights != 0.0).any(axis=1)
    instants, lows, weights = instants[used], lows[used], weights[used]
    total = np.zeros((2 * len(modes), len(omega)), dtype=np.complex128)
    for block, some in blocks(len(omega), len(instants)):
        turn = turned(omega[block], instants[some], lows[some])
        for row, column in enumerate(weights[some].T):
            total[row, block] += (turn * column).sum(axis=-1)
    return total


def _quadrature(
    run: StructureTrajectory,
    b: int,
    part: tuple[int, float, float],
    pieces: Stretches,
    omega: Floats,
    low: float,
) -> Complexes:
    """Return the integral of p u + q w of a mode over the pieces of a set by Gauss's rule."""
    total = np.zeros(len(omega), dtype=np.complex128)
    if len(omega) == 0:
        return total
    record, (j, p, q) = run.record, part
    sets, n = record.sets, record.sets.modes.shape[1]
    m = sets.turns.shape[2]
    harmonics = sets.law[b, FIRST_HARMONIC : FIRST_HARMONIC + m, OMEGA]
    row = FIRST_HARMONIC + m + j * (1 + m)
    rates = abs(float(sets.law[b, row, QUICKEST])), float(np.abs(harmonics).max(initial=0.0))
    fastest = float(np.abs(omega).max()) + max(*rates, math.sqrt(abs(sets.modes[b, j, at.SPRING])))
    of_u, of_w = np.zeros(n), np.zeros(n)
    of_u[j], of_w[j] = p, q
    nothing = np.zeros(len(sets.records))
    form = LinearForm(of_u, of_w, 0.0, np.zeros((m, 2)), nothing, nothing)
    for tail in (False, True):
        chosen = (pieces.sets == b) & (pieces.in_tail == tail)
        start, end = pieces.begins[0][chosen], pieces.ends[0][chosen]
        counts = np.maximum(np.ceil((end - start) * fastest / PANEL_PHASE), 1.0).astype(np.int64)
        t, factors = gauss_points(*panels(start, end, counts), NODES)
        if tail:
            # Too short to bend.
            parts = (t - np.repeat(np.repeat(start, counts), NODES)) / np.repeat(
                np.repeat(end - start, counts), NODES
            )
            a, z = (
                matmul(side[chosen][:, j], np.array([p, q])) for side in (pieces.first, pieces.last)
            )
            a, z = (np.repeat(np.repeat(side, counts), NODES) for side in (a, z))
            values = factors * (a + parts * (z - a))
        else:
            values = factors * part_at(record, b, form, np.clip(low + t, run.t0, run.t_end))
        add_exponentials(total, values, t, omega, max(1, AT_ONCE // max(1, len(omega))))
    return total
