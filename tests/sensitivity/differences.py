"""Derivatives of a motion by central differences of the oracle, to some twenty digits."""

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


def _moved(
    run: pc.Trajectory, path: str, step: Fraction, max_impacts: int | None
) -> event_driven.Run:
    values = run.oscillator, run.forcing, run.start
    value = get_parameter(*values, path)
    times, plus = angle(value)
    moved = PiTimes(times, plus + step) if times else plus + step
    osc, force, start = replace_parameter(*values, path, moved)
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
