"""W1: elastic impacts, x'' + x = sin 3t on x > 0, from x = 0 with v = 0.45."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

import percuss as pc
from benchmarks import references
from benchmarks.report import Report, installed
from benchmarks.timing import race

Contenders: TypeAlias = dict[str, Callable[[], object]]

OSCILLATOR, FORCE = pc.impact_oscillator(), pc.sine(3)
V0 = "0.45"
# sin 3t as the peers take it: a cosine with a phase.
PEER = {"omega": 3.0, "phase": -math.pi / 2, "start": (0.0, 0.45)}
LONG, SHORT, SLOW = 100_000, 1_000, 20
# A short call is timed as the mean of so many: calls come in numbers where they matter.
CALLS = 20


def run(report: Report) -> None:
    """Compare seconds per impact, long run and whole call, with the peers'."""
    report.section(
        "W1: elastic impacts of the third harmonic",
        "x'' + x = sin 3t, wall at 0, r = 1, v0 = 0.45. heyoka cannot act on an event without "
        "Python code. Its time without the callback is the smaller of two: a terminal event "
        "without one, after which a Python loop turns v and restarts; and the time with the "
        "callback less what as many calls of it take alone.",
    )
    found = motion(LONG).impacts
    error = _error(found.t)
    # Two ulp of t = 2094, which is where the reference ends.
    assert len(found) == LONG
    assert error <= 2 * np.spacing(2094.0), f"error of impact times {error}"
    report.line("percuss, largest error of the first 1,000 times", f"{error:.1e}")
    # One race each for long runs and short calls, so that every ratio is one of the times shown.
    long: Contenders = {"percuss": lambda: motion(LONG)}
    short: Contenders = {"percuss": lambda: [motion(SHORT) for _ in range(CALLS)]}
    wrong: dict[str, float] = {}
    if installed("heyoka"):
        wrong["heyoka"] = _add_heyoka(long, short)
    if installed("scipy"):
        wrong["scipy"] = _add_scipy(long)
    taken, calls = race(long), race(short)
    each = taken["percuss"] / LONG
    report.below("percuss, ns per impact of 100,000 (aim)", each * 1e9, 100, "ns")
    report.line("percuss, a call of 1,000 impacts", f"{calls['percuss'] / CALLS * 1e6:.0f} us")
    if "heyoka" in wrong:
        _tell_heyoka(report, wrong["heyoka"], taken, calls)
    if "scipy" in wrong:
        scipy = taken["scipy"] / SLOW
        report.line(f"SciPy, largest error of the first {SLOW} times", f"{wrong['scipy']:.1e}")
        report.line("SciPy DOP853 1e-12 with events, us per impact", f"{scipy * 1e6:.0f} us")
        report.ratio("SciPy : percuss", scipy / each, 1000)


def motion(n: int) -> pc.Trajectory:
    return pc.simulate(OSCILLATOR, FORCE, v0=V0, max_impacts=n)


def _error(t: np.ndarray) -> float:
    """Return the largest error of the first impact times, up to 1,000 of them."""
    exact, _ = references.impacts(OSCILLATOR, FORCE, (0, V0), SHORT, "w1")
    n = min(len(t), SHORT)
    return float(np.abs(t[:n] - exact[:n]).max())


def _add_heyoka(long: Contenders, short: Contenders) -> float:
    """Let heyoka take part, and return its largest error."""
    from benchmarks.heyoka_peer import Impacts

    peer, bare = Impacts(), Impacts(callback=False)
    errors = [
        _error(peer.run(SHORT, restitution=1.0, **PEER)[0]),
        _error(bare.run_restarted(SHORT, **PEER)[0]),
    ]
    # What a peer gets wrong by more than this is no comparison.
    assert max(errors) < 1e-8
    long["heyoka"] = lambda: peer.run(LONG, restitution=1.0, **PEER)
    long["restarted"] = lambda: bare.run_restarted(LONG, **PEER)
    long["callback"] = lambda: peer.call_back(LONG)
    short["heyoka"] = lambda: peer.run(SHORT, restitution=1.0, **PEER)
    return max(errors)


def _tell_heyoka(
    report: Report, error: float, long: dict[str, float], short: dict[str, float]
) -> None:
    report.line("heyoka, largest error of the first 1,000 times", f"{error:.1e}")
    without = min(long["restarted"], long["heyoka"] - long["callback"])
    report.line("heyoka with its callback, ns per impact", f"{long['heyoka'] / LONG * 1e9:.0f} ns")
    report.line("heyoka without its callback, ns per impact", f"{without / LONG * 1e9:.0f} ns")
    report.line("heyoka, a call of 1,000 impacts", f"{short['heyoka'] * 1e6:.0f} us")
    report.ratio("heyoka with callback : percuss, 100,000", long["heyoka"] / long["percuss"], 20)
    report.ratio(
        "heyoka with callback : percuss, 1,000", short["heyoka"] / short["percuss"] * CALLS, 12
    )
    report.ratio("heyoka without callback : percuss, 100,000", without / long["percuss"])


def _add_scipy(long: Contenders) -> float:
    """Let SciPy take part, and return its largest error."""
    from benchmarks import scipy_peer

    error = _error(scipy_peer.impacts(SLOW, restitution=1.0, **PEER)[0])
    assert error < 1e-8
    long["scipy"] = lambda: scipy_peer.impacts(SLOW, restitution=1.0, **PEER)
    return error
