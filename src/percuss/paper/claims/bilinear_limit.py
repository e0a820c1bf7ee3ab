"""The bilinear oscillator near the impact oscillator, to first order and as measured.

x'' + x = cos(omega t + phase) on x > 0, and on x < 0 the stiffness k- in place of 1. Small is
k-^(-1/2). docs/theory/bilinear-limit.md derives what is computed here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.harmonic_forces import cosine, sine
from percuss.model.oscillator import bilinear_oscillator, impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.models.motions import impact_speeds

OMEGA, SPEED, T_END = 1.7, 0.8, 25.0
# When a motion is looked at that grazes at t = 0.
AFTER_GRAZE = 0.5
STIFFNESSES = tuple(10.0**power for power in range(2, 15, 2))


def impact_run() -> Trajectory:
    """Return the motion of the impact oscillator that stays away from grazing."""
    return simulate(impact_oscillator(), cosine(OMEGA), v0=SPEED, t_end=T_END)


@cache
def bilinear_run(stiffness: float) -> Trajectory:
    """Return the bilinear motion from the same start."""
    osc = bilinear_oscillator(stiffness_below=stiffness)
    return simulate(osc, cosine(OMEGA), v0=SPEED, t_end=T_END)


def first_delays(run: Trajectory, contact: float = math.pi) -> Floats:
    """Return how much later the bilinear oscillator hits, times sqrt(k-), for k- to infinity.

    Each contact is, to first order, a delay of pi / sqrt(k-) at unchanged speed; delays are
    carried on by the derivative of the impact map.

    Parameters
    ----------
    run
        A motion of the impact oscillator from its wall, under cos(omega t).
    contact
        Duration of a contact, times sqrt(k-).

    Returns
    -------
    array
        (n,), one for each impact of the run; the first is zero.

    Examples
    --------
    Without a force, delays add up:

    >>> import percuss as pc
    >>> free = pc.simulate(pc.impact_oscillator(), pc.cosine(1.7, 0.0), v0=1.0, max_impacts=3)
    >>> first_delays(free, 1.0).round(12) + 0.0
    array([0., 1., 2.])
    """
    times = np.concatenate(([run.t0], run.impacts.t))
    speeds = np.concatenate(([run.v0], run.impacts.v_after))
    amplitude = run.forcing.components()[0].cos if run.forcing is not None else 0.0
    late, faster = 0.0, 0.0
    delays = []
    for k in range(len(times) - 1):
        flight = times[k + 1] - times[k]
        force, force_after = amplitude * numerics.cos(OMEGA * times[k : k + 2])
        x, v = -speeds[k] * late, faster - force * late
        x, v = _rotated(x, v, flight)
        late = x / speeds[k + 1]
        delays.append(late)
        faster = -(v + force_after * late)
        late += contact
    return np.array(delays)


def _rotated(x: float, v: float, t: float) -> tuple[float, float]:
    return x * numerics.cos(t) + v * numerics.sin(t), v * numerics.cos(t) - x * numerics.sin(t)


def time_errors(stiffness: float) -> Floats:
    """Return how much later the bilinear oscillator hits than the impact oscillator.

    Parameters
    ----------
    stiffness
        k-, so large that no impact of the run is gained or lost.

    Returns
    -------
    array
        (n,) differences of the times of entry and of impact.

    Examples
    --------
    >>> errors = time_errors(1e10) * 1e5
    >>> bool(abs(errors - first_delays(impact_run())).max() < 0.02)
    True
    """
    limit = impact_run().impacts.t
    entries, _ = impact_speeds(bilinear_run(stiffness))
    count = min(len(limit), len(entries))
    return np.asarray(entries[:count] - limit[:count])


def local_orders(smallness: Floats, errors: Floats) -> Floats:
    """Return the power of the error between neighbours of a sequence.

    Examples
    --------
    >>> local_orders(np.array([1.0, 0.1, 0.01]), np.array([3.0, 0.03, 0.0003])).round(12)
    array([2., 2.])
    """
    return np.asarray(np.diff(numerics.log(np.abs(errors))) / np.diff(numerics.log(smallness)))


@dataclass(frozen=True)
class Graze:
    """A motion of the impact oscillator with one impact and, at t = 0, a graze.

    Attributes
    ----------
    omega, phase
        Of the force cos(omega t + phase).
    t0, x0, v0
        Its start.
    clearance
        Where a stiff bilinear oscillator is at t = 0, times sqrt(k-), to first order.
    """

    omega: float
    phase: float
    t0: float
    x0: float
    v0: float
    clearance: float

    def predicted(self, stiffness: float) -> float:
        """Return the jump in velocity at the graze, to leading order.

        2 sqrt(2 f c) k-^(-1/4), with the force f at the graze, where the bilinear oscillator
        arrives a depth c k-^(-1/2) too low; 0 where it passes above.
        """
        depth = max(-self.clearance, 0.0) / math.sqrt(stiffness)
        return 2.0 * math.sqrt(2.0 * numerics.cos(self.phase) * depth)


@cache
def graze(omega: float, phase: float) -> Graze:
    """Return a grazing motion, found by following it backwards from the graze.

    Parameters
    ----------
    omega, phase
        Of the force, cos(phase) > 0: it points away from the wall at the graze.

    Examples
    --------
    >>> graze(0.7, 0.8).clearance < 0 < graze(0.7, -0.8).clearance
    True
    """
    reversed_force = cosine(omega, phase=-phase)
    first = simulate(impact_oscillator(), reversed_force, max_impacts=1).impacts
    back, speed = float(first.t[0]), float(first.v_after[0])
    run = simulate(impact_oscillator(), reversed_force, t_end=back + 0.5)
    x, v = run(back + 0.5)
    late_x = -speed * math.pi
    late_v = -numerics.cos(phase - omega * back) * math.pi
    clearance, _ = _rotated(late_x, late_v, back)
    return Graze(omega, phase, -back - 0.5, float(x), -float(v), clearance)


def graze_run(case: Graze, stiffness: float) -> Trajectory:
    """Return the motion of the bilinear oscillator from the start of a grazing motion."""
    return simulate(
        bilinear_oscillator(stiffness_below=stiffness),
        cosine(case.omega, phase=case.phase),
        x0=case.x0,
        v0=case.v0,
        t0=case.t0,
        t_end=AFTER_GRAZE,
    )


def graze_error(case: Graze, stiffness: float) -> float:
    """Return how far the bilinear oscillator is from the grazing motion, a moment after.

    Parameters
    ----------
    case
        The motion.
    stiffness
        k-.

    Returns
    -------
    float
        Difference of the displacements at t = 1/2 by sin(1/2): the jump in velocity at t = 0.
    """
    later = AFTER_GRAZE
    exact = simulate(impact_oscillator(), cosine(case.omega, phase=case.phase), t_end=later)
    run = graze_run(case, stiffness)
    return float(run(later)[0] - exact(later)[0]) / numerics.sin(later)


def saturation_speed(n: int, stiffness: float, factor: float = 4.0) -> float:
    """Return the largest speed under sin(n t), n even, from rest, to leading order.

    4 sqrt(k-) / (pi (n^2 - 1)), or another factor than 4: the bilinear oscillator's resonance lies
    1/sqrt(k-) below, and it beats.

    Examples
    --------
    >>> round(saturation_speed(2, 1e4), 3)
    42.441
    """
    return factor * math.sqrt(stiffness) / (math.pi * (n * n - 1))


def beat_run(n: int, stiffness: float) -> Trajectory:
    """Return three quarters of the first beat under sin(n t) from rest."""
    osc = bilinear_oscillator(stiffness_below=stiffness)
    return simulate(osc, sine(n), t_end=1.5 * math.pi / n * math.sqrt(stiffness))


@cache
def bilinear_saturation(n: int, stiffness: float) -> tuple[float, float]:
    """Return the largest speed in the first beat under sin(n t) from rest, and its time.

    Parameters
    ----------
    n
        Frequency of the force, even. A beat takes (2 pi / n) sqrt(k-).
    stiffness
        k-.
    """
    run = beat_run(n, stiffness)
    times, speeds = impact_speeds(run)
    at = int(np.argmax(speeds[: len(times)]))
    return float(speeds[at]), float(times[at])


def half_harmonic_run(stiffness: float, phase: float = 0.0) -> Trajectory:
    """Return many beats under cos(t + phase) from rest."""
    osc = bilinear_oscillator(stiffness_below=stiffness)
    return simulate(osc, cosine(1, phase=phase), t_end=40.0 * math.sqrt(stiffness))


@cache
def half_harmonic_saturation(stiffness: float, phases: int = 12) -> float:
    """Return the largest speed under cos(t + phase) from rest, over many beats and phases.

    Parameters
    ----------
    stiffness
        k-.
    phases
        Number of phases of the force, equally spaced.
    """
    largest = 0.0
    for step in range(phases):
        _, speeds = impact_speeds(half_harmonic_run(stiffness, 2.0 * math.pi * step / phases))
        largest = max(largest, float(speeds.max()))
    return largest
