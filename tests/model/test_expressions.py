"""Expressions of named parameters: exact values, texts, derivatives, and what is refused."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, fmpq
from hypothesis import given, settings
from hypothesis import strategies as st

import percuss as pc
from percuss.certified.numbers import precision
from percuss.errors import ParameterError
from percuss.model.exact import Phase, angle, as_float, as_fraction, cos_sin, number_problem
from percuss.model.expression import Expression, expression, parameter

W = parameter("w", "1.7")


@pytest.fixture(scope="module", autouse=True)
def _working_precision() -> Iterator[None]:
    """400 bits, as long as these tests last: the precision is one for the process."""
    with precision(400):
        yield


def test_a_number_may_be_written_as_the_expression_that_it_is() -> None:
    osc = pc.Oscillator(
        stiffness="4*pi**2", damping="0.1*sqrt(2)", stops=(pc.Wall("pi/4", "above"),)
    )
    assert osc.stiffness == expression("4*pi**2")
    assert osc.stops[0].at == expression("pi/4")
    place: Any = pc.pi_times(1, 4)
    assert pc.Wall(place, "above") == pc.Wall(expression("1/4*pi"), "above")
    _, shaking = pc.ball_on_table(1, "2*pi", restitution="0.5")
    assert shaking.components()[0].sin == 4 * math.pi**2
    assert pc.cosine("2*pi").exact_period == pc.pi_times(0) + 1
    assert str(pc.cosine("50*pi").exact_period) == "1/25"
    assert pc.Oscillator.from_mass(2, "8*pi**2", damping_ratio="0.5").damping == expression(
        "sqrt(1*8*pi**2*2)"
    )
    # Numbers stay as they were written, phases what they are, and what is neither is refused.
    assert (pc.Harmonic("1/2", "2.8", "pi/2").amplitude, pc.Start(0, 0, "pi/2").t0) == (
        "1/2",
        "pi/2",
    )
    for wrong in ("2*w", "exp(1)", "high", "", "pi pi", "1/0", "nan"):
        with pytest.raises(
            ParameterError, match=r"stiffness = .*(not a number|division|not finite)"
        ):
            pc.Oscillator(stiffness=wrong)


class Balls:
    """An independent arithmetic, of Arb at 400 bits."""

    def number(self, value: Fraction) -> arb:
        return arb(fmpq(value.numerator, value.denominator))

    def pi(self) -> arb:
        return arb.pi()

    def sqrt(self, value: arb) -> arb:
        return value.sqrt()

    def sin(self, value: arb) -> arb:
        return value.sin()

    def cos(self, value: arb) -> arb:
        return value.cos()


def in_balls(given: Expression) -> arb:
    """Return the value of an expression, from Arb at 400 bits."""
    balls = Balls()
    values = {}
    for name, value in given.parameters:
        times, plus = angle(value)
        values[name] = balls.number(plus) + balls.pi() * balls.number(times)
    return given.evaluated(balls, values)


@pytest.mark.parametrize(
    ("given", "text", "value"),
    [
        ("0.15" * W**2, "0.15*w**2", Fraction("0.4335")),
        (0.5 * W, "0.5*w", Fraction("0.85")),
        (Fraction(1, 3) * W - 1, "1/3*w-1", Fraction("1.7") / 3 - 1),
        (Decimal("0.10") + W, "0.10+w", Fraction("1.8")),
        (np.float64(0.25) + W, "0.25+w", Fraction("1.95")),
        (np.int64(2) * W, "2*w", Fraction("3.4")),
        ((W + 1) * (W - 1), "(w+1)*(w-1)", Fraction("1.89")),
        (2 - (W - 1), "2-(w-1)", Fraction("1.3")),
        (1 / (W / 2), "1/(w/2)", 2 / Fraction("1.7")),
        (W / 2 / W, "w/2/w", Fraction(1, 2)),
        (-(W**2), "-w**2", -Fraction("2.89")),
        ((-W) ** 2, "(-w)**2", Fraction("2.89")),
        (W**-2, "w**-2", 1 / Fraction("2.89")),
        (expression("sqrt(w**2)", w="1.7"), "sqrt(w**2)", Fraction("1.7")),
        (expression("cos(2*pi/3) + sin(pi/6)"), "cos(2*pi/3)+sin(pi/6)", Fraction(0)),
        (expression("2*pi*w/pi", w="1/3"), "2*pi*w/pi", Fraction(2, 3)),
    ],
)
def test_what_is_rational_stays_exact_and_prints_as_it_was_written(
    given: Expression, text: str, value: Fraction
) -> None:
    assert (str(given), as_fraction(given)) == (text, value)
    assert given.is_exact
    # The text alone has the same meaning.
    assert expression(text, **dict(given.parameters)) == given


def test_a_float_in_an_expression_is_that_double_and_a_text_is_that_decimal() -> None:
    assert as_fraction(0.15 * W) == Fraction(0.15) * Fraction("1.7")
    assert as_fraction("0.15" * W) == Fraction("0.15") * Fraction("1.7")
    assert str(0.15 * W) == "float(0.15)*w"
    assert eval(repr(0.15 * W), {"expression": expression}) == 0.15 * W


@pytest.mark.parametrize(
    "text",
    [
        "sqrt(2)", "sqrt(w)", "sin(3)", "cos(1e22)", "sin(w)*cos(w)", "pi**2", "1/pi", "w*pi+w",
        "sqrt(1e-300)", "cos(355)", "sin(pi*w)", "sqrt(sqrt(w)+pi)", "sin(1e-60)", "cos(pi/2+1e-30)",
        "(sqrt(2)+1)**64", "(pi-3.14159265358979)**-5", "sin(710)*1e250", "cos(103993/33102)+1",
    ],
)  # fmt: skip
def test_irrational_values_are_rounded_correctly(text: str) -> None:
    given = expression(text, w="1.7")
    ball = in_balls(given)
    low, high = (Fraction(*_ratio(end)) for end in (ball.lower(), ball.upper()))

    assert float(low) == float(high), "the ball decides the rounding"
    assert float(given) == float(low)
    assert abs(as_fraction(given) - low) <= abs(low) / 2**250


def _ratio(value: arb) -> tuple[int, int]:
    mantissa, exponent = value.man_exp()
    number = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return number.numerator, number.denominator


NUMBERS = st.one_of(
    st.integers(-20, 20),
    st.floats(-8, 8, allow_nan=False).filter(lambda x: x == 0 or abs(x) > 1e-6),
    st.fractions(-5, 5, max_denominator=40),
    st.decimals(-9, 9, allow_nan=False, places=3),
)


@st.composite
def trees(draw: Any, depth: int = 4) -> Any:
    """Draw an expression of u and w."""
    if depth == 0 or draw(st.booleans()):
        own = parameter(draw(st.sampled_from("uw")), "1.7")
        return own * draw(NUMBERS) if draw(st.booleans()) else own
    kind = draw(st.sampled_from(["+", "-", "*", "/", "**", "neg", "sin", "cos", "sqrt", "number"]))
    one = draw(trees(depth - 1))
    if kind in ("sin", "cos", "sqrt"):
        return getattr(one, kind)() if kind != "sqrt" else (one * one + 1).sqrt()
    if kind == "neg":
        return -one
    if kind == "**":
        return one ** draw(st.integers(-3, 4))
    if kind == "number":
        number = draw(NUMBERS)
        return draw(st.sampled_from([one + number, number - one, one * number, number * one]))
    other = draw(trees(depth - 1))
    return {"+": one + other, "-": one - other, "*": one * other}.get(kind) or one / other


@settings(max_examples=150, deadline=None)
@given(trees(), st.fractions(Fraction(1, 10), 3, max_denominator=50))
def test_the_value_and_the_derivative_of_any_expression_are_those_of_an_independent_arithmetic(
    given: Expression, value: Fraction
) -> None:
    given = given.replaced({"u": value})
    assert expression(str(given), **dict(given.parameters)) == given
    if given.problem() is not None:
        return
    ball = in_balls(given)
    assert not ball.is_finite() or ball.overlaps(arb(_q(as_fraction(given))) * arb(1, 2.0**-240))
    if given.problem() is not None or not ball.is_finite():
        return
    derivative = given.derivative("w")
    if derivative.problem() is not None:
        return
    step = Fraction(1, 10**30)
    here = dict(given.parameters).get("w", "1.7")
    ends = [in_balls(given.replaced({"w": as_fraction(here) + s * step})) for s in (-1, 1)]  # type: ignore[arg-type]
    quotient = (ends[1] - ends[0]) / (2 * arb(_q(step)))
    size = 1 + abs(float(derivative))
    assert not quotient.is_finite() or abs(float(quotient) - float(derivative)) < 1e-9 * size**3


def _q(value: Fraction) -> fmpq:
    return fmpq(value.numerator, value.denominator)


def test_expressions_are_values() -> None:
    made = "0.15" * W**2
    assert made == expression(" 0.15 * w ** 2 ", w=Decimal("1.7")).replaced({"w": "1.7"})
    assert made != made.replaced({"w": "1.8"})
    assert len({made, expression("0.15*w**2", w="1.7")}) == 1
    for copied in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
        assert (copied, hash(copied), repr(copied)) == (made, hash(made), repr(made))
    with pytest.raises(AttributeError):
        made.text = "w"  # type: ignore[misc]
    assert repr(W) == "parameter('w', '1.7')"
    assert made.names == ("w",)


def test_numpys_functions_are_those_of_expressions() -> None:
    given: Any = W
    assert np.sqrt(given) == expression("sqrt(w)", w="1.7")
    assert np.sin(given) + np.cos(given) == expression("sin(w)+cos(w)", w="1.7")


def test_multiples_of_pi_make_expressions() -> None:
    phase = pc.pi_times(-1, 2) + W
    assert angle(phase) == (Fraction(-1, 2), Fraction("1.7"))
    assert cos_sin(pc.pi_times(1) * parameter("n", 3) / 2) == (0.0, -1.0)
    assert angle("pi/3" - W) == (Fraction(1, 3), -Fraction("1.7"))
    assert float(parameter("phi", "pi/4").cos()) == math.sqrt(0.5)


REFUSED = {
    "": "no expression",
    "   ": "no expression",
    "w w": "a sign, a number",
    "w * * 2": "a sign, a number",
    "3 4": "a sign, a number",
    "2w": "'2w' in an expression",
    "(((": "a sign, a number",
    "2^3": "write ** for powers",
    "u+v*w": "u and v are no parameters; there are w",
    "ww": "ww is no parameter; did you mean w?",
    "2**10**10": "a whole number from -64 to 64",
    "2**w": "a whole number from -64 to 64",
    "w**0.5": "sqrt(x) the power 1/2",
    "w**65": "a whole number from -64 to 64",
    "sqrt": "sqrt without a value",
    "sqrt()": "sqrt takes one value",
    "open(3)": "open() is not allowed; sqrt, sin and cos are",
    "__import__(w)": "__import__() is not allowed",
    "w.real": "'.real' in an expression",
    "(1).real": "'.real' in an expression",
    "w(2)": "w() is not allowed",
    "2(w)": "write * between",
    "[w]": "in an expression",
    "w if w else w": "if in an expression; it is a word of Python",
    "w and w": "and in an expression; it is a word of Python",
    "lambda": "lambda in an expression; it is a word of Python",
    "True": "True in an expression; it is a word of Python",
    "1e999": "beyond the range of floats",
    "0x10": "in an expression",
    "1_0": "in an expression",
    "w\n+1;2": "in an expression",
    "float(w)": "float() takes one number",
    "é": "in an expression",
    "-" * 900 + "1": "deep",
    "+".join(["(w"] * 300) + ")" * 300: "expression",
    "(" * 300 + "w" + ")" * 300: "a sign, a number",
    "1+" * 600 + "1": "1000 are the most",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_no_expression_is_refused_with_one_sentence(text: str) -> None:
    with pytest.raises(ParameterError) as caught:
        expression(text, w="1.7")
    assert REFUSED[text] in str(caught.value)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1/(w-1.7)", "a division by zero"),
        ("w**-1/(w-w)", "a division by zero"),
        ("1/(sqrt(w)**2-1.7)", "a division by zero"),
        ("sqrt(1-w)", "the square root of a negative number"),
        ("sqrt(1-sqrt(w))", "the square root of a negative number"),
        ("(1e300*w)**2", "beyond the range of floats, 5e-324 to 1.8e308"),
        ("((((9e99**64)**64)**64)**64)**64", "beyond the range of floats, 5e-324 to 1.8e308"),
        ("((((9e99**64)**64)**64)**64)**-64", "beyond the range of floats, 5e-324 to 1.8e308"),
    ],
)
def test_an_expression_without_a_value_is_a_fault_of_the_field_that_it_stands_in(
    text: str, reason: str
) -> None:
    given = expression(text, w="1.7")
    assert number_problem(given) == reason
    with pytest.raises(ParameterError, match="stiffness = .*" + reason[:20]):
        pc.Oscillator(stiffness=given)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("omega", "a word of paths"),
        ("start", "a word of paths"),
        ("pi", "a word of paths"),
        ("x", "a word of paths"),
        ("2w", "no name"),
        ("a.b", "no name"),
        ("ω", "no name"),
        ("", "no name"),
        (3, "no name"),
    ],
)
def test_a_parameter_is_not_named_like_a_path(name: Any, reason: str) -> None:
    with pytest.raises(ParameterError, match=reason):
        parameter(name, 1)


@pytest.mark.parametrize("value", ["one", math.nan, "1e999", True, None, W, [1]])
def test_the_value_of_a_parameter_is_a_number(value: Any) -> None:
    with pytest.raises(ParameterError, match="w = "):
        parameter("w", value)


def test_one_name_has_one_value() -> None:
    other = parameter("w", "1.8")
    with pytest.raises(ParameterError, match=r"one name has one value"):
        W * other
    with pytest.raises(ParameterError, match=r"one name has one value"):
        pc.simulate(pc.Oscillator(), pc.cosine(W, amplitude=other), t_end=1)
    with pytest.raises(ParameterError, match=r"one name has one value"):
        pc.simulate(pc.Structure([1], [W]), pc.Loads({0: pc.cosine(other)}), t_end=1)
    # The same number in other words.
    assert (W * parameter("w", Fraction(17, 10))).parameters == (("w", "1.7"),)


@pytest.mark.parametrize("given", [W, "0.15" * W**2, W.sqrt(), pc.pi_times(2) * W])
def test_an_expression_is_a_number_everywhere(given: Expression) -> None:
    as_number: list[Phase] = [given]
    assert [as_float(value) for value in as_number] == [float(given)]
    assert float(as_fraction(given)) == float(given)


@pytest.mark.parametrize("function", [np.exp, np.log, np.tan])
def test_functions_of_numpy_that_are_not_allowed_say_so(function: Any) -> None:
    with pytest.raises(ParameterError, match="only sqrt, sin and cos of it are allowed"):
        function(W)
    with pytest.raises(ParameterError, match="no exponent"):
        W**W
