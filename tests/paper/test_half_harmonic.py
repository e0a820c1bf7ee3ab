"""Verdicts and numbers of (27)-(35) and figs 10-12."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from tests.oracle.event_driven import simulate as simulate_precisely
from tests.oracle.from_model import problem_of

import percuss as pc
from percuss.paper.claims.half_harmonic import STATEMENTS
from percuss.paper.claims.half_harmonic_growth import envelope_factor, upper_peaks
from percuss.paper.statement import Finding, judge

BY_ID = {statement.id: statement for statement in STATEMENTS}


@cache
def finding(name: str) -> Finding:
    return BY_ID[name].find()


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("eq27", "holds"),
        ("eq28", "holds"),
        ("eq29", "holds with the correction tan xi = xi cos t_k / (cos t_k + 2 V_k + xi sin t_k)"),
        ("eq30", "holds with the correction a_k = cos t_k / (cos t_k + 2 V_k + xi_k sin t_k)"),
        ("eq31", "holds"),
        ("eq32", "holds with the correction V_{k+1} = V_k + (pi/2) [sin t_k + ((pi/2) cos t_k"),
        ("eq33", "holds with the correction V_{k+2} = V_k + (pi/2) sin(2 t_k) / V_k"),
        ("eq34", "holds with the correction dV/dt = sin(2 psi) / (4 V)"),
        ("eq35", "holds"),
        ("eq35-constant", "holds with the correction b = sqrt(sin(2 psi)/2)"),
        ("fig10", "holds with the correction velocities alternate"),
        ("fig10-accuracy", "holds"),
        ("fig11", "holds"),
        ("fig11-bilinear", "fails"),
        ("fig11-asymptotic", "holds with the correction b = sqrt(sin(2 psi)/2) = 0.590579848926"),
        ("fig12", "holds"),
    ],
)
def test_verdict(name: str, verdict: str) -> None:
    found = judge(finding(name))
    assert found == verdict if " " not in verdict else found.startswith(verdict)


def test_every_statement_has_its_verdict_tested() -> None:
    assert len(BY_ID) == len(STATEMENTS) == 16


def test_printed_forms_fail_by_far() -> None:
    for name in ("eq29", "eq30", "eq33", "eq34"):
        worst = max(abs(check.difference) / check.tolerance for check in finding(name).printed)
        assert worst > 1e2, name


def test_printed_velocity_is_wrong_by_its_own_first_order() -> None:
    (printed,), (corrected,) = finding("eq32").printed, finding("eq32").corrected
    assert abs(printed.measured - 1.0) < 0.01
    assert abs(corrected.measured - 2.0) < 0.01


def test_constants_of_the_envelope() -> None:
    others = [check.measured for check in finding("eq35-constant").printed]
    np.testing.assert_allclose(others, [0.692344412716, 0.299436581762, 0.095225798693], atol=2e-12)
    assert abs(finding("fig11-asymptotic").printed[0].measured - 0.590579848926) < 1e-12


def test_factors_of_the_pictures() -> None:
    assert abs(finding("fig11").printed[0].measured - 0.6088) < 1e-4
    assert abs(finding("fig11-bilinear").printed[0].measured - 0.6044) < 1e-4
    assert abs(finding("fig10").printed[0].measured - 0.6442) < 1e-4


def test_peaks_are_those_of_the_closed_form() -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=2.0, t_end=40.0)
    t, height = upper_peaks(run)
    assert len(t) == 11
    np.testing.assert_allclose(height, 2.0, rtol=1e-12)
    np.testing.assert_allclose(t, math.pi * (np.arange(11) + 1.5), atol=1e-6)


def test_contacts_with_a_soft_stop_have_no_upper_peaks() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=4.0), v0=2.0, t_end=40.0)
    t, height = upper_peaks(run)
    np.testing.assert_allclose(height, 2.0, rtol=1e-12)
    np.testing.assert_allclose(np.diff(t), 1.5 * math.pi, atol=1e-6)


def test_factor_of_an_exact_root_law_is_recovered() -> None:
    t = np.arange(1.0, 101.0)
    lower = np.where(np.arange(100) % 2 == 1, 1.0, 0.8)
    factor, error = envelope_factor(t, 0.6 * np.sqrt(t) * lower)
    assert abs(factor - 0.6) < 1e-14
    assert error < 1e-14


@pytest.mark.parametrize("name", ["limit", "stiff"])
def test_shadow_run_with_many_digits_confirms_figs_10_and_11(name: str) -> None:
    """Up to t = 120; the whole figure in the nightly run below."""
    compare_with_many_digits(name, 120.0)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["limit", "stiff"])
def test_shadow_run_of_the_whole_figure(name: str) -> None:
    compare_with_many_digits(name, 400.0)


def compare_with_many_digits(name: str, t_end: float) -> None:
    osc = {
        "limit": pc.impact_oscillator(),
        "stiff": pc.bilinear_oscillator(stiffness_above=1, stiffness_below=400_000_000),
    }[name]
    run = pc.simulate(osc, pc.sine(1), v0=0, t_end=t_end)
    shadow = simulate_precisely(problem_of(osc, pc.sine(1)), 0, 0, t_end=t_end, digits=20)
    precise = shadow.impacts.t if name == "limit" else shadow.crossings.t
    found = run.impacts.t if name == "limit" else run.crossings.t

    np.testing.assert_allclose(found, np.array([float(t) for t in precise]), rtol=0, atol=2e-13)
