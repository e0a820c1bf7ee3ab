"""From smooth to bilinear, from bilinear to rigid: questions of the introduction, and beyond."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import sympy

from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import bilinear_oscillator
from percuss.motion.simulate import simulate
from percuss.paper.claims.bilinear_limit import (
    STIFFNESSES,
    beat_run,
    bilinear_run,
    bilinear_saturation,
    first_delays,
    graze,
    graze_error,
    graze_run,
    half_harmonic_run,
    half_harmonic_saturation,
    impact_run,
    local_orders,
    saturation_speed,
    time_errors,
)
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.comparisons import (
    DOUBLES,
    ROUNDING,
    WithError,
    agreement,
    last_of,
)
from percuss.paper.claims.off_resonance import (
    DETUNING,
    damped_deviation,
    fig_2_run,
    interval_ends,
    kinds_from_rest,
    periodic_start,
    run_near_periodic,
)
from percuss.paper.claims.smoothed import STATEMENTS as SMOOTHED
from percuss.paper.evidence import Deduction, Measurement, Step, counted
from percuss.paper.proof import identity, sign
from percuss.paper.statement import Finding, Statement

BEYOND = "beyond the article"

# Frequency and phase of a force with which the bilinear oscillator arrives too low at a graze,
# and of one with which it passes above.
GRAZES = {"low": (0.7, 0.8), "high": (0.7, -0.8)}
OFF = Fraction("2.02")
# Of a period: a lag of this size is seen beside the marks on the axis of fig 2.
VISIBLE_LAG = 0.1
# Some ten impacts: the start of a motion that is long, as ball arithmetic has it.
START_END = 40.0


def _impact_limit(contact: float = math.pi) -> Finding:
    large = np.array(STIFFNESSES[-3:])
    errors = np.array([time_errors(float(k))[1:6] for k in large])
    orders = [last_of(local_orders(large, column)) for column in errors.T]
    predicted = first_delays(impact_run(), contact)[1:6]
    # (k-, impacts)
    ratios = errors * np.sqrt(large)[:, np.newaxis] / predicted
    away = last_of(np.abs(ratios - 1.0).max(axis=1))
    worst = max(orders, key=lambda order: abs(order.value + 0.5))
    first = WithError(float(time_errors(large[0])[0]), DOUBLES)
    return Finding(
        (
            agreement("first impact: difference", first, 0.0, ROUNDING),
            agreement("impacts 2 to 6: power of k-, furthest", worst, -0.5, 1e-3),
            agreement("errors by the first-order ones, furthest from 1", away, 0.0, 1e-3),
        ),
        remark=f"sqrt(k-) times the delay of impact 6 is {predicted[-1]:.6f}, of impact 2 "
        f"{predicted[0]:.6f}.",
        study=motion_text(bilinear_run(STIFFNESSES[-1])),
    )


def _impact_limit_at_grazing(power: float = -0.25) -> Finding:
    large = np.array(STIFFNESSES[-3:])
    low, high = (graze(*GRAZES[name]) for name in ("low", "high"))
    below = np.array([graze_error(low, float(k)) for k in large])
    above = np.array([graze_error(high, float(k)) for k in large])
    ratio = last_of(below / np.array([low.predicted(float(k)) for k in large]))
    return Finding(
        # The next term is smaller by k-^(-1/4) times a factor of about 5, 2e-3 at 1e14.
        (
            agreement(
                "arriving too low: power of k-", last_of(local_orders(large, below)), power, 0.01
            ),
            agreement("arriving too low: error by 2 sqrt(2 f c) k-^(-1/4)", ratio, 1.0, 0.01),
            agreement(
                "passing above: power of k-", last_of(local_orders(large, above)), -0.5, 0.01
            ),
        ),
        study=motion_text(graze_run(low, float(large[-1]))),
    )


def _saturation(factor: float = 4.0) -> Finding:
    checks = []
    for n in (2, 4):
        peaks = {k: bilinear_saturation(n, k) for k in (1e6, 1e8)}
        # The next term is smaller by 1/sqrt(k-).
        largest = last_of([v / saturation_speed(n, k, factor) for k, (v, _) in peaks.items()])
        late = last_of([t / math.sqrt(k) * n / math.pi for k, (_, t) in peaks.items()])
        checks.append(agreement(f"n = {n}: largest V, by the form", largest, 1.0, 1e-3))
        checks.append(agreement(f"n = {n}: its time by (pi/n) sqrt(k-)", late, 1.0, 1e-3))
    return Finding(tuple(checks), study=motion_text(beat_run(n, min(peaks))))


def _half_harmonic_saturation(most: float = 0.5) -> Finding:
    start = simulate(bilinear_oscillator(stiffness_below=1e4), cosine(1), t_end=START_END)
    if certain_run(start) is None:
        return Finding((), undecided=f"the start up to t = {START_END:g} is not proven")
    shares = {k: half_harmonic_saturation(k) ** 2 / math.sqrt(k) for k in (1e4, 1e6)}
    checks = tuple(
        Measurement(
            f"k- = {k:.0e}: largest V^2 over sqrt(k-); to 1/2, and 4/sqrt(k-) of slow motion",
            share,
            low=0.0,
            high=most + 4.0 / math.sqrt(k),
            error=ROUNDING,
        )
        for k, share in shares.items()
    )
    numbers = ", ".join(f"{share:.3f} at k- = {k:.0e}" for k, share in shares.items())
    return Finding(
        checks,
        remark=f"The largest V^2 / sqrt(k-) over 12 phases is {numbers}.",
        study=motion_text(half_harmonic_run(min(shares))),
    )


def _periodic_motion(faster: float) -> Deduction:
    """Deduce a motion with the period of cos(omega t), for omega from 2.001 to 3."""
    t, omega = sympy.symbols("t omega", positive=True)
    size, half = 1 / (omega**2 - 1), sympy.pi / omega
    bow = sympy.cos(t - half) / sympy.cos(half)
    x = size * (bow - sympy.cos(omega * t))
    speed = size * sympy.tan(half)
    steps = (
        identity("This flight solves the equation:", sympy.diff(x, t, 2) + x, sympy.cos(omega * t)),
        _meets("it begins on the wall,", x.subs(t, 0), "x(0) = 0"),
        identity("with V0;", sympy.diff(x, t).subs(t, 0), speed + sympy.nsimplify(faster)),
        _meets(
            "and ends there after one period of the force,",
            x.subs(t, 2 * half),
            r"x(\frac{2 \pi}{\omega}) = 0",
        ),
        identity("with the same speed.", -sympy.diff(x, t).subs(t, 2 * half), speed),
        sign("For omega from 2.001 to 3 V0 is positive,", speed, {omega: ("2001/1000", 3)}),
        sign("and cos(pi/omega) too.", sympy.cos(half), {omega: ("2001/1000", 3)}),
        identity(
            "Both factors on the right are positive inside the flight, where t/2 and pi/omega - "
            "t/2 lie between 0 and pi/2: x exceeds (1 - cos(omega t))/(omega^2 - 1), so nothing "
            "is met on the way.",
            sympy.cos(half) * (bow - 1),
            2 * sympy.sin(t / 2) * sympy.sin(half - t / 2),
        ),
    )
    what = "the impact oscillator has impacts with the period of cos(omega t), 2.001 <= omega <= 3"
    return Deduction(what, steps, "differs")


def _meets(text: str, position: sympy.Expr, shown: str) -> Step:
    return replace(identity(text, position, sympy.Integer(0)), formula=shown)


def _off_resonance(faster: float = 0.0) -> Finding:
    kinds, last = kinds_from_rest()
    from_rest = counted(
        f"from rest: phases of {len(kinds)} without a period",
        kinds.count("no_period_found"),
        len(kinds),
    )
    beside = 0.1
    special, nearby = periodic_start(OFF, faster), periodic_start(OFF, beside)
    damped = WithError(damped_deviation(0.01), DOUBLES)
    return Finding(
        (
            _periodic_motion(faster),
            from_rest,
            Measurement(
                "omega = 2.02, one V0: flight times less the period, if none had it",
                special,
                low=1e-9,
                high=math.inf,
                error=ROUNDING,
            ),
        ),
        (
            from_rest,
            agreement(
                "omega = 2.02, one V0: flight times less the period",
                WithError(special, DOUBLES),
                0.0,
                ROUNDING,
            ),
            Measurement("omega = 2.02, V0 + 0.1: the same", nearby, 1e-9, math.inf, ROUNDING),
            agreement("fig 2 with damping 0.01: intervals less the period", damped, 0.0, ROUNDING),
        ),
        "without damping, and for all motions but one: the impact oscillator has a periodic motion "
        "with V0 = |tan(pi/omega)/(1 - omega^2)|",
        remark=(
            "With damping every motion tends to a periodic one. Without it, motions from rest have "
            "no period in any phase of the force; the amplitude of the force changes only their "
            f"scale. After 60 periods their intervals are {last.min():.4f} to {last.max():.4f} "
            "periods."
        ),
        study=motion_text(run_near_periodic(OFF, beside)),
    )


def _intervals(detuning: float = DETUNING) -> Finding:
    """Compare the first and the last interval of fig 2 with the period, from rest in 8 phases."""
    ends = [interval_ends(step, detuning) for step in range(8)]
    ratios = [abs(last - 1) / abs(first - 1) for first, last, _ in ends]
    lags = [lag for _, _, lag in ends]
    what = "difference of the last interval from the period over that of the first, largest of 8 phases"
    largest = max(ratios, key=float)
    return Finding(
        (enclosed(what, largest, 1.0, math.inf),),
        (
            enclosed(what, largest, 0.0, 1.0),
            enclosed(
                "lag of the last impact behind the force, in periods, least of 8 phases",
                min(lags, key=float),
                VISIBLE_LAG,
                math.inf,
            ),
        ),
        "the intervals come closer to the period of the force; what grows, and becomes apparent in "
        "the end, is the lag of the impacts behind the force",
        remark=(
            f"In the phase of the figure the first interval is {float(ends[0][0].mid()):.4f} and "
            f"the last {float(ends[0][1].mid()):.4f} periods. After 60 periods the impacts lag "
            f"{float(min(lags, key=float)):.2f} to {float(max(lags, key=float)):.2f} of a period "
            "behind the force in the 8 phases."
        ),
        study=motion_text(fig_2_run(0, detuning)),
    )


STATEMENTS = (
    Statement(
        id="fig2-intervals",
        reference="introduction, fig 2",
        claim=(
            "Next to the resonance the intervals between impacts seem equal to the period of the "
            "force in the beginning, and differ from it visibly in the end."
        ),
        method="Fig 2 from rest in 8 phases of the force, in ball arithmetic.",
        find=_intervals,
        formula=r"\omega = 1.01\,\Omega_r,\ \omega_-^2/\omega_+^2 = 20",
        theory="resonances.md",
    ),
    Statement(
        id="commensurate-off-resonance",
        reference="introduction, fig 2",
        claim=(
            "Any minor deviation from a resonant frequency produces impact times that are not "
            "periodic, against the assumption of Shaw and Holmes."
        ),
        method="Fig 2 from rest in 8 phases of the force; a periodic motion in closed form; damping.",
        find=_off_resonance,
        formula=r"\omega = 1.01\,\Omega_r,\ \omega_-^2/\omega_+^2 = 20",
        theory="resonances.md",
    ),
    *SMOOTHED,
    Statement(
        id="bilinear-limit",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "Away from grazing the impact times of the bilinear oscillator tend to those of the impact "
            "oscillator as 1/sqrt(k-), each contact being a delay of pi/sqrt(k-)."
        ),
        method="First-order delays by the derivative of the impact map; k- up to 1e14.",
        find=_impact_limit,
        formula=r"t_j(k_-) - t_j = c_j/\sqrt{k_-} + O(1/k_-)",
        theory="bilinear-limit.md",
    ),
    Statement(
        id="bilinear-limit-grazing",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "After a graze at which the bilinear oscillator arrives too low, the error is of the order "
            "of k-^(-1/4); where it passes above, of k-^(-1/2)."
        ),
        method="A motion with one impact and a graze, found backwards; k- up to 1e14.",
        find=_impact_limit_at_grazing,
        formula=r"\delta v = 2\sqrt{2fc}\;k_-^{-1/4}",
        theory="bilinear-limit.md",
    ),
    Statement(
        id="bilinear-saturation",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "For finite k- the resonance at n = 2, 4 is a beat: the speed grows up to "
            "4 sqrt(k-)/(pi (n^2 - 1)), at the time (pi/n) sqrt(k-)."
        ),
        method="From rest under sin nt, k- = 1e6 and 1e8.",
        find=_saturation,
        formula=r"V_{max} = 4\sqrt{k_-}\,/\,\pi(n^2-1)",
        theory="bilinear-limit.md",
    ),
    Statement(
        id="bilinear-saturation-half",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "For finite k- the half-harmonic resonance ends too: V^2 stays below sqrt(k-)/2 but for "
            "a few units."
        ),
        method="From rest under cos(t + phase), 12 phases, over 40 sqrt(k-); k- = 1e4 and 1e6.",
        find=_half_harmonic_saturation,
        formula=r"V^2 < \sqrt{k_-}/2 + O(1)",
        theory="bilinear-limit.md",
    ),
)
