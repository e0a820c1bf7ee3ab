"""Work in some processes, each of which keeps to one module as long as it can.

What the items of a module share is computed once where one process does them all.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager
from typing import TypeVar

from percuss.paper.collection import Item

Result = TypeVar("Result")
# How often the caller is asked whether to go on [s].
PATIENCE = 0.1


def next_item(waiting: Sequence[Item], mine: str | None, others: set[str]) -> Item:
    """Return what a process should do next: its own module, then one that no process is at.

    Parameters
    ----------
    waiting
        What is left, not empty, in order.
    mine
        The module that the process did last.
    others
        The modules that the other processes are at.

    Examples
    --------
    >>> a, b = Item("figure", "fig1", "one", ""), Item("figure", "fig2", "two", "")
    >>> next_item([a, b], "two", set()).name, next_item([a, b], None, {"one"}).name
    ('fig2', 'fig2')
    """
    own = (item for item in waiting if item.module == mine)
    free = (item for item in waiting if item.module not in others)
    return next(own, None) or next(free, None) or waiting[-1]


def in_processes(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    processes: int,
    go_on: Callable[[], bool],
    failed: Callable[[Item, str], Result],
) -> Iterator[Result]:
    """Do items in processes and give the answers as they come.

    Parameters
    ----------
    work
        A function that another process can import.
    items
        What to do.
    processes
        How many.
    go_on
        Asked ten times a second; once it says False nothing new is begun, what is being done is
        finished.
    failed
        Gives the answer for an item whose process ended, and why.
    """
    pools = [_pool() for _ in range(processes)]
    waiting = list(items)
    running: dict[Future[Result], tuple[int, Item]] = {}
    module: list[str | None] = [None] * processes
    try:
        while waiting or running:
            if not go_on():
                waiting.clear()
            busy = {worker for worker, _ in running.values()}
            for worker in sorted(set(range(processes)) - busy):
                if waiting:
                    others = {item.module for _, item in running.values()}
                    item = next_item(waiting, module[worker], others)
                    waiting.remove(item)
                    module[worker] = item.module
                    with _interrupts_ignored():
                        running[pools[worker].submit(work, item)] = worker, item
            finished, _ = wait(running, timeout=PATIENCE, return_when=FIRST_COMPLETED)
            for future in finished:
                worker, item = running.pop(future)
                try:
                    yield future.result()
                except BrokenExecutor:
                    pools[worker] = _pool()
                    yield failed(item, "its process ended, perhaps for want of memory")
    finally:
        for pool in pools:
            pool.shutdown(wait=not running, cancel_futures=True)


def _pool() -> ProcessPoolExecutor:
    # Not forked: this process has threads, and numba and matplotlib may hold locks.
    return ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"))


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Have processes begun here ignore Ctrl-C, from their first instruction on.

    Ctrl-C goes to all of them; the process that shows the progress ends the others.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
