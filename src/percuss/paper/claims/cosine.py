"""Statements (36)-(40) and figs 14, 15: the half-harmonic force of the other phase, cos t."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from percuss.model.exact import Exact
from percuss.model.forcing import cosine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.half_harmonic import cosine_eigenset_motion
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.envelope import power_law
from percuss.paper.claims.half_harmonic_growth import PRINTED_ERROR, Floats, envelope_factor, peaks
from percuss.paper.models.motions import STIFFNESS_BELOW, impact_speeds, oscillators, simulate_all
from percuss.paper.models.runge_kutta import runge_kutta
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]

THEORY = "half-harmonic.md"
T_FIGURE = 900.0
# A difference in time that no figure shows.
VISIBLE = 1e-2


@cache
def _eigenset_run(v0: Exact) -> Trajectory:
    return simulate(impact_oscillator(), cosine(1), v0=v0, t_end=30.0 * math.pi + 1.0)


def _general_solution() -> Finding:
    # From an impact off the eigenset the motion is no multiple of sin t.
    start = 0.3
    run = simulate(impact_oscillator(), cosine(1), t0=start, v0=1.0, max_impacts=1)
    t = start + np.array([0.1, 0.4, 0.7, 0.95]) * run.impacts.intervals[0]
    x = run(t)[0]
    a = x[0] / math.sin(t[0]) - 0.5 * t[0]
    printed = float(np.abs(x - (a + 0.5 * t) * np.sin(t)).max())
    matrix = np.array([[math.sin(u), math.cos(u)] for u in t[:2]])
    a, b = np.linalg.solve(matrix, x[:2] - 0.5 * t[:2] * np.sin(t[:2]))
    corrected = float(np.abs(x - (a + 0.5 * t) * np.sin(t) - b * np.cos(t)).max())
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
        times = run.impacts.t - math.pi * np.arange(1, len(run.impacts) + 1)
        what = f"impact times less pi k, V0 = {v0:g}"
        checks.append(Check(what, float(np.abs(times).max()), 0.0, 1e-9))
        checks.append(Check(f"impacts up to 30 pi, V0 = {v0:g}", float(len(times)), 30.0))
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
            Check("force 1 after the new origin, sin 1 in (27)", -math.sin(1.0), math.sin(1.0)),
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


@cache
def _factors(displacement: bool) -> dict[str, tuple[float, float, float]]:
    """Return the factor of sqrt(t), its standard error and the last value, of each model."""
    found = {}
    for name, run in simulate_all(cosine(1), 0, T_FIGURE).items():
        t, height = _peaks(run, displacement)
        factor, error = envelope_factor(t, height)
        found[name] = (factor, error, float(height[t > T_FIGURE - 100.0].max()))
    return found


def _peaks(run: Trajectory, displacement: bool) -> tuple[Floats, Floats]:
    """Return times and heights of the peaks of x, or times and velocities of the impacts."""
    t, height = peaks(run) if displacement else impact_speeds(run)
    n = min(len(t), len(height))
    return t[:n], height[:n]


def _powers(displacement: bool) -> dict[str, tuple[float, float]]:
    """Return the exponent of the larger of each two peaks, and its standard error."""
    found = {}
    for name, run in simulate_all(cosine(1), 0, T_FIGURE).items():
        t, height = _peaks(run, displacement)
        n = len(t) - len(t) % 2
        higher = height[:n].reshape(-1, 2).argmax(axis=1) + np.arange(0, n, 2)
        found[name] = power_law(t[higher], height[higher])[1:]
    return found


def _growth(displacement: bool, printed: float) -> Finding:
    found = _factors(displacement)
    end = printed * math.sqrt(T_FIGURE)
    what = {"limit": "impact oscillator", "stiff": "w-/w+ = 2e4", "soft": "w-^2/w+^2 = 2e4"}
    checks = [
        Check(
            f"factor of sqrt t through the larger peaks, {what[name]}",
            factor,
            printed,
            PRINTED_ERROR,
        )
        for name, (factor, _, _) in found.items()
    ]
    checks += [
        Check(f"largest for 800 < t < 900, {what[name]}", last, end, 0.05 * end)
        for name, (_, _, last) in found.items()
    ]
    errors = ", ".join(f"{error:.1e} ({what[name]})" for name, (_, error, _) in found.items())
    powers = ", ".join(
        f"{p:.2f} +- {e:.2f} ({what[k]})" for k, (p, e) in _powers(displacement).items()
    )
    late = simulate(impact_oscillator(), cosine(1), t0=0.1, v0=0, t_end=T_FIGURE)
    moved, moved_error = envelope_factor(*_peaks(late, displacement))
    return Finding(
        tuple(checks),
        remark=(
            f"Standard errors of the factors: {errors}; of fitted exponents t^p {powers}. The impact "
            "oscillator does not grow at all, and neither reading of the stiffness gives the printed "
            "growth. The phase of the start decides: started 0.1 later, the impact oscillator has "
            f"the factor {moved:.3f} +- {moved_error:.3f}. That is near the printed one, and chosen "
            "for it among eight starts: it shows what an error in the phase can do, not what did it."
        ),
    )


def _first_apart(below: float, limit: float) -> float:
    """Return when a disturbance of V0 by 1e-15 first moves an impact by more than the limit."""
    name = next(name for name, value in STIFFNESS_BELOW.items() if value == below)
    run = simulate_all(cosine(1), 0, T_FIGURE)[name]
    moved = simulate(oscillators()[name], cosine(1), v0=1e-15, t_end=T_FIGURE)
    t, other = run.crossings.t, moved.crossings.t
    n = min(len(t), len(other))
    apart = np.abs(t[:n] - other[:n]) > limit
    return float(t[:n][apart][0]) if apart.any() else math.inf


def _numerics() -> Finding:
    printed = []
    values = []
    exact = simulate_all(cosine(1), 0, T_FIGURE)["stiff"]
    late = exact.crossings.t > T_FIGURE - 100.0
    reference = float(np.abs(exact.crossings.v[late]).max())
    for tolerance in (1e-2, 1e-3, 1e-5, 1e-8):
        motion = runge_kutta(
            STIFFNESS_BELOW["stiff"], 1.0, 0.0, v0=0.0, t_end=T_FIGURE, tolerance=tolerance
        )
        speed = float(np.abs(motion.v[motion.t > T_FIGURE - 100.0]).max())
        values.append(f"{speed:.2f} ({tolerance:g})")
        what = f"largest velocity, 800 < t < 900, Runge-Kutta to {tolerance:g} a step"
        printed.append(Check(what, speed, reference, 0.05 * reference))
    trusted = {below: _first_apart(below, VISIBLE) for below in STIFFNESS_BELOW.values()}
    said = ", ".join(
        f"{below:g}: " + ("not up to 900" if t == math.inf else f"at t = {t:.0f}")
        for below, t in trusted.items()
    )
    return Finding(
        tuple(printed),
        remark=(
            f"Exactly {reference:.2f}; by Runge-Kutta {', '.join(values)}. At the touch at 2 pi "
            "an error e of the position becomes a velocity sqrt(2 e). None of the four tolerances "
            "gives the printed growth, nor do they come to agree: how figs 14 and 15 came about is "
            "not settled by this. An error of 1e-15 shows as 0.01 in the impact times of the exact bilinear run "
            f"of stiffness {said}."
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
    )


_MODELS = "exact runs of the impact oscillator and of the bilinear one at both readings of 2e4"

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
    _statement(
        "fig14",
        "fig 14",
        "For V0 = 0 the velocity grows as 0.31 sqrt t up to t = 900.",
        lambda: _growth(False, 0.31),
        r"0.31\,\sqrt{t}",
        "simulation and a fit; the limit in closed form",
        _MODELS,
    ),
    _statement(
        "fig15",
        "fig 15",
        "For V0 = 0 the displacement grows as 0.29 sqrt t up to t = 900.",
        lambda: _growth(True, 0.29),
        r"0.29\,\sqrt{t}",
        "simulation and a fit; the limit in closed form",
        _MODELS,
    ),
    _statement(
        "fig14-numerics",
        "figs 14-15",
        "Fourth-order Runge-Kutta with adaptive step and 2^20 points follows this motion.",
        _numerics,
        certainty="simulation",
        method="such a method at four tolerances, against the exact bilinear run",
    ),
)
