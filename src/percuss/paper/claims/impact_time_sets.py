"""What the paper says in words of sets of impact times: 6. (b) to (e) of the discussion."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np

from percuss import numerics
from percuss.certified import keeps_eigenset
from percuss.model.forcing import Forcing, cosine, sine
from percuss.motion.eigenset import eigenset
from percuss.motion.eigenset_forms import SubsetMotion, subset_forcing
from percuss.motion.growth import growth
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import (
    certain_condition,
    certain_run,
    impacts_at,
    subset_constant,
)
from percuss.paper.claims.evidence import ROUNDING, WALL, apart, condition, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


# Forces sin(w t), and starts, among which resonances on periodic impact times are looked for.
FREQUENCIES = sorted({Fraction(p, q) for q in (1, 2, 3) for p in range(1, 6 * q + 3)})
STARTS = ("0.3", "1.1", "2.3")
SCAN_END = 2000.0 * math.pi
PERIODIC = ("eigenset", "eigenset_subset", "periodic")
# An eigenset of a resonance shows its linear growth as an exponent near 1; steady motions have 0.
RESONANT = 0.5
LATE = 1e6
PHASES = 24


def _is_resonance(run: Trajectory) -> bool:
    law = growth(run)
    return law.kind == "grows" and law.exponent > RESONANT


def _only_on_the_eigenset() -> Finding:
    """Classify the motions of a scan, and compute velocities from the times alone."""
    on: list[str] = []
    off: list[str] = []
    n_periodic = 0
    for omega in FREQUENCIES:
        for v0 in STARTS:
            run = simulate(WALL, sine(omega), v0=v0, t_end=SCAN_END)
            found = classify_impact_times(run)
            # Only sets that share a period with the force are spoken of.
            if found.kind not in PERIODIC or found.n_periods == 0:
                continue
            n_periodic += 1
            if _is_resonance(run):
                (on if found.kind == "eigenset" else off).append(f"{omega}")
    worst = max(_velocity_error(v0) for v0 in ("0.2", "0.3", "0.45"))
    return Finding(
        (
            near("resonances on commensurate periodic times off the eigenset", len(off)),
            condition(
                "resonances on the eigenset at w = 2, 4, 6, 8 only", set(on) == {"2", "4", "6", "8"}
            ),
            near("V from the times of its flight, minus V", worst),
        ),
        remark=(
            f"Of {len(FREQUENCIES) * len(STARTS)} motions {n_periodic} have such times, {len(on)} of "
            "them are resonances. A flight that does not last a multiple of pi fixes its velocity by "
            "its two times, so on a periodic set the velocity is periodic as well; one that lasts "
            "2 pi or more would enter the wall at high velocity."
        ),
    )


def _velocity_error(v0: str) -> float:
    """Compare the velocities of short flights under sin 3t with what x = 0 at both ends demands."""
    run = simulate(WALL, sine(3), v0=v0, t_end=200.0)
    t0, t1 = run.impacts.t[:-1], run.impacts.t[1:]
    flight = run.impacts.intervals[1:]
    short = np.abs(numerics.sin(flight)) > 1e-3
    p0, p1, slope = (
        -numerics.sin(3 * t0) / 8,
        -numerics.sin(3 * t1) / 8,
        -3 * numerics.cos(3 * t0) / 8,
    )
    v = slope + (p0 * numerics.cos(flight) - p1) / numerics.sin(flight)
    return apart(v[short], run.impacts.v_after[:-1][short])


@cache
def _half_harmonic() -> Trajectory:
    return simulate(WALL, sine(1), t_end=LATE)


def _subharmonic() -> Finding:
    """Classify the impact times of the half-harmonic, and fit their approach."""
    run = _half_harmonic()
    found = classify_impact_times(run)
    ahead = run.impacts.t - math.pi * np.arange(1, len(run.impacts) + 1)
    # Two neighbours lie on either side of what they approach.
    shift = 0.5 * (ahead[1:] + ahead[:-1])
    return Finding(
        (
            condition(
                "the impact times approach and are not periodic",
                found.kind == "approaching_eigenset",
            ),
            near("p of abs(t_{k+1} - t_k - pi) ~ t^-p", found.rate, 0.5, 0.005),
        ),
        remark=(
            f"Up to t = {LATE:g} the intervals come within {found.deviation:.1e} of pi. The times "
            f"themselves approach a shifted eigenset: t_k - k pi tends to {shift[-1]:.5f}, within "
            f"{abs(shift[-1] - shift[len(shift) // 10]):.0e} since a tenth of the run."
        ),
    )


def _changes(force: Forcing, one: str, other: str, t_end: float) -> float:
    """Return how far apart the impact times of two initial velocities are, infinite if not as many."""
    times = [simulate(WALL, force, v0=v0, t_end=t_end).impacts.t for v0 in (one, other)]
    return apart(*times) if len(times[0]) == len(times[1]) else math.inf


def _on_eigenset(n: int, one: str, other: str, t_end: float) -> Check:
    """Compare the impact times of two velocities under sin(n t): where both keep to the eigenset."""
    what = f"eigenset: sin {n}t, V0 = {one} and {other}"
    if all(keeps_eigenset(WALL, sine(n), v0).holds is True for v0 in (one, other)):
        return Check(what, 0.0, 0.0, ROUNDING, 0.0)
    return near(what, _changes(sine(n), one, other, t_end))


def _on_subset(m: int, one: str, other: str, t_end: float) -> Check:
    """Compare the impact times of two velocities under the force of Y_m."""
    what, force = f"subset Y_{m}, V0 = {one} and {other}", subset_forcing(m)
    runs = [simulate(WALL, force, v0=v0, t_end=t_end) for v0 in (one, other)]
    slow, fast = (certain_run(run, over=subset_constant(m)) for run in runs)
    if slow is None or fast is None or len(runs[0].impacts) != len(runs[1].impacts):
        return near(what, _changes(force, one, other, t_end))
    first, second = slow.impacts.t, fast.impacts.t
    gaps = apart(first.mid(), second.mid())
    radius = float((first.radius() + second.radius()).max()) + 2.0 * np.spacing(t_end)
    return Check(what, gaps, 0.0, ROUNDING, radius)


def _shared() -> tuple[Check, ...]:
    t_end = 40.5 * math.pi
    return (
        _on_eigenset(2, "0.2", "0.7", t_end),
        _on_eigenset(3, "0.6", "0.7", t_end),
        _on_subset(2, "0.2", "0.7", t_end),
        _on_subset(3, "0.2", "0.7", t_end),
    )


def _moved(force: Forcing, v0: float) -> tuple[float, bool]:
    """Return by how much impacts move with the initial velocity, and whether that is certain."""
    small = 1e-6
    runs = [simulate(WALL, force, v0=v, max_impacts=3) for v in (v0, v0 + small)]
    one, other = (certain_run(run) for run in runs)
    if one is None or other is None:
        return apart(runs[0].impacts.t, runs[1].impacts.t) / small, False
    first, second = one.impacts.t, other.impacts.t
    gaps = np.abs(first.mid() - second.mid()) - first.radius() - second.radius() - 1e-14
    # At least; the velocities are these doubles.
    return float(gaps.max()) / (1.001 * small), True


def _subsets_too() -> Finding:
    """Compare impact times from two velocities, on the eigenset, on subsets, and elsewhere."""
    starts = ((sine(3), 0.45), (sine(3), 0.2), (sine(1), 1.0), (sine("2.5"), 1.0))
    moved = [_moved(force, v0) for force, v0 in starts]
    least = min(by for by, _ in moved)
    return Finding(
        (
            *_shared(),
            certain_condition(
                "elsewhere times move by more than 0.01 dV, in four motions",
                least > 0.01,
                least > 0.01 and all(is_certain for _, is_certain in moved),
            ),
        ),
        remark=(
            "The difference of two motions of the same force with the same times is (W - V) sin(t - "
            "t_k) in each flight, so each flight lasts a multiple of pi: shared times are a subset of "
            "the eigenset, counted from the first impact."
        ),
    )


def _eigenset_alone() -> Finding:
    """Find a set that is not the eigenset, has the force's period, and bears many velocities."""
    eigenset, steady, second, third = _shared()
    m = 3
    motion = SubsetMotion(m, 0.5)
    expected = motion.impact_times(30)
    gap = float(np.diff(expected).max()) / math.pi
    run = simulate(WALL, motion.forcing, v0="0.5", t_end=float(expected[-1]) + 0.5)
    times = impacts_at(
        "impact times of Y_3, simulated minus (10)", run, expected, over=subset_constant(m)
    )
    # A ratio of fractions.
    frequency = motion.forcing.frequency or Fraction(1)
    ratio = 2 / (frequency * (m + 1))
    shared = third.is_certain and third.passed and times.is_certain and times.passed
    return Finding(
        (
            certain_condition(
                "the times of a motion with gaps of 3 pi, periodic with the force, change with V0",
                gap > 2.5 and third.measured > 1e-6,
                shared,
            ),
        ),
        corrected=(
            eigenset,
            steady,
            second,
            third,
            times,
            Check("period of its force over 4 pi", float(ratio), 1.0, 0.0, 0.0),
        ),
        correction="the eigenset and its subsets",
    )


