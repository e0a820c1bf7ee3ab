"""Statements (36)-(40): the half-harmonic force of the other phase, cos t."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.exact import Exact
from percuss.model.forcing import cosine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.half_harmonic import cosine_eigenset_motion
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import impacts_at
from percuss.paper.claims.cosine_growth import GROWTH_STATEMENTS, T_FIGURE
from percuss.paper.models.motions import simulate_all
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]

THEORY = "half-harmonic.md"
# Statements on the closed form of the motion on the eigenset, and on the one from V0 = 0.
PROVEN = ("eq37", "eq38", "eq39", "eq40", "cosine-steady", "cosine-half-pi", "cosine-becomes-sine")


@cache
def _eigenset_run(v0: Exact) -> Trajectory:
    return simulate(impact_oscillator(), cosine(1), v0=v0, t_end=30.0 * math.pi + 1.0)


def _general_solution() -> Finding:
    # From an impact off the eigenset the motion is no multiple of sin t.
    start = 0.3
    run = simulate(impact_oscillator(), cosine(1), t0=start, v0=1.0, max_impacts=1)
    t = start + np.array([0.1, 0.4, 0.7, 0.95]) * run.impacts.intervals[0]
    x = run(t)[0]
    a = x[0] / numerics.sin(t[0]) - 0.5 * t[0]
    printed = float(np.abs(x - (a + 0.5 * t) * numerics.sin(t)).max())
    matrix = np.array([[numerics.sin(u), numerics.cos(u)] for u in t[:2]])
    a, b = numerics.solve_linear(matrix, x[:2] - 0.5 * t[:2] * numerics.sin(t[:2]))
    corrected = float(np.abs(x - (a + 0.5 * t) * numerics.sin(t) - b * numerics.cos(t)).max())
    what = "largest difference on a flight from t_k = 0.3, V_k = 1"
    return Finding(
        (Check(what, printed, 0.0, 1e-12),),
        (Check(what, corrected, 0.0, 1e-12),),
        "x_k = (A_k + t/2) sin t + B_k cos t; B_k = 0 only from impacts on Y0",
        remark="The sign of t/2 is lost in the extraction of the article, and read as plus.",
    )


def _on_the_eigenset() -> Finding:
    checks = []
    t = np.linspace(0.0, 30.0 * math.pi, 997)
    for v0 in (0.1, 1.0, 10.0):
        run = _eigenset_run(v0)
        apart = np.abs(np.array(run(t)) - np.array(cosine_eigenset_motion(t, v0)))
        far = np.abs(t / math.pi - np.round(t / math.pi)) > 1e-6
        what = f"difference of x and v from the formula, V0 = {v0:g}"
        checks.append(Check(what, float(apart[:, far].max()), 0.0, 1e-11))
    return Finding(tuple(checks))


def _alternation() -> Finding:
    checks = []
    for v0 in (0.1, 1.0, 10.0):
        v = np.concatenate([[v0], _eigenset_run(v0).impacts.v_after])
        gains = np.diff(v) - 0.5 * math.pi * (-1.0) ** np.arange(len(v) - 1)
        worst = float(np.abs(gains).max())
        checks.append(Check(f"V_(k+1) - V_k -+ pi/2, V0 = {v0:g}", worst, 0.0, 1e-11))
        twice = float(np.abs(v[2:] - v[:-2]).max())
        checks.append(Check(f"V_(k+2) - V_k, V0 = {v0:g}", twice, 0.0, 1e-11))
    return Finding(tuple(checks))


def _extra_roots() -> Finding:
    # For odd k the factor V_k - t/2 of (40) vanishes at 2 V_k, within a flight for V_k < pi/2.
    checks = []
    for v in (0.3, 1.0, 1.5):
        run = simulate(impact_oscillator(), cosine(1), t0=math.pi, v0=v, max_impacts=1)
        what = f"first flight from (pi, {v:g})"
        checks.append(Check(what, float(run.impacts.intervals[0]), 2.0 * v, 1e-11))
    late = simulate(impact_oscillator(), cosine(1), t0=math.pi, v0=1.6, max_impacts=1)
    checks.append(
        Check("first flight from (pi, 1.6)", float(late.impacts.intervals[0]), math.pi, 1e-11)
    )
    return Finding(
        tuple(checks),
        remark="The velocities start at odd k as (40) forbids, with V_k < pi/2, to show the root.",
    )


def _steady() -> Finding:
    checks = []
    for v0 in (1e-3, 0.1, 1.0, 10.0):
        run = _eigenset_run(v0)
        times = math.pi * np.arange(1, len(run.impacts) + 1, dtype=np.float64)
        checks.append(impacts_at(f"impact times less pi k, V0 = {v0:g}", run, times, 1e-9))
        radius = 0.0 if checks[-1].is_certain else None
        what = f"impacts up to 30 pi + 1, V0 = {v0:g}"
        checks.append(Check(what, float(len(times)), 30.0, radius=radius))
    disturbed = simulate(impact_oscillator(), cosine(1), v0=0.5, t0=-0.001, max_impacts=30_000)
    grown = float(disturbed.impacts.v_after.max())
    return Finding(
        tuple(checks),
        remark=(
            "True for these starts, but unstable: from V0 = 0.5 a start 0.001 earlier grows to a "
            f"velocity of {grown:.2f} in 30,000 impacts, by the law of the resonance; a start "
            "later falls first."
        ),
    )


def _impact_at_half_pi() -> Finding:
    run = simulate(impact_oscillator(), cosine(1), v0=0, t_end=T_FIGURE)
    x, v = run([0.5 * math.pi, 2.0 * math.pi])
    times = run.impacts.t
    odd = (2 * np.arange(len(times)) + 1) * math.pi
    speeds = run.impacts.v_after
    return Finding(
        (Check("x at t = pi/2 for V0 = 0", float(x[0]), 0.0, 1e-10),),
        (
            Check("x at t = pi/2, of (t/2) sin t", float(x[0]), 0.25 * math.pi, 1e-12),
            Check("x at t = 2 pi", float(x[1]), 0.0, 1e-12),
            Check("velocity at t = 2 pi", float(v[1]), 0.0, 1e-12),
            Check(
                "impact times up to 900 less odd multiples of pi", _worst(times - odd), 0.0, 1e-10
            ),
            Check(
                "impact velocities up to 900 less pi/2", _worst(speeds - 0.5 * math.pi), 0, 1e-10
            ),
            Check(
                "touches without speed up to 900",
                float(len(run.grazes)),
                float(int(T_FIGURE / (2 * math.pi))),
            ),
        ),
        "no impact at pi/2, where x = pi/4: the extra root of V_1 - t/2, V_1 = pi/2, is t = pi "
        "after the impact at pi, a double zero at 2 pi that touches the stop without speed; the "
        "motion x = (t/2) sin t, ((2 pi - t)/2) |sin t| has period 2 pi and impacts at odd "
        "multiples of pi",
    )


def _worst(differences: Floats) -> float:
    return float(np.abs(differences).max())


def _becomes_sine() -> Finding:
    x, v = simulate(impact_oscillator(), cosine(1), v0=0, t_end=2.0)(0.5 * math.pi)
    speeds = simulate_all(cosine(1), 0, T_FIGURE)["limit"].impacts.v_after
    growth = float(speeds[-10:].mean() / speeds[:10].mean())
    return Finding(
        (
            Check("x at the new origin, 0 in (27)", float(x), 0.0, 1e-10),
            Check(
                "force 1 after the new origin, sin 1 in (27)", -numerics.sin(1.0), numerics.sin(1.0)
            ),
            Check(
                "velocity late over velocity early, up to t = 900 (sqrt 90 in (27))",
                growth,
                math.sqrt(90.0),
                1.0,
            ),
        ),
        remark=(
            f"At pi/2 the mass is at x = {float(x):.6f} with velocity {float(v):.6f}, off the "
            "stop, and the force turns into -sin t. The origin of time decides nothing: what "
            "decides is the phase of the force at the impacts, and here it is that of no growth."
        ),
    )


def _statement(
    name: str,
    reference: str,
    claim: str,
    find: Callable[[], Finding],
    formula: str = "",
    certainty: str = "simulation, 1e-10, against the closed form",
    method: str = "closed form on the eigenset, and exact runs of the impact oscillator",
) -> Statement:
    return Statement(
        id=name,
        reference=reference,
        claim=claim,
        formula=formula,
        method=method,
        certainty=certainty,
        find=find,
        theory=THEORY,
        proven=name in PROVEN,
    )


STATEMENTS = (
    _statement(
        "eq37",
        "(36), (37)",
        "The general solution on a flight of x'' + x = cos t is (A_k + t/2) sin t.",
        _general_solution,
        r"x_k(t) = \left(A_k + \frac{t}{2}\right)\,\sin t",
        "simulation, 1e-12",
    ),
    _statement(
        "eq38",
        "(38)",
        "From impacts on Y0 the motion is (V_k + (-1)^k t/2) sin t, t from the impact.",
        _on_the_eigenset,
        r"x_k(t) = \left(V_k + (-1)^k\,\frac{t}{2}\right)\,\sin t",
    ),
    _statement(
        "eq39",
        "(39)",
        "On Y0 impact velocities alternate: V_(k+1) = V_k + (-1)^k pi/2, V_(k+2) = V_k.",
        _alternation,
        r"V_{k+1} = V_k + (-1)^k\,\frac{\pi}{2},\ V_{k+2} = V_k",
    ),
    _statement(
        "eq40",
        "(40)",
        "The only extra roots are those of V_k - t/2, for odd k and V_k <= pi/2.",
        _extra_roots,
        r"x_k(t) = \left(V_k - \frac{t}{2}\right)\,\sin t",
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
        certainty="closed form, 10 digits",
    ),
    _statement(
        "cosine-becomes-sine",
        "section 5",
        "For V0 = 0 a shift of the origin by pi/2 turns (36) into (27), with its growth.",
        _becomes_sine,
        certainty="closed form, 10 digits",
    ),
    *GROWTH_STATEMENTS,
)
