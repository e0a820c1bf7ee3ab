"""Section 3 of the paper held against evidence: the motions whose impact times are Y_m."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np

from percuss import numerics
from percuss.model.exact import pi_times
from percuss.model.forcing import cosine
from percuss.motion.eigenset_forms import SubsetMotion, subset_critical_velocity, subset_forcing
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims import family_limits, model_statements
from percuss.paper.claims.certain import impacts_at, subset_constant, subset_kept
from percuss.paper.claims.evidence import WALL, condition, furthest, latest, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "paper-family.md"
NUMBERS = tuple(range(2, 10))
PARTS = (0.2, 0.6)


@cache
def _run(m: int, part: float) -> Trajectory:
    """Return six periods (m+1) pi from V0 = part of V*(m), under the force of (11)."""
    t_end = 6.5 * (m + 1) * math.pi
    return simulate(WALL, subset_forcing(m), v0=part * subset_critical_velocity(m), t_end=t_end)


def _free_part(m: int, t: float) -> float:
    """Return (11) without A sin t."""
    return numerics.cos(math.pi / (m + 1)) - numerics.cos((2 * t + math.pi) / (m + 1))


def _kick(m: int) -> float:
    """Return q."""
    return 2 / (m + 1) * numerics.sin(math.pi / (m + 1))


def _worst(formula: Callable[[int, float, Trajectory], float]) -> float:
    """Return the largest error of a formula over m = 2 to 9 and two velocities."""
    cases = [
        (m, part * subset_critical_velocity(m), _run(m, part)) for m in NUMBERS for part in PARTS
    ]
    return max(abs(formula(*case)) for case in cases)


def _indices(m: int, count: int) -> list[int]:
    """Return s_1, s_2, ... by the recursion as printed."""
    found = [0]
    for k in range(count):
        found.append(found[-1] + (m if k % 2 == 0 else 1))
    return found[1:]


def _impact_times() -> Finding:
    checks = tuple(
        subset_kept(
            f"m = {m}, V0 = {part:g} V*: t_k minus pi s_k, all impacts",
            m,
            _run(m, part).v0,
            partial(_first_times, m, part),
        )
        for m in NUMBERS
        for part in PARTS
    )
    return Finding(
        checks,
        remark="The balls are those of the force with its constant, cos(pi/(m+1)), exactly. "
        "The motions exist: simulated under the corrected force of (12).",
    )


def _first_times(m: int, part: float) -> Check:
    """Compare the impacts of six periods."""
    run = _run(m, part)
    return impacts_at(
        f"m = {m}, V0 = {part:g} V*: t_k minus pi s_k, {len(run.impacts)} impacts",
        run,
        math.pi * np.array(_indices(m, 12), np.float64),
        over=subset_constant(m),
    )


def _zeros() -> Finding:
    rows = [
        abs(amplitude * numerics.sin(s * math.pi) + _free_part(m, s * math.pi))
        for m in NUMBERS
        for amplitude in (-1.0, 0.0, 2.0)
        for s in _indices(m, 8)
    ]
    return Finding(
        (near("largest |x(pi s_k)| for m = 2 to 9, A = -1, 0, 2", max(rows), tolerance=1e-12),)
    )


def _force() -> Finding:
    """Simulate under (12) as printed, and under x'' + x of (11)."""
    printed, corrected = [], []
    for m in (2, 3, 4, 5):
        exact = Fraction(-(m - 1) * (m + 3), (m + 1) ** 2)
        factors = Fraction((3 - m) * (m + 5), (m + 1) ** 2), _projected(m)
        printed.append(
            near(f"m = {m}: factor of the cosine in x'' + x", factors[1], float(factors[0]))
        )
        corrected.append(
            near(f"m = {m}: factor of the cosine in x'' + x", factors[1], float(exact))
        )
        for factor, checks in ((factors[0], printed), (exact, corrected)):
            checks.append(near(f"m = {m}: first impact over m pi", _first_impact(m, factor), 1.0))
    return Finding(
        tuple(printed),
        tuple(corrected),
        "the factor is -(m-1)(m+3)/(m+1)^2 = (1-m)(m+3)/(m+1)^2",
        remark="The printed factor, 16/(m+1)^2 - 1, is that of a cosine of frequency 4/(m+1), twice "
        "the one in (11). For even m the first zero m pi does not depend on the factor.",
    )


def _projected(m: int) -> float:
    """Return the cosine's share of x'' + x of (11), with x'' by differences, by projection."""
    h, period = 0.01, (m + 1) * math.pi
    t = period * np.arange(4096) / 4096
    wave = numerics.cos((2 * t + math.pi) / (m + 1))

    def x(shift: float) -> Any:
        return numerics.cos(math.pi / (m + 1)) - numerics.cos((2 * (t + shift) + math.pi) / (m + 1))

    # Differences of order 6: what they leave out is below 1e-12 for these slow waves.
    weights = (-49 / 18, 3 / 2, -3 / 20, 1 / 90)
    second = weights[0] * x(0.0)
    for j in (1, 2, 3):
        second = second + weights[j] * (x(j * h) + x(-j * h))
    return float(2 * ((second / h**2 + x(0.0)) * wave).mean())


