"""The lines of periodic motions under sin 3t in ball arithmetic: exact Fourier coefficients."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cache

import numpy as np
from flint import acb, arb

from percuss.arrays import Floats
from percuss.certified import repeats_after
from percuss.certified.families import ReflectedMotion
from percuss.certified.numbers import ball, precision
from percuss.certified.system import system_of
from percuss.model.exact import as_fraction
from percuss.model.harmonic_forces import sine
from percuss.paper.claims.comparisons import WALL

# The motions have the period 4 pi: four half periods pi, each with an impact or more.
HALF_PERIODS = 4
BITS = 160
MOST_IMPACTS = 64
# Instants and velocities after the impacts of a period.
LineStates = tuple["tuple[arb, arb]", ...]


@cache
def _states(v0: str) -> LineStates | None:
    """Return the impacts from t = 0 to 4 pi, None where the motion is not proven to close there."""
    with precision(BITS):
        motion = ReflectedMotion(system_of(WALL, sine(3)), arb(0), ball(as_fraction(v0)))
        states: list[tuple[arb, arb]] = []
        while len(states) < MOST_IMPACTS:
            if motion.is_closed and motion.half_periods == HALF_PERIODS:
                break
            states.append((motion.t, motion.v))
            motion.fly()
    closes = repeats_after(WALL, sine(3), v0, len(states)).holds is True
    return tuple(states) if closes else None


@cache
def proven_lines(v0: str, count: int) -> tuple[arb, ...] | None:
    """Return balls of the amplitudes of x at 0, 1/2, 1, ..., count of them.

    On a flight x = y cos(t - t_k) + z sin(t - t_k) - sin(3t)/8 with y = sin(3 t_k)/8 and
    z = V_k + 3 cos(3 t_k)/8, whose integrals against exp(-i w t) are closed forms.

    Parameters
    ----------
    v0
        Velocity at the wall at t = 0.
    count
        How many.

    Returns
    -------
    tuple of arb or None
        None where the motion is not proven to have the period 4 pi. That at 0 is the mean, as in
        `percuss.line_spectrum`.
    """
    states = _states(v0)
    if states is None:
        return None

    with precision(BITS):
        period = HALF_PERIODS * arb.pi()
        pieces = []
        ends = [t for t, _ in states[1:]] + [states[0][0] + period]
        for (t, v), end in zip(states, ends, strict=True):
            y, z = (3 * t).sin() / 8, v + 3 * (3 * t).cos() / 8
            # x + sin(3t)/8 = Re (y - i z) exp(i (t - t_k)).
            pieces.append((t, end, acb(y, -z) * acb(0, -t).exp()))
        lines: list[arb] = []
        for k in range(count):
            total = sum((_integral(a, b, c, k) for a, b, c in pieces), acb(0))
            if k == 6:
                # Of -sin(3t)/8 itself.
                total = total - acb(0, -1) * period / 16
            lines.append(abs(total) / period if k == 0 else abs(2 * total / period))
    return tuple(lines)


def _integral(a: arb, b: arb, c: acb, k: int) -> acb:
    """Return the integral of Re(c exp(i t)) exp(-i t k/2) from a to b."""
    w = arb(k) / 2
    total = acb(0)
    for factor, rate in ((c, 1 - w), (c.conjugate(), -1 - w)):
        part = acb(b - a) if rate.is_zero() else _wave(rate, a, b)
        total = total + factor * part / 2
    return total


def _wave(rate: arb, a: arb, b: arb) -> acb:

    return (acb(0, rate * b).exp() - acb(0, rate * a).exp()) / acb(0, rate)


def jump_bound(v0: str) -> arb | None:
    """Return w^2 times what no line at high frequencies w exceeds, from the velocity's jumps."""
    states = _states(v0)
    if states is None:
        return None

    with precision(BITS):
        total = sum((2 * v for _, v in states), arb(0))
        return 2 * total / (HALF_PERIODS * arb.pi())


def power_law(lines: Sequence[arb], edges: Floats) -> arb | None:
    """Return the exponent of the highest line between each two edges, by least squares.

    None where the balls do not tell which line is the highest.
    """
    omega = 0.5 * np.arange(len(lines))
    x, y = [], []
    for low, high in itertools.pairwise(edges):
        inside = np.flatnonzero((omega >= low) & (omega < high)).tolist()
        best = max(inside, key=lambda k: float(lines[k]))
        if not all(k == best or lines[k] < lines[best] for k in inside):
            return None
        x.append(arb(float(omega[best])).log())
        y.append(lines[best].log())
    mean = sum(x, arb(0)) / len(x)
    above = sum(((a - mean) * b for a, b in zip(x, y, strict=True)), arb(0))
    return above / sum(((a - mean) * (a - mean) for a in x), arb(0))
