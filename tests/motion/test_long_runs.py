"""At t = 3e6 one ulp of t is 4.7e-10: what a run must not lose."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

import percuss as pc


@pytest.mark.parametrize("count", [100_000, pytest.param(1_000_000, marks=pytest.mark.nightly)])
def test_third_harmonic_stays_on_its_eigenset_for_a_million_impacts(count: int) -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, max_impacts=count)

    with mpmath.workdps(40):
        exact = np.array([float(k * mpmath.pi) for k in range(count - 999, count + 1)])
    assert (np.abs(run.impacts.t[-1000:] - exact) <= 2 * np.spacing(exact)).all()
    # Impacts come at cycles 1/2 and 0 of 2 pi / 3.
    off = np.abs(run.impacts.cycle * 2.0 - np.round(run.impacts.cycle * 2.0)) / 2.0
    assert off.max() < 1e-10
    assert np.abs(run.impacts.v_after - 0.51).max() < 1e-9


@pytest.mark.parametrize("count", [10_000, pytest.param(100_000, marks=pytest.mark.nightly)])
def test_second_harmonic_grows_linearly_for_a_hundred_thousand_impacts(count: int) -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(2), v0=1.0, max_impacts=count)

    expected = 1.0 + 4.0 / 3.0 * np.arange(1, count + 1)
    np.testing.assert_allclose(run.impacts.v_after, expected, rtol=5e-12)


def test_start_at_a_late_instant_is_the_start_at_its_phase() -> None:
    late = 2.0**30
    with mpmath.workdps(40):
        phase = float(mpmath.fmod(2 * mpmath.mpf(late), 2 * mpmath.pi))
    osc = pc.impact_oscillator(0.9)

    run = pc.simulate(osc, pc.cosine(2.0), v0=1.0, t0=late, t_end=late + 50.0)
    early = pc.simulate(osc, pc.cosine(2.0, phase=phase), v0=1.0, t_end=50.0)

    np.testing.assert_allclose(run.impacts.intervals, early.impacts.intervals, rtol=1e-11)
    np.testing.assert_allclose(run.impacts.v_after, early.impacts.v_after, rtol=1e-11)
    assert math.isclose(run.impacts.t[0] - late, early.impacts.t[0], abs_tol=2e-7)
