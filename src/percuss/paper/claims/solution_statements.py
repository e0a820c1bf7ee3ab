"""Sections 2 and 3 of the paper on solutions: that they exist, are smooth, and may be added."""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np
import sympy
from flint import arb

from percuss.certified.ball_law import law_of
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import constant_of, precision
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import cosine, sine
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.certain_motion import furthest_apart
from percuss.paper.claims.comparisons import ROUNDING, WALL
from percuss.paper.claims.oscillator_statements import EQ5, FORCE, X1, X2, X
from percuss.paper.evidence import Deduction
from percuss.paper.formula import Formula
from percuss.paper.proof import enclose, identity, leading_terms, sign, theorem
from percuss.paper.statement import Finding, Statement

THEORY = "paper-oscillator.md"
T = sympy.Symbol("t", real=True)
V = sympy.Symbol("V", positive=True)
M = sympy.Symbol("m", integer=True, nonnegative=True)
# A bound of the force, and an instant before t.
BOUND, LATER = sympy.symbols("F s", positive=True)
INTO_THE_WALL = -sympy.cos(2 * T)
# Derivatives whose jumps are computed at an impact.
HIGHEST = 6


def _existence(force: sympy.Expr = INTO_THE_WALL) -> Finding:
    """Start from rest on the wall under a force that pushes into it."""
    x = sympy.dsolve(
        sympy.Function("x")(T).diff(T, 2) + sympy.Function("x")(T) - force,
        ics={sympy.Function("x")(0): 0, sympy.Function("x")(T).diff(T).subs(T, 0): 0},
    ).rhs
    begins = Deduction(
        "x'' + x = -cos 2t has no solution with x > 0 from x = x' = 0",
        (
            identity("the solution of the linear equation obeys it", x.diff(T, 2) + x, force),
            identity("and starts from rest", (x**2 + x.diff(T) ** 2).subs(T, 0), 0 * V),
            leading_terms("it begins below the wall", x, T, 4, -(T**2) / 2),
            sign("and is there at once, for instance from 0.01 to 1", -x, {T: ("0.01", 1)}),
            identity(
                "an impact at t = 0 turns no velocity: (4) leads to the same start",
                -x.diff(T).subs(T, 0),
                x.diff(T).subs(T, 0),
            ),
        ),
        concludes="differs",
    )
    flights = Deduction(
        "one solution from V0 > 0, as long as impact velocities stay above a bound V > 0",
        (
            theorem(
                "A flight is the solution of a linear equation from x = 0 with a given velocity: "
                "there is one (Coddington & Levinson 1955, chapter 3)."
            ),
            identity(
                "With |f| at most F it lies above the following, by the variation of constants, "
                "for 0 < t < pi:",
                V * sympy.sin(T) - sympy.integrate(BOUND * sympy.sin(LATER), (LATER, 0, T)),
                V * sympy.sin(T) - BOUND * (1 - sympy.cos(T)),
            ),
            identity(
                "which is positive while tan(t/2) < V/F: no flight is shorter than 2 arctan(V/F), "
                "so finitely many flights, each determined by the one before, reach any time.",
                (V * sympy.sin(T) - BOUND * (1 - sympy.cos(T))).rewrite(sympy.tan),
                (sympy.sin(T) * (V - BOUND * sympy.tan(T / 2))).rewrite(sympy.tan),
            ),
        ),
    )
    early = arb("0.2")
    # With contact there is one motion.
    pushed = cosine(2, float(force.coeff(sympy.cos(2 * T))))
    return Finding(
        (
            begins,
            enclosed("x(0.2) of the linear equation", enclose(x, {T: early}), 0.0, math.inf),
        ),
        (flights,),
        "from V0 > 0, for as long as the impact velocities do not tend to 0; a mass at rest on the "
        "wall, pushed into it, has no motion that obeys (3) and (4)",
        remark=(
            "What is missing in (3), (4) is contact: where the force pushes into the wall a mass at "
            "rest stays. percuss adds it, and a motion from rest under -cos 2t starts when the "
            "force turns. With contact and an analytic force there is one motion in any case; for "
            "forces that are smooth and not analytic there may be several (Schatzman 1998, Math. "
            "Comput. Modelling 28)."
        ),
        study=motion_text(simulate(WALL, pushed, t_end=10)),
    )


