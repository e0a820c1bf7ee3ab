"""From bilinear to rigid: verdicts, orders with their constants, and what the limit loses."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from tests.paper.findings import finding

import percuss as pc
from percuss.paper.claims.bilinear_limit import (
    STIFFNESSES,
    bilinear_run,
    bilinear_saturation,
    first_delays,
    graze,
    graze_error,
    half_harmonic_saturation,
    impact_run,
    local_orders,
    saturation_speed,
    time_errors,
)
from percuss.paper.claims.limits import GRAZES, STATEMENTS
from percuss.paper.claims.off_resonance import (
    damped_deviation,
    kinds_from_rest,
    periodic_speed,
    periodic_start,
)
from percuss.paper.figures.limit_figures import FIGURES, limit_of_stiffness
from percuss.paper.statement import Statement, judge

VERDICTS = {
    "fig2-intervals": "holds with the correction the intervals come closer",
    "commensurate-off-resonance": "holds with the correction without damping",
    "smoothed-converges": "holds",
    "smoothed-grazing": "holds",
    "smoothed-in-time": "holds",
    "smoothed-and-stiff": "holds",
    "bilinear-limit": "holds",
    "bilinear-limit-grazing": "holds",
    "bilinear-saturation": "holds",
    "bilinear-saturation-half": "holds",
}


@pytest.mark.parametrize("statement", STATEMENTS, ids=lambda statement: statement.id)
def test_the_verdict_of_each_statement(statement: Statement) -> None:
    verdict, expected = judge(finding(statement.id)), VERDICTS[statement.id]
    assert verdict.startswith(expected)
    assert expected != "holds" or verdict == "holds"


def test_the_first_impact_does_not_know_the_stiffness() -> None:
    for stiffness in STIFFNESSES[1:]:
        assert time_errors(stiffness)[0] == 0.0


def test_impact_times_tend_to_the_limit_as_the_root_with_derived_constants() -> None:
    predicted = first_delays(impact_run())
    for stiffness in STIFFNESSES[-3:]:
        measured = time_errors(stiffness) * math.sqrt(stiffness)
        # The error of the first order is of the first order itself, and grows with the delays.
        assert np.abs(measured[1:6] / predicted[1:6] - 1.0).max() < 60.0 / math.sqrt(stiffness)


def test_displacements_tend_to_the_limit_as_the_root() -> None:
    times = np.array([1.0, 4.0, 8.0, 12.0])
    stiffnesses = np.array([1e8, 1e10, 1e12])
    errors = np.array(
        [bilinear_run(float(k))(times)[0] - impact_run()(times)[0] for k in stiffnesses]
    )
    assert np.abs(errors[:, 0]).max() == 0.0  # before the first impact
    for column in errors[:, 1:].T:
        assert local_orders(stiffnesses, column) == pytest.approx([-0.5, -0.5], abs=1e-3)


def test_without_a_force_the_delays_are_those_of_the_bilinear_eigenset() -> None:
    stiffness = 1e6
    osc = pc.bilinear_oscillator(stiffness_below=stiffness)
    late = pc.eigenset(osc, 5) - pc.eigenset(pc.impact_oscillator(), 5)
    assert late * math.sqrt(stiffness) == pytest.approx(math.pi * np.arange(5), abs=1e-8)


def test_a_graze_halves_the_order_on_the_side_that_arrives_too_low() -> None:
    large = np.array([1e10, 1e12, 1e14])
    low, high = graze(*GRAZES["low"]), graze(*GRAZES["high"])
    below = np.array([graze_error(low, float(k)) for k in large])
    above = np.array([graze_error(high, float(k)) for k in large])
    assert local_orders(large, below)[-1] == pytest.approx(-0.25, abs=1e-3)
    assert local_orders(large, above)[-1] == pytest.approx(-0.5, abs=1e-5)
    ratio = below / np.array([low.predicted(float(k)) for k in large])
    # The next term falls as k-^(-1/4).
    root = 10.0**0.5
    assert (root * ratio[2] - ratio[1]) / (root - 1.0) == pytest.approx(1.0, abs=1e-4)
    assert high.predicted(1e8) == 0.0


@pytest.mark.parametrize("n", [2, 4, 6])
def test_for_finite_stiffness_an_even_harmonic_beats(n: int) -> None:
    speed, time = bilinear_saturation(n, 1e8)
    assert speed == pytest.approx(saturation_speed(n, 1e8), rel=1e-5)
    assert time == pytest.approx(math.pi / n * 1e4, rel=1e-3)


def test_for_finite_stiffness_the_half_harmonic_ends() -> None:
    assert 0.3 < half_harmonic_saturation(1e6) ** 2 / 1e3 < 0.5


def test_a_periodic_motion_exists_off_resonance_in_closed_form() -> None:
    assert periodic_speed(2.02) == pytest.approx(20.8717740486, rel=1e-11)
    for text in ("2.001", "2.02", "2.2"):
        assert periodic_start(Fraction(text), 0.0) < 1e-10
        assert periodic_start(Fraction(text), 0.1) > 1e-7


def test_figure_two_has_no_period_from_rest_in_any_phase() -> None:
    kinds, last = kinds_from_rest()
    assert set(kinds) == {"no_period_found"}
    assert last == pytest.approx([1.005] * 8, abs=5e-4)


def test_damping_makes_the_intervals_commensurate() -> None:
    assert damped_deviation(0.05) < 1e-11
    assert damped_deviation(0.01) < 1e-11


def test_the_figure_shows_the_orders() -> None:
    data = limit_of_stiffness()
    k = data.stiffness.values[-2:]
    assert local_orders(k, data.delay.values[-2:, 0])[0] == pytest.approx(-0.5, abs=1e-3)
    assert local_orders(k, data.jump.sel(graze="low").values[-2:])[0] == pytest.approx(
        -0.25, abs=2e-3
    )
    assert [figure.name for figure in FIGURES] == ["limit-stiff", "limit-smoothed"]
