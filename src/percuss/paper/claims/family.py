"""Section 3 of the paper held against evidence: the motions whose impact times are Y_m."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial

import numpy as np
import sympy

from percuss import numerics
from percuss.io.study_text import motion_text
from percuss.model.exact import pi_times
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import cosine, sine
from percuss.motion.eigenset_forms import subset_critical_velocity, subset_forcing
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims import above_critical, family_limits, model_statements
from percuss.paper.claims import family_formulas as symbols
from percuss.paper.claims.certain import certain_run, impacts_at, subset_constant
from percuss.paper.claims.comparisons import ROUNDING, WALL, furthest, latest
from percuss.paper.claims.family_formulas import (
    EQ10,
    EQ11,
    EQ12,
    EQ13_LONG,
    EQ13_SHORT,
    EQ14,
    KICK,
)
from percuss.paper.claims.family_proofs import (
    Equation,
    deduced,
    exists,
    follows,
    of_parity,
    read,
    rebounds,
    right,
    roots,
    solves,
    starts,
)
from percuss.paper.evidence import Comparison, Deduction, Evidence, Measurement, compare, counted
from percuss.paper.formula import Formula, numerically
from percuss.paper.statement import Finding, Statement

THEORY = "paper-family.md"
NUMBERS = tuple(range(2, 10))
PARTS = (0.2, 0.6)
# Rounding of simulated times and velocities.
SIMULATED = 1e-12


@cache
def _run(m: int, part: float) -> Trajectory:
    """Return six periods (m+1) pi from V0 = part of V*(m), under the force of (11)."""
    t_end = 6.5 * (m + 1) * math.pi
    return simulate(WALL, subset_forcing(m), v0=part * subset_critical_velocity(m), t_end=t_end)


def _simulated(what: str, value: float, expected: float = 0.0) -> Comparison:
    """Compare a number of a motion without chaos; its error is that of some tens of impacts."""
    return compare(what, float(value), expected, ROUNDING, error=SIMULATED)


def _kick(m: int) -> float:
    """Return q."""
    return 2 / (m + 1) * numerics.sin(math.pi / (m + 1))


def _indices(recursion: Formula, m: int, count: int) -> list[int]:
    """Return s_1, s_2, ... by a recursion."""
    indices = [0]
    for index in range(count):
        values = {symbols.k: index, symbols.s: indices[-1], symbols.m: m}
        indices.append(int(recursion.printed.rhs.subs(values)))
    return indices[1:]


def _impact_times(recursion: Formula = EQ10) -> Finding:
    checks = tuple(
        impacts_at(
            f"m = {m}, V0 = {part:g} V*: t_k minus pi s_k, {len(_run(m, part).impacts)} impacts",
            _run(m, part),
            math.pi * np.array(_indices(recursion, m, 12), np.float64),
            over=subset_constant(m),
        )
        for m in NUMBERS
        for part in PARTS
    )
    return Finding(
        (exists(recursion), *checks),
        remark="Under the right force (12). Here q = 2/(m+1) sin(pi/(m+1)); for odd m the motions "
        "exist up to V* > 2q. The impact times of the single motions are certified.",
        study=motion_text(_run(3, PARTS[1])),
    )


def _zeros(motion: Formula = EQ11) -> Finding:
    x = motion.side(symbols.A, symbols.t, symbols.m)
    rows = [
        abs(x(amplitude, index * math.pi, m))
        for m in NUMBERS
        for amplitude in (-1.0, 0.0, 2.0)
        for index in _indices(EQ10, m, 8)
    ]
    what = "largest |x(pi s_k)| for m = 2 to 9, A = -1, 0, 2"
    return Finding(
        (
            deduced("(11) is zero on Y_m", *roots(motion=motion)),
            _simulated(what, max(rows)),
        ),
        study=motion_text(_run(2, PARTS[1])),
    )


def _force(force: Formula = EQ12) -> Finding:
    """Put (11) into the equation of motion; simulate under (12) as printed, and corrected."""

    def evidence(side: sympy.Expr) -> tuple[Evidence, ...]:
        deduction = deduced("(11) is a motion under (12)", solves(side))
        first = [
            _simulated(f"m = {m}: first impact over m pi", _first_impact(m, side), 1.0)
            for m in (3, 5)
        ]
        return (deduction, *first)

    return Finding(
        evidence(force.printed.rhs),
        evidence(right(force)),
        "(1 - m)(m + 3) in place of (3 - m)(m + 5)",
        remark="The printed factor, 16/(m+1)^2 - 1, is that of a cosine of frequency 4/(m+1), twice "
        "the one in (11). For even m the first zero m pi does not depend on the factor.",
        study=motion_text(_under(3, right(force))),
    )


def _under(m: int, side: sympy.Expr) -> Trajectory:
    """Return four periods (m+1) pi under a force of the form (12)."""
    wave = sympy.cos((2 * symbols.t + sympy.pi) / (symbols.m + 1))
    factor = sympy.Rational(side.coeff(wave).subs(symbols.m, m))
    constant = numerics.cos(math.pi / (m + 1))
    exact = Fraction(int(factor.p), int(factor.q))
    force = cosine(Fraction(2, m + 1), exact, pi_times(1, m + 1), constant)
    end = 4 * (m + 1) * math.pi
    return simulate(WALL, force, v0=0.3 * subset_critical_velocity(m), t_end=end)


def _first_impact(m: int, side: sympy.Expr) -> float:
    """Return the first impact time over m pi under a force of the form (12)."""
    run = _under(m, side)
    return latest(run, 0, run.t_end) / (m * math.pi)


def _amplitude(m: int, part: float, t: float) -> float:
    """Return A on the flight around t of a simulated motion."""
    free = EQ11.side(symbols.A, symbols.t, symbols.m)(0.0, t, m)
    return float((float(_run(m, part)(t)[0]) - free) / numerics.sin(t))


def _amplitudes_differ(name: str, side: sympy.Expr, flight: Callable[[int], float]) -> Comparison:
    """Compare amplitudes of simulated motions with a formula, at its worst."""
    formula = numerically(side, symbols.V, symbols.m)
    off = [
        _amplitude(m, part, flight(m)) - formula(_run(m, part).v0, m)
        for m in NUMBERS
        for part in PARTS
    ]
    return _simulated(f"A of simulated motions minus {name}, m = 2 to 9", max(off, key=abs))


def _long_amplitude(amplitude: Formula = EQ13_LONG) -> Finding:
    corrected = right(amplitude)

    def simulated(side: sympy.Expr, name: str) -> Comparison:
        return _amplitudes_differ(name, side, lambda _: 0.5 * math.pi)

    return Finding(
        (
            read("the amplitude of the long flight", amplitude, starts),
            simulated(amplitude.printed.rhs, "the printed one"),
        ),
        (
            deduced("the amplitude of the long flight", *starts(corrected)),
            simulated(corrected, "the right one"),
        ),
        "minus in place of plus, as (A1) has it",
        remark="The plus is printed: every plus survives in the text. What may be lost is a minus "
        "before V0, and with it the amplitude is wrong, too. (A1) prints V0 - q on the same flight.",
        study=motion_text(_run(2, PARTS[1])),
    )


def _short_amplitude(amplitude: Formula = EQ13_SHORT) -> Finding:
    return Finding(
        (
            read("the amplitude of the short flight", amplitude, rebounds),
            _amplitudes_differ("(13)", amplitude.printed.rhs, lambda m: (m + 0.5) * math.pi),
        ),
        remark="The text shows no minus before V0; as it loses minus signs, and the amplitude is "
        "wrong without it, it is read as printed. (A1) shows the same line in the same state.",
        study=motion_text(_run(3, PARTS[1])),
    )


def _next_velocity(following: Formula = EQ14) -> Finding:
    side = following.printed.rhs
    off = []
    for m in NUMBERS:
        formula = numerically(side.subs(symbols.m, m), symbols.V)
        off += [
            float(_run(m, part).impacts.v_after[1]) - formula(_run(m, part).v0) for part in PARTS
        ]
    return Finding(
        (
            read("the velocity of the next long flight", following, follows),
            _simulated("V1 of simulated motions minus (14), m = 2 to 9", max(off, key=abs)),
        ),
        remark="The text shows no minus before the first V0; as it loses minus signs, and the "
        "velocity is wrong without it, it is read as printed.",
        study=motion_text(_run(2, PARTS[1])),
    )


def _returns(following: Formula) -> Deduction:
    """Return after how many periods of Y_m the velocity comes back, from (14)."""
    even, odd = (of_parity(following.printed.rhs, parity) for parity in ("even", "odd"))
    name = r"V_1(V_1(V_0))"
    kick = of_parity(KICK, "even")
    return deduced(
        "the velocity comes back after two periods (m+1) pi for even m, after one for odd m",
        *follows(following.printed.rhs),
        Equation("even m: after two", name, even.subs(symbols.V, even), symbols.V),
        Equation(
            "not after one, unless V0 = q", "V_1 - V_0", even - symbols.V, 2 * (kick - symbols.V)
        ),
        Equation("odd m: after one", "V_1", odd, symbols.V),
    )


def _single_period(following: Formula) -> Deduction:
    """Return the contrary of the statement that for even m the period is 2 (m+1) pi."""
    even = of_parity(following.printed.rhs, "even")
    kick = of_parity(KICK, "even")
    deduction = deduced(
        "for even m and V0 = q, half of V*, the period is (m+1) pi",
        Equation(
            "even m, V0 = q: the velocity comes back", "V_1(q)", even.subs(symbols.V, kick), kick
        ),
    )
    return replace(deduction, concludes="differs") if deduction.outcome == "agrees" else deduction


def _periods(following: Formula = EQ14, counts: tuple[int, int] = (2, 1)) -> Finding:
    """Count the periods (m+1) pi after which the initial velocity comes back."""
    generic = tuple(
        counted(f"m = {m}, V0 = {part:g} V*: periods (m+1) pi in one of the motion",
                _repeats(_run(m, part)), counts[m % 2])
        for m in NUMBERS for part in PARTS
    )  # fmt: skip
    return Finding(
        (_single_period(following), *generic),
        (_returns(following), *generic),
        "for even m and V0 = V*/2, where V1 = V0, the period is (m+1) pi too",
        study=motion_text(_run(2, PARTS[1])),
    )


def _repeats(run: Trajectory) -> int:
    after = run.impacts.v_after[1::2]
    return int(np.flatnonzero(np.abs(after - run.v0) < 1e-9)[0]) + 1


def _commensurate(counts: tuple[int, int] = (2, 1)) -> Finding:
    """Compare the periods of the motions for m = 2 and 3 with that of the force."""
    ratios = tuple(
        _simulated(
            f"m = {m}, V0 = {part:g} V*: period of the motion over that of the force",
            _repeats(_run(m, part)) * (m + 1) * math.pi / (subset_forcing(m).period or math.nan),
            counts[m % 2],
        )
        for m in (2, 3)
        for part in PARTS
    )
    return Finding(
        (_single_period(EQ14), *ratios),
        (_returns(EQ14), *ratios),
        "for m = 2 and V0 = 1/sqrt(3), half of V*, the motion has the period of the force too",
        study=motion_text(_run(2, PARTS[1])),
    )


def _coincide(numbers: tuple[int, ...] = above_critical.NUMBERS) -> Finding:
    """Look for motions of the example whose impact times have no period."""
    pairs = [pair for pair in above_critical.neighbours_above() if pair.m in numbers]
    # What is followed for so long is proven in its beginning.
    if certain_run(_under_its_force(numbers[0])) is None:
        return Finding((), undecided="the beginning of a motion above V* is not proven")
    chaotic = [pair for pair in pairs if above_critical.is_chaotic(pair)]
    least = min((pair.growth for pair in chaotic), default=0.0)
    return Finding(
        (
            counted(
                f"motions of {len(pairs)} above V* that are chaotic", len(chaotic), 1, math.inf
            ),
            Measurement(
                "in these, least growth of the distance of two neighbours at an impact, in units "
                "of the first distance",
                least,
                above_critical.LINEAR,
                math.inf,
                above_critical.ROUNDING / above_critical.APART / 1000,
            ),
        ),
        remark="The motions above V* show it: chaotic impact times have no period, and the force "
        "has the period (m+1) pi. Those below V* do not: Y_m has the period (m+1) pi too, for every "
        "m, as the article says above (13); only their velocities, for even m, have twice that.",
        study=motion_text(above_critical.fastest_parting(tuple(pairs))),
    )


def _under_its_force(m: int) -> Trajectory:
    """Return the beginning of a motion above V*."""
    v0 = above_critical.PARTS[-1] * subset_critical_velocity(m)
    return simulate(WALL, subset_forcing(m), v0=v0, t_end=10.0)


# At 0.001 a flight passes so near a graze that roundings decide whether Y_2 is left.
LATE = 1.01e-3


def _stability(late: float = LATE) -> Finding:
    """Vary the initial velocity, and the time of the start."""
    moved = max(furthest(_run(m, part), _run(m, 0.2).impacts.t) for m in NUMBERS for part in PARTS)
    velocity = _simulated("moves of the impact times when V0 changes, m = 2 to 9", moved)
    eigenset = _simulated(
        "the same on the eigenset, under sin 2t, sin 3t and cos t",
        max(
            furthest(_on_eigenset(force, one), _on_eigenset(force, other).impacts.t)
            for force, one, other in ON_EIGENSET
        ),
    )
    beside = Measurement(
        f"sin 2t, sin 3t, cos t: largest distance from the eigenset in 2000 of its periods after a "
        f"start {late:g} late",
        max(_beside_eigenset(force, one, late) for force, one, _ in ON_EIGENSET),
        0.0,
        0.1,
        ROUNDING,
    )
    alone = (velocity, eigenset, beside)
    what = "m = {}: largest distance from the eigenset in 2000 periods after a start {:g} late"
    stray = [(what.format(m, late), _stray(m, late)) for m in (2, 4)]
    # What a lateness of 1e-6 leaves out is of its own order.
    drifts = [
        compare(f"m = {m}: drift of V over that derived", _drift(m), 1, 1e-5, error=2e-6)
        for m in NUMBERS
    ]
    return Finding(
        (
            *alone,
            *(Measurement(name, off, 0.0, 0.1, ROUNDING) for name, off in stray),
        ),
        (
            *alone,
            *(Measurement(name, off, 0.1, math.inf, ROUNDING) for name, off in stray),
            *drifts,
        ),
        "the eigenset is; its subsets Y_m are so against changes of V0 alone: after a start late by "
        "tau V drifts, for odd m by -(16/(m+1)^2) cos(pi/(m+1)) tau a period, and for m = 2 and 4 "
        "Y_m is left",
        remark="The impact times of the eigenset stay close to it after a late start; velocities need "
        "not: under cos t they then grow.",
        study=motion_text(_late_run(2, late)),
    )


# Forces, and two velocities that share the eigenset.
ON_EIGENSET = ((sine(2), 0.3, 0.9), (sine(3), 0.6, 0.9), (cosine(1), 0.3, 0.9))


@cache
def _on_eigenset(force: Forcing, v0: float) -> Trajectory:
    return simulate(WALL, force, v0=v0, t_end=60.0)


@cache
def _beside_eigenset(force: Forcing, v0: float, late: float) -> float:
    """Return how far from the eigenset a motion on it comes that starts late."""
    end = 2000.0 * math.pi
    times = simulate(WALL, force, v0=v0, t0=late, t_end=end).impacts.t / math.pi
    return float(np.abs(times - np.round(times)).max()) * math.pi


def _drift(m: int) -> float:
    """Return how V changes in two periods after a late start, over what is derived."""
    late, q = 1e-6, _kick(m)
    v0 = 0.4 * subset_critical_velocity(m)
    run = simulate(WALL, subset_forcing(m), v0=v0, t0=late, max_impacts=4)
    force = 4 / (m + 1) ** 2 * numerics.cos(math.pi / (m + 1))
    factor = 8.0 if m % 2 else 4.0 * (1.0 + v0 / (2.0 * q - v0))
    return (float(run.impacts.v_after[3]) - v0) / (-factor * force * late)


@cache
def _late_run(m: int, late: float) -> Trajectory:
    """Return 2000 periods (m+1) pi of a motion of Y_m that starts late."""
    end = 2000 * (m + 1) * math.pi
    v0 = 0.4 * subset_critical_velocity(m)
    return simulate(WALL, subset_forcing(m), v0=v0, t0=late, t_end=end)


def _stray(m: int, late: float) -> float:
    """Return how far from the eigenset a motion of Y_m comes that starts late."""
    times = _late_run(m, late).impacts.t / math.pi
    return float(np.abs(times - np.round(times)).max()) * math.pi


_of = partial(Statement, theory=THEORY)

OWN: tuple[Statement, ...] = (
    _of(
        id="eq10",
        reference="(10)",
        claim="There are motions whose impact times are Y_m, with the gaps m pi and pi in turn.",
        formula=EQ10,
        method="algebra and inequalities for every m; certified runs for m = 2 to 9",
        find=_impact_times,
    ),
    _of(
        id="eq11",
        reference="(11)",
        claim="For every A the function (11) is zero on Y_m.",
        formula=EQ11,
        method="algebra, for every m",
        find=_zeros,
    ),
    _of(
        id="eq12",
        reference="(12)",
        claim="The functions (11) satisfy x'' + x = f with the force (12).",
        formula=EQ12,
        method="(11) put into the equation of motion; simulation under both forces",
        find=_force,
    ),
    _of(
        id="eq13-long",
        reference="(13)",
        claim="On the long flight from t = 0 the amplitude is A = V0 + q, with "
        "q = 2/(m+1) sin(pi/(m+1)).",
        formula=EQ13_LONG,
        method="the velocity at the start of the flight; amplitudes of simulated flights",
        find=_long_amplitude,
    ),
    _of(
        id="eq13-short",
        reference="(13)",
        claim="On the short flight the amplitude is A = -V0 + q (1 + 2 (-1)^m), with "
        "q = 2/(m+1) sin(pi/(m+1)).",
        formula=EQ13_SHORT,
        method="the velocity at the start of the flight; amplitudes of simulated flights",
        find=_short_amplitude,
    ),
    _of(
        id="eq14",
        reference="(14)",
        claim="The next long flight begins with V1 = -V0 + 4/(m+1) sin(pi/(m+1)) for even m, V1 = V0 "
        "for odd m.",
        formula=EQ14,
        method="the velocity at the end of the short flight; simulated motions",
        find=_next_velocity,
    ),
    _of(
        id="family-period",
        reference="(14)",
        claim="The motion has the period 2(m+1) pi for even m, (m+1) pi for odd m.",
        method="(14) applied twice; simulation",
        find=_periods,
    ),
    _of(
        id="family-commensurate",
        reference="section 3",
        claim="For m = 3 the motion has the period of the force, for m = 2 twice it.",
        method="(14) applied twice; simulation",
        find=_commensurate,
    ),
    _of(
        id="periods-coincide",
        reference="section 3",
        claim="The example demonstrates that the periods of impact times and driving force do not "
        "have to coincide (the impact times may even be aperiodic).",
        method="the motions above V*, each with a neighbour",
        find=_coincide,
    ),
    _of(
        id="subset-stability",
        reference="abstract",
        claim="The eigenset and its subsets are stable with respect to variation of initial "
        "conditions.",
        method="simulation from varied velocities, and of 2000 periods from another time of start",
        find=_stability,
    ),
)

STATEMENTS: tuple[Statement, ...] = (
    *model_statements.STATEMENTS,
    *OWN,
    *family_limits.STATEMENTS,
    *above_critical.STATEMENTS,
)
