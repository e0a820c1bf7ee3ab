"""Statements (27)-(35) and figs 10-12: the half-harmonic resonance, x'' + x = sin t."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from percuss import numerics
from percuss.model.forcing import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.half_harmonic import (
    half_harmonic_expansion,
    half_harmonic_impact,
    half_harmonic_two_impacts,
)
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain_gains import (
    exponent_of_drift,
    mean_gain,
    two_proven_impacts,
)
from percuss.paper.claims.half_harmonic_growth import GROWTH_STATEMENTS
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "half-harmonic.md"
# Phases and velocities of impacts: none is special, and the flights from them are short and long.
STATES = ((0.7, 1.0), (2.0, 3.0), (5.0, 10.0), (0.7, 100.0))
PHASE = 0.7
# Equations that the theory derives, for every state or to the order that is stated.
PROVEN = (28, 29, 30, 31, 32, 33)
# Far enough for the power of the error to show, near enough for rounding not to.
VELOCITIES = np.array([100.0, 200.0, 400.0, 800.0])


def _exponent(errors: list[float]) -> float:
    """Return p of an error that falls as V^-p over VELOCITIES."""
    return -numerics.fit_line(numerics.log(VELOCITIES), numerics.log(np.abs(errors)))[0]


def _is_of_order(what: str, errors: list[float], power: float) -> Check:
    """Compare the power of 1/V of an error; the next order bends it by some hundredths."""
    return Check(f"exponent p of the error V^-p of {what}", _exponent(errors), power, 0.05)


def _flight_constants() -> Finding:
    run = simulate(impact_oscillator(), sine(1), v0=1.0, max_impacts=6)
    checks = []
    for k in (0, 2, 4):
        start, length = run.impacts.t[k], run.impacts.intervals[k + 1]
        t = start + np.array([0.05, 0.3, 0.6, 0.9]) * length
        x, v = run(t)
        # A and B from the position and the velocity at the first instant, then predict the rest.
        particular = -0.5 * t * numerics.cos(t)
        slope = -0.5 * numerics.cos(t) + 0.5 * t * numerics.sin(t)
        turn = np.array(
            [[numerics.sin(t[0]), numerics.cos(t[0])], [numerics.cos(t[0]), -numerics.sin(t[0])]]
        )
        a, b = numerics.solve_linear(turn, np.array([x[0] - particular[0], v[0] - slope[0]]))
        apart_x = x - (a * numerics.sin(t) + b * numerics.cos(t) + particular)
        apart_v = v - (
            (a - 0.5) * numerics.cos(t) - b * numerics.sin(t) + 0.5 * t * numerics.sin(t)
        )
        worst = float(np.abs([apart_x, apart_v]).max())
        checks.append(Check(f"largest difference on flight {k + 1}", worst, 0.0, 1e-12))
    return Finding(tuple(checks))


def _flight_equation() -> Finding:
    printed, corrected = [], []
    for t, v in STATES:
        interval = half_harmonic_impact(t, v)[0] - t
        s, c = numerics.sin(t), numerics.cos(t)
        measured = numerics.tan(interval)
        what = f"tan xi for t_k = {t:g}, V_k = {v:g}"
        printed.append(Check(what, measured, interval * c / (c + 2.0 * v), 1e-10))
        right = interval * c / (c + 2.0 * v + interval * s)
        corrected.append(Check(what, measured, right, 1e-10))
    return Finding(
        tuple(printed),
        tuple(corrected),
        "tan xi = xi cos t_k / (cos t_k + 2 V_k + xi sin t_k)",
        remark="The two agree only where sin t_k = 0 or cos t_k = 0.",
    )


def _coefficient() -> Finding:
    printed, corrected = [], []
    for t, v in STATES:
        interval = half_harmonic_impact(t, v)[0] - t
        s, c = numerics.sin(t), numerics.cos(t)
        what = f"tan(xi) / xi for t_k = {t:g}, V_k = {v:g}"
        measured = numerics.tan(interval) / interval
        printed.append(Check(what, measured, c / (c + 2.0 * v), 1e-10))
        corrected.append(Check(what, measured, c / (c + 2.0 * v + interval * s), 1e-10))
    return Finding(
        tuple(printed),
        tuple(corrected),
        "a_k = cos t_k / (cos t_k + 2 V_k + xi_k sin t_k)",
        remark="Both forms are cos t_k / (2 V_k) + O(V_k^-2), so that a_k is small as stated.",
    )


def _interval() -> Finding:
    a = numerics.cos(PHASE) / (numerics.cos(PHASE) + 2.0 * VELOCITIES)
    intervals = np.array([half_harmonic_impact(PHASE, v)[0] for v in VELOCITIES]) - PHASE
    coefficient = a - numerics.cos(PHASE) / (2.0 * VELOCITIES)
    expansion = intervals + PHASE - half_harmonic_expansion(PHASE, VELOCITIES)[0]
    return Finding(
        (
            _is_of_order("xi_k = pi (1 + a_k)", list(intervals - math.pi * (1.0 + a)), 2.0),
            _is_of_order("a_k = cos t_k / (2 V_k)", list(coefficient), 2.0),
        ),
        remark=(
            "The error of (29) does not reach this order. With the next term, "
            "xi = pi + (pi/2) c/V - (pi^2/4) s c/V^2, the error falls as V^-p with p = "
            f"{_exponent(list(expansion)):.3f}. So intervals tend to pi, but the impact times "
            "tend to multiples of pi plus a phase that the start decides, not to those of Y0."
        ),
    )


def _next_velocity() -> Finding:
    s, c = numerics.sin(PHASE), numerics.cos(PHASE)
    exact = np.array([half_harmonic_impact(PHASE, v)[1] for v in VELOCITIES])
    a = c / (c + 2.0 * VELOCITIES)
    printed = VELOCITIES + 0.5 * math.pi * (s + (math.pi + 2.0 * s) * a)
    corrected = half_harmonic_expansion(PHASE, VELOCITIES)[1]
    return Finding(
        (_is_of_order("(32)", list(exact - printed), 2.0),),
        (_is_of_order("the corrected form", list(exact - corrected), 2.0),),
        "V_{k+1} = V_k + (pi/2) [sin t_k + ((pi/2) cos t_k + 2 sin t_k) a_k] + O(a_k^2)",
    )


def _two_impacts(t: float, v: float) -> float:
    return half_harmonic_impact(*half_harmonic_impact(t, v))[1]


def _second_velocity() -> Finding:
    v = 1e5
    printed, corrected = [], []
    for t in (0.0, 0.7, 2.0, 4.5):
        measured = v * (_two_impacts(t, v) - v)
        s, c = numerics.sin(t), numerics.cos(t)
        what = f"V_k (V_(k+2) - V_k) for t_k = {t:g}, V_k = 1e5"
        as_printed = 0.5 * math.pi * (0.5 * math.pi * c * c + 2.0 * s * c)
        printed.append(Check(what, measured, as_printed, 1e-4))
        right = v * float(half_harmonic_two_impacts(t, v) - v)
        corrected.append(Check(what, measured, right, 1e-4))
    phase = 0.25 * math.pi
    errors = [
        _two_impacts(phase, u) - float(half_harmonic_two_impacts(phase, u)) for u in VELOCITIES
    ]
    order = _is_of_order("the corrected form", errors, 2.0)
    return Finding(
        tuple(printed),
        (*corrected, order),
        "V_{k+2} = V_k + (pi/2) sin(2 t_k) / V_k + O(V_k^-2): no term in cos^2 t_k",
    )


def _mean_growth() -> Finding:
    v = 1e4
    phases = (np.arange(24) + 0.5) * math.pi / 24
    proven = [two_proven_impacts(float(t), v) for t in phases]
    late = [two_proven_impacts(PHASE, float(u)) for u in VELOCITIES]
    means = (
        ("mean over the phase of V_k (V_(k+2) - V_k), of (33) as printed pi^2/8", slice(None)),
        ("mean over 0 < t_k mod pi < pi/2", slice(None, 12)),
        ("mean over pi/2 < t_k mod pi < pi", slice(12, None)),
    )
    gains = np.array([v * (_two_impacts(t, v) - v) for t in phases])
    values = [mean_gain(v, proven[part]) or (float(gains[part].mean()), None) for _, part in means]
    names = [name for name, _ in means]
    (mean, radius), *halves = values
    what = "the phase two impacts on, t_k + 2 pi"
    order = exponent_of_drift(PHASE, VELOCITIES, late)
    if order is None:
        drifts = [
            half_harmonic_impact(*half_harmonic_impact(PHASE, u))[0] - PHASE - 2.0 * math.pi
            for u in VELOCITIES
        ]
        last = _is_of_order(what, drifts, 3.0)
    else:
        last = Check(f"exponent p of the error V^-p of {what}", order[0], 3.0, 0.05, order[1])
    return Finding(
        (Check(names[0], mean, math.pi**2 / 8.0, 1e-3, radius),),
        (
            Check("the same mean, of the corrected (33)", mean, 0.0, 1e-3, radius),
            Check(names[1], halves[0][0], 1.0, 5e-3, halves[0][1]),
            Check(names[2], halves[1][0], -1.0, 5e-3, halves[1][1]),
            last,
        ),
        "dV/dt = sin(2 psi) / (4 V): the phase psi of the impacts stands still and is not averaged "
        "over; velocities grow for 0 < psi < pi/2 and fall for pi/2 < psi < pi",
    )


def _statement(
    number: int,
    claim: str,
    find: Callable[[], Finding],
    formula: str = "",
    certainty: str = "",
    method: str = "",
) -> Statement:
    return Statement(
        id=f"eq{number}",
        reference=f"({number})",
        claim=claim,
        formula=formula,
        method=method or "compared with the exact impact map for large velocities",
        certainty=certainty or "closed form, the order of the error measured",
        find=find,
        theory=THEORY,
        proven=number in PROVEN,
        # The law is one for large velocities; its cases are at some.
        general=number == 34,
    )


STATEMENTS = (
    _statement(
        28,
        "Each flight is A sin t + B cos t - (t/2) cos t.",
        _flight_constants,
        r"x_k(t) = A_k\,\sin t + B_k\,\cos t - \frac{t}{2}\,\cos t",
        "simulation, 1e-12",
        "A and B from one instant of a simulated flight, compared at others",
    ),
    _statement(
        29,
        "The time of flight xi_k solves tan xi_k = xi_k cos t_k / (cos t_k + 2 V_k).",
        _flight_equation,
        r"\tan\xi_k = \frac{\xi_k\,\cos t_k}{\cos t_k + 2V_k}",
        "symbolic",
        "put the exact time of flight into it",
    ),
    _statement(
        30,
        "The factor of xi_k in (29) is a_k = cos t_k / (cos t_k + 2 V_k).",
        _coefficient,
        r"a_k = \frac{\cos t_k}{\cos t_k + 2V_k}",
        "symbolic",
        "tan(xi)/xi of the exact time of flight",
    ),
    _statement(
        31,
        "For large velocities xi_k = pi (1 + a_k) + O(a_k^2) and a_k = cos t_k/(2 V_k) + O(V_k^-2).",
        _interval,
        r"\xi_k = \pi(1 + a_k) + O(a_k^2)",
    ),
    _statement(
        32,
        "The next impact velocity is V_k + (pi/2) [sin t_k + (pi + 2 sin t_k) a_k] + O(a_k^2).",
        _next_velocity,
        r"V_{k+1} = V_k + \frac{\pi}{2}\,[\sin t_k + (\pi + 2\,\sin t_k)\,a_k] + O(a_k^2)",
    ),
    _statement(
        33,
        "Two impacts on, V_k has grown by (pi/2) [(pi/2) cos^2 t_k + sin 2 t_k] / V_k.",
        _second_velocity,
        r"V_{k+2} = V_k + \frac{\pi}{2}\,"
        r"\frac{\frac{\pi}{2}\,\cos^2 t_k + \sin 2t_k}{V_k} + O(V_k^{-2})",
    ),
    _statement(
        34,
        "The numerator of (33) may be replaced by its average a > 0: dV/dt = a / (pi V).",
        _mean_growth,
        r"\frac{dV}{dt} = \frac{a}{\pi V}",
        method="mean over the phase of the exact change of velocity over two impacts",
    ),
    *GROWTH_STATEMENTS,
)
