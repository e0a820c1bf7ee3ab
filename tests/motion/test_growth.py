"""The envelope's law, and whether its errors are honest."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.motion.growth import fit_power_law, peaks

ELASTIC = pc.impact_oscillator()


def test_the_main_resonance_grows_by_four_thirds_in_each_flight() -> None:
    run = pc.simulate(ELASTIC, pc.sine(2), t_end=5000.0)

    fitted = pc.growth(run)

    assert fitted.kind == "grows"
    assert fitted.exponent == pytest.approx(1.0, abs=1e-9)
    assert fitted.coefficient == pytest.approx(4 / 3 / math.pi, rel=1e-9)
    assert fitted.n_points > 700


@pytest.mark.parametrize("v0", ["0.51", "0.45"])
def test_steady_motions_are_bounded(v0: str) -> None:
    run = pc.simulate(ELASTIC, pc.sine(3), v0=v0, t_end=2000.0)

    for of in ("velocity", "displacement"):
        fitted = pc.growth(run, of)
        assert fitted.kind == "bounded"
        assert abs(fitted.exponent) <= max(3 * fitted.exponent_error, 1e-12)


def test_the_half_harmonic_grows_as_the_square_root() -> None:
    run = pc.simulate(ELASTIC, pc.sine(1), t_end=1e5)

    for of in ("velocity", "displacement"):
        late = pc.growth(run, of, since=1e4)
        assert late.kind == "grows"
        assert late.exponent == pytest.approx(0.5, abs=0.005)


def test_a_falling_power_decays_and_a_slight_one_is_bounded() -> None:
    t = np.linspace(1.0, 1000.0, 500)

    assert fit_power_law(t, 3.0 * t**-0.25).kind == "decays"
    assert fit_power_law(t, 3.0 * t**-0.001).kind == "bounded"


@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.99])
def test_errors_hold_for_correlated_peaks(correlation: float) -> None:
    """In 95 of 100 samples the exponent is within two errors; the simple formula fails that."""
    rng = np.random.default_rng(7)
    t = np.linspace(10.0, 1000.0, 600)
    hits = 0
    for _ in range(200):
        noise = np.zeros(600)
        for i, kick in enumerate(rng.normal(size=600)):
            noise[i] = correlation * noise[i - 1] + kick
        fitted = fit_power_law(t, np.sqrt(t) * np.exp(0.02 * noise))
        hits += abs(fitted.exponent - 0.5) < 2 * fitted.exponent_error
    assert 178 <= hits <= 199


def test_peaks_of_flights_are_exact() -> None:
    """With sin 3t and V0 = 0.51 flights rise to V0 + 1/2 and, between, to two lower maxima."""
    run = pc.simulate(ELASTIC, pc.sine(3), v0="0.51", t_end=30.0)

    times, heights = peaks(run, "displacement")

    np.testing.assert_allclose(heights[1::2], 1.01, rtol=1e-13)
    np.testing.assert_allclose(times[1::2], (2.5 + 2 * np.arange(len(times) // 2)) * math.pi)
    t = np.linspace(math.pi, 2 * math.pi, 1_000_001)
    assert heights[0] == pytest.approx(run(t)[0].max(), rel=1e-10)


def test_without_walls_the_edges_of_soft_stops_are_taken() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9.0), v0=1.0, t_end=100.0)

    fitted = pc.growth(run)

    assert fitted.kind == "bounded"
    assert fitted.coefficient == pytest.approx(1.0)


def test_few_peaks_tell_nothing() -> None:
    fitted = pc.growth(pc.simulate(ELASTIC, v0=1.0, t_end=10.0))

    assert fitted.kind == "too_few"
    assert math.isnan(fitted.exponent)
    assert pc.growth(pc.simulate(pc.Oscillator(), v0=1.0, t_end=10.0)).n_points == 0


def test_unknown_words_and_times_outside_are_refused() -> None:
    run = pc.simulate(ELASTIC, v0=1.0, t_end=100.0)
    with pytest.raises(pc.ParameterError, match="neither velocity"):
        pc.growth(run, "energy")  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match="since"):
        pc.growth(run, since=100.0)
