"""How fast intervals come to the eigenset's spacing."""

from __future__ import annotations

import math

import pytest

import percuss as pc

ELASTIC = pc.impact_oscillator()


@pytest.mark.parametrize("t_end", [1e4, 1e6])
def test_intervals_of_the_half_harmonic_approach_as_the_inverse_root(t_end: float) -> None:
    run = pc.simulate(ELASTIC, pc.sine(1), t_end=t_end)

    approach = pc.classify_impact_times(run)

    assert approach.kind == "approaching_eigenset"
    assert approach.rate == pytest.approx(0.5, abs=0.005)


def test_a_resonance_started_out_of_phase_approaches_as_the_inverse_square() -> None:
    run = pc.simulate(ELASTIC, pc.cosine(2), v0="0.3", t_end=1e4)

    approach = pc.classify_impact_times(run)

    assert approach.kind == "approaching_eigenset"
    assert approach.rate == pytest.approx(2.0, abs=0.02)


def test_the_rate_of_given_times_is_that_of_their_law() -> None:
    times = [0.0, math.pi]
    while len(times) < 20_000:
        times.append(times[-1] + math.pi + 0.3 * times[-1] ** -0.7)

    assert pc.classify_impact_times(times, ELASTIC).rate == pytest.approx(0.7, abs=0.002)


def test_other_kinds_have_no_rate() -> None:
    for v0 in ("0.45", "0.51"):
        run = pc.simulate(ELASTIC, pc.sine(3), v0=v0, t_end=400.0)
        assert math.isnan(pc.classify_impact_times(run).rate)


def test_a_transient_to_a_period_of_the_same_spacing_is_no_approach_for_ever() -> None:
    """After the transient intervals differ from pi by rounding alone."""
    run = pc.simulate(pc.impact_oscillator(0.7), pc.sine(2), v0=1.0, t_end=2000.0)

    assert pc.classify_impact_times(run).kind in ("periodic", "eigenset")


def test_a_wandering_motion_is_no_approach() -> None:
    """omega = 14/5: long stretches near the eigenset, and none that ends in it."""
    for t_end in (1e3, 1e4, 1e5):
        run = pc.simulate(ELASTIC, pc.sine("2.8"), v0="0.3", t_end=t_end)
        assert pc.classify_impact_times(run).kind == "no_period_found"
