"""Where the chunks of a job are done: threads, processes, or the workers of a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
from collections.abc import Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeAlias

from percuss.ensembles.cluster import EngineError, chunks_by_address, chunks_by_client, reach
from percuss.ensembles.grid import whole
from percuss.ensembles.job import Block, Job
from percuss.ensembles.main_script import check_main
from percuss.ensembles.threads import Threads
from percuss.ensembles.watch import tell_of_stopping
from percuss.errors import ParameterError

__all__ = ["Engine", "EngineError", "check_engine", "done_chunks", "make_ready"]

# "threads", "processes", the address of a Dask scheduler, or a `distributed.Client`.
Engine: TypeAlias = Any
Span: TypeAlias = tuple[int, int]

# Chunks in hand for each worker: the next ones, so that none waits.
AHEAD = 2


def done_chunks(
    job: Job, spans: Sequence[Span], engine: Engine = "threads", n_workers: int | None = None
) -> Iterator[tuple[int, Block]]:
    """Do chunks, and give each as soon as it is done with its place in ``spans``.

    Closing the iterator ends what has not begun.

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

    Returns
    -------
    iterator of (int, Block)
        In the order in which they come.

    Raises
    ------
    ParameterError
        If there is no such engine, or it cannot have so many workers.
    EngineError
        If a cluster cannot be reached or loses its workers.
    """
    check_engine(engine, n_workers)
    if engine == "threads":
        return _of_pool(_threads(n_workers), job, spans, n_workers)
    if engine == "processes":
        return _of_pool(_processes(n_workers, job), None, spans, n_workers)
    if isinstance(engine, str):
        return chunks_by_address(job, spans, engine)
    return chunks_by_client(job, spans, engine)


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


def _threads(n_workers: int | None) -> futures.Executor:
    return Threads(n_workers or cores())


def _processes(n_workers: int | None, job: Job) -> futures.Executor:
    _check_that_it_travels(job)
    return futures.ProcessPoolExecutor(
        n_workers or cores(),
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
    pool: futures.Executor, job: Job | None, spans: Sequence[Span], n_workers: int | None
) -> Iterator[tuple[int, Block]]:
    n = n_workers or cores()
    waiting = iter(range(len(spans)))
    running: dict[futures.Future[Block], int] = {}
    n_done = n_interrupts = 0
    is_over = False
    try:
        while True:
            try:
                # Few at a time: what is done waits in memory until it is taken.
                while n_interrupts == 0 and len(running) < AHEAD * n:
                    i = next(waiting, None)
                    if i is None:
                        break
                    running[pool.submit(_compute, job, spans[i])] = i
                if not running:
                    break
                done, _ = futures.wait(running, return_when=futures.FIRST_COMPLETED)
            except KeyboardInterrupt:
                n_interrupts += 1
                if n_interrupts > 1:
                    raise
                tell_of_stopping()
                running = {future: i for future, i in running.items() if not future.cancel()}
                continue
            for future in sorted(done, key=running.__getitem__):
                block = future.result()
                n_done += 1
                yield running.pop(future), block
        is_over = True
        if n_interrupts > 0:
            raise KeyboardInterrupt
    except BrokenProcessPool as error:
        if n_interrupts > 0:
            raise KeyboardInterrupt from error
        raise EngineError(_of_a_death(running, spans, n, n_done)) from error
    finally:
        for future in running:
            future.cancel()
        # The second may come while the first is still being told.
        is_dropped = n_interrupts > 0 and not is_over
        if is_dropped:
            _drop(pool)
        pool.shutdown(wait=not is_dropped, cancel_futures=True)


def _drop(pool: futures.Executor) -> None:
    """End the processes of a pool where they are; threads are left to themselves."""
    for process in list((getattr(pool, "_processes", None) or {}).values()):
        process.kill()


def _of_a_death(
    running: dict[futures.Future[Block], int], spans: Sequence[Span], n: int, n_done: int
) -> str:
    """Say what was at work when a worker died: of what was handed out, the first n."""
    left = [i for future, i in running.items() if not future.done() or future.exception()]
    points = [f"{spans[i][0]:,} to {spans[i][1] - 1:,}" for i in sorted(left)[:n]]
    reason = (
        "a worker process has died, by a crash, a signal or for want of memory, while these points "
        f"were at work: {', '.join(points)}"
    )
    return reason if n_done else f"{reason}; none was done before, and it may have said why above"
