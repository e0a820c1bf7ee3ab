"""A numbered formula of the article: as its text shows it, as it was printed, and as it is right.

One SymPy expression makes the picture of a formula, the check of it and what is said of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import sympy
from sympy.printing.latex import LatexPrinter

from percuss import numerics

# numerics gives the same bits on every machine.
MODULES: list[Any] = [
    {name: getattr(numerics, name) for name in ("sin", "cos", "tan", "exp", "log")},
    "numpy",
]


@dataclass(frozen=True)
class Formula:
    r"""A numbered formula.

    Parameters
    ----------
    number
        Of the article: "12", "A4".
    shown
        What the extraction of the article's text shows, verbatim.
    printed
        The formula as it was printed: what is shown, with a minus where a sign is lost.
    right
        The right formula; None where the printed one is right.
    lost
        What is lost in the extraction, and how it was restored; empty where nothing is.
    order
        The order of what is left out, printed after the formula, such as "V_k^{-2}".

    Examples
    --------
    >>> V, t = sympy.symbols("V t", real=True)
    >>> f = Formula("9", "x0 = V0 sin t", sympy.Eq(sympy.Symbol("x_0"), V * sympy.sin(t)))
    >>> f.tex()
    'x_{0} = V \\, \\sin t'
    """

    number: str
    shown: str
    printed: sympy.Basic
    right: sympy.Basic | None = None
    lost: str = ""
    order: str = ""

    def tex(self, *, right: bool = False) -> str:
        """Return the printed formula, or the right one, in mathtext without dollar signs."""
        formula = self.right if right and self.right is not None else self.printed
        rest = f" + O({self.order})" if self.order else ""
        return mathtext(formula) + rest

    @cached_property
    def left(self) -> sympy.Expr:
        """The left side, which both forms share."""
        return self.printed.lhs

    def side(self, *symbols: sympy.Symbol, right: bool = False) -> Callable[..., Any]:
        """Return the right side of the printed formula, or of the right one, as a function.

        Parameters
        ----------
        *symbols
            In the order of the function's arguments, which may be arrays.
        right
            Whether of the right formula.
        """
        formula = self.right if right and self.right is not None else self.printed
        return numerically(formula.rhs, *symbols)


def numerically(expression: sympy.Expr, *symbols: sympy.Symbol) -> Callable[..., Any]:
    """Return an expression as a function of floats or arrays, the same bits on every machine.

    Examples
    --------
    >>> t = sympy.Symbol("t")
    >>> numerically(sympy.sin(t) / 3, t)(0.0)
    0.0
    """
    function: Callable[..., Any] = sympy.lambdify(symbols, expression, modules=MODULES)
    return function


class _WrittenSum(sympy.Add):  # type: ignore[misc]
    """A sum that keeps the order of its terms; whatever is made of it is a plain sum."""

    @property
    def func(self) -> Any:
        return sympy.Add


class _WrittenProduct(sympy.Mul):  # type: ignore[misc]
    """A product that keeps the order of its factors, as `_WrittenSum` does."""

    @property
    def func(self) -> Any:
        return sympy.Mul


class _Printer(LatexPrinter):  # type: ignore[misc]
    """Prints what was written in an order in that order, the rest in SymPy's."""

    def _print_Add(self, expr: sympy.Add, order: str | None = None) -> str:  # noqa: N802
        return self._in_order(expr, partial(super()._print_Add, order=order))

    def _print_Mul(self, expr: sympy.Mul) -> str:  # noqa: N802
        return self._in_order(expr, super()._print_Mul)

    def _in_order(self, expr: sympy.Expr, shown: Callable[[sympy.Expr], str]) -> str:
        is_written = isinstance(expr, (_WrittenSum, _WrittenProduct))
        outer = self._settings["order"]
        self._settings["order"] = "none" if is_written else None
        try:
            return shown(expr)
        finally:
            self._settings["order"] = outer


def ordered(*terms: sympy.Expr | int) -> sympy.Expr:
    """Return a sum that is printed in the order of its terms, where SymPy has another.

    Examples
    --------
    >>> a = sympy.Symbol("a")
    >>> mathtext(1 + a), mathtext(ordered(1, a))
    ('a + 1', '1 + a')
    """
    return _WrittenSum(*terms, evaluate=False)


def product(*factors: sympy.Expr | int) -> sympy.Expr:
    r"""Return a product that is printed in the order of its factors, where SymPy has another.

    Examples
    --------
    >>> a, b = sympy.symbols("a b")
    >>> mathtext(product(b, a))
    'b \\, a'
    """
    return _WrittenProduct(*factors, evaluate=False)


def mathtext(formula: sympy.Basic) -> str:
    r"""Return a formula as matplotlib's mathtext sets it: products thin, functions without braces.

    Examples
    --------
    >>> t = sympy.Symbol("t_k")
    >>> mathtext(sympy.cos(2 * t) ** 2 / 3)
    '\\frac{\\cos^{2} 2 \\, t_{k}}{3}'
    """
    if isinstance(formula, sympy.Tuple):
        return r",\ ".join(mathtext(part) for part in formula)
    if isinstance(formula, sympy.Eq) and isinstance(formula.rhs, sympy.Piecewise):
        return f"{mathtext(formula.lhs)} = {_cases(formula.rhs)}"
    text = _Printer({"fold_func_brackets": True, "mul_symbol": r" \, "}).doprint(formula)
    text = re.sub(
        r"\\(sin|cos|tan|arctan)(\^\{[^{}]*\})? *\{([^{}]*(?:\{[^{}]*\}[^{}]*)*)\}",
        r"\\\1\2 \3",
        text,
    )
    return re.sub(r" +", " ", text)


def _cases(choice: sympy.Piecewise) -> str:
    """Return a choice by parity, in one line: mathtext has no braces over several."""
    (even, condition), (odd, _) = choice.args
    number = mathtext(condition.lhs.args[0])
    return rf"{mathtext(even)}\ ({number}\ even),\ {mathtext(odd)}\ ({number}\ odd)"
