"""Named parameters and expressions of them, which may stand in any field of a model.

An expression is a text of a small grammar, and the values of its parameters. It is read with
Python's own parser, its nodes are checked against a list, and nothing is ever executed. Its value
is exact where it is rational or a multiple of pi; else it is enclosed in rational intervals.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, Self, TypeVar, cast

from percuss.errors import ParameterError
from percuss.model.exact import (
    NOT_A_PHASE,
    Computed,
    Exact,
    Phase,
    PiTimes,
    angle,
    computed_in,
    phase_problem,
    plain,
    range_problem,
)
from percuss.model.expression_tree import (
    EXACT,
    FUNCTIONS,
    NO_POWER,
    ONE,
    Arithmetic,
    Node,
    derivative_of,
    evaluated,
    names_of,
    number_node,
    power_of,
    read,
    text_of,
    tree_of,
)
from percuss.model.intervals import (
    ExactNumber,
    IntervalArithmetic,
    Irrational,
    NoNumber,
    TooLarge,
    enclosed,
)
from percuss.wording import closest

LONGEST_TEXT = 1000
SHOWN = 60
T = TypeVar("T")
# A parameter of such a name would look like a part of the model, or a column of its results.
WORDS = frozenset(
    [
        "oscillator",
        "forcing",
        "start",
        "stops",
        "harmonics",
        "stiffness",
        "damping",
        "at",
        "side",
        "restitution",
        "amplitude",
        "omega",
        "phase",
        "constant",
        "period",
        "x0",
        "v0",
        "t0",
        "pi",
        "t",
        "x",
        "v",
        "cycle",
        "v_after",
        "bound",
        "branch",
        "sample",
        "point",
        "value",
        "attractor",
        "reason",
        "fraction",
    ]
).union(FUNCTIONS)
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)


@dataclass(frozen=True, slots=True, repr=False)
class Expression(Computed):
    """A number given by an expression of named parameters, exactly.

    Made by `parameter` and `expression`, and by + - * / and ``**`` of these with numbers. It may
    stand wherever a model takes a number. The text of a number means that decimal; ``float(0.1)``
    is the double. Its methods sqrt, sin and cos, which ``numpy.sqrt`` and the others call, give its
    functions.

    Parameters
    ----------
    text
        The expression: numbers, names, ``+ - * / **``, parentheses, pi, sqrt, sin and cos.
        Exponents are whole numbers from -64 to 64.
    parameters
        (name, value) of each parameter in it, ordered by name; a value is a number or a multiple
        of pi.

    Raises
    ------
    ParameterError
        If it is no such expression, or has a name that is no parameter.

    Examples
    --------
    >>> w = parameter("w", "1.7")
    >>> force = "0.15" * w**2
    >>> print(force, float(force), force.derivative("w"))
    0.15*w**2 0.4335 0.15*2*w
    """

    text: str
    parameters: tuple[tuple[str, Phase], ...] = ()

    def __post_init__(self) -> None:
        problem = expression_problem(self.text, [name for name, _ in self.parameters])
        if problem is not None:
            raise ParameterError("expression", shortened(self.text), problem)
        text, used = read(self.text)
        object.__setattr__(self, "text", text)
        rows = sorted((name, plain(value)) for name, value in self.parameters if name in used)
        for name, value in rows:
            wrong = value_problem(value)
            if wrong is not None:
                raise ParameterError(name, value, wrong)
        object.__setattr__(self, "parameters", tuple(rows))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters, in order."""
        return tuple(name for name, _ in self.parameters)

    @property
    def is_parameter(self) -> bool:
        """Whether it is a parameter alone."""
        return self.names == (self.text,)

    @property
    def factor(self) -> Expression | None:
        """The number that it is times its one parameter; None where it is no such multiple.

        Examples
        --------
        >>> print(expression("2*pi*f", f=3).factor, expression("f + 1", f=3).factor)
        2*pi None
        """
        if len(self.names) != 1:
            return None
        (name,) = self.names
        factor = self.derivative(name)
        try:
            rest = self.replaced({name: 0}).angle()
        except NoNumber:
            return None
        return None if factor.names or any(rest) else factor

    @property
    def is_reciprocal(self) -> bool:
        """Whether it is a number divided by its one parameter.

        Examples
        --------
        >>> expression("2*pi/T", T=3).is_reciprocal, expression("2*pi*f", f=3).is_reciprocal
        (True, False)
        """
        tree = tree_of(self.text)
        if tree.kind != "/":
            return False
        above, below = tree.parts
        return not names_of(above) and text_of(below) in self.names

    @property
    def is_exact(self) -> bool:
        """Whether its value is known exactly: rational, or a rational multiple of pi and more."""
        return _value(self).is_exact

    def problem(self) -> str | None:
        """Return why the value is no finite number, None if it is one."""
        try:
            value = _value(self)
        except NoNumber as error:
            return str(error)
        return range_problem(value.times) or range_problem(value.plus)

    def angle(self) -> tuple[Fraction, Fraction]:
        """Return ``(times, plus)`` of the value times * pi + plus; within 2^-320 if irrational."""
        value = _value(self)
        return value.times, value.plus

    def replaced(self, values: Mapping[str, Phase]) -> Self:
        """Return the expression with other values of some of its parameters."""
        rows = tuple((name, values.get(name, value)) for name, value in self.parameters)
        return type(self)(self.text, rows)

    def derivative(self, name: str) -> Expression:
        """Return the derivative by a parameter, as an expression."""
        return _made(derivative_of(tree_of(self.text), name), dict(self.parameters))

    def evaluated(self, arithmetic: Arithmetic[T], values: Mapping[str, T]) -> T:
        """Return the value in another arithmetic, at values of all parameters."""
        return evaluated(tree_of(self.text), arithmetic, values)

    def sqrt(self) -> Expression:
        """Return the square root."""
        return _combined("sqrt", self)

    def sin(self) -> Expression:
        """Return the sine."""
        return _combined("sin", self)

    def cos(self) -> Expression:
        """Return the cosine."""
        return _combined("cos", self)

    def exp(self) -> Expression:
        """Refuse what ``numpy.exp`` calls; `log` and `tan` do the same."""
        raise ParameterError("expression", self, "only sqrt, sin and cos of it are allowed")

    log = tan = exp

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        if self.is_parameter:
            return f"parameter({self.text!r}, {self.parameters[0][1]!r})"
        values = "".join(f", {name}={value!r}" for name, value in self.parameters)
        return f"expression({self.text!r}{values})"

    def __add__(self, other: object) -> Expression:
        return _combined("+", self, other)

    def __radd__(self, other: object) -> Expression:
        return _combined("+", other, self)

    def __sub__(self, other: object) -> Expression:
        return _combined("-", self, other)

    def __rsub__(self, other: object) -> Expression:
        return _combined("-", other, self)

    def __mul__(self, other: object) -> Any:
        # A force is multiplied by its own rule.
        if not isinstance(other, str | Expression) and phase_problem(plain(other)) == NOT_A_PHASE:
            return NotImplemented
        return _combined("*", self, other)

    def __rmul__(self, other: object) -> Expression:
        return _combined("*", other, self)

    def __truediv__(self, other: object) -> Expression:
        return _combined("/", self, other)

    def __rtruediv__(self, other: object) -> Expression:
        return _combined("/", other, self)

    def __pow__(self, exponent: object) -> Expression:
        node, parameters = _operand(self)
        # Exponents have no parameters: of an expression the names are not asked.
        if isinstance(exponent, Expression):
            power = power_of(tree_of(exponent.text))
        else:
            power = power_of(_operand(exponent)[0])
        return _made(Node("**", (node,), str(power)), parameters)

    def __rpow__(self, base: object) -> Expression:
        raise ParameterError("exponent", self, NO_POWER)

    def __neg__(self) -> Expression:
        return _combined("neg", self)

    def __pos__(self) -> Self:
        return self


