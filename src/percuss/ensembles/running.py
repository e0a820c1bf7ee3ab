"""Do a job: what is left of it, on an engine, into a store where there is one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from percuss.ensembles.checks import check_means
from percuss.ensembles.engines import (
    Engine,
    EngineError,
    done_chunks,
    make_ready,
    say_stopping,
)
from percuss.ensembles.job import Answer, Block, Job, check_room, chunks_of, numbers_of
from percuss.ensembles.sizes import NUMBER, in_gigabytes
from percuss.ensembles.store import RESULT, Store, has_store, keep_result
from percuss.errors import OutputError
from percuss.progress import PATIENCE, Progress, Report, duration_text, rate_text

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["Report", "keep", "run_job", "unanswered"]

# What takes longer than this [s] is said once where no progress was asked for.
LONG = 600.0
# An answer of so many bytes is told before the work.
LARGE = 1_000_000_000


def run_job(
    job: Job,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
    *,
    is_read_from_disk: bool = False,
) -> Answer:
    """Do what is left of a job and return the whole answer.

    Ctrl-C, and a progress function that returns False, end it with what is done; with a store,
    the same call goes on from there.

    Parameters
    ----------
    job
        The job.
    store
        Folder of a store; None keeps the answer in memory alone.
    engine, n_workers
        As `done_chunks` takes them.
    progress
        True shows a line on the error stream after two seconds, with the rate and the time
        left; a function ``(done, total) -> bool`` is called with numbers of points after each
        chunk, and at least every 1.5 s while none is finished.
    is_read_from_disk
        Whether the answer may be larger than memory where there is a store.

    Returns
    -------
    Answer
        The same bits whatever the engine, the workers and the interruptions.
    """
    # Before there is a store.
    check_means(store, engine, n_workers, progress)
    on_disk = Path(store) if store is not None and is_read_from_disk else None
    hint = "; with store= it is kept on disk" if is_read_from_disk else ""
    if on_disk is None or not has_store(on_disk):
        # What has been begun has taken its room already.
        check_room(job, on_disk, hint if store is None else "")
    spans = chunks_of(job)
    make_ready(job, engine, is_new=store is not None and not has_store(Path(store)))
    keeper = _Memory(job, spans) if store is None else Store(store, job)
    todo = keeper.todo()
    reported = _ChunkProgress(progress, job, _size(spans, todo))
    if progress is not False and todo:
        _tell_size(job, store)
    is_interrupted = False
    those = [spans[i] for i in todo]
    coming = done_chunks(job, those, engine, n_workers, reported.tick) if todo else iter(())
    try:
        for place, block in coming:
            keeper.write(todo[place], block)
            first, last = spans[todo[place]]
            if not reported.chunk_done(last - first, block.n_impacts):
                break
    except EngineError as error:
        done = f"{job.size - _size(spans, keeper.todo()):,} of {job.size:,} points are done"
        kept = f"kept in {store}: the same call goes on from there"
        lost = "lost; with store= they would be kept, and the same call would go on from there"
        raise EngineError(f"{error}; {done} and {kept if store else lost}") from error
    except KeyboardInterrupt:
        is_interrupted = True
        if getattr(coming, "gi_frame", None) is not None:
            # It came between two chunks: those at work have still to end.
            say_stopping()
    finally:
        close = getattr(coming, "close", None)
        if close is not None:
            close()
        reported.close()
    if is_interrupted:
        # What was being written then may be done or not.
        reported.say_interrupted(job.size - _size(spans, keeper.todo()), store)
    answer = keeper.read()
    if store is not None and not (answer.complete or is_interrupted or reported.is_stopped):
        reason = (
            "has lost chunks that were written: someone has removed them; the same call goes on"
        )
        raise OutputError(store, reason)
    return answer


class _ChunkProgress(Progress):
    """The points of a job that are done, with the rate of impacts and the time left."""

    def __init__(self, report: Report, job: Job, n_todo: int) -> None:
        units = getattr(job, "each", "points")
        super().__init__(report, job.size, units, done=job.size - n_todo)
        self._is_silent, self._n_impacts = report is None, 0

    def chunk_done(self, n_points: int, n_impacts: int) -> bool:
        """Count a chunk; return whether to go on."""
        # The first one may have had to compile: the rate is that of the others.
        since = self.since_first()
        self._n_impacts += n_impacts if since > 0.0 else 0
        rate = rate_text(self._n_impacts / since) if since > 0.0 else ""
        is_wanted = self.advance(n_points, f"{rate} impacts/s" if rate else "")
        if self._is_silent and since > PATIENCE and self.seconds_left() > LONG:
            self._is_silent = False
            _say(
                f"{duration_text(self.seconds_left())} left for {self.total:,} points at the rate "
                "of the first chunks; progress=True shows how far it is, store= keeps what is done"
            )
        return is_wanted

    def say_interrupted(self, done: int, store: str | Path | None) -> None:
        """Say what an interruption has left: so many points, in a store or in hand."""
        kept = f"kept in {store}: the same call goes on from there" if store else "returned"
        _say(f"interrupted; {done:,} of {self.total:,} {self._units} are done and {kept}")


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()


def _tell_size(job: Job, store: str | Path | None) -> None:
    """Say before the work how large the answer will be, where it is large."""
    size = NUMBER * numbers_of(job) * job.size
    if size >= LARGE:
        where = "of memory" if store is None else f"in {store}"
        _say(
            f"{job.size:,} points in chunks of {job.chunk:,}, whose answer takes "
            f"{in_gigabytes(size)} {where}"
        )


def _size(spans: list[tuple[int, int]], numbers: list[int]) -> int:
    return sum(spans[i][1] - spans[i][0] for i in numbers)


def unanswered(job: Job) -> Answer:
    """Return the answer of a job that has not been begun."""
    arrays = {name: column.empty(job.size) for name, column in job.columns.items()}
    return Answer(arrays, {}, 0, complete=False)


def keep(dataset: Dataset, store: str | Path | None) -> Dataset:
    """Keep a result in its store once it is complete, and return it."""
    if store is not None and dataset.attrs["complete"] and not (Path(store) / RESULT).exists():
        keep_result(store, dataset)
    return dataset


class _Memory:
    """Keeps the answer where there is no store, as a `Store` does."""

    def __init__(self, job: Job, spans: list[tuple[int, int]]) -> None:
        # Filled where nothing has come: to write all of a large answer takes seconds.
        self._arrays = {
            name: np.empty((job.size, *column.tail), dtype=column.dtype)
            for name, column in job.columns.items()
        }
        self._columns = job.columns
        self._spans = spans
        self._left = dict.fromkeys(range(len(spans)))
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

    def read(self) -> Answer:
        reasons = dict(sorted(self._reasons.items()))
        for number in self._left:
            first, last = self._spans[number]
            for name, array in self._arrays.items():
                array[first:last] = self._columns[name].empty(last - first)
        return Answer(self._arrays, reasons, self._n_impacts, complete=not self._left)
