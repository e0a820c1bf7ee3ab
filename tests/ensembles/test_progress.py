"""What is shown while many motions are followed, and what Ctrl-C leaves."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import percuss as pc
from percuss import progress
from percuss.ensembles.diagram import FollowedBranches
from percuss.ensembles.run_job import ChunkProgress
from percuss.ensembles.threads import UnwantedError, check_going_on
from percuss.progress import Progress, Report

OSC, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return a clock that stands still; add to its only entry."""
    now = [0.0]
    monkeypatch.setattr("percuss.progress.time.monotonic", lambda: now[0])
    return now


class SomeJob:
    """As much of a job as its progress knows."""

    def __init__(self, size: int) -> None:
        self.size = size


def of_chunks(report: Report, size: int, todo: int) -> ChunkProgress:
    return ChunkProgress(report, SomeJob(size), size, todo, lambda: None)  # type: ignore[arg-type]


def test_a_terminal_sees_one_line_with_rate_and_time_left(
    clock: list[float], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "_can_rewrite", lambda: True)
    seen = of_chunks(True, size=1000, todo=800)
    # The first chunk compiles; the rate is that of the others.
    for passed, impacts in ((50.0, 1), (2.0, 3_000_000), (2.0, 5_000_000)):
        clock[0] += passed
        assert seen.chunk_done(100, impacts)
    seen.close()

    lines = capsys.readouterr().err.split("\r")
    assert "30.0%" in lines[1]
    assert "impacts/s" not in lines[1]
    assert "50.0%  500 of 1,000 points, 2 million impacts/s, 10 s left" in lines[3]
    assert lines[3].endswith("\n")


