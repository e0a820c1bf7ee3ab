"""The formulas (28)-(35), and the impact map under sin t in powers of 1/V, as steps of proofs.

t_k and V_k are the instant of an impact and the velocity after it; the smallness is epsilon, the
reciprocal of V_k. The derivation in words is in docs/theory/half-harmonic.md.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import sympy

from percuss.paper.evidence import Deduction, Step
from percuss.paper.formula import Formula, mathtext, ordered, product
from percuss.paper.proof import identity, leading_terms, sign, theorem

TIME = sympy.Symbol("t", real=True)
T_K = sympy.Symbol("t_k", real=True)
V_K = sympy.Symbol("V_k", positive=True)
INTERVAL = sympy.Symbol("xi_k", positive=True)
ELAPSED = sympy.Symbol("tau", real=True)
EPS = sympy.Symbol("epsilon", positive=True)
# Of the article: a_k, the average a of a numerator, and b.
FACTOR, MEAN = sympy.Symbol("a_k", real=True), sympy.Symbol("a", positive=True)
ROOT_FACTOR = sympy.Symbol("b", positive=True)
# The limit of t_k modulo pi.
PHASE = sympy.Symbol("psi", real=True)
SIN, COS = sympy.sin(T_K), sympy.cos(T_K)
_HALF_TURN = sympy.pi / 2
_A, _B, _V = sympy.symbols("A_k B_k V", real=True)
_x, _w = sympy.Symbol("{x_k}(t)"), sympy.Symbol("{x_k}'(t)")
_MOTION = _A * sympy.sin(TIME) + _B * sympy.cos(TIME) - TIME / 2 * sympy.cos(TIME)

EQ27 = Formula(
    "27",
    "x00 þx ¼ sin t, x40",
    sympy.Eq(sympy.Symbol("{x''} + x"), sympy.sin(TIME)),
)
EQ28 = Formula(
    "28",
    "t xk ðtÞ ¼ Ak sin t þ Bk cos t cos t 2",
    sympy.Eq(_x, _MOTION),
    lost="The minus before (t/2) cos t is lost: every plus survives in the extraction.",
)
EQ28_VELOCITY = Formula(
    "28",
    "1 t cos tBk sin t þ sin t x0k ðtÞ ¼ Ak  2 2",
    sympy.Eq(
        _w,
        ordered(
            (_A - sympy.Rational(1, 2)) * sympy.cos(TIME),
            -_B * sympy.sin(TIME),
            TIME / 2 * sympy.sin(TIME),
        ),
    ),
    lost="The two minuses, before 1/2 and before B_k, are lost.",
)
EQ29 = Formula(
    "29",
    "tan xk ¼ cos t k x cos t k þ 2V k k",
    sympy.Eq(sympy.tan(INTERVAL), INTERVAL * COS / ordered(COS, 2 * V_K)),
    sympy.Eq(sympy.tan(INTERVAL), INTERVAL * COS / ordered(COS, 2 * V_K, INTERVAL * SIN)),
)
EQ30 = Formula(
    "30",
    "cos t k ¼ ak cos t k þ2V k",
    sympy.Eq(FACTOR, COS / ordered(COS, 2 * V_K)),
    sympy.Eq(FACTOR, COS / ordered(COS, 2 * V_K, INTERVAL * SIN)),
)
EQ31 = Formula(
    "31",
    "xk ¼ pð1þ ak Þ þOða2k Þ",
    sympy.Eq(INTERVAL, sympy.pi * ordered(1, FACTOR)),
    order="a_k^2",
)
EQ31_FACTOR = Formula(
    "31",
    "ak ¼ cos t k þ OðV 2 k Þ, 2V k",
    sympy.Eq(FACTOR, COS / (2 * V_K)),
    lost="The minus of the exponent in the order is lost.",
    order="V_k^{-2}",
)
EQ32 = Formula(
    "32",
    "Vkþ1 ¼ Vk þ p 2 ½sin t k þ ðp þ 2sint k Þak  þ Oða2k Þ",
    sympy.Eq(
        sympy.Symbol("V_{k+1}"),
        V_K + _HALF_TURN * ordered(SIN, product(ordered(sympy.pi, 2 * SIN), FACTOR)),
    ),
    sympy.Eq(
        sympy.Symbol("V_{k+1}"),
        V_K + _HALF_TURN * ordered(SIN, product(ordered(_HALF_TURN * COS, 2 * SIN), FACTOR)),
    ),
    order="a_k^2",
)
EQ33 = Formula(
    "33",
    "p p=2 cos2 tk þ sin 2tk Vkþ2 ¼ Vk þ þOðV 2 (33) k Þ 2 Vk",
    sympy.Eq(
        sympy.Symbol("V_{k+2}"),
        V_K + _HALF_TURN * ordered(_HALF_TURN * COS**2, sympy.sin(2 * T_K)) / V_K,
    ),
    sympy.Eq(sympy.Symbol("V_{k+2}"), V_K + sympy.pi / 2 * sympy.sin(2 * T_K) / V_K),
    lost="The minus of the exponent in the order is lost.",
    order="V_k^{-2}",
)
TWO_FLIGHTS = Formula(
    "33",
    "2pð1þ ak ÞV 0 ðt k Þ",
    sympy.Eq(sympy.Symbol("t_{k+2} - t_k"), 2 * sympy.pi * ordered(1, FACTOR)),
    sympy.Eq(sympy.Symbol("t_{k+2} - t_k"), 2 * sympy.pi),
)
_RATE = sympy.Derivative(_V, TIME, evaluate=False)
EQ34 = Formula(
    "34",
    "dV a ¼ þOðV 2 Þ dt pV",
    sympy.Eq(_RATE, MEAN / (sympy.pi * _V)),
    sympy.Eq(_RATE, sympy.sin(2 * PHASE) / (4 * _V)),
    lost="The minus of the exponent in the order is lost.",
    order="V^{-2}",
)
EQ35 = Formula(
    "35",
    "pffiffi VðtÞ ¼ b t",
    sympy.Eq(sympy.Symbol("V(t)"), ROOT_FACTOR * sympy.sqrt(TIME)),
)


def _root(square: sympy.Expr) -> sympy.Expr:
    """Return a root that is set as one, not as a quotient of roots."""
    return sympy.Pow(square, sympy.Rational(1, 2), evaluate=False)


# What (34) gives for b, and what is right.
EQ35_FACTOR = Formula(
    "35",
    "",
    sympy.Eq(ROOT_FACTOR, _root(2 * MEAN / sympy.pi)),
    sympy.Eq(ROOT_FACTOR, _root(sympy.sin(2 * PHASE) / 2)),
)

# x and x' a time tau after an impact, t = t_k + tau.
_FLIGHT = (V_K + ELAPSED / 2 * SIN) * sympy.sin(ELAPSED) + COS / 2 * (
    sympy.sin(ELAPSED) - ELAPSED * sympy.cos(ELAPSED)
)
_DENOMINATOR = 2 * V_K + COS + INTERVAL * SIN
# Twice the position a time xi_k after an impact.
LANDING = sympy.sin(INTERVAL) * _DENOMINATOR - INTERVAL * COS * sympy.cos(INTERVAL)
# Of the interval beyond pi, and of the next velocity beyond V_k, in powers of epsilon.
_EXCESS = sympy.pi * COS / 2 * EPS - sympy.pi**2 * SIN * COS / 4 * EPS**2
_GAIN = sympy.pi / 2 * SIN + sympy.pi / 2 * (SIN + sympy.pi / 4 * COS) * COS * EPS


def right_side(formula: Formula) -> sympy.Expr:
    """Return the right side of the right formula, which may be the printed one."""
    return formula.printed.rhs if formula.right is None else formula.right.rhs


def compared(
    what: str,
    steps: tuple[Step, ...],
    stated: sympy.Expr,
    found: sympy.Expr,
    over: dict[sympy.Symbol, tuple[str, str]],
) -> Deduction:
    """Return the deduction that a stated expression is the one found, or that it is another.

    Parameters
    ----------
    what
        What is deduced.
    steps
        That lead to what was found.
    stated, found
        The expression of the article, and the one that the steps give.
    over
        A box over which the two differ, where they are not the same.
    """
    same = identity("What is printed is this.", stated, found)
    if same.holds:
        return Deduction(what, (*steps, same))
    differ = sign(
        "What is printed is another expression: the difference is not zero, as here.",
        sympy.Abs(sympy.simplify(stated - found)),
        over,
    )
    return Deduction(what, (*steps, differ), "differs")


@cache
def flight_equation_steps() -> tuple[Step, ...]:
    """Return the steps from (27) to the equation of the time of flight."""
    height = _FLIGHT.subs(ELAPSED, INTERVAL)
    return (
        identity(
            "With tau = t - t_k the motion between two impacts solves (27).",
            sympy.diff(_FLIGHT, ELAPSED, 2) + _FLIGHT,
            sympy.sin(T_K + ELAPSED),
        ),
        replace(
            identity("It begins on the wall,", _FLIGHT.subs(ELAPSED, 0), sympy.Integer(0)),
            formula=r"x(t_k) = 0",
        ),
        replace(
            identity("with V_k.", sympy.diff(_FLIGHT, ELAPSED).subs(ELAPSED, 0), V_K),
            formula=r"x'(t_k) = V_k",
        ),
        identity("It is zero again at xi_k where this is.", 2 * height, LANDING),
        identity(
            "Division by cos xi_k and the factor of sin xi_k gives tan xi_k.",
            LANDING / (sympy.cos(INTERVAL) * _DENOMINATOR),
            sympy.tan(INTERVAL) - INTERVAL * COS / _DENOMINATOR,
        ),
    )


@cache
def interval_steps() -> tuple[Step, ...]:
    """Return the steps from the equation of the time of flight to its expansion."""
    interval = INTERVAL
    scaled = sympy.sin(interval) * (2 + EPS * COS + EPS * interval * SIN)
    scaled -= EPS * interval * COS * sympy.cos(interval)
    slope = sympy.diff(scaled, interval).subs({interval: sympy.pi, EPS: 0})
    return (
        *flight_equation_steps(),
        replace(
            identity("At 1/V_k = 0 the root pi is simple: its slope is", slope, sympy.Integer(-2)),
            formula=r"-2",
        ),
        theorem(
            "So near pi there is one root, analytic in 1/V_k (implicit function theorem: Krantz & "
            "Parks 2002, theorem 2.3.5)."
        ),
        _expansion(
            "This solves the equation up to the third order.",
            scaled.subs(interval, sympy.pi + _EXCESS),
            3,
            sympy.Integer(0),
            r"\xi_k = " + _in_velocity(sympy.pi + _EXCESS) + " + O(V_k^{-3})",
        ),
    )


@cache
def next_velocity_steps() -> tuple[Step, ...]:
    """Return the steps to the expansion of the velocity after the next impact."""
    interval = sympy.pi + _EXCESS
    after = -sympy.diff(_FLIGHT, ELAPSED).subs({ELAPSED: interval, V_K: 1 / EPS})
    return (
        *interval_steps(),
        _expansion(
            "The velocity after the next impact is -x' at its instant.",
            after - 1 / EPS,
            2,
            _GAIN,
            r"V_{k+1} = V_k + " + _in_velocity(_GAIN) + " + O(V_k^{-2})",
        ),
    )


@cache
def two_impact_steps() -> tuple[Step, ...]:
    """Return the steps to velocity and phase two impacts on."""
    sin, cos = -sympy.sin(T_K + _EXCESS), -sympy.cos(T_K + _EXCESS)
    between = 1 / EPS + _GAIN
    square = sympy.pi**2 * COS**2 / 4 * EPS
    gain = _GAIN + sympy.pi / 2 * sin
    gain += sympy.pi / 2 * (sin + sympy.pi / 4 * cos) * cos / between
    drift = _EXCESS + sympy.pi / 2 * cos / between
    drift -= sympy.pi**2 / 4 * sin * cos / between**2
    expected = sympy.pi / 2 * sympy.sin(2 * T_K) * EPS
    return (
        *next_velocity_steps(),
        _expansion(
            "In the next gain the shifted phase, t_{k+1} - pi, brings a term in cos^2,",
            sympy.pi / 2 * (sin + SIN),
            2,
            -square,
            r"\frac{\pi}{2} \, (\sin t_{k+1} + \sin t_k) = "
            + _in_velocity(-square)
            + " + O(V_k^{-2})",
        ),
        replace(
            identity(
                "which the terms in cos^2 of the two gains cancel.",
                2 * sympy.pi / 2 * sympy.pi / 4 * COS**2 * EPS,
                square,
            ),
            formula=r"2 \, \frac{\pi^2 \cos^2 t_k}{8 \, V_k} - \frac{\pi^2 \cos^2 t_k}{4 \, V_k} = 0",
        ),
        _expansion(
            "The map applied twice.",
            gain,
            2,
            expected,
            r"V_{k+2} = V_k + " + _in_velocity(expected) + " + O(V_k^{-2})",
        ),
        _expansion(
            "The phase has moved by no term of the first or the second order.",
            drift,
            3,
            sympy.Integer(0),
            r"t_{k+2} = t_k + 2 \pi + O(V_k^{-3})",
        ),
    )


@cache
def growth_steps() -> tuple[Step, ...]:
    """Return the steps to the law of growth over many impacts."""
    gain = sympy.pi / 2 * sympy.sin(2 * T_K) * EPS
    rate = gain / (2 * sympy.pi) / EPS
    return (
        *two_impact_steps(),
        replace(
            identity(
                "So V dV/dt over two impacts is this, up to 1/V_k:", rate, sympy.sin(2 * T_K) / 4
            ),
            formula=r"V \frac{dV}{dt} = \frac{1}{4} \sin 2t_k",
        ),
    )


def root_steps(law: sympy.Expr, words: str) -> tuple[Step, Step]:
    """Return the steps that a law V(t) solves the law of growth, said in words, from rest."""
    return (
        identity(words, sympy.diff(law, TIME), ROOT_FACTOR**2 / (2 * law)),
        identity("and is 0 at t = 0.", law.subs(TIME, 0), sympy.Integer(0)),
    )


def no_mean(what: str) -> Deduction:
    """Return the deduction that the numerator of (33) has no positive average over the phase."""
    mean = sympy.integrate(sympy.pi / 2 * sympy.sin(2 * T_K), (T_K, 0, sympy.pi)) / sympy.pi
    gain = sympy.expand((EQ33.printed.rhs - V_K) * V_K)
    as_printed = sympy.integrate(gain, (T_K, 0, sympy.pi)) / sympy.pi
    steps = (
        *two_impact_steps(),
        replace(
            identity(
                "The mean of the printed numerator over the phase is positive,",
                as_printed,
                sympy.pi**2 / 8,
            ),
            formula=r"\frac{1}{\pi} \int_0^\pi \frac{\pi}{2} \, (\frac{\pi}{2} \cos^2 t + \sin 2t) \, dt = \frac{\pi^2}{8}",
        ),
        replace(
            identity("that of the right one is zero:", mean, sympy.Integer(0)),
            formula=r"\frac{1}{\pi} \int_0^\pi \frac{\pi}{2} \sin 2t \, dt = 0",
        ),
    )
    return Deduction(what, steps, "differs")


def _expansion(
    text: str, expression: sympy.Expr, order: int, expected: sympy.Expr, shown: str
) -> Step:
    """Return the step of an expansion in epsilon, shown as a formula in V_k."""
    return replace(leading_terms(text, expression, EPS, order, expected), formula=shown)


def _in_velocity(expression: sympy.Expr) -> str:
    return mathtext(sympy.expand(expression).subs(EPS, 1 / V_K))
