"""Expressions as trees: read with Python's own parser, and never executed.

The nodes that Python's parser returns are checked against a list. A tree has a text, a value in any
arithmetic, and a derivative.
"""

from __future__ import annotations

import ast
import keyword
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, Protocol, TypeVar, cast

from percuss.errors import ParameterError
from percuss.model.exact import Phase, PiTimes, number_problem
from percuss.model.intervals import ExactNumber, Irrational, NoNumber, TooLarge

DEEPEST, LARGEST_POWER = 100, 64
FUNCTIONS = ("sqrt", "sin", "cos", "float")
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?![\w.])"
    r"|(?P<name>[A-Za-z_]\w*)|\*\*|[-+*/()])",
    re.ASCII,
)
_OPERATIONS: dict[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
}
_APPLY: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}
_PRECEDENCE = {"+": 1, "-": 1, "neg": 1, "*": 2, "/": 2, "**": 3}

T = TypeVar("T")


class Arithmetic(Protocol[T]):
    """What an expression is evaluated in: numbers with + - * / and powers, and functions of them."""

    def number(self, value: Fraction) -> T:
        """Return a rational number."""

    def pi(self) -> T:
        """Return pi."""

    def sqrt(self, value: T) -> T:
        """Return a square root."""

    def sin(self, value: T) -> T:
        """Return a sine."""

    def cos(self, value: T) -> T:
        """Return a cosine."""


@dataclass(frozen=True, slots=True)
class Node:
    """A part of an expression; ``text`` is that of a number or a name, or the exponent."""

    kind: str
    parts: tuple[Node, ...] = ()
    text: str = ""


ZERO, ONE = Node("number", text="0"), Node("number", text="1")


NO_POWER = (
    f"no exponent; a whole number from -{LARGEST_POWER} to {LARGEST_POWER} is one, "
    "and sqrt(x) the power 1/2"
)
_NO_EXPRESSION = "no expression such as 0.15*w**2: a sign, a number or a parenthesis is missing"


@lru_cache(maxsize=1024)
def read(text: str) -> tuple[str, frozenset[str]]:
    """Return a text without spaces, and the names in it."""
    _check_tokens(text)
    bare = "".join(text.split())
    return bare, names_of(tree_of(bare))


def _check_tokens(text: str) -> None:
    """Raise the fault of a character that no expression has."""
    place, end = 0, len(text.rstrip())
    while place < end:
        token = _TOKEN.match(text, place)
        if token is None:
            word = text[place:].split(maxsplit=1)[0]
            has = "it has numbers, names, + - * / ** and parentheses"
            reason = "^ in an expression; write ** for powers"
            reason = reason if word[0] == "^" else f"{word[:20]!r} in an expression; {has}"
            raise ParameterError("expression", text, reason)
        if token["number"] is not None:
            problem = number_problem(token["number"])
            if problem is not None:
                raise ParameterError("expression", text, f"{token['number'][:20]} is {problem}")
        word = token.group().strip()
        if keyword.iskeyword(word):
            reason = f"{word} in an expression; it is a word of Python, and no name here"
            raise ParameterError("expression", text, reason)
        place = token.end()
    # The spaces are left out: they must part nothing.
    if re.search(r"[\w.)]\s+[\w.]|\*\s+\*", text):
        raise ParameterError("expression", text, _NO_EXPRESSION)


@lru_cache(maxsize=1024)
def tree_of(text: str) -> Node:
    """Return the tree of a text without spaces, whose characters have been checked."""
    try:
        parsed = ast.parse(text, mode="eval").body
        return _node(parsed, text, 0)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError("expression", text, _NO_EXPRESSION) from error


