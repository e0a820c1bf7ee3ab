"""What the result of a million impacts holds."""

from __future__ import annotations

import gc
import tracemalloc

import percuss as pc
from benchmarks.report import Report


def run(report: Report) -> None:
    """Measure what stays allocated with a result, its tables read."""
    report.section("Memory", "Traced by tracemalloc, to which NumPy reports its arrays.")
    osc, force = pc.impact_oscillator(), pc.sine(3)
    pc.simulate(osc, force, v0=0.45, max_impacts=10)
    gc.collect()
    tracemalloc.start()
    motion = pc.simulate(osc, force, v0=0.45, max_impacts=10**6)
    tables = (motion.impacts, motion.crossings, motion.contacts, motion.grazes)
    assert [len(table) for table in tables] == [10**6, 0, 0, 0]
    gc.collect()
    held, most = (size / 1e6 for size in tracemalloc.get_traced_memory())
    tracemalloc.stop()
    report.below("a result of 1e6 impacts", held, 150, "MB")
    report.line("most while it was computed", f"{most:.0f} MB")
