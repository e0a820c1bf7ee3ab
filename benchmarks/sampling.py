"""The motion at 2^20 instants."""

from __future__ import annotations

import numpy as np
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of

import percuss as pc
from benchmarks.report import Report
from benchmarks.timing import race

OSCILLATOR, FORCE = pc.impact_oscillator(), pc.sine(3)
T, N = 400.0, 2**20


def run(report: Report) -> None:
    """Evaluate a run of 190 impacts in closed form."""
    report.section(
        "Closed-form sampling",
        f"The motion of W1 up to t = {T:g}, x and v at 2^20 instants in order.",
    )
    motion = pc.simulate(OSCILLATOR, FORCE, v0=0.45, t_end=T)
    t = np.linspace(0.0, T, N)
    x, v = motion(t)
    exact = simulate(problem_of(OSCILLATOR, FORCE), 0, 0.45, t_end=T)
    for i in range(1, N, N // 200):
        expected = [float(value) for value in exact(t[i])]
        # An impact time carries half an ulp of 400, which is 3e-14, into x and v.
        np.testing.assert_allclose((x[i], v[i]), expected, rtol=0, atol=1e-12)
    taken = race({"call": lambda: motion(t), "sample": lambda: motion.sample(N)})
    report.below("run(t)", taken["call"] * 1e3, 50, "ms")
    report.below("run.sample(n), as a dataset", taken["sample"] * 1e3, 50, "ms")
