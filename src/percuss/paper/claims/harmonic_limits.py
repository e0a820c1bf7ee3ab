"""Equations (24) to (26) and table 2 held against evidence: where the eigenset is left."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, partial

import numpy as np
import sympy
from sympy import Eq, Integer, Rational, Symbol, cos, pi, sin, tan

from percuss import numerics
from percuss.certified import Ball
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.motion.eigenset_forms import harmonic_critical_velocity
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import in_ball, limit_velocity
from percuss.paper.claims.comparisons import (
    ROUNDING,
    WALL,
    apart,
    furthest,
    last_unchanged,
    latest,
)
from percuss.paper.claims.harmonic_formulas import EQ23, bound_steps, end_steps, j, n, s, t
from percuss.paper.claims.harmonic_formulas import V as VELOCITY
from percuss.paper.evidence import Deduction, Step, compare, counted
from percuss.paper.formula import Formula, ordered
from percuss.paper.proof import identity, sign, theorem
from percuss.paper.statement import Finding, Statement

THEORY = "paper-harmonics.md"
TABLE_2 = {
    5: "0.26",
    7: "0.18",
    9: "0.138",
    11: "0.112",
    13: "0.095",
    15: "0.082",
}
ODD = (3, *TABLE_2)
# V_max(3) of the article.
HALF = Rational(1, 2)

m = Symbol("m", integer=True, positive=True)
xi = Symbol("xi", real=True)
V = Symbol("V_{2p}", real=True)
WAVE = (-1) ** m / (n**2 - 1)
LOST = "the blanks before fractions and in exponents are restored minus signs: "
EQ24 = Formula(
    "24",
    "xðxÞ ¼ V 2p  n2n1 cos x þ ð1Þm n2 1 cos nx ¼ 0, n ¼ 2m þ 1",
    Eq(Symbol("x"), ordered((V - n / (n**2 - 1)) * cos(xi), WAVE * cos(n * xi))),
    lost=LOST + "V_2p - n/(n^2-1), (-1)^m, n^2-1",
)
EQ24_VELOCITY = Formula(
    "24",
    "x0 ðxÞ ¼ V 2p  n2n1 sin x þ ð1Þm n n2 1 sin nx ¼ 0",
    Eq(Symbol("x'"), ordered((V - n / (n**2 - 1)) * sin(xi), n * WAVE * sin(n * xi))),
    lost=LOST + "V_2p - n/(n^2-1), (-1)^m, n^2-1",
)
EQ25 = Formula("25", "tan x ¼ n tannx", Eq(tan(xi), n * tan(n * xi)))
EQ26 = Formula(
    "26",
    "V k ¼ V 2p rV max  1 m cos nx nð1Þ , cos x n2 1",
    Eq(Symbol("V_{max}"), ordered(n, -((-1) ** m) * cos(n * xi) / cos(xi)) / (n**2 - 1)),
    lost=LOST + "n - (-1)^m, n^2-1",
)


def _odd(expression: sympy.Expr) -> sympy.Expr:
    """Return an expression for n = 2 m + 1."""
    return expression.subs(n, 2 * m + 1)


def _two_turns(number: int, v0: float) -> Trajectory:
    return simulate(WALL, sine(number), v0=v0, t_end=4.5 * math.pi)


def _leaves(number: int, v0: float) -> bool:
    """Return whether the impacts of two turns are not the eigenset."""
    run = _two_turns(number, v0)
    eigenset = np.asarray(math.pi * np.arange(1, 5), dtype=np.float64)
    return len(run.impacts) != 4 or furthest(run, eigenset) > 1e-8


@cache
def _simulated_limit(number: int) -> float:
    """Return by halving up to which V0 the eigenset is left; V_max is not used."""
    return last_unchanged(partial(_leaves, number), 0.5 / number, 1.0)


def critical_ball(number: int) -> Ball:
    """Return V_max as a ball, from what is proven about starts on either side of it.

    Examples
    --------
    >>> round(critical_ball(3).mid(), 9)
    0.5
    """
    return limit_velocity(sine(number), Fraction(1, 100 * number), 1)


def _shifted_steps(first: Formula, second: Formula) -> tuple[Step, ...]:
    """Return the steps that (24) is the flight of (23) and the condition that it is at rest."""
    flight = EQ23.printed.lhs.subs(VELOCITY, V)
    shifted = _odd(flight).subs(t, xi + 3 * pi / 2)
    line, rest = _odd(first.printed.rhs), _odd(second.printed.rhs)
    return (
        *(
            identity(
                f"x of (23) at xi + 3 pi/2, {parity} m, is the first line",
                shifted.subs(m, 2 * j + odd),
                line.subs(m, 2 * j + odd),
            )
            for odd, parity in ((0, "even"), (1, "odd"))
        ),
        identity("its velocity is minus the second line", line.diff(xi), -rest),
    )


def _touch_steps(limit: Formula) -> tuple[Step, ...]:
    """Return the steps that the first extra root is a double one, and that xi >= 0 is enough."""
    line, size = _odd(EQ24.printed.rhs), _odd(limit.printed.rhs)
    return (
        identity("x(-xi) = x(xi): xi >= 0 is enough", line.subs(xi, -xi), line),
        identity("x is cos xi (V - W), W the right side of (26)", line, cos(xi) * (V - size)),
        *end_steps(),
        theorem(
            "So it does at both ends; by the bound it is positive inside. It takes its largest "
            "value V_max inside, where W' = 0 (Weierstrass, Fermat): with V falling the first root "
            "is there"
        ),
        identity(
            "and there x = 0 and x' = 0 at V = W",
            line.diff(xi).subs(V, size),
            -cos(xi) * size.diff(xi),
        ),
    )


def _shifted_flight(first: Formula = EQ24, second: Formula = EQ24_VELOCITY) -> Finding:
    """Deduce both lines of (24), the double root, and compare with simulated second flights."""
    steps = (*_shifted_steps(first, second), *bound_steps(), *_touch_steps(EQ26))
    at = np.linspace(-0.499, 0.499, 999) * math.pi
    in_x, in_v = [], []
    for one in ODD:
        v0 = 1.01 * harmonic_critical_velocity(one)
        run = simulate(WALL, sine(one), v0=v0, t_end=7.0)
        x, v = run(at + 1.5 * math.pi)
        in_x.append(apart(x, first.side(V, n, m, xi)(v0, one, one // 2, at)))
        in_v.append(apart(v, -second.side(V, n, m, xi)(v0, one, one // 2, at)))
    return Finding(
        (
            Deduction("(24), and that the first extra root is a double one", steps),
            compare(
                "x of simulated flights minus the first line", max(in_x), 0.0, ROUNDING, error=1e-13
            ),
            compare("x' plus the second line, n = 3 to 15", max(in_v), 0.0, ROUNDING, error=1e-13),
        ),
        remark="The second line is minus the velocity; as it is set to zero, its roots are right.",
        study=motion_text(run),
    )


def _roots(number: int) -> list[float]:
    """Return the roots of tan xi = n tan(n xi) in [0, pi/2), 0 among them.

    Between pi/2 - pi/n and pi/2, where both sides have a pole, there is none.
    """
    at = np.linspace(1e-9, (0.5 - 0.5 / number) * math.pi, 400 * number)
    values = _tilt(number, at)
    roots = [0.0]
    for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        before = partial(_same_sign, number, float(values[i]))
        roots.append(last_unchanged(before, float(at[i]), float(at[i + 1])))
    return roots


def _tilt(number: int, at: np.ndarray | float) -> np.ndarray:
    """Return (tan xi - n tan(n xi)) cos xi cos(n xi)."""
    across = numerics.sin(at) * numerics.cos(number * at)
    return np.asarray(across - number * numerics.sin(number * at) * numerics.cos(at))


def _same_sign(number: int, value: float, at: float) -> bool:
    return bool(_tilt(number, at) * value > 0.0)


def _third(limit: Formula = EQ26, printed: Rational = HALF) -> Finding:
    """Deduce the contact for n = 3."""
    size = limit.printed.rhs.subs({n: 3, m: 1})
    steps = (
        identity("For n = 3 the right side of (26) is", size, cos(xi) ** 2 / 2),
        identity("That at xi = 0 is V_max", size.subs(xi, 0), printed),
        identity(
            "and on |xi| <= pi/2 all others are smaller, by",
            size.subs(xi, 0) - size,
            sin(xi) ** 2 / 2,
        ),
        identity(
            "x = cos xi (V - cos^2(xi)/2) has a root if and only if 0 < V <= 1/2",
            EQ24.printed.rhs.subs({n: 3, m: 1}),
            cos(xi) * (V - cos(xi) ** 2 / 2),
        ),
    )
    return Finding(
        (
            Deduction("contact at xi = 0, V_max = 1/2", steps),
            in_ball("V_max(3) from starts on either side", critical_ball(3), float(printed)),
        ),
        study=motion_text(_two_turns(3, float(printed))),
    )


def _other_root(first: Formula = EQ24, second: Formula = EQ24_VELOCITY) -> Finding:
    """Deduce what the root pi/2 of (24) asks for."""
    line, rest = _odd(first.printed.rhs), _odd(second.printed.rhs)
    steps = (
        *(
            step
            for odd, parity in ((0, "even"), (1, "odd"))
            for step in (
                identity(
                    f"The first line is zero at pi/2 for every V, {parity} m",
                    line.subs(m, 2 * j + odd).subs(xi, pi / 2),
                    Integer(0),
                ),
                identity(
                    f"the second line is V there, {parity} m",
                    rest.subs(m, 2 * j + odd).subs(xi, pi / 2),
                    V,
                ),
            )
        ),
        *(
            Step(
                f"n = {one}: (26) tends to 0 at pi/2",
                "W \\to 0",
                sympy.limit(EQ26.printed.rhs.subs({n: one, m: one // 2}), xi, pi / 2) == 0,
                "algebra",
            )
            for one in (3, 5)
        ),
    )
    return Finding((Deduction("at xi = pi/2 (24) asks for V = 0", steps),))


def _contact(law: Formula = EQ25) -> Finding:
    """Deduce (25) from (24), and see whether simulated extra impacts lie at its roots."""
    line, rest = (_odd(one.printed.rhs) for one in (EQ24, EQ24_VELOCITY))
    difference = _odd(law.printed.lhs - law.printed.rhs).replace(tan, lambda of: sin(of) / cos(of))
    left = sin(xi) * cos((2 * m + 1) * xi) - (2 * m + 1) * sin((2 * m + 1) * xi) * cos(xi)
    scale = (-1) ** m / ((2 * m + 1) ** 2 - 1)
    steps = (
        *bound_steps(),
        *_touch_steps(EQ26),
        identity(
            "sin xi times the first line, less cos xi times the second, has no V",
            sin(xi) * line - cos(xi) * rest,
            scale * left,
        ),
        identity(
            "which is (25), times cos xi cos n xi",
            sympy.expand(cos(xi) * cos((2 * m + 1) * xi) * difference),
            left,
        ),
        identity(
            "where cos xi cos n xi = 0 inside, that is cos n xi = 0, the left side is not zero: its "
            "square there is",
            (n * sin(n * xi) * cos(xi)) ** 2,
            n**2 * cos(xi) ** 2 * (1 - cos(n * xi) ** 2),
        ),
    )
    numbers = []
    for one in TABLE_2:
        depth = 1e-10
        run = simulate(
            WALL, sine(one), v0=_simulated_limit(one) * (1 - depth), t_end=1.999 * math.pi
        )
        # xi < 0 before the middle of the flight; the dip is as wide as the root of its depth.
        contact = 1.5 * math.pi - latest(run, 1, math.inf)
        roots = np.array(_roots(one))
        nearest = float(roots[np.abs(roots - contact).argmin()])
        what = f"n = {one}: |xi| of the extra impact, nearest root"
        numbers.append(compare(what, contact, nearest, 1e-4, error=2.0 * math.sqrt(depth)))
    return Finding(
        (Deduction("(25) is what (24) leaves without V", steps), *numbers),
        study=motion_text(run),
    )


def _largest_steps() -> tuple[Step, ...]:
    """Return the steps that the largest root of (25) gives the largest value of (26)."""
    size = _odd(EQ26.printed.rhs)
    ratio = ((n - sin(n * s) / sin(s)) / (n**2 - 1)).subs(n, 2 * m + 1)
    fall = n * sympy.cot(n * s) - sympy.cot(s)
    return (
        *(
            identity(
                f"With xi = pi/2 - s, {parity} m, (26) is (n - sin ns/sin s)/(n^2-1)",
                size.subs(m, 2 * j + odd).subs(xi, pi / 2 - s),
                ratio.subs(m, 2 * j + odd),
            )
            for odd, parity in ((0, "even"), (1, "odd"))
        ),
        identity("sin ns returns after 2 pi/n", sin(n * s + 2 * pi), sin(n * s)),
        identity(
            "and is negative first for pi/n < s < 2 pi/n. Later the same sin ns is divided by more, "
            "since sin s grows in a turn by this, positive up to s = pi/2; so the largest value "
            "lies in the first interval:",
            sin(s + 2 * pi / n) - sin(s),
            2 * cos(s + pi / n) * sin(pi / n),
        ),
        identity(
            "It lies where n cot ns = cot s, which is (25); the difference falls, as |sin ns| < "
            "n sin s,",
            fall.diff(s),
            1 / sin(s) ** 2 - n**2 / sin(n * s) ** 2,
        ),
        *bound_steps(),
        theorem(
            "A falling difference has one root in that interval at most, and one where it changes "
            "its sign (intermediate value theorem: Rudin 1976, theorem 4.23); for 0 < s <= pi/n it "
            "begins below 0 and has none. So the root is the smallest s, the largest xi."
        ),
    )


def _which_root(limit: Formula = EQ26, *, every: bool = True) -> Finding:
    """Put every root of (25) into (26), or the largest."""
    size = limit.side(n, m, xi)
    at_zero = limit.printed.rhs.subs({n: 5, m: 2, xi: 0})
    deeper = EQ24.printed.rhs.subs({n: 5, m: 2, V: Rational(1, 4), xi: Rational(66, 100)})
    wrong = (
        identity(
            "xi = 0 is a root of (25)", EQ25.printed.lhs.subs(xi, 0), EQ25.printed.rhs.subs(xi, 0)
        ),
        identity("where (26) gives, for n = 5,", at_zero, Rational(1, 6)),
        sign(
            "But at V = 1/4, xi = 0.66 the first line of (24) is negative: V_max > 1/4", -deeper, {}
        ),
    )
    right, numbers = [], []
    for one in TABLE_2:
        roots = _roots(one)
        value = float(size(one, one // 2, roots[-1]))
        what = f"n = {one}: V_max of starts on either side, that of (26) at xi = {roots[-1]:.6f}"
        right.append(in_ball(what, critical_ball(one), value))
        what = f"n = {one}: number of roots of (25) in [0, pi/2)"
        numbers.append(counted(what, len(roots), (one - 1) // 2))
    refuted = (Deduction("a root of (25) that does not give V_max", wrong, "differs"),)
    return Finding(
        (*(refuted if every else ()), *(() if every else right)),
        (Deduction("the largest root gives V_max", _largest_steps()), *right, *numbers),
        "with the largest of the (n-1)/2 roots of (25) in [0, pi/2), the touch next to the impact",
        remark="The article does not say which root; its table 2 has the right one.",
        study=motion_text(_two_turns(5, critical_ball(5).mid())),
    )


def _table(printed: Mapping[int, str] = TABLE_2) -> Finding:
    """Compare the table with balls that starts on either side give."""
    numbers = []
    for one, text in printed.items():
        half = 0.5 * 10.0 ** -len(text.split(".")[1])
        ball = critical_ball(one)
        numbers.append(in_ball(f"V_max({one}) = {ball.mid():.12f}", ball, float(text), half))
    return Finding(
        tuple(numbers),
        remark="Tolerance: half a unit of the last printed digit.",
        study=motion_text(_two_turns(5, critical_ball(5).mid())),
    )


def keeps_steps() -> tuple[Step, ...]:
    """Return the steps that V_max parts the starts that keep to the eigenset from the others."""
    return (
        *_shifted_steps(EQ24, EQ24_VELOCITY),
        *_touch_steps(EQ26),
        theorem(
            "W is continuous and takes all values from 0 to V_max (intermediate value theorem: Rudin "
            "1976, theorem 4.23). So flights with odd k have an extra root for 0 < V < V_max, and "
            "none for V > V_max; those with even k have none by (22), and by (21) V is the same on "
            "all flights of the eigenset."
        ),
    )


def _both_sides(limit: Formula = EQ26) -> Finding:
    """Deduce what happens on either side, and compare the limit of motions with (26)."""
    size = limit.side(n, m, xi)
    numbers = [
        in_ball(
            f"n = {one}: limit of starts that keep to the eigenset minus the largest of (26)",
            critical_ball(one),
            float(size(one, one // 2, _roots(one)[-1])),
        )
        for one in ODD
    ]
    simulated = [
        compare(
            f"n = {one}: the same limit by halving of simulated starts",
            _simulated_limit(one),
            critical_ball(one).mid(),
            ROUNDING,
            error=2e-12,
        )
        for one in ODD
    ]
    return Finding(
        (
            Deduction(
                "the eigenset for V0 > V_max, other times below", (*bound_steps(), *keeps_steps())
            ),
            *numbers,
            *simulated,
        ),
        remark="At V_max itself the extra root is a touch that changes nothing.",
        study=motion_text(_two_turns(3, _simulated_limit(3))),
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="eq24",
        reference="(24)",
        claim="With t = xi + 2 pi p + 3 pi/2 the second flight is the first line of (24); with V "
        "falling the first extra root is a double one, where the second line vanishes too, and "
        "xi >= 0 is enough.",
        formula=EQ24,
        method="substitution; symmetry and largest value of (26); simulated flights",
        find=_shifted_flight,
    ),
    _of(
        id="eq24-third",
        reference="(24)",
        claim="For n = 3 the contact is at xi = 0 and V_max = 1/2.",
        formula=r"V_{max}(3) = 1/2",
        method="largest value of (26) for n = 3; starts on either side",
        find=_third,
    ),
    _of(
        id="eq24-other-root",
        reference="(24)",
        claim="The other root of (24), xi = pi/2, gives the trivial condition V >= 0.",
        method="both lines of (24) and the limit of (26) at pi/2",
        find=_other_root,
    ),
    _of(
        id="eq25",
        reference="(25)",
        claim="For n = 5, 7, ... the contact is at a root of tan xi = n tan(n xi).",
        formula=EQ25,
        method="elimination of V from (24); extra impacts of motions just below the limit",
        find=_contact,
    ),
    _of(
        id="eq26",
        reference="(25), (26)",
        claim="(26) with a root of (25) gives V_max.",
        formula=EQ26,
        method="a root that does not, and the largest value of (26); starts on either side",
        find=_which_root,
    ),
    _of(
        id="table2",
        reference="table 2",
        claim="V_max = 0.26, 0.18, 0.138, 0.112, 0.095, 0.082 for n = 5, 7, 9, 11, 13, 15.",
        method="starts on either side, proven to keep to the eigenset or to leave it",
        find=_table,
    ),
    _of(
        id="table2-simulated",
        reference="table 2",
        claim="Velocities below V_max give other impact times than the eigenset, those above it "
        "the eigenset.",
        method="values of (26) between impacts; limit of starts on either side, and by halving",
        find=_both_sides,
    ),
)
