"""Section 2 of the paper held against evidence: equations (6) to (9), Property 1."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import sympy
from flint import arb

from percuss.io.study_text import motion_text
from percuss.model.forcing import Forcing, Harmonic
from percuss.model.harmonic_forces import cosine, sine
from percuss.motion.eigenset import eigenset
from percuss.motion.eigenset_forms import SubsetMotion
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims import multi_harmonics, oscillator_statements, solution_statements
from percuss.paper.claims.certain import certain_run, enclosed, impacts_at, subset_constant
from percuss.paper.claims.certain_motion import MotionPart, sum_within
from percuss.paper.claims.comparisons import ROUNDING, WALL, apart
from percuss.paper.claims.oscillator_statements import FORCE, X
from percuss.paper.evidence import Comparison, Deduction, Measurement
from percuss.paper.formula import Formula, ordered, product
from percuss.paper.proof import enclose, identity
from percuss.paper.statement import Finding, Statement

THEORY = "paper-family.md"
T, T_K, D = sympy.symbols("t t_k D", real=True)
V0, V, ALPHA, BETA, EPSILON = sympy.symbols("V_0 V alpha beta epsilon", positive=True)
# As it is printed, and as the proofs take it.
INDEX, K = sympy.Symbol("k", real=True), sympy.Symbol("k", integer=True, nonnegative=True)
OTHER, Z, Z2, OTHER_FORCE = sympy.symbols("y z z'' g(t)", real=True)
A_Y, PART, PART_START, PART_SLOPE = sympy.symbols(
    "A_y x_{part}(t) x_{part}(0) x_{part}'(0)", real=True
)

EQ6 = Formula(
    "6",
    "z00 þ z ¼ af ðtÞ þ bgðtÞ, z 40 (6)",
    sympy.Eq(ordered(Z2, Z), ordered(product(ALPHA, FORCE), product(BETA, OTHER_FORCE))),
)
EQ9 = Formula(
    "9",
    "x0 ðtÞ ¼ V 0 sinðtpkÞ for pk r t r pðkþ 1Þ (9)",
    sympy.Eq(
        sympy.Symbol("x_0"),
        V0 * sympy.sin(ordered(T, product(-1, sympy.pi, INDEX)), evaluate=False),
    ),
    lost="the minus of t - pi k",
)
FLIGHT = sympy.Eq(OTHER, ordered(A_Y * sympy.sin(T), -PART_START * sympy.cos(T), PART))
EQ15 = Formula(
    "15",
    "yðtÞ ¼ Ay sin txpart ð0Þ þ xpart ðtÞ",
    sympy.Eq(OTHER, ordered(A_Y * sympy.sin(T), -PART_START, PART)),
    right=FLIGHT,
    lost="the minus after sin t",
)
EQ16 = Formula(
    "16",
    "9yðtÞzðtÞ9 o e and 9y0 ðtÞz0 ðtÞ9 o e (16)",
    sympy.StrictLessThan(sympy.Abs(sympy.Symbol("y") - sympy.Symbol("z")), EPSILON),
    lost="the minus between the two",
)
# The difference of two motions on a flight from t_k, as the proof of Property 1 should have it;
# the article writes sin t.
DIFFERENCE = D * sympy.sin(T - T_K)
NUMBERS = np.linspace(0.0, 60.0, 301)


def _combination(formula: Formula = EQ6, alpha: str = "2", beta: str = "1/2") -> Finding:
    """Combine motions with the same impact times, on Y_2 and on the eigenset."""
    # Each obeys (5), its impacts turn its velocity.
    second = ALPHA * (FORCE - X) + BETA * (OTHER_FORCE - OTHER)
    before, other = sympy.symbols("x'(t_{k}-0) y'(t_{k}-0)", real=True)
    proof = Deduction(
        "z = alpha x + beta y obeys (6) and (4), and is positive as both are",
        (
            identity(
                "between impacts z'' + z is the force of (6)",
                second + ALPHA * X + BETA * OTHER,
                formula.printed.rhs,
            ),
            identity(
                "at the common impacts the velocity of z is turned, as both are",
                ALPHA * -before + BETA * -other,
                -(ALPHA * before + BETA * other),
            ),
        ),
    )
    a, b = (float(sympy.Rational(text)) for text in (alpha, beta))
    slow, fast = SubsetMotion(2, "0.3"), SubsetMotion(2, "0.9")
    both = _combined(formula, slow.forcing, fast.forcing, a, b)
    on_subset: list[MotionPart] = [
        (a, simulate(WALL, slow.forcing, v0="0.3", t_end=60), None),
        (b, simulate(WALL, fast.forcing, v0="0.9", t_end=60), None),
        (-1.0, simulate(WALL, both, v0=a * 0.3 + b * 0.9, t_end=60), None),
    ]
    both = _combined(formula, sine(2), sine(4), a, b)
    on_eigenset: list[MotionPart] = [
        (a, simulate(WALL, sine(2), v0=0.4, t_end=60), None),
        (b, simulate(WALL, sine(4), v0=0.4, t_end=60), None),
        (-1.0, simulate(WALL, both, v0=(a + b) * 0.4, t_end=60), None),
    ]
    what = "2x + y/2 minus the motion under the combined force, on"
    return Finding(
        (
            proof,
            sum_within(f"{what} Y_2", on_subset, NUMBERS, ROUNDING),
            sum_within(f"{what} the eigenset", on_eigenset, NUMBERS, ROUNDING),
        ),
        study=motion_text(on_eigenset[-1][1]),
    )


def _combined(formula: Formula, f: Forcing, g: Forcing, alpha: float, beta: float) -> Forcing:
    """Return the force that the formula gives for two forces of harmonics."""
    total = sympy.expand(formula.printed.rhs.subs({ALPHA: alpha, BETA: beta}))
    parts, constant = [], 0.0
    for name, force in ((FORCE, f), (OTHER_FORCE, g)):
        factor = float(total.coeff(name))
        constant += factor * float(force.constant)
        for part in force.harmonics:
            assert isinstance(part, Harmonic)
            parts.append(Harmonic(factor * float(part.amplitude), part.omega, part.phase))
    return Forcing(parts, constant=constant)


def _free_motion(formula: Formula = EQ9) -> Finding:
    """Prove (9), and hold it against free motions of four speeds."""
    x = formula.printed.rhs.subs(INDEX, K)
    begin, end = sympy.pi * K, sympy.pi * (K + 1)
    proof = Deduction(
        "(9) obeys (7), (8) and (4), and its impact times are pi k",
        (
            identity("it obeys (7)", x.diff(T, 2) + x, sympy.Integer(0)),
            identity("it is zero at pi k", x.subs(T, begin), sympy.Integer(0)),
            identity("and leaves with V0", x.diff(T).subs(T, begin), V0),
            identity("it is back at pi (k + 1), the next zero of the sine", x.subs(T, end), 0 * V0),
            identity("where the impact turns -V0", x.diff(T).subs(T, end), -V0),
        ),
    )
    checks: list[Comparison] = []
    for v0 in ("1e-6", "0.1", "1.5", "1000"):
        run = simulate(WALL, v0=v0, t_end=100.0)
        checks += [
            impacts_at(f"V0 = {v0}: t_k minus pi k, to t = 100", run, eigenset(WALL, 40)),
            enclosed(f"V0 = {v0}: x/V0 minus (9)", _off_formula(formula, v0), -ROUNDING, ROUNDING),
        ]
    return Finding(
        (proof, *checks),
        study=motion_text(run),
    )


def _off_formula(formula: Formula, v0: str) -> arb | None:
    """Return how far the free motion is from a formula for it, over V0."""
    proven = certain_run(simulate(WALL, v0=v0, t_end=100.0))
    if proven is None:
        return None
    speed = arb(v0)
    largest = arb(0)
    for t, value in zip(NUMBERS, proven(NUMBERS)[0].arbs, strict=True):
        numbers = {T: arb(float(t)), INDEX: arb(int(t / math.pi)), V0: speed}
        largest = largest.max(abs(value - enclose(formula.printed.rhs, numbers)) / speed)
    return largest


def _shifted(formula: Formula = EQ9, more: str = "7/10") -> Finding:
    """Add the free motion to forced ones whose impact times are the eigenset."""
    free = formula.printed.rhs.subs(INDEX, K)
    begin, end = sympy.pi * K, sympy.pi * (K + 1)
    proof = Deduction(
        "x + x0 obeys (5) and (4) under the force of x",
        (
            identity(
                "between impacts, where x'' = f - x",
                (FORCE - X + free.diff(T, 2)) + (X + free),
                FORCE,
            ),
            identity("x0 is zero at pi k, as x is", free.subs(T, begin), 0 * V0),
            identity(
                "and its velocity is turned there, as that of x is",
                free.diff(T).subs(T, end),
                -free.subs(K, K + 1).diff(T).subs(T, end),
            ),
        ),
    )
    added = sympy.Rational(more)
    sums = []
    for n, v0 in ((2, "0"), (3, "3/5"), (4, "1/10")):
        faster = str(sympy.Rational(v0) + sympy.Rational(7, 10))
        parts: list[MotionPart] = [
            (1.0, simulate(WALL, sine(n), v0=v0, t_end=60.0), None),
            (1.0, simulate(WALL, v0=str(added), t_end=60.0), None),
            (-1.0, simulate(WALL, sine(n), v0=faster, t_end=60.0), None),
        ]
        what = f"sin {n}t: x of V0 = {v0} plus x0 of 7/10 minus x of {faster}"
        sums.append(sum_within(what, parts, NUMBERS, ROUNDING))
    return Finding(
        (proof, *sums),
        study=motion_text(parts[-1][1]),
    )


def shared_times(difference: sympy.Expr = DIFFERENCE) -> Deduction:
    """Return the proof that motions of one force can share times of the eigenset alone."""
    flight = sympy.Symbol("s", real=True)
    return Deduction(
        "motions of one force with the same impact times have them in the eigenset",
        (
            identity(
                "on a flight from t_k the difference z of the two obeys (7): it is D sin(t - t_k)",
                difference.diff(T, 2) + difference,
                0 * D,
            ),
            identity("zero at t_k", difference.subs(T, T_K), 0 * D),
            identity("with the slope D = W_k - V_k", difference.diff(T).subs(T, T_K), D),
            identity(
                "if D is 0 on one flight, it is on the next and on the one before: x and y are "
                "one motion. So it is not 0 on any flight",
                difference.subs(D, 0),
                0 * D,
            ),
            identity(
                "z vanishes at t_(k+1) too: there the sine is zero",
                difference.subs(T, T_K + flight) / D,
                sympy.sin(flight),
            ),
            identity(
                "which it is at the multiples of pi, and nowhere else",
                sympy.sin(sympy.pi * K),
                sympy.Integer(0),
            ),
        ),
    )


def _property_1(difference: sympy.Expr = DIFFERENCE) -> Finding:
    """Prove Property 1, and change the initial velocity, off the eigenset and on it."""
    proof = shared_times(difference)
    rng = np.random.default_rng(1)
    least, worst = math.inf, 0.0
    for _ in range(60):
        omegas, amplitudes = rng.uniform(0.4, 5.0, 2), rng.uniform(0.3, 1.0, 2)
        phases, v0 = rng.uniform(-3.0, 3.0, 2), float(rng.uniform(0.3, 2.0))
        force = Forcing(map(Harmonic, amplitudes, omegas, phases), constant=0.5)
        least = min(least, _change(force, v0))
    for m in (2, 3, 4, 5):
        worst = max(worst, _change(SubsetMotion(m, "0.1").forcing, 0.1))
    for n in (2, 3, 4, 5):
        worst = max(worst, _change(sine(n), 0.6))
    remark = (
        "The eigenset is counted from an impact. In the printed proof (7) should be (5), and sin t "
        "should be sin(t - t_k). It calls on the uniqueness of motions, which is not needed here: "
        "between common impact times the equation is linear."
    )
    return Finding(
        (
            proof,
            Measurement(
                "60 random forces, V0 changed by 1e-3: largest move of 4 impacts, the least",
                least,
                low=1e-6,
                high=math.inf,
                error=ROUNDING,
            ),
            Measurement(
                "on the eigenset and its subsets: largest move",
                worst,
                low=-ROUNDING,
                high=ROUNDING,
                error=1e-13,
            ),
        ),
        remark=remark,
        study=motion_text(_few_impacts(force, v0)),
    )


def _few_impacts(force: Forcing, v0: float) -> Trajectory:
    return simulate(WALL, force, v0=v0, max_impacts=4, t_end=200)


def _change(force: Forcing, v0: float) -> float:
    """Return by how much the first impacts move with the initial velocity."""
    one, other = (_few_impacts(force, v) for v in (v0, v0 + 1e-3))
    count = min(len(one.impacts), len(other.impacts))
    return apart(one.impacts.t[:count], other.impacts.t[:count])


def _split(formula: Formula = EQ15, amplitude: sympy.Expr = V) -> Finding:
    """Put (15) into (5), for any particular solution and for those of cos 2t and sin 2t."""
    part = sympy.Function("p")(T)
    start, slope = sympy.Symbol("p(0)", real=True), PART_SLOPE

    def of(side: sympy.Expr, amplitude: sympy.Expr, p: sympy.Expr = part) -> sympy.Expr:
        ends = (start, slope) if p == part else (p.subs(T, 0), p.diff(T).subs(T, 0))
        values = {PART: p, PART_START: ends[0], A_Y: amplitude}
        return sympy.expand(side.subs(values).subs(slope, ends[1]))

    def residual(y: sympy.Expr, p: sympy.Expr) -> sympy.Expr:
        """Return y'' + y - f, where f = p'' + p."""
        return sympy.expand(y.diff(T, 2) + y - p.diff(T, 2) - p)

    printed, correct = formula.printed.rhs, FLIGHT.rhs
    any_printed, any_right = of(printed, amplitude), of(correct, V - slope)
    part_cos, part_sin = -sympy.cos(2 * T) / 3, -sympy.sin(2 * T) / 3
    against = Deduction(
        "(15) with A_y = V is no flight of (5)",
        (
            identity("put into (5) it leaves", residual(any_printed, part), -start),
            identity(
                "which is 1/3 for the force cos 2t",
                residual(of(printed, amplitude, part_cos), part_cos),
                sympy.Rational(1, 3),
            ),
            identity(
                "and for sin 2t, where it is 0, the flight starts with another velocity than V",
                of(printed, amplitude, part_sin).diff(T).subs(T, 0),
                V - sympy.Rational(2, 3),
            ),
        ),
        concludes="differs",
    )
    ends = {part.diff(T): slope, part: start}
    proof = Deduction(
        "(15) with x_part(0) cos t, and A_y = V - x_part'(0)",
        (
            identity("it obeys (5)", residual(any_right, part), 0 * V),
            identity("starts from the wall", any_right.subs(ends).subs(T, 0), 0 * V),
            identity("with V", any_right.diff(T).subs(ends).subs(T, 0), V),
        ),
    )
    flights = ((1, "cos 2t", part_cos), (2, "sin 2t", part_sin))
    printed_off = [
        _off_flight(f"{name}: x minus (15), to t = 1.5", n, of(printed, amplitude.subs(V, 1), p))
        for n, name, p in flights
    ]
    right_off = [
        _off_flight(
            f"{name}: x minus the corrected form, to t = 1.5",
            n,
            of(correct, 1 - p.diff(T).subs(T, 0), p),
        )
        for n, name, p in flights
    ]
    return Finding(
        (against, *printed_off),
        (proof, *right_off),
        "x_part(0) cos t for x_part(0), with A_y = V - x_part'(0) and t from t_k; "
        "(15) itself holds for the x_part that starts from rest",
        remark="What the proof needs, that two flights differ by (A_y - A_z) sin t, is right.",
        study=motion_text(_flight(1)),
    )


def _flight(which: int) -> Trajectory:
    """Return the flight under cos 2t (1) or sin 2t (2) from V = 1."""
    return simulate(WALL, cosine(2) if which == 1 else sine(2), v0=1, t_end=1.5)


def _off_flight(what: str, which: int, y: sympy.Expr) -> Comparison:
    """Compare the flight under cos 2t (1) or sin 2t (2) from V = 1 with an expression."""
    proven = certain_run(_flight(which))
    if proven is None:
        return enclosed(what, None, -ROUNDING, ROUNDING)
    t = np.linspace(0.0, 1.5, 301)
    largest = arb(0)
    for time, value in zip(t, proven(t)[0].arbs, strict=True):
        largest = largest.max(abs(value - enclose(y, {T: arb(float(time))})))
    return enclosed(what, largest, -ROUNDING, ROUNDING)


def _closeness(formula: Formula = EQ16, faster: str = "1.001") -> Finding:
    """Prove (16) for all common impact times, and follow motions whose velocities differ by 1e-3."""
    other = sympy.Symbol("A_z", real=True)
    y = FLIGHT.rhs
    apart_by = D * sympy.sin(T)
    proof = Deduction(
        "on common impact times two motions of one force stay as close as their velocities",
        (
            identity(
                "on a flight y - z = D sin t, with D = A_y - A_z and t from t_k",
                y - y.subs(A_Y, other),
                apart_by.subs(D, A_Y - other),
            ),
            identity(
                "D^2 exceeds (y - z)^2 by a square: |y - z| is at most |D|",
                D**2 - apart_by**2,
                (D * sympy.cos(T)) ** 2,
            ),
            identity(
                "and D^2 exceeds (y' - z')^2 by a square",
                D**2 - apart_by.diff(T) ** 2,
                (D * sympy.sin(T)) ** 2,
            ),
            identity(
                "a common flight lasts a multiple of pi (Property 1): |D| is the same on the next",
                apart_by.diff(T).subs(T, sympy.pi * K) ** 2,
                D**2,
            ),
        ),
    )
    bound = float(formula.printed.rhs.subs(EPSILON, sympy.Rational("0.001")))
    # From 0.1 on, so that no time is an impact.
    t = np.linspace(0.1, 60.0, 400)
    over = subset_constant(3)
    force = SubsetMotion(3, 0).forcing
    slower = str(sympy.Rational(faster) - sympy.Rational("0.8"))
    cases: tuple[tuple[str, list[MotionPart]], ...] = (
        (
            "the eigenset, sin 2t",
            [(s, simulate(WALL, sine(2), v0=v, t_end=60), None) for s, v in _pair("1", faster)],
        ),
        (
            "Y_3",
            [(s, simulate(WALL, force, v0=v, t_end=60), over) for s, v in _pair("0.2", slower)],
        ),
    )
    return Finding(
        (
            proof,
            *(
                sum_within(
                    f"largest |{name}| on {where}, eps = 0.001", parts, t, bound, velocity=velocity
                )
                for where, parts in cases
                for name, velocity in (("y - z", False), ("y' - z'", True))
            ),
        ),
        remark="The differences are eps |sin(t - t_k)| and eps |cos(t - t_k)| on each flight.",
        study=motion_text(cases[0][1][0][1]),
    )


def _pair(one: str, other: str) -> tuple[tuple[float, str], tuple[float, str]]:
    return (1.0, other), (-1.0, one)


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    *oscillator_statements.STATEMENTS,
    *multi_harmonics.STATEMENTS,
    *solution_statements.STATEMENTS,
    _of(
        id="eq6",
        reference="(6)",
        claim="Motions with the same impact times may be added with positive factors, and their "
        "forces with them.",
        formula=EQ6,
        method="the equation and the impacts of the sum; motions under the combined force",
        theory="paper-oscillator.md",
        find=_combination,
    ),
    _of(
        id="eq9",
        reference="(7) to (9)",
        claim="Without a force the motion from V0 is (9): the impact times are the eigenset pi k, "
        "whatever V0.",
        formula=EQ9,
        method="(9) put into (7), (8) and (4); free motions of four speeds",
        find=_free_motion,
    ),
    _of(
        id="eigenset-sum",
        reference="section 3",
        claim="The free motion added to a motion whose impact times are the eigenset is another "
        "motion under the same force, with another initial velocity.",
        method="the equation and the impacts of the sum; the sum formed at 301 times",
        theory="paper-oscillator.md",
        find=_shifted,
    ),
    _of(
        id="property1",
        reference="Property 1",
        claim="Different motions with the same impact times, not within the eigenset, have "
        "different forces: with the force kept, another initial velocity gives other impact times.",
        method="proof; motions under 60 random forces, and on the eigenset and its subsets",
        find=_property_1,
    ),
    _of(
        id="eq15",
        reference="(15)",
        claim="A flight from the velocity V is A_y sin t - x_part(0) + x_part(t), with A_y = V and "
        "a particular solution x_part.",
        formula=EQ15,
        method="put into (5); flights under cos 2t and sin 2t",
        find=_split,
    ),
    _of(
        id="eq16",
        reference="(16)",
        claim="Motions of one force on the same impact times whose velocities differ by less than "
        "eps stay within eps of each other, in displacement and velocity, flight after flight.",
        formula=EQ16,
        method="proof; two motions on the eigenset and two on Y_3, to t = 60",
        theory="paper-oscillator.md",
        find=_closeness,
    ),
)
