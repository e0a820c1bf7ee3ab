"""The verdicts on section 4 of the paper, and the numbers behind them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

import percuss as pc
from percuss.paper.claims import harmonics
from percuss.paper.statement import Finding, judge

THEORY = Path(__file__).parents[2] / "docs" / "theory"

HOLD = {
    "eq17",
    "eq18",
    "eq19",
    "eq19-velocities",
    "eq19-increment",
    "eq20",
    "eq21",
    "eq22",
    "eq23",
    "not-sufficient",
    "eq24",
    "eq24-third",
    "eq25",
    "table2",
    "table2-simulated",
    "property2",
    "only-resonances",
}
CORRECTED = {"eq26": "the largest of the (n-1)/2 roots"}


@cache
def finding(name: str) -> Finding:
    (statement,) = (one for one in harmonics.STATEMENTS if one.id == name)
    return statement.find()


def test_every_statement_is_listed_once_and_its_theory_exists() -> None:
    names = [statement.id for statement in harmonics.STATEMENTS]

    assert len(set(names)) == len(names)
    assert set(names) == HOLD | set(CORRECTED)
    assert all((THEORY / statement.theory).is_file() for statement in harmonics.STATEMENTS)


@pytest.mark.parametrize("name", sorted(HOLD))
def test_what_holds(name: str) -> None:
    assert judge(finding(name)) == "holds"


def test_the_root_must_be_named() -> None:
    verdict = judge(finding("eq26"))
    wrong = [check for check in finding("eq26").printed if not check.passed]

    assert verdict.startswith("holds with the correction")
    assert CORRECTED["eq26"] in verdict
    # n = 5 to 15 have (n-1)/2 roots each, of which all but one are wrong.
    assert len(wrong) == sum((n - 1) // 2 - 1 for n in (5, 7, 9, 11, 13, 15))


def test_the_limits_found_by_simulation_have_twelve_digits() -> None:
    limits = [check for check in finding("table2-simulated").printed if "limit minus" in check.what]

    assert len(limits) == 7
    assert max(abs(check.difference) + (check.radius or 0.0) for check in limits) < 2e-12


def test_a_resonance_on_a_subset_ends_where_the_contact_condition_says() -> None:
    gained = next(c for c in finding("property2").printed if "gained a period" in c.what)

    assert gained.measured == pytest.approx(8 / 300, abs=1e-12)
    assert "66 periods" in finding("property2").remark


def test_the_table_in_the_theory_has_the_numbers_of_the_library() -> None:
    text = (THEORY / "paper-harmonics.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| ([\d.]+) \|$", text, flags=re.MULTILINE)

    assert len(rows) == 10
    for n, digits in rows:
        assert f"{pc.harmonic_critical_velocity(int(n)):.12f}" == digits