def _first_impact(m: int, factor: Fraction) -> float:
    """Return the first impact time over m pi under a force of the form (12)."""
    constant = numerics.cos(math.pi / (m + 1))
    force = cosine(Fraction(2, m + 1), factor, pi_times(1, m + 1), constant)
    end = 4 * (m + 1) * math.pi
    run = simulate(WALL, force, v0=0.3 * subset_critical_velocity(m), t_end=end)
    return latest(run, 0, end) / (m * math.pi)


def _amplitude(m: int, run: Trajectory, t: float) -> float:
    """Return A on the flight around t of a simulated motion."""
    return (float(run(t)[0]) - _free_part(m, t)) / numerics.sin(t)


def _long_amplitude() -> Finding:
    def error(sign: int) -> float:
        def of(m: int, v0: float, run: Trajectory) -> float:
            return _amplitude(m, run, 0.5 * math.pi) - (v0 + sign * _kick(m))

        return _worst(of)

    return Finding(
        (near("A of simulated motions minus (V0 + q), m = 2 to 9", error(1)),),
        (near("A of simulated motions minus (V0 - q), m = 2 to 9", error(-1)),),
        "V0 - q, as (A1) has it",
        remark="The plus is that of the text's extraction, in which signs may be lost.",
    )


def _short_amplitude() -> Finding:
    def error(m: int, v0: float, run: Trajectory) -> float:
        expected = -v0 + _kick(m) * (-1 if m % 2 else 3)
        return _amplitude(m, run, (m + 0.5) * math.pi) - expected

    return Finding((near("A of simulated motions minus the formula, m = 2 to 9", _worst(error)),))


def _next_velocity() -> Finding:
    def error(m: int, v0: float, run: Trajectory) -> float:
        expected = v0 if m % 2 else -v0 + 4 / (m + 1) * numerics.sin(math.pi / (m + 1))
        return float(run.impacts.v_after[1]) - expected

    return Finding((near("V1 of simulated motions minus the formula, m = 2 to 9", _worst(error)),))


def _periods() -> Finding:
    """Count the periods (m+1) pi after which the initial velocity comes back."""
    general = [_repeats(_run(m, part)) for m in NUMBERS for part in PARTS]
    expected = [2 - m % 2 for m in NUMBERS for _ in PARTS]
    halves = [_repeats(_run(m, 0.5)) for m in NUMBERS if m % 2 == 0]
    generic = condition("1 for odd and 2 for even m, V0 = 0.2 and 0.6 V*", general == expected)
    what = "least number of periods (m+1) pi for even m, V0 = V*/2"
    return Finding(
        (generic, *(near(what, count, 2) for count in halves)),
        (generic, *(near(what, count, 1) for count in halves)),
        "for even m and V0 = V*/2 = q, where V1 = V0, the period is (m+1) pi too",
    )


def _repeats(run: Trajectory) -> int:
    after = run.impacts.v_after[1::2]
    return int(np.flatnonzero(np.abs(after - run.v0) < 1e-9)[0]) + 1


def _stability() -> Finding:
    """Vary the initial velocity, and the time of the start."""
    moved = max(furthest(_run(m, part), _run(m, 0.2).impacts.t) for m in NUMBERS for part in PARTS)
    velocity = near("moves of the impact times when V0 changes, m = 2 to 9", moved)
    stray = [_stray(m, 1e-3) for m in (2, 4)]
    checks = tuple(
        condition(f"m = {m}: 2000 periods after a start 1e-3 late on Y_m within 0.1", off < 0.1)
        for m, off in zip((2, 4), stray, strict=True)
    )
    drifts = [near(f"m = {m}: drift of V over that derived", _drift(m), 1, 1e-3) for m in NUMBERS]
    return Finding(
        (velocity, *checks),
        (velocity, condition("m = 2, 4: Y_m is left after that start", min(stray) > 0.1), *drifts),
        "against changes of V0 alone; after a start late by tau, V drifts, for odd m by "
        "-(16/(m+1)^2) cos(pi/(m+1)) tau a period, and for m = 2 and 4 Y_m is left",
    )


def _drift(m: int) -> float:
    """Return how V changes in two periods after a late start, over what is derived."""
    late, q = 1e-6, _kick(m)
    v0 = 0.4 * subset_critical_velocity(m)
    run = simulate(WALL, subset_forcing(m), v0=v0, t0=late, max_impacts=4)
    force = 4 / (m + 1) ** 2 * numerics.cos(math.pi / (m + 1))
    factor = 8.0 if m % 2 else 4.0 * (1.0 + v0 / (2.0 * q - v0))
    return (float(run.impacts.v_after[3]) - v0) / (-factor * force * late)