def _both_phases() -> Finding:
    """See sin t grow from V0 = 0, and cos t not, from five positive velocities."""
    grown = growth(simulate(WALL, sine(1), t_end=1e5))
    changes = []
    for v0 in ("0.1", "0.5", "1", "2", "5"):
        run = simulate(WALL, cosine(1), v0=v0, t_end=1e5)
        changes.append(apart(run.impacts.v_after[2:], run.impacts.v_after[:-2]))
        changes.append(apart(run.impacts.t, eigenset(WALL, len(run.impacts))))
    return Finding(
        (
            near("sin t, V0 = 0: exponent of the velocity's growth", grown.exponent, 0.5, 0.02),
            near("cos t, V0 = 0.1 ... 5: V_{k+2} - V_k, and t_k - k pi", max(changes), 0.0, 1e-9),
        ),
        remark=f"The exponent is {grown.exponent:.4f} with the error {grown.exponent_error:.4f}.",
    )


def _depends_on_phase() -> Finding:
    """Start at 24 phases with V0 = 1 and count those from which the velocity grows."""
    exponents = []
    for k in range(PHASES):
        run = simulate(WALL, cosine(1, phase=(k + 0.5) * 2.0 * math.pi / PHASES), v0=1, t_end=1e5)
        law = growth(run, since=1e4)
        exponents.append(law.exponent if law.kind == "grows" else 0.0)
    values = np.array(exponents)
    beside = growth(simulate(WALL, cosine(1, phase=0.01), v0=1, t_end=1e5), since=1e4)
    return Finding(
        (condition("some of 24 phases of the force show no growth", bool((values == 0.0).any())),),
        corrected=(
            near("share of 24 phases that grow", float((values > 0.0).mean()), 1.0),
            near("their exponents: least", float(values.min()), 0.5, 0.03),
            near("their exponents: greatest", float(values.max()), 0.5, 0.03),
            near("exponent at the phase 0.01 beside cos t", beside.exponent, 0.5, 0.03),
        ),
        correction=(
            "only motions that meet the wall exactly where cos t is at an extreme stay bounded; from "
            "all other phases tried the velocity grows as sqrt t"
        ),
        remark="A start at another phase is a start at another time: the force is the same.",
    )


