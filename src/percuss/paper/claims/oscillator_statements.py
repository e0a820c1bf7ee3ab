"""Section 1 of the paper held against evidence: equations (1) to (5), the oscillators."""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np
import sympy
from flint import arb

from percuss.certified import Ball, CertifiedRun
from percuss.certified.ball_law import law_of
from percuss.certified.flight import EnclosedFlight
from percuss.certified.numbers import constant_of, precision
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import cosine, sine
from percuss.model.oscillator import Oscillator, bilinear_oscillator, impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.certain_motion import furthest_apart
from percuss.paper.claims.comparisons import ROUNDING, WALL, apart
from percuss.paper.evidence import Comparison, Deduction, Step, compare
from percuss.paper.formula import Formula, ordered, product
from percuss.paper.proof import identity, theorem
from percuss.paper.statement import Finding, Statement

THEORY = "paper-oscillator.md"

# Displacement, its derivatives, and the force at one instant.
X, X1, X2, FORCE, JERK = sympy.symbols("x x' x'' f(t) f'(t)", real=True)
DAMPING, STIFFNESS, V = sympy.symbols("a k(x) V", positive=True)
ABOVE, BELOW = sympy.symbols("omega_+ omega_-", positive=True)
RATE_ABOVE, RATE_BELOW, RATE, OWN = sympy.symbols(
    "Omega_+ Omega_- Omega_\\pm omega_\\pm", positive=True
)
BEFORE, AFTER = sympy.symbols("x'(t_{k}-0) x'(t_{k}+0)", real=True)


EQ1 = Formula(
    "1",
    "( 2 o þ , x Z0 ~ ~ x00 þ 2ax0 þ kðxÞx (1) , o þ o o ¼ f ðtÞ, kðxÞ ¼ o2 , x o0",
    sympy.Eq(ordered(X2, product(2, DAMPING, X1), product(STIFFNESS, X)), FORCE),
)
EQ2 = Formula(
    "2",
    "Or ¼ 2O þ O , O27 ¼ o27 a2 O þ þ O (2)",
    sympy.Eq(sympy.Symbol("Omega_r"), 2 * RATE_ABOVE * RATE_BELOW / (RATE_ABOVE + RATE_BELOW)),
    lost="the minus of the index in the second frequency",
)
RATES = Formula(
    "2",
    "O27 ¼ o27 a2",
    sympy.Eq(RATE**2, ordered(OWN**2, -(DAMPING**2))),
    lost="the minus between the squares",
)
EQ4 = Formula(
    "4",
    "x0 ðt k þ0Þ ¼ x0 ðt k 0Þ ¼ V k (4)",
    sympy.Eq(AFTER, -BEFORE),
    lost="the minus of the second side, and that of its argument",
)
EQ5 = Formula("5", "x00 þx ¼ f ðtÞ, x 4 0, (5)", sympy.Eq(ordered(X2, X), FORCE))


def _acceleration(formula: Formula) -> sympy.Expr:
    """Return x'' from an equation of motion."""
    (acceleration,) = sympy.solve(formula.printed, X2)
    return acceleration


def _smoothness(formula: Formula = EQ1) -> Finding:
    """Follow x'' and x''' through a change of the stiffness, as the equation gives them."""
    second = _acceleration(formula)
    third = second.diff(FORCE) * JERK + second.diff(X) * X1 + second.diff(X1) * second

    def jump(expression: sympy.Expr, at: sympy.Expr) -> sympy.Expr:
        """Below minus above."""
        return (expression.subs(STIFFNESS, BELOW**2) - expression.subs(STIFFNESS, ABOVE**2)).subs(
            X, at
        )

    place = sympy.Symbol("x_c", real=True)
    step = ABOVE**2 - BELOW**2
    proof = Deduction(
        "x'' is continuous where x = 0, and x''' is not",
        (
            identity("x'' from below less x'' from above, at x = 0", jump(second, 0), 0 * X),
            identity(
                "x''' from below less x''' from above, at x = 0: not zero where x' is not",
                jump(third, 0),
                step * X1,
            ),
            identity(
                "if the stiffness changed at another place x_c, x'' itself would jump",
                jump(second, place),
                step * place,
            ),
        ),
    )
    second_jump, third_jump = _jumps_in_balls()
    return Finding(
        (
            proof,
            enclosed("jump of x'' at a crossing", second_jump, -1e-9, 1e-9),
            enclosed("jump of x''' over (w+^2 - w-^2) x' there", third_jump, 1 - 1e-6, 1 + 1e-6),
        ),
        remark="Where the motion touches x = 0 with x' = 0 the third derivative does not jump.",
        study=motion_text(_crossing_run()),
    )


