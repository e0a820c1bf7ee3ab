"""Printed inputs of section 3's example and appendix A, perturbed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import sympy

from percuss.paper.claims import family, family_limits, model_statements
from percuss.paper.claims import family_formulas as formulas
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding, Statement

STATEMENTS: tuple[Statement, ...] = tuple(
    one for one in family.STATEMENTS if one not in model_statements.STATEMENTS
)
FIND = {one.id: one.find for one in STATEMENTS}
UNMOVED: dict[str, str] = {}

V, m, s, t = formulas.V, formulas.m, formulas.s, formulas.t


def mutant(formula: Formula, old: Any, new: Any) -> Formula:
    """Return a formula with a part of what is printed replaced."""
    printed = formula.printed.xreplace({old: new})
    assert printed != formula.printed
    return replace(formula, printed=printed)


def as_right(formula: Formula) -> Formula:
    """Return a formula as if the right one had been printed."""
    assert formula.right is not None
    return replace(formula, printed=formula.right, right=None)


def entry(m: int, text: str) -> dict[int, str]:
    """Return table 1 with another entry."""
    return {**family_limits.TABLE_1, m: text}


STEPS = formulas.EQ10.printed.rhs
LATER = replace(
    formulas.EQ10,
    printed=sympy.Eq(
        formulas.EQ10.left, sympy.Piecewise((s + m + 1, STEPS.args[0].cond), (s + 2, True))
    ),
)
SWAPPED = replace(
    formulas.EQ10,
    printed=sympy.Eq(
        formulas.EQ10.left, sympy.Piecewise((s + 1, STEPS.args[0].cond), (s + m, True))
    ),
)
COSINE = sympy.cos((2 * t + sympy.pi) / (m + 1))
KICK = formulas.KICK
(SECOND, SLOPE, BOUND) = formulas.EQA6_A7.printed

PERTURBED: list[tuple[str, str, tuple[Any, ...], dict[str, Any]]] = [
        ("eq10", "s + m + 1, s + 2 for s + m, s + 1", (LATER,), {}),
        ("eq10", "the gaps in the other order", (SWAPPED,), {}),
        ("eq11", "the sign of a cosine", (mutant(formulas.EQ11, -COSINE, COSINE),), {}),
        (
            "eq11",
            "m + 2 for m + 1",
            (replace(formulas.EQ11, printed=formulas.EQ11.printed.subs(m, m + 1)),),
            {},
        ),
        ("eq12", "the right factor", (as_right(formulas.EQ12),), {}),
        ("eq13-long", "minus for plus", (as_right(formulas.EQ13_LONG),), {}),
        (
            "eq13-short",
            "1 + 3 (-1)^m for 1 + 2 (-1)^m",
            (mutant(formulas.EQ13_SHORT, 2 * (-1) ** m, 3 * (-1) ** m),),
            {},
        ),
        (
            "eq13-short",
            "(-1)^(m+1)",
            (mutant(formulas.EQ13_SHORT, 2 * (-1) ** m, 2 * (-1) ** (m + 1)),),
            {},
        ),
        ("eq14", "6 for 4", (mutant(formulas.EQ14, -V + 2 * KICK, -V + 3 * KICK),), {}),
        ("family-period", "6 for 4 in (14)", (mutant(formulas.EQ14, -V + 2 * KICK, -V + 3 * KICK),), {}),
        ("family-period", "even and odd exchanged", (), {"counts": (1, 2)}),
        ("family-commensurate", "even and odd exchanged", ((1, 2),), {}),
        ("periods-coincide", "m = 3 alone", ((3,),), {}),
        ("subset-stability", "no lateness", (), {"late": 0.0}),
        (
            "family-valid",
            "3 for 4 in (A4)",
            (replace(formulas.EQA4, printed=sympy.Eq(formulas.EQA4.left, 3 * KICK / 2)),),
            {},
        ),
        ("eqA3", "no bars", (as_right(formulas.EQA3),), {}),
        ("eqA4", "m + 2 for m + 1",
         (replace(formulas.EQA4, printed=formulas.EQA4.printed.subs(m, m + 1)),), {}),
        ("eqA4", "5 for 4",
         (replace(formulas.EQA4, printed=sympy.Eq(formulas.EQA4.left, 5 * KICK / 2)),), {}),
        ("eqA5", "3/(4 sqrt 2)",
         (mutant(formulas.EQA5, 1 + 3 * sympy.sqrt(2) / 4, 1 + 3 / (4 * sympy.sqrt(2))),), {}),
        ("eqA5", "minus for plus",
         (mutant(formulas.EQA5, 1 + 3 * sympy.sqrt(2) / 4, 1 - 3 * sympy.sqrt(2) / 4),), {}),
        ("eqA6-A7", "the sign of the slope",
         (replace(formulas.EQA6_A7, printed=sympy.Tuple(
             SECOND, sympy.Eq(SLOPE.lhs - 2 * formulas.D * sympy.cos(formulas.CONTACT), 0), BOUND)),),
         {}),
        ("eqA6-A7", "plus for minus in (A7)",
         (replace(formulas.EQA6_A7, printed=sympy.Tuple(
             SECOND, SLOPE, sympy.Le(V + KICK, formulas.D))),), {}),
        ("eqA8", "plus for minus",
         (replace(formulas.EQA8, printed=sympy.Eq(
             formulas.EQA8.left, 2 * KICK - formulas.EQA8.printed.rhs)),), {}),
        ("table1", "0.985 for 0.984", (entry(7, "0.985"),), {}),
        ("table1", "0.284 for 0.283", (entry(15, "0.284"),), {}),
        ("table1-simulated", "0.485 for 0.486", (), {"table": entry(11, "0.485")}),
        ("above-critical", "below V*", ((0.9,),), {}),
        ("fig3-4", "sqrt(3)/2 for 2/sqrt(3)", (sympy.sqrt(3) / 2,), {}),
        ("figA1", "V0 = 2.2 for 2", ((1.2, 2.2),), {}),
]  # fmt: skip
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    (id, what, partial(FIND[id], *arguments, **named)) for id, what, arguments, named in PERTURBED
]
