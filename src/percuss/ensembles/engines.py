"""The engines that compute the chunks of a job: threads, processes, or a Dask cluster."""

from __future__ import annotations

import ast
import logging
import multiprocessing
import os
import pickle
import pickletools
import signal
import sys
import traceback
import types
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent import futures
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeAlias

from percuss.ensembles.cluster import EngineError, chunks_by_address, chunks_by_client, reach
from percuss.ensembles.job import Block, Job
from percuss.ensembles.threads import Threads, UnwantedError
from percuss.errors import ParameterError
from percuss.model.exact import whole

# "threads", "processes", the address of a Dask scheduler, or a `distributed.Client`.
Engine: TypeAlias = Any
ChunkRange: TypeAlias = tuple[int, int]
Tick: TypeAlias = Callable[[], bool]

LOG = logging.getLogger(__name__)

# Chunks submitted for each worker: one to work on and the next, so that no worker waits.
AHEAD = 2
# Seconds between two calls of tick while no chunk is finished, and the longest wait for chunks that
# are no longer wanted.
TICK, GRACE = 0.5, 1.0
# The guard under which a script may begin other processes.
GUARD = 'if __name__ == "__main__":'
# A chunk that has killed so many worker processes is not tried again.
MOST_DEATHS = 3


def done_chunks(
    job: Job,
    spans: Sequence[ChunkRange],
    engine: Engine = "threads",
    n_workers: int | None = None,
    tick: Tick | None = None,
) -> Generator[tuple[int, Block], None, None]:
    """Compute chunks, and yield each as soon as it is done, with its place in ``spans``.

    Closing the generator abandons the chunks that are not finished.

    Parameters
    ----------
    job
        The job.
    spans
        First and last point of each chunk to compute.
    engine
        "threads", "processes", the address of a Dask scheduler ("tcp://..."), or a client of one.
    n_workers
        Threads or processes; default: the cores that this process may use.
    tick
        Called every half second while no chunk is finished; False ends the generator.

    Returns
    -------
    generator of (int, Block)
        In the order in which they are finished.

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
        return _Pool(lambda: Threads(n), job.compute, spans, n).done(tick)
    if engine == "processes":
        check_processes(job)
        return _Pool(lambda: process_pool(n, job), compute_remembered, spans, n).done(tick)
    if isinstance(engine, str):
        return chunks_by_address(job, spans, engine, tick)
    return chunks_by_client(job, spans, engine, tick)


def say_stopping() -> None:
    """Acknowledge Ctrl-C at once: the chunks at work may take a while."""
    if sys.stderr.isatty():
        # Behind the "^C" that the terminal shows.
        sys.stderr.write("\n")
    LOG.warning("stopping after the chunks at work; Ctrl-C again drops them")


def _goes_on() -> bool:
    return True


def check_engine(engine: Engine, n_workers: int | None) -> None:
    """Raise a `ParameterError` unless there is such an engine, and it can have so many workers."""
    if n_workers is not None:
        whole("n_workers", n_workers, 1)
    is_named = isinstance(engine, str) and (engine in ("threads", "processes") or "://" in engine)
    is_client = hasattr(engine, "submit") and hasattr(engine, "scheduler_info")
    if not (is_named or is_client):
        reason = 'neither "threads" nor "processes", nor a Dask client or its address ("tcp://...")'
        raise ParameterError("engine", engine, reason)


def make_ready(job: Job, engine: Engine, *, is_new: bool) -> None:
    """Make sure that the engine can begin, before anything is written.

    Parameters
    ----------
    job, engine
        As `done_chunks` takes them.
    is_new
        Whether no chunk is done yet: a finished study needs no cluster.

    Raises
    ------
    ParameterError
        If other processes cannot begin from the caller's script, or do not find its functions.
    EngineError
        If no cluster answers.
    """
    if engine == "processes":
        check_processes(job)
    elif is_new and isinstance(engine, str) and "://" in engine:
        reach(engine)


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Pool:
    """The chunks of a job in a pool of threads or processes."""

    def __init__(
        self,
        make: Callable[[], futures.Executor],
        compute: Callable[[int, int], Block],
        spans: Sequence[ChunkRange],
        n: int,
    ) -> None:
        self._make, self._compute, self._spans = make, compute, spans
        self._queue = _Queue(len(spans), n)
        self._running: dict[futures.Future[Block], int] = {}
        self._is_interrupted = False

    def done(self, tick: Tick) -> Generator[tuple[int, Block], None, None]:
        """Yield chunks as they are finished, with their places; as `done_chunks` does."""
        is_over = False
        self._pool = self._make()
        try:
            while True:
                done: set[futures.Future[Block]] = set()
                try:
                    is_broken = not self._submit()
                    if not (self._running or is_broken):
                        break
                    if not is_broken:
                        done, _ = futures.wait(
                            self._running, TICK, return_when=futures.FIRST_COMPLETED
                        )
                        if not done and not tick():
                            return
                except KeyboardInterrupt:
                    self._interrupt()
                    continue
                lost = {future for future in done if _is_lost(future)}
                for future in sorted(done - lost, key=self._running.__getitem__):
                    place = self._running.pop(future)
                    if self._is_interrupted and isinstance(future.exception(), UnwantedError):
                        # A chunk that takes long has given up.
                        continue
                    yield place, future.result()
                if lost or is_broken:
                    self._begin_again()
            is_over = True
            if self._is_interrupted:
                raise KeyboardInterrupt
        finally:
            for future in self._running:
                future.cancel()
            # A second Ctrl-C may come while the first is still being handled.
            if is_over:
                self._pool.shutdown(wait=True)
            else:
                _drop(self._pool)

    def _submit(self) -> bool:
        """Submit chunks while the pool has room; return whether it has accepted them."""
        while not self._is_interrupted and self._queue.has_next(len(self._running)):
            i = self._queue.take()
            try:
                self._running[self._pool.submit(self._compute, *self._spans[i])] = i
            except BrokenProcessPool:
                self._queue.take_back([i])
                return False
        return True

    def _interrupt(self) -> None:
        """Submit no more; wait for the chunks at work, until a second Ctrl-C."""
        if self._is_interrupted:
            raise KeyboardInterrupt
        self._is_interrupted = True
        say_stopping()
        if isinstance(self._pool, Threads):
            self._pool.end_soon()
        self._running = {future: i for future, i in self._running.items() if not future.cancel()}

    def _begin_again(self) -> None:
        """Make a new pool: the death of one process breaks the whole pool."""
        if self._is_interrupted:
            raise KeyboardInterrupt
        futures.wait(self._running)
        lost = {future: i for future, i in self._running.items() if _is_lost(future)}
        self._running = {future: i for future, i in self._running.items() if future not in lost}
        self._queue.note_death(sorted(lost.values()), self._spans)
        self._pool.shutdown(wait=False)
        self._pool = self._make()


class _Queue:
    """The order of the chunks: a chunk during which a process has died is tried again alone."""

    def __init__(self, count: int, n: int) -> None:
        self._waiting = deque(range(count))
        self._suspects: deque[int] = deque()
        self._alone: int | None = None
        self._deaths: Counter[int] = Counter()
        self._n = n

    def has_next(self, running: int) -> bool:
        """Return whether to submit one more while so many are at work."""
        if running == 0:
            self._alone = None
        if self._suspects or self._alone is not None:
            # If a process dies now, it is clear of which chunk.
            return running == 0
        # Few at a time: finished chunks wait in memory until they are taken.
        return bool(self._waiting) and running < AHEAD * self._n

    def take(self) -> int:
        """Return the next chunk."""
        if self._suspects:
            self._alone = self._suspects.popleft()
            return self._alone
        return self._waiting.popleft()

    def take_back(self, chunks: Sequence[int]) -> None:
        """Put chunks back at the front."""
        self._waiting.extendleft(reversed(chunks))

    def note_death(self, lost: Sequence[int], spans: Sequence[ChunkRange]) -> None:
        """Put lost chunks back, of which the first n were at work.

        Raises
        ------
        EngineError
            If one of them has killed too many processes.
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
        LOG.warning(
            f"a worker process has died while these points were at work: {points}; they are done "
            "again"
        )
        self._suspects.extend(at_work)
        self._alone = None
        self.take_back(lost[len(at_work) :])


