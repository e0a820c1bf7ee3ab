"""Resonance with losses: closed forms of the peaks, and speeds over the frequency of the force.

docs/theory/resonances.md, section 4, derives the forms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from percuss import numerics
from percuss.arrays import Floats
from percuss.ensembles.sweep import sweep
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import Oscillator, bilinear_oscillator, impact_oscillator
from percuss.orbits.bifurcations.continue_orbit import continue_orbit
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.paper.models.averaging import averaged, kick
from percuss.paper.models.resonance_runs import growing_phase


@cache
def lossy(restitution: str | float, damping: str | float) -> Oscillator:
    """Return the impact oscillator with its wall at the equilibrium, and losses."""
    return impact_oscillator(restitution=restitution, damping=damping)


@cache
def stiff(stiffness_below: float, damping: float) -> Oscillator:
    """Return the bilinear oscillator with damping on both sides."""
    return bilinear_oscillator(stiffness_below=stiffness_below, damping=damping)


def lost_share(restitution: float, damping: float) -> float:
    """Return the share of its speed that the free motion loses from impact to impact.

    Examples
    --------
    >>> round(lost_share(0.8, 0.0), 12)
    0.2
    """
    return 1.0 - restitution * numerics.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))


def gain(n: int) -> float:
    """Return what the force cos nt with even n adds to the speed in a flight: (19) of the paper.

    Examples
    --------
    >>> gain(2)
    1.3333333333333333
    """
    return 2.0 * n / (n * n - 1.0)


def single_impact_speed(omega: ArrayLike, turns: int, restitution: float, damping: float) -> Floats:
    """Return the speed into the wall of the motion with one impact in some periods of the force.

    Parameters
    ----------
    omega
        (n,) array, the frequency of the force, of amplitude 1.
    turns
        Periods of the force between impacts.
    restitution, damping
        The losses, not both absent at resonance; damping < 1.

    Returns
    -------
    (n,) array
        The speed before the impact [length/time].

    Examples
    --------
    With r = 0.8 the peak at omega = 2 has the speed (4/3)/(1 - r):

    >>> float(single_impact_speed(2.0, 1, 0.8, 0.0).round(12))
    6.666666666667
    """
    w = np.asarray(omega, dtype=np.float64)
    natural = math.sqrt(1.0 - damping**2)
    flight = 2.0 * math.pi * turns / w
    decay = numerics.exp(-damping * flight)
    c, s = numerics.cos(natural * flight), numerics.sin(natural * flight) / natural
    # The response to the force has the displacement X and the velocity Y at the impact; per unit
    # of the speed they solve two linear equations.
    a11, a12 = -(1.0 - decay * (c + damping * s)), decay * s
    a21, a22 = decay * s, 1.0 - decay * (c - damping * s)
    b1, b2 = restitution * decay * s, -(1.0 + restitution * decay * (c - damping * s))
    determinant = a11 * a22 - a12 * a21
    x, y = (b1 * a22 - a12 * b2) / determinant, (a11 * b2 - a21 * b1) / determinant
    response = 1.0 / np.abs(1.0 - w**2 + 2j * damping * w)
    return np.asarray(response / numerics.hypot(x, y / w))


def saddle_speed(omega: Fraction, lost: float) -> float:
    """Return the speed at which gain and loss balance for omega = 2p/q, at leading order.

    Parameters
    ----------
    omega
        The frequency 2p/q.
    lost
        The share of the speed lost from impact to impact.

    Examples
    --------
    >>> round(saddle_speed(Fraction(2), 0.1), 3), round(gain(2) / 0.1, 3)
    (13.333, 13.333)
    """
    mean = averaged(omega)
    return float((2.0 * math.pi * mean.p * abs(mean.strength) / lost) ** (1.0 / mean.q))


def peak_orbit(omega: Fraction, restitution: float) -> PeriodicOrbit:
    """Return the periodic orbit of omega = 2p/q on which gain and loss balance.

    Parameters
    ----------
    omega
        The frequency.
    restitution
        The only loss.

    Raises
    ------
    ParameterError
        If none is found.

    Examples
    --------
    >>> peak_orbit(Fraction(2, 3), 0.99).stability
    'unstable'
    """
    mean = averaged(omega)
    speed = saddle_speed(omega, 1.0 - restitution)
    cycle = growing_phase(omega) / (2.0 * math.pi) % 1.0
    osc, force = lossy(restitution, 0.0), cosine(omega)
    # The phase is the growing one at leading order only, and for q = 2 it is not even that.
    for shift in np.arange(0, 48) / 48.0 / mean.q * mean.p:
        try:
            guess = (cycle + shift) % 1.0, restitution * speed
            orbit = find_orbit(osc, force, mean.q, mean.p, guess=guess, formal=True)
        except ConvergenceError:
            continue
        if orbit.admissible and np.abs(orbit.impacts.v_before).max() > 0.7 * speed:
            return orbit
    raise ParameterError("omega", str(omega), f"no orbit near the speed {speed:.4g} is found")


def stiff_resonance(stiffness_below: float) -> float:
    """Return the resonant frequency (2) of the paper, for stiffness 1 above.

    Examples
    --------
    >>> stiff_resonance(4.0) * 3.0
    4.0
    """
    root = math.sqrt(stiffness_below)
    return 2.0 * root / (1.0 + root)


def cycle_work(stiffness_below: float, m: int) -> float:
    """Return the work of cos(m W_r t), at its best phase, on a free cycle of entry speed 1.

    Parameters
    ----------
    stiffness_below
        Stiffness below 0, > 1; above it is 1.
    m
        Which multiple of the resonant frequency W_r.

    Returns
    -------
    float
        Work per unit mass and unit speed [length].

    Examples
    --------
    It tends to that of the impact oscillator:

    >>> round(cycle_work(1e12, 1), 4), round(gain(2), 4)
    (1.3333, 1.3333)
    """
    root = math.sqrt(stiffness_below)
    above = m * stiff_resonance(stiffness_below)
    # Each half cycle has the work of a flight, in units of its own.
    below = above / root
    return float(abs(above * kick(above) - (-1.0) ** m * below * kick(below) / root))


def responses(
    osc: Oscillator,
    omegas: Floats,
    speeds: Sequence[float] = (0.0, 1.0, 3.0, 10.0),
    transient: int = 400,
) -> tuple[Floats, Floats]:
    """Return the largest impact speed and displacement of the attractor that each start finds.

    Parameters
    ----------
    osc
        What moves, under cos(omega t).
    omegas
        (n,) array, the frequencies.
    speeds
        Velocities of the starts at 0.
    transient
        Periods that are left out; 64 are measured.

    Returns
    -------
    tuple of (n, starts) arrays
        Speeds and displacements.
    """
    data = sweep(
        ("peak_impact_velocity", "peak_displacement"),
        osc,
        cosine(1.0),
        over={"forcing.omega": omegas, "start.v0": list(speeds)},
        transient=transient,
        n_workers=1,
    )
    return data.peak_impact_velocity.values, data.peak_displacement.values


def response(
    osc: Oscillator,
    omegas: Floats,
    speeds: Sequence[float] = (0.0, 1.0, 3.0, 10.0),
    transient: int = 400,
) -> tuple[Floats, Floats]:
    """Return the largest speed and displacement of `responses` at each frequency.

    Returns
    -------
    tuple of (n,) arrays
        The largest over the starts.
    """
    fastest, widest = (
        np.nanmax(values, axis=1) for values in responses(osc, omegas, speeds, transient)
    )
    return fastest, widest


def largest_speeds(osc: Oscillator, omegas: Floats, expected: float, transient: int) -> Floats:
    """Return the largest impact speeds near a peak, from starts at and below its height."""
    return response(osc, omegas, (0.5 * expected, 0.9 * expected, expected), transient)[0]


def peak_and_width(omegas: Floats, speeds: Floats) -> tuple[float, float]:
    """Return the height of a peak, and its width where the speed is 1/sqrt 2 of that.

    Parameters
    ----------
    omegas, speeds
        (n,) arrays, the peak's sides included.

    Examples
    --------
    >>> omegas = np.linspace(-4.0, 4.0, 4001)
    >>> height, width = peak_and_width(omegas, 1.0 / np.sqrt(1.0 + omegas**2))
    >>> round(height, 6), round(width, 5)
    (1.0, 2.0)
    """
    top = int(np.argmax(speeds))
    level = speeds[top] / math.sqrt(2.0)
    left, right = speeds[: top + 1] < level, speeds[top:] < level
    if not left.any() or not right.any():
        return float(speeds[top]), math.nan
    i = int(np.flatnonzero(left)[-1])
    j = top + int(np.argmax(right))
    low = np.interp(level, speeds[[i, i + 1]], omegas[[i, i + 1]])
    high = np.interp(-level, -speeds[[j - 1, j]], omegas[[j - 1, j]])
    # A parabola through the three highest points has its top between them.
    if 0 < top < len(speeds) - 1:
        before, after = omegas[top - 1] - omegas[top], omegas[top + 1] - omegas[top]
        left = (speeds[top - 1] - speeds[top]) / before
        right = (speeds[top + 1] - speeds[top]) / after
        bend = (right - left) / (after - before)
        slope = left - bend * before
        return float(speeds[top] - slope**2 / (4.0 * bend)), float(high - low)
    return float(speeds[top]), float(high - low)


@dataclass(frozen=True)
class HalfPeak:
    """The peak of the half-harmonic, from a branch of stable orbits.

    Attributes
    ----------
    height
        The largest impact speed.
    width
        Range of the frequency in which the speed is more than 1/sqrt 2 of that.
    end
        How far above 1 the stable orbits end.
    at_one
        The impact speed at omega = 1.
    multipliers
        Of the orbit at omega = 1, the larger one first.
    """

    height: float
    width: float
    end: float
    at_one: float
    multipliers: tuple[float, float]


@cache
def half_peak(lost: float) -> HalfPeak:
    """Follow the orbit of the half-harmonic around omega = 1.

    Parameters
    ----------
    lost
        The share of the speed lost at an impact, 1 - r; without damping.
    """
    orbit = peak_orbit(Fraction(1), 1.0 - lost)
    span = 1.0 - 1.5 * lost**2, 1.0 + 0.4 * lost**2
    branch = continue_orbit(orbit, over={"forcing.omega": span})
    rows = np.flatnonzero(branch.admissible & branch.is_stable)
    rows = rows[np.argsort(branch.values[rows], kind="stable")]
    speeds = np.abs(branch.impact_velocity[rows]).max(axis=1)
    omegas = branch.values[rows]
    height, width = peak_and_width(omegas, np.append(speeds[:-1], 0.0))
    larger, smaller = sorted(np.real(orbit.multipliers), reverse=True)
    at_one = float(np.abs(orbit.impacts.v_before).max())
    return HalfPeak(height, width, float(omegas[-1] - 1.0), at_one, (float(larger), float(smaller)))
