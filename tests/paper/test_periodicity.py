"""Verdicts and numbers of the statements in words: third harmonic, sets of times, chaos."""

from __future__ import annotations

import importlib
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from tests.oracle.event_driven import simulate as exact_simulate
from tests.oracle.from_model import problem_of
from tests.paper.findings import finding
from tests.paper.numbers_of import numbers

import percuss as pc
from percuss.paper.claims.divergence import AFTER, CHAOTIC, STEP, growth_rate, separation
from percuss.paper.claims.periodicity import STATEMENTS
from percuss.paper.claims.third_harmonic_family import (
    STIFFNESSES,
    bilinear_run,
    critical_velocities,
    impact_times,
    speed_errors,
    stepped,
)
from percuss.paper.claims.third_harmonic_lines import lines, share_between_lines
from percuss.paper.evidence import Comparison, Deduction, Enclosure
from percuss.paper.statement import Finding, grade, verdict_kind

WALL = pc.impact_oscillator()
SINE3 = problem_of(WALL, pc.sine(3))

VERDICTS = {
    "periodicity-fig6b-times": "holds",
    "periodicity-fig6b-lost": "fails",
    "periodicity-outside-range": "holds with",
    "periodicity-fig6b-bilinear": "holds",
    "periodicity-fig8a-regular": "holds",
    "periodicity-fig8b-irregular": "holds",
    "periodicity-fig8b-slower": "holds with",
    "periodicity-resonance-sets": "holds",
    "periodicity-subharmonic": "holds with",
    "periodicity-subsets-too": "holds",
    "periodicity-eigenset-alone": "holds with",
    "periodicity-cos-and-sin": "holds",
    "periodicity-phase": "holds with",
    "periodicity-chaos": "holds",
    "poincare-maps": "holds with",
}


@pytest.fixture(scope="module")
def findings() -> dict[str, Finding]:
    return {statement.id: finding(statement.id) for statement in STATEMENTS}


def check_of(finding: Finding, part: str) -> Comparison:
    (check,) = (c for c in (*finding.printed, *finding.corrected) if part in c.what)
    assert not isinstance(check, Deduction)
    return check


def test_every_statement_has_the_verdict_that_its_evidence_gives(
    findings: dict[str, Finding],
) -> None:
    verdicts = {name: verdict_kind(finding) for name, finding in findings.items()}

    assert set(verdicts) == set(VERDICTS)
    for name, expected in VERDICTS.items():
        assert verdicts[name] == ("corrected" if expected == "holds with" else expected), name


def test_what_the_verdicts_on_the_third_harmonic_rest_on(findings: dict[str, Finding]) -> None:
    expected = {
        "fig6b-times": "deduced",
        "fig6b-lost": "deduced",
        "outside-range": "certified",
        "fig6b-bilinear": "measured",
        "fig8a-regular": "certified",
        "fig8b-irregular": "certified",
        "fig8b-slower": "certified",
    }
    grades = {name: grade(findings[f"periodicity-{name}"]) for name in expected}
    assert grades == expected


