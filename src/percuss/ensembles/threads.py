"""Threads whose work can be left where it is.

A thread cannot be ended from outside: it looks at a flag of its own between the steps of its work,
which compiled loops take as an array and look at too. Elsewhere than in the threads of `Threads`
the flag is never set.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from concurrent import futures
from typing import Any

import numpy as np

from percuss.arrays import Integers
from percuss.errors import PercussError

__all__ = ["Threads", "UnwantedError", "check_wanted", "stop_flag"]

_own = threading.local()
_NEVER = np.zeros(1, dtype=np.int64)


class UnwantedError(PercussError):
    """Work was given up because its result is not wanted any more."""


def stop_flag() -> Integers:
    """Return the flag of this thread, (1,) array: 0 as long as its work is wanted."""
    found: Integers = getattr(_own, "flag", _NEVER)
    return found


def check_wanted() -> None:
    """Raise `UnwantedError` if the result of this thread is not wanted any more.

    Examples
    --------
    >>> check_wanted()
    """
    if stop_flag()[0] != 0:
        raise UnwantedError("given up")


class Threads(futures.Executor):
    """A pool of threads; those of `concurrent.futures` keep a program from ending.

    Parameters
    ----------
    n
        How many.
    """

    def __init__(self, n: int) -> None:
        self._work: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._most = n
        self._threads: list[threading.Thread] = []
        self._stop = np.zeros(1, dtype=np.int64)
        # One for each thread that has nothing to do.
        self._idle = threading.Semaphore(0)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> futures.Future[Any]:
        """Have a function called by the next thread that is free."""
        future: futures.Future[Any] = futures.Future()
        self._work.put((future, fn, args, kwargs))
        if not self._idle.acquire(blocking=False) and len(self._threads) < self._most:
            name = f"percuss-{len(self._threads)}"
            self._threads.append(threading.Thread(target=self._run, name=name, daemon=True))
            self._threads[-1].start()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the threads when they are done with what has been submitted."""
        while cancel_futures:
            try:
                self._work.get_nowait()[0].cancel()
            except queue.Empty:
                break
        for _ in self._threads:
            self._work.put(None)
        for thread in self._threads if wait else ():
            thread.join()

    def drop(self, seconds: float) -> None:
        """Give up what is at work, and wait so long at most until it has ended [s]."""
        self._stop[0] = 1
        self.shutdown(wait=False, cancel_futures=True)
        until = time.monotonic() + seconds
        for thread in self._threads:
            thread.join(max(0.0, until - time.monotonic()))

    def _run(self) -> None:
        _own.flag = self._stop
        while (item := self._work.get()) is not None:
            future, fn, args, kwargs = item
            if future.set_running_or_notify_cancel():
                try:
                    result = fn(*args, **kwargs)
                except BaseException as error:  # noqa: BLE001  the waiting thread raises it
                    future.set_exception(error)
                else:
                    future.set_result(result)
                    del result
            # What it holds is not kept until the next one comes.
            del item, future, fn, args, kwargs
            self._idle.release()
