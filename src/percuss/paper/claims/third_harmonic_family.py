"""The third harmonic below its critical velocity: impact times that are not the eigenset's.

docs/theory/third-harmonic.md derives what is measured here.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import sympy
from flint import arb
from sympy import Integer, Rational, cos, pi, sin

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified import CertifiedRun, repeats_after
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import Oscillator, bilinear_oscillator
from percuss.model.start import Start
from percuss.motion.impact_times import ImpactTimes, classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run, enclosed, impacts_at
from percuss.paper.claims.comparisons import (
    WALL,
    apart,
)
from percuss.paper.claims.divergence import separation
from percuss.paper.claims.harmonic_formulas import EQ18, EQ20, A, V, k, n, s, t
from percuss.paper.evidence import Comparison, Deduction, Measurement, Step, compare
from percuss.paper.models.runge_kutta import POINTS, SteppedMotion, runge_kutta
from percuss.paper.proof import identity, sign, theorem
from percuss.paper.statement import Finding, Statement
from percuss.studies.axes import Span
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.study import Study, study_text

V0 = "0.45"
T_END = 30.0 * math.pi
# The paper's 2e4 as the ratio of frequencies, and as that of their squares.
STIFFNESSES = {"w-/w+ = 2e4": 4e8, "w-^2/w+^2 = 2e4": 2e4}
LONG = 3000.0 * math.pi
# How far from an end of a range two starts are that are proven to be in it and not.
NEARBY = 1e-10
# Starts between 0 and the critical velocity 1/2 whose impact times are classified.
N_STARTS = 100
START = Fraction(V0)
HALF = Rational(1, 2)
s1 = sympy.Symbol("s_1", real=True)
# The second flight, and V0 by its early zero s1.
FLIGHT = sin(s) * (V - sin(s) ** 2 / 2)
VALUE = sin(s1) ** 2 / 2


def _exact(v0: Fraction) -> Rational:
    return Rational(v0.numerator, v0.denominator)


@cache
def long_run() -> Trajectory:
    """Return the motion of figure 6b in the limit, a hundred times as long."""
    return simulate(WALL, sine(3), v0=V0, t_end=LONG)


@cache
def bilinear_run(stiffness_below: float, t_end: float = T_END) -> Trajectory:
    """Return the same motion with a finite stiffness."""
    osc = bilinear_oscillator(stiffness_below=stiffness_below)
    return simulate(osc, sine(3), v0=V0, t_end=t_end)


@cache
def stepped(stiffness_below: float, tolerance: float) -> SteppedMotion:
    """Return the same motion by the paper's method."""
    return runge_kutta(
        stiffness_below, 3.0, -0.5 * math.pi, v0=float(V0), t_end=T_END, tolerance=tolerance
    )


def impact_times(v0: float, periods: int) -> Floats:
    """Return the impact times in closed form, six in each 4 pi.

    Examples
    --------
    >>> (impact_times(0.45, 1) / math.pi).round(4)
    array([1.    , 1.3976, 2.3976, 2.6024, 3.6024, 4.    ])
    """
    short = numerics.atan2(math.sqrt(2.0 * v0), math.sqrt(1.0 - 2.0 * v0))
    pattern = np.array([0.0, short, math.pi + short, 2 * math.pi - short, 3 * math.pi - short])
    pattern = np.append(math.pi + pattern, 4 * math.pi)
    return np.asarray(
        (4 * math.pi * np.arange(periods)[:, np.newaxis] + pattern).reshape(-1), dtype=np.float64
    )


def _flight_steps() -> tuple[Step, ...]:
    """Return the steps to the second impact from V0 < 1/2, which is not at 2 pi."""
    second = EQ18.printed.rhs.subs(A, EQ20.printed.rhs).subs({n: 3, k: 1}).subs(t, s + pi)
    return (
        identity("With s = t - pi the second flight of (20) is", second, FLIGHT),
        identity(
            "It is zero at s1 with sin^2 s1 = 2 V0,", FLIGHT.subs(s, s1).subs(V, VALUE), Integer(0)
        ),
        identity(
            "which is hit with the speed V1 = 2 V0 cos s1",
            -FLIGHT.diff(s).subs(s, s1).subs(V, VALUE),
            2 * VALUE * cos(s1),
        ),
    )


