"""Statements of the paper on sets of impact times: 6. (b) to (e) of the discussion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from flint import arb

from percuss import numerics
from percuss.certified import Ball, CertifiedRun
from percuss.io.study_text import motion_text
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import cosine, sine
from percuss.motion.eigenset import eigenset
from percuss.motion.eigenset_forms import SubsetMotion, subset_forcing
from percuss.motion.growth import growth
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import (
    certain_run,
    enclosed,
    impacts_at,
    subset_constant,
)
from percuss.paper.claims.comparisons import ROUNDING, WALL, apart
from percuss.paper.claims.model_statements import shared_times
from percuss.paper.evidence import Enclosure, compare, counted
from percuss.paper.statement import Finding, Statement

# Forces sin(w t), and starts, among which resonances on periodic impact times are looked for.
FREQUENCIES = sorted({Fraction(p, q) for q in (1, 2, 3) for p in range(1, 6 * q + 3)})
STARTS = ("0.3", "1.1", "2.3")
SCAN_END = 2000.0 * math.pi
PERIODIC = ("eigenset", "eigenset_subset", "periodic")
# An eigenset of a resonance shows its linear growth as an exponent near 1; steady motions have 0.
RESONANT = 0.5
# Of a flight whose times tell its velocity.
LEAST_SINE = 1e-3
# At half the resonant frequency.
HALF_SINE, HALF_COSINE = sine(1), cosine(1)
SHARED_END = 40.5 * math.pi
PHASES = tuple((k + 0.5) * 2.0 * math.pi / 24 for k in range(24))


def _is_resonance(run: Trajectory) -> bool:
    law = growth(run)
    return law.kind == "grows" and law.exponent > RESONANT


def _scanned(omega: Exact, v0: str) -> Trajectory:
    return simulate(WALL, sine(omega), v0=v0, t_end=SCAN_END)


def _only_on_the_eigenset(resonant: Sequence[str] = ("2", "4", "6", "8")) -> Finding:
    """Classify the motions of a scan, and compute velocities from the times alone."""
    on: list[str] = []
    off: list[str] = []
    n_periodic = 0
    for omega in FREQUENCIES:
        for v0 in STARTS:
            run = _scanned(omega, v0)
            kinds = classify_impact_times(run)
            # Only sets that share a period with the force are spoken of.
            if kinds.kind not in PERIODIC or kinds.n_periods == 0:
                continue
            n_periodic += 1
            if _is_resonance(run):
                (on if kinds.kind == "eigenset" else off).append(f"{omega}")
    worst = max(_velocity_error(v0) for v0 in ("0.2", "0.3", "0.45"))
    return Finding(
        (
            counted("resonances on commensurate periodic times off the eigenset", len(off), 0),
            counted(
                "frequencies that resonate on the eigenset and are not among 2, 4, 6, 8, or the "
                "reverse",
                len(set(on) ^ set(resonant)),
                0,
            ),
            compare(
                "V from the times of its flight, minus V",
                worst,
                0.0,
                ROUNDING,
                # The division by sin, above 1e-3, enlarges the rounding of times up to 200.
                error=float(np.spacing(200.0)) / LEAST_SINE,
            ),
        ),
        remark=(
            f"Of {len(FREQUENCIES) * len(STARTS)} motions {n_periodic} have such times, {len(on)} of "
            "them are resonances. A flight that does not last a multiple of pi fixes its velocity by "
            "its two times, so on a periodic set the velocity is periodic as well; one that lasts "
            "2 pi or more would enter the wall at high velocity."
        ),
        study=motion_text(_scanned(resonant[0], STARTS[0])),
    )


def _velocity_error(v0: str) -> float:
    """Compare the velocities of short flights under sin 3t with what x = 0 at both ends demands."""
    run = simulate(WALL, sine(3), v0=v0, t_end=200.0)
    t0, t1 = run.impacts.t[:-1], run.impacts.t[1:]
    flight = run.impacts.intervals[1:]
    short = np.abs(numerics.sin(flight)) > LEAST_SINE
    p0, p1, slope = (
        -numerics.sin(3 * t0) / 8,
        -numerics.sin(3 * t1) / 8,
        -3 * numerics.cos(3 * t0) / 8,
    )
    v = slope + (p0 * numerics.cos(flight) - p1) / numerics.sin(flight)
    return apart(v[short], run.impacts.v_after[:-1][short])


def _moves(
    force: Forcing, one: str, other: str, over: Mapping[str, Ball] | None = None
) -> arb | None:
    """Return the largest move of the impact times from one start to another, up to t = 40.5 pi."""
    runs = [simulate(WALL, force, v0=v0, t_end=SHARED_END) for v0 in (one, other)]
    slow, fast = (certain_run(run, over=over) for run in runs)
    if slow is None or fast is None:
        return None
    if len(slow.impacts) != len(fast.impacts):
        return arb("inf")
    return _furthest(slow, fast)


def _furthest(one: CertifiedRun, other: CertifiedRun) -> arb:
    largest = arb(0)
    for first, second in zip(one.impacts.t.arbs, other.impacts.t.arbs, strict=True):
        largest = largest.max(abs(first - second))
    return largest


def _shared(m: int = 3) -> tuple[Enclosure, ...]:
    """Return how impact times move where different velocities should share them."""
    on_eigenset = [(2, "0.2", "0.7"), (3, "0.6", "0.7")]
    checks = [
        (f"eigenset: sin {n}t, V0 = {one} and {other}", _moves(sine(n), one, other))
        for n, one, other in on_eigenset
    ]
    checks += [
        (f"Y_{k}, V0 = 0.2 and 0.7", _moves(subset_forcing(k), "0.2", "0.7", subset_constant(k)))
        for k in (2, m)
    ]
    return tuple(enclosed(what, gap, -ROUNDING, ROUNDING) for what, gap in checks)


def _three_impacts(force: Forcing, v0: float) -> Trajectory:
    return simulate(WALL, force, v0=v0, max_impacts=3)


def _moved(force: Forcing, v0: float) -> arb | None:
    """Return by how much 3 impacts move with the initial velocity, over its change."""
    runs = [_three_impacts(force, v) for v in (v0, v0 + 1e-6)]
    one, other = (certain_run(run) for run in runs)
    if one is None or other is None:
        return None
    # The velocities are these doubles.
    return _furthest(one, other) / (arb(runs[1].v0) - arb(runs[0].v0))


ELSEWHERE = ((sine(3), 0.45), (sine(3), 0.2), (sine(1), 1.0), (sine("2.5"), 1.0))


def _subsets_too(starts: Sequence[tuple[Forcing, float]] = ELSEWHERE) -> Finding:
    """Compare impact times from two velocities, on the eigenset, on subsets, and elsewhere."""
    moved = [_moved(force, v0) for force, v0 in starts]
    return Finding(
        (
            shared_times(),
            *_shared(),
            *(
                enclosed(f"elsewhere, motion {k}: move over dV", by, 0.01, math.inf)
                for k, by in enumerate(moved, 1)
            ),
        ),
        remark="The eigenset is counted from the first impact.",
        study=motion_text(_three_impacts(*starts[0])),
    )


def _eigenset_alone(fast: str = "0.7") -> Finding:
    """Find a set that is not the eigenset, has the force's period, and bears many velocities."""
    m = 3
    motion = SubsetMotion(m, 0.5)
    expected = motion.impact_times(30)
    run = simulate(WALL, motion.forcing, v0="0.5", t_end=float(expected[-1]) + 0.5)
    times = impacts_at(
        "impact times of Y_3, gaps of 3 pi and pi, computed minus (10)",
        run,
        expected,
        over=subset_constant(m),
    )
    # A ratio of fractions.
    frequency = motion.forcing.frequency or Fraction(1)
    ratio = 2 / (frequency * (m + 1))
    moves = _moves(motion.forcing, "0.2", fast, subset_constant(m))
    what = f"Y_3, periodic with its force, V0 = 0.2 and {fast}: move of the impact times"
    return Finding(
        (enclosed(what, moves, 1e-6, math.inf),),
        corrected=(
            *_shared(),
            times,
            compare("period of its force over 4 pi", float(ratio), 1.0, 0.0, 0.0),
        ),
        correction="the eigenset and its subsets",
        study=motion_text(run),
    )


