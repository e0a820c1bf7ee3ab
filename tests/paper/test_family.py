"""The verdicts on sections 1 to 3 of the paper and its appendix, and the numbers behind them."""

from __future__ import annotations

from pathlib import Path

import mpmath as mp
import pytest
from tests.paper.findings import finding
from tests.paper.numbers_of import difference, numbers, numbers_in_theory

import percuss as pc
from percuss.paper.claims import family
from percuss.paper.claims import family_formulas as formulas
from percuss.paper.claims.above_critical import is_chaotic, neighbours_above
from percuss.paper.evidence import Deduction
from percuss.paper.statement import grade, judge

THEORY = Path(__file__).parents[2] / "docs" / "theory"

HOLD = {
    "eq1",
    "eq2",
    "eq3-4",
    "eq5",
    "eq6",
    "eq9",
    "eigenset-sum",
    "property1",
    "eq16",
    "derivatives-at-impacts",
    "periods-coincide",
    "eq10",
    "eq11",
    "eq13-short",
    "eq14",
    "family-valid",
    "eqA4",
    "eqA5",
    "eqA6-A7",
    "eqA8",
    "table1",
    "table1-simulated",
    "fig3-4",
    "figA1",
}
CORRECTED = {
    "multi-harmonics": "J_n = 0",
    "eq15": "x_part(0) cos t",
    "eq12": "(1 - m)(m + 3)",
    "eq13-long": "minus in place of plus",
    "family-commensurate": "V0 = 1/sqrt(3)",
    "existence-uniqueness": "do not tend to 0",
    "neutral-element": "acts on the solutions",
    "above-critical": "quasi-periodic",
    "family-period": "V0 = V*/2",
    "subset-stability": "changes of V0 alone",
    "eqA3": "without the absolute values",
}


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


# What is measured in motions, and one of each other kind.
FEW = {"above-critical", "subset-stability", "table1-simulated", "eq6", "eq12", "neutral-element"}
ALL = sorted(HOLD | set(CORRECTED))


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=() if one in FEW else pytest.mark.nightly) for one in ALL],
)
def test_verdicts_do_not_depend_on_the_run_of_the_command(name: str) -> None:
    (statement,) = (one for one in family.STATEMENTS if one.id == name)

    assert statement.find() == finding(name)


DEDUCED = (
    "eq10",
    "eq11",
    "eq12",
    "eq13-short",
    "eq14",
    "family-period",
    "family-commensurate",
    "family-valid",
    "eqA3",
    "eqA4",
    "eqA5",
    "eqA6-A7",
    "eqA8",
    "fig3-4",
)


@pytest.mark.parametrize("name", [*DEDUCED, "eq13-long"])
def test_what_is_deduced_for_every_m(name: str) -> None:
    assert grade(finding(name)) == "deduced"


@pytest.mark.parametrize("name", ["table1", "table1-simulated"])
def test_the_numbers_of_the_table_are_certified(name: str) -> None:
    assert grade(finding(name)) == "certified"


@pytest.mark.parametrize("name", ["subset-stability", "above-critical", "figA1"])
def test_what_is_measured(name: str) -> None:
    assert grade(finding(name)) == "measured"


def test_the_printed_force_misses_where_the_corrected_one_hits() -> None:
    printed = {check.what: check for check in numbers(finding("eq12").printed)}

    assert printed["m = 3: first impact over m pi"].value < 0.6
    assert all(abs(difference(check)) < 1e-10 for check in numbers(finding("eq12").corrected))


def own(m: int, long: bool, v0: mp.mpf, t: mp.mpf) -> mp.mpf:
    """Return the motion of Y_m on its first flights, from the initial velocity alone."""
    gap = mp.mpf(m + 1)

    def p(t: mp.mpf) -> mp.mpf:
        return mp.cos(mp.pi / gap) - mp.cos((2 * t + mp.pi) / gap)

    amplitude = v0 - mp.diff(p, 0)
    if not long:
        end = m * mp.pi
        rebound = -(amplitude * mp.cos(end) + mp.diff(p, end))
        amplitude = (rebound - mp.diff(p, end)) / mp.cos(end)
    return amplitude * mp.sin(t) + p(t)


@pytest.mark.parametrize("m", [2, 3, 4, 7])
def test_the_right_formulas_are_those_of_an_independent_way(m: int) -> None:
    v0, long, short = mp.mpf("0.2"), 0.4, m * mp.pi + 0.7
    x = formulas.EQ11.side(formulas.A, formulas.t, formulas.m)

    amplitude = formulas.EQ13_LONG.side(formulas.V, formulas.m, right=True)(0.2, m)
    assert float(own(m, True, v0, long)) == pytest.approx(x(amplitude, long, m), abs=1e-14)
    amplitude = formulas.EQ13_SHORT.side(formulas.V, formulas.m)(0.2, m)
    assert float(own(m, False, v0, short)) == pytest.approx(
        x(amplitude, float(short), m), abs=1e-14
    )
    end = (m + 1) * mp.pi
    slope = -mp.diff(lambda t: own(m, False, v0, t), end)
    following = formulas.EQ14.printed.rhs.subs(formulas.m, m).subs(formulas.V, 0.2)
    assert float(slope) == pytest.approx(float(following), abs=1e-14)


def test_signs_are_read_by_one_rule() -> None:
    for name, formula in (("eq13-short", formulas.EQ13_SHORT), ("eq14", formulas.EQ14)):
        deduction = next(one for one in finding(name).printed if isinstance(one, Deduction))
        assert formula.shown.startswith("V 0 þ")
        assert "no sign before V0" in deduction.steps[0].text
        assert deduction.outcome == "agrees"
    readings = next(one for one in finding("eq13-long").printed if isinstance(one, Deduction))
    assert [step.text.rsplit("with ", 1)[1] for step in readings.steps] == [
        "a minus before V0",
        "no sign before V0",
    ]
    assert readings.outcome == "differs"


def test_regular_and_chaotic_motions_above_the_bound_are_told_apart_by_a_wide_gap() -> None:
    pairs = neighbours_above()
    regular = [pair for pair in pairs if not is_chaotic(pair)]
    chaotic = [pair for pair in pairs if is_chaotic(pair)]

    assert max(pair.growth for pair in regular) < 5
    assert min(pair.growth for pair in chaotic) > 1e4
    # All five for m = 3, and none for m = 4 and 6.
    assert sum(pair.m == 3 for pair in regular) == 5
    assert not any(pair.m in (4, 6) for pair in regular)
    assert (len(regular), len(chaotic)) == (10, 20)


def test_a_weakly_chaotic_motion_looks_regular_up_to_a_time_of_4000() -> None:
    pair = next(one for one in neighbours_above() if one.m == 4 and one.impacts > 4000)

    assert is_chaotic(pair)
    assert pair.distance > 1.0


def test_figure_a1a_has_a_velocity_above_its_bound() -> None:
    assert "above V*(2) = 1.1547" in finding("figA1").remark
    assert "least, -0.0" in finding("figA1").remark


def test_the_table_in_the_theory_has_the_numbers_of_the_library() -> None:
    rows = numbers_in_theory("paper-family.md")

    assert len(rows) == 14
    for m, digits in rows:
        assert f"{pc.subset_critical_velocity(m):.12f}" == digits
