"""The third harmonic below its critical velocity: impact times that are not the eigenset's.

docs/theory/third-harmonic.md derives what is measured here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified import repeats_after
from percuss.model.forcing import sine
from percuss.model.oscillator import Oscillator, bilinear_oscillator
from percuss.model.start import Start
from percuss.motion.impact_times import ImpactTimes, classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import impacts_at
from percuss.paper.claims.divergence import separation
from percuss.paper.claims.evidence import (
    ROUNDING,
    WALL,
    apart,
    condition,
    last_unchanged,
    near,
)
from percuss.paper.models.runge_kutta import POINTS, SteppedMotion, runge_kutta
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS", "STIFFNESSES", "T_END", "V0", "bilinear_run", "long_run", "stepped"]


V0 = "0.45"
T_END = 30.0 * math.pi
# The paper's 2e4 as the ratio of frequencies, and as that of their squares.
STIFFNESSES = {"w-/w+ = 2e4": 4e8, "w-^2/w+^2 = 2e4": 2e4}
LONG = 3000.0 * math.pi
# How far from an end of a range two starts are that are proven to be in it and not.
NEARBY = 1e-10
# Starts between 0 and the critical velocity 1/2 whose impact times are classified.
N_STARTS = 100


@cache
def long_run() -> Trajectory:
    """Return the motion of figure 6b in the limit, a hundred times as long."""
    return simulate(WALL, sine(3), v0=V0, t_end=LONG)


@cache
def bilinear_run(stiffness_below: float, t_end: float = T_END) -> Trajectory:
    """Return the same motion with a finite stiffness."""
    osc = bilinear_oscillator(stiffness_below=stiffness_below)
    return simulate(osc, sine(3), v0=V0, t_end=t_end)


@cache
def stepped(stiffness_below: float, tolerance: float) -> SteppedMotion:
    """Return the same motion by the paper's method."""
    return runge_kutta(
        stiffness_below, 3.0, -0.5 * math.pi, v0=float(V0), t_end=T_END, tolerance=tolerance
    )


def impact_times(v0: float, periods: int) -> Floats:
    """Return the impact times in closed form, six in each 4 pi.

    Examples
    --------
    >>> (impact_times(0.45, 1) / math.pi).round(4)
    array([1.    , 1.3976, 2.3976, 2.6024, 3.6024, 4.    ])
    """
    short = numerics.atan2(math.sqrt(2.0 * v0), math.sqrt(1.0 - 2.0 * v0))
    pattern = np.array([0.0, short, math.pi + short, 2 * math.pi - short, 3 * math.pi - short])
    pattern = np.append(math.pi + pattern, 4 * math.pi)
    return np.asarray(
        (4 * math.pi * np.arange(periods)[:, np.newaxis] + pattern).reshape(-1), dtype=np.float64
    )


def _other_times() -> Finding:
    """Measure how far the impacts are from multiples of pi, and where they are instead."""
    run = simulate(WALL, sine(3), v0=V0, max_impacts=42)
    times = run.impacts.t
    off = np.abs(times / math.pi - np.round(times / math.pi)).max() * math.pi
    checks = [
        condition("some impact is farther than 0.1 from each multiple of pi", off > 0.1),
        impacts_at("t_k minus the closed form", run, impact_times(0.45, 7), start=Start(0, V0)),
    ]
    if checks[1].is_certain:
        # The times are known to far more digits than these.
        checks[0] = replace(checks[0], radius=0.0)
    return Finding(
        tuple(checks),
        remark=(
            "The second impact is at pi + arcsin sqrt(2 V0); the farthest one is "
            f"{off:.4f} from the eigenset."
        ),
    )


def _is_six(v0: float) -> bool:
    """Return whether the motion from V0 has the pattern of six impacts in 4 pi."""
    times = simulate(WALL, sine(3), v0=v0, t_end=8.5 * math.pi).impacts.t
    # Next to a critical velocity an extra impact comes where the motion grazes, never far from it.
    expected = impact_times(v0, 2)
    return len(times) == len(expected) and apart(times, expected) < 1e-6


def critical_velocities() -> tuple[float, float]:
    """Return between which velocities there are six impacts in 4 pi.

    Examples
    --------
    >>> low, high = critical_velocities()
    >>> round(low, 6), round(high, 6)
    (0.135723, 0.489277)
    """
    return (5.0 - 2.0 * math.sqrt(2.0)) / 16.0, (5.0 + 2.0 * math.sqrt(2.0)) / 16.0


