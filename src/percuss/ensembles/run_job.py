"""The execution of a job: its missing chunks, on an engine, into a store where there is one."""

from __future__ import annotations

import contextlib
import inspect
import logging
from collections.abc import Callable, Generator, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from percuss.ensembles.array_parts import PartOfJob
from percuss.ensembles.cluster import EngineError
from percuss.ensembles.engines import Engine, check_engine, done_chunks, make_ready, say_stopping
from percuss.ensembles.job import (
    BYTES_OF_A_NUMBER,
    Answer,
    Block,
    Job,
    check_room,
    chunks_of,
    in_gigabytes,
    numbers_of,
)
from percuss.ensembles.store import RESULT, Store, has_store, keep_result, motions_of_a_point
from percuss.errors import OutputError, ParameterError
from percuss.execution import ArrayPart, Execution, folder_of, folder_of_parts
from percuss.progress import PATIENCE, Progress, Report, duration_text, rate_text

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

LOG = logging.getLogger(__name__)

# Work that takes longer than this [s] is announced once even without progress=True.
LONG = 600.0
# The size of an answer is announced before the work from so many bytes on.
LARGE = 1_000_000_000


def execution_of(
    store: str | Path | None,
    engine: Engine,
    n_workers: int | None,
    progress: Report,
    part: object = None,
) -> Execution:
    """Return the execution that the keywords of a call describe, each of them checked.

    Raises
    ------
    ParameterError
        If one of them is wrong.
    """
    folder = None if store is None else folder_of(store)
    check_engine(engine, n_workers)
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        reason = "neither True nor a function (done, total) -> bool"
        raise ParameterError("progress", progress, reason)
    of_array = None if part is None else ArrayPart.of(part)
    if of_array is not None:
        if folder is None:
            raise ParameterError("part", part, "needs store=, where the parts are put together")
        folder = folder_of_parts(folder) / of_array.name
    return Execution(folder, engine, n_workers, progress, of_array)


def keep(dataset: Dataset, execution: Execution) -> Dataset:
    """Keep a result in the store once it is complete, and return it."""
    store = execution.store
    if store is not None and dataset.attrs["complete"] and not (store / RESULT).exists():
        keep_result(store, dataset)
    return dataset


def run_job(job: Job, execution: Execution, *, is_read_from_disk: bool = False) -> Answer:
    """Compute the missing chunks of a job and return the whole answer.

    Ctrl-C, and a progress function that returns False, end it with the chunks that are done; with a
    store, the same call goes on from there.

    Parameters
    ----------
    job, execution
        What is computed, and how.
    is_read_from_disk
        Whether the answer may be larger than memory where there is a store.

    Returns
    -------
    Answer
        The same bits for all engines, numbers of workers and interruptions. Of a part of a job
        array no data, which stay in its store.
    """
    if execution.part is not None:
        job = PartOfJob(job, execution.part)
    with contextlib.closing(_keeper(job, execution, is_read_from_disk=is_read_from_disk)) as keeper:
        return _answer(job, keeper, execution)


def _answer(job: Job, keeper: Store | _Memory, execution: Execution) -> Answer:
    """Compute the missing chunks and return the whole answer."""
    todo, spans = _todo(keeper, execution.part), chunks_of(job)
    size = _points(job, _of_part(range(len(spans)), execution.part))
    progress = ChunkProgress(execution.progress, job, size, _points(job, todo), keeper.renew)
    is_interrupted = False
    chunks = _chunks(job, todo, execution, progress)
    try:
        LOG.info("%s", _begin_in_words(job, size, len(todo), execution))
        if execution.progress is not False and todo:
            _say_size(job, execution.store)
        for number, block in chunks:
            keeper.write(number, block)
            first, last = spans[number]
            LOG.debug("points %d to %d are done, %d impacts", first, last - 1, block.n_impacts)
            if not progress.chunk_done(last - first, block.n_impacts):
                break
    except EngineError as error:
        left = _points(job, _todo(keeper, execution.part))
        done = f"{size - left:,} of {size:,} points are done"
        kept = f"kept in {execution.store}: the same call goes on from there"
        lost = "lost; with store= they would be kept, and the same call would go on from there"
        raise EngineError(f"{error}; {done} and {kept if execution.store else lost}") from error
    except KeyboardInterrupt:
        is_interrupted = True
        if inspect.getgeneratorstate(chunks) == inspect.GEN_SUSPENDED:
            # It came between two chunks: the others are still at work.
            say_stopping()
    finally:
        chunks.close()
        progress.close()
    if is_interrupted:
        # A chunk that was being written may be done or not.
        left = _points(job, _todo(keeper, execution.part))
        progress.say_interrupted(size - left, execution.store)
    if execution.part is None:
        answer = keeper.read()
    else:
        n_done, n_impacts = keeper.done()
        n_motions = n_done * motions_of_a_point(job)
        answer = Answer({}, {}, n_impacts, complete=n_done == size, n_done=n_motions)
    LOG.info("%s, %d impacts", "complete" if answer.complete else "stopped", answer.n_impacts)
    if not (answer.complete or is_interrupted or progress.is_stopped or execution.store is None):
        reason = (
            "has lost chunks that were written: someone has removed them; the same call goes on"
        )
        raise OutputError(execution.store, reason)
    return answer


def _todo(keeper: Store | _Memory, part: ArrayPart | None) -> list[int]:
    """Return the numbers of the chunks that are left to this process."""
    return _of_part(keeper.todo(), part)


