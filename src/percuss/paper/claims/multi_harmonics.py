"""Whether the bilinear oscillator resonates at every multiple of its resonant frequency."""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np
import sympy
from flint import arb
from sympy.simplify.fu import TR8

from percuss.io.study_text import motion_text
from percuss.model.exact import as_float
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import bilinear_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.oscillator_statements import resonant_frequency
from percuss.paper.evidence import Comparison, Deduction, Enclosure, Step
from percuss.paper.proof import enclose, identity, sign
from percuss.paper.statement import Finding, Statement

# w-/w+ = 5/3, at which the fourth multiple of W_r = 5/4 is 5 w+ and 3 w-.
RATIO, SILENT = sympy.Rational(5, 3), 4
STIFFNESS = "25/9"
# A flight from x = 0 with the speed V, after the time s, the force then at the phase psi.
S, PSI, V = sympy.symbols("s psi V", real=True)
# They contain [0, pi] and [0, 2 pi].
RANGES = {S: (0, "22/7"), PSI: (0, "44/7")}
# The greatest speeds in two spans of 75 periods are compared; a motion that is periodic
# with the force from rest crosses x = 0 at whole periods.
EDGES = (0.25, 75.25, 225.25, 300.25)


def work_on_free_cycle(n: sympy.Expr, ratio: sympy.Expr) -> sympy.Expr:
    """Return |J_n|: what a force of frequency n W_r can do on a cycle of the free motion.

    J_n is the integral of x' exp(i n W_r t) over a cycle that leaves x = 0 with the speed 1, for
    w+ = 1 and w- = ratio; docs/theory/paper-oscillator.md derives the closed form, which is not
    for n W_r equal to w+ or w-.

    Examples
    --------
    >>> work_on_free_cycle(sympy.Integer(4), sympy.Rational(5, 3))
    0
    """
    rate = n * resonant_frequency(sympy.Integer(1), ratio, sympy.Integer(0))
    reach = 2 * rate * sympy.Abs(sympy.cos(sympy.pi * rate / 2)) * (ratio**2 - 1)
    return reach / sympy.Abs((rate**2 - 1) * (rate**2 - ratio**2))


def _flight(order: int) -> sympy.Expr:
    """Return the flight under cos(n s + psi) from x = 0 with V."""
    n = sympy.Integer(order)
    rise = sympy.cos(PSI) * (sympy.cos(S) - sympy.cos(n * S))
    lag = sympy.sin(PSI) * (sympy.sin(n * S) - n * sympy.sin(S))
    return V * sympy.sin(S) + (rise + lag) / (n**2 - 1)


