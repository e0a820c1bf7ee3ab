"""Verdicts and numbers of (27)-(35) and figs 10-12."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from tests.motion.test_half_harmonic import precise_impact
from tests.oracle.event_driven import simulate as simulate_precisely
from tests.oracle.from_model import problem_of
from tests.paper.findings import finding
from tests.paper.numbers_of import difference, numbers
from tests.paper.test_article import TEXT

import percuss as pc
from percuss.paper.chain import LINES
from percuss.paper.claims import cosine_formulas, half_harmonic_formulas, poincare
from percuss.paper.claims.certain_growth import growth_bounds
from percuss.paper.claims.half_harmonic import STATEMENTS
from percuss.paper.claims.half_harmonic_figures import envelope_factor, upper_peaks
from percuss.paper.claims.half_harmonic_growth import (
    SUBHARMONIC_STATEMENTS,
    late_growth,
    limit_constant,
)
from percuss.paper.collection import items
from percuss.paper.dependence import DEPENDS, falls_with
from percuss.paper.evidence import Deduction
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding, grade, verdict_kind

BY_ID = {
    statement.id: statement
    for statement in (*STATEMENTS, *SUBHARMONIC_STATEMENTS, *poincare.STATEMENTS)
}


def perturbed(name: str, *args: object, **kwargs: object) -> Finding:
    """Return the finding with other printed input."""
    find: Callable[..., Finding] = BY_ID[name].find
    return find(*args, **kwargs)


VERDICTS = {
    "eq27": ("holds", "deduced"),
    "eq28": ("holds", "deduced"),
    "eq29": ("corrected", "deduced"),
    "eq30": ("corrected", "deduced"),
    "eq31": ("holds", "deduced"),
    "eq32": ("corrected", "deduced"),
    "eq33": ("corrected", "deduced"),
    "eq34": ("corrected", "deduced"),
    "chain": ("corrected", "deduced"),
    "large-times": ("corrected", "deduced"),
    "eq35": ("holds", "deduced"),
    "eq35-constant": ("corrected", "deduced"),
    "fig10": ("holds", "measured"),
    "fig10-accuracy": ("holds", "measured"),
    "accuracy-argument": ("fails", "deduced"),
    "fig11": ("holds", "measured"),
    "fig11-bilinear": ("holds", "measured"),
    "fig11-asymptotic": ("corrected", "measured"),
    "fig12": ("holds", "certified"),
    "fig13": ("holds", "measured"),
    "periodicity-subharmonic": ("corrected", "deduced"),
    "poincare-maps": ("corrected", "measured"),
}


@pytest.mark.parametrize("name", VERDICTS)
def test_verdict(name: str) -> None:
    found = finding(name)
    assert (verdict_kind(found), grade(found)) == VERDICTS[name]


def test_every_statement_has_its_verdict_tested() -> None:
    assert BY_ID.keys() == VERDICTS.keys()


def test_printed_forms_fail_by_far() -> None:
    for name in ("eq29", "eq30", "eq33", "eq34"):
        worst = max(
            abs(difference(check)) / (0.5 * (check.high - check.low))
            for check in numbers(finding(name).printed)
        )
        assert worst > 1e2, name


def test_printed_velocity_is_wrong_by_its_own_first_order() -> None:
    (printed,) = numbers(finding("eq32").printed)
    (corrected,) = numbers(finding("eq32").corrected)
    assert abs(printed.value - 1.0) < 0.01
    # With a_k of (30) in place of its first term the next order bends the power by 0.011.
    assert abs(corrected.value - 2.0) < 0.02


def test_the_rate_of_growth_is_that_of_forty_digits() -> None:
    with mpmath.workdps(40):
        t, v = mpmath.mpf(7) / 10, mpmath.mpf(10) ** 6
        later, after = precise_impact(*precise_impact(t, v))
        rate = float(v * (after - v) / (later - t))
    found = numbers(finding("eq34").corrected)[0]
    assert abs(found.value - rate) < 1e-14
    assert round(rate, 7) == 0.2463624
    printed = [check.value - difference(check) for check in numbers(finding("eq34").printed)]
    np.testing.assert_allclose(printed, [0.3136784, 0.4927249], atol=1e-6)


def test_the_proof_of_growth_agrees_with_many_digits() -> None:
    """Bounds of two impacts enclose what they do, and are not far from it."""
    for v in (30, 300):
        bounds = growth_bounds(Fraction(49, 50), Fraction(69, 50), Fraction(v))
        for phase in (0.99, 1.18, 1.37):
            with mpmath.workdps(40):
                t, speed = mpmath.mpf(phase), mpmath.mpf(v)
                later, after = precise_impact(*precise_impact(t, speed))
                drift = abs(float((later - t - 2 * mpmath.pi) * speed**3))
                gain = float(after**2 - speed**2)
            assert float(bounds.drift) >= drift
            assert float(bounds.gain) <= gain
        assert float(bounds.drift) < 3.0
        assert float(bounds.gain) > 0.5


def test_the_enclosed_limit_of_the_phase_holds_that_of_a_long_run() -> None:
    for v0 in (0.0, 1.0):
        late = late_growth(v0)
        assert late is not None
        assert late.stays
        assert abs(limit_constant(v0)[2] - float(late.limit.mid())) < float(late.limit.rad()) < 0.1
        narrow = replace(late, high=late.low + Fraction(1, 10))
        assert not narrow.stays


def test_a_box_that_no_bound_reaches_is_refused() -> None:
    with pytest.raises(ArithmeticError, match="not shown to end near pi"):
        growth_bounds(Fraction(0), Fraction(7), Fraction(1, 2))


def test_a_motion_with_loss_fails_the_check_of_growth() -> None:
    for restitution in ("0.9999", "0.999"):
        found = perturbed("eq27", restitution)
        assert verdict_kind(found) == "fails"
        proof, rate, positive = found.printed
        assert (proof.outcome, rate.outcome, positive.outcome) == ("open", "differs", "agrees")


def test_the_time_of_two_impacts_exceeds_two_periods_by_the_third_order() -> None:
    values = [check.value for check in numbers(finding("large-times").corrected)]
    np.testing.assert_allclose(values, [9.195559e-3, 9.297570e-5], rtol=1e-6)


def test_impact_times_approach_a_shifted_eigenset() -> None:
    shift = numbers(finding("periodicity-subharmonic").corrected)[-1].value
    assert abs(shift - 1.18480) < 5e-6
    # Numbers alone do not tell this limit from psi.
    refuted, *measured = perturbed("periodicity-subharmonic", 1.1848).printed
    assert refuted.outcome == "open"
    assert {check.outcome for check in measured} == {"agrees"}


def test_constants_of_the_envelope() -> None:
    others = [check.value for check in numbers(finding("eq35-constant").printed)]
    np.testing.assert_allclose(others, [0.692344412716, 0.299436581762, 0.095225798693], atol=2e-12)
    assert abs(numbers(finding("fig11-asymptotic").printed)[0].value - 0.590579848926) < 1e-12


def test_factors_of_the_pictures() -> None:
    for name, factors in (
        ("fig11", (0.6088, 0.6096, 0.5960, 0.6055)),
        ("fig11-bilinear", (0.6044, 0.6063, 0.5920, 0.6004)),
    ):
        found = [check.value for check in numbers(finding(name).printed)]
        np.testing.assert_allclose(found, factors, atol=6e-5)
    assert "The fitted factor is 0.6442." in finding("fig10").remark


def test_a_fit_by_eye_is_refuted_beyond_the_spread_of_estimators_alone() -> None:
    for printed, kind in ((0.60, "holds"), (0.61, "holds"), (0.64, "fails"), (0.57, "fails")):
        assert verdict_kind(perturbed("fig11-bilinear", printed=printed)) == kind, printed


def test_the_growth_that_the_stroboscopic_map_shows() -> None:
    rate = numbers(finding("poincare-maps").corrected)[0].value
    assert abs(rate - 0.590579848926**2) < 1e-4


def test_the_chain_breaks_at_33_and_names_what_falls_with_it() -> None:
    follows = {line.record: line.follows for line in LINES}
    assert [record for record, does in follows.items() if not does] == [
        "eq29",
        "eq32",
        "eq33",
        "eq34",
    ]
    assert [line.record for line in LINES if line.is_break] == ["eq33"]
    assert {"eq34", "eq35", "fig11", "fig14", "accuracy-argument"} <= set(falls_with("eq33"))
    assert not {"eq27", "eq31", "periodicity-subharmonic"} & set(falls_with("eq33"))


def test_the_printed_33_is_the_right_32_twice_without_the_shift_of_the_phase() -> None:
    (line,) = (line for line in LINES if line.is_break)
    assert "left out" in line.deduction.steps[-1].text
    assert all(step.holds for step in line.deduction.steps)


def test_the_graph_names_statements_that_are_there() -> None:
    assert {item.name for item in items() if item.kind == "statement"} >= DEPENDS.keys()
    for needs in DEPENDS.values():
        assert DEPENDS.keys() >= set(needs)


def test_steps_of_all_deductions_hold_and_are_shown() -> None:
    for name in VERDICTS:
        for item in (*finding(name).printed, *finding(name).corrected):
            for step in item.steps if isinstance(item, Deduction) else ():
                assert step.holds, (name, step.text)
                assert step.formula or step.by in ("theorem", "argument"), (name, step.text)


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


def test_formulas_show_what_the_text_shows() -> None:
    if TEXT not in os.environ:
        pytest.skip(f"{TEXT} names no text of the article")
    text = re.sub(r"\n+", " ", Path(os.environ[TEXT]).read_text(encoding="utf-8"))
    for module in (half_harmonic_formulas, cosine_formulas):
        for name, formula in vars(module).items():
            assert not isinstance(formula, Formula) or formula.shown in text, name
