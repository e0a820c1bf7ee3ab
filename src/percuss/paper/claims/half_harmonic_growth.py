"""Statements on the growth under sin t: (27), (35), its constant, and where the impacts tend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial

import numpy as np
import sympy
from flint import arb

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified.numbers import ball
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.half_harmonic import half_harmonic_growth, half_harmonic_invariant
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run
from percuss.paper.claims.certain_gains import excess_of_two_flights, two_impacts
from percuss.paper.claims.certain_growth import GrowthBounds, growth_bounds
from percuss.paper.claims.comparisons import WithError, agreement, last_of, stated
from percuss.paper.claims.half_harmonic_formulas import (
    COS,
    EPS,
    EQ27,
    EQ30,
    EQ35,
    EQ35_FACTOR,
    FACTOR,
    INTERVAL,
    LANDING,
    MEAN,
    ROOT_FACTOR,
    SIN,
    T_K,
    TIME,
    TWO_FLIGHTS,
    V_K,
    compared,
    root_steps,
    two_impact_steps,
)
from percuss.paper.evidence import Comparison, Deduction, Measurement, Step, compare
from percuss.paper.formula import Formula
from percuss.paper.proof import identity, sign, theorem
from percuss.paper.statement import Finding

THEORY = "half-harmonic.md"
LONG = 200_000
# After so many impacts from rest the velocity is 32.4, and the bounds close.
PROVEN_IMPACTS = 1000
# Two impacts are bounded from this velocity on, for phases so far on either side.
FROM_VELOCITY = Fraction(30)
AROUND = Fraction(7, 50)
# How far b computed from impact 10,000 and from impact 200,000 may be apart, in doubles.
CONVERGED = 1e-13
# The first thousand impacts are left out of fits: the logarithm is largest there.
LATE, LATER = slice(1000, None), slice(2000, None)


@cache
def first_impacts(v0: float = 0.0, restitution: str = "1") -> Trajectory:
    """Return the first thousand impacts under sin t from the wall at t = 0."""
    osc = impact_oscillator(restitution)
    return simulate(osc, sine(1), v0=v0, max_impacts=PROVEN_IMPACTS)


@cache
def impacts(v0: float, restitution: str = "1") -> tuple[Floats, Floats, Floats]:
    """Return times, velocities and phases of 200,000 impacts under sin t from the wall at t = 0."""
    run = simulate(impact_oscillator(restitution), sine(1), v0=v0, max_impacts=LONG)
    return run.impacts.t, run.impacts.v_after, 2.0 * math.pi * run.impacts.cycle


@cache
def limit_constant(v0: float) -> tuple[float, float, float]:
    """Return b, the factor of ln t and the limit of the phase, from the last impact of a run."""
    _, v, phase = impacts(v0)
    law = half_harmonic_growth(float(phase[-1]), float(v[-1]))
    return law.constant, law.logarithm, law.phase


def smooth_speeds(v: Floats, phase: Floats) -> Floats:
    """Return velocities freed of their alternation, abs(V e^(i t_k) + i pi/4)."""
    return numerics.modulus(v * numerics.phasor(phase) + 0.25j * math.pi)


@cache
def phase_shift() -> tuple[float, float]:
    """Return the limit of t_k - k pi from rest, and how far neighbours still are from each other."""
    t, _, _ = impacts(0.0)
    ahead = t[-2:] - math.pi * np.arange(LONG - 1, LONG + 1)
    return float(ahead.mean()), float(abs(ahead[1] - ahead[0]))


@cache
def unbounded_steps(v0: float = 0.0, restitution: str = "1") -> tuple[Step, ...]:
    """Return the steps of the proof that velocities under sin t grow without bound from a start.

    Parameters
    ----------
    v0
        Velocity at t = 0.
    restitution
        Of the wall; the proof closes for 1 alone.
    """
    eps, tau = EPS, sympy.Symbol("tau", real=True)
    height = sympy.sin(tau) * (2 + eps * COS + eps * tau * SIN) - eps * tau * COS * sympy.cos(tau)
    least = 2 + eps * (COS + tau * SIN - sympy.Abs(COS))
    every: dict[sympy.Symbol, tuple[int | str, int | str]] = {eps: (0, "1/30"), T_K: (0, 7)}
    steps = (
        identity(
            "An impact turns the velocity and keeps its size.",
            sympy.Rational(restitution) * V_K,
            V_K,
        ),
        *two_impact_steps(),
        sign(
            "For V >= 30 no flight ends before 3/2: as tau cos(tau) <= sin(tau) there, "
            "2 x/V is at least sin(tau) times this;",
            least,
            {**every, tau: (0, "3/2")},
        ),
        sign("nor from 3/2 to 5/2, where 2 x/V is", height, {**every, tau: ("3/2", "5/2")}),
        sign(
            "and from 5/2 to 11/3 it falls: there is one root, that near pi.",
            -sympy.diff(height, tau),
            {**every, tau: ("5/2", "11/3")},
        ),
    )
    return (*steps, *_induction(late_growth(v0, restitution), v0))


@dataclass(frozen=True)
class LateGrowth:
    """Where the impacts of a motion are after PROVEN_IMPACTS, and how far they can still go.

    Parameters
    ----------
    low, high
        Range of phases, t_k - k pi, over which two impacts are bounded.
    phase, speed
        Of the last impact that is enclosed.
    bounds
        Of two impacts, for phases of that range and speeds of at least FROM_VELOCITY.
    """

    low: Fraction
    high: Fraction
    phase: arb
    speed: arb
    bounds: GrowthBounds

    @property
    def moved(self) -> arb:
        """The most that the phase moves in all impacts to come."""
        return self.bounds.total_drift(self.speed)

    @property
    def limit(self) -> arb:
        """Encloses the limit of the phase, if it stays in the range."""
        return self.phase + arb(0, 1) * self.moved.upper()

    @property
    def stays(self) -> bool:
        """Whether the phase stays in the range and the speed grows, if impacts are elastic."""
        inside = ball(self.low) < self.limit and self.limit < ball(self.high)
        fast = self.speed > int(FROM_VELOCITY)
        return bool(inside and fast and self.bounds.gain > 0 and self.bounds.drift.is_finite())


@cache
def late_growth(v0: float, restitution: str = "1") -> LateGrowth | None:
    """Return the late growth of a motion under sin t from the stop, None where it is not proven."""
    run = certain_run(first_impacts(v0, restitution))
    if run is None:
        return None
    phase = run.impacts.t.arbs[-1] - PROVEN_IMPACTS * arb.pi()
    middle = Fraction(round(100 * float(phase.mid())), 100)
    low, high = middle - AROUND, middle + AROUND
    bounds = growth_bounds(low, high, FROM_VELOCITY)
    return LateGrowth(low, high, phase, run.impacts.v_after.arbs[-1], bounds)


def _induction(late: LateGrowth | None, v0: float) -> tuple[Step, ...]:
    if late is None:
        return (Step("The first impacts are proven.", "", False, "balls"),)
    phase, fast = float(late.phase.mid()), float(late.speed.mid())
    low, high, bounds = float(late.low), float(late.high), late.bounds
    return (
        Step(
            f"The first {PROVEN_IMPACTS} impacts from V0 = {v0:g} are enclosed.",
            rf"t_k - k \pi = {phase:.6f}, \ V_k = {fast:.6f}",
            bool(late.speed > int(FROM_VELOCITY)) and low < phase < high,
            "balls",
        ),
        Step(
            f"For all phases from {low:g} to {high:g} and all V >= {FROM_VELOCITY} two impacts "
            "add at least this to V^2,",
            rf"V_{{k+2}}^2 - V_k^2 > {float(bounds.gain.lower()):.3f}",
            bool(bounds.gain > 0),
            "balls",
        ),
        Step(
            "and move the phase at most by this.",
            rf"|t_{{k+2}} - t_k - 2\pi| < {float(bounds.drift.upper()):.3f} \, V_k^{{-3}}",
            bool(bounds.drift.is_finite()),
            "balls",
        ),
        Step(
            "So while the phase stays in that range V_k^2 grows linearly, and the sum of all "
            "moves is less than this: the phase never leaves the range, and V_k^2 grows for ever.",
            rf"\sum |t_{{k+2}} - t_k - 2\pi| < {float(late.moved.upper()):.3f}",
            late.stays,
            "balls",
        ),
    )


def phase_limit_steps(v0: float = 0.0) -> tuple[Step, ...]:
    """Return the steps that t_k - k pi has a limit psi under sin t, and where it is."""
    late = late_growth(v0)
    limit = "" if late is None else rf"\psi = {_shown(late.limit)}"
    return (
        *unbounded_steps(v0),
        theorem(
            "The moves of the phase over two impacts have a finite sum, so it has a limit psi for "
            "even k (absolutely convergent series: Rudin 1976, theorem 3.45); as V_k grows the "
            "flights tend to pi, and psi is the limit for odd k as well.",
            r"\lim_{k \to \infty} \, (t_k - k \pi) = \psi",
        ),
        Step("It lies here.", limit, late is not None and late.stays, "balls"),
    )


def envelope_steps(v0: float = 0.0) -> tuple[Step, ...]:
    """Return the steps that V^2/t tends to sin(2 psi)/2 under sin t."""
    return (
        *phase_limit_steps(v0),
        theorem(
            "The gains of V^2 tend to pi sin(2 psi) a time 2 pi. Their means have the same limit "
            "(Cauchy; Hardy 1949, Divergent series, section 1.3), so V^2/t tends to sin(2 psi)/2.",
            r"\lim V^2/t = \frac{1}{2}\sin 2\psi",
        ),
    )


def off_eigenset(stated: float = 0.0) -> Deduction:
    """Return the deduction that the impact times from rest do not tend to k pi + stated."""
    late = late_growth(0.0)
    apart = late is not None and not (late.limit - stated).sin().contains(0)
    step = Step("That is no multiple of pi from what is stated.", f"{stated:g}", apart, "balls")
    return Deduction("limit of t_k - k pi, from V0 = 0", (*phase_limit_steps(), step), "differs")


def _shown(number: arb) -> str:
    return rf"{float(number.mid()):.4f} \pm {float(number.rad()) + 5e-5:.4f}"


def _resonance(restitution: str = "1") -> Finding:
    t, v, phase = impacts(0.0, restitution)
    half = len(v) // 2 - 1
    square = smooth_speeds(v, phase) ** 2
    rate = float((square[-1] - square[half]) / (t[-1] - t[half]))
    middle = (half + len(v)) // 2
    later = float((square[-1] - square[middle]) / (t[-1] - t[middle]))
    last = phase[-2:] - math.pi * np.floor(phase[-2:] / math.pi)
    expected = 0.5 * numerics.sin(2.0 * float(last.mean()))
    return Finding(
        (
            Deduction(
                "V_k grows without bound from V0 = 0", unbounded_steps(restitution=restitution)
            ),
            # The logarithm in V^2 adds 4e-7 over this range.
            compare(
                "growth of V^2 per time, impacts 100,000 to 200,000, against sin(2 psi)/2",
                rate,
                expected,
                1e-5,
                error=abs(later - rate),
            ),
            Measurement(
                "sin(2 psi)/2, which is to be positive",
                expected,
                0.0,
                math.inf,
                error=float(abs(last[1] - last[0])),
            ),
        ),
        remark=f"The largest impact velocity is {v.max():.6g} up to impact 200,000.",
        study=motion_text(first_impacts(restitution=restitution)),
    )


def _square_root(formula: Formula) -> Finding:
    t, v, phase = impacts(0.0)
    b, logarithm, psi = limit_constant(0.0)
    smooth = smooth_speeds(v, phase)
    exponent, error = numerics.fit_line(numerics.log(t[LATE]), numerics.log(smooth[LATE]))
    matrix = np.column_stack([t, numerics.log(t), np.ones_like(t)])
    fits = [
        numerics.least_squares(matrix[part], smooth[part] ** 2, 1e-14) for part in (LATE, LATER)
    ]
    linear, logarithmic = (last_of([float(fit[k]) for fit in reversed(fits)]) for k in (0, 1))
    law = formula.printed.rhs
    power = float(sympy.simplify(TIME * sympy.diff(law, TIME) / law))
    steps = (
        *envelope_steps(),
        *root_steps(law, "What is printed solves dV/dt = b^2/(2V),"),
    )
    return Finding(
        (
            Deduction("V/sqrt t has a positive limit, from V0 = 0", steps),
            # Over this run the logarithm bends the exponent by (ln t)/t: 1e-4.
            agreement(
                "exponent of the velocity over time", WithError(exponent, error), power, 1e-3
            ),
            agreement("factor of t in V^2, fitted, against sin(2 psi)/2", linear, b**2, 1e-8),
            agreement(
                "factor of ln t in V^2, fitted, against theory", logarithmic, logarithm, 1e-3
            ),
        ),
        remark=(
            "The law holds though its derivation does not: V^2 = sin(2 psi) t/2 + c ln t + O(1), "
            "V freed of its alternation by (pi/4) sin psi. The standard error of the exponent is "
            f"{error:.1e}; psi = {psi:.12f}, c = {logarithm:.6f}."
        ),
        study=motion_text(first_impacts()),
    )


def _factor_from_34(formula: Formula) -> tuple[Step, ...]:
    """Return the steps that (34), with one average a, gives one b."""
    law = EQ35.printed.rhs
    stated = formula.printed.rhs
    return (
        identity(
            "(34) gives V dV/dt = a/pi, so V = b sqrt t with this b, for every start,",
            (law * sympy.diff(law, TIME)).subs(ROOT_FACTOR, stated),
            MEAN / sympy.pi,
        ),
        identity(
            "as the average a of the numerator of (33) knows no start.",
            sympy.diff(stated, T_K),
            sympy.Integer(0),
        ),
    )


def _universal(
    formula: Formula = EQ35_FACTOR, starts: tuple[float, ...] = (0.0, 1.0, 10.0, 100.0)
) -> Finding:
    b = {v0: limit_constant(v0)[0] for v0 in starts}
    printed = tuple(
        compare(
            f"b for V0 = {v0:g}, against that for V0 = 0", b[v0], b[0.0], 0.005, error=CONVERGED
        )
        for v0 in starts[1:]
    )
    corrected: list[Comparison] = []
    for v0 in (10.0, 100.0):
        invariant = float(half_harmonic_invariant(0.0, v0))
        closed = math.sqrt(0.5 * math.sqrt(1.0 - invariant**2))
        # The error of the invariant, by its expansion and by four roundings, carried over to b.
        slope = 0.5 * closed * abs(invariant) / (1.0 - invariant**2)
        error = slope * (3.0 * v0**-7 + 4.0 * 2.0**-52)
        value = limit_constant(v0)[0]
        what = f"b for V0 = {v0:g}, closed form"
        corrected.append(compare(what, value, closed, error, error=CONVERGED))
    simple = math.sqrt(math.pi / (2.0 * math.sqrt(3.0) * 100.0))
    what = "b for V0 = 100, leading term"
    corrected.append(compare(what, limit_constant(100.0)[0], simple, 1e-5, error=CONVERGED))
    two = starts[:2]
    steps = tuple(dict.fromkeys(step for v0 in two for step in envelope_steps(v0)))
    differ = (*_factor_from_34(formula), *steps, _apart(two))
    return Finding(
        (Deduction("b from two starts", differ, "differs"), *printed),
        (Deduction("V^2/t tends to sin(2 psi)/2 from each start", steps), *corrected),
        "b = sqrt(sin(2 psi)/2), where the phase psi of the impacts depends on the start",
        remark="On each motion b is a constant, as the article says. b = "
        + ", ".join(f"{b[v0]:.10f} (V0 = {v0:g})" for v0 in starts)
        + ". For a large V0 at t = 0, cos 2 psi = (4 V0/pi) arctan(pi/(2 V0)) - 1. As no sine "
        "exceeds 1, b is at most 1/sqrt 2; which values below that occur is not settled here.",
        study=motion_text(first_impacts(starts[-1])),
    )


def _apart(starts: Sequence[float]) -> Step:
    """Return the step that 2 b^2 from one start is not that from another."""
    growths = [late_growth(v0) for v0 in starts]
    squares = [(2 * late.limit).sin() for late in growths if late is not None]
    shown = r",\ ".join(
        rf"{_shown(square)} \ (V_0 = {v0:g})" for square, v0 in zip(squares, starts, strict=True)
    )
    differ = len(squares) == 2 and not squares[0].overlaps(squares[1])
    return Step("The two limits are not the same.", rf"\sin 2\psi = {shown}", differ, "balls")


def _large_times(formula: Formula) -> Finding:
    """Examine the time of two flights."""
    a = EQ30.printed.rhs
    excess_said = formula.printed.rhs - 2 * sympy.pi
    stated = sympy.limit(excess_said.subs(FACTOR, a).subs(V_K, 1 / EPS) / EPS, EPS, 0)
    steps = two_impact_steps()
    moved = compared(
        "V times the excess of t_(k+2) - t_k over 2 pi, for large V",
        steps,
        sympy.sympify(stated),
        sympy.Integer(0),
        {T_K: ("7/10", "7/10")},
    )
    said = float(sympy.N(sympy.sympify(stated).subs(T_K, sympy.Rational(7, 10))))
    measured, squares = [], []
    for v in (100, 10_000):
        value, radius = excess_of_two_flights("7/10", v)
        what = f"V (t_(k+2) - t_k - 2 pi), t_k = 0.7, V = {v:g}"
        measured.append(compare(what, value, said, 1e-2, radius))
        square = f"V^2 (t_(k+2) - t_k - 2 pi), t_k = 0.7, V = {v:g}"
        # The third order has the factor 0.93 there.
        squares.append(compare(square, v * value, 0.0, 1.0 / v, v * radius + 1e-15))
    c = sympy.Symbol("C", positive=True)
    constant = identity(
        "Any constant of integration leaves the leading term as it is.",
        sympy.limit(sympy.sqrt(ROOT_FACTOR**2 * TIME + c) / sympy.sqrt(TIME), TIME, sympy.oo),
        ROOT_FACTOR,
    )
    return Finding(
        (moved, *measured),
        (Deduction("two flights last 2 pi, up to the third order", (*steps, constant)), *squares),
        "t_(k+2) - t_k = 2 pi + O(V_k^-3), for a_(k+1) = -a_k to the first order; V(0) = 0 lies "
        "outside V >> 1, where (34) is derived, and is not needed",
        remark="In (34) itself the term is of the order that is left out.",
        study=motion_text(two_impacts("7/10", v)),
    )


def _subharmonic(printed: float = 0.0) -> Finding:
    """Examine whether impact times approach k pi + printed."""
    t, _, _ = impacts(0.0)
    gaps = np.abs(np.diff(t) - math.pi)
    slope, error = numerics.fit_line(numerics.log(t[1001:]), numerics.log(gaps[1000:]))
    shift, away = phase_shift()
    psi = limit_constant(0.0)[2]
    approach: tuple[Comparison, ...] = (
        compare("p of abs(t_(k+1) - t_k - pi) ~ t^-p", -slope, 0.5, 0.005, error=error),
        Measurement(
            "largest late deviation of an interval from pi",
            gaps[-1000:].max(),
            1e-9,
            0.01,
            error=2.0 * float(np.spacing(t[-1])),
        ),
    )
    what = "limit of t_k - k pi, from V0 = 0"
    late = late_growth(0.0)
    phases = (0, 2) if late is None else (late.low, late.high)
    shifted = (
        *phase_limit_steps(),
        identity(
            "Periodic intervals that tend to pi would all be pi, and on such a flight 2 x at its "
            "end is not zero:",
            LANDING.subs(INTERVAL, sympy.pi),
            sympy.pi * COS,
        ),
        sign("The intervals are not periodic.", COS, {T_K: phases}),
    )
    return Finding(
        (off_eigenset(printed), *approach, compare(what, shift, printed, away, error=away**2)),
        (
            Deduction("t_k - k pi tends to psi, and the intervals are not periodic", shifted),
            *approach,
            # Of the mean of two neighbours the first order is gone.
            compare(f"{what}, against psi", shift, psi, 1e-5, error=away**2),
        ),
        "they approach the eigenset shifted by psi, t_k - k pi -> psi, which the start decides: "
        f"psi = {psi:.5f} from V0 = 0",
        remark=(
            "The intervals tend to pi, the impact times do not tend to multiples of pi. The "
            "article counts time from the first impact; the shift is then that of psi from the "
            "phase of the force there."
        ),
        study=motion_text(first_impacts()),
    )


_statement = stated(
    THEORY, "exact run of the impact oscillator, held against the invariant of its impact map"
)


GROWTH_STATEMENTS = (
    _statement(
        "eq27",
        "(27)",
        "x'' + x = sin t, from rest on the wall, exhibits resonance.",
        _resonance,
        EQ27,
        "1000 impacts enclosed, then bounds of two impacts for all larger velocities",
    ),
    _statement(
        "large-times",
        "section 5",
        "t_(k+2) - t_k = 2 pi (1 + a_k); at times much larger than this, V(0) = 0.",
        partial(_large_times, TWO_FLIGHTS),
        TWO_FLIGHTS,
        "expansion of the exact impact map; two impacts in ball arithmetic",
    ),
    _statement(
        "eq35", "(35)", "Impact velocities grow as b sqrt t.", partial(_square_root, EQ35), EQ35
    ),
    _statement(
        "eq35-constant",
        "b of (35)",
        "By (34) the constant b is sqrt(2a/pi), with the average a of the numerator of (33): the "
        "same for every start.",
        _universal,
        EQ35_FACTOR,
    ),
)
# The record of the same id elsewhere gives way to this one.
SUBHARMONIC_STATEMENTS = (
    _statement(
        "periodicity-subharmonic",
        "section 5, conclusion",
        "In the first sub-harmonic resonance the impact times are not periodic, but asymptotically "
        "close to the eigenset.",
        _subharmonic,
        method="200,000 impacts; exponent of the approach by least squares, and its limit",
    ),
)