def _is_lost(future: futures.Future[Block]) -> bool:
    return future.done() and isinstance(future.exception(), BrokenProcessPool)


def _drop(pool: futures.Executor) -> None:
    """Abandon the work in progress: processes at once, threads at their next step."""
    if isinstance(pool, Threads):
        pool.drop(GRACE)
        return
    for process in list((getattr(pool, "_processes", None) or {}).values()):
        process.kill()
    pool.shutdown(wait=False, cancel_futures=True)


# The job of this worker process, sent once when it began.
_remembered: list[Job] = []


def process_pool(n: int, job: Job) -> futures.Executor:
    """Return a pool of n processes, each of which keeps the job."""
    return futures.ProcessPoolExecutor(
        n,
        # Forking a process whose threads hold locks can hang it.
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_remember,
        initargs=(job,),
    )


def _remember(job: Job) -> None:
    _remembered[:] = [job]
    # Ctrl-C reaches all processes of a terminal; the calling process handles it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def compute_remembered(first: int, last: int) -> Block:
    """Compute a chunk of the job that this worker process keeps."""
    return _remembered[0].compute(first, last)


def check_processes(job: Job) -> None:
    """Raise a `ParameterError` unless worker processes can begin and find the job's function.

    A process that is spawned imports the caller's script first, under another name than
    ``__main__``, and takes functions from there by their names.
    """
    measure = getattr(job, "measure", None)
    shown = getattr(measure, "__name__", measure)
    try:
        sent = pickle.dumps(job)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        if measure is None:
            raise
        reason = (
            "cannot be sent to another process, which takes functions by the name that they have "
            'in a module; define it with def in a module, or take engine="threads"'
        )
        raise ParameterError("measure", shown, reason) from error
    words = {word for _, word, _ in pickletools.genops(sent) if isinstance(word, str)}
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    if file is not None and not Path(file).is_file():
        reason = (
            f"begins other processes, which import the script that asks for them, and {file} is "
            'no file; save it as one, or take engine="threads"'
        )
        raise ParameterError("engine", "processes", reason)
    if file is not None:
        _check_script(main, Path(file), words if "__main__" in words else set())
    elif "__main__" in words:
        reason = (
            "defined where no other process can import it, in a notebook, a session or a text "
            "given to python; put it into a file of its own and import it from there, or take "
            'engine="threads"'
        )
        raise ParameterError("measure", shown, reason)


