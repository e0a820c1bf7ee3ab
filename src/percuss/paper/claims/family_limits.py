"""Appendix A of the paper held against evidence: up to which V0 the impact times are Y_m."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial

import numpy as np
import sympy

from percuss import numerics
from percuss.certified import keeps_subset
from percuss.io.study_text import motion_text
from percuss.motion.eigenset_forms import (
    SubsetMotion,
    contact_time,
    subset_critical_velocity,
    subset_forcing,
)
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import impacts_at, subset_constant
from percuss.paper.claims.comparisons import (
    ROUNDING,
    WALL,
    furthest,
    last_unchanged,
    latest,
)
from percuss.paper.claims.family_formulas import (
    CONTACT,
    EQ11,
    EQ14,
    EQA3,
    EQA4,
    EQA5,
    EQA6_A7,
    EQA8,
    KICK,
    A,
    D,
    V,
    t,
)
from percuss.paper.claims.family_formulas import m as m_
from percuss.paper.claims.family_proofs import (
    Equation,
    amplitudes,
    contact_is_unique,
    deduced,
    of_parity,
    positive_long,
    positive_short,
)
from percuss.paper.evidence import (
    Comparison,
    Deduction,
    Evidence,
    Measurement,
    Step,
    compare,
    counted,
)
from percuss.paper.formula import Formula
from percuss.paper.proof import sign
from percuss.paper.statement import Finding, Statement

THEORY = "paper-family.md"
TABLE_1 = {5: "1.5", 7: "0.984", 9: "0.675", 11: "0.486", 13: "0.365", 15: "0.283"}
EVEN = (2, 4, 6, 8, 10)
# An impact slower than this may pass for a touch: its depth is below the rounding of x.
SLOWEST_IMPACT = 2e-6
# How far from V* two starts are between which it provably lies.
NEARBY = 1e-11
# V0 of figs 3 and 4.
MAXIMAL = 2 / sympy.sqrt(3)
# Of curves, in units of pi.
GRID = 1e-4


def _kick(m: int) -> float:
    """Return q."""
    return 2 / (m + 1) * numerics.sin(math.pi / (m + 1))


def _two_periods(m: int, v0: float) -> Trajectory:
    return simulate(WALL, subset_forcing(m), v0=v0, t_end=(2 * (m + 1) + 0.5) * math.pi)


def _beside_limit(m: int, side: float) -> Trajectory:
    """Return two periods from just below V* (side = -1) or just above (side = 1)."""
    return _two_periods(m, subset_critical_velocity(m) + side * NEARBY)


def _stays(m: int, v0: float) -> bool:
    """Return whether the impacts of two periods are those of Y_m."""
    run = _two_periods(m, v0)
    return len(run.impacts) == 4 and furthest(run, SubsetMotion(m, 0).impact_times(4)) < 1e-8


@cache
def _simulated_limit(m: int) -> float:
    """Return by halving up to which V0 simulated impact times are Y_m; V* is not used."""
    return last_unchanged(partial(_stays, m), _kick(m), 4.0)


def _even_bound(bound: Formula) -> list[Step | Equation]:
    """Return why a formula is the bound of V0 for even m: V1 is 0 there."""
    following = of_parity(EQ14.printed.rhs, "even")
    return [
        Equation(
            "even m: the velocity after the long flight is 0 at the bound, negative above",
            "V_1(V^*)",
            following.subs(V, of_parity(bound.printed.rhs, "even")),
            sympy.S.Zero,
        ),
        *positive_short(),
        *positive_long(),
    ]


def _valid(bound: Formula = EQA4) -> Finding:
    parts = (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99)
    stay = sum(
        _stays(m, part * subset_critical_velocity(m)) for m in range(2, 16) for part in parts
    )
    long, _ = amplitudes()
    return Finding(
        (
            deduced(
                "even m: x > 0 for 0 < V0 < 2q; odd m: x > 0 up to a contact on the long flight",
                Equation("(A1) begins with V0", "u'(0) - w'(0)", _slope(0, long), V),
                *_even_bound(bound),
                *contact_is_unique(),
            ),
            counted("motions of 98 (m = 2 to 15, seven V0 below V*) that stay on Y_m", stay, 98),
        ),
        remark="At V0 = 0 and V0 = V* some impacts have no velocity.",
        study=motion_text(_two_periods(2, parts[-1] * subset_critical_velocity(2))),
    )


def _slope(time: sympy.Expr | int, amplitude: sympy.Expr) -> sympy.Expr:
    """Return u' - w' of (A1) at an impact."""
    return sympy.diff(EQ11.printed.rhs, t).subs(A, amplitude).subs(t, time)


# V0 of even m over 2q: below the bound, and above it.
BELOW = (Fraction(1, 100), Fraction(99, 100))
ABOVE = (Fraction(101, 100), Fraction(19, 10))


def _slopes(condition: Formula = EQA3) -> Finding:
    """Hold (A3) against x > 0 where the flights of even m begin, for V0 below 2q and above."""
    return Finding(
        (_condition_on_slopes(condition.printed),),
        (_condition_on_slopes(EQA3.printed if condition.right is None else condition.right),),
        "u' >= w' at the start of each flight, without the absolute values: on the long flight "
        "of even m |u'| <= |w'|",
        remark="The bars are blanks in the text, and the primes stand apart. On the short flight "
        "(A3) is right at the start.",
        study=motion_text(_two_periods(2, float(BELOW[1]) * subset_critical_velocity(2))),
    )


def _condition_on_slopes(condition: sympy.Rel) -> Deduction:
    """Return whether a condition on the slopes says the same as x > 0."""
    ratio = sympy.Symbol("r", positive=True)
    u, w = sympy.symbols("u' w'")
    long, short = amplitudes()
    starts = {"long": ({u: 2 * ratio - 1, w: -1}), "short": ({u: 3 - 2 * ratio, w: 1})}
    gaps = {flight: (condition.lhs - condition.rhs).subs(at) for flight, at in starts.items()}
    slopes = [
        Equation(
            "u' and w' at the start of the long flight: V0 - q and -q, even m",
            "x'(0)",
            of_parity(_slope(0, long), "even"),
            of_parity(V - KICK + KICK, "even"),
        ),
        Equation(
            "u' and w' at the start of the short flight: 3q - V0 and q, even m",
            r"x'(m\pi + 0)",
            of_parity(_slope(m_ * sympy.pi, short), "even"),
            of_parity(3 * KICK - V - KICK, "even"),
        ),
    ]
    what = "the condition on the slopes is x > 0, even m"
    holds = [
        sign("it holds on the long flight for V0 = 2 q r, r < 1", gaps["long"], {ratio: BELOW}),
        sign("it holds on the short flight for r < 1", gaps["short"], {ratio: BELOW}),
        sign("it does not hold on the short flight for r > 1", -gaps["short"], {ratio: ABOVE}),
    ]
    against = sign(
        "it does not hold on the long flight for V0 = 2 q r, r < 1, where x > 0",
        -gaps["long"],
        {ratio: BELOW},
    )
    if against.holds:
        deduction = deduced(what, *slopes, *positive_long(), against)
        return replace(deduction, concludes="differs")
    return deduced(what, *slopes, *_even_bound(EQA4), *holds)


def _even(bound: Formula = EQA4) -> Finding:
    printed = bound.side(m_)
    checks = [
        compare(
            f"V*({m}) found by simulation", _simulated_limit(m), printed(m), 2 * SLOWEST_IMPACT,
            error=SLOWEST_IMPACT,
        )
        for m in EVEN
    ]  # fmt: skip
    return Finding(
        (deduced("the bound of V0 for even m", *_even_bound(bound)), *checks),
        remark="No impact is added at V*: the velocity 2q - V0 of the impact at m pi vanishes, "
        "and above V* it comes earlier. Simulation decides this down to impacts of 1e-6.",
        study=motion_text(_two_periods(EVEN[0], _simulated_limit(EVEN[0]))),
    )


def _third(bound: Formula = EQA5) -> Finding:
    middle = sympy.Rational(3, 2) * sympy.pi
    x = EQ11.printed.rhs.subs(A, bound.printed.rhs - KICK)
    printed = float(bound.printed.rhs)
    return Finding(
        (
            deduced(
                "V*(3), from the contact in the middle",
                *contact_is_unique(),
                Equation("x at the middle", r"x(3\pi/2)", x.subs({t: middle, m_: 3}), sympy.S.Zero),
                Equation(
                    "its slope",
                    r"x'(3\pi/2)",
                    sympy.diff(x, t).subs({t: middle, m_: 3}),
                    sympy.S.Zero,
                ),
            ),
            _limit("V*(3), between two certified starts", 3, printed, ROUNDING),
            compare(
                "V*(3) found by simulation",
                _simulated_limit(3),
                printed,
                ROUNDING,
                error=NEARBY,
            ),
        ),
        study=motion_text(_two_periods(3, _simulated_limit(3))),
    )


def _system(system: Formula = EQA6_A7) -> Finding:
    """Hold (A6) against the contact of (11), and look where simulation adds an impact."""
    value, slope, bound = system.printed
    x = EQ11.printed.rhs.subs({A: D, t: CONTACT})
    long, _ = amplitudes()
    proof = deduced(
        "(A6) says that the long flight touches the wall, (A7) that its amplitude is at most D",
        Equation("the first line is x at the contact", "x(t_*)", x, value.lhs - value.rhs),
        Equation(
            "the second is its slope",
            "x'(t_*)",
            sympy.diff(x, CONTACT),
            slope.lhs - slope.rhs,
        ),
        Equation("(A7) has the amplitude of the long flight", "A", long, bound.lhs),
        *contact_is_unique(),
        Equation(
            "with the contact in (pi, 2 pi) there is its mirror image, in [(m-2) pi, (m-1) pi]",
            r"x(m\pi - t_*)",
            of_parity(x.subs(CONTACT, m_ * sympy.pi - CONTACT), "odd"),
            of_parity(x, "odd"),
        ),
    )
    checks: list[Evidence] = []
    for m in TABLE_1:
        above = subset_critical_velocity(m) * (1 + 1e-10)
        run = simulate(WALL, subset_forcing(m), v0=above, t_end=m * math.pi)
        # The dip has the width of the root of its depth, 1e-5.
        added = latest(run, 0, math.inf)
        what = f"m = {m}: impact that is added just above V*, and m pi - t*"
        checks.append(compare(what, added, contact_time(m), 1e-4, error=3e-5))
    return Finding(
        (proof, *checks),
        remark="The long flight touches at t* and, by its symmetry about m pi/2, at m pi - t*; "
        "the earlier touch decides. For m = 3 both are 3 pi/2.",
        study=motion_text(run),
    )


def _through_contact(bound: Formula = EQA8) -> Finding:
    _, slope, _ = EQA6_A7.printed
    (amplitude,) = sympy.solve(slope, D)
    printed = bound.side(CONTACT, m_)
    checks = [
        _limit(
            f"V*({m}), between two certified starts, and (A8)",
            m,
            printed(m * math.pi - contact_time(m), m),
            ROUNDING,
        )
        for m in TABLE_1
    ]
    return Finding(
        (
            deduced(
                "(A8) is D + q, D from the second line of (A6)",
                Equation("V* by (A8), less q", "V^* - q", bound.printed.rhs - KICK, amplitude),
                *contact_is_unique(),
            ),
            *checks,
        ),
        remark="For m = 3 (A8) is 0/0, and (A5) holds instead.",
        study=motion_text(_beside_limit(min(TABLE_1), -1.0)),
    )


def _limit(what: str, m: int, expected: float, tolerance: float) -> Comparison:
    """Compare the limit of the velocities with Y_m, between two starts that balls decide.

    All impacts of the lower start are on Y_m, not all of the upper one; what must not be negative,
    x and the velocities, is linear in V0.
    """
    value = subset_critical_velocity(m)
    kept = [keeps_subset(m, value + side * NEARBY).holds for side in (-1.0, 1.0)]
    return compare(what, value, expected, tolerance, NEARBY if kept == [True, False] else math.inf)


def _table(table: Mapping[int, str] = TABLE_1) -> Finding:
    return Finding(
        tuple(
            _limit(f"V*({m})", m, float(entry), 0.5 * 10.0 ** -len(entry.split(".")[1]))
            for m, entry in table.items()
        ),
        remark="Tolerance: half a unit of the last printed digit.",
        study=motion_text(_beside_limit(min(table), -1.0)),
    )


def _both_sides(
    even: Formula = EQA4, third: Formula = EQA5, table: Mapping[int, str] = TABLE_1
) -> Finding:
    """Find the limit of the velocities with Y_m, by certified starts and by simulation."""
    printed = {m: (float(even.side(m_)(m)), ROUNDING) for m in EVEN}
    printed[3] = float(third.printed.rhs), ROUNDING
    for m, entry in table.items():
        printed[m] = float(entry), 0.5 * 10.0 ** -len(entry.split(".")[1])
    checks: list[Evidence] = []
    for m, (value, tolerance) in printed.items():
        what = f"m = {m}: limit of the velocities with Y_m"
        checks.append(_limit(what, m, value, tolerance))
    return Finding(
        tuple(checks),
        remark="Each lies between two certified starts 2e-11 apart.",
        study=motion_text(_beside_limit(3, 1.0)),
    )


def _of_figures(m: int, v0: float) -> Trajectory:
    return simulate(WALL, subset_forcing(m), v0=v0, t_end=6.5 * (m + 1) * math.pi)


def _velocities_of_figures(
    largest: sympy.Expr = MAXIMAL, others: tuple[float, ...] = (0.5,)
) -> Finding:
    """Hold the velocities of figs 3 and 4 against the bounds for m = 2 and 3."""
    second = EQ14.printed.rhs.subs(m_, 2)
    proof = deduced(
        "2/sqrt(3) is V*(2)",
        Equation("m = 2: V1 is 0 at this V0", "V_1", second.subs(V, largest), sympy.S.Zero),
        *_even_bound(EQA4),
        sign("m = 3: the same V0 is below the bound", EQA5.printed.rhs - largest, {}),
        *contact_is_unique(),
    )
    runs = [(2, v0) for v0 in others] + [(3, v0) for v0 in (*others, float(largest))]
    checks = [
        impacts_at(
            f"m = {m}, V0 = {v0:.4g}: impact times minus those of Y_{m}",
            _of_figures(m, v0),
            SubsetMotion(m, 0).impact_times(13),
            over=subset_constant(m),
        )
        for m, v0 in runs
    ]
    return Finding(
        (proof, *checks),
        remark="At V0 = 2/sqrt(3) every second impact of m = 2 has no velocity: the mass touches "
        "the wall. The third V0 of the figures is 0.",
        study=motion_text(_of_figures(*runs[-1])),
    )


def _curves(velocities: tuple[float, float] = (1.2, 2.0)) -> Finding:
    """Look where u - w of the two panels of fig. A1 is least."""
    first, second = velocities
    at, least = _least(2, first, 0, 3)
    middle, height = _least(3, second, 1, 2)
    what = f"(b), m = 3, V0 = {second:g}: "
    return Finding(
        (
            Measurement(
                what + "t/pi of the least u - w where sin t < 0", middle, 1.499, 1.501, GRID
            ),
            Measurement(what + "u - w there", height, 0.0, math.inf, GRID),
        ),
        remark=f"(a), m = 2, V0 = {first:g}: u - w is least, {least:.4f}, at t = {at:.3f} pi. This "
        f"V0 is above V*(2) = {subset_critical_velocity(2):.4f}: where u < w (A2) is violated, and "
        "the impact before t = 2 pi is not one of Y_2.",
        study=motion_text(_two_periods(3, second)),
    )


def _least(m: int, v0: float, low: int, high: int) -> tuple[float, float]:
    """Return where u - w of (A1) is least between two multiples of pi, over pi, and its value."""
    long, short = (float(amplitude.subs({V: v0, m_: m}).evalf()) for amplitude in amplitudes())
    turns = np.linspace(low, high, 1 + round((high - low) / GRID))
    amplitude = np.where(turns <= m, long, short)
    x = EQ11.side(A, t, m_)(amplitude, math.pi * turns, m)
    return float(turns[x.argmin()]), float(x.min())


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="family-valid",
        reference="section 3, (A1), (A2)",
        claim="For 0 < V0 < V*(m) the motion (11) with (13), (14) stays positive between the "
        "times of Y_m.",
        method="algebra and inequalities; simulation for m = 2 to 15",
        find=_valid,
    ),
    _of(
        id="eqA3",
        reference="(A3)",
        claim="For even m, x = u - w >= 0 reduces to a condition on the slopes.",
        formula=EQA3,
        method="slopes where the flights begin, below the bound and above",
        find=_slopes,
    ),
    _of(
        id="eqA4",
        reference="(A4)",
        claim="V*(m) for even m.",
        formula=EQA4,
        method="algebra and inequalities; the limit found by simulation alone, without the formula",
        find=_even,
    ),
    _of(
        id="eqA5",
        reference="(A5)",
        claim="V*(3), from a contact in the middle of the long flight.",
        formula=EQA5,
        method="the contact put into (11); certified starts; the limit found by simulation",
        find=_third,
    ),
    _of(
        id="eqA6-A7",
        reference="(A6), (A7)",
        claim="For other odd m the limit comes from a contact of u and w at t*, with V* = D + q.",
        formula=EQA6_A7,
        method="the contact of (11); where simulation adds an impact",
        find=_system,
    ),
    _of(
        id="eqA8",
        reference="(A8)",
        claim="V*(m) for odd m through the instant of contact.",
        formula=EQA8,
        method="algebra; certified starts just below and just above",
        find=_through_contact,
    ),
    _of(
        id="table1",
        reference="table 1",
        claim="V* = 1.5, 0.984, 0.675, 0.486, 0.365, 0.283 for m = 5, 7, 9, 11, 13, 15.",
        method="certified starts just below and just above",
        find=_table,
    ),
    _of(
        id="table1-simulated",
        reference="table 1",
        claim="At V*(m) the impact times change.",
        method="certified starts just below and just above, 2e-11 apart",
        find=_both_sides,
    ),
    _of(
        id="fig3-4",
        reference="figs 3, 4",
        claim="For m = 2, V0 = 2/sqrt(3) is the maximal velocity at which the impact times remain "
        "Y_m; the trajectories for m = 3 have the same V0.",
        method="algebra and inequalities; certified runs",
        find=_velocities_of_figures,
    ),
    _of(
        id="figA1",
        reference="fig A1",
        claim="The curves u and w for m = 3, V0 = 2 are nearest in the middle of the long flight, "
        "where u > w.",
        method="(A1) evaluated on a grid",
        find=_curves,
    ),
)