def monodromy() -> Floats:
    """Return the change of (x, v) at t = pi/2 + 4 pi with that at t = pi/2, by differences."""
    start, step = 0.5 * math.pi, 1e-4
    x0, v0 = (float(value) for value in long_run()(start))
    columns = []
    for dx, dv in ((step, 0.0), (0.0, step)):
        ends = []
        for sign in (1.0, -1.0):
            run = simulate(
                WALL,
                sine(3),
                x0=x0 + sign * dx,
                v0=v0 + sign * dv,
                t0=start,
                t_end=start + 4.0 * math.pi,
            )
            ends.append(np.array(run(run.t_end)))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.stack(columns, axis=1)


def _period_lost() -> Finding:
    """Classify the impact times, and see what becomes of motions nearby."""
    found = classify_impact_times(long_run())
    matrix = monodromy()
    apart_by = separation(WALL, sine(3), float(V0), 1e-9, LONG)
    remark = (
        f"The motion has {found.n_impacts} impacts in {found.n_periods} forcing periods, 4 pi, and "
        f"repeats itself to {found.deviation:.0e} over {LONG / math.pi:g} pi. Motions nearby have "
        f"the same period: the monodromy matrix is the identity to {np.abs(matrix - np.eye(2)).max():.0e}, "
        "both multipliers are 1. A difference of 1e-9 at the start grows at most "
        f"{apart_by.max():.1f} times, so what figure 6b shows of irregularity is none of the limit "
        "w- -> infinity."
    )
    return Finding(
        (condition("the impact times have no period", found.kind != "periodic"),), remark=remark
    )


@cache
def kinds_of_starts() -> tuple[ImpactTimes, ...]:
    """Classify the impact times from equidistant velocities below 1/2."""
    return tuple(
        classify_impact_times(
            simulate(WALL, sine(3), v0=(k + 0.5) / (2 * N_STARTS), t_end=1000.0 * math.pi)
        )
        for k in range(N_STARTS)
    )


def _share_without_period() -> Check:
    """Return the share of the starts without a period, as far as the periodic ones are proven."""
    found = kinds_of_starts()
    what = "share of starts 0 < V0 < 1/2 without a period in 1000 pi"
    proven = sum(
        one.kind == "periodic"
        and repeats_after(WALL, sine(3), (k + 0.5) / (2 * N_STARTS), int(one.n_impacts)).holds
        is True
        for k, one in enumerate(found)
    )
    # Those that are proven have a period; of the others nothing is known.
    largest = 1.0 - proven / N_STARTS
    return Check(what, 0.5 * largest, 1.0, ROUNDING, 0.5 * largest + 1e-15)


def _end(what: str, value: float, simulated: Callable[[], float], way: float) -> Check:
    """Return the check that the six impacts begin, or end, at a velocity: within 1e-10."""
    inside, outside = (
        repeats_after(WALL, sine(3), value + side * way * NEARBY, 6).holds for side in (1, -1)
    )
    if inside is True and outside is False:
        return Check(what, value, value, 1e-9, 1.01 * NEARBY)
    return near(what, simulated(), value, 1e-9)


def _identity() -> Check:
    """Return the check that the derivative over the period is the identity."""
    what = "largest entry of the monodromy matrix minus 1"
    if repeats_after(WALL, sine(3), V0, 6).holds is True:
        # All motions nearby return exactly.
        return Check(what, 0.0, 0.0, 1e-7, 0.0)
    return near(what, np.abs(monodromy() - np.eye(2)).max(), 0.0, 1e-7)


def _outside_the_range() -> Finding:
    """Count the starts below 1/2 without a period, and find where the six impacts end."""
    found = kinds_of_starts()
    periodic = sum(one.kind == "periodic" for one in found)
    six = sum((one.n_impacts, one.n_periods) == (6, 6) for one in found)
    low, high = critical_velocities()
    patterns = sorted({(one.n_impacts, one.n_periods) for one in found if one.kind == "periodic"})
    return Finding(
        (_share_without_period(),),
        corrected=(
            _end(
                "V0 where six impacts in 4 pi begin",
                low,
                lambda: -last_unchanged(lambda v: _is_six(-v), -0.3, -0.01),
                1.0,
            ),
            _end(
                "V0 where six impacts in 4 pi end",
                high,
                lambda: last_unchanged(_is_six, 0.3, 0.4999),
                -1.0,
            ),
            _identity(),
        ),
        correction=(
            "the impact times change, but stay periodic over most of the range: with six impacts in "
            "4 pi for (5 - 2 sqrt 2)/16 < V0 < (5 + 2 sqrt 2)/16, with longer periods or none elsewhere"
        ),
        remark=(
            f"Of {N_STARTS} starts {periodic} are periodic, {six} with six impacts in six forcing "
            f"periods; others with (impacts, periods) = {', '.join(map(str, patterns[1:]))}. That all "
            "velocities between the two ends have six impacts is derived."
        ),
    )


