"""Statements (36)-(40): the half-harmonic force of the other phase, cos t."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import sympy

from percuss import numerics
from percuss.arrays import Floats
from percuss.io.study_text import motion_text
from percuss.model.exact import Exact
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import impacts_at
from percuss.paper.claims.comparisons import DOUBLES, ONE_FLIGHT, ROUNDING, stated
from percuss.paper.claims.cosine_formulas import (
    A_K,
    B_K,
    ELAPSED,
    EQ37,
    EQ37_VELOCITY,
    EQ38,
    EQ38_VELOCITY,
    EQ39,
    EQ39_TWICE,
    EQ40,
    SIGN,
    TIME,
    V_K,
    force_of,
    from_rest_steps,
    no_other_root_steps,
    on_eigenset_steps,
)
from percuss.paper.claims.cosine_growth import GROWTH_STATEMENTS, T_FIGURE
from percuss.paper.claims.half_harmonic_formulas import compared
from percuss.paper.evidence import Comparison, Deduction, Evidence, compare, counted
from percuss.paper.formula import Formula, numerically
from percuss.paper.models.motions import simulate_all
from percuss.paper.proof import identity
from percuss.paper.statement import Finding

THEORY = "half-harmonic.md"
# Starts on the eigenset.
STARTS = (0.1, 1.0, 10.0)
# (-1)^k as a number, and what the formulas are functions of.
COUNT_SIGN = sympy.Symbol("s_k", real=True)
NAMES = (ELAPSED, V_K, COUNT_SIGN)


@cache
def _eigenset_run(v0: Exact) -> Trajectory:
    return simulate(impact_oscillator(), cosine(1), v0=v0, t_end=30.0 * math.pi + 1.0)


def _by_sign(expression: sympy.Expr) -> Callable[..., Any]:
    """Return an expression as a function of tau, V_k and (-1)^k."""
    return numerically(expression.subs(SIGN, COUNT_SIGN), *NAMES)


def _general_solution(formula: Formula, velocity: Formula) -> Finding:
    # From an impact off the eigenset the motion is no multiple of sin t.
    start = 0.3
    run = simulate(impact_oscillator(), cosine(1), t0=start, v0=1.0, max_impacts=1)
    t = start + np.array([0.1, 0.4, 0.7, 0.95]) * run.impacts.intervals[0]
    x = run(t)[0]

    def apart(*, right: bool) -> Comparison:
        """Fit A_k, and B_k where there is one, to the first instants, and compare at the rest."""
        motion = formula.side(TIME, A_K, B_K, right=right)
        units = [np.array([1.0, 0.0]), np.array([0.0, 1.0])]
        rest = motion(t, 0.0, 0.0)
        columns = [motion(t, *unit) - rest for unit in units]
        used = [column for column in columns if np.abs(column).max() > 0.0]
        matrix = np.array([column[: len(used)] for column in used]).T
        constants = numerics.solve_linear(matrix, (x - rest)[: len(used)])
        fitted = rest + sum(c * column for c, column in zip(constants, used, strict=True))
        what = "largest difference on a flight from t_k = 0.3, V_k = 1"
        return compare(what, float(np.abs(x - fitted).max()), 0.0, DOUBLES, error=ONE_FLIGHT)

    here = dict.fromkeys((TIME, A_K), ("7/10", "7/10"))
    stated = sympy.simplify(force_of(formula.printed.rhs, TIME))
    solves = compared("it solves (36)", (), stated, sympy.cos(TIME), here)
    both = (
        identity(
            "The second line is the derivative of the first.",
            sympy.diff(formula.printed.rhs, TIME),
            velocity.printed.rhs,
        ),
        *solves.steps,
    )
    motion = (formula.printed if formula.right is None else formula.right).rhs
    speed = sympy.diff(motion, TIME)
    general = (
        identity("It solves (36).", force_of(motion, TIME), sympy.cos(TIME)),
        identity(
            "A_k and B_k meet any position and velocity: the determinant is not 0.",
            sympy.diff(motion, A_K) * sympy.diff(speed, B_K)
            - sympy.diff(motion, B_K) * sympy.diff(speed, A_K),
            sympy.Integer(-1),
        ),
    )
    return Finding(
        (Deduction("it solves (36)", both, solves.concludes), apart(right=False)),
        (Deduction("the general solution of (36)", general), apart(right=True)),
        "t/2 has a plus, the printed minus being a probable misprint, and B_k cos t is missing: "
        "B_k = 0 only from impacts on Y0",
        remark=(
            "In the extraction every plus survives and every minus is lost, and here a sign is "
            "lost, in both lines consistently: with a minus it solves x'' + x = -cos t. (38) has "
            "the right sign again. The printed page was not seen, so the misprint is probable, "
            "no more; that B_k cos t is missing does not depend on it."
        ),
        study=motion_text(run),
    )


def _on_the_eigenset(formula: Formula) -> Finding:
    motion, speed = formula.printed.rhs, sympy.diff(formula.printed.rhs, ELAPSED)
    position, velocity = _by_sign(motion), _by_sign(speed)
    checks: list[Comparison] = []
    for v0 in STARTS:
        run = _eigenset_run(v0)
        t = np.linspace(0.0, 30.0 * math.pi, 997)
        t = t[np.abs(t / math.pi - np.round(t / math.pi)) > 1e-6]
        count = np.floor(t / math.pi)
        odd = count % 2.0
        here = (t - math.pi * count, v0 + 0.5 * math.pi * odd, 1.0 - 2.0 * odd)
        x, v = run(t)
        worst = float(np.abs([x - position(*here), v - velocity(*here)]).max())
        what = f"difference of x and v, V0 = {v0:g}"
        checks.append(compare(what, worst, 0.0, 1e-11, error=DOUBLES))
    return Finding(
        (Deduction("the flight from k pi", on_eigenset_steps(motion)), *checks),
        study=motion_text(_eigenset_run(STARTS[1])),
    )


def _speed_on_the_eigenset(formula: Formula) -> Finding:
    derivative = sympy.diff(EQ38.printed.rhs, ELAPSED)
    here = {ELAPSED: ("1", "1"), V_K: ("1", "1"), COUNT_SIGN: ("1", "1")}

    def deduced(stated: sympy.Expr) -> Deduction:
        what = "x' is the derivative of x"
        return compared(
            what,
            on_eigenset_steps(),
            stated.subs(SIGN, COUNT_SIGN),
            derivative.subs(SIGN, COUNT_SIGN),
            here,
        )

    def measured(*, right: bool) -> Comparison:
        t = np.linspace(0.1, 3.0, 30)
        side = (formula.right if right and formula.right is not None else formula.printed).rhs
        values = _by_sign(side)(t, 1.0, 1.0)
        worst = float(np.abs(_eigenset_run(1.0)(t)[1] - values).max())
        what = "difference of x' on the first flight, V0 = 1"
        return compare(what, worst, 0.0, 1e-11, error=DOUBLES)

    right_line = (formula.printed if formula.right is None else formula.right).rhs
    return Finding(
        (deduced(formula.printed.rhs), measured(right=False)),
        (deduced(right_line), measured(right=True)),
        "the second term has a plus: the printed minus is a probable misprint",
        remark=(
            "The sign between the two terms is lost in the extraction, and every plus survives, so "
            "it was a minus. Nothing else rests on it: (39) takes x' at tau = pi, where the sine "
            "is zero."
        ),
        study=motion_text(_eigenset_run(1.0)),
    )


def _alternation(formula: Formula, twice: Formula) -> Finding:
    end = {ELAPSED: sympy.pi}
    after = -sympy.diff(EQ38.printed.rhs, ELAPSED).subs(end)
    stated = formula.printed.rhs
    again = stated.subs({V_K: stated, SIGN: -SIGN}, simultaneous=True)
    steps = (
        *on_eigenset_steps(),
        identity("The velocity after the impact at its end is -x'(pi),", after, stated),
        identity(
            "and one flight on, (-1)^(k+1) for (-1)^k,", sympy.expand(again), twice.printed.rhs
        ),
    )
    checks: list[Comparison] = []
    gained = _by_sign(stated - V_K)
    for v0 in STARTS:
        v = np.concatenate([[v0], _eigenset_run(v0).impacts.v_after])
        signs = 1.0 - 2.0 * (np.arange(len(v) - 1) % 2)
        worst = float(np.abs(np.diff(v) - gained(0.0, v[:-1], signs)).max())
        what = f"V_(k+1) less that of (39), V0 = {v0:g}"
        checks.append(compare(what, worst, 0.0, 1e-11, error=DOUBLES))
        back = float(np.abs(v[2:] - v[:-2]).max())
        what = f"V_(k+2) - V_k, V0 = {v0:g}"
        checks.append(compare(what, back, 0.0, 1e-11, error=DOUBLES))
    return Finding(
        (Deduction("velocities on Y0 alternate", steps), *checks),
        study=motion_text(_eigenset_run(STARTS[0])),
    )


def _extra_roots(formula: Formula) -> Finding:
    # For odd k the factor V_k - t/2 of (40) vanishes at 2 V_k, within a flight for V_k < pi/2.
    steps = no_other_root_steps(formula.printed.rhs)
    side = formula.side(ELAPSED, V_K)
    checks: list[Comparison] = []
    for v in (0.3, 1.0, 1.5):
        run = simulate(impact_oscillator(), cosine(1), t0=math.pi, v0=v, max_impacts=1)
        flight = float(run.impacts.intervals[0])
        what = f"x of (40) at the end of the first flight from (pi, {v:g})"
        checks.append(compare(what, float(side(flight, v)), 0.0, 1e-11, error=ONE_FLIGHT))
        what = f"its duration, against 2 V_k = {2 * v:g}"
        checks.append(compare(what, flight, 2.0 * v, 1e-11, error=ONE_FLIGHT))
    late = simulate(impact_oscillator(), cosine(1), t0=math.pi, v0=1.6, max_impacts=1)
    flight = float(late.impacts.intervals[0])
    what = "first flight from (pi, 1.6)"
    checks.append(compare(what, flight, math.pi, 1e-11, error=ONE_FLIGHT))
    return Finding(
        (Deduction("there are no other roots", steps), *checks),
        remark="The velocities start at odd k as (40) forbids, with V_k < pi/2, to show the root.",
        study=motion_text(late),
    )


def _steady(starts: tuple[float, ...] = (1e-3, 0.1, 1.0, 10.0)) -> Finding:
    steps = (
        *on_eigenset_steps(),
        *no_other_root_steps(),
        identity(
            "After two flights the velocity is V_k again, so the motion has the period 2 pi.",
            EQ39.printed.rhs.subs({V_K: EQ39.printed.rhs, SIGN: -SIGN}, simultaneous=True),
            V_K,
        ),
    )
    checks: list[Evidence] = [Deduction("impacts at k pi for ever, for every V0 > 0", steps)]
    for v0 in starts:
        run = _eigenset_run(v0)
        times = math.pi * np.arange(1, len(run.impacts) + 1, dtype=np.float64)
        checks.append(impacts_at(f"impact times less pi k, V0 = {v0:g}", run, times, 1e-9))
        what = f"impacts up to 30 pi + 1, V0 = {v0:g}"
        checks.append(counted(what, len(times), 30))
    disturbed = simulate(impact_oscillator(), cosine(1), v0=0.5, t0=-0.001, max_impacts=30_000)
    grown = float(disturbed.impacts.v_after.max())
    return Finding(
        tuple(checks),
        remark=(
            "These motions are unstable: the motion that starts with V0 = 0.5 at t = -0.001 in place "
            f"of t = 0 reaches the velocity {grown:.2f} in 30,000 impacts, and grows as the square "
            "root of time. The motion that starts at t = 0.001 first loses speed, and then grows."
        ),
        study=motion_text(_eigenset_run(starts[-1])),
    )


def _impact_at_half_pi(instant: sympy.Expr = sympy.pi / 2) -> Finding:
    """Examine whether there is an impact at an instant, in the motion from rest."""
    run = simulate(impact_oscillator(), cosine(1), v0=0, t_end=T_FIGURE)
    x, v = run([float(instant), 2.0 * math.pi])
    times = run.impacts.t
    odd = (2 * np.arange(len(times)) + 1) * math.pi
    speeds = run.impacts.v_after
    first = ELAPSED / 2 * sympy.sin(ELAPSED)
    none = compared(
        "x is zero at that instant",
        from_rest_steps(),
        sympy.Integer(0),
        first.subs(ELAPSED, instant),
        {},
    )
    touches = int(T_FIGURE / (2 * math.pi))
    return Finding(
        (none, compare("x at that instant, for V0 = 0", float(x[0]), 0.0, 1e-10, error=ONE_FLIGHT)),
        (
            Deduction("the motion from rest has the period 2 pi", from_rest_steps()),
            compare("x at t = 2 pi", float(x[1]), 0.0, DOUBLES, error=ONE_FLIGHT),
            compare("velocity at t = 2 pi", float(v[1]), 0.0, DOUBLES, error=ONE_FLIGHT),
            *(
                compare(what, _worst(differences), 0.0, ROUNDING, error=DOUBLES)
                for what, differences in (
                    ("impact times up to 900 less odd multiples of pi", times - odd),
                    ("impact velocities up to 900 less pi/2", speeds - 0.5 * math.pi),
                )
            ),
            counted("touches without speed up to 900", len(run.grazes), touches),
        ),
        "no impact at pi/2, where x = pi/4: the extra root of V_1 - t/2, V_1 = pi/2, is t = pi "
        "after the impact at pi, a double zero at 2 pi that touches the wall without speed; the "
        "motion x = (t/2) sin t, ((2 pi - t)/2) |sin t| has period 2 pi and impacts at odd "
        "multiples of pi",
        study=motion_text(run),
    )


def _worst(differences: Floats) -> float:
    return float(np.abs(differences).max())


def _becomes_sine(shift: sympy.Expr = sympy.pi / 2) -> Finding:
    """Examine whether a shift of the origin of time turns (36) into (27)."""
    x, v = simulate(impact_oscillator(), cosine(1), v0=0, t_end=2.0)(0.5 * math.pi)
    run = simulate_all(cosine(1), 0, T_FIGURE)["limit"]
    shifted = sympy.expand_trig(sympy.cos(TIME + shift))
    force = compared(
        "the shifted force is that of (27)",
        (),
        shifted,
        sympy.sin(TIME),
        {TIME: ("7/10", "7/10")},
    )
    at_origin = compared(
        "the mass is on the wall at the new origin",
        from_rest_steps(),
        sympy.Integer(0),
        (ELAPSED / 2 * sympy.sin(ELAPSED)).subs(ELAPSED, sympy.Abs(shift)),
        {},
    )
    return Finding(
        (force, at_origin),
        instead="at pi/2 the mass is off the wall, and the force turns into -sin t; the motion from "
        "rest has the period 2 pi",
        remark=(
            f"At pi/2 x = {float(x):.6f} and x' = {float(v):.6f}. The origin of time decides "
            "nothing. What decides is the phase of the force at the impacts, and under cos t from "
            "rest that is a phase without growth."
        ),
        study=motion_text(run),
    )


_statement = stated(THEORY, "closed form on the eigenset, and exact runs of the impact oscillator")


STATEMENTS = (
    _statement(
        "eq37",
        "(36), (37)",
        "The general solution on a flight of x'' + x = cos t is (A_k - t/2) sin t.",
        partial(_general_solution, EQ37, EQ37_VELOCITY),
        EQ37,
        "put into (36); an exact flight from elsewhere than Y0",
    ),
    _statement(
        "eq38",
        "(38)",
        "From impacts on Y0 the motion is (V_k + (-1)^k tau/2) sin tau, tau from the impact.",
        partial(_on_the_eigenset, EQ38),
        EQ38,
    ),
    _statement(
        "eq38-velocity",
        "(38)",
        "Its velocity is (V_k + (-1)^k tau/2) cos tau - ((-1)^k/2) sin tau.",
        partial(_speed_on_the_eigenset, EQ38_VELOCITY),
        EQ38_VELOCITY,
    ),
    _statement(
        "eq39",
        "(39)",
        "On Y0 impact velocities alternate: V_(k+1) = V_k + (-1)^k pi/2, V_(k+2) = V_k.",
        partial(_alternation, EQ39, EQ39_TWICE),
        EQ39,
    ),
    _statement(
        "eq40",
        "(40)",
        "The only extra roots are those of V_k - tau/2, for odd k and V_k <= pi/2.",
        partial(_extra_roots, EQ40),
        EQ40,
    ),
    _statement(
        "cosine-steady",
        "section 5",
        "For every V0 > 0 the motion under cos t is steady and periodic, with impacts on Y0.",
        _steady,
    ),
    _statement(
        "cosine-half-pi",
        "section 5",
        "For V0 = 0 there is an additional impact at t = pi/2.",
        _impact_at_half_pi,
    ),
    _statement(
        "cosine-becomes-sine",
        "section 5",
        "For V0 = 0 a shift of the origin by pi/2 turns (36) into (27), with its growth.",
        _becomes_sine,
    ),
    *GROWTH_STATEMENTS,
)
