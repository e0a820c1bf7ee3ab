"""What a verdict rests on: derived, certified or numerical, with and without ball arithmetic."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.paper.test_report import outline, result, statement

import percuss as pc
from percuss.paper.claim import examine
from percuss.paper.claims.certain import eigenset_kept, impacts_at, limit_velocity
from percuss.paper.claims.evidence import WALL
from percuss.paper.collection import items, statement_with_id
from percuss.paper.report.page import page
from percuss.paper.statement import Check, Finding, grade

THEORY = Path(__file__).parents[2] / "docs" / "theory"

CERTAIN = Check("certain", 1.0, 1.0, radius=0.0)
FLOAT = Check("float", 1.0, 1.0)
WRONG = Check("wrong", 1.0, 2.0, 0.1, 0.05)
# They need nothing that only doubles tell.
# Those that fail, or hold with a correction, for certain.
CERTIFIED_OTHERWISE = {
    "periodicity-outside-range": "corrected",
    "periodicity-fig8b-slower": "corrected",
    "fig11-bilinear": "fails",
    "fig14": "fails",
    "fig14-numerics": "fails",
    "fig15": "fails",
}
# Those that a derivation proves, or that are general: what was computed is certain.
CERTAIN_CASES = {
    "eq1": "derived",
    "eq16": "derived",
    "eq2": "derived",
    "eq3-4": "numerical",
    "eq34": "numerical",
    "eq5": "derived",
    "eq6": "derived",
    "eigenset-sum": "derived",
    "multi-harmonics": "numerical",
    "periodicity-eigenset-alone": "derived",
    "periodicity-subsets-too": "derived",
    "resonance-odd": "derived",
}
CERTIFIED = (
    "eq9",
    "eq10",
    "eq17",
    "eq23",
    "fig10-accuracy",
    "fig11",
    "fig12",
    "not-sufficient",
    "periodicity-fig6b-times",
    "periodicity-fig8a-regular",
    "periodicity-fig8b-irregular",
    "table1",
    "table1-simulated",
    "table2",
    "table2-simulated",
)


@pytest.mark.parametrize(
    ("finding", "expected"),
    [
        (Finding((CERTAIN, CERTAIN)), "certified"),
        (Finding((CERTAIN, FLOAT)), "numerical"),
        # One certain disagreement refutes a form, whatever else is known.
        (Finding((FLOAT, WRONG)), "certified"),
        (Finding((CERTAIN, Check("float", 1.0, 2.0))), "numerical"),
        (Finding((WRONG,), (CERTAIN,), "so"), "certified"),
        (Finding((WRONG,), (FLOAT,), "so"), "numerical"),
        (Finding((Check("float", 1.0, 2.0),), (CERTAIN,), "so"), "numerical"),
        # Here it is the correction that fails, too: the printed form is refuted for certain.
        (Finding((WRONG,), (Check("float", 1.0, 2.0),), "so"), "certified"),
        (Finding((CERTAIN,), undecided="it is"), "numerical"),
        (Finding(()), "numerical"),
    ],
)
def test_the_grade_follows_from_the_comparisons_that_decide(
    finding: Finding, expected: str
) -> None:
    assert grade(finding) == expected


def test_a_proof_says_derived_unless_nothing_came_out() -> None:
    assert grade(Finding((FLOAT,)), proven=True) == "derived"
    assert grade(Finding((Check("nan", float("nan"), 1.0),)), proven=True) == "numerical"


def test_a_radius_counts_against_agreement_and_can_leave_it_open() -> None:
    inside = Check("a", 1.0, 1.05, 0.1, 0.02)
    open_check = Check("a", 1.0, 1.05, 0.1, 0.06)
    outside = Check("a", 1.0, 1.05, 0.01, 0.02)

    assert (inside.passed, inside.is_certain) == (True, True)
    assert (open_check.passed, open_check.is_certain) == (False, False)
    assert (outside.passed, outside.is_certain) == (False, True)


def test_every_proven_statement_names_its_proof() -> None:
    proven = [
        found
        for found in (statement_with_id(item) for item in items() if item.kind == "statement")
        if found.proven
    ]

    assert len(proven) > 20
    assert all((THEORY / found.theory).is_file() for found in proven)


@pytest.mark.parametrize("name", CERTIFIED)
def test_verdicts_that_ball_arithmetic_proves(name: str) -> None:
    (item,) = (one for one in items() if one.kind == "statement" and one.name == name)
    claim = examine(statement_with_id(item))

    assert (claim.kind, claim.grade) == ("holds", "certified")


@pytest.mark.parametrize("name", CERTIFIED_OTHERWISE)
def test_verdicts_against_the_paper_that_ball_arithmetic_proves(name: str) -> None:
    (item,) = (one for one in items() if one.kind == "statement" and one.name == name)
    claim = examine(statement_with_id(item))

    assert (claim.kind, claim.grade) == (CERTIFIED_OTHERWISE[name], "certified")


@pytest.mark.parametrize("name", CERTAIN_CASES)
def test_cases_of_general_statements_are_certain(name: str) -> None:
    (item,) = (one for one in items() if one.kind == "statement" and one.name == name)
    claim = examine(statement_with_id(item))

    every = (*claim.finding.printed, *claim.finding.corrected)
    assert claim.grade == CERTAIN_CASES[name]
    assert claim.kind != "fails"
    assert all(check.is_certain for check in every)


def test_a_general_statement_is_certain_by_a_refutation_alone() -> None:
    assert grade(Finding((CERTAIN,)), general=True) == "numerical"
    assert grade(Finding((WRONG,)), general=True) == "certified"
    assert grade(Finding((WRONG,), (CERTAIN,), "so"), general=True) == "numerical"
    assert grade(Finding((CERTAIN,)), general=True, proven=True) == "derived"


def test_a_start_that_leaves_the_eigenset_fails_the_check_that_it_keeps_to_it() -> None:
    below = eigenset_kept("below", pc.sine(3), "0.49", lambda: True)
    left = eigenset_kept("below", pc.sine(3), "0.49", lambda: False, kept=False)

    assert (below.passed, below.is_certain) == (False, True)
    assert (left.passed, left.is_certain) == (True, True)


def test_where_the_closed_form_does_not_hold_the_check_is_numerical() -> None:
    check = eigenset_kept("half-harmonic", pc.sine(1), "0.5", lambda: False)

    assert (check.passed, check.is_certain) == (False, False)


def test_impact_times_are_certain_to_what_is_asked_and_no_further() -> None:
    run = pc.simulate(WALL, pc.sine(2), v0=1, max_impacts=5)
    times = np.pi * np.arange(1, 6, dtype=np.float64)

    assert impacts_at("times", run, times).is_certain
    assert impacts_at("times", run, times).passed
    assert not impacts_at("times", run, times, tolerance=0.0).is_certain
    moved = impacts_at("times", run, times + 1e-9)
    assert (moved.passed, moved.is_certain) == (False, True)
    assert not impacts_at("too few", run, times[:3]).passed


def test_the_critical_velocity_is_a_ball_around_a_half() -> None:
    ball = limit_velocity(pc.sine(3), "0.1", 1)

    assert ball is not None
    assert ball.contains("0.5")
    assert ball.radius() < 1e-11


def test_the_page_says_what_each_verdict_rests_on(tmp_path: Path) -> None:
    claims = [
        statement("sure", Finding((CERTAIN,))),
        statement("seen", Finding((FLOAT,))),
    ]
    text = page(result(tmp_path, *claims))
    outline(text)

    assert [claim.grade for claim in claims] == ["certified", "numerical"]
    assert "The verdicts are 1 certified, 1 numerical." in text
    assert text.count('<span class="grade certified">certified</span>') == 2
    assert claims[0].record()["grade"] == "certified"
    assert 'title="proven in ball arithmetic"' in text.split('id="sure"')[1].split("</article>")[0]


WITHOUT = """
import sys
sys.modules["flint"] = None
from percuss.cli import main
sys.argv = ["percuss", "paper", "--out", sys.argv[1]]
main()
"""


def test_without_python_flint_the_report_is_refused_in_one_sentence(tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = subprocess.run(
        [sys.executable, "-c", WITHOUT, str(out)],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip

    assert found.returncode == 2
    assert found.stderr.split("\n")[0].endswith(
        "the report on the paper needs python-flint: install percuss[paper]"
    )
    assert not out.exists()


def test_a_certified_verdict_does_not_speak_of_floats() -> None:
    sure = statement("sure", Finding((CERTAIN,)))
    seen = statement("seen", Finding((FLOAT,)))

    assert sure.certainty.startswith("ball arithmetic")
    assert seen.certainty == "exact"