def _node(given: ast.expr, text: str, depth: int) -> Node:
    if depth > DEEPEST:
        raise ParameterError(
            "expression", text, f"nested more than {DEEPEST} deep, or so many terms"
        )
    if isinstance(given, ast.Constant) and type(given.value) in (int, float):
        return Node("number", text=text[given.col_offset : given.end_col_offset])
    if isinstance(given, ast.Name):
        if given.id in FUNCTIONS:
            raise ParameterError("expression", text, f"{given.id} without a value in parentheses")
        return Node("pi" if given.id == "pi" else "name", text=given.id)
    if isinstance(given, ast.UnaryOp) and isinstance(given.op, ast.UAdd | ast.USub):
        part = _node(given.operand, text, depth + 1)
        return part if isinstance(given.op, ast.UAdd) else Node("neg", (part,))
    if isinstance(given, ast.BinOp) and type(given.op) in _OPERATIONS:
        left, right = (_node(part, text, depth + 1) for part in (given.left, given.right))
        kind = _OPERATIONS[type(given.op)]
        return (
            Node("**", (left,), str(power_of(right))) if kind == "**" else Node(kind, (left, right))
        )
    if isinstance(given, ast.Call) and isinstance(given.func, ast.Name):
        return _call(given.func.id, given, text, depth)
    if isinstance(given, ast.Call):
        raise ParameterError("expression", text, "a value called as a function; write * between")
    raise ParameterError("expression", text, _NO_EXPRESSION)


def _call(name: str, given: ast.Call, text: str, depth: int) -> Node:
    if name not in FUNCTIONS:
        raise ParameterError("expression", text, f"{name}() is not allowed; sqrt, sin and cos are")
    if len(given.args) != 1 or given.keywords:
        raise ParameterError("expression", text, f"{name} takes one value in parentheses")
    part = _node(given.args[0], text, depth + 1)
    if name != "float":
        return Node(name, (part,))
    if part.kind != "number":
        raise ParameterError("expression", text, "float() takes one number, such as 0.1")
    return Node("float", text=part.text)


def power_of(node: Node) -> int:
    """Return the exponent that a node means."""
    try:
        value = evaluated(node, EXACT, {})
    except (KeyError, Irrational, NoNumber, TooLarge) as error:
        raise ParameterError("exponent", text_of(node), NO_POWER) from error
    if value.times or value.plus.denominator != 1 or abs(value.plus) > LARGEST_POWER:
        raise ParameterError("exponent", text_of(node), NO_POWER)
    return int(value.plus)


def names_of(node: Node) -> frozenset[str]:
    """Return the names of the parameters in a tree."""
    if node.kind == "name":
        return frozenset({node.text})
    return frozenset().union(*(names_of(part) for part in node.parts))


def text_of(node: Node) -> str:
    """Return the text of a node, with as few parentheses as are needed."""
    if not node.parts:
        return f"float({node.text})" if node.kind == "float" else node.text
    if node.kind == "neg":
        return f"-{_wrapped(node.parts[0], 2)}"
    if node.kind == "**":
        return f"{_wrapped(node.parts[0], 4)}**{node.text}"
    if len(node.parts) == 1:
        return f"{node.kind}({text_of(node.parts[0])})"
    own = _PRECEDENCE[node.kind]
    left, right = node.parts
    return f"{_wrapped(left, own)}{node.kind}{_wrapped(right, own + (node.kind in '-/'))}"


def _wrapped(node: Node, least: int) -> str:
    is_negative = node.kind == "neg" and least > 1
    text = text_of(node)
    return text if _PRECEDENCE.get(node.kind, 4) >= least and not is_negative else f"({text})"


class _ExactArithmetic:
    """Rational numbers and multiples of pi; what is neither raises `Irrational`."""

    def number(self, value: Fraction) -> ExactNumber:
        return ExactNumber(Fraction(0), value)

    def pi(self) -> ExactNumber:
        return ExactNumber(Fraction(1), Fraction(0))

    def sqrt(self, value: ExactNumber) -> ExactNumber:
        return value.sqrt()

    def sin(self, value: ExactNumber) -> ExactNumber:
        return value.sin()

    def cos(self, value: ExactNumber) -> ExactNumber:
        return value.cos()


EXACT = _ExactArithmetic()


