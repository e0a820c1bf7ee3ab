"""What an impact takes in a sweep: with each measure, and with several in a list."""

from __future__ import annotations

import time

import numpy as np

import percuss as pc
from benchmarks.report import Report

OSCILLATOR, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine(2.5)
# Few laws: what laws take is a line of its own, in W2.
OVER = {
    "forcing.omega": [float(omega) for omega in np.linspace(2.0, 3.0, 50)],
    "start.v0": [float(v) for v in np.linspace(0.05, 3.0, 40)],
}
# As in a sweep that says nothing of them.
TRANSIENT, PERIODS = 200, 64
LIST = ["period", "largest_lyapunov_exponent"]
TURNS = 5


def run(report: Report) -> None:
    """Time sweeps over starts, of one core, by the processor's own clock."""
    report.section(
        "Measures of a sweep",
        f"x'' + x = cos omega t, wall at 0, r = 0.8; {TRANSIENT} forcing periods left out and "
        f"{PERIODS} measured, at 50 frequencies from 40 starts each; time of the processor for "
        "each impact of the motions. An exponent is taken in a run of its own, so that a list "
        "of it and a period follows each motion twice.",
    )
    measures: list[str | list[str]] = [
        "peak_impact_velocity", "peak_displacement", "period", "largest_lyapunov_exponent", LIST,
    ]  # fmt: skip
    taken: dict[int, list[float]] = {i: [] for i in range(len(measures))}
    impacts = int(_sweep("period").attrs["n_impacts"])
    for _ in range(TURNS):
        for i, measure in enumerate(measures):
            start = time.process_time()
            found = _sweep(measure)
            taken[i].append(time.process_time() - start)
            # Of a list both runs are counted.
            assert found.attrs["n_impacts"] in (impacts, 2 * impacts)
    for i, measure in enumerate(measures):
        name = measure if isinstance(measure, str) else " and ".join(measure)
        report.line(f"{name}, ns per impact", f"{np.median(taken[i]) / impacts * 1e9:.0f} ns")


def _sweep(measure: str | list[str]):  # type: ignore[no-untyped-def]
    return pc.sweep(
        measure, OSCILLATOR, FORCE, over=OVER, start=(0.0, 1.0),
        transient=TRANSIENT, periods=PERIODS, n_workers=1,
    )  # fmt: skip
