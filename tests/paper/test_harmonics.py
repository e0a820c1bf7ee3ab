"""The verdicts on section 4 of the paper, and the numbers behind them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.paper.findings import finding
from tests.paper.numbers_of import difference, numbers, numbers_in_theory

import percuss as pc
from percuss.paper.claims import harmonics
from percuss.paper.statement import grade, judge

THEORY = Path(__file__).parents[2] / "docs" / "theory"

# What each verdict rests on.
HOLD = {
    "eq17": "deduced",
    "eq18": "deduced",
    "eq19": "deduced",
    "eq19-velocities": "deduced",
    "eq19-increment": "deduced",
    "eq20": "deduced",
    "eq21": "deduced",
    "eq22": "deduced",
    "eq23": "deduced",
    "not-sufficient": "deduced",
    "eq24": "deduced",
    "eq24-third": "deduced",
    "eq24-other-root": "deduced",
    "eq25": "deduced",
    "table2-simulated": "deduced",
    "fig5": "deduced",
    "fig6a": "deduced",
    "fig9": "deduced",
    "property2": "deduced",
    "only-resonances": "deduced",
    "nonperiodic-others": "deduced",
    "table2": "certified",
    "fig7": "certified",
}
CORRECTED = {"eq26": "the largest of the (n-1)/2 roots"}


def test_every_statement_is_listed_once_and_its_theory_exists() -> None:
    names = [statement.id for statement in harmonics.STATEMENTS]

    assert len(set(names)) == len(names)
    assert set(names) == HOLD.keys() | CORRECTED.keys()
    assert all((THEORY / statement.theory).is_file() for statement in harmonics.STATEMENTS)


@pytest.mark.parametrize("name", sorted(HOLD))
def test_what_holds(name: str) -> None:
    assert judge(finding(name)) == "holds"
    assert grade(finding(name)) == HOLD[name]


def test_the_root_must_be_named() -> None:
    verdict = judge(finding("eq26"))
    counted = [c.value for c in numbers(finding("eq26").corrected) if "number of roots" in c.what]

    assert verdict.startswith("holds with the correction")
    assert CORRECTED["eq26"] in verdict
    assert grade(finding("eq26")) == "deduced"
    assert counted == [2, 3, 4, 5, 6, 7]


def test_the_two_motions_of_figure_7_have_the_speeds_of_the_closed_form() -> None:
    above, below = (check.value for check in numbers(finding("fig7").printed))
    assert above == pytest.approx(1.0, abs=1e-12)
    assert below == pytest.approx(2.0 * 0.1**0.5, abs=1e-12)


def test_the_limits_found_by_simulation_have_twelve_digits() -> None:
    limits = [
        check
        for check in numbers(finding("table2-simulated").printed)
        if "minus the largest of (26)" in check.what
    ]

    assert len(limits) == 7
    assert max(abs(difference(check)) + getattr(check, "radius", 0.0) for check in limits) < 2e-12


def test_a_resonance_on_a_subset_ends_where_the_contact_condition_says() -> None:
    gained = next(c for c in numbers(finding("property2").printed) if "gained a period" in c.what)

    assert gained.value == pytest.approx(8 / 300, abs=1e-12)
    assert "66 periods" in finding("property2").remark


def test_the_table_in_the_theory_has_the_numbers_of_the_library() -> None:
    rows = numbers_in_theory("paper-harmonics.md")

    assert len(rows) == 10
    for n, digits in rows:
        assert f"{pc.harmonic_critical_velocity(n):.12f}" == digits