def evaluated(node: Node, arithmetic: Arithmetic[T], values: Mapping[str, T]) -> T:
    """Return the value of a node in an arithmetic, at values of its names."""
    kind = node.kind
    if kind == "number":
        return arithmetic.number(Fraction(node.text))
    if kind == "float":
        return arithmetic.number(Fraction(float(node.text)))
    if kind == "name":
        return values[node.text]
    if kind == "pi":
        return arithmetic.pi()
    parts = [evaluated(part, arithmetic, values) for part in node.parts]
    if kind == "neg":
        return cast("T", -parts[0])  # type: ignore[operator]  # an Arithmetic has numbers
    if kind == "**":
        return _raised(parts[0], int(node.text), arithmetic)
    if len(parts) == 1:
        return cast("T", getattr(arithmetic, kind)(parts[0]))
    return cast("T", _APPLY[kind](*parts))


def _raised(base: T, exponent: int, arithmetic: Arithmetic[T]) -> T:
    """Return a whole power by repeated squaring: + - * / are all that an arithmetic needs."""
    result, square, left = arithmetic.number(Fraction(1)), base, abs(exponent)
    while left:
        if left & 1:
            result = _APPLY["*"](result, square)
        left >>= 1
        square = _APPLY["*"](square, square) if left else square
    return (
        cast("T", _APPLY["/"](arithmetic.number(Fraction(1)), result)) if exponent < 0 else result
    )


def number_node(number: Phase) -> Node:
    """Return a plain number as a node."""
    if isinstance(number, PiTimes):
        pi = _product(number_node(number.times), Node("pi", text="pi"))
        return _sum(pi, number_node(number.plus))
    if isinstance(number, Fraction):
        p, q = number_node(number.numerator), number.denominator
        return p if q == 1 else Node("/", (p, Node("number", text=str(q))))
    if number < 0:  # type: ignore[operator]  # an int, a float or a Decimal
        return Node("neg", (number_node(-number),))  # type: ignore[operator]
    if isinstance(number, float):
        is_short = Fraction(repr(number)) == Fraction(number)
        return Node("number" if is_short else "float", text=repr(number))
    return Node("number", text=str(number))


def derivative_of(node: Node, name: str) -> Node:
    """Return the derivative of a node by a name, without the terms that are zero."""
    if not node.parts:
        return ONE if node.kind == "name" and node.text == name else ZERO
    inner = [derivative_of(part, name) for part in node.parts]
    if all(part == ZERO for part in inner):
        return ZERO
    u, du = node.parts[0], inner[0]
    match node.kind:
        case "+":
            return _sum(*inner)
        case "-":
            return _difference(*inner)
        case "neg":
            return _difference(ZERO, du)
        case "*":
            return _sum(_product(du, node.parts[1]), _product(u, inner[1]))
        case "/":
            v, dv = node.parts[1], inner[1]
            return _difference(_quotient(du, v), _quotient(_product(u, dv), _to_power(v, 2)))
        case "**":
            n = int(node.text)
            return _product(_product(number_node(n), _to_power(u, n - 1)), du)
        case "sqrt":
            return _quotient(du, _product(Node("number", text="2"), node))
        case "sin":
            return _product(Node("cos", (u,)), du)
        case _:
            return _difference(ZERO, _product(Node("sin", (u,)), du))


def _sum(a: Node, b: Node) -> Node:
    return b if a == ZERO else a if b == ZERO else Node("+", (a, b))


def _difference(a: Node, b: Node) -> Node:
    if b == ZERO:
        return a
    return Node("neg", (b,)) if a == ZERO else Node("-", (a, b))


def _product(a: Node, b: Node) -> Node:
    if ZERO in (a, b):
        return ZERO
    return b if a == ONE else a if b == ONE else Node("*", (a, b))


def _quotient(a: Node, b: Node) -> Node:
    return ZERO if a == ZERO else Node("/", (a, b))


def _to_power(a: Node, n: int) -> Node:
    return ONE if n == 0 else a if n == 1 else Node("**", (a,), str(n))
