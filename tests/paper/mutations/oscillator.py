"""Perturbed records on sections 1 and 2 of the article, and on Property 1."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import sympy
from tests.paper.perturbed import Mutation, perturbed, record

from percuss.paper.claims import model_statements, oscillator_statements
from percuss.paper.formula import Formula

T, T_K, D, K = sympy.symbols("t t_k D k", real=True)
A, V0, EPSILON, ALPHA = sympy.symbols("a V_0 epsilon alpha", positive=True)
X, X1 = sympy.symbols("x x'", real=True)


def printed(name: str, *changes: tuple[Any, Any]) -> Formula:
    """Return a record's formula with parts of what is printed replaced."""
    formula = record(name).formula
    assert isinstance(formula, Formula)
    assert all(formula.printed.has(part) for part, _ in changes)
    return replace(formula, printed=formula.printed.xreplace(dict(changes)))


EQ2, RATES = oscillator_statements.EQ2, oscillator_statements.RATES
EQ9, EQ15 = model_statements.EQ9, model_statements.EQ15
HALF_RATE = replace(EQ2, printed=sympy.Eq(EQ2.left, EQ2.printed.rhs / 2))
ANTI_DAMPED = replace(RATES, printed=RATES.printed.subs(A, sympy.I * A))
LARGER_X = replace(EQ9, printed=sympy.Eq(EQ9.left, sympy.Rational("1.01") * EQ9.printed.rhs))
FASTER_X = replace(EQ9, printed=EQ9.printed.subs(T, sympy.Rational("1.01") * T))

MUTATIONS: list[Mutation] = [
    perturbed(
        "eq1",
        "the stiffness times x^2",
        formula=printed("eq1", (X, X**2)),
    ),
    perturbed("eq2", "W_r halved", eq2=HALF_RATE),
    perturbed("eq2", "plus a^2", rates=ANTI_DAMPED),
    perturbed("multi-harmonics", "n = 3", n=3),
    perturbed(
        "eq3-4",
        "the sign of the velocity",
        impact=replace(
            printed("eq3-4"),
            printed=sympy.Eq(printed("eq3-4").left, -printed("eq3-4").printed.rhs),
        ),
    ),
    perturbed("eq5", "2x", formula=printed("eq5", (X, 2 * X))),
    perturbed("eq5", "W_r = 3", harmonic="3"),
    perturbed("eq6", "alpha^2", formula=printed("eq6", (ALPHA, ALPHA**2))),
    perturbed("eq9", "1.01 V0", formula=LARGER_X),
    perturbed("eq9", "1.01 t", formula=FASTER_X),
    perturbed("eq9", "2 pi k", formula=printed("eq9", (K, 2 * K))),
    perturbed("eigenset-sum", "a free motion of 9/10", more="9/10"),
    perturbed("property1", "z = D sin t, as printed", difference=D * sympy.sin(T)),
    perturbed("property1", "z = D sin 2(t - t_k)", difference=D * sympy.sin(2 * (T - T_K))),
    perturbed(
        "eq15",
        "the right form",
        formula=replace(EQ15, printed=EQ15.right),
        amplitude=sympy.Symbol("V", positive=True) - sympy.Symbol("x_{part}'(0)", real=True),
    ),
    perturbed("eq16", "velocities that differ by 0.002", faster="1.002"),
    perturbed("eq16", "eps/2", formula=printed("eq16", (EPSILON, EPSILON / 2))),
    perturbed("existence-uniqueness", "the force cos 2t", force=sympy.cos(2 * T)),
    perturbed(
        "derivatives-at-impacts",
        "x' for x",
        formula=printed("eq5", (X, X1)),
    ),
    perturbed("neutral-element", "V0 = 0", speed="0"),
]
UNMOVED: dict[str, str] = {}