def _returns(order: int, side: str) -> tuple[Step, ...]:
    """Return the steps that a fast flight on one side lasts pi and comes back as fast."""
    x, n = _flight(order), order
    # sin ns and cos s - cos ns, over sin s.
    wave = sympy.chebyshevu(n - 1, sympy.cos(S))
    rise = 2 * sympy.sin((n + 1) // 2 * S) * sympy.chebyshevu((n - 3) // 2, sympy.cos(S))
    over_sine = V + (sympy.cos(PSI) * rise + sympy.sin(PSI) * (wave - n)) / (n**2 - 1)
    return (
        identity(
            f"{side}, in the time of its own frequency, the force is cos({n}s + psi); the flight x",
            x.diff(S, 2) + x,
            sympy.cos(n * S + PSI),
        ),
        identity("starts from x = 0 with the speed V", (x + x.diff(S)).subs(S, 0), V),
        identity(
            "and after pi it has changed its sign: x = 0 again, and the speed is V again",
            x.subs(S, S + sympy.pi),
            -x,
        ),
        identity("before that it is a positive factor times sin s", over_sine * sympy.sin(S), x),
        sign("positive, at every phase, for V = 1 and so above", over_sine.subs(V, 1), RANGES),
    )


def _no_motion_grows(n: int = SILENT, ratio: sympy.Expr = RATIO) -> Deduction:
    """Prove that at the ratio 5/3 no motion grows under the fourth multiple."""
    rate = n * resonant_frequency(sympy.Integer(1), ratio, sympy.Integer(0))
    t = sympy.Symbol("t", real=True)
    end = sympy.pi * (1 + 1 / ratio)
    # x' of the free motion above and below, as a sum of waves with the force.
    spans = (sympy.cos(t), 0, sympy.pi), (-sympy.cos(ratio * (t - sympy.pi)), sympy.pi, end)
    real, imaginary = (
        sum(
            sympy.integrate(TR8(velocity * wave(rate * t)), (t, low, high))
            for velocity, low, high in spans
        )
        for wave in (sympy.cos, sympy.sin)
    )
    return Deduction(
        "w-^2/w+^2 = 25/9, n = 4: no motion grows",
        (
            identity("the frequency 4 W_r is 5 w+", rate, sympy.Integer(5)),
            identity("and 3 w-", rate, 3 * ratio),
            identity(
                "J_4, real part: the force does no work on the free cycle",
                real,
                sympy.Integer(0),
            ),
            identity("J_4, imaginary part", imaginary, sympy.Integer(0)),
            *_returns(5, "above"),
            *_returns(3, "below"),
            identity(
                "a cycle is four periods of the force, so that every fast motion is periodic; run "
                "backwards it is one of the same kind, so that no slow motion becomes fast",
                rate * end,
                8 * sympy.pi,
            ),
        ),
        concludes="differs",
    )


def _base(k: int | str) -> float:
    """Return W_r."""
    return 2.0 / (1.0 + 1.0 / math.sqrt(as_float(k)))


@cache
def _run(k: int | str, n: float) -> Trajectory:
    """Return 301 periods under the frequency n W_r."""
    osc, base = bilinear_oscillator(stiffness_below=k), _base(k)
    return simulate(osc, cosine(n * base), v0=0.5, t_end=301.0 * (2.0 * math.pi / base))


@cache
def _ratio_of_speeds(k: int | str, n: float) -> tuple[float, float]:
    """Return the greatest speed in periods 225 to 300 over that in 0 to 75, and its radius."""
    period = 2.0 * math.pi / _base(k)
    proven = certain_run(_run(k, n))
    if proven is None:
        return math.nan, math.inf
    speed, periods = np.abs(proven.crossings.v.mid()), proven.crossings.t.mid() / period
    if np.abs(periods[:, None] - np.array(EDGES)).min() < 1e-9:
        # On which side of an edge a crossing lies would be open.
        return math.nan, math.inf
    first, last = (
        float(speed[(periods > a) & (periods <= b)].max()) for a, b in (EDGES[:2], EDGES[2:])
    )
    open_part = float(proven.crossings.v.radius().max())
    # Both have the radius of the velocities, and the quotient is rounded.
    return last / first, 2.0 * open_part * (first + last) / first**2 + 1e-14


def _growth_of_speed(k: int | str, n: float, low: float, high: float) -> Comparison:
    """Compare the greatest speed late in a motion with that in its beginning."""
    what = f"w-^2/w+^2 = {k}, w = {n:g} W_r: greatest speed in periods 225 to 300 over 0 to 75"
    return Enclosure(what, *_ratio_of_speeds(k, n), low, high)


def _work(n: int, ratio: sympy.Expr, name: str) -> Comparison:
    value: arb = enclose(work_on_free_cycle(sympy.Integer(n), ratio), {})
    return enclosed(f"w-^2/w+^2 = {name}: |J_{n}|, over 0.01", value, 0.01, math.inf)


def _multi_harmonics(n: int = SILENT, k: str = STIFFNESS) -> Finding:
    """See the bilinear oscillator grow at n W_r, and not beside it, nor where J_n = 0."""
    # Linear growth makes it 4, less what the start contributes.
    grows = partial(_growth_of_speed, low=3.8, high=4.2)
    stays = partial(_growth_of_speed, low=0.9, high=1.1)
    root = sympy.sqrt(20)
    ratio = sympy.sqrt(sympy.Rational(k))
    return Finding(
        (_no_motion_grows(n, ratio), grows(k, float(n))),
        (
            *(_work(m, root, "20") for m in (1, 2, 3)),
            *(grows(20, float(m)) for m in (1, 2, 3)),
            _work(3, RATIO, STIFFNESS),
            grows(STIFFNESS, 3.0),
            stays(20, 1.01),
            stays(STIFFNESS, float(SILENT)),
        ),
        "except where the force does no work on a cycle of the free motion, J_n = 0: where n W_r "
        "is an odd multiple of w+ and of w-, above 1 of both, as for w-^2/w+^2 = 25/9 and n = 4",
        remark=(
            "J_n is the integral of x' exp(i n W_r t) over a cycle of the free motion. On it "
            "depends to first order whether a fast motion gains speed."
        ),
        study=motion_text(_run(k, float(n))),
    )


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        id="multi-harmonics",
        reference="section 1",
        claim="The bilinear oscillator resonates at n W_r.",
        method="a multiple at which no motion grows, with proof; speeds over 300 periods at "
        "others, and beside them",
        theory="paper-oscillator.md",
        find=_multi_harmonics,
    ),
)
