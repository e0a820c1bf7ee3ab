"""Appendix A of the paper held against evidence: up to which V0 the impact times are Y_m."""

from __future__ import annotations

import math
from functools import cache, partial

import numpy as np
from flint import arb

from percuss import numerics
from percuss.certified import Ball, keeps_subset
from percuss.motion.eigenset_forms import (
    SubsetMotion,
    contact_time,
    subset_critical_velocity,
    subset_forcing,
)
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain import certain_condition
from percuss.paper.claims.evidence import (
    ROUNDING,
    WALL,
    condition,
    furthest,
    last_unchanged,
    latest,
    near,
    printed_table,
)
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]

THEORY = "paper-family.md"
TABLE_1 = {5: "1.5", 7: "0.984", 9: "0.675", 11: "0.486", 13: "0.365", 15: "0.283"}
ODD = (3, *TABLE_1)
EVEN = (2, 4, 6, 8, 10)
# An impact slower than this may pass for a touch: its depth is below the rounding of x.
SLOWEST_IMPACT = 2e-6
# How far from V* two starts are between which it provably lies.
NEARBY = 1e-11


def _kick(m: int) -> float:
    """Return q."""
    return 2 / (m + 1) * numerics.sin(math.pi / (m + 1))


def _stays(m: int, v0: float) -> bool:
    """Return whether the impacts of two periods are those of Y_m."""
    motion = SubsetMotion(m, 0)
    run = simulate(WALL, motion.forcing, v0=v0, t_end=(2 * (m + 1) + 0.5) * math.pi)
    return len(run.impacts) == 4 and furthest(run, motion.impact_times(4)) < 1e-8


@cache
def _simulated_limit(m: int) -> float:
    """Return by halving up to which V0 simulated impact times are Y_m; V* is not used."""
    return last_unchanged(partial(_stays, m), _kick(m), 4.0)


def _valid() -> Finding:
    parts = (0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99)
    failed = [
        (m, part)
        for m in range(2, 16)
        for part in parts
        if not _stays(m, part * subset_critical_velocity(m))
    ]
    return Finding(
        (near("motions of 98 (m = 2 to 15, seven V0 below V*) that leave Y_m", len(failed)),),
        remark="At V0 = 0 and V0 = V* some impacts have no velocity.",
    )


def _slopes() -> Finding:
    """Compare |u'| with |w'| where flights of even m begin, for motions that stay on Y_m."""
    printed, corrected = [], []
    for m in EVEN:
        q, v0 = _kick(m), 0.6 * subset_critical_velocity(m)
        stays = _stays(m, v0)
        long, short = abs(v0 - q) >= q, abs(3 * q - v0) >= q
        printed += [
            condition(f"m = {m}, long flight: |u'| >= |w'| as x >= 0 is", long == stays),
            condition(f"m = {m}, short flight: |u'| >= |w'| as x >= 0 is", short == stays),
        ]
        for part in (0.6, 1.1):
            v0 = part * subset_critical_velocity(m)
            holds = v0 - q >= -q and 3 * q - v0 >= q
            what = f"m = {m}, V0 = {part:g} V*: u' >= w' at both starts as x >= 0 is"
            corrected.append(condition(what, holds == _stays(m, v0)))
    return Finding(
        tuple(printed),
        tuple(corrected),
        "u' >= w' at the start of each flight, without the absolute values: on the long flight "
        "of even m |u'| <= |w'|",
        remark="The argument of u' and the bars are uncertain in the text's extraction.",
    )


def _even() -> Finding:
    checks = []
    for m in EVEN:
        printed = 4 / (m + 1) * numerics.sin(math.pi / (m + 1))
        what = f"V*({m}) found by simulation"
        checks.append(near(what, _simulated_limit(m), printed, SLOWEST_IMPACT))
    return Finding(
        tuple(checks),
        remark="No impact is added at V*: the velocity 2q - V0 of the impact at m pi vanishes, "
        "and above V* it comes earlier. Simulation decides this down to impacts of 1e-6.",
    )


