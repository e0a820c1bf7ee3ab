"""The derivation (27) to (35) as one chain: each line, and whether it follows from those before.

What is said of a line, that it follows or does not, is the outcome of its deduction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import sympy

from percuss.paper.claims.half_harmonic_formulas import (
    COS,
    EPS,
    EQ27,
    EQ28,
    EQ29,
    EQ30,
    EQ31,
    EQ32,
    EQ33,
    EQ34,
    EQ35,
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
    next_velocity_steps,
    no_mean,
    root_steps,
    two_impact_steps,
)
from percuss.paper.dependence import falls_with
from percuss.paper.evidence import Deduction
from percuss.paper.formula import Formula
from percuss.paper.proof import identity, leading_terms
from percuss.paper.statement import Finding, Statement

# The line at which the derivation breaks: those before it have slips that do no harm.
BREAK = "33"

# Where two expressions that differ are compared.
_HERE = {
    T_K: ("7/10", "7/10"),
    V_K: ("1", "1"),
    INTERVAL: ("1", "6"),
    FACTOR: ("1/10", "1/10"),
}


@dataclass(frozen=True)
class ChainLine:
    """A line of the derivation.

    Parameters
    ----------
    record
        Id of the statement that examines the line by itself.
    formula
        Of the line, printed and right.
    prove
        Deduces that the printed line follows from the right ones before it, or that it does not.
    step
        What is done to get there, in words.
    survives
        What is left of the line, in words.
    """

    record: str
    formula: Formula
    prove: Callable[[Formula], Deduction]
    step: str
    survives: str

    @cached_property
    def deduction(self) -> Deduction:
        """The deduction of the line, carried out when it is first asked for."""
        return self.prove(self.formula)

    @property
    def follows(self) -> bool:
        """Whether the printed line follows from the right ones before it."""
        return self.deduction.outcome == "agrees"

    @property
    def is_break(self) -> bool:
        """Whether the derivation breaks here."""
        return self.formula.number == BREAK


def _box(*expressions: sympy.Expr) -> dict[sympy.Symbol, tuple[str, str]]:
    names = set().union(*(expression.free_symbols for expression in expressions))
    return {name: _HERE.get(name, ("7/10", "7/10")) for name in names}


def _equation(formula: Formula) -> Deduction:
    force = formula.printed.rhs
    return Deduction("(27) is given", (identity("The force is", force, sympy.sin(TIME)),))


def _flights(formula: Formula) -> Deduction:
    motion = formula.printed.rhs
    twice = sympy.diff(motion, TIME, 2)
    step = identity("Put into (27), it solves it.", twice + motion, sympy.sin(TIME))
    return Deduction("(28) from (27)", (step,))


def _time_of_flight(formula: Formula) -> Deduction:
    right = INTERVAL * COS / (COS + 2 * V_K + INTERVAL * SIN)
    stated = formula.printed.rhs
    return compared("(29) from (28)", flight_equation_steps(), stated, right, _box(stated, right))


def _naming(formula: Formula) -> Deduction:
    steps = (
        identity(
            "It names the factor of xi_k, printed or right, of the same first term.",
            sympy.limit((formula.printed.rhs).subs(V_K, 1 / EPS) / EPS, EPS, 0),
            COS / 2,
        ),
    )
    return Deduction("(30) from (29)", steps)


def _interval(formula: Formula) -> Deduction:
    interval = formula.printed.rhs.subs(FACTOR, COS / 2 * EPS)
    right = sympy.sin(interval) * (2 + EPS * COS + EPS * interval * SIN)
    right -= EPS * interval * COS * sympy.cos(interval)
    printed = sympy.sin(interval) * (2 + EPS * COS) - EPS * interval * COS * sympy.cos(interval)
    zero = sympy.Integer(0)
    steps = (
        leading_terms("It solves the right equation to the first order,", right, EPS, 2, zero),
        leading_terms("and the printed (29) as well.", printed, EPS, 2, zero),
    )
    return Deduction("(31) from (29)", steps)


def _next_velocity(formula: Formula) -> Deduction:
    right = V_K + sympy.pi / 2 * (SIN + (sympy.pi / 2 * COS + 2 * SIN) * FACTOR)
    stated = formula.printed.rhs
    return compared("(32) from (31)", next_velocity_steps(), stated, right, _box(stated, right))


def _second_velocity(formula: Formula) -> Deduction:
    right = V_K + sympy.pi / 2 * sympy.sin(2 * T_K) / V_K
    stated = formula.printed.rhs
    gain = sympy.pi / 2 * (SIN + (sympy.pi / 2 * COS + 2 * SIN) * FACTOR)
    # The gain of the next impact, if its phase were that of this one: t_k + pi, -a_k.
    unmoved = gain.subs({T_K: T_K + sympy.pi, FACTOR: -FACTOR}, simultaneous=True)
    kept = (gain + unmoved).subs(FACTOR, COS / (2 * V_K))
    steps = two_impact_steps()
    deduction = compared("(33) from (32)", steps, stated, right, _box(stated, right))
    if deduction.concludes == "agrees":
        return deduction
    why = identity(
        "The printed (33) is what the right (32) gives twice if t_{k+1} is taken as t_k + pi: the "
        "shift pi a_k of the phase, of the same order, is left out.",
        V_K + kept,
        stated,
    )
    return Deduction(deduction.what, (*deduction.steps, why), "differs")


def _rate(formula: Formula) -> Deduction:
    stated = formula.printed.rhs
    if MEAN in stated.free_symbols:
        return no_mean("(34) from (33)")
    (speed,) = stated.free_symbols - {PHASE}
    rate = (speed * stated).subs(PHASE, T_K)
    mean = sympy.sin(2 * T_K) / 4
    return compared("(34) from (33)", growth_steps(), rate, mean, _box(rate))


def _root(formula: Formula) -> Deduction:
    law = formula.printed.rhs
    steps = root_steps(law, "It solves dV/dt = b^2/(2V), whatever the constant is,")
    return Deduction("(35) from (34)", steps)


LINES = (
    ChainLine("eq27", EQ27, _equation, "The equation.", "All of it."),
    ChainLine(
        "eq28", EQ28, _flights, "Solved between two impacts.", "All of it; the text lost a minus."
    ),
    ChainLine(
        "eq29",
        EQ29,
        _time_of_flight,
        "A_k and B_k from t_k and V_k; then x_k = 0 at the next impact.",
        "All but the term xi_k sin t_k in the denominator, which (31) does not need.",
    ),
    ChainLine("eq30", EQ30, _naming, "The factor of xi_k gets a name.", "The name."),
    ChainLine(
        "eq31", EQ31, _interval, "Large V_k.", "All of it: the interval to the first order in a_k."
    ),
    ChainLine(
        "eq32",
        EQ32,
        _next_velocity,
        "The velocity at the next impact.",
        "All but one factor: (pi/2) cos t_k for pi. What is derived from it in print uses the "
        "right one.",
    ),
    ChainLine(
        "eq33",
        EQ33,
        _second_velocity,
        "The next impact: (32) again, at t_{k+1}.",
        "The term in sin 2 t_k. That in cos^2 t_k is cancelled by the shift of the phase, pi a_k, "
        "which is left out.",
    ),
    ChainLine(
        "eq34",
        EQ34,
        _rate,
        "The numerator of (33) replaced by its average a > 0.",
        "dV/dt is a constant over V, but no average: the average is zero, and the phase stands "
        "still at this order, so nothing may be averaged. The constant is sin(2 psi)/4.",
    ),
    ChainLine(
        "eq35",
        EQ35,
        _root,
        "Integrated.",
        "The law b sqrt t. b = sqrt(sin(2 psi)/2) depends on the phase, so on the start; for "
        "pi/2 < psi < pi velocities fall.",
    ),
)


def wrong_lines() -> tuple[str, ...]:
    """Return the records of the lines that do not follow from the right ones before them."""
    return tuple(line.record for line in LINES if not line.follows)


def _chain(lines: Sequence[ChainLine]) -> Finding:
    root = next(line for line in lines if line.record == "eq35")
    whole = (*growth_steps(), *root.deduction.steps)
    return Finding(
        tuple(line.deduction for line in lines),
        (Deduction("from (27) to b sqrt t, with the right lines", whole),),
        "(33) has no term in cos^2 t_k, so its numerator has the mean zero; the phase psi of the "
        "impacts stands still and is not averaged over: dV/dt = sin(2 psi)/(4V), b = "
        "sqrt(sin(2 psi)/2)",
        remark=(
            "It breaks at (33). The square root of time survives; the argument by an average does "
            "not, and b depends on the phase. Of the statements of section 5 "
            f"{len(falls_with('eq33'))} rest on (33) as argued in print."
        ),
    )


CHAIN_STATEMENTS = (
    Statement(
        id="chain",
        reference="section 5",
        claim="(35) follows from (27) by (28) to (34).",
        method="each line derived from the right ones before it",
        find=partial(_chain, LINES),
        theory="half-harmonic.md",
    ),
)