@cache
def _crossing_run() -> Trajectory:
    osc = bilinear_oscillator(stiffness_above=1, stiffness_below=5, damping="0.1")
    return simulate(osc, cosine("1.3"), v0=1.0, t_end=10.0)


def _jumps_in_balls() -> tuple[arb | None, arb | None]:
    """Return the jump of x'' at a crossing, and that of x''' over (w+^2 - w-^2) x'."""
    proven = certain_run(_crossing_run())
    if proven is None:
        return None, None

    t, v = proven.crossings.t.arbs[0], proven.crossings.v.arbs[0]
    with precision(proven.precision):
        law = law_of(proven.system)
        # The closed forms of the regions above and below, at the instant that they share.
        above, below = (
            EnclosedFlight(law, region, law.phasors(t), law.places[0], v).derivatives(arb(0), 3)[0]
            for region in (1, 0)
        )
        jumps = [constant_of(b) - constant_of(a) for a, b in zip(above, below, strict=True)]
        return jumps[2], jumps[3] / ((1 - 5) * v)


def resonant_frequency(
    above: sympy.Expr, below: sympy.Expr, damping: sympy.Expr, eq2: Formula = EQ2
) -> sympy.Expr:
    """Return W_r of (2) for given frequencies w+, w- and damping a.

    Examples
    --------
    >>> resonant_frequency(sympy.Integer(1), sympy.Rational(5, 3), sympy.Integer(0))
    5/4
    """
    rates = [
        sympy.sqrt(RATES.printed.rhs.subs({OWN: own, DAMPING: damping})) for own in (above, below)
    ]
    return eq2.printed.rhs.subs(dict(zip((RATE_ABOVE, RATE_BELOW), rates, strict=True)))


def _resonant_frequency(eq2: Formula = EQ2, rates: Formula = RATES) -> Finding:
    """Prove (2) by the free motion on either side, and see it in five motions."""
    t = sympy.Symbol("t", real=True)
    free = V / RATE * sympy.exp(-DAMPING * t) * sympy.sin(RATE * t)
    (own_squared,) = sympy.solve(rates.printed, OWN**2)
    cycle = sympy.pi / RATE_ABOVE + sympy.pi / RATE_BELOW
    proof = Deduction(
        "W_r from the times spent on either side",
        (
            identity(
                "the free motion x = (V/W) exp(-a t) sin W t on one side obeys (1)",
                free.diff(t, 2) + 2 * DAMPING * free.diff(t) + own_squared * free,
                sympy.Integer(0),
            ),
            identity("it leaves x = 0 with the velocity V", free.diff(t).subs(t, 0), V),
            identity(
                "and is back at t = pi/W, the first zero of the sine, whatever V",
                free.subs(t, sympy.pi / RATE),
                sympy.Integer(0),
            ),
            identity(
                "2 pi over the sum of the two times is (2)",
                2 * sympy.pi / cycle,
                eq2.printed.rhs,
            ),
        ),
    )
    cases = [(1.0, 5.0, 0.1), (2.0, 0.3, 0.2), (1.0, 400.0, 0.05), (1.0, 1e8, 0.0)]
    soft = [_frequency(_bilinear(*case), *case, eq2, rates) for case in cases]
    wall = _frequency(impact_oscillator(damping="0.3"), 1.0, math.inf, 0.3, eq2, rates)
    remark = (
        "W_r is the frequency of the free motion. With damping the steady response is largest a "
        "little below it: for w- = w+ at sqrt(w^2 - 2 a^2)."
    )
    return Finding(
        (proof, *soft, wall),
        remark=remark,
        study=motion_text(_free_run(_bilinear(*cases[0]), _cycle(*cases[0], eq2, rates))),
    )


def _bilinear(above: float, below: float, damping: float) -> Oscillator:
    return bilinear_oscillator(stiffness_above=above, stiffness_below=below, damping=damping)


def _cycle(above: float, below: float, damping: float, eq2: Formula, rates: Formula) -> float:
    """Return the duration of a free cycle by the formula."""
    squared = rates.side(OWN, DAMPING)
    slow, fast = (math.sqrt(squared(math.sqrt(k), damping)) for k in (above, below))
    if math.isfinite(below):
        return 2.0 * math.pi / float(eq2.side(RATE_ABOVE, RATE_BELOW)(slow, fast))
    rigid = sympy.limit(eq2.printed.rhs, RATE_BELOW, sympy.oo)
    return 2.0 * math.pi / float(rigid.subs(RATE_ABOVE, slow))


