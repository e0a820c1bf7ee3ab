"""Statements on the growth of the half-harmonic: (27), (35), 0.61 sqrt t, figs 10-12."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.forcing import sine
from percuss.model.oscillator import impact_oscillator
from percuss.motion.growth import fit_power_law, peaks
from percuss.motion.half_harmonic import half_harmonic_growth, half_harmonic_invariant
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, in_ball
from percuss.paper.claims.certain_envelopes import (
    BallColumn,
    factor_of_root,
    proven_peaks,
    proven_speeds,
)
from percuss.paper.models.motions import STIFFNESS_BELOW, impact_speeds, simulate_all
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["GROWTH_STATEMENTS"]


THEORY = "half-harmonic.md"
T_FIGURE = 400.0
LONG = 200_000
# Two digits are printed.
PRINTED = 0.61
PRINTED_ERROR = 0.005


@cache
def impacts(v0: float, count: int = LONG) -> tuple[Floats, Floats, Floats]:
    """Return times, velocities and phases of the impacts under sin t from the stop at t = 0."""
    run = simulate(impact_oscillator(), sine(1), v0=v0, max_impacts=count)
    return run.impacts.t, run.impacts.v_after, 2.0 * math.pi * run.impacts.cycle


@cache
def limit_constant(v0: float) -> tuple[float, float, float]:
    """Return b, the factor of ln t and the limit of the phase, from the last impact of a run."""
    _, v, phase = impacts(v0)
    law = half_harmonic_growth(float(phase[-1]), float(v[-1]))
    return law.constant, law.logarithm, law.phase


def upper_peaks(run: Trajectory) -> tuple[Floats, Floats]:
    """Return times and heights of the highest points of x, one a flight between impacts."""
    t, height = peaks(run, "displacement")
    # Of a soft stop the contacts are flights too, below it.
    above = np.asarray(run(t)[0]) > 0.0
    return t[above], height[above]


def envelope_factor(t: Floats, height: Floats) -> tuple[float, float]:
    """Return the factor of sqrt(t) through the higher of each two peaks, and its standard error."""
    n = len(t) - len(t) % 2
    higher = height[:n].reshape(-1, 2).argmax(axis=1) + np.arange(0, n, 2)
    root, top = np.sqrt(t[higher]), height[higher]
    factor = float((root * top).sum() / (root**2).sum())
    rest = top - factor * root
    return factor, float(np.sqrt((rest**2).sum() / (len(rest) - 1) / (root**2).sum()))


def root_factor(what: str, factor: float, proven: BallColumn | None, printed: float) -> Check:
    """Return the check of a factor of sqrt(t), from balls where the run is proven."""
    if proven is None:
        return Check(what, factor, printed, PRINTED_ERROR)
    return in_ball(what, factor_of_root(*proven), printed, PRINTED_ERROR)


def _resonance() -> Finding:
    _, v, _ = impacts(0.0)
    largest = v[: LONG // 10 * 10].reshape(10, -1).max(axis=1)
    grows = float((np.diff(largest) > 0.0).all())
    return Finding(
        (
            Check(
                "the largest velocity of each tenth of 200,000 impacts exceeds the last", grows, 1
            ),
        ),
        remark=f"The largest impact velocity is {v.max():.6g} at impact 200,000.",
    )


def _square_root() -> Finding:
    t, v, phase = impacts(0.0)
    b, logarithm, psi = limit_constant(0.0)
    smooth = numerics.modulus(v * numerics.phasor(phase) + 0.25j * math.pi)
    late = slice(1000, None)
    exponent, error = numerics.fit_line(numerics.log(t[late]), numerics.log(smooth[late]))
    matrix = np.column_stack([t, numerics.log(t), np.ones_like(t)])[late]
    fitted = numerics.least_squares(matrix, smooth[late] ** 2, 1e-14)
    return Finding(
        (
            # Over this run the logarithm bends the exponent by (ln t)/t: 1e-4.
            Check("exponent of the velocity over time", float(exponent), 0.5, 1e-3),
            Check("factor of t in V^2, fitted, against sin(2 psi)/2", fitted[0], b**2, 1e-8),
            Check("factor of ln t in V^2, fitted, against theory", fitted[1], logarithm, 1e-3),
        ),
        remark=(
            f"Standard error of the exponent {error:.1e}. Exactly, V^2 = "
            "sin(2 psi) t/2 + c ln t + O(1), V freed of its alternation by (pi/4) sin psi; here "
            f"psi = {psi:.12f}, c = {logarithm:.6f}."
        ),
    )


def _universal() -> Finding:
    starts = (0.0, 1.0, 10.0, 100.0)
    b = {v0: limit_constant(v0)[0] for v0 in starts}
    printed = tuple(Check(f"b for V0 = {v0:g}", b[v0], b[0.0], 0.005) for v0 in starts[1:])
    corrected = []
    for v0 in (10.0, 100.0):
        invariant = float(half_harmonic_invariant(0.0, v0))
        closed = math.sqrt(0.5 * math.sqrt(1.0 - invariant**2))
        # The error of the invariant, by its expansion and by four roundings, carried over to b.
        slope = 0.5 * closed * abs(invariant) / (1.0 - invariant**2)
        error = slope * (3.0 * v0**-7 + 4.0 * 2.0**-52)
        corrected.append(Check(f"b for V0 = {v0:g}, closed form", b[v0], closed, error))
    simple = math.sqrt(math.pi / (2.0 * math.sqrt(3.0) * 100.0))
    corrected.append(Check("b for V0 = 100, leading term", b[100.0], simple, 1e-5))
    corrected += [
        Check(f"b for V0 = {v0:g} is at most 1/sqrt 2", float(b[v0] < math.sqrt(0.5)), 1.0)
        for v0 in starts
    ]
    return Finding(
        printed,
        tuple(corrected),
        "b = sqrt(sin(2 psi)/2), where the phase psi depends on the start: "
        "cos 2 psi = (4 V0/pi) arctan(pi/(2 V0)) - 1 for a large V0 at t = 0, any b up to "
        "1/sqrt 2 for others",
        remark="b = " + ", ".join(f"{b[v0]:.10f} (V0 = {v0:g})" for v0 in starts) + ".",
    )


def _figure_11(name: str) -> Finding:
    factors = {
        model: envelope_factor(*upper_peaks(run))
        for model, run in simulate_all(sine(1), 0, T_FIGURE).items()
    }
    factor, error = factors[name]
    run = simulate_all(sine(1), 0, T_FIGURE)[name]
    t, height = upper_peaks(run)
    law = fit_power_law(t[2:], height[2:])
    late = envelope_factor(t[t > 200.0], height[t > 200.0])[0]
    said = ", ".join(f"{model} {value:.4f}" for model, (value, _) in factors.items())
    return Finding(
        (
            root_factor(
                "factor of sqrt t, upper peaks of x, 0 < t < 400",
                factor,
                proven_peaks(run),
                PRINTED,
            ),
        ),
        remark=(
            f"Standard error of the factor {error:.1e}; with a free exponent {law.exponent:.3f} +- "
            f"{law.exponent_error:.3f}. Factors of the three models: {said}. The soft one, 2e4 as the "
            "ratio of stiffnesses, is no resonance: the contact of pi/w- an impact moves the phase "
            f"psi by t/w-, up to t = 400 by {T_FIGURE / math.sqrt(STIFFNESS_BELOW['soft']):.2f}. The "
            "paper fits by eye, and the fit depends on the range: the peaks of 200 < t < 400 alone "
            f"have the factor {late:.4f}."
        ),
    )


def _asymptotic_constant() -> Finding:
    b, _, psi = limit_constant(0.0)
    earlier = []
    _, v, phase = impacts(0.0)
    for k in (999, 9_999, 99_999):
        earlier.append(half_harmonic_growth(float(phase[k]), float(v[k])).constant)
    checks = (
        Check("b from impact 1,000 and from impact 200,000", earlier[0], b, 1e-9),
        Check("b from impact 10,000 and from impact 200,000", earlier[1], b, 1e-12),
        Check("b from impact 100,000 and from impact 200,000", earlier[2], b, 1e-12),
    )
    return Finding(
        (Check("limit of V / sqrt t", b, PRINTED, PRINTED_ERROR),),
        (
            *checks,
            Check("limit of V / sqrt t", b, 0.5 * 2**0.5 * numerics.sin(2 * psi) ** 0.5, 1e-12),
        ),
        f"b = sqrt(sin(2 psi)/2) = {b:.12f} with psi = {psi:.12f}; 0.61 fits only up to "
        "t = 400, where peaks of x still lie above b sqrt t by cos(psi)/2",
    )


def _figure_10() -> Finding:
    runs = simulate_all(sine(1), 0, T_FIGURE)
    t, v = impact_speeds(runs["limit"])
    factor, error = envelope_factor(t, v)
    _, late, phase = impacts(0.0)
    psi = limit_constant(0.0)[2]
    smooth = numerics.modulus(late[-2:] * numerics.phasor(phase[-2:]) + 0.25j * math.pi)
    above = float((late[-2:] - smooth).max())
    return Finding(
        (
            root_factor(
                "factor of sqrt t through the larger velocities",
                factor,
                proven_speeds(runs["limit"]),
                PRINTED,
            ),
        ),
        (
            Check(
                "larger velocity less the mean, late",
                above,
                0.25 * math.pi * numerics.sin(psi),
                1e-3,
            ),
        ),
        "velocities alternate by (pi/4) sin(psi) = "
        f"{0.25 * math.pi * numerics.sin(psi):.4f} about b sqrt t, peaks of x by cos(psi)/2 = "
        f"{0.5 * numerics.cos(psi):.4f}: one factor serves both only for t -> infinity, up to t = 400 "
        f"the velocities need {factor:.3f}",
        remark=f"Standard error of the fitted factor {error:.1e}.",
    )


def _figure_12() -> Finding:
    run = simulate_all(sine(1), 0, T_FIGURE)["limit"]
    v = run.impacts.v_after
    proven = certain_run(run)
    # By how much each is larger than the one two before, at least.
    error = 0.0 if proven is None else float(proven.impacts.v_after.radius().max())
    if proven is not None:
        v = proven.impacts.v_after.mid()
    larger = bool((v[2:] - v[:-2] > 4.0 * error).all())
    radius = 0.0 if proven is not None and larger else None
    what = "each loop is larger than the one two before"
    return Finding(
        (Check(what, float(larger), 1.0, radius=radius),),
        remark=f"All of the {len(v)} loops up to t = 400.",
    )


def _accuracy() -> Finding:
    runs = simulate_all(sine(1), 0, T_FIGURE)
    moved = simulate(impact_oscillator(), sine(1), v0="1e-9", t_end=T_FIGURE)
    times, speeds = impact_speeds(runs["limit"])
    apart = float(np.abs(times - impact_speeds(moved)[0]).max() / 1e-9)
    gap = float(np.abs(impact_speeds(runs["stiff"])[1][-1] / speeds[-1] - 1.0))
    radii: tuple[float | None, float | None] = None, None
    columns = [proven_speeds(run) for run in (runs["limit"], moved, runs["stiff"])]
    limit, other, stiff = columns
    if limit is not None and other is not None and stiff is not None:
        moves = [abs(a - b) * 10**9 for a, b in zip(limit[0], other[0], strict=True)]
        most = max(moves, key=float)
        less = abs(stiff[1][-1] / limit[1][-1] - 1)
        apart, gap = float(most.mid()), float(less.mid())
        widest = max(float(move.rad()) for move in moves)
        radii = 2.0 * widest + 1e-12, float(less.rad()) + 1e-15
    return Finding(
        (
            Check("growth of a disturbance of V0 up to t = 400", apart, 0.0, 100.0, radii[0]),
            Check(
                "relative difference of the last velocity, w-/w+ = 2e4", gap, 0.0, 0.02, radii[1]
            ),
        ),
        remark=f"A disturbance of V0 = 0 by 1e-9 changes impact times {apart:.2g} times as much.",
    )


def _statement(
    name: str,
    reference: str,
    claim: str,
    find: Callable[[], Finding],
    certainty: str,
    formula: str = "",
) -> Statement:
    return Statement(
        id=name,
        reference=reference,
        claim=claim,
        formula=formula,
        method="exact run of the impact oscillator, held against the invariant of its impact map",
        certainty=certainty,
        find=find,
        theory=THEORY,
    )


GROWTH_STATEMENTS = (
    _statement(
        "eq27",
        "(27)",
        "x'' + x = sin t, from rest on the stop, is a resonance: velocities grow without bound.",
        _resonance,
        "simulation of 200,000 impacts; the law of growth is closed form",
        r"x'' + x = \sin t,\ x > 0",
    ),
    _statement(
        "eq35",
        "(35)",
        "Impact velocities grow as b sqrt t.",
        _square_root,
        "closed form, held against 200,000 impacts",
        r"V(t) = b\,\sqrt{t}",
    ),
    _statement(
        "eq35-constant",
        "(35)",
        "b is a constant of the equation: it does not depend on the start.",
        _universal,
        "closed form for large V0, 10 digits from simulation for others",
    ),
    _statement(
        "fig11",
        "fig 11",
        "0.61 sqrt t is the envelope of the displacement of (27) up to t = 400.",
        lambda: _figure_11("limit"),
        "simulation, 1e-9, and a fit",
        r"x \leq 0.61\,\sqrt{t}",
    ),
    _statement(
        "fig11-bilinear",
        "fig 11",
        "0.61 sqrt t is the envelope for the bilinear oscillator with w-/w+ = 2e4 as well.",
        lambda: _figure_11("stiff"),
        "simulation, 1e-9, and a fit",
    ),
    _statement(
        "fig11-asymptotic",
        "fig 11",
        "0.61 is the constant b of the asymptotics (35).",
        _asymptotic_constant,
        "simulation, 12 digits",
        r"b = 0.61",
    ),
    _statement(
        "fig10",
        "fig 10",
        "The same law is the envelope of the velocity.",
        _figure_10,
        "simulation, 1e-9, and a fit",
    ),
    _statement(
        "fig12",
        "fig 12",
        "The phase portrait has a regular character: loops widen one after the other.",
        _figure_12,
        "simulation, 1e-9",
    ),
    _statement(
        "fig10-accuracy",
        "figs 10-11",
        "For these parameters the numerical solution is accurate.",
        _accuracy,
        "simulation, 1e-9",
    ),
)
