"""Chunks of a job on the workers of a Dask cluster, which may die and join."""

from __future__ import annotations

import contextlib
import logging
import queue
import time
from collections.abc import Callable, Generator, Sequence
from typing import Any

from percuss.ensembles.job import Block, Job
from percuss.errors import MissingExtraError, ParameterError, PercussError

LOG = logging.getLogger(__name__)

# Seconds to reach a cluster.
CONNECT = 10.0
# Chunks submitted at a time: two for each thread of a worker, so that no thread waits, and at least
# 500, from which an adaptive cluster sees how far to grow; but no more copies of the job than take
# so many bytes.
AHEAD, LEAST, MOST_BYTES = 2, 500, 64_000_000
# Seconds between two requests for the list of workers, and between two calls of tick.
RENEWED, TICK = 1.0, 0.5
# A worker sends a heartbeat every second or so. Silence after which the user is told, time until
# the message is repeated, and time that the scheduler has to answer [s].
SILENT, AGAIN, ANSWER = 5.0, 30.0, 3.0
# Time that a worker has to hand over a chunk before others are asked, at first and at most [s].
RESULT, LONGEST_RESULT = 1.0, 16.0


class EngineError(PercussError):
    """The engine cannot be reached, or has lost its workers."""


def chunks_by_address(
    job: Job, spans: Sequence[tuple[int, int]], address: str, tick: Callable[[], bool]
) -> Generator[tuple[int, Block], None, None]:
    """Compute chunks on the cluster whose scheduler is at an address, as `done_chunks` does."""
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
    client = distributed.Client.__new__(distributed.Client)
    try:
        # As the default client it would be used by the next call of Dask, after it is closed.
        client.__init__(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        # The garbage collector would close it at any time, even while the next client begins and
        # holds the lock that this waits for.
        with contextlib.suppress(Exception):
            client.close()
        raise EngineError(f"no Dask scheduler answers at {address}: {error}") from error
    return client


def chunks_by_client(
    job: Job, spans: Sequence[tuple[int, int]], client: Any, tick: Callable[[], bool]
) -> Generator[tuple[int, Block], None, None]:
    """Compute chunks on the cluster of a client, as `done_chunks` does."""
    submitted = _Submitted(job, spans, client)
    try:
        yield from submitted.done(tick)
    finally:
        submitted.cancel()


class _Submitted:
    """The chunks submitted to a scheduler."""

    def __init__(self, job: Job, spans: Sequence[tuple[int, int]], client: Any) -> None:
        self._job, self._spans, self._client = job, spans, client
        self._distributed = _distributed()
        self._least = max(1, min(LEAST, MOST_BYTES // _bytes_of(job)))
        self._waiting = list(range(len(spans)))[::-1]
        self._running: dict[Any, int] = {}
        self._most, self._renewed = 0, -RENEWED
        self._finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._last_answer = time.monotonic()
        self._said: float | None = None
        self._patience: dict[Any, float] = {}

    def done(self, tick: Callable[[], bool]) -> Generator[tuple[int, Block], None, None]:
        about = self._about()
        if self._waiting and about is not None and not about["workers"]:
            # They may still wait in a queue.
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
                # The worker that holds the result may be frozen; the other chunks go on.
                self._patience[future] = min(2.0 * patience, LONGEST_RESULT)
                self._finished.put(future)
                self._report_silent_workers()
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
        """Return the next finished future, None once tick has returned False."""
        while True:
            try:
                return self._finished.get(timeout=TICK)
            except queue.Empty:
                if not tick():
                    return None
                self._report_silent_workers()

    def _about(self) -> dict[str, Any] | None:
        """Return the description of the workers by the scheduler, None while it does not answer.

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

    def _report_silent_workers(self) -> None:
        """Report workers that do not answer; the run goes on if they return."""
        now = time.monotonic()
        if now - self._renewed < RENEWED:
            return
        self._renewed = now
        about = self._about()
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
            LOG.warning(
                f"{what} at {self._client.scheduler.address}; waiting: the run goes on when "
                "workers answer or join (dask worker ADDRESS), and Ctrl-C ends it"
            )

    def _wanted(self) -> int:
        """Return how many chunks the scheduler should hold for the workers it has now."""
        now = time.monotonic()
        if now - self._renewed >= RENEWED:
            self._renewed = now
            about = self._about()
            workers = about["workers"] if about is not None else {}
            threads = sum(int(worker["nthreads"]) for worker in workers.values())
            self._most = max(AHEAD * threads, self._least)
        return self._most

    def cancel(self) -> None:
        """Cancel the chunks that are not finished."""
        # Fails where the connection is lost or the scheduler frozen.
        with contextlib.suppress(Exception):
            self._client.sync(self._client._cancel, list(self._running), callback_timeout=ANSWER)


def _compute(job: Job, span: tuple[int, int]) -> Block:
    return job.compute(*span)


def _bytes_of(job: Job) -> int:
    """Return the size of the message that submits a chunk."""
    # A dependency of Dask, which pickles functions by it that pickle cannot, such as lambdas.
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
