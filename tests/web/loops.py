"""Running coroutines beside a browser, which keeps the event loop of this thread to itself."""

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