def _derivatives(formula: Formula = EQ5) -> Finding:
    """Follow the jumps at an impact from one derivative to the next but one."""
    (second,) = sympy.solve(formula.printed, X2)
    order = sympy.Symbol("n", integer=True, nonnegative=True)

    def jump(n: sympy.Expr) -> sympy.Expr:
        """0 of x, 2 V of x', and so on: what solves the recursion."""
        return 2 * V * sympy.sin(sympy.pi * n / 2)

    linear = sympy.expand(second - FORCE)
    proof = Deduction(
        "jumps J_n of the n-th derivative at an impact with V > 0",
        (
            identity("x is zero on both sides", jump(sympy.Integer(0)), 0 * V),
            identity("x' goes from -V to V", jump(sympy.Integer(1)), V - -V),
            identity(
                "(5) differentiated n times, with a force that has no jumps: J_(n+2) from J_n",
                sympy.expand_trig(jump(order + 2)),
                linear.coeff(X) * jump(order) + linear.coeff(X1) * jump(order + 1),
            ),
            identity("so even derivatives do not jump", jump(2 * M), 0 * V),
            identity("and all odd ones do, by 2 V or -2 V", jump(2 * M + 1), (-1) ** M * 2 * V),
        ),
    )
    jumps = _jumps_in_balls()
    checks = [
        enclosed(f"jump of derivative {n} over 2 V, sin 2.5t", _part(jumps, n), *around)
        for n, around in ((2, _near(0)), (3, _near(-1)), (4, _near(0)), (5, _near(1)))
    ]
    return Finding(
        (proof, *checks),
        remark="At a graze, an impact with V = 0, no derivative jumps.",
        study=motion_text(_run()),
    )


def _near(value: float) -> tuple[float, float]:
    return value - 1e-9, value + 1e-9


def _part(balls: list[arb] | None, n: int) -> arb | None:
    return None if balls is None else balls[n]


@cache
def _run() -> Trajectory:
    return simulate(WALL, sine("2.5"), v0=1, t_end=10)


def _jumps_in_balls() -> list[arb] | None:
    """Return the jumps of the derivatives at the first impact of a motion, over 2 V."""
    proven = certain_run(_run())
    if proven is None:
        return None
    t, v = proven.impacts.t.arbs[0], proven.impacts.v_after.arbs[0]
    with precision(proven.precision):
        law = law_of(proven.system)
        before, after = (
            EnclosedFlight(law, 0, law.phasors(t), law.places[0], speed).derivatives(
                arb(0), HIGHEST
            )[0]
            for speed in (-v, v)
        )
        return [
            (constant_of(b) - constant_of(a)) / (2 * v) for a, b in zip(before, after, strict=True)
        ]


def _neutral(speed: str = "7/10") -> Finding:
    """Add x0 to a motion, and two motions of one force to each other."""
    free = sympy.Rational(speed) * sympy.sin(T)
    other = sympy.Symbol("y", real=True)
    (second,) = sympy.solve(EQ5.printed, X2)
    proof = Deduction(
        "x0 changes what it is added to, and solutions are not closed under addition",
        (
            identity("x + x0 differs from x by x0", (X + free) - X, free),
            sign(
                "which is positive inside a flight, here for the speed 7/10",
                free,
                {T: ("0.01", "3.14")},
            ),
            identity(
                "the sum of two solutions x, y of (5) obeys it with the force 2f, not f",
                second + second.subs(X, other) + X + other,
                2 * FORCE,
            ),
        ),
        concludes="differs",
    )
    one, two = sympy.symbols("V_a V_b", nonnegative=True)
    free_of = sympy.Lambda(one, one * sympy.sin(T))
    acts = Deduction(
        "the free motions act on the solutions",
        (
            identity(
                "x + x0 obeys (5) with the force of x on every flight of the eigenset, where x0 is "
                "V0 sin(t - pi k):",
                second + sympy.diff(free_of(one), T, 2) + X + free_of(one),
                FORCE,
            ),
            identity(
                "two free motions, added one after the other, are one free motion;",
                (X + free_of(one)) + free_of(two),
                X + free_of(one + two),
            ),
            identity("and that without velocity changes nothing.", X + free_of(0), X),
        ),
    )
    t = np.linspace(0.0, 60.0, 301)
    runs = [simulate(WALL, sine(2), v0=str(sympy.Rational(s) + 1), t_end=60) for s in (speed, "0")]
    gap = furthest_apart([(1.0, runs[0], None), (-1.0, runs[1], None)], t)
    off = f"sin 2t, V0 = 1: largest |(x + x0) - x| for x0 of {speed}"
    return Finding(
        (proof, enclosed(off, gap, -ROUNDING, ROUNDING)),
        (acts,),
        "the free motions are a semigroup, whose neutral element is x0 = 0, and this semigroup acts "
        "on the solutions of (5) on the eigenset: x0 shifts their velocities by V0",
        remark=(
            "A neutral element would leave each solution as it is. The solutions of (5) are no "
            "semigroup: the sum of two of them belongs to twice the force."
        ),
        study=motion_text(runs[0]),
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="existence-uniqueness",
        reference="section 2",
        claim="For given initial conditions the solution of (3) and (4) exists and is unique.",
        method="a start from rest on the wall under -cos 2t",
        find=_existence,
    ),
    _of(
        id="derivatives-at-impacts",
        reference="section 2",
        claim="Under a force with derivatives of all orders x has them between impacts; at impacts "
        "all odd derivatives are discontinuous, and all even ones continuous.",
        method="jumps from (5) differentiated; an impact in ball arithmetic",
        find=_derivatives,
    ),
    _of(
        id="neutral-element",
        reference="section 3",
        claim="The free motion x0 plays the role of a neutral element in a semigroup of solutions "
        "of (5) on the eigenset.",
        method="x + x0 beside x; the equation that a sum of solutions obeys",
        find=_neutral,
    ),
)
