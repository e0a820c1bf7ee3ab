"""Figures 5, 6a, 7 and 9 of the paper: do they show what their captions say."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import sympy
from sympy import Rational, sin

from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.comparisons import ROUNDING, WALL, apart
from percuss.paper.claims.harmonic_formulas import (
    BEFORE,
    EQ18,
    EQ19,
    EQ19_GAIN,
    EQ20,
    EQ21,
    A,
    V,
    amplitude_steps,
    bound_steps,
    form_steps,
    gain_steps,
    k,
    n,
    positive_even,
    t,
)
from percuss.paper.claims.harmonic_limits import critical_ball, keeps_steps
from percuss.paper.evidence import Comparison, Deduction, Enclosure, compare
from percuss.paper.formula import Formula
from percuss.paper.proof import identity, sign
from percuss.paper.statement import Finding, Statement

THEORY = "paper-harmonics.md"
# In the frame of figure 5.
FRAME_FLIGHTS = 8
# The velocities of the captions.
FIG_6A, FIG_9 = Rational("0.51"), Rational("0.139")


def _largest(number: int, flights: int, amplitude: Formula, gain: Formula) -> float:
    """Return the largest x of (18), (19) from rest over some flights."""
    size, place, step = amplitude.side(V, n, k), EQ18.side(A, n, t), gain.side(BEFORE, n)
    after = 0.0
    tops = []
    for flight in range(flights):
        at = (flight + np.linspace(0.0, 1.0, 20_001)) * math.pi
        tops.append(float(place(size(after, number, flight), number, at).max()))
        after = step(after, number)
    return max(tops)


def _multi_harmonic(amplitude: Formula = EQ19, gain: Formula = EQ19_GAIN) -> Finding:
    """Deduce that (18), (19) are the trajectories, and compare their tops with simulated ones."""
    steps = (
        *form_steps(),
        *amplitude_steps(amplitude, odd=0),
        *gain_steps(amplitude, gain, odd=0),
        *bound_steps(),
        *positive_even(amplitude),
    )
    numbers = []
    runs = {
        number: simulate(WALL, sine(number), x0=0, v0=0, t_end=FRAME_FLIGHTS * math.pi)
        for number in (2, 4, 6)
    }
    for number, run in runs.items():
        top = float(run(np.linspace(0.0, run.t_end, 160_001))[0].max())
        form = _largest(number, FRAME_FLIGHTS, amplitude, gain)
        what = f"n = {number}: largest x up to 8 pi, simulated, that of (18), (19)"
        numbers.append(compare(what, top, form, 1e-6, error=1e-7))
    return Finding(
        (Deduction("(18), (19) for n = 2, 4, 6", steps), *numbers),
        remark="The article does not say V0. From rest the curve of n = 2 reaches 10, the top "
        "label of the figure's axis. The resonant frequency is 2: n = 4 is twice, n = 6 three "
        "times "
        "that.",
        study=motion_text(runs[2]),
    )


def _steady(v0: Rational = FIG_6A) -> Finding:
    """Deduce that (20) is the trajectory of figure 6a, and compare it with the simulated one."""
    first, second = (
        EQ18.printed.rhs.subs(A, EQ20.printed.rhs.subs(k, late)).subs({n: 3, V: v0})
        for late in (0, 1)
    )
    wave = sin(t) ** 2 / 2
    steps = (
        *form_steps(),
        *amplitude_steps(EQ20, odd=1),
        *gain_steps(EQ20, EQ21, odd=1),
        identity("Even flights are sin t (V0 + sin^2(t)/2)", first, sin(t) * (v0 + wave)),
        identity(
            "odd flights, where sin t < 0, are -sin t (V0 - sin^2(t)/2)",
            second,
            -sin(t) * (v0 - wave),
        ),
        sign("V0 is above 1/2: no extra root", v0 - Rational(1, 2), {}),
    )
    run = simulate(WALL, sine(3), v0=str(float(v0)), t_end=30 * math.pi)
    at = np.linspace(0.0, run.t_end, 30_001)
    flight = np.floor(at / math.pi).astype(int)
    form = EQ18.side(A, n, t)(EQ20.side(V, n, k)(float(v0), 3, flight), 3, at)
    off = compare(
        "x up to 30 pi, simulated minus (20)", apart(run(at)[0], form), 0.0, ROUNDING, error=1e-12
    )
    return Finding(
        (Deduction("(20) for n = 3 from V0 = 0.51", steps), off),
        study=motion_text(run),
    )


def _portraits(above: str = "0.51", below: str = "0.45") -> Finding:
    """Compare the speeds at the wall of both motions: the portraits' ends on the axis x = 0."""
    numbers: list[Comparison] = []
    for v0, low, high in ((above, 1.0 - 1e-9, 1.0 + 1e-9), (below, -math.inf, 0.99)):
        run = simulate(WALL, sine(3), v0=v0, max_impacts=6)
        speeds = certain_run(run)
        what = f"V0 = {v0}: least speed at the wall in six impacts, over V0"
        if speeds is None:
            numbers.append(enclosed(what, None, low, high))
            continue
        after = speeds.impacts.v_after
        at = int(after.mid().argmin())
        radius = float(after.radius().max()) / run.v0 + 1e-15
        numbers.append(Enclosure(what, float(after.mid()[at]) / run.v0, radius, low, high))
    return Finding(
        tuple(numbers),
        remark="Above 1/2 the portrait has one speed at the wall, V0. At V0 = 0.45 it has two, "
        "V0 and "
        "2 V0 sqrt(1 - 2 V0) = 0.285; both are closed curves (record periodicity-fig6b-lost).",
        study=motion_text(run),
    )