def _stray(m: int, late: float) -> float:
    """Return how far from the eigenset a motion of Y_m comes that starts late."""
    end = 2000 * (m + 1) * math.pi
    v0 = 0.4 * subset_critical_velocity(m)
    times = simulate(WALL, subset_forcing(m), v0=v0, t0=late, t_end=end).impacts.t / math.pi
    return float(np.abs(times - np.round(times)).max()) * math.pi


def _commensurate() -> Finding:
    periods = [subset_forcing(m).period or math.nan for m in NUMBERS]
    checks: list[Check] = [
        near("period of the force over (m+1) pi", period / ((m + 1) * math.pi), 1.0)
        for m, period in zip(NUMBERS, periods, strict=True)
    ]
    ratio = SubsetMotion(2, 0.5).period / periods[0], SubsetMotion(3, 0.5).period / periods[1]
    checks += [
        near(f"period of the motion over that of the force, m = {m}", ratio[m - 2], 4 - m)
        for m in (2, 3)
    ]
    return Finding(tuple(checks))


_of = partial(Statement, theory=THEORY)

OWN: tuple[Statement, ...] = (
    _of(
        id="eq10",
        reference="(10)",
        claim="There are motions whose impact times are Y_m, with the gaps m pi and pi in turn.",
        formula=r"s_0=0,\ s_{k+1}=s_k+m\ (k\ even),\ s_k+1\ (k\ odd)",
        method="simulation for m = 2 to 9",
        certainty="simulation, 1e-10",
        find=_impact_times,
    ),
    _of(
        id="eq11",
        reference="(11)",
        claim="For every A the function (11) is zero on Y_m.",
        formula=r"x = A\sin t - \cos\frac{2t+\pi}{m+1} + \cos\frac{\pi}{m+1}",
        method="the formula evaluated; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=_zeros,
    ),
    _of(
        id="eq12",
        reference="(12)",
        claim="The functions (11) satisfy x'' + x = f with the force (12).",
        formula=r"f = \frac{(3-m)(m+5)}{(m+1)^2}\cos\frac{2t+\pi}{m+1} + \cos\frac{\pi}{m+1}",
        method="x'' + x of (11); simulation under both forces; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=_force,
    ),
    _of(
        id="eq13-long",
        reference="(13)",
        claim="On the long flight from t = 0 the amplitude is A = V0 + q.",
        formula=r"A = V_0 + \frac{2}{m+1}\sin\frac{\pi}{m+1},\ 0 \leq t \leq m\pi",
        method="amplitudes of simulated flights",
        certainty="closed form, 12 digits",
        proven=True,
        find=_long_amplitude,
    ),
    _of(
        id="eq13-short",
        reference="(13)",
        claim="On the short flight the amplitude is A = -V0 + q (1 + 2 (-1)^m).",
        formula=r"A = -V_0 + \frac{2}{m+1}[1+2(-1)^m]\sin\frac{\pi}{m+1}",
        method="amplitudes of simulated flights",
        certainty="closed form, 12 digits",
        proven=True,
        find=_short_amplitude,
    ),
    _of(
        id="eq14",
        reference="(14)",
        claim="The next long flight begins with V1 = -V0 + 2q for even m, V1 = V0 for odd m.",
        formula=r"V_1 = -V_0 + \frac{4}{m+1}\sin\frac{\pi}{m+1}\ (m\ even),\ V_0\ (m\ odd)",
        method="velocities of simulated motions",
        certainty="closed form, 12 digits",
        proven=True,
        find=_next_velocity,
    ),
    _of(
        id="family-period",
        reference="(14)",
        claim="The motion has the period 2(m+1) pi for even m, (m+1) pi for odd m.",
        method="simulation; for even m also from V0 = V*/2",
        certainty="simulation, 1e-9",
        proven=True,
        find=_periods,
    ),
    _of(
        id="family-commensurate",
        reference="section 3",
        claim="For m = 3 the motion has the period of the force, for m = 2 twice it.",
        method="periods of the closed forms",
        certainty="closed form, 12 digits",
        proven=True,
        find=_commensurate,
    ),
    _of(
        id="subset-stability",
        reference="abstract",
        claim="The eigenset and its subsets are stable with respect to variation of initial "
        "conditions.",
        method="simulation from varied velocities, and of 2000 periods from a late start",
        certainty="simulation",
        find=_stability,
    ),
)

STATEMENTS: tuple[Statement, ...] = (
    *model_statements.STATEMENTS,
    *OWN,
    *family_limits.STATEMENTS,
)
