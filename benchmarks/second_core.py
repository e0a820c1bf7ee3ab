"""What a second core brings: motions handed out to threads as ensembles hand them out."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import Report
from benchmarks.timing import race
from percuss.ensembles.batch import Plan, follow_batch
from percuss.ensembles.engines import done_chunks
from percuss.ensembles.job import Block, Column, Dimension, chunks_of
from percuss.kernels.record import STATE_ENTRIES

CHUNKS = 8


@contextlib.contextmanager
def all_cores() -> Iterator[None]:
    """Let this process and those that it starts use every core: the others use one."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


@dataclass(frozen=True)
class MotionsJob:
    """Motions as a job."""

    laws: NDArray[np.float64]
    which: NDArray[np.int64]
    starts: NDArray[np.float64]
    plan: Plan

    @property
    def size(self) -> int:
        return len(self.which)

    @property
    def chunk(self) -> int:
        return -(-self.size // CHUNKS)

    @property
    def columns(self) -> dict[str, Column]:
        return {"state": Column((STATE_ENTRIES,))}

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        return (Dimension("motion", tuple(float(i) for i in range(self.size))),)

    def identity(self) -> dict[str, object]:
        return {"kind": "motions", "over": {}}

    def compute(self, first: int, last: int) -> Block:
        part, plan = slice(first, last), self.plan
        cut = replace(plan, since=plan.since[part], every=plan.every[part], until=plan.until[part])
        motions = follow_batch(self.laws, self.which[part], self.starts[part], cut)
        return Block({"state": motions.state}, n_impacts=int(motions.n_impacts.sum()))


def run(report: Report, job: MotionsJob) -> None:
    """Add a line on two threads against one, whose last bits are the same."""
    if (os.cpu_count() or 1) < 2:
        return
    last: dict[int, NDArray[Any]] = {}

    def follow(n_workers: int) -> None:
        states: dict[int, NDArray[Any]] = {}
        for place, block in done_chunks(job, chunks_of(job), "threads", n_workers):
            states[place] = block.arrays["state"]
        last[n_workers] = np.concatenate([states[place] for place in sorted(states)])

    with all_cores():
        taken = race({"one": lambda: follow(1), "two": lambda: follow(2)})
    np.testing.assert_array_equal(last[1], last[2])
    report.ratio("one thread : two", taken["one"] / taken["two"], 1.7)
