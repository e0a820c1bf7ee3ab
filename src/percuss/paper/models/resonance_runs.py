"""Ensembles of motions of the elastic impact oscillator, at one frequency of the force each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats, Integers
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.models.averaging import averaged

# How far from the growing phase motions start that approach it, or leave it [rad].
AWAY = 1e-3


# A motion grows if its largest speed does so by this factor in the last decade of impacts.
GROWS = 1.3


@dataclass(frozen=True)
class Ensemble:
    """Speeds of many motions after some numbers of impacts.

    Attributes
    ----------
    counts
        (n,) array, numbers of impacts, evenly spaced in their logarithm.
    largest
        (motions, n) array, the largest speed so far.
    typical
        (motions, n) array, the median speed of the last half of the impacts so far.
    """

    counts: Integers
    largest: Floats
    typical: Floats

    def late_growth(self) -> Floats:
        """Return by which factor the largest speed of each motion grew in the last decade."""
        decade = int(np.searchsorted(self.counts, self.counts[-1] // 10))
        return np.asarray(self.largest[:, -1] / self.largest[:, decade])

    def share_growing(self, factor: float = GROWS) -> float:
        """Return the share of motions whose largest speed grew by a factor in the last decade."""
        return float(np.mean(self.late_growth() > factor))

    def exponent(self, what: str, skip: int = 2) -> tuple[float, float]:
        """Return the power of the number of impacts with which speeds grow.

        It is the slope of the median over the motions in logarithms; its standard error comes
        from motions drawn anew, with replacement.

        Parameters
        ----------
        what
            "largest" or "typical".
        skip
            How many counts to leave out at the start.
        """
        speeds = numerics.log(self.largest if what == "largest" else self.typical)[:, skip:]
        steps = numerics.log(self.counts[skip:].astype(np.float64))
        generator = np.random.default_rng(0)
        motions = len(speeds)
        drawn = [_slope(steps, speeds[generator.integers(0, motions, motions)]) for _ in range(200)]
        return _slope(steps, speeds), float(np.std(drawn))


def _slope(steps: Floats, speeds: Floats) -> float:
    return numerics.fit_line(steps, np.median(speeds, axis=0))[0]


def starts(motions: int, slowest: float = 0.0, fastest: float = 2.0) -> list[tuple[float, float]]:
    """Return random phases of the force, and random speeds at the wall."""
    generator = np.random.default_rng(0)
    return [
        (generator.uniform(0.0, 2.0 * math.pi), generator.uniform(slowest, fastest))
        for _ in range(motions)
    ]


def first_run(
    omega: Fraction, impacts: int, slowest: float = 0.0, fastest: float = 2.0
) -> Trajectory:
    """Return the first motion of an `ensemble`, for so many impacts."""
    return run_of(omega, *starts(1, slowest, fastest)[0], impacts)


@cache
def ensemble(
    omega: Fraction, motions: int, impacts: int, slowest: float = 0.0, fastest: float = 2.0
) -> Ensemble:
    """Follow motions that start at the wall with random phases of the force and random speeds.

    Parameters
    ----------
    omega
        The frequency of the force, cos(omega t + phase).
    motions
        How many; the same numbers give the same ones.
    impacts
        How long to follow each.
    slowest, fastest
        Range of the speed at the start.

    Examples
    --------
    >>> ensemble(Fraction(2), 3, 1000).share_growing()
    1.0
    """
    # Four steps a power of ten.
    steps = 4 * (len(str(impacts // 100)) - 1) + 1
    counts = np.round(numerics.geometric(100, impacts, steps)).astype(np.int64)
    largest, typical = np.empty((2, motions, len(counts)))
    for row, (phase, speed) in enumerate(starts(motions, slowest, fastest)):
        speeds = run_of(omega, phase, speed, impacts).impacts.v_after
        largest[row] = np.maximum.accumulate(speeds)[counts - 1]
        typical[row] = [np.median(speeds[n // 2 : n]) for n in counts]
    return Ensemble(counts, largest, typical)


def energy_rates(motions: int = 16, impacts: int = 20_000) -> tuple[Floats, Floats]:
    """Return how fast V^2 grows under cos(t + phase), and the rate its last phase predicts.

    Parameters
    ----------
    motions
        How many, from random phases and speeds.
    impacts
        How long to follow each.

    Returns
    -------
    tuple of array
        (2, motions) slopes of V^2 over the second quarter and over the second half of each motion,
        and (motions,) values of |sin 2 psi| / 2 at its end.
    """
    generator = np.random.default_rng(1)
    slopes, predicted = [], []
    for _ in range(motions):
        phase = generator.uniform(0.0, 2.0 * math.pi)
        hits = run_of(Fraction(1), phase, generator.uniform(0.0, 2.0), impacts).impacts
        # Two flights are one cycle of what averaging leaves out.
        square = 0.5 * (hits.v_after[:-1] ** 2 + hits.v_after[1:] ** 2)
        ends = [impacts // 4, impacts // 2, len(square) - 1]
        slopes.append(np.diff(square[ends]) / np.diff(hits.t[ends]))
        predicted.append(0.5 * abs(numerics.sin(2.0 * (2.0 * math.pi * hits.cycle[-1] + phase))))
    return np.array(slopes).T, np.array(predicted)


def run_of(omega: Fraction, phase: float, speed: float, impacts: int) -> Trajectory:
    """Follow one motion from the wall under cos(omega t + phase)."""
    return simulate(impact_oscillator(), cosine(omega, phase=phase), v0=speed, max_impacts=impacts)


def growing_phase(omega: Fraction) -> float:
    """Return the phase of the force at an impact, from which V^q grows fastest [rad].

    It is where (-1)^p strength sin(q phase) is largest, at leading order in 1 / V.

    Examples
    --------
    >>> growing_phase(Fraction(2)) * 2 / math.pi
    -1.0
    """
    mean = averaged(omega)
    return math.copysign(0.5 * math.pi / mean.q, (-1) ** mean.p * mean.strength)


def run_near_growing(omega: Fraction, speed: float, from_phase: float, impacts: int) -> Trajectory:
    """Follow a motion from near the growing phase.

    Parameters
    ----------
    omega
        The frequency, 2 p / q.
    speed
        V at the start.
    from_phase
        How far from the growing phase it starts [rad].
    impacts
        How long to follow it.
    """
    return run_of(omega, growing_phase(omega) + from_phase, speed, impacts)


def growing_run(
    omega: Fraction, speed: float, from_phase: float, impacts: int
) -> tuple[Floats, Floats]:
    """Follow a motion from near the growing phase, looked at once every q flights.

    Parameters
    ----------
    omega, speed, from_phase, impacts
        As for `run_near_growing`.

    Returns
    -------
    tuple of array
        V, and how far from the growing phase the impact is, in (-pi / q, pi / q].
    """
    q = averaged(omega).q
    run = run_near_growing(omega, speed, from_phase, impacts)
    speeds = np.concatenate(([speed], run.impacts.v_after))[::q]
    turns = np.concatenate(([0.0], run.impacts.cycle))[::q]
    return speeds, offset(2.0 * math.pi * turns + from_phase, q)


def deviation_power(omega: Fraction, speed: float, impacts: int) -> float:
    """Return the power of V with which nearby motions leave the growing phase, or approach it.

    The averaged motion has q - 2: on a level of V^(2 - q) cos(q psi) the distance from the
    growing phase goes as V^(q - 2).

    Parameters
    ----------
    omega
        The frequency, 2 p / q.
    speed
        V at the start.
    impacts
        How long to follow them.

    Examples
    --------
    >>> round(deviation_power(Fraction(2), 50.0, 1000), 6)
    -1.0
    """
    behind, ahead = (growing_run(omega, speed, start, impacts) for start in (-AWAY, AWAY))
    apart, mean = np.abs(ahead[1] - behind[1]), 0.5 * (ahead[0] + behind[0])
    chosen = np.unique(numerics.geometric(10, len(mean) - 1, 24).astype(np.int64))
    return numerics.fit_line(numerics.log(mean[chosen]), numerics.log(apart[chosen]))[0]


def offset(angle: Floats, q: int) -> Floats:
    """Return angles modulo 2 pi / q, in [-pi / q, pi / q)."""
    part = 2.0 * math.pi / q
    return (angle + 0.5 * part) % part - 0.5 * part
