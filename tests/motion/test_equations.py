"""The formulas of Dyskin, Pasternak & Pelinovsky 2012, by their numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc

WALL = pc.impact_oscillator()


def test_equation_2_resonant_frequency_is_the_harmonic_mean_of_both_sides() -> None:
    osc = pc.bilinear_oscillator(4.0, stiffness_below=36.0, damping=0.5)
    above, below = math.sqrt(3.75), math.sqrt(35.75)

    assert pc.resonant_frequency(osc) == pytest.approx(2 * above * below / (above + below))
    assert pc.resonant_frequency(WALL) == pytest.approx(2.0, rel=1e-15)


def test_section_3_eigenset_are_the_impact_times_of_the_free_oscillator() -> None:
    osc = pc.impact_oscillator(0.9, stiffness=4.0, damping=0.1)

    run = pc.simulate(osc, x0=0.0, v0=0.3, t0=2.0, max_impacts=20)

    np.testing.assert_allclose(run.impacts.t, pc.eigenset(osc, 20, t0=2.0), rtol=1e-14)


def test_section_3_eigenset_of_a_bilinear_oscillator_are_its_entries() -> None:
    osc = pc.bilinear_oscillator(1.0, stiffness_below=9.0)

    run = pc.simulate(osc, v0=0.3, t_end=50.0)

    entries = run.crossings.t[run.crossings.direction == "in"]
    np.testing.assert_allclose(entries, pc.eigenset(osc, len(entries)), rtol=1e-14)


@pytest.mark.parametrize(
    "osc",
    [
        pc.impact_oscillator(wall=0.1),
        pc.Oscillator(),
        pc.backlash_oscillator(1.0, 3.0),
        pc.impact_oscillator(damping=1.0),
        pc.impact_oscillator(stiffness=0.0),
    ],
)
def test_section_3_there_is_no_eigenset_where_times_depend_on_the_amplitude(
    osc: pc.Oscillator,
) -> None:
    with pytest.raises(pc.ParameterError, match=r"stops|damping|stiffness"):
        pc.eigenset(osc, 3)


def test_equation_9_free_motion_is_a_sine_between_impacts() -> None:
    run = pc.simulate(WALL, v0=0.7, t_end=20.0)

    t = np.linspace(0.0, 20.0, 401)
    np.testing.assert_allclose(run(t)[0], 0.7 * np.abs(np.sin(t)), atol=1e-14)


@pytest.mark.parametrize("n", [2, 4, 6])
def test_equations_18_19_even_harmonics_grow_linearly_on_the_eigenset(n: int) -> None:
    run = pc.simulate(WALL, pc.sine(n), v0=1.0, max_impacts=200)

    k = np.arange(1, 201)
    gain = n / (n**2 - 1)
    np.testing.assert_allclose(run.impacts.t, math.pi * k, rtol=4e-16)
    np.testing.assert_allclose(run.impacts.v_after, 1.0 + 2.0 * gain * k, rtol=5e-14)
    t = np.linspace(0.0, 30.0, 301)
    flights = np.floor(t / math.pi)
    amplitude = (-1.0) ** flights * (1.0 + 2.0 * gain * flights + gain)
    expected = amplitude * np.sin(t) - np.sin(n * t) / (n**2 - 1)
    np.testing.assert_allclose(run(t)[0], expected, atol=1e-12)


def test_equations_20_21_third_harmonic_is_steady_above_its_critical_velocity() -> None:
    run = pc.simulate(WALL, pc.sine(3), v0=0.51, max_impacts=1000)

    assert abs(run.impacts.t - math.pi * np.arange(1, 1001)).max() <= 2 * math.ulp(1000 * math.pi)
    np.testing.assert_allclose(run.impacts.v_after, 0.51, rtol=1e-11)
    t = np.linspace(0.0, 9.0, 301)
    flights = np.floor(t / math.pi)
    expected = ((-1.0) ** flights * 0.51 + 3 / 8) * np.sin(t) - np.sin(3 * t) / 8
    np.testing.assert_allclose(run(t)[0], expected, atol=1e-14)


@pytest.mark.parametrize("n", [3, 5, 7, 9, 11, 13, 15])
def test_equations_24_26_the_eigenset_is_lost_below_the_critical_velocity(n: int) -> None:
    """V_max = (n - min sin(n u) / sin(u)) / (n^2 - 1), from the contact of both parts."""
    second_kind = np.polynomial.Chebyshev.basis(n).deriv() / n
    turning = second_kind.deriv().roots().real
    critical = (n - second_kind(turning).min()) / (n**2 - 1)

    above = pc.simulate(WALL, pc.sine(n), v0=critical + 1e-9, t_end=20.0)
    below = pc.simulate(WALL, pc.sine(n), v0=critical - 1e-9, t_end=20.0)

    np.testing.assert_allclose(above.impacts.t, math.pi * np.arange(1, 7), rtol=1e-14)
    # The dip is in the second flight.
    assert len(below.impacts) > 6
    assert below.impacts.t[0] == pytest.approx(math.pi, rel=1e-14)
    assert 0.1 < below.impacts.t[1] - math.pi < math.pi - 0.1


def test_equation_27_half_harmonic_from_rest_first_strikes_where_tan_t_is_t() -> None:
    run = pc.simulate(WALL, pc.sine(1), max_impacts=1)

    assert run.impacts.t[0] == pytest.approx(4.493409457909064, rel=4e-16)
    # v = t sin(t) / 2.
    assert run.impacts.v_before[0] == pytest.approx(
        4.493409457909064 * math.sin(4.493409457909064) / 2, rel=1e-15
    )


def test_equations_37_40_cosine_alternates_on_the_eigenset() -> None:
    run = pc.simulate(WALL, pc.cosine(1), v0=1.0, max_impacts=100)

    np.testing.assert_allclose(run.impacts.t, math.pi * np.arange(1, 101), rtol=1e-14)
    np.testing.assert_allclose(run.impacts.v_after[0::2], 1.0 + math.pi / 2, rtol=1e-12)
    np.testing.assert_allclose(run.impacts.v_after[1::2], 1.0, rtol=1e-11)


def test_equation_36_from_rest_touches_at_whole_periods_and_strikes_between() -> None:
    """V0 = 0: V alternates between pi/2 and 0, which is a tangency (or an impact of 1e-16)."""
    run = pc.simulate(WALL, pc.cosine(1), t_end=40.0)

    hard = run.impacts.t[run.impacts.v_after > 1e-6]
    soft = [*run.impacts.t[run.impacts.v_after <= 1e-6], *run.grazes.t]
    np.testing.assert_allclose(hard, math.pi * np.arange(1, 13, 2), rtol=1e-13)
    # A displacement of 1e-16 above a parabola is 1e-8 wide.
    np.testing.assert_allclose(
        np.unique(np.round(soft, 6)), np.round(math.tau * np.arange(1, 7), 6)
    )