STATEMENTS = (
    Statement(
        id="periodicity-resonance-sets",
        reference="section 4, abstract",
        claim="Among periodic sets of impact times commensurate with the force only the eigenset "
        "can support a resonance.",
        method="scan of sin(w t); velocities of flights from their times",
        certainty="simulation, 1e-9",
        find=_only_on_the_eigenset,
    ),
    Statement(
        id="periodicity-subharmonic",
        reference="section 5, conclusion",
        claim="In the first sub-harmonic resonance the impact times are not periodic, but approach "
        "the eigenset.",
        method="318,000 impacts; exponent of the approach by least squares",
        certainty="simulation, 1e-9; exponent statistical",
        find=_subharmonic,
        theory="half-harmonic.md",
    ),
    Statement(
        id="periodicity-subsets-too",
        reference="discussion",
        claim="The eigenset and its subsets are the only sets of impact times that different initial "
        "velocities can share.",
        method="impact times from two velocities on each kind of set",
        certainty="proof in a line; simulation, 1e-10",
        find=_subsets_too,
        theory="paper-family.md",
        proven=True,
    ),
    Statement(
        id="periodicity-eigenset-alone",
        reference="conclusion",
        claim="In all cases but the eigenset, periodic impact times commensurate with the force "
        "depend on the initial velocity.",
        method="a counterexample: the subset Y_3 under its force",
        certainty="simulation, 1e-10",
        find=_eigenset_alone,
        theory="paper-family.md",
        proven=True,
    ),
    Statement(
        id="periodicity-cos-and-sin",
        reference="section 5, (36)",
        claim="At half the resonant frequency the force sin t makes the oscillator grow, and cos t, "
        "for V0 > 0, does not.",
        method="32,000 impacts each",
        certainty="simulation, 1e-9; exponent statistical",
        find=_both_phases,
        theory="half-harmonic.md",
    ),
    Statement(
        id="periodicity-phase",
        reference="section 5",
        claim="Whether the half-harmonic resonance exists depends on the phase of the force.",
        method="24 phases at V0 = 1",
        certainty="statistical",
        find=_depends_on_phase,
        theory="half-harmonic.md",
    ),
)
