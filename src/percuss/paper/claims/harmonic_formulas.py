"""Formulas (17) to (23) of the paper, and the steps of proofs that several statements share."""

from __future__ import annotations

from dataclasses import replace

import sympy
from sympy import Eq, Symbol, cos, pi, sin

from percuss.paper.evidence import Step
from percuss.paper.formula import Formula, ordered
from percuss.paper.proof import identity, positive, theorem

n, k, i, j = sympy.symbols("n k i j", integer=True, positive=True)
t, s = sympy.symbols("t s", real=True)
A, V, BEFORE = sympy.symbols("A_k V_k V_{k-1}", real=True)
# What the particular solution adds to the velocity at an impact.
G = n / (n**2 - 1)
# Between two impacts: sin s; the rest n sin s -+ sin ns over n^2 - 1, which the bound makes
# positive; and by how much a velocity is above a limit.
SINE, REST = Symbol(r"{\sin s}", positive=True), Symbol("R", positive=True)
ABOVE, FROM_REST = Symbol("V", positive=True), Symbol("V_k", nonnegative=True)
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
            "The bound holds for n = 2: between 0 and pi this is positive.",
            (2 * sin(s)) ** 2 - sin(2 * s) ** 2,
            4 * sin(s) ** 4,
        ),
        identity(
            "Sine of a sum",
            sin(n * s) * cos(s) + cos(n * s) * sin(s),
            sin((n + 1) * s),
        ),
        theorem(
            "As |cos s| < 1 and |cos ns| <= 1 the bound for n gives that for n + 1 (triangle "
            "inequality), so it holds for all n (induction).",
            r"|\sin ns| < n\,\sin s\ (0 < s < \pi,\ n \geq 2)",
        ),
    )


def positive_even(amplitude: Formula = EQ19) -> tuple[Step, ...]:
    """Return the steps that x > 0 on each flight for even n; the bound is used."""
    least = V * sin(s) + (n * sin(s) - sin(n * s)) / (n**2 - 1)
    return (
        *(
            identity(
                f"n even, k {'odd' if late else 'even'}, t = k pi + s: x is V_k sin s and a rest, "
                "which the bound makes positive",
                shifted(amplitude, odd=0, late=late),
                least.subs(n, 2 * j),
            )
            for late in (0, 1)
        ),
        positive("so x has no root between the impacts for V_k >= 0:", FROM_REST * SINE + REST),
    )


def positive_odd(amplitude: Formula = EQ20) -> tuple[Step, ...]:
    """Return the steps that x > 0 on each flight for odd n and V_k > 2 n/(n^2-1)."""
    rest = (n * sin(s) - sin(n * s)) / (n**2 - 1)
    first, second = V * sin(s) + rest, (V - 2 * G) * sin(s) + (n * sin(s) + sin(n * s)) / (n**2 - 1)
    return (
        *(
            identity(
                f"n odd, k {'odd' if late else 'even'}, t = k pi + s: x is {words} and a rest, "
                "which the bound makes positive",
                shifted(amplitude, odd=1, late=late),
                least.subs(n, 2 * j + 1),
            )
            for late, words, least in (
                (0, "V_k sin s", first),
                (1, "(V_k - 2n/(n^2-1)) sin s", second),
            )
        ),
        positive(
            "so x has no root between the impacts where V_k is larger by V than 2n/(n^2-1):",
            ABOVE * SINE + REST,
        ),
    )


def end_steps() -> tuple[Step, ...]:
    """Return the step that W, the right side of (26) in s = pi/2 - xi, tends to 0 at an impact."""
    limit = (n - sympy.limit(sin(n * s) / sin(s), s, 0)) / (n**2 - 1)
    shown = r"\lim_{s \to 0} \frac{n - \sin ns/\sin s}{n^2 - 1} = 0"
    return (replace(identity("W tends to 0 at s = 0.", limit, sympy.Integer(0)), formula=shown),)