def _free_run(osc: Oscillator, cycle: float) -> Trajectory:
    return simulate(osc, v0=1.0, t_end=7.5 * cycle)


def _frequency(
    osc: Oscillator, above: float, below: float, damping: float, eq2: Formula, rates: Formula
) -> Comparison:
    """Compare the time between entries of the free motion with the formula."""
    expected = _cycle(above, below, damping, eq2, rates)
    run = _free_run(osc, expected)
    what = f"2 pi/W_r, w+^2 = {above:g}, w-^2 = {below:g}, a = {damping:g}: worst of 5 cycles"
    proven = certain_run(run)
    if proven is None:
        return compare(what, math.nan, expected, ROUNDING, math.inf)

    walls = len(proven.impacts) > 0
    balls = proven.impacts.t if walls else proven.crossings.t
    middle = balls.mid()[slice(None) if walls else proven.crossings.direction == "in"]
    # The radii, and the rounding of what is expected and of the difference.
    radius = 2.0 * float(balls.radius().max()) + 8.0 * float(np.spacing(middle[5]))
    cycles = np.diff(middle[:6])
    worst = float(cycles[np.abs(cycles - expected).argmax()])
    return compare(what, worst, expected, ROUNDING, radius)


def _contact_steps(impact: Formula) -> tuple[Step, ...]:
    """Return the steps to what a contact with x < 0 becomes as w- tends to infinity."""
    small, speed = sympy.symbols("epsilon V", positive=True)
    t, push = sympy.symbols("t F", real=True)
    x = push * small**2 * (1 - sympy.cos(t / small)) - speed * small * sympy.sin(t / small)
    velocity = sympy.diff(x, t)
    # Twice the energy over the mass.
    energy = velocity**2 + x**2 / small**2 - 2 * push * x
    return (
        identity(
            "With epsilon = 1/w- and a constant force F a contact from x = 0, entered with V, is "
            "this, without damping:",
            sympy.diff(x, t, 2) + x / small**2,
            push,
        ),
        identity("It is entered at x = 0 with -V,", (x + velocity).subs(t, 0), -speed),
        identity(
            "and keeps its energy, so that it leaves x = 0 with the speed that (4) gives, V.",
            sympy.simplify(energy),
            impact.printed.rhs.subs(BEFORE, -speed) ** 2,
        ),
        identity("(4) turns -V into V:", impact.printed.rhs.subs(BEFORE, -speed), speed),
        identity(
            "It lasts no longer than a turn, 2 pi epsilon, and is no deeper than "
            "V epsilon + 2 |F| epsilon^2; both tend to 0.",
            sympy.limit(
                2 * sympy.pi * small + speed * small + 2 * sympy.Abs(push) * small**2, small, 0
            ),
            sympy.Integer(0),
        ),
        theorem(
            "In so short a time a continuous force changes, and damping acts, by as little: their "
            "share tends to 0 with epsilon, and so does the difference of the flights that follow "
            "(continuous dependence: Coddington & Levinson 1955, chapter 1), as long as each "
            "contact is entered with V > 0."
        ),
    )


def _limit(impact: Formula = EQ4) -> Finding:
    """Follow stiff bilinear oscillators and the impact oscillator side by side."""
    t = np.linspace(0.0, 20.0, 2001)
    hard = simulate(WALL, sine("2.5"), v0=1.0, t_end=20.0)
    runs = [
        simulate(bilinear_oscillator(stiffness_below=below), sine("2.5"), v0=1.0, t_end=20.0)
        for below in (10**10, 10**12)
    ]
    errors = [furthest_apart([(1.0, run, None), (-1.0, hard, None)], t) for run in runs]
    soft, stiff = errors
    ratio = None if soft is None or stiff is None else stiff / soft
    return Finding(
        (
            Deduction("a contact becomes an impact", _contact_steps(impact)),
            enclosed("x at w-^2 = 1e12 less the limit, largest to t = 20", stiff, 0.0, 1e-4),
            enclosed("that error over the one at w-^2 = 1e10", ratio, 0.099, 0.101),
            _reversed(runs[1], impact),
        ),
        remark=(
            "(3) and (4) define the model. The error falls as 1/w- where the motion meets x = 0 "
            "with a velocity, and as the root of that once it has grazed."
        ),
        study=motion_text(runs[1]),
    )