def parameter(name: str, value: Phase) -> Expression:
    """Return a named number, which makes expressions with ``+ - * /`` and ``**``.

    Its name is the path by which it is changed, with all that depends on it.

    Parameters
    ----------
    name
        ASCII letters, digits and underscores; none of the words of paths and results, such as
        ``omega`` and ``x``.
    value
        A number, or a multiple of pi; a text means that decimal.

    Returns
    -------
    Expression
        The parameter.

    Raises
    ------
    ParameterError
        If it can have no such name, or the value is no number.

    Examples
    --------
    >>> w = parameter("w", "1.7")
    >>> 2 * w + 1
    expression('2*w+1', w='1.7')
    """
    problem = name_problem(name)
    if problem is not None:
        raise ParameterError("name", name, problem)
    return Expression(name, ((name, value),))


def expression(text: str, **parameters: Phase) -> Expression:
    """Return the expression of a text, with the values of its parameters.

    Parameters
    ----------
    text
        The expression, as `Expression` takes it.
    **parameters
        Values of its parameters.

    Returns
    -------
    Expression
        The expression.

    Raises
    ------
    ParameterError
        If it is no such expression.

    Examples
    --------
    >>> float(expression("sqrt(k/m)", k=50, m=2))
    5.0
    """
    for name in parameters:
        problem = name_problem(name)
        if problem is not None:
            raise ParameterError("name", name, problem)
    return Expression(text, tuple(parameters.items()))


def as_expression(value: Phase) -> Expression:
    """Return a number as an expression."""
    return value if isinstance(value, Expression) else _made(*_operand(value))