def _third() -> Finding:
    printed = 1 + 3 * math.sqrt(2) / 4
    return Finding(
        (
            near("V*(3) from the contact", subset_critical_velocity(3), printed, 1e-12),
            near("V*(3) found by simulation", _simulated_limit(3), printed),
            near("the contact over 3 pi/2", contact_time(3) / (1.5 * math.pi), 1.0, 1e-12),
        )
    )


def _system() -> Finding:
    """Put the contact into (A6) and (A7), and look where simulation adds an impact."""
    checks = []
    for m in TABLE_1:
        t, gap = m * math.pi - contact_time(m), m + 1
        d = subset_critical_velocity(m) - _kick(m)
        value = (
            d * numerics.sin(t)
            - numerics.cos((2 * t + math.pi) / gap)
            + numerics.cos(math.pi / gap)
        )
        slope = d * numerics.cos(t) + 2 / gap * numerics.sin((2 * t + math.pi) / gap)
        size = max(abs(value), abs(slope))
        checks.append(near(f"m = {m}: both lines of (A6) at t* and D", size, tolerance=1e-13))
        inside = (m - 2) * math.pi <= t <= (m - 1) * math.pi
        checks.append(condition(f"m = {m}: t* in [(m-2) pi, (m-1) pi]", inside))
        above = subset_critical_velocity(m) * (1 + 1e-10)
        run = simulate(WALL, subset_forcing(m), v0=above, t_end=m * math.pi)
        # The dip has the width of the root of its depth, 1e-5.
        added = latest(run, 0, math.inf)
        checks.append(near(f"m = {m}: added impact at m pi - t*", added, contact_time(m), 1e-4))
    return Finding(
        tuple(checks),
        remark="The long flight touches at t* and, by its symmetry about m pi/2, at m pi - t*; "
        "the earlier touch decides. For m = 3 both are 3 pi/2.",
    )


def _through_contact() -> Finding:
    checks = []
    for m in TABLE_1:
        t, gap = m * math.pi - contact_time(m), m + 1
        ratio = numerics.sin((2 * t + math.pi) / gap) / numerics.cos(t)
        value = 2 / gap * (numerics.sin(math.pi / gap) - ratio)
        checks.append(near(f"V*({m}) by (A8), found by simulation", _simulated_limit(m), value))
    return Finding(tuple(checks), remark="For m = 3 (A8) is 0/0, and (A5) holds instead.")


def _table() -> Finding:
    return printed_table("V*", TABLE_1, subset_critical_velocity, proven=_proven_limit)


def _proven_limit(m: int) -> Ball | None:
    """Return a ball around V*(m): below it all impacts are on Y_m, above it they are not."""
    value = subset_critical_velocity(m)
    if [_kept(m, value + side * NEARBY) for side in (-1.0, 1.0)] != [True, False]:
        return None
    return Ball(arb(value, NEARBY))


def _kept(m: int, v0: float) -> bool | None:
    """Return whether all impacts are provably those of Y_m, or not; None without an answer."""
    return keeps_subset(m, v0).holds


def _side(m: int, v0: float, what: str, *, stays: bool) -> Check:
    """See whether a motion stays on Y_m, for ever where the balls say so, else for two periods."""
    kept = _kept(m, v0)
    if kept is not None:
        return certain_condition(what, kept is stays, is_certain=True)
    return condition(what, _stays(m, v0) is stays)


def _both_sides() -> Finding:
    """Follow motions just below and just above each critical velocity."""
    checks = []
    for m in (*EVEN, *ODD):
        v = subset_critical_velocity(m)
        # Even m: see SLOWEST_IMPACT.
        close = 1e-5 if m % 2 == 0 else 1e-10
        below, above = v * (1 - close), v * (1 + close)
        checks.append(_side(m, below, f"m = {m}: Y_m at V* (1 - {close:g})", stays=True))
        checks.append(_side(m, above, f"m = {m}: not Y_m at V* (1 + {close:g})", stays=False))
    for m in ODD:
        ball, value = _proven_limit(m), subset_critical_velocity(m)
        found = _simulated_limit(m) if ball is None else ball.mid()
        what = f"m = {m}: limit of the velocities with Y_m, minus V*"
        radius = None if ball is None else ball.radius()
        checks.append(Check(what, found - value, 0.0, ROUNDING, radius))
    return Finding(tuple(checks))


