"""The closed forms of Dyskin et al. 2012 against simulation, and their limits against mpmath."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.motion.eigenset_forms import contact_time, harmonic_contact_time

WALL = pc.impact_oscillator()
SUBSETS = [2, 3, 4, 5, 6, 7, 12, 15]


def same_motion(run: pc.Trajectory, x: Floats, v: Floats, t: Floats) -> float:
    """Return the largest difference, without the instants next to an impact for the velocity."""
    found_x, found_v = run(t)
    at_impact = np.abs(t[:, None] - run.impacts.t).min(axis=1) < 1e-6
    error = np.where(at_impact, 0.0, np.abs(found_v - v))
    return float(max(np.abs(found_x - x).max(), error.max()))


def test_the_eigenset_motion_is_that_of_the_free_oscillator() -> None:
    run = pc.simulate(WALL, v0=1.5, t_end=50.0)
    t = np.linspace(0.0, 50.0, 1001)

    assert same_motion(run, *pc.eigenset_motion("1.5", t), t) < 1e-12


@pytest.mark.parametrize("m", SUBSETS)
@pytest.mark.parametrize("part", [0.05, 0.5, 0.95])
def test_the_family_is_what_its_force_makes(m: int, part: float) -> None:
    v0 = part * pc.subset_critical_velocity(m)
    motion = pc.SubsetMotion(m, v0)
    t_end = 6.2 * (m + 1) * math.pi

    run = pc.simulate(WALL, motion.forcing, v0=v0, t_end=t_end)

    t = np.linspace(0.0, t_end, 3001)
    n = len(run.impacts)
    assert n == 12
    assert np.abs(run.impacts.t - motion.impact_times(n)).max() < 1e-11
    cycle = np.resize(motion.velocities, n + 1)[1:]
    assert np.abs(run.impacts.v_after - cycle).max() < 1e-11
    assert same_motion(run, *motion(t), t) < 1e-11


@pytest.mark.parametrize("m", [2, 4, 6])
def test_for_even_m_the_motion_takes_two_periods_but_at_half_the_critical_velocity(m: int) -> None:
    half = 0.5 * pc.subset_critical_velocity(m)
    single = (m + 1) * math.pi

    assert pc.SubsetMotion(m, half).period == single
    assert pc.SubsetMotion(m, 0.9 * half).period == 2.0 * single
    assert pc.SubsetMotion(m + 1, half).period == pytest.approx(single + math.pi)


def test_the_force_of_the_family_is_exact() -> None:
    (harmonic,) = pc.subset_forcing(4).harmonics

    assert isinstance(harmonic, pc.Harmonic)
    assert harmonic.phase == pc.pi_times(1, 5)
    assert harmonic.amplitude == Fraction(-21, 25)
    assert pc.subset_forcing(5).constant == math.sqrt(0.75)
    assert pc.subset_forcing(2).constant == 0.5
    assert pc.subset_forcing(2).period == pytest.approx(3 * math.pi, rel=1e-15)


@pytest.mark.parametrize("m", [3, 5, 7, 9, 15, 51, 1001])
def test_critical_velocity_of_the_family_is_the_least_ratio_of_the_long_flight(m: int) -> None:
    with mpmath.workdps(30):
        angle, gap = mpmath.pi / (m + 1), m + 1

        def ratio(t: Any) -> Any:
            rise = mpmath.cos(angle) - mpmath.cos(2 * t / gap + angle)
            return rise / -mpmath.sin(t)

        t = mpmath.findroot(lambda s: mpmath.diff(ratio, s), mpmath.mpf(contact_time(m)))
        expected = ratio(t) + 2 * mpmath.sin(angle) / gap

        assert mpmath.pi < t < 2 * mpmath.pi
        assert pc.subset_critical_velocity(m) == pytest.approx(float(expected), rel=4e-15)
        # No later lobe of the long flight comes closer.
        lobes = np.concatenate(
            [np.linspace(k + 0.01, k + 0.99, 99) for k in range(1, min(m, 60), 2)]
        )
        later = [float(ratio(mpmath.pi * s)) for s in lobes]
        assert min(later) >= float(ratio(t)) * (1.0 - 1e-15)


@pytest.mark.parametrize("n", [3, 5, 7, 9, 13, 15, 101, 1001])
def test_critical_velocity_of_odd_harmonics_is_the_greatest_over_the_second_flight(n: int) -> None:
    with mpmath.workdps(30):

        def velocity(eta: Any) -> Any:
            return (n - mpmath.sin(n * eta) / mpmath.sin(eta)) / (n * n - 1)

        guess = mpmath.mpf(harmonic_contact_time(n)) - mpmath.pi
        eta = mpmath.findroot(lambda s: mpmath.diff(velocity, s), guess)

        critical = pc.harmonic_critical_velocity(n)
        assert critical == pytest.approx(float(velocity(eta)), rel=4e-15)
    grid = np.linspace(1e-6, math.pi / 2, 200 * n)
    others = (n - np.sin(n * grid) / np.sin(grid)) / (n * n - 1)
    assert critical * (1.0 - 1e-3) < others.max() <= critical * (1.0 + 1e-14)


def test_critical_velocity_of_high_harmonics_falls_like_one_over_n() -> None:
    """The lobe of sin(n eta)/sin(eta) becomes that of n sin(z)/z, whose minimum is known."""
    with mpmath.workdps(20):
        z = mpmath.findroot(lambda s: mpmath.tan(s) - s, 4.4934)
        limit = float(1 - mpmath.sin(z) / z)

    assert 100_001 * pc.harmonic_critical_velocity(100_001) == pytest.approx(limit, rel=1e-9)


@pytest.mark.parametrize(("n", "v0"), [(2, 0.0), (2, 3.0), (4, 0.0), (6, 0.1), (40, 0.0)])
def test_even_harmonics_resonate_from_every_velocity(n: int, v0: float) -> None:
    motion = pc.HarmonicMotion(n, v0)
    run = pc.simulate(WALL, motion.forcing, v0=v0, t_end=100.5 * math.pi)
    t = np.linspace(0.0, 100.5 * math.pi, 2001)

    assert np.abs(run.impacts.t - math.pi * np.arange(1, 101)).max() < 1e-10
    assert np.abs(run.impacts.v_after - motion.velocity(np.arange(1, 101))).max() < 1e-10
    assert same_motion(run, *motion(t), t) < 1e-9


@pytest.mark.parametrize("n", [3, 5, 9, 15])
def test_odd_harmonics_are_steady_above_their_critical_velocity(n: int) -> None:
    v0 = 1.001 * pc.harmonic_critical_velocity(n)
    motion = pc.HarmonicMotion(n, v0)
    run = pc.simulate(WALL, motion.forcing, v0=v0, t_end=40.5 * math.pi)
    t = np.linspace(0.0, 40.5 * math.pi, 2001)

    assert np.abs(run.impacts.t - math.pi * np.arange(1, 41)).max() < 1e-11
    assert same_motion(run, *motion(t), t) < 1e-11


def test_amplitudes_are_those_of_the_printed_formulas() -> None:
    even, odd = pc.HarmonicMotion(4, 0.5), pc.HarmonicMotion(5, 0.5)

    assert even.amplitude(1) == pytest.approx(-(0.5 + 8 / 15 + 4 / 15))
    assert odd.amplitude([0, 1]) == pytest.approx([0.5 + 5 / 24, -0.5 + 5 / 24])


@pytest.mark.parametrize("m", [1, 0, -3, 2.5, True, "2"])
def test_no_family_for_other_numbers(m: object) -> None:
    with pytest.raises(pc.ParameterError, match="whole number of at least 2"):
        pc.subset_critical_velocity(m)  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match="whole number of at least 2"):
        pc.HarmonicMotion(m, 1.0)  # type: ignore[arg-type]


def test_velocities_outside_the_closed_form_are_refused() -> None:
    with pytest.raises(pc.ParameterError, match=r"outside \[0, V\*\(2\)\]"):
        pc.SubsetMotion(2, 1.1548)
    with pytest.raises(pc.ParameterError, match="outside"):
        pc.SubsetMotion(3, -0.1)
    with pytest.raises(pc.ParameterError, match=r"below V_max\(3\)"):
        pc.HarmonicMotion(3, 0.4999)
    with pytest.raises(pc.ParameterError, match="negative"):
        pc.HarmonicMotion(2, -0.1)
    with pytest.raises(pc.ParameterError, match="into the wall"):
        pc.eigenset_motion(-1.0, 0.0)
    with pytest.raises(pc.ParameterError, match="even"):
        pc.harmonic_critical_velocity(4)
    with pytest.raises(pc.ParameterError, match="even"):
        contact_time(4)
    with pytest.raises(pc.ParameterError, match="negative"):
        pc.SubsetMotion(3, 0.5).impact_times(-1)


def test_the_printed_ends_of_the_range_are_taken() -> None:
    """2/sqrt(3) and 1/2 are V*(2) and V_max(3)."""
    assert pc.SubsetMotion(2, 2.0 / math.sqrt(3.0)).velocities[1] == pytest.approx(0.0, abs=1e-15)
    assert pc.SubsetMotion(3, 0).velocities == (0.0, 0.0)
    assert float(pc.HarmonicMotion(3, "0.5").velocity(7)) == 0.5