def _farthest_from_turns(proven: CertifiedRun) -> arb:
    largest = arb(0)
    for time in proven.impacts.t.arbs:
        largest = largest.max(abs(time - round(float(time / arb.pi())) * arb.pi()))
    return largest


def _other_times(v0: Fraction = START) -> Finding:
    """Deduce the second impact, and measure how far the impacts are from multiples of pi."""
    start = str(float(v0))
    run = simulate(WALL, sine(3), v0=start, max_impacts=42)
    proven = certain_run(run)
    off = None if proven is None else _farthest_from_turns(proven)
    steps = (
        *_flight_steps(),
        sign("V0 is below 1/2, so that s1 lies between 0 and pi/2", HALF - _exact(v0), {}),
    )
    return Finding(
        (
            Deduction("an impact at pi + arcsin sqrt(2 V0)", steps),
            enclosed("distance of the impacts from multiples of pi, farthest", off, 0.1, 1.6),
            impacts_at(
                "t_k minus the closed form", run, impact_times(0.45, 7), start=Start(0, start)
            ),
        ),
        remark="The text of the article says Fig. 6b of both velocities, 0.51 and 0.45; they are "
        "the "
        "two parts of its figure 6.",
        study=motion_text(run),
    )


def critical_velocities() -> tuple[float, float]:
    """Return between which velocities there are six impacts in 4 pi.

    Examples
    --------
    >>> low, high = critical_velocities()
    >>> round(low, 6), round(high, 6)
    (0.135723, 0.489277)
    """
    return (5.0 - 2.0 * math.sqrt(2.0)) / 16.0, (5.0 + 2.0 * math.sqrt(2.0)) / 16.0


def monodromy() -> Floats:
    """Return the change of (x, v) at t = pi/2 + 4 pi with that at t = pi/2, by differences."""
    start, step = 0.5 * math.pi, 1e-4
    x0, v0 = (float(value) for value in long_run()(start))
    columns = []
    for dx, dv in ((step, 0.0), (0.0, step)):
        ends = []
        for side in (1.0, -1.0):
            run = simulate(
                WALL,
                sine(3),
                x0=x0 + side * dx,
                v0=v0 + side * dv,
                t0=start,
                t_end=start + 4.0 * math.pi,
            )
            ends.append(np.array(run(run.t_end)))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.stack(columns, axis=1)


def _period_steps(v0: Fraction) -> tuple[Step, ...]:
    """Return the steps that the motion from V0 has six impacts in 4 pi, and repeats."""
    speed = 2 * VALUE * cos(s1)
    reflected = FLIGHT.subs(V, VALUE) + 2 * speed * sin(s - s1)
    a, b = sympy.symbols("a b", real=True)
    h = a * sin(t) + b * cos(t) - sin(3 * t) / 8
    c = sympy.sqrt(1 - 2 * _exact(v0))
    return (
        *_flight_steps(),
        identity(
            "The flight that is reflected there is a product,",
            reflected,
            sin(s - s1) * (2 * speed - sin(s) * sin(s + s1) / 2),
        ),
        identity(
            "with",
            sin(s) * sin(s + s1),
            (cos(s1) - cos(2 * s + s1)) / 2,
        ),
        sign(
            "positive for pi if 2 V1 > (1 + cos s1)/4: so it is here",
            4 * _exact(v0) * c - (1 + c) / 4,
            {},
        ),
        identity("Every solution changes its sign in pi,", h.subs(t, t + pi), -h),
        identity(
            "and the second flight is symmetric about its middle", FLIGHT.subs(s, pi - s), FLIGHT
        ),
        identity(
            "So the flights last pi, s1, pi (from pi + s1, ending with the speed V1 along the "
            "continued second flight), pi - 2 s1, pi by the symmetry, and s1, which ends with V0. "
            "Together:",
            pi + s1 + pi + (pi - 2 * s1) + pi + s1,
            4 * pi,
        ),
        Step(
            "The same in ball arithmetic: after six impacts the motion is back",
            "",
            repeats_after(WALL, sine(3), str(float(v0)), 6).holds is True,
            "balls",
        ),
    )


