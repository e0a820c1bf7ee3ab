"""Threads whose work can be abandoned.

A thread cannot be ended from outside: it reads a flag of its own between the steps of its work, and
so do compiled loops, which take the flag as an array. Another flag says that no more work is
begun: what takes long and keeps nothing of a part gives up then. Only the threads of `Threads` have
flags that are ever set.
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

_own = threading.local()
_NEVER = np.zeros(1, dtype=np.int64)


class UnwantedError(PercussError):
    """The work was abandoned: its result is no longer wanted."""


def stop_flag() -> Integers:
    """Return the flag of this thread, (1,) array: 0 as long as its work is wanted."""
    flag: Integers = getattr(_own, "flag", _NEVER)
    return flag


def check_wanted() -> None:
    """Raise `UnwantedError` if the result of this thread is no longer wanted.

    Examples
    --------
    >>> check_wanted()
    """
    if stop_flag()[0] != 0:
        raise UnwantedError("given up")


def check_going_on() -> None:
    """Raise `UnwantedError` if the work of this thread is unwanted, or its pool begins no more work.

    Examples
    --------
    >>> check_going_on()
    """
    check_wanted()
    if getattr(_own, "ending", _NEVER)[0] != 0:
        raise UnwantedError("given up unfinished")


class Threads(futures.Executor):
    """A pool of at most n threads that do not keep a program from ending, as Python's own do."""

    def __init__(self, n: int) -> None:
        self._work: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._most = n
        self._threads: list[threading.Thread] = []
        self._stop = np.zeros(1, dtype=np.int64)
        self._ending = np.zeros(1, dtype=np.int64)
        # Released once for each thread that has nothing to do.
        self._idle = threading.Semaphore(0)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> futures.Future[Any]:
        """Have a function called by the next free thread."""
        future: futures.Future[Any] = futures.Future()
        self._work.put((future, fn, args, kwargs))
        if not self._idle.acquire(blocking=False) and len(self._threads) < self._most:
            name = f"percuss-{len(self._threads)}"
            self._threads.append(threading.Thread(target=self._run, name=name, daemon=True))
            self._threads[-1].start()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the threads once the submitted work is done."""
        while cancel_futures:
            try:
                self._work.get_nowait()[0].cancel()
            except queue.Empty:
                break
        for _ in self._threads:
            self._work.put(None)
        for thread in self._threads if wait else ():
            thread.join()

    def end_soon(self) -> None:
        """Let work that keeps nothing of a part give up: no more is begun."""
        self._ending[0] = 1

    def drop(self, seconds: float) -> None:
        """Abandon the work in progress, and wait at most so long for its end [s]."""
        self._stop[0] = 1
        self.shutdown(wait=False, cancel_futures=True)
        until = time.monotonic() + seconds
        for thread in self._threads:
            thread.join(max(0.0, until - time.monotonic()))

    def _run(self) -> None:
        _own.flag, _own.ending = self._stop, self._ending
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
            # Frees its memory before the next item comes.
            del item, future, fn, args, kwargs
            self._idle.release()
