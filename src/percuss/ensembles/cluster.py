"""Chunks of a job done by the workers of a Dask cluster, which may die and join."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Any

from percuss.ensembles.job import Block, Job
from percuss.errors import MissingExtraError, ParameterError, PercussError

__all__ = ["EngineError", "chunks_by_address", "chunks_by_client", "reach"]

# Seconds to reach a cluster.
CONNECT = 10.0
# Chunks that the scheduler has at a time: two for each thread of a worker, so that none waits, but
# this many in any case, from which a cluster that grows with its work knows how far to grow, as
# long as all copies of the job are not larger than this [bytes].
AHEAD, LEAST, MOST_BYTES = 2, 500, 64_000_000
# How often one looks for workers that have joined [s].
RENEWED = 1.0


class EngineError(PercussError):
    """The engine cannot be reached, or has lost its workers."""


def chunks_by_address(
    job: Job, spans: Sequence[tuple[int, int]], address: str
) -> Iterator[tuple[int, Block]]:
    """Do chunks on the cluster whose scheduler is at an address, as `done_chunks` does."""
    client = _client(address)
    try:
        yield from chunks_by_client(job, spans, client)
    finally:
        with contextlib.suppress(Exception):
            client.close()


def reach(address: str) -> None:
    """Raise an `EngineError` unless a scheduler answers at an address."""
    _client(address).close()


def _client(address: str) -> Any:
    distributed = _distributed()
    try:
        # As a default it would be asked for by whatever uses Dask next, and not be there.
        return distributed.Client(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        raise EngineError(f"no Dask scheduler answers at {address}: {error}") from error


def chunks_by_client(
    job: Job, spans: Sequence[tuple[int, int]], client: Any
) -> Iterator[tuple[int, Block]]:
    """Do chunks on the cluster of a client, as `done_chunks` does."""
    crowd = _Crowd(job, spans, client)
    try:
        yield from crowd.done()
    finally:
        crowd.cancel()


class _Crowd:
    """The chunks that a scheduler has."""

    def __init__(self, job: Job, spans: Sequence[tuple[int, int]], client: Any) -> None:
        self._job, self._spans, self._client = job, spans, client
        self._distributed = _distributed()
        self._least = max(1, min(LEAST, MOST_BYTES // _bytes_of(job)))
        self._waiting = list(range(len(spans)))[::-1]
        self._running: dict[Any, int] = {}
        self._most, self._looked = 0, -RENEWED

    def done(self) -> Iterator[tuple[int, Block]]:
        coming = self._distributed.as_completed(loop=self._client.loop)
        about = self._client.scheduler_info(n_workers=-1)
        if self._waiting and not about.get("workers"):
            # Theirs may be in a queue: it is no fault, but looks like one.
            sys.stderr.write(f"no workers yet at {about.get('address')}; waiting\n")
            sys.stderr.flush()
        while self._waiting or self._running:
            try:
                while self._waiting and len(self._running) < self._room():
                    coming.add(self._submit(self._waiting.pop()))
                future = next(coming)
                i = self._running.pop(future)
                block: Block = future.result()
            except self._distributed.KilledWorker as error:
                # Dask's own limit, `distributed.scheduler.allowed-failures`.
                raise EngineError(
                    f"the points from {self._spans[i][0]} on were lost with several workers of the "
                    "cluster, one after another; is their memory too small?"
                ) from error
            except Exception as error:
                # The connection, the scheduler, or a worker that cannot load the code.
                reason = f"the Dask cluster has failed: {type(error).__name__}: {error}"
                raise EngineError(reason) from error
            yield i, block

    def _submit(self, i: int) -> Any:
        future = self._client.submit(_compute, self._job, self._spans[i], pure=False)
        self._running[future] = i
        return future

    def _room(self) -> int:
        """Return how many chunks the scheduler should have; workers may have joined."""
        now = time.monotonic()
        if now - self._looked >= RENEWED:
            self._looked = now
            workers = self._client.scheduler_info(n_workers=-1).get("workers", {})
            threads = sum(int(worker["nthreads"]) for worker in workers.values())
            self._most = max(AHEAD * threads, self._least)
        return self._most

    def cancel(self) -> None:
        """Take back what has not been done."""
        # With the connection gone there is nobody to tell.
        with contextlib.suppress(Exception):
            self._client.cancel(list(self._running))


def _compute(job: Job, span: tuple[int, int]) -> Block:
    return job.compute(*span)


def _bytes_of(job: Job) -> int:
    """Return the size of what is sent for a chunk."""
    # A part of Dask, which sends by it what pickle alone cannot, as a lambda.
    import cloudpickle  # type: ignore[import-untyped]

    try:
        return max(1, len(cloudpickle.dumps(job)))
    except Exception as error:
        measure = getattr(job, "measure", None)
        if measure is None:
            raise
        name = getattr(measure, "__name__", measure)
        raise ParameterError("measure", name, f"cannot be sent to a worker: {error}") from error


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingExtraError("a Dask engine needs distributed", "cluster") from None
    return distributed