def _check_script(main: types.ModuleType, file: Path, words: set[str]) -> None:
    """Raise unless a script asks for processes under its guard, and defines functions above it."""
    try:
        nodes = list(ast.walk(ast.parse(file.read_bytes())))
    except (OSError, SyntaxError, ValueError):
        return
    guards = [
        node for node in nodes if isinstance(node, ast.If) and "__name__" in ast.unparse(node.test)
    ]
    for frame, line in traceback.walk_stack(None):
        is_script = frame.f_code.co_name == "<module>" and frame.f_globals is vars(main)
        if is_script and not any(
            guard.lineno <= line <= (guard.end_lineno or line) for guard in guards
        ):
            reason = (
                f"begins other processes, which import {file.name} and would come to its line "
                f"{line} again; put what the script does under `{GUARD}`"
            )
            raise ParameterError("engine", "processes", reason)
    under = _defined(node for guard in guards for node in ast.walk(guard))
    hidden = set(under) & words
    if any(under.count(name) == _defined(nodes).count(name) for name in hidden):
        reason = (
            f"defined under `{GUARD}`, where other processes do not see it; "
            "define it above that line"
        )
        raise ParameterError("measure", min(hidden), reason)


def _defined(nodes: Iterable[ast.AST]) -> list[str]:
    return [node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)]