def test_figure_6b_repeats_in_thirty_digits() -> None:
    """The oracle shares no code with percuss; its impacts follow the closed form to 25 digits."""
    exact = exact_simulate(SINE3, 0, "0.45", t_end=30 * math.pi, digits=30)
    run = pc.simulate(WALL, pc.sine(3), v0="0.45", t_end=30 * math.pi)

    with mp.workdps(30):
        short = mp.asin(mp.sqrt(mp.mpf("0.9")))
        pattern = [0, short, mp.pi + short, 2 * mp.pi - short, 3 * mp.pi - short, 3 * mp.pi]
        for k, time in enumerate(exact.impacts.t[:42]):
            assert abs(time - (4 * (k // 6) + 1) * mp.pi - pattern[k % 6]) < 1e-25
    times = np.array([float(t) for t in exact.impacts.t])
    assert np.abs(times - run.impacts.t).max() < 1e-13


def test_the_family_is_derived_without_a_mistake() -> None:
    sp: Any = importlib.import_module("sympy")
    s, v, c = sp.symbols("s V c", positive=True)
    second = sp.sin(s) * (v - sp.sin(s) ** 2 / 2)
    assert sp.simplify(sp.diff(second, s, 2) + second + sp.sin(3 * s)) == 0
    assert second.subs(s, 0) == 0
    assert sp.diff(second, s).subs(s, 0) == v
    ends = sp.solve(8 * (1 - c) * c - 1, c)
    velocities = sorted(float((1 - end**2) / 2) for end in ends)
    np.testing.assert_allclose(velocities, critical_velocities(), rtol=1e-14)


@pytest.mark.parametrize("v0", [0.14, 0.25, 0.45, 0.489])
def test_six_impacts_fill_four_pi_inside_the_range(v0: float) -> None:
    times = pc.simulate(WALL, pc.sine(3), v0=v0, t_end=40.5 * math.pi).impacts.t

    np.testing.assert_allclose(times, impact_times(v0, 10), atol=1e-11)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_beyond_the_ends_of_the_range_the_times_are_others(side: float) -> None:
    end = critical_velocities()[0 if side < 0 else 1]
    for offset, same in ((-1e-7, True), (1e-7, False)):
        v0 = end + side * offset
        times = pc.simulate(WALL, pc.sine(3), v0=v0, t_end=40.5 * math.pi).impacts.t
        expected = impact_times(v0, 10)
        assert (len(times) == 60 and bool(np.abs(times - expected).max() < 1e-9)) == same


@pytest.mark.parametrize("v0", ["0.45", "0.51"])
def test_lines_follow_from_the_impacts_alone(v0: str) -> None:
    """(w^2 - 1) times a line is 4/P times the sum of V_k exp(-i w t_k), except at w = 1 and 3."""
    run = pc.simulate(WALL, pc.sine(3), v0=v0, t_end=8 * math.pi - 0.1)
    chosen = run.impacts.t > 4 * math.pi - 0.1
    t, v = run.impacts.t[chosen], run.impacts.v_after[chosen]
    omega, amplitude = lines(v0)
    used = (omega > 0) & (omega != 1) & (omega != 3) & (omega < 100)
    total = np.abs(np.exp(-1j * np.multiply.outer(omega[used], t)) @ v)

    expected = total / math.pi / np.abs(omega[used] ** 2 - 1)
    np.testing.assert_allclose(amplitude[used], expected, atol=1e-14)


def test_numbers_of_the_spectra(findings: dict[str, Finding]) -> None:
    slower = findings["periodicity-fig8b-slower"]
    above, below, _ = (check.value for check in numbers(slower.corrected))
    assert above == pytest.approx(-2.0, abs=0.01)
    assert below == pytest.approx(-2.0, abs=0.06)
    ratios = [check.value for check in numbers(slower.printed)]
    assert ratios == pytest.approx([0.973, 0.807], abs=1e-3)
    assert check_of(slower, "bounds").value == pytest.approx(0.99923, abs=1e-5)
    assert "57 lines instead of 21" in findings["periodicity-fig8b-irregular"].remark


def test_power_between_the_lines_comes_from_stiffness_and_steps() -> None:
    limit = share_between_lines(pc.simulate(WALL, pc.sine(3), v0="0.45", t_end=30 * math.pi))
    stiff, soft = (share_between_lines(bilinear_run(k)) for k in STIFFNESSES.values())
    plain = share_between_lines(stepped(4e8, 0.0).x)
    fine = share_between_lines(stepped(4e8, 1e-9).x)

    assert limit < 1e-20
    assert 1e-6 < stiff < 1e-4
    assert 0.1 < soft < 1.0
    assert 0.1 < plain < 1.0
    # With an error test the steps give back what the equation itself has.
    assert fine == pytest.approx(stiff, rel=0.05)


def test_steps_as_long_as_a_contact_change_the_speed() -> None:
    assert speed_errors(stepped(4e8, 0.0)) > 0.1
    assert speed_errors(stepped(4e8, 1e-9)) < 1e-3


@pytest.mark.parametrize("stiffness", STIFFNESSES.values())
def test_the_bilinear_motion_drifts_in_thirty_digits_as_well(stiffness: float) -> None:
    """What looks irregular in the bilinear motion is no rounding."""
    osc = pc.bilinear_oscillator(stiffness_below=stiffness)
    exact = exact_simulate(problem_of(osc, pc.sine(3)), 0, "0.45", t_end=30, digits=30)
    run = bilinear_run(stiffness)

    times = np.array([float(t) for t in exact.crossings.t])
    assert np.abs(times - run.crossings.t[: len(times)]).max() < 1e-12


def test_in_chaos_doubles_part_from_forty_digits_as_two_runs_part() -> None:
    """The estimate by two runs is the error of a run, within a factor of a hundred."""
    t_end = 90 * math.pi
    exact = exact_simulate(SINE3, 0, CHAOTIC, t_end=t_end, digits=40)
    run = pc.simulate(WALL, pc.sine(3), v0=CHAOTIC, t_end=t_end)
    estimate = 1e-16 * separation(WALL, pc.sine(3), CHAOTIC, 1e-12, t_end)
    t = np.arange(1, 90) * math.pi + AFTER
    true = np.array([[float(value) for value in exact(time)] for time in t])
    x, v = run(t)
    error = np.hypot(x - true[:, 0], v - true[:, 1])

    # Up to there the difference of the two runs, 1e4 times the estimate, is still small.
    early = slice(5, 60)
    assert (1e4 * estimate[early]).max() < 0.01
    assert (error[early] < 100 * estimate[early]).all()
    assert (error[early] > estimate[early] / 100).all()
    # Then nothing of the motion is left.
    assert error[:60].max() < 1e-6
    assert error[72:].max() > 0.01


def test_the_growth_of_differences_at_the_two_velocities(findings: dict[str, Finding]) -> None:
    chaotic = separation(WALL, pc.sine(3), CHAOTIC, STEP, 120 * math.pi)
    rate, error = growth_rate(chaotic)
    assert rate > 5 * error > 0
    regular = separation(WALL, pc.sine(3), 0.45, 1e-9, 3000 * math.pi)
    assert regular.max() < 10
    assert math.isnan(growth_rate(regular)[0])
    found = findings["periodicity-chaos"]
    assert found.remark
    # Without rounding they part as well.
    enclosures = [one for one in found.printed if isinstance(one, Enclosure)]
    proven = [one for one in enclosures if "without rounding" in one.what]
    assert len(proven) == 3
    assert 0.1802 < check_of(found, "topological entropy").value < 0.1803


@pytest.mark.nightly
def test_differences_grow_without_rounding_as_another_program_has_it(
    findings: dict[str, Finding],
) -> None:
    found = findings["periodicity-chaos"]
    enclosures = [one for one in found.printed if isinstance(one, Enclosure)]
    proven = [one for one in enclosures if "without rounding" in one.what]
    t_end = 120 * math.pi
    exact = [exact_simulate(SINE3, 0, v0, t_end=t_end, digits=40) for v0 in (0.49, 0.49 + STEP)]
    times = np.arange(1, 119) * math.pi + AFTER
    apart = [abs(float(exact[0](t)[0] - exact[1](t)[0])) for t in times]
    growth = next(one.value for one in proven if "0.49:" in one.what)
    assert growth == pytest.approx(max(apart) / (0.49 + STEP - 0.49), rel=1e-6)


def test_the_half_harmonic_approaches_a_shifted_eigenset(findings: dict[str, Finding]) -> None:
    found = findings["periodicity-subharmonic"]
    rate = check_of(replace(found, corrected=()), "t^-p")
    assert rate.value == pytest.approx(0.5, abs=0.001)
    # The phase at which growth and drift balance, from docs/theory/half-harmonic.md.
    run = pc.simulate(WALL, pc.sine(1), t_end=1e6)
    ahead = run.impacts.t[-2:] - math.pi * np.arange(len(run.impacts) - 1, len(run.impacts) + 1)
    assert ahead.mean() == pytest.approx(1.18480, abs=1e-5)


def test_of_all_phases_only_the_extremes_of_the_force_are_steady(
    findings: dict[str, Finding],
) -> None:
    found = findings["periodicity-phase"]
    assert check_of(found, "phases that grow, of 24").value == 24.0
    assert check_of(found, "phase 0.01").value == pytest.approx(0.5, abs=0.02)