def _both_phases(growing: Forcing = HALF_SINE, steady: Forcing = HALF_COSINE) -> Finding:
    """See sin t grow from V0 = 0, and cos t not, from five positive velocities."""
    rising = simulate(WALL, growing, t_end=1e5)
    grown = growth(rising)
    changes = []
    for v0 in ("0.1", "0.5", "1", "2", "5"):
        run = simulate(WALL, steady, v0=v0, t_end=1e5)
        changes.append(apart(run.impacts.v_after[2:], run.impacts.v_after[:-2]))
        changes.append(apart(run.impacts.t, eigenset(WALL, len(run.impacts))))
    return Finding(
        (
            compare(
                "sin t, V0 = 0: exponent of the velocity's growth",
                grown.exponent,
                0.5,
                0.02,
                error=grown.exponent_error,
            ),
            compare(
                "cos t, V0 = 0.1 ... 5: V_{k+2} - V_k, and t_k - k pi",
                max(changes),
                0.0,
                1e-9,
                # 32,000 impacts, the last at 1e5.
                error=8.0 * float(np.spacing(1e5)),
            ),
        ),
        study=motion_text(rising),
    )


def _depends_on_phase(phases: Sequence[float] = PHASES) -> Finding:
    """Start at 24 phases with V0 = 1 and count those from which the velocity grows."""
    laws = [
        growth(simulate(WALL, cosine(1, phase=phase), v0=1, t_end=1e5), since=1e4)
        for phase in phases
    ]
    values = np.array([law.exponent if law.kind == "grows" else 0.0 for law in laws])
    error = max(law.exponent_error for law in laws)
    late = simulate(WALL, cosine(1, phase=0.01), v0=1, t_end=1e5)
    beside = growth(late, since=1e4)
    return Finding(
        (
            counted(
                f"phases of the force without growth, of {len(values)}",
                int((values == 0.0).sum()),
                1,
                math.inf,
            ),
        ),
        corrected=(
            counted(f"phases that grow, of {len(values)}", int((values > 0.0).sum()), len(values)),
            compare("their exponents: least", float(values.min()), 0.5, 0.03, error=error),
            compare("their exponents: greatest", float(values.max()), 0.5, 0.03, error=error),
            compare(
                "exponent at the phase 0.01 beside cos t",
                beside.exponent,
                0.5,
                0.03,
                error=beside.exponent_error,
            ),
        ),
        correction=(
            "only motions that meet the wall exactly where cos t is at an extreme stay bounded; from "
            "all other phases tried the velocity grows as sqrt t"
        ),
        remark="A start at another phase is a start at another time: the force is the same.",
        study=motion_text(late),
    )


