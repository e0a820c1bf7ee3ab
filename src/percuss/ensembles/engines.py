"""Where the chunks of a job are done: threads, processes, or the workers of a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeAlias

from percuss.ensembles.cluster import EngineError, chunks_by_address, chunks_by_client, reach
from percuss.ensembles.grid import whole
from percuss.ensembles.job import Block, Job
from percuss.ensembles.main_script import check_main
from percuss.ensembles.threads import Threads
from percuss.errors import ParameterError

__all__ = ["Engine", "EngineError", "check_engine", "done_chunks", "make_ready", "say_stopping"]

# "threads", "processes", the address of a Dask scheduler, or a `distributed.Client`.
Engine: TypeAlias = Any
Span: TypeAlias = tuple[int, int]
Tick: TypeAlias = Callable[[], bool]

# Chunks in hand for each worker: the next ones, so that none waits.
AHEAD = 2
# How often one looks up while no chunk is finished, and how long chunks are waited for that nobody
# wants any more [s].
TICK, GRACE = 0.5, 1.0
# A chunk at whose work so many worker processes have died is not tried again.
MOST_DEATHS = 3


def done_chunks(
    job: Job,
    spans: Sequence[Span],
    engine: Engine = "threads",
    n_workers: int | None = None,
    tick: Tick | None = None,
) -> Iterator[tuple[int, Block]]:
    """Do chunks, and give each as soon as it is done with its place in ``spans``.

    Closing the iterator drops what is at work and what has not begun.

    Parameters
    ----------
    job
        The work.
    spans
        First and last point of each chunk to do.
    engine
        "threads", "processes", the address of a Dask scheduler ("tcp://..."), or a client of one.
    n_workers
        Threads or processes; default: the cores that this process may use.
    tick
        Called every half second while no chunk is finished; False ends the iterator.

    Returns
    -------
    iterator of (int, Block)
        In the order in which they come.

    Raises
    ------
    ParameterError
        If there is no such engine, or it cannot have so many workers.
    EngineError
        If a cluster cannot be reached or is lost, or a chunk kills its workers.
    """
    check_engine(engine, n_workers)
    tick = tick or _goes_on
    n = n_workers or cores()
    if engine == "threads":
        return _of_pool(lambda: Threads(n), job, spans, n, tick)
    if engine == "processes":
        _check_that_it_travels(job)
        return _of_pool(lambda: _processes(n, job), None, spans, n, tick)
    if isinstance(engine, str):
        return chunks_by_address(job, spans, engine, tick)
    return chunks_by_client(job, spans, engine, tick)


def say_stopping() -> None:
    """Say at once that Ctrl-C was heard: chunks that are at work may take a while."""
    sys.stderr.write("\nstopping after the chunks at work; Ctrl-C again drops them\n")
    sys.stderr.flush()


def _goes_on() -> bool:
    return True


def check_engine(engine: Engine, n_workers: int | None) -> None:
    """Raise a `ParameterError` unless there can be such an engine, with so many workers."""
    if n_workers is not None:
        whole("n_workers", n_workers, 1)
    is_named = isinstance(engine, str) and (engine in ("threads", "processes") or "://" in engine)
    is_client = hasattr(engine, "submit") and hasattr(engine, "scheduler_info")
    if not (is_named or is_client):
        reason = 'neither "threads" nor "processes", nor a Dask client or its address ("tcp://...")'
        raise ParameterError("engine", engine, reason)


def make_ready(job: Job, engine: Engine, *, is_new: bool) -> None:
    """See to it that the engine can begin, before anything is written.

    Parameters
    ----------
    job
        The work.
    engine
        As `done_chunks` takes it.
    is_new
        Whether nothing has been done yet: what is finished needs no cluster.

    Raises
    ------
    ParameterError
        If other processes cannot begin from the caller's script, or do not find its functions.
    EngineError
        If no cluster answers.
    """
    if engine == "processes":
        _check_that_it_travels(job)
        check_main(job)
    elif is_new and isinstance(engine, str) and "://" in engine:
        reach(engine)


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _processes(n: int, job: Job) -> futures.Executor:
    return futures.ProcessPoolExecutor(
        n,
        # Forking a process whose threads hold locks can hang it.
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_remember,
        initargs=(job,),
    )


def _check_that_it_travels(job: Job) -> None:
    """Say in a sentence that a function cannot be sent to another process, before any begins."""
    measure = getattr(job, "measure", None)
    try:
        pickle.dumps(job)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        if measure is None:
            raise
        reason = (
            "cannot be sent to another process, which takes functions by the name that they have "
            'in a module; define it with def in a module, or take engine="threads"'
        )
        raise ParameterError("measure", getattr(measure, "__name__", measure), reason) from error


_JOB: list[Job] = []


def _remember(job: Job) -> None:
    _JOB[:] = [job]
    # Ctrl-C reaches all processes of a terminal; what is done about it is the caller's.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _compute(job: Job | None, span: Span) -> Block:
    return (job or _JOB[0]).compute(*span)


def _of_pool(
    make: Callable[[], futures.Executor],
    job: Job | None,
    spans: Sequence[Span],
    n: int,
    tick: Tick,
) -> Iterator[tuple[int, Block]]:
    hand = _Hand(len(spans), n)
    running: dict[futures.Future[Block], int] = {}
    n_interrupts = 0
    is_over = False
    pool = make()
    try:
        while True:
            done: set[futures.Future[Block]] = set()
            is_broken = False
            try:
                while n_interrupts == 0 and hand.has_next(len(running)):
                    i = hand.take()
                    running[pool.submit(_compute, job, spans[i])] = i
                if not running:
                    break
                done, _ = futures.wait(running, TICK, return_when=futures.FIRST_COMPLETED)
                if not done and not tick():
                    return
            except KeyboardInterrupt:
                n_interrupts += 1
                if n_interrupts > 1:
                    raise
                say_stopping()
                running = {future: i for future, i in running.items() if not future.cancel()}
                continue
            except BrokenProcessPool:
                # It did not take what it was handed.
                hand.take_back([i])
                is_broken = True
            lost = [future for future in done if _is_lost(future)]
            for future in sorted(done.difference(lost), key=running.__getitem__):
                block = future.result()
                yield running.pop(future), block
            if lost or is_broken:
                # With a process its whole pool is lost, and what it has not finished.
                if n_interrupts > 0:
                    raise KeyboardInterrupt
                futures.wait(running)
                gone = {future: i for future, i in running.items() if _is_lost(future)}
                running = {future: i for future, i in running.items() if future not in gone}
                hand.note_death(sorted(gone.values()), spans)
                pool.shutdown(wait=False)
                pool = make()
        is_over = True
        if n_interrupts > 0:
            raise KeyboardInterrupt
    finally:
        for future in running:
            future.cancel()
        # The second may come while the first is still being told.
        if is_over:
            pool.shutdown(wait=True)
        else:
            _drop(pool)


class _Hand:
    """Which chunk is handed out next: one at whose work a process has died goes alone."""

    def __init__(self, count: int, n: int) -> None:
        self._waiting = deque(range(count))
        self._suspects: deque[int] = deque()
        self._alone: int | None = None
        self._deaths: Counter[int] = Counter()
        self._n = n

    def has_next(self, running: int) -> bool:
        """Return whether one more is to be handed out beside so many that are at work."""
        if running == 0:
            self._alone = None
        if self._suspects or self._alone is not None:
            # Whatever dies then has died of it.
            return running == 0
        # Few at a time: what is done waits in memory until it is taken.
        return bool(self._waiting) and running < AHEAD * self._n

    def take(self) -> int:
        """Return the next one."""
        if self._suspects:
            self._alone = self._suspects.popleft()
            return self._alone
        return self._waiting.popleft()

    def take_back(self, those: Sequence[int]) -> None:
        """Have chunks handed out again."""
        self._waiting.extendleft(reversed(those))

    def note_death(self, lost: Sequence[int], spans: Sequence[Span]) -> None:
        """Have lost chunks handed out again, unless the death of a process is told of one.

        Parameters
        ----------
        lost
            Those that were handed out and not done, in order: the first n were at work.
        spans
            First and last point of each chunk.
        """
        if not lost:
            return
        at_work = lost[: self._n]
        self._deaths.update(at_work)
        points = ", ".join(f"{spans[i][0]:,} to {spans[i][1] - 1:,}" for i in at_work)
        if any(self._deaths[i] >= MOST_DEATHS for i in at_work):
            raise EngineError(
                f"{MOST_DEATHS} worker processes have died, one after another, by a crash, a "
                f"signal or for want of memory, while these points were at work: {points}; they "
                "may have said why above"
            )
        sys.stderr.write(
            f"a worker process has died while these points were at work: {points}; they are done "
            "again\n"
        )
        sys.stderr.flush()
        self._suspects.extend(at_work)
        self._alone = None
        self.take_back(lost[len(at_work) :])


def _is_lost(future: futures.Future[Block]) -> bool:
    return future.done() and isinstance(future.exception(), BrokenProcessPool)


def _drop(pool: futures.Executor) -> None:
    """End what is at work: processes at once, threads at the next step of their work."""
    if isinstance(pool, Threads):
        pool.drop(GRACE)
        return
    for process in list((getattr(pool, "_processes", None) or {}).values()):
        process.kill()
    pool.shutdown(wait=False, cancel_futures=True)
