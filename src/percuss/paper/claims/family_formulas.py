"""The formulas of section 3's example and of appendix A, as shown, as printed and as right.

One rule for the signs: in the text every plus survives and a minus may be lost. A formula is read
as it is shown, with a minus where one may be lost if it is right with that minus alone.
"""

from __future__ import annotations

import sympy
from sympy import Abs, Eq, Ge, Le, Mod, Piecewise, Tuple, cos, pi, sin, sqrt

from percuss.paper.formula import Formula, ordered

A, D, V, t = sympy.symbols("A D V_0 t", real=True)
CONTACT = sympy.Symbol("t_*", real=True)
m = sympy.Symbol("m", integer=True, positive=True)
k = sympy.Symbol("k", integer=True, nonnegative=True)
s = sympy.Symbol("s_k", integer=True, nonnegative=True)
KICK = 2 / (m + 1) * sin(pi / (m + 1))
AMPLITUDE = sympy.Symbol("A")
LIMIT = sympy.Symbol("V^*")
EVEN = Eq(Mod(m, 2), 0)
SIGNS = "every plus survives in the text, a minus may be lost"

EQ10 = Formula(
    "10",
    "sk þm if k is even ... sk þ1 if k is odd",
    Eq(sympy.Symbol("s_{k+1}"), Piecewise((s + m, Eq(Mod(k, 2), 0)), (s + 1, True))),
)
EQ11 = Formula(
    "11",
    "xn ðtÞ ¼ A sin tcos 2t þ p p þ cos mþ 1 mþ1",
    Eq(sympy.Symbol("x"), A * sin(t) - cos((2 * t + pi) / (m + 1)) + cos(pi / (m + 1))),
    lost=f"the minus before the first cosine ({SIGNS})",
)
EQ12 = Formula(
    "12",
    "f ðtÞ ¼ ð3mÞðm þ 5Þ ðm þ1Þ2 cos 2t þ p p þ cos m þ1 mþ1",
    Eq(
        sympy.Symbol("f"),
        (3 - m) * (m + 5) / (m + 1) ** 2 * cos((2 * t + pi) / (m + 1)) + cos(pi / (m + 1)),
    ),
    Eq(
        sympy.Symbol("f"),
        (1 - m) * (m + 3) / (m + 1) ** 2 * cos((2 * t + pi) / (m + 1)) + cos(pi / (m + 1)),
    ),
    lost=f"the minus of 3 - m ({SIGNS})",
)
EQ13_LONG = Formula(
    "13",
    "V 0 þ m 2þ 1 sin m pþ 1",
    Eq(AMPLITUDE, V + KICK),
    Eq(AMPLITUDE, V - KICK),
    lost="a minus may be lost before V0; the amplitude is wrong with it and without it, so that "
    "it is read as it is shown",
)
EQ13_SHORT = Formula(
    "13",
    "V 0 þ m 2þ 1 1 þ2ð1Þm sin m pþ 1",
    Eq(AMPLITUDE, -V + KICK * ordered(1, 2 * (-1) ** m)),
    lost=f"the minus before V0 and that of (-1)^m ({SIGNS}); without the first the amplitude "
    "is wrong",
)
EQ14 = Formula(
    "14",
    "V 0 þ m 4þ 1 sin m pþ 1 , if m is even V1 ¼ if m is odd V 0,",
    Eq(sympy.Symbol("V_1"), Piecewise((-V + 2 * KICK, EVEN), (V, True))),
    lost=f"the minus before the first V0 ({SIGNS}); without it the velocity is wrong",
)
EQA3 = Formula(
    "A3",
    "0   0  u ðtÞ Z w ðtÞ",
    Ge(Abs(sympy.Symbol("u'")), Abs(sympy.Symbol("w'"))),
    Ge(sympy.Symbol("u'"), sympy.Symbol("w'")),
    lost="the primes stand before the line and the bars are blanks",
)
EQA4 = Formula(
    "A4",
    "V 0 o V n ðmÞ ¼ 4 p sin mþ 1 mþ1",
    Eq(LIMIT, 4 / (m + 1) * sin(pi / (m + 1))),
)
EQA5 = Formula(
    "A5",
    "V n ð3Þ ¼ 1þ 3 2=4",
    Eq(LIMIT, 1 + 3 * sqrt(2) / 4),
    lost="the root stands before the line",
)
EQA6_A7 = Formula(
    "A6",
    "D sin t n cos 2tmnþþ1p þ cos m pþ 1 ¼ 0 : D cos t n þ m 2þ 1 sin 2tmnþþ1p ¼ 0 ... "
    "V 0 2 p sin r D, mþ1 m þ1",
    Tuple(
        Eq(D * sin(CONTACT) - cos((2 * CONTACT + pi) / (m + 1)) + cos(pi / (m + 1)), 0),
        Eq(D * cos(CONTACT) + 2 / (m + 1) * sin((2 * CONTACT + pi) / (m + 1)), 0),
        Le(V - KICK, D),
    ),
    lost=f"a minus in the first line, and that in (A7) ({SIGNS})",
)
EQA8 = Formula(
    "A8",
    "sin ð2t n þ pÞ=ðm þ 1Þ 2 p sin  V n ðmÞ ¼ mþ1 cos t n mþ1",
    Eq(
        LIMIT,
        2 / (m + 1) * (sin(pi / (m + 1)) - sin((2 * CONTACT + pi) / (m + 1)) / cos(CONTACT)),
    ),
    lost=f"the minus between the two sines ({SIGNS})",
)