STATEMENTS = (
    Statement(
        id="periodicity-resonance-sets",
        reference="section 4, abstract",
        claim="Among periodic sets of impact times commensurate with the force only the eigenset "
        "can support a resonance.",
        method="scan of sin(w t); velocities of flights from their times",
        find=_only_on_the_eigenset,
        theory="paper-harmonics.md",
    ),
    Statement(
        id="periodicity-subsets-too",
        reference="discussion",
        claim="The eigenset and its subsets are the only sets of impact times that different initial "
        "velocities can share.",
        method="Property 1; impact times from two velocities on each kind of set",
        find=_subsets_too,
        theory="paper-family.md",
    ),
    Statement(
        id="periodicity-eigenset-alone",
        reference="conclusion",
        claim="In all cases but the eigenset, periodic impact times commensurate with the force "
        "depend on the initial velocity.",
        method="a counterexample: the subset Y_3 under its force",
        find=_eigenset_alone,
        theory="paper-family.md",
    ),
    Statement(
        id="periodicity-cos-and-sin",
        reference="section 5, (36)",
        claim="At half the resonant frequency the force sin t makes the oscillator grow, and cos t, "
        "for V0 > 0, does not.",
        method="32,000 impacts each",
        find=_both_phases,
        theory="half-harmonic.md",
    ),
    Statement(
        id="periodicity-phase",
        reference="section 5",
        claim="Whether the half-harmonic resonance exists depends on the phase of the force.",
        method="24 phases at V0 = 1",
        find=_depends_on_phase,
        theory="half-harmonic.md",
    ),
)
