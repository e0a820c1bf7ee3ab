"""Derivatives of motions and orbits by central differences of the oracle, to twenty digits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import mpmath
import numpy as np
from tests.oracle import event_driven
from tests.oracle.curves import Real
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.arrays import Floats
from percuss.model.exact import PiTimes, angle, as_fraction
from percuss.model.paths import get_parameter, replace_parameter
from percuss.model.start import Start

# The error of a central difference is H^2 times a third derivative, and 10^-DIGITS / H by rounding.
H = Fraction(1, 10**13)
DIGITS = 40


@dataclass(frozen=True)
class Differences:
    """The derivatives by one parameter, as floats, in the columns of a run."""

    t: Floats
    v_before: Floats
    v_after: Floats
    crossings: Floats
    start: Floats
    release: Floats
    x: Floats
    v: Floats


def differences(
    run: pc.Trajectory,
    path: str,
    *,
    times: Sequence[float] = (),
    max_impacts: int | None = None,
) -> Differences:
    """Return the differences of a run by a parameter; with ``max_impacts`` up to that impact."""
    ahead, behind = (_moved(run, path, step, max_impacts) for step in (H, -H))

    def by_two(one: list[Real], other: list[Real]) -> Floats:
        assert len(one) == len(other)
        with mpmath.workdps(2 * DIGITS):
            step = mpmath.mpf(H.numerator) / H.denominator
            pairs = zip(one, other, strict=True)
            return np.array([float((a - b) / (2 * step)) for a, b in pairs])

    states = [[oracle(t) for t in times] for oracle in (ahead, behind)]
    x, v = (by_two(*([state[i] for state in some] for some in states)) for i in (0, 1))
    return Differences(
        by_two(ahead.impacts.t, behind.impacts.t),
        by_two(ahead.impacts.v_before, behind.impacts.v_before),
        by_two(ahead.impacts.v_after, behind.impacts.v_after),
        by_two(ahead.crossings.t, behind.crossings.t),
        by_two(ahead.contacts.start, behind.contacts.start),
        by_two(ahead.contacts.release, behind.contacts.release),
        x,
        v,
    )


@dataclass(frozen=True)
class OrbitDifferences:
    """The derivatives of an orbit with one impact by one parameter."""

    t0: float
    v0: float
    period: float
    trace: float
    determinant: float


def orbit_differences(orbit: pc.PeriodicOrbit, path: str) -> OrbitDifferences:
    """Return the differences of an orbit with one impact on a wall, whose map the oracle solves."""
    ahead, behind = (_closed(orbit, path, step) for step in (H, -H))
    with mpmath.workdps(2 * DIGITS):
        step = mpmath.mpf(H.numerator) / H.denominator
        pairs = zip(ahead, behind, strict=True)
        return OrbitDifferences(*(float((a - b) / (2 * step)) for a, b in pairs))


def _closed(orbit: pc.PeriodicOrbit, path: str, step: Fraction) -> tuple[Real, ...]:
    """Return t0, v0, the period and the map's trace and determinant at a moved parameter."""
    osc, force, _ = _moved_system(orbit.oscillator, orbit.forcing, None, path, step)
    problem = problem_of(osc, force)
    wall = as_fraction(osc.stops[0].at)
    is_free = orbit.n_periods == 0
    moved = run_map(orbit)
    with mpmath.workdps(2 * DIGITS):
        period = mpmath.mpf(0)
        if not is_free:
            period = orbit.n_periods * 2 * mpmath.pi / problem.harmonics[0].omega

        def arrival(t0: Real, v0: Real) -> tuple[Real, Real]:
            run = event_driven.simulate(problem, wall, v0, t0, max_impacts=1, digits=DIGITS)
            return run.impacts.t[-1] - period, run.impacts.v_after[-1]

        t0, v0 = mpmath.mpf(orbit.t0), mpmath.mpf(orbit.v0)
        for _ in range(4):
            t, v = arrival(t0, v0)
            if is_free:
                v0 += (v - v0) / (1 - moved[1, 1])
            else:
                late, fast = np.linalg.inv(np.eye(2) - moved) @ np.array([t - t0, v - v0])
                t0, v0 = t0 + late, v0 + fast
        h = mpmath.mpf(H.numerator) / H.denominator
        by_t, by_v = (
            [(a - b) / (2 * h) for a, b in zip(one, other, strict=True)]
            for one, other in (
                (arrival(t0 + h, v0), arrival(t0 - h, v0)),
                (arrival(t0, v0 + h), arrival(t0, v0 - h)),
            )
        )
        if is_free:
            period = arrival(t0, v0)[0] - t0
        return t0, v0, period, by_t[0] + by_v[1], by_t[0] * by_v[1] - by_t[1] * by_v[0]


def run_map(orbit: pc.PeriodicOrbit) -> Floats:
    """Return the derivative of the next impact's instant and velocity by those of this one."""
    motion = orbit.trajectory(2).sensitivity(["start.t0", "start.v0"])
    found: Floats = np.stack([motion.impacts.t[0], motion.impacts.v_after[0]])
    return found


def _moved_system(
    osc: pc.Oscillator, force: pc.Forcing | None, start: Start | None, path: str, step: Fraction
) -> tuple[pc.Oscillator, pc.Forcing | None, Start | None]:
    values = osc, force, start
    value = get_parameter(*values, path)
    times, plus = angle(value)
    moved = PiTimes(times, plus + step) if times else plus + step
    return replace_parameter(*values, path, moved)


def _moved(
    run: pc.Trajectory, path: str, step: Fraction, max_impacts: int | None
) -> event_driven.Run:
    osc, force, start = _moved_system(run.oscillator, run.forcing, run.start, path, step)
    assert start is not None
    with mpmath.workdps(10 * DIGITS):
        times, plus = angle(start.t0)
        t0 = event_driven.number(times) * mpmath.pi + event_driven.number(plus)
    return event_driven.simulate(
        problem_of(osc, force),
        as_fraction(start.x0),
        as_fraction(start.v0),
        t0,
        t_end=mpmath.inf if max_impacts else run.t_end,
        max_impacts=max_impacts,
        digits=DIGITS,
    )
