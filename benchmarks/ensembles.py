"""Stores, engines, a cluster's second worker, and the memory of a million starts."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import percuss as pc
from benchmarks.report import Report, installed
from benchmarks.timing import race
from percuss.ensembles.engines import done_chunks
from percuss.ensembles.job import Block, Column, Dimension, chunks_of

OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine("2.5")
TASK, TASKS = 0.5, 16
# The basins of two attractors, of 1000 x 1000 starts.
MILLION = """
import resource, sys, time
import numpy as np
import percuss as pc
osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
pc.basins(osc, pc.cosine("1.5"), x0=[0.0], v0=[0.0], periods=40)
begin = time.perf_counter()
found = pc.basins(osc, pc.cosine("1.5"), x0=np.linspace(-4.0, 1.45, 1000),
                  v0=np.linspace(-4.0, 4.0, 1000), n_workers=int(sys.argv[1]))
print(time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
      int((found.basin >= 0).sum()), found.attrs["n_impacts"])
"""


@dataclass(frozen=True)
class Spinning:
    """A job whose tasks keep a core busy for as long as one of half a second does."""

    tasks: int
    rounds: int

    @property
    def size(self) -> int:
        return self.tasks

    @property
    def chunk(self) -> int:
        return 1

    @property
    def columns(self) -> dict[str, Column]:
        return {"value": Column()}

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        return (Dimension("task", tuple(float(i) for i in range(self.tasks))),)

    def identity(self) -> dict[str, object]:
        return {"kind": "spinning", "over": {}}

    def compute(self, first: int, last: int) -> Block:
        run = pc.simulate(OSC, FORCE, v0=1.0 + 1e-3 * first, max_impacts=self.rounds)
        return Block({"value": np.full(last - first, float(run.impacts.t[-1]))})


def run(report: Report) -> None:
    """Measure what many motions cost beside their impacts."""
    report.section(
        "Many motions: stores and engines",
        "What keeping costs: a sweep of 200 x 200 points of 264 periods, with and without a store. "
        "What handing out costs: 16 tasks of half a second, against calling them one after the "
        "other, on one worker each; and two workers of a local Dask cluster against one.",
    )
    _store(report)
    rounds = _rounds()
    _engines(report, rounds)
    with all_cores():
        if installed("distributed"):
            _cluster(report, rounds)
        _million(report)


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


def _sweep(store: Path | None) -> int:
    found = pc.sweep(
        ["peak_impact_velocity", "impacts_per_period"],
        OSC,
        FORCE,
        over={
            "start.x0": np.linspace(0.0, 2.0, 200),
            "start.v0": np.linspace(-2.0, 2.0, 200),
        },
        store=store,
        n_workers=1,
    )
    assert int(found.attrs["complete"]) == 1
    return int(found.attrs["n_impacts"])


def _store(report: Report) -> None:
    n_impacts = _sweep(None)
    with tempfile.TemporaryDirectory() as folder:
        names = iter(range(100))
        taken = race(
            {
                "without": lambda: _sweep(None),
                "with": lambda: _sweep(Path(folder) / f"{next(names)}.zarr"),
            }
        )
    report.line("a sweep without a store", f"{taken['without']:.3g} s")
    report.line("ns per impact", f"{taken['without'] / n_impacts * 1e9:.0f} ns")
    over = taken["with"] / taken["without"] - 1.0
    report.line("what the store adds", f"{over:.1%}", "<= 5 %", met=over <= 0.05)


def _rounds() -> int:
    """Return how many impacts take half a second here."""
    pc.simulate(OSC, FORCE, v0=1.0, max_impacts=1000)
    rounds = 100_000
    begin = time.perf_counter()
    pc.simulate(OSC, FORCE, v0=1.0, max_impacts=rounds)
    return max(1, int(rounds * TASK / (time.perf_counter() - begin)))


def _do(job: Spinning, engine: object, n_workers: int | None = 1) -> float:
    total = 0.0
    for _, block in done_chunks(job, chunks_of(job), engine, n_workers):
        total += float(block.arrays["value"][0])
    assert math.isfinite(total)
    return total


def _engines(report: Report, rounds: int) -> None:
    job = Spinning(TASKS, rounds)
    direct: Callable[[], object] = lambda: [job.compute(*span) for span in chunks_of(job)]
    taken = race({"direct": direct, "threads": lambda: _do(job, "threads")})
    each = taken["direct"] / TASKS
    report.line("a task, one after the other", f"{each:.3g} s")
    over = taken["threads"] / taken["direct"] - 1.0
    report.line("what threads add to it", f"{over:.1%}", "<= 5 %", met=over <= 0.05)
    # Processes take a second or two to start, which is no part of a task.
    few, many = Spinning(2, rounds), Spinning(2 + TASKS, rounds)
    processes = race({"few": lambda: _do(few, "processes"), "many": lambda: _do(many, "processes")})
    over = (processes["many"] - processes["few"]) / taken["direct"] - 1.0
    report.line("what processes add to it", f"{over:.1%}", "<= 5 %", met=over <= 0.05)


def _cluster(report: Report, rounds: int) -> None:
    import distributed

    job = Spinning(TASKS, rounds)
    taken = {}
    direct: Callable[[], object] = lambda: [job.compute(*span) for span in chunks_of(job)]
    for workers in (1, 2):
        with (
            distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=":0"
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            # Each worker compiles, or loads, its kernels once.
            _do(Spinning(4, 1000), client)
            found = race({"direct": direct, "dask": lambda: _do(job, client)})
            taken[workers] = found["dask"]
            if workers == 1:
                over = found["dask"] / found["direct"] - 1.0
                report.line("what Dask adds to it", f"{over:.1%}", "<= 5 %", met=over <= 0.05)
    report.ratio("one Dask worker : two", taken[1] / taken[2], 1.6)


def _million(report: Report) -> None:
    report.section(
        "A million starts",
        "The basins of two attractors from 1000 x 1000 starts, in a process of its own: "
        "x'' + 0.1 x' + x = cos 1.5 t below a wall at 1.45789, r = 0.7.",
    )
    for workers in (1, 2):
        command = [sys.executable, "-c", MILLION, str(workers)]
        out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        seconds, memory, decided, impacts = (float(part) for part in out.split())
        assert decided == 1e6
        if workers == 1:
            report.line("one thread", f"{seconds:.3g} s")
            report.line("ns per impact", f"{seconds / impacts * 1e9:.0f} ns")
        else:
            report.below("two threads", seconds, 20.0, "s")
        report.below(f"most memory, {workers} of them", memory / 1024.0, 500.0, "MB")
