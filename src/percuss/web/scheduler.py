"""A scheduler in time slices: short tasks overtake long ones, and no client blocks the others."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any, TypeVar

from percuss.ensembles.threads import Threads

T = TypeVar("T")

# Length of a slice [s]: a long call reaches a checkpoint a few times in it.
SLICE = 0.02
# Part of the time for tasks that have used a slice while new tasks wait: a task that needs little
# does not wait for a round of long ones, and the long ones still advance.
LONG_SHARE = 0.1
# Threads, with those of waiting tasks: more than there are clients.
MOST_THREADS = 2048


class Task:
    """A function that runs in slices, and its time.

    Parameters
    ----------
    scheduler
        Hands out the slices.
    function
        Called with this task.
    """

    def __init__(self, scheduler: Scheduler, function: Callable[[Task], Any]) -> None:
        self.scheduler = scheduler
        self.function = function
        self.future: Future[Any] = Future()
        self.has_started = self.had_slice = False
        self.resumed = threading.Event()
        self._slice_began = self._spent = 0.0

    def begin_slice(self) -> None:
        """Start the clock of a slice."""
        self._slice_began = time.monotonic()

    def end_slice(self) -> float:
        """Stop the clock, and return how long the slice was [s]."""
        before = self._spent
        self._spent, self._slice_began = self.seconds(), 0.0
        return self._spent - before

    def seconds(self) -> float:
        """Return how long the task has run, without its waits [s]."""
        return self._spent + (time.monotonic() - self._slice_began if self._slice_began else 0.0)

    def checkpoint(self) -> bool:
        """Let other tasks run once the slice is used up; return whether to go on at all."""
        if time.monotonic() - self._slice_began > SLICE:
            self.scheduler.wait_for_slice(self)
        return not self.scheduler.is_closed


class Scheduler:
    """Two round robins: of new tasks, and of those that have used a slice.

    A client can submit only a few tasks at once (`percuss.web.session`), so that a round is short.

    Parameters
    ----------
    n
        How many tasks run at once.

    Examples
    --------
    >>> scheduler = Scheduler(1)
    >>> scheduler.submit(lambda task: task.checkpoint()).result()
    True
    """

    def __init__(self, n: int) -> None:
        self._free = n
        self._new: deque[Task] = deque()
        self._long: deque[Task] = deque()
        # Time that tasks beyond their first slice may take before new ones [s].
        self._credit = 0.0
        self._tasks: set[Task] = set()
        self._lock = threading.Lock()
        self._threads = Threads(MOST_THREADS)
        self.is_closed = False

    def submit(self, function: Callable[[Task], T]) -> Future[T]:
        """Run a function, which should call ``task.checkpoint()`` now and then.

        Returns
        -------
        concurrent.futures.Future
            Its result; it is cancelled when the scheduler is closed.
        """
        task = Task(self, function)
        with self._lock:
            if self.is_closed:
                task.future.cancel()
                return task.future
            self._tasks.add(task)
            self._new.append(task)
            self._dispatch()
        return task.future

    def wait_for_slice(self, task: Task) -> None:
        """Wait until a task gets another slice; at once where no other waits."""
        with self._lock:
            self._account(task)
            if not (self._new or self._long) or self.is_closed:
                task.begin_slice()
                return
            task.resumed.clear()
            self._long.append(task)
            self._free += 1
            self._dispatch()
        task.resumed.wait()
        task.begin_slice()

    def close(self) -> None:
        """Cancel all tasks; a running one ends at its next checkpoint, and is not waited for."""
        with self._lock:
            if self.is_closed:
                return
            self.is_closed = True
            tasks, self._tasks = self._tasks, set()
            for task in tasks:
                task.resumed.set()
            self._new.clear()
            self._long.clear()
        for task in tasks:
            task.future.cancel()
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _account(self, task: Task) -> None:
        """Charge a task for its slice; under the lock."""
        seconds = task.end_slice()
        if task.had_slice:
            self._credit = max(-1.0, self._credit - seconds)
        else:
            self._credit = min(SLICE, self._credit + LONG_SHARE * seconds)
        task.had_slice = True

    def _dispatch(self) -> None:
        """Give the free places to the next tasks; under the lock."""
        while self._free > 0 and (self._new or self._long):
            is_long = self._long and (not self._new or self._credit > 0.0)
            task = (self._long if is_long else self._new).popleft()
            self._free -= 1
            if task.has_started:
                task.resumed.set()
            else:
                task.has_started = True
                self._threads.submit(self._run, task)

    def _run(self, task: Task) -> None:
        task.begin_slice()
        # The future may be cancelled while the function runs.
        with suppress(InvalidStateError):
            try:
                if not task.future.cancelled():
                    task.future.set_result(task.function(task))
            except InvalidStateError:
                raise
            except BaseException as error:  # noqa: BLE001 - handed to whoever waits for the future
                task.future.set_exception(error)
        with self._lock:
            self._account(task)
            self._tasks.discard(task)
            self._free += 1
            self._dispatch()
