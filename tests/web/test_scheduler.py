"""Time slices: no client waits for all requests of another."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
import time
from functools import partial
from typing import Any

import pytest
import websockets
from tests.loops import run
from tests.web.frames import read_frame
from tests.web.test_server import fetched

from percuss.web.request import RunningRequest
from percuss.web.scheduler import Scheduler, Task

# Whatever hangs ends here, and fails [s].
LONGEST = 240.0


def test_short_tasks_do_not_wait_for_long_ones() -> None:
    scheduler = Scheduler(1)
    is_over = threading.Event()
    turns = [0] * 10

    def much(task: Task, k: int) -> None:
        while not is_over.is_set() and task.checkpoint():
            time.sleep(0.002)
            turns[k] += 1

    greedy = [scheduler.submit(partial(much, k=k)) for k in range(10)]
    for _ in range(5):
        assert scheduler.submit(lambda _task: "little").result(timeout=LONGEST) == "little"
    assert not any(it.done() for it in greedy)
    # Each gets its part of the time, however slow the machine is.
    end = time.monotonic() + LONGEST
    while min(turns) <= 2 and time.monotonic() < end:
        time.sleep(0.01)
    is_over.set()
    assert min(turns) > 2


def test_one_task_runs_at_a_time_and_each_knows_its_own_time() -> None:
    scheduler = Scheduler(1)
    at_work = []
    most = []

    def work(task: Task) -> float:
        for _ in range(30):
            at_work.append(1)
            most.append(len(at_work))
            time.sleep(0.003)
            at_work.pop()
            task.checkpoint()
        return task.seconds()

    began = time.monotonic()
    seconds = [it.result(timeout=LONGEST) for it in [scheduler.submit(work) for _ in range(5)]]
    assert max(most) == 1
    assert sum(seconds) <= time.monotonic() - began + 0.01


def test_a_task_that_fails_raises_in_its_future_and_frees_its_place() -> None:
    scheduler = Scheduler(1)

    def fail(_task: Task) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        scheduler.submit(fail).result(timeout=LONGEST)
    assert scheduler.submit(lambda _task: 1).result(timeout=LONGEST) == 1


def test_a_closed_scheduler_ends_running_and_waiting_tasks() -> None:
    scheduler = Scheduler(1)
    begun, ended = threading.Event(), threading.Event()

    def endless(task: Task) -> None:
        begun.set()
        running = RunningRequest()
        with running.in_task(task):
            while running.progress(0.0, 1.0)(0.0, 1.0):
                time.sleep(0.001)
        ended.set()

    works = [scheduler.submit(endless) for _ in range(3)]
    assert begun.wait(LONGEST)
    scheduler.close()
    assert all(it.cancelled() for it in works)
    assert ended.wait(LONGEST)
    assert scheduler.submit(lambda _task: 1).cancelled()


def slow(study: dict[str, Any]) -> dict[str, Any]:
    """A motion that takes as long as it may."""
    harmonic = {**study["forcing"]["harmonics"][0], "omega": "1e-12"}
    return {**study, "forcing": {"harmonics": [harmonic]}}


def test_ten_clients_with_endless_motions_do_not_hold_up_a_slider(
    address: str, study: dict[str, Any]
) -> None:
    async def talk() -> list[float]:
        async def hostile() -> None:
            async with websockets.connect(f"ws://{address}/api/socket", max_size=None) as it:
                number = 0
                while True:
                    number += 1
                    text = {"id": number, "kind": "explore", "study": slow(study)}
                    await it.send(json.dumps(text))
                    while True:
                        data = await it.recv()
                        assert isinstance(data, bytes)
                        if read_frame(data)[0]["kind"] != "progress":
                            break

        tasks = [asyncio.create_task(hostile()) for _ in range(10)]
        await asyncio.sleep(1.0)
        delays = []
        async with websockets.connect(f"ws://{address}/api/socket", max_size=None) as it:
            for number in range(8):
                began = time.monotonic()
                await it.send(json.dumps({"id": number, "kind": "explore", "study": study}))
                await it.recv()
                delays.append(time.monotonic() - began)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return delays

    delays = run(talk())
    # One after another they took 10 to 12 s, whatever the machine does besides, for their time is
    # bounded by the clock; a round of slices takes a quarter of a second.
    assert sorted(delays)[len(delays) // 2] < 6.0


def test_a_file_is_cancelled_when_its_client_disconnects(
    address: str, study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from percuss.web import app

    seen: list[RunningRequest] = []

    def endless(_question: object, _extension: str, running: RunningRequest) -> None:
        seen.append(running)
        while running.checkpoint():
            time.sleep(0.005)
        seen.append(running)

    monkeypatch.setattr(app, "file_of", endless)
    body = json.dumps({"kind": "motion", "study": study}).encode()
    head = f"POST /api/file/png HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n"

    async def leave() -> None:
        host, port = address.split(":")
        _, writer = await asyncio.open_connection(host, int(port))
        writer.write(head.encode() + body)
        while not seen:
            await asyncio.sleep(0.01)
        writer.close()
        with contextlib.suppress(ConnectionError):
            await writer.wait_closed()
        while len(seen) < 2:
            await asyncio.sleep(0.01)

    run(leave())
    assert seen[0].is_cancelled


def test_a_client_requests_only_a_few_files_at_once(
    address: str, study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from percuss.web import app

    body = json.dumps({"kind": "motion", "study": study}).encode()
    monkeypatch.setattr(app, "MOST_FILES", 0)
    status, _, said = fetched(address, "/api/file/toml", body)
    assert status == 429
    assert "wait for one" in json.loads(said)["fault"]
    monkeypatch.undo()
    assert fetched(address, "/api/file/toml", body)[0] == 200
