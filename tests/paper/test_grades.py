"""What a verdict rests on: deduced, certified or measured, with and without ball arithmetic."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.paper.test_report import outline, result, statement

import percuss as pc
from percuss.paper.claim import examine
from percuss.paper.claims.certain import impacts_at, limit_velocity
from percuss.paper.claims.comparisons import WALL
from percuss.paper.collection import items, statement_with_id
from percuss.paper.evidence import Deduction, Step, compare, is_decided, is_proven
from percuss.paper.report.page import page
from percuss.paper.statement import Finding, grade, judge, verdict_kind

THEORY = Path(__file__).parents[2] / "docs" / "theory"

CERTAIN = compare("certain", 1.0, 1.0, radius=0.0)
PROOF = Deduction("all cases", (Step("a step", "1 = 1", True, "algebra"),))
BROKEN = Deduction("all cases", (Step("a step", "1 = 2", False, "algebra"),))
REFUTATION = Deduction("a counterexample", PROOF.steps, "differs")
FLOAT = compare("float", 1.0, 1.0)
WRONG = compare("wrong", 1.0, 2.0, 0.1, 0.05)
# They need nothing that only doubles tell.
# Those that fail, or hold with a correction, for certain.
CERTIFIED_OTHERWISE = {
    "periodicity-outside-range": "corrected",
    "fig2-intervals": "corrected",
    "periodicity-fig8b-slower": "corrected",
    "fig14": "fails",
    "fig15": "fails",
}
CERTIFIED = (
    "fig12",
    "periodicity-fig8a-regular",
    "periodicity-fig8b-irregular",
    "table1",
    "table1-simulated",
    "table2",
)


@pytest.mark.parametrize(
    ("finding", "expected"),
    [
        (Finding((CERTAIN, CERTAIN)), "certified"),
        (Finding((CERTAIN, FLOAT)), "measured"),
        # One certain disagreement refutes a form, whatever else is known.
        (Finding((FLOAT, WRONG)), "certified"),
        (Finding((CERTAIN, compare("float", 1.0, 2.0))), "measured"),
        (Finding((WRONG,), (CERTAIN,), "so"), "certified"),
        (Finding((WRONG,), (FLOAT,), "so"), "measured"),
        (Finding((compare("float", 1.0, 2.0),), (CERTAIN,), "so"), "measured"),
        # Here it is the correction that fails, too: the printed form is refuted for certain.
        (Finding((WRONG,), (compare("float", 1.0, 2.0),), "so"), "certified"),
        (Finding((CERTAIN,), undecided="it is"), "measured"),
        (Finding(()), "measured"),
    ],
)
def test_the_grade_follows_from_the_comparisons_that_decide(
    finding: Finding, expected: str
) -> None:
    assert grade(finding) == expected


def test_a_deduction_decides_for_all_cases_and_a_broken_one_leaves_it_open() -> None:
    assert grade(Finding((PROOF, FLOAT))) == "deduced"
    assert grade(Finding((REFUTATION, FLOAT))) == "deduced"
    assert verdict_kind(Finding((BROKEN,))) == "undecided"
    assert verdict_kind(Finding((REFUTATION,))) == "fails"
    assert judge(Finding((REFUTATION,), (PROOF,), "so")) == "holds with the correction so"
    # What is deduced does not outweigh a number that differs.
    assert verdict_kind(Finding((PROOF, WRONG))) == "fails"


def test_words_alone_deduce_nothing() -> None:
    words = (Step("a theorem", "", True, "theorem"), Step("so", "", True, "argument"))

    assert Deduction("all cases", words).outcome == "open"
    assert Deduction("all cases", (*words, *PROOF.steps)).outcome == "agrees"


def test_a_corrected_form_rests_on_the_weaker_of_refutation_and_correction() -> None:
    assert grade(Finding((REFUTATION,), (CERTAIN,), "so")) == "certified"
    assert grade(Finding((REFUTATION,), (FLOAT,), "so")) == "measured"
    assert grade(Finding((WRONG,), (PROOF,), "so")) == "certified"


def test_an_error_counts_against_agreement_and_can_leave_it_open() -> None:
    inside = compare("a", 1.0, 1.05, 0.1, 0.02)
    open_item = compare("a", 1.0, 1.05, 0.1, 0.06)
    outside = compare("a", 1.0, 1.05, 0.01, 0.02)

    assert (inside.outcome, is_decided(inside), is_proven(inside)) == ("agrees", True, True)
    assert (open_item.outcome, is_decided(open_item), is_proven(open_item)) == (
        "open",
        False,
        False,
    )
    assert (outside.outcome, is_decided(outside), is_proven(outside)) == ("differs", True, False)
    assert compare("a", 1.0, 1.05, 0.1, error=0.06).outcome == "open"
    assert not is_decided(FLOAT)


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


def test_impact_times_are_certain_to_what_is_asked_and_no_further() -> None:
    run = pc.simulate(WALL, pc.sine(2), v0=1, max_impacts=5)
    times = np.pi * np.arange(1, 6, dtype=np.float64)

    assert is_proven(impacts_at("times", run, times))
    assert not is_decided(impacts_at("times", run, times, tolerance=0.0))
    moved = impacts_at("times", run, times + 1e-9)
    assert (moved.outcome, is_decided(moved)) == ("differs", True)
    assert impacts_at("too few", run, times[:3]).outcome != "agrees"


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

    assert [claim.grade for claim in claims] == ["certified", "measured"]
    assert "The verdicts are 1 certified, 1 measured." in re.sub(r"<[^>]*>", "", text)
    # In the explanation of the words, on the record, and at its number.
    assert text.count('<span class="ground certified">certified</span>') == 3
    assert claims[0].record()["grade"] == "certified"
    assert (
        'id="seen" data-verdict="holds" data-section="impact-times" data-evidence="measured"'
        in text
    )


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


KEPT = Path(__file__).parents[1] / "frozen" / "values" / "claims.json"


def test_what_is_measured_has_an_error_unless_it_is_counted() -> None:
    records = json.loads(KEPT.read_text(encoding="utf-8")).values()
    bare = [
        (record["id"], item["what"])
        for record in records
        for form in record["evidence"].values()
        for item in form
        if item["kind"] == "measured" and bool(item["error"]) == item["count"]
    ]
    assert bare == []


def test_what_fails_says_what_is_true_instead() -> None:
    for record in json.loads(KEPT.read_text(encoding="utf-8")).values():
        assert bool(record["instead"]) == (record["kind"] == "fails"), record["id"]