def _above() -> Finding:
    """Follow motions above V* for 4000 time units."""
    kinds, moved, reached = [], [], []
    for m in range(2, 8):
        motion = SubsetMotion(m, 0)
        for part in (1.01, 1.05, 1.3, 2.0, 4.0):
            v0 = part * subset_critical_velocity(m)
            run = simulate(WALL, motion.forcing, v0=v0, t_end=4000.0)
            kinds.append(classify_impact_times(run).kind)
            times = run.impacts.t[: len(motion.impact_times(8))]
            moved.append(float(np.abs(times - motion.impact_times(8)).max()))
            reached.append(run.outcome.name == "reached_t_end")
    return Finding(
        (
            condition("30 motions (m = 2 to 7, V0 = 1.01 to 4 V*) go on to t = 4000", all(reached)),
            condition("none of them keeps to Y_m", min(moved) > 1e-3),
            near("with impact times without a period", kinds.count("no_period_found"), 30),
        ),
        remark="Irregular here: no period found within 4000 time units.",
    )


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="family-valid",
        reference="section 3, (A1), (A2)",
        claim="For 0 < V0 < V*(m) the motion (11) with (13), (14) stays positive between the "
        "times of Y_m.",
        method="simulation for m = 2 to 15",
        certainty="proof",
        proven=True,
        find=_valid,
    ),
    _of(
        id="eqA3",
        reference="(A3)",
        claim="For even m, x = u - w >= 0 reduces to a condition on the slopes.",
        formula=r"|u'(t)| \geq |w'(t)|",
        method="slopes where the flights begin, for motions that stay on Y_m and that do not",
        certainty="proof",
        proven=True,
        find=_slopes,
    ),
    _of(
        id="eqA4",
        reference="(A4)",
        claim="V*(m) for even m.",
        formula=r"V^*(m) = \frac{4}{m+1}\sin\frac{\pi}{m+1}",
        method="the limit found by simulation alone, without the formula",
        certainty="proof",
        proven=True,
        find=_even,
    ),
    _of(
        id="eqA5",
        reference="(A5)",
        claim="V*(3), from a contact in the middle of the long flight.",
        formula=r"V^*(3) = 1 + 3\sqrt{2}/4",
        method="root of the contact condition, and the limit found by simulation",
        certainty="closed form, 12 digits",
        proven=True,
        find=_third,
    ),
    _of(
        id="eqA6-A7",
        reference="(A6), (A7)",
        claim="For other odd m the limit comes from a contact of u and w at t*, with V* = D + q.",
        formula=r"D\sin t_* = \cos\frac{2t_*+\pi}{m+1} - \cos\frac{\pi}{m+1}",
        method="root of the contact condition, and where simulation adds an impact",
        certainty="closed form, 12 digits",
        proven=True,
        find=_system,
    ),
    _of(
        id="eqA8",
        reference="(A8)",
        claim="V*(m) for odd m through the instant of contact.",
        formula=r"V^* = \frac{2}{m+1}[\sin\frac{\pi}{m+1} - \sin\frac{2t_*+\pi}{m+1}/\cos t_*]",
        method="the formula, and the limit found by simulation",
        certainty="closed form, 12 digits",
        proven=True,
        find=_through_contact,
    ),
    _of(
        id="table1",
        reference="table 1",
        claim="V* = 1.5, 0.984, 0.675, 0.486, 0.365, 0.283 for m = 5, 7, 9, 11, 13, 15.",
        method="root of the contact condition",
        certainty="closed form, 12 digits",
        find=_table,
    ),
    _of(
        id="table1-simulated",
        reference="table 1",
        claim="At V*(m) the impact times change.",
        method="simulation just below and just above, and the limit found by halving",
        certainty="simulation, 1e-10",
        find=_both_sides,
    ),
    _of(
        id="above-critical",
        reference="section 3",
        claim="Above V* solutions exist, but involve different, irregular impact times.",
        method="simulation of 30 motions",
        certainty="simulation",
        find=_above,
    ),
)
