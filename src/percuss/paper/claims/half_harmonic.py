"""Statements (28)-(34): the impact map under sin t, x'' + x = sin t, for large velocities."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np
import sympy

from percuss import numerics
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.half_harmonic import half_harmonic_impact
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.chain import CHAIN_STATEMENTS
from percuss.paper.claims.certain_gains import (
    mean_gain,
    rate_over_two_impacts,
    two_impacts,
    two_proven_impacts,
)
from percuss.paper.claims.comparisons import DOUBLES, ONE_FLIGHT, ROUNDING
from percuss.paper.claims.half_harmonic_figures import FIGURE_STATEMENTS
from percuss.paper.claims.half_harmonic_formulas import (
    COS,
    EPS,
    EQ28,
    EQ28_VELOCITY,
    EQ29,
    EQ30,
    EQ31,
    EQ31_FACTOR,
    EQ32,
    EQ33,
    EQ34,
    FACTOR,
    INTERVAL,
    MEAN,
    PHASE,
    SIN,
    T_K,
    TIME,
    V_K,
    compared,
    flight_equation_steps,
    growth_steps,
    interval_steps,
    next_velocity_steps,
    no_mean,
    right_side,
    two_impact_steps,
)
from percuss.paper.claims.half_harmonic_growth import (
    GROWTH_STATEMENTS,
    first_impacts,
)
from percuss.paper.evidence import Comparison, Deduction, Enclosure, Step, compare
from percuss.paper.formula import Formula, numerically
from percuss.paper.proof import identity, leading_terms
from percuss.paper.statement import Finding, Statement

THEORY = "half-harmonic.md"
# Phases and velocities of impacts: none is special, and the flights from them are short and long.
STATES = ((0.7, 1.0), (2.0, 3.0), (5.0, 10.0), (0.7, 100.0))
START = 0.7
# Far enough for the power of the error to show, near enough for rounding not to.
VELOCITIES = np.array([100.0, 200.0, 400.0, 800.0])
# So fast that the next order, 1/V, is below the digits that are compared.
FAST = 10**6
# Where expressions that differ are compared: a state like any other, and all times of flight.
STATE = {T_K: ("7/10", "7/10"), V_K: ("1", "1"), INTERVAL: ("1", "6"), FACTOR: ("1/10", "1/10")}


def _box(*expressions: sympy.Expr) -> dict[sympy.Symbol, tuple[str, str]]:
    names = set().union(*(expression.free_symbols for expression in expressions))
    return {name: STATE.get(name, ("7/10", "7/10")) for name in names}


def _derived(
    what: str, steps: tuple[Step, ...], formula: Formula, *, right: bool = False
) -> Deduction:
    """Return the deduction of a form of a formula, held against what the right one says."""
    derived = right_side(formula)
    stated = derived if right else formula.printed.rhs
    return compared(what, steps, stated, derived, _box(stated, derived))


def _is_of_order(what: str, errors: list[float], power: float) -> Comparison:
    """Compare the power of 1/V of an error; the next order bends it by some hundredths."""
    slope, error = numerics.fit_line(numerics.log(VELOCITIES), numerics.log(np.abs(errors)))
    return compare(f"exponent p of the error V^-p of {what}", -slope, power, 0.05, error=error)


def _flight(formula: Formula, velocity: Formula) -> Finding:
    a, b = sympy.symbols("A_k B_k", real=True)
    motion, speed = formula.printed.rhs, velocity.printed.rhs
    steps = (
        identity(
            "The form solves (27) for all A_k and B_k.",
            sympy.diff(motion, TIME, 2) + motion,
            sympy.sin(TIME),
        ),
        identity(
            "Its second line is the derivative of the first.", sympy.diff(motion, TIME), speed
        ),
        identity(
            "A_k and B_k meet any position and velocity at any instant: the determinant is not 0.",
            sympy.expand(motion).coeff(a) * sympy.expand(speed).coeff(b)
            - sympy.expand(motion).coeff(b) * sympy.expand(speed).coeff(a),
            sympy.Integer(-1),
        ),
    )
    return Finding(
        (Deduction("each flight has this form", steps), *_on_flights(formula, velocity)),
        study=motion_text(_six_flights()),
    )


@cache
def _six_flights() -> Trajectory:
    return simulate(impact_oscillator(), sine(1), v0=1.0, max_impacts=6)


def _on_flights(formula: Formula, velocity: Formula) -> tuple[Comparison, ...]:
    """Take A and B from one instant of a simulated flight, and compare at others."""
    symbols = (TIME, *sympy.symbols("A_k B_k", real=True))
    position, speed = formula.side(*symbols), velocity.side(*symbols)
    run = _six_flights()
    checks = []
    for k in (0, 2, 4):
        begin, length = run.impacts.t[k], run.impacts.intervals[k + 1]
        t = begin + np.array([0.05, 0.3, 0.6, 0.9]) * length
        x, v = run(t)
        rest = np.array([x[0] - position(t[0], 0.0, 0.0), v[0] - speed(t[0], 0.0, 0.0)])
        columns = [
            [form(t[0], *unit) - form(t[0], 0.0, 0.0) for unit in ((1.0, 0.0), (0.0, 1.0))]
            for form in (position, speed)
        ]
        a, b = numerics.solve_linear(np.array(columns), rest)
        apart = np.abs([x - position(t, a, b), v - speed(t, a, b)]).max()
        what = f"largest difference on flight {k + 1}"
        checks.append(compare(what, float(apart), 0.0, DOUBLES, error=ONE_FLIGHT))
    return tuple(checks)


def _third_term_lost(
    formula: Formula,
    side: tuple[str, Callable[[float], float]],
    derived: str,
    remark: str,
    state: tuple[float, float],
) -> Finding:
    """Compare a formula for an interval xi, whose left side has a name, with exact flights."""
    name, measured = side

    def checks(*, right: bool) -> list[Comparison]:
        stated, comparisons = formula.side(T_K, V_K, INTERVAL, right=right), []
        for t, v in STATES:
            interval = half_harmonic_impact(t, v)[0] - t
            what = f"{name} for t_k = {t:g}, V_k = {v:g}"
            found, expected = measured(interval), stated(t, v, interval)
            comparisons.append(compare(what, found, expected, ROUNDING, error=ONE_FLIGHT))
        return comparisons

    steps = flight_equation_steps()
    return Finding(
        (_derived(derived, steps, formula), *checks(right=False)),
        (_derived(derived, steps, formula, right=True), *checks(right=True)),
        "the denominator has a third term, xi_k sin t_k",
        remark=remark,
        study=motion_text(two_impacts(*state)),
    )


def _flight_equation(formula: Formula) -> Finding:
    return _third_term_lost(
        formula,
        ("tan xi", numerics.tan),
        "the equation of the time of flight",
        "The two agree only where sin t_k = 0 or cos t_k = 0.",
        STATES[0],
    )


def _factor(formula: Formula) -> Finding:
    return _third_term_lost(
        formula,
        ("tan(xi)/xi", lambda xi: numerics.tan(xi) / xi),
        "the factor of xi_k in tan xi_k = a_k xi_k",
        "Both forms are cos t_k / (2 V_k) + O(V_k^-2), so a_k is small as stated.",
        STATES[1],
    )


def _interval(formula: Formula, factor: Formula) -> Finding:
    a = EQ30.printed.rhs.subs(V_K, 1 / EPS)
    first = factor.printed.rhs.subs(V_K, 1 / EPS)
    printed = formula.printed.rhs.subs(FACTOR, first)
    expansion = Deduction(
        "xi_k and a_k to the first order in 1/V_k",
        (
            *interval_steps(),
            leading_terms("a_k of (30) has this first term,", a, EPS, 2, first),
            identity(
                "and pi (1 + a_k) is the interval to the first order.",
                printed,
                sympy.pi + sympy.pi / 2 * COS * EPS,
            ),
        ),
    )
    side = formula.side(FACTOR)
    values = numerically(EQ30.printed.rhs, T_K, V_K)(START, VELOCITIES)
    intervals = np.array([half_harmonic_impact(START, v)[0] for v in VELOCITIES]) - START
    coefficient = values - factor.side(T_K, V_K)(START, VELOCITIES)
    return Finding(
        (
            expansion,
            _is_of_order("xi_k = pi (1 + a_k)", list(intervals - side(values)), 2.0),
            _is_of_order("a_k = cos t_k/(2 V_k)", list(coefficient), 2.0),
        ),
        remark=(
            "That (29) lacks a term does not reach the first order. What the article concludes "
            "from (31), that the impact times approach the eigenset, is examined for itself, in "
            "the record of section 5 on the sub-harmonic resonance."
        ),
        study=motion_text(first_impacts()),
    )


def _next_velocity(formula: Formula) -> Finding:
    a = sympy.expand(COS / 2 * EPS)
    gained = right_side(formula) - V_K
    exact = np.array([half_harmonic_impact(START, v)[1] for v in VELOCITIES])
    factor = numerically(EQ30.printed.rhs, T_K, V_K)(START, VELOCITIES)

    def order(what: str, *, right: bool) -> Comparison:
        side = formula.side(T_K, V_K, FACTOR, right=right)
        return _is_of_order(what, list(exact - side(START, VELOCITIES, factor)), 2.0)

    gain = sympy.pi / 2 * SIN + sympy.pi / 2 * (SIN + sympy.pi / 4 * COS) * COS * EPS
    steps = (
        *next_velocity_steps(),
        identity(
            "With a_k = cos t_k/(2 V_k) the gain is this.",
            gain,
            sympy.expand(gained.subs(FACTOR, a)),
        ),
    )
    what = "the next velocity to the first order in a_k"
    return Finding(
        (_derived(what, steps, formula), order("(32)", right=False)),
        (_derived(what, steps, formula, right=True), order("the corrected form", right=True)),
        "(pi/2) cos t_k where pi is printed",
        study=motion_text(two_impacts(START, float(VELOCITIES[0]))),
    )


def _two_impacts(t: float, v: float) -> float:
    return half_harmonic_impact(*half_harmonic_impact(t, v))[1]


def _second_velocity(formula: Formula) -> Finding:
    v = 1e5

    def checks(*, right: bool) -> list[Comparison]:
        side, comparisons = formula.side(T_K, V_K, right=right), []
        for t in (0.0, 0.7, 2.0, 4.5):
            measured = v * (_two_impacts(t, v) - v)
            what = f"V_k (V_(k+2) - V_k) for t_k = {t:g}, V_k = 1e5"
            stated = v * (float(side(t, v)) - v)
            # The difference of two velocities is rounded, and multiplied by V.
            comparisons.append(
                compare(what, measured, stated, 1e-4, error=v * float(np.spacing(v)))
            )
        return comparisons

    gained = right_side(formula) - V_K
    steps = (
        *two_impact_steps(),
        identity(
            "The gain over two impacts is this.",
            sympy.pi / 2 * sympy.sin(2 * T_K) / V_K,
            gained,
        ),
    )
    what = "the velocity two impacts on"
    return Finding(
        (_derived(what, steps, formula), *checks(right=False)),
        (_derived(what, steps, formula, right=True), *checks(right=True)),
        "there is no term in cos^2 t_k: the phase of the impact between shifts, and cancels it",
        remark=(
            "The right (32), applied twice with t_(k+1) = t_k + pi, gives the printed (33): the "
            "shift pi a_k of the phase is left out, though it is of the order that is kept."
        ),
        study=motion_text(two_impacts(START, v)),
    )


def _mean_growth(formula: Formula) -> Finding:
    speed = next(iter(formula.printed.lhs.atoms(sympy.Derivative))).expr
    mean = sympy.sin(2 * T_K) / 4
    bracket = sympy.sin(2 * T_K)
    readings = {"the bracket": bracket, "the numerator with its pi/2": sympy.pi / 2 * bracket}
    stated = (speed * formula.printed.rhs).subs(PHASE, T_K)
    rate, radius = rate_over_two_impacts("7/10", FAST)
    printed: list[Deduction | Comparison] = []
    for name, a in readings.items() if MEAN in stated.free_symbols else [("printed", MEAN)]:
        value = stated.subs(MEAN, a)
        what = f"the constant, a being {name}" if MEAN in stated.free_symbols else "the constant"
        printed.append(compared(what, growth_steps(), value, mean, _box(value)))
        expected = float(numerically(value, T_K)(START))
        said = f"V dV/dt at t_k = 0.7, V = 1e6, against {what}"
        printed.append(compare(said, rate, expected, 1e-6, radius))
    if MEAN in stated.free_symbols:
        printed.append(no_mean("a > 0 as an average over the phase"))
    exact = float(numerically(mean, T_K)(START))
    what = "V dV/dt = sin(2 psi)/4 over two impacts, to the leading order"
    right = (speed * right_side(formula)).subs(PHASE, T_K)
    means = _means()
    return Finding(
        tuple(printed),
        (
            compared(what, growth_steps(), right, mean, _box(right)),
            compare("V dV/dt at t_k = 0.7, V = 1e6: sin(1.4)/4", rate, exact, 1e-6, radius),
            *means,
        ),
        "the phase psi of the impacts stands still and is not averaged over: velocities grow for "
        "0 < psi < pi/2 and fall for pi/2 < psi < pi",
        remark=(
            "The constant a/(pi V) follows from (33) on no reading: division by 2 pi gives a/(4V) "
            "if a averages the bracket, a/(2 pi V) if it averages the numerator. With the right "
            "numerator it would be 0.3137 or 0.4927 at t_k = 0.7."
        ),
        study=motion_text(two_impacts(START, FAST)),
    )


def _means() -> tuple[Comparison, ...]:
    """Return means of the gain over 24 phases, of all and of each half, in ball arithmetic."""
    v = 1e4
    phases = (np.arange(24) + 0.5) * math.pi / 24
    gains = [two_proven_impacts(float(t), v) for t in phases]
    # Of so many values between, the mean of the sine over a half lies 1 + 1e-3.
    wanted = (
        ("mean over the phase of V_k (V_(k+2) - V_k)", slice(None), 0.0, 1e-3),
        ("mean over 0 < t_k mod pi < pi/2", slice(None, 12), 1.0, 5e-3),
        ("mean over pi/2 < t_k mod pi < pi", slice(12, None), -1.0, 5e-3),
    )
    return tuple(
        Enclosure(what, *mean_gain(v, gains[part]), mean - width, mean + width, mean)
        for what, part, mean, width in wanted
    )


def _statement(
    number: int,
    claim: str,
    find: Callable[[], Finding],
    formula: Formula,
    method: str = "expansion of the exact impact map, and exact impacts at large velocities",
) -> Statement:
    return Statement(
        id=f"eq{number}",
        reference=f"({number})",
        claim=claim,
        formula=formula,
        method=method,
        find=find,
        theory=THEORY,
    )


STATEMENTS = (
    _statement(
        28,
        "Each flight is A_k sin t + B_k cos t - (t/2) cos t.",
        partial(_flight, EQ28, EQ28_VELOCITY),
        EQ28,
        "put into (27); A_k and B_k from one instant of a simulated flight, compared at others",
    ),
    _statement(
        29,
        "The time of flight xi_k solves tan xi_k = xi_k cos t_k / (cos t_k + 2 V_k).",
        partial(_flight_equation, EQ29),
        EQ29,
        "derived from (28); the exact time of flight put into it",
    ),
    _statement(
        30,
        "The factor of xi_k in (29) is a_k = cos t_k / (cos t_k + 2 V_k).",
        partial(_factor, EQ30),
        EQ30,
        "derived from (28); tan(xi)/xi of the exact time of flight",
    ),
    _statement(
        31,
        "For large velocities xi_k = pi (1 + a_k) + O(a_k^2) and a_k = cos t_k/(2 V_k) + "
        "O(V_k^-2), so that the intervals between impacts are close to pi.",
        partial(_interval, EQ31, EQ31_FACTOR),
        EQ31,
        "expansion of the time of flight; exact times of flight at large velocities",
    ),
    _statement(
        32,
        "The next impact velocity is V_k + (pi/2) [sin t_k + (pi + 2 sin t_k) a_k] + O(a_k^2).",
        partial(_next_velocity, EQ32),
        EQ32,
    ),
    _statement(
        33,
        "Two impacts on, V_k has grown by (pi/2) [(pi/2) cos^2 t_k + sin 2 t_k] / V_k.",
        partial(_second_velocity, EQ33),
        EQ33,
    ),
    _statement(
        34,
        "The numerator of (33) may be replaced by its average a > 0, and this gives "
        "dV/dt = a/(pi V).",
        partial(_mean_growth, EQ34),
        EQ34,
        "expansion of the exact impact map; its coefficient at V = 1e6 in ball arithmetic",
    ),
    *CHAIN_STATEMENTS,
    *GROWTH_STATEMENTS,
    *FIGURE_STATEMENTS,
)