def _period_lost(v0: Fraction = START) -> Finding:
    """Deduce the period of the motion, and see what becomes of motions nearby."""
    kinds = classify_impact_times(long_run())
    off = np.abs(monodromy() - np.eye(2)).max()
    apart_by = separation(WALL, sine(3), float(v0), 1e-9, LONG)
    remark = (
        f"Simulated over {LONG / math.pi:g} pi it has {kinds.n_impacts} impacts in "
        f"{kinds.n_periods} forcing periods and repeats itself to {kinds.deviation:.0e}. Motions "
        "nearby "
        f"have the same period: the derivative over 4 pi is the identity to {off:.0e}. A "
        f"difference of 1e-9 at the start grows at most {apart_by.max():.1f} times, so what figure "
        "6b shows of irregularity is none of the limit w- -> infinity. The article says this of no "
        "figure by name: it calls the motion of V0 = 0.51 the one with periodic impact times, that "
        "of 0.45 the other, and lets impact times lose periodicity outside the range of the first."
    )
    period = Deduction("impact times with the period 4 pi", _period_steps(v0), "differs")
    return Finding(
        (period,),
        instead="the motion has the period 4 pi, six periods of the force with six impacts",
        remark=remark,
        study=motion_text(long_run()),
    )


def _start(k: int) -> float:
    """Return the k-th of the equidistant velocities below 1/2."""
    return (k + 0.5) / (2 * N_STARTS)


@cache
def kinds_of_starts() -> tuple[ImpactTimes, ...]:
    """Classify the impact times from equidistant velocities below 1/2."""
    return tuple(
        classify_impact_times(simulate(WALL, sine(3), v0=_start(k), t_end=1000.0 * math.pi))
        for k in range(N_STARTS)
    )


def _diagram_of_starts() -> Study:
    """Return the study of the same starts: where each motion is once a period of the force."""
    starts = Span(_start(0), _start(N_STARTS - 1), N_STARTS)
    return Study(WALL, sine(3), Diagram(over={"start.v0": starts}, follow=(), transient=0))


def _periodic_starts() -> Comparison:
    """Return how many of the starts are proven to have a period: none, says the article."""
    kinds = kinds_of_starts()
    what = f"starts of {N_STARTS} between 0 and 1/2 that are proven to have a period"
    proven = sum(
        one.kind == "periodic"
        and repeats_after(WALL, sine(3), _start(k), int(one.n_impacts)).holds is True
        for k, one in enumerate(kinds)
    )
    return compare(what, float(proven), 0.0, 0.0, 0.0)


def _end(what: str, value: float, way: float) -> Comparison:
    """Return the check that the six impacts begin, or end, at a velocity: within 1e-10."""
    inside, outside = (
        repeats_after(WALL, sine(3), value + side * way * NEARBY, 6).holds for side in (1, -1)
    )
    is_there = inside is True and outside is False
    return compare(what, value if is_there else math.nan, value, 1e-9, 1.01 * NEARBY)


def _identity() -> Deduction:
    """Return the deduction that motions next to that from V0 have its period."""
    return Deduction(
        "all motions near that from V0 = 0.45 have the period 4 pi",
        (
            *_period_steps(START),
            theorem(
                "Simple zeros move smoothly with the start, and flights that do not graze do not "
                "graze nearby (implicit function theorem: Krantz & Parks 2002, theorem 2.3.5): the "
                "same steps hold there."
            ),
        ),
    )


def _outside_the_range(ends: tuple[float, float] | None = None) -> Finding:
    """Count the starts below 1/2 without a period, and find where the six impacts end."""
    kinds = kinds_of_starts()
    periodic = sum(one.kind == "periodic" for one in kinds)
    six = sum((one.n_impacts, one.n_periods) == (6, 6) for one in kinds)
    low, high = critical_velocities() if ends is None else ends
    patterns = sorted({(one.n_impacts, one.n_periods) for one in kinds if one.kind == "periodic"})
    return Finding(
        (_periodic_starts(),),
        corrected=(
            _end("V0 where six impacts in 4 pi begin", low, 1.0),
            _end("V0 where six impacts in 4 pi end", high, -1.0),
            _identity(),
        ),
        correction=(
            "the impact times change, but stay periodic for (5 - 2 sqrt 2)/16 < V0 < (5 + 2 sqrt "
            "2)/16, most of the range, with six impacts in 4 pi; elsewhere longer periods occur"
        ),
        remark=(
            f"Of {N_STARTS} starts {periodic} are proven to be periodic, {six} with six impacts in "
            "six periods of the force, others with (impacts, periods) = "
            f"{', '.join(map(str, patterns[1:]))}. Whether the other {N_STARTS - periodic} have a "
            "longer period or none is not known. That all velocities between the two ends have six "
            "impacts is derived."
        ),
        study=study_text(_diagram_of_starts()),
    )


