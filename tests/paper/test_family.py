"""The verdicts on sections 1 to 3 of the paper and its appendix, and the numbers behind them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

import percuss as pc
from percuss.paper.claims import family
from percuss.paper.statement import Finding, judge

THEORY = Path(__file__).parents[2] / "docs" / "theory"

HOLD = {
    "eq1",
    "eq2",
    "multi-harmonics",
    "eq3-4",
    "eq5",
    "eq6",
    "eq9",
    "eigenset-sum",
    "property1",
    "eq16",
    "eq10",
    "eq11",
    "eq13-short",
    "eq14",
    "family-commensurate",
    "family-valid",
    "eqA4",
    "eqA5",
    "eqA6-A7",
    "eqA8",
    "table1",
    "table1-simulated",
    "above-critical",
}
CORRECTED = {
    "eq15": "x_part(0) cos t",
    "eq12": "(1-m)(m+3)/(m+1)^2",
    "eq13-long": "V0 - q",
    "family-period": "V0 = V*/2",
    "subset-stability": "changes of V0 alone",
    "eqA3": "without the absolute values",
}


@cache
def finding(name: str) -> Finding:
    (statement,) = (one for one in family.STATEMENTS if one.id == name)
    return statement.find()


def test_every_statement_is_listed_once_and_its_theory_exists() -> None:
    names = [statement.id for statement in family.STATEMENTS]

    assert len(set(names)) == len(names)
    assert set(names) == HOLD | set(CORRECTED)
    assert all((THEORY / statement.theory).is_file() for statement in family.STATEMENTS)


@pytest.mark.parametrize("name", sorted(HOLD))
def test_what_holds(name: str) -> None:
    assert judge(finding(name)) == "holds"


@pytest.mark.parametrize("name", sorted(CORRECTED))
def test_what_holds_with_a_correction(name: str) -> None:
    verdict = judge(finding(name))

    assert verdict.startswith("holds with the correction")
    assert CORRECTED[name] in verdict


@pytest.mark.parametrize("name", sorted(HOLD | set(CORRECTED)))
def test_verdicts_do_not_depend_on_the_run_of_the_command(name: str) -> None:
    (statement,) = (one for one in family.STATEMENTS if one.id == name)

    assert statement.find() == finding(name)


def test_the_printed_force_misses_where_the_corrected_one_hits() -> None:
    printed = {check.what: check for check in finding("eq12").printed}
    factor = printed["m = 3: factor of the cosine in x'' + x"]
    impact = printed["m = 3: first impact over m pi"]

    assert factor.expected == 0.0
    assert factor.measured == pytest.approx(-0.75, abs=1e-11)
    assert impact.measured < 0.6
    assert all(abs(check.difference) < 1e-10 for check in finding("eq12").corrected)


def test_the_limits_found_by_simulation_have_ten_digits_for_odd_m() -> None:
    limits = [check for check in finding("table1-simulated").printed if "minus V*" in check.what]

    assert len(limits) == 7
    assert max(abs(check.difference) for check in limits) < 1e-11


def test_the_table_in_the_theory_has_the_numbers_of_the_library() -> None:
    text = (THEORY / "paper-family.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| ([\d.]+) \|$", text, flags=re.MULTILINE)

    assert len(rows) == 14
    for m, digits in rows:
        assert f"{pc.subset_critical_velocity(int(m)):.12f}" == digits
