"""From nothing to a result: imports, the command line, a warm and a cold cache."""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import percuss as pc
from benchmarks.report import Report
from benchmarks.timing import REPEATS

IMPORT = "import time; a = time.perf_counter(); import percuss; print(time.perf_counter() - a)"
SIMULATE = (
    "import percuss as pc; "
    "print(pc.simulate(pc.impact_oscillator(), pc.sine(3), v0=0.51, t_end=94.25).impacts.t[29])"
)
THIRTY_PI = 94.24777960769379


def run(report: Report) -> None:
    """Time whole processes."""
    report.section("Start", "Whole processes but for the first line; medians of seven.")
    imports = [float(_output("-c", IMPORT)) for _ in range(REPEATS + 1)]
    report.below("import percuss", statistics.median(imports[1:]), 0.2, "s")
    report.below("percuss --help", _seconds("-m", "percuss", "--help"), 0.3, "s")
    _check(_output("-c", SIMULATE))
    report.below("import and simulate, warm cache", _seconds("-c", SIMULATE), 0.5, "s")
    report.below("the same, cold cache", _cold_seconds(), 6.0, "s")
    report.below("a new oscillator under a new force, 30 impacts", _call() * 1e6, 60.0, "us")


def _call() -> float:
    """Return the median of calls of which each has a restitution and a force of its own [s]."""
    times = []
    for k in range(500):
        begin = time.perf_counter()
        oscillator = pc.impact_oscillator(restitution=0.9 + k * 1e-5)
        run = pc.simulate(oscillator, pc.cosine(2.5 + k * 1e-4), v0=1.0, max_impacts=30)
        times.append(time.perf_counter() - begin)
        assert len(run.impacts) == 30
    return statistics.median(times)


def _check(printed: str) -> None:
    """Assert that the 30th impact is at 30 pi, within an ulp."""
    assert abs(float(printed) - THIRTY_PI) <= math.ulp(THIRTY_PI), printed


def _output(*arguments: str, cache: str | None = None) -> str:
    environment = os.environ | ({"NUMBA_CACHE_DIR": cache} if cache else {})
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, check=True, capture_output=True, text=True, env=environment, cwd=Path.home()
    ).stdout


def _seconds(*arguments: str) -> float:
    times = []
    for _ in range(REPEATS + 1):
        start = time.perf_counter()
        _output(*arguments)
        times.append(time.perf_counter() - start)
    return statistics.median(times[1:])


def _cold_seconds() -> float:
    times = []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as cache:
            start = time.perf_counter()
            _check(_output("-c", SIMULATE, cache=cache))
            times.append(time.perf_counter() - start)
    return statistics.median(times)
