"""The motions on Y_m deduced from their formulas, for every m: algebra, and a few inequalities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import sympy
from sympy import Rational, cos, pi, sin

from percuss.certified.numbers import precision
from percuss.paper.claims.family_formulas import (
    CONTACT,
    EQ10,
    EQ11,
    EQ12,
    EQ13_LONG,
    EQ13_SHORT,
    EQ14,
    KICK,
    A,
    V,
    k,
    m,
    s,
    t,
)
from percuss.paper.evidence import Deduction, Step
from percuss.paper.formula import Formula, mathtext
from percuss.paper.proof import enclose, identity, sign

BITS = 128
n = sympy.Symbol("n", integer=True, positive=True)
j = sympy.Symbol("j", integer=True, nonnegative=True)
PARITIES = {"even": 2 * n, "odd": 2 * n + 1}
# Points at which two sides that are not the same are told apart.
POINTS = (1, 2, 3)


@dataclass(frozen=True)
class Equation:
    """Two sides that should be the same for every value of their symbols.

    Parameters
    ----------
    text
        What the equation says.
    name
        Of the left side, in mathtext.
    left, right
        The sides.
    """

    text: str
    name: str
    left: sympy.Expr
    right: sympy.Expr

    def step(self) -> tuple[Step, bool]:
        """Return the step that both sides are the same, or that they differ, and which it is."""
        gap, right = settled(self.left - self.right), mathtext(self.right)
        if gap == 0:
            return Step(self.text, f"{self.name} = {right}", True, "algebra"), True
        differs = any(_is_nonzero(gap, at) for at in POINTS)
        return Step(f"not so: {self.text}", rf"{self.name} \neq {right}", differs, "balls"), False


def deduced(what: str, *parts: Step | Equation) -> Deduction:
    """Return the deduction of a statement, or of its contrary where an equation does not hold."""
    steps = []
    for part in parts:
        step, same = part.step() if isinstance(part, Equation) else (part, True)
        steps.append(step)
        if not same:
            return Deduction(what, tuple(steps), "differs")
    return Deduction(what, tuple(steps))


def settled(expression: sympy.Expr) -> sympy.Expr:
    """Return an expression with all whole multiples of pi taken out of its sines and cosines.

    Examples
    --------
    >>> settled(cos((2 * pi * (m + 1) + pi) / (m + 1)))
    cos(pi/(m + 1))
    """
    for _ in range(3):
        expression = sympy.expand(expression.replace(_is_wave, _settled_wave))
    over, under = sympy.fraction(sympy.together(expression))
    return sympy.expand(over) / under


def _is_wave(expression: Any) -> bool:
    return isinstance(expression, sin | cos)


def _settled_wave(wave: Any) -> sympy.Expr:
    whole = wave.args[0]
    for size in (m, n):
        if whole.has(size):
            whole = sympy.apart(sympy.together(whole), size)
    # Only whole multiples of pi are split off.
    free = [sympy.expand(term) for term in sympy.Add.make_args(sympy.expand(whole))]
    turns = [term for term in free if (term / pi).is_integer]
    rest = sum((term for term in free if not (term / pi).is_integer), sympy.S.Zero)
    sign_of = (-1) ** sympy.expand(sum(turns, sympy.S.Zero) / pi)
    return sympy.simplify(sign_of) * wave.func(rest)


def _is_nonzero(gap: sympy.Expr, at: int) -> bool:
    values = {
        name: sympy.Integer(at) if name.is_integer else Rational(at, 2) + Rational(1, 7)
        for name in gap.free_symbols
    }
    with precision(BITS):
        return not enclose(sympy.expand(gap.subs(values)), {}).contains(0)


def of_parity(expression: sympy.Expr, parity: str) -> sympy.Expr:
    """Return an expression for m = 2n or m = 2n + 1."""
    return expression.subs(m, PARITIES[parity])


def right(formula: Formula) -> sympy.Expr:
    """Return the right side of the right form."""
    return (formula.printed if formula.right is None else formula.right).rhs


def times(recursion: Formula = EQ10) -> tuple[sympy.Expr, sympy.Expr]:
    """Return s_2j and s_2j+1 by a recursion whose two steps add the same to every s."""
    step = recursion.printed.rhs
    even, odd = step.subs(k, 2 * j), step.subs(k, 2 * j + 1)
    after_two = sympy.expand(odd.subs(s, even) - s) * j
    return after_two, even.subs(s, after_two)


def roots(recursion: Formula = EQ10, motion: Formula = EQ11) -> list[Equation]:
    """Return that (11) is zero at the times of (10), for every A."""
    return [
        Equation(
            f"(11) is zero on {which}, whatever A",
            name,
            motion.printed.rhs.subs(t, pi * time),
            sympy.S.Zero,
        )
        for time, which, name in zip(
            times(recursion),
            ("every second time", "the times between"),
            (r"x(\pi s_{2j})", r"x(\pi s_{2j+1})"),
            strict=True,
        )
    ]


def solves(force: sympy.Expr, motion: Formula = EQ11) -> Equation:
    """Return that (11) is a motion under a force."""
    x = motion.printed.rhs
    text = "(11) put into the equation of motion gives the force"
    return Equation(text, "x'' + x", sympy.diff(x, t, 2) + x, force)


def amplitudes(long: Formula = EQ13_LONG, short: Formula = EQ13_SHORT) -> tuple[Any, Any]:
    """Return the amplitudes on both flights: that of the long one right, of the short as printed."""
    return right(long), short.printed.rhs


def starts(amplitude: sympy.Expr) -> list[Equation]:
    """Return that the long flight begins with V0."""
    x = EQ11.printed.rhs.subs(A, amplitude)
    return [Equation("the long flight begins with V0", "x'(0)", sympy.diff(x, t).subs(t, 0), V)]


def rebounds(short: sympy.Expr) -> list[Equation]:
    """Return that the short flight begins with the velocity with which the long one ends."""
    slope = sympy.diff(EQ11.printed.rhs, t).subs(t, pi * m)
    long, _ = amplitudes()
    return [
        Equation(
            f"the short flight begins with the velocity of the rebound, {parity} m",
            r"x'(m\pi + 0) + x'(m\pi - 0)",
            of_parity(slope.subs(A, short) + slope.subs(A, long), parity),
            sympy.S.Zero,
        )
        for parity in PARITIES
    ]


def follows(following: sympy.Expr = EQ14.printed.rhs) -> list[Equation]:
    """Return that the next long flight begins with V1."""
    _, short = amplitudes()
    slope = -sympy.diff(EQ11.printed.rhs, t).subs(t, pi * (m + 1)).subs(A, short)
    return [
        Equation(
            f"the rebound of the short flight, {parity} m",
            r"-x'((m + 1)\pi - 0)",
            of_parity(slope, parity),
            of_parity(following, parity),
        )
        for parity in PARITIES
    ]


def read(what: str, formula: Formula, follow: Callable[[sympy.Expr], list[Equation]]) -> Deduction:
    """Return whether a formula is right as its text shows it, or with a lost minus before V0.

    Parameters
    ----------
    what
        What is deduced.
    formula
        Printed with that minus, or without it.
    follow
        The equations that hold if a right side is right.
    """
    printed = formula.printed.rhs
    steps: list[Step] = []
    for side in (printed.subs(V, -V), printed):
        parts = [equation.step() for equation in follow(side)]
        if all(same for _, same in parts):
            return Deduction(what, (*steps, *(step for step, _ in parts)))
        # One equation that does not hold is enough.
        wrong = next(step for step, same in parts if not same)
        text = f"{wrong.text}, with {reading(side)}"
        steps.append(replace(wrong, text=text))
    return Deduction(what, tuple(steps), "differs")


def reading(side: sympy.Expr) -> str:
    """Return the reading of a right side in words."""
    first = side.args[0].expr if isinstance(side, sympy.Piecewise) else side
    negative = sympy.diff(first, V) == -1
    return "a minus before V0" if negative else "no sign before V0"


@cache
def exists(recursion: Formula = EQ10) -> Deduction:
    """Return the deduction that for 0 < V0 < 2q there is a motion on the times of a recursion."""
    long, short = amplitudes()
    return deduced(
        "for every m and 0 < V0 < 2q a motion with the impact times Y_m",
        *roots(recursion),
        solves(right(EQ12)),
        *starts(long),
        *rebounds(short),
        *follows(),
        *positive_short(),
        *positive_long(),
    )


OMEGA, PHI, TAU = sympy.symbols("omega varphi tau", positive=True)
X = sympy.Symbol("s", real=True)


def positive_short() -> list[Step | Equation]:
    """Return why the short flight is above the wall if it begins away from it."""
    left = OMEGA * cos(OMEGA * X) * sin(X) - sin(OMEGA * X) * cos(X)
    g = sin(OMEGA * pi / 2) * OMEGA * cos(X) - cos(OMEGA * X) + cos(OMEGA * pi / 2)
    steps: list[Step | Equation] = [
        identity(
            "a function that is 0 at s = 0 and rises on (0, pi/2), since the right side is "
            "positive for 0 < omega < 1",
            sympy.diff(left, X),
            (1 - OMEGA**2) * sin(OMEGA * X) * sin(X),
        ),
        identity(
            "so the quotient of the sines rises to its value at s = pi/2",
            sympy.diff(sin(OMEGA * X) / sin(X), X),
            left / sin(X) ** 2,
        ),
        identity(
            "so the function g falls on (0, pi/2), its derivative being negative",
            sympy.diff(g, X),
            -OMEGA * sin(X) * (sin(OMEGA * pi / 2) - sin(OMEGA * X) / sin(X)),
        ),
        identity("to 0: it is positive before", g.subs(X, pi / 2), sympy.S.Zero),
    ]
    _, short = amplitudes()
    flight = EQ11.printed.rhs.subs(A, short).subs(t, pi * (m + Rational(1, 2)) + X)
    shape = g.subs(OMEGA, 2 / (m + 1))
    for parity in PARITIES:
        velocity = of_parity(EQ14.printed.rhs, parity)
        steps.append(
            Equation(
                f"on the short flight x is the sum of V1 cos s and g, {parity} m: positive for "
                "V1 >= 0, and negative near its ends for V1 < 0",
                r"x((m + 1/2)\pi + s)",
                of_parity(flight, parity),
                velocity * cos(X) + of_parity(shape, parity),
            )
        )
    return steps


def positive_long() -> list[Step | Equation]:
    """Return why p, (11) without A sin t, exceeds q |sin t| on the long flight."""
    p, omega = cos(PHI) - cos(OMEGA * t + PHI), OMEGA
    free = EQ11.printed.rhs.subs(A, 0)
    return [
        identity(
            "with phi = pi/(m+1) <= pi/3, h = p - q sin t is 0 at t = 0 and does not fall up to "
            "pi/2, since omega t/2 + phi <= 3 phi/2 <= pi/2 there",
            sympy.diff(p - omega * sin(PHI) * sin(t), t),
            omega * (2 * cos(omega * t / 2 + PHI) * sin(omega * t / 2) + sin(PHI) * (1 - cos(t))),
        ),
        identity(
            "p rises up to the middle m pi/2, where omega t + phi = pi, so p >= p(pi/2) >= q "
            "between pi/2 and the middle",
            sympy.diff(p, t),
            omega * sin(omega * t + PHI),
        ),
        Equation(
            "and p is symmetric about the middle: p > q |sin t| on the whole flight",
            r"p(m\pi - t)",
            free.subs(t, pi * m - t),
            free,
        ),
        identity(
            "|V0 - q| < q for 0 < V0 < 2q, where x = (V0 - q) sin t + p is therefore positive",
            KICK**2 - (V - KICK) ** 2,
            V * (2 * KICK - V),
        ),
    ]


def contact_is_unique() -> list[Step]:
    """Return why for odd m the bound comes from one contact, in the first lobe with sin t < 0."""
    gap = sympy.Symbol("M", positive=True)
    first, second = CONTACT / gap, (CONTACT + pi) / gap
    tilt = _cot(first) + _cot(second) - gap * _cot(CONTACT)
    bend = gap * (1 + _cot(CONTACT) ** 2) - (2 + _cot(first) ** 2 + _cot(second) ** 2) / gap
    return [
        identity(
            "(11) without A sin t as a product",
            cos(PHI) - cos(2 * TAU + PHI),
            2 * sin(TAU) * sin(TAU + PHI),
        ),
        identity(
            "where sin t < 0 the amplitude must not exceed p/|sin t|; |sin t| is the same in every "
            "such lobe, and p rises up to the middle: the first lobe and its mirror image decide",
            sin(CONTACT + 2 * pi * j),
            sin(CONTACT),
        ),
        identity(
            "with M = m + 1, the derivative of the logarithm of this quotient: it is 0 with the "
            "bracket",
            sympy.diff(sum(map(sympy.log, map(sin, (first, second)))), CONTACT) - _cot(CONTACT),
            tilt / gap,
        ),
        identity("the slope of the bracket", sympy.diff(tilt, CONTACT), bend),
        identity(
            "y cos y - sin y is 0 at 0 and falls on (0, pi), so sin y / y falls: on pi < t < 2 pi "
            "and for M >= 4, M sin(t/M) >= 2 and M sin((t + pi)/M) >= 4 sqrt(2)/3",
            sympy.diff(TAU * cos(TAU) - sin(TAU), TAU),
            -TAU * sin(TAU),
        ),
        sign(
            "as 1 + cot^2 = 1/sin^2, the slope over M is at least this: one root, where the "
            "quotient is least, and x and x' are 0",
            1 - Rational(1, 4) - Rational(9, 32),
            {},
        ),
    ]


def _cot(angle: sympy.Expr) -> sympy.Expr:
    return cos(angle) / sin(angle)
