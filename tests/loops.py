"""Running coroutines in a thread of their own.

A browser keeps the event loop of its thread to itself, and `asyncio.run` throws away the one that
a Dask client left there, unclosed.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

Value = TypeVar("Value")

WAIT = 60.0


def run(work: Coroutine[Any, Any, Value], wait: float = WAIT) -> Value:
    """Return what a coroutine returns."""

    async def bounded() -> Value:
        return await asyncio.wait_for(work, wait)

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(lambda: asyncio.run(bounded())).result()