def speed_errors(motion: SteppedMotion) -> float:
    """Return the largest relative change of the speed from an entry into x < 0 to the exit."""
    below = motion.x < 0.0
    entries = np.flatnonzero(below[1:] & ~below[:-1])
    exits = np.flatnonzero(~below[1:] & below[:-1]) + 1
    n = min(len(entries), len(exits))
    before, after = np.abs(motion.v[entries[:n]]), np.abs(motion.v[exits[:n]])
    return float(np.abs(after / before - 1.0).max())


def least_change(times: Floats) -> float:
    """Return how periodic instants are: the least range of the time that j of them take, over j.

    Examples
    --------
    >>> least_change(np.array([0.0, 1.0, 3.0, 4.0, 6.0, 7.0]))
    0.0
    """
    most = len(times) // 2
    return min(float(np.ptp(times[j:] - times[:-j])) for j in range(1, most + 1))


def _finite_stiffness(allowed: float = 1e-6) -> Finding:
    """Classify the impact times of the bilinear oscillator, and follow a motion beside it."""
    checks, remarks = [], []
    t = np.linspace(0.0, T_END, 20_001)
    for name, below in STIFFNESSES.items():
        run = bilinear_run(below)
        if certain_run(run) is None:
            return Finding((), undecided=f"the run at {name} is not proven up to 30 pi")
        for t_end in (T_END, LONG):
            crossings = bilinear_run(below, t_end).crossings
            least = least_change(crossings.t[crossings.direction == "in"])
            what = f"{name}, {t_end / math.pi:g} pi: least change of the time that j entries take"
            checks.append(Measurement(what, least, allowed, math.inf, 1e-9))
        osc: Oscillator = run.oscillator
        growth = separation(osc, sine(3), float(V0), 1e-9, LONG).max()
        off = apart(run(t)[0], long_run()(t)[0])
        entries = run.crossings.direction == "in"
        speeds = np.abs(run.crossings.v[entries])
        remarks.append(
            f"{name}: x differs from the limit by up to {off:.2g}; the entry speeds of each sixth "
            f"impact go from {speeds[0]:.5f} to {speeds[36]:.5f}; 1e-9 at the start grows at most "
            f"{growth:.0f} times up to {LONG / math.pi:g} pi"
        )
    steps = math.pi / 2e4 / (T_END / POINTS)
    plain = speed_errors(stepped(4e8, 0.0))
    fine = speed_errors(stepped(4e8, 1e-9))
    remark = (
        "; ".join(remarks)
        + ". So this is a slow drift through the family of periodic motions, since "
        "each contact takes the time pi/w-, and no chaos. Runge-Kutta steps of the article's length "
        f"(2^20 to 30 pi) at w-/w+ = 2e4, {steps:.2f} to a contact, change the speed at a "
        "contact by "
        f"up to {plain:.0%}, with an error test that shortens them by {fine:.0e}: without one they "
        "make an irregular motion that belongs to neither equation. The article names a method with "
        "an adaptive step, and no tolerance."
    )
    return Finding(
        tuple(checks),
        remark=remark,
        study=motion_text(run),
    )


STATEMENTS = (
    Statement(
        id="periodicity-fig6b-times",
        reference="fig 6b",
        claim="Under sin 3t a start with V0 = 0.45 leads to impact times that are not the "
        "eigenset's.",
        method="closed form of the second impact; exact motion",
        find=_other_times,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig6b-lost",
        reference="sections 4, 6, fig 6b",
        claim="At V0 = 0.45, outside the range of the eigenset, the impact times are not periodic.",
        method="the motion flight by flight in closed form; motions beside it",
        find=_period_lost,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-outside-range",
        reference="section 6",
        claim="Outside the range of initial velocities with impact times on the eigenset, for n "
        "= 3 "
        "below V0 = 1/2, the impact times lose periodicity.",
        method="100 starts; proofs on both sides of each end of the family, in closed form",
        find=_outside_the_range,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig6b-bilinear",
        reference="fig 6b, section 4",
        claim="The bilinear oscillator that the article computes in place of the impact oscillator "
        "has "
        "impact times without a period at V0 = 0.45.",
        method="exact bilinear motion at both readings of the stiffness ratio; Runge-Kutta",
        find=_finite_stiffness,
        theory="third-harmonic.md",
    ),
)
