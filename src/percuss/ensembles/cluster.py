"""Chunks of a job done by the workers of a Dask cluster, which may die and join."""

from __future__ import annotations

import contextlib
import queue
import sys
import time
from collections.abc import Callable, Generator, Sequence
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
# How often one looks for workers that have joined, and up while no chunk is finished [s].
RENEWED, TICK = 1.0, 0.5
# Workers send a sign of life every second or so. How long they may be silent until it is said,
# how often it is said again, and how long the scheduler may take to answer [s].
SILENT, AGAIN, ANSWER = 5.0, 30.0, 3.0
# How long a worker may take to hand over a chunk until others are asked, at first and at last [s].
RESULT, LONGEST_RESULT = 1.0, 16.0


class EngineError(PercussError):
    """The engine cannot be reached, or has lost its workers."""


def chunks_by_address(
    job: Job, spans: Sequence[tuple[int, int]], address: str, tick: Callable[[], bool]
) -> Generator[tuple[int, Block], None, None]:
    """Do chunks on the cluster whose scheduler is at an address, as `done_chunks` does."""
    client = _client(address)
    try:
        yield from chunks_by_client(job, spans, client, tick)
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
    job: Job, spans: Sequence[tuple[int, int]], client: Any, tick: Callable[[], bool]
) -> Generator[tuple[int, Block], None, None]:
    """Do chunks on the cluster of a client, as `done_chunks` does."""
    submitted = _Submitted(job, spans, client)
    try:
        yield from submitted.done(tick)
    finally:
        submitted.cancel()


class _Submitted:
    """The chunks that a scheduler has."""

    def __init__(self, job: Job, spans: Sequence[tuple[int, int]], client: Any) -> None:
        self._job, self._spans, self._client = job, spans, client
        self._distributed = _distributed()
        self._least = max(1, min(LEAST, MOST_BYTES // _bytes_of(job)))
        self._waiting = list(range(len(spans)))[::-1]
        self._running: dict[Any, int] = {}
        self._most, self._looked = 0, -RENEWED
        self._finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._last_answer = time.monotonic()
        self._said: float | None = None
        self._patience: dict[Any, float] = {}

    def done(self, tick: Callable[[], bool]) -> Generator[tuple[int, Block], None, None]:
        about = self._asked()
        if self._waiting and about is not None and not about["workers"]:
            # Theirs may be in a queue: it is no fault, but looks like one.
            self._say("no workers yet")
        while self._waiting or self._running:
            try:
                while self._waiting and len(self._running) < self._wanted():
                    self._submit(self._waiting.pop())
                future = self._next(tick)
                if future is None:
                    return
                patience = self._patience.get(future, RESULT)
                i = self._running[future]
                block: Block = future.result(patience)
                del self._running[future]
            except EngineError:
                raise
            except TimeoutError:
                # The worker that has the result may be frozen; others do not wait for it.
                self._patience[future] = min(2.0 * patience, LONGEST_RESULT)
                self._finished.put(future)
                self._look_for_silent_workers()
                if not tick():
                    return
                continue
            except self._distributed.KilledWorker as error:
                # Dask's own limit, `distributed.scheduler.allowed-failures`.
                raise EngineError(
                    f"the points from {self._spans[i][0]} on were lost with several workers of the "
                    "cluster, one after another; is their memory too small?"
                ) from error
            except Exception as error:
                # The connection, the scheduler, or a worker that cannot load the code.
                words = " ".join(str(error).split()).rstrip(".")
                reason = f"the Dask cluster has failed: {type(error).__name__}: {words}"
                raise EngineError(reason) from error
            yield i, block

    def _submit(self, i: int) -> None:
        future = self._client.submit(_compute, self._job, self._spans[i], pure=False)
        self._running[future] = i
        future.add_done_callback(self._finished.put)

    def _next(self, tick: Callable[[], bool]) -> Any:
        """Return the next future that is done, None where it is wanted no more."""
        while True:
            try:
                return self._finished.get(timeout=TICK)
            except queue.Empty:
                if not tick():
                    return None
                self._look_for_silent_workers()

    def _asked(self) -> dict[str, Any] | None:
        """Return what the scheduler says of its workers, None while it does not answer.

        Raises
        ------
        EngineError
            If the connection to it is gone.
        """
        if self._client.status not in ("running", "connecting"):
            raise EngineError(
                "the Dask cluster has failed: the connection to its scheduler is gone"
            )
        try:
            about: dict[str, Any] = self._client.sync(
                self._client.scheduler.identity, n_workers=-1, callback_timeout=ANSWER
            )
        except (TimeoutError, OSError):
            return None
        return about | {"workers": about.get("workers", {})}

    def _look_for_silent_workers(self) -> None:
        """Say so if no worker answers; the run goes on if one returns."""
        now = time.monotonic()
        if now - self._looked < RENEWED:
            return
        self._looked = now
        about = self._asked()
        if about is None:
            silence = now - self._last_answer
            if silence >= SILENT:
                self._say(f"the scheduler has not answered for {silence:.0f} s")
            return
        self._last_answer = now
        workers = about["workers"].values()
        silent = [time.time() - worker["last_seen"] for worker in workers]
        late = [seconds for seconds in silent if seconds >= SILENT]
        if not silent:
            self._say("no workers")
        elif late:
            self._say(
                f"nothing has been heard of {len(late)} of {len(silent)} workers for "
                f"{max(late):.0f} s, which are frozen, cut off or too busy"
            )
        else:
            self._said = None

    def _say(self, what: str) -> None:
        now = time.monotonic()
        if self._said is None or now - self._said >= AGAIN:
            self._said = now
            sys.stderr.write(
                f"{what} at {self._client.scheduler.address}; waiting: the run goes on when "
                "workers answer or join (dask worker ADDRESS), and Ctrl-C ends it\n"
            )
            sys.stderr.flush()

    def _wanted(self) -> int:
        """Return how many chunks the scheduler should have; workers may have joined."""
        now = time.monotonic()
        if now - self._looked >= RENEWED:
            self._looked = now
            about = self._asked()
            workers = about["workers"] if about is not None else {}
            threads = sum(int(worker["nthreads"]) for worker in workers.values())
            self._most = max(AHEAD * threads, self._least)
        return self._most

    def cancel(self) -> None:
        """Take back what has not been done."""
        # With the connection gone there is nobody to tell; who is frozen does not answer.
        with contextlib.suppress(Exception):
            self._client.sync(self._client._cancel, list(self._running), callback_timeout=ANSWER)


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
