"""Shallow dips and near misses: who sees the first event?"""

from __future__ import annotations

import time
from collections.abc import Callable

from tests.motion.adversarial import faults_of, near_grazing_cases
from tests.motion.one_harmonic import Pass, is_right, passes

import percuss as pc
from benchmarks.report import Report, installed

HARD = 10_000


def run(report: Report) -> None:
    """Count wrong answers: 4,000 cases of one harmonic with the peers, 10,000 harder ones."""
    report.section(
        "Near-grazing first events",
        "One harmonic: 2,000 dips of 1e-10 to 1e-3 below the wall and as many near misses; SciPy "
        "does every tenth. The harder set: 10,000 cases down to 1e-15 of the amplitude, every "
        "linear regime, up to four harmonics, soft stops, two walls; wrong is what rounding "
        "(1e-13 of the amplitude) does not excuse and `run.grazes` does not list.",
    )
    dips, misses = list(passes(2000, 1, -1)), list(passes(2000, 1, 1))
    for name, first_event in _contenders().items():
        step = 10 if name == "SciPy" else 1
        first_event(dips[0])
        start = time.perf_counter()
        missed = sum(not is_right(case, first_event(case)) for case in dips[::step])
        false = sum(not is_right(case, first_event(case)) for case in misses[::step])
        each = (time.perf_counter() - start) / (len(dips[::step]) + len(misses[::step]))
        of = len(dips[::step])
        report.line(f"{name}, missed / false of {of} / {of}", f"{missed} / {false}")
        report.line(f"{name}, us per case", f"{each * 1e6:.0f} us")
        assert name != "percuss" or missed == false == 0
    wrong = [fault for case in near_grazing_cases(HARD, seed=1) for fault in faults_of(case)]
    report.line(f"percuss, wrong of {HARD:,} harder cases", str(len(wrong)), "0", met=not wrong)
    assert wrong == []


def _contenders() -> dict[str, Callable[[Pass], float | None]]:
    found: dict[str, Callable[[Pass], float | None]] = {"percuss": _percuss}
    if installed("heyoka"):
        from benchmarks.heyoka_peer import Impacts

        peer = Impacts(callback=False)
        found["heyoka"] = lambda case: peer.first_event(case.omega, case.start, case.t_end)
    if installed("scipy"):
        from benchmarks import scipy_peer

        found["SciPy"] = lambda case: scipy_peer.first_event(case.omega, case.start, case.t_end)
    return found


def _percuss(case: Pass) -> float | None:
    osc, force = pc.impact_oscillator(), pc.cosine(case.omega)
    found = pc.simulate(osc, force, *case.start, t_end=case.t_end, max_impacts=1).impacts
    return float(found.t[0]) if len(found) else None
