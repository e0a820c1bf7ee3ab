"""Decisive numbers of the records on sections 1 and 2, against mpmath."""

from __future__ import annotations

import pytest
import sympy
from mpmath import mp
from tests.paper.findings import finding
from tests.paper.numbers_of import numbers

from percuss.paper.claims.multi_harmonics import work_on_free_cycle
from percuss.paper.evidence import Deduction
from percuss.paper.statement import grade


@pytest.mark.parametrize(("n", "ratio"), [(1, "5/3"), (2, "5/3"), (4, "5/3"), (3, "2"), (5, "7")])
def test_the_work_on_a_free_cycle_is_the_integral(n: int, ratio: str) -> None:
    """By quadrature of x' exp(i n W_r t) over both parts of the cycle."""
    closed = work_on_free_cycle(sympy.Integer(n), sympy.Rational(ratio))
    below = mp.mpf(sympy.Rational(ratio).p) / sympy.Rational(ratio).q
    rate = 2 * n / (1 + 1 / below)
    half = mp.pi
    integral = mp.quad(lambda t: mp.cos(t) * mp.expj(rate * t), mp.linspace(0, half, 5))
    integral -= mp.quad(
        lambda t: mp.cos(below * (t - half)) * mp.expj(rate * t),
        mp.linspace(half, half + mp.pi / below, 5),
    )

    assert float(abs(integral)) == pytest.approx(float(closed), abs=1e-12)


def test_no_motion_at_the_fourth_multiple_changes_its_speed() -> None:
    found = finding("multi-harmonics")
    (fourth,) = numbers(found.printed)

    assert fourth.value == pytest.approx(1.0, abs=1e-12)
    assert any(isinstance(item, Deduction) for item in found.printed)


@pytest.mark.parametrize(
    "name",
    [
        "eq1",
        "eq2",
        "eq5",
        "eq6",
        "eq9",
        "eigenset-sum",
        "property1",
        "eq15",
        "eq16",
        "existence-uniqueness",
        "derivatives-at-impacts",
        "neutral-element",
    ],
)
def test_what_is_deduced(name: str) -> None:
    assert grade(finding(name)) == "deduced"


def test_a_sum_of_motions_is_formed_and_closeness_is_measured() -> None:
    """0.001 sin(t - pi k) and 0.001 cos(t - pi k), at times near their largest."""
    close = numbers(finding("eq16").printed)
    assert [item.value for item in close] == pytest.approx([1e-3] * 4, rel=1e-4)
    assert all(item.value < 1e-3 for item in close)

    below = numbers(finding("existence-uniqueness").printed)
    exact = (mp.cos(mp.mpf("0.4")) - mp.cos(mp.mpf("0.2"))) / 3
    assert below[0].value == pytest.approx(float(exact), abs=1e-15)