def speed_errors(motion: SteppedMotion) -> float:
    """Return the largest relative change of the speed from an entry into the stop to its exit."""
    below = motion.x < 0.0
    entries = np.flatnonzero(below[1:] & ~below[:-1])
    exits = np.flatnonzero(~below[1:] & below[:-1]) + 1
    n = min(len(entries), len(exits))
    before, after = np.abs(motion.v[entries[:n]]), np.abs(motion.v[exits[:n]])
    return float(np.abs(after / before - 1.0).max())


def _finite_stiffness() -> Finding:
    """Classify the impact times of the bilinear oscillator, and follow a motion beside it."""
    checks, remarks = [], []
    t = np.linspace(0.0, T_END, 20_001)
    for name, below in STIFFNESSES.items():
        run = bilinear_run(below)
        for t_end in (T_END, LONG):
            kind = classify_impact_times(bilinear_run(below, t_end)).kind
            what = f"{name}: the entries up to {t_end / math.pi:g} pi have no period"
            checks.append(condition(what, kind == "no_period_found"))
        osc: Oscillator = run.oscillator
        growth = separation(osc, sine(3), float(V0), 1e-9, LONG).max()
        off = apart(run(t)[0], long_run()(t)[0])
        entries = run.crossings.direction == "in"
        speeds = np.abs(run.crossings.v[entries])
        remarks.append(
            f"{name}: x differs from the limit by up to {off:.2g}; the entry speeds of each sixth "
            f"impact go from {speeds[0]:.5f} to {speeds[36]:.5f}; 1e-9 at the start grows at most "
            f"{growth:.0f} times up to {LONG / math.pi:g} pi"
        )
    steps = math.pi / 2e4 / (T_END / POINTS)
    plain = speed_errors(stepped(4e8, 0.0))
    fine = speed_errors(stepped(4e8, 1e-9))
    remark = (
        "; ".join(remarks)
        + ". So this is a slow drift through the family of periodic motions, since "
        "each contact takes the time pi/w-, and no chaos. Runge-Kutta steps of the paper's length "
        f"(2^20 to 30 pi) at w-/w+ = 2e4, {steps:.2f} to a contact, change the speed at a contact by "
        f"up to {plain:.0%}, with an error test that shortens them by {fine:.0e}: without one they "
        "make an irregular motion that belongs to neither equation."
    )
    return Finding(tuple(checks), remark=remark)


STATEMENTS = (
    Statement(
        id="periodicity-fig6b-times",
        reference="fig 6b",
        claim="Under sin 3t a start with V0 = 0.45 leads to impact times that are not the eigenset's.",
        method="exact motion, held against the closed form of its impact times",
        certainty="closed form, 12 digits",
        find=_other_times,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig6b-lost",
        reference="section 6, fig 6b",
        claim="At V0 = 0.45 the impact times have lost their periodicity.",
        method="classification of 4,500 impacts of the exact motion; motions beside it",
        certainty="closed form of the periodic motion; simulation, 1e-9",
        proven=True,
        find=_period_lost,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-outside-range",
        reference="section 6",
        claim="Outside the range of initial velocities with impact times on the eigenset, for n = 3 "
        "below V0 = 1/2, the impact times lose periodicity.",
        method="100 starts; the ends of the family by bisection against their closed form",
        certainty="simulation, 1e-9",
        find=_outside_the_range,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig6b-bilinear",
        reference="fig 6b, section 4",
        claim="The bilinear oscillator that the paper computes in place of the impact oscillator has "
        "impact times without a period at V0 = 0.45.",
        method="exact bilinear motion at both readings of the stiffness ratio; Runge-Kutta",
        certainty="simulation, 1e-9",
        find=_finite_stiffness,
        theory="third-harmonic.md",
    ),
)