def test_followed_branches_are_reported_as_such(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # All lines are written: while kernels are compiled the first one may come by the clock.
    monkeypatch.setattr(progress, "PATIENCE", -1.0)
    monkeypatch.setattr(progress, "RENEWED_IN_A_LOG", -1.0)

    pc.bifurcation_diagram(OSC, FORCE, over={"forcing.omega": [2.4, 2.45, 2.5]}, points=2,
                           transient=2, progress=True)  # fmt: skip

    lines = capsys.readouterr().err.splitlines()
    assert any("3 of 3 points" in line for line in lines)
    assert any("1 of 2 followed branches of 3 values" in line for line in lines)


def test_a_log_gets_a_line_now_and_then(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    seen = Progress(True, 100, "points")
    for _ in range(80):
        clock[0] += 1.0
        seen.advance()
    seen.close()

    lines = capsys.readouterr().err.splitlines()
    # After two seconds, and every ten from then on.
    assert len(lines) == 8
    assert all("\r" not in line for line in lines)


def test_a_log_gets_lines_before_the_first_chunk_is_done(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    seen = Progress(True, 100, "points")
    for _ in range(30):
        clock[0] += 1.0
        assert seen.tick()
    seen.close()

    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert all("0.0%  0 of 100 points" in line for line in lines)


def test_a_function_is_called_by_the_clock_while_no_chunk_is_done(clock: list[float]) -> None:
    calls: list[tuple[float, float]] = []

    def report(done: float, total: float) -> bool:
        calls.append((done, clock[0]))
        return total > 0 and len(calls) < 3

    seen = Progress(report, 100, done=20)
    wanted = []
    for _ in range(8):
        clock[0] += 0.5
        wanted.append(seen.tick())

    assert calls[:3] == [(20, 1.0), (20, 2.0), (20, 3.0)]
    assert wanted[:6] == [True, True, True, True, True, False]


def napping(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    """Take a minute."""
    time.sleep(60.0)
    return 1.0


@pytest.mark.parametrize("engine", ["threads", "processes", "cluster"])
def test_progress_is_reported_and_obeyed_within_two_seconds_for_chunks_of_any_length(
    engine: str,
) -> None:
    calls: list[float] = []
    over = {"forcing.omega": np.linspace(2.0, 3.0, 64)}

    def stop(done: float, total: float) -> bool:  # noqa: ARG001
        calls.append(time.monotonic())
        return len(calls) < 2

    with contextlib.ExitStack() as stack:
        where: object = engine
        if engine == "cluster":
            distributed = pytest.importorskip("distributed")
            cluster = distributed.LocalCluster(
                n_workers=1, threads_per_worker=1, dashboard_address=":0", processes=True
            )
            stack.enter_context(cluster)
            where = stack.enter_context(distributed.Client(cluster, set_as_default=False))
        began = time.monotonic()
        data = pc.sweep(napping, OSC, FORCE, over=over, engine=where, n_workers=1, progress=stop)
        ended = time.monotonic()

    assert data.attrs["complete"] == 0
    assert len(calls) == 2
    # Each chunk would have taken a quarter of an hour.
    assert calls[0] - began < 60.0
    assert ended - calls[-1] < 60.0


def at_work() -> set[threading.Thread]:
    return {it for it in threading.enumerate() if it.name.startswith("percuss-")}


def test_a_long_chunk_of_compiled_motions_is_given_up_where_it_is() -> None:
    # Threads of others, which wait.
    before = at_work()
    data = pc.sweep(
        "peak_displacement", pc.Oscillator(stops=(pc.SoftStop(0, "below", 4.0),)), FORCE,
        over={"start.v0": np.linspace(1.0, 2.0, 500)}, periods=10**7, max_impacts=10**9,
        n_workers=1, progress=lambda *_: False,
    )  # fmt: skip

    assert data.attrs["complete"] == 0
    until = time.monotonic() + 60.0
    while at_work() - before and time.monotonic() < until:
        time.sleep(0.1)
    # Its thread has ended, though the chunk would have taken hours.
    assert not at_work() - before


def test_long_work_is_announced_once_without_progress(
    clock: list[float], caplog: pytest.LogCaptureFixture
) -> None:
    for report, reported in ((None, 1), (False, 0)):
        seen = of_chunks(report, size=10_000, todo=10_000)
        for _ in range(50):
            clock[0] += 1.0
            seen.chunk_done(1, 10)
        seen.close()
        assert len(caplog.records) == reported
        caplog.clear()
    short = of_chunks(None, size=100, todo=100)
    for _ in range(50):
        clock[0] += 1.0
        short.chunk_done(1, 10)
    assert caplog.records == []


def test_what_is_soon_over_shows_nothing(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    seen = Progress(True, 10)
    clock[0] += 1.0
    seen.advance(10)
    seen.close()

    assert capsys.readouterr().err == ""


def interrupting(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    """Press Ctrl-C at the hundredth point."""
    # A list of its own would count as a part of the function, which is then another one.
    os.environ[CALLS] = str(int(os.environ[CALLS]) + 1)
    if os.environ[CALLS] == "100":
        os.kill(os.getpid(), signal.SIGINT)
    return 1.0


CALLS = "PERCUSS_TEST_CALLS"


@pytest.mark.skipif(os.name != "posix", reason="a process cannot press Ctrl-C for itself")
@pytest.mark.parametrize("stored", [True, False])
def test_ctrl_c_leaves_a_store_that_goes_on_and_says_so(
    stored: bool,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(CALLS, "0")
    store = tmp_path / "a.zarr" if stored else None
    over = {"forcing.omega": np.linspace(1.0, 2.0, 2_000)}

    part = pc.sweep(interrupting, OSC, FORCE, over=over, store=store, n_workers=1)
    done = int(np.isfinite(part.interrupting).sum())
    said = caplog.text

    assert part.attrs["complete"] == 0
    assert f"interrupted; {done:,} of 2,000 points are done" in said
    assert ("goes on from there" in said) == stored
    if stored:
        whole = pc.sweep(interrupting, OSC, FORCE, over=over, store=store)
        assert whole.attrs["complete"] == 1
        # Only what was under way is done twice.
        assert int(os.environ[CALLS]) < 2_000 + 200


@pytest.mark.skipif(os.name != "posix", reason="a process cannot press Ctrl-C for itself")
def test_ctrl_c_gives_up_a_branch_that_is_followed_at_its_next_value(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    visited: list[int] = []

    def step(_self: object, _block: object, _row: int, k: int, begin: object) -> object:
        visited.append(k)
        if k == 2:
            os.kill(os.getpid(), signal.SIGINT)
            until = time.monotonic() + 60.0
            with contextlib.suppress(UnwantedError):
                while time.monotonic() < until:
                    check_going_on()
                    time.sleep(0.001)
        return begin

    monkeypatch.setattr(FollowedBranches, "_step", step)
    over = {"forcing.omega": np.linspace(2.0, 3.0, 50)}
    data = pc.bifurcation_diagram(OSC, FORCE, over=over, follow=["forward"], n_workers=1)

    assert visited == [0, 1, 2]
    assert data.attrs["complete"] == 0
    assert np.isnan(data.x).all()


@pytest.mark.parametrize("what", ["sweep", "diagram"])
def test_ctrl_c_before_the_first_report_leaves_an_answer_without_points(
    what: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("percuss.ensembles.run_job._say_size", interrupted)
    structure = pc.chain([1, 1], [1, 1, 0], "0.1", [pc.Wall("0.5", "above", "0.7", on=1)])
    loads = pc.Loads({0: pc.cosine("0.9")})
    over = {"loads.0.omega": np.linspace(0.8, 1.0, 3)}

    if what == "sweep":
        data = pc.sweep("peak_displacement", structure, loads, over=over, on=0)
        values = data.peak_displacement
    else:
        data = pc.bifurcation_diagram(structure, loads, over=over, on=0, points=8)
        values = data.x

    assert data.attrs["complete"] == 0
    assert values.isnull().all()
    assert "interrupted; 0 of " in caplog.text
    # There are none at work.
    assert "stopping after the chunks" not in caplog.text
