"""Property 2 of the paper held against evidence: resonance on periodic impact times."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import partial

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.exact import pi_times
from percuss.model.forcing import Forcing, sine
from percuss.model.harmonics import Harmonic
from percuss.motion.eigenset_forms import SubsetMotion, subset_forcing
from percuss.motion.simulate import simulate
from percuss.paper.claims.evidence import WALL, condition, near
from percuss.paper.statement import Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "paper-harmonics.md"
# Gaps of periodic subsets of the eigenset in units of pi, at least one above 1.
PATTERNS = ((2,), (3,), (2, 1), (3, 1), (2, 2, 1), (5, 1, 1), (3, 2, 1), (4, 1))
# Of the second force below: small, so that many periods pass before the subset is left.
PUSH = Fraction(1, 100)


def _property_2() -> Finding:
    """Bound the velocity on subsets, and follow motions that grow on one until they leave it."""
    least = math.inf
    for seed, gaps in enumerate(PATTERNS * 10):
        least = min(least, _room(np.random.default_rng(seed), gaps))
    periods, allowed, kept, failed = _climb()
    off = max(abs(_sum_on_even_gap(m)) for m in range(2, 12, 2))
    gain = float(failed - kept)
    return Finding(
        (
            condition("80 random forces: V on a gap > pi is at most max|p| + max|p'|", least >= 0),
            near("even gaps, m = 2 to 10: V before + V after, difference of two motions", off),
            near("Y_3 with 0.01 sin 2t: velocity gained a period", gain, 8 / 3 * float(PUSH)),
            condition("it is left when V passes what the long flight allows", kept <= allowed),
            condition("and not before", failed > allowed),
        ),
        remark=f"A resonance can climb on the periodic subset Y_3 for a while: here for {periods} "
        "periods. It ends because a gap over pi holds a time at which A sin t < 0.",
    )


def _room(rng: np.random.Generator, gaps: tuple[int, ...]) -> float:
    """Return by how much a bound of V exceeds the largest V that a gap over pi allows.

    The force is a random sum of harmonics of the pattern's period whose particular solution p
    is zero at the pattern's times, so that every A keeps them as zeros.
    """
    period = math.pi * sum(gaps)
    orders = np.arange(0, 9)
    orders = orders[2 * orders != sum(gaps)]  # without the natural frequency
    waves = 2 * math.pi * orders / period
    times = math.pi * np.concatenate([[0], np.cumsum(gaps)[:-1]])
    coefficients = rng.normal(size=2 * len(waves))
    basis = _basis(times, waves)
    # The least of the vectors that the basis takes to the same: the rest is taken to zero.
    coefficients -= numerics.least_squares(basis, numerics.matmul(basis, coefficients), 1e-12)
    t = np.linspace(0.0, period, 4001)
    p = numerics.matmul(_basis(t, waves), coefficients)
    slopes = numerics.matmul(_basis(t + 1e-6, waves), coefficients) - numerics.matmul(
        _basis(t - 1e-6, waves), coefficients
    )
    bound = float(np.abs(p).max() + np.abs(slopes).max() / 2e-6)
    room = math.inf
    for start, gap in zip(times, gaps, strict=True):
        if gap > 1:
            s = np.linspace(1e-3, gap * math.pi - 1e-3, 2001)
            rise = numerics.matmul(_basis(start + s, waves), coefficients)
            down = numerics.sin(s) < -1e-3
            highest = float((rise[down] / -numerics.sin(s[down])).min())
            near_start = numerics.matmul(
                _basis(start + np.array([-1e-6, 1e-6]), waves), coefficients
            )
            room = min(room, bound - (highest + float(np.diff(near_start)[0]) / 2e-6))
    return room


def _basis(t: Floats, waves: Floats) -> Floats:
    return np.concatenate(
        [numerics.cos(np.outer(t, waves)), numerics.sin(np.outer(t, waves))], axis=1
    )


def _sum_on_even_gap(m: int) -> float:
    """Return by how much V0 + V(m pi) differs between two motions of the family, m even."""
    sums = []
    for part in (0.2, 0.7):
        v0 = part * 2 / (m + 1) * numerics.sin(math.pi / (m + 1))
        run = simulate(WALL, subset_forcing(m), v0=v0, max_impacts=1)
        sums.append(v0 + float(run.impacts.v_after[0]))
    return sums[1] - sums[0]


def _climb() -> tuple[int, float, float, float]:
    """Follow Y_3 under its force plus 0.01 sin 2t until the motion leaves it.

    sin 2t has the particular solution -sin(2t)/3, zero at all multiples of pi; on each of the
    two flights of a period, both odd, it adds 4/3 of its amplitude to the velocity.

    Returns
    -------
    tuple
        Periods kept, the velocity allowed by the contact condition of the long flight, and those
        with which the last long flight on Y_3 and the first off it began; NaN if it stays.
    """
    own = subset_forcing(3)
    push = Harmonic(PUSH, 2, pi_times(-1, 2))
    force = Forcing((*own.harmonics, push), own.constant, period=pi_times(4))
    run = simulate(WALL, force, v0="0.3", max_impacts=1000)
    off = np.flatnonzero(np.abs(run.impacts.t - SubsetMotion(3, 0).impact_times(1000)) > 1e-6)
    t = np.linspace(1.001 * math.pi, 1.999 * math.pi, 100_001)
    rise = (
        2 * numerics.sin(t / 4) * numerics.sin((t + math.pi) / 4)
        - float(PUSH) * numerics.sin(2 * t) / 3
    )
    slope = 0.5 * numerics.sin(0.25 * math.pi) - 2 * float(PUSH) / 3
    allowed = float((rise / -numerics.sin(t)).min()) + slope
    if not len(off):
        return 500, allowed, math.nan, math.nan
    # Long flights begin after every second impact.
    periods = int(off[0]) // 2
    kept, failed = (float(run.impacts.v_after[2 * k - 1]) for k in (periods - 1, periods))
    return periods, allowed, kept, failed


def _single_harmonics() -> Finding:
    """Look through frequencies and phases for single harmonics that keep the eigenset."""
    keeping, growing = [], []
    for omega in sorted({Fraction(p, q) for q in range(1, 7) for p in range(q, 9 * q)} - {1}):
        for twelfths in range(24):
            phase = twelfths * math.pi / 12
            k = np.arange(13)
            at_impacts = (-1.0) ** k * numerics.sin(
                np.asarray(float(omega) * math.pi * k + phase, dtype=np.float64)
            )
            if np.abs(at_impacts - at_impacts[0]).max() > 1e-9:
                continue
            keeping.append((omega, twelfths))
            gain = numerics.cos(phase) + numerics.cos(float(omega) * math.pi + phase)
            if gain > 1e-9:
                growing.append((omega, twelfths))
    odd = [(Fraction(n), j) for n in range(3, 9, 2) for j in range(24)]
    even = [(Fraction(n), j) for n in range(2, 9, 2) for j in (0, 12)]
    gains = simulate(WALL, sine(4), v0=0.0, max_impacts=10).impacts.v_after
    return Finding(
        (
            condition(
                "only odd n, and even n at phase 0 or pi, keep the eigenset",
                sorted(keeping) == sorted(odd + even),
            ),
            condition(
                "of these only even n at phase 0 grow",
                growing == [(Fraction(n), 0) for n in range(2, 9, 2)],
            ),
            near("n = 4, ten impacts from rest: velocity", float(gains[-1]), 10 * 8 / 15),
        ),
        remark="x'' + x = sin(w t + phase), w = p/q from 1 to 9, q up to 6, 24 phases.",
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="property2",
        reference="Property 2",
        claim="If impact times and force share a period and the impact velocity is unbounded, "
        "the impact times are the eigenset.",
        method="proof; bound of V under 80 random forces with several harmonics; simulation of "
        "a resonance on a subset",
        certainty="proof",
        proven=True,
        find=_property_2,
    ),
    _of(
        id="only-resonances",
        reference="section 4",
        claim="The only resonances of (17) on periodic impact times commensurate with the force "
        "are those of even n.",
        method="proof; all frequencies p/q from 1 to 9 with q up to 6, 24 phases each",
        certainty="proof",
        proven=True,
        find=_single_harmonics,
    ),
)
