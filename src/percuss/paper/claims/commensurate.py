"""Property 2 of the paper held against evidence: resonance on periodic impact times."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial

import numpy as np
import sympy
from sympy import Integer, Rational, cos, pi, sin

from percuss import numerics
from percuss.io.study_text import motion_text
from percuss.model.exact import pi_times
from percuss.model.forcing import Forcing, Harmonic
from percuss.model.harmonic_forces import sine
from percuss.motion.eigenset_forms import SubsetMotion, subset_forcing
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.comparisons import ROUNDING, WALL
from percuss.paper.evidence import Deduction, Measurement, Step, compare
from percuss.paper.proof import argument, identity, positive, theorem
from percuss.paper.statement import Finding, Statement

THEORY = "paper-harmonics.md"
# Of the second force below: small, so that many periods pass before the subset is left.
PUSH = Fraction(1, 100)
# What a run of a hundred periods rounds, with the contact condition read off 1e5 points.
CLIMB_ERROR = 1e-6

u = sympy.Symbol("u", real=True)
V, D, SLOPE, GAP = sympy.symbols("V_k D D' g", real=True)
w, phase = sympy.symbols("omega phi", real=True)
m = sympy.Symbol("m", integer=True)
# Where a gap longer than pi is looked at, in units of pi after its beginning.
LATER = Rational(3, 2)
# What (19) gives for an even omega = n, at other phases too.
GAINED = 2 * w * cos(phase) / (w**2 - 1)


def bounded_off_the_eigenset(inside: Rational = LATER) -> tuple[Step, ...]:
    """Return the steps that a gap other than pi in periodic impact times bounds the velocities.

    Parameters
    ----------
    inside
        Where a longer gap is looked at, in units of pi after its beginning.
    """
    # x at the time u of a flight, and minus its velocity.
    force, v = sympy.Function("f"), sympy.Symbol("v", real=True)
    driven = sympy.Integral(sin(u - v) * force(v), (v, 0, u))
    x, back = V * sin(u) + D, -V * cos(u) - SLOPE
    at = x.subs(u, inside * pi)
    return (
        replace(
            identity(
                "On a flight x = V_k sin u + D(u), D what the force does from rest:",
                driven.diff(u, 2) + driven,
                force(u),
            ),
            formula=r"D = \int_0^u \sin(u - v)\,f(t_k + v)\,dv,\ D'' + D = f",
        ),
        theorem(
            "With |f| <= F and a gap g both |D| and |D'| are at most g F (an integral is at most "
            "the length times the largest value)."
        ),
        identity(
            "A gap g that is no multiple of pi fixes the velocity before it: x(g) = 0 gives "
            "V_k = -D/sin g, at most g F/|sin g|",
            x.subs(u, GAP).subs(V, -D / sin(GAP)),
            Integer(0),
        ),
        identity(
            "In a gap of 2 pi or more x is -V_k + D at u = 3 pi/2, and x >= 0: so V_k <= 3 pi F/2",
            at,
            D - V,
        ),
        identity(
            "From impact to impact the velocity grows by g F at most: V_{k+1} = -V_k cos g - D'",
            back.subs(u, GAP),
            -V * cos(GAP) - SLOPE,
        ),
        argument(
            "Periodic impact times have finitely many gaps in a period. A gap that is not pi bounds "
            "the velocity before it in every period, and with it all others. Where velocities have "
            "no bound, all gaps are pi."
        ),
    )


def _property_2(inside: Rational = LATER) -> Finding:
    """Deduce the property, and follow a motion that grows on a subset until it leaves it."""
    periods, allowed, kept, failed = _climb()
    return Finding(
        (
            Deduction(
                "without a bound on the velocities all gaps are pi",
                bounded_off_the_eigenset(inside),
            ),
            compare(
                "Y_3 with 0.01 sin 2t: velocity gained a period",
                failed - kept,
                8 / 3 * float(PUSH),
                ROUNDING,
                error=1e-12,
            ),
            Measurement(
                "velocity before the last long flight on Y_3, over what that flight allows",
                kept / allowed,
                -math.inf,
                1.0,
                CLIMB_ERROR,
            ),
            Measurement(
                "the same before the first that fails", failed / allowed, 1.0, math.inf, CLIMB_ERROR
            ),
        ),
        remark="The article's step 4 is the proof, with a bound added: on a gap over pi the "
        "velocity "
        "is bounded in every period, by the force alone. Its steps 1 to 3 are not needed, and "
        "step 3 "
        "has a gap: (16) keeps two motions together for one period only, while the point that it "
        "is to contradict is chosen after the motions are. Nor need the periods be the same. "
        f"For a while a resonance can climb on the subset Y_3: here for {periods} periods.",
        study=motion_text(_climbing_run()),
    )


@cache
def _climbing_run() -> Trajectory:
    """Return the motion of Y_3 under its force plus 0.01 sin 2t."""
    own = subset_forcing(3)
    push = Harmonic(PUSH, 2, pi_times(-1, 2))
    force = Forcing((*own.harmonics, push), own.constant, period=pi_times(4))
    return simulate(WALL, force, v0="0.3", max_impacts=1000)


def _climb() -> tuple[int, float, float, float]:
    """Follow Y_3 under its force plus 0.01 sin 2t until the motion leaves it.

    sin 2t has the particular solution -sin(2t)/3, zero at all multiples of pi; on each of the
    two flights of a period, both odd, it adds 4/3 of its amplitude to the velocity.

    Returns
    -------
    tuple
        Periods kept, the velocity allowed by the contact condition of the long flight, and those
        with which the last long flight on Y_3 and the first off it began; NaN if it stays.
    """
    run = _climbing_run()
    off = np.flatnonzero(np.abs(run.impacts.t - SubsetMotion(3, 0).impact_times(1000)) > 1e-6)
    t = np.linspace(1.001 * math.pi, 1.999 * math.pi, 100_001)
    rise = (
        2 * numerics.sin(t / 4) * numerics.sin((t + math.pi) / 4)
        - float(PUSH) * numerics.sin(2 * t) / 3
    )
    slope = 0.5 * numerics.sin(0.25 * math.pi) - 2 * float(PUSH) / 3
    allowed = float((rise / -numerics.sin(t)).min()) + slope
    if not len(off):
        return 500, allowed, math.nan, math.nan
    # Long flights begin after every second impact.
    periods = int(off[0]) // 2
    kept, failed = (float(run.impacts.v_after[2 * k - 1]) for k in (periods - 1, periods))
    return periods, allowed, kept, failed


def which_harmonics(growing: sympy.Expr = GAINED) -> tuple[Step, ...]:
    """Return the steps that sin(omega t + phi) grows on the eigenset for even omega alone.

    Parameters
    ----------
    growing
        The velocity gained at an impact for even omega, as the article has it.
    """

    def off(k: int) -> sympy.Expr:
        return sin((w - 1) * pi * k + phase) - sin(phase)

    half = (w - 1) * pi / 2
    gain = w * (cos(phase) + cos(w * pi + phase)) / (w**2 - 1)
    secular = -u * cos(u + phase) / 2
    slope = secular.diff(u).subs(phase, pi / 2)
    return (
        identity(
            "The response sin(omega t + phi)/(1 - omega^2) keeps the eigenset if its value at m "
            "pi, times (-1)^m, is the same for all m, sin phi:",
            (-1) ** m * sin(w * pi * m + phase),
            sin((w - 1) * pi * m + phase),
        ),
        identity(
            "k = 1 asks for a zero of one of two factors", off(1), 2 * cos(half + phase) * sin(half)
        ),
        identity("k = 2 likewise", off(2), 2 * cos(2 * half + phase) * sin(2 * half)),
        identity(
            "If both cosines are zero, so is the sine: it is zero in any case but omega even, phi = 0 "
            "or pi. So omega is odd, with any phase, or even with one of these.",
            sympy.expand_trig(sin((2 * half + phase) - (half + phase))),
            sympy.expand_trig(
                sin(2 * half + phase) * cos(half + phase)
                - cos(2 * half + phase) * sin(half + phase)
            ),
        ),
        identity("Odd omega gains nothing at an impact", gain.subs(w, 2 * m + 1), Integer(0)),
        identity("even omega gains", gain.subs(w, 2 * m), growing.subs(w, 2 * m)),
        positive(
            "which is positive for phi = 0, omega = 2 p,",
            growing.subs({phase: 0, w: 2 * sympy.Symbol("p", integer=True, positive=True)}),
        ),
        identity(
            "and the negative of it for phi = pi: growth for phi = 0 alone.",
            growing.subs(phase, pi),
            -growing.subs(phase, 0),
        ),
        identity(
            "omega = 1: the response is secular,",
            secular.diff(u, 2) + secular,
            sin(u + phase),
        ),
        identity(
            "at k pi, times (-1)^k, it is -k pi cos(phi)/2, the same for all k for phi = pi/2 "
            "only,",
            (-1) ** m * secular.subs(u, pi * m),
            -pi * m * cos(phase) / 2,
        ),
        identity(
            "when the gains alternate: no growth",
            (-slope.subs(u, pi * m) - slope.subs(u, pi * (m + 1))),
            (-1) ** m * pi / 2,
        ),
    )


def _single_harmonics(growing: sympy.Expr = GAINED) -> Finding:
    """Deduce which single harmonics resonate on periodic impact times."""
    steps = (*bounded_off_the_eigenset(), *which_harmonics(growing))
    run = simulate(WALL, sine(4), v0=0.0, max_impacts=10)
    a_gain = float(growing.subs({w: 4, phase: 0}))
    return Finding(
        (
            Deduction("even omega with phi = 0 at an impact, and no other harmonic", steps),
            compare(
                "n = 4, ten impacts from rest: velocity",
                run.impacts.v_after[-1],
                10 * a_gain,
                ROUNDING,
                error=1e-12,
            ),
        ),
        remark="Of all forces sin(omega t + phi), whether omega is an integer or not.",
        study=motion_text(run),
    )


def _others(growing: sympy.Expr = GAINED) -> Finding:
    """Deduce that a resonance at any other frequency has no periodic impact times."""
    steps = (*bounded_off_the_eigenset(), *which_harmonics(growing))
    return Finding(
        (
            Deduction(
                "unbounded velocities under sin(omega t + phi) on periodic impact times need an "
                "even "
                "omega",
                steps,
            ),
        ),
        remark="The article expects it; here it is proven, for the impact oscillator without "
        "losses "
        "and a force of one harmonic: for sub-harmonics 2/m as for 4/3 or 3/2. A bounded motion at "
        "such a frequency may well be periodic.",
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="property2",
        reference="Property 2",
        claim="If impact times and force share a period and the impact velocity is unbounded, "
        "the impact times are the eigenset.",
        method="bound of the velocity on every other gap; simulation of a resonance on a subset",
        find=_property_2,
    ),
    _of(
        id="only-resonances",
        reference="section 4",
        claim="The only resonances of (17) on periodic impact times commensurate with the force "
        "are those of even n.",
        method="Property 2, and the harmonics whose response keeps the eigenset",
        find=_single_harmonics,
    ),
    _of(
        id="nonperiodic-others",
        reference="abstract, section 4",
        claim="Other resonances than those of (18), (19) have sets of impact times that are not "
        "periodic.",
        method="Property 2 for any periodic set, and the harmonics whose response keeps the "
        "eigenset",
        find=_others,
    ),
)
