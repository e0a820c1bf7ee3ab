"""Perturbations of the statements of section 5: under sin t and under cos t."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import sympy

import percuss as pc
from percuss.paper import chain
from percuss.paper.claims import (
    cosine,
    cosine_formulas,
    half_harmonic,
    half_harmonic_formulas,
    poincare,
)
from percuss.paper.claims.half_harmonic_growth import SUBHARMONIC_STATEMENTS
from percuss.paper.formula import Formula
from percuss.paper.statement import Finding

STATEMENTS = (
    *half_harmonic.STATEMENTS,
    *SUBHARMONIC_STATEMENTS,
    *cosine.STATEMENTS,
    *poincare.STATEMENTS,
)


def mended(formula: Formula) -> Formula:
    """Return a formula with the right form printed."""
    assert formula.right is not None
    return replace(formula, printed=formula.right)


def edited(formula: Formula, old: Any, new: Any) -> Formula:
    """Return a formula with a part of its printed right side replaced."""
    side = formula.printed.rhs.xreplace({sympy.sympify(old): sympy.sympify(new)})
    assert side != formula.printed.rhs
    return replace(formula, printed=sympy.Eq(formula.printed.lhs, side))


H, C = half_harmonic_formulas, cosine_formulas
NAMED: dict[str, Callable[..., Finding]] = {
    statement.id: getattr(statement.find, "func", statement.find) for statement in STATEMENTS
}


def _of(record: str, *args: Any, **kwargs: Any) -> Callable[[], Finding]:
    """Return the finding of a statement with other printed input."""
    return partial(NAMED[record], *args, **kwargs)


def mended_chain() -> Finding:
    lines = [
        line if line.formula.right is None else replace(line, formula=mended(line.formula))
        for line in chain.LINES
    ]
    return NAMED["chain"](lines)


HALF = sympy.Rational(1, 2)
PLUS = replace(
    H.EQ28,
    printed=sympy.Eq(H.EQ28.printed.lhs, H.EQ28.printed.rhs + H.TIME * sympy.cos(H.TIME)),
)
CUBE_ROOT = replace(
    H.EQ35, printed=sympy.Eq(H.EQ35.printed.lhs, H.ROOT_FACTOR * sympy.cbrt(H.TIME))
)

MUTATIONS: list[tuple[str, str, Callable[[], Finding]]] = [
    ("eq27", "restitution 0.9999", _of("eq27", "0.9999")),
    ("eq27", "restitution 0.999", _of("eq27", "0.999")),
    ("eq28", "sign of (t/2) cos t", _of("eq28", PLUS, H.EQ28_VELOCITY)),
    ("eq29", "the missing term put in", _of("eq29", mended(H.EQ29))),
    ("eq30", "the missing term put in", _of("eq30", mended(H.EQ30))),
    ("eq31", "2 a_k for a_k", _of("eq31", edited(H.EQ31, H.FACTOR, 2 * H.FACTOR), H.EQ31_FACTOR)),
    ("eq32", "the right factor", _of("eq32", mended(H.EQ32))),
    ("eq33", "without cos^2", _of("eq33", mended(H.EQ33))),
    ("eq34", "the right rate", _of("eq34", mended(H.EQ34))),
    ("chain", "all lines right", mended_chain),
    ("large-times", "2 pi without a_k", _of("large-times", mended(H.TWO_FLIGHTS))),
    ("eq35", "cube root", _of("eq35", CUBE_ROOT)),
    ("eq35-constant", "two starts that are nearly one", _of("eq35-constant", starts=(0.0, 1e-6))),
    ("fig10", "linear growth", _of("fig10", 1.0)),
    ("fig11", "0.64 for 0.61", _of("fig11", "limit", 0.64)),
    ("fig11-bilinear", "0.64 for 0.61", _of("fig11-bilinear", "stiff", 0.64)),
    ("fig11-bilinear", "the soft stop", _of("fig11-bilinear", "soft")),
    ("fig11-asymptotic", "0.59 for 0.61", _of("fig11-asymptotic", 0.59)),
    ("fig12", "sin 3t from 0.45", _of("fig12", pc.sine(3), "0.45")),
    ("fig12", "sin 3t from 0.4999", _of("fig12", pc.sine(3), "0.4999")),
    ("fig13", "sin 3t from 0.45", _of("fig13", pc.sine(3), "0.45")),
    ("fig10-accuracy", "the soft stop", _of("fig10-accuracy", "soft")),
    ("accuracy-argument", "0.052 for 0.31", _of("accuracy-argument", "0.052")),
    ("eq37", "the right form", _of("eq37", mended(C.EQ37), mended(C.EQ37_VELOCITY))),
    ("eq38", "sign of (-1)^k", _of("eq38", edited(C.EQ38, C.SIGN, -C.SIGN))),
    ("eq38-velocity", "the right sign", _of("eq38-velocity", mended(C.EQ38_VELOCITY))),
    (
        "eq39",
        "pi/3 for pi/2",
        _of("eq39", edited(C.EQ39, sympy.pi, sympy.pi * 2 / 3), C.EQ39_TWICE),
    ),
    ("eq40", "t/3 for t/2", _of("eq40", edited(C.EQ40, -HALF, -HALF * 2 / 3))),
    ("cosine-steady", "V0 = 0", _of("cosine-steady", (0.0,))),
    ("cosine-half-pi", "pi for pi/2", _of("cosine-half-pi", sympy.pi)),
    ("fig14", "0.16 for 0.31", _of("fig14", displacement=False, printed=0.16)),
    ("fig15", "0.155 for 0.29", _of("fig15", displacement=True, printed=0.155)),
    ("fig14-numerics", "sin t", _of("fig14-numerics", pc.sine(1), 400.0, (1e-5, 1e-8))),
    ("poincare-maps", "restitution 0.99", _of("poincare-maps", pc.impact_oscillator("0.99"))),
    ("periodicity-subharmonic", "k pi + 1.1848 for k pi", _of("periodicity-subharmonic", 1.1848)),
]
UNMOVED = {
    "cosine-becomes-sine": "the motion from rest does not grow, whatever the shift of the origin",
}
