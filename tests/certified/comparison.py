"""Certified runs against the oracle's, which share no code."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
from flint import arb, ctx
from tests.oracle.event_driven import Run, simulate
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import Motion

import percuss as pc
from percuss.certified import Balls, CertifiedRun, Ending
from percuss.motion.trajectory import Outcome

DURATION = 5.0
# Events that are compared: each costs the oracle hundreds of digits.
MOST = 4
# Elastic hops on a wall can be any number.
FEW = 150
DIGITS = 100
# What the oracle may be off by, after so many events.
ORACLE = "1e-60"

COMPLETE = {Ending.reached_t_end, Ending.reached_max_impacts, Ending.at_rest}


def misses(case: Motion, bits: tuple[int | None, ...] = (None,)) -> list[str]:
    """Return what of a motion lies outside of its enclosures, and proofs that end early."""
    t0 = case.start[2]
    until = t0 + DURATION
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=until, max_impacts=FEW)
    # The entries into soft stops count too.
    if run.outcome is Outcome.reached_max_impacts:
        return []
    try:
        exact = _exact(case, until)
    except ArithmeticError:
        # A root of higher order; all that is claimed must end before it.
        proven = pc.certify(run, t_end=until)
        if proven.outcome is not Ending.graze:
            raise
        until = proven.t_end.mid() - 1e-6
        exact = _exact(case, until)
    found = []
    for number in bits:
        proven = pc.certify(run, t_end=until, bits=number)
        found += [f"{case}, {number} bits: {text}" for text in _misses(proven, exact)]
        open_ = proven.outcome not in COMPLETE and not _arrives_without_velocity(run, proven)
        if number is None and open_ and not _touches(run, exact):
            found.append(f"{case}: {proven}")
    return found


def _exact(case: Motion, until: float) -> Run:
    return simulate(
        problem_of(case.oscillator, case.forcing),
        *case.start,
        t_end=until,
        max_impacts=MOST,
        digits=DIGITS,
    )


def _touches(run: pc.Trajectory, exact: Run) -> bool:
    return len(run.grazes) > 0 or len(exact.touches) > 0


def _arrives_without_velocity(run: pc.Trajectory, proven: CertifiedRun) -> bool:
    """Return whether a proof ends where the float run comes to a stop with no speed to speak of.

    Half a natural period after a release, under odd harmonics of it, that is so exactly.
    """
    if len(proven.grazes) == 0:
        return False
    t = min(proven.grazes.t.mid()[0], run.t_end)
    return bool(abs(run(t, limit="before")[1]) < 1e-9)


def _misses(proven: CertifiedRun, exact: Run) -> list[str]:
    # Behind an accumulation the oracle has hops that are not listed here.
    listed = proven.contacts.n_impacts[0] if proven.accumulations else len(proven.impacts)
    with ctx.workprec(600):
        found = []
        for table, columns in (
            ("impacts", ("t", "v_before", "v_after")),
            ("crossings", ("t", "v")),
            ("contacts", ("start", "release")),
        ):
            for column in columns:
                ours, theirs = (getattr(getattr(r, table), column) for r in (proven, exact))
                ours = ours[: int(listed)] if table == "impacts" else ours
                found += [f"{table}.{column} {text}" for text in _outside(ours, theirs)]
            ours, theirs = (list(getattr(r, table).stop) for r in (proven, exact))
            n = min(len(ours), len(theirs), int(listed) if table == "impacts" else MOST)
            if ours[:n] != theirs[:n]:
                found.append(f"stops of {table}")
        return found + _motion(proven, exact)


def _motion(proven: CertifiedRun, exact: Run) -> list[str]:
    """Compare the motion up to the oracle's last event."""
    events = [*exact.impacts.t, *exact.crossings.t, *exact.contacts.start]
    start, end = proven.start_time.mid(), proven.t_end.mid() - proven.t_end.radius()
    if len(exact.impacts.t) == MOST:
        end = min(end, float(max(events)))
    if not start < end < float("inf"):
        return []
    found = []
    for t in np.linspace(start, end, 5)[1:-1]:
        ours, theirs = proven([t]), exact(float(t))
        for name, ball, number in zip("xv", ours, theirs, strict=True):
            found += [f"{name}({t}) {text}" for text in _outside(ball, [number])]
    return found


def _outside(balls: Balls, numbers: list[Any]) -> list[str]:
    """Return those numbers that lie outside of their balls."""
    return [
        f"{i}: {mpmath.nstr(number, 25)} outside of {ball}"
        for i, (ball, number) in enumerate(zip(balls, numbers, strict=False))
        if not mpmath.isnan(number) and not ball.arb.overlaps(_ball(number))
    ]


def _ball(number: Any) -> arb:
    with mpmath.workdps(160):
        return arb(mpmath.nstr(number, 150)) + arb(0, ORACLE)