def meant_by(number: str | PiTimes) -> str | Expression:
    """Return a multiple of pi, and the text of an expression, as that; other texts unchanged.

    Examples
    --------
    >>> meant_by("4*pi**2"), meant_by("high")
    (expression('4*pi**2'), 'high')
    """
    if isinstance(number, PiTimes):
        return as_expression(number)
    return number if expression_problem(number, []) else Expression(number)


def name_problem(name: object) -> str | None:
    """Return why a parameter cannot have a name, None if it can."""
    if not isinstance(name, str) or _NAME.fullmatch(name) is None:
        return "no name; letters of ASCII, digits and underscores make one, such as w or base_amplitude"
    if name in WORDS:
        return "a word of paths, results or expressions; give it another name, such as w"
    return None


def expression_problem(text: object, known: list[str]) -> str | None:
    """Return why a text is no expression of some parameters, None if it is one."""
    if not isinstance(text, str) or not text.strip():
        return "no expression; write one such as 0.15*w**2"
    if len(text) > LONGEST_TEXT:
        return f"an expression of {len(text)} characters; {LONGEST_TEXT} are the most"
    try:
        _, names = read(text)
    except ParameterError as error:
        return error.reason
    unknown = sorted(names.difference(known))
    if not unknown:
        return None
    alike = closest(unknown[0], known)
    all_known = f"there are {', '.join(sorted(known))}" if known else "there are none"
    hint = f"did you mean {alike}?" if alike else all_known
    are = "is no parameter" if len(unknown) == 1 else "are no parameters"
    return f"{' and '.join(unknown)} {are}; {hint}"


def shortened(text: object) -> object:
    """Return a text as messages show it: cut where it is long."""
    is_long = isinstance(text, str) and len(text) > SHOWN
    return f"{cast('str', text)[:SHOWN]} ..." if is_long else text


def expressions_in(*values: object) -> Iterator[Expression]:
    """Yield the expressions in parts of a model."""
    return (value for value in computed_in(*values) if isinstance(value, Expression))


def parameters_in(*values: object) -> dict[str, Phase]:
    """Return the parameters of parts of a model and their values, by name.

    Raises
    ------
    ParameterError
        If two of one name have different values.
    """
    parameters: dict[str, Phase] = {}
    for value in expressions_in(*values):
        for name, number in value.parameters:
            _add_parameter(parameters, name, number)
    return dict(sorted(parameters.items()))


def _add_parameter(parameters: dict[str, Phase], name: str, value: Phase) -> None:
    before = parameters.setdefault(name, value)
    if before is not value and before != value and angle(before) != angle(value):
        reason = f"a parameter that is {before} elsewhere; one name has one value"
        raise ParameterError(name, value, reason)


@dataclass(frozen=True, slots=True)
class _Value:
    times: Fraction
    plus: Fraction
    is_exact: bool


@lru_cache(maxsize=4096)
def _value(of: Expression) -> _Value:
    """Return the value of an expression; `NoNumber` says why there is none."""
    tree, numbers = tree_of(of.text), {name: angle(value) for name, value in of.parameters}
    try:
        exact = evaluated(tree, EXACT, {name: ExactNumber(*pair) for name, pair in numbers.items()})
        return _Value(exact.times, exact.plus, True)
    except (Irrational, TooLarge):
        pass

    def at(arithmetic: IntervalArithmetic) -> Any:
        pairs = numbers.items()
        known = {
            name: arithmetic.number(plus) + arithmetic.pi() * arithmetic.number(times)
            for name, (times, plus) in pairs
        }
        return evaluated(tree, arithmetic, known)

    return _Value(Fraction(0), enclosed(at), False)


def value_problem(value: object) -> str | None:
    """Return why a plain value is none that a parameter can have."""
    if isinstance(value, Expression):
        return "an expression; the value of a parameter is a number"
    return phase_problem(value)


def _operand(value: object) -> tuple[Node, dict[str, Phase]]:
    """Return the node and the parameters of an expression or a number."""
    if isinstance(value, Expression):
        return tree_of(value.text), dict(value.parameters)
    number = plain(value)
    if isinstance(number, str):
        return tree_of(Expression(number).text), {}
    problem = phase_problem(number)
    if problem is not None:
        raise ParameterError("value", value, problem)
    return number_node(cast("Exact | PiTimes", number)), {}


def _combined(kind: str, *values: object) -> Expression:
    parts, parameters = [], cast("dict[str, Phase]", {})
    for value in values:
        node, own = _operand(value)
        parts.append(node)
        for name, number in own.items():
            _add_parameter(parameters, name, number)
    if kind == "*" and parts[1].kind == "/" and parts[1].parts[0] == ONE:
        return _made(Node("/", (parts[0], parts[1].parts[1])), parameters)
    return _made(Node(kind, tuple(parts)), parameters)


def _made(node: Node, parameters: Mapping[str, Phase]) -> Expression:
    return Expression(text_of(node), tuple(parameters.items()))
