"""Section 4 with a digit, a sign, an index or an exponent of its printed inputs perturbed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import sympy
from sympy import Eq, Rational, cos, pi, sin

from percuss.paper.claims import commensurate, harmonics
from percuss.paper.claims.commensurate import GAINED
from percuss.paper.claims.harmonic_formulas import (
    EQ18,
    EQ18_VELOCITY,
    EQ19,
    EQ19_GAIN,
    EQ20,
    EQ21,
    EQ22,
    EQ23,
    G,
    V,
    k,
    n,
    t,
)
from percuss.paper.claims.harmonic_limits import EQ24, EQ24_VELOCITY, EQ25, EQ26, TABLE_2, m, xi
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding


def with_right(formula: Formula, right: sympy.Expr) -> Formula:
    """Return a formula with another right side."""
    return replace(formula, printed=Eq(formula.printed.lhs, right))


def with_left(formula: Formula, left: sympy.Expr) -> Formula:
    """Return a formula with another left side."""
    return replace(formula, printed=Eq(left, formula.printed.rhs))


def plus(formula: Formula, more: sympy.Expr) -> Formula:
    """Return a formula with something added to its right side."""
    return with_right(formula, formula.printed.rhs + more)


STATEMENTS = harmonics.STATEMENTS
FIND: dict[str, Callable[..., Finding]] = {one.id: one.find for one in STATEMENTS}
WAVE = sin(n * t) / (n**2 - 1)
# A record, what is perturbed in it, and the finding that this gives.
MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    (id, what, partial(FIND[id], **inputs))
    for id, what, inputs in (
        ("eq17", "period pi of even n to pi/2", {"even": pi / 2}),
        ("eq17", "period 2 pi of odd n to pi", {"odd": pi}),
        ("eq18", "sign of the wave", {"x": plus(EQ18, 2 * WAVE)}),
        ("eq18", "n^2 - 1 to n^2 + 1", {"x": plus(EQ18, WAVE - sin(n * t) / (n**2 + 1))}),
        ("eq18", "n in x' left out", {"velocity": plus(EQ18_VELOCITY, cos(n * t) / (n + 1))}),
        ("eq19", "(-1)^k to (-1)^(k+1)", {"amplitude": with_right(EQ19, -EQ19.printed.rhs)}),
        ("eq19", "sign of the share", {"amplitude": with_right(EQ19, (-1) ** k * (V - G))}),
        ("eq19", "2n to n", {"gain": plus(EQ19_GAIN, -G)}),
        (
            "eq19-velocities",
            "sign of the share",
            {"amplitude": with_right(EQ19, (-1) ** k * (V - G))},
        ),
        ("eq19-increment", "2/n to 1/n", {"law": 1 / n}),
        ("eq19-increment", "2/n to 2/n^2", {"law": 2 / n**2}),
        ("eq20", "(-1)^k for the share too", {"amplitude": EQ19}),
        ("eq20", "n to 2n in the share", {"amplitude": plus(EQ20, G)}),
        ("eq21", "a gain added", {"same": plus(EQ21, G)}),
        ("eq22", "sign of V", {"formula": with_left(EQ22, EQ23.printed.lhs)}),
        ("eq22", "sign of the wave", {"formula": with_left(EQ22, EQ22.printed.lhs + 2 * WAVE)}),
        ("eq23", "sign of V", {"formula": with_left(EQ23, EQ22.printed.lhs)}),
        ("eq23", "sign of the wave", {"formula": with_left(EQ23, EQ23.printed.lhs + 2 * WAVE)}),
        ("not-sufficient", "the velocity to one below V_max(3)", {"v0": Rational("0.3")}),
        ("not-sufficient", "a gain added to (21)", {"same": plus(EQ21, G)}),
        (
            "eq24",
            "sign of the wave",
            {"first": plus(EQ24, -2 * (-1) ** m * cos(n * xi) / (n**2 - 1))},
        ),
        (
            "eq24",
            "the factor n of the second line",
            {"second": plus(EQ24_VELOCITY, (-1) ** m * sin(n * xi))},
        ),
        ("eq24-third", "1/2 to 1/3", {"printed": Rational(1, 3)}),
        (
            "eq24-third",
            "sign in (26)",
            {"limit": plus(EQ26, 2 * (-1) ** m * cos(n * xi) / cos(xi) / (n**2 - 1))},
        ),
        ("eq24-other-root", "sine for cosine", {"first": plus(EQ24, sin(xi))}),
        ("eq24-other-root", "sign of n/(n^2-1)", {"second": plus(EQ24_VELOCITY, 2 * G * sin(xi))}),
        ("eq25", "factor n to n + 1", {"law": plus(EQ25, sympy.tan(n * xi))}),
        ("eq25", "sign of n", {"law": with_right(EQ25, -EQ25.printed.rhs)}),
        ("eq26", "the root named: the largest", {"every": False}),
        (
            "eq26",
            "n^2 - 1 to n^2 + 1",
            {"limit": with_right(EQ26, EQ26.printed.rhs * (n**2 - 1) / (n**2 + 1))},
        ),
        ("table2", "0.138 to 0.139", {"printed": {**TABLE_2, 9: "0.139"}}),
        ("table2", "0.26 to 0.27", {"printed": {**TABLE_2, 5: "0.27"}}),
        (
            "table2-simulated",
            "n^2 - 1 to n^2",
            {"limit": with_right(EQ26, EQ26.printed.rhs * (n**2 - 1) / n**2)},
        ),
        ("fig5", "2n to n in (19)", {"gain": plus(EQ19_GAIN, -G)}),
        ("fig6a", "0.51 to 0.49", {"v0": Rational("0.49")}),
        ("fig7", "0.45 to 0.55", {"below": "0.55"}),
        ("fig9", "0.139 to 0.137", {"v0": Rational("0.137")}),
        ("property2", "the point in the gap: 3 pi/2 to pi/2", {"inside": Rational(1, 2)}),
        ("only-resonances", "2n to n in (19)", {"growing": GAINED / 2}),
        (
            "nonperiodic-others",
            "cos phi to sin phi",
            {"growing": GAINED.subs(cos(commensurate.phase), sin(commensurate.phase))},
        ),
    )
]
UNMOVED: dict[str, str] = {}
