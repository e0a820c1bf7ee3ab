"""Formulas (17) to (23) of the paper, and the steps of proofs that several statements share."""

from __future__ import annotations

import sympy
from sympy import Eq, Symbol, cos, pi, sin

from percuss.paper.evidence import Step
from percuss.paper.formula import Formula, ordered
from percuss.paper.proof import argument, identity, theorem

__all__ = [
    "BEFORE",
    "EQ17",
    "EQ18",
    "EQ18_VELOCITY",
    "EQ19",
    "EQ19_GAIN",
    "EQ20",
    "EQ21",
    "EQ22",
    "EQ23",
    "A",
    "G",
    "V",
    "amplitude_steps",
    "bound_steps",
    "form_steps",
    "gain_steps",
    "j",
    "joined",
    "k",
    "n",
    "s",
    "shifted",
    "t",
]

n, k, i, j = sympy.symbols("n k i j", integer=True, positive=True)
t, s = sympy.symbols("t s", real=True)
A, V, BEFORE = sympy.symbols("A_k V_k V_{k-1}", real=True)
# What the particular solution adds to the velocity at an impact.
G = n / (n**2 - 1)
LOST = "the blanks before the wave, its factor and the exponent are restored minus signs: "

EQ17 = Formula(
    "17",
    "x00 þ x ¼ sin nt, x 40",
    Eq(ordered(Symbol("x''"), Symbol("x")), sin(n * t)),
)
EQ18 = Formula(
    "18",
    "xk ðtÞ ¼ Ak sin t 1 sin nt, n2 1",
    Eq(Symbol("x_k"), A * sin(t) - sin(n * t) / (n**2 - 1)),
    lost=LOST + "-1/(n^2-1)",
)
EQ18_VELOCITY = Formula(
    "18",
    "x0k ðtÞ ¼ Ak cos t n cos nt n2 1",
    Eq(Symbol("x'_k"), A * cos(t) - n * cos(n * t) / (n**2 - 1)),
    lost=LOST + "-n/(n^2-1)",
)
EQ19 = Formula(
    "19",
    "h Ak ¼ ð1Þk V k þ n i , n2 1",
    Eq(A, (-1) ** k * (V + G)),
    lost=LOST + "(-1)^k, n^2-1",
)
EQ19_GAIN = Formula(
    "19",
    "V k ¼ V k1 þ 2n , n2 1",
    Eq(V, BEFORE + 2 * n / (n**2 - 1)),
    lost=LOST + "k-1, n^2-1",
)
EQ20 = Formula(
    "20",
    "Ak ¼ ð1Þk V k þ n n2 1",
    Eq(A, (-1) ** k * V + G),
    lost=LOST + "(-1)^k, n^2-1",
)
EQ21 = Formula("21", "V k ¼ V k1", Eq(V, BEFORE), lost=LOST + "k-1")
EQ22 = Formula(
    "22",
    "h n i 1 sin t 2 sin nt ¼ 0 V 2p þ 2 n 1 n 1",
    Eq((V + G) * sin(t) - sin(n * t) / (n**2 - 1), 0),
    lost=LOST + "n^2-1, -1/(n^2-1)",
)
EQ23 = Formula(
    "23",
    "h V 2p þ n i 1 sin t 2 sin nt ¼ 0 n2 1 n 1",
    Eq((-V + G) * sin(t) - sin(n * t) / (n**2 - 1), 0),
    lost=LOST + "-V, n^2-1, -1/(n^2-1)",
)


def joined(*formulas: Formula) -> str:
    """Return several formulas in one line of mathtext."""
    return r",\ ".join(formula.tex() for formula in formulas)


def of_parity(expression: sympy.Expr, *, odd: int, late: int) -> sympy.Expr:
    """Return an expression for n even or odd, and on flights k even or odd."""
    return expression.subs({n: 2 * j + odd, k: 2 * i + late})


def form_steps(x: Formula = EQ18, velocity: Formula = EQ18_VELOCITY) -> tuple[Step, ...]:
    """Return the steps that (18) solves (17) and vanishes at all multiples of pi."""
    form = x.printed.rhs
    return (
        identity("The form solves (17)", form.diff(t, 2) + form, EQ17.printed.rhs),
        identity("its derivative is the printed velocity", form.diff(t), velocity.printed.rhs),
        identity("it vanishes at each multiple of pi", form.subs(t, pi * k), sympy.Integer(0)),
        theorem("a linear equation has one solution with given x and x' (Picard and Lindelöf)"),
    )


def amplitude_steps(amplitude: Formula, *, odd: int) -> tuple[Step, ...]:
    """Return the steps that the amplitude gives the velocity V_k after the impact at k pi."""
    after = EQ18.printed.rhs.diff(t).subs(A, amplitude.printed.rhs).subs(t, pi * k)
    parity = "odd" if odd else "even"
    return tuple(
        identity(
            f"n {parity}, k {'odd' if late else 'even'}: the flight starts with V_k",
            of_parity(after, odd=odd, late=late),
            V,
        )
        for late in (0, 1)
    )


def gain_steps(amplitude: Formula, gain: Formula, *, odd: int) -> tuple[Step, ...]:
    """Return the steps that the flight from (k-1) pi is reflected with the V_k of a formula."""
    first = amplitude.printed.rhs.subs(V, BEFORE).subs(k, k - 1)
    arriving = -EQ18.printed.rhs.diff(t).subs(A, first).subs(t, pi * k)
    return tuple(
        identity(
            f"{'odd' if late else 'even'} k: at k pi the velocity is reversed",
            of_parity(arriving, odd=odd, late=late),
            of_parity(gain.printed.rhs, odd=odd, late=late),
        )
        for late in (0, 1)
    )


def shifted(amplitude: Formula, *, odd: int, late: int) -> sympy.Expr:
    """Return x on the flight from k pi, at the time s after its start, from an amplitude."""
    return of_parity(
        EQ18.printed.rhs.subs(A, amplitude.printed.rhs).subs(t, s + pi * k), odd=odd, late=late
    )


def bound_steps() -> tuple[Step, ...]:
    """Return the steps that |sin ns| < n sin s between 0 and pi for n >= 2."""
    return (
        identity(
            "Sine of a sum",
            sin(n * s) * cos(s) + cos(n * s) * sin(s),
            sin((n + 1) * s),
        ),
        argument(
            "by induction, as |cos s| < 1 and |cos ns| <= 1 between 0 and pi",
            r"|\sin ns| < n\,\sin s\ (0 < s < \pi,\ n \geq 2)",
        ),
    )
