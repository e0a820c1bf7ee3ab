"""The formulas (37)-(40), and the motions under cos t from the eigenset, as steps of proofs."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import sympy

from percuss.paper.evidence import Step
from percuss.paper.formula import Formula, ordered
from percuss.paper.proof import identity, theorem

TIME = sympy.Symbol("t", real=True)
ELAPSED = sympy.Symbol("tau", nonnegative=True)
A_K, B_K = sympy.symbols("A_k B_k", real=True)
V_K = sympy.Symbol("V_k", nonnegative=True)
COUNT = sympy.Symbol("k", integer=True)
SIGN = (-1) ** COUNT
_HALF = sympy.Rational(1, 2)
_x, _w = sympy.Symbol("{x_k}(t)"), sympy.Symbol("{x_k}'(t)")
_later, _last = sympy.Symbol("V_{k+1}"), sympy.Symbol("V_{k+2}")

EQ37 = Formula(
    "37",
    "t sin t xk ðtÞ ¼ Ak  2",
    sympy.Eq(_x, (A_K - TIME / 2) * sympy.sin(TIME)),
    sympy.Eq(_x, ordered((A_K + TIME / 2) * sympy.sin(TIME), B_K * sympy.cos(TIME))),
    lost="A sign before t/2 is lost; every plus survives in the extraction, so it was a minus.",
)
EQ37_VELOCITY = Formula(
    "37",
    "t 1 x0k ðtÞ ¼ Ak  cos t sin t 2 2",
    sympy.Eq(_w, (A_K - TIME / 2) * sympy.cos(TIME) - _HALF * sympy.sin(TIME)),
    sympy.Eq(
        _w,
        ordered(
            (A_K + TIME / 2) * sympy.cos(TIME),
            _HALF * sympy.sin(TIME),
            -B_K * sympy.sin(TIME),
        ),
    ),
    lost="The signs before t/2 and before 1/2 are lost, so both were minuses.",
)
EQ38 = Formula(
    "38",
    "t xk ðtÞ ¼ V k þ ð1Þk sin t, t ¼ tkp, 0 r t r p 2",
    sympy.Eq(_x, ordered(V_K, SIGN * ELAPSED / 2) * sympy.sin(ELAPSED)),
    lost="The minus of (-1)^k is lost.",
)
EQ38_VELOCITY = Formula(
    "38",
    "t ð1Þk cos t sin t (38) x0k ðtÞ ¼ V k þð1Þk 2 2",
    sympy.Eq(
        _w,
        ordered(
            ordered(V_K, SIGN * ELAPSED / 2) * sympy.cos(ELAPSED),
            -SIGN / 2 * sympy.sin(ELAPSED),
        ),
    ),
    sympy.Eq(
        _w,
        ordered(
            ordered(V_K, SIGN * ELAPSED / 2) * sympy.cos(ELAPSED),
            SIGN / 2 * sympy.sin(ELAPSED),
        ),
    ),
    lost="The sign between the two terms is lost, so it was a minus; so is that of (-1)^k, twice.",
)
EQ39 = Formula(
    "39",
    "V k þ 1 ¼ V k þ ð1Þk p 2",
    sympy.Eq(_later, ordered(V_K, SIGN * sympy.pi / 2)),
    lost="The minus of (-1)^k is lost.",
)
EQ39_TWICE = Formula("39", "Vkþ2 ¼ Vk", sympy.Eq(_last, V_K))
EQ40 = Formula(
    "40",
    "t xk ðtÞ ¼ V k  sin t, if k is odd, 2",
    sympy.Eq(_x, (V_K - ELAPSED / 2) * sympy.sin(ELAPSED)),
    lost="The minus before t/2 is lost.",
)


def force_of(motion: sympy.Expr, time: sympy.Symbol) -> sympy.Expr:
    """Return x'' + x of a motion."""
    return sympy.diff(motion, time, 2) + motion


@cache
def on_eigenset_steps(motion: sympy.Expr = EQ38.printed.rhs) -> tuple[Step, ...]:
    """Return the steps that a motion is the flight from an impact at k pi with V_k."""
    speed = sympy.diff(motion, ELAPSED)
    return (
        identity(
            "With tau = t - k pi the force is this,",
            sympy.expand_trig(sympy.cos(COUNT * sympy.pi + ELAPSED)),
            SIGN * sympy.cos(ELAPSED),
        ),
        identity(
            "and the motion solves (36):", force_of(motion, ELAPSED), SIGN * sympy.cos(ELAPSED)
        ),
        replace(
            identity("it begins on the wall", motion.subs(ELAPSED, 0), sympy.Integer(0)),
            formula=r"x(k \pi) = 0",
        ),
        replace(identity("with V_k.", speed.subs(ELAPSED, 0), V_K), formula=r"x'(k \pi) = V_k"),
        theorem("There is no other (linear equations: Coddington & Levinson 1955, chapter 3)."),
        replace(
            identity("At tau = pi it is zero.", motion.subs(ELAPSED, sympy.pi), sympy.Integer(0)),
            formula=r"x((k + 1) \, \pi) = 0",
        ),
    )


@cache
def no_other_root_steps(odd: sympy.Expr = EQ40.printed.rhs) -> tuple[Step, ...]:
    """Return the steps that no zero lies within a flight from the eigenset."""
    motion = EQ38.printed.rhs
    speed = sympy.Symbol("V", positive=True)
    after = speed + sympy.pi / 2
    inner = sympy.Symbol("tau", positive=True)
    return (
        identity("For odd k it is this,", motion.subs(SIGN, -1), odd),
        Step(
            "for even k its first factor is positive, so between 0 and pi it has no zero.",
            r"V_k + \frac{\tau}{2} > 0",
            bool((V_K + inner / 2).is_positive),
            "algebra",
        ),
        identity(
            "For odd k the other factor is zero at 2 V_k alone,",
            sympy.solve(odd / sympy.sin(ELAPSED), ELAPSED)[0],
            2 * V_K,
        ),
        Step(
            "which is beyond pi if the even velocity before, V_k - pi/2, is positive.",
            r"2 V_k - \pi = 2 V_{k-1} > 0",
            bool(sympy.expand(2 * after - sympy.pi).is_positive),
            "algebra",
        ),
    )


@cache
def from_rest_steps() -> tuple[Step, ...]:
    """Return the steps to the motion under cos t from rest on the wall, which does not grow."""
    first = EQ38.printed.rhs.subs({SIGN: 1, V_K: 0})
    second = EQ38.printed.rhs.subs({SIGN: -1, V_K: sympy.pi / 2})
    end = {ELAPSED: sympy.pi}
    zero = sympy.Integer(0)
    inside = sympy.Symbol("s", positive=True)
    return (
        *on_eigenset_steps(),
        identity("From rest the first flight is this,", first, ELAPSED / 2 * sympy.sin(ELAPSED)),
        Step(
            "positive up to its end at pi.",
            r"\frac{\tau}{2} > 0",
            bool((inside / 2).is_positive),
            "algebra",
        ),
        replace(
            identity(
                "The impact at pi has the velocity",
                -sympy.diff(first, ELAPSED).subs(end),
                sympy.pi / 2,
            ),
            formula=r"-x'(\pi) = \frac{\pi}{2}",
        ),
        identity(
            "The second flight is this,", second, (sympy.pi - ELAPSED) / 2 * sympy.sin(ELAPSED)
        ),
        replace(
            identity("which ends at 2 pi on the wall", second.subs(end), zero),
            formula=r"x(2 \pi) = 0",
        ),
        replace(
            identity("without speed,", sympy.diff(second, ELAPSED).subs(end), zero),
            formula=r"x'(2 \pi) = 0",
        ),
        replace(
            identity(
                "where the force is 1 and lifts the mass off: the motion begins again.",
                sympy.cos(2 * sympy.pi),
                sympy.Integer(1),
            ),
            formula=r"\cos 2\pi = 1",
        ),
    )
