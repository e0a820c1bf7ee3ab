"""Long elastic runs of which every impact is known in closed form (Dyskin et al. 2012)."""

from __future__ import annotations

import mpmath
import numpy as np

import percuss as pc
from benchmarks.report import Report
from benchmarks.timing import race

OSCILLATOR = pc.impact_oscillator()


def run(report: Report) -> None:
    """Check a million impacts of n = 3 and 1e5 of n = 2."""
    report.section(
        "Long runs",
        "Impacts at k pi: for n = 3 and V0 = 0.51 with the speed V0 each time, for n = 2 with "
        "V0 + 4k/3 (Dyskin et al. 2012, eq. 19 and fig. 6).",
    )
    found = pc.simulate(OSCILLATOR, pc.sine(3), v0=0.51, max_impacts=10**6).impacts
    k = np.arange(1, len(found) + 1)
    assert len(found) == 10**6
    ulps = float((np.abs(found.t - _multiples_of_pi(k)) / np.spacing(found.t)).max())
    expected = (1.5 * k) % 1.0
    off = np.abs(found.cycle - expected)
    cycle = float(np.minimum(off, 1.0 - off).max())
    speed = float(np.abs(found.v_after - 0.51).max())
    for what, value, limit, unit in (
        ("n = 3, 1e6 impacts: error of t_k", ulps, 2.0, "ulp"),
        ("n = 3: error of the cycle", cycle, 1e-10, ""),
        ("n = 3: error of V_k", speed, 1e-9, ""),
        ("n = 2, 1e5 impacts: relative error of V_k", _growth_error(), 5e-12, ""),
    ):
        assert value <= limit, f"{what}: {value}"
        report.below(what, value, limit, unit)
    taken = race({"n3": lambda: pc.simulate(OSCILLATOR, pc.sine(3), v0=0.51, max_impacts=10**6)})
    report.line("n = 3, 1e6 impacts", f"{taken['n3']:.3f} s")


def _growth_error() -> float:
    found = pc.simulate(OSCILLATOR, pc.sine(2), v0=1.0, max_impacts=10**5).impacts
    exact = 1.0 + np.arange(1, 10**5 + 1) * (4.0 / 3.0)
    return float(np.abs(found.v_after / exact - 1.0).max())


def _multiples_of_pi(k: np.ndarray) -> np.ndarray:
    """Return k pi, correctly rounded."""
    with mpmath.workdps(40):
        return np.array([float(int(n) * mpmath.pi) for n in k])
