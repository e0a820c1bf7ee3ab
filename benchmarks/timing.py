"""How long something takes."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

REPEATS = 7
FEWEST = 3
# Seconds for the runs of one contender.
BUDGET = 20.0


def race(
    contenders: dict[str, Callable[[], object]], *, of_processor: bool = False
) -> dict[str, float]:
    """Return the median seconds of each contender; they take turns, after one run to warm up.

    Of the processor the least, which other work on the machine hardly changes.
    """
    clock = time.process_time if of_processor else time.perf_counter
    typical = min if of_processor else statistics.median
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for run in contenders.values():
        run()
    for turn in range(REPEATS):
        for name, run in contenders.items():
            if turn >= FEWEST and sum(times[name]) > BUDGET:
                continue
            start = clock()
            run()
            times[name].append(clock() - start)
    return {name: typical(taken) for name, taken in times.items()}