def _ninth(v0: Rational = FIG_9) -> Finding:
    """Deduce that the start of figure 9 is above V_max(9)."""
    y = sympy.Symbol("y", nonnegative=True)
    chebyshev = sympy.expand(sympy.chebyshevu(8, sympy.sqrt(y)))
    steps = (
        *keeps_steps(),
        identity(
            "sin 9s/sin s is a polynomial in y = cos^2 s",
            sympy.expand(sympy.expand_trig(sin(9 * t)) / sin(t)).subs(
                sin(t) ** 2, 1 - sympy.cos(t) ** 2
            ),
            chebyshev.subs(y, sympy.cos(t) ** 2),
        ),
        sign(
            "80 (V0 - W) = 80 V0 - 9 + sin 9s/sin s is positive",
            80 * v0 - 9 + sympy.horner(chebyshev),
            {y: (0, 1)},
        ),
    )
    return Finding(
        (
            Deduction("V0 = 0.139 is above V_max(9), so the impact times are the eigenset", steps),
            Enclosure(
                "V_max(9)", critical_ball(9).mid(), critical_ball(9).radius(), -math.inf, float(v0)
            ),
        ),
        study=motion_text(
            simulate(WALL, sine(9), v0=str(float(v0)), t_end=FRAME_FLIGHTS * math.pi)
        ),
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="fig5",
        reference="fig 5",
        claim="The curves for n = 2, 4, 6 are (18), (19).",
        method="(18), (19) as in their records; largest x of simulated motions from rest",
        find=_multi_harmonic,
    ),
    _of(
        id="fig6a",
        reference="fig 6a",
        claim="For n = 3, V0 = 0.51 the trajectory is (20), with impact times on the eigenset.",
        method="(20) on both kinds of flights; simulation to 30 pi",
        find=_steady,
    ),
    _of(
        id="fig7",
        reference="fig 7",
        claim="The phase portraits for V0 = 0.51 and V0 = 0.45 differ.",
        method="speeds at the wall of certified motions",
        find=_portraits,
    ),
    _of(
        id="fig9",
        reference="fig 9",
        claim="For n = 9, V0 = 0.139 the impact times are the eigenset.",
        method="sign of a polynomial; V_max(9) from starts on either side",
        find=_ninth,
    ),
)
