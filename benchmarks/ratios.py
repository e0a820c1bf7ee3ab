"""Times of W1, W2 and W4 over that of a plain loop of the same machine; `make frozen` keeps them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numba

from benchmarks import basin, elastic, sweep

REPEATS = 9


@numba.njit
def _loop(n: int) -> float:
    x, v = 0.1, 0.2
    for _ in range(n):
        x, v = x + 1e-3 * v, v - 1e-3 * x + 1e-7 / (1.0 + x * x)
    return x + v


def _seconds(call: Callable[[], object], repeats: int) -> float:
    call()
    least = math.inf
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        least = min(least, time.perf_counter() - began)
    return least


def frozen() -> dict[str, float]:
    """Return each ratio, of the least times."""
    yard = _seconds(lambda: _loop(5_000_000), REPEATS)
    times = {
        "W1": _seconds(lambda: elastic.motion(elastic.LONG), REPEATS),
        "W2": _seconds(sweep.follow, REPEATS),
        "W4": _seconds(lambda: basin.follow(basin.STARTS), 3),
    }
    return {name: round(seconds / yard, 3) for name, seconds in times.items()}
