"""Impact times next to a resonance: the question that figure 2 illustrates."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
from flint import arb

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.exact import pi_times
from percuss.model.harmonic_forces import cosine, sine
from percuss.model.oscillator import bilinear_oscillator, impact_oscillator
from percuss.motion.eigenset import resonant_frequency
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run
from percuss.paper.models.motions import impact_speeds

BELOW, DETUNING, FIG_2_PERIODS = 20, 1.01, 60


@cache
def kinds_from_rest(phases: int = 8, periods: int = 60) -> tuple[tuple[str, ...], Floats]:
    """Return what the impact times of fig 2's oscillator are, from rest.

    From rest the amplitude of the force changes the scale alone, so only its phase is varied.

    Parameters
    ----------
    phases
        Number of phases, equally spaced.
    periods
        Periods of the force, 60 in fig 2.

    Returns
    -------
    tuple
        Kind of the set of impact times for each phase, and the interval between the last two
        impacts in periods of the force.

    Examples
    --------
    >>> kinds_from_rest(1)[0]
    ('no_period_found',)
    """
    osc = bilinear_oscillator(stiffness_below=BELOW)
    omega = DETUNING * resonant_frequency(osc)
    period = 2.0 * math.pi / omega
    kinds, last = [], []
    for step in range(phases):
        force = cosine(omega, phase=pi_times(2 * step, phases))
        times, _ = impact_speeds(simulate(osc, force, t_end=periods * period))
        kinds.append(classify_impact_times(times, osc, force).kind)
        last.append(float(times[-1] - times[-2]) / period)
    return tuple(kinds), np.array(last)


def fig_2_run(step: int, detuning: float = DETUNING) -> Trajectory:
    """Return the motion of fig 2 from rest.

    Parameters
    ----------
    step
        Phase of the force, in eighths of its period.
    detuning
        Its frequency over the resonant one.
    """
    osc = bilinear_oscillator(stiffness_below=BELOW)
    omega = detuning * resonant_frequency(osc)
    force = cosine(omega, phase=pi_times(2 * step, 8))
    return simulate(osc, force, t_end=FIG_2_PERIODS * 2.0 * math.pi / omega)


def interval_ends(step: int, detuning: float = DETUNING) -> tuple[arb, arb, arb]:
    """Return the first and the last interval between impacts of fig 2, and the lag that adds up.

    Parameters
    ----------
    step, detuning
        As for `fig_2_run`.

    Returns
    -------
    tuple
        Balls, all in periods of the force.

    Raises
    ------
    ArithmeticError
        If the motion is not proven.

    Examples
    --------
    >>> round(float(interval_ends(0)[1].mid()), 4)
    1.005
    """
    proven = certain_run(fig_2_run(step, detuning))
    if proven is None:
        raise ArithmeticError(f"the motion of fig 2 is not proven in the phase {step}/8")
    omega = detuning * resonant_frequency(bilinear_oscillator(stiffness_below=BELOW))
    crossings = proven.crossings
    times = [t for t, way in zip(crossings.t.arbs, crossings.direction, strict=True) if way == "in"]
    turns = [t * arb(omega) / (2 * arb.pi()) for t in times]
    lag = turns[-1] - turns[0] - (len(turns) - 1)
    return turns[1] - turns[0], turns[-1] - turns[-2], lag


@cache
def damped_deviation(damping: float, periods: int = 1000) -> float:
    """Return how far intervals are from the forcing period in the end, with damping.

    Parameters
    ----------
    damping
        a > 0.
    periods
        How long to wait, in periods.

    Returns
    -------
    float
        Largest deviation of the last five intervals, in periods.

    Examples
    --------
    >>> damped_deviation(0.05) < 1e-10
    True
    """
    osc = bilinear_oscillator(stiffness_below=BELOW, damping=damping)
    omega = DETUNING * resonant_frequency(osc)
    period = 2.0 * math.pi / omega
    times, _ = impact_speeds(simulate(osc, sine(omega), t_end=periods * period))
    return float(np.abs(np.diff(times[-6:]) / period - 1.0).max())


def periodic_speed(omega: float) -> float:
    """Return V0 of the motion of the impact oscillator with one impact a period, off resonance.

    |tan(pi / omega) / (1 - omega^2)|, under cos omega t for omega a little above 2.

    Examples
    --------
    >>> round(periodic_speed(2.02), 9)
    20.871774049
    """
    return abs(numerics.tan(math.pi / omega) / (1.0 - omega * omega))


def run_near_periodic(omega: Fraction, faster: float, impacts: int = 300) -> Trajectory:
    """Return a motion of the impact oscillator that starts near the periodic one.

    Parameters
    ----------
    omega
        Frequency of the force cos omega t, a little above 2.
    faster
        How much faster than the periodic motion the start is.
    impacts
        How long to follow it.
    """
    speed = periodic_speed(float(omega)) + faster
    return simulate(impact_oscillator(), cosine(omega), v0=speed, max_impacts=impacts)


def periodic_start(omega: Fraction, faster: float, impacts: int = 300) -> float:
    """Return how far flight times are from the period, for a start near the periodic one.

    Parameters
    ----------
    omega, faster, impacts
        As for `run_near_periodic`.

    Returns
    -------
    float
        Largest deviation of a flight time from 2 pi / omega.

    Examples
    --------
    >>> periodic_start(Fraction("2.02"), 0.0) < 1e-10 < periodic_start(Fraction("2.02"), 0.1)
    True
    """
    run = run_near_periodic(omega, faster, impacts)
    return float(np.abs(run.impacts.intervals - 2.0 * math.pi / float(omega)).max())