def _of_part(chunks: Iterable[int], part: ArrayPart | None) -> list[int]:
    """Return the chunks of a part: every n-th, so that all have their share of the slow ones."""
    return [i for i in chunks if part is None or i % part.count == part.number - 1]


def _begin_in_words(job: Job, size: int, n_todo: int, execution: Execution) -> str:
    part = "" if execution.part is None else f"part {execution.part}: "
    where = "" if execution.store is None else f", into {execution.store}"
    chunks = f"{n_todo:,} chunks of {job.chunk:,} are left"
    return f"{part}{size:,} points on {execution.engine}{where}; {chunks}"


def _keeper(job: Job, execution: Execution, *, is_read_from_disk: bool) -> Store | _Memory:
    """Return the store or the memory for the answer, once both it and the engine are ready."""
    store = execution.store
    is_new = store is not None and not has_store(store)
    on_disk = store if is_read_from_disk or execution.part is not None else None
    hint = "; with store= it is kept on disk" if is_read_from_disk and store is None else ""
    # A store that has been begun has its space already.
    if on_disk is None or is_new:
        check_room(job, on_disk, hint)
    make_ready(job, execution.engine, is_new=is_new)
    return _Memory(job) if store is None else Store(store, job)


def _chunks(
    job: Job, todo: Sequence[int], execution: Execution, progress: Progress
) -> Generator[tuple[int, Block], None, None]:
    """Yield the missing chunks with their numbers, each as soon as it is done."""
    if todo:
        spans = chunks_of(job)
        left = [spans[number] for number in todo]
        done = done_chunks(job, left, execution.engine, execution.n_workers, progress.tick)
        with contextlib.closing(done):
            for place, block in done:
                yield todo[place], block


def _points(job: Job, chunks: Sequence[int]) -> int:
    """Return the number of points in some chunks."""
    spans = chunks_of(job)
    return sum(spans[i][1] - spans[i][0] for i in chunks)


class ChunkProgress(Progress):
    """The progress of a job in points, with the rate of impacts and the time left."""

    def __init__(
        self, report: Report, job: Job, size: int, n_todo: int, renew: Callable[[], None]
    ) -> None:
        units = getattr(job, "each", "points")
        super().__init__(report, size, units, done=size - n_todo)
        self._is_silent, self._n_impacts = report is None, 0
        self._renew = renew

    def tick(self, text: str | Callable[[], str] = "") -> bool:
        """Report by the clock, and renew the lock of the store."""
        self._renew()
        return super().tick(text)

    def chunk_done(self, n_points: int, n_impacts: int) -> bool:
        """Count a chunk; return whether to go on."""
        # The first chunk may have had to compile: the rate is that of the others.
        since = self.since_first()
        self._n_impacts += n_impacts if since > 0.0 else 0
        rate = rate_text(self._n_impacts / since) if since > 0.0 else ""
        is_wanted = self.advance(n_points, f"{rate} impacts/s" if rate else "")
        if self._is_silent and since > PATIENCE and self.seconds_left() > LONG:
            self._is_silent = False
            LOG.warning(
                f"{duration_text(self.seconds_left())} left for {self.total:,} points at the rate "
                "of the first chunks; progress=True shows how far it is, store= keeps what is done"
            )
        return is_wanted

    def say_interrupted(self, done: int, store: Path | None) -> None:
        """Report how many points are done after an interruption, and where they are."""
        kept = f"kept in {store}: the same call goes on from there" if store else "returned"
        LOG.warning(f"interrupted; {done:,} of {self.total:,} {self._units} are done and {kept}")


def _say_size(job: Job, store: Path | None) -> None:
    """Announce the size of a large answer before the work."""
    size = BYTES_OF_A_NUMBER * numbers_of(job) * job.size
    if size >= LARGE:
        where = "of memory" if store is None else f"in {store}"
        LOG.warning(
            f"{job.size:,} points in chunks of {job.chunk:,}, whose answer takes "
            f"{in_gigabytes(size)} {where}"
        )


class _Memory:
    """The answer in memory, for jobs without a store; it has the methods of a `Store`."""

    def __init__(self, job: Job) -> None:
        # Filled at the end, and only where no chunk came: writing a large answer takes seconds.
        self._arrays = {
            name: np.empty((job.size, *column.tail), dtype=column.dtype)
            for name, column in job.columns.items()
        }
        self._columns = job.columns
        self._spans = chunks_of(job)
        self._left = dict.fromkeys(range(len(self._spans)))
        self._reasons: dict[int, str] = {}
        self._n_impacts = 0

    def todo(self) -> list[int]:
        return list(self._left)

    def write(self, number: int, block: Block) -> None:
        first, last = self._spans[number]
        for name, array in self._arrays.items():
            array[first:last] = block.arrays[name]
        self._reasons |= {first + i: text for i, text in block.reasons.items()}
        self._n_impacts += block.n_impacts
        del self._left[number]

    def renew(self) -> None:
        """Do nothing: no other process writes into this memory."""

    def close(self) -> None:
        """Do nothing."""

    def done(self) -> tuple[int, int]:
        left = sum(self._spans[i][1] - self._spans[i][0] for i in self._left)
        return self._spans[-1][1] - left, self._n_impacts

    def read(self) -> Answer:
        reasons = dict(sorted(self._reasons.items()))
        for number in self._left:
            first, last = self._spans[number]
            for name, array in self._arrays.items():
                array[first:last] = self._columns[name].empty(last - first)
        return Answer(self._arrays, reasons, self._n_impacts, complete=not self._left)
