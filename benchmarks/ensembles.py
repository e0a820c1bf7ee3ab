"""Stores, engines, a cluster's second worker, and the memory of a million starts."""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from tests.ensembles.studies import exponents

import percuss as pc
from benchmarks.report import Report, installed
from benchmarks.second_core import all_cores
from benchmarks.timing import race
from percuss.ensembles.batch import Plan, follow_batch
from percuss.ensembles.engines import done_chunks
from percuss.ensembles.job import Block, Column, Dimension, chunks_of
from percuss.model.system import law

OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine("2.5")
# Seconds of a task, how many there are, and the motions that each follows.
TASK, TASKS, LANES = 0.5, 16, 64
# Values along each axis of the chart whose store is timed, and how often it is made each way.
CHART, TURNS = 400, 2
# The basins of two attractors, of 1000 x 1000 starts. The most memory is that of the program alone:
# what getrusage tells includes the process that has started it.
MILLION = """
import sys, time
import numpy as np
import percuss as pc
osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
pc.basins(osc, pc.cosine("1.5"), x0=[0.0], v0=[0.0], periods=40)
begin = time.perf_counter()
found = pc.basins(osc, pc.cosine("1.5"), x0=np.linspace(-4.0, 1.45, 1000),
                  v0=np.linspace(-4.0, 4.0, 1000), n_workers=int(sys.argv[1]))
taken = time.perf_counter() - begin
try:
    lines = open("/proc/self/status").read().splitlines()
    most = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
except OSError:
    import resource
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(taken, most, int((found.basin >= 0).sum()), found.attrs["n_impacts"])
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
        """Follow motions for so many impacts each, as tasks of ensembles do."""
        still = np.zeros(LANES)
        plan = Plan(still, still + 1.0, still + math.inf, max_impacts=self.rounds)
        speeds = 1.0 + 1e-3 * (first + np.arange(LANES) / LANES)
        starts = np.stack([still, speeds, still], axis=1)
        which = np.zeros(LANES, dtype=np.int64)
        motions = follow_batch(law(OSC, FORCE)[np.newaxis], which, starts, plan)
        return Block({"value": np.full(last - first, motions.state.sum())})


def run(report: Report) -> None:
    """Measure what many motions cost beside their impacts."""
    report.section(
        "Many motions: stores and engines",
        "What keeping costs: a chart of the largest exponent over 400 x 400 points, and a sweep of "
        "200 x 200 starts over 264 periods, with and without a store. What handing out costs: 16 "
        "tasks of half a second, against calling them one after the other, on one worker each; "
        "and two workers of a local Dask cluster against one.",
    )
    _chart_and_store(report)
    _sweep_and_store(report)
    rounds = _rounds()
    _engines(report, rounds)
    with all_cores():
        if installed("distributed"):
            _cluster(report, rounds)
        _million(report)


def _chart(store: Path | None, size: int = CHART) -> xr.Dataset:
    chart: xr.Dataset = exponents(store, size, n_workers=1)
    return chart


def _chart_and_store(report: Report) -> None:
    without, with_store = [], []
    with tempfile.TemporaryDirectory() as folder:
        _chart(Path(folder) / "small.zarr", 20)
        for turn in range(TURNS):
            begin = time.perf_counter()
            expected = _chart(None)
            between = time.perf_counter()
            found = _chart(Path(folder) / f"{turn}.zarr")
            with_store.append(time.perf_counter() - between)
            without.append(between - begin)
            assert found.identical(expected)
            assert pc.load_store(Path(folder) / f"{turn}.zarr").identical(expected)
    report.line("a chart of 400 x 400 without a store", f"{min(without):.3g} s")
    over = min(with_store) / min(without) - 1.0
    report.line("what the store adds to the chart", f"{over:.1%}", "<= 5 %", met=over <= 0.05)


def _sweep(store: Path | None) -> int:
    data = pc.sweep(
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
    assert int(data.attrs["complete"]) == 1
    return int(data.attrs["n_impacts"])


def _sweep_and_store(report: Report) -> None:
    n_impacts = _sweep(None)
    with tempfile.TemporaryDirectory() as folder:
        names = iter(range(100))
        taken = race(
            {
                "without": lambda: _sweep(None),
                "with": lambda: _sweep(Path(folder) / f"{next(names)}.zarr"),
            }
        )
    report.line("a sweep of 200 x 200 without a store", f"{taken['without']:.3g} s")
    report.line("ns per impact", f"{taken['without'] / n_impacts * 1e9:.0f} ns")
    over = taken["with"] / taken["without"] - 1.0
    report.line("what the store adds to the sweep", f"{over:.1%}", "<= 5 %", met=over <= 0.05)


def _rounds() -> int:
    """Return how many impacts of each motion take half a second here."""

    def seconds(rounds: int) -> float:
        taken = []
        for _ in range(5):
            begin = time.perf_counter()
            Spinning(1, rounds).compute(0, 1)
            taken.append(time.perf_counter() - begin)
        return statistics.median(taken)

    rounds = 1000
    seconds(rounds)
    # The first guess is of a short task, whose beginning counts; the next is right.
    for _ in range(2):
        rounds = max(1, round(rounds * TASK / seconds(rounds)))
    return rounds


def _do(job: Spinning, engine: object, n_workers: int | None = 1) -> list[float]:
    """Return the value of each task."""
    found = [math.nan] * job.tasks
    for place, block in done_chunks(job, chunks_of(job), engine, n_workers):
        found[place] = float(block.arrays["value"][0])
    return found


def _in_turn(job: Spinning) -> list[float]:
    return [float(job.compute(*span).arrays["value"][0]) for span in chunks_of(job)]


def _engines(report: Report, rounds: int) -> None:
    job = Spinning(TASKS, rounds)
    assert _do(job, "threads") == _in_turn(job)
    direct: Callable[[], object] = lambda: _in_turn(job)
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
    direct: Callable[[], object] = lambda: _in_turn(job)
    for workers in (1, 2):
        with (
            distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=":0"
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            # Each worker compiles, or loads, its kernels once.
            _do(Spinning(4, 1000), client)
            assert _do(job, client) == _in_turn(job)
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
    threads = {}
    for workers in (1, 2):
        command = [sys.executable, "-c", MILLION, str(workers)]
        out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        seconds, memory, decided, impacts = (float(part) for part in out.split())
        assert decided == 1e6
        threads[workers] = seconds
        if workers == 1:
            report.line("one thread", f"{seconds:.3g} s")
            report.line("ns per impact", f"{seconds / impacts * 1e9:.0f} ns")
        else:
            report.below("two threads", seconds, 20.0, "s")
            report.ratio("one thread : two", threads[1] / threads[2], 1.7)
        report.below(f"most memory, {workers} of them", memory / 1024.0, 500.0, "MB")
