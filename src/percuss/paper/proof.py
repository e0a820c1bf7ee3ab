"""The steps of a deduction, carried out: algebra by SymPy, inequalities by ball arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TypeAlias

import sympy
from flint import arb

from percuss.certified.numbers import ball, between, precision
from percuss.paper.evidence import Step
from percuss.paper.formula import mathtext

# Of boxes that an inequality is split into before it is left open.
MOST_BOXES = 20_000
BITS = 96
Box: TypeAlias = dict[sympy.Symbol, tuple[Fraction, Fraction]]
FUNCTIONS: dict[type[sympy.Function], Callable[[arb], arb]] = {
    sympy.sin: arb.sin,
    sympy.cos: arb.cos,
    sympy.tan: arb.tan,
    sympy.atan: arb.atan,
    sympy.Abs: abs,
}


def identity(text: str, left: sympy.Expr, right: sympy.Expr) -> Step:
    """Return the step that two expressions are the same.

    Parameters
    ----------
    text
        The step in words.
    left, right
        Both sides; their symbols carry what is assumed of them (integer, positive).

    Returns
    -------
    Step
        It holds if SymPy reduces the difference to zero.

    Examples
    --------
    >>> t = sympy.Symbol("t", real=True)
    >>> identity("double angle", sympy.sin(2 * t), 2 * sympy.sin(t) * sympy.cos(t)).holds
    True
    >>> identity("wrong", sympy.sin(2 * t), sympy.sin(t)).holds
    False
    """
    return Step(text, _equation(left, right), _is_zero(left - right), "algebra")


def leading_terms(
    text: str, expression: sympy.Expr, small: sympy.Symbol, order: int, expected: sympy.Expr
) -> Step:
    """Return the step that an expression begins with some terms of its power series.

    Parameters
    ----------
    text
        The step in words.
    expression
        A function of ``small``, analytic at 0.
    small
        The variable that goes to 0.
    order
        Power of the first term that is left out.
    expected
        The terms below that power.

    Examples
    --------
    >>> e = sympy.Symbol("e")
    >>> leading_terms("sine", sympy.sin(e), e, 5, e - e**3 / 6).holds
    True
    """
    leading = sympy.series(expression, small, 0, order).removeO()
    return Step(text, _equation(expression, expected), _is_zero(leading - expected), "algebra")


def sign(
    text: str,
    expression: sympy.Expr,
    over: Mapping[sympy.Symbol, tuple[Fraction | int | str, Fraction | int | str]],
) -> Step:
    """Return the step that an expression is positive over a box of its variables.

    Parameters
    ----------
    text
        The step in words.
    expression
        Made of the four operations, powers, `sin`, `cos`, `tan`, `sqrt` and `Abs`.
    over
        The range of each symbol, ends included, as exact numbers.

    Returns
    -------
    Step
        It holds if ball arithmetic encloses the expression above 0 on boxes that fill the range.

    Examples
    --------
    >>> t = sympy.Symbol("t", real=True)
    >>> sign("no zero", 2 + sympy.sin(t), {t: (0, 7)}).holds
    True
    >>> sign("a zero", sympy.sin(t), {t: (0, 7)}).holds
    False
    """
    with precision(BITS):
        first = {name: (Fraction(low), Fraction(high)) for name, (low, high) in over.items()}
        holds = _is_positive(expression, [first])
    return Step(text, f"{mathtext(expression)} > 0", holds, "balls")


def positive(text: str, expression: sympy.Expr) -> Step:
    """Return the step that an expression is positive, whatever its symbols are.

    Parameters
    ----------
    text
        The step in words.
    expression
        Its symbols carry what is assumed of them (positive, nonnegative, integer).

    Returns
    -------
    Step
        It holds if SymPy derives the sign from these assumptions.

    Examples
    --------
    >>> a, b = sympy.Symbol("a", nonnegative=True), sympy.Symbol("b", positive=True)
    >>> positive("a sum", a + b).holds, positive("a difference", a - b).holds
    (True, False)
    """
    holds = sympy.factor(expression).is_positive is True
    return Step(text, f"{mathtext(expression)} > 0", holds, "algebra")


def theorem(text: str, formula: str = "") -> Step:
    """Return the step that a theorem gives; the text names it, or its source."""
    return Step(text, formula, True, "theorem")


def argument(text: str, formula: str = "") -> Step:
    """Return a step that is argued in words; nothing carries it out, and the report says so."""
    return Step(text, formula, True, "argument")


def _is_positive(expression: sympy.Expr, boxes: list[Box]) -> bool:
    done = 0
    while boxes and done < MOST_BOXES:
        box, done = boxes.pop(), done + 1
        value = enclose(expression, {name: between(*map(ball, box[name])) for name in box})
        if value <= 0:
            return False
        if not value > 0:
            widest = max(box, key=lambda name: box[name][1] - box[name][0])
            low, high = box[widest]
            middle = (low + high) / 2
            boxes += [{**box, widest: half} for half in ((low, middle), (middle, high))]
    return not boxes


def enclose(expression: sympy.Expr, values: Mapping[sympy.Symbol, arb]) -> arb:
    """Return an enclosure of an expression, its numbers exact and its symbols balls.

    Parameters
    ----------
    expression
        Made of the four operations, powers, pi, `sin`, `cos`, `tan`, `atan` and `Abs`.
    values
        Of its symbols.

    Raises
    ------
    NotImplementedError
        If the expression is made of anything else.

    Examples
    --------
    >>> t = sympy.Symbol("t")
    >>> bool(abs(enclose(sympy.Rational(1, 3) * t, {t: arb(3)}) - 1) < 1e-9)
    True
    """
    if isinstance(expression, sympy.Symbol):
        return values[expression]
    if isinstance(expression, sympy.Rational):
        return ball(Fraction(int(expression.p), int(expression.q)))
    if expression is sympy.pi:
        return arb.pi()
    parts = [enclose(part, values) for part in expression.args]
    if isinstance(expression, sympy.Add):
        return sum(parts, arb(0))
    if isinstance(expression, sympy.Mul):
        return math.prod(parts, start=arb(1))
    if isinstance(expression, sympy.Pow):
        power = expression.exp
        if power == sympy.Rational(1, 2):
            return parts[0].sqrt()
        return parts[0] ** (int(power) if power.is_Integer else parts[1])
    if type(expression) in FUNCTIONS:
        return FUNCTIONS[type(expression)](*parts)
    raise NotImplementedError(f"no enclosure of {expression.func}")


def _is_zero(expression: sympy.Expr) -> bool:
    """Return whether SymPy reduces an expression to zero; each attempt is dearer than the last."""
    for reduced in (
        lambda e: e,
        sympy.expand,
        lambda e: sympy.expand(e.rewrite(sympy.exp), power_exp=False),
        sympy.simplify,
        lambda e: sympy.simplify(sympy.expand_trig(sympy.expand(e))),
        lambda e: sympy.simplify(e.rewrite(sympy.exp)),
    ):
        if reduced(expression) == 0:
            return True
    return False


def _equation(left: sympy.Expr, right: sympy.Expr) -> str:
    """Return both sides, or one where SymPy has made them the same when they were formed."""
    sides = list(dict.fromkeys((mathtext(left), mathtext(right))))
    return " = ".join(sides)
