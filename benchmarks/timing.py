"""How long something takes."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

REPEATS = 7
FEWEST = 3
# Seconds for the runs of one contender.
BUDGET = 20.0


def race(contenders: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the median seconds of each contender; they take turns, after one run to warm up."""
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for run in contenders.values():
        run()
    for turn in range(REPEATS):
        for name, run in contenders.items():
            if turn >= FEWEST and sum(times[name]) > BUDGET:
                continue
            start = time.perf_counter()
            run()
            times[name].append(time.perf_counter() - start)
    return {name: statistics.median(taken) for name, taken in times.items()}