def _reversed(run: Trajectory, impact: Formula) -> Comparison:
    """Compare the speeds at which a stiff stop is entered and left."""
    what = "velocity on leaving x < 0, less that of (4), w-^2 = 1e12"
    proven = certain_run(run)
    if proven is None:
        return enclosed(what, None, 0.0, 1e-9)
    v, direction = proven.crossings.v, proven.crossings.direction
    entries, exits = (v.mid()[direction == way] for way in ("in", "out"))
    n = min(len(entries), len(exits))
    gap = apart(exits[:n], impact.side(BEFORE)(entries[:n]))
    return compare(what, gap, 0.0, 1e-9, 2.0 * float(v.radius().max()) + 1e-15)


def _scaling(formula: Formula = EQ5, eq2: Formula = EQ2, harmonic: str = "2") -> Finding:
    """Scale time by w+ and the force by w+^2, in the equation and in a motion."""
    wall = sympy.limit(eq2.printed.rhs, RATE_BELOW, sympy.oo)
    proof = Deduction(
        "(3) in the new variables, and its resonant frequency",
        (
            identity(
                "if x(t) obeys (5) under f(t), x(w+ t) has w+^2 x'' for its second derivative, and "
                "obeys (3) with a = 0 under w+^2 f(w+ t)",
                ABOVE**2 * _acceleration(formula) + ABOVE**2 * X,
                ABOVE**2 * FORCE,
            ),
            identity(
                "(2) for w- to infinity, at w+ = 1: W_r, and n W_r = 2n",
                wall.subs(RATE_ABOVE, 1),
                sympy.Rational(harmonic),
            ),
        ),
    )
    own = simulate(impact_oscillator(stiffness=4), cosine("3.4", amplitude=4), v0="1.2", t_end=20)
    scaled_run = simulate(WALL, cosine("1.7"), v0="0.6", t_end=40)
    one, other = certain_run(own), certain_run(scaled_run)
    free = certain_run(simulate(WALL, v0=1, t_end=30))
    return Finding(
        (proof, *_scaled_alike(one, other), _free_frequency(free, float(harmonic))),
        study=motion_text(scaled_run),
    )


def _free_frequency(free: CertifiedRun | None, expected: float) -> Comparison:
    """Compare 2 pi over the time between two free impacts with W_r."""
    what = "2 pi over the time between free impacts"
    if free is None:
        return compare(what, math.nan, expected, ROUNDING, math.inf)
    first, second = free.impacts.t.arbs[:2]
    value = Ball(2 * arb.pi() / (second - first))
    return compare(what, value.mid(), expected, ROUNDING, value.radius())


def _scaled_alike(own: CertifiedRun | None, scaled: CertifiedRun | None) -> tuple[Comparison, ...]:
    """Compare times and velocities of the impacts in both units."""
    names = "w+ t_k minus the scaled t_k", "x'/w+ minus the scaled x' after impacts"
    if own is None or scaled is None:
        return tuple(enclosed(name, None, 0.0, ROUNDING) for name in names)
    one, other = own.impacts, scaled.impacts
    columns = ((2.0, one.t, other.t), (0.5, one.v_after, other.v_after))
    checks = []
    for name, (factor, first, second) in zip(names, columns, strict=True):
        gap = apart(factor * first.mid(), second.mid())
        radius = float((factor * first.radius() + second.radius()).max())
        checks.append(compare(name, gap, 0.0, ROUNDING, radius + 1e-15))
    return tuple(checks)


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="eq1",
        reference="(1)",
        claim="Under a continuously differentiable force the solution is twice continuously "
        "differentiable; its third derivative is discontinuous at x = 0.",
        formula=EQ1,
        method="jumps of the derivatives from the equation; a crossing in ball arithmetic",
        find=_smoothness,
    ),
    _of(
        id="eq2",
        reference="(2)",
        claim="The sum of the times spent on either side gives the resonant frequency, with "
        "damping too.",
        formula=rf"{EQ2.tex()},\ {RATES.tex()}",
        method="the free motion on either side; times between entries of five free motions",
        find=_resonant_frequency,
    ),
    _of(
        id="eq3-4",
        reference="(3), (4)",
        claim="With w- to infinity (1) turns into (3) with the impacts (4).",
        formula=EQ4,
        method="the contact for large w-; motions for w-^2 = 1e10 and 1e12 beside that of the limit",
        find=_limit,
    ),
    _of(
        id="eq5",
        reference="(5)",
        claim="With time scaled by w+ and the force by w+^2 the equation is (5); its resonant "
        "frequency is 2, and the multi-harmonics are the even numbers.",
        formula=EQ5,
        method="change of variables; a motion in both units",
        find=_scaling,
    ),
)
