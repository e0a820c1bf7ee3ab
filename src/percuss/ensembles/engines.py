"""Where the chunks of a job are done: threads, processes, or the workers of a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import pickle
from collections.abc import Iterator, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeAlias

from percuss.ensembles.job import Block, Job
from percuss.errors import MissingExtraError, ParameterError, PercussError

__all__ = ["Engine", "EngineError", "done_chunks"]

# "threads", "processes", the address of a Dask scheduler, or a `distributed.Client`.
Engine: TypeAlias = Any
Span: TypeAlias = tuple[int, int]

# Chunks in hand for each worker: the next ones, so that none waits.
AHEAD = 2
# Seconds to reach a cluster.
CONNECT = 10.0
# A worker that dies takes its chunk along so many times before the chunk is given up.
RETRIES = 10


class EngineError(PercussError):
    """The engine cannot be reached, or has lost its workers."""


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
        If there is no such engine.
    EngineError
        If a cluster cannot be reached or loses its workers.
    """
    if engine == "threads":
        return _of_pool(_threads(n_workers), job, spans, n_workers)
    if engine == "processes":
        return _of_pool(_processes(n_workers, job), None, spans, n_workers)
    if isinstance(engine, str) and "://" in engine:
        return _of_address(job, spans, engine)
    if hasattr(engine, "submit") and hasattr(engine, "scheduler_info"):
        return _of_client(job, spans, engine)
    reason = 'neither "threads" nor "processes", nor a Dask client or its address ("tcp://...")'
    raise ParameterError("engine", engine, reason)


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _threads(n_workers: int | None) -> futures.Executor:
    return futures.ThreadPoolExecutor(n_workers or cores(), thread_name_prefix="percuss")


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


def _compute(job: Job | None, span: Span) -> Block:
    return (job or _JOB[0]).compute(*span)


def _of_pool(
    pool: futures.Executor, job: Job | None, spans: Sequence[Span], n_workers: int | None
) -> Iterator[tuple[int, Block]]:
    waiting = iter(range(len(spans)))
    running: dict[futures.Future[Block], int] = {}
    try:
        while True:
            # Few at a time: what is done waits in memory until it is taken.
            while len(running) < AHEAD * (n_workers or cores()):
                i = next(waiting, None)
                if i is None:
                    break
                running[pool.submit(_compute, job, spans[i])] = i
            if not running:
                return
            done, _ = futures.wait(running, return_when=futures.FIRST_COMPLETED)
            for future in sorted(done, key=running.__getitem__):
                yield running.pop(future), future.result()
    except BrokenProcessPool as error:
        raise EngineError(f"a worker process has died: {error}") from error
    finally:
        for future in running:
            future.cancel()
        pool.shutdown(wait=True, cancel_futures=True)


def _of_address(job: Job, spans: Sequence[Span], address: str) -> Iterator[tuple[int, Block]]:
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise EngineError(
            f"no Dask scheduler answers at {address} within {CONNECT:g} s: {error}"
        ) from error
    try:
        yield from _of_client(job, spans, client)
    finally:
        client.close()


def _of_client(job: Job, spans: Sequence[Span], client: Any) -> Iterator[tuple[int, Block]]:
    distributed = _distributed()
    waiting = iter(range(len(spans)))
    running: dict[Any, int] = {}

    def submit() -> Any:
        i = next(waiting, None)
        if i is None:
            return None
        future = client.submit(_compute, job, spans[i], pure=False, retries=RETRIES)
        running[future] = i
        return future

    try:
        first = [submit() for _ in range(min(len(spans), AHEAD * _n_threads(client)))]
        done = distributed.as_completed([future for future in first if future is not None])
        for future in done:
            yield running.pop(future), _result_of(future, distributed)
            following = submit()
            if following is not None:
                done.add(following)
    finally:
        for future in running:
            future.cancel()


def _result_of(future: Any, distributed: Any) -> Block:
    try:
        block: Block = future.result()
    except distributed.KilledWorker as error:
        raise EngineError(f"a chunk was lost with {RETRIES} workers, one after another") from error
    return block


def _n_threads(client: Any) -> int:
    workers = client.scheduler_info(n_workers=-1)["workers"]
    return max(1, sum(int(worker["nthreads"]) for worker in workers.values()))


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingExtraError("a Dask engine needs distributed", "cluster") from None
    return distributed
