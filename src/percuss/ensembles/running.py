"""Do a job: what is left of it, on an engine, into a store where there is one."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.engines import Engine, done_chunks
from percuss.ensembles.job import Block, Job, chunks_of
from percuss.ensembles.store import Store

__all__ = ["Answer", "Report", "run_job"]

Report = bool | Callable[[float, float], bool] | None

# A line appears only for what takes longer than this [s], and is renewed this often.
PATIENCE = 2.0
RENEWED = 0.2


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of a job.

    Attributes
    ----------
    arrays
        By column, (size, *tail) each; NaN and -1 where it has not been done.
    reasons
        Why points have no answer, by point, in order.
    n_impacts
        How many impacts it took.
    complete
        False where it was stopped before its end.
    """

    arrays: dict[str, NDArray[np.generic]]
    reasons: dict[int, str]
    n_impacts: int
    complete: bool


def run_job(
    job: Job,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
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
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each chunk with numbers of points.

    Returns
    -------
    Answer
        The same bits whatever the engine, the workers and the interruptions.
    """
    spans = chunks_of(job)
    kept = None if store is None else Store(store, job)
    memory = _Memory(job) if kept is None else None
    todo = list(range(len(spans))) if kept is None else kept.todo()
    watch = _Watch(progress, job.size, sum(spans[i][1] - spans[i][0] for i in todo))
    left = len(todo)
    coming = done_chunks(job, [spans[i] for i in todo], engine, n_workers) if todo else iter(())
    try:
        for place, block in coming:
            if kept is not None:
                kept.write(todo[place], block)
            elif memory is not None:
                memory.write(spans[todo[place]], block)
            left -= 1
            first, last = spans[todo[place]]
            if not watch.go_on(last - first, block.n_impacts):
                break
    except KeyboardInterrupt:
        watch.tell_of_interruption(store)
    finally:
        close = getattr(coming, "close", None)
        if close is not None:
            close()
        watch.close()
    if kept is not None:
        return Answer(*kept.read(), complete=left == 0)
    assert memory is not None
    return Answer(memory.arrays, dict(sorted(memory.reasons.items())), memory.n_impacts, left == 0)


class _Memory:
    """The answer where there is no store."""

    def __init__(self, job: Job) -> None:
        self.arrays = {name: column.empty(job.size) for name, column in job.columns.items()}
        self.reasons: dict[int, str] = {}
        self.n_impacts = 0

    def write(self, span: tuple[int, int], block: Block) -> None:
        for name, array in self.arrays.items():
            array[span[0] : span[1]] = block.arrays[name]
        self.reasons |= {span[0] + i: text for i, text in block.reasons.items()}
        self.n_impacts += block.n_impacts


class _Watch:
    """Tells how far a job has come."""

    def __init__(self, report: Report, size: int, todo: int) -> None:
        self._report, self._size, self._before = report, size, size - todo
        self._done = self._impacts = 0
        self._started = self._shown = time.monotonic()
        self._line = False

    def go_on(self, points: int, n_impacts: int) -> bool:
        """Count what is done; False if the caller wants it stopped."""
        self._done += points
        self._impacts += n_impacts
        if self._report is None or self._report is False:
            return True
        if callable(self._report):
            return self._report(self._before + self._done, self._size) is not False
        now = time.monotonic()
        if now - self._started > PATIENCE and now - self._shown > RENEWED:
            self._shown, self._line = now, True
            passed = now - self._started
            left = passed * (self._size - self._before - self._done) / self._done
            share = (self._before + self._done) / self._size
            rate = self._impacts / passed
            sys.stderr.write(
                f"\r{share:6.1%}  {self._before + self._done:,} of {self._size:,} points, "
                f"{rate:,.0f} impacts a second, {_in_words(left)} left "
            )
            sys.stderr.flush()
        return True

    def tell_of_interruption(self, store: str | Path | None) -> None:
        """Say what an interruption has left, to someone who watches."""
        if self._report is True:
            kept = f"the same command goes on with {store}" if store else "nothing was stored"
            sys.stderr.write(f"\ninterrupted; {kept}")
            self._line = True

    def close(self) -> None:
        """End the line, if there is one."""
        if self._line:
            sys.stderr.write("\n")


def _in_words(seconds: float) -> str:
    if seconds < 90.0:
        return f"{math.ceil(seconds)} s"
    minutes = seconds / 60.0
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60.0:.1f} h"
