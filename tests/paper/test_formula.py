"""Formulas are shown as the article prints them."""

from __future__ import annotations

import pytest

from percuss.paper.claims.half_harmonic_formulas import EQ32
from percuss.paper.claims.harmonic_limits import EQ24, EQ26
from percuss.paper.formula import Formula

SHARE = r"\frac{n}{n^{2} - 1}"


@pytest.mark.parametrize(
    ("formula", "article"),
    [
        pytest.param(
            EQ24,
            rf"x = \left(V_{{2p}} - {SHARE}\right) \, \cos \xi + "
            r"\frac{\left(-1\right)^{m} \, \cos n \, \xi}{n^{2} - 1}",
            id="(24)",
        ),
        pytest.param(
            EQ26,
            r"V_{max} = \frac{n - \frac{\left(-1\right)^{m} \, \cos n \, \xi}{\cos \xi}}"
            r"{n^{2} - 1}",
            id="(26)",
        ),
        pytest.param(
            EQ32,
            r"V_{k+1} = V_{k} + \frac{\pi \, \left(\sin t_{k} + "
            r"\left(\pi + 2 \, \sin t_{k}\right) \, a_{k}\right)}{2} + O(a_k^2)",
            id="(32)",
        ),
    ],
)
def test_terms_stand_in_the_order_of_the_article(formula: Formula, article: str) -> None:
    assert formula.tex() == article
